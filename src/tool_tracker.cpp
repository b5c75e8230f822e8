// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"

namespace cv { namespace surgtrack {

String stateName(int state)
{
    static const char* names[] = {"initializing", "tracking", "coasting", "lost"};
    CV_Check(state, state >= STATE_INITIALIZING && state <= STATE_LOST, "no such state");
    return names[state];
}

ToolEstimate::ToolEstimate()
    : state(STATE_INITIALIZING), camera_T_tool(Matx44d::eye()), camera_T_nominal(Matx44d::eye()), covariance(Matx66d::zeros()),
      visibleParts(0), inliers(0), similarity(0), nis(0)
{
}

ToolTracker::Params::Params()
    : method(METHOD_PAPER), initialWindow(0.014), minWindow(30), minInitialInliers(6), minInitialSimilarity(0.65), confirmFrames(1), coastingTime(2), seed(1)
{
}

std::vector<String> ToolTracker::timingNames()
{
    static const char* names[] = {"render", "image", "match", "verify", "filter", "total"};
    return std::vector<String>(names, names + 6);
}

namespace {

enum Stage { RENDER, IMAGE, MATCH, VERIFY, FILTER, TOTAL, STAGES };

// Adds the time of a scope to its stage.
class StageTimer
{
public:
    explicit StageTimer(double& sum) : sum_(sum), start_(getTickCount()) {}
    ~StageTimer() { sum_ += double(getTickCount() - start_) / getTickFrequency(); }

private:
    double& sum_;
    int64 start_;
};

const int hypotheses = 9;   // of scale and rotation

// Plausible errors of a hand-eye calibration; a first pose beyond them is a false one.
const double maxCorrectionAngle = 15 * CV_PI / 180;
const double maxCorrectionShift = 0.03;     // [m], at the tool
const double maxReprojectionError = 8;      // [pixel at 720 px image width]

double rotationAngle(const Matx44d& T)
{
    return std::acos(std::min(1., std::max(-1., (T(0, 0) + T(1, 1) + T(2, 2) - 1) / 2)));
}

double meanSimilarity(const std::vector<PartMatch>& matches)
{
    double sum = 0;
    for (size_t i = 0; i < matches.size(); i++) sum += matches[i].similarity;
    return matches.empty() ? 0 : sum / double(matches.size());
}

struct TrackedTool
{
    Ptr<ToolModel> model;
    Matx44d nominal_T_base;
    Ptr<ToolPoseEKF> filter;
    Matx44d correction;              // the last one; kept when nothing is seen
    Matx44d trusted;                 // the last one that was tracked; what an unconfirmed one goes back to
    int state;
    int hypothesis;                  // of the search for a lost tool
    int confirmed;                   // consecutive measured frames since the (re)start
    double lastSeen;                 // time of the last measurement [s]
    std::vector<Point3d> nominalPoints;   // of the current frame
    double similarity, nis;
    int visibleParts;
    std::vector<PartMatch> inliers;
};

// Widths of gradients, of spreading and of zones are pixels of an image about this wide.
const int referenceWidth = 720;

// The camera whose pixels are the means of factor x factor pixels.
CameraModel reduceCamera(const CameraModel& camera, int factor)
{
    const double f = 1. / factor;
    const Matx33d K(camera.fx * f, 0, (camera.cx + 0.5) * f - 0.5, 0, camera.fy * f, (camera.cy + 0.5) * f - 0.5, 0, 0, 1);
    return CameraModel(K, camera.distCoeffs(), Size(camera.imageSize().width / factor, camera.imageSize().height / factor));
}

inline Point2d enlarge(const Point2d& p, int factor)
{
    return Point2d((p.x + 0.5) * factor - 0.5, (p.y + 0.5) * factor - 0.5);
}

class ToolTrackerImpl CV_FINAL : public ToolTracker
{
public:
    ToolTrackerImpl(const CameraModel& camera, const Params& params);

