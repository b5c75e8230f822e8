// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// What evaluate computes with: means, chi-square bands, transforms, checked text files.

#ifndef OPENCV_SURGTRACK_SAMPLES_EVALUATION_STATISTICS_HPP
#define OPENCV_SURGTRACK_SAMPLES_EVALUATION_STATISTICS_HPP

#include <cmath>
#include <fstream>
#include <limits>
#include "opencv2/surgtrack.hpp"
#include "opencv2/surgtrack/lab.hpp"
#include "../support/common.hpp"

namespace evaluation {

inline double unknown() { return std::numeric_limits<double>::quiet_NaN(); }

//! Mean and standard deviation (of the population) of what was added; unknown without any.
class Moments
{
public:
    Moments() : count_(0), sum_(0), sum2_(0) {}

    void add(double value)
    {
        count_++;
        sum_ += value;
        sum2_ += value * value;
    }
    //! Those of another, from its count, mean and deviation.
    void add(int count, double mean, double deviation)
    {
        if (count == 0)
            return;
        count_ += count;
        sum_ += count * mean;
        sum2_ += count * (deviation * deviation + mean * mean);
    }
    int count() const { return count_; }
    double mean() const { return count_ ? sum_ / count_ : unknown(); }
    double deviation() const { return count_ ? std::sqrt(std::max(0., sum2_ / count_ - mean() * mean())) : unknown(); }

private:
    int count_;
    double sum_, sum2_;
};

/* The regularised lower incomplete gamma function P(a, x): its series below a + 1, its continued fraction (Lentz) above. */
inline double incompleteGamma(double a, double x)
{
    if (!(x > 0))
        return 0;
    const double factor = std::exp(a * std::log(x) - x - std::lgamma(a));
    const int most = 1000000;   // terms; some ten times the root of a are needed
    if (x < a + 1)
    {
        double term = 1 / a, sum = term;
        for (int i = 1; i < most && term > 1e-16 * sum; i++)
        {
            term *= x / (a + i);
            sum += term;
        }
        return factor * sum;
    }
    double b = x + 1 - a, c = 1e300, d = 1 / b, fraction = d;
    for (int i = 1; i < most; i++)
    {
        const double an = -i * (i - a);
        b += 2;
        d = 1 / (an * d + b);
        c = b + an / c;
        fraction *= c * d;
        if (std::abs(c * d - 1) < 1e-15)
            break;
    }
    return 1 - factor * fraction;
}

/** The value that a chi-square variable with so many degrees of freedom stays below with a probability; by bisection of its
distribution function, to nine digits and more. */
inline double chiSquareQuantile(double probability, double dof)
{
    double low = 0, high = std::max(dof, 1.);
    while (incompleteGamma(dof / 2, high / 2) < probability)
        high *= 2;
    while (high - low > 1e-12 * high)
    {
        const double middle = (low + high) / 2;
        if (middle <= low || middle >= high)
            break;
        (incompleteGamma(dof / 2, middle / 2) < probability ? low : high) = middle;
    }
    return (low + high) / 2;
}

//! The band that holds 95 % of a chi-square variable divided by n.
struct Band
{
    double low, high;
    Band(double dof, double n)
        : low(dof > 0 ? chiSquareQuantile(0.025, dof) / n : unknown()), high(dof > 0 ? chiSquareQuantile(0.975, dof) / n : unknown())
    {
    }
    bool holds(double value) const { return value >= low && value <= high; }
};

inline cv::Matx33d rotationOf(const cv::Matx44d& T) { return T.get_minor<3, 3>(0, 0); }
inline cv::Vec3d translationOf(const cv::Matx44d& T) { return cv::Vec3d(T(0, 3), T(1, 3), T(2, 3)); }

inline cv::Matx44d rigid(const cv::Matx33d& R, const cv::Vec3d& t)
{
    return cv::Matx44d(R(0, 0), R(0, 1), R(0, 2), t[0], R(1, 0), R(1, 1), R(1, 2), t[1], R(2, 0), R(2, 1), R(2, 2), t[2], 0, 0, 0, 1);
}

inline cv::Matx44d rigidInverse(const cv::Matx44d& T)
{
    const cv::Matx33d Rt = rotationOf(T).t();
    return rigid(Rt, -(Rt * translationOf(T)));
}

inline cv::Matx33d rotationFromVector(const cv::Vec3d& v)
{
    const double angle = cv::norm(v);
    if (angle < 1e-12)
        return cv::Matx33d::eye();
    const cv::Vec3d n = v * (1 / angle);
    const cv::Matx33d N(0, -n[2], n[1], n[2], 0, -n[0], -n[1], n[0], 0);
    return cv::Matx33d::eye() + N * std::sin(angle) + N * N * (1 - std::cos(angle));   // Rodrigues
}

//! A number of a CSV file; nothing if it is not finite.
inline std::string cell(double value, int digits = 6)
{
    return cvIsNaN(value) || cvIsInf(value) ? "" : cv::format("%.*g", digits, value);
}

//! A number of a printed table; a dash if it is not finite.
inline std::string shown(double value, int decimals, const char* unit = "")
{
    return cvIsNaN(value) || cvIsInf(value) ? "-" : cv::format("%.*f%s", decimals, value, unit);
}

//! A mean, plus-minus sign (UTF-8), deviation.
inline std::string shown(double mean, double deviation, int decimals)
{
    return cvIsNaN(mean) ? "-" : cv::format("%.*f \xc2\xb1 %.*f", decimals, mean, decimals, deviation);
}

//! A text file; what can't be written is an error that names it.
class TextFile
{
public:
    explicit TextFile(const std::string& filename) : filename_(filename), file_(filename.c_str(), std::ios::binary)
    {
        check();
    }
    TextFile& operator<<(const std::string& text)
    {
        file_ << text;
        return *this;
    }
    //! Throws if not all of it was written.
    void finish()
    {
        file_.close();
        check();
    }

private:
    void check() const
    {
        if (!file_)
            common::fail(filename_ + ": can't be written, expected a file in a folder with room for it");
    }
    std::string filename_;
    std::ofstream file_;
};

} // namespace evaluation

#endif
