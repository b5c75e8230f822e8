// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include <deque>
#include "opencv2/surgtrack/mesh_renderer.hpp"
#include "render/check_rendering.hpp"
#include "render/mesh_raster.hpp"

namespace cv { namespace surgtrack { namespace {

class SoftwareRenderer CV_FINAL : public MeshRenderer
{
public:
    int addMesh(const Mesh& mesh) CV_OVERRIDE;
    void render(const CameraModel& camera, const Rect& window, const std::vector<MeshInstance>& instances, Rendering& rendering,
                const std::vector<Rect>& regions) CV_OVERRIDE;

private:
    std::deque<ClusteredMesh> meshes_;
    std::vector<RasterInstance> instances_;
    RasterTarget target_;
};

int SoftwareRenderer::addMesh(const Mesh& mesh)
{
    CV_CheckEQ(mesh.normals.size(), mesh.vertices.size(), "a mesh needs one normal per vertex");
    if (mesh.triangles.empty()) CV_Error(Error::StsBadArg, "mesh has no triangles");
    for (size_t i = 0; i < mesh.vertices.size(); i++)
    {
        const Point3f& p = mesh.vertices[i];
        if (!(std::abs(p.x) < 1e6f && std::abs(p.y) < 1e6f && std::abs(p.z) < 1e6f))
            CV_Error(Error::StsBadArg, format("mesh vertex %d is not finite", int(i)));
    }
    for (size_t i = 0; i < mesh.triangles.size(); i++)
        for (int j = 0; j < 3; j++)
            CV_CheckLT((size_t)mesh.triangles[i][j], mesh.vertices.size(), "triangle refers to a vertex that does not exist");
    meshes_.push_back(clusterMesh(mesh));
    return int(meshes_.size()) - 1;
}

void SoftwareRenderer::render(const CameraModel& camera, const Rect& window, const std::vector<MeshInstance>& instances, Rendering& rendering,
                              const std::vector<Rect>& regions)
{
    checkRendering(camera, window, instances, int(meshes_.size()));
    const RasterView view = rasterView(camera, window);
    instances_.clear();
    for (size_t i = 0; i < instances.size(); i++)
    {
        const RasterInstance instance = {&meshes_[instances[i].mesh], Matx44f(instances[i].camera_T_mesh), instances[i].id};
        instances_.push_back(instance);
    }
    target_.create(window.size());
    if (!regions.empty()) target_.exclude();
    for (size_t i = 0; i < regions.size(); i++) target_.include((regions[i] & window) - window.tl());
    rasterize(view, instances_, target_);

    rendering.create(window);
    for (int y = 0; y < window.height; y++)
        unpackRow(target_.w + y * target_.step, target_.surface + y * target_.step, window.width, rendering.depth.ptr<float>(y), rendering.ids.ptr(y),
                  rendering.shading.ptr(y));
}

} // namespace

Ptr<MeshRenderer> MeshRenderer::createSoftware()
{
    return makePtr<SoftwareRenderer>();
}

}} // namespace cv::surgtrack
