// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "files/csv.hpp"
#include "opencv2/surgtrack/import.hpp"

#include <cctype>
#include <cstdlib>
#include <cstring>

// importJoints(): CSV files of recorded joint readings.

namespace cv { namespace surgtrack {

namespace {

//! The dVRK's names of q1, q2, ...; some versions put `outer_` before them.
const char* const DVRK_NAMES[] = { "yaw", "pitch", "insertion", "roll", "wrist_pitch", "wrist_yaw" };

bool endsWith(const String& text, const String& end)
{
    return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

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

//! The number in `position3`, `position[3]`, `position_3` or `position.3` at the end of a name; -1 if it has none.
int positionIndex(String column)
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
    return endsWith(column.substr(0, end), "position") ? std::atoi(column.c_str() + digits) : -1;
}

class JointFile
{
public:
    explicit JointFile(const String& filename) : filename_(filename), csv_(filename), whole_(-1), fraction_(-1) { findTime(); }

    //! The column of a coordinate; -1: none
    int find(const String& coordinate, const String& column) const
    {
        if (!column.empty())
            return csv_.find(column);
        std::vector<String> names(1, coordinate);
        for (int i = 0; i < 6; i++)
            if (coordinate == format("q%d", i + 1))
            {
                names.push_back(DVRK_NAMES[i]);
                names.push_back(String("outer_") + DVRK_NAMES[i]);
            }
        int found = -1;
        for (size_t i = 0; i < csv_.header().size(); i++)
        {
            if ((int)i == whole_ || (int)i == fraction_ || std::find(names.begin(), names.end(), jointOf(csv_.header()[i])) == names.end())
                continue;
            if (found >= 0)
                fail("columns '" + csv_.header()[found] + "' and '" + csv_.header()[i] + "' are both of " + coordinate + ", expected one");
            found = (int)i;
        }
        return found;
    }

    int findPosition(int index) const
    {
        for (size_t i = 0; i < csv_.header().size(); i++)
            if (positionIndex(csv_.header()[i]) == index)
                return (int)i;
        return -1;
    }

    void read(const std::vector<int>& columns)
    {
        while (csv_.next())
        {
            const double time = csv_.number(whole_) + (fraction_ < 0 ? 0 : 1e-9 * csv_.number(fraction_));
            if (!times.empty() && time == times.back())
                continue;
            if (!times.empty() && time < times.back())
                csv_.fail(format("time %.9g does not come after %.9g", time, times.back()));
            times.push_back(time);
            for (size_t i = 0; i < columns.size(); i++)
                values.push_back(csv_.number(columns[i]));
        }
        if (times.size() < 2)
            fail("expected at least two readings");
        const double interval = (times.back() - times.front()) / (times.size() - 1);
        const bool nanoseconds = interval >= 2e5;
        if (!nanoseconds && interval > 0.5)
            fail(format("column '%s': expected seconds or nanoseconds, readings are %g apart: as either no rate from 2 Hz to 5 kHz",
                        csv_.header()[whole_].c_str(), interval));
        for (size_t i = 0; nanoseconds && i < times.size(); i++)
            times[i] *= 1e-9;
    }

    CV_NORETURN void fail(const String& what) const { CV_Error(Error::StsParseError, filename_ + ": " + what); }

    std::vector<double> times, values;   // values: row-major, a row a time

private:
    void findTime()
    {
        const char* const pairs[][2] = { { "secs", "nsecs" }, { "sec", "nanosec" }, { "secs", "nanosecs" } };
        for (int i = 0; i < 3; i++)
            for (size_t a = 0; a < csv_.header().size(); a++)
            {
                const String& name = csv_.header()[a];
                if (!endsWith(name, pairs[i][0]) || endsWith(name, pairs[i][1]))
                    continue;
                fraction_ = csv_.find(name.substr(0, name.size() - String(pairs[i][0]).size()) + pairs[i][1]);
                whole_ = (int)a;
                if (fraction_ >= 0)
                    return;
            }
        // The time stamp of the reading rather than the time it was recorded.
        const char* const ends[] = { "stamp", "time", "__time", "%time" };
        for (int i = 0; i < 4; i++)
            for (size_t a = 0; a < csv_.header().size(); a++)
            {
                const String& name = csv_.header()[a];
                whole_ = (int)a;
                if (i == 0 ? endsWith(name, "stamp") : name == ends[i])
                    return;
            }
        fail("line 1: expected a column of the time: time, timestamp, ...header.stamp, ...secs and ...nsecs");
    }

