// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "base/geometry.hpp"
#include "track/full_method.hpp"

namespace cv { namespace surgtrack {

namespace {

const double depthStep = 0.003;        // [m]; half of what the two basins of depth were apart where they were seen
const double depthRotation = CV_PI / 180;   // what another tool tells of the camera's motion is as uncertain as a push [rad]
const double apart = 0.001;            // poses that are nearer to each other are the same [m]
const int rivalFrames = 25;            // that two poses are followed at most: a second

} // namespace

// How far a pose is from the state of the filter, at the first keypoint.
double FullMethod::distance(const Pose& pose) const
{
    const Point3d& p = nominalPoints_[0];
    return norm(transform(filter_->correction(), p) - transform(pose.filter.corrected.correction, p));
}

/* Much less is explained than in the frames before: edges of something else may have pulled the pose away, most easily in depth. Once
   more with edges that are near to where the points have it, by the outline alone, and from nearer and farther. What explains clearly
   more is kept; but one frame may favour the wrong one of two depths, so a pose elsewhere that does not explain ten times as much is
   followed beside the other until frames have told. */
void FullMethod::correctAnew(Scene& scene)
{
    keepPose(far_);
    filter_->undo();
    const ArticulatedPoseEKF::State predicted = filter_->state();
    evidence_.points = correctPoints(scene, eyes(scene)) > 0;
    if (!evidence_.points) filter_->undo();
    refine(scene, nearPass);
    if (isBetter(far_)) keepPose(far_);
    const Point3d at = transform(predicted.corrected.correction, nominalPoints_[0]);
    for (int i = 0; i < 3; i++)
    {
        const bool camera = i == 2;   // has moved, as another tool saw it
        if (camera && (!isSettled_ || scene.cameraMotion == Matx44d::eye())) continue;
        ArticulatedPoseEKF::State moved = predicted;
        const Matx44d shift = rigidTransform(Matx33d::eye(), at * ((i == 0 ? -1 : 1) * depthStep / norm(at)));
        moved.predicted.correction = camera ? scene.cameraMotion * settled_ : shift * moved.predicted.correction;
        moved.corrected.correction = camera ? scene.cameraMotion * settled_ : shift * moved.corrected.correction;
        filter_->setState(moved);
        filter_->inflate(camera ? depthRotation : 0, depthStep);
        correct(scene);
        if (getenv("DBG")) fprintf(stderr, "  hyp %d: lo %.2f against %.2f, distance %.2f mm\n", i, evidence_.logOdds(), far_.evidence.logOdds(), distance(far_) * 1000);
        if (!isBetter(far_)) continue;
        const double lead = evidence_.logOdds() - far_.evidence.logOdds();
        if (distance(far_) < apart || lead > thresholds_.confirmed) keepPose(far_);
        else if (rival_.frames == 0 || lead > rival_.lead)
        {
            keepPose(rival_.pose);
            rival_.lead = lead;
            rival_.frames = 1;
        }
    }
    filter_->setState(predicted);
    correctByOutline(scene);   // the set of points may be a false one
    if (isBetter(far_)) keepPose(far_);
    setPose(far_);
    usual_ = evidence_.logOdds();   // there is no better
}

// Before the pose that is believed, so that what is seen of the tool is that one's.
void FullMethod::followRival(Scene& scene)
{
    const ArticulatedPoseEKF::State believed = filter_->state();
    filter_->setState(rival_.pose.filter);
    filter_->predict(joints_);
    for (size_t e = 0; e < eyes(scene); e++)
    {
        expectParts(*scene.eyes[e], true);
        look(scene, e, filter_->view(), windows_, false);
    }
    visibleParts_ = int(sights_[0].cut->templates.size());
    correct(scene);
    keepPose(rival_.pose);
    filter_->setState(believed);
}

// The frames since the two parted tell together which one it is.
void FullMethod::judgeRival()
{
    rival_.lead += rival_.pose.evidence.logOdds() - evidence_.logOdds();
    if (getenv("DBG")) fprintf(stderr, "  rival lo %.2f against %.2f, lead %.2f distance %.2f mm\n", rival_.pose.evidence.logOdds(), evidence_.logOdds(), rival_.lead, distance(rival_.pose) * 1000);
    if (rival_.lead >= thresholds_.sure)
    {
        setPose(rival_.pose);
        usual_ = evidence_.logOdds();
        rival_.frames = 0;
    }
    else if (distance(rival_.pose) < apart || rival_.lead <= -thresholds_.confirmed || ++rival_.frames > rivalFrames) rival_.frames = 0;
}

}} // namespace cv::surgtrack
