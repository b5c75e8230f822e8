// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_TRACK_EVIDENCE_HPP
#define OPENCV_SURGTRACK_SRC_TRACK_EVIDENCE_HPP

#include <cmath>
#include <algorithm>
#include "opencv2/surgtrack/tool_estimate.hpp"

namespace cv { namespace surgtrack {

/* What a pose is believed for. Parts that a similar pose would show look alike, and so do edges of tissue, but not both at once. The
log odds that a pose is within 10 pixels and 5 mm of the truth are a sum over what it has to show. Coefficients: logistic regression,
misc/fit_confidence.py, on 6600 poses of the paper's recording and of path-traced sequences, clear, dim, blurred, hazy and coded, fitted
about good and bad hand-eye calibrations; no pose on tissue alone has more than 0.5 among them. */
struct EvidenceModel
{
    EvidenceModel() : constant(-6.3), parts(4.3), tissue(0.5), support(12.2), nis(4.5), mostNis(2) {}

    double constant;
    double parts;      // of the square root of the summed similarities beyond those of tissue
    double tissue;     // similarity of a part that tells nothing; the matcher drops weaker ones
    double support;    // of the share of the outline
    double nis;        // of the root of the points' NIS, which is taken off
    double mostNis;    // more says no more
};

struct EvidenceThresholds
{
    //! @param minConfidence Params::minConfidence: by its odds what follows is more or less than if it is 0.5
    explicit EvidenceThresholds(double minConfidence = 0.5) : first(0), confirmed(2.2), sure(3.9), followed(1), prior(2), outlinePrior(0.5), leastSupport(0.3), seriousLead(-1.1), minParts(4), pushedGain(0.6)
    {
        const double more = std::log(minConfidence / (1 - minConfidence));
        first += more;
        confirmed += more;
        sure += more;
        followed += more;
    }

    // Log odds: 0 is a probability of 0.5, 1 of 0.73, 2.2 of 0.9, 3.9 of 0.98.
    double first;       // of a pose worth a second frame
    double confirmed;   // of one that counts as tracking after more frames
    double sure;        // of one that needs no second frame
    double followed;    // of one that follows from the frame before, with its prior
    double prior;       // of such a pose, at most: of 200 poses whose own odds were 0.4 to 1, 97 % were right after one that was
    double outlinePrior;   // of an outline alone: it must have 0.56 of its own, 20 px off it has 0.31 at most
    double leastSupport;   // of a pose that is followed, whatever its prior: outlines 5 px off have 0.2 on average
    double seriousLead; // of a second pose against the one that is believed: one in four
    int minParts;       // that must be found and pass the filter's gate: three leave a pose and its mirror image
    double pushedGain;  // that a push of the camera must add to be believed: twice what noise adds
};

//! What a pose has to show for itself, that the filter does not know.
struct Evidence
{
    Evidence() : similarity(0), support(0), white(0), nis(0), parts(0), points(false), plausible(true) { eyeSupport[0] = eyeSupport[1] = 0; }

    double similarity;   // mean, of the parts that went into the pose
    double support;      // share of the outline with its strongest edge where the pose has it
    double eyeSupport[2];   // the same, of each eye that was looked with
    double white;        // share of the edges that were found beside white: how far light has bloomed over them, and with it the depth, is not known
    double nis;          // of the points, per degree of freedom
    int parts;           // that went into the pose
    bool points;         // whether any did, not only the outline
    bool plausible;      // whether a calibration's error may be that large, and the parts lie where the pose has them

    //! Of the pose being right, by this frame alone.
    double logOdds(const EvidenceModel& m = EvidenceModel()) const
    {
        if (!plausible) return m.constant;
        return m.constant + m.parts * std::sqrt(parts * std::max(0., similarity - m.tissue)) + m.support * support
               - m.nis * std::sqrt(std::min(nis, m.mostNis));
    }
    //! Light hides the tool's size.
    bool isBlinded() const { return white > 0.5; }
    //! Enough to be taken for one of the first poses.
    bool isFirstPose(const EvidenceThresholds& t) const { return plausible && parts > t.minParts && logOdds() >= t.first; }
    //! Enough without a second frame. @param minInliers Params::minInitialInliers
    bool isSure(const EvidenceThresholds& t, int minInliers) const { return logOdds() >= t.sure && parts >= minInliers; }
};

//! Log odds as a probability.
inline double probability(double logOdds) { return 1 / (1 + std::exp(-logOdds)); }

}} // namespace cv::surgtrack

#endif
