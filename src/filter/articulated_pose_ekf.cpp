// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include <Eigen/Dense>
#include "opencv2/surgtrack/articulated_pose_ekf.hpp"
#include "base/checks.hpp"
#include "base/geometry.hpp"

// x      error of the state: (omega [rad], v [m], d [rad or m])
// P, Q   covariance of the error, of the process noise
// h, r   a measurement's row dh / dx, and its innovation
// A, b   information of all measurements: sum of h h^T / sigma^2, sum of h r / sigma^2

namespace cv { namespace surgtrack {

void ArticulatedPoseEKF::reset()
{
    reset(Matx44d::eye());
}

void ArticulatedPoseEKF::copyTo(const Ptr<ArticulatedPoseEKF>& other) const
{
    CV_Assert(other && "other: a filter to be changed");
    copyTo(*other);
}

ArticulatedPoseEKF::Params::Params()
    : initialRotation(4 * CV_PI / 180), initialTranslation(0.008), processRotation(0.1 * CV_PI / 180), processTranslation(0.0003),
      processJoint(0.03), pointNoise(3), gate(13.8), contourNoise(1), jointOffsets(true), contourCorrelation(18)
{
}

namespace {

const int maxOffsets = 10, maxStates = 6 + maxOffsets;
// Bounded: no memory is taken. Not aligned: members of objects on the heap, where C++11 promises 16 bytes only.
typedef Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::DontAlign, maxStates, 1> Vector;
typedef Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::DontAlign, maxStates, maxStates> Matrix;

typedef Eigen::Matrix<double, 2, Eigen::Dynamic, 0, 2, maxStates> Rows2;
typedef Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, maxStates> Rows3;

const double nearest = 1e-3;   // [m]; points nearer than this are not seen

void checkParams(const ArticulatedPoseEKF::Params& p)
{
    CV_Check(p.initialRotation, p.initialRotation > 0 && p.initialRotation < DBL_MAX, "Params::initialRotation must be positive");
    CV_Check(p.initialTranslation, p.initialTranslation > 0 && p.initialTranslation < DBL_MAX, "Params::initialTranslation must be positive");
    CV_Check(p.processRotation, p.processRotation >= 0 && p.processRotation < DBL_MAX, "Params::processRotation must not be negative");
    CV_Check(p.processTranslation, p.processTranslation >= 0 && p.processTranslation < DBL_MAX, "Params::processTranslation must not be negative");
    CV_Check(p.processJoint, p.processJoint >= 0 && p.processJoint < DBL_MAX, "Params::processJoint must not be negative");
    CV_Check(p.pointNoise, p.pointNoise > 0 && p.pointNoise < DBL_MAX, "Params::pointNoise must be positive");
    CV_Check(p.gate, p.gate < DBL_MAX, "Params::gate must be a number");
    CV_Check(p.contourNoise, p.contourNoise > 0 && p.contourNoise < DBL_MAX, "Params::contourNoise must be positive");
    CV_Check(p.contourCorrelation, p.contourCorrelation >= 1 && p.contourCorrelation < DBL_MAX, "Params::contourCorrelation must be 1 or more");
}

// Standard deviations that are added to P.
void checkGrowth(double rotation, double translation)
{
    CV_Check(rotation, rotation >= 0 && rotation < DBL_MAX, "rotation must not be negative");
    CV_Check(translation, translation >= 0 && translation < DBL_MAX, "translation must not be negative");
}

struct State
{
    Matx44d correction;
    std::vector<double> offsets;
    Matrix P;
    Point3d centre;       // what omega turns about, in the camera frame
    bool placed;          // whether the centre is that of a frame; before, P is about wherever the tool will be
    double nis;
};

class ArticulatedPoseEKFImpl CV_FINAL : public ArticulatedPoseEKF
{
public:
    ArticulatedPoseEKFImpl(const Ptr<ToolModel>& model, const Matx44d& nominal_T_base, const Params& params);

