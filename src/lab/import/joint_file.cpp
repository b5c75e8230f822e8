// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "lab/import/joint_file.hpp"
#include "files/joint_names.hpp"
#include "files/text_file.hpp"

#include <cctype>
#include <cstdlib>
#include <cstring>

namespace cv { namespace surgtrack {

namespace {

//! The joint a column is of: the last part of its name, but for `position`; empty if it is not of a position.
String jointOf(const String& column)
{
    String joint, part;
    for (size_t i = 0; i <= column.size(); i++)
    {
        if (i < column.size() && column[i] != '/' && column[i] != '.')
        {
            part += column[i];
            continue;
        }
        if (part == "velocity" || part == "effort")
            return String();
        if (!part.empty() && part != "position")
            joint = part;
        part.clear();
    }
    return joint;
}

//! What a robot was told, not where it was.
bool isCommand(const String& column)
{
    const String name = lowerCase(column);
    return name.find("setpoint") != String::npos || name.find("goal") != String::npos || name.find("desired") != String::npos;
}

//! The number in `position3`, `position[3]`, `position_3` or `position.3` at the end of a name; -1 if it has none.
int indexAfter(String column, const String& word)
{
    if (endsWith(column, "]"))
        column.erase(column.size() - 1);
    size_t digits = column.size();
    while (digits > 0 && std::isdigit((uchar)column[digits - 1]))
        digits--;
    if (digits == column.size() || column.size() - digits > 3)
        return -1;
    size_t end = digits;
    if (end > 0 && std::strchr("[_.", column[end - 1]))
        end--;
    return endsWith(column.substr(0, end), word) ? std::atoi(column.c_str() + digits) : -1;
}

//! Whether a column is called so, whatever topic or message stands before it.
bool isCalled(const String& column, const String& word)
{
    return endsWith(column, word) && (column.size() == word.size() || std::strchr("./_", column[column.size() - word.size() - 1]));
}

//! The items of a list as Python prints it: [1, 2], ('a', 'b'), [1 2], array('d', [1, 2]).
std::vector<String> itemsOf(const String& text)
{
    const size_t array = text.find("['") == String::npos && text.compare(0, 6, "array(") == 0 ? text.find('[') : 0;
    std::vector<String> items;
    String item;
    for (size_t i = array == String::npos ? 0 : array; i <= text.size(); i++)
    {
        const bool ends = i == text.size() || std::strchr("()[], '\"", text[i]);
        if (!ends)
            item += text[i];
        else if (!item.empty())
        {
            items.push_back(item);
            item.clear();
        }
    }
    return items;
}

struct Unit
{
    const char* name;
    double size;
};

//! Takes a unit off the name of a column: `time [ns]`, `time_ms`, `q1 (deg)`. @return its size, 0 = none is said
template <size_t N> double takeUnit(String& name, const Unit (&units)[N])
{
    const size_t end = name.find_last_not_of("])");
    for (size_t i = 0; i < N && end != String::npos; i++)
    {
        const String unit = units[i].name;
        if (end + 1 <= unit.size() || lowerCase(name.substr(end + 1 - unit.size(), unit.size())) != unit || !std::strchr("_[(", name[end - unit.size()]))
            continue;
        name.resize(end - unit.size());
        while (!name.empty() && name[name.size() - 1] == ' ')
            name.resize(name.size() - 1);
        return units[i].size;
    }
    return 0;
}

const Unit timeUnits[] = { { "ns", 1e-9 }, { "us", 1e-6 }, { "ms", 1e-3 }, { "sec", 1 }, { "s", 1 } };
const Unit jointUnits[] = { { "rad", 1 }, { "radians", 1 }, { "deg", CV_PI / 180 }, { "degrees", CV_PI / 180 }, { "mm", 1e-3 }, { "cm", 1e-2 }, { "m", 1 } };

//! Seconds of a day and time of ISO 8601 since 1970, or of a duration as MATLAB writes it (`0.5 sec`). @return false: it is neither
bool readTime(const String& text, double& seconds)
{
    int year, month, day, hour, minute, used = 0;
    char between;
    double second;
    if (std::sscanf(text.c_str(), "%d-%d-%d%c%d:%d:%lf%n", &year, &month, &day, &between, &hour, &minute, &second, &used) == 7 && (between == ' ' || between == 'T'))
    {
        int zoneHour = 0, zoneMinute = 0;
        const String zone = text.substr(used);
        if (!zone.empty() && zone != "Z" && std::sscanf(zone.c_str(), "%d:%d", &zoneHour, &zoneMinute) < 1)
            return false;
        const int y = month <= 2 ? year - 1 : year, m = (month + 9) % 12;   // of years that begin in March
        const double days = 365. * y + y / 4 - y / 100 + y / 400 + (153 * m + 2) / 5 + day - 719469;
        seconds = 86400 * days + 3600 * (hour - zoneHour) + 60 * (minute - (zone[0] == '-' ? -zoneMinute : zoneMinute)) + second;
        return true;
    }
    char unit[8];
    return std::sscanf(text.c_str(), "%lf %7[a-z]%n", &seconds, unit, &used) == 2 && used == (int)text.size()
           && (String(unit) == "sec" || String(unit) == "s");
}

double toNumber(const CsvReader& csv, const JointCell& cell)
{
    if (cell.item < 0)
        return csv.number(cell.column) * (cell.unit > 0 ? cell.unit : 1);
    const std::vector<String> items = itemsOf(csv.text(cell.column));
    char* end = 0;
    const double value = (size_t)cell.item < items.size() ? std::strtod(items[cell.item].c_str(), &end) : 0;
    if (!end || *end || !(std::abs(value) < DBL_MAX))
        csv.fail(format("%s is '%.40s', expected a list of finite numbers, at least %d", csv.header()[cell.column].c_str(), csv.text(cell.column),
                        cell.item + 1));
    return value;
}

} // namespace

JointFile::JointFile(const String& filename) : filename_(filename)
{
    CsvReader csv(filename, true);
    header_ = csv.header();
    const bool hasRow = csv.next();
    for (size_t i = 0; i < header_.size(); i++)
    {
        const int index = isCommand(header_[i]) ? -1 : indexAfter(header_[i], "position");
        JointCell cell = { (int)i, -1, 0 }, none = { -1, -1, 0 };
        if (index >= (int)positions_.size())
            positions_.resize(index + 1, none);
        if (index >= 0 && positions_[index].column >= 0)
            fail("columns '" + header_[positions_[index].column] + "' and '" + header_[i] + "' have the same number, expected those of one arm");
        if (index >= 0)
            positions_[index] = cell;
    }
    for (size_t i = 0; hasRow && positions_.empty() && i < header_.size(); i++)
        if (isCalled(header_[i], "position") && std::strchr("[(a", csv.text((int)i)[0]))
            for (size_t k = 0; k < itemsOf(csv.text((int)i)).size(); k++)
            {
                const JointCell cell = { (int)i, (int)k, 0 };
                positions_.push_back(cell);
            }
    if (hasRow)
        readNames(csv);
    chooseTime();
}

void JointFile::readNames(const CsvReader& csv)
{
    std::vector<String> names(positions_.size());
    for (size_t i = 0; i < header_.size(); i++)
    {
        const int index = indexAfter(header_[i], "name");
        if (index >= 0 && index < (int)names.size())
            names[index] = csv.text((int)i);
        if (isCalled(header_[i], "name") && !positions_.empty() && positions_[0].item >= 0)
            names = itemsOf(csv.text((int)i));
    }
    if (names.size() == positions_.size() && std::count(names.begin(), names.end(), String()) == 0)
        names_ = names;
}

std::vector<JointFile::TimeColumn> JointFile::timeColumns(const CsvReader& csv) const
{
    std::vector<TimeColumn> found;
    const char* const pairs[][2] = { { "secs", "nsecs" }, { "sec", "nanosec" }, { "secs", "nanosecs" } };
    for (int i = 0; i < 3; i++)
        for (size_t a = 0; a < header_.size(); a++)
        {
            const String& name = header_[a];
            if (!endsWith(name, pairs[i][0]) || endsWith(name, pairs[i][1]))
                continue;
            const TimeColumn time = { (int)a, csv.find(name.substr(0, name.size() - String(pairs[i][0]).size()) + pairs[i][1]), 1 };
            if (time.fraction >= 0)
                found.push_back(time);
        }
    // The time stamp of the reading rather than the time it was recorded.
    for (int i = 0; i < 6; i++)
        for (size_t a = 0; a < header_.size(); a++)
        {
            const char* const names[] = { "", "", "time", "__time", "%time", "t" };
            String name = lowerCase(header_[a]);
            const TimeColumn time = { (int)a, -1, takeUnit(name, timeUnits) };
            const bool stamp = endsWith(name, "stamp"), header = endsWith(name, "header.stamp");
            if (i == 0 ? header : i == 1 ? stamp && !header : name == names[i])
                found.push_back(time);
        }
    return found;
}

//! The first column of a time that does not stand still: stamps that nobody filled in are 0.
void JointFile::chooseTime()
{
    CsvReader csv(filename_, true);
    const std::vector<TimeColumn> candidates = timeColumns(csv);
    if (candidates.empty())
        fail("line 1: expected a column of the time: time, timestamp, ...header.stamp, ...secs and ...nsecs");
    std::vector<String> first;
    time_ = candidates[0];
    if (candidates.size() == 1)
        return;
    while (csv.next())
        for (size_t i = 0; i < candidates.size(); i++)
        {
            const int fraction = candidates[i].fraction;
            const String text = String(csv.text(candidates[i].whole)) + "." + (fraction < 0 ? "" : csv.text(fraction));
            if (first.size() < candidates.size())
                first.push_back(text);
            else if (text != first[i])
            {
                time_ = candidates[i];
                if (i == 0)
                    return;
                break;
            }
        }
}

bool JointFile::find(const String& coordinate, JointCell& cell) const
{
    const String key = jointKey(coordinate);
    int found = -1;
    for (size_t i = 0; i < header_.size(); i++)
    {
        String name = header_[i];
        if ((int)i == time_.whole || (int)i == time_.fraction || name.empty() || isCommand(name))
            continue;
        const bool plain = jointKey(jointOf(name)) == key;
        const double unit = plain ? 0 : takeUnit(name, jointUnits);
        if (!plain && (unit == 0 || jointKey(jointOf(name)) != key))
            continue;
        if (found >= 0)
            fail("columns '" + header_[found] + "' and '" + header_[i] + "' are both of " + coordinate + ", expected one");
        found = (int)i;
        cell.unit = unit;
    }
    cell.column = found;
    cell.item = -1;
    if (found >= 0)
        return true;
    for (size_t i = 0; i < names_.size(); i++)
        if (jointKey(names_[i]) == key && positions_[i].column >= 0)
        {
            cell = positions_[i];
            return true;
        }
    return false;
}

bool JointFile::findColumn(const String& name, JointCell& cell) const
{
    String withoutUnit = name;
    cell.unit = takeUnit(withoutUnit, jointUnits);
    cell.item = -1;
    cell.column = (int)(std::find(header_.begin(), header_.end(), name) - header_.begin());
    return cell.column < (int)header_.size();
}

bool JointFile::findPosition(int index, JointCell& cell) const
{
    if (index >= (int)positions_.size() || positions_[index].column < 0)
        return false;
    cell = positions_[index];
    return true;
}

double JointFile::timeOf(const CsvReader& csv) const
{
    double seconds;
    if (readTime(csv.text(time_.whole), seconds))
        return seconds;
    return csv.number(time_.whole) + (time_.fraction < 0 ? 0 : 1e-9 * csv.number(time_.fraction));
}

void JointFile::read(std::vector<JointSeries>& series) const
{
    CsvReader csv(filename_, true);
    double last = -DBL_MAX;
    int rows = 0, conflicts = 0;
    while (csv.next())
    {
        if (csv.isEmpty(time_.whole))
            continue;
        const double time = timeOf(csv);
        if (time < last)
            csv.fail(format("time %.9g does not come after %.9g", time, last));
        bool conflict = false;
        for (size_t i = 0; i < series.size(); i++)
        {
            if (csv.isEmpty(series[i].cell.column))
                continue;
            const double value = toNumber(csv, series[i].cell);
            if (series[i].times.empty() || series[i].times.back() != time)
            {
                series[i].times.push_back(time);
                series[i].values.push_back(value);
            }
            else
                conflict = conflict || value != series[i].values.back();
        }
        last = time;
        rows++;
        conflicts += conflict;
    }
    for (size_t i = 0; i < series.size(); i++)
        if (series[i].times.size() < 2)
            fail("expected at least two readings" + (rows < 2 ? String() : format(" at different times, all of column '%s' are the same or '%s' is empty",
                                                     header_[time_.whole].c_str(), header_[series[i].cell.column].c_str())));
    if (conflicts > rows / 10)
        fail(format("column '%s': %d of %d rows repeat the time of the row before with other values: expected times with more digits",
                    header_[time_.whole].c_str(), conflicts, rows));
    toSeconds(series);
}

void JointFile::toSeconds(std::vector<JointSeries>& series) const
{
    std::vector<double> intervals;
    for (size_t i = 1; i < series[0].times.size(); i++)
        intervals.push_back(series[0].times[i] - series[0].times[i - 1]);
    std::nth_element(intervals.begin(), intervals.begin() + intervals.size() / 2, intervals.end());
    const double interval = intervals[intervals.size() / 2];   // the median: recorders pause
    const bool nanoseconds = interval >= 2e5;
    if (time_.unit == 0 && !nanoseconds && interval > 0.5)
        fail(format("column '%s': expected seconds or nanoseconds, readings are %g apart: as either no rate from 2 Hz to 5 kHz",
                    header_[time_.whole].c_str(), interval));
    const double unit = time_.unit > 0 ? time_.unit : nanoseconds ? 1e-9 : 1;
    for (size_t i = 0; i < series.size(); i++)
    {
        std::vector<double>& times = series[i].times;
        // Stamps of the first messages may not be filled in yet.
        while (times.size() > 2 && times[0] == 0 && times[1] > 1000 * interval)
        {
            times.erase(times.begin());
            series[i].values.erase(series[i].values.begin());
        }
        for (size_t k = 0; unit != 1 && k < times.size(); k++)
            times[k] *= unit;
    }
}

void JointFile::fail(const String& what) const { importError(filename_, what); }

}} // namespace cv::surgtrack
