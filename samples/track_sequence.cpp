// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Tracks the tools of recorded sequences: video, joint readings and a rough hand-eye calibration in, tool poses out.

#include "opencv2/videoio.hpp"
#include "opencv2/surgtrack.hpp"
#include "opencv2/surgtrack/lab.hpp"
#include "support/common.hpp"
#include "support/debug_pictures.hpp"
#include "support/frame_reader.hpp"
#include "support/run_output.hpp"
#include "support/tools.hpp"
#include "support/track_options.hpp"
#include "support/track_run.hpp"

using namespace cv;
using namespace cv::surgtrack;
using common::fail;
using common::Tool;
typedef common::TrackOptions Options;
typedef common::TrackRun Run;

namespace {

//! Time of the joint readings of a tool that belong to a frame.
double readingTime(const Run& run, int tool, int frame, int field = 0) { return run.sequence->frameTime(frame, field) + run.timeOffsets[tool]; }

//! The joint readings of all tools at a frame. Returns the first tool whose records do not reach it, or -1.
int readJoints(const Run& run, int frame, std::vector<std::vector<double> >& joints, int field = 0)
{
    joints.resize(run.tools.size());
    for (int i = 0; i < (int)run.tools.size(); i++)
        if (!run.sequence->jointsAt(i, readingTime(run, i, frame, field), joints[i], run.tools[i].model->coordinateNames()))
            return i;
    return -1;
}

//! @param folder empty: the built-in sequence
void prepare(const Options& options, String folder, Run& run)
{
    run.frames = run.skipped = 0;
    run.seconds = 0;
    run.interrupted = false;
    run.renderer = MeshRenderer::createSoftware();
    if (folder.empty())
    {
        folder = "surgtrack_demo";
        if (!options.quiet)
            std::fprintf(stderr, "making a synthetic sequence in %s\n", folder.c_str());
        SyntheticScene::Params scene;
        scene.stereo = options.stereo;
        scene.cables = 1;
        SyntheticScene::create(Ptr<ToolModel>(), scene)->write(folder);
    }
    run.sequence = Sequence::load(folder);
    if (options.stereo && !run.sequence->isStereo())
        fail("argument '--stereo': sequence " + folder + " has one camera, expected 'right' and 'right_T_left' in its sequence.yaml");

    run.tracker = ToolTracker::create(run.sequence->leftCamera(), options.params, options.stages);
    if (options.stereo)
        run.tracker->setRightCamera(run.sequence->rightCamera(), run.sequence->right_T_left());
    common::setMasks(*run.sequence, *run.tracker, options.stereo);
    run.tools = common::loadTools(*run.sequence);
    run.timeOffsets.assign(run.tools.size(), options.timeOffset);
    for (size_t i = 0; i < run.tools.size(); i++)
        run.tracker->addTool(run.tools[i].model, run.tools[i].info.nominal_T_base);
    common::readState(run, options.toolState);
    if (run.sequence->hasGroundTruth())
        run.scorer = PoseScorer::create(run.sequence->leftCamera(), common::modelsOf(run.tools));
}

//! Arms have clocks of their own: of each tool, or, where that can't be told, that of one where it can.
void findTimeOffsets(const Options& options, Run& run)
{
    if (!options.quiet)
        std::fprintf(stderr, "looking for the time offset%s\n", run.tools.size() > 1 ? " of each tool" : "");
    const size_t unknown = run.tools.size();
    size_t best = unknown;
    std::vector<TimeOffset> found(run.tools.size());
    std::vector<char> known(run.tools.size());
    TimeOffsetParams params;
    for (params.tool = 0; params.tool < (int)run.tools.size(); params.tool++)
    {
        TimeOffset& offset = found[params.tool];
        known[params.tool] = estimateTimeOffset(run.sequence, offset, params);
        if (known[params.tool] && (best == unknown || offset.support > found[best].support))
            best = params.tool;
        if (known[params.tool] && !options.quiet)
            std::fprintf(stderr, "%s: time offset %.4f s +- %.4f s, confidence %.2f\n", run.tools[params.tool].info.name.c_str(), offset.offset,
                         offset.deviation, offset.confidence);
    }
    if (best == unknown)
        fail("argument '--time-offset=auto': the time offset can't be told: " + found[0].reason + "; give it in seconds");
    for (size_t i = 0; i < run.tools.size(); i++)
    {
        run.timeOffsets[i] = found[known[i] ? i : best].offset;
        if (!known[i])
            std::fprintf(stderr, "warning: the time offset of tool '%s' can't be told (%s): that of '%s' is taken\n", run.tools[i].info.name.c_str(),
                         found[i].reason.c_str(), run.tools[best].info.name.c_str());
    }
}

//! A frame without joint readings, at an end of the records: the poses at the nearest reading, not to be relied on.
void skipFrame(Run& run, int frame, std::vector<std::vector<double> >& joints, std::vector<ToolEstimate>& estimates)
{
    const bool before = run.frames == run.skipped;    // none is tracked yet
    estimates.resize(run.tools.size());
    for (int i = 0; i < (int)run.tools.size(); i++)
    {
        const Tool& tool = run.tools[i];
        const double time = std::min(std::max(readingTime(run, i, frame), run.sequence->firstTime(i)), run.sequence->lastTime(i));
        run.sequence->jointsAt(i, time, joints[i], tool.model->coordinateNames());
        estimates[i] = common::unmeasured(tool, joints[i], before ? STATE_INITIALIZING : STATE_LOST, estimates[i]);
    }
    run.skipped++;
}

//! right is empty without --stereo
void trackFrame(Run& run, int frame, const Mat& image, const Mat& right, const std::vector<std::vector<double> >& joints,
                std::vector<ToolEstimate>& estimates, int field = 0)
{
    const double time = run.sequence->frameTime(frame, field);
    if (right.empty())
        run.tracker->update(image, time, joints, estimates);
    else
        run.tracker->updateStereo(image, right, time, joints, estimates);
    const std::vector<StageTime> times = run.tracker->getTimings();
    run.timings.resize(times.size());
    for (size_t i = 0; i < times.size(); i++)
        run.timings[i].push_back(times[i].last);
}

//! The templates of the next image are drawn while this one is tracked.
void drawAhead(Run& run, int frame, int field)
{
    std::vector<std::vector<double> > joints;
    const int next = field + 1;
    const bool inFrame = next < run.sequence->imagesPerFrame();
    if (readJoints(run, inFrame ? frame : frame + 1, joints, inFrame ? next : 0) < 0)
        run.tracker->renderAhead(joints);
}

//! Where frames hold two fields, the second one; the poses of a frame are those of its first.
void trackSecond(const Options& options, Run& run, common::EyesReader& reader, int frame, Mat& image, Mat& right)
{
    std::vector<std::vector<double> > joints;
    std::vector<ToolEstimate> estimates;
    if (!reader.readSecond(image, right) || readJoints(run, frame, joints, 1) >= 0)
        return;
    if (options.renderAhead)
        drawAhead(run, frame, 1);
    trackFrame(run, frame, image, right, joints, estimates, 1);
}

void record(Run& run, int frame, const std::vector<ToolEstimate>& estimates, PoseWriter* writer)
{
    const double time = run.sequence->frameTime(frame);
    for (int i = 0; i < (int)run.tools.size(); i++)
    {
        run.tools[i].tracked += estimates[i].state == STATE_TRACKING;
        if (writer)
            writer->write(frame, time, run.tools[i].info.name, estimates[i]);
        Matx44d truth;
        std::vector<double> trueJoints;
        if (run.scorer && run.sequence->groundTruth(i, frame, truth, trueJoints))
            run.scorer->add(i, estimates[i].state, estimates[i].camera_T_tool, truth);
    }
    run.frames++;
}

//! What is written beside the summary; empty: it is not asked for.
struct Outputs
{
    Outputs(const Options& options, const Run& run) : debugFrames(options.debugFrames, options.start)
    {
        const CameraModel camera = run.sequence->leftCamera();
        if (!options.poses.empty())
            poses = PoseWriter::create(options.poses, common::namesOf(run.tools), common::modelsOf(run.tools));
        if (!options.timings.empty())
            timings = makePtr<common::TimingsWriter>(options.timings);
        if (!options.video.empty())
            overlay = makePtr<common::Overlay>(options.video, run.sequence->fps(), camera.imageSize());
        if (!options.debug.empty())
            debug = makePtr<common::DebugPictures>(options.debug, options.params.method);
    }

