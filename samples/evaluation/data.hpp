// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// The sequences that evaluate is given, with all that is known of the truth.

#ifndef OPENCV_SURGTRACK_SAMPLES_EVALUATION_DATA_HPP
#define OPENCV_SURGTRACK_SAMPLES_EVALUATION_DATA_HPP

#include <cctype>
#include <map>
#include "opencv2/core/utils/filesystem.hpp"
#include "statistics.hpp"
#include "../support/tools.hpp"

namespace evaluation {

using namespace cv;
using namespace cv::surgtrack;
using common::fail;
using common::Tool;

//! The truth of one tool in one frame.
struct Truth
{
    Matx44d camera_T_tool;
    std::vector<double> joints;   //!< one per coordinate of the tool; empty if groundtruth.csv lacks one of them
};

//! A name for files and tables.
inline String plainName(String name)
{
    for (size_t i = 0; i < name.size(); i++)
        if (!std::isalnum((unsigned char)name[i]) && name[i] != '-' && name[i] != '.')
            name[i] = '_';
    return name;
}

//! A sequence with truth.
struct Data
{
    String folder, label;   //!< label: for tables and file names
    Ptr<Sequence> sequence;
    std::vector<Tool> tools;

    /** @param path folder
    @param newLabel label
    @throws cv::Exception naming the file and what was expected */
    void load(const String& path)
    {
        folder = path;
        sequence = Sequence::load(folder);
        const String truthFile = sequence->groundTruthFile();
        if (!sequence->hasGroundTruth() && !sequence->hasKeypoints())
            fail(truthFile + ": there is no such file, expected the true poses to evaluate against, or labels in " + sequence->keypointsFile());
        if (sequence->hasGroundTruth() && !hasPoses())
            fail(truthFile + ": expected lines with true poses");
        tools = common::loadTools(*sequence);
        for (int i = 0; i < (int)tools.size(); i++)   // an error in keypoints.csv comes before the work
            for (int frame = 0; frame < std::max(1, sequence->groundTruthEnd()); frame++)
                visibleKeypoints(i, frame);
        label = plainName(sequence->name());
    }

    //! Whether true poses are known; else there are labels in the images only.
    bool hasPoses() const { return sequence->groundTruthEnd() > 0; }

    //! Whether all tools have joint readings at a frame.
    bool hasJoints(int frame) const
    {
        std::vector<double> readings;
        bool found = true;
        for (int i = 0; i < (int)tools.size(); i++)
            found = found && sequence->jointsAt(i, time(frame), readings, tools[i].model->coordinateNames());
        return found;
    }

    double time(int frame, int field = 0) const { return sequence->frameTime(frame, field); }

    //! The joint readings of all tools at a frame.
    void joints(int frame, std::vector<std::vector<double> >& readings, int field = 0) const
    {
        readings.resize(tools.size());
        for (int i = 0; i < (int)tools.size(); i++)
            if (!sequence->jointsAt(i, time(frame, field), readings[i], tools[i].model->coordinateNames()))
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

    //! Image points of the keypoints that can be seen, by index.
    std::map<int, Point2d> visibleKeypoints(int tool, int frame) const
    {
        const std::vector<String> names = tools[tool].model->keypointNames();
        const std::vector<TrueKeypoint> points = sequence->keypoints(tool, frame);
        std::map<int, Point2d> result;
        for (size_t i = 0; i < points.size(); i++)
        {
            const size_t part = std::find(names.begin(), names.end(), points[i].name) - names.begin();
            if (part == names.size())
                fail(sequence->keypointsFile() + ": keypoint '" + points[i].name + "' is none of the keypoints of " + tools[tool].info.model);
            if (points[i].visible)
                result[(int)part] = points[i].imagePoint;
        }
        return result;
    }

    //! The pose of the arm's base that puts the end effector where it is, with these joints.
    Matx44d camera_T_base(int tool, const Matx44d& camera_T_tool, const std::vector<double>& joints) const
    {
        return camera_T_tool * rigidInverse(tools[tool].model->endEffectorPose(joints));
    }
};

} // namespace evaluation

#endif
