// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_IMPORT_HPP
#define OPENCV_SURGTRACK_IMPORT_HPP

#include "opencv2/surgtrack/sequence.hpp"

// Files of other programs -> tools, cameras, joint readings and labels of this module, and sequence folders made of them.
// Whatever is wrong in a file is a cv::Exception that names the file, the key or the line, and what was expected.

namespace cv { namespace surgtrack {

//! @addtogroup surgtrack
//! @{

/** @brief What the kinematics of a robot do not say of a tool: its shape, and the points to look for. */
struct CV_EXPORTS_W_SIMPLE ToolParts
{
    CV_WRAP ToolParts();

    /** A tool file to take meshes, keypoints, jaws and the place of the end effector from, for a tool of the same build; empty: none.
    Of a dVRK tool it also gives the names of links and coordinates, joint for joint; links of an URDF are found by their names. */
    CV_PROP_RW String like;

    //! `LINK:FILE` each: mesh files (PLY, STL or OBJ) of links; they replace those of the file imported, or of `like`,
    //! which are not read. `LINK:none`: that link has no mesh.
    CV_PROP_RW std::vector<String> meshes;

    CV_PROP_RW double meshScale;        //!< of the files in `meshes`: metres per unit; 1 = metres, 0.001 = millimetres

    /** The axes of `meshes` are those of the reported tool frame (the rotation of `tooltip_offset`), as in jhu-dvrk/dvrk_model, and not
    those of the Denavit-Hartenberg frame of their link. Their origin is the link's in both cases. dVRK tools only. */
    CV_PROP_RW bool meshesInToolAxes;

    /** A CSV file `name,link,x,y,z`: keypoints as they are picked in the link's mesh file, in its axes and unit (of an URDF: before the visual's scale
    and origin); they replace those of `like`, and may be 2 mm off the link's surface at most. `auto` or `auto:N`: chooseKeypoints() chooses.
    Empty: those of `like`, else none. */
    CV_PROP_RW String keypoints;

