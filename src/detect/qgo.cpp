// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/surgtrack/qgo.hpp"
#include "base/checks.hpp"
#include "base/memory.hpp"
#include "detect/qgo.hpp"
#include "detect/qgo.simd.hpp"
#include "detect/qgo.simd_declarations.hpp"   // defines CV_CPU_DISPATCH_MODES_ALL

// Integer arithmetic throughout, so that every implementation gives the same bits.
//   blurred   [1 4 7 8 7 4 1] / 32 each way, sigma 1.41: across, rounded to 4 x grey level, then down, to 16 x
//   gx, gy    3x3 Sobel of blurred, 16 x, at most 7650 in magnitude and less than 40 more by rounding
//   bin       direction modulo 180 degrees; its bounds are those of 1/5 and 2/3, 11.31 and 33.69 degrees

namespace cv { namespace surgtrack {

Mat keptImage(std::vector<uchar>& memory, const Size& size)
{
    memory.resize(roomFor(size.area(), memory.size()));
    return Mat(size, CV_8UC1, &memory[0]);
}

namespace plain {

// One channel of an area, blurred.
static void blur(const Mat& image, int channel, const Rect& area, Mat_<ushort>& blurred)
{
    static const int kernel[7] = {1, 4, 7, 8, 7, 4, 1};
    const int channels = image.channels();
    Mat_<ushort> across(area.height + 6, area.width);
    for (int y = 0; y < across.rows; y++)
    {
        const uchar* row = image.ptr(std::min(std::max(area.y + y - 3, 0), image.rows - 1)) + channel;
        for (int x = 0; x < across.cols; x++)
        {
            int sum = 4;
            for (int j = 0; j < 7; j++) sum += kernel[j] * row[channels * std::min(std::max(area.x + x + j - 3, 0), image.cols - 1)];
            across(y, x) = ushort(sum >> 3);
        }
    }
    blurred.create(area.size());
    for (int y = 0; y < area.height; y++)
        for (int x = 0; x < area.width; x++)
        {
            int sum = 4;
            for (int j = 0; j < 7; j++) sum += kernel[j] * across(y + j, x);
            blurred(y, x) = ushort(sum >> 3);
        }
}

static int orientationBin(int gx, int gy)
{
    const int ax = std::abs(gx), ay = std::abs(gy);
    const int bin = (5 * ay > ax) + (3 * ay > 2 * ax) + (2 * ay > 3 * ax) + (ay > 5 * ax);
    return (gx < 0) != (gy < 0) ? (8 - bin) & 7 : bin;
}

// The squared Sobel magnitude in grey levels, divided by 16; each square's fraction is cut off.
static int strength(int gx, int gy)
{
    return (16 * gx * gx >> 16) + (16 * gy * gy >> 16);
}

// About twice the Sobel magnitude in grey levels, 3 % too small to 7 % too large, at most 255.
static uchar byteSize(int gx, int gy)
{
    const int x = std::abs(gx), y = std::abs(gy);
    return uchar(std::min((std::max(x, y) + (3 * std::min(x, y) >> 3)) >> 3, 255));
}

void quantize(const Mat& image, const Rect& window, int leastStrength, Mat& orientations, Mat* sizes)
{
    // Sobel and vote reach one pixel each.
    const Rect area(window.x - 2, window.y - 2, window.width + 4, window.height + 4);
    Mat_<ushort> blurred[3];
    for (int c = 0; c < image.channels(); c++) blur(image, c, area, blurred[c]);

    const int w = window.width + 2, h = window.height + 2;
    Mat_<uchar> bins(h, w), strong(h, w);
    for (int y = 0; y < h; y++)
        for (int x = 0; x < w; x++)
        {
            int best = -1, gx = 0, gy = 0;
            for (int c = 0; c < image.channels(); c++)
            {
                const Mat_<ushort>& b = blurred[c];
                const int dx = (b(y, x + 2) + 2 * b(y + 1, x + 2) + b(y + 2, x + 2)) - (b(y, x) + 2 * b(y + 1, x) + b(y + 2, x));
                const int dy = (b(y + 2, x) + 2 * b(y + 2, x + 1) + b(y + 2, x + 2)) - (b(y, x) + 2 * b(y, x + 1) + b(y, x + 2));
                const int size = std::abs(dx) + std::abs(dy);
                if (size > best) best = size, gx = dx, gy = dy;
            }
            bins(y, x) = uchar(orientationBin(gx, gy));
            strong(y, x) = strength(gx, gy) >= leastStrength;
            if (sizes && Rect(1, 1, window.width, window.height).contains(Point(x, y))) sizes->at<uchar>(y - 1, x - 1) = byteSize(gx, gy);
        }

    for (int y = 0; y < window.height; y++)
        for (int x = 0; x < window.width; x++)
        {
            uchar result = 0;
            if (strong(y + 1, x + 1))
            {
                int votes[8] = {0};
                for (int j = 0; j < 9; j++) votes[bins(y + j / 3, x + j % 3)]++;
                for (int b = 0; b < 8; b++)
                    if (votes[b] >= 5) result = uchar(1 << b);
            }
            orientations.at<uchar>(y, x) = result;
        }
}

void dropWeak(uchar* bits, const uchar* sizes, const uchar* least, int n)
{
    for (int i = 0; i < n; i++)
        if (sizes[i] < least[i]) bits[i] = 0;
}

void spread(const Mat& src, Mat& dst, int size)
{
    const int r = size / 2;
    for (int y = 0; y < src.rows; y++)
        for (int x = 0; x < src.cols; x++)
        {
            uchar bits = 0;
            for (int j = std::max(0, y - r); j <= std::min(src.rows - 1, y + r); j++)
                for (int i = std::max(0, x - r); i <= std::min(src.cols - 1, x + r); i++) bits |= src.at<uchar>(j, i);
            dst.at<uchar>(y, x) = bits;
        }
}

void response(const Mat& bits, int bin, Mat& dst)
{
    const int same = 1 << bin, next = 1 << ((bin + 1) & 7) | 1 << ((bin + 7) & 7);
    for (int y = 0; y < bits.rows; y++)
        for (int x = 0; x < bits.cols; x++)
        {
            const int b = bits.at<uchar>(y, x);
            dst.at<uchar>(y, x) = b & same ? 4 : b & next ? 1 : 0;
        }
}

} // namespace plain

int leastStrength(double magnitudeThreshold)
{
    CV_Check(magnitudeThreshold, magnitudeThreshold >= 0 && magnitudeThreshold < 1e4, "magnitudeThreshold must be in 0..10000");
    return std::min(cvCeil(magnitudeThreshold * magnitudeThreshold / 16), int(SHRT_MAX));   // no gradient is that strong
}

void quantize(const Mat& image, const Rect& window, int leastStrength, Mat& orientations, std::vector<uchar>& workspace, Mat* sizes)
{
    CV_CPU_DISPATCH(quantizeKernel, (image, window, leastStrength, orientations, sizes, workspace), CV_CPU_DISPATCH_MODES_ALL);
}

void dropWeak(uchar* bits, const uchar* sizes, const uchar* least, int n)
{
    CV_CPU_DISPATCH(dropWeakKernel, (bits, sizes, least, n), CV_CPU_DISPATCH_MODES_ALL);
}

void spread(const Mat& src, Mat& dst, int size, std::vector<uchar>& workspace)
{
    CV_CPU_DISPATCH(spreadKernel, (src, dst, size, workspace), CV_CPU_DISPATCH_MODES_ALL);
}

void responses(const uchar* bits, size_t bitsStep, Size size, uchar* planes, size_t planeStep, size_t planeSize)
{
    CV_CPU_DISPATCH(responseKernel, (bits, bitsStep, size, planes, planeStep, planeSize), CV_CPU_DISPATCH_MODES_ALL);
}

void similarities(const uchar* planes, size_t step, const int* offsets, int features, Size window, ushort* sums)
{
    CV_CPU_DISPATCH(similarityKernel, (planes, step, offsets, features, window, sums), CV_CPU_DISPATCH_MODES_ALL);
}

void coarseResponses(const Mat& spread, Point tl, Size cells, uchar* planes, size_t planeStep, size_t planeSize, std::vector<uchar>& workspace)
{
    CV_CPU_DISPATCH(coarseKernel, (spread, tl, cells, planes, planeStep, planeSize, workspace), CV_CPU_DISPATCH_MODES_ALL);
}

int greatest(const ushort* values, int n)
{
    CV_CPU_DISPATCH(greatestKernel, (values, n), CV_CPU_DISPATCH_MODES_ALL);
}

int atLeast(const ushort* values, int n, int least, int* indices)
{
    CV_CPU_DISPATCH(atLeastKernel, (values, n, least, indices), CV_CPU_DISPATCH_MODES_ALL);
}

void cellSimilarities(const uchar* bits, size_t step, const CellFeature* features, int n, ushort* sums)
{
    CV_CPU_DISPATCH(cellKernel, (bits, step, features, n, sums), CV_CPU_DISPATCH_MODES_ALL);
}

void quantizeOrientations(InputArray _image, const Rect& window, OutputArray _orientations, double magnitudeThreshold)
{
    const Mat image = _image.getMat();
    checkImage(image);
    if (window.empty() || (window & Rect(Point(), image.size())) != window)
        CV_Error(Error::StsOutOfRange, format("window %d x %d at (%d, %d) does not lie in the image of %d x %d", window.width, window.height,
                                              window.x, window.y, image.cols, image.rows));
    _orientations.create(window.size(), CV_8UC1);
    Mat orientations = _orientations.getMat();
    std::vector<uchar> workspace;
    quantize(image, window, leastStrength(magnitudeThreshold), orientations, workspace);
}

void quantizeOrientations(InputArray image, OutputArray orientations, double magnitudeThreshold)
{
    quantizeOrientations(image, Rect(Point(), image.size()), orientations, magnitudeThreshold);
}

void spreadOrientations(InputArray _orientations, OutputArray _spread, int size)
{
    const Mat orientations = _orientations.getMat();
    CV_CheckTypeEQ(orientations.type(), CV_8UC1, "orientations are bit sets of 8 bits");
    CV_Check(size, size > 0 && size % 2 == 1, "size must be odd and positive");
    Mat result(orientations.size(), CV_8UC1);   // not in place
    std::vector<uchar> workspace;
    spread(orientations, result, size, workspace);
    result.copyTo(_spread);
}

void orientationResponse(InputArray _spread, int bin, OutputArray _response)
{
    const Mat bits = _spread.getMat();
    CV_CheckTypeEQ(bits.type(), CV_8UC1, "spread orientations are bit sets of 8 bits");
    CV_Check(bin, bin >= 0 && bin < 8, "bin must be 0..7");
    _response.create(bits.size(), CV_8UC1);
    Mat response = _response.getMat();
    plain::response(bits, bin, response);
}

}} // namespace cv::surgtrack
