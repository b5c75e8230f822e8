// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_HAND_EYE_HPP
#define OPENCV_SURGTRACK_HAND_EYE_HPP

#include "opencv2/surgtrack/sequence.hpp"

namespace cv { namespace surgtrack {

//! @addtogroup surgtrack
//! @{

/** @brief Who holds the camera and who the board while a hand-eye calibration is recorded.

In both set-ups two frames of the robot are sought in: `mount`, which does not move against the camera, and `holder`, which does
not move against the board: `camera_T_board = camera_T_mount * mount_T_holder * holder_T_board`. */
enum HandEyeSetup
{
    HAND_EYE_BOARD_ON_TOOL = 0,    //!< the instrument holds the board, the camera stands: mount = the arm's base, holder = the tool
    HAND_EYE_CAMERA_ON_ARM = 1     //!< an arm holds the camera, the board lies: mount = the end of that arm, holder = its base
};

/** @brief Ways to solve for a hand-eye calibration. The first five are those of cv::calibrateHandEye(), the next two those of
cv::calibrateRobotWorldHandEye(). */
enum HandEyeMethod
{
    HAND_EYE_BEST = -1,         //!< that with the smallest error in poses left out
    HAND_EYE_TSAI = 0,          //!< Tsai and Lenz 1989, as in the paper
    HAND_EYE_PARK = 1,
    HAND_EYE_HORAUD = 2,
    HAND_EYE_ANDREFF = 3,
    HAND_EYE_DANIILIDIS = 4,
    HAND_EYE_SHAH = 5,
    HAND_EYE_LI = 6,
    HAND_EYE_REFINED = 7        //!< least squares of the poses' errors in their standard deviations, from the best of the others
};

/** @brief `tsai`, `park`, ..., `refined`; `best` for HAND_EYE_BEST. */
CV_EXPORTS_W String handEyeMethodName(int method);

/** @brief Options of estimateHandEye(). */
struct CV_EXPORTS_W_SIMPLE HandEyeParams
{
    CV_WRAP HandEyeParams();
    CV_PROP_RW int setup;            //!< see cv::surgtrack::HandEyeSetup; default HAND_EYE_BOARD_ON_TOOL, the paper's
    CV_PROP_RW int method;           //!< see cv::surgtrack::HandEyeMethod; default HAND_EYE_BEST
    CV_PROP_RW double rejection;     //!< a pose is thrown out if its error is so many standard deviations; default 3, 0 = keep all
    CV_PROP_RW int seed;             //!< of all random choices
};

/** @brief What one method found. Errors are root mean squares over the poses that were not thrown out. */
struct CV_EXPORTS_W_SIMPLE HandEyeFit
{
    CV_WRAP HandEyeFit();
    CV_PROP int method;                    //!< see cv::surgtrack::HandEyeMethod
    CV_PROP bool valid;                    //!< false: it has no finite answer, or none if a pose is left out; all else is then 0
    CV_PROP Matx44d camera_T_mount;        //!< the calibration. HAND_EYE_BOARD_ON_TOOL: camera_T_base
    CV_PROP Matx44d holder_T_board;        //!< where the board is
    CV_PROP double translation;            //!< error of the middle of the board [m]
    CV_PROP double rotation;               //!< error of the board's orientation [rad]
    CV_PROP double pixels;                 //!< error of the board's points in the image [pixel]; 0 without a camera
    CV_PROP double leftOutTranslation;     //!< the same, of each pose by the calibration from all the others [m]
    CV_PROP double leftOutRotation;        //!< [rad]
    CV_PROP double leftOutPixels;          //!< [pixel]
    CV_PROP double spreadTranslation;      //!< standard deviation of the calibration where the board was, from those without a pose each (jackknife) [m]
    CV_PROP double spreadRotation;         //!< standard deviation of its rotation, likewise [rad]
};

/** @brief The answer of estimateHandEye(). */
struct CV_EXPORTS_W_SIMPLE HandEyeResult
{
    CV_WRAP HandEyeResult();
    CV_PROP HandEyeFit best;                   //!< the calibration to use
    CV_PROP std::vector<HandEyeFit> fits;      //!< all methods, in the order of HandEyeMethod
    CV_PROP std::vector<int> rejected;         //!< indices of the poses that were thrown out, rising
    CV_PROP Mat residuals;                     //!< N x 3 CV_64F, of `best`, of all poses: [m], [rad], [pixel]
    CV_PROP double largestRotation;            //!< between any two poses that were kept [rad]
    CV_PROP double crossRotation;              //!< the same, about axes perpendicular to the one they turn about most [rad]
    CV_PROP std::vector<String> warnings;      //!< too little motion, an uncertain result: one line each
    CV_PROP String reason;                     //!< why the calibration can't be told, one line; empty if it can
};

/** @brief Hand-eye calibration: the camera against the robot, from poses of robot and board.

Every method is run. Poses that do not fit the others are thrown out first: from the least median of squares over random quadruples,
then repeatedly those whose error, as predicted from the others, is more than HandEyeParams::rejection standard deviations (root mean
square of three translations and three rotations). With less than six poses none is. The standard deviations, along the line of
sight and across, are taken from the medians of these errors. Each pose is then left out once, of more than 30 poses every
thirtieth, and predicted from the others: the method with the smallest of these errors, in standard deviations, is the best.
The methods look at all pairs of poses: 20 poses take half a second, 100 half a minute.

@param robotPoses N poses, N x 4 x 4 (or N x 16), floating, rigid [m], N from 4 to 200: HAND_EYE_BOARD_ON_TOOL base_T_tool, HAND_EYE_CAMERA_ON_ARM
base_T_arm of the arm that holds the camera
@param boardPoses as many poses camera_T_board, as findBoard() gives them
@param result after false `best` must not be relied on, and `reason` says why
@param params options
@param camera to report errors in pixels too; an empty one = not
@param boardPoints N x 3 points of the board, in its frame [m], see getBoardPoints(). Without them the corners of a square of 15 mm,
with the frame's origin in the middle
@return whether the calibration can be told. It can't be from poses that all turn about the same axis
@throws cv::Exception naming the argument, and the pose, if it is not valid */
CV_EXPORTS_W bool estimateHandEye(InputArray robotPoses, InputArray boardPoses, CV_OUT HandEyeResult& result,
                                  const HandEyeParams& params = HandEyeParams(), const CameraModel& camera = CameraModel(),
                                  InputArray boardPoints = noArray());

/** @brief A flat calibration board. Both kinds look different upside down, so that poses from several images belong together. */
struct CV_EXPORTS_W_SIMPLE CalibrationBoard
{
    enum Pattern { CHESSBOARD = 0, ASYMMETRIC_CIRCLES = 1 };

