// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// A z-buffer. The vertices of a cluster of triangles go to the camera frame and, through the lens, to the image, a vector at a
// time; there they are rounded to 1/256 pixel. Triangles are small: their edge functions are exact in 32-bit integers, so that
// neighbours leave no gap, and are evaluated for a vector of pixels of a row at once.
//
// Clusters are drawn from near to far. A coarse map holds, for tiles of pixels, the farthest depth drawn: clusters and
// triangles behind it are left out, so that what is hidden costs little.
//
// Long edges are halved first: where the lens bends lines a chord then leaves its curve by less than 0.1 pixel, and shading is
// linear in the image to well below a grey level.

#include "opencv2/core/hal/intrin.hpp"
#include "render/mesh_raster.hpp"
#if CV_SIMD && !defined(CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY)
#include "base/simd.hpp"
#endif

namespace cv { namespace surgtrack {

CV_CPU_OPTIMIZATION_NAMESPACE_BEGIN

void rasterizeKernel(const RasterView& view, const std::vector<RasterInstance>& instances, RasterTarget& target);
void rasterizePlainKernel(const RasterView& view, const std::vector<RasterInstance>& instances, RasterTarget& target);
void unpackRowKernel(const float* w, const int* surface, int width, float* depth, uchar* ids, uchar* shading);

#ifndef CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

namespace {

const float nearPlane = 0.002f;     // [m]; nothing nearer is drawn: no endoscope sees it
const int maxEdge = 32 * 256;       // [1/256 pixel]; longer edges are halved. Edge functions stay below 2^28.
const int farPixel = 1 << 26;       // [1/256 pixel]; farther ones are taken for this far
const int tile = RasterTarget::tile;
const size_t updateEvery = 16;      // clusters; a tile changes with several neighbours

// The few operations used below, for a vector and for a single number.
#if CV_SIMD
inline v_float32 rootOf(const v_float32& a) { return v_sqrt(a); }
inline v_float32 absolute(const v_float32& a) { return v_abs(a); }
inline v_int32 rounded(const v_float32& a) { return v_round(a); }

struct Vector
{
    typedef v_float32 Float;
    typedef v_int32 Int;
    static int count() { return lanes<v_float32>(); }
    static Float all(float a) { return vx_setall_f32(a); }
    static Int all(int a) { return vx_setall_s32(a); }
    static Float load(const float* p) { return vx_load(p); }
    static Int load(const int* p) { return vx_load(p); }
    static Float toFloat(const Int& a) { return v_cvt_f32(a); }
    static Int truncated(const Float& a) { return v_trunc(a); }
    static Int nonNegative(const Int& a) { return greater(a, vx_setall_s32(-1)); }
    static Int greaterThan(const Float& a, const Float& b) { return v_reinterpret_as_s32(greater(a, b)); }
    static int bits(const Int& mask) { return v_signmask(mask); }
    static Int expand(const uchar* p) { return v_reinterpret_as_s32(vx_load_expand_q(p)); }
    static Int lookUp(const int* table, const Int& index) { return v_lut(table, index); }
    static Int pixel(const Int& a) { return v_shr<8>(a); }
    static Float least(const Float& a, const Float& b) { return v_min(a, b); }
    static Float largest(const Float& a, const Float& b) { return v_max(a, b); }
    static Int least(const Int& a, const Int& b) { return v_min(a, b); }
    static Int largest(const Int& a, const Int& b) { return v_max(a, b); }
    static float reduceLeast(const Float& a) { return v_reduce_min(a); }
    static float reduceLargest(const Float& a) { return v_reduce_max(a); }
    static int reduceLeast(const Int& a) { return v_reduce_min(a); }
    static int reduceLargest(const Int& a) { return v_reduce_max(a); }
    static Float select(const Int& mask, const Float& a, const Float& b) { return v_select(v_reinterpret_as_f32(mask), a, b); }
    static Int select(const Int& mask, const Int& a, const Int& b) { return v_select(mask, a, b); }
    static void store(float* p, const Float& a) { v_store(p, a); }
    static void store(int* p, const Int& a) { v_store(p, a); }
};
#endif

inline float add(float a, float b) { return a + b; }
inline float sub(float a, float b) { return a - b; }
inline float mul(float a, float b) { return a * b; }
inline float div(float a, float b) { return a / b; }
inline int add(int a, int b) { return a + b; }
inline int sub(int a, int b) { return a - b; }
inline int mul(int a, int b) { return a * b; }
inline int bor(int a, int b) { return a | b; }
inline int band(int a, int b) { return a & b; }
inline float rootOf(float a) { return std::sqrt(a); }
inline float absolute(float a) { return std::abs(a); }
inline int rounded(float a) { return cvRound(a); }

struct Single
{
    typedef float Float;
    typedef int Int;
    static int count() { return 1; }
    static float all(float a) { return a; }
    static int all(int a) { return a; }
    static float load(const float* p) { return *p; }
    static int load(const int* p) { return *p; }
    static float toFloat(int a) { return float(a); }
    static int truncated(float a) { return int(a); }
    static int nonNegative(int a) { return a >= 0 ? -1 : 0; }
    static int greaterThan(float a, float b) { return a > b ? -1 : 0; }
    static int bits(int mask) { return mask & 1; }
    static int expand(const uchar* p) { return *p; }
    static int lookUp(const int* table, int index) { return table[index]; }
    static int pixel(int a) { return a >> 8; }
    template <typename T> static T least(T a, T b) { return std::min(a, b); }
    template <typename T> static T largest(T a, T b) { return std::max(a, b); }
    template <typename T> static T reduceLeast(T a) { return a; }
    template <typename T> static T reduceLargest(T a) { return a; }
    static float select(int mask, float a, float b) { return mask ? a : b; }
    static int select(int mask, int a, int b) { return mask ? a : b; }
    static void store(float* p, float a) { *p = a; }
    static void store(int* p, int a) { *p = a; }
};

// Mesh to camera frame.
template <typename L> struct Transform
{
    typedef typename L::Float V;
    void set(const Matx44f& T) { for (int i = 0; i < 12; i++) t[i] = L::all(T.val[i]); }
    V rotate(int row, const V& x, const V& y, const V& z) const
    {
        return add(add(mul(t[4 * row], x), mul(t[4 * row + 1], y)), mul(t[4 * row + 2], z));
    }
    V move(int row, const V& x, const V& y, const V& z) const { return add(rotate(row, x, y, z), t[4 * row + 3]); }
    V t[12];
};

// Camera frame to image, and shading.
template <typename L> struct Projection
{
    typedef typename L::Float V;
    explicit Projection(const RasterView& v) : fx(L::all(v.fx)), fy(L::all(v.fy)), cx(L::all(v.cx)), cy(L::all(v.cy)), distorted(v.distorted)
    {
        for (int i = 0; i < 12; i++) k[i] = L::all(v.k[i]);
    }

    void operator()(const V& x, const V& y, const V& z, V& u, V& v, V& w) const
    {
        w = div(L::all(1.f), z);
        V a = mul(x, w), b = mul(y, w);
        if (distorted)
        {
            // CameraModel::project() in float: good to a thousandth of a pixel
            const V one = L::all(1.f), aa = mul(a, a), bb = mul(b, b), r2 = add(aa, bb), ab = mul(a, b), ab2 = add(ab, ab);
            const V numerator = add(one, mul(r2, add(k[0], mul(r2, add(k[1], mul(r2, k[4]))))));
            const V denominator = add(one, mul(r2, add(k[5], mul(r2, add(k[6], mul(r2, k[7]))))));
            const V g = div(numerator, denominator);
            a = add(add(mul(a, g), mul(k[2], ab2)), add(mul(k[3], add(r2, add(aa, aa))), mul(r2, add(k[8], mul(r2, k[9])))));
            b = add(add(mul(b, g), mul(k[3], ab2)), add(mul(k[2], add(r2, add(bb, bb))), mul(r2, add(k[10], mul(r2, k[11])))));
        }
        u = add(mul(fx, a), cx);
        v = add(mul(fy, b), cy);
    }

    // 255 * |cos| of the angle between a unit normal and the viewing ray.
    static V shade(const V& nx, const V& ny, const V& nz, const V& x, const V& y, const V& z)
    {
        const V dot = add(add(mul(nx, x), mul(ny, y)), mul(nz, z)), squared = add(add(mul(x, x), mul(y, y)), mul(z, z));
        return div(mul(L::all(255.f), absolute(dot)), rootOf(squared));
    }

    V fx, fy, cx, cy, k[12];
    bool distorted;
};

struct Vertex
{
    float x, y, z, nx, ny, nz;   // camera frame [m]; unit normal, or between two
    float w, shade;
    int u, v;                    // [1/256 pixel]
};

// The vertices of a cluster.
struct ImageVertices
{
    float x[256], y[256], z[256];
    int u[256], v[256];
    float w[256], shade[256];
    uchar codes[256];
};

enum { OUT_LEFT = 1, OUT_RIGHT = 2, OUT_TOP = 4, OUT_BOTTOM = 8, OUT_NEAR = 16, OUT_GUARD = 32, OUTSIDE = 31, UNSAFE = OUT_NEAR | OUT_GUARD };

inline int least(int a, int b, int c) { return std::min(a, std::min(b, c)); }
inline int largest(int a, int b, int c) { return std::max(a, std::max(b, c)); }

template <typename L> class Raster
{
public:
    Raster(const RasterView& view, RasterTarget& target)
        : view_(view), target_(target), project_(view), project1_(view), budget_(0), instance_(0), cull_(true)
    {
        // A triangle over the whole window takes a tenth of this.
        mostParts_ = 64 * (1 + 256 * view.width / maxEdge) * (1 + 256 * view.height / maxEdge);
        for (int i = 0; i < L::count(); i++) steps_[i] = i;
        left_ = std::sqrt(1 + view.left * view.left);
        right_ = std::sqrt(1 + view.right * view.right);
        top_ = std::sqrt(1 + view.top * view.top);
        bottom_ = std::sqrt(1 + view.bottom * view.bottom);
    }

    void draw(const std::vector<RasterInstance>& instances)
    {
        target_.order.clear();
        for (size_t i = 0; i < instances.size(); i++) collect(instances[i], int(i));
        std::sort(target_.order.begin(), target_.order.end());
        for (size_t i = 0; i < target_.order.size(); i++)
        {
            const RasterInstance& instance = instances[target_.order[i].instance];
            if (instance_ != &instance)
            {
                instance_ = &instance;
                transform_.set(instance.camera_T_mesh);
                transform1_.set(instance.camera_T_mesh);
                id_ = L::all(256 * instance.id);
            }
            draw(*instance.mesh, instance.mesh->clusters[target_.order[i].cluster]);
            if (i % updateEvery == updateEvery - 1) updateTiles();
        }
    }

private:
    // The clusters that may be seen.
    void collect(const RasterInstance& instance, int index)
    {
        const Matx44f& T = instance.camera_T_mesh;
        transform1_.set(T);
        if (isOutside(viewPoint(instance.mesh->centre), instance.mesh->radius)) return;
        const Point3f eye(Matx33f(T.get_minor<3, 3>(0, 0)).t() * -Vec3f(T(0, 3), T(1, 3), T(2, 3)));   // in the mesh's frame
        for (size_t i = 0; i < instance.mesh->clusters.size(); i++)
        {
            const MeshCluster& cluster = instance.mesh->clusters[i];
            if (facesAway(cluster, eye)) continue;
            const Point3f centre = viewPoint(cluster.centre);
            if (isOutside(centre, cluster.radius)) continue;
            const RasterTarget::Item item = {centre.z - cluster.radius, index, int(i)};
            target_.order.push_back(item);
        }
    }

    Point3f viewPoint(const Point3f& p) const
    {
        return Point3f(transform1_.move(0, p.x, p.y, p.z), transform1_.move(1, p.x, p.y, p.z), transform1_.move(2, p.x, p.y, p.z));
    }

    // Every triangle turns its back on the eye.
    static bool facesAway(const MeshCluster& cluster, const Point3f& eye)
    {
        if (cluster.sine > 1) return false;
        const Point3f d = cluster.centre - eye;
        return d.dot(cluster.axis) >= cluster.sine * float(norm(d)) + cluster.radius;
    }

    bool isOutside(const Point3f& c, float r) const
    {
        return c.z + r < nearPlane || c.x - view_.left * c.z < -r * left_ || view_.right * c.z - c.x < -r * right_
               || c.y - view_.top * c.z < -r * top_ || view_.bottom * c.z - c.y < -r * bottom_;
    }

    bool needsClipping(const Point3f& c, float r) const
    {
        const float margin = r * 1.5f * std::max(std::max(left_, right_), std::max(top_, bottom_));   // the guard's planes lean more
        return c.z - r < nearPlane || c.x - view_.guardLeft * c.z < margin || view_.guardRight * c.z - c.x < margin
               || c.y - view_.guardTop * c.z < margin || view_.guardBottom * c.z - c.y < margin;
    }

    int outcode(float x, float y, float z) const
    {
        int code = z < nearPlane ? OUT_NEAR : 0;
        if (x < view_.left * z) code |= OUT_LEFT;
        if (x > view_.right * z) code |= OUT_RIGHT;
        if (y < view_.top * z) code |= OUT_TOP;
        if (y > view_.bottom * z) code |= OUT_BOTTOM;
        if (x < view_.guardLeft * z || x > view_.guardRight * z || y < view_.guardTop * z || y > view_.guardBottom * z) code |= OUT_GUARD;
        return code;
    }

    // Pixels whose centres lie in the box, as far as they are in the window.
    Rect pixelsOf(int u0, int v0, int u1, int v1) const
    {
        const int x0 = std::max(0, (u0 + 255) >> 8), y0 = std::max(0, (v0 + 255) >> 8);
        return Rect(x0, y0, std::min(view_.width - 1, u1 >> 8) - x0 + 1, std::min(view_.height - 1, v1 >> 8) - y0 + 1);
    }

    // Something nearer than 1 / w is drawn on all these pixels, or they are not wanted.
    bool isHidden(const Rect& pixels, float w) const
    {
        const int x1 = (pixels.x + pixels.width - 1) / tile, y1 = (pixels.y + pixels.height - 1) / tile;
        for (int y = pixels.y / tile; y <= y1; y++)
            for (int x = pixels.x / tile; x <= x1; x++)
                if (!(w < target_.farthest[y * target_.tileStep + x])) return false;
        return true;
    }

    // The depth map has changed on these pixels.
    void mark(const Rect& pixels)
    {
        const int x0 = pixels.x / tile, x1 = (pixels.x + pixels.width - 1) / tile, y1 = (pixels.y + pixels.height - 1) / tile;
        for (int y = pixels.y / tile; y <= y1; y++) std::fill(target_.changed + y * target_.tileStep + x0, target_.changed + y * target_.tileStep + x1 + 1, uchar(1));
    }

    void updateTiles()
    {
        for (int y = 0; y * tile < view_.height; y++)
            for (int x = 0; x * tile < view_.width; x++)
            {
                const size_t at = y * target_.tileStep + x;
                if (!target_.changed[at]) continue;
                target_.changed[at] = 0;
                if (target_.farthest[at] == FLT_MAX) continue;
                typename L::Float farthest = L::all(FLT_MAX);
                const int rows = std::min(int(tile), view_.height - y * tile);
                const float* w = target_.w + size_t(y) * tile * target_.step + x * tile;
                for (int j = 0; j < rows; j++, w += target_.step)
                    for (int i = 0; i < tile; i += L::count()) farthest = L::least(farthest, L::load(w + i));
                target_.farthest[at] = L::reduceLeast(farthest);
            }
    }

    void draw(const ClusteredMesh& mesh, const MeshCluster& cluster)
    {
        cull_ = cluster.oneSided;
        const bool clipping = needsClipping(viewPoint(cluster.centre), cluster.radius);
        project(mesh, cluster);
        Rect box;
        if (clipping)
        {
            for (int i = 0; i < cluster.vertices; i++) image_.codes[i] = uchar(outcode(image_.x[i], image_.y[i], image_.z[i]));
            for (int i = cluster.firstTriangle; i < cluster.firstTriangle + cluster.triangles; i++)
            {
                const int codeA = image_.codes[mesh.a[i]], codeB = image_.codes[mesh.b[i]], codeC = image_.codes[mesh.c[i]];
                if (!(codeA & codeB & codeC & OUTSIDE) && (codeA | codeB | codeC) & UNSAFE) drawClipped(mesh, cluster, mesh.a[i], mesh.b[i], mesh.c[i]);
            }
        }
        else
        {
            box = pixelsOf(u0_, v0_, u1_, v1_);
            if (box.width <= 0 || box.height <= 0 || isHidden(box, nearest_)) return;
        }
        for (int i = 0; i < cluster.triangles; i += L::count())
        {
            const int at = cluster.firstTriangle + i;
            const int candidates = select(&mesh.a[at], &mesh.b[at], &mesh.c[at]);
            for (int j = 0; candidates >> j; j++)
            {
                if (!(candidates >> j & 1)) continue;
                const int a = mesh.a[at + j], b = mesh.b[at + j], c = mesh.c[at + j];
                if (clipping && (image_.codes[a] | image_.codes[b] | image_.codes[c]) & UNSAFE) continue;
                const Rect pixels(x0_[j], y0_[j], x1_[j] - x0_[j] + 1, y1_[j] - y0_[j] + 1);
                if (isHidden(pixels, std::max(image_.w[a], std::max(image_.w[b], image_.w[c])))) continue;
                if (longest_[j] > maxEdge) drawClipped(mesh, cluster, a, b, c);
                // front faces run against the sense of fill()
                else fill(image_.u[a], image_.v[a], image_.w[a], image_.shade[a], image_.u[c], image_.v[c], image_.w[c], image_.shade[c],
                          image_.u[b], image_.v[b], image_.w[b], image_.shade[b], pixels);
            }
        }
        if (!clipping) mark(box);
    }

    // Of as many triangles as a vector has elements, those that may hold a pixel's centre and show their face, as bits; and the
    // pixels to look at.
    int select(const uchar* a, const uchar* b, const uchar* c)
    {
        typedef typename L::Int I;
        typedef typename L::Float V;
        const I ia = L::expand(a), ib = L::expand(b), ic = L::expand(c);
        const I ua = L::lookUp(image_.u, ia), ub = L::lookUp(image_.u, ib), uc = L::lookUp(image_.u, ic);
        const I va = L::lookUp(image_.v, ia), vb = L::lookUp(image_.v, ib), vc = L::lookUp(image_.v, ic);
        const I u0 = L::least(ua, L::least(ub, uc)), u1 = L::largest(ua, L::largest(ub, uc));
        const I v0 = L::least(va, L::least(vb, vc)), v1 = L::largest(va, L::largest(vb, vc));
        const I x0 = L::largest(L::all(0), L::pixel(add(u0, L::all(255)))), x1 = L::least(L::all(view_.width - 1), L::pixel(u1));
        const I y0 = L::largest(L::all(0), L::pixel(add(v0, L::all(255)))), y1 = L::least(L::all(view_.height - 1), L::pixel(v1));
        L::store(x0_, x0);
        L::store(x1_, x1);
        L::store(y0_, y0);
        L::store(y1_, y1);
        L::store(longest_, L::largest(sub(u1, u0), sub(v1, v0)));
        I mask = L::nonNegative(bor(sub(x1, x0), sub(y1, y0)));
        if (cull_)
        {
            const V area = sub(mul(L::toFloat(sub(ub, ua)), L::toFloat(sub(vc, va))), mul(L::toFloat(sub(vb, va)), L::toFloat(sub(uc, ua))));
            mask = band(mask, L::greaterThan(L::all(0.f), area));
        }
        return L::bits(mask);
    }

    void project(const ClusteredMesh& mesh, const MeshCluster& cluster)
    {
        typedef typename L::Float V;
        typedef typename L::Int I;
        const int first = cluster.firstVertex;
        I u0 = L::all(INT_MAX), u1 = L::all(INT_MIN), v0 = u0, v1 = u1;
        V nearest = L::all(0.f);
        for (int i = 0; i < cluster.vertices; i += L::count())
        {
            const V px = L::load(&mesh.x[first + i]), py = L::load(&mesh.y[first + i]), pz = L::load(&mesh.z[first + i]);
            const V mx = L::load(&mesh.nx[first + i]), my = L::load(&mesh.ny[first + i]), mz = L::load(&mesh.nz[first + i]);
            const V x = transform_.move(0, px, py, pz), y = transform_.move(1, px, py, pz), z = transform_.move(2, px, py, pz);
            const V nx = transform_.rotate(0, mx, my, mz), ny = transform_.rotate(1, mx, my, mz), nz = transform_.rotate(2, mx, my, mz);
            V uf, vf, w;
            project_(x, y, z, uf, vf, w);
            const I u = clamped(rounded(uf)), v = clamped(rounded(vf));
            u0 = L::least(u0, u);
            u1 = L::largest(u1, u);
            v0 = L::least(v0, v);
            v1 = L::largest(v1, v);
            nearest = L::largest(nearest, w);
            L::store(image_.x + i, x);
            L::store(image_.y + i, y);
            L::store(image_.z + i, z);
            L::store(image_.u + i, u);
            L::store(image_.v + i, v);
            L::store(image_.w + i, w);
            L::store(image_.shade + i, Projection<L>::shade(nx, ny, nz, x, y, z));
        }
        u0_ = L::reduceLeast(u0);
        u1_ = L::reduceLargest(u1);
        v0_ = L::reduceLeast(v0);
        v1_ = L::reduceLargest(v1);
        nearest_ = L::reduceLargest(nearest);
    }

    // For corners that will be clipped: sums of a few of these do not overflow.
    static typename L::Int clamped(const typename L::Int& a) { return L::least(L::largest(a, L::all(-farPixel)), L::all(+farPixel)); }

    // Vertex by vertex, with the same arithmetic.
    Vertex vertex(const ClusteredMesh& mesh, int i) const
    {
        Vertex v = Vertex();
        v.x = transform1_.move(0, mesh.x[i], mesh.y[i], mesh.z[i]);
        v.y = transform1_.move(1, mesh.x[i], mesh.y[i], mesh.z[i]);
        v.z = transform1_.move(2, mesh.x[i], mesh.y[i], mesh.z[i]);
        v.nx = transform1_.rotate(0, mesh.nx[i], mesh.ny[i], mesh.nz[i]);
        v.ny = transform1_.rotate(1, mesh.nx[i], mesh.ny[i], mesh.nz[i]);
        v.nz = transform1_.rotate(2, mesh.nx[i], mesh.ny[i], mesh.nz[i]);
        return v;
    }

    void project(Vertex& p) const
    {
        float u, v;
        project1_(p.x, p.y, p.z, u, v, p.w);
        p.u = std::min(std::max(rounded(u), -farPixel), farPixel);
        p.v = std::min(std::max(rounded(v), -farPixel), farPixel);
        p.shade = Projection<Single>::shade(p.nx, p.ny, p.nz, p.x, p.y, p.z);
    }

    static Vertex mix(const Vertex& a, const Vertex& b, float s)
    {
        Vertex v = Vertex();
        v.x = a.x + s * (b.x - a.x);
        v.y = a.y + s * (b.y - a.y);
        v.z = a.z + s * (b.z - a.z);
        v.nx = a.nx + s * (b.nx - a.nx);
        v.ny = a.ny + s * (b.ny - a.ny);
        v.nz = a.nz + s * (b.nz - a.nz);
        const float length = std::sqrt(v.nx * v.nx + v.ny * v.ny + v.nz * v.nz), inverse = length > 0 ? 1 / length : 0.f;
        v.nx *= inverse;
        v.ny *= inverse;
        v.nz *= inverse;
        return v;
    }

    // Sutherland-Hodgman against the near plane and the four guard planes.
    void drawClipped(const ClusteredMesh& mesh, const MeshCluster& cluster, int a, int b, int c)
    {
        Vertex polygon[2][9];
        polygon[0][0] = vertex(mesh, cluster.firstVertex + a);
        polygon[0][1] = vertex(mesh, cluster.firstVertex + b);
        polygon[0][2] = vertex(mesh, cluster.firstVertex + c);
        int n = 3, from = 0;
        for (int plane = 0; plane < 5; plane++)
        {
            float distance[9];
            const Vertex* in = polygon[from];
            bool anyOutside = false;
            for (int i = 0; i < n; i++)
            {
                const Vertex& v = in[i];
                distance[i] = plane == 0   ? v.z - nearPlane
                              : plane == 1 ? v.x - view_.guardLeft * v.z
                              : plane == 2 ? view_.guardRight * v.z - v.x
                              : plane == 3 ? v.y - view_.guardTop * v.z
                                           : view_.guardBottom * v.z - v.y;
                anyOutside |= distance[i] < 0;
            }
            if (!anyOutside) continue;
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
        budget_ = mostParts_;
        for (int i = 2; i < n; i++) subdivide(v[0], v[i - 1], v[i], 0);
    }

    // Halves the longest edge while it is too long. Two triangles that share an edge halve it at the same point.
    void subdivide(const Vertex& a, const Vertex& b, const Vertex& c, int depth)
    {
        // Wholly beside the window, also where the lens bends its edges.
        const int slack = (std::abs(a.u - b.u) + std::abs(a.v - b.v) + std::abs(a.u - c.u) + std::abs(a.v - c.v)) / 8;
        if (largest(a.u, b.u, c.u) + slack < 0 || least(a.u, b.u, c.u) - slack > view_.width << 8 || largest(a.v, b.v, c.v) + slack < 0
            || least(a.v, b.v, c.v) - slack > view_.height << 8) return;
        const int64 ab = squared(a.u - b.u) + squared(a.v - b.v), bc = squared(b.u - c.u) + squared(b.v - c.v);
        const int64 ca = squared(c.u - a.u) + squared(c.v - a.v), longest = std::max(ab, std::max(bc, ca));
        if (longest <= squared(maxEdge))
        {
            const Rect pixels = pixelsOf(least(a.u, b.u, c.u), least(a.v, b.v, c.v), largest(a.u, b.u, c.u), largest(a.v, b.v, c.v));
            if (pixels.width > 0 && pixels.height > 0 && !isHidden(pixels, std::max(a.w, std::max(b.w, c.w))))
                fill(a.u, a.v, a.w, a.shade, c.u, c.v, c.w, c.shade, b.u, b.v, b.w, b.shade, pixels);
            return;
        }
        if (depth >= 40 || --budget_ < 0) return;   // each of the three edges some ten times, as in an image of 30,000 pixels: never
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

    static int64 squared(int a) { return int64(a) * a; }

    // Fills the pixels whose centres lie in the triangle or on its edge. 1 / z is linear in the image, and shading nearly.
    // Corners a, b, c go clockwise in the image (whose rows go down), as those of a front face taken backwards.
    void fill(int ax, int ay, float aw, float as, int bx, int by, float bw, float bs, int cx, int cy, float cw, float cs,
              const Rect& pixels)
    {
        typedef typename L::Int I;
        int area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
        if (area <= 0)
        {
            if (area == 0 || cull_) return;
            std::swap(bx, cx);
            std::swap(by, cy);
            std::swap(bw, cw);
            std::swap(bs, cs);
            area = -area;
        }
        // Edge functions e = (q - p) x (point - p), positive inside; their sum is `area`.
        const int sx = (pixels.x << 8) - ax, sy = (pixels.y << 8) - ay, width = pixels.width, height = pixels.height;
        const int ab = (bx - ax) * sy - (by - ay) * sx, ca = (ax - cx) * sy - (ay - cy) * sx, bc = area - ab - ca;
        const int abX = 256 * (ay - by), bcX = 256 * (by - cy), caX = 256 * (cy - ay);   // a pixel to the right
        const int abY = 256 * (bx - ax), bcY = 256 * (cx - bx), caY = 256 * (ax - cx);   // a pixel down
        const float inverse = 1 / float(area);
        const Surface surface = {L::all(aw), L::all((bw - aw) * inverse), L::all((cw - aw) * inverse),
                                 L::all(as + 0.5f), L::all((bs - as) * inverse), L::all((cs - as) * inverse), id_};
        const I steps = L::load(steps_);
        I toC = add(L::all(ab), mul(steps, L::all(abX))), toA = add(L::all(bc), mul(steps, L::all(bcX))), toB = add(L::all(ca), mul(steps, L::all(caX)));
        const I toCDown = L::all(abY), toADown = L::all(bcY), toBDown = L::all(caY);
        const size_t step = target_.step;
        float* w = target_.w + size_t(pixels.y) * step + pixels.x;
        int* to = target_.surface + size_t(pixels.y) * step + pixels.x;
        if (width <= L::count())
        {
            for (int y = 0; y < height; y++, w += step, to += step)
            {
                put(w, to, toA, toB, toC, surface);
                toA = add(toA, toADown);
                toB = add(toB, toBDown);
                toC = add(toC, toCDown);
            }
            return;
        }
        const float abSlope = abX ? -1 / float(abX) : 0.f, bcSlope = bcX ? -1 / float(bcX) : 0.f, caSlope = caX ? -1 / float(caX) : 0.f;
        for (int y = 0; y < height; y++, w += step, to += step)
        {
            // Where the edges cross the row, give or take a pixel: slivers leave most of their box empty.
            float lo = 0, hi = float(width - 1);
            bound(ab + y * abY, abX, abSlope, lo, hi);
            bound(bc + y * bcY, bcX, bcSlope, lo, hi);
            bound(ca + y * caY, caX, caSlope, lo, hi);
            const int end = std::min(width, int(hi + 2));
            for (int x = int(lo); x < end; x += L::count())
                put(w + x, to + x, add(toA, L::all(x * bcX)), add(toB, L::all(x * caX)), add(toC, L::all(x * abX)), surface);
            toA = add(toA, toADown);
            toB = add(toB, toBDown);
            toC = add(toC, toCDown);
        }
    }

    // 1 / z and shading as functions of the edge functions: at corner a, and by those towards b and c.
    struct Surface
    {
        typename L::Float aw, bw, cw, as, bs, cs;
        typename L::Int id;
    };

    // A vector of pixels, given their edge functions, which grow towards a corner each.
    static void put(float* w, int* to, const typename L::Int& toA, const typename L::Int& toB, const typename L::Int& toC, const Surface& s)
    {
        typedef typename L::Float V;
        typedef typename L::Int I;
        const V b = L::toFloat(toB), c = L::toFloat(toC), before = L::load(w), now = add(s.aw, add(mul(b, s.bw), mul(c, s.cw)));
        const I mask = band(L::nonNegative(bor(toA, bor(toB, toC))), L::greaterThan(now, before));
        const I shade = L::truncated(add(s.as, add(mul(b, s.bs), mul(c, s.cs))));
        L::store(w, L::select(mask, now, before));
        L::store(to, L::select(mask, add(s.id, shade), L::load(to)));
    }

    static void bound(int e, int step, float slope, float& lo, float& hi)
    {
        const float crossing = float(e) * slope;
        if (step > 0) lo = std::max(lo, crossing);
        else if (step < 0) hi = std::min(hi, crossing);
    }

    const RasterView& view_;
    RasterTarget& target_;
    Projection<L> project_;
    Projection<Single> project1_;
    float left_, right_, top_, bottom_;   // lengths of the normals of the window's planes
    int steps_[64];                       // 0, 1, 2, ...
    int mostParts_, budget_;              // that a triangle may be halved into

    // of the instance that is drawn
    const RasterInstance* instance_;
    Transform<L> transform_;
    Transform<Single> transform1_;
    typename L::Int id_;

    // of the cluster
    bool cull_;
    ImageVertices image_;
    int u0_, u1_, v0_, v1_;
    float nearest_;
    int x0_[64], x1_[64], y0_[64], y1_[64], longest_[64];   // of a vector of triangles, see select()
};

} // namespace

void rasterizeKernel(const RasterView& view, const std::vector<RasterInstance>& instances, RasterTarget& target)
{
#if CV_SIMD
    Raster<Vector>(view, target).draw(instances);
#else
    Raster<Single>(view, target).draw(instances);
#endif
}

void rasterizePlainKernel(const RasterView& view, const std::vector<RasterInstance>& instances, RasterTarget& target)
{
    Raster<Single>(view, target).draw(instances);
}

void unpackRowKernel(const float* w, const int* surface, int width, float* depth, uchar* ids, uchar* shading)
{
    int x = 0;
#if CV_SIMD
    const int step = lanes<v_float32>();
    const v_float32 zero = vx_setzero_f32(), one = vx_setall_f32(1);
    const v_uint32 low = vx_setall_u32(255);
    for (; x <= width - 4 * step; x += 4 * step)
    {
        v_uint32 id[4], shade[4];
        for (int i = 0; i < 4; i++)
        {
            const v_float32 here = vx_load(w + x + i * step);
            v_store(depth + x + i * step, v_select(greater(here, zero), div(one, here), zero));
            const v_uint32 s = v_reinterpret_as_u32(vx_load(surface + x + i * step));
            id[i] = v_shr<8>(s);
            shade[i] = band(s, low);
        }
        v_store(ids + x, v_pack(v_pack(id[0], id[1]), v_pack(id[2], id[3])));
        v_store(shading + x, v_pack(v_pack(shade[0], shade[1]), v_pack(shade[2], shade[3])));
    }
#endif
    for (; x < width; x++)
    {
        depth[x] = w[x] > 0 ? 1 / w[x] : 0.f;
        ids[x] = uchar(surface[x] >> 8);
        shading[x] = uchar(surface[x]);
    }
}

#endif   // CV_CPU_OPTIMIZATION_DECLARATIONS_ONLY

CV_CPU_OPTIMIZATION_NAMESPACE_END

}} // namespace cv::surgtrack
