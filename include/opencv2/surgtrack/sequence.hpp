// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SEQUENCE_HPP
#define OPENCV_SURGTRACK_SEQUENCE_HPP

#include <map>
#include "opencv2/surgtrack/camera.hpp"
#include "opencv2/surgtrack/tool_model.hpp"
#include "opencv2/surgtrack/tool_estimate.hpp"

namespace cv { namespace surgtrack {

class NodeReader;

//! @addtogroup surgtrack
//! @{

/** @brief One tool of a sequence. */
struct CV_EXPORTS_W_SIMPLE SequenceTool
{
    CV_WRAP SequenceTool();
    CV_PROP String name;                //!< as in the CSV files
    CV_PROP String model;               //!< path of the tool file
    CV_PROP Matx44d nominal_T_base;     //!< the calibrated, wrong, hand-eye: the key camera_T_base of the file
    CV_PROP double timeOffset;          //!< the joints of the image of time t were recorded at t + timeOffset: the key time_offset, else 0 [s]
};

/** @brief How the images of two eyes lie in the videos of a sequence: the key `layout`. */
enum SequenceLayout
{
    LAYOUT_SEPARATE = 0,       //!< `separate`, or no key: a file each
    LAYOUT_SIDE_BY_SIDE = 1,   //!< `side_by_side`: in one file, the left eye's image left of the right one's
    LAYOUT_TOP_BOTTOM = 2      //!< `top_bottom`: in one file, the left eye's image above the right one's
};

/** @brief Where a keypoint of a tool truly is in a frame. */
struct CV_EXPORTS_W_SIMPLE TrueKeypoint
{
    CV_WRAP TrueKeypoint();
    CV_PROP String name;            //!< as in the tool file
    CV_PROP Point2d imagePoint;     //!< in the (distorted) left image [pixel]
    CV_PROP Point3d cameraPoint;    //!< in the left camera's frame [m]; zeros where keypoints.csv has no x, y, z
    CV_PROP bool visible;           //!< nothing hides it
};

/** @brief A recorded sequence: a folder with sequence.yaml, video, kinematics.csv and, where known, groundtruth.csv and keypoints.csv.
The format is described in doc/formats.md. Frame k is at time k / fps, or where frames.csv has it. Keys and columns that are not known are ignored. */
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
    /** @brief Time of a frame: its stamp in frames.csv, interpolated between and 1 / fps apart beyond those it has; without that file
    frame / fps [s].
    @param frame number, from 0 on
    @param field 1: of its second field, half a frame later */
    CV_WRAP double frameTime(int frame, int field = 0) const;
    /** @brief Whether there is a frames.csv. */
    CV_WRAP bool hasFrameTimes() const { return !frames_.empty(); }
    /** @brief The left camera, or the only one. */
    CV_WRAP CameraModel leftCamera() const { return left_; }
    /** @brief The right camera; of size 0 x 0 if there is one camera. */
    CV_WRAP CameraModel rightCamera() const { return right_; }
    /** @brief Path of the left video; may lie outside the folder. Empty if not recorded and not named. */
    CV_WRAP String leftVideo() const { return leftVideo_; }
    /** @brief Path of the right video, which is the left one if both eyes are in one file; empty if there is one camera. */
    CV_WRAP String rightVideo() const { return rightVideo_; }

    /** @brief See SequenceLayout. */
    CV_WRAP int layout() const { return layout_; }
    /** @brief Of the frames of the videos: the cameras' size, or twice that if both eyes are in one file [pixel]. */
    CV_WRAP Size frameSize() const;
    /** @brief Images of an eye in a frame: 2 if it holds two fields, which the key `fields` tells, else 1. */
    CV_WRAP int imagesPerFrame() const { return fields_ ? 2 : 1; }
    /** @brief An eye's image out of a frame of its video.
    @param frame of frameSize(), CV_8UC1 or CV_8UC3
    @param image of the camera's size; the frame itself, not a copy, if there is nothing to take apart
    @param eye 0 = left, 1 = right
    @param field 0 to imagesPerFrame() - 1, as they follow in time; see splitFields() */
    CV_WRAP void eyeImage(InputArray frame, OutputArray image, int eye = 0, int field = 0) const;
    /** @brief What of an eye's images shows the scene, for ToolTracker::setMask(): the key `mask`.
    @param eye 0 = left, 1 = right
    @return CV_8UC1 of the camera's size, 0 where there is nothing to see; empty without the key
    @throws cv::Exception naming file, key and what was expected */
    CV_WRAP Mat mask(int eye = 0) const;

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
    @param time of the image [s]; SequenceTool::timeOffset is added
    @param joints one value per wanted coordinate [rad or m]
    @param coordinates the coordinates wanted, as ToolModel::coordinateNames(); empty = all of jointNames()
    @return false if the time lies outside the records (by more than one sampling interval); joints is then unchanged
    @throws cv::Exception if kinematics.csv has no column for a coordinate */
    CV_WRAP bool jointsAt(int tool, double time, CV_OUT std::vector<double>& joints,
                          const std::vector<String>& coordinates = std::vector<String>()) const;

    /** @brief Names of the joint columns of kinematics.csv: all but `time` and `tool`. */
    CV_WRAP std::vector<String> jointNames() const { return jointNames_; }

    /** @brief Time of a tool's first joint reading, on the images' clock [s]. */
    CV_WRAP double firstTime(int tool) const;
    /** @brief Time of a tool's last joint reading, on the images' clock [s]. */
    CV_WRAP double lastTime(int tool) const;

    /** @brief Path of sequence.yaml. */
    CV_WRAP String descriptionFile() const { return filename_; }
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

