// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_LAB_HPP
#define OPENCV_SURGTRACK_LAB_HPP

// What is around tracking: synthetic scenes, calibration, time offsets, files of others, live data, a view from outside, scores, a check of the setup,
// parameters as files.

#include "opencv2/surgtrack/synthetic.hpp"
#include "opencv2/surgtrack/hand_eye.hpp"
#include "opencv2/surgtrack/time_offset.hpp"
#include "opencv2/surgtrack/import.hpp"
#include "opencv2/surgtrack/live.hpp"
#include "opencv2/surgtrack/tool_setup.hpp"
#include "opencv2/surgtrack/scene_view.hpp"
#include "opencv2/surgtrack/pose_score.hpp"
#include "opencv2/surgtrack/setup_check.hpp"
#include "opencv2/surgtrack/tracker_params.hpp"
#include "opencv2/surgtrack/tool_state.hpp"

#endif
