// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/surgtrack/geometric_context.hpp"

namespace cv { namespace surgtrack {

GeometricContextVerifier::Params::Params()
    : zoneAngle(CV_PI / 6), zoneRadius(10), centredZones(true), minInliers(4), maxIterations(100), maxScale(1.35),
      maxRotation(35 * CV_PI / 180), seed(1)
{
}

namespace {

const double twoPi = 2 * CV_PI;

// The PROSAC sampler (Chum and Matas 2005, eq. 3 and 5): pairs from a set of best matches that grows as if T_N pairs had been
// drawn from all of them at random.
class ProsacPairs
{
public:
    ProsacPairs(int total, int maxSamples, uint64 seed) : rng_(seed), total_(total), n_(2), drawn_(0), nextGrowth_(1)
    {
        // T_n of the first set: T_N * prod (n - i) / (N - i), i = 0, 1.
        T_n_ = maxSamples * 2. / (double(total) * (total - 1));
    }

    Vec2i next()
    {
        drawn_++;
        while (drawn_ > nextGrowth_ && n_ < total_)
        {
            const double larger = T_n_ * (n_ + 1) / (n_ - 1);
            n_++;
            nextGrowth_ += std::max(1, cvCeil(larger - T_n_));
            T_n_ = larger;
        }
        if (n_ < total_ || drawn_ == 1) return Vec2i(rng_.uniform(0, n_ - 1), n_ - 1);
        const int a = rng_.uniform(0, n_), b = rng_.uniform(0, n_ - 1);
        return Vec2i(a, b + (b >= a));
    }

private:
    RNG rng_;
    int total_, n_, drawn_, nextGrowth_;
    double T_n_;
};

// Polar coordinates about a centre, the angle from an axis, in 0..2 pi.
struct PolarGrid
{
    PolarGrid(const Point2d& c, const Point2d& onAxis) : centre(c), axis(std::atan2(onAxis.y - c.y, onAxis.x - c.x)) {}

    void locate(const Point2d& p, double& angle, double& radius) const
    {
        const Point2d d = p - centre;
        radius = norm(d);
        angle = std::atan2(d.y, d.x) - axis;
        if (angle < 0) angle += twoPi;
        if (angle >= twoPi) angle -= twoPi;
    }

    Point2d centre;
    double axis;
};

inline double angleBetween(double a, double b)
{
    const double d = std::fmod(std::abs(a - b), twoPi);
    return std::min(d, twoPi - d);
}

inline bool byPart(const PartMatch& a, const PartMatch& b)
{
    return a.part < b.part;
}

class GeometricContextVerifierImpl CV_FINAL : public GeometricContextVerifier
{
public:
    explicit GeometricContextVerifierImpl(const Params& params) : params_(params)
    {
        CV_Check(params.zoneAngle, params.zoneAngle > 0 && params.zoneAngle <= twoPi, "Params::zoneAngle must be in 0..2 pi");
        CV_Check(params.zoneRadius, params.zoneRadius > 0 && params.zoneRadius < DBL_MAX, "Params::zoneRadius must be positive");
        CV_Check(params.maxIterations, params.maxIterations > 0 && params.maxIterations <= 1000000, "Params::maxIterations must be in 1..1000000");
        CV_CheckGE(params.minInliers, 2, "Params::minInliers must be at least 2");
    }

    bool verify(const std::vector<PartMatch>& matches, std::vector<PartMatch>& inliers) CV_OVERRIDE;
    std::vector<PartMatch> sample() const CV_OVERRIDE
    {
        std::vector<PartMatch> matches;
        copySample(matches);
        return matches;
    }
    void copySample(std::vector<PartMatch>& matches) const CV_OVERRIDE { matches.assign(sample_, sample_ + (result_.empty() ? 0 : 2)); }

private:
    bool sameZone(const PolarGrid& drawing, const PolarGrid& image, const PartMatch& m) const;
    double collect(const std::vector<PartMatch>& matches, int first, int second, std::vector<int>& agreeing);

