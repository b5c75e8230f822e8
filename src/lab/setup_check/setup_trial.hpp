// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_LAB_SETUP_CHECK_SETUP_TRIAL_HPP
#define OPENCV_SURGTRACK_SRC_LAB_SETUP_CHECK_SETUP_TRIAL_HPP

#include <map>
#include "precomp.hpp"
#include "opencv2/surgtrack/sequence.hpp"
#include "opencv2/surgtrack/tool_tracker.hpp"

namespace cv { namespace surgtrack {

//! The tools of a sequence as they are tried: as given, or with something exchanged.
struct SetupTools
{
    std::vector<Ptr<ToolModel> > models;
    std::vector<Matx44d> nominal_T_base;
    std::vector<double> timeOffsets;   // a tool, beside that of the sequence [s]
    std::vector<std::vector<char> > inDegrees;   // a tool, a coordinate: its readings are; none: all as they are

    bool upsideDown = false;           // images are turned by 180 degrees

    void readAs(int tool, std::vector<double>& joints) const;
};

//! How well a tool is tracked.
struct SetupScore
{
    SetupScore() : tried(0), frames(0), tracked(0), parts(0), evidence(0), nis(0), seen(), matched() {}
    int tried;            // frames
    int frames;           // of these, in which its readings put at least four parts where they can be seen
    int tracked;          // of these
    double parts;         // seen, a frame
    double evidence;      // similarity and contour support, a tracked frame
    double nis;           // a tracked frame
    double seen[2];       // in tracked frames, parts on links that others hang on, and at the tool's end: its jaws
    double matched[2];    // the sum of their similarities, 0 where they were not found

    double share() const { return frames ? double(tracked) / frames : 0; }

    void addParts(const ToolModel& model, const ToolSight& sight, const std::vector<PartMatch>& matches);

    /* Another instrument is tracked, too, but in fewer frames, with less evidence, and points that fit worse: by these alone others much
    alike have up to 1.1, and stills of a real recording 1.0. Instruments have the same shafts and much the same wrists, and their jaws
    differ. Light, blur and noise are the same for all parts in an image, so how much better jaws match than the rest tells of the
    instrument alone: by 0.03 to 0.15 with the right one, by -0.5 to 0.02 with others that are tracked at all. Of both: 1.4 and more with
    the right one in eleven sequences, five synthetic ones and the stills, at most 1.2 with another. */
    bool isGood() const;
    bool isJudged() const { return frames >= 6; }
};

//! Tracks the tools in short stretches of the video, each from the hand-eye calibration on.
class SetupTrial
{
public:
    explicit SetupTrial(const Sequence& sequence);
    std::vector<SetupScore> run(const SetupTools& tools) const;

private:
    void trackStretch(const SetupTools& tools, int start, std::vector<SetupScore>& scores) const;

    const Sequence& sequence_;
    std::vector<int> starts_;
    std::map<int, Mat> images_;   // by frame
};

}} // namespace cv::surgtrack

#endif
