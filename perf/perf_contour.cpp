// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "perf_common.hpp"

namespace opencv_test { namespace {

typedef TestBaseWithParam<Size> Size_Contour;

// A tool, its drawing and its outline.
struct Outline : View
{
    explicit Outline(Size size) : View(size), renderer(PartTemplateRenderer::create(Ptr<MeshRenderer>(), wholeTool())), contour(ToolContour::create(scene->model()))
    {
        renderer->addTool(scene->model());
        std::vector<PartTemplate> parts;
        renderer->render(camera, views, 0, parts);
        sample();
    }

    static PartTemplateRenderer::Params wholeTool()
    {
        PartTemplateRenderer::Params params;
        params.wholeTool = true;
        return params;
    }

    void sample() { contour->sample(camera, views[0], renderer->rendering(), 1, points); }

    Ptr<PartTemplateRenderer> renderer;
    Ptr<ToolContour> contour;
    std::vector<ContourPoint> points;
};

PERF_TEST_P(Size_Contour, sample, SURGTRACK_SIZES)
{
    Outline outline(GetParam());
    TEST_CYCLE() outline.sample();
    ASSERT_GT(outline.points.size(), 50u);
    SANITY_CHECK_NOTHING();
}

PERF_TEST_P(Size_Contour, place, SURGTRACK_SIZES)
{
    Outline outline(GetParam());
    TEST_CYCLE() placeContour(outline.camera, outline.views[0], outline.points);
    ASSERT_GT(outline.points.size(), 50u);
    SANITY_CHECK_NOTHING();
}

PERF_TEST_P(Size_Contour, match, SURGTRACK_SIZES)
{
    Outline outline(GetParam());
    const ContourSearch search;
    int found = 0;
    TEST_CYCLE() found = matchContour(outline.image, outline.points, search);
    ASSERT_GT(found, int(outline.points.size() / 3));
    SANITY_CHECK_NOTHING();
}

// What METHOD_FULL does about three times a frame: all parts and the outline, about the state found before. The size only says which camera.
PERF_TEST_P(Size_Contour, correct, SURGTRACK_SIZES)
{
    Outline outline(GetParam());
    matchContour(outline.image, outline.points, ContourSearch());
    const std::vector<ToolModel::Keypoint>& keypoints = outline.scene->model()->keypoints();
    std::vector<int> parts;
    std::vector<Point2d> imagePoints;
    for (size_t i = 0; i < keypoints.size(); i++)
    {
        const Point3d& k = keypoints[i].linkPoint;
        const Vec4d p = outline.views[0].camera_T_base * outline.views[0].base_T_link[keypoints[i].link] * Vec4d(k.x, k.y, k.z, 1);
        parts.push_back(int(i));
        imagePoints.push_back(outline.camera.project(Point3d(p[0], p[1], p[2])));
    }
    Ptr<ArticulatedPoseEKF> filter = ArticulatedPoseEKF::create(outline.scene->model(), outline.scene->camera_T_base(0));
    filter->predict(outline.scene->trueJoints(0, 0));
    std::vector<uchar> used;
    int edges = 0;
    bool solved = false;
    TEST_CYCLE()
    {
        filter->begin();
        filter->addPoints(outline.camera, Matx44d::eye(), parts, imagePoints, used);
        edges = filter->addContour(outline.camera, Matx44d::eye(), outline.points, 3);
        solved = filter->solve();
    }
    ASSERT_TRUE(solved);
    ASSERT_GT(edges, 20);
    SANITY_CHECK_NOTHING();
}

}} // namespace
