// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "lab/tool/surface.hpp"

namespace cv { namespace surgtrack {

Vec3d nearestOnSegment(const Vec3d& p, const Vec3d& a, const Vec3d& b)
{
    const Vec3d d = b - a;
    return a + d * std::min(std::max((p - a).dot(d) / std::max(d.dot(d), DBL_MIN), 0.), 1.);
}

Vec3d nearestOnTriangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c)
{
    const Vec3d n = (b - a).cross(c - a);
    const bool above = n.dot((b - a).cross(p - a)) >= 0 && n.dot((c - b).cross(p - b)) >= 0 && n.dot((a - c).cross(p - c)) >= 0;
    if (above && norm(n) > 0)
        return p - n * (n.dot(p - a) / n.dot(n));
    const Vec3d edges[] = { nearestOnSegment(p, a, b), nearestOnSegment(p, b, c), nearestOnSegment(p, c, a) };
    return *std::min_element(edges, edges + 3, [&](const Vec3d& u, const Vec3d& v) { return norm(u - p) < norm(v - p); });
}

double distanceTo(const Mesh& mesh, const Point3d& point)
{
    double nearest = DBL_MAX;
    for (size_t i = 0; i < mesh.triangles.size(); i++)
    {
        const Vec3i& t = mesh.triangles[i];
        const Vec3d on = nearestOnTriangle(Vec3d(point), Vec3d(Point3d(mesh.vertices[t[0]])), Vec3d(Point3d(mesh.vertices[t[1]])), Vec3d(Point3d(mesh.vertices[t[2]])));
        nearest = std::min(nearest, norm(on - Vec3d(point)));
    }
    return nearest;
}

}} // namespace cv::surgtrack
