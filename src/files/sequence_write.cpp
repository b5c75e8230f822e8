// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include <cctype>
#include <cerrno>
#include <cstring>
#include <set>
#include "opencv2/core/utils/filesystem.hpp"
#include "opencv2/surgtrack/sequence.hpp"
#include "base/checks.hpp"
#include "base/geometry.hpp"
#include "files/csv.hpp"
#include "files/node_reader.hpp"
#include "files/text_file.hpp"

// Sequence folders, part by part.

namespace cv { namespace surgtrack {

namespace {

void makeFolder(const String& folder)
{
    if (!utils::fs::isDirectory(folder) && !utils::fs::createDirectories(folder))
        CV_Error(Error::StsError, format("%s: the folder can't be made: %s", folder.c_str(), std::strerror(errno)));
}

void checkName(const String& name)
{
    if (name.empty() || name.find_first_of(",\"\r\n") != String::npos)
        CV_Error(Error::StsBadArg, "name: expected the name of a tool, without comma, quote and line break");
}

//! Writes a node as it is; matrices are maps with a type.
void copy(const FileNode& node, FileStorage& out)
{
    if (node.isMap() && !node["rows"].empty() && !node["cols"].empty() && !node["dt"].empty())
        out << node.mat();
    else if (node.isMap() || node.isSeq())
    {
        out << (node.isMap() ? "{" : "[");
        for (FileNodeIterator it = node.begin(); it != node.end(); ++it)
        {
            if (node.isMap())
                out << (*it).name();
            copy(*it, out);
        }
        out << (node.isMap() ? "}" : "]");
    }
    else if (node.isInt())
        out << (int)node;
    else if (node.isReal())
        out << (double)node;
    else
        out << (String)node;
}

/* sequence.yaml: the keys in the order of doc/formats.md, new values in the place of the old ones. */
class SequenceFile
{
public:
    explicit SequenceFile(const String& folder) : cameras(0), tool(0), fps(0), folder_(folder), filename_(utils::fs::join(folder, "sequence.yaml"))
    {
        makeFolder(folder);
        if (!utils::fs::exists(filename_))
            return;
        file_ = openStorage(filename_);
        root_ = file_.root();
    }

    const CameraPair* cameras;
    const SequenceTool* tool;
    String leftVideo, rightVideo;
    double fps;

    void write()
    {
        String text;
        try
        {
            text = composed();
        }
        catch (const Exception& e)   // of what is copied: a map that looks like a matrix, a key that is none
        {
            if (e.err.find(filename_) != String::npos) throw;
            importError(filename_, "can't be written anew: " + e.err);
        }
        writeContent(filename_, text);
    }

private:
    String composed()
    {
        FileStorage out(".yaml", FileStorage::WRITE | FileStorage::MEMORY | FileStorage::FORMAT_YAML);
        const String canonical = utils::fs::canonical(folder_);
        put(out, "name", canonical.substr(canonical.find_last_of("/\\") + 1), true);
        if (fps > 0)
            put(out, "fps", fps, false);
        else
            copyKey(out, "fps");
        if (cameras)
        {
            put(out, "image_width", cameras->left.imageSize().width, false);
            put(out, "image_height", cameras->left.imageSize().height, false);
            putCamera(out, "left", cameras->left, leftVideo);
            if (cameras->right.imageSize().area() > 0)
            {
                putCamera(out, "right", cameras->right, rightVideo);
                put(out, "right_T_left", Mat(cameras->right_T_left), false);
            }
            done_.insert("right");
            done_.insert("right_T_left");
        }
        const char* const keys[] = { "image_width", "image_height", "left", "right", "right_T_left", "kinematics", "groundtruth", "keypoints" };
        for (int i = 0; i < 8; i++)
            copyKey(out, keys[i]);
        for (FileNodeIterator it = root_.begin(); it != root_.end(); ++it)
            if ((*it).name() != "tools")
                copyKey(out, (*it).name());
        putTools(out);
        return out.releaseAndGetString();
    }

    void copyKey(FileStorage& out, const String& key)
    {
        if (root_[key].empty() || !done_.insert(key).second)
            return;
        out << key;
        copy(root_[key], out);
    }

