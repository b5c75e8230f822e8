// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "base/geometry.hpp"
#include "render/box_window.hpp"

namespace cv { namespace surgtrack {

MeshBox boxAbout(const Mesh& mesh)
{
    const std::vector<Point3f>& vertices = mesh.vertices;
    MeshBox box = {vertices[0], vertices[0]};
    for (size_t j = 1; j < vertices.size(); j++)
    {
        box.low = Point3f(std::min(box.low.x, vertices[j].x), std::min(box.low.y, vertices[j].y), std::min(box.low.z, vertices[j].z));
        box.high = Point3f(std::max(box.high.x, vertices[j].x), std::max(box.high.y, vertices[j].y), std::max(box.high.z, vertices[j].z));
    }
    return box;
}

void BoxWindow::add(const Matx44d& camera_T_mesh, const MeshBox& box)
{
    Point3d corners[8];
    for (int c = 0; c < 8; c++)
        corners[c] = transform(camera_T_mesh, Point3d(c & 1 ? box.high.x : box.low.x, c & 2 ? box.high.y : box.low.y, c & 4 ? box.high.z : box.low.z));
    for (int c = 0; c < 8; c++)
        for (int axis = 1; axis < 8; axis *= 2)
        {
            if (c & axis) continue;
            Point3d p = corners[c], q = corners[c | axis];
            if (p.z < nearestDepth && q.z < nearestDepth) continue;
            if (p.z < nearestDepth) p = p + (q - p) * ((nearestDepth - p.z) / (q.z - p.z));
            if (q.z < nearestDepth) q = q + (p - q) * ((nearestDepth - q.z) / (p.z - q.z));
            left_ = std::min(left_, std::min(p.x / p.z, q.x / q.z));
            right_ = std::max(right_, std::max(p.x / p.z, q.x / q.z));
            top_ = std::min(top_, std::min(p.y / p.z, q.y / q.z));
            bottom_ = std::max(bottom_, std::max(p.y / p.z, q.y / q.z));
        }
}

Rect BoxWindow::get(const CameraModel& camera, const Rect2d& field) const
{
    const double left = std::max(left_, field.x), right = std::min(right_, field.x + field.width);
    const double top = std::max(top_, field.y), bottom = std::min(bottom_, field.y + field.height);
    if (!(left < right && top < bottom)) return Rect();
    double x0 = DBL_MAX, x1 = -DBL_MAX, y0 = DBL_MAX, y1 = -DBL_MAX;
    const int samples = 8;   // of a border, which a lens bends
    for (int i = 0; i <= samples; i++)
        for (int side = 0; side < 4; side++)
        {
            const double s = double(i) / samples, x = left + (right - left) * s, y = top + (bottom - top) * s;
            const Point2d p = camera.project(side == 0 ? Point3d(x, top, 1) : side == 1 ? Point3d(x, bottom, 1) : side == 2 ? Point3d(left, y, 1) : Point3d(right, y, 1));
            x0 = std::min(x0, p.x);
            x1 = std::max(x1, p.x);
            y0 = std::min(y0, p.y);
            y1 = std::max(y1, p.y);
        }
    // About the image, where an int has room for them.
    const Size size = camera.imageSize();
    x0 = std::min(std::max(x0, -16.), size.width + 16.);
    x1 = std::min(std::max(x1, -16.), size.width + 16.);
    y0 = std::min(std::max(y0, -16.), size.height + 16.);
    y1 = std::min(std::max(y1, -16.), size.height + 16.);
    return Rect(Point(cvFloor(x0) - 3, cvFloor(y0) - 3), Point(cvCeil(x1) + 4, cvCeil(y1) + 4)) & Rect(Point(), size);
}

}} // namespace cv::surgtrack
