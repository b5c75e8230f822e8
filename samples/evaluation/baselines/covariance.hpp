// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Covariance descriptors of image regions (Tuzel et al. 2006), as Reiter et al. 2014 describe landmarks with; the set of values and sizes is ours.

#ifndef OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_COVARIANCE_HPP
#define OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_COVARIANCE_HPP

#include <cmath>
#include <vector>
#include "opencv2/imgproc.hpp"

namespace evaluation {

using namespace cv;

typedef Matx<double, 9, 9> Matx99d;

//! Eigenvalues and vectors (columns) of a symmetric matrix by Jacobi's rotations.
inline void symmetricEigen(Matx99d A, Vec<double, 9>& values, Matx99d& vectors)
{
    vectors = Matx99d::eye();
    for (int sweep = 0; sweep < 30; sweep++)
    {
        double off = 0, diagonal = 0;
        for (int i = 0; i < 9; i++)
            for (int j = 0; j <= i; j++)
                (i == j ? diagonal : off) += A(i, j) * A(i, j);
        if (off <= 1e-28 * diagonal)
            break;
        for (int p = 0; p < 8; p++)
            for (int q = p + 1; q < 9; q++)
            {
                if (A(p, q) == 0)
                    continue;
                const double theta = (A(q, q) - A(p, p)) / (2 * A(p, q));
                const double t = (theta < 0 ? -1 : 1) / (std::abs(theta) + std::sqrt(theta * theta + 1));
                const double c = 1 / std::sqrt(t * t + 1), s = t * c;
                for (int k = 0; k < 9; k++)
                {
                    const double a = A(k, p), b = A(k, q), v = vectors(k, p), w = vectors(k, q);
                    A(k, p) = c * a - s * b;
                    A(k, q) = s * a + c * b;
                    vectors(k, p) = c * v - s * w;
                    vectors(k, q) = s * v + c * w;
                }
                for (int k = 0; k < 9; k++)
                {
                    const double a = A(p, k), b = A(q, k);
                    A(p, k) = c * a - s * b;
                    A(q, k) = s * a + c * b;
                }
            }
    }
    for (int i = 0; i < 9; i++)
        values[i] = A(i, i);
}

inline Matx99d matrixLog(const Matx99d& A)
{
    Vec<double, 9> values;
    Matx99d vectors, scaled;
    symmetricEigen(A, values, vectors);
    for (int j = 0; j < 9; j++)
    {
        const double logarithm = std::log(std::max(values[j], 1e-12));
        for (int i = 0; i < 9; i++)
            scaled(i, j) = vectors(i, j) * logarithm;
    }
    return scaled * vectors.t();
}

/** Nine values a pixel: x, y, R, G, B, |dx|, |dy|, gradient magnitude, atan2(|dy|, |dx|); colours and gradients over 255, x and y over 20 px.
Means and covariances of them over squares come from integrals of the values and their products. */
class CovarianceImage
{
public:
    enum { VALUES = 9, SUMS = 54, SIZES = 2, LENGTH = 52, BORDER = 20 };   // LENGTH: 45 of the logarithm and 7 means

    static int radius(int size) { return size == 0 ? 10 : 20; }

    void setImage(const Mat& image)
    {
        Mat colour = image, grey, dx, dy;
        if (image.channels() == 1)
            cvtColor(image, colour, COLOR_GRAY2BGR);
        copyMakeBorder(colour, colour, BORDER, BORDER, BORDER, BORDER, BORDER_REPLICATE);
        cvtColor(colour, grey, COLOR_BGR2GRAY);
        Sobel(grey, dx, CV_32F, 1, 0, 3, 1. / (4 * 255), 0, BORDER_REPLICATE);
        Sobel(grey, dy, CV_32F, 0, 1, 3, 1. / (4 * 255), 0, BORDER_REPLICATE);
        values_.create(colour.size(), CV_32FC(7));
        for (int y = 0; y < colour.rows; y++)
            for (int x = 0; x < colour.cols; x++)
            {
                const Vec3b& c = colour.at<Vec3b>(y, x);
                const float a = std::abs(dx.at<float>(y, x)), b = std::abs(dy.at<float>(y, x));
                values_.at<Vec<float, 7> >(y, x) = Vec<float, 7>(c[2] / 255.f, c[1] / 255.f, c[0] / 255.f, a, b, std::sqrt(a * a + b * b), std::atan2(b, a));
            }
        size_ = image.size();
        region_ = Rect();
    }
    Size size() const { return size_; }

