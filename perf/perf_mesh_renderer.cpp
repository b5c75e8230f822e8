// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "perf_common.hpp"

namespace opencv_test { namespace {

typedef TestBaseWithParam<Size> Size_MeshRenderer;

struct Drawing
{
    explicit Drawing(Size size) : view(size), renderer(MeshRenderer::createSoftware())
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

    View view;
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

// As for templates: around the tool's wrist.
PERF_TEST_P(Size_MeshRenderer, softwareWindow, SURGTRACK_SIZES)
{
    Drawing d(GetParam());
    const int side = cvRound(300 * GetParam().width / 720.);
    const Rect window = Rect(GetParam().width / 2 - side / 2, GetParam().height / 2 - side / 2, side, side) & Rect(Point(), GetParam());
    d.renderer->render(d.view.camera, window, d.instances, d.rendering);
    TEST_CYCLE() d.renderer->render(d.view.camera, window, d.instances, d.rendering);
    ASSERT_GT(countNonZero(d.rendering.ids), 1000);
    SANITY_CHECK_NOTHING();
}

}} // namespace
