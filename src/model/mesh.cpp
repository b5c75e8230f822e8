// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "model/mesh.hpp"

#include <cstring>

namespace cv { namespace surgtrack {

Mesh::Mesh() {}

Mesh::Mesh(const std::vector<Point3f>& _vertices, const std::vector<Point3f>& _normals, const std::vector<Vec3i>& _triangles)
    : vertices(_vertices), normals(_normals), triangles(_triangles)
{
}

namespace {

const double FEATURE_ANGLE = 35 * CV_PI / 180;   // sharper edges are creases

uint64 hashOf(const Point3f& p)
{
    uint64 h = 0;
    const float xyz[] = { p.x, p.y, p.z };
    for (int i = 0; i < 3; ++i)
    {
        Cv32suf bits;
        bits.f = xyz[i] + 0.f;   // -0 is 0
        h = (h ^ bits.u) * 0x9E3779B97F4A7C15ULL;
        h ^= h >> 29;
    }
    return h;
}

//! The triangles on the other side of each one's edges; -1: none, or an edge of more than two.
struct Neighbours
{
    explicit Neighbours(const std::vector<Vec3i>& triangles) : across(triangles.size(), Vec3i::all(-1)), isClosed(!triangles.empty())
    {
        struct Edge { int a, b, side; bool operator<(const Edge& o) const { return a != o.a ? a < o.a : b != o.b ? b < o.b : side < o.side; } };
        std::vector<Edge> edges;
        edges.reserve(3 * triangles.size());
        for (int t = 0; t < (int)triangles.size(); ++t)
            for (int k = 0; k < 3; ++k)
            {
                const int a = triangles[t][k], b = triangles[t][(k + 1) % 3];
                const Edge edge = { std::min(a, b), std::max(a, b), 3 * t + k };
                edges.push_back(edge);
            }
        std::sort(edges.begin(), edges.end());
        for (size_t i = 0, next; i < edges.size(); i = next)
        {
            for (next = i + 1; next < edges.size() && edges[next].a == edges[i].a && edges[next].b == edges[i].b; )
                ++next;
            isClosed = isClosed && (next - i) % 2 == 0;
            if (next - i != 2)
                continue;
            across[edges[i].side / 3][edges[i].side % 3] = edges[i + 1].side / 3;
            across[edges[i + 1].side / 3][edges[i + 1].side % 3] = edges[i].side / 3;
        }
    }

