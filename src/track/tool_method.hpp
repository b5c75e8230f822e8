// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_TRACK_TOOL_METHOD_HPP
#define OPENCV_SURGTRACK_SRC_TRACK_TOOL_METHOD_HPP

#include "opencv2/surgtrack/tool_tracker.hpp"
#include "track/scene.hpp"

namespace cv { namespace surgtrack {

//! What is known of a tool from frame to frame, beside what its filter knows.
struct ToolMemory
{
    Matx44d correction_;               // the last one; kept when nothing is seen
    Matx44d calibration_;              // the correction that a search begins from
    Matx44d settled_;                  // the first one after some frames of tracking
    bool isSettled_;
    int state_, confirmed_;            // consecutive measured frames since the (re)start
    double lastSeen_;                  // time of the last measurement [s]
    std::vector<Point3d> nominalPoints_;   // keypoints of the current frame, where the calibration has them
    Evidence evidence_;                // of the last pose looked at
    int visibleParts_;
    std::vector<PartMatch> inliers_;
    std::vector<double> joints_;       // readings of the current frame
    std::vector<double> shownJoints_;  // readings of the last image that was a new one
    int skipped_;                      // frames whose readings no joint can have
};

/** How the pose of one tool is found, and what is known of it over time. The tracker places all tools, lets each be measured in turn,
and reports. */
class ToolMethod : protected ToolMemory
{
public:
    ToolMethod(int index, const Ptr<ToolModel>& model, const Matx44d& nominal_T_base, const ToolTracker::Params& params, double pixelScale);
    virtual ~ToolMethod() {}

    //! Back to the hand-eye calibration itself.
    virtual void reset();

    //! A frame begins: where the kinematics and the last correction have the tool.
    //! @param seconds since the frame before; 0: there was none
    void place(const std::vector<double>& joints, double seconds);
    //! As if this frame, which began with place(), had not been.
    virtual void takeBack() { static_cast<ToolMemory&>(*this) = before_; }

    /** The tool in this frame's images.
    @param scene all else
    @param ahead what was drawn ahead of this tool for the left eye, and is near enough; none: 0 */
    virtual void measure(Scene& scene, const PartDrawing* ahead) = 0;

    //! Where the tool will be with these readings. Its link poses are empty if it may be anywhere.
    void foresee(const std::vector<double>& readings, ToolView& view);

    //! The tool as it is believed to be, in the frame of the left camera.
    virtual const ToolView& view() const = 0;
    virtual void report(ToolEstimate& estimate) const;
    //! A copy of what one eye saw last.
    ToolSight sight(size_t eye) const;

    //! How the camera has moved since the tool was first tracked, if by more than an estimate wanders; else unit.
    Matx44d cameraMotion() const;
    //! The same since the frame before, in every frame in which the tool was tracked.
    Matx44d cameraStep() const;

    //! Of the joints, for METHOD_FULL.
    virtual ReadingErrors readingErrors() const { return ReadingErrors(); }
    //! Begins anew with these.
    virtual void setReadingErrors(const ReadingErrors&) { CV_Error(Error::StsBadArg, "Params::method: only METHOD_FULL learns what is wrong with readings"); }

    //! The calibration is another; the pose that is known stays. @param nominal_T_base rigid
    virtual void setHandEye(const Matx44d& nominal_T_base) = 0;
    //! The camera has moved by this, and with it where the calibration has the base.
    virtual void moveCamera(const Matx44d& now_T_before) = 0;
    //! Another instrument on the same arm: goes on from what another method has learnt of the calibration.
    virtual void inherit(const ToolMethod& other) = 0;

    void setIndex(int index) { index_ = index; }
    const Ptr<ToolModel>& model() const { return model_; }
    size_t coordinates() const { return coordinates_; }
    const Matx44d& nominal_T_base() const { return nominal_T_base_; }
    const Matx44d& correction() const { return correction_; }
    const Matx44d& calibration() const { return calibration_; }
    int state() const { return state_; }
    //! How sure its pose of the frame before is, beside those of other tools.
    virtual double sureness() const { return 0; }
    bool isLocated() const { return !starts() && state_ != STATE_LOST; }
    //! Where a tool is not known yet, nothing can be drawn ahead.
    bool usesDrawnAhead() const { return !settles() && state_ != STATE_LOST; }

protected:
    //! Readings with what is known of their errors.
    virtual void correctJoints(const std::vector<double>& readings, std::vector<double>& joints) const { joints = readings; }
    //! The tool where joints and state have it, for place().
    virtual const ToolView& predict(const std::vector<double>& joints, double seconds) = 0;

    //! Where the calibration has them, with the joints of this view.
    void placeKeypoints(const ToolView& view);

    //! Readings that joints can have: the nearest ones. @return whether these are such
    bool bound(const std::vector<double>& readings, std::vector<double>& bounded) const;

    //! Whether the image is the one before once more, although the tool has moved. Once a frame.
    bool isStale(const Scene& scene);

    bool starts() const { return state_ == STATE_INITIALIZING && confirmed_ == 0; }
    /* So many first frames are each taken in from the hand-eye calibration alone. Their points lean towards where the templates
       were drawn: a filter that believed them together would keep the error of the first pose, most of it depth, for minutes. Of
       0, 3, 6 and 12 the best on phantom_stereo and exvivo_single with METHOD_PAPER. */
    static const int startFrames = 6;
    bool settles() const { return confirmed_ < startFrames; }
    double minWindow() const { return params_.minWindow * pixelScale_; }

    //! Whether a calibration's error may be this large, and the parts found lie where it has them.
    bool plausible(const CameraModel& camera, const Matx44d& correction, const std::vector<PartMatch>& inliers) const;
    double maxReprojectionError() const;

    struct StartCandidate
    {
        StartCandidate() : score(0), templates(0) {}
        double score;          // sum of the inliers' similarities
        int templates;
        std::vector<PartMatch> inliers;
    };
    static const int hypotheses = 9;   // of scale and rotation (paper, Sec. 2.1)
    //! The nine scale and turn the image; attempts of later frames turn the tool out of it, in turn to its four sides. @param at of the tool
    static Matx44d startTurn(int attempt, const Point3d& at);
    /** Parts in wide windows, by drawings in several scales and rotations about a view.
    @param first, last which of the nine
    @param distance of the tool [m]
    @param best in: how many are wanted; those with the largest score, falling
    @return how many templates the first drawing had */
    int findStarts(Scene& scene, int first, int last, const ToolView& view, double distance, std::vector<StartCandidate>& best);

    //! One eye's parts at a view.
    void look(Scene& scene, size_t eye, const ToolView& view, const PartWindows& windows, bool starting);
    //! The left eye's parts as they were drawn ahead. @param windows are moved to where the last correction has the parts
    void lookAhead(Scene& scene, const PartDrawing& ahead, PartWindows& windows);
    void expect(const PartDrawing& ahead, const CameraModel& camera, PartWindows& windows) const;

    int index_;                        // of the tool
    Ptr<ToolModel> model_;
    size_t coordinates_;
    Matx44d nominal_T_base_;
    ToolTracker::Params params_;
    double pixelScale_;                // of thresholds given for images 720 pixels wide

    std::vector<Vec2d> ranges_;        // of readings, a coordinate
    ToolMemory before_;                // this frame
    ToolView shown_;                   // memory of isStale()
    std::vector<double> foreseen_, bounded_;   // memory of foresee() and place()
    std::vector<Sight> sights_;        // an eye
};

}} // namespace cv::surgtrack

#endif
