// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/surgtrack/contour.hpp"
#include "base/checks.hpp"
#include "detect/contour_match.hpp"

namespace cv { namespace surgtrack {

ContourSearch::ContourSearch() : halfWindow(8), preference(0.5), minStrength(6), contrast(1.1), leastStrength(1), ambiguity(0.8) {}

namespace {

const int maxHalf = 40;   // [pixel]
const float rampFoot = 0.5f;    // of the steepest place's gradient: a ramp ends where it is less. Farther out shading counts as well
const int rampWidth = 5;        // [pixel]; edges of a sharp image are narrower

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

// The energy of the gradient along a normal, over all channels.
void profileEnergy(const float* profile, int channels, int n, float* energy)
{
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
}

// From where to where the gradient is steep about a place.
void findRamp(const float* energy, int n, int at, int& l, int& r)
{
    const float least = rampFoot * rampFoot * energy[at];
    for (l = at; l > 2 && energy[l - 1] > least;) l--;
    for (r = at; r < n - 3 && energy[r + 1] > least;) r++;
}

/* A blurred edge is a ramp as wide as the blur, and has no steepest place: its middle, in light, is where the edge is. Weights fall to 0
   where the ramp ends, so that it does not matter which pixel is its last one. */
float rampMiddle(const float* profile, int channels, int n, int at)
{
    float light[3 * (2 * maxHalf + 9)], energy[2 * maxHalf + 9];
    for (int i = 0; i < channels * n; i++) light[i] = profile[i] * profile[i];
    profileEnergy(light, channels, n, energy);
    int l, r;
    while (at > 2 && energy[at - 1] > energy[at]) at--;
    while (at < n - 3 && energy[at + 1] > energy[at]) at++;
    findRamp(energy, n, at, l, r);
    const float foot = rampFoot * std::sqrt(energy[at]);
    float sum = 0, moment = 0;
    for (int j = l; j <= r; j++)
    {
        const float weight = std::sqrt(energy[j]) - foot;
        sum += weight;
        moment += weight * j;
    }
    return moment / sum;
}

// Which side of an edge is white, in all channels: 1 that after it, -1 that before it.
int clippedSide(const float* profile, int channels, int n, int at)
{
    const int reach = 6;        // a bright ramp is as wide as that [pixel]
    const float white = 240;    // codecs and white balance take some grey levels off
    int sides = 0;
    for (int side = -1; side <= 1; side += 2)
    {
        const int j = std::min(std::max(at + side * reach, 0), n - 1);
        bool clipped = true;
        for (int c = 0; c < channels && clipped; c++) clipped = profile[c * n + j] >= white;
        sides += clipped ? side : 0;
    }
    return sides;
}

// Whether the profile of a point lies in the image, and from where.
bool profileInside(const Mat& image, const ContourPoint& c, int reach, Point2d& a)
{
    a = c.imagePoint - c.normal * reach;
    const Point2d b = c.imagePoint + c.normal * reach;
    return std::min(a.x, b.x) >= 0 && std::min(a.y, b.y) >= 0 && std::max(a.x, b.x) < image.cols - 1.001 && std::max(a.y, b.y) < image.rows - 1.001;
}

// The median strength about the outline: that of texture and noise.
float medianStrength(const Mat& image, const std::vector<ContourPoint>& points)
{
    const int looks = 32, reach = 12, n = 2 * reach + 1;   // so many points, and so far, tell
    float profile[3 * n], energy[n], strengths[looks * n];
    int count = 0;
    for (size_t i = 0; i < points.size(); i += points.size() / looks + 1)
    {
        Point2d a;
        if (!profileInside(image, points[i], reach, a)) continue;
        if (image.channels() == 3) readProfile<3>(image, a, points[i].normal, n, profile);
        else readProfile<1>(image, a, points[i].normal, n, profile);
        profileEnergy(profile, image.channels(), n, energy);
        for (int j = 2; j < n - 2; j += 2)
            if (energy[j] > 0) strengths[count++] = energy[j];   // not of black surrounds
    }
    if (!count) return 0;
    std::nth_element(strengths, strengths + count / 2, strengths + count);
    return std::sqrt(strengths[count / 2]);
}

} // namespace

void checkSearch(const ContourSearch& search)
{
    CV_Check(search.halfWindow, search.halfWindow >= 1 && search.halfWindow <= maxHalf, "ContourSearch::halfWindow must be in 1..40");
    CV_Check(search.preference, search.preference >= 0 && search.preference < DBL_MAX, "ContourSearch::preference must not be negative");
    CV_Check(search.minStrength, search.minStrength >= 0 && search.minStrength < DBL_MAX, "ContourSearch::minStrength must not be negative");
    CV_Check(search.contrast, search.contrast >= 0 && search.contrast < DBL_MAX, "ContourSearch::contrast must not be negative");
    CV_Check(search.leastStrength, search.leastStrength >= 0 && search.leastStrength < DBL_MAX, "ContourSearch::leastStrength must not be negative");
    CV_Check(search.ambiguity, search.ambiguity >= 0 && search.ambiguity <= 1, "ContourSearch::ambiguity must be in 0..1");
}

double strengthAsked(const Mat& image, const std::vector<ContourPoint>& points, const ContourSearch& search)
{
    if (search.contrast <= 0) return search.minStrength;
    return std::min(search.minStrength, std::max(search.leastStrength, search.contrast * medianStrength(image, points)));
}

int matchContour(InputArray _image, std::vector<ContourPoint>& points, const ContourSearch& search)
{
    const Mat image = _image.getMat();
    checkImage(image);
    return matchContour(image, points, search, strengthAsked(image, points, search));
}

int matchContour(const Mat& image, std::vector<ContourPoint>& points, const ContourSearch& search, double leastStrength)
{
    checkSearch(search);
    const int half = cvRound(search.halfWindow), reach = half + 4, n = 2 * reach + 1, channels = image.channels();
    float profile[3 * (2 * maxHalf + 9)], energy[2 * maxHalf + 9], prior[2 * maxHalf + 9];
    for (int i = 0; i < n; i++) prior[i] = search.preference > 0 ? std::exp(-0.5f * float((i - reach) * (i - reach)) / float(search.preference * search.preference * half * half)) : 1.f;
    const float least = float(leastStrength * leastStrength);
    // Where all edges are weaker, weak ones are placed as well.
    const double unit = search.minStrength > 0 ? 12 * leastStrength / search.minStrength : 12;
    int found = 0;
    for (size_t i = 0; i < points.size(); i++)
    {
        ContourPoint& c = points[i];
        c.found = false;
        Point2d a;
        if (!profileInside(image, c, reach, a)) continue;
        if (channels == 3) readProfile<3>(image, a, c.normal, n, profile);
        else readProfile<1>(image, a, c.normal, n, profile);
        profileEnergy(profile, channels, n, energy);
        int best = -1;
        float bestScore = 0, second = 0;
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
        int l, r;
        findRamp(energy, n, best, l, r);
        if (r - l >= rampWidth) c.offset = rampMiddle(profile, channels, n, best) - reach;
        c.clipped = clippedSide(profile, channels, n, best);
        c.strength = std::sqrt(energy[best]);
        c.deviation = std::sqrt(0.3 * 0.3 + unit * unit / energy[best]);
        found++;
    }
    return found;
}

}} // namespace cv::surgtrack
