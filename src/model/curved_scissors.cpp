// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "model/loft.hpp"

// Curved scissors: the shaft and the wrist of the built-in needle driver, with blades that bend out of the plane they open in, both to the
// same side. Lengths in this file are millimetres.

namespace cv { namespace surgtrack {

namespace {

const double YAW_TO_TIP = 14.5, BEND = 2.6;   // of the tip, along the yaw axis

/* y towards the tip, z the yaw axis. side = -1: the blade at x < 0. */
Mesh drawBlade(int side)
{
    LinkMesh link;
    link.add(cylinder(2.4, side < 0 ? 0.05 : -1.8, side < 0 ? 1.8 : -0.05, 0.15), ALONG_Z);
    std::vector<Ring> blade, spine;   // the spine is a ridge along the blade's outer side
    const int steps = 16;
    for (int i = 0; i <= steps; ++i)
    {
        const double y = 0.8 + (YAW_TO_TIP - 0.8) * i / steps, share = (double)i / steps, z = BEND * share * share;
        const double half = 1.55 - 1.0 * share * share, back = 2.2 - 1.5 * share, inner = i == 0 ? 0.3 : 0.03, cut = 0.3 * back;
        blade.push_back({ Point3d(z + half, side * inner, y), Point3d(z + half, side * (back - cut), y), Point3d(z + half - cut, side * back, y),
                          Point3d(z + cut - half, side * back, y), Point3d(z - half, side * (back - cut), y), Point3d(z - half, side * inner, y) });
        if (i < 3 || i > 12)
            continue;
        const double height = back + (i == 3 || i == 12 ? -0.05 : 0.3), wide = 0.45 * half;
        spine.push_back({ Point3d(z + wide, side * (back - 0.2), y), Point3d(z + 0.5 * wide, side * height, y), Point3d(z - 0.5 * wide, side * height, y),
                          Point3d(z - wide, side * (back - 0.2), y) });
    }
    link.add(blade, ALONG_Y);
    link.add(spine, ALONG_Y);
    return link.mesh();
}

} // namespace

Ptr<ToolModel> ToolModel::curvedScissors()
{
    Description tool = needleDriver()->description();
    tool.name = "curved_scissors";
    tool.keypoints.clear();
    for (size_t i = 0; i < tool.links.size(); ++i)
        if (tool.links[i].name == "jaw_right" || tool.links[i].name == "jaw_left")
        {
            const int side = tool.links[i].name == "jaw_right" ? -1 : 1;
            tool.meshes[tool.links[i].mesh] = drawBlade(side);
            tool.links[i].name = side < 0 ? "blade_right" : "blade_left";
        }
    // As chooseKeypoints() took them from this shape: link, place, score.
    const struct { int link; Point3d place; double score; } points[] = {
        { 3, Point3d(2.89, 2.62, -13.50), 0.88 }, { 3, Point3d(0.95, -3.78, -13.50), 0.83 }, { 3, Point3d(3.34, -2.00, -13.50), 0.96 },
        { 3, Point3d(-4.15, -0.62, -13.20), 0.92 }, { 3, Point3d(2.50, -3.37, -9.50), 0.96 }, { 3, Point3d(-2.70, -3.22, -5.00), 0.97 },
        { 3, Point3d(2.16, -3.60, 1.61), 1.00 }, { 3, Point3d(-1.90, -3.74, 1.90), 1.00 }, { 3, Point3d(-1.90, 3.74, 1.90), 1.00 },
        { 3, Point3d(0.94, 4.09, 2.52), 1.00 }, { 3, Point3d(-1.89, 3.74, -10.00), 0.88 }, { 3, Point3d(4.06, 1.04, -11.56), 0.91 },
        { 3, Point3d(-3.61, 2.14, -11.56), 0.96 }, { 3, Point3d(-2.11, -3.63, -0.48), 1.00 }, { 4, Point3d(3.23, 3.00, 2.73), 1.00 },
        { 4, Point3d(6.00, 3.00, 0.00), 1.00 }, { 4, Point3d(10.11, -2.50, 2.71), 0.94 }, { 4, Point3d(10.11, -2.80, -2.39), 0.94 },
        { 4, Point3d(7.79, -2.82, 1.07), 0.96 }, { 4, Point3d(4.27, 2.50, -3.60), 0.97 }, { 6, Point3d(-0.03, 12.36, 1.02), 0.77 },
        { 6, Point3d(-0.26, 14.50, 3.15), 0.75 }, { 7, Point3d(1.05, 7.22, -0.76), 0.83 }, { 7, Point3d(1.31, 8.93, 1.72), 0.78 } };
    std::vector<int> number(tool.links.size(), 0);
    for (size_t i = 0; i < sizeof(points) / sizeof(points[0]); ++i)
    {
        Keypoint keypoint;
        keypoint.link = points[i].link;
        keypoint.name = tool.links[keypoint.link].name + format("_%d", ++number[keypoint.link]);
        keypoint.linkPoint = points[i].place * 1e-3;
        keypoint.score = points[i].score;
        tool.keypoints.push_back(keypoint);
    }
    tool.link_T_endEffector(1, 3) = YAW_TO_TIP * 1e-3;
    tool.link_T_endEffector(2, 3) = BEND * 1e-3;
    return create(tool);
}

}} // namespace cv::surgtrack
