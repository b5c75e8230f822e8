// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include <set>
#include "opencv2/imgproc.hpp"
#include "opencv2/surgtrack/draw.hpp"
#include "opencv2/surgtrack/tool_setup.hpp"
#include "base/geometry.hpp"
#include "lab/tool/tool_motion.hpp"
#include "render/tool_instances.hpp"

namespace cv { namespace surgtrack {

namespace {

const int CELL = 320, HIGH = 230, HEAD = 52, LINE = 17, COLUMNS = 6, ROWS = 3, STRIP = 26;   // [pixel]
const Scalar INK(40, 40, 40), PALE(150, 150, 150), PAPER(245, 245, 245);

void write(Mat& sheet, const String& text, Point at, const Scalar& color = INK, double size = 0.42)
{
    putText(sheet, text, at, FONT_HERSHEY_SIMPLEX, size, color, 1, LINE_AA);
}

class ToolSheet
{
public:
    explicit ToolSheet(const Ptr<ToolModel>& model)
        : model_(model), motion_(*model), renderer_(MeshRenderer::createSoftware()), distance_(0.3)
    {
        // What lies beyond the shaft fits into the cell at all settings, 12 mm of shaft with it.
        double along = motion_.reach + 0.012, across = 0;
        const std::vector<int> depth = motion_.wristDepth(*model);
        for (int row = 0; row < ROWS; row++)
        {
            std::vector<Matx44d> base_T_link;
            model->forwardKinematics(setting(row), base_T_link);
            for (size_t i = 0; i < depth.size(); i++)
            {
                const int mesh = model->links()[i].mesh;
                for (size_t k = 0; depth[i] > 0 && mesh >= 0 && k < model->meshes()[mesh].vertices.size(); k++)
                {
                    const Vec3d v(transform(base_T_link[i], Point3d(model->meshes()[mesh].vertices[k])) - motion_.centre);
                    along = std::max(along, v.dot(motion_.shaft));
                    across = std::max(across, norm(v.cross(motion_.shaft)));
                }
            }
        }
        const double focal = distance_ * std::min(0.47 * CELL / along, 0.47 * HIGH / std::max(across, 1e-3)), middle = (CELL - 1) / 2.;
        camera_ = CameraModel(Matx33d(focal, 0, middle, 0, focal, (HIGH - 1) / 2., 0, 0, 1), noArray(), Size(CELL, HIGH));
        pixelsPerMetre_ = focal / distance_;
    }

    Mat draw()
    {
        const int perColumn = ((int)model_->keypoints().size() + 5) / 6;
        sheet_ = Mat(HEAD + ROWS * (HIGH + STRIP) + (perColumn + 1) * LINE + 8, COLUMNS * CELL, CV_8UC3, PAPER);
        drawHead();
        for (int row = 0; row < ROWS; row++)
            drawRow(row);
        for (int i = 0; i < (int)model_->keypoints().size(); i++)
        {
            const ToolModel::Keypoint& k = model_->keypoints()[i];
            const Point at(i / perColumn * CELL + 6, HEAD + ROWS * (HIGH + STRIP) + (i % perColumn + 1) * LINE);
            write(sheet_, format("%d %s", i + 1, k.name.c_str()) + (k.score >= 0 ? format(" %.2f", k.score) : String()), at, INK, 0.38);
        }
        return sheet_;
    }

private:
    static Viewpoint side(int column, double distance)
    {
        static const double azimuths[] = { 0, 90, 180, 270, 0, 90 }, elevations[] = { 85, 85, 85, 85, 35, 145 };
        const Viewpoint view = { azimuths[column] * CV_PI / 180, elevations[column] * CV_PI / 180, distance };
        return view;
    }

    void drawHead()
    {
        static const char* const sides[] = { "side 0", "side 90", "side 180", "side 270", "from behind", "from the front" };
        size_t triangles = 0;
        for (size_t i = 0; i < model_->meshes().size(); i++)
            triangles += model_->meshes()[i].triangles.size();
        write(sheet_, model_->name() + format(": %d links, %d coordinates, %d meshes, %d triangles, %d keypoints", (int)model_->links().size(),
              (int)model_->coordinateNames().size(), (int)model_->meshes().size(), (int)triangles, (int)model_->keypoints().size()), Point(6, 20), INK, 0.55);
        for (int c = 0; c < COLUMNS; c++)
            write(sheet_, sides[c], Point(c * CELL + 6, HEAD - 8), PALE);
        const int right = COLUMNS * CELL - 10, left = right - cvRound(0.01 * pixelsPerMetre_);
        line(sheet_, Point(left, 24), Point(right, 24), INK, 2);
        write(sheet_, "10 mm", Point(right - 44, 18));
        write(sheet_, "end effector x", Point(left - 330, 20), Scalar(0, 0, 200));
        write(sheet_, "y", Point(left - 220, 20), Scalar(0, 140, 0));
        write(sheet_, "z", Point(left - 200, 20), Scalar(200, 0, 0));
        write(sheet_, "joint axes", Point(left - 170, 20), Scalar(160, 0, 160));
    }

