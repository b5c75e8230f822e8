// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "detect/contrast.hpp"
#include "detect/qgo.hpp"

namespace cv { namespace surgtrack {

namespace {

const int tile = 128;    // [pixel]; smaller ones may lie within a tool, whose own edges then raise the threshold
const int block = 8;     // [pixel]; thresholds change from block to block
const int step = 4;      // of the pixels that are counted
const int prior = 64;    // pixels of the whole region that are counted with every tile: some have few of their own

} // namespace

// Sizes of 0 are of black surrounds and clipped highlights, not of texture.
void LocalThreshold::count(const Mat& sizes)
{
    counts_.assign(256 * size_t(tiles_.area()), 0);
    all_.assign(256, 0);
    for (int y = 0; y < sizes.rows; y += step)
    {
        const uchar* row = sizes.ptr(y);
        ushort* tiles = &counts_[256 * size_t(tiles_.width) * ((tl_.y + y) / tile - first_.y)];
        for (int x = 0; x < sizes.cols;)
        {
            ushort* counts = tiles + 256 * ((tl_.x + x) / tile - first_.x);
            const int end = std::min(sizes.cols, ((tl_.x + x) / tile + 1) * tile - tl_.x);
            for (; x < end; x += step) counts[row[x]]++;
        }
    }
    for (size_t i = 0; i < counts_.size(); i++) all_[i & 255] += counts_[i];
    all_[0] = total_ = 0;
    for (int i = 1; i < 256; i++) total_ += all_[i];
}

// Of a tile, or, without one, of the region.
double LocalThreshold::median(const ushort* counts) const
{
    const double share = double(prior) / total_;
    double left = prior / 2.;
    for (int i = 1; i < 256 && counts; i++) left += counts[i] / 2.;
    for (int i = 1; i < 256; i++)
    {
        const double here = share * all_[i] + (counts ? counts[i] : 0);
        if (here >= left) return i + left / here;
        left -= here;
    }
    return 255;
}

void LocalThreshold::measure(const Mat& sizes, Point tl, double ratio, double least, double most)
{
    tl_ = tl;
    first_ = Point(tl.x / tile, tl.y / tile);
    tiles_ = Size((tl.x + sizes.cols - 1) / tile - first_.x + 1, (tl.y + sizes.rows - 1) / tile - first_.y + 1);
    count(sizes);
    thresholds_.assign(tiles_.area(), float(most));
    if (!total_) return;   // black, or clipped
    const double ofRegion = median(0);
    for (int i = 0; i < tiles_.area(); i++)
        thresholds_[i] = float(std::min(std::max(ratio * std::min(median(&counts_[256 * size_t(i)]), ofRegion), least), most));
}

// The threshold at a place of the image.
int LocalThreshold::at(int x, int y) const
{
    const float u = std::min(std::max((x + 0.5f) / tile - 0.5f - first_.x, 0.f), float(tiles_.width - 1));
    const float v = std::min(std::max((y + 0.5f) / tile - 0.5f - first_.y, 0.f), float(tiles_.height - 1));
    const int i = int(u), j = int(v), right = i + 1 < tiles_.width, down = j + 1 < tiles_.height ? tiles_.width : 0;
    const float *t = &thresholds_[j * tiles_.width + i], a = u - i, b = v - j;
    return cvRound((1 - b) * ((1 - a) * t[0] + a * t[right]) + b * ((1 - a) * t[down] + a * t[down + right]));
}

void LocalThreshold::apply(Mat& orientations, const Mat& sizes)
{
    row_.resize(std::max(row_.size(), size_t(sizes.cols)));
    for (int y = 0; y < sizes.rows; y++)
    {
        const int py = tl_.y + y;
        if (y == 0 || py % block == 0)
            for (int x = 0; x < sizes.cols;)
            {
                const int bx = (tl_.x + x) / block, end = std::min((bx + 1) * block - tl_.x, sizes.cols);
                const uchar least = uchar(at(bx * block + block / 2, py / block * block + block / 2));
                for (; x < end; x++) row_[x] = least;
            }
        dropWeak(orientations.ptr(y), sizes.ptr(y), &row_[0], sizes.cols);
    }
}

}} // namespace cv::surgtrack
