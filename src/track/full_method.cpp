// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "track/tool_tracker.hpp"

// METHOD_FULL: parts and contours of all eyes, into one filter of correction and joint offsets.

namespace cv { namespace surgtrack {

namespace {

/* Contours are looked for several times, nearer each time; the filter believes an edge the less the farther it is beyond the
   tolerance. A first pose begins with the first window, one that is followed with the third. */
const int passes = 5, startPass = 0, trackPass = 2;
const double searchWindows[passes] = {16, 12, 8, 5, 3}, tolerances[passes] = {8, 5, 3, 1, 0};   // [pixel at 720 px image width]

const double leastWindow = 2;          // of small images, too [pixel]

const int minPoints = 4;               // parts that must have been found

// A first pose.
const double startScales[] = {1, 0.8, 1.2}, startRotations[] = {0, -15 * CV_PI / 180, 15 * CV_PI / 180};   // hypotheses
const int fitted = 3, fitRounds = 4;   // so many hypotheses are fitted, in so many rounds

/* Evidence: mean similarity of the parts plus support of the outline. Parts that a similar pose would show look alike, and so do
   edges of tissue, but not both at once: right poses have 1.2 to 1.8, wrong ones up to 1.1. */
const double sureEvidence = 1.25, startEvidence = 1.12, trackEvidence = 0.9;
const double sureNis = 0.6;             // of points, per degree of freedom
const double doubt = 0.25;              // of evidence, by NIS, where first poses are compared
const double startSupport = 0.45;       // of an outline that was not followed until now
const double leastSupport = 0.3, leastSimilarity = 0.5, outlineAlone = 0.55;
const double searchRotation = 4 * CV_PI / 180, searchTranslation = 0.008;   // how far a lost tool may be from where it was [rad, m]

struct Candidate
{
    Candidate() : score(0) {}
    double score;
    std::vector<PartMatch> inliers;
};

const double supportWindow = 6, supportedWithin = 1.5;   // where edges are looked for, and which are the outline's [pixel at 720 px image width]

// The outline is drawn anew where a keypoint has moved farther than this since.
const double maxContourShift = 6;      // [pixel at 720 px image width]
const double maxContourTurn = 0.05;    // [rad]

// Points that look less like their templates are placed less well.
const double clearSimilarity = 0.8, noiseOfDissimilarity = 4;

// A push of the camera, or a slip: the constant state is no longer believed.
const double pushRotation = CV_PI / 180, pushTranslation = 0.002;   // [rad], [m]
const double pushedGain = 0.05;        // of evidence, least
const int pushedFrames = 10;
const int settlingFrames = 15;         // after a first pose, which may be the wrong one of two that look alike in one frame
const double pushedSimilarity = 0.55;  // of all points that agree
const double pushedNis = 0.75;         // of points, per degree of freedom
const double pushedLikelihood = 2;     // logarithm of the ratio; 99 of 100 frames without a push have less than 1

} // namespace

// 0 where the parts or the outline do not tell the tool from tissue at all.
static double evidence(const TrackedTool& tool)
{
    const double similarity = meanSimilarity(tool.inliers);
    return similarity < leastSimilarity || tool.contourSupport < leastSupport ? 0 : similarity + tool.contourSupport;
}

// Enough for a pose that does not follow from the frame before.
static bool isSure(const TrackedTool& tool)
{
    return evidence(tool) >= startEvidence && tool.contourSupport >= startSupport;
}

// Every eye's points, to be solved. Returns how many passed the gate.
int ToolTrackerImpl::addPoints(TrackedTool& tool, double tolerance)
{
    int passed = 0;
    for (size_t e = 0; e < open_; e++)
    {
        Eye& eye = eyes_[e];
        parts_.clear();
        imagePoints_.clear();
        noise_.clear();
        for (size_t i = 0; i < eye.inliers.size(); i++)
        {
            noise_.push_back(1 + noiseOfDissimilarity * std::max(0., clearSimilarity - eye.inliers[i].similarity));
            parts_.push_back(eye.inliers[i].part);
            imagePoints_.push_back(eye.inliers[i].imagePoint);
        }
        passed += tool.full->addPoints(eye.camera, eye.eye_T_camera, parts_, imagePoints_, used_, noise_, tolerance);
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
    const int passed = addPoints(tool, DBL_MAX);
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

// The tool as it is believed to be, in the frame of the eye.
const ToolView& ToolTrackerImpl::seenFrom(const Eye& eye, const TrackedTool& tool)
{
    seen_ = tool.full->view();
    seen_.camera_T_base = eye.eye_T_camera * seen_.camera_T_base;
    return seen_;
}

// Edges on the normals of all eyes' outlines, taken in three times. Returns the log likelihood ratio of a push.
double ToolTrackerImpl::refine(TrackedTool& tool, int firstPass)
{
    StageTimer timer(times_, CONTOUR);
    double likelihood = 0;
    for (int pass = firstPass; pass < passes; pass++)
    {
        ContourSearch search;
        search.halfWindow = std::max(leastWindow, searchWindows[pass] * pixelScale_);
        tool.full->begin();
        addPoints(tool, tolerances[pass] * pixelScale_);
        for (size_t e = 0; e < open_; e++)
        {
            Eye& eye = eyes_[e];
            placeContour(eye.camera, seenFrom(eye, tool), eye.outline);
            matchContour(eye.pixels(), eye.outline, search);
            if (params_.contours) tool.full->addContour(eye.camera, eye.eye_T_camera, eye.outline, tolerances[pass] * pixelScale_);
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
    search.halfWindow = std::max(leastWindow, supportWindow * pixelScale_);
    search.preference = 0;
    search.ambiguity = 1;
    int supported = 0, all = 0;
    for (size_t e = 0; e < open_; e++)
    {
        Eye& eye = eyes_[e];
        placeContour(eye.camera, seenFrom(eye, tool), eye.outline);
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

// Everything from the filter's prediction, which is vague, and the parts found: in several rounds, each drawn where the one before ended. The one
// that explains the image best is kept: the next may end in the wrong one of two depths.
void ToolTrackerImpl::fit(int index, const std::vector<PartMatch>& inliers)
{
    TrackedTool& tool = tools_[index];
    const size_t open = open_;
    open_ = 1;   // the first matches are of one eye
    eyes_[0].inliers = inliers;
    correctPoints(tool);
    open_ = open;
    double most = -DBL_MAX, support = 0, nis = 0;
    for (int round = 0; round < fitRounds; round++)
    {
        views_[index] = tool.full->view();
        for (size_t e = 0; e < open_; e++)
        {
            draw(index, eyes_[e]);
            if (round < fitRounds - 1) locate(index, eyes_[e], eyes_[e].templates, params_.minWindow * pixelScale_, e == 0);
        }
        tool.visibleParts = int(eyes_[0].templates.size());
        sampleContours(index, 0);
        if (round == 0) correctPoints(tool);
        refine(tool, round < 2 ? startPass : trackPass);
        const double merit = evidence(tool) - doubt * tool.nis;
        if (merit < most) continue;
        most = merit;
        support = tool.contourSupport;
        nis = tool.nis;
        tool.full->copyTo(*tool.round);
        tool.inliersOfRound = tool.inliers;
    }
    tool.round->copyTo(*tool.full);
    tool.inliers = tool.inliersOfRound;
    tool.contourSupport = support;
    tool.nis = nis;
}

/* The first pose, or that of a lost tool: parts in wide windows by several scales and rotations about the pose predicted (paper,
   Sec. 2.1), the most promising of them fitted, and the one kept that explains the image best.
   first, last: which of the nine hypotheses */
bool ToolTrackerImpl::beginAnew(int index, int first, int last)
{
    TrackedTool& tool = tools_[index];
    Eye& eye = eyes_[0];
    tool.full->copyTo(*tool.before);
    const double distance = std::max(transform(tool.full->correction(), tool.nominalPoints[0]).z, 0.02);
    const double halfWindow = params_.initialWindow * std::max(eye.camera.fx, eye.camera.fy) / distance;
    Candidate best[fitted];
    for (int i = first; i <= last; i++)
    {
        views_[index] = tool.full->view();
        const std::vector<PartTemplate>& templates = draw(index, eye, startScales[i / 3], startRotations[i % 3], true);
        locate(index, eye, templates, halfWindow, true);
        if (i == first) tool.visibleParts = int(templates.size());
        double score = 0;
        for (size_t k = 0; k < eye.inliers.size(); k++) score += eye.inliers[k].similarity;
        for (int k = 0; k < fitted; k++)
            if (score > best[k].score)
            {
                for (int l = fitted - 1; l > k; l--) std::swap(best[l], best[l - 1]);
                best[k].score = score;
                best[k].inliers = eye.inliers;
                break;
            }
    }
    double most = -DBL_MAX, support = 0, nis = 0;
    tool.inliersBefore.clear();
    for (int k = 0; k < fitted && best[k].score > 0; k++)
    {
        if (k > 0) tool.before->copyTo(*tool.full);
        fit(index, best[k].inliers);
        const double merit = evidence(tool) - doubt * tool.nis;
        if (merit <= most || !isSure(tool) || int(tool.inliers.size()) <= minPoints || !plausible(tool, tool.full->correction())) continue;
        most = merit;
        tool.full->copyTo(*tool.best);
        tool.inliersBefore = tool.inliers;
        support = tool.contourSupport;
        nis = tool.nis;
    }
    const bool found = most > -DBL_MAX;
    (found ? tool.best : tool.before)->copyTo(*tool.full);
    tool.inliers = tool.inliersBefore;
    tool.contourSupport = support;
    tool.nis = nis;
    if (found) tool.boosted = settlingFrames;
    return found;
}

// Where the camera has moved since its calibration, the tools' corrections are about the same. Unit if no other tool is tracked.
Matx44d ToolTrackerImpl::correctionOfAnother(int index) const
{
    for (int i = 0; i < int(tools_.size()); i++)
        if (i != index && tools_[i].state == STATE_TRACKING) return tools_[i].correction;
    return Matx44d::eye();
}

// About the hand-eye calibration, and every other time about what has become of it for another tool.
bool ToolTrackerImpl::startFull(int index)
{
    TrackedTool& tool = tools_[index];
    tool.full->reset(tool.searches++ % 2 ? correctionOfAnother(index) : Matx44d::eye());
    tool.full->predict(joints_[index]);
    return beginAnew(index, 0, 8);
}

// One hypothesis a frame, the upright one every other time: about the last pose, the hand-eye calibration, another tool's correction.
bool ToolTrackerImpl::searchFull(int index)
{
    TrackedTool& tool = tools_[index];
    const int n = tool.searches++;
    const int hypothesis = n % 2 == 0 ? 0 : 1 + (n / 2) % 8;
    tool.full->copyTo(*tool.before);
    if (n % 4 < 2) tool.full->inflate(searchRotation, searchTranslation);
    else
    {
        tool.full->reset(n % 8 < 4 ? Matx44d::eye() : correctionOfAnother(index));
        tool.full->predict(joints_[index]);
    }
    // beginAnew() has its own memory of the vague filter
    Ptr<ArticulatedPoseEKF> before = tool.before;
    tool.before = tool.spare;
    const bool found = beginAnew(index, hypothesis, hypothesis);
    tool.spare = tool.before;
    tool.before = before;
    if (!found) tool.before->copyTo(*tool.full);
    else if (!tool.searched) tool.confirmed = 0;
    tool.searched = found;
    return found;
}

void ToolTrackerImpl::dropPoints(TrackedTool& tool)
{
    tool.full->undo();
    tool.inliers.clear();
    for (size_t e = 0; e < open_; e++) eyes_[e].inliers.clear();
    tool.nis = 0;
    tool.points = false;
}

void ToolTrackerImpl::correctByOutline(int index, const TemplateSet* ahead)
{
    dropPoints(tools_[index]);
    views_[index] = tools_[index].full->view();
    if (!ahead)   // the push may have had it drawn elsewhere
        for (size_t e = 0; e < open_; e++) draw(index, eyes_[e]);
    sampleContours(index, ahead);
    refine(tools_[index], trackPass);
}

/* Points, then contours, from the filter's prediction. ahead: where the outline was drawn, if not in this frame
   Returns whether all this, with a push before, is that much likelier than without. */
bool ToolTrackerImpl::correctFull(int index, const TemplateSet* ahead)
{
    TrackedTool& tool = tools_[index];
    const std::vector<PartMatch>& matches = eyes_[0].inliers;
    const int passed = correctPoints(tool);
    bool pushed = int(matches.size()) > minPoints && meanSimilarity(matches) > pushedSimilarity
                  && (2 * passed < int(matches.size()) || tool.nis > pushedNis);
    if (passed < minPoints) dropPoints(tool);   // the outline alone may do
    tool.points = passed >= minPoints;
    sampleContours(index, ahead);
    if (movedSince(index, ahead ? ahead->views : eyes_[0].views))
    {
        views_[index] = tool.full->view();
        for (size_t e = 0; e < open_; e++) draw(index, eyes_[e]);
        sampleContours(index, 0);
    }
    return refine(tool, trackPass) > pushedLikelihood || pushed;
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
    if (correctFull(index, ahead) && params_.adaptation)
    {
        // A push is believed if it explains what is seen better.
        tool.full->copyTo(*tool.before);
        tool.inliersBefore = tool.inliers;
        const double without = evidence(tool), support = tool.contourSupport, nis = tool.nis;
        const bool points = tool.points;
        tool.full->inflate(pushRotation, pushTranslation);
        correctFull(index, ahead);
        if (evidence(tool) > without + pushedGain) tool.boosted = pushedFrames;
        else
        {
            tool.before->copyTo(*tool.full);
            tool.inliers = tool.inliersBefore;
            tool.contourSupport = support;
            tool.nis = nis;
            tool.points = points;
            if (nis > pushedNis) correctByOutline(index, ahead);   // the set of points is a false one
        }
    }
    // A first pose that is to be confirmed, and one after a gap, need more; an outline alone only continues.
    const bool follows = tool.state == STATE_TRACKING;
    const bool seen = tool.points ? (follows ? evidence(tool) >= trackEvidence : isSure(tool))
                                  : (follows || tool.state == STATE_COASTING) && tool.contourSupport >= outlineAlone;
    if (seen && plausible(tool, tool.full->correction())) return true;
    tool.full->undo();
    tool.inliers.clear();
    return false;
}

// The state after a frame.
void ToolTrackerImpl::concludeFull(TrackedTool& tool, bool seen)
{
    if (seen)
    {
        tool.lastSeen = time_;
        tool.unseen = 0;
        tool.confirmed++;
        const bool strong = tool.state == STATE_INITIALIZING && evidence(tool) >= sureEvidence && tool.nis <= sureNis && int(tool.inliers.size()) >= params_.minInitialInliers;
        const bool followed = !tool.searched && (tool.state == STATE_TRACKING || tool.state == STATE_COASTING);
        if (!followed && tool.state == STATE_TRACKING) tool.state = STATE_COASTING;   // found elsewhere: to be confirmed
        if (followed || strong || tool.confirmed > params_.confirmFrames)
        {
            tool.state = STATE_TRACKING;
            tool.searches = 0;
            tool.searched = false;
            tool.full->copyTo(*tool.sure);
        }
    }
    else
    {
        tool.unseen++;
        tool.confirmed = 0;
        tool.inliers.clear();
        tool.nis = 0;
        if (tool.searched) tool.sure->copyTo(*tool.full);   // the pose of the search was a false one
        tool.searched = false;
        if (tool.state == STATE_TRACKING) tool.state = STATE_COASTING;
        if (tool.state == STATE_COASTING && time_ - tool.lastSeen > params_.coastingTime) tool.state = STATE_LOST;
    }
    tool.correction = tool.full->correction();
    tool.similarity = meanSimilarity(tool.inliers);
}

}} // namespace cv::surgtrack
