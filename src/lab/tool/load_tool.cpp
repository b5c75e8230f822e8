// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/surgtrack/import.hpp"
#include "opencv2/surgtrack/tool_setup.hpp"
#include "files/joint_names.hpp"
#include "files/mesh_io.hpp"
#include "lab/tool/simplified.hpp"
#include "model/mesh.hpp"

namespace cv { namespace surgtrack {

Ptr<ToolModel> simplified(const Ptr<ToolModel>& model, int maxTriangles)
{
    size_t triangles = 0;
    for (size_t i = 0; i < model->meshes().size(); i++)
        triangles += model->meshes()[i].triangles.size();
    if (maxTriangles <= 0 || triangles <= (size_t)maxTriangles)
        return model;
    ToolModel::Description tool = model->description();
    for (size_t i = 0; i < tool.meshes.size(); i++)
        mergePoints(tool.meshes[i]);
    decimateMeshes(tool.meshes, maxTriangles);
    for (size_t i = 0; i < tool.meshes.size(); i++)
        computeNormals(tool.meshes[i]);
    return ToolModel::create(tool);
}

static bool isUrdf(const String& filename)
{
    const size_t dot = filename.rfind('.');
    const String ending = dot == String::npos ? String() : lowerCase(filename.substr(dot));
    return ending == ".urdf" || ending == ".xacro";
}

Ptr<ToolModel> loadTool(const String& filename, int maxTriangles)
{
    CV_CheckGE(maxTriangles, 0, "maxTriangles: 0 keeps all");
    const bool urdf = isUrdf(filename);
    const Ptr<ToolModel> model = urdf ? importUrdfTool(filename) : ToolModel::load(filename, maxTriangles);
    if (!model->keypoints().empty() || model->meshes().empty())
        return simplified(model, maxTriangles);
    try
    {
        return simplified(chooseKeypoints(urdf ? model : ToolModel::load(filename, 0)), maxTriangles);
    }
    catch (const Exception& e)
    {
        if (e.code != Error::StsObjectNotFound)
            throw;
        return simplified(model, maxTriangles);   // nothing to be found: checkTool() says why
    }
}

}} // namespace cv::surgtrack
