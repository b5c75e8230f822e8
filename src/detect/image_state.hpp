// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_DETECT_IMAGE_STATE_HPP
#define OPENCV_SURGTRACK_SRC_DETECT_IMAGE_STATE_HPP

#include <vector>
#include "opencv2/core.hpp"

namespace cv { namespace surgtrack {

/** Where a camera never shows anything: black surrounds and pillars, found in the images, and what the user says. In blocks, since
gradients near the border of a surround are its own. */
class CV_EXPORTS VisibleRegion
{
public:
    //! What the user knows. @param mask CV_8UC1 of the images' size: 0 where there is nothing to see; empty: all may be seen
    void setMask(const Mat& mask);
    //! The next image.
    void look(const Mat& image);

    //! Whether there is anything that is not seen.
    bool isPartial() const { return partial_; }
    bool sees(const Point2d& p) const;
    //! Whether all of an area is seen.
    bool seesAll(const Rect2d& area) const;
    //! How often what is seen has changed.
    int changes() const { return changes_; }
    //! 255 where something is seen. @param factor pixels of the mask are so many of the image wide; the mask has the size it is to have
    void paint(Mat& mask, double factor) const;

private:
    void findSurround(const Mat& image, std::vector<uchar>& dark);
    void keepConnected(std::vector<uchar>& dark);
    void combine();

    Size size_, blocks_;
    std::vector<uchar> masked_;                 // a block; empty: no mask
    std::vector<uchar> dark_, both_, hidden_;   // at the last look, at the last two, and in the end
    std::vector<uchar> found_, kept_;           // memory of a look
    std::vector<Point> open_;
    int looks_ = 0, changes_ = 0;
    bool partial_ = false;
};

//! Samples of an image, to tell whether the next one is another.
class ImageSamples
{
public:
    //! @param reduction of an image that is so many times as large, as many pixels are looked at
    void look(const Mat& image, int reduction);
    //! Mean difference from the image before in a region [grey levels]; DBL_MAX without one.
    double change(const Rect& region) const;

private:
    int spacing_ = 1;   // [pixel]
    Size grid_;
    std::vector<uchar> now_, before_;
};

}} // namespace cv::surgtrack

#endif
