// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_TOOL_STATE_HPP
#define OPENCV_SURGTRACK_TOOL_STATE_HPP

#include "opencv2/surgtrack/reading_errors.hpp"

namespace cv { namespace surgtrack {

//! @addtogroup surgtrack
//! @{

/** @brief What was learnt of tools, as writeToolState() wrote it.
@param filename YAML, XML or JSON
@param tool name of the tool in its sequence
@return without names if the file does not name the tool
@throws cv::Exception naming file and key */
CV_EXPORTS_W ReadingErrors readToolState(const String& filename, const String& tool);

/** @brief Writes what was learnt of tools.
@param filename YAML, XML or JSON by its ending
@param tools their names, each once
@param errors ToolTracker::readingErrors() of each
@throws cv::Exception naming the file if it can't be written; what was there before still is */
CV_EXPORTS_W void writeToolState(const String& filename, const std::vector<String>& tools, const std::vector<ReadingErrors>& errors);

//! @}

}} // namespace cv::surgtrack

#endif
