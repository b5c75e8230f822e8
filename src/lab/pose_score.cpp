// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include <limits>
#include "opencv2/surgtrack/pose_score.hpp"
#include "base/geometry.hpp"

namespace cv { namespace surgtrack {

namespace {

const double MAX_PIXELS = 10;         // paper, Sec. 3, scaled with the image
const double SILENT_ERROR = 0.005;    // [m]
const double BESIDE_PIVOT = 0.003;    // [m]

struct Sums
{
    int frames, covered, accurate, silent;
    double translation, translation2, rotation, rotation2;
    Sums() : frames(0), covered(0), accurate(0), silent(0), translation(0), translation2(0), rotation(0), rotation2(0) {}
};

double meanOf(double sum, int n) { return n ? sum / n : 0; }
double deviationOf(double sum, double sum2, int n)
{
    return n ? std::sqrt(std::max(0., sum2 / n - (sum / n) * (sum / n))) : 0;
}

// In the end effector's frame.
std::vector<Vec3d> scoredPoints(const ToolModel& model)
{
    const std::vector<ToolModel::Link>& links = model.links();
    int pivot = model.endEffectorLink();
    while (pivot >= 0 && links[pivot].jointType == ToolModel::JOINT_FIXED)
        pivot = links[pivot].parent;
    if (pivot < 0)   // nothing moves
        pivot = model.endEffectorLink();
    std::vector<Matx44d> base_T_link;
    model.forwardKinematics(std::vector<double>(model.coordinateNames().size(), 0.), base_T_link);   // any: no joint lies between
    const Matx44d tool_T_pivot = rigidInverse(model.endEffectorFromLinks(base_T_link)) * base_T_link[pivot];
    std::vector<Vec3d> points(1, Vec3d());
    for (int side = -1; side <= 1; side++)
    {
        const Point3d p = transform(tool_T_pivot, Point3d(0, 0, side * BESIDE_PIVOT));   // a link turns about its z
        points.push_back(Vec3d(p.x, p.y, p.z));
    }
    return points;
}

class PoseScorerImpl CV_FINAL : public PoseScorer
{
public:
    PoseScorerImpl(const CameraModel& camera, const std::vector<Ptr<ToolModel> >& models) : camera_(camera), sums_(models.size())
    {
        for (size_t i = 0; i < models.size(); i++)
            points_.push_back(scoredPoints(*models[i]));
    }

    void add(int tool, int state, const Matx44d& camera_T_tool, const Matx44d& true_camera_T_tool) CV_OVERRIDE
    {
        CV_CheckGE(tool, 0, "tool index");
        CV_CheckLT(tool, (int)sums_.size(), "tool index");
        Sums& s = sums_[tool];
        s.frames++;
        if ((state != STATE_TRACKING && state != STATE_COASTING) || !checkRange(camera_T_tool))
            return;
        const Matx33d R = rotationOf(camera_T_tool), trueR = rotationOf(true_camera_T_tool);
        const Vec3d t(camera_T_tool(0, 3), camera_T_tool(1, 3), camera_T_tool(2, 3));
        const Vec3d trueT(true_camera_T_tool(0, 3), true_camera_T_tool(1, 3), true_camera_T_tool(2, 3));
        const double translation = norm(t - trueT), rotation = angleBetween(trueR, R);
        s.covered++;
        s.translation += translation;
        s.translation2 += translation * translation;
        s.rotation += rotation;
        s.rotation2 += rotation * rotation;
        s.accurate += reprojectionError(points_[tool], R, t, trueR, trueT) <= MAX_PIXELS * camera_.imageSize().width / referenceWidth;
        s.silent += state == STATE_TRACKING && translation > SILENT_ERROR;
    }

