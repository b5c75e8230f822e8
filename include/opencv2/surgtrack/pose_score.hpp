// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_POSE_SCORE_HPP
#define OPENCV_SURGTRACK_POSE_SCORE_HPP

#include "opencv2/surgtrack/camera.hpp"
#include "opencv2/surgtrack/tracking_state.hpp"

namespace cv { namespace surgtrack {

//! @addtogroup surgtrack
//! @{

/** @brief How good the poses of one tool are, measured against the truth. */
struct CV_EXPORTS_W_SIMPLE PoseScore
{
    CV_WRAP PoseScore();
    CV_PROP int frames;                 //!< with truth
    CV_PROP int covered;                //!< of these, with a pose that claims to be one: tracking or coasting
    CV_PROP double translationMean;     //!< distance of the end effector from its true place, over the covered frames [m]; 0 without any
    CV_PROP double translationStd;      //!< its standard deviation [m]
    CV_PROP double rotationMean;        //!< angle between estimated and true orientation, over the covered frames [rad]
    CV_PROP double rotationStd;         //!< its standard deviation [rad]
    CV_PROP double accuracy;            //!< share of all frames whose end effector is at most 10 pixel off in an image 720 pixel wide (paper, Sec. 3)
    CV_PROP double silent;              //!< share of all frames that claim to be tracking and are more than 5 mm off
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
