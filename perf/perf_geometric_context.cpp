// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "perf_common.hpp"

namespace opencv_test { namespace {

typedef TestBaseWithParam<Size> Size_GeometricContext;

PERF_TEST_P(Size_GeometricContext, verify, SURGTRACK_SIZES)
{
    const View view(GetParam());
    const std::vector<PartTemplate> templates = view.templates();
    Ptr<QGOMatcher> matcher = QGOMatcher::create();
    matcher->setImage(view.image);
    std::vector<PartMatch> matches, inliers;
    matcher->match(templates, view.windows(templates), matches);
    GeometricContextVerifier::Params params;
    params.zoneRadius *= GetParam().width / 720.;
    Ptr<GeometricContextVerifier> verifier = GeometricContextVerifier::create(params);
    TEST_CYCLE() verifier->verify(matches, inliers);
    ASSERT_FALSE(inliers.empty());
    SANITY_CHECK_NOTHING();
}

}} // namespace
