// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_TEST_DATA_HPP
#define OPENCV_SURGTRACK_TEST_DATA_HPP

#include "test_precomp.hpp"
#include <cstdlib>
#include "opencv2/core/utils/filesystem.hpp"

namespace opencv_test { namespace {

// SURGTRACK_DATA; empty if it is not set.
inline String dataFolder()
{
    const char* const data = std::getenv("SURGTRACK_DATA");
    return data ? data : "";
}

// A file or folder of the recorded data; the test is skipped without.
inline String recorded(const String& name)
{
    const String folder = dataFolder(), path = cv::utils::fs::join(folder, name);
    if (folder.empty() || !cv::utils::fs::exists(path)) throw SkipTestException("SURGTRACK_DATA does not name a folder that has " + name);
    return path;
}

}} // namespace

#endif
