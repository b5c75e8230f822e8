// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "lab/time_offset/time_offset_fit.hpp"
#include <Eigen/Dense>
#include "base/geometry.hpp"

// x      unknowns: the offset; per tool the errors of its joints; per tool and block the correction: rotation w, translation t
// A, b   normal equations, A dx = b, of residuals divided by their deviations
// e      residual of a point, w its weight
// J      d(u, v) / dx of a point: offset, joints, correction

namespace cv { namespace surgtrack {

namespace {

const double pointDeviation = 3;                              // of a match [pixel at 720 px width]
const double handEyeAngle = 4 * CV_PI / 180, handEyeShift = 0.008;   // the error of a hand-eye calibration, as ToolPoseEKF has it
const double tieAngle = 0.3 * CV_PI / 180, tieShift = 0.0005;   // change of the correction from block to block, while no one moves the camera
const double velocityStep = 0.04;                             // [s]; velocities over a shorter time are those of noise
const int minMeasurements = 3;                                // fewer do not even determine one correction
const double leastVariance = 0.25;                            // no match is better than half of pointDeviation

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
        CV_Assert(keypoints(int(i), sequence.firstTime(tools[i].index), points, 0));
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
    if (!sequence_.jointsAt(tools_[tool].index, time, joints, tools_[tool].coordinates)) return false;
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
    if (!sequence_.jointsAt(tools_[tool].index, time + offset_, joints, tools_[tool].coordinates)) return false;
    for (size_t i = 0; i < joints.size(); i++) joints[i] += jointOffsets_[tool][i];
    tools_[tool].model->forwardKinematics(joints, view.base_T_link);
    const Correction& c = corrections_[tool][block];
    const Vec3d shift = pivots_[tool] + c.t - c.R * pivots_[tool];
    view.camera_T_base = rigidTransform(c.R, shift) * tools_[tool].nominal_T_base;
    return true;
}

double TimeOffsetFit::residual(int tool, const ToolView& view, const PartMatch& match) const
{
    const ToolModel::Keypoint& k = tools_[tool].model->keypoints()[match.part];
    const Point3d p = transform(view.camera_T_base * view.base_T_link[k.link], k.linkPoint);
    return p.z > nearestDepth ? norm(camera_.project(p) - match.imagePoint) : DBL_MAX;
}

struct TimeOffsetFit::Normals
{
    explicit Normals(int unknowns) : A(Eigen::MatrixXd::Zero(unknowns, unknowns)), b(Eigen::VectorXd::Zero(unknowns)), sum2(0), weights(0), points(0), found(0) {}

