// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "fuzz.hpp"
#include "opencv2/surgtrack.hpp"
#include "opencv2/surgtrack/tracker_params.hpp"

using namespace cv::surgtrack;

FUZZ_FILE(".yaml", [](const std::string& name)
{
    ToolTracker::Params params;
    ToolTracker::Stages stages;
    readTrackerParams(name, params, stages);
    try
    {
        ToolTracker::create(CameraModel(cv::Matx33d(800, 0, 320, 0, 800, 240, 0, 0, 1), cv::noArray(), cv::Size(640, 480)), params, stages);
    }
    catch (const cv::Exception&)   // which names the parameter
    {
    }
})
