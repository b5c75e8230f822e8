// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include <cerrno>
#include <cstring>
#include "opencv2/core/utils/filesystem.hpp"
#include "opencv2/videoio.hpp"
#include "opencv2/surgtrack/part_templates.hpp"
#include "base/geometry.hpp"
#include "files/text_file.hpp"
#include "lab/synthetic/synthetic_write.hpp"
#include "render/tool_instances.hpp"

namespace cv { namespace surgtrack {

namespace {

const double RECORD_RATE = 100;    // [Hz]

//! A video file that is complete when finish() returns.
class VideoFile
{
public:
    VideoFile(const String& filename, double fps, Size size) : filename_(filename), frames_(0)
    {
        // MPEG-4 is written with a bit a pixel, as recordings are; H.264 with its default quality, a twentieth of that here, bends edges.
        if (!writer_.open(filename, VideoWriter::fourcc('m', 'p', '4', 'v'), fps, size))
            writer_.open(filename, VideoWriter::fourcc('a', 'v', 'c', '1'), fps, size);
        if (!writer_.isOpened())
            CV_Error(Error::StsError, format("%s: can't be written as H.264 or MPEG-4 video", filename.c_str()));
    }
    void write(const Mat& image)
    {
        writer_.write(image);
        frames_++;
    }
    void finish()    // VideoWriter does not tell when the disk is full
    {
        writer_.release();
        VideoCapture check(filename_);
        if (!check.isOpened() || check.get(CAP_PROP_FRAME_COUNT) < frames_)
            CV_Error(Error::StsError, format("%s: not all of its %d frames were written, is the disk full?", filename_.c_str(), frames_));
    }

private:
    VideoWriter writer_;
    String filename_;
    int frames_;
};

String toolName(int tool) { return format("PSM%d", tool + 1); }

void writeCamera(FileStorage& file, const char* key, const char* video, const CameraModel& camera)
{
    file << key << "{" << "video" << video << "camera_matrix" << Mat(camera.cameraMatrix()) << "distortion_coefficients"
         << camera.distCoeffs().colRange(0, 5) << "}";
}

void writeDescription(const SyntheticScene& scene, const SyntheticScene::Params& params, const String& toolFile, const String& folder)
{
    FileStorage file(".yaml", FileStorage::WRITE | FileStorage::MEMORY | FileStorage::FORMAT_YAML);
    file << "name" << "synthetic" << "fps" << params.fps << "image_width" << params.imageSize.width << "image_height" << params.imageSize.height;
    writeCamera(file, "left", "left.mp4", scene.camera());
    if (params.stereo)
    {
        writeCamera(file, "right", "right.mp4", scene.camera(true));
        file << "right_T_left" << Mat(scene.right_T_left());
    }
    file << "kinematics" << "kinematics.csv" << "groundtruth" << "groundtruth.csv" << "keypoints" << "keypoints.csv" << "tools" << "[";
    for (int i = 0; i < scene.toolCount(); i++)
        file << "{" << "name" << toolName(i) << "model" << toolFile << "camera_T_base" << Mat(scene.nominal_T_base(i)) << "}";
    file << "]";
    writeContent(utils::fs::join(folder, "sequence.yaml"), file.releaseAndGetString());
}

void addJoints(Table& table, const std::vector<double>& joints)
{
    for (size_t i = 0; i < joints.size(); i++)
        table << "," << joints[i];
    table << "\n";
}

void writeKinematics(const SyntheticScene& scene, const SyntheticScene::Params& params, const String& jointHeader, const String& filename)
{
    Table table("time,tool" + jointHeader);
    const int records = cvCeil((params.frames - 1) / params.fps * RECORD_RATE) + 4;
    for (int k = 0; k < records; k++)
        for (int i = 0; i < scene.toolCount(); i++)
        {
            table << format("%d.%02d", k / 100, k % 100) << "," << toolName(i);
            addJoints(table, scene.recordedJoints(i, k / RECORD_RATE));
        }
    table.write(filename);
}

class TruthWriter
{
public:
    TruthWriter(const SyntheticScene& scene, const SyntheticScene::Params& params, const String& jointHeader)
        : scene_(scene), fps_(params.fps), model_(scene.model()), camera_(scene.camera()), renderer_(MeshRenderer::createSoftware()), firstMesh_(renderer_->addTool(model_)),
          poses_("frame,time,tool,tx,ty,tz,qx,qy,qz,qw" + jointHeader), keypoints_("frame,tool,keypoint,u,v,x,y,z,visible\n")
    {
    }

