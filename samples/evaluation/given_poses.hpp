// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Poses of any other program, to be set beside ours.

#ifndef OPENCV_SURGTRACK_SAMPLES_EVALUATION_GIVEN_POSES_HPP
#define OPENCV_SURGTRACK_SAMPLES_EVALUATION_GIVEN_POSES_HPP

#include <sstream>
#include "baselines/pose_run.hpp"
#include "files.hpp"

namespace evaluation {

//! `NAME:PATH`, a poses file, or a folder with a SEQUENCE.csv for each sequence it has poses of.
struct GivenPoses
{
    String name, path;

    //! @throws cv::Exception if it is something else
    static GivenPoses parse(const String& text)
    {
        GivenPoses given;
        const size_t colon = text.find(':');
        given.name = text.substr(0, colon);
        given.path = colon == String::npos ? String() : text.substr(colon + 1);
        if (given.path.empty() || given.name.empty() || plainName(given.name) != given.name)
            fail("argument '--poses': '" + text + "', expected NAME:FILE, the name of letters, digits, '-' and '.'");
        if (!utils::fs::exists(given.path))
            fail("argument '--poses': " + given.path + ": there is no such file or folder");
        return given;
    }
    //! The file of a sequence; empty if there is none. @param folder of the sequence
    String fileOf(const String& folder) const
    {
        if (!utils::fs::isDirectory(path))
            return path;
        const String file = utils::fs::join(path, baseName(absolutePath(folder)) + ".csv");
        return utils::fs::exists(file) ? file : String();
    }
};

/** @brief Reads a poses file (doc/formats.md) as a run. Of its columns frame, tool, tx .. qw are needed; status, if there is one, says
which rows are poses. A frame with truth that it has no row of is lost.
@param frames at most so many; 0 = all with truth
@throws cv::Exception naming file and line */
class PosesFile
{
public:
    static Run read(const Data& data, const String& name, const String& filename, int frames)
    {
        std::ifstream file(filename.c_str());
        std::string line;
        if (!file || !std::getline(file, line))
            fail(filename + ": expected a line with names of columns");
        const std::vector<std::string> header = split(line);
        static const char* const names[] = { "frame", "tool", "tx", "ty", "tz", "qx", "qy", "qz", "qw" };
        int columns[9];
        for (int i = 0; i < 9; i++)
        {
            columns[i] = (int)(std::find(header.begin(), header.end(), names[i]) - header.begin());
            if (columns[i] == (int)header.size())
                fail(filename + ": expected a column '" + String(names[i]) + "'");
        }
        const size_t status = std::find(header.begin(), header.end(), "status") - header.begin();
        Poses poses;
        for (int number = 2; std::getline(file, line); number++)
        {
            const std::vector<std::string> cells = split(line);
            const String place = filename + format(", line %d: ", number);
            if (cells.size() != header.size())
                fail(place + format("has %d columns, expected %d", (int)cells.size(), (int)header.size()));
            const int state = status < cells.size() ? stateOf(place, cells[status]) : int(STATE_TRACKING);
            poses[std::make_pair(toolOf(data, place, cells[columns[1]]), cvRound(numberOf(place, cells[columns[0]])))] =
                std::make_pair(state, poseOf(place, cells, columns));
        }
        return runOf(data, name, poses, frames);
    }

private:
    typedef std::map<std::pair<int, int>, std::pair<int, Matx44d> > Poses;   // by tool and frame: state and pose

    static std::vector<std::string> split(std::string line)
    {
        if (!line.empty() && line[line.size() - 1] == '\r')
            line.erase(line.size() - 1);
        std::vector<std::string> cells(1);
        for (size_t i = 0; i < line.size(); i++)
            if (line[i] == ',')
                cells.push_back(std::string());
            else
                cells.back() += line[i];
        return cells;
    }
    static double numberOf(const String& place, const std::string& cell)
    {
        std::istringstream stream(cell);
        stream.imbue(std::locale::classic());
        double value;
        if (!(stream >> value) || !stream.eof())
            fail(place + "'" + cell + "', expected a number");
        return value;
    }
    static int stateOf(const String& place, const std::string& cell)
    {
        for (int state = STATE_INITIALIZING; state <= STATE_LOST; state++)
            if (stateName(state) == cell)
                return state;
        fail(place + "status is '" + cell + "', expected initializing, tracking, coasting or lost");
    }
    static int toolOf(const Data& data, const String& place, const std::string& cell)
    {
        for (int tool = 0; tool < (int)data.tools.size(); tool++)
            if (data.tools[tool].info.name == cell)
                return tool;
        fail(place + "tool '" + cell + "' is none of the sequence's");
    }
    static Matx44d poseOf(const String& place, const std::vector<std::string>& cells, const int* columns)
    {
        double v[7];
        for (int i = 0; i < 7; i++)
            v[i] = numberOf(place, cells[columns[2 + i]]);
        const double length = std::sqrt(v[3] * v[3] + v[4] * v[4] + v[5] * v[5] + v[6] * v[6]);
        if (std::abs(length - 1) > 1e-2)   // digits cut off, not another convention
            fail(place + "the quaternion is not of length 1");
        const double x = v[3] / length, y = v[4] / length, z = v[5] / length, w = v[6] / length;
        const Matx33d R(1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), 2 * (x * y + z * w), 1 - 2 * (x * x + z * z),
                        2 * (y * z - x * w), 2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y));
        return rigid(R, Vec3d(v[0], v[1], v[2]));
    }
    static Run runOf(const Data& data, const String& name, const Poses& poses, int frames)
    {
        PoseRun run(data, name);
        for (int frame = 0; frame < data.sequence->groundTruthEnd() && (frames == 0 || frame < frames); frame++)
        {
            for (int tool = 0; tool < (int)data.tools.size(); tool++)
            {
                const Poses::const_iterator it = poses.find(std::make_pair(tool, frame));
                run.add(tool, frame, it == poses.end() ? int(STATE_LOST) : it->second.first, it == poses.end() ? Matx44d::eye() : it->second.second);
            }
            run.addFrame(0);
        }
        return run.finish();
    }
};

} // namespace evaluation

#endif
