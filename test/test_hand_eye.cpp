// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_hand_eye.hpp"

#include <limits>

namespace opencv_test { namespace {

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

// cv::calibrateHandEye() by Tsai and by Daniilidis takes the wrong sign of some quaternions beyond 120 degrees (OpenCV 4.6).
TEST(SurgTrack_HandEye, largeRotationsMakeNoWrongMethodTheBest)
{
    const Recording r(13, HAND_EYE_BOARD_ON_TOOL, 14, 0.0002, 0.2 * degree, 30 * degree, 175 * degree);
    HandEyeResult result;
    ASSERT_TRUE(estimateHandEye(r.robot, r.board, result));
    EXPECT_GT(result.largestRotation, 150 * degree);
    EXPECT_TRUE(result.rejected.empty());
    EXPECT_LT(rotationAngle(result.best.camera_T_mount, r.camera_T_mount), 0.45 * degree);   // bound of the noise test, whose noise is larger
    for (int method = 0; method <= HAND_EYE_REFINED; method++)
    {
        ASSERT_TRUE(estimateHandEye(r.robot, r.board, result, paramsFor(HAND_EYE_BOARD_ON_TOOL, method)) || !result.best.valid);
        const bool right = result.best.valid && rotationAngle(result.best.camera_T_mount, r.camera_T_mount) < 5 * degree;
        EXPECT_TRUE(right || !result.best.valid || mentions(result.warnings, "poses that do not fit")) << handEyeMethodName(method);
    }
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
    const int sizes[] = { 12, 4, 4 };
    Mat robot = rowsOf(r.robot), board = rowsOf(r.board);
    HandEyeResult d;
    ASSERT_TRUE(estimateHandEye(Mat(3, sizes, CV_64F, robot.data), Mat(3, sizes, CV_64F, board.data), d));
    EXPECT_EQ(a.best.camera_T_mount, d.best.camera_T_mount);
}

TEST(SurgTrack_HandEye, aWrongCallIsRefused)
{
    const Recording r(12, HAND_EYE_BOARD_ON_TOOL, 8);
    HandEyeResult result;
    std::vector<Matx44d> robot = r.robot, three(robot.begin(), robot.begin() + 3);
    EXPECT_ERROR(estimateHandEye(three, three, result), "robotPoses: 3 poses, expected at least 4");
    EXPECT_ERROR(estimateHandEye(three, r.board, result), "robotPoses and boardPoses");
    EXPECT_ERROR(estimateHandEye(noArray(), r.board, result), "robotPoses");
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

}} // namespace
