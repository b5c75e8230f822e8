// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "vtk/camera_rays.hpp"

namespace cv { namespace surgtrack {

static const double oversampling = 1.5;     // of the image without distortion: its samples are then at most 1/3 pixel off
static const int maxDrawingSize = 4096;     // [pixel] of that image; every OpenGL 3.2 can
static const size_t maxCachedCameras = 4;

const Mat_<Vec2f>& CameraRays::of(const CameraModel& camera)
{
    Kept wanted;
    const double intrinsics[4] = {camera.fx, camera.fy, camera.cx, camera.cy};
    std::copy(intrinsics, intrinsics + 4, wanted.intrinsics);
    std::copy(camera.k, camera.k + 12, wanted.intrinsics + 4);
    wanted.size = camera.imageSize();
    for (size_t i = 0; i < cameras_.size(); i++)
        if (cameras_[i].size == wanted.size && std::equal(wanted.intrinsics, wanted.intrinsics + 16, cameras_[i].intrinsics)) return cameras_[i].rays;

    Mat_<Vec2d> pixels(wanted.size.area(), 1);
    for (int i = 0; i < pixels.rows; i++) pixels(i) = Vec2d(i % wanted.size.width, i / wanted.size.width);
    Mat rays;
    camera.unprojectPoints(pixels, rays);
    rays.reshape(2, wanted.size.height).convertTo(wanted.rays, CV_32F);
    if (cameras_.size() == maxCachedCameras) cameras_.erase(cameras_.begin());
    cameras_.push_back(wanted);
    return cameras_.back().rays;
}

Pinhole enclose(const CameraModel& camera, const Mat_<Vec2f>& rays)
{
    Vec2f lo(FLT_MAX, FLT_MAX), hi = -lo;
    for (int y = 0; y < rays.rows; y++)
        for (int x = 0; x < rays.cols; x++)
        {
            const Vec2f& ray = rays(y, x);
            lo = Vec2f(std::min(lo[0], ray[0]), std::min(lo[1], ray[1]));
            hi = Vec2f(std::max(hi[0], ray[0]), std::max(hi[1], ray[1]));
        }
    Pinhole p;
    p.fx = std::min(oversampling * camera.fx, (maxDrawingSize - 2) / std::max<double>(hi[0] - lo[0], 1e-9));
    p.fy = std::min(oversampling * camera.fy, (maxDrawingSize - 2) / std::max<double>(hi[1] - lo[1], 1e-9));
    p.cx = -lo[0] * p.fx;
    p.cy = -lo[1] * p.fy;
    p.width = cvRound((hi[0] - lo[0]) * p.fx) + 1;
    p.height = cvRound((hi[1] - lo[1]) * p.fy) + 1;
    return p;
}

}} // namespace cv::surgtrack
