// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include <cfloat>
#include <deque>
#include "files/joint_names.hpp"
#include "lab/live/reading_bounds.hpp"
#include "opencv2/surgtrack/live.hpp"

namespace cv { namespace surgtrack {

namespace {

const size_t maxReadings = 4096;     // of a coordinate
const int restartAfter = 50;         // readings in succession that are too old or too new

bool isFinite(double value) { return !cvIsNaN(value) && !cvIsInf(value); }

struct Sample
{
    double time, value;
};

bool isEarlier(const Sample& sample, double time) { return sample.time < time; }

class JointBufferImpl CV_FINAL : public JointBuffer
{
public:
    JointBufferImpl(const std::vector<String>& coordinates, double history, double maxGap)
        : coordinates_(coordinates), history_(history), maxGap_(maxGap), samples_(coordinates.size()), strange_(0)
    {
        for (size_t c = 0; c < coordinates.size(); c++) keys_.push_back(jointKey(coordinates[c]));
    }

    bool add(const JointReading& reading) CV_OVERRIDE
    {
        const std::vector<int> targets = targetsOf(reading);
        CV_Assert(std::abs(reading.time) <= mostTime && "the time of a reading must be finite, and within 1e11 s");
        for (size_t i = 0; i < reading.positions.size(); i++)
            CV_Assert(std::abs(reading.positions[i]) <= mostPosition && "the positions of a reading must be finite, and within 1e6");
        double last = -DBL_MAX;
        for (size_t c = 0; c < samples_.size(); c++)
            if (!samples_[c].empty()) last = std::max(last, samples_[c].back().time);
        const bool strange = last > -DBL_MAX && std::abs(reading.time - last) > history_;
        if (strange && ++strange_ < restartAfter)
            return false;
        if (strange)
            clear();
        strange_ = 0;
        bool isNew = false;
        for (size_t i = 0; i < targets.size(); i++)
            if (targets[i] >= 0) isNew = insert(samples_[targets[i]], reading.time, reading.positions[i]) || isNew;
        return isNew;
    }

    int at(double time, std::vector<double>& joints) const CV_OVERRIDE
    {
        std::vector<double> result(samples_.size());
        for (size_t c = 0; c < samples_.size(); c++)
        {
            const int state = coordinateAt(samples_[c], time, result[c]);
            if (state != JOINTS_FOUND)
                return state;
        }
        joints.swap(result);
        return JOINTS_FOUND;
    }

    double newest() const CV_OVERRIDE
    {
        double time = DBL_MAX;
        for (size_t c = 0; c < samples_.size(); c++)
            time = std::min(time, samples_[c].empty() ? -DBL_MAX : samples_[c].back().time);
        return time;
    }

    void clear() CV_OVERRIDE
    {
        for (size_t c = 0; c < samples_.size(); c++) samples_[c].clear();
        strange_ = 0;
    }

private:
    //! The coordinate of each position, -1 if there is none.
    std::vector<int> targetsOf(const JointReading& reading) const
    {
        const size_t n = reading.positions.size();
        CV_Assert((reading.names.empty() || reading.names.size() == n) && "a reading has one name a position, or none");
        std::vector<int> targets(n, -1);
        bool named = false;
        for (size_t i = 0; i < reading.names.size(); i++)
        {
            size_t c = std::find(coordinates_.begin(), coordinates_.end(), reading.names[i]) - coordinates_.begin();
            if (c == coordinates_.size())
                c = std::find(keys_.begin(), keys_.end(), jointKey(reading.names[i])) - keys_.begin();
            targets[i] = c < coordinates_.size() ? (int)c : -1;
            named = named || targets[i] >= 0;
        }
        if (named)
            return targets;
        const size_t all = coordinates_.size();
        if (n != all && n + 1 != all)
            CV_Error(Error::StsUnmatchedSizes, format("a reading has %d positions%s; expected %d, or %d without the jaw, in the order of the tool's "
                     "coordinates, or names of coordinates", (int)n, reading.names.empty() ? " without names" : " whose names are no coordinates",
                     (int)all, (int)all - 1));
        for (size_t i = 0; i < n; i++) targets[i] = (int)i;
        return targets;
    }

    bool insert(std::deque<Sample>& samples, double time, double value) const
    {
        const std::deque<Sample>::iterator after = std::lower_bound(samples.begin(), samples.end(), time, isEarlier);
        if (after != samples.end() && after->time == time)
            return false;
        const Sample sample = { time, value };
        samples.insert(after, sample);
        while (samples.size() > maxReadings || samples.front().time < samples.back().time - history_) samples.pop_front();
        return true;
    }

    int coordinateAt(const std::deque<Sample>& samples, double time, double& value) const
    {
        if (samples.empty())
            return JOINTS_NONE;
        if (!(time <= samples.back().time))   // so that a time that is not a number is not found
            return JOINTS_TOO_NEW;
        if (time < samples.front().time)
            return JOINTS_TOO_OLD;
        const std::deque<Sample>::const_iterator after = std::lower_bound(samples.begin(), samples.end(), time, isEarlier);
        value = after->value;
        if (after->time == time)
            return JOINTS_FOUND;
        const Sample &a = *(after - 1), &b = *after;
        if (b.time - a.time > maxGap_)
            return JOINTS_GAP;
        value = a.value + (time - a.time) / (b.time - a.time) * (b.value - a.value);
        return JOINTS_FOUND;
    }

    std::vector<String> coordinates_, keys_;     // keys_: see jointKey()
    double history_, maxGap_;
    std::vector<std::deque<Sample> > samples_;   // a coordinate, by rising time
    int strange_;                                // readings in succession, older or newer than the history
};

class ClockOffsetImpl CV_FINAL : public ClockOffset
{
public:
    explicit ClockOffsetImpl(double window) : window_(window) {}

    void add(double stamp, double arrival) CV_OVERRIDE
    {
        CV_Assert(isFinite(stamp) && isFinite(arrival) && "stamp and arrival must be finite");
        // A difference that is not less than a later one will never be the least again.
        while (!differences_.empty() && differences_.back().value >= arrival - stamp) differences_.pop_back();
        const Sample sample = { arrival, arrival - stamp };
        differences_.push_back(sample);
        while (differences_.front().time < arrival - window_ || differences_.size() > maxReadings) differences_.pop_front();
    }

    double offset() const CV_OVERRIDE { return differences_.empty() ? 0 : differences_.front().value; }

private:
    double window_;
    std::deque<Sample> differences_;   // rising, in time and value: the first is the least
};

} // namespace

JointReading::JointReading() : time(0) {}

Ptr<JointBuffer> JointBuffer::create(const std::vector<String>& coordinates, double history, double maxGap)
{
    CV_Assert(!coordinates.empty() && "coordinates must not be empty");
    CV_Assert(history > 0 && isFinite(history) && "history must be larger than 0");
    CV_Assert(maxGap > 0 && isFinite(maxGap) && "maxGap must be larger than 0");
    return makePtr<JointBufferImpl>(coordinates, history, maxGap);
}

Ptr<ClockOffset> ClockOffset::create(double window)
{
    CV_Assert(window > 0 && isFinite(window) && "window must be larger than 0");
    return makePtr<ClockOffsetImpl>(window);
}

}} // namespace cv::surgtrack
