// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_common.hpp"

namespace opencv_test { namespace {

// The light of a straight edge behind a lens: from `in` to `out` at `offset`, blurred.
double stepLight(double x, double offset, double in, double out, double blur)
{
    return in + (out - in) * 0.5 * (1 + std::erf((x - offset) / (blur * std::sqrt(2.))));
}

// As cameras have it: light is summed, then comes the tone curve; 255 = the light 1.
uchar toned(double light)
{
    return saturate_cast<uchar>(255 * std::sqrt(std::max(light, 0.)));
}

struct Step
{
    double offset;   // along the normal, from the centre [pixel]
    Vec3d in, out;   // light 0..1 on both sides, BGR
};

// Straight edges across the middle of an image, each replaces the light of the one before beyond it.
Mat image(const std::vector<Step>& steps, double angle, double blur = 1, int channels = 3, Size size = Size(80, 80), const Point2d& centre = Point2d(40.3, 39.6))
{
    const Point2d normal(std::cos(angle), std::sin(angle));
    Mat result(size, CV_MAKETYPE(CV_8U, channels));
    for (int y = 0; y < size.height; y++)
        for (int x = 0; x < size.width; x++)
            for (int c = 0; c < channels; c++)
            {
                const double at = (Point2d(x, y) - centre).dot(normal);
                double light = steps[0].in[c];
                for (const Step& s : steps) light += stepLight(at, s.offset, s.in[c], s.out[c], blur) - s.in[c];
                result.ptr(y)[channels * x + c] = toned(light);
            }
    return result;
}

Mat image(const Step& step, double angle, double blur = 1, int channels = 3)
{
    return image(std::vector<Step>(1, step), angle, blur, channels);
}

ContourPoint pointAt(double angle, const Point2d& at = Point2d(40.3, 39.6))
{
    ContourPoint c;
    c.link = 0;
    c.imagePoint = at;
    c.normal = Point2d(std::cos(angle), std::sin(angle));
    return c;
}

bool match(const Mat& image, double angle, ContourPoint& point, const ContourSearch& search = ContourSearch())
{
    std::vector<ContourPoint> points(1, pointAt(angle));
    const int found = matchContour(image, points, search);
    point = points[0];
    EXPECT_EQ(point.found, found == 1);
    return point.found;
}

Step grey(double offset, double in, double out)
{
    const Step s = {offset, Vec3d::all(in), Vec3d::all(out)};
    return s;
}

TEST(SurgTrack_ContourMatch, findsABlurredEdgeOfLightToAFractionOfAPixel)
{
    const Vec3d sides[][2] = {{Vec3d::all(0.02), Vec3d::all(0.3)}, {Vec3d::all(0.4), Vec3d::all(0.05)}, {Vec3d::all(0.2), Vec3d::all(0.5)}, {Vec3d::all(0.8), Vec3d::all(0.3)},
                              {Vec3d(0.3, 0.35, 0.4), Vec3d(0.05, 0.05, 0.3)}, {Vec3d(0.02, 0.02, 0.1), Vec3d(0.2, 0.2, 0.15)}};
    const double offsets[] = {-3.4, -1.75, -0.5, 0, 0.3, 1.1, 2.6};
    double worst = 0, sum = 0;
    int n = 0;
    for (size_t s = 0; s < sizeof(sides) / sizeof(sides[0]); s++)
    {
        double bias = 0;
        int m = 0;
        for (int channels = 1; channels <= 3; channels += 2)
            for (int direction = 0; direction < 24; direction++)
                for (double offset : offsets)
                {
                    const Step step = {offset, sides[s][0], sides[s][1]};
                    const double angle = direction * CV_2PI / 24;
                    ContourPoint c;
                    if (channels == 1 && std::abs(std::sqrt(sides[s][0][0]) - std::sqrt(sides[s][1][0])) < 0.1) continue;
                    ASSERT_TRUE(match(image(step, angle, 1, channels), angle, c)) << s << ", direction " << direction << ", offset " << offset;
                    const double error = c.offset - offset;
                    worst = std::max(worst, std::abs(error));
                    bias += error;
                    sum += std::abs(error);
                    m++;
                    n++;
                    EXPECT_GE(c.strength, ContourSearch().leastStrength);
                    EXPECT_GT(c.deviation, 0);
                }
        EXPECT_LT(std::abs(bias / m), 0.05) << s;   // grey levels are interpolated, not light: measured 0.04; 0.15 and more if they were not squared
    }
    EXPECT_LT(sum / n, 0.05);   // the same, and a parabola for the peak; measured: 0.039
    EXPECT_LT(worst, 0.12);     // the same; measured: 0.108
}

TEST(SurgTrack_ContourMatch, sharpAndSoftEdgesAreFoundAlike)
{
    const double blurs[] = {0.5, 0.8, 1.5, 2};
    for (double blur : blurs)
    {
        double bias = 0, worst = 0;
        int n = 0;
        for (int direction = 0; direction < 24; direction++)
            for (double offset = -2; offset <= 2; offset += 0.37)
                for (int polarity = 0; polarity < 2; polarity++)
                {
                    const double angle = direction * CV_2PI / 24;
                    ContourPoint c;
                    ASSERT_TRUE(match(image(grey(offset, polarity ? 0.05 : 0.5, polarity ? 0.5 : 0.05), angle, blur, 1), angle, c)) << blur;
                    bias += (polarity ? 1 : -1) * (c.offset - offset);   // towards the bright side
                    worst = std::max(worst, std::abs(c.offset - offset));
                    n++;
                }
        EXPECT_LT(std::abs(bias / n), 0.06) << blur;   // as above; measured: 0.052 where it is sharpest, 0.02 where it is softest
        EXPECT_LT(worst, 0.18) << blur;                // the same; measured: 0.146
    }
}

// An edge that moved by so much while the shutter was open.
Mat movedEdge(double offset, double in, double out, double angle, double width, const Point2d& centre = Point2d(40.3, 39.6))
{
    const Point2d normal(std::cos(angle), std::sin(angle));
    Mat result(80, 80, CV_8U);
    for (int y = 0; y < result.rows; y++)
        for (int x = 0; x < result.cols; x++)
        {
            const double at = ((Point2d(x, y) - centre).dot(normal) - offset) / width + 0.5;
            result.at<uchar>(y, x) = toned(in + (out - in) * std::min(std::max(at, 0.), 1.));
        }
    return result;
}

TEST(SurgTrack_ContourMatch, anEdgeBlurredByMotionIsInTheMiddleOfItsRamp)
{
    const double sides[][2] = {{0.05, 0.5}, {0.2, 0.5}};
    for (int width = 5; width <= 13; width += 2)
        for (const double* side : sides)
        {
            double worst = 0, bias = 0;
            int n = 0;
            for (int direction = 0; direction < 12; direction++)
                for (double offset = -2; offset <= 2; offset += 0.37)
                    for (int polarity = 0; polarity < 2; polarity++)
                    {
                        const double angle = direction * CV_2PI / 12;
                        ContourPoint c;
                        ASSERT_TRUE(match(movedEdge(offset, side[1 - polarity], side[polarity], angle, width), angle, c)) << width << ", offset " << offset;
                        worst = std::max(worst, std::abs(c.offset - offset));
                        bias += (polarity ? 1 : -1) * (c.offset - offset);   // towards the bright side
                        n++;
                    }
            if (std::getenv("SURGTRACK_TEST_PRINT")) std::cout << width << " px, " << side[0] << ": worst " << worst << ", bias " << bias / n << " px" << std::endl;
            EXPECT_LT(std::abs(bias / n), 0.06) << width << ", " << side[0];   // as that of sharp edges; 0.6 to 1.6 if grey levels were not squared
            EXPECT_LT(worst, 0.3) << width << ", " << side[0];                 // steps of rounded grey levels, which end a ramp early or late
        }
}

TEST(SurgTrack_ContourMatch, ambiguousEdgesAreLeftOut)
{
    // Two edges alike, on both sides of the expected place.
    std::vector<Step> steps(1, grey(-4, 0.05, 0.4));
    steps.push_back(grey(4, 0.4, 0.05));
    ContourSearch search;
    ContourPoint c;
    search.ambiguity = 0.8;
    EXPECT_FALSE(match(image(steps, 0.3), 0.3, c, search));
    search.ambiguity = 1;   // the better one, by however little
    EXPECT_TRUE(match(image(steps, 0.3), 0.3, c, search));
    EXPECT_NEAR(4, std::abs(c.offset), 0.2);   // as sharp edges are found
    search.ambiguity = 0;   // only where there is no other
    steps[1] = grey(4, 0.4, 0.3);
    EXPECT_FALSE(match(image(steps, 0.3), 0.3, c, search));
    EXPECT_TRUE(match(image(grey(-4, 0.05, 0.4), 0.3), 0.3, c, search));
    // One of them nearer: it is preferred, and no longer ambiguous.
    search = ContourSearch();
    search.preference = 0.5;
    search.ambiguity = 0.8;
    steps[0] = grey(-1, 0.05, 0.4);
    steps[1] = grey(6, 0.4, 0.05);
    EXPECT_TRUE(match(image(steps, 0.3), 0.3, c, search));
    EXPECT_NEAR(-1, c.offset, 0.2);
}

TEST(SurgTrack_ContourMatch, nearerEdgesArePreferredAsTheParameterSays)
{
    // At preference * halfWindow an edge counts 0.6 of what it counts at the expected place.
    ContourSearch search;
    search.halfWindow = 10;
    search.preference = 0.6;
    search.ambiguity = 1;
    const double base = 60, weak = 40;   // grey levels
    const double ratios[] = {1.4, 2};
    for (double ratio : ratios)
    {
        const double levels[] = {base, base + weak, base + weak + weak * ratio};
        std::vector<Step> steps;
        for (int i = 0; i < 2; i++)
        {
            const double a = levels[i] / 255, b = levels[i + 1] / 255;
            steps.push_back(grey(i ? 6 : 0, a * a, b * b));
        }
        ContourPoint c;
        const Mat scene = image(steps, 0, 1, 1, Size(80, 80), Point2d(40, 40));   // both on pixels
        std::vector<ContourPoint> points(1, pointAt(0, Point2d(40, 40)));
        EXPECT_EQ(1, matchContour(scene, points, search));
        EXPECT_NEAR(ratio * 0.607 > 1 ? 6 : 0, points[0].offset, 0.3) << ratio;   // tone curve and blur of the other edge
        search.preference = 0;   // all the same: the stronger one
        EXPECT_EQ(1, matchContour(scene, points, search));
        EXPECT_NEAR(6, points[0].offset, 0.3) << ratio;
        search.preference = 0.6;
    }
}

TEST(SurgTrack_ContourMatch, edgesOutsideTheWindowAreNotFound)
{
    const double halves[] = {1, 3, 5.4, 8, 16, 24};
    for (double half : halves)
    {
        ContourSearch search;
        search.halfWindow = half;
        search.preference = 0;
        for (double offset = -26.25; offset <= 26.25; offset += 0.75)
            for (int direction = 0; direction < 2; direction++)
            {
                const double angle = direction * 0.7;
                ContourPoint c;
                const bool found = match(image(grey(offset, 0.05, 0.4), angle), angle, c, search);
                if (std::abs(offset) < half - 1)
                {
                    EXPECT_TRUE(found) << half << ", " << offset;
                }
                if (std::abs(offset) > half + 1.5)
                {
                    EXPECT_FALSE(found) << half << ", " << offset;
                }
                if (found)
                {
                    EXPECT_NEAR(offset, c.offset, 0.2) << half << ", " << offset;
                    EXPECT_LE(std::abs(c.offset), half + 2);   // half a sample of rounding, and 1.5 of the peak's interpolation
                }
            }
    }
}

TEST(SurgTrack_ContourMatch, weakEdgesAndSmoothImagesHaveNone)
{
    ContourPoint c;
    EXPECT_FALSE(match(Mat(80, 80, CV_8UC3, Scalar::all(120)), 0.3, c));
    Mat ramp(80, 80, CV_8UC1);
    for (int y = 0; y < 80; y++)
        for (int x = 0; x < 80; x++) ramp.at<uchar>(y, x) = uchar(40 + 2 * x);
    EXPECT_FALSE(match(ramp, 0, c));
    // A step of 60 levels, blurred by a pixel, changes by about 20 a pixel.
    const double a = 80 / 255., b = 140 / 255.;
    const Mat step = image(grey(0.5, a * a, b * b), 0.3);
    ContourSearch search;
    search.contrast = 0;
    search.minStrength = 12;
    ASSERT_TRUE(match(step, 0.3, c, search));
    const double strength = c.strength;
    search.minStrength = strength * 1.05;
    EXPECT_FALSE(match(step, 0.3, c, search));
    search.minStrength = strength * 0.95;
    EXPECT_TRUE(match(step, 0.3, c, search));
    // A stronger edge is a surer one.
    const double deviation = c.deviation;
    ASSERT_TRUE(match(image(grey(0.5, 0.02, 0.8), 0.3), 0.3, c));
    EXPECT_GT(c.strength, strength);
    EXPECT_LE(c.deviation, deviation);
}

TEST(SurgTrack_ContourMatch, inDimLightTheSameEdgesAreFound)
{
    // Points along an outline in texture; the second row of them looks at texture only.
    Mat scene = textured(Size(240, 200), 3, 4, 70, 150);
    scene.colRange(120, 240).setTo(Scalar::all(230));
    GaussianBlur(scene, scene, Size(5, 5), 1);
    std::vector<ContourPoint> points;
    for (int y = 30; y < 170; y += 2)
        for (int x = 60; x <= 120; x += 60) points.push_back(pointAt(0, Point2d(x + 0.3, y)));
    ContourSearch search;
    std::vector<ContourPoint> bright = points;
    const int expected = matchContour(scene, bright, search);
    ASSERT_GT(expected, 60);
    const double gains[] = {0.25, 0.4, 0.6};
    for (double gain : gains)
    {
        Mat dim;
        scene.convertTo(dim, CV_8U, gain);
        std::vector<ContourPoint> dark = points;
        matchContour(dim, dark, search);
        int same = 0;
        double off = 0;
        for (size_t i = 0; i < points.size(); i++)
        {
            same += dark[i].found == bright[i].found;
            if (dark[i].found && bright[i].found && i % 2) off = std::max(off, std::abs(dark[i].offset - bright[i].offset));
        }
        EXPECT_GT(same, 0.85 * double(points.size())) << gain;   // of texture, some are as strong as the least
        EXPECT_LT(off, 0.15) << gain;                            // grey levels are rounded
        search.contrast = 0;
        std::vector<ContourPoint> fixed = points;
        if (gain < 0.3) EXPECT_LT(matchContour(dim, fixed, search), 0.75 * expected);   // what it is good for
        search.contrast = ContourSearch().contrast;
    }
}

TEST(SurgTrack_ContourMatch, pointsAtTheBorderAndOutsideAreNotFound)
{
    const Mat scene = image(grey(0, 0.05, 0.4), 0);   // at x = 40.3
    ContourSearch search;
    search.halfWindow = 5;
    for (int y = -20; y < 100; y++)
    {
        std::vector<ContourPoint> points(1, pointAt(0, Point2d(40, y)));
        const bool inside = y >= 0 && y < 79;   // a profile along x needs this row and the next
        EXPECT_EQ(inside, matchContour(scene, points, search) == 1) << y;
        EXPECT_EQ(inside, points[0].found) << y;
    }
    std::vector<ContourPoint> points;
    const double far[] = {-1e9, -9, 0, 3, 77, 79, 80, 1e9, NOT_A_NUMBER, std::numeric_limits<double>::infinity()};
    for (double x : far)
        for (double y : far)
        {
            points.push_back(pointAt(0.3, Point2d(x, y)));
            points.back().found = true;   // of another image
        }
    points.push_back(pointAt(NOT_A_NUMBER, Point2d(40, 40)));
    EXPECT_EQ(0, matchContour(scene, points, search));
    for (const ContourPoint& c : points) EXPECT_FALSE(c.found) << c.imagePoint;

    // Profiles that end on the last pixel: nothing outside the image is read.
    RNG rng(23);
    for (int i = 0; i < 2000; i++)
    {
        const Mat part = scene(Rect(rng.uniform(0, 20), rng.uniform(0, 20), rng.uniform(20, 60), rng.uniform(20, 60)));
        const Mat copy = part.clone();
        std::vector<ContourPoint> a(1, pointAt(rng.uniform(0, 4) * CV_PI / 2, Point2d(rng.uniform(0, 2) ? 9 : part.cols - 10, rng.uniform(0, 2) ? 9 : part.rows - 10))), b = a;
        ASSERT_EQ(matchContour(part, a, search), matchContour(copy, b, search));
        ASSERT_EQ(a[0].offset, b[0].offset);
    }
}

TEST(SurgTrack_ContourMatch, tinyImagesHaveNone)
{
    for (int side = 1; side < 24; side++)
    {
        std::vector<ContourPoint> points;
        for (int i = 0; i < 8; i++) points.push_back(pointAt(i, Point2d(side / 2., side / 2.)));
        EXPECT_EQ(0, matchContour(Mat(side, 25 - side, CV_8UC1, Scalar(7)), points, ContourSearch())) << side;
    }
    std::vector<ContourPoint> none;
    EXPECT_EQ(0, matchContour(Mat(80, 80, CV_8UC1, Scalar(7)), none, ContourSearch()));
}

TEST(SurgTrack_ContourMatch, colourTellsWhereGreyDoesNot)
{
    // Two colours that are equally bright in the first channel.
    Step step = {1, Vec3d(0.2, 0.4, 0.1), Vec3d(0.2, 0.1, 0.4)};
    ContourPoint c;
    EXPECT_FALSE(match(image(step, 0.3, 1, 1), 0.3, c));
    ASSERT_TRUE(match(image(step, 0.3), 0.3, c));
    EXPECT_NEAR(1, c.offset, 0.1);
}

TEST(SurgTrack_ContourMatch, rejectsBadInputNamingTheArgument)
{
    std::vector<ContourPoint> points(1, pointAt(0));
    EXPECT_THROW(matchContour(Mat(), points, ContourSearch()), cv::Exception);
    const int types[] = {CV_8UC2, CV_8UC4, CV_16UC1, CV_32FC3};
    for (int type : types) EXPECT_THROW(matchContour(Mat(80, 80, type, Scalar::all(0)), points, ContourSearch()), cv::Exception) << type;

    const Mat scene = image(grey(0, 0.05, 0.4), 0);
    double ContourSearch::* const members[] = {&ContourSearch::halfWindow, &ContourSearch::preference, &ContourSearch::minStrength, &ContourSearch::contrast,
                                               &ContourSearch::leastStrength, &ContourSearch::ambiguity};
    const char* const names[] = {"halfWindow", "preference", "minStrength", "contrast", "leastStrength", "ambiguity"};
    const double values[] = {-1, NOT_A_NUMBER, std::numeric_limits<double>::infinity()};
    for (int i = 0; i < 6; i++)
        for (double value : values)
        {
            ContourSearch search;
            search.*members[i] = value;
            EXPECT_ERROR(matchContour(scene, points, search), names[i]);
        }
    ContourSearch search;
    search.halfWindow = 0.5;
    EXPECT_ERROR(matchContour(scene, points, search), "halfWindow");
    search.halfWindow = 41;
    EXPECT_ERROR(matchContour(scene, points, search), "halfWindow");
    search.halfWindow = 8;
    search.ambiguity = 1.1;
    EXPECT_ERROR(matchContour(scene, points, search), "ambiguity");
}

}} // namespace
