// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// The evaluation's baselines that give poses, and poses of other programs.

#include "test_common.hpp"
#include "../samples/evaluation/baselines/reiter2012.hpp"
#include "../samples/evaluation/baselines/reiter2014.hpp"
#include "../samples/evaluation/given_poses.hpp"

namespace opencv_test { namespace {

using namespace evaluation;

Ptr<SyntheticScene> sceneWithout(double jointNoise)
{
    SyntheticScene::Params params;
    params.tools = 1;
    params.jointNoise = jointNoise;
    return SyntheticScene::create(Ptr<ToolModel>(), params);
}

// A pose of which the true one is a hypothesis: in plane 3, out of plane -5 degrees, nearer by 8 %.
Matx44d offTheGrid(const Matx44d& truth)
{
    const Matx33d turn = rotationMatrix(Vec3d(0, 0, Hypothesis::step(Hypothesis::IN_PLANE))) *
                         rotationMatrix(Vec3d(-Hypothesis::step(Hypothesis::OUT_X), 0, 0));
    return evaluation::rigid(turn.t() * rotationOf(truth), translationOf(truth) * (1 / (1 - Hypothesis::step(Hypothesis::DISTANCE))));
}

void checkWholeTool(bool pyramid, double rotation)
{
    const Ptr<SyntheticScene> scene = sceneWithout(0);
    Mat image;
    scene->render(10, image);
    const Matx44d truth = scene->truePose(0, 0.4);
    WholeToolSearch search(scene->model(), scene->camera(), false, pyramid);
    const WholeToolSearch::Found found = search.search(image, offTheGrid(truth), scene->trueJoints(0, 0.4), 120);
    ASSERT_GT(found.similarity, 0);
    EXPECT_LT(rotationAngle(truth, found.camera_T_tool), rotation);
    EXPECT_LT(distance(truth, found.camera_T_tool), 0.003);
    const Point2d tip = scene->camera().project(transformed(found.camera_T_tool, Point3d())), expected = scene->camera().project(transformed(truth, Point3d()));
    EXPECT_LT(cv::norm(tip - expected), 4);
}

// The true hypothesis wins: another one would be off by 3 degrees at least.
TEST(Surgtrack_WholeTool, findsTheTrueHypothesis) { checkWholeTool(false, 0.001); }

// Half a step of refinement is 1.5 to 2.5 degrees.
TEST(Surgtrack_WholeTool, findsItInAPyramid) { checkWholeTool(true, 0.06); }

TEST(Surgtrack_WholeTool, hypothesesAreThoseOfTheGrid)
{
    EXPECT_EQ(405u, Hypothesis::grid(false).size());
    EXPECT_EQ(3645u, Hypothesis::grid(true).size());
}

// True landmarks with noise of 8 pixels.
std::vector<Landmark> landmarksOf(const SyntheticScene& scene, double time, RNG& rng)
{
    Mat basePoints;
    scene.model()->keypointPositions(scene.trueJoints(0, time), basePoints);
    std::vector<Landmark> landmarks;
    for (int i = 0; i < basePoints.rows; i += 2)   // of each class one
    {
        const double* const p = basePoints.ptr<double>(i);
        const Point3d q = transformed(scene.camera_T_base(0), Point3d(p[0], p[1], p[2]));
        const Landmark landmark = { i, scene.camera().project(q) + Point2d(rng.gaussian(8), rng.gaussian(8)), Point2d(NOT_A_NUMBER, NOT_A_NUMBER) };
        landmarks.push_back(landmark);
    }
    return landmarks;
}

// Fed with them from 3 degrees and 6 mm off, mean distance from the truth in the end of ten draws [m].
double distanceAfter(const SyntheticScene& scene, int frames, double noise)
{
    const Ptr<ToolModel> model = scene.model();
    const Matx44d truth = scene.truePose(0, 0);
    const Matx44d wrong = evaluation::rigid(rotationMatrix(Vec3d(0.03, -0.03, 0.03)) * rotationOf(truth), translationOf(truth) + Vec3d(0.004, -0.003, 0.0033));
    CameraPair cameras;
    cameras.left = scene.camera();
    double sum = 0;
    for (int seed = 0; seed < 10; seed++)
    {
        LandmarkFusion fusion(model, wrong * rigidInverse(truth) * scene.camera_T_base(0), cameras, 1, noise);
        EXPECT_EQ(STATE_INITIALIZING, fusion.state());
        RNG rng(19 + seed);
        for (int frame = 0; frame < frames; frame++)
        {
            fusion.predict(scene.trueJoints(0, frame / 25.));
            fusion.correct(landmarksOf(scene, frame / 25., rng), frame / 25.);
            EXPECT_EQ(STATE_TRACKING, fusion.state());
        }
        sum += distance(scene.truePose(0, (frames - 1) / 25.), fusion.camera_T_tool(model));
    }
    return sum / 10;
}

// Nearly all of it is depth, which one eye sees by the size of the tool: 5 mm in a single frame.
TEST(Surgtrack_LandmarkFusion, converges)
{
    const Ptr<SyntheticScene> scene = sceneWithout(0);
    EXPECT_LT(distanceAfter(*scene, 30, 8), 0.0015);    // told what they are
    EXPECT_LT(distanceAfter(*scene, 60, 40), 0.0015);   // told what real ones are, which err alike for long
}

TEST(Surgtrack_LandmarkFusion, coastsAndIsLost)
{
    const Ptr<SyntheticScene> scene = sceneWithout(0);
    const Ptr<ToolModel> model = scene->model();
    CameraPair cameras;
    cameras.left = scene->camera();
    LandmarkFusion fusion(model, scene->camera_T_base(0), cameras, 1);
    RNG rng(19);
    for (int frame = 0; frame < 90; frame++)
    {
        const double time = frame / 25.;
        fusion.predict(scene->trueJoints(0, time));
        fusion.correct(frame < 30 ? landmarksOf(*scene, time, rng) : std::vector<Landmark>(), time);
        EXPECT_EQ(frame < 30 ? STATE_TRACKING : time - 29 / 25. > 2 ? STATE_LOST : STATE_COASTING, fusion.state()) << frame;
    }
    EXPECT_LT(distance(scene->truePose(0, 89 / 25.), fusion.camera_T_tool(model)), 1e-9);   // it starts anew from the calibration, here the true one
}

// A poses file of the truth itself has no errors, and frames that it lacks are not covered.
TEST(Surgtrack_GivenPoses, areScored)
{
    SyntheticScene::Params params;
    params.frames = 4;
    params.imageSize = Size(160, 120);
    const String folder = cv::tempfile(""), file = utils::fs::join(folder, "poses.csv");
    SyntheticScene::create(Ptr<ToolModel>(), params)->write(folder);
    Data data;
    data.load(folder);
    {
        const Ptr<PoseWriter> writer = PoseWriter::create(file);
        for (int frame = 0; frame < 3; frame++)
        {
            Truth truth;
            ASSERT_TRUE(data.truth(0, frame, truth));
            writer->write(frame, data.time(frame), data.tools[0].info.name, STATE_TRACKING, truth.camera_T_tool);
        }
    }
    const evaluation::Run run = PosesFile::read(data, "truth", file, 0);
    EXPECT_EQ(4, run.scores.back().frames);
    EXPECT_EQ(3, run.scores.back().covered);
    EXPECT_LT(run.scores.back().translationMean, 1e-6);   // digits of the files
    std::ofstream(file.c_str(), std::ios::app) << "9,0.1,nobody,tracking,0,0,0,0,0,0,1\n";
    EXPECT_ERROR(PosesFile::read(data, "truth", file, 0), "nobody");
    EXPECT_ERROR(GivenPoses::parse("name"), "NAME:FILE");
    EXPECT_ERROR(GivenPoses::parse("a name:" + file), "NAME:FILE");
    utils::fs::remove_all(folder);
}

}} // namespace
