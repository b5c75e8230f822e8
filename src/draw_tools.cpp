// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"

namespace cv { namespace surgtrack {

DrawnTool::DrawnTool() : camera_T_base(Matx44d::eye()), color(0, 255, 0), opacity(0.4) {}

DrawnTool::DrawnTool(const Ptr<ToolModel>& _model, const std::vector<double>& _joints, const Matx44d& _camera_T_base, const Scalar& _color,
                     double _opacity)
    : model(_model), joints(_joints), camera_T_base(_camera_T_base), color(_color), opacity(_opacity)
{
}

namespace {

const double ambient = 0.15;   // light from everywhere, as in the drawings that templates are cut from

// All meshes of all tools; the number of a tool plus one is the id of its meshes.
void placeTools(const std::vector<DrawnTool>& tools, MeshRenderer& renderer, std::vector<MeshInstance>& instances)
{
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
        const std::vector<ToolModel::Link>& links = tool.model->links();
        for (size_t l = 0; l < links.size(); l++)
        {
            if (links[l].mesh < 0) continue;
            const MeshInstance instance = {firstMesh + links[l].mesh, int(i) + 1, tool.camera_T_base * base_T_link[l]};
            instances.push_back(instance);
        }
    }
}

// What is added to (1 - opacity) * image, for every shade.
std::vector<Vec3f> shades(const DrawnTool& tool)
{
    std::vector<Vec3f> result(256);
    for (int s = 0; s < 256; s++)
    {
        const double lit = tool.opacity * (ambient + (1 - ambient) * s / 255);
        result[s] = Vec3f(float(tool.color[0] * lit), float(tool.color[1] * lit), float(tool.color[2] * lit));
    }
    return result;
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
    std::vector<MeshInstance> instances;
    placeTools(tools, *renderer, instances);
    Rendering rendering;
    renderer->render(camera, Rect(Point(), camera.imageSize()), instances, rendering);
    const Rect box = boundingRect(rendering.ids);
    if (box.empty()) return;

    std::vector<std::vector<Vec3f> > surface;
    for (size_t i = 0; i < tools.size(); i++) surface.push_back(shades(tools[i]));
    for (int y = box.y; y < box.y + box.height; y++)
    {
        const uchar *ids = rendering.ids.ptr(y), *shading = rendering.shading.ptr(y);
        Vec3b* row = image.ptr<Vec3b>(y);
        for (int x = box.x; x < box.x + box.width; x++)
        {
            if (!ids[x]) continue;
            const Vec3f& s = surface[ids[x] - 1][shading[x]];
            const float rest = float(1 - tools[ids[x] - 1].opacity);
            for (int c = 0; c < 3; c++) row[x][c] = saturate_cast<uchar>(s[c] + rest * row[x][c]);
        }
    }

    if (thickness < 0) thickness = std::max(1, cvRound(image.cols / 360.));
    if (thickness == 0) return;
    const Mat disc = getStructuringElement(MORPH_ELLIPSE, Size(2 * thickness + 1, 2 * thickness + 1));
    for (size_t i = 0; i < tools.size(); i++)
    {
        const Mat covered = rendering.ids == double(i + 1);
        Mat inner;
        erode(covered, inner, disc);   // what lies beyond the image's border is no outline
        image.setTo(tools[i].color, covered & ~inner);
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
