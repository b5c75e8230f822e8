// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "base/geometry.hpp"
#include "track/full_method.hpp"
#include "track/view_change.hpp"

// A frame of a tool that is followed, and the state after it. full_start.cpp: first poses and searches; full_correction.cpp: points and
// edges into the filter.

namespace cv { namespace surgtrack {

namespace {

// A push of the camera, or a slip: the constant state is no longer believed. What a knock at the endoscope's holder does.
const double pushRotation = CV_PI / 180, pushTranslation = 0.002;   // [rad], [m]
const int pushedFrames = 10;           // that the process noise stays raised for
const double pushedGrowth = 3;         // factor on the deviations of Q then, and after a first pose
const double leastSimilarity = 0.55;   // of a set of points: what tissue gives where all of it agrees
const double pushedNis = 0.75;         // of points, per degree of freedom; below 0.6 as a rule
const double pushedLikelihood = 2;     // logarithm of the ratio; 99 of 100 frames without a push have less than 1

const double remembered = 0.25;        // a tool that moves at 5 cm/s is a centimetre farther by then [s]
const int unsureFrames = 4;            // that a first pose may stay without being confirmed: others come to their turn

const int settlingFrames = 50;         // from the first pose until the filter knows the calibration as well as it will

const double unusual = 0.75;           // log odds less than in the frames before: what they change by from frame to frame
const double usualFrames = 5;          // that they are averaged over

// The right eye is left out where it sees so much less of the outline than the left one, in so many frames in a row.
const double eyeDisagreement = 0.25;
const int eyeFrames = 5, eyeTrial = 50;   // eyeTrial: after so many frames it is tried again

// The outline is drawn anew where a keypoint has moved farther than this since: beyond, other points of the tool are its outline.
const double maxContourShift = 6;      // [pixel at 720 px image width]
const double maxContourTurn = 0.05;    // [rad]

} // namespace

FullMethod::FullMethod(int index, const Ptr<ToolModel>& model, const Matx44d& nominal_T_base, const ToolTracker::Params& params, double pixelScale,
                       const ArticulatedPoseEKF::Params& filter, const ToolContour::Params& contour, const ContourSearch& edges)
    : ToolMethod(index, model, nominal_T_base, params, pixelScale), filter_(ArticulatedPoseEKF::create(model, nominal_T_base, filter)),
      contour_(ToolContour::create(model, contour)), edges_(edges), thresholds_(params.minConfidence)
{
    const size_t parts = model->keypoints().size();
    windows_.deviations.reserve(parts);
    windows_.expected.reserve(parts);
    parts_.reserve(parts);
    imagePoints_.reserve(parts);
    noise_.reserve(parts);
    used_.reserve(parts);
    without_.inliers.reserve(parts);
    far_.inliers.reserve(parts);
    rival_.pose.inliers.reserve(parts);
    before_.rival_.pose.inliers.reserve(parts);
    reset();
}

void FullMethod::reset()
{
    ToolMethod::reset();
    filter_->reset();
    placed_ = sure_ = filter_->state();
    usual_ = -DBL_MAX;
    searches_ = boosted_ = pushed_ = disagreed_ = disputed_ = settling_ = rival_.frames = 0;
    eyes_ = 2;
    searched_ = isSeen_ = false;
    logOdds_ = 0;
    ownOdds_ = -DBL_MAX;
}

const ToolView& FullMethod::predict(const std::vector<double>& joints, double seconds)
{
    placed_ = filter_->state();
    before_ = *this;
    filter_->predict(joints, boosted_ > 0 ? pushedGrowth : 1, seconds);
    return filter_->view();
}

FullMethod::Pose FullMethod::pose() const
{
    Pose pose;
    keepPose(pose);
    return pose;
}

void FullMethod::keepPose(Pose& pose) const
{
    pose.filter = filter_->state();
    pose.correction = filter_->correction();
    pose.evidence = evidence_;
    pose.inliers = inliers_;
    pose.visibleParts = visibleParts_;
    pose.eyes = eyes_;
}

void FullMethod::setPose(const Pose& pose)
{
    filter_->setState(pose.filter);
    evidence_ = pose.evidence;
    inliers_ = pose.inliers;
    visibleParts_ = pose.visibleParts;
    eyes_ = pose.eyes;
}

void FullMethod::measure(Scene& scene, const PartDrawing* ahead)
{
    boosted_ = std::max(0, boosted_ - 1);
    pushed_ = std::max(0, pushed_ - 1);
    bool seen = false;
    if (starts())
    {
        shownJoints_ = joints_;
        seen = start(scene);
    }
    else if (!isStale(scene)) seen = follow(scene, ahead) || search(scene);
    conclude(scene, seen);
}

// Windows about where the tool is drawn. known: as wide as the filter's covariance asks for
void FullMethod::expectParts(const PartFinder& eye, bool known)
{
    windows_.halfWidth = minWindow();
    windows_.deviations.clear();
    windows_.expected.clear();
    for (size_t k = 0; known && k < nominalPoints_.size(); k++)
    {
        const Matx22d C = filter_->imageCovariance(eye.camera(), eye.eye_T_camera(), int(k));
        windows_.deviations.push_back(Point2d(std::sqrt(C(0, 0)), std::sqrt(C(1, 1))));
    }
}

bool FullMethod::follow(Scene& scene, const PartDrawing* ahead)
{
    const bool rivalled = rival_.frames > 0;
    if (rivalled) followRival(scene);
    for (size_t e = 0; e < eyes(scene); e++)
    {
        expectParts(*scene.eyes[e], true);
        if (e == 0 && ahead) lookAhead(scene, *ahead, windows_);
        else look(scene, e, filter_->view(), windows_, false);
    }
    visibleParts_ = int(sights_[0].cut->templates.size());
    if (correct(scene) && params_.adaptation)
    {
        // A push is believed if it explains what is seen better.
        keepPose(without_);
        filter_->inflate(pushRotation, pushTranslation);
        correct(scene);
        if (isBetter(without_)) boosted_ = pushed_ = pushedFrames;
        else
        {
            setPose(without_);
            if (evidence_.nis > pushedNis) correctByOutline(scene);   // the set of points is a false one
        }
    }
    if (pushed_ || evidence_.logOdds() < usual_ - unusual || isDisputed(scene)) correctAnew(scene);
    if (rivalled) judgeRival();
    judgeEyes(scene);
    if (continues(scene)) return true;
    ownOdds_ = evidence_.plausible ? evidence_.logOdds() + prior(scene.time) : -DBL_MAX;
    filter_->undo();
    inliers_.clear();
    return false;
}

// Each eye for itself.
void FullMethod::judgeEyes(Scene& scene)
{
    if (scene.open < 2) return;
    if (eyes_ == 2)
    {
        const bool agree = evidence_.eyeSupport[1] >= evidence_.eyeSupport[0] - eyeDisagreement;
        disagreed_ = agree ? 0 : disagreed_ + 1;
        if (disagreed_ >= eyeFrames) eyes_ = 1;
    }
    else if (++disagreed_ >= eyeTrial)
    {
        eyes_ = 2;
        disagreed_ = eyeFrames - 1;   // one more frame in which they disagree ends it
    }
}

/* Points, then contours, from the filter's prediction.
   Returns whether all this, with a push before, is that much likelier than without. */
bool FullMethod::correct(Scene& scene)
{
    const std::vector<PartMatch>& matches = sights_[0].found.inliers;
    const int passed = correctPoints(scene, eyes(scene));
    const bool pushed = int(matches.size()) > thresholds_.minParts && meanSimilarity(matches) > leastSimilarity
                        && (2 * passed < int(matches.size()) || evidence_.nis > pushedNis);
    evidence_.points = passed >= thresholds_.minParts && meanSimilarity(inliers_) >= leastSimilarity;
    if (!evidence_.points) dropPoints(scene);   // the outline alone may do
    for (size_t e = 0; e < eyes(scene); e++) sampleOutline(scene, e, *sights_[e].drawn);
    const ViewChange moved = viewChange(scene.camera(), *model_, filter_->view(), sights_[0].drawn->views[index_]);
    if (!(moved.shift <= maxContourShift * pixelScale_ && moved.turn <= maxContourTurn))
        for (size_t e = 0; e < eyes(scene); e++) redraw(scene, e);
    return refine(scene, trackPass) > pushedLikelihood || pushed;
}

void FullMethod::dropPoints(Scene& scene)
{
    filter_->undo();
    inliers_.clear();
    for (size_t e = 0; e < eyes(scene); e++) sights_[e].found.inliers.clear();
    evidence_.nis = 0;
    evidence_.points = false;
}

void FullMethod::correctByOutline(Scene& scene)
{
    dropPoints(scene);
    for (size_t e = 0; e < eyes(scene); e++) sampleOutline(scene, e, *sights_[e].cut);   // drawn where the filter is once more
    refine(scene, trackPass);
}

bool FullMethod::isBetter(const Pose& other) const
{
    return evidence_.logOdds() > other.evidence.logOdds() + thresholds_.pushedGain;
}

// What the tool's own past tells of a pose that follows from it: as sure as a pose was, but not for long where it is not seen.
double FullMethod::prior(double time) const
{
    if (searched_ || (state_ != STATE_TRACKING && state_ != STATE_COASTING)) return 0;
    const double unseen = state_ == STATE_TRACKING ? 0 : (time - lastSeen_) / remembered;
    return std::max(0., std::min(logOdds_, evidence_.points ? thresholds_.prior : thresholds_.outlinePrior)) * std::max(0., 1 - unseen);
}

bool FullMethod::continues(const Scene& scene) const
{
    if (!evidence_.plausible || evidence_.support < thresholds_.leastSupport) return false;
    const double past = prior(scene.time), all = evidence_.logOdds() + past;
    if (past > 0 && all >= thresholds_.followed) return true;
    if (state_ == STATE_TRACKING || !evidence_.points) return false;
    // A tool that is not seen where it was may be elsewhere; a first pose that is neither confirmed nor refuted makes room for others.
    return state_ != STATE_INITIALIZING ? all >= thresholds_.confirmed : all >= thresholds_.first && confirmed_ <= params_.confirmFrames + unsureFrames;
}

// The state after a frame.
void FullMethod::conclude(const Scene& scene, bool seen)
{
    if (seen)
    {
        const double past = prior(scene.time), own = evidence_.logOdds();
        lastSeen_ = scene.time;
        confirmed_++;
        const bool isSure = evidence_.isSure(thresholds_, params_.minInitialInliers), sure = isSure && state_ == STATE_INITIALIZING;
        const bool confirmed = (confirmed_ > params_.confirmFrames && own >= thresholds_.confirmed) || (confirmed_ > 1 && isSure);
        if (searched_ && state_ == STATE_TRACKING) state_ = STATE_COASTING;   // found elsewhere: to be confirmed
        const bool followed = !searched_ && (state_ == STATE_TRACKING || (state_ == STATE_COASTING && own + past >= thresholds_.sure));
        logOdds_ = own + past;
        const bool unsure = (isTorn() && rival_.lead > thresholds_.seriousLead) || evidence_.isBlinded();   // one of two, or of a whole range of depths
        if (unsure && (followed || sure || confirmed || state_ == STATE_TRACKING)) state_ = STATE_COASTING;
        else if (followed || sure || confirmed)
        {
            state_ = STATE_TRACKING;
            searches_ = 0;
            searched_ = false;
            sure_ = filter_->state();
            if (confirmed_ > startFrames && settling_ < settlingFrames && cameraMotion() == Matx44d::eye())
            {
                settling_++;
                isSettled_ = true;
                settled_ = filter_->correction();
            }
        }
    }
    else
    {
        confirmed_ = rival_.frames = 0;
        inliers_.clear();
        evidence_.nis = 0;
        if (searched_)   // the pose of the search was a false one
        {
            filter_->setState(sure_);
            filter_->predict(joints_);   // sure_ is of other readings
        }
        searched_ = false;
        if (state_ == STATE_TRACKING) state_ = STATE_COASTING;
        if (state_ == STATE_COASTING && scene.time - lastSeen_ > params_.coastingTime) state_ = STATE_LOST;
    }
    isSeen_ = seen;
    if (state_ != STATE_TRACKING) usual_ = -DBL_MAX;
    else usual_ = usual_ == -DBL_MAX ? evidence_.logOdds() : usual_ + (evidence_.logOdds() - usual_) / usualFrames;
    correction_ = filter_->correction();
    evidence_.similarity = meanSimilarity(inliers_);
    evidence_.parts = int(inliers_.size());
}

void FullMethod::setReadingErrors(const ReadingErrors& errors)
{
    filter_->setReadingErrors(errors);
    reset();
}

// A calibration that is another one is as good a beginning as the last was; what was tracked stays where it is.
void FullMethod::setHandEye(const Matx44d& nominal_T_base)
{
    nominal_T_base_ = nominal_T_base;
    calibration_ = Matx44d::eye();
    isSettled_ = false;
    settling_ = 0;
    moveStates([&](ArticulatedPoseEKF& filter) { filter.setHandEye(nominal_T_base); });
    if (starts()) filter_->reset();
    correction_ = filter_->correction();
}

void FullMethod::moveCamera(const Matx44d& now_T_before)
{
    calibration_ = now_T_before * calibration_ * rigidInverse(now_T_before);
    settled_ = now_T_before * settled_ * rigidInverse(now_T_before);
    moveStates([&](ArticulatedPoseEKF& filter) { filter.moveCamera(now_T_before); });
    nominal_T_base_ = filter_->state().nominal_T_base;
    correction_ = filter_->correction();
}

// All that is kept of the filter, and the filter itself.
void FullMethod::moveStates(const std::function<void(ArticulatedPoseEKF&)>& move)
{
    const ArticulatedPoseEKF::State now = filter_->state();
    filter_->setState(sure_);
    move(*filter_);
    sure_ = filter_->state();
    rival_.frames = 0;
    filter_->setState(now);
    move(*filter_);
}

void FullMethod::inherit(const ToolMethod& other)
{
    calibration_ = correction_ = other.isLocated() ? other.correction() : other.calibration();
    filter_->reset(calibration_);
    sure_ = filter_->state();
}

void FullMethod::report(ToolEstimate& e) const
{
    ToolMethod::report(e);
    e.covariance = filter_->poseCovariance();
    if (rival_.frames > 0) spanRival(e.covariance);
    std::copy(filter_->offsets().begin(), filter_->offsets().end(), e.jointOffsets.begin());
    e.joints = filter_->joints();
    e.delay = filter_->delay();
    e.confidence = isSeen_ ? probability(logOdds_) : 0;
    if (isTorn()) e.confidence *= probability(-rival_.lead);
    if (evidence_.isBlinded()) e.confidence *= 1 - evidence_.white;
}

}} // namespace cv::surgtrack
