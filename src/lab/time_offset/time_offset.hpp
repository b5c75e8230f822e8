// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_LAB_TIME_OFFSET_TIME_OFFSET_HPP
#define OPENCV_SURGTRACK_SRC_LAB_TIME_OFFSET_TIME_OFFSET_HPP

#include <map>
#include "opencv2/surgtrack/part_finder.hpp"
#include "opencv2/surgtrack/time_offset.hpp"
#include "base/geometry.hpp"
#include "lab/time_offset/time_offset_fit.hpp"
#include "model/camera.hpp"

namespace cv { namespace surgtrack {

const double chanceSimilarity = 0.4;          // tissue has it anywhere
const int luckyFrames = 4;                    // that many without any support are added to a mean, so that a short overlap is not believed too easily
const int minOffsetFrames = 6;                // fewer tell nothing

// What was found of a tool in a frame with the readings of a certain time.
struct OffsetDetection
{
    int tool, cell;          // offset = expected + cell * step
    size_t frame;            // index of the frame kept
    double score;
    std::vector<PartMatch> inliers;
};

struct OffsetCandidate
{
    int cell;
    double coarse, offset, deviation, support;
    int frames;
    bool settled;            // not at the end of the reach of its refinement
};

// time_offset_search.cpp: frames and the coarse search; time_offset.cpp: refinement and verdict
class TimeOffsetEstimator
{
public:
    TimeOffsetEstimator(const Sequence& sequence, const TimeOffsetParams& params);
    bool run(TimeOffset& result);

private:
    void readFrames();
    bool drawn(int cell, std::vector<PartDrawing>& drawings);
    void searchAll();
    double coarseScore(int cell) const;
    std::vector<int> peaks() const;
    double overlapOf(int cell) const { return frameCounts_[cell + reach_] * stride_ / sequence_.fps(); }
    bool refine(OffsetCandidate& candidate, bool thorough);
    bool measureAgain(const TimeOffsetFit& fit, PartFinder& finder, std::vector<OffsetMeasurement>& measurements);
    void support(const TimeOffsetFit& fit, const std::vector<OffsetMeasurement>& measurements, OffsetCandidate& candidate) const;
    bool choose(OffsetCandidate& best, double& second);
    int blockOf(size_t frame) const { return int(frame * blocks_ / frames_.size()); }

    const Sequence& sequence_;
    TimeOffsetParams params_;
    Ptr<PartFinder> coarse_, fine_;  // coarse: with fewer features
    CameraModel camera_;             // of the reduced images
    std::vector<OffsetTool> tools_;
    Ptr<GeometricContextVerifier> verifier_;

    double step_;                    // of cells [s]
    int stride_;                     // frames of the video from one that is kept to the next
    int reach_;                      // cells to either side of the expected offset
    std::vector<Mat> frames_;
    std::vector<double> times_;
    int blocks_;
    std::map<int, std::vector<PartDrawing> > drawings_;   // by cell of their readings' time; a tool
    std::vector<OffsetDetection> detections_;
    std::vector<double> sums_;       // of scores, a cell of the offset
    std::vector<int> counts_;        // of frames and tools with readings, likewise
    std::vector<int> frameCounts_;
};

}} // namespace cv::surgtrack

#endif