    CV_WRAP CalibrationBoard();
    CV_PROP_RW int pattern;       //!< default ASYMMETRIC_CIRCLES, the paper's
    CV_PROP_RW Size size;         //!< inner corners of a chessboard, one of the numbers odd and one even; circles a row and rows, an odd number of rows; default 4 x 11, the paper's
    CV_PROP_RW double spacing;    //!< side of a square; distance of two rows of circles, half of that of two circles in a row [m]; default 0.0015, the paper's
};

/** @brief Points of a board, in the order of cv::findChessboardCorners() and cv::findCirclesGrid().
@param board the board
@param points N x 3 CV_64F, z = 0 [m]
@throws cv::Exception if the board is not one of those CalibrationBoard describes */
CV_EXPORTS_W void getBoardPoints(const CalibrationBoard& board, OutputArray points);

/** @brief Finds a board in an image and its pose, with the camera's distortion.
@param image as the camera delivers it, CV_8UC1 or CV_8UC3, of the camera's image size
@param camera the camera
@param board the board
@param camera_T_board its pose [m]
@param imagePoints N x 2 CV_64F, where its points were found [pixel]
@param error root mean square distance of the points found from those of the pose [pixel]
@return false if the board was not found; the outputs are then unchanged */
CV_EXPORTS_W bool findBoard(InputArray image, const CameraModel& camera, const CalibrationBoard& board, CV_OUT Matx44d& camera_T_board,
                            OutputArray imagePoints, CV_OUT double& error);

//! @}

}} // namespace cv::surgtrack

#endif
