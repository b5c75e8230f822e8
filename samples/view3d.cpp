// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Shows a tracked sequence from outside: camera, image, tools as they were found and as the calibration believes, and the tips' paths.

#include <fstream>
#include <map>
#include <sstream>
#include "opencv2/imgcodecs.hpp"
#include "opencv2/imgproc.hpp"
#include "opencv2/surgtrack.hpp"
#include "opencv2/surgtrack/lab.hpp"
#include "support/common.hpp"
#include "support/frame_reader.hpp"
#include "support/tools.hpp"

using namespace cv;
using namespace cv::surgtrack;
using common::fail;

namespace {

const char* const KEYS =
    "{ help h   |    | print this }"
    "{ sequence |    | folder of the sequence }"
    "{ poses    |    | poses file that track_sequence wrote for it }"
    "{ frame    | -1 | the frame to show, with the paths until then; -1 = the last one of the poses file }"
    "{ out      |    | PNG or JPG file to write; needs no display }"
    "{ window   |    | show it in a window: the left button turns, the wheel comes nearer, q ends }";

struct Pose
{
    double time;   // [s]
    bool known;    // tracking or coasting
    Matx44d camera_T_tool;
    std::map<std::string, double> offsets;   // of the readings, by coordinate
};

typedef std::map<int, std::map<std::string, Pose> > Poses;   // by frame and tool

std::vector<std::string> cells(const std::string& line)
{
    std::vector<std::string> result;
    std::stringstream stream(line.substr(0, line.find('\r')));
    for (std::string cell; std::getline(stream, cell, ',');)
        result.push_back(cell);
    return result;
}

double number(const std::string& filename, int line, const std::string& column, const std::string& cell)
{
    char* end = 0;
    const double value = std::strtod(cell.c_str(), &end);
    if (end == cell.c_str() || *end || !(std::abs(value) < 1e12))
        fail(format("%s, line %d: %s is '%s', expected a number", filename.c_str(), line, column.c_str(), cell.c_str()));
    return value;
}

Matx44d poseOf(const Vec3d& t, const Vec4d& q)
{
    const double x = q[0], y = q[1], z = q[2], w = q[3];
    return Matx44d(1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), t[0],
                   2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w), t[1],
                   2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y), t[2], 0, 0, 0, 1);
}

Poses readPoses(const std::string& filename)
{
    std::ifstream file(filename.c_str());
    std::string text;
    if (!std::getline(file, text))
        fail(filename + ": can't be read, expected a poses file of track_sequence");
    const std::vector<std::string> header = cells(text);
    const char* const wanted[] = { "frame", "time", "tool", "status", "tx", "ty", "tz", "qx", "qy", "qz", "qw" };
    std::map<std::string, size_t> column;
    for (size_t i = 0; i < header.size(); i++)
        column[header[i]] = i;
    for (size_t i = 0; i < 11; i++)
        if (!column.count(wanted[i]))
            fail(filename + ": expected a column '" + wanted[i] + "'");
    Poses poses;
    for (int line = 2; std::getline(file, text); line++)
    {
        std::vector<std::string> row = cells(text);
        row.resize(header.size());   // the last cells may be empty
        double values[7];
        for (int i = 0; i < 7; i++)
            values[i] = number(filename, line, wanted[4 + i], row[column[wanted[4 + i]]]);
        const Vec4d q(values[3], values[4], values[5], values[6]);
        if (std::abs(norm(q) - 1) > 1e-3)   // written with nine digits; this only refuses what is no quaternion
            fail(format("%s, line %d: qx..qw have length %g, expected 1", filename.c_str(), line, norm(q)));
        Pose& pose = poses[(int)number(filename, line, "frame", row[column["frame"]])][row[column["tool"]]];
        pose.time = number(filename, line, "time", row[column["time"]]);
        pose.known = row[column["status"]] == "tracking" || row[column["status"]] == "coasting";
        pose.camera_T_tool = poseOf(Vec3d(values), q * (1 / norm(q)));
        for (size_t i = 0; i < header.size(); i++)
            if (header[i].compare(0, 7, "offset_") == 0 && !row[i].empty())
                pose.offsets[header[i].substr(7)] = number(filename, line, header[i], row[i]);
    }
    if (poses.empty())
        fail(filename + ": has no poses");
    return poses;
}

