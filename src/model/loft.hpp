// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_MODEL_LOFT_HPP
#define OPENCV_SURGTRACK_SRC_MODEL_LOFT_HPP

#include "opencv2/surgtrack/tool_model.hpp"
#include "model/mesh.hpp"

// What the built-in tools are drawn with. Lengths in these files are millimetres.

namespace cv { namespace surgtrack {

// Solids are lofts: closed convex rings of equal size, in planes of constant w, joined and capped. Their (u, v, w) are the
// link's axes turned cyclically, so that w is the axis wanted.
typedef std::vector<Point3d> Ring;
static const Matx33d ALONG_X(0, 0, 1, 1, 0, 0, 0, 1, 0);   // (u, v, w) = (y, z, x)
static const Matx33d ALONG_Y(0, 1, 0, 0, 0, 1, 1, 0, 0);   // (u, v, w) = (z, x, y)
static const Matx33d ALONG_Z = Matx33d::eye();
static const Matx33d HALF_TURN_ABOUT_X(1, 0, 0, 0, -1, 0, 0, 0, -1);

inline Ring circle(double radius, double w, Point2d centre = Point2d(), int corners = 32)
{
    Ring ring;
    for (int i = 0; i < corners; ++i)
    {
        const double angle = CV_2PI * i / corners;
        ring.push_back(Point3d(centre.x + radius * std::cos(angle), centre.y + radius * std::sin(angle), w));
    }
    return ring;
}

/* A rectangle about the line from p to q that extends by the margin on all sides. */
inline Ring bar(Point2d p, Point2d q, double margin, double w)
{
    const Point2d along = (q - p) * (margin / norm(q - p)), across(-along.y, along.x);
    const Point2d corners[] = { p - along - across, q + along - across, q + along + across, p - along + across };
    Ring ring;
    for (int i = 0; i < 4; ++i)
        ring.push_back(Point3d(corners[i].x, corners[i].y, w));
    return ring;
}

/* A rectangle with its corners cut. */
inline Ring roundedRectangle(double halfU, double halfV, double cut, double w)
{
    const double u[] = { halfU, halfU, halfU - cut, cut - halfU, -halfU, -halfU, cut - halfU, halfU - cut };
    const double v[] = { cut - halfV, halfV - cut, halfV, halfV, halfV - cut, cut - halfV, -halfV, -halfV };
    Ring ring;
    for (int i = 0; i < 8; ++i)
        ring.push_back(Point3d(u[i], v[i], w));
    return ring;
}

inline std::vector<Ring> cylinder(double radius, double w0, double w1, double chamfer, int corners = 32)
{
    const Point2d axis;
    return { circle(radius - chamfer, w0, axis, corners), circle(radius, w0 + chamfer, axis, corners),
             circle(radius, w1 - chamfer, axis, corners), circle(radius - chamfer, w1, axis, corners) };
}

/* The mesh of one link. */
class LinkMesh
{
public:
    void add(const std::vector<Ring>& rings, const Matx33d& axes)
    {
        Mesh solid;
        const int n = (int)rings[0].size(), last = (int)rings.size() - 1;
        for (size_t r = 0; r < rings.size(); ++r)
            for (int i = 0; i < n; ++i)
                solid.vertices.push_back(axes * rings[r][i] * 1e-3);
        for (int r = 0; r < last; ++r)
            for (int i = 0; i < n; ++i)
            {
                const int a = r * n + i, b = r * n + (i + 1) % n;
                solid.triangles.push_back(Vec3i(a, b, b + n));
                solid.triangles.push_back(Vec3i(a, b + n, a + n));
            }
        for (int i = 1; i + 1 < n; ++i)
        {
            solid.triangles.push_back(Vec3i(0, i + 1, i));
            solid.triangles.push_back(Vec3i(last * n, last * n + i, last * n + i + 1));
        }
        // Each solid on its own: solids only overlap, and shading is not to blend across them.
        computeNormals(solid);
        const int offset = (int)mesh_.vertices.size();
        mesh_.vertices.insert(mesh_.vertices.end(), solid.vertices.begin(), solid.vertices.end());
        mesh_.normals.insert(mesh_.normals.end(), solid.normals.begin(), solid.normals.end());
        for (size_t i = 0; i < solid.triangles.size(); ++i)
            mesh_.triangles.push_back(solid.triangles[i] + Vec3i::all(offset));
    }

    const Mesh& mesh() const { return mesh_; }

private:
    Mesh mesh_;
};

}} // namespace cv::surgtrack

#endif
