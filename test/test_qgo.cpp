// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_common.hpp"
#include "detect/qgo.hpp"

namespace opencv_test { namespace {

// ---- The definitions, written down once more, pixel by pixel, with nothing shared with the module. ----

// 7x7, sigma 1.41, to 16 x grey level: across, rounded to 4 x grey level, then down.
int blurredAt(const Mat& image, int channel, int x, int y)
{
    static const int kernel[7] = {1, 4, 7, 8, 7, 4, 1};
    int sum = 0;
    for (int j = -3; j <= 3; j++)
    {
        int row = 0;
        const int yj = cv::borderInterpolate(y + j, image.rows, BORDER_REPLICATE);
        for (int i = -3; i <= 3; i++) row += kernel[i + 3] * image.ptr(yj, cv::borderInterpolate(x + i, image.cols, BORDER_REPLICATE))[channel];
        sum += kernel[j + 3] * ((row + 4) / 8);
    }
    return (sum + 4) / 8;
}

// The bin of a gradient; its bounds are slopes of 1/5 and 2/3, 11.31 and 33.69 degrees.
int binOf(int gx, int gy)
{
    const int x = std::abs(gx), y = std::abs(gy);
    int bin;
    if (5 * y <= x) bin = 0;
    else if (3 * y <= 2 * x) bin = 1;
    else if (2 * y <= 3 * x) bin = 2;
    else if (y <= 5 * x) bin = 3;
    else bin = 4;
    const bool falling = (gx < 0) != (gy < 0);
    return falling && bin > 0 ? 8 - bin : bin;
}

Mat referenceQuantize(const Mat& image, double magnitudeThreshold)
{
    const int border = 2, w = image.cols + 2 * border, h = image.rows + 2 * border;
    std::vector<Mat_<int> > blurred;
    for (int c = 0; c < image.channels(); c++)
    {
        Mat_<int> b(h, w);
        for (int y = 0; y < h; y++)
            for (int x = 0; x < w; x++) b(y, x) = blurredAt(image, c, x - border, y - border);
        blurred.push_back(b);
    }
    Mat_<int> bins(h, w, -1), squares(h, w, 0);
    for (int y = 1; y < h - 1; y++)
        for (int x = 1; x < w - 1; x++)
        {
            int strongest = -1;
            for (size_t c = 0; c < blurred.size(); c++)
            {
                int gx = 0, gy = 0;
                for (int i = -1; i <= 1; i++)
                {
                    const int weight = 2 - std::abs(i);
                    gx += weight * (blurred[c](y + i, x + 1) - blurred[c](y + i, x - 1));
                    gy += weight * (blurred[c](y + 1, x + i) - blurred[c](y - 1, x + i));
                }
                if (std::abs(gx) + std::abs(gy) <= strongest) continue;   // the strongest channel by this sum, the first of equal ones
                strongest = std::abs(gx) + std::abs(gy);
                squares(y, x) = gx * gx / 4096 + gy * gy / 4096;   // 256 x the square in grey levels, to 1/16 of it
                bins(y, x) = binOf(gx, gy);
            }
        }

    Mat_<uchar> result(image.size(), uchar(0));
    for (int y = 0; y < image.rows; y++)
        for (int x = 0; x < image.cols; x++)
        {
            if (16 * squares(y + border, x + border) < magnitudeThreshold * magnitudeThreshold) continue;
            int votes[8] = {0, 0, 0, 0, 0, 0, 0, 0};
            for (int j = -1; j <= 1; j++)
                for (int i = -1; i <= 1; i++) votes[bins(y + border + j, x + border + i)]++;
            const int winner = int(std::max_element(votes, votes + 8) - votes);
            if (votes[winner] >= 5) result(y, x) = uchar(1 << winner);
        }
    return std::move(result);
}

Mat referenceSpread(const Mat& bits, int size)
{
    Mat_<uchar> result(bits.size(), uchar(0));
    for (int y = 0; y < bits.rows; y++)
        for (int x = 0; x < bits.cols; x++)
            for (int j = -(size / 2); j <= size / 2; j++)
                for (int i = -(size / 2); i <= size / 2; i++)
                    if (Rect(Point(), bits.size()).contains(Point(x + i, y + j))) result(y, x) |= bits.at<uchar>(y + j, x + i);
    return std::move(result);
}

Mat referenceResponse(const Mat& bits, int bin)
{
    Mat_<uchar> result(bits.size(), uchar(0));
    for (int y = 0; y < bits.rows; y++)
        for (int x = 0; x < bits.cols; x++)
            for (int b = 0; b < 8; b++)
                if (bits.at<uchar>(y, x) >> b & 1)
                {
                    const int off = std::min((b - bin + 8) % 8, (bin - b + 8) % 8);
                    result(y, x) = std::max(result(y, x), uchar(off == 0 ? 4 : off == 1 ? 1 : 0));
                }
    return std::move(result);
}

// ---- Inputs ----

enum Kind { NOISE, BLOTCHES, STEPS, RAMP, KINDS };

Mat testImage(Size size, int channels, int kind, uint64 seed)
{
    RNG rng(seed);
    Mat image(size, CV_MAKETYPE(CV_8U, channels));
    if (kind == NOISE) rng.fill(image, RNG::UNIFORM, 0, 256);
    else if (kind == BLOTCHES) image = textured(size, channels, seed);
    else if (kind == STEPS)
    {
        // Saturated edges: the largest gradients there are.
        image.setTo(Scalar::all(0));
        for (int i = 0; i < 6; i++)
            rectangle(image, Point(rng.uniform(-9, size.width), rng.uniform(-9, size.height)),
                      Point(rng.uniform(0, size.width + 9), rng.uniform(0, size.height + 9)),
                      Scalar(255 * rng.uniform(0, 2), 255 * rng.uniform(0, 2), 255 * rng.uniform(0, 2)), FILLED);
    }
    else
    {
        // Long ramps: the same bin over whole vectors; a slope near a bin's bound now and again.
        const double angle = rng.uniform(0., 2 * CV_PI), slope = rng.uniform(1., 9.);
        for (int y = 0; y < size.height; y++)
            for (int x = 0; x < size.width * channels; x++)
                image.ptr(y)[x] = saturate_cast<uchar>(128 + slope * (std::cos(angle) * (x / channels - size.width / 2) + std::sin(angle) * (y - size.height / 2)));
    }
    return image;
}

const Size SIZES[] = {Size(1, 1), Size(1, 9), Size(9, 1), Size(2, 3), Size(3, 2), Size(4, 4), Size(5, 7), Size(7, 5), Size(8, 8), Size(15, 16), Size(16, 15),
                      Size(17, 31), Size(31, 17), Size(32, 3), Size(33, 33), Size(47, 20), Size(63, 9), Size(64, 21), Size(65, 65), Size(96, 11), Size(127, 5),
                      Size(128, 33), Size(129, 67), Size(130, 70)};

// A matrix in the middle of a larger one, so that it has a stride, any alignment and neighbours that must not be touched.
struct Framed
{
    Framed(Size size, int type, RNG& rng) : left(rng.uniform(1, 34)), all(size.height + 2, size.width + left + rng.uniform(1, 40), type)
    {
        rng.fill(all, RNG::UNIFORM, 0, 256);
        inner = all(Rect(left, 1, size.width, size.height));
        before = all.clone();
    }
    explicit Framed(const Mat& content, RNG& rng) : Framed(content.size(), content.type(), rng) { content.copyTo(inner); before = all.clone(); }

