// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_common.hpp"

#include <cstdio>
#include <fstream>
#include <map>
#include <sstream>

#include "opencv2/core/utils/filesystem.hpp"

namespace opencv_test { namespace {

using namespace cv::surgtrack;

// A two-link tool; the children come first, as a file may have it.
const char* const TOOL =
    "%YAML:1.0\n---\n"
    "name: \"crane\"\n"
    "coordinates: [ \"turn\", \"lift\" ]\n"
    "mesh_scale: 0.5\n"
    "links:\n"
    "   - { name: \"hook\", parent: \"arm\", joint: { type: \"fixed\" }, mdh: { alpha: 0.1, a: 0.2, theta: 0.3, d: 0.4 } }\n"
    "   - { name: \"arm\", parent: \"tower\", joint: { type: \"prismatic\", coordinate: \"lift\", scale: 2 },"
    " mdh: { alpha: 0, a: 1, theta: 0, d: 0 } }\n"
    "   -\n"
    "      name: \"tower\"\n"
    "      parent: \"base\"\n"
    "      joint: { type: \"revolute\", coordinate: \"turn\", scale: 1 }\n"
    "      mdh: { alpha: 0, a: 0, theta: 0, d: 0 }\n"
    "      mesh: \"tower.obj\"\n"
    "      link_T_mesh: !!opencv-matrix\n"
    "         rows: 4\n"
    "         cols: 4\n"
    "         dt: d\n"
    "         data: [ 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 5, 0, 0, 0, 1 ]\n"
    "end_effector:\n"
    "   link: \"hook\"\n"
    "   link_T_end_effector: !!opencv-matrix\n"
    "      rows: 4\n"
    "      cols: 4\n"
    "      dt: d\n"
    "      data: [ 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0.25, 0, 0, 0, 1 ]\n"
    "keypoints:\n"
    "   - { name: \"top\", link: \"tower\", position: [ 1, 2, 3 ] }\n"
    "   - { name: \"end\", link: \"hook\", position: [ 0, 0, 0.5 ] }\n";

const char* const TETRAHEDRON = "v 0 0 0\nv 2 0 0\nv 0 2 0\nv 0 0 2\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";

String writeTool(const TempFolder& folder, const std::string& content, const char* name = "tool.yaml")
{
    std::ofstream((folder / "tower.obj").c_str()) << TETRAHEDRON;
    std::ofstream((folder / name).c_str(), std::ios::binary) << content;
    return folder / name;
}

std::string replaced(std::string text, const std::string& what, const std::string& by)
{
    const size_t at = text.find(what);
    CV_Assert(at != std::string::npos);
    return text.replace(at, what.size(), by);
}

// The error of load(), which must name the file; "" if there is none.
String errorOf(const String& filename, int code = Error::StsParseError)
{
    try
    {
        ToolModel::load(filename);
    }
    catch (const cv::Exception& e)
    {
        EXPECT_EQ(code, e.code) << e.what();
        EXPECT_NE(String::npos, e.err.find(filename)) << "the file is not named: " << e.err;
        return e.err;
    }
    return String();
}

std::vector<double> randomJoints(const ToolModel& tool, RNG& rng)
{
    std::vector<double> q;
    for (size_t i = 0; i < tool.coordinateNames().size(); ++i)
        q.push_back(rng.uniform(-1.2, 1.2));
    return q;
}

void expectEqualKinematics(const ToolModel& a, const ToolModel& b)
{
    RNG rng(3);
    for (int i = 0; i < 20; ++i)
    {
        const std::vector<double> q = randomJoints(a, rng);
        EXPECT_LT(cv::norm(a.endEffectorPose(q) - b.endEffectorPose(q)), 1e-12);   // 17 digits are written
        Mat pa, pb;
        a.keypointPositions(q, pa);
        b.keypointPositions(q, pb);
        EXPECT_LT(cvtest::norm(pa, pb, NORM_INF), 1e-12);
    }
}

TEST(SurgTrack_ToolModel, readsLinksInAnyOrder)
{
    const TempFolder folder;
    const Ptr<ToolModel> tool = ToolModel::load(writeTool(folder, TOOL));
    EXPECT_EQ("crane", tool->name());
    EXPECT_EQ((std::vector<String>{ "turn", "lift" }), tool->coordinateNames());
    EXPECT_EQ((std::vector<String>{ "tower", "arm", "hook" }), tool->linkNames());
    EXPECT_EQ((std::vector<String>{ "top", "end" }), tool->keypointNames());
    EXPECT_EQ(1, tool->coordinateIndex("lift"));
    EXPECT_EQ(-1, tool->coordinateIndex("push"));
    EXPECT_EQ(1, tool->links()[2].parent);
    EXPECT_EQ(0, tool->links()[0].mesh);

    // By hand: the tower turns by 90 degrees, the arm is 1 m out and, by its scale of 2, 0.6 m up.
    std::vector<Matx44d> base_T_link;
    tool->forwardKinematics(std::vector<double>{ CV_PI / 2, 0.3 }, base_T_link);
    const Matx44d arm(0, -1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0.6, 0, 0, 0, 1);
    EXPECT_LT(cv::norm(base_T_link[1] - arm), 1e-15);   // rounding
    const Mat poses = tool->linkPoses(std::vector<double>{ CV_PI / 2, 0.3 });
    ASSERT_EQ(3, poses.dims);
    EXPECT_EQ((std::vector<int>{ 3, 4, 4 }), std::vector<int>(poses.size.p, poses.size.p + 3));
    for (int i = 0; i < 3; ++i)
        EXPECT_EQ(0, cv::norm(Matx44d(poses.ptr<double>(i)), base_T_link[i])) << "the same numbers";
    EXPECT_LT(cv::norm(tool->endEffectorPose(std::vector<float>{ 0.5f, 0.25f }) - tool->endEffectorPose(Matx12d(0.5, 0.25))), 1e-15);

    Mat vertices, triangles;
    tool->getMesh(0, vertices, triangles);
    EXPECT_EQ(CV_32FC1, vertices.type());
    EXPECT_EQ(Size(3, 12), vertices.size());
    EXPECT_EQ(CV_32SC1, triangles.type());
    EXPECT_EQ(Size(3, 4), triangles.size());
    double low, high;
    minMaxLoc(vertices.col(2), &low, &high);
    EXPECT_EQ(5, low);    // link_T_mesh
    EXPECT_EQ(6, high);   // mesh_scale 0.5 of 2
    EXPECT_THROW(tool->getMesh(1, vertices, triangles), cv::Exception);
    EXPECT_THROW(tool->getMesh(-1, vertices, triangles), cv::Exception);
    EXPECT_EQ(0, tool->linkMesh(0));
    EXPECT_EQ(-1, tool->linkMesh(1));
    EXPECT_THROW(tool->linkMesh(3), cv::Exception);
    EXPECT_THROW(tool->linkMesh(-1), cv::Exception);
}

TEST(SurgTrack_ToolModel, theWristsOffsetsAreUnknownUnlessTheFileSaysOtherwise)
{
    const TempFolder folder;
    // What turns beyond the joint that slides: q4, q5, q6 and the jaw.
    EXPECT_EQ((std::vector<double>{ 0, 0, 0, 0.03, 0.03, 0.03, 0.03 }), ToolModel::needleDriver()->offsetDeviations());
    EXPECT_EQ((std::vector<double>{ 0, 0 }), ToolModel::load(writeTool(folder, TOOL))->offsetDeviations());

    const std::string stated = replaced(replaced(TOOL, "scale: 2", "scale: 2, offset_deviation: 0.002"), "scale: 1 ", "scale: 1, offset_deviation: 0.01 ");
    EXPECT_EQ((std::vector<double>{ 0.01, 0.002 }), ToolModel::load(writeTool(folder, stated))->offsetDeviations());

    // In a description: one of the two joints on a coordinate is enough; 0 takes an offset away; all outlive a file.
    const Ptr<ToolModel> driver = ToolModel::needleDriver();
    ToolModel::Description d;
    d.name = driver->name();
    d.coordinates = driver->coordinateNames();
    d.links = driver->links();
    d.meshes = driver->meshes();
    d.keypoints = driver->keypoints();
    d.endEffectorLink = driver->endEffectorLink();
    const int jaw = driver->coordinateIndex("jaw"), roll = driver->coordinateIndex("q4");
    int jaws = 0;
    for (size_t i = 0; i < d.links.size(); ++i)
    {
        if (d.links[i].coordinate == jaw && jaws++ == 0)
            d.links[i].offsetDeviation = 0.05;
        if (d.links[i].coordinate == roll)
            d.links[i].offsetDeviation = 0;
    }
    ASSERT_EQ(2, jaws);
    const std::vector<double> expected = { 0, 0, 0, 0, 0.03, 0.03, 0.05 };
    const Ptr<ToolModel> tool = ToolModel::create(d);
    EXPECT_EQ(expected, tool->offsetDeviations());
    const char* const names[] = { "a.yaml", "b.xml", "c.json" };
    for (int i = 0; i < 3; ++i)
    {
        tool->save(folder / names[i]);
        EXPECT_EQ(expected, ToolModel::load(folder / names[i])->offsetDeviations()) << names[i];
    }
}

TEST(SurgTrack_ToolModel, everyErrorNamesFileAndKey)
{
    const struct { const char *what, *by, *key; } cases[] = {
        { "name: \"crane\"\n", "", "name: missing" },
        { "name: \"crane\"", "name: 12", "name: expected a string" },
        { "name: \"crane\"", "nam: \"crane\"", "nam: unknown key" },
        { "name: \"crane\"", "name: \"crane\"\nname: \"cranf\"", "name: expected once" },
        { "coordinates: [ \"turn\", \"lift\" ]", "coordinates: [ \"turn\", \"turn\" ]", "coordinates[1]: expected a name of its own" },
        { "coordinates: [ \"turn\", \"lift\" ]", "coordinates: \"turn\"", "coordinates: expected a sequence" },
        { "mesh_scale: 0.5", "mesh_scale: 0", "mesh_scale: expected a positive" },
        { "mesh_scale: 0.5", "mesh_scal: 0.5", "mesh_scal: unknown key" },
        { "mesh_scale: 0.5", "mesh_scale: \"0.5\"", "mesh_scale: expected a finite number" },
        { "parent: \"arm\", ", "", "links[0].parent: missing" },
        { "parent: \"arm\"", "parent: \"arn\"", "links[0].parent: expected the name of a link or `base`, found `arn`" },
        { "parent: \"tower\"", "parent: \"hook\"", "links[0].parent: expected a tree" },
        { "parent: \"base\"", "parent: \"tower\"", "links[0].parent: expected a tree" },
        { "name: \"hook\"", "name: \"arm\"", "links[1].name: expected a name of its own" },
        { "name: \"hook\"", "name: \"base\"", "links[0].name: expected another name" },
        { "joint: { type: \"fixed\" }, ", "", "links[0].joint: missing" },
        { "type: \"prismatic\"", "type: \"prismatik\"", "links[1].joint.type: expected revolute, prismatic or fixed" },
        { "type: \"fixed\"", "type: \"fixed\", coordinate: \"lift\"", "links[0].joint.coordinate: unknown key" },
        { "coordinate: \"lift\"", "coordinate: \"push\"", "links[1].joint.coordinate: expected the name of a coordinate" },
        { "coordinate: \"lift\", ", "", "links[1].joint.coordinate: missing" },
        { "scale: 2", "scal: 2", "links[1].joint.scal: unknown key" },
        { "scale: 2", "scale: .Nan", "links[1].joint.scale: expected a finite number" },
        { "scale: 2", "scale: 2, offset_deviation: -0.1", "links[1].joint.offset_deviation: expected a number of at least 0" },
        { "scale: 2", "scale: 2, offset_deviation: .Nan", "links[1].joint.offset_deviation: expected a finite number" },
        { "scale: 2", "scale: 2, offset_deviation: \"wide\"", "links[1].joint.offset_deviation: expected a finite number" },
        { "type: \"fixed\"", "type: \"fixed\", offset_deviation: 0", "links[0].joint.offset_deviation: unknown key" },
        { "scale: 1 ", "scale: 1, play_deviation: -0.1 ", "joint.play_deviation: expected a number of at least 0" },
        { "scale: 2", "scale: 2, gain_deviation: 0.1", "links[1].joint.gain_deviation: expected none, as the joint does not turn" },
        { "alpha: 0.1, ", "", "links[0].mdh.alpha: missing" },
        { "alpha: 0.1", "alpha: .Inf", "links[0].mdh.alpha: expected a finite number" },
        { "d: 0.4", "d: 0.4, e: 1", "links[0].mdh.e: unknown key" },
        { "mdh: { alpha: 0, a: 1, theta: 0, d: 0 }", "mdh: 1", "links[1].mdh: expected a map" },
        { "mesh: \"tower.obj\"", "mesh: \"towel.obj\"", "links[2].mesh: " },
        { "      mesh: \"tower.obj\"\n", "", "links[2].mesh: missing" },
        { "mesh: \"tower.obj\"", "mash: \"tower.obj\"", "links[2].mash: unknown key" },
        { "         rows: 4\n         cols: 4", "         rows: 8\n         cols: 2", "links[2].link_T_mesh: expected a 4x4 opencv-matrix, found 8x2" },
        { "0, 0, 1, 5, 0,", "0, 0, 2, 5, 0,", "links[2].link_T_mesh: expected a rigid transform" },
        { "0, 0, 1, 5, 0,", "0, 0, -1, 5, 0,", "links[2].link_T_mesh: expected a rigid transform" },
        { "0, 0, 1, 5, 0,", "0, 0, 1, 5, 1,", "links[2].link_T_mesh: expected a rigid transform" },
        { "0, 0, 1, 5, 0,", "0, 0, 1, .Nan, 0,", "links[2].link_T_mesh: expected a rigid transform" },
        { "0, 0, 1, 5, 0,", "0, 0, 1, 5,", "links[2].link_T_mesh: expected a 4x4 matrix" },
        { "   link: \"hook\"", "   link: \"hock\"", "end_effector.link: expected the name of a link" },
        { "   link: \"hook\"\n", "", "end_effector.link: missing" },
        { "[ 0, -1, 0, 0, 1,", "[ 0, -1, 0, 0, 1.01,", "end_effector.link_T_end_effector: expected a rigid transform" },
        { "link: \"tower\", position", "link: \"towel\", position", "keypoints[0].link: expected the name of a link" },
        { "name: \"top\"", "name: \"end\"", "keypoints[1].name: expected a name of its own" },
        { "[ 1, 2, 3 ]", "[ 1, 2 ]", "keypoints[0].position: expected three numbers" },
        { "[ 1, 2, 3 ]", "[ 1, 2, .Nan ]", "keypoints[0].position[2]: expected a finite number" },
        { ", position: [ 1, 2, 3 ]", "", "keypoints[0].position: missing" } };
    const TempFolder folder;
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i)
    {
        const bool missingMesh = String(cases[i].by).find("towel.obj") != String::npos;
        const String error = errorOf(writeTool(folder, replaced(TOOL, cases[i].what, cases[i].by)),
                                     missingMesh ? Error::StsObjectNotFound : Error::StsParseError);
        EXPECT_NE(String::npos, error.find(cases[i].key)) << "case " << i << ": expected `" << cases[i].key << "`, got `" << error << "`";
    }
}

TEST(SurgTrack_ToolModel, brokenMeshIsReportedWithToolFileAndKey)
{
    const TempFolder folder;
    const String filename = writeTool(folder, TOOL);
    const char* const meshes[] = { "", "v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n", "v 0 0 0\nv 1 0 0\nf 1 2 3\n", "v 0 0 0\nv 1 0 0\nv 0 1 0\n" };
    for (int i = 0; i < 4; ++i)
    {
        std::ofstream((folder / "tower.obj").c_str()) << meshes[i];
        const String error = errorOf(filename);
        EXPECT_NE(String::npos, error.find("links[2].mesh: ")) << error;
        EXPECT_NE(String::npos, error.find("tower.obj: ")) << error;
    }
}

TEST(SurgTrack_ToolModel, filesOfOtherKindsAreReported)
{
    const TempFolder folder;
    const std::string tool = TOOL;
    const std::string contents[] = { "", "hello\n", "%YAML:1.0\n---\n", "{}", "{ \"name\": 1", "<?xml version=\"1.0\"?>\n<robot/>\n",
                                     "/* a comment */ { }", std::string(1000, '\0'), "%YAML:1.0\n---\nname: [ 1, 2\n", "%YAML:1.0\n---\n- 1\n- 2\n" };
    for (size_t i = 0; i < sizeof(contents) / sizeof(contents[0]); ++i)
        EXPECT_NE("", errorOf(writeTool(folder, contents[i]))) << "content " << i;
    // Cut anywhere before its last line.
    for (size_t length = 0; length < tool.find("   - { name: \"end\""); length += 11)
        EXPECT_NE("", errorOf(writeTool(folder, tool.substr(0, length)))) << "cut to " << length << " bytes";
    errorOf(folder / "absent.yaml", Error::StsObjectNotFound);
    errorOf(folder / "", Error::StsObjectNotFound);
    EXPECT_THROW(ToolModel::load("absent.yaml"), cv::Exception);
    EXPECT_THROW(ToolModel::load(writeTool(folder, TOOL), -1), cv::Exception);
}

TEST(SurgTrack_ToolModel, createRejectsInvalidDescriptions)
{
    const TempFolder folder;
    const Ptr<ToolModel> tool = ToolModel::load(writeTool(folder, TOOL));
    ToolModel::Description good;
    good.name = tool->name();
    good.coordinates = tool->coordinateNames();
    good.links = tool->links();
    good.meshes = tool->meshes();
    good.keypoints = tool->keypoints();
    good.endEffectorLink = 2;
    EXPECT_NO_THROW(ToolModel::create(good));

    const double nan = std::numeric_limits<double>::quiet_NaN();
    std::vector<ToolModel::Description> bad(20, good);
    bad[0].links[1].parent = 1;
    bad[1].links[1].parent = -2;
    bad[2].links[1].coordinate = 2;
    bad[3].links[2].coordinate = 0;
    bad[4].links[1].name = "tower";
    bad[5].links[1].d = nan;
    bad[6].links[1].mesh = 1;
    bad[7].links[1].jointType = (ToolModel::JointType)3;
    bad[8].endEffectorLink = 3;
    bad[9].link_T_endEffector(3, 3) = 2;
    bad[10].keypoints[0].link = -1;
    bad[11].keypoints[0].linkPoint.x = nan;
    bad[12].keypoints[0].name = "end";
    bad[13].coordinates[0] = "lift";
    bad[14].meshes[0].normals.pop_back();
    bad[15].meshes[0].triangles[0][0] = 12;
    bad[16].meshes[0].vertices[0].x = (float)nan;
    bad[17].links[1].offsetDeviation = nan;
    bad[18].links[2].offsetDeviation = 0;   // a fixed joint
    bad[19].links[1].coordinate = 0;        // both joints turn, and their deviations differ
    bad[19].links[1].jointType = ToolModel::JOINT_REVOLUTE;
    bad[19].links[1].offsetDeviation = 0.01;
    bad[19].links[0].offsetDeviation = 0.02;
    for (size_t i = 0; i < bad.size(); ++i)
        EXPECT_THROW(ToolModel::create(bad[i]), cv::Exception) << "case " << i;
    EXPECT_THROW(ToolModel::create(ToolModel::Description()), cv::Exception);
}

TEST(SurgTrack_ToolModel, jointsOfWrongCountTypeOrValueAreRejected)
{
    const TempFolder folder;
    const Ptr<ToolModel> tool = ToolModel::load(writeTool(folder, TOOL));
    const double nan = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(tool->endEffectorPose(std::vector<double>(1)), cv::Exception);
    EXPECT_THROW(tool->endEffectorPose(std::vector<double>(3)), cv::Exception);
    EXPECT_THROW(tool->endEffectorPose(std::vector<int>(2)), cv::Exception);
    EXPECT_THROW(tool->endEffectorPose(noArray()), cv::Exception);
    EXPECT_THROW(tool->endEffectorPose(Matx12d(0, nan)), cv::Exception);
    EXPECT_THROW(tool->endEffectorPose(Matx12d(1 / 0., 0)), cv::Exception);
    EXPECT_THROW(tool->keypointPositions(Matx12d(0, nan), noArray()), cv::Exception);
}

TEST(SurgTrack_ToolModel, jacobianEqualsCentralDifferences)
{
    const TempFolder folder;
    const Ptr<ToolModel> tools[] = { ToolModel::needleDriver(), ToolModel::load(writeTool(folder, TOOL)) };
    RNG rng(5);
    for (int i = 0; i < 20; ++i)
    {
        const ToolModel& tool = *tools[i % 2];
        const std::vector<double> q = randomJoints(tool, rng);
        Mat points, J;
        tool.keypointPositions(q, points, J);
        ASSERT_EQ(Size((int)q.size(), 3 * points.rows), J.size());
        const double h = 1e-5;
        for (size_t c = 0; c < q.size(); ++c)
        {
            std::vector<double> lower = q, upper = q;
            lower[c] -= h;
            upper[c] += h;
            Mat a, b;
            tool.keypointPositions(lower, a);
            tool.keypointPositions(upper, b);
            const Mat numeric = Mat((b - a) / (2 * h)).reshape(1, 3 * points.rows);
            // h^2 / 6 of the third derivative, at most 4 m / rad^3, and rounding of 1e-16 m / h
            EXPECT_LT(cvtest::norm(J.col((int)c), numeric, NORM_INF), 2e-10) << "coordinate " << c;
        }
    }
}

TEST(SurgTrack_ToolModel, savedToolIsReadBackEqual)
{
    const TempFolder folder;
    const Ptr<ToolModel> tools[] = { ToolModel::needleDriver(), ToolModel::load(writeTool(folder, TOOL)) };
    const char* const names[] = { "a.yaml", "b.xml", "c.json" };
    for (int i = 0; i < 6; ++i)
    {
        const ToolModel& tool = *tools[i % 2];
        const String filename = folder / names[i / 2];
        tool.save(filename);
        const Ptr<ToolModel> copy = ToolModel::load(filename, 0);
        EXPECT_EQ(tool.name(), copy->name());
        EXPECT_EQ(tool.coordinateNames(), copy->coordinateNames());
        EXPECT_EQ(tool.linkNames(), copy->linkNames());
        EXPECT_EQ(tool.keypointNames(), copy->keypointNames());
        EXPECT_EQ(tool.offsetDeviations(), copy->offsetDeviations());
        expectEqualKinematics(tool, *copy);
        ASSERT_EQ(tool.meshes().size(), copy->meshes().size());
        for (size_t m = 0; m < tool.meshes().size(); ++m)
        {
            const Mesh &a = tool.meshes()[m], &b = copy->meshes()[m];
            ASSERT_EQ(a.triangles.size(), b.triangles.size());
            double worst = 0;
            for (size_t t = 0; t < a.triangles.size(); ++t)
                for (int k = 0; k < 3; ++k)
                    worst = std::max(worst, cv::norm(a.vertices[a.triangles[t][k]] - b.vertices[b.triangles[t][k]]));
            EXPECT_EQ(0, worst) << "floats are written as they are";
        }
    }
    EXPECT_THROW(tools[0]->save(folder / "tower.obj/tool.yaml"), cv::Exception);
}

// Whether each edge is shared by two triangles that pass it in opposite senses, points of equal position being one.
bool isClosed(const Mesh& mesh)
{
    std::map<std::vector<float>, int> ids;
    std::map<std::pair<int, int>, int> passes;
    for (size_t t = 0; t < mesh.triangles.size(); ++t)
    {
        int corner[3];
        for (int k = 0; k < 3; ++k)
        {
            const Point3f p = mesh.vertices[mesh.triangles[t][k]];
            corner[k] = ids.insert(std::make_pair(std::vector<float>{ p.x, p.y, p.z }, (int)ids.size())).first->second;
        }
        for (int k = 0; k < 3; ++k)
        {
            const int a = corner[k], b = corner[(k + 1) % 3];
            passes[std::make_pair(std::min(a, b), std::max(a, b))] += a < b ? 1 : -1;
        }
    }
    for (std::map<std::pair<int, int>, int>::const_iterator it = passes.begin(); it != passes.end(); ++it)
        if (it->second != 0)
            return false;
    return true;
}

double volume(const Mesh& mesh)
{
    double sum = 0;
    for (size_t t = 0; t < mesh.triangles.size(); ++t)
    {
        const Vec3d a = Point3d(mesh.vertices[mesh.triangles[t][0]]), b = Point3d(mesh.vertices[mesh.triangles[t][1]]);
        sum += a.cross(b).dot(Vec3d(Point3d(mesh.vertices[mesh.triangles[t][2]]))) / 6;
    }
    return sum;
}

TEST(SurgTrack_NeedleDriver, meshesAreClosedOutwardAndLight)
{
    const Ptr<ToolModel> tool = ToolModel::needleDriver();
    size_t triangles = 0;
    ASSERT_EQ(4u, tool->meshes().size());
    for (size_t m = 0; m < 4; ++m)
    {
        const Mesh& mesh = tool->meshes()[m];
        triangles += mesh.triangles.size();
        EXPECT_TRUE(isClosed(mesh)) << "mesh " << m;
        EXPECT_GT(volume(mesh), 0) << "mesh " << m;
        for (size_t t = 0; t < mesh.triangles.size(); ++t)
        {
            const Vec3i& i = mesh.triangles[t];
            const Vec3d a = Point3d(mesh.vertices[i[0]]), b = Point3d(mesh.vertices[i[1]]), c = Point3d(mesh.vertices[i[2]]);
            const Vec3d normal = (b - a).cross(c - a);
            for (int k = 0; k < 3; ++k)
            {
                EXPECT_NEAR(1, cv::norm(mesh.normals[i[k]]), 1e-6);   // float rounding
                EXPECT_GT(normal.dot(Vec3d(Point3d(mesh.normals[i[k]]))), 0) << "the normal of a vertex is that of its side";
            }
        }
    }
    EXPECT_GE(triangles, 3000u);
    EXPECT_LE(triangles, 12000u);
}

TEST(SurgTrack_NeedleDriver, hasThePublishedDimensions)
{
    const Ptr<ToolModel> tool = ToolModel::needleDriver();
    double radius = 0, tip = 0;
    for (size_t i = 0; i < tool->meshes()[0].vertices.size(); ++i)
        if (tool->meshes()[0].vertices[i].z < -0.02f)
            radius = std::max(radius, cv::norm(Vec2f(tool->meshes()[0].vertices[i].x, tool->meshes()[0].vertices[i].y)));
    for (size_t i = 0; i < tool->meshes()[2].vertices.size(); ++i)
        tip = std::max(tip, (double)tool->meshes()[2].vertices[i].y);
    EXPECT_NEAR(0.0042, radius, 1e-8);    // float rounding
    EXPECT_NEAR(0.00965, tip, 1e-8);      // float rounding
    EXPECT_EQ(0.0091, tool->links()[tool->meshes().size() + 1].a);
    std::vector<Matx44d> closed, open;
    tool->forwardKinematics(std::vector<double>{ 0, 0, 0.1, 0, 0, 0, 0 }, closed);
    tool->forwardKinematics(std::vector<double>{ 0, 0, 0.1, 0, 0, 0, 1 }, open);
    // Of two jaws opened by 1 rad each has turned by half of it, about the same axis, in opposite senses.
    const Matx44d right = closed[6].inv() * open[6], left = closed[7].inv() * open[7];
    EXPECT_NEAR(0.5, std::atan2(right(1, 0), right(0, 0)), 1e-12);
    EXPECT_LT(cv::norm(right * left - Matx44d::eye()), 1e-12);
}

double distanceToSegment(const Vec3d& p, const Vec3d& a, const Vec3d& b)
{
    const Vec3d edge = b - a;
    return cv::norm(p - a - edge * std::min(1., std::max(0., (p - a).dot(edge) / edge.dot(edge))));
}

double distanceToMesh(const Point3d& point, const Mesh& mesh)
{
    double best = DBL_MAX;
    for (size_t t = 0; t < mesh.triangles.size(); ++t)
    {
        const Vec3i& i = mesh.triangles[t];
        const Vec3d p = point, a = Point3d(mesh.vertices[i[0]]), b = Point3d(mesh.vertices[i[1]]), c = Point3d(mesh.vertices[i[2]]);
        const Vec3d n = (b - a).cross(c - a) / cv::norm((b - a).cross(c - a));
        const bool inside = n.dot((b - a).cross(p - a)) >= 0 && n.dot((c - b).cross(p - b)) >= 0 && n.dot((a - c).cross(p - c)) >= 0;
        best = std::min(best, inside ? std::abs(n.dot(p - a)) : std::min(distanceToSegment(p, a, b), std::min(distanceToSegment(p, b, c),
                                                                                                          distanceToSegment(p, c, a))));
    }
    return best;
}

TEST(SurgTrack_NeedleDriver, keypointsLieOnTheSurfaceInPairs)
{
    const Ptr<ToolModel> tool = ToolModel::needleDriver();
    ASSERT_EQ(14u, tool->keypoints().size());
    for (size_t k = 0; k < 14; ++k)
    {
        const ToolModel::Keypoint& keypoint = tool->keypoints()[k];
        ASSERT_GE(tool->links()[keypoint.link].mesh, 0);
        EXPECT_LT(distanceToMesh(keypoint.linkPoint, tool->meshes()[tool->links()[keypoint.link].mesh]), 1e-8) << keypoint.name;   // rounding
        if (k % 2 == 0)
        {
            const String flat = keypoint.name, deep = tool->keypoints()[k + 1].name;
            EXPECT_EQ(flat.substr(0, flat.find("_flat")), deep.substr(0, deep.find("_deep")));
        }
    }
}

// ------------------------------------------------------------------------------------------- against data made by other means

std::vector<std::vector<std::string> > readCSV(const String& filename)
{
    std::ifstream file(filename.c_str());
    CV_Assert(file.is_open());
    std::vector<std::vector<std::string> > rows;
    std::string line, cell;
    for (std::getline(file, line); std::getline(file, line); )
    {
        std::istringstream cells(line);
        rows.push_back(std::vector<std::string>());
        while (std::getline(cells, cell, ','))
            rows.back().push_back(cell);
    }
    return rows;
}

Matx44d poseOf(const std::vector<std::string>& row)
{
    double v[7];
    for (int i = 0; i < 7; ++i)
        v[i] = std::atof(row[3 + i].c_str());
    const double x = v[3], y = v[4], z = v[5], w = v[6];
    return Matx44d(1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), v[0],
                   2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), v[1],
                   2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), v[2], 0, 0, 0, 1);
}

