// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_LAB_TOOL_SIMPLIFIED_HPP
#define OPENCV_SURGTRACK_SRC_LAB_TOOL_SIMPLIFIED_HPP

#include "opencv2/surgtrack/tool_model.hpp"

namespace cv { namespace surgtrack {

//! The tool with at most so many triangles, as ToolModel::load() has it.
Ptr<ToolModel> simplified(const Ptr<ToolModel>& model, int maxTriangles);

/** The tool with meshes that do not depend on how their files have them: in which unit, mirrored or turned (and put right by what places them), in which
order, wound to which side. Vertices move by half a micrometre at most an axis. */
Ptr<ToolModel> canonical(const Ptr<ToolModel>& model);

}} // namespace cv::surgtrack

#endif
