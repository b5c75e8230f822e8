// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_data.hpp"

#include <cstdio>
#include <fstream>
#include <sstream>

namespace opencv_test { namespace {

using namespace cv::surgtrack;

// A cube [0, 2]^3 as quads, seen from outside counter-clockwise.
const int CUBE_QUADS[6][4] = { { 0, 2, 3, 1 }, { 4, 5, 7, 6 }, { 0, 1, 5, 4 }, { 2, 6, 7, 3 }, { 0, 4, 6, 2 }, { 1, 3, 7, 5 } };

Point3f cubeCorner(int i)
{
    return Point3f(i & 1 ? 2.f : 0.f, i & 2 ? 2.f : 0.f, i & 4 ? 2.f : 0.f);
}

void put(std::string& data, const void* value, int size, bool bigEndian)
{
    const int one = 1;
    const bool hostIsBig = *(const char*)&one == 0;
    for (int i = 0; i < size; ++i)
        data += ((const char*)value)[bigEndian == hostIsBig ? i : size - 1 - i];
}

std::string binaryPLYCube(bool bigEndian)
{
    std::string data = std::string("ply\nformat ") + (bigEndian ? "binary_big_endian" : "binary_little_endian") + " 1.0\ncomment a cube\n"
        "element vertex 8\nproperty float x\nproperty float y\nproperty float z\nproperty uchar red\n"
        "element face 6\nproperty list uchar int vertex_indices\nend_header\n";
    for (int i = 0; i < 8; ++i)
    {
        const Point3f p = cubeCorner(i);
        put(data, &p.x, 4, bigEndian);
        put(data, &p.y, 4, bigEndian);
        put(data, &p.z, 4, bigEndian);
        data += (char)200;
    }
    for (int f = 0; f < 6; ++f)
    {
        data += (char)4;
        for (int k = 0; k < 4; ++k)
            put(data, &CUBE_QUADS[f][k], 4, bigEndian);
    }
    return data;
}

std::string asciiPLYCube()
{
    std::ostringstream s;
    s << "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
         "element face 6\nproperty list uchar int vertex_indices\nend_header\n";
    for (int i = 0; i < 8; ++i)
        s << cubeCorner(i).x << ' ' << cubeCorner(i).y << ' ' << cubeCorner(i).z << '\n';
    for (int f = 0; f < 6; ++f)
        s << "4 " << CUBE_QUADS[f][0] << ' ' << CUBE_QUADS[f][1] << ' ' << CUBE_QUADS[f][2] << ' ' << CUBE_QUADS[f][3] << '\n';
    return s.str();
}

std::string objCube(bool inverted = false)
{
    std::ostringstream s;
    s << "# a cube\n";
    for (int i = 0; i < 8; ++i)
        s << "v " << cubeCorner(i).x << ' ' << cubeCorner(i).y << ' ' << cubeCorner(i).z << '\n';
    s << "vt 0 0\n";
    for (int f = 0; f < 6; ++f)
    {
        s << 'f';
        for (int k = 0; k < 4; ++k)
            s << ' ' << 1 + CUBE_QUADS[f][inverted ? 3 - k : k] << "/1";
        s << '\n';
    }
    return s.str();
}

std::string stlCube(bool binary)
{
    std::string data = binary ? std::string("solid binaries may begin like this") : "solid cube\n";
    std::ostringstream text;
    const uint32_t count = 12;
    if (binary)
    {
        data.resize(80, ' ');
        put(data, &count, 4, false);
    }
    for (int f = 0; f < 6; ++f)
        for (int half = 0; half < 2; ++half)
        {
            const float zero = 0;
            const int corners[] = { 0, 1 + half, 2 + half };
            text << " facet normal 0 0 0\n  outer loop\n";
            for (int k = 0; binary && k < 3; ++k)
                put(data, &zero, 4, false);
            for (int k = 0; k < 3; ++k)
            {
                const Point3f p = cubeCorner(CUBE_QUADS[f][corners[k]]);
                text << "   vertex " << p.x << ' ' << p.y << ' ' << p.z << '\n';
                if (binary)
                    put(data, &p.x, 4, false), put(data, &p.y, 4, false), put(data, &p.z, 4, false);
            }
            text << "  endloop\n endfacet\n";
            if (binary)
                data += std::string(2, '\0');
        }
    return binary ? data : data + text.str() + "endsolid cube\n";
}

/* A mesh file that is removed again. */
class MeshFile
{
public:
    MeshFile(const std::string& content, const char* extension) : name(cv::tempfile(extension))
    {
        std::ofstream(name.c_str(), std::ios::binary) << content;
    }
    ~MeshFile() { std::remove(name.c_str()); }
    const std::string name;
};

// What loadMesh() says to the content; "" if it accepts it.
String errorOf(const std::string& content, const char* extension, std::string* name = 0)
{
    const MeshFile file(content, extension);
    if (name)
        *name = file.name;
    try
    {
        loadMesh(file.name);
    }
    catch (const cv::Exception& e)
    {
        EXPECT_EQ(Error::StsParseError, e.code) << e.what();
        EXPECT_NE(String::npos, e.err.find(file.name)) << "the file is not named: " << e.err;
        return e.err;
    }
    return String();
}

std::string replaced(std::string text, const std::string& what, const std::string& by)
{
    const size_t at = text.find(what);
    CV_Assert(at != std::string::npos);
    return text.replace(at, what.size(), by);
}

double distanceToTriangle(const Point3f& point, const Point3f& a, const Point3f& b, const Point3f& c)
{
    // In double: a shaft has triangles 0.5 m long and 0.4 mm wide.
    const Vec3d ab(Point3d(b) - Point3d(a)), ac(Point3d(c) - Point3d(a)), ap(Point3d(point) - Point3d(a));
    const double aa = ab.dot(ab), bb = ab.dot(ac), cc = ac.dot(ac), d = ab.dot(ap), e = ac.dot(ap), det = aa * cc - bb * bb;
    const double s = cc * d - bb * e, t = aa * e - bb * d;
    if (det > 0 && s >= 0 && t >= 0 && s + t <= det)
        return cv::norm(ap - ab * (s / det) - ac * (t / det));
    double best = DBL_MAX;
    const Point3f corners[] = { a, b, c };
    for (int i = 0; i < 3; ++i)
    {
        const Vec3d edge(Point3d(corners[(i + 1) % 3]) - Point3d(corners[i])), rel(Point3d(point) - Point3d(corners[i]));
        const double length = edge.dot(edge), u = length > 0 ? std::min(1., std::max(0., rel.dot(edge) / length)) : 0.;
        best = std::min(best, cv::norm(rel - edge * u));
    }
    return best;
}

double distanceToMesh(const Point3f& point, const Mesh& mesh)
{
    double best = DBL_MAX;
    for (size_t i = 0; i < mesh.triangles.size(); ++i)
    {
        const Vec3i& t = mesh.triangles[i];
        best = std::min(best, distanceToTriangle(point, mesh.vertices[t[0]], mesh.vertices[t[1]], mesh.vertices[t[2]]));
    }
    return best;
}

// Distances of random points of one surface, evenly spread over it, to the other, sorted.
std::vector<double> surfaceDistances(const Mesh& from, const Mesh& to, int samples, RNG& rng)
{
    std::vector<double> area(1, 0.), distances;
    for (size_t i = 0; i < from.triangles.size(); ++i)
    {
        const Vec3i& t = from.triangles[i];
        const Vec3f ab = from.vertices[t[1]] - from.vertices[t[0]], ac = from.vertices[t[2]] - from.vertices[t[0]];
        area.push_back(area.back() + cv::norm(ab.cross(ac)));
    }
    for (int i = 0; i < samples; ++i)
    {
        const size_t k = std::upper_bound(area.begin(), area.end(), rng.uniform(0., area.back())) - area.begin() - 1;
        const Vec3i& t = from.triangles[std::min(k, from.triangles.size() - 1)];
        float u = rng.uniform(0.f, 1.f), v = rng.uniform(0.f, 1.f);
        if (u + v > 1)
            u = 1 - u, v = 1 - v;
        const Point3f a = from.vertices[t[0]];
        distances.push_back(distanceToMesh(a + u * (from.vertices[t[1]] - a) + v * (from.vertices[t[2]] - a), to));
    }
    std::sort(distances.begin(), distances.end());
    return distances;
}

void expectCube(const Mesh& mesh, const String& what)
{
    ASSERT_EQ(12u, mesh.triangles.size()) << what;
    ASSERT_EQ(24u, mesh.vertices.size()) << what << ": each corner once per side";
    ASSERT_EQ(24u, mesh.normals.size()) << what;
    for (size_t i = 0; i < 12; ++i)
    {
        const Vec3i& t = mesh.triangles[i];
        const Point3f a = mesh.vertices[t[0]], b = mesh.vertices[t[1]], c = mesh.vertices[t[2]];
        const Vec3f faceNormal = Vec3f(b - a).cross(Vec3f(c - a)) / 4;   // twice the triangle's area is 4
        EXPECT_GT(faceNormal.dot(Vec3f(a + b + c) / 3 - Vec3f(1, 1, 1)), 0) << what << ": outward";
        for (int k = 0; k < 3; ++k)
            EXPECT_LT(cv::norm(Vec3f(mesh.normals[t[k]]) - faceNormal), 1e-6) << what;   // float rounding
    }
}

TEST(SurgTrack_Mesh, everyFormatGivesTheSameCube)
{
    const struct { std::string content; const char* extension; } files[] = {
        { asciiPLYCube(), ".ply" }, { binaryPLYCube(false), ".ply" }, { binaryPLYCube(true), ".PLY" }, { stlCube(false), ".stl" },
        { stlCube(true), ".STL" }, { asciiPLYCube().substr(0, asciiPLYCube().size() - 1), ".ply" }, { objCube(), ".obj" }, { objCube(true), ".Obj" } };
    for (int i = 0; i < 8; ++i)
    {
        const MeshFile file(files[i].content, files[i].extension);
        expectCube(loadMesh(file.name), format("file %d (%s)", i, files[i].extension));
    }
}

// A square pyramid of height 3 on [0, 2]^2, in forms other programs write.
void expectPyramid(const std::string& content, const char* extension)
{
    const MeshFile file(content, extension);
    Mesh mesh;
    ASSERT_NO_THROW(mesh = loadMesh(file.name)) << content;
    ASSERT_EQ(6u, mesh.triangles.size()) << content;
    double volume = 0;
    for (size_t i = 0; i < mesh.triangles.size(); ++i)
    {
        const Vec3i& t = mesh.triangles[i];
        volume += Vec3d(Point3d(mesh.vertices[t[0]])).dot(Vec3d(Point3d(mesh.vertices[t[1]])).cross(Vec3d(Point3d(mesh.vertices[t[2]])))) / 6;
    }
    EXPECT_NEAR(4, volume, 1e-5) << content;   // float rounding
}

TEST(SurgTrack_Mesh, formsOfOtherProgramsAreRead)
{
    const std::string points = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nv 1 1 3\nvt 0 0\nvn 0 0 1\n";
    expectPyramid(points + "f 1 4 3 \\\n 2\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n", ".obj");
    expectPyramid(points + "f 1//1 4//1 3//1 2//1\nf 1/1/1 2/1/1 5/1/1\nf 2 3 5\nf 3/1 4/1 5/1\nf 4/1/ 1// -1\n", ".obj");
    const std::string head = "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\nelement face 5\n";
    const std::string corners = "end_header\n0 0 0\n2 0 0\n2 2 0\n0 2 0\n1 1 3\n";
    expectPyramid(head + "property list uchar int vertex_index\n" + corners + "4 0 3 2 1\n3 0 1 4\n3 1 2 4\n3 2 3 4\n3 3 0 4\n", ".ply");
    expectPyramid(head + "property list uchar int vertex_indices\nproperty list uchar float texcoord\n" + corners
                  + "4 0 3 2 1 8 0 0 0 1 1 1 1 0\n3 0 1 4 6 0 0 1 0 0 1\n3 1 2 4 6 0 0 1 0 0 1\n3 2 3 4 6 .1 0 1 0 0 1\n3 3 0 4 0\n", ".ply");
}

TEST(SurgTrack_Mesh, colladaIsReadInItsUnitAndAxes)
{
    const String dae =
        "<?xml version=\"1.0\"?><COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\"><asset><unit meter=\"0.001\"/>"
        "<up_axis>Z_UP</up_axis></asset><library_geometries><geometry id=\"g\"><mesh><source id=\"p\"><float_array id=\"a\" count=\"15\">"
        "0 0 0 2 0 0 2 2 0 0 2 0 1 1 3</float_array><technique_common><accessor source=\"#a\" count=\"5\" stride=\"3\"><param name=\"X\" type=\"float\"/>"
        "<param name=\"Y\" type=\"float\"/><param name=\"Z\" type=\"float\"/></accessor></technique_common></source><vertices id=\"v\"><input "
        "semantic=\"POSITION\" source=\"#p\"/></vertices><polylist count=\"5\"><input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/>"
        "<vcount>4 3 3 3 3</vcount><p>0 3 2 1 0 1 4 1 2 4 2 3 4 3 0 4</p></polylist></mesh></geometry></library_geometries><library_visual_scenes>"
        "<visual_scene id=\"s\"><node><translate>0 0 5</translate><instance_geometry url=\"#g\"/></node></visual_scene></library_visual_scenes>"
        "<scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>";
    const MeshFile file(dae, ".dae");
    const Mesh mesh = loadMesh(file.name);
    ASSERT_EQ(6u, mesh.triangles.size());
    Point3f low = mesh.vertices[0], high = low;
    for (size_t i = 0; i < mesh.vertices.size(); ++i)
    {
        low = Point3f(std::min(low.x, mesh.vertices[i].x), std::min(low.y, mesh.vertices[i].y), std::min(low.z, mesh.vertices[i].z));
        high = Point3f(std::max(high.x, mesh.vertices[i].x), std::max(high.y, mesh.vertices[i].y), std::max(high.z, mesh.vertices[i].z));
    }
    EXPECT_LT(cv::norm(low - Point3f(0, 0, 0.005f)) + cv::norm(high - Point3f(0.002f, 0.002f, 0.008f)), 1e-8) << "metres, and z is up: " << low << high;
}

TEST(SurgTrack_Mesh, binaryPLYMayBeginWithALineFeed)
{
    // The first byte of the first number is a line feed.
    std::string data = binaryPLYCube(false);
    const size_t body = data.find("end_header\n") + 11;
    data[body] = '\n';
    const MeshFile file(data, ".ply");
    EXPECT_EQ(12u, loadMesh(file.name).triangles.size());
}

TEST(SurgTrack_Mesh, flatPartsCutFinelyKeepTheirCorners)
{
    std::ostringstream obj;   // a plate of 100 x 100 squares
    const int n = 100;
    for (int i = 0; i <= n; ++i)
        for (int k = 0; k <= n; ++k)
            obj << "v " << i << ' ' << k << " 0\n";
    for (int i = 0; i < n; ++i)
        for (int k = 0; k < n; ++k)
            obj << "f " << 1 + i * (n + 1) + k << ' ' << 1 + (i + 1) * (n + 1) + k << ' ' << 2 + (i + 1) * (n + 1) + k << ' ' << 2 + i * (n + 1) + k << '\n';
    const MeshFile file(obj.str(), ".obj");
    const Mesh mesh = loadMesh(file.name, 1, Matx44d::eye(), 200);
    EXPECT_LE(mesh.triangles.size(), 200u);
    double area = 0;
    for (size_t i = 0; i < mesh.triangles.size(); ++i)
    {
        const Vec3i& t = mesh.triangles[i];
        area += cv::norm((mesh.vertices[t[1]] - mesh.vertices[t[0]]).cross(mesh.vertices[t[2]] - mesh.vertices[t[0]])) / 2;
    }
    EXPECT_NEAR(n * n, area, 1e-3 * n * n) << "no hole, nothing folded, no corner lost";
}

TEST(SurgTrack_Mesh, stlMayBeInCapitals)
{
    std::string text = stlCube(false);
    std::transform(text.begin(), text.end(), text.begin(), [](char c) { return (char)std::toupper((uchar)c); });
    const MeshFile file(text, ".stl");
    expectCube(loadMesh(file.name), "capitals");
}

TEST(SurgTrack_Mesh, stlMayBeginAndEndInOtherWays)
{
    const MeshFile spaced("  \n" + stlCube(false), ".stl"), padded(stlCube(true) + "twelve bytes", ".stl");
    expectCube(loadMesh(spaced.name), "spaces before");
    expectCube(loadMesh(padded.name), "bytes behind");
    const MeshFile words(replaced(stlCube(false), "endsolid", "end solid"), ".stl"), filled(stlCube(true) + std::string(300, '\0'), ".stl");
    expectCube(loadMesh(words.name), "two words");
    expectCube(loadMesh(filled.name), "filled up");
    EXPECT_NE("", errorOf(stlCube(true) + std::string(300, 'x'), ".stl"));   // may be more triangles than it says
}

TEST(SurgTrack_Mesh, scaleThenPoseAreApplied)
{
    const MeshFile file(objCube(), ".obj");
    const Matx44d link_T_mesh(0, -1, 0, 5, 0, 0, 1, 6, -1, 0, 0, 7, 0, 0, 0, 1);
    const Mesh mesh = loadMesh(file.name, 0.5, link_T_mesh);
    Point3f low(9, 9, 9), high(-9, -9, -9);
    for (size_t i = 0; i < mesh.vertices.size(); ++i)
    {
        const Point3f v = mesh.vertices[i];
        low = Point3f(std::min(low.x, v.x), std::min(low.y, v.y), std::min(low.z, v.z));
        high = Point3f(std::max(high.x, v.x), std::max(high.y, v.y), std::max(high.z, v.z));
    }
    EXPECT_EQ(Point3f(4, 6, 6), low);
    EXPECT_EQ(Point3f(5, 7, 7), high);
    EXPECT_THROW(loadMesh(file.name, 0), cv::Exception);
    EXPECT_THROW(loadMesh(file.name, 1, Matx44d::all(1)), cv::Exception);
    EXPECT_THROW(loadMesh(file.name, 1, Matx44d::eye(), -1), cv::Exception);
}

TEST(SurgTrack_Mesh, everyTruncationIsReported)
{
    const std::string binary[] = { binaryPLYCube(false), stlCube(true) };
    const char* const extensions[] = { ".ply", ".stl" };
    for (int i = 0; i < 2; ++i)
        for (size_t length = 0; length < binary[i].size(); ++length)
            EXPECT_NE("", errorOf(binary[i].substr(0, length), extensions[i])) << extensions[i] << " cut to " << length << " bytes";
    // The last number of a text may lose digits unnoticed; less than that may not.
    const std::string text = asciiPLYCube(), stl = stlCube(false), obj = objCube();
    for (size_t length = 0; length < text.size() - 2; ++length)
        EXPECT_NE("", errorOf(text.substr(0, length), ".ply")) << "text PLY cut to " << length << " bytes";
    for (size_t length = 0; length < stl.find("endsolid"); length += 7)
        EXPECT_NE("", errorOf(stl.substr(0, length), ".stl")) << "text STL cut to " << length << " bytes";
    EXPECT_NE("", errorOf(obj.substr(0, obj.rfind("f ") + 5), ".obj"));
    EXPECT_NE("", errorOf(obj.substr(0, obj.find("f ")), ".obj"));
}

TEST(SurgTrack_Mesh, brokenContentIsReportedByReason)
{
    const struct { std::string content; const char* extension; const char* reason; } files[] = {
        { replaced(asciiPLYCube(), "2 2 2", "2 nan 2"), ".ply", "finite" },
        { replaced(asciiPLYCube(), "2 2 2", "2 inf 2"), ".ply", "finite" },
        { replaced(asciiPLYCube(), "2 2 2", "2 two 2"), ".ply", "expected a number" },
        { replaced(asciiPLYCube(), "4 0 2 3 1", "4 0 2 8 1"), ".ply", "vertex 8" },
        { replaced(asciiPLYCube(), "4 0 2 3 1", "4 0 -2 3 1"), ".ply", "vertex -2" },
        { replaced(asciiPLYCube(), "4 0 2 3 1", "-4 0 2 3 1"), ".ply", "its count is -4" },
        { replaced(asciiPLYCube(), "ascii", "klingon"), ".ply", "klingon" },
        { replaced(asciiPLYCube(), "float x", "floot x"), ".ply", "floot" },
        { replaced(asciiPLYCube(), "face 6", "face 0"), ".ply", "at least one triangle" },
        { replaced(asciiPLYCube(), "face 6", "face -6"), ".ply", "face -6" },
        { replaced(asciiPLYCube(), "vertex_indices", "neighbours"), ".ply", "vertex_indices" },
        { replaced(asciiPLYCube(), "float y", "float q"), ".ply", "`y`" },
        { replaced(asciiPLYCube(), "element face 6\nproperty list uchar int vertex_indices\n", ""), ".ply", "vertex_indices" },
        { replaced(asciiPLYCube(), "end_header", "\nend_header"), ".ply", "unknown line" },
        { replaced(asciiPLYCube(), "4 0 2 3 1\n", "4 0 2 3\n1 "), ".ply", "line of its own" },
        { replaced(asciiPLYCube(), "4 0 2 3 1", "2 0 2"), ".ply", "at least three vertices" },
        { replaced(asciiPLYCube(), "uchar int", "uchar float"), ".ply", "uchar float" },
        { replaced(binaryPLYCube(false), "vertex 8", "vertex 2000000000"), ".ply", "truncated" },
        { replaced(stlCube(false), "vertex 2 2 2", "vertex 2 nan 2"), ".stl", "finite" },
        { replaced(stlCube(false), "vertex 2 2 2", "vertex 2 2"), ".stl", "number" },
        { "solid nothing\nendsolid nothing\n", ".stl", "at least one triangle" },
        { std::string(84, '\0'), ".stl", "at least one triangle" },
        { "hello", ".stl", "STL" },
        { replaced(objCube(), "v 2 2 2", "v 2 nan 2"), ".obj", "finite" },
        { replaced(objCube(), "v 2 2 2", "v 2 2"), ".obj", "line 9" },
        { replaced(objCube(), "f 1/1", "f 9/1"), ".obj", "9/1" },
        { replaced(objCube(), "f 1/1", "f 1/2"), ".obj", "1/2" },
        { replaced(objCube(), "f 1/1", "f x"), ".obj", "x" },
        { replaced(objCube(), "f 1/1", "f 1/1/1"), ".obj", "1/1/1" },
        { replaced(objCube(), "f 1/1", "f /1"), ".obj", "`/1`" },
        { replaced(objCube(), "f 1/1", "f 1/1///"), ".obj", "`1/1///`" },
        { "# nothing\n", ".obj", "at least one triangle" },
        { "", ".ply", "ply" },
        { "ISO-10303-21;\nHEADER;\n", ".step", "export these as STL" },
        { "ISO-10303-21;\nHEADER;\n" + std::string(100, ' '), ".stl", "export these as STL" },
        { asciiPLYCube(), ".vtk", ".ply, .stl, .obj" } };
    for (size_t i = 0; i < sizeof(files) / sizeof(files[0]); ++i)
    {
        const String error = errorOf(files[i].content, files[i].extension);
        EXPECT_NE(String::npos, error.find(files[i].reason)) << "case " << i << " " << files[i].extension << ": expected `" << files[i].reason
                                                             << "`, got `" << error << "`";
    }
}

TEST(SurgTrack_Mesh, missingFileIsReported)
{
    const String names[] = { cv::tempfile(".ply"), "/", "." };
    for (int i = 0; i < 3; ++i)
        try
        {
            loadMesh(names[i]);
            ADD_FAILURE() << names[i] << " was read";
        }
        catch (const cv::Exception& e)
        {
            EXPECT_EQ(Error::StsObjectNotFound, e.code);
            EXPECT_NE(String::npos, e.err.find(names[i]));
        }
}

TEST(SurgTrack_Mesh, nothingIsPrinted)
{
    testing::internal::CaptureStderr();
    testing::internal::CaptureStdout();
    errorOf(replaced(asciiPLYCube(), "end_header", "\nend_header"), ".ply");
    errorOf(replaced(stlCube(false), "outer loop", "outer lip"), ".stl");
    errorOf(replaced(objCube(), "f 1/1", "f x"), ".obj");
    errorOf(binaryPLYCube(true).substr(0, 300), ".ply");
    errorOf(stlCube(true).substr(0, 300), ".stl");
    errorOf(replaced(asciiPLYCube(), "2 2 2", "2 nan 2"), ".ply");
    EXPECT_EQ("", testing::internal::GetCapturedStdout());
    EXPECT_EQ("", testing::internal::GetCapturedStderr());
}

TEST(SurgTrack_Mesh, decimatedSphereStaysOnTheSphere)
{
    // Rows of latitude, one vertex a pole: 2 * 120 * 119 triangles.
    std::ostringstream obj;
    const int rows = 120, columns = 120;
    obj.precision(9);
    obj << "v 0 0 1\nv 0 0 -1\n";
    for (int r = 1; r < rows; ++r)
        for (int c = 0; c < columns; ++c)
        {
            const double polar = CV_PI * r / rows, around = CV_2PI * c / columns;
            obj << "v " << std::sin(polar) * std::cos(around) << ' ' << std::sin(polar) * std::sin(around) << ' ' << std::cos(polar) << '\n';
        }
    for (int c = 0; c < columns; ++c)
    {
        const int next = (c + 1) % columns, last = 3 + (rows - 2) * columns;
        obj << "f 1 " << 3 + c << ' ' << 3 + next << "\nf 2 " << last + next << ' ' << last + c << '\n';
        for (int r = 0; r + 2 < rows; ++r)
            obj << "f " << 3 + r * columns + c << ' ' << 3 + (r + 1) * columns + c << ' ' << 3 + (r + 1) * columns + next << ' '
                << 3 + r * columns + next << '\n';
    }
    const MeshFile file(obj.str(), ".obj");
    const Mesh full = loadMesh(file.name), mesh = loadMesh(file.name, 1, Matx44d::eye(), 3000);
    EXPECT_EQ(2u * columns * (rows - 1), full.triangles.size());
    EXPECT_LE(mesh.triangles.size(), 3000u);
    EXPECT_GE(mesh.triangles.size(), 2900u);
    RNG rng(1);
    // 3000 triangles of edge 0.1, their corners on the unit sphere, leave gaps of 0.1^2 / 6 = 1.6e-3 by geometry; three times that.
    EXPECT_LT(surfaceDistances(full, mesh, 2000, rng).back(), 5e-3);
    int outward = 0;
    for (size_t i = 0; i < mesh.vertices.size(); ++i)
        outward += mesh.vertices[i].dot(mesh.normals[i]) > 0.95;   // facets of 0.1 rad, uneven
    EXPECT_GE(outward, (int)mesh.vertices.size() - 6) << "but for the corners of a sliver or two";
}

TEST(SurgTrack_Mesh, decimationOfARealToolKeepsItsSurface)
{
    const String filename = recorded("tools/large_needle_driver/large_needle_driver.yaml");
    const int64 start = getTickCount();
    const Ptr<ToolModel> full = ToolModel::load(filename, 0), tool = ToolModel::load(filename, 20000);
    const double seconds = (getTickCount() - start) / getTickFrequency();
    RNG rng(1);
    size_t triangles = 0;
    for (size_t i = 0; i < tool->meshes().size(); ++i)
    {
        const Mesh &a = full->meshes()[i], &b = tool->meshes()[i];
        triangles += b.triangles.size();
        const std::vector<double> lost = surfaceDistances(a, b, 600, rng), added = surfaceDistances(b, a, 200, rng);
        const double worst = std::max(lost.back(), added.back());
        printf("mesh %d: %d -> %d triangles, off by at most %.4f mm, 99 %% within %.4f mm\n", (int)i, (int)a.triangles.size(),
               (int)b.triangles.size(), 1e3 * worst, 1e3 * std::max(lost[lost.size() * 99 / 100], added[added.size() * 99 / 100]));
        EXPECT_LT(worst, 0.03e-3) << "a quarter of a pixel at 100 mm and f = 800";
    }
    EXPECT_LE(triangles, 20000u);
    EXPECT_GE(triangles, 19900u);
    printf("read twice, decimated once: %.0f ms\n", 1e3 * seconds);
}

}} // namespace opencv_test
