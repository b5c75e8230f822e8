// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include <cctype>
#include "files/text_file.hpp"
#include "lab/import/urdf_text.hpp"

namespace cv { namespace surgtrack {

namespace {

const int deepest = 64;         // levels of tags
const size_t mostJoints = 1000; // a chain of them is gone through by calls within calls

String withoutComments(const String& text)
{
    String rest;
    size_t start = 0;
    for (size_t at; start < text.size() && (at = text.find("<!--", start)) != String::npos; )
    {
        rest += text.substr(start, at - start);
        const size_t end = text.find("-->", at + 4);
        start = end == String::npos ? text.size() : end + 3;
    }
    return rest + text.substr(start);
}

void checkLevels(const String& filename, const String& text)
{
    int levels = 0;
    for (size_t at = 0; (at = text.find('<', at)) != String::npos; )
    {
        const bool comment = text.compare(at, 4, "<!--") == 0, other = text[at + 1] == '!' || text[at + 1] == '?', closes = text[at + 1] == '/';
        if (text.compare(at, 3, "<![") == 0)
            importError(filename, "expected no CDATA");
        size_t end = comment ? text.find("-->", at + 4) : other ? text.find('>', at) : at + 1;
        for (char quote = 0; !other && end < text.size() && (quote || text[end] != '>'); end++)
            quote = quote ? (text[end] == quote ? '\0' : quote) : text[end] == '"' || text[end] == '\'' ? text[end] : '\0';
        if (end >= text.size())
            return;
        levels = closes ? std::max(levels - 1, 0) : levels + (!other && text[end - 1] != '/');
        if (levels > deepest)
            importError(filename, format("expected at most %d levels of tags", deepest));
        at = end;
    }
}

} // namespace

std::vector<String> checkUrdfText(const String& filename, const String& text)
{
    const String plain = withoutComments(text);
    // What is still to be expanded; the name space alone often stays in what was.
    if (plain.find("<xacro:") != String::npos || plain.find("${") != String::npos || plain.find("$(") != String::npos)
        importError(filename, "is xacro, expected an expanded URDF: `xacro FILE.xacro > FILE.urdf` expands it");
    checkLevels(filename, text);
    std::vector<String> joints;
    for (size_t at = 0; (at = plain.find("<joint", at)) != String::npos; at++)
    {
        if (joints.size() == mostJoints)
            importError(filename, format("expected at most %d joints", (int)mostJoints));
        if (at + 6 >= plain.size() || !std::isspace((uchar)plain[at + 6]))
            continue;
        String tag = plain.substr(at, 1000);
        tag.resize(std::min(tag.find('>'), tag.size()));
        const size_t name = tag.find("name"), quote = name == String::npos ? name : tag.find_first_of("\"'", name);
        const size_t end = quote == String::npos ? quote : tag.find(tag[quote], quote + 1);
        joints.push_back(end == String::npos ? String() : tag.substr(quote + 1, end - quote - 1));
    }
    return joints;
}

}} // namespace cv::surgtrack
