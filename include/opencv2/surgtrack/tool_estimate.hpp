// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_TOOL_ESTIMATE_HPP
#define OPENCV_SURGTRACK_TOOL_ESTIMATE_HPP

#include "opencv2/surgtrack/part_match.hpp"
#include "opencv2/surgtrack/tracking_state.hpp"

namespace cv { namespace surgtrack {

//! @addtogroup surgtrack
//! @{

/** @brief The tracker's answer for one tool and one frame. */
struct CV_EXPORTS_W_SIMPLE ToolEstimate
{
    CV_WRAP ToolEstimate();

    CV_PROP_RW int state;                   //!< see cv::surgtrack::TrackingState
    CV_PROP_RW Matx44d camera_T_tool;       //!< pose of the end effector in the camera frame [m]
    CV_PROP_RW Matx44d camera_T_nominal;    //!< the correction of the hand-eye calibration
    CV_PROP_RW Matx66d covariance;          //!< of camera_T_tool: (rotation vector [rad], translation [m]), both in the camera frame; zero with METHOD_EPNP
    CV_PROP_RW std::vector<double> jointOffsets;   //!< METHOD_FULL: one per coordinate, what is wrong with the reading and is added to it [rad or m], and 0 where ToolModel::offsetDeviations() is; else zeros
    CV_PROP_RW std::vector<double> joints;  //!< one per coordinate, those the pose is of: the readings, as they are `delay` later, with jointOffsets, and no jaw beyond its stop [rad or m]
    CV_PROP_RW int visibleParts;            //!< parts that had a template, in the left image
    CV_PROP_RW int inliers;                 //!< matches in the left image that agreed on the geometric context and went into the pose; 0 if nothing was measured, or METHOD_FULL followed the outline alone
    CV_PROP_RW double similarity;           //!< mean similarity of the inliers, 0..1; 0 without inliers
    CV_PROP_RW double contourSupport;       //!< METHOD_FULL: share of the visible outline, in both eyes, whose strongest edge within 6 px is at most 1.5 px off (pixels at 720 px width), 0..1; else 0. Of the last pose that was looked at, also if it was not believed
    CV_PROP_RW double confidence;           //!< METHOD_FULL: probability that the pose is within 5 mm and 10 px of the truth, from this frame's evidence and from how sure the pose was that it follows from (src/track/evidence.hpp); else, and where nothing was measured, 0
    CV_PROP_RW double nis;                  //!< of the inliers, normalised innovation squared per degree of freedom; about 1 if image points are as bad as the filter takes them for, less if they are better; 0 with METHOD_EPNP and without inliers
    CV_PROP_RW double delay;                //!< METHOD_FULL: the image shows the joints as they are read so much later, negative: earlier [s]; else 0
    CV_PROP_RW std::vector<PartMatch> matches;   //!< the inliers
    CV_PROP_RW int skippedReadings;         //!< frames since addTool() or reset() whose readings no joint can have: further beyond ToolModel::jointLimits() than these are apart, or without limits 10 m or 100 turns. Such a frame has the readings of the frame before
};

//! @}

}} // namespace cv::surgtrack

#endif
