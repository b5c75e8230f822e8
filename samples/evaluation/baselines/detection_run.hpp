// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// How often the detectors of the baselines find the parts (paper, Fig. 3 a and b).

#ifndef OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_DETECTION_RUN_HPP
#define OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_DETECTION_RUN_HPP

#include "../detection.hpp"
#include "detectors.hpp"

namespace evaluation {

//! Front pin, logo and rear pin, the paper's three.
inline std::vector<String> defaultParts()
{
    static const char* const names[] = { "logo_pivot", "logo_s", "shaft_pivot" };
    return std::vector<String>(names, names + 3);
}

/** The images that DetectionRun looks at, and its windows of the variant `raw`; detectors that are fast enough look at whole images too. A
class is found where a candidate is near any of its visible keypoints. */
class BaselineDetectionRun
{
public:
    BaselineDetectionRun(const Data& data, PartDetector& detector) : data_(data), detector_(detector), parts_(data)
    {
        pixel_ = parts_.finder().pixelScale();
        detection_.detector = detector.name();
        for (size_t i = 0; i < detector.classes().size(); i++)
            detection_.at(0, detector.classes()[i]);
    }

    //! @param frames at most so many; 0 = all. Of a long sequence every k-th is looked at
    const Detection& run(int frames, bool quiet)
    {
        common::FrameReader reader(*data_.sequence, 0);
        const int count = frames > 0 ? std::min(frames, reader.count()) : reader.count(), step = 1 + (std::max(count, 1) - 1) / 300;
        common::Progress progress(count, quiet);
        Mat image;
        for (int frame = 0; (frames == 0 || frame < frames) && reader.read(image); frame++)
        {
            if (frame % step || !parts_.read(frame))
                continue;
            PartFinder& finder = parts_.finder();
            finder.setImage(image);
            detector_.setImage(finder.pixels(Rect(Point(), finder.camera().imageSize())));
            finder.release();
            data_.joints(frame, joints_);
            look();
            progress.show(frame + 1);
        }
        return detection_;
    }

private:
    void look()
    {
        std::vector<std::vector<Point2d> > all(detector_.classCount());
        for (int tool = 0; tool < (int)data_.tools.size(); tool++)
        {
            const std::vector<ToolModel::Keypoint>& keypoints = data_.tools[tool].model->keypoints();
            const std::map<int, Point2d> visible = parts_.visible(tool);
            for (int cls = 1; cls < detector_.classCount(); cls++)
            {
                std::vector<Point2d> points;
                for (std::map<int, Point2d>::const_iterator it = visible.begin(); it != visible.end(); ++it)
                    if (className(keypoints[it->first].name) == detector_.classes()[cls - 1])
                        points.push_back(it->second);
                all[cls].insert(all[cls].end(), points.begin(), points.end());
                const Point2d expected = expectedPoint(tool, detector_.classes()[cls - 1]);
                const int half = cvRound(120 * pixel_);
                if (!points.empty())
                    count(0, cls, Rect(cvRound(expected.x) - half, cvRound(expected.y) - half, 2 * half + 1, 2 * half + 1), points, &expected);
            }
        }
        for (int cls = 1; cls < detector_.classCount() && detector_.wholeImage(); cls++)
            if (!all[cls].empty())
                count(2, cls, Rect(), all[cls], 0);
    }
    //! Where the recorded kinematics has a class: the side nearer to the camera.
    Point2d expectedPoint(int tool, const String& cls) const
    {
        const ToolModel& model = *data_.tools[tool].model;
        Mat basePoints;
        model.keypointPositions(joints_[tool], basePoints);
        Point3d best(0, 0, DBL_MAX);
        for (int i = 0; i < basePoints.rows; i++)
        {
            const double* const b = basePoints.ptr<double>(i);
            const Vec4d p = data_.tools[tool].info.nominal_T_base * Vec4d(b[0], b[1], b[2], 1);
            if (className(model.keypoints()[i].name) == cls && p[2] > 1e-3 && p[2] < best.z)
                best = Point3d(p[0], p[1], p[2]);
        }
        return best.z < DBL_MAX ? const_cast<TrueParts&>(parts_).finder().camera().project(best) : Point2d();
    }
    void count(int variant, int cls, const Rect& window, const std::vector<Point2d>& points, const Point2d* expected)
    {
        DetectionCount& count = detection_.at(variant, detector_.classes()[cls - 1]);
        std::vector<PartMatch> matches;
        std::vector<double> distances;
        detector_.detect(window, cls, MAX_TOP_N, matches);
        for (size_t i = 0; i < matches.size(); i++)
            distances.push_back(nearestOf(points, matches[i].imagePoint) / pixel_);
        count.visible++;
        count.prior += expected ? nearestOf(points, *expected) / pixel_ : 0;
        count.addSample(distances);
    }

    const Data& data_;
    PartDetector& detector_;
    TrueParts parts_;
    double pixel_;
    std::vector<std::vector<double> > joints_;
    Detection detection_;
};

} // namespace evaluation

#endif
