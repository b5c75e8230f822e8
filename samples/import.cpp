// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Brings files of other programs into the formats of this module.

#include "opencv2/surgtrack.hpp"
#include "opencv2/surgtrack/lab.hpp"
#include "opencv2/core/utils/filesystem.hpp"
#include "opencv2/videoio.hpp"
#include "support/common.hpp"
#include "support/video.hpp"

using namespace cv;
using namespace cv::surgtrack;

namespace {

const char* const KEYS =
    "{ help h       |      | print this }"
    "{ from         |      | format of the files: dvrk, urdf, tool (tools; tool: a tool file, for other keypoints); camera_info, opencv_stereo, surgpose (cameras); joints_csv, surgpose_joints "
    "(joint readings); daVinciToolTrack (a recording: joints, hand-eye and cameras); endovis15, surgpose_keypoints (labels) }"
    "{ in           |      | the files, separated by commas }"
    "{ out          |      | tools: tool file to write, YAML, its meshes beside it; labels: keypoints.csv to write }"
    "{ into         |      | cameras, joints, recordings: folder of the sequence to write into; is made if it does not exist }"
    "{ like         |      | tools: a tool file to take meshes, keypoints, jaws and the reported point from }"
    "{ meshes       |      | tools: mesh files LINK:FILE, separated by commas }"
    "{ mesh-scale   | 1    | tools: metres per unit of --meshes, 0.001 for millimetres }"
    "{ mesh-axes    | link | dvrk: axes of --meshes: link, or tool (those of tooltip_offset, as in dvrk_model) }"
    "{ keypoints    |      | tools: CSV file name,link,x,y,z of keypoints as picked in the meshes, or auto[:N]: N chosen where matching finds them, as is done if the tool has none; labels: LABEL:KEYPOINT, separated by commas }"
    "{ packages     |      | urdf: folder in which package:// is looked for }"
    "{ base         |      | urdf: link to take for the arm's base; without it the root }"
    "{ end-effector |      | urdf: link whose pose is reported }"
    "{ unit         |      | opencv_stereo: unit of the board the cameras were calibrated with: m, cm or mm; needed with two eyes }"
    "{ image-size   |      | opencv_stereo: WIDTHxHEIGHT, if the file does not have it }"
    "{ left         |      | cameras, recordings: video of the left camera }"
    "{ right        |      | the same of the right one }"
    "{ fps          |      | frames a second; without it that of the video }"
    "{ tool         |      | joints: name of the tool in the sequence; of surgpose_joints also the arm, PSM1 or PSM3 }"
    "{ jaw          |      | surgpose_joints: the jaw's angle, which the recording has not [rad] }"
    "{ model        |      | joints, daVinciToolTrack: tool file; a copy goes into the sequence }"
    "{ columns      |      | joints_csv: the columns of the tool's coordinates, separated by commas; without it by the names of dVRK and ROS }"
    "{ start        |      | joints_csv: time stamp of the first frame [s]; without it that of the first reading }"
    "{ hand-eye     |      | joints: file with the 4x4 matrix camera_T_base [m], or ...-registration-open-cv.json of the dVRK; puts the tool into sequence.yaml }"
    "{ tools        |      | labels: TOOL:NAME of the tools to write, separated by commas; without it all, by their names }"
    "{ quiet        |      | do not say what was written }";

std::vector<String> split(const String& text)
{
    std::vector<String> parts;
    for (size_t start = 0; !text.empty() && start <= text.size(); )
    {
        const size_t end = std::min(text.find(',', start), text.size());
        if (end > start)
            parts.push_back(text.substr(start, end - start));
        start = end + 1;
    }
    return parts;
}

class Import
{
public:
    explicit Import(const CommandLineParser& parser) : parser_(parser), in_(split(text("in"))) {}