    //! @param keep the old value goes before the new one
    template <typename T> void put(FileStorage& out, const String& key, const T& value, bool keep)
    {
        if (keep)
            copyKey(out, key);
        if (done_.insert(key).second)
            out << key << value;
    }

    void putCamera(FileStorage& out, const String& key, const CameraModel& camera, const String& video)
    {
        const FileNode old = root_[key];
        const FileNode oldVideo = old.isMap() ? old["video"] : FileNode();
        const String layout = root_["layout"].isString() ? (String)root_["layout"] : String();
        const bool ofLeft = key == "right" && !layout.empty() && layout != "separate";   // its images are in the left one's file
        out << key << "{";
        if (!video.empty() || oldVideo.isString() || !ofLeft)
            out << "video" << (!video.empty() ? video : oldVideo.isString() ? (String)oldVideo : key + ".mp4");
        const Mat distortion = camera.distCoeffs();
        int n = 12;   // no more than is needed, of the numbers OpenCV allows
        const int sizes[] = { 8, 5 };
        for (int i = 0; i < 2; i++)
            if (countNonZero(distortion.colRange(sizes[i], 12)) == 0)
                n = sizes[i];
        out << "camera_matrix" << Mat(camera.cameraMatrix()) << "distortion_coefficients" << distortion.colRange(0, n);
        if (old.isMap() && !old["mask"].empty())
        {
            out << "mask";
            copy(old["mask"], out);
        }
        out << "}";
        done_.insert(key);
    }

    void putTool(FileStorage& out, const FileNode& old)
    {
        const FileNode oldModel = old.isMap() ? old["model"] : FileNode();
        if (tool->model.empty() && !oldModel.isString())
            CV_Error(Error::StsBadArg, "model: expected the path of a tool file, tool '" + tool->name + "' is not in " + filename_ + " yet");
        out << "{" << "name" << tool->name << "model" << (tool->model.empty() ? (String)oldModel : tool->model);
        out << "camera_T_base" << Mat(tool->nominal_T_base) << "}";
    }

    void putTools(FileStorage& out)
    {
        const FileNode tools = root_["tools"];
        bool found = false;
        if (!tool && !tools.isSeq())
            return;
        out << "tools" << "[";
        for (FileNodeIterator it = tools.begin(); tools.isSeq() && it != tools.end(); ++it)
        {
            const FileNode name = (*it).isMap() ? (*it)["name"] : FileNode();
            const bool same = tool && name.isString() && (String)name == tool->name;
            if (same)
                putTool(out, *it);
            else
                copy(*it, out);
            found = found || same;
        }
        if (tool && !found)
            putTool(out, FileNode());
        out << "]";
    }

