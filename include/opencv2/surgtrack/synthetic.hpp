// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SYNTHETIC_HPP
#define OPENCV_SURGTRACK_SYNTHETIC_HPP

#include "opencv2/surgtrack/mesh_renderer.hpp"

namespace cv { namespace surgtrack {

//! @addtogroup surgtrack
//! @{

/** @brief A synthetic scene with exact truth: tools moving over textured tissue, seen by an endoscope.

The built-in sequence of tests and demonstration. Tools are lit by the endoscope's own light; the image has vignette,
noise and, if the camera has it, distortion. The recorded joints carry bias, drift and noise, and the recorded hand-eye
calibration is wrong. Everything follows from the seed. */
class CV_EXPORTS_W SyntheticScene
{
public:
    struct CV_EXPORTS_W_SIMPLE Params
    {
        CV_WRAP Params();
        CV_PROP_RW int tools;                  //!< 1..4
        CV_PROP_RW int frames;                 //!< length; the motion is periodic in it
        CV_PROP_RW int seed;
        CV_PROP_RW Size imageSize;             //!< [pixel]; write() needs an even width and height
        CV_PROP_RW double fps;
        CV_PROP_RW double handEyeRotation;     //!< error of the recorded hand-eye calibration [rad]
        CV_PROP_RW double handEyeTranslation;  //!< the same [m], at the tool
        CV_PROP_RW double jointNoise;          //!< scale of offsets and noise of the joints: 1 = 0.006 rad and 0.6 mm at the arm, 0.02 rad at the wrist, 0.03 rad at the jaw; 0 = none
        CV_PROP_RW double cables;              //!< scale of what the cables of wrist and jaws add: 1 = as measured on a real arm, play of 0.02 rad, gains of 2 %, a coupling of pitch into yaw of 0.09; 0 (default) = nothing
        CV_PROP_RW double imageNoise;          //!< standard deviation of the sensor noise [grey levels]
        CV_PROP_RW bool distortion;            //!< lens distortion (k1 = -0.2) or a pinhole
        CV_PROP_RW bool stereo;                //!< a right image, 5.2 mm beside the left one
    };

    /** @brief A scene from its seed.
    @param model the tool all arms carry; empty = ToolModel::needleDriver(); an arm of two joints that turn, one that slides, one that rolls, two of
    a wrist, and perhaps one of jaws
    @param params options */
    CV_WRAP static Ptr<SyntheticScene> create(const Ptr<ToolModel>& model = Ptr<ToolModel>(),
                                              const SyntheticScene::Params& params = SyntheticScene::Params());
    virtual ~SyntheticScene() {}

    /** @brief Number of arms. */
    CV_WRAP virtual int toolCount() const = 0;
    /** @brief Params::frames. */
    CV_WRAP virtual int frameCount() const = 0;
    /** @brief The tool that all arms carry. */
    CV_WRAP virtual Ptr<ToolModel> model() const = 0;
    /** @brief One of the cameras. @param right the right one of a stereo scene */
    CV_WRAP virtual CameraModel camera(bool right = false) const = 0;
    /** @brief Pose of the left camera in the frame of the right one [m]. */
    CV_WRAP virtual Matx44d right_T_left() const = 0;

    /** @brief The recorded, wrong, hand-eye calibration of an arm. */
    CV_WRAP virtual Matx44d nominal_T_base(int tool) const = 0;
    /** @brief The true hand-eye calibration of an arm (left camera). */
    CV_WRAP virtual Matx44d camera_T_base(int tool) const = 0;

    /** @brief True joints at a time [s]: one value per coordinate [rad or m]. */
    CV_WRAP virtual std::vector<double> trueJoints(int tool, double time) const = 0;
    /** @brief Joints at a time [s] as the robot reads them: one value per coordinate [rad or m]. */
    CV_WRAP virtual std::vector<double> recordedJoints(int tool, double time) const = 0;
    /** @brief camera_T_tool, exact (left camera). @param tool index @param time [s] */
    CV_WRAP virtual Matx44d truePose(int tool, double time) const = 0;

    /** @brief Draws a frame.
    @param frame number, 0 <= frame
    @param image CV_8UC3, BGR
    @param right the right eye of a stereo scene */
    CV_WRAP virtual void render(int frame, OutputArray image, bool right = false) = 0;

    /** @brief Draws a frame with arms that stand or move otherwise: as after a knock against the camera, or with one more arm.
    @param frame number, 0 <= frame; decides the sensor noise
    @param joints per arm the true joints, one value per coordinate [rad or m]; any number of arms
    @param camera_T_base per arm its base (left camera)
    @param image CV_8UC3, BGR
    @param right the right eye of a stereo scene
    @throws cv::Exception for vectors of different lengths, and for more links than a MeshRenderer can tell apart */
    CV_WRAP virtual void renderArms(int frame, const std::vector<std::vector<double> >& joints, const std::vector<Matx44d>& camera_T_base,
                                    OutputArray image, bool right = false) = 0;

    /** @brief Writes the scene as a sequence folder: sequence.yaml, video, kinematics.csv (100 Hz), groundtruth.csv,
    keypoints.csv, and the tool file with its meshes.
    @param folder is made if it does not exist
    @throws cv::Exception naming the file that can't be written */
    CV_WRAP virtual void write(const String& folder) = 0;
};

//! @}

}} // namespace cv::surgtrack

#endif
