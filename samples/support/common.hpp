// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// What the samples share: strict command lines, one-line errors, progress, checked video files.

#ifndef OPENCV_SURGTRACK_SAMPLES_SUPPORT_COMMON_HPP
#define OPENCV_SURGTRACK_SAMPLES_SUPPORT_COMMON_HPP

#include <algorithm>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <set>
#include <string>
#include <vector>
#ifdef _WIN32
#include <io.h>
#else
#include <unistd.h>
#endif
#include "opencv2/core.hpp"
#include "opencv2/core/utility.hpp"
#include "opencv2/core/utils/logger.hpp"
#include "opencv2/surgtrack/names.hpp"

namespace common {

//! Set by Ctrl-C.
inline volatile std::sig_atomic_t& interrupted()
{
    static volatile std::sig_atomic_t flag = 0;
    return flag;
}

inline void onInterrupt(int signal)
{
    interrupted() = 1;
    std::signal(signal, SIG_DFL);    // the second one ends the program
}

//! From now on the program ends by itself after Ctrl-C, as interrupted() tells it to.
inline void catchInterrupts()
{
    std::signal(SIGINT, onInterrupt);
    std::signal(SIGTERM, onInterrupt);
}

// An error of the command line or of the data; the text is the line the user gets.
CV_NORETURN inline void fail(const std::string& line)
{
    throw cv::Exception(cv::Error::StsError, line, "", "", 0);
}

inline int ignoreError(int, const char*, const char*, const char*, int, void*) { return 0; }

// Errors are printed once, by the sample: not by OpenCV's log and FFmpeg's as well.
inline void silenceLibraries()
{
    cv::redirectError(ignoreError);
    cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
#ifndef _WIN32
    setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", 0);
#endif
}

//! The message of the exception that is being handled, in one line.
inline std::string errorLine()
{
    std::string line;
    try
    {
        throw;
    }
    catch (const cv::Exception& e)
    {
        line = e.err.empty() ? e.what() : e.err;
    }
    catch (const std::exception& e)
    {
        line = e.what();
    }
    std::replace(line.begin(), line.end(), '\n', ' ');
    return line;
}

inline int reportError(const char* program, const std::string& line = errorLine())
{
    std::fprintf(stderr, "%s: %s\n", program, line.c_str());
    return 1;
}

// cv::CommandLineParser passes over what it does not know; here that is an error.
// options: names of the options with a value; flags: names of those without.
inline void checkCommandLine(int argc, char** argv, const std::vector<std::string>& options, const std::vector<std::string>& flags)
{
    for (int i = 1; i < argc; i++)
    {
        const std::string argument = argv[i];
        if (argument == "-h") continue;
        const size_t equals = argument.find('=');
        const std::string name = argument.compare(0, 2, "--") == 0 ? argument.substr(2, equals == std::string::npos ? equals : equals - 2) : "";
        const bool isFlag = std::find(flags.begin(), flags.end(), name) != flags.end();
        if (!isFlag && std::find(options.begin(), options.end(), name) == options.end())
        {
            std::vector<cv::String> known;
            for (size_t k = 0; k < options.size() + flags.size(); k++)
                known.push_back("--" + (k < options.size() ? options[k] : flags[k - options.size()]));
            fail("unknown argument '" + argument + "'" + cv::surgtrack::didYouMean(argument.substr(0, equals), known) + " see --help");
        }
        if (isFlag && equals != std::string::npos)
            fail("argument '" + argument + "': --" + name + " takes no value");
        if (!isFlag && (equals == std::string::npos || equals + 1 == argument.size()))
            fail("argument '" + argument + "': expected --" + name + "=VALUE");
    }
}

//! A sample, for main().
struct Program
{
    const char *name, *about;
    const char* keys;                            //!< of cv::CommandLineParser
    std::vector<std::string> options, flags;     //!< with a value, and without one
};

//! `--set A=1 --set=B=2` as `--set=A=1,B=2`, which cv::CommandLineParser can read; all else as it is.
inline std::vector<std::string> gatherSettings(int argc, char** argv)
{
    std::vector<std::string> arguments;
    std::string settings;
    for (int i = 0; i < argc; i++)
    {
        const std::string argument = argv[i];
        const bool apart = argument == "--set" && i + 1 < argc;
        if (apart || argument.compare(0, 6, "--set=") == 0)
            settings += (settings.empty() ? "--set=" : ",") + (apart ? std::string(argv[++i]) : argument.substr(6));
        else
            arguments.push_back(argument);
    }
    if (!settings.empty())
        arguments.push_back(settings);
    return arguments;
}

/** What main() of a sample does: --help, --version, or run(parser) with a checked command line; whatever goes wrong is one line on stderr.
@return the exit code: that of run() */
template <class Run> int runProgram(int argc, char** argv, Program program, Run run)
{
    silenceLibraries();
    try
    {
        program.flags.push_back("help");
        program.flags.push_back("version");
        std::vector<std::string> arguments = gatherSettings(argc, argv);
        std::vector<char*> pointers;
        for (size_t i = 0; i < arguments.size(); i++)
            pointers.push_back(&arguments[i][0]);
        checkCommandLine((int)pointers.size(), pointers.data(), program.options, program.flags);
        cv::CommandLineParser parser((int)pointers.size(), pointers.data(), std::string(program.keys) + "{ version | | print the version }");
        parser.about(program.about);
        if (parser.has("version"))
        {
            std::printf("%s, cv::surgtrack on OpenCV %s\n", program.name, CV_VERSION);
            return 0;
        }
        if (!parser.has("help"))
            return run(parser);
        parser.printMessage();
        return 0;
    }
    catch (...)
    {
        return reportError(program.name);
    }
}

inline double number(const cv::CommandLineParser& parser, const char* name, double least, double most)
{
    const std::string text = parser.get<std::string>(name);
    char* end = 0;
    const double value = std::strtod(text.c_str(), &end);
    if (end == text.c_str() || *end || !(value >= least && value <= most))
        fail(cv::format("argument '--%s=%s': expected a number from %g to %g", name, text.c_str(), least, most));
    return value;
}

inline int integer(const cv::CommandLineParser& parser, const char* name, int least, int most = INT_MAX)
{
    const std::string text = parser.get<std::string>(name);
    char* end = 0;
    errno = 0;
    const long value = std::strtol(text.c_str(), &end, 10);
    if (end == text.c_str() || *end || errno || value < least || value > most)
        fail(most == INT_MAX ? cv::format("argument '--%s=%s': expected a whole number from %d", name, text.c_str(), least)
                             : cv::format("argument '--%s=%s': expected a whole number from %d to %d", name, text.c_str(), least, most));
    return (int)value;
}

// Which frames are wanted, as --debug-frames says: `3,17,40`, or `every:25` from the first one on.
class FrameChoice
{
public:
    FrameChoice(const std::string& text, int first) : text_(text), first_(first), every_(0), seen_(false)
    {
        if (text.compare(0, 6, "every:") == 0)
            every_ = number(text.substr(6), 1);
        else
            for (size_t at = 0, comma; at <= text.size(); at = comma + 1)
            {
                comma = std::min(text.find(',', at), text.size());
                frames_.insert(number(text.substr(at, comma - at), 0));
            }
    }

