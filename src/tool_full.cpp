// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "tool_tracker.hpp"

// METHOD_FULL: parts and contours of all eyes, into one filter of correction and joint offsets.

namespace cv { namespace surgtrack {

namespace {

/* Contours are looked for several times, nearer each time; the filter believes an edge the less the farther it is beyond the
   tolerance. A first pose begins with the first window, one that is followed with the third. */
const int passes = 5, startPass = 0, trackPass = 2;
const double searchWindows[passes] = {16, 12, 8, 5, 3}, tolerances[passes] = {8, 5, 3, 1, 0};   // [pixel at 720 px image width]

const int minPoints = 4;               // parts that must have been found
const double supportWindow = 6, supportedWithin = 1.5;   // where edges are looked for, and which are the outline's [pixel at 720 px image width]

// The outline is drawn anew where a keypoint has moved farther than this since.
const double maxContourShift = 6;      // [pixel at 720 px image width]
const double maxContourTurn = 0.05;    // [rad]

// A push of the camera, or a slip: the constant state is no longer believed.
const double pushRotation = CV_PI / 180, pushTranslation = 0.002;   // [rad], [m]
const int pushedFrames = 10;
const double pushedNis = 0.75;         // of points, per degree of freedom
const double pushedLikelihood = 15;    // logarithm of the ratio, of contours

} // namespace

// Every eye's points, to be solved. Returns how many passed the gate.
int ToolTrackerImpl::addPoints(TrackedTool& tool)
{
    int passed = 0;
    for (size_t e = 0; e < open_; e++)
    {
        Eye& eye = eyes_[e];
        parts_.clear();
        imagePoints_.clear();
        for (size_t i = 0; i < eye.inliers.size(); i++)
        {
            parts_.push_back(eye.inliers[i].part);
            imagePoints_.push_back(eye.inliers[i].imagePoint);
        }
        passed += tool.full->addPoints(eye.camera, eye.eye_T_camera, parts_, imagePoints_, used_);
        if (e > 0) continue;
        tool.inliers.clear();
        for (size_t i = 0; i < used_.size(); i++)
            if (used_[i]) tool.inliers.push_back(eye.inliers[i]);
    }
    return passed;
}

// The filter after the points alone.
int ToolTrackerImpl::correctPoints(TrackedTool& tool)
{
    StageTimer timer(times_, FILTER);
    tool.full->begin();
    const int passed = addPoints(tool);
    if (passed < minPoints || !tool.full->solve()) return 0;
    tool.nis = tool.full->nis();
    return passed;
}

// The outline where the tool was drawn.
void ToolTrackerImpl::sampleContours(int index, const TemplateSet* ahead)
{
    StageTimer timer(times_, CONTOUR);
    for (size_t e = 0; e < open_; e++)
    {
        Eye& eye = eyes_[e];
        const bool fromAhead = e == 0 && ahead;
        const Rendering& rendering = fromAhead ? ahead->renderings[index] : eye.renderer->rendering();
        tools_[index].contour->sample(eye.camera, fromAhead ? ahead->views[index] : eye.views[index], rendering, index + 1, eye.outline);
        if (eye.reduction == 1 || eye.outline.empty()) continue;
        Rect2d box(eye.outline[0].imagePoint, Size2d());
        for (size_t i = 0; i < eye.outline.size(); i++) box |= Rect2d(eye.outline[i].imagePoint, Size2d(1, 1));
        const int reach = cvCeil(maxContourShift * pixelScale_ + 16);
        eye.reduce(Rect(cvFloor(box.x) - reach, cvFloor(box.y) - reach, cvCeil(box.width) + 2 * reach, cvCeil(box.height) + 2 * reach));
    }
}

static ToolView seenFrom(const Eye& eye, const ToolView& view)
{
    ToolView result = view;
    result.camera_T_base = eye.eye_T_camera * view.camera_T_base;
    return result;
}

// Edges on the normals of all eyes' outlines, taken in three times. Returns the log likelihood ratio of a push.
double ToolTrackerImpl::refine(TrackedTool& tool, int firstPass)
{
    StageTimer timer(times_, CONTOUR);
    double likelihood = 0;
    for (int pass = firstPass; pass < passes; pass++)
    {
        ContourSearch search;
        search.halfWindow = searchWindows[pass] * pixelScale_;
        tool.full->begin();
        addPoints(tool);
        for (size_t e = 0; e < open_; e++)
        {
            Eye& eye = eyes_[e];
            placeContour(eye.camera, seenFrom(eye, tool.full->view()), eye.outline);
            matchContour(eye.pixels(), eye.outline, search);
            tool.full->addContour(eye.camera, eye.eye_T_camera, eye.outline, tolerances[pass] * pixelScale_);
        }
        if (pass == firstPass) likelihood = tool.full->surprise(pushRotation / 2, pushTranslation / 2);
        tool.full->solve();
    }
    tool.contourSupport = support(tool);
    return likelihood;
}

// The share of the outline where the strongest edge around is the outline's.
double ToolTrackerImpl::support(const TrackedTool& tool)
{
    ContourSearch search;
    search.halfWindow = supportWindow * pixelScale_;
    search.preference = 0;
    search.ambiguity = 1;
    int supported = 0, all = 0;
    for (size_t e = 0; e < open_; e++)
    {
        Eye& eye = eyes_[e];
        placeContour(eye.camera, seenFrom(eye, tool.full->view()), eye.outline);
        matchContour(eye.pixels(), eye.outline, search);
        all += int(eye.outline.size());
        for (size_t i = 0; i < eye.outline.size(); i++)
            supported += eye.outline[i].found && std::abs(eye.outline[i].offset) < supportedWithin * pixelScale_;
    }
    return all ? double(supported) / all : 0;
}

// Whether the tool is so far from where it was drawn that its outline is another.
bool ToolTrackerImpl::movedSince(int index, const std::vector<ToolView>& drawn) const
{
    const TrackedTool& tool = tools_[index];
    const CameraModel& camera = eyes_[0].camera;
    const std::vector<ToolModel::Keypoint>& keypoints = tool.model->keypoints();
    const ToolView &now = tool.full->view(), &then = drawn[index];
    for (size_t k = 0; k < keypoints.size(); k++)
    {
        const Matx44d A = now.camera_T_base * now.base_T_link[keypoints[k].link], B = then.camera_T_base * then.base_T_link[keypoints[k].link];
        const Point3d p = transform(A, keypoints[k].linkPoint), q = transform(B, keypoints[k].linkPoint);
        if (p.z < 1e-3 || q.z < 1e-3) return true;
        const double shift = std::max(camera.fx * std::abs(p.x / p.z - q.x / q.z), camera.fy * std::abs(p.y / p.z - q.y / q.z));
        double cosine = -1;
        for (int r = 0; r < 3; r++)
            for (int c = 0; c < 3; c++) cosine += A(r, c) * B(r, c);
        if (!(shift <= maxContourShift * pixelScale_ && 0.5 * cosine >= std::cos(maxContourTurn))) return true;
    }
    return false;
}

bool ToolTrackerImpl::startFull(int index)
{
    TrackedTool& tool = tools_[index];
    tool.full->undo();
    const size_t open = open_;
    open_ = 1;
    eyes_[0].inliers = tool.inliers;
    for (int pass = 0; pass < 5; pass++)
    {
        if (pass == 1) open_ = open;
        if (pass > 0)
        {
            views_[index] = tool.full->view();
            for (size_t e = 0; e < open_; e++)
            {
                draw(index, eyes_[e]);
                if (pass < 4) locate(index, eyes_[e], eyes_[e].templates, params_.minWindow * pixelScale_, e == 0);
            }
            tool.visibleParts = int(eyes_[0].templates.size());
            sampleContours(index, 0);
        }
        if (pass == 0) { tool.full->reset();
        tool.full->predict(joints_[index]); }
        if (pass < 2) correctPoints(tool);
        if (pass > 0) refine(tool, pass > 2 ? trackPass : startPass);
    }
    open_ = open;
    tool.correction = tool.full->correction();
    const bool good = meanSimilarity(tool.inliers) >= params_.minInitialSimilarity && plausible(tool, tool.correction);
    if (!good)
    {
        tool.full->undo();
        tool.correction = tool.full->correction();
        tool.inliers.clear();
    }
    return good;
}

bool ToolTrackerImpl::measureFull(int index, const TemplateSet* ahead)
{
    TrackedTool& tool = tools_[index];
    if (!tool.usesDrawnAhead()) ahead = 0;
    for (size_t e = 0; e < open_; e++)
    {
        const std::vector<PartTemplate>& templates = e == 0 && ahead ? ahead->templates[index] : draw(index, eyes_[e]);
        locate(index, eyes_[e], templates, params_.minWindow * pixelScale_, false);
        if (e == 0) tool.visibleParts = int(templates.size());
    }
    tool.contourSupport = 0;
    int passed = correctPoints(tool);
    const std::vector<PartMatch>& matches = eyes_[0].inliers;
    if (matches.size() >= 5 && meanSimilarity(matches) > 0.55 && (2 * passed < int(matches.size()) || tool.full->nis() > pushedNis))
    {
        tool.full->inflate(pushRotation, pushTranslation);
        tool.boosted = pushedFrames;
        passed = correctPoints(tool);
    }
    if (passed < minPoints)
    {
        tool.full->undo();
        tool.inliers.clear();
        return false;
    }
    sampleContours(index, ahead);
    if (movedSince(index, ahead ? ahead->views : eyes_[0].views))
    {
        views_[index] = tool.full->view();
        for (size_t e = 0; e < open_; e++) draw(index, eyes_[e]);
        sampleContours(index, 0);
    }
    if (refine(tool, trackPass) > pushedLikelihood)
    {
        tool.full->inflate(pushRotation / 2, pushTranslation / 2);
        tool.boosted = std::max(tool.boosted, 3);
        correctPoints(tool);
        refine(tool, trackPass);
    }
    const bool found = tool.state != STATE_LOST || (int(tool.inliers.size()) >= params_.minInitialInliers
                                                    && meanSimilarity(tool.inliers) >= params_.minInitialSimilarity);
    if (!found || !plausible(tool, tool.full->correction()))
    {
        tool.full->undo();
        return false;
    }
    tool.correction = tool.full->correction();
    return true;
}

}} // namespace cv::surgtrack
