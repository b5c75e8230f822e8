// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_common.hpp"
#include "track/evidence.hpp"

namespace opencv_test { namespace {

Evidence evidence(double similarity, double support, int parts = 8, double nis = 0.1)
{
    Evidence e;
    e.similarity = similarity;
    e.support = support;
    e.nis = nis;
    e.parts = parts;
    e.points = parts > 0;
    return e;
}

const EvidenceThresholds T;

TEST(SurgTrack_Evidence, partsAndOutlineAddUp)
{
    // More parts, more alike, on a larger share of the outline, that fit better: more likely. Half of it is not enough.
    const double right = evidence(0.75, 0.6).logOdds();
    EXPECT_GT(right, T.sure);
    EXPECT_LT(evidence(0.75, 0.6, 4).logOdds(), right);
    EXPECT_LT(evidence(0.65, 0.6).logOdds(), right);
    EXPECT_LT(evidence(0.75, 0.4).logOdds(), right);
    EXPECT_LT(evidence(0.75, 0.6, 8, 0.5).logOdds(), right);
    EXPECT_LT(evidence(0.75, 0.1).logOdds(), T.first);   // parts that look right in the wrong place
    EXPECT_LT(evidence(0.5, 0.5).logOdds(), T.first);   // an outline of tissue
}

TEST(SurgTrack_Evidence, partsLikeTissueTellNothing)
{
    const EvidenceModel model;
    EXPECT_DOUBLE_EQ(evidence(model.tissue, 0.6).logOdds(), evidence(model.tissue - 0.3, 0.6).logOdds());
    EXPECT_DOUBLE_EQ(evidence(model.tissue, 0.6, 8).logOdds(), evidence(model.tissue, 0.6, 2).logOdds());
}

TEST(SurgTrack_Evidence, whatCannotBeIsNotBelieved)
{
    Evidence e = evidence(0.9, 0.9);
    EXPECT_GT(e.logOdds(), T.sure);
    e.plausible = false;
    EXPECT_LT(e.logOdds(), T.first - T.prior);
}

TEST(SurgTrack_Evidence, growsWithWhatItIsAskedFor)
{
    // One that is followed needs least, one that is sure at once most.
    EXPECT_LT(T.followed - T.prior, T.first);
    EXPECT_LT(T.first, T.confirmed);
    EXPECT_LT(T.confirmed, T.sure);
    // An outline alone goes on where it is well supported, and begins nothing: 20 px off it is 0.31 at most.
    EXPECT_GT(evidence(0, 0.55, 0, 0).logOdds() + T.prior, T.followed);
    EXPECT_LT(evidence(0, 0.31, 0, 0).logOdds() + T.prior, T.followed);
    EXPECT_FALSE(evidence(0, 1, 0).isFirstPose(T));
}

TEST(SurgTrack_Evidence, moreConfidenceIsMoreOfAllThatIsAskedFor)
{
    const EvidenceThresholds more(0.9), none(0);
    EXPECT_NEAR(0.9, probability(more.first), 1e-12);   // rounding
    EXPECT_NEAR(T.sure - T.first, more.sure - more.first, 1e-12);
    EXPECT_NEAR(T.followed - T.first, more.followed - more.first, 1e-12);
    EXPECT_TRUE(evidence(0.5, 0, 5, 2).isFirstPose(none));
    Evidence e = evidence(0.9, 0.9);
    e.plausible = false;
    EXPECT_FALSE(e.isFirstPose(none));   // what cannot be never is
}

TEST(SurgTrack_Evidence, aFirstPoseNeedsMoreThanFourParts)
{
    EXPECT_FALSE(evidence(0.8, 0.6, T.minParts).isFirstPose(T));
    EXPECT_TRUE(evidence(0.8, 0.6, T.minParts + 1).isFirstPose(T));
    EXPECT_TRUE(evidence(0.8, 0.6, 6).isSure(T, 6));
    EXPECT_FALSE(evidence(0.8, 0.6, 5).isSure(T, 6));
    EXPECT_FALSE(evidence(0.8, 0.6, 6, 2).isSure(T, 6));   // points that do not fit
}

TEST(SurgTrack_Evidence, isAProbability)
{
    EXPECT_DOUBLE_EQ(0.5, probability(0));
    EXPECT_NEAR(0.9, probability(T.confirmed), 0.005);   // as said beside the thresholds
    EXPECT_NEAR(0.98, probability(T.sure), 0.005);
    EXPECT_NEAR(0.73, probability(T.followed), 0.005);
}

}} // namespace
