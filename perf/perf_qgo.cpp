// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "perf_common.hpp"

namespace opencv_test { namespace {

typedef TestBaseWithParam<Size> Size_QGO;

// One channel or three.
typedef TestBaseWithParam<tuple<Size, int> > Size_Channels_QGO;

Mat imageOf(Size size, int channels)
{
    Mat image = View(size).image;
    if (channels == 1) cvtColor(image.clone(), image, COLOR_BGR2GRAY);
    return image;
}

PERF_TEST_P(Size_Channels_QGO, quantize, testing::Combine(SURGTRACK_SIZES, testing::Values(1, 3)))
{
    const Mat image = imageOf(get<0>(GetParam()), get<1>(GetParam()));
    Mat orientations(image.size(), CV_8UC1);
    TEST_CYCLE() quantizeOrientations(image, orientations);
    SANITY_CHECK_NOTHING();
}

// What the same costs with OpenCV's own filters, up to the gradients only: the yardstick of quantize.
PERF_TEST_P(Size_Channels_QGO, referenceBlurAndSobel, testing::Combine(SURGTRACK_SIZES, testing::Values(1, 3)))
{
    const Mat image = imageOf(get<0>(GetParam()), get<1>(GetParam()));
    Mat blurred, gx, gy;
    TEST_CYCLE()
    {
        GaussianBlur(image, blurred, Size(7, 7), 1.4, 1.4, BORDER_REPLICATE);
        Sobel(blurred, gx, CV_16S, 1, 0, 3, 1, 0, BORDER_REPLICATE);
        Sobel(blurred, gy, CV_16S, 0, 1, 3, 1, 0, BORDER_REPLICATE);
    }
    SANITY_CHECK_NOTHING();
}

PERF_TEST_P(Size_QGO, spread, SURGTRACK_SIZES)
{
    Mat orientations, spread(GetParam(), CV_8UC1);
    quantizeOrientations(imageOf(GetParam(), 3), orientations);
    TEST_CYCLE() spreadOrientations(orientations, spread);
    SANITY_CHECK_NOTHING();
}

PERF_TEST_P(Size_QGO, response, SURGTRACK_SIZES)
{
    Mat orientations, spread, response(GetParam(), CV_8UC1);
    quantizeOrientations(imageOf(GetParam(), 3), orientations);
    spreadOrientations(orientations, spread);
    TEST_CYCLE() orientationResponse(spread, 3, response);
    SANITY_CHECK_NOTHING();
}

}} // namespace
