// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "filter/articulated_pose_ekf.hpp"

namespace cv { namespace surgtrack {

// All that the filter knows, as a value.

namespace {

const double largest = 1e4;   // of constants [rad, m or s], as of Params: poses beyond are no numbers any more

void checkSize(const std::vector<double>& values, const char* name)
{
    if (!checkRange(values, true, 0, -largest, largest)) CV_Error(Error::StsBadArg, format("%s: expected numbers between -%g and %g", name, largest, largest));
}

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

ReadingErrors ArticulatedPoseEKFImpl::readingErrors() const
{
    ReadingErrors result;
    const int n = n_ - 6;
    for (int i = 0; i < n; i++) result.names.push_back(i < errors_->size() ? errors_->name(i) : String("delay"));
    result.values.assign(state_.theta.data(), state_.theta.data() + n);
    result.reference = reference_.empty() ? joints_ : reference_;
    Mat_<double> covariance(n, n);
    for (int r = 0; r < n; r++)
        for (int c = 0; c < n; c++) covariance(r, c) = state_.P(6 + r, 6 + c);
    result.covariance = covariance;
    return result;
}

void ArticulatedPoseEKFImpl::setReadingErrors(const ReadingErrors& errors)
{
    const int n = n_ - 6;
    Vector mean(n);
    mean.setZero();
    Matrix P = Matrix::Zero(n, n);
    if (!errors.names.empty())
    {
        const std::vector<String> names = readingErrors().names;
        if (errors.names != names)
        {
            String all;
            for (size_t i = 0; i < names.size(); i++) all += (i ? ", " : "") + names[i];
            CV_Error(Error::StsBadArg, "errors.names: of another tool, or with other parameters; expected " + all);
        }
        CV_CheckEQ((int)errors.values.size(), n, "errors.values: one of each name");
        CV_CheckEQ(errors.reference.size(), joints_.size(), "errors.reference: one per coordinate");
        checkSize(errors.values, "errors.values");
        checkSize(errors.reference, "errors.reference");
        CV_CheckTypeEQ(errors.covariance.type(), CV_64F, "errors.covariance");
        if (errors.covariance.dims != 2 || errors.covariance.rows != n || errors.covariance.cols != n ||
            !checkRange(errors.covariance, true, 0, -largest * largest, largest * largest))
            CV_Error(Error::StsBadArg, format("errors.covariance: expected %d x %d numbers between -%g and %g", n, n, largest * largest, largest * largest));
        for (int r = 0; r < n; r++)
        {
            mean[r] = errors.values[r];
            for (int c = 0; c < n; c++) P(r, c) = (errors.covariance.at<double>(r, c) + errors.covariance.at<double>(c, r)) / 2;
        }
    }
    for (int i = 0; i < n; i++)
        if (errors.names.empty() || changes(6 + i)) P(i, i) += std::pow(prior(6 + i), 2);
    if (n > 0 && Eigen::LLT<Matrix>(P).info() != Eigen::Success) CV_Error(Error::StsBadArg, "errors.covariance: is none, it is not positive definite");
    known_ = mean;
    knownP_ = P;
    knownReference_ = errors.reference;
    reset(Matx44d::eye());
}

}} // namespace cv::surgtrack
