// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_import.hpp"

namespace opencv_test { namespace {

const char* const TETRAHEDRON = "v 0 0 0\nv 2 0 0\nv 0 2 0\nv 0 0 4\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

// An arm that turns and slides, as the dVRK describes arms today.
const char* const ARM =
    "/* -*- Mode: Javascript -*- */\n"
    "{ // see the user guide\n"
    "  \"DH\": { \"convention\": \"modified\", \"joints\": [\n"
    "    { \"name\": \"yaw\", \"alpha\": 1.5708, \"A\": 0.0, \"theta\": 0.7854, \"D\": 0.1, \"type\": \"revolute\", \"mode\": \"active\","
    " \"offset\": 1.5708, \"qmin\": -1.6 },\n"
    "    { \"name\": \"insertion\", \"alpha\": -1.5708, \"A\": 0.2, \"theta\": 0.1, \"D\": 0.3, \"type\": \"prismatic\", \"offset\": -0.4318 }\n"
    "  ] } }\n";

const char* const INSTRUMENT =
    "{ \"DH\": { \"convention\": \"modified\", \"joints\": [\n"
    "    { \"name\": \"roll\", \"alpha\": 0, \"A\": 0.0091, \"theta\": 0, \"D\": 0.4162, \"type\": \"revolute\", \"offset\": -1.5708 }\n"
    "  ] },\n"
    "  \"jaw\": { \"qmin\": -0.7, \"qmax\": 1.4 },\n"
    "  \"tooltip_offset\": [[0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]] }\n";

// The same tool in the old format: one file, hyphens, the convention in each link, no names.
const char* const OLD =
    "{ \"DH\": { \"links\": [\n"
    "    { \"convention\": \"modified\", \"alpha\": 1.5708, \"A\": 0.0, \"theta\": 0.7854, \"D\": 0.1, \"type\": \"revolute\", \"offset\": 1.5708 },\n"
    "    { \"convention\": \"modified\", \"alpha\": -1.5708, \"A\": 0.2, \"theta\": 0.1, \"D\": 0.3, \"type\": \"prismatic\", \"offset\": -0.4318 },\n"
    "    { \"convention\": \"modified\", \"alpha\": 0, \"A\": 0.0091, \"theta\": 0, \"D\": 0.4162, \"type\": \"revolute\", \"offset\": -1.5708 }\n"
    "  ] }, \"jaw\": { },\n"
    "  \"tooltip-offset\": [[0.0, -1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [-1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]] }\n";

Matx44d denavitHartenberg(double alpha, double a, double theta, double d)
{
    return rigid(rotationMatrix(Vec3d(alpha, 0, 0)), Point3d()) * rigid(Matx33d::eye(), Point3d(a, 0, 0))
         * rigid(rotationMatrix(Vec3d(0, 0, theta)), Point3d(0, 0, d));
}

class SurgTrack_ImportDvrk : public ImportTest
{
protected:
    Ptr<ToolModel> tool(const ToolParts& parts = ToolParts()) const
    {
        const std::vector<String> files = list(put("PSM.json", ARM), put("DRIVER_1.json", INSTRUMENT));
        return orSkip([&]() { return importDvrkTool(files, parts); });
    }

