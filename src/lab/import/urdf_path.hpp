// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_LAB_IMPORT_URDF_PATH_HPP
#define OPENCV_SURGTRACK_SRC_LAB_IMPORT_URDF_PATH_HPP

#include "opencv2/core.hpp"

namespace cv { namespace surgtrack {

/** The file that a mesh of an URDF is in.
@param filename the URDF
@param packages ToolParts::packages
@param name as the URDF has it: `package://...`, `file://...` or a path
@throws cv::Exception naming it if it is nowhere to be looked for */
String urdfMeshPath(const String& filename, const String& packages, const String& name);

}} // namespace cv::surgtrack

#endif
