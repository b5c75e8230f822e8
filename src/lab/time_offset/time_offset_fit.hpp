// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_LAB_TIME_OFFSET_TIME_OFFSET_FIT_HPP
#define OPENCV_SURGTRACK_SRC_LAB_TIME_OFFSET_TIME_OFFSET_FIT_HPP

#include "precomp.hpp"
#include "opencv2/surgtrack/qgo_matcher.hpp"
#include "opencv2/surgtrack/sequence.hpp"

namespace cv { namespace surgtrack {

//! A tool of the sequence, as the estimator of the time offset needs it.
struct OffsetTool
{
    int index;                         // in the sequence
    Ptr<ToolModel> model;
    std::vector<String> coordinates;
    std::vector<double> deviations;    // of constant errors of its readings, for the prior; a coordinate
    Matx44d nominal_T_base;
};

//! What was found of a tool in a frame.
struct OffsetMeasurement
{
    int tool, block;                   // the block is that of the hand-eye correction
    double time;                       // of the image [s]
    std::vector<PartMatch> inliers;
};

/** Least squares for the offset, and all that is unknown beside it: per tool constant errors of the joints and a correction of the
hand-eye calibration for each block of time. Neighbouring blocks are tied together, by a robust tie that a move of the camera breaks. */
class TimeOffsetFit
{
public:
    TimeOffsetFit(const Sequence& sequence, const CameraModel& camera, const std::vector<OffsetTool>& tools, int blocks);

    //! From scratch: at an offset, the hand-eye calibration as it is.
    void start(double offset);

    /** @param measurements of all tools
    @param scale distance from which on points count less [pixel at 720 px width]
    @param iterations of Gauss-Newton
    @param reach the offset stays this near to that of start() [s]
    @return false if too few points are left or they determine nothing */
    bool run(const std::vector<OffsetMeasurement>& measurements, double scale, int iterations, double reach);

    double offset() const { return offset_; }
    double deviation() const { return deviation_; }     // of the offset, after run() [s]

    //! The tool as it should be in the image of a time; false without a reading.
    bool view(int tool, int block, double time, ToolView& view) const;

    //! Distance of a match from where the fit has its part [pixel]; `view` is that of its tool.
    double residual(int tool, const ToolView& view, const PartMatch& match) const;

private:
    struct Correction { Matx33d R; Vec3d t; };    // viewPoint = R * (nominalPoint - pivot) + pivot + t

    struct Normals;                               // the normal equations
    bool keypoints(int tool, double time, Mat& basePoints, Mat* jacobian) const;
    bool motion(int tool, double time, Mat& basePoints, Mat& jacobian, Mat& velocities) const;
    void addMeasurement(const OffsetMeasurement& m, double limit2, Normals& normals) const;
    void addPriors(double reach, Normals& normals) const;
    void addTie(int tool, int block, Normals& normals) const;
    void apply(const double* dx, double reach);
    int correctionColumn(int tool, int block) const { return correctionColumns_[tool] + 6 * block; }

    const Sequence& sequence_;
    CameraModel camera_;
    double pixelScale_;
    const std::vector<OffsetTool>& tools_;
    int blocks_, unknowns_;
    std::vector<int> jointColumns_, correctionColumns_;   // a tool
    std::vector<Vec3d> pivots_;
    double offset_, startOffset_, deviation_;
    std::vector<std::vector<double> > jointOffsets_;
    std::vector<std::vector<Correction> > corrections_;   // a tool, a block
};

}} // namespace cv::surgtrack

#endif