    bool frameIsUntouched() const
    {
        Mat now = all.clone();
        before(Rect(left, 1, inner.cols, inner.rows)).copyTo(now(Rect(left, 1, inner.cols, inner.rows)));
        return cvtest::norm(now, before, NORM_INF) == 0;
    }

    int left;
    Mat all, inner, before;
};

double differing(const Mat& a, const Mat& b)
{
    return cvtest::norm(a, b, NORM_INF) == 0 ? 0 : double(countNonZero(a != b)) / double(a.total());
}

// ---- Tests ----

TEST(SurgTrack_QGO, quantizesEveryImageBitForBitAsDefined)
{
    const double thresholds[] = {50, 0, 7.3, 180};
    RNG rng(101);
    uint64 seed = 1;
    double edges = 0;
    for (const Size& size : SIZES)
        for (int channels = 1; channels <= 3; channels += 2)
            for (int kind = 0; kind < KINDS; kind++)
            {
                const Mat image = testImage(size, channels, kind, seed);
                const double threshold = thresholds[seed++ % 4];
                const Mat expected = referenceQuantize(image, threshold);
                edges += countNonZero(expected);
                Mat result;
                quantizeOrientations(image, result, threshold);
                ASSERT_EQ(CV_8UC1, result.type());
                ASSERT_EQ(size, result.size());
                ASSERT_EQ(0, differing(expected, result)) << size << ", " << channels << " channels, kind " << kind << ", threshold " << threshold;

                Framed source(image, rng), target(size, CV_8UC1, rng);
                quantizeOrientations(source.inner, target.inner, threshold);
                ASSERT_EQ(0, differing(expected, target.inner)) << "sub-matrices, " << size << ", " << channels << " channels, kind " << kind;
                ASSERT_TRUE(target.frameIsUntouched()) << size << ", " << channels << " channels, kind " << kind;
                ASSERT_TRUE(source.frameIsUntouched()) << size << ", " << channels << " channels, kind " << kind;
            }
    EXPECT_GT(edges, 20000);   // the comparison above was one of edges, not of empty images
}

TEST(SurgTrack_QGO, quantizesImagesOfRandomSizesBitForBitAsDefined)
{
    RNG rng(7);
    for (int i = 0; i < 60; i++)
    {
        const Size size(rng.uniform(1, 150), rng.uniform(1, 40));
        const int channels = rng.uniform(0, 2) ? 3 : 1, kind = rng.uniform(0, KINDS);
        const Framed source(testImage(size, channels, kind, 1000 + i), rng);
        const Mat expected = referenceQuantize(source.inner, 30);
        Mat result;
        quantizeOrientations(source.inner, result, 30);
        ASSERT_EQ(0, differing(expected, result)) << size << ", " << channels << " channels, kind " << kind;
    }
}

TEST(SurgTrack_QGO, quantizesWholeFramesBitForBitAsDefined)
{
    // Large enough to be shared out among threads.
    for (int channels = 1; channels <= 3; channels += 2)
    {
        const Mat image = testImage(Size(721, 577), channels, BLOTCHES, 77 + channels), expected = referenceQuantize(image, 50);
        Mat result, spread;
        quantizeOrientations(image, result, 50);
        ASSERT_EQ(0, differing(expected, result)) << channels << " channels";
        spreadOrientations(result, spread, 5);
        ASSERT_EQ(0, differing(referenceSpread(expected, 5), spread)) << channels << " channels";
        for (int bin = 0; bin < 8; bin++)
        {
            orientationResponse(spread, bin, result);
            ASSERT_EQ(0, differing(referenceResponse(spread, bin), result)) << channels << " channels, bin " << bin;
        }
    }
}

TEST(SurgTrack_QGO, aWindowIsTheCutOutOfTheWholeImage)
{
    RNG rng(3);
    for (int channels = 1; channels <= 3; channels += 2)
    {
        const Framed source(testImage(Size(173, 131), channels, BLOTCHES, 17), rng);
        const Mat& image = source.inner;
        Mat whole;
        quantizeOrientations(image, whole, 20);
        ASSERT_GT(countNonZero(whole), 5000);   // an image of edges
        std::vector<Rect> windows = {Rect(0, 0, 173, 131), Rect(0, 0, 1, 1), Rect(172, 130, 1, 1), Rect(0, 130, 173, 1), Rect(172, 0, 1, 131), Rect(1, 1, 171, 129),
                                     Rect(2, 2, 16, 16), Rect(3, 3, 64, 33), Rect(109, 0, 64, 5), Rect(108, 126, 65, 5)};
        for (int i = 0; i < 100; i++)
        {
            const int w = rng.uniform(1, 174), h = rng.uniform(1, 132);
            windows.push_back(Rect(rng.uniform(0, 174 - w), rng.uniform(0, 132 - h), w, h));
        }
        for (const Rect& window : windows)
        {
            Mat result;
            quantizeOrientations(image, window, result, 20);
            ASSERT_EQ(window.size(), result.size());
            ASSERT_EQ(0, differing(whole(window), result)) << window << ", " << channels << " channels";
        }
    }
}

TEST(SurgTrack_QGO, rampsInSixteenDirectionsFallIntoTheirBins)
{
    const int side = 25;
    for (int direction = 0; direction < 16; direction++)
        for (int off = -9; off <= 9; off += 9)   // [degree]; bins reach 11.25 to either side, grey levels are rounded
        {
            const double angle = (22.5 * direction + off) * CV_PI / 180;
            Mat_<uchar> image(side, side);
            for (int y = 0; y < side; y++)
                for (int x = 0; x < side; x++) image(y, x) = saturate_cast<uchar>(128 + 7 * (std::cos(angle) * (x - side / 2) + std::sin(angle) * (y - side / 2)));
            Mat result;
            quantizeOrientations(image, result, 20);
            const Mat inner = result(Rect(5, 5, side - 10, side - 10));   // beyond it the image's border bends the gradient
            EXPECT_EQ(int(inner.total()), countNonZero(inner == 1 << direction % 8)) << direction << " * 22.5 degrees + " << off;
        }
}

TEST(SurgTrack_QGO, theThresholdIsThatOfASobelGradient)
{
    // A ramp of s grey levels a pixel has a Sobel magnitude of 8 s.
    Mat_<uchar> image(20, 20), result;
    for (int x = 0; x < 20; x++) image.col(x).setTo(6 * x);
    quantizeOrientations(image, result, 48);
    EXPECT_EQ(1, result(10, 10));
    quantizeOrientations(image, result, 48.01);
    EXPECT_EQ(0, result(10, 10));
}

TEST(SurgTrack_QGO, theStrongestChannelDecides)
{
    Mat image(20, 20, CV_8UC3);
    for (int y = 0; y < 20; y++)
        for (int x = 0; x < 20; x++) image.at<Vec3b>(y, x) = Vec3b(uchar(4 * x), uchar(10 * y), uchar(100));
    Mat result;
    quantizeOrientations(image, result, 20);
    EXPECT_EQ(1 << 4, result.at<uchar>(10, 10));   // downwards, as the second channel
}

TEST(SurgTrack_QGO, brightnessOffsetAndInversionChangeNothing)
{
    for (int channels = 1; channels <= 3; channels += 2)
    {
        const Mat image = textured(Size(160, 120), channels, 5, 20, 190);
        Mat expected, result;
        quantizeOrientations(image, expected, 20);
        ASSERT_GT(countNonZero(expected), 2000);   // an image of edges

        Mat other = image + Scalar::all(50);
        quantizeOrientations(other, result, 20);
        EXPECT_EQ(0, differing(expected, result));

        other = Scalar::all(255) - image;
        quantizeOrientations(other, result, 20);
        EXPECT_LT(differing(expected, result), 0.03);   // halves are rounded up: off by 1/4 grey level here and there, which moves 1.3 % of these pixels over a bound
    }
}

TEST(SurgTrack_QGO, sizesAreThoseOfTheDefinitionBitForBit)
{
    RNG rng(57);
    std::vector<uchar> workspace;
    int weak = 0;
    for (int i = 0; i < 120; i++)
    {
        const Size size = i < 24 ? SIZES[i] : Size(rng.uniform(1, 450), rng.uniform(1, 40));   // wider than a strip now and then
        const int channels = rng.uniform(0, 2) ? 3 : 1;
        const Mat image = testImage(size, channels, rng.uniform(0, KINDS), 300 + i);
        const int w = rng.uniform(1, size.width + 1), h = rng.uniform(1, size.height + 1);
        const Rect window(rng.uniform(0, size.width - w + 1), rng.uniform(0, size.height - h + 1), w, h);
        Mat bits(h, w, CV_8UC1), sizes(h, w, CV_8UC1), plainBits(h, w, CV_8UC1), plainSizes(h, w, CV_8UC1);
        cv::surgtrack::quantize(image, window, 4, bits, workspace, &sizes);
        cv::surgtrack::plain::quantize(image, window, 4, plainBits, &plainSizes);
        ASSERT_EQ(0, differing(plainBits, bits)) << window;
        ASSERT_EQ(0, differing(plainSizes, sizes)) << window;

        Mat least(h, w, CV_8UC1);
        rng.fill(least, RNG::UNIFORM, 0, 256);
        for (int y = 0; y < h; y++)
        {
            cv::surgtrack::dropWeak(bits.ptr(y), sizes.ptr(y), least.ptr(y), w);
            cv::surgtrack::plain::dropWeak(plainBits.ptr(y), sizes.ptr(y), least.ptr(y), w);
        }
        ASSERT_EQ(0, differing(plainBits, bits)) << window;
        weak += countNonZero(bits);
    }
    EXPECT_GT(weak, 10000);   // not of nothing
}

TEST(SurgTrack_QGO, aUniformImageHasNoOrientations)
{
    Mat result;
    for (int channels = 1; channels <= 3; channels += 2)
    {
        quantizeOrientations(Mat(37, 53, CV_8UC(channels), Scalar::all(77)), result, 1);
        EXPECT_EQ(Size(53, 37), result.size());
        EXPECT_EQ(0, countNonZero(result));
    }
}

TEST(SurgTrack_QGO, spreadsEveryBitSetAsDefined)
{
    RNG rng(31);
    const int sides[] = {1, 3, 5, 7, 9, 15, 33};
    for (const Size& size : SIZES)
        for (int side : sides)
        {
            Mat sparse(size, CV_8UC1), bits(size, CV_8UC1);
            rng.fill(bits, RNG::UNIFORM, 0, 256);
            rng.fill(sparse, RNG::UNIFORM, 0, 256);
            bits.setTo(0, sparse > 60);
            const Mat expected = referenceSpread(bits, side);
            Mat result;
            spreadOrientations(bits, result, side);
            ASSERT_EQ(CV_8UC1, result.type());
            ASSERT_EQ(0, differing(expected, result)) << size << ", " << side;

            const Framed source(bits, rng);
            Framed target(size, CV_8UC1, rng);
            spreadOrientations(source.inner, target.inner, side);
            ASSERT_EQ(0, differing(expected, target.inner)) << "sub-matrices, " << size << ", " << side;
            ASSERT_TRUE(target.frameIsUntouched()) << size << ", " << side;

            spreadOrientations(bits, bits, side);
            ASSERT_EQ(0, differing(expected, bits)) << "in place, " << size << ", " << side;
        }
}

TEST(SurgTrack_QGO, respondsToEveryBitSetAsDefined)
{
    Mat_<uchar> all(1, 256);
    for (int i = 0; i < 256; i++) all(i) = uchar(i);
    RNG rng(41);
    for (int bin = 0; bin < 8; bin++)
    {
        Mat result;
        orientationResponse(all, bin, result);
        ASSERT_EQ(CV_8UC1, result.type());
        ASSERT_EQ(0, differing(referenceResponse(all, bin), result)) << bin;
        for (const Size& size : SIZES)
        {
            Framed source(size, CV_8UC1, rng), target(size, CV_8UC1, rng);
            orientationResponse(source.inner, bin, target.inner);
            ASSERT_EQ(0, differing(referenceResponse(source.inner, bin), target.inner)) << size << ", " << bin;
            ASSERT_TRUE(target.frameIsUntouched()) << size << ", " << bin;
        }
    }
}

TEST(SurgTrack_QGO, rejectsBadInputNamingTheArgument)
{
    Mat result;
    const int types[] = {CV_16UC1, CV_16UC3, CV_8UC2, CV_8UC4, CV_32FC1, CV_8SC1};
    for (int type : types) EXPECT_ERROR(quantizeOrientations(Mat::zeros(20, 20, type), result), "image");
    EXPECT_ERROR(quantizeOrientations(Mat(), result), "image");
    EXPECT_ERROR(quantizeOrientations(Mat(0, 7, CV_8UC1), result), "image");

    const Mat image(30, 20, CV_8UC1, Scalar(1));
    const double thresholds[] = {-1, NOT_A_NUMBER, 1e9};
    for (double threshold : thresholds) EXPECT_ERROR(quantizeOrientations(image, result, threshold), "magnitudeThreshold");
    const Rect windows[] = {Rect(), Rect(-1, 0, 5, 5), Rect(0, -1, 5, 5), Rect(16, 0, 5, 5), Rect(0, 26, 5, 5), Rect(5, 5, 0, 3), Rect(100, 100, 3, 3)};
    for (const Rect& window : windows) EXPECT_ERROR(quantizeOrientations(image, window, result), "window");

    const int sides[] = {0, -1, 2, 4};
    for (int side : sides) EXPECT_ERROR(spreadOrientations(image, result, side), "size");
    EXPECT_ERROR(spreadOrientations(Mat::zeros(5, 5, CV_16UC1), result), "orientations");
    EXPECT_ERROR(orientationResponse(image, -1, result), "bin");
    EXPECT_ERROR(orientationResponse(image, 8, result), "bin");
    EXPECT_ERROR(orientationResponse(Mat::zeros(5, 5, CV_8UC3), 0, result), "orientations");
}

}} // namespace
