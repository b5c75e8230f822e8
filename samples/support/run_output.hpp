// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// What a run writes beside its poses: the overlay video and the times of its stages, and what it prints of these.

#ifndef OPENCV_SURGTRACK_SAMPLES_SUPPORT_RUN_OUTPUT_HPP
#define OPENCV_SURGTRACK_SAMPLES_SUPPORT_RUN_OUTPUT_HPP

#include <fstream>
#include "opencv2/videoio.hpp"
#include "opencv2/surgtrack.hpp"
#include "common.hpp"

namespace common {

//! The value that so much of the others are below; 0 without any.
inline double percentile(std::vector<double> values, double share)
{
    if (values.empty())
        return 0;
    std::sort(values.begin(), values.end());
    return values[std::min(values.size() - 1, (size_t)(share * values.size()))];
}

//! The overlay video.
class Overlay
{
public:
    Overlay(const cv::String& filename, double fps, cv::Size size) : filename_(filename), frames_(0)
    {
        if (!writer_.open(filename, cv::VideoWriter::fourcc('a', 'v', 'c', '1'), fps, size))
            writer_.open(filename, cv::VideoWriter::fourcc('m', 'p', '4', 'v'), fps, size);
        if (!writer_.isOpened())
            fail(filename + ": can't be written as a video, expected a file in a folder that exists, such as overlay.mp4");
    }

    void write(const cv::Mat& image)
    {
        writer_.write(image);
        frames_++;
    }

    //! Throws if the file does not hold what was written, as on a full disk.
    void finish()
    {
        writer_.release();
        cv::VideoCapture check(filename_);
        if (frames_ > 0 && (!check.isOpened() || check.get(cv::CAP_PROP_FRAME_COUNT) < frames_))
            fail(cv::format("%s: not all of its %d frames were written, is the disk full?", filename_.c_str(), frames_));
    }

private:
    cv::VideoWriter writer_;
    cv::String filename_;
    int frames_;
};

//! The time of each stage in each frame, to be written beside the poses, which are the same on every machine.
class TimingsWriter
{
public:
    explicit TimingsWriter(const cv::String& filename) : filename_(filename), file_(filename.c_str()), stages_(0) { check(); }

    void write(int frame, double time, const std::vector<cv::surgtrack::StageTime>& stages)
    {
        if (stages_ == 0)
        {
            file_ << "frame,time";
            for (size_t i = 0; i < stages.size(); i++)
                file_ << ',' << stages[i].name;
            file_ << '\n';
        }
        stages_ = stages.size();
        file_ << frame << ',' << time;
        for (size_t i = 0; i < stages.size(); i++)
            file_ << ',' << stages[i].last;
        file_ << std::endl;
        check();
    }

private:
    void check() const
    {
        if (!file_)
            fail(filename_ + ": can't be written");
    }

    cv::String filename_;
    std::ofstream file_;
    size_t stages_;
};

} // namespace common

#endif
