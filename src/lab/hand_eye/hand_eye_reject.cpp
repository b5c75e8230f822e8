// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "lab/hand_eye/hand_eye_reject.hpp"

namespace cv { namespace surgtrack {

namespace {

const int leastToReject = 6;
const int sampleSize = 4, samples = 200;
const size_t mostGroups = 30;    // more poses than this are left out several at a time

Indices allOf(const HandEyeProblem& problem)
{
    Indices all;
    for (int i = 0; i < problem.size(); i++) all.push_back(i);
    return all;
}

double median(std::vector<double> values)
{
    std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
    return values[values.size() / 2];
}

//! The solution of a quadruple that has the smallest median error. @return false if none has any
bool leastMedian(const HandEyeProblem& problem, int seed, HandEye& best)
{
    RNG rng(seed);
    double least = DBL_MAX;
    for (int k = 0; k < samples; k++)
    {
        Indices sample;
        while ((int)sample.size() < sampleSize)
        {
            const int pose = rng.uniform(0, problem.size());
            if (std::find(sample.begin(), sample.end(), pose) == sample.end()) sample.push_back(pose);
        }
        HandEye candidate;
        if (!problem.solve(HAND_EYE_SHAH, sample, candidate)) continue;
        std::vector<double> errors;
        for (int i = 0; i < problem.size(); i++) errors.push_back(problem.weighted(problem.error(candidate, i).e));
        const double m = median(errors);
        if (m < least)
        {
            least = m;
            best = candidate;
        }
    }
    return least < DBL_MAX;
}

/* Errors of all poses as predicted from the kept ones without the pose itself: the error of a pose that took part in a fit is smaller
   than that of one that did not, by much if there are few. */
bool predictedErrors(const HandEyeProblem& problem, const Indices& kept, std::vector<Vec6d>& errors)
{
    const std::vector<Indices> groups = groupsOf(allOf(problem));
    std::vector<uchar> solved(groups.size());
    errors.resize(problem.size());
    parallel_for_(Range(0, (int)groups.size()), [&](const Range& range)
    {
        for (int g = range.start; g < range.end; g++)
        {
            HandEye solution;
            const Indices others = without(kept, groups[g]);
            solved[g] = problem.solve(HAND_EYE_SHAH, others, solution);
            if (solved[g]) problem.refine(others, solution);
            for (size_t i = 0; i < groups[g].size() && solved[g]; i++) errors[groups[g][i]] = problem.error(solution, groups[g][i]).e;
        }
    });
    return std::count(solved.begin(), solved.end(), 0) == 0;
}

//! The half of the poses that the solution fits best.
Indices betterHalf(const HandEyeProblem& problem, const HandEye& solution)
{
    std::vector<std::pair<double, int> > order;
    for (int i = 0; i < problem.size(); i++) order.push_back(std::make_pair(problem.weighted(problem.error(solution, i).e), i));
    std::sort(order.begin(), order.end());
    Indices half;
    for (int i = 0; i < problem.size() / 2 + 1; i++) half.push_back(order[i].second);
    std::sort(half.begin(), half.end());
    return half;
}

} // namespace

std::vector<Indices> groupsOf(const Indices& poses)
{
    std::vector<Indices> groups(std::min(poses.size(), mostGroups));
    for (size_t i = 0; i < poses.size(); i++) groups[i % groups.size()].push_back(poses[i]);
    return groups;
}

Indices without(const Indices& poses, const Indices& group)
{
    Indices rest;
    for (size_t i = 0; i < poses.size(); i++)
        if (std::find(group.begin(), group.end(), poses[i]) == group.end()) rest.push_back(poses[i]);
    return rest;
}

Indices keptPoses(HandEyeProblem& problem, double rejection, int seed)
{
    const Indices all = allOf(problem);
    std::vector<Vec6d> errors;
    HandEye start;
    const bool reject = rejection > 0 && problem.size() >= leastToReject && leastMedian(problem, seed, start);
    Indices kept = reject ? betterHalf(problem, start) : all;
    for (int iteration = 0; iteration < 20; iteration++)
    {
        if (!predictedErrors(problem, kept, errors)) return all;
        problem.weigh(errors);
        Indices next;
        for (size_t i = 0; i < all.size(); i++)
            if (!reject || problem.weighted(errors[i]) <= rejection) next.push_back(all[i]);
        if (next == kept) break;
        kept = next;
    }
    return kept;
}

}} // namespace cv::surgtrack
