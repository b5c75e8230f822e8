// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "fuzz.hpp"
#include "opencv2/surgtrack/import.hpp"

using namespace cv::surgtrack;

FUZZ_FILE(".json", [](const std::string& name)
{
    importEndoVisKeypoints(name, name + ".csv");
    std::remove((name + ".csv").c_str());
})
