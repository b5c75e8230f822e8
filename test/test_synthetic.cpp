// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_precomp.hpp"
#include <fstream>
#include "opencv2/core/affine.hpp"
#include "opencv2/core/utils/filesystem.hpp"
#include "opencv2/imgproc.hpp"
#include "opencv2/videoio.hpp"

namespace opencv_test { namespace {

using namespace cv::surgtrack;

SyntheticScene::Params smallScene()
{
    SyntheticScene::Params params;
    params.imageSize = Size(360, 288);
    params.frames = 20;
    return params;
}

Ptr<SyntheticScene> makeScene(const SyntheticScene::Params& params) { return SyntheticScene::create(Ptr<ToolModel>(), params); }

TEST(SurgTrack_Synthetic, frameDependsOnSeedAndNumberOnly)
{
    const Ptr<SyntheticScene> a = makeScene(smallScene()), b = makeScene(smallScene());
    Mat first, again, other;
    a->render(3, first);
    b->render(11, other);
    b->render(3, again);
    EXPECT_EQ(0, cvtest::norm(first, again, NORM_INF));
    EXPECT_GT(cvtest::norm(first, other, NORM_INF), 50);      // a tool that moved: far above the noise
    SyntheticScene::Params params = smallScene();
    params.seed = 2;
    makeScene(params)->render(3, other);
    EXPECT_GT(cvtest::norm(first, other, NORM_INF), 50);      // another tissue
}

TEST(SurgTrack_Synthetic, armsCanBeDrawnElsewhere)
{
    SyntheticScene::Params params = smallScene();
    params.stereo = true;
    const Ptr<SyntheticScene> scene = makeScene(params);
    const double time = 3 / params.fps;
    std::vector<std::vector<double> > joints(1, scene->trueJoints(0, time));
    std::vector<Matx44d> bases(1, scene->camera_T_base(0));
    Mat usual, image, without;
    for (int right = 0; right < 2; right++)
    {
        scene->render(3, usual, right != 0);
        scene->renderArms(3, joints, bases, image, right != 0);
        EXPECT_EQ(0, cvtest::norm(usual, image, NORM_INF)) << right;
    }
    scene->render(3, usual);
    scene->renderArms(3, std::vector<std::vector<double> >(), std::vector<Matx44d>(), without);

    // A second arm is where its base says: the end effector of the first, 15 mm to the left of it.
    joints.push_back(joints[0]);
    bases.push_back(bases[0]);
    bases[1](0, 3) -= 0.015;
    scene->renderArms(3, joints, bases, image);
    const Matx44d tool = scene->truePose(0, time);
    for (int arm = 0; arm < 2; arm++)
    {
        const Point at = scene->camera().project(Point3d(tool(0, 3) - 0.015 * arm, tool(1, 3), tool(2, 3) - 0.002));   // 2 mm back, in the jaws
        const Rect around(at.x - 4, at.y - 4, 9, 9);
        EXPECT_GT(cvtest::norm(image(around), without(around), NORM_INF), 50) << arm;       // steel on tissue: far above the noise
        if (arm == 0) EXPECT_GT(cvtest::norm(usual(around), without(around), NORM_INF), 50);
        else EXPECT_LT(cvtest::norm(usual(around), without(around), NORM_INF), 40);         // the same noise and tissue, at most in the shadow
    }
    EXPECT_THROW(scene->renderArms(-1, joints, bases, image), cv::Exception);
    bases.pop_back();
    EXPECT_THROW(scene->renderArms(3, joints, bases, image), cv::Exception);
    EXPECT_THROW(scene->renderArms(3, std::vector<std::vector<double> >(100, joints[0]), std::vector<Matx44d>(100, bases[0]), image), cv::Exception);
}

TEST(SurgTrack_Synthetic, recordsAreExactWithoutErrors)
{
    SyntheticScene::Params params = smallScene();
    params.tools = 2;
    params.jointNoise = params.handEyeRotation = params.handEyeTranslation = 0;
    const Ptr<SyntheticScene> scene = makeScene(params);
    for (int tool = 0; tool < 2; tool++)
        for (double time = 0; time < 1; time += 0.033)
        {
            const Matx44d recorded = scene->nominal_T_base(tool) * scene->model()->endEffectorPose(scene->recordedJoints(tool, time));
            EXPECT_LT(cv::norm(recorded, scene->truePose(tool, time), NORM_INF), 1e-12);   // rounding
        }
}

TEST(SurgTrack_Synthetic, handEyeErrorHasTheSizeAskedFor)
{
    for (int seed = 0; seed < 10; seed++)
    {
        SyntheticScene::Params params = smallScene();
        params.seed = seed;
        params.jointNoise = 0;
        const Ptr<SyntheticScene> scene = makeScene(params);
        const Matx44d error = scene->nominal_T_base(0) * scene->camera_T_base(0).inv();
        EXPECT_NEAR(params.handEyeRotation, cv::norm(Affine3d(error).rvec()), 1e-9);      // rounding
        const Matx44d T = scene->truePose(0, 0), N = error * T;
        const double shift = cv::norm(Vec3d(T(0, 3) - N(0, 3), T(1, 3) - N(1, 3), T(2, 3) - N(2, 3)));
        // The tool is at most 20 mm from its workspace's centre, where 3 degrees are 1 mm.
        EXPECT_NEAR(params.handEyeTranslation, shift, 0.0011);
    }
}

TEST(SurgTrack_Synthetic, toolsStayInViewAndApart)
{
    for (int seed = 0; seed < 10; seed++)
        for (int tools = 2; tools <= 4; tools++)
        {
            SyntheticScene::Params params = smallScene();
            params.seed = seed;
            params.tools = tools;
            params.frames = 100;
            const Ptr<SyntheticScene> scene = makeScene(params);
            ASSERT_EQ(tools, scene->toolCount());
            const Rect2d image(Point2d(), Size2d(params.imageSize));
            for (int frame = 0; frame < params.frames; frame += 3)
            {
                std::vector<Point3d> ends;
                for (int i = 0; i < tools; i++)
                {
                    const Matx44d T = scene->truePose(i, frame / params.fps);
                    const Point3d end(T(0, 3), T(1, 3), T(2, 3));
                    // 9 mm: more than the width of a tool.
                    for (size_t k = 0; k < ends.size(); k++) EXPECT_GT(cv::norm(end - ends[k]), 0.009);
                    ends.push_back(end);
                    EXPECT_TRUE(image.contains(scene->camera().project(end)));
                    EXPECT_GT(end.z, 0.06);
                    EXPECT_LT(end.z, 0.13);
                }
            }
        }
}

// Each tool's noise is its own: were a stream shared, two arms would err alike.
TEST(SurgTrack_Synthetic, readingsOfDifferentArmsErrDifferently)
{
    SyntheticScene::Params params = smallScene();
    params.tools = 4;
    const Ptr<SyntheticScene> scene = makeScene(params);
    // Bias and drift hardly change from record to record (100 Hz); what does is the white noise.
    std::vector<std::vector<double> > noise(4);
    for (int i = 0; i < 4; i++)
        for (int record = 0; record < 20; record++)
        {
            const double time = record / 100.;
            noise[i].push_back(scene->recordedJoints(i, time)[4] - scene->trueJoints(i, time)[4]);
        }
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < i; k++)
            for (int lag = -1; lag <= 1; lag++)
            {
                int alike = 0;
                for (int record = 2; record < 19; record++)
                    alike += std::abs((noise[i][record] - noise[i][record - 1]) - (noise[k][record + lag] - noise[k][record + lag - 1])) < 1e-5;
                EXPECT_LT(alike, 4);    // chance: differences of 8e-4 agree to 1e-5 once in a hundred times
            }
}

// The tool's outline in the image is where the renderer, given the true pose, draws it.
TEST(SurgTrack_Synthetic, imageShowsTheToolAtItsTruePose)
{
    SyntheticScene::Params params = smallScene();
    params.imageNoise = 0;
    params.distortion = true;
    const Ptr<SyntheticScene> scene = makeScene(params);
    const Ptr<MeshRenderer> renderer = MeshRenderer::createSoftware();
    Mat images[2], masks[2];
    for (int i = 0; i < 2; i++)
    {
        Mat depth, shading;
        scene->render(10 * i, images[i]);
        renderer->renderTool(scene->model(), scene->trueJoints(0, 10 * i / params.fps), scene->camera_T_base(0), scene->camera(), depth, masks[i], shading);
        masks[i] = masks[i] > 0;
    }
    // Steel and plastic are grey, tissue is not: the mean saturation tells them apart.
    for (int i = 0; i < 2; i++)
    {
        Mat hsv, inside, outside;
        cvtColor(images[i], hsv, COLOR_BGR2HSV);
        erode(masks[i], inside, Mat(), Point(-1, -1), 2);
        dilate(masks[i], outside, Mat(), Point(-1, -1), 2);
        ASSERT_GT(countNonZero(inside), 2000);
        Mat edge = outside.clone();
        dilate(edge, edge, Mat(), Point(-1, -1), 3);
        edge.setTo(0, outside);      // a ring of tissue, 3 to 5 pixel from the tool
        EXPECT_LT(cv::mean(hsv, inside)[1], 60);
        EXPECT_GT(cv::mean(hsv, edge)[1], 90);
    }
}

class SurgTrack_SyntheticFolder : public testing::Test
{
protected:
    void SetUp() CV_OVERRIDE { folder = cv::tempfile(""); }
    void TearDown() CV_OVERRIDE { cv::utils::fs::remove_all(folder); }
    String folder;
};

TEST_F(SurgTrack_SyntheticFolder, readsBackAsASequence)
{
    SyntheticScene::Params params = smallScene();
    params.tools = 2;
    params.stereo = params.distortion = true;
    params.fps = 30;
    const Ptr<SyntheticScene> scene = makeScene(params);
    scene->write(folder);
    const Ptr<Sequence> sequence = Sequence::load(folder);
    EXPECT_EQ(30, sequence->fps());
    ASSERT_EQ(2, sequence->toolCount());
    ASSERT_TRUE(sequence->isStereo());
    EXPECT_EQ(scene->right_T_left(), sequence->right_T_left());
    EXPECT_EQ(scene->camera().k[0], sequence->leftCamera().k[0]);
    const Ptr<ToolModel> model = ToolModel::load(sequence->tool(0).model);
    for (int tool = 0; tool < 2; tool++)
    {
        EXPECT_LT(cv::norm(scene->nominal_T_base(tool), sequence->tool(tool).nominal_T_base, NORM_INF), 1e-12);   // 17 digits in the file
        for (int frame = 0; frame < params.frames; frame++)
        {
            const double time = frame / params.fps;
            Matx44d truth;
            std::vector<double> joints, readings;
            ASSERT_TRUE(sequence->groundTruth(tool, frame, truth, joints));
            EXPECT_LT(cv::norm(scene->truePose(tool, time), truth, NORM_INF), 1e-8);                              // 9 digits in the file
            EXPECT_LT(cv::norm(scene->camera_T_base(tool) * model->endEffectorPose(joints), truth, NORM_INF), 1e-8);
            ASSERT_TRUE(sequence->jointsAt(tool, time, readings, model->coordinateNames()));
            // Linear between records 10 ms apart: acceleration * (0.01 s)^2 / 8, and the roll has 40 rad/s^2 at most.
            EXPECT_LT(cvtest::norm(Mat(scene->recordedJoints(tool, time)), Mat(readings), NORM_INF), 6e-4);
        }
    }
}

TEST_F(SurgTrack_SyntheticFolder, videosHoldTheFrames)
{
    SyntheticScene::Params params = smallScene();
    params.stereo = true;
    params.frames = 6;
    const Ptr<SyntheticScene> scene = makeScene(params);
    scene->write(folder);
    for (int eye = 0; eye < 2; eye++)
    {
        cv::VideoCapture video(cv::utils::fs::join(folder, eye ? "right.mp4" : "left.mp4"));
        ASSERT_TRUE(video.isOpened());
        Mat decoded, drawn;
        int frames = 0;
        for (; video.read(decoded); frames++)
        {
            scene->render(frames, drawn, eye == 1);
            ASSERT_EQ(drawn.size(), decoded.size());
            // Compression and sensor noise; another frame or the other eye is 12 and more away.
            EXPECT_LT(cvtest::norm(drawn, decoded, NORM_L1) / (3. * drawn.total()), 6) << "frame " << frames;
        }
        EXPECT_EQ(params.frames, frames);
    }
}

TEST_F(SurgTrack_SyntheticFolder, keypointsAreWhereTheModelPutsThem)
{
    SyntheticScene::Params params = smallScene();
    params.distortion = true;
    params.frames = 5;
    const Ptr<SyntheticScene> scene = makeScene(params);
    scene->write(folder);
    std::ifstream file(cv::utils::fs::join(folder, "keypoints.csv").c_str());
    std::string line;
    ASSERT_TRUE(std::getline(file, line));
    EXPECT_EQ("frame,tool,keypoint,u,v,x,y,z,visible", line);
    const std::vector<String> names = scene->model()->keypointNames();
    int rows = 0, visible = 0;
    for (; std::getline(file, line); rows++)
    {
        int frame, seen;
        char name[64];
        Point2d imagePoint;
        Point3d p;
        ASSERT_EQ(8, sscanf(line.c_str(), "%d,PSM1,%63[^,],%lf,%lf,%lf,%lf,%lf,%d", &frame, name, &imagePoint.x, &imagePoint.y, &p.x, &p.y, &p.z, &seen));
        const int k = rows % (int)names.size();
        EXPECT_EQ(rows / (int)names.size(), frame);
        EXPECT_EQ(names[k], name);
        Mat basePoints;
        scene->model()->keypointPositions(scene->trueJoints(0, frame / params.fps), basePoints);
        const double* b = basePoints.ptr<double>(k);
        const Vec4d expected = scene->camera_T_base(0) * Vec4d(b[0], b[1], b[2], 1);
        EXPECT_LT(cv::norm(Vec3d(expected.val) - Vec3d(p.x, p.y, p.z)), 1e-8);                     // nine digits
        EXPECT_LT(cv::norm(scene->camera().project(p) - imagePoint), 1e-4);                        // nine digits
        visible += seen;
    }
    EXPECT_EQ(5 * (int)names.size(), rows);
    EXPECT_GE(visible, 5 * 4);                       // the side towards the camera
    EXPECT_LT(visible, 5 * (int)names.size());       // not the far side
}

TEST_F(SurgTrack_SyntheticFolder, errorNamesTheFolderThatCannotBeMade)
{
    std::ofstream(folder.c_str()) << "a file in the way";
    try
    {
        makeScene(smallScene())->write(folder);
        ADD_FAILURE() << "expected an exception";
    }
    catch (const cv::Exception& e)
    {
        EXPECT_NE(String::npos, e.err.find(folder)) << e.err;
    }
}

TEST(SurgTrack_Synthetic, refusesParametersOutOfRange)
{
    SyntheticScene::Params params;
    params.tools = 5;
    EXPECT_THROW(makeScene(params), cv::Exception);
    params.tools = 0;
    EXPECT_THROW(makeScene(params), cv::Exception);
    params = SyntheticScene::Params();
    params.fps = 0;
    EXPECT_THROW(makeScene(params), cv::Exception);
    params = SyntheticScene::Params();
    params.imageSize = Size();
    EXPECT_THROW(makeScene(params), cv::Exception);
    params = SyntheticScene::Params();
    params.jointNoise = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(makeScene(params), cv::Exception);
    params = SyntheticScene::Params();
    params.imageSize = Size(321, 240);
    EXPECT_THROW(makeScene(params)->write(cv::tempfile()), cv::Exception) << "encoders need even sizes";
    Mat image;
    EXPECT_THROW(makeScene(smallScene())->render(0, image, true), cv::Exception) << "no right eye";
    EXPECT_THROW(makeScene(smallScene())->render(-1, image), cv::Exception);
}

}} // namespace
