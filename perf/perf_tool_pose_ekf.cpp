// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "perf_common.hpp"

namespace opencv_test { namespace {

typedef TestBaseWithParam<Size> Size_EKF;

// All keypoints of a tool and where they are seen.
void measure(const Pose& view, Mat& points, Mat& image)
{
    const Ptr<ToolModel> model = view.scene->model();
    points.create(int(model->keypoints().size()), 3, CV_64F);
    for (int i = 0; i < points.rows; i++)
    {
        const ToolModel::Keypoint& k = model->keypoints()[i];
        const Vec4d p = view.views[0].camera_T_base * view.views[0].base_T_link[k.link] * Vec4d(k.linkPoint.x, k.linkPoint.y, k.linkPoint.z, 1);
        for (int j = 0; j < 3; j++) points.at<double>(i, j) = p[j];
    }
    projectKeypoints(view.camera, Matx61d::zeros(), points, image);
    image = image.reshape(1).clone();
}

// The prediction and the update with 14 keypoints; the size only says which camera.
PERF_TEST_P(Size_EKF, update, SURGTRACK_SIZES)
{
    const Pose view(GetParam());
    Mat points, image;
    measure(view, points, image);
    Ptr<ToolPoseEKF> filter = ToolPoseEKF::create(view.camera);
    bool updated = false;
    TEST_CYCLE()
    {
        filter->predict();
        updated = filter->correct(points, image);
    }
    ASSERT_TRUE(updated);
    SANITY_CHECK_NOTHING();
}

PERF_TEST_P(Size_EKF, solveEPnP, SURGTRACK_SIZES)
{
    const Pose view(GetParam());
    Mat points, image;
    measure(view, points, image);
    Matx44d camera_T_nominal;
    bool found = false;
    TEST_CYCLE() found = solveEPnP(view.camera, points, image, camera_T_nominal);
    ASSERT_TRUE(found);
    SANITY_CHECK_NOTHING();
}

}} // namespace
