// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_TRACK_TOOL_TRACKER_HPP
#define OPENCV_SURGTRACK_SRC_TRACK_TOOL_TRACKER_HPP

#include "precomp.hpp"
#include "track/render_ahead.hpp"
#include "track/stage_times.hpp"

namespace cv { namespace surgtrack {

// A camera, and what it is looked at with.
struct Eye
{
    Eye(const CameraModel& camera, const Matx44d& eye_T_camera, bool wholeTools);

    //! Brings reduced up to date where gradients in the roi look.
    void reduce(const Rect& roi);
    const Mat& pixels() const { return reduction > 1 ? reduced : image; }

    Size imageSize;        // of the images given
    int reduction;         // by this they are reduced; camera and all image points inside are those of the reduced image
    CameraModel camera;
    Matx44d eye_T_camera;  // the left camera's frame, in which poses are, in this one's
    Rect2d field;          // of view
    Mat image, reduced;    // reduced: up to date in the region looked at
    Ptr<PartTemplateRenderer> renderer;
    Ptr<QGOMatcher> matcher;

    std::vector<ToolView> views;   // what was drawn last, in the frame of this camera
    // of the tool that is being looked at
    std::vector<PartTemplate> templates;
    std::vector<PartMatch> inliers;
    std::vector<ContourPoint> outline;
};

struct TrackedTool
{
    Ptr<ToolModel> model;
    size_t coordinates;              // of the model
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

    // METHOD_FULL
    Ptr<ArticulatedPoseEKF> full;    // `filter` of the other methods
    Ptr<ArticulatedPoseEKF> before;  // it, as it was before a search
    Ptr<ArticulatedPoseEKF> spare, best, round;   // memory
    Ptr<ArticulatedPoseEKF> sure;    // it, as it was when the tool was last tracked
    Ptr<ToolContour> contour;
    double contourSupport;
    bool points;                     // whether parts went into the pose, not only the outline
    std::vector<PartMatch> inliersBefore, inliersOfRound;   // memory
    int unseen;                      // consecutive frames without a measurement
    int searches;                    // since the tool was last seen
    bool searched;                   // the pose is that of a search, and not confirmed yet
    int boosted;                     // frames for which the process noise stays raised

    bool starts() const { return state == STATE_INITIALIZING && confirmed == 0; }
    /* So many first frames are each taken in from the hand-eye calibration alone. Their points lean towards where the templates
       were drawn: a filter that believed them together would keep the error of the first pose, most of it depth, for minutes. */
    static const int settlingFrames = 6;
    bool settles() const { return confirmed < settlingFrames; }
    bool isLocated() const { return !starts() && state != STATE_LOST; }
    // Where a tool is not known yet, nothing can be drawn ahead.
    bool usesDrawnAhead() const { return !settles() && state != STATE_LOST; }
};

double meanSimilarity(const std::vector<PartMatch>& matches);

// tool_tracker.cpp: set-up and the frame; tool_start.cpp: the first pose, and that of a lost tool; tool_ahead.cpp: renderAhead()
class ToolTrackerImpl CV_FINAL : public ToolTracker
{
public:
    ToolTrackerImpl(const CameraModel& camera, const Params& params);

    void setRightCamera(const CameraModel& right, const Matx44d& right_T_left) CV_OVERRIDE;
    int addTool(const Ptr<ToolModel>& model, const Matx44d& nominal_T_base) CV_OVERRIDE;
    void update(InputArray image, double time, const std::vector<std::vector<double> >& joints, std::vector<ToolEstimate>& estimates) CV_OVERRIDE;
    void updateStereo(InputArray left, InputArray right, double time, const std::vector<std::vector<double> >& joints,
                      std::vector<ToolEstimate>& estimates) CV_OVERRIDE;
    void renderAhead(const std::vector<std::vector<double> >& joints) CV_OVERRIDE;
    void reset(int tool) CV_OVERRIDE;
    std::vector<StageTime> getTimings() const CV_OVERRIDE { return times_.get(); }
    void resetTimings() CV_OVERRIDE { times_.reset(); }

private:
    void checkJoints(const std::vector<std::vector<double> >& joints) const;
    void check(const Mat& image, const Eye& eye, const char* name) const;
    void checkTime(double time) const;
    void updateEyes(double time, const std::vector<std::vector<double> >& joints, std::vector<ToolEstimate>& estimates);
    void placeTools(const std::vector<std::vector<double> >& joints);
    double shiftSince(const std::vector<ToolView>* drawn) const;
    const TemplateSet* drawnAhead();
    const std::vector<PartTemplate>& draw(int tool, Eye& eye, double scale = 1, double rotation = 0, bool alone = false);
    void locate(int tool, Eye& eye, const std::vector<PartTemplate>& templates, double halfWindow, bool starting);
    bool start(int tool);
    bool search(int tool);
    bool initialize(int tool, int first, int last);
    bool startFromHandEye(int tool);
    bool correctFromHandEye(TrackedTool& tool);
    bool measure(int tool, const TemplateSet* ahead);
    void conclude(TrackedTool& tool, bool seen) const;
    bool plausible(const TrackedTool& tool, const Matx44d& correction) const;
    void gather(const TrackedTool& tool);
    void report(const TrackedTool& tool, const ToolView& view, ToolEstimate& estimate) const;

    // METHOD_FULL
    bool startFull(int tool);
    bool searchFull(int tool);
    Matx44d correctionOfAnother(int tool) const;
    bool beginAnew(int tool, int first, int last);
    void fit(int tool, const std::vector<PartMatch>& inliers);
    void dropPoints(TrackedTool& tool);
    void correctByOutline(int tool, const TemplateSet* ahead);
    bool correctFull(int tool, const TemplateSet* ahead);
    bool measureFull(int tool, const TemplateSet* ahead);
    void concludeFull(TrackedTool& tool, bool seen);
    int addPoints(TrackedTool& tool, double tolerance);
    int correctPoints(TrackedTool& tool);
    void sampleContours(int tool, const TemplateSet* ahead);
    double refine(TrackedTool& tool, int firstPass);
    const ToolView& seenFrom(const Eye& eye, const TrackedTool& tool);
    double support(const TrackedTool& tool);
    bool movedSince(int tool, const std::vector<ToolView>& drawn) const;

    std::vector<Eye> eyes_;   // the left one first
    size_t open_;             // of them have an image of this frame
    Params params_;
    double pixelScale_;       // of thresholds given for images 720 pixels wide
    Ptr<GeometricContextVerifier> verifier_, startVerifier_;   // the first pose needs more points to agree
    std::vector<TrackedTool> tools_;
    std::vector<ToolView> views_;
    std::vector<std::vector<double> > joints_;
    double time_;

    // of one locate()
    std::vector<Point2d> predicted_;
    std::vector<Rect> windows_;
    std::vector<PartMatch> matches_;

    // of one correction
    std::vector<Point3d> nominalPoints_;
    std::vector<Point2d> imagePoints_;
    std::vector<int> parts_;
    std::vector<double> noise_;
    ToolView seen_;
    std::vector<uchar> used_;

    Ptr<RenderAhead> ahead_;   // made by the first renderAhead()
    std::vector<ToolView> aheadViews_;

    StageTimes times_;
};

}} // namespace cv::surgtrack

#endif