TEST(SurgTrack_ToolModel, truePosesAndKeypointsOfTheSequencesAreReproduced)
{
    const char* const sequences[] = { "exvivo_single", "phantom_stereo", "paper_rig" };
    const Ptr<ToolModel> tool = ToolModel::load(recorded("tools/large_needle_driver/large_needle_driver_lowres.yaml"));
    for (int s = 0; s < 3; ++s)
    {
        const String folder = recorded(String("sequences/") + sequences[s]);
        const std::vector<std::vector<std::string> > truth = readCSV(folder + "/groundtruth.csv"), keypoints = readCSV(folder + "/keypoints.csv");
        std::map<std::string, Matx44d> camera_T_base;
        std::map<std::pair<std::string, std::string>, Mat> basePoints;
        double worstPose = 0, worstPoint = 0;
        for (size_t i = 0; i < truth.size(); ++i)
        {
            std::vector<double> q;
            for (int k = 0; k < 7; ++k)
                q.push_back(std::atof(truth[i][10 + k].c_str()));
            const Matx44d T = poseOf(truth[i]) * tool->endEffectorPose(q).inv();
            camera_T_base.insert(std::make_pair(truth[i][2], T));
            worstPose = std::max(worstPose, cv::norm(T - camera_T_base[truth[i][2]], NORM_INF));
            tool->keypointPositions(q, basePoints[std::make_pair(truth[i][0], truth[i][2])]);
        }
        for (size_t i = 0; i < keypoints.size(); ++i)
        {
            const std::vector<String> names = tool->keypointNames();
            const int k = (int)(std::find(names.begin(), names.end(), keypoints[i][2]) - names.begin());
            ASSERT_LT(k, (int)names.size()) << keypoints[i][2];
            const Point3d p(basePoints[std::make_pair(keypoints[i][0], keypoints[i][1])].row(k));
            const Matx44d& T = camera_T_base[keypoints[i][1]];
            const Vec4d view = T * Vec4d(p.x, p.y, p.z, 1);
            for (int c = 0; c < 3; ++c)
                worstPoint = std::max(worstPoint, std::abs(view[c] - std::atof(keypoints[i][5 + c].c_str())));
        }
        printf("%s: %d poses to %.1e, %d keypoints to %.1e m\n", sequences[s], (int)truth.size(), worstPose, (int)keypoints.size(), worstPoint);
        EXPECT_LT(worstPose, 1e-6) << "the truth is good to 4e-7, as single precision would leave it";
        EXPECT_LT(worstPoint, 0.6e-6) << "six decimals are written";
    }
}

