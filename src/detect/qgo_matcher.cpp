// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "detect/qgo.hpp"
#include "detect/contrast.hpp"

namespace cv { namespace surgtrack {

PartMatch::PartMatch() : tool(0), part(0), similarity(0), templateIndex(0) {}

QGOMatcher::Params::Params()
    : magnitudeThreshold(50), contrast(1.5), leastMagnitude(8), spread(5), candidates(5), suppressionRadius(6), minSimilarity(0.5), relativeSimilarity(0.7)
{
}

namespace {

// Similarities of all places of a window.
class DenseMap
{
public:
    DenseMap(ushort* sums, const Size& size) : map_(size.height, size.width, sums) {}
    Size size() const { return map_.size(); }
    int operator()(int y, int x) const { return map_(y, x); }
    bool best(int& similarity, Point& at) const
    {
        double most;
        minMaxLoc(map_, 0, &most, 0, &at);
        similarity = int(most);
        return most > 0;
    }
    void suppress(const Rect& area) { map_(area).setTo(0); }

private:
    Mat_<ushort> map_;
};

/* Similarities of the places of an image, 4 x 4 at a time, where they are asked for. Cells and their slots are kept from
   template to template, clear() forgets what was found. */
class CellMap
{
public:
    void setImage(const Size& image, const Mat& spread, const Rect& roi)
    {
        clear();
        size_ = image;
        spread_ = spread;
        roi_ = roi;
        cells_ = Size((image.width + 3) / 4, (image.height + 3) / 4);
        if (slots_.size() < size_t(cells_.area())) slots_.resize(cells_.area(), 0);
    }
    void setTemplate(const PartTemplate& t)
    {
        clear();
        template_ = &t;
        features_.resize(t.features.size());
        Point low(SHRT_MAX, SHRT_MAX), high(SHRT_MIN, SHRT_MIN);
        for (size_t i = 0; i < features_.size(); i++)
        {
            const TemplateFeature& f = t.features[i];
            low = Point(std::min(low.x, int(f.x)), std::min(low.y, int(f.y)));
            high = Point(std::max(high.x, int(f.x)), std::max(high.y, int(f.y)));
            features_[i].offset = int(f.y * (ptrdiff_t)spread_.step) + f.x;
            features_[i].same = uchar(1 << f.bin);
            features_[i].wide = uchar(1 << f.bin | 1 << ((f.bin + 1) & 7) | 1 << ((f.bin + 7) & 7));
        }
        reach_ = Rect(low, high + Point(4, 4));   // of a cell's 4 x 4 places
    }
    void clear()
    {
        for (size_t i = 0; i < found_.size(); i++) slots_[found_[i].cell] = 0;
        found_.clear();
        suppressed_.clear();
    }

    Size cells() const { return cells_; }
    int evaluate(int cell);
    Size size() const { return size_; }
    int operator()(int y, int x)
    {
        const int cell = (y >> 2) * cells_.width + (x >> 2);
        if (!slots_[cell]) evaluate(cell);
        return found_[slots_[cell] - 1].sums[(y & 3) * 4 + (x & 3)];
    }
    bool best(int& similarity, Point& at) const;
    void suppress(const Rect& area);

private:
    struct Found
    {
        int cell, best;
        ushort sums[16];
    };

    Point place(int cell) const { return Point(cell % cells_.width * 4, cell / cells_.width * 4); }
    void zero(Found& found, const Rect& area) const;
    static int most(const Found& found) { return *std::max_element(found.sums, found.sums + 16); }

