// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_TRACK_STAGE_TIMES_HPP
#define OPENCV_SURGTRACK_SRC_TRACK_STAGE_TIMES_HPP

#include "precomp.hpp"
#include "opencv2/surgtrack/tool_tracker.hpp"

namespace cv { namespace surgtrack {

enum Stage { RENDER, IMAGE, MATCH, VERIFY, FILTER, CONTOUR, TOTAL, STAGES };

// What the stages of the current frame took, and the statistics of the frames before.
class StageTimes
{
public:
    StageTimes() { reset(); }

    void reset()
    {
        frames_ = 0;
        std::fill(last_, last_ + STAGES, 0.);
    }

    void beginFrame() { std::fill(current_, current_ + STAGES, 0.); }
    void add(Stage stage, double seconds) { current_[stage] += seconds; }

    void endFrame()
    {
        for (int i = 0; i < STAGES; i++)
        {
            const double t = last_[i] = current_[i];
            sum_[i] = frames_ ? sum_[i] + t : t;
            min_[i] = frames_ ? std::min(min_[i], t) : t;
            max_[i] = frames_ ? std::max(max_[i], t) : t;
        }
        frames_++;
    }

    std::vector<StageTime> get() const
    {
        static const char* const names[] = {"render", "image", "match", "verify", "filter", "contour", "total"};
        std::vector<StageTime> result(STAGES);
        for (int i = 0; i < STAGES; i++)
        {
            result[i].name = names[i];
            if (frames_ == 0) continue;
            result[i].calls = frames_;
            result[i].last = last_[i];
            result[i].mean = sum_[i] / frames_;
            result[i].min = min_[i];
            result[i].max = max_[i];
        }
        return result;
    }

private:
    int frames_;
    double current_[STAGES], last_[STAGES], sum_[STAGES], min_[STAGES], max_[STAGES];   // [s]
};

// Adds the time of a scope to its stage.
class StageTimer
{
public:
    StageTimer(StageTimes& times, Stage stage) : times_(times), stage_(stage), start_(getTickCount()) {}
    ~StageTimer() { times_.add(stage_, double(getTickCount() - start_) / getTickFrequency()); }

private:
    StageTimes& times_;
    Stage stage_;
    int64 start_;
};

}} // namespace cv::surgtrack

#endif
