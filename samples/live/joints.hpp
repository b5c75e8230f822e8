// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Joint readings that come by UDP, and the clock all live samples share.

#ifndef OPENCV_SURGTRACK_SAMPLES_LIVE_JOINTS_HPP
#define OPENCV_SURGTRACK_SAMPLES_LIVE_JOINTS_HPP

#include <atomic>
#include <cfloat>
#include <chrono>
#include <cmath>
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
    //! Messages with a joint reading, without one; readings that brought nothing, and with stamps of another clock; messages beyond `most`.
    struct Counts { int readings, others, malformed, late, strange, flood; };

    /** @param listen, from see UdpReceiver
    @param speed seconds of the robot's clock a second of this one; not 1 when a recording is played faster */
    JointStream(const std::vector<JointPort>& ports, const std::string& listen, const std::string& from, const std::vector<std::string>& tools,
                const std::vector<std::vector<cv::String> >& coordinates, double speed)
        : ports_(ports), tools_(tools), speed_(speed), receiver_(numbers(ports), listen, from), counts_(), robotClocks_(tools.size()), second_(0), taken_(0),
          stop_(false)
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
            int port = 0, over = 0;
            while (!stop_)
            {
                if (!receiver_.receive(packet, port, 100))
                    continue;
                if (isWithin(packet.size()))
                    take(packet, ports_[port]);
                else if (++over % 100 == 0)   // a flood must not take the processor from the images
                    std::this_thread::sleep_for(std::chrono::milliseconds(1));
            }
        }
        catch (...)
        {
            std::lock_guard<std::mutex> lock(mutex_);
            error_ = std::current_exception();
        }
        changed_.notify_all();
    }

    //! Whether there is still room in this second for a message: a hundred robots have it.
    bool isWithin(size_t bytes)
    {
        const size_t most = 4000000, longest = 16384;
        const double time = now();
        if (time >= second_ + 1)
        {
            second_ = time;
            taken_ = 0;
        }
        taken_ += bytes;
        if (taken_ <= most && bytes <= longest)
            return true;
        std::lock_guard<std::mutex> lock(mutex_);
        counts_.flood++;
        return false;
    }

    //! Whatever is wrong with a message is counted, and the first time kept: a network brings anything.
    void take(const std::string& packet, const JointPort& port)
    {
        const double arrival = now();
        std::vector<cv::surgtrack::JointReading> readings;
        std::string complaint;
        try
        {
            cv::surgtrack::parseJointMessage(packet, readings);
        }
        catch (const cv::Exception& e)
        {
            complaint = e.err;
        }
        std::lock_guard<std::mutex> lock(mutex_);
        try
        {
            for (size_t i = 0; i < readings.size(); i++) takeReading(toolOf(readings[i], port), readings[i], arrival);
            if (complaint.empty()) (readings.empty() ? counts_.others : counts_.readings)++;
        }
        catch (const cv::Exception& e)
        {
            complaint = e.err;
        }
        counts_.malformed += !complaint.empty();
        if (complaint_.empty()) complaint_ = complaint;
        changed_.notify_all();
    }

    /** What a stamp says of the robot's clock, arrival less stamp, agrees with other readings, unless it is wrong. Of the clocks that are told
    of that is believed which most readings of the last second agree on; another one, as when the robot was restarted, needs twice as many. */
    void takeReading(int tool, const cv::surgtrack::JointReading& reading, double arrival)
    {
        const double early = 0.3, late = 2, memory = 1;    // [s]; a message may be held up, but comes before its stamp on another clock only
        const double following = 0.05;                     // of a delay that stays
        const double enough = 2.5, more = 2;
        const size_t mostClocks = 8, mostKept = 50;
        std::vector<RobotClock>& all = robotClocks_[tool];
        const double difference = arrival - reading.time / speed_;
        size_t at = all.size(), lightest = 0;
        for (size_t i = 0; i < all.size(); i++)
        {
            all[i].weight *= std::exp((all[i].last - arrival) / memory);
            all[i].last = arrival;
            if (difference >= all[i].difference - early && difference <= all[i].difference + late && at == all.size()) at = i;
            if (i > 1 && all[i].weight <= all[lightest].weight) lightest = i;
            else if (i == 1) lightest = 1;
        }
        if (at == all.size() && all.size() < mostClocks) all.push_back(RobotClock());
        else if (at == all.size()) all[at = lightest] = RobotClock();
        RobotClock& clock = all[at];
        clock.difference = clock.weight > 0 ? std::min(difference, clock.difference + following * (difference - clock.difference)) : difference;
        clock.last = arrival;
        clock.weight += 1;
        const bool known = all[0].believed;
        if (known && at == 0)
            return add(tool, reading, arrival);
        counts_.strange++;
        clock.kept.push_back(std::make_pair(reading, arrival));
        if (clock.kept.size() > mostKept) clock.kept.erase(clock.kept.begin());
        if (clock.weight < (known ? more * all[0].weight + enough : enough))
            return;
        std::swap(all[0], all[at]);
        all[at].believed = false;
        all[0].believed = true;
        buffers_[tool]->clear();
        clocks_[tool] = cv::surgtrack::ClockOffset::create();
        std::vector<std::pair<cv::surgtrack::JointReading, double> > kept;
        kept.swap(all[0].kept);
        counts_.strange -= (int)kept.size();
        for (size_t i = 0; i < kept.size(); i++) add(tool, kept[i].first, kept[i].second);
    }

    void add(int tool, const cv::surgtrack::JointReading& reading, double arrival)
    {
        counts_.late += !buffers_[tool]->add(reading);
        clocks_[tool]->add(reading.time / speed_, arrival);
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
        std::string shown = name.substr(0, 40);
        for (size_t i = 0; i < shown.size(); i++)
            if (shown[i] < ' ' || shown[i] > '~') shown[i] = '?';
        fail("joint message: tool '" + shown + "' is none of the tools of sequence.yaml");
    }

    struct RobotClock
    {
        RobotClock() : difference(0), last(0), weight(0), believed(false) {}
        double difference, last;    // arrival - stamp of the last reading, and when any came [s]
        double weight;              // readings of about the last second
        bool believed;              // the first of all is, or none
        std::vector<std::pair<cv::surgtrack::JointReading, double> > kept;    // with their arrivals, while it is not believed
    };

    const std::vector<JointPort> ports_;
    const std::vector<std::string> tools_;
    const double speed_;
    UdpReceiver receiver_;
    std::vector<cv::Ptr<cv::surgtrack::JointBuffer> > buffers_;
    std::vector<cv::Ptr<cv::surgtrack::ClockOffset> > clocks_;
    Counts counts_;
    std::vector<std::vector<RobotClock> > robotClocks_;    // a tool
    double second_;       // when the current one began
    size_t taken_;        // bytes in it
    std::string complaint_;
    std::exception_ptr error_;
    std::atomic<bool> stop_;
    mutable std::mutex mutex_;
    std::condition_variable changed_;
    std::thread thread_;
};

} // namespace common

#endif
