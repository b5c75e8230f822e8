// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_tracking.hpp"

namespace opencv_test { namespace {

TEST(SurgTrack_Consistency, poseErrorLeadsFromTheEstimateToTheTruth)
{
    RNG rng(11);
    for (int i = 0; i < 50; i++)
    {
        const double angle = i == 0 ? 0 : i == 1 ? CV_PI : rng.uniform(1e-6, 3.1);
        const Vec3d turn = angle * randomDirection(rng), shift(rng.gaussian(0.01), rng.gaussian(0.01), rng.gaussian(0.01));
        const Matx44d estimate = rigid(rotationMatrix(randomDirection(rng)), Point3d(0.01, 0.02, 0.1));
        Matx44d truth = rigid(rotationMatrix(turn) * estimate.get_minor<3, 3>(0, 0), Point3d(0.01 + shift[0], 0.02 + shift[1], 0.1 + shift[2]));
        const Matx61d e = poseError(estimate, truth);
        const Vec3d r(e(0), e(1), e(2)), t(e(3), e(4), e(5));
        EXPECT_LT(cv::norm(rotationMatrix(r) - rotationMatrix(turn), NORM_INF), 1e-7) << angle;   // half a turn has half of the digits
        EXPECT_NEAR(angle, cv::norm(r), 1e-7);                                                    // the same
        EXPECT_LT(cv::norm(t - shift, NORM_INF), 1e-15);                                          // rounding
    }
}

TEST(SurgTrack_Consistency, normalizedErrorIsThatOfTheCovariance)
{
    RNG rng(12);
    Matx66d A;
    for (int i = 0; i < 36; i++) A.val[i] = rng.gaussian(1);
    Matx66d P = A * A.t() + 0.1 * Matx66d::eye();
    for (int i = 0; i < 6; i++)   // metres beside radians
        for (int j = 0; j < 6; j++) P(i, j) *= (i < 3 ? 1e-2 : 1e-5) * (j < 3 ? 1e-2 : 1e-5);
    const Matx61d e(0.01, -0.02, 0.03, 1e-5, 2e-5, -3e-5);
    const Matx33d rotation = P.get_minor<3, 3>(0, 0), translation = P.get_minor<3, 3>(3, 3);
    EXPECT_NEAR((e.t() * P.inv(DECOMP_SVD) * e)(0), normalizedErrorSquared(e, P), 1e-3 * normalizedErrorSquared(e, P));   // the inverse's digits
    const Vec3d r(e(0), e(1), e(2)), t(e(3), e(4), e(5));
    EXPECT_NEAR(r.dot(rotation.inv() * r), normalizedErrorSquared(e, P, 0, 3), 1e-6);
    EXPECT_NEAR(t.dot(translation.inv() * t), normalizedErrorSquared(e, P, 3, 3), 1e-6);
    P(4, 4) = 0;
    EXPECT_TRUE(cvIsNaN(normalizedErrorSquared(e, P)) != 0);
    EXPECT_FALSE(cvIsNaN(normalizedErrorSquared(e, P, 0, 3)) != 0) << "the other block is as it was";
    EXPECT_TRUE(cvIsNaN(normalizedErrorSquared(e, Matx66d::zeros())) != 0) << "of METHOD_EPNP";
    EXPECT_THROW(normalizedErrorSquared(e, P, 4, 3), cv::Exception);
}

TEST(SurgTrack_Consistency, theMeanNormalizedErrorIsInItsBand)
{
    const int seeds = 4, tools = 2, length = 60;
    double sum = 0;
    int frames = 0;
    for (int seed = 1; seed <= seeds; seed++)
    {
        SyntheticScene::Params params;
        params.seed = seed;
        params.tools = tools;
        const Recording recording(params, length);
        const Ptr<ToolTracker> tracker = recording.tracker(METHOD_FULL);
        for (int frame = 0; frame < length; frame++)
        {
            const Estimates estimates = recording.update(*tracker, frame);
            for (int tool = 0; tool < tools; tool++)
            {
                if (estimates[tool].state != STATE_TRACKING) continue;
                const Matx44d truth = recording.scene->truePose(tool, recording.time(frame));
                sum += normalizedErrorSquared(poseError(estimates[tool].camera_T_tool, truth), estimates[tool].covariance);
                frames++;
            }
        }
    }
    EXPECT_GE(frames, seeds * tools * (length - 5));   // the first few frames may be unconfirmed
    // Errors of successive frames are correlated, so a run of one tool counts as one draw: the 95 % band of chi-square with 8 x 6
    // degrees of freedom, divided by 8.
    EXPECT_GE(sum / frames, 3.84);
    EXPECT_LE(sum / frames, 8.63);
}

}} // namespace
