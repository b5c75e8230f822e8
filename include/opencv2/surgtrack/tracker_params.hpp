// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_TRACKER_PARAMS_HPP
#define OPENCV_SURGTRACK_TRACKER_PARAMS_HPP

#include "opencv2/surgtrack/tool_tracker.hpp"

namespace cv { namespace surgtrack {

//! @addtogroup surgtrack
//! @{

/** @brief Reads parameters of a tracker from a file: those it names, the others stay as they are. Keys are the names of the fields of
ToolTracker::Params, and maps of those of ToolTracker::Stages.
@param filename YAML, XML or JSON, as writeTrackerParams() writes it
@param params, stages changed
@throws cv::Exception naming file and key: no such field, no number, or one out of its range */
CV_EXPORTS_W void readTrackerParams(const String& filename, CV_IN_OUT ToolTracker::Params& params, CV_IN_OUT ToolTracker::Stages& stages);

/** @brief Writes all parameters of a tracker.
@param filename YAML, XML or JSON by its ending
@param params, stages what is written
@throws cv::Exception naming the file if it can't be written */
CV_EXPORTS_W void writeTrackerParams(const String& filename, const ToolTracker::Params& params, const ToolTracker::Stages& stages);

/** @brief Sets one parameter by its name.
@param name of a field of ToolTracker::Params, as `minWindow`, or of a stage, as `matcher.minSimilarity`
@param value as text: a number; 0, 1, false or true for a flag
@param params, stages changed
@throws cv::Exception naming the parameter, and what it may be or what there is instead */
CV_EXPORTS_W void setTrackerParam(const String& name, const String& value, CV_IN_OUT ToolTracker::Params& params,
                                  CV_IN_OUT ToolTracker::Stages& stages);

//! @}

}} // namespace cv::surgtrack

#endif
