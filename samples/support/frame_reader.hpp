// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SAMPLES_SUPPORT_FRAME_READER_HPP
#define OPENCV_SURGTRACK_SAMPLES_SUPPORT_FRAME_READER_HPP

#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include "opencv2/videoio.hpp"
#include "opencv2/surgtrack.hpp"
#include "common.hpp"

namespace common {

//! A video whose frames all have the size the sequence says; decoded in a thread of its own, two frames ahead.
class FrameReader
{
public:
    FrameReader(const cv::surgtrack::Sequence& sequence, int start, bool right = false)
        : filename_(right ? sequence.rightVideo() : sequence.leftVideo()),
          size_((right ? sequence.rightCamera() : sequence.leftCamera()).imageSize()), next_(0), decoded_(0), taken_(0), ended_(false), stop_(false)
    {
        if (!capture_.open(filename_))
            fail(filename_ + ": can't be read as a video");
        count_ = (int)capture_.get(cv::CAP_PROP_FRAME_COUNT);
        while (next_ < start && capture_.grab())   // seeking is not exact in every container
            next_++;
        if (next_ < start)
            fail(cv::format("%s: has %d frames, none at --start=%d", filename_.c_str(), next_, start));
        thread_ = std::thread(&FrameReader::decode, this);
    }

    ~FrameReader()
    {
        {
            std::lock_guard<std::mutex> lock(mutex_);
            stop_ = true;
        }
        changed_.notify_all();
        thread_.join();
    }

    //! image may come with the memory of a frame that is done with.
    bool read(cv::Mat& image)
    {
        {
            std::unique_lock<std::mutex> lock(mutex_);
            while (decoded_ == taken_ && !ended_)
                changed_.wait(lock);
            if (decoded_ == taken_ && error_)
                std::rethrow_exception(error_);
            if (decoded_ == taken_)
                return false;
            cv::swap(image, frames_[taken_ % LOOK_AHEAD]);
            taken_++;
        }
        changed_.notify_all();
        if (image.size() != size_)
            fail(cv::format("%s: frame %d has %dx%d pixels, expected %dx%d as in sequence.yaml", filename_.c_str(), next_, image.cols, image.rows,
                            size_.width, size_.height));
        next_++;
        return true;
    }

    //! Throws if the video should have gone on.
    void checkEnd(const cv::surgtrack::Sequence& sequence) const
    {
        if (next_ + 2 < count_)   // the count of some containers is rounded
            fail(cv::format("%s: ends after %d frames, expected %d as its header says", filename_.c_str(), next_, count_));
        if (next_ < sequence.groundTruthEnd())
            fail(cv::format("%s: ends after %d frames, expected %d as in the ground truth", filename_.c_str(), next_, sequence.groundTruthEnd()));
    }

    //! Throws that the video should have gone on as another one did.
    CV_NORETURN void failEnd(const FrameReader& other) const
    {
        fail(cv::format("%s: ends after %d frames, expected more, as in %s", filename_.c_str(), next_, other.filename_.c_str()));
    }

    int count() const { return count_; }

private:
    enum { LOOK_AHEAD = 2 };

    void decode()
    {
        std::unique_lock<std::mutex> lock(mutex_);
        while (!ended_)
        {
            while (!stop_ && decoded_ - taken_ == LOOK_AHEAD)
                changed_.wait(lock);
            if (stop_)
                return;
            cv::Mat& frame = frames_[decoded_ % LOOK_AHEAD];
            bool found = false;
            lock.unlock();
            try
            {
                found = capture_.read(frame) && !frame.empty();
            }
            catch (...)
            {
                error_ = std::current_exception();
            }
            lock.lock();
            decoded_ += found;
            ended_ = !found;
            changed_.notify_all();
        }
    }

    cv::VideoCapture capture_;
    cv::String filename_;
    cv::Size size_;
    int next_, count_;
    cv::Mat frames_[LOOK_AHEAD];
    int decoded_, taken_;   // since the start
    bool ended_, stop_;
    std::exception_ptr error_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::thread thread_;
};

//! The frames of one eye, or of both side by side.
class EyesReader
{
public:
    EyesReader(const cv::surgtrack::Sequence& sequence, int start, bool stereo) : sequence_(sequence), left_(sequence, start)
    {
        if (stereo)
            right_ = cv::makePtr<FrameReader>(sequence, start, true);
    }

    //! right is left alone without stereo. Throws at the end of one video if it should have gone on, or the other one does.
    bool read(cv::Mat& left, cv::Mat& right)
    {
        const bool leftFound = left_.read(left), rightFound = right_ ? right_->read(right) : leftFound;
        if (!leftFound)
            left_.checkEnd(sequence_);
        if (right_ && !rightFound)
            right_->checkEnd(sequence_);
        if (leftFound != rightFound)
            (leftFound ? *right_ : left_).failEnd(leftFound ? left_ : *right_);
        return leftFound;
    }

    int count() const { return left_.count(); }

private:
    const cv::surgtrack::Sequence& sequence_;
    FrameReader left_;
    cv::Ptr<FrameReader> right_;
};

} // namespace common

#endif
