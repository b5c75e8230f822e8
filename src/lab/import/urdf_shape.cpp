// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "base/geometry.hpp"
#include "lab/import/urdf_shape.hpp"
#include "model/mesh.hpp"

#ifdef HAVE_URDFDOM

namespace cv { namespace surgtrack {

// Corners are those of a band of rings, from the bottom to the top.
Mesh shapeMesh(const urdf::Geometry& geometry, const Matx44d& link_T_shape)
{
    const int sides = geometry.type == urdf::Geometry::BOX ? 4 : 48;
    std::vector<Vec2d> profile;   // radius and z of the rings
    Vec2d stretch(1, 1);
    if (geometry.type == urdf::Geometry::SPHERE)
        for (int i = 0; i <= sides / 2; i++)
            profile.push_back(static_cast<const urdf::Sphere&>(geometry).radius * Vec2d(std::sin(i * 2 * CV_PI / sides), -std::cos(i * 2 * CV_PI / sides)));
    else
    {
        const bool box = geometry.type == urdf::Geometry::BOX;
        const urdf::Vector3 dim = box ? static_cast<const urdf::Box&>(geometry).dim : urdf::Vector3();
        const double radius = box ? std::sqrt(0.5) : static_cast<const urdf::Cylinder&>(geometry).radius;
        const double half = (box ? dim.z : static_cast<const urdf::Cylinder&>(geometry).length) / 2;
        const Vec2d rings[] = { Vec2d(0, -half), Vec2d(radius, -half), Vec2d(radius, half), Vec2d(0, half) };
        profile.assign(rings, rings + 4);
        if (box)
            stretch = Vec2d(dim.x, dim.y);
    }
    Mesh mesh;
    for (size_t ring = 0; ring < profile.size(); ring++)
        for (int i = 0; i < sides; i++)
        {
            const double angle = (i + 0.5) * 2 * CV_PI / sides, r = profile[ring][0];
            mesh.vertices.push_back(Point3f(transform(link_T_shape, Point3d(stretch[0] * r * std::cos(angle), stretch[1] * r * std::sin(angle),
                                                                            profile[ring][1]))));
        }
    for (int ring = 0; ring + 1 < (int)profile.size(); ring++)
        for (int i = 0; i < sides; i++)
        {
            const int a = ring * sides + i, b = ring * sides + (i + 1) % sides;
            if (profile[ring][0] > 1e-9)   // else its corners are one point
                mesh.triangles.push_back(Vec3i(a, b, b + sides));
            if (profile[ring + 1][0] > 1e-9)
                mesh.triangles.push_back(Vec3i(a, b + sides, a + sides));
        }
    computeNormals(mesh);
    return mesh;
}

}} // namespace cv::surgtrack

#endif
