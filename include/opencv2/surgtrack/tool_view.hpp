// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_TOOL_VIEW_HPP
#define OPENCV_SURGTRACK_TOOL_VIEW_HPP

#include <vector>
#include "opencv2/core.hpp"

namespace cv { namespace surgtrack {

//! @addtogroup surgtrack
//! @{

/** @brief Where a tool is in one frame: what drawing it takes. */
struct CV_EXPORTS_W_SIMPLE ToolView
{
    CV_WRAP ToolView();

    /** @param camera_T_base camera_T_nominal * nominal_T_base
    @param base_T_link one per link, ToolModel::forwardKinematics() or ToolModel::linkPoses() */
    CV_WRAP ToolView(const Matx44d& camera_T_base, const std::vector<Matx44d>& base_T_link);

    CV_PROP_RW Matx44d camera_T_base;       //!< camera_T_nominal * nominal_T_base
    std::vector<Matx44d> base_T_link;       //!< ToolModel::forwardKinematics()

    /** @brief base_T_link as an array, L x 4 x 4 CV_64F. */
    CV_WRAP Mat linkPoses() const;
};

//! @}

}} // namespace cv::surgtrack

#endif