    PoseScore score(int tool) const CV_OVERRIDE
    {
        CV_CheckGE(tool, -1, "tool index");
        CV_CheckLT(tool, (int)sums_.size(), "tool index");
        Sums s;
        for (int i = 0; i < (int)sums_.size(); i++)
        {
            if (tool >= 0 && i != tool)
                continue;
            s.frames += sums_[i].frames;
            s.covered += sums_[i].covered;
            s.accurate += sums_[i].accurate;
            s.silent += sums_[i].silent;
            s.translation += sums_[i].translation;
            s.translation2 += sums_[i].translation2;
            s.rotation += sums_[i].rotation;
            s.rotation2 += sums_[i].rotation2;
        }
        PoseScore score;
        score.frames = s.frames;
        score.covered = s.covered;
        score.translationMean = meanOf(s.translation, s.covered);
        score.translationStd = deviationOf(s.translation, s.translation2, s.covered);
        score.rotationMean = meanOf(s.rotation, s.covered);
        score.rotationStd = deviationOf(s.rotation, s.rotation2, s.covered);
        score.accuracy = meanOf(s.accurate, s.frames);
        score.silent = meanOf(s.silent, s.frames);
        return score;
    }

private:
    Point2d project(const Vec3d& X) const
    {
        return X[2] > 1e-6 ? Point2d(camera_.fx * X[0] / X[2], camera_.fy * X[1] / X[2]) : Point2d(1e9, 1e9);
    }

    double reprojectionError(const std::vector<Vec3d>& points, const Matx33d& R, const Vec3d& t, const Matx33d& trueR, const Vec3d& trueT) const
    {
        double sum = 0;
        for (size_t i = 0; i < points.size(); i++)
            sum += norm(project(R * points[i] + t) - project(trueR * points[i] + trueT));
        return sum / (double)points.size();
    }

    CameraModel camera_;
    std::vector<std::vector<Vec3d> > points_;   // a tool
    std::vector<Sums> sums_;
};

} // namespace

PoseScore::PoseScore()
    : frames(0), covered(0), translationMean(0), translationStd(0), rotationMean(0), rotationStd(0), accuracy(0), silent(0)
{
}

Ptr<PoseScorer> PoseScorer::create(const CameraModel& camera, const std::vector<Ptr<ToolModel> >& models)
{
    CV_Assert(!models.empty());
    for (size_t i = 0; i < models.size(); i++)
        if (!models[i])
            CV_Error(Error::StsBadArg, format("models[%d] is empty", (int)i));
    CV_Assert(!camera.imageSize().empty() && "the camera must have an image size");
    return makePtr<PoseScorerImpl>(camera, models);
}

Matx61d poseError(const Matx44d& camera_T_tool, const Matx44d& true_camera_T_tool)
{
    const Vec3d r = rotationVector(true_camera_T_tool.get_minor<3, 3>(0, 0) * camera_T_tool.get_minor<3, 3>(0, 0).t());
    Matx61d e;
    for (int i = 0; i < 3; i++)
    {
        e(i) = r[i];
        e(3 + i) = true_camera_T_tool(i, 3) - camera_T_tool(i, 3);
    }
    return e;
}

double normalizedErrorSquared(const Matx61d& error, const Matx66d& covariance, int first, int count)
{
    CV_CheckGE(first, 0, "first component");
    CV_Check(count, count > 0 && first + count <= 6, "number of components");
    // Components are divided by their deviations first: metres and radians differ by orders of magnitude.
    const double unknown = std::numeric_limits<double>::quiet_NaN();
    Mat_<double> correlation(count, count), scaled(count, 1), solution;
    for (int i = 0; i < count; i++)
    {
        const double variance = covariance(first + i, first + i);
        if (!(variance > 0))
            return unknown;
        scaled(i) = error(first + i) / std::sqrt(variance);
        for (int j = 0; j < count; j++)
            correlation(i, j) = covariance(first + i, first + j) / std::sqrt(variance * covariance(first + j, first + j));
    }
    if (!checkRange(correlation) || !solve(correlation, scaled, solution, DECOMP_CHOLESKY))
        return unknown;
    return scaled.dot(solution);
}

}} // namespace cv::surgtrack
