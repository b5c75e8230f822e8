// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Seven channels of an image at half its size, and their sums over rectangles. They are those of integral channel features (Dollar et al.
// 2009) without grey levels and colours, which do not carry over from the few videos that are learnt from to another tissue (learnt from
// one training video, on the other one: top 1 within 10 px 41 % without, 29 % with them); Sznitman et al. 2014 leave theirs open.

#ifndef OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_CHANNELS_HPP
#define OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_CHANNELS_HPP

#include <vector>
#include "opencv2/imgproc.hpp"

namespace evaluation {

using namespace cv;

/** Gradient magnitude of the strongest colour, and that magnitude in six bins of orientation. Whole numbers of 0..255, so that sums are
exact. */
class Channels
{
public:
    enum { COUNT = 7, BINS = 6, BORDER = 16 };

    void setImage(const Mat& image)
    {
        Mat colour = image;
        if (image.channels() == 1)
            cvtColor(image, colour, COLOR_GRAY2BGR);
        Mat half;
        resize(colour, half, Size(std::max(1, colour.cols / 2), std::max(1, colour.rows / 2)), 0, 0, INTER_AREA);
        GaussianBlur(half, half, Size(3, 3), 0, 0, BORDER_REPLICATE);
        size_ = half.size();
        makePlanes(half);
        for (int i = 0; i < COUNT; i++)
        {
            Mat padded;
            copyMakeBorder(planes_[i], padded, BORDER, BORDER, BORDER, BORDER, BORDER_REPLICATE);
            integral(padded, integrals_[i], CV_32S);
        }
    }

    Size size() const { return size_; }
    const Mat& plane(int channel) const { return planes_[channel]; }
    //! Elements from one row of the sums to the next.
    int stride() const { return (int)integrals_[0].step1(); }
    //! The sum above and to the left of a channel pixel; pixels may lie BORDER outside, where the edge goes on.
    const int* at(int channel, int x, int y) const { return integrals_[channel].ptr<int>(y + BORDER) + x + BORDER; }
    int sum(int channel, const Rect& r) const
    {
        const int* a = at(channel, r.x, r.y);
        const int* b = at(channel, r.x, r.y + r.height);
        return b[r.width] - b[0] - a[r.width] + a[0];
    }

    //! Channel pixels of an image point and back: means of 2 x 2.
    static Point placeOf(const Point2d& p) { return Point(cvRound((p.x - 0.5) / 2), cvRound((p.y - 0.5) / 2)); }
    static Point2d pointOf(const Point& p) { return Point2d(2 * p.x + 0.5, 2 * p.y + 0.5); }

private:
    void makePlanes(const Mat& image)
    {
        for (int i = 0; i < COUNT; i++)
            planes_[i].create(image.size(), CV_8U);
        Mat dx, dy;
        Sobel(image, dx, CV_16S, 1, 0, 3, 1, 0, BORDER_REPLICATE);
        Sobel(image, dy, CV_16S, 0, 1, 3, 1, 0, BORDER_REPLICATE);
        for (int y = 0; y < image.rows; y++)
            for (int x = 0; x < image.cols; x++)
                setGradient(y, x, dx.at<Vec3s>(y, x), dy.at<Vec3s>(y, x));
    }
    void setGradient(int y, int x, const Vec3s& dx, const Vec3s& dy)
    {
        int best = 0, strongest = -1;
        for (int i = 0; i < 3; i++)
        {
            const int size = dx[i] * dx[i] + dy[i] * dy[i];
            if (size > strongest)
            {
                strongest = size;
                best = i;
            }
        }
        const uchar magnitude = saturate_cast<uchar>(std::sqrt((double)strongest) / 2);
        float angle = fastAtan2(dy[best], dx[best]);
        angle -= angle >= 180 ? 180 : 0;
        const int bin = std::min(int(angle * BINS / 180), BINS - 1);
        planes_[0].at<uchar>(y, x) = magnitude;
        for (int i = 0; i < BINS; i++)
            planes_[1 + i].at<uchar>(y, x) = i == bin ? magnitude : 0;
    }

    Size size_;
    Mat planes_[COUNT], integrals_[COUNT];
};

//! The sum of a channel over a rectangle of a window about a place.
struct ChannelFeature
{
    enum { WINDOW = 28, LEAST = 2, MOST = 15 };
    int channel;
    Rect box;   //!< about the place

    static std::vector<ChannelFeature> random(int count, uint64 seed)
    {
        RNG rng(seed);
        std::vector<ChannelFeature> features(count);
        for (int i = 0; i < count; i++)
        {
            const int w = rng.uniform(int(LEAST), MOST + 1), h = rng.uniform(int(LEAST), MOST + 1);
            features[i].channel = rng.uniform(0, int(Channels::COUNT));
            features[i].box = Rect(rng.uniform(0, WINDOW - w + 1) - WINDOW / 2, rng.uniform(0, WINDOW - h + 1) - WINDOW / 2, w, h);
        }
        return features;
    }
    int of(const Channels& channels, const Point& place) const { return channels.sum(channel, box + place); }
};

} // namespace evaluation

#endif
