// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "mesh_io.hpp"

#include <cctype>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "opencv2/core/utils/filesystem.hpp"

#include <vtkCallbackCommand.h>
#include <vtkCellArray.h>
#include <vtkCleanPolyData.h>
#include <vtkExecutive.h>
#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkOBJReader.h>
#include <vtkPLYReader.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataNormals.h>
#include <vtkQuadricDecimation.h>
#include <vtkSTLReader.h>
#include <vtkSmartPointer.h>
#include <vtkTriangleFilter.h>

namespace cv { namespace surgtrack {

namespace {

const double FEATURE_ANGLE = 35;   // [degree]; sharper edges are creases

// VTK's readers deliver what they could make of a damaged file, or read beyond its end. So files are checked before VTK sees
// them, and what VTK read is compared with what the file promises.
class MeshFileChecker
{
public:
    explicit MeshFileChecker(const String& filename) : filename_(filename), pos_(0), faces_(-1), vertices_(-1)
    {
        std::ifstream file;
        if (!utils::fs::isDirectory(filename))
            file.open(filename.c_str(), std::ios::binary);
        if (!file.is_open())
            CV_Error(Error::StsObjectNotFound, filename + ": expected a mesh file that can be read");
        std::ostringstream content;
        content << file.rdbuf();
        data_ = content.str();
    }

    void checkPLY();
    void checkSTL();
    void checkOBJ();

    //! Compares with what the file promises; -1 = not known.
    void checkCounts(vtkIdType vertices, vtkIdType faces) const
    {
        if (vertices_ >= 0 && vertices != vertices_)
            fail(format("expected %lld vertices, read %lld", (long long)vertices_, (long long)vertices));
        if (faces_ >= 0 && faces != faces_)
            fail(format("expected %lld faces, read %lld", (long long)faces_, (long long)faces));
    }

    const std::string& content() const { return data_; }

    void fail(const String& what) const { CV_Error(Error::StsParseError, filename_ + ": " + what); }

private:
    struct Type { int size; bool isInteger, isSigned; };
    struct Property { String name; Type count, value; };   // count.size 0: not a list
    struct Element { String name; int64 count; std::vector<Property> properties; };

    std::vector<Element> readPLYHeader(String& plyFormat);
    void needPLYProperty(const std::vector<Element>& elements, const char* element, const char* property, bool list) const;
    static Type plyType(const String& name);
    void checkPLYFace(const int64* indices, int64 count) const;
    void checkTextElement(const Element& element, bool faces);
    void checkBinaryElement(const Element& element, bool faces, bool bigEndian);
    double nextNumber();
    int64 nextInteger(const Type& type, bool bigEndian);

    bool nextLine(String& line)
    {
        if (pos_ >= data_.size())
            return false;
        const size_t end = std::min(data_.find('\n', pos_), data_.size());
        line = data_.substr(pos_, end - pos_);
        if (!line.empty() && line[line.size() - 1] == '\r')
            line.resize(line.size() - 1);
        pos_ = end + 1;
        return true;
    }

    String checkOBJCorner(const String& corner, const int64* count, int line) const;

    // vtkPLYReader stumbles over characters that are white space to others.
    void nextPLYLine(String& line, const char* expected)
    {
        if (!nextLine(line))
            fail(String("truncated: expected ") + expected);
        for (size_t i = 0; i < line.size(); ++i)
            if ((uchar)line[i] < ' ' && line[i] != '\t')
                fail("expected text, found `" + line.substr(0, 40) + "`");
    }

    void need(int64 bytes) const
    {
        if (bytes > (int64)data_.size() - (int64)pos_)
            fail(format("truncated: expected %lld bytes more than its %lld", (long long)(bytes - ((int64)data_.size() - (int64)pos_)),
                        (long long)data_.size()));
    }

