// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/surgtrack/tool_tracker.hpp"

namespace cv { namespace surgtrack {

ToolTracker::Params::Params()
    : method(METHOD_FULL), jointOffsets(true), contours(true), adaptation(true), initialWindow(0.014), minWindow(30), minInitialInliers(6),
      minInitialSimilarity(0.65), minConfidence(0.5), confirmFrames(1), coastingTime(2), seed(1)
{
}

ToolTracker::Stages::Stages()
{
    paperFilter.minPoints = 4;   // as many as must agree on the geometric context
}

ToolSight::ToolSight() : enlargement(1) {}

StageTime::StageTime() : calls(0), last(0), mean(0), min(0), max(0) {}

}} // namespace cv::surgtrack
