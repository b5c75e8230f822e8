// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "mesh_visibility.hpp"

// A z-buffer. Vertices go to the camera frame and, through the lens, to the image; triangles are filled row by row.
// Where the lens bends lines, long edges are halved first, so that a chord leaves its curve by less than 0.1 pixel.

namespace cv { namespace surgtrack { namespace {

const float nearPlane = 0.002f;    // [m]; nothing nearer is drawn: no endoscope sees it
const float maxEdge = 32;          // [pixel]; longer edges are halved if the camera distorts
const float unclippedFactor = 8;   // without distortion, triangles up to this many fields of view wide need no clipping

struct Vertex
{
    float x, y, z;    // camera frame [m]
    float nx, ny, nz; // normal, camera frame
    float u, v, w;    // relative to the window [pixel]; 1 / z
    float shade;      // 0..255
};

enum { OUT_NEAR = 1, OUT_LEFT = 2, OUT_RIGHT = 4, OUT_TOP = 8, OUT_BOTTOM = 16, OUT_GUARD = 32 };

struct SoftwareMesh
{
    std::vector<Point3f> vertices, normals;
    std::vector<Vec3i> triangles;
    Point3f centre;
    float radius;
    size_t oneSided;   // so many triangles come first whose back is never seen
};

class SoftwareRenderer CV_FINAL : public MeshRenderer
{
public:
    SoftwareRenderer() : width_(0), height_(0), distorted_(false) {}

    int addMesh(const Mesh& mesh) CV_OVERRIDE;
    void render(const CameraModel& camera, const Rect& window, const std::vector<MeshInstance>& instances, Rendering& rendering) CV_OVERRIDE;

private:
    void draw(const SoftwareMesh& mesh, const Matx44d& camera_T_mesh);
    void project(Vertex& v) const;
    int outcode(const Vertex& v) const;
    void clip(const Vertex& a, const Vertex& b, const Vertex& c);
    void subdivide(const Vertex& a, const Vertex& b, const Vertex& c, int depth);
    void fill(const Vertex& a, const Vertex& b, const Vertex& c);
    void fillSmall(const Vertex& a, const Vertex& b, const Vertex& c, int x0, int x1, int y0, int y1);

    std::vector<SoftwareMesh> meshes_;
    std::vector<Vertex> vertices_;
    std::vector<uchar> codes_;

