// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "fuzz.hpp"
#include "opencv2/surgtrack/articulated_pose_ekf.hpp"
#include "opencv2/surgtrack/tool_state.hpp"

using namespace cv;
using namespace cv::surgtrack;

// What a file says was learnt, and what a filter that begins with it says of the next frames: numbers, or it refuses.
static void use(ArticulatedPoseEKF& filter, const ReadingErrors& errors)
{
    try
    {
        filter.setReadingErrors(errors);
    }
    catch (const Exception&)   // which names the member
    {
        return;
    }
    const CameraModel camera(Matx33d(100, 0, 48, 0, 100, 36, 0, 0, 1), noArray(), Size(96, 72));
    std::vector<double> joints(filter.joints().size(), 0.1);
    std::vector<uchar> used;
    for (int frame = 0; frame < 3; frame++)
    {
        for (size_t i = 0; i < joints.size(); i++) joints[i] += 0.01;
        filter.predict(joints, 1, 0.04);
        filter.begin();
        filter.addPoints(camera, Matx44d::eye(), { 0, 1, 2, 3 }, { Point2d(40, 30), Point2d(42, 35), Point2d(50, 36), Point2d(55, 40) }, used);
        filter.solve();
        if (!checkRange(filter.joints()) || !checkRange(filter.correction()) || !checkRange(filter.covariance()) || !checkRange(filter.poseCovariance()) ||
            !checkRange(filter.readingErrors().values) || !checkRange(filter.readingErrors().covariance))
            std::abort();
    }
}

FUZZ_FILE(".yaml", [](const std::string& name)
{
    static const Ptr<ToolModel> model = ToolModel::needleDriver();
    ArticulatedPoseEKF::Params params;
    params.gain = params.play = params.coupling = 0;   // offsets and the delay alone: short files
    const Matx44d nominal_T_base(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0.1, 0, 0, 0, 1);
    const ReadingErrors errors = readToolState(name, "PSM1");
    use(*ArticulatedPoseEKF::create(model, nominal_T_base, params), errors);
})
