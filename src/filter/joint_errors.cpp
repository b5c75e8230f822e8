// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "filter/joint_errors.hpp"

namespace cv { namespace surgtrack {

// Half of the play; only what a coordinate does within it depends on it, the errors at both ends are learnt [rad].
static const double playWidth = 0.02;

void JointErrors::add(Term::Kind kind, int row, size_t coordinate, double prior)
{
    if (!(prior > 0) || size() >= maxStates - 6) return;
    const Term term = {kind, row, int(coordinate)};
    terms_.push_back(term);
    priors_.push_back(prior);
}

JointErrors::JointErrors(const std::vector<double>& offsets, const std::vector<uchar>& revolute, const std::vector<uchar>& jaw,
                         const ArticulatedPoseEKF::Params& params)
    : offsetOf_(offsets.size(), -1)
{
    for (size_t i = 0; i < offsets.size(); i++)
    {
        if (!(offsets[i] > 0) || this->offsets() >= ArticulatedPoseEKF::MAX_OFFSETS) continue;
        offsetOf_[i] = this->offsets();
        coordinates_.push_back(int(i));
        add(Term::OFFSET, offsetOf_[i], i, offsets[i]);
    }
    for (int row = 0; row < this->offsets(); row++)
    {
        const size_t i = coordinates_[row];
        if (!revolute[i]) continue;
        add(Term::GAIN, row, i, params.gain);
        add(Term::PLAY, row, i, params.play);
        if (row > 0 && !jaw[i] && revolute[coordinates_[row - 1]]) add(Term::COUPLING, row, coordinates_[row - 1], params.coupling);
    }
}

void JointErrors::hang(const double* before, const double* now, size_t n, double* directions)
{
    for (size_t i = 0; i < n; i++) directions[i] = std::min(std::max(directions[i] + (now[i] - before[i]) / playWidth, -1.), 1.);
}

void JointErrors::phi(const double* readings, const double* reference, const double* directions, Matrix& result) const
{
    result.setZero(offsets(), size());
    for (int k = 0; k < size(); k++)
    {
        const Term& t = terms_[k];
        result(t.row, k) = t.kind == Term::OFFSET ? 1 : t.kind == Term::PLAY ? directions[t.coordinate] : readings[t.coordinate] - reference[t.coordinate];
    }
}

}} // namespace cv::surgtrack