    /** @brief Path of groundtruth.csv, whether there is one or not. */
    CV_WRAP String groundTruthFile() const { return groundTruthFile_; }

    /** @brief True places of a tool's keypoints in a frame, in the order of the file.
    @param tool index
    @param frame number
    @return empty if there are none of this frame, or no keypoints.csv
    @throws cv::Exception naming file, line and what was expected; the file is read when it is first asked for */
    CV_WRAP std::vector<TrueKeypoint> keypoints(int tool, int frame) const;
    /** @brief Whether the folder has a keypoints.csv; it may hold no points. */
    CV_WRAP bool hasKeypoints() const;
    /** @brief Path of keypoints.csv, whether there is one or not. */
    CV_WRAP String keypointsFile() const { return keypointsFile_; }

private:
    struct KeypointRecords;
    struct JointRecords { std::vector<double> times; std::vector<double> values; };   // values: row-major, a row a time
    struct Truth { Matx44d camera_T_tool; std::vector<double> joints; };

    Sequence();
    void readDescription(const String& filename, bool recorded);
    void readImages(const NodeReader& root, bool recorded);
    void readFrames(const String& filename);
    void readKinematics();
    void readGroundTruth();
    void readKeypoints() const;
    const JointRecords& records(int tool) const;

    String name_, leftVideo_, rightVideo_, kinematicsFile_, groundTruthFile_, keypointsFile_;
    String filename_, masks_[2];        // of the description; an eye's, or none
    int layout_, fields_;               // fields_: 0 = none, 1 = the top one first, 2 = the bottom one
    double fps_;
    std::vector<int> frames_;           // of frames.csv, with
    std::vector<double> stamps_;        // their times [s]
    CameraModel left_, right_;
    Matx44d right_T_left_;
    std::vector<SequenceTool> tools_;
    std::vector<String> jointNames_;
    std::vector<JointRecords> records_;                // a tool
    bool hasGroundTruth_;
    std::vector<std::map<int, Truth> > truth_;         // a tool, by frame
    Ptr<KeypointRecords> keypoints_;
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

    /** @brief Begins a file of estimates. Its further columns are what they say beside the pose (doc/formats.md): evidence, standard
    deviations, and the offsets of the joints, those of the first tool.
    @param filename is overwritten
    @param tools names
    @param models theirs
    @param extraColumns names of columns after these
    @throws cv::Exception naming the file if it can't be written */
    CV_WRAP static Ptr<PoseWriter> create(const String& filename, const std::vector<String>& tools, const std::vector<Ptr<ToolModel> >& models,
                                          const std::vector<String>& extraColumns = std::vector<String>());
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

    /** @brief Adds the row of an estimate to a file that was begun for estimates.
    @param frame number
    @param time [s]
    @param tool name, one of those given to create()
    @param estimate of this tool; values it has none of are left empty: deviations without a covariance, offsets of joints that only
    the first tool has
    @param extra one value per column of `extraColumns`; non-finite values are left empty
    @throws cv::Exception as above */
    CV_WRAP virtual void write(int frame, double time, const String& tool, const ToolEstimate& estimate,
                               const std::vector<double>& extra = std::vector<double>()) = 0;
};

/** @brief Puts cameras into a folder's sequence.yaml, which is made if it does not exist; all else in it is kept, but for comments.
@param folder of the sequence; is made if it does not exist
@param cameras one eye or two
@param leftVideo path for the key `left.video`; empty: that stays as it is, or `left.mp4`
@param rightVideo the same of the right eye
@param fps frames per second; 0: stays as it is, or is missing */
CV_EXPORTS_W void writeSequenceCameras(const String& folder, const CameraPair& cameras, const String& leftVideo = String(),
                                       const String& rightVideo = String(), double fps = 0);

/** @brief Puts a tool into a folder's sequence.yaml, in the place of the one of this name, or at the end.
@param folder of the sequence; is made if it does not exist
@param name as in the CSV files
@param model path of the tool file, for the key `model`; empty: stays as it is
@param nominal_T_base the hand-eye calibration, key `camera_T_base` */
CV_EXPORTS_W void writeSequenceTool(const String& folder, const String& name, const String& model, const Matx44d& nominal_T_base);

/** @brief Puts a tool's joint readings into a folder's kinematics.csv, in the place of those of this name.
@param folder of the sequence; is made if it does not exist
@param name of the tool
@param coordinates names of the columns; other tools in the file must have the same
@param times rising, on the clock on which frame k is at k / fps [s]
@param joints N x C CV_64F, a row a time [rad or m] */
CV_EXPORTS_W void writeSequenceJoints(const String& folder, const String& name, const std::vector<String>& coordinates,
                                      const std::vector<double>& times, InputArray joints);

/** @brief Sets a tool's `camera_T_base` in a sequence.yaml. The rest of the file stays as it is, to the byte; the new file takes the
place of the old one at once.
@param sequence the folder, or its sequence.yaml
@param tool name
@param camera_T_base rigid [m]
@throws cv::Exception naming file and key: not a description as in doc/formats.md, no such tool, can't be written */
CV_EXPORTS_W void writeHandEye(const String& sequence, const String& tool, const Matx44d& camera_T_base);

/** @brief Reads rigid poses from a CSV file with the columns `index` or `time`, and tx, ty, tz [m], qx, qy, qz, qw.
@param filename the file
@param keys values of the first of these columns, rising [s if it is `time`]
@param poses N x 16 CV_64F: 4 x 4 matrices, row by row
@return whether the column is `time`
@throws cv::Exception naming file and line */
CV_EXPORTS_W bool readPoses(const String& filename, CV_OUT std::vector<double>& keys, OutputArray poses);

//! @}

}} // namespace cv::surgtrack

#endif
