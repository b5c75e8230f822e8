// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_BASE_GEOMETRY_HPP
#define OPENCV_SURGTRACK_SRC_BASE_GEOMETRY_HPP

#include <algorithm>
#include "opencv2/core.hpp"
#include "opencv2/core/affine.hpp"

namespace cv { namespace surgtrack {

//! What lies nearer to a camera than this is not seen [m].
const double nearestDepth = 1e-3;

//! Widths of gradients, of spreading and of zones are pixels of an image about this wide.
const int referenceWidth = 720;

// Rigid transforms

inline Point3d transform(const Matx44d& T, const Point3d& p)
{
    return Point3d(T(0, 0) * p.x + T(0, 1) * p.y + T(0, 2) * p.z + T(0, 3),
                   T(1, 0) * p.x + T(1, 1) * p.y + T(1, 2) * p.z + T(1, 3),
                   T(2, 0) * p.x + T(2, 1) * p.y + T(2, 2) * p.z + T(2, 3));
}

inline Matx44d rigidTransform(const Matx33d& R, const Vec3d& t) { return Affine3d(R, t).matrix; }

inline Matx33d rotationOf(const Matx44d& T) { return T.get_minor<3, 3>(0, 0); }

//! Inverse of a rigid transform.
inline Matx44d rigidInverse(const Matx44d& T)
{
    Matx44d inv = Matx44d::eye();
    for (int r = 0; r < 3; r++)
    {
        for (int c = 0; c < 3; c++) inv(r, c) = T(c, r);
        inv(r, 3) = -(T(0, r) * T(0, 3) + T(1, r) * T(1, 3) + T(2, r) * T(2, 3));
    }
    return inv;
}

//! Rotation orthonormal and right-handed, last row 0 0 0 1, all finite. The tolerance admits matrices typed with four decimals.
bool isRigid(const Matx44d& T, double tolerance = 1e-3);

//! The same with an exact rotation, the nearest one.
Matx44d nearestRigid(const Matx44d& T);

//! N x 4 x 4 CV_64F, empty if there are none.
Mat stackPoses(const std::vector<Matx44d>& poses);

// Rotations

//! a x b = skew(a) b
inline Matx33d skew(const Vec3d& a) { return Matx33d(0, -a[2], a[1], a[2], 0, -a[0], -a[1], a[0], 0); }

//! The formula of Rodrigues, of a unit vector v or of one whose length s and c make up for.
inline Matx33d rodrigues(const Vec3d& v, double s, double c)
{
    const Matx33d K = skew(v);
    return Matx33d::eye() + K * s + K * K * c;
}

//! @param axis of unit length
inline Matx33d rotationAbout(const Vec3d& axis, double angle) { return rodrigues(axis, std::sin(angle), 1 - std::cos(angle)); }

//! Exponential: the rotation of a rotation vector [rad].
inline Matx33d exponential(const Vec3d& omega)
{
    const double angle = norm(omega);
    return angle > 1e-9 ? rodrigues(omega, std::sin(angle) / angle, (1 - std::cos(angle)) / (angle * angle)) : rodrigues(omega, 1, 0.5);
}

//! Logarithm: the rotation vector of a rotation [rad].
Vec3d rotationVector(const Matx33d& R);

//! Between two orientations [rad]. By atan2: acos of the trace loses all digits of small angles.
inline double angleBetween(const Matx33d& A, const Matx33d& B)
{
    const Matx33d D = A.t() * B;
    const Vec3d v(D(2, 1) - D(1, 2), D(0, 2) - D(2, 0), D(1, 0) - D(0, 1));
    return std::atan2(norm(v), trace(D) - 1);
}

/** The angle a transform turns by [rad], from its trace: cheap, for comparisons with bounds. Small angles are good to 1e-8 only.
What is not a number gives pi. */
inline double turnFromTrace(double trace) { return std::acos(std::min(1., std::max(-1., (trace - 1) / 2))); }
inline double turnOf(const Matx44d& T) { return turnFromTrace(T(0, 0) + T(1, 1) + T(2, 2)); }

//! The same of A^-1 B, without the product.
inline double turnBetween(const Matx44d& A, const Matx44d& B)
{
    double sum = 0;
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) sum += A(r, c) * B(r, c);
    return turnFromTrace(sum);
}

// Quaternions

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
