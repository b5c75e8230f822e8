// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/surgtrack/scene_view.hpp"
#include "base/checks.hpp"
#include "base/geometry.hpp"
#include "vtk/scene_mouse.hpp"
#include "vtk/vtk_mesh.hpp"
#include "vtk/vtk_window.hpp"

#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkFloatArray.h>
#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkTexture.h>
#include <vtkUnsignedCharArray.h>

// The world is the camera frame; VTK only has to know that y points down.

namespace cv { namespace surgtrack { namespace {

const int gridStep = 16;             // the image is laid on a grid of so many pixels, which the lens bends
const double planeBehind = 1.25;     // the image is so many times as far as the farthest tool
const double defaultDepth = 0.1;     // of the image where there is no tool [m]
const double axisLength = 0.012;     // [m]
const Scalar backgroundLow(245, 245, 245), backgroundHigh(225, 215, 205);   // BGR
const Scalar fieldColor(120, 120, 120);

vtkSmartPointer<vtkActor> makeActor(vtkPolyData* data, const Scalar& bgr)
{
    vtkNew<vtkPolyDataMapper> mapper;
    mapper->SetInputData(data);
    mapper->ScalarVisibilityOff();
    vtkSmartPointer<vtkActor> actor = vtkSmartPointer<vtkActor>::New();
    actor->SetMapper(mapper);
    actor->GetProperty()->SetColor(bgr[2] / 255, bgr[1] / 255, bgr[0] / 255);
    return actor;
}

//! Through the points, in one colour, not lit.
vtkSmartPointer<vtkActor> makePath(const std::vector<Point3d>& line, const Scalar& bgr, float width)
{
    vtkNew<vtkPoints> points;
    vtkNew<vtkCellArray> cells;
    cells->InsertNextCell(int(line.size()));
    for (size_t i = 0; i < line.size(); i++) cells->InsertCellPoint(points->InsertNextPoint(line[i].x, line[i].y, line[i].z));
    vtkNew<vtkPolyData> data;
    data->SetPoints(points);
    data->SetLines(cells);
    vtkSmartPointer<vtkActor> actor = makeActor(data, bgr);
    actor->GetProperty()->SetLineWidth(width);
    actor->GetProperty()->LightingOff();
    return actor;
}

struct ModelMeshes
{
    Ptr<ToolModel> model;
    std::vector<vtkSmartPointer<vtkPolyData> > meshes;
};

class SceneViewImpl CV_FINAL : public SceneView
{
public:
    SceneViewImpl(const CameraModel& camera, Size size, const Drawable& drawable, bool window);
    ~SceneViewImpl() CV_OVERRIDE;

    void setViewpoint(const Point3d& viewer, const Point3d& centre) CV_OVERRIDE;
    void draw(InputArray image, const std::vector<DrawnTool>& tools, const std::vector<Mat>& paths, OutputArray picture) CV_OVERRIDE;
    void show(double seconds) CV_OVERRIDE;

    //! Draws nothing. @return whether the background is there
    bool test();

private:
    void addTool(const DrawnTool& tool);
    void addField();
    void addImage(const Mat& image);
    void render(Mat& picture);
    Point3d onPlane(double u, double v) const;
    const ModelMeshes& meshesOf(const Ptr<ToolModel>& model);

