// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_tracking.hpp"

namespace opencv_test { namespace {

class SurgTrack_TrackerCalls : public testing::TestWithParam<int> {};

TEST_P(SurgTrack_TrackerCalls, theSameInputGivesTheSameEstimates)
{
    const Recording r(scene(2, 2, Size(480, 384), true), 8);
    Ptr<ToolTracker> first = r.tracker(GetParam()), second = r.tracker(GetParam());
    const int threads = cv::getNumThreads();
    for (int frame = 0; frame < r.frames(); frame++)
    {
        const Estimates a = r.update(*first, frame);
        cv::setNumThreads(1);
        const Estimates b = r.update(*second, frame);
        cv::setNumThreads(threads);
        ASSERT_TRUE(same(a, b)) << frame;
    }
}

TEST_P(SurgTrack_TrackerCalls, badInputIsRejectedAndLeavesTheStateUnchanged)
{
    const Recording& r = common();
    Ptr<ToolTracker> tracker = r.tracker(GetParam()), undisturbed = r.tracker(GetParam());
    for (int frame = 0; frame < 6; frame++)
    {
        const Mat& image = r.images[frame];
        const double time = r.time(frame);
        const Joints joints = r.joints(frame);
        Estimates e;
        Mat deep;
        image.convertTo(deep, CV_16U);
        EXPECT_ERROR(tracker->update(deep, time, joints, e), "image");
        EXPECT_ERROR(tracker->update(Mat(), time, joints, e), "image");
        EXPECT_ERROR(tracker->update(Mat(576, 720, CV_8UC4), time, joints, e), "image");
        EXPECT_ERROR(tracker->update(image.rowRange(0, 575), time, joints, e), "575");
        EXPECT_ERROR(tracker->update(image, NOT_A_NUMBER, joints, e), "time");
        EXPECT_ERROR(tracker->update(image, std::numeric_limits<double>::infinity(), joints, e), "time");
        if (frame > 0)
        {
            EXPECT_ERROR(tracker->update(image, r.time(frame - 1), joints, e), "time");
            EXPECT_ERROR(tracker->update(image, r.time(frame - 1) - 1, joints, e), "time");
        }
        Joints bad = joints;
        bad[0][3] = NOT_A_NUMBER;
        EXPECT_ERROR(tracker->update(image, time, bad, e), "joints[0]");
        bad = joints;
        bad[0].pop_back();
        EXPECT_ERROR(tracker->update(image, time, bad, e), "joints[0]");
        bad.clear();
        EXPECT_ERROR(tracker->update(image, time, bad, e), "joints");
        bad.assign(2, joints[0]);
        EXPECT_ERROR(tracker->update(image, time, bad, e), "joints");
        EXPECT_TRUE(e.empty());
        ASSERT_TRUE(same(r.update(*undisturbed, frame), r.update(*tracker, frame))) << frame;
    }
}

INSTANTIATE_TEST_CASE_P(Methods, SurgTrack_TrackerCalls, testing::Values(int(METHOD_FULL), int(METHOD_PAPER)), MethodNames());

TEST(SurgTrack_Tracker, rejectsBadSetUp)
{
    const CameraModel camera = endoscope();
    EXPECT_THROW(ToolTracker::create(CameraModel()), cv::Exception);
    ToolTracker::Params params;
    params.method = 99;
    EXPECT_ERROR(ToolTracker::create(camera, params), "method");
    params = ToolTracker::Params();
    params.minInitialInliers = 3;
    EXPECT_ERROR(ToolTracker::create(camera, params), "minInitialInliers");
    params = ToolTracker::Params();
    params.initialWindow = 0;
    EXPECT_ERROR(ToolTracker::create(camera, params), "initialWindow");
    const double notProbabilities[] = {-0.1, 1, NOT_A_NUMBER};
    for (double value : notProbabilities)
    {
        params = ToolTracker::Params();
        params.minConfidence = value;
        EXPECT_ERROR(ToolTracker::create(camera, params), "minConfidence");
    }

    Ptr<ToolTracker> tracker = ToolTracker::create(camera);
    Estimates e;
    EXPECT_ERROR(tracker->update(Mat::zeros(576, 720, CV_8UC3), 0, Joints(), e), "tool");
    Matx44d notRigid = Matx44d::eye();
    notRigid(1, 1) = 1.1;
    EXPECT_ERROR(tracker->addTool(needleDriver(), notRigid), "nominal_T_base");
    notRigid(1, 1) = NOT_A_NUMBER;
    EXPECT_ERROR(tracker->addTool(needleDriver(), notRigid), "nominal_T_base");
    EXPECT_THROW(tracker->addTool(Ptr<ToolModel>(), Matx44d::eye()), cv::Exception);
    EXPECT_ERROR(tracker->reset(0), "tool");
    EXPECT_EQ(0, tracker->addTool(needleDriver(), Matx44d::eye()));
    EXPECT_ERROR(tracker->reset(1), "tool");
    EXPECT_ERROR(tracker->reset(-2), "tool");
}

TEST(SurgTrack_Tracker, rejectsAToolWithTooFewKeypoints)
{
    const Ptr<ToolModel> full = needleDriver();
    ToolModel::Description d;
    d.name = "blank";
    d.coordinates = full->coordinateNames();
    d.links = full->links();
    d.meshes = full->meshes();
    d.endEffectorLink = 0;
    Ptr<ToolTracker> tracker = ToolTracker::create(common().scene->camera());
    EXPECT_ERROR(tracker->addTool(ToolModel::create(d), Matx44d::eye()), "keypoints");
}

TEST(SurgTrack_Tracker, timesItsStages)
{
    Ptr<ToolTracker> tracker = common().tracker();
    const char* const expected[] = {"render", "image", "match", "verify", "filter", "contour", "total"};
    std::vector<StageTime> times = tracker->getTimings();
    ASSERT_EQ(7u, times.size());
    for (int i = 0; i < 7; i++)
    {
        EXPECT_EQ(expected[i], times[i].name);
        EXPECT_EQ(0, times[i].calls);
        EXPECT_EQ(0, times[i].mean);
    }
    std::vector<double> sum(7), least(7, DBL_MAX), most(7);
    const int frames = 4;
    for (int frame = 0; frame < frames; frame++)
    {
        common().update(*tracker, frame);
        times = tracker->getTimings();
        double stages = 0;
        for (int i = 0; i < 7; i++)
        {
            EXPECT_EQ(frame + 1, times[i].calls);
            EXPECT_GE(times[i].last, 0) << expected[i];
            if (i < 6) stages += times[i].last;
            sum[i] += times[i].last;
            least[i] = std::min(least[i], times[i].last);
            most[i] = std::max(most[i], times[i].last);
        }
        EXPECT_GT(stages, 0);
        EXPECT_LE(stages, times[6].last + 1e-6);   // the stages are parts of the total; the clock ticks
    }
    for (int i = 0; i < 7; i++)
    {
        EXPECT_NEAR(sum[i] / frames, times[i].mean, 1e-12);   // rounding
        EXPECT_EQ(least[i], times[i].min);
        EXPECT_EQ(most[i], times[i].max);
    }
    tracker->resetTimings();
    EXPECT_EQ(0, tracker->getTimings()[6].calls);
    EXPECT_EQ(0, tracker->getTimings()[6].last);
    common().update(*tracker, frames);
    times = tracker->getTimings();
    EXPECT_EQ(1, times[6].calls);
    EXPECT_EQ(times[6].last, times[6].max);   // nothing is left of the frames before
}

TEST(SurgTrack_Tracker, statesHaveTheNamesOfPosesFiles)
{
    EXPECT_EQ("initializing", stateName(STATE_INITIALIZING));
    EXPECT_EQ("tracking", stateName(STATE_TRACKING));
    EXPECT_EQ("coasting", stateName(STATE_COASTING));
    EXPECT_EQ("lost", stateName(STATE_LOST));
    EXPECT_ERROR(stateName(4), "state");
    EXPECT_ERROR(stateName(-1), "state");
}

TEST(SurgTrack_Tracker, drawsTheSkeletonIntoAnyView)
{
    const CameraModel camera = endoscope();
    Mat image = Mat::zeros(576, 720, CV_8UC3);
    const PosedTool tool;
    drawSkeleton(image, camera, tool.model, tool.joints, tool.view.camera_T_base, Scalar(0, 255, 0));
    std::vector<Mat> planes;
    split(image, planes);
    EXPECT_EQ(0, countNonZero(planes[0]));
    EXPECT_GT(countNonZero(planes[1]), 300);
    for (size_t i = 0; i < tool.model->keypoints().size(); i++)
    {
        const Point2d u = camera.project(tool.keypoint(i));
        EXPECT_GT(planes[1].at<uchar>(cvRound(u.y), cvRound(u.x)), 128) << i;
    }
    // Behind the camera: nothing, and nothing bad.
    Mat empty = Mat::zeros(576, 720, CV_8UC3);
    const PosedTool behind(-0.6, 0, 0);
    drawSkeleton(empty, camera, behind.model, behind.joints, behind.view.camera_T_base, Scalar::all(255));
    EXPECT_THROW(drawSkeleton(planes[0], camera, tool.model, tool.joints, tool.view.camera_T_base, Scalar::all(255)), cv::Exception);
}

}} // namespace