    void reset(const Matx44d& correction) CV_OVERRIDE;
    void predict(const std::vector<double>& joints, double growth) CV_OVERRIDE;
    void inflate(double rotation, double translation) CV_OVERRIDE;
    void undo() CV_OVERRIDE;
    void begin() CV_OVERRIDE;
    int addPoints(const CameraModel& camera, const Matx44d& eye_T_camera, const std::vector<int>& parts,
                  const std::vector<Point2d>& imagePoints, std::vector<uchar>& used, const std::vector<double>& noise,
                  double tolerance) CV_OVERRIDE;
    int addContour(const CameraModel& camera, const Matx44d& eye_T_camera, const std::vector<ContourPoint>& points,
                   double tolerance) CV_OVERRIDE;
    double surprise(double rotation, double translation) const CV_OVERRIDE;
    bool solve() CV_OVERRIDE;
    void copyTo(ArticulatedPoseEKF& other) const CV_OVERRIDE;
    const ToolView& view() const CV_OVERRIDE { return view_; }
    Matx44d correction() const CV_OVERRIDE { return state_.correction; }
    const std::vector<double>& offsets() const CV_OVERRIDE { return state_.offsets; }
    Mat covariance() const CV_OVERRIDE;
    double nis() const CV_OVERRIDE { return state_.nis; }
    Matx22d imageCovariance(const CameraModel& camera, const Matx44d& eye_T_camera, int part) const CV_OVERRIDE;
    Matx66d poseCovariance() const CV_OVERRIDE;

private:
    struct Axis
    {
        int state;           // index of the offset in x
        Point3d direction, origin;   // in the camera frame; direction times the joint's scale
        bool revolute;
    };

    void place();
    bool row(const CameraModel& camera, const Matx44d& eye_T_camera, int link, const Point3d& linkPoint, Point2d& imagePoint,
             Rows2& H) const;
    void motion(int link, const Point3d& p, Rows3& D) const;
    bool posterior(const Matrix& P, Vector& x, Matrix& result) const;
    void apply(const Vector& x);

    Ptr<ToolModel> model_;
    Matx44d nominal_T_base_;
    Params params_;
    std::vector<int> stateOf_;        // of a coordinate: index in x, or -1
    std::vector<double> deviations_;  // of a coordinate
    std::vector<uchar> isJaw_;        // of a coordinate
    int n_;                           // of the state
    std::vector<double> joints_;      // readings of this frame
    std::vector<double> corrected_;
    ToolView view_;
    std::vector<std::vector<Axis> > axes_;   // of a link: the joints that move it
    State state_, predicted_;

