// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// What others report: errors at labelled keypoints (EndoVis, SurgPose), and the measures of SurgRIPE.

#ifndef OPENCV_SURGTRACK_SAMPLES_EVALUATION_MEASURES_HPP
#define OPENCV_SURGTRACK_SAMPLES_EVALUATION_MEASURES_HPP

#include "data.hpp"

namespace evaluation {

//! A keypoint of a frame that is labelled, or known, to be seen.
struct LabelError
{
    LabelError() : frame(0), tool(0), part(0), covered(0), pixels(0) {}
    int frame, tool, part;
    int covered;      //!< 0: there is no pose
    double pixels;    //!< between the label and where the pose has it; of no meaning without
};

//! How labelled keypoints fare.
struct LabelScore
{
    LabelScore() : labels(0) {}
    int labels;
    Moments pixels, percent;         //!< of those with a pose; percent: of the image width
    std::vector<double> percents;    //!< the same, one by one

    void add(const LabelError& e, int width)
    {
        labels++;
        if (!e.covered)
            return;
        pixels.add(e.pixels);
        percents.push_back(100 * e.pixels / width);
        percent.add(percents.back());
    }
    //! The share of all labels, with a pose or without, that is at most so far off [per cent of the image width]: a point of the PCK curve.
    double pck(double most) const
    {
        int near = 0;
        for (size_t i = 0; i < percents.size(); i++)
            near += percents[i] <= most;
        return labels ? (double)near / labels : unknown();
    }
};

/** Errors of a pose at the keypoints that are seen.
@param joints the pose is of; empty: there is no pose */
inline void addLabels(const Data& data, int tool, int frame, const Matx44d& camera_T_tool, const std::vector<double>& joints, std::vector<LabelError>& errors)
{
    const std::map<int, Point2d> labels = data.visibleKeypoints(tool, frame);
    if (labels.empty())
        return;
    Mat basePoints;
    const Ptr<ToolModel>& model = data.tools[tool].model;
    const CameraModel camera = data.sequence->leftCamera();
    if (!joints.empty())
        model->keypointPositions(joints, basePoints);
    const Matx44d camera_T_base = joints.empty() ? Matx44d::eye() : data.camera_T_base(tool, camera_T_tool, joints);
    for (std::map<int, Point2d>::const_iterator it = labels.begin(); it != labels.end(); ++it)
    {
        LabelError e;
        e.frame = frame;
        e.tool = tool;
        e.part = it->first;
        if (!joints.empty())
        {
            const double* b = basePoints.ptr<double>(it->first);
            const Vec4d p = camera_T_base * Vec4d(b[0], b[1], b[2], 1);
            e.covered = p[2] > 1e-3;
            if (e.covered)
                e.pixels = norm(camera.project(Point3d(p[0], p[1], p[2])) - it->second);
        }
        errors.push_back(e);
    }
}

/** The tool as SurgRIPE measures it: some hundred points of the link that carries the end effector, and of what that carries, each
where its pose and joints have it. */
class ToolPoints
{
public:
    explicit ToolPoints(const Ptr<ToolModel>& model) : model_(model), diameter_(0)
    {
        const std::vector<ToolModel::Link>& links = model->links();
        std::vector<char> wanted(links.size());
        size_t total = 0;
        for (size_t i = 0; i < links.size(); i++)
        {
            wanted[i] = (int)i == model->endEffectorLink() || (links[i].parent >= 0 && wanted[links[i].parent]);
            if (wanted[i] && links[i].mesh >= 0)
                total += model->meshes()[links[i].mesh].vertices.size();
        }
        const size_t most = 400, step = std::max((size_t)1, total / most);
        size_t next = 0;
        for (size_t i = 0; i < links.size(); i++)
            for (size_t k = 0; wanted[i] && links[i].mesh >= 0 && k < model->meshes()[links[i].mesh].vertices.size(); k++)
                if (next++ % step == 0)
                    points_.push_back(std::make_pair((int)i, Point3d(model->meshes()[links[i].mesh].vertices[k])));
        for (size_t i = 0; points_.empty() && i < model->keypoints().size(); i++)   // an end effector without a mesh
            points_.push_back(std::make_pair(model->keypoints()[i].link, model->keypoints()[i].linkPoint));
        std::vector<Point3d> closed;
        place(Matx44d::eye(), std::vector<double>(model->coordinateNames().size(), 0.), closed);
        for (size_t i = 0; i < closed.size(); i++)
            for (size_t k = 0; k < i; k++)
                diameter_ = std::max(diameter_, norm(closed[i] - closed[k]));
    }

    //! Largest distance of two points, the jaws closed [m].
    double diameter() const { return diameter_; }

    //! Points in the camera frame [m].
    void place(const Matx44d& camera_T_tool, const std::vector<double>& joints, std::vector<Point3d>& points) const
    {
        std::vector<Matx44d> base_T_link;
        model_->forwardKinematics(joints, base_T_link);
        const Matx44d camera_T_base = camera_T_tool * rigidInverse(model_->endEffectorFromLinks(base_T_link));
        points.clear();
        for (size_t i = 0; i < points_.size(); i++)
        {
            const Point3d& l = points_[i].second;
            const Vec4d p = camera_T_base * base_T_link[points_[i].first] * Vec4d(l.x, l.y, l.z, 1);
            points.push_back(Point3d(p[0], p[1], p[2]));
        }
    }

private:
    Ptr<ToolModel> model_;
    std::vector<std::pair<int, Point3d> > points_;    // link, and place in it
    double diameter_;
};

//! The mean distance of the tool's points, and of their images.
struct PointDistance
{
    double space;    //!< ADD, as a share of the tool's diameter
    double image;    //!< [pixel]
};

/** @param joints, trueJoints the latter may be empty: unknown, then the pose alone counts */
inline PointDistance distanceOf(const ToolPoints& tool, const CameraModel& camera, const Matx44d& camera_T_tool, const std::vector<double>& joints,
                                const Matx44d& trueCamera_T_tool, const std::vector<double>& trueJoints)
{
    std::vector<Point3d> found, truth;
    tool.place(camera_T_tool, joints, found);
    tool.place(trueCamera_T_tool, trueJoints.empty() ? joints : trueJoints, truth);
    PointDistance distance = { 0, 0 };
    for (size_t i = 0; i < found.size(); i++)
    {
        distance.space += norm(found[i] - truth[i]) / tool.diameter() / found.size();
        const bool seen = found[i].z > 1e-3 && truth[i].z > 1e-3;
        distance.image += seen ? norm(camera.project(found[i]) - camera.project(truth[i])) / found.size() : DBL_MAX;
    }
    return distance;
}

} // namespace evaluation

#endif
