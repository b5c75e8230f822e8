// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_common.hpp"
#include <numeric>

namespace opencv_test { namespace {

// The tool's shading, lit a little from everywhere, over darker textured noise, all of it moved.
Mat pictureOf(const CameraModel& camera, const PosedTool& tool, const Point& shift, int channels = 3, uint64 seed = 9)
{
    Mat depth, ids, shading, picture = textured(camera.imageSize(), channels, seed, 30, 110);
    MeshRenderer::createSoftware()->renderTool(tool.model, tool.joints, tool.view.camera_T_base, camera, depth, ids, shading);
    shading = 0.85 * shading + 40;
    const Rect image(Point(), camera.imageSize()), to = (image + shift) & image, from = to - shift;
    Mat drawn;
    merge(std::vector<Mat>(channels, shading(from)), drawn);
    drawn.copyTo(picture(to), ids(from) != 0);
    return picture;
}

std::vector<PartTemplate> templatesOf(const CameraModel& camera, const PosedTool& tool)
{
    Ptr<PartTemplateRenderer> renderer = PartTemplateRenderer::create();
    renderer->addTool(tool.model);
    return renderer->renderTool(camera, tool.view.camera_T_base, tool.joints);
}

std::vector<Rect> windowsAround(const std::vector<PartTemplate>& templates, int halfWidth)
{
    std::vector<Rect> windows;
    for (const PartTemplate& t : templates)
        windows.push_back(Rect(t.anchor.x - halfWidth, t.anchor.y - halfWidth, 2 * halfWidth + 1, 2 * halfWidth + 1));
    return windows;
}

// Features all over a box; offsets may repeat.
PartTemplate randomTemplate(int features, int reach, RNG& rng)
{
    PartTemplate t;
    t.part = rng.uniform(0, 14);
    for (int i = 0; i < features; i++)
    {
        TemplateFeature f;
        f.x = short(rng.uniform(-reach, reach + 1));
        f.y = short(rng.uniform(-reach, reach + 1));
        f.bin = uchar(rng.uniform(0, 8));
        t.features.push_back(f);
    }
    t.bounds = Rect(-reach, -reach, 2 * reach + 1, 2 * reach + 1);
    t.anchor = Point(rng.uniform(0, 100), rng.uniform(0, 100));
    t.imagePoint = Point2d(t.anchor) + Point2d(rng.uniform(-0.5, 0.5), rng.uniform(-0.5, 0.5));
    return t;
}

// The similarity as documented, from the public stages; what lies outside the region counts as not found.
Mat referenceSimilarity(const Mat& image, const Rect& region, const PartTemplate& t, const Rect& window, const QGOMatcher::Params& params)
{
    Mat orientations, spread, responses[8];
    quantizeOrientations(image, region, orientations, params.magnitudeThreshold);
    spreadOrientations(orientations, spread, params.spread);
    for (int b = 0; b < 8; b++) orientationResponse(spread, b, responses[b]);
    Mat_<ushort> result(window.size(), ushort(0));
    for (int y = 0; y < window.height; y++)
        for (int x = 0; x < window.width; x++)
            for (const TemplateFeature& f : t.features)
            {
                const Point p = Point(x + f.x, y + f.y) + window.tl();
                if (region.contains(p)) result(y, x) = ushort(result(y, x) + responses[f.bin].at<uchar>(p - region.tl()));
            }
    return std::move(result);
}

// The best place that is left, row by row; then its neighbourhood is gone.
bool takeBest(Mat_<ushort>& map, int radius, double& best, Point& at)
{
    best = 0;
    for (int y = 0; y < map.rows; y++)
        for (int x = 0; x < map.cols; x++)
            if (map(y, x) > best) best = map(y, x), at = Point(x, y);
    for (int y = std::max(0, at.y - radius); y <= std::min(map.rows - 1, at.y + radius); y++)
        for (int x = std::max(0, at.x - radius); x <= std::min(map.cols - 1, at.x + radius); x++) map(y, x) = 0;
    return best > 0;
}

bool fallingSimilarity(const std::vector<PartMatch>& matches)
{
    for (size_t i = 1; i < matches.size(); i++)
        if (matches[i].similarity > matches[i - 1].similarity) return false;
    return true;
}

TEST(SurgTrack_QGOMatcher, findsEveryPartWhereItWasPasted)
{
    const CameraModel camera = endoscope();
    const PosedTool views[] = {PosedTool(0.1, 0.3, 1.1, 0.35), PosedTool(0.09, 2.5, 1.1, -0.3), PosedTool(0.14, -1.9, 2.1, 0.5)};
    const Point shifts[] = {Point(0, 0), Point(7, -5), Point(-23, 17), Point(31, 29)};
    Ptr<QGOMatcher> matcher = QGOMatcher::create();
    std::vector<double> offs;
    for (const PosedTool& view : views)
    {
        const std::vector<PartTemplate> templates = templatesOf(camera, view);
        ASSERT_GE(templates.size(), 6u);
        for (const Point& shift : shifts)
            for (int channels = 1; channels <= 3; channels += 2)
            {
                matcher->setImage(pictureOf(camera, view, shift, channels));
                std::vector<PartMatch> matches;
                matcher->match(templates, windowsAround(templates, 40), matches);
                EXPECT_TRUE(fallingSimilarity(matches));
                std::vector<int> seen(templates.size(), 0);
                for (const PartMatch& m : matches)
                {
                    ASSERT_GE(m.templateIndex, 0);
                    ASSERT_LT(m.templateIndex, int(templates.size()));
                    const PartTemplate& t = templates[m.templateIndex];
                    EXPECT_EQ(t.part, m.part);
                    EXPECT_EQ(t.tool, m.tool);
                    EXPECT_EQ(t.imagePoint, m.predictedPoint);
                    if (seen[m.templateIndex]++) continue;   // the first of a part is its best
                    const double off = cv::norm(m.imagePoint - t.imagePoint - Point2d(shift));
                    EXPECT_LT(off, 2.5) << "part " << t.part << ", " << shift;   // half of the 5 x 5 pixels to which spreading flattens a peak
                    offs.push_back(off);
                    EXPECT_GT(m.similarity, 0.9) << "part " << t.part << ", " << shift;   // all but the background's edges and the vote's ties agree
                }
                for (size_t i = 0; i < templates.size(); i++) EXPECT_GE(seen[i], 1) << "part " << templates[i].part << ", " << shift;
            }
    }
    std::sort(offs.begin(), offs.end());
    EXPECT_LT(std::accumulate(offs.begin(), offs.end(), 0.) / offs.size(), 0.25);   // measured: 0.15; the background pulls at outlines
    EXPECT_LT(offs[offs.size() * 95 / 100], 0.7);   // measured: 0.48
    EXPECT_LT(offs[offs.size() * 99 / 100], 1.3);   // measured: 1.13, and 1.46 the worst of 192: shafts, whose peaks are ridges
}

TEST(SurgTrack_QGOMatcher, anExactCopyIsFoundWithoutBias)
{
    // Templates cut from the image itself: peaks are flat, as wide as the spreading, and their centre is the place.
    Mat image = textured(Size(300, 220), 3, 4), orientations;
    GaussianBlur(image, image, Size(), 2);
    cv::normalize(image, image, 0, 255, NORM_MINMAX);
    quantizeOrientations(image, orientations);
    Ptr<QGOMatcher> matcher = QGOMatcher::create();
    matcher->setImage(image);
    std::vector<PartTemplate> templates;
    for (int y = 60; y < 170; y += 22)
        for (int x = 60; x < 250; x += 27)
        {
            PartTemplate t;
            t.anchor = Point(x, y);
            t.imagePoint = Point2d(x + 0.3, y - 0.2);
            t.bounds = Rect(-20, -20, 41, 41);
            for (int j = -20; j <= 20; j++)
                for (int i = -20; i <= 20; i++)
                    for (int b = 0; b < 8; b++)
                        if (orientations.at<uchar>(y + j, x + i) == 1 << b)
                        {
                            const TemplateFeature f = {short(i), short(j), uchar(b)};
                            t.features.push_back(f);
                        }
            ASSERT_GT(t.features.size(), 100u);
            templates.push_back(t);
        }
    std::vector<PartMatch> matches;
    matcher->match(templates, windowsAround(templates, 30), matches);
    std::set<int> seen;
    Point2d mean;
    double worst = 0;
    for (const PartMatch& m : matches)
    {
        if (!seen.insert(m.templateIndex).second) continue;
        EXPECT_EQ(1, m.similarity);
        const Point2d off = m.imagePoint - m.predictedPoint;
        mean += off * (1. / double(templates.size()));
        worst = std::max(worst, cv::norm(off));
    }
    EXPECT_EQ(templates.size(), seen.size());
    EXPECT_LT(cv::norm(mean), 0.05) << mean;   // nothing prefers a side
    EXPECT_LT(worst, 0.2);                     // what lies around makes a peak's top uneven by hundredths of a pixel
}

TEST(SurgTrack_QGOMatcher, findsPartsInTheWholeImage)
{
    const CameraModel camera = endoscope(true, Size(360, 288));
    const PosedTool tool;
    const std::vector<PartTemplate> templates = templatesOf(camera, tool);
    const Point shift(41, 55);
    Ptr<QGOMatcher> matcher = QGOMatcher::create();
    matcher->setImage(pictureOf(camera, tool, shift));
    std::vector<PartMatch> matches;
    matcher->match(templates, std::vector<Rect>(), matches);
    std::set<int> seen;
    for (const PartMatch& m : matches)
    {
        if (!seen.insert(m.templateIndex).second) continue;
        EXPECT_LT(cv::norm(m.imagePoint - m.predictedPoint - Point2d(shift)), 1.3) << m.part;   // as above
    }
    EXPECT_EQ(templates.size(), seen.size());
}

// Matches of one template, in their order.
std::vector<PartMatch> ofTemplate(const std::vector<PartMatch>& matches, size_t index)
{
    std::vector<PartMatch> result;
    for (const PartMatch& m : matches)
        if (m.templateIndex == int(index)) result.push_back(m);
    return result;
}

TEST(SurgTrack_QGOMatcher, theWholeImageSearchFindsWhatTheDenseSearchFinds)
{
    const CameraModel camera = endoscope(true, Size(360, 288));
    const PosedTool views[] = {PosedTool(), PosedTool(0.1, 0.3, 1.1, 0.35), PosedTool(0.12, 2.5, 1.1, -0.3)};
    const Rect image(Point(), camera.imageSize());
    Ptr<QGOMatcher> matcher = QGOMatcher::create();
    size_t searches = 0, sameLists = 0;
    for (const PosedTool& view : views)
    {
        const std::vector<PartTemplate> templates = templatesOf(camera, view);
        for (int i = 0; i < 4; i++)
        {
            matcher->setImage(pictureOf(camera, view, Point(13 * i - 20, 7 * i - 11), 3, 20 + i));
            std::vector<PartMatch> whole, dense;
            matcher->match(templates, std::vector<Rect>(), whole);
            // A window that is not quite the image is searched place by place.
            matcher->match(templates, std::vector<Rect>(templates.size(), Rect(1, 0, image.width - 1, image.height)), dense);
            for (size_t t = 0; t < templates.size(); t++)
            {
                const std::vector<PartMatch> a = ofTemplate(whole, t), b = ofTemplate(dense, t);
                searches++;
                ASSERT_EQ(b.empty(), a.empty()) << t;
                if (b.empty()) continue;
                EXPECT_EQ(b[0].similarity, a[0].similarity) << t;   // bounds of cells guarantee it
                EXPECT_LT(cv::norm(b[0].imagePoint - a[0].imagePoint), 1e-9) << t;
                bool same = a.size() == b.size();
                for (size_t k = 0; k < std::min(a.size(), b.size()); k++)
                {
                    EXPECT_LE(a[k].similarity, b[k].similarity);    // never better than all places
                    same = same && a[k].similarity == b[k].similarity && cv::norm(a[k].imagePoint - b[k].imagePoint) < 1e-9;
                }
                sameLists += same;
            }
        }
    }
    EXPECT_GT(searches, 80u);
    EXPECT_GE(sameLists, 0.8 * double(searches)) << searches;   // weaker candidates come from fewer cells
}

TEST(SurgTrack_QGOMatcher, theWholeImageSearchFindsTheBestPlaceOfAnyTemplateInAnyRegion)
{
    RNG rng(77);
    QGOMatcher::Params params;
    params.magnitudeThreshold = 15;
    params.contrast = 0;
    params.minSimilarity = 0.01;
    Ptr<QGOMatcher> matcher = QGOMatcher::create(params);
    for (int round = 0; round < 150; round++)
    {
        const Size size(rng.uniform(1, 150), rng.uniform(1, 110));
        const Rect all(Point(), size);
        const Mat image = textured(size, round % 2 ? 3 : 1, 100 + round);
        Rect roi;
        if (round % 3 == 0) roi = Rect(rng.uniform(-20, 100), rng.uniform(-20, 70), rng.uniform(1, 90), rng.uniform(1, 90));
        matcher->setImage(image, roi);
        std::vector<PartTemplate> templates;
        const int counts[] = {1, 63, 64, 300}, reaches[] = {3, 20, 60, 200};   // the last reach further than the image
        for (int i = 0; i < 4; i++) templates.push_back(randomTemplate(counts[(round + i) % 4], reaches[i], rng));
        std::vector<PartMatch> matches;
        matcher->match(templates, std::vector<Rect>(), matches);
        for (size_t i = 0; i < templates.size(); i++)
        {
            const std::vector<PartMatch> found = ofTemplate(matches, i);
            Mat_<ushort> map;
            matcher->similarityMap(templates[i], all, map);
            const double best = *std::max_element(map.begin(), map.end()) / (4. * double(templates[i].features.size()));
            if (best < 0.01) EXPECT_TRUE(found.empty()) << size << " " << roi;
            else
            {
                ASSERT_FALSE(found.empty()) << size << " " << roi;
                EXPECT_EQ(best, found[0].similarity) << size << " " << roi << " " << i;
            }
        }
    }
}

TEST(SurgTrack_QGOMatcher, theSimilarityMapEqualsTheSumOverFeatures)
{
    RNG rng(5);
    QGOMatcher::Params params;
    params.magnitudeThreshold = 15;
    params.contrast = 0;
    const int counts[] = {1, 2, 63, 64, 127, 1000};
    const Size sizes[] = {Size(131, 97), Size(64, 64), Size(17, 31)};
    for (const Size& size : sizes)
        for (int channels = 1; channels <= 3; channels += 2)
        {
            const Mat image = textured(size, channels, size.width + channels);
            Ptr<QGOMatcher> matcher = QGOMatcher::create(params);
            matcher->setImage(image);
            for (int count : counts)
            {
                const PartTemplate t = randomTemplate(count, count % 2 ? 20 : 170, rng);   // some far larger than the image
                // Inside, over the border, and outside of the image.
                const Rect windows[] = {Rect(3, 2, std::min(50, size.width - 3), std::min(33, size.height - 2)), Rect(-13, -7, 45, 31),
                                        Rect(size.width - 9, size.height - 3, 33, 17), Rect(-60, -60, 20, 19),
                                        Rect(size.width + 200, -300, 20, 19), Rect(-150, -99, 260, 210), Rect(Point(), size), Rect(1, 1, 1, 1)};
                for (const Rect& window : windows)
                {
                    Mat map;
                    matcher->similarityMap(t, window, map);
                    ASSERT_EQ(CV_16UC1, map.type());
                    ASSERT_EQ(window.size(), map.size());
                    ASSERT_EQ(0, cvtest::norm(map, referenceSimilarity(image, Rect(Point(), size), t, window, params), NORM_INF))
                        << size << ", " << channels << " channels, " << count << " features, " << window;
                }
            }
        }
}

TEST(SurgTrack_QGOMatcher, sumsOfManyFeaturesDoNotOverflow)
{
    // Every feature responds with the full 4 everywhere: more than a byte holds from 64 features on.
    Mat_<uchar> image(80, 80);
    for (int x = 0; x < 80; x++) image.col(x).setTo(3 * x);
    QGOMatcher::Params params;
    params.magnitudeThreshold = 20;
    params.contrast = 0;
    Ptr<QGOMatcher> matcher = QGOMatcher::create(params);
    matcher->setImage(image);
    const int counts[] = {63, 64, 65, 127, 255, 256, 1000, 5000};
    RNG rng(6);
    for (int count : counts)
    {
        PartTemplate t = randomTemplate(count, 10, rng);
        for (TemplateFeature& f : t.features) f.bin = 0;
        Mat map;
        matcher->similarityMap(t, Rect(20, 20, 37, 33), map);
        EXPECT_EQ(0, countNonZero(map != 4 * count)) << count;
        std::vector<PartMatch> matches;
        matcher->match(std::vector<PartTemplate>(1, t), std::vector<Rect>(1, Rect(20, 20, 37, 33)), matches);
        ASSERT_FALSE(matches.empty());
        EXPECT_EQ(1, matches[0].similarity) << count;
    }
    std::vector<PartMatch> matches;
    EXPECT_ERROR(matcher->match(std::vector<PartTemplate>(1, randomTemplate(16384, 10, rng)), std::vector<Rect>(), matches), "features");
}

TEST(SurgTrack_QGOMatcher, matchesAreTheBestPlacesOfTheMapWithTheirNeighbourhoodsSuppressed)
{
    RNG rng(8);
    const Mat image = textured(Size(190, 140), 1, 21);
    int full = 0, fewer = 0;
    for (int round = 0; round < 60; round++)
    {
        QGOMatcher::Params params;
        params.magnitudeThreshold = 15;
        params.contrast = 0;
        params.candidates = rng.uniform(1, 9);
        params.suppressionRadius = rng.uniform(0, 12);
        params.minSimilarity = rng.uniform(0.2, 0.55);
        params.relativeSimilarity = rng.uniform(0.6, 1.);
        Ptr<QGOMatcher> matcher = QGOMatcher::create(params);
        matcher->setImage(image);
        const PartTemplate t = randomTemplate(40, 12, rng);
        const Rect window(rng.uniform(0, 100), rng.uniform(0, 70), rng.uniform(1, 90), rng.uniform(1, 70));
        Mat_<ushort> map;
        matcher->similarityMap(t, window, map);
        std::vector<PartMatch> matches;
        matcher->match(std::vector<PartTemplate>(1, t), std::vector<Rect>(1, window), matches);

        size_t expected = 0;
        double weakest = params.minSimilarity * 160, best;
        Point at;
        while (int(expected) < params.candidates && takeBest(map, params.suppressionRadius, best, at) && best >= weakest)
        {
            if (expected == 0) weakest = std::max(weakest, params.relativeSimilarity * best);
            ASSERT_LT(expected, matches.size()) << round;
            const PartMatch& m = matches[expected++];
            ASSERT_EQ(best / 160, m.similarity) << round;
            const Point2d place = m.imagePoint - (t.imagePoint - Point2d(t.anchor)), off = place - Point2d(at + window.tl());
            ASSERT_LE(std::max(std::abs(off.x), std::abs(off.y)), 4 + 1e-9) << round;   // the centre of a peak that spreading made 5 x 5, seen from its first corner
        }
        ASSERT_EQ(expected, matches.size()) << round;
        (int(expected) == params.candidates ? full : fewer)++;
    }
    EXPECT_GT(full, 5);     // both ways to end occurred
    EXPECT_GT(fewer, 5);
}

TEST(SurgTrack_QGOMatcher, candidatesOfAllPartsAreSortedAndKeepTheirLimits)
{
    const CameraModel camera = endoscope();
    const PosedTool tool;
    const std::vector<PartTemplate> templates = templatesOf(camera, tool);
    QGOMatcher::Params params;
    params.minSimilarity = 0.4;
    params.relativeSimilarity = 0.6;
    Ptr<QGOMatcher> matcher = QGOMatcher::create(params);
    matcher->setImage(pictureOf(camera, tool, Point(11, 3)));
    std::vector<PartMatch> matches;
    matcher->match(templates, windowsAround(templates, 60), matches);
    EXPECT_TRUE(fallingSimilarity(matches));
    std::vector<std::vector<PartMatch> > ofPart(templates.size());
    for (const PartMatch& m : matches) ofPart[m.templateIndex].push_back(m);
    size_t several = 0;
    for (const std::vector<PartMatch>& part : ofPart)
    {
        ASSERT_FALSE(part.empty());
        EXPECT_LE(part.size(), 5u);
        several += part.size() > 1;
        for (const PartMatch& m : part)
        {
            EXPECT_GE(m.similarity, 0.4);
            EXPECT_GE(m.similarity, 0.6 * part[0].similarity);
            EXPECT_LE(m.similarity, 1);
        }
    }
    EXPECT_GT(several, templates.size() / 2);   // the limits had something to limit
}

TEST(SurgTrack_QGOMatcher, windowsMayReachOverTheImageOrBeEmpty)
{
    const CameraModel camera = endoscope(true, Size(360, 288));
    const PosedTool tool;
    const std::vector<PartTemplate> templates = templatesOf(camera, tool);
    Ptr<QGOMatcher> matcher = QGOMatcher::create();
    matcher->setImage(pictureOf(camera, tool, Point(2, 3)));
    std::vector<PartMatch> whole, matches;
    matcher->match(templates, std::vector<Rect>(), whole);
    matcher->match(templates, std::vector<Rect>(templates.size(), Rect(-50, -60, 500, 400)), matches);
    EXPECT_TRUE(sameMatches(whole, matches));

    const Rect nothing[] = {Rect(), Rect(10, 10, 0, 5), Rect(10, 10, 5, 0), Rect(-100, -100, 50, 50), Rect(360, 0, 20, 20), Rect(0, 288, 20, 20), Rect(50, 50, -3, 7)};
    for (const Rect& window : nothing)
    {
        matcher->match(templates, std::vector<Rect>(templates.size(), window), matches);
        EXPECT_TRUE(matches.empty()) << window;
    }
    std::vector<Rect> one(templates.size());
    one[1] = windowsAround(templates, 20)[1];
    matcher->match(templates, one, matches);
    ASSERT_FALSE(matches.empty());
    for (const PartMatch& m : matches)
    {
        EXPECT_EQ(1, m.templateIndex);
        EXPECT_LE(std::abs(m.imagePoint.x - templates[1].anchor.x), 20.5);   // in its window; the keypoint lies up to half a pixel beside the anchor
        EXPECT_LE(std::abs(m.imagePoint.y - templates[1].anchor.y), 20.5);
    }
    matcher->match(std::vector<PartTemplate>(), std::vector<Rect>(), matches);
    EXPECT_TRUE(matches.empty());
    matcher->match(std::vector<PartTemplate>(1), std::vector<Rect>(), matches);   // without features
    EXPECT_TRUE(matches.empty());
}

// Bright edges on weaker texture, in the light of a gain, a tone curve and haze of some opacity.
Mat litScene(double gain, double gamma, double haze, int channels)
{
    Mat scene = textured(Size(320, 256), channels, 9, 85, 125);
    for (int i = 0; i < 6; i++) line(scene, Point(20 + 50 * i, 10), Point(60 + 40 * i, 240), Scalar::all(i % 2 ? 20 : 200), 9);
    Mat lit(scene.size(), scene.type());
    for (int y = 0; y < scene.rows; y++)
        for (int x = 0; x < scene.cols * channels; x++)
        {
            const double level = 255 * std::pow(scene.ptr(y)[x] / 255., gamma) * gain;
            lit.ptr(y)[x] = saturate_cast<uchar>(level * (1 - haze) + 200 * haze * gain);
        }
    return lit;
}

Mat orientationsOf(const Mat& image, const QGOMatcher::Params& params = QGOMatcher::Params())
{
    Ptr<QGOMatcher> matcher = QGOMatcher::create(params);
    matcher->setImage(image);
    Mat result;
    matcher->orientations(result);
    return result;
}

TEST(SurgTrack_QGOMatcher, orientationsFollowTheContrastNotTheLight)
{
    const double lights[][3] = {{0.25, 1, 0}, {0.4, 1, 0}, {0.6, 1, 0}, {1, 1.4, 0}, {1, 0.7, 0}, {1, 1, 0.3}, {1, 1, 0.6}, {0.5, 1, 0.5}};
    QGOMatcher::Params params;
    params.leastMagnitude = 3;   // a quarter of the scene's contrast asks for 5
    for (int channels = 1; channels <= 3; channels += 2)
    {
        const Mat expected = orientationsOf(litScene(1, 1, 0, channels), params);
        const double edges = countNonZero(expected);
        ASSERT_GT(edges, 5000);
        for (const double* light : lights)
        {
            const Mat image = litScene(light[0], light[1], light[2], channels);
            const Mat result = orientationsOf(image, params);
            // Rounding to 8 bits turns weak gradients a little.
            EXPECT_LT(std::abs(countNonZero(result) - edges), 0.15 * edges) << light[0] << " " << light[1] << " " << light[2];
            EXPECT_LT(countNonZero(expected & ~result), 0.15 * edges) << light[0] << " " << light[1] << " " << light[2];
        }
    }
}

TEST(SurgTrack_QGOMatcher, noiseInBlandAreasHasFewOrientations)
{
    RNG rng(71);
    const double sigmas[] = {2, 7, 15};   // [grey levels]
    for (double sigma : sigmas)
    {
        Mat noise(256, 320, CV_32FC1), image;
        rng.fill(noise, RNG::NORMAL, 90, sigma);
        noise.convertTo(image, CV_8U);
        EXPECT_LT(countNonZero(orientationsOf(image)), 0.12 * double(image.total())) << sigma;   // a fifth is that strong, every other of them is outvoted; measured: 0.10
    }
}

TEST(SurgTrack_QGOMatcher, contrastAsksForNoMoreThanTheThresholdAndNoLessThanTheLeast)
{
    const Mat image = textured(Size(200, 150), 3, 33);
    QGOMatcher::Params params;
    params.magnitudeThreshold = params.leastMagnitude = 25;   // whatever the contrast
    Mat expected;
    quantizeOrientations(image, expected, 25);
    const Mat result = orientationsOf(image, params);
    EXPECT_EQ(0, countNonZero(result & ~expected));
    EXPECT_GT(countNonZero(result), 0.97 * countNonZero(expected));   // sizes are known to some percent

    params.contrast = 0;
    EXPECT_EQ(0, cvtest::norm(expected, orientationsOf(image, params), NORM_INF));
    EXPECT_EQ(0, countNonZero(orientationsOf(Mat(90, 70, CV_8UC1, Scalar(0)))));   // a black image has no contrast
    Mat half = image.clone();   // a black surround is no texture: the rest keeps its orientations
    half.rowRange(75, 150).setTo(Scalar::all(0));
    const Rect upper(0, 0, 200, 60);
    Ptr<QGOMatcher> matcher = QGOMatcher::create();
    Mat whole, masked;
    matcher->setImage(image);
    matcher->orientations(whole);
    matcher->setImage(half);
    matcher->orientations(masked);
    EXPECT_LT(countNonZero(whole(upper) != masked(upper)), 0.1 * double(upper.area()));
}

TEST(SurgTrack_QGOMatcher, anyImageSizeWorks)
{
    RNG rng(12);
    const Size sizes[] = {Size(1, 1), Size(1, 40), Size(40, 1), Size(2, 2), Size(5, 3), Size(17, 31), Size(31, 17), Size(641, 479)};
    QGOMatcher::Params params;
    params.magnitudeThreshold = 15;
    params.contrast = 0;
    params.minSimilarity = 0.01;
    Ptr<QGOMatcher> matcher = QGOMatcher::create(params);
    for (const Size& size : sizes)
        for (int channels = 1; channels <= 3; channels += 2)
        {
            const Mat image = textured(size, channels, 3);
            matcher->setImage(image);
            const PartTemplate t = randomTemplate(100, 25, rng);   // reaches outside most of these images
            std::vector<PartMatch> matches;
            matcher->match(std::vector<PartTemplate>(1, t), std::vector<Rect>(), matches);
            const Mat_<ushort> expected = referenceSimilarity(image, Rect(Point(), size), t, Rect(Point(), size), params);
            const double best = *std::max_element(expected.begin(), expected.end()) / 400.;
            if (best >= 0.01)
            {
                ASSERT_FALSE(matches.empty()) << size;
                EXPECT_EQ(best, matches[0].similarity) << size;
            }
            else EXPECT_TRUE(matches.empty()) << size;
        }
}

TEST(SurgTrack_QGOMatcher, aPreparedRegionGivesTheSameWhereTemplatesStayInside)
{
    RNG rng(14);
    QGOMatcher::Params params;
    params.magnitudeThreshold = 15;
    params.contrast = 0;
    const Mat image = textured(Size(180, 130), 3, 15);
    Ptr<QGOMatcher> whole = QGOMatcher::create(params), part = QGOMatcher::create(params);
    whole->setImage(image);
    for (int i = 0; i < 40; i++)
    {
        const Rect roi = Rect(rng.uniform(-30, 120), rng.uniform(-30, 80), rng.uniform(60, 120), rng.uniform(60, 100));
        const Rect region = roi & Rect(Point(), image.size());
        const int reach = 10, border = reach + params.spread / 2;   // spreading looks beyond the region too
        part->setImage(image, roi);
        const PartTemplate t = randomTemplate(70, reach, rng);
        const Rect window(region.x + border, region.y + border, std::max(1, region.width - 2 * border), std::max(1, region.height - 2 * border));
        Mat expected, result;
        if (region.width > 2 * border && region.height > 2 * border)
        {
            whole->similarityMap(t, window, expected);
            part->similarityMap(t, window, result);
            ASSERT_EQ(0, cvtest::norm(expected, result, NORM_INF)) << roi;
        }
        // Beyond it features count as not found.
        const Rect wide(region.x - 20, region.y - 20, region.width + 40, region.height + 40);
        part->similarityMap(t, wide, result);
        ASSERT_EQ(0, cvtest::norm(referenceSimilarity(image, region, t, wide, params), result, NORM_INF)) << roi;
    }
    // A region outside the image holds nothing.
    part->setImage(image, Rect(500, 500, 20, 20));
    Mat result;
    part->similarityMap(randomTemplate(70, 10, rng), Rect(0, 0, 30, 30), result);
    EXPECT_EQ(0, countNonZero(result));
}

TEST(SurgTrack_QGOMatcher, aGreyImageMatchesAsItsThreeEqualChannels)
{
    const CameraModel camera = endoscope(true, Size(360, 288));
    const PosedTool tool;
    const std::vector<PartTemplate> templates = templatesOf(camera, tool);
    const Mat grey = pictureOf(camera, tool, Point(4, -2), 1);
    Mat colour;
    cvtColor(grey, colour, COLOR_GRAY2BGR);
    Ptr<QGOMatcher> matcher = QGOMatcher::create();
    std::vector<PartMatch> fromGrey, fromColour;
    matcher->setImage(grey);
    matcher->match(templates, std::vector<Rect>(), fromGrey);
    matcher->setImage(colour);
    matcher->match(templates, std::vector<Rect>(), fromColour);
    ASSERT_FALSE(fromGrey.empty());
    EXPECT_TRUE(sameMatches(fromGrey, fromColour));
}

TEST(SurgTrack_QGOMatcher, doesNotKeepTheImageAndForgetsTheLastOne)
{
    const CameraModel camera = endoscope(true, Size(360, 288));
    const PosedTool tool;
    const std::vector<PartTemplate> templates = templatesOf(camera, tool);
    Mat image = pictureOf(camera, tool, Point(4, -2));
    Ptr<QGOMatcher> matcher = QGOMatcher::create();
    std::vector<PartMatch> first, again;
    matcher->setImage(image);
    matcher->match(templates, std::vector<Rect>(), first);
    image.setTo(Scalar::all(0));
    matcher->match(templates, std::vector<Rect>(), again);
    EXPECT_TRUE(sameMatches(first, again));
    matcher->setImage(image);
    matcher->match(templates, std::vector<Rect>(), again);
    EXPECT_TRUE(again.empty());
    matcher->setImage(textured(Size(33, 700), 1, 2));   // another size
    matcher->setImage(pictureOf(camera, tool, Point(4, -2)));
    matcher->match(templates, std::vector<Rect>(), again);
    EXPECT_TRUE(sameMatches(first, again));
}

TEST(SurgTrack_QGOMatcher, rejectsBadInputNamingTheArgument)
{
    Ptr<QGOMatcher> matcher = QGOMatcher::create();
    RNG rng(1);
    const std::vector<PartTemplate> templates(2, randomTemplate(40, 5, rng));
    std::vector<PartMatch> matches;
    Mat map;
    EXPECT_ERROR(matcher->match(templates, std::vector<Rect>(), matches), "setImage");
    EXPECT_ERROR(matcher->similarityMap(templates[0], Rect(0, 0, 4, 4), map), "setImage");
    EXPECT_ERROR(matcher->orientations(map), "setImage");
    EXPECT_ERROR(matcher->setImage(Mat()), "image");
    EXPECT_ERROR(matcher->setImage(Mat::zeros(50, 50, CV_16UC1)), "image");
    EXPECT_ERROR(matcher->match(templates, std::vector<Rect>(), matches), "setImage");   // none that it accepted
    matcher->setImage(Mat::zeros(50, 50, CV_8UC1));
    EXPECT_ERROR(matcher->match(templates, std::vector<Rect>(1), matches), "windows");
    EXPECT_ERROR(matcher->similarityMap(templates[0], Rect(), map), "window");

    QGOMatcher::Params params;
    params.spread = 4;
    EXPECT_ERROR(QGOMatcher::create(params), "spread");
    params = QGOMatcher::Params();
    params.candidates = 0;
    EXPECT_ERROR(QGOMatcher::create(params), "candidates");
    params = QGOMatcher::Params();
    params.suppressionRadius = -1;
    EXPECT_ERROR(QGOMatcher::create(params), "suppressionRadius");
    const double values[] = {-1, NOT_A_NUMBER, std::numeric_limits<double>::infinity()};
    for (double value : values)
    {
        params = QGOMatcher::Params();
        params.contrast = value;
        EXPECT_ERROR(QGOMatcher::create(params), "contrast");
        params = QGOMatcher::Params();
        params.leastMagnitude = value;
        EXPECT_ERROR(QGOMatcher::create(params), "leastMagnitude");
    }
    params = QGOMatcher::Params();
    params.magnitudeThreshold = 180;
    EXPECT_ERROR(QGOMatcher::create(params), "magnitudeThreshold");
    params.contrast = 0;
    EXPECT_NO_THROW(QGOMatcher::create(params));
}

}} // namespace
