// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "base/checks.hpp"
#include "model/camera.hpp"

namespace cv { namespace surgtrack {

const int largestImage = 32768;   // side [pixel]

static void checkField(const CameraModel& camera);
static void checkLens(const CameraModel& camera);

CameraModel::CameraModel() : fx(1), fy(1), cx(0), cy(0), size_(0, 0), distorted_(false)
{
    std::fill(k, k + 12, 0.);
}

CameraModel::CameraModel(InputArray cameraMatrix, InputArray distCoeffs, Size imageSize)
{
    const Mat K = cameraMatrix.getMat(), D = distCoeffs.getMat();
    if (K.size() != Size(3, 3) || K.channels() != 1 || (K.depth() != CV_64F && K.depth() != CV_32F))
        CV_Error(Error::StsBadArg, format("cameraMatrix must be 3 x 3 and floating point, is %d x %d", K.rows, K.cols));
    const int n = int(D.total() * D.channels());
    if ((n != 0 && n != 4 && n != 5 && n != 8 && n != 12) || (n != 0 && D.rows != 1 && D.cols != 1))
        CV_Error(Error::StsBadArg, format("distCoeffs must have 0, 4, 5, 8 or 12 coefficients, has %d", n));
    if (imageSize.width <= 0 || imageSize.height <= 0 || std::max(imageSize.width, imageSize.height) > largestImage)
        CV_Error(Error::StsBadSize, format("imageSize must be positive and at most %d, is %d x %d", largestImage, imageSize.width, imageSize.height));

    Mat_<double> K64, D64;
    K.convertTo(K64, CV_64F);
    checkFinite(K64, "cameraMatrix");
    fx = K64(0, 0); fy = K64(1, 1); cx = K64(0, 2); cy = K64(1, 2);
    if (!(fx > 0 && fy > 0) || K64(0, 1) != 0 || K64(1, 0) != 0 || K64(2, 0) != 0 || K64(2, 1) != 0 || K64(2, 2) != 1)
        CV_Error(Error::StsBadArg, "cameraMatrix must be [fx 0 cx; 0 fy cy; 0 0 1] with positive focal lengths");

    std::fill(k, k + 12, 0.);
    if (n > 0)
    {
        D.clone().reshape(1, 1).convertTo(D64, CV_64F);   // a column of a larger matrix is not continuous
        checkFinite(D64, "distCoeffs");
        std::copy(D64.begin(), D64.end(), k);
    }
    size_ = imageSize;
    distorted_ = std::count(k, k + 12, 0.) != 12;
    checkField(*this);
    if (distorted_) checkLens(*this);
}

CameraPair::CameraPair() : right_T_left(Matx44d::eye()) {}

Matx33d CameraModel::cameraMatrix() const
{
    return Matx33d(fx, 0, cx, 0, fy, cy, 0, 0, 1);
}

Mat CameraModel::distCoeffs() const
{
    return Mat(1, 12, CV_64F, const_cast<double*>(k)).clone();
}

// OpenCV's distortion model of a ray (x, y), and its derivatives d(xd, yd) / d(x, y).
static void distort(const double* k, double x, double y, double& xd, double& yd, Matx22d* J)
{
    const double r2 = x * x + y * y, r4 = r2 * r2, r6 = r4 * r2;
    const double num = 1 + k[0] * r2 + k[1] * r4 + k[4] * r6, den = 1 / (1 + k[5] * r2 + k[6] * r4 + k[7] * r6);
    const double g = num * den;
    xd = x * g + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x) + k[8] * r2 + k[9] * r4;
    yd = y * g + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y + k[10] * r2 + k[11] * r4;
    if (!J) return;
    // dg / d(r2), times d(r2) / d(x, y) = (2x, 2y)
    const double dg = (k[0] + 2 * k[1] * r2 + 3 * k[4] * r4) * den - num * den * den * (k[5] + 2 * k[6] * r2 + 3 * k[7] * r4);
    const double sx = k[8] + 2 * k[9] * r2, sy = k[10] + 2 * k[11] * r2;
    (*J)(0, 0) = g + 2 * x * x * dg + 2 * k[2] * y + 6 * k[3] * x + 2 * x * sx;
    (*J)(0, 1) = 2 * x * y * dg + 2 * k[2] * x + 2 * k[3] * y + 2 * y * sx;
    (*J)(1, 0) = 2 * x * y * dg + 2 * k[2] * x + 2 * k[3] * y + 2 * x * sy;
    (*J)(1, 1) = g + 2 * y * y * dg + 6 * k[2] * y + 2 * k[3] * x + 2 * y * sy;
}

Point2d CameraModel::project(const Point3d& p, Matx23d* jacobian) const
{
    const double iz = 1 / p.z, x = p.x * iz, y = p.y * iz;
    double xd = x, yd = y;
    Matx22d D = Matx22d::eye();
    if (distorted_) distort(k, x, y, xd, yd, jacobian ? &D : 0);
    if (jacobian)
    {
        const double a = fx * D(0, 0) * iz, b = fx * D(0, 1) * iz, c = fy * D(1, 0) * iz, d = fy * D(1, 1) * iz;
        *jacobian = Matx23d(a, b, -(a * x + b * y), c, d, -(c * x + d * y));
    }
    return Point2d(fx * xd + cx, fy * yd + cy);
}

void CameraModel::projectPoints(InputArray viewPoints, OutputArray imagePoints) const
{
    const Mat points = asRows(viewPoints, 3, "viewPoints");
    imagePoints.create(points.rows, 1, CV_64FC2);
    Mat out = imagePoints.getMat();
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (int i = 0; i < points.rows; i++)
    {
        const Point3d& p = *points.ptr<Point3d>(i);
        out.at<Point2d>(i) = p.z > 0 ? project(p) : Point2d(nan, nan);
    }
}

static Point2d unproject(const CameraModel& camera, const Point2d& u)
{
    const double xd = (u.x - camera.cx) / camera.fx, yd = (u.y - camera.cy) / camera.fy;
    Point2d ray(xd, yd);
    if (!camera.hasDistortion()) return ray;
    // Newton on distort(ray) = (xd, yd); a step that would leave the monotonic part of the model is cut.
    for (int i = 0; i < 20; i++)
    {
        double x, y;
        Matx22d J;
        distort(camera.k, ray.x, ray.y, x, y, &J);
        const double det = J(0, 0) * J(1, 1) - J(0, 1) * J(1, 0), ex = xd - x, ey = yd - y;
        if (!(det > 1e-3)) break;
        Point2d step((J(1, 1) * ex - J(0, 1) * ey) / det, (J(0, 0) * ey - J(1, 0) * ex) / det);
        const double length = norm(step);
        if (length > 0.2) step *= 0.2 / length;
        ray += step;
        if (length < 1e-12) break;
    }
    return ray;
}

void CameraModel::unprojectPoints(InputArray imagePoints, OutputArray rays) const
{
    const Mat points = asRows(imagePoints, 2, "imagePoints");
    rays.create(points.rows, 1, CV_64FC2);
    Mat out = rays.getMat();
    for (int i = 0; i < points.rows; i++) out.at<Point2d>(i) = unproject(*this, *points.ptr<Point2d>(i));
}

//! That rays to the image are some of a lens: what is near 180 degrees, or a thousand images beside the axis, is a slip of units.
static void checkField(const CameraModel& camera)
{
    const Size size = camera.imageSize();
    const double f[] = {camera.fx, camera.fy}, c[] = {camera.cx, camera.cy}, side[] = {double(size.width), double(size.height)};
    for (int i = 0; i < 2; i++)
        if (!(f[i] >= 1e-3 * side[i] && f[i] <= 1e6 * side[i] && std::abs(c[i]) <= 1e3 * side[i]))
            CV_Error(Error::StsBadArg, format("cameraMatrix: expected a focal length from 0.001 to 1e6, and a principal point within 1000, times the %d pixels "
                                              "of the image's %s, found %g and %g", cvRound(side[i]), i ? "height" : "width", f[i], c[i]));
}

//! Where the model has a pole, or folds back, several rays come to one pixel, or none does.
static void checkLens(const CameraModel& camera)
{
    const Size size = camera.imageSize();
    const double* k = camera.k;
    const int borders = 8, steps = 16;
    const double margin = 1.02;   // a little beyond the image is drawn, too
    for (int i = 0; i <= borders; i++)
        for (int side = 0; side < 4; side++)
        {
            const double s = double(i) / borders, w = size.width, h = size.height;
            const Point2d pixel = Point2d(side < 2 ? s * w : side == 2 ? 0 : w, side < 2 ? (side ? h : 0) : s * h) - Point2d(0.5, 0.5);
            const Point2d ray = unproject(camera, pixel), back = camera.project(Point3d(ray.x, ray.y, 1));
            bool sound = norm(back - pixel) < 0.5;
            const double far2 = margin * margin * ray.dot(ray);
            // Of the denominator 1 + k4 r^2 + k5 r^4 + k6 r^6 the least value is at an end or where its slope is 0.
            double places[] = {far2, 0, 0};
            const double root = 4 * k[6] * k[6] - 12 * k[5] * k[7];
            for (int j = 0; j < 2 && root >= 0; j++)
                places[1 + j] = k[7] != 0 ? (-2 * k[6] + (j ? 1 : -1) * std::sqrt(root)) / (6 * k[7]) : k[6] != 0 ? -k[5] / (2 * k[6]) : 0.;
            for (int j = 0; j < 3; j++)
            {
                const double r2 = places[j];
                sound = sound && !(r2 > 0 && r2 <= far2 && !(1 + r2 * (k[5] + r2 * (k[6] + r2 * k[7])) > 1e-3));
            }
            for (int j = 1; j <= steps && sound; j++)
            {
                double x, y;
                Matx22d J;
                distort(k, ray.x * j * margin / steps, ray.y * j * margin / steps, x, y, &J);
                sound = J(0, 0) * J(1, 1) - J(0, 1) * J(1, 0) > 0 && J(0, 0) + J(1, 1) > 0;
            }
            if (!sound)
                CV_Error(Error::StsBadArg, format("distCoeffs: expected a lens that gives each pixel one ray, this one folds or has a pole within the image, "
                                                  "at or before pixel (%.0f, %.0f)", pixel.x, pixel.y));
        }
}

Rect2d CameraModel::fieldOfView(const Rect& window) const
{
    // A pixel reaches half a pixel beyond its centre.
    const double l = window.x - 0.5, t = window.y - 0.5, w = window.width, h = window.height;
    const int samples = distorted_ ? 16 : 1;
    // Between samples a border bulges by less than a twentieth of a pixel.
    const double bulge = distorted_ ? 0.05 : 0.;
    double xmin = DBL_MAX, xmax = -DBL_MAX, ymin = DBL_MAX, ymax = -DBL_MAX;
    for (int i = 0; i <= samples; i++)
    {
        const double s = double(i) / samples;
        const Point2d border[4] = {Point2d(l + s * w, t), Point2d(l + s * w, t + h), Point2d(l, t + s * h), Point2d(l + w, t + s * h)};
        for (int j = 0; j < 4; j++)
        {
            const Point2d ray = unproject(*this, border[j]);
            xmin = std::min(xmin, ray.x); xmax = std::max(xmax, ray.x);
            ymin = std::min(ymin, ray.y); ymax = std::max(ymax, ray.y);
        }
    }
    xmin -= bulge / fx; xmax += bulge / fx;
    ymin -= bulge / fy; ymax += bulge / fy;
    return Rect2d(xmin, ymin, xmax - xmin, ymax - ymin);
}

//! Pixels f times as large in each direction.
static CameraModel scaleCamera(const CameraModel& camera, double f, const Size& size)
{
    const Matx33d K(camera.fx * f, 0, (camera.cx + 0.5) * f - 0.5, 0, camera.fy * f, (camera.cy + 0.5) * f - 0.5, 0, 0, 1);
    return CameraModel(K, camera.distCoeffs(), size);
}

CameraModel reduceCamera(const CameraModel& camera, int factor)
{
    return scaleCamera(camera, 1. / factor, Size(camera.imageSize().width / factor, camera.imageSize().height / factor));
}

CameraModel enlargeCamera(const CameraModel& camera, int factor)
{
    return scaleCamera(camera, factor, camera.imageSize() * factor);
}

}} // namespace cv::surgtrack
