// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "time_offset_fit.hpp"
#if CV_VERSION_MAJOR >= 5
#include "opencv2/geometry.hpp"
#else
#include "opencv2/calib3d.hpp"
#endif
#include <Eigen/Dense>

// x      unknowns: the offset; per tool the errors of its joints; per tool and block the correction: rotation w, translation t
// A, b   normal equations, A dx = b
// J      d(u, v) / dx of a point: offset, joints, correction

namespace cv { namespace surgtrack {

namespace {

const double pointDeviation = 3;                              // of a match [pixel at 720 px width]
const double handEyeAngle = 4 * CV_PI / 180, handEyeShift = 0.008;   // the error of a hand-eye calibration, as ToolPoseEKF has it
const double tieAngle = 0.3 * CV_PI / 180, tieShift = 0.0005;   // change of the correction from block to block, while no one moves the camera
const double velocityStep = 0.04;                             // [s]; velocities over a shorter time are those of noise
const double minDepth = 1e-3;                                 // [m]

inline Vec3d rotate(const Matx33d& R, const Vec3d& v) { return R * v; }

Vec3d rotationVector(const Matx33d& R)
{
    Vec3d v;
    Rodrigues(R, v);
    return v;
}

inline Vec3d rowOf(const Mat& points, int i) { return Vec3d(points.ptr<double>(i)); }

} // namespace

TimeOffsetFit::TimeOffsetFit(const Sequence& sequence, const CameraModel& camera, const std::vector<OffsetTool>& tools, int blocks)
    : sequence_(sequence), camera_(camera), pixelScale_(camera.imageSize().width / double(referenceWidth)), tools_(tools), blocks_(blocks),
      unknowns_(1), pivots_(tools.size()), offset_(0), startOffset_(0), deviation_(DBL_MAX)
{
    for (size_t i = 0; i < tools.size(); i++)
    {
        jointColumns_.push_back(unknowns_);
        unknowns_ += int(tools[i].coordinates.size());
        correctionColumns_.push_back(unknowns_);
        unknowns_ += 6 * blocks;
        // About a place where the tool works, so that rotations and translations are independent.
        Mat points;
        CV_Assert(keypoints(int(i), sequence.firstTime(int(i)), points, 0));
        for (int k = 0; k < points.rows; k++)
        {
            const Vec3d p = rowOf(points, k);
            const Point3d n = transform(tools[i].nominal_T_base, Point3d(p));
            pivots_[i] += Vec3d(n.x, n.y, n.z) * (1. / points.rows);
        }
    }
    start(0);
}

void TimeOffsetFit::start(double offset)
{
    offset_ = startOffset_ = offset;
    deviation_ = DBL_MAX;
    jointOffsets_.clear();
    corrections_.clear();
    Correction none;
    none.R = Matx33d::eye();
    for (size_t i = 0; i < tools_.size(); i++)
    {
        jointOffsets_.push_back(std::vector<double>(tools_[i].coordinates.size(), 0.));
        corrections_.push_back(std::vector<Correction>(blocks_, none));
    }
}

// Keypoints in the base at a time of the readings, with the errors of the joints taken out.
bool TimeOffsetFit::keypoints(int tool, double time, Mat& basePoints, Mat* jacobian) const
{
    std::vector<double> joints;
    if (!sequence_.jointsAt(tool, time, joints, tools_[tool].coordinates)) return false;
    if (!jointOffsets_.empty())
        for (size_t i = 0; i < joints.size(); i++) joints[i] += jointOffsets_[tool][i];
    if (jacobian) tools_[tool].model->keypointPositions(joints, basePoints, *jacobian);
    else tools_[tool].model->keypointPositions(joints, basePoints);
    return true;
}

// The same with velocities [m/s], at the ends of the records to one side.
bool TimeOffsetFit::motion(int tool, double time, Mat& basePoints, Mat& jacobian, Mat& velocities) const
{
    if (!keypoints(tool, time, basePoints, &jacobian)) return false;
    Mat before, after;
    const bool hasBefore = keypoints(tool, time - velocityStep, before, 0), hasAfter = keypoints(tool, time + velocityStep, after, 0);
    const double span = (hasBefore + hasAfter) * velocityStep;
    if (span <= 0) return false;
    velocities = ((hasAfter ? after : basePoints) - (hasBefore ? before : basePoints)) / span;
    return true;
}

bool TimeOffsetFit::view(int tool, int block, double time, ToolView& view) const
{
    std::vector<double> joints;
    if (!sequence_.jointsAt(tool, time + offset_, joints, tools_[tool].coordinates)) return false;
    for (size_t i = 0; i < joints.size(); i++) joints[i] += jointOffsets_[tool][i];
    tools_[tool].model->forwardKinematics(joints, view.base_T_link);
    const Correction& c = corrections_[tool][block];
    const Vec3d shift = pivots_[tool] + c.t - c.R * pivots_[tool];
    Matx44d camera_T_nominal = Matx44d::eye();
    for (int r = 0; r < 3; r++)
    {
        for (int k = 0; k < 3; k++) camera_T_nominal(r, k) = c.R(r, k);
        camera_T_nominal(r, 3) = shift[r];
    }
    view.camera_T_base = camera_T_nominal * tools_[tool].nominal_T_base;
    return true;
}

double TimeOffsetFit::residual(int tool, const ToolView& view, const PartMatch& match) const
{
    const ToolModel::Keypoint& k = tools_[tool].model->keypoints()[match.part];
    const Point3d p = transform(view.camera_T_base * view.base_T_link[k.link], k.linkPoint);
    return p.z > minDepth ? norm(camera_.project(p) - match.imagePoint) : DBL_MAX;
}

bool TimeOffsetFit::run(const std::vector<OffsetMeasurement>& measurements, double scale, int iterations, double reach)
{
    typedef Eigen::MatrixXd Matrix;
    typedef Eigen::VectorXd Vector;
    Matrix A(unknowns_, unknowns_);
    Vector b(unknowns_);
    const double s = 1 / (pointDeviation * pixelScale_);            // residuals are in deviations
    const double limit2 = std::pow(scale / pointDeviation, 2);
    deviation_ = DBL_MAX;
    for (int iteration = 0; iteration <= iterations; iteration++)   // the last one is for the covariance only
    {
        A.setZero();
        b.setZero();
        double sum2 = 0, weights = 0, found = 0;
        int points = 0;
        for (size_t i = 0; i < measurements.size(); i++)
        {
            const OffsetMeasurement& m = measurements[i];
            const OffsetTool& tool = tools_[m.tool];
            Mat basePoints, jacobian, velocities;
            if (!motion(m.tool, m.time + offset_, basePoints, jacobian, velocities)) continue;
            const Matx33d nominal_R_base = tool.nominal_T_base.get_minor<3, 3>(0, 0);
            const Correction& c = corrections_[m.tool][m.block];
            const Matx33d camera_R_base = c.R * nominal_R_base;
            const int joints = int(tool.coordinates.size()), size = 7 + joints;
            double frameWeight = 0;
            for (size_t k = 0; k < m.inliers.size(); k++)
            {
                const int part = m.inliers[k].part;
                const Point3d nominal = transform(tool.nominal_T_base, Point3d(rowOf(basePoints, part)));
                const Vec3d arm = c.R * (Vec3d(nominal.x, nominal.y, nominal.z) - pivots_[m.tool]), v = arm + pivots_[m.tool] + c.t;
                if (v[2] < minDepth) continue;
                Matx23d P;
                const Point2d h = camera_.project(Point3d(v), &P);
                const Vec2d e = Vec2d(m.inliers[k].imagePoint.x - h.x, m.inliers[k].imagePoint.y - h.y) * s;
                Eigen::Matrix<double, 2, Eigen::Dynamic> J(2, size);
                const Vec2d dOffset = P * (camera_R_base * rowOf(velocities, part)) * s;
                const Matx33d cross(0, arm[2], -arm[1], -arm[2], 0, arm[0], arm[1], -arm[0], 0);   // dv / dw = -[arm]x
                const Matx23d dRotation = P * cross * s, dTranslation = P * s;
                for (int r = 0; r < 2; r++)
                {
                    J(r, 0) = dOffset[r];
                    for (int j = 0; j < 3; j++)
                    {
                        J(r, 1 + joints + j) = dRotation(r, j);
                        J(r, 4 + joints + j) = dTranslation(r, j);
                    }
                }
                for (int j = 0; j < joints; j++)
                {
                    const Vec3d d(jacobian.at<double>(3 * part, j), jacobian.at<double>(3 * part + 1, j), jacobian.at<double>(3 * part + 2, j));
                    const Vec2d dJoint = P * (camera_R_base * d) * s;
                    J(0, 1 + j) = dJoint[0];
                    J(1, 1 + j) = dJoint[1];
                }
                const double w = 1 / std::pow(1 + e.dot(e) / limit2, 2);   // Geman and McClure
                const Eigen::MatrixXd N = w * J.transpose() * J;
                const Eigen::VectorXd g = w * J.transpose() * Eigen::Vector2d(e[0], e[1]);
                std::vector<int> columns(size);
                for (int j = 1; j <= joints; j++) columns[j] = jointColumns_[m.tool] + j - 1;
                for (int j = 0; j < 6; j++) columns[1 + joints + j] = correctionColumn(m.tool, m.block) + j;
                for (int r = 0; r < size; r++)
                {
                    b[columns[r]] += g[r];
                    for (int j = 0; j < size; j++) A(columns[r], columns[j]) += N(r, j);
                }
                sum2 += w * e.dot(e);
                weights += w;
                frameWeight += w;
                points++;
            }
            found += frameWeight > 1;
        }
        if (points < 8 || found < 3) return false;

        // What is known beforehand, and the ties between blocks.
        for (size_t i = 0; i < tools_.size(); i++)
        {
            for (size_t j = 0; j < tools_[i].coordinates.size(); j++)
            {
                const double w = 1 / std::pow(tools_[i].deviations[j], 2);
                const int column = jointColumns_[i] + int(j);
                A(column, column) += w;
                b[column] -= w * jointOffsets_[i][j];
            }
            for (int block = 0; block < blocks_; block++)
            {
                const Correction& c = corrections_[i][block];
                const Vec3d w = rotationVector(c.R);
                const int column = correctionColumn(int(i), block);
                for (int j = 0; j < 6; j++)
                {
                    const double weight = 1 / std::pow(j < 3 ? handEyeAngle : handEyeShift, 2) / blocks_;
                    A(column + j, column + j) += weight;
                    b[column + j] -= weight * (j < 3 ? w[j] : c.t[j - 3]);
                }
                if (block == 0) continue;
                const Correction& last = corrections_[i][block - 1];
                const Vec3d dw = rotationVector(c.R * last.R.t()) * (1 / tieAngle), dt = (c.t - last.t) * (1 / tieShift);
                const double robust = 1 / (1 + (dw.dot(dw) + dt.dot(dt)) / 9);   // Cauchy: a tie of more than three deviations gives way
                const int previous = correctionColumn(int(i), block - 1);
                for (int j = 0; j < 6; j++)
                {
                    const double deviation = j < 3 ? tieAngle : tieShift, weight = robust / (deviation * deviation);
                    const double difference = (j < 3 ? dw[j] : dt[j - 3]) * deviation;
                    A(column + j, column + j) += weight;
                    A(previous + j, previous + j) += weight;
                    A(column + j, previous + j) -= weight;
                    A(previous + j, column + j) -= weight;
                    b[column + j] -= weight * difference;
                    b[previous + j] += weight * difference;
                }
            }
        }
        A(0, 0) += 1 / (reach * reach);
        b[0] -= (offset_ - startOffset_) / (reach * reach);
        const Eigen::LLT<Matrix> cholesky(A);
        if (cholesky.info() != Eigen::Success) return false;
        if (iteration == iterations)
        {
            // The points of a tool in a frame are wrong together (template, bending, time stamp): they count as one.
            const double variance = std::max(0.25, sum2 / std::max(1., 2 * weights - 7)) * points / std::max(1., found);
            deviation_ = std::sqrt(cholesky.solve(Vector::Unit(unknowns_, 0))[0] * variance);
            break;
        }
        const Vector dx = cholesky.solve(b);
        offset_ = std::min(std::max(offset_ + dx[0], startOffset_ - reach), startOffset_ + reach);
        for (size_t i = 0; i < tools_.size(); i++)
        {
            for (size_t j = 0; j < tools_[i].coordinates.size(); j++) jointOffsets_[i][j] += dx[jointColumns_[i] + int(j)];
            for (int block = 0; block < blocks_; block++)
            {
                const int column = correctionColumn(int(i), block);
                Matx33d dR;
                Rodrigues(Vec3d(dx[column], dx[column + 1], dx[column + 2]), dR);
                Correction& c = corrections_[i][block];
                c.R = dR * c.R;
                c.t += Vec3d(dx[column + 3], dx[column + 4], dx[column + 5]);
            }
        }
    }
    return true;
}

}} // namespace cv::surgtrack
