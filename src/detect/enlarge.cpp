// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "detect/enlarge.hpp"

namespace cv { namespace surgtrack {

// Pixel 2i lies a quarter of a pixel before pixel i, 2i + 1 a quarter behind it.
void enlargeTwice(const Mat& image, const Rect& area, Mat& result)
{
    CV_Assert(result.size() == image.size() * 2 && result.type() == image.type());
    const int channels = image.channels(), tile = 128;   // of columns of the image
    int sums[3 * (tile + 2)];
    for (int y = area.y; y < area.y + area.height; y++)
    {
        const int beside = y % 2 ? std::min(y / 2 + 1, image.rows - 1) : std::max(y / 2 - 1, 0);
        const uchar *near = image.ptr(y / 2), *far = image.ptr(beside);
        for (int left = area.x / 2; 2 * left < area.x + area.width; left += tile)
        {
            // Columns left - 1 to right, those beyond the image as the last ones in it.
            const int right = std::min(left + tile, (area.x + area.width + 1) / 2);
            const int first = std::max(left - 1, 0), last = std::min(right, image.cols - 1);
            int* const inside = sums + (first - (left - 1)) * channels;
            const int n = (last - first + 1) * channels;
            for (int i = 0; i < n; i++) inside[i] = 3 * near[first * channels + i] + far[first * channels + i];
            for (int c = 0; c < channels; c++)
            {
                if (left == 0) sums[c] = sums[channels + c];
                if (right == image.cols) sums[(right - left + 1) * channels + c] = sums[(right - left) * channels + c];
            }
            uchar* to = result.ptr(y) + 2 * left * channels;
            for (int x = left; x < right; x++, to += 2 * channels)
                for (int c = 0; c < channels; c++)
                {
                    const int* at = sums + (x - left + 1) * channels + c;
                    to[c] = uchar((3 * at[0] + at[-channels] + 8) >> 4);
                    to[channels + c] = uchar((3 * at[0] + at[channels] + 8) >> 4);
                }
        }
    }
}

}} // namespace cv::surgtrack