    String filename_;
    CsvReader csv_;
    int whole_, fraction_;   // columns of the time
};

struct Source
{
    Ptr<JointFile> file;
    std::vector<int> columns, coordinates;

    double valueAt(size_t i, double time) const
    {
        const std::vector<double>& t = file->times;
        const size_t n = columns.size(), after = std::min(std::max((size_t)(std::lower_bound(t.begin(), t.end(), time) - t.begin()), (size_t)1),
                                                          t.size() - 1);
        const double weight = (time - t[after - 1]) / (t[after] - t[after - 1]);
        const double a = file->values[(after - 1) * n + i], b = file->values[after * n + i];
        return weight <= 0 ? a : weight >= 1 ? b : a + weight * (b - a);
    }
};

} // namespace

void importJoints(const std::vector<String>& files, const std::vector<String>& coordinates, std::vector<double>& times,
                  OutputArray joints, const std::vector<String>& columns)
{
    if (files.empty() || coordinates.empty())
        CV_Error(Error::StsBadArg, "files, coordinates: expected at least one each");
    if (!columns.empty() && columns.size() != coordinates.size())
        CV_Error(Error::StsBadArg, format("columns: %d names, expected one for each of %d coordinates", (int)columns.size(), (int)coordinates.size()));
    std::vector<Source> sources(files.size());
    std::vector<bool> known(coordinates.size(), false);
    for (size_t f = 0; f < files.size(); f++)
    {
        Source& source = sources[f];
        source.file = makePtr<JointFile>(files[f]);
        for (int named = 1; named >= 0 && source.columns.empty(); named--)
            for (size_t c = 0; c < coordinates.size(); c++)
            {
                const int column = known[c] ? -1 : named ? source.file->find(coordinates[c], columns.empty() ? String() : columns[c])
                                                 : columns.empty() ? source.file->findPosition((int)source.columns.size()) : -1;
                if (column < 0)
                    continue;
                known[c] = true;
                source.columns.push_back(column);
                source.coordinates.push_back((int)c);
            }
        if (source.columns.empty())
            source.file->fail("line 1: expected columns of joints");
        source.file->read(source.columns);
    }
    for (size_t c = 0; c < coordinates.size(); c++)
        if (!known[c])
            sources[0].file->fail("line 1: expected a column of " + (columns.empty() ? coordinates[c] : columns[c])
                                  + (files.size() > 1 ? ", there or in the other files" : ""));

    double first = -DBL_MAX, last = DBL_MAX;
    for (size_t f = 0; f < files.size(); f++)
    {
        first = std::max(first, sources[f].file->times.front());
        last = std::min(last, sources[f].file->times.back());
    }
    times.clear();
    for (size_t i = 0; i < sources[0].file->times.size(); i++)
        if (sources[0].file->times[i] >= first && sources[0].file->times[i] <= last)
            times.push_back(sources[0].file->times[i]);
    if (times.empty())
        sources[0].file->fail("no readings at times of the other files, expected recordings of the same time");
    joints.create((int)times.size(), (int)coordinates.size(), CV_64F);
    Mat_<double> values = joints.getMat();
    for (size_t i = 0; i < times.size(); i++)
        for (size_t f = 0; f < files.size(); f++)
            for (size_t c = 0; c < sources[f].columns.size(); c++)
                values((int)i, sources[f].coordinates[c]) = sources[f].valueAt(c, times[i]);
}

}} // namespace cv::surgtrack
