// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Tracks as it happens: images of a camera, or of a video played at its pace, joint readings by UDP; poses go out by UDP and to a file.

#include <limits>
#include "live/images.hpp"
#include "live/window.hpp"
#include "support/run_output.hpp"
#include "support/tools.hpp"

using namespace cv;
using namespace cv::surgtrack;
using common::fail;
using common::Tool;

namespace {

const char* const KEYS =
    "{ help h      |       | print this }"
    "{ sequence    |       | folder with sequence.yaml: camera, tools and hand-eye calibration; its CSV files are not read }"
    "{ joints      | 48051 | UDP ports of the joint readings, PORT or TOOL:PORT, separated by commas; TOOL if the messages do not say }"
    "{ listen      | 127.0.0.1 | address of this machine that readings come to; 0.0.0.0: any }"
    "{ from        |       | address that readings are taken from; default: any }"
    "{ camera      |       | images of this camera, a number or an address such as rtsp://...; two, separated by a comma, with --stereo. "
    "Without it the video of sequence.yaml is played }"
    "{ stereo      |       | use the right image too }"
    "{ fps         |       | images a second: the video is played at this pace, a camera asked for it; default that of sequence.yaml }"
    "{ time-offset | 0     | the joints that belong to the image of time t were recorded at t + SECONDS; a camera's images arrive late: "
    "about -0.05 for one }"
    "{ send        |       | HOST:PORT to send poses to, JSON by UDP }"
    "{ poses       |       | CSV file to write the poses to }"
    "{ show        |       | a window with the tools where they are found; Esc ends }"
    "{ frames      | 0     | stop after so many images, 0 = go on }"
    "{ quiet       |       | no progress }";

const double PATIENCE = 10;     // for the first readings [s]
const double LONGEST_WAIT = 60; // until the robot's clock shows the time of the first image of a video [s]
const double WAIT = 0.05;       // for the reading after an image [s]: some packets at 100 Hz may be lost
const double DRAW_UNTIL = 2. / 3;    // after an image [interval]; later, drawing for the next one would slow its tracking down
const double SILENCE = 1;       // without an image that has readings, until it is said [s]

struct Options
{
    String sequence, poses, send, listen, from;
    std::vector<common::JointPort> ports;
    std::vector<std::string> cameras;    // empty: the video
    double fps, timeOffset;
    int frames;
    bool stereo, show, quiet;
};

std::vector<std::string> split(const std::string& text)
{
    std::vector<std::string> parts(1);
    for (size_t i = 0; i < text.size(); i++)
        if (text[i] == ',') parts.push_back("");
        else parts.back() += text[i];
    return parts;
}

std::vector<common::JointPort> readPorts(const std::string& text)
{
    std::vector<common::JointPort> ports;
    const std::vector<std::string> parts = split(text);
    for (size_t i = 0; i < parts.size(); i++)
    {
        const size_t colon = parts[i].rfind(':');
        const std::string number = colon == std::string::npos ? parts[i] : parts[i].substr(colon + 1);
        const common::JointPort port = { std::atoi(number.c_str()), colon == std::string::npos ? "" : parts[i].substr(0, colon) };
        if (number.empty() || number.size() > 5 || number.find_first_not_of("0123456789") != std::string::npos || port.port < 1 || port.port > 65535)
            fail("argument '--joints=" + text + "': expected ports from 1 to 65535, such as 48051 or PSM1:48051,PSM2:48052");
        ports.push_back(port);
    }
    return ports;
}

Options readOptions(const CommandLineParser& parser)
{
    Options options;
    options.sequence = parser.get<String>("sequence");
    if (options.sequence.empty())
        fail("expected --sequence=DIR, see --help");
    options.poses = parser.get<String>("poses");
    options.send = parser.get<String>("send");
    options.listen = parser.get<String>("listen");
    options.from = parser.get<String>("from");
    options.ports = readPorts(parser.get<String>("joints"));
    options.stereo = parser.has("stereo");
    if (parser.has("camera"))
        options.cameras = split(parser.get<String>("camera"));
    options.fps = parser.has("fps") ? common::number(parser, "fps", 0.1, 1000) : 0;
    options.timeOffset = common::number(parser, "time-offset", -1e12, 1e12);
    options.frames = common::integer(parser, "frames", 0);
    options.show = parser.has("show");
    options.quiet = parser.has("quiet");
    return options;
}

//! What became of an image.
enum Answer { TRACKED, TOO_SLOW, NO_READINGS };

struct Run
{
    Ptr<Sequence> setup;
    std::vector<Tool> tools;
    Ptr<ToolTracker> tracker;
    Ptr<common::LiveImages> images;
    Ptr<common::JointStream> joints;
    Ptr<PoseWriter> writer;
    Ptr<common::UdpSender> sender;
    Ptr<common::LiveWindow> window;
    bool live;
    double timeOffset, interval;    // interval: between images [s]
    std::vector<ToolEstimate> estimates;             // of the last image
    std::vector<std::vector<double> > readings;      // of the last image that was tracked; 0 before
    double time;                                     // of that image, on the tracker's clock [s]
    int answers[3], reasons[5];                      // images, by Answer, and those without readings by JointsState
    std::vector<double> waits, updates, latencies;   // an image that was tracked [s]
};

String joined(const std::vector<std::string>& words)
{
    String result;
    for (size_t i = 0; i < words.size(); i++) result += (i ? "," : "") + words[i];
    return result;
}

//! Time of an image for the tracker [s].
double imageTime(const Run& run, int number, double arrival) { return run.live ? arrival : number / run.setup->fps(); }

//! When the joints of an image were read, on the clock of a tool.
double readingTime(const Run& run, int tool, double time) { return (run.live ? run.joints->robotTime(tool, time) : time) + run.timeOffset; }

std::vector<double> readingTimes(const Run& run, double time)
{
    std::vector<double> times;
    for (size_t i = 0; i < run.tools.size(); i++) times.push_back(readingTime(run, (int)i, time));
    return times;
}

void prepare(const Options& options, Run& run)
{
    std::vector<JointReading> none;
    parseJointMessage("{}", none);    // throws if the module was built without what it takes
    run.setup = Sequence::load(options.sequence, false);
    run.live = !options.cameras.empty();
    const double fps = options.fps > 0 ? options.fps : run.setup->fps();
    run.interval = 1 / fps;
    run.timeOffset = options.timeOffset;
    run.time = -DBL_MAX;
    std::fill(run.answers, run.answers + 3, 0);
    std::fill(run.reasons, run.reasons + 5, 0);
    std::vector<std::string> sources = run.live ? options.cameras : std::vector<std::string>(1, run.setup->leftVideo());
    run.tracker = ToolTracker::create(run.setup->leftCamera());
    if (options.stereo)
    {
        if (run.setup->rightCamera().imageSize().empty())
            fail("argument '--stereo': " + options.sequence + " has one camera, expected 'right' and 'right_T_left' in its sequence.yaml");
        run.tracker->setRightCamera(run.setup->rightCamera(), run.setup->right_T_left());
        if (!run.live && run.setup->layout() == LAYOUT_SEPARATE) sources.push_back(run.setup->rightVideo());
    }
    if (sources.size() != (options.stereo && run.setup->layout() == LAYOUT_SEPARATE ? 2u : 1u))
        fail("argument '--camera=" + joined(sources) + "': expected " + (!options.stereo ? "one camera" : run.setup->layout() == LAYOUT_SEPARATE ?
             "two cameras, separated by a comma" : "one camera: by layout in sequence.yaml both eyes are in one image"));
    common::setMasks(*run.setup, *run.tracker, options.stereo);
    for (size_t i = 0; i < sources.size(); i++)
        if (sources[i].empty())
            fail("expected --camera=..., or the key 'video' in sequence.yaml of " + options.sequence);

    run.tools = common::loadTools(*run.setup);
    const std::vector<String> names = common::namesOf(run.tools);
    std::vector<std::vector<String> > coordinates;
    for (size_t i = 0; i < run.tools.size(); i++)
    {
        run.tracker->addTool(run.tools[i].model, run.tools[i].info.nominal_T_base);
        coordinates.push_back(run.tools[i].model->coordinateNames());
        run.readings.push_back(std::vector<double>(coordinates.back().size()));
    }
    for (size_t i = 0; i < options.ports.size(); i++)
        if (!options.ports[i].tool.empty() && std::find(names.begin(), names.end(), options.ports[i].tool) == names.end())
            fail("argument '--joints': tool '" + options.ports[i].tool + "' is none of the tools of sequence.yaml");
    run.images = makePtr<common::LiveImages>(sources, run.setup, options.stereo, run.live, fps);
    if (options.show)
        run.window = makePtr<common::LiveWindow>();   // better now than at the first image
    if (!options.send.empty())
        run.sender = makePtr<common::UdpSender>(options.send);
    if (!options.poses.empty())
        run.writer = PoseWriter::create(options.poses, names, common::modelsOf(run.tools), { "dropped", "latency" });
    run.joints = makePtr<common::JointStream>(options.ports, options.listen, options.from, names, coordinates, run.live ? 1 : fps / run.setup->fps());
}

//! Images begin with the readings: those of a video come when the robot's clock has their time.
void start(const Options& options, Run& run)
{
    if (!options.quiet)
        std::fprintf(stderr, "waiting for joint readings\n");
    const int missing = run.joints->waitForAll(PATIENCE, common::interrupted());
    if (missing >= 0 && !common::interrupted())
    {
        const common::JointStream::Counts counts = run.joints->counts();
        const std::string complaint = run.joints->complaint();
        fail(format("no joint readings of tool '%s' in %g s; to %s came %d messages with readings, %d without, %d malformed%s%s",
                    run.tools[missing].info.name.c_str(), PATIENCE, options.listen.c_str(), counts.readings, counts.others, counts.malformed, complaint.empty() ? "" : ", the first one: ", complaint.c_str()));
    }
    double first = run.joints->localTime(0, run.timeOffset);
    const double end = common::now() + PATIENCE;    // the first stamps may be wrong
    while (!run.live && first - common::now() > LONGEST_WAIT && !common::interrupted())
    {
        if (common::now() > end)
            fail(format("the robot's clock is %g s before the first image of the video, expected readings with the stamps of its recording", first - common::now()));
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
        first = run.joints->localTime(0, run.timeOffset);
    }
    run.images->start(first, options.frames);
}

//! The poses of an image that was not tracked: those of its readings if there are some, with what was known before.
void coast(Run& run, double time)
{
    std::vector<std::vector<double> > readings;
    const bool found = run.joints->at(readingTimes(run, time), 0, readings) == JOINTS_FOUND;
    run.estimates.resize(run.tools.size());
    for (size_t i = 0; i < run.tools.size(); i++)
    {
        const std::vector<double>& joints = found ? readings[i] : run.readings[i];
        const int before = run.estimates[i].state;
        const int state = before == STATE_INITIALIZING ? before : before == STATE_LOST || !found ? (int)STATE_LOST : (int)STATE_COASTING;
        run.estimates[i] = common::unmeasured(run.tools[i], joints, state, run.estimates[i]);
    }
}

//! arrival: of an image that was tracked
void record(Run& run, int number, double time, Answer answer, double arrival)
{
    const double reported = run.live ? readingTime(run, 0, time) : time;
    run.answers[answer]++;
    if (run.sender && answer == TRACKED)
        for (size_t i = 0; i < run.tools.size(); i++)
            run.sender->send(formatPoseMessage(number, reported, run.tools[i].info.name, run.estimates[i]));
    const double latency = answer == TRACKED ? common::now() - arrival : std::numeric_limits<double>::quiet_NaN();
    if (answer == TRACKED)
        run.latencies.push_back(latency);
    for (size_t i = 0; i < run.tools.size(); i++)
    {
        run.tools[i].tracked += run.estimates[i].state == STATE_TRACKING;
        if (run.writer)
            run.writer->write(number, reported, run.tools[i].info.name, run.estimates[i], { (double)answer, latency });
    }
}

//! Templates of the next image are drawn beside the wait for it: of tools that go on as they went from the last image to this one.
void drawAhead(Run& run, const std::vector<std::vector<double> >& readings, double time)
{
    std::vector<std::vector<double> > next = readings;
    if (time - run.time < 0.2)   // [s]; an older motion says nothing
        for (size_t i = 0; i < next.size(); i++)
            for (size_t k = 0; k < next[i].size(); k++) next[i][k] += readings[i][k] - run.readings[i][k];
    run.tracker->renderAhead(next);
}

Answer answer(Run& run, const common::LiveImage& image)
{
    const double time = imageTime(run, image.number, image.arrival), begin = common::now();
    std::vector<std::vector<double> > readings;
    const int state = run.joints->at(readingTimes(run, time), WAIT, readings);
    if (state != JOINTS_FOUND)
    {
        run.reasons[state]++;
        coast(run, time);
        record(run, image.number, time, NO_READINGS, image.arrival);
        return NO_READINGS;
    }
    const double found = common::now();
    if (image.right.empty())
        run.tracker->update(image.left, time, readings, run.estimates);
    else
        run.tracker->updateStereo(image.left, image.right, time, readings, run.estimates);
    run.waits.push_back(found - begin);
    run.updates.push_back(common::now() - found);
    record(run, image.number, time, TRACKED, image.arrival);
    if (common::now() < image.arrival + DRAW_UNTIL * run.interval)
        drawAhead(run, readings, time);
    run.readings.swap(readings);
    run.time = time;
    return TRACKED;
}

void track(const Options& options, Run& run)
{
    common::Progress progress(options.frames, options.quiet);
    common::LiveImage image;
    int next = 0;               // image
    double last = 0, spoken = common::now();
    while (!run.images->ended())
    {
        if (common::interrupted())
            run.images->stop();
        if (!run.images->take(image))
            continue;
        const double time = imageTime(run, image.number, image.arrival);
        for (int first = next; next < image.number; next++)
        {
            const double missed = first == 0 ? time : last + (time - last) * (next - first + 1) / (image.number - first + 1);
            const double t = run.live ? missed : imageTime(run, next, 0);
            coast(run, t);
            record(run, next, t, TOO_SLOW, 0);
        }
        if (answer(run, image) == TRACKED)
            spoken = common::now();
        else if (common::now() - spoken > SILENCE && !options.quiet)
        {
            std::fprintf(stderr, "no joint readings at the time of the images for %g s\n", SILENCE);
            spoken = common::now();
        }
        if (run.window && !run.window->show(image.left, run.setup->leftCamera(), run.tools, run.estimates))
            run.images->stop();
        last = time;
        next = image.number + 1;
        progress.show(next);
    }
}

void printTimes(const char* name, const std::vector<double>& values)
{
    std::printf("  %-22s %8.2f %8.2f %8.2f\n", name, 1e3 * common::percentile(values, 0.5), 1e3 * common::percentile(values, 0.95), 1e3 * common::percentile(values, 1));
}

void printSummary(const Run& run)
{
    const int images = run.answers[TRACKED] + run.answers[TOO_SLOW] + run.answers[NO_READINGS];
    std::printf("%s: %d images, %d answered, %d dropped for a newer one, %d dropped without joint readings\n", run.setup->name().c_str(), images,
                run.answers[TRACKED], run.answers[TOO_SLOW], run.answers[NO_READINGS]);
    if (run.answers[NO_READINGS])
        std::printf("  without readings: %d from before the oldest ones kept, %d still to come after %g ms, %d more than 0.1 s apart\n",
                    run.reasons[JOINTS_NONE] + run.reasons[JOINTS_TOO_OLD], run.reasons[JOINTS_TOO_NEW], 1e3 * WAIT, run.reasons[JOINTS_GAP]);
    for (size_t i = 0; i < run.tools.size(); i++)
        std::printf("  %-8s tracked in %.1f %% of the images\n", run.tools[i].info.name.c_str(), images ? 100. * run.tools[i].tracked / images : 0.);
    const common::JointStream::Counts counts = run.joints->counts();
    const std::string complaint = run.joints->complaint();
    std::printf("messages: %d with joint readings, %d readings too late or twice, %d with stamps of another clock, %d too large or too many, "
                "%d about other things, %d malformed%s%s\n", counts.readings, counts.late, counts.strange, counts.flood, counts.others, counts.malformed, complaint.empty() ? "" : ", the first one: ", complaint.c_str());
    std::printf("time of an image [ms]      median     95 %%      max\n");
    printTimes("waiting for joints", run.waits);
    printTimes("tracking", run.updates);
    printTimes("latency, image to pose", run.latencies);
    std::fflush(stdout);
}

int run(const CommandLineParser& parser)
{
    common::catchInterrupts();
    const Options options = readOptions(parser);
    Run run;
    prepare(options, run);
    start(options, run);
    try
    {
        track(options, run);
    }
    catch (const Exception&)   // what was tracked until then is summed up all the same
    {
        printSummary(run);
        throw;
    }
    printSummary(run);
    return 0;
}

} // namespace

int main(int argc, char** argv)
{
    const common::Program program = { "live", "Tracks the tools a camera sees now, by their CAD models and the joint readings a robot sends.",
                                      KEYS, { "sequence", "joints", "listen", "from", "camera", "fps", "time-offset", "send", "poses", "frames" }, { "stereo", "show", "quiet" } };
    return common::runProgram(argc, argv, program, run);
}
