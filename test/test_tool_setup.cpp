// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_import.hpp"
#include "test_common.hpp"
#include "opencv2/surgtrack/tool_setup.hpp"
#include "opencv2/surgtrack/synthetic.hpp"

namespace opencv_test { namespace {

using namespace cv::surgtrack;

class SurgTrack_ToolSetup : public ImportTest
{
};

//! The built-in needle driver without its keypoints, and changed as the function says.
template <class Change> Ptr<ToolModel> bare(Change change)
{
    ToolModel::Description tool = ToolModel::needleDriver()->description();
    tool.keypoints.clear();
    change(tool);
    return ToolModel::create(tool);
}

Ptr<ToolModel> bare() { return bare([](ToolModel::Description&) {}); }

// How many templates are cut of the tool, straight and with closed jaws, from each of twelve sides at 100 mm.
std::vector<int> seenFrom(const Ptr<ToolModel>& model)
{
    const CameraModel camera(Matx33d(818, 0, 359.5, 0, 818, 287.5, 0, 0, 1), noArray(), Size(720, 576));
    const Ptr<PartTemplateRenderer> renderer = PartTemplateRenderer::create();
    renderer->addTool(model);
    std::vector<double> joints(model->coordinateNames().size(), 0.);
    joints[2] = 0.1;
    const Matx44d tool = model->endEffectorPose(joints);
    std::vector<int> counts;
    for (int side = 0; side < 12; side++)
    {
        // The shaft, z of the tool, goes to the right in the image, and is turned about itself.
        const Matx33d R = Matx33d(0, 0, 1, 0, 1, 0, -1, 0, 0) * rotationMatrix(Vec3d(0, 0, side * CV_PI / 6));
        const Matx44d camera_T_base = rigid(R, Point3d(0.01, 0, 0.1)) * tool.inv();
        counts.push_back((int)renderer->renderTool(camera, camera_T_base, joints).size());
    }
    return counts;
}

TEST_F(SurgTrack_ToolSetup, keypointsAreSeenFromAllSides)
{
    const Ptr<ToolModel> model = chooseKeypoints(bare());
    EXPECT_GE(model->keypoints().size(), 24u);
    EXPECT_TRUE(checkTool(model).empty()) << checkTool(model)[0];
    const std::vector<int> seen = seenFrom(model);
    for (size_t side = 0; side < seen.size(); side++)
        EXPECT_GE(seen[side], 6) << "side " << side;
    const std::vector<double> scores = model->keypointScores();
    for (size_t i = 0; i < scores.size(); i++)
        EXPECT_TRUE(scores[i] >= 0.75 && scores[i] <= 1) << model->keypointNames()[i] << ": " << scores[i];
}

TEST_F(SurgTrack_ToolSetup, theSameToolGetsTheSameKeypoints)
{
    const Ptr<ToolModel> a = chooseKeypoints(bare(), 12), b = chooseKeypoints(bare(), 12);
    ASSERT_EQ(a->keypoints().size(), b->keypoints().size());
    for (size_t i = 0; i < a->keypoints().size(); i++)
    {
        EXPECT_EQ(a->keypoints()[i].name, b->keypoints()[i].name);
        EXPECT_EQ(a->keypoints()[i].linkPoint, b->keypoints()[i].linkPoint);
    }
}

//! What is left of a tool whose meshes were written in another unit, turned by R, and put right by what reads them: rounding.
Ptr<ToolModel> rewritten(double unit, const Matx33d& R, bool reversed)
{
    return bare([&](ToolModel::Description& tool)
    {
        for (size_t m = 0; m < tool.meshes.size(); m++)
        {
            Mesh& mesh = tool.meshes[m];
            for (size_t i = 0; i < mesh.vertices.size(); i++)
                mesh.vertices[i] = Point3f(R * (unit * Point3d(Point3f(R.t() * Point3d(mesh.vertices[i]) * (1 / unit)))));
            for (size_t i = 0; i < mesh.triangles.size() && reversed; i++)   // as of a mesh that was mirrored
                std::swap(mesh.triangles[i][1], mesh.triangles[i][2]);
            if (reversed)
                std::reverse(mesh.triangles.begin(), mesh.triangles.end());
        }
    });
}

TEST_F(SurgTrack_ToolSetup, keypointsDoNotDependOnHowTheMeshesAreWritten)
{
    const struct { const char* what; double unit; Matx33d R; bool reversed; } ways[] = {
        { "millimetres", 0.001, Matx33d::eye(), false },
        { "centimetres", 0.01, Matx33d::eye(), false },
        { "inches", 0.0254, Matx33d::eye(), false },
        { "mirrored, another order", 1, Matx33d::diag(Vec3d(-1, 1, 1)), true },
        { "a quarter turn", 0.001, Matx33d(0, -1, 0, 1, 0, 0, 0, 0, 1), false },
        { "turned", 1, rotationMatrix(Vec3d(0.3, 0.7, -1.1)), false } };
    const Ptr<ToolModel> expected = chooseKeypoints(bare());
    for (size_t i = 0; i < sizeof(ways) / sizeof(ways[0]); i++)
    {
        const Ptr<ToolModel> model = chooseKeypoints(rewritten(ways[i].unit, ways[i].R, ways[i].reversed));
        ASSERT_EQ(expected->keypoints().size(), model->keypoints().size()) << ways[i].what;
        for (size_t k = 0; k < expected->keypoints().size(); k++)
        {
            EXPECT_EQ(expected->keypoints()[k].name, model->keypoints()[k].name) << ways[i].what;
            // A vertex may be rounded to the next place, 1 micrometre away.
            EXPECT_LT(cv::norm(expected->keypoints()[k].linkPoint - model->keypoints()[k].linkPoint), 2e-6) << ways[i].what << ", " << k;
        }
    }
}

TEST_F(SurgTrack_ToolSetup, toolsWithoutJawsAndWithOneThatSlidesGetKeypoints)
{
    const Ptr<ToolModel> tools[] = {
        bare([](ToolModel::Description& tool)
        {
            for (int i = 6; i < 8; i++)   // both jaws stand still
            {
                tool.links[i].jointType = ToolModel::JOINT_FIXED;
                tool.links[i].coordinate = -1;
            }
            tool.coordinates.pop_back();
        }),
        bare([](ToolModel::Description& tool)
        {
            tool.links[6].jointType = ToolModel::JOINT_FIXED;
            tool.links[6].coordinate = -1;
            tool.links[7].jointType = ToolModel::JOINT_PRISMATIC;   // one slides along the pivot
            tool.links[7].scale = 1;
        }) };
    for (int i = 0; i < 2; i++)
    {
        const Ptr<ToolModel> model = chooseKeypoints(tools[i], 12);
        EXPECT_GE(model->keypoints().size(), 12u);
        std::set<int> links;
        for (size_t k = 0; k < model->keypoints().size(); k++)
            links.insert(model->keypoints()[k].link);
        EXPECT_GE(links.size(), 3u) << "tool " << i << ": on shaft, wrist and jaws";
    }
}

TEST_F(SurgTrack_ToolSetup, nothingToFindIsAnError)
{
    EXPECT_ERROR(chooseKeypoints(bare([](ToolModel::Description& tool)
    {
        tool.meshes.clear();
        for (size_t i = 0; i < tool.links.size(); i++)
            tool.links[i].mesh = -1;
    })), "expected meshes");
    EXPECT_THROW(chooseKeypoints(bare(), 3), cv::Exception);
}

TEST_F(SurgTrack_ToolSetup, theSecondBuiltInToolCanBeTracked)
{
    const Ptr<ToolModel> model = ToolModel::curvedScissors();
    EXPECT_TRUE(checkTool(model).empty()) << checkTool(model)[0];
    const std::vector<int> seen = seenFrom(model);
    for (size_t side = 0; side < seen.size(); side++)
        EXPECT_GE(seen[side], 6) << "side " << side;
}

TEST_F(SurgTrack_ToolSetup, checkSaysWhatIsWrong)
{
    const struct { const char* what; Ptr<ToolModel> model; } tools[] = {
        { "scale 0.001", bare([](ToolModel::Description& tool)
          {
              for (size_t m = 0; m < tool.meshes.size(); m++)
                  for (size_t i = 0; i < tool.meshes[m].vertices.size(); i++)
                      tool.meshes[m].vertices[i] *= 1000;
          }) },
        { "mm thick", bare([](ToolModel::Description& tool)   // in inches, read as metres / 100
          {
              for (size_t m = 0; m < tool.meshes.size(); m++)
                  for (size_t i = 0; i < tool.meshes[m].vertices.size(); i++)
                      tool.meshes[m].vertices[i] *= 0.05;
          }) },
        { "from all others", bare([](ToolModel::Description& tool)
          {
              for (size_t i = 0; i < tool.meshes[3].vertices.size(); i++)
                  tool.meshes[3].vertices[i].y += 0.05f;
          }) },
        { "keypoint k is 5 mm off", bare([](ToolModel::Description& tool)
          {
              ToolModel::Keypoint keypoint;
              keypoint.name = "k";
              keypoint.link = 3;
              keypoint.linkPoint = Point3d(0.0092, 0, -0.1);   // the shaft's radius is 4.2 mm
              tool.keypoints.push_back(keypoint);
          }) },
        { "0 keypoints", bare() },
        { "coordinate q5 goes as far as 90", bare([](ToolModel::Description& tool)
          {
              tool.limits.assign(tool.coordinates.size(), Vec2d(-1, 1));
              tool.limits[4] = Vec2d(-90, 90);
          }) },
        { "no joint moves the end effector", bare([](ToolModel::Description& tool)
          {
              ToolModel::Link link;
              link.name = "stand";
              tool.links.push_back(link);
              tool.endEffectorLink = (int)tool.links.size() - 1;
          }) } };
    for (size_t i = 0; i < sizeof(tools) / sizeof(tools[0]); i++)
    {
        const std::vector<String> findings = checkTool(tools[i].model);
        String all;
        for (size_t k = 0; k < findings.size(); k++)
            all += findings[k] + "\n";
        EXPECT_NE(String::npos, all.find(tools[i].what)) << "expected `" << tools[i].what << "`, got " << all;
    }
    EXPECT_TRUE(checkTool(ToolModel::needleDriver()).empty());
}

TEST_F(SurgTrack_ToolSetup, sheetShowsTheToolEverywhere)
{
    const Ptr<ToolModel> models[] = { ToolModel::needleDriver(), ToolModel::curvedScissors(), bare(), bare([](ToolModel::Description& tool)
    {
        tool.link_T_endEffector(1, 3) -= 0.006;   // before the tips
    }) };
    for (int i = 0; i < 4; i++)
    {
        Mat sheet;
        drawToolSheet(models[i], sheet);
        ASSERT_EQ(CV_8UC3, sheet.type());
        for (int row = 0; row < 3; row++)
            for (int column = 0; column < 6; column++)
            {
                const Rect cell(column * sheet.cols / 6, 78 + row * 256, sheet.cols / 6, 230);
                Mat grey;
                cvtColor(sheet(cell), grey, COLOR_BGR2GRAY);
                EXPECT_GT(countNonZero(grey < 230), cell.area() / 40) << "the tool is in the cell";
                EXPECT_EQ(0, countNonZero(grey.row(0) < 230) + countNonZero(grey.row(grey.rows - 1) < 230)) << "all of it, tool " << i << ", row " << row;
            }
    }
    Mat sheet;
    drawToolSheet(bare([](ToolModel::Description& tool)
    {
        tool.meshes.clear();
        for (size_t i = 0; i < tool.links.size(); i++)
            tool.links[i].mesh = -1;
    }), sheet);
    EXPECT_FALSE(sheet.empty()) << "a chain alone is drawn too";
}

TEST_F(SurgTrack_ToolSetup, limitsAndScoresAreInTheToolFile)
{
    ToolModel::Description tool = ToolModel::needleDriver()->description();
    tool.limits.assign(tool.coordinates.size(), Vec2d(-DBL_MAX, DBL_MAX));
    tool.limits[4] = Vec2d(-1.4, 1.3);
    tool.limits[6] = Vec2d(0, DBL_MAX);
    tool.keypoints[0].score = 0.9;
    ToolModel::create(tool)->save(path("tool.yaml"));
    const Ptr<ToolModel> model = loadTool(path("tool.yaml"));
    const Mat_<double> limits = model->jointLimits();
    EXPECT_EQ(-DBL_MAX, limits(3, 0));
    EXPECT_EQ(-1.4, limits(4, 0));
    EXPECT_EQ(1.3, limits(4, 1));
    EXPECT_EQ(0, limits(6, 0));
    EXPECT_EQ(DBL_MAX, limits(6, 1));
    EXPECT_EQ(0.9, model->keypointScores()[0]);
    EXPECT_LT(model->keypointScores()[1], 0);
    const std::string text = get("tool.yaml");
    put("score.yaml", replaced(text, "score:9", "score:99"));
    EXPECT_ERROR(ToolModel::load(path("score.yaml")), "score");
    put("limits.yaml", replaced(text, "lower:-1", "lower:5"));
    EXPECT_ERROR(ToolModel::load(path("limits.yaml")), "limits[4]: expected lower and upper");
    put("joint.yaml", replaced(text, "coordinate:q5, lower", "coordinate:q9, lower"));
    EXPECT_ERROR(ToolModel::load(path("joint.yaml")), "q9");
}

TEST_F(SurgTrack_ToolSetup, anyToolWithAWristMovesInSyntheticScenes)
{
    const Ptr<ToolModel> hook = bare([](ToolModel::Description& tool)
    {
        for (int i = 6; i < 8; i++)
        {
            tool.links[i].jointType = ToolModel::JOINT_FIXED;
            tool.links[i].coordinate = -1;
        }
        tool.coordinates.pop_back();
        for (size_t i = 0; i < tool.coordinates.size(); i++)
            tool.coordinates[i] = format("joint_%d", (int)i);
        tool.limits.assign(6, Vec2d(-0.3, 0.3));
    });
    SyntheticScene::Params params;
    params.frames = 20;
    const Ptr<SyntheticScene> scene = SyntheticScene::create(hook, params);
    for (int frame = 0; frame < params.frames; frame++)
    {
        const std::vector<double> joints = scene->trueJoints(0, frame / params.fps);
        ASSERT_EQ(6u, joints.size());
        for (int i = 4; i < 6; i++)
            EXPECT_LE(std::abs(joints[i]), 0.3) << "within the limits of the wrist";
        const Matx44d T = scene->truePose(0, frame / params.fps);
        EXPECT_LT(cv::norm(Vec3d(T(0, 3), T(1, 3), T(2, 3)) - Vec3d(0, 0, 0.1)), 0.03) << "in front of the camera";
    }
    EXPECT_ERROR(SyntheticScene::create(bare([](ToolModel::Description& tool)
    {
        tool.endEffectorLink = 3;   // nothing bends before it
    })), "two joints of a wrist");
}

}} // namespace opencv_test
