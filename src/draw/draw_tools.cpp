// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/surgtrack/draw.hpp"
#include "base/geometry.hpp"
#include "render/box_window.hpp"
#include "render/tool_instances.hpp"

namespace cv { namespace surgtrack {

DrawnTool::DrawnTool() : camera_T_base(Matx44d::eye()), color(0, 255, 0), opacity(0.4) {}

DrawnTool::DrawnTool(const Ptr<ToolModel>& _model, const std::vector<double>& _joints, const Matx44d& _camera_T_base, const Scalar& _color,
                     double _opacity)
    : model(_model), joints(_joints), camera_T_base(_camera_T_base), color(_color), opacity(_opacity)
{
}

namespace {

const double ambient = 0.15;   // light from everywhere, as in the drawings that templates are cut from

// All meshes of all tools; the number of a tool plus one is the id of its meshes. windows: what holds all that is seen of each.
void placeTools(const CameraModel& camera, const std::vector<DrawnTool>& tools, MeshRenderer& renderer, std::vector<MeshInstance>& instances,
                std::vector<Rect>& windows)
{
    const Rect2d field = camera.fieldOfView(Rect(Point(), camera.imageSize()));
    CV_CheckLE(tools.size(), size_t(255), "too many tools");
    std::vector<Matx44d> base_T_link;
    for (size_t i = 0; i < tools.size(); i++)
    {
        const DrawnTool& tool = tools[i];
        if (!tool.model) CV_Error(Error::StsBadArg, format("tools[%d].model is empty", int(i)));
        if (!isRigid(tool.camera_T_base, 1e-2)) CV_Error(Error::StsBadArg, format("tools[%d].camera_T_base must be a rigid transform", int(i)));
        CV_Check(tool.opacity, tool.opacity >= 0 && tool.opacity <= 1, "opacity must be in 0..1");
        const int firstMesh = renderer.addTool(tool.model);
        tool.model->forwardKinematics(tool.joints, base_T_link);
        const size_t first = instances.size();
        addInstances(*tool.model, firstMesh, tool.camera_T_base, base_T_link, int(i) + 1, false, instances);
        BoxWindow window;
        for (size_t k = first; k < instances.size(); k++)
            window.add(instances[k].camera_T_mesh, boxAbout(tool.model->meshes()[instances[k].mesh - firstMesh]));
        windows.push_back(window.get(camera, field));
    }
}

void blend(Mat& image, const Mat& covered, const Mat& shading, const DrawnTool& tool)
{
    // In 1 / 256 of a grey level, with half of one for rounding.
    const int rest = 256 - cvRound(256 * tool.opacity);
    Vec3i light[256];
    for (int s = 0; s < 256; s++)
        for (int c = 0; c < 3; c++) light[s][c] = saturate_cast<uchar>(tool.color[c] * (ambient + (1 - ambient) * s / 255)) * (256 - rest) + 128;
    for (int y = 0; y < image.rows; y++)
    {
        const uchar *inside = covered.ptr(y), *shades = shading.ptr(y);
        Vec3b* row = image.ptr<Vec3b>(y);
        for (int x = 0; x < image.cols; x++)
            for (int c = 0; inside[x] && c < 3; c++) row[x][c] = uchar((light[shades[x]][c] + rest * row[x][c]) >> 8);
    }
}

/* Of the pixels that are covered, those near the covered area's border. Lines are drawn about it, and cut: quicker than eroding it.
   covered: 255 or 0; what goes on beyond its border has no outline there */
Mat outlineOf(const Mat& covered, int thickness)
{
    const int pad = thickness + 1;
    Mat padded, lines;
    copyMakeBorder(covered, padded, pad, pad, pad, pad, BORDER_REPLICATE);
    std::vector<std::vector<Point> > contours;
    findContours(padded, contours, RETR_LIST, CHAIN_APPROX_NONE);
    lines = Mat::zeros(padded.size(), CV_8UC1);
    drawContours(lines, contours, -1, Scalar::all(255), 2 * thickness - 1);
    return lines(Rect(Point(pad, pad), covered.size())) & covered;
}

} // namespace

void drawTools(InputOutputArray _image, const CameraModel& camera, const std::vector<DrawnTool>& tools, const Ptr<MeshRenderer>& _renderer, int thickness)
{
    Mat image = _image.getMat();
    CV_CheckTypeEQ(image.type(), CV_8UC3, "image must be BGR");
    if (image.size() != camera.imageSize())
        CV_Error(Error::StsUnmatchedSizes, format("image is %d x %d, the camera's is %d x %d", image.cols, image.rows, camera.imageSize().width,
                                                  camera.imageSize().height));
    const Ptr<MeshRenderer> renderer = _renderer ? _renderer : MeshRenderer::createSoftware();
    if (thickness < 0) thickness = std::max(1, cvRound(image.cols / 360.));
    std::vector<MeshInstance> instances;
    std::vector<Rect> windows;
    placeTools(camera, tools, *renderer, instances, windows);
    Rendering rendering;
    for (size_t i = 0; i < tools.size(); i++)
    {
        if (windows[i].empty()) continue;
        renderer->render(camera, windows[i], instances, rendering);   // all of them, for what hides it
        Mat part = image(windows[i]);
        const Mat covered = rendering.ids == double(i + 1);
        blend(part, covered, rendering.shading, tools[i]);
        if (thickness > 0) part.setTo(tools[i].color, outlineOf(covered, thickness));
    }
}

void drawTool(InputOutputArray image, const CameraModel& camera, const Ptr<ToolModel>& model, InputArray joints, const Matx44d& camera_T_base,
              const Scalar& color, double opacity, const Ptr<MeshRenderer>& renderer)
{
    std::vector<double> values;
    joints.copyTo(values);
    drawTools(image, camera, std::vector<DrawnTool>(1, DrawnTool(model, values, camera_T_base, color, opacity)), renderer);
}

}} // namespace cv::surgtrack