    void run()
    {
        const String from = needed("from", "FORMAT");
        if (from == "dvrk" || from == "urdf" || from == "tool")
            importTool(from);
        else if (from == "camera_info" || from == "opencv_stereo" || from == "surgpose")
            importCameras(from);
        else if (from == "joints_csv")
            importReadings();
        else if (from == "surgpose_joints")
            importSurgPose();
        else if (from == "daVinciToolTrack")
            importRecording();
        else if (from == "endovis15" || from == "surgpose_keypoints")
            importLabels(from);
        else
            common::fail("argument '--from=" + from + "': expected dvrk, urdf, tool, camera_info, opencv_stereo, surgpose, joints_csv, "
                         "surgpose_joints, daVinciToolTrack, endovis15 or surgpose_keypoints");
    }

private:
    String text(const char* name) const { return parser_.get<String>(name); }

    String needed(const char* name, const char* value) const
    {
        if (text(name).empty())
            common::fail(format("expected --%s=%s, see --help", name, value));
        return text(name);
    }

    const std::vector<String>& files() const
    {
        needed("in", "FILE");
        return in_;
    }

    String oneFile() const
    {
        if (in_.size() != 1)
            common::fail("expected --in=FILE, one file");
        return in_[0];
    }

    void say(const String& line) const
    {
        if (!parser_.has("quiet"))
            std::printf("%s\n", line.c_str());
    }

    //! @param count auto or auto:N @param needed none are an error
    Ptr<ToolModel> withKeypoints(const Ptr<ToolModel>& model, const String& count, bool needed) const
    {
        try
        {
            return chooseKeypoints(model, count.size() > 5 ? std::atoi(count.c_str() + 5) : 24);
        }
        catch (const cv::Exception& e)
        {
            if (needed || e.code != Error::StsObjectNotFound)
                throw;
            say(e.err);
            return model;
        }
    }

    void importTool(const String& from) const
    {
        const String out = needed("out", "TOOL.yaml"), axes = text("mesh-axes");
        if (axes != "link" && axes != "tool")
            common::fail("argument '--mesh-axes=" + axes + "': expected link or tool");
        ToolParts parts;
        parts.like = text("like");
        parts.meshes = split(text("meshes"));
        parts.meshScale = common::number(parser_, "mesh-scale", 1e-9, 1e9);
        parts.meshesInToolAxes = axes == "tool";
        parts.keypoints = text("keypoints");
        parts.packages = text("packages");
        parts.base = text("base");
        parts.endEffector = text("end-effector");
        Ptr<ToolModel> model = from == "dvrk" ? importDvrkTool(files(), parts) : from == "urdf" ? importUrdfTool(oneFile(), parts) : ToolModel::load(oneFile(), 0);
        const bool asked = parts.keypoints.compare(0, 4, "auto") == 0;
        if ((asked && from == "tool") || (model->keypoints().empty() && !model->meshes().empty()))
            model = withKeypoints(model, asked ? parts.keypoints : String("auto"), asked);
        model->save(out);
        size_t triangles = 0;
        for (size_t i = 0; i < model->meshes().size(); i++)
            triangles += model->meshes()[i].triangles.size();
        say(format("%s: %d links, %d coordinates, %d meshes with %d triangles, %d keypoints", out.c_str(), (int)model->links().size(),
                   (int)model->coordinateNames().size(), (int)model->meshes().size(), (int)triangles, (int)model->keypoints().size()));
        const std::vector<String> findings = checkTool(model);
        for (size_t i = 0; i < findings.size(); i++)
            say(out + ": " + findings[i]);
        if (model->meshes().empty())
            say("meshes and keypoints are given by --meshes, --keypoints and --like");
    }

    //! The absolute path of a file, or of a pattern of files as img/%05d.png.
    static String absolute(const String& filename)
    {
        if (utils::fs::exists(filename))
            return utils::fs::canonical(filename);
        const size_t slash = filename.find_last_of("/\\");
        return utils::fs::join(utils::fs::canonical(slash == String::npos ? String(".") : filename.substr(0, slash + 1)), filename.substr(slash + 1));
    }

