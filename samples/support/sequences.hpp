// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Which sequences a program is given.

#ifndef OPENCV_SURGTRACK_SAMPLES_SUPPORT_SEQUENCES_HPP
#define OPENCV_SURGTRACK_SAMPLES_SUPPORT_SEQUENCES_HPP

#include <algorithm>
#include "opencv2/core/utils/filesystem.hpp"

namespace common {

inline cv::String absolutePath(const cv::String& path)
{
    return cv::utils::fs::exists(path) ? cv::utils::fs::canonical(path) : path;
}

inline cv::String baseName(const cv::String& path)
{
    const size_t end = path.find_last_not_of("/\\"), slash = end == cv::String::npos ? end : path.find_last_of("/\\", end);
    return path.substr(slash == cv::String::npos ? 0 : slash + 1, slash == cv::String::npos ? end + 1 : end - slash);
}

/** The sequences of folders: a folder that is none itself is searched for them, in the order of their names. A folder without any is
kept, to be told of when it is used. */
inline std::vector<cv::String> findSequences(const std::vector<cv::String>& folders)
{
    namespace fs = cv::utils::fs;
    std::vector<cv::String> sequences, known;
    for (size_t i = 0; i < folders.size(); i++)
    {
        std::vector<cv::String> found(1, folders[i]);
        if (fs::isDirectory(folders[i]) && !fs::exists(fs::join(folders[i], "sequence.yaml")))
        {
            std::vector<cv::String> files;
            fs::glob(folders[i], "sequence.yaml", files, true);
            std::sort(files.begin(), files.end());
            if (!files.empty())
                found = files;
            for (size_t j = 0; j < files.size(); j++)
                found[j] = fs::getParent(files[j]);
        }
        for (size_t j = 0; j < found.size(); j++)
        {
            const cv::String path = absolutePath(found[j]);
            if (std::find(known.begin(), known.end(), path) != known.end())
                continue;
            known.push_back(path);
            sequences.push_back(found[j]);
        }
    }
    return sequences;
}

} // namespace common

#endif
