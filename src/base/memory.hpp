// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_BASE_MEMORY_HPP
#define OPENCV_SURGTRACK_SRC_BASE_MEMORY_HPP

#include <cstddef>

namespace cv { namespace surgtrack {

//! How much memory to take for `needed` elements where there are `existing`: twice what is needed, so that windows that grow a
//! little from frame to frame do not take some each time.
inline size_t roomFor(size_t needed, size_t existing) { return needed > existing ? 2 * needed : existing; }

}} // namespace cv::surgtrack

#endif
