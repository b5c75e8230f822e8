// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_filter_bench.hpp"

namespace opencv_test { namespace {

// Coordinates with an offset, in the order of the state.
std::vector<int> offsetCoordinates(const ToolModel& model)
{
    std::vector<int> result;
    const std::vector<double> deviations = model.offsetDeviations();
    for (size_t i = 0; i < deviations.size(); i++)
        if (deviations[i] > 0) result.push_back(int(i));
    return result;
}

// The tool after a change of the error state (omega, v, d) about c.
ToolView changed(const Bench& bench, const ArticulatedPoseEKF& filter, const Point3d& c, const Mat_<double>& x)
{
    std::vector<double> joints = bench.readings();
    const std::vector<int> coordinates = offsetCoordinates(*bench.tool.model);
    for (size_t i = 0; i < joints.size(); i++) joints[i] += filter.offsets()[i];
    for (size_t i = 0; i < coordinates.size(); i++) joints[coordinates[i]] += x(6 + int(i));
    ToolView view;
    view.camera_T_base = motionAbout(c, Vec3d(x(0), x(1), x(2)), Vec3d(x(3), x(4), x(5))) * filter.correction() * bench.nominal_T_base;
    bench.tool.model->forwardKinematics(joints, view.base_T_link);
    return view;
}

double deviation(const Mat& P, int i)
{
    return std::sqrt(P.at<double>(i, i));
}

bool isSymmetricPositiveDefinite(const Mat& P)
{
    Mat values;
    return checkRange(P) && cvtest::norm(P, Mat(P.t()), NORM_INF) <= 1e-12 * cvtest::norm(P, NORM_INF) && cv::eigen(P, values)
        && values.at<double>(P.rows - 1) > 0;
}

std::vector<double> wristOffsets(double q4, double q5, double q6, double jaw)
{
    const double values[] = {0, 0, 0, q4, q5, q6, jaw};
    return std::vector<double>(values, values + 7);
}

// A point every three pixels.
std::vector<ContourPoint> outlineOf(const CameraModel& camera, const Matx44d& camera_T_base, const std::vector<double>& joints)
{
    ToolContour::Params params;
    params.spacing = 3;
    params.maxPoints = 400;
    static const Ptr<ToolContour> contour = ToolContour::create(needleDriver(), params);
    return contour->sampleTool(camera, camera_T_base, joints);
}

bool sameView(const ToolView& a, const ToolView& b)
{
    bool same = cv::norm(a.camera_T_base - b.camera_T_base, NORM_INF) == 0 && a.base_T_link.size() == b.base_T_link.size();
    for (size_t i = 0; same && i < a.base_T_link.size(); i++) same = cv::norm(a.base_T_link[i] - b.base_T_link[i], NORM_INF) == 0;
    return same;
}

TEST(SurgTrack_ArticulatedEKF, startsFromTheCalibrationAndTheReadings)
{
    const Bench bench(PosedTool(0.1));
    const ArticulatedPoseEKF::Params params;
    Ptr<ArticulatedPoseEKF> filter = bench.filter();
    for (int again = 0; again < 2; again++)
    {
        EXPECT_EQ(0, cv::norm(filter->correction() - Matx44d::eye(), NORM_INF));
        EXPECT_EQ(std::vector<double>(7, 0.), filter->offsets());
        EXPECT_EQ(0, filter->nis());
        const Mat P = filter->covariance();
        ASSERT_EQ(Size(10, 10), P.size());   // six, and q4, q5, q6, jaw
        ASSERT_EQ(CV_64FC1, P.type());
        EXPECT_EQ(10, countNonZero(P));      // diagonal
        for (int i = 0; i < 10; i++)
            EXPECT_NEAR(i < 3 ? params.initialRotation : i < 6 ? params.initialTranslation : 0.03, deviation(P, i), 1e-15);   // rounding
        filter->predict(bench.readings());
        EXPECT_LT(cv::norm(filter->view().camera_T_base - bench.nominal_T_base, NORM_INF), 1e-15);   // rounding
        ASSERT_TRUE(correct(*filter, endoscope(), bench.parts, bench.seen(endoscope())));
        filter->reset();
    }
}

TEST(SurgTrack_ArticulatedEKF, jacobiansEqualCentralDifferences)
{
    const CameraModel cameras[] = {endoscope(true), endoscope(false)};
    RNG rng(11);
    for (int pose = 0; pose < 8; pose++)
    {
        const CameraModel& camera = cameras[pose % 2];
        const Matx44d eye_T_camera = pose % 4 < 2 ? SAME_EYE : rightEye();
        const Bench bench(PosedTool(rng.uniform(0.08, 0.12), rng.uniform(-3., 3.), rng.uniform(0.9, 1.6), rng.uniform(-0.5, 0.5)),
                          motionAbout(Point3d(0, 0, 0.1), randomDirection(rng) * 0.02, randomDirection(rng) * 0.002), wristOffsets(0.01, -0.02, 0.015, 0.02));
        Ptr<ArticulatedPoseEKF> filter = bench.filter();
        filter->predict(bench.readings());
        const Point3d c = bench.centre(filter->view());
        for (int few = 0; few < 6; few++)
        {
            // A few parts at a time, so that P is another, full, matrix each time: what is compared then tells all of the Jacobian.
            std::vector<int> parts;
            for (int i = 0; i < few; i++) parts.push_back(rng.uniform(0, int(bench.parts.size())));
            std::vector<Point2d> points;
            for (int part : parts) points.push_back(bench.seen(camera)[part]);
            if (few > 0)
            {
                ASSERT_TRUE(correct(*filter, camera, parts, points));
            }
            const Mat P = filter->covariance();
            const int n = P.rows;
            const double step = 1e-5;   // [rad], [m]
            std::vector<ToolView> plus, minus;
            for (int i = 0; i < n; i++)
            {
                Mat_<double> x = Mat_<double>::zeros(n, 1);
                x(i) = step;
                plus.push_back(changed(bench, *filter, c, x));
                minus.push_back(changed(bench, *filter, c, -x));
            }
            for (int part : bench.parts)
            {
                Mat_<double> H(2, n);
                for (int i = 0; i < n; i++)
                {
                    const Point2d d = camera.project(transformed(eye_T_camera, bench.keypoint(plus[i], part)))
                                      - camera.project(transformed(eye_T_camera, bench.keypoint(minus[i], part)));
                    H(0, i) = d.x / (2 * step);
                    H(1, i) = d.y / (2 * step);
                }
                const Mat_<double> expected = H * P * H.t();
                // Third derivatives times step^2 / 6 are 1e-6 of the first (see SurgTrack_EKF), and so of their squares.
                ASSERT_LT(cvtest::norm(Mat(filter->imageCovariance(camera, eye_T_camera, part)), expected, NORM_INF), 1e-5 * cvtest::norm(expected, NORM_INF))
                    << pose << ", part " << part;
            }
            Mat_<double> J(6, n);
            for (int i = 0; i < n; i++)
            {
                const Matx44d a = bench.toolPose(minus[i]), b = bench.toolPose(plus[i]);
                const Vec3d w = rotationVector(b.get_minor<3, 3>(0, 0) * a.get_minor<3, 3>(0, 0).t());
                for (int r = 0; r < 3; r++)
                {
                    J(r, i) = w[r] / (2 * step);
                    J(3 + r, i) = (b(r, 3) - a(r, 3)) / (2 * step);
                }
            }
            const Mat_<double> expected = J * P * J.t();
            // By blocks: rad^2 and m^2 differ by four decades.
            const Mat found = Mat(filter->poseCovariance());
            for (int block = 0; block < 4; block++)
            {
                const Rect at(block % 2 * 3, block / 2 * 3, 3, 3);
                ASSERT_LT(cvtest::norm(found(at), expected(at), NORM_INF), 1e-6 * cvtest::norm(expected(at), NORM_INF) + 1e-12) << "block " << block;   // as above
            }
        }
    }
}

TEST(SurgTrack_ArticulatedEKF, recoversThePoseFromThePointsOfOneFrame)
{
    ArticulatedPoseEKF::Params params;
    params.pointNoise = 0.01;   // points without noise: next to nothing is left to the prior
    params.gate = 0;            // linearization at the start is off by pixels
    RNG rng(12);
    for (int run = 0; run < 10; run++)
    {
        const CameraModel camera = endoscope(run % 2 == 0);
        const PosedTool tool(rng.uniform(0.09, 0.11), rng.uniform(-3., 3.), rng.uniform(0.9, 1.5), rng.uniform(-0.5, 0.5));
        const Bench bench(tool, motionAbout(Point3d(0, 0, 0.1), randomDirection(rng) * 3 * DEGREE, randomDirection(rng) * 0.006),
                          wristOffsets(0.03, -0.02, 0.025, 0.04));
        Ptr<ArticulatedPoseEKF> filter = bench.filter(params);
        filter->predict(bench.readings());
        EXPECT_GT(distance(bench.toolPose(filter->view()), tool.camera_T_tool), 1e-3);
        ASSERT_TRUE(correct(*filter, camera, bench.parts, bench.seen(camera), 8));
        // The prior (4 degrees, 8 mm, 0.03 rad) pulls by its share of the information, 1e-6 to 1e-5.
        EXPECT_LT(rotationAngle(bench.toolPose(filter->view()), tool.camera_T_tool), 1e-5) << run;
        EXPECT_LT(distance(bench.toolPose(filter->view()), tool.camera_T_tool), 1e-6) << run;
        // What is beyond the wrist's two bends is seen to move against the rest.
        EXPECT_NEAR(bench.offsets[5], filter->offsets()[5], 1e-4) << run;
        EXPECT_NEAR(bench.offsets[6], filter->offsets()[6], 1e-4) << run;
    }
}

TEST(SurgTrack_ArticulatedEKF, recoversCorrectionAndOffsetsAsTheArmMoves)
{
    // An offset of the roll turns all that is seen: only the arm's motion tells it from a turn of the camera.
    ArticulatedPoseEKF::Params params;
    params.pointNoise = 0.01;
    params.gate = 0;
    params.processRotation = params.processTranslation = params.processJoint = 0;   // the truth is constant
    const CameraModel camera = endoscope(false);
    for (int run = 0; run < 4; run++)
    {
        RNG rng(30 + run);
        Bench bench(PosedTool(0.1, 0.3 + run, 1.2, 0.3), motionAbout(Point3d(0, 0, 0.1), randomDirection(rng) * 3 * DEGREE, randomDirection(rng) * 0.006),
                    wristOffsets(0.03, -0.02, 0.025, 0.04));
        Ptr<ArticulatedPoseEKF> filter = bench.filter(params);
        for (int frame = 0; frame < 30; frame++)
        {
            std::vector<double> q = joints(bench.tool, 0.4 + 0.5 * std::sin(0.3 * frame), 0.4 * std::cos(0.2 * frame), 0.4 * std::sin(0.25 * frame), 0.5);
            q[0] = 0.2 * std::sin(0.2 * frame);
            q[1] = 0.2 * std::cos(0.2 * frame);
            bench.move(q);
            filter->predict(bench.readings());
            ASSERT_TRUE(correct(*filter, camera, bench.parts, bench.seen(camera), 5));
        }
        for (int i = 0; i < 7; i++) EXPECT_NEAR(bench.offsets[i], filter->offsets()[i], 2e-4) << run << ", coordinate " << i;   // the prior's share, as above
        const Matx44d tool = bench.tool.camera_T_tool;   // a point to compare at
        EXPECT_LT(rotationAngle(filter->correction(), bench.correction), 3e-4) << run;
        EXPECT_LT(distance(filter->correction() * tool, bench.correction * tool), 3e-5) << run;
    }
}

TEST(SurgTrack_ArticulatedEKF, recoversCorrectionAndOffsetsFromContours)
{
    ArticulatedPoseEKF::Params params;
    params.contourNoise = 0.01;
    params.contourCorrelation = 1;
    const CameraModel cameras[] = {endoscope(), endoscope(false)};
    const Matx44d eyes[] = {SAME_EYE, rightEye()};
    for (int run = 0; run < 3; run++)
    {
        RNG rng(13 + run);
        const PosedTool tool(0.1, 0.3 + run, 1.1, 0.35);
        const Bench bench(tool, motionAbout(Point3d(0, 0, 0.1), randomDirection(rng) * 0.5 * DEGREE, randomDirection(rng) * 0.001),
                          wristOffsets(0.005, -0.005, 0.004, 0.006));
        Ptr<ArticulatedPoseEKF> filter = bench.filter(params);
        filter->predict(bench.readings());
        std::vector<ContourPoint> outlines[2];
        for (int eye = 0; eye < 2; eye++)
        {
            outlines[eye] = outlineOf(cameras[eye], eyes[eye] * filter->view().camera_T_base, bench.readings());
            ASSERT_GT(outlines[eye].size(), 100u);
        }
        for (int pass = 0; pass < 12; pass++)
        {
            filter->begin();
            for (int eye = 0; eye < 2; eye++)
            {
                ToolView view = filter->view();
                view.camera_T_base = eyes[eye] * view.camera_T_base;
                placeContour(cameras[eye], view, outlines[eye]);
                for (ContourPoint& c : outlines[eye])   // where the same points of the tool are
                {
                    const Point3d p = transformed(tool.view.camera_T_base * tool.view.base_T_link[c.link], c.linkPoint);
                    c.offset = (cameras[eye].project(transformed(eyes[eye], p)) - c.imagePoint).dot(c.normal);
                    c.deviation = 1;
                    c.found = true;
                }
                const int passed = filter->addContour(cameras[eye], eyes[eye], outlines[eye], 20);
                EXPECT_EQ(int(outlines[eye].size()), passed) << run;
            }
            ASSERT_TRUE(filter->solve());
        }
        const Matx44d found = bench.toolPose(filter->view());
        // Noise-free; the prior has its share, along the worst direction (turns about the shaft) 1e-4 of 0.5 degrees.
        EXPECT_LT(rotationAngle(found, tool.camera_T_tool), 1e-4) << run;
        EXPECT_LT(distance(found, tool.camera_T_tool), 5e-6) << run;
    }
}

TEST(SurgTrack_ArticulatedEKF, theCovarianceStaysSymmetricAndPositiveDefinite)
{
    const CameraModel camera = endoscope();
    for (int few = 0; few < 2; few++)
    {
        // Many points nearly without noise, and one point now and then, with next to no process noise.
        ArticulatedPoseEKF::Params params;
        params.pointNoise = few ? 3 : 0.01;
        params.processRotation = few ? 1e-3 : 1e-9;
        params.processTranslation = few ? 1e-4 : 1e-10;
        params.processJoint = few ? 0.03 : 1e-9;
        Bench bench(PosedTool(0.1));
        Ptr<ArticulatedPoseEKF> filter = bench.filter(params);
        RNG rng(14);
        for (int step = 0; step < 600; step++)
        {
            bench.move(joints(bench.tool, 0.4 + 0.3 * std::sin(0.1 * step), 0.3 * std::cos(0.07 * step), -0.2, 0.5));
            filter->predict(bench.tool.joints);
            const std::vector<Point2d> points = bench.seen(camera, SAME_EYE, params.pointNoise, &rng);
            const int n = few ? step % 2 : int(points.size());
            if (n > 0) correct(*filter, camera, std::vector<int>(bench.parts.begin(), bench.parts.begin() + n), std::vector<Point2d>(points.begin(), points.begin() + n));
            if (step % 30 != 29) continue;
            ASSERT_TRUE(isSymmetricPositiveDefinite(filter->covariance())) << few << ", step " << step;
        }
        EXPECT_TRUE(checkRange(filter->correction()));
    }
}

TEST(SurgTrack_ArticulatedEKF, undoTakesBackAllSinceThePrediction)
{
    const CameraModel camera = endoscope();
    const Bench bench(PosedTool(0.1), motionAbout(Point3d(0, 0, 0.1), Vec3d(0.01, 0.02, -0.01), Vec3d(0.001, -0.001, 0.002)), wristOffsets(0.02, 0.01, -0.02, 0.01));
    Ptr<ArticulatedPoseEKF> filter = bench.filter();
    filter->predict(bench.readings());
    correct(*filter, camera, bench.parts, bench.seen(camera));
    filter->predict(bench.readings());
    const Matx44d correction = filter->correction();
    const std::vector<double> offsets = filter->offsets();
    const Mat P = filter->covariance();
    const ToolView view = filter->view();
    ASSERT_TRUE(correct(*filter, camera, bench.parts, bench.seen(camera), 3));
    EXPECT_GT(cv::norm(filter->correction() - correction, NORM_INF), 0);
    EXPECT_FALSE(sameView(view, filter->view()));
    for (int by = 0; by < 2; by++)
    {
        if (by == 0) filter->undo();
        else filter->inflate(0.02, 0.003);
        EXPECT_EQ(0, cv::norm(filter->correction() - correction, NORM_INF));
        EXPECT_EQ(offsets, filter->offsets());
        EXPECT_TRUE(sameView(view, filter->view()));
        Mat expected = P.clone();
        for (int i = 0; i < 6 && by == 1; i++) expected.at<double>(i, i) += std::pow(i < 3 ? 0.02 : 0.003, 2);
        EXPECT_EQ(0, cvtest::norm(expected, filter->covariance(), NORM_INF)) << by;
    }
    EXPECT_FALSE((filter->begin(), filter->solve()));   // nothing was added
    EXPECT_EQ(offsets, filter->offsets());
}

TEST(SurgTrack_ArticulatedEKF, aCopyGoesOnAsTheOriginalDoes)
{
    const CameraModel camera = endoscope();
    const Bench bench(PosedTool(0.1), motionAbout(Point3d(0, 0, 0.1), Vec3d(0.01, 0.02, -0.01), Vec3d(0.001, -0.001, 0.002)), wristOffsets(0.02, 0.01, -0.02, 0.01));
    Ptr<ArticulatedPoseEKF> filter = bench.filter(), copy = bench.filter();
    filter->predict(bench.readings());
    ASSERT_TRUE(correct(*filter, camera, bench.parts, bench.seen(camera)));
    copy->predict(joints(bench.tool, 0, 0, 0, 0));
    filter->copyTo(*copy);
    for (int step = 0; step < 4; step++)
    {
        EXPECT_TRUE(sameView(filter->view(), copy->view())) << step;
        EXPECT_EQ(filter->offsets(), copy->offsets()) << step;
        EXPECT_EQ(filter->nis(), copy->nis()) << step;
        EXPECT_EQ(0, cvtest::norm(filter->covariance(), copy->covariance(), NORM_INF)) << step;
        for (ArticulatedPoseEKF* f : {filter.get(), copy.get()})
        {
            if (step == 0) correct(*f, camera, bench.parts, bench.seen(camera));
            else if (step == 1) f->undo();
            else f->predict(bench.readings());
        }
    }
    EXPECT_ERROR(filter->copyTo(*ArticulatedPoseEKF::create(ToolModel::needleDriver(), Matx44d::eye())), "other");
}

TEST(SurgTrack_ArticulatedEKF, whatItWasIsAValue)
{
    const CameraModel camera = endoscope();
    const Bench bench(PosedTool(0.1), motionAbout(Point3d(0, 0, 0.1), Vec3d(0.01, 0.02, -0.01), Vec3d(0.001, -0.001, 0.002)));
    Ptr<ArticulatedPoseEKF> filter = bench.filter();
    filter->predict(bench.readings());
    const ArticulatedPoseEKF::State before = filter->state();
    const ToolView view = filter->view();
    const Mat P = filter->covariance();
    ASSERT_TRUE(correct(*filter, camera, bench.parts, bench.seen(camera)));
    EXPECT_FALSE(sameView(view, filter->view()));
    filter->setState(before);
    EXPECT_TRUE(sameView(view, filter->view()));
    EXPECT_EQ(0, cvtest::norm(P, filter->covariance(), NORM_INF));
}

// blkdiag(R, R) P blkdiag(R, R)^T
Matx66d turned(const Matx66d& P, const Matx44d& T)
{
    Matx66d B = Matx66d::zeros();
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) B(r, c) = B(3 + r, 3 + c) = T(r, c);
    return B * P * B.t();
}

TEST(SurgTrack_ArticulatedEKF, movesWithTheCamera)
{
    const CameraModel camera = endoscope();
    const Bench bench(PosedTool(0.1), motionAbout(Point3d(0, 0, 0.1), Vec3d(0.01, 0.02, -0.01), Vec3d(0.001, -0.001, 0.002)), wristOffsets(0.02, 0.01, -0.02, 0.01));
    Ptr<ArticulatedPoseEKF> filter = bench.filter();
    filter->predict(bench.readings());
    ASSERT_TRUE(correct(*filter, camera, bench.parts, bench.seen(camera)));
    const Matx44d pose = bench.toolPose(filter->view());
    const Matx66d P = filter->poseCovariance();
    const std::vector<double> offsets = filter->offsets();
    const Matx44d now_T_before = rigid(rotationMatrix(Vec3d(0.1, -0.4, 0.2)), Point3d(0.03, -0.02, 0.04));
    filter->moveCamera(now_T_before);
    EXPECT_LT(cv::norm(bench.toolPose(filter->view()) - now_T_before * pose, NORM_INF), 1e-12);   // rounding
    EXPECT_LT(cv::norm(filter->poseCovariance() - turned(P, now_T_before), NORM_INF), 1e-12);
    EXPECT_EQ(offsets, filter->offsets());
    // The points, seen by the moved camera, tell nothing new.
    filter->predict(bench.readings());
    Bench moved = bench;
    moved.tool.view.camera_T_base = now_T_before * bench.tool.view.camera_T_base;
    ASSERT_TRUE(correct(*filter, camera, bench.parts, moved.seen(camera)));
    EXPECT_LT(distance(moved.toolPose(filter->view()), now_T_before * bench.tool.camera_T_tool), 2e-4);   // as well as before
}

TEST(SurgTrack_ArticulatedEKF, anotherCalibrationMovesNothing)
{
    const CameraModel camera = endoscope();
    const Bench bench(PosedTool(0.1), motionAbout(Point3d(0, 0, 0.1), Vec3d(0.01, 0.02, -0.01), Vec3d(0.001, -0.001, 0.002)));
    Ptr<ArticulatedPoseEKF> filter = bench.filter();
    filter->predict(bench.readings());
    ASSERT_TRUE(correct(*filter, camera, bench.parts, bench.seen(camera)));
    const Matx44d pose = bench.toolPose(filter->view());
    const Matx66d P = filter->poseCovariance();
    filter->setHandEye(bench.tool.view.camera_T_base);   // the true one
    EXPECT_LT(cv::norm(bench.toolPose(filter->view()) - pose, NORM_INF), 1e-12);   // rounding
    EXPECT_EQ(0, cv::norm(filter->poseCovariance() - P, NORM_INF) > 1e-15);
    EXPECT_LT(rotationAngle(filter->correction(), Matx44d::eye()), 0.012);   // of 0.024; offsets of 0.03 rad may explain half of a turn in one frame
    EXPECT_ERROR(filter->setHandEye(Matx44d::zeros()), "nominal_T_base");
    EXPECT_ERROR(filter->moveCamera(Matx44d::zeros()), "now_T_before");
}

TEST(SurgTrack_ArticulatedEKF, aRepeatedCorrectionTakesThePlaceOfTheOneBefore)
{
    const CameraModel camera = endoscope();
    // Points where they are expected: the state stays, so each repetition is the same correction.
    const Bench bench(PosedTool(0.1));
    Ptr<ArticulatedPoseEKF> filter = bench.filter();
    filter->predict(bench.readings());
    const std::vector<Point2d> points = bench.seen(camera);
    ASSERT_TRUE(correct(*filter, camera, bench.parts, points));
    const Mat once = filter->covariance();
    const Matx66d pose = filter->poseCovariance();
    ASSERT_TRUE(correct(*filter, camera, bench.parts, points, 10));
    EXPECT_LT(cvtest::norm(once, filter->covariance(), NORM_INF), 1e-12 * cvtest::norm(once, NORM_INF));   // rounding
    // In two frames it is taken in twice.
    filter->predict(bench.readings());
    ASSERT_TRUE(correct(*filter, camera, bench.parts, points));
    // Of the pose: what is the correction's and what the offsets' share no posture tells alone.
    for (int i = 0; i < 6; i++) EXPECT_LT(std::sqrt(filter->poseCovariance()(i, i)), 0.95 * std::sqrt(pose(i, i))) << i;   // 0.71 without Q and prior

    // Points elsewhere: further repetitions only move to where the linearization ends, the most probable state.
    const Bench off(PosedTool(0.1), motionAbout(Point3d(0, 0, 0.1), Vec3d(0.02, -0.01, 0.03), Vec3d(0.002, 0.001, -0.003)), wristOffsets(0.02, -0.01, 0.01, 0.02));
    filter = off.filter();
    filter->predict(off.readings());
    ASSERT_TRUE(correct(*filter, camera, off.parts, off.seen(camera), 10));
    const Matx44d correction = filter->correction();
    const double nis = filter->nis();
    ASSERT_TRUE(correct(*filter, camera, off.parts, off.seen(camera), 10));
    EXPECT_LT(cv::norm(filter->correction() - correction, NORM_INF), 1e-9);   // converged
    EXPECT_NEAR(nis, filter->nis(), 1e-6);                                    // the same
}

TEST(SurgTrack_ArticulatedEKF, theUpdateIsThatOfTheTextbook)
{
    const CameraModel camera = endoscope();
    const ArticulatedPoseEKF::Params params;
    const Bench bench(PosedTool(0.1), motionAbout(Point3d(0, 0, 0.1), Vec3d(0.01, -0.02, 0.01), Vec3d(0.001, -0.002, 0.001)), wristOffsets(0.01, -0.01, 0.02, 0.01));
    Ptr<ArticulatedPoseEKF> filter = bench.filter();
    filter->predict(bench.readings());
    const Mat P = filter->covariance();
    const Point3d c = bench.centre(filter->view());
    const int n = P.rows, rows = 2 * int(bench.parts.size());
    Mat_<double> H(rows, n), y(rows, 1);
    const std::vector<Point2d> points = bench.seen(camera);
    const ToolView before = filter->view();
    for (int i = 0; i < n; i++)
    {
        const double step = 1e-5;
        Mat_<double> x = Mat_<double>::zeros(n, 1);
        x(i) = step;
        const ToolView plus = changed(bench, *filter, c, x), minus = changed(bench, *filter, c, -x);
        for (int part : bench.parts)
        {
            const Point2d d = camera.project(bench.keypoint(plus, part)) - camera.project(bench.keypoint(minus, part));
            H(2 * part, i) = d.x / (2 * step);
            H(2 * part + 1, i) = d.y / (2 * step);
            const Point2d r = points[part] - camera.project(bench.keypoint(before, part));
            y(2 * part) = r.x;
            y(2 * part + 1) = r.y;
        }
    }
    const Mat S = H * P * H.t() + std::pow(params.pointNoise, 2) * Mat::eye(rows, rows, CV_64F), inverse = S.inv(DECOMP_CHOLESKY), K = P * H.t() * inverse;
    const Mat_<double> x = K * y;
    const ToolView expected = changed(bench, *filter, c, x);
    ASSERT_TRUE(correct(*filter, camera, bench.parts, points));
    EXPECT_LT(cv::norm(expected.camera_T_base - filter->view().camera_T_base, NORM_INF), 1e-8);   // central differences are good to 1e-6 of 1e-2
    for (int i = 0; i < 4; i++) EXPECT_NEAR(x(6 + i), filter->offsets()[3 + i], 1e-7);               // the same
    const Mat expectedP = (Mat::eye(n, n, CV_64F) - K * H) * P;
    EXPECT_LT(cvtest::norm(expectedP, filter->covariance(), NORM_INF), 1e-5 * cvtest::norm(expectedP, NORM_INF));   // the same, and a condition of 1e5 of S
    EXPECT_NEAR(Mat(y.t() * inverse * y).at<double>(0) / rows, filter->nis(), 1e-4 * filter->nis());                  // the same
}

TEST(SurgTrack_ArticulatedEKF, aNewCentreLeavesTheCovarianceOfAFixedPointAsItIs)
{
    const CameraModel camera = endoscope();
    for (int noisy = 0; noisy < 2; noisy++)
    {
        ArticulatedPoseEKF::Params params;
        if (!noisy) params.processRotation = params.processTranslation = params.processJoint = 0;
        const Bench bench(PosedTool(0.1), Matx44d::eye());
        Ptr<ArticulatedPoseEKF> filter = bench.filter(params);
        filter->predict(bench.readings());
        ASSERT_TRUE(correct(*filter, camera, bench.parts, bench.seen(camera)));

        // The wrist moves, the shaft does not, nor do its keypoints.
        const std::vector<double> moved = joints(bench.tool, 0.4, -0.6, 0.7, 0.1);
        std::vector<Matx22d> before;
        for (int part : bench.parts) before.push_back(filter->imageCovariance(camera, SAME_EYE, part));
        const Mat P = filter->covariance();
        const Point3d centre = bench.centre(filter->view());
        filter->predict(moved, 2);
        EXPECT_GT(cv::norm(bench.centre(filter->view()) - centre), 5e-4);
        EXPECT_GT(cvtest::norm(P, filter->covariance(), NORM_INF), 1e-9);
        int still = 0;
        for (int part : bench.parts)
        {
            if (bench.tool.model->links()[bench.tool.model->keypoints()[part].link].coordinate != bench.tool.model->coordinateIndex("q4")) continue;
            still++;
            const Matx22d after = filter->imageCovariance(camera, SAME_EYE, part);
            if (noisy)
                EXPECT_GT(trace(after - before[part]), 0) << part;   // Q
            else
                EXPECT_LT(cv::norm(before[part] - after, NORM_INF), 1e-9 * cv::norm(after, NORM_INF)) << part;   // rounding
        }
        EXPECT_GE(still, 2);
    }
}

TEST(SurgTrack_ArticulatedEKF, aFrameAddsTheProcessNoiseTimesItsGrowth)
{
    const ArticulatedPoseEKF::Params params;
    const Bench bench(PosedTool(0.1));
    Ptr<ArticulatedPoseEKF> filter = bench.filter();
    filter->predict(bench.readings());
    const double growths[] = {1, 0, 5};
    for (double growth : growths)
    {
        Mat expected = filter->covariance();
        for (int i = 0; i < 6; i++) expected.at<double>(i, i) += std::pow(growth * (i < 3 ? params.processRotation : params.processTranslation), 2);
        for (int i = 6; i < 10; i++) expected.at<double>(i, i) += std::pow(growth * params.processJoint * 0.03, 2);   // no travel yet: of the offsets alone
        filter->predict(bench.readings(), growth);
        EXPECT_LT(cvtest::norm(expected, filter->covariance(), NORM_INF), 1e-16);   // rounding of 1e-2 [rad^2]
    }
}

TEST(SurgTrack_ArticulatedEKF, onlyJointsThatAreNotExactHaveOffsets)
{
    const CameraModel camera = endoscope();
    const PosedTool driver(0.1);
    const Ptr<ToolModel> model = driver.model;
    for (int which = 0; which < 3; which++)
    {
        ToolModel::Description d;
        d.name = model->name();
        d.coordinates = model->coordinateNames();
        d.links = model->links();
        d.meshes = model->meshes();
        d.keypoints = model->keypoints();
        d.endEffectorLink = model->endEffectorLink();
        for (ToolModel::Link& link : d.links)
            if (link.coordinate >= 0)
                link.offsetDeviation = which == 0 ? 0 : which == 1 && link.coordinate == model->coordinateIndex("jaw") ? 0.05 : which == 2 ? -1 : 0;
        const Bench bench(driver, motionAbout(Point3d(0, 0, 0.1), Vec3d(0.02, 0, 0.01), Vec3d(0.001, 0.002, 0)), wristOffsets(0.03, 0.03, 0.03, 0.03));
        const Ptr<ToolModel> other = ToolModel::create(d);
        Ptr<ArticulatedPoseEKF> filter = ArticulatedPoseEKF::create(other, bench.nominal_T_base);
        filter->predict(bench.readings());
        ASSERT_TRUE(correct(*filter, camera, bench.parts, bench.seen(camera), 3));
        EXPECT_EQ(which == 0 ? 6 : which == 1 ? 7 : 10, filter->covariance().rows);
        ASSERT_EQ(7u, filter->offsets().size());
        const std::vector<double> deviations = other->offsetDeviations();
        ArticulatedPoseEKF::Params none;
        none.jointOffsets = false;
        EXPECT_EQ(6, ArticulatedPoseEKF::create(other, bench.nominal_T_base, none)->covariance().rows) << which;
        for (int i = 0; i < 7; i++) EXPECT_EQ(deviations[i] > 0, filter->offsets()[i] != 0) << which << ", coordinate " << i;
    }
}

TEST(SurgTrack_ArticulatedEKF, theJawStopsWhenItIsClosed)
{
    const CameraModel camera = endoscope();
    ArticulatedPoseEKF::Params params;
    params.pointNoise = 0.5;
    params.gate = 0;
    // The jaw reads 0.02, and its tips are seen where they would be if it had closed beyond its stop.
    PosedTool tool(0.1);
    tool.set("jaw", -0.1);
    tool.place();
    const Bench bench(tool, Matx44d::eye(), wristOffsets(0, 0, 0, -0.12));
    const double stopped = -bench.readings()[6];
    ASSERT_NEAR(-0.02, stopped, 1e-15);   // rounding
    const std::vector<Point2d> points = bench.seen(camera);
    Ptr<ArticulatedPoseEKF> filter = bench.filter(params);
    std::vector<Matx44d> closed;
    std::vector<double> stop = bench.readings();
    filter->predict(bench.readings());
    ASSERT_TRUE(correct(*filter, camera, bench.parts, points, 5));
    EXPECT_NEAR(stopped, filter->offsets()[6], 1e-15);   // the sum of what is wrong with a reading: rounding
    for (int i = 0; i < 7; i++) stop[i] += filter->offsets()[i];
    stop[6] = 0;
    bench.tool.model->forwardKinematics(stop, closed);
    for (size_t l = 0; l < closed.size(); l++) EXPECT_LT(cv::norm(closed[l] - filter->view().base_T_link[l], NORM_INF), 1e-12) << l;   // rounding

    // However often it is repeated, the stop does not push the rest away.
    const Matx44d correction = filter->correction();
    ASSERT_TRUE(correct(*filter, camera, bench.parts, points, 30));
    EXPECT_NEAR(stopped, filter->offsets()[6], 1e-15);   // the sum of what is wrong with a reading: rounding
    EXPECT_LT(cv::norm(filter->correction() - correction, NORM_INF), 1e-6);   // converged

    // A reading beyond the stop is left as it is, but not made worse.
    std::vector<double> beyond = bench.readings();
    beyond[6] = -0.03;
    filter->reset();
    filter->predict(beyond);
    ASSERT_TRUE(correct(*filter, camera, bench.parts, points, 5));
    EXPECT_NEAR(0, filter->offsets()[6], 1e-15);
}

TEST(SurgTrack_ArticulatedEKF, resetStartsFromTheCorrectionGiven)
{
    const Bench bench(PosedTool(0.1));
    const Matx44d correction = motionAbout(Point3d(0, 0, 0.1), Vec3d(0.02, -0.01, 0.03), Vec3d(0.004, 0, -0.003));
    Ptr<ArticulatedPoseEKF> filter = bench.filter(), fresh = bench.filter();
    filter->predict(bench.readings());
    ASSERT_TRUE(correct(*filter, endoscope(), bench.parts, bench.seen(endoscope())));
    filter->reset(correction);
    EXPECT_EQ(0, cv::norm(filter->correction() - correction, NORM_INF));
    EXPECT_EQ(0, cvtest::norm(filter->covariance(), fresh->covariance(), NORM_INF));
    EXPECT_ERROR(filter->reset(Matx44d::zeros()), "rigid");
}

TEST(SurgTrack_ArticulatedEKF, pointsThatDisagreeWithTheRestCountLittleWithinATolerance)
{
    // Two of fourteen points are 10 pixels off, within the gate of a vague prediction.
    const CameraModel camera = endoscope(false);
    const Bench bench(PosedTool(0.1));
    std::vector<Point2d> points = bench.seen(camera);
    points[3] += Point2d(7, 7);
    points[8] += Point2d(7, 7);
    double error[2];
    for (int robust = 0; robust < 2; robust++)
    {
        Ptr<ArticulatedPoseEKF> filter = bench.filter();
        filter->predict(bench.readings());
        std::vector<uchar> used;
        for (int i = 0; i < 5; i++)
        {
            filter->begin();
            filter->addPoints(camera, SAME_EYE, bench.parts, points, used, std::vector<double>(), robust && i > 0 ? 1 : DBL_MAX);
            ASSERT_TRUE(filter->solve());
        }
        for (uchar u : used) EXPECT_EQ(1, u);   // no gate does it
        error[robust] = distance(bench.toolPose(filter->view()), bench.tool.camera_T_tool);
    }
    EXPECT_GT(error[0], 0.0002);              // there was something to repair
    EXPECT_LT(error[1], 0.5 * error[0]);      // a weight of 1 / (1 + 100 / 37)^2, a fourteenth; what the rest tolerates dilutes it
}

TEST(SurgTrack_ArticulatedEKF, twoEyesTellMoreThanOne)
{
    const CameraModel left = endoscope(), right = endoscope(false);
    const Bench bench(PosedTool(0.1));   // points where they are expected, so that both linearize at the same state
    Ptr<ArticulatedPoseEKF> one = bench.filter(), two = bench.filter();
    std::vector<uchar> used;
    const int n = int(bench.parts.size());
    for (int eyes = 1; eyes <= 2; eyes++)
    {
        ArticulatedPoseEKF& filter = eyes == 1 ? *one : *two;
        filter.predict(bench.readings());
        for (int i = 0; i < 3; i++)
        {
            filter.begin();
            EXPECT_EQ(n, filter.addPoints(left, SAME_EYE, bench.parts, bench.seen(left), used));
            if (eyes == 2)
            {
                EXPECT_EQ(n, filter.addPoints(right, rightEye(), bench.parts, bench.seen(right, rightEye()), used));
            }
            ASSERT_TRUE(filter.solve());
        }
    }
    Mat values;
    const Mat gain = one->covariance() - two->covariance();
    cv::eigen(gain, values);
    EXPECT_GT(values.at<double>(gain.rows - 1), -1e-15);   // less uncertain in every direction; rounding of 1e-3 [rad^2]
    // Depth most of all: 3 px in one image are 4 mm, a baseline of 5.2 mm at 0.1 m makes 45 px of it.
    const double depth1 = one->poseCovariance()(5, 5), depth2 = two->poseCovariance()(5, 5);
    EXPECT_LT(depth2, 0.8 * depth1);   // measured: 0.57
}

TEST(SurgTrack_ArticulatedEKF, aGrossOutlierIsGatedAndReported)
{
    const CameraModel camera = endoscope();
    const Bench bench(PosedTool(0.1));
    const std::vector<Point2d> points = bench.seen(camera);
    const int wrong = 4, n = int(points.size());
    std::vector<int> others;
    std::vector<Point2d> withoutIt;
    for (int i = 0; i < n; i++)
        if (i != wrong) others.push_back(i), withoutIt.push_back(points[i]);
    Ptr<ArticulatedPoseEKF> filter = bench.filter(), clean = bench.filter();
    for (int frame = 0; frame < 5; frame++)   // both are sure of their state
    {
        filter->predict(bench.readings());
        clean->predict(bench.readings());
        ASSERT_TRUE(correct(*filter, camera, bench.parts, points));
        ASSERT_TRUE(correct(*clean, camera, bench.parts, points));
    }
    std::vector<Point2d> spoilt = points;
    spoilt[wrong].x += 60;
    std::vector<uchar> used;
    filter->predict(bench.readings());
    filter->begin();
    EXPECT_EQ(n - 1, filter->addPoints(camera, SAME_EYE, bench.parts, spoilt, used));
    ASSERT_EQ(size_t(n), used.size());
    for (int i = 0; i < n; i++) EXPECT_EQ(i == wrong ? 0 : 1, used[i]) << i;
    ASSERT_TRUE(filter->solve());
    clean->predict(bench.readings());
    ASSERT_TRUE(correct(*clean, camera, others, withoutIt));
    EXPECT_EQ(0, cv::norm(clean->correction() - filter->correction(), NORM_INF));   // the same rows
    EXPECT_EQ(0, cvtest::norm(clean->covariance(), filter->covariance(), NORM_INF));

    ArticulatedPoseEKF::Params params;
    params.gate = 0;
    filter = bench.filter(params);
    filter->predict(bench.readings());
    filter->begin();
    EXPECT_EQ(n, filter->addPoints(camera, SAME_EYE, bench.parts, spoilt, used));
}

TEST(SurgTrack_ArticulatedEKF, aFactorOfTheNoiseIsALargerNoise)
{
    const CameraModel camera = endoscope();
    const Bench bench(PosedTool(0.1), motionAbout(Point3d(0, 0, 0.1), Vec3d(0.01, -0.02, 0.01), Vec3d(0.001, -0.002, 0.001)));
    ArticulatedPoseEKF::Params params;
    params.pointNoise *= 2;
    Ptr<ArticulatedPoseEKF> factor = bench.filter(), larger = bench.filter(params);
    std::vector<uchar> used;
    for (ArticulatedPoseEKF* filter : {factor.get(), larger.get()})
    {
        filter->predict(bench.readings());
        filter->begin();
        const std::vector<double> noise(filter == factor.get() ? bench.parts.size() : 0, 2.);
        EXPECT_EQ(int(bench.parts.size()), filter->addPoints(camera, SAME_EYE, bench.parts, bench.seen(camera), used, noise));
        ASSERT_TRUE(filter->solve());
    }
    EXPECT_LT(cv::norm(factor->correction() - larger->correction(), NORM_INF), 1e-12);   // rounding
    EXPECT_LT(cvtest::norm(factor->covariance(), larger->covariance(), NORM_INF), 1e-15);
}

TEST(SurgTrack_ArticulatedEKF, edgesBeyondTheToleranceAreLeftOut)
{
    const CameraModel camera = endoscope();
    const Bench bench(PosedTool(0.1));
    ArticulatedPoseEKF::Params params;
    params.contourNoise = 1;
    params.initialRotation = params.initialTranslation = 1e-7;   // a state that is known tolerates nothing
    params.processRotation = params.processTranslation = params.delay = 0;
    params.jointOffsets = false;
    Ptr<ArticulatedPoseEKF> filter = bench.filter(params);
    filter->predict(bench.readings());
    std::vector<ContourPoint> points = outlineOf(camera, filter->view().camera_T_base, bench.readings());
    ASSERT_GT(points.size(), 100u);
    for (size_t i = 0; i < points.size(); i++)
    {
        points[i].found = i % 4 != 3;
        points[i].deviation = 1;
        points[i].offset = i % 4 == 0 ? 9.5 : i % 4 == 1 ? -9.4 : 0;
    }
    // The gate is 3 * sqrt(1 + tolerance^2): with a tolerance of 3 pixels it is at 9.49.
    filter->begin();
    int expected = 0;
    for (size_t i = 0; i < points.size(); i++) expected += i % 4 == 1 || i % 4 == 2;
    EXPECT_EQ(expected, filter->addContour(camera, SAME_EYE, points, 3));
    EXPECT_TRUE(filter->solve());

    // A tool that may be a centimetre elsewhere has its edges so far away.
    filter = bench.filter();
    filter->predict(bench.readings());
    filter->begin();
    EXPECT_EQ(int(points.size()) * 3 / 4, filter->addContour(camera, SAME_EYE, points, 3));

    // Correlated neighbours: thirty of them tell as much as one.
    for (ContourPoint& c : points) c.found = true, c.offset = 0;
    ArticulatedPoseEKF::Params all, few;
    all.contourCorrelation = 30;
    few.contourCorrelation = 1;
    few.contourNoise = all.contourNoise * std::sqrt(30.);
    Mat P[2];
    for (int i = 0; i < 2; i++)
    {
        filter = bench.filter(i ? few : all);
        filter->predict(bench.readings());
        filter->begin();
        EXPECT_EQ(int(points.size()), filter->addContour(camera, SAME_EYE, points, 3));
        ASSERT_TRUE(filter->solve());
        P[i] = filter->covariance();
    }
    EXPECT_LT(cvtest::norm(P[0], P[1], NORM_INF), 1e-9 * cvtest::norm(P[0], NORM_INF));   // the same weights: rounding
}

TEST(SurgTrack_ArticulatedEKF, whatAPushExplainsIsASurprise)
{
    const CameraModel camera = endoscope();
    ArticulatedPoseEKF::Params params;
    params.gate = 0;   // which would leave out most of what a push does
    const Bench bench(PosedTool(0.1));
    Ptr<ArticulatedPoseEKF> filter = bench.filter(params);
    for (int frame = 0; frame < 5; frame++)
    {
        filter->predict(bench.readings());
        ASSERT_TRUE(correct(*filter, camera, bench.parts, bench.seen(camera)));
    }
    filter->predict(bench.readings());
    double before = -1;
    const double shifts[] = {0, 0.0005, 0.001, 0.002};   // [m]
    for (double shift : shifts)
    {
        Bench pushed = bench;
        pushed.tool.view.camera_T_base = motionAbout(Point3d(0, 0, 0.1), Vec3d(), Vec3d(shift, 0, 0)) * bench.tool.view.camera_T_base;
        std::vector<uchar> used;
        filter->begin();
        EXPECT_EQ(0, filter->surprise(DEGREE, 0.002));   // nothing was added
        filter->addPoints(camera, SAME_EYE, pushed.parts, pushed.seen(camera), used);
        const double surprise = filter->surprise(DEGREE, 0.002);
        EXPECT_EQ(0, filter->surprise(0, 0));
        if (shift == 0)
        {
            EXPECT_NEAR(0, surprise, 1e-9);   // all where it is expected
        }
        if (shift > 0.0005)
        {
            EXPECT_NEAR(4, surprise / before, 0.2);   // squares of distances, but for the curvature of the projection
        }
        before = surprise;
    }
    EXPECT_GT(before, 10);   // 2 mm are 17 pixels of 3, of which P explains some. Measured: 18.4
}

TEST(SurgTrack_ArticulatedEKF, isConsistentOverManyRuns)
{
    const CameraModel camera = endoscope();
    ArticulatedPoseEKF::Params params;
    params.initialRotation = 1 * DEGREE;   // small enough for a linearisation
    params.initialTranslation = 0.002;
    params.processRotation = 0.02 * DEGREE;
    params.processTranslation = 0.00006;
    params.processJoint = 0.01;
    params.pointNoise = 2;
    params.gate = 0;
    const int runs = 50, frames = 12;
    double sum = 0, nis = 0;
    for (int run = 0; run < runs; run++)
    {
        RNG rng(100 + run);
        const PosedTool tool(rng.uniform(0.09, 0.11), rng.uniform(-3., 3.), rng.uniform(0.9, 1.5), 0.2);
        Bench bench(tool);   // the calibration; truth differs from it
        const Ptr<ArticulatedPoseEKF> filter = bench.filter(params);
        const std::vector<double> deviations = tool.model->offsetDeviations();
        Matx44d truth = Matx44d::eye();
        std::vector<double> offsets(7, 0.);
        for (int frame = 0; frame < frames; frame++)
        {
            const std::vector<double> readings = joints(tool, 0.4 + 0.05 * frame, 0.3 * std::sin(0.5 * frame), 0.2 * std::cos(0.4 * frame), 0.6);
            filter->predict(readings);
            const Point3d c = bench.centre(filter->view());
            Vec3d omega, v;
            for (int first = frame == 0; first >= 0; first--)   // what it was before the first frame, and the process noise
                for (int i = 0; i < 3; i++)
                {
                    omega[i] += rng.gaussian(first ? params.initialRotation : params.processRotation);
                    v[i] += rng.gaussian(first ? params.initialTranslation : params.processTranslation);
                }
            truth = motionAbout(c, omega, v) * truth;
            for (int i = 0; i < 7; i++)
            {
                if (frame == 0) offsets[i] = rng.gaussian(deviations[i]);
                offsets[i] += rng.gaussian(params.processJoint * deviations[i]);
            }
            Bench now = bench;
            now.tool.view.camera_T_base = truth * bench.nominal_T_base;
            std::vector<double> real = readings;
            for (int i = 0; i < 7; i++) real[i] += offsets[i];
            now.move(real);
            const std::vector<Point2d> all = now.seen(camera, SAME_EYE, params.pointNoise, &rng);
            const int n = rng.uniform(4, int(all.size()));   // the first ones, so that at times little is seen of the jaws
            ASSERT_TRUE(correct(*filter, camera, std::vector<int>(bench.parts.begin(), bench.parts.begin() + n), std::vector<Point2d>(all.begin(), all.begin() + n), 3));
            nis += filter->nis() / (runs * frames);
            if (frame + 1 < frames) continue;
            const Matx44d error = truth * filter->correction().inv();
            const Vec3d w = rotationVector(error.get_minor<3, 3>(0, 0));
            const Point3d u = transformed(error, c) - c;
            Mat_<double> e = (Mat_<double>(10, 1) << w[0], w[1], w[2], u.x, u.y, u.z, 0, 0, 0, 0);
            for (int i = 0; i < 4; i++) e(6 + i) = offsets[3 + i] - filter->offsets()[3 + i];
            sum += Mat(e.t() * filter->covariance().inv() * e).at<double>(0);
        }
    }
    // The sum is chi-square with 10 * 50 degrees of freedom: mean 500, variance 1000; 95 % lie in 10 +- 1.96 * sqrt(1000) / 50 = 10 +- 1.24 a run.
    EXPECT_GT(sum / runs, 8.76);
    EXPECT_LT(sum / runs, 11.24);
    EXPECT_NEAR(1, nis, 0.05);   // 600 updates of about 17 rows each: three times sqrt(2 / 10200) = 0.014
}

TEST(SurgTrack_ArticulatedEKF, rejectsBadInputAndLeavesTheStateUnchanged)
{
    const CameraModel camera = endoscope();
    const Bench bench(PosedTool(0.1), motionAbout(Point3d(0, 0, 0.1), Vec3d(0.01, 0, 0), Vec3d(0.001, 0, 0)));
    Ptr<ArticulatedPoseEKF> filter = bench.filter();
    filter->predict(bench.readings());
    ASSERT_TRUE(correct(*filter, camera, bench.parts, bench.seen(camera)));
    const Matx44d correction = filter->correction();
    const Mat P = filter->covariance();
    const ToolView view = filter->view();

    std::vector<double> bad = bench.readings();
    EXPECT_ERROR(filter->predict(std::vector<double>(6)), "joints");
    EXPECT_ERROR(filter->predict(std::vector<double>(8)), "joints");
    EXPECT_ERROR(filter->predict(bench.readings(), NOT_A_NUMBER), "growth");
    EXPECT_ERROR(filter->predict(bench.readings(), -1), "growth");
    bad[2] = NOT_A_NUMBER;
    EXPECT_ERROR(filter->predict(bad), "joints");
    EXPECT_ERROR(filter->inflate(-1, 0), "rotation");
    EXPECT_ERROR(filter->inflate(0, NOT_A_NUMBER), "translation");
    EXPECT_ERROR(filter->surprise(NOT_A_NUMBER, 0), "rotation");

    std::vector<uchar> used;
    std::vector<int> parts = bench.parts;
    std::vector<Point2d> points = bench.seen(camera);
    filter->begin();
    EXPECT_ERROR(filter->addPoints(camera, SAME_EYE, parts, std::vector<Point2d>(2), used), "one image point per part");
    parts.back() = int(bench.parts.size());
    EXPECT_ERROR(filter->addPoints(camera, SAME_EYE, parts, points, used), "parts");
    parts.back() = -1;
    EXPECT_ERROR(filter->addPoints(camera, SAME_EYE, parts, points, used), "parts");
    EXPECT_ERROR(filter->imageCovariance(camera, SAME_EYE, -1), "part");
    EXPECT_ERROR(filter->imageCovariance(camera, SAME_EYE, 99), "part");
    points[3].y = NOT_A_NUMBER;
    EXPECT_ERROR(filter->addPoints(camera, SAME_EYE, bench.parts, points, used), "imagePoints");
    EXPECT_ERROR(filter->addPoints(camera, SAME_EYE, bench.parts, bench.seen(camera), used, std::vector<double>(2, 1.)), "noise");
    EXPECT_ERROR(filter->addPoints(camera, SAME_EYE, bench.parts, bench.seen(camera), used, std::vector<double>(bench.parts.size(), 0.)), "noise");
    EXPECT_ERROR(filter->addPoints(camera, Matx44d::zeros(), bench.parts, bench.seen(camera), used), "eye_T_camera");

    std::vector<ContourPoint> outline(1);
    EXPECT_ERROR(filter->addContour(camera, SAME_EYE, outline, 1), "points");   // link -1
    outline[0].link = 99;
    EXPECT_ERROR(filter->addContour(camera, SAME_EYE, outline, 1), "points");
    outline[0].link = 0;
    outline[0].found = true;                                                    // and no deviation
    EXPECT_ERROR(filter->addContour(camera, SAME_EYE, outline, 1), "deviation");
    outline[0].deviation = 1;
    EXPECT_ERROR(filter->addContour(camera, SAME_EYE, outline, -1), "tolerance");
    EXPECT_ERROR(filter->addContour(camera, Matx44d::zeros(), outline, 1), "eye_T_camera");

    EXPECT_FALSE(filter->solve());   // nothing was taken in
    EXPECT_EQ(0, cv::norm(correction - filter->correction(), NORM_INF));
    EXPECT_EQ(0, cvtest::norm(P, filter->covariance(), NORM_INF));
    EXPECT_TRUE(sameView(view, filter->view()));

    EXPECT_THROW(ArticulatedPoseEKF::create(Ptr<ToolModel>(), Matx44d::eye()), cv::Exception);
    EXPECT_ERROR(ArticulatedPoseEKF::create(bench.tool.model, Matx44d::zeros()), "nominal_T_base");
}

TEST(SurgTrack_ArticulatedEKF, rejectsBadParameters)
{
    typedef ArticulatedPoseEKF::Params Params;
    const struct { double Params::* member; const char* name; bool zero; } cases[] = {
        {&Params::initialRotation, "initialRotation", false}, {&Params::initialTranslation, "initialTranslation", false},
        {&Params::processRotation, "processRotation", true},  {&Params::processTranslation, "processTranslation", true},
        {&Params::processJoint, "processJoint", true},        {&Params::pointNoise, "pointNoise", false},
        {&Params::contourNoise, "contourNoise", false},       {&Params::contourCorrelation, "contourCorrelation", false}};
    const double values[] = {-1, NOT_A_NUMBER, std::numeric_limits<double>::infinity(), 0};
    for (const auto& c : cases)
        for (double value : values)
        {
            Params params;
            params.*c.member = value;
            if (value == 0 && c.zero)
            {
                EXPECT_NO_THROW(ArticulatedPoseEKF::create(needleDriver(), Matx44d::eye(), params)) << c.name;
            }
            else
                EXPECT_ERROR(ArticulatedPoseEKF::create(needleDriver(), Matx44d::eye(), params), c.name);
        }
    Params params;
    params.gate = NOT_A_NUMBER;
    EXPECT_ERROR(ArticulatedPoseEKF::create(needleDriver(), Matx44d::eye(), params), "gate");
}

TEST(SurgTrack_ArticulatedEKF, pointsBehindTheCameraAreLeftOut)
{
    const CameraModel camera = endoscope();
    const Bench bench(PosedTool(0.1));
    Ptr<ArticulatedPoseEKF> filter = bench.filter();
    filter->predict(bench.readings());
    const Matx44d turned = rigid(rotationMatrix(Vec3d(0, CV_PI, 0)), Point3d());   // an eye that looks the other way
    std::vector<uchar> used;
    filter->begin();
    EXPECT_EQ(0, filter->addPoints(camera, turned, bench.parts, bench.seen(camera), used));
    EXPECT_EQ(0, std::count(used.begin(), used.end(), 1));
    EXPECT_FALSE(filter->solve());
    EXPECT_EQ(0, cv::norm(filter->imageCovariance(camera, turned, 0), NORM_INF));
}

}} // namespace
