// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// The sequences that evaluate is given, with all that is known of the truth.

#ifndef OPENCV_SURGTRACK_SAMPLES_EVALUATION_DATA_HPP
#define OPENCV_SURGTRACK_SAMPLES_EVALUATION_DATA_HPP

#include <cctype>
#include <map>
#include <sstream>
#include "opencv2/core/utils/filesystem.hpp"
#include "statistics.hpp"

namespace evaluation {

using namespace cv;
using namespace cv::surgtrack;
using common::fail;

struct Tool
{
    SequenceTool info;
    Ptr<ToolModel> model;
};

//! The truth of one tool in one frame.
struct Truth
{
    Matx44d camera_T_tool;
    std::vector<double> joints;   //!< one per coordinate of the tool; empty if groundtruth.csv lacks one of them
};

//! Where a keypoint is, in the image as the camera delivers it.
struct TrueKeypoint
{
    Point2d imagePoint;
    bool visible;
};

/** The path a key of sequence.yaml names, or the default; folder may be the sequence.yaml itself, as for Sequence::load(). */
inline String fileOf(const String& folder, const char* key, const char* otherwise)
{
    const bool isFile = utils::fs::exists(folder) && !utils::fs::isDirectory(folder);
    const FileStorage description(isFile ? folder : utils::fs::join(folder, "sequence.yaml"), FileStorage::READ);
    const FileNode node = description[key];
    const String path = node.isString() && !node.string().empty() ? node.string() : String(otherwise);
    const bool absolute = path[0] == '/' || path[0] == '\\' || (path.size() > 1 && path[1] == ':');
    const String parent = isFile ? utils::fs::getParent(folder) : folder;
    return absolute ? path : utils::fs::join(parent.empty() ? String(".") : parent, path);
}

//! A name for files and tables.
inline String plainName(String name)
{
    for (size_t i = 0; i < name.size(); i++)
        if (!std::isalnum((unsigned char)name[i]) && name[i] != '-' && name[i] != '.')
            name[i] = '_';
    return name;
}

//! keypoints.csv: by tool, frame and keypoint.
class KeypointFile
{
public:
    typedef std::vector<std::vector<std::map<int, TrueKeypoint> > > Points;   // a tool, a keypoint, by frame

    static Points read(const String& filename, const std::vector<Tool>& tools)
    {
        KeypointFile file(filename);
        const int columns[] = { file.column("frame"), file.column("tool"), file.column("keypoint"), file.column("u"), file.column("v"),
                                file.column("visible") };
        Points points(tools.size());
        for (size_t i = 0; i < tools.size(); i++)
            points[i].resize(tools[i].model->keypoints().size());
        while (file.next())
        {
            size_t tool = 0, part = 0;
            while (tool < tools.size() && tools[tool].info.name != file.cells_[columns[1]])
                tool++;
            if (tool == tools.size())
                file.fail("tool '" + file.cells_[columns[1]] + "' is none of the tools of sequence.yaml");
            const std::vector<ToolModel::Keypoint>& keypoints = tools[tool].model->keypoints();
            while (part < keypoints.size() && keypoints[part].name != file.cells_[columns[2]])
                part++;
            if (part == keypoints.size())
                file.fail("keypoint '" + file.cells_[columns[2]] + "' is none of the keypoints of " + tools[tool].info.model);
            const double frame = file.number(columns[0]), visible = file.number(columns[5]);
            if (!(frame >= 0 && frame < 1e9 && frame == std::floor(frame)))
                file.fail("frame is '" + file.cells_[columns[0]] + "', expected a whole number from 0");
            if (visible != 0 && visible != 1)
                file.fail("visible is '" + file.cells_[columns[5]] + "', expected 0 or 1");
            const TrueKeypoint point = { Point2d(file.number(columns[3]), file.number(columns[4])), visible == 1 };
            points[tool][part][(int)frame] = point;
        }
        return points;
    }

private:
    explicit KeypointFile(const String& filename) : filename_(filename), file_(filename.c_str(), std::ios::binary), line_(0)
    {
        if (!file_)
            common::fail(filename_ + ": can't be read");
        next();
        header_ = cells_;
    }

    int column(const std::string& name) const
    {
        const size_t index = std::find(header_.begin(), header_.end(), name) - header_.begin();
        if (index == header_.size())
            common::fail(filename_ + ", line 1: expected a column '" + name + "'");
        return (int)index;
    }

