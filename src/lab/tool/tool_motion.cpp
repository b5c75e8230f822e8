// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "base/geometry.hpp"
#include "lab/tool/tool_motion.hpp"

namespace cv { namespace surgtrack {

ToolMotion::ToolMotion(const ToolModel& model) : slide(-1), reach(0)
{
    findRoles(model);
    findRanges(model);
    findShaft(model);
}

void ToolMotion::findRoles(const ToolModel& model)
{
    const std::vector<ToolModel::Link>& links = model.links();
    role.assign(model.coordinateNames().size(), JAW);
    std::vector<int> chain;
    for (int i = model.endEffectorLink(); i >= 0; i = links[i].parent)
        if (links[i].coordinate >= 0)
            chain.insert(chain.begin(), i);
    bool arm = false;   // a tool without one has its wrist from the first joint on
    for (size_t i = 0; i < chain.size(); i++)
        arm = arm || links[chain[i]].jointType == ToolModel::JOINT_PRISMATIC;
    for (size_t i = 0; i < chain.size(); i++)
    {
        const ToolModel::Link& link = links[chain[i]];
        if (std::find(path.begin(), path.end(), link.coordinate) != path.end())
            continue;
        path.push_back(link.coordinate);
        role[link.coordinate] = arm ? ARM : WRIST;
        if (arm && link.jointType == ToolModel::JOINT_PRISMATIC)
        {
            slide = link.coordinate;
            arm = false;
        }
    }
}

void ToolMotion::findRanges(const ToolModel& model)
{
    const double bent = 0.7, open = 0.8;   // [rad], as far as instruments are mostly moved
    const Mat_<double> limits = model.jointLimits();
    for (int c = 0; c < (int)role.size(); c++)
    {
        bool slides = true;   // a coordinate may turn one link and shift another
        for (size_t i = 0; i < model.links().size(); i++)
            slides = slides && (model.links()[i].coordinate != c || model.links()[i].jointType == ToolModel::JOINT_PRISMATIC);
        const double least = limits(c, 0), most = limits(c, 1), zero = std::min(std::max(0., least), most);
        const double down = role[c] == JAW ? 0 : slides ? 0.01 : bent, up = role[c] == JAW ? (slides ? 0.003 : open) : slides ? 0.01 : bent;
        low.push_back(std::max(zero - down, least));
        high.push_back(std::min(zero + up, most));
        if (low.back() == high.back() && role[c] == JAW)   // jaws that open the other way
            low.back() = std::max(zero - up, least);
        rest.push_back(zero);
    }
}

void ToolMotion::findShaft(const ToolModel& model)
{
    std::vector<Matx44d> base_T_link;
    model.forwardKinematics(rest, base_T_link);
    const std::vector<ToolModel::Link>& links = model.links();
    const Matx44d end = model.endEffectorFromLinks(base_T_link);
    const Vec3d tip(end(0, 3), end(1, 3), end(2, 3));
    Vec3d middle;
    double points = 0;
    for (size_t i = 0; i < links.size(); i++)
        for (size_t k = 0; links[i].mesh >= 0 && k < model.meshes()[links[i].mesh].vertices.size(); k++, points++)
            middle += Vec3d(transform(base_T_link[i], Point3d(model.meshes()[links[i].mesh].vertices[k])));
    Vec3d back = tip - middle * (1 / std::max(points, 1.));
    shaft = norm(back) > 1e-6 ? normalize(back) : Vec3d(0, 0, 1);
    for (int i = model.endEffectorLink(); i >= 0; i = links[i].parent)
        if (slide >= 0 && links[i].coordinate == slide)
        {
            const Vec3d axis(base_T_link[i](0, 2), base_T_link[i](1, 2), base_T_link[i](2, 2));
            shaft = axis.dot(back) < 0 ? -axis : axis;
        }
    Vec3d sum = tip, first = tip;
    int count = 1;
    for (int i = model.endEffectorLink(); i >= 0; i = links[i].parent)
    {
        const int c = links[i].coordinate;
        if (c < 0 || role[c] != WRIST)
            continue;
        const Vec3d axis(base_T_link[i](0, 2), base_T_link[i](1, 2), base_T_link[i](2, 2)), at(base_T_link[i](0, 3), base_T_link[i](1, 3), base_T_link[i](2, 3));
        if (slide >= 0 && std::abs(axis.dot(shaft)) > 0.95)
        {
            role[c] = ROLL;
            continue;
        }
        sum += at;
        first = at;
        count++;
    }
    centre = Point3d(sum * (1. / count));
    reach = std::max(0.01, std::max(norm(tip - Vec3d(centre)), norm(first - Vec3d(centre))));
}

std::vector<double> ToolMotion::setting(int index) const
{
    static const int primes[] = { 2, 3, 5, 7, 11, 13 };   // the sequence of Halton
    std::vector<double> joints = rest;
    int used = 0;
    for (size_t c = 0; c < joints.size(); c++)
    {
        if (role[c] != WRIST && role[c] != JAW)
            continue;
        const int base = primes[used++ % 6];
        double share = 0, digit = 1;
        for (int n = index + 1; n > 0; n /= base)
        {
            digit /= base;
            share += digit * (n % base);
        }
        joints[c] = low[c] + share * (high[c] - low[c]);
    }
    return joints;
}

std::vector<int> ToolMotion::wristDepth(const ToolModel& model) const
{
    const std::vector<ToolModel::Link>& links = model.links();
    std::vector<int> depth;
    for (size_t i = 0; i < links.size(); i++)
        depth.push_back((links[i].parent < 0 ? 0 : depth[links[i].parent]) + (links[i].coordinate >= 0 && role[links[i].coordinate] == WRIST));
    return depth;
}

Matx44d Viewpoint::camera_T_base(const ToolMotion& motion) const
{
    const Vec3d s = motion.shaft, other = std::abs(s[0]) < 0.8 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0);
    const Vec3d u = normalize(s.cross(other)), v = s.cross(u), side = u * std::cos(azimuth) + v * std::sin(azimuth);
    const Vec3d z = s * std::cos(elevation) - side * std::sin(elevation);   // the viewing direction
    const Vec3d x = normalize(s - z * s.dot(z)), y = z.cross(x);            // the tool points to the right
    const Matx33d R(x[0], x[1], x[2], y[0], y[1], y[2], z[0], z[1], z[2]);
    return rigidTransform(R, Vec3d(0, 0, distance) - R * Vec3d(motion.centre));
}

}} // namespace cv::surgtrack
