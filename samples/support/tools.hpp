// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// The tools of a sequence, and what is said of them.

#ifndef OPENCV_SURGTRACK_SAMPLES_SUPPORT_TOOLS_HPP
#define OPENCV_SURGTRACK_SAMPLES_SUPPORT_TOOLS_HPP

#include <map>
#include "opencv2/surgtrack.hpp"
#include "opencv2/surgtrack/lab.hpp"

namespace common {

struct Tool
{
    cv::surgtrack::SequenceTool info;
    cv::Ptr<cv::surgtrack::ToolModel> model;
    int tracked;    // frames
};

//! A tool file, an URDF, or one of the built-in tools by its name.
inline cv::Ptr<cv::surgtrack::ToolModel> anyTool(const cv::String& name)
{
    using cv::surgtrack::ToolModel;
    return name == "needle_driver" ? ToolModel::needleDriver() : name == "curved_scissors" ? ToolModel::curvedScissors() : cv::surgtrack::loadTool(name);
}

//! Tools of the same file share their model.
inline std::vector<Tool> loadTools(const cv::surgtrack::Sequence& sequence)
{
    std::map<cv::String, cv::Ptr<cv::surgtrack::ToolModel> > models;
    std::vector<Tool> tools;
    for (int i = 0; i < sequence.toolCount(); i++)
    {
        const cv::surgtrack::SequenceTool info = sequence.tool(i);
        cv::Ptr<cv::surgtrack::ToolModel>& model = models[info.model];
        if (!model)
            model = cv::surgtrack::loadTool(info.model);
        const Tool tool = { info, model, 0 };
        tools.push_back(tool);
    }
    return tools;
}

//! What the sequence says the eyes do not show.
inline void setMasks(const cv::surgtrack::Sequence& sequence, cv::surgtrack::ToolTracker& tracker, bool stereo)
{
    for (int eye = 0; eye <= (int)stereo; eye++)
        tracker.setMask(sequence.mask(eye), eye);
}

inline std::vector<cv::String> namesOf(const std::vector<Tool>& tools)
{
    std::vector<cv::String> names;
    for (size_t i = 0; i < tools.size(); i++)
        names.push_back(tools[i].info.name);
    return names;
}

inline std::vector<cv::Ptr<cv::surgtrack::ToolModel> > modelsOf(const std::vector<Tool>& tools)
{
    std::vector<cv::Ptr<cv::surgtrack::ToolModel> > models;
    for (size_t i = 0; i < tools.size(); i++)
        models.push_back(tools[i].model);
    return models;
}

inline bool isKnown(const cv::surgtrack::ToolEstimate& estimate)
{
    return estimate.state == cv::surgtrack::STATE_TRACKING || estimate.state == cv::surgtrack::STATE_COASTING;
}

//! What there is to say at a time without an image: the pose of the readings, with the correction and offsets known before.
inline cv::surgtrack::ToolEstimate unmeasured(const Tool& tool, const std::vector<double>& readings, int state, const cv::surgtrack::ToolEstimate& before)
{
    cv::surgtrack::ToolEstimate estimate;
    estimate.state = state;
    estimate.camera_T_nominal = before.camera_T_nominal;
    estimate.jointOffsets = before.jointOffsets;
    estimate.jointOffsets.resize(readings.size(), 0.);
    estimate.joints = readings;
    for (size_t i = 0; i < readings.size(); i++)
        estimate.joints[i] += estimate.jointOffsets[i];
    estimate.camera_T_tool = estimate.camera_T_nominal * tool.info.nominal_T_base * tool.model->endEffectorPose(estimate.joints);
    return estimate;
}

} // namespace common

#endif
