// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "lab/tool/simplified.hpp"
#include "model/mesh.hpp"

namespace cv { namespace surgtrack {

namespace {

const double GRID = 1e-6;      // [m]: a sixtieth of a pixel of the pictures that points are tried in, and thirty times what rounding moves half a metre away
const double ASIDE = 0.1234567;   // files have decimal numbers, and none of them lies on a border of this grid

float onGrid(float x) { return (float)(GRID * std::floor(x / GRID + 0.5 + ASIDE)); }

bool isBefore(const Point3f& a, const Point3f& b) { return a.x != b.x ? a.x < b.x : a.y != b.y ? a.y < b.y : a.z < b.z; }

Mesh canonicalMesh(const Mesh& mesh)
{
    std::vector<Point3f> places;
    for (size_t i = 0; i < mesh.vertices.size(); i++)
        places.push_back(Point3f(onGrid(mesh.vertices[i].x), onGrid(mesh.vertices[i].y), onGrid(mesh.vertices[i].z)));
    Mesh sorted;
    sorted.vertices = places;
    std::sort(sorted.vertices.begin(), sorted.vertices.end(), isBefore);
    sorted.vertices.erase(std::unique(sorted.vertices.begin(), sorted.vertices.end()), sorted.vertices.end());
    std::vector<int> number;
    for (size_t i = 0; i < places.size(); i++)
        number.push_back((int)(std::lower_bound(sorted.vertices.begin(), sorted.vertices.end(), places[i], isBefore) - sorted.vertices.begin()));
    for (size_t i = 0; i < mesh.triangles.size(); i++)
    {
        Vec3i t = mesh.triangles[i];
        for (int k = 0; k < 3; k++)
            t[k] = number[t[k]];
        std::sort(t.val, t.val + 3);   // which side is outside is found anew
        sorted.triangles.push_back(t);
    }
    std::sort(sorted.triangles.begin(), sorted.triangles.end(),
              [](const Vec3i& a, const Vec3i& b) { return std::lexicographical_compare(a.val, a.val + 3, b.val, b.val + 3); });
    computeNormals(sorted);
    return sorted;
}

} // namespace

Ptr<ToolModel> canonical(const Ptr<ToolModel>& model)
{
    ToolModel::Description tool = model->description();
    for (size_t i = 0; i < tool.meshes.size(); i++)
        tool.meshes[i] = canonicalMesh(tool.meshes[i]);
    return ToolModel::create(tool);
}

}} // namespace cv::surgtrack
