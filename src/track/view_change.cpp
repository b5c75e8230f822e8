// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "base/geometry.hpp"
#include "track/view_change.hpp"

namespace cv { namespace surgtrack {

ViewChange viewChange(const CameraModel& camera, const ToolModel& model, const ToolView& now, const ToolView& then, const Rect2d* field)
{
    ViewChange change = {0, 0, 0};
    const ViewChange unknown = {DBL_MAX, DBL_MAX, DBL_MAX};
    const std::vector<ToolModel::Keypoint>& keypoints = model.keypoints();
    for (size_t k = 0; k < keypoints.size(); k++)
    {
        const Matx44d A = now.camera_T_base * now.base_T_link[keypoints[k].link], B = then.camera_T_base * then.base_T_link[keypoints[k].link];
        const Point3d p = transform(A, keypoints[k].linkPoint), q = transform(B, keypoints[k].linkPoint);
        if (field && (p.z < nearestDepth || !field->contains(Point2d(p.x / p.z, p.y / p.z)))) continue;
        if (p.z < nearestDepth || q.z < nearestDepth) return unknown;
        const double shift = std::max(camera.fx * std::abs(p.x / p.z - q.x / q.z), camera.fy * std::abs(p.y / p.z - q.y / q.z));
        if (!(shift < DBL_MAX)) return unknown;   // nor is what is not a number
        change.shift = std::max(change.shift, shift);
        change.turn = std::max(change.turn, turnBetween(A, B));
        change.zoom = std::max(change.zoom, std::abs(q.z / p.z - 1));
    }
    return change;
}

}} // namespace cv::surgtrack
