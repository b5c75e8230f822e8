// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include <cctype>
#include "files/joint_names.hpp"

namespace cv { namespace surgtrack {

String lowerCase(const String& text)
{
    String lower = text;
    for (size_t i = 0; i < lower.size(); i++)
        lower[i] = (char)std::tolower((uchar)lower[i]);
    return lower;
}

bool endsWith(const String& text, const String& end)
{
    return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

String jointKey(const String& name)
{
    String key = lowerCase(name);
    if (endsWith(key, "_joint"))
        key.resize(key.size() - 6);
    if (key.compare(0, 3, "psm") == 0)
    {
        const size_t after = key.find_first_not_of("0123456789", 3);
        if (after != String::npos && key[after] == '_')
            key = key.substr(after + 1);
    }
    if (key.compare(0, 6, "outer_") == 0)
        key = key.substr(6);
    const char* const dvrk[][2] = { { "yaw", "q1" }, { "pitch", "q2" }, { "insertion", "q3" }, { "main_insertion", "q3" }, { "roll", "q4" },
                                    { "tool_roll", "q4" }, { "wrist_pitch", "q5" }, { "tool_pitch", "q5" }, { "wrist_yaw", "q6" },
                                    { "tool_yaw", "q6" }, { "wrist_open_angle", "jaw" } };
    for (size_t i = 0; i < sizeof(dvrk) / sizeof(dvrk[0]); i++)
        if (key == dvrk[i][0])
            return dvrk[i][1];
    return key;
}

String jointUnitFault(const String& coordinate, double value)
{
    const String key = jointKey(coordinate);
    if (key == "q3" && std::abs(value) > 10)
        return format("%s is %g, further than any arm slides: expected metres, not millimetres", coordinate.c_str(), value);
    const bool turns = key == "q1" || key == "q2" || key == "q4" || key == "q5" || key == "q6" || key == "jaw";
    if (turns && std::abs(value) > 4 * CV_PI)
        return format("%s is %g, more than two turns: expected radians, not degrees", coordinate.c_str(), value);
    return String();
}

}} // namespace cv::surgtrack
