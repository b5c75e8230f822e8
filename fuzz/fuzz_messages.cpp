// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "fuzz.hpp"
#include "opencv2/surgtrack/live.hpp"

using namespace cv::surgtrack;

// Packets, one a line, as a robot's readings are taken in; and what the buffer then says at times about theirs.
extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    static cv::ErrorCallback quiet = cv::redirectError([](int, const char*, const char*, const char*, int, void*) { return 0; });
    (void)quiet;
    const cv::Ptr<JointBuffer> buffer = JointBuffer::create({ "q1", "q2", "q3", "q4", "q5", "q6", "jaw" });
    const cv::Ptr<ClockOffset> clock = ClockOffset::create();
    const std::string packets(reinterpret_cast<const char*>(data), size);
    double now = 1e6;
    for (size_t start = 0; start < packets.size(); now += 0.01)
    {
        const size_t end = std::min(packets.find('\n', start), packets.size());
        std::vector<JointReading> readings;
        try
        {
            parseJointMessage(packets.substr(start, end - start), readings);
            for (size_t i = 0; i < readings.size(); i++)
            {
                buffer->add(readings[i]);
                clock->add(readings[i].time, now);
            }
        }
        catch (const cv::Exception&)
        {
        }
        start = end + 1;
        const double about = readings.empty() ? buffer->newest() : readings[0].time;
        for (int k = -2; k <= 2; k++)
        {
            std::vector<double> joints;
            if (buffer->at(about + 0.003 * k, joints) == JOINTS_FOUND && !cv::checkRange(joints)) std::abort();
        }
        if (!(std::abs(clock->offset()) < 1e13)) std::abort();
    }
    return 0;
}
