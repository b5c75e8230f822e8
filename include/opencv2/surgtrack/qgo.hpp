// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_QGO_HPP
#define OPENCV_SURGTRACK_QGO_HPP

#include "opencv2/core.hpp"

namespace cv { namespace surgtrack {

//! @addtogroup surgtrack
//! @{

/** @brief Quantised gradient orientations (QGO) of an image (paper, Sec. 2.1; @cite hinterstoisser2012gradient).

Blur (7x7, sigma 1.41), 3x3 Sobel in the channel whose gradient is strongest (largest |gx| + |gy|), direction modulo 180 degrees in eight bins of
22.5 degrees (bin 0 is centred on a horizontal gradient), and a 3x3 vote: a pixel keeps an orientation if its gradient is
strong enough and at least five of the nine pixels around it share one bin; it gets that bin. Integer arithmetic throughout.

@param image CV_8UC1 or CV_8UC3, any size; pixels beyond its border repeat it
@param orientations CV_8UC1, same size: 0 or one bit, 1 << bin
@param magnitudeThreshold least Sobel magnitude of the blurred image [grey levels x 4] that counts as an edge */
CV_EXPORTS_W void quantizeOrientations(InputArray image, OutputArray orientations, double magnitudeThreshold = 50);

/** @brief The same for a window of a larger image: pixels beyond the window but inside the image are used, so that the result
is quantizeOrientations() of the whole image, cut out.
@param image CV_8UC1 or CV_8UC3, any size; pixels beyond its border repeat it
@param window part of the image; must lie inside it
@param orientations CV_8UC1 of the window's size
@param magnitudeThreshold least Sobel magnitude of the blurred image [grey levels x 4] that counts as an edge */
CV_EXPORTS_AS(quantizeOrientationsInWindow) void quantizeOrientations(InputArray image, const Rect& window, OutputArray orientations, double magnitudeThreshold = 50);

/** @brief Spreads orientations: each pixel gets the bits of all pixels of the size x size square around it
(@cite hinterstoisser2012gradient, Sec. 3.3). Tolerates misplacement by size / 2 pixels.
@param orientations CV_8UC1 bit sets
@param spread CV_8UC1, same size
@param size odd side of the square [pixel] */
CV_EXPORTS_W void spreadOrientations(InputArray orientations, OutputArray spread, int size = 5);

/** @brief Similarity of every spread bit set to one orientation: 4 if it holds the orientation, 1 if it holds a neighbouring
one, else 0.
@param spread CV_8UC1 bit sets
@param bin 0..7
@param response CV_8UC1, same size, values 0, 1, 4 */
CV_EXPORTS_W void orientationResponse(InputArray spread, int bin, OutputArray response);

//! @}

}} // namespace cv::surgtrack

#endif
