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
        rightImages.resize(params.stereo ? frames : 0);
        for (size_t i = 0; i < rightImages.size(); i++) scene->render(int(i), rightImages[i], true);
    }

    int frames() const { return int(images.size()); }
    double time(int frame) const { return frame / params.fps; }

    Joints joints(int frame) const
    {
        Joints result;
        for (int i = 0; i < scene->toolCount(); i++) result.push_back(scene->recordedJoints(i, time(frame)));
        return result;
    }

    Ptr<ToolTracker> tracker(int method = METHOD_FULL) const
    {
        ToolTracker::Params p;
        p.method = method;
        return tracker(p);
    }

    Ptr<ToolTracker> stereoTracker(const ToolTracker::Params& p = ToolTracker::Params()) const
    {
        Ptr<ToolTracker> result = tracker(p);
        result->setRightCamera(scene->camera(true), scene->right_T_left());
        return result;
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

    Estimates updateStereo(ToolTracker& tracker, int frame) const
    {
        Estimates result;
        tracker.updateStereo(images[frame], rightImages[frame], time(frame), joints(frame), result);
        return result;
    }

    // Without truth: where the robot alone has the end effector.
    Matx44d nominalPose(int tool, int frame) const
    {
        return scene->nominal_T_base(tool) * scene->model()->endEffectorPose(joints(frame)[tool]);
    }

    SyntheticScene::Params params;
    Ptr<SyntheticScene> scene;
    std::vector<Mat> images, rightImages;   // right: of a stereo scene
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

// One tool before both eyes.
inline const Recording& commonStereo()
{
    static Ptr<Recording> recording;
    if (!recording)
    {
        SyntheticScene::Params p = scene();
        p.stereo = true;
        recording = makePtr<Recording>(p, 25);
    }
    return *recording;
}

struct Score
{
    Score() : translation(0), rotation(0), kinematics(0), frames(0), covered(0), silent(0) {}
    double translation, rotation;   // means of the frames that claim to know [m], [rad]
    double kinematics;              // mean error without tracking [m]
    int frames, covered, silent;    // silent: `tracking`, and more than 5 mm off

    void add(const ToolEstimate& e, const Matx44d& truth, const Matx44d& nominal)
    {
        frames++;
        kinematics += distance(nominal, truth);
        if (e.state != STATE_TRACKING && e.state != STATE_COASTING) return;
        covered++;
        translation += distance(e.camera_T_tool, truth);
        rotation += rotationAngle(e.camera_T_tool, truth);
        silent += e.state == STATE_TRACKING && distance(e.camera_T_tool, truth) > 0.005;
    }

    void finish()
    {
        kinematics /= std::max(1, frames);
        translation /= std::max(1, covered);
        rotation /= std::max(1, covered);
    }

    // To measure bounds anew.
    void print() const
    {
        std::cout << "translation " << translation * 1e3 << " mm, rotation " << rotation << " rad, covered " << covered << " of " << frames << ", silent "
                  << silent << ", kinematics " << kinematics * 1e3 << " mm" << std::endl;
    }
};

enum Eyes { LEFT, AHEAD, BOTH };   // AHEAD: each frame is drawn while the one before is tracked

// One a tool, and all of them together.
inline std::vector<Score> scoresOf(const Recording& r, ToolTracker& tracker, Eyes eyes = LEFT)
{
    const int tools = r.scene->toolCount();
    std::vector<Score> scores(tools + 1);
    for (int frame = 0; frame < r.frames(); frame++)
    {
        if (eyes == AHEAD && frame + 1 < r.frames()) tracker.renderAhead(r.joints(frame + 1));
        const Estimates estimates = eyes == BOTH ? r.updateStereo(tracker, frame) : r.update(tracker, frame);
        EXPECT_EQ(size_t(tools), estimates.size());
        for (int i = 0; i < tools; i++)
        {
            EXPECT_LE(estimates[i].inliers, estimates[i].visibleParts) << "frame " << frame << ", tool " << i;
            scores[i].add(estimates[i], r.scene->truePose(i, r.time(frame)), r.nominalPose(i, frame));
            scores[tools].add(estimates[i], r.scene->truePose(i, r.time(frame)), r.nominalPose(i, frame));
        }
    }
    for (Score& s : scores) s.finish();
    if (std::getenv("SURGTRACK_TEST_PRINT")) scores[tools].print();
    return scores;
}

inline Score scoreOf(const Recording& r, ToolTracker& tracker, Eyes eyes = LEFT) { return scoresOf(r, tracker, eyes).back(); }

// All fields, bit for bit.
inline bool same(const ToolEstimate& a, const ToolEstimate& b)
{
    return a.state == b.state && a.camera_T_tool == b.camera_T_tool && a.camera_T_nominal == b.camera_T_nominal && a.covariance == b.covariance
           && a.jointOffsets == b.jointOffsets && a.joints == b.joints && a.visibleParts == b.visibleParts && a.inliers == b.inliers && a.similarity == b.similarity
           && a.contourSupport == b.contourSupport && a.confidence == b.confidence && a.delay == b.delay && a.nis == b.nis && a.skippedReadings == b.skippedReadings
           && sameMatches(a.matches, b.matches);
}

inline bool same(const Estimates& a, const Estimates& b)
{
    return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), [](const ToolEstimate& x, const ToolEstimate& y) { return same(x, y); });
}

inline const char* methodName(int method)
{
    static const char* const names[] = {"paper", "epnp", "full"};
    return names[method];
}

struct MethodNames
{
    template <typename Info> std::string operator()(const Info& info) const { return methodName(info.param); }
};

}} // namespace

#endif
