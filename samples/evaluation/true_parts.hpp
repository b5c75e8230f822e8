// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Where the parts of the tools are in truth, in the images that parts are looked for in.

#ifndef OPENCV_SURGTRACK_SAMPLES_EVALUATION_TRUE_PARTS_HPP
#define OPENCV_SURGTRACK_SAMPLES_EVALUATION_TRUE_PARTS_HPP

#include "data.hpp"

namespace evaluation {

/** Without keypoints.csv the true points come from groundtruth.csv and the tool file, and a part can be seen if a drawing at the true
pose shows it. */
class TrueParts
{
public:
    explicit TrueParts(const Data& data) : data_(data)
    {
        renderer_ = PartTemplateRenderer::create();
        finder_ = PartFinder::create(data.sequence->leftCamera(), renderer_);
        for (size_t i = 0; i < data.tools.size(); i++)
            renderer_->addTool(data.tools[i].model);
    }

    //! Of the reduced images.
    PartFinder& finder() { return *finder_; }

    //! The true state of all tools. @return false: there is none of some tool
    bool read(int frame)
    {
        frame_ = frame;
        truths_.resize(data_.tools.size());
        for (int i = 0; i < (int)data_.tools.size(); i++)
            if (!data_.truth(i, frame, truths_[i]))
                return false;
        return true;
    }
    const Truth& truth(int tool) const { return truths_[tool]; }

    //! Image points of the keypoints of one tool that can be seen, by index, in the reduced image.
    std::map<int, Point2d> visible(int tool)
    {
        std::map<int, Point2d> result;
        if (data_.sequence->hasKeypoints())
        {
            const std::map<int, Point2d> points = data_.visibleKeypoints(tool, frame_);
            for (std::map<int, Point2d>::const_iterator it = points.begin(); it != points.end(); ++it)
                result[it->first] = Point2d((it->second.x + 0.5) / finder_->reduction() - 0.5, (it->second.y + 0.5) / finder_->reduction() - 0.5);
            return result;
        }
        std::vector<ToolView> views(data_.tools.size());
        for (int i = 0; i < (int)data_.tools.size(); i++)
        {
            if (truths_[i].joints.empty())
                fail(data_.sequence->groundTruthFile() + ": expected the true joints of tool '" + data_.tools[i].info.name +
                     "', or a keypoints.csv beside it");
            views[i].camera_T_base = data_.camera_T_base(i, truths_[i].camera_T_tool, truths_[i].joints);
            data_.tools[i].model->forwardKinematics(truths_[i].joints, views[i].base_T_link);
        }
        finder_->draw(views, tool, drawing_);
        for (size_t i = 0; i < drawing_.templates.size(); i++)
            result[drawing_.templates[i].part] = drawing_.templates[i].imagePoint;
        return result;
    }

private:
    const Data& data_;
    Ptr<PartTemplateRenderer> renderer_;
    Ptr<PartFinder> finder_;
    std::vector<Truth> truths_;
    int frame_;
    PartDrawing drawing_;
};

} // namespace evaluation

#endif
