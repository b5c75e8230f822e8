// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_ARTICULATED_POSE_EKF_HPP
#define OPENCV_SURGTRACK_ARTICULATED_POSE_EKF_HPP

#include "opencv2/surgtrack/contour.hpp"
#include "opencv2/surgtrack/reading_errors.hpp"

namespace cv { namespace surgtrack {

//! @addtogroup surgtrack
//! @{

/** @brief The filter of METHOD_FULL: the error of the hand-eye calibration and those of the joint readings.

State: the correction camera_T_nominal and, of each coordinate with ToolModel::offsetDeviations() > 0 (the first ten), constants of what
is wrong with its readings: an offset, a gain, play, and the coupling to the coordinate before it; and one time by which all readings are
late. The sum of them at this frame's
readings, d, is added to these. The state's error is (omega, v, theta), omega and v a small motion of the tool about its own centre c in
the camera frame, `camera_T_nominal <- Trans(c + v) Exp(omega) Trans(-c) camera_T_nominal`, theta that of the constants; so rotation and
translation are nearly independent, and P is moved to the new centre as the tool moves. Process: constant, with noise Q. Measurements: points of
parts and edges on contour normals, of one camera or several, all at once. */
class CV_EXPORTS_W ArticulatedPoseEKF
{
public:
    struct CV_EXPORTS_W_SIMPLE Params
    {
        CV_WRAP Params();
        CV_PROP_RW double initialRotation;      //!< standard deviation of the hand-eye calibration [rad]
        CV_PROP_RW double initialTranslation;   //!< the same, at the tool [m]
        CV_PROP_RW double processRotation;      //!< process noise, standard deviation in a frame of 40 ms; its variance grows with time [rad]
        CV_PROP_RW double processTranslation;   //!< the same [m]
        CV_PROP_RW double processJoint;         //!< the same, of what is wrong with the joints' readings, as a share of its prior deviation; of offsets, which take up what the others do not explain: theirs is a fifth
        CV_PROP_RW double gain;                 //!< prior standard deviation of a turning joint's gain, of its travel; 0 = none, as of the next two; defaults: what a real PSM had
        CV_PROP_RW double play;                 //!< the same, of half its play [rad]
        CV_PROP_RW double coupling;             //!< the same, of a share of the travel of the coordinate before it
        CV_PROP_RW double delay;                //!< the same, of the time between image and readings [s]; what is known of it is taken off before
        CV_PROP_RW double exact;                //!< prior probability that there is neither gain nor play nor coupling at all, and that there is no delay; 0 = there are
        CV_PROP_RW double pointNoise;           //!< standard deviation of a part's image point [pixel]
        CV_PROP_RW double gate;                 //!< points with a larger squared Mahalanobis distance are left out; 13.8 = 99.9 % of chi-square with 2 dof
        CV_PROP_RW double contourNoise;         //!< standard deviation of an edge along its normal [pixel]
        CV_PROP_RW double edgeBias;             //!< the same, of what displaces all edges of an eye and frame together, as codecs do [pixel]
        CV_PROP_RW double bloom;                //!< the same, of those beside what is clipped to white [pixel]
        CV_PROP_RW bool jointOffsets;           //!< whether the readings may have offsets
        CV_PROP_RW double contourCorrelation;   //!< so many neighbouring contour points tell as much as one
    };

    static const int MAX_OFFSETS = 10, MAX_STATES = 40;

    //! What is believed of a tool: state and covariance.
    struct CV_EXPORTS Belief
    {
        Matx44d correction;                    //!< camera_T_nominal
        Vec<double, MAX_STATES> theta;         //!< constants of the readings' errors; its first part is used
        Matx<double, MAX_STATES, MAX_STATES> covariance;   //!< of (omega, v, theta); its upper left part is used
        Vec<double, MAX_STATES> shift;         //!< from the mean of the state to that of the mixture that is believed, see Params::exact;
        Matx44d believed_T_correction;         //!< the same of the correction, as a motion in the camera frame
        Point3d centre;                        //!< c, in the camera frame [m]
        bool placed;                           //!< whether the centre is that of a frame; before, P is about wherever the tool will be
        double nis;                            //!< see ArticulatedPoseEKF::nis()
    };

