// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "fuzz.hpp"
#include "opencv2/surgtrack/sequence.hpp"

using namespace cv::surgtrack;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    const Input input(data, size, ".yaml");
    input.give([](const std::string& name)
    {
        const cv::Ptr<Sequence> sequence = Sequence::load(name, false);
        writeHandEye(name, sequence->tool(0).name, sequence->tool(0).nominal_T_base);
        Sequence::load(name, false);
    });
    input.give([](const std::string& name) { writeHandEye(name, "PSM1", cv::Matx44d::eye()); });   // also where it can't be loaded
    return 0;
}