    // of the current render()
    CameraModel camera_;
    Rect window_;
    float left_, right_, top_, bottom_;                          // field of view of the window [x / z, y / z]
    float guardLeft_, guardRight_, guardTop_, guardBottom_;      // beyond these, triangles are clipped
    float fx_, fy_, cx_, cy_, k_[12];                            // the camera's, relative to the window
    int width_, height_;
    bool distorted_, cull_;
    uchar id_;
    float* w_;          // the depth map; holds 1 / z until the end
    uchar* ids_;
    uchar* shading_;
};

int SoftwareRenderer::addMesh(const Mesh& mesh)
{
    CV_CheckEQ(mesh.normals.size(), mesh.vertices.size(), "a mesh needs one normal per vertex");
    if (mesh.triangles.empty()) CV_Error(Error::StsBadArg, "mesh has no triangles");
    SoftwareMesh m;
    m.vertices = mesh.vertices;
    m.normals = mesh.normals;
    m.triangles = mesh.triangles;
    Point3f lo(FLT_MAX, FLT_MAX, FLT_MAX), hi = -lo;
    for (size_t i = 0; i < m.vertices.size(); i++)
    {
        const Point3f& p = m.vertices[i];
        if (!(std::abs(p.x) < 1e6f && std::abs(p.y) < 1e6f && std::abs(p.z) < 1e6f))
            CV_Error(Error::StsBadArg, format("mesh vertex %d is not finite", int(i)));
        lo = Point3f(std::min(lo.x, p.x), std::min(lo.y, p.y), std::min(lo.z, p.z));
        hi = Point3f(std::max(hi.x, p.x), std::max(hi.y, p.y), std::max(hi.z, p.z));
    }
    for (size_t i = 0; i < m.triangles.size(); i++)
        for (int j = 0; j < 3; j++) CV_CheckLT((size_t)m.triangles[i][j], m.vertices.size(), "triangle refers to a vertex that does not exist");
    m.centre = (lo + hi) * 0.5f;
    m.radius = float(norm(hi - lo) * 0.5);
    const std::vector<uchar> twoSided = seenFromBehind(mesh);
    m.triangles.clear();
    for (int side = 0; side < 2; side++)
    {
        for (size_t i = 0; i < mesh.triangles.size(); i++)
            if (twoSided[i] == side) m.triangles.push_back(mesh.triangles[i]);
        if (side == 0) m.oneSided = m.triangles.size();
    }
    meshes_.push_back(m);
    return int(meshes_.size()) - 1;
}

void SoftwareRenderer::render(const CameraModel& camera, const Rect& window, const std::vector<MeshInstance>& instances, Rendering& rendering)
{
    checkRendering(camera, window, instances, int(meshes_.size()));

    rendering.create(window);
    rendering.depth.setTo(0);
    rendering.ids.setTo(0);
    rendering.shading.setTo(0);

    camera_ = camera;
    window_ = window;
    width_ = window.width;
    height_ = window.height;
    distorted_ = camera.hasDistortion();
    fx_ = float(camera.fx); fy_ = float(camera.fy);
    cx_ = float(camera.cx - window.x); cy_ = float(camera.cy - window.y);
    for (int i = 0; i < 12; i++) k_[i] = float(camera.k[i]);
    w_ = rendering.depth.ptr<float>();
    ids_ = rendering.ids.ptr();
    shading_ = rendering.shading.ptr();

    const Rect2d fov = camera.fieldOfView(window);
    left_ = float(fov.x); right_ = float(fov.x + fov.width);
    top_ = float(fov.y); bottom_ = float(fov.y + fov.height);
    const float margin = distorted_ ? 0.02f : unclippedFactor;
    guardLeft_ = left_ - margin * float(fov.width); guardRight_ = right_ + margin * float(fov.width);
    guardTop_ = top_ - margin * float(fov.height); guardBottom_ = bottom_ + margin * float(fov.height);

    for (size_t i = 0; i < instances.size(); i++)
    {
        id_ = uchar(instances[i].id);
        draw(meshes_[instances[i].mesh], instances[i].camera_T_mesh);
    }

    float* depth = w_;
    for (size_t i = 0, n = rendering.depth.total(); i < n; i++) depth[i] = depth[i] > 0 ? 1 / depth[i] : 0.f;
}

inline int SoftwareRenderer::outcode(const Vertex& v) const
{
    int code = v.z < nearPlane ? OUT_NEAR : 0;
    if (v.x < left_ * v.z) code |= OUT_LEFT;
    if (v.x > right_ * v.z) code |= OUT_RIGHT;
    if (v.y < top_ * v.z) code |= OUT_TOP;
    if (v.y > bottom_ * v.z) code |= OUT_BOTTOM;
    if (v.x < guardLeft_ * v.z || v.x > guardRight_ * v.z || v.y < guardTop_ * v.z || v.y > guardBottom_ * v.z) code |= OUT_GUARD;
    return code;
}

// 255 * |cos| of the angle between a normal and a viewing ray, of any lengths.
inline float shadeOf(float nx, float ny, float nz, float x, float y, float z)
{
    return 255 * std::abs(nx * x + ny * y + nz * z) / std::sqrt((nx * nx + ny * ny + nz * nz) * (x * x + y * y + z * z) + 1e-30f);
}

// To the window's pixels.
inline void SoftwareRenderer::project(Vertex& v) const
{
    v.w = 1 / v.z;
    v.shade = shadeOf(v.nx, v.ny, v.nz, v.x, v.y, v.z);
    if (distorted_)
    {
        // CameraModel::project() in float: good to a thousandth of a pixel
        const float* k = k_;
        const float x = v.x * v.w, y = v.y * v.w, r2 = x * x + y * y;
        const float g = (1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]))) / (1 + r2 * (k[5] + r2 * (k[6] + r2 * k[7])));
        const float xd = x * g + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x) + r2 * (k[8] + r2 * k[9]);
        const float yd = y * g + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y + r2 * (k[10] + r2 * k[11]);
        v.u = fx_ * xd + cx_;
        v.v = fy_ * yd + cy_;
    }
    else
    {
        v.u = fx_ * v.x * v.w + cx_;
        v.v = fy_ * v.y * v.w + cy_;
    }
}

