// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Which baselines are wanted, and how they are made.

#ifndef OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_OPTIONS_HPP
#define OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_OPTIONS_HPP

#include "training.hpp"

namespace evaluation {

struct BaselineOptions
{
    std::vector<String> names, train, parts;   //!< parts: of gradboost
    int rounds, trees;
    bool early, leaveOut, fine, quiet;

    BaselineOptions() : rounds(200), trees(60), early(true), leaveOut(false), fine(false), quiet(false) {}
    bool has(const char* name) const { return std::find(names.begin(), names.end(), name) != names.end(); }
    bool learns() const { return has("gradboost") || has("reiter2014"); }

    //! What other options make other results.
    String text() const
    {
        String text;
        for (size_t i = 0; i < names.size(); i++)
            text += " " + names[i];
        for (size_t i = 0; i < parts.size(); i++)
            text += " " + parts[i];
        return names.empty() ? text : text + format(" %d rounds %d trees %d %d %d", rounds, trees, early, leaveOut, fine);
    }

    //! The folders to learn from that have no video of a sequence. @param sequence which is tested
    std::vector<String> trainingFor(const String& sequence) const
    {
        std::vector<String> folders;
        for (size_t i = 0; i < train.size(); i++)
            if (!leaveOut || !shareVideo(train[i], sequence))
                folders.push_back(train[i]);
        if (folders.empty() && !train.empty())
            fail("argument '--train': nothing is left to learn from when those with the video of " + sequence + " are left out");
        return folders;
    }
};

} // namespace evaluation

#endif
