// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_tracking.hpp"

namespace opencv_test { namespace {

class SurgTrack_TrackerStates : public testing::TestWithParam<int>
{
public:
    SurgTrack_TrackerStates() : farthest_(0) {}

    ~SurgTrack_TrackerStates()
    {
        if (std::getenv("SURGTRACK_TEST_PRINT") && farthest_ > 0) std::cout << "at most " << farthest_ * 1e3 << " mm" << std::endl;
    }

protected:
    void add(const ToolEstimate& e, int frame) { farthest_ = std::max(farthest_, distance(e.camera_T_tool, common().scene->truePose(0, common().time(frame)))); }

    double farthest_;   // from the truth, of the frames added [m]
};

TEST_P(SurgTrack_TrackerStates, tissueWithoutAToolIsNeverTracked)
{
    // The calibration puts the tool 3.6 cm beside where it is: there is nothing but tissue in the search windows.
    const Recording& r = common();
    const Point3d beside[] = {Point3d(-0.03, -0.02, 0), Point3d(-0.03, 0.02, 0)};
    for (const Point3d& shift : beside)
    {
        ToolTracker::Params params;
        params.method = GetParam();
        Ptr<ToolTracker> tracker = ToolTracker::create(r.scene->camera(), params);
        tracker->addTool(r.scene->model(), rigid(Matx33d::eye(), shift) * r.scene->nominal_T_base(0));
        for (int frame = 0; frame < 8; frame++)
        {
            const ToolEstimate e = r.update(*tracker, frame)[0];
            EXPECT_EQ(STATE_INITIALIZING, e.state) << frame;
            EXPECT_EQ(0, cv::norm(e.camera_T_nominal - Matx44d::eye(), NORM_INF)) << frame;   // the pose is that of the kinematics
        }
    }
}

TEST_P(SurgTrack_TrackerStates, noiseIsNeverTracked)
{
    // Edges everywhere in all directions: every template finds half of its features anywhere.
    const Recording& r = common();
    for (int smooth = 0; smooth < 2; smooth++)
        for (int seed = 1; seed <= 2; seed++)
        {
            Ptr<ToolTracker> tracker = r.tracker(GetParam());
            for (int frame = 0; frame < 8; frame++)
            {
                Mat image = textured(Size(720, 576), 3, 1000 * seed + frame, 40, 220);
                if (smooth) GaussianBlur(image, image, Size(), 2);
                if (smooth) cv::normalize(image, image, 60, 180, NORM_MINMAX);
                Estimates e;
                tracker->update(image, r.time(frame), r.joints(frame), e);
                EXPECT_EQ(STATE_INITIALIZING, e[0].state) << "smooth " << smooth << ", seed " << seed << ", frame " << frame;
            }
        }
}

TEST_P(SurgTrack_TrackerStates, blackFramesAreCoastedThenLostAndTheToolIsFoundAgain)
{
    const Recording& r = common();
    ToolTracker::Params params;
    params.method = GetParam();
    params.coastingTime = 0.21;   // five frames
    Ptr<ToolTracker> tracker = r.tracker(params);
    Estimates e;
    for (int frame = 0; frame < 8; frame++) e = r.update(*tracker, frame);
    ASSERT_EQ(STATE_TRACKING, e[0].state);
    const Matx44d correction = e[0].camera_T_nominal;
    const double certain = trace(Mat(e[0].covariance))[0];
    for (int frame = 8; frame < 18; frame++)
    {
        tracker->update(Mat::zeros(576, 720, CV_8UC3), r.time(frame), r.joints(frame), e);
        EXPECT_EQ(frame <= 12 ? STATE_COASTING : STATE_LOST, e[0].state) << frame;
        EXPECT_EQ(0, e[0].inliers);
        EXPECT_EQ(0, e[0].similarity);
        EXPECT_EQ(0, cv::norm(e[0].camera_T_nominal - correction, NORM_INF));   // the last correction is kept
        EXPECT_GT(trace(Mat(e[0].covariance))[0], certain);
    }
    for (int frame = 18; frame < r.frames(); frame++)
    {
        e = r.update(*tracker, frame);
        if (frame < 20) continue;
        EXPECT_EQ(STATE_TRACKING, e[0].state) << frame;
        add(e[0], frame);
    }
    EXPECT_LT(farthest_, GetParam() == METHOD_FULL ? 0.00028 : 0.0028);   // measured: 0.15, 1.5 mm
}

TEST_P(SurgTrack_TrackerStates, shortBlackoutsAreCoasted)
{
    const Recording& r = common();
    Ptr<ToolTracker> tracker = r.tracker(GetParam());
    for (int frame = 0; frame < 16; frame++)
    {
        Estimates e;
        const bool black = frame % 5 == 4;
        tracker->update(black ? Mat::zeros(576, 720, CV_8UC3) : r.images[frame], r.time(frame), r.joints(frame), e);
        if (frame == 0) continue;
        EXPECT_EQ(black ? STATE_COASTING : STATE_TRACKING, e[0].state) << frame;
        add(e[0], frame);
    }
    EXPECT_LT(farthest_, GetParam() == METHOD_FULL ? 0.00044 : 0.0024);   // measured: 0.23, 1.2 mm
}

TEST_P(SurgTrack_TrackerStates, resetForgetsOneToolOrAll)
{
    const Recording r(scene(1, 2, Size(480, 384)), 10);
    ToolTracker::Params params;
    params.method = GetParam();
    if (GetParam() == METHOD_FULL) params.minInitialInliers = 14;   // no first pose is a sure one
    Ptr<ToolTracker> tracker = r.tracker(params);
    Estimates e;
    for (int frame = 0; frame < 5; frame++) e = r.update(*tracker, frame);
    ASSERT_EQ(STATE_TRACKING, e[0].state);
    ASSERT_EQ(STATE_TRACKING, e[1].state);
    tracker->reset(1);
    e = r.update(*tracker, 5);
    EXPECT_EQ(STATE_TRACKING, e[0].state);
    EXPECT_EQ(STATE_INITIALIZING, e[1].state);

    // After a reset of all it is as a new one.
    tracker->reset();
    Ptr<ToolTracker> fresh = r.tracker(params);
    for (int frame = 6; frame < r.frames(); frame++) EXPECT_TRUE(same(r.update(*fresh, frame), r.update(*tracker, frame))) << frame;
}

INSTANTIATE_TEST_CASE_P(Methods, SurgTrack_TrackerStates, testing::Values(int(METHOD_FULL), int(METHOD_PAPER)), MethodNames());

TEST(SurgTrack_Tracker, theFirstFrameIsNotTakenForATrack)
{
    Ptr<ToolTracker> tracker = common().tracker(METHOD_PAPER);
    EXPECT_EQ(STATE_INITIALIZING, common().update(*tracker, 0)[0].state);
    EXPECT_EQ(STATE_TRACKING, common().update(*tracker, 1)[0].state);
}

TEST(SurgTrack_Tracker, theFirstFrameIsATrackIfTheEvidenceIsStrong)
{
    const ToolEstimate e = common().update(*common().tracker(METHOD_FULL), 0)[0];
    EXPECT_EQ(STATE_TRACKING, e.state);
    EXPECT_GE(e.confidence, 0.98);   // what one needs without a second frame: log odds of 3.9
    EXPECT_LT(distance(e.camera_T_tool, common().scene->truePose(0, 0)), 0.00023);   // measured: 0.12 mm
}

// A recording of single pictures: between two of them the arms jump, and what was learnt of delays tells nothing of where they are.
TEST(SurgTrack_Tracker, picturesInSuccessionAreFoundWithinThreeShowings)
{
    SyntheticScene::Params p = scene(3, 2);
    p.frames = 100;
    const Ptr<SyntheticScene> still = SyntheticScene::create(needleDriver(), p);
    const Ptr<ToolTracker> tracker = ToolTracker::create(still->camera());
    for (int i = 0; i < 2; i++) tracker->addTool(still->model(), still->nominal_T_base(i));
    double clock = 0;
    for (int frame : {0, 60, 20, 90, 40})
    {
        Mat image;
        still->render(frame, image);
        Estimates e;
        for (int showing = 0; showing < 3; showing++)
            tracker->update(image, clock += 0.04, {still->recordedJoints(0, frame / p.fps), still->recordedJoints(1, frame / p.fps)}, e);
        for (int i = 0; i < 2; i++)
        {
            EXPECT_EQ(STATE_TRACKING, e[i].state) << "frame " << frame << ", tool " << i;
            EXPECT_LT(distance(e[i].camera_T_tool, still->truePose(i, frame / p.fps)), 0.005) << "frame " << frame << ", tool " << i;
        }
    }
}

}} // namespace
