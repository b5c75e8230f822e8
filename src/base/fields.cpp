// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/surgtrack/fields.hpp"
#include "base/checks.hpp"
#include "base/geometry.hpp"

namespace cv { namespace surgtrack {

namespace {

/* Of an image without fields rows that are nearer differ less; of noise alone both differences are the same, to a twentieth in a
   block's 190 samples. Motion across upright edges by a pixel and more makes the nearer ones larger. */
const int combBlock = 96;          // [pixel]
const double combRatio = 1.25, combDifference = 4;   // of the differences; least mean of the nearer ones [grey levels]
const int combBlocks = 2;          // one alone may be a ribbed jaw

//! The field of the rows of a parity: they are copied, those between are the means of their neighbours.
void takeField(const Mat& image, int parity, Mat field)
{
    const int n = image.cols * image.channels();
    for (int y = 0; y < image.rows; y++)
    {
        const bool own = y % 2 == parity;
        const uchar* above = image.ptr(own || y == 0 ? std::min(y + !own, image.rows - 1) : y - 1);
        const uchar* below = image.ptr(own || y + 1 == image.rows ? std::max(y - !own, 0) : y + 1);
        uchar* to = field.ptr(y);
        if (own || above == below) std::copy(above, above + n, to);
        else
            for (int i = 0; i < n; i++) to[i] = uchar((above[i] + below[i] + 1) >> 1);
    }
}

} // namespace

bool isInterlaced(InputArray _image)
{
    const Mat image = _image.getMat();
    checkImage(image);
    if (image.rows < 8) return false;
    const int channels = image.channels(), channel = channels / 2;   // green tells most of the light
    const int reduction = std::max(1, image.cols / referenceWidth);  // as many pixels of any image are looked at
    const int block = combBlock * reduction;
    int combed = 0;
    for (int top = 0; top + block / 2 <= image.rows; top += block)
        for (int left = 0; left + block / 2 <= image.cols; left += block)
        {
            int nearer = 0, farther = 0, count = 0;
            const int bottom = std::min(top + block, image.rows - 2), right = std::min(left + block, image.cols);
            for (int y = top; y < bottom; y += 6 * reduction)
            {
                const uchar *a = image.ptr(y) + channel, *b = image.ptr(y + 1) + channel, *c = image.ptr(y + 2) + channel;
                for (int x = left; x < right; x += 8 * reduction, count++)
                {
                    nearer += std::abs(a[x * channels] - b[x * channels]);
                    farther += std::abs(a[x * channels] - c[x * channels]);
                }
            }
            combed += nearer > combRatio * farther && nearer > combDifference * count;
        }
    return combed >= combBlocks;
}

void splitFields(InputArray _image, bool topFirst, OutputArray first, OutputArray second)
{
    const Mat image = _image.getMat();
    checkImage(image);
    CV_CheckGE(image.rows, 2, "image: a row of each field");
    const _OutputArray* const fields[] = {&first, &second};
    for (int i = 0; i < 2; i++)
    {
        if (!fields[i]->needed()) continue;
        fields[i]->create(image.size(), image.type());
        const Mat field = fields[i]->getMat();
        CV_Assert(field.data != image.data && "first and second must not be the image");
        takeField(image, topFirst ? i : 1 - i, field);
    }
}

}} // namespace cv::surgtrack