    std::vector<Vec3i> across;
    bool isClosed;      //!< each edge has a triangle on both sides
};

//! Whether two triangles that share an edge run along it in opposite directions.
bool agree(const Vec3i& t, int side, const Vec3i& other)
{
    const int a = t[side], b = t[(side + 1) % 3];
    for (int k = 0; k < 3; ++k)
        if (other[k] == b && other[(k + 1) % 3] == a)
            return true;
    return false;
}

double volumeBelow(const Mesh& mesh, const Vec3i& t, const Point3d& origin)
{
    const Point3d a = Point3d(mesh.vertices[t[0]]) - origin, b = Point3d(mesh.vertices[t[1]]) - origin, c = Point3d(mesh.vertices[t[2]]) - origin;
    return a.dot(b.cross(c));
}

/* All triangles of a piece look to the side of its first one; of a closed mesh, outward. Pieces end at edges of more than two triangles
too: seen from the middle of all, most of their volume is on the right side even so. */
void orient(Mesh& mesh, Neighbours& neighbours)
{
    Point3d origin;
    for (size_t i = 0; i < mesh.vertices.size(); ++i)
        origin += Point3d(mesh.vertices[i]) * (1. / (double)mesh.vertices.size());
    std::vector<uchar> seen(mesh.triangles.size(), 0);
    std::vector<int> piece;
    for (int start = 0; start < (int)seen.size(); ++start)
    {
        if (seen[start])
            continue;
        piece.assign(1, start);
        seen[start] = 1;
        double volume = 0;
        for (size_t i = 0; i < piece.size(); ++i)
        {
            const Vec3i t = mesh.triangles[piece[i]];
            volume += volumeBelow(mesh, t, origin);
            for (int k = 0; k < 3; ++k)
            {
                const int other = neighbours.across[piece[i]][k];
                if (other < 0 || seen[other])
                    continue;
                seen[other] = 1;
                piece.push_back(other);
                if (!agree(t, k, mesh.triangles[other]))
                {
                    std::swap(mesh.triangles[other][1], mesh.triangles[other][2]);
                    std::swap(neighbours.across[other][0], neighbours.across[other][2]);
                }
            }
        }
        for (size_t i = 0; neighbours.isClosed && volume < 0 && i < piece.size(); ++i)
        {
            std::swap(mesh.triangles[piece[i]][1], mesh.triangles[piece[i]][2]);
            std::swap(neighbours.across[piece[i]][0], neighbours.across[piece[i]][2]);
        }
    }
}

Vec3f unitNormal(const Mesh& mesh, const Vec3i& t)
{
    const Point3d a(mesh.vertices[t[0]]), b(mesh.vertices[t[1]]), c(mesh.vertices[t[2]]);
    const Vec3d n((b - a).cross(c - a));
    const double length = norm(n);
    return length > 0 ? Vec3f(n / length) : Vec3f();
}

int rootOf(std::vector<int>& parents, int i)
{
    while (parents[i] != i)
        i = parents[i] = parents[parents[i]];
    return i;
}

} // namespace

void mergePoints(Mesh& mesh)
{
    size_t slots = 16;
    while (slots < 2 * mesh.vertices.size())
        slots *= 2;
    std::vector<int> table(slots, -1), place(mesh.vertices.size(), -1);
    std::vector<Point3f> merged;
    std::vector<Vec3i> triangles;
    triangles.reserve(mesh.triangles.size());
    for (size_t i = 0; i < mesh.triangles.size(); ++i)
    {
        Vec3i t = mesh.triangles[i];
        for (int k = 0; k < 3; ++k)
        {
            int& index = place[t[k]];
            if (index < 0)
            {
                const Point3f p = mesh.vertices[t[k]];
                size_t slot = (size_t)(hashOf(p) >> 20) & (slots - 1);
                while (table[slot] >= 0 && merged[table[slot]] != p)
                    slot = (slot + 1) & (slots - 1);
                if (table[slot] < 0)
                {
                    table[slot] = (int)merged.size();
                    merged.push_back(p);
                }
                index = table[slot];
            }
            t[k] = index;
        }
        if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0])
            triangles.push_back(t);
    }
    mesh.vertices.swap(merged);
    mesh.triangles.swap(triangles);
    mesh.normals.clear();
}

void computeNormals(Mesh& mesh)
{
    mergePoints(mesh);
    Neighbours neighbours(mesh.triangles);
    orient(mesh, neighbours);
    std::vector<Vec3f> normals;
    for (size_t i = 0; i < mesh.triangles.size(); ++i)
        normals.push_back(unitNormal(mesh, mesh.triangles[i]));

    // Corners of triangles that meet at a vertex over edges that are no creases share its normal.
    const float crease = (float)std::cos(FEATURE_ANGLE);
    std::vector<int> corners(3 * mesh.triangles.size());
    for (int i = 0; i < (int)corners.size(); ++i)
        corners[i] = i;
    for (int t = 0; t < (int)mesh.triangles.size(); ++t)
        for (int k = 0; k < 3; ++k)
        {
            const int other = neighbours.across[t][k];
            if (other <= t || normals[t].dot(normals[other]) < crease)
                continue;
            for (int end = 0; end < 2; ++end)
                for (int c = 0; c < 3; ++c)
                    if (mesh.triangles[other][c] == mesh.triangles[t][(k + end) % 3])
                        corners[rootOf(corners, 3 * other + c)] = rootOf(corners, 3 * t + (k + end) % 3);
        }
    std::vector<int> vertexOf(corners.size(), -1);
    std::vector<uchar> taken(mesh.vertices.size(), 0);
    mesh.normals.assign(mesh.vertices.size(), Point3f());
    for (int i = 0; i < (int)corners.size(); ++i)
    {
        int& vertex = vertexOf[rootOf(corners, i)];
        int& corner = mesh.triangles[i / 3][i % 3];
        if (vertex < 0 && taken[corner])
        {
            vertex = (int)mesh.vertices.size();
            mesh.vertices.push_back(Point3f(mesh.vertices[corner]));
            mesh.normals.push_back(Point3f());
        }
        else if (vertex < 0)
        {
            vertex = corner;
            taken[corner] = 1;
        }
        corner = vertex;
        mesh.normals[vertex] += Point3f(normals[i / 3]);
    }
    for (size_t i = 0; i < mesh.normals.size(); ++i)
    {
        const double length = norm(mesh.normals[i]);
        mesh.normals[i] = length > 0 ? mesh.normals[i] * (float)(1 / length) : Point3f(0, 0, 1);
    }
}

}} // namespace cv::surgtrack
