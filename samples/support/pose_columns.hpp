// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// The further columns of a poses file.

#ifndef OPENCV_SURGTRACK_SAMPLES_SUPPORT_POSE_COLUMNS_HPP
#define OPENCV_SURGTRACK_SAMPLES_SUPPORT_POSE_COLUMNS_HPP

#include <limits>
#include "opencv2/surgtrack.hpp"

namespace common {

//! Their names; joint offsets are those of the first tool.
inline std::vector<cv::String> poseColumns(const cv::surgtrack::ToolModel& first)
{
    const char* const names[] = { "visible", "inliers", "similarity", "contour", "nis", "sd_rx", "sd_ry", "sd_rz", "sd_tx", "sd_ty", "sd_tz" };
    std::vector<cv::String> result(names, names + 11);
    const std::vector<cv::String> coordinates = first.coordinateNames();
    for (size_t i = 0; i < coordinates.size(); i++)
        result.push_back("offset_" + coordinates[i]);
    return result;
}

//! Their values for a tool; those there is none of are not finite: the file leaves them empty.
inline std::vector<double> poseRow(const cv::surgtrack::ToolModel& first, const cv::surgtrack::ToolModel& tool,
                                   const cv::surgtrack::ToolEstimate& estimate)
{
    const double nothing = std::numeric_limits<double>::quiet_NaN();
    const double values[] = { (double)estimate.visibleParts, (double)estimate.inliers, estimate.similarity, estimate.contourSupport, estimate.nis };
    std::vector<double> result(values, values + 5);
    for (int i = 0; i < 6; i++)
        result.push_back(estimate.covariance(i, i) > 0 ? std::sqrt(estimate.covariance(i, i)) : nothing);
    const std::vector<cv::String> coordinates = first.coordinateNames();
    for (size_t i = 0; i < coordinates.size(); i++)
    {
        const int k = tool.coordinateIndex(coordinates[i]);
        result.push_back(k >= 0 && k < (int)estimate.jointOffsets.size() ? estimate.jointOffsets[k] : nothing);
    }
    return result;
}

//! The readings with the offsets that were found; those of METHOD_PAPER and METHOD_EPNP are 0.
inline std::vector<double> corrected(std::vector<double> joints, const cv::surgtrack::ToolEstimate& estimate)
{
    for (size_t i = 0; i < estimate.jointOffsets.size(); i++)
        joints[i] += estimate.jointOffsets[i];
    return joints;
}

} // namespace common

#endif
