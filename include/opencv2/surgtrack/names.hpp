// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_NAMES_HPP
#define OPENCV_SURGTRACK_NAMES_HPP

#include "opencv2/core.hpp"

namespace cv { namespace surgtrack {

//! @addtogroup surgtrack
//! @{

/** @brief What a name that there is not was probably meant to be.
@param name as it was written
@param names there are
@return the one that differs by the fewest letters, of the whole or of what comes after its last dot; empty if none is near */
CV_EXPORTS String closestName(const String& name, const std::vector<String>& names);

//! The same for the end of an error: `, did you mean 'NAME'?`, or empty.
CV_EXPORTS String didYouMean(const String& name, const std::vector<String>& names);

//! @}

}} // namespace cv::surgtrack

#endif
