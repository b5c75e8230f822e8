// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// What the tracker saw of one tool in one frame, brought to the size of the pictures that debug_pictures.hpp draws.

#ifndef OPENCV_SURGTRACK_SAMPLES_SUPPORT_DEBUG_STAGES_HPP
#define OPENCV_SURGTRACK_SAMPLES_SUPPORT_DEBUG_STAGES_HPP

#include "opencv2/imgproc.hpp"
#include "opencv2/surgtrack.hpp"

namespace common {

using namespace cv;
using namespace cv::surgtrack;

//! One tool in one frame.
struct DebugTool
{
    String name;
    Ptr<ToolModel> model;
    ToolSight sight;                     // of the left eye
    std::vector<double> foundJoints;     // of the pose found
    Matx44d found_camera_T_base;
};

class DebugStages
{
public:
    //! @param method of the tracker, see TrackingMethod
    explicit DebugStages(int method) : scale_(1), zoom_(1)
    {
        if (method != METHOD_FULL)   // as the tracker does
        {
            context_.centredZones = false;
            context_.maxScale = context_.maxRotation = 0;
        }
        matcher_ = QGOMatcher::create();
        renderer_ = MeshRenderer::createSoftware();
    }

protected:
    enum { WIDTH = 720 };   // of a picture, about

    //! What a part of the image, so much larger or smaller, is the image of.
    static CameraModel part(const CameraModel& camera, const Rect& crop, double zoom)
    {
        const Matx33d K(camera.fx * zoom, 0, (camera.cx - crop.x + 0.5) * zoom - 0.5, 0, camera.fy * zoom, (camera.cy - crop.y + 0.5) * zoom - 0.5, 0, 0, 1);
        return CameraModel(K, camera.distCoeffs(), Size(cvRound(crop.width * zoom), cvRound(crop.height * zoom)));
    }

    Point2d zoomed(const Point2d& p) const { return Point2d((p.x - crop_.x + 0.5) * zoom_ - 0.5, (p.y - crop_.y + 0.5) * zoom_ - 0.5); }

    std::vector<PartMatch> zoomed(std::vector<PartMatch> matches) const
    {
        for (size_t i = 0; i < matches.size(); i++)
        {
            matches[i].imagePoint = zoomed(matches[i].imagePoint);
            matches[i].predictedPoint = zoomed(matches[i].predictedPoint);
        }
        return matches;
    }

    std::vector<ContourPoint> zoomed(std::vector<ContourPoint> points) const
    {
        for (size_t i = 0; i < points.size(); i++)
            points[i].imagePoint = zoomed(points[i].imagePoint);
        return points;
    }

    Mat zoomed(const Mat& image, int interpolation) const
    {
        Mat result;
        resize(image(crop_), result, Size(), zoom_, zoom_, interpolation);
        return result;
    }

    //! The drawing that the templates were cut from: lit as they were, on grey. covered: where a tool is
    Mat lit(Mat* covered = 0) const
    {
        const Rendering& r = sight_.rendering;
        Mat picture(sight_.camera.imageSize(), CV_8UC3, Scalar::all(80)), shading, ids = Mat::zeros(picture.size(), CV_8UC1);
        r.shading.convertTo(shading, CV_8U, 0.85, 0.15 * 255);
        cvtColor(shading, shading, COLOR_GRAY2BGR);
        shading.copyTo(picture(r.window), r.ids);
        r.ids.copyTo(ids(r.window));
        if (covered)
            *covered = ids;
        return picture;
    }

    //! Begins a picture of a tool. Returns whether there is a part to look at.
    bool look(const Mat& image, const DebugTool& tool)
    {
        sight_ = tool.sight;
        if (sight_.templates.empty())
            return false;
        const Size all = sight_.camera.imageSize();
        scale_ = all.width / 720.;
        resize(image, image_, all, 0, 0, INTER_AREA);
        Mat matched = image_;
        if (sight_.enlargement > 1)   // of a small tool
            resize(image_, matched, all * sight_.enlargement, 0, 0, INTER_LINEAR);
        matcher_->setImage(matched);
        Rect box;
        for (size_t i = 0; i < sight_.found.windows.size(); i++)
            box = box.empty() ? sight_.found.windows[i] : box | sight_.found.windows[i];
        // The parts' surroundings, of the image's shape, so that all pictures are of one size.
        const double share = std::min(1., std::max(double(box.width) / all.width, double(box.height) / all.height));
        const Size size(std::max(8, cvFloor(share * all.width)), std::max(8, cvFloor(share * all.height)));
        const Point at(box.x + box.width / 2 - size.width / 2, box.y + box.height / 2 - size.height / 2);
        crop_ = Rect(Point(std::min(std::max(at.x, 0), all.width - size.width), std::min(std::max(at.y, 0), all.height - size.height)), size);
        zoom_ = std::max(1, cvRound(double(WIDTH) / size.width));
        view_ = part(sight_.camera, crop_, zoom_);
        return true;
    }

    GeometricContextVerifier::Params context_;   // of the tracker, but for its scale
    Ptr<MeshRenderer> renderer_;
    Ptr<QGOMatcher> matcher_;

    // of one tool in one frame
    ToolSight sight_;
    double scale_;        // of thresholds given for images 720 pixels wide
    Mat image_;           // reduced as the tracker does
    Rect crop_;           // what the pictures show,
    int zoom_;            // so much larger
    CameraModel view_;    // of the pictures
};

} // namespace common

#endif
