// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "track/tool_tracker.hpp"
#include "track/view_change.hpp"

// The tracker's side of renderAhead().

namespace cv { namespace surgtrack {

namespace {

/* How far a tool may stand from where it was drawn. Templates are moved to where it is now, so a shift changes only the
   perspective: 6 pixels are less than half a degree of viewing direction. A turn or another distance distorts them: a template
   reaches some 50 pixels from its keypoint at 720 pixels width, where these bounds are a pixel; features are spread by two. */
const double maxShift = 6;      // [pixel at 720 px image width]
const double maxTurn = 0.02;    // [rad]
const double maxZoom = 0.02;

// A set that is surely drawn by now is as good as one that is nearer by less than this.
const double clearlyNearer = 1;   // [pixel]

} // namespace

void ToolTrackerImpl::renderAhead(const std::vector<std::vector<double> >& joints)
{
    checkJoints(joints);
    if (!ahead_)
    {
        ahead_ = makePtr<RenderAhead>(makeFinder(cameras_[0], tools_, MeshRenderer::createSoftware()), int(tools_.size()));
        aheadViews_.resize(tools_.size());
    }
    for (size_t i = 0; i < tools_.size(); i++) tools_[i]->foresee(joints[i], aheadViews_[i]);
    ahead_->request(aheadViews_);
}

// The largest shift of a keypoint in the image since the views were drawn [pixel]; DBL_MAX if templates drawn then are no use.
double ToolTrackerImpl::shiftSince(const std::vector<ToolView>* drawn) const
{
    if (!drawn) return DBL_MAX;
    const double scale = scene_.eyes[0]->pixelScale();
    double largest = 0;
    for (size_t i = 0; i < tools_.size(); i++)
    {
        if (!tools_[i]->usesDrawnAhead()) continue;
        if ((*drawn)[i].base_T_link.empty()) return DBL_MAX;   // it was not known where it is
        const ViewChange change = viewChange(scene_.camera(), *tools_[i]->model(), tools_[i]->view(), (*drawn)[i], &field_);
        if (!(change.shift <= maxShift * scale && change.turn <= maxTurn && change.zoom <= maxZoom)) return DBL_MAX;
        largest = std::max(largest, change.shift);
    }
    return largest;
}

// The templates drawn ahead for tools that stand where they do now; 0 if there are none.
const TemplateSet* ToolTrackerImpl::drawnAhead()
{
    if (!ahead_) return 0;
    if (ahead_->stamp(RenderAhead::EARLIER)) ahead_->wait(RenderAhead::EARLIER);   // for its error, too
    bool needed = false;
    for (size_t i = 0; i < tools_.size(); i++) needed = needed || tools_[i]->usesDrawnAhead();
    if (!needed) return 0;
    const double earlier = shiftSince(ahead_->stamp(RenderAhead::EARLIER)), newest = shiftSince(ahead_->stamp(RenderAhead::NEWEST));
    if (std::min(earlier, newest) == DBL_MAX) return 0;
    return &ahead_->wait(newest + clearlyNearer * scene_.eyes[0]->pixelScale() < earlier ? RenderAhead::NEWEST : RenderAhead::EARLIER);
}

}} // namespace cv::surgtrack
