// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "detect/image_state.hpp"

namespace cv { namespace surgtrack {

namespace {

const int spacing = 8;             // of samples [pixel]

const int surroundBlock = 8, surroundStep = 2;   // [pixel]
const int darkest = 6;             // video black with what a codec leaves of the picture beside it [grey levels]
const int surroundMargin = 2;      // blocks about a surround that hold its border, and the blur of gradients
const int looksApart = 32;         // images from one look for a surround to the next
const double leastSurround = 0.03; // of the image: a pillar of 20 pixels; less is vignetting in the corners

} // namespace

static Size blocksOf(const Size& image)
{
    return Size((image.width + surroundBlock - 1) / surroundBlock, (image.height + surroundBlock - 1) / surroundBlock);
}

void VisibleRegion::setMask(const Mat& mask)
{
    const Size blocks = blocksOf(mask.size());
    masked_.assign(blocks.area(), 0);
    for (int y = 0; y < mask.rows; y++)
        for (int x = 0; x < mask.cols; x++)
            if (!mask.at<uchar>(y, x)) masked_[size_t(y / surroundBlock) * blocks.width + x / surroundBlock] = 1;
    looks_ = 0;
}

// All samples of all channels of a block.
void VisibleRegion::findSurround(const Mat& image, std::vector<uchar>& dark)
{
    const int channels = image.channels();
    dark.assign(blocks_.area(), 1);
    for (int y = 0; y < image.rows; y += surroundStep)
    {
        const uchar* row = image.ptr(y);
        uchar* blocks = &dark[size_t(y / surroundBlock) * blocks_.width];
        for (int x = 0; x < image.cols; x += surroundStep)
            for (int c = 0; c < channels; c++)
                if (row[x * channels + c] > darkest) blocks[x / surroundBlock] = 0;
    }
    keepConnected(dark);
}

// Surrounds reach the border of the image; shadows do not, as a rule.
void VisibleRegion::keepConnected(std::vector<uchar>& dark)
{
    kept_.assign(dark.size(), 0);
    open_.clear();
    for (int y = 0; y < blocks_.height; y++)
        for (int x = 0; x < blocks_.width; x++)
            if (y == 0 || x == 0 || y == blocks_.height - 1 || x == blocks_.width - 1) open_.push_back(Point(x, y));
    int count = 0;
    while (!open_.empty())
    {
        const Point p = open_.back();
        open_.pop_back();
        if (!Rect(Point(), blocks_).contains(p)) continue;
        const size_t i = size_t(p.y) * blocks_.width + p.x;
        if (!dark[i] || kept_[i]) continue;
        kept_[i] = 1;
        count++;
        open_.push_back(p + Point(1, 0));
        open_.push_back(p - Point(1, 0));
        open_.push_back(p + Point(0, 1));
        open_.push_back(p - Point(0, 1));
    }
    // An image that is all black is no surround: the light is off.
    if (count < leastSurround * blocks_.area() || count == blocks_.area()) std::fill(kept_.begin(), kept_.end(), uchar(0));
    dark.swap(kept_);
}

// What was dark at both of the last looks, and what the mask hides, with a margin.
void VisibleRegion::combine()
{
    found_.swap(hidden_);   // as it was
    hidden_.assign(both_.size(), 0);
    partial_ = false;
    for (int y = 0; y < blocks_.height; y++)
        for (int x = 0; x < blocks_.width; x++)
        {
            const size_t i = size_t(y) * blocks_.width + x;
            if (!both_[i] && !(i < masked_.size() && masked_[i])) continue;
            partial_ = true;
            for (int v = std::max(0, y - surroundMargin); v <= std::min(blocks_.height - 1, y + surroundMargin); v++)
                for (int u = std::max(0, x - surroundMargin); u <= std::min(blocks_.width - 1, x + surroundMargin); u++)
                    hidden_[size_t(v) * blocks_.width + u] = 1;
        }
    changes_ += found_ != hidden_;
}

void VisibleRegion::look(const Mat& image)
{
    if (image.size() != size_)
    {
        size_ = image.size();
        blocks_ = blocksOf(size_);
        looks_ = 0;
    }
    if (looks_++ % looksApart) return;
    findSurround(image, found_);
    both_ = found_;
    if (looks_ > 1)
        for (size_t i = 0; i < both_.size(); i++) both_[i] = both_[i] && dark_[i];
    dark_.swap(found_);
    combine();
}

bool VisibleRegion::sees(const Point2d& p) const
{
    if (!partial_) return true;
    const int x = cvFloor(p.x) / surroundBlock, y = cvFloor(p.y) / surroundBlock;
    return p.x >= 0 && p.y >= 0 && x < blocks_.width && y < blocks_.height && !hidden_[size_t(y) * blocks_.width + x];
}

bool VisibleRegion::seesAll(const Rect2d& area) const
{
    if (!partial_) return true;
    const int left = cvFloor(area.x) / surroundBlock, right = cvFloor(area.x + area.width) / surroundBlock;
    const int top = cvFloor(area.y) / surroundBlock, bottom = cvFloor(area.y + area.height) / surroundBlock;
    if (area.x < 0 || area.y < 0 || right >= blocks_.width || bottom >= blocks_.height) return false;
    for (int y = top; y <= bottom; y++)
        for (int x = left; x <= right; x++)
            if (hidden_[size_t(y) * blocks_.width + x]) return false;
    return true;
}

void VisibleRegion::paint(Mat& mask, double factor) const
{
    mask.setTo(Scalar::all(255));
    // The first pixel of the mask that lies in a block, or beyond it.
    const auto first = [&](int block) { return std::max(0, cvCeil((block * surroundBlock + 0.5) / factor - 0.5)); };
    for (int y = 0; y < blocks_.height; y++)
        for (int x = 0; x < blocks_.width; x++)
        {
            if (!hidden_[size_t(y) * blocks_.width + x]) continue;
            const Rect block(Point(first(x), first(y)), Point(first(x + 1), first(y + 1)));
            mask(block & Rect(Point(), mask.size())).setTo(Scalar::all(0));
        }
}

void ImageSamples::look(const Mat& image, int reduction)
{
    spacing_ = spacing * reduction;
    const int channels = image.channels(), channel = channels / 2;
    const Size grid((image.cols + spacing_ - 1) / spacing_, (image.rows + spacing_ - 1) / spacing_);
    std::swap(now_, before_);
    if (grid != grid_) before_.clear();
    grid_ = grid;
    now_.resize(grid.area());
    for (int y = 0; y < grid.height; y++)
        for (int x = 0; x < grid.width; x++) now_[size_t(y) * grid.width + x] = image.ptr(y * spacing_)[x * spacing_ * channels + channel];
}

double ImageSamples::change(const Rect& region) const
{
    const Rect cells = Rect(region.x / spacing_, region.y / spacing_, region.width / spacing_ + 1, region.height / spacing_ + 1) & Rect(Point(), grid_);
    if (before_.empty() || cells.empty()) return DBL_MAX;
    int sum = 0;
    for (int y = cells.y; y < cells.y + cells.height; y++)
        for (int x = cells.x; x < cells.x + cells.width; x++)
            sum += std::abs(now_[size_t(y) * grid_.width + x] - before_[size_t(y) * grid_.width + x]);
    return double(sum) / cells.area();
}

}} // namespace cv::surgtrack
