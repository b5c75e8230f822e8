// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "files/mesh_check.hpp"

#include <cctype>
#include <cstdlib>

namespace cv { namespace surgtrack {

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

}} // namespace cv::surgtrack
