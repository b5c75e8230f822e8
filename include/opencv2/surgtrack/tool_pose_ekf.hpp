// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_TOOL_POSE_EKF_HPP
#define OPENCV_SURGTRACK_TOOL_POSE_EKF_HPP

#include "opencv2/surgtrack/camera.hpp"

namespace cv { namespace surgtrack {

//! @addtogroup surgtrack
//! @{

/** @brief The measurement function h(x) of the paper (Sec. 2.3, eq. 3-5): where keypoints of the nominal camera frame are seen.

@param camera intrinsics and distortion
@param state 6 values: x = (theta_x, theta_y, theta_z [rad], r_x, r_y, r_z [m]), the correction
camera_T_nominal = (Rot_z(theta_z) Rot_y(theta_y) Rot_x(theta_x), r)
@param nominalPoints N x 3, 64-bit: keypoints in the nominal camera frame, nominal_T_base * basePoint [m]
@param imagePoints N x 1 CV_64FC2 [pixel]; NaN where a point is not in front of the camera
@param jacobian if wanted, 2N x 6 CV_64F: dh / dx, rows u, v of point 0, then of point 1, ... */
CV_EXPORTS_W void projectKeypoints(const CameraModel& camera, InputArray state, InputArray nominalPoints, OutputArray imagePoints,
                                   OutputArray jacobian = noArray());

/** @brief camera_T_nominal of a state (theta_x, theta_y, theta_z [rad], r_x, r_y, r_z [m]). */
CV_EXPORTS_W Matx44d correctionFromState(InputArray state);
/** @brief The state, 6 x 1 CV_64F, of a camera_T_nominal: the inverse of correctionFromState(). */
CV_EXPORTS_W void stateFromCorrection(const Matx44d& camera_T_nominal, OutputArray state);

/** @brief EPnP on verified matches: the paper's start, and its per-frame baseline.
@param camera intrinsics and distortion
@param nominalPoints N x 3, 64-bit [m], N >= 4
@param imagePoints N x 2, 64-bit [pixel]
@param camera_T_nominal result; unchanged after false
@param maxError if positive, the pose is sought by RANSAC with this reprojection error [pixel]
@return whether a pose was found that has all points in front of the camera */
CV_EXPORTS_W bool solveEPnP(const CameraModel& camera, InputArray nominalPoints, InputArray imagePoints, CV_OUT Matx44d& camera_T_nominal,
                            double maxError = 0);

/** @brief The extended Kalman filter of the paper (Sec. 2.3): estimates the error of the hand-eye calibration.

State x: rotation (Euler angles) and translation of camera_T_nominal. Process: constant, with noise Q. Measurement: image points
of keypoints, z = h(x) + noise R. Parts that were not found have no rows. P is updated in Joseph's form. */
class CV_EXPORTS_W ToolPoseEKF
{
public:
    struct CV_EXPORTS_W_SIMPLE Params
    {
        CV_WRAP Params();
        CV_PROP_RW double initialRotation;      //!< standard deviation of the first state [rad]
        CV_PROP_RW double initialTranslation;   //!< the same [m]
        CV_PROP_RW double processRotation;      //!< process noise, standard deviation a frame [rad]
        CV_PROP_RW double processTranslation;   //!< the same [m]
        CV_PROP_RW double measurementNoise;     //!< standard deviation of an image point [pixel]
        CV_PROP_RW double gate;                 //!< points with a larger squared Mahalanobis distance are left out; 13.8 = 99.9 % of chi-square with 2 dof; 0 = none
        CV_PROP_RW int minPoints;               //!< with fewer points inside the gate nothing is updated; default 1
    };

    /** @param camera intrinsics and distortion
    @param params noise and gate */
    CV_WRAP static Ptr<ToolPoseEKF> create(const CameraModel& camera, const ToolPoseEKF::Params& params = ToolPoseEKF::Params());
    virtual ~ToolPoseEKF() {}

    /** @brief Starts anew from a correction (the unit matrix: the hand-eye calibration itself) with the initial covariance. */
    CV_WRAP virtual void reset(const Matx44d& camera_T_nominal) = 0;

    /** @brief Takes a correction and its covariance to another pair of frames, as when the camera moves or another calibration is given:
    camera_T_nominal <- now_T_camera camera_T_nominal nominal_T_now. @param now_T_camera rigid @param nominal_T_now rigid */
    CV_WRAP virtual void changeFrames(const Matx44d& now_T_camera, const Matx44d& nominal_T_now) = 0;

    /** @brief One frame passes: P grows by Q. */
    CV_WRAP virtual void predict() = 0;

    /** @brief Takes in measured keypoints.
    @param nominalPoints N x 3, 64-bit: keypoints in the nominal camera frame [m]
    @param imagePoints N x 2, 64-bit: where they were found [pixel]
    @param used if wanted, N x 1 CV_8U: 1 where the point passed the gate
    @return whether the state was updated; false if fewer than Params::minPoints passed or the innovation covariance is singular: nothing changes then */
    CV_WRAP virtual bool correct(InputArray nominalPoints, InputArray imagePoints, OutputArray used = noArray()) = 0;

    //! Makes another filter what this one is, but for its camera and parameters.
    virtual void copyTo(ToolPoseEKF& other) const = 0;

    /** @brief camera_T_nominal. */
    CV_WRAP virtual Matx44d correction() const = 0;
    /** @brief 6 x 1 CV_64F, see projectKeypoints(). */
    CV_WRAP virtual Mat state() const = 0;
    /** @brief 6 x 6 CV_64F, order of the state. */
    CV_WRAP virtual Mat covariance() const = 0;
    /** @brief Normalised innovation squared of the last correct(), per degree of freedom; 0 before the first. */
    CV_WRAP virtual double nis() const = 0;

    /** @brief Covariance of where a keypoint will be seen, H P H^T [pixel^2], without measurement noise. */
    CV_WRAP virtual Matx22d imageCovariance(const Point3d& nominalPoint) const = 0;

    /** @brief Covariance of camera_T_tool, (rotation vector, translation) in the camera frame, from that of the state.
    @param nominalTool origin of the tool in the nominal camera frame [m] */
    CV_WRAP virtual Matx66d poseCovariance(const Point3d& nominalTool) const = 0;
};

//! @}

}} // namespace cv::surgtrack

#endif
