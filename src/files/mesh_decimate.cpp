// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "files/mesh_io.hpp"
#include "model/mesh.hpp"

#include <meshoptimizer.h>

namespace cv { namespace surgtrack {

namespace {

typedef std::vector<unsigned> Indices;   // three a triangle

/** Collapses edges while the surface moves by less than error [m], and more than `most` triangles are left.
@param options of meshoptimizer
@return the error that came to [m] */
double collapse(const std::vector<Point3f>& vertices, Indices& indices, double error, size_t most, unsigned options)
{
    const float extent = meshopt_simplifyScale(&vertices[0].x, vertices.size(), sizeof(Point3f));
    Indices result(indices.size());
    float reached = 0;
    result.resize(meshopt_simplify(&result[0], &indices[0], indices.size(), &vertices[0].x, vertices.size(), sizeof(Point3f), 3 * most, (float)(error / extent),
                                   options, &reached));
    indices.swap(result);
    return reached * extent;
}

/* A slice of a mesh by itself: meshoptimizer counts in single precision, relative to what it is given. */
double collapseSlice(const std::vector<Point3f>& vertices, Indices& indices, double error, size_t most)
{
    std::vector<unsigned> used(indices);
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    std::vector<Point3f> own;
    for (size_t i = 0; i < used.size(); ++i)
        own.push_back(vertices[used[i]]);
    for (size_t i = 0; i < indices.size(); ++i)
        indices[i] = (unsigned)(std::lower_bound(used.begin(), used.end(), indices[i]) - used.begin());
    const double reached = collapse(own, indices, error, most, meshopt_SimplifyLockBorder);
    for (size_t i = 0; i < indices.size(); ++i)
        indices[i] = used[indices[i]];
    return reached;
}

Vec3d sidesOf(const std::vector<Point3f>& vertices, Point3f& low)
{
    Point3f high = low = vertices[0];
    for (size_t i = 0; i < vertices.size(); ++i)
    {
        const Point3f& v = vertices[i];
        low = Point3f(std::min(low.x, v.x), std::min(low.y, v.y), std::min(low.z, v.z));
        high = Point3f(std::max(high.x, v.x), std::max(high.y, v.y), std::max(high.z, v.z));
    }
    return Vec3d(Point3d(high - low));
}

double largestSide(const std::vector<Mesh>& meshes)
{
    double largest = 0;
    Point3f low;
    for (size_t m = 0; m < meshes.size(); ++m)
        largest = std::max(largest, norm(sidesOf(meshes[m].vertices, low), NORM_INF));
    return largest;
}

//! Drops pairs of triangles with the same corners: of what was folded flat both sides are left.
void dropFolds(std::vector<Vec3i>& triangles)
{
    typedef std::pair<Vec3i, int> Keyed;
    std::vector<Keyed> keyed;
    for (size_t i = 0; i < triangles.size(); ++i)
    {
        Vec3i corners = triangles[i];
        std::sort(corners.val, corners.val + 3);
        keyed.push_back(Keyed(corners, (int)i));
    }
    std::sort(keyed.begin(), keyed.end(), [](const Keyed& a, const Keyed& b)
    {
        return std::lexicographical_compare(a.first.val, a.first.val + 3, b.first.val, b.first.val + 3);
    });
    std::vector<uchar> dropped(triangles.size(), 0);
    for (size_t i = 1; i < keyed.size(); ++i)
        if (keyed[i].first == keyed[i - 1].first)
            dropped[keyed[i].second] = dropped[keyed[i - 1].second] = 1;
    size_t kept = 0;
    for (size_t i = 0; i < triangles.size(); ++i)
        if (!dropped[i])
            triangles[kept++] = triangles[i];
    triangles.resize(kept);
}

float along(const Point3f& p, int axis) { return axis == 0 ? p.x : axis == 1 ? p.y : p.z; }

/* A shaft is half a metre long, and edges of a hundredth of a millimetre count: such meshes go in slices, cut elsewhere each time.
phase: of the cuts, 0..1 */
double collapseLong(const std::vector<Point3f>& vertices, Indices& indices, double error, size_t most, double phase)
{
    Point3f low;
    Vec3d sides = sidesOf(vertices, low);
    const int axis = (int)(std::max_element(sides.val, sides.val + 3) - sides.val);
    const double start = along(low, axis), length = sides[axis];
    std::sort(sides.val, sides.val + 3);
    const double slice = std::max(2 * sides[1], 1e-2 * length);
    if (length < 2 * slice)
        return collapse(vertices, indices, error, most, 0);
    std::vector<Indices> slices((size_t)(length / slice) + 2);
    Indices rest;   // what is longer than a slice needs no thinning
    for (size_t i = 0; i < indices.size(); i += 3)
    {
        const float a = along(vertices[indices[i]], axis), b = along(vertices[indices[i + 1]], axis), c = along(vertices[indices[i + 2]], axis);
        const bool isLong = std::max(a, std::max(b, c)) - std::min(a, std::min(b, c)) > slice;
        Indices& to = isLong ? rest : slices[(size_t)(((a + b + c) / 3 - start) / slice + phase)];
        to.insert(to.end(), indices.begin() + i, indices.begin() + i + 3);
    }
    const double share = (double)most / (indices.size() / 3);
    double reached = 0;
    indices.swap(rest);
    for (size_t i = 0; i < slices.size(); ++i)
        if (!slices[i].empty())
        {
            reached = std::max(reached, collapseSlice(vertices, slices[i], error, (size_t)(share * (slices[i].size() / 3))));
            indices.insert(indices.end(), slices[i].begin(), slices[i].end());
        }
    return reached;
}

//! Collapses all meshes by the same error. share: of its triangles so many stay in any case, 0..1. @return the number of triangles left
size_t collapseAll(const std::vector<Mesh>& meshes, std::vector<Indices>& indices, double error, double share, bool slices, double phase)
{
    size_t left = 0;
    for (size_t m = 0; m < meshes.size(); ++m)
    {
        const size_t most = (size_t)(share * (double)(indices[m].size() / 3));
        if (slices)
            collapseLong(meshes[m].vertices, indices[m], error, most, phase);
        else
            collapse(meshes[m].vertices, indices[m], error, most, 0);
        left += indices[m].size() / 3;
    }
    return left;
}

/* One error for all meshes: so the triangles stay where they are needed most. It is sought between one that leaves too many and one that
takes too many; where many edges are alike, as on a flat part, the last ones go by number. */
void collapseTo(const std::vector<Mesh>& meshes, std::vector<Indices>& indices, size_t triangles, int maxTriangles)
{
    const double extent = largestSide(meshes), rough = 2e-4 * extent;   // rough: no slices any more
    const size_t enough = 5 * (size_t)maxTriangles;
    double error = 5e-7 * extent, phase = 0, low = 0, high = 0;
    for (size_t m = 0; m < meshes.size(); ++m)   // a first step by number, as each one with a million triangles takes a second
        if (indices[m].size() / 3 > enough)
            error = std::max(error, 2 * collapseLong(meshes[m].vertices, indices[m], rough, enough, phase));
    while (triangles > (size_t)maxTriangles && error < extent)
    {
        std::vector<Indices> next = indices;
        phase = std::fmod(phase + 0.38, 1.);
        const bool last = high > 0 && (high < 1.02 * low || high < 1e-8 * extent);
        const size_t left = collapseAll(meshes, next, error, last ? (double)maxTriangles / (double)triangles : 0, error < rough, phase);
        if (last)
            high = 0;
        if (left < 0.995 * maxTriangles && !last)
            high = error;
        else
        {
            indices.swap(next);
            triangles = left;
            low = error;
        }
        const bool close = high > 0 && (high < 1.02 * low || high < 1e-8 * extent);
        error = high == 0 ? 2 * error : close ? high : low == 0 ? high / 4 : std::sqrt(low * high);
    }
}

} // namespace

void decimateMeshes(std::vector<Mesh>& meshes, int maxTriangles)
{
    std::vector<Indices> indices(meshes.size());
    size_t triangles = 0;
    for (size_t m = 0; m < meshes.size(); ++m)
    {
        for (size_t i = 0; i < meshes[m].triangles.size(); ++i)
            for (int k = 0; k < 3; ++k)
                indices[m].push_back((unsigned)meshes[m].triangles[i][k]);
        triangles += meshes[m].triangles.size();
    }
    if (triangles <= (size_t)maxTriangles)
        return;
    collapseTo(meshes, indices, triangles, maxTriangles);
    for (size_t m = 0; m < meshes.size(); ++m)
    {
        meshes[m].triangles.clear();
        for (size_t i = 0; i < indices[m].size(); i += 3)
            meshes[m].triangles.push_back(Vec3i((int)indices[m][i], (int)indices[m][i + 1], (int)indices[m][i + 2]));
        dropFolds(meshes[m].triangles);
        mergePoints(meshes[m]);
    }
}

}} // namespace cv::surgtrack