    Params params_;
    // of one verify()
    std::vector<int> agreeing_, best_;
    std::vector<uchar> taken_;
    std::vector<PartMatch> result_;
    PartMatch sample_[2];
};

bool GeometricContextVerifierImpl::sameZone(const PolarGrid& drawing, const PolarGrid& image, const PartMatch& m) const
{
    double angleDrawn, radiusDrawn, angleSeen, radiusSeen;
    drawing.locate(m.predictedPoint, angleDrawn, radiusDrawn);
    image.locate(m.imagePoint, angleSeen, radiusSeen);
    if (params_.centredZones)
        return std::abs(radiusDrawn - radiusSeen) <= params_.zoneRadius / 2
               && (angleBetween(angleDrawn, angleSeen) <= params_.zoneAngle / 2 || std::max(radiusDrawn, radiusSeen) <= params_.zoneRadius);
    return cvFloor(radiusDrawn / params_.zoneRadius) == cvFloor(radiusSeen / params_.zoneRadius)
           && cvFloor(angleDrawn / params_.zoneAngle) == cvFloor(angleSeen / params_.zoneAngle);
}

// All that agrees with the sample, the most similar match of each part; the sum of their similarities.
double GeometricContextVerifierImpl::collect(const std::vector<PartMatch>& matches, int first, int second, std::vector<int>& agreeing)
{
    const PartMatch &a = matches[first], &b = matches[second];
    agreeing.clear();
    const Point2d drawn = b.predictedPoint - a.predictedPoint, seen = b.imagePoint - a.imagePoint;
    const double drawnLength = norm(drawn), seenLength = norm(seen);
    if (a.part == b.part || drawnLength < 1 || seenLength < 1) return 0;
    const double scale = seenLength / drawnLength;
    if (params_.maxScale > 0 && (scale > params_.maxScale || scale < 1 / params_.maxScale)) return 0;
    const double turned = angleBetween(std::atan2(seen.y, seen.x), std::atan2(drawn.y, drawn.x));
    if (params_.maxRotation > 0 && turned > params_.maxRotation) return 0;

    const PolarGrid drawing(a.predictedPoint, b.predictedPoint), image(a.imagePoint, b.imagePoint);
    std::fill(taken_.begin(), taken_.end(), uchar(0));
    taken_[a.part] = taken_[b.part] = 1;
    agreeing.push_back(first);
    agreeing.push_back(second);
    double score = a.similarity + b.similarity;
    for (int i = 0; i < int(matches.size()); i++)
    {
        if (taken_[matches[i].part] || !sameZone(drawing, image, matches[i])) continue;
        taken_[matches[i].part] = 1;
        agreeing.push_back(i);
        score += matches[i].similarity;
    }
    return score;
}

bool GeometricContextVerifierImpl::verify(const std::vector<PartMatch>& matches, std::vector<PartMatch>& inliers)
{
    const int n = int(matches.size());
    int lastPart = -1;
    for (int i = 0; i < n; i++)
    {
        const PartMatch& m = matches[i];
        CV_CheckGE(m.part, 0, "matches: a part index is negative");
        const double sum = m.imagePoint.x + m.imagePoint.y + m.predictedPoint.x + m.predictedPoint.y + m.similarity;
        if (!(std::abs(sum) < DBL_MAX)) CV_Error(Error::StsBadArg, format("matches[%d] is not finite", i));
        lastPart = std::max(lastPart, matches[i].part);
    }
    taken_.assign(lastPart + 1, 0);
    agreeing_.reserve(taken_.size());
    best_.reserve(taken_.size());
    result_.reserve(taken_.size());
    best_.clear();
    double bestScore = 0;
    if (n >= params_.minInliers)
    {
        ProsacPairs pairs(n, params_.maxIterations, uint64(params_.seed));
        for (int k = 0; k < params_.maxIterations; k++)
        {
            const Vec2i pair = pairs.next();
            const double score = collect(matches, pair[0], pair[1], agreeing_);
            if (agreeing_.size() < best_.size() || (agreeing_.size() == best_.size() && score <= bestScore)) continue;
            best_.swap(agreeing_);
            bestScore = score;
            // The paper stops at the first sample that enough matches agree with.
            if (!params_.centredZones && int(best_.size()) >= params_.minInliers) break;
        }
    }
    const bool found = int(best_.size()) >= params_.minInliers;
    result_.clear();
    if (found)
    {
        for (size_t i = 0; i < best_.size(); i++) result_.push_back(matches[best_[i]]);
        std::copy(result_.begin(), result_.begin() + 2, sample_);
        std::sort(result_.begin(), result_.end(), byPart);
    }
    inliers.assign(result_.begin(), result_.end());   // at the end: they may be the matches themselves
    return found;
}

} // namespace

Ptr<GeometricContextVerifier> GeometricContextVerifier::create(const Params& params)
{
    return makePtr<GeometricContextVerifierImpl>(params);
}

}} // namespace cv::surgtrack
