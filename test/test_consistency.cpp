// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_tracking.hpp"

namespace opencv_test { namespace {

// e^T P^-1 e of a pose; e = (rotation vector [rad], translation [m]) in the camera frame, as the covariance has it.
double normalizedError(const ToolEstimate& estimate, const Matx44d& truth)
{
    const Vec3d omega = rotationVector(truth.get_minor<3, 3>(0, 0) * estimate.camera_T_tool.get_minor<3, 3>(0, 0).t());
    Matx61d e, y;
    for (int i = 0; i < 3; i++)
    {
        e(i) = omega[i];
        e(3 + i) = truth(i, 3) - estimate.camera_T_tool(i, 3);
    }
    EXPECT_TRUE(solve(estimate.covariance, e, y, DECOMP_CHOLESKY));
    return e.dot(y);
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
                sum += normalizedError(estimates[tool], recording.scene->truePose(tool, recording.time(frame)));
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
