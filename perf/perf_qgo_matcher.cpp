// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "perf_common.hpp"

namespace opencv_test { namespace {

typedef TestBaseWithParam<Size> Size_QGOMatcher;

// The image stage: orientations, spreading and all responses.
PERF_TEST_P(Size_QGOMatcher, setImage, SURGTRACK_SIZES)
{
    const View view(GetParam());
    Ptr<QGOMatcher> matcher = QGOMatcher::create();
    matcher->setImage(view.image);
    TEST_CYCLE() matcher->setImage(view.image);
    SANITY_CHECK_NOTHING();
}

PERF_TEST_P(Size_QGOMatcher, matchInWindows, SURGTRACK_SIZES)
{
    const View view(GetParam());
    const std::vector<PartTemplate> templates = view.templates();
    const std::vector<Rect> windows = view.windows(templates);
    Ptr<QGOMatcher> matcher = QGOMatcher::create();
    matcher->setImage(view.image);
    std::vector<PartMatch> matches;
    TEST_CYCLE() matcher->match(templates, windows, matches);
    ASSERT_FALSE(matches.empty());
    SANITY_CHECK_NOTHING();
}

// Of a tracked tool: the image's part of it, too, whose response maps are made when they are first needed.
PERF_TEST_P(Size_QGOMatcher, imageAndMatchInWindows, SURGTRACK_SIZES)
{
    const View view(GetParam());
    const std::vector<PartTemplate> templates = view.templates();
    const std::vector<Rect> windows = view.windows(templates);
    Rect roi;
    for (size_t i = 0; i < templates.size(); i++)
    {
        const Rect &w = windows[i], &b = templates[i].bounds;
        roi |= Rect(w.x + b.x, w.y + b.y, w.width + b.width, w.height + b.height);
    }
    roi &= Rect(Point(), GetParam());
    Ptr<QGOMatcher> matcher = QGOMatcher::create();
    std::vector<PartMatch> matches;
    TEST_CYCLE()
    {
        matcher->setImage(view.image, roi);
        matcher->match(templates, windows, matches);
    }
    ASSERT_FALSE(matches.empty());
    SANITY_CHECK_NOTHING();
}

PERF_TEST_P(Size_QGOMatcher, matchInTheWholeImage, SURGTRACK_SIZES)
{
    const View view(GetParam());
    const std::vector<PartTemplate> templates = view.templates();
    Ptr<QGOMatcher> matcher = QGOMatcher::create();
    matcher->setImage(view.image);
    std::vector<PartMatch> matches;
    TEST_CYCLE() matcher->match(templates, std::vector<Rect>(), matches);
    ASSERT_FALSE(matches.empty());
    SANITY_CHECK_NOTHING();
}

// As many and as small as cv::linemod is used with; see perf_peers.cpp.
PERF_TEST_P(Size_QGOMatcher, match28Of63FeaturesInTheWholeImage, SURGTRACK_SIZES)
{
    const View view(GetParam(), 2);
    const std::vector<PartTemplate> templates = cutTemplates(view.image, 28, 63);
    Ptr<QGOMatcher> matcher = QGOMatcher::create();
    matcher->setImage(view.image);
    std::vector<PartMatch> matches;
    TEST_CYCLE() matcher->match(templates, std::vector<Rect>(), matches);
    ASSERT_GE(matches.size(), templates.size());
    SANITY_CHECK_NOTHING();
}

typedef TestBaseWithParam<int> Templates_QGOMatcher;

// The same with other numbers of templates, and the image stage.
PERF_TEST_P(Templates_QGOMatcher, imageAndMatchInTheWholeImage, testing::Values(1, 7, 14, 28, 56))
{
    const View view(Size(720, 576), 2);
    const std::vector<PartTemplate> templates = cutTemplates(view.image, GetParam(), 63);
    Ptr<QGOMatcher> matcher = QGOMatcher::create();
    std::vector<PartMatch> matches;
    TEST_CYCLE()
    {
        matcher->setImage(view.image);
        matcher->match(templates, std::vector<Rect>(), matches);
    }
    ASSERT_GE(int(matches.size()), GetParam());
    SANITY_CHECK_NOTHING();
}

}} // namespace
