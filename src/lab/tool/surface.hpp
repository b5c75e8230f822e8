// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_LAB_TOOL_SURFACE_HPP
#define OPENCV_SURGTRACK_SRC_LAB_TOOL_SURFACE_HPP

#include "opencv2/surgtrack/tool_model.hpp"

namespace cv { namespace surgtrack {

//! A keypoint farther from its link's surface is none [m]: twice what a part's depth may be off to be visible.
const double farthestKeypoint = 0.002;

//! The point of a segment, of a triangle, that is nearest to p.
Vec3d nearestOnSegment(const Vec3d& p, const Vec3d& a, const Vec3d& b);
Vec3d nearestOnTriangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c);

//! From a point to the nearest triangle [m].
double distanceTo(const Mesh& mesh, const Point3d& point);

}} // namespace cv::surgtrack

#endif
