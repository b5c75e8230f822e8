// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "lab/synthetic/synthetic_image.hpp"

namespace cv { namespace surgtrack {

namespace {

// Random values on a grid of the given cell size, interpolated. CV_32FC1, about -1..1.
Mat smoothNoise(Size size, double cell, RNG& rng)
{
    const Size grid(cvCeil(size.width / cell) + 3, cvCeil(size.height / cell) + 3);
    Mat values(grid, CV_32F), noise;
    rng.fill(values, RNG::UNIFORM, -1, 1);
    resize(values, noise, Size(cvCeil(grid.width * cell), cvCeil(grid.height * cell)), 0, 0, INTER_CUBIC);
    return noise(Rect(cvFloor(cell), cvFloor(cell), size.width, size.height)).clone();
}

Mat fractalNoise(Size size, double cell, int octaves, double persistence, RNG& rng)
{
    Mat sum = Mat::zeros(size, CV_32F);
    double weight = 1;
    for (int i = 0; i < octaves && cell >= 2; i++, cell /= 2, weight *= persistence)
        sum += weight * smoothNoise(size, cell, rng);
    return sum;
}

float smoothStep(float low, float high, float x)
{
    const float t = std::min(std::max((x - low) / (high - low), 0.f), 1.f);
    return t * t * (3 - 2 * t);
}

Vec3f mix(const Vec3f& a, const Vec3f& b, float share) { return a + share * (b - a); }

float power(float x, int exponent)   // exponent: a power of two
{
    for (; exponent > 1; exponent /= 2)
        x *= x;
    return x;
}

float dot(const Vec3f& a, const Vec3f& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec3f unit(const Vec3f& v) { return v * (1 / std::sqrt(dot(v, v))); }    // cv::normalize() works in double

struct Shader
{
    const Rendering& doubled;
    const std::vector<ToolMaterial>& materials;
    Vec3f sideLight, lens;     // lens: the first light's place, beside the lens [m]
    float fx, fy, cx, cy;      // of the doubled camera
    int pitch;

    Shader(const Rendering& rendering, const CameraModel& camera, const std::vector<ToolMaterial>& toolMaterials, const Vec3f& side)
        : doubled(rendering), materials(toolMaterials), sideLight(side), lens(0.004f, -0.005f, 0), fx((float)camera.fx),
          fy((float)camera.fy), cx((float)camera.cx), cy((float)camera.cy), pitch((int)rendering.ids.step1())
    {
        CV_CheckEQ(rendering.ids.step1(), rendering.depth.step1(), "the maps must have equal rows");
    }

    // Change of depth to the next pixel in steps of `step` floats; across outlines it takes the side that goes on.
    static float slope(const float* z, const uchar* id, int step, bool hasBefore, bool hasAfter)
    {
        const float maxJump = 0.0006f;
        const float before = hasBefore && id[-step] == id[0] ? z[0] - z[-step] : 1.f;
        const float after = hasAfter && id[step] == id[0] ? z[step] - z[0] : 1.f;
        const bool useBefore = std::abs(before) < maxJump, useAfter = std::abs(after) < maxJump;
        if (useBefore && useAfter)
            return 0.5f * (before + after);
        return useBefore ? before : useAfter ? after : 0.f;
    }

    Vec3f operator()(const float* zs, const uchar* ids, int x, int y) const
    {
        const float z = *zs;
        const float zu = slope(zs, ids, 1, x > 0, x + 1 < doubled.ids.cols);
        const float zv = slope(zs, ids, pitch, y > 0, y + 1 < doubled.ids.rows);
        // Lens distortion turns the normals by a degree at most: left out.
        const float rx = ((float)x - cx) / fx, ry = ((float)y - cy) / fy;
        const Vec3f du(z / fx + rx * zu, ry * zu, zu), dv(rx * zv, z / fy + ry * zv, zv);
        const Vec3f n = unit(dv.cross(du));   // towards the camera

        const Vec3f P(rx * z, ry * z, z), toEye = unit(-P), toLens = lens - P;
        const float distance2 = dot(toLens, toLens), falloff = 0.0092f / distance2;   // 1 at 96 mm
        const Vec3f lensLight = toLens * (1 / std::sqrt(distance2));
        const float cosLens = std::max(dot(n, lensLight), 0.f), cosSide = std::max(dot(n, sideLight), 0.f);
        const ToolMaterial& m = materials[*ids - 1];
        const float highlight = m.specular * (falloff * power(std::max(dot(n, unit(lensLight + toEye)), 0.f), m.shininess) +
                                              0.6f * power(std::max(dot(n, unit(sideLight + toEye)), 0.f), m.shininess));
        const float scattered = 0.72f * falloff * cosLens + 0.42f * cosSide;
        // Tissue reflects in surfaces that face away from the lens.
        const float reflected = 0.35f + 0.65f * (1 - cosLens);
        const float tissue[] = { 0.16f, 0.14f, 0.30f };
        Vec3f c;
        for (int i = 0; i < 3; i++)
            c[i] = std::min(255 * (m.colour[i] * (scattered + tissue[i] * reflected) + highlight), 255.f);
        return c;
    }
};

// Soft shadow of the tools on the tissue behind them, 0..1, away from the side light. CV_32FC1.
Mat makeShadow(const Mat& ids, const Vec3f& sideLight, Size size)
{
    const int factor = 8;
    Mat mask, small, shadow;
    resize(ids > 0, small, Size((size.width + factor - 1) / factor, (size.height + factor - 1) / factor), 0, 0, INTER_AREA);
    const double offset = 0.03 * size.width / factor;
    const Matx23d shift(1, 0, -offset * sideLight[0], 0, 1, -offset * sideLight[1]);
    warpAffine(small, mask, shift, small.size(), INTER_LINEAR, BORDER_REPLICATE);
    GaussianBlur(mask, mask, Size(), 0.012 * size.width / factor);
    mask.convertTo(small, CV_32F, 1 / 255.);
    resize(small, shadow, size, 0, 0, INTER_LINEAR);
    return shadow;
}

} // namespace

std::vector<ToolMaterial> toolMaterials(const std::vector<int>& wristDepth)
{
    // Plastic up to the shaft, then steel; the last links, the jaws, are brighter.
    const ToolMaterial plastic = { Vec3f(0.19f, 0.18f, 0.18f), 0.22f, 16 };
    const ToolMaterial steel = { Vec3f(0.62f, 0.61f, 0.60f), 0.45f, 32 };
    const ToolMaterial jaw = { Vec3f(0.74f, 0.75f, 0.76f), 0.50f, 16 };
    std::vector<ToolMaterial> materials;
    for (size_t i = 0; i < wristDepth.size(); i++)
        materials.push_back(wristDepth[i] == 0 ? plastic : wristDepth[i] == 1 ? steel : jaw);
    return materials;
}

Mat makeTissue(Size size, RNG& rng)
{
    const double unit = size.height / 576.;   // structures keep their size in the picture
    const Mat tone = fractalNoise(size, 190 * unit, 7, 0.55, rng), fat = fractalNoise(size, 150 * unit, 5, 0.5, rng);
    const Mat largeVeins = fractalNoise(size, 170 * unit, 4, 0.4, rng), smallVeins = fractalNoise(size, 60 * unit, 4, 0.45, rng);
    const Mat relief = fractalNoise(size, 42 * unit, 4, 0.5, rng), grain = smoothNoise(size, std::max(2., 3 * unit), rng);
    Mat tissue(size, CV_8UC3);
    for (int y = 0; y < size.height; y++)
        for (int x = 0; x < size.width; x++)
        {
            Vec3f c = mix(Vec3f(88, 92, 182), Vec3f(128, 138, 215), smoothStep(-0.9f, 0.9f, tone.at<float>(y, x)));
            c = mix(c, Vec3f(118, 172, 220), 0.65f * smoothStep(0.25f, 0.9f, fat.at<float>(y, x)));
            // Veins run where the noise changes its sign.
            const float large = 1 - smoothStep(0.012f, 0.055f, std::abs(largeVeins.at<float>(y, x)));
            const float fine = 1 - smoothStep(0.015f, 0.06f, std::abs(smallVeins.at<float>(y, x)));
            c = mix(c, Vec3f(52, 40, 120), 0.7f * large);
            c = mix(c, Vec3f(66, 52, 150), 0.4f * fine * smoothStep(-0.2f, 0.5f, tone.at<float>(y, x)));
            c *= 1 + 0.10f * relief.at<float>(y, x) + 0.03f * grain.at<float>(y, x);
            // Wet spots: the tops of the relief.
            const float wet = smoothStep(0.95f, 1.25f, relief.at<float>(y, x) + 0.12f * grain.at<float>(y, x));
            c = mix(c, Vec3f(245, 245, 255), 0.85f * wet);
            tissue.at<Vec3b>(y, x) = Vec3b(saturate_cast<uchar>(c[0]), saturate_cast<uchar>(c[1]), saturate_cast<uchar>(c[2]));
        }
    return tissue;
}

Mat makeVignette(Size size)
{
    Mat vignette(size, CV_32F);
    const float cx = 0.5f * size.width, cy = 0.5f * size.height, radius2 = cx * cx + cy * cy;
    for (int y = 0; y < size.height; y++)
        for (int x = 0; x < size.width; x++)
            vignette.at<float>(y, x) = 1 - 0.45f * ((x - cx) * (x - cx) + (y - cy) * (y - cy)) / radius2;
    return vignette;
}

void composeImage(const Rendering& doubled, const CameraModel& doubledCamera, const std::vector<ToolMaterial>& materials,
                  const Vec3f& sideLight, const Mat& background, const Mat& vignette, Mat& light)
{
    CV_Assert(doubled.ids.size() == Size(2 * background.cols, 2 * background.rows) && vignette.size() == background.size());
    const Shader shade(doubled, doubledCamera, materials, sideLight);
    const Mat shadow = makeShadow(doubled.ids, sideLight, background.size());
    light.create(background.size(), CV_32FC3);
    parallel_for_(Range(0, light.rows), [&](const Range& range)
    {
        for (int y = range.start; y < range.end; y++)
        {
            const Vec3b* b = background.ptr<Vec3b>(y);
            const float *v = vignette.ptr<float>(y), *s = shadow.ptr<float>(y);
            const uchar* ids[] = { doubled.ids.ptr<uchar>(2 * y), doubled.ids.ptr<uchar>(2 * y + 1) };
            const float* zs[] = { doubled.depth.ptr<float>(2 * y), doubled.depth.ptr<float>(2 * y + 1) };
            Vec3f* out = light.ptr<Vec3f>(y);
            for (int x = 0; x < light.cols; x++)
            {
                Vec3f sum(0, 0, 0);
                int covered = 0;
                for (int i = 0; i < 4; i++)
                {
                    const int u = 2 * x + (i & 1), row = i >> 1;
                    if (!ids[row][u])
                        continue;
                    const Vec3f level = shade(zs[row] + u, ids[row] + u, u, 2 * y + row);
                    sum += level.mul(level);
                    covered++;
                }
                const float shade2 = (1 - 0.5f * s[x]) * (1 - 0.5f * s[x]), share = (float)(4 - covered) * shade2;
                for (int c = 0; c < 3; c++)
                    out[x][c] = 0.25f * v[x] * v[x] * (sum[c] + share * (float)(b[x][c] * b[x][c]));
            }
        }
    });
}

}} // namespace cv::surgtrack
