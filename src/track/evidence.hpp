// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_TRACK_EVIDENCE_HPP
#define OPENCV_SURGTRACK_SRC_TRACK_EVIDENCE_HPP

#include "opencv2/surgtrack/tool_estimate.hpp"

namespace cv { namespace surgtrack {

/* When a pose of METHOD_FULL is believed. Parts that a similar pose would show look alike, and so do edges of tissue, but not both
at once: the sum of similarity and support is 1.2 to 1.8 at right poses and up to 1.1 at wrong ones (frames of the path-traced
sequences, at the true pose and at what was found about false hand-eye calibrations; right poses of real stills have 1.11, 1.29
and 1.41 at 10, 50 and 90 %). */
struct EvidenceThresholds
{
    EvidenceThresholds()
        : followed(0.9), start(1.12), sure(1.25), leastSimilarity(0.5), leastSupport(0.3), startSupport(0.45), outlineAlone(0.55), minParts(4),
          followedNis(0.75), sureNis(0.6), doubt(0.25), pushedGain(0.05)
    {
    }

    double followed;            // sum, of a pose that follows from the frame before: what a partly hidden tool in smoke still has
    double start;               // sum, of one that does not: above the wrong ones
    double sure;                // sum, of one that needs no second frame: above the wrong ones with room to spare
    double leastSimilarity;     // less is tissue; the matcher drops weaker parts
    double leastSupport;        // less is tissue: outlines 5 px off have 0.2 on average
    double startSupport;        // of an outline that was not followed until now: false finds by parts alone end below
    double outlineAlone;        // support that continues a track without parts: 20 px off it is 0.31 at most
    int minParts;               // that must be found and pass the filter's gate: three leave a pose and its mirror image
    double followedNis;         // of points, per degree of freedom, of a pose that needs no more than `followed`: below 0.6 as a rule
    double sureNis;             // of points, per degree of freedom, of a pose that needs no second frame
    double doubt;               // what a unit of NIS takes off the sum where first poses are compared
    double pushedGain;          // sum that a push of the camera must add to be believed: twice what noise adds
};

//! What a pose has to show for itself, that the filter does not know.
struct Evidence
{
    Evidence() : similarity(0), support(0), nis(0), parts(0), points(false) { eyeSupport[0] = eyeSupport[1] = 0; }

    double similarity;   // mean, of the parts that went into the pose
    double support;      // share of the outline with its strongest edge where the pose has it
    double eyeSupport[2];   // the same, of each eye that was looked with
    double nis;          // of the points, per degree of freedom
    int parts;           // that went into the pose
    bool points;         // whether any did, not only the outline

    //! Similarity + support; 0 where either does not tell the tool from tissue at all.
    double sum(const EvidenceThresholds& t) const
    {
        return similarity < t.leastSimilarity || support < t.leastSupport ? 0 : similarity + support;
    }
    //! Enough for a pose that does not follow from the frame before, or one after a gap.
    bool isStart(const EvidenceThresholds& t) const { return sum(t) >= t.start && support >= t.startSupport; }
    //! Enough to be taken for one of the first poses.
    bool isFirstPose(const EvidenceThresholds& t) const { return isStart(t) && parts > t.minParts; }
    //! Enough without a second frame. @param minInliers Params::minInitialInliers
    bool isSure(const EvidenceThresholds& t, int minInliers) const { return sum(t) >= t.sure && nis <= t.sureNis && parts >= minInliers; }
    //! Enough to go on: a tool that is followed needs less, an outline alone only continues. @param state before this frame, see TrackingState
    bool continues(const EvidenceThresholds& t, int state) const
    {
        const bool followed = state == STATE_TRACKING;
        if (points) return followed && nis <= t.followedNis ? sum(t) >= t.followed : isStart(t);
        return (followed || state == STATE_COASTING) && support >= t.outlineAlone;
    }
    //! For comparing first poses: the larger, the better.
    double merit(const EvidenceThresholds& t) const { return sum(t) - t.doubt * nis; }
};

}} // namespace cv::surgtrack

#endif
