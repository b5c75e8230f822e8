// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Tracks the tools of a recorded sequence: video, joint readings and a rough hand-eye calibration in, tool poses out.

#include "opencv2/videoio.hpp"
#include "opencv2/surgtrack.hpp"
#include "opencv2/surgtrack/lab.hpp"
#include "support/common.hpp"
#include "support/debug_pictures.hpp"
#include "support/frame_reader.hpp"
#include "support/run_output.hpp"
#include "support/setup_check.hpp"
#include "support/tools.hpp"

using namespace cv;
using namespace cv::surgtrack;
using common::fail;
using common::isKnown;
using common::Tool;

namespace {

const char* const KEYS =
    "{ help h   |       | print this }"
    "{ sequence |       | folder of the sequence; without it a synthetic one is made in ./surgtrack_demo and tracked }"
    "{ poses    |       | CSV file to write the poses to }"
    "{ video    |       | MP4 file to draw the result into: kinematics in red, estimate in green, matched parts as dots }"
    "{ timings  |       | CSV file to write the time of each stage in each frame to [s] }"
    "{ debug    |       | folder to write pictures of every stage to, see --debug-frames }"
    "{ debug-frames |   | the frames to do so for: 3,17,40, or every:N from the first one on; default every:25 }"
    "{ method   | full  | full: with joint offsets and outlines; paper: Ye et al. 2016; epnp: their baseline, EPnP on each frame alone }"
    "{ stereo   |       | use the right image too; method full only }"
    "{ start    | 0     | first frame }"
    "{ frames   | 0     | number of frames, 0 = to the end of the video }"
    "{ time-offset | 0  | the joints that belong to the image of time t were recorded at t + SECONDS; auto: found from the sequence }"
    "{ render-ahead |   | draw the templates of the next frame in a second thread: faster, the poses differ a little }"
    "{ check    |       | only look for mistakes of the setup: units, hand-eye calibration, clocks, eyes; exit code 1 if there are any }"
    "{ quiet    |       | no progress }";

struct Options
{
    String sequence, poses, video, timings, debug, debugFrames;
    int method, start, frames;
    double timeOffset;    // [s]
    bool findTimeOffset, stereo, renderAhead, check, quiet;
};

void readTimeOffset(const String& text, Options& options)
{
    char* end = 0;
    options.findTimeOffset = text == "auto";
    options.timeOffset = options.findTimeOffset ? 0 : std::strtod(text.c_str(), &end);
    if (!options.findTimeOffset && (end == text.c_str() || *end || !(std::abs(options.timeOffset) <= 1e12)))
        fail("argument '--time-offset=" + text + "': expected a number of seconds or auto");
}

Options readOptions(const CommandLineParser& parser)
{
    Options options;
    options.sequence = parser.get<String>("sequence");
    options.poses = parser.get<String>("poses");
    options.video = parser.get<String>("video");
    options.timings = parser.get<String>("timings");
    options.debug = parser.get<String>("debug");
    options.debugFrames = parser.get<String>("debug-frames");
    options.start = common::integer(parser, "start", 0);
    options.frames = common::integer(parser, "frames", 0);
    readTimeOffset(parser.get<String>("time-offset"), options);
    options.renderAhead = parser.has("render-ahead");
    options.check = parser.has("check");
    options.quiet = parser.has("quiet");
    const String method = parser.get<String>("method");
    if (method != "full" && method != "paper" && method != "epnp")
        fail("argument '--method=" + method + "': the methods available are full, paper and epnp");
    options.method = method == "full" ? METHOD_FULL : method == "paper" ? METHOD_PAPER : METHOD_EPNP;
    options.stereo = parser.has("stereo");
    if (options.stereo && options.method != METHOD_FULL)
        fail("argument '--stereo': method " + method + " uses one image, expected --method=full");
    if (!options.debugFrames.empty() && options.debug.empty())
        fail("argument '--debug-frames': expected --debug=DIR too");
    if (!options.debug.empty() && options.renderAhead)
        fail("argument '--debug': what is drawn ahead is not kept, expected no --render-ahead");
    if (options.debugFrames.empty())
        options.debugFrames = "every:25";
    common::FrameChoice(options.debugFrames, options.start);   // an error in it comes before the work
    return options;
}

struct Run
{
    Ptr<Sequence> sequence;
    std::vector<Tool> tools;
    Ptr<ToolTracker> tracker;
    Ptr<PoseScorer> scorer;
    Ptr<MeshRenderer> renderer;    // of the overlay
    std::vector<std::vector<double> > timings;    // a stage, a frame [s]
    int frames, skipped;    // skipped: of the frames, those without joint readings
    double seconds, timeOffset;
};

void drawResult(Mat& image, const Run& run, const std::vector<std::vector<double> >& joints, const std::vector<ToolEstimate>& estimates)
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

std::vector<common::DebugTool> debugTools(const Run& run, const std::vector<ToolEstimate>& estimates)
{
    std::vector<common::DebugTool> result(run.tools.size());
    for (size_t i = 0; i < run.tools.size(); i++)
    {
        common::DebugTool& debug = result[i];
        debug.name = run.tools[i].info.name;
        debug.model = run.tools[i].model;
        debug.sight = run.tracker->sight((int)i);
        debug.foundJoints = estimates[i].joints;
        debug.found_camera_T_base = estimates[i].camera_T_nominal * run.tools[i].info.nominal_T_base;
    }
    return result;
}

//! Time of the joint readings that belong to a frame.
double readingTime(const Run& run, int frame, int field = 0) { return run.sequence->frameTime(frame, field) + run.timeOffset; }

//! The joint readings of all tools at a frame. Returns the first tool whose records do not reach it, or -1.
int readJoints(const Run& run, int frame, std::vector<std::vector<double> >& joints, int field = 0)
{
    joints.resize(run.tools.size());
    for (int i = 0; i < (int)run.tools.size(); i++)
        if (!run.sequence->jointsAt(i, readingTime(run, frame, field), joints[i], run.tools[i].model->coordinateNames()))
            return i;
    return -1;
}

void prepare(const Options& options, Run& run)
{
    run.frames = run.skipped = 0;
    run.seconds = 0;
    run.timeOffset = options.timeOffset;
    run.renderer = MeshRenderer::createSoftware();
    String folder = options.sequence;
    if (folder.empty())
    {
        folder = "surgtrack_demo";
        if (!options.quiet)
            std::fprintf(stderr, "making a synthetic sequence in %s\n", folder.c_str());
        SyntheticScene::Params scene;
        scene.stereo = options.stereo;
        SyntheticScene::create(Ptr<ToolModel>(), scene)->write(folder);
    }
    run.sequence = Sequence::load(folder);
    if (options.stereo && !run.sequence->isStereo())
        fail("argument '--stereo': sequence " + folder + " has one camera, expected 'right' and 'right_T_left' in its sequence.yaml");

    ToolTracker::Params params;
    params.method = options.method;
    run.tracker = ToolTracker::create(run.sequence->leftCamera(), params);
    if (options.stereo)
        run.tracker->setRightCamera(run.sequence->rightCamera(), run.sequence->right_T_left());
    common::setMasks(*run.sequence, *run.tracker, options.stereo);
    run.tools = common::loadTools(*run.sequence);
    for (size_t i = 0; i < run.tools.size(); i++)
        run.tracker->addTool(run.tools[i].model, run.tools[i].info.nominal_T_base);
    if (run.sequence->hasGroundTruth())
        run.scorer = PoseScorer::create(run.sequence->leftCamera(), common::modelsOf(run.tools));
}

void findTimeOffset(const Options& options, Run& run)
{
    if (!options.quiet)
        std::fprintf(stderr, "looking for the time offset\n");
    TimeOffset found;
    if (!estimateTimeOffset(run.sequence, found))
        fail("argument '--time-offset=auto': the time offset can't be told: " + found.reason + "; give it in seconds");
    run.timeOffset = found.offset;
    if (!options.quiet)
        std::fprintf(stderr, "time offset %.4f s +- %.4f s, confidence %.2f\n", found.offset, found.deviation, found.confidence);
}

//! A frame without joint readings, at an end of the records: the poses at the nearest reading, not to be relied on.
void skipFrame(Run& run, int frame, std::vector<std::vector<double> >& joints, std::vector<ToolEstimate>& estimates)
{
    const bool before = run.frames == run.skipped;    // none is tracked yet
    estimates.resize(run.tools.size());
    for (int i = 0; i < (int)run.tools.size(); i++)
    {
        const Tool& tool = run.tools[i];
        const double time = std::min(std::max(readingTime(run, frame), run.sequence->firstTime(i)), run.sequence->lastTime(i));
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
            debug = makePtr<common::DebugPictures>(options.debug, options.method);
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
                 run.sequence->kinematicsFile().c_str(), run.tools[tool].info.name.c_str(), readingTime(run, frame), frame,
                 run.sequence->firstTime(tool), run.sequence->lastTime(tool));
}

//! At the end of the video.
void finish(const Run& run, Outputs& outputs)
{
    if (outputs.overlay)
        outputs.overlay->finish();
    if (outputs.debug && run.frames > run.skipped)
        outputs.debugFrames.check();
    if (run.frames == 0)
        fail(run.sequence->leftVideo() + ": has no frames");
    if (run.skipped == run.frames)
        fail(format("%s: no joint readings at the time of any frame with a time offset of %g s; those of tool '%s' cover %.3f to %.3f s",
                    run.sequence->kinematicsFile().c_str(), run.timeOffset, run.tools[0].info.name.c_str(), run.sequence->firstTime(0),
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
        if (!reader.read(image, right))
            break;
        note.look(image);
        const int missing = readJoints(run, frame, joints);
        if (missing >= 0 && run.timeOffset == 0 && run.skipped == 0)
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
                outputs.debug->write(frame, image, debugTools(run, estimates));
        }
        record(run, frame, estimates, outputs.poses.get());
        if (outputs.overlay)
        {
            drawResult(image, run, joints, estimates);
            outputs.overlay->write(image);
        }
        if (missing < 0)
            trackSecond(options, run, reader, frame, image, right);
        run.seconds = (double)(getTickCount() - startTick) / getTickFrequency();
        progress.show(run.frames);
    }
    finish(run, outputs);
}

void printSummary(const Run& run)
{
    const Size size = run.sequence->leftCamera().imageSize();
    std::printf("%s: %d frames of %dx%d\n", run.sequence->name().c_str(), run.frames, size.width, size.height);
    for (size_t i = 0; i < run.tools.size(); i++)
        std::printf("  %-8s tracked in %.1f %% of the frames\n", run.tools[i].info.name.c_str(), 100. * run.tools[i].tracked / run.frames);
    if (run.timeOffset != 0 || run.skipped > 0)
        std::printf("  time offset %.4f s, %d frames without joint readings\n", run.timeOffset, run.skipped);
    std::printf("time a frame [ms]   median      95 %%\n");
    const std::vector<StageTime> times = run.tracker->getTimings();
    std::vector<std::vector<double> > timings = run.timings;
    timings.resize(times.size());   // none if every frame was skipped
    for (size_t i = 0; i < times.size(); i++)
        std::printf("  %-14s %9.2f %9.2f\n", times[i].name.c_str(), 1e3 * common::percentile(timings[i], 0.5), 1e3 * common::percentile(timings[i], 0.95));
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

//! @return number of findings
int printFindings(const Options& options, const Run& run)
{
    const std::vector<std::string> findings = common::SetupCheck(*run.sequence, run.tools).run(options.stereo);
    for (size_t i = 0; i < findings.size(); i++)
        std::fprintf(stderr, "check: %s\n", findings[i].c_str());
    return (int)findings.size();
}

//! @return the exit code: 2 if nothing was tracked; then what may be the cause is printed
int verdict(const Options& options, const Run& run)
{
    for (size_t i = 0; i < run.tools.size(); i++)
        if (run.tools[i].tracked > 0)
            return 0;
    if (printFindings(options, run) == 0)
        std::fprintf(stderr, "check: nothing was tracked, though units and calibration are plausible: is it this instrument (model), this arm (name), "
                     "this time (time_offset), and does the hand-eye calibration put it within some centimetres?\n");
    return 2;
}

int run(const CommandLineParser& parser)
{
    Run run;
    const Options options = readOptions(parser);
    prepare(options, run);
    if (options.check)
    {
        const int findings = printFindings(options, run);
        std::printf("%s: %d findings\n", run.sequence->name().c_str(), findings);
        return findings > 0;
    }
    if (options.stereo)
    {
        const std::string eyes = common::SetupCheck::eyesFault(*run.sequence);
        if (!eyes.empty())
            std::fprintf(stderr, "warning: %s\n", eyes.c_str());
    }
    if (options.findTimeOffset)
        findTimeOffset(options, run);
    try
    {
        track(options, run);
    }
    catch (const Exception&)   // what was tracked until then is written and summed up all the same
    {
        if (run.frames > 0)
            printSummary(run);
        throw;
    }
    printSummary(run);
    return verdict(options, run);
}

} // namespace

int main(int argc, char** argv)
{
    const common::Program program = { "track_sequence", "Tracks the tools of a recorded sequence by their CAD models and joint readings.",
                                      KEYS, { "sequence", "poses", "video", "method", "start", "frames", "time-offset", "timings", "debug", "debug-frames" },
                                      { "stereo", "render-ahead", "check", "quiet" } };
    return common::runProgram(argc, argv, program, run);
}
