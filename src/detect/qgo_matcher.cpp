// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/surgtrack/qgo_matcher.hpp"
#include "base/checks.hpp"
#include "detect/qgo.hpp"
#include "detect/contrast.hpp"
#include "detect/whole_image_search.hpp"

namespace cv { namespace surgtrack {

QGOMatcher::Params::Params()
    : magnitudeThreshold(50), contrast(1.5), leastMagnitude(8), spread(5), candidates(5), suppressionRadius(6), minSimilarity(0.5), relativeSimilarity(0.7)
{
}

namespace {

// Similarities of all places of a window, with the greatest of each row.
class DenseMap
{
public:
    DenseMap(ushort* sums, const Size& size, std::vector<ushort>& rows) : map_(size.height, size.width, sums), rows_(rows)
    {
        rows_.resize(size.height);
        look(0, size.height);
    }
    Size size() const { return map_.size(); }
    int operator()(int y, int x) const { return map_(y, x); }
    bool best(int& similarity, Point& at) const
    {
        at.y = int(std::max_element(rows_.begin(), rows_.end()) - rows_.begin());
        similarity = rows_[at.y];
        at.x = int(std::find(map_[at.y], map_[at.y] + map_.cols, ushort(similarity)) - map_[at.y]);
        return similarity > 0;
    }
    void suppress(const Rect& area)
    {
        map_(area).setTo(0);
        look(area.y, area.y + area.height);
    }

private:
    void look(int first, int end)
    {
        for (int y = first; y < end; y++) rows_[y] = ushort(greatest(map_[y], map_.cols));
    }

    Mat_<ushort> map_;
    std::vector<ushort>& rows_;
};

class QGOMatcherImpl CV_FINAL : public QGOMatcher
{
public:
    explicit QGOMatcherImpl(const Params& params) : params_(params), step_(0), planeSize_(0)
    {
        CV_Check(params.contrast, params.contrast >= 0 && params.contrast < DBL_MAX, "Params::contrast must not be negative");
        CV_Check(params.leastMagnitude, params.leastMagnitude >= 0 && params.leastMagnitude < DBL_MAX, "Params::leastMagnitude must not be negative");
        CV_Check(params.magnitudeThreshold, params.magnitudeThreshold >= 0 && params.magnitudeThreshold < 1e4, "Params::magnitudeThreshold must be in 0..10000");
        if (params.contrast > 0) CV_CheckLE(params.magnitudeThreshold, 127., "Params::magnitudeThreshold: more goes without contrast only");
        CV_Check(params.spread, params.spread > 0 && params.spread % 2 == 1 && params.spread < 100, "Params::spread must be odd, positive and less than 100");
        CV_CheckGT(params.candidates, 0, "Params::candidates must be positive");
        CV_Check(params.suppressionRadius, params.suppressionRadius >= 0 && params.suppressionRadius < 1000, "Params::suppressionRadius must be in 0..999");
        CV_Check(params.minSimilarity, std::abs(params.minSimilarity) < DBL_MAX, "Params::minSimilarity must be finite");
        CV_Check(params.relativeSimilarity, std::abs(params.relativeSimilarity) < DBL_MAX, "Params::relativeSimilarity must be finite");
    }

    void setImage(InputArray image, const Rect& roi, InputArray mask) CV_OVERRIDE;
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
    void similarity(const PartTemplate& t, const Rect& window);
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
    std::vector<ushort> similarity_, rows_;
    WholeImageSearch wholeImage_;
    // Of all templates, in the order found, and by falling similarity.
    std::vector<PartMatch> found_;
    std::vector<std::pair<double, int> > order_;
};

Rect reachIn(const PartTemplate& t, const Rect& window)
{
    const Rect reach = reachOf(t);
    return Rect(window.x + reach.x, window.y + reach.y, window.width + reach.width, window.height + reach.height);
}

void QGOMatcherImpl::setImage(InputArray _image, const Rect& roi, InputArray _mask)
{
    const Mat image = _image.getMat(), mask = _mask.getMat();
    checkImage(image);
    if (!mask.empty() && (mask.type() != CV_8UC1 || mask.size() != image.size())) CV_Error(Error::StsBadArg, "mask must be CV_8UC1 of the image's size");
    const Rect all(Point(), image.size());
    imageSize_ = image.size();
    roi_ = roi.empty() ? all : roi & all;
    covered_ = Rect();
    wholeImage_.forget();
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
    if (!mask.empty()) bitwise_and(orientations_, mask(roi_), orientations_, noArray());
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
    if (anyWhole) wholeImage_.prepare(imageSize_, spread_, roi_, templates);
    prepareResponses(needed);
    for (size_t i = 0; i < templates.size(); i++)
    {
        const PartTemplate& t = templates[i];
        const Rect window = windows.empty() ? all : windows[i] & all;
        if (window.empty() || t.features.empty()) continue;
        if (window == all)
        {
            selectCandidates(wholeImage_.search(t, params_), t, int(i), all);
            continue;
        }
        similarity(t, window);
        DenseMap map(&similarity_[0], window.size(), rows_);
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
