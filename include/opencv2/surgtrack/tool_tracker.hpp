// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_TOOL_TRACKER_HPP
#define OPENCV_SURGTRACK_TOOL_TRACKER_HPP

#include "opencv2/surgtrack/part_finder.hpp"
#include "opencv2/surgtrack/tool_pose_ekf.hpp"
#include "opencv2/surgtrack/articulated_pose_ekf.hpp"
#include "opencv2/surgtrack/tool_estimate.hpp"

namespace cv { namespace surgtrack {

//! @addtogroup surgtrack
//! @{

//! How poses are found from the verified matches.
enum TrackingMethod
{
    METHOD_PAPER = 0,   //!< @cite ye2016realtime as published: six-state filter on the hand-eye correction
    METHOD_EPNP = 1,    //!< the paper's baseline: EPnP on the matches of each frame alone
    METHOD_FULL = 2     //!< beyond the paper: joint offsets, outlines, both eyes, pushes of the camera, and evidence from parts and outline
};

/** @brief How long a stage of ToolTracker::update() takes. A frame is one sample: the sum over all tools and eyes, 0 if the stage was not reached. */
struct CV_EXPORTS_W_SIMPLE StageTime
{
    CV_WRAP StageTime();

    CV_PROP_RW String name;   //!< `render`, `image`, `match`, `verify`, `filter`, `contour` (METHOD_FULL) or `total`, all of update()
    CV_PROP_RW int calls;     //!< frames; without any, the times are 0
    CV_PROP_RW double last;   //!< of the last frame [s]
    CV_PROP_RW double mean;   //!< [s]
    CV_PROP_RW double min;    //!< [s]
    CV_PROP_RW double max;    //!< [s]
};

//! What the last update() looked at of a tool with one eye, and what it saw there: of the last pose it tried. For pictures.
struct CV_EXPORTS ToolSight
{
    ToolSight();

