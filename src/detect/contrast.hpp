// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_DETECT_CONTRAST_HPP
#define OPENCV_SURGTRACK_SRC_DETECT_CONTRAST_HPP

#include <vector>
#include "opencv2/core.hpp"

namespace cv { namespace surgtrack {

/* How strong gradients must be, by the texture around them: a multiple of the median size in tiles, bilinear between their centres,
   and no more than that multiple of the median of all. Half of the pixels of a picture are texture and noise, no outline of a
   tool, and their gradients scale with light, tone curve and haze as those of the outline do. */
class LocalThreshold
{
public:
    /** Looks at the sizes of a region.
    @param sizes see quantize()
    @param tl where the region lies in the image: tiles are the image's
    @param ratio threshold / median
    @param least, most of the threshold, in units of sizes */
    void measure(const Mat& sizes, Point tl, double ratio, double least, double most);

    //! Drops the orientations of the region that are weaker.
    void apply(Mat& orientations, const Mat& sizes);

private:
    void count(const Mat& sizes);
    double median(const ushort* tile) const;
    int at(int x, int y) const;

    Point tl_, first_;              // of the region; its first tile
    Size tiles_;
    std::vector<ushort> counts_;    // of each tile's sizes: 256
    std::vector<int> all_;
    int total_;
    std::vector<float> thresholds_;
    std::vector<uchar> row_;
};

}} // namespace cv::surgtrack

#endif
