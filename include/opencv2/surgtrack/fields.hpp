// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_FIELDS_HPP
#define OPENCV_SURGTRACK_FIELDS_HPP

#include "opencv2/core.hpp"

namespace cv { namespace surgtrack {

//! @addtogroup surgtrack
//! @{

/** @brief Whether an image holds two fields of different times, known by their combs: rows next to each other differ more than those
that are two apart. Only where something moves; some samples are looked at.
@param image CV_8UC1 or CV_8UC3 */
CV_EXPORTS_W bool isInterlaced(InputArray image);

/** @brief Takes the two fields of an interlaced image apart. Each is an image of the full size for the same camera: its own rows are
where they were, the others are the means of their neighbours, so nothing moves up or down by half a row.
@param image CV_8UC1 or CV_8UC3
@param topFirst whether the rows 0, 2, 4, ... were taken before the others
@param first what was taken first
@param second what was taken half a frame later; noArray() if it is not wanted */
CV_EXPORTS_W void splitFields(InputArray image, bool topFirst, OutputArray first, OutputArray second);

//! @}

}} // namespace cv::surgtrack

#endif
