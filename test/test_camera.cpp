// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_common.hpp"

namespace opencv_test { namespace {

const Matx33d K(854.7, 0, 331.2, 0, 935.1, 270.4, 0, 0, 1);
const Size IMAGE(720, 576);

// The first n of twelve coefficients, all of them at work.
Mat coefficients(int n, double k1 = -0.2334)
{
    const double all[12] = {k1, 0.148, -0.0058, 0.001, -0.05, 0.08, -0.06, 0.02, 0.003, -0.002, -0.004, 0.001};
    return Mat(1, n, CV_64F, const_cast<double*>(all)).clone();
}

// Points all over the image, at depths of 4 cm to 25 cm.
std::vector<Point3d> scatteredPoints(int n)
{
    RNG rng(11);
    std::vector<Point3d> points(n);
    for (int i = 0; i < n; i++)
    {
        const double z = rng.uniform(0.04, 0.25);
        points[i] = Point3d(rng.uniform(-0.42, 0.48) * z, rng.uniform(-0.3, 0.34) * z, z);
    }
    return points;
}

TEST(SurgTrack_Camera, projectsAsCalib3dForEveryNumberOfCoefficients)
{
    const std::vector<Point3d> points = scatteredPoints(500);
    const int counts[] = {0, 4, 5, 8, 12};
    for (int n : counts)
    {
        const Mat D = n ? coefficients(n) : Mat();
        const CameraModel camera(K, D, IMAGE);
        std::vector<Point2d> expected;
        cv::projectPoints(points, Vec3d(), Vec3d(), K, D, expected);
        Mat image;
        camera.projectPoints(points, image);
        ASSERT_EQ(CV_64FC2, image.type());
        ASSERT_EQ(Size(1, 500), image.size());
        for (int i = 0; i < 500; i++)
        {
            const Point2d single = camera.project(points[i]);
            ASSERT_EQ(single, image.at<Point2d>(i)) << n << " coefficients, point " << i;
            ASSERT_LT(cv::norm(single - expected[i]), 1e-9) << n << " coefficients, point " << i;   // rounding of the same formula, in pixels of up to 1e3
        }
    }
}

TEST(SurgTrack_Camera, acceptsPointsInEveryShape)
{
    const CameraModel camera(K, coefficients(5), IMAGE);
    const std::vector<Point3d> points = scatteredPoints(7);
    Mat expected, result;
    camera.projectPoints(points, expected);

    camera.projectPoints(Mat(points).reshape(1, 7), result);                       // N x 3
    EXPECT_EQ(0, cvtest::norm(expected, result, NORM_INF));
    camera.projectPoints(Mat(points).reshape(3, 1), result);                    // 1 x N, 3 channels
    EXPECT_EQ(0, cvtest::norm(expected, result, NORM_INF));
    Mat wide(7, 5, CV_64F, Scalar(-1)), inner = wide.colRange(1, 4);
    Mat(points).reshape(1, 7).copyTo(inner);
    camera.projectPoints(inner, result);                                        // with a stride
    EXPECT_EQ(0, cvtest::norm(expected, result, NORM_INF));
    camera.projectPoints(std::vector<Point3f>(points.begin(), points.end()), result);
    EXPECT_LT(cvtest::norm(expected, result, NORM_INF), 1e-3);                  // 24-bit points: 6e-8 of 1e3 pixels, times a few
    camera.projectPoints(Mat(), result);
    EXPECT_TRUE(result.empty());
}

TEST(SurgTrack_Camera, pointsNotInFrontOfTheCameraProjectToNaN)
{
    const CameraModel camera(K, coefficients(5), IMAGE);
    const Point3d points[] = {Point3d(0.01, 0, 0.1), Point3d(0.01, 0, 0), Point3d(0.01, 0, -0.1)};
    Mat_<Point2d> image;
    camera.projectPoints(Mat(3, 3, CV_64F, (void*)points), image);
    EXPECT_TRUE(checkRange(Mat(image.row(0)).reshape(1)));
    for (int i = 1; i < 3; i++)
    {
        EXPECT_TRUE(cvIsNaN(image(i).x)) << i;
        EXPECT_TRUE(cvIsNaN(image(i).y)) << i;
    }
}

TEST(SurgTrack_Camera, jacobianEqualsCentralDifferences)
{
    const double step = 1e-6;   // [m]
    const int counts[] = {0, 5, 8, 12};
    for (int n : counts)
    {
        const CameraModel camera(K, n ? coefficients(n) : Mat(), IMAGE);
        for (const Point3d& p : scatteredPoints(200))
        {
            Matx23d J;
            EXPECT_EQ(camera.project(p), camera.project(p, &J));
            for (int axis = 0; axis < 3; axis++)
            {
                Point3d plus = p, minus = p;
                (&plus.x)[axis] += step;
                (&minus.x)[axis] -= step;
                const Point2d d = (camera.project(plus) - camera.project(minus)) * (0.5 / step);
                const double tolerance = 1e-4;   // third derivatives of up to 1e8 pixel/m^3 times step^2 / 6, and 1e-13 pixel / step of rounding
                ASSERT_NEAR(d.x, J(0, axis), tolerance) << n << " coefficients, axis " << axis << ", " << p;
                ASSERT_NEAR(d.y, J(1, axis), tolerance) << n << " coefficients, axis " << axis << ", " << p;
            }
        }
    }
}

TEST(SurgTrack_Camera, unprojectInvertsProjectAllOverTheImage)
{
    const double firsts[] = {-0.2334, 0.1};
    const int counts[] = {0, 4, 5, 8, 12};
    for (int n : counts)
        for (double k1 : firsts)
        {
            const CameraModel camera(K, n ? coefficients(n, k1) : Mat(), IMAGE);
            std::vector<Point2d> pixels;
            for (double y = -0.5; y <= IMAGE.height; y += 14.4)
                for (double x = -0.5; x <= IMAGE.width; x += 14.4) pixels.push_back(Point2d(x, y));
            Mat_<Point2d> rays;
            camera.unprojectPoints(pixels, rays);
            ASSERT_EQ(int(pixels.size()), rays.rows);
            for (int i = 0; i < rays.rows; i++)
            {
                const Point2d back = camera.project(Point3d(rays(i).x, rays(i).y, 1));
                ASSERT_LT(cv::norm(back - pixels[i]), 1e-8) << n << " coefficients, " << pixels[i];   // Newton ends below 1e-12 in the ray: 1e-9 pixel
            }
        }
}

TEST(SurgTrack_Camera, fieldOfViewHoldsTheRaysOfTheWindowAndLittleMore)
{
    const Rect windows[] = {Rect(0, 0, 720, 576), Rect(0, 0, 1, 1), Rect(719, 575, 1, 1), Rect(300, 200, 97, 61), Rect(0, 500, 720, 76), Rect(613, 3, 90, 540)};
    const double firsts[] = {0, -0.2334, 0.15};
    for (double k1 : firsts)
        for (const Rect& w : windows)
        {
            const CameraModel camera(K, k1 != 0 ? coefficients(5, k1) : Mat(), IMAGE);
            const Rect2d field = camera.fieldOfView(w);
            std::vector<Point2d> border;   // of the window's pixels; the extremes of a continuous map of the window are on it
            for (int i = 0; i <= 100; i++)
            {
                const double x = w.x - 0.5 + w.width * i / 100., y = w.y - 0.5 + w.height * i / 100.;
                border.push_back(Point2d(x, w.y - 0.5));
                border.push_back(Point2d(x, w.y + w.height - 0.5));
                border.push_back(Point2d(w.x - 0.5, y));
                border.push_back(Point2d(w.x + w.width - 0.5, y));
            }
            Mat_<Point2d> rays;
            camera.unprojectPoints(border, rays);
            double xmin = DBL_MAX, xmax = -DBL_MAX, ymin = DBL_MAX, ymax = -DBL_MAX;
            for (int i = 0; i < rays.rows; i++)
            {
                xmin = std::min(xmin, rays(i).x); xmax = std::max(xmax, rays(i).x);
                ymin = std::min(ymin, rays(i).y); ymax = std::max(ymax, rays(i).y);
            }
            const double pixel = 1 / K(0, 0);
            const double inside = 1e-3 * pixel;   // a thousandth of a pixel: nobody misses what is outside
            const double more = pixel;            // clipping may be generous by a pixel
            EXPECT_LE(field.x, xmin + inside) << k1 << " " << w;
            EXPECT_LE(field.y, ymin + inside) << k1 << " " << w;
            EXPECT_GE(field.br().x, xmax - inside) << k1 << " " << w;
            EXPECT_GE(field.br().y, ymax - inside) << k1 << " " << w;
            EXPECT_GE(field.x, xmin - more) << k1 << " " << w;
            EXPECT_GE(field.y, ymin - more) << k1 << " " << w;
            EXPECT_LE(field.br().x, xmax + more) << k1 << " " << w;
            EXPECT_LE(field.br().y, ymax + more) << k1 << " " << w;
        }
}

TEST(SurgTrack_Camera, givesBackWhatItWasMadeOf)
{
    const CameraModel camera(Mat_<float>(Mat(K)), coefficients(8).t(), IMAGE);
    EXPECT_LT(cvtest::norm(Mat(camera.cameraMatrix()), Mat(K), NORM_INF), 1e-4);   // through 32-bit floats
    EXPECT_EQ(IMAGE, camera.imageSize());
    EXPECT_TRUE(camera.hasDistortion());
    const Mat D = camera.distCoeffs();
    ASSERT_EQ(Size(12, 1), D.size());
    EXPECT_EQ(0, cvtest::norm(D.colRange(0, 8), coefficients(8), NORM_INF));
    EXPECT_EQ(0, countNonZero(D.colRange(8, 12)));
    EXPECT_FALSE(CameraModel(K, Mat::zeros(1, 5, CV_64F), IMAGE).hasDistortion());
    EXPECT_EQ(Size(), CameraModel().imageSize());
}

TEST(SurgTrack_Camera, acceptsCoefficientsThatAreAColumnOfAMatrix)
{
    Mat_<double> table(5, 3, 0.);
    coefficients(5).reshape(1, 5).copyTo(table.col(1));
    const CameraModel camera(K, table.col(1), IMAGE);
    EXPECT_EQ(0, cvtest::norm(camera.distCoeffs().colRange(0, 5), coefficients(5), NORM_INF));
}

TEST(SurgTrack_Camera, rejectsBadInputNamingTheArgument)
{
    const Mat none;
    EXPECT_ERROR(CameraModel(Mat::eye(3, 4, CV_64F), none, IMAGE), "cameraMatrix");
    EXPECT_ERROR(CameraModel(Mat(), none, IMAGE), "cameraMatrix");
    EXPECT_ERROR(CameraModel(Mat::eye(3, 3, CV_32S), none, IMAGE), "cameraMatrix");
    const double bad[][3] = {{0, 0, -800}, {1, 1, -800}, {0, 0, 0}, {1, 1, 0}, {0, 1, 1}, {2, 2, 2}, {2, 0, 1}, {1, 0, 0.1},
                             {0, 0, NOT_A_NUMBER}, {1, 2, NOT_A_NUMBER}, {0, 2, std::numeric_limits<double>::infinity()}};
    for (const double* b : bad)
    {
        Matx33d M = K;
        M(int(b[0]), int(b[1])) = b[2];
        EXPECT_ERROR(CameraModel(M, none, IMAGE), "cameraMatrix");
    }
    const int counts[] = {1, 2, 3, 6, 7, 9, 11};
    for (int n : counts) EXPECT_ERROR(CameraModel(K, coefficients(n), IMAGE), "distCoeffs");
    EXPECT_ERROR(CameraModel(K, Mat::zeros(2, 4, CV_64F), IMAGE), "distCoeffs");
    EXPECT_ERROR(CameraModel(K, Mat::zeros(1, 14, CV_64F), IMAGE), "distCoeffs");
    Mat D = coefficients(5);
    D.at<double>(3) = NOT_A_NUMBER;
    EXPECT_ERROR(CameraModel(K, D, IMAGE), "distCoeffs");
    EXPECT_ERROR(CameraModel(K, none, Size(0, 576)), "imageSize");
    EXPECT_ERROR(CameraModel(K, none, Size(720, -1)), "imageSize");

    const CameraModel camera(K, none, IMAGE);
    Mat result;
    EXPECT_ERROR(camera.projectPoints(Mat::ones(4, 2, CV_64F), result), "viewPoints");
    EXPECT_ERROR(camera.projectPoints(Mat::ones(4, 3, CV_32S), result), "viewPoints");
    EXPECT_ERROR(camera.projectPoints(Mat(4, 3, CV_64F, Scalar(NOT_A_NUMBER)), result), "viewPoints");
    EXPECT_ERROR(camera.unprojectPoints(Mat::ones(4, 3, CV_64F), result), "imagePoints");
    EXPECT_ERROR(camera.unprojectPoints(Mat(1, 4, CV_64FC2, Scalar(1, NOT_A_NUMBER)), result), "imagePoints");
}

}} // namespace
