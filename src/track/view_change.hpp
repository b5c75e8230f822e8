// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_TRACK_VIEW_CHANGE_HPP
#define OPENCV_SURGTRACK_SRC_TRACK_VIEW_CHANGE_HPP

#include "opencv2/surgtrack/part_templates.hpp"

namespace cv { namespace surgtrack {

//! How far a tool has moved between two views: the most of any keypoint. DBL_MAX if one is behind the camera.
struct ViewChange
{
    double shift;   // in the image [pixel]
    double turn;    // of its link [rad]
    double zoom;    // change of the distance, as a share of it
};

//! @param field keypoints that are not in this field of view now are left out; none: all count
ViewChange viewChange(const CameraModel& camera, const ToolModel& model, const ToolView& now, const ToolView& then, const Rect2d* field = 0);

}} // namespace cv::surgtrack

#endif
