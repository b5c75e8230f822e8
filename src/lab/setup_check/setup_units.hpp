// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_LAB_SETUP_CHECK_SETUP_UNITS_HPP
#define OPENCV_SURGTRACK_SRC_LAB_SETUP_CHECK_SETUP_UNITS_HPP

#include "precomp.hpp"
#include "opencv2/surgtrack/tool_model.hpp"

namespace cv { namespace surgtrack {

//! What is wrong with readings, a row each, by the limits of the tool file; empty: nothing.
String limitFault(const ToolModel& model, const Mat& joints);

//! Turning coordinates that go so far that their readings may be degrees.
std::vector<int> mayBeDegrees(const ToolModel& model, const Mat& joints);

//! What is wrong with the sizes of meshes; empty: nothing.
String sizeFault(const ToolModel& model);

}} // namespace cv::surgtrack

#endif
