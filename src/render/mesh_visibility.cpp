// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "render/mesh_visibility.hpp"

namespace cv { namespace surgtrack { namespace {

const int directions = 32;
const double finest = 2.5e-4;      // [m] a pixel: what a camera sees of a tool 20 cm away
const double mostPixels = 1 << 18; // of a view; larger meshes are drawn coarser
const float grazing = 0.1f;        // cosine below which a back face that shows through an edge does not count

// Orthographic views along d, the long axis of the mesh along the image's rows.
class OrthographicView
{
public:
    OrthographicView(const Mesh& mesh, const Vec3f& d, const Vec3f& longAxis);
    void mark(const Mesh& mesh, std::vector<uchar>& seen) const;

private:
    void fill(const Vec3f& a, const Vec3f& b, const Vec3f& c, int index);

    Vec3f d_;
    std::vector<Vec3f> projected_;   // column, row [pixel], depth [m]
    Mat_<float> depth_;
    Mat_<int> index_;
};

inline Vec3f vec(const Point3f& p) { return Vec3f(p.x, p.y, p.z); }

OrthographicView::OrthographicView(const Mesh& mesh, const Vec3f& d, const Vec3f& longAxis) : d_(d), projected_(mesh.vertices.size())
{
    Vec3f u = longAxis - d * longAxis.dot(d);
    if (norm(u) < 0.1) u = std::abs(d[0]) < 0.9f ? Vec3f(1, 0, 0).cross(d) : Vec3f(0, 1, 0).cross(d);
    u = normalize(u);
    const Vec3f v = d.cross(u);
    float lo[2] = {FLT_MAX, FLT_MAX}, hi[2] = {-FLT_MAX, -FLT_MAX};
    for (size_t i = 0; i < projected_.size(); i++)
    {
        const Vec3f p = vec(mesh.vertices[i]);
        projected_[i] = Vec3f(u.dot(p), v.dot(p), d.dot(p));
        for (int j = 0; j < 2; j++)
        {
            lo[j] = std::min(lo[j], projected_[i][j]);
            hi[j] = std::max(hi[j], projected_[i][j]);
        }
    }
    const double pixel = std::max(finest, std::sqrt(double(hi[0] - lo[0]) * (hi[1] - lo[1]) / mostPixels));
    for (size_t i = 0; i < projected_.size(); i++)
        for (int j = 0; j < 2; j++) projected_[i][j] = float((projected_[i][j] - lo[j]) / pixel);
    const Size size(int((hi[0] - lo[0]) / pixel) + 2, int((hi[1] - lo[1]) / pixel) + 2);
    depth_.create(size);
    depth_.setTo(FLT_MAX);
    index_.create(size);
    index_.setTo(-1);
    for (size_t i = 0; i < mesh.triangles.size(); i++)
    {
        const Vec3i& t = mesh.triangles[i];
        fill(projected_[t[0]], projected_[t[1]], projected_[t[2]], int(i));
    }
}

void OrthographicView::fill(const Vec3f& a, const Vec3f& b, const Vec3f& c, int index)
{
    const float abx = b[0] - a[0], aby = b[1] - a[1], acx = c[0] - a[0], acy = c[1] - a[1], area = abx * acy - aby * acx;
    if (area == 0) return;
    const float ia = 1 / area;
    const int x0 = std::max(0, cvCeil(std::min(a[0], std::min(b[0], c[0])))), x1 = std::min(depth_.cols - 1, cvFloor(std::max(a[0], std::max(b[0], c[0]))));
    const int y0 = std::max(0, cvCeil(std::min(a[1], std::min(b[1], c[1])))), y1 = std::min(depth_.rows - 1, cvFloor(std::max(a[1], std::max(b[1], c[1]))));
    for (int y = y0; y <= y1; y++)
        for (int x = x0; x <= x1; x++)
        {
            const float dx = float(x) - a[0], dy = float(y) - a[1];
            const float wb = (dx * acy - dy * acx) * ia, wc = (dy * abx - dx * aby) * ia;
            if (wb < 0 || wc < 0 || wb + wc > 1) continue;
            const float z = a[2] + wb * (b[2] - a[2]) + wc * (c[2] - a[2]);
            if (z >= depth_(y, x)) continue;
            depth_(y, x) = z;
            index_(y, x) = index;
        }
}

void OrthographicView::mark(const Mesh& mesh, std::vector<uchar>& seen) const
{
    for (int y = 0; y < index_.rows; y++)
        for (int x = 0; x < index_.cols; x++)
        {
            const int i = index_(y, x);
            if (i < 0 || seen[i]) continue;
            const Vec3i& t = mesh.triangles[i];
            const Vec3f a = vec(mesh.vertices[t[0]]), normal = (vec(mesh.vertices[t[1]]) - a).cross(vec(mesh.vertices[t[2]]) - a);
            seen[i] = normal.dot(d_) > grazing * float(norm(normal));
        }
}

bool lexicographic(const std::pair<Vec3f, int>& a, const std::pair<Vec3f, int>& b)
{
    for (int i = 0; i < 3; i++)
        if (a.first[i] != b.first[i]) return a.first[i] < b.first[i];
    return a.second < b.second;
}

// Triangles that share a corner, by its place, with one that was seen.
void addNeighbours(const Mesh& mesh, std::vector<uchar>& seen)
{
    std::vector<std::pair<Vec3f, int> > corners;
    for (size_t i = 0; i < mesh.triangles.size(); i++)
        for (int j = 0; j < 3; j++) corners.push_back(std::make_pair(vec(mesh.vertices[mesh.triangles[i][j]]), int(i)));
    std::sort(corners.begin(), corners.end(), lexicographic);
    const std::vector<uchar> before = seen;
    for (size_t first = 0; first < corners.size();)
    {
        size_t last = first;
        uchar any = 0;
        for (; last < corners.size() && corners[last].first == corners[first].first; last++) any |= before[corners[last].second];
        for (; first < last; first++) seen[corners[first].second] |= any;
    }
}

} // namespace

std::vector<uchar> seenFromBehind(const Mesh& mesh)
{
    Vec3f lo(FLT_MAX, FLT_MAX, FLT_MAX), hi = -lo;
    for (size_t i = 0; i < mesh.vertices.size(); i++)
        for (int j = 0; j < 3; j++)
        {
            lo[j] = std::min(lo[j], vec(mesh.vertices[i])[j]);
            hi[j] = std::max(hi[j], vec(mesh.vertices[i])[j]);
        }
    const Vec3f extent = hi - lo;
    Vec3f longAxis(0, 0, 0);
    longAxis[extent[0] >= extent[1] && extent[0] >= extent[2] ? 0 : extent[1] >= extent[2] ? 1 : 2] = 1;

    std::vector<uchar> seen(mesh.triangles.size(), 0);
    for (int i = 0; i < directions; i++)
    {
        // a Fibonacci lattice on the sphere
        const double z = 1 - (2 * i + 1.) / directions, angle = i * CV_PI * (3 - std::sqrt(5.)), r = std::sqrt(1 - z * z);
        OrthographicView(mesh, Vec3f(float(r * std::cos(angle)), float(r * std::sin(angle)), float(z)), longAxis).mark(mesh, seen);
    }
    addNeighbours(mesh, seen);
    return seen;
}

}} // namespace cv::surgtrack