void SoftwareRenderer::draw(const SoftwareMesh& mesh, const Matx44d& camera_T_mesh)
{
    const Matx44f T = camera_T_mesh;
    // The bounding sphere against the planes of the window's field of view.
    const Point3d c = transform(camera_T_mesh, Point3d(mesh.centre));
    const double r = mesh.radius;
    if (c.z + r < nearPlane || c.x - left_ * c.z < -r * std::sqrt(1 + left_ * left_) || right_ * c.z - c.x < -r * std::sqrt(1 + right_ * right_)
        || c.y - top_ * c.z < -r * std::sqrt(1 + top_ * top_) || bottom_ * c.z - c.y < -r * std::sqrt(1 + bottom_ * bottom_))
        return;

    const size_t n = mesh.vertices.size();
    vertices_.resize(n);
    codes_.resize(n);
    for (size_t i = 0; i < n; i++)
    {
        const Point3f& p = mesh.vertices[i];
        const Point3f& m = mesh.normals[i];
        Vertex& v = vertices_[i];
        v.x = T(0, 0) * p.x + T(0, 1) * p.y + T(0, 2) * p.z + T(0, 3);
        v.y = T(1, 0) * p.x + T(1, 1) * p.y + T(1, 2) * p.z + T(1, 3);
        v.z = T(2, 0) * p.x + T(2, 1) * p.y + T(2, 2) * p.z + T(2, 3);
        const int code = outcode(v);
        codes_[i] = uchar(code);
        v.nx = T(0, 0) * m.x + T(0, 1) * m.y + T(0, 2) * m.z;
        v.ny = T(1, 0) * m.x + T(1, 1) * m.y + T(1, 2) * m.z;
        v.nz = T(2, 0) * m.x + T(2, 1) * m.y + T(2, 2) * m.z;
        if (!(code & (OUT_NEAR | OUT_GUARD))) project(v);
    }

    for (size_t i = 0; i < mesh.triangles.size(); i++)
    {
        cull_ = i < mesh.oneSided;
        const Vec3i& t = mesh.triangles[i];
        const int codeA = codes_[t[0]], codeB = codes_[t[1]], codeC = codes_[t[2]];
        if (codeA & codeB & codeC & ~OUT_GUARD) continue;
        const Vertex &a = vertices_[t[0]], &b = vertices_[t[1]], &d = vertices_[t[2]];
        if ((codeA | codeB | codeC) & (OUT_NEAR | OUT_GUARD)) clip(a, b, d);
        else if (distorted_) subdivide(a, b, d, 0);
        else fill(a, b, d);
    }
}

inline Vertex mix(const Vertex& a, const Vertex& b, float s)
{
    Vertex v;
    v.x = a.x + s * (b.x - a.x);
    v.y = a.y + s * (b.y - a.y);
    v.z = a.z + s * (b.z - a.z);
    v.nx = a.nx + s * (b.nx - a.nx);
    v.ny = a.ny + s * (b.ny - a.ny);
    v.nz = a.nz + s * (b.nz - a.nz);
    return v;
}

// Sutherland-Hodgman against the near plane and the four guard planes.
void SoftwareRenderer::clip(const Vertex& a, const Vertex& b, const Vertex& c)
{
    Vertex polygon[2][9] = {{a, b, c}};
    float distance[9];
    int n = 3, from = 0;
    for (int plane = 0; plane < 5; plane++)
    {
        const Vertex* in = polygon[from];
        for (int i = 0; i < n; i++)
        {
            const Vertex& v = in[i];
            distance[i] = plane == 0   ? v.z - nearPlane
                          : plane == 1 ? v.x - guardLeft_ * v.z
                          : plane == 2 ? guardRight_ * v.z - v.x
                          : plane == 3 ? v.y - guardTop_ * v.z
                                       : guardBottom_ * v.z - v.y;
        }
        Vertex* out = polygon[1 - from];
        int kept = 0;
        for (int i = 0; i < n; i++)
        {
            const int j = i + 1 < n ? i + 1 : 0;
            if (distance[i] >= 0) out[kept++] = in[i];
            if ((distance[i] >= 0) != (distance[j] >= 0))
            {
                // From the inside outwards, so that the neighbour across the edge gets the same point.
                const int p = distance[i] >= 0 ? i : j, q = distance[i] >= 0 ? j : i;
                out[kept++] = mix(in[p], in[q], distance[p] / (distance[p] - distance[q]));
            }
        }
        n = kept;
        from = 1 - from;
        if (n < 3) return;
    }
    Vertex* v = polygon[from];
    for (int i = 0; i < n; i++) project(v[i]);
    for (int i = 2; i < n; i++)
    {
        if (distorted_) subdivide(v[0], v[i - 1], v[i], 0);
        else fill(v[0], v[i - 1], v[i]);
    }
}

