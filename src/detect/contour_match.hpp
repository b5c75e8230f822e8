// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_DETECT_CONTOUR_MATCH_HPP
#define OPENCV_SURGTRACK_SRC_DETECT_CONTOUR_MATCH_HPP

#include "opencv2/surgtrack/contour.hpp"

namespace cv { namespace surgtrack {

//! @throws cv::Exception for values that are wrong
void checkSearch(const ContourSearch& search);

//! How strong an edge must be, by the picture around an outline, see ContourSearch::contrast. The same for all looks at it.
double strengthAsked(const Mat& image, const std::vector<ContourPoint>& points, const ContourSearch& search);

//! matchContour() with edges of that strength.
int matchContour(const Mat& image, std::vector<ContourPoint>& points, const ContourSearch& search, double leastStrength);

}} // namespace cv::surgtrack

#endif
