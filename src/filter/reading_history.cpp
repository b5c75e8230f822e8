// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "filter/reading_history.hpp"

namespace cv { namespace surgtrack {

// Twice what the wrists of the paper's recording do, and four times what its arms do.
static const double fastestTurn = 18, fastestSlide = 0.25;   // [rad/s], [m/s]

ReadingHistory::ReadingHistory(const ToolModel& model)
    : n_(model.coordinateNames().size()), last_(0), count_(0), values_(frames * n_), ages_(frames), fastest_(n_, fastestTurn)
{
    for (size_t l = 0; l < model.links().size(); l++)
        if (model.links()[l].jointType == ToolModel::JOINT_PRISMATIC) fastest_[model.links()[l].coordinate] = fastestSlide;
}

void ReadingHistory::add(const double* readings, double seconds)
{
    bool jumps = seconds > longestGap;
    for (size_t i = 0; i < n_ && !jumps && count_ > 0 && seconds > 0; i++) jumps = std::abs(readings[i] - of(0)[i]) > fastest_[i] * seconds;
    if (jumps) count_ = 0;
    if (seconds > shortestGap || count_ == 0)
    {
        last_ = (last_ + 1) % frames;
        count_ = std::min(count_ + 1, int(frames));
        ages_[last_] = seconds;
    }
    std::copy(readings, readings + n_, &values_[last_ * n_]);
}

void ReadingHistory::at(double seconds, double* difference, double* rate) const
{
    std::fill(difference, difference + n_, 0.);
    std::fill(rate, rate + n_, 0.);
    if (count_ < 2) return;
    // The interval that the time is in; later than the newest, and earlier than the oldest, the nearest one goes on.
    int back = 0;
    double end = 0;
    while (back < count_ - 2 && seconds < end - ages_[(last_ + frames - back) % frames])
    {
        end -= ages_[(last_ + frames - back) % frames];
        back++;
    }
    const double *to = of(back), *from = of(back + 1), *newest = of(0), length = ages_[(last_ + frames - back) % frames];
    for (size_t i = 0; i < n_; i++)
    {
        rate[i] = (to[i] - from[i]) / length;
        difference[i] = to[i] + rate[i] * (seconds - end) - newest[i];
    }
}

}} // namespace cv::surgtrack
