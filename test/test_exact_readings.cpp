// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_filter_bench.hpp"

namespace opencv_test { namespace {

const CameraModel& camera()
{
    static const CameraModel result = endoscope(false);
    return result;
}

ArticulatedPoseEKF::Params constantTruth()
{
    ArticulatedPoseEKF::Params params;
    params.pointNoise = 0.3;
    params.gate = 0;
    params.processRotation = params.processTranslation = params.processJoint = 0;
    return params;
}

// A wrist that bends to and fro.
std::vector<double> waving(const Bench& bench, int frame)
{
    return joints(bench.tool, 0.4 + 0.5 * std::sin(0.3 * frame), 0.4 * std::cos(0.2 * frame), 0.4 * std::sin(0.25 * frame), 0.5);
}

// Follows an arm whose pitch is coupled into its yaw. Returns the mean error of the yaw's readings that is left over the last frames [rad].
double follow(ArticulatedPoseEKF& filter, Bench& bench, double coupling, int frames, RNG& rng)
{
    double sum = 0;
    for (int frame = 0; frame < frames; frame++)
    {
        const std::vector<double> q = waving(bench, frame);
        bench.move(q);
        std::vector<double> readings = bench.readings();
        const double wrong = coupling * (q[4] - 0.4);
        readings[5] += wrong;
        filter.predict(readings);
        std::vector<Point2d> seen = bench.seen(camera());
        for (Point2d& p : seen) p += Point2d(rng.gaussian(0.3), rng.gaussian(0.3));
        EXPECT_TRUE(correct(filter, camera(), bench.parts, seen, 5));
        if (frame >= frames / 2) sum += std::abs(filter.offsets()[5] + wrong) / (frames - frames / 2);
    }
    return sum;
}

Bench goodArm()
{
    return Bench(PosedTool(0.1, 0.3, 1.2, 0.3), motionAbout(Point3d(0, 0, 0.1), Vec3d(1, 2, -1) * DEGREE, Vec3d(0.002, -0.003, 0.004)),
                 std::vector<double>(7, 0.));
}

TEST(SurgTrack_ExactReadings, theMixtureIsThatOfTheFilterThatLearnsAndTheOneThatDoesNot)
{
    // As sure of either as can be, the mixture is that filter: given that constants are zero, one that learns them is one that has none.
    ArticulatedPoseEKF::Params learns = constantTruth(), exact = learns, surelyErring = learns, surelyExact = learns;
    learns.exact = 0;
    exact.gain = exact.play = exact.coupling = exact.delay = 0;
    surelyErring.exact = 1e-300;
    surelyExact.exact = 1 - 1e-15;
    Matx44d poses[4];
    Mat covariances[4];
    const ArticulatedPoseEKF::Params params[] = {learns, surelyErring, exact, surelyExact};
    for (int i = 0; i < 4; i++)
    {
        RNG rng(7);
        Bench bench = goodArm();
        const Ptr<ArticulatedPoseEKF> filter = bench.filter(params[i]);
        follow(*filter, bench, 0, 8, rng);
        poses[i] = bench.toolPose(filter->view());
        covariances[i] = Mat(filter->poseCovariance()).clone();
    }
    EXPECT_LT(distance(poses[0], poses[1]), 1e-9);
    EXPECT_LE(cvtest::norm(covariances[0], covariances[1], NORM_INF), 1e-9 * cvtest::norm(covariances[0], NORM_INF));
    // Both are linear about a place of their own, 0.1 mm apart: of turns of degrees a thousandth of that is left.
    EXPECT_GT(distance(poses[1], poses[3]), 1e-6);
    EXPECT_LT(distance(poses[2], poses[3]), 2e-6);
    EXPECT_LT(rotationAngle(poses[2], poses[3]), 1e-4);
    EXPECT_LE(cvtest::norm(covariances[2], covariances[3], NORM_INF), 0.02 * cvtest::norm(covariances[2], NORM_INF));
}

TEST(SurgTrack_ExactReadings, goodReadingsAreBelievedAndBadOnesLearnt)
{
    ArticulatedPoseEKF::Params learns = constantTruth();
    learns.exact = 0;
    double good[2] = {0, 0}, bad[2] = {0, 0};
    for (int run = 0; run < 5; run++)
        for (int mixes = 0; mixes < 2; mixes++)
        {
            RNG rng(20 + run);
            Bench bench = goodArm();
            const ArticulatedPoseEKF::Params params = mixes ? constantTruth() : learns;
            good[mixes] += follow(*bench.filter(params), bench, 0, 40, rng) / 5;
            bad[mixes] += follow(*bench.filter(params), bench, 0.1, 40, rng) / 5;   // 0.04 rad to and fro
        }
    EXPECT_LT(good[1], good[0]);
    EXPECT_LT(bad[1], 1.2 * bad[0]);   // what is left of a hypothesis that is a false one
    EXPECT_LT(bad[1], 0.01);           // a quarter of the error
}

TEST(SurgTrack_ExactReadings, whatIsBelievedStaysWhileNothingIsSeen)
{
    RNG rng(3);
    Bench bench = goodArm();
    ArticulatedPoseEKF::Params params;   // constants drift
    const Ptr<ArticulatedPoseEKF> filter = bench.filter(params);
    follow(*filter, bench, 0.05, 10, rng);
    const Matx44d correction = filter->correction();
    for (int frame = 10; frame < 40; frame++)
    {
        filter->predict(waving(bench, frame));
        ASSERT_EQ(0, cv::norm(filter->correction() - correction, NORM_INF)) << frame;
        filter->undo();
        ASSERT_EQ(0, cv::norm(filter->correction() - correction, NORM_INF)) << frame;
    }
}

// The outline of a tool where a filter has it, with edges where they are truly seen, those of the outside displaced.
double depthAfterBloom(double displaced, int clipped, double bloom, double* bias)
{
    const PosedTool tool(0.1, 0.3, 1.1, 0.35);
    const Bench bench(tool, Matx44d::eye(), std::vector<double>(7, 0.));
    ArticulatedPoseEKF::Params params;
    params.bloom = bloom;
    const Ptr<ArticulatedPoseEKF> filter = bench.filter(params);
    filter->predict(bench.readings());
    std::vector<ContourPoint> outline = ToolContour::create(needleDriver())->sampleTool(camera(), filter->view().camera_T_base, bench.readings());
    for (int pass = 0; pass < 5; pass++)
    {
        filter->begin();
        placeContour(camera(), filter->view(), outline);
        std::vector<uchar> used;
        filter->addPoints(camera(), SAME_EYE, bench.parts, bench.seen(camera()), used);
        for (ContourPoint& c : outline)
        {
            const Point3d p = transformed(tool.view.camera_T_base * tool.view.base_T_link[c.link], c.linkPoint);
            c.offset = (camera().project(p) - c.imagePoint).dot(c.normal) - displaced;
            c.deviation = 0.3;
            c.found = true;
            c.clipped = clipped;
        }
        filter->addContour(camera(), SAME_EYE, outline, 5);
        EXPECT_TRUE(filter->solve());
    }
    if (bias) *bias = filter->edgeBias(clipped);
    return bench.toolPose(filter->view())(2, 3) - tool.camera_T_tool(2, 3);
}

TEST(SurgTrack_EdgeBias, edgesThatWhiteEatsIntoDoNotMoveTheToolAway)
{
    // Three pixels of both sides of a shaft that is 80 wide: 7 % of its distance, but for the points, were they believed.
    double bias = 0;
    const double believed = depthAfterBloom(3, 1, 1e-3, 0), known = depthAfterBloom(3, 1, 3, &bias);
    EXPECT_GT(believed, 0.0015);
    EXPECT_LT(std::abs(known), 0.3 * believed);   // points tell the depth; they are fewer
    EXPECT_NEAR(-3, bias, 1);
    EXPECT_LT(std::abs(depthAfterBloom(0, 1, 3, 0)), 1e-4);   // and where nothing is displaced nothing moves
    EXPECT_LT(std::abs(depthAfterBloom(0, 0, 3, 0)), 1e-4);
}

TEST(SurgTrack_EdgeBias, whiteBesideAnEdgeIsNoticed)
{
    // A dark bar on white, on grey, and a white one on dark.
    struct { int bar, ground, clipped; } const scenes[] = {{60, 255, 1}, {60, 200, 0}, {255, 60, -1}};
    for (size_t s = 0; s < sizeof(scenes) / sizeof(scenes[0]); s++)
    {
        Mat image(100, 200, CV_8UC3, Scalar::all(scenes[s].ground));
        image.colRange(80, 120).setTo(Scalar::all(scenes[s].bar));
        GaussianBlur(image, image, Size(), 1);
        std::vector<ContourPoint> points(1);
        points[0].imagePoint = Point2d(118.5, 50);
        points[0].normal = Point2d(1, 0);
        ASSERT_EQ(1, matchContour(image, points, ContourSearch()));
        EXPECT_EQ(scenes[s].clipped, points[0].clipped) << s;
    }
}

}} // namespace
