// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_precomp.hpp"
#include "opencv2/core/affine.hpp"
#include "opencv2/imgproc.hpp"

namespace opencv_test { namespace {

using namespace cv::surgtrack;

// Scenes with a truth that can be computed for every ray, and both renderers held against it.

enum RendererKind { SOFTWARE, VTK };

void PrintTo(const RendererKind& kind, std::ostream* os)
{
    *os << (kind == SOFTWARE ? "software" : "VTK");
}

Ptr<MeshRenderer> createRenderer(RendererKind kind)
{
    if (kind == SOFTWARE) return MeshRenderer::createSoftware();
    try
    {
        return MeshRenderer::createVTK();
    }
    catch (const cv::Exception& e)
    {
        if (e.code != Error::StsNotImplemented) throw;
        throw SkipTestException(e.err);
    }
}

typedef testing::TestWithParam<RendererKind> SurgTrack_MeshRenderer;

// ---- scenes

void addQuad(Mesh& mesh, const Point3f& corner, const Point3f& edge1, const Point3f& edge2, int cells)
{
    const Point3f n = edge1.cross(edge2);
    const int first = int(mesh.vertices.size()), row = cells + 1;
    for (int i = 0; i <= cells; i++)
        for (int j = 0; j <= cells; j++)
        {
            mesh.vertices.push_back(corner + edge1 * (float(i) / float(cells)) + edge2 * (float(j) / float(cells)));
            mesh.normals.push_back(n * float(1 / cv::norm(n)));
        }
    for (int i = 0; i < cells; i++)
        for (int j = 0; j < cells; j++)
        {
            const int a = first + i * row + j;
            mesh.triangles.push_back(Vec3i(a, a + row, a + row + 1));
            mesh.triangles.push_back(Vec3i(a, a + row + 1, a + 1));
        }
}

// A square in the plane z = 0, facing -z.
Mesh square(float side, int cells)
{
    Mesh mesh;
    addQuad(mesh, Point3f(-side / 2, -side / 2, 0), Point3f(0, side, 0), Point3f(side, 0, 0), cells);
    return mesh;
}

Mesh box(const Point3f& lo, const Point3f& hi)
{
    const Point3f x(hi.x - lo.x, 0, 0), y(0, hi.y - lo.y, 0), z(0, 0, hi.z - lo.z);
    Mesh mesh;
    addQuad(mesh, lo, y, x, 1);
    addQuad(mesh, lo, z, y, 1);
    addQuad(mesh, lo, x, z, 1);
    addQuad(mesh, hi, -x, -y, 1);
    addQuad(mesh, hi, -y, -z, 1);
    addQuad(mesh, hi, -z, -x, 1);
    return mesh;
}

Mesh sphere(float radius, int n)
{
    Mesh mesh;
    for (int i = 0; i <= n; i++)
        for (int j = 0; j <= 2 * n; j++)
        {
            const double a = CV_PI * i / n, b = CV_PI * j / n;
            const Point3f p(float(sin(a) * cos(b)), float(sin(a) * sin(b)), float(cos(a)));
            mesh.vertices.push_back(p * radius);
            mesh.normals.push_back(p);
        }
    for (int i = 0; i < n; i++)
        for (int j = 0; j < 2 * n; j++)
        {
            const int a = i * (2 * n + 1) + j, c = a + 2 * n + 1;
            if (i > 0) mesh.triangles.push_back(Vec3i(a, c, a + 1));
            if (i < n - 1) mesh.triangles.push_back(Vec3i(a + 1, c, c + 1));
        }
    return mesh;
}

Matx44d pose(const Vec3d& rotation, const Vec3d& translation)
{
    return Affine3d(rotation, translation).matrix;
}

MeshInstance instanceOf(int mesh, int id, const Matx44d& camera_T_mesh)
{
    MeshInstance instance;
    instance.mesh = mesh;
    instance.id = id;
    instance.camera_T_mesh = camera_T_mesh;
    return instance;
}

CameraModel makeCamera(bool distorted = false)
{
    const Matx33d K(520, 0, 190.3, 0, 575, 130.6, 0, 0, 1);   // fx != fy, off-centre
    if (!distorted) return CameraModel(K, noArray(), Size(360, 288));
    const Mat_<double> D = (Mat_<double>(1, 5) << -0.23, 0.06, 0.0012, -0.0015, 0.01);
    return CameraModel(K, D, Size(360, 288));
}

const Rect whole(0, 0, 360, 288);

// ---- truth

struct Hit
{
    int id;           // 0: nothing
    double z, shade;
};

// What the ray through (x, y, 1) meets.
struct Truth
{
    virtual ~Truth() {}
    virtual Hit operator()(const Point2d& ray) const = 0;
};

struct SquareTruth : Truth
{
    SquareTruth(int id_, double side_, const Matx44d& T_) : id(id_), side(side_), T(T_) {}
    Hit operator()(const Point2d& ray) const CV_OVERRIDE
    {
        const Vec3d x(T(0, 0), T(1, 0), T(2, 0)), y(T(0, 1), T(1, 1), T(2, 1)), n(T(0, 2), T(1, 2), T(2, 2)), t(T(0, 3), T(1, 3), T(2, 3));
        const Vec3d r(ray.x, ray.y, 1);
        const double z = n.dot(t) / n.dot(r);
        const Vec3d p = r * z - t;
        Hit hit = {0, 0, 0};
        if (z <= 0 || std::abs(x.dot(p)) > side / 2 || std::abs(y.dot(p)) > side / 2) return hit;
        hit.id = id;
        hit.z = z;
        hit.shade = 255 * std::abs(n.dot(r)) / cv::norm(r);
        return hit;
    }
    int id;
    double side;
    Matx44d T;
};

struct SphereTruth : Truth
{
    SphereTruth(int id_, double radius_, const Vec3d& centre_) : id(id_), radius(radius_), centre(centre_) {}
    Hit operator()(const Point2d& ray) const CV_OVERRIDE
    {
        const Vec3d r(ray.x, ray.y, 1);
        const double a = r.dot(r), b = r.dot(centre), c = centre.dot(centre) - radius * radius, d = b * b - a * c;
        Hit hit = {0, 0, 0};
        if (d < 0) return hit;
        hit.id = id;
        hit.z = (b - std::sqrt(d)) / a;
        hit.shade = 255 * std::abs((r * hit.z - centre).dot(r)) / (radius * cv::norm(r));
        return hit;
    }
    int id;
    double radius;
    Vec3d centre;
};

struct BoxTruth : Truth
{
    BoxTruth(int id_, const Vec3d& lo_, const Vec3d& hi_) : id(id_), lo(lo_), hi(hi_) {}
    Hit operator()(const Point2d& ray) const CV_OVERRIDE
    {
        const Vec3d r(ray.x, ray.y, 1);
        double from = 0, to = DBL_MAX;
        for (int i = 0; i < 3; i++)
        {
            const double a = lo[i] / r[i], b = hi[i] / r[i];
            from = std::max(from, std::min(a, b));
            to = std::min(to, std::max(a, b));
        }
        Hit hit = {0, 0, 0};
        if (from >= to) return hit;
        hit.id = id;
        hit.z = from;
        return hit;
    }
    int id;
    Vec3d lo, hi;
};

struct NearestTruth : Truth
{
    Hit operator()(const Point2d& ray) const CV_OVERRIDE
    {
        Hit nearest = {0, 0, 0};
        for (size_t i = 0; i < parts.size(); i++)
        {
            const Hit hit = (*parts[i])(ray);
            if (hit.id && (!nearest.id || hit.z < nearest.z)) nearest = hit;
        }
        return nearest;
    }
    std::vector<const Truth*> parts;
};

// Holds every pixel against the truth at its centre, give or take `margin` pixels: where the id is the same all over that
// square it must be the pixel's, and depth and shade must lie in the range they have there, widened by their tolerances.
// Returns how many pixels that showed something were compared.
int expectTruth(const Rendering& rendering, const CameraModel& camera, const Truth& truth, double margin, double depthTolerance, double shadeTolerance)
{
    const double offsets[5][2] = {{0, 0}, {-margin, -margin}, {margin, -margin}, {-margin, margin}, {margin, margin}};
    EXPECT_EQ(CV_32FC1, rendering.depth.type());
    EXPECT_EQ(CV_8UC1, rendering.ids.type());
    EXPECT_EQ(CV_8UC1, rendering.shading.type());
    EXPECT_EQ(rendering.window.size(), rendering.depth.size());
    EXPECT_EQ(rendering.window.size(), rendering.ids.size());
    EXPECT_EQ(rendering.window.size(), rendering.shading.size());

    Mat_<Vec2d> points(rendering.ids.rows * rendering.ids.cols * 5, 1), rays;
    for (int i = 0; i < points.rows; i++)
        points(i) = Vec2d(rendering.window.x + i / 5 % rendering.ids.cols + offsets[i % 5][0], rendering.window.y + i / 5 / rendering.ids.cols + offsets[i % 5][1]);
    camera.unprojectPoints(points, rays);

    int compared = 0, wrongId = 0, wrongDepth = 0, wrongShade = 0;
    double depthError = 0, shadeError = 0;
    for (int y = 0; y < rendering.ids.rows; y++)
        for (int x = 0; x < rendering.ids.cols; x++)
        {
            Hit lo = {0, 0, 0}, hi = lo;
            bool sure = true;
            for (int i = 0; i < 5; i++)
            {
                const Vec2d ray = rays((y * rendering.ids.cols + x) * 5 + i);
                const Hit hit = truth(Point2d(ray[0], ray[1]));
                if (i == 0) lo = hi = hit;
                sure = sure && hit.id == lo.id;
                lo.z = std::min(lo.z, hit.z); hi.z = std::max(hi.z, hit.z);
                lo.shade = std::min(lo.shade, hit.shade); hi.shade = std::max(hi.shade, hit.shade);
            }
            if (!sure) continue;
            const double z = rendering.depth.at<float>(y, x), shade = rendering.shading.at<uchar>(y, x);
            if (rendering.ids.at<uchar>(y, x) != lo.id)
            {
                wrongId++;
                continue;
            }
            if (lo.id == 0)
            {
                wrongDepth += z != 0;
                wrongShade += shade != 0;
                continue;
            }
            compared++;
            const double dz = std::max(lo.z - z, z - hi.z), ds = std::max(lo.shade - shade, shade - hi.shade);
            wrongDepth += !(dz <= depthTolerance);
            wrongShade += ds > shadeTolerance;
            depthError = std::max(depthError, dz);
            shadeError = std::max(shadeError, ds);
        }
    EXPECT_EQ(0, wrongId);
    EXPECT_EQ(0, wrongDepth) << "largest error " << depthError * 1e3 << " mm";
    EXPECT_EQ(0, wrongShade) << "largest error " << shadeError << " grey levels";
    return compared;
}

const double margin = 0.02;            // [pixel] OpenGL snaps corners to 1/256 pixel, the software renderer has 24 bits of mantissa
const double lensMargin = 0.75;        // [pixel] with distortion: VTK takes the nearest of samples 1/1.5 pixel apart, software bends edges by chords
const double flatDepth = 2e-6;         // [m] rounding of float and of a 24 bit z-buffer
const double flatShade = 1.5;          // grey levels: rounding, and the software renderer interpolates the cosine within small triangles
const double anyShade = 255;           // large triangles: the software renderer interpolates the cosine between their corners

// ---- the tests

TEST_P(SurgTrack_MeshRenderer, drawsATiltedSquareWhereTheProjectionSays)
{
    const Ptr<MeshRenderer> renderer = createRenderer(GetParam());
    const Matx44d T = pose(Vec3d(0.7, -0.4, 0.3), Vec3d(-0.004, 0.003, 0.11));
    const int mesh = renderer->addMesh(square(0.03f, 24));
    Rendering rendering;
    renderer->render(makeCamera(), whole, std::vector<MeshInstance>(1, instanceOf(mesh, 255, T)), rendering);
    EXPECT_EQ(whole, rendering.window);
    EXPECT_GT(expectTruth(rendering, makeCamera(), SquareTruth(255, 0.03, T), margin, flatDepth, flatShade), 10000);
}

TEST_P(SurgTrack_MeshRenderer, drawsASphere)
{
    const Ptr<MeshRenderer> renderer = createRenderer(GetParam());
    const Vec3d centre(0.005, -0.004, 0.09);
    const int mesh = renderer->addMesh(sphere(0.01f, 120));
    Rendering rendering;
    renderer->render(makeCamera(), whole, std::vector<MeshInstance>(1, instanceOf(mesh, 1, pose(Vec3d(0.3, 0.2, 0.1), centre))), rendering);
    // 120 facets a half turn lie up to 10 mm * (1 - cos(0.75 deg * sqrt(2))) = 1.7 um inside the sphere: 0.01 pixel at the
    // outline, but there the ray runs along the surface, and 0.2 pixel of margin bounds what that does to the depth.
    EXPECT_GT(expectTruth(rendering, makeCamera(), SphereTruth(1, 0.01, centre), 0.2, 5e-6, 2.5), 9000);
}

TEST_P(SurgTrack_MeshRenderer, nearerSurfaceHidesFartherInAnyOrder)
{
    const Ptr<MeshRenderer> renderer = createRenderer(GetParam());
    const Matx44d T1 = pose(Vec3d(0, 0.5, 0), Vec3d(0.002, 0, 0.1)), T2 = pose(Vec3d(0, -0.5, 0.4), Vec3d(-0.002, 0.001, 0.1));
    const int mesh = renderer->addMesh(square(0.03f, 24));
    const SquareTruth truth1(1, 0.03, T1), truth2(2, 0.03, T2);
    NearestTruth truth;
    truth.parts.push_back(&truth1);
    truth.parts.push_back(&truth2);
    std::vector<MeshInstance> instances;   // the same mesh twice, running through each other
    instances.push_back(instanceOf(mesh, 1, T1));
    instances.push_back(instanceOf(mesh, 2, T2));
    Rendering rendering, reversed;
    renderer->render(makeCamera(), whole, instances, rendering);
    EXPECT_GT(expectTruth(rendering, makeCamera(), truth, margin, flatDepth, flatShade), 15000);
    EXPECT_GT(countNonZero(rendering.ids == 1), 5000);
    EXPECT_GT(countNonZero(rendering.ids == 2), 5000);

    std::swap(instances[0], instances[1]);
    renderer->render(makeCamera(), whole, instances, reversed);
    EXPECT_EQ(0, cvtest::norm(rendering.ids, reversed.ids, NORM_L1));
    EXPECT_EQ(0, cvtest::norm(rendering.depth, reversed.depth, NORM_INF));
}

TEST_P(SurgTrack_MeshRenderer, clipsABeamThatReachesBehindTheCamera)
{
    const Ptr<MeshRenderer> renderer = createRenderer(GetParam());
    const Vec3d lo(-0.003, 0.004, -0.5), hi(0.005, 0.012, 0.1);
    const int mesh = renderer->addMesh(box(Point3f(-0.003f, 0.004f, -0.5f), Point3f(0.005f, 0.012f, 0.1f)));
    for (int distorted = 0; distorted < 2; distorted++)
    {
        const CameraModel camera = makeCamera(distorted != 0);
        Rendering rendering;
        renderer->render(camera, whole, std::vector<MeshInstance>(1, instanceOf(mesh, 3, Matx44d::eye())), rendering);
        // Triangles of 0.6 m: float leaves 1e-6 of them.
        EXPECT_GT(expectTruth(rendering, camera, BoxTruth(3, lo, hi), distorted ? lensMargin : margin, 5e-6, anyShade), 5000);
    }
}

TEST_P(SurgTrack_MeshRenderer, distortionMovesTheOutlineAsTheCameraModelSays)
{
    const Ptr<MeshRenderer> renderer = createRenderer(GetParam());
    const CameraModel camera = makeCamera(true);
    const Matx44d T = pose(Vec3d(0.5, 0.3, 0.2), Vec3d(-0.001, 0.003, 0.1));
    const int coarse = renderer->addMesh(square(0.06f, 1)), fine = renderer->addMesh(square(0.06f, 24));
    Rendering rendering;
    renderer->render(camera, whole, std::vector<MeshInstance>(1, instanceOf(fine, 9, T)), rendering);
    EXPECT_GT(expectTruth(rendering, camera, SquareTruth(9, 0.06, T), lensMargin, flatDepth, flatShade), 40000);
    EXPECT_LT(countNonZero(rendering.ids), whole.area());

    // Two triangles must bend too; 0.01 mm: their edges are chords of the curve.
    renderer->render(camera, whole, std::vector<MeshInstance>(1, instanceOf(coarse, 9, T)), rendering);
    EXPECT_GT(expectTruth(rendering, camera, SquareTruth(9, 0.06, T), lensMargin, 1e-5, anyShade), 40000);
    const Rect window(211, 17, 97, 133);
    renderer->render(camera, window, std::vector<MeshInstance>(1, instanceOf(coarse, 9, T)), rendering);
    EXPECT_GT(expectTruth(rendering, camera, SquareTruth(9, 0.06, T), lensMargin, 1e-5, anyShade), 5000);
}

TEST_P(SurgTrack_MeshRenderer, aWindowIsTheCutOutOfTheImage)
{
    const Ptr<MeshRenderer> renderer = createRenderer(GetParam());
    std::vector<MeshInstance> instances;
    instances.push_back(instanceOf(renderer->addMesh(sphere(0.01f, 40)), 4, pose(Vec3d(), Vec3d(0.003, 0.002, 0.09))));
    instances.push_back(instanceOf(renderer->addMesh(square(0.05f, 3)), 5, pose(Vec3d(0.2, 0.5, 0.1), Vec3d(-0.01, 0, 0.1))));
    const Rect windows[] = {Rect(0, 0, 1, 1), Rect(101, 57, 130, 101), Rect(340, 200, 20, 88), Rect(0, 250, 360, 38), whole};
    Rendering image, cut;
    renderer->render(makeCamera(), whole, instances, image);
    for (size_t i = 0; i < sizeof(windows) / sizeof(windows[0]); i++)
    {
        renderer->render(makeCamera(), windows[i], instances, cut);
        ASSERT_EQ(windows[i], cut.window);
        // Coordinates relative to another corner round differently: a pixel centre on an edge may fall to the other side.
        EXPECT_LE(countNonZero(cut.ids != image.ids(windows[i])), windows[i].area() / 1000);
        const Mat same = cut.ids == image.ids(windows[i]);
        if (countNonZero(same) == 0) continue;
        EXPECT_LE(cvtest::norm(cut.depth, image.depth(windows[i]), NORM_INF, same), 1e-5);    // the same rounding at a slanted surface
        EXPECT_LE(cvtest::norm(cut.shading, image.shading(windows[i]), NORM_INF, same), 1);   // rounding to grey levels
    }
}

TEST_P(SurgTrack_MeshRenderer, drawsNothingOfWhatIsBehindOrBeside)
{
    const Ptr<MeshRenderer> renderer = createRenderer(GetParam());
    const int mesh = renderer->addMesh(sphere(0.01f, 20));
    std::vector<MeshInstance> none, some;
    some.push_back(instanceOf(mesh, 1, pose(Vec3d(), Vec3d(0, 0, -0.1))));
    some.push_back(instanceOf(mesh, 2, pose(Vec3d(), Vec3d(0.2, 0, 0.1))));
    some.push_back(instanceOf(mesh, 3, pose(Vec3d(), Vec3d(0, -0.2, 0.1))));
    for (int distorted = 0; distorted < 2; distorted++)
    {
        // A drawing before must leave no trace.
        Rendering rendering;
        renderer->render(makeCamera(), whole, std::vector<MeshInstance>(1, instanceOf(mesh, 7, pose(Vec3d(), Vec3d(0, 0, 0.1)))), rendering);
        EXPECT_GT(countNonZero(rendering.ids == 7), 5000);
        const std::vector<MeshInstance>* lists[] = {&none, &some};
        for (int i = 0; i < 2; i++)
        {
            renderer->render(makeCamera(distorted != 0), whole, *lists[i], rendering);
            EXPECT_EQ(whole.size(), rendering.ids.size());
            EXPECT_EQ(0, countNonZero(rendering.ids));
            EXPECT_EQ(0, countNonZero(rendering.depth));
            EXPECT_EQ(0, countNonZero(rendering.shading));
        }
    }
}

TEST_P(SurgTrack_MeshRenderer, severalRenderersDoNotDisturbEachOther)
{
    std::vector<Ptr<MeshRenderer> > renderers;
    std::vector<Rendering> renderings(3);
    const Matx44d T = pose(Vec3d(0.7, -0.4, 0.3), Vec3d(0, 0, 0.11));
    for (int i = 0; i < 3; i++)
    {
        renderers.push_back(createRenderer(GetParam()));
        EXPECT_EQ(0, renderers[i]->addMesh(square(0.03f, 4)));
    }
    for (int i = 0; i < 3; i++) renderers[i]->render(makeCamera(), whole, std::vector<MeshInstance>(1, instanceOf(0, 6, T)), renderings[i]);
    renderers[1].release();
    renderers[0]->render(makeCamera(), whole, std::vector<MeshInstance>(1, instanceOf(0, 6, T)), renderings[1]);
    renderers[0].release();
    renderers[1] = createRenderer(GetParam());
    renderers[1]->addMesh(square(0.03f, 4));
    renderers[1]->render(makeCamera(), whole, std::vector<MeshInstance>(1, instanceOf(0, 6, T)), renderings[0]);
    for (int i = 0; i < 2; i++)
    {
        EXPECT_EQ(0, cvtest::norm(renderings[i].depth, renderings[2].depth, NORM_INF));
        EXPECT_EQ(0, cvtest::norm(renderings[i].ids, renderings[2].ids, NORM_INF));
        EXPECT_EQ(0, cvtest::norm(renderings[i].shading, renderings[2].shading, NORM_INF));
    }
}

TEST_P(SurgTrack_MeshRenderer, rejectsWhatCannotBeDrawn)
{
    const Ptr<MeshRenderer> renderer = createRenderer(GetParam());
    Rendering rendering;
    const std::vector<MeshInstance> none;
    EXPECT_THROW(renderer->render(makeCamera(), Rect(300, 0, 100, 100), none, rendering), cv::Exception);
    EXPECT_THROW(renderer->render(makeCamera(), Rect(-1, 0, 10, 10), none, rendering), cv::Exception);
    EXPECT_THROW(renderer->render(makeCamera(), Rect(10, 10, 0, 5), none, rendering), cv::Exception);

    const int mesh = renderer->addMesh(square(0.01f, 1));
    const Matx44d T = pose(Vec3d(), Vec3d(0, 0, 0.1));
    Matx44d notFinite = T, scaled = T * 2.;
    notFinite(0, 3) = std::numeric_limits<double>::quiet_NaN();
    const MeshInstance bad[] = {instanceOf(-1, 1, T), instanceOf(mesh + 1, 1, T), instanceOf(mesh, 0, T), instanceOf(mesh, 256, T),
                                instanceOf(mesh, 1, notFinite), instanceOf(mesh, 1, scaled)};
    for (size_t i = 0; i < sizeof(bad) / sizeof(bad[0]); i++)
        EXPECT_THROW(renderer->render(makeCamera(), whole, std::vector<MeshInstance>(1, bad[i]), rendering), cv::Exception) << i;

    Mesh broken = square(0.01f, 1);
    broken.triangles.clear();
    EXPECT_THROW(renderer->addMesh(broken), cv::Exception);
    broken = square(0.01f, 1);
    broken.triangles[0][1] = 4;
    EXPECT_THROW(renderer->addMesh(broken), cv::Exception);
    broken.triangles[0][1] = -1;
    EXPECT_THROW(renderer->addMesh(broken), cv::Exception);
    broken = square(0.01f, 1);
    broken.normals.pop_back();
    EXPECT_THROW(renderer->addMesh(broken), cv::Exception);
    broken = square(0.01f, 1);
    broken.vertices[2].y = std::numeric_limits<float>::infinity();
    EXPECT_THROW(renderer->addMesh(broken), cv::Exception);

    renderer->render(makeCamera(), whole, std::vector<MeshInstance>(1, instanceOf(mesh, 1, T)), rendering);
    EXPECT_GT(countNonZero(rendering.ids), 1000);   // still of use
}

// A random pose with the wrist in the field of view and the shaft coming from beside the camera, as through a trocar.
Matx44d randomBase(const Ptr<ToolModel>& tool, const std::vector<double>& joints, RNG& rng)
{
    const Matx44d base_T_tool = tool->endEffectorPose(joints);
    const Vec3d tip(base_T_tool(0, 3), base_T_tool(1, 3), base_T_tool(2, 3)), from = tip / cv::norm(tip);
    const double azimuth = rng.uniform(-CV_PI, CV_PI), tilt = rng.uniform(0.4, 1.1);
    const Vec3d to(std::sin(tilt) * std::cos(azimuth), std::sin(tilt) * std::sin(azimuth), std::cos(tilt)), axis = from.cross(to);
    const Affine3d turn(axis * (std::atan2(cv::norm(axis), from.dot(to)) / cv::norm(axis))), roll(to * rng.uniform(-CV_PI, CV_PI));
    const Vec3d viewTip(rng.uniform(-0.012, 0.012), rng.uniform(-0.009, 0.009), rng.uniform(0.06, 0.14));
    Affine3d camera_T_base = roll * turn;
    return camera_T_base.translate(viewTip - camera_T_base.linear() * tip).matrix;
}

TEST(SurgTrack_MeshRenderers, bothRenderersDrawTheSameNeedleDriver)
{
    const Ptr<MeshRenderer> software = createRenderer(SOFTWARE), vtk = createRenderer(VTK);
    const Ptr<ToolModel> tool = ToolModel::needleDriver();
    const CameraModel camera(Matx33d(905, 0, 352.4, 0, 921, 281.7, 0, 0, 1), noArray(), Size(720, 576));
    const int insertion = tool->coordinateIndex("q3");
    RNG rng(20160101);
    for (int round = 0; round < 8; round++)
    {
        SCOPED_TRACE(round);
        std::vector<double> joints;
        for (size_t i = 0; i < tool->coordinateNames().size(); i++) joints.push_back(rng.uniform(-0.6, 0.6));
        joints[insertion] = rng.uniform(0.1, 0.2);
        const Matx44d camera_T_base = randomBase(tool, joints, rng);
        Mat depth[2], ids[2], shading[2];
        software->renderTool(tool, joints, camera_T_base, camera, depth[0], ids[0], shading[0]);
        vtk->renderTool(tool, joints, camera_T_base, camera, depth[1], ids[1], shading[1]);

        // Away from outlines, of the tool and of its parts: which side of an edge a pixel centre is on is rounding.
        Mat lo, hi;
        erode(ids[0], lo, Mat());
        dilate(ids[0], hi, Mat());
        const Mat inner = (lo == hi) & (ids[0] > 0), agree = (ids[0] == ids[1]) & inner;
        const int pixels = countNonZero(inner), agreed = countNonZero(agree);
        ASSERT_GT(pixels, 5000);
        EXPECT_LE(countNonZero((lo == hi) & (ids[0] == 0) & (ids[1] > 0)), 0);

        Mat depthDifference, shadeDifference;
        absdiff(depth[0], depth[1], depthDifference);
        absdiff(shading[0], shading[1], shadeDifference);
        const int sameDepth = countNonZero((depthDifference <= 5e-5f) & agree), sameShade = countNonZero((shadeDifference <= 3) & agree);
        // 1 %: where parts run through each other their order is rounding.
        EXPECT_GE(agreed, 0.99 * pixels);
        // 0.05 mm, the tracker's depth slack is 1 mm; 1 %: creases of one part, where the nearer side is rounding.
        EXPECT_GE(sameDepth, 0.99 * agreed);
        // 3 grey levels: the software renderer interpolates the cosine, OpenGL the normal; 2 %: creases again.
        EXPECT_GE(sameShade, 0.98 * agreed);
    }
}

INSTANTIATE_TEST_CASE_P(/**/, SurgTrack_MeshRenderer, testing::Values(SOFTWARE, VTK));

}} // namespace
