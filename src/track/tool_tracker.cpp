// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "base/checks.hpp"
#include "opencv2/core/utils/logger.hpp"
#include "track/tool_tracker.hpp"

namespace cv { namespace surgtrack {

// The frame; tracker_setup.cpp: cameras and tools, tracker_ahead.cpp: renderAhead().

static const double longestPause = 3600;   // nothing that time changes is changed more by a longer one [s]

static Point2d enlarge(const Point2d& p, int factor)
{
    return Point2d((p.x + 0.5) * factor - 0.5, (p.y + 0.5) * factor - 0.5);
}

void ToolTrackerImpl::checkJoints(const std::vector<std::vector<double> >& joints) const
{
    if (tools_.empty()) CV_Error(Error::StsError, "no tool: addTool() comes first");
    CV_CheckEQ(joints.size(), tools_.size(), "joints: one vector per tool");
    for (size_t i = 0; i < joints.size(); i++)
    {
        const size_t expected = tools_[i]->coordinates();
        if (joints[i].size() != expected)
            CV_Error(Error::StsBadSize, format("joints[%d] has %d values, tool %s has %d coordinates", int(i), int(joints[i].size()),
                                               tools_[i]->model()->name().c_str(), int(expected)));
        if (!checkRange(joints[i])) CV_Error(Error::StsBadArg, format("joints[%d] holds a value that is not finite", int(i)));
    }
}

void ToolTrackerImpl::checkFrame(const Mat& image, size_t eye, const char* name, double time) const
{
    checkImage(image, name);
    const Size size = scene_.eyes[eye]->imageSize();
    if (image.size() != size)
        CV_Error(Error::StsUnmatchedSizes, format("%s is %d x %d, the camera's is %d x %d", name, image.cols, image.rows, size.width, size.height));
    if (!(time > scene_.time && time < DBL_MAX))
        CV_Error(Error::StsOutOfRange, format("time %g must be finite and larger than the last, %g", time, scene_.time));
}

// Others are drawn, and hidden, where this tool is; one that may be anywhere hides nothing.
void ToolTrackerImpl::show(int tool)
{
    scene_.views[tool] = tools_[tool]->view();
    if (!tools_[tool]->isLocated()) scene_.views[tool].base_T_link.clear();
}

// Calibration errors are each arm's own, but a camera that has moved has moved for all: by what another tool saw of it.
// The surest one comes first: it tells the others how the camera has moved since the frame before.
void ToolTrackerImpl::sortTools()
{
    order_.resize(tools_.size());
    for (int i = 0; i < int(tools_.size()); i++)
    {
        int at = i;
        for (; at > 0 && tools_[i]->sureness() > tools_[order_[at - 1]]->sureness(); at--) order_[at] = order_[at - 1];
        order_[at] = i;
    }
}

Matx44d ToolTrackerImpl::motionOfAnother(int tool) const
{
    for (size_t k = 0; k < order_.size(); k++)
        if (order_[k] != tool && tools_[order_[k]]->state() == STATE_TRACKING) return tools_[order_[k]]->cameraMotion();
    return Matx44d::eye();
}

void ToolTrackerImpl::report(int tool, ToolEstimate& e) const
{
    tools_[tool]->report(e);
    for (size_t i = 0; i < e.matches.size(); i++)
    {
        e.matches[i].imagePoint = enlarge(e.matches[i].imagePoint, scene_.eyes[0]->reduction());
        e.matches[i].predictedPoint = enlarge(e.matches[i].predictedPoint, scene_.eyes[0]->reduction());
    }
}

void ToolTrackerImpl::updateEyes(const Mat* images, size_t count, double time, const std::vector<std::vector<double> >& joints,
                                 std::vector<ToolEstimate>& estimates)
{
    const double before = scene_.time;
    size_t placed = 0, looked = 0;
    scene_.times.beginFrame();
    try
    {
        StageTimer timer(scene_.times, TOTAL);
        const double seconds = before > -DBL_MAX ? std::min(time - before, longestPause) : 0;
        while (placed < tools_.size())
        {
            placed++;
            tools_[placed - 1]->place(joints[placed - 1], seconds);
        }
        const TemplateSet* ahead = 0;
        {
            StageTimer renderTimer(scene_.times, RENDER);
            ahead = drawnAhead();
        }
        scene_.time = time;
        scene_.open = count;
        while (looked < count)
        {
            looked++;
            scene_.eyes[looked - 1]->setImage(images[looked - 1]);
        }
        for (int i = 0; i < int(tools_.size()); i++) show(i);
        sortTools();
        for (size_t k = 0; k < tools_.size(); k++)
        {
            const int i = order_[k];
            ToolMethod& tool = *tools_[i];
            const int state = tool.state();
            scene_.cameraMotion = motionOfAnother(i);
            scene_.cameraStep = k > 0 ? tools_[order_[0]]->cameraStep() : Matx44d::eye();
            tool.measure(scene_, ahead && tool.usesDrawnAhead() ? &ahead->drawings[i] : 0);
            show(i);
            if (tool.state() != state)
                CV_LOG_INFO(NULL, "surgtrack: tool " << i << ", " << tool.model()->name() << ": " << stateName(tool.state()) << " at " << time << " s");
        }
        estimates.resize(tools_.size());
        for (size_t i = 0; i < tools_.size(); i++) report(int(i), estimates[i]);
    }
    catch (...)   // as if this frame had not been
    {
        scene_.time = before;
        for (size_t i = 0; i < placed; i++) tools_[i]->takeBack();
        for (size_t e = 0; e < looked; e++) scene_.eyes[e]->takeBack();
        throw;
    }
    if (ahead_) ahead_->nextFrame();
    for (size_t e = 0; e < count; e++) scene_.eyes[e]->release();
    scene_.times.endFrame();
}

void ToolTrackerImpl::update(InputArray _image, double time, const std::vector<std::vector<double> >& joints, std::vector<ToolEstimate>& estimates)
{
    const Mat image = _image.getMat();
    checkJoints(joints);
    checkFrame(image, 0, "image", time);
    updateEyes(&image, 1, time, joints, estimates);
}

void ToolTrackerImpl::updateStereo(InputArray left, InputArray right, double time, const std::vector<std::vector<double> >& joints,
                                   std::vector<ToolEstimate>& estimates)
{
    if (cameras_.size() < 2) CV_Error(Error::StsError, "no right camera: setRightCamera() comes first");
    const Mat images[] = {left.getMat(), right.getMat()};
    checkJoints(joints);
    checkFrame(images[0], 0, "left", time);
    checkFrame(images[1], 1, "right", time);
    CV_CheckTypeEQ(images[0].type(), images[1].type(), "left and right must be of the same type");
    updateEyes(images, 2, time, joints, estimates);
}

ToolSight ToolTrackerImpl::sight(int tool, int eye) const
{
    checkTool(tool);
    CV_Check(eye, eye >= 0 && eye < int(cameras_.size()), "no such eye");
    ToolSight result = tools_[tool]->sight(eye);
    result.camera = scene_.eyes[eye]->camera();
    return result;
}

}} // namespace cv::surgtrack
