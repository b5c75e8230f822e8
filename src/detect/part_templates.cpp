// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/surgtrack/part_templates.hpp"
#include "base/geometry.hpp"
#include "base/memory.hpp"
#include "detect/qgo.hpp"
#include "render/box_window.hpp"
#include "render/tool_instances.hpp"

namespace cv { namespace surgtrack {

PartTemplate::PartTemplate() : tool(0), part(0) {}

Mat PartTemplate::getFeatures() const
{
    Mat_<int> m(int(features.size()), 3);
    for (int i = 0; i < m.rows; i++)
    {
        m(i, 0) = features[i].x;
        m(i, 1) = features[i].y;
        m(i, 2) = features[i].bin;
    }
    return m;
}

PartTemplateRenderer::Params::Params()
    : boxSize(0.011), minFeatures(30), maxFeatures(250), magnitudeThreshold(80), depthSlack(0.001), wholeTool(false), tipDepthSlack(0.003)
{
}

namespace {

inline bool isZero8(const uchar* p)
{
    int64 eight;
    std::memcpy(&eight, p, 8);
    return eight == 0;
}

inline uchar bitIndex(int oneBit)
{
    return uchar((oneBit & 0xf0 ? 4 : 0) + (oneBit & 0xcc ? 2 : 0) + (oneBit & 0xaa ? 1 : 0));
}

// Some light from everywhere, as tissue reflects it, and a background that outlines stand out from.
const double ambient = 0.15;
const uchar background = 80;

class PartTemplateRendererImpl CV_FINAL : public PartTemplateRenderer
{
public:
    PartTemplateRendererImpl(const Ptr<MeshRenderer>& renderer, const Params& params)
        : renderer_(renderer ? renderer : MeshRenderer::createSoftware()), params_(params)
    {
        CV_Check(params.boxSize, params.boxSize > 0 && params.boxSize <= 1, "Params::boxSize must be positive and at most 1 m");
        CV_CheckGT(params.maxFeatures, 0, "Params::maxFeatures must be positive");
        params_.maxFeatures = std::min(params.maxFeatures, 65535 / 4);   // a matcher takes no more
        CV_Check(params.magnitudeThreshold, params.magnitudeThreshold >= 0 && params.magnitudeThreshold < 1e4, "Params::magnitudeThreshold must be in 0..10000");
        CV_Check(params.depthSlack, std::abs(params.depthSlack) < DBL_MAX, "Params::depthSlack must be finite");
        CV_Check(params.tipDepthSlack, std::abs(params.tipDepthSlack) < DBL_MAX, "Params::tipDepthSlack must be finite");
    }

    int addTool(const Ptr<ToolModel>& model) CV_OVERRIDE;
    void render(const CameraModel& camera, const std::vector<ToolView>& views, int tool, std::vector<PartTemplate>& templates, double scale,
                double rotation) CV_OVERRIDE;
    Ptr<ToolModel> model(int tool) const CV_OVERRIDE
    {
        CV_Check(tool, tool >= 0 && tool < int(tools_.size()), "no such tool: addTool() comes first");
        return tools_[tool].model;
    }
    const Rendering& rendering() const CV_OVERRIDE { return rendering_; }
    void swapRendering(Rendering& other) CV_OVERRIDE { std::swap(rendering_, other); }

private:
    struct Tool
    {
        Ptr<ToolModel> model;
        int firstMesh;
        std::vector<uchar> isTip;   // a keypoint: on a link that carries no other
        std::vector<MeshBox> boxes;
    };

    Rect toolWindow(const CameraModel& camera, const Rect2d& field, int tool) const;
    void placeInstances(const std::vector<ToolView>& views, int tool, const Matx44d& moved);
    void light();
    void cut(PartTemplate& t, const Size2d& box, int id);
    void keepVisible(const CameraModel& camera, int tool, size_t parts, std::vector<PartTemplate>& templates);

