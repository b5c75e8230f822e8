// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "model/loft.hpp"

// An 8 mm wristed needle driver, drawn from its dimensions. Lengths in this file are millimetres.
//
// Headlight shading shows slopes, not heights: a raised shape with upright walls is invisible from the front. So all that is
// to be seen has sloping walls or is domed.

namespace cv { namespace surgtrack {

namespace {

const double SHAFT_RADIUS = 4.2, SHAFT_LENGTH = 450;
const double PITCH_TO_YAW = 9.1, YAW_TO_TIP = 9.65, YAW_TO_END_EFFECTOR = 10.2;
const double CLEVIS_LENGTH = 9, CLEVIS_INNER = 2.9, CLEVIS_RADIUS = 2.7;    // the fork that holds the pitch pin
const double WRIST_HALF_THICKNESS = 3, WRIST_HALF_WIDTH = 3.7, WRIST_FRONT = 6.3;   // the body between both axes
const double FORK_INNER = 1.9, FORK_OUTER = 2.8, FORK_RADIUS = 2.9;         // its two arms that hold the yaw pin
const double RELIEF = 0.25;                                                 // height and slope width of raised shapes
const double PITCH_PIN_END = 4.5, YAW_PIN_END = 3.15;
const double TOOTH_PITCH = 0.5, TOOTH_DEPTH = 0.2;

/* z along the shaft, towards the tip; the pitch axis is y. */
Mesh drawShaft()
{
    LinkMesh link;
    const double end = -CLEVIS_LENGTH;
    const double z[] = { -SHAFT_LENGTH, end - 5.2, end - 4.9, end - 4.5, end - 4.2, end - 0.5, end };
    const double r[] = { 0, 0, 0.3, 0.3, 0, 0, 0.5 };   // a groove where the sleeve ends, and a chamfer
    std::vector<Ring> tube;
    for (int i = 0; i < 7; ++i)
        tube.push_back(circle(SHAFT_RADIUS - r[i], z[i], Point2d(), 64));
    link.add(tube, ALONG_Z);

    for (int side = -1; side <= 1; side += 2)
    {
        std::vector<Ring> arm;   // a segment of the shaft's circle, its end round about the pitch axis
        for (int i = -1; i <= 10; ++i)
        {
            const double angle = CV_PI / 2 * i / 11, w = i < 0 ? end - 1 : CLEVIS_RADIUS * std::sin(angle);
            const double half = CLEVIS_RADIUS * std::cos(i < 0 ? 0 : angle);
            Ring ring;
            for (int k = 0; k <= 10; ++k)
            {
                const double x = half * (1 - k / 5.);
                ring.push_back(Point3d(x, side * std::sqrt(SHAFT_RADIUS * SHAFT_RADIUS - x * x), w));
            }
            ring.push_back(Point3d(-half, side * CLEVIS_INNER, w));
            ring.push_back(Point3d(half, side * CLEVIS_INNER, w));
            arm.push_back(ring);
        }
        link.add(arm, ALONG_Z);

        const double inner = side * 2.05, groove = side * 2.4, outer = side * 2.8;
        link.add({ circle(2.6, inner), circle(2.2, groove), circle(2.6, outer) }, ALONG_Y);   // pulley
        for (int k = -1; k <= 1; k += 2)
        {
            const Point2d cable(k * 2.2, groove);
            link.add({ circle(0.25, end - 1, cable, 8), circle(0.25, 0, cable, 8) }, ALONG_Z);
        }
    }
    // The pin: a sloping collar and a domed head.
    const double face = SHAFT_RADIUS, e = PITCH_PIN_END;
    link.add({ circle(1.6, -face - 0.1), circle(1.9, -face + 0.2), circle(1.9, face - 0.2), circle(1.6, face + 0.1) }, ALONG_Y);
    link.add({ circle(0.3, -e), circle(0.8, -e + 0.12), circle(1.1, -e + 0.45), circle(1.1, e - 0.45), circle(0.8, e - 0.12),
               circle(0.3, e) }, ALONG_Y);
    return link.mesh();
}

/* Raised shapes on both faces of the wrist; (right, up) on a face = (z, x) of the link. */
void raise(LinkMesh& link, const Ring& base, const Ring& top)
{
    link.add({ base, top }, ALONG_Y);
    link.add({ base, top }, HALF_TURN_ABOUT_X * ALONG_Y);
}

void raiseDisc(LinkMesh& link, Point2d centre, double radius, double height)
{
    raise(link, circle(radius + height + 0.1, WRIST_HALF_THICKNESS - 0.1, centre), circle(radius, WRIST_HALF_THICKNESS + height, centre));
}

void raiseBar(LinkMesh& link, Point2d p, Point2d q, double halfWidth)
{
    raise(link, bar(p, q, halfWidth + RELIEF + 0.1, WRIST_HALF_THICKNESS - 0.1), bar(p, q, halfWidth, WRIST_HALF_THICKNESS + RELIEF));
}

const Point2d LOGO_DISC(0, 1.1), LOGO_WHEEL(-2.25, 5.1), LOGO_C(-0.3, 4.9), LOGO_V(2.1, 4.1);

/* x towards the tip, z the pitch axis, y (the yaw axis) across the two faces. */
Mesh drawWrist()
{
    LinkMesh link;
    const double thick = WRIST_HALF_THICKNESS;
    link.add(cylinder(thick, -1.9, 1.9, 0.2), ALONG_Z);
    link.add({ roundedRectangle(thick, 1.9, 0.3, 0), roundedRectangle(thick, 1.9, 0.3, 2.7),
               roundedRectangle(thick, WRIST_HALF_WIDTH, 0.6, 3.4), roundedRectangle(thick, WRIST_HALF_WIDTH, 0.6, WRIST_FRONT - 0.3),
               roundedRectangle(thick - 0.3, WRIST_HALF_WIDTH - 0.3, 0.6, WRIST_FRONT) }, ALONG_X);

    for (int side = -1; side <= 1; side += 2)
    {
        std::vector<Ring> arm;
        for (int i = -1; i <= 10; ++i)
        {
            const double angle = CV_PI / 2 * i / 11, half = FORK_RADIUS * std::cos(i < 0 ? 0 : angle);
            const double w = i < 0 ? WRIST_FRONT - 0.8 : PITCH_TO_YAW + FORK_RADIUS * std::sin(angle), cut = half * 0.12;
            const double inner = side * FORK_INNER, outer = side * FORK_OUTER, edge = side * (FORK_OUTER - 0.3);
            arm.push_back({ Point3d(inner, -half, w), Point3d(inner, half, w), Point3d(edge, half, w), Point3d(outer, half - cut, w),
                            Point3d(outer, cut - half, w), Point3d(edge, -half, w) });
        }
        link.add(arm, ALONG_X);
    }
    const double e = YAW_PIN_END;
    const Point2d yaw(0, PITCH_TO_YAW);
    link.add({ circle(1.7, -FORK_OUTER - 0.02, yaw), circle(1.7, FORK_OUTER + 0.02, yaw) }, ALONG_Y);
    link.add({ circle(0.3, -e, yaw), circle(0.9, -e + 0.12, yaw), circle(1.25, -e + 0.4, yaw), circle(1.25, e - 0.4, yaw),
               circle(0.9, e - 0.12, yaw), circle(0.3, e, yaw) }, ALONG_Y);

    const Point2d boss(4.8, 0);   // on the sides that face the pitch axis
    link.add({ circle(0.6, -WRIST_HALF_WIDTH - RELIEF, boss), circle(0.9, -WRIST_HALF_WIDTH + 0.1, boss),
               circle(0.9, WRIST_HALF_WIDTH - 0.1, boss), circle(0.6, WRIST_HALF_WIDTH + RELIEF, boss) }, ALONG_Z);
    raiseDisc(link, LOGO_DISC, 0.85, RELIEF);
    raiseDisc(link, LOGO_DISC, 0.3, 2 * RELIEF);
    raiseDisc(link, LOGO_WHEEL, 0.7, RELIEF);
    raiseDisc(link, LOGO_WHEEL, 0.2, 2 * RELIEF);
    const Point2d c = LOGO_C, v = LOGO_V;   // the letters C and V
    raiseBar(link, c + Point2d(0, -0.6), c + Point2d(0, 0.6), 0.12);
    raiseBar(link, c + Point2d(0, 0.85), c + Point2d(0.9, 0.85), 0.12);
    raiseBar(link, c + Point2d(0, -0.85), c + Point2d(0.9, -0.85), 0.12);
    raiseBar(link, v, v + Point2d(-0.7, 1.7), 0.12);
    raiseBar(link, v, v + Point2d(0.7, 1.7), 0.12);
    return link.mesh();
}

/* y towards the tip, z the yaw axis. side = -1: the jaw at x < 0. */
Mesh drawJaw(int side)
{
    LinkMesh link;
    link.add(cylinder(2.5, side < 0 ? 0.05 : -1.8, side < 0 ? 1.8 : -0.05, 0.15), ALONG_Z);

    const double toothStart = 3.4, toothEnd = 9.2;
    const int steps = cvRound((toothEnd - toothStart) / (TOOTH_PITCH / 2));
    std::vector<double> along(1, 1.), inner(1, 0.02);
    for (int i = 0; i <= steps; ++i)
    {
        along.push_back(toothStart + i * TOOTH_PITCH / 2);
        inner.push_back(0.02 + (i % 2 ? TOOTH_DEPTH : 0));
    }
    along.push_back(YAW_TO_TIP - 0.15);
    inner.push_back(0.02);
    along.push_back(YAW_TO_TIP);
    inner.push_back(0.1);

    std::vector<Ring> blade, insert;   // the insert carries the teeth and stands out of the blade's flanks
    for (size_t i = 0; i < along.size(); ++i)
    {
        const double y = along[i], taper = std::max(0., (y - 3) / (YAW_TO_TIP - 3)), tip = i + 1 == along.size() ? 0.15 : 0;
        const double back = 2.25 - 1.2 * taper - tip, half = 1.6 - 0.75 * taper - tip, cut = 0.45 - 0.2 * taper;
        const double split = 0.75 - 0.25 * taper, lip = half + 0.15;
        blade.push_back({ Point3d(half, side * 0.4, y), Point3d(half, side * (back - cut), y), Point3d(half - cut, side * back, y),
                          Point3d(cut - half, side * back, y), Point3d(-half, side * (back - cut), y), Point3d(-half, side * 0.4, y) });
        if (i == 0)
            continue;
        insert.push_back({ Point3d(lip, side * inner[i], y), Point3d(lip, side * split, y), Point3d(half - 0.1, side * (split + 0.25), y),
                           Point3d(0.1 - half, side * (split + 0.25), y), Point3d(-lip, side * split, y),
                           Point3d(-lip, side * inner[i], y) });
    }
    link.add(blade, ALONG_Y);
    link.add(insert, ALONG_Y);
    return link.mesh();
}

void addLink(ToolModel::Description& tool, const char* name, int parent, ToolModel::JointType type, int coordinate, double scale,
             double alpha, double a, double theta, double d)
{
    ToolModel::Link link;
    link.name = name;
    link.parent = parent;
    link.jointType = type;
    link.coordinate = coordinate;
    link.scale = scale;
    link.alpha = alpha;
    link.a = a * 1e-3;
    link.theta = theta;
    link.d = d * 1e-3;
    tool.links.push_back(link);
}

void addKeypoint(ToolModel::Description& tool, const char* name, int link, Point3d millimetres)
{
    ToolModel::Keypoint keypoint;
    keypoint.name = name;
    keypoint.link = link;
    keypoint.linkPoint = millimetres * 1e-3;
    tool.keypoints.push_back(keypoint);
}

} // namespace

Ptr<ToolModel> ToolModel::needleDriver()
{
    Description tool;
    tool.name = "needle_driver";
    tool.coordinates = { "q1", "q2", "q3", "q4", "q5", "q6", "jaw" };
    // The patient side manipulator and the wrist of an 8 mm needle driver, as dVRK publishes them.
    enum { OUTER_YAW, OUTER_PITCH, INSERTION, SHAFT, WRIST, YAW, JAW_RIGHT, JAW_LEFT };
    const double right = CV_PI / 2;
    addLink(tool, "outer_yaw", -1, JOINT_REVOLUTE, 0, 1, right, 0, right, 0);
    addLink(tool, "outer_pitch", OUTER_YAW, JOINT_REVOLUTE, 1, 1, -right, 0, -right, 0);
    addLink(tool, "insertion", OUTER_PITCH, JOINT_PRISMATIC, 2, 1, right, 0, 0, -431.8);
    addLink(tool, "shaft", INSERTION, JOINT_REVOLUTE, 3, 1, 0, 0, 0, 416.2);
    addLink(tool, "wrist", SHAFT, JOINT_REVOLUTE, 4, 1, -right, 0, -right, 0);
    addLink(tool, "yaw", WRIST, JOINT_REVOLUTE, 5, 1, -right, PITCH_TO_YAW, -right, 0);
    addLink(tool, "jaw_right", YAW, JOINT_REVOLUTE, 6, 0.5, 0, 0, 0, 0);
    addLink(tool, "jaw_left", YAW, JOINT_REVOLUTE, 6, -0.5, 0, 0, 0, 0);
    tool.endEffectorLink = YAW;
    tool.link_T_endEffector = Matx44d(0, -1, 0, 0, 0, 0, 1, YAW_TO_END_EFFECTOR * 1e-3, -1, 0, 0, 0, 0, 0, 0, 1);

    const Mesh meshes[] = { drawShaft(), drawWrist(), drawJaw(-1), drawJaw(1) };
    const int meshLinks[] = { SHAFT, WRIST, JAW_RIGHT, JAW_LEFT };
    for (int i = 0; i < 4; ++i)
    {
        tool.meshes.push_back(meshes[i]);
        tool.links[meshLinks[i]].mesh = i;
    }

    addKeypoint(tool, "shaft_pivot_flat", SHAFT, Point3d(0, -PITCH_PIN_END, 0));
    addKeypoint(tool, "shaft_pivot_deep", SHAFT, Point3d(0, PITCH_PIN_END, 0));
    const double relief = WRIST_HALF_THICKNESS + RELIEF;
    const struct { const char *flat, *deep; Point2d point; double height; } logo[] = {
        { "logo_disc_flat", "logo_disc_deep", LOGO_DISC, relief + RELIEF },
        { "logo_wheel_flat", "logo_wheel_deep", LOGO_WHEEL, relief + RELIEF },
        { "logo_c_flat", "logo_c_deep", LOGO_C, relief },
        { "logo_v_flat", "logo_v_deep", LOGO_V, relief },
        { "logo_pivot_flat", "logo_pivot_deep", Point2d(0, PITCH_TO_YAW), YAW_PIN_END } };
    for (int i = 0; i < 5; ++i)
    {
        addKeypoint(tool, logo[i].flat, WRIST, Point3d(logo[i].point.y, logo[i].height, logo[i].point.x));
        addKeypoint(tool, logo[i].deep, WRIST, Point3d(logo[i].point.y, -logo[i].height, -logo[i].point.x));
    }
    addKeypoint(tool, "tip_flat", JAW_RIGHT, Point3d(-0.5, YAW_TO_TIP, 0));
    addKeypoint(tool, "tip_deep", JAW_LEFT, Point3d(0.5, YAW_TO_TIP, 0));
    return create(tool);
}

}} // namespace cv::surgtrack
