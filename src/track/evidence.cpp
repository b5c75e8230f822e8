// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/surgtrack/tool_tracker.hpp"
#include "track/evidence.hpp"

namespace cv { namespace surgtrack {

EvidenceThresholds::EvidenceThresholds()
    : followed(0.9), start(1.12), sure(1.25), leastSimilarity(0.5), leastSupport(0.3), startSupport(0.45), outlineAlone(0.55), minParts(4),
      sureNis(0.6), doubt(0.25), pushedGain(0.05)
{
}

// A tool that is followed needs less; an outline alone only continues.
bool Evidence::continues(const EvidenceThresholds& t, int state) const
{
    const bool followed = state == STATE_TRACKING;
    if (points) return followed ? sum(t) >= t.followed : isStart(t);
    return (followed || state == STATE_COASTING) && support >= t.outlineAlone;
}

}} // namespace cv::surgtrack
