// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SEQUENCE_HPP
#define OPENCV_SURGTRACK_SEQUENCE_HPP

#include <map>
#include "opencv2/surgtrack/camera.hpp"
#include "opencv2/surgtrack/tool_model.hpp"

namespace cv { namespace surgtrack {

//! @addtogroup surgtrack
//! @{

/** @brief One tool of a sequence. */
struct CV_EXPORTS_W_SIMPLE SequenceTool
{
    CV_WRAP SequenceTool();
    CV_PROP String name;                //!< as in the CSV files
    CV_PROP String model;               //!< path of the tool file
    CV_PROP Matx44d nominal_T_base;     //!< the calibrated, wrong, hand-eye: the key camera_T_base of the file
};

/** @brief A recorded sequence: a folder with sequence.yaml, video, kinematics.csv and, where known, groundtruth.csv.
The format is described in doc/formats.md. Frame k is at time k / fps. Keys and columns that are not known are ignored. */
class CV_EXPORTS_W Sequence
{
public:
    /** @brief Reads a sequence; videos are not opened.
    @param folder the folder, or its sequence.yaml
    @param recorded false: only cameras and tools are read, for live use; there need be no videos and CSV files, and asking for
    joints or truth is an error
    @throws cv::Exception naming file, key or line and what was expected */
    CV_WRAP static Ptr<Sequence> load(const String& folder, bool recorded = true);

    /** @brief The key `name`, or else the folder's name. */
    CV_WRAP String name() const { return name_; }
    /** @brief Frames a second. */
    CV_WRAP double fps() const { return fps_; }
    /** @brief The left camera, or the only one. */
    CV_WRAP CameraModel leftCamera() const { return left_; }
    /** @brief The right camera; of size 0 x 0 if there is one camera. */
    CV_WRAP CameraModel rightCamera() const { return right_; }
    /** @brief Path of the left video; may lie outside the folder. Empty if not recorded and not named. */
    CV_WRAP String leftVideo() const { return leftVideo_; }
    /** @brief Path of the right video; empty if there is one camera. */
    CV_WRAP String rightVideo() const { return rightVideo_; }
    /** @brief Pose of the left camera in the frame of the right one [m]. */
    CV_WRAP Matx44d right_T_left() const { return right_T_left_; }
    /** @brief Whether there are two cameras. */
    CV_WRAP bool isStereo() const { return !rightVideo_.empty(); }
    /** @brief Number of tools. */
    CV_WRAP int toolCount() const { return (int)tools_.size(); }
    /** @brief What is known of a tool. @param index 0 to toolCount() - 1 */
    CV_WRAP SequenceTool tool(int index) const;

    /** @brief Joint readings at a time, linearly interpolated between the two nearest records.
    @param tool index
    @param time [s]
    @param joints one value per wanted coordinate [rad or m]
    @param coordinates the coordinates wanted, as ToolModel::coordinateNames(); empty = all of jointNames()
    @return false if the time lies outside the records (by more than one sampling interval); joints is then unchanged
    @throws cv::Exception if kinematics.csv has no column for a coordinate */
    CV_WRAP bool jointsAt(int tool, double time, CV_OUT std::vector<double>& joints,
                          const std::vector<String>& coordinates = std::vector<String>()) const;

    /** @brief Names of the joint columns of kinematics.csv: all but `time` and `tool`. */
    CV_WRAP std::vector<String> jointNames() const { return jointNames_; }

    /** @brief Time of a tool's first joint reading [s]. */
    CV_WRAP double firstTime(int tool) const;
    /** @brief Time of a tool's last joint reading [s]. */
    CV_WRAP double lastTime(int tool) const;

    /** @brief Path of kinematics.csv. */
    CV_WRAP String kinematicsFile() const { return kinematicsFile_; }

