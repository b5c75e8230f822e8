// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "base/calib.hpp"
#include "base/geometry.hpp"

namespace cv { namespace surgtrack {

Mat stackPoses(const std::vector<Matx44d>& poses)
{
    if (poses.empty()) return Mat();
    const int sizes[] = { (int)poses.size(), 4, 4 };
    return Mat(3, sizes, CV_64F, const_cast<Matx44d*>(poses.data())).clone();
}

bool isRigid(const Matx44d& T, double tolerance)
{
    if (!checkRange(T)) return false;
    const Matx33d R = rotationOf(T);
    const bool affine = T(3, 0) == 0 && T(3, 1) == 0 && T(3, 2) == 0 && T(3, 3) == 1;
    return affine && norm(R.t() * R, Matx33d::eye(), NORM_INF) < tolerance && determinant(R) > 0;
}

Matx44d nearestRigid(const Matx44d& T)
{
    Matx31d w;
    Matx33d u, vt;
    SVD::compute(T.get_minor<3, 3>(0, 0), w, u, vt);
    const Matx33d R = u * vt;
    Matx44d result = T;
    for (int i = 0; i < 9; i++) result(i / 3, i % 3) = R(i / 3, i % 3);
    return result;
}

Vec3d rotationVector(const Matx33d& R)
{
    Vec3d omega;
    Rodrigues(R, omega);
    return omega;
}

}} // namespace cv::surgtrack
