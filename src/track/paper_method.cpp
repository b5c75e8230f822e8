// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "track/tool_tracker.hpp"

namespace cv { namespace surgtrack {

namespace {

const int hypotheses = 9;   // of scale and rotation

// Plausible errors of a hand-eye calibration; a first pose beyond them is a false one.
const double maxCorrectionAngle = 15 * CV_PI / 180;
const double maxCorrectionShift = 0.03;     // [m], at the tool
const double maxReprojectionError = 8;      // [pixel at 720 px image width]

double rotationAngle(const Matx44d& T)
{
    return std::acos(std::min(1., std::max(-1., (T(0, 0) + T(1, 1) + T(2, 2) - 1) / 2)));
}

} // namespace

// The first pose: all hypotheses at once.
bool ToolTrackerImpl::start(int index)
{
    return initialize(index, 0, hypotheses - 1);
}

// A lost tool is looked for in a wider window, by one hypothesis a frame.
bool ToolTrackerImpl::search(int index)
{
    int& hypothesis = tools_[index].hypothesis;
    hypothesis = (hypothesis + 1) % hypotheses;
    return initialize(index, hypothesis, hypothesis);
}

bool ToolTrackerImpl::plausible(const TrackedTool& tool, const Matx44d& correction) const
{
    Point3d centre;
    for (size_t i = 0; i < tool.nominalPoints.size(); i++) centre += tool.nominalPoints[i] * (1. / tool.nominalPoints.size());
    if (rotationAngle(correction) > maxCorrectionAngle || norm(transform(correction, centre) - centre) > maxCorrectionShift) return false;
    if (tool.inliers.empty()) return true;
    double sum = 0;
    for (size_t i = 0; i < tool.inliers.size(); i++)
    {
        const Point3d p = transform(correction, tool.nominalPoints[tool.inliers[i].part]);
        if (p.z < 1e-3) return false;
        const Point2d d = eyes_[0].camera.project(p) - tool.inliers[i].imagePoint;
        sum += d.dot(d);
    }
    return std::sqrt(sum / double(tool.inliers.size())) < maxReprojectionError * pixelScale_;
}

// Several scales and rotations about the kinematics' pose (paper, Sec. 2.1), the best agreement goes to EPnP (Sec. 2.3).
// first, last: which of the nine hypotheses
bool ToolTrackerImpl::initialize(int index, int first, int last)
{
    static const double scales[] = {1, 0.8, 1.2}, rotations[] = {0, -15 * CV_PI / 180, 15 * CV_PI / 180};
    TrackedTool& tool = tools_[index];
    Eye& eye = eyes_[0];
    const double distance = transform(tool.correction, tool.nominalPoints[0]).z;
    const double halfWindow = params_.initialWindow * std::max(eye.camera.fx, eye.camera.fy) / std::max(distance, 0.02);
    tool.inliers.clear();
    double bestScore = 0;
    for (int i = first; i <= last; i++)
    {
        const std::vector<PartTemplate>& templates = draw(index, eye, scales[i / 3], rotations[i % 3], true);
        locate(index, eye, templates, halfWindow, true);
        if (i == first) tool.visibleParts = int(templates.size());
        double score = 0;
        for (size_t k = 0; k < eye.inliers.size(); k++) score += eye.inliers[k].similarity;
        if (score <= bestScore) continue;
        bestScore = score;
        tool.inliers = eye.inliers;
        tool.visibleParts = int(templates.size());
    }
    Matx44d correction;
    {
        StageTimer timer(times_, FILTER);
        gather(tool);
        if (tool.inliers.empty() || !solveEPnP(eye.camera, nominalPoints_, imagePoints_, correction, maxReprojectionError * pixelScale_)
            || !plausible(tool, correction))
        {
            tool.inliers.clear();
            return false;
        }
    }
    const Matx44d before = tool.correction;
    tool.filter->reset(correction);
    tool.correction = correction;
    if (params_.method == METHOD_EPNP || startFromHandEye(index)) return true;
    tool.correction = before;
    tool.filter->reset(before);
    tool.inliers.clear();
    return false;
}

// The filter after the points of this frame and the hand-eye calibration, whose error is of a known size, and nothing else.
// Returns false for points that such a calibration does not explain, as after a move of the camera: then at the last correction.
bool ToolTrackerImpl::correctFromHandEye(TrackedTool& tool)
{
    tool.filter->reset(Matx44d::eye());
    if (tool.filter->correct(nominalPoints_, imagePoints_, used_) && 2 * countNonZero(used_) > int(used_.size())) return true;
    tool.filter->reset(tool.correction);
    return false;
}

/* The paper's filter starts from EPnP's pose, whose depth is off by 5 mm and more, and from templates of another scale. Ours takes
   the same points in from the hand-eye calibration and looks again with templates that fit.
   Returns whether the tool then looks as it should; tissue does not. */
bool ToolTrackerImpl::startFromHandEye(int index)
{
    TrackedTool& tool = tools_[index];
    Eye& eye = eyes_[0];
    for (int pass = 0; pass < 3; pass++)
    {
        if (pass > 0)
        {
            views_[index].camera_T_base = tool.correction * tool.nominal_T_base;
            const std::vector<PartTemplate>& templates = draw(index, eye);
            locate(index, eye, templates, params_.minWindow * pixelScale_, true);
            if (eye.inliers.empty()) return false;
            tool.inliers = eye.inliers;
            tool.visibleParts = int(templates.size());
        }
        StageTimer timer(times_, FILTER);
        gather(tool);
        if (correctFromHandEye(tool)) tool.correction = tool.filter->correction();
    }
    return meanSimilarity(tool.inliers) >= params_.minInitialSimilarity && plausible(tool, tool.correction);
}

}} // namespace cv::surgtrack
