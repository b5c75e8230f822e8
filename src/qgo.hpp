// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_QGO_HPP
#define OPENCV_SURGTRACK_SRC_QGO_HPP

#include <vector>
#include "opencv2/core.hpp"

namespace cv { namespace surgtrack {

//! The threshold of quantizeOrientations() in the kernels' units.
int leastStrength(double magnitudeThreshold);

/** quantizeOrientations() of a window that lies in the image.
@param orientations of the window's size
@param workspace memory that is kept from call to call */
void quantize(const Mat& image, const Rect& window, int leastStrength, Mat& orientations, std::vector<uchar>& workspace);

//! spreadOrientations(); dst is not src.
void spread(const Mat& src, Mat& dst, int size, std::vector<uchar>& workspace);

//! orientationResponse() for all eight bins; bin b of a row starts at planes + b * planeSize + row * planeStep.
void responses(const uchar* bits, size_t bitsStep, Size size, uchar* planes, size_t planeStep, size_t planeSize);

//! sums(y, x) = sum over i of planes[offsets[i] + y * step + x], for a window; planes hold values up to 4.
void similarities(const uchar* planes, size_t step, const int* offsets, int features, Size window, ushort* sums);

// The definitions, pixel by pixel; what the fast kernels are tested against.
namespace plain {
void quantize(const Mat& image, const Rect& window, int leastStrength, Mat& orientations);
void spread(const Mat& src, Mat& dst, int size);
void response(const Mat& bits, int bin, Mat& dst);
} // namespace plain

}} // namespace cv::surgtrack

#endif