    CameraModel camera;                      //!< of all points below: of the reduced image, see PartFinder
    std::vector<ToolView> views;             //!< of all tools, as they were drawn, in the frame of this eye; none if drawn ahead
    std::vector<PartTemplate> templates;     //!< that were looked for; none if drawn ahead
    int enlargement;                         //!< of theirs, see PartDrawing
    Rendering rendering;                     //!< that they were cut from; none if drawn ahead
    FoundParts found;                        //!< windows, candidates and inliers
    std::vector<ContourPoint> outline;       //!< METHOD_FULL: at the pose, with the edges that contourSupport is counted from
};

/** @brief Finds the pose of articulated tools in the camera from video and joint readings.

METHOD_PAPER, per frame (paper, Sec. 2): the tools are drawn as the kinematics and the last correction say they look (Sec. 2.1);
part templates are cut from the drawing (PartTemplateRenderer), found in the image (QGOMatcher), kept where their arrangement
agrees (GeometricContextVerifier, Sec. 2.2), and fused with the kinematics (ToolPoseEKF, Sec. 2.3). METHOD_EPNP has EPnP in
place of the filter.

METHOD_FULL, per frame:
- Parts are drawn, found and verified as above, in each eye. Samples of the geometric context that scale or turn too much are
  skipped and the best one is taken, not the first: fewer wrong inliers.
- ArticulatedPoseEKF takes them in. It has what is wrong with each wrist and jaw reading in its state (offset, gain, play, coupling),
  beside the correction: cables stretch, and no rigid correction repairs a reading.
- The outline is placed where this pose has it (ToolContour), edges are sought on its normals (matchContour()), within 8, 5 and
  3 pixels in turn (at 720 px width), and taken in together with the parts. Parts tell from far off where the tool is, to some
  pixels; edges are many and exact to a fraction of a pixel, but need a pose within some pixels to begin with.
- Evidence is the log odds of the pose being right: how many parts were found and how alike, how much of the outline is where the pose
  has it, and how badly the points fit (a logistic model, fitted to poses that are known to be right or wrong). Tissue may look like parts,
  or like an outline, but not like both at once. One that follows from the frame before has that one's log odds besides, up to a limit,
  so an outline alone does for a while. A first pose needs more of its own, and one that is to count as tracking without a second frame
  most. ToolEstimate::confidence is the probability. (Coefficients and thresholds: src/track/evidence.hpp.)
- A push of the camera: where points or edges fit badly to a correction that changes slowly, the frame is measured once more with
  P grown by what a push does; if that has more evidence it is kept, and the process noise stays raised for some frames. If it has
  not and the points fit badly, they are the wrong ones: the outline alone is taken. During a push, and where there is much less evidence
  than in the frames before, nearer edges and other depths are tried as well.
- First pose: nine drawings (paper, Sec. 2.1: scales 0.8, 1, 1.2, rotations 0, +-15 degrees); the three with the largest summed
  similarity are fitted, parts and outline, in four rounds each; the one with the most evidence is taken, as the summed similarity
  alone does not tell good from bad. If none is good enough, the next frames do the same about the calibration turned out of the image
  by 10 degrees, to one side after the other. The process noise is raised for the frames after a first pose: two may look alike in one frame.
- A tool that is not seen is sought in every frame with one of the nine drawings, in turn about its last pose and about the
  hand-eye calibration itself, since either may be the better guess. What is found there must be confirmed by the next frames;
  else the tool goes back to the last pose that was tracked. Meanwhile P grows.

Images 1440 pixels wide and more are reduced by a whole number first, since gradients and tolerances are made for pixels of an
image about 720 wide.

Each tool has a state of its own. The result depends on the input alone: same images, times and joints, same estimates.

**Threads.** One thread at a time may call a tracker; different trackers do not know of each other. renderAhead() has the only thread
of its own. **Cost**, some 720 pixels wide: update() takes milliseconds (doc/performance.md), ten times as long where a tool is sought;
addTool(), replaceTool(), removeTool() and setRightCamera() milliseconds; all others microseconds. **Messages**, of changes of
state, go to OpenCV's log at the level info: none by default. */
class CV_EXPORTS_W ToolTracker
{
public:
    struct CV_EXPORTS_W_SIMPLE Params
    {
        CV_WRAP Params();
        CV_PROP_RW int method;                 //!< see cv::surgtrack::TrackingMethod; default METHOD_FULL
        CV_PROP_RW bool jointOffsets;          //!< METHOD_FULL: joint readings may be wrong by offsets, which are estimated; false for readings known to be exact
        CV_PROP_RW bool contours;              //!< METHOD_FULL: edges on outlines go into the pose; if false they are evidence only
        CV_PROP_RW bool adaptation;            //!< METHOD_FULL: a push of the camera is noticed and followed; false for a camera that is fixed to the arms
        CV_PROP_RW double initialWindow;       //!< half-width of the search window before the first pose [m on the tool]
        CV_PROP_RW double minWindow;           //!< smallest half-width of the search window while tracking [pixel at 720 px width]
        CV_PROP_RW int minInitialInliers;      //!< matches needed for a first pose (paper's release: more than 6); METHOD_FULL: to count as tracking at once, else five
        CV_PROP_RW double minInitialSimilarity;   //!< their least mean similarity; bare tissue gives up to 0.6, a tool 0.75 and more. Not METHOD_FULL, which has the outline too
        CV_PROP_RW double minConfidence;       //!< METHOD_FULL: what ToolEstimate::confidence a first pose must have to be worth another frame, 0..1 (default 0.5). What is asked of tracking moves with it, in odds: more of it starts and goes on less readily, and is wrong less often. 0: no pose is refused, the caller judges
        CV_PROP_RW int confirmFrames;          //!< frames that must confirm a first pose before it counts as tracking; METHOD_FULL needs none where the evidence is strong
        CV_PROP_RW double coastingTime;        //!< without a measurement for longer a tool is lost [s]
        CV_PROP_RW int seed;                   //!< of all random choices
    };

