// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Are numbers in metres and radians?

#ifndef OPENCV_SURGTRACK_SAMPLES_SUPPORT_UNITS_HPP
#define OPENCV_SURGTRACK_SAMPLES_SUPPORT_UNITS_HPP

#include "opencv2/surgtrack.hpp"

namespace common {

//! What is wrong with joint readings, N x C, that no instrument can have: in one line; empty: nothing
inline std::string unitFault(const cv::surgtrack::ToolModel& model, const cv::Mat& joints)
{
    using cv::surgtrack::ToolModel;
    const std::vector<ToolModel::Link> links = model.links();
    for (size_t i = 0; i < links.size(); i++)
    {
        const int c = links[i].coordinate;
        if (links[i].jointType == ToolModel::JOINT_FIXED || c < 0 || c >= joints.cols)
            continue;
        double low, high;
        cv::minMaxIdx(joints.col(c), &low, &high);
        const double most = std::max(-low, high) * std::abs(links[i].scale);
        const bool slides = links[i].jointType == ToolModel::JOINT_PRISMATIC;
        if (most > (slides ? 1 : 4 * CV_PI))
            return cv::format("coordinate %s goes to %g: %s", model.coordinateNames()[c].c_str(), std::max(-low, high),
                              slides ? "no instrument slides more than 1 m, expected metres, not millimetres"
                                     : "more than two turns, expected radians, not degrees");
    }
    return std::string();
}

/** Which coordinate is read far outside of its joint's limits, in one line; empty: none. Offsets of a worn cable, and jaws that are pressed together,
stay within the slack. */
inline std::string limitFault(const cv::surgtrack::ToolModel& model, const cv::Mat& joints)
{
    using cv::surgtrack::ToolModel;
    const cv::Mat_<double> limits = model.jointLimits();
    for (int c = 0; c < limits.rows && c < joints.cols; c++)
    {
        bool slides = true;
        for (size_t i = 0; i < model.links().size(); i++)
            slides = slides && (model.links()[i].coordinate != c || model.links()[i].jointType == ToolModel::JOINT_PRISMATIC);
        const double slack = slides ? 0.02 : 0.4;   // [m, rad]
        double low, high;
        cv::minMaxIdx(joints.col(c), &low, &high);
        if (low < limits(c, 0) - slack || high > limits(c, 1) + slack)
            return cv::format("coordinate %s is read from %.4g to %.4g, its joint goes from %.4g to %.4g: is it the joint's column, and has it the same zero and sign?",
                              model.coordinateNames()[c].c_str(), low, high, limits(c, 0), limits(c, 1));
    }
    return std::string();
}

} // namespace common

#endif
