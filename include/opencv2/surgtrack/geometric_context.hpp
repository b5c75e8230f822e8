// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_GEOMETRIC_CONTEXT_HPP
#define OPENCV_SURGTRACK_GEOMETRIC_CONTEXT_HPP

#include "opencv2/surgtrack/qgo_matcher.hpp"

namespace cv { namespace surgtrack {

//! @addtogroup surgtrack
//! @{

/** @brief Keeps the matches of one tool whose arrangement in the image is that of the drawing (paper, Sec. 2.2).

Two matches of different parts, drawn in PROSAC order @cite chum2005matching, span a polar grid in the image and one in the
drawing: centre on the first point, axis through the second. Another match agrees if it falls into the zone of its part in
both grids. The sample with most inliers wins (ties: the larger sum of similarities); a part has at most one inlier. With Params::centredZones = false the first sample
that Params::minInliers agree with is taken, as in the paper. */
class CV_EXPORTS_W GeometricContextVerifier
{
public:
    struct CV_EXPORTS_W_SIMPLE Params
    {
        CV_WRAP Params();
        CV_PROP_RW double zoneAngle;      //!< width of a zone [rad]; 30 degrees, as in the paper
        CV_PROP_RW double zoneRadius;     //!< depth of a zone [pixel]; 10, as in the paper
        CV_PROP_RW bool centredZones;     //!< zones centred on the predicted points; false: fixed cells of the grid, as in the paper
        CV_PROP_RW int minInliers;        //!< fewer are no agreement; 4, as in the paper
        CV_PROP_RW int maxIterations;     //!< samples at most; 100, as in the paper
        CV_PROP_RW double maxScale;       //!< samples that scale the arrangement by more than this, or less than its inverse, are skipped; 0 = any
        CV_PROP_RW double maxRotation;    //!< samples that turn the arrangement by more than this are skipped [rad]; 0 = any
        CV_PROP_RW int seed;              //!< of the sampling
    };

    /** @param params zones and limits */
    CV_WRAP static Ptr<GeometricContextVerifier> create(const GeometricContextVerifier::Params& params = GeometricContextVerifier::Params());
    virtual ~GeometricContextVerifier() {}

    /** @brief Keeps what agrees.
    @param matches candidates of one tool, sorted by falling similarity
    @param inliers those that agree, at most one a part, sorted by part; empty after false
    @return whether at least Params::minInliers agree */
    CV_WRAP virtual bool verify(const std::vector<PartMatch>& matches, CV_OUT std::vector<PartMatch>& inliers) = 0;

    /** @brief The two matches that span the grids the inliers of the last verify() agree in: the centre, and a point on the axis.
    Empty after false. */
    CV_WRAP virtual std::vector<PartMatch> sample() const = 0;
    //! The same, into memory that is there. @param matches result
    virtual void copySample(std::vector<PartMatch>& matches) const = 0;
};

//! @}

}} // namespace cv::surgtrack

#endif
