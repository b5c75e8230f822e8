// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_PERF_COMMON_HPP
#define OPENCV_SURGTRACK_PERF_COMMON_HPP

#include "perf_precomp.hpp"
#include "opencv2/imgproc.hpp"

namespace opencv_test {

using namespace cv::surgtrack;

// The images of endoscopes.
#define SURGTRACK_SIZES testing::Values(Size(720, 576), Size(1280, 1024), Size(1920, 1080))

// CAD models by their number of triangles, and the real one, for tool().
#define SURGTRACK_CAD testing::Values("12k", "80k", "1M", "SURGTRACK_DATA")

/* A tool as a user gets it, from a file by ToolModel::load(): "12k", "80k", "1M" = the built-in tool with that many triangles,
"SURGTRACK_DATA" = the Large Needle Driver of the data folder (the test is skipped without it). Made once. */
Ptr<ToolModel> tool(const std::string& cad);

// A frame of a scene with the built-in tool, of the left or the right eye. Drawn once.
Mat drawn(const SyntheticScene::Params& params, int frame, bool right = false);

/* Templates cut from an image, at its strongest corners. Features as cv::linemod chooses them: strong gradients, scattered.
Patches are 64 pixels wide at 720 pixels' width. */
std::vector<PartTemplate> cutTemplates(const Mat& image, int count, int features);

namespace {

inline SyntheticScene::Params sceneOf(Size size, int tools = 1, bool distortion = true)
{
    SyntheticScene::Params params;
    params.imageSize = size;
    params.tools = tools;
    params.distortion = distortion;
    if (tools > 2)    // so that every tool finds a start: what is measured is tracking
    {
        params.handEyeRotation /= 3;
        params.handEyeTranslation /= 3;
    }
    return params;
}

// Tools in a scene at its first frame.
struct Pose
{
    explicit Pose(Size size, int tools = 1, const Ptr<ToolModel>& model = Ptr<ToolModel>())
        : scene(SyntheticScene::create(model, sceneOf(size, tools))), camera(scene->camera())
    {
        for (int i = 0; i < tools; i++)
        {
            ToolView view;
            view.camera_T_base = scene->camera_T_base(i);
            scene->model()->forwardKinematics(scene->trueJoints(i, 0), view.base_T_link);
            views.push_back(view);
        }
    }

    Ptr<SyntheticScene> scene;
    CameraModel camera;
    std::vector<ToolView> views;
};

// The same and its image, as the tracker gets it.
struct View : Pose
{
    explicit View(Size size, int tools = 1) : Pose(size, tools), image(drawn(sceneOf(size, tools), 0)) {}

    // Templates of the first tool.
    std::vector<PartTemplate> templates() const
    {
        Ptr<PartTemplateRenderer> renderer = PartTemplateRenderer::create();
        for (size_t i = 0; i < views.size(); i++) renderer->addTool(scene->model());
        std::vector<PartTemplate> result;
        renderer->render(camera, views, 0, result);
        return result;
    }

    // Search windows as wide as while tracking.
    std::vector<Rect> windows(const std::vector<PartTemplate>& templates) const
    {
        const int half = cvRound(30 * camera.imageSize().width / 720.);
        std::vector<Rect> result;
        for (size_t i = 0; i < templates.size(); i++)
            result.push_back(Rect(templates[i].anchor.x - half, templates[i].anchor.y - half, 2 * half + 1, 2 * half + 1));
        return result;
    }

    Mat image;
};

}} // namespace

#endif