    /** @brief All that the filter knows, as a value: `const State before = filter->state(); ... filter->setState(before);`. Copying it takes
    no memory from the heap with up to sixteen coordinates. */
    struct CV_EXPORTS State
    {
        Ptr<ToolModel> model;
        Matx44d nominal_T_base;                //!< the hand-eye calibration
        AutoBuffer<double, 16> joints;         //!< readings of the frame [rad or m],
        AutoBuffer<double, 16> reference;      //!< of the first frame,
        AutoBuffer<double, 16> directions;     //!< and where in its play each coordinate hangs, -1..1
        Belief predicted, corrected;           //!< after predict(), and after the last solve() since
        Vec<double, MAX_STATES> moved;         //!< from one to the other
    };

    /** @param model the tool
    @param nominal_T_base the hand-eye calibration
    @param params noise and gate */
    CV_WRAP static Ptr<ArticulatedPoseEKF> create(const Ptr<ToolModel>& model, const Matx44d& nominal_T_base,
                                                  const ArticulatedPoseEKF::Params& params = ArticulatedPoseEKF::Params());
    virtual ~ArticulatedPoseEKF() {}

    /** @brief Back to the readings themselves, with the initial covariance. @param correction camera_T_nominal; unit: the hand-eye calibration */
    CV_WRAP virtual void reset(const Matx44d& correction) = 0;

    /** @brief Back to the readings and the hand-eye calibration themselves, with the initial covariance. */
    CV_WRAP void reset();

    /** @brief One frame passes.
    @param joints readings, one per coordinate [rad or m]
    @param growth factor on the deviations of Q
    @param seconds since the last frame; 0 = it is the same one once more, or not known: then nothing is learnt of the delay, and Q is that
    of 40 ms */
    CV_WRAP virtual void predict(const std::vector<double>& joints, double growth = 1, double seconds = 0) = 0;

    /** @brief Takes back everything since the last predict(); the prediction's P grows by these standard deviations, as after a push.
    @param rotation [rad] @param translation [m] */
    CV_WRAP virtual void inflate(double rotation, double translation) = 0;

    /** @brief Takes back everything since the last predict(). */
    CV_WRAP virtual void undo() = 0;

    /** @name One correction: begin(), any number of addPoints() and addContour(), solve().
    It may be repeated, each time about the state found before: the last one takes the place of those before it (iterated filter).
    @{ */

    /** @brief Nothing is measured yet. */
    CV_WRAP virtual void begin() = 0;

    /** @brief Points of parts.
    @param camera that saw them
    @param eye_T_camera the camera frame of the state in that of this camera; unit if it is the same
    @param parts keypoint indices
    @param imagePoints where they were found [pixel]
    @param used 1 where the point passed the gate
    @param noise factor on Params::pointNoise, one each; none: 1
    @param tolerance points that are farther off than this (and than the noise) from where the state has them count little; as the
    state is that of the last solve(), not before the first one of a frame [pixel]
    @return how many passed */
    CV_WRAP virtual int addPoints(const CameraModel& camera, const Matx44d& eye_T_camera, const std::vector<int>& parts,
                                  const std::vector<Point2d>& imagePoints, CV_OUT std::vector<uchar>& used,
                                  const std::vector<double>& noise = std::vector<double>(), double tolerance = DBL_MAX) = 0;

    /** @brief Edges on the normals of a contour.
    @param camera that saw them
    @param eye_T_camera see addPoints()
    @param points those found are taken
    @param tolerance edges that are farther off than this, their noise and what is not known of the state explain count little, beyond three times of it nothing [pixel]
    @return how many passed */
    CV_WRAP virtual int addContour(const CameraModel& camera, const Matx44d& eye_T_camera, const std::vector<ContourPoint>& points,
                                   double tolerance) = 0;

