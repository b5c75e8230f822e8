// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "lab/import/joint_file.hpp"
#include "files/joint_names.hpp"
#include "files/text_file.hpp"
#include "opencv2/surgtrack/import.hpp"

#include <cstdlib>

// importJoints(): CSV files of recorded joint readings. importSurgPoseJoints(): SurgPose's.

namespace cv { namespace surgtrack {

namespace {

void checkUnits(const String& filename, const std::vector<String>& coordinates, const Mat_<double>& joints)
{
    for (int i = 0; i < joints.rows; i++)
        for (int c = 0; c < joints.cols; c++)
        {
            const String fault = jointUnitFault(coordinates[c], joints(i, c));
            if (!fault.empty())
                importError(filename, fault);
        }
}

//! Which cells of a file are of which coordinates: those that are known by name; in a file with none, by place.
std::vector<JointSeries> seriesOf(const JointFile& file, const std::vector<String>& coordinates, const std::vector<String>& columns,
                                  std::vector<bool>& known)
{
    std::vector<JointSeries> found;
    for (int named = 1; named >= 0 && found.empty(); named--)
        for (size_t c = 0; c < coordinates.size(); c++)
        {
            JointCell cell;
            const bool there = known[c] ? false : !columns.empty() ? named && file.findColumn(columns[c], cell)
                                                : named ? file.find(coordinates[c], cell) : file.findPosition((int)found.size(), cell);
            if (!there)
                continue;
            known[c] = true;
            found.push_back(JointSeries(cell, (int)c));
        }
    if (found.empty())
        file.fail("line 1: expected columns of joints");
    return found;
}

double valueAt(const JointSeries& series, double time)
{
    const std::vector<double>& t = series.times;
    const size_t after = std::min(std::max((size_t)(std::lower_bound(t.begin(), t.end(), time) - t.begin()), (size_t)1), t.size() - 1);
    const double weight = (time - t[after - 1]) / (t[after] - t[after - 1]);
    const double a = series.values[after - 1], b = series.values[after];
    return weight <= 0 ? a : weight >= 1 ? b : a + weight * (b - a);
}

} // namespace

void importJoints(const std::vector<String>& files, const std::vector<String>& coordinates, std::vector<double>& times,
                  OutputArray joints, const std::vector<String>& columns)
{
    if (files.empty() || coordinates.empty())
        CV_Error(Error::StsBadArg, "files, coordinates: expected at least one each");
    if (!columns.empty() && columns.size() != coordinates.size())
        CV_Error(Error::StsBadArg, format("columns: %d names, expected one for each of %d coordinates", (int)columns.size(), (int)coordinates.size()));
    std::vector<JointSeries> all;
    std::vector<bool> known(coordinates.size(), false);
    for (size_t f = 0; f < files.size(); f++)
    {
        JointFile file(files[f]);
        std::vector<JointSeries> series = seriesOf(file, coordinates, columns, known);
        file.read(series);
        all.insert(all.end(), series.begin(), series.end());
    }
    for (size_t c = 0; c < coordinates.size(); c++)
        if (!known[c])
            importError(files[0], "line 1: expected a column of " + (columns.empty() ? coordinates[c] : columns[c])
                                  + (files.size() > 1 ? ", there or in the other files" : ""));

    double first = -DBL_MAX, last = DBL_MAX;
    for (size_t i = 0; i < all.size(); i++)
    {
        first = std::max(first, all[i].times.front());
        last = std::min(last, all[i].times.back());
    }
    times.clear();
    for (size_t i = 0; i < all[0].times.size(); i++)
        if (all[0].times[i] >= first && all[0].times[i] <= last)
            times.push_back(all[0].times[i]);
    if (times.empty())
        importError(files[0], files.size() > 1 ? "no readings at times of the other files, expected recordings of the same time"
                                               : "no time at which all joints are known, expected readings of the same time");
    joints.create((int)times.size(), (int)coordinates.size(), CV_64F);
    Mat_<double> values = joints.getMat();
    for (size_t i = 0; i < times.size(); i++)
        for (size_t s = 0; s < all.size(); s++)
            values((int)i, all[s].coordinate) = valueAt(all[s], times[i]);
    checkUnits(files[0], coordinates, values);
}

void importSurgPoseJoints(const String& filename, const String& arm, int coordinates, double jaw, OutputArray joints)
{
    if (coordinates < 1)
        CV_Error(Error::StsBadArg, "coordinates: expected the number of the tool's");
    const FileStorage file = openYaml(filename);
    const FileNode frames = file.root();
    Mat_<double> rows(0, coordinates);
    for (FileNodeIterator it = frames.begin(); it != frames.end(); ++it)
    {
        const FileNode frame = *it;
        const String path = "key " + frame.name().substr(1), expected = format("%s: expected frame %d", path.c_str(), rows.rows);
        if (frame.name() != format("n%d", rows.rows))
            importError(filename, expected + ", frames count from 0 without a gap");
        const FileNode values = frame.isMap() ? frame[arm] : FileNode();
        const int n = values.isSeq() ? (int)values.size() : 0;
        if (n != coordinates && n + 1 != coordinates)
            importError(filename, path + "." + arm + format(": expected %d numbers, or %d without the jaw", coordinates, coordinates - 1));
        Mat_<double> row(1, coordinates, jaw);
        for (int i = 0; i < n; i++)
            row(i) = values[i].isInt() || values[i].isReal() ? (double)values[i] : DBL_MAX;
        if (!checkRange(row, true, 0, -1e6, 1e6))
            importError(filename, path + "." + arm + ": expected finite numbers [rad or m]");
        rows.push_back(row);
    }
    if (rows.empty())
        importError(filename, "expected frames `0`, `1`, ... with the joints of the arms");
    rows.copyTo(joints);
}

}} // namespace cv::surgtrack
