// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "files/joint_names.hpp"
#include "files/mesh_reader.hpp"

#include <cctype>
#include <cstdlib>

namespace cv { namespace surgtrack {

MeshFileReader::Type MeshFileReader::plyType(const String& name)
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

//! Two names of the same have been in use since the format's first days.
static bool isFaceList(const String& property) { return property == "vertex_indices" || property == "vertex_index"; }

std::vector<MeshFileReader::Element> MeshFileReader::readPLYHeader(String& plyFormat)
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
            if (elements.empty() || !p.value.size || (list && !p.count.isInteger) || (isFaceList(p.name) && !p.value.isInteger))
                fail("expected `property TYPE NAME` or `property list TYPE TYPE NAME` of an element, found `" + line + "`");
            elements.back().properties.push_back(p);
        }
        else if (word != "comment" && word != "obj_info")
            fail("unknown line `" + line + "` in the header");
    }
}

void MeshFileReader::needPLYProperty(const std::vector<Element>& elements, const char* element, const char* property, bool list) const
{
    for (size_t e = 0; e < elements.size(); ++e)
        for (size_t p = 0; elements[e].name == element && p < elements[e].properties.size(); ++p)
            if ((elements[e].properties[p].name == property || (list && isFaceList(elements[e].properties[p].name))) && (elements[e].properties[p].count.size > 0) == list)
                return;
    fail(format("expected %s `%s` of element `%s` in the header", list ? "a list" : "a number", property, element));
}

double MeshFileReader::nextNumber()
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

int64 MeshFileReader::nextInteger(const Type& type, bool bigEndian)
{
    need(type.size);
    int64 value = 0;
    for (int i = 0; i < type.size; ++i)
        value |= (int64)(uchar)data_[pos_ + i] << 8 * (bigEndian ? type.size - 1 - i : i);
    pos_ += type.size;
    const int64 signBit = (int64)1 << (8 * type.size - 1);
    return type.isSigned && (value & signBit) ? value - 2 * signBit : value;
}

double MeshFileReader::nextValue(const Type& type, bool bigEndian)
{
    if (type.isInteger)
        return (double)nextInteger(type, bigEndian);
    const Type bits = { type.size, true, false };
    const uint64 value = (uint64)nextInteger(bits, bigEndian);
    Cv32suf single;
    Cv64suf twice;
    single.u = (unsigned)value;
    twice.u = value;
    return type.size == 4 ? single.f : twice.f;
}

void MeshFileReader::addFace(const std::vector<int>& corners)
{
    faces_.push_back((int)corners.size());
    faces_.insert(faces_.end(), corners.begin(), corners.end());
}

void MeshFileReader::addPLYFace(const std::vector<double>& indices, int64 vertices)
{
    if (indices.size() < 3)
        fail(format("expected at least three vertices in each face, found %d", (int)indices.size()));
    std::vector<int> corners;
    for (size_t k = 0; k < indices.size(); ++k)
    {
        if (!(indices[k] >= 0 && indices[k] < (double)vertices))
            fail(format("a face names vertex %g of %lld", indices[k], (long long)vertices));
        corners.push_back((int)indices[k]);
    }
    addFace(corners);
}

//! Of vertices x, y and z, of faces their corners; texture coordinates and colours are passed over.
void MeshFileReader::addPLYItem(const Element& element, const Property& property, const std::vector<double>& values, int64 vertices)
{
    if (element.name == "face" && property.count.size && isFaceList(property.name))
        addPLYFace(values, vertices);
    if (element.name != "vertex" || property.count.size || property.name.size() != 1)
        return;
    Point3d& p = points_.back();
    if (property.name == "x")
        p.x = values[0];
    else if (property.name == "y")
        p.y = values[0];
    else if (property.name == "z")
        p.z = values[0];
}

