// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_LAB_SETUP_CHECK_SETUP_TRIAL_HPP
#define OPENCV_SURGTRACK_SRC_LAB_SETUP_CHECK_SETUP_TRIAL_HPP

#include <map>
#include "precomp.hpp"
#include "opencv2/surgtrack/sequence.hpp"

namespace cv { namespace surgtrack {

//! The tools of a sequence as they are tried: as given, or with something exchanged.
struct SetupTools
{
    std::vector<Ptr<ToolModel> > models;
    std::vector<Matx44d> nominal_T_base;
    std::vector<double> timeOffsets;   // a tool, beside that of the sequence [s]
};

//! How well a tool is tracked.
struct SetupScore
{
    SetupScore() : tried(0), frames(0), tracked(0), parts(0), evidence(0), nis(0) {}
    int tried;            // frames
    int frames;           // of these, in which its readings put at least four parts where they can be seen
    int tracked;          // of these
    double parts;         // seen, a frame
    double evidence;      // similarity and contour support, a tracked frame
    double nis;           // a tracked frame

    double share() const { return frames ? double(tracked) / frames : 0; }

    /* 1.26 and more with the right instrument on the path-traced sequences, 1.0 and 1.1 on stills of a real one, at most 0.9 with most
    others, though a few much alike have 1.0: these are tracked, too, but in fewer frames, with less evidence and points that fit worse. */
    bool isGood() const { return share() * evidence - 2 * nis >= 0.9; }
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
