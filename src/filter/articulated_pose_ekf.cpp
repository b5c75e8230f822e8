// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "base/checks.hpp"
#include "base/geometry.hpp"
#include "filter/articulated_pose_ekf.hpp"

namespace cv { namespace surgtrack {

namespace {

const double frameRate = 25;      // that process noise is given for
const double longestGap = 12;     // frames that it grows for: half a second in which nothing is seen
const double steadiness = 0.2;    // process noise of gains, play and the like as a share of that of offsets, which take up what the model does not explain

} // namespace

void ArticulatedPoseEKF::reset()
{
    reset(Matx44d::eye());
}

void ArticulatedPoseEKF::copyTo(const Ptr<ArticulatedPoseEKF>& other) const
{
    CV_Assert(other && "other: a filter to be changed");
    copyTo(*other);
}

/* exact: the one real arm that was measured (507 poses) was not; 0.02 to 0.1 were tried on path-traced sequences, good and bad. delay: the paper's
   recording lags by 0.06 s; with 0.07 and more, tools that leave the view are looked for too far away (losses test). edgeBias: a codec's,
   measured at the true pose. bloom: that of a picture over-exposed 1.9 times. contourCorrelation: by the normalised errors of the
   built-in scenes (consistency test). */
ArticulatedPoseEKF::Params::Params()
    : initialRotation(4 * CV_PI / 180), initialTranslation(0.008), processRotation(0.1 * CV_PI / 180), processTranslation(0.0003),
      processJoint(0.03), gain(0.02), play(0.02), coupling(0.1), delay(0.05), exact(0.02), pointNoise(3), gate(13.8), contourNoise(1), edgeBias(0.1), bloom(3), jointOffsets(true), contourCorrelation(13)
{
}

namespace {

void checkParams(const ArticulatedPoseEKF::Params& p)
{
    CV_Check(p.initialRotation, p.initialRotation > 0 && p.initialRotation < 1e4, "Params::initialRotation must be positive and less than 1e4");
    CV_Check(p.initialTranslation, p.initialTranslation > 0 && p.initialTranslation < 1e4, "Params::initialTranslation must be positive and less than 1e4");
    CV_Check(p.processRotation, p.processRotation >= 0 && p.processRotation < 1e4, "Params::processRotation must be at least 0 and less than 1e4");
    CV_Check(p.processTranslation, p.processTranslation >= 0 && p.processTranslation < 1e4, "Params::processTranslation must be at least 0 and less than 1e4");
    CV_Check(p.processJoint, p.processJoint >= 0 && p.processJoint < 1e4, "Params::processJoint must be at least 0 and less than 1e4");
    CV_Check(p.gain, p.gain >= 0 && p.gain < 1e4, "Params::gain must be at least 0 and less than 1e4");
    CV_Check(p.play, p.play >= 0 && p.play < 1e4, "Params::play must be at least 0 and less than 1e4");
    CV_Check(p.coupling, p.coupling >= 0 && p.coupling < 1e4, "Params::coupling must be at least 0 and less than 1e4");
    CV_Check(p.delay, p.delay >= 0 && p.delay < 1e4, "Params::delay must be at least 0 and less than 1e4");
    CV_Check(p.exact, p.exact >= 0 && p.exact < 1, "Params::exact must be a probability below 1");
    CV_Check(p.pointNoise, p.pointNoise > 1e-4 && p.pointNoise < 1e4, "Params::pointNoise must be more than 1e-4 and less than 1e4");
    CV_Check(p.gate, p.gate < DBL_MAX, "Params::gate must be a number");
    CV_Check(p.contourNoise, p.contourNoise > 1e-4 && p.contourNoise < 1e4, "Params::contourNoise must be more than 1e-4 and less than 1e4");
    CV_Check(p.edgeBias, p.edgeBias > 1e-4 && p.edgeBias < 1e4, "Params::edgeBias must be more than 1e-4 and less than 1e4");
    CV_Check(p.bloom, p.bloom > 1e-4 && p.bloom < 1e4, "Params::bloom must be more than 1e-4 and less than 1e4");
    CV_Check(p.contourCorrelation, p.contourCorrelation >= 1 && p.contourCorrelation < 1e4, "Params::contourCorrelation must be 1 or more and less than 1e4");
}

} // namespace

ArticulatedPoseEKFImpl::ArticulatedPoseEKFImpl(const Ptr<ToolModel>& model, const Matx44d& nominal_T_base, const Params& params)
    : model_(model), nominal_T_base_(nominal_T_base), params_(params), exact_(params.exact), history_(*model),
      earlier_(history_)
{
    CV_Assert(isRigid(nominal_T_base) && "nominal_T_base: rigid");
    checkParams(params);
    const size_t coordinates = model->coordinateNames().size();
    isJaw_ = JointErrors::jaws(*model);
    errors_ = makePtr<JointErrors>(*model, params, params.jointOffsets);
    const int delays = params.delay > 0;   // comes last
    n_ = 6 + errors_->size() + delays;
    m_ = 6 + errors_->offsets() + delays;
    std::vector<int> constants;
    std::vector<double> priors;
    for (int i = 6 + errors_->offsets(); i < n_ - delays; i++)
    {
        constants.push_back(i);
        priors.push_back(prior(i));
    }
    exact_.add(constants, priors);
    if (delays) exact_.add(std::vector<int>(1, n_ - 1), std::vector<double>(1, params.delay));
    for (size_t i = 0; i < coordinates; i++) stateOf_.push_back(errors_->offsetOf(i) < 0 ? -1 : 6 + errors_->offsetOf(i));
    directions_.assign(coordinates, 0.);
    offsets_.assign(coordinates, 0.);
    late_ = rates_ = offsets_;
    joints_.assign(coordinates, 0.);
    axes_.resize(model->links().size());
    setReadingErrors(ReadingErrors());
}

void ArticulatedPoseEKFImpl::reset(const Matx44d& correction)
{
    CV_Assert(isRigid(correction) && "correction: rigid");
    state_.correction = correction;
    state_.theta = known_;
    state_.P = Matrix::Zero(n_, n_);
    state_.P.bottomRightCorner(n_ - 6, n_ - 6) = knownP_;
    for (int i = 0; i < 3; i++)
    {
        state_.P(i, i) = params_.initialRotation * params_.initialRotation;
        state_.P(3 + i, 3 + i) = params_.initialTranslation * params_.initialTranslation;
    }
    state_.shift.setZero(n_);
    state_.believed_T_correction = Matx44d::eye();
    state_.nis = 0;
    state_.placed = false;
    bias_.setZero();
    reference_ = knownReference_;
    history_.clear();
    std::fill(directions_.begin(), directions_.end(), 0.);
    moved_.setZero(n_);
    setReadings(joints_);
    predictedNow();
}

// The mixture, after a correction; until the next one it stays as it is.
void ArticulatedPoseEKFImpl::believe()
{
    exact_.mix(state_.theta, state_.P, state_.shift, 0);
    state_.believed_T_correction = motionOf(state_.shift);
}

// Of these readings the offsets are a sum of the constants.
void ArticulatedPoseEKFImpl::setReadings(const std::vector<double>& readings)
{
    joints_ = readings;
    const std::vector<double>& reference = reference_.empty() ? joints_ : reference_;
    errors_->phi(joints_.data(), reference.data(), directions_.data(), phi_);
    if (params_.delay > 0)
    {
        phi_.conservativeResize(m_ - 6, n_ - 6);
        phi_.rightCols(1).setZero();
        phi_.bottomRows(1).setZero();
        phi_(m_ - 7, n_ - 7) = 1;
    }
    place();
}

void ArticulatedPoseEKFImpl::predictedNow()
{
    predicted_ = state_;
    predictedSeen_ = seen(predicted_.P);
    isStateSeen_ = false;
    moved_.setZero(n_);
    see();
    begin();
}

// Covariance of (omega, v, d) from that of (omega, v, theta).
SeenMatrix ArticulatedPoseEKFImpl::seen(const Matrix& P) const
{
    SeenMatrix result(m_, m_);
    const int k = m_ - 6, l = n_ - 6;
    result.topLeftCorner(6, 6) = P.topLeftCorner(6, 6);
    result.bottomLeftCorner(k, 6) = phi_ * P.bottomLeftCorner(l, 6);
    result.topRightCorner(6, k) = result.bottomLeftCorner(k, 6).transpose();
    result.bottomRightCorner(k, k) = phi_ * P.bottomRightCorner(l, l) * phi_.transpose();
    return result;
}

// Windows of all parts ask for it.
const SeenMatrix& ArticulatedPoseEKFImpl::stateSeen() const
{
    if (isStateSeen_) return stateSeen_;
    Vector shift;
    Matrix P;
    exact_.mix(state_.theta, state_.P, shift, &P);
    stateSeen_ = seen(P);
    isStateSeen_ = true;
    return stateSeen_;
}

// How far what is believed is from the prediction.
void ArticulatedPoseEKFImpl::see()
{
    seenMoved_ = seenOf(moved_ + state_.shift);
}

// (omega, v, d) of (omega, v, theta).
SeenVector ArticulatedPoseEKFImpl::seenOf(const Vector& x) const
{
    SeenVector result(m_);
    result.head(6) = x.head(6);
    result.tail(m_ - 6) = phi_ * x.tail(n_ - 6);
    return result;
}

void ArticulatedPoseEKFImpl::sumOffsets(const Vector& theta)
{
    const Vector d = phi_ * theta;
    for (size_t i = 0; i < stateOf_.size(); i++) offsets_[i] = stateOf_[i] >= 0 ? d[stateOf_[i] - 6] : 0;
}

void ArticulatedPoseEKFImpl::correctJoints(const std::vector<double>& readings, std::vector<double>& joints) const
{
    CV_CheckEQ(readings.size(), stateOf_.size(), "readings: one value per coordinate");
    joints.resize(readings.size());
    for (size_t i = 0; i < readings.size(); i++)
    {
        joints[i] = readings[i] + late_[i] + offsets_[i];
        if (isJaw_[i]) joints[i] = std::max(joints[i], std::min(readings[i], 0.));
    }
}

// Poses of the links and axes of the joints, from readings and state. The centre stays.
void ArticulatedPoseEKFImpl::place()
{
    isStateSeen_ = false;
    see();
    sumOffsets(state_.theta + state_.shift.tail(n_ - 6));
    history_.at(delay(), late_.data(), rates_.data());
    correctJoints(joints_, corrected_);
    model_->forwardKinematics(corrected_, view_.base_T_link);
    correction_ = state_.believed_T_correction * state_.correction;
    view_.camera_T_base = correction_ * nominal_T_base_;
    const std::vector<ToolModel::Link>& links = model_->links();
    for (size_t l = 0; l < links.size(); l++)
    {
        axes_[l].clear();
        for (int i = int(l); i >= 0; i = links[i].parent)
        {
            if (links[i].coordinate < 0) continue;
            const Matx44d T = view_.camera_T_base * view_.base_T_link[i];
            Axis a;
            a.state = stateOf_[links[i].coordinate];
            a.rate = rates_[links[i].coordinate];
            if (a.state < 0 && a.rate == 0) continue;
            a.direction = Point3d(T(0, 2), T(1, 2), T(2, 2)) * links[i].scale;
            a.origin = Point3d(T(0, 3), T(1, 3), T(2, 3));
            a.revolute = links[i].jointType == ToolModel::JOINT_REVOLUTE;
            axes_[l].push_back(a);
        }
    }
}

void ArticulatedPoseEKFImpl::predict(const std::vector<double>& joints, double growth, double seconds)
{
    CV_CheckEQ(joints.size(), stateOf_.size(), "joints: one value per coordinate");
    checkFinite(joints, "joints");
    CV_Check(growth, growth >= 0 && growth < DBL_MAX, "growth must not be negative");
    CV_Check(seconds, seconds >= 0 && seconds < DBL_MAX, "seconds must not be negative");
    if (seconds > 0) earlier_ = history_;
    history_.add(joints.data(), seconds);
    if (reference_.empty()) reference_ = joints_ = joints;
    JointErrors::hang(joints_.data(), joints.data(), joints.size(), &directions_[0]);
    setReadings(joints);
    const std::vector<ToolModel::Keypoint>& keypoints = model_->keypoints();
    Point3d centre;
    for (size_t i = 0; i < keypoints.size(); i++)
        centre += transform(view_.camera_T_base * view_.base_T_link[keypoints[i].link], keypoints[i].linkPoint) * (1. / keypoints.size());
    const Point3d d = centre - state_.centre;
    state_.centre = centre;
    // v at the new centre = v + omega x d
    Matrix T = Matrix::Identity(n_, n_);
    T(3, 1) = d.z; T(3, 2) = -d.y; T(4, 0) = -d.z; T(4, 2) = d.x; T(5, 0) = d.y; T(5, 1) = -d.x;
    if (state_.placed)
    {
        state_.P = (T * state_.P * T.transpose()).eval();
        state_.shift = (T * state_.shift).eval();
    }
    state_.placed = true;
    const double frames = seconds > 0 ? std::min(seconds * frameRate, longestGap) : 1, more = growth * growth * frames;
    for (int i = 0; i < 3; i++)
    {
        state_.P(i, i) += more * params_.processRotation * params_.processRotation;
        state_.P(3 + i, 3 + i) += more * params_.processTranslation * params_.processTranslation;
    }
    for (int i = 6; i < n_; i++)
    {
        // The delay is as steady, but for the first frames: it is the one constant that moves the whole tool.
        const bool steady = i >= 6 + errors_->size() ? growth <= 1 : !changes(i);
        state_.P(i, i) += more * std::pow(params_.processJoint * prior(i) * (steady ? steadiness : 1), 2);
    }
    predictedNow();
}

void ArticulatedPoseEKFImpl::inflate(double rotation, double translation)
{
    checkGrowth(rotation, translation);
    for (int i = 0; i < 3; i++)
    {
        predicted_.P(i, i) += rotation * rotation;
        predicted_.P(3 + i, 3 + i) += translation * translation;
    }
    predictedSeen_ = seen(predicted_.P);
    undo();
}

void ArticulatedPoseEKFImpl::undo()
{
    state_ = predicted_;
    moved_.setZero(n_);
    place();
}

void ArticulatedPoseEKFImpl::setHandEye(const Matx44d& nominal_T_base)
{
    CV_Assert(isRigid(nominal_T_base) && "nominal_T_base: rigid");
    const Matx44d before_T_now = nominal_T_base_ * rigidInverse(nominal_T_base);
    Estimate* const estimates[] = {&state_, &predicted_};
    for (int i = 0; i < 2; i++) estimates[i]->correction = nearestRigid(estimates[i]->correction * before_T_now);
    nominal_T_base_ = nominal_T_base;
    place();
}

// The error (omega, v) is that of a motion in the camera frame: it turns with it.
void ArticulatedPoseEKFImpl::moveCamera(const Matx44d& now_T_before)
{
    CV_Assert(isRigid(now_T_before) && "now_T_before: rigid");
    Matrix T = Matrix::Identity(n_, n_);
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) T(r, c) = T(3 + r, 3 + c) = now_T_before(r, c);
    Estimate* const estimates[] = {&state_, &predicted_};
    for (int i = 0; i < 2; i++)
    {
        Estimate& e = *estimates[i];
        e.correction = nearestRigid(now_T_before * e.correction * rigidInverse(now_T_before));
        e.centre = transform(now_T_before, e.centre);
        e.P = (T * e.P * T.transpose()).eval();
        e.shift = (T * e.shift).eval();
        e.believed_T_correction = now_T_before * e.believed_T_correction * rigidInverse(now_T_before);
    }
    moved_ = (T * moved_).eval();
    predictedSeen_ = seen(predicted_.P);
    nominal_T_base_ = nearestRigid(now_T_before * nominal_T_base_);
    place();
}

Mat ArticulatedPoseEKFImpl::covariance() const
{
    const SeenMatrix& P = stateSeen();
    const int n = 6 + errors_->offsets();
    Mat_<double> result(n, n);
    for (int r = 0; r < n; r++)
        for (int c = 0; c < n; c++) result(r, c) = P(r, c);
    return Mat(result);
}

Ptr<ArticulatedPoseEKF> ArticulatedPoseEKF::create(const Ptr<ToolModel>& model, const Matx44d& nominal_T_base, const Params& params)
{
    CV_Assert(model);
    return makePtr<ArticulatedPoseEKFImpl>(model, nominal_T_base, params);
}

}} // namespace cv::surgtrack