    String filename_;
    std::string data_;
    size_t pos_;
    int64 faces_, vertices_;
};

MeshFileChecker::Type MeshFileChecker::plyType(const String& name)
{
    static const char* const names[] = { "char", "int8", "uchar", "uint8", "short", "int16", "ushort", "uint16",
                                         "int", "int32", "uint", "uint32", "float", "float32", "double", "float64" };
    Type type = { 0, false, false };
    for (int i = 0; i < 16; ++i)
        if (name == names[i])
        {
            type.size = i < 4 ? 1 : i < 8 ? 2 : i < 14 ? 4 : 8;
            type.isInteger = i < 12;
            type.isSigned = i % 4 < 2;
        }
    return type;
}

std::vector<MeshFileChecker::Element> MeshFileChecker::readPLYHeader(String& plyFormat)
{
    std::vector<Element> elements;
    String line;
    nextPLYLine(line, "`ply`");
    if (line != "ply")
        fail("expected a PLY file (first line `ply`)");
    while (true)
    {
        nextPLYLine(line, "`end_header`");
        std::istringstream words(line);
        String word, type, countType;
        words >> word;
        if (word == "end_header")
            return elements;
        if (word == "format")
            words >> plyFormat;
        else if (word == "element")
        {
            Element e;
            e.count = -1;
            words >> e.name >> e.count;
            if (e.count < 0 || e.count > INT_MAX)
                fail("expected `element NAME COUNT`, found `" + line + "`");
            elements.push_back(e);
        }
        else if (word == "property")
        {
            Property p = { String(), plyType(String()), plyType(String()) };
            words >> type;
            const bool list = type == "list";
            if (list)
            {
                words >> countType >> type;
                p.count = plyType(countType);
            }
            p.value = plyType(type);
            words >> p.name;
            if (elements.empty() || !p.value.size || (list && !p.count.isInteger) || (p.name == "vertex_indices" && !p.value.isInteger))
                fail("expected `property TYPE NAME` or `property list TYPE TYPE NAME` of an element, found `" + line + "`");
            elements.back().properties.push_back(p);
        }
        else if (word != "comment" && word != "obj_info")
            fail("unknown line `" + line + "` in the header");
    }
}

// Without one of them vtkPLYReader crashes.
void MeshFileChecker::needPLYProperty(const std::vector<Element>& elements, const char* element, const char* property, bool list) const
{
    for (size_t e = 0; e < elements.size(); ++e)
        for (size_t p = 0; elements[e].name == element && p < elements[e].properties.size(); ++p)
            if (elements[e].properties[p].name == property && (elements[e].properties[p].count.size > 0) == list)
                return;
    fail(format("expected %s `%s` of element `%s` in the header", list ? "a list" : "a number", property, element));
}

double MeshFileChecker::nextNumber()
{
    while (pos_ < data_.size() && std::isspace((uchar)data_[pos_]))
        ++pos_;
    need(1);
    char* end = 0;
    const double value = std::strtod(data_.c_str() + pos_, &end);
    const size_t newPos = end - data_.c_str();
    if (newPos == pos_ || (newPos < data_.size() && !std::isspace((uchar)*end)))
        fail("expected a number, found `" + data_.substr(pos_, 16) + "`");
    pos_ = newPos;
    return value;
}

int64 MeshFileChecker::nextInteger(const Type& type, bool bigEndian)
{
    need(type.size);
    int64 value = 0;
    for (int i = 0; i < type.size; ++i)
        value |= (int64)(uchar)data_[pos_ + i] << 8 * (bigEndian ? type.size - 1 - i : i);
    pos_ += type.size;
    const int64 signBit = (int64)1 << (8 * type.size - 1);
    return type.isSigned && (value & signBit) ? value - 2 * signBit : value;
}

void MeshFileChecker::checkPLYFace(const int64* indices, int64 count) const
{
    if (count < 3)
        fail(format("expected at least three vertices in each face, found %lld", (long long)count));
    for (int64 k = 0; k < count; ++k)
        if (indices[k] < 0 || indices[k] >= vertices_)
            fail(format("a face names vertex %lld of %lld", (long long)indices[k], (long long)vertices_));
}

// vtkPLYReader takes a line for an element, whatever is in it.
void MeshFileChecker::checkTextElement(const Element& element, bool faces)
{
    const size_t begin = pos_;
    String line;
    nextPLYLine(line, format("%lld elements `%s`", (long long)element.count, element.name.c_str()).c_str());
    const size_t next = pos_, end = begin + line.size();
    pos_ = begin;
    std::vector<int64> indices;
    for (size_t p = 0; p < element.properties.size(); ++p)
    {
        const Property& property = element.properties[p];
        const double count = property.count.size ? nextNumber() : 1;
        if (count < 0 || count != std::floor(count))
            fail(format("expected a list in element `%s`, its count is %g", element.name.c_str(), count));
        indices.clear();
        for (double k = 0; k < count; ++k)
            indices.push_back(saturate_cast<int>(nextNumber()));
        if (faces && property.name == "vertex_indices")
            checkPLYFace(indices.data(), (int64)indices.size());
    }
    if (pos_ > end || data_.find_first_not_of(" \t", pos_) < end)
        fail(format("expected each element `%s` on a line of its own, found `%s`", element.name.c_str(), line.substr(0, 40).c_str()));
    pos_ = next;
}

void MeshFileChecker::checkBinaryElement(const Element& element, bool faces, bool bigEndian)
{
    std::vector<int64> indices;
    for (size_t p = 0; p < element.properties.size(); ++p)
    {
        const Property& property = element.properties[p];
        const int64 count = property.count.size ? nextInteger(property.count, bigEndian) : 1;
        if (count < 0)
            fail(format("expected a list in element `%s`, its count is negative", element.name.c_str()));
        need(count * property.value.size);
        if (faces && property.name == "vertex_indices")
        {
            indices.clear();
            for (int64 k = 0; k < count; ++k)
                indices.push_back(nextInteger(property.value, bigEndian));
            checkPLYFace(indices.data(), count);
        }
        else
            pos_ += (size_t)(count * property.value.size);
    }
}

void MeshFileChecker::checkPLY()
{
    String plyFormat;
    const std::vector<Element> elements = readPLYHeader(plyFormat);
    const bool ascii = plyFormat == "ascii", bigEndian = plyFormat == "binary_big_endian";
    if (!ascii && !bigEndian && plyFormat != "binary_little_endian")
        fail("expected format ascii, binary_little_endian or binary_big_endian, found `" + plyFormat + "`");
    needPLYProperty(elements, "vertex", "x", false);
    needPLYProperty(elements, "vertex", "y", false);
    needPLYProperty(elements, "vertex", "z", false);
    needPLYProperty(elements, "face", "vertex_indices", true);
    for (size_t e = 0; e < elements.size(); ++e)
    {
        int64* const known = elements[e].name == "vertex" ? &vertices_ : elements[e].name == "face" ? &faces_ : 0;
        if (known && *known >= 0)
            fail("expected element `" + elements[e].name + "` once");
        if (known)
            *known = elements[e].count;
    }
    for (size_t e = 0; e < elements.size(); ++e)
        for (int64 i = 0; i < elements[e].count; ++i)
        {
            if (ascii)
                checkTextElement(elements[e], elements[e].name == "face");
            else
                checkBinaryElement(elements[e], elements[e].name == "face", bigEndian);
        }
}

void MeshFileChecker::checkSTL()
{
    // A binary file may begin with "solid" as well; only its size tells.
    int64 expectedSize = 0, triangles = 0;
    if (data_.size() >= 84)
    {
        pos_ = 80;
        triangles = nextInteger(plyType("uint32"), false);
        expectedSize = 84 + 50 * triangles;
    }
    if (expectedSize && (int64)data_.size() == expectedSize)
    {
        faces_ = triangles;
        return;
    }
    if (data_.compare(0, 5, "solid") != 0)
    {
        if (data_.size() < 84)
            fail("expected an STL file: `solid`, or at least 84 bytes");
        fail(format("expected %lld bytes for a binary STL file of %lld triangles, found %lld", (long long)expectedSize,
                    (long long)triangles, (long long)data_.size()));
    }
    int64 facets = 0, ends = 0, vertices = 0, solids = 0;
    pos_ = 0;
    String line, word;
    while (nextLine(line))
    {
        word.clear();
        std::istringstream words(line);
        words >> word;
        facets += word == "facet";
        ends += word == "endfacet";
        solids += word == "endsolid";
        if (word == "vertex")
        {
            ++vertices;
            const size_t next = pos_;
            pos_ = next - line.size() - 1 + line.find("vertex") + 6;
            for (int k = 0; k < 3; ++k)
                nextNumber();
            pos_ = next;
        }
    }
    if (!solids || facets != ends || vertices != 3 * facets)
        fail(format("truncated: expected `endsolid`, and an `endfacet` and three vertices for each of %lld facets", (long long)facets));
    faces_ = facets;
}

// A corner of a face: v, v/vt, v//vn or v/vt/vn. @return which of these
String MeshFileChecker::checkOBJCorner(const String& corner, const int64* count, int line) const
{
    static const char* const names[] = { "v", "vt", "vn" };
    String form;
    const char* c = corner.c_str();
    for (int k = 0; k < 3; ++k)
    {
        char* end = 0;
        const long long index = std::strtoll(c, &end, 10);
        const bool omitted = k == 1 && *c == '/', last = !*end;
        if ((*end && (*end != '/' || k == 2)) || (!omitted && (end == c || index == 0 || index > count[k] || index < -count[k])))
            break;
        form += omitted ? "" : names[k];
        if (last)
            return form;
        form += "/";
        c = (omitted ? c : end) + 1;
    }
    fail(format("line %d: `%s` names a vertex, texture or normal that is not there", line, corner.c_str()));
    return form;
}

void MeshFileChecker::checkOBJ()
{
    int64 count[3] = { 0, 0, 0 };   // v, vt, vn
    String line, word, corner, form;
    faces_ = 0;
    for (int number = 1; nextLine(line); ++number)
    {
        word.clear();
        std::istringstream words(line);
        words >> word;
        if (word == "v")
        {
            ++count[0];
            for (int k = 0; k < 3; ++k)
            {
                char* end = 0;
                if (!(words >> corner) || !(std::abs(std::strtod(corner.c_str(), &end)) < DBL_MAX) || *end)
                    fail(format("line %d: expected three finite numbers", number));   // vtkOBJReader reads `nan` as something finite
            }
        }
        count[1] += word == "vt";
        count[2] += word == "vn";
        const int least = word == "f" ? 3 : word == "l" ? 2 : word == "p" ? 1 : 0;
        if (!least)
            continue;
        faces_ += word == "f";
        int corners = 0;
        for (; words >> corner; ++corners)
        {
            const String cornerForm = checkOBJCorner(corner, count, number);
            if (form.empty())
                form = cornerForm;
            if (form != cornerForm)
                fail(format("line %d: `%s`: expected all corners in the form of the first, %s", number, corner.c_str(), form.c_str()));
        }
        if (corners < least)
            fail(format("line %d: expected at least %d vertices", number, least));
    }
}

// With an observer VTK hands over its errors instead of printing them.
void collectError(vtkObject*, unsigned long, void* errors, void* message)
{
    if (((String*)errors)->empty() && message)
        *(String*)errors = (const char*)message;
}

vtkSmartPointer<vtkPolyData> runReader(vtkAbstractPolyDataReader* reader, const String& filename, const MeshFileChecker& checker)
{
    String errors;
    vtkNew<vtkCallbackCommand> observer;
    observer->SetCallback(collectError);
    observer->SetClientData(&errors);
    const unsigned long events[] = { vtkCommand::ErrorEvent, vtkCommand::WarningEvent };
    for (int i = 0; i < 2; ++i)
    {
        reader->AddObserver(events[i], observer);
        reader->GetExecutive()->AddObserver(events[i], observer);
    }
    reader->SetFileName(filename.c_str());
    reader->Update();
    if (!errors.empty() || reader->GetErrorCode())
        checker.fail("not readable: " + errors.substr(0, errors.find_last_not_of(" \n") + 1));
    return reader->GetOutput();
}

vtkSmartPointer<vtkPolyData> readPolyData(const String& filename)
{
    MeshFileChecker checker(filename);
    const size_t dot = filename.rfind('.');
    String extension = dot == String::npos ? String() : filename.substr(dot + 1);
    for (size_t i = 0; i < extension.size(); ++i)
        extension[i] = (char)std::tolower((uchar)extension[i]);

    vtkSmartPointer<vtkPolyData> data;
    if (extension == "ply")
    {
        checker.checkPLY();
        vtkNew<vtkPLYReader> reader;
        reader->ReadFromInputStringOn();
        reader->SetInputString(checker.content() + "\n");   // a text that ends without a line feed crashes it
        data = runReader(reader, filename, checker);
    }
    else if (extension == "stl")
    {
        checker.checkSTL();
        vtkNew<vtkSTLReader> reader;
        reader->MergingOff();
        data = runReader(reader, filename, checker);
    }
    else if (extension == "obj")
    {
        checker.checkOBJ();
        data = runReader(vtkNew<vtkOBJReader>(), filename, checker);
    }
    else
        checker.fail("expected a file name ending in .ply, .stl or .obj");
    checker.checkCounts(data->GetNumberOfPoints(), data->GetNumberOfPolys());

    for (vtkIdType i = 0; i < data->GetNumberOfPoints(); ++i)
    {
        double p[3];
        data->GetPoint(i, p);
        if (!(std::abs(p[0]) + std::abs(p[1]) + std::abs(p[2]) < DBL_MAX))
            checker.fail(format("expected finite numbers, vertex %lld is not", (long long)i));
    }
    vtkIdType n;
    const vtkIdType* ids;
    vtkCellArray* polys = data->GetPolys();
    for (polys->InitTraversal(); polys->GetNextCell(n, ids); )
        for (vtkIdType k = 0; k < n; ++k)
            if (ids[k] < 0 || ids[k] >= data->GetNumberOfPoints())
                checker.fail(format("a face names vertex %lld of %lld", (long long)ids[k], (long long)data->GetNumberOfPoints()));
    return data;
}

vtkSmartPointer<vtkPolyData> toPolyData(const Mesh& mesh)
{
    vtkNew<vtkPoints> points;
    points->SetNumberOfPoints((vtkIdType)mesh.vertices.size());
    for (size_t i = 0; i < mesh.vertices.size(); ++i)
        points->SetPoint((vtkIdType)i, mesh.vertices[i].x, mesh.vertices[i].y, mesh.vertices[i].z);
    vtkNew<vtkCellArray> polys;
    for (size_t i = 0; i < mesh.triangles.size(); ++i)
    {
        const vtkIdType ids[] = { mesh.triangles[i][0], mesh.triangles[i][1], mesh.triangles[i][2] };
        polys->InsertNextCell(3, ids);
    }
    vtkSmartPointer<vtkPolyData> data = vtkSmartPointer<vtkPolyData>::New();
    data->SetPoints(points);
    data->SetPolys(polys);
    return data;
}

// Takes vertices, triangles and, if there are any, normals; triangles with a vertex twice are dropped.
void fromPolyData(vtkPolyData* data, Mesh& mesh)
{
    mesh = Mesh();
    for (vtkIdType i = 0; i < data->GetNumberOfPoints(); ++i)
    {
        double p[3];
        data->GetPoint(i, p);
        mesh.vertices.push_back(Point3f((float)p[0], (float)p[1], (float)p[2]));
    }
    vtkIdType n;
    const vtkIdType* ids;
    vtkCellArray* polys = data->GetPolys();
    for (polys->InitTraversal(); polys->GetNextCell(n, ids); )
        if (n == 3 && ids[0] != ids[1] && ids[1] != ids[2] && ids[2] != ids[0])
            mesh.triangles.push_back(Vec3i((int)ids[0], (int)ids[1], (int)ids[2]));
    vtkDataArray* normals = data->GetPointData()->GetNormals();
    for (vtkIdType i = 0; normals && i < normals->GetNumberOfTuples(); ++i)
    {
        double p[3];
        normals->GetTuple(i, p);
        mesh.normals.push_back(Point3f((float)p[0], (float)p[1], (float)p[2]));
    }
}

bool isClosed(vtkPolyData* data)
{
    std::vector<std::pair<vtkIdType, vtkIdType> > edges;
    vtkIdType n;
    const vtkIdType* ids;
    vtkCellArray* polys = data->GetPolys();
    for (polys->InitTraversal(); polys->GetNextCell(n, ids); )
        for (vtkIdType k = 0; k < n; ++k)
            edges.push_back(std::minmax(ids[k], ids[(k + 1) % n]));
    std::sort(edges.begin(), edges.end());
    for (size_t i = 0; i < edges.size(); i += 2)
        if (i + 1 == edges.size() || edges[i] != edges[i + 1])
            return false;
    return !edges.empty();
}

} // namespace

Mesh readMesh(const String& filename, double scale, const Matx44d& link_T_mesh)
{
    CV_CheckGT(scale, 0., "scale: metres per unit of the mesh file");
    CV_Assert(isRigid(link_T_mesh));
    vtkNew<vtkTriangleFilter> triangles;
    triangles->SetInputData(readPolyData(filename));
    triangles->PassVertsOff();
    triangles->PassLinesOff();
    vtkNew<vtkCleanPolyData> clean;
    clean->SetInputConnection(triangles->GetOutputPort());
    clean->SetTolerance(0);
    clean->Update();

    Mesh mesh;
    fromPolyData(clean->GetOutput(), mesh);
    mesh.normals.clear();
    if (mesh.triangles.empty())
        CV_Error(Error::StsParseError, filename + ": expected at least one triangle");
    const Matx33d R = link_T_mesh.get_minor<3, 3>(0, 0);
    const Point3d t(link_T_mesh(0, 3), link_T_mesh(1, 3), link_T_mesh(2, 3));
    for (size_t i = 0; i < mesh.vertices.size(); ++i)
        mesh.vertices[i] = R * (scale * Point3d(mesh.vertices[i])) + t;
    return mesh;
}

void decimateMeshes(std::vector<Mesh>& meshes, int maxTriangles)
{
    // All meshes go into one data set, side by side along x in slots too wide to stray from. So one queue of errors decides
    // what goes, and the triangles stay where they are needed most; measured on a tool of 80,000 triangles, the worst mesh
    // comes out several times closer than with a number of triangles for each.
    double slot = 0, triangles = 0;
    std::vector<double> centres;
    for (size_t m = 0; m < meshes.size(); ++m)
    {
        double low = DBL_MAX, high = -DBL_MAX;
        for (size_t i = 0; i < meshes[m].vertices.size(); ++i)
        {
            low = std::min(low, (double)meshes[m].vertices[i].x);
            high = std::max(high, (double)meshes[m].vertices[i].x);
        }
        centres.push_back((low + high) / 2);
        slot = std::max(slot, 2 * (high - low));
        triangles += (double)meshes[m].triangles.size();
    }
    if (triangles <= maxTriangles)
        return;
    vtkNew<vtkPoints> points;
    points->SetDataTypeToDouble();
    vtkNew<vtkCellArray> polys;
    for (size_t m = 0; m < meshes.size(); ++m)
    {
        const vtkIdType first = points->GetNumberOfPoints();
        for (size_t i = 0; i < meshes[m].vertices.size(); ++i)
        {
            const Point3d p = meshes[m].vertices[i];
            points->InsertNextPoint(p.x - centres[m] + (double)m * slot, p.y, p.z);
        }
        for (size_t i = 0; i < meshes[m].triangles.size(); ++i)
        {
            const Vec3i& t = meshes[m].triangles[i];
            const vtkIdType ids[] = { first + t[0], first + t[1], first + t[2] };
            polys->InsertNextCell(3, ids);
        }
    }
    vtkNew<vtkPolyData> all;
    all->SetPoints(points);
    all->SetPolys(polys);
    vtkNew<vtkQuadricDecimation> decimation;
    decimation->SetInputData(all);
    decimation->SetTargetReduction(1 - maxTriangles / triangles);
    decimation->VolumePreservationOn();
    decimation->Update();

    vtkPolyData* result = decimation->GetOutput();
    std::vector<std::vector<int> > newIndex(meshes.size());
    for (size_t m = 0; m < meshes.size(); ++m)
    {
        meshes[m] = Mesh();
        newIndex[m].assign((size_t)result->GetNumberOfPoints(), -1);
    }
    vtkIdType n;
    const vtkIdType* ids;
    for (result->GetPolys()->InitTraversal(); result->GetPolys()->GetNextCell(n, ids); )
    {
        double p[3];
        result->GetPoint(ids[0], p);
        const int m = std::min(std::max(cvRound(p[0] / slot), 0), (int)meshes.size() - 1);
        Vec3i triangle;
        for (int k = 0; k < 3; ++k)
        {
            int& index = newIndex[m][(size_t)ids[k]];
            if (index < 0)
            {
                result->GetPoint(ids[k], p);
                index = (int)meshes[m].vertices.size();
                meshes[m].vertices.push_back(Point3f((float)(p[0] + centres[m] - m * slot), (float)p[1], (float)p[2]));
            }
            triangle[k] = index;
        }
        meshes[m].triangles.push_back(triangle);
    }
}

void computeNormals(Mesh& mesh)
{
    vtkNew<vtkCleanPolyData> clean;
    clean->SetInputData(toPolyData(mesh));
    clean->SetTolerance(0);
    clean->Update();
    vtkNew<vtkPolyDataNormals> normals;
    normals->SetInputData(clean->GetOutput());
    normals->SetFeatureAngle(FEATURE_ANGLE);
    normals->SplittingOn();
    normals->ConsistencyOn();
    normals->SetAutoOrientNormals(isClosed(clean->GetOutput()));
    normals->Update();
    fromPolyData(normals->GetOutput(), mesh);
}

void writePLY(const String& filename, const Mesh& mesh)
{
    const int one = 1;
    const bool littleEndian = *(const char*)&one == 1;
    std::ofstream file(filename.c_str(), std::ios::binary);
    file << "ply\nformat " << (littleEndian ? "binary_little_endian" : "binary_big_endian") << " 1.0\ncomment metres\n"
         << "element vertex " << mesh.vertices.size() << "\nproperty float x\nproperty float y\nproperty float z\n"
         << "element face " << mesh.triangles.size() << "\nproperty list uchar int vertex_indices\nend_header\n";
    for (size_t i = 0; i < mesh.vertices.size(); ++i)
        file.write((const char*)&mesh.vertices[i], 3 * sizeof(float));
    for (size_t i = 0; i < mesh.triangles.size(); ++i)
    {
        file.put(3);
        file.write((const char*)mesh.triangles[i].val, 3 * sizeof(int));
    }
    file.close();
    if (!file)
        CV_Error(Error::StsError, filename + ": cannot be written");
}

Mesh loadMesh(const String& filename, double scale, const Matx44d& link_T_mesh, int maxTriangles)
{
    CV_CheckGE(maxTriangles, 0, "maxTriangles: 0 keeps all");
    std::vector<Mesh> mesh(1, readMesh(filename, scale, link_T_mesh));
    if (maxTriangles)
        decimateMeshes(mesh, maxTriangles);
    computeNormals(mesh[0]);
    return mesh[0];
}

}} // namespace cv::surgtrack
