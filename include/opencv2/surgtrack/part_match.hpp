// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_PART_MATCH_HPP
#define OPENCV_SURGTRACK_PART_MATCH_HPP

#include "opencv2/core.hpp"

namespace cv { namespace surgtrack {

//! @addtogroup surgtrack
//! @{

/** @brief A place in the image where a part may be. */
struct CV_EXPORTS_W_SIMPLE PartMatch
{
    CV_WRAP PartMatch();

    CV_PROP_RW int tool;              //!< index of the tool
    CV_PROP_RW int part;              //!< index of the keypoint
    CV_PROP_RW Point2d imagePoint;    //!< where it was found [pixel]
    CV_PROP_RW double similarity;     //!< 0..1
    CV_PROP_RW Point2d predictedPoint;//!< where the template expected it [pixel]
    CV_PROP_RW int templateIndex;     //!< index into the templates that were matched
};

//! @}

}} // namespace cv::surgtrack

#endif
