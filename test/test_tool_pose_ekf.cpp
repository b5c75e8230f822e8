// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_common.hpp"

namespace opencv_test { namespace {

const double DEGREE = CV_PI / 180;

Matx61d stateOf(double rx, double ry, double rz, double tx, double ty, double tz)
{
    return Matx61d(rx, ry, rz, tx, ty, tz);
}

// Keypoints of the tool in different poses in front of the camera, N x 3.
Mat keypointsOf(int pose)
{
    RNG rng(1000 + pose);
    const Vec6d v = uniform(rng, Vec6d(0.08, -3, 0.9, -0.5, -0.015, -0.01), Vec6d(0.13, 3, 1.6, 0.5, 0.015, 0.01));
    const PosedTool tool(v[0], v[1], v[2], v[3], Point2d(v[4], v[5]));
    const int n = int(tool.model->keypoints().size());
    Mat points(n, 3, CV_64F);
    for (int i = 0; i < n; i++) *points.ptr<Point3d>(i) = tool.keypoint(i);
    return points;
}

// Where the camera sees them if the correction is that of a state, N x 2.
Mat seen(const CameraModel& camera, const Matx61d& state, const Mat& points, double noise = 0, RNG* rng = 0)
{
    Mat image;
    projectKeypoints(camera, state, points, image);
    image = image.reshape(1).clone();
    if (noise > 0)
        for (int i = 0; i < image.rows; i++)
            for (int j = 0; j < 2; j++) image.at<double>(i, j) += rng->gaussian(noise);
    return image;
}

// A wrong calibration: turned about the workspace, 10 cm in front of the camera, and shifted.
Matx44d wrongCalibration(double angle, double shift, uint64 seed)
{
    RNG rng(seed);
    const Matx33d R = rotationMatrix(randomDirection(rng) * angle);
    const Vec3d workspace(0, 0, 0.1), t = workspace - R * workspace + randomDirection(rng) * shift;
    return rigid(R, Point3d(t[0], t[1], t[2]));
}

bool isSymmetricPositiveDefinite(const Mat& P)
{
    Mat values;
    return checkRange(P) && cvtest::norm(P, Mat(P.t()), NORM_INF) == 0 && cv::eigen(P, values) && values.at<double>(P.rows - 1) > 0;
}

Mat_<double> rotationVectorAndTranslation(const Matx44d& T, const Matx44d& reference)
{
    const Matx33d R = T.get_minor<3, 3>(0, 0) * reference.get_minor<3, 3>(0, 0).t();
    const Vec3d w = rotationVector(R);
    return (Mat_<double>(6, 1) << w[0], w[1], w[2], T(0, 3) - reference(0, 3), T(1, 3) - reference(1, 3), T(2, 3) - reference(2, 3));
}

// A sample of a normal distribution.
Mat_<double> gaussianSample(const Mat& covariance, RNG& rng)
{
    Mat_<double> L = covariance.clone(), z(covariance.rows, 1);
    for (int i = 0; i < L.rows; i++)   // Cholesky
        for (int j = 0; j <= i; j++)
        {
            double s = L(i, j);
            for (int k = 0; k < j; k++) s -= L(i, k) * L(j, k);
            L(i, j) = i == j ? std::sqrt(s) : s / L(j, j);
        }
    for (int i = 0; i < L.rows; i++)
    {
        z(i) = rng.gaussian(1);
        for (int j = i + 1; j < L.cols; j++) L(i, j) = 0;
    }
    return L * z;
}

TEST(SurgTrack_EKF, jacobianEqualsCentralDifferences)
{
    const CameraModel cameras[] = {endoscope(true), endoscope(false)};
    RNG rng(3);
    for (const CameraModel& camera : cameras)
        for (int pose = 0; pose < 20; pose++)
        {
            const Mat points = keypointsOf(pose);
            const Matx61d x = stateOf(rng.uniform(-0.2, 0.2), rng.uniform(-0.2, 0.2), rng.uniform(-0.5, 0.5), rng.uniform(-0.01, 0.01), rng.uniform(-0.01, 0.01),
                                      rng.uniform(-0.01, 0.01));
            Mat image, H;
            projectKeypoints(camera, x, points, image, H);
            ASSERT_EQ(Size(6, 2 * points.rows), H.size());
            ASSERT_EQ(CV_64FC1, H.type());
            for (int i = 0; i < 6; i++)
            {
                const double step = i < 3 ? 1e-5 : 1e-6;   // [rad], [m]
                Matx61d plus = x, minus = x;
                plus(i) += step;
                minus(i) -= step;
                const Mat difference = (seen(camera, plus, points) - seen(camera, minus, points)) / (2 * step);
                // Columns reach 1e4 pixel/m; third derivatives of 1e8 pixel/m^3 times step^2 / 6, and 1e-13 pixel / step of rounding.
                ASSERT_LT(cvtest::norm(difference.reshape(1, 2 * points.rows), H.col(i), NORM_INF), 1e-4) << pose << ", column " << i;
            }
        }
}

TEST(SurgTrack_EKF, projectsByTheCorrectionAndTheCamera)
{
    const CameraModel camera = endoscope();
    const Matx61d x = stateOf(0.1, -0.2, 0.3, 0.004, -0.003, 0.002);
    const Matx44d T = correctionFromState(x);
    const Mat points = keypointsOf(1);
    Mat_<Point2d> image;
    projectKeypoints(camera, x, points, image);
    for (int i = 0; i < points.rows; i++)
        EXPECT_LT(cv::norm(image(i) - camera.project(transformed(T, *points.ptr<Point3d>(i)))), 1e-9);   // rounding of the same formula [pixel]
}

TEST(SurgTrack_EKF, theCorrectionIsRzRyRxAndTheTranslation)
{
    const double a = 0.3, b = -0.4, c = 0.7;
    const Matx33d expected = rotationMatrix(Vec3d(0, 0, c)) * rotationMatrix(Vec3d(0, b, 0)) * rotationMatrix(Vec3d(a, 0, 0));
    const Matx44d T = correctionFromState(stateOf(a, b, c, 1, 2, 3));
    EXPECT_LT(cv::norm(T - rigid(expected, Point3d(1, 2, 3)), NORM_INF), 1e-14);   // rounding
}

TEST(SurgTrack_EKF, stateAndCorrectionAreInversesOfEachOther)
{
    RNG rng(4);
    for (int i = 0; i < 200; i++)
    {
        const Matx61d x = stateOf(rng.uniform(-3.1, 3.1), rng.uniform(-1.5, 1.5), rng.uniform(-3.1, 3.1), rng.uniform(-1., 1.), rng.uniform(-1., 1.), rng.uniform(-1., 1.));
        Mat back;
        stateFromCorrection(correctionFromState(x), back);
        ASSERT_EQ(Size(1, 6), back.size());
        ASSERT_LT(cvtest::norm(Mat(x), back, NORM_INF), 1e-12);   // rounding, 14 times larger near a pitch of 86 degrees
        const Matx44d T = correctionFromState(x);
        ASSERT_LT(cv::norm(correctionFromState(back) - T, NORM_INF), 1e-14);   // rounding
    }
    Mat state;
    stateFromCorrection(Matx44d::eye(), state);
    EXPECT_EQ(0, countNonZero(state));
}

TEST(SurgTrack_EKF, pointsNotInFrontOfTheCameraProjectToNaN)
{
    const Matx<double, 2, 3> points(0, 0, -0.1, 0, 0, 0.1);
    Mat image, H;
    projectKeypoints(endoscope(), Matx61d::zeros(), points, image, H);
    EXPECT_TRUE(cvIsNaN(image.at<Point2d>(0).x));
    EXPECT_TRUE(cvIsNaN(H.at<double>(0, 0)));
    EXPECT_TRUE(checkRange(image.row(1)));
    EXPECT_TRUE(checkRange(H.rowRange(2, 4)));
}

TEST(SurgTrack_EKF, convergesToTheTrueCorrection)
{
    const CameraModel camera = endoscope();
    for (int seed = 1; seed <= 20; seed++)
    {
        const Matx44d truth = wrongCalibration(3 * DEGREE, 0.006, seed);
        Mat state;
        stateFromCorrection(truth, state);
        const Matx61d x((double*)state.ptr());
        Ptr<ToolPoseEKF> filter = ToolPoseEKF::create(camera);
        EXPECT_EQ(0, filter->nis());
        for (int frame = 0; frame < 60; frame++)
        {
            const Mat points = keypointsOf(frame);
            filter->predict();
            ASSERT_TRUE(filter->correct(points, seen(camera, x, points)));
        }
        // Noise-free, but the filter believes in 3 pixels of noise and forgets its start only by and by. Measured: 2.5e-5 rad and 5e-7 m at most.
        const Matx44d tool = rigid(Matx33d::eye(), Point3d(0, 0, 0.1));
        EXPECT_LT(rotationAngle(filter->correction() * tool, truth * tool), 1e-4) << seed;
        EXPECT_LT(distance(filter->correction() * tool, truth * tool), 2e-6) << seed;
    }
}

TEST(SurgTrack_EKF, theUpdateIsThatOfTheTextbook)
{
    const CameraModel camera = endoscope();
    const ToolPoseEKF::Params params;
    const Matx61d truth = stateOf(0.01, -0.02, 0.015, 0.001, -0.002, 0.001);
    RNG rng(5);
    Ptr<ToolPoseEKF> filter = ToolPoseEKF::create(camera);
    for (int frame = 0; frame < 5; frame++)
    {
        const Mat points = keypointsOf(frame), image = seen(camera, truth, points, 1, &rng);
        Mat P = filter->covariance(), x = filter->state(), h, H, used;
        for (int i = 0; i < 6; i++) P.at<double>(i, i) += std::pow(i < 3 ? params.processRotation : params.processTranslation, 2);
        filter->predict();
        EXPECT_LT(cvtest::norm(P, filter->covariance(), NORM_INF), 1e-18);   // rounding of 1e-3 [rad^2]
        projectKeypoints(camera, x, points, h, H);
        const Mat y = image.reshape(1, 2 * points.rows) - h.reshape(1, 2 * points.rows);
        const Mat S = H * P * H.t() + std::pow(params.measurementNoise, 2) * Mat::eye(2 * points.rows, 2 * points.rows, CV_64F), inverse = S.inv(DECOMP_CHOLESKY);
        const Mat K = P * H.t() * inverse;
        ASSERT_TRUE(filter->correct(points, image, used));
        ASSERT_EQ(points.rows, countNonZero(used));
        EXPECT_LT(cvtest::norm(Mat(x + K * y), filter->state(), NORM_INF), 1e-10);                                                // S has a condition of 1e5
        EXPECT_LT(cvtest::norm(Mat((Mat::eye(6, 6, CV_64F) - K * H) * P), filter->covariance(), NORM_INF), 1e-12);              // the same, of 1e-3
        EXPECT_NEAR(Mat(y.t() * inverse * y).at<double>(0) / y.rows, filter->nis(), 1e-9 * filter->nis() + 1e-12);
    }
}

TEST(SurgTrack_EKF, theCovarianceStaysSymmetricAndPositiveDefinite)
{
    const CameraModel camera = endoscope();
    RNG rng(6);
    for (int few = 0; few < 2; few++)
    {
        // Many points nearly without noise, and one point now and then, with next to no process noise.
        ToolPoseEKF::Params params;
        params.measurementNoise = few ? 3 : 0.01;
        params.processRotation = few ? 1e-3 : 1e-9;
        params.processTranslation = few ? 1e-4 : 1e-10;
        Ptr<ToolPoseEKF> filter = ToolPoseEKF::create(camera, params);
        for (int step = 0; step < 1000; step++)
        {
            const Mat points = keypointsOf(step % 10), image = seen(camera, Matx61d::zeros(), points, params.measurementNoise, &rng);
            const int n = few ? step % 2 : points.rows;
            filter->predict();
            if (n > 0) filter->correct(points.rowRange(0, n), image.rowRange(0, n));
            if (step % 50 != 49) continue;
            ASSERT_TRUE(isSymmetricPositiveDefinite(filter->covariance())) << few << ", step " << step;
        }
        EXPECT_TRUE(checkRange(filter->state()));
    }
}

TEST(SurgTrack_EKF, isConsistentOverManyRuns)
{
    const CameraModel camera = endoscope();
    ToolPoseEKF::Params params;
    params.initialRotation = 1 * DEGREE;        // small enough for a linearisation
    params.initialTranslation = 0.002;
    params.processRotation = 0.02 * DEGREE;
    params.processTranslation = 0.00006;
    params.measurementNoise = 2;
    params.gate = 0;
    const int runs = 200, frames = 15;
    RNG rng(7);
    double sum = 0, nis = 0;
    for (int run = 0; run < runs; run++)
    {
        Matx61d truth;
        for (int i = 0; i < 6; i++) truth(i) = rng.gaussian(i < 3 ? params.initialRotation : params.initialTranslation);
        Ptr<ToolPoseEKF> filter = ToolPoseEKF::create(camera, params);
        for (int frame = 0; frame < frames; frame++)
        {
            for (int i = 0; i < 6; i++) truth(i) += rng.gaussian(i < 3 ? params.processRotation : params.processTranslation);
            const Mat points = keypointsOf(rng.uniform(0, 30)).rowRange(0, rng.uniform(3, 12));
            filter->predict();
            ASSERT_TRUE(filter->correct(points, seen(camera, truth, points, params.measurementNoise, &rng)));
            nis += filter->nis() / (runs * frames);
        }
        const Mat error = filter->state() - Mat(truth);
        sum += Mat(error.t() * filter->covariance().inv() * error).at<double>(0);
    }
    // Chi-square with 6 * 200 degrees of freedom, over 200: 95 % lie in 6 +- 1.96 * sqrt(2 * 6 / 200). Measured: 5.92.
    EXPECT_GT(sum / runs, 5.52);
    EXPECT_LT(sum / runs, 6.48);
    EXPECT_NEAR(1, nis, 0.02);   // 3000 updates of about 14 rows each: standard deviation sqrt(2 / 42000) = 0.007
}

TEST(SurgTrack_EKF, missingPartsHaveNoRows)
{
    const CameraModel camera = endoscope();
    const Mat points = keypointsOf(0), image = seen(camera, Matx61d::zeros(), points);
    Mat before;
    double smaller = DBL_MAX;
    for (int n = 1; n <= points.rows; n++)
    {
        Ptr<ToolPoseEKF> filter = ToolPoseEKF::create(camera);
        if (n == 1) before = filter->covariance();
        ASSERT_TRUE(filter->correct(points.rowRange(0, n), image.rowRange(0, n)));
        Mat values;
        const Mat P = filter->covariance(), gain = before - P;
        cv::eigen(gain, values);
        EXPECT_GT(values.at<double>(5), -1e-15) << n;   // each part takes something off, in no direction does it add
        EXPECT_LT(trace(P)[0], smaller) << n;
        smaller = trace(P)[0];
        before = P;
    }
}

TEST(SurgTrack_EKF, aGrossOutlierIsGatedAndReported)
{
    const CameraModel camera = endoscope();
    const Mat points = keypointsOf(2);
    Mat image = seen(camera, Matx61d::zeros(), points), without, withoutImage, used;
    Ptr<ToolPoseEKF> filter = ToolPoseEKF::create(camera), clean = ToolPoseEKF::create(camera);
    for (int frame = 0; frame < 5; frame++)   // both are sure of their state
    {
        filter->correct(points, image);
        clean->correct(points, image);
    }
    const int wrong = 4;
    image.at<double>(wrong, 0) += 60;
    for (int i = 0; i < points.rows; i++)
        if (i != wrong) without.push_back(points.row(i)), withoutImage.push_back(image.row(i));
    ASSERT_TRUE(filter->correct(points, image, used));
    ASSERT_EQ(CV_8UC1, used.type());
    ASSERT_EQ(points.rows, int(used.total()));
    for (int i = 0; i < points.rows; i++) EXPECT_EQ(i == wrong ? 0 : 1, used.at<uchar>(i)) << i;
    ASSERT_TRUE(clean->correct(without, withoutImage));
    EXPECT_LT(cvtest::norm(clean->state(), filter->state(), NORM_INF), 1e-14);             // the same rows: rounding
    EXPECT_LT(cvtest::norm(clean->covariance(), filter->covariance(), NORM_INF), 1e-16);   // the same

    ToolPoseEKF::Params params;
    params.gate = 0;
    filter = ToolPoseEKF::create(camera, params);
    ASSERT_TRUE(filter->correct(points, image, used));
    EXPECT_EQ(points.rows, countNonZero(used));
}

TEST(SurgTrack_EKF, withoutAPointThatPassesNothingChanges)
{
    const CameraModel camera = endoscope();
    const Mat points = keypointsOf(3);
    Mat image = seen(camera, Matx61d::zeros(), points), used;
    Ptr<ToolPoseEKF> filter = ToolPoseEKF::create(camera);
    ASSERT_TRUE(filter->correct(points, image));
    const Mat state = filter->state(), P = filter->covariance();
    const double nis = filter->nis();
    image += Scalar::all(1000);
    EXPECT_FALSE(filter->correct(points, image, used));   // all gated
    EXPECT_EQ(points.rows, int(used.total()));
    EXPECT_EQ(0, countNonZero(used));
    EXPECT_FALSE(filter->correct(Mat(), Mat()));
    EXPECT_FALSE(filter->correct(-points, image, used));  // all behind the camera
    EXPECT_EQ(0, countNonZero(used));
    EXPECT_EQ(0, cvtest::norm(state, filter->state(), NORM_INF));
    EXPECT_EQ(0, cvtest::norm(P, filter->covariance(), NORM_INF));
    EXPECT_EQ(nis, filter->nis());
}

TEST(SurgTrack_EKF, pointsBehindTheCameraAreIgnored)
{
    const CameraModel camera = endoscope();
    const Matx61d truth = stateOf(0.01, 0.01, -0.01, 0.001, 0, 0.001);
    const Mat points = keypointsOf(4), image = seen(camera, truth, points);
    Mat more, moreImage, used;
    vconcat(points, Mat(-points.rowRange(0, 2)), more);
    vconcat(image, image.rowRange(0, 2), moreImage);
    Ptr<ToolPoseEKF> filter = ToolPoseEKF::create(camera), other = ToolPoseEKF::create(camera);
    ASSERT_TRUE(filter->correct(points, image));
    ASSERT_TRUE(other->correct(more, moreImage, used));
    EXPECT_EQ(points.rows, countNonZero(used));
    EXPECT_EQ(0, used.at<uchar>(points.rows));
    EXPECT_EQ(0, used.at<uchar>(points.rows + 1));
    EXPECT_EQ(0, cvtest::norm(filter->state(), other->state(), NORM_INF));
}

TEST(SurgTrack_EKF, imageCovarianceIsThatOfTheStateSeenThroughTheJacobian)
{
    const CameraModel camera = endoscope();
    const Mat points = keypointsOf(5), image = seen(camera, stateOf(0.02, 0, 0.01, 0, 0.002, 0.001), points);
    Ptr<ToolPoseEKF> filter = ToolPoseEKF::create(camera);
    for (int updates = 0; updates < 3; updates++)
    {
        Mat h, H;
        projectKeypoints(camera, filter->state(), points, h, H);
        for (int i = 0; i < points.rows; i++)
        {
            const Mat J = H.rowRange(2 * i, 2 * i + 2), expected = J * filter->covariance() * J.t();
            const Matx22d C = filter->imageCovariance(*points.ptr<Point3d>(i));
            EXPECT_LT(cvtest::norm(expected, Mat(C), NORM_INF), 1e-12 * cvtest::norm(expected, NORM_INF)) << i;   // rounding
        }
        filter->correct(points, image);
    }
}

TEST(SurgTrack_EKF, poseCovarianceIsThatOfSampledPoses)
{
    const CameraModel camera = endoscope();
    ToolPoseEKF::Params params;
    params.initialRotation = 1 * DEGREE;
    params.initialTranslation = 0.002;
    Ptr<ToolPoseEKF> filter = ToolPoseEKF::create(camera, params);
    filter->reset(correctionFromState(stateOf(0.2, -0.3, 0.4, 0.003, 0.002, -0.001)));   // far from zero: the axes of the angles differ
    const Matx61d x((double*)filter->state().ptr());
    const Mat points = keypointsOf(6);
    ASSERT_TRUE(filter->correct(points.rowRange(0, 2), seen(camera, x, points).rowRange(0, 2)));   // correlations
    const Mat state = filter->state(), P = filter->covariance();
    const Matx44d nominal_T_tool = rigid(rotationMatrix(Vec3d(0.5, -1, 0.3)), Point3d(0.01, -0.02, 0.11)), mean = filter->correction() * nominal_T_tool;

    RNG rng(8);
    const int samples = 20000;
    Mat_<double> C = Mat::zeros(6, 6, CV_64F);
    for (int i = 0; i < samples; i++)
    {
        const Mat_<double> e = rotationVectorAndTranslation(correctionFromState(state + gaussianSample(P, rng)) * nominal_T_tool, mean);
        C += e * e.t() / samples;
    }
    const Matx66d covariance = filter->poseCovariance(Point3d(0.01, -0.02, 0.11));
    for (int i = 0; i < 6; i++)
        for (int j = 0; j < 6; j++)
            // 20000 samples: a standard deviation of 1 %, four of which, and 1 % for what is not linear within a degree
            EXPECT_NEAR(covariance(i, j), C(i, j), 0.05 * std::sqrt(C(i, i) * C(j, j))) << i << " " << j;
}

TEST(SurgTrack_EKF, resetStartsAnew)
{
    const CameraModel camera = endoscope();
    const Mat points = keypointsOf(7);
    Ptr<ToolPoseEKF> filter = ToolPoseEKF::create(camera), fresh = ToolPoseEKF::create(camera);
    filter->predict();
    filter->correct(points, seen(camera, stateOf(0.01, 0, 0, 0, 0, 0.002), points));
    filter->reset(Matx44d::eye());
    EXPECT_EQ(0, cvtest::norm(fresh->state(), filter->state(), NORM_INF));
    EXPECT_EQ(0, cvtest::norm(fresh->covariance(), filter->covariance(), NORM_INF));
    EXPECT_EQ(0, filter->nis());
    const Matx44d T = wrongCalibration(0.1, 0.01, 3);
    filter->reset(T);
    EXPECT_LT(cv::norm(filter->correction() - T, NORM_INF), 1e-14);   // rounding
    EXPECT_EQ(0, cvtest::norm(fresh->covariance(), filter->covariance(), NORM_INF));
}

TEST(SurgTrack_EKF, rejectsBadInputNamingTheArgument)
{
    const CameraModel camera = endoscope();
    Ptr<ToolPoseEKF> filter = ToolPoseEKF::create(camera);
    const Mat points = keypointsOf(8), image = seen(camera, Matx61d::zeros(), points), state = filter->state(), P = filter->covariance();
    Mat bad = points.clone(), badImage = image.clone(), result;
    bad.at<double>(3, 1) = NOT_A_NUMBER;
    badImage.at<double>(2, 0) = std::numeric_limits<double>::infinity();
    EXPECT_ERROR(filter->correct(bad, image), "nominalPoints");
    EXPECT_ERROR(filter->correct(points, badImage), "imagePoints");
    EXPECT_ERROR(filter->correct(points, image.rowRange(0, 3)), "point");
    EXPECT_ERROR(filter->correct(image, image), "nominalPoints");
    EXPECT_EQ(0, cvtest::norm(state, filter->state(), NORM_INF));
    EXPECT_EQ(0, cvtest::norm(P, filter->covariance(), NORM_INF));

    Matx44d notRigid = Matx44d::eye();
    notRigid(0, 0) = 2;
    EXPECT_ERROR(filter->reset(notRigid), "camera_T_nominal");
    notRigid(0, 0) = NOT_A_NUMBER;
    EXPECT_ERROR(filter->reset(notRigid), "camera_T_nominal");
    EXPECT_ERROR(stateFromCorrection(notRigid, result), "camera_T_nominal");
    EXPECT_ERROR(projectKeypoints(camera, Mat::zeros(5, 1, CV_64F), points, result), "state");
    EXPECT_ERROR(projectKeypoints(camera, Mat(6, 1, CV_64F, Scalar(NOT_A_NUMBER)), points, result), "state");
    EXPECT_ERROR(correctionFromState(Mat::zeros(2, 6, CV_64F)), "state");
    EXPECT_THROW(ToolPoseEKF::create(CameraModel()), cv::Exception);
}

TEST(SurgTrack_EKF, movesWithTheCamera)
{
    const CameraModel camera = endoscope();
    const Mat points = keypointsOf(1);
    const Matx61d truth = stateOf(0.02, -0.03, 0.01, 0.002, 0.001, -0.003);
    Ptr<ToolPoseEKF> filter = ToolPoseEKF::create(camera);
    ASSERT_TRUE(filter->correct(points, seen(camera, truth, points)));
    const Point3d tool = *points.ptr<Point3d>(0);
    const Matx44d before = filter->correction(), now_T_before = rigid(rotationMatrix(Vec3d(0.1, -0.4, 0.2)), Point3d(0.03, -0.02, 0.04));
    const Matx66d P = filter->poseCovariance(tool);
    filter->changeFrames(now_T_before, now_T_before.inv());
    EXPECT_LT(cv::norm(filter->correction() - now_T_before * before * now_T_before.inv(), NORM_INF), 1e-12);   // rounding
    Matx66d turn = Matx66d::zeros();
    for (int i = 0; i < 9; i++) turn(i / 3, i % 3) = turn(3 + i / 3, 3 + i % 3) = now_T_before(i / 3, i % 3);
    const Matx66d expected = turn * P * turn.t(), moved = filter->poseCovariance(transformed(now_T_before, tool));
    EXPECT_LT(cv::norm(moved - expected, NORM_INF), 1e-6 * cv::norm(expected, NORM_INF));   // derivatives by differences
}

TEST(SurgTrack_EKF, rejectsBadParameters)
{
    const CameraModel camera = endoscope();
    const double values[] = {-1, NOT_A_NUMBER};
    double ToolPoseEKF::Params::* const members[] = {&ToolPoseEKF::Params::measurementNoise, &ToolPoseEKF::Params::initialRotation, &ToolPoseEKF::Params::initialTranslation,
                                                     &ToolPoseEKF::Params::processRotation, &ToolPoseEKF::Params::processTranslation, &ToolPoseEKF::Params::gate};
    const char* const names[] = {"measurementNoise", "initialRotation", "initialTranslation", "processRotation", "processTranslation", "gate"};
    for (int i = 0; i < 6; i++)
        for (double value : values)
        {
            if (i == 5 && value < 0) continue;   // no gate
            ToolPoseEKF::Params params;
            params.*members[i] = value;
            EXPECT_ERROR(ToolPoseEKF::create(camera, params), names[i]);
        }
    ToolPoseEKF::Params params;
    params.measurementNoise = 0;
    EXPECT_ERROR(ToolPoseEKF::create(camera, params), "measurementNoise");
}

TEST(SurgTrack_EPnP, recoversThePoseOfNoiseFreePoints)
{
    const CameraModel cameras[] = {endoscope(true), endoscope(false)};
    for (const CameraModel& camera : cameras)
        for (int seed = 1; seed <= 20; seed++)
        {
            const Matx44d truth = wrongCalibration(0.2, 0.01, seed);
            Mat state;
            stateFromCorrection(truth, state);
            const Mat points = keypointsOf(seed), image = seen(camera, Matx61d((double*)state.ptr()), points);
            Matx44d T;
            ASSERT_TRUE(solveEPnP(camera, points, image, T)) << seed;
            // OpenCV undistorts the points by fixed-point steps. Measured: 9e-8 rad and 2.5e-8 m at most.
            EXPECT_LT(rotationAngle(T, truth), 1e-6) << seed;
            EXPECT_LT(distance(T * rigid(Matx33d::eye(), Point3d(0, 0, 0.1)), truth * rigid(Matx33d::eye(), Point3d(0, 0, 0.1))), 1e-6) << seed;

            // With outliers, by RANSAC.
            Mat spoilt = image.clone();
            spoilt.at<double>(1, 0) += 80;
            spoilt.at<double>(6, 1) -= 120;
            Matx44d robust;
            ASSERT_TRUE(solveEPnP(camera, points, spoilt, robust, 3)) << seed;
            EXPECT_LT(distance(robust * rigid(Matx33d::eye(), Point3d(0, 0, 0.1)), truth * rigid(Matx33d::eye(), Point3d(0, 0, 0.1))), 1e-3) << seed;   // from the inliers alone
        }
}

TEST(SurgTrack_EPnP, fewerThanFourPointsGiveNothing)
{
    const CameraModel camera = endoscope();
    const Mat points = keypointsOf(0), image = seen(camera, Matx61d::zeros(), points);
    for (int n = 0; n < 4; n++)
        for (int ransac = 0; ransac < 2; ransac++)
        {
            Matx44d T = Matx44d::all(7);
            EXPECT_FALSE(solveEPnP(camera, points.rowRange(0, n), image.rowRange(0, n), T, ransac * 3.)) << n;
            EXPECT_EQ(0, cv::norm(T - Matx44d::all(7), NORM_INF));
        }
    Matx44d T;
    EXPECT_TRUE(solveEPnP(camera, points.rowRange(0, 4), image.rowRange(0, 4), T));
}

TEST(SurgTrack_EPnP, degeneratePointsGiveNothingOrAFinitePose)
{
    const CameraModel camera = endoscope();
    Mat_<double> line(8, 3), same(8, 3), plane(8, 3);
    RNG rng(9);
    for (int i = 0; i < 8; i++)
    {
        line.row(i) = Mat(Matx13d(0.002 * i, 0.001 * i, 0.1 + 0.001 * i)) + 0;
        same.row(i) = Mat(Matx13d(0.01, 0.01, 0.1)) + 0;
        plane.row(i) = Mat(Matx13d(rng.uniform(-0.01, 0.01), rng.uniform(-0.01, 0.01), 0.1)) + 0;
    }
    const Mat sets[] = {line, same, plane};
    for (int i = 0; i < 3; i++)
        for (int ransac = 0; ransac < 2; ransac++)
        {
            Matx44d T = Matx44d::all(7);
            bool found = false;
            ASSERT_NO_THROW(found = solveEPnP(camera, sets[i], seen(camera, Matx61d::zeros(), sets[i]), T, ransac * 3.)) << i;
            EXPECT_TRUE(checkRange(T)) << i;
            EXPECT_EQ(!found, cv::norm(T - Matx44d::all(7), NORM_INF) == 0) << i;
            if (i == 2)
            {
                EXPECT_TRUE(found);
                EXPECT_LT(rotationAngle(T, Matx44d::eye()), 0.01);   // a plane is enough; undistortion as above
            }
        }
}

TEST(SurgTrack_EPnP, rejectsBadInputNamingTheArgument)
{
    const CameraModel camera = endoscope();
    const Mat points = keypointsOf(0), image = seen(camera, Matx61d::zeros(), points);
    Mat bad = points.clone(), badImage = image.clone();
    bad.at<double>(0, 0) = NOT_A_NUMBER;
    badImage.at<double>(0, 0) = NOT_A_NUMBER;
    Matx44d T;
    EXPECT_ERROR(solveEPnP(camera, bad, image, T), "nominalPoints");
    EXPECT_ERROR(solveEPnP(camera, points, badImage, T), "imagePoints");
    EXPECT_ERROR(solveEPnP(camera, points, image.rowRange(0, 5), T), "point");
    EXPECT_ERROR(solveEPnP(camera, image, image, T), "nominalPoints");
}

}} // namespace