    CameraModel camera_;
    Size size_;
    Ptr<XDisplayHolder> display_;
    vtkSmartPointer<vtkOpenGLRenderWindow> window_;
    vtkSmartPointer<vtkRenderer> renderer_;
    std::vector<ModelMeshes> models_;
    bool inWindow_, placed_;
    double depth_;   // of the image's plane [m]; 0: no draw() yet
};

SceneViewImpl::SceneViewImpl(const CameraModel& camera, Size size, const Drawable& drawable, bool window)
    : camera_(camera), size_(size), display_(drawable.display), window_(drawable.window), renderer_(vtkSmartPointer<vtkRenderer>::New()), inWindow_(window),
      placed_(false), depth_(0)
{
    window_->SetOffScreenRendering(!window);
    window_->SetMultiSamples(window ? 8 : 0);
    if (!window) window_->SetSwapBuffers(0);
    window_->SetSize(size.width, size.height);
    window_->SetWindowName("surgtrack");
    window_->AddRenderer(renderer_);
    renderer_->SetBackground(backgroundLow[2] / 255, backgroundLow[1] / 255, backgroundLow[0] / 255);
    renderer_->SetBackground2(backgroundHigh[2] / 255, backgroundHigh[1] / 255, backgroundHigh[0] / 255);
    renderer_->GradientBackgroundOn();
    renderer_->SetUseFXAA(!window);   // contexts without a window have no multisampling
}

SceneViewImpl::~SceneViewImpl()
{
    SavedGLContexts saved;
    Quiet quiet;
    window_->Finalize();
    renderer_ = 0;
    window_ = 0;
}

void SceneViewImpl::setViewpoint(const Point3d& viewer, const Point3d& centre)
{
    const Point3d d = centre - viewer;
    if (!(norm(d) > 1e-6 && norm(d) < 1e6)) CV_Error(Error::StsBadArg, "viewer and centre must be finite and different");
    vtkCamera* view = renderer_->GetActiveCamera();
    view->SetPosition(viewer.x, viewer.y, viewer.z);
    view->SetFocalPoint(centre.x, centre.y, centre.z);
    const bool vertical = std::abs(d.y) > 0.999 * norm(d);
    view->SetViewUp(0, vertical ? 0 : -1, vertical ? 1 : 0);
    placed_ = true;
}

const ModelMeshes& SceneViewImpl::meshesOf(const Ptr<ToolModel>& model)
{
    for (size_t i = 0; i < models_.size(); i++)
        if (models_[i].model == model) return models_[i];
    ModelMeshes added;
    added.model = model;
    for (size_t i = 0; i < model->meshes().size(); i++) added.meshes.push_back(toPolyData(model->meshes()[i]));
    models_.push_back(added);
    return models_.back();
}

void SceneViewImpl::addTool(const DrawnTool& tool)
{
    const ModelMeshes& shape = meshesOf(tool.model);
    std::vector<Matx44d> base_T_link;
    tool.model->forwardKinematics(tool.joints, base_T_link);
    for (size_t l = 0; l < tool.model->links().size(); l++)
    {
        const int mesh = tool.model->links()[l].mesh;
        if (mesh < 0) continue;
        vtkSmartPointer<vtkActor> actor = makeActor(shape.meshes[mesh], tool.color);
        actor->GetProperty()->SetOpacity(tool.opacity);
        actor->GetProperty()->SetAmbient(0.3);
        actor->GetProperty()->SetSpecular(0.25);
        actor->GetProperty()->SetSpecularPower(20);
        const Matx44d pose = tool.camera_T_base * base_T_link[l];
        vtkNew<vtkMatrix4x4> matrix;
        matrix->DeepCopy(pose.val);
        actor->SetUserMatrix(matrix);
        renderer_->AddActor(actor);
    }
}

// Where a pixel looks, in the plane of the image.
Point3d SceneViewImpl::onPlane(double u, double v) const
{
    Mat rays;
    camera_.unprojectPoints(Mat(Matx12d(u, v)), rays);
    const Point2d ray = rays.at<Point2d>(0);
    return Point3d(ray.x, ray.y, 1) * depth_;
}

void SceneViewImpl::addField()
{
    const double w = camera_.imageSize().width, h = camera_.imageSize().height;
    const Point2d corners[5] = {Point2d(-0.5, -0.5), Point2d(w - 0.5, -0.5), Point2d(w - 0.5, h - 0.5), Point2d(-0.5, h - 0.5), Point2d(-0.5, -0.5)};
    const int pieces = 16;   // of a side
    std::vector<Point3d> frame;
    for (int i = 0; i < 4; i++)
    {
        std::vector<Point3d> ray(1, Point3d());
        ray.push_back(onPlane(corners[i].x, corners[i].y));
        renderer_->AddActor(makePath(ray, fieldColor, 1.5f));
        for (int j = 0; j < pieces; j++)
        {
            const Point2d p = corners[i] + (corners[i + 1] - corners[i]) * (double(j) / pieces);
            frame.push_back(onPlane(p.x, p.y));
        }
    }
    frame.push_back(frame[0]);
    renderer_->AddActor(makePath(frame, fieldColor, 1.5f));
    for (int i = 0; i < 3; i++)
    {
        std::vector<Point3d> axis(2);
        (i == 0 ? axis[1].x : i == 1 ? axis[1].y : axis[1].z) = axisLength;
        renderer_->AddActor(makePath(axis, Scalar(i == 2 ? 255 : 0, i == 1 ? 200 : 0, i == 0 ? 255 : 0), 4));
    }
}

void SceneViewImpl::addImage(const Mat& image)
{
    Mat rgb;
    cvtColor(image, rgb, image.channels() == 3 ? COLOR_BGR2RGB : COLOR_GRAY2RGB);
    vtkNew<vtkImageData> data;
    data->SetDimensions(rgb.cols, rgb.rows, 1);
    data->AllocateScalars(VTK_UNSIGNED_CHAR, 3);
    for (int y = 0; y < rgb.rows; y++) std::memcpy(data->GetScalarPointer(0, y, 0), rgb.ptr(y), 3 * size_t(rgb.cols));
    vtkNew<vtkTexture> texture;
    texture->SetInputData(data);
    texture->InterpolateOn();

    const int columns = std::max(1, rgb.cols / gridStep), rows = std::max(1, rgb.rows / gridStep);
    vtkNew<vtkPoints> points;
    vtkNew<vtkFloatArray> texturePoints;
    texturePoints->SetNumberOfComponents(2);
    vtkNew<vtkCellArray> cells;
    for (int j = 0; j <= rows; j++)
        for (int i = 0; i <= columns; i++)
        {
            const double u = double(i) / columns, v = double(j) / rows;
            const Point3d p = onPlane(u * rgb.cols - 0.5, v * rgb.rows - 0.5);
            const vtkIdType at = points->InsertNextPoint(p.x, p.y, p.z);
            texturePoints->InsertNextTuple2(u, v);
            if (i == columns || j == rows) continue;
            const vtkIdType quad[4] = {at, at + 1, at + columns + 2, at + columns + 1};
            cells->InsertNextCell(4, quad);
        }
    vtkNew<vtkPolyData> plane;
    plane->SetPoints(points);
    plane->GetPointData()->SetTCoords(texturePoints);
    plane->SetPolys(cells);
    vtkSmartPointer<vtkActor> actor = makeActor(plane, Scalar::all(255));
    actor->SetTexture(texture);
    actor->GetProperty()->LightingOff();
    renderer_->AddActor(actor);
}

void SceneViewImpl::render(Mat& picture)
{
    window_->MakeCurrent();
    renderer_->ResetCameraClippingRange();
    window_->Render();
    vtkNew<vtkUnsignedCharArray> pixels;
    if (window_->GetPixelData(0, 0, size_.width - 1, size_.height - 1, 0, pixels, 0) != VTK_OK)
        CV_Error(Error::StsError, "OpenGL failed to draw or to read back");
    const Mat rgb(size_, CV_8UC3, pixels->GetPointer(0));
    flip(rgb, picture, 0);   // OpenGL's first row is the lowest
    cvtColor(picture, picture, COLOR_RGB2BGR);
}

void SceneViewImpl::draw(InputArray _image, const std::vector<DrawnTool>& tools, const std::vector<Mat>& paths, OutputArray picture)
{
    const Mat image = _image.getMat();
    if (!image.empty())
    {
        checkImage(image);
        CV_Assert(image.size() == camera_.imageSize() && "image must have the camera's size");
    }
    CV_CheckLE(paths.size(), tools.size(), "paths: one per tool at most");
    double farthest = 0;
    Point3d middle;
    for (size_t i = 0; i < tools.size(); i++)
    {
        if (!tools[i].model) CV_Error(Error::StsBadArg, format("tools[%d].model is empty", int(i)));
        if (!isRigid(tools[i].camera_T_base, 1e-2)) CV_Error(Error::StsBadArg, format("tools[%d].camera_T_base must be a rigid transform", int(i)));
        CV_Check(tools[i].opacity, tools[i].opacity >= 0 && tools[i].opacity <= 1, "opacity must be in 0..1");
        const Point3d end = transform(tools[i].camera_T_base * tools[i].model->endEffectorPose(tools[i].joints), Point3d());
        farthest = std::max(farthest, end.z);
        middle += end / double(tools.size());
    }
    if (depth_ == 0) depth_ = farthest > 0 ? planeBehind * farthest : defaultDepth;   // kept, so that a film does not wobble
    if (!placed_)
    {
        const Point3d at = farthest > 0 ? 0.55 * Point3d(0, 0, 0.5 * depth_) + 0.45 * middle : Point3d(0, 0, 0.5 * depth_);
        setViewpoint(at + Point3d(1.15, -0.8, -1.35) * depth_, at);
    }
    std::vector<Mat> lines;
    for (size_t i = 0; i < paths.size(); i++) lines.push_back(paths[i].empty() ? Mat() : asRows(paths[i], 3, "paths"));

    SavedGLContexts saved;   // what is removed lets go of its textures
    Quiet quiet;
    renderer_->RemoveAllViewProps();
    if (!image.empty()) addImage(image);
    addField();
    for (size_t i = 0; i < tools.size(); i++) addTool(tools[i]);
    for (size_t i = 0; i < lines.size(); i++)
    {
        std::vector<Point3d> line;
        for (int j = 0; j < lines[i].rows; j++) line.push_back(Point3d(lines[i].at<double>(j, 0), lines[i].at<double>(j, 1), lines[i].at<double>(j, 2)));
        if (line.size() > 1) renderer_->AddActor(makePath(line, tools[i].color * 0.7, 3));
    }
    Mat drawn;
    render(drawn);
    drawn.copyTo(picture);
}

bool SceneViewImpl::test()
{
    try
    {
        SavedGLContexts saved;
        Quiet quiet;
        window_->Initialize();
        window_->MakeCurrent();
        if (!window_->IsCurrent()) return false;
        int major = 0, minor = 0;
        window_->GetOpenGLVersion(major, minor);
        if (major * 10 + minor < 32) return false;
        Mat picture;
        render(picture);
        return norm(picture.row(size_.height - 1), Mat(1, size_.width, CV_8UC3, backgroundLow), NORM_INF) < 5;
    }
    catch (const cv::Exception&)
    {
        return false;
    }
}

void SceneViewImpl::show(double seconds)
{
    CV_Check(seconds, seconds >= 0 && seconds < 1e6, "seconds must not be negative");
    if (!inWindow_) CV_Error(Error::StsError, "there is no window: it is asked for when the view is created");
    SavedGLContexts saved;
    Quiet quiet;
    interact(window_, renderer_, seconds);
}

} // namespace

Ptr<SceneView> SceneView::create(const CameraModel& camera, Size size, bool window)
{
    CV_Assert(!camera.imageSize().empty());
    CV_Check(size.area(), size.width > 0 && size.height > 0 && size.width <= 8192 && size.height <= 8192, "size must be 1..8192");
    typedef Drawable (*Opener)(String&);
    const Opener openers[2] = {openXWindow, openEGLWindow};
    const char* const names[2] = {"X", "EGL"};
    String reasons;
    for (int i = 0; i < (window ? 1 : 2); i++)
    {
        String reason;
        Ptr<SceneViewImpl> view;
        XDisplayHolder::ErrorsIgnored ignored;
        {
            SavedGLContexts saved;
            Quiet quiet;
            const Drawable drawable = openers[i](reason);
            if (drawable.window) view = makePtr<SceneViewImpl>(camera, size, drawable, window);
        }
        if (view && view->test()) return view;
        if (view) reason = "OpenGL 3.2 does not work there";
        view.release();
        reasons += format("%s%s: %s", i ? "; " : "", names[i], reason.c_str());
    }
    CV_Error(Error::StsNotImplemented, (window ? "a window needs a display. " : "VTK can draw neither through an X server nor without one. ") + reasons);
}

}} // namespace cv::surgtrack