    //! The absolute path of a video, checked, and its rate if there is no other.
    static String video(const String& filename, Size size, double* fps)
    {
        if (filename.empty())
            return filename;
        VideoCapture capture(filename);
        if (!capture.isOpened())
            common::fail(filename + ": can't be read, expected a video");
        common::asRecorded(capture);
        common::noteTurned(capture, filename);
        const Size found(cvRound(capture.get(CAP_PROP_FRAME_WIDTH)), cvRound(capture.get(CAP_PROP_FRAME_HEIGHT)));
        if (found != size)
            common::fail(format("%s: images of %dx%d pixels, expected %dx%d as the camera was calibrated for", filename.c_str(), found.width,
                                found.height, size.width, size.height));
        common::warnOfRate(capture, filename, fps ? *fps : 0);
        if (fps && *fps == 0)
            *fps = capture.get(CAP_PROP_FPS);
        return absolute(filename);
    }

    double putCameras(const CameraPair& cameras) const
    {
        const String folder = needed("into", "DIR");
        double fps = text("fps").empty() ? 0 : common::number(parser_, "fps", 1e-3, 1e5);
        const Size size = cameras.left.imageSize();
        const bool stereo = cameras.right.imageSize().area() > 0;
        if (!stereo && !text("right").empty())
            common::fail("argument '--right': the calibration has one eye only");
        const String left = video(text("left"), size, &fps), right = video(text("right"), size, 0);
        writeSequenceCameras(folder, cameras, left, right, fps);
        const Matx44d& T = cameras.right_T_left;
        say(folder + format("/sequence.yaml: %s of %dx%d pixels, fx %.1f, fy %.1f", stereo ? "two cameras" : "camera", size.width, size.height,
                            cameras.left.fx, cameras.left.fy)
            + (stereo ? format(", baseline %.2f mm", 1e3 * norm(Vec3d(T(0, 3), T(1, 3), T(2, 3)))) : String()));
        return fps;
    }

    void importCameras(const String& from) const
    {
        if (from == "camera_info")
            putCameras(importCameraInfo(files()));
        else if (from == "surgpose")
            putCameras(importSurgPoseCameras(oneFile()));
        else
        {
            const String unit = text("unit"), sizeText = text("image-size");
            if (!unit.empty() && unit != "m" && unit != "cm" && unit != "mm")
                common::fail("argument '--unit=" + unit + "': expected m, cm or mm");
            Size size;
            char rest;
            if (!sizeText.empty() && (std::sscanf(sizeText.c_str(), "%dx%d%c", &size.width, &size.height, &rest) != 2 || size.width <= 0
                                      || size.height <= 0))
                common::fail("argument '--image-size=" + sizeText + "': expected WIDTHxHEIGHT");
            putCameras(importOpenCVCameras(files(), unit.empty() ? 0 : unit == "m" ? 1 : unit == "cm" ? 0.01 : 0.001, size));
        }
    }

    //! Copies the tool file into the sequence. @return its path there
    static String putModel(const ToolModel& model, const String& filename, const String& folder)
    {
        const String base = filename.substr(filename.find_last_of("/\\") + 1), stem = base.substr(0, base.rfind('.'));
        const bool urdf = base.size() > 5 && base.substr(base.size() - 5) == ".urdf";
        const String name = "tool/" + (urdf ? stem + ".yaml" : base), tools = utils::fs::join(folder, "tool");
        if (!utils::fs::createDirectories(tools))
            common::fail(tools + ": the folder can't be made");
        model.save(utils::fs::join(folder, name));
        return name;
    }

    void importReadings() const
    {
        needed("into", "DIR");
        needed("tool", "NAME");
        const Ptr<ToolModel> model = loadTool(needed("model", "TOOL.yaml"), 0);
        std::vector<double> times;
        Mat joints;
        importJoints(files(), model->coordinateNames(), times, joints, split(text("columns")));
        const double start = text("start").empty() ? times[0] : common::number(parser_, "start", -1e300, 1e300);
        for (size_t i = 0; i < times.size(); i++)
            times[i] -= start;
        putReadings(model, times, joints);
    }

