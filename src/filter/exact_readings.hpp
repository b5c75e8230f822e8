// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_FILTER_EXACT_READINGS_HPP
#define OPENCV_SURGTRACK_SRC_FILTER_EXACT_READINGS_HPP

#include "filter/articulated_states.hpp"

namespace cv { namespace surgtrack {

/* A robot may be a good one: with some probability, before anything is seen, a group of the constants of its readings' errors is zero, and
   not just small (a spike beside the slab of the filter's prior; Mitchell, Beauchamp 1988). As constants do not change, the filter that
   has them at zero is the one that learns them, given that they are zero, and the Bayes factor of the two is the density at zero that is
   left of the prior's (Savage, Dickey; in Dickey 1971). What is believed is the mixture of all these. */
class ExactReadings
{
public:
    //! @param probability prior one, that a group is zero
    explicit ExactReadings(double probability) : probability_(probability) {}

    //! Constants that are zero together, or are not. @param states their indices in the state @param priors their standard deviations
    void add(const std::vector<int>& states, const std::vector<double>& priors);

    /** From the filter to the mixture.
    @param theta constants, the state's from the seventh on @param P covariance of the state
    @param shift of the state's mean @param mixed covariance; 0: not asked for */
    void mix(const Vector& theta, const Matrix& P, Vector& shift, Matrix* mixed) const;

private:
    struct Group
    {
        std::vector<int> states;
        double logPrior;   // sum of the logarithms of the deviations
    };

    double probability_;
    std::vector<Group> groups_;
};

}} // namespace cv::surgtrack

#endif
