// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// The command line of track_sequence.

#ifndef OPENCV_SURGTRACK_SAMPLES_SUPPORT_TRACK_OPTIONS_HPP
#define OPENCV_SURGTRACK_SAMPLES_SUPPORT_TRACK_OPTIONS_HPP

#include "opencv2/surgtrack.hpp"
#include "opencv2/surgtrack/lab.hpp"
#include "common.hpp"
#include "sequences.hpp"

namespace common {

struct TrackOptions
{
    std::vector<cv::String> sequences;    // none: the built-in one
    cv::String poses, video, timings, debug, debugFrames, toolState;
    cv::surgtrack::ToolTracker::Params params;
    cv::surgtrack::ToolTracker::Stages stages;
    int start, frames;
    double timeOffset;    // [s]
    bool findTimeOffset, stereo, renderAhead, check, quiet;

    bool keepsNothing() const { return poses.empty() && video.empty() && timings.empty() && debug.empty(); }
};

//! For cv::CommandLineParser.
inline const char* trackKeys()
{
    return
    "{ help h   |       | print this }"
    "{ sequence |       | folder of the sequence, or one that is searched for such; without it a synthetic one is made in ./surgtrack_demo }"
    "{ poses    |       | CSV file to write the poses to. Of several sequences: FILE_SEQUENCE.csv, and so for what follows }"
    "{ video    |       | MP4 file to draw the result into: kinematics in red, estimate in green, matched parts as dots }"
    "{ timings  |       | CSV file to write the time of each stage in each frame to [s] }"
    "{ debug    |       | folder to write pictures of every stage to, see --debug-frames }"
    "{ debug-frames |   | the frames to do so for: 3,17,40, or every:N from the first one on; default every:25 }"
    "{ method   |       | full (default): with joint offsets and outlines; paper: Ye et al. 2016; epnp: their baseline, EPnP on each frame alone }"
    "{ stereo   |       | use the right image too; method full only }"
    "{ start    | 0     | first frame }"
    "{ frames   | 0     | number of frames, 0 = to the end of the video }"
    "{ time-offset | 0  | the joints that belong to the image of time t were recorded at t + SECONDS; auto: found from the sequence, of each tool }"
    "{ render-ahead |   | draw the templates of the next frame in a second thread: faster, the poses differ a little }"
    "{ tool-state |     | file with what was learnt of the joints' errors: read if it is there, written in the end, one for all sequences: play is the same tomorrow }"
    "{ config   |       | file with parameters of the tracker, as --write-config writes it }"
    "{ set      |       | NAME=VALUE[,NAME=VALUE...]: parameters, as matcher.minSimilarity=0.5; comes after --config }"
    "{ write-config |   | file to write all parameters to; nothing is tracked }"
    "{ check    |       | only look for mistakes of the setup: units, calibrations, clocks, arms, instruments; exit code 1 if there are any }"
    "{ quiet    |       | print warnings and errors only }";
}

inline Program trackProgram()
{
    const Program program = { "track_sequence", "Tracks the tools of recorded sequences by their CAD models and joint readings. Exit code 2: nothing was tracked.",
                              trackKeys(), { "sequence", "poses", "video", "method", "start", "frames", "time-offset", "timings", "debug", "debug-frames",
                                             "tool-state", "config", "set", "write-config" },
                              { "stereo", "render-ahead", "check", "quiet" } };
    return program;
}

inline void readTimeOffset(const cv::String& text, TrackOptions& options)
{
    char* end = 0;
    options.findTimeOffset = text == "auto";
    options.timeOffset = options.findTimeOffset ? 0 : std::strtod(text.c_str(), &end);
    if (!options.findTimeOffset && (end == text.c_str() || *end || !(std::abs(options.timeOffset) <= 1e12)))
        fail("argument '--time-offset=" + text + "': expected a number of seconds or auto");
}

//! --config, --set and --method, in this order.
inline void readParams(const cv::CommandLineParser& parser, TrackOptions& options)
{
    using namespace cv::surgtrack;
    const cv::String config = parser.get<cv::String>("config"), method = parser.get<cv::String>("method");
    const std::string list = parser.get<cv::String>("set");
    if (!config.empty())
        readTrackerParams(config, options.params, options.stages);
    for (size_t at = 0, comma; at < list.size(); at = comma + 1)
    {
        comma = std::min(list.find(',', at), list.size());
        const std::string item = list.substr(at, comma - at);
        const size_t equals = item.find('=');
        if (equals == std::string::npos)
            fail("argument '--set': expected NAME=VALUE, found '" + item + "'");
        setTrackerParam(item.substr(0, equals), item.substr(equals + 1), options.params, options.stages);
    }
    if (method != "" && method != "full" && method != "paper" && method != "epnp")
        fail("argument '--method=" + method + "': the methods available are full, paper and epnp");
    if (!method.empty())
        options.params.method = method == "full" ? METHOD_FULL : method == "paper" ? METHOD_PAPER : METHOD_EPNP;
}

inline TrackOptions readTrackOptions(const cv::CommandLineParser& parser)
{
    TrackOptions options;
    const cv::String sequence = parser.get<cv::String>("sequence");
    if (!sequence.empty())
        options.sequences = findSequences(std::vector<cv::String>(1, sequence));
    options.poses = parser.get<cv::String>("poses");
    options.video = parser.get<cv::String>("video");
    options.timings = parser.get<cv::String>("timings");
    options.debug = parser.get<cv::String>("debug");
    options.debugFrames = parser.get<cv::String>("debug-frames");
    options.toolState = parser.get<cv::String>("tool-state");
    options.start = integer(parser, "start", 0);
    options.frames = integer(parser, "frames", 0);
    readTimeOffset(parser.get<cv::String>("time-offset"), options);
    options.renderAhead = parser.has("render-ahead");
    options.check = parser.has("check");
    options.quiet = parser.has("quiet");
    readParams(parser, options);
    options.stereo = parser.has("stereo");
    if (options.stereo && options.params.method != cv::surgtrack::METHOD_FULL)
        fail(cv::String("argument '--stereo': method ") + (options.params.method == cv::surgtrack::METHOD_PAPER ? "paper" : "epnp") +
             " uses one image, expected --method=full");
    if (!options.toolState.empty() && options.params.method != cv::surgtrack::METHOD_FULL)
        fail("argument '--tool-state': only --method=full learns what is wrong with readings");
    if (!options.debugFrames.empty() && options.debug.empty())
        fail("argument '--debug-frames': expected --debug=DIR too");
    if (!options.debug.empty() && options.renderAhead)
        fail("argument '--debug': what is drawn ahead is not kept, expected no --render-ahead");
    if (options.debugFrames.empty())
        options.debugFrames = "every:25";
    FrameChoice(options.debugFrames, options.start);   // an error in it comes before the work
    return options;
}

} // namespace common

#endif
