// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "base/geometry.hpp"
#include "track/tool_method.hpp"
#include "track/view_change.hpp"

namespace cv { namespace surgtrack {

namespace {

// Plausible errors of a hand-eye calibration; a first pose beyond them is a false one. Twice what the paper's recording has.
const double maxCorrectionAngle = 15 * CV_PI / 180;
const double maxCorrectionShift = 0.03;     // [m], at the tool
// What a push moves a tool by at least; estimates wander by half of it, from one posture to another.
const double leastMotionAngle = 2 * CV_PI / 180, leastMotionShift = 0.004;   // [rad], [m]
const double largestReprojectionError = 8;  // [pixel at 720 px image width]

// What a joint can read; beyond, a message was garbled, or is in another unit.
const double mostTravel = 10, mostTurn = 200 * CV_PI;    // [m], [rad]
const double leastMargin = 0.1, leastTurnMargin = CV_PI; // beyond limits, which may be those of the next instrument [m], [rad]

/* An image that comes again: pictures of a camera differ by its noise, in each pixel by a grey level and more, and those of a tool
   that has moved by a pixel by more than that. */
const double staleChange = 0.5;        // mean over samples [grey levels]
const double staleShift = 1;           // of a keypoint [pixel at 720 px image width]
const double staleMargin = 30;         // about the keypoints [pixel at 720 px image width]

std::vector<Vec2d> rangesOf(const ToolModel& model)
{
    const Mat_<double> limits = model.jointLimits();
    std::vector<Vec2d> ranges(limits.rows);
    for (int i = 0; i < limits.rows; i++)
    {
        bool slides = false;
        for (size_t l = 0; l < model.links().size(); l++)
            slides = slides || (model.links()[l].coordinate == i && model.links()[l].jointType == ToolModel::JOINT_PRISMATIC);
        const double most = slides ? mostTravel : mostTurn;
        const double margin = std::max(slides ? leastMargin : leastTurnMargin, limits(i, 1) - limits(i, 0));   // infinite without limits
        ranges[i] = Vec2d(std::max(-most, limits(i, 0) - margin), std::min(most, limits(i, 1) + margin));
    }
    return ranges;
}

const double turnOfStarts = 10 * CV_PI / 180;   // two and a half times what a calibration is taken to be off by in each direction [rad]

} // namespace

ToolMethod::ToolMethod(int index, const Ptr<ToolModel>& model, const Matx44d& nominal_T_base, const ToolTracker::Params& params, double pixelScale)
    : index_(index), model_(model), coordinates_(model->coordinateNames().size()), nominal_T_base_(nominal_T_base), params_(params),
      pixelScale_(pixelScale), ranges_(rangesOf(*model)), sights_(2)
{
    // All that a frame may need: update() takes no memory later.
    const size_t parts = model->keypoints().size();
    nominalPoints_.reserve(parts);
    inliers_.reserve(parts);
    joints_.reserve(coordinates_);
    before_.nominalPoints_.reserve(parts);
    before_.inliers_.reserve(parts);
    before_.joints_.reserve(coordinates_);
    bounded_.reserve(coordinates_);
    for (size_t e = 0; e < sights_.size(); e++) sights_[e].found.inliers.reserve(parts);
    ToolMethod::reset();
}

void ToolMethod::reset()
{
    correction_ = calibration_ = settled_ = Matx44d::eye();
    isSettled_ = false;
    state_ = STATE_INITIALIZING;
    confirmed_ = 0;
    lastSeen_ = -DBL_MAX;
    evidence_ = Evidence();
    visibleParts_ = 0;
    inliers_.clear();
    joints_.clear();
    shownJoints_.assign(coordinates_, 0.);
    skipped_ = 0;
}

bool ToolMethod::bound(const std::vector<double>& readings, std::vector<double>& bounded) const
{
    bounded.resize(readings.size());
    for (size_t i = 0; i < readings.size(); i++) bounded[i] = std::min(std::max(readings[i], ranges_[i][0]), ranges_[i][1]);
    return bounded == readings;
}

void ToolMethod::place(const std::vector<double>& joints, double seconds)
{
    before_ = *this;
    const bool possible = bound(joints, bounded_);
    if (possible || joints_.empty()) joints_ = bounded_;
    skipped_ += !possible;
    placeKeypoints(predict(joints_, seconds));
}

void ToolMethod::placeKeypoints(const ToolView& view)
{
    const std::vector<ToolModel::Keypoint>& keypoints = model_->keypoints();
    nominalPoints_.resize(keypoints.size());
    for (size_t k = 0; k < keypoints.size(); k++)
        nominalPoints_[k] = transform(nominal_T_base_ * view.base_T_link[keypoints[k].link], keypoints[k].linkPoint);
}

void ToolMethod::foresee(const std::vector<double>& readings, ToolView& view)
{
    bound(readings, bounded_);
    correctJoints(bounded_, foreseen_);
    model_->forwardKinematics(foreseen_, view.base_T_link);
    view.camera_T_base = correction_ * nominal_T_base_;
    if (!isLocated()) view.base_T_link.clear();
}

Matx44d ToolMethod::cameraMotion() const
{
    if (!isSettled_) return Matx44d::eye();
    const Matx44d motion = correction_ * rigidInverse(settled_);
    const Point3d at = transform(settled_, nominalPoints_[0]);
    return turnOf(motion) > leastMotionAngle || norm(transform(motion, at) - at) > leastMotionShift ? motion : Matx44d::eye();
}

Matx44d ToolMethod::cameraStep() const
{
    if (state_ != STATE_TRACKING || before_.state_ != STATE_TRACKING) return Matx44d::eye();
    return correction_ * rigidInverse(before_.correction_);
}

double ToolMethod::maxReprojectionError() const
{
    return largestReprojectionError * pixelScale_;
}

bool ToolMethod::plausible(const CameraModel& camera, const Matx44d& correction, const std::vector<PartMatch>& inliers) const
{
    Point3d centre;
    for (size_t i = 0; i < nominalPoints_.size(); i++) centre += nominalPoints_[i] * (1. / nominalPoints_.size());
    if (turnOf(correction) > maxCorrectionAngle || norm(transform(correction, centre) - centre) > maxCorrectionShift) return false;
    if (inliers.empty()) return true;
    double sum = 0;
    for (size_t i = 0; i < inliers.size(); i++)
    {
        const Point3d p = transform(correction, nominalPoints_[inliers[i].part]);
        if (p.z < nearestDepth) return false;
        const Point2d d = camera.project(p) - inliers[i].imagePoint;
        sum += d.dot(d);
    }
    return std::sqrt(sum / double(inliers.size())) < maxReprojectionError();
}

// Whether the image is the one before once more, although the tool has moved.
bool ToolMethod::isStale(const Scene& scene)
{
    const PartFinder& eye = *scene.eyes[0];
    Rect2d box;
    for (size_t k = 0; k < nominalPoints_.size(); k++)
    {
        const Point3d p = transform(correction_, nominalPoints_[k]);
        if (p.z < nearestDepth) continue;
        const Rect2d at(eye.camera().project(p), Size2d(1, 1));
        box = box.empty() ? at : box | at;
    }
    const int margin = cvRound(staleMargin * pixelScale_);
    box &= Rect2d(-1e5, -1e5, 2e5, 2e5);   // what an int has room for
    const Rect region(cvFloor(box.x) - margin, cvFloor(box.y) - margin, cvCeil(box.width) + 2 * margin, cvCeil(box.height) + 2 * margin);
    if (eye.change(region & Rect(Point(), eye.camera().imageSize())) > staleChange)
    {
        shownJoints_ = joints_;
        return false;
    }
    correctJoints(shownJoints_, foreseen_);
    model_->forwardKinematics(foreseen_, shown_.base_T_link);
    shown_.camera_T_base = view().camera_T_base;
    return !(viewChange(eye.camera(), *model_, view(), shown_).shift < staleShift * pixelScale_);
}

Matx44d ToolMethod::startTurn(int attempt, const Point3d& at)
{
    static const Vec3d axes[] = {Vec3d(0, 0, 0), Vec3d(1, 0, 0), Vec3d(0, 1, 0), Vec3d(-1, 0, 0), Vec3d(0, -1, 0)};
    const Matx33d R = exponential(turnOfStarts * axes[attempt % 5]);
    return rigidTransform(R, at - R * at);
}

int ToolMethod::findStarts(Scene& scene, int first, int last, const ToolView& view, double distance, std::vector<StartCandidate>& best)
{
    static const double scales[] = {1, 0.8, 1.2}, rotations[] = {0, -15 * CV_PI / 180, 15 * CV_PI / 180};
    Sight& sight = sights_[0];
    const PartWindows windows(params_.initialWindow * std::max(scene.camera().fx, scene.camera().fy) / std::max(distance, 0.02));
    int templates = 0;
    for (int i = first; i <= last; i++)
    {
        scene.draw(0, index_, view, sight.drawing, scales[i / 3], rotations[i % 3], true);
        scene.find(0, sight.drawing, windows, true, sight.found);
        if (i == first) templates = int(sight.drawing.templates.size());
        StartCandidate candidate;
        candidate.inliers = sight.found.inliers;
        candidate.templates = int(sight.drawing.templates.size());
        for (size_t k = 0; k < candidate.inliers.size(); k++) candidate.score += candidate.inliers[k].similarity;
        for (size_t k = 0; k < best.size(); k++)
            if (candidate.score > best[k].score)
            {
                best.insert(best.begin() + k, candidate);
                best.pop_back();
                break;
            }
    }
    return templates;
}

void ToolMethod::expect(const PartDrawing& ahead, const CameraModel& camera, PartWindows& windows) const
{
    windows.expected.assign(nominalPoints_.size(), Point2d());
    for (size_t i = 0; i < ahead.templates.size(); i++)
    {
        const PartTemplate& t = ahead.templates[i];
        const Point3d p = transform(correction_, nominalPoints_[t.part]);
        windows.expected[t.part] = p.z > nearestDepth ? camera.project(p) : t.imagePoint;
    }
}

void ToolMethod::look(Scene& scene, size_t eye, const ToolView& view, const PartWindows& windows, bool starting)
{
    Sight& sight = sights_[eye];
    scene.draw(eye, index_, view, sight.drawing);
    sight.drawnAhead = false;
    sight.cut = sight.drawn = &sight.drawing;
    scene.find(eye, sight.drawing, windows, starting, sight.found);
}

void ToolMethod::lookAhead(Scene& scene, const PartDrawing& ahead, PartWindows& windows)
{
    Sight& sight = sights_[0];
    expect(ahead, scene.camera(), windows);
    sight.drawnAhead = true;
    sight.cut = sight.drawn = &ahead;
    scene.find(0, ahead, windows, false, sight.found);
}

ToolSight ToolMethod::sight(size_t eye) const
{
    const Sight& from = sights_[eye];
    ToolSight result;
    if (!from.drawnAhead)
    {
        result.views = from.drawing.views;
        result.templates = from.drawing.templates;
        result.enlargement = from.drawing.enlargement;
        result.rendering.create(from.drawing.rendering.window);
        from.drawing.rendering.depth.copyTo(result.rendering.depth);
        from.drawing.rendering.ids.copyTo(result.rendering.ids);
        from.drawing.rendering.shading.copyTo(result.rendering.shading);
    }
    result.found = from.found;
    result.outline = from.outline;
    return result;
}

void ToolMethod::report(ToolEstimate& e) const
{
    e.state = state_;
    e.camera_T_nominal = correction_;
    e.camera_T_tool = correction_ * (nominal_T_base_ * model_->endEffectorFromLinks(view().base_T_link));
    e.jointOffsets.assign(coordinates_, 0.);
    e.joints.assign(joints_.begin(), joints_.end());
    e.visibleParts = visibleParts_;
    e.inliers = int(inliers_.size());
    e.similarity = evidence_.similarity;
    e.contourSupport = evidence_.support;
    e.nis = evidence_.nis;
    e.skippedReadings = skipped_;
    e.matches.reserve(inliers_.capacity());
    e.matches = inliers_;
}

}} // namespace cv::surgtrack
