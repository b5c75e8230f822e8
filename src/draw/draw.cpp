// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/surgtrack/draw.hpp"
#include "base/geometry.hpp"
#include "render/tool_instances.hpp"

namespace cv { namespace surgtrack {

void drawSkeleton(InputOutputArray _image, const CameraModel& camera, const Ptr<ToolModel>& model, InputArray joints,
                  const Matx44d& camera_T_base, const Scalar& color)
{
    CV_Assert(model);
    Mat image = _image.getMat();
    CV_CheckTypeEQ(image.type(), CV_8UC3, "image must be BGR");
    const int thickness = std::max(1, image.cols / 500);
    std::vector<Matx44d> base_T_link;
    model->forwardKinematics(joints, base_T_link);
    struct Pen
    {
        Mat& image;
        const CameraModel& camera;
        const Scalar& color;
        int thickness;
        Point at(const Point3d& p) const { const Point2d u = camera.project(p); return Point(cvRound(u.x), cvRound(u.y)); }
        // In short pieces, because lenses bend lines and the shaft reaches behind the camera.
        void line3d(const Point3d& a, const Point3d& b) const
        {
            const int pieces = 1 + int(norm(b - a) / 0.005);
            for (int i = 0; i < pieces; i++)
            {
                const Point3d p = a + (b - a) * (double(i) / pieces), q = a + (b - a) * (double(i + 1) / pieces);
                if (p.z < 0.01 || q.z < 0.01) continue;
                const Point u = at(p), v = at(q);
                if (std::abs(u.x) < 10000 && std::abs(u.y) < 10000 && std::abs(v.x) < 10000 && std::abs(v.y) < 10000)
                    line(image, u, v, color, thickness, LINE_AA);
            }
        }
    } pen = {image, camera, color, thickness};

    const std::vector<ToolModel::Link>& links = model->links();
    for (size_t i = 0; i < links.size(); i++)
    {
        if (links[i].parent < 0) continue;
        const Point3d from = transform(camera_T_base * base_T_link[links[i].parent], Point3d()), to = transform(camera_T_base * base_T_link[i], Point3d());
        pen.line3d(from, to);
    }
    const std::vector<ToolModel::Keypoint>& keypoints = model->keypoints();
    for (size_t i = 0; i < keypoints.size(); i++)
    {
        const Matx44d camera_T_link = camera_T_base * base_T_link[keypoints[i].link];
        const Point3d p = transform(camera_T_link, keypoints[i].linkPoint);
        // Keypoints on leaf links are tips: the jaws are drawn as lines from their axis.
        if (isTip(*model, keypoints[i].link)) pen.line3d(transform(camera_T_link, Point3d()), p);
        if (p.z > 0.01) circle(image, pen.at(p), 2 * thickness, color, FILLED, LINE_AA);
    }
}

}} // namespace cv::surgtrack
