// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_MODEL_CAMERA_HPP
#define OPENCV_SURGTRACK_SRC_MODEL_CAMERA_HPP

#include "opencv2/surgtrack/camera.hpp"

namespace cv { namespace surgtrack {

//! The camera whose pixels are the means of factor x factor pixels.
CameraModel reduceCamera(const CameraModel& camera, int factor);

//! The camera of an image that was enlarged by a factor.
CameraModel enlargeCamera(const CameraModel& camera, int factor);

}} // namespace cv::surgtrack

#endif
