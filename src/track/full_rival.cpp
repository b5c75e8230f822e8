// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "base/geometry.hpp"
#include "track/full_method.hpp"

namespace cv { namespace surgtrack {

namespace {

const double depthStep = 0.003;        // [m]; half of what the two basins of depth were apart where they were seen
// Another tool's correction tells the camera's motion so well: half of what two tools differ by before it is disputed [rad], [m].
const double cameraTurn = CV_PI / 360, cameraShift = 0.001;
const double disputed = 0.002;         // estimates of the camera's motion by two tools differ by as much, from one posture to another [m]
const int disputedFrames = 2;          // each second is looked at once more: it costs as much as the frame
const double apart = 0.001;            // poses that are nearer to each other are the same [m]
const double serious = 0.003;          // of two poses that are nearer both may count as right: within 5 mm, of which their own errors take some [m]
const int rivalFrames = 25;            // that two poses are followed at most: a second

void forgetPose(Matx<double, ArticulatedPoseEKF::MAX_STATES, ArticulatedPoseEKF::MAX_STATES>& covariance)
{
    for (int r = 0; r < 6; r++)
        for (int c = 0; c < ArticulatedPoseEKF::MAX_STATES; c++) covariance(r, c) = covariance(c, r) = 0;
}

} // namespace

// How far a pose is from the state of the filter, at the first keypoint.
double FullMethod::distance(const Pose& pose) const
{
    const Point3d& p = nominalPoints_[0];
    return norm(transform(filter_->correction(), p) - transform(pose.correction, p));
}

// Whether another tool saw the camera move otherwise, every fifth time.
bool FullMethod::isDisputed(const Scene& scene)
{
    if (!isSettled_ || scene.cameraMotion == Matx44d::eye()) return false;
    const Point3d& p = nominalPoints_[0];
    if (norm(transform(filter_->correction(), p) - transform(scene.cameraMotion * settled_, p)) < disputed) return false;
    return ++disputed_ % disputedFrames == 0;
}

/* The predicted pose elsewhere: nearer, farther, or where a tool that is surer saw the camera go. While it is pushed that is the step since the
   frame before, which is exact; later all its motion, about which each tool's estimate wanders.
   Returns whether there is such a pose. */
bool FullMethod::displace(const Scene& scene, const ArticulatedPoseEKF::State& predicted, int where)
{
    const bool steps = pushed_ && scene.cameraStep != Matx44d::eye();
    if (where == CAMERA && !steps && (!isSettled_ || scene.cameraMotion == Matx44d::eye())) return false;
    ArticulatedPoseEKF::State moved = predicted;
    Matx44d& correction = moved.predicted.correction;
    const Point3d at = transform(correction, nominalPoints_[0]);
    double turn = 0, shift = 0;   // that it is not known by
    if (where != CAMERA)
    {
        correction = rigidTransform(Matx33d::eye(), at * ((where == NEARER ? -1 : 1) * depthStep / norm(at))) * correction;
        shift = depthStep;
    }
    else if (steps) correction = scene.cameraStep * correction;
    else
    {
        correction = scene.cameraMotion * settled_;
        forgetPose(moved.predicted.covariance);
        turn = cameraTurn;
        shift = cameraShift;
    }
    filter_->setState(moved);
    filter_->inflate(turn, shift);
    return true;
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
    for (int i = NEARER; i <= CAMERA && params_.adaptation; i++)
    {
        if (!displace(scene, predicted, i)) continue;
        correct(scene);
        const double more = i == CAMERA ? thresholds_.confirmed : 0;   // another tool speaks for it
        const double lead = evidence_.logOdds() - far_.evidence.logOdds() + more;
        if (lead < thresholds_.pushedGain) continue;
        if (lead > thresholds_.confirmed || distance(far_) < apart) keepPose(far_);
        else if (distance(far_) >= apart && (rival_.frames == 0 || lead > rival_.lead))
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

bool FullMethod::isTorn() const { return rival_.frames > 0 && distance(rival_.pose) > serious; }

// The covariance of a mixture of the two.
void FullMethod::spanRival(Matx66d& covariance) const
{
    const Matx44d between = rival_.pose.correction * rigidInverse(correction_);
    const Point3d at = transform(correction_, nominalPoints_[0]), moved = transform(between, at) - at;
    const Vec3d turn = rotationVector(between.get_minor<3, 3>(0, 0));
    const Vec6d d(turn[0], turn[1], turn[2], moved.x, moved.y, moved.z);
    const double p = probability(rival_.lead);
    covariance += p * (1 - p) * d * d.t();
}

// The frames since the two parted tell together which one it is.
void FullMethod::judgeRival()
{
    rival_.lead += rival_.pose.evidence.logOdds() - evidence_.logOdds();
    if (rival_.lead >= -thresholds_.seriousLead)   // now it is the other that is the rival
    {
        keepPose(without_);
        setPose(rival_.pose);
        std::swap(rival_.pose, without_);
        rival_.lead = -rival_.lead;
        usual_ = evidence_.logOdds();
    }
    if (distance(rival_.pose) < apart || rival_.lead <= -thresholds_.confirmed || ++rival_.frames > rivalFrames) rival_.frames = 0;
}

}} // namespace cv::surgtrack
