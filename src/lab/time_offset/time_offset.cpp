// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "lab/time_offset/time_offset.hpp"
#include <set>

namespace cv { namespace surgtrack {

TimeOffsetParams::TimeOffsetParams()
    : expected(0), range(3), step(0.16), frames(48), minOverlap(1.5), minConfidence(0.15), maxDeviation(0.03), seed(1), tool(-1)
{
}

TimeOffset::TimeOffset() : offset(0), deviation(0), confidence(0), support(0), frames(0) {}

namespace {

const double refineWindow = 24;               // half-width of the windows once the correction is about known [pixel at 720 px width]
const int coarseFeatures = 100;               // of the templates of the first search
const double agreement = 8;                   // a part this near to where the fit has it supports the offset [pixel at 720 px width]
const int minAgreeing = 4;                    // parts of a tool that is said to be found
const double minSupport = 0.6;                // three parts at a similarity of 0.6 [see TimeOffset::support]
const double jointDeviation = 0.03, slideDeviation = 0.001;   // constant errors of joint readings [rad], [m]

} // namespace

TimeOffsetEstimator::TimeOffsetEstimator(const Sequence& sequence, const TimeOffsetParams& params)
    : sequence_(sequence), params_(params),
      camera_(reduceCamera(sequence.leftCamera(), std::max(1, sequence.leftCamera().imageSize().width / referenceWidth))), blocks_(1)
{
    PartTemplateRenderer::Params drawing;
    drawing.maxFeatures = coarseFeatures;
    const Ptr<PartTemplateRenderer> few = PartTemplateRenderer::create(Ptr<MeshRenderer>(), drawing), all = PartTemplateRenderer::create();
    coarse_ = PartFinder::create(camera_, few);   // of images that are reduced when they are read
    fine_ = PartFinder::create(camera_, all);
    GeometricContextVerifier::Params context;
    context.zoneRadius *= fine_->pixelScale();
    context.seed = params.seed;
    verifier_ = GeometricContextVerifier::create(context);
    std::map<String, Ptr<ToolModel> > models;
    for (int i = 0; i < sequence.toolCount(); i++)
    {
        if (params.tool >= 0 && i != params.tool) continue;
        const SequenceTool info = sequence.tool(i);
        Ptr<ToolModel>& model = models[info.model];
        if (!model) model = ToolModel::load(info.model);
        OffsetTool tool;
        tool.index = i;
        tool.model = model;
        tool.coordinates = model->coordinateNames();
        tool.nominal_T_base = nearestRigid(info.nominal_T_base);
        tool.deviations.assign(tool.coordinates.size(), jointDeviation);
        for (size_t k = 0; k < model->links().size(); k++)
            if (model->links()[k].jointType == ToolModel::JOINT_PRISMATIC) tool.deviations[model->links()[k].coordinate] = slideDeviation;
        tools_.push_back(tool);
        few->addTool(model);
        all->addTool(model);
    }
    // Times of frames are whole numbers of cells, so that a drawing serves many frames.
    const double interval = 1 / sequence.fps();
    const int framesACell = std::max(1, cvRound(params.step / interval));
    const int cellsAFrame = framesACell > 1 ? 1 : std::max(1, cvCeil(interval / params.step - 1e-6));
    stride_ = framesACell;
    step_ = interval * framesACell / cellsAFrame;
    reach_ = cvCeil(params.range / step_ - 1e-6);
    sums_.assign(2 * reach_ + 1, 0.);
    counts_.assign(2 * reach_ + 1, 0);
    frameCounts_ = counts_;
}

// Draws the tools as the fit has them and finds them anew.
bool TimeOffsetEstimator::measureAgain(const TimeOffsetFit& fit, PartFinder& finder, std::vector<OffsetMeasurement>& measurements)
{
    measurements.clear();
    std::vector<ToolView> views(tools_.size());
    PartDrawing drawing;
    FoundParts found;
    for (size_t f = 0; f < frames_.size(); f++)
    {
        bool known = true;
        for (size_t i = 0; i < tools_.size(); i++) known = known && fit.view(int(i), blockOf(f), times_[f], views[i]);
        if (!known) continue;
        finder.setImage(frames_[f]);
        for (size_t i = 0; i < tools_.size(); i++)
        {
            OffsetMeasurement m;
            finder.draw(views, int(i), drawing);
            finder.find(drawing, PartWindows(cvRound(refineWindow * finder.pixelScale())), *verifier_, found);
            m.inliers = found.inliers;
            m.tool = int(i);
            m.block = blockOf(f);
            m.time = times_[f];
            measurements.push_back(m);
        }
    }
    return !measurements.empty();
}

/* From the detections near a coarse offset to the refined one.
   thorough: with the full templates, until it settles; else as far as it takes to see how well it is supported. */
bool TimeOffsetEstimator::refine(OffsetCandidate& candidate, bool thorough)
{
    // Of neighbouring readings those whose drawing was found best.
    std::map<std::pair<size_t, int>, const OffsetDetection*> best;
    for (size_t i = 0; i < detections_.size(); i++)
    {
        const OffsetDetection& d = detections_[i];
        if (std::abs(d.cell - candidate.cell) > 1) continue;
        const OffsetDetection*& b = best[std::make_pair(d.frame, d.tool)];
        if (!b || d.score > b->score) b = &d;
    }
    std::vector<OffsetMeasurement> measurements;
    for (std::map<std::pair<size_t, int>, const OffsetDetection*>::const_iterator it = best.begin(); it != best.end(); ++it)
    {
        OffsetMeasurement m;
        m.tool = it->second->tool;
        m.block = blockOf(it->second->frame);
        m.time = times_[it->second->frame];
        m.inliers = it->second->inliers;
        measurements.push_back(m);
    }
    // The hand-eye error moves all points by tens of pixels: far points lose their say little by little.
    static const double scales[] = { 80, 40, 20, 12 };
    const double reach = 2 * step_;
    TimeOffsetFit fit(sequence_, camera_, tools_, blocks_);
    fit.start(params_.expected + candidate.cell * step_);
    for (int i = 0; i < 4; i++)
        if (!fit.run(measurements, scales[i], 5, reach)) return false;
    for (int pass = 0; pass < (thorough ? 3 : 1); pass++)
        if (!measureAgain(fit, thorough ? *fine_ : *coarse_, measurements) || !fit.run(measurements, pass == 0 ? 12 : 9, 8, reach)) return false;
    candidate.offset = fit.offset();
    candidate.deviation = fit.deviation();
    candidate.settled = std::abs(fit.offset() - params_.expected - candidate.cell * step_) < 0.99 * reach;
    support(fit, measurements, candidate);
    return true;
}

void TimeOffsetEstimator::support(const TimeOffsetFit& fit, const std::vector<OffsetMeasurement>& measurements, OffsetCandidate& candidate) const
{
    std::set<double> seen;   // times
    candidate.support = 0;
    for (size_t i = 0; i < measurements.size(); i++)
    {
        const OffsetMeasurement& m = measurements[i];
        ToolView view;
        if (!fit.view(m.tool, m.block, m.time, view)) continue;
        int agreeing = 0;
        for (size_t k = 0; k < m.inliers.size(); k++)
        {
            if (fit.residual(m.tool, view, m.inliers[k]) > agreement * fine_->pixelScale()) continue;
            candidate.support += std::max(0., m.inliers[k].similarity - chanceSimilarity);
            agreeing++;
        }
        if (agreeing >= minAgreeing) seen.insert(m.time);
    }
    candidate.support /= double(measurements.size() + luckyFrames);
    candidate.frames = int(seen.size());
}

/* The best offset, and the next best that does not settle to the same one.
   A candidate with less than half the coarse score is not worth refining. */
bool TimeOffsetEstimator::choose(OffsetCandidate& best, double& second)
{
    std::vector<OffsetCandidate> candidates;
    const std::vector<int> cells = peaks();
    second = 0;
    for (size_t i = 0; i < cells.size(); i++)
    {
        OffsetCandidate candidate;
        candidate.cell = cells[i];
        candidate.coarse = coarseScore(cells[i]);
        if ((i == 0 || candidate.coarse > 0.5 * coarseScore(cells[0])) && refine(candidate, false)) candidates.push_back(candidate);
        else if (i > 0) second = std::max(second, candidate.coarse / coarseScore(cells[0]));
    }
    if (candidates.empty()) return false;
    int chosen = 0;
    for (int i = 1; i < int(candidates.size()); i++)
        if (candidates[i].support > candidates[chosen].support) chosen = i;
    best = candidates[chosen];
    for (int i = 0; i < int(candidates.size()); i++)
        if (std::abs(candidates[i].offset - best.offset) > step_ && best.support > 0) second = std::max(second, candidates[i].support / best.support);
    best.cell = cvRound((best.offset - params_.expected) / step_);
    return refine(best, true);
}

bool TimeOffsetEstimator::run(TimeOffset& result)
{
    result = TimeOffset();
    result.offset = params_.expected;
    readFrames();
    searchAll();
    double overlap = 0, second = 0;
    for (int cell = -reach_; cell <= reach_; cell++) overlap = std::max(overlap, overlapOf(cell));
    if (overlap < params_.minOverlap)
    {
        result.reason = format("no offset of the range gives readings to more than %.2f s of the video, expected at least %.2f s", overlap, params_.minOverlap);
        return false;
    }
    OffsetCandidate best;
    if (!choose(best, second))
    {
        result.reason = "the tools are nowhere where any offset of the range has them";
        return false;
    }
    result.offset = best.offset;
    result.deviation = best.deviation;
    result.confidence = std::max(0., 1 - second);
    result.support = best.support;
    result.frames = best.frames;
    if (best.frames < minOffsetFrames || best.support < minSupport)
        result.reason = format("the tools were found in %d frames, with a support of %.2f; expected at least %d and %.2f", best.frames, best.support,
                               minOffsetFrames, minSupport);
    else if (!(best.deviation <= params_.maxDeviation))
        result.reason = format("the tools move too little: the offset is known to %.3f s, expected %.3f s or better", best.deviation, params_.maxDeviation);
    else if (result.confidence < params_.minConfidence)
        result.reason = format("another offset fits nearly as well: confidence %.2f, expected at least %.2f", result.confidence, params_.minConfidence);
    else if (!best.settled || std::abs(best.offset - params_.expected) > params_.range + step_)
        result.reason = format("the best offset, %.3f s, lies at the end of the range", best.offset);
    return result.reason.empty();
}

namespace {

void check(const TimeOffsetParams& p, const Sequence& sequence)
{
    CV_Check(p.tool, p.tool >= -1 && p.tool < sequence.toolCount(), "TimeOffsetParams::tool must be the index of a tool, or -1");
    CV_Check(p.expected, std::abs(p.expected) < DBL_MAX, "TimeOffsetParams::expected must be finite");
    CV_Check(p.range, p.range >= 0 && p.range < DBL_MAX, "TimeOffsetParams::range must not be negative");
    CV_Check(p.step, p.step > 0 && p.step < DBL_MAX, "TimeOffsetParams::step must be positive");
    CV_Check(p.range / p.step, p.range / p.step <= 10000, "TimeOffsetParams::range must be at most 10000 steps");
    CV_CheckGE(p.frames, minOffsetFrames, "TimeOffsetParams::frames: fewer tell nothing");
    CV_Check(p.minOverlap, p.minOverlap >= 0 && p.minOverlap < DBL_MAX, "TimeOffsetParams::minOverlap must not be negative");
    CV_Check(p.minConfidence, p.minConfidence >= 0 && p.minConfidence <= 1, "TimeOffsetParams::minConfidence must be in 0..1");
    CV_Check(p.maxDeviation, p.maxDeviation > 0 && p.maxDeviation < DBL_MAX, "TimeOffsetParams::maxDeviation must be positive");
}

} // namespace

bool estimateTimeOffset(const Ptr<Sequence>& sequence, TimeOffset& result, const TimeOffsetParams& params)
{
    if (!sequence) CV_Error(Error::StsNullPtr, "sequence: expected one that is loaded");
    check(params, *sequence);
    TimeOffsetEstimator estimator(*sequence, params);
    return estimator.run(result);
}

}} // namespace cv::surgtrack