    Size size_, cells_;
    Mat spread_;
    Rect roi_, reach_;
    const PartTemplate* template_;
    std::vector<CellFeature> features_;
    std::vector<int> slots_;      // of each cell: 1 + its place in found_, or 0
    std::vector<Found> found_;
    std::vector<Rect> suppressed_;
};

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
        cellSimilarities(spread_.ptr(tl.y - roi_.y) + tl.x - roi_.x, spread_.step, &features_[0], int(features_.size()), found.sums);
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

class QGOMatcherImpl CV_FINAL : public QGOMatcher
{
public:
    explicit QGOMatcherImpl(const Params& params) : params_(params), step_(0), planeSize_(0), coarseReady_(false), coarseMargin_(0), coarseStep_(0), coarsePlaneSize_(0)
    {
        CV_Check(params.contrast, params.contrast >= 0 && params.contrast < DBL_MAX, "Params::contrast must not be negative");
        CV_Check(params.leastMagnitude, params.leastMagnitude >= 0 && params.leastMagnitude < DBL_MAX, "Params::leastMagnitude must not be negative");
        if (params.contrast > 0) CV_CheckLE(params.magnitudeThreshold, 127., "Params::magnitudeThreshold: more goes without contrast only");
        CV_Check(params.spread, params.spread > 0 && params.spread % 2 == 1, "Params::spread must be odd and positive");
        CV_CheckGT(params.candidates, 0, "Params::candidates must be positive");
        CV_CheckGE(params.suppressionRadius, 0, "Params::suppressionRadius must not be negative");
    }

    void setImage(InputArray image, const Rect& roi) CV_OVERRIDE;
    void match(const std::vector<PartTemplate>& templates, const std::vector<Rect>& windows, std::vector<PartMatch>& matches) CV_OVERRIDE;
    void similarityMap(const PartTemplate& partTemplate, const Rect& window, OutputArray similarity) CV_OVERRIDE;
    void orientations(OutputArray result) const CV_OVERRIDE
    {
        CV_Assert(!imageSize_.empty() && "setImage() comes first");
        if (roi_.empty()) result.release();
        else orientations_.copyTo(result);
    }

private:
    void prepareResponses(const Rect& needed);
    void prepareCoarse(const std::vector<PartTemplate>& templates);
    void similarity(const PartTemplate& t, const Rect& window);
    void search(const PartTemplate& t);
    template <typename Map> void selectCandidates(Map& map, const PartTemplate& t, int templateIndex, const Rect& window);

