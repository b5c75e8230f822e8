// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "qgo.hpp"

namespace cv { namespace surgtrack {

PartMatch::PartMatch() : tool(0), part(0), similarity(0), templateIndex(0) {}

QGOMatcher::Params::Params()
    : magnitudeThreshold(50), spread(5), candidates(5), suppressionRadius(6), minSimilarity(0.5), relativeSimilarity(0.7)
{
}

namespace {

class QGOMatcherImpl CV_FINAL : public QGOMatcher
{
public:
    explicit QGOMatcherImpl(const Params& params) : params_(params)
    {
        CV_Check(params.spread, params.spread > 0 && params.spread % 2 == 1, "Params::spread must be odd and positive");
        CV_CheckGT(params.candidates, 0, "Params::candidates must be positive");
        CV_CheckGE(params.suppressionRadius, 0, "Params::suppressionRadius must not be negative");
    }

    void setImage(InputArray image, const Rect& roi) CV_OVERRIDE;
    void match(const std::vector<PartTemplate>& templates, const std::vector<Rect>& windows, std::vector<PartMatch>& matches) CV_OVERRIDE;
    void similarityMap(const PartTemplate& partTemplate, const Rect& window, OutputArray similarity) CV_OVERRIDE;

private:
    void similarity(const PartTemplate& t, const Rect& window);
    void selectCandidates(const PartTemplate& t, int templateIndex, const Rect& window, std::vector<PartMatch>& matches);

