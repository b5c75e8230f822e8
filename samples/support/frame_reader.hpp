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
#include "video.hpp"

namespace common {

//! The images of one eye, out of a video whose frames all have the size the sequence says; decoded in a thread of its own, two frames ahead.
class FrameReader
{
public:
    FrameReader(const cv::surgtrack::Sequence& sequence, int start, bool right = false)
        : sequence_(sequence), eye_(right), plain_(sequence.layout() == cv::surgtrack::LAYOUT_SEPARATE && sequence.imagesPerFrame() == 1),
          filename_(right ? sequence.rightVideo() : sequence.leftVideo()), size_(sequence.frameSize()), next_(0), rate_(0), shift_(0), isShifted_(false),
          decoded_(0), taken_(0), ended_(false), stop_(false)
    {
        if (!capture_.open(filename_))
            fail(filename_ + ": can't be read as a video" + (isPattern() ? ", expected images numbered from 0 or 1 on" : ""));
        asRecorded(capture_);
        noteTurned(capture_, filename_);
        if (!sequence.hasFrameTimes())
        {
            warnOfRate(capture_, filename_, sequence.fps());
            rate_ = capture_.get(cv::CAP_PROP_FPS) > 0 ? capture_.get(cv::CAP_PROP_FPS) : sequence.fps();
        }
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

    //! The next frame's image, the first one if it holds two. It may come with the memory of a frame that is done with.
    bool read(cv::Mat& image)
    {
        if (!readFrame(plain_ ? image : frame_))
            return false;
        if (!plain_)
            take(image, eye_, 0);
        return true;
    }

    //! Another image of the frame that was read, of a sequence that has several in one. See Sequence::eyeImage().
    void take(cv::Mat& image, int eye, int field) const { sequence_.eyeImage(frame_, image, eye, field); }

    //! Throws if the video should have gone on.
    void checkEnd(const cv::surgtrack::Sequence& sequence) const
    {
        if (next_ < count_ && isPattern())
            fail(cv::format("%s: ends after %d images, expected %d: is one missing?", filename_.c_str(), next_, count_));
        if (next_ + 2 < count_ && isCut(filename_))   // the count of some containers is rounded
            fail(cv::format("%s: ends after %d frames, expected %d as its header says", filename_.c_str(), next_, count_));
        if (next_ + 2 < count_)
            std::fprintf(stderr, "note: %s: has %d frames, its header counts %d, as after cutting without coding anew\n", filename_.c_str(), next_, count_);
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
    //! Of images, one a file.
    bool isPattern() const { return filename_.find('%') != cv::String::npos; }

    enum { LOOK_AHEAD = 2 };

    bool readFrame(cv::Mat& image)
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
            checkStamp(stamps_[taken_ % LOOK_AHEAD]);
            taken_++;
        }
        changed_.notify_all();
        if (image.size() != size_)
            fail(cv::format("%s: frame %d has %dx%d pixels, expected %dx%d as in sequence.yaml%s", filename_.c_str(), next_, image.cols, image.rows,
                            size_.width, size_.height, sequence_.layout() ? " by image_width, image_height and layout"
                            : image.cols == size_.height && image.rows == size_.width ? ": is it turned by 90 degrees?" : ""));
        next_++;
        return true;
    }

    //! Says so, once, if the video's own time stamps are not those of a constant rate. @param stamp [s]
    void checkStamp(double stamp)
    {
        if (rate_ <= 0 || stamp <= 0)   // not said
            return;
        const double late = stamp - next_ / rate_;
        if (!isShifted_)
            shift_ = late;    // a clip that was cut begins later
        isShifted_ = true;
        if (std::abs(late - shift_) < 1.5 / rate_)
            return;
        std::fprintf(stderr, "warning: %s: the time stamps are not k / fps: frame %d is %.3f s off; a variable frame rate, or frames that were left out? "
                     "frames.csv with the columns frame,stamp says when each was taken\n", filename_.c_str(), next_, late - shift_);
        rate_ = 0;
    }

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
                stamps_[decoded_ % LOOK_AHEAD] = 1e-3 * capture_.get(cv::CAP_PROP_POS_MSEC);
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

    const cv::surgtrack::Sequence& sequence_;
    const int eye_;
    const bool plain_;      // frames are the eye's images
    cv::Mat frame_;         // the last one, if not
    cv::VideoCapture capture_;
    cv::String filename_;
    cv::Size size_;
    int next_, count_;
    double rate_, shift_;   // of the time stamps: frames/s, 0 = they are not looked at; [s]
    bool isShifted_;
    cv::Mat frames_[LOOK_AHEAD];
    double stamps_[LOOK_AHEAD];
    int decoded_, taken_;   // since the start
    bool ended_, stop_;
    std::exception_ptr error_;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::thread thread_;
};

//! The images of one eye, or of both.
class EyesReader
{
public:
    EyesReader(const cv::surgtrack::Sequence& sequence, int start, bool stereo)
        : sequence_(sequence), left_(sequence, start), together_(stereo && sequence.layout() != cv::surgtrack::LAYOUT_SEPARATE)
    {
        if (stereo && !together_)
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
        if (leftFound && together_)
            left_.take(right, 1, 0);
        return leftFound;
    }

    //! The second field of the frame that was read. @return false if frames have none
    bool readSecond(cv::Mat& left, cv::Mat& right) const
    {
        if (sequence_.imagesPerFrame() < 2)
            return false;
        left_.take(left, 0, 1);
        if (right_ || together_)
            (right_ ? *right_ : left_).take(right, 1, 1);
        return true;
    }

    int count() const { return left_.count(); }

private:
    const cv::surgtrack::Sequence& sequence_;
    FrameReader left_;
    const bool together_;   // in one file
    cv::Ptr<FrameReader> right_;
};

/** Says so, once, if the images of a sequence are interlaced and its description does not tell. */
class FieldsNote
{
public:
    explicit FieldsNote(const cv::surgtrack::Sequence& sequence) : sequence_(sequence), combed_(0) {}

    void look(const cv::Mat& image)
    {
        const int sure = 3;   // images
        if (sequence_.imagesPerFrame() > 1 || combed_ >= sure || !cv::surgtrack::isInterlaced(image) || ++combed_ < sure)
            return;
        std::fprintf(stderr, "note: %s: is interlaced, only one field of each frame is used: write fields: top_first (or bottom_first, as DV has) into "
                     "sequence.yaml for both\n", sequence_.leftVideo().c_str());
    }

private:
    const cv::surgtrack::Sequence& sequence_;
    int combed_;
};

} // namespace common

#endif
