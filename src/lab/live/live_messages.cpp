// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include <locale>
#include <sstream>
#include "opencv2/surgtrack/live.hpp"
#include "base/geometry.hpp"
#include "lab/live/reading_bounds.hpp"
#ifdef HAVE_NLOHMANN_JSON
#include <nlohmann/json.hpp>
#endif

namespace cv { namespace surgtrack {

#ifdef HAVE_NLOHMANN_JSON

namespace {

using nlohmann::json;

CV_NORETURN void fail(const String& what)
{
    CV_Error(Error::StsParseError, "joint message: " + what);
}

//! The text of a message, as far as a line of an error should have it.
String excerpt(const String& text)
{
    String result = text.substr(0, 60);
    for (size_t i = 0; i < result.size(); i++)
        if (result[i] < ' ' || result[i] > '~') result[i] = '?';
    return "'" + result + (text.size() > 60 ? "...'" : "'");
}

const json& required(const json& object, const String& path, const char* key)
{
    const json::const_iterator it = object.find(key);
    if (it == object.end())
        fail("key " + path + key + " is missing");
    return *it;
}

//! @param most what is more is no reading: sums and differences of others stay numbers
double boundedNumber(const json& value, const String& path, double most)
{
    const double number = value.is_number() ? value.get<double>() : DBL_MAX;
    if (!(std::abs(number) <= most))
        fail("key " + path + format(": expected a number within %g", most));
    return number;
}

String text(const json& value, const String& path)
{
    if (!value.is_string() || value.get_ref<const std::string&>().empty())
        fail("key " + path + ": expected a text");
    return value.get<std::string>();
}

std::vector<double> finiteNumbers(const json& values, const String& path)
{
    if (!values.is_array() || values.empty())
        fail("key " + path + ": expected a list of numbers");
    std::vector<double> result;
    for (size_t i = 0; i < values.size(); i++)
        result.push_back(boundedNumber(values[i], format("%s[%d]", path.c_str(), (int)i), mostPosition));
    return result;
}

std::vector<String> texts(const json& values, const String& path, size_t expected)
{
    if (!values.is_array() || values.size() != expected)
        fail(format("key %s: expected a list of %d names, one a position", path.c_str(), (int)expected));
    std::vector<String> result;
    for (size_t i = 0; i < values.size(); i++)
        result.push_back(text(values[i], format("%s[%d]", path.c_str(), (int)i)));
    return result;
}

JointReading readPlain(const json& message)
{
    JointReading reading;
    if (message.count("tool"))
        reading.tool = text(message["tool"], "tool");
    const String root;
    reading.time = boundedNumber(required(message, root, "time"), "time", mostTime);
    const json& positions = required(message, root, "position");
    if (positions.is_object() && !positions.empty())
    {
        for (json::const_iterator it = positions.begin(); it != positions.end(); ++it)
        {
            reading.names.push_back(it.key());
            reading.positions.push_back(boundedNumber(it.value(), "position." + excerpt(it.key()), mostPosition));
        }
        return reading;
    }
    reading.positions = finiteNumbers(positions, "position");
    if (message.count("name"))
        reading.names = texts(message["name"], "name", reading.positions.size());
    return reading;
}

/* The state of some joints, as cisst writes a prmStateJoint. key: [tool/][jaw/]measured_js. Returns false if the robot says that it
   is not valid; vectors are then often null. */
bool readState(const String& key, const json& state, JointReading& reading)
{
    const String path = excerpt(key) + ".";
    if (!state.is_object())
        fail("key " + excerpt(key) + ": expected an object");
    if (state.count("Valid"))
    {
        if (!state["Valid"].is_boolean())
            fail("key " + path + "Valid: expected true or false");
        if (!state["Valid"].get<bool>())
            return false;
    }
    reading.time = boundedNumber(required(state, path, "Timestamp"), path + "Timestamp", mostTime);
    reading.positions = finiteNumbers(required(state, path, "Position"), path + "Position");
    String tool = key.substr(0, key.size() - String("measured_js").size());
    const bool jaw = tool == "jaw/" || (tool.size() > 5 && tool.substr(tool.size() - 5) == "/jaw/");
    if (jaw)
        tool.resize(tool.size() - 4);
    reading.tool = tool.substr(0, tool.empty() ? 0 : tool.size() - 1);
    if (jaw && reading.positions.size() != 1)
        fail(format("key %sPosition: expected one number, found %d", path.c_str(), (int)reading.positions.size()));
    const json names = state.value("Name", json());
    if (jaw)
        reading.names.push_back("jaw");
    else if (!names.is_null())
        reading.names = texts(names, path + "Name", reading.positions.size());
    return true;
}

bool endsWith(const String& name, const String& end)
{
    return name.size() >= end.size() && name.compare(name.size() - end.size(), end.size(), end) == 0;
}

//! Rounded to nine digits: the message then fits into one Ethernet packet.
double finite(double value)
{
    CV_Assert(!cvIsNaN(value) && !cvIsInf(value) && "the numbers of an estimate must be finite");
    std::stringstream text;
    text.imbue(std::locale::classic());
    text.precision(9);
    text << value;
    text >> value;
    return value;
}

std::vector<double> finite(const double* values, size_t n)
{
    std::vector<double> result;
    for (size_t i = 0; i < n; i++) result.push_back(finite(values[i]));
    return result;
}

} // namespace

void parseJointMessage(const String& message, std::vector<JointReading>& readings)
{
    readings.clear();
    const json root = json::parse(message, nullptr, false);   // false: no exceptions
    if (!root.is_object())
        fail("expected a JSON object, found " + excerpt(message));
    std::vector<JointReading> found;
    if (root.count("tool") || root.count("time") || root.count("position"))
        found.push_back(readPlain(root));
    for (json::const_iterator it = root.begin(); it != root.end(); ++it)
    {
        JointReading reading;
        if ((it.key() == "measured_js" || endsWith(it.key(), "/measured_js")) && readState(it.key(), it.value(), reading))
            found.push_back(reading);
    }
    readings.swap(found);
}

String formatPoseMessage(int frame, double time, const String& tool, const ToolEstimate& estimate)
{
    const Matx44d& T = estimate.camera_T_tool;
    const double position[] = { T(0, 3), T(1, 3), T(2, 3) };
    const Vec4d q = quaternionFromRotation(T.get_minor<3, 3>(0, 0));
    CV_Assert(!cvIsNaN(time) && !cvIsInf(time) && "the time of an estimate must be finite");
    nlohmann::ordered_json message;
    message["frame"] = frame;
    message["time"] = time;
    message["tool"] = tool;
    message["status"] = stateName(estimate.state);
    message["position"] = finite(position, 3);
    message["orientation"] = finite(q.val, 4);
    for (int i = 0; i < 6; i++)
        message["covariance"].push_back(finite(&estimate.covariance.val[6 * i], 6));
    message["joint_offsets"] = finite(estimate.jointOffsets.data(), estimate.jointOffsets.size());
    message["similarity"] = finite(estimate.similarity);
    message["contour"] = finite(estimate.contourSupport);
    message["inliers"] = estimate.inliers;
    message["nis"] = finite(estimate.nis);
    return message.dump(-1, ' ', false, json::error_handler_t::replace);   // a name that is not UTF-8 must not stop the poses
}

#else

void parseJointMessage(const String&, std::vector<JointReading>&)
{
    CV_Error(Error::StsNotImplemented, "joint messages need nlohmann_json, which the module was built without");
}

String formatPoseMessage(int, double, const String&, const ToolEstimate&)
{
    CV_Error(Error::StsNotImplemented, "pose messages need nlohmann_json, which the module was built without");
}

#endif

}} // namespace cv::surgtrack
