// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_tracking.hpp"

// What the robot knows and tells: camera, calibration and instruments that change; and the stages' own parameters.

namespace opencv_test { namespace {

// The camera turned by an angle about the tool, and back from it: where its frame was before, in its frame now.
Matx44d orbit(const Point3d& about, double angle, double back)
{
    const Matx33d R = rotationMatrix(Vec3d(0, angle, 0));
    return rigid(R, about - R * about + Point3d(0, 0, back));
}

// One arm in a scene whose camera may have moved.
struct Stage
{
    explicit Stage(int method) : recording(scene(4), 1), wristError(0), moved(Matx44d::eye()), frame(0)
    {
        ToolTracker::Params p;
        p.method = method;
        tracker = recording.tracker(p);
    }

    Matx44d truth() const { return moved * recording.scene->truePose(0, recording.time(frame)); }

    ToolEstimate next()
    {
        frame++;
        const std::vector<double> joints = recording.scene->trueJoints(0, recording.time(frame));
        Mat image;
        recording.scene->renderArms(frame, Joints(1, joints), std::vector<Matx44d>(1, moved * recording.scene->camera_T_base(0)), image);
        Joints readings(1, joints);
        const int yaw = recording.scene->model()->coordinateIndex("q6");
        readings[0][yaw] -= wristError;
        Estimates estimates;
        tracker->update(image, recording.time(frame), readings, estimates);
        return estimates[0];
    }