    CV_PROP_RW String packages;         //!< URDF: the folder in which `package://NAME/...` is looked for, as NAME/... or as ...; empty: the URDF's, and those above it
    CV_PROP_RW String base;             //!< URDF: the link to take for the arm's base, the remote centre of motion; empty: the root
    CV_PROP_RW String endEffector;      //!< URDF: the link to report the pose of; empty: as in `like`, else `tool_tip_link`, else the only end that no joint moves by itself
};

/** @brief A tool from the kinematics of the da Vinci Research Kit, arm and instrument.

Reads files as sawIntuitiveResearchKit has them, comments included: `DH.joints` (or, in old files, `DH.links`), modified convention;
`tooltip_offset` (old: `tooltip-offset`); `jaw`. `theta + offset + q` turns, `D + offset + q` slides. As the dVRK does, angles that
are a multiple of pi / 12 rounded to four digits (1.5708) are made exact. Coordinates are `q1`, `q2`, ..., and `jaw` if a file has
one: two jaws that open by half of it each, `jaw_right` and `jaw_left`.

The end effector has the rotation of `tooltip_offset`. Its origin is that of `tooltip_offset`; where that is at 0, as the dVRK ships it,
and ToolParts::like is given, it is where that tool has it.

@param files the kinematic files in the order of the joints: the arm's (PSM.json), the instrument's (LARGE_NEEDLE_DRIVER_400006.json);
or one old file with all. Joints of mode `passive` do not move
@param parts meshes and keypoints; without any the tool has kinematics only
@throws cv::Exception (StsNotImplemented) if the module was built without nlohmann_json */
CV_EXPORTS_W Ptr<ToolModel> importDvrkTool(const std::vector<String>& files, const ToolParts& parts = ToolParts());

/** @brief A tool from an expanded URDF (no xacro).

Joints that turn or slide become coordinates of the same name; joints that mimic share the coordinate of the joint they follow. A
joint in a general place takes up to four links of modified Denavit-Hartenberg transforms; the last has the name of the URDF's link.
Coordinates come in the order of the joints on the way to the end effector, from the base on, then the others as in the file.
The visuals of a link are read, with their scale and origin: meshes, cylinders, spheres and boxes; those of the base are not, it does not move with the tool.
Limits of joints are kept.
Rotations by quarter turns about the axes whose angles were rounded (1.5708, 1.570796327) are made exact.

@param filename the URDF
@param parts ToolParts::packages for `package://` names; keypoints and end effector
@throws cv::Exception (StsNotImplemented) if the module was built without urdfdom */
CV_EXPORTS_W Ptr<ToolModel> importUrdfTool(const String& filename, const ToolParts& parts = ToolParts());

/** @brief Cameras from ROS calibration files (`camera_info` YAML, as camera_calibration writes them), or CameraInfo messages as `ros2 topic
echo` prints them. Without a region of interest images are of the whole sensor.
@param files the left camera's, or left and right of a stereo pair (its baseline is in the `projection_matrix`, in metres)
@throws cv::Exception for distortion models other than plumb_bob and rational_polynomial, and cameras more than 0.5 m apart */
CV_EXPORTS_W CameraPair importCameraInfo(const std::vector<String>& files);

/** @brief Cameras from files of cv::FileStorage.

Keys are those of OpenCV's samples and common elsewhere: `M1, D1, M2, D2, R, T` (intrinsics.yml and extrinsics.yml),
`cameraMatrix1, distCoeffs1, ...`, `camera_matrix, distortion_coefficients` (`Camera_Matrix, Distortion_Coefficients`). Calibrations of
fisheye lenses are refused.

@param files one or several, taken together
@param unit metres per unit of T (0.001 for a board measured in millimetres); needed with two eyes, as files do not say it
@param imageSize [pixel]; empty: the file has to have it (`image_width`, `image_height` or `imageSize`) */
CV_EXPORTS_W CameraPair importOpenCVCameras(const std::vector<String>& files, double unit = 0, Size imageSize = Size());

/** @brief Cameras from SurgPose's StereoCalibrationDVRK.ini: `kc_0, kc_1, kc_4` radial, `kc_2, kc_3` tangential; T in millimetres. */
CV_EXPORTS_W CameraPair importSurgPoseCameras(const String& filename);

/** @brief A hand-eye calibration from a file of others.
@param filename of cv::FileStorage, plain YAML or JSON: `camera_T_base`; the dVRK's `...-registration-open-cv.json`: `base-frame.transform`;
or a text of three or four lines of four numbers
@return camera_T_base [m] */
CV_EXPORTS_W Matx44d importHandEye(const String& filename);

/** @brief Joint readings from CSV files of dVRK or ROS recordings.

The time is the column `...header.stamp`, `...stamp`, `time` (`Time`, `time_ms`, `time [ns]`), `__time`, `%time` or `t`, or the pair `...secs`
and `...nsecs` (`...sec`, `...nanosec`); the first of these in which the time does not stand still. Seconds or nanoseconds are told by the
rate, which must lie between 2 Hz and 5 kHz, if the name has no unit; dates of ISO 8601 are seconds since 1970. Joints are the columns of the
coordinate's name, of the dVRK's (`yaw` or `outer_yaw` for q1, ... `jaw`), perhaps followed by `position` or a unit (`q1 [deg]`,
`insertion_mm`); those whose names stand in the rows (`name0` of `position0`, or lists `name` and `position`); or, in a file with none of
these, `...position0`, `...position[1]`, ..., in the order of the coordinates, going on from file to file. A cell that is empty or
`nan` has no reading: each joint is interpolated over those it has.

@param files the arm's, and if the jaw was recorded apart, the jaw's: interpolated to the times of the first
@param coordinates names, as ToolModel::coordinateNames()
@param times of the readings, on the recording's own clock [s]
@param joints N x C CV_64F, a row a time [rad or m]
@param columns the column of each coordinate, with its unit if that is in the name (`a [deg]`), if the names are others; empty: as above
@throws cv::Exception too if a joint of the dVRK slides further than 10 m or turns more than twice: other units */
CV_EXPORTS_W void importJoints(const std::vector<String>& files, const std::vector<String>& coordinates, CV_OUT std::vector<double>& times,
                               OutputArray joints, const std::vector<String>& columns = std::vector<String>());

/** @brief Joint values of SurgPose (api_jp_data.yaml): of each frame, from 0 on, six of each arm.
@param filename the YAML
@param arm `PSM1` or `PSM3`
@param coordinates of the tool, 7
@param jaw the last one, which the recording has not [rad]
@param joints N x coordinates CV_64F, a row a frame [rad or m] */
CV_EXPORTS_W void importSurgPoseJoints(const String& filename, const String& arm, int coordinates, double jaw, OutputArray joints);

/** @brief Joint values from the poses recorded by the authors of @cite ye2016realtime (`sim-PSM1-....xml` of daVinciToolTrack, millimetres).

The poses of the links of the coordinates q4, q5 and q6 are known; joints are found by Gauss-Newton steps, turns without jumps. The jaw
is clamped at closed.

@param filename the XML
@param model the tool: six joints to the end effector, and a coordinate for the jaw
@param joints N x 7 CV_64F, a row a frame, in the order of the model's coordinates [rad or m]
@throws cv::Exception too if a pose is more than 1 mm or 0.02 rad from any the model can take (the three poses of a frame were read one
after the other: in fast motion they disagree by up to 0.17 mm and 5e-3 rad) */
CV_EXPORTS_W void importDaVinciJoints(const String& filename, const Ptr<ToolModel>& model, OutputArray joints);

/** @brief Hand-eye calibration of the same authors (`out_handeye_data.xml`, millimetres).
@param filename the XML
@param key `bHc_psm1` or `bHc_psm2`
@return nominal_T_base, the base in the camera's frame [m] */
CV_EXPORTS_W Matx44d importDaVinciHandEye(const String& filename, const String& key);

/** @brief Writes keypoints.csv from the labels of the EndoVis 2015 challenge (JSON: a list of images).
@param labels the JSON; the frame is the number in an entry's `filename`, counted from that of the first entry; without numbers entry k is frame k. A
label without `id`, as some of the test set are, is of the only tool of its image without a label of that class; else it is left out
@param csv the file to write
@param keypoints `CLASS:NAME` each: label classes to write and the names of the tool's keypoints they are; empty: all, by their class
@param tools `ID:NAME` each, the same for tools
@return number of points
@throws cv::Exception (StsNotImplemented) if the module was built without nlohmann_json */
CV_EXPORTS_W int importEndoVisKeypoints(const String& labels, const String& csv, const std::vector<String>& keypoints = std::vector<String>(),
                                        const std::vector<String>& tools = std::vector<String>());

/** @brief Writes keypoints.csv from the labels of SurgPose (keypoints_left.yaml). Keypoints 1 to 7 are those of PSM1, 8 to 14 of PSM3.
@param labels the YAML
@param csv the file to write
@param keypoints `NUMBER:NAME` each, the number as in the file; empty: all, by their number
@param tools `PSM1:NAME` and `PSM3:NAME`; empty: both, by these names
@return number of points */
CV_EXPORTS_W int importSurgPoseKeypoints(const String& labels, const String& csv, const std::vector<String>& keypoints = std::vector<String>(),
                                         const std::vector<String>& tools = std::vector<String>());

//! @}

}} // namespace cv::surgtrack

#endif
