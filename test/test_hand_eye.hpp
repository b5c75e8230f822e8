// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_TEST_HAND_EYE_HPP
#define OPENCV_SURGTRACK_TEST_HAND_EYE_HPP

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
        camera_T_mount = rigid(randomRotation(rng), Point3d(0.05, -0.08, 0.03));
        holder_T_board = rigid(randomRotation(rng), Point3d(0.004, 0.002, 0.01));
        for (int i = 0; i < poses; i++)
        {
            const double direction = rng.uniform(-CV_PI, CV_PI), angle = tilt * std::sqrt(rng.uniform(0., 1.));
            const Matx33d R = rotationMatrix(Vec3d(std::cos(direction), std::sin(direction), 0) * angle) * rotationMatrix(Vec3d(0, 0, rng.uniform(-roll, roll)));
            const Matx44d T = rigid(R, Point3d(uniform(rng, Vec3d(-0.02, -0.015, 0.08), Vec3d(0.02, 0.015, 0.12))));
            const Matx44d M = camera_T_mount.inv() * T * holder_T_board.inv();
            robot.push_back(setup == HAND_EYE_BOARD_ON_TOOL ? M : Matx44d(M.inv()));
            board.push_back(disturbed(T, rng, shiftNoise, angleNoise));
        }
    }

    static Matx33d randomRotation(RNG& rng)
    {
        const double angle = rng.uniform(0., 3.);
        return rotationMatrix(randomDirection(rng) * angle);
    }

    static Matx44d disturbed(const Matx44d& T, RNG& rng, double shift, double angle)
    {
        const Matx44d turn = rigid(rotationMatrix(gaussian<3>(rng, 1) * angle), Point3d());
        const Vec3d d = gaussian<3>(rng, 1) * shift;
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

}} // namespace

#endif
