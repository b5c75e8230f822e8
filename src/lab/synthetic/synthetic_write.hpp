// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_LAB_SYNTHETIC_SYNTHETIC_WRITE_HPP
#define OPENCV_SURGTRACK_SRC_LAB_SYNTHETIC_SYNTHETIC_WRITE_HPP

#include "opencv2/surgtrack/synthetic.hpp"

namespace cv { namespace surgtrack {

//! SyntheticScene::write()
void writeScene(SyntheticScene& scene, const SyntheticScene::Params& params, const String& folder);

}} // namespace cv::surgtrack

#endif
