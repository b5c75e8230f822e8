// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "perf_common.hpp"

namespace opencv_test { namespace {

typedef TestBaseWithParam<Size> Size_MeshRenderer;
typedef TestBaseWithParam<tuple<Size, std::string> > Size_CAD_MeshRenderer;

struct Drawing
{
    explicit Drawing(Size size, const Ptr<ToolModel>& tool = Ptr<ToolModel>()) : view(size, 1, tool), renderer(MeshRenderer::createSoftware())
    {
        const Ptr<ToolModel> model = view.scene->model();
        for (size_t i = 0; i < model->links().size(); i++)
        {
            if (model->links()[i].mesh < 0) continue;
            MeshInstance instance;
            instance.mesh = renderer->addMesh(model->meshes()[model->links()[i].mesh]);
            instance.id = int(i) + 1;
            instance.camera_T_mesh = view.views[0].camera_T_base * view.views[0].base_T_link[i];
            instances.push_back(instance);
        }
    }

    // As for templates: around the tool's wrist.
    Rect window() const
    {
        const Size size = view.camera.imageSize();
        const int side = cvRound(300 * size.width / 720.);
        return Rect(size.width / 2 - side / 2, size.height / 2 - side / 2, side, side) & Rect(Point(), size);
    }

    Pose view;
    Ptr<MeshRenderer> renderer;
    std::vector<MeshInstance> instances;
    Rendering rendering;
};

PERF_TEST_P(Size_MeshRenderer, softwareWholeImage, SURGTRACK_SIZES)
{
    Drawing d(GetParam());
    const Rect window(Point(), GetParam());
    d.renderer->render(d.view.camera, window, d.instances, d.rendering);
    TEST_CYCLE() d.renderer->render(d.view.camera, window, d.instances, d.rendering);
    ASSERT_GT(countNonZero(d.rendering.ids), 1000);
    SANITY_CHECK_NOTHING();
}

PERF_TEST_P(Size_MeshRenderer, softwareWindow, SURGTRACK_SIZES)
{
    Drawing d(GetParam());
    const Rect window = d.window();
    d.renderer->render(d.view.camera, window, d.instances, d.rendering);
    TEST_CYCLE() d.renderer->render(d.view.camera, window, d.instances, d.rendering);
    ASSERT_GT(countNonZero(d.rendering.ids), 1000);
    SANITY_CHECK_NOTHING();
}

PERF_TEST_P(Size_CAD_MeshRenderer, softwareWholeImage, testing::Combine(SURGTRACK_SIZES, SURGTRACK_CAD))
{
    Drawing d(get<0>(GetParam()), tool(get<1>(GetParam())));
    const Rect window(Point(), get<0>(GetParam()));
    d.renderer->render(d.view.camera, window, d.instances, d.rendering);
    TEST_CYCLE() d.renderer->render(d.view.camera, window, d.instances, d.rendering);
    ASSERT_GT(countNonZero(d.rendering.ids), 1000);
    SANITY_CHECK_NOTHING();
}

PERF_TEST_P(Size_CAD_MeshRenderer, softwareWindow, testing::Combine(SURGTRACK_SIZES, SURGTRACK_CAD))
{
    Drawing d(get<0>(GetParam()), tool(get<1>(GetParam())));
    const Rect window = d.window();
    d.renderer->render(d.view.camera, window, d.instances, d.rendering);
    TEST_CYCLE() d.renderer->render(d.view.camera, window, d.instances, d.rendering);
    ASSERT_GT(countNonZero(d.rendering.ids), 1000);
    SANITY_CHECK_NOTHING();
}

}} // namespace
