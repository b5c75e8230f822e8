// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "perf_common.hpp"

namespace opencv_test { namespace {

typedef TestBaseWithParam<tuple<Size, int> > Size_Tools_Tracker;

// A scene of a few frames, played to and fro so that motion never jumps.
struct Player
{
    Player(Size size, int tools) : frames(6), shown(0), scene(SyntheticScene::create(Ptr<ToolModel>(), sceneOf(size, tools))), images(frames), joints(frames)
    {
        tracker = ToolTracker::create(scene->camera());
        for (int i = 0; i < tools; i++) tracker->addTool(scene->model(), scene->nominal_T_base(i));
        for (int frame = 0; frame < frames; frame++)
        {
            images[frame] = drawn(sceneOf(size, tools), frame);
            for (int i = 0; i < tools; i++) joints[frame].push_back(scene->recordedJoints(i, frame / 25.));
        }
    }

    void next()
    {
        const int k = shown % (2 * frames - 2), frame = k < frames ? k : 2 * frames - 2 - k;
        tracker->update(images[frame], shown++ / 25., joints[frame], estimates);
    }

    bool tracksAll() const
    {
        for (size_t i = 0; i < estimates.size(); i++)
            if (estimates[i].state != STATE_TRACKING) return false;
        return !estimates.empty();
    }

    const int frames;
    int shown;
    Ptr<SyntheticScene> scene;
    std::vector<Mat> images;
    std::vector<std::vector<std::vector<double> > > joints;
    Ptr<ToolTracker> tracker;
    std::vector<ToolEstimate> estimates;
};

PERF_TEST_P(Size_Tools_Tracker, update, testing::Combine(SURGTRACK_SIZES, testing::Values(1, 2, 4)))
{
    Player player(get<0>(GetParam()), get<1>(GetParam()));
    for (int i = 0; i < 20 && (i < 3 || !player.tracksAll()); i++) player.next();
    TEST_CYCLE() player.next();
    for (size_t i = 0; i < player.estimates.size(); i++) EXPECT_EQ(STATE_TRACKING, player.estimates[i].state);
    SANITY_CHECK_NOTHING();
}

// The first frame: several hypotheses for each tool.
PERF_TEST_P(Size_Tools_Tracker, initialization, testing::Combine(SURGTRACK_SIZES, testing::Values(1, 2)))
{
    Player player(get<0>(GetParam()), get<1>(GetParam()));
    player.next();
    TEST_CYCLE()
    {
        player.tracker->reset();
        player.next();
    }
    for (size_t i = 0; i < player.estimates.size(); i++) EXPECT_EQ(STATE_INITIALIZING, player.estimates[i].state);
    SANITY_CHECK_NOTHING();
}

}} // namespace
