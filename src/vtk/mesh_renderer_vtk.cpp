// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "base/geometry.hpp"
#include "render/check_rendering.hpp"
#include "vtk/camera_rays.hpp"
#include "vtk/vtk_mesh.hpp"
#include "vtk/vtk_window.hpp"

#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkCullerCollection.h>
#include <vtkFloatArray.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkOpenGLPolyDataMapper.h>
#include <vtkOpenGLVertexBufferObject.h>
#include <vtkPolyData.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkShaderProperty.h>
#include <vtkUniforms.h>
#include <vtkUnsignedCharArray.h>

// One pass of OpenGL: a fragment shader writes id and shade as colour, the z-buffer is the depth. OpenGL draws straight lines
// only, so a camera with distortion gets a finer image without, from which each pixel takes the sample nearest to its ray.

namespace cv { namespace surgtrack { namespace {

const Matx44d gl_T_camera(1, 0, 0, 0, 0, -1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1);   // OpenGL: y up, z backward
const double nearPlane = 0.002;      // [m]; as in the software renderer

const char* const vertexShader =
    "//VTK::System::Dec\n"
    "in vec4 vertexMC;\n"
    "in vec3 normalMC;\n"
    "uniform mat4 MCDCMatrix;\n"
    "uniform mat4 MCVCMatrix;\n"
    "uniform mat3 normalMatrix;\n"
    "out vec3 viewPoint;\n"
    "out vec3 viewNormal;\n"
    "void main()\n"
    "{\n"
    "  viewPoint = (MCVCMatrix * vertexMC).xyz;\n"
    "  viewNormal = normalMatrix * normalMC;\n"
    "  gl_Position = MCDCMatrix * vertexMC;\n"
    "}\n";

const char* const fragmentShader =
    "//VTK::System::Dec\n"
    "//VTK::Output::Dec\n"
    "//VTK::CustomUniforms::Dec\n"
    "in vec3 viewPoint;\n"
    "in vec3 viewNormal;\n"
    "void main()\n"
    "{\n"
    "  float shade = abs(dot(viewNormal, viewPoint)) / (length(viewNormal) * length(viewPoint) + 1e-20);\n"
    "  gl_FragData[0] = vec4(instanceId, shade, 0.0, 1.0);\n"
    "}\n";

struct VTKMesh
{
    vtkSmartPointer<vtkPolyData> data;
    std::vector<vtkSmartPointer<vtkActor> > actors;   // one for each instance in a drawing
    size_t used;                                      // of them, in this drawing
    Point3d lo, hi;                                   // bounding box
};

class VTKRenderer CV_FINAL : public MeshRenderer
{
public:
    explicit VTKRenderer(const Drawable& drawable);
    ~VTKRenderer() CV_OVERRIDE;

    int addMesh(const Mesh& mesh) CV_OVERRIDE;
    void render(const CameraModel& camera, const Rect& window, const std::vector<MeshInstance>& instances, Rendering& rendering,
                const std::vector<Rect>& regions) CV_OVERRIDE;

    //! Draws a square. @return whether it is there
    bool test();

private:
    bool place(const std::vector<MeshInstance>& instances, double& nearest, double& farthest);
    void draw(const Pinhole& pinhole, double nearest, double farthest);

