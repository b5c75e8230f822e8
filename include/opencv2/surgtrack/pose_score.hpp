// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_POSE_SCORE_HPP
#define OPENCV_SURGTRACK_POSE_SCORE_HPP

#include "opencv2/surgtrack/camera.hpp"
#include "opencv2/surgtrack/tool_model.hpp"
#include "opencv2/surgtrack/tracking_state.hpp"

namespace cv { namespace surgtrack {

//! @addtogroup surgtrack
//! @{

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
    CV_PROP_RW double accuracy;            //!< share of all frames whose scored points are at most 10 pixel off, on average, in an image 720 pixel wide (paper, Sec. 3)
    CV_PROP_RW double silent;              //!< share of all frames that claim to be tracking and are more than 5 mm off
};

/** @brief Compares poses with the truth, as Table 1 of the paper does.

The scored points of a tool, for PoseScore::accuracy, move with its end effector: the end effector itself, its pivot, which is the origin
of the last link on the way to it that a joint moves, and the two points 3 mm beside the pivot on that joint's axis. Of a needle driver
they are the tip and the axis of the jaws. */
class CV_EXPORTS_W PoseScorer
{
public:
    /** @brief A scorer without poses yet.
    @param camera of the image the reprojection error is taken in; its distortion is left out
    @param models of the tools, whose points are scored */
    CV_WRAP static Ptr<PoseScorer> create(const CameraModel& camera, const std::vector<Ptr<ToolModel> >& models);
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

/** @brief What leads from an estimated pose to the true one, in the terms of ToolEstimate::covariance:
R_true = exp(rotation) R_estimate, t_true = translation + t_estimate.
@param camera_T_tool estimate
@param true_camera_T_tool truth
@return (rotation vector [rad], translation [m]), both in the camera frame */
CV_EXPORTS_W Matx61d poseError(const Matx44d& camera_T_tool, const Matx44d& true_camera_T_tool);

/** @brief Normalised error squared (NEES): e^T P^-1 e of some components, as many as its mean should be if P is right.
@param error see poseError()
@param covariance see ToolEstimate::covariance
@param first, count components, by default all: 0, 3 is the rotation alone, 3, 3 the translation
@return not a number if that block of the covariance is not positive definite, as without a covariance */
CV_EXPORTS_W double normalizedErrorSquared(const Matx61d& error, const Matx66d& covariance, int first = 0, int count = 6);

//! @}

}} // namespace cv::surgtrack

#endif
