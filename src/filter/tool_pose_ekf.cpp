// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include <Eigen/Dense>
#include "opencv2/surgtrack/tool_pose_ekf.hpp"
#include "base/calib.hpp"
#include "base/checks.hpp"
#include "base/geometry.hpp"

// x      state: (theta_x, theta_y, theta_z, r_x, r_y, r_z) of camera_T_nominal, R = Rz Ry Rx
// P, Q   covariance of the state, of the process noise
// z, h   measured and predicted image points (u, v)
// H      dh / dx
// R      covariance of the image points; diagonal, so a number
// S, K   innovation covariance, gain; of one point

namespace cv { namespace surgtrack {

// Not aligned: members of objects on the heap, where C++11 promises 16 bytes only.
typedef Eigen::Matrix<double, 6, 1, Eigen::DontAlign> Vector6;
typedef Eigen::Matrix<double, 6, 6, Eigen::DontAlign> Matrix6;
typedef Eigen::Matrix<double, 2, 6, Eigen::DontAlign> Row2x6;

namespace {

// R = Rz Ry Rx and, on request, its derivatives by the three angles.
Matx33d eulerRotation(const double* theta, Matx33d* derivatives = 0)
{
    const double cx = std::cos(theta[0]), sx = std::sin(theta[0]), cy = std::cos(theta[1]), sy = std::sin(theta[1]);
    const double cz = std::cos(theta[2]), sz = std::sin(theta[2]);
    const Matx33d X(1, 0, 0, 0, cx, -sx, 0, sx, cx), Y(cy, 0, sy, 0, 1, 0, -sy, 0, cy), Z(cz, -sz, 0, sz, cz, 0, 0, 0, 1);
    if (derivatives)
    {
        derivatives[0] = Z * Y * Matx33d(0, 0, 0, 0, -sx, -cx, 0, cx, -sx);
        derivatives[1] = Z * Matx33d(-sy, 0, cy, 0, 0, 0, -cy, 0, -sy) * X;
        derivatives[2] = Matx33d(-sz, -cz, 0, cz, -sz, 0, 0, 0, 0) * Y * X;
    }
    return Z * Y * X;
}

// The state's rotation with its derivatives, kept for all points of a frame.
struct Linearization
{
    explicit Linearization(const double* x) : R(eulerRotation(x, dR)), r(x[3], x[4], x[5]) {}

    Point3d viewPoint(const Point3d& p) const
    {
        const Vec3d v = R * Vec3d(p.x, p.y, p.z);
        return Point3d(v[0] + r.x, v[1] + r.y, v[2] + r.z);
    }

    // h(x) and H of one point that lies in front of the camera (paper, eq. 4 and 5)
    Point2d project(const CameraModel& camera, const Point3d& p, Row2x6* H) const
    {
        const Point3d v = viewPoint(p);
        if (!H) return camera.project(v);
        Matx23d J;
        const Point2d u = camera.project(v, &J);
        for (int i = 0; i < 3; i++)
        {
            const Vec3d d = dR[i] * Vec3d(p.x, p.y, p.z);
            const Vec2d column = J * d;
            (*H)(0, i) = column[0];
            (*H)(1, i) = column[1];
            (*H)(0, 3 + i) = J(0, i);
            (*H)(1, 3 + i) = J(1, i);
        }
        return u;
    }

