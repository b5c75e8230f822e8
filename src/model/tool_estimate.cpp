// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/surgtrack/tool_estimate.hpp"

namespace cv { namespace surgtrack {

PartMatch::PartMatch() : tool(0), part(0), similarity(0), templateIndex(0) {}

String stateName(int state)
{
    static const char* names[] = {"initializing", "tracking", "coasting", "lost"};
    CV_Check(state, state >= STATE_INITIALIZING && state <= STATE_LOST, "no such state");
    return names[state];
}

ToolEstimate::ToolEstimate()
    : state(STATE_INITIALIZING), camera_T_tool(Matx44d::eye()), camera_T_nominal(Matx44d::eye()), covariance(Matx66d::zeros()),
      visibleParts(0), inliers(0), similarity(0), contourSupport(0), confidence(0), nis(0), delay(0), skippedReadings(0)
{
}

}} // namespace cv::surgtrack
