// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "files/joint_names.hpp"
#include "files/mesh_check.hpp"
#include "files/text_file.hpp"

#include <cctype>
#include <cfloat>
#include <cstdlib>
#include <cstring>

namespace cv { namespace surgtrack {

float MeshCheck::nextNumber()
{
    while (pos_ < data_.size() && std::isspace((uchar)data_[pos_]))
        ++pos_;
    const char* end = 0;
    const double value = toDouble(data_.c_str() + pos_, end);
    const size_t newPos = end - data_.c_str();
    if (newPos == pos_ || (newPos < data_.size() && !std::isspace((uchar)*end)))
        fail("expected a number, found `" + data_.substr(pos_, 16) + "`");
    if (!(std::abs(value) <= FLT_MAX))
        fail("expected finite numbers, found `" + data_.substr(pos_, newPos - pos_) + "`");
    pos_ = newPos;
    return (float)value;
}

//! The next word, in lower case; empty at the end.
String MeshCheck::nextWord()
{
    while (pos_ < data_.size() && std::isspace((uchar)data_[pos_]))
        ++pos_;
    const size_t begin = pos_;
    while (pos_ < data_.size() && !std::isspace((uchar)data_[pos_]))
        ++pos_;
    String word = data_.substr(begin, pos_ - begin);
    for (size_t i = 0; i < word.size(); ++i)
        word[i] = (char)std::tolower((uchar)word[i]);
    return word;
}

Mesh MeshCheck::readTextSTL()
{
    Mesh mesh;
    int64 facets = 0, ends = 0, vertices = 0, solids = 0;
    bool header = false;   // of a facet: its normal, and what some write of its colour
    for (String word = nextWord(); !word.empty(); word = nextWord())
    {
        if (word == "end")   // `end solid` in two words
            word += nextWord();
        header = word == "facet" || (header && word != "outer");
        const bool known = word == "facet" || word == "outer" || word == "loop" || word == "vertex" || word == "endloop" || word == "endfacet"
                           || word == "solid" || word == "endsolid";
        if (!header && !known)
            fail("expected the words of an STL, found `" + word.substr(0, 40) + "`");
        facets += word == "facet";
        ends += word == "endfacet";
        solids += word == "endsolid";
        vertices += word == "vertex";
        if (word == "vertex")
        {
            const float x = nextNumber(), y = nextNumber(), z = nextNumber();
            mesh.vertices.push_back(Point3f(x, y, z));
        }
        if (word == "endfacet" && vertices != 3 * ends)
            fail(format("expected three vertices in each facet, facet %lld has others", (long long)ends));
        if (word == "solid" || word == "endsolid")   // a name may follow, in any letters
            pos_ = std::min(data_.find_first_of("\r\n", pos_), data_.size());
    }
    if (!solids || facets != ends || vertices != 3 * facets)
        fail(format("truncated: expected `endsolid`, and an `endfacet` and three vertices for each of %lld facets", (long long)facets));
    for (int64 i = 0; i < facets; ++i)
        mesh.triangles.push_back(Vec3i((int)(3 * i), (int)(3 * i + 1), (int)(3 * i + 2)));
    return mesh;
}

Mesh MeshCheck::readBinarySTL(int64 triangles) const
{
    Mesh mesh;
    for (int64 i = 0; i < triangles; ++i)
    {
        const uchar* bytes = (const uchar*)data_.data() + 84 + 50 * i + 12;   // 12: of the normal
        float xyz[9];
        for (int k = 0; k < 9; ++k, bytes += 4)
        {
            Cv32suf number;
            number.u = bytes[0] | bytes[1] << 8 | bytes[2] << 16 | (unsigned)bytes[3] << 24;
            if (!(std::abs(number.f) <= FLT_MAX))
                fail(format("expected finite numbers, vertex %lld is not", (long long)(3 * i + k / 3)));
            xyz[k] = number.f;
        }
        for (int k = 0; k < 9; k += 3)
            mesh.vertices.push_back(Point3f(xyz[k], xyz[k + 1], xyz[k + 2]));
        mesh.triangles.push_back(Vec3i((int)(3 * i), (int)(3 * i + 1), (int)(3 * i + 2)));
    }
    return mesh;
}

Mesh MeshCheck::readSTL()
{
    // A binary file may begin with "solid" as well: its size tells, or that there are no facets in its text.
    int64 expectedSize = 0, triangles = 0;
    if (data_.size() >= 84)
    {
        for (int i = 0; i < 4; ++i)
            triangles |= (int64)(uchar)data_[80 + i] << 8 * i;
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

void MeshCheck::checkVertex(const char* text, int line, std::string& checked) const
{
    const char* next = text;
    for (int k = 0; k < 3; ++k)
    {
        const char* const start = next;
        const double value = toDouble(start, next);
        const size_t length = next - start;
        if (!length || (*next && !std::isspace((uchar)*next)) || !(std::abs(value) <= FLT_MAX) || std::memchr(start, '\n', length) || std::memchr(start, 'x', length)
            || std::memchr(start, 'X', length))
            fail(format("line %d: expected three finite numbers", line));
    }
    checked.append("v ").append(text, next - text).append("\n");
}

// A corner of a face: v, v/vt, v//vn or v/vt/vn; what is between slashes or behind the last one may be missing.
void MeshCheck::checkFace(const char* text, const int64* count, int line, std::string& checked) const
{
    const int most = 1000;   // what is done for a face grows faster than their number
    int corners = 0;
    checked += "f";
    for (const char* c = text; ; ++corners)
    {
        while (*c == ' ' || *c == '\t' || *c == '\r' || (*c == '\\' && (c[1] == '\n' || c[1] == '\r')) || (*c == '\n' && (c[-1] == '\\' || (c[-1] == '\r' && c[-2] == '\\'))))
            ++c;
        if (!*c || *c == '\n' || *c == '#')
            break;
        const char* const word = c;
        for (int k = 0; k < 3; ++k)
        {
            char* end = 0;
            const long long index = std::strtoll(c, &end, 10);
            const bool ends = !*end || std::isspace((uchar)*end), omitted = k > 0 && (end == c || c[0] == ' ' || c[0] == '\t' || c[0] == '\n');
            if (omitted)
                end = const_cast<char*>(c);
            const bool done = omitted ? !*c || std::isspace((uchar)*c) : ends;
            if ((!done && (*end != '/' || k == 2)) || (!omitted && (end == c || index == 0 || index > count[k] || index < -count[k])))
                fail(format("line %d: `%s` names a vertex, texture or normal that is not there", line, std::string(word, std::min(std::strcspn(word, " \t\r\n"), (size_t)40)).c_str()));
            if (k == 0)
                checked += format(" %lld", index > 0 ? index : (long long)count[0] + 1 + index);
            c = end;
            if (done)
                break;
            ++c;
        }
    }
    if (corners < 3 || corners > most)
        fail(format("line %d: expected at least three vertices, and at most %d", line, most));
    checked += "\n";
}

std::string MeshCheck::checkedOBJ()
{
    std::string checked;
    int64 count[3] = { 0, 0, 0 };   // v, vt, vn
    int line = 1;
    for (const char* c = data_.c_str(); c && *c; ++line)
    {
        while (*c == ' ' || *c == '\t')
            ++c;
        const bool blank = c[0] && (c[1] == ' ' || c[1] == '\t');
        if (c[0] == 'v' && blank)
            checkVertex(c + 2, line, checked);
        count[0] += c[0] == 'v' && blank;
        count[1] += c[0] == 'v' && c[1] == 't';
        count[2] += c[0] == 'v' && c[1] == 'n';
        if (c[0] == 'f' && blank)
            checkFace(c + 2, count, line, checked);
        c = std::strchr(c, '\n');
        c = c ? c + 1 : c;
    }
    return checked;
}

}} // namespace cv::surgtrack
