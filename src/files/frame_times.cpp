// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/core/utils/filesystem.hpp"
#include "opencv2/surgtrack/sequence.hpp"
#include "files/csv.hpp"

// frames.csv: when each frame was taken, of recordings that dropped some or have no constant rate.

namespace cv { namespace surgtrack {

void Sequence::readFrames(const String& filename)
{
    if (!utils::fs::exists(filename))
        return;
    CsvReader csv(filename);
    const int frameColumn = csv.column("frame"), stampColumn = csv.column("stamp");
    std::vector<double> intervals;
    while (csv.next())
    {
        const int frame = csv.count(frameColumn);
        const double stamp = csv.number(stampColumn);
        if (!frames_.empty() && (frame <= frames_.back() || stamp <= stamps_.back()))
            csv.fail(format("frame %d at %.10g s comes after frame %d at %.10g s, expected both to rise", frame, stamp, frames_.back(), stamps_.back()));
        if (!frames_.empty())
            intervals.push_back((stamp - stamps_.back()) / (frame - frames_.back()));
        frames_.push_back(frame);
        stamps_.push_back(stamp);
    }
    if (intervals.empty())
        CV_Error(Error::StsParseError, filename + ": expected at least two frames");
    std::nth_element(intervals.begin(), intervals.begin() + intervals.size() / 2, intervals.end());
    fps_ = 1 / intervals[intervals.size() / 2];   // unless sequence.yaml says another one
}

double Sequence::frameTime(int frame, int field) const
{
    CV_CheckGE(frame, 0, "frame");
    CV_Check(field, field >= 0 && field <= 1, "field must be 0 or 1");
    if (field == 1)   // where frames are missing the camera did not wait; where stamps jitter it still comes before the next one
        return frameTime(frame) + 0.5 * std::min(1 / fps_, frameTime(frame + 1) - frameTime(frame));
    if (frames_.empty())
        return frame / fps_;
    if (frame <= frames_.front())
        return stamps_.front() + (frame - frames_.front()) / fps_;
    if (frame >= frames_.back())
        return stamps_.back() + (frame - frames_.back()) / fps_;
    const size_t after = std::lower_bound(frames_.begin(), frames_.end(), frame) - frames_.begin();
    const double share = (double)(frame - frames_[after - 1]) / (frames_[after] - frames_[after - 1]);
    return stamps_[after - 1] + share * (stamps_[after] - stamps_[after - 1]);
}

}} // namespace cv::surgtrack