    Params params_;
    Size imageSize_;
    Rect roi_;                     // what is prepared
    std::vector<uchar> orientationMemory_, spreadMemory_, sizeMemory_;
    LocalThreshold threshold_;
    Mat orientations_, spread_;    // views of it
    std::vector<uchar> workspace_;
    // Eight maps of the responses 4, 1, 0 for windows; zeros where they cover more than roi_, which features beyond it fall on.
    Rect covered_;
    size_t step_, planeSize_;
    std::vector<uchar> planes_;
    std::vector<int> offsets_;
    std::vector<ushort> similarity_;
    // For the whole image: upper bounds of 4 x 4 places each, with a margin of empty cells; see coarseResponses().
    bool coarseReady_;
    int coarseMargin_;
    size_t coarseStep_, coarsePlaneSize_;
    std::vector<uchar> coarse_;
    std::vector<int> cellIndices_;
    std::vector<uint64> queue_;
    CellMap cellMap_;
    // Of all templates, in the order found, and by falling similarity.
    std::vector<PartMatch> found_;
    std::vector<std::pair<double, int> > order_;
};

const int overrun = 64;   // a row of a kernel may

// Offsets of a template's features from its keypoint.
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

Rect reachIn(const PartTemplate& t, const Rect& window)
{
    const Rect reach = reachOf(t);
    return Rect(window.x + reach.x, window.y + reach.y, window.width + reach.width, window.height + reach.height);
}

void QGOMatcherImpl::setImage(InputArray _image, const Rect& roi)
{
    const Mat image = _image.getMat();
    checkImage(image);
    const Rect all(Point(), image.size());
    imageSize_ = image.size();
    roi_ = roi.empty() ? all : roi & all;
    covered_ = Rect();
    coarseReady_ = false;
    if (roi_.empty()) return;
    orientations_ = keptImage(orientationMemory_, roi_.size());
    spread_ = keptImage(spreadMemory_, roi_.size());
    const double least = std::min(params_.leastMagnitude, params_.magnitudeThreshold);
    if (params_.contrast > 0)
    {
        Mat sizes = keptImage(sizeMemory_, roi_.size());
        quantize(image, roi_, leastStrength(least), orientations_, workspace_, &sizes);
        threshold_.measure(sizes, roi_.tl(), params_.contrast, 2 * least, 2 * params_.magnitudeThreshold);
        threshold_.apply(orientations_, sizes);
    }
    else quantize(image, roi_, leastStrength(params_.magnitudeThreshold), orientations_, workspace_);
    spread(orientations_, spread_, params_.spread, workspace_);
}

// Response maps of an area that may reach beyond the region.
void QGOMatcherImpl::prepareResponses(const Rect& needed)
{
    // Half a template's box, and some more; a window far larger than the region goes without.
    const int margin = std::max(96, imageSize_.width / 7);
    const Rect area = needed & Rect(roi_.x - margin, roi_.y - margin, roi_.width + 2 * margin, roi_.height + 2 * margin);
    if (area.empty() || (area & covered_) == area) return;
    covered_ = area;
    step_ = alignSize(covered_.width, 64);
    planeSize_ = step_ * covered_.height + overrun;
    CV_CheckLT(8 * planeSize_, size_t(INT_MAX), "the image is too large, a roi is needed");
    if (planes_.size() < 8 * planeSize_) planes_.resize(8 * planeSize_);
    const Rect inside = covered_ & roi_;
    const int left = inside.empty() ? covered_.width : inside.x - covered_.x, right = left + inside.width;
    for (int bin = 0; bin < 8; bin++)
        for (int y = 0; y < covered_.height; y++)
        {
            uchar* row = &planes_[0] + bin * planeSize_ + y * step_;
            const bool empty = covered_.y + y < inside.y || covered_.y + y >= inside.y + inside.height;
            if (empty) std::fill(row, row + covered_.width, uchar(0));
            else
            {
                std::fill(row, row + left, uchar(0));
                std::fill(row + right, row + covered_.width, uchar(0));
            }
        }
    if (!inside.empty())
        responses(spread_.ptr(inside.y - roi_.y) + inside.x - roi_.x, spread_.step, inside.size(), &planes_[0] + (inside.y - covered_.y) * step_ + left, step_, planeSize_);
}

// Sums the responses of all features for every place of the keypoint in the window.
void QGOMatcherImpl::similarity(const PartTemplate& t, const Rect& window)
{
    similarity_.resize(window.area());
    const Rect reach = reachIn(t, window);
    if ((reach & covered_) == reach)
    {
        offsets_.clear();
        for (size_t i = 0; i < t.features.size(); i++)
            offsets_.push_back(int(t.features[i].bin * planeSize_ + t.features[i].y * (ptrdiff_t)step_) + t.features[i].x);
        similarities(&planes_[0] + (window.y - covered_.y) * (ptrdiff_t)step_ + (window.x - covered_.x), step_, &offsets_[0], int(offsets_.size()),
                     window.size(), &similarity_[0]);
        return;
    }
    // A window far larger than the prepared region: feature by feature, where it is covered.
    std::fill(similarity_.begin(), similarity_.end(), ushort(0));
    for (size_t i = 0; i < t.features.size(); i++)
    {
        const TemplateFeature& f = t.features[i];
        const Rect seen = (window + Point(f.x, f.y)) & roi_;
        const int same = 1 << f.bin, next = 1 << ((f.bin + 1) & 7) | 1 << ((f.bin + 7) & 7);
        for (int y = seen.y; y < seen.y + seen.height; y++)
        {
            const uchar* src = spread_.ptr(y - roi_.y) + seen.x - roi_.x;
            ushort* dst = &similarity_[0] + (y - f.y - window.y) * window.width + seen.x - f.x - window.x;
            for (int x = 0; x < seen.width; x++) dst[x] = ushort(dst[x] + (src[x] & same ? 4 : src[x] & next ? 1 : 0));
        }
    }
}

void QGOMatcherImpl::similarityMap(const PartTemplate& t, const Rect& window, OutputArray result)
{
    CV_Assert(!imageSize_.empty() && "setImage() comes first");
    CV_Assert(!window.empty());
    CV_Check(t.features.size(), !t.features.empty() && t.features.size() <= 65535 / 4, "partTemplate needs 1..16383 features");
    prepareResponses(reachIn(t, window));
    similarity(t, window);
    Mat(window.size(), CV_16UC1, &similarity_[0]).copyTo(result);
}

// Coarse responses with a margin that the templates fit into.
void QGOMatcherImpl::prepareCoarse(const std::vector<PartTemplate>& templates)
{
    int reach = 0;
    for (size_t i = 0; i < templates.size(); i++)
    {
        const Rect r = reachOf(templates[i]);
        reach = std::max(std::max(reach, std::max(-r.x, -r.y)), std::max(r.x + r.width, r.y + r.height));
    }
    // A feature further away than the image is wide and high never lies in it, wherever the keypoint does.
    const int margin = std::min(reach, std::max(imageSize_.width, imageSize_.height)) / 4 + 3;
    const Size cells((imageSize_.width + 3) / 4, (imageSize_.height + 3) / 4);
    const size_t step = cells.width + 2 * margin, planeSize = step * (cells.height + 2 * margin) + overrun;
    if (coarseReady_ && margin <= coarseMargin_) return;
    coarseReady_ = true;
    if (margin > coarseMargin_ || coarseStep_ != cells.width + 2 * size_t(coarseMargin_) || coarsePlaneSize_ != coarseStep_ * (cells.height + 2 * coarseMargin_) + overrun)
    {
        coarseMargin_ = margin;
        coarseStep_ = step;
        coarsePlaneSize_ = planeSize;
        CV_CheckLT(8 * planeSize, size_t(INT_MAX), "the image is too large, windows are needed");
        coarse_.assign(8 * planeSize + overrun, 0);
        cellIndices_.resize(cells.area());
        similarity_.resize(std::max(similarity_.size(), size_t(cells.area())));
    }
    cellMap_.setImage(imageSize_, spread_, roi_);
    if (!roi_.empty())
        coarseResponses(spread_, roi_.tl(), cells, &coarse_[0] + (coarseMargin_ - 2) * (coarseStep_ + 1), coarseStep_, coarsePlaneSize_, workspace_);
    else std::fill(coarse_.begin(), coarse_.end(), uchar(0));
}

/* Fills the cells of the whole image that can hold a candidate, the most promising first. A cell's coarse similarity bounds
   that of its places, so the best place of the image is in a filled cell as soon as it beats the bounds of all others. */
void QGOMatcherImpl::search(const PartTemplate& t)
{
    const int enough = 8 * params_.candidates, most = 8192;   // cells, for the further candidates and for the best
    const Size cells = cellMap_.cells();
    cellMap_.setTemplate(t);
    offsets_.clear();
    for (size_t i = 0; i < t.features.size(); i++)
    {
        const TemplateFeature& f = t.features[i];
        if (std::abs(int(f.x)) >= 4 * coarseMargin_ - 4 || std::abs(int(f.y)) >= 4 * coarseMargin_ - 4) continue;
        offsets_.push_back(int(f.bin * coarsePlaneSize_ + (f.y >> 2) * (ptrdiff_t)coarseStep_) + (f.x >> 2));   // rounded down
    }
    if (offsets_.empty()) return;
    similarity_.resize(std::max(similarity_.size(), size_t(cells.area())));
    similarities(&coarse_[0] + coarseMargin_ * (coarseStep_ + 1), coarseStep_, &offsets_[0], int(offsets_.size()), cells, &similarity_[0]);

    const ushort* bounds = &similarity_[0];
    double weakest = std::max(1., params_.minSimilarity * 4. * double(t.features.size()));
    int best = 0, evaluated = 0;
    // What the most promising cell holds makes the list of the others shorter.
    const int greatestBound = greatest(bounds, cells.area());
    if (greatestBound < weakest) return;
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
            weakest = std::max(weakest, params_.relativeSimilarity * best);
            evaluated++;
            std::pop_heap(queue_.begin(), queue_.end());
            queue_.pop_back();
        }
    }
}

// The best places, each suppressing its neighbourhood.
template <typename Map> void QGOMatcherImpl::selectCandidates(Map& map, const PartTemplate& t, int templateIndex, const Rect& window)
{
    const double full = 4. * double(t.features.size());
    double weakest = params_.minSimilarity * full;
    const int r = params_.suppressionRadius, reach = params_.spread / 2 + 1;
    for (int k = 0; k < params_.candidates; k++)
    {
        int best;
        Point at;
        if (!map.best(best, at) || best < weakest) return;
        if (k == 0) weakest = std::max(weakest, params_.relativeSimilarity * best);

        // Spreading flattens peaks, and the best place is the first of a plateau: the centre of mass of the top, sought from there.
        const double floor = best - std::max(1., 0.04 * full);
        Point2d centre(at);
        for (int pass = 0; pass < 3; pass++)
        {
            const Rect around = Rect(cvRound(centre.x) - reach, cvRound(centre.y) - reach, 2 * reach + 1, 2 * reach + 1) & Rect(Point(), map.size());
            double sum = 0;
            Point2d moment;
            for (int y = around.y; y < around.y + around.height; y++)
                for (int x = around.x; x < around.x + around.width; x++)
                {
                    const double weight = std::max(0., map(y, x) - floor);
                    sum += weight;
                    moment += weight * Point2d(x, y);
                }
            if (sum > 0) centre = moment * (1 / sum);
        }

        PartMatch m;
        m.tool = t.tool;
        m.part = t.part;
        m.templateIndex = templateIndex;
        m.similarity = best / full;
        m.predictedPoint = t.imagePoint;
        // The template was cut around the anchor, the keypoint lies a fraction beside it.
        m.imagePoint = Point2d(window.tl()) + centre + (t.imagePoint - Point2d(t.anchor));
        found_.push_back(m);

        map.suppress(Rect(at.x - r, at.y - r, 2 * r + 1, 2 * r + 1) & Rect(Point(), map.size()));
    }
}

// By falling similarity, equal ones in the order found.
inline bool before(const std::pair<double, int>& a, const std::pair<double, int>& b)
{
    return a.first > b.first || (a.first == b.first && a.second < b.second);
}

void QGOMatcherImpl::match(const std::vector<PartTemplate>& templates, const std::vector<Rect>& windows, std::vector<PartMatch>& matches)
{
    CV_Assert(!imageSize_.empty() && "setImage() comes first");
    CV_Check(windows.size(), windows.empty() || windows.size() == templates.size(), "windows: one per template, or none");
    found_.clear();
    const Rect all(Point(), imageSize_);
    Rect needed;
    bool anyWhole = false;
    for (size_t i = 0; i < templates.size(); i++)
    {
        CV_CheckLE(templates[i].features.size(), size_t(65535 / 4), "too many features in a template");
        const Rect window = windows.empty() ? all : windows[i] & all;
        if (window == all) anyWhole = true;
        else if (!window.empty() && !templates[i].features.empty()) needed |= reachIn(templates[i], window);
    }
    if (anyWhole) prepareCoarse(templates);
    prepareResponses(needed);
    for (size_t i = 0; i < templates.size(); i++)
    {
        const PartTemplate& t = templates[i];
        const Rect window = windows.empty() ? all : windows[i] & all;
        if (window.empty() || t.features.empty()) continue;
        if (window == all)
        {
            search(t);
            selectCandidates(cellMap_, t, int(i), all);
            continue;
        }
        similarity(t, window);
        DenseMap map(&similarity_[0], window.size());
        selectCandidates(map, t, int(i), window);
    }
    order_.resize(found_.size());
    for (size_t i = 0; i < found_.size(); i++) order_[i] = std::make_pair(found_[i].similarity, int(i));
    std::sort(order_.begin(), order_.end(), before);
    matches.resize(found_.size());
    for (size_t i = 0; i < found_.size(); i++) matches[i] = found_[order_[i].second];
}

} // namespace

Ptr<QGOMatcher> QGOMatcher::create(const Params& params)
{
    return makePtr<QGOMatcherImpl>(params);
}

}} // namespace cv::surgtrack