    bool next()
    {
        std::string text;
        if (!std::getline(file_, text))
            return false;
        line_++;
        if (!text.empty() && text[text.size() - 1] == '\r')
            text.erase(text.size() - 1);
        cells_.clear();
        std::istringstream row(text);
        for (std::string value; std::getline(row, value, ',');)
            cells_.push_back(value);
        if (line_ > 1 && cells_.size() != header_.size())
            fail(format("has %d columns, expected %d as in line 1", (int)cells_.size(), (int)header_.size()));
        return true;
    }

    double number(int column) const
    {
        char* end = 0;
        const double value = std::strtod(cells_[column].c_str(), &end);
        if (end == cells_[column].c_str() || *end || cvIsNaN(value) || cvIsInf(value))
            fail(header_[column] + " is '" + cells_[column] + "', expected a number");
        return value;
    }

    CV_NORETURN void fail(const std::string& what) const { common::fail(format("%s, line %d: %s", filename_.c_str(), line_, what.c_str())); }

    String filename_;
    std::ifstream file_;
    int line_;
    std::vector<std::string> header_, cells_;
};

//! A sequence with truth.
struct Data
{
    String folder, label;   //!< label: for tables and file names
    Ptr<Sequence> sequence;
    std::vector<Tool> tools;
    KeypointFile::Points keypoints;   //!< empty without keypoints.csv
    String keypointSource;

    /** @param path folder
    @param newLabel label
    @throws cv::Exception naming the file and what was expected */
    void load(const String& path)
    {
        folder = path;
        sequence = Sequence::load(folder);
        const String truthFile = fileOf(folder, "groundtruth", "groundtruth.csv");
        if (!sequence->hasGroundTruth())
            fail(truthFile + ": there is no such file, expected the true poses to evaluate against");
        if (sequence->groundTruthEnd() == 0)
            fail(truthFile + ": expected lines with true poses");
        std::map<String, Ptr<ToolModel> > models;
        for (int i = 0; i < sequence->toolCount(); i++)
        {
            Tool tool;
            tool.info = sequence->tool(i);
            Ptr<ToolModel>& model = models[tool.info.model];
            if (!model)
                model = ToolModel::load(tool.info.model);
            tool.model = model;
            tools.push_back(tool);
        }
        const String keypointFile = fileOf(folder, "keypoints", "keypoints.csv");
        if (utils::fs::exists(keypointFile))
            keypoints = KeypointFile::read(keypointFile, tools);
        label = plainName(sequence->name());
    }

    double time(int frame) const { return frame / sequence->fps(); }

    //! The joint readings of all tools at a frame.
    void joints(int frame, std::vector<std::vector<double> >& readings) const
    {
        readings.resize(tools.size());
        for (int i = 0; i < (int)tools.size(); i++)
            if (!sequence->jointsAt(i, time(frame), readings[i], tools[i].model->coordinateNames()))
                fail(format("%s: no joint readings of tool '%s' at %.3f s (frame %d), expected the time of every frame; they cover %.3f to %.3f s",
                            sequence->kinematicsFile().c_str(), tools[i].info.name.c_str(), time(frame), frame, sequence->firstTime(i),
                            sequence->lastTime(i)));
    }

    //! @return false if there is none of this tool and frame
    bool truth(int tool, int frame, Truth& result) const
    {
        std::vector<double> values;
        if (!sequence->groundTruth(tool, frame, result.camera_T_tool, values))
            return false;
        const std::vector<String> columns = sequence->jointNames(), names = tools[tool].model->coordinateNames();
        result.joints.clear();
        for (size_t i = 0; i < names.size() && !values.empty(); i++)
        {
            const size_t column = std::find(columns.begin(), columns.end(), names[i]) - columns.begin();
            if (column < values.size())
                result.joints.push_back(values[column]);
        }
        if (result.joints.size() != names.size())
            result.joints.clear();
        return true;
    }

    //! The pose of the arm's base that puts the end effector where it is, with these joints.
    Matx44d camera_T_base(int tool, const Matx44d& camera_T_tool, const std::vector<double>& joints) const
    {
        return camera_T_tool * rigidInverse(tools[tool].model->endEffectorPose(joints));
    }
};

} // namespace evaluation

#endif
