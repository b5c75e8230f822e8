// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// The public stages, run once more on one tool in one frame, from the tracker's estimates: what debug_pictures.hpp draws.

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
    Matx44d expected_camera_T_base, found_camera_T_base;   // before and after the frame
    std::vector<double> expectedJoints, foundJoints;       // readings and the offsets known then
    bool known;                                            // whether it was followed before
};

class DebugStages
{
public:
    /** @param camera of the images
    @param method of the tracker, see TrackingMethod */
    DebugStages(const CameraModel& camera, int method)
        : reduction_(std::max(1, camera.imageSize().width / 720)), scale_(camera.imageSize().width / reduction_ / 720.), zoom_(1)
    {
        camera_ = part(camera, Rect(0, 0, camera.imageSize().width / reduction_ * reduction_, camera.imageSize().height / reduction_ * reduction_), 1. / reduction_);
        context_.zoneRadius *= scale_;
        if (method != METHOD_FULL)   // as the tracker does
        {
            context_.centredZones = false;
            context_.maxScale = context_.maxRotation = 0;
        }
        drawing_.wholeTool = true;
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

    Mat zoomed(const Mat& image, int interpolation) const
    {
        Mat result;
        resize(image(crop_), result, Size(), zoom_, zoom_, interpolation);
        return result;
    }

    //! Begins a frame.
    void setImage(const Mat& image, const std::vector<DebugTool>& tools)
    {
        if (!templates_)
        {
            templates_ = PartTemplateRenderer::create(renderer_, drawing_);
            for (size_t i = 0; i < tools.size(); i++)
                templates_->addTool(tools[i].model);
        }
        resize(image, image_, camera_.imageSize(), 0, 0, INTER_AREA);
    }

    //! The stages up to the inliers. Returns whether there is a part to look at.
    bool look(const std::vector<DebugTool>& tools, int index)
    {
        const DebugTool& tool = tools[index];
        std::vector<ToolView> views(tools.size());
        for (size_t i = 0; i < tools.size(); i++)
        {
            views[i].camera_T_base = tools[i].expected_camera_T_base;
            tools[i].model->forwardKinematics(tools[i].expectedJoints, views[i].base_T_link);
        }
        templates_->render(camera_, views, index, parts_);
        if (parts_.empty())
            return false;
        const ToolTracker::Params tracker;
        windows_.clear();
        Rect box;
        for (size_t i = 0; i < parts_.size(); i++)
        {
            const PartTemplate& t = parts_[i];
            const int half = cvRound(tool.known ? tracker.minWindow * scale_ : tracker.initialWindow * std::max(camera_.fx, camera_.fy) / t.viewPoint.z);
            windows_.push_back(Rect(t.anchor.x - half, t.anchor.y - half, 2 * half + 1, 2 * half + 1) & Rect(Point(), camera_.imageSize()));
            box = box.empty() ? windows_[i] : box | windows_[i];
        }
        matcher_->setImage(image_);
        matcher_->match(parts_, windows_, matches_);
        const Ptr<GeometricContextVerifier> verifier = GeometricContextVerifier::create(context_);
        verifier->verify(matches_, inliers_);
        sample_ = verifier->sample();

        // The parts' surroundings, of the image's shape, so that all pictures are of one size.
        const Size all = camera_.imageSize();
        const double share = std::min(1., std::max(double(box.width) / all.width, double(box.height) / all.height));
        const Size size(std::max(8, cvFloor(share * all.width)), std::max(8, cvFloor(share * all.height)));
        const Point at(box.x + box.width / 2 - size.width / 2, box.y + box.height / 2 - size.height / 2);
        crop_ = Rect(Point(std::min(std::max(at.x, 0), all.width - size.width), std::min(std::max(at.y, 0), all.height - size.height)), size);
        zoom_ = std::max(1, cvRound(double(WIDTH) / size.width));
        view_ = part(camera_, crop_, zoom_);
        return true;
    }

    //! The edges about the outline where the tool was found, in zoomed points. Returns how many are within 1.5 pixels.
    int findOutline(const std::vector<DebugTool>& tools, int index, std::vector<ContourPoint>& points)
    {
        std::vector<ToolView> views(tools.size());
        for (size_t i = 0; i < tools.size(); i++)
        {
            views[i].camera_T_base = tools[i].found_camera_T_base;
            tools[i].model->forwardKinematics(tools[i].foundJoints, views[i].base_T_link);
        }
        std::vector<PartTemplate> parts;
        templates_->render(camera_, views, index, parts);
        ToolContour::create(tools[index].model)->sample(camera_, views[index], templates_->rendering(), index + 1, points);
        ContourSearch search;   // that of ToolEstimate::contourSupport
        search.halfWindow = std::min(40., std::max(2., 6 * scale_));
        search.preference = 0;
        search.ambiguity = 1;
        matchContour(image_, points, search);
        int supported = 0;
        for (size_t i = 0; i < points.size(); i++)
        {
            supported += points[i].found && std::abs(points[i].offset) < 1.5 * scale_;
            points[i].imagePoint = zoomed(points[i].imagePoint);
        }
        return supported;
    }

    int reduction_;       // of the images, as in the tracker
    double scale_;        // of thresholds given for images 720 pixels wide
    CameraModel camera_;  // of the reduced image
    GeometricContextVerifier::Params context_;
    PartTemplateRenderer::Params drawing_;
    Ptr<MeshRenderer> renderer_;
    Ptr<PartTemplateRenderer> templates_;
    Ptr<QGOMatcher> matcher_;

    // of one tool in one frame
    Mat image_;
    std::vector<PartTemplate> parts_;
    std::vector<Rect> windows_;
    std::vector<PartMatch> matches_, inliers_, sample_;
    Rect crop_;           // what the pictures show,
    int zoom_;            // so much larger
    CameraModel view_;    // of the pictures
};

} // namespace common

#endif
