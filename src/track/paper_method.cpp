// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "base/geometry.hpp"
#include "track/paper_method.hpp"

namespace cv { namespace surgtrack {

PaperMethod::PaperMethod(int index, const Ptr<ToolModel>& model, const Matx44d& nominal_T_base, const ToolTracker::Params& params, double pixelScale,
                         const CameraModel& camera, const ToolPoseEKF::Params& filter)
    : ToolMethod(index, model, nominal_T_base, params, pixelScale), camera_(camera), filter_(ToolPoseEKF::create(camera, filter)),
      filterBefore_(ToolPoseEKF::create(camera, filter))
{
    const size_t parts = model->keypoints().size();
    nominalInliers_.reserve(parts);
    imageInliers_.reserve(parts);
    used_.reserve(parts);
    windows_.deviations.reserve(parts);
    windows_.expected.reserve(parts);
    reset();
}

void PaperMethod::reset()
{
    ToolMethod::reset();
    filter_->reset(Matx44d::eye());
    trusted_ = Matx44d::eye();
    hypothesis_ = attempts_ = 0;
}

void PaperMethod::takeBack()
{
    ToolMethod::takeBack();
    static_cast<PaperMemory&>(*this) = before_;
    filterBefore_->copyTo(*filter_);
}

const ToolView& PaperMethod::predict(const std::vector<double>& joints, double)
{
    before_ = *this;
    filter_->copyTo(*filterBefore_);
    model_->forwardKinematics(joints, view_.base_T_link);
    view_.camera_T_base = correction_ * nominal_T_base_;
    return view_;
}

void PaperMethod::setCorrection(const Matx44d& correction)
{
    correction_ = correction;
    filter_->reset(correction);
}

void PaperMethod::gather()
{
    nominalInliers_.clear();
    imageInliers_.clear();
    for (size_t i = 0; i < inliers_.size(); i++)
    {
        nominalInliers_.push_back(nominalPoints_[inliers_[i].part]);
        imageInliers_.push_back(inliers_[i].imagePoint);
    }
}

void PaperMethod::measure(Scene& scene, const PartDrawing* ahead)
{
    const bool stale = !starts() && isStale(scene);
    if (starts()) shownJoints_ = joints_;
    if (!starts()) attempts_ = 0;
    bool seen = starts() ? start(scene, 0, hypotheses - 1) : !stale && follow(scene, ahead);
    if (!seen && !stale && state_ == STATE_LOST)   // in a wider window, by one hypothesis a frame
    {
        hypothesis_ = (hypothesis_ + 1) % hypotheses;
        seen = start(scene, hypothesis_, hypothesis_);
    }
    conclude(scene, seen);
    view_.camera_T_base = correction_ * nominal_T_base_;
}

// One template a part at the last correction, then the filter (paper, Sec. 2.3).
bool PaperMethod::follow(Scene& scene, const PartDrawing* ahead)
{
    const bool filtered = params_.method == METHOD_PAPER;
    if (filtered) filter_->predict();
    const Sight& sight = sights_[0];
    windows_.halfWidth = minWindow();
    windows_.deviations.clear();
    windows_.expected.clear();
    for (size_t k = 0; filtered && k < nominalPoints_.size(); k++)
    {
        const Matx22d C = filter_->imageCovariance(nominalPoints_[k]);
        windows_.deviations.push_back(Point2d(std::sqrt(C(0, 0)), std::sqrt(C(1, 1))));
    }
    if (ahead) lookAhead(scene, *ahead, windows_);
    else look(scene, 0, view_, windows_, false);
    inliers_ = sight.found.inliers;
    visibleParts_ = int(sight.cut->templates.size());
    if (inliers_.empty()) return false;

    StageTimer timer(scene.times, FILTER);
    gather();
    if (filtered) return correct();
    Matx44d correction;
    if (!solveEPnP(camera_, nominalInliers_, imageInliers_, correction) || !plausible(camera_, correction, inliers_)) return false;
    correction_ = correction;
    return true;
}

// The filter after the points gathered.
bool PaperMethod::correct()
{
    if (!(settles() && correctFromHandEye()) && !filter_->correct(nominalInliers_, imageInliers_, used_)) return false;
    size_t kept = 0;
    for (size_t i = 0; i < used_.size(); i++)
        if (used_[i]) inliers_[kept++] = inliers_[i];
    inliers_.resize(kept);
    // A lost tool is found again on the evidence of a start, and none where no calibration error could have put it.
    const bool found = state_ != STATE_LOST
                       || (int(kept) >= params_.minInitialInliers && meanSimilarity(inliers_) >= params_.minInitialSimilarity);
    if (!found || !plausible(camera_, filter_->correction(), inliers_))
    {
        filter_->reset(correction_);
        return false;
    }
    correction_ = filter_->correction();
    evidence_.nis = filter_->nis();
    return true;
}

/* The filter after the points of this frame and the hand-eye calibration, whose error is of a known size, and nothing else.
   Returns false for points that such a calibration does not explain, as after a move of the camera: then at the last correction. */
bool PaperMethod::correctFromHandEye()
{
    filter_->reset(calibration_);
    if (filter_->correct(nominalInliers_, imageInliers_, used_) && 2 * countNonZero(used_) > int(used_.size())) return true;
    filter_->reset(correction_);
    return false;
}

// Several scales and rotations about the kinematics' pose (paper, Sec. 2.1), the best agreement goes to EPnP (Sec. 2.3).
bool PaperMethod::start(Scene& scene, int first, int last)
{
    std::vector<StartCandidate> best(5);   // the paper has the first alone
    const Point3d at = transform(correction_, nominalPoints_[0]);
    ToolView view = view_;
    view.camera_T_base = startTurn(attempts_++, at) * view.camera_T_base;
    visibleParts_ = findStarts(scene, first, last, view, at.z, best);
    for (size_t k = 0; k < best.size() && best[k].score > 0; k++)
        if (startFrom(scene, best[k])) return true;
    return false;
}

bool PaperMethod::startFrom(Scene& scene, const StartCandidate& candidate)
{
    inliers_ = candidate.inliers;
    visibleParts_ = candidate.templates;
    Matx44d correction;
    bool solved;
    {
        StageTimer timer(scene.times, FILTER);
        gather();
        solved = solveEPnP(camera_, nominalInliers_, imageInliers_, correction, maxReprojectionError()) && plausible(camera_, correction, inliers_);
    }
    if (!solved)
    {
        if (params_.method == METHOD_EPNP) return false;
        correction = calibration_;   // joints that are off leave EPnP without a pose; the filter has one to begin with
    }
    const Matx44d before = correction_;
    setCorrection(correction);
    if (params_.method == METHOD_EPNP) return true;
    if (startFromHandEye(scene))
    {
        evidence_.nis = filter_->nis();
        return true;
    }
    setCorrection(before);
    return false;
}

/* The paper's filter starts from EPnP's pose, whose depth is off by 5 mm and more, and from templates of another scale. Ours takes
   the same points in from the hand-eye calibration and looks again with templates that fit.
   Returns whether the tool then looks as it should; tissue does not. */
bool PaperMethod::startFromHandEye(Scene& scene)
{
    for (int pass = 0; pass < 3; pass++)
    {
        if (pass > 0)
        {
            view_.camera_T_base = correction_ * nominal_T_base_;
            look(scene, 0, view_, PartWindows(minWindow()), true);
            if (sights_[0].found.inliers.empty()) return false;
            inliers_ = sights_[0].found.inliers;
            visibleParts_ = int(sights_[0].drawing.templates.size());
        }
        StageTimer timer(scene.times, FILTER);
        gather();
        if (correctFromHandEye()) correction_ = filter_->correction();
    }
    return meanSimilarity(inliers_) >= params_.minInitialSimilarity && plausible(camera_, correction_, inliers_);
}

// The state after a frame.
void PaperMethod::conclude(const Scene& scene, bool seen)
{
    if (seen)
    {
        lastSeen_ = scene.time;
        confirmed_++;
        if (confirmed_ > params_.confirmFrames)
        {
            state_ = STATE_TRACKING;
            trusted_ = correction_;
        }
    }
    else
    {
        if (state_ == STATE_TRACKING) state_ = STATE_COASTING;
        if (state_ == STATE_COASTING && scene.time - lastSeen_ > params_.coastingTime) state_ = STATE_LOST;
        if (state_ != STATE_COASTING && confirmed_ > 0)
        {
            confirmed_ = 0;
            setCorrection(trusted_);
        }
        inliers_.clear();
        evidence_.nis = 0;
    }
    evidence_.similarity = meanSimilarity(inliers_);
}

// A calibration that is another one is as good a beginning as the last was; what was tracked stays where it is.
void PaperMethod::setHandEye(const Matx44d& nominal_T_base)
{
    const Matx44d before_T_now = nominal_T_base_ * rigidInverse(nominal_T_base);
    nominal_T_base_ = nominal_T_base;
    calibration_ = Matx44d::eye();
    trusted_ = nearestRigid(trusted_ * before_T_now);
    correction_ = nearestRigid(correction_ * before_T_now);
    filter_->changeFrames(Matx44d::eye(), before_T_now);
    if (starts()) setCorrection(calibration_);
}

void PaperMethod::moveCamera(const Matx44d& now_T_before)
{
    const Matx44d before_T_now = rigidInverse(now_T_before);
    nominal_T_base_ = nearestRigid(now_T_before * nominal_T_base_);
    calibration_ = now_T_before * calibration_ * before_T_now;
    trusted_ = nearestRigid(now_T_before * trusted_ * before_T_now);
    correction_ = nearestRigid(now_T_before * correction_ * before_T_now);
    filter_->changeFrames(now_T_before, before_T_now);
}

void PaperMethod::inherit(const ToolMethod& other)
{
    calibration_ = trusted_ = other.isLocated() ? other.correction() : other.calibration();
    setCorrection(calibration_);
}

void PaperMethod::report(ToolEstimate& e) const
{
    ToolMethod::report(e);
    e.covariance = Matx66d::zeros();
    if (params_.method != METHOD_PAPER) return;
    const Matx44d nominal_T_tool = nominal_T_base_ * model_->endEffectorFromLinks(view_.base_T_link);
    e.covariance = filter_->poseCovariance(Point3d(nominal_T_tool(0, 3), nominal_T_tool(1, 3), nominal_T_tool(2, 3)));
}

}} // namespace cv::surgtrack
