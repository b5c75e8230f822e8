// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <locale>
#include <sstream>
#include "opencv2/core/utils/filesystem.hpp"
#include "files/csv.hpp"
#include "base/geometry.hpp"

namespace cv { namespace surgtrack {

namespace {

const double farthest = 10;    // [m]; no arm reaches further, but in millimetres most do

String textOf(const String& filename)
{
    std::ifstream file(filename.c_str(), std::ios::binary);
    String text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    if (!file || file.bad() || utils::fs::isDirectory(filename))
        CV_Error(Error::StsObjectNotFound, filename + ": can't be read, expected a sequence.yaml");
    return text;
}

void parse(const String& filename, const String& text, FileStorage& storage)
{
    try
    {
        storage.open(text, FileStorage::READ | FileStorage::MEMORY);
    }
    catch (const Exception& e)
    {
        CV_Error(Error::StsParseError, format("%s: can't be parsed: %s", filename.c_str(), e.err.c_str()));
    }
    if (!storage.isOpened() || !storage.root().isMap())
        CV_Error(Error::StsParseError, filename + ": expected a file of cv::FileStorage with the keys fps, image_width, ...");
}

//! Numbers, texts and structure are the same; keys in this order too. The node `except` is not compared.
bool sameNodes(const FileNode& a, const FileNode& b, const String& path, const String& except)
{
    if (path == except) return true;
    if (a.type() != b.type() || a.size() != b.size()) return false;
    if (a.isInt()) return (int)a == (int)b;
    if (a.isReal()) return (double)a == (double)b;
    if (a.isString()) return a.string() == b.string();
    FileNodeIterator i = a.begin(), j = b.begin();
    for (int k = 0; k < (int)a.size(); k++, ++i, ++j)
    {
        const FileNode x = *i, y = *j;
        if (a.isMap() && x.name() != y.name()) return false;
        if (!sameNodes(x, y, path + "/" + (a.isMap() ? x.name() : format("%d", k)), except)) return false;
    }
    return true;
}

//! Where a token begins from `start` on, outside of comments and of texts in quotes; npos if nowhere.
size_t findToken(const String& text, const String& token, size_t start)
{
    char quote = 0;
    bool comment = false;
    for (size_t i = 0; i < text.size(); i++)
    {
        const char c = text[i];
        if (comment) comment = c != '\n';
        else if (quote && c == '\\') i++;
        else if (quote) quote = c == quote ? 0 : quote;
        else if (c == '"' || c == '\'') quote = c;
        else if (c == '#') comment = true;
        else if (i >= start && text.compare(i, token.size(), token) == 0 && (i == 0 || !(std::isalnum((uchar)text[i - 1]) || text[i - 1] == '_')))
            return i;
    }
    return String::npos;
}

//! The numbers between the brackets of the n-th `camera_T_base` are replaced.
String replaced(const String& text, int n, const Matx44d& T)
{
    size_t at = 0;
    for (int i = 0; i <= n && at != String::npos; i++) at = findToken(text, "camera_T_base", i ? at + 1 : 0);
    const size_t data = at == String::npos ? at : findToken(text, "data", at);
    const size_t open = data == String::npos ? data : text.find('[', data), close = open == String::npos ? open : text.find(']', open);
    if (close == String::npos) return text;
    std::ostringstream numbers;
    numbers.imbue(std::locale::classic());
    numbers.precision(17);
    for (int i = 0; i < 16; i++) numbers << (i ? ", " : " ") << T.val[i];
    return text.substr(0, open + 1) + numbers.str() + " " + text.substr(close);
}

//! All or nothing: written beside, then renamed.
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

} // namespace

bool readPoses(const String& filename, std::vector<double>& keys, OutputArray poses)
{
    CsvReader file(filename);
    const bool byTime = file.find("time") >= 0;
    if (byTime == (file.find("index") >= 0))
        CV_Error(Error::StsParseError, filename + ", line 1: expected a column 'index' or a column 'time', one of them");
    const int key = file.column(byTime ? "time" : "index");
    const char* const names[] = { "tx", "ty", "tz", "qx", "qy", "qz", "qw" };
    int columns[7];
    for (int i = 0; i < 7; i++) columns[i] = file.column(names[i]);
    std::vector<double> found;
    Mat_<double> rows(0, 16);
    while (file.next())
    {
        double v[7];
        for (int i = 0; i < 7; i++) v[i] = file.number(columns[i]);
        const Vec4d q(v[3], v[4], v[5], v[6]);
        if (std::abs(norm(q) - 1) > 0.01) file.fail(format("qx,qy,qz,qw has length %g, expected a unit quaternion", norm(q)));
        if (norm(Vec3d(v)) > farthest) file.fail(format("tx,ty,tz is %.4g m away, expected metres, not millimetres", norm(Vec3d(v))));
        found.push_back(byTime ? file.number(key) : file.count(key));
        if (found.size() > 1 && found.back() <= found[found.size() - 2])
            file.fail(format("%s is %.10g after %.10g, expected rising values", byTime ? "time" : "index", found.back(), found[found.size() - 2]));
        const Matx33d R = rotationFromQuaternion(q);
        const Matx<double, 1, 16> row(R(0, 0), R(0, 1), R(0, 2), v[0], R(1, 0), R(1, 1), R(1, 2), v[1], R(2, 0), R(2, 1), R(2, 2), v[2], 0, 0, 0, 1);
        rows.push_back(Mat(row));
    }
    if (found.empty()) CV_Error(Error::StsParseError, filename + ": has no poses");
    keys.swap(found);
    rows.copyTo(poses);
    return byTime;
}

void writeHandEye(const String& sequence, const String& tool, const Matx44d& camera_T_base)
{
    CV_Assert(isRigid(camera_T_base) && "camera_T_base must be rigid");
    const String filename = utils::fs::isDirectory(sequence) ? utils::fs::join(sequence, "sequence.yaml") : sequence;
    const String before = textOf(filename);
    FileStorage storage;
    parse(filename, before, storage);
    const FileNode tools = storage["tools"];
    int index = -1, n = 0;
    String known;
    for (int i = 0; tools.isSeq() && i < (int)tools.size() && index < 0; i++)
    {
        const FileNode node = tools[i].isMap() ? tools[i]["name"] : FileNode();
        const String name = node.isString() ? node.string() : String();
        known += (known.empty() ? "" : ", ") + name;
        if (name == tool) index = i;
        else if (tools[i].isMap() && !tools[i]["camera_T_base"].empty()) n++;
    }
    if (index < 0)
        CV_Error(Error::StsObjectNotFound, format("%s: key tools has no tool '%s', expected one of: %s", filename.c_str(), tool.c_str(), known.c_str()));
    if (!tools[index]["camera_T_base"].isMap())
        CV_Error(Error::StsParseError, format("%s: key tools[%d].camera_T_base is missing, expected a 4x4 matrix to replace", filename.c_str(), index));

    // The place is found in the text, so that comments and layout stay; the result is parsed to see that it was the right one.
    const String after = replaced(before, n, camera_T_base);
    FileStorage check;
    parse(filename, after, check);
    Mat written;
    const FileNode node = check["tools"][index]["camera_T_base"];
    if (node.isMap()) node >> written;
    const String key = format("/tools/%d/camera_T_base", index);
    if (written.size() != Size(4, 4) || written.type() != CV_64F || Matx44d(written.ptr<double>()) != camera_T_base
        || !sameNodes(storage.root(), check.root(), "", key))
        CV_Error(Error::StsParseError, format("%s: key tools[%d].camera_T_base can't be replaced, expected a 4x4 opencv-matrix of type d with its numbers in brackets",
                                              filename.c_str(), index));
    writeAtOnce(filename, after);
}

}} // namespace cv::surgtrack
