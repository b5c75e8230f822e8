// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "perf_common.hpp"

namespace opencv_test { namespace {

typedef TestBaseWithParam<tuple<Size, int> > Size_Tools_Tracker;

// A scene of a few frames, played to and fro so that motion never jumps.
struct Player
{
    Player(Size size, int tools, int method = METHOD_PAPER, bool stereo = false) : frames(6), shown(0), images(frames), rightImages(frames), joints(frames)
    {
        SyntheticScene::Params params = sceneOf(size, tools);
        params.stereo = stereo;
        scene = SyntheticScene::create(Ptr<ToolModel>(), params);
        ToolTracker::Params options;
        options.method = method;
        tracker = ToolTracker::create(scene->camera(), options);
        if (stereo) tracker->setRightCamera(scene->camera(true), scene->right_T_left());
        for (int i = 0; i < tools; i++) tracker->addTool(scene->model(), scene->nominal_T_base(i));
        for (int frame = 0; frame < frames; frame++)
        {
            images[frame] = drawn(params, frame);
            if (stereo) rightImages[frame] = drawn(params, frame, true);
            for (int i = 0; i < tools; i++) joints[frame].push_back(scene->recordedJoints(i, frame / 25.));
        }
    }

    void next()
    {
        const int k = shown % (2 * frames - 2), frame = k < frames ? k : 2 * frames - 2 - k;
        const double time = shown++ / 25.;
        if (rightImages[frame].empty()) tracker->update(images[frame], time, joints[frame], estimates);
        else tracker->updateStereo(images[frame], rightImages[frame], time, joints[frame], estimates);
    }

    // A start takes several frames.
    void start()
    {
        for (int i = 0; i < 20 && (i < 3 || !tracksAll()); i++) next();
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
    std::vector<Mat> images, rightImages;
    std::vector<std::vector<std::vector<double> > > joints;
    Ptr<ToolTracker> tracker;
    std::vector<ToolEstimate> estimates;
};

PERF_TEST_P(Size_Tools_Tracker, update, testing::Combine(SURGTRACK_SIZES, testing::Values(1, 2, 4)))
{
    Player player(get<0>(GetParam()), get<1>(GetParam()));
    player.start();
    TEST_CYCLE() player.next();
    for (size_t i = 0; i < player.estimates.size(); i++) EXPECT_EQ(STATE_TRACKING, player.estimates[i].state);
    SANITY_CHECK_NOTHING();
}

// With joint offsets and outlines.
PERF_TEST_P(Size_Tools_Tracker, updateFull, testing::Combine(testing::Values(Size(720, 576), Size(1920, 1080)), testing::Values(1, 2)))
{
    Player player(get<0>(GetParam()), get<1>(GetParam()), METHOD_FULL);
    player.start();
    TEST_CYCLE() player.next();
    for (size_t i = 0; i < player.estimates.size(); i++) EXPECT_EQ(STATE_TRACKING, player.estimates[i].state);
    SANITY_CHECK_NOTHING();
}

// The same with both eyes.
PERF_TEST_P(Size_Tools_Tracker, updateStereo, testing::Combine(testing::Values(Size(720, 576)), testing::Values(2)))
{
    Player player(get<0>(GetParam()), get<1>(GetParam()), METHOD_FULL, true);
    player.start();
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
