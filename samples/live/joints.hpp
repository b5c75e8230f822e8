// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Joint readings that come by UDP, and the clock all live samples share.

#ifndef OPENCV_SURGTRACK_SAMPLES_LIVE_JOINTS_HPP
#define OPENCV_SURGTRACK_SAMPLES_LIVE_JOINTS_HPP

#include <atomic>
#include <cfloat>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <exception>
#include <mutex>
#include <thread>
#include "opencv2/surgtrack.hpp"
#include "opencv2/surgtrack/lab.hpp"
#include "udp.hpp"

namespace common {

//! This machine's clock, which nobody sets [s].
inline double now()
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

inline std::chrono::steady_clock::time_point timePoint(double seconds)
{
    typedef std::chrono::steady_clock Clock;
    return Clock::time_point(std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds)));
}

struct JointPort
{
    int port;
    std::string tool;    // whose readings come there, if they do not say so themselves; may be empty
};

//! The readings of all tools, taken in by a thread of its own.
class JointStream
{
public:
    struct Counts { int readings, others, malformed, late; };    // messages with a joint reading, without one; readings that brought nothing

    //! speed: seconds of the robot's clock a second of this one; not 1 when a recording is played faster
    JointStream(const std::vector<JointPort>& ports, const std::vector<std::string>& tools, const std::vector<std::vector<cv::String> >& coordinates,
                double speed)
        : ports_(ports), tools_(tools), speed_(speed), receiver_(numbers(ports)), counts_(), stop_(false)
    {
        for (size_t i = 0; i < tools.size(); i++)
        {
            buffers_.push_back(cv::surgtrack::JointBuffer::create(coordinates[i]));
            clocks_.push_back(cv::surgtrack::ClockOffset::create());
        }
        thread_ = std::thread(&JointStream::run, this);
    }
    ~JointStream()
    {
        stop_ = true;
        thread_.join();
    }

    //! Waits until all tools have all their joints. Returns the first tool that has not, or -1.
    int waitForAll(double seconds, const volatile std::sig_atomic_t& interrupted)
    {
        const double end = now() + seconds;
        std::unique_lock<std::mutex> lock(mutex_);
        for (;;)
        {
            if (error_)
                std::rethrow_exception(error_);
            int missing = -1;
            for (size_t i = 0; i < buffers_.size() && missing < 0; i++)
                if (buffers_[i]->newest() == -DBL_MAX) missing = (int)i;
            if (missing < 0 || interrupted || now() >= end)
                return missing;
            changed_.wait_for(lock, std::chrono::milliseconds(100));
        }
    }

    /** Joints of all tools, each at a time of its own clock. Waits for readings that are still to come, up to so many seconds.
    Returns a JointsState. */
    int at(const std::vector<double>& times, double wait, std::vector<std::vector<double> >& joints)
    {
        const double end = now() + wait;
        joints.resize(buffers_.size());
        std::unique_lock<std::mutex> lock(mutex_);
        for (size_t tool = 0; tool < buffers_.size();)
        {
            if (error_)
                std::rethrow_exception(error_);
            const int state = buffers_[tool]->at(times[tool], joints[tool]);
            if (state == cv::surgtrack::JOINTS_FOUND)
                tool++;
            else if (state != cv::surgtrack::JOINTS_TOO_NEW || changed_.wait_until(lock, timePoint(end)) == std::cv_status::timeout)
                return state;
        }
        return cv::surgtrack::JOINTS_FOUND;
    }

    //! What a tool's clock shows at a moment of this one.
    double robotTime(int tool, double local) const
    {
        std::lock_guard<std::mutex> lock(mutex_);
        return (local - clocks_[tool]->offset()) * speed_;
    }

    //! When a tool's clock shows a time.
    double localTime(int tool, double robot) const
    {
        std::lock_guard<std::mutex> lock(mutex_);
        return robot / speed_ + clocks_[tool]->offset();
    }

    Counts counts() const
    {
        std::lock_guard<std::mutex> lock(mutex_);
        return counts_;
    }

    //! Why the first malformed message was; empty if none was.
    std::string complaint() const
    {
        std::lock_guard<std::mutex> lock(mutex_);
        return complaint_;
    }

private:
    static std::vector<int> numbers(const std::vector<JointPort>& ports)
    {
        std::vector<int> result;
        for (size_t i = 0; i < ports.size(); i++) result.push_back(ports[i].port);
        return result;
    }

    void run()
    {
        try
        {
            std::string packet;
            int port = 0;
            while (!stop_)
                if (receiver_.receive(packet, port, 100)) take(packet, ports_[port]);
        }
        catch (...)
        {
            std::lock_guard<std::mutex> lock(mutex_);
            error_ = std::current_exception();
        }
        changed_.notify_all();
    }

    //! Whatever is wrong with a message is counted, and the first time kept: a network brings anything.
    void take(const std::string& packet, const JointPort& port)
    {
        const double arrival = now();
        std::vector<cv::surgtrack::JointReading> readings;
        std::lock_guard<std::mutex> lock(mutex_);
        try
        {
            cv::surgtrack::parseJointMessage(packet, readings);
            for (size_t i = 0; i < readings.size(); i++)
            {
                const int tool = toolOf(readings[i], port);
                counts_.late += !buffers_[tool]->add(readings[i]);
                clocks_[tool]->add(readings[i].time / speed_, arrival);
            }
            (readings.empty() ? counts_.others : counts_.readings)++;
        }
        catch (const cv::Exception& e)
        {
            counts_.malformed++;
            if (complaint_.empty()) complaint_ = e.err;
        }
        changed_.notify_all();
    }

    int toolOf(const cv::surgtrack::JointReading& reading, const JointPort& port) const
    {
        const std::string name = reading.tool.empty() ? port.tool : reading.tool;
        if (name.empty() && tools_.size() == 1)
            return 0;
        if (name.empty())
            fail(cv::format("joint message on port %d: does not say of which tool, expected --joints=TOOL:%d", port.port, port.port));
        for (size_t i = 0; i < tools_.size(); i++)
            if (tools_[i] == name) return (int)i;
        fail("joint message: tool '" + name + "' is none of the tools of sequence.yaml");
    }

    const std::vector<JointPort> ports_;
    const std::vector<std::string> tools_;
    const double speed_;
    UdpReceiver receiver_;
    std::vector<cv::Ptr<cv::surgtrack::JointBuffer> > buffers_;
    std::vector<cv::Ptr<cv::surgtrack::ClockOffset> > clocks_;
    Counts counts_;
    std::string complaint_;
    std::exception_ptr error_;
    std::atomic<bool> stop_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::thread thread_;
};

} // namespace common

#endif
