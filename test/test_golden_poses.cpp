// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// How far from the truth the poses of the built-in sequences are: no way of tracking may lose, or silently gain, a factor of two.

#include "test_tracking.hpp"

namespace opencv_test { namespace {

enum Way { FULL, FULL_AHEAD, FULL_STEREO, PAPER, EPNP, WAYS };

const char* const wayNames[WAYS] = {"full", "fullAhead", "fullStereo", "paper", "epnp"};

struct WayNames
{
    template <typename Info> std::string operator()(const Info& info) const { return wayNames[info.param]; }
};

const int SEQUENCES = 2, FRAMES = 25;

// The first has one tool; the second two, seen through a distorting lens.
const Recording& sequence(int index)
{
    static Ptr<Recording> recordings[SEQUENCES];
    if (!recordings[index])
    {
        SyntheticScene::Params params = scene(index + 1, index + 1, Size(720, 576), index == 1);
        params.stereo = true;
        recordings[index] = makePtr<Recording>(params, FRAMES);
    }
    return *recordings[index];
}

Ptr<ToolTracker> trackerOf(const Recording& r, Way way)
{
    static const int methods[WAYS] = {METHOD_FULL, METHOD_FULL, METHOD_FULL, METHOD_PAPER, METHOD_EPNP};
    return way == FULL_STEREO ? r.stereoTracker() : r.tracker(methods[way]);
}

struct Golden
{
    Way way;
    int sequence, tool;
    double translation, rotation;   // mean errors [mm], [mrad]
    int covered;                    // of 25 frames
};

// SURGTRACK_TEST_PRINT=1 prints the rows anew.
const Golden golden[] = {
    {FULL, 0, 0, 0.12, 6.0, 25},
    {FULL, 1, 0, 0.22, 9.6, 25},
    {FULL, 1, 1, 0.09, 5.5, 25},
    {FULL_AHEAD, 0, 0, 0.13, 5.2, 25},
    {FULL_AHEAD, 1, 0, 0.22, 9.6, 25},
    {FULL_AHEAD, 1, 1, 0.09, 5.5, 25},
    {FULL_STEREO, 0, 0, 0.10, 4.8, 25},
    {FULL_STEREO, 1, 0, 0.20, 6.3, 25},
    {FULL_STEREO, 1, 1, 0.07, 4.6, 25},
    {PAPER, 0, 0, 0.81, 54.5, 24},
    {PAPER, 1, 0, 1.64, 18.3, 24},
    {PAPER, 1, 1, 0.72, 24.0, 24},
    {EPNP, 0, 0, 2.38, 42.0, 24},
    {EPNP, 1, 0, 1.89, 49.1, 24},
    {EPNP, 1, 1, 2.46, 59.7, 24}};

class SurgTrack_GoldenPoses : public testing::TestWithParam<int> {};

TEST_P(SurgTrack_GoldenPoses, areAsGoodAsTheyWere)
{
    const Way way = Way(GetParam());
    const Eyes eyes = way == FULL_STEREO ? BOTH : way == FULL_AHEAD ? AHEAD : LEFT;
    int compared = 0;
    for (int i = 0; i < SEQUENCES; i++)
    {
        const std::vector<Score> scores = scoresOf(sequence(i), *trackerOf(sequence(i), way), eyes);
        for (int tool = 0; tool + 1 < int(scores.size()); tool++)
        {
            const Score& s = scores[tool];
            static const char* const constants[WAYS] = {"FULL", "FULL_AHEAD", "FULL_STEREO", "PAPER", "EPNP"};
            if (std::getenv("SURGTRACK_TEST_PRINT"))
                std::cout << format("    {%s, %d, %d, %.2f, %.1f, %d},", constants[way], i, tool, s.translation * 1e3, s.rotation * 1e3, s.covered) << std::endl;
            for (const Golden& g : golden)
            {
                if (g.way != way || g.sequence != i || g.tool != tool) continue;
                compared++;
                EXPECT_LE(s.translation * 1e3, 2 * g.translation) << "sequence " << i << ", tool " << tool;
                EXPECT_LE(s.rotation * 1e3, 2 * g.rotation) << "sequence " << i << ", tool " << tool;
                EXPECT_GE(s.translation * 1e3, 0.5 * g.translation) << "sequence " << i << ", tool " << tool << ": better than the table, which is to be renewed";
                EXPECT_GE(s.rotation * 1e3, 0.5 * g.rotation) << "sequence " << i << ", tool " << tool << ": better than the table, which is to be renewed";
                EXPECT_GE(s.covered, g.covered - 1) << "sequence " << i << ", tool " << tool;   // a first frame may be a chance
                if (way != EPNP) EXPECT_EQ(0, s.silent) << "sequence " << i << ", tool " << tool;
            }
        }
    }
    EXPECT_EQ(3, compared);   // of one tool and two
}

INSTANTIATE_TEST_CASE_P(All, SurgTrack_GoldenPoses, testing::Range(0, int(WAYS)), WayNames());

// Of later frames scoresOf() says it.
TEST(SurgTrack_Tracker, firstFramesHaveNoMoreInliersThanVisibleParts)
{
    for (int seed = 1; seed <= 4; seed++)
    {
        SyntheticScene::Params params = scene(seed, 1 + seed % 2, Size(480, 384), seed > 2);
        params.stereo = true;
        const Recording r(params, 0);
        for (int frame = 0; frame <= 18; frame += 6)
        {
            Mat left, right;
            r.scene->render(frame, left);
            r.scene->render(frame, right, true);
            for (int way = 0; way < 2; way++)
            {
                Estimates estimates;
                if (way == 0) r.tracker()->update(left, r.time(frame), r.joints(frame), estimates);
                else r.stereoTracker()->updateStereo(left, right, r.time(frame), r.joints(frame), estimates);
                for (const ToolEstimate& e : estimates)
                {
                    EXPECT_LE(e.inliers, e.visibleParts) << "seed " << seed << ", frame " << frame << (way ? ", both eyes" : "");
                    EXPECT_EQ(e.inliers, int(e.matches.size()));
                }
            }
        }
    }
}

}} // namespace
