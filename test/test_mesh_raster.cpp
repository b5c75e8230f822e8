// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_common.hpp"
#include "opencv2/imgproc.hpp"
#include "render/mesh_raster.hpp"

namespace opencv_test { namespace {

// Triangles of all sizes and directions in a cube, neighbours sharing corners; normals are the corners' own.
Mesh debris(RNG& rng, int triangles)
{
    Mesh mesh;
    for (int i = 0; i < triangles; i++)
    {
        const float size = std::pow(10.f, rng.uniform(-3.5f, -1.3f));   // 0.3 to 50 mm
        const Point3f centre(rng.uniform(-0.04f, 0.04f), rng.uniform(-0.04f, 0.04f), rng.uniform(-0.04f, 0.04f));
        const int first = int(mesh.vertices.size());
        for (int j = 0; j < 4; j++)
        {
            const Point3f d(rng.uniform(-size, size), rng.uniform(-size, size), rng.uniform(-size, size));
            mesh.vertices.push_back(centre + d);
            mesh.normals.push_back(d * float(1 / std::max(1e-9, cv::norm(d))));
        }
        mesh.triangles.push_back(Vec3i(first, first + 1, first + 2));
        mesh.triangles.push_back(Vec3i(first + 2, first + 1, first + 3));
    }
    return mesh;
}

CameraModel randomCamera(RNG& rng)
{
    const Matx33d K(rng.uniform(500., 900.), 0, rng.uniform(300., 400.), 0, rng.uniform(500., 900.), rng.uniform(250., 330.), 0, 0, 1);
    const Matx<double, 1, 5> k(rng.uniform(-0.25, 0.1), rng.uniform(-0.02, 0.02), 0.001, -0.002, 0);
    return rng.uniform(0, 2) ? CameraModel(K, k, Size(720, 576)) : CameraModel(K, noArray(), Size(720, 576));
}

Rect randomWindow(RNG& rng)
{
    const Size size(rng.uniform(1, 400), rng.uniform(1, 300));
    return Rect(rng.uniform(0, 720 - size.width + 1), rng.uniform(0, 576 - size.height + 1), size.width, size.height);
}

// Some of it behind the camera, some of it beside the window.
Matx44d randomPose(RNG& rng)
{
    const Vec3d turn(rng.uniform(-2., 2.), rng.uniform(-2., 2.), rng.uniform(-2., 2.));
    return rigid(rotationMatrix(turn), Point3d(rng.uniform(-0.03, 0.03), rng.uniform(-0.03, 0.03), rng.uniform(0., 0.15)));
}

TEST(SurgTrack_MeshRaster, vectorsGiveTheBitsOfThePlainVersion)
{
    RNG rng(7);
    size_t drawn = 0;
    for (int scene = 0; scene < 25; scene++)
    {
        const ClusteredMesh meshes[] = {clusterMesh(debris(rng, 150)), clusterMesh(debris(rng, 3))};
        std::vector<RasterInstance> instances;
        for (int i = 0; i < 4; i++)
        {
            const RasterInstance instance = {&meshes[i % 2], Matx44f(randomPose(rng)), i + 1};
            instances.push_back(instance);
        }
        const Rect window = randomWindow(rng);
        const RasterView view = rasterView(randomCamera(rng), window);
        RasterTarget vectors, plain;
        vectors.create(window.size());
        plain.create(window.size());
        rasterize(view, instances, vectors);
        cv::surgtrack::plain::rasterize(view, instances, plain);
        for (int y = 0; y < window.height; y++)
            for (int x = 0; x < window.width; x++)
            {
                const size_t at = y * vectors.step + x;
                ASSERT_EQ(plain.w[at], vectors.w[at]) << "scene " << scene << ", " << Point(x, y);
                ASSERT_EQ(plain.surface[at], vectors.surface[at]) << "scene " << scene << ", " << Point(x, y);
                drawn += plain.w[at] > 0;
            }
    }
    EXPECT_GT(drawn, 50000u);
}

// What is left out as hidden or facing away must not be missed: every cluster drawn alone, and the nearest taken.
TEST(SurgTrack_MeshRaster, leavesOutOnlyWhatIsHidden)
{
    RNG rng(8);
    for (int scene = 0; scene < 8; scene++)
    {
        const ClusteredMesh mesh = clusterMesh(debris(rng, 300));
        const RasterInstance whole = {&mesh, Matx44f(randomPose(rng)), 1};
        const Rect window = randomWindow(rng);
        const RasterView view = rasterView(randomCamera(rng), window);
        RasterTarget together, alone;
        together.create(window.size());
        rasterize(view, std::vector<RasterInstance>(1, whole), together);
        Mat_<float> nearest(window.size(), 0.f);
        for (size_t i = 0; i < mesh.clusters.size(); i++)
        {
            ClusteredMesh one = mesh;
            one.clusters.assign(1, mesh.clusters[i]);
            one.clusters[0].sine = 2;   // whichever way it faces
            const RasterInstance instance = {&one, whole.camera_T_mesh, 1};
            alone.create(window.size());
            rasterize(view, std::vector<RasterInstance>(1, instance), alone);
            for (int y = 0; y < window.height; y++)
                for (int x = 0; x < window.width; x++) nearest(y, x) = std::max(nearest(y, x), alone.w[y * alone.step + x]);
        }
        for (int y = 0; y < window.height; y++)
            for (int x = 0; x < window.width; x++) ASSERT_EQ(nearest(y, x), together.w[y * together.step + x]) << "scene " << scene << ", " << Point(x, y);
    }
}

std::vector<MeshInstance> instancesOf(MeshRenderer& renderer, const ToolModel& model, const Matx44d& camera_T_base, const std::vector<double>& joints)
{
    std::vector<Matx44d> base_T_link;
    model.forwardKinematics(joints, base_T_link);
    std::vector<MeshInstance> instances;
    for (size_t i = 0; i < model.links().size(); i++)
    {
        if (model.links()[i].mesh < 0) continue;
        MeshInstance instance;
        instance.mesh = renderer.addMesh(model.meshes()[model.links()[i].mesh]);
        instance.id = 1;
        instance.camera_T_mesh = camera_T_base * base_T_link[i];
        instances.push_back(instance);
    }
    return instances;
}

TEST(SurgTrack_MeshRaster, regionsHoldWhatAWholeDrawingHolds)
{
    const Ptr<ToolModel> model = ToolModel::needleDriver();
    const CameraModel camera(Matx33d(800, 0, 359.5, 0, 780, 287.5, 0, 0, 1), Matx<double, 1, 4>(-0.2, 0.01, 0, 0), Size(720, 576));
    const std::vector<double> joints = {0.1, 0.2, 0.1, 0.3, 0.2, -0.3, 0.4};
    const Matx44d base_T_tool = model->endEffectorPose(joints), camera_T_tool = rigid(rotationMatrix(Vec3d(0.3, 2.6, 0.4)), Point3d(0.002, 0, 0.09));
    Ptr<MeshRenderer> renderer = MeshRenderer::createSoftware();
    const std::vector<MeshInstance> instances = instancesOf(*renderer, *model, camera_T_tool * base_T_tool.inv(), joints);
    const Rect window(200, 120, 301, 287);
    Rendering whole, part;
    renderer->render(camera, window, instances, whole);
    ASSERT_GT(countNonZero(whole.ids), 5000);
    RNG rng(9);
    for (int i = 0; i < 30; i++)
    {
        std::vector<Rect> regions;
        for (int k = 0; k <= i % 3; k++)
            regions.push_back(Rect(window.x + rng.uniform(-20, 300), window.y + rng.uniform(-20, 280), rng.uniform(1, 120), rng.uniform(1, 120)));
        renderer->render(camera, window, instances, part, regions);
        for (const Rect& region : regions)
        {
            const Rect r = (region & window) - window.tl();
            if (r.empty()) continue;
            EXPECT_EQ(0, cv::norm(whole.depth(r), part.depth(r), NORM_INF));
            EXPECT_EQ(0, cv::norm(whole.ids(r), part.ids(r), NORM_INF));
            EXPECT_EQ(0, cv::norm(whole.shading(r), part.shading(r), NORM_INF));
        }
    }
}

// The 80,000 triangles of the Large Needle Driver against what ToolModel::load() makes of them, drawn eight times as large.
TEST(SurgTrack_MeshRaster, decimationKeepsTheOutline)
{
    const std::string file = recorded("tools/large_needle_driver/large_needle_driver.yaml");
    const int enlarged = 8;
    const CameraModel camera(Matx33d(800. * enlarged, 0, 359.5 * enlarged, 0, 800. * enlarged, 287.5 * enlarged, 0, 0, 1), noArray(),
                             Size(720 * enlarged, 576 * enlarged));
    const Rect window(200 * enlarged, 130 * enlarged, 320 * enlarged, 320 * enlarged);
    RNG rng(10);
    std::vector<float> off;
    double outline = 0;
    const Ptr<ToolModel> models[] = {ToolModel::load(file, 0), ToolModel::load(file)};
    for (int view = 0; view < 6; view++)
    {
        const Matx44d camera_T_tool = rigid(rotationMatrix(Vec3d(rng.uniform(-1., 1.), rng.uniform(2., 3.), rng.uniform(-1., 1.))), Point3d(0, 0, 0.09));
        std::vector<double> joints = {0, 0, 0.1, rng.uniform(-1., 1.), rng.uniform(-1., 1.), rng.uniform(-1., 1.), rng.uniform(0., 0.8)};
        Mat shapes[2];
        for (int i = 0; i < 2; i++)
        {
            Ptr<MeshRenderer> renderer = MeshRenderer::createSoftware();
            Rendering rendering;
            const Matx44d camera_T_base = camera_T_tool * models[i]->endEffectorPose(joints).inv();
            renderer->render(camera, window, instancesOf(*renderer, *models[i], camera_T_base, joints), rendering);
            shapes[i] = rendering.ids.clone();
        }
        Mat inside, outside, edge;
        distanceTransform(shapes[0], inside, DIST_L2, DIST_MASK_PRECISE);
        distanceTransform(1 - shapes[0], outside, DIST_L2, DIST_MASK_PRECISE);
        morphologyEx(shapes[0], edge, MORPH_GRADIENT, Mat::ones(3, 3, CV_8U));
        outline += countNonZero(edge) / 2.;
        for (int y = 0; y < window.height; y++)
            for (int x = 0; x < window.width; x++)
                if (shapes[0].at<uchar>(y, x) != shapes[1].at<uchar>(y, x))
                    off.push_back((inside.at<float>(y, x) + outside.at<float>(y, x) - 0.5f) / enlarged);   // the outline runs between pixels
    }
    ASSERT_GT(outline, 1000.);
    ASSERT_FALSE(off.empty());
    std::sort(off.begin(), off.end());
    EXPECT_LT(off.size() / outline / enlarged, 0.015);     // mean distance of the outlines [pixel]; measured: 0.013
    EXPECT_LE(off[off.size() * 99 / 100], 0.15);           // of the area between them; measured: 0.11, and 0.22 in the worst place
}

}} // namespace