    Recording recording;
    double wristError;
    Matx44d moved;
    int frame;
    Ptr<ToolTracker> tracker;
};

typedef testing::TestWithParam<int> SurgTrack_Changes;

INSTANTIATE_TEST_CASE_P(/**/, SurgTrack_Changes, testing::Values(int(METHOD_FULL), int(METHOD_PAPER)));

TEST_P(SurgTrack_Changes, aCameraMotionThatIsToldLosesNoFrame)
{
    Stage stage(GetParam());
    for (int i = 0; i < 12; i++) stage.next();
    const Matx44d truth = stage.truth();
    const Matx44d now_T_before = orbit(Point3d(truth(0, 3), truth(1, 3), truth(2, 3)), 30 * CV_PI / 180, 0.024);
    const Matx44d before_T_now = now_T_before.inv();
    ASSERT_NEAR(0.06, cv::norm(Vec3d(before_T_now(0, 3), before_T_now(1, 3), before_T_now(2, 3))), 0.003);
    stage.moved = now_T_before;
    stage.tracker->moveCamera(now_T_before);
    for (int i = 0; i < 5; i++)
    {
        const ToolEstimate e = stage.next();
        EXPECT_EQ(STATE_TRACKING, e.state) << i;
        EXPECT_LT(distance(e.camera_T_tool, stage.truth()), GetParam() == METHOD_FULL ? 0.001 : 0.003) << i;   // measured: 0.3 and 2.1 mm, as without a motion
    }
}

TEST_P(SurgTrack_Changes, aBetterCalibrationMovesNoPose)
{
    Stage stage(GetParam()), untold(GetParam());
    for (int i = 0; i < 12; i++)
    {
        stage.next();
        untold.next();
    }
    stage.tracker->setHandEye(0, stage.recording.scene->camera_T_base(0));
    for (int i = 0; i < 5; i++)
    {
        const ToolEstimate e = stage.next(), same = untold.next();
        EXPECT_EQ(STATE_TRACKING, e.state);
        // The noise of METHOD_PAPER's filter is that of other angles.
        EXPECT_LT(distance(e.camera_T_tool, same.camera_T_tool), GetParam() == METHOD_FULL ? 1e-5 : 8e-4) << i;   // measured: 0.4 mm
        EXPECT_LT(rotationAngle(e.camera_T_tool, same.camera_T_tool), GetParam() == METHOD_FULL ? 1e-4 : 0.013) << i;   // measured: 0.007
        if (GetParam() == METHOD_FULL) EXPECT_LT(rotationAngle(e.camera_T_nominal, Matx44d::eye()), 0.03) << i;   // it was 3 degrees
    }
}

TEST_P(SurgTrack_Changes, anExchangedInstrumentIsFoundWithinTenFrames)
{
    Stage stage(GetParam());
    stage.wristError = 0.02;
    for (int i = 0; i < 12; i++) stage.next();
    stage.wristError = -0.02;   // of another instrument of the same kind
    stage.tracker->replaceTool(0, ToolModel::needleDriver());
    int first = -1;
    for (int i = 0; i < 10; i++)
    {
        const ToolEstimate e = stage.next();
        if (e.state != STATE_TRACKING) continue;
        if (first < 0) first = i;
        EXPECT_LT(distance(e.camera_T_tool, stage.truth()), 0.003) << i;
    }
    EXPECT_GE(first, 0);
    EXPECT_LE(first, 3);   // it begins where the calibration was learnt to be
}

TEST(SurgTrack_ToolTracker, aToolThatIsRemovedTakesNothingWithIt)
{
    const Recording r(scene(2, 2), 14);
    Ptr<ToolTracker> tracker = r.tracker(METHOD_FULL);
    for (int frame = 0; frame < 10; frame++) r.update(*tracker, frame);
    tracker->removeTool(0);
    for (int frame = 10; frame < 14; frame++)
    {
        Estimates estimates;
        tracker->update(r.images[frame], r.time(frame), Joints(1, r.joints(frame)[1]), estimates);
        ASSERT_EQ(1u, estimates.size());
        EXPECT_EQ(STATE_TRACKING, estimates[0].state) << frame;
        EXPECT_LT(distance(estimates[0].camera_T_tool, r.scene->truePose(1, r.time(frame))), 0.001) << frame;
    }
    EXPECT_ERROR(tracker->removeTool(1), "no such tool");
    EXPECT_ERROR(tracker->replaceTool(-1, needleDriver()), "no such tool");
    EXPECT_ERROR(tracker->setHandEye(0, Matx44d::zeros()), "nominal_T_base");
    EXPECT_ERROR(tracker->moveCamera(Matx44d::zeros()), "now_T_before");
}

class CountingRenderer : public MeshRenderer
{
public:
    CountingRenderer() : drawings(0), software(MeshRenderer::createSoftware()) {}
    int addMesh(const cv::surgtrack::Mesh& mesh) CV_OVERRIDE { return software->addMesh(mesh); }
    void render(const CameraModel& camera, const Rect& window, const std::vector<MeshInstance>& instances, Rendering& rendering,
                const std::vector<Rect>& regions) CV_OVERRIDE
    {
        drawings++;
        software->render(camera, window, instances, rendering, regions);
    }
    int drawings;

private:
    Ptr<MeshRenderer> software;
};

TEST(SurgTrack_ToolTracker, drawsWithTheRendererThatIsGiven)
{
    const Recording& r = common();
    Ptr<CountingRenderer> renderer = makePtr<CountingRenderer>();
    Ptr<ToolTracker> own = r.tracker(METHOD_FULL);
    Ptr<ToolTracker> given = ToolTracker::create(r.scene->camera(), ToolTracker::Params(), ToolTracker::Stages(), renderer);
    given->addTool(r.scene->model(), r.scene->nominal_T_base(0));
    for (int frame = 0; frame < 4; frame++) EXPECT_TRUE(same(r.update(*own, frame), r.update(*given, frame))) << frame;
    EXPECT_GT(renderer->drawings, 4);
}

TEST(SurgTrack_ToolTracker, itsStagesAreAsTheyAreWanted)
{
    const Recording& r = common();
    for (int method : {int(METHOD_FULL), int(METHOD_PAPER)})
    {
        ToolTracker::Params params;
        params.method = method;
        ToolTracker::Stages stages;
        stages.matcher.minSimilarity = 1;   // nothing is
        Ptr<ToolTracker> tracker = ToolTracker::create(r.scene->camera(), params, stages);
        tracker->addTool(r.scene->model(), r.scene->nominal_T_base(0));
        EXPECT_EQ(0, r.update(*tracker, 0)[0].inliers) << method;
        stages = ToolTracker::Stages();
        stages.templates.minFeatures = 100000;   // nor is any part seen
        tracker = ToolTracker::create(r.scene->camera(), params, stages);
        tracker->addTool(r.scene->model(), r.scene->nominal_T_base(0));
        EXPECT_EQ(0, r.update(*tracker, 0)[0].visibleParts) << method;
    }
}

TEST(SurgTrack_ToolTracker, showsWhatItSaw)
{
    const Recording& r = common();
    Ptr<ToolTracker> tracker = r.tracker(METHOD_FULL);
    ToolEstimate e;
    for (int frame = 0; frame < 8; frame++) e = r.update(*tracker, frame)[0];
    ASSERT_EQ(STATE_TRACKING, e.state);
    const ToolSight sight = tracker->sight(0);
    EXPECT_EQ(size_t(e.visibleParts), sight.templates.size());
    EXPECT_EQ(sight.templates.size(), sight.found.windows.size());
    EXPECT_GE(int(sight.found.inliers.size()), e.inliers);
    EXPECT_EQ(2u, sight.found.sample.size());
    int supported = 0;
    for (const ContourPoint& c : sight.outline) supported += c.found && std::abs(c.offset) < 1.5;
    EXPECT_DOUBLE_EQ(e.contourSupport, supported / double(sight.outline.size()));
    EXPECT_EQ(r.scene->camera().imageSize(), sight.camera.imageSize());
    EXPECT_ERROR(tracker->sight(0, 1), "no such eye");
}

}} // namespace
