// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_common.hpp"

#include <cstdio>
#include <fstream>
#include <limits>
#include "opencv2/core/utils/filesystem.hpp"

namespace opencv_test { namespace {

const double degree = CV_PI / 180;

// A recording of robot and board with known truth. The board is 0.1 m in front of the camera, tilted and rolled.
struct Recording
{
    std::vector<Matx44d> robot, board;
    Matx44d camera_T_mount, holder_T_board;

    /* tilt: how far the board turns about axes in the image [rad], roll: about the viewing axis
       noise: standard deviation of the board's poses, per axis: [m] and [rad] */
    Recording(uint64 seed, int setup, int poses, double shiftNoise = 0, double angleNoise = 0, double tilt = 30 * degree, double roll = 50 * degree)
    {
        RNG rng(seed);
        camera_T_mount = rigid(rotationMatrix(randomDirection(rng) * rng.uniform(0., 3.)), Point3d(0.05, -0.08, 0.03));
        holder_T_board = rigid(rotationMatrix(randomDirection(rng) * rng.uniform(0., 3.)), Point3d(0.004, 0.002, 0.01));
        for (int i = 0; i < poses; i++)
        {
            const double direction = rng.uniform(-CV_PI, CV_PI), angle = tilt * std::sqrt(rng.uniform(0., 1.));
            const Matx33d R = rotationMatrix(Vec3d(std::cos(direction), std::sin(direction), 0) * angle) * rotationMatrix(Vec3d(0, 0, rng.uniform(-roll, roll)));
            const Matx44d T = rigid(R, Point3d(rng.uniform(-0.02, 0.02), rng.uniform(-0.015, 0.015), rng.uniform(0.08, 0.12)));
            const Matx44d M = camera_T_mount.inv() * T * holder_T_board.inv();
            robot.push_back(setup == HAND_EYE_BOARD_ON_TOOL ? M : Matx44d(M.inv()));
            board.push_back(disturbed(T, rng, shiftNoise, angleNoise));
        }
    }

    static Matx44d disturbed(const Matx44d& T, RNG& rng, double shift, double angle)
    {
        const Matx44d turn = rigid(rotationMatrix(Vec3d(rng.gaussian(1), rng.gaussian(1), rng.gaussian(1)) * angle), Point3d());
        const Vec3d d = Vec3d(rng.gaussian(1), rng.gaussian(1), rng.gaussian(1)) * shift;
        Matx44d result = T * turn;    // about the board's own origin
        for (int i = 0; i < 3; i++) result(i, 3) += d[i];
        return result;
    }