// Halves the longest edge while it is longer than maxEdge. Two triangles that share an edge halve it at the same point.
void SoftwareRenderer::subdivide(const Vertex& a, const Vertex& b, const Vertex& c, int depth)
{
    const float ab = (a.u - b.u) * (a.u - b.u) + (a.v - b.v) * (a.v - b.v);
    const float bc = (b.u - c.u) * (b.u - c.u) + (b.v - c.v) * (b.v - c.v);
    const float ca = (c.u - a.u) * (c.u - a.u) + (c.v - a.v) * (c.v - a.v);
    const float longest = std::max(ab, std::max(bc, ca));
    if (longest <= maxEdge * maxEdge || depth >= 12)
    {
        fill(a, b, c);
        return;
    }
    if (longest == ab)
    {
        Vertex m = mix(a, b, 0.5f);
        project(m);
        subdivide(m, b, c, depth + 1);
        subdivide(a, m, c, depth + 1);
    }
    else if (longest == bc) subdivide(b, c, a, depth);
    else subdivide(c, a, b, depth);
}

// Value of a quantity that is linear in the image: at corner a, and its derivatives. In double, because slivers that reach
// far beyond the window cancel.
struct Plane
{
    double a, du, dv;
    float at(double u, double v) const { return float(a + du * u + dv * v); }
};

struct PlaneMaker
{
    double abu, abv, acu, acv, ia;
    Plane operator()(double a, double b, double c) const
    {
        const Plane plane = {a, ((b - a) * acv - (c - a) * abv) * ia, ((c - a) * abu - (b - a) * acu) * ia};
        return plane;
    }
};

// Triangles about the size of a pixel, which most are: tests the few pixel centres of the box around one.
void SoftwareRenderer::fillSmall(const Vertex& a, const Vertex& b, const Vertex& c, int x0, int x1, int y0, int y1)
{
    const float abu = b.u - a.u, abv = b.v - a.v, acu = c.u - a.u, acv = c.v - a.v;
    const float area = abu * acv - abv * acu;
    if ((cull_ && area > 0) || area == 0) return;
    const float ia = 1 / area, tolerance = -1e-4f;   // no gap between neighbours from rounding
    for (int y = y0; y <= y1; y++)
        for (int x = x0; x <= x1; x++)
        {
            const float du = float(x) - a.u, dv = float(y) - a.v;
            const float wb = (du * acv - dv * acu) * ia, wc = (dv * abu - du * abv) * ia, wa = 1 - wb - wc;
            if (wa < tolerance || wb < tolerance || wc < tolerance) continue;
            const float w = wa * a.w + wb * b.w + wc * c.w;
            const size_t at = size_t(y) * width_ + x;
            if (w <= w_[at]) continue;
            w_[at] = w;
            ids_[at] = id_;
            shading_[at] = uchar(std::min(255.f, std::max(0.f, wa * a.shade + wb * b.shade + wc * c.shade + 0.5f)));
        }
}

