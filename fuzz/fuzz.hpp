// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_FUZZ_HPP
#define OPENCV_SURGTRACK_FUZZ_HPP

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#ifndef _WIN32
#include <unistd.h>
#endif
#include "opencv2/core.hpp"
#include "opencv2/core/utils/logger.hpp"

// A target gives any bytes to a parser: it answers, or throws a cv::Exception that names the file. Whatever else happens is a fault.

//! A file of these bytes, the same for all inputs of a process.
class Input
{
public:
    Input(const uint8_t* data, size_t size, const char* extension) : name_(folder() + "/input" + std::to_string(getpid()) + extension)
    {
        FILE* file = std::fopen(name_.c_str(), "wb");
        if (!file || std::fwrite(data, 1, size, file) != size || std::fclose(file) != 0) std::abort();
    }
    ~Input() { std::remove(name_.c_str()); }
    const std::string& name() const { return name_; }

    template <typename Read> void give(const Read& read) const
    {
        cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
        static cv::ErrorCallback quiet = cv::redirectError([](int, const char*, const char*, const char*, int, void*) { return 0; });
        (void)quiet;
        try
        {
            read(name_);
        }
        catch (const cv::Exception& e)
        {
            if (e.err.find(name_) == std::string::npos)
            {
                std::fprintf(stderr, "does not name the file: %s\n", e.what());
                std::abort();
            }
        }
    }

private:
    static std::string folder()
    {
        const char* chosen = std::getenv("FUZZ_FOLDER");   // better in memory
        return chosen ? chosen : "/tmp";
    }
    std::string name_;
};

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);

#define FUZZ_FILE(extension, read)                                              \
    extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)     \
    {                                                                           \
        Input(data, size, extension).give(read);                                \
        return 0;                                                               \
    }

#endif