    /** @brief How much better a push of this size before this frame explains what was added: half the difference of its squared
    Mahalanobis distances, a log likelihood ratio but for the determinants.
    @param rotation [rad] @param translation [m] */
    CV_WRAP virtual double surprise(double rotation, double translation) const = 0;

    /** @brief The correction by all that was added. @return false if the equations can't be solved; nothing changes then */
    CV_WRAP virtual bool solve() = 0;
    //! @}

    //! The readings of the last predict() that time had passed before have not been: for setState() to what was before it.
    virtual void dropReadings() = 0;
    //! All that is known, but for the readings of frames before, which the delay is learnt from.
    virtual State state() const = 0;
    //! Makes this filter what it, or another of the same tool, was. @param state what state() gave
    virtual void setState(const State& state) = 0;

    //! Makes another filter of the same tool what this one is.
    void copyTo(ArticulatedPoseEKF& other) const { other.setState(state()); }

    /** @brief Makes another filter of the same tool what this one is. @param other changes */
    CV_WRAP void copyTo(const Ptr<ArticulatedPoseEKF>& other) const;

    /** @brief The constants of the readings' errors. */
    CV_WRAP virtual ReadingErrors readingErrors() const = 0;

    /** @brief What was learnt of them before: where reset() begins, in place of nothing; calls it. Offsets and the delay may have changed since
    by as much as they are unknown by without this.
    @param errors of the same tool, as readingErrors() gave them; without names: nothing is known
    @throws cv::Exception for other constants than those of this filter, numbers beyond 1e4, and a covariance that is none */
    CV_WRAP virtual void setReadingErrors(const ReadingErrors& errors) = 0;

    /** @brief The calibration is another one: the tool, and what is known of its place, stay where they are, so the correction changes.
    @param nominal_T_base rigid */
    CV_WRAP virtual void setHandEye(const Matx44d& nominal_T_base) = 0;

    /** @brief The camera has moved, and everything moves in its frame: the tool, its covariance, and where the calibration has the base.
    @param now_T_before pose of the camera before the move in the frame of the one after it, rigid */
    CV_WRAP virtual void moveCamera(const Matx44d& now_T_before) = 0;

    /** @brief The tool as it is believed to be. */
    CV_WRAP virtual const ToolView& view() const = 0;
    /** @brief camera_T_nominal. */
    CV_WRAP virtual Matx44d correction() const = 0;
    /** @brief The image shows the joints as they are read so much later; negative: earlier [s]. */
    CV_WRAP virtual double delay() const = 0;
    /** @brief One per coordinate, to be added to the reading [rad or m]. */
    CV_WRAP virtual const std::vector<double>& offsets() const = 0;
    //! Readings of another time with their offsets, and no jaw beyond its stop. @param readings one per coordinate @param joints result
    virtual void correctJoints(const std::vector<double>& readings, std::vector<double>& joints) const = 0;
    /** @brief One per coordinate: the readings with their offsets, and no jaw beyond its stop [rad or m]. */
    CV_WRAP virtual const std::vector<double>& joints() const = 0;
    /** @brief CV_64F, of (omega, v, d): d is the sum of what is wrong with each reading now. */
    CV_WRAP virtual Mat covariance() const = 0;
    /** @brief What displaced edges in the last solve(), along their normals [pixel]. @param clipped ContourPoint::clipped */
    CV_WRAP virtual double edgeBias(int clipped) const = 0;
    /** @brief Normalised innovation squared of the last solve(), per degree of freedom. */
    CV_WRAP virtual double nis() const = 0;
    /** @brief Covariance of where a keypoint will be seen [pixel^2], without measurement noise.
    @param camera that will see it
    @param eye_T_camera see addPoints()
    @param part index of the keypoint */
    CV_WRAP virtual Matx22d imageCovariance(const CameraModel& camera, const Matx44d& eye_T_camera, int part) const = 0;
    /** @brief Covariance of camera_T_tool: (rotation vector [rad], translation [m]), both in the camera frame. */
    CV_WRAP virtual Matx66d poseCovariance() const = 0;
};

//! @}

}} // namespace cv::surgtrack

#endif
