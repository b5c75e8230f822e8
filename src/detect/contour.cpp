// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include <map>
#include "opencv2/surgtrack/contour.hpp"
#include "base/geometry.hpp"
#include "render/tool_instances.hpp"

namespace cv { namespace surgtrack {

ContourPoint::ContourPoint() : link(-1), crease(false), found(false), offset(0), deviation(0), clipped(0), strength(0) {}

ToolContour::Params::Params() : spacing(5), maxPoints(200), creaseAngle(0) {}

namespace {

// The one or two triangles beside an edge.
struct EdgeFaces
{
    int first, second;   // second < 0: border
};

struct EdgeLine
{
    Point3f a, b;
    bool sharp;
};

struct MeshEdges
{
    std::vector<float> nx, ny, nz, d;   // planes of the triangles: n . p = d
    std::vector<EdgeFaces> faces;       // of each edge
    std::vector<EdgeLine> lines;
};

struct ByPosition
{
    bool operator()(const Point3f& p, const Point3f& q) const { return p.x != q.x ? p.x < q.x : p.y != q.y ? p.y < q.y : p.z < q.z; }
};

// Vertices are stored once per side of a crease: equal points are one here.
MeshEdges findEdges(const Mesh& mesh, double creaseAngle)
{
    MeshEdges result;
    std::map<Point3f, int, ByPosition> points;
    std::vector<int> point(mesh.vertices.size());
    for (size_t i = 0; i < mesh.vertices.size(); i++)
        point[i] = points.insert(std::make_pair(mesh.vertices[i], int(points.size()))).first->second;
    std::map<std::pair<int, int>, int> edgeOf;
    std::vector<int> count;   // of the triangles at an edge
    for (size_t i = 0; i < mesh.triangles.size(); i++)
    {
        const Vec3i& t = mesh.triangles[i];
        const Point3d p = mesh.vertices[t[0]], q = mesh.vertices[t[1]], r = mesh.vertices[t[2]];
        const Point3d normal = (q - p).cross(r - p);
        const double area = norm(normal);
        if (!(area > 1e-14)) continue;   // without extent; [m^2]
        const Point3d n = normal * (1 / area);
        const int face = int(result.nx.size());
        result.nx.push_back(float(n.x));
        result.ny.push_back(float(n.y));
        result.nz.push_back(float(n.z));
        result.d.push_back(float(n.dot(p)));
        for (int j = 0; j < 3; j++)
        {
            int a = point[t[j]], b = point[t[(j + 1) % 3]];
            if (a > b) std::swap(a, b);
            const std::pair<std::map<std::pair<int, int>, int>::iterator, bool> at =
                edgeOf.insert(std::make_pair(std::make_pair(a, b), int(result.lines.size())));
            if (at.second)
            {
                const EdgeFaces edge = {face, -1};
                const EdgeLine line = {mesh.vertices[t[j]], mesh.vertices[t[(j + 1) % 3]], false};
                result.faces.push_back(edge);
                result.lines.push_back(line);
                count.push_back(1);
                continue;
            }
            // Of more than two triangles that meet the first two make the edge.
            const int i2 = at.first->second;
            if (++count[i2] == 2) result.faces[i2].second = face;
        }
    }
    if (creaseAngle > 0)
        for (size_t i = 0; i < result.lines.size(); i++)
        {
            const int f = result.faces[i].first, g = result.faces[i].second;
            if (g < 0) continue;
            result.lines[i].sharp = result.nx[f] * result.nx[g] + result.ny[f] * result.ny[g] + result.nz[f] * result.nz[g] < std::cos(creaseAngle);
        }
    return result;
}

const double across = 0.8;          // so far from the edge the drawing tells what is on its sides [pixel]
const double depthSlack = 1e-3;    // [m]


// Whether nothing is drawn in the pixels just outside of an outline's point. Edges of the tool less than a pixel inside of its
// outline have background beside them too.
bool isOutermost(const Mat& ids, const Point2d& point, const Point2d& normal)
{
    const double least = 0.05, most = 1.2, aside = 1;   // of pixel centres, along the normal and across [pixel]
    const Point middle(cvRound(point.x), cvRound(point.y));
    for (int y = middle.y - 1; y <= middle.y + 1; y++)
        for (int x = middle.x - 1; x <= middle.x + 1; x++)
        {
            const Point2d d = Point2d(x, y) - point;
            const double out = d.dot(normal);
            if (ids.at<uchar>(y, x) && out > least && out < most && std::abs(d.cross(normal)) < aside) return false;
        }
    return true;
}

class ToolContourImpl CV_FINAL : public ToolContour
{
public:
    ToolContourImpl(const Ptr<ToolModel>& model, const Params& params) : model_(model), params_(params)
    {
        CV_Assert(model);
        CV_Check(params.spacing, params.spacing > 0 && params.spacing < DBL_MAX, "Params::spacing must be positive");
        CV_CheckGT(params.maxPoints, 0, "Params::maxPoints must be positive");
        CV_Check(params.creaseAngle, params.creaseAngle >= 0 && params.creaseAngle < CV_PI, "Params::creaseAngle must be in 0..pi");
        for (size_t i = 0; i < model->meshes().size(); i++) meshes_.push_back(findEdges(model->meshes()[i], params.creaseAngle));
    }

