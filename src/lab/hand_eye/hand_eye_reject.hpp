// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_LAB_HAND_EYE_HAND_EYE_REJECT_HPP
#define OPENCV_SURGTRACK_SRC_LAB_HAND_EYE_HAND_EYE_REJECT_HPP

#include "lab/hand_eye/hand_eye_solve.hpp"

namespace cv { namespace surgtrack {

typedef std::vector<int> Indices;

//! Poses that are left out together: one, or of many every thirtieth.
std::vector<Indices> groupsOf(const Indices& poses);

//! The poses that are not in the group.
Indices without(const Indices& poses, const Indices& group);

/** The poses that fit each other, see estimateHandEye(); the problem's weights are then those of their errors.
@param rejection in standard deviations, 0 = keep all
@param seed of the quadruples */
Indices keptPoses(HandEyeProblem& problem, double rejection, int seed);

}} // namespace cv::surgtrack

#endif
