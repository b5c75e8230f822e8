// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "detect/contour_match.hpp"
#include "track/full_method.hpp"

namespace cv { namespace surgtrack {

namespace {

/* Contours are looked for several times, nearer each time; the filter believes an edge the less the farther it is beyond the
   tolerance. A first pose begins with the first window, one that is followed with the third. */
const int passes = 5;
const double searchWindows[passes] = {16, 12, 8, 5, 3}, tolerances[passes] = {8, 5, 3, 1, 0};   // [pixel at 720 px image width]
const double leastWindow = 2;          // of small images, too [pixel]

const double supportWindow = 6, supportedWithin = 1.5;   // where edges are looked for, and which are the outline's [pixel at 720 px image width]
const double reachOfOutline = 6;       // how far an outline may be moved before it is drawn anew [pixel at 720 px image width]

// A push that is just noticed: half of what is taken for one, see full_method.cpp.
const double noticedRotation = CV_PI / 360, noticedTranslation = 0.001;   // [rad], [m]

// Points that look less like their templates are placed less well: at a similarity of 0.55 by twice the noise.
const double clearSimilarity = 0.8, noiseOfDissimilarity = 4;

} // namespace

// Every eye's points, to be solved. Returns how many passed the gate.
int FullMethod::addPoints(Scene& scene, size_t eyes, double tolerance)
{
    int passed = 0;
    for (size_t e = 0; e < eyes; e++)
    {
        const std::vector<PartMatch>& found = sights_[e].found.inliers;
        parts_.clear();
        imagePoints_.clear();
        noise_.clear();
        for (size_t i = 0; i < found.size(); i++)
        {
            noise_.push_back(1 + noiseOfDissimilarity * std::max(0., clearSimilarity - found[i].similarity));
            parts_.push_back(found[i].part);
            imagePoints_.push_back(found[i].imagePoint);
        }
        passed += filter_->addPoints(scene.eyes[e]->camera(), scene.eyes[e]->eye_T_camera(), parts_, imagePoints_, used_, noise_, tolerance);
        if (e > 0) continue;
        inliers_.clear();
        for (size_t i = 0; i < used_.size(); i++)
            if (used_[i]) inliers_.push_back(found[i]);
    }
    return passed;
}

// The filter after the points of so many eyes alone.
int FullMethod::correctPoints(Scene& scene, size_t eyes)
{
    StageTimer timer(scene.times, FILTER);
    filter_->begin();
    const int passed = addPoints(scene, eyes, DBL_MAX);
    if (passed < thresholds_.minParts || !filter_->solve()) return 0;
    evidence_.nis = filter_->nis();
    return passed;
}

// The outline where the tool was drawn.
void FullMethod::sampleOutline(Scene& scene, size_t e, const PartDrawing& drawing)
{
    StageTimer timer(scene.times, CONTOUR);
    PartFinder& eye = *scene.eyes[e];
    std::vector<ContourPoint>& outline = sights_[e].outline;
    contour_->sample(eye.camera(), drawing.views[index_], drawing.rendering, index_ + 1, outline);
    size_t seen = 0;
    for (size_t i = 0; i < outline.size(); i++)
        if (eye.sees(outline[i].imagePoint)) outline[seen++] = outline[i];
    outline.resize(seen);
    if (outline.empty()) return;
    Rect2d box(outline[0].imagePoint, Size2d());
    for (size_t i = 0; i < outline.size(); i++) box |= Rect2d(outline[i].imagePoint, Size2d(1, 1));
    const int reach = cvCeil(reachOfOutline * pixelScale_ + searchWindows[0]);
    eye.pixels(Rect(cvFloor(box.x) - reach, cvFloor(box.y) - reach, cvCeil(box.width) + 2 * reach, cvCeil(box.height) + 2 * reach));
}

// Where it is believed now.
void FullMethod::redraw(Scene& scene, size_t e)
{
    scene.draw(e, index_, filter_->view(), sights_[e].redrawn);
    sights_[e].drawn = &sights_[e].redrawn;
    sampleOutline(scene, e, sights_[e].redrawn);
}

// The tool as it is believed to be, in the frame of the eye.
const ToolView& FullMethod::seenBy(const PartFinder& eye)
{
    seen_ = filter_->view();
    seen_.camera_T_base = eye.eye_T_camera() * seen_.camera_T_base;
    return seen_;
}

// Where its edges are expected: what is clipped to white eats into the tool.
void FullMethod::placeOutline(const PartFinder& eye, std::vector<ContourPoint>& outline)
{
    placeContour(eye.camera(), seenBy(eye), outline);
    for (size_t i = 0; i < outline.size(); i++)
        if (outline[i].clipped) outline[i].imagePoint += outline[i].normal * filter_->edgeBias(outline[i].clipped);
}

// Edges on the normals of all eyes' outlines, taken in several times. Returns the log likelihood ratio of a push.
double FullMethod::refine(Scene& scene, int firstPass)
{
    StageTimer timer(scene.times, CONTOUR);
    double likelihood = 0, strengths[2] = {0, 0};
    for (int pass = firstPass; pass < passes; pass++)
    {
        ContourSearch search = edges_;
        search.halfWindow = std::max(leastWindow, searchWindows[pass] * pixelScale_);
        const double tolerance = tolerances[pass] * pixelScale_;
        filter_->begin();
        addPoints(scene, eyes(scene), tolerance);
        for (size_t e = 0; e < eyes(scene); e++)
        {
            PartFinder& eye = *scene.eyes[e];
            std::vector<ContourPoint>& outline = sights_[e].outline;
            placeOutline(eye, outline);
            const Mat& image = eye.pixels(Rect());
            if (pass == firstPass) strengths[e] = strengthAsked(image, outline, search);
            matchContour(image, outline, search, strengths[e]);
            if (params_.contours) filter_->addContour(eye.camera(), eye.eye_T_camera(), outline, tolerance);
        }
        if (pass == firstPass) likelihood = filter_->surprise(noticedRotation, noticedTranslation);
        filter_->solve();
    }
    evidence_.support = support(scene, strengths);
    evidence_.similarity = meanSimilarity(inliers_);
    evidence_.parts = int(inliers_.size());
    evidence_.plausible = plausible(scene.camera(), filter_->correction(), inliers_);
    return likelihood;
}

// The share of the outline where the strongest edge around is the outline's.
double FullMethod::support(Scene& scene, const double* strengths)
{
    ContourSearch search = edges_;
    search.halfWindow = std::max(leastWindow, supportWindow * pixelScale_);
    search.preference = 0;
    search.ambiguity = 1;
    int supported = 0, all = 0, found = 0, white = 0;
    for (size_t e = 0; e < eyes(scene); e++)
    {
        PartFinder& eye = *scene.eyes[e];
        std::vector<ContourPoint>& outline = sights_[e].outline;
        placeOutline(eye, outline);
        matchContour(eye.pixels(Rect()), outline, search, strengths[e]);
        int here = 0;
        for (size_t i = 0; i < outline.size(); i++)
        {
            if (!outline[i].found) continue;
            here += std::abs(outline[i].offset) < supportedWithin * pixelScale_;
            white += outline[i].clipped != 0;
            found++;
        }
        evidence_.eyeSupport[e] = outline.empty() ? 0 : double(here) / double(outline.size());
        supported += here;
        all += int(outline.size());
    }
    evidence_.white = found ? double(white) / found : 0;
    return all ? double(supported) / all : 0;
}

}} // namespace cv::surgtrack