    void expectError(const String& arm, const char* what) const
    {
        EXPECT_ERROR(importDvrkTool(list(put("bad.json", arm))), "bad.json");
        EXPECT_ERROR(importDvrkTool(list(put("bad.json", arm))), what);
    }
};

TEST_F(SurgTrack_ImportDvrk, offsetsAddToTheAngleThatTurnsAndTheLengthThatSlides)
{
    const Ptr<ToolModel> model = tool();
    EXPECT_EQ("DRIVER_1", model->name());
    ASSERT_EQ(4u, model->coordinateNames().size());
    EXPECT_EQ("q3", model->coordinateNames()[2]);
    EXPECT_EQ("jaw", model->coordinateNames()[3]);
    EXPECT_EQ("insertion", model->linkNames()[1]);
    const double joints[] = { 0.3, 0.05, -0.4, 0.6 };
    const Matx44d expected = denavitHartenberg(CV_PI / 2, 0, CV_PI / 4 + CV_PI / 2 + 0.3, 0.1)
                             * denavitHartenberg(-CV_PI / 2, 0.2, 0.1, 0.3 - 0.4318 + 0.05)
                             * denavitHartenberg(0, 0.0091, -CV_PI / 2 - 0.4, 0.4162);
    const Matx44d tip(0, -1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 0, 0, 0, 0, 1);
    std::vector<Matx44d> links;
    model->forwardKinematics(Mat(1, 4, CV_64F, (void*)joints), links);
    ASSERT_EQ(5u, links.size());
    EXPECT_LT(cv::norm(links[2] - expected), 1e-14);   // rounding: 1.5708 stands for pi / 2
    EXPECT_LT(cv::norm(model->endEffectorPose(Mat(1, 4, CV_64F, (void*)joints)) - expected * tip), 1e-14);
    // The jaws open by half of the angle each, to both sides.
    EXPECT_LT(cv::norm(links[linkIndex(*model, "jaw_right")] - expected * denavitHartenberg(0, 0, 0.3, 0)), 1e-14);
    EXPECT_LT(cv::norm(links[linkIndex(*model, "jaw_left")] - expected * denavitHartenberg(0, 0, -0.3, 0)), 1e-14);
}

TEST_F(SurgTrack_ImportDvrk, limitsOfJointsAreTaken)
{
    const String arm = replaced(ARM, "\"qmin\": -1.6", "\"qmin\": -1.6, \"qmax\": 1.5");
    const std::vector<String> files = list(put("PSM.json", arm), put("DRIVER_1.json", INSTRUMENT));
    const Ptr<ToolModel> model = orSkip([&]() { return importDvrkTool(files); });
    const Mat_<double> limits = model->jointLimits();
    EXPECT_EQ(Vec2d(-1.6, 1.5), Vec2d(limits(0, 0), limits(0, 1)));
    EXPECT_EQ(Vec2d(-DBL_MAX, DBL_MAX), Vec2d(limits(1, 0), limits(1, 1))) << "the file has none of the second joint";
}

TEST_F(SurgTrack_ImportDvrk, oldFilesGiveTheSameTool)
{
    const Ptr<ToolModel> a = tool(), b = importDvrkTool(list(put("old.json", OLD)));
    RNG rng(1);
    for (int i = 0; i < 20; i++)
    {
        const std::vector<double> q = randomJoints(*a, rng);
        EXPECT_EQ(0, cv::norm(a->endEffectorPose(q) - b->endEffectorPose(q)));
    }
}

TEST_F(SurgTrack_ImportDvrk, meshesAndKeypointsMayBeGivenInTheAxesOfTheTool)
{
    ToolParts parts;
    parts.meshes = list("roll:" + put("shaft.obj", TETRAHEDRON));
    parts.meshScale = 0.001;
    parts.meshesInToolAxes = true;
    parts.keypoints = put("keypoints.csv", "name,link,x,y,z\npeak,roll,0,0,4\nflat,roll,2,0,0\n");
    const Ptr<ToolModel> model = tool(parts);
    ASSERT_EQ(1u, model->meshes().size());
    ASSERT_EQ(2u, model->keypoints().size());
    EXPECT_LT(cv::norm(model->keypoints()[0].linkPoint - Point3d(0, 0.004, 0)), 1e-15);     // the tool's z is the link's y
    EXPECT_LT(cv::norm(model->keypoints()[1].linkPoint - Point3d(0, 0, -0.002)), 1e-15);    // and its x the link's -z
    double furthest = 0;
    for (size_t i = 0; i < model->meshes()[0].vertices.size(); i++)
        furthest = std::max(furthest, (double)model->meshes()[0].vertices[i].y);
    EXPECT_NEAR(0.004, furthest, 1e-9);   // single precision
    parts.meshesInToolAxes = false;
    EXPECT_LT(cv::norm(tool(parts)->keypoints()[0].linkPoint - Point3d(0, 0, 0.004)), 1e-15);
}

TEST_F(SurgTrack_ImportDvrk, takesWhatItLacksFromAToolOfTheSameBuild)
{
    needleDriver()->save(path("driver.yaml"));
    const String psm = recorded("formats/dvrk/PSM.json"), instrument = recorded("formats/dvrk/LARGE_NEEDLE_DRIVER_420006.json");
    ToolParts parts;
    parts.like = path("driver.yaml");
    const Ptr<ToolModel> model = orSkip([&]() { return importDvrkTool(list(psm, instrument), parts); });
    EXPECT_EQ(needleDriver()->linkNames(), model->linkNames());
    EXPECT_EQ(needleDriver()->keypointNames(), model->keypointNames());
    EXPECT_EQ(needleDriver()->meshes().size(), model->meshes().size());
    // This instrument has a shaft of 0.4670 m instead of 0.4162 m: the slide has to go back by as much.
    std::vector<double> joints(7, 0.1), back = joints;
    back[2] -= 0.4670 - 0.4162;
    EXPECT_LT(cv::norm(model->endEffectorPose(back) - needleDriver()->endEffectorPose(joints)), 1e-12);   // rounding of the saved file
}

TEST_F(SurgTrack_ImportDvrk, theLargeNeedleDriverIsThatOfTheToolFile)
{
    const String psm = recorded("formats/dvrk/PSM.json"), instrument = recorded("formats/dvrk/LARGE_NEEDLE_DRIVER_400006.json");
    const Ptr<ToolModel> expected = ToolModel::load(recorded("tools/large_needle_driver/large_needle_driver_lowres.yaml"));
    const Ptr<ToolModel> model = orSkip([&]() { return importDvrkTool(list(psm, instrument)); });
    RNG rng(2);
    for (int i = 0; i < 100; i++)
    {
        std::vector<double> joints = randomJoints(*model, rng);
        std::vector<Matx44d> a, b;
        model->forwardKinematics(joints, a);
        expected->forwardKinematics(joints, b);
        ASSERT_EQ(8u, a.size());
        for (size_t k = 0; k < 8; k++)
            EXPECT_LT(cv::norm(a[k] - b[k]), 1e-12) << model->linkNames()[k];   // rounding
    }
}

TEST_F(SurgTrack_ImportDvrk, meshesInTheAxesOfTheToolAreThoseOfTheToolFile)
{
    const String psm = recorded("formats/dvrk/PSM.json"), instrument = recorded("formats/dvrk/LARGE_NEEDLE_DRIVER_400006.json");
    const Ptr<ToolModel> expected = ToolModel::load(recorded("tools/large_needle_driver/large_needle_driver_lowres.yaml"), 0);
    const char* const links[][2] = { { "roll", "shaft" }, { "wrist_pitch", "logobody" }, { "jaw_right", "jawRight" }, { "jaw_left", "jawLeft" } };
    ToolParts parts;
    for (int i = 0; i < 4; i++)
        parts.meshes.push_back(links[i][0] + (":" + recorded(format("tools/large_needle_driver/meshes_lowres/%s.ply", links[i][1]))));
    parts.meshScale = 0.001;
    parts.meshesInToolAxes = true;
    parts.keypoints = put("points.csv", "name,link,x,y,z\nshaft_pivot_flat,roll,0,0,-3.93\nlogo_s_flat,wrist_pitch,-0.317,-5.841,2.998\n");
    const Ptr<ToolModel> model = orSkip([&]() { return importDvrkTool(list(psm, instrument), parts); });
    ASSERT_EQ(4u, model->meshes().size());
    for (size_t i = 0; i < 4; i++)
        EXPECT_EQ(0, cvtest::norm(Mat(model->meshes()[i].vertices), Mat(expected->meshes()[i].vertices), NORM_INF));
    for (size_t i = 0; i < 2; i++)
    {
        const std::vector<String> names = expected->keypointNames();
        const size_t k = std::find(names.begin(), names.end(), model->keypointNames()[i]) - names.begin();
        EXPECT_LT(cv::norm(model->keypoints()[i].linkPoint - expected->keypoints()[k].linkPoint), 1e-15);   // rounding
    }
}

TEST_F(SurgTrack_ImportDvrk, theTipOfTheFileIsTakenWhereItHasAPlace)
{
    needleDriver()->save(path("driver.yaml"));
    ToolParts parts;
    parts.like = path("driver.yaml");
    const String psm = recorded("formats/dvrk/PSM.json");
    std::ifstream file(recorded("formats/dvrk/LARGE_NEEDLE_DRIVER_400006.json").c_str());
    std::ostringstream text;
    text << file.rdbuf();
    const String moved = put("moved.json", replaced(text.str(), "[ 0.0,  0.0,  1.0,  0.0]", "[ 0.0,  0.0,  1.0,  0.02]"));
    const std::vector<double> joints(7, 0.1);
    std::vector<Matx44d> links;
    const Ptr<ToolModel> model = orSkip([&]() { return importDvrkTool(list(psm, moved), parts); });
    model->forwardKinematics(joints, links);
    const Matx44d link_T_tip = links[model->endEffectorLink()].inv() * model->endEffectorPose(joints);
    EXPECT_NEAR(0.02, link_T_tip(1, 3), 1e-12);   // rounding
    EXPECT_NEAR(1, link_T_tip(1, 2), 1e-12);
}

TEST_F(SurgTrack_ImportDvrk, refusesWhatItCannotTake)
{
    tool();
    expectError(replaced(ARM, "\"modified\"", "\"standard\""), "standard");
    expectError(replaced(ARM, "\"prismatic\"", "\"ball\""), "DH.joints[1].type");
    expectError(replaced(ARM, "\"alpha\": -1.5708, ", ""), "DH.joints[1].alpha: missing");
    expectError(replaced(ARM, "\"theta\": 0.7854", "\"theta\": \"much\""), "DH.joints[0].theta: expected a finite number");
    expectError(replaced(ARM, "\"DH\"", "\"HD\""), "DH: missing");
    expectError(replaced(ARM, "{ // see the user guide", "{ \"snake-like\": true,"), "snake");
    expectError(replaced(INSTRUMENT, "[-1.0, 0.0, 0.0, 0.0]", "[-2.0, 0.0, 0.0, 0.0]"), "tooltip_offset");
    expectError(replaced(INSTRUMENT, "[-1.0, 0.0, 0.0, 0.0]", "[-1.0, 0.0, 0.0]"), "tooltip_offset");
    expectError("{ \"DH\": ", "JSON");
    EXPECT_ERROR(importDvrkTool(list(path("none.json"))), "none.json");
    EXPECT_ERROR(importDvrkTool(std::vector<String>()), "files");
    needleDriver()->save(path("driver.yaml"));
    ToolParts parts;
    parts.like = path("driver.yaml");
    EXPECT_ERROR(tool(parts), "expected 3");   // joints to the end effector, where the driver has six
    parts = ToolParts();
    parts.meshes = list("elbow:x.ply");
    EXPECT_ERROR(tool(parts), "no link 'elbow'");
    parts.meshes = list("roll");
    EXPECT_ERROR(tool(parts), "meshes: 'roll'");
    parts.meshes.clear();
    parts.meshScale = 0;
    EXPECT_ERROR(tool(parts), "meshScale");
}

TEST_F(SurgTrack_ImportDvrk, filesThatAreMissingOrExchangedAreRefused)
{
    tool();
    EXPECT_ERROR(importDvrkTool(list(put("DRIVER_1.json", INSTRUMENT), put("PSM.json", ARM))), "expected the arm's file");
    EXPECT_ERROR(importDvrkTool(list(path("DRIVER_1.json"))), "expected the arm's file (PSM.json)");
    const String bare = replaced(replaced(INSTRUMENT, "\"jaw\"", "\"other\""), "\"tooltip_offset\"", "\"another\"");
    EXPECT_ERROR(importDvrkTool(list(put("bare.json", bare), path("PSM.json"))), "expected the arm's file");
}

TEST_F(SurgTrack_ImportDvrk, passiveJointsDoNotMove)
{
    const String arm = replaced(ARM, "\"mode\": \"active\"", "\"mode\": \"passive\"");
    const Ptr<ToolModel> model = orSkip([&]() { return importDvrkTool(list(put("PSM.json", arm), put("DRIVER_1.json", INSTRUMENT))); });
    ASSERT_EQ(3u, model->coordinateNames().size());
    EXPECT_EQ("q1", model->coordinateNames()[0]);
    std::vector<double> moving = { 0.1, 0.2, 0.3 }, all = { 0, 0.1, 0.2, 0.3 };
    EXPECT_LT(cv::norm(model->endEffectorPose(moving) - tool()->endEffectorPose(all)), 1e-14);   // rounding
}

// ---- URDF

String number(double value) { return format("%.17g", value); }

Matx33d fromRollPitchYaw(const Vec3d& rpy)
{
    return rotationMatrix(Vec3d(0, 0, rpy[2])) * rotationMatrix(Vec3d(0, rpy[1], 0)) * rotationMatrix(Vec3d(rpy[0], 0, 0));
}

struct Joint
{
    String type, mimic;
    Vec3d xyz, rpy, axis;
};

// Joint i goes from link i (link 0 is `root`) to link i + 1.
String urdf(const std::vector<Joint>& joints)
{
    String text = "<?xml version=\"1.0\"?>\n<robot name=\"crane\">\n<link name=\"l0\"/>\n";
    for (size_t i = 0; i < joints.size(); i++)
    {
        const Joint& j = joints[i];
        const Vec3d triples[] = { j.xyz, j.rpy, j.axis };
        String numbers[3];
        for (int k = 0; k < 9; k++)
            numbers[k / 3] += (k % 3 ? " " : "") + number(triples[k / 3][k % 3]);
        text += format("<link name=\"l%d\"/>\n<joint name=\"j%d\" type=\"%s\"><parent link=\"l%d\"/><child link=\"l%d\"/><origin xyz=\"%s\" "
                       "rpy=\"%s\"/><axis xyz=\"%s\"/>%s<limit lower=\"-3\" upper=\"3\" effort=\"1\" velocity=\"1\"/></joint>\n",
                       (int)i + 1, (int)i, j.type.c_str(), (int)i, (int)i + 1, numbers[0].c_str(), numbers[1].c_str(), numbers[2].c_str(),
                       j.mimic.c_str());
    }
    return text + "</robot>\n";
}

class SurgTrack_ImportUrdf : public ImportTest
{
protected:
    Ptr<ToolModel> load(const String& text, const ToolParts& parts = ToolParts()) const
    {
        const String filename = put("tool.urdf", text);
        return orSkip([&]() { return importUrdfTool(filename, parts); });
    }

