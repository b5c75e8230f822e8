// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "base/geometry.hpp"
#include "track/full_method.hpp"

namespace cv { namespace surgtrack {

namespace {

const int fitted = 3, fitRounds = 4;    // so many of the nine hypotheses are fitted, in so many rounds
const int looseFrames = 15;             // after a first pose, which may be the wrong one of two that look alike in one frame
const double elsewhere = 0.003;   // of a tool that moves by itself between two frames [m]
const double searchRotation = 4 * CV_PI / 180, searchTranslation = 0.008;   // how far a lost tool may be from where it was, as the calibration may [rad, m]

} // namespace

/* About the calibration, and every other time about what the camera's motion, as another tool saw it, makes of it. The nine hypotheses
   scale and turn the image; further attempts, of later frames, turn the tool out of it. */
bool FullMethod::start(Scene& scene)
{
    const bool moved = scene.cameraMotion != Matx44d::eye();
    const int attempt = searches_++;
    const Matx44d from = moved && attempt % 2 ? scene.cameraMotion * calibration_ : calibration_;
    filter_->reset(startTurn(moved ? attempt / 2 : attempt, transform(from, nominalPoints_[0])) * from);
    filter_->predict(joints_);
    placeKeypoints(filter_->view());
    if (beginAnew(scene, 0, hypotheses - 1)) return true;
    filter_->reset(calibration_);   // until there is a pose, it is that of the tool's own kinematics
    filter_->predict(joints_);
    return false;
}

// One hypothesis a frame, in turn about the last pose and about the calibration, which is moved by the motion of the camera that another
// tool saw every other time; the upright one half of the time.
bool FullMethod::search(Scene& scene)
{
    const int n = searches_++;
    const int hypothesis = n % 4 < 2 ? 0 : 1 + (n / 4) % 8;
    const ArticulatedPoseEKF::State before = filter_->state();
    const Point3d& p = nominalPoints_[0];
    const Point3d predicted = transform(filter_->correction(), p);
    if (n % 2 == 0) filter_->inflate(searchRotation, searchTranslation);
    else
    {
        filter_->reset(n % 4 == 1 ? calibration_ : scene.cameraMotion * calibration_);
        filter_->predict(joints_);
        placeKeypoints(filter_->view());   // nothing is known of a delay there
    }
    bool found = beginAnew(scene, hypothesis, hypothesis);
    // Where it was predicted it may be hidden for a moment: a pose elsewhere must explain ten times as much.
    if (found && norm(transform(filter_->correction(), p) - predicted) > elsewhere && evidence_.logOdds() < ownOdds_ + thresholds_.confirmed) found = false;
    if (!found)
    {
        filter_->setState(before);
        placeKeypoints(filter_->view());
    }
    else if (!searched_) confirmed_ = 0;
    searched_ = found;
    return found;
}

/* Parts in wide windows by several scales and rotations about the pose predicted (paper, Sec. 2.1), the most promising of them fitted,
   and the one kept that explains the image best.
   first, last: which of the nine hypotheses */
bool FullMethod::beginAnew(Scene& scene, int first, int last)
{
    const ArticulatedPoseEKF::State vague = filter_->state();
    std::vector<StartCandidate> candidates(fitted);
    const int visible = findStarts(scene, first, last, filter_->view(), transform(filter_->correction(), nominalPoints_[0]).z, candidates);
    double most = -DBL_MAX;
    Pose best;
    best.filter = vague;
    best.visibleParts = visible;
    best.evidence.points = evidence_.points;
    best.eyes = 2;
    for (int k = 0; k < fitted && candidates[k].score > 0; k++)
    {
        // With all eyes and, as they may not stand to each other as they are said to, with the left one alone.
        for (size_t count = scene.open; count >= 1; count--)
        {
            eyes_ = count;
            filter_->setState(vague);
            fit(scene, candidates[k]);
            const double merit = evidence_.logOdds() - (count < scene.open ? thresholds_.pushedGain : 0);
            if (merit <= most || !evidence_.isFirstPose(thresholds_)) continue;
            most = merit;
            best = pose();
        }
    }
    setPose(best);
    const bool found = most > -DBL_MAX;
    if (found) boosted_ = looseFrames;
    return found;
}

/* Everything from the filter's prediction, which is vague, and the parts found: in several rounds, each drawn where the one before
   ended. The one that explains the image best is kept: the next may end in the wrong one of two depths. */
void FullMethod::fit(Scene& scene, const StartCandidate& candidate)
{
    sights_[0].found.inliers = candidate.inliers;
    correctPoints(scene, 1);   // the first matches are of one eye
    double most = -DBL_MAX;
    Pose best;
    for (int round = 0; round < fitRounds; round++)
    {
        const ToolView view = filter_->view();
        for (size_t e = 0; e < eyes(scene); e++)
        {
            if (round == fitRounds - 1)
            {
                redraw(scene, e);
                continue;
            }
            expectParts(*scene.eyes[e], e > 0);
            look(scene, e, view, windows_, e == 0);
            sampleOutline(scene, e, sights_[e].drawing);
        }
        visibleParts_ = int(sights_[0].cut->templates.size());
        if (round == 0) correctPoints(scene, eyes(scene));
        refine(scene, round < 2 ? startPass : trackPass);
        const double merit = evidence_.logOdds();
        if (merit < most) continue;
        most = merit;
        best = pose();
    }
    setPose(best);
}

}} // namespace cv::surgtrack