    Ptr<PoseWriter> poses;
    Ptr<common::TimingsWriter> timings;
    Ptr<common::Overlay> overlay;
    Ptr<common::DebugPictures> debug;
    common::FrameChoice debugFrames;
};

//! Once: recordings hardly ever start together.
void warnOfMissing(const Run& run, int tool, int frame)
{
    std::fprintf(stderr, "warning: %s: no joint readings of tool '%s' at %.3f s (frame %d), they cover %.3f to %.3f s: such frames are not tracked\n",
                 run.sequence->kinematicsFile().c_str(), run.tools[tool].info.name.c_str(), readingTime(run, tool, frame), frame,
                 run.sequence->firstTime(tool), run.sequence->lastTime(tool));
}

//! At the end of the video, or after Ctrl-C.
void finish(const Run& run, Outputs& outputs)
{
    if (outputs.overlay)
        outputs.overlay->finish();
    if (outputs.debug && run.frames > run.skipped && !run.interrupted)
        outputs.debugFrames.check();
    if (run.interrupted)
        return;
    if (run.frames == 0)
        fail(run.sequence->leftVideo() + ": has no frames");
    if (run.skipped == run.frames)
        fail(format("%s: no joint readings at the time of any frame with a time offset of %g s; those of tool '%s' cover %.3f to %.3f s",
                    run.sequence->kinematicsFile().c_str(), run.timeOffsets[0], run.tools[0].info.name.c_str(), run.sequence->firstTime(0),
                    run.sequence->lastTime(0)));
}

void track(const Options& options, Run& run)
{
    common::EyesReader reader(*run.sequence, options.start, options.stereo);
    Outputs outputs(options, run);
    const int remaining = std::max(0, reader.count() - options.start);
    common::Progress progress(options.frames > 0 ? std::min(options.frames, remaining) : remaining, options.quiet);
    const int64 startTick = getTickCount();
    Mat image, right;
    std::vector<std::vector<double> > joints;
    common::FieldsNote note(*run.sequence);
    std::vector<ToolEstimate> estimates;
    for (int frame = options.start; options.frames == 0 || frame < options.start + options.frames; frame++)
    {
        run.interrupted = common::interrupted() != 0;
        if (run.interrupted || !reader.read(image, right))
            break;
        note.look(image);
        const int missing = readJoints(run, frame, joints);
        if (missing >= 0 && run.timeOffsets[missing] == 0 && run.skipped == 0)
            warnOfMissing(run, missing, frame);
        if (missing >= 0)
            skipFrame(run, frame, joints, estimates);
        else
        {
            if (options.renderAhead)
                drawAhead(run, frame, 0);
            trackFrame(run, frame, image, right, joints, estimates);
            if (outputs.timings)
                outputs.timings->write(frame, run.sequence->frameTime(frame), run.tracker->getTimings());
            if (outputs.debug && outputs.debugFrames.wants(frame))
                outputs.debug->write(frame, image, common::debugTools(run, estimates));
        }
        record(run, frame, estimates, outputs.poses.get());
        if (outputs.overlay)
        {
            common::drawResult(image, run, joints, estimates);
            outputs.overlay->write(image);
        }
        if (missing < 0)
            trackSecond(options, run, reader, frame, image, right);
        run.seconds = (double)(getTickCount() - startTick) / getTickFrequency();
        progress.show(run.frames);
    }
    finish(run, outputs);
    if (run.frames > run.skipped)
        common::writeState(run, options.toolState);
}

//! @return number of findings
int printFindings(const Options& options, const Run& run)
{
    std::vector<String> findings, figures;
    checkSetup(run.sequence, findings, figures, options.stereo || (options.check && run.sequence->isStereo()));
    for (size_t i = 0; i < figures.size() && options.check && !options.quiet; i++)
        std::printf("%s\n", figures[i].c_str());
    for (size_t i = 0; i < findings.size(); i++)
        std::fprintf(stderr, "check: %s\n", findings[i].c_str());
    return (int)findings.size();
}

//! @return the exit code: 2 if nothing was tracked; then what may be the cause is printed
int verdict(const Options& options, const Run& run)
{
    if (!common::nothingTracked(run))
        return 0;
    if (printFindings(options, run) == 0)
        std::fprintf(stderr, "check: nothing was tracked, though units and calibration are plausible: is it this instrument (model), this arm (name), "
                     "this time (time_offset), and does the hand-eye calibration put it within some centimetres?\n");
    return 2;
}

//! @return the exit code
int checkOnly(const Options& options, const Run& run)
{
    const int findings = printFindings(options, run);
    if (!options.quiet)
        std::printf("%s: %d finding%s\n", run.sequence->name().c_str(), findings, findings == 1 ? "" : "s");
    return findings > 0;
}

//! @return the exit code
int runSequence(const Options& options, const String& folder)
{
    Run run;
    prepare(options, folder, run);
    if (options.check)
        return checkOnly(options, run);
    if (options.stereo)
    {
        const String eyes = checkEyes(run.sequence);
        if (!eyes.empty())
            std::fprintf(stderr, "warning: %s\n", eyes.c_str());
    }
    if (options.findTimeOffset)
        findTimeOffsets(options, run);
    try
    {
        track(options, run);
    }
    catch (const Exception&)   // what was tracked until then is written and summed up all the same
    {
        if (run.frames > 0 && !options.quiet)
            common::printSummary(run);
        throw;
    }
    if (run.frames > 0 && !options.quiet)
        common::printSummary(run);
    if (run.interrupted)
    {
        std::fprintf(stderr, "interrupted: all is of the first %d frames\n", run.frames);
        return 130;   // as of a program that the signal ended
    }
    const int code = verdict(options, run);
    if (options.keepsNothing() && !options.quiet && code == 0)
        std::printf("nothing was kept: --poses=FILE.csv and --video=FILE.mp4 write the result\n");
    return code;
}

//! Of one of several sequences: each writes files of its own.
Options optionsOf(const Options& all, const String& label)
{
    Options options = all;
    String* const files[] = { &options.poses, &options.video, &options.timings, &options.debug };
    for (int i = 0; i < 4; i++)
    {
        const size_t slash = files[i]->find_last_of("/\\"), dot = files[i]->rfind('.');
        const bool ending = dot != String::npos && (slash == String::npos || dot > slash);
        if (!files[i]->empty())
            files[i]->insert(ending ? dot : files[i]->size(), "_" + label);
    }
    return options;
}

int run(const CommandLineParser& parser)
{
    const Options options = common::readTrackOptions(parser);
    const String written = parser.get<String>("write-config");
    if (!written.empty())
    {
        writeTrackerParams(written, options.params, options.stages);
        return 0;
    }
    common::catchInterrupts();
    if (options.sequences.size() <= 1)
        return runSequence(options, options.sequences.empty() ? String() : options.sequences[0]);
    int worst = 0;
    std::map<String, int> labels;
    for (size_t i = 0; i < options.sequences.size() && !common::interrupted(); i++)   // one that fails is told of, and the next one's turn comes
    {
        String label = common::baseName(common::absolutePath(options.sequences[i]));
        if (labels[label]++ > 0)
            label += format("-%d", labels[label]);
        int code = 1;
        try
        {
            code = runSequence(optionsOf(options, label), options.sequences[i]);
        }
        catch (...)
        {
            common::reportError("track_sequence");
        }
        worst = std::max(worst, code);
    }
    return worst;
}

} // namespace

int main(int argc, char** argv)
{
    return common::runProgram(argc, argv, common::trackProgram(), run);
}