    Params params_;
    Size imageSize_;
    Rect roi_;                     // what the responses cover
    Mat orientations_, spread_;
    std::vector<uchar> workspace_;
    // Eight maps of the responses 4, 1, 0; around the region a margin of zeros, which features beyond it fall on.
    int margin_;
    Rect padded_;
    size_t step_, planeSize_;
    std::vector<uchar> planes_;
    std::vector<int> offsets_;
    std::vector<ushort> similarity_;
};

const int overrun = 64;   // a row of a kernel may

void QGOMatcherImpl::setImage(InputArray _image, const Rect& roi)
{
    const Mat image = _image.getMat();
    checkImage(image);
    const Rect all(Point(), image.size());
    imageSize_ = image.size();
    roi_ = roi.empty() ? all : roi & all;
    margin_ = std::max(96, image.cols / 7);   // half a template's box, and some more
    padded_ = Rect(roi_.x - margin_, roi_.y - margin_, roi_.width + 2 * margin_, roi_.height + 2 * margin_);
    step_ = padded_.width;
    planeSize_ = step_ * padded_.height + overrun;
    CV_CheckLT(8 * planeSize_, size_t(INT_MAX), "the image is too large, a roi is needed");
    planes_.assign(8 * planeSize_, 0);
    if (roi_.empty()) return;
    orientations_.create(roi_.size(), CV_8UC1);
    spread_.create(roi_.size(), CV_8UC1);
    quantize(image, roi_, leastStrength(params_.magnitudeThreshold), orientations_, workspace_);
    spread(orientations_, spread_, params_.spread, workspace_);
    responses(spread_.ptr(), spread_.step, roi_.size(), &planes_[margin_ * step_ + margin_], step_, planeSize_);
}

// Sums the responses of all features for every place of the keypoint in the window.
void QGOMatcherImpl::similarity(const PartTemplate& t, const Rect& window)
{
    similarity_.resize(window.area());
    int left = 0, right = 0, top = 0, bottom = 0;
    offsets_.clear();
    for (size_t i = 0; i < t.features.size(); i++)
    {
        const TemplateFeature& f = t.features[i];
        left = std::min(left, int(f.x));
        right = std::max(right, int(f.x));
        top = std::min(top, int(f.y));
        bottom = std::max(bottom, int(f.y));
    }
    const Rect reach(window.x + left, window.y + top, window.width + right - left, window.height + bottom - top);
    if ((reach & padded_) == reach)
    {
        for (size_t i = 0; i < t.features.size(); i++)
            offsets_.push_back(int(t.features[i].bin * planeSize_ + t.features[i].y * (ptrdiff_t)step_) + t.features[i].x);
        similarities(&planes_[0] + (window.y - padded_.y) * (ptrdiff_t)step_ + (window.x - padded_.x), step_, &offsets_[0], int(offsets_.size()),
                     window.size(), &similarity_[0]);
        return;
    }
    // A window far larger than the prepared region: feature by feature, where it is covered.
    std::fill(similarity_.begin(), similarity_.end(), ushort(0));
    for (size_t i = 0; i < t.features.size(); i++)
    {
        const TemplateFeature& f = t.features[i];
        const Rect seen = (window + Point(f.x, f.y)) & roi_;
        for (int y = seen.y; y < seen.y + seen.height; y++)
        {
            const uchar* src = &planes_[0] + f.bin * planeSize_ + (y - padded_.y) * step_ + (seen.x - padded_.x);
            ushort* dst = &similarity_[0] + (y - f.y - window.y) * window.width + seen.x - f.x - window.x;
            for (int x = 0; x < seen.width; x++) dst[x] = ushort(dst[x] + src[x]);
        }
    }
}

void QGOMatcherImpl::similarityMap(const PartTemplate& t, const Rect& window, OutputArray result)
{
    CV_Assert(!imageSize_.empty() && "setImage() comes first");
    CV_Assert(!window.empty());
    CV_Check(t.features.size(), !t.features.empty() && t.features.size() <= 65535 / 4, "partTemplate needs 1..16383 features");
    similarity(t, window);
    Mat(window.size(), CV_16UC1, &similarity_[0]).copyTo(result);
}

// The best places, each suppressing its neighbourhood.
void QGOMatcherImpl::selectCandidates(const PartTemplate& t, int templateIndex, const Rect& window, std::vector<PartMatch>& matches)
{
    Mat_<ushort> map(window.height, window.width, &similarity_[0]);
    const double full = 4. * double(t.features.size());
    double weakest = params_.minSimilarity * full;
    const int r = params_.suppressionRadius, reach = params_.spread / 2 + 1;
    for (int k = 0; k < params_.candidates; k++)
    {
        double best;
        Point at;
        minMaxLoc(map, 0, &best, 0, &at);
        if (best < weakest || best <= 0) return;
        if (k == 0) weakest = std::max(weakest, params_.relativeSimilarity * best);

        // Spreading flattens peaks, and the best place is the first of a plateau: the centre of mass of the top, sought from there.
        const double floor = best - std::max(1., 0.04 * full);
        Point2d centre(at);
        for (int pass = 0; pass < 3; pass++)
        {
            const Rect around = Rect(cvRound(centre.x) - reach, cvRound(centre.y) - reach, 2 * reach + 1, 2 * reach + 1) & Rect(Point(), window.size());
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
        matches.push_back(m);

        map(Rect(at.x - r, at.y - r, 2 * r + 1, 2 * r + 1) & Rect(Point(), window.size())).setTo(0);
    }
}

inline bool moreSimilar(const PartMatch& a, const PartMatch& b)
{
    return a.similarity > b.similarity;
}

void QGOMatcherImpl::match(const std::vector<PartTemplate>& templates, const std::vector<Rect>& windows, std::vector<PartMatch>& matches)
{
    CV_Assert(!imageSize_.empty() && "setImage() comes first");
    CV_Check(windows.size(), windows.empty() || windows.size() == templates.size(), "windows: one per template, or none");
    matches.clear();
    const Rect all(Point(), imageSize_);
    for (size_t i = 0; i < templates.size(); i++)
    {
        const Rect window = windows.empty() ? all : windows[i] & all;
        const size_t n = templates[i].features.size();
        CV_CheckLE(n, size_t(65535 / 4), "too many features in a template");
        if (window.empty() || n == 0) continue;
        similarity(templates[i], window);
        selectCandidates(templates[i], int(i), window, matches);
    }
    std::stable_sort(matches.begin(), matches.end(), moreSimilar);
}

} // namespace

Ptr<QGOMatcher> QGOMatcher::create(const Params& params)
{
    return makePtr<QGOMatcherImpl>(params);
}

}} // namespace cv::surgtrack
