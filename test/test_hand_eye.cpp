// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_common.hpp"

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

TEST(SurgTrack_HandEye, everyMethodIsAsGoodAsTheNoiseAllows)
{
    const int poses = 20, runs = 20;
    const double shift = 0.0003, angle = 0.3 * degree;    // per axis; what a board of 15 mm gives
    for (int setup = 0; setup < 2; setup++)
    {
        std::vector<double> places(HAND_EYE_REFINED + 1, 0.), angles(HAND_EYE_REFINED + 1, 0.);
        for (int run = 0; run < runs; run++)
        {
            const Recording r(100 + run, setup, poses, shift, angle);
            HandEyeParams params = paramsFor(setup);
            params.rejection = 0;
            HandEyeResult result;
            ASSERT_TRUE(estimateHandEye(r.robot, r.board, result, params));
            for (int method = 0; method <= HAND_EYE_REFINED; method++)
            {
                ASSERT_TRUE(result.fits[method].valid);
                places[method] += std::pow(r.errorAtBoard(result.fits[method].camera_T_mount), 2) / runs;
                angles[method] += std::pow(rotationAngle(result.fits[method].camera_T_mount, r.camera_T_mount), 2) / runs;
            }
        }
        for (int method = 0; method <= HAND_EYE_REFINED; method++)
            printf("%s %.3f mm %.3f deg\n", handEyeMethodName(method).c_str(), 1e3*std::sqrt(places[method]), std::sqrt(angles[method])/degree);
    }
}

}} // namespace
