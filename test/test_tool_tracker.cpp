// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_tracking.hpp"
#include "opencv2/videoio.hpp"

namespace opencv_test { namespace {

TEST(SurgTrack_Tracker, findsAndFollowsOneTool)
{
    Ptr<ToolTracker> tracker = common().tracker();
    const Score s = scoreOf(common(), *tracker);
    EXPECT_EQ(s.frames - 1, s.covered);   // the second frame confirms the first
    EXPECT_EQ(0, s.silent);
    EXPECT_LT(s.translation, 0.0013);     // measured: 0.6 mm; 7 mm without tracking
    EXPECT_LT(s.rotation, 0.12);          // measured: 0.06 rad; of which the wrist's readings are 0.03 rad
    EXPECT_GT(s.kinematics, 0.005);       // there was something to correct
}

TEST(SurgTrack_Tracker, followsTwoTools)
{
    const Recording r(scene(1, 2), 25);
    Ptr<ToolTracker> tracker = r.tracker();
    const Score s = scoreOf(r, *tracker);
    EXPECT_GE(s.covered, s.frames - 3);   // a frame a tool confirms the start; one more if the first image starts one of them only
    EXPECT_EQ(0, s.silent);
    EXPECT_LT(s.translation, 0.002);      // measured: 1.0 mm with the paper's fixed grid cells
    EXPECT_LT(s.rotation, 0.13);          // measured: 0.066 rad
}

TEST(SurgTrack_Tracker, followsThroughADistortingLens)
{
    const Recording r(scene(1, 1, Size(720, 576), true), 25);
    ASSERT_TRUE(r.scene->camera().hasDistortion());
    Ptr<ToolTracker> tracker = r.tracker();
    const Score s = scoreOf(r, *tracker);
    EXPECT_EQ(s.frames - 1, s.covered);
    EXPECT_LT(s.translation, 0.0013);     // measured: 0.5 mm
    EXPECT_LT(s.rotation, 0.1);           // measured: 0.05 rad
}

TEST(SurgTrack_Tracker, followsInGreyImages)
{
    Recording r = common();
    for (Mat& image : r.images) cvtColor(image.clone(), image, COLOR_BGR2GRAY);
    Ptr<ToolTracker> tracker = r.tracker();
    const Score s = scoreOf(r, *tracker);
    EXPECT_GE(s.covered, s.frames - 4);
    EXPECT_LT(s.translation, 0.0035);     // measured: 1.7 mm
    EXPECT_LT(s.rotation, 0.12);          // measured: 0.06 rad
}

TEST(SurgTrack_Tracker, followsInSmallAndLargeImages)
{
    const Recording small(scene(1, 1, Size(320, 256)), 25);
    Score s = scoreOf(small, *small.tracker(METHOD_FULL));
    EXPECT_GE(s.covered, s.frames - 1);
    EXPECT_EQ(0, s.silent);
    EXPECT_LT(s.translation, 0.0015);     // measured: 0.6 mm, 0.5 to 0.8 mm by the seed
    s = scoreOf(small, *small.tracker());
    EXPECT_GE(s.covered, s.frames - 5);   // measured: 22 of 25; in 5 of 6 seeds the first pose is confirmed within 3 frames
    EXPECT_LT(s.translation, 0.004);      // measured: 1.9 mm with the paper's fixed grid cells; a pixel is 0.25 mm on the tool
    EXPECT_LT(s.rotation, 0.14);          // measured: 0.07 rad; the wrist is 40 pixels wide

    const Recording large(scene(1, 1, Size(1280, 1024)), 8);
    s = scoreOf(large, *large.tracker());
    EXPECT_EQ(s.frames - 1, s.covered);
    EXPECT_LT(s.translation, 0.003);      // measured: 1.4 mm, of the first frames
    EXPECT_LT(s.rotation, 0.16);          // measured: 0.08 rad
}

TEST(SurgTrack_Tracker, largeImagesGiveWhatTheirReductionGives)
{
    const Recording& r = common();
    const CameraModel camera = r.scene->camera();
    for (int factor = 2; factor <= 4; factor++)
    {
        // The reduced camera as in the tracker, so that no bit differs; some columns and a row are left over.
        const double f = factor, share = 1. / factor;
        const Matx33d K(camera.fx * f, 0, (camera.cx + 0.5) * f - 0.5, 0, camera.fy * f, (camera.cy + 0.5) * f - 0.5, 0, 0, 1);
        const Matx33d reducedK(K(0, 0) * share, 0, (K(0, 2) + 0.5) * share - 0.5, 0, K(1, 1) * share, (K(1, 2) + 0.5) * share - 0.5, 0, 0, 1);
        const Size size(720 * factor, 576 * factor);
        Ptr<ToolTracker> large = ToolTracker::create(CameraModel(K, noArray(), size + Size(factor > 2 ? 2 : 1, 1)));
        Ptr<ToolTracker> small = ToolTracker::create(CameraModel(reducedK, noArray(), Size(720, 576)));
        large->addTool(r.scene->model(), r.scene->nominal_T_base(0));
        small->addTool(r.scene->model(), r.scene->nominal_T_base(0));
        const Mat noise = textured(size, 3, factor, 0, 60);
        for (int frame = 0; frame < 4; frame++)
        {
            Mat image, bordered, reduced;
            cv::resize(r.images[frame], image, size, 0, 0, INTER_LINEAR);
            cv::subtract(image, noise, image);
            cv::copyMakeBorder(image, bordered, 0, 1, 0, factor > 2 ? 2 : 1, BORDER_CONSTANT);
            cv::resize(image, reduced, Size(720, 576), 0, 0, INTER_AREA);
            Estimates a, b;
            large->update(bordered, r.time(frame), r.joints(frame), a);
            small->update(reduced, r.time(frame), r.joints(frame), b);
            for (PartMatch& m : b[0].matches)
            {
                m.imagePoint = Point2d((m.imagePoint.x + 0.5) * factor - 0.5, (m.imagePoint.y + 0.5) * factor - 0.5);
                m.predictedPoint = Point2d((m.predictedPoint.x + 0.5) * factor - 0.5, (m.predictedPoint.y + 0.5) * factor - 0.5);
            }
            EXPECT_TRUE(same(a, b)) << "factor " << factor << ", frame " << frame;
            EXPECT_TRUE(frame < 3 || a[0].state == STATE_TRACKING) << factor;   // there was something to compare
        }
    }
}

TEST(SurgTrack_Tracker, theFilterBeatsEPnPOfEachFrame)
{
    double paper = 0, epnp = 0;
    const int seeds[] = {1, 2, 4};
    for (int seed : seeds)
    {
        const Recording* r = &common();
        Ptr<Recording> own;
        if (seed != 1) own = makePtr<Recording>(scene(seed), 25), r = own.get();
        const Score filtered = scoreOf(*r, *r->tracker(METHOD_PAPER)), single = scoreOf(*r, *r->tracker(METHOD_EPNP));
        EXPECT_GE(single.covered, single.frames / 2);
        paper += filtered.translation / 3;
        epnp += single.translation / 3;
    }
    EXPECT_LT(paper, 0.7 * epnp);         // measured: 0.9 and 2.1 mm
}

TEST(SurgTrack_Tracker, theEstimateIsTheCorrectedKinematics)
{
    const Recording& r = common();
    Ptr<ToolTracker> tracker = r.tracker();
    for (int frame = 0; frame < 6; frame++)
    {
        const ToolEstimate e = r.update(*tracker, frame)[0];
        const Matx44d expected = e.camera_T_nominal * r.scene->nominal_T_base(0) * r.scene->model()->endEffectorPose(r.joints(frame)[0]);
        EXPECT_LT(cv::norm(expected - e.camera_T_tool, NORM_INF), 1e-12);   // rounding
        Mat eigenvalues;
        ASSERT_TRUE(cv::eigen(Mat(e.covariance), eigenvalues));
        EXPECT_GT(eigenvalues.at<double>(5), 0);
        EXPECT_EQ(int(e.matches.size()), e.inliers);
        EXPECT_GE(e.visibleParts, e.inliers);
        if (e.state != STATE_TRACKING) continue;
        EXPECT_GE(e.inliers, 4);
        double similarity = 0;
        for (const PartMatch& m : e.matches) similarity += m.similarity / e.inliers;
        EXPECT_NEAR(similarity, e.similarity, 1e-12);                       // rounding
        EXPECT_GT(e.nis, 0);
        EXPECT_LT(e.nis, 4);    // about 1 if the filter is consistent; a chi-square with 10 degrees of freedom over 10 is below 3 in 99.9 %
    }
}

TEST(SurgTrack_Tracker, theFirstFrameIsNotTakenForATrack)
{
    Ptr<ToolTracker> tracker = common().tracker();
    EXPECT_EQ(STATE_INITIALIZING, common().update(*tracker, 0)[0].state);
    EXPECT_EQ(STATE_TRACKING, common().update(*tracker, 1)[0].state);
}

TEST(SurgTrack_Tracker, tissueWithoutAToolIsNeverTracked)
{
    // The calibration puts the tool 3.6 cm beside where it is: there is nothing but tissue in the search windows.
    const Recording& r = common();
    const Point3d beside[] = {Point3d(-0.03, -0.02, 0), Point3d(-0.03, 0.02, 0)};
    for (const Point3d& shift : beside)
    {
        Ptr<ToolTracker> tracker = ToolTracker::create(r.scene->camera());
        tracker->addTool(r.scene->model(), rigid(Matx33d::eye(), shift) * r.scene->nominal_T_base(0));
        for (int frame = 0; frame < 8; frame++)
        {
            const ToolEstimate e = r.update(*tracker, frame)[0];
            EXPECT_EQ(STATE_INITIALIZING, e.state) << frame;
            EXPECT_EQ(0, cv::norm(e.camera_T_nominal - Matx44d::eye(), NORM_INF)) << frame;   // the pose is that of the kinematics
        }
    }
}

TEST(SurgTrack_Tracker, noiseIsNeverTracked)
{
    // Edges everywhere in all directions: every template finds half of its features anywhere.
    const Recording& r = common();
    for (int smooth = 0; smooth < 2; smooth++)
        for (int seed = 1; seed <= 2; seed++)
        {
            Ptr<ToolTracker> tracker = r.tracker();
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

TEST(SurgTrack_Tracker, blackFramesAreCoastedThenLostAndTheToolIsFoundAgain)
{
    const Recording& r = common();
    ToolTracker::Params params;
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
        EXPECT_LT(distance(e[0].camera_T_tool, r.scene->truePose(0, r.time(frame))), 0.005) << frame;   // measured: 2.4 mm at most
    }
}

TEST(SurgTrack_Tracker, shortBlackoutsAreCoasted)
{
    const Recording& r = common();
    Ptr<ToolTracker> tracker = r.tracker();
    for (int frame = 0; frame < 16; frame++)
    {
        Estimates e;
        const bool black = frame % 5 == 4;
        tracker->update(black ? Mat::zeros(576, 720, CV_8UC3) : r.images[frame], r.time(frame), r.joints(frame), e);
        if (frame == 0) continue;
        EXPECT_EQ(black ? STATE_COASTING : STATE_TRACKING, e[0].state) << frame;
        EXPECT_LT(distance(e[0].camera_T_tool, r.scene->truePose(0, r.time(frame))), 0.005) << frame;   // measured: 2.4 mm at most
    }
}

TEST(SurgTrack_Tracker, theSameInputGivesTheSameEstimates)
{
    const Recording r(scene(2, 2, Size(480, 384), true), 8);
    Ptr<ToolTracker> first = r.tracker(), second = r.tracker();
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

TEST(SurgTrack_Tracker, badInputIsRejectedAndLeavesTheStateUnchanged)
{
    const Recording& r = common();
    Ptr<ToolTracker> tracker = r.tracker(), undisturbed = r.tracker();
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

TEST(SurgTrack_Tracker, resetForgetsOneToolOrAll)
{
    const Recording r(scene(1, 2, Size(480, 384)), 10);
    Ptr<ToolTracker> tracker = r.tracker();
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
    Ptr<ToolTracker> fresh = r.tracker();
    for (int frame = 6; frame < r.frames(); frame++) EXPECT_TRUE(same(r.update(*fresh, frame), r.update(*tracker, frame))) << frame;
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

TEST(SurgTrack_Tracker, followsTheRecordedPaperRig)
{
    const char* const data = std::getenv("SURGTRACK_DATA");
    const String folder = data ? String(data) + "/sequences/paper_rig" : String();
    if (!data || !std::ifstream((folder + "/sequence.yaml").c_str()).good())
        throw SkipTestException("the sequence paper_rig is not there: SURGTRACK_DATA does not name a folder that has it");
    const Ptr<Sequence> sequence = Sequence::load(folder);
    VideoCapture video(sequence->leftVideo());
    if (!video.isOpened()) throw SkipTestException("this OpenCV cannot read the video of paper_rig");
    const CameraModel camera = sequence->leftCamera();
    Ptr<ToolTracker> tracker = ToolTracker::create(camera);
    std::vector<Ptr<ToolModel> > models;
    for (int i = 0; i < sequence->toolCount(); i++)
    {
        models.push_back(ToolModel::load(sequence->tool(i).model));
        tracker->addTool(models[i], sequence->tool(i).nominal_T_base);
    }
    Ptr<PoseScorer> scorer = PoseScorer::create(camera, models);
    for (int frame = 0; frame < 60; frame++)
    {
        Mat image;
        ASSERT_TRUE(video.read(image)) << frame;
        const double time = frame / sequence->fps();
        Joints joints(models.size());
        for (int i = 0; i < sequence->toolCount(); i++) ASSERT_TRUE(sequence->jointsAt(i, time, joints[i], models[i]->coordinateNames()));
        Estimates e;
        tracker->update(image, time, joints, e);
        for (int i = 0; i < sequence->toolCount(); i++)
        {
            Matx44d truth;
            std::vector<double> trueJoints;
            ASSERT_TRUE(sequence->groundTruth(i, frame, truth, trueJoints));
            scorer->add(i, e[i].state, e[i].camera_T_tool, truth);
        }
    }
    const PoseScore score = scorer->score(-1);
    if (std::getenv("SURGTRACK_TEST_PRINT")) std::cout << score.translationMean * 1e3 << " mm, " << score.rotationMean << " rad, accuracy " << score.accuracy << std::endl;
    EXPECT_GE(score.covered, 116);             // of 120; the first frames initialise
    EXPECT_LT(score.translationMean, 0.0022);  // measured: 1.1 mm
    EXPECT_LT(score.rotationMean, 0.07);       // measured: 0.035 rad
    EXPECT_GE(score.accuracy, 0.95);           // measured: 0.98
    EXPECT_EQ(0, score.silent);
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

TEST(SurgTrack_Tracker, takesACalibrationRoundedToFourDecimals)
{
    const Recording& r = common();
    Matx44d rounded = r.scene->nominal_T_base(0);
    for (int i = 0; i < 12; i++) rounded.val[i] = std::floor(rounded.val[i] * 1e4 + 0.5) / 1e4;
    Ptr<ToolTracker> tracker = ToolTracker::create(r.scene->camera());
    tracker->addTool(r.scene->model(), rounded);
    Estimates e;
    for (int frame = 0; frame < 3; frame++) e = r.update(*tracker, frame);
    EXPECT_EQ(STATE_TRACKING, e[0].state);
    const Matx33d R = e[0].camera_T_tool.get_minor<3, 3>(0, 0);
    EXPECT_LT(cv::norm(R.t() * R, Matx33d::eye(), NORM_INF), 1e-9);   // a pose is a rotation, whatever was typed in
}

}} // namespace
