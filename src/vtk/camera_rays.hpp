// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_VTK_CAMERA_RAYS_HPP
#define OPENCV_SURGTRACK_SRC_VTK_CAMERA_RAYS_HPP

#include <vector>
#include "opencv2/surgtrack/camera.hpp"

namespace cv { namespace surgtrack {

/** A camera without distortion. */
struct Pinhole
{
    int width, height;
    double fx, fy, cx, cy;
};

/** The viewing rays (x / z, y / z) of all pixels of cameras with distortion; those of the last few are kept. */
class CameraRays
{
public:
    const Mat_<Vec2f>& of(const CameraModel& camera);

private:
    struct Kept
    {
        double intrinsics[16];
        Size size;
        Mat_<Vec2f> rays;
    };
    std::vector<Kept> cameras_;
};

//! The pinhole image that holds all rays.
Pinhole enclose(const CameraModel& camera, const Mat_<Vec2f>& rays);

}} // namespace cv::surgtrack

#endif