// Fills the pixels whose centres lie in the triangle. 1 / z and normal / z are linear in the image; in small triangles the
// shade is close enough to linear, too.
void SoftwareRenderer::fill(const Vertex& a, const Vertex& b, const Vertex& c)
{
    const float vmin = std::min(a.v, std::min(b.v, c.v)), vmax = std::max(a.v, std::max(b.v, c.v));
    const float umin = std::min(a.u, std::min(b.u, c.u)), umax = std::max(a.u, std::max(b.u, c.u));
    const int y0 = std::max(0, cvCeil(vmin)), y1 = std::min(height_ - 1, cvFloor(vmax));
    const int left = std::max(0, cvCeil(umin)), right = std::min(width_ - 1, cvFloor(umax));
    if (y0 > y1 || left > right) return;
    if ((umax - umin) * (vmax - vmin) < 20)
    {
        fillSmall(a, b, c, left, right, y0, y1);
        return;
    }
    const double abu = double(b.u) - a.u, abv = double(b.v) - a.v, acu = double(c.u) - a.u, acv = double(c.v) - a.v;
    const double area = abu * acv - abv * acu;   // > 0: clockwise as seen in the image (y down), which is a back face
    if ((cull_ && area > 0) || area == 0) return;

    const PlaneMaker planeOf = {abu, abv, acu, acv, 1 / area};
    const Plane wPlane = planeOf(a.w, b.w, c.w);
    const bool large = !distorted_ && std::max(umax - umin, vmax - vmin) > maxEdge;
    Plane sPlane = {}, nx = {}, ny = {}, nz = {};
    if (large)
    {
        nx = planeOf(a.nx * a.w, b.nx * b.w, c.nx * c.w);
        ny = planeOf(a.ny * a.w, b.ny * b.w, c.ny * c.w);
        nz = planeOf(a.nz * a.w, b.nz * b.w, c.nz * c.w);
    }
    else sPlane = planeOf(a.shade, b.shade, c.shade);

    // Edges that bound a row from the left and from the right; horizontal ones bound nothing.
    const Vertex* corners[4] = {&a, &b, &c, &a};
    float edgeU[3], edgeV[3], slope[3];
    int lefts = 0, rights = 0;
    int leftEdges[3], rightEdges[3];
    for (int i = 0; i < 3; i++)
    {
        const Vertex &p = *corners[i], &q = *corners[i + 1];
        const float dv = q.v - p.v;
        if (dv == 0) continue;
        // The same end first for both triangles at an edge: no gap from rounding.
        const Vertex& upper = dv > 0 ? p : q;
        edgeU[i] = upper.u;
        edgeV[i] = upper.v;
        slope[i] = (q.u - p.u) / dv;
        if ((dv > 0) == (area > 0)) rightEdges[rights++] = i;
        else leftEdges[lefts++] = i;
    }

    for (int y = y0; y <= y1; y++)
    {
        float ul = umin, ur = umax;
        for (int i = 0; i < lefts; i++) ul = std::max(ul, edgeU[leftEdges[i]] + (float(y) - edgeV[leftEdges[i]]) * slope[leftEdges[i]]);
        for (int i = 0; i < rights; i++) ur = std::min(ur, edgeU[rightEdges[i]] + (float(y) - edgeV[rightEdges[i]]) * slope[rightEdges[i]]);
        const int x0 = std::max(0, cvCeil(ul)), x1 = std::min(width_ - 1, cvFloor(ur));
        if (x0 > x1) continue;
        const double du = x0 - double(a.u), dv = y - double(a.v);
        const size_t row = size_t(y) * width_;
        float w = wPlane.at(du, dv);
        const float dw = float(wPlane.du);
        if (large)
        {
            float mx = nx.at(du, dv), my = ny.at(du, dv), mz = nz.at(du, dv);
            const float dmx = float(nx.du), dmy = float(ny.du), dmz = float(nz.du), ifx = float(1 / camera_.fx);
            const float ry = float((y + window_.y - camera_.cy) / camera_.fy);
            float rx = float((x0 + window_.x - camera_.cx) / camera_.fx);
            for (int x = x0; x <= x1; x++, w += dw, mx += dmx, my += dmy, mz += dmz, rx += ifx)
            {
                if (w <= w_[row + x]) continue;
                w_[row + x] = w;
                ids_[row + x] = id_;
                shading_[row + x] = uchar(std::min(255.f, shadeOf(mx, my, mz, rx, ry, 1) + 0.5f));
            }
            continue;
        }
        float s = sPlane.at(du, dv) + 0.5f;
        const float ds = float(sPlane.du);
        for (int x = x0; x <= x1; x++, w += dw, s += ds)
        {
            if (w <= w_[row + x]) continue;
            w_[row + x] = w;
            ids_[row + x] = id_;
            shading_[row + x] = uchar(std::min(255.f, std::max(0.f, s)));
        }
    }
}

} // namespace

Ptr<MeshRenderer> MeshRenderer::createSoftware()
{
    return makePtr<SoftwareRenderer>();
}

}} // namespace cv::surgtrack