    //! Where descriptors are wanted: pixels of the image.
    void prepare(const Rect& places)
    {
        region_ = places & Rect(Point(), size_);
        const int width = region_.width + 2 * BORDER, height = region_.height + 2 * BORDER;
        sums_.assign(size_t(width + 1) * (height + 1) * SUMS, 0);
        stride_ = size_t(width + 1) * SUMS;
        for (int y = 0; y < height; y++)
        {
            double row[SUMS] = {};
            const double* above = &sums_[y * stride_ + SUMS];
            double* out = &sums_[(y + 1) * stride_ + SUMS];
            for (int x = 0; x < width; x++, above += SUMS, out += SUMS)
            {
                double v[VALUES];
                valuesAt(region_.x + x, region_.y + y, v);
                for (int i = 0, k = VALUES; i < VALUES; i++)
                {
                    row[i] += v[i];
                    for (int j = i; j < VALUES; j++)
                        row[k++] += v[i] * v[j];
                }
                for (int k = 0; k < SUMS; k++)
                    out[k] = above[k] + row[k];
            }
        }
    }
    const Rect& prepared() const { return region_; }

    //! Of the square about a prepared pixel.
    void covariance(const Point& place, int size, double* mean, Matx99d& C) const
    {
        const int r = radius(size), x = place.x - region_.x + BORDER, y = place.y - region_.y + BORDER;
        const double n = (2 * r + 1) * (2 * r + 1);
        const double* a = &sums_[(y - r) * stride_ + (x - r) * SUMS];
        const double* b = a + (2 * r + 1) * stride_;
        const int w = (2 * r + 1) * SUMS;
        double s[SUMS];
        for (int k = 0; k < SUMS; k++)
            s[k] = (b[k + w] - b[k] - a[k + w] + a[k]) / n;
        for (int i = 0, k = VALUES; i < VALUES; i++)
        {
            mean[i] = s[i];
            for (int j = i; j < VALUES; j++, k++)
                C(i, j) = C(j, i) = s[k] - s[i] * s[j] + (i == j ? 1e-3 : 0);
        }
    }
    //! @param out LENGTH * SIZES
    void describe(const Point& place, float* out) const
    {
        for (int size = 0; size < SIZES; size++)
        {
            double mean[VALUES];
            Matx99d C;
            covariance(place, size, mean, C);
            const Matx99d L = matrixLog(C);
            for (int i = 0; i < VALUES; i++)
                for (int j = i; j < VALUES; j++)
                    *out++ = float(L(i, j) * (i == j ? 1 : std::sqrt(2.)));
            for (int i = 2; i < VALUES; i++)
                *out++ = (float)mean[i];
        }
    }
    //! The values of a pixel of the image with its border, which starts at 0. x and y are from the prepared region.
    void valuesAt(int x, int y, double* v) const
    {
        v[0] = (x - region_.x) / 20.;
        v[1] = (y - region_.y) / 20.;
        const float* const others = values_.ptr<float>(y) + 7 * x;
        for (int i = 0; i < 7; i++)
            v[2 + i] = others[i];
    }

private:
    Mat values_;
    Size size_;
    Rect region_;
    std::vector<double> sums_;   // interleaved: a square needs four places of memory
    size_t stride_;
};

} // namespace evaluation

#endif