    bool wants(int frame)
    {
        const bool wanted = every_ ? (frame - first_) % every_ == 0 : frames_.count(frame) > 0;
        seen_ = seen_ || wanted;
        return wanted;
    }

    // At the end: throws if there was none.
    void check() const
    {
        if (!seen_)
            fail("argument '--debug-frames=" + text_ + "': none of these frames was tracked");
    }

private:
    int number(const std::string& word, int least) const
    {
        char* end = 0;
        errno = 0;
        const long value = std::strtol(word.c_str(), &end, 10);
        if (end == word.c_str() || *end || errno || value < least || value > INT_MAX)
            fail("argument '--debug-frames=" + text_ + "': expected numbers of frames, as in 3,17,40, or every:N");
        return (int)value;
    }

    std::string text_;
    int first_, every_;
    std::set<int> frames_;
    bool seen_;
};

// A line on stderr that is written over itself, if stderr is a terminal.
class Progress
{
public:
    Progress(int total, bool quiet) : total_(total), start_(cv::getTickCount()), last_(0), shown_(false)
    {
#ifdef _WIN32
        enabled_ = !quiet && _isatty(_fileno(stderr));
#else
        enabled_ = !quiet && isatty(fileno(stderr));
#endif
    }
    ~Progress() { clear(); }

    void show(int done)
    {
        const double seconds = (double)(cv::getTickCount() - start_) / cv::getTickFrequency();
        if (!enabled_ || (seconds - last_ < 0.2 && done != total_))
            return;
        last_ = seconds;
        const double rate = seconds > 0 ? done / seconds : 0;
        const int eta = rate > 0 && total_ > done ? cvCeil((total_ - done) / rate) : 0;
        if (total_ > 0)
            std::fprintf(stderr, "\rframe %d of %d   %.1f frames/s   ETA %d:%02d   ", done, total_, rate, eta / 60, eta % 60);
        else
            std::fprintf(stderr, "\rframe %d   %.1f frames/s   ", done, rate);
        std::fflush(stderr);
        shown_ = true;
    }

    void clear()
    {
        if (shown_)
            std::fprintf(stderr, "\r%60s\r", "");
        shown_ = false;
    }

private:
    int total_;
    int64 start_;
    double last_;
    bool enabled_, shown_;
};

} // namespace common

#endif
