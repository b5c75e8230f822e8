// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_LAB_LIVE_READING_BOUNDS_HPP
#define OPENCV_SURGTRACK_SRC_LAB_LIVE_READING_BOUNDS_HPP

namespace cv { namespace surgtrack {

// What is more is no reading. Sums, differences and squares of others stay numbers, and times keep their microseconds.
const double mostPosition = 1e6, mostTime = 1e11;   // [rad or m], [s]

}} // namespace cv::surgtrack

#endif
