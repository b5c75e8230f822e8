// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_FILTER_ARTICULATED_STATES_HPP
#define OPENCV_SURGTRACK_SRC_FILTER_ARTICULATED_STATES_HPP

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include "opencv2/surgtrack/articulated_pose_ekf.hpp"

namespace cv { namespace surgtrack {

const int maxStates = ArticulatedPoseEKF::MAX_STATES, maxSeen = 7 + ArticulatedPoseEKF::MAX_OFFSETS;

typedef Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::DontAlign, maxStates, 1> Vector;
typedef Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::DontAlign, maxStates, maxStates> Matrix;

// Of what a frame sees: (omega, v, d, delay).
typedef Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::DontAlign, maxSeen, 1> SeenVector;
typedef Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::DontAlign, maxSeen, maxSeen> SeenMatrix;
typedef Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, maxSeen> Rows2;
typedef Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::DontAlign, maxSeen, 2> SeenColumns2;
typedef Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, maxSeen> Rows3;

}} // namespace cv::surgtrack

#endif
