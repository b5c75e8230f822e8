// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_DETECT_QGO_HPP
#define OPENCV_SURGTRACK_SRC_DETECT_QGO_HPP

#include <vector>
#include "opencv2/core.hpp"

namespace cv { namespace surgtrack {

//! The threshold of quantizeOrientations() in the kernels' units.
int leastStrength(double magnitudeThreshold);

//! A CV_8UC1 image in memory that only grows, so that windows of changing size take none.
Mat keptImage(std::vector<uchar>& memory, const Size& size);

/** quantizeOrientations() of a window that lies in the image.
@param orientations of the window's size
@param workspace memory that is kept from call to call
@param sizes of the window's size, CV_8UC1: about twice the gradients' magnitude, at most 255; for dropWeak() */
CV_EXPORTS void quantize(const Mat& image, const Rect& window, int leastStrength, Mat& orientations, std::vector<uchar>& workspace, Mat* sizes = 0);

//! Orientations of a row whose size is less than asked for at its place are none.
CV_EXPORTS void dropWeak(uchar* bits, const uchar* sizes, const uchar* least, int n);

//! spreadOrientations(); dst is not src.
void spread(const Mat& src, Mat& dst, int size, std::vector<uchar>& workspace);

//! orientationResponse() for all eight bins; bin b of a row starts at planes + b * planeSize + row * planeStep.
void responses(const uchar* bits, size_t bitsStep, Size size, uchar* planes, size_t planeStep, size_t planeSize);

const int overrun = 64;   // a row of a kernel may

//! sums(y, x) = sum over i of planes[offsets[i] + y * step + x], for a window; planes hold values up to 4.
void similarities(const uchar* planes, size_t step, const int* offsets, int features, Size window, ushort* sums);

/** The coarse responses of a whole-image search: an upper bound of all responses that the 4 x 4 places of a cell can get from a
feature. Feature offset f = 4 F + r and place 4 g + s, both r and s in 0..3, give the pixel 4 (g + F) + 0..6: seven spread
pixels each way are OR-ed. The response of cell g to F lies in the bin's plane at g + F.
@param spread bits of a region of the image
@param tl where the region lies in the image
@param cells columns and rows of cells, ceil(image size / 4)
@param planes cell (-2, -2) of the first plane: those before the image see into it. Rows may be overrun by zeros. */
void coarseResponses(const Mat& spread, Point tl, Size cells, uchar* planes, size_t planeStep, size_t planeSize, std::vector<uchar>& workspace);

int greatest(const ushort* values, int n);

//! Indices of the values that are at least, in their order; indices has room for all. @return how many
int atLeast(const ushort* values, int n, int least, int* indices);

//! A feature for cellSimilarities(): where its pixel lies, from the upper left one of all of the cell; its bit, and with those of the neighbours.
struct CellFeature
{
    int offset;
    uchar same, wide;
};

//! Sums of the responses for the 4 x 4 places of a cell, row by row, from the spread bits.
void cellSimilarities(const uchar* bits, size_t step, const CellFeature* features, int n, ushort* sums);

// The definitions, pixel by pixel; what the fast kernels are tested against.
namespace plain {
CV_EXPORTS void quantize(const Mat& image, const Rect& window, int leastStrength, Mat& orientations, Mat* sizes = 0);
CV_EXPORTS void dropWeak(uchar* bits, const uchar* sizes, const uchar* least, int n);
void spread(const Mat& src, Mat& dst, int size);
void response(const Mat& bits, int bin, Mat& dst);
} // namespace plain

}} // namespace cv::surgtrack

#endif