    void expectError(const String& text, const char* what) const
    {
        load(urdf(std::vector<Joint>(1, crane()[0])));
        EXPECT_ERROR(importUrdfTool(put("bad.urdf", text)), "bad.urdf");
        EXPECT_ERROR(importUrdfTool(put("bad.urdf", text)), what);
    }

    static std::vector<Joint> crane()
    {
        std::vector<Joint> joints(2);
        joints[0].type = "revolute";
        joints[0].axis = Vec3d(0, 0, 1);
        joints[1].type = "prismatic";
        joints[1].xyz = Vec3d(0.1, 0.2, 0.3);
        joints[1].axis = Vec3d(1, 0, 0);
        return joints;
    }

    // The largest difference of any link's pose from the URDF's own definition.
    double worstError(const std::vector<Joint>& joints) const
    {
        const Ptr<ToolModel> model = load(urdf(joints));
        RNG rng(5);
        double worst = 0;
        for (int i = 0; i < 100; i++)
        {
            const std::vector<double> q = randomJoints(*model, rng);
            std::vector<Matx44d> links;
            model->forwardKinematics(q, links);
            Matx44d T = Matx44d::eye();
            for (size_t k = 0; k < joints.size(); k++)
            {
                const Joint& j = joints[k];
                T = T * rigid(fromRollPitchYaw(j.rpy), Point3d(j.xyz));
                if (j.type != "fixed")
                {
                    const Vec3d axis = j.axis * (q[model->coordinateIndex(format("j%d", (int)k))] / cv::norm(j.axis));
                    T = T * (j.type == "prismatic" ? rigid(Matx33d::eye(), Point3d(axis)) : rigid(rotationMatrix(axis), Point3d()));
                }
                worst = std::max(worst, cv::norm(T - links[linkIndex(*model, format("l%d", (int)k + 1))], NORM_INF));
            }
        }
        return worst;
    }
};

TEST_F(SurgTrack_ImportUrdf, linksAreWhereTheUrdfHasThem)
{
    RNG rng(3);
    const char* const types[] = { "revolute", "prismatic", "continuous", "fixed" };
    for (int trial = 0; trial < 10; trial++)
    {
        std::vector<Joint> joints(6);
        for (size_t i = 0; i < joints.size(); i++)
        {
            joints[i].type = types[rng.uniform(0, 4)];
            joints[i].xyz = randomDirection(rng) * 0.2;
            joints[i].rpy = Vec3d(rng.uniform(-3., 3.), rng.uniform(-1.5, 1.5), rng.uniform(-3., 3.));
            joints[i].axis = randomDirection(rng) * 2;   // urdfdom leaves the length to us
        }
        joints.back().type = "revolute";
        EXPECT_LT(worstError(joints), 1e-12) << "trial " << trial;   // rounding
    }
}

TEST_F(SurgTrack_ImportUrdf, almostParallelAxesLoseNoDigits)
{
    const double angles[] = { 0, 1e-13, 1e-9, 1e-6, 1e-4, 0.99e-3, 1.01e-3, CV_PI - 1e-4, CV_PI - 1e-8, CV_PI };
    for (int i = 0; i < 10; i++)
    {
        std::vector<Joint> joints(3);
        for (int k = 0; k < 3; k++)
        {
            joints[k].type = k == 1 ? "prismatic" : "revolute";
            joints[k].axis = Vec3d(0, 0, k == 2 ? -1 : 1);
            joints[k].xyz = Vec3d(0.1, -0.2, 0.3);
            joints[k].rpy = Vec3d(angles[i] * 0.8, angles[i] < 1 ? angles[i] * 0.6 : 0, 0.4);
        }
        EXPECT_LT(worstError(joints), 2e-12) << angles[i];   // rounding, a thousandfold where the common normal is a thousand times as far
    }
}

TEST_F(SurgTrack_ImportUrdf, theLargeNeedleDriverIsThatOfTheToolFile)
{
    const String filename = recorded("tools/large_needle_driver/large_needle_driver.urdf");
    ToolParts parts;
    parts.like = recorded("tools/large_needle_driver/large_needle_driver_lowres.yaml");
    const Ptr<ToolModel> expected = ToolModel::load(parts.like);
    const Ptr<ToolModel> model = orSkip([&]() { return importUrdfTool(filename, parts); });
    ASSERT_EQ(expected->coordinateNames(), model->coordinateNames());
    RNG rng(7);
    double worst = 0;
    for (int i = 0; i < 100; i++)
    {
        const std::vector<double> joints = randomJoints(*model, rng);
        std::vector<Matx44d> a, b;
        model->forwardKinematics(joints, a);
        expected->forwardKinematics(joints, b);
        for (size_t k = 0; k < b.size(); k++)
            worst = std::max(worst, cv::norm(b[k] - a[linkIndex(*model, expected->linkNames()[k])], NORM_INF));
        worst = std::max(worst, cv::norm(model->endEffectorPose(joints) - expected->endEffectorPose(joints), NORM_INF));
    }
    EXPECT_LT(worst, 1e-12);   // rounding: the nine digits of its angles stand for quarter turns
    EXPECT_EQ(expected->keypointNames(), model->keypointNames());
    EXPECT_EQ(4u, model->meshes().size());
}

TEST_F(SurgTrack_ImportUrdf, jointsThatMimicShareACoordinate)
{
    std::vector<Joint> joints = crane();
    joints.push_back(joints[0]);
    joints.push_back(joints[0]);
    joints[2].axis = Vec3d(0, 0, -1);
    joints[2].mimic = "<mimic joint=\"j0\" multiplier=\"0.5\" offset=\"0.1\"/>";
    joints[3].axis = Vec3d(0, 1, 0);
    joints[3].mimic = "<mimic joint=\"j2\" multiplier=\"-2\" offset=\"0.3\"/>";
    const Ptr<ToolModel> model = load(urdf(joints));
    EXPECT_EQ(list("j0", "j1"), model->coordinateNames());
    const double q[] = { 0.7, 0.05 };
    const Matx44d expected = rigid(rotationMatrix(Vec3d(0, 0, 0.7)), Point3d()) * rigid(Matx33d::eye(), Point3d(0.15, 0.2, 0.3))
                             * rigid(rotationMatrix(Vec3d(0, 0, -(0.5 * 0.7 + 0.1))), Point3d())
                             * rigid(rotationMatrix(Vec3d(0, -2 * (0.5 * 0.7 + 0.1) + 0.3, 0)), Point3d());
    EXPECT_LT(cv::norm(model->endEffectorPose(Mat(1, 2, CV_64F, (void*)q)) - expected), 1e-14);   // rounding
}

TEST_F(SurgTrack_ImportUrdf, meshesAreScaledMirroredAndPlaced)
{
    put("peak.obj", TETRAHEDRON);
    const String visual = "<link name=\"l2\"><visual><origin xyz=\"0.1 0 0\" rpy=\"0 0 1.570796\"/><geometry><mesh filename=\"peak.obj\" "
                          "scale=\"0.1 -0.2 0.3\"/></geometry></visual></link>";
    const Ptr<ToolModel> model = load(replaced(urdf(crane()), "<link name=\"l2\"/>", visual));
    ASSERT_EQ(1u, model->meshes().size());
    EXPECT_EQ(0, model->links().back().mesh);
    const Mesh& mesh = model->meshes()[0];
    const Point3d corners[] = { Point3d(0.1, 0, 0), Point3d(0.1, 0.2, 0), Point3d(0.5, 0, 0), Point3d(0.1, 0, 1.2) };
    const Point3d middle(0.2, 0.05, 0.3);
    for (size_t i = 0; i < mesh.vertices.size(); i++)
    {
        double nearest = DBL_MAX;
        for (int k = 0; k < 4; k++)
            nearest = std::min(nearest, cv::norm(Point3d(mesh.vertices[i]) - corners[k]));
        EXPECT_LT(nearest, 1e-6);   // single precision
        EXPECT_GT((Point3d(mesh.vertices[i]) - middle).dot(Point3d(mesh.normals[i])), 0) << "normals show outward";
    }
    for (size_t i = 0; i < mesh.triangles.size(); i++)
    {
        const Point3f a = mesh.vertices[mesh.triangles[i][0]], b = mesh.vertices[mesh.triangles[i][1]], c = mesh.vertices[mesh.triangles[i][2]];
        EXPECT_GT((b - a).cross(c - a).dot(mesh.normals[mesh.triangles[i][0]]), 0) << "triangles turn as their normals say";
    }
}

TEST_F(SurgTrack_ImportUrdf, keypointsAreInTheAxesOfTheMeshFile)
{
    put("peak.obj", TETRAHEDRON);
    const String visual = "<link name=\"l2\"><visual><origin xyz=\"0.1 0 0\" rpy=\"0 0 1.570796\"/><geometry><mesh filename=\"peak.obj\" "
                          "scale=\"0.1 -0.2 0.3\"/></geometry></visual></link>";
    const String text = replaced(urdf(crane()), "<link name=\"l2\"/>", visual);
    ToolParts parts;
    parts.keypoints = put("points.csv", "name,link,x,y,z\npeak,l2,0,0,4\nside,l2,0,2,0\n");
    const Ptr<ToolModel> model = load(text, parts);
    ASSERT_EQ(2u, model->keypoints().size());
    EXPECT_LT(cv::norm(model->keypoints()[0].linkPoint - Point3d(0.1, 0, 1.2)), 1e-9);   // rounding
    EXPECT_LT(cv::norm(model->keypoints()[1].linkPoint - Point3d(0.5, 0, 0)), 1e-9);
    parts.keypoints = put("off.csv", "name,link,x,y,z\npeak,l2,0,0,4.01\n");   // 3 mm after the scale
    EXPECT_ERROR(importUrdfTool(path("tool.urdf"), parts), "keypoint `peak` is 3 mm off the surface of link `l2`");
    parts.keypoints = "auto:x";
    EXPECT_ERROR(importUrdfTool(path("tool.urdf"), parts), "auto:N");
}

TEST_F(SurgTrack_ImportUrdf, limitsOfJointsAreKept)
{
    std::vector<Joint> joints = crane();
    joints[1].mimic = "";
    const Mat_<double> limits = load(replaced(urdf(joints), "lower=\"-3\" upper=\"3\"", "lower=\"-0.5\" upper=\"0.7\""))->jointLimits();
    EXPECT_EQ(-0.5, limits(0, 0));
    EXPECT_EQ(0.7, limits(0, 1));
    EXPECT_EQ(3, limits(1, 1));
    joints[0].type = "continuous";
    EXPECT_EQ(DBL_MAX, Mat_<double>(load(urdf(joints))->jointLimits())(0, 1)) << "turns on and on";
}

TEST_F(SurgTrack_ImportUrdf, theEndEffectorNeedNotBeNamed)
{
    const String tip = "<link name=\"%s\"/><joint name=\"%s_joint\" type=\"fixed\"><parent link=\"l1\"/><child link=\"%s\"/></joint></robot>";
    const String still = replaced(urdf(crane()), "</robot>", format(tip.c_str(), "peak", "peak", "peak"));
    EXPECT_EQ("peak", load(still)->linkNames()[load(still)->endEffectorLink()]) << "the only end that no joint moves";
    const String two = replaced(still, "</robot>", format(tip.c_str(), "tool_tip_link", "tool_tip_link", "tool_tip_link"));
    EXPECT_EQ("tool_tip_link", load(two)->linkNames()[load(two)->endEffectorLink()]);
}

TEST_F(SurgTrack_ImportUrdf, packagesAreLookedForInAGivenFolder)
{
    ASSERT_TRUE(cv::utils::fs::createDirectories(path("packages/cranes/meshes")));
    put("packages/cranes/meshes/peak.obj", TETRAHEDRON);
    const String text = replaced(urdf(crane()), "<link name=\"l2\"/>",
        "<link name=\"l2\"><visual><geometry><mesh filename=\"package://cranes/meshes/peak.obj\"/></geometry></visual></link>");
    EXPECT_ERROR(load(text), "expected the folder of the package");
    put("packages/cranes/tool.urdf", text);
    EXPECT_EQ(1u, importUrdfTool(path("packages/cranes/tool.urdf"))->meshes().size()) << "in the folder above the URDF's";
    ToolParts parts;
    parts.packages = path("packages");
    EXPECT_EQ(1u, load(text, parts)->meshes().size());
    parts.packages = path("packages/cranes");   // the package itself
    EXPECT_EQ(1u, load(text, parts)->meshes().size());
    parts.packages = path("elsewhere");
    EXPECT_ERROR(load(text, parts), "elsewhere/cranes/meshes/peak.obj");
    EXPECT_EQ(1u, load(replaced(text, "package://cranes", "file://" + path("packages/cranes")))->meshes().size());
}

TEST_F(SurgTrack_ImportUrdf, aPointerOfGitLfsIsRecognised)
{
    put("peak.stl", "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a214614ab2935c943f9e0ff69d22eadbb8f32b1258daaa5e2ca24d17e2393\n"
                    "size 12345\n");
    const String text = replaced(urdf(crane()), "<link name=\"l2\"/>",
        "<link name=\"l2\"><visual><geometry><mesh filename=\"peak.stl\"/></geometry></visual></link>");
    EXPECT_ERROR(load(text), "git-LFS");
    EXPECT_ERROR(load(text), "peak.stl");
}

TEST_F(SurgTrack_ImportUrdf, baseAndEndEffectorCanBeChosen)
{
    ToolParts parts;
    parts.base = "l1";
    const Ptr<ToolModel> model = load(urdf(crane()), parts);
    EXPECT_EQ(list("j1"), model->coordinateNames());
    parts = ToolParts();
    parts.endEffector = "l1";
    EXPECT_EQ("l1", load(urdf(crane()), parts)->linkNames()[load(urdf(crane()), parts)->endEffectorLink()]);
    parts.endEffector = "l9";
    EXPECT_ERROR(load(urdf(crane()), parts), "'l9'");
    parts.base = "l8";
    EXPECT_ERROR(load(urdf(crane()), parts), "`l8`");
    parts.base = "l2";
    EXPECT_ERROR(load(urdf(crane()), parts), "nothing hangs on");
}

TEST_F(SurgTrack_ImportUrdf, coordinatesComeOnTheWayToTheEndEffectorFirst)
{
    const String joints = "<link name=\"a\"/><link name=\"b\"/><link name=\"c\"/><link name=\"d\"/>"
        "<!-- <joint name=\"elbow\"/> -->"
        "<joint type=\"continuous\" name=\"side\"><parent link=\"a\"/><child link=\"d\"/><axis xyz=\"0 0 1\"/></joint>"
        "<joint name=\"zenith\" type=\"continuous\"><parent link=\"a\"/><child link=\"b\"/><axis xyz=\"0 0 1\"/></joint>"
        "<joint name=\"elbow\" type=\"continuous\"><parent link=\"b\"/><child link=\"c\"/><axis xyz=\"0 0 1\"/></joint></robot>";
    ToolParts parts;
    parts.endEffector = "c";
    const std::vector<String> names = load("<robot name=\"r\">" + joints, parts)->coordinateNames();
    ASSERT_EQ(3u, names.size());
    EXPECT_EQ("zenith", names[0]);
    EXPECT_EQ("elbow", names[1]);
    EXPECT_EQ("side", names[2]);
}

TEST_F(SurgTrack_ImportUrdf, shapesBecomeMeshes)
{
    const struct { const char* geometry; double volume; } shapes[] = {
        { "<cylinder radius=\"0.1\" length=\"0.5\"/>", CV_PI * 0.01 * 0.5 },
        { "<sphere radius=\"0.1\"/>", CV_PI * 0.001 * 4 / 3 },
        { "<box size=\"0.1 0.2 0.3\"/>", 0.006 } };
    for (int i = 0; i < 3; i++)
    {
        const String visual = String("<link name=\"l2\"><visual><origin xyz=\"0.3 0 0\"/><geometry>") + shapes[i].geometry + "</geometry></visual></link>";
        const Ptr<ToolModel> model = load(replaced(urdf(crane()), "<link name=\"l2\"/>", visual));
        ASSERT_EQ(1u, model->meshes().size());
        const Mesh& mesh = model->meshes()[0];
        double volume = 0;
        for (size_t k = 0; k < mesh.triangles.size(); k++)
        {
            const Vec3d a(Point3d(mesh.vertices[mesh.triangles[k][0]])), b(Point3d(mesh.vertices[mesh.triangles[k][1]]));
            volume += a.dot(b.cross(Vec3d(Point3d(mesh.vertices[mesh.triangles[k][2]])))) / 6;
        }
        EXPECT_NEAR(shapes[i].volume, volume, 0.01 * shapes[i].volume) << shapes[i].geometry;   // 48 sides
    }
}

TEST_F(SurgTrack_ImportUrdf, meshesThatAreReplacedAreNotRead)
{
    put("peak.obj", TETRAHEDRON);
    const String visual = "<link name=\"l2\"><visual><geometry><mesh filename=\"cover.dae\"/></geometry></visual></link>";
    const String text = replaced(urdf(crane()), "<link name=\"l2\"/>", visual);
    ToolParts parts;
    EXPECT_ERROR(load(text, parts), "cover.dae");
    parts.meshes = list("l2:" + path("peak.obj"));
    EXPECT_EQ(1u, load(text, parts)->meshes().size());
    parts.meshes = list("l2:none");
    EXPECT_EQ(0u, load(text, parts)->meshes().size());
}

TEST_F(SurgTrack_ImportUrdf, refusesWhatItCannotTake)
{
    const String text = urdf(crane());
    expectError(replaced(text, "type=\"prismatic\"", "type=\"floating\""), "joint `j1`");
    expectError(replaced(text, "<parent link=\"l1\"/>", "<parent link=\"l7\"/>"), "l7");
    expectError(replaced(text, "<axis xyz=\"1 0 0\"/>", "<axis xyz=\"0 0 0\"/>"), "axis");
    expectError(replaced(text, "<axis xyz=\"1 0 0\"/>", "<axis xyz=\"1 0 0\"/><mimic joint=\"j8\"/>"), "mimic");
    expectError(replaced(text, "</robot>", ""), "URDF");
    expectError("<xacro/>", "URDF");
    expectError(replaced(text, "<link name=\"l2\"/>", "<link name=\"l2\"/><xacro:tool/>"), "xacro FILE.xacro > FILE.urdf");
    expectError(replaced(text, "<link name=\"l2\"/>", "<link name=\"l2\"/><link name=\"l3\"/><joint name=\"j2\" type=\"fixed\">"
                         "<parent link=\"l0\"/><child link=\"l3\"/></joint><link name=\"l4\"/><joint name=\"j3\" type=\"fixed\">"
                         "<parent link=\"l2\"/><child link=\"l4\"/></joint>"), "l4, l3; expected the end effector");
    EXPECT_ERROR(importUrdfTool(path("none.urdf")), "none.urdf");
}

}} // namespace
