// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_BASE_GEOMETRY_HPP
#define OPENCV_SURGTRACK_SRC_BASE_GEOMETRY_HPP

#include <algorithm>
#include "opencv2/core.hpp"

namespace cv { namespace surgtrack {

//! @param q x, y, z, w; any length but 0
inline Matx33d rotationFromQuaternion(const Vec4d& q)
{
    const double x = q[0], y = q[1], z = q[2], w = q[3], s = 2 / q.dot(q);
    return Matx33d(1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w),
                   s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w),
                   s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y));
}

//! @return x, y, z, w of unit length
inline Vec4d quaternionFromRotation(const Matx33d& R)
{
    // The largest of the four components is computed first and divides the others: stable at any angle.
    const double squares[] = { 1 + R(0, 0) - R(1, 1) - R(2, 2), 1 - R(0, 0) + R(1, 1) - R(2, 2),
                               1 - R(0, 0) - R(1, 1) + R(2, 2), 1 + R(0, 0) + R(1, 1) + R(2, 2) };
    const double x = R(2, 1) - R(1, 2), y = R(0, 2) - R(2, 0), z = R(1, 0) - R(0, 1);
    const double xy = R(0, 1) + R(1, 0), xz = R(0, 2) + R(2, 0), yz = R(1, 2) + R(2, 1);
    const Vec4d candidates[] = { Vec4d(squares[0], xy, xz, x), Vec4d(xy, squares[1], yz, y),
                                 Vec4d(xz, yz, squares[2], z), Vec4d(x, y, z, squares[3]) };
    return normalize(candidates[std::max_element(squares, squares + 4) - squares]);
}

}} // namespace cv::surgtrack

#endif
