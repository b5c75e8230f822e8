// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// How often a baseline finds the parts of the tools, counted as those of QGO matching are (paper, Fig. 3 a and b).

#ifndef OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_RUN_HPP
#define OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_RUN_HPP

#include "../detection.hpp"
#include "gradboost.hpp"

namespace evaluation {

/** Looks for every class that can be seen, in the whole image. A hit: a visible keypoint of the class, of any tool, is near.
@param frames at most so many; 0 = all. Of a long sequence every k-th is looked at */
inline BaselineCounts countBaseline(const Data& data, GradBoost& detector, int frames, bool quiet)
{
    BaselineCounts result;
    result.parts = detector.classes();
    result.counts.resize(result.parts.size());
    TrueParts truths(data);
    const double pixel = truths.finder().pixelScale();
    common::FrameReader reader(*data.sequence, 0);
    const int count = frames > 0 ? std::min(frames, reader.count()) : reader.count();
    const int step = 1 + (std::max(count, 1) - 1) / MAX_DETECTION_FRAMES;
    common::Progress progress(count, quiet);
    Mat image;
    std::vector<PartMatch> matches;
    for (int frame = 0; (frames == 0 || frame < frames) && reader.read(image); frame++)
    {
        if (frame % step || !truths.read(frame))
            continue;
        truths.finder().setImage(image);
        detector.setImage(truths.finder().pixels(Rect(Point(), truths.finder().camera().imageSize())));
        const ClassPoints points = pointsOf(data, truths);
        for (int cls = 1; cls < detector.classCount(); cls++)
        {
            const ClassPoints own = pointsOf(points, result.parts[cls - 1]);
            if (own.empty())
                continue;
            detector.detect(cls, MAX_TOP_N, matches);
            std::vector<double> distances;
            for (size_t i = 0; i < matches.size(); i++)
                distances.push_back(nearestOf(own, matches[i].imagePoint) / pixel);
            DetectionCount& ofPart = result.counts[cls - 1];
            ofPart.visible++;
            ofPart.samples++;
            ofPart.prior = unknown();
            ofPart.addHits(distances);
        }
        truths.finder().release();
        progress.show(frame + 1);
    }
    return result;
}

} // namespace evaluation

#endif
