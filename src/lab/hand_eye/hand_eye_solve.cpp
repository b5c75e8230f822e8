// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "base/calib.hpp"
#include "base/geometry.hpp"
#include "lab/hand_eye/hand_eye_solve.hpp"

namespace cv { namespace surgtrack {

namespace {

typedef Matx<double, 12, 12> Matrix12;
typedef Matx<double, 12, 1> Vector12;

const double leastShift = 1e-5, leastAngle = 1e-4;    // deviations [m], [rad]; no robot and no board is known better
const double robotShift = 1e-3, robotAngle = CV_PI / 180;    // the same, to begin with; what a cable-driven robot has
const double largestError = 1e6;

//! Of rotation vector and translation.
Matx44d motionOf(const double* v) { return rigidTransform(exponential(Vec3d(v)), Vec3d(v + 3)); }

void split(const Matx44d& T, double unit, std::vector<Mat>& R, std::vector<Mat>& t)
{
    R.push_back(Mat(rotationOf(T)));
    t.push_back(Mat(T.get_minor<3, 1>(0, 3) * unit));
}

//! The nearest rigid transform, if there is one.
bool makeRigid(Matx44d& T)
{
    if (!checkRange(T)) return false;
    T = nearestRigid(T);
    return isRigid(T);
}

//! The Y that fits an X best: the mean of what each pose says.
Matx44d meanBoard(const HandEyeProblem& problem, const std::vector<int>& poses, const Matx44d& X)
{
    Matx44d sum = Matx44d::zeros();
    for (size_t i = 0; i < poses.size(); i++)
        sum += rigidInverse(problem.M()[poses[i]]) * rigidInverse(X) * problem.B()[poses[i]];
    return sum * (1. / poses.size());
}

} // namespace

HandEyeProblem::HandEyeProblem(const std::vector<Matx44d>& M, const std::vector<Matx44d>& B, const CameraModel& camera,
                               const std::vector<Point3d>& points)
    : M_(M), B_(B), camera_(camera), points_(points), deviation_(robotShift, robotShift, robotShift, robotAngle, robotAngle, robotAngle)
{
    for (size_t i = 0; i < points.size(); i++) middle_ += points[i] * (1. / points.size());
}

HandEyeError HandEyeProblem::error(const HandEye& solution, int pose) const
{
    const Matx44d predicted = solution.X * M_[pose] * solution.Y;
    const Vec3d rotation = rotationVector(rotationOf(B_[pose]) * rotationOf(predicted).t());
    const Point3d shift = transform(B_[pose], middle_) - transform(predicted, middle_);
    HandEyeError error;
    error.e = Vec6d(shift.x, shift.y, shift.z, rotation[0], rotation[1], rotation[2]);
    error.translation = norm(shift);
    error.rotation = norm(rotation);
    error.pixels = 0;
    if (camera_.imageSize().empty()) return error;
    // No error is larger than the image: what lies behind the camera has no place in it.
    const double image = norm(Point(camera_.imageSize()));
    for (size_t i = 0; i < points_.size(); i++)
    {
        const Point3d q = transform(predicted, points_[i]);
        const double distance = q.z > nearestDepth ? std::min(norm(camera_.project(q) - camera_.project(transform(B_[pose], points_[i]))), image) : image;
        error.pixels += distance * distance / points_.size();
    }
    error.pixels = std::sqrt(error.pixels);
    return error;
}

double HandEyeProblem::weighted(const Vec6d& e) const
{
    double sum = 0;
    for (int i = 0; i < 6; i++) sum += e[i] * e[i] / (deviation_[i] * deviation_[i]);
    return std::min(std::sqrt(sum / 6), largestError);
}

void HandEyeProblem::weigh(const std::vector<Vec6d>& errors)
{
    for (int i = 0; i < 6; i += 3)
    {
        std::vector<double> across, along;    // the line of sight
        for (size_t j = 0; j < errors.size(); j++)
        {
            across.push_back(std::abs(errors[j][i]));
            across.push_back(std::abs(errors[j][i + 1]));
            along.push_back(std::abs(errors[j][i + 2]));
        }
        const double least = i ? leastAngle : leastShift;
        std::nth_element(across.begin(), across.begin() + across.size() / 2, across.end());
        std::nth_element(along.begin(), along.begin() + along.size() / 2, along.end());
        // 1.4826: deviation of normal errors, as a multiple of their median
        deviation_[i] = deviation_[i + 1] = std::max(1.4826 * across[across.size() / 2], least);
        deviation_[i + 2] = std::max(1.4826 * along[along.size() / 2], least);
    }
}

bool HandEyeProblem::solveClosed(int method, const std::vector<int>& poses, HandEye& solution) const
{
    const bool robotWorld = method == HAND_EYE_SHAH || method == HAND_EYE_LI;
    // Andreff and Li weigh equations of rotations and of translations alike, so the unit of length is a weight: errors of both shall have
    // the same size. In metres the rotations would shrink with the noise, and the translations be off by centimetres.
    const double unit = deviation_[3] / deviation_[0];
    std::vector<Mat> robotR, robotT, boardR, boardT;
    for (size_t i = 0; i < poses.size(); i++)
    {
        // gripper2base of calibrateHandEye() is holder_T_mount, base2gripper of calibrateRobotWorldHandEye() is mount_T_holder
        split(robotWorld ? M_[poses[i]] : rigidInverse(M_[poses[i]]), unit, robotR, robotT);
        split(B_[poses[i]], unit, boardR, boardT);
    }
    Matx33d R, worldR;
    Vec3d t, worldT;
    if (robotWorld)
    {
        calibrateRobotWorldHandEye(boardR, boardT, robotR, robotT, worldR, worldT, R, t,
                                   method == HAND_EYE_SHAH ? CALIB_ROBOT_WORLD_HAND_EYE_SHAH : CALIB_ROBOT_WORLD_HAND_EYE_LI);
        solution.X = rigidTransform(R, t * (1 / unit));                // gripper2cam
        solution.Y = rigidTransform(worldR, worldT * (1 / unit));      // base2world, to be inverted
        if (!makeRigid(solution.X) || !makeRigid(solution.Y)) return false;
        solution.Y = rigidInverse(solution.Y);
        return true;
    }
    const HandEyeCalibrationMethod methods[] = { CALIB_HAND_EYE_TSAI, CALIB_HAND_EYE_PARK, CALIB_HAND_EYE_HORAUD, CALIB_HAND_EYE_ANDREFF,
                                                 CALIB_HAND_EYE_DANIILIDIS };
    calibrateHandEye(robotR, robotT, boardR, boardT, R, t, methods[method]);
    solution.X = rigidTransform(R, t * (1 / unit));                    // cam2gripper, to be inverted
    if (!makeRigid(solution.X)) return false;
    solution.X = rigidInverse(solution.X);
    solution.Y = meanBoard(*this, poses, solution.X);
    return makeRigid(solution.Y);
}

bool HandEyeProblem::solve(int method, const std::vector<int>& poses, HandEye& solution) const
{
    if (poses.size() < 3) return false;
    try
    {
        return solveClosed(method, poses, solution);
    }
    catch (const Exception&)    // a rotation of determinant 0, if nothing turns
    {
        return false;
    }
}

double HandEyeProblem::cost(const std::vector<int>& poses, const HandEye& solution, Matrix12* A, Vector12* b) const
{
    double sum = 0;
    if (A)
    {
        *A = Matrix12::zeros();
        *b = Vector12::zeros();
    }
    for (size_t i = 0; i < poses.size(); i++)
    {
        const Matx44d predicted = solution.X * M_[poses[i]] * solution.Y;
        const Vec6d e = error(solution, poses[i]).e;
        // de of e = B - exp(x1) X M Y exp(x2)
        const Matx33d R = rotationOf(predicted), left = skew(transform(predicted, middle_)), right = R * skew(middle_);
        Matx<double, 6, 12> J = Matx<double, 6, 12>::zeros();
        Vec6d weightedError;
        for (int r = 0; r < 3; r++)
            for (int c = 0; c < 3; c++)
            {
                J(r, c) = -left(r, c) / deviation_[r];
                J(r, 3 + c) = (r == c) / deviation_[r];
                J(r, 6 + c) = -right(r, c) / deviation_[r];
                J(r, 9 + c) = R(r, c) / deviation_[r];
                J(3 + r, c) = (r == c) / deviation_[3 + r];
                J(3 + r, 6 + c) = R(r, c) / deviation_[3 + r];
            }
        for (int r = 0; r < 6; r++) weightedError[r] = e[r] / deviation_[r];
        sum += weightedError.dot(weightedError);
        if (!A) continue;
        *A += J.t() * J;
        *b += J.t() * weightedError;
    }
    return sum;
}

// Levenberg and Marquardt; steps as in the Jacobian above.
void HandEyeProblem::refine(const std::vector<int>& poses, HandEye& solution) const
{
    Matrix12 A;
    Vector12 b;
    double lambda = 1e-4, before = cost(poses, solution, &A, &b);
    for (int i = 0; i < 50 && lambda < 1e8; i++)
    {
        Matrix12 damped = A;
        for (int k = 0; k < 12; k++) damped(k, k) += lambda * A(k, k) + DBL_MIN;
        Vector12 x;
        HandEye next = solution;
        const bool solved = cv::solve(damped, b, x, DECOMP_CHOLESKY);
        if (solved)
        {
            next.X = nearestRigid(motionOf(x.val) * solution.X);
            next.Y = nearestRigid(solution.Y * motionOf(x.val + 6));
        }
        const double after = solved ? cost(poses, next, 0, 0) : DBL_MAX;
        if (!(after < before))
        {
            lambda *= 10;
            continue;
        }
        const bool done = after > before * (1 - 1e-9);
        solution = next;
        lambda = std::max(lambda * 0.1, 1e-12);
        before = cost(poses, solution, &A, &b);
        if (done) break;
    }
}

}} // namespace cv::surgtrack