    /** @brief Ground truth of a frame.
    @param tool index
    @param frame number
    @param camera_T_tool true pose
    @param joints true joint values in the order of jointNames(); empty if the file lacks one of these columns
    @return false if there is none for this frame; the outputs are then unchanged */
    CV_WRAP bool groundTruth(int tool, int frame, CV_OUT Matx44d& camera_T_tool, CV_OUT std::vector<double>& joints) const;
    /** @brief Whether the folder has a groundtruth.csv. */
    CV_WRAP bool hasGroundTruth() const;
    /** @brief One more than the last frame with ground truth; 0 without. */
    CV_WRAP int groundTruthEnd() const;

private:
    struct JointRecords { std::vector<double> times; std::vector<double> values; };   // values: row-major, a row a time
    struct Truth { Matx44d camera_T_tool; std::vector<double> joints; };

    Sequence();
    void readDescription(const String& folder, const String& filename, bool recorded);
    void readKinematics();
    void readGroundTruth();
    const JointRecords& records(int tool) const;

    String name_, leftVideo_, rightVideo_, kinematicsFile_, groundTruthFile_;
    double fps_;
    CameraModel left_, right_;
    Matx44d right_T_left_;
    std::vector<SequenceTool> tools_;
    std::vector<String> jointNames_;
    std::vector<JointRecords> records_;                // a tool
    std::vector<std::map<int, Truth> > truth_;         // a tool, by frame
};

/** @brief Writes a poses CSV: `frame,time,tool,status,tx,ty,tz,qx,qy,qz,qw` and further columns.
Each row is flushed, so that what was written is complete and readable whatever happens next. */
class CV_EXPORTS_W PoseWriter
{
public:
    /** @brief Begins a file.
    @param filename is overwritten
    @param extraColumns names of further columns
    @throws cv::Exception naming the file if it can't be written */
    CV_WRAP static Ptr<PoseWriter> create(const String& filename, const std::vector<String>& extraColumns = std::vector<String>());
    virtual ~PoseWriter() {}

    /** @brief Adds one row.
    @param frame number
    @param time [s]
    @param tool name
    @param state see cv::surgtrack::TrackingState
    @param camera_T_tool rigid; a non-finite pose is an error
    @param extra one value per further column; non-finite values are left empty
    @throws cv::Exception naming the file if the row can't be written (as on a full disk) */
    CV_WRAP virtual void write(int frame, double time, const String& tool, int state, const Matx44d& camera_T_tool,
                               const std::vector<double>& extra = std::vector<double>()) = 0;
};

/** @brief How good the poses of one tool are, measured against the truth. */
struct CV_EXPORTS_W_SIMPLE PoseScore
{
    CV_WRAP PoseScore();
    CV_PROP_RW int frames;                 //!< with truth
    CV_PROP_RW int covered;                //!< of these, with a pose that claims to be one: tracking or coasting
    CV_PROP_RW double translationMean;     //!< distance of the end effector from its true place, over the covered frames [m]; 0 without any
    CV_PROP_RW double translationStd;      //!< its standard deviation [m]
    CV_PROP_RW double rotationMean;        //!< angle between estimated and true orientation, over the covered frames [rad]
    CV_PROP_RW double rotationStd;         //!< its standard deviation [rad]
    CV_PROP_RW double accuracy;            //!< share of all frames whose end effector is at most 10 pixel off in an image 720 pixel wide (paper, Sec. 3)
    CV_PROP_RW double silent;              //!< share of all frames that claim to be tracking and are more than 5 mm off
};

/** @brief Compares poses with the truth, as Table 1 of the paper does. */
class CV_EXPORTS_W PoseScorer
{
public:
    /** @brief A scorer without poses yet.
    @param camera of the image the reprojection error is taken in; its distortion is left out
    @param tools number of tools */
    CV_WRAP static Ptr<PoseScorer> create(const CameraModel& camera, int tools);
    virtual ~PoseScorer() {}

    /** @brief Takes in one frame of one tool.
    @param tool index
    @param state see cv::surgtrack::TrackingState
    @param camera_T_tool estimate
    @param true_camera_T_tool truth */
    CV_WRAP virtual void add(int tool, int state, const Matx44d& camera_T_tool, const Matx44d& true_camera_T_tool) = 0;

    /** @brief The score so far. @param tool index; -1 = all tools together */
    CV_WRAP virtual PoseScore score(int tool = -1) const = 0;
};

//! @}

}} // namespace cv::surgtrack

#endif