// The chain of the URDF file: a joint a line, in the order of its elements.
struct UrdfJoint { std::string parent, mimic; bool prismatic; Matx44d origin; double multiplier; };

std::string attribute(const std::string& line, const std::string& element, const std::string& name)
{
    const size_t at = line.find("<" + element + " "), from = at == std::string::npos ? at : line.find(name + "=\"", at);
    if (from == std::string::npos)
        return std::string();
    const size_t begin = from + name.size() + 2;
    return line.substr(begin, line.find('"', begin) - begin);
}

TEST(SurgTrack_ToolModel, kinematicsEqualThoseOfTheUrdf)
{
    const Ptr<ToolModel> tool = ToolModel::load(recorded("tools/large_needle_driver/large_needle_driver_lowres.yaml"));
    std::ifstream file(recorded("tools/large_needle_driver/large_needle_driver.urdf").c_str());
    std::map<std::string, UrdfJoint> joints;   // by child; each with the name of the coordinate in `mimic`
    std::string line;
    while (std::getline(file, line))
    {
        if (line.find("<joint ") == std::string::npos)
            continue;
        UrdfJoint joint = { attribute(line, "parent", "link"), attribute(line, "mimic", "joint"),
                            attribute(line, "joint", "type") == "prismatic", Matx44d::eye(), 1 };
        if (joint.mimic.empty())
            joint.mimic = attribute(line, "joint", "name");
        else
            joint.multiplier = std::atof(attribute(line, "mimic", "multiplier").c_str());
        double x = 0, y = 0, z = 0, r = 0, p = 0, w = 0;
        std::istringstream(attribute(line, "origin", "xyz")) >> x >> y >> z;
        std::istringstream(attribute(line, "origin", "rpy")) >> r >> p >> w;
        const Matx33d R = Matx33d(cos(w), -sin(w), 0, sin(w), cos(w), 0, 0, 0, 1) * Matx33d(cos(p), 0, sin(p), 0, 1, 0, -sin(p), 0, cos(p))
                        * Matx33d(1, 0, 0, 0, cos(r), -sin(r), 0, sin(r), cos(r));
        joint.origin = Matx44d(R(0, 0), R(0, 1), R(0, 2), x, R(1, 0), R(1, 1), R(1, 2), y, R(2, 0), R(2, 1), R(2, 2), z, 0, 0, 0, 1);
        joints[attribute(line, "child", "link")] = joint;
    }
    RNG rng(11);
    for (int i = 0; i < 20; ++i)
    {
        const std::vector<double> q = randomJoints(*tool, rng);
        std::vector<Matx44d> base_T_link;
        tool->forwardKinematics(q, base_T_link);
        for (size_t l = 0; l < base_T_link.size(); ++l)
        {
            Matx44d expected = Matx44d::eye();
            for (std::string name = tool->linkNames()[l]; name != "base"; name = joints[name].parent)
            {
                ASSERT_EQ(1u, joints.count(name)) << name;
                const UrdfJoint& joint = joints[name];
                const double v = joint.multiplier * q[tool->coordinateIndex(joint.mimic)], t = joint.prismatic ? 0 : v;
                expected = joint.origin * Matx44d(cos(t), -sin(t), 0, 0, sin(t), cos(t), 0, 0, 0, 0, 1, joint.prismatic ? v : 0, 0, 0, 0, 1) * expected;
            }
            EXPECT_LT(cv::norm(base_T_link[l] - expected, NORM_INF), 5e-9) << "nine decimals of an angle are written, several in a chain";
        }
    }
}

}} // namespace opencv_test
