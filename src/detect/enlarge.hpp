// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_DETECT_ENLARGE_HPP
#define OPENCV_SURGTRACK_SRC_DETECT_ENLARGE_HPP

#include "opencv2/core.hpp"

namespace cv { namespace surgtrack {

/** A region of an image at twice its size, interpolated by cubics as resize() does it: without tables and threads.
@param image CV_8UC1 or CV_8UC3
@param area of the result that is filled
@param result twice as wide and high as the image, of its type */
CV_EXPORTS void enlargeTwice(const Mat& image, const Rect& area, Mat& result);

}} // namespace cv::surgtrack

#endif
