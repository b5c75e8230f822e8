// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "fuzz.hpp"
#include "opencv2/surgtrack/import.hpp"
#include "opencv2/surgtrack/tool_model.hpp"

using namespace cv::surgtrack;

FUZZ_FILE(".xml", [](const std::string& name)
{
    static const cv::Ptr<ToolModel> model = ToolModel::needleDriver();
    cv::Mat joints;
    importDaVinciJoints(name, model, joints);
})
