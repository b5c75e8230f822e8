// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "files/mesh_io.hpp"
#include "opencv2/surgtrack/tool_setup.hpp"
#include "files/csv.hpp"
#include "lab/import/import_tool.hpp"
#include "lab/tool/surface.hpp"

namespace cv { namespace surgtrack {

ToolParts::ToolParts() : meshScale(1), meshesInToolAxes(false) {}

double exactAngle(double angle)
{
    const double step = CV_PI / 12, exact = cvRound(angle / step) * step;
    return std::abs(angle - exact) < 1e-5 ? exact : angle;
}

static ToolModel::Link step(double alpha, double a, double theta, double d)
{
    ToolModel::Link link;
    link.alpha = alpha;
    link.a = a;
    link.theta = theta;
    link.d = d;
    return link;
}

/* T = Rot_z(theta0) Trans_z(d0) Rot_x(alpha) Trans_x(a) Rot_z(theta1) Trans_z(d1): along the common normal of the two z axes, as Denavit
   and Hartenberg have it. The first pair is a transform with alpha = a = 0, and not needed if theta0 = d0 = 0. */
std::vector<ToolModel::Link> denavitHartenbergSteps(const Matx44d& T)
{
    const double tiny = 1e-12;   // of rounding, of angles that were made exact
    const Vec3d z(T(0, 2), T(1, 2), T(2, 2)), t(T(0, 3), T(1, 3), T(2, 3));
    const double sine = std::hypot(z[0], z[1]);
    // Axes that are almost parallel have a common normal somewhere far away. Then: the translation by itself, and the rotation.
    const bool parallel = sine < tiny, far = !parallel && sine < 1e-3;

    const double nx = parallel || far ? t[0] : -z[1], ny = parallel || far ? t[1] : z[0];   // (nx, ny, 0): along the common normal
    double theta0 = std::hypot(nx, ny) < tiny ? 0 : std::atan2(ny, nx);
    if (theta0 > CV_PI / 2 + tiny || theta0 <= -CV_PI / 2 + tiny)   // the other direction of the normal
        theta0 -= theta0 > 0 ? CV_PI : -CV_PI;
    if (std::abs(theta0) < tiny)
        theta0 = 0;
    const double c = std::cos(theta0), s = std::sin(theta0), a = c * t[0] + s * t[1];
    std::vector<ToolModel::Link> steps;
    if (far)
    {
        if (theta0 != 0)
            steps.push_back(step(0, 0, theta0, 0));
        steps.push_back(step(0, a, -theta0, t[2]));
        const Matx44d rotation = rigidTransform(T.get_minor<3, 3>(0, 0), Vec3d());
        // From here the z axes meet in the origin, and the normal is well defined whatever the angle.
        const double angle = std::atan2(z[0], -z[1]), alpha = std::atan2(sine, z[2]);
        const Matx33d R = rotation.get_minor<3, 3>(0, 0);
        const Matx33d first(std::cos(angle), -std::sin(angle), 0, std::sin(angle), std::cos(angle), 0, 0, 0, 1);
        const Matx33d tilt(1, 0, 0, 0, std::cos(alpha), -std::sin(alpha), 0, std::sin(alpha), std::cos(alpha));
        const Matx33d rest = (first * tilt).t() * R;
        steps.back().theta += angle;
        steps.push_back(step(alpha, 0, std::atan2(rest(1, 0), rest(0, 0)), 0));
        return steps;
    }
    // In the frame turned by theta0 the second axis is (0, -sin alpha, cos alpha).
    const double alpha = parallel ? (z[2] > 0 ? 0 : CV_PI) : std::atan2(s * z[0] - c * z[1], z[2]);
    const double sideways = c * t[1] - s * t[0];
    const double d1 = parallel ? t[2] * (z[2] > 0 ? 1 : -1) : -sideways / std::sin(alpha);
    const double d0 = parallel ? 0 : t[2] - d1 * std::cos(alpha);
    const double x = c * T(0, 0) + s * T(1, 0), y = c * T(1, 0) - s * T(0, 0);
    const double theta1 = std::atan2(std::cos(alpha) * y + std::sin(alpha) * T(2, 0), x);
    if (theta0 != 0 || std::abs(d0) > tiny)
        steps.push_back(step(0, 0, theta0, d0));
    steps.push_back(step(alpha, a, theta1, d1));
    return steps;
}

int findLink(const ToolModel::Description& tool, const String& name, const String& source)
{
    String known;
    for (size_t i = 0; i < tool.links.size(); i++)
    {
        if (tool.links[i].name == name)
            return (int)i;
        known += (i ? ", " : "") + tool.links[i].name;
    }
    CV_Error(Error::StsBadArg, source + ": there is no link '" + name + "', expected one of: " + known);
}

void dropUnusedMeshes(ToolModel::Description& tool)
{
    std::vector<Mesh> used;
    for (size_t i = 0; i < tool.links.size(); i++)
        if (tool.links[i].mesh >= 0)
        {
            used.push_back(tool.meshes[tool.links[i].mesh]);
            tool.links[i].mesh = (int)used.size() - 1;
        }
    tool.meshes.swap(used);
}

bool wantsAuto(const String& keypoints, int* count)
{
    if (keypoints == "auto")
        return true;
    char rest;
    int n = 0;
    if (keypoints.compare(0, 5, "auto:") != 0)
        return false;
    if (std::sscanf(keypoints.c_str() + 5, "%d%c", &n, &rest) != 1 || n < 6 || n > 200)
        CV_Error(Error::StsBadArg, "keypoints is `" + keypoints + "`, expected auto, auto:N with N from 6 to 200, or a file");
    if (count)
        *count = n;
    return true;
}

//! A point picked in the link's mesh file, in the link's frame: where its mesh is, if it has one.
static Point3d placed(const ToolParts& parts, const MeshFrames& frames, const String& name, const Point3d& picked, int link, const ToolModel::Description& tool)
{
    const MeshFrames::const_iterator own = frames.find(link), any = own == frames.end() ? frames.find(-1) : own;
    const int mesh = tool.links[link].mesh;
    Point3d best;
    double nearest = DBL_MAX;
    for (size_t i = 0; i < any->second.size(); i++)
    {
        const Point3d p = transform(any->second[i], picked);
        const double distance = mesh < 0 ? 0 : distanceTo(tool.meshes[mesh], p);
        if (distance < nearest)
        {
            nearest = distance;
            best = p;
        }
    }
    if (nearest > farthestKeypoint)
        CV_Error(Error::StsParseError, parts.keypoints + format(": keypoint `%s` is %.4g mm off the surface of link `%s`, expected %g at most: are its axes and its "
                 "unit those of the link's mesh file?", name.c_str(), 1e3 * nearest, tool.links[link].name.c_str(), 1e3 * farthestKeypoint));
    return best;
}

static void addKeypoints(const ToolParts& parts, const MeshFrames& frames, ToolModel::Description& tool)
{
    tool.keypoints.clear();
    CsvReader csv(parts.keypoints);
    const int name = csv.column("name"), link = csv.column("link"), xyz[] = { csv.column("x"), csv.column("y"), csv.column("z") };
    while (csv.next())
    {
        ToolModel::Keypoint keypoint;
        keypoint.name = csv.text(name);
        keypoint.link = findLink(tool, csv.text(link), parts.keypoints);
        const Point3d picked(csv.number(xyz[0]), csv.number(xyz[1]), csv.number(xyz[2]));
        keypoint.linkPoint = placed(parts, frames, keypoint.name, picked, keypoint.link, tool);
        tool.keypoints.push_back(keypoint);
    }
}

void addParts(const ToolParts& parts, const Matx33d& axes, ToolModel::Description& tool, MeshFrames frames)
{
    if (!(parts.meshScale > 0 && parts.meshScale < DBL_MAX))
        CV_Error(Error::StsBadArg, format("meshScale is %g, expected a positive number of metres per unit", parts.meshScale));
    const double scale = parts.meshScale;
    const Matx44d link_T_file = rigidTransform(axes, Vec3d()) * Matx44d::diag(Matx41d(scale, scale, scale, 1));
    frames[-1].assign(1, link_T_file);
    for (size_t i = 0; i < parts.meshes.size(); i++)
    {
        const std::pair<String, String> part = splitPair(parts.meshes[i], "meshes");
        const int index = findLink(tool, part.first, "meshes");
        ToolModel::Link& link = tool.links[index];
        frames.erase(index);
        link.mesh = part.second == "none" ? -1 : (int)tool.meshes.size();
        if (link.mesh < 0)
            continue;
        tool.meshes.push_back(loadMesh(part.second, scale, rigidTransform(axes, Vec3d())));
    }
    dropUnusedMeshes(tool);
    if (!parts.keypoints.empty() && !wantsAuto(parts.keypoints))
        addKeypoints(parts, frames, tool);
}

Ptr<ToolModel> makeTool(const String& filename, const ToolParts& parts, const ToolModel::Description& tool)
{
    int count = 24;   // as chooseKeypoints() has it
    const Ptr<ToolModel> model = createTool(filename, tool);
    return wantsAuto(parts.keypoints, &count) ? chooseKeypoints(model, count) : model;
}

}} // namespace cv::surgtrack
