// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "filter/articulated_pose_ekf.hpp"

namespace cv { namespace surgtrack {

// All that the filter knows, as a value.

namespace {

void store(const Estimate& from, ArticulatedPoseEKF::Belief& to)
{
    to.correction = from.correction;
    for (int i = 0; i < from.theta.size(); i++) to.theta[i] = from.theta[i];
    for (int i = 0; i < from.shift.size(); i++) to.shift[i] = from.shift[i];
    to.believed_T_correction = from.believed_T_correction;
    for (int r = 0; r < from.P.rows(); r++)
        for (int c = 0; c < from.P.cols(); c++) to.covariance(r, c) = from.P(r, c);
    to.centre = from.centre;
    to.placed = from.placed;
    to.nis = from.nis;
}

// Of the same size.
void restore(const ArticulatedPoseEKF::Belief& from, Estimate& to)
{
    to.correction = from.correction;
    for (int i = 0; i < to.theta.size(); i++) to.theta[i] = from.theta[i];
    for (int i = 0; i < to.shift.size(); i++) to.shift[i] = from.shift[i];
    to.believed_T_correction = from.believed_T_correction;
    for (int r = 0; r < to.P.rows(); r++)
        for (int c = 0; c < to.P.cols(); c++) to.P(r, c) = from.covariance(r, c);
    to.centre = from.centre;
    to.placed = from.placed;
    to.nis = from.nis;
}

void store(const std::vector<double>& from, AutoBuffer<double, 16>& to)
{
    to.allocate(from.size());
    std::copy(from.begin(), from.end(), to.data());
}

void restore(const AutoBuffer<double, 16>& from, std::vector<double>& to)
{
    to.assign(from.data(), from.data() + from.size());
}

} // namespace

ArticulatedPoseEKF::State ArticulatedPoseEKFImpl::state() const
{
    State result;
    result.model = model_;
    result.nominal_T_base = nominal_T_base_;
    store(joints_, result.joints);
    store(reference_, result.reference);
    store(directions_, result.directions);
    store(predicted_, result.predicted);
    store(state_, result.corrected);
    for (int i = 0; i < n_; i++) result.moved[i] = moved_[i];
    return result;
}

void ArticulatedPoseEKFImpl::setState(const State& state)
{
    CV_Assert(state.model == model_ && "state: of another tool");
    nominal_T_base_ = state.nominal_T_base;
    restore(state.joints, joints_);
    restore(state.reference, reference_);
    restore(state.directions, directions_);
    restore(state.predicted, predicted_);
    restore(state.corrected, state_);
    for (int i = 0; i < n_; i++) moved_[i] = state.moved[i];
    setReadings(joints_);
    predictedSeen_ = seen(predicted_.P);
}

}} // namespace cv::surgtrack
