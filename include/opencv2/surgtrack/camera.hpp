// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_CAMERA_HPP
#define OPENCV_SURGTRACK_CAMERA_HPP

#include "opencv2/core.hpp"

namespace cv { namespace surgtrack {

//! @addtogroup surgtrack
//! @{

/** @brief A calibrated camera: intrinsics, lens distortion and image size.

Everything in the module works in the image as the camera delivers it: keypoints are projected, templates drawn and
measurements taken with fx != fy and with distortion; no image is ever undistorted.

Camera frame: x right, y down, z forward. Pixel (0, 0) is the centre of the top-left pixel.
 */
class CV_EXPORTS_W_SIMPLE CameraModel
{
public:
    //! An empty camera: imageSize() is 0 x 0.
    CV_WRAP CameraModel();

    /** @param cameraMatrix 3x3, any floating type, [pixel]; the skew is 0 and the last row 0 0 1
    @param distCoeffs 0, 4, 5, 8 or 12 coefficients in OpenCV's order (k1, k2, p1, p2[, k3[, k4, k5, k6[, s1..s4]]])
    @param imageSize width and height [pixel]

    @throws cv::Exception for any other shape, for non-finite values, for a focal length that is not positive or is less than a thousandth of
    the image's side, for an image of more than 32768 pixels a side, and for a distortion that folds or has a pole within the image: there
    several rays would come to one pixel, or none */
    CV_WRAP CameraModel(InputArray cameraMatrix, InputArray distCoeffs, Size imageSize);

    /** @brief 3x3, [pixel]. */
    CV_WRAP Matx33d cameraMatrix() const;
    /** @brief 1x12 CV_64F, zeros where nothing was given. */
    CV_WRAP Mat distCoeffs() const;
    /** @brief Width and height [pixel]. */
    CV_WRAP Size imageSize() const { return size_; }
    /** @brief Whether one of the coefficients is not 0. */
    CV_WRAP bool hasDistortion() const { return distorted_; }

    /** Projects one point of the camera frame [m] to the image [pixel].
    @param viewPoint point with z > 0; the caller sees to that
    @param jacobian if given, d(u, v) / d(x, y, z) */
    Point2d project(const Point3d& viewPoint, Matx23d* jacobian = 0) const;

    /** @brief Projects points of the camera frame to the image.
    @param viewPoints N points of the camera frame, N x 3 or 3-channel, floating [m]
    @param imagePoints N x 1 CV_64FC2 [pixel]; NaN where a point is not in front of the camera */
    CV_WRAP void projectPoints(InputArray viewPoints, OutputArray imagePoints) const;

    /** @brief The inverse: viewing rays of image points.
    @param imagePoints N points, N x 2 or 2-channel, floating [pixel]
    @param rays N x 1 CV_64FC2, (x / z, y / z) */
    CV_WRAP void unprojectPoints(InputArray imagePoints, OutputArray rays) const;

    /** @brief The rectangle in the plane z = 1 that holds the rays of every point of the image window [x / z, y / z].
    Tangents of the field of view; used to clip geometry before distortion is applied.
    @param window part of the image [pixel] */
    CV_WRAP Rect2d fieldOfView(const Rect& window) const;

    double fx, fy, cx, cy;   //!< [pixel]
    double k[12];            //!< k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4

private:
    Size size_;
    bool distorted_;
};

/** @brief Cameras of an endoscope with one or two eyes. */
struct CV_EXPORTS_W_SIMPLE CameraPair
{
    CV_WRAP CameraPair();
    CV_PROP_RW CameraModel left;
    CV_PROP_RW CameraModel right;           //!< image size 0 x 0 if there is one eye only
    CV_PROP_RW Matx44d right_T_left;        //!< maps the left camera's frame to the right's [m]
};

//! @}

}} // namespace cv::surgtrack

#endif
