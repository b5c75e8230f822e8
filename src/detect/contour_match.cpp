// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/surgtrack/contour.hpp"
#include "base/checks.hpp"

namespace cv { namespace surgtrack {

ContourSearch::ContourSearch() : halfWindow(8), preference(0.5), minStrength(6), ambiguity(0.8) {}

namespace {

const int maxHalf = 40;   // [pixel]

// The image along a normal, a sample a pixel, bilinear.
template <int channels> void readProfile(const Mat& image, const Point2d& from, const Point2d& step, int n, float* profile)
{
    for (int i = 0; i < n; i++)
    {
        const float x = float(from.x + i * step.x), y = float(from.y + i * step.y);
        const int ix = int(x), iy = int(y);
        const float u = x - ix, v = y - iy;
        const uchar *p = image.ptr(iy) + channels * ix, *q = p + image.step;
        for (int c = 0; c < channels; c++)
            profile[c * n + i] = (1 - v) * ((1 - u) * p[c] + u * p[c + channels])
                                 + v * ((1 - u) * q[c] + u * q[c + channels]);
    }
}

// The vertex of the parabola through three values at -1, 0, 1, of which the middle one is the largest.
inline float vertex(float l, float m, float r)
{
    const float d = l - 2 * m + r;
    return d < 0 ? 0.5f * (l - r) / d : 0.f;
}

} // namespace

int matchContour(InputArray _image, std::vector<ContourPoint>& points, const ContourSearch& search)
{
    const Mat image = _image.getMat();
    checkImage(image);
    CV_Check(search.halfWindow, search.halfWindow >= 1 && search.halfWindow <= maxHalf, "ContourSearch::halfWindow must be in 1..40");
    CV_Check(search.preference, search.preference >= 0 && search.preference < DBL_MAX, "ContourSearch::preference must not be negative");
    CV_Check(search.minStrength, search.minStrength >= 0 && search.minStrength < DBL_MAX, "ContourSearch::minStrength must not be negative");
    CV_Check(search.ambiguity, search.ambiguity >= 0 && search.ambiguity <= 1, "ContourSearch::ambiguity must be in 0..1");
    const int half = cvRound(search.halfWindow), reach = half + 4, n = 2 * reach + 1, channels = image.channels();
    float profile[3 * (2 * maxHalf + 9)], energy[2 * maxHalf + 9], prior[2 * maxHalf + 9];
    for (int i = 0; i < n; i++) prior[i] = search.preference > 0 ? std::exp(-0.5f * float((i - reach) * (i - reach)) / float(search.preference * search.preference * half * half)) : 1.f;
    int found = 0;
    for (size_t i = 0; i < points.size(); i++)
    {
        ContourPoint& c = points[i];
        c.found = false;
        const Point2d a = c.imagePoint - c.normal * reach, b = c.imagePoint + c.normal * reach;
        if (!(std::min(a.x, b.x) >= 0 && std::min(a.y, b.y) >= 0 && std::max(a.x, b.x) < image.cols - 1.001 && std::max(a.y, b.y) < image.rows - 1.001)) continue;
        if (channels == 3) readProfile<3>(image, a, c.normal, n, profile);
        else readProfile<1>(image, a, c.normal, n, profile);
        std::fill(energy, energy + n, 0.f);
        for (int k = 0; k < channels; k++)
        {
            const float* p = profile + k * n;
            for (int j = 2; j < n - 2; j++)
            {
                const float g = ((p[j + 1] - p[j - 1]) * 2 + (p[j + 2] - p[j - 2])) * 0.125f;
                energy[j] += g * g;
            }
        }
        int best = -1;
        float bestScore = 0, second = 0;
        const float least = float(search.minStrength * search.minStrength);
        for (int j = 4; j < n - 4; j++)
        {
            if (energy[j] < least || energy[j] < energy[j - 1] || energy[j] <= energy[j + 1]) continue;
            const float score = std::sqrt(energy[j]) * prior[j];
            if (score > bestScore)
            {
                second = bestScore;
                bestScore = score;
                best = j;
            }
            else second = std::max(second, score);
        }
        if (best < 0 || second > search.ambiguity * bestScore) continue;
        c.found = true;
        /* Lenses blur light, and cameras' tone curves are close to a square root of it: grey levels would have the edge on the dark
           side by 0.1 to 0.2 pixel, their squares have it where it is. */
        float linear[5] = {0, 0, 0, 0, 0};
        for (int k = 0; k < channels; k++)
            for (int i5 = 0; i5 < 5; i5++)
            {
                const float* p = profile + k * n + best - 2 + i5;
                const float g = (p[1] * p[1] - p[-1] * p[-1]) * 2 + (p[2] * p[2] - p[-2] * p[-2]);
                linear[i5] += g * g;
            }
        int at = 2;
        if (linear[1] > linear[2] && linear[1] > linear[3]) at = 1;
        else if (linear[3] > linear[2]) at = 3;
        c.offset = best - reach + at - 2 + vertex(linear[at - 1], linear[at], linear[at + 1]);
        c.offset = std::min(std::max(c.offset, best - reach - 1.5), best - reach + 1.5);
        c.strength = std::sqrt(energy[best]);
        c.deviation = std::sqrt(0.3 * 0.3 + 12 * 12 / energy[best]);
        found++;
    }
    return found;
}

}} // namespace cv::surgtrack