    //! At rest; bent and open; bent the other way and half open.
    std::vector<double> setting(int row) const
    {
        std::vector<double> joints = motion_.rest;
        for (size_t c = 0; c < joints.size(); c++)
        {
            const double low = motion_.low[c], high = motion_.high[c];
            if (row && motion_.role[c] == ToolMotion::WRIST)
                joints[c] = row == 1 ? high : low;
            if (row && motion_.role[c] == ToolMotion::JAW)
                joints[c] = row == 1 ? high : 0.5 * (low + high);
        }
        return joints;
    }

    void drawRow(int row)
    {
        const std::vector<double> joints = setting(row);
        const int top = HEAD + row * (HIGH + STRIP);
        String text;
        for (size_t c = 0; c < joints.size(); c++)
            text += format("%s%s = %.3g", c ? ",  " : "", model_->coordinateNames()[c].c_str(), joints[c]);
        line(sheet_, Point(0, top), Point(sheet_.cols, top), PALE);
        write(sheet_, text, Point(6, top + 17));
        std::vector<Matx44d> base_T_link;
        model_->forwardKinematics(joints, base_T_link);
        for (int column = 0; column < COLUMNS; column++)
        {
            Mat cell = sheet_(Rect(column * CELL, top + STRIP, CELL, HIGH));
            const Matx44d camera_T_base = side(column, distance_).camera_T_base(motion_);
            if (!model_->meshes().empty())
                drawTool(cell, camera_, model_, joints, camera_T_base, Scalar(215, 205, 195), 1, renderer_);
            drawAxes(cell, camera_T_base, base_T_link, row == 0);
            drawKeypoints(cell, camera_T_base, joints, base_T_link);
        }
    }

    Point pixel(const Matx44d& camera_T_base, const Point3d& basePoint) const
    {
        const Point2d p = camera_.project(transform(camera_T_base, basePoint));
        return Point(cvRound(p.x), cvRound(p.y));
    }

    void drawAxes(Mat& cell, const Matx44d& camera_T_base, const std::vector<Matx44d>& base_T_link, bool named)
    {
        const double length = 0.007;   // of the lines [m]
        std::set<int> labelled;
        for (size_t i = 0; i < base_T_link.size(); i++)
        {
            const ToolModel::Link& link = model_->links()[i];
            const Matx44d& T = base_T_link[i];
            const Point3d at(T(0, 3), T(1, 3), T(2, 3)), z(T(0, 2), T(1, 2), T(2, 2));
            if (link.coordinate < 0 || motion_.role[link.coordinate] == ToolMotion::ARM || norm(at - motion_.centre) > motion_.reach + 0.012)
                continue;
            const Point end = pixel(camera_T_base, at + z * length), start = pixel(camera_T_base, at - z * length);
            line(cell, start, end, Scalar(160, 0, 160), 1, LINE_AA);
            // Names at the far ends of axes that are seen from the side; wrist and jaws often share one.
            const bool fromSide = norm(end - start) > 0.7 * 2 * length * pixelsPerMetre_;
            if (named && fromSide && labelled.insert(link.coordinate).second)
                write(cell, model_->coordinateNames()[link.coordinate], (motion_.role[link.coordinate] == ToolMotion::JAW ? start : end) + Point(3, 3),
                      Scalar(160, 0, 160), 0.33);
        }
        const Matx44d T = model_->endEffectorFromLinks(base_T_link);
        const Point3d at(T(0, 3), T(1, 3), T(2, 3));
        for (int k = 0; k < 3; k++)
            arrowedLine(cell, pixel(camera_T_base, at), pixel(camera_T_base, at + Point3d(T(0, k), T(1, k), T(2, k)) * (0.7 * length)),
                        k == 0 ? Scalar(0, 0, 200) : k == 1 ? Scalar(0, 140, 0) : Scalar(200, 0, 0), 1, LINE_AA);
    }

    //! Filled where they are seen.
    void drawKeypoints(Mat& cell, const Matx44d& camera_T_base, const std::vector<double>& joints, const std::vector<Matx44d>& base_T_link)
    {
        Mat depth, ids, shading;
        if (!model_->meshes().empty())
            renderer_->renderTool(model_, joints, camera_T_base, camera_, depth, ids, shading);
        for (int i = 0; i < (int)model_->keypoints().size(); i++)
        {
            const ToolModel::Keypoint& k = model_->keypoints()[i];
            const Point3d basePoint = transform(base_T_link[k.link], k.linkPoint);
            const Point at = pixel(camera_T_base, basePoint);
            const bool seen = !depth.empty() && isVisible(depth, ids, at, 1, transform(camera_T_base, basePoint).z, std::min(k.link + 1, 255), 0.0005);
            circle(cell, at, seen ? 3 : 2, seen ? partColor(i) : PALE, seen ? FILLED : 1, LINE_AA);
            if (seen)
                write(cell, format("%d", i + 1), at + Point(4, -2), INK, 0.33);
        }
    }

    Ptr<ToolModel> model_;
    ToolMotion motion_;
    Ptr<MeshRenderer> renderer_;
    double distance_, pixelsPerMetre_;
    CameraModel camera_;
    Mat sheet_;
};

} // namespace

void drawToolSheet(const Ptr<ToolModel>& model, OutputArray sheet)
{
    CV_Assert(model);
    ToolSheet(model).draw().copyTo(sheet);
}

}} // namespace cv::surgtrack