    Ptr<XDisplayHolder> display_;
    vtkSmartPointer<vtkOpenGLRenderWindow> window_;
    vtkSmartPointer<vtkRenderer> renderer_;
    vtkSmartPointer<vtkMatrix4x4> projection_;
    vtkSmartPointer<vtkUnsignedCharArray> colours_;
    vtkSmartPointer<vtkFloatArray> depths_;
    std::vector<VTKMesh> meshes_;
    CameraRays rays_;
};

VTKRenderer::VTKRenderer(const Drawable& drawable)
    : display_(drawable.display), window_(drawable.window), renderer_(vtkSmartPointer<vtkRenderer>::New()), projection_(vtkSmartPointer<vtkMatrix4x4>::New()),
      colours_(vtkSmartPointer<vtkUnsignedCharArray>::New()), depths_(vtkSmartPointer<vtkFloatArray>::New())
{
    window_->SetOffScreenRendering(1);
    window_->SetMultiSamples(0);
    window_->SetSwapBuffers(0);   // what was drawn is read from where it was drawn
    window_->AddRenderer(renderer_);
    renderer_->SetBackground(0, 0, 0);
    renderer_->AutomaticLightCreationOff();
    renderer_->GetCullers()->RemoveAllItems();   // they do not know explicit projections
    vtkCamera* camera = renderer_->GetActiveCamera();
    camera->SetPosition(0, 0, 0);
    camera->SetFocalPoint(0, 0, -1);
    camera->SetViewUp(0, 1, 0);
    camera->SetExplicitProjectionTransformMatrix(projection_);
    camera->UseExplicitProjectionTransformMatrixOn();
}

VTKRenderer::~VTKRenderer()
{
    SavedGLContexts saved;
    Quiet quiet;
    window_->Finalize();
    meshes_.clear();
    renderer_ = 0;
    window_ = 0;
}

int VTKRenderer::addMesh(const Mesh& mesh)
{
    VTKMesh m;
    m.data = toPolyData(mesh);
    m.used = 0;
    m.lo = Point3d(DBL_MAX, DBL_MAX, DBL_MAX);
    m.hi = -m.lo;
    for (size_t i = 0; i < mesh.vertices.size(); i++)
    {
        const Point3f& p = mesh.vertices[i];
        m.lo = Point3d(std::min<double>(m.lo.x, p.x), std::min<double>(m.lo.y, p.y), std::min<double>(m.lo.z, p.z));
        m.hi = Point3d(std::max<double>(m.hi.x, p.x), std::max<double>(m.hi.y, p.y), std::max<double>(m.hi.z, p.z));
    }
    meshes_.push_back(m);
    return int(meshes_.size()) - 1;
}

vtkSmartPointer<vtkActor> makeActor(vtkPolyData* data)
{
    vtkSmartPointer<vtkActor> actor = vtkSmartPointer<vtkActor>::New();
    vtkNew<vtkOpenGLPolyDataMapper> mapper;
    mapper->SetInputData(data);
    mapper->ScalarVisibilityOff();
    mapper->SetStatic(1);
    mapper->SetVBOShiftScaleMethod(vtkOpenGLVertexBufferObject::DISABLE_SHIFT_SCALE);
    actor->SetMapper(mapper);
    actor->GetProperty()->LightingOff();
    actor->GetShaderProperty()->SetVertexShaderCode(vertexShader);
    actor->GetShaderProperty()->SetFragmentShaderCode(fragmentShader);
    vtkNew<vtkMatrix4x4> pose;
    actor->SetUserMatrix(pose);
    return actor;
}

// Poses the actors. Returns whether any may be seen; nearest and farthest enclose what is in front of the near plane [m].
bool VTKRenderer::place(const std::vector<MeshInstance>& instances, double& nearest, double& farthest)
{
    for (size_t i = 0; i < meshes_.size(); i++)
    {
        meshes_[i].used = 0;
        for (size_t j = 0; j < meshes_[i].actors.size(); j++) meshes_[i].actors[j]->SetVisibility(0);
    }
    nearest = DBL_MAX;
    farthest = -DBL_MAX;
    for (size_t i = 0; i < instances.size(); i++)
    {
        VTKMesh& mesh = meshes_[instances[i].mesh];
        const Matx44d& T = instances[i].camera_T_mesh;
        double zmin = DBL_MAX, zmax = -DBL_MAX;
        for (int corner = 0; corner < 8; corner++)
        {
            const Point3d p(corner & 1 ? mesh.hi.x : mesh.lo.x, corner & 2 ? mesh.hi.y : mesh.lo.y, corner & 4 ? mesh.hi.z : mesh.lo.z);
            const double z = transform(T, p).z;
            zmin = std::min(zmin, z);
            zmax = std::max(zmax, z);
        }
        if (zmax <= nearPlane) continue;
        nearest = std::min(nearest, zmin);
        farthest = std::max(farthest, zmax);

        if (mesh.used == mesh.actors.size())
        {
            mesh.actors.push_back(makeActor(mesh.data));
            renderer_->AddActor(mesh.actors.back());
        }
        vtkActor* actor = mesh.actors[mesh.used++];
        const Matx44d gl_T_mesh = gl_T_camera * T;
        actor->GetUserMatrix()->DeepCopy(gl_T_mesh.val);
        actor->GetShaderProperty()->GetFragmentCustomUniforms()->SetUniformf("instanceId", float(instances[i].id) / 255);
        actor->SetVisibility(1);
    }
    // A little room, so that rounding does not clip what touches the planes.
    nearest = std::max(nearPlane, nearest * 0.999 - 1e-6);
    farthest = farthest * 1.001 + 1e-6;
    return farthest > nearest;
}

// Draws into the first pixels of the window, which never shrinks, and reads them into colours_ and depths_, bottom row first.
void VTKRenderer::draw(const Pinhole& pinhole, double nearest, double farthest)
{
    const int w = pinhole.width, h = pinhole.height;
    const int W = std::max(w, window_->GetSize()[0]), H = std::max(h, window_->GetSize()[1]);
    if (W != window_->GetSize()[0] || H != window_->GetSize()[1]) window_->SetSize(W, H);
    renderer_->SetViewport(0, 0, double(w) / W, double(h) / H);

    // Pixel centres are integers in OpenCV and halves in OpenGL. Columns act on (x, y, z) of OpenGL, where -z is the depth.
    const double n = nearest, f = farthest;
    const Matx44d projection(2 * pinhole.fx / w, 0, 1 - 2 * (pinhole.cx + 0.5) / w, 0,
                             0, 2 * pinhole.fy / h, 2 * (pinhole.cy + 0.5) / h - 1, 0,
                             0, 0, -(f + n) / (f - n), -2 * f * n / (f - n),
                             0, 0, -1, 0);
    projection_->DeepCopy(projection.val);
    renderer_->GetActiveCamera()->Modified();   // it does not look into the matrix for a change

    window_->Render();
    if (window_->GetRGBACharPixelData(0, 0, w - 1, h - 1, 0, colours_) != VTK_OK
        || window_->GetZbufferData(0, 0, w - 1, h - 1, depths_) != VTK_OK)
        CV_Error(Error::StsError, "OpenGL failed to draw or to read back");
}

void VTKRenderer::render(const CameraModel& camera, const Rect& window, const std::vector<MeshInstance>& instances, Rendering& rendering,
                         const std::vector<Rect>&)
{
    checkRendering(camera, window, instances, int(meshes_.size()));

    rendering.create(window);
    double n, f;
    if (!place(instances, n, f))
    {
        rendering.depth.setTo(0);
        rendering.ids.setTo(0);
        rendering.shading.setTo(0);
        return;
    }

    Mat_<Vec2f> rays;
    Pinhole pinhole = {window.width, window.height, camera.fx, camera.fy, camera.cx - window.x, camera.cy - window.y};
    if (camera.hasDistortion())
    {
        rays = rays_.of(camera)(window);
        pinhole = enclose(camera, rays);
    }
    {
        SavedGLContexts saved;
        Quiet quiet;
        draw(pinhole, n, f);
    }

    const uchar* colours = colours_->GetPointer(0);
    const float* depths = depths_->GetPointer(0);
    const float a = float(1 / n), b = float((f - n) / (f * n));   // 1 / z is linear in the z-buffer's value
    const bool distorted = !rays.empty();
    for (int y = 0; y < window.height; y++)
    {
        float* depth = rendering.depth.ptr<float>(y);
        uchar* ids = rendering.ids.ptr(y);
        uchar* shading = rendering.shading.ptr(y);
        for (int x = 0; x < window.width; x++)
        {
            int column = x, row = y;
            if (distorted)
            {
                const Vec2f ray = rays(y, x);
                column = std::min(std::max(cvRound(ray[0] * pinhole.fx + pinhole.cx), 0), pinhole.width - 1);
                row = std::min(std::max(cvRound(ray[1] * pinhole.fy + pinhole.cy), 0), pinhole.height - 1);
            }
            const size_t i = size_t(pinhole.height - 1 - row) * pinhole.width + column;
            ids[x] = colours[4 * i];
            shading[x] = colours[4 * i + 1];
            depth[x] = ids[x] ? 1 / (a - b * depths[i]) : 0.f;
        }
    }
}

bool VTKRenderer::test()
{
    Mesh mesh;
    const float side[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    for (int i = 0; i < 4; i++)
    {
        mesh.vertices.push_back(Point3f(side[i][0], side[i][1], 0));
        mesh.normals.push_back(Point3f(0, 0, -1));
    }
    mesh.triangles.push_back(Vec3i(0, 2, 1));
    mesh.triangles.push_back(Vec3i(0, 3, 2));

    SavedGLContexts saved;
    Quiet quiet;
    window_->SetSize(16, 16);
    window_->Initialize();
    window_->MakeCurrent();
    if (!window_->IsCurrent()) return false;
    int major = 0, minor = 0;
    window_->GetOpenGLVersion(major, minor);
    if (major * 10 + minor < 32) return false;

    MeshInstance instance;
    instance.mesh = addMesh(mesh);
    instance.id = 200;
    instance.camera_T_mesh = Matx44d::eye();
    instance.camera_T_mesh(2, 3) = 2;
    Rendering rendering;
    const CameraModel camera(Matx33d(8, 0, 7.5, 0, 8, 7.5, 0, 0, 1), noArray(), Size(16, 16));
    try
    {
        render(camera, Rect(0, 0, 16, 16), std::vector<MeshInstance>(1, instance), rendering, std::vector<Rect>());
    }
    catch (const cv::Exception&)
    {
        return false;
    }
    renderer_->RemoveActor(meshes_.back().actors[0]);
    meshes_.clear();
    return rendering.ids.at<uchar>(8, 8) == 200 && std::abs(rendering.depth.at<float>(8, 8) - 2) < 1e-3
        && rendering.shading.at<uchar>(8, 8) > 240 && rendering.ids.at<uchar>(0, 0) == 0;
}

} // namespace

Ptr<MeshRenderer> MeshRenderer::createVTK()
{
    typedef Drawable (*Opener)(String&);
    const Opener openers[2] = {openXWindow, openEGLWindow};
    const char* const names[2] = {"X", "EGL"};
    String reasons;
    for (int i = 0; i < 2; i++)
    {
        String reason;
        Ptr<VTKRenderer> renderer;
        XDisplayHolder::ErrorsIgnored ignored;
        {
            SavedGLContexts saved;
            Quiet quiet;
            const Drawable drawable = openers[i](reason);
            if (drawable.window) renderer = makePtr<VTKRenderer>(drawable);
        }
        if (renderer && renderer->test()) return renderer;
        if (renderer) reason = "OpenGL 3.2 does not work there";
        renderer.release();   // closes the display, which waits for its errors
        reasons += format("%s%s: %s", i ? "; " : "", names[i], reason.c_str());
    }
    CV_Error(Error::StsNotImplemented, "VTK can draw neither through an X server nor without one. " + reasons);
}

}} // namespace cv::surgtrack
