// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "filter/exact_readings.hpp"

namespace cv { namespace surgtrack {

static const size_t mostGroups = 2;   // two to the power of it are the hypotheses

void ExactReadings::add(const std::vector<int>& states, const std::vector<double>& priors)
{
    if (states.empty() || !(probability_ > 0)) return;
    CV_Assert(groups_.size() < mostGroups && states.size() == priors.size());
    Group group = {states, 0};
    for (size_t i = 0; i < priors.size(); i++) group.logPrior += std::log(priors[i]);
    groups_.push_back(group);
}

void ExactReadings::mix(const Vector& theta, const Matrix& P, Vector& shift, Matrix* mixed) const
{
    const int n = int(P.rows()), hypotheses = 1 << groups_.size();
    shift.setZero(n);
    if (mixed) *mixed = P;
    if (hypotheses == 1) return;
    double weights[1 << mostGroups], most = 0;
    Vector shifts[1 << mostGroups];
    Matrix gains[1 << mostGroups];   // P less the square of it is the covariance
    weights[0] = 0;
    shifts[0].setZero(n);
    for (int h = 1; h < hypotheses; h++)
    {
        int zeros[maxStates], k = 0;
        weights[h] = 0;
        for (size_t g = 0; g < groups_.size(); g++)
        {
            if (!(h >> g & 1)) continue;
            std::copy(groups_[g].states.begin(), groups_[g].states.end(), zeros + k);
            k += int(groups_[g].states.size());
            weights[h] += groups_[g].logPrior + std::log(probability_ / (1 - probability_));
        }
        Matrix inner(k, k), outer(k, n);
        Vector mean(k);
        for (int i = 0; i < k; i++)
        {
            outer.row(i) = P.row(zeros[i]);
            for (int j = 0; j < k; j++) inner(i, j) = P(zeros[i], zeros[j]);
            mean[i] = theta[zeros[i] - 6];
        }
        const Eigen::LLT<Matrix> root(inner);
        const Matrix L = root.matrixL();
        gains[h] = root.matrixL().solve(outer);
        const Vector white = root.matrixL().solve(mean);
        weights[h] -= 0.5 * white.squaredNorm() + L.diagonal().array().log().sum();
        shifts[h] = -gains[h].transpose() * white;
        most = std::max(most, weights[h]);
    }
    double sum = 0;
    for (int h = 0; h < hypotheses; h++) sum += weights[h] = std::exp(weights[h] - most);
    for (int h = 1; h < hypotheses; h++) shift += weights[h] / sum * shifts[h];
    if (!mixed) return;
    for (int h = 0; h < hypotheses; h++)
    {
        const Vector apart = shifts[h] - shift;
        if (h > 0) mixed->noalias() -= weights[h] / sum * gains[h].transpose() * gains[h];
        mixed->noalias() += weights[h] / sum * apart * apart.transpose();
    }
}

}} // namespace cv::surgtrack
