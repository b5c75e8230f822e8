// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <regex>
#include "opencv2/core/utils/filesystem.hpp"
#include "files/text_file.hpp"

namespace cv { namespace surgtrack {

void importError(const String& filename, const String& what, Error::Code code)
{
    CV_Error(code, filename + ": " + what);
}

static const char* const byteOrderMark = "\xEF\xBB\xBF";

static bool isUtf16(const String& text) { return text.compare(0, 2, "\xFF\xFE") == 0 || text.compare(0, 2, "\xFE\xFF") == 0; }

static String readWhole(const String& filename)
{
    if (utils::fs::isDirectory(filename))
        importError(filename, "is a folder, expected a text file", Error::StsObjectNotFound);
    if (!utils::fs::exists(filename))
        importError(filename, "there is no such file", Error::StsObjectNotFound);
    std::ifstream file(filename.c_str(), std::ios::binary);
    std::ostringstream content;
    if (!file.is_open())
        importError(filename, String("can't be read: ") + std::strerror(errno), Error::StsObjectNotFound);
    if (!(content << file.rdbuf()))
        importError(filename, "expected a text file that is not empty");
    if (isUtf16(content.str()))
        importError(filename, "is UTF-16, expected UTF-8 or ASCII");
    return content.str();
}

String readTextFile(const String& filename)
{
    const String text = readWhole(filename);
    return text.compare(0, 3, byteOrderMark) == 0 ? text.substr(3) : text;
}

void writeText(const String& filename, const String& text)
{
    FILE* file = std::fopen(filename.c_str(), "wb");
    const bool written = file && std::fwrite(text.data(), 1, text.size(), file) == text.size() && std::fflush(file) == 0;
    const String reason = written ? "" : std::strerror(errno);
    const bool closed = !file || std::fclose(file) == 0;
    if (!written || !closed)
        CV_Error(Error::StsError, format("%s: can't be written: %s", filename.c_str(), reason.c_str()));
}

void writeAtOnce(const String& filename, const String& text)
{
    const String beside = filename + ".new";
    FILE* file = std::fopen(beside.c_str(), "wb");
    bool written = file && std::fwrite(text.data(), 1, text.size(), file) == text.size() && std::fflush(file) == 0;
    String reason = written ? "" : std::strerror(errno);
    if (file && std::fclose(file) != 0 && written)
    {
        written = false;
        reason = std::strerror(errno);
    }
#ifdef _WIN32
    if (written) std::remove(filename.c_str());    // rename() does not overwrite there
#endif
    if (written && std::rename(beside.c_str(), filename.c_str()) != 0)
    {
        written = false;
        reason = std::strerror(errno);
    }
    if (written) return;
    if (file) std::remove(beside.c_str());
    CV_Error(Error::StsError, format("%s: can't be written: %s", filename.c_str(), reason.c_str()));
}

//! What cv::FileStorage says of the text it can't take, and of which line. @param added lines before the file's own
static String reasonOf(const Exception& e, int added)
{
    // `FILE(LINE): REASON`, which OpenCV 4 hands over in the place of the function's name.
    const std::regex place("^[^]*\\(([0-9]+)\\): *([^]*)$");
    std::smatch found;
    if (!std::regex_match(e.func, found, place) && !std::regex_match(e.err, found, place))
        return " (" + e.err + ")";
    const String reason = found[2].str();
    return format(" (line %d: ", std::max(1, std::atoi(found[1].str().c_str()) - added)) + reason + ")";
}

static FileStorage openAs(const String& filename, const String& source, int flags, const char* expected, int added = 0)
{
    FileStorage storage;
    String reason;
    try
    {
        storage.open(source, flags);
    }
    catch (const Exception& e)
    {
        reason = reasonOf(e, added);
    }
    if (!storage.isOpened() || !storage.root().isMap())
        importError(filename, String("expected ") + expected + reason);
    return storage;
}

static const char* const ofStorage = "a YAML, XML or JSON file of cv::FileStorage";

FileStorage openStorage(const String& filename)
{
    const String text = readWhole(filename);
    if (text.compare(0, 3, byteOrderMark) == 0)
        return parseStorage(filename, text.substr(3));
    return openAs(filename, filename, FileStorage::READ, ofStorage);
}

FileStorage parseStorage(const String& filename, const String& text)
{
    return openAs(filename, text, FileStorage::READ | FileStorage::MEMORY, ofStorage);
}

//! Puts commas between the numbers of lists that have none. @param depth of brackets, carried from line to line
static String withCommas(const String& line, int& depth)
{
    const String ofNumber = "0123456789.", startsNumber = "0123456789.+-[";
    String result;
    for (size_t i = 0; i < line.size(); i++)
    {
        depth += line[i] == '[' ? 1 : line[i] == ']' ? -1 : 0;
        result += line[i];
        const size_t next = line.find_first_not_of(' ', i + 1);
        const bool ends = ofNumber.find(line[i]) != String::npos || (line[i] == ']' && depth > 0);
        if (depth > 0 && ends && next != String::npos && next > i + 1 && startsNumber.find(line[next]) != String::npos)
            result += ',';
    }
    return result;
}

FileStorage openYaml(const String& filename)
{
    const String whole = readTextFile(filename);
    const size_t begin = whole.find_first_not_of(" \r\n");
    if (begin != String::npos && whole[begin] == '{' && whole.find('"') != String::npos)
        return parseStorage(filename, whole.substr(begin));   // JSON
    const std::regex numberKey("(^|[{,]) *['\"]?([0-9]+)['\"]? *:(?= |$)"), notForStorage("[ \r]+$|!!python/tuple");
    std::istringstream lines(whole);
    String text = "%YAML:1.0\n---\n", line;
    int depth = 0;
    for (bool begun = false; std::getline(lines, line); )
    {
        line = withCommas(std::regex_replace(line, notForStorage, ""), depth);
        const size_t start = line.find_first_not_of(" ");
        const bool document = line.compare(0, 3, "---") == 0 || line.compare(0, 3, "...") == 0;
        if (document && begun)
            break;   // the first message of several
        if (start == String::npos || line[0] == '%' || document)
            text += "\n";   // so that lines keep their numbers
        else if (line.compare(start, 2, "- ") == 0)
            text += " " + line + "\n";
        else
            text += line.substr(0, start) + std::regex_replace(line.substr(start), numberKey, "$1n$2:") + "\n";
        begun = begun || (start != String::npos && !document && line[0] != '%' && line[start] != '#');
    }
    return openAs(filename, text, FileStorage::READ | FileStorage::MEMORY, "YAML", 2);
}

std::pair<String, String> splitPair(const String& text, const char* what)
{
    const size_t colon = text.find(':');
    if (colon == 0 || colon == String::npos || colon + 1 == text.size())
        CV_Error(Error::StsBadArg, format("%s: '%s', expected two parts and a colon between", what, text.c_str()));
    return std::make_pair(text.substr(0, colon), text.substr(colon + 1));
}

std::map<String, String> pairsByLabel(const std::vector<String>& pairs, const char* what)
{
    std::map<String, String> result;
    for (size_t i = 0; i < pairs.size(); i++)
        if (!result.insert(splitPair(pairs[i], what)).second)
            CV_Error(Error::StsBadArg, format("%s: '%s', expected each label once", what, pairs[i].c_str()));
    return result;
}

}} // namespace cv::surgtrack
