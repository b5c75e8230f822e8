// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_PRECOMP_HPP
#define OPENCV_SURGTRACK_PRECOMP_HPP

#include "opencv2/surgtrack.hpp"
#include "opencv2/imgproc.hpp"
#include "opencv2/core/private.hpp"
#include "opencv2/core/utility.hpp"

namespace cv { namespace surgtrack {

//! Asserts that every element of a numeric array is finite; name is the argument's, for the message.
void checkFinite(InputArray values, const char* name);

//! CV_8UC1 or CV_8UC3, not empty.
void checkImage(const Mat& image);

//! As a N x channels CV_64F matrix (a copy if need be), finite; for arguments that may come as N x channels or N-vectors of points.
Mat asRows(InputArray values, int channels, const char* name);

//! The arguments of MeshRenderer::render(), for a renderer that has so many meshes.
void checkRendering(const CameraModel& camera, const Rect& window, const std::vector<MeshInstance>& instances, int meshes);

//! How much memory to take for `needed` elements where there are `existing`: twice what is needed, so that windows that grow a
//! little from frame to frame do not take some each time.
inline size_t roomFor(size_t needed, size_t existing) { return needed > existing ? 2 * needed : existing; }

inline Point3d transform(const Matx44d& T, const Point3d& p)
{
    return Point3d(T(0, 0) * p.x + T(0, 1) * p.y + T(0, 2) * p.z + T(0, 3),
                   T(1, 0) * p.x + T(1, 1) * p.y + T(1, 2) * p.z + T(1, 3),
                   T(2, 0) * p.x + T(2, 1) * p.y + T(2, 2) * p.z + T(2, 3));
}

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

//! N x 4 x 4 CV_64F, empty if there are none.
Mat stackPoses(const std::vector<Matx44d>& poses);

//! Rotation orthonormal and right-handed, last row 0 0 0 1, all finite. The tolerance admits matrices typed with four decimals.
bool isRigid(const Matx44d& T, double tolerance = 1e-3);

//! The same with an exact rotation, the nearest one.
Matx44d nearestRigid(const Matx44d& T);

//! Widths of gradients, of spreading and of zones are pixels of an image about this wide.
const int referenceWidth = 720;

//! The camera whose pixels are the means of factor x factor pixels.
CameraModel reduceCamera(const CameraModel& camera, int factor);

}} // namespace cv::surgtrack

#endif