    int addTool(const Ptr<ToolModel>& model, const Matx44d& nominal_T_base) CV_OVERRIDE;
    void update(InputArray image, double time, const std::vector<std::vector<double> >& joints, std::vector<ToolEstimate>& estimates) CV_OVERRIDE;
    void reset(int tool) CV_OVERRIDE;
    std::vector<double> getTimings() const CV_OVERRIDE { return std::vector<double>(timings_, timings_ + STAGES); }

private:
    void check(const Mat& image, double time, const std::vector<std::vector<double> >& joints) const;
    void placeTools(const std::vector<std::vector<double> >& joints);
    void locate(int tool, const Mat& image, double halfWindow, bool starting, double scale, double rotation);
    bool initialize(int tool, const Mat& image, int first, int last);
    bool startFromHandEye(int tool, const Mat& image);
    bool measure(int tool, const Mat& image);
    bool plausible(const TrackedTool& tool, const Matx44d& correction) const;
    void gather(const TrackedTool& tool, Mat& nominalPoints, Mat& imagePoints) const;
    void report(const TrackedTool& tool, const ToolView& view, ToolEstimate& estimate) const;

    Size imageSize_;       // of the images given
    int reduction_;        // by this they are reduced; camera_ and all image points inside are those of the reduced image
    CameraModel camera_;
    Mat reduced_;
    Params params_;
    double pixelScale_;    // of thresholds given for images 720 pixels wide
    Ptr<PartTemplateRenderer> renderer_;
    Ptr<QGOMatcher> matcher_;
    Ptr<GeometricContextVerifier> verifier_, startVerifier_;   // the first pose needs more points to agree
    std::vector<TrackedTool> tools_;
    std::vector<ToolView> views_;
    double time_;

    // of one locate()
    std::vector<PartTemplate> templates_;
    std::vector<Rect> windows_;
    std::vector<PartMatch> matches_;
    std::vector<PartMatch> inliers_;

