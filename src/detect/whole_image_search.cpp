// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "detect/whole_image_search.hpp"

namespace cv { namespace surgtrack {

Rect reachOf(const PartTemplate& t)
{
    int left = 0, right = 0, top = 0, bottom = 0;
    for (size_t i = 0; i < t.features.size(); i++)
    {
        const TemplateFeature& f = t.features[i];
        left = std::min(left, int(f.x));
        right = std::max(right, int(f.x));
        top = std::min(top, int(f.y));
        bottom = std::max(bottom, int(f.y));
    }
    return Rect(left, top, right - left, bottom - top);
}

void CellMap::zero(Found& found, const Rect& area) const
{
    const Point tl = place(found.cell);
    const Rect common = (area - tl) & Rect(0, 0, 4, 4);
    for (int y = common.y; y < common.y + common.height; y++)
        for (int x = common.x; x < common.x + common.width; x++) found.sums[4 * y + x] = 0;
    found.best = most(found);
}

// Fills a cell, and returns the best of its places.
int CellMap::evaluate(int cell)
{
    if (slots_[cell]) return found_[slots_[cell] - 1].best;
    found_.resize(found_.size() + 1);
    Found& found = found_.back();
    found.cell = cell;
    slots_[cell] = int(found_.size());
    const Point tl = place(cell);
    const Rect reach = reach_ + tl;
    if ((reach & roi_) == reach && tl.x + 4 <= size_.width && tl.y + 4 <= size_.height)
        cellSimilarities(spread_.ptr(reach.y - roi_.y) + reach.x - roi_.x, spread_.step, &features_[0], int(features_.size()), found.sums);
    else
    {
        std::fill(found.sums, found.sums + 16, ushort(0));
        for (size_t i = 0; i < features_.size(); i++)
        {
            const TemplateFeature& f = template_->features[i];
            const Rect seen = (Rect(tl, Size(4, 4)) & Rect(Point(), size_)) & (roi_ - Point(f.x, f.y));
            for (int y = seen.y; y < seen.y + seen.height; y++)
                for (int x = seen.x; x < seen.x + seen.width; x++)
                {
                    const int bits = spread_.at<uchar>(y + f.y - roi_.y, x + f.x - roi_.x);
                    ushort& sum = found.sums[4 * (y - tl.y) + x - tl.x];
                    sum = ushort(sum + (bits & features_[i].same ? 4 : bits & features_[i].wide ? 1 : 0));
                }
        }
    }
    found.best = most(found);
    for (size_t i = 0; i < suppressed_.size(); i++) zero(found, suppressed_[i]);
    return found.best;
}

// The best place, of equal ones the first, row by row.
bool CellMap::best(int& similarity, Point& at) const
{
    similarity = 0;
    for (size_t i = 0; i < found_.size(); i++)
    {
        const Found& found = found_[i];
        if (found.best == 0 || found.best < similarity) continue;
        const int k = int(std::find(found.sums, found.sums + 16, found.best) - found.sums);
        const Point p = place(found.cell) + Point(k & 3, k >> 2);
        if (found.best > similarity || p.y < at.y || (p.y == at.y && p.x < at.x)) at = p;
        similarity = found.best;
    }
    return similarity > 0;
}

void CellMap::suppress(const Rect& area)
{
    suppressed_.push_back(area);
    for (size_t i = 0; i < found_.size(); i++)
        if (!(Rect(place(found_[i].cell), Size(4, 4)) & area).empty()) zero(found_[i], area);
}

void WholeImageSearch::prepare(const Size& image, const Mat& spread, const Rect& roi, const std::vector<PartTemplate>& templates)
{
    int reach = 0;
    for (size_t i = 0; i < templates.size(); i++)
    {
        const Rect r = reachOf(templates[i]);
        reach = std::max(std::max(reach, std::max(-r.x, -r.y)), std::max(r.x + r.width, r.y + r.height));
    }
    // A feature further away than the image is wide and high never lies in it, wherever the keypoint does.
    const int margin = std::min(reach, std::max(image.width, image.height)) / 4 + 3;
    const Size cells((image.width + 3) / 4, (image.height + 3) / 4);
    const size_t step = cells.width + 2 * margin, planeSize = step * (cells.height + 2 * margin) + overrun;
    if (ready_ && margin <= margin_) return;
    ready_ = true;
    if (margin > margin_ || step_ != cells.width + 2 * size_t(margin_) || planeSize_ != step_ * (cells.height + 2 * margin_) + overrun)
    {
        margin_ = margin;
        step_ = step;
        planeSize_ = planeSize;
        CV_CheckLT(8 * planeSize, size_t(INT_MAX), "the image is too large, windows are needed");
        planes_.assign(8 * planeSize + overrun, 0);
        cellIndices_.resize(cells.area());
        bounds_.resize(std::max(bounds_.size(), size_t(cells.area())));
    }
    cellMap_.setImage(image, spread, roi);
    if (!roi.empty())
        coarseResponses(spread, roi.tl(), cells, &planes_[0] + (margin_ - 2) * (step_ + 1), step_, planeSize_, workspace_);
    else std::fill(planes_.begin(), planes_.end(), uchar(0));
}

/* Fills the cells of the whole image that can hold a candidate, the most promising first. A cell's coarse similarity bounds
   that of its places, so the best place of the image is in a filled cell as soon as it beats the bounds of all others. */
CellMap& WholeImageSearch::search(const PartTemplate& t, const QGOMatcher::Params& params)
{
    const int enough = 8 * params.candidates, most = 8192;   // cells, for the further candidates and for the best
    const Size cells = cellMap_.cells();
    cellMap_.setTemplate(t);
    offsets_.clear();
    for (size_t i = 0; i < t.features.size(); i++)
    {
        const TemplateFeature& f = t.features[i];
        if (std::abs(int(f.x)) >= 4 * margin_ - 4 || std::abs(int(f.y)) >= 4 * margin_ - 4) continue;
        offsets_.push_back(int(f.bin * planeSize_ + (f.y >> 2) * (ptrdiff_t)step_) + (f.x >> 2));   // rounded down
    }
    if (offsets_.empty()) return cellMap_;
    bounds_.resize(std::max(bounds_.size(), size_t(cells.area())));
    similarities(&planes_[0] + margin_ * (step_ + 1), step_, &offsets_[0], int(offsets_.size()), cells, &bounds_[0]);

    const ushort* bounds = &bounds_[0];
    double weakest = std::max(1., params.minSimilarity * 4. * double(t.features.size()));
    int best = 0, evaluated = 0;
    // What the most promising cell holds makes the list of the others shorter.
    const int greatestBound = greatest(bounds, cells.area());
    if (greatestBound < weakest) return cellMap_;
    for (int pass = 0; pass < 2; pass++)
    {
        const int count = atLeast(bounds, cells.area(), pass == 0 ? greatestBound : cvCeil(weakest), &cellIndices_[0]);
        queue_.resize(count);
        for (int i = 0; i < count; i++) queue_[i] = uint64(bounds[cellIndices_[i]]) << 32 | (0xffffffffu - unsigned(cellIndices_[i]));
        std::make_heap(queue_.begin(), queue_.end());
        while (!queue_.empty() && evaluated < most)
        {
            const int bound = int(queue_.front() >> 32);
            if (bound < weakest || (bound < best && evaluated >= enough)) break;
            best = std::max(best, cellMap_.evaluate(int(0xffffffffu - unsigned(queue_.front()))));
            weakest = std::max(weakest, params.relativeSimilarity * best);
            evaluated++;
            std::pop_heap(queue_.begin(), queue_.end());
            queue_.pop_back();
        }
    }
    return cellMap_;
}

}} // namespace cv::surgtrack