    String folder_, filename_;
    FileStorage file_;
    FileNode root_;
    std::set<String> done_;
};

//! Seconds with all digits a time has, whatever the locale.
String timeText(double time)
{
    std::ostringstream text;
    text.imbue(std::locale::classic());
    text.setf(std::ios::fixed);
    text.precision(6);
    text << time;
    return text.str();
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

} // namespace

void writeSequenceCameras(const String& folder, const CameraPair& cameras, const String& leftVideo, const String& rightVideo, double fps)
{
    if (cameras.left.imageSize().area() <= 0)
        CV_Error(Error::StsBadArg, "cameras: expected a left camera");
    if (cameras.right.imageSize().area() > 0 && cameras.right.imageSize() != cameras.left.imageSize())
        CV_Error(Error::StsBadSize, "cameras: expected images of the same size of both eyes");
    if (!(fps >= 0 && fps < DBL_MAX))
        CV_Error(Error::StsBadArg, format("fps is %g, expected frames per second, or 0", fps));
    if (!isRigid(cameras.right_T_left))
        CV_Error(Error::StsBadArg, "cameras: right_T_left: expected a rigid transform");
    SequenceFile file(folder);
    file.cameras = &cameras;
    file.leftVideo = leftVideo;
    file.rightVideo = rightVideo;
    file.fps = fps;
    file.write();
}

void writeSequenceTool(const String& folder, const String& name, const String& model, const Matx44d& nominal_T_base)
{
    checkName(name);
    if (!isRigid(nominal_T_base))
        CV_Error(Error::StsBadArg, "nominal_T_base: expected a rigid transform: rotation, translation [m], last row 0 0 0 1");
    SequenceTool tool;
    tool.name = name;
    tool.model = model;
    tool.nominal_T_base = nominal_T_base;
    SequenceFile file(folder);
    file.tool = &tool;
    file.write();
}

void writeSequenceJoints(const String& folder, const String& name, const std::vector<String>& coordinates, const std::vector<double>& times,
                         InputArray joints)
{
    checkName(name);
    const Mat values = joints.getMat();
    if (values.type() != CV_64F || values.rows != (int)times.size() || values.cols != (int)coordinates.size() || times.empty())
        CV_Error(Error::StsBadSize, format("joints: expected %d x %d numbers of type CV_64F, a row a time and a column a coordinate",
                                           (int)times.size(), (int)coordinates.size()));
    checkFinite(values, "joints");
    checkFinite(times, "times");
    for (size_t i = 1; i < times.size(); i++)
        if (!(times[i] > times[i - 1]))
            CV_Error(Error::StsBadArg, format("times[%d]: expected rising times, %g comes after %g", (int)i, times[i], times[i - 1]));
    makeFolder(folder);
    const String filename = utils::fs::join(folder, "kinematics.csv");
    String header = "time,tool";
    for (size_t i = 0; i < coordinates.size(); i++)
        header += "," + coordinates[i];
    Table table(header + "\n");
    if (utils::fs::exists(filename))
    {
        CsvReader csv(filename);
        const int toolColumn = csv.column("tool");
        String oldHeader;
        for (size_t i = 0; i < csv.header().size(); i++)
            oldHeader += (i ? "," : "") + csv.header()[i];
        while (csv.next())
        {
            if (name == csv.text(toolColumn))
                continue;
            if (oldHeader != header)
                importError(filename + ", line 1", "expected the columns " + header + ", as it has readings of another tool");
            for (size_t i = 0; i < csv.header().size(); i++)
                table << (i ? "," : "") << csv.text((int)i);
            table << "\n";
        }
    }
    for (int i = 0; i < values.rows; i++)
    {
        table << timeText(times[i]) << "," << name;
        for (int c = 0; c < values.cols; c++)
            table << "," << values.at<double>(i, c);
        table << "\n";
    }
    table.write(filename);
}

void writeHandEye(const String& sequence, const String& tool, const Matx44d& camera_T_base)
{
    CV_Assert(isRigid(camera_T_base) && "camera_T_base must be rigid");
    const String filename = utils::fs::isDirectory(sequence) ? utils::fs::join(sequence, "sequence.yaml") : sequence;
    const String before = readTextFile(filename);
    const FileStorage storage = parseStorage(filename, before);
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
        importError(filename, format("key tools has no tool '%s', expected one of: %s", tool.c_str(), known.c_str()), Error::StsObjectNotFound);
    if (!tools[index]["camera_T_base"].isMap())
        CV_Error(Error::StsParseError, format("%s: key tools[%d].camera_T_base is missing, expected a 4x4 matrix to replace", filename.c_str(), index));

    // The place is found in the text, so that comments and layout stay; the result is parsed to see that it was the right one.
    const String after = replaced(before, n, camera_T_base);
    const FileStorage check = parseStorage(filename, after);
    const Mat written = matrixOf(check["tools"][index]["camera_T_base"]);
    const String key = format("/tools/%d/camera_T_base", index);
    if (written.size() != Size(4, 4) || written.type() != CV_64F || Matx44d(written.ptr<double>()) != camera_T_base
        || !sameNodes(storage.root(), check.root(), "", key))
        CV_Error(Error::StsParseError, format("%s: key tools[%d].camera_T_base can't be replaced, expected a 4x4 opencv-matrix of type d with its numbers in brackets",
                                              filename.c_str(), index));
    writeContent(filename, after);
}

}} // namespace cv::surgtrack