//! An element is a line.
void MeshFileReader::readTextElement(const Element& element, int64 vertices)
{
    const size_t begin = pos_;
    String line;
    nextPLYLine(line, format("%lld elements `%s`", (long long)element.count, element.name.c_str()).c_str());
    const size_t next = pos_, end = begin + line.size();
    pos_ = begin;
    std::vector<double> values;
    for (size_t p = 0; p < element.properties.size(); ++p)
    {
        const Property& property = element.properties[p];
        const double count = property.count.size ? nextNumber() : 1;
        if (count < 0 || count != std::floor(count))
            fail(format("expected a list in element `%s`, its count is %g", element.name.c_str(), count));
        values.clear();
        for (double k = 0; k < count; ++k)
            values.push_back(nextNumber());
        addPLYItem(element, property, values, vertices);
    }
    if (pos_ > end || data_.find_first_not_of(" \t", pos_) < end)
        fail(format("expected each element `%s` on a line of its own, found `%s`", element.name.c_str(), line.substr(0, 40).c_str()));
    pos_ = next;
}

void MeshFileReader::readBinaryElement(const Element& element, int64 vertices, bool bigEndian)
{
    std::vector<double> values;
    for (size_t p = 0; p < element.properties.size(); ++p)
    {
        const Property& property = element.properties[p];
        const int64 count = property.count.size ? nextInteger(property.count, bigEndian) : 1;
        if (count < 0)
            fail(format("expected a list in element `%s`, its count is negative", element.name.c_str()));
        need(count * property.value.size);
        values.clear();
        for (int64 k = 0; k < count; ++k)
            values.push_back(nextValue(property.value, bigEndian));
        addPLYItem(element, property, values, vertices);
    }
}

void MeshFileReader::readPLY()
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
    int64 vertices = 0;
    for (size_t e = 0; e < elements.size(); ++e)
    {
        for (size_t other = 0; other < e; ++other)
            if (elements[e].name == elements[other].name)
                fail("expected element `" + elements[e].name + "` once");
        if (elements[e].name == "vertex")
            vertices = elements[e].count;
    }
    for (size_t e = 0; e < elements.size(); ++e)
        for (int64 i = 0; i < elements[e].count; ++i)
        {
            if (elements[e].name == "vertex")
                points_.push_back(Point3d());
            if (ascii)
                readTextElement(elements[e], vertices);
            else
                readBinaryElement(elements[e], vertices, bigEndian);
        }
}

void MeshFileReader::readBinarySTL(int64 triangles)
{
    const Type number = plyType("float");
    std::vector<int> corners(3);
    pos_ = 84;
    for (int64 i = 0; i < triangles; ++i)
    {
        pos_ += 12;   // the normal
        for (int k = 0; k < 3; ++k)
        {
            Point3d p;
            p.x = nextValue(number, false);
            p.y = nextValue(number, false);
            p.z = nextValue(number, false);
            corners[k] = (int)points_.size();
            points_.push_back(p);
        }
        addFace(corners);
        pos_ += 2;
    }
}

void MeshFileReader::readSTL()
{
    // A binary file may begin with "solid" as well: its size tells, or that there are no facets in its text.
    int64 expectedSize = 0, triangles = 0;
    if (data_.size() >= 84)
    {
        pos_ = 80;
        triangles = nextInteger(plyType("uint32"), false);
        expectedSize = 84 + 50 * triangles;
    }
    const size_t start = data_.find_first_not_of(" \t\r\n");
    const bool text = start != String::npos && lowerCase(data_.substr(start, 5)) == "solid";
    const int64 size = (int64)data_.size();
    // Less than another triangle, or padding, may follow.
    const bool padded = expectedSize && size > expectedSize
                        && (size < expectedSize + 50 || data_.find_first_not_of('\0', (size_t)expectedSize) == String::npos);
    if (expectedSize && (size == expectedSize || (padded && !(text && lowerCase(data_.substr(0, 4096)).find("facet") != String::npos))))
        return readBinarySTL(triangles);
    if (text)
        return readTextSTL();
    if (data_.size() < 84)
        fail("expected an STL file: `solid`, or at least 84 bytes");
    fail(format("expected %lld bytes for a binary STL file of %lld triangles, found %lld", (long long)expectedSize, (long long)triangles,
                (long long)size));
}

