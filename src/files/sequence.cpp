// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include <mutex>
#include "opencv2/core/utils/filesystem.hpp"
#include "opencv2/surgtrack/sequence.hpp"
#include "base/geometry.hpp"
#include "files/csv.hpp"
#include "files/node_reader.hpp"
#include "files/text_file.hpp"

namespace cv { namespace surgtrack {

namespace {

const double farthest = 10;    // [m]; no arm reaches further, but in millimetres most do

int findTool(const std::vector<SequenceTool>& tools, const CsvReader& csv, int column)
{
    for (size_t i = 0; i < tools.size(); i++)
        if (tools[i].name == csv.text(column))
            return (int)i;
    csv.fail(format("tool '%s' is none of the tools of sequence.yaml", csv.text(column)));
}

Matx44d near(const NodeReader& node)
{
    const Matx44d T = node.rigid();
    const double distance = norm(Vec3d(T(0, 3), T(1, 3), T(2, 3)));
    if (distance > farthest)
        node.expected(format("metres, not millimetres: it is %.4g m away", distance));
    return T;
}

//! The columns of a pose: translation [m], unit quaternion.
struct PoseColumns
{
    explicit PoseColumns(const CsvReader& csv)
    {
        const char* const names[] = { "tx", "ty", "tz", "qx", "qy", "qz", "qw" };
        for (int i = 0; i < 7; i++)
            at[i] = csv.column(names[i]);
    }
    Matx44d read(const CsvReader& csv) const
    {
        double p[7];
        for (int i = 0; i < 7; i++)
            p[i] = csv.number(at[i]);
        const Vec4d q(p + 3);
        if (std::abs(norm(q) - 1) > 0.01)
            csv.fail(format("qx,qy,qz,qw has length %g, expected a unit quaternion", norm(q)));
        return rigidTransform(rotationFromQuaternion(q), Vec3d(p));
    }
    int at[7];
};

} // namespace

SequenceTool::SequenceTool() : nominal_T_base(Matx44d::eye()), timeOffset(0) {}

TrueKeypoint::TrueKeypoint() : visible(false) {}

//! Of keypoints.csv, which few need: it is read when it is first asked for, by any thread.
struct Sequence::KeypointRecords
{
    KeypointRecords() : read(false) {}
    std::mutex mutex;
    bool read;
    std::vector<std::map<int, std::vector<TrueKeypoint> > > frames;   // a tool, by frame
};

Sequence::Sequence()
    : layout_(LAYOUT_SEPARATE), fields_(0), fps_(0), right_T_left_(Matx44d::eye()), hasGroundTruth_(false), keypoints_(makePtr<KeypointRecords>())
{
}

Ptr<Sequence> Sequence::load(const String& folder, bool recorded)
{
    const bool isFile = utils::fs::exists(folder) && !utils::fs::isDirectory(folder);
    const String filename = isFile ? folder : utils::fs::join(folder, "sequence.yaml");
    if (!utils::fs::exists(filename))
        CV_Error(Error::StsObjectNotFound, format("%s: there is no such file", filename.c_str()));
    Ptr<Sequence> sequence(new Sequence());
    sequence->readDescription(filename, recorded);
    if (recorded)
    {
        sequence->readKinematics();
        sequence->readGroundTruth();
    }
    return sequence;
}

void Sequence::readDescription(const String& filename, bool recorded)
{
    const char* const table = "the path of a CSV file";
    const FileStorage file = openStorage(filename);
    const NodeReader root(filename, file.root());
    filename_ = filename;
    const std::vector<String> keys = {"name", "fps", "frames", "image_width", "image_height", "layout", "fields", "mask", "left", "right",
                                      "right_T_left", "kinematics", "groundtruth", "keypoints", "tools"};
    root.checkSpelling(keys);
    const NodeReader kinematics = root["kinematics"], truth = root["groundtruth"];

    name_ = root.has("name") ? root["name"].text() : utils::fs::canonical(besideFile(filename, "."));
    name_ = name_.substr(name_.find_last_of("/\\") + 1);
    const NodeReader frames = root["frames"];
    if (recorded)
        readFrames(frames.isThere() ? frames.path(table) : besideFile(filename, "frames.csv"));
    if (frames_.empty() || root.has("fps"))
        fps_ = root["fps"].number();
    if (fps_ <= 0)
        root["fps"].expected("a number larger than 0 [frames/s]");
    readImages(root, recorded);
    if (root.has("right"))
        right_T_left_ = near(root["right_T_left"]);
    kinematicsFile_ = kinematics.isThere() ? kinematics.path(table) : besideFile(filename, "kinematics.csv");
    groundTruthFile_ = truth.isThere() ? truth.path(table) : besideFile(filename, "groundtruth.csv");
    const NodeReader keypoints = root["keypoints"];
    keypointsFile_ = keypoints.isThere() ? keypoints.path(table) : besideFile(filename, "keypoints.csv");

    const std::vector<NodeReader> tools = root["tools"].sequence();
    if (tools.empty())
        root["tools"].expected("at least one tool");
    for (size_t i = 0; i < tools.size(); i++)
    {
        SequenceTool tool;
        tools[i].checkSpelling({"name", "model", "camera_T_base", "time_offset"});
        const NodeReader name = tools[i]["name"];
        tool.name = name.text();
        for (size_t j = 0; j < i; j++)
            if (tools_[j].name == tool.name)
                name.expected("another name for each tool");
        if (tool.name.find_first_of(",\"\r\n") != String::npos)
            name.expected("a name without comma, quote and line break");
        tool.model = tools[i]["model"].path("the path of a tool file");
        tool.nominal_T_base = near(tools[i]["camera_T_base"]);
        if (tools[i].has("time_offset"))
            tool.timeOffset = tools[i]["time_offset"].number();
        tools_.push_back(tool);
    }
}

void Sequence::readKinematics()
{
    CsvReader csv(kinematicsFile_);
    const int timeColumn = csv.column("time"), toolColumn = csv.column("tool");
    std::vector<int> columns;
    for (int i = 0; i < (int)csv.header().size(); i++)
        if (i != timeColumn && i != toolColumn)
        {
            columns.push_back(i);
            jointNames_.push_back(csv.header()[i]);
        }
    if (columns.empty())
        CV_Error(Error::StsParseError, format("%s, line 1: expected columns of joints after time and tool", kinematicsFile_.c_str()));
    records_.resize(tools_.size());
    while (csv.next())
    {
        JointRecords& records = records_[findTool(tools_, csv, toolColumn)];
        const double time = csv.number(timeColumn);
        if (!records.times.empty() && time <= records.times.back())
            csv.fail(format("time %g of tool '%s' does not come after %g", time, csv.text(toolColumn), records.times.back()));
        records.times.push_back(time);
        for (size_t i = 0; i < columns.size(); i++)
            records.values.push_back(csv.number(columns[i]));
    }
    for (size_t i = 0; i < tools_.size(); i++)
        if (records_[i].times.empty())
            CV_Error(Error::StsParseError, format("%s: expected lines of tool '%s'", kinematicsFile_.c_str(), tools_[i].name.c_str()));
}

void Sequence::readGroundTruth()
{
    truth_.resize(tools_.size());
    hasGroundTruth_ = utils::fs::exists(groundTruthFile_);
    if (!hasGroundTruth_)
        return;
    CsvReader csv(groundTruthFile_);
    const int frameColumn = csv.column("frame"), toolColumn = csv.column("tool");
    const PoseColumns pose(csv);
    std::vector<int> jointColumns;
    for (size_t i = 0; i < jointNames_.size(); i++)
        jointColumns.push_back(csv.find(jointNames_[i]));
    if (std::count(jointColumns.begin(), jointColumns.end(), -1) > 0)
        jointColumns.clear();
    while (csv.next())
    {
        std::map<int, Truth>& truth = truth_[findTool(tools_, csv, toolColumn)];
        const int frame = csv.count(frameColumn);
        if (truth.count(frame))
            csv.fail(format("frame %d of tool '%s' is there twice", frame, csv.text(toolColumn)));
        const Matx44d camera_T_tool = pose.read(csv);
        Truth& t = truth[frame];
        t.camera_T_tool = camera_T_tool;
        for (size_t i = 0; i < jointColumns.size(); i++)
            t.joints.push_back(csv.number(jointColumns[i]));
    }
}

void Sequence::readKeypoints() const
{
    std::vector<std::map<int, std::vector<TrueKeypoint> > > frames(tools_.size());
    if (hasKeypoints())
    {
        CsvReader csv(keypointsFile_);
        const int frameColumn = csv.column("frame"), toolColumn = csv.column("tool"), nameColumn = csv.column("keypoint");
        const int u = csv.column("u"), v = csv.column("v"), visibleColumn = csv.column("visible");
        const int x = csv.find("x"), y = csv.find("y"), z = csv.find("z");
        while (csv.next())
        {
            TrueKeypoint point;
            point.name = csv.text(nameColumn);
            point.imagePoint = Point2d(csv.number(u), csv.number(v));
            if (x >= 0 && y >= 0 && z >= 0 && *csv.text(x))
                point.cameraPoint = Point3d(csv.number(x), csv.number(y), csv.number(z));
            const int visible = csv.count(visibleColumn);
            if (visible > 1)
                csv.fail(format("visible is '%s', expected 0 or 1", csv.text(visibleColumn)));
            point.visible = visible == 1;
            frames[findTool(tools_, csv, toolColumn)][csv.count(frameColumn)].push_back(point);
        }
    }
    keypoints_->frames.swap(frames);
    keypoints_->read = true;
}

SequenceTool Sequence::tool(int index) const
{
    CV_CheckGE(index, 0, "tool index");
    CV_CheckLT(index, toolCount(), "tool index");
    return tools_[index];
}

const Sequence::JointRecords& Sequence::records(int tool) const
{
    CV_CheckGE(tool, 0, "tool index");
    CV_CheckLT(tool, toolCount(), "tool index");
    if (records_.empty())
        CV_Error(Error::StsBadArg, "the sequence was loaded without its recording");
    return records_[tool];
}

double Sequence::firstTime(int tool) const { return records(tool).times.front() - tools_[tool].timeOffset; }
double Sequence::lastTime(int tool) const { return records(tool).times.back() - tools_[tool].timeOffset; }

bool Sequence::jointsAt(int tool, double time, std::vector<double>& joints, const std::vector<String>& coordinates) const
{
    const std::vector<double>& times = records(tool).times;
    time += tools_[tool].timeOffset;
    const double interval = times.size() > 1 ? (times.back() - times.front()) / (times.size() - 1) : 0;
    const double slack = interval * (1 + 1e-6);   // times are rounded in the file
    if (!(time >= times.front() - slack && time <= times.back() + slack))
        return false;
    const size_t n = jointNames_.size();
    size_t after = std::upper_bound(times.begin(), times.end(), time) - times.begin();
    after = std::min(std::max(after, (size_t)1), times.size() - 1);   // 0 if there is a single record
    const size_t before = after > 0 ? after - 1 : 0;
    const double span = times[after] - times[before];
    const double weight = span > 0 ? std::min(std::max((time - times[before]) / span, 0.), 1.) : 0;
    const double* a = &records_[tool].values[before * n];
    const double* b = &records_[tool].values[after * n];
    const size_t wanted = coordinates.empty() ? n : coordinates.size();
    std::vector<double> result(wanted);
    for (size_t i = 0; i < wanted; i++)
    {
        const size_t column = coordinates.empty() ? i : std::find(jointNames_.begin(), jointNames_.end(), coordinates[i]) - jointNames_.begin();
        if (column == n)
            CV_Error(Error::StsObjectNotFound, format("%s, line 1: expected a column '%s', a coordinate of tool '%s'", kinematicsFile_.c_str(),
                     coordinates[i].c_str(), tools_[tool].name.c_str()));
        result[i] = a[column] + weight * (b[column] - a[column]);
    }
    joints.swap(result);
    return true;
}

bool Sequence::hasGroundTruth() const { return hasGroundTruth_; }

int Sequence::groundTruthEnd() const
{
    int end = 0;
    for (size_t i = 0; i < truth_.size(); i++)
        if (!truth_[i].empty())
            end = std::max(end, truth_[i].rbegin()->first + 1);
    return end;
}

bool Sequence::groundTruth(int tool, int frame, Matx44d& camera_T_tool, std::vector<double>& joints) const
{
    records(tool);   // checks the index
    const std::map<int, Truth>::const_iterator it = truth_[tool].find(frame);
    if (it == truth_[tool].end())
        return false;
    camera_T_tool = it->second.camera_T_tool;
    joints = it->second.joints;
    return true;
}

bool Sequence::hasKeypoints() const { return !records_.empty() && utils::fs::exists(keypointsFile_); }

std::vector<TrueKeypoint> Sequence::keypoints(int tool, int frame) const
{
    records(tool);   // checks the index
    const std::lock_guard<std::mutex> lock(keypoints_->mutex);
    if (!keypoints_->read)
        readKeypoints();
    const std::map<int, std::vector<TrueKeypoint> >& frames = keypoints_->frames[tool];
    const std::map<int, std::vector<TrueKeypoint> >::const_iterator it = frames.find(frame);
    return it == frames.end() ? std::vector<TrueKeypoint>() : it->second;
}

bool readPoses(const String& filename, std::vector<double>& keys, OutputArray poses)
{
    CsvReader file(filename);
    const bool byTime = file.find("time") >= 0;
    if (byTime == (file.find("index") >= 0))
        CV_Error(Error::StsParseError, filename + ", line 1: expected a column 'index' or a column 'time', one of them");
    const int key = file.column(byTime ? "time" : "index");
    const PoseColumns pose(file);
    std::vector<double> found;
    Mat_<double> rows(0, 16);
    while (file.next())
    {
        const Matx44d T = pose.read(file);
        const double distance = norm(Vec3d(T(0, 3), T(1, 3), T(2, 3)));
        if (distance > farthest) file.fail(format("tx,ty,tz is %.4g m away, expected metres, not millimetres", distance));
        found.push_back(byTime ? file.number(key) : file.count(key));
        if (found.size() > 1 && found.back() <= found[found.size() - 2])
            file.fail(format("%s is %.10g after %.10g, expected rising values", byTime ? "time" : "index", found.back(), found[found.size() - 2]));
        rows.push_back(Mat(T).reshape(1, 1));
    }
    if (found.empty()) CV_Error(Error::StsParseError, filename + ": has no poses");
    keys.swap(found);
    rows.copyTo(poses);
    return byTime;
}

}} // namespace cv::surgtrack
