// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "files/ply_reader.hpp"
#include "files/text_file.hpp"

#include <cctype>
#include <cfloat>
#include <cstdlib>

namespace cv { namespace surgtrack {

PlyReader::Type PlyReader::plyType(const String& name)
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

std::vector<PlyReader::Element> PlyReader::readHeader(String& plyFormat)
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
            if (elements.size() == 100)
                fail("expected at most 100 kinds of elements");
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
            if (elements.empty() || p.name.empty() || !p.value.size || (list && !p.count.isInteger) || (isFaceList(p.name) && !p.value.isInteger))
                fail("expected `property TYPE NAME` or `property list TYPE TYPE NAME` of an element, found `" + line + "`");
            elements.back().properties.push_back(p);
        }
        else if (word != "comment" && word != "obj_info")
            fail("unknown line `" + line + "` in the header");
    }
}

void PlyReader::needPLYProperty(const std::vector<Element>& elements, const char* element, const char* property, bool list) const
{
    for (size_t e = 0; e < elements.size(); ++e)
        for (size_t p = 0; elements[e].name == element && p < elements[e].properties.size(); ++p)
            if ((elements[e].properties[p].name == property || (list && isFaceList(elements[e].properties[p].name))) && (elements[e].properties[p].count.size > 0) == list)
                return;
    fail(format("expected %s `%s` of element `%s` in the header", list ? "a list" : "a number", property, element));
}

double PlyReader::nextNumber()
{
    while (pos_ < data_.size() && std::isspace((uchar)data_[pos_]))
        ++pos_;
    need(1);
    const char* end = 0;
    const double value = toDouble(data_.c_str() + pos_, end);
    const size_t newPos = end - data_.c_str();
    if (newPos == pos_ || (newPos < data_.size() && !std::isspace((uchar)*end)))
        fail("expected a number, found `" + data_.substr(pos_, 16) + "`");
    pos_ = newPos;
    return value;
}

int64 PlyReader::nextInteger(const Type& type, bool bigEndian)
{
    need(type.size);
    int64 value = 0;
    for (int i = 0; i < type.size; ++i)
        value |= (int64)(uchar)data_[pos_ + i] << 8 * (bigEndian ? type.size - 1 - i : i);
    pos_ += type.size;
    const int64 signBit = (int64)1 << (8 * type.size - 1);
    return type.isSigned && (value & signBit) ? value - 2 * signBit : value;
}

double PlyReader::nextValue(const Type& type, bool bigEndian)
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

//! Of faces their corners, as a fan; texture coordinates and colours are passed over.
void PlyReader::addFace(const std::vector<double>& corners, int64 vertices)
{
    if (corners.size() < 3)
        fail(format("expected at least three vertices in each face, found %d", (int)corners.size()));
    for (size_t k = 0; k < corners.size(); ++k)
        if (!(corners[k] >= 0 && corners[k] < (double)vertices && corners[k] == std::floor(corners[k])))
            fail(format("a face names vertex %g of %lld", corners[k], (long long)vertices));
    for (size_t k = 2; k < corners.size(); ++k)
        mesh_.triangles.push_back(Vec3i((int)corners[0], (int)corners[k - 1], (int)corners[k]));
}

void PlyReader::addNumber(const Element& element, const Property& property, double value)
{
    if (element.name != "vertex" || property.count.size || property.name.size() != 1 || property.name[0] < 'x' || property.name[0] > 'z')
        return;
    if (!(std::abs(value) <= FLT_MAX))
        fail(format("expected finite numbers, vertex %d is not", (int)mesh_.vertices.size() - 1));
    Point3f& p = mesh_.vertices.back();
    (property.name[0] == 'x' ? p.x : property.name[0] == 'y' ? p.y : p.z) = (float)value;
}

//! An element is a line.
void PlyReader::readTextElement(const Element& element, int64 vertices)
{
    const size_t begin = pos_;
    String line;
    if (pos_ >= data_.size())
        fail(format("truncated: expected %lld elements `%s`", (long long)element.count, element.name.c_str()));
    nextPLYLine(line, "an element");
    const size_t next = pos_, end = begin + line.size();
    pos_ = begin;
    for (size_t p = 0; p < element.properties.size(); ++p)
    {
        const Property& property = element.properties[p];
        const bool corners = element.name == "face" && property.count.size && isFaceList(property.name);
        const double count = property.count.size ? nextNumber() : 1;
        if (count < 0 || count != std::floor(count))
            fail(format("expected a list in element `%s`, its count is %g", element.name.c_str(), count));
        values_.clear();
        for (double k = 0; k < count; ++k)
            values_.push_back(nextNumber());
        if (corners)
            addFace(values_, vertices);
        else if (!property.count.size)
            addNumber(element, property, values_[0]);
    }
    if (pos_ > end || data_.find_first_not_of(" \t", pos_) < end)
        fail(format("expected each element `%s` on a line of its own, found `%s`", element.name.c_str(), line.substr(0, 40).c_str()));
    pos_ = next;
}

void PlyReader::readBinaryElement(const Element& element, int64 vertices, bool bigEndian)
{
    for (size_t p = 0; p < element.properties.size(); ++p)
    {
        const Property& property = element.properties[p];
        const bool corners = element.name == "face" && property.count.size && isFaceList(property.name);
        const int64 count = property.count.size ? nextInteger(property.count, bigEndian) : 1;
        if (count < 0)
            fail(format("expected a list in element `%s`, its count is negative", element.name.c_str()));
        need(count * property.value.size);
        values_.clear();
        for (int64 k = 0; k < count; ++k)
            values_.push_back(nextValue(property.value, bigEndian));
        if (corners)
            addFace(values_, vertices);
        else if (!property.count.size)
            addNumber(element, property, values_[0]);
    }
}

Mesh PlyReader::read()
{
    String plyFormat;
    const std::vector<Element> elements = readHeader(plyFormat);
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
    {
        if (!ascii && elements[e].properties.empty())   // takes no bytes, however many there are
            continue;
        for (int64 i = 0; i < elements[e].count; ++i)
        {
            if (elements[e].name == "vertex")
                mesh_.vertices.push_back(Point3f());
            if (ascii)
                readTextElement(elements[e], vertices);
            else
                readBinaryElement(elements[e], vertices, bigEndian);
        }
    }
    return mesh_;
}

}} // namespace cv::surgtrack
