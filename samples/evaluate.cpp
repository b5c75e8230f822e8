// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Measures the tracker on sequences whose truth is known, or keypoints in them: the tables and figures of Ye et al. 2016, Sec. 3, and whether the filter is
// as good as it says.

#include "evaluation/baselines/baselines.hpp"
#include "evaluation/given_poses.hpp"
#include "evaluation/report.hpp"

using namespace cv;
using namespace cv::surgtrack;
using namespace evaluation;

namespace {

const char* const NAME = "evaluate";
const char* const KEYS =
    "{ help h    |                 | print this }"
    "{ sequences |                 | folders of sequences with groundtruth.csv, or labels in keypoints.csv, separated by commas; other folders are searched for such }"
    "{ out       |                 | folder to write; is made if it does not exist. Sequences whose results are there already are not run again }"
    "{ methods   | full,paper,epnp | methods to evaluate, separated by commas: full, paper, epnp. Worst frames are those of the first }"
    "{ frames    | 0               | number of frames of each sequence, 0 = to the end of the video }"
    "{ stereo    |                 | method full a second time with the right image, where there is one }"
    "{ baselines |                 | systems that the paper compares with, separated by commas: gradboost, reiter2014, reiter2012; or that start from the true pose: contour, and rapid if opencv_contrib's is in the build }"
    "{ train     |                 | folders of sequences with truth that the baselines learn from, separated by commas; none of a tested video. reiter2012 rejects by colour if there are some, the others need them }"
    "{ leave-out |                 | of --train those with the tested video are left out, a sequence at a time, not refused }"
    "{ parts     | logo_pivot,logo_s,shaft_pivot | classes of parts that gradboost learns and detectors are compared by; default: those of the paper }"
    "{ rounds    | 200             | that gradboost learns }"
    "{ no-early-stopping |         | gradboost looks at all of them everywhere }"
    "{ trees     | 60              | of reiter2014 }"
    "{ hypotheses | coarse         | of reiter2012: coarse, 405, or fine, 3645 }"
    "{ poses     |                 | NAME:FILE[,NAME:FILE...]: poses of other programs beside ours, files as track_sequence writes; a folder instead of FILE has a SEQUENCE.csv each }"
    "{ part      |                 | write no tables: one of several processes with a share of the sequences each, --merge comes last }"
    "{ merge     |                 | run nothing: tables of the results that are in --out }"
    "{ quiet     |                 | no progress }";

struct Options
{
    std::vector<String> sequences, methods;
    BaselineOptions baselines;
    std::vector<GivenPoses> poses;
    String out;
    int frames;
    bool stereo, part, merge, quiet;
};

std::vector<String> split(const CommandLineParser& parser, const char* name)
{
    const String text = parser.get<String>(name);
    std::vector<String> parts;
    size_t start = 0;
    for (size_t end = 0; end != String::npos; start = end + 1)
    {
        end = text.find(',', start);
        parts.push_back(text.substr(start, end == String::npos ? end : end - start));
        if (parts.back().empty())
            fail("argument '--" + String(name) + "=" + text + "': expected values separated by commas, none of them empty");
        if (std::count(parts.begin(), parts.end(), parts.back()) > 1)
            fail("argument '--" + String(name) + "=" + text + "': '" + parts.back() + "' is there twice");
    }
    return parts;
}

int methodOf(const String& name)
{
    return name == "full" ? METHOD_FULL : name == "paper" ? METHOD_PAPER : METHOD_EPNP;
}

void readBaselines(const CommandLineParser& parser, const std::vector<String>& sequences, BaselineOptions& options)
{
    options.rounds = common::integer(parser, "rounds", 1, 1000);
    options.trees = common::integer(parser, "trees", 1, 1000);
    options.parts = split(parser, "parts");
    options.early = !parser.has("no-early-stopping");
    options.leaveOut = parser.has("leave-out");
    options.quiet = parser.has("quiet");
    const String hypotheses = parser.get<String>("hypotheses");
    options.fine = hypotheses == "fine";
    if (!options.fine && hypotheses != "coarse")
        fail("argument '--hypotheses': '" + hypotheses + "', expected coarse or fine");
    if (!parser.get<String>("train").empty())
        options.train = findSequences(split(parser, "train"));
    if (!parser.get<String>("baselines").empty())
        options.names = split(parser, "baselines");
    static const char* const known[] = { "gradboost", "reiter2014", "reiter2012", "contour", "rapid" };
    for (size_t i = 0; i < options.names.size(); i++)
        if (std::find(known, known + 5, options.names[i]) == known + 5)
            fail("argument '--baselines': '" + options.names[i] + "' is no baseline, those available are gradboost, reiter2014, reiter2012, contour and rapid");
    if (options.train.empty() ? options.learns() : options.names.empty())
        fail("arguments '--baselines' and '--train': expected both of them or none");
    if (!options.leaveOut)
        checkLeaks(options.train, sequences);
}

Options readOptions(const CommandLineParser& parser)
{
    Options options;
    if (parser.get<String>("sequences").empty())
        fail("expected --sequences=DIR[,DIR...], see --help");
    if (parser.get<String>("out").empty())
        fail("expected --out=DIR, see --help");
    options.sequences = findSequences(split(parser, "sequences"));
    options.out = parser.get<String>("out");
    options.methods = split(parser, "methods");
    for (size_t i = 0; i < options.methods.size(); i++)
        if (options.methods[i] != "full" && options.methods[i] != "paper" && options.methods[i] != "epnp")
            fail("argument '--methods': '" + options.methods[i] + "' is no method, those available are full, paper and epnp");
    options.frames = common::integer(parser, "frames", 0);
    options.stereo = parser.has("stereo");
    if (options.stereo && std::find(options.methods.begin(), options.methods.end(), "full") == options.methods.end())
        fail("argument '--stereo': only method full uses the right image, expected it in --methods");
    options.part = parser.has("part");
    options.merge = parser.has("merge");
    if (options.part && options.merge)
        fail("arguments '--part' and '--merge': expected one of them, or none for both in turn");
    options.quiet = parser.has("quiet");
    readBaselines(parser, options.sequences, options.baselines);
    const std::vector<String> poses = parser.get<String>("poses").empty() ? std::vector<String>() : split(parser, "poses");
    for (size_t i = 0; i < poses.size(); i++)
        options.poses.push_back(GivenPoses::parse(poses[i]));
    return options;
}

//! Names a label that no other sequence has.
String uniqueLabel(const String& label, const Results& results)
{
    String candidate = label;
    for (int number = 2;; number++)
    {
        bool taken = candidate == "all";   // the rows of all sequences
        for (size_t i = 0; i < results.size(); i++)
            taken = taken || results[i]->label == candidate;
        if (!taken)
            return candidate;
        candidate = label + format("-%d", number);
    }
}

Run track(const Data& data, const String& name, const Options& options, bool stereo)
{
    if (!options.quiet)
        std::fprintf(stderr, "%s: %s\n", data.label.c_str(), methodTitle(name).c_str());
    const String method = stereo ? String("full") : name;
    TrackedRun run(data, name, methodOf(method), stereo, method == options.methods[0]);
    return run.track(options.frames, options.quiet);
}

void evaluateSequence(const Options& options, const String& folder, const Data& data, Baselines& baselines, Result& result)
{
    result.label = data.label;
    result.width = data.sequence->leftCamera().imageSize().width;
    for (size_t i = 0; i < data.tools.size(); i++)
    {
        result.tools.push_back(data.tools[i].info.name);
        result.coordinates.push_back(data.tools[i].model->coordinateNames());
    }
    for (size_t i = 0; i < options.methods.size(); i++)
    {
        result.runs.push_back(track(data, options.methods[i], options, false));
        if (options.methods[i] == "full" && options.stereo && data.sequence->isStereo())
            result.runs.push_back(track(data, "full-stereo", options, true));
    }
    if (!data.hasPoses())
        return;   // the rest compares with true poses
    if (!options.quiet)
        std::fprintf(stderr, "%s: detection of parts\n", data.label.c_str());
    DetectionRun detection(data);
    result.detection = detection.run(options.frames, options.quiet);
    baselines.evaluate(folder, data, options.frames, result);
    result.runs.push_back(control(data, false, options.frames));
    result.runs.push_back(control(data, true, options.frames));
}

//! Poses that other programs have of the sequence, before the controls: they are read when tables are made, and so may change.
void addPoses(const Options& options, const String& folder, Result& result)
{
    Data data;
    for (size_t i = 0; i < options.poses.size(); i++)
    {
        const String file = options.poses[i].fileOf(folder), name = options.poses[i].name;
        if (find(result, name))
            fail("argument '--poses': '" + name + "' is the name of a method already");
        if (file.empty())
            continue;
        if (!data.sequence)
            data.load(folder);
        if (!data.hasPoses())
            return;   // nothing to compare with
        const Run run = PosesFile::read(data, name, file, options.frames);
        result.runs.insert(result.runs.end() - 2, run);
    }
}

//! Those of an earlier evaluation, whose sequences may have had other labels.
void removeFiles(const String& folder, const String& pattern)
{
    std::vector<String> files;
    utils::fs::glob(folder, pattern, files);
    for (size_t i = 0; i < files.size(); i++)
        std::remove(files[i].c_str());
}

void writeAll(const Options& options, const Results& results, const std::vector<std::string>& failures)
{
    const String& out = options.out;
    removeFiles(out, "frames_*.csv");
    removeFiles(out, "worst_*.png");
    writeScores(utils::fs::join(out, "table.csv"), results);
    TextFile table(utils::fs::join(out, "table.md"));
    table << scoreTable(results);
    table.finish();
    writeDetections(utils::fs::join(out, "detection.csv"), results);
    writeLabels(out, results);
    writeMeasures(utils::fs::join(out, "measures.csv"), results);
    writeAxes(utils::fs::join(out, "rotation_axes.csv"), results);
    writeConsistency(utils::fs::join(out, "consistency.csv"), results);
    writeTimings(utils::fs::join(out, "timings.csv"), results);
    for (size_t i = 0; i < results.size(); i++)
        for (size_t j = 0; j < results[i]->runs.size(); j++)
        {
            const Run& run = results[i]->runs[j];
            writeFrames(utils::fs::join(out, "frames_" + results[i]->label + "_" + run.method + ".csv"), *results[i], run);
        }
    writeWorst(out, results);
    writeReport(utils::fs::join(out, "report.md"), results, failures);
}

//! What other options make another result. @param models of the baselines; empty: there are none
String settingsOf(const Options& options, const String& models)
{
    String settings = format("%d frames%s", options.frames, options.stereo ? ", stereo" : "");
    for (size_t i = 0; i < options.methods.size(); i++)
        settings += " " + options.methods[i];
    return models.empty() ? settings : settings + "," + models;
}

//! Leaves NAME.yml.gz, or, if the sequence can't be evaluated, NAME.failed with the reason.
void makeResult(const Options& options, const String& folder, const String& name, Baselines& baselines)
{
    std::remove((name + ".failed").c_str());
    std::string error;
    try
    {
        Data data;
        data.load(folder);
        Result result;
        evaluateSequence(options, folder, data, baselines, result);
        save(name + ".yml.gz", result);
        return;
    }
    catch (...)
    {
        error = common::errorLine();
    }
    TextFile file(name + ".failed");
    file << (error.find(folder) == std::string::npos ? folder + ": " + error : error) + "\n";
    file.finish();
}

//! Why there is no result; nothing if there is one.
String failureOf(const Options& options, const String& folder, const String& name)
{
    if (utils::fs::exists(name + ".yml.gz"))
        return String();
    std::ifstream file((name + ".failed").c_str());
    std::string line;
    return std::getline(file, line) ? line : folder + ": has no result in " + options.out + ", expected one of a run with --part and the same other options";
}

//! Evaluates and writes. Returns the exit code: 1 if a sequence failed.
int run(const CommandLineParser& parser)
{
    const Options options = readOptions(parser);
    const String folder = utils::fs::join(options.out, "results");
    if (!utils::fs::createDirectories(folder) || !utils::fs::isDirectory(folder))
        fail("argument '--out=" + options.out + "': the folder can't be made");
    const String probe = partOf(utils::fs::join(folder, "probe"));   // better now than after an hour
    TextFile(probe).finish();
    std::remove(probe.c_str());
    Baselines baselines(options.baselines, utils::fs::join(options.out, "models"));
    Results results;
    std::vector<std::string> failures;
    for (size_t i = 0; i < options.sequences.size(); i++)
    {
        const String& sequence = options.sequences[i];
        const String name = resultName(folder, sequence, settingsOf(options, baselines.settings(sequence)));
        if (!options.merge && !utils::fs::exists(name + ".yml.gz"))
            makeResult(options, sequence, name, baselines);
        else if (!options.quiet && !options.merge)
            std::fprintf(stderr, "%s: is in %s already\n", sequence.c_str(), folder.c_str());
        const String failure = failureOf(options, sequence, name);
        if (!failure.empty())
        {
            common::reportError(NAME, failure);
            failures.push_back(failure);
        }
        else if (!options.part)
        {
            const Ptr<Result> result = makePtr<Result>();
            load(name + ".yml.gz", *result);
            result->label = uniqueLabel(result->label, results);
            addPoses(options, sequence, *result);
            results.push_back(result);
        }
    }
    if (!results.empty())
    {
        writeAll(options, results, failures);
        std::printf("%s%s", scoreTable(results).c_str(), speedLine(results).c_str());
        std::fflush(stdout);
    }
    return failures.empty() ? 0 : 1;
}

} // namespace

int main(int argc, char** argv)
{
    const common::Program program = { NAME, "Measures the tracker on sequences whose truth is known; writes tables, frame by frame errors and report.md.\n"
                                      "plot_evaluation.py makes the plots.",
                                      KEYS, { "sequences", "out", "methods", "frames", "baselines", "train", "parts", "rounds", "trees", "hypotheses", "poses" },
                                      { "stereo", "leave-out", "no-early-stopping", "part", "merge", "quiet" } };
    return common::runProgram(argc, argv, program, run);
}
