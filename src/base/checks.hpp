// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_BASE_CHECKS_HPP
#define OPENCV_SURGTRACK_SRC_BASE_CHECKS_HPP

#include "opencv2/core.hpp"

namespace cv { namespace surgtrack {

//! Asserts that every element of a numeric array is finite; name is the argument's, for the message.
void checkFinite(InputArray values, const char* name);

//! As a N x channels CV_64F matrix (a copy if need be), finite; for arguments that may come as N x channels or N-vectors of points.
Mat asRows(InputArray values, int channels, const char* name);

//! CV_8UC1 or CV_8UC3, not empty.
void checkImage(const Mat& image, const char* name = "image");

}} // namespace cv::surgtrack

#endif