    Matx33d dR[3], R;
    Point3d r;
};

Vector6 checkedState(InputArray state)
{
    const Mat x = asRows(state, 6, "state");
    if (x.rows != 1) CV_Error(Error::StsBadSize, "state must have 6 values");
    return Vector6(x.ptr<double>());
}

} // namespace

void projectKeypoints(const CameraModel& camera, InputArray state, InputArray nominalPoints, OutputArray imagePoints, OutputArray jacobian)
{
    const Vector6 x = checkedState(state);
    const Mat points = asRows(nominalPoints, 3, "nominalPoints");
    const Linearization at(x.data());
    imagePoints.create(points.rows, 1, CV_64FC2);
    Mat_<Point2d> u = imagePoints.getMat();
    Mat_<double> J;
    if (jacobian.needed())
    {
        jacobian.create(2 * points.rows, 6, CV_64F);
        J = jacobian.getMat();
    }
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (int i = 0; i < points.rows; i++)
    {
        const Point3d& p = *points.ptr<Point3d>(i);
        Row2x6 H = Row2x6::Constant(nan);
        u(i) = Point2d(nan, nan);
        if (at.viewPoint(p).z > nearestDepth) u(i) = at.project(camera, p, &H);
        if (!J.empty())
            for (int j = 0; j < 12; j++) J(2 * i + j / 6, j % 6) = H(j / 6, j % 6);
    }
}

static Matx44d correctionOf(const Vector6& x)
{
    return rigidTransform(eulerRotation(x.data()), Vec3d(x[3], x[4], x[5]));
}

Matx44d correctionFromState(InputArray state)
{
    return correctionOf(checkedState(state));
}

static Vector6 stateOf(const Matx44d& T)
{
    if (!isRigid(T)) CV_Error(Error::StsBadArg, "camera_T_nominal must be a rigid transform");
    Vector6 x;
    x << std::atan2(T(2, 1), T(2, 2)), std::atan2(-T(2, 0), std::hypot(T(0, 0), T(1, 0))), std::atan2(T(1, 0), T(0, 0)), T(0, 3), T(1, 3), T(2, 3);
    return x;
}

void stateFromCorrection(const Matx44d& camera_T_nominal, OutputArray state)
{
    Vector6 x = stateOf(camera_T_nominal);
    Mat(6, 1, CV_64F, x.data()).copyTo(state);
}

bool solveEPnP(const CameraModel& camera, InputArray _nominalPoints, InputArray _imagePoints, Matx44d& camera_T_nominal, double maxError)
{
    const Mat points = asRows(_nominalPoints, 3, "nominalPoints"), image = asRows(_imagePoints, 2, "imagePoints");
    CV_CheckEQ(points.rows, image.rows, "one image point per nominal point");
    if (points.rows < 4) return false;
    Mat rvec, tvec;
    bool found;
    if (maxError > 0)
    {
        Mat inliers;
        found = solvePnPRansac(points, image, camera.cameraMatrix(), camera.distCoeffs(), rvec, tvec, false, 200, float(maxError), 0.999,
                               inliers, SOLVEPNP_EPNP);
    }
    else found = solvePnP(points, image, camera.cameraMatrix(), camera.distCoeffs(), rvec, tvec, false, SOLVEPNP_EPNP);
    if (!found || !checkRange(rvec) || !checkRange(tvec)) return false;

    Matx33d R;
    Rodrigues(rvec, R);
    const Matx44d T = rigidTransform(R, Vec3d(tvec.ptr<double>()));
    for (int i = 0; i < points.rows; i++)
        if (transform(T, *points.ptr<Point3d>(i)).z < nearestDepth) return false;
    camera_T_nominal = T;
    return true;
}

ToolPoseEKF::Params::Params()
    : initialRotation(4 * CV_PI / 180), initialTranslation(0.008), processRotation(0.05 * CV_PI / 180), processTranslation(0.00015),
      measurementNoise(3), gate(13.8), minPoints(1)
{
}

namespace {

class ToolPoseEKFImpl CV_FINAL : public ToolPoseEKF
{
public:
    ToolPoseEKFImpl(const CameraModel& camera, const Params& params) : camera_(camera), params_(params)
    {
        CV_Assert(!camera.imageSize().empty());
        CV_Check(params.measurementNoise, params.measurementNoise > 1e-4 && params.measurementNoise < 1e4, "Params::measurementNoise must be more than 1e-4 and less than 1e4");
        CV_Check(params.initialRotation, params.initialRotation >= 0 && params.initialRotation < 1e4, "Params::initialRotation must be at least 0 and less than 1e4");
        CV_Check(params.initialTranslation, params.initialTranslation >= 0 && params.initialTranslation < 1e4, "Params::initialTranslation must be at least 0 and less than 1e4");
        CV_Check(params.processRotation, params.processRotation >= 0 && params.processRotation < 1e4, "Params::processRotation must be at least 0 and less than 1e4");
        CV_Check(params.processTranslation, params.processTranslation >= 0 && params.processTranslation < 1e4, "Params::processTranslation must be at least 0 and less than 1e4");
        CV_Check(params.gate, params.gate < DBL_MAX, "Params::gate must be a number");
        Q_ << Vector6::Constant(params.processRotation).head<3>(), Vector6::Constant(params.processTranslation).tail<3>();
        Q_ = Q_.cwiseAbs2().eval();
        reset(Matx44d::eye());
    }