//! The tool as it was found, then as the calibration has it.
void addTool(const Sequence& sequence, int index, const Ptr<ToolModel>& model, const Pose& pose, std::vector<DrawnTool>& found, std::vector<DrawnTool>& nominal)
{
    const SequenceTool info = sequence.tool(index);
    std::vector<double> joints;
    if (!sequence.jointsAt(index, pose.time, joints, model->coordinateNames()))
        fail(format("%s: no joint readings of tool '%s' at %.3f s", sequence.kinematicsFile().c_str(), info.name.c_str(), pose.time));
    nominal.push_back(DrawnTool(model, joints, info.nominal_T_base, Scalar(60, 60, 230), 0.3));
    const std::vector<String> coordinates = model->coordinateNames();
    for (size_t i = 0; i < coordinates.size(); i++)
        if (pose.offsets.count(coordinates[i]))
            joints[i] += pose.offsets.find(coordinates[i])->second;
    const Matx44d camera_T_base = pose.camera_T_tool * model->endEffectorPose(joints).inv();
    const Scalar colors[] = { Scalar(90, 190, 60), Scalar(200, 140, 40), Scalar(40, 170, 220), Scalar(180, 80, 180) };
    found.push_back(DrawnTool(model, joints, camera_T_base, pose.known ? colors[index % 4] : Scalar::all(150), 1));
}

Mat pathOf(const Poses& poses, const std::string& tool, int until)
{
    Mat path;
    for (Poses::const_iterator i = poses.begin(); i != poses.end() && i->first <= until; ++i)
        if (i->second.count(tool) && i->second.at(tool).known)
        {
            const Matx44d& T = i->second.at(tool).camera_T_tool;
            path.push_back(Mat(Matx13d(T(0, 3), T(1, 3), T(2, 3))));
        }
    return path;
}

Mat frameOf(const Sequence& sequence, int frame)
{
    common::FrameReader reader(sequence, frame);
    Mat image;
    if (!reader.read(image))
        fail(format("%s: has no frame %d", sequence.leftVideo().c_str(), frame));
    return image;
}

int view(const CommandLineParser& parser)
{
    const String folder = parser.get<String>("sequence"), posesFile = parser.get<String>("poses"), out = parser.get<String>("out");
    const bool window = parser.has("window");
    if (folder.empty())
        fail("argument '--sequence': expected the folder of a sequence");
    if (posesFile.empty())
        fail("argument '--poses': expected the poses file of a run");
    if (out.empty() && !window)
        fail("argument '--out': expected a file to write, or --window");
    int frame = common::integer(parser, "frame", -1);

    const Ptr<Sequence> sequence = Sequence::load(folder);
    const Poses poses = readPoses(posesFile);
    if (frame < 0)
        frame = poses.rbegin()->first;
    if (!poses.count(frame))
        fail(format("%s: has no frame %d", posesFile.c_str(), frame));
    std::vector<DrawnTool> tools, nominal;
    std::vector<Mat> paths;
    const std::vector<common::Tool> loaded = common::loadTools(*sequence);
    for (int i = 0; i < sequence->toolCount(); i++)
    {
        const SequenceTool info = sequence->tool(i);
        if (!poses.at(frame).count(info.name))
            fail(format("%s: has no tool '%s' in frame %d", posesFile.c_str(), info.name.c_str(), frame));
        addTool(*sequence, i, loaded[i].model, poses.at(frame).at(info.name), tools, nominal);
        paths.push_back(pathOf(poses, info.name, frame));
    }
    tools.insert(tools.end(), nominal.begin(), nominal.end());   // what is seen through comes last

    const Ptr<SceneView> scene = SceneView::create(sequence->leftCamera(), Size(960, 720), window);
    Mat picture;
    scene->draw(frameOf(*sequence, frame), tools, paths, picture);
    if (!out.empty())
    {
        putText(picture, format("%s, frame %d   red: as the calibration has it", sequence->name().c_str(), frame), Point(12, picture.rows - 14),
                FONT_HERSHEY_SIMPLEX, 0.55, Scalar::all(40), 1, LINE_AA);
        bool written = false;
        try
        {
            written = imwrite(out, picture);
        }
        catch (const Exception&)   // of a name without a known extension
        {
        }
        if (!written)
            fail(out + ": can't be written, expected a name such as scene.png in a folder that exists");
    }
    if (window)
        scene->show();
    return 0;
}

} // namespace

int main(int argc, char** argv)
{
    const common::Program program = { "view3d", "Shows camera, image and tools of a tracked sequence from outside.",
                                      KEYS, { "sequence", "poses", "frame", "out" }, { "window" } };
    return common::runProgram(argc, argv, program, view);
}
