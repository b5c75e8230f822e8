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

TEST(SurgTrack_Evidence, isTheSumUnlessOneHalfIsTissue)
{
    EXPECT_DOUBLE_EQ(1.4, evidence(0.8, 0.6).sum(T));
    EXPECT_EQ(0, evidence(T.leastSimilarity - 0.01, 0.9).sum(T));
    EXPECT_EQ(0, evidence(0.9, T.leastSupport - 0.01).sum(T));
}

TEST(SurgTrack_Evidence, growsWithWhatItIsAskedFor)
{
    // One that is followed needs least, one that is sure at once most.
    EXPECT_LT(T.followed, T.start);
    EXPECT_LT(T.start, T.sure);
    EXPECT_LE(T.leastSupport, T.startSupport);
    EXPECT_LT(T.startSupport, T.outlineAlone);
}

TEST(SurgTrack_Evidence, aToolThatIsFollowedNeedsLess)
{
    const Evidence weak = evidence(0.6, 0.4);   // 1.0
    EXPECT_TRUE(weak.continues(T, STATE_TRACKING));
    EXPECT_FALSE(weak.continues(T, STATE_COASTING));
    EXPECT_FALSE(weak.continues(T, STATE_INITIALIZING));
    EXPECT_FALSE(weak.isStart(T));
    const Evidence strong = evidence(0.7, 0.5);   // 1.2
    for (int state = STATE_INITIALIZING; state <= STATE_LOST; state++) EXPECT_TRUE(strong.continues(T, state)) << state;
}

TEST(SurgTrack_Evidence, anOutlineAloneOnlyContinues)
{
    const Evidence outline = evidence(0, T.outlineAlone, 0);
    EXPECT_TRUE(outline.continues(T, STATE_TRACKING));
    EXPECT_TRUE(outline.continues(T, STATE_COASTING));
    EXPECT_FALSE(outline.continues(T, STATE_INITIALIZING));
    EXPECT_FALSE(outline.continues(T, STATE_LOST));
    EXPECT_FALSE(evidence(0, T.outlineAlone - 0.01, 0).continues(T, STATE_TRACKING));
    EXPECT_FALSE(outline.isStart(T));
}

TEST(SurgTrack_Evidence, aStartNeedsBothHalves)
{
    EXPECT_TRUE(evidence(0.8, T.startSupport).isStart(T));
    EXPECT_FALSE(evidence(1, T.startSupport - 0.01).isStart(T));   // parts that look right in the wrong place
    EXPECT_FALSE(evidence(0.8, 0.5, T.minParts).isFirstPose(T));
    EXPECT_TRUE(evidence(0.8, 0.5, T.minParts + 1).isFirstPose(T));
}

TEST(SurgTrack_Evidence, toBeSureTakesPointsThatFit)
{
    EXPECT_TRUE(evidence(0.8, 0.6, 6).isSure(T, 6));
    EXPECT_FALSE(evidence(0.8, 0.6, 5).isSure(T, 6));
    EXPECT_FALSE(evidence(0.7, 0.5, 6).isSure(T, 6));
    EXPECT_FALSE(evidence(0.8, 0.6, 6, T.sureNis + 0.01).isSure(T, 6));
}

TEST(SurgTrack_Evidence, pointsThatFitBadlyTakeFromTheMerit)
{
    EXPECT_GT(evidence(0.8, 0.6, 8, 0.1).merit(T), evidence(0.8, 0.6, 8, 0.5).merit(T));
    EXPECT_GT(evidence(0.8, 0.6, 8, 0.5).merit(T), evidence(0.6, 0.6, 8, 0.5).merit(T));
}

}} // namespace
