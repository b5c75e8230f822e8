// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_READING_ERRORS_HPP
#define OPENCV_SURGTRACK_READING_ERRORS_HPP

#include "opencv2/core.hpp"

namespace cv { namespace surgtrack {

//! @addtogroup surgtrack
//! @{

/** @brief What METHOD_FULL has learnt of what is wrong with the readings of a tool's joints: constants that are the robot's and its
instrument's and will be the same tomorrow. ToolTracker::readingErrors(), setReadingErrors(); files: readToolState(), writeToolState(). */
struct CV_EXPORTS_W_SIMPLE ReadingErrors
{
    CV_WRAP ReadingErrors() {}

    CV_PROP_RW std::vector<String> names;        //!< of the constants: a coordinate and `offset`, `gain`, `play` or `coupling`, as `wrist_yaw gain`; `delay`
    CV_PROP_RW std::vector<double> values;       //!< of each [rad or m, of the travel, rad, of the travel, s]
    CV_PROP_RW Mat covariance;                   //!< CV_64F, of the values; empty: nothing is known
    CV_PROP_RW std::vector<double> reference;    //!< one per coordinate: readings that travel is counted from [rad or m]
};

//! @}

}} // namespace cv::surgtrack

#endif
