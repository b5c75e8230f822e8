// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_LAB_HAND_EYE_HAND_EYE_SOLVE_HPP
#define OPENCV_SURGTRACK_SRC_LAB_HAND_EYE_HAND_EYE_SOLVE_HPP

#include <vector>
#include "opencv2/surgtrack/hand_eye.hpp"

namespace cv { namespace surgtrack {

// B_i = X M_i Y, with
// B   camera_T_board, measured
// M   mount_T_holder, of the robot
// X   camera_T_mount, sought
// Y   holder_T_board, sought

struct HandEye
{
    Matx44d X, Y;
};

//! By how much a solution misses a pose of the board.
struct HandEyeError
{
    double translation, rotation, pixels;    //!< of the board's middle [m], orientation [rad], points [pixel; 0 without a camera]
    Vec6d e;                                 //!< translation of the middle [m], rotation vector [rad], in the camera's axes
};

//! All poses, and how errors in them are weighted.
class HandEyeProblem
{
public:
    //! @param camera an empty one = no errors in pixels
    HandEyeProblem(const std::vector<Matx44d>& M, const std::vector<Matx44d>& B, const CameraModel& camera, const std::vector<Point3d>& points);

    int size() const { return (int)M_.size(); }
    const std::vector<Matx44d>& M() const { return M_; }
    const std::vector<Matx44d>& B() const { return B_; }
    Point3d middle() const { return middle_; }    //!< of the board, in its frame

    HandEyeError error(const HandEye& solution, int pose) const;

    //! An error in standard deviations, root mean square of its six components; at most 1e6.
    double weighted(const Vec6d& e) const;
    //! The standard deviations, from the medians of errors: the depth of a board is known less than its place in the image, its
    //! tilt less than its roll, and the robot errs too; by how much is seen in the errors only.
    void weigh(const std::vector<Vec6d>& errors);

    //! One of the methods but HAND_EYE_REFINED, from some of the poses. @return false if it has no finite answer
    bool solve(int method, const std::vector<int>& poses, HandEye& solution) const;

    //! Least squares of the weighted errors.
    void refine(const std::vector<int>& poses, HandEye& solution) const;

private:
    bool solveClosed(int method, const std::vector<int>& poses, HandEye& solution) const;
    //! Sum of squares; on request normal equations, A dx = b, in x = rotation and translation of X, then of Y.
    double cost(const std::vector<int>& poses, const HandEye& solution, Matx<double, 12, 12>* A, Matx<double, 12, 1>* b) const;

    std::vector<Matx44d> M_, B_;
    CameraModel camera_;
    std::vector<Point3d> points_;
    Point3d middle_;
    Vec6d deviation_;
};

}} // namespace cv::surgtrack

#endif