    /** @brief Parameters of the stages that a tracker is made of. Pixels are those of an image 720 pixels wide. What a method or
    Params decide is overruled: wholeTool of templates (METHOD_FULL), seed and minInliers of the verifier, its zones and limits
    and contrast of the matcher (METHOD_PAPER, METHOD_EPNP), halfWindow of edges. */
    struct CV_EXPORTS_W_SIMPLE Stages
    {
        CV_WRAP Stages();
        CV_PROP_RW PartTemplateRenderer::Params templates;
        CV_PROP_RW QGOMatcher::Params matcher;
        CV_PROP_RW GeometricContextVerifier::Params verifier;
        CV_PROP_RW ToolPoseEKF::Params paperFilter;       //!< METHOD_PAPER
        CV_PROP_RW ArticulatedPoseEKF::Params filter;     //!< METHOD_FULL
        CV_PROP_RW ToolContour::Params contour;           //!< METHOD_FULL
        CV_PROP_RW ContourSearch edges;                   //!< METHOD_FULL
    };

    /** @param camera the left one, or the only one
    @param params what is tracked, and how
    @param stages how its stages work
    @param renderer draws the tools, for both eyes; must not be used by anyone else meanwhile. None: MeshRenderer::createSoftware().
    The second thread of renderAhead() has a software renderer of its own */
    CV_WRAP static Ptr<ToolTracker> create(const CameraModel& camera, const ToolTracker::Params& params = ToolTracker::Params(),
                                           const ToolTracker::Stages& stages = ToolTracker::Stages(),
                                           const Ptr<MeshRenderer>& renderer = Ptr<MeshRenderer>());

    virtual ~ToolTracker() {}

    /** @brief Makes the right eye known, for updateStereo(). Before or after addTool().
    @param right its intrinsics and distortion
    @param right_T_left pose of the left camera in the frame of the right one [m]. Called again, the mask of the right eye stays if its
    images have the same size
    @throws cv::Exception for another method than METHOD_FULL, and a transform that is not rigid */
    CV_WRAP virtual void setRightCamera(const CameraModel& right, const Matx44d& right_T_left) = 0;

    /** @brief Adds a tool.
    @param model the tool
    @param nominal_T_base where the (wrong) hand-eye calibration believes the arm's base to be, in the camera frame
    @return index of the tool
    @throws cv::Exception for a tool with too few keypoints, parameters of stages that are wrong, and a transform that is not rigid or
    further away than 1000 m; no tool is then added */
    CV_WRAP virtual int addTool(const Ptr<ToolModel>& model, const Matx44d& nominal_T_base) = 0;

    /** @brief Tracks one frame.
    @param image CV_8UC1 or CV_8UC3 (BGR) of the camera's size
    @param time time stamp [s], larger than the last one
    @param joints per tool, in the order of addTool(), one reading per coordinate [rad or m]
    @param estimates per tool the answer
    Readings that no joint can have are left out, see ToolEstimate::skippedReadings.
    @throws cv::Exception for another image type or size, another number of joints, or non-finite values. Whatever is thrown, also by a
    renderer of the user's own, the tracker is then as it was before the call */
    CV_WRAP virtual void update(InputArray image, double time, const std::vector<std::vector<double> >& joints,
                                CV_OUT std::vector<ToolEstimate>& estimates) = 0;

    /** @brief Tracks one frame of both eyes, taken at the same time; setRightCamera() comes first. Frames of one eye, by update(), may
    lie between. Poses, matches and the search for a first pose are those of the left eye.
    @param left, right images of the same type, each of its camera's size
    @param time, joints, estimates see update(), also for what is thrown */
    CV_WRAP virtual void updateStereo(InputArray left, InputArray right, double time, const std::vector<std::vector<double> >& joints,
                                      CV_OUT std::vector<ToolEstimate>& estimates) = 0;

