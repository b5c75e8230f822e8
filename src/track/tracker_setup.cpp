// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "base/geometry.hpp"
#include "detect/contour_match.hpp"
#include "track/full_method.hpp"
#include "track/paper_method.hpp"
#include "track/tool_tracker.hpp"

namespace cv { namespace surgtrack {

// Cameras and tools, which may come and go.

namespace {

const int minFullInliers = 4;   // of a first pose of METHOD_FULL; the outline tells the rest

void checkParams(const ToolTracker::Params& p)
{
    CV_Check(p.method, p.method >= METHOD_PAPER && p.method <= METHOD_FULL, "Params::method: no such method");
    CV_CheckGE(p.minInitialInliers, 4, "Params::minInitialInliers: EPnP needs four points");
    CV_Check(p.initialWindow, p.initialWindow > 0 && p.initialWindow <= 1, "Params::initialWindow must be positive and at most 1 m");
    CV_Check(p.minWindow, p.minWindow > 0 && p.minWindow < 1e5, "Params::minWindow must be positive");
    CV_Check(p.minInitialSimilarity, p.minInitialSimilarity >= 0 && p.minInitialSimilarity <= 1, "Params::minInitialSimilarity must be in 0..1");
    CV_Check(p.minConfidence, p.minConfidence >= 0 && p.minConfidence < 1, "Params::minConfidence must be at least 0 and less than 1");
    CV_CheckGE(p.confirmFrames, 0, "Params::confirmFrames must not be negative");
    CV_Check(p.coastingTime, p.coastingTime >= 0 && p.coastingTime < DBL_MAX, "Params::coastingTime must not be negative");
}

//! @return with an exact rotation
Matx44d checkedPose(const Matx44d& T, const char* name)
{
    const double farthest = 1000;   // [m]
    if (!isRigid(T)) CV_Error(Error::StsBadArg, format("%s must be a rigid transform", name));
    if (!(norm(Vec3d(T(0, 3), T(1, 3), T(2, 3))) <= farthest)) CV_Error(Error::StsBadArg, format("%s must be within %g m", name, farthest));
    return nearestRigid(T);
}

} // namespace

ToolTrackerImpl::ToolTrackerImpl(const CameraModel& camera, const Params& params, const Stages& stages, const Ptr<MeshRenderer>& renderer)
    : params_(params), stages_(stages), renderer_(renderer ? renderer : MeshRenderer::createSoftware())
{
    CV_Assert(!camera.imageSize().empty());
    checkParams(params);
    checkSearch(stages.edges);
    const bool full = params.method == METHOD_FULL;
    if (full) stages_.templates.wholeTool = true;
    else stages_.matcher.contrast = 0;   // as published: without outlines as evidence, more orientations end in more false poses
    const Camera left = {camera, Matx44d::eye(), Mat()};
    change(tools_, std::vector<Camera>(1, left));
    const double scale = scene_.eyes[0]->pixelScale();
    GeometricContextVerifier::Params& context = stages_.verifier;
    context.seed = params.seed;
    context.zoneRadius *= scale;
    if (!full)
    {
        context.centredZones = false;   // both methods are the paper's: fixed cells, the first sample that agrees
        context.maxScale = context.maxRotation = 0;
    }
    scene_.verifier = GeometricContextVerifier::create(context);
    GeometricContextVerifier::Params start = context;
    start.minInliers = full ? minFullInliers : params.minInitialInliers;
    scene_.startVerifier = GeometricContextVerifier::create(start);
    stages_.filter.jointOffsets = stages_.filter.jointOffsets && params.jointOffsets;
    stages_.filter.pointNoise *= scale;
    stages_.filter.contourNoise *= scale;
    stages_.paperFilter.measurementNoise *= scale;
}

Ptr<PartFinder> ToolTrackerImpl::makeFinder(const Camera& camera, const std::vector<Ptr<ToolMethod> >& tools, const Ptr<MeshRenderer>& renderer) const
{
    const Ptr<PartTemplateRenderer> templates = PartTemplateRenderer::create(renderer, stages_.templates);
    for (size_t i = 0; i < tools.size(); i++) templates->addTool(tools[i]->model());
    return PartFinder::create(camera.model, templates, QGOMatcher::create(stages_.matcher), camera.eye_T_camera);
}

Ptr<ToolMethod> ToolTrackerImpl::makeMethod(int index, const Ptr<ToolModel>& model, const Matx44d& nominal_T_base) const
{
    const double scale = scene_.eyes[0]->pixelScale();
    if (params_.method == METHOD_FULL)
        return makePtr<FullMethod>(index, model, nominal_T_base, params_, scale, stages_.filter, stages_.contour, stages_.edges);
    return makePtr<PaperMethod>(index, model, nominal_T_base, params_, scale, scene_.camera(), stages_.paperFilter);
}

// Other tools or cameras. What knows all tools is made anew, and only then are they those; meshes that are prepared stay so.
void ToolTrackerImpl::change(std::vector<Ptr<ToolMethod> > tools, std::vector<Camera> cameras)
{
    std::vector<Ptr<PartFinder> > eyes;
    for (size_t e = 0; e < cameras.size(); e++)
    {
        eyes.push_back(makeFinder(cameras[e], tools, renderer_));
        eyes[e]->setMask(cameras[e].mask);
    }
    scene_.views.resize(tools.size());
    scene_.eyes.swap(eyes);
    tools_.swap(tools);
    cameras_.swap(cameras);
    for (size_t i = 0; i < tools_.size(); i++) tools_[i]->setIndex(int(i));
    field_ = scene_.camera().fieldOfView(Rect(Point(), scene_.camera().imageSize()));
    ahead_.release();   // its thread knows the old tools only
}

void ToolTrackerImpl::setRightCamera(const CameraModel& right, const Matx44d& right_T_left)
{
    if (params_.method != METHOD_FULL) CV_Error(Error::StsBadArg, "Params::method: only METHOD_FULL uses a right camera");
    CV_Assert(!right.imageSize().empty());
    const bool same = cameras_.size() > 1 && cameras_[1].model.imageSize() == right.imageSize();
    const Camera camera = {right, checkedPose(right_T_left, "right_T_left"), same ? cameras_[1].mask : Mat()};
    change(tools_, { cameras_[0], camera });
}

void ToolTrackerImpl::checkTool(int tool) const
{
    CV_Check(tool, tool >= 0 && tool < int(tools_.size()), "no such tool");
}

void ToolTrackerImpl::checkModel(const Ptr<ToolModel>& model) const
{
    CV_Assert(model);
    const int parts = int(model->keypoints().size());
    if (parts < params_.minInitialInliers)
        CV_Error(Error::StsBadArg, format("tool %s has %d keypoints, expected at least %d (Params::minInitialInliers)", model->name().c_str(),
                                          parts, params_.minInitialInliers));
}

int ToolTrackerImpl::addTool(const Ptr<ToolModel>& model, const Matx44d& nominal_T_base)
{
    checkModel(model);
    std::vector<Ptr<ToolMethod> > tools = tools_;
    tools.push_back(makeMethod(int(tools.size()), model, checkedPose(nominal_T_base, "nominal_T_base")));
    change(tools, cameras_);
    return int(tools_.size()) - 1;
}

void ToolTrackerImpl::replaceTool(int tool, const Ptr<ToolModel>& model)
{
    checkTool(tool);
    checkModel(model);
    const Ptr<ToolMethod> method = makeMethod(tool, model, tools_[tool]->nominal_T_base());
    method->inherit(*tools_[tool]);
    std::vector<Ptr<ToolMethod> > tools = tools_;
    tools[tool] = method;
    change(tools, cameras_);
}

void ToolTrackerImpl::removeTool(int tool)
{
    checkTool(tool);
    std::vector<Ptr<ToolMethod> > tools = tools_;
    tools.erase(tools.begin() + tool);
    change(tools, cameras_);
}

void ToolTrackerImpl::setHandEye(int tool, const Matx44d& nominal_T_base)
{
    checkTool(tool);
    tools_[tool]->setHandEye(checkedPose(nominal_T_base, "nominal_T_base"));
    if (ahead_) ahead_->clear();
}

void ToolTrackerImpl::moveCamera(const Matx44d& now_T_before)
{
    const Matx44d motion = checkedPose(now_T_before, "now_T_before");
    for (size_t i = 0; i < tools_.size(); i++) tools_[i]->moveCamera(motion);
    if (ahead_) ahead_->clear();
}

void ToolTrackerImpl::setMask(InputArray mask, int eye)
{
    CV_Check(eye, eye >= 0 && eye < int(cameras_.size()), "no such eye");
    const Mat copy = mask.getMat().clone();
    scene_.eyes[eye]->setMask(copy);
    cameras_[eye].mask = copy;
}

ReadingErrors ToolTrackerImpl::readingErrors(int tool) const
{
    checkTool(tool);
    return tools_[tool]->readingErrors();
}

void ToolTrackerImpl::setReadingErrors(int tool, const ReadingErrors& errors)
{
    checkTool(tool);
    tools_[tool]->setReadingErrors(errors);
    if (ahead_) ahead_->clear();
}

void ToolTrackerImpl::reset(int tool)
{
    if (tool != -1) checkTool(tool);
    if (ahead_) ahead_->clear();
    for (int i = 0; i < int(tools_.size()); i++)
        if (tool == -1 || i == tool) tools_[i]->reset();
}

Ptr<ToolTracker> ToolTracker::create(const CameraModel& camera, const Params& params, const Stages& stages, const Ptr<MeshRenderer>& renderer)
{
    return makePtr<ToolTrackerImpl>(camera, params, stages, renderer);
}

}} // namespace cv::surgtrack
