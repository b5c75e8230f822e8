// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_FILTER_READING_HISTORY_HPP
#define OPENCV_SURGTRACK_SRC_FILTER_READING_HISTORY_HPP

#include "opencv2/surgtrack/tool_model.hpp"

namespace cv { namespace surgtrack {

//! The last readings of a tool, for those of a time between and a little after.
class ReadingHistory
{
public:
    explicit ReadingHistory(const ToolModel& model);

    //! @param seconds since the last; 0, or next to it: instead of it
    void add(const double* readings, double seconds);
    void clear() { count_ = 0; }
    //! Readings at a time from the newest on, less the newest, and their rates. @param seconds negative: earlier
    void at(double seconds, double* difference, double* rate) const;

private:
    static const int frames = 8;
    static constexpr double shortestGap = 1e-4;   // [s]; of less no rate can be told
    static constexpr double longestGap = 0.5;   // [s]; beyond, nothing is known of what was between


    const double* of(int back) const { return &values_[((last_ + frames - back) % frames) * n_]; }

    size_t n_;
    int last_, count_;
    std::vector<double> values_, ages_;   // ages_: seconds to the one before
    std::vector<double> fastest_;         // of a coordinate: more is another recording, or a glitch [rad/s or m/s]
};

}} // namespace cv::surgtrack

#endif
