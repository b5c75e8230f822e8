// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_TEST_IMPORT_HPP
#define OPENCV_SURGTRACK_TEST_IMPORT_HPP

#include "test_common.hpp"
#include "opencv2/core/utils/filesystem.hpp"

namespace opencv_test { namespace {

// A folder for small files, removed again.
class ImportTest : public testing::Test
{
protected:
    void SetUp() CV_OVERRIDE
    {
        folder = cv::tempfile("");
        ASSERT_TRUE(cv::utils::fs::createDirectories(folder));
    }
    void TearDown() CV_OVERRIDE { cv::utils::fs::remove_all(folder); }

    String path(const String& name) const { return cv::utils::fs::join(folder, name); }

    // @return its path
    String put(const String& name, const String& text) const
    {
        std::ofstream file(path(name).c_str(), std::ios::binary);
        file << text;
        CV_Assert(file.good());
        return path(name);
    }

    String get(const String& name) const
    {
        std::ifstream file(path(name).c_str(), std::ios::binary);
        std::ostringstream text;
        text << file.rdbuf();
        return text.str();
    }

    String folder;
};

inline std::vector<String> list(const String& a) { return std::vector<String>(1, a); }

inline std::vector<String> list(const String& a, const String& b)
{
    const String both[] = { a, b };
    return std::vector<String>(both, both + 2);
}

// The module may have been built without the library a format needs.
template <typename Call> auto orSkip(const Call& call) -> decltype(call())
{
    try
    {
        return call();
    }
    catch (const cv::Exception& e)
    {
        if (e.code == Error::StsNotImplemented)
            throw SkipTestException(e.err);
        throw;
    }
}

inline String replaced(String text, const String& what, const String& by)
{
    const size_t at = text.find(what);
    CV_Assert(at != String::npos);
    return text.replace(at, what.size(), by);
}

inline std::vector<double> randomJoints(const ToolModel& tool, RNG& rng)
{
    std::vector<double> q;
    for (size_t i = 0; i < tool.coordinateNames().size(); ++i)
        q.push_back(rng.uniform(-1.2, 1.2));
    return q;
}

inline int linkIndex(const ToolModel& tool, const String& name)
{
    const std::vector<String> names = tool.linkNames();
    const int index = (int)(std::find(names.begin(), names.end(), name) - names.begin());
    CV_Assert(index < (int)names.size());
    return index;
}

}} // namespace

#endif
