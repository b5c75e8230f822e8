// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SETUP_CHECK_HPP
#define OPENCV_SURGTRACK_SETUP_CHECK_HPP

#include "opencv2/surgtrack/sequence.hpp"

namespace cv { namespace surgtrack {

//! @addtogroup surgtrack
//! @{

/** @brief Looks for mistakes in the setup of a recorded sequence: units of readings and meshes, joint limits, hand-eye calibrations,
clocks, and, with @p stereo, the eyes against each other. Where none of these is found, the tools are tracked in some thirty frames
spread over the video (its first 5000 frames), to see whether arms or tool files are exchanged, clocks differ, or another instrument is
seen. Takes seconds; where tools are not found, up to a minute.

An instrument very much like the model's can't be told from it; nor is it looked for where a tool is never in the image.
@param sequence video and readings
@param findings what is likely to be wrong, with the probable cause and the key to change, a line each; none: nothing was found
@param figures what was seen of each tool, a line each; none if a finding came before the tracking
@param stereo the right eye is used
@throws cv::Exception if the video can't be read */
CV_EXPORTS_W void checkSetup(const Ptr<Sequence>& sequence, CV_OUT std::vector<String>& findings, CV_OUT std::vector<String>& figures,
                             bool stereo = false);

/** @brief Whether the first images of the eyes contradict `right_T_left`: corners are found where they would be with the eyes exchanged.
@param sequence with two eyes
@return what is wrong, in a line; empty: nothing, or it can't be told */
CV_EXPORTS_W String checkEyes(const Ptr<Sequence>& sequence);

/** @brief Whether joint readings are in radians and metres.
@param model the tool
@param joints N x C, a reading a row
@return what no instrument can have, in a line; empty: nothing */
CV_EXPORTS_W String checkUnits(const Ptr<ToolModel>& model, InputArray joints);

//! @}

}} // namespace cv::surgtrack

#endif
