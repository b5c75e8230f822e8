// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_LAB_HAND_EYE_HAND_EYE_MOTION_HPP
#define OPENCV_SURGTRACK_SRC_LAB_HAND_EYE_HAND_EYE_MOTION_HPP

#include "lab/hand_eye/hand_eye_solve.hpp"

namespace cv { namespace surgtrack {

/** How far the kept poses turn, and what is to be said of that and of result.best: fills largestRotation, crossRotation, warnings and
reason. */
void judgeHandEye(const HandEyeProblem& problem, const std::vector<int>& kept, HandEyeResult& result);

}} // namespace cv::surgtrack

#endif
