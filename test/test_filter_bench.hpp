// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_TEST_FILTER_BENCH_HPP
#define OPENCV_SURGTRACK_TEST_FILTER_BENCH_HPP

#include "test_common.hpp"

namespace opencv_test { namespace {

const double DEGREE = CV_PI / 180;
const Matx44d SAME_EYE = Matx44d::eye();

inline Matx44d rightEye()
{
    return rigid(rotationMatrix(Vec3d(0.01, -0.03, 0.005)), Point3d(-0.0052, 0.0003, 0.0001));
}

// Small motion about a centre, as the filter's error state has it: Trans(c + v) Exp(omega) Trans(-c).
inline Matx44d motionAbout(const Point3d& c, const Vec3d& omega, const Vec3d& v)
{
    const Matx33d R = rotationMatrix(omega);
    return rigid(R, c + Point3d(v) - R * c);
}

// Tool and readings, and the truth: the camera sees `tool`, the filter is told of a wrong hand-eye calibration and wrong readings.
struct Bench
{
    explicit Bench(const PosedTool& _tool, const Matx44d& _correction = Matx44d::eye(), const std::vector<double>& _offsets = std::vector<double>())
        : tool(_tool), correction(_correction), offsets(_offsets)
    {
        offsets.resize(tool.joints.size(), 0.);
        nominal_T_base = correction.inv() * tool.view.camera_T_base;
        for (size_t i = 0; i < tool.model->keypoints().size(); i++) parts.push_back(int(i));
    }

    std::vector<double> readings() const
    {
        std::vector<double> result = tool.joints;
        for (size_t i = 0; i < result.size(); i++) result[i] -= offsets[i];
        return result;
    }

    // The arm moves; its base stays.
    void move(const std::vector<double>& joints)
    {
        tool.joints = joints;
        tool.model->forwardKinematics(joints, tool.view.base_T_link);
    }

    Point3d keypoint(const ToolView& view, int part) const
    {
        const ToolModel::Keypoint& k = tool.model->keypoints()[part];
        return transformed(view.camera_T_base * view.base_T_link[k.link], k.linkPoint);
    }

    Point3d centre(const ToolView& view) const
    {
        Point3d sum;
        for (int part : parts) sum += keypoint(view, part) * (1. / parts.size());
        return sum;
    }

    Matx44d toolPose(const ToolView& view) const { return view.camera_T_base * tool.model->endEffectorFromLinks(view.base_T_link); }

    std::vector<Point2d> seen(const CameraModel& camera, const Matx44d& eye_T_camera = SAME_EYE, double noise = 0, RNG* rng = 0) const
    {
        std::vector<Point2d> result;
        for (int part : parts)
        {
            Point2d p = camera.project(transformed(eye_T_camera, tool.keypoint(part)));
            if (noise > 0) p += Point2d(rng->gaussian(noise), rng->gaussian(noise));
            result.push_back(p);
        }
        return result;
    }

    Ptr<ArticulatedPoseEKF> filter(const ArticulatedPoseEKF::Params& params = ArticulatedPoseEKF::Params()) const
    {
        return ArticulatedPoseEKF::create(tool.model, nominal_T_base, params);
    }

    PosedTool tool;
    Matx44d correction, nominal_T_base;
    std::vector<double> offsets;
    std::vector<int> parts;
};

// Takes in the points of some parts, so many times about the state found before.
inline bool correct(ArticulatedPoseEKF& filter, const CameraModel& camera, const std::vector<int>& parts, const std::vector<Point2d>& points, int iterations = 1)
{
    std::vector<uchar> used;
    for (int i = 0; i < iterations; i++)
    {
        filter.begin();
        filter.addPoints(camera, SAME_EYE, parts, points, used);
        if (!filter.solve()) return false;
    }
    return true;
}

inline std::vector<double> joints(const PosedTool& tool, double q4, double q5, double q6, double jaw)
{
    PosedTool moved = tool;
    moved.set("q4", q4);
    moved.set("q5", q5);
    moved.set("q6", q6);
    moved.set("jaw", jaw);
    return moved.joints;
}

}} // namespace

#endif
