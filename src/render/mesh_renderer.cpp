// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "base/geometry.hpp"
#include "render/check_rendering.hpp"
#include "render/tool_instances.hpp"

namespace cv { namespace surgtrack {

Rendering::Rendering() {}

MeshInstance::MeshInstance() : mesh(-1), id(0), camera_T_mesh(Matx44d::eye()) {}

MeshInstance::MeshInstance(int _mesh, int _id, const Matx44d& _camera_T_mesh) : mesh(_mesh), id(_id), camera_T_mesh(_camera_T_mesh) {}

void Rendering::create(const Rect& newWindow)
{
    window = newWindow;
    const size_t n = window.area();
    if (storage_.total() < 6 * n) storage_.create(1, int(12 * n), CV_8UC1);   // windows that grow take memory now and then only
    depth = Mat(window.size(), CV_32FC1, storage_.data);
    ids = Mat(window.size(), CV_8UC1, storage_.data + 4 * n);
    shading = Mat(window.size(), CV_8UC1, storage_.data + 5 * n);
}

void checkRendering(const CameraModel& camera, const Rect& window, const std::vector<MeshInstance>& instances, int meshes)
{
    if (window.empty() || (window & Rect(Point(), camera.imageSize())) != window)
        CV_Error(Error::StsOutOfRange, format("window %d x %d at (%d, %d) does not lie in the image of %d x %d", window.width, window.height,
                                              window.x, window.y, camera.imageSize().width, camera.imageSize().height));
    for (size_t i = 0; i < instances.size(); i++)
    {
        CV_CheckGE(instances[i].mesh, 0, "no such mesh");
        CV_CheckLT(instances[i].mesh, meshes, "no such mesh");
        CV_Check(instances[i].id, instances[i].id >= 1 && instances[i].id <= 255, "id must be 1..255");
        // wider than at the door: products of transforms that were typed in
        if (!isRigid(instances[i].camera_T_mesh, 1e-2)) CV_Error(Error::StsBadArg, format("instances[%d].camera_T_mesh must be rigid", int(i)));
    }
}

int MeshRenderer::addTool(const Ptr<ToolModel>& tool)
{
    CV_Assert(tool);
    for (size_t i = 0; i < tools_.size(); i++)
        if (tools_[i].first == tool) return tools_[i].second;
    int firstMesh = -1;
    for (size_t i = 0; i < tool->meshes().size(); i++)
    {
        const int handle = addMesh(tool->meshes()[i]);
        if (i == 0) firstMesh = handle;
    }
    tools_.push_back(std::make_pair(tool, firstMesh));
    return firstMesh;
}

void MeshRenderer::renderTool(const Ptr<ToolModel>& tool, InputArray joints, const Matx44d& camera_T_base, const CameraModel& camera,
                              OutputArray depth, OutputArray ids, OutputArray shading)
{
    if (!isRigid(camera_T_base)) CV_Error(Error::StsBadArg, "camera_T_base must be a rigid transform");
    const int firstMesh = addTool(tool);
    std::vector<Matx44d> base_T_link;
    tool->forwardKinematics(joints, base_T_link);
    std::vector<MeshInstance> instances;
    addInstances(*tool, firstMesh, camera_T_base, base_T_link, 1, true, instances);
    Rendering rendering;
    render(camera, Rect(Point(), camera.imageSize()), instances, rendering);
    rendering.depth.copyTo(depth);
    rendering.ids.copyTo(ids);
    rendering.shading.copyTo(shading);
}

}} // namespace cv::surgtrack
