// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_losses.hpp"

namespace opencv_test { namespace {

/* SURGTRACK_LOSS_TRIALS=100 measures with so many seeds a kind of loss, of which SURGTRACK_LOSS_SEED (1) is the first, in images
   SURGTRACK_LOSS_WIDTH (720) pixels wide. SURGTRACK_TEST_PRINT=1 prints the frames of trials that fail. */
int numberOf(const char* variable, int otherwise)
{
    const char* const text = std::getenv(variable);
    return text ? std::atoi(text) : otherwise;
}

LossFigures measure(Loss loss, int firstSeed, int trials, Size size)
{
    LossFigures figures;
    for (int seed = firstSeed; seed < firstSeed + trials; seed++) runTrial(loss, seed, size, figures);
    return figures;
}

void check(const LossFigures& f)
{
    EXPECT_EQ(f.trials, f.flagged);
    EXPECT_GE(f.recovered, cvFloor(0.95 * f.trials));   // the goal; of a few trials one may fail
    EXPECT_EQ(0, f.silent);
    EXPECT_EQ(0, f.blind);
    EXPECT_LE(f.alarms, std::max(1., 0.01 * f.visible));              // the goal; one frame in a short run is none
    EXPECT_LE(f.disturbed, 0.01 * f.beside);            // as for false alarms
}

struct LossNames
{
    template <typename Info> std::string operator()(const Info& info) const { return lossName(info.param); }
};

class SurgTrack_Losses : public testing::TestWithParam<int> {};

TEST_P(SurgTrack_Losses, areFlaggedAndRecovered)
{
    const LossFigures f = measure(Loss(GetParam()), 1, 3, Size(480, 384));
    if (std::getenv("SURGTRACK_TEST_PRINT")) printFigures(Loss(GetParam()), f);
    check(f);
}

TEST_P(SurgTrack_Losses, areFlaggedAndRecoveredInManyTrials)
{
    const int trials = numberOf("SURGTRACK_LOSS_TRIALS", 0), width = numberOf("SURGTRACK_LOSS_WIDTH", 720);
    if (trials <= 0) throw SkipTestException("SURGTRACK_LOSS_TRIALS, the number of trials a kind of loss, is not set");
    const LossFigures f = measure(Loss(GetParam()), numberOf("SURGTRACK_LOSS_SEED", 1), trials, Size(width, width * 4 / 5));
    printFigures(Loss(GetParam()), f);
    check(f);
}

INSTANTIATE_TEST_CASE_P(All, SurgTrack_Losses, testing::Range(0, int(LOSSES)), LossNames());

}} // namespace
