// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_BASE_CALIB_HPP
#define OPENCV_SURGTRACK_SRC_BASE_CALIB_HPP

#include "opencv2/core/version.hpp"

// Rodrigues(), solvePnP(), calibrateHandEye(), boards, corners, distances: OpenCV 5 split calib3d, and imgproc.
#if CV_VERSION_MAJOR >= 5
#include "opencv2/calib.hpp"
#include "opencv2/features.hpp"
#include "opencv2/geometry.hpp"
#include "opencv2/objdetect.hpp"
#else
#include "opencv2/calib3d.hpp"
#endif

#endif