    void reset(const Matx44d& camera_T_nominal) CV_OVERRIDE
    {
        x_ = stateOf(camera_T_nominal);
        P_.setZero();
        P_.diagonal().head<3>().setConstant(params_.initialRotation * params_.initialRotation);
        P_.diagonal().tail<3>().setConstant(params_.initialTranslation * params_.initialTranslation);
        nis_ = 0;
    }

    void changeFrames(const Matx44d& now_T_camera, const Matx44d& nominal_T_now) CV_OVERRIDE;

    void predict() CV_OVERRIDE { P_.diagonal() += Q_; }

    void copyTo(ToolPoseEKF& other) const CV_OVERRIDE
    {
        ToolPoseEKFImpl& to = static_cast<ToolPoseEKFImpl&>(other);   // there are no others
        to.x_ = x_;
        to.P_ = P_;
        to.nis_ = nis_;
    }

    bool correct(InputArray nominalPoints, InputArray imagePoints, OutputArray used) CV_OVERRIDE;

    Matx44d correction() const CV_OVERRIDE { return correctionOf(x_); }
    Mat state() const CV_OVERRIDE { return Mat(6, 1, CV_64F, const_cast<double*>(x_.data())).clone(); }
    Mat covariance() const CV_OVERRIDE { return Mat(6, 6, CV_64F, const_cast<double*>(P_.data())).clone(); }
    double nis() const CV_OVERRIDE { return nis_; }
    Matx22d imageCovariance(const Point3d& nominalPoint) const CV_OVERRIDE;
    Matx66d poseCovariance(const Point3d& nominalTool) const CV_OVERRIDE;

private:
    CameraModel camera_;
    Params params_;
    Vector6 x_, Q_;   // Q_: the diagonal
    Matrix6 P_;
    double nis_;
};

// P by the derivatives of the new state by the old one, from central differences.
void ToolPoseEKFImpl::changeFrames(const Matx44d& now_T_camera, const Matx44d& nominal_T_now)
{
    CV_Assert(isRigid(now_T_camera) && "now_T_camera: rigid");
    CV_Assert(isRigid(nominal_T_now) && "nominal_T_now: rigid");
    const double step = 1e-6;   // [rad, m]; the derivatives are good to 1e-9
    Matrix6 J;
    for (int i = 0; i < 6; i++)
    {
        const Vector6 d = step * Vector6::Unit(i);
        J.col(i) = (stateOf(now_T_camera * correctionOf(x_ + d) * nominal_T_now) - stateOf(now_T_camera * correctionOf(x_ - d) * nominal_T_now)) / (2 * step);
    }
    x_ = stateOf(now_T_camera * correctionOf(x_) * nominal_T_now);
    P_ = (J * P_ * J.transpose()).eval();
}

/* R is diagonal, so the points are taken in one after the other, all at the linearization of the predicted state: the same
   result as from all at once, without matrices that grow with their number. */
bool ToolPoseEKFImpl::correct(InputArray nominalPoints, InputArray imagePoints, OutputArray used)
{
    const Mat points = asRows(nominalPoints, 3, "nominalPoints"), image = asRows(imagePoints, 2, "imagePoints");
    CV_CheckEQ(points.rows, image.rows, "one image point per nominal point");
    Mat flags;
    if (used.needed())
    {
        used.create(points.rows, 1, CV_8UC1);
        flags = used.getMat();
    }

    const double R = params_.measurementNoise * params_.measurementNoise;
    const Linearization at(x_.data());
    Vector6 dx = Vector6::Zero();
    Matrix6 P = P_;
    double nis = 0;
    int passed = 0;
    for (int i = 0; i < points.rows; i++)
    {
        if (!flags.empty()) flags.at<uchar>(i) = 0;
        const Point3d& p = *points.ptr<Point3d>(i);
        if (at.viewPoint(p).z < nearestDepth) continue;
        Row2x6 H;
        const Point2d difference = *image.ptr<Point2d>(i) - at.project(camera_, p, &H);
        const Eigen::Vector2d innovation(difference.x, difference.y);
        const Eigen::Matrix2d predicted = H * P_ * H.transpose() + R * Eigen::Matrix2d::Identity();
        if (params_.gate > 0 && innovation.dot(predicted.llt().solve(innovation)) > params_.gate) continue;
        if (!flags.empty()) flags.at<uchar>(i) = 1;
        passed++;

        const Eigen::Matrix2d S = H * P * H.transpose() + R * Eigen::Matrix2d::Identity();
        const Eigen::LLT<Eigen::Matrix2d> cholesky(S);
        if (cholesky.info() != Eigen::Success) return false;
        const Eigen::Matrix<double, 6, 2> K = cholesky.solve(H * P).transpose();
        const Eigen::Vector2d y = innovation - H * dx;
        nis += y.dot(cholesky.solve(y));
        dx += K * y;
        const Matrix6 I_KH = Matrix6::Identity() - K * H;
        P = (I_KH * P * I_KH.transpose() + R * K * K.transpose()).eval();   // Joseph
    }
    if (passed < std::max(1, params_.minPoints)) return false;
    x_ += dx;
    P_ = 0.5 * (P + P.transpose());
    nis_ = nis / (2 * passed);
    return true;
}

Matx22d ToolPoseEKFImpl::imageCovariance(const Point3d& nominalPoint) const
{
    const Linearization at(x_.data());
    if (at.viewPoint(nominalPoint).z < nearestDepth) return Matx22d::zeros();
    Row2x6 H;
    at.project(camera_, nominalPoint, &H);
    const Eigen::Matrix2d C = H * P_ * H.transpose();
    return Matx22d(C(0, 0), C(0, 1), C(1, 0), C(1, 1));
}

Matx66d ToolPoseEKFImpl::poseCovariance(const Point3d& p) const
{
    const Linearization at(x_.data());
    Matrix6 J = Matrix6::Zero();   // d(rotation vector, translation of the tool) / dx
    const double zero[3] = {0, 0, 0}, onlyZ[3] = {0, 0, x_[2]}, yz[3] = {0, x_[1], x_[2]};
    const Matx33d axes[3] = {eulerRotation(yz), eulerRotation(onlyZ), eulerRotation(zero)};   // axis of angle i: column i
    for (int i = 0; i < 3; i++)
    {
        const Vec3d d = at.dR[i] * Vec3d(p.x, p.y, p.z);
        for (int j = 0; j < 3; j++)
        {
            J(j, i) = axes[i](j, i);
            J(3 + j, i) = d[j];
        }
        J(3 + i, 3 + i) = 1;
    }
    Matx66d result;
    Eigen::Map<Matrix6>(result.val) = J * P_ * J.transpose();   // symmetric: the storage order does not matter
    return result;
}

} // namespace

Ptr<ToolPoseEKF> ToolPoseEKF::create(const CameraModel& camera, const Params& params)
{
    return makePtr<ToolPoseEKFImpl>(camera, params);
}

}} // namespace cv::surgtrack
