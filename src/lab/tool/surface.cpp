// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "lab/tool/surface.hpp"

namespace cv { namespace surgtrack {

static double toSegment(const Vec3d& p, const Vec3d& a, const Vec3d& b)
{
    const Vec3d d = b - a;
    const double along = std::min(std::max((p - a).dot(d) / std::max(d.dot(d), DBL_MIN), 0.), 1.);
    return norm(p - a - d * along);
}

static double toTriangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c)
{
    const Vec3d n = (b - a).cross(c - a);
    const double edges = std::min(toSegment(p, a, b), std::min(toSegment(p, b, c), toSegment(p, c, a)));
    const bool above = n.dot((b - a).cross(p - a)) >= 0 && n.dot((c - b).cross(p - b)) >= 0 && n.dot((a - c).cross(p - c)) >= 0;
    return above && norm(n) > 0 ? std::abs(n.dot(p - a)) / norm(n) : edges;
}

double distanceTo(const Mesh& mesh, const Point3d& point)
{
    double nearest = DBL_MAX;
    for (size_t i = 0; i < mesh.triangles.size(); i++)
    {
        const Vec3i& t = mesh.triangles[i];
        nearest = std::min(nearest, toTriangle(Vec3d(point), Vec3d(Point3d(mesh.vertices[t[0]])), Vec3d(Point3d(mesh.vertices[t[1]])), Vec3d(Point3d(mesh.vertices[t[2]]))));
    }
    return nearest;
}

}} // namespace cv::surgtrack