    Matrix A_;
    Vector b_;
    double square_;                   // sum of r^2 / sigma^2
    int rows_;
    Vector moved_;                    // x of the state since predict()
};

ArticulatedPoseEKFImpl::ArticulatedPoseEKFImpl(const Ptr<ToolModel>& model, const Matx44d& nominal_T_base, const Params& params)
    : model_(model), nominal_T_base_(nominal_T_base), params_(params)
{
    CV_Assert(model);
    CV_Assert(isRigid(nominal_T_base) && "nominal_T_base: rigid");
    checkParams(params);
    deviations_ = model->offsetDeviations();
    if (!params.jointOffsets) std::fill(deviations_.begin(), deviations_.end(), 0.);
    const std::vector<ToolModel::Link>& links = model->links();
    n_ = 6;
    for (size_t i = 0; i < deviations_.size(); i++)
    {
        stateOf_.push_back(deviations_[i] > 0 && n_ < maxStates ? n_++ : -1);
        // Two links that one coordinate moves against each other are jaws, closed at 0.
        bool positive = false, negative = false;
        for (size_t l = 0; l < links.size(); l++)
            if (links[l].coordinate == int(i)) (links[l].scale > 0 ? positive : negative) = true;
        isJaw_.push_back(positive && negative);
    }
    joints_.assign(deviations_.size(), 0.);
    axes_.resize(links.size());
    reset(Matx44d::eye());
}

void ArticulatedPoseEKFImpl::reset(const Matx44d& correction)
{
    CV_Assert(isRigid(correction) && "correction: rigid");
    state_.correction = correction;
    state_.offsets.assign(deviations_.size(), 0.);
    state_.P = Matrix::Zero(n_, n_);
    for (int i = 0; i < 3; i++)
    {
        state_.P(i, i) = params_.initialRotation * params_.initialRotation;
        state_.P(3 + i, 3 + i) = params_.initialTranslation * params_.initialTranslation;
    }
    for (size_t i = 0; i < stateOf_.size(); i++)
        if (stateOf_[i] >= 0) state_.P(stateOf_[i], stateOf_[i]) = deviations_[i] * deviations_[i];
    state_.nis = 0;
    state_.placed = false;
    place();
    predicted_ = state_;
    moved_.setZero(n_);
    begin();
}

// Poses of the links and axes of the joints, from readings and state. The centre stays.
void ArticulatedPoseEKFImpl::place()
{
    corrected_.resize(joints_.size());
    for (size_t i = 0; i < joints_.size(); i++)
    {
        corrected_[i] = joints_[i] + state_.offsets[i];
        if (isJaw_[i]) corrected_[i] = std::max(corrected_[i], std::min(joints_[i], 0.));
    }
    model_->forwardKinematics(corrected_, view_.base_T_link);
    view_.camera_T_base = state_.correction * nominal_T_base_;
    const std::vector<ToolModel::Link>& links = model_->links();
    for (size_t l = 0; l < links.size(); l++)
    {
        axes_[l].clear();
        for (int i = int(l); i >= 0; i = links[i].parent)
        {
            if (links[i].coordinate < 0 || stateOf_[links[i].coordinate] < 0) continue;
            const Matx44d T = view_.camera_T_base * view_.base_T_link[i];
            Axis a;
            a.state = stateOf_[links[i].coordinate];
            a.direction = Point3d(T(0, 2), T(1, 2), T(2, 2)) * links[i].scale;
            a.origin = Point3d(T(0, 3), T(1, 3), T(2, 3));
            a.revolute = links[i].jointType == ToolModel::JOINT_REVOLUTE;
            axes_[l].push_back(a);
        }
    }
}

void ArticulatedPoseEKFImpl::predict(const std::vector<double>& joints, double growth)
{
    CV_CheckEQ(joints.size(), stateOf_.size(), "joints: one value per coordinate");
    checkFinite(joints, "joints");
    CV_Check(growth, growth >= 0 && growth < DBL_MAX, "growth must not be negative");
    joints_ = joints;
    place();
    const std::vector<ToolModel::Keypoint>& keypoints = model_->keypoints();
    Point3d centre;
    for (size_t i = 0; i < keypoints.size(); i++)
        centre += transform(view_.camera_T_base * view_.base_T_link[keypoints[i].link], keypoints[i].linkPoint) * (1. / keypoints.size());
    const Point3d d = centre - state_.centre;
    state_.centre = centre;
    // v at the new centre = v + omega x d
    Matrix T = Matrix::Identity(n_, n_);
    T(3, 1) = d.z; T(3, 2) = -d.y; T(4, 0) = -d.z; T(4, 2) = d.x; T(5, 0) = d.y; T(5, 1) = -d.x;
    if (state_.placed) state_.P = (T * state_.P * T.transpose()).eval();
    state_.placed = true;
    for (int i = 0; i < 3; i++)
    {
        state_.P(i, i) += growth * growth * params_.processRotation * params_.processRotation;
        state_.P(3 + i, 3 + i) += growth * growth * params_.processTranslation * params_.processTranslation;
    }
    for (size_t i = 0; i < stateOf_.size(); i++)
        if (stateOf_[i] >= 0) state_.P(stateOf_[i], stateOf_[i]) += std::pow(growth * params_.processJoint * deviations_[i], 2);
    predicted_ = state_;
    moved_.setZero(n_);
    begin();
}

void ArticulatedPoseEKFImpl::inflate(double rotation, double translation)
{
    checkGrowth(rotation, translation);
    for (int i = 0; i < 3; i++)
    {
        predicted_.P(i, i) += rotation * rotation;
        predicted_.P(3 + i, 3 + i) += translation * translation;
    }
    undo();
}

void ArticulatedPoseEKFImpl::undo()
{
    state_ = predicted_;
    moved_.setZero(n_);
    place();
}

// dp / dx of a point of a link, in the camera frame
void ArticulatedPoseEKFImpl::motion(int link, const Point3d& p, Rows3& D) const
{
    D.setZero(3, n_);
    const Point3d a = p - state_.centre;
    D(0, 1) = a.z; D(0, 2) = -a.y; D(1, 0) = -a.z; D(1, 2) = a.x; D(2, 0) = a.y; D(2, 1) = -a.x;
    D(0, 3) = D(1, 4) = D(2, 5) = 1;
    const std::vector<Axis>& axes = axes_[link];
    for (size_t i = 0; i < axes.size(); i++)
    {
        const Point3d u = axes[i].revolute ? axes[i].direction.cross(p - axes[i].origin) : axes[i].direction;
        D(0, axes[i].state) += u.x;
        D(1, axes[i].state) += u.y;
        D(2, axes[i].state) += u.z;
    }
}

bool ArticulatedPoseEKFImpl::row(const CameraModel& camera, const Matx44d& eye_T_camera, int link, const Point3d& linkPoint, Point2d& imagePoint,
                                 Rows2& H) const
{
    const Point3d p = transform(view_.camera_T_base * view_.base_T_link[link], linkPoint), q = transform(eye_T_camera, p);
    if (q.z < nearest) return false;
    Matx23d J;
    imagePoint = camera.project(q, &J);
    const Matx23d JR = J * eye_T_camera.get_minor<3, 3>(0, 0);
    Rows3 D;
    motion(link, p, D);
    H = Eigen::Map<const Eigen::Matrix<double, 2, 3, Eigen::RowMajor> >(JR.val) * D;
    return true;
}

// x = (P^-1 + A)^-1 b with P = L L^T: L (I + L^T A L)^-1 L^T b; the posterior is symmetric and positive by its form.
bool ArticulatedPoseEKFImpl::posterior(const Matrix& P, Vector& x, Matrix& result) const
{
    const Eigen::LLT<Matrix> root(P);
    if (root.info() != Eigen::Success) return false;
    const Matrix L = root.matrixL();
    const Matrix M = Matrix::Identity(n_, n_) + L.transpose() * A_ * L;
    const Eigen::LLT<Matrix> cholesky(M);
    if (cholesky.info() != Eigen::Success) return false;
    const Matrix W = cholesky.matrixL().solve(Matrix(L.transpose()));
    result = W.transpose() * W;
    x = result * b_;
    return x.allFinite();
}

void ArticulatedPoseEKFImpl::apply(const Vector& x)
{
    const Matx33d R = exponential(Vec3d(x[0], x[1], x[2]));
    const Point3d c = state_.centre, t = c + Point3d(x[3], x[4], x[5]) - R * c;
    const Matx44d motion(R(0, 0), R(0, 1), R(0, 2), t.x, R(1, 0), R(1, 1), R(1, 2), t.y, R(2, 0), R(2, 1), R(2, 2), t.z, 0, 0, 0, 1);
    state_.correction = nearestRigid(motion * state_.correction);
    for (size_t i = 0; i < stateOf_.size(); i++)
        if (stateOf_[i] >= 0)
        {
            state_.offsets[i] += x[stateOf_[i]];
            if (isJaw_[i]) state_.offsets[i] = std::max(state_.offsets[i], std::min(0., -joints_[i]));
        }
    place();
}

void ArticulatedPoseEKFImpl::begin()
{
    A_.setZero(n_, n_);
    b_.setZero(n_);
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
        const Eigen::Vector2d residual(imagePoints[i].x - h.x, imagePoints[i].y - h.y), r = residual + H * moved_;   // r: of the prediction
        double R = std::pow(params_.pointNoise * (noise.empty() ? 1 : noise[i]), 2);
        const Eigen::Matrix2d S = H * predicted_.P * H.transpose() + R * Eigen::Matrix2d::Identity();
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
    int passed = 0;
    for (size_t i = 0; i < points.size(); i++)
    {
        const ContourPoint& c = points[i];
        if (!c.found) continue;
        Point2d h;
        Rows2 H;
        if (!row(camera, eye_T_camera, c.link, c.linkPoint, h, H)) continue;
        const Vector g = (c.normal.x * H.row(0) + c.normal.y * H.row(1)).transpose();
        const double r = c.normal.dot(c.imagePoint + c.normal * c.offset - h);   // of the state; robust about it
        const double sigma2 = std::pow(params_.contourNoise * c.deviation, 2), scale = tolerance * tolerance;
        if (!(r * r <= 9 * (sigma2 + scale))) continue;
        const double w = 1 / (std::pow(1 + r * r / (4 * sigma2 + scale), 2) * sigma2 * params_.contourCorrelation);
        const double z = r + g.dot(moved_);
        A_.noalias() += w * g * g.transpose();
        b_.noalias() += w * z * g;
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
    if (rows_ == 0 || !posterior(predicted_.P, x, result) || !posterior(pushed, y, result)) return 0;
    return 0.5 * b_.dot(y - x);
}

bool ArticulatedPoseEKFImpl::solve()
{
    Vector x;
    Matrix P;
    if (rows_ == 0 || !posterior(predicted_.P, x, P)) return false;
    state_.nis = (square_ - b_.dot(x)) / rows_;
    state_.P = P;
    const Vector step = x - moved_;
    apply(step);
    moved_ = x;
    // Where the jaw met its stop the state is not at x.
    for (size_t i = 0; i < stateOf_.size(); i++)
        if (stateOf_[i] >= 0) moved_[stateOf_[i]] = state_.offsets[i] - predicted_.offsets[i];
    return true;
}

void ArticulatedPoseEKFImpl::copyTo(ArticulatedPoseEKF& _other) const
{
    ArticulatedPoseEKFImpl* const other = dynamic_cast<ArticulatedPoseEKFImpl*>(&_other);
    CV_Assert(other && other->model_ == model_ && "other: a filter of the same tool");
    other->state_ = state_;
    other->predicted_ = predicted_;
    other->moved_ = moved_;
    other->joints_ = joints_;
    other->place();
}

Mat ArticulatedPoseEKFImpl::covariance() const
{
    Mat_<double> result(n_, n_);
    for (int r = 0; r < n_; r++)
        for (int c = 0; c < n_; c++) result(r, c) = state_.P(r, c);
    return std::move(result);
}

Matx22d ArticulatedPoseEKFImpl::imageCovariance(const CameraModel& camera, const Matx44d& eye_T_camera, int part) const
{
    CV_Check(part, part >= 0 && part < int(model_->keypoints().size()), "part: no such keypoint");
    CV_Assert(isRigid(eye_T_camera) && "eye_T_camera: rigid");
    const ToolModel::Keypoint& keypoint = model_->keypoints()[part];
    Point2d h;
    Rows2 H;
    if (!row(camera, eye_T_camera, keypoint.link, keypoint.linkPoint, h, H)) return Matx22d::zeros();
    const Eigen::Matrix2d C = H * state_.P * H.transpose();
    return Matx22d(C(0, 0), C(0, 1), C(1, 0), C(1, 1));
}

Matx66d ArticulatedPoseEKFImpl::poseCovariance() const
{
    const Matx44d camera_T_tool = view_.camera_T_base * model_->endEffectorFromLinks(view_.base_T_link);
    Eigen::Matrix<double, 6, Eigen::Dynamic, 0, 6, maxStates> J;
    J.setZero(6, n_);
    J.topLeftCorner<3, 3>().setIdentity();
    const int link = model_->endEffectorLink();
    for (size_t i = 0; i < axes_[link].size(); i++)
    {
        const Axis& a = axes_[link][i];
        if (a.revolute) J.block<3, 1>(0, a.state) += Eigen::Vector3d(a.direction.x, a.direction.y, a.direction.z);
    }
    Rows3 D;
    motion(link, Point3d(camera_T_tool(0, 3), camera_T_tool(1, 3), camera_T_tool(2, 3)), D);
    J.bottomRows<3>() = D;
    Matx66d result;
    Eigen::Map<Eigen::Matrix<double, 6, 6> >(result.val) = J * state_.P * J.transpose();
    return result;
}

} // namespace

Ptr<ArticulatedPoseEKF> ArticulatedPoseEKF::create(const Ptr<ToolModel>& model, const Matx44d& nominal_T_base, const Params& params)
{
    return makePtr<ArticulatedPoseEKFImpl>(model, nominal_T_base, params);
}

}} // namespace cv::surgtrack
