// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_common.hpp"
#include "base/calib.hpp"
#include "base/geometry.hpp"

namespace opencv_test { namespace {

Vec3d someVector(RNG& rng, double length)
{
    const Vec3d v(rng.gaussian(1), rng.gaussian(1), rng.gaussian(1));
    return v * (length / cv::norm(v));
}

Matx44d someTransform(RNG& rng)
{
    return rigidTransform(exponential(someVector(rng, rng.uniform(0., 3.))), someVector(rng, 0.1));
}

TEST(SurgTrack_Geometry, exponentialIsTheRotationOfRodrigues)
{
    RNG rng(1);
    const double angles[] = { 0, 1e-12, 1e-6, 0.01, 1, 3.1, 7 };
    for (int i = 0; i < 7; i++)
    {
        const Vec3d omega = someVector(rng, angles[i]);
        Matx33d expected;
        cv::Rodrigues(omega, expected);
        EXPECT_LT(cv::norm(exponential(omega) - expected, NORM_INF), 1e-14) << angles[i];   // rounding
        if (angles[i] == 0) continue;
        EXPECT_LT(cv::norm(rotationAbout(omega * (1 / angles[i]), angles[i]) - expected, NORM_INF), 1e-14) << angles[i];
    }
}

TEST(SurgTrack_Geometry, anglesAreThoseOfTheTurn)
{
    RNG rng(2);
    const double angles[] = { 1e-7, 1e-3, 0.5, 3.1 };
    for (int i = 0; i < 4; i++)
    {
        const Matx44d A = someTransform(rng), turn = rigidTransform(exponential(someVector(rng, angles[i])), someVector(rng, 0.2));
        const Matx44d B = A * turn;
        EXPECT_NEAR(angles[i], angleBetween(rotationOf(A), rotationOf(B)), 1e-14);
        EXPECT_NEAR(angles[i], turnOf(turn), 1e-7);         // of the trace
        EXPECT_NEAR(angles[i], turnBetween(A, B), 1e-7);    // the same
    }
    EXPECT_EQ(0, angleBetween(Matx33d::eye(), Matx33d::eye()));
    EXPECT_NEAR(CV_PI, turnOf(Matx44d::eye() * std::numeric_limits<double>::quiet_NaN()), 1e-15) << "what is not a number is no small turn";
}

TEST(SurgTrack_Geometry, inverseUndoesATransform)
{
    RNG rng(3);
    for (int i = 0; i < 10; i++)
    {
        const Matx44d T = someTransform(rng);
        EXPECT_LT(cv::norm(rigidInverse(T) * T - Matx44d::eye(), NORM_INF), 1e-14);   // rounding
        const Point3d p(0.1, -0.2, 0.3);
        EXPECT_LT(cv::norm(transform(rigidInverse(T), transform(T, p)) - p), 1e-15);
    }
}

}} // namespace
