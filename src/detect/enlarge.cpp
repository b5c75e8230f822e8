// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "detect/enlarge.hpp"

namespace cv { namespace surgtrack {

namespace {

// Pixel 2i lies a quarter of a pixel before pixel i, 2i + 1 a quarter behind it: weights / 256 of the pixels i - 2 to i + 2, those
// of cubics with a slope of -0.75.
const int weights[2][5] = {{-9, 67, 225, -27, 0}, {0, -27, 225, 67, -9}};
const int reach = 2;

} // namespace

void enlargeTwice(const Mat& image, const Rect& area, Mat& result)
{
    CV_Assert(result.size() == image.size() * 2 && result.type() == image.type());
    const int channels = image.channels(), tile = 128;   // of columns of the image
    int sums[3 * (tile + 2 * reach)];
    for (int y = area.y; y < area.y + area.height; y++)
    {
        const int* const w = weights[y % 2];
        const uchar* rows[5];
        for (int k = 0; k < 5; k++) rows[k] = image.ptr(std::min(std::max(y / 2 + k - reach, 0), image.rows - 1));
        for (int left = area.x / 2; 2 * left < area.x + area.width; left += tile)
        {
            const int right = std::min(left + tile, (area.x + area.width + 1) / 2);
            for (int x = left - reach, i = 0; x < right + reach; x++)
            {
                const int at = std::min(std::max(x, 0), image.cols - 1) * channels;   // beyond the image as the last ones in it
                for (int c = at; c < at + channels; c++, i++)
                    sums[i] = w[0] * rows[0][c] + w[1] * rows[1][c] + w[2] * rows[2][c] + w[3] * rows[3][c] + w[4] * rows[4][c];
            }
            uchar* to = result.ptr(y) + 2 * left * channels;
            const int* s = sums;
            for (int x = left; x < right; x++, to += channels)
                for (int c = 0; c < channels; c++, s++, to++)
                {
                    const int before = s[channels], middle = s[2 * channels], behind = s[3 * channels];
                    const int first = -9 * s[0] + 67 * before + 225 * middle - 27 * behind;
                    const int second = -27 * before + 225 * middle + 67 * behind - 9 * s[4 * channels];
                    to[0] = saturate_cast<uchar>((first + 32768) >> 16);
                    to[channels] = saturate_cast<uchar>((second + 32768) >> 16);
                }
        }
    }
}

}} // namespace cv::surgtrack
