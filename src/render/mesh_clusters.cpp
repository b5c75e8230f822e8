// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "render/mesh_clusters.hpp"
#include "render/mesh_visibility.hpp"

namespace cv { namespace surgtrack { namespace {

const size_t largest = 64;          // triangles of a cluster
const float normalWeight = 0.02f;  // [m]; normals this much apart (1 = 60 degrees) separate triangles as a distance does

// A triangle for the clustering: its centre [m] and its normal, weighted.
struct Facet
{
    float at[6];
    int index;
};

struct ByCoordinate
{
    explicit ByCoordinate(int axis) : axis_(axis) {}
    bool operator()(const Facet& a, const Facet& b) const
    {
        return a.at[axis_] != b.at[axis_] ? a.at[axis_] < b.at[axis_] : a.index < b.index;
    }
    int axis_;
};

Point3f faceNormal(const Mesh& mesh, const Vec3i& t)
{
    const Point3f a = mesh.vertices[t[0]], n = (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a);
    const double length = norm(n);
    return length > 0 ? n * float(1 / length) : Point3f();
}

void enclose(const ClusteredMesh& mesh, int first, int last, Point3f& centre, float& radius)
{
    Point3f lo(FLT_MAX, FLT_MAX, FLT_MAX), hi = -lo;
    for (int i = first; i < last; i++)
    {
        lo = Point3f(std::min(lo.x, mesh.x[i]), std::min(lo.y, mesh.y[i]), std::min(lo.z, mesh.z[i]));
        hi = Point3f(std::max(hi.x, mesh.x[i]), std::max(hi.y, mesh.y[i]), std::max(hi.z, mesh.z[i]));
    }
    centre = (lo + hi) * 0.5f;
    double squared = 0;
    for (int i = first; i < last; i++)
    {
        const Point3f d = Point3f(mesh.x[i], mesh.y[i], mesh.z[i]) - centre;
        squared = std::max(squared, d.ddot(d));
    }
    radius = float(std::sqrt(squared) * (1 + 1e-6));
}

class Clusterer
{
public:
    Clusterer(const Mesh& mesh, ClusteredMesh& result) : mesh_(mesh), result_(result), local_(mesh.vertices.size(), -1) {}

    // Halves the facets where they differ most, until they are few.
    void split(Facet* first, Facet* last, bool oneSided)
    {
        if (size_t(last - first) <= largest)
        {
            if (first != last) add(first, last, oneSided);
            return;
        }
        int widest = 0;
        float width = -1;
        for (int axis = 0; axis < 6; axis++)
        {
            float lo = FLT_MAX, hi = -FLT_MAX;
            for (const Facet* f = first; f != last; f++)
            {
                lo = std::min(lo, f->at[axis]);
                hi = std::max(hi, f->at[axis]);
            }
            if (hi - lo > width) width = hi - lo, widest = axis;
        }
        Facet* middle = first + (last - first) / 2;
        std::nth_element(first, middle, last, ByCoordinate(widest));
        split(first, middle, oneSided);
        split(middle, last, oneSided);
    }

private:
    void add(const Facet* first, const Facet* last, bool oneSided)
    {
        MeshCluster cluster;
        cluster.oneSided = oneSided;
        cluster.firstVertex = int(result_.x.size());
        cluster.firstTriangle = int(result_.a.size());
        std::vector<int> used;
        Point3f sum;
        for (const Facet* f = first; f != last; f++)
        {
            const Vec3i& t = mesh_.triangles[f->index];
            uchar corners[3];
            for (int i = 0; i < 3; i++)
            {
                if (local_[t[i]] < 0)
                {
                    local_[t[i]] = int(used.size());
                    used.push_back(t[i]);
                    addVertex(t[i]);
                }
                corners[i] = uchar(local_[t[i]]);
            }
            addTriangle(corners[0], corners[1], corners[2]);
            sum += faceNormal(mesh_, t);
        }
        while ((result_.a.size() - cluster.firstTriangle) % ClusteredMesh::padding) addTriangle(0, 0, 0);
        cluster.triangles = int(result_.a.size()) - cluster.firstTriangle;
        while ((result_.x.size() - cluster.firstVertex) % ClusteredMesh::padding) addVertex(used.back());
        cluster.vertices = int(result_.x.size()) - cluster.firstVertex;
        for (size_t i = 0; i < used.size(); i++) local_[used[i]] = -1;

        enclose(result_, cluster.firstVertex, int(result_.x.size()), cluster.centre, cluster.radius);
        cluster.sine = 2;
        const double length = norm(sum);
        if (oneSided && length > 0)
        {
            cluster.axis = sum * float(1 / length);
            float cosine = 1;
            for (const Facet* f = first; f != last; f++)
            {
                const Point3f n = faceNormal(mesh_, mesh_.triangles[f->index]);
                if (n != Point3f()) cosine = std::min(cosine, n.dot(cluster.axis));
            }
            if (cosine > 0) cluster.sine = std::sqrt(std::max(0.f, 1 - cosine * cosine)) + 1e-4f;
        }
        result_.clusters.push_back(cluster);
    }

    void addTriangle(uchar a, uchar b, uchar c)
    {
        result_.a.push_back(a);
        result_.b.push_back(b);
        result_.c.push_back(c);
    }

    void addVertex(int index)
    {
        const Point3f &p = mesh_.vertices[index], &n = mesh_.normals[index];
        const double length = norm(n);
        const float s = length > 0 ? float(1 / length) : 0.f;
        result_.x.push_back(p.x);
        result_.y.push_back(p.y);
        result_.z.push_back(p.z);
        result_.nx.push_back(n.x * s);
        result_.ny.push_back(n.y * s);
        result_.nz.push_back(n.z * s);
    }

    const Mesh& mesh_;
    ClusteredMesh& result_;
    std::vector<int> local_;   // a vertex's number in the cluster that is being made, or -1
};

} // namespace

ClusteredMesh clusterMesh(const Mesh& mesh)
{
    const std::vector<uchar> twoSided = seenFromBehind(mesh);
    std::vector<Facet> facets[2];
    for (size_t i = 0; i < mesh.triangles.size(); i++)
    {
        const Vec3i& t = mesh.triangles[i];
        const Point3f centre = (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) * (1 / 3.f), n = faceNormal(mesh, t) * normalWeight;
        const Facet f = {{centre.x, centre.y, centre.z, n.x, n.y, n.z}, int(i)};
        facets[twoSided[i] ? 1 : 0].push_back(f);
    }
    ClusteredMesh result;
    Clusterer clusterer(mesh, result);
    for (int side = 0; side < 2; side++)
        if (!facets[side].empty()) clusterer.split(&facets[side][0], &facets[side][0] + facets[side].size(), side == 0);
    enclose(result, 0, int(result.x.size()), result.centre, result.radius);
    return result;
}

}} // namespace cv::surgtrack
