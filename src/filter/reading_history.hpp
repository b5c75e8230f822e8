// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_FILTER_READING_HISTORY_HPP
#define OPENCV_SURGTRACK_SRC_FILTER_READING_HISTORY_HPP

#include <vector>
#include <cstddef>

namespace cv { namespace surgtrack {

//! The last readings of a tool, for those of a time between and a little after.
class ReadingHistory
{
public:
    explicit ReadingHistory(size_t coordinates) : n_(coordinates), last_(0), count_(0), values_(frames * coordinates), ages_(frames) {}

    //! @param seconds since the last; 0, or next to it: instead of it
    void add(const double* readings, double seconds);
    void clear() { count_ = 0; }
    //! Readings at a time from the newest on, less the newest, and their rates. @param seconds negative: earlier
    void at(double seconds, double* difference, double* rate) const;

private:
    static const int frames = 8;
    static constexpr double shortestGap = 1e-4;   // [s]; of less no rate can be told
    static constexpr double longestGap = 0.5;   // [s]; beyond, nothing is known of what was between

    static constexpr double fastest = 15;     // [rad/s or m/s]; twice what instruments' wrists do: more is another recording, or a glitch

    const double* of(int back) const { return &values_[((last_ + frames - back) % frames) * n_]; }

    size_t n_;
    int last_, count_;
    std::vector<double> values_, ages_;   // ages_: seconds to the one before
};

}} // namespace cv::surgtrack

#endif
