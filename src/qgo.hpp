// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_QGO_HPP
#define OPENCV_SURGTRACK_SRC_QGO_HPP

#include "opencv2/core.hpp"

namespace cv { namespace surgtrack {

//! The threshold of quantizeOrientations() in the kernels' units.
int squaredMagnitude(double magnitudeThreshold);

// The definitions, pixel by pixel; what the fast kernels are tested against.
namespace plain {
void quantize(const Mat& image, const Rect& window, int squaredThreshold, Mat& orientations);
void spread(const Mat& src, Mat& dst, int size);
void response(const Mat& bits, int bin, Mat& dst);
} // namespace plain

}} // namespace cv::surgtrack

#endif
