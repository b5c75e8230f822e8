// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_FILES_JOINT_NAMES_HPP
#define OPENCV_SURGTRACK_SRC_FILES_JOINT_NAMES_HPP

#include "opencv2/core.hpp"

namespace cv { namespace surgtrack {

String lowerCase(const String& text);

bool endsWith(const String& text, const String& end);

/** What joints of the same meaning have in common: small letters, without the arm (`PSM1_`), `outer_` and `_joint`; the dVRK's names
(yaw, pitch, insertion, roll, wrist_pitch, wrist_yaw, jaw) are q1 to q6 and jaw. */
String jointKey(const String& name);

//! Whether a joint of the dVRK has a value no such joint can have: further than two turns or 10 m. @return what is wrong; empty: nothing
String jointUnitFault(const String& coordinate, double value);

}} // namespace cv::surgtrack

#endif