    // Error of a calibration where the board is, as spreadTranslation has it [m].
    double errorAtBoard(const Matx44d& estimate) const
    {
        Point3d place;
        for (size_t i = 0; i < board.size(); i++) place += transformed(board[i], Point3d()) * (1. / board.size());
        const Point3d mountPlace = transformed(camera_T_mount.inv(), place);
        return cv::norm(transformed(estimate, mountPlace) - transformed(camera_T_mount, mountPlace));
    }
};

HandEyeParams paramsFor(int setup, int method = HAND_EYE_BEST)
{
    HandEyeParams params;
    params.setup = setup;
    params.method = method;
    return params;
}

Mat rowsOf(const std::vector<Matx44d>& poses)
{
    Mat rows((int)poses.size(), 16, CV_64F);
    for (size_t i = 0; i < poses.size(); i++) std::copy(poses[i].val, poses[i].val + 16, rows.ptr<double>((int)i));
    return rows;
}

bool mentions(const std::vector<String>& warnings, const char* what)
{
    for (size_t i = 0; i < warnings.size(); i++)
        if (warnings[i].find(what) != String::npos) return true;
    return false;
}

TEST(SurgTrack_HandEye, everyMethodIsExactWithoutNoise)
{
    for (int setup = 0; setup < 2; setup++)
    {
        const Recording r(1, setup, 12);
        HandEyeResult result;
        ASSERT_TRUE(estimateHandEye(r.robot, r.board, result, paramsFor(setup))) << result.reason;
        ASSERT_EQ(HAND_EYE_REFINED + 1, (int)result.fits.size());
        EXPECT_TRUE(result.rejected.empty());
        EXPECT_TRUE(result.warnings.empty()) << result.warnings[0];
        for (int method = 0; method <= HAND_EYE_REFINED; method++)
        {
            const HandEyeFit& fit = result.fits[method];
            SCOPED_TRACE(handEyeMethodName(method));
            ASSERT_TRUE(fit.valid);
            EXPECT_EQ(method, fit.method);
            EXPECT_LT(cv::norm(fit.camera_T_mount - r.camera_T_mount, NORM_INF), 1e-9);    // rounding, through least squares
            EXPECT_LT(cv::norm(fit.holder_T_board - r.holder_T_board, NORM_INF), 1e-9);    // the same
            EXPECT_LT(fit.leftOutTranslation, 1e-9);                                       // the same
        }
    }
}

// Twenty poses in a cone of 30 degrees: a standard deviation of 0.26 rad about each axis in the image, of 0.5 rad about the viewing axis.
// The rotations of mount and holder are told apart by these turns, so their errors are about those of a pose, by sqrt(20) and by 0.26.
TEST(SurgTrack_HandEye, everyMethodIsAsGoodAsTheNoiseAllows)
{
    const int poses = 20, runs = 4;
    const double shift = 0.0003, angle = 0.3 * degree;    // per axis; a small board and a robot of fair accuracy
    const double rotationBound = std::sqrt(3.) * angle / std::sqrt((double)poses) / 0.26;                    // 0.45 degrees
    const double translationBound = std::sqrt(3.) * (shift + 0.1 * angle) / std::sqrt((double)poses) / 0.26;   // 0.1 m: from mount to board; 1.2 mm
    for (int setup = 0; setup < 2; setup++)
    {
        std::vector<double> shifts(HAND_EYE_REFINED + 1, 0.), angles(HAND_EYE_REFINED + 1, 0.);
        for (int run = 0; run < runs; run++)
        {
            const Recording r(100 + run, setup, poses, shift, angle);
            HandEyeResult result;
            ASSERT_TRUE(estimateHandEye(r.robot, r.board, result, paramsFor(setup)));
            EXPECT_TRUE(result.rejected.empty()) << "nothing but normal noise";
            for (int method = 0; method <= HAND_EYE_REFINED; method++)
            {
                ASSERT_TRUE(result.fits[method].valid);
                shifts[method] += std::pow(r.errorAtBoard(result.fits[method].camera_T_mount), 2) / runs;
                angles[method] += std::pow(rotationAngle(result.fits[method].camera_T_mount, r.camera_T_mount), 2) / runs;
            }
        }
        for (int method = 0; method <= HAND_EYE_REFINED; method++)
        {
            EXPECT_LT(std::sqrt(shifts[method]), translationBound) << handEyeMethodName(method);
            EXPECT_LT(std::sqrt(angles[method]), rotationBound) << handEyeMethodName(method);
            EXPECT_LE(shifts[HAND_EYE_REFINED], shifts[method] * 1.21) << handEyeMethodName(method);   // 10 %: four runs tell no less
        }
    }
}

TEST(SurgTrack_HandEye, theSpreadIsTheErrorOfTheCalibration)
{
    double errors = 0, angles = 0, spreads = 0, angleSpreads = 0;
    for (int run = 0; run < 12; run++)
    {
        const Recording r(200 + run, HAND_EYE_BOARD_ON_TOOL, 10, 0.0003, 0.3 * degree);
        HandEyeResult result;
        ASSERT_TRUE(estimateHandEye(r.robot, r.board, result));
        errors += std::pow(r.errorAtBoard(result.best.camera_T_mount), 2);
        angles += std::pow(rotationAngle(result.best.camera_T_mount, r.camera_T_mount), 2);
        spreads += std::pow(result.best.spreadTranslation, 2);
        angleSpreads += std::pow(result.best.spreadRotation, 2);
    }
    // Variances of three components in twelve runs are known within 24 %; the jackknife's own are not better.
    EXPECT_NEAR(1, std::sqrt(spreads / errors), 0.5);
    EXPECT_NEAR(1, std::sqrt(angleSpreads / angles), 0.5);
}

TEST(SurgTrack_HandEye, leftOutErrorsAreThoseOfThePosesAndOfTheCalibration)
{
    const double shift = 0.0003, angle = 0.3 * degree;
    const Recording r(7, HAND_EYE_BOARD_ON_TOOL, 40, shift, angle);
    HandEyeResult result;
    ASSERT_TRUE(estimateHandEye(r.robot, r.board, result));
    const HandEyeFit& best = result.best;
    EXPECT_LT(best.translation, best.leftOutTranslation);
    EXPECT_LT(best.rotation, best.leftOutRotation);
    // Three components each; 15 %: of a deviation from 120 numbers (6 %), twice, and of the calibration's own error.
    EXPECT_NEAR(1, best.leftOutTranslation / (std::sqrt(3.) * shift), 0.15);
    EXPECT_NEAR(1, best.leftOutRotation / (std::sqrt(3.) * angle), 0.15);
    ASSERT_EQ(40, result.residuals.rows);
    EXPECT_NEAR(best.translation, std::sqrt(result.residuals.col(0).dot(result.residuals.col(0)) / 40), 1e-12);   // rounding
    EXPECT_EQ(0, best.pixels) << "without a camera";
}

TEST(SurgTrack_HandEye, errorsInPixelsAreThoseOfTheBoardsPoints)
{
    Recording r(8, HAND_EYE_BOARD_ON_TOOL, 12);
    const CameraModel camera = endoscope();
    Mat points;
    getBoardPoints(CalibrationBoard(), points);
    HandEyeParams params;
    params.rejection = 0;
    r.board[3](0, 3) += 0.001;
    HandEyeResult result;
    ASSERT_TRUE(estimateHandEye(r.robot, r.board, result, params, camera, points));
    Mat there, seen;
    Matx44d predicted = result.best.camera_T_mount * r.robot[3] * result.best.holder_T_board;
    std::vector<Point3d> a, b;
    for (int i = 0; i < points.rows; i++)
    {
        a.push_back(transformed(predicted, *points.ptr<Point3d>(i)));
        b.push_back(transformed(r.board[3], *points.ptr<Point3d>(i)));
    }
    camera.projectPoints(a, there);
    camera.projectPoints(b, seen);
    EXPECT_NEAR(cv::norm(there, seen) / std::sqrt((double)points.rows), result.residuals.at<double>(3, 2), 1e-9);   // rounding
    EXPECT_GT(result.residuals.at<double>(3, 2), 3.);    // most of the millimetre, which is 7 to 11 pixels
}

TEST(SurgTrack_HandEye, posesThatDoNotFitAreThrownOutAndNamed)
{
    for (int run = 0; run < 4; run++)
    {
        Recording r(300 + run, run % 2, 20, 0.0002, 0.2 * degree);
        const double truth = r.errorAtBoard(r.camera_T_mount);
        ASSERT_LT(truth, 1e-12);    // rounding
        RNG rng(run);
        std::swap(r.robot[2], r.robot[9]);                             // pairs mixed up
        r.board[5](2, 3) += 0.003;                                     // 15 deviations in depth
        r.board[12] = r.board[12] * rigid(rotationMatrix(Vec3d(0.07, 0, 0)), Point3d());    // 20 deviations of tilt
        r.robot[17] = Recording::disturbed(r.robot[17], rng, 0.03, 0.5);                   // anything
        HandEyeResult result;
        ASSERT_TRUE(estimateHandEye(r.robot, r.board, result, paramsFor(run % 2)));
        const int wrong[] = { 2, 5, 9, 12, 17 };
        EXPECT_EQ(std::vector<int>(wrong, wrong + 5), result.rejected);
        EXPECT_LT(r.errorAtBoard(result.best.camera_T_mount), 0.001);    // bound of the noise test, by 2 / 3 for the noise and sqrt(20 / 15)
    }
}

TEST(SurgTrack_HandEye, nearlyHalfOfThePosesMayBeWrong)
{
    Recording r(31, HAND_EYE_BOARD_ON_TOOL, 20, 0.0002, 0.2 * degree);
    RNG rng(5);
    std::vector<int> wrong;
    for (int i = 0; i < 8; i++)
    {
        wrong.push_back(2 * i + 1);
        r.board[2 * i + 1] = Recording::disturbed(r.board[2 * i + 1], rng, 0.02, 0.3);
    }
    HandEyeResult result;
    ASSERT_TRUE(estimateHandEye(r.robot, r.board, result));
    EXPECT_EQ(wrong, result.rejected);
    EXPECT_TRUE(mentions(result.warnings, "8 of 20 poses were thrown out"));
}

TEST(SurgTrack_HandEye, goodPosesAreHardlyEverThrownOut)
{
    int thrownOut = 0, poses = 0;
    for (int run = 0; run < 12; run++)
    {
        const Recording r(400 + run, HAND_EYE_BOARD_ON_TOOL, 6 + run, 0.0003, 0.3 * degree);
        HandEyeResult result;
        ASSERT_TRUE(estimateHandEye(r.robot, r.board, result));
        thrownOut += (int)result.rejected.size();
        poses += 6 + run;
    }
    EXPECT_LE(thrownOut, poses / 100) << "of " << poses;    // deviations from few poses are uncertain; from many it would be one in a billion
}

TEST(SurgTrack_HandEye, theBestIsThatWithTheSmallestLeftOutErrorAndAnyCanBeChosen)
{
    const Recording r(9, HAND_EYE_BOARD_ON_TOOL, 12, 0.0003, 0.3 * degree);
    HandEyeResult best;
    ASSERT_TRUE(estimateHandEye(r.robot, r.board, best));
    for (int method = 0; method <= HAND_EYE_REFINED; method++)
    {
        HandEyeResult chosen;
        ASSERT_TRUE(estimateHandEye(r.robot, r.board, chosen, paramsFor(HAND_EYE_BOARD_ON_TOOL, method)));
        EXPECT_EQ(method, chosen.best.method);
        EXPECT_EQ(best.fits[method].camera_T_mount, chosen.best.camera_T_mount);
        // The errors are weighted; a method that is better in both is better.
        EXPECT_FALSE(best.fits[method].leftOutTranslation < 0.99 * best.best.leftOutTranslation
                     && best.fits[method].leftOutRotation < 0.99 * best.best.leftOutRotation) << handEyeMethodName(method);
    }
}

TEST(SurgTrack_HandEye, tooLittleMotionIsSaid)
{
    HandEyeResult result;
    const double shift = 0.0002, angle = 0.2 * degree;
    ASSERT_TRUE(estimateHandEye(Recording(1, 0, 14, shift, angle).robot, Recording(1, 0, 14, shift, angle).board, result));
    EXPECT_TRUE(result.warnings.empty()) << result.warnings[0];

    const Recording few(2, 0, 5, shift, angle);
    ASSERT_TRUE(estimateHandEye(few.robot, few.board, result));
    EXPECT_TRUE(mentions(result.warnings, "few poses: 5"));

    const Recording small(3, 0, 14, shift, angle, 8 * degree, 8 * degree);
    ASSERT_TRUE(estimateHandEye(small.robot, small.board, result));
    EXPECT_TRUE(mentions(result.warnings, "small rotations"));
    EXPECT_LT(result.largestRotation, 30 * degree);

    const Recording parallel(4, 0, 14, shift, angle, 2 * degree, 60 * degree);
    ASSERT_TRUE(estimateHandEye(parallel.robot, parallel.board, result));
    EXPECT_TRUE(mentions(result.warnings, "nearly parallel rotation axes"));
    EXPECT_FALSE(mentions(result.warnings, "uncertain"));

    const Recording noisy(4, 0, 14, 5 * shift, 5 * angle, 4 * degree, 60 * degree);
    ASSERT_TRUE(estimateHandEye(noisy.robot, noisy.board, result));
    EXPECT_TRUE(mentions(result.warnings, "uncertain"));

    const Recording one(5, 0, 14, shift, angle, 0.1 * degree, 60 * degree);
    EXPECT_FALSE(estimateHandEye(one.robot, one.board, result));
    EXPECT_NE(String::npos, result.reason.find("one axis only")) << result.reason;

    const Recording still(6, 0, 14, shift, angle, 0, 0);
    EXPECT_FALSE(estimateHandEye(still.robot, still.board, result));
    EXPECT_FALSE(result.reason.empty());
}

TEST(SurgTrack_HandEye, theOtherSetUpIsNoticed)
{
    const Recording r(11, HAND_EYE_CAMERA_ON_ARM, 14, 0.0002, 0.2 * degree);
    HandEyeResult result;
    EXPECT_TRUE(estimateHandEye(r.robot, r.board, result, paramsFor(HAND_EYE_BOARD_ON_TOOL)));
    EXPECT_TRUE(mentions(result.warnings, "poses that do not fit"));
}

TEST(SurgTrack_HandEye, theSameInputHasTheSameResultInAnyLayout)
{
    const Recording r(10, HAND_EYE_BOARD_ON_TOOL, 12, 0.0003, 0.3 * degree);
    HandEyeResult a, b, c;
    ASSERT_TRUE(estimateHandEye(r.robot, r.board, a));
    ASSERT_TRUE(estimateHandEye(rowsOf(r.robot), rowsOf(r.board), b));
    ASSERT_TRUE(estimateHandEye(rowsOf(r.robot).reshape(4, 48), rowsOf(r.board).reshape(4, 48), c));    // as N x 4 x 4 comes from Python
    EXPECT_EQ(a.best.camera_T_mount, b.best.camera_T_mount);
    EXPECT_EQ(a.best.camera_T_mount, c.best.camera_T_mount);
    EXPECT_EQ(a.best.spreadTranslation, c.best.spreadTranslation);
}

TEST(SurgTrack_HandEye, aWrongCallIsRefused)
{
    const Recording r(12, HAND_EYE_BOARD_ON_TOOL, 8);
    HandEyeResult result;
    std::vector<Matx44d> robot = r.robot, three(robot.begin(), robot.begin() + 3);
    EXPECT_ERROR(estimateHandEye(three, three, result), "robotPoses: 3 poses, expected at least 4");
    EXPECT_ERROR(estimateHandEye(three, r.board, result), "robotPoses and boardPoses");
    EXPECT_ERROR(estimateHandEye(Mat::eye(4, 3, CV_64F), r.board, result), "robotPoses must be N x 4 x 4");
    robot[6](1, 1) = std::numeric_limits<double>::quiet_NaN();
    EXPECT_ERROR(estimateHandEye(robot, r.board, result), "robotPoses: pose 6 is not rigid");
    robot[6] = Matx44d::eye() * 2.;
    EXPECT_ERROR(estimateHandEye(robot, r.board, result), "robotPoses: pose 6 is not rigid");
    std::vector<Matx44d> behind = r.board;
    behind[1](2, 3) = -0.1;
    EXPECT_ERROR(estimateHandEye(r.robot, behind, result, HandEyeParams(), endoscope()), "boardPoses: pose 1 has a point of the board behind the camera");
    EXPECT_ERROR(estimateHandEye(r.robot, r.board, result, paramsFor(2)), "params.setup");
    EXPECT_ERROR(estimateHandEye(r.robot, r.board, result, paramsFor(0, 8)), "params.method");
    EXPECT_ERROR(handEyeMethodName(8), "method");
    const std::vector<Matx44d> many(201, Matx44d::eye());
    EXPECT_ERROR(estimateHandEye(many, many, result), "expected at most 200");
}

// A board as the camera sees it: where the ray of each pixel meets it. Four samples a pixel.
Mat photograph(const CameraModel& camera, const CalibrationBoard& board, const Matx44d& camera_T_board)
{
    Mat points;
    getBoardPoints(board, points);
    const double s = board.spacing, right = points.at<double>(points.rows - 1, 0), bottom = points.at<double>(points.rows - 1, 1);
    const Matx44d board_T_camera = camera_T_board.inv();
    const Point3d centre = transformed(board_T_camera, Point3d());
    const Point3d corners[] = { Point3d(-2 * s, -2 * s, 0), Point3d(right + 3 * s, -2 * s, 0), Point3d(right + 3 * s, bottom + 2 * s, 0),
                                Point3d(-2 * s, bottom + 2 * s, 0) };
    Rect2d outline;
    for (int i = 0; i < 4; i++) outline |= Rect2d(camera.project(transformed(camera_T_board, corners[i])) - Point2d(5, 5), Size(10, 10));
    Mat image(camera.imageSize(), CV_8U, Scalar(110));
    const Rect window = Rect(outline) & Rect(Point(), image.size());
    for (int v = window.y; v < window.br().y; v++)
    {
        Mat pixels(4 * window.width, 2, CV_64F), rays;
        for (int i = 0; i < pixels.rows; i++)
        {
            pixels.at<double>(i, 0) = window.x + i / 4 + (i & 1) * 0.5 - 0.25;
            pixels.at<double>(i, 1) = v + (i >> 1 & 1) * 0.5 - 0.25;
        }
        camera.unprojectPoints(pixels, rays);
        for (int u = window.x; u < window.br().x; u++)
        {
            double sum = 0;
            for (int i = 4 * (u - window.x); i < 4 * (u - window.x) + 4; i++)
            {
                const Point2d ray = rays.at<Point2d>(i);
                const Point3d d = transformed(board_T_camera, Point3d(ray.x, ray.y, 1)) - centre, p = centre - d * (centre.z / d.z);
                bool dark = false;
                const bool on = p.x > -2 * s && p.y > -2 * s && p.x < right + 3 * s && p.y < bottom + 2 * s;
                if (board.pattern == CalibrationBoard::CHESSBOARD)
                    dark = p.x > -s && p.y > -s && p.x < right + s && p.y < bottom + s && (cvFloor(p.x / s) + cvFloor(p.y / s)) % 2 != 0;
                else
                    for (int j = 0; j < points.rows; j++) dark = dark || std::hypot(p.x - points.at<double>(j, 0), p.y - points.at<double>(j, 1)) < 0.4 * s;
                sum += !on ? 110 : dark ? 25 : 230;
            }
            image.at<uchar>(v, u) = saturate_cast<uchar>(sum / 4);
        }
    }
    return image;
}

CalibrationBoard chessboard()
{
    CalibrationBoard board;
    board.pattern = CalibrationBoard::CHESSBOARD;
    board.size = Size(7, 6);
    board.spacing = 0.003;
    return board;
}

TEST(SurgTrack_HandEye, aBoardIsFoundWithDistortionAnyWayUp)
{
    const CameraModel camera = endoscope();
    const CalibrationBoard boards[] = { CalibrationBoard(), chessboard() };
    for (int i = 0; i < 2; i++)
        for (int roll = -2; roll <= 3; roll++)
        {
            const Matx44d T = rigid(rotationMatrix(Vec3d(0.3, -0.2, 0)) * rotationMatrix(Vec3d(0, 0, roll * 60 * degree)), Point3d(0.002, -0.001, 0.09));
            Matx44d found;
            Mat points;
            double error = -1;
            ASSERT_TRUE(findBoard(photograph(camera, boards[i], T), camera, boards[i], found, points, error)) << i << " " << roll;
            EXPECT_EQ(boards[i].size.area(), points.rows);
            EXPECT_LT(error, 0.2);                                   // pixel; four samples a pixel place an edge to about a quarter
            EXPECT_LT(rotationAngle(found, T), 1 * degree);          // 0.2 pixel of 100, times sqrt(1 / 40 points), seen at 20 degrees
            EXPECT_LT(distance(found, T), 0.0005);                   // 0.2 % of the distance, likewise, and the board's corner turns
        }
}

TEST(SurgTrack_HandEye, aBoardThatIsNotThereIsNotFound)
{
    const CameraModel camera = endoscope();
    Matx44d T = Matx44d::eye() * 7.;
    double error = -1;
    Mat points;
    EXPECT_FALSE(findBoard(textured(camera.imageSize(), 3, 1), camera, CalibrationBoard(), T, points, error));
    EXPECT_FALSE(findBoard(Mat(camera.imageSize(), CV_8U, Scalar(128)), camera, chessboard(), T, points, error));
    EXPECT_EQ(7, T(0, 0));
    EXPECT_EQ(-1, error);
    EXPECT_ERROR(findBoard(Mat(100, 100, CV_8U, Scalar(0)), camera, chessboard(), T, points, error), "image is 100 x 100, expected the camera's 720 x 576");
}

TEST(SurgTrack_HandEye, aBoardThatLooksTheSameUpsideDownIsRefused)
{
    CalibrationBoard board = chessboard();
    Mat points;
    board.size = Size(8, 6);
    EXPECT_ERROR(getBoardPoints(board, points), "upside down");
    board.size = Size(7, 5);
    EXPECT_ERROR(getBoardPoints(board, points), "upside down");
    board = CalibrationBoard();
    board.size = Size(4, 10);
    EXPECT_ERROR(getBoardPoints(board, points), "upside down");
    board = CalibrationBoard();
    board.spacing = 0;
    EXPECT_ERROR(getBoardPoints(board, points), "board.spacing");
    getBoardPoints(CalibrationBoard(), points);
    ASSERT_EQ(44, points.rows);
    EXPECT_EQ(0.0015 * 7, points.at<double>(7, 0));   // last of the second row
    EXPECT_EQ(0.0015 * 1, points.at<double>(7, 1));
}

TEST(SurgTrack_HandEye, imagesOfABoardGiveTheCalibration)
{
    const Recording r(21, HAND_EYE_BOARD_ON_TOOL, 8, 0, 0, 25 * degree);
    const CameraModel camera = endoscope();
    const CalibrationBoard board;
    Mat points;
    getBoardPoints(board, points);
    std::vector<Matx44d> robot, found;
    for (size_t i = 0; i < r.board.size(); i++)
    {
        Matx44d T;
        double error;
        Mat at;
        if (!findBoard(photograph(camera, board, r.board[i]), camera, board, T, at, error)) continue;
        robot.push_back(r.robot[i]);
        found.push_back(T);
    }
    ASSERT_GE(found.size(), 6u);    // others may reach out of the image
    HandEyeResult result;
    ASSERT_TRUE(estimateHandEye(robot, found, result, HandEyeParams(), camera, points));
    EXPECT_LT(r.errorAtBoard(result.best.camera_T_mount), 0.0005);                                  // as a single board pose above
    EXPECT_LT(rotationAngle(result.best.camera_T_mount, r.camera_T_mount), 0.5 * degree);           // half of one above, for six
    EXPECT_LT(result.best.pixels, 2.);                                                              // exact robot: tilt and depth of the boards
}

String written(const String& text, const char* extension = ".csv")
{
    const String filename = cv::tempfile(extension);
    std::ofstream(filename.c_str(), std::ios::binary) << text;
    return filename;
}

String textOf(const String& filename)
{
    std::ifstream file(filename.c_str(), std::ios::binary);
    return String((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
}

TEST(SurgTrack_HandEye, posesAreReadByIndexAndByTime)
{
    std::vector<double> keys;
    Mat poses;
    const String file = written("index,tx,ty,tz,qx,qy,qz,qw,note\n3,0.1,0.2,0.3,0,0,0,1,a\n7,0,0,0.1,0,0,0.6,0.8,b\n");
    EXPECT_FALSE(readPoses(file, keys, poses));
    ASSERT_EQ(Size(16, 2), poses.size());
    EXPECT_EQ(7, keys[1]);
    EXPECT_EQ(0.2, poses.at<double>(0, 7));
    EXPECT_NEAR(0.28, poses.at<double>(1, 0), 1e-12);    // cos of twice acos 0.8; rounding
    EXPECT_NEAR(-0.96, poses.at<double>(1, 1), 1e-12);   // the same
    std::remove(file.c_str());

    const String head = "time,tx,ty,tz,qx,qy,qz,qw\n";
    const char* const wrong[][2] = { { "0.5,100,0,30,0,0,0,1\n", "line 2: tx,ty,tz is 104.4 m away, expected metres" },
                                     { "0.5,0,0,0,0,0,0,0.5\n", "line 2: qx,qy,qz,qw has length 0.5" },
                                     { "0.5,0,0,0,0,0,0,1\n0.5,0,0,0,0,0,0,1\n", "line 3: time is 0.5 after 0.5, expected rising values" },
                                     { "0.5,0,0,nan,0,0,0,1\n", "line 2: tz is 'nan'" },
                                     { "", "has no poses" } };
    for (int i = 0; i < 5; i++)
    {
        const String bad = written(head + wrong[i][0]);
        EXPECT_ERROR(readPoses(bad, keys, poses), wrong[i][1]);
        EXPECT_ERROR(readPoses(bad, keys, poses), bad);
        std::remove(bad.c_str());
    }
    const String unkeyed = written("tx,ty,tz,qx,qy,qz,qw\n0,0,0,0,0,0,1\n");
    EXPECT_ERROR(readPoses(unkeyed, keys, poses), "expected a column 'index' or a column 'time'");
    std::remove(unkeyed.c_str());
    EXPECT_ERROR(readPoses("/none/poses.csv", keys, poses), "/none/poses.csv");
}

const char* const description =
    "%YAML:1.0\n---\nfps: 25   # frames\ntools:\n"
    "   # camera_T_base: !!opencv-matrix, data: [ 0 ], of the old camera\n"
    "   -\n      name: \"camera_T_base data: [ 1 ]\"\n      model: \"a.yaml\"\n"
    "      camera_T_base: !!opencv-matrix\n         rows: 4\n         cols: 4\n         dt: d\n"
    "         data: [ 1, 0, 0, 0.5, 0, 1, 0, 0.25, 0, 0, 1, 0, 0, 0, 0, 1 ]\n"
    "   - { name: PSM2, my_camera_T_base: 3, camera_T_base: !!opencv-matrix { rows: 4, cols: 4, dt: d,\n"
    "         data: [ 1, 0, 0, 0, 0, 1, 0, 0,\n         0, 0, 1, 0, 0, 0, 0, 1 ] } }\nextra: [ 1, 2.5, yes ]\n";

TEST(SurgTrack_HandEye, onlyTheMatrixOfTheToolIsReplaced)
{
    const Matx44d T = rigid(rotationMatrix(Vec3d(0.1, 0.2, 0.3)), Point3d(0.01, -0.02, 0.1234567890123456789));
    const char* const names[] = { "camera_T_base data: [ 1 ]", "PSM2" };
    for (int i = 0; i < 2; i++)
    {
        const String file = written(description, ".yaml");
        writeHandEye(file, names[i], T);
        const String after = textOf(file), before = description;
        const size_t open = before.find("[ 1, 0, 0, 0", i ? before.find("PSM2") : 0), close = before.find(']', open);
        EXPECT_EQ(before.substr(0, open), after.substr(0, open));
        EXPECT_EQ(before.substr(close), after.substr(after.size() - (before.size() - close)));
        Mat read;
        cv::FileStorage(file, cv::FileStorage::READ)["tools"][i]["camera_T_base"] >> read;
        EXPECT_EQ(0, cv::norm(read, Mat(T), NORM_INF));
        EXPECT_FALSE(cv::utils::fs::exists(file + ".new"));
        std::remove(file.c_str());
    }
}

TEST(SurgTrack_HandEye, aDescriptionThatCannotBeChangedStaysAsItIs)
{
    const String file = written(description, ".yaml");
    EXPECT_ERROR(writeHandEye(file, "PSM3", Matx44d::eye()), "no tool 'PSM3', expected one of: camera_T_base data: [ 1 ], PSM2");
    EXPECT_ERROR(writeHandEye(file, "PSM2", Matx44d::eye() * 2.), "camera_T_base must be rigid");
    EXPECT_EQ(String(description), textOf(file));
    std::remove(file.c_str());
    const String missing = written("%YAML:1.0\n---\ntools:\n   - { name: PSM1, model: a }\n", ".yaml");
    EXPECT_ERROR(writeHandEye(missing, "PSM1", Matx44d::eye()), "tools[0].camera_T_base is missing");
    std::remove(missing.c_str());
    EXPECT_ERROR(writeHandEye("/none", "PSM1", Matx44d::eye()), "/none");
}

}} // namespace
