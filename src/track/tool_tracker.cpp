// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "track/tool_tracker.hpp"

namespace cv { namespace surgtrack {

String stateName(int state)
{
    static const char* names[] = {"initializing", "tracking", "coasting", "lost"};
    CV_Check(state, state >= STATE_INITIALIZING && state <= STATE_LOST, "no such state");
    return names[state];
}

ToolEstimate::ToolEstimate()
    : state(STATE_INITIALIZING), camera_T_tool(Matx44d::eye()), camera_T_nominal(Matx44d::eye()), covariance(Matx66d::zeros()),
      visibleParts(0), inliers(0), similarity(0), contourSupport(0), nis(0)
{
}

ToolTracker::Params::Params()
    : method(METHOD_FULL), jointOffsets(true), contours(true), adaptation(true), initialWindow(0.014), minWindow(30), minInitialInliers(6), minInitialSimilarity(0.65), confirmFrames(1), coastingTime(2), seed(1)
{
}

StageTime::StageTime() : calls(0), last(0), mean(0), min(0), max(0) {}

namespace {

// Gradients of a pixel reach so far: blur 3, Sobel and vote 1 each.
const int gradientReach = 5;

// For some frames after a first pose or a push the deviations of Q are larger.
const double pushedGrowth = 3;

// Of a first pose; the outline tells the rest.
const int minFullInliers = 4;

inline Point2d enlarge(const Point2d& p, int factor)
{
    return Point2d((p.x + 0.5) * factor - 0.5, (p.y + 0.5) * factor - 0.5);
}

} // namespace

double meanSimilarity(const std::vector<PartMatch>& matches)
{
    double sum = 0;
    for (size_t i = 0; i < matches.size(); i++) sum += matches[i].similarity;
    return matches.empty() ? 0 : sum / double(matches.size());
}

Eye::Eye(const CameraModel& full, const Matx44d& _eye_T_camera, bool wholeTools)
    : imageSize(full.imageSize()), reduction(std::max(1, imageSize.width / referenceWidth)), camera(reduceCamera(full, reduction)),
      eye_T_camera(_eye_T_camera), field(camera.fieldOfView(Rect(Point(), camera.imageSize())))
{
    PartTemplateRenderer::Params params;
    params.wholeTool = wholeTools;
    renderer = PartTemplateRenderer::create(Ptr<MeshRenderer>(), params);
    matcher = QGOMatcher::create();
}

// In tiles so narrow that resize() has its tables on the stack and wakes no other thread.
void Eye::reduce(const Rect& roi)
{
    if (reduction == 1) return;
    reduced.create(camera.imageSize(), image.type());
    const Rect reach(roi.x - gradientReach, roi.y - gradientReach, roi.width + 2 * gradientReach, roi.height + 2 * gradientReach);
    const Rect area = reach & Rect(Point(), reduced.size());
    for (int x = area.x; x < area.x + area.width; x += 64)
    {
        const Rect tile(x, area.y, std::min(64, area.x + area.width - x), area.height);
        const Rect source(tile.x * reduction, tile.y * reduction, tile.width * reduction, tile.height * reduction);
        resize(image(source), reduced(tile), tile.size(), 0, 0, INTER_AREA);
    }
}

ToolTrackerImpl::ToolTrackerImpl(const CameraModel& camera, const Params& params) : open_(1), params_(params), pixelScale_(1), time_(-DBL_MAX)
{
    CV_Assert(!camera.imageSize().empty());
    CV_Check(params.method, params.method >= METHOD_PAPER && params.method <= METHOD_FULL, "Params::method: no such method");
    CV_CheckGE(params.minInitialInliers, 4, "Params::minInitialInliers: EPnP needs four points");
    CV_Check(params.initialWindow, params.initialWindow > 0 && params.initialWindow < DBL_MAX, "Params::initialWindow must be positive");
    CV_Check(params.minWindow, params.minWindow > 0 && params.minWindow < 1e5, "Params::minWindow must be positive");
    CV_Check(params.minInitialSimilarity, params.minInitialSimilarity >= 0 && params.minInitialSimilarity <= 1, "Params::minInitialSimilarity must be in 0..1");
    CV_CheckGE(params.confirmFrames, 0, "Params::confirmFrames must not be negative");
    CV_Check(params.coastingTime, params.coastingTime >= 0 && params.coastingTime < DBL_MAX, "Params::coastingTime must not be negative");
    eyes_.push_back(Eye(camera, Matx44d::eye(), params.method == METHOD_FULL));
    pixelScale_ = eyes_[0].camera.imageSize().width / double(referenceWidth);
    GeometricContextVerifier::Params context;
    context.seed = params.seed;
    context.zoneRadius *= pixelScale_;
    if (params.method != METHOD_FULL)
    {
        context.centredZones = false;   // both methods are the paper's: fixed cells, the first sample that agrees
        context.maxScale = context.maxRotation = 0;
    }
    verifier_ = GeometricContextVerifier::create(context);
    context.minInliers = params.method == METHOD_FULL ? minFullInliers : params.minInitialInliers;
    startVerifier_ = GeometricContextVerifier::create(context);
}

void ToolTrackerImpl::setRightCamera(const CameraModel& right, const Matx44d& right_T_left)
{
    if (params_.method != METHOD_FULL) CV_Error(Error::StsBadArg, "Params::method: only METHOD_FULL uses a right camera");
    CV_Assert(!right.imageSize().empty());
    if (!isRigid(right_T_left)) CV_Error(Error::StsBadArg, "right_T_left must be a rigid transform");
    eyes_.resize(1, eyes_[0]);
    eyes_.push_back(Eye(right, nearestRigid(right_T_left), true));
    for (size_t i = 0; i < tools_.size(); i++) eyes_[1].renderer->addTool(tools_[i].model);
}

int ToolTrackerImpl::addTool(const Ptr<ToolModel>& model, const Matx44d& nominal_T_base)
{
    CV_Assert(model);
    if (!isRigid(nominal_T_base)) CV_Error(Error::StsBadArg, "nominal_T_base must be a rigid transform");
    const int parts = int(model->keypoints().size());
    if (parts < params_.minInitialInliers)
        CV_Error(Error::StsBadArg, format("tool %s has %d keypoints, expected at least %d (Params::minInitialInliers)", model->name().c_str(),
                                          parts, params_.minInitialInliers));
    TrackedTool tool;
    tool.model = model;
    tool.coordinates = model->coordinateNames().size();
    tool.nominal_T_base = nearestRigid(nominal_T_base);
    ToolPoseEKF::Params filter;
    filter.measurementNoise *= pixelScale_;
    filter.minPoints = 4;   // as many as must agree on the geometric context
    tool.filter = ToolPoseEKF::create(eyes_[0].camera, filter);
    if (params_.method == METHOD_FULL)
    {
        ArticulatedPoseEKF::Params full;
        full.jointOffsets = params_.jointOffsets;
        full.pointNoise *= pixelScale_;
        full.contourNoise *= pixelScale_;
        tool.full = ArticulatedPoseEKF::create(model, tool.nominal_T_base, full);
        tool.before = ArticulatedPoseEKF::create(model, tool.nominal_T_base, full);
        tool.spare = ArticulatedPoseEKF::create(model, tool.nominal_T_base, full);
        tool.round = ArticulatedPoseEKF::create(model, tool.nominal_T_base, full);
        tool.best = ArticulatedPoseEKF::create(model, tool.nominal_T_base, full);
        tool.sure = ArticulatedPoseEKF::create(model, tool.nominal_T_base, full);
        tool.contour = ToolContour::create(model);
    }
    for (size_t i = 0; i < eyes_.size(); i++)
    {
        eyes_[i].renderer->addTool(model);
        eyes_[i].inliers.reserve(parts);
    }
    ahead_.release();   // its thread knows the old tools only
    // All that a frame may need: update() takes no memory later.
    windows_.reserve(parts);
    predicted_.reserve(parts);
    parts_.reserve(parts);
    noise_.reserve(parts);
    nominalPoints_.reserve(parts);
    imagePoints_.reserve(parts);
    used_.reserve(parts);
    matches_.reserve(parts * QGOMatcher::Params().candidates);
    tools_.push_back(tool);
    views_.push_back(ToolView());
    reset(int(tools_.size()) - 1);
    return int(tools_.size()) - 1;
}

void ToolTrackerImpl::reset(int tool)
{
    CV_Check(tool, tool >= -1 && tool < int(tools_.size()), "no such tool");
    if (ahead_) ahead_->clear();
    for (int i = 0; i < int(tools_.size()); i++)
    {
        if (tool >= 0 && i != tool) continue;
        TrackedTool& t = tools_[i];
        t.filter->reset(Matx44d::eye());
        if (t.full) t.full->reset();
        t.contourSupport = 0;
        t.boosted = t.unseen = t.searches = 0;
        t.searched = t.points = false;
        t.correction = t.trusted = Matx44d::eye();
        t.state = STATE_INITIALIZING;
        t.confirmed = 0;
        t.hypothesis = 0;
        t.lastSeen = -DBL_MAX;
        t.similarity = t.nis = 0;
        t.visibleParts = 0;
        t.inliers.clear();
    }
}

void ToolTrackerImpl::checkJoints(const std::vector<std::vector<double> >& joints) const
{
    if (tools_.empty()) CV_Error(Error::StsError, "no tool: addTool() comes first");
    CV_CheckEQ(joints.size(), tools_.size(), "joints: one vector per tool");
    for (size_t i = 0; i < joints.size(); i++)
    {
        const size_t expected = tools_[i].coordinates;
        if (joints[i].size() != expected)
            CV_Error(Error::StsBadSize, format("joints[%d] has %d values, tool %s has %d coordinates", int(i), int(joints[i].size()),
                                               tools_[i].model->name().c_str(), int(expected)));
        if (!checkRange(joints[i])) CV_Error(Error::StsBadArg, format("joints[%d] holds a value that is not finite", int(i)));
    }
}

void ToolTrackerImpl::check(const Mat& image, const Eye& eye, const char* name) const
{
    checkImage(image);
    if (image.size() != eye.imageSize)
        CV_Error(Error::StsUnmatchedSizes, format("%s is %d x %d, the camera's is %d x %d", name, image.cols, image.rows,
                                                  eye.imageSize.width, eye.imageSize.height));
}

void ToolTrackerImpl::checkTime(double time) const
{
    if (!(time > time_ && time < DBL_MAX)) CV_Error(Error::StsOutOfRange, format("time %g must be finite and larger than the last, %g", time, time_));
}

// Where the kinematics and the last correction say everything is.
void ToolTrackerImpl::placeTools(const std::vector<std::vector<double> >& joints)
{
    joints_ = joints;
    for (size_t i = 0; i < tools_.size(); i++)
    {
        TrackedTool& tool = tools_[i];
        if (tool.full)
        {
            tool.full->copyTo(*tool.spare);
            tool.full->predict(joints[i], tool.boosted > 0 ? pushedGrowth : 1);
            views_[i] = tool.full->view();
        }
        else
        {
            tool.model->forwardKinematics(joints[i], views_[i].base_T_link);
            views_[i].camera_T_base = tool.correction * tool.nominal_T_base;
        }
        const std::vector<ToolModel::Keypoint>& keypoints = tool.model->keypoints();
        tool.nominalPoints.resize(keypoints.size());
        tool.inliers.reserve(keypoints.size());
        for (size_t k = 0; k < keypoints.size(); k++)
            tool.nominalPoints[k] = transform(tool.nominal_T_base * views_[i].base_T_link[keypoints[k].link], keypoints[k].linkPoint);
    }
}

// A tool that may be anywhere hides nothing; alone: no other tool hides this one, which may be anywhere itself.
const std::vector<PartTemplate>& ToolTrackerImpl::draw(int index, Eye& eye, double scale, double rotation, bool alone)
{
    StageTimer timer(times_, RENDER);
    eye.views = views_;
    for (int i = 0; i < int(eye.views.size()); i++)
    {
        if (i != index && (alone || !tools_[i].isLocated())) eye.views[i].base_T_link.clear();
        if (&eye != &eyes_[0]) eye.views[i].camera_T_base = eye.eye_T_camera * eye.views[i].camera_T_base;
    }
    eye.renderer->render(eye.camera, eye.views, index, eye.templates, scale, rotation);
    return eye.templates;
}

/* Paper, Sec. 2.1 and 2.2: matches templates in windows and verifies; the result is in eye.inliers.
   templates: of the start or of about where the tool is
   halfWindow: of the search windows [pixel]; larger where the filter's covariance asks for it, unless starting */
void ToolTrackerImpl::locate(int index, Eye& eye, const std::vector<PartTemplate>& templates, double halfWindow, bool starting)
{
    TrackedTool& tool = tools_[index];
    eye.inliers.clear();
    const Rect all(Point(), eye.camera.imageSize());
    windows_.clear();
    predicted_.clear();
    Rect roi;
    for (size_t i = 0; i < templates.size(); i++)
    {
        const PartTemplate& t = templates[i];
        double hx = halfWindow, hy = halfWindow;
        if (!starting && params_.method != METHOD_EPNP)
        {
            const Matx22d C = tool.full ? tool.full->imageCovariance(eye.camera, eye.eye_T_camera, t.part)
                                        : tool.filter->imageCovariance(tool.nominalPoints[t.part]);
            hx = std::min(std::max(hx, 3 * std::sqrt(C(0, 0))), 4 * halfWindow);
            hy = std::min(std::max(hy, 3 * std::sqrt(C(1, 1))), 4 * halfWindow);
        }
        Point2d predicted = t.imagePoint;
        if (&templates != &eye.templates)   // drawn ahead
        {
            const Point3d p = transform(tool.correction, tool.nominalPoints[t.part]);
            if (p.z > 1e-3) predicted = eye.camera.project(p);
        }
        predicted_.push_back(predicted);
        const Point2d at = Point2d(t.anchor) + Point2d(cvRound(predicted.x - t.imagePoint.x), cvRound(predicted.y - t.imagePoint.y));
        windows_.push_back(Rect(cvRound(at.x - hx), cvRound(at.y - hy), cvRound(2 * hx) + 1, cvRound(2 * hy) + 1) & all);
        const Rect& w = windows_.back();
        if (w.empty()) continue;
        const Rect reach = Rect(w.x + t.bounds.x, w.y + t.bounds.y, w.width + t.bounds.width, w.height + t.bounds.height) & all;
        roi = roi.empty() ? reach : roi | reach;
    }
    if (roi.empty()) return;
    {
        StageTimer timer(times_, IMAGE);
        eye.reduce(roi);
        eye.matcher->setImage(eye.pixels(), roi);
    }
    {
        StageTimer timer(times_, MATCH);
        eye.matcher->match(templates, windows_, matches_);
        for (size_t i = 0; i < matches_.size(); i++) matches_[i].predictedPoint = predicted_[matches_[i].templateIndex];
    }
    StageTimer timer(times_, VERIFY);
    (starting ? startVerifier_ : verifier_)->verify(matches_, eye.inliers);
}

void ToolTrackerImpl::gather(const TrackedTool& tool)
{
    nominalPoints_.clear();
    imagePoints_.clear();
    for (size_t i = 0; i < tool.inliers.size(); i++)
    {
        nominalPoints_.push_back(tool.nominalPoints[tool.inliers[i].part]);
        imagePoints_.push_back(tool.inliers[i].imagePoint);
    }
}

// One template a part at the last correction, then the filter (paper, Sec. 2.3).
bool ToolTrackerImpl::measure(int index, const TemplateSet* ahead)
{
    TrackedTool& tool = tools_[index];
    Eye& eye = eyes_[0];
    const bool filtered = params_.method == METHOD_PAPER;
    if (filtered) tool.filter->predict();
    const std::vector<PartTemplate>& templates = ahead && tool.usesDrawnAhead() ? ahead->templates[index] : draw(index, eye);
    locate(index, eye, templates, params_.minWindow * pixelScale_, false);
    tool.inliers = eye.inliers;
    tool.visibleParts = int(templates.size());
    if (tool.inliers.empty()) return false;

    StageTimer timer(times_, FILTER);
    gather(tool);
    if (!filtered)
    {
        Matx44d correction;
        if (!solveEPnP(eye.camera, nominalPoints_, imagePoints_, correction) || !plausible(tool, correction)) return false;
        tool.correction = correction;
        return true;
    }
    if (!(tool.settles() && correctFromHandEye(tool)) && !tool.filter->correct(nominalPoints_, imagePoints_, used_)) return false;
    size_t kept = 0;
    for (size_t i = 0; i < used_.size(); i++)
        if (used_[i]) tool.inliers[kept++] = tool.inliers[i];
    tool.inliers.resize(kept);
    // A lost tool is found again on the evidence of a start, and none where no calibration error could have put it.
    const bool found = tool.state != STATE_LOST
                       || (int(kept) >= params_.minInitialInliers && meanSimilarity(tool.inliers) >= params_.minInitialSimilarity);
    if (!found || !plausible(tool, tool.filter->correction()))
    {
        tool.filter->reset(tool.correction);
        return false;
    }
    tool.correction = tool.filter->correction();
    tool.nis = tool.filter->nis();
    return true;
}

// The state after a frame.
void ToolTrackerImpl::conclude(TrackedTool& tool, bool seen) const
{
    if (seen)
    {
        tool.lastSeen = time_;
        tool.confirmed++;
        if (tool.confirmed > params_.confirmFrames)
        {
            tool.state = STATE_TRACKING;
            tool.trusted = tool.correction;
        }
    }
    else
    {
        if (tool.state == STATE_TRACKING) tool.state = STATE_COASTING;
        if (tool.state == STATE_COASTING && time_ - tool.lastSeen > params_.coastingTime) tool.state = STATE_LOST;
        if (tool.state != STATE_COASTING && tool.confirmed > 0)
        {
            tool.confirmed = 0;
            tool.correction = tool.trusted;
            tool.filter->reset(tool.correction);
        }
        tool.inliers.clear();
        tool.nis = 0;
    }
    tool.similarity = meanSimilarity(tool.inliers);
}

void ToolTrackerImpl::report(const TrackedTool& tool, const ToolView& view, ToolEstimate& e) const
{
    const Matx44d nominal_T_tool = tool.nominal_T_base * tool.model->endEffectorFromLinks(view.base_T_link);
    e.state = tool.state;
    e.camera_T_nominal = tool.correction;
    e.camera_T_tool = tool.correction * nominal_T_tool;
    e.jointOffsets.assign(tool.coordinates, 0.);
    e.contourSupport = tool.contourSupport;
    if (tool.full)
    {
        e.covariance = tool.full->poseCovariance();
        std::copy(tool.full->offsets().begin(), tool.full->offsets().end(), e.jointOffsets.begin());
    }
    if (params_.method == METHOD_PAPER)
        e.covariance = tool.filter->poseCovariance(Point3d(nominal_T_tool(0, 3), nominal_T_tool(1, 3), nominal_T_tool(2, 3)));
    e.visibleParts = tool.visibleParts;
    e.inliers = int(tool.inliers.size());
    e.similarity = tool.similarity;
    e.nis = tool.nis;
    e.matches.reserve(tool.inliers.capacity());
    e.matches = tool.inliers;
    for (size_t i = 0; i < e.matches.size(); i++)
    {
        e.matches[i].imagePoint = enlarge(e.matches[i].imagePoint, eyes_[0].reduction);
        e.matches[i].predictedPoint = enlarge(e.matches[i].predictedPoint, eyes_[0].reduction);
    }
}

void ToolTrackerImpl::updateEyes(double time, const std::vector<std::vector<double> >& joints, std::vector<ToolEstimate>& estimates)
{
    times_.beginFrame();
    {
        StageTimer timer(times_, TOTAL);
        placeTools(joints);
        const TemplateSet* ahead = 0;
        {
            StageTimer renderTimer(times_, RENDER);
            try
            {
                ahead = drawnAhead();
            }
            catch (...)   // of the second thread; as if this frame had not been
            {
                for (size_t i = 0; i < tools_.size(); i++)
                    if (tools_[i].full) tools_[i].spare->copyTo(*tools_[i].full);
                throw;
            }
        }
        time_ = time;
        for (int i = 0; i < int(tools_.size()); i++)
        {
            TrackedTool& tool = tools_[i];
            if (tool.full)
            {
                tool.boosted = std::max(0, tool.boosted - 1);
                bool seen = tool.starts() ? startFull(i) : measureFull(i, ahead);
                if (!seen && !tool.starts()) seen = searchFull(i);
                concludeFull(tool, seen);
            }
            else
            {
                bool seen = tool.starts() ? start(i) : measure(i, ahead);
                if (!seen && tool.state == STATE_LOST) seen = search(i);
                conclude(tool, seen);
            }
            // Others are drawn, and hidden, where this tool was found.
            if (tool.full) views_[i] = tool.full->view();
            else views_[i].camera_T_base = tool.correction * tool.nominal_T_base;
        }
    }
    estimates.resize(tools_.size());
    if (ahead_) ahead_->nextFrame();
    for (size_t i = 0; i < tools_.size(); i++) report(tools_[i], views_[i], estimates[i]);
    for (size_t i = 0; i < eyes_.size(); i++) eyes_[i].image.release();
    times_.endFrame();
}

void ToolTrackerImpl::update(InputArray image, double time, const std::vector<std::vector<double> >& joints, std::vector<ToolEstimate>& estimates)
{
    const Mat left = image.getMat();
    checkJoints(joints);
    check(left, eyes_[0], "image");
    checkTime(time);
    open_ = 1;
    eyes_[0].image = left;
    updateEyes(time, joints, estimates);
}

void ToolTrackerImpl::updateStereo(InputArray _left, InputArray _right, double time, const std::vector<std::vector<double> >& joints,
                                   std::vector<ToolEstimate>& estimates)
{
    if (eyes_.size() < 2) CV_Error(Error::StsError, "no right camera: setRightCamera() comes first");
    const Mat left = _left.getMat(), right = _right.getMat();
    checkJoints(joints);
    check(left, eyes_[0], "left");
    check(right, eyes_[1], "right");
    CV_CheckTypeEQ(left.type(), right.type(), "left and right must be of the same type");
    checkTime(time);
    open_ = 2;
    eyes_[0].image = left;
    eyes_[1].image = right;
    updateEyes(time, joints, estimates);
}

Ptr<ToolTracker> ToolTracker::create(const CameraModel& camera, const Params& params)
{
    return makePtr<ToolTrackerImpl>(camera, params);
}

}} // namespace cv::surgtrack
