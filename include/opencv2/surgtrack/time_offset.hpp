// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_TIME_OFFSET_HPP
#define OPENCV_SURGTRACK_TIME_OFFSET_HPP

#include "opencv2/surgtrack/sequence.hpp"

namespace cv { namespace surgtrack {

//! @addtogroup surgtrack
//! @{

/** @brief Options of estimateTimeOffset(). */
struct CV_EXPORTS_W_SIMPLE TimeOffsetParams
{
    CV_WRAP TimeOffsetParams();
    CV_PROP_RW double expected;        //!< centre of the search [s]; default 0
    CV_PROP_RW double range;           //!< offsets this far from the expected one are searched [s]; default 3
    CV_PROP_RW double step;            //!< of the first, coarse search [s]; default 0.16. A tool should move by less than 10 mm in it
    CV_PROP_RW int frames;             //!< at most so many frames are looked at, spread over the sequence; default 48
    CV_PROP_RW double minOverlap;      //!< offsets that leave less of the video with readings are not considered [s]; default 1.5
    CV_PROP_RW double minConfidence;   //!< see TimeOffset::confidence; default 0.15
    CV_PROP_RW double maxDeviation;    //!< see TimeOffset::deviation [s]; default 0.03
    CV_PROP_RW int seed;               //!< of all random choices
    CV_PROP_RW int tool;               //!< index of the only tool that is looked at, as arms may have clocks of their own; -1, the default: one offset holds for all
};

/** @brief The answer of estimateTimeOffset(). */
struct CV_EXPORTS_W_SIMPLE TimeOffset
{
    CV_WRAP TimeOffset();
    CV_PROP double offset;        //!< the readings that belong to the image of time t are those recorded at t + offset [s]
    CV_PROP double deviation;     //!< standard deviation of the offset, if it is the right one and not another that looks alike [s]
    CV_PROP double confidence;    //!< 0..1: by how much the images support this offset more than the next best that is not a neighbour; 0.5 = twice as much
    CV_PROP double support;       //!< summed similarity above chance of the parts found where the offset has them, a frame and tool
    CV_PROP int frames;           //!< frames in which a tool was found
    CV_PROP String reason;        //!< why the offset can't be told, one line; empty if it can
};

/** @brief Finds by how much the clocks of video and joint readings differ, from the whole of a recorded sequence.

The tools are drawn as the readings of many times say they look, and sought in frames spread over the video. Of each offset, in
coarse steps, the similarity of what was found tells how well it is supported. The best few are refined to a fraction of a frame:
one least-squares fit, over all frames, of the offset (a point is wrong by its velocity times the error of the offset), of the
correction of the hand-eye calibration and of constant errors of the joints; then tools are drawn and found again with the result.
The correction may change from one two-second block to the next where the images insist, as after a move of the camera.

Expects a calibration wrong by at most 14 mm at the tool and about 10 degrees. One offset holds for the whole sequence.
With the default options it takes about 15 s for two tools at 720x576, in proportion to frames, tools and range. The frames looked at
are kept in memory.

@param sequence video (the left one) and readings
@param result after false `offset` is the best guess and must not be relied on, and `reason` says why
@param params options
@return whether the offset is known: Params::minConfidence and Params::maxDeviation are met. It can't be known if tools hardly move
or are hardly seen, if too little of the video has readings, if the motion repeats itself within the range, or if the offset lies outside of it
@throws cv::Exception for options out of range and naming the file if the video can't be read or has frames of another size */
CV_EXPORTS_W bool estimateTimeOffset(const Ptr<Sequence>& sequence, CV_OUT TimeOffset& result,
                                     const TimeOffsetParams& params = TimeOffsetParams());

//! @}

}} // namespace cv::surgtrack

#endif