    double timings_[STAGES];
};

ToolTrackerImpl::ToolTrackerImpl(const CameraModel& camera, const Params& params)
    : imageSize_(camera.imageSize()), reduction_(std::max(1, imageSize_.width / referenceWidth)), camera_(reduceCamera(camera, reduction_)),
      params_(params), pixelScale_(camera_.imageSize().width / double(referenceWidth)), time_(-DBL_MAX)
{
    CV_Assert(!camera.imageSize().empty());
    CV_Check(params.method, params.method == METHOD_PAPER || params.method == METHOD_EPNP, "Params::method: no such method");
    CV_CheckGE(params.minInitialInliers, 4, "Params::minInitialInliers: EPnP needs four points");
    CV_Check(params.initialWindow, params.initialWindow > 0 && params.initialWindow < DBL_MAX, "Params::initialWindow must be positive");
    CV_Check(params.minWindow, params.minWindow > 0 && params.minWindow < 1e5, "Params::minWindow must be positive");
    CV_Check(params.minInitialSimilarity, params.minInitialSimilarity >= 0 && params.minInitialSimilarity <= 1, "Params::minInitialSimilarity must be in 0..1");
    CV_CheckGE(params.confirmFrames, 0, "Params::confirmFrames must not be negative");
    CV_Check(params.coastingTime, params.coastingTime >= 0 && params.coastingTime < DBL_MAX, "Params::coastingTime must not be negative");
    renderer_ = PartTemplateRenderer::create();
    matcher_ = QGOMatcher::create();
    GeometricContextVerifier::Params context;
    context.seed = params.seed;
    context.zoneRadius *= pixelScale_;
    context.centredZones = false;   // both methods are the paper's: fixed cells, the first sample that agrees
    context.maxScale = context.maxRotation = 0;
    verifier_ = GeometricContextVerifier::create(context);
    context.minInliers = params.minInitialInliers;
    startVerifier_ = GeometricContextVerifier::create(context);
    std::fill(timings_, timings_ + STAGES, 0.);
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
    tool.nominal_T_base = nearestRigid(nominal_T_base);
    ToolPoseEKF::Params filter;
    filter.measurementNoise *= pixelScale_;
    filter.minPoints = 4;   // as many as must agree on the geometric context
    tool.filter = ToolPoseEKF::create(camera_, filter);
    renderer_->addTool(model);
    tools_.push_back(tool);
    views_.push_back(ToolView());
    reset(int(tools_.size()) - 1);
    return int(tools_.size()) - 1;
}

void ToolTrackerImpl::reset(int tool)
{
    CV_Check(tool, tool >= -1 && tool < int(tools_.size()), "no such tool");
    for (int i = 0; i < int(tools_.size()); i++)
    {
        if (tool >= 0 && i != tool) continue;
        TrackedTool& t = tools_[i];
        t.filter->reset(Matx44d::eye());
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

void ToolTrackerImpl::check(const Mat& image, double time, const std::vector<std::vector<double> >& joints) const
{
    if (tools_.empty()) CV_Error(Error::StsError, "no tool: addTool() comes first");
    checkImage(image);
    if (image.size() != imageSize_)
        CV_Error(Error::StsUnmatchedSizes, format("image is %d x %d, the camera's is %d x %d", image.cols, image.rows,
                                                  imageSize_.width, imageSize_.height));
    if (!(time > time_ && time < DBL_MAX)) CV_Error(Error::StsOutOfRange, format("time %g must be finite and larger than the last, %g", time, time_));
    CV_CheckEQ(joints.size(), tools_.size(), "joints: one vector per tool");
    for (size_t i = 0; i < joints.size(); i++)
    {
        const size_t expected = tools_[i].model->coordinateNames().size();
        if (joints[i].size() != expected)
            CV_Error(Error::StsBadSize, format("joints[%d] has %d values, tool %s has %d coordinates", int(i), int(joints[i].size()),
                                               tools_[i].model->name().c_str(), int(expected)));
        checkFinite(joints[i], format("joints[%d]", int(i)).c_str());
    }
}

// Where the kinematics and the last correction say everything is.
void ToolTrackerImpl::placeTools(const std::vector<std::vector<double> >& joints)
{
    for (size_t i = 0; i < tools_.size(); i++)
    {
        TrackedTool& tool = tools_[i];
        tool.model->forwardKinematics(joints[i], views_[i].base_T_link);
        views_[i].camera_T_base = tool.correction * tool.nominal_T_base;
        const std::vector<ToolModel::Keypoint>& keypoints = tool.model->keypoints();
        tool.nominalPoints.resize(keypoints.size());
        for (size_t k = 0; k < keypoints.size(); k++)
            tool.nominalPoints[k] = transform(tool.nominal_T_base * views_[i].base_T_link[keypoints[k].link], keypoints[k].linkPoint);
    }
}

/* Paper, Sec. 2.1 and 2.2: renders templates, matches them in windows and verifies; the result is in inliers_.
   halfWindow: of the search windows [pixel]; larger where the filter's covariance asks for it, unless starting */
void ToolTrackerImpl::locate(int index, const Mat& image, double halfWindow, bool starting, double scale, double rotation)
{
    TrackedTool& tool = tools_[index];
    {
        StageTimer timer(timings_[RENDER]);
        renderer_->render(camera_, views_, index, templates_, scale, rotation);
    }
    inliers_.clear();
    if (templates_.empty()) return;

    const Rect all(Point(), image.size());
    windows_.clear();
    Rect roi;
    for (size_t i = 0; i < templates_.size(); i++)
    {
        const PartTemplate& t = templates_[i];
        double hx = halfWindow, hy = halfWindow;
        if (!starting && params_.method != METHOD_EPNP)
        {
            const Matx22d C = tool.filter->imageCovariance(tool.nominalPoints[t.part]);
            hx = std::min(std::max(hx, 3 * std::sqrt(C(0, 0))), 4 * halfWindow);
            hy = std::min(std::max(hy, 3 * std::sqrt(C(1, 1))), 4 * halfWindow);
        }
        windows_.push_back(Rect(cvRound(t.anchor.x - hx), cvRound(t.anchor.y - hy), cvRound(2 * hx) + 1, cvRound(2 * hy) + 1) & all);
        const Rect& w = windows_.back();
        if (w.empty()) continue;
        const Rect reach = Rect(w.x + t.bounds.x, w.y + t.bounds.y, w.width + t.bounds.width, w.height + t.bounds.height) & all;
        roi = roi.empty() ? reach : roi | reach;
    }
    {
        StageTimer timer(timings_[IMAGE]);
        matcher_->setImage(image, roi);
    }
    {
        StageTimer timer(timings_[MATCH]);
        matcher_->match(templates_, windows_, matches_);
    }
    StageTimer timer(timings_[VERIFY]);
    (starting ? startVerifier_ : verifier_)->verify(matches_, inliers_);
}

void ToolTrackerImpl::gather(const TrackedTool& tool, Mat& nominalPoints, Mat& imagePoints) const
{
    nominalPoints.create(int(tool.inliers.size()), 3, CV_64F);
    imagePoints.create(int(tool.inliers.size()), 2, CV_64F);
    for (int i = 0; i < int(tool.inliers.size()); i++)
    {
        *nominalPoints.ptr<Point3d>(i) = tool.nominalPoints[tool.inliers[i].part];
        *imagePoints.ptr<Point2d>(i) = tool.inliers[i].imagePoint;
    }
}

bool ToolTrackerImpl::plausible(const TrackedTool& tool, const Matx44d& correction) const
{
    Point3d centre;
    for (size_t i = 0; i < tool.nominalPoints.size(); i++) centre += tool.nominalPoints[i] * (1. / tool.nominalPoints.size());
    if (rotationAngle(correction) > maxCorrectionAngle || norm(transform(correction, centre) - centre) > maxCorrectionShift) return false;
    double sum = 0;
    for (size_t i = 0; i < tool.inliers.size(); i++)
    {
        const Point3d p = transform(correction, tool.nominalPoints[tool.inliers[i].part]);
        if (p.z < 1e-3) return false;
        const Point2d d = camera_.project(p) - tool.inliers[i].imagePoint;
        sum += d.dot(d);
    }
    return std::sqrt(sum / double(tool.inliers.size())) < maxReprojectionError * pixelScale_;
}

// Several scales and rotations about the kinematics' pose (paper, Sec. 2.1), the best agreement goes to EPnP (Sec. 2.3).
// first, last: which of the nine hypotheses
bool ToolTrackerImpl::initialize(int index, const Mat& image, int first, int last)
{
    static const double scales[] = {1, 0.8, 1.2}, rotations[] = {0, -15 * CV_PI / 180, 15 * CV_PI / 180};
    TrackedTool& tool = tools_[index];
    const double distance = transform(tool.correction, tool.nominalPoints[0]).z;
    const double halfWindow = params_.initialWindow * std::max(camera_.fx, camera_.fy) / std::max(distance, 0.02);
    tool.inliers.clear();
    double bestScore = 0;
    for (int i = first; i <= last; i++)
    {
        locate(index, image, halfWindow, true, scales[i / 3], rotations[i % 3]);
        if (i == first) tool.visibleParts = int(templates_.size());
        double score = 0;
        for (size_t k = 0; k < inliers_.size(); k++) score += inliers_[k].similarity;
        if (score <= bestScore) continue;
        bestScore = score;
        tool.inliers = inliers_;
        tool.visibleParts = int(templates_.size());
    }
    Mat nominalPoints, imagePoints;
    Matx44d correction;
    {
        StageTimer timer(timings_[FILTER]);
        gather(tool, nominalPoints, imagePoints);
        if (tool.inliers.empty() || !solveEPnP(camera_, nominalPoints, imagePoints, correction, maxReprojectionError * pixelScale_)
            || !plausible(tool, correction))
        {
            tool.inliers.clear();
            return false;
        }
    }
    const Matx44d before = tool.correction;
    tool.filter->reset(correction);
    tool.correction = correction;
    if (params_.method == METHOD_EPNP || startFromHandEye(index, image)) return true;
    tool.correction = before;
    tool.filter->reset(before);
    tool.inliers.clear();
    return false;
}

/* The paper's filter starts from EPnP's pose, whose depth is off by 5 mm and more, and from templates of another scale. Ours takes
   the same points in from the hand-eye calibration, whose error is of a known size, and looks again with templates that fit.
   Returns whether the tool then looks as it should; tissue does not. */
bool ToolTrackerImpl::startFromHandEye(int index, const Mat& image)
{
    TrackedTool& tool = tools_[index];
    Mat nominalPoints, imagePoints;
    for (int pass = 0; pass < 3; pass++)
    {
        if (pass > 0)
        {
            views_[index].camera_T_base = tool.correction * tool.nominal_T_base;
            locate(index, image, params_.minWindow * pixelScale_, true, 1, 0);
            if (inliers_.empty()) return false;
            tool.inliers = inliers_;
            tool.visibleParts = int(templates_.size());
        }
        StageTimer timer(timings_[FILTER]);
        gather(tool, nominalPoints, imagePoints);
        tool.filter->reset(Matx44d::eye());
        std::vector<uchar> used;
        // Points that such a calibration does not explain: EPnP's pose, as after a move of the camera.
        if (tool.filter->correct(nominalPoints, imagePoints, used) && 2 * countNonZero(used) > int(used.size()))
            tool.correction = tool.filter->correction();
        else tool.filter->reset(tool.correction);
    }
    return meanSimilarity(tool.inliers) >= params_.minInitialSimilarity && plausible(tool, tool.correction);
}

// One template a part at the last correction, then the filter (paper, Sec. 2.3).
bool ToolTrackerImpl::measure(int index, const Mat& image)
{
    TrackedTool& tool = tools_[index];
    const bool filtered = params_.method == METHOD_PAPER;
    if (filtered) tool.filter->predict();
    locate(index, image, params_.minWindow * pixelScale_, false, 1, 0);
    tool.inliers = inliers_;
    tool.visibleParts = int(templates_.size());
    if (tool.inliers.empty()) return false;

    StageTimer timer(timings_[FILTER]);
    Mat nominalPoints, imagePoints;
    gather(tool, nominalPoints, imagePoints);
    if (!filtered)
    {
        Matx44d correction;
        if (!solveEPnP(camera_, nominalPoints, imagePoints, correction) || !plausible(tool, correction)) return false;
        tool.correction = correction;
        return true;
    }
    std::vector<uchar> used;
    if (!tool.filter->correct(nominalPoints, imagePoints, used)) return false;
    size_t kept = 0;
    for (size_t i = 0; i < used.size(); i++)
        if (used[i]) tool.inliers[kept++] = tool.inliers[i];
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

void ToolTrackerImpl::report(const TrackedTool& tool, const ToolView& view, ToolEstimate& e) const
{
    const Matx44d nominal_T_tool = tool.nominal_T_base * tool.model->endEffectorFromLinks(view.base_T_link);
    e.state = tool.state;
    e.camera_T_nominal = tool.correction;
    e.camera_T_tool = tool.correction * nominal_T_tool;
    if (params_.method == METHOD_PAPER)
        e.covariance = tool.filter->poseCovariance(Point3d(nominal_T_tool(0, 3), nominal_T_tool(1, 3), nominal_T_tool(2, 3)));
    e.visibleParts = tool.visibleParts;
    e.inliers = int(tool.inliers.size());
    e.similarity = tool.similarity;
    e.nis = tool.nis;
    e.matches = tool.inliers;
    for (size_t i = 0; i < e.matches.size(); i++)
    {
        e.matches[i].imagePoint = enlarge(e.matches[i].imagePoint, reduction_);
        e.matches[i].predictedPoint = enlarge(e.matches[i].predictedPoint, reduction_);
    }
}

void ToolTrackerImpl::update(InputArray _image, double time, const std::vector<std::vector<double> >& joints, std::vector<ToolEstimate>& estimates)
{
    Mat image = _image.getMat();
    check(image, time, joints);
    std::fill(timings_, timings_ + STAGES, 0.);
    {
        StageTimer timer(timings_[TOTAL]);
        if (reduction_ > 1)
        {
            StageTimer imageTimer(timings_[IMAGE]);
            const Size size = camera_.imageSize();
            resize(image(Rect(0, 0, size.width * reduction_, size.height * reduction_)), reduced_, size, 0, 0, INTER_AREA);
            image = reduced_;
        }
        time_ = time;
        placeTools(joints);
        for (int i = 0; i < int(tools_.size()); i++)
        {
            TrackedTool& tool = tools_[i];
            const bool starting = tool.state == STATE_INITIALIZING && tool.confirmed == 0;
            bool seen = starting ? initialize(i, image, 0, hypotheses - 1) : measure(i, image);
            // A lost tool is looked for in a wider window, by one hypothesis a frame.
            if (!seen && tool.state == STATE_LOST)
            {
                tool.hypothesis = (tool.hypothesis + 1) % hypotheses;
                seen = initialize(i, image, tool.hypothesis, tool.hypothesis);
            }
            if (seen)
            {
                tool.lastSeen = time;
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
                if (tool.state == STATE_COASTING && time - tool.lastSeen > params_.coastingTime) tool.state = STATE_LOST;
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
            // Others are drawn, and hidden, where this tool was found.
            views_[i].camera_T_base = tool.correction * tool.nominal_T_base;
        }
    }
    estimates.resize(tools_.size());
    for (size_t i = 0; i < tools_.size(); i++) report(tools_[i], views_[i], estimates[i]);
}

} // namespace

Ptr<ToolTracker> ToolTracker::create(const CameraModel& camera, const Params& params)
{
    return makePtr<ToolTrackerImpl>(camera, params);
}

}} // namespace cv::surgtrack
