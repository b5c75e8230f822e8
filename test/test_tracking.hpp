// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_TEST_TRACKING_HPP
#define OPENCV_SURGTRACK_TEST_TRACKING_HPP

#include "test_common.hpp"

#include <cstdlib>

namespace opencv_test { namespace {

typedef std::vector<ToolEstimate> Estimates;
typedef std::vector<std::vector<double> > Joints;

// A synthetic scene, its frames drawn once.
struct Recording
{
    Recording(const SyntheticScene::Params& _params, int frames) : params(_params), scene(SyntheticScene::create(needleDriver(), _params)), images(frames)
    {
        for (int i = 0; i < frames; i++) scene->render(i, images[i]);
    }

    int frames() const { return int(images.size()); }
    double time(int frame) const { return frame / params.fps; }

    Joints joints(int frame) const
    {
        Joints result;
        for (int i = 0; i < scene->toolCount(); i++) result.push_back(scene->recordedJoints(i, time(frame)));
        return result;
    }

    Ptr<ToolTracker> tracker(int method = METHOD_PAPER) const
    {
        ToolTracker::Params p;
        p.method = method;
        return tracker(p);
    }

    Ptr<ToolTracker> tracker(const ToolTracker::Params& p) const
    {
        Ptr<ToolTracker> result = ToolTracker::create(scene->camera(), p);
        for (int i = 0; i < scene->toolCount(); i++) EXPECT_EQ(i, result->addTool(scene->model(), scene->nominal_T_base(i)));
        return result;
    }

    Estimates update(ToolTracker& tracker, int frame) const
    {
        Estimates result;
        tracker.update(images[frame], time(frame), joints(frame), result);
        return result;
    }

    SyntheticScene::Params params;
    Ptr<SyntheticScene> scene;
    std::vector<Mat> images;
};

inline SyntheticScene::Params scene(int seed = 1, int tools = 1, Size size = Size(720, 576), bool distortion = false)
{
    SyntheticScene::Params p;
    p.seed = seed;
    p.tools = tools;
    p.imageSize = size;
    p.distortion = distortion;
    return p;
}

// One tool, three quarters of a second; used by several tests.
inline const Recording& common()
{
    static const Recording recording(scene(), 25);
    return recording;
}

struct Score
{
    Score() : translation(0), rotation(0), kinematics(0), frames(0), covered(0), silent(0) {}
    double translation, rotation;   // means of the frames that claim to know [m], [rad]
    double kinematics;              // mean error without tracking [m]
    int frames, covered, silent;    // silent: `tracking`, and more than 5 mm off
};

// ahead: each frame is drawn while the one before is tracked
inline Score scoreOf(const Recording& r, ToolTracker& tracker, bool ahead = false)
{
    Score s;
    for (int frame = 0; frame < r.frames(); frame++)
    {
        if (ahead && frame + 1 < r.frames()) tracker.renderAhead(r.joints(frame + 1));
        const Estimates estimates = r.update(tracker, frame);
        const Joints joints = r.joints(frame);
        EXPECT_EQ(joints.size(), estimates.size());
        for (int i = 0; i < int(estimates.size()); i++)
        {
            const ToolEstimate& e = estimates[i];
            const Matx44d truth = r.scene->truePose(i, r.time(frame));
            s.frames++;
            s.kinematics += distance(r.scene->nominal_T_base(i) * r.scene->model()->endEffectorPose(joints[i]), truth);
            if (e.state != STATE_TRACKING && e.state != STATE_COASTING) continue;
            s.covered++;
            s.translation += distance(e.camera_T_tool, truth);
            s.rotation += rotationAngle(e.camera_T_tool, truth);
            s.silent += e.state == STATE_TRACKING && distance(e.camera_T_tool, truth) > 0.005;
        }
    }
    s.kinematics /= s.frames;
    s.translation /= std::max(1, s.covered);
    s.rotation /= std::max(1, s.covered);
    if (std::getenv("SURGTRACK_TEST_PRINT"))   // to measure the bounds anew
        std::cout << "translation " << s.translation * 1e3 << " mm, rotation " << s.rotation << " rad, covered " << s.covered << " of " << s.frames << ", silent "
                  << s.silent << ", kinematics " << s.kinematics * 1e3 << " mm" << std::endl;
    return s;
}

inline bool same(const Estimates& a, const Estimates& b)
{
    if (a.size() != b.size()) return false;
    for (size_t i = 0; i < a.size(); i++)
        if (a[i].state != b[i].state || cv::norm(a[i].camera_T_tool - b[i].camera_T_tool, NORM_INF) != 0
            || cv::norm(a[i].camera_T_nominal - b[i].camera_T_nominal, NORM_INF) != 0 || cv::norm(a[i].covariance - b[i].covariance, NORM_INF) != 0
            || a[i].visibleParts != b[i].visibleParts || a[i].inliers != b[i].inliers || a[i].similarity != b[i].similarity || a[i].nis != b[i].nis
            || !sameMatches(a[i].matches, b[i].matches))
            return false;
    return true;
}

}} // namespace

#endif