    void sample(const CameraModel& camera, const ToolView& view, const Rendering& rendering, int id,
                std::vector<ContourPoint>& points) CV_OVERRIDE;
    Ptr<ToolModel> model() const CV_OVERRIDE { return model_; }

private:
    struct Segment
    {
        Point3f a, b;     // ends in the link's frame
        Point3d p, q;     // ends in the camera frame
        int link;
        bool crease;
        double length;    // in the image [pixel]
    };

    void collect(const CameraModel& camera, const ToolView& view, const Rect2d& field);

    Ptr<ToolModel> model_;
    Params params_;
    std::vector<MeshEdges> meshes_;
    std::vector<uchar> facing_;
    std::vector<Segment> segments_;
};

// Cuts a segment to z >= nearestDepth and to the field of view.
bool clip(const Rect2d& field, Point3d& p, Point3d& q, Point3f& a, Point3f& b)
{
    double s = 0, t = 1;   // the part that is kept
    const double planes[5][4] = {{0, 0, 1, -nearestDepth}, {1, 0, -field.x, 0}, {-1, 0, field.x + field.width, 0}, {0, 1, -field.y, 0},
                                 {0, -1, field.y + field.height, 0}};
    for (int i = 0; i < 5; i++)
    {
        const double* n = planes[i];
        const double u = n[0] * p.x + n[1] * p.y + n[2] * p.z + n[3], v = n[0] * q.x + n[1] * q.y + n[2] * q.z + n[3];
        if (u < 0 && v < 0) return false;
        if (u < 0) s = std::max(s, u / (u - v));
        else if (v < 0) t = std::min(t, u / (u - v));
    }
    if (s >= t) return false;
    const Point3d d = q - p;
    const Point3f e = b - a;
    q = p + d * t;
    p = p + d * s;
    b = a + e * float(t);
    a = a + e * float(s);
    return true;
}

void ToolContourImpl::collect(const CameraModel& camera, const ToolView& view, const Rect2d& field)
{
    segments_.clear();
    const bool creases = params_.creaseAngle > 0;
    const std::vector<ToolModel::Link>& links = model_->links();
    for (size_t l = 0; l < links.size(); l++)
    {
        if (links[l].mesh < 0) continue;
        const MeshEdges& mesh = meshes_[links[l].mesh];
        const Matx44d camera_T_link = view.camera_T_base * view.base_T_link[l];
        const Point3d eye = transform(rigidInverse(camera_T_link), Point3d());
        const float ex = float(eye.x), ey = float(eye.y), ez = float(eye.z);
        const size_t faces = mesh.nx.size();
        facing_.resize(std::max(facing_.size(), faces));
        uchar* facing = facing_.data();
        for (size_t i = 0; i < faces; i++) facing[i] = mesh.nx[i] * ex + mesh.ny[i] * ey + mesh.nz[i] * ez > mesh.d[i];
        for (size_t i = 0; i < mesh.faces.size(); i++)
        {
            const EdgeFaces& f = mesh.faces[i];
            const bool outline = f.second < 0 || facing[f.first] != facing[f.second];
            if (!outline && !(creases && facing[f.first] && mesh.lines[i].sharp)) continue;
            const EdgeLine& e = mesh.lines[i];
            Segment s;
            s.a = e.a;
            s.b = e.b;
            s.p = transform(camera_T_link, e.a);
            s.q = transform(camera_T_link, e.b);
            if (!clip(field, s.p, s.q, s.a, s.b)) continue;
            s.link = int(l);
            s.crease = !outline;
            const double u = camera.fx * (s.p.x / s.p.z - s.q.x / s.q.z), v = camera.fy * (s.p.y / s.p.z - s.q.y / s.q.z);
            s.length = std::sqrt(u * u + v * v);
            segments_.push_back(s);
        }
    }
}

void ToolContourImpl::sample(const CameraModel& camera, const ToolView& view, const Rendering& rendering, int id,
                             std::vector<ContourPoint>& points)
{
    CV_CheckEQ(view.base_T_link.size(), model_->links().size(), "view: one pose per link");
    points.clear();
    const Rect& window = rendering.window;
    if (window.empty()) return;
    CV_Assert(rendering.ids.type() == CV_8UC1 && rendering.ids.size() == window.size() && "rendering.ids: CV_8UC1 of the window's size");
    CV_Assert(rendering.depth.type() == CV_32FC1 && rendering.depth.size() == window.size() && "rendering.depth: CV_32FC1 of the window's size");
    CV_Check(id, id >= 1 && id <= 255, "id must be 1..255");
    collect(camera, view, camera.fieldOfView(window));
    const Rect inside(1, 1, window.width - 2, window.height - 2);
    double spacing = params_.spacing, rest = spacing / 2;
    for (size_t i = 0; i < segments_.size(); i++)
    {
        const Segment& s = segments_[i];
        // The next point comes after `rest` pixels, wherever the segments begin.
        double at = rest;
        for (; at < s.length; at += spacing)
        {
            // linear in the image: 1 / z is
            const double u = at / s.length, w = (1 - u) / s.p.z + u / s.q.z, t = u / s.q.z / w;
            const Point3d p = s.p + (s.q - s.p) * t;
            Matx23d J;
            ContourPoint c;
            c.imagePoint = camera.project(p, &J);
            const Point3d d = s.q - s.p;
            const Point2d along(J(0, 0) * d.x + J(0, 1) * d.y + J(0, 2) * d.z, J(1, 0) * d.x + J(1, 1) * d.y + J(1, 2) * d.z);
            const double length = norm(along);
            if (!(length > 0)) continue;
            c.normal = Point2d(-along.y, along.x) * (1 / length);
            const Point2d local = c.imagePoint - Point2d(window.tl());
            const Point o(cvRound(local.x + across * c.normal.x), cvRound(local.y + across * c.normal.y));
            const Point n(cvRound(local.x - across * c.normal.x), cvRound(local.y - across * c.normal.y));
            if (!inside.contains(o) || !inside.contains(n)) continue;
            const int ido = rendering.ids.at<uchar>(o), idn = rendering.ids.at<uchar>(n);
            c.crease = s.crease;
            bool inwards = false;
            if (s.crease)
            {
                if (ido != id || idn != id) continue;
                if (p.z > rendering.depth.at<float>(o) + depthSlack || p.z > rendering.depth.at<float>(n) + depthSlack) continue;
            }
            else
            {
                if ((ido == 0) == (idn == 0)) continue;
                const bool flip = ido != 0;
                if ((flip ? ido : idn) != id) continue;
                if (flip) c.normal = -c.normal;
                inwards = flip;
                if (!isOutermost(rendering.ids, local, c.normal)) continue;
                if (p.z > rendering.depth.at<float>(flip ? o : n) + depthSlack * 3) continue;
            }
            c.link = s.link;
            const Point3d direction = s.b - s.a;
            c.linkPoint = Point3d(s.a) + direction * t;
            c.linkDirection = direction * ((inwards ? -1 : 1) / norm(direction));
            points.push_back(c);
        }
        rest = at - s.length;
    }
    if (int(points.size()) > params_.maxPoints)
    {
        const size_t n = points.size(), m = params_.maxPoints;
        for (size_t i = 0; i < m; i++) points[i] = points[i * n / m];
        points.resize(m);
    }
}

} // namespace

void placeContour(const CameraModel& camera, const ToolView& view, std::vector<ContourPoint>& points)
{
    size_t kept = 0;
    int link = INT_MIN;
    Matx44d camera_T_link;
    for (size_t i = 0; i < points.size(); i++)
    {
        ContourPoint c = points[i];
        if (c.link != link)
        {
            link = c.link;
            CV_Check(link, link >= 0 && link < int(view.base_T_link.size()), "points: of another tool, no such link");
            camera_T_link = view.camera_T_base * view.base_T_link[link];
        }
        const Point3d p = transform(camera_T_link, c.linkPoint);
        if (p.z < nearestDepth) continue;
        const Point3d d = transform(camera_T_link, c.linkPoint + c.linkDirection) - p;
        Matx23d J;
        c.imagePoint = camera.project(p, &J);
        const Point2d along(J(0, 0) * d.x + J(0, 1) * d.y + J(0, 2) * d.z, J(1, 0) * d.x + J(1, 1) * d.y + J(1, 2) * d.z);
        const double length = norm(along);
        if (!(length > 0)) continue;
        c.normal = Point2d(-along.y, along.x) * (1 / length);
        points[kept++] = c;
    }
    points.resize(kept);
}

std::vector<ContourPoint> ToolContour::sampleTool(const CameraModel& camera, const Matx44d& camera_T_base, InputArray joints)
{
    ToolView view;
    view.camera_T_base = camera_T_base;
    model()->forwardKinematics(joints, view.base_T_link);
    Ptr<MeshRenderer> renderer = MeshRenderer::createSoftware();
    std::vector<MeshInstance> instances;
    addInstances(*model(), renderer->addTool(model()), camera_T_base, view.base_T_link, 1, false, instances);
    Rendering rendering;
    renderer->render(camera, Rect(Point(), camera.imageSize()), instances, rendering);
    std::vector<ContourPoint> points;
    sample(camera, view, rendering, 1, points);
    return points;
}

Ptr<ToolContour> ToolContour::create(const Ptr<ToolModel>& model, const Params& params)
{
    return makePtr<ToolContourImpl>(model, params);
}

}} // namespace cv::surgtrack