    //! --into, --tool, --model and --hand-eye say where.
    void putReadings(const Ptr<ToolModel>& model, const std::vector<double>& times, const Mat& joints) const
    {
        const String folder = needed("into", "DIR"), tool = needed("tool", "NAME"), filename = text("model");
        const String fault = checkUnits(model, joints);
        if (!fault.empty())
            common::fail(in_[0] + ": " + fault);
        writeSequenceJoints(folder, tool, model->coordinateNames(), times, joints);
        if (!text("hand-eye").empty())
            writeSequenceTool(folder, tool, putModel(*model, filename, folder), importHandEye(text("hand-eye")));
        say(folder + format("/kinematics.csv: %d readings of %s from %.3f to %.3f s", (int)times.size(), tool.c_str(), times[0], times.back()));
    }

    void importSurgPose() const
    {
        const Ptr<ToolModel> model = loadTool(needed("model", "TOOL.yaml"), 0);
        const double jaw = text("jaw").empty() ? 0 : common::number(parser_, "jaw", -7, 7);
        needed("fps", "NUMBER");
        const double fps = common::number(parser_, "fps", 1e-3, 1e5);
        Mat joints;
        importSurgPoseJoints(oneFile(), needed("tool", "PSM1"), (int)model->coordinateNames().size(), jaw, joints);
        std::vector<double> times;
        for (int frame = 0; frame < joints.rows; frame++)
            times.push_back(frame / fps);
        if (text("jaw").empty())
            say("the recording has no jaw: it is taken to be closed, at 0 rad, see --jaw");
        putReadings(model, times, joints);
    }

    //! The file of the folder whose name starts and ends so.
    static String fileOf(const String& folder, const String& pattern)
    {
        std::vector<String> found;
        utils::fs::glob(folder, pattern, found);
        if (found.size() != 1)
            common::fail(utils::fs::join(folder, pattern) + format(": found %d files, expected one", (int)found.size()));
        return found[0];
    }

    void importRecording() const
    {
        const String folder = needed("into", "DIR"), source = oneFile(), filename = needed("model", "TOOL.yaml");
        const Ptr<ToolModel> model = loadTool(filename, 0);
        const String handEye = fileOf(source, "*handeye_data.xml");
        const double fps = putCameras(importOpenCVCameras(std::vector<String>(1, fileOf(source, "*camera_data.xml")), 1e-3));
        if (!(fps > 0))
            common::fail("expected --fps=NUMBER or --left=VIDEO, the recording does not say its frame rate");
        const String copy = putModel(*model, filename, folder);
        for (int arm = 1; arm <= 2; arm++)
        {
            const String tool = format("PSM%d", arm);
            Mat joints;
            importDaVinciJoints(fileOf(source, "*" + tool + "*.xml"), model, joints);
            std::vector<double> times;
            for (int frame = 0; frame < joints.rows; frame++)
                times.push_back(frame / fps);
            writeSequenceTool(folder, tool, copy, importDaVinciHandEye(handEye, format("bHc_psm%d", arm)));
            writeSequenceJoints(folder, tool, model->coordinateNames(), times, joints);
            say(folder + format("/kinematics.csv: %d readings of %s", joints.rows, tool.c_str()));
        }
    }

    void importLabels(const String& from) const
    {
        const String out = needed("out", "keypoints.csv");
        const std::vector<String> keypoints = split(text("keypoints")), tools = split(text("tools"));
        const int n = from == "endovis15" ? importEndoVisKeypoints(oneFile(), out, keypoints, tools)
                                          : importSurgPoseKeypoints(oneFile(), out, keypoints, tools);
        say(format("%s: %d points", out.c_str(), n));
    }

    const CommandLineParser& parser_;
    std::vector<String> in_;
};

int run(const CommandLineParser& parser)
{
    Import(parser).run();
    return 0;
}

} // namespace

int main(int argc, char** argv)
{
    const common::Program program = { "import", "Brings files of other programs into the formats of this module.",
                                      KEYS, { "from", "in", "out", "into", "like", "meshes", "mesh-scale", "mesh-axes", "keypoints", "packages",
                                        "base", "end-effector", "unit", "image-size", "left", "right", "fps", "tool", "jaw", "model",
                                        "columns", "start", "hand-eye", "tools" }, { "quiet" } };
    return common::runProgram(argc, argv, program, run);
}
