// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// A run of track_sequence: what it holds, draws and prints in the end.

#ifndef OPENCV_SURGTRACK_SAMPLES_SUPPORT_TRACK_RUN_HPP
#define OPENCV_SURGTRACK_SAMPLES_SUPPORT_TRACK_RUN_HPP

#include "opencv2/core/utils/filesystem.hpp"
#include "opencv2/surgtrack.hpp"
#include "opencv2/surgtrack/lab.hpp"
#include "debug_pictures.hpp"
#include "run_output.hpp"
#include "tools.hpp"

namespace common {

using namespace cv;
using namespace cv::surgtrack;

//! What is tracked, and what came of it.
struct TrackRun
{
    Ptr<Sequence> sequence;
    std::vector<Tool> tools;
    Ptr<ToolTracker> tracker;
    Ptr<PoseScorer> scorer;
    Ptr<MeshRenderer> renderer;    // of the overlay
    std::vector<std::vector<double> > timings;    // a stage, a frame [s]
    int frames, skipped;    // skipped: of the frames, those without joint readings
    double seconds;
    std::vector<double> timeOffsets;    // a tool, beside those of the sequence [s]
    bool interrupted;
};

//! What an earlier run learnt of the joints, if there was one.
inline void readState(TrackRun& run, const String& filename)
{
    if (filename.empty() || !utils::fs::exists(filename))
        return;
    for (size_t i = 0; i < run.tools.size(); i++)
    {
        const ReadingErrors errors = readToolState(filename, run.tools[i].info.name);
        try
        {
            run.tracker->setReadingErrors((int)i, errors);
        }
        catch (const Exception& e)
        {
            fail(filename + ": tool '" + run.tools[i].info.name + "': " + e.err);
        }
    }
}

inline void writeState(const TrackRun& run, const String& filename)
{
    if (filename.empty())
        return;
    std::vector<ReadingErrors> errors;
    for (size_t i = 0; i < run.tools.size(); i++)
        errors.push_back(run.tracker->readingErrors((int)i));
    writeToolState(filename, namesOf(run.tools), errors);
}

inline void drawResult(Mat& image, const TrackRun& run, const std::vector<std::vector<double> >& joints, const std::vector<ToolEstimate>& estimates)
{
    const CameraModel camera = run.sequence->leftCamera();
    std::vector<DrawnTool> nominal, found;
    for (size_t i = 0; i < run.tools.size(); i++)
    {
        const Tool& tool = run.tools[i];
        nominal.push_back(DrawnTool(tool.model, joints[i], tool.info.nominal_T_base, Scalar(0, 0, 255), 0));
        if (isKnown(estimates[i]))
            found.push_back(DrawnTool(tool.model, estimates[i]));
    }
    drawTools(image, camera, found, run.renderer);
    drawTools(image, camera, nominal, run.renderer);
    for (size_t i = 0; i < run.tools.size(); i++)
        drawEvidence(image, estimates[i], run.tools[i].info.name, (int)i);
}

inline std::vector<DebugTool> debugTools(const TrackRun& run, const std::vector<ToolEstimate>& estimates)
{
    std::vector<DebugTool> result(run.tools.size());
    for (size_t i = 0; i < run.tools.size(); i++)
    {
        DebugTool& debug = result[i];
        debug.name = run.tools[i].info.name;
        debug.model = run.tools[i].model;
        debug.sight = run.tracker->sight((int)i);
        debug.foundJoints = estimates[i].joints;
        debug.found_camera_T_base = estimates[i].camera_T_nominal * run.tools[i].info.nominal_T_base;
    }
    return result;
}

inline bool nothingTracked(const TrackRun& run)
{
    int tracked = 0;
    for (size_t i = 0; i < run.tools.size(); i++)
        tracked += run.tools[i].tracked;
    return tracked == 0;
}

//! Where nothing was tracked, no more than that: what may be the cause comes next.
inline void printSummary(const TrackRun& run)
{
    const Size size = run.sequence->leftCamera().imageSize();
    std::printf("%s: %d frames of %dx%d\n", run.sequence->name().c_str(), run.frames, size.width, size.height);
    for (size_t i = 0; i < run.tools.size(); i++)
        std::printf("  %-8s tracked in %.1f %% of the frames\n", run.tools[i].info.name.c_str(), 100. * run.tools[i].tracked / run.frames);
    for (size_t i = 0; i < run.tools.size(); i++)
        if (run.timeOffsets[i] != 0)
            std::printf("  %-8s time offset %.4f s; time_offset: %.4f of this tool in sequence.yaml keeps it\n", run.tools[i].info.name.c_str(),
                        run.timeOffsets[i], run.tools[i].info.timeOffset + run.timeOffsets[i]);
    if (run.skipped > 0)
        std::printf("  %d frames without joint readings\n", run.skipped);
    std::fflush(stdout);
    if (nothingTracked(run))
        return;
    std::printf("time a frame [ms]   median      95 %%\n");
    const std::vector<StageTime> times = run.tracker->getTimings();
    std::vector<std::vector<double> > timings = run.timings;
    timings.resize(times.size());   // none if every frame was skipped
    for (size_t i = 0; i < times.size(); i++)
        std::printf("  %-14s %9.2f %9.2f\n", times[i].name.c_str(), 1e3 * percentile(timings[i], 0.5), 1e3 * percentile(timings[i], 0.95));
    const double total = times.back().mean * times.back().calls;
    std::printf("tracker %.1f Hz, whole run %.1f frames/s\n", total > 0 ? (run.frames - run.skipped) / total : 0, run.seconds > 0 ? run.frames / run.seconds : 0);
    std::fflush(stdout);
    if (!run.scorer)
        return;
    std::printf("error of the poses  covered     translation [mm]     rotation [rad]   accuracy     silent\n");
    for (int i = 0; i <= (int)run.tools.size(); i++)
    {
        const bool all = i == (int)run.tools.size();
        const PoseScore s = run.scorer->score(all ? -1 : i);
        std::printf("  %-14s %8.1f %%    %6.2f +- %6.2f    %6.3f +- %5.3f   %6.1f %%   %6.1f %%\n", all ? "overall" : run.tools[i].info.name.c_str(),
                    s.frames ? 100. * s.covered / s.frames : 0, 1e3 * s.translationMean, 1e3 * s.translationStd, s.rotationMean, s.rotationStd,
                    100 * s.accuracy, 100 * s.silent);
    }
    std::fflush(stdout);
}

} // namespace common

#endif