    /** @brief Starts drawing templates in a second thread (paper, Sec. 2: two threads) and returns at once.

    A video is tracked with the drawing of the next frame beside the matching of this one:

        tracker->renderAhead(joints of frame t + 1);
        tracker->update(image t, time t, joints of frame t, estimates);

    and a live image with the newest readings as soon as there are some, before update(). Templates are drawn with the corrections
    known at the time of the call. update() knows the last request before it and the last one before the previous update(). It waits
    for the one whose drawing has the tools within a few pixels and degrees of where they are now, and moves its templates there; if
    neither has, or a tool starts or is lost, it draws as ever. The estimates so depend on the order of the calls and what is given to
    them, never on the speed of a thread; they differ a little from those without this call.

    @param joints as for update(), as they are expected to be
    @throws cv::Exception for another number of joints or non-finite values. What goes wrong in the second thread is thrown by the
    update() that asks for the templates, this or the next one; the tracker's state is then unchanged, and the request gone */
    CV_WRAP virtual void renderAhead(const std::vector<std::vector<double> >& joints) = 0;

    /** @brief Another instrument is on the arm. What was learnt of the calibration stays and is where the search begins; offsets of
    joints, which are the instrument's, are forgotten. Makes the drawing of all tools anew: some milliseconds and more for a large CAD.
    @param tool index, stays the same
    @param model the new one */
    CV_WRAP virtual void replaceTool(int tool, const Ptr<ToolModel>& model) = 0;

    /** @brief A tool is gone. @param tool index; those of the tools after it fall by one */
    CV_WRAP virtual void removeTool(int tool) = 0;

    /** @brief Where a camera shows anything. Black surrounds are found without; overlays of a console are not.
    @param mask CV_8UC1 of the images' size, 0 where there is nothing of the scene; empty: anywhere
    @param eye 0 = left, 1 = right */
    CV_WRAP virtual void setMask(InputArray mask, int eye = 0) = 0;

    /** @brief There is another hand-eye calibration. The pose of a tool that is tracked stays as it is; one without a pose begins anew.
    @param tool index
    @param nominal_T_base as for addTool() */
    CV_WRAP virtual void setHandEye(int tool, const Matx44d& nominal_T_base) = 0;

    /** @brief The camera has moved since the last frame, and it is known how: a da Vinci's camera arm has joints, too. All poses, and all
    calibrations, move in its frame; the next frame goes on from there. Moves that are not told are found, too, if they are small.
    @param now_T_before pose of the camera at the last frame in its frame now [m] */
    CV_WRAP virtual void moveCamera(const Matx44d& now_T_before) = 0;

    /** @brief What was learnt of the errors of a tool's joint readings, METHOD_FULL; else nothing. @param tool index */
    CV_WRAP virtual ReadingErrors readingErrors(int tool) const = 0;

    /** @brief The same of another day: a robot's play does not change overnight. The tool begins anew with it, also after reset().
    @param tool index
    @param errors of the same instrument on the same arm, see ArticulatedPoseEKF::setReadingErrors()
    @throws cv::Exception for another method than METHOD_FULL, and errors of another tool */
    CV_WRAP virtual void setReadingErrors(int tool, const ReadingErrors& errors) = 0;

    /** @brief Forgets what was learnt of a tool. @param tool index; -1 = all */
    CV_WRAP virtual void reset(int tool = -1) = 0;

    //! What was looked at in the last update(). @param tool index @param eye 0 = left, 1 = right; copies
    virtual ToolSight sight(int tool, int eye = 0) const = 0;

    /** @brief Times of the stages since the first frame or the last resetTimings(), in the order of the data flow; `total` comes last. */
    CV_WRAP virtual std::vector<StageTime> getTimings() const = 0;

    /** @brief Starts the times of getTimings() anew; tracking goes on as it was. */
    CV_WRAP virtual void resetTimings() = 0;
};

//! @}

}} // namespace cv::surgtrack

#endif
