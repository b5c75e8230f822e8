// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_common.hpp"
#include "opencv2/core/utils/filesystem.hpp"
#include "opencv2/surgtrack/import.hpp"
#include "opencv2/surgtrack/tracker_params.hpp"

#include <cstdio>
#include <thread>
#ifndef _WIN32
#include <sys/stat.h>
#endif

// Files that are damaged, or made to do harm: each is read, or is an error that names it, after work in proportion to its size.

namespace opencv_test { namespace {

const double enough = 10;   // [s]; each of these takes milliseconds, and minutes, gigabytes or for ever where work is not bounded

class HostileFile
{
public:
    HostileFile(const std::string& content, const char* extension) : name(cv::tempfile(extension)) { std::ofstream(name.c_str(), std::ios::binary) << content; }
    ~HostileFile() { std::remove(name.c_str()); }
    const std::string name;
};

// What reading says of a file; "" if it takes it.
template <typename Read> std::string answerTo(const std::string& content, const char* extension, const Read& read)
{
    const HostileFile file(content, extension);
    const int64 start = cv::getTickCount();
    const std::string error = errorText([&]() { read(file.name); });
    EXPECT_LT((cv::getTickCount() - start) / cv::getTickFrequency(), enough) << content.substr(0, 200);
    EXPECT_TRUE(error.empty() || error.find(file.name) != std::string::npos) << "the file is not named: " << error.substr(0, 300);
    return error;
}

std::string meshAnswer(const std::string& content, const char* extension)
{
    return answerTo(content, extension, [](const std::string& name) { loadMesh(name); });
}

#define EXPECT_REFUSED(answer, what)                                                                                                     \
    do                                                                                                                                   \
    {                                                                                                                                    \
        const std::string text_ = answer;                                                                                                \
        EXPECT_NE(std::string::npos, text_.find(what)) << "the message is '" << text_.substr(0, 300) << "'";                             \
    } while (false)

std::string repeated(const std::string& text, int n)
{
    std::string result;
    for (int i = 0; i < n; i++) result += text;
    return result;
}

// --- PLY ---

// A tetrahedron; elements and their data in this order, beside `other` of one number.
std::string ply(const std::vector<std::string>& order, const std::string& more = "")
{
    std::string header = "ply\nformat ascii 1.0\n", body;
    for (size_t i = 0; i < order.size(); i++)
        if (order[i] == "vertex")
        {
            header += "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
            body += "0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
        }
        else if (order[i] == "face")
        {
            header += "element face 4\nproperty list uchar int vertex_indices\n";
            body += "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n";
        }
        else
        {
            header += "element " + order[i] + " 1\nproperty int a\n";
            body += "7\n";
        }
    return header + more + "end_header\n" + body;
}

TEST(SurgTrack_HostileFiles, plyElementsMayComeInAnyOrder)
{
    const std::vector<std::string> orders[] = { { "other", "vertex", "face" }, { "vertex", "other", "face" }, { "vertex", "face", "other" }, { "face", "vertex" },
                                                { "face", "other", "vertex" } };
    for (size_t i = 0; i < 5; i++)
    {
        const HostileFile file(ply(orders[i]), ".ply");
        const Mesh mesh = loadMesh(file.name);
        EXPECT_EQ(4u, mesh.triangles.size()) << i;
    }
}

TEST(SurgTrack_HostileFiles, plyHeadersAreNotBelieved)
{
    EXPECT_REFUSED(meshAnswer(ply({ "vertex", "face" }, "property list uchar int\n"), ".ply"), "property");
    EXPECT_REFUSED(meshAnswer(ply({ "vertex", "face" }, "property float\n"), ".ply"), "property");
    const std::string few = "element vertex 0\nproperty float x\nproperty float y\nproperty float z\nelement face 0\nproperty list uchar int vertex_indices\n";
    const std::string kinds[] = { "ascii", "binary_little_endian", "binary_big_endian" };
    for (size_t i = 0; i < 3; i++)
    {
        // Elements that take no bytes, two billions of each.
        std::string many = "ply\nformat " + kinds[i] + " 1.0\n" + few;
        for (int k = 0; k < 20; k++) many += format("element e%d 2147483647\n", k);
        EXPECT_REFUSED(meshAnswer(many + "end_header\n", ".ply"), i ? "triangle" : "truncated");
        // More than the file has bytes for.
        EXPECT_REFUSED(meshAnswer("ply\nformat " + kinds[i] + " 1.0\n" + few + "element e 2147483647\nproperty list uint double d\nend_header\n1 2 3 4\n", ".ply"), "");
    }
    EXPECT_REFUSED(meshAnswer("ply\nformat ascii 1.0\n" + few + repeated("element e 1\n", 50000) + "end_header\n", ".ply"), "at most 100");
    EXPECT_REFUSED(meshAnswer(ply({ "vertex", "face" }) + "3 0 1 0.5\n", ".ply"), "");
}

// --- STL: text or binary is decided once ---

std::string textStl(const std::string& name, int facets)
{
    std::string result = "solid " + name + "\n";
    for (int i = 0; i < facets; i++)
        result += format("facet normal 0 0 1\nouter loop\nvertex 0 0 %d\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n", i);
    return result + "endsolid " + name + "\n";
}

TEST(SurgTrack_HostileFiles, namesOfAnyLettersMayStandInTextStl)
{
    const std::string names[] = { "Gr\xC3\xBCner Greifer", "Gr\xFCner", "\xD0\x97\xD0\xB0\xD0\xB6\xD0\xB8\xD0\xBC", "\xE6\x89\x8B\xE6\x9C\xAF\xE5\x88\x80",
                                  std::string("a\0b", 3), "a\x01" "b\x02", repeated("\xC3\xA4", 600), "vertex 1 2", "" };
    for (size_t i = 0; i < sizeof(names) / sizeof(names[0]); i++)
        for (int facets = 1; facets < 20; facets += 9)
        {
            const HostileFile file(textStl(names[i], facets), ".stl");
            EXPECT_EQ(facets, (int)loadMesh(file.name).triangles.size()) << i;
        }
}

TEST(SurgTrack_HostileFiles, damagedTextStlIsRefused)
{
    const std::string good = textStl("a", 2);
    RNG rng(3);
    for (int i = 0; i < 500; i++)
    {
        std::string bad = good;
        for (int k = rng.uniform(1, 5); k > 0; k--) bad[rng.uniform(6, (int)bad.size())] = (char)rng.uniform(0, 256);
        meshAnswer(bad, ".stl");   // an answer is all that is asked for
    }
    EXPECT_REFUSED(meshAnswer("solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nen0 1 1\nendloop\nendfacet\nendsolid a\n", ".stl"), "`en0`");
    std::string binary(84, ' ');
    binary.replace(0, 5, "solid");
    for (int k = 80; k < 84; k++) binary[k] = '\xFF';
    EXPECT_REFUSED(meshAnswer(binary, ".stl"), "facets");
    binary.replace(0, 5, "lidso");
    EXPECT_REFUSED(meshAnswer(binary, ".stl"), "214748364834 bytes");
}

TEST(SurgTrack_HostileFiles, objFacesAreBounded)
{
    std::string obj, face = "f";
    for (int i = 0; i < 5000; i++)
    {
        obj += format("v %d %d 0\n", i % 100, i / 100);
        face += format(" %d", i + 1);
    }
    EXPECT_REFUSED(meshAnswer(obj + face + "\n", ".obj"), "at most 1000");
    EXPECT_REFUSED(meshAnswer("v 0x1 0 0\n", ".obj"), "finite numbers");
}

// Readers of libraries have kept what they read in one place for all threads.
TEST(SurgTrack_HostileFiles, meshesAreLoadedInSeveralThreads)
{
    std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n", dae =
        "<?xml version=\"1.0\"?><COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\"><library_geometries><geometry id=\"g\"><mesh>"
        "<source id=\"p\"><float_array id=\"a\" count=\"12\">0 0 0 1 0 0 0 1 0 0 0 1</float_array><technique_common><accessor source=\"#a\" count=\"4\" stride=\"3\">"
        "<param name=\"X\" type=\"float\"/><param name=\"Y\" type=\"float\"/><param name=\"Z\" type=\"float\"/></accessor></technique_common></source>"
        "<vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices><triangles count=\"4\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/>"
        "<p>0 2 1 0 1 3 1 2 3 2 0 3</p></triangles></mesh></geometry></library_geometries><library_visual_scenes><visual_scene id=\"s\"><node>"
        "<instance_geometry url=\"#g\"/></node></visual_scene></library_visual_scenes><scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>";
    const HostileFile files[] = { { ply({ "vertex", "face" }), ".ply" }, { textStl("a", 4), ".stl" }, { obj, ".obj" }, { dae, ".dae" } };
    std::vector<std::thread> threads;
    std::vector<int> right(4, 0);
    for (int k = 0; k < 4; k++)
        threads.push_back(std::thread([&, k]()
        {
            for (int i = 0; i < 100; i++)
            {
                const std::string error = errorText([&]() { right[k] += loadMesh(files[(i + k) % 4].name).triangles.size() == 4; });
                EXPECT_EQ("", error);
            }
        }));
    for (int k = 0; k < 4; k++)
    {
        threads[k].join();
        EXPECT_EQ(100, right[k]);
    }
}

// --- what is no file ---

#ifndef _WIN32
TEST(SurgTrack_HostileFiles, devicesAndPipesAreNotRead)
{
    const std::string pipe = cv::tempfile(".ply");
    ASSERT_EQ(0, mkfifo(pipe.c_str(), 0600));
    const HostileFile link("x", ".ply");
    std::remove(link.name.c_str());
    ASSERT_EQ(0, symlink("/dev/zero", link.name.c_str()));
    const std::string names[] = { pipe, link.name };
    for (size_t i = 0; i < 2; i++)
    {
        EXPECT_ERROR(loadMesh(names[i]), names[i]);
        EXPECT_ERROR(ToolModel::load(names[i]), names[i]);
        EXPECT_ERROR(Sequence::load(names[i]), names[i]);
        std::vector<double> keys;
        Mat poses;
        EXPECT_ERROR(readPoses(names[i], keys, poses), names[i]);
        EXPECT_ERROR(importCameraInfo({ names[i] }), names[i]);
        ToolParts parts;
        EXPECT_ERROR(importUrdfTool(names[i], parts), names[i]);
    }
    std::remove(pipe.c_str());
}

// Then data is not looked for in /.
TEST(SurgTrack_HostileFiles, anEmptyNameOfTheDataFolderIsNone)
{
    const char* const data = std::getenv("SURGTRACK_DATA");
    const std::string before = data ? data : "";
    ASSERT_EQ(0, setenv("SURGTRACK_DATA", "", 1));
    EXPECT_TRUE(dataFolder().empty());
    ASSERT_EQ(0, data ? setenv("SURGTRACK_DATA", before.c_str(), 1) : unsetenv("SURGTRACK_DATA"));
}

TEST(SurgTrack_HostileFiles, namesWithLineFeedsAreNames)
{
    const std::string folder = cv::tempfile("") + "%YAML:1.0\nname: x\n";
    ASSERT_TRUE(cv::utils::fs::createDirectory(folder));
    const std::string name = folder + "/driver.yaml";
    needleDriver()->save(name);
    EXPECT_EQ(needleDriver()->coordinateNames(), ToolModel::load(name)->coordinateNames());
    cv::utils::fs::remove_all(folder);
}

// --- disks that are full ---

TEST(SurgTrack_HostileFiles, aFullDiskIsAnErrorAndLeavesWhatWasThere)
{
    if (!cv::utils::fs::exists("/dev/full")) throw SkipTestException("there is no /dev/full");
    const std::string folder = cv::tempfile(""), name = folder + "/driver.yaml";
    ASSERT_TRUE(cv::utils::fs::createDirectory(folder));
    const auto content = [](const std::string& file)
    {
        std::ostringstream text;
        text << std::ifstream(file.c_str(), std::ios::binary).rdbuf();
        return text.str();
    };
    needleDriver()->save(name);
    const std::string before = content(name);
    ASSERT_FALSE(before.empty());
    // What is written under a temporary name first fails there.
    ASSERT_EQ(0, symlink("/dev/full", (name + ".new").c_str()));
    EXPECT_ERROR(needleDriver()->save(name), name);
    EXPECT_EQ(before, content(name));
    ASSERT_EQ(0, symlink("/dev/full", (name + ".new").c_str()));   // it was taken away again
    EXPECT_ERROR(writeTrackerParams(name, ToolTracker::Params(), ToolTracker::Stages()), name);
    EXPECT_TRUE(before == content(name));
    const std::string sequence = folder + "/sequence.yaml";
    writeSequenceTool(folder, "PSM1", name, Matx44d::eye());
    const std::string description = content(sequence);
    ASSERT_EQ(0, symlink("/dev/full", (sequence + ".new").c_str()));
    EXPECT_ERROR(writeSequenceTool(folder, "PSM2", name, Matx44d::eye()), sequence);
    EXPECT_EQ(description, content(sequence));
    cv::utils::fs::remove_all(folder);
}
#endif

// --- cv::FileStorage ---

std::string storageAnswer(const std::string& content)
{
    return answerTo(content, ".yaml", [](const std::string& name) { ToolModel::load(name); });
}

TEST(SurgTrack_HostileFiles, nestingOfStoragesIsBounded)
{
    const int deep = 50000;
    EXPECT_REFUSED(storageAnswer("%YAML:1.0\n---\na: " + repeated("[", deep)), "64 levels");
    EXPECT_REFUSED(storageAnswer("%YAML:1.0\n---\na: " + repeated("[ \"]\", ", deep)), "64 levels");
    EXPECT_REFUSED(storageAnswer("%YAML:1.0\n---\na: " + repeated("[ it's, ']', ", deep)), "64 levels");
    EXPECT_REFUSED(storageAnswer("%YAML:1.0\n---\na: " + repeated("{ k} , x: ", deep)), "64 levels");
    EXPECT_REFUSED(storageAnswer("%YAML:1.0\n---\n" + repeated("a: ", deep)), "64 levels");
    EXPECT_REFUSED(storageAnswer("%YAML:1.0\n---\n" + repeated("- ", deep)), "64 levels");
    std::string steps = "%YAML:1.0\n---\n";
    for (int i = 0; i < 1000; i++) steps += std::string(i, ' ') + "a:\n";
    EXPECT_REFUSED(storageAnswer(steps), "column 256");
    EXPECT_REFUSED(storageAnswer("{ \"a\": " + repeated("[", deep)), "64 levels");
    EXPECT_REFUSED(storageAnswer("{ " + repeated("\"a\": { ", deep)), "64 levels");
    EXPECT_REFUSED(storageAnswer("<?xml version=\"1.0\"?>\n<opencv_storage>\n" + repeated("<a>", deep)), "64 levels");
}

TEST(SurgTrack_HostileFiles, textsThatEndWithinAreRefused)
{
    const char* const texts[] = {
        "%YAML:1.0\n---\n:", "%YAML:1.0\n   : 1\n", "%YAML:1.0\n---\na: \"b\\", "%YAML:1.0\n---\na: \"\\x", "%YAML:1.0\n---\na: [1, 2", "%YAML:1.0\n---\na: 1\n...\n- x\n",
        "%YAML:1.0\n- x\n...\n-", "%YAML:1.0\na: {b: 1", "%YAML:1.0\n---\n{a: 1}\nxy", "%YAML:1.0\n---\n  a: 1\nx", "%YAML:1.0\n---\na: !!binary |\n  AAAA", "%YAML:1.0\na: !<", "%YAML",
        "<?xml version=\"1.0\"?>\n<opencv_storage><a b=", "<?xml version=\"1.0\"?>\n<opencv_storage><a b=\">\" c=", "<?xml", "<?xml version=\"1.0\"?>\n<opencv_storage>\n<", "<?xml?><",
        "<?xml version=\"1.0\"?>\n<opencv_storage><a type_id=\"binary\">AAAA</a></opencv_storage>", "{ \"a\": \"$base64$AAAA\" }", "{ \"a\": \"b", "{ /*", "{ //", "{", "{ \"a\" ",
        "{ \"a\": \"b\\", "%YAML:1.0\n---a%L: 1\n--\n-na", "%YAML:1.0\n---\n   %YAML:1.0\n--z-\na: 1\n", "%YAML:1.0\n---\nrows: 2000000000\ncols: 4\ndt: d\ndata: [ 1. ]\n", "%YAML:1.0\n---\nm: !!opencv-matrix\n   rows: 2147483647\n   cols: 2147483647\n   dt: d\n   data: [ 1. ]\n", "%YAML:1.0\n---\nm: !!opencv-matrix\n   sizes: [ 40000, 40000 ]\n   dt: d\n   data: [ 1. ]\n" };
    for (size_t i = 0; i < sizeof(texts) / sizeof(texts[0]); i++) EXPECT_NE("", storageAnswer(texts[i])) << texts[i];
    EXPECT_REFUSED(storageAnswer(std::string("%YAML:1.0\n\0a: 1\n", 16)), "byte 0");
}

// What is sound goes through: a tool written in each form, and by hand.
TEST(SurgTrack_HostileFiles, soundStoragesAreRead)
{
    const char* const forms[] = { ".yaml", ".xml", ".json" };
    for (int i = 0; i < 3; i++)
    {
        const std::string folder = cv::tempfile(""), name = folder + "/tool" + forms[i];
        ASSERT_TRUE(cv::utils::fs::createDirectory(folder));
        needleDriver()->save(name);
        EXPECT_EQ(needleDriver()->keypointNames(), ToolModel::load(name)->keypointNames()) << forms[i];
        cv::utils::fs::remove_all(folder);
    }
    const HostileFile camera("# by hand\n%YAML:1.0\n", ".yaml");
    const HostileFile info("image_width: 640   # of it\nimage_height: 480\ncamera_name: it's [a] \"camera\": 1\nmore: { a: 'x], [', b: [ [1, 2], [ 3 4 ] ] }\n"
                           "camera_matrix:\n  rows: 3\n  cols: 3\n  data: [500, 0, 320,\n         0, 500, 240, 0, 0, 1]\n"
                           "distortion_coefficients: {rows: 1, cols: 5, data: [0.1 -0.2 0 0 0]}\ntexts:\n- \"a: [\"\n- 'it''s }'\n- -1\n- - 1\n  - 2\n...\n---\nnot read: [\n", ".yaml");
    EXPECT_EQ(Size(640, 480), importCameraInfo({ info.name }).left.imageSize());
}

// --- errors ---

// Whatever stands in a file, what is said of it is a line to be read, and does nothing to a terminal.
TEST(SurgTrack_HostileFiles, errorsAreShortLines)
{
    const std::string wild = repeated("7\x1b[2J\x07", 20000);
    std::vector<std::string> answers;
    const auto poses = [](const std::string& name) { std::vector<double> keys; Mat found; readPoses(name, keys, found); };
    answers.push_back(answerTo("index,tx,ty,tz,qx,qy,qz,qw\n0," + wild + ",0,0,0,0,0,1\n", ".csv", poses));
    answers.push_back(answerTo("index,tx,ty,tz,qx,qy,qz,qw," + wild + "," + wild + "\n", ".csv", poses));
    answers.push_back(storageAnswer("%YAML:1.0\n---\nname: x\ncoordinates: [ \"" + wild + "\", \"" + wild + "\" ]\n"));
    answers.push_back(answerTo("camera_matrix: " + wild + "\nimage_width: " + wild + "\n", ".yaml", [](const std::string& name) { importCameraInfo({ name }); }));
    answers.push_back(meshAnswer("ply\n" + wild + "\nend_header\n", ".ply"));
    answers.push_back(meshAnswer("solid a\n" + wild + "\n", ".stl"));
    // Latin-1, and what looks like UTF-8; letters stay.
    answers.push_back(answerTo("index,tx,ty,tz,qx,qy,qz,qw\n0,Gr\xFC\xDF" "e \xC3\xA4\xE6\x89\x8B\xF0\x9F\x94\xA7 \xC0\x80\xED\xA0\x80\xC2\x9B\xF8\x90\x80\x80\xE6\x89,0,0,0,0,0,1\n", ".csv", poses));
    EXPECT_REFUSED(answers.back(), "'Gr" + std::string(2, '?') + "e \xC3\xA4\xE6\x89\x8B\xF0\x9F\x94\xA7 " + std::string(13, '?') + "'");
    for (size_t i = 0; i < answers.size(); i++)
    {
        EXPECT_NE("", answers[i]) << i;
        EXPECT_GT(3000u, answers[i].size()) << i << ": " << answers[i].substr(0, 300);
        EXPECT_EQ(std::string::npos, answers[i].find_first_of("\x1b\x07")) << i << ": " << answers[i].substr(0, 300);
    }
}

TEST(SurgTrack_HostileFiles, whatIsReplacedMustBeAMatrix)
{
    const char* const poses[] = { "{ rows: 4, cols: 4, data: [ 1., 2. ] }", "{ rows: 4, cols: 4, dt: d }", "{ rows: -4, cols: 4, dt: d, data: [ 1. ] }", "{ a: 1 }",
                                  "!!opencv-matrix { rows: 4, cols: 4, dt: \"9999999999x\", data: [ 1. ] }", "1" };
    for (size_t i = 0; i < sizeof(poses) / sizeof(poses[0]); i++)
        EXPECT_NE("", answerTo(std::string("%YAML:1.0\n---\ntools:\n   - { name: A, camera_T_base: ") + poses[i] + " }\n", ".yaml",
                               [](const std::string& name) { writeHandEye(name, "A", Matx44d::eye()); })) << poses[i];
}

// Of a matrix without its numbers nothing is taken: room for them, with what is in it, was there before they were read.
TEST(SurgTrack_HostileFiles, matricesNeedTheirNumbers)
{
    const auto matrix = [](const char* name, int rows, int cols, const char* data)
    { return format("<%s type_id=\"opencv-matrix\"><rows>%d</rows><cols>%d</cols><dt>d</dt><data>%s</data></%s>", name, rows, cols, data, name); };
    const std::string begin = "<?xml version=\"1.0\"?>\n<opencv_storage>\n", end = "\n</opencv_storage>\n";
    const std::string K = matrix("camera_matrix", 3, 3, "800. 0. 320. 0. 810. 240. 0. 0. 1."), size = "<image_width>640</image_width><image_height>480</image_height>";
    const auto cameras = [](const std::string& name) { importOpenCVCameras({name}); };
    const auto handEye = [](const std::string& name) { importDaVinciHandEye(name, "T"); };
    EXPECT_EQ("", answerTo(begin + size + K + matrix("distortion_coefficients", 5, 1, "0. 0. 0. 0. 0.") + end, ".xml", cameras));
    for (int i = 0; i < 20; i++)   // memory may hold what it held the time before
    {
        EXPECT_REFUSED(answerTo(begin + size + matrix("camera_matrix", 3, 3, "800. 0.") + end, ".xml", cameras), "expected a matrix");
        EXPECT_REFUSED(answerTo(begin + size + K + matrix("distortion_coefficients", 5, 1, "0.1 0.1") + end, ".xml", cameras), "expected a matrix");
        EXPECT_REFUSED(answerTo(begin + matrix("T", 4, 4, "1. 0. 0.") + end, ".xml", handEye), "expected a rigid 4x4 matrix");
    }
}

// What a tool's or a camera's entry is written beside is copied.
TEST(SurgTrack_HostileFiles, sequencesThatCannotBeCopiedAreLeftAlone)
{
    const std::string folder = cv::tempfile(""), name = folder + "/sequence.yaml";
    ASSERT_TRUE(cv::utils::fs::createDirectory(folder));
    const char* const values[] = { "!!opencv-matrix { rows: 4, cols: 4, dt: d, data: [ 1., 2. ] }", "!!opencv-matrix { rows: 4, cols: 4, dt: d }", "{ rows: 4, %dt: d }" };
    for (size_t i = 0; i < sizeof(values) / sizeof(values[0]); i++)
    {
        const std::string before = std::string("%YAML:1.0\n---\nboard: ") + values[i] + "\n";
        std::ofstream(name.c_str(), std::ios::binary) << before;
        EXPECT_ERROR(writeSequenceTool(folder, "PSM1", "tool.yaml", Matx44d::eye()), name);
        std::ostringstream after;
        after << std::ifstream(name.c_str(), std::ios::binary).rdbuf();
        EXPECT_EQ(before, after.str());
    }
    cv::utils::fs::remove_all(folder);
}

// --- long lines, many items ---

TEST(SurgTrack_HostileFiles, longLinesAreLines)
{
    const int length = 200000;
    const auto info = [](const std::string& name) { importCameraInfo({ name }); };
    const auto labels = [](const std::string& name) { importSurgPoseKeypoints(name, name + ".csv", {}, {}); };
    const std::string lines[] = { "a: 1" + std::string(length, ' '), std::string(length, '1') + ": 2", "a: [" + repeated("1 ", length) + "]", "a: [1" + std::string(length, ' ') + "]",
                                  std::string(length, ' '), repeated("{", length), repeated(",", length), "a: " + repeated("'", length), repeated("!!python/tuple", length / 10) };
    for (size_t i = 0; i < sizeof(lines) / sizeof(lines[0]); i++)
    {
        EXPECT_NE("", answerTo(lines[i] + "\n", ".yaml", info)) << i;
        answerTo("1:\n  1: [3, 4]\n" + lines[i] + "\n", ".yaml", labels);
    }
    EXPECT_REFUSED(answerTo("a" + repeated(",a", 50000) + "\n", ".csv", [](const std::string& name) { std::vector<double> keys; Mat poses; readPoses(name, keys, poses); }), "at most");
    std::string many = "%YAML:1.0\n---\nname: x\ncoordinates: [ a0";
    for (int i = 1; i < 100000; i++) many += format(",\n     a%d", i);
    EXPECT_REFUSED(storageAnswer(many + " ]\n"), "at most 1000");
}

// --- URDF ---

std::string urdfAnswer(const std::string& content, const std::string& base = "")
{
    return answerTo(content, ".urdf", [&](const std::string& name)
    {
        ToolParts parts;
        parts.base = base;
        importUrdfTool(name, parts);
    });
}

std::string urdf(const std::vector<std::pair<int, int> >& joints, int links)
{
    std::string text = "<robot name=\"r\">";
    for (int i = 0; i < links; i++) text += format("<link name=\"l%d\"/>", i);
    for (size_t i = 0; i < joints.size(); i++)
        text += format("<joint name=\"j%d\" type=\"continuous\"><parent link=\"l%d\"/><child link=\"l%d\"/><axis xyz=\"0 0 1\"/></joint>", (int)i, joints[i].first, joints[i].second);
    return text + "</robot>";
}

TEST(SurgTrack_HostileFiles, urdfLinksAreATree)
{
    const std::string probe = urdfAnswer(urdf({ { 0, 1 } }, 2));
    if (probe.find("urdfdom") != std::string::npos && probe.find("without") != std::string::npos) throw SkipTestException("built without urdfdom");
    EXPECT_REFUSED(urdfAnswer(urdf({ { 0, 1 }, { 1, 2 }, { 2, 1 } }, 3)), "tree of links");
    EXPECT_NE("", urdfAnswer(urdf({ { 1, 2 }, { 2, 1 } }, 3), "l1"));
    std::vector<std::pair<int, int> > diamond, chain;
    for (int i = 0; i < 30; i++)
    {
        diamond.push_back(std::make_pair(i, i + 1));
        diamond.push_back(std::make_pair(i, i + 1));
    }
    EXPECT_REFUSED(urdfAnswer(urdf(diamond, 31)), "tree of links");
    for (int i = 0; i < 20000; i++) chain.push_back(std::make_pair(i, i + 1));
    EXPECT_REFUSED(urdfAnswer(urdf(chain, 20001)), "at most 1000 joints");
}

TEST(SurgTrack_HostileFiles, urdfTagsAreBounded)
{
    const int deep = 20000;
    EXPECT_REFUSED(urdfAnswer("<robot name=\"r\">" + repeated("<a>", deep) + repeated("</a>", deep) + "</robot>"), "levels of tags");
    EXPECT_REFUSED(urdfAnswer("<robot name=\"r\">" + repeated("<a x=\"</\">", deep)), "levels of tags");
    EXPECT_REFUSED(urdfAnswer("<robot name=\"r\"><!--" + std::string(1000000, '-') + "${-->" + repeated("<a>", deep)), "levels of tags");
    EXPECT_REFUSED(urdfAnswer("<robot name=\"r\"><a x=\"<!--\">" + repeated("<a>", deep) + "-->"), "levels of tags");
    EXPECT_NE("", urdfAnswer(repeated("<joint ", 100000)));
    EXPECT_NE("", urdfAnswer("<"));
}

}} // namespace
