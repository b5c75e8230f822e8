// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include <set>
#include "opencv2/surgtrack/tool_model.hpp"
#include "base/geometry.hpp"

namespace cv { namespace surgtrack {

ToolModel::Link::Link()
    : parent(-1), jointType(JOINT_FIXED), coordinate(-1), scale(1), alpha(0), a(0), theta(0), d(0), mesh(-1), offsetDeviation(-1), gainDeviation(-1), playDeviation(-1), couplingDeviation(-1)
{
}

ToolModel::Keypoint::Keypoint() : link(-1), score(-1) {}

ToolModel::Description::Description() : endEffectorLink(-1), link_T_endEffector(Matx44d::eye())
{
}

namespace {

void expect(bool condition, const String& what)
{
    if (!condition)
        CV_Error(Error::StsBadArg, what);
}

// Far beyond any tool, and near enough that sums and squares of what a file says stay numbers.
const double longest = 1000, largestFactor = 1e4, largestAngle = 1e4;   // [m], [], [rad]

void checkNewName(std::set<String>& names, const String& name, const String& path)
{
    expect(!name.empty() && names.insert(name).second, path + ": expected a name of its own, found `" + name + "`");
}

void checkMesh(const Mesh& mesh, const String& path)
{
    expect(!mesh.triangles.empty(), path + ".triangles: expected at least one");
    expect(mesh.normals.size() == mesh.vertices.size(), path + ".normals: expected one per vertex");
    expect(checkRange(mesh.vertices, true, 0, -longest, longest), path + format(".vertices: expected finite numbers, within %g m", longest));
    expect(checkRange(mesh.normals), path + ".normals: expected finite numbers");
    for (size_t i = 0; i < mesh.triangles.size(); ++i)
        for (int k = 0; k < 3; ++k)
            expect(mesh.triangles[i][k] >= 0 && mesh.triangles[i][k] < (int)mesh.vertices.size(),
                   path + format(".triangles[%d]: expected indices of vertices", (int)i));
}

void checkDescription(const ToolModel::Description& tool)
{
    std::set<String> coordinateNames, linkNames, keypointNames;
    const int linkCount = (int)tool.links.size();
    for (size_t i = 0; i < tool.coordinates.size(); ++i)
        checkNewName(coordinateNames, tool.coordinates[i], format("coordinates[%d]", (int)i));
    linkNames.insert("base");
    expect(linkCount > 0, "links: expected at least one");
    for (int i = 0; i < linkCount; ++i)
    {
        const ToolModel::Link& link = tool.links[i];
        const String path = format("links[%d]", i);
        checkNewName(linkNames, link.name, path + ".name");
        expect(link.parent >= -1 && link.parent < i, path + ".parent: expected the index of an earlier link, or -1");
        const bool fixed = link.jointType == ToolModel::JOINT_FIXED;
        expect(fixed || link.jointType == ToolModel::JOINT_REVOLUTE || link.jointType == ToolModel::JOINT_PRISMATIC,
               path + ".jointType: expected a JointType");
        expect(fixed ? link.coordinate == -1 : link.coordinate >= 0 && link.coordinate < (int)tool.coordinates.size(),
               path + ".coordinate: expected the index of a coordinate, or -1 for a fixed joint");
        expect(checkRange(Vec<double, 5>(link.scale, link.alpha, link.a, link.theta, link.d)),
               path + ": expected finite scale, alpha, a, theta and d");
        expect(std::abs(link.scale) <= largestFactor && std::max(std::abs(link.a), std::abs(link.d)) <= longest
                   && std::max(std::abs(link.alpha), std::abs(link.theta)) <= largestAngle,
               path + format(": expected a scale of at most %g, a and d of at most %g m, alpha and theta of at most %g rad", largestFactor, longest, largestAngle));
        static const struct { double ToolModel::Link::*value; const char* name; bool turns; } deviations[] = {
            { &ToolModel::Link::offsetDeviation, ".offsetDeviation", false }, { &ToolModel::Link::gainDeviation, ".gainDeviation", true },
            { &ToolModel::Link::playDeviation, ".playDeviation", true }, { &ToolModel::Link::couplingDeviation, ".couplingDeviation", true } };
        for (const auto& d : deviations)
        {
            const double value = link.*d.value;
            expect(value < 0 || (value <= largestAngle && (d.turns ? link.jointType == ToolModel::JOINT_REVOLUTE : !fixed)),
                   path + d.name + ": expected a finite number, or a negative one for the default, as for a "
                       + (d.turns ? "joint that does not turn" : "fixed joint"));
            for (int j = 0; j < i; ++j)
                expect(fixed || tool.links[j].coordinate != link.coordinate || tool.links[j].*d.value < 0 || value < 0 || tool.links[j].*d.value == value,
                       path + d.name + ": expected the same as of the other links of this coordinate");
        }
        expect(link.mesh >= -1 && link.mesh < (int)tool.meshes.size(), path + ".mesh: expected the index of a mesh, or -1");
    }
    for (size_t i = 0; i < tool.meshes.size(); ++i)
        checkMesh(tool.meshes[i], format("meshes[%d]", (int)i));
    for (size_t i = 0; i < tool.keypoints.size(); ++i)
    {
        const ToolModel::Keypoint& keypoint = tool.keypoints[i];
        const String path = format("keypoints[%d]", (int)i);
        checkNewName(keypointNames, keypoint.name, path + ".name");
        expect(keypoint.link >= 0 && keypoint.link < linkCount, path + ".link: expected the index of a link");
        expect(checkRange(Vec3d(keypoint.linkPoint), true, 0, -longest, longest), path + format(".linkPoint: expected finite numbers, within %g m", longest));
        expect(keypoint.score <= 1, path + ".score: expected a number from 0 to 1, or a negative one if it is not known");
    }
    expect(tool.limits.empty() || tool.limits.size() == tool.coordinates.size(), "limits: expected one of each coordinate, or none");
    for (size_t i = 0; i < tool.limits.size(); ++i)
        expect(tool.limits[i][0] <= tool.limits[i][1], format("limits[%d]: expected the least and the greatest value", (int)i));
    expect(tool.endEffectorLink >= 0 && tool.endEffectorLink < linkCount, "endEffectorLink: expected the index of a link");
    const Matx44d& end = tool.link_T_endEffector;
    expect(isRigid(end) && norm(Vec3d(end(0, 3), end(1, 3), end(2, 3))) <= longest, format("link_T_endEffector: expected a rigid transform, within %g m", longest));
}

} // namespace

Ptr<ToolModel> ToolModel::create(const Description& description)
{
    checkDescription(description);
    return Ptr<ToolModel>(new ToolModel(description));
}

ToolModel::ToolModel(const Description& description) : description_(description)
{
}

std::vector<String> ToolModel::linkNames() const
{
    std::vector<String> names;
    for (size_t i = 0; i < description_.links.size(); ++i)
        names.push_back(description_.links[i].name);
    return names;
}

std::vector<String> ToolModel::keypointNames() const
{
    std::vector<String> names;
    for (size_t i = 0; i < description_.keypoints.size(); ++i)
        names.push_back(description_.keypoints[i].name);
    return names;
}

Mat ToolModel::jointLimits() const
{
    Mat_<double> limits((int)description_.coordinates.size(), 2);
    for (int i = 0; i < limits.rows; ++i)
        for (int k = 0; k < 2; ++k)
            limits(i, k) = description_.limits.empty() ? (k ? DBL_MAX : -DBL_MAX) : description_.limits[i][k];
    return limits;
}

std::vector<double> ToolModel::keypointScores() const
{
    std::vector<double> scores;
    for (size_t i = 0; i < description_.keypoints.size(); ++i)
        scores.push_back(description_.keypoints[i].score);
    return scores;
}

int ToolModel::coordinateIndex(const String& name) const
{
    const std::vector<String>& all = description_.coordinates;
    const std::vector<String>::const_iterator at = std::find(all.begin(), all.end(), name);
    return at == all.end() ? -1 : int(at - all.begin());
}

std::vector<double> ToolModel::offsetDeviations() const
{
    // The wrist: what turns beyond the joint that slides. Errors of the arm are as good as errors of the hand-eye calibration.
    const double wrist = 0.03;   // [rad]
    const std::vector<Link>& links = description_.links;
    std::vector<double> deviations(description_.coordinates.size(), 0.);
    std::vector<uchar> slid(links.size(), 0);
    for (size_t i = 0; i < links.size(); ++i)
    {
        slid[i] = links[i].jointType == JOINT_PRISMATIC || (links[i].parent >= 0 && slid[links[i].parent]);
        if (slid[i] && links[i].jointType == JOINT_REVOLUTE)
            deviations[links[i].coordinate] = wrist;
    }
    for (size_t i = 0; i < links.size(); ++i)
        if (links[i].offsetDeviation >= 0)
            deviations[links[i].coordinate] = links[i].offsetDeviation;
    return deviations;
}

int ToolModel::linkMesh(int link) const
{
    CV_CheckGE(link, 0, "link: of the tool");
    CV_CheckLT(link, (int)description_.links.size(), "link: of the tool");
    return description_.links[link].mesh;
}

void ToolModel::getMesh(int index, OutputArray vertices, OutputArray triangles) const
{
    CV_CheckGE(index, 0, "index: of a mesh");
    CV_CheckLT(index, (int)description_.meshes.size(), "index: of a mesh");
    const Mesh& mesh = description_.meshes[index];
    Mat(mesh.vertices).reshape(1, (int)mesh.vertices.size()).copyTo(vertices);
    Mat(mesh.triangles).reshape(1, (int)mesh.triangles.size()).copyTo(triangles);
}

void ToolModel::forwardKinematics(InputArray joints, std::vector<Matx44d>& base_T_link) const
{
    Mat q = joints.getMat();
    CV_CheckEQ(q.total() * q.channels(), description_.coordinates.size(), "joints: one value per coordinate");
    if (!q.empty())
    {
        CV_CheckDepth(q.depth(), q.depth() == CV_32F || q.depth() == CV_64F, "joints");
        if (q.depth() != CV_64F || !q.isContinuous())
            q.convertTo(q, CV_64F);
        CV_Assert(checkRange(q) && "joints: finite");
    }
    base_T_link.resize(description_.links.size());
    for (size_t i = 0; i < base_T_link.size(); ++i)
    {
        const Link& link = description_.links[i];
        const double value = link.coordinate < 0 ? 0 : link.scale * q.ptr<double>()[link.coordinate];
        const double theta = link.theta + (link.jointType == JOINT_REVOLUTE ? value : 0);
        const double d = link.d + (link.jointType == JOINT_PRISMATIC ? value : 0);
        const double ca = std::cos(link.alpha), sa = std::sin(link.alpha), ct = std::cos(theta), st = std::sin(theta);
        const Matx44d parent_T_link(ct,      -st,      0,   link.a,
                                    ca * st, ca * ct, -sa, -sa * d,
                                    sa * st, sa * ct,  ca,  ca * d,
                                    0,       0,        0,   1);
        base_T_link[i] = link.parent < 0 ? parent_T_link : base_T_link[link.parent] * parent_T_link;
    }
}

Matx44d ToolModel::endEffectorFromLinks(const std::vector<Matx44d>& base_T_link) const
{
    CV_CheckEQ(base_T_link.size(), description_.links.size(), "base_T_link: one per link");
    return base_T_link[description_.endEffectorLink] * description_.link_T_endEffector;
}

void ToolModel::pointJacobian(const std::vector<Matx44d>& base_T_link, int link, const Point3d& basePoint, OutputArray jacobian) const
{
    CV_CheckEQ(base_T_link.size(), description_.links.size(), "base_T_link: one pose per link");
    CV_Check(link, link >= 0 && link < (int)base_T_link.size(), "no such link");
    jacobian.create(3, (int)description_.coordinates.size(), CV_64F);
    Mat_<double> J(3, (int)description_.coordinates.size());
    pointJacobian(base_T_link, link, basePoint, J.ptr<double>());
    J.copyTo(jacobian);
}

Mat ToolModel::linkPoses(InputArray joints) const
{
    std::vector<Matx44d> base_T_link;
    forwardKinematics(joints, base_T_link);
    return stackPoses(base_T_link);
}

Matx44d ToolModel::endEffectorPose(InputArray joints) const
{
    std::vector<Matx44d> base_T_link;
    forwardKinematics(joints, base_T_link);
    return endEffectorFromLinks(base_T_link);
}

void ToolModel::keypointPositions(InputArray joints, OutputArray basePoints, OutputArray jacobian) const
{
    std::vector<Matx44d> base_T_link;
    forwardKinematics(joints, base_T_link);
    const int K = (int)description_.keypoints.size(), C = (int)description_.coordinates.size();
    basePoints.create(K, 3, CV_64F);
    Mat points = basePoints.getMat(), J;
    if (jacobian.needed())
    {
        jacobian.create(3 * K, C, CV_64F);
        J = jacobian.getMat();
    }
    for (int k = 0; k < K; ++k)
    {
        const Keypoint& keypoint = description_.keypoints[k];
        const Matx44d& T = base_T_link[keypoint.link];
        const Point3d basePoint = T.get_minor<3, 3>(0, 0) * keypoint.linkPoint + Point3d(T(0, 3), T(1, 3), T(2, 3));
        *points.ptr<Point3d>(k) = basePoint;
        if (!J.empty())
            pointJacobian(base_T_link, keypoint.link, basePoint, J.ptr<double>(3 * k));
    }
}

void ToolModel::pointJacobian(const std::vector<Matx44d>& base_T_link, int link, const Point3d& basePoint, double* jacobian) const
{
    CV_DbgAssert(base_T_link.size() == description_.links.size() && link >= 0 && link < (int)base_T_link.size());
    const size_t C = description_.coordinates.size();
    std::fill(jacobian, jacobian + 3 * C, 0.);
    for (int i = link; i >= 0; i = description_.links[i].parent)
    {
        const Link& joint = description_.links[i];
        if (joint.coordinate < 0)
            continue;
        // A modified DH joint turns about, or slides along, the z axis of its own link.
        const Matx44d& T = base_T_link[i];
        const Point3d axis(T(0, 2), T(1, 2), T(2, 2)), origin(T(0, 3), T(1, 3), T(2, 3));
        const Point3d velocity = joint.scale * (joint.jointType == JOINT_REVOLUTE ? axis.cross(basePoint - origin) : axis);
        jacobian[joint.coordinate] += velocity.x;
        jacobian[C + joint.coordinate] += velocity.y;
        jacobian[2 * C + joint.coordinate] += velocity.z;
    }
}

}} // namespace cv::surgtrack
