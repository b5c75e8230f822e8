// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "filter/joint_errors.hpp"

namespace cv { namespace surgtrack {

// Half of the play; only what a coordinate does within it depends on it, the errors at both ends are learnt [rad].
static const double playWidth = 0.02;

void JointErrors::add(Term::Kind kind, int row, size_t coordinate, double prior, const String& name)
{
    if (!(prior > 0) || size() >= maxStates - 7) return;   // a delay has room as well
    const Term term = {kind, row, int(coordinate)};
    terms_.push_back(term);
    priors_.push_back(prior);
    names_.push_back(name);
}

// What the links of a coordinate state, or the default.
static double stated(const ToolModel& model, int coordinate, double ToolModel::Link::*value, double otherwise)
{
    const std::vector<ToolModel::Link>& links = model.links();
    for (size_t l = 0; l < links.size(); l++)
        if (links[l].coordinate == coordinate && links[l].*value >= 0) return links[l].*value;
    return otherwise;
}

JointErrors::JointErrors(const ToolModel& model, const ArticulatedPoseEKF::Params& params, bool wrong) : offsetOf_(model.coordinateNames().size(), -1)
{
    const std::vector<double> offsets = model.offsetDeviations();
    const std::vector<String>& names = model.coordinateNames();
    const std::vector<uchar> jaw = jaws(model);
    for (size_t i = 0; i < offsets.size() && wrong; i++)
    {
        if (!(offsets[i] > 0) || this->offsets() >= ArticulatedPoseEKF::MAX_OFFSETS) continue;
        offsetOf_[i] = this->offsets();
        coordinates_.push_back(int(i));
        add(Term::OFFSET, offsetOf_[i], i, offsets[i], names[i] + " offset");
    }
    std::vector<uchar> turns(offsets.size(), 0);
    for (size_t l = 0; l < model.links().size(); l++)
        if (model.links()[l].jointType == ToolModel::JOINT_REVOLUTE) turns[model.links()[l].coordinate] = 1;
    for (int row = 0; row < this->offsets(); row++)
    {
        const int i = coordinates_[row];
        if (!turns[i]) continue;
        add(Term::GAIN, row, i, stated(model, i, &ToolModel::Link::gainDeviation, params.gain), names[i] + " gain");
        add(Term::PLAY, row, i, stated(model, i, &ToolModel::Link::playDeviation, params.play), names[i] + " play");
        if (row > 0 && !jaw[i] && turns[coordinates_[row - 1]])
            add(Term::COUPLING, row, coordinates_[row - 1], stated(model, i, &ToolModel::Link::couplingDeviation, params.coupling), names[i] + " coupling");
    }
}

std::vector<uchar> JointErrors::jaws(const ToolModel& model)
{
    std::vector<uchar> positive(model.coordinateNames().size(), 0), negative = positive;
    for (size_t l = 0; l < model.links().size(); l++)
        if (model.links()[l].coordinate >= 0) (model.links()[l].scale > 0 ? positive : negative)[model.links()[l].coordinate] = 1;
    for (size_t i = 0; i < positive.size(); i++) positive[i] = positive[i] && negative[i];
    return positive;
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
