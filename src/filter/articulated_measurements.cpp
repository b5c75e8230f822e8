// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "base/checks.hpp"
#include "base/geometry.hpp"
#include "filter/articulated_pose_ekf.hpp"

namespace cv { namespace surgtrack {

void checkGrowth(double rotation, double translation)
{
    CV_Check(rotation, rotation >= 0 && rotation < DBL_MAX, "rotation must not be negative");
    CV_Check(translation, translation >= 0 && translation < DBL_MAX, "translation must not be negative");
}


static void add(Rows3& D, int column, const Point3d& u)
{
    D(0, column) += u.x;
    D(1, column) += u.y;
    D(2, column) += u.z;
}

// dp / dx of a point of a link, in the camera frame
void ArticulatedPoseEKFImpl::motion(int link, const Point3d& p, Rows3& D) const
{
    D.setZero(3, m_);
    const Point3d a = p - state_.centre;
    D(0, 1) = a.z; D(0, 2) = -a.y; D(1, 0) = -a.z; D(1, 2) = a.x; D(2, 0) = a.y; D(2, 1) = -a.x;
    D(0, 3) = D(1, 4) = D(2, 5) = 1;
    const std::vector<Axis>& axes = axes_[link];
    for (size_t i = 0; i < axes.size(); i++)
    {
        const Point3d u = axes[i].revolute ? axes[i].direction.cross(p - axes[i].origin) : axes[i].direction;
        if (axes[i].state >= 0) add(D, axes[i].state, u);
        if (params_.delay > 0) add(D, m_ - 1, u * axes[i].rate);
    }
}

bool ArticulatedPoseEKFImpl::row(const CameraModel& camera, const Matx44d& eye_T_camera, int link, const Point3d& linkPoint, Point2d& imagePoint,
                                 Rows2& H) const
{
    const Point3d p = transform(view_.camera_T_base * view_.base_T_link[link], linkPoint), q = transform(eye_T_camera, p);
    if (q.z < nearestDepth) return false;
    Matx23d J;
    imagePoint = camera.project(q, &J);
    const Matx23d JR = J * eye_T_camera.get_minor<3, 3>(0, 0);
    Rows3 D;
    motion(link, p, D);
    H = Eigen::Map<const Eigen::Matrix<double, 2, 3, Eigen::RowMajor> >(JR.val) * D;
    return true;
}

// Inverse covariance of what displaces edges, given all else.
Eigen::Matrix2d ArticulatedPoseEKFImpl::edgeBiases() const
{
    Eigen::Matrix2d result = biasA_;
    result(0, 0) += 1 / std::pow(params_.edgeBias, 2);
    result(1, 1) += 1 / std::pow(params_.bloom, 2);
    return result;
}

// What is measured, whatever displaced the edges: a Schur complement.
void ArticulatedPoseEKFImpl::marginalise(SeenMatrix& A, SeenVector& b, double& square) const
{
    const Eigen::Matrix2d inverse = edgeBiases().inverse();
    A = A_ - biasSeen_ * inverse * biasSeen_.transpose();
    b = b_ - biasSeen_ * (inverse * biasb_);
    square = square_ - biasb_.dot(inverse * biasb_);
}

// x = (P^-1 + A)^-1 b with P = L L^T: L (I + L^T A L)^-1 L^T b; the posterior is symmetric and positive by its form.
bool ArticulatedPoseEKFImpl::posterior(const Matrix& P, const SeenMatrix& seenA, const SeenVector& seenb, Vector& x, Matrix& result) const
{
    const int k = m_ - 6, l = n_ - 6;
    Matrix A(n_, n_);   // of the state, from that of what is seen
    A.topLeftCorner(6, 6) = seenA.topLeftCorner(6, 6);
    A.bottomLeftCorner(l, 6) = phi_.transpose() * seenA.bottomLeftCorner(k, 6);
    A.topRightCorner(6, l) = A.bottomLeftCorner(l, 6).transpose();
    A.bottomRightCorner(l, l) = phi_.transpose() * seenA.bottomRightCorner(k, k) * phi_;
    const Eigen::LLT<Matrix> root(P);
    if (root.info() != Eigen::Success) return false;
    const Matrix L = root.matrixL();
    const Matrix M = Matrix::Identity(n_, n_) + L.transpose() * A * L;
    const Eigen::LLT<Matrix> cholesky(M);
    if (cholesky.info() != Eigen::Success) return false;
    const Matrix W = cholesky.matrixL().solve(Matrix(L.transpose()));
    result = W.transpose() * W;
    x = result * ofState(seenb);
    return x.allFinite() && result.allFinite();
}

Vector ArticulatedPoseEKFImpl::ofState(const SeenVector& b) const
{
    Vector result(n_);
    result.head(6) = b.head(6);
    result.tail(n_ - 6) = phi_.transpose() * b.tail(m_ - 6);
    return result;
}

// Of a small motion about the centre.
Matx44d ArticulatedPoseEKFImpl::motionOf(const Vector& x) const
{
    const Matx33d R = exponential(Vec3d(x[0], x[1], x[2]));
    const Point3d c = state_.centre;
    return rigidTransform(R, c + Point3d(x[3], x[4], x[5]) - R * c);
}

void ArticulatedPoseEKFImpl::apply(const Vector& x)
{
    state_.correction = nearestRigid(motionOf(x) * state_.correction);
    state_.theta += x.tail(n_ - 6);
    sumOffsets(state_.theta);
    for (size_t i = 0; i < stateOf_.size(); i++)
        if (stateOf_[i] >= 0 && isJaw_[i])
        {
            const double stop = std::min(0., -joints_[i]);
            if (!(offsets_[i] < stop)) continue;
            state_.theta[errors_->stateOf(i) - 6] += stop - offsets_[i];
            moved_[errors_->stateOf(i)] += stop - offsets_[i];
        }
    believe();
    place();
}

void ArticulatedPoseEKFImpl::begin()
{
    A_.setZero(m_, m_);
    b_.setZero(m_);
    biasA_.setZero();
    biasb_.setZero();
    biasSeen_.setZero(m_, 2);
    square_ = 0;
    rows_ = 0;
}

int ArticulatedPoseEKFImpl::addPoints(const CameraModel& camera, const Matx44d& eye_T_camera, const std::vector<int>& parts,
                                      const std::vector<Point2d>& imagePoints, std::vector<uchar>& used, const std::vector<double>& noise,
                                      double tolerance)
{
    CV_Check(tolerance, tolerance >= 0, "tolerance must not be negative");
    CV_CheckEQ(parts.size(), imagePoints.size(), "one image point per part");
    CV_Assert(isRigid(eye_T_camera) && "eye_T_camera: rigid");
    for (size_t i = 0; i < parts.size(); i++)
    {
        CV_Check(parts[i], parts[i] >= 0 && parts[i] < int(model_->keypoints().size()), "parts: no such keypoint");
        if (!(std::abs(imagePoints[i].x) < DBL_MAX && std::abs(imagePoints[i].y) < DBL_MAX))
            CV_Error(Error::StsBadArg, format("imagePoints holds a value that is not finite, of part %d", parts[i]));
    }
    used.assign(parts.size(), 0);
    CV_Check(noise.size(), noise.empty() || noise.size() == parts.size(), "noise: one factor per part");
    for (size_t i = 0; i < noise.size(); i++) CV_Check(noise[i], noise[i] > 0 && noise[i] < DBL_MAX, "noise: factors must be positive");
    int passed = 0;
    for (size_t i = 0; i < parts.size(); i++)
    {
        const ToolModel::Keypoint& keypoint = model_->keypoints()[parts[i]];
        Point2d h;
        Rows2 H;
        if (!row(camera, eye_T_camera, keypoint.link, keypoint.linkPoint, h, H)) continue;
        const Eigen::Vector2d residual(imagePoints[i].x - h.x, imagePoints[i].y - h.y), r = residual + H * seenMoved_;   // r: of the prediction
        double R = std::pow(params_.pointNoise * (noise.empty() ? 1 : noise[i]), 2);
        const Eigen::Matrix2d S = H * predictedSeen_ * H.transpose() + R * Eigen::Matrix2d::Identity();
        if (params_.gate > 0 && r.dot(S.llt().solve(r)) > params_.gate) continue;
        const double square = residual.squaredNorm(), scale = tolerance * tolerance;
        if (params_.gate > 0 && square > params_.gate * (R + scale)) continue;
        R *= std::pow(1 + square / (4 * R + scale), 2);
        used[i] = 1;
        passed++;
        A_.noalias() += H.transpose() * H / R;
        b_.noalias() += H.transpose() * r / R;
        square_ += r.squaredNorm() / R;
        rows_ += 2;
    }
    return passed;
}

int ArticulatedPoseEKFImpl::addContour(const CameraModel& camera, const Matx44d& eye_T_camera, const std::vector<ContourPoint>& points,
                                       double tolerance)
{
    CV_Assert(isRigid(eye_T_camera) && "eye_T_camera: rigid");
    CV_Check(tolerance, tolerance >= 0 && tolerance < DBL_MAX, "tolerance must not be negative");
    for (size_t i = 0; i < points.size(); i++)
    {
        if (points[i].found && !(points[i].deviation > 0)) CV_Error(Error::StsBadArg, "points: an edge needs a positive deviation");
        CV_Check(points[i].link, points[i].link >= 0 && points[i].link < int(axes_.size()), "points: of another tool, no such link");
    }
    const SeenMatrix& known = stateSeen();
    int passed = 0;
    for (size_t i = 0; i < points.size(); i++)
    {
        const ContourPoint& c = points[i];
        if (!c.found) continue;
        Point2d h;
        Rows2 H;
        if (!row(camera, eye_T_camera, c.link, c.linkPoint, h, H)) continue;
        const SeenVector g = (c.normal.x * H.row(0) + c.normal.y * H.row(1)).transpose();
        const double r = c.normal.dot(c.imagePoint + c.normal * c.offset - h);   // of the state; robust about it
        const double sigma2 = std::pow(params_.contourNoise * c.deviation, 2), left = r - edgeBias(c.clipped);
        const double scale = tolerance * tolerance + g.dot(known * g);   // what is not known of the state moves edges, too
        if (!(left * left <= 9 * (sigma2 + scale))) continue;
        const double w = 1 / (std::pow(1 + left * left / (4 * sigma2 + scale), 2) * sigma2 * params_.contourCorrelation);
        const double z = r + g.dot(seenMoved_);
        A_.noalias() += w * g * g.transpose();
        b_.noalias() += w * z * g;
        const Eigen::Vector2d u(1, c.clipped);
        biasA_ += w * u * u.transpose();
        biasb_ += w * z * u;
        biasSeen_.noalias() += w * g * u.transpose();
        square_ += w * z * z;
        rows_++;
        passed++;
    }
    return passed;
}

double ArticulatedPoseEKFImpl::surprise(double rotation, double translation) const
{
    checkGrowth(rotation, translation);
    Vector x, y;
    Matrix result, pushed = predicted_.P;
    for (int i = 0; i < 3; i++)
    {
        pushed(i, i) += rotation * rotation;
        pushed(3 + i, 3 + i) += translation * translation;
    }
    SeenMatrix A;
    SeenVector b;
    double square;
    marginalise(A, b, square);
    if (rows_ == 0 || !posterior(predicted_.P, A, b, x, result) || !posterior(pushed, A, b, y, result)) return 0;
    return 0.5 * ofState(b).dot(y - x);
}

bool ArticulatedPoseEKFImpl::solve()
{
    Vector x;
    Matrix P;
    SeenMatrix A;
    SeenVector b;
    double square;
    marginalise(A, b, square);
    if (rows_ == 0 || !posterior(predicted_.P, A, b, x, P)) return false;
    state_.nis = (square - ofState(b).dot(x)) / rows_;
    bias_ = edgeBiases().inverse() * (biasb_ - biasSeen_.transpose() * seenOf(x));
    state_.P = P;
    const Vector step = x - moved_;
    moved_ = x;
    apply(step);
    return true;
}

Matx22d ArticulatedPoseEKFImpl::imageCovariance(const CameraModel& camera, const Matx44d& eye_T_camera, int part) const
{
    CV_Check(part, part >= 0 && part < int(model_->keypoints().size()), "part: no such keypoint");
    CV_Assert(isRigid(eye_T_camera) && "eye_T_camera: rigid");
    const ToolModel::Keypoint& keypoint = model_->keypoints()[part];
    Point2d h;
    Rows2 H;
    if (!row(camera, eye_T_camera, keypoint.link, keypoint.linkPoint, h, H)) return Matx22d::zeros();
    const Eigen::Matrix2d C = H * stateSeen() * H.transpose();
    return Matx22d(C(0, 0), C(0, 1), C(1, 0), C(1, 1));
}

Matx66d ArticulatedPoseEKFImpl::poseCovariance() const
{
    const Matx44d camera_T_tool = view_.camera_T_base * model_->endEffectorFromLinks(view_.base_T_link);
    Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, maxSeen> J;
    J.setZero(6, m_);
    J.topLeftCorner<3, 3>().setIdentity();
    const int link = model_->endEffectorLink();
    for (size_t i = 0; i < axes_[link].size(); i++)
    {
        const Axis& a = axes_[link][i];
        if (!a.revolute) continue;
        const Eigen::Vector3d axis(a.direction.x, a.direction.y, a.direction.z);
        if (a.state >= 0) J.block<3, 1>(0, a.state) += axis;
        if (params_.delay > 0) J.block<3, 1>(0, m_ - 1) += axis * a.rate;
    }
    Rows3 D;
    motion(link, Point3d(camera_T_tool(0, 3), camera_T_tool(1, 3), camera_T_tool(2, 3)), D);
    J.bottomRows<3>() = D;
    Matx66d result;
    Eigen::Map<Eigen::Matrix<double, 6, 6> >(result.val) = J * stateSeen() * J.transpose();
    return result;
}

}} // namespace cv::surgtrack
