// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_LAB_IMPORT_URDF_TEXT_HPP
#define OPENCV_SURGTRACK_SRC_LAB_IMPORT_URDF_TEXT_HPP

#include "opencv2/core.hpp"

namespace cv { namespace surgtrack {

/** Refuses what urdfdom can't be given: xacro, and texts that keep it for long or end the program, as each level of tags is a call within a
call, and is looked through again for each that is closed.
@param filename for errors
@return names of the joints in the order of the text, which urdfdom does not keep
@throws cv::Exception */
std::vector<String> checkUrdfText(const String& filename, const String& text);

}} // namespace cv::surgtrack

#endif
