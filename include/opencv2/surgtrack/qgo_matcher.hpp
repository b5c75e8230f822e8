// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_QGO_MATCHER_HPP
#define OPENCV_SURGTRACK_QGO_MATCHER_HPP

#include "opencv2/surgtrack/qgo.hpp"
#include "opencv2/surgtrack/part_match.hpp"
#include "opencv2/surgtrack/part_templates.hpp"

namespace cv { namespace surgtrack {

//! @addtogroup surgtrack
//! @{

/** @brief Finds part templates in an image by their quantised gradient orientations (paper, Sec. 2.1).

The similarity of a template at a place is the mean, over its features, of 1 where the spread image holds the feature's
orientation, 1/4 where it holds a neighbouring one, else 0; sums of small integers over sliding windows, no per-pixel loop over
features.

Gradients count where they are strong for the picture, not for a fixed light: compared to the median of their tile of 128 x 128
pixels, and of all that is prepared, whichever is less. Half of a picture is texture and noise, no outline of a tool. Of noise a
fifth is more than 1.5 times as strong as its median, and then five neighbours of nine must agree on the direction. So a dim
picture, one in haze and one with another tone curve have nearly the same orientations.

A window is searched place by place. The whole image is searched in cells of 4 x 4 places first, whose similarity bounds that of
their places from above; cells are then looked into, the most promising first, until the best place found beats all bounds that
are left. So the best match of a template is that of a search place by place, unless thousands of cells promise as much (a
template that is nowhere in an image full of edges). Its further matches come from the cells that were looked into, at least
eight a candidate if that many can hold one: they have the places and similarities they have, but one may be missed.

Only what is asked for is made: responses of the area that windows need at the first match in windows, cells at the first search
of the whole image. Memory is kept from image to image. */
class CV_EXPORTS_W QGOMatcher
{
public:
    struct CV_EXPORTS_W_SIMPLE Params
    {
        CV_WRAP Params();
        CV_PROP_RW double magnitudeThreshold;   //!< see quantizeOrientations(); the most that is asked for; default 50, as the paper's release
        CV_PROP_RW double contrast;             //!< gradients must be so many times the median around, where that is less than magnitudeThreshold (then up to 127); 0 = not looked at; default 1.5, from rendered scenes (1.5 to 3)
        CV_PROP_RW double leastMagnitude;       //!< contrast never asks for less; default 8: a blurred edge of four grey levels, as rounding and compression make
        CV_PROP_RW int spread;                  //!< see spreadOrientations() [pixel]; default 5, as the paper's release
        CV_PROP_RW int candidates;              //!< at most so many matches a part; default 5 (paper: top 5)
        CV_PROP_RW int suppressionRadius;       //!< a match suppresses weaker ones of its part this near [pixel]; default 6
        CV_PROP_RW double minSimilarity;        //!< weaker matches are dropped, 0..1; default 0.5
        CV_PROP_RW double relativeSimilarity;   //!< as are those weaker than this share of the part's best; default 0.7
    };

    CV_WRAP static Ptr<QGOMatcher> create(const QGOMatcher::Params& params = QGOMatcher::Params());
    virtual ~QGOMatcher() {}

    /** @brief Prepares the image for matching.
    @param image CV_8UC1 or CV_8UC3, any size; is not kept
    @param roi only windows with their templates inside it can be matched; empty = the whole image
    @param mask CV_8UC1 of the image's size: there are no orientations where it is 0; none: everywhere */
    CV_WRAP virtual void setImage(InputArray image, const Rect& roi = Rect(), InputArray mask = noArray()) = 0;

    /** @brief Finds templates in the prepared image. Features outside the prepared region count as not found.
    @param templates what to look for
    @param windows where the keypoints of each template may be [pixel]; one per template, or none for the whole image; a window
    that holds the image is the whole image
    @param matches candidates, sorted by falling similarity */
    CV_WRAP virtual void match(const std::vector<PartTemplate>& templates, const std::vector<Rect>& windows,
                               CV_OUT std::vector<PartMatch>& matches) = 0;

    /** @brief The similarity of one template over a window, before any selection.
    @param partTemplate what to look for
    @param window where its keypoint may be [pixel]
    @param similarity CV_16UC1 of the window's size: sum over features of 4, 1 or 0 */
    CV_WRAP virtual void similarityMap(const PartTemplate& partTemplate, const Rect& window, OutputArray similarity) = 0;

    /** @brief What is matched, before it is spread.
    @param orientations of the prepared region, as of quantizeOrientations() */
    CV_WRAP virtual void orientations(OutputArray orientations) const = 0;
};

//! @}

}} // namespace cv::surgtrack

#endif
