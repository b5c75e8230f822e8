// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Images as they come: from a camera, or from a video that is played at its pace. Only the newest is kept.

#ifndef OPENCV_SURGTRACK_SAMPLES_LIVE_IMAGES_HPP
#define OPENCV_SURGTRACK_SAMPLES_LIVE_IMAGES_HPP

#include "opencv2/videoio.hpp"
#include "joints.hpp"

namespace common {

struct LiveImage
{
    int number;          // from 0
    double arrival;      // when it was there, on this machine's clock [s]
    cv::Mat left, right;
};

//! Images of one eye or two, read by a thread of its own into a place for one: who takes them is never behind by more than that.
class LiveImages
{
public:
    /** @param sources a camera's number, or what else VideoCapture opens; two for both eyes, one if they come in one image
    @param setup says which size images have, and how the eyes lie in them
    @param stereo both eyes are wanted
    @param live they come when they come; else they are played at a pace */
    LiveImages(const std::vector<std::string>& sources, const cv::Ptr<cv::surgtrack::Sequence>& setup, bool stereo, bool live, double fps)
        : sources_(sources), setup_(setup), stereo_(stereo), captures_(sources.size()), live_(live), fps_(fps), full_(false), ended_(false), stop_(false)
    {
        for (size_t i = 0; i < sources.size(); i++) open((int)i);
    }
    ~LiveImages() { stop(); }

    //! Image k of a video comes at start + k / fps, on this machine's clock.
    void start(double start, int frames)
    {
        thread_ = std::thread(&LiveImages::run, this, start, frames);
    }

    //! No further image is read; the one that is there can still be taken.
    void stop()
    {
        {
            std::lock_guard<std::mutex> lock(mutex_);
            stop_ = true;
        }
        changed_.notify_all();
        if (thread_.joinable()) thread_.join();
    }

    /** The newest image, which may come with the memory of one that is done with. Waits up to 0.1 s for it.
    @return whether there is one
    @throws what went wrong in the thread */
    bool take(LiveImage& image)
    {
        std::unique_lock<std::mutex> lock(mutex_);
        changed_.wait_for(lock, std::chrono::milliseconds(100), [this] { return full_ || ended_; });
        if (error_)
            std::rethrow_exception(error_);
        if (!full_)
            return false;
        swap(image, slot_);
        full_ = false;
        return true;
    }

    //! Whether no image is there, nor will be.
    bool ended() const
    {
        std::lock_guard<std::mutex> lock(mutex_);
        return ended_ && !full_ && !error_;
    }

private:
    static void swap(LiveImage& a, LiveImage& b)
    {
        std::swap(a.number, b.number);
        std::swap(a.arrival, b.arrival);
        cv::swap(a.left, b.left);
        cv::swap(a.right, b.right);
    }

    void open(int eye)
    {
        const std::string& source = sources_[eye];
        const bool isNumber = live_ && source.find_first_not_of("0123456789") == std::string::npos && source.size() < 6;
        const bool opened = isNumber ? captures_[eye].open(std::atoi(source.c_str())) : captures_[eye].open(source);
        if (!opened)
            fail(isNumber ? "camera " + source + ": can't be opened; is it there, and was OpenCV built with support for cameras?"
                          : source + ": can't be read as a video");
        if (!isNumber)
            return;
        const cv::Size size = setup_->frameSize();    // a wish: what comes is checked
        captures_[eye].set(cv::CAP_PROP_FRAME_WIDTH, size.width);
        captures_[eye].set(cv::CAP_PROP_FRAME_HEIGHT, size.height);
        captures_[eye].set(cv::CAP_PROP_FPS, fps_);
        captures_[eye].set(cv::CAP_PROP_BUFFERSIZE, 1);     // the driver must not queue what is too old here
    }

    //! Both eyes are grabbed before one is decoded, so that they are of the same moment.
    bool read(LiveImage& image, double& arrival)
    {
        for (size_t i = 0; i < captures_.size(); i++)
            if (!captures_[i].grab()) return false;
        arrival = now();
        for (size_t i = 0; i < captures_.size(); i++)
        {
            cv::Mat& eye = i == 0 ? image.left : image.right;
            cv::Mat& frame = setup_->frameSize() == setup_->leftCamera().imageSize() && setup_->imagesPerFrame() == 1 ? eye : frame_;
            if (!captures_[i].retrieve(frame) || frame.empty())
                return false;
            const cv::Size size = setup_->frameSize();
            if (frame.size() != size)
                fail(cv::format("%s: image %d has %dx%d pixels, expected %dx%d as in sequence.yaml", sources_[i].c_str(), image.number, frame.cols,
                                frame.rows, size.width, size.height));
            if (&frame == &eye)
                continue;
            setup_->eyeImage(frame, eye, (int)i);
            if (stereo_ && captures_.size() == 1)
                setup_->eyeImage(frame, image.right, 1);
        }
        return true;
    }

    //! Whether to go on.
    bool sleepUntil(double time)
    {
        std::unique_lock<std::mutex> lock(mutex_);
        while (!stop_ && now() < time) changed_.wait_until(lock, timePoint(time));
        return !stop_;
    }

    void run(double start, int frames)
    {
        LiveImage image;
        try
        {
            for (int number = 0; (frames == 0 || number < frames) && sleepUntil(0); number++)
            {
                image.number = number;
                if (!read(image, image.arrival) || (!live_ && !sleepUntil(start + number / fps_)))
                    break;
                std::lock_guard<std::mutex> lock(mutex_);
                if (!live_) image.arrival = now();
                swap(image, slot_);
                full_ = true;
                changed_.notify_all();
            }
        }
        catch (...)
        {
            std::lock_guard<std::mutex> lock(mutex_);
            error_ = std::current_exception();
        }
        std::lock_guard<std::mutex> lock(mutex_);
        ended_ = true;
        changed_.notify_all();
    }

    const std::vector<std::string> sources_;
    const cv::Ptr<cv::surgtrack::Sequence> setup_;
    const bool stereo_;
    cv::Mat frame_;    // of several images
    std::vector<cv::VideoCapture> captures_;
    const bool live_;
    const double fps_;
    LiveImage slot_;
    bool full_, ended_, stop_;
    std::exception_ptr error_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::thread thread_;
};

} // namespace common

#endif
