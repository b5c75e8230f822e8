// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_TRACKING_STATE_HPP
#define OPENCV_SURGTRACK_TRACKING_STATE_HPP

#include "opencv2/core.hpp"

namespace cv { namespace surgtrack {

//! @addtogroup surgtrack
//! @{

//! What an estimate is worth.
enum TrackingState
{
    STATE_INITIALIZING = 0,   //!< no confirmed pose yet: that of the kinematics, or a first measurement
    STATE_TRACKING = 1,       //!< the pose was measured in this frame
    STATE_COASTING = 2,       //!< nothing was measured for a short while: kinematics with the last correction; or, with METHOD_FULL, the tool was found elsewhere, which further frames are to confirm
    STATE_LOST = 3            //!< the pose must not be used
};

/** @brief `initializing`, `tracking`, `coasting` or `lost`, as poses files have it. @param state see cv::surgtrack::TrackingState */
CV_EXPORTS_W String stateName(int state);

//! @}

}} // namespace cv::surgtrack

#endif
