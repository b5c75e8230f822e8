// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include <cstring>
#include <fstream>
#include <iterator>
#include <vector>
#include "fuzz.hpp"
#include "opencv2/core/utils/filesystem.hpp"

// Where there is no libFuzzer: every file of a folder, and what becomes of it by changes at random, the same for the same seed.
//   fuzz_ply [-runs=N] [-max_total_time=SECONDS] [-seed=N] FOLDER

static long option(const char* argument, const char* name, long value)
{
    const size_t n = std::strlen(name);
    return std::strncmp(argument, name, n) == 0 ? std::atol(argument + n) : value;
}

static std::string changed(std::string text, const std::string& other, cv::RNG& rng)
{
    for (int k = rng.uniform(1, 8); k > 0; k--)
    {
        const size_t at = text.empty() ? 0 : rng.uniform(0, (int)text.size());
        const size_t length = std::min((size_t)rng.uniform(1, 32), text.size() - at), from = other.empty() ? 0 : rng.uniform(0, (int)other.size());
        switch (rng.uniform(0, 5))
        {
        case 0: if (!text.empty()) text[at] = (char)rng.uniform(0, 256); break;
        case 1: text.erase(at, length); break;
        case 2: text.insert(at, other.substr(from, rng.uniform(1, 32))); break;
        case 3: for (int n = rng.uniform(1, 1 << rng.uniform(1, 10)); n > 0; n--) text.insert(at, text.substr(at, 1)); break;
        default: text.resize(at);
        }
    }
    return text;
}

int main(int argc, char** argv)
{
    long runs = 1000, seconds = 0, seed = 1;
    std::vector<std::string> corpus;
    for (int i = 1; i < argc; i++)
    {
        runs = option(argv[i], "-runs=", runs);
        seconds = option(argv[i], "-max_total_time=", seconds);
        seed = option(argv[i], "-seed=", seed);
        if (argv[i][0] == '-') continue;
        std::vector<cv::String> files;
        cv::utils::fs::glob(argv[i], "", files);
        for (size_t f = 0; f < files.size(); f++)
        {
            std::ifstream file(files[f].c_str(), std::ios::binary);
            corpus.push_back(std::string(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()));
        }
    }
    if (corpus.empty())
    {
        std::fprintf(stderr, "expected a folder with inputs\n");
        return 1;
    }
    cv::RNG rng(seed);
    const int64 start = cv::getTickCount();
    long done = 0;
    for (; seconds > 0 || done < runs; done++)
    {
        if (seconds > 0 && (double)(cv::getTickCount() - start) / cv::getTickFrequency() > (double)seconds) break;
        const std::string& one = corpus[done < (long)corpus.size() ? done : rng.uniform(0, (int)corpus.size())];
        const std::string text = done < (long)corpus.size() ? one : changed(one, corpus[rng.uniform(0, (int)corpus.size())], rng);
        std::ofstream("replay.input", std::ios::binary) << text;   // what is left behind is what it fell over
        LLVMFuzzerTestOneInput(reinterpret_cast<const uint8_t*>(text.data()), text.size());
    }
    std::remove("replay.input");
    std::printf("%ld inputs\n", done);
    return 0;
}
