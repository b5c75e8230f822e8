// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "perf_common.hpp"

namespace opencv_test { namespace {

typedef TestBaseWithParam<tuple<Size, int> > Size_Tools_PartTemplates;
typedef TestBaseWithParam<tuple<Size, std::string> > Size_CAD_PartTemplates;

// Drawing included: all tools are drawn, the templates of one are cut.
PERF_TEST_P(Size_Tools_PartTemplates, render, testing::Combine(SURGTRACK_SIZES, testing::Values(1, 2, 4)))
{
    const int tools = get<1>(GetParam());
    const Pose view(get<0>(GetParam()), tools);
    Ptr<PartTemplateRenderer> renderer = PartTemplateRenderer::create();
    for (int i = 0; i < tools; i++) renderer->addTool(view.scene->model());
    std::vector<PartTemplate> templates;
    renderer->render(view.camera, view.views, 0, templates);
    TEST_CYCLE() renderer->render(view.camera, view.views, 0, templates);
    ASSERT_FALSE(templates.empty());
    SANITY_CHECK_NOTHING();
}

PERF_TEST_P(Size_CAD_PartTemplates, render, testing::Combine(SURGTRACK_SIZES, SURGTRACK_CAD))
{
    const Pose view(get<0>(GetParam()), 1, tool(get<1>(GetParam())));
    Ptr<PartTemplateRenderer> renderer = PartTemplateRenderer::create();
    renderer->addTool(view.scene->model());
    std::vector<PartTemplate> templates;
    renderer->render(view.camera, view.views, 0, templates);
    TEST_CYCLE() renderer->render(view.camera, view.views, 0, templates);
    ASSERT_FALSE(templates.empty());
    SANITY_CHECK_NOTHING();
}

}} // namespace