    Eigen::MatrixXd A;
    Eigen::VectorXd b;
    double sum2, weights;     // weighted squares of residuals [deviations^2], their weights
    int points, found;        // found: measurements with at least one good point
};

// The points of one tool in one frame.
// limit2: squared residual from which on points count less [deviations^2]
void TimeOffsetFit::addMeasurement(const OffsetMeasurement& m, double limit2, Normals& normals) const
{
    Mat basePoints, jacobian, velocities;
    if (!motion(m.tool, m.time + offset_, basePoints, jacobian, velocities)) return;
    const OffsetTool& tool = tools_[m.tool];
    const Correction& c = corrections_[m.tool][m.block];
    const Matx33d camera_R_base = c.R * tool.nominal_T_base.get_minor<3, 3>(0, 0);
    const int joints = int(tool.coordinates.size()), size = 7 + joints;
    std::vector<int> columns(size);   // of x; 0 is the offset
    for (int j = 1; j <= joints; j++) columns[j] = jointColumns_[m.tool] + j - 1;
    for (int j = 0; j < 6; j++) columns[1 + joints + j] = correctionColumns_[m.tool] + 6 * m.block + j;
    Eigen::Matrix<double, 2, Eigen::Dynamic> J(2, size);
    const double s = 1 / (pointDeviation * pixelScale_);   // residuals are in deviations
    double weights = 0;
    for (size_t k = 0; k < m.inliers.size(); k++)
    {
        const int part = m.inliers[k].part;
        const Vec3d nominal = Vec3d(transform(tool.nominal_T_base, Point3d(rowOf(basePoints, part))));
        const Vec3d arm = c.R * (nominal - pivots_[m.tool]), v = arm + pivots_[m.tool] + c.t;
        if (v[2] < nearestDepth) continue;
        Matx23d P;
        const Point2d h = camera_.project(Point3d(v), &P);
        const Eigen::Vector2d e(s * (m.inliers[k].imagePoint.x - h.x), s * (m.inliers[k].imagePoint.y - h.y));
        const Matx33d cross(0, arm[2], -arm[1], -arm[2], 0, arm[0], arm[1], -arm[0], 0);   // dv / dw = -[arm]x
        const Matx23d dRotation = P * cross * s, dTranslation = P * s, dBase = P * camera_R_base * s;
        const Vec2d dOffset = dBase * rowOf(velocities, part);
        for (int r = 0; r < 2; r++)
        {
            J(r, 0) = dOffset[r];
            for (int j = 0; j < joints; j++)
                J(r, 1 + j) = dBase(r, 0) * jacobian.at<double>(3 * part, j) + dBase(r, 1) * jacobian.at<double>(3 * part + 1, j)
                              + dBase(r, 2) * jacobian.at<double>(3 * part + 2, j);
            for (int j = 0; j < 3; j++)
            {
                J(r, 1 + joints + j) = dRotation(r, j);
                J(r, 4 + joints + j) = dTranslation(r, j);
            }
        }
        const double w = 1 / std::pow(1 + e.squaredNorm() / limit2, 2);   // Geman and McClure
        const Eigen::MatrixXd N = w * J.transpose() * J;
        const Eigen::VectorXd g = w * J.transpose() * e;
        for (int r = 0; r < size; r++)
        {
            normals.b[columns[r]] += g[r];
            for (int j = 0; j < size; j++) normals.A(columns[r], columns[j]) += N(r, j);
        }
        normals.sum2 += w * e.squaredNorm();
        normals.points++;
        weights += w;
    }
    normals.weights += weights;
    normals.found += weights > 1;
}

// The correction of a block is about that of the block before.
void TimeOffsetFit::addTie(int tool, int block, Normals& normals) const
{
    const Correction &c = corrections_[tool][block], &last = corrections_[tool][block - 1];
    const Vec3d dw = rotationVector(c.R * last.R.t()), dt = c.t - last.t;
    const double e2 = dw.dot(dw) / (tieAngle * tieAngle) + dt.dot(dt) / (tieShift * tieShift);
    const double robust = 1 / (1 + e2 / 9);   // Cauchy: beyond three deviations the tie gives way
    const int column = correctionColumns_[tool] + 6 * block, previous = column - 6;
    for (int j = 0; j < 6; j++)
    {
        const double weight = robust / std::pow(j < 3 ? tieAngle : tieShift, 2), difference = j < 3 ? dw[j] : dt[j - 3];
        normals.A(column + j, column + j) += weight;
        normals.A(previous + j, previous + j) += weight;
        normals.A(column + j, previous + j) -= weight;
        normals.A(previous + j, column + j) -= weight;
        normals.b[column + j] -= weight * difference;
        normals.b[previous + j] += weight * difference;
    }
}

// What is known beforehand: the offset, to the reach; errors of joints; that of the hand-eye calibration, shared out among the blocks.
void TimeOffsetFit::addPriors(double reach, Normals& normals) const
{
    normals.A(0, 0) += 1 / (reach * reach);
    normals.b[0] -= (offset_ - startOffset_) / (reach * reach);
    for (int i = 0; i < int(tools_.size()); i++)
    {
        for (size_t j = 0; j < tools_[i].coordinates.size(); j++)
        {
            const double weight = 1 / std::pow(tools_[i].deviations[j], 2);
            const int column = jointColumns_[i] + int(j);
            normals.A(column, column) += weight;
            normals.b[column] -= weight * jointOffsets_[i][j];
        }
        for (int block = 0; block < blocks_; block++)
        {
            const Correction& c = corrections_[i][block];
            const Vec3d w = rotationVector(c.R);
            const int column = correctionColumns_[i] + 6 * block;
            for (int j = 0; j < 6; j++)
            {
                const double weight = 1 / std::pow(j < 3 ? handEyeAngle : handEyeShift, 2) / blocks_;
                normals.A(column + j, column + j) += weight;
                normals.b[column + j] -= weight * (j < 3 ? w[j] : c.t[j - 3]);
            }
            if (block > 0) addTie(i, block, normals);
        }
    }
}

void TimeOffsetFit::apply(const double* dx, double reach)
{
    offset_ = std::min(std::max(offset_ + dx[0], startOffset_ - reach), startOffset_ + reach);
    for (size_t i = 0; i < tools_.size(); i++)
    {
        for (size_t j = 0; j < jointOffsets_[i].size(); j++) jointOffsets_[i][j] += dx[jointColumns_[i] + int(j)];
        for (int block = 0; block < blocks_; block++)
        {
            const double* d = dx + correctionColumns_[i] + 6 * block;
            Correction& c = corrections_[i][block];
            c.R = exponential(Vec3d(d)) * c.R;
            c.t += Vec3d(d[3], d[4], d[5]);
        }
    }
}

bool TimeOffsetFit::run(const std::vector<OffsetMeasurement>& measurements, double scale, int iterations, double reach)
{
    deviation_ = DBL_MAX;
    for (int iteration = 0; iteration <= iterations; iteration++)   // the last one is for the covariance only
    {
        Normals normals(unknowns_);
        for (size_t i = 0; i < measurements.size(); i++) addMeasurement(measurements[i], std::pow(scale / pointDeviation, 2), normals);
        if (normals.found < minMeasurements) return false;
        addPriors(reach, normals);
        const Eigen::LLT<Eigen::MatrixXd> cholesky(normals.A);
        if (cholesky.info() != Eigen::Success) return false;
        if (iteration < iterations)
        {
            const Eigen::VectorXd dx = cholesky.solve(normals.b);
            apply(dx.data(), reach);
            continue;
        }
        // The points of a tool in a frame are wrong together (template, bending, time stamp): they count as one.
        const double variance = std::max(leastVariance, normals.sum2 / std::max(1., 2 * normals.weights - 7)) * normals.points / normals.found;
        deviation_ = std::sqrt(cholesky.solve(Eigen::VectorXd::Unit(unknowns_, 0))[0] * variance);
    }
    return true;
}

}} // namespace cv::surgtrack
