// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "track/tool_tracker.hpp"

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

double turn(const Matx44d& A, const Matx44d& B)
{
    double sum = 0;
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) sum += A(r, c) * B(r, c);
    return std::acos(std::min(1., std::max(-1., (sum - 1) / 2)));
}

} // namespace

void ToolTrackerImpl::renderAhead(const std::vector<std::vector<double> >& joints)
{
    checkJoints(joints);
    if (!ahead_)
    {
        std::vector<Ptr<ToolModel> > models;
        for (size_t i = 0; i < tools_.size(); i++) models.push_back(tools_[i].model);
        ahead_ = makePtr<RenderAhead>(eyes_[0].camera, models, params_.method == METHOD_FULL);
        aheadViews_.resize(tools_.size());
    }
    for (size_t i = 0; i < tools_.size(); i++)
    {
        tools_[i].model->forwardKinematics(joints[i], aheadViews_[i].base_T_link);
        aheadViews_[i].camera_T_base = tools_[i].correction * tools_[i].nominal_T_base;
        if (!tools_[i].isLocated()) aheadViews_[i].base_T_link.clear();
    }
    ahead_->request(aheadViews_);
}

// The largest shift of a keypoint in the image since the views were drawn [pixel]; DBL_MAX if templates drawn then are no use.
double ToolTrackerImpl::shiftSince(const std::vector<ToolView>* drawn) const
{
    if (!drawn) return DBL_MAX;
    const CameraModel& camera = eyes_[0].camera;
    double largest = 0;
    for (size_t i = 0; i < tools_.size(); i++)
    {
        if (!tools_[i].usesDrawnAhead()) continue;
        if ((*drawn)[i].base_T_link.empty()) return DBL_MAX;   // it was not known where it is
        const std::vector<ToolModel::Keypoint>& keypoints = tools_[i].model->keypoints();
        for (size_t k = 0; k < keypoints.size(); k++)
        {
            const Matx44d now = views_[i].camera_T_base * views_[i].base_T_link[keypoints[k].link];
            const Matx44d then = (*drawn)[i].camera_T_base * (*drawn)[i].base_T_link[keypoints[k].link];
            const Point3d p = transform(now, keypoints[k].linkPoint), q = transform(then, keypoints[k].linkPoint);
            if (p.z < 1e-3 || !eyes_[0].field.contains(Point2d(p.x / p.z, p.y / p.z))) continue;
            const double shift = std::max(camera.fx * std::abs(p.x / p.z - q.x / q.z), camera.fy * std::abs(p.y / p.z - q.y / q.z));
            // Written so that a value that is not a number does not pass.
            if (!(shift <= maxShift * pixelScale_ && turn(now, then) <= maxTurn && std::abs(q.z / p.z - 1) <= maxZoom)) return DBL_MAX;
            largest = std::max(largest, shift);
        }
    }
    return largest;
}

// The templates drawn ahead for tools that stand where they do now; 0 if there are none.
const TemplateSet* ToolTrackerImpl::drawnAhead()
{
    if (!ahead_) return 0;
    if (ahead_->stamp(RenderAhead::EARLIER)) ahead_->wait(RenderAhead::EARLIER);   // for its error, too
    bool needed = false;
    for (size_t i = 0; i < tools_.size(); i++) needed = needed || tools_[i].usesDrawnAhead();
    if (!needed) return 0;
    const double earlier = shiftSince(ahead_->stamp(RenderAhead::EARLIER)), newest = shiftSince(ahead_->stamp(RenderAhead::NEWEST));
    if (std::min(earlier, newest) == DBL_MAX) return 0;
    return &ahead_->wait(newest + clearlyNearer * pixelScale_ < earlier ? RenderAhead::NEWEST : RenderAhead::EARLIER);
}

}} // namespace cv::surgtrack