void MeshFileReader::readTextSTL()
{
    int64 facets = 0, ends = 0, vertices = 0, solids = 0;
    pos_ = 0;
    String line, word, second;
    while (nextLine(line))
    {
        word.clear();
        std::istringstream words(line);
        words >> word;
        word = lowerCase(word);
        if (word == "end" && words >> second)   // `end solid` in two words
            word += lowerCase(second);
        facets += word == "facet";
        ends += word == "endfacet";
        solids += word == "endsolid";
        if (word != "vertex")
            continue;
        ++vertices;
        const size_t next = pos_;
        pos_ = next - line.size() - 1 + line.find_first_not_of(" \t") + 6;
        Point3d p;
        p.x = nextNumber();
        p.y = nextNumber();
        p.z = nextNumber();
        points_.push_back(p);
        pos_ = next;
    }
    if (!solids || facets != ends || vertices != 3 * facets)
        fail(format("truncated: expected `endsolid`, and an `endfacet` and three vertices for each of %lld facets", (long long)facets));
    std::vector<int> corners(3);
    for (int i = 0; i < (int)points_.size(); i += 3)
    {
        for (int k = 0; k < 3; ++k)
            corners[k] = i + k;
        addFace(corners);
    }
}

// A corner of a face: v, v/vt, v//vn or v/vt/vn; what is between slashes or behind the last one may be missing. @return its vertex
int MeshFileReader::readOBJCorner(const String& corner, const int64* count, int line) const
{
    int vertex = 0;
    const char* c = corner.c_str();
    for (int k = 0; k < 3; ++k)
    {
        char* end = 0;
        const long long index = std::strtoll(c, &end, 10);
        const bool omitted = k > 0 && end == c && (*c == '/' || !*c);
        if ((*end && (*end != '/' || k == 2)) || (!omitted && (end == c || index == 0 || index > count[k] || index < -count[k])))
            break;
        if (k == 0)
            vertex = (int)(index > 0 ? index - 1 : count[0] + index);
        if (!*end)
            return vertex;
        c = end + 1;
    }
    fail(format("line %d: `%s` names a vertex, texture or normal that is not there", line, corner.c_str()));
}

void MeshFileReader::readOBJVertex(std::istream& words, int line)
{
    double xyz[3];
    String word;
    for (int k = 0; k < 3; ++k)
    {
        char* end = 0;
        xyz[k] = words >> word ? std::strtod(word.c_str(), &end) : DBL_MAX;
        if (!(std::abs(xyz[k]) < DBL_MAX) || *end)
            fail(format("line %d: expected three finite numbers", line));
    }
    points_.push_back(Point3d(xyz[0], xyz[1], xyz[2]));
}

void MeshFileReader::readOBJ()
{
    int64 count[3] = { 0, 0, 0 };   // v, vt, vn
    String line, more, word, corner;
    for (int number = 1, next = 1; nextLine(line); number = next)
    {
        for (++next; !line.empty() && line[line.size() - 1] == '\\' && nextLine(more); ++next)   // goes on in the next line
            line = line.substr(0, line.size() - 1) + " " + more;
        word.clear();
        std::istringstream words(line);
        words >> word;
        if (word == "v")
            readOBJVertex(words, number);
        count[0] = (int64)points_.size();
        count[1] += word == "vt";
        count[2] += word == "vn";
        const int least = word == "f" ? 3 : word == "l" ? 2 : word == "p" ? 1 : 0;
        std::vector<int> corners;
        while (least && words >> corner)
            corners.push_back(readOBJCorner(corner, count, number));
        if ((int)corners.size() < least)
            fail(format("line %d: expected at least %d vertices", number, least));
        if (word == "f")
            addFace(corners);
    }
}

}} // namespace cv::surgtrack