    void add(int frame)
    {
        const double time = frame / fps_;
        std::vector<MeshInstance> instances;
        std::vector<std::vector<Matx44d> > base_T_links;
        for (int i = 0; i < scene_.toolCount(); i++)
        {
            std::vector<Matx44d> links;
            model_->forwardKinematics(scene_.trueJoints(i, time), links);
            addInstances(*model_, firstMesh_, scene_.camera_T_base(i), links, 1, false, instances);
            base_T_links.push_back(links);
        }
        renderer_->render(camera_, Rect(Point(), camera_.imageSize()), instances, rendering_);
        for (int i = 0; i < scene_.toolCount(); i++)
        {
            addPose(frame, time, i);
            for (size_t j = 0; j < model_->keypoints().size(); j++)
                addKeypoint(frame, i, model_->keypoints()[j], scene_.camera_T_base(i) * base_T_links[i][model_->keypoints()[j].link]);
        }
    }

    void write(const String& folder) const
    {
        poses_.write(utils::fs::join(folder, "groundtruth.csv"));
        keypoints_.write(utils::fs::join(folder, "keypoints.csv"));
    }

private:
    void addPose(int frame, double time, int tool)
    {
        const Matx44d T = scene_.truePose(tool, time);
        const Vec4d q = quaternionFromRotation(T.get_minor<3, 3>(0, 0));
        poses_ << frame << "," << time << "," << toolName(tool) << "," << T(0, 3) << "," << T(1, 3) << "," << T(2, 3);
        for (int i = 0; i < 4; i++)
            poses_ << "," << q[i];
        addJoints(poses_, scene_.trueJoints(tool, time));
    }

    void addKeypoint(int frame, int tool, const ToolModel::Keypoint& keypoint, const Matx44d& camera_T_link)
    {
        const Point3d& p = keypoint.linkPoint;
        const Vec4d v = camera_T_link * Vec4d(p.x, p.y, p.z, 1);
        const bool inFront = v[2] > 1e-6;
        const Point2d imagePoint = inFront ? camera_.project(Point3d(v[0], v[1], v[2])) : Point2d(-1, -1);
        const PartTemplateRenderer::Params slack;
        const bool visible = inFront && isVisible(rendering_.depth, rendering_.ids, Point(cvRound(imagePoint.x), cvRound(imagePoint.y)), 0, v[2], 1,
                                                  isTip(*model_, keypoint.link) ? slack.tipDepthSlack : slack.depthSlack);
        keypoints_ << frame << "," << toolName(tool) << "," << keypoint.name << "," << imagePoint.x << "," << imagePoint.y << "," << v[0] << ","
                   << v[1] << "," << v[2] << "," << (int)visible << "\n";
    }

    const SyntheticScene& scene_;
    double fps_;
    Ptr<ToolModel> model_;
    CameraModel camera_;
    Ptr<MeshRenderer> renderer_;
    int firstMesh_;
    Rendering rendering_;
    Table poses_, keypoints_;
};

} // namespace

void writeScene(SyntheticScene& scene, const SyntheticScene::Params& params, const String& folder)
{
    const Size size = params.imageSize;
    if (size.width % 2 || size.height % 2)
        CV_Error(Error::StsBadSize, format("image size %d x %d: width and height must be even, video encoders store colour for pairs of pixels",
                                           size.width, size.height));
    const String toolFolder = utils::fs::join(folder, "tool");
    if (!utils::fs::createDirectories(toolFolder))
        CV_Error(Error::StsError, format("%s: the folder can't be made: %s", toolFolder.c_str(), std::strerror(errno)));
    const String toolFile = "tool/" + scene.model()->name() + ".yaml";
    scene.model()->save(utils::fs::join(folder, toolFile));

    const std::vector<String> names = scene.model()->coordinateNames();
    String jointHeader;
    for (size_t i = 0; i < names.size(); i++)
        jointHeader += "," + names[i];
    jointHeader += "\n";
    writeDescription(scene, params, toolFile, folder);
    writeKinematics(scene, params, jointHeader, utils::fs::join(folder, "kinematics.csv"));

    TruthWriter truth(scene, params, jointHeader);
    VideoFile left(utils::fs::join(folder, "left.mp4"), params.fps, params.imageSize);
    Ptr<VideoFile> right;
    if (params.stereo)
        right = makePtr<VideoFile>(utils::fs::join(folder, "right.mp4"), params.fps, params.imageSize);
    Mat image;
    for (int frame = 0; frame < params.frames; frame++)
    {
        scene.render(frame, image);
        left.write(image);
        if (right)
        {
            scene.render(frame, image, true);
            right->write(image);
        }
        truth.add(frame);
    }
    truth.write(folder);
    left.finish();
    if (right)
        right->finish();
}

}} // namespace cv::surgtrack