    Ptr<MeshRenderer> renderer_;
    Params params_;
    std::vector<Tool> tools_;
    std::vector<MeshInstance> instances_;
    std::vector<Rect> boxes_;
    Rendering rendering_;
    Rect window_;             // of the parts
    Mat depth_, ids_, shading_;   // the drawing there
    Mat picture_, orientations_;
    std::vector<uchar> pictureMemory_, orientationMemory_, workspace_;
    std::vector<PartTemplate> parts_;      // in the image, of one render()
    std::vector<TemplateFeature> found_;   // of one cut()
    std::vector<std::vector<TemplateFeature> > spare_;   // memory of templates that are no more
};

int PartTemplateRendererImpl::addTool(const Ptr<ToolModel>& model)
{
    CV_Assert(model);
    CV_CheckLT(tools_.size(), size_t(255), "too many tools");
    Tool tool;
    tool.model = model;
    tool.firstMesh = renderer_->addTool(model);
    const std::vector<ToolModel::Keypoint>& keypoints = model->keypoints();
    for (size_t i = 0; i < keypoints.size(); i++) tool.isTip.push_back(isTip(*model, keypoints[i].link));
    for (size_t i = 0; i < model->meshes().size(); i++) tool.boxes.push_back(boxAbout(model->meshes()[i]));
    tools_.push_back(tool);
    return int(tools_.size()) - 1;
}

// A window of the image that holds all that is seen of a tool: of the boxes about its meshes.
Rect PartTemplateRendererImpl::toolWindow(const CameraModel& camera, const Rect2d& field, int index) const
{
    const Tool& tool = tools_[index];
    BoxWindow window;
    for (size_t i = 0; i < instances_.size(); i++)
        if (instances_[i].id == index + 1) window.add(instances_[i].camera_T_mesh, tool.boxes[instances_[i].mesh - tool.firstMesh]);
    return window.get(camera, field);
}

// All meshes of all tools, the wanted one moved; a tool's number plus one is the id of its meshes.
void PartTemplateRendererImpl::placeInstances(const std::vector<ToolView>& views, int tool, const Matx44d& moved)
{
    instances_.clear();
    for (size_t t = 0; t < tools_.size(); t++)
    {
        if (views[t].base_T_link.empty()) continue;
        const Matx44d camera_T_base = int(t) == tool ? moved * views[t].camera_T_base : views[t].camera_T_base;
        addInstances(*tools_[t].model, tools_[t].firstMesh, camera_T_base, views[t].base_T_link, int(t) + 1, false, instances_);
    }
}

// Turns by angle about the ray through centre, and moves along it until the tool looks scale times as large.
Matx44d hypothesis(const Point3d& centre, double scale, double angle)
{
    return rigidTransform(rotationAbout(centre * (1 / norm(centre)), angle), centre * (1 / scale - 1));
}

void PartTemplateRendererImpl::light()
{
    picture_ = keptImage(pictureMemory_, window_.size());
    const int scale = cvRound((1 - ambient) * 65536), offset = cvRound((255 * ambient + 0.5) * 65536), width = picture_.cols;
    for (int y = 0; y < picture_.rows; y++)
    {
        const uchar *shading = shading_.ptr(y), *ids = ids_.ptr(y);
        uchar* picture = picture_.ptr(y);
        for (int x = 0; x < width; x++)
        {
            const uchar lit = uchar((shading[x] * scale + offset) >> 16);
            picture[x] = ids[x] ? lit : background;
        }
    }
}

// Features on the tool's pixels and the one pixel around them, thinned evenly to maxFeatures.
void PartTemplateRendererImpl::cut(PartTemplate& t, const Size2d& box, int id)
{
    const Point at = t.anchor - window_.tl();
    const int hx = cvRound(box.width / 2), hy = cvRound(box.height / 2);
    const Rect inner = Rect(1, 1, window_.width - 2, window_.height - 2);
    const Rect area = Rect(at.x - hx, at.y - hy, 2 * hx + 1, 2 * hy + 1) & inner;
    found_.resize(roomFor(area.area() + 1, found_.size()));
    TemplateFeature* const first = &found_[0];
    TemplateFeature* next = first;
    for (int y = area.y; y < area.y + area.height; y++)
    {
        const uchar* bits = orientations_.ptr(y);
        const uchar *above = ids_.ptr(y - 1), *ids = ids_.ptr(y), *below = ids_.ptr(y + 1);
        for (int x = area.x, end = area.x + area.width; x < end; x++)
        {
            while (x + 8 <= end && isZero8(bits + x)) x += 8;
            if (x >= end) break;
            if (!bits[x] || (ids[x] != id && ids[x - 1] != id && ids[x + 1] != id && above[x] != id && below[x] != id)) continue;
            next->x = short(x - at.x);
            next->y = short(y - at.y);
            next->bin = bitIndex(bits[x]);
            next++;
        }
    }
    const size_t found = next - first, n = std::min(found, size_t(params_.maxFeatures));
    t.features.reserve(params_.maxFeatures);
    t.features.resize(n);
    for (size_t i = 0; i < n; i++) t.features[i] = found_[i * found / n];

    int left = 0, right = 0, top = 0, bottom = 0;
    for (size_t i = 0; i < n; i++)
    {
        left = std::min(left, int(t.features[i].x));
        right = std::max(right, int(t.features[i].x));
        top = std::min(top, int(t.features[i].y));
        bottom = std::max(bottom, int(t.features[i].y));
    }
    t.bounds = Rect(left, top, right - left + 1, bottom - top + 1);
}

void PartTemplateRendererImpl::render(const CameraModel& camera, const std::vector<ToolView>& views, int tool,
                                      std::vector<PartTemplate>& templates, double scale, double rotation)
{
    CV_CheckEQ(views.size(), tools_.size(), "views: one per tool");
    CV_Check(tool, tool >= 0 && tool < int(tools_.size()), "no such tool");
    CV_Check(scale, scale > 0 && scale < DBL_MAX, "scale must be positive");
    CV_Check(rotation, std::abs(rotation) < DBL_MAX, "rotation must be finite");
    for (size_t i = 0; i < views.size(); i++)
    {
        if (int(i) != tool && views[i].base_T_link.empty()) continue;
        if (!isRigid(views[i].camera_T_base, 1e-2)) CV_Error(Error::StsBadArg, format("views[%d].camera_T_base must be a rigid transform", int(i)));
        CV_CheckEQ(views[i].base_T_link.size(), tools_[i].model->links().size(), "a view needs one pose per link");
    }
    const Tool& own = tools_[tool];
    const ToolView& view = views[tool];
    const std::vector<ToolModel::Keypoint>& keypoints = own.model->keypoints();
    const Rect image(Point(), camera.imageSize());

    Point3d centre;
    for (size_t i = 0; i < keypoints.size(); i++)
        centre += transform(view.camera_T_base * view.base_T_link[keypoints[i].link], keypoints[i].linkPoint) / double(keypoints.size());
    Matx44d moved = Matx44d::eye();
    if (scale != 1 || rotation != 0) moved = hypothesis(centre, scale, rotation);
    const Matx44d camera_T_base = moved * view.camera_T_base;

    // Keypoints in the image, and the window that holds their boxes.
    const Rect2d field = camera.fieldOfView(image);
    size_t parts = 0;
    Rect window;
    boxes_.clear();
    for (size_t i = 0; i < keypoints.size(); i++)
    {
        if (parts == parts_.size()) parts_.push_back(PartTemplate());
        PartTemplate& t = parts_[parts];
        t.tool = tool;
        t.part = int(i);
        t.viewPoint = transform(camera_T_base * view.base_T_link[keypoints[i].link], keypoints[i].linkPoint);
        // Far outside the field of view a lens model may fold points back into the image.
        if (t.viewPoint.z < nearestDepth || !field.contains(Point2d(t.viewPoint.x, t.viewPoint.y) * (1 / t.viewPoint.z))) continue;
        t.imagePoint = camera.project(t.viewPoint);
        t.anchor = Point(cvRound(t.imagePoint.x), cvRound(t.imagePoint.y));
        if (!image.contains(t.anchor)) continue;
        const int hx = cvCeil(params_.boxSize * camera.fx / t.viewPoint.z / 2) + 6, hy = cvCeil(params_.boxSize * camera.fy / t.viewPoint.z / 2) + 6;
        const Rect box = Rect(t.anchor.x - hx, t.anchor.y - hy, 2 * hx + 1, 2 * hy + 1) & image;
        window = window.empty() ? box : window | box;
        boxes_.push_back(box);
        parts++;
    }
    placeInstances(views, tool, moved);
    Rect drawn = window;
    if (params_.wholeTool)
    {
        drawn = toolWindow(camera, field, tool);
        drawn = drawn.empty() ? window : window.empty() ? drawn : drawn | window;
        boxes_.clear();
    }
    rendering_.window = Rect();
    if (!drawn.empty()) renderer_->render(camera, drawn, instances_, rendering_, boxes_);
    if (parts == 0)
    {
        templates.clear();
        return;
    }
    window_ = window;
    const Rect inside = window - drawn.tl();
    depth_ = rendering_.depth(inside);
    ids_ = rendering_.ids(inside);
    shading_ = rendering_.shading(inside);
    light();
    orientations_ = keptImage(orientationMemory_, window.size());
    quantize(picture_, Rect(Point(), picture_.size()), leastStrength(params_.magnitudeThreshold), orientations_, workspace_);

    keepVisible(camera, tool, parts, templates);
}

// Cuts the templates of the parts that are seen; the caller's of the frame before lend their memory: features are swapped, not copied.
void PartTemplateRendererImpl::keepVisible(const CameraModel& camera, int tool, size_t parts, std::vector<PartTemplate>& templates)
{
    const Tool& own = tools_[tool];
    size_t kept = 0;
    for (size_t i = 0; i < parts; i++)
    {
        PartTemplate& t = parts_[i];
        const double slack = own.isTip[t.part] ? params_.tipDepthSlack : params_.depthSlack;
        // Its neighbours too: keypoints on an outline project beside it as often as on it.
        if (!isVisible(depth_, ids_, t.anchor - window_.tl(), 1, t.viewPoint.z, tool + 1, slack)) continue;
        cut(t, Size2d(params_.boxSize * camera.fx / t.viewPoint.z, params_.boxSize * camera.fy / t.viewPoint.z), tool + 1);
        if (int(t.features.size()) < params_.minFeatures) continue;
        if (kept == templates.size())
        {
            templates.push_back(PartTemplate());
            if (!spare_.empty())
            {
                templates.back().features.swap(spare_.back());
                spare_.pop_back();
            }
        }
        std::swap(templates[kept++], t);
    }
    while (templates.size() > kept)
    {
        spare_.push_back(std::vector<TemplateFeature>());
        spare_.back().swap(templates.back().features);
        templates.pop_back();
    }
}

} // namespace

std::vector<PartTemplate> PartTemplateRenderer::renderTool(const CameraModel& camera, const Matx44d& camera_T_base, InputArray joints,
                                                           double scale, double rotation)
{
    std::vector<ToolView> views(1);
    views[0].camera_T_base = camera_T_base;
    model(0)->forwardKinematics(joints, views[0].base_T_link);
    std::vector<PartTemplate> templates;
    render(camera, views, 0, templates, scale, rotation);
    return templates;
}

Rendering PartTemplateRenderer::copyRendering() const
{
    const Rendering& last = rendering();
    Rendering copy;
    copy.window = last.window;
    copy.depth = last.depth.clone();
    copy.ids = last.ids.clone();
    copy.shading = last.shading.clone();
    return copy;
}

Ptr<PartTemplateRenderer> PartTemplateRenderer::create(const Ptr<MeshRenderer>& renderer, const Params& params)
{
    return makePtr<PartTemplateRendererImpl>(renderer, params);
}

}} // namespace cv::surgtrack
