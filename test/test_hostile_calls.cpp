// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_tracking.hpp"

// Cameras, readings, parameters and renderers that are wrong: each is refused before anything changes, or answered with numbers.

namespace opencv_test { namespace {

CameraModel camera(double f, const std::vector<double>& distortion = std::vector<double>(), Size size = Size(720, 576))
{
    return CameraModel(Mat(Matx33d(f, 0, size.width / 2., 0, f, size.height / 2., 0, 0, 1)), Mat(distortion), size);
}

// --- lenses ---

TEST(SurgTrack_HostileCalls, lensesThatFoldWithinTheImageAreRefused)
{
    // The denominator of the first has its zero near the corner of the image: what was drawn there was halved for ever.
    EXPECT_ERROR(camera(400, { -.16, -.33, 0, 0, .26, -.37, -.05, -.3 }), "distCoeffs");
    EXPECT_ERROR(camera(400, { -0.4, 0, 0, 0, 0 }), "distCoeffs");              // the slope 1 - 1.2 r^2 is 0 at 365 pixels
    EXPECT_ERROR(camera(400, { 0, 0, 0, 0, 0, -2, 0, 0 }), "distCoeffs");       // a pole at 283 pixels
    EXPECT_ERROR(camera(400, { 0, 0, 0.5, 0, 0 }), "distCoeffs");               // tangential, beyond a fold
    EXPECT_ERROR(camera(400, { 1e300, 0, 0, 0, 0 }), "distCoeffs");
    EXPECT_ERROR(camera(400, { 0, 0, 0, 0, 1e308, 0, 0, -1e308 }), "distCoeffs");
    camera(800, { -0.4, 0, 0, 0, 0 });                                          // the same fold, outside of the image
    camera(400, { -0.2, 0.05, 0, 0, 0 });
    endoscope();
}

// Of many lenses those that are taken give each pixel its own ray, and a tracker an answer.
TEST(SurgTrack_HostileCalls, lensesThatAreTakenAreSound)
{
    RNG rng(11);
    int taken = 0;
    for (int i = 0; i < 3000; i++)
    {
        std::vector<double> D(i % 2 ? 8 : 12);
        const double size = std::pow(10, rng.uniform(-3., 0.5));
        for (size_t k = 0; k < D.size(); k++) D[k] = rng.gaussian(k == 2 || k == 3 ? 0.1 * size : size);
        CameraModel c;
        if (!errorText([&]() { c = camera(rng.uniform(300., 1000.), D); }).empty()) continue;
        taken++;
        std::vector<Point2d> pixels, rays;
        for (int k = 0; k < 50; k++) pixels.push_back(Point2d(rng.uniform(0., 719.), rng.uniform(0., 575.)));
        c.unprojectPoints(pixels, rays);
        for (size_t k = 0; k < pixels.size(); k++)
            ASSERT_LT(cv::norm(c.project(Point3d(rays[k].x, rays[k].y, 1)) - pixels[k]), 0.5) << i;   // what is asked for at the border
    }
    EXPECT_GT(taken, 500);
}

TEST(SurgTrack_HostileCalls, camerasWithoutASensibleFieldAreRefused)
{
    EXPECT_ERROR(camera(1e-300), "focal length");
    EXPECT_ERROR(camera(0.1), "focal length");
    EXPECT_ERROR(camera(1e300), "focal length");
    EXPECT_ERROR(CameraModel(Mat(Matx33d(500, 0, 1e9, 0, 500, 240, 0, 0, 1)), Mat(), Size(640, 480)), "principal point");
    EXPECT_ERROR(camera(500, {}, Size(1 << 20, 4)), "at most 32768");
    camera(1, {}, Size(160, 120));
}

// --- readings ---

bool isFinite(const ToolEstimate& e)
{
    bool ok = cv::checkRange(e.camera_T_tool) && cv::checkRange(e.camera_T_nominal) && cv::checkRange(e.covariance) && cv::checkRange(e.jointOffsets) && cv::checkRange(e.joints)
              && cv::checkRange(Vec<double, 6>(e.similarity, e.contourSupport, e.confidence, e.nis, e.delay, double(e.state)));
    for (size_t i = 0; i < e.matches.size(); i++) ok = ok && cv::checkRange(Vec3d(e.matches[i].imagePoint.x, e.matches[i].imagePoint.y, e.matches[i].similarity));
    for (int i = 0; i < 6; i++) ok = ok && e.covariance(i, i) >= 0;
    return ok;
}

typedef testing::TestWithParam<int> SurgTrack_HostileReadings;

INSTANTIATE_TEST_CASE_P(/**/, SurgTrack_HostileReadings, testing::Values(int(METHOD_FULL), int(METHOD_PAPER), int(METHOD_EPNP)));

// One glitch: that frame is as one with the readings of the frame before.
TEST_P(SurgTrack_HostileReadings, areLeftOutAndCounted)
{
    const double glitches[] = { 1e200, -1e200, 1e308, 11, -11 };
    const Recording& r = common();
    const int insertion = r.scene->model()->coordinateIndex("q3");
    for (size_t g = 0; g < 5; g++)
    {
        Ptr<ToolTracker> hit = r.tracker(GetParam()), held = r.tracker(GetParam());
        Estimates a, b;
        for (int i = 0; i < 14; i++)
        {
            Joints wild = r.joints(i), last = wild;
            if (i == 8)
            {
                wild[0][insertion] = glitches[g];
                last = r.joints(7);
            }
            hit->update(r.images[i], r.time(i), wild, a);
            held->update(r.images[i], r.time(i), last, b);
            EXPECT_TRUE(isFinite(a[0])) << i;
            EXPECT_EQ(i < 8 ? 0 : 1, a[0].skippedReadings) << i;
            EXPECT_EQ(0, b[0].skippedReadings);
            a[0].skippedReadings = 0;
            EXPECT_TRUE(same(a, b)) << glitches[g] << " frame " << i;
        }
    }
}

TEST_P(SurgTrack_HostileReadings, fromTheFirstOnGiveNumbers)
{
    const Recording& r = common();
    Ptr<ToolTracker> tracker = r.tracker(GetParam());
    RNG rng(7);
    Estimates e;
    for (int i = 0; i < 25; i++)
    {
        Joints joints = r.joints(i);
        for (size_t k = 0; k < joints[0].size(); k++)
            if (i < 8 || rng.uniform(0, 3) == 0) joints[0][k] = rng.gaussian(1) * std::pow(10, rng.uniform(-3., 300.));
        if (i % 3 == 0) tracker->renderAhead(joints);
        tracker->update(r.images[i], r.time(i), joints, e);
        EXPECT_TRUE(isFinite(e[0])) << i;
    }
    EXPECT_GT(e[0].skippedReadings, 8);
}

// Limits of the tool file count, with a margin as wide as they are apart.
TEST(SurgTrack_HostileCalls, jointLimitsBoundReadings)
{
    ToolModel::Description description;
    description.coordinates = needleDriver()->coordinateNames();
    description.links = needleDriver()->links();
    description.keypoints = needleDriver()->keypoints();
    description.meshes = needleDriver()->meshes();
    description.endEffectorLink = needleDriver()->endEffectorLink();
    description.limits.assign(description.coordinates.size(), Vec2d(-DBL_MAX, DBL_MAX));
    const int insertion = needleDriver()->coordinateIndex("q3");
    description.limits[insertion] = Vec2d(0, 0.24);
    const Recording& r = common();
    Ptr<ToolTracker> tracker = ToolTracker::create(r.scene->camera());
    tracker->addTool(ToolModel::create(description), r.scene->nominal_T_base(0));
    Estimates e;
    const double values[] = { 0.12, 0.47, 0.49, -0.23, -0.25, 0.12 };
    const int skipped[] = { 0, 0, 1, 1, 2, 2 };
    for (int i = 0; i < 6; i++)
    {
        Joints joints = r.joints(i);
        joints[0][insertion] = values[i];
        tracker->update(r.images[i], r.time(i), joints, e);
        EXPECT_EQ(skipped[i], e[0].skippedReadings) << values[i];
    }
    tracker->reset(0);
    tracker->update(r.images[6], r.time(6), r.joints(6), e);
    EXPECT_EQ(0, e[0].skippedReadings);
}

TEST_P(SurgTrack_HostileReadings, timesMayJump)
{
    const Recording& r = common();
    Ptr<ToolTracker> tracker = r.tracker(GetParam());
    Estimates e;
    const double times[] = { -1e308, 0, 1e-300, 1, 1e15, 1e308 };
    for (int i = 0; i < 6; i++)
    {
        tracker->update(r.images[i], times[i], r.joints(i), e);
        EXPECT_TRUE(isFinite(e[0])) << times[i];
    }
}

// --- update() succeeds, or leaves everything as it was ---

//! Throws at a draw that is asked for.
class FailingRenderer : public MeshRenderer
{
public:
    FailingRenderer() : renderer(MeshRenderer::createSoftware()), left(INT_MAX) {}
    int addMesh(const Mesh& mesh) CV_OVERRIDE { return renderer->addMesh(mesh); }
    void render(const CameraModel& camera, const Rect& window, const std::vector<MeshInstance>& instances, Rendering& rendering, const std::vector<Rect>& regions) CV_OVERRIDE
    {
        if (left-- == 0) throw std::runtime_error("out of order");
        renderer->render(camera, window, instances, rendering, regions);
    }
    Ptr<MeshRenderer> renderer;
    int left;
};

TEST_P(SurgTrack_HostileReadings, whateverIsThrownTheTrackerIsAsItWas)
{
    const Recording& r = common();
    ToolTracker::Params p;
    p.method = GetParam();
    // Frames of the start, of following, of a tool that is not where it was, and of readings that no joint can have.
    for (int draw = 0; draw < 40; draw = draw < 4 ? draw + 1 : 2 * draw)
    {
        const Ptr<FailingRenderer> renderer = makePtr<FailingRenderer>();
        Ptr<ToolTracker> failing = ToolTracker::create(r.scene->camera(), p, ToolTracker::Stages(), renderer), other = r.tracker(p);
        failing->addTool(r.scene->model(), r.scene->nominal_T_base(0));
        Estimates a, b;
        int thrown = 0;
        for (int i = 0; i < 16; i++)
        {
            Joints joints = r.joints(i);
            if (i == 6) joints[0][2] = 1e100;
            const Mat image = i == 9 || i == 10 ? Mat(r.images[i].size(), r.images[i].type(), Scalar::all(90)) : r.images[i];
            renderer->left = draw;
            bool failed = false;
            try
            {
                failing->update(image, r.time(i), joints, a);
            }
            catch (const std::runtime_error&)
            {
                failed = true;
            }
            thrown += failed;
            renderer->left = INT_MAX;
            if (failed) failing->update(image, r.time(i), joints, a);   // once more, and now it works
            other->update(image, r.time(i), joints, b);
            ASSERT_TRUE(same(a, b)) << "frame " << i << ", draw " << draw;
        }
        EXPECT_TRUE(draw > 3 || thrown > 0) << draw;
    }
}

TEST(SurgTrack_HostileCalls, callsThatAreRefusedChangeNothing)
{
    const Recording& r = common();
    Ptr<ToolTracker> tracker = r.tracker(), other = r.tracker();
    Estimates a, b;
    const Matx44d far = rigid(Matx33d::eye(), Point3d(0, 0, 1e4));
    for (int i = 0; i < 8; i++)
    {
        EXPECT_ERROR(tracker->addTool(r.scene->model(), far), "nominal_T_base must be within 1000 m");
        EXPECT_ERROR(tracker->setHandEye(0, far), "nominal_T_base");
        EXPECT_ERROR(tracker->moveCamera(far), "now_T_before");
        EXPECT_ERROR(tracker->setRightCamera(r.scene->camera(), far), "right_T_left");
        EXPECT_ERROR(tracker->setMask(Mat(3, 3, CV_8UC1), 0), "mask");
        EXPECT_ERROR(tracker->update(Mat(), r.time(i), r.joints(i), a), "image");
        EXPECT_ERROR(tracker->replaceTool(0, Ptr<ToolModel>()), "model");
        a = r.update(*tracker, i);
        b = r.update(*other, i);
        ASSERT_TRUE(same(a, b)) << i;
    }
}

// More tools than there are names for in a drawing: the one too many is refused, and the others go on.
TEST(SurgTrack_HostileCalls, wrongStagesAreRefusedAtOnce)
{
    const CameraModel c = endoscope();
    const auto stages = [&](const std::function<void(ToolTracker::Stages&)>& change)
    {
        ToolTracker::Stages s;
        change(s);
        return errorText([&]() { ToolTracker::create(c, ToolTracker::Params(), s)->addTool(needleDriver(), Matx44d::eye()); });
    };
    EXPECT_EQ("", stages([](ToolTracker::Stages&) {}));
    EXPECT_NE("", stages([](ToolTracker::Stages& s) { s.edges.ambiguity = 2; }));
    EXPECT_NE("", stages([](ToolTracker::Stages& s) { s.edges.minStrength = NOT_A_NUMBER; }));
    EXPECT_NE("", stages([](ToolTracker::Stages& s) { s.templates.magnitudeThreshold = -1; }));
    EXPECT_NE("", stages([](ToolTracker::Stages& s) { s.templates.boxSize = NOT_A_NUMBER; }));
    EXPECT_NE("", stages([](ToolTracker::Stages& s) { s.templates.maxFeatures = 0; }));
    EXPECT_EQ("", stages([](ToolTracker::Stages& s) { s.templates.maxFeatures = INT_MAX; }));
    EXPECT_NE("", stages([](ToolTracker::Stages& s) { s.matcher.magnitudeThreshold = 1e9; }));
    EXPECT_NE("", stages([](ToolTracker::Stages& s) { s.matcher.spread = 1000001; }));
    EXPECT_NE("", stages([](ToolTracker::Stages& s) { s.filter.initialRotation = 1e300; }));
    EXPECT_NE("", stages([](ToolTracker::Stages& s) { s.filter.pointNoise = 1e-300; }));
    EXPECT_NE("", stages([](ToolTracker::Stages& s) { s.contour.spacing = 0; }));
}

// --- small things ---

TEST(SurgTrack_HostileCalls, aMaskOfTheRightEyeOutlivesANewCalibration)
{
    const Recording& r = commonStereo();
    const Mat nothing = Mat::zeros(r.images[0].size(), CV_8UC1);
    Ptr<ToolTracker> masked = r.stereoTracker(), again = r.stereoTracker(), open = r.stereoTracker();
    masked->setMask(nothing, 1);
    again->setMask(nothing, 1);
    again->setRightCamera(r.scene->camera(true), r.scene->right_T_left());
    bool differs = false;
    for (int i = 0; i < 8; i++)
    {
        const Estimates a = r.updateStereo(*masked, i), b = r.updateStereo(*again, i), c = r.updateStereo(*open, i);
        EXPECT_TRUE(same(a, b)) << i;
        differs = differs || !same(a, c);
    }
    EXPECT_TRUE(differs);
}

TEST(SurgTrack_HostileCalls, errorsNameTheEye)
{
    const Recording& r = commonStereo();
    Ptr<ToolTracker> tracker = r.stereoTracker();
    Estimates e;
    EXPECT_ERROR(tracker->updateStereo(r.images[0], Mat(), 0, r.joints(0), e), "right must be");
    EXPECT_ERROR(tracker->updateStereo(Mat(), r.images[0], 0, r.joints(0), e), "left must be");
}

TEST(SurgTrack_HostileCalls, posesOfTwoToolsHaveTwoNames)
{
    const std::string name = cv::tempfile(".csv");
    EXPECT_ERROR(PoseWriter::create(name, { "A", "A" }, { needleDriver(), needleDriver() }), "'A'");
}

TEST(SurgTrack_HostileCalls, thePapersFilterTellsItsInnovationFromTheFirstFrameOn)
{
    const Recording& r = common();
    Ptr<ToolTracker> tracker = r.tracker(METHOD_PAPER);
    for (int i = 0; i < 8; i++)
    {
        const Estimates e = r.update(*tracker, i);
        EXPECT_EQ(e[0].inliers > 0, e[0].nis > 0) << i;
    }
}

// A picture that comes again while the robot moves on is not measured.
TEST_P(SurgTrack_HostileReadings, picturesThatComeAgainAreNotBelieved)
{
    const Recording& r = common();
    Ptr<ToolTracker> tracker = r.tracker(GetParam());
    Estimates e;
    for (int i = 0; i < 12; i++) e = r.update(*tracker, i);
    ASSERT_EQ(STATE_TRACKING, e[0].state);
    for (int i = 12; i < 18; i++)
    {
        tracker->update(r.images[11], r.time(i), r.joints(i), e);
        EXPECT_EQ(STATE_COASTING, e[0].state) << i;
        EXPECT_EQ(0, e[0].inliers) << i;
    }
    e = r.update(*tracker, 18);
    EXPECT_EQ(STATE_TRACKING, e[0].state);
}

TEST(SurgTrack_HostileCalls, toolsHaveTheSizeOfTools)
{
    ToolModel::Description description;
    description.coordinates = needleDriver()->coordinateNames();
    description.links = needleDriver()->links();
    description.keypoints = needleDriver()->keypoints();
    description.meshes = needleDriver()->meshes();
    description.endEffectorLink = needleDriver()->endEffectorLink();
    ToolModel::create(description);
    const auto wrong = [&](const std::function<void(ToolModel::Description&)>& change)
    {
        ToolModel::Description d = description;
        change(d);
        return errorText([&]() { ToolModel::create(d); });
    };
    EXPECT_NE("", wrong([](ToolModel::Description& d) { d.links[1].a = 1e308; }));
    EXPECT_NE("", wrong([](ToolModel::Description& d) { d.links[1].scale = 1e300; }));
    EXPECT_NE("", wrong([](ToolModel::Description& d) { d.links[1].theta = 1e300; }));
    EXPECT_NE("", wrong([](ToolModel::Description& d) { d.keypoints[0].linkPoint.x = 1e300; }));
    EXPECT_NE("", wrong([](ToolModel::Description& d) { d.link_T_endEffector(0, 3) = 1e300; }));
    EXPECT_NE("", wrong([](ToolModel::Description& d) { d.meshes[0].vertices[0].x = 1e30f; }));
}

}} // namespace
