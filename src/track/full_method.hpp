// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_TRACK_FULL_METHOD_HPP
#define OPENCV_SURGTRACK_SRC_TRACK_FULL_METHOD_HPP

#include <functional>
#include "opencv2/surgtrack/articulated_pose_ekf.hpp"
#include "track/tool_method.hpp"

namespace cv { namespace surgtrack {

//! A pose, and what it has to show for itself.
struct FullPose
{
    ArticulatedPoseEKF::State filter;
    Matx44d correction;
    Evidence evidence;
    std::vector<PartMatch> inliers;
    int visibleParts;
    size_t eyes;
};

//! A second pose that explains the image about as well as the one that is believed.
struct Rival
{
    FullPose pose;
    double lead;   // log odds against the one that is believed, of all frames since
    int frames;    // since, with the first one; 0: there is none
};

//! What METHOD_FULL knows from frame to frame, beside its filter.
struct FullMemory
{
    ArticulatedPoseEKF::State sure_;       // the filter when the tool was last tracked
    double logOdds_;                       // that the last pose seen is right
    bool isSeen_;                          // in this frame
    double usual_;                         // log odds of the frames before by their own evidence
    int searches_;                         // since the tool was last seen
    bool searched_;                        // the pose is that of a search, and not confirmed yet
    size_t eyes_;                          // that are believed to stand where they are said to
    int disagreed_;                        // consecutive frames in which the right eye did not see what the left one saw
    int boosted_;                          // frames for which the process noise stays raised,
    int pushed_;                           // and for which a push is going on
    int settling_;                         // frames that have gone into where the calibration is settled
    int disputed_;                         // frames in which another tool saw another motion of the camera
    Rival rival_;
};

//! METHOD_FULL: parts and outlines of all eyes, into one filter of correction and joint offsets, believed by evidence.
class FullMethod CV_FINAL : public ToolMethod, private FullMemory
{
public:
    FullMethod(int index, const Ptr<ToolModel>& model, const Matx44d& nominal_T_base, const ToolTracker::Params& params, double pixelScale,
               const ArticulatedPoseEKF::Params& filter, const ToolContour::Params& contour, const ContourSearch& edges);

    void reset() CV_OVERRIDE;
    void takeBack() CV_OVERRIDE
    {
        ToolMethod::takeBack();
        static_cast<FullMemory&>(*this) = before_;
        filter_->dropReadings();
        filter_->setState(placed_);
    }
    void measure(Scene& scene, const PartDrawing* ahead) CV_OVERRIDE;
    double sureness() const CV_OVERRIDE { return state_ == STATE_TRACKING ? evidence_.logOdds() : -DBL_MAX; }
    const ToolView& view() const CV_OVERRIDE { return filter_->view(); }
    void report(ToolEstimate& estimate) const CV_OVERRIDE;
    ReadingErrors readingErrors() const CV_OVERRIDE { return filter_->readingErrors(); }
    void setReadingErrors(const ReadingErrors& errors) CV_OVERRIDE;
    void setHandEye(const Matx44d& nominal_T_base) CV_OVERRIDE;
    void moveCamera(const Matx44d& now_T_before) CV_OVERRIDE;
    void inherit(const ToolMethod& other) CV_OVERRIDE;

private:
    // Windows in which edges are looked for: a first pose begins with the widest.
    typedef FullPose Pose;

    static const int startPass = 0, trackPass = 2, nearPass = 3;

    void correctJoints(const std::vector<double>& readings, std::vector<double>& joints) const CV_OVERRIDE { filter_->correctJoints(readings, joints); }
    const ToolView& predict(const std::vector<double>& joints, double seconds) CV_OVERRIDE;
    Pose pose() const;
    void keepPose(Pose& pose) const;
    void setPose(const Pose& pose);

    bool start(Scene& scene);
    bool search(Scene& scene);
    bool beginAnew(Scene& scene, int first, int last);
    void fit(Scene& scene, const StartCandidate& candidate);

    bool follow(Scene& scene, const PartDrawing* ahead);
    void expectParts(const PartFinder& eye, bool known);
    bool correct(Scene& scene);
    int correctPoints(Scene& scene, size_t eyes);
    void correctByOutline(Scene& scene);
    void correctAnew(Scene& scene);
    enum { NEARER, FARTHER, CAMERA };
    bool displace(const Scene& scene, const ArticulatedPoseEKF::State& predicted, int where);
    bool isBetter(const Pose& other) const;
    double distance(const Pose& pose) const;
    bool isDisputed(const Scene& scene);
    void followRival(Scene& scene);
    void judgeRival();
    //! Between two poses of which only one can be right.
    bool isTorn() const;
    void spanRival(Matx66d& covariance) const;
    void dropPoints(Scene& scene);
    int addPoints(Scene& scene, size_t eyes, double tolerance);

    void sampleOutline(Scene& scene, size_t eye, const PartDrawing& drawing);
    void redraw(Scene& scene, size_t eye);
    double refine(Scene& scene, int firstPass);
    double support(Scene& scene, const double* strengths);
    const ToolView& seenBy(const PartFinder& eye);
    void placeOutline(const PartFinder& eye, std::vector<ContourPoint>& outline);
    size_t eyes(const Scene& scene) const { return std::min(scene.open, eyes_); }
    void judgeEyes(Scene& scene);
    double prior(double time) const;
    bool continues(const Scene& scene) const;
    void conclude(const Scene& scene, bool seen);
    void moveStates(const std::function<void(ArticulatedPoseEKF&)>& move);

    Ptr<ArticulatedPoseEKF> filter_;
    Ptr<ToolContour> contour_;
    ContourSearch edges_;
    EvidenceThresholds thresholds_;
    ArticulatedPoseEKF::State placed_;     // the filter before this frame, and what is known beside it
    FullMemory before_;

    double ownOdds_;                       // log odds, with the past, of the pose that did not do to be followed

    // Memory of one function each.
    Pose without_, far_;
    PartWindows windows_;
    ToolView seen_;
    std::vector<int> parts_;
    std::vector<Point2d> imagePoints_;
    std::vector<double> noise_;
    std::vector<uchar> used_;
};

}} // namespace cv::surgtrack

#endif
