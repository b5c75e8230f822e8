// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include <cctype>
#include <cerrno>
#include <clocale>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sys/stat.h>
#include "opencv2/core/utils/filesystem.hpp"
#include "files/joint_names.hpp"
#include "files/storage_check.hpp"
#include "files/text_file.hpp"

namespace cv { namespace surgtrack {

//! Without what a terminal would act on, and what is not UTF-8: Python shows nothing at all of a text that has it.
static String printable(const String& text, size_t most)
{
    static const unsigned least[] = { ' ', 0xA0, 0x800, 0x10000 };   // of as many bytes
    String result;
    for (size_t i = 0, bytes; i < text.size(); i += bytes)
    {
        if (result.size() >= most)
            return result + "...";
        const uchar first = (uchar)text[i];
        bytes = first < 0xC0 ? 1 : first < 0xE0 ? 2 : first < 0xF0 ? 3 : 4;
        unsigned code = bytes == 1 ? first : first & (0xFFu >> (bytes + 1));
        bool sound = (first < 0x80 || first >= 0xC0) && first < 0xF8;
        for (size_t k = 1; k < bytes && sound; k++)
        {
            sound = i + k < text.size() && ((uchar)text[i + k] & 0xC0) == 0x80;
            code = code << 6 | ((uchar)text[i + k] & 0x3F);
        }
        sound = sound && code >= least[bytes - 1] && code != 127 && (code < 0xD800 || code > 0xDFFF) && code <= 0x10FFFF;
        if (!sound) bytes = 1;
        result += sound ? text.substr(i, bytes) : String("?");
    }
    return result;
}

void importError(const String& filename, const String& what, Error::Code code)
{
    CV_Error(code, filename + ": " + printable(what, 2000));
}

static const char* const byteOrderMark = "\xEF\xBB\xBF";

static bool isUtf16(const String& text) { return text.compare(0, 2, "\xFF\xFE") == 0 || text.compare(0, 2, "\xFE\xFF") == 0; }

bool isRegularFile(const String& filename)
{
    struct stat status;
    return stat(filename.c_str(), &status) == 0 && (status.st_mode & S_IFMT) == S_IFREG;
}

String readContent(const String& filename, const char* expected)
{
    if (utils::fs::isDirectory(filename))
        importError(filename, String("is a folder, expected ") + expected, Error::StsObjectNotFound);
    if (!utils::fs::exists(filename))
        importError(filename, "there is no such file", Error::StsObjectNotFound);
    if (!isRegularFile(filename))
        importError(filename, String("can't be read: expected ") + expected + ", not a device or pipe", Error::StsObjectNotFound);
    std::ifstream file(filename.c_str(), std::ios::binary);
    std::ostringstream content;
    if (!file.is_open())
        importError(filename, String("can't be read: ") + std::strerror(errno), Error::StsObjectNotFound);
    content << file.rdbuf();
    if (file.bad())
        importError(filename, String("expected ") + expected + " that can be read");
    return content.str();
}

double toDouble(const char* text, const char*& end)
{
    char* stop = 0;
    double value = std::strtod(text, &stop);
    end = stop;
    const String point = std::localeconv()->decimal_point;
    if (*stop != '.' || point == ".")
        return value;
    while (std::isspace((uchar)*text))
        text++;
    String local(text, std::strcspn(text, " \t\r\n"));
    local.replace(end - text, 1, point);
    value = std::strtod(local.c_str(), &stop);
    end = text + (stop - local.c_str()) - (point.size() - 1);
    return value;
}

static String readWhole(const String& filename)
{
    const String text = readContent(filename, "a text file");
    if (text.empty())
        importError(filename, "expected a text file that is not empty");
    if (isUtf16(text))
        importError(filename, "is UTF-16, expected UTF-8 or ASCII");
    return text;
}

String readTextFile(const String& filename)
{
    const String text = readWhole(filename);
    return text.compare(0, 3, byteOrderMark) == 0 ? text.substr(3) : text;
}

void writeContent(const String& filename, const String& content)
{
    const String place = utils::fs::canonical(filename);   // behind links
    const bool inPlace = utils::fs::exists(place) && !isRegularFile(place);   // renaming would put a file where a device is
    const String target = inPlace ? place : place + ".new";
    FILE* file = std::fopen(target.c_str(), "wb");
    bool written = file && std::fwrite(content.data(), 1, content.size(), file) == content.size() && std::fflush(file) == 0;
    String reason = written ? "" : std::strerror(errno);
    if (file && std::fclose(file) != 0 && written)
    {
        written = false;
        reason = std::strerror(errno);
    }
#ifdef _WIN32
    if (written && !inPlace) std::remove(place.c_str());    // rename() does not overwrite there
#endif
    if (written && !inPlace && std::rename(target.c_str(), place.c_str()) != 0)
    {
        written = false;
        reason = std::strerror(errno);
    }
    if (written) return;
    if (file && !inPlace) std::remove(target.c_str());
    CV_Error(Error::StsError, format("%s: can't be written: %s", filename.c_str(), reason.c_str()));
}

//! What cv::FileStorage says of the text it can't take, and of which line. @param added lines before the file's own
static String reasonOf(const Exception& e, int added)
{
    // `FILE(LINE): REASON`, which OpenCV 4 hands over in the place of the function's name.
    const String* const texts[] = { &e.func, &e.err };
    for (int i = 0; i < 2; i++)
    {
        const String& text = *texts[i];
        const size_t end = text.rfind("):"), open = end == String::npos ? end : text.find_last_not_of("0123456789", end - 1);
        if (end == String::npos || end == 0 || open == String::npos || text[open] != '(' || open + 1 == end)
            continue;
        const size_t reason = std::min(text.find_first_not_of(' ', end + 2), text.size());
        return format(" (line %d: ", std::max(1, std::atoi(text.c_str() + open + 1) - added)) + text.substr(reason) + ")";
    }
    return " (" + e.err + ")";
}

static FileStorage openAs(const String& filename, const String& text, const char* expected, int added = 0)
{
    // Nothing is opened by its name: that of a folder with a line feed in it was taken for a text.
    const String checked = StorageCheck(filename, text, added).checked();
    FileStorage storage;
    String reason;
    try
    {
        storage.open(checked, FileStorage::READ | FileStorage::MEMORY);
    }
    catch (const Exception& e)
    {
        reason = reasonOf(e, added);
    }
    if (!storage.isOpened() || !storage.root().isMap())
        importError(filename, String("expected ") + expected + reason);
    StorageCheck::checkMatrices(filename, storage.root());
    return storage;
}

static const char* const ofStorage = "a YAML, XML or JSON file of cv::FileStorage";

FileStorage openStorage(const String& filename)
{
    return parseStorage(filename, readTextFile(filename));
}

FileStorage parseStorage(const String& filename, const String& text)
{
    return openAs(filename, text, ofStorage);
}

FileStorage newStorage(const String& filename)
{
    const String kind = lowerCase(filename.substr(std::min(filename.rfind('.'), filename.size())));
    return FileStorage(kind == ".xml" || kind == ".json" ? kind : ".yaml", FileStorage::WRITE | FileStorage::MEMORY);
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
        if (depth <= 0 || (line[i] != ']' && ofNumber.find(line[i]) == String::npos))
            continue;
        const size_t next = line.find_first_not_of(' ', i + 1);
        if (next != String::npos && next > i + 1 && startsNumber.find(line[next]) != String::npos)
            result += ',';
    }
    return result;
}

//! Puts an `n` before keys that are numbers, in quotes or not.
static String withNamedKeys(const String& line)
{
    String result;
    bool begins = true;   // a key
    for (size_t i = 0; i < line.size(); )
    {
        if (begins)
        {
            size_t digits = std::min(line.find_first_not_of(' ', i), line.size());
            digits += digits < line.size() && (line[digits] == '\'' || line[digits] == '"');
            const size_t end = std::min(line.find_first_not_of("0123456789", digits), line.size());
            size_t colon = end + (end < line.size() && (line[end] == '\'' || line[end] == '"'));
            colon = std::min(line.find_first_not_of(' ', colon), line.size());
            if (end > digits && colon < line.size() && line[colon] == ':' && (colon + 1 == line.size() || line[colon + 1] == ' '))
            {
                result += "n" + line.substr(digits, end - digits) + ":";
                i = colon + 1;
                begins = false;
                continue;
            }
        }
        begins = line[i] == '{' || line[i] == ',';
        result += line[i++];
    }
    return result;
}

//! Without spaces at the end, and what Python says of its types.
static String withoutTypes(const String& line)
{
    const String type = "!!python/tuple";
    String result;
    size_t start = 0;
    for (size_t at; (at = line.find(type, start)) != String::npos; start = at + type.size())
        result += line.substr(start, at - start);
    result += line.substr(start);
    result.resize(result.find_last_not_of(" \r") + 1);
    return result;
}

FileStorage openYaml(const String& filename)
{
    const String whole = readTextFile(filename);
    const size_t begin = whole.find_first_not_of(" \r\n");
    if (begin != String::npos && whole[begin] == '{' && whole.find('"') != String::npos)
        return parseStorage(filename, whole.substr(begin));   // JSON
    std::istringstream lines(whole);
    String text = "%YAML:1.0\n---\n", line;
    int depth = 0;
    for (bool begun = false; std::getline(lines, line); )
    {
        line = withCommas(withoutTypes(line), depth);
        const size_t start = line.find_first_not_of(" ");
        const bool document = line.compare(0, 3, "---") == 0 || line.compare(0, 3, "...") == 0;
        if (document && begun)
            break;   // the first message of several
        if (start == String::npos || line[0] == '%' || document)
            text += "\n";   // so that lines keep their numbers
        else if (line.compare(start, 2, "- ") == 0)
            text += " " + line + "\n";
        else
            text += line.substr(0, start) + withNamedKeys(line.substr(start)) + "\n";
        begun = begun || (start != String::npos && !document && line[0] != '%' && line[start] != '#');
    }
    return openAs(filename, text, "YAML", 2);
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
