// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Trackers of edges alone, which need a pose to start from: they get the true one of the first frame, which nobody has, and from then on
// the recorded joints, as `frozen` has them.

#ifndef OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_PEERS_HPP
#define OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_PEERS_HPP

#include "opencv2/opencv_modules.hpp"
#ifdef HAVE_OPENCV_RAPID
#include "opencv2/calib3d.hpp"
#include "opencv2/rapid.hpp"
#endif
#include "pose_run.hpp"
#include "../true_parts.hpp"

namespace evaluation {

//! Follows one tool from frame to frame.
struct EdgeTracker
{
    virtual ~EdgeTracker() {}
    //! @param correction camera_T_nominal that makes the pose of the first frame exact
    virtual void start(const Matx44d& correction) = 0;
    //! @param image of the camera @param joints recorded @param camera_T_tool result @return whether it was measured
    virtual bool track(const Mat& image, const std::vector<double>& joints, Matx44d& camera_T_tool) = 0;
};

//! METHOD_FULL without parts: its filter, with the outline alone.
class ContourTracker : public EdgeTracker
{
public:
    ContourTracker(const Tool& tool, const CameraModel& camera, double scale) : model_(tool.model), camera_(camera), scale_(scale)
    {
        filter_ = ArticulatedPoseEKF::create(model_, tool.info.nominal_T_base);
        contour_ = ToolContour::create(model_);
        PartTemplateRenderer::Params drawing;
        drawing.wholeTool = true;
        renderer_ = PartTemplateRenderer::create(Ptr<MeshRenderer>(), drawing);
        renderer_->addTool(model_);
    }
    void start(const Matx44d& correction) CV_OVERRIDE { filter_->reset(correction); }

    bool track(const Mat& image, const std::vector<double>& joints, Matx44d& camera_T_tool) CV_OVERRIDE
    {
        static const double windows[] = { 8, 5, 3 }, tolerances[] = { 3, 1, 0 };   // as METHOD_FULL follows a tool [pixel]
        filter_->predict(joints);
        std::vector<PartTemplate> templates;
        renderer_->render(camera_, std::vector<ToolView>(1, filter_->view()), 0, templates);
        contour_->sample(camera_, filter_->view(), renderer_->rendering(), 1, points_);   // 1: the first tool
        for (int pass = 0; pass < 3; pass++)
        {
            look(image, windows[pass]);
            filter_->begin();
            if (filter_->addContour(camera_, Matx44d::eye(), points_, std::max(tolerances[pass], 1.) * scale_) == 0 || !filter_->solve())
                break;
        }
        look(image, 6);
        int supported = 0;
        for (size_t i = 0; i < points_.size(); i++)
            supported += points_[i].found && std::abs(points_[i].offset) <= 1.5 * scale_;
        camera_T_tool = filter_->view().camera_T_base * model_->endEffectorPose(filter_->joints());
        return !points_.empty() && supported >= 0.55 * points_.size();   // what METHOD_FULL asks of an outline without parts
    }

private:
    void look(const Mat& image, double halfWindow)
    {
        ContourSearch search;
        search.halfWindow = halfWindow * scale_;
        placeContour(camera_, filter_->view(), points_);
        matchContour(image, points_, search);
    }

    Ptr<ToolModel> model_;
    CameraModel camera_;
    double scale_;
    Ptr<ArticulatedPoseEKF> filter_;
    Ptr<ToolContour> contour_;
    Ptr<PartTemplateRenderer> renderer_;
    std::vector<ContourPoint> points_;
};

#ifdef HAVE_OPENCV_RAPID

/** cv::rapid with the part of the tool about its end effector as a rigid mesh, made anew for each frame's joints. With search lines longer
than 4 px it takes inner edges of the steel for the outline. */
class RapidTracker : public EdgeTracker
{
public:
    RapidTracker(const Tool& tool, const CameraModel& camera, double scale)
        : tool_(tool), model_(ToolModel::load(tool.info.model, 1500)), camera_(camera), scale_(scale)
    {
    }
    void start(const Matx44d& correction) CV_OVERRIDE { correction_ = correction; }

    bool track(const Mat& image, const std::vector<double>& joints, Matx44d& camera_T_tool) CV_OVERRIDE
    {
        std::vector<Point3f> vertices;
        std::vector<Vec3i> triangles;
        rigidMesh(joints, vertices, triangles);
        const Matx44d nominal = tool_.info.nominal_T_base * tool_.model->endEffectorPose(joints), expected = correction_ * nominal;
        Vec3d rotation, translation = translationOf(expected);
        Rodrigues(rotationOf(expected), rotation);
        Mat rvec = Mat(rotation).clone(), tvec = Mat(translation).clone(), undistorted;
        undistort(image, undistorted, camera_.cameraMatrix(), camera_.distCoeffs());   // it knows no distortion
        bool measured = false;
        try
        {
            measured = rapid::Rapid::create(vertices, triangles)->compute(undistorted, 100, cvRound(4 * scale_), camera_.cameraMatrix(), rvec, tvec) > 0.5f;
        }
        catch (const Exception&)
        {
            // the mesh is not in the image, or has too few points there
        }
        Matx33d R;
        Rodrigues(rvec, R);
        measured = measured && norm(Vec3d(tvec.ptr<double>()) - translation) < 0.005;   // no step of a frame, but the start of a divergence
        camera_T_tool = measured ? rigid(R, Vec3d(tvec.ptr<double>())) : expected;
        correction_ = camera_T_tool * rigidInverse(nominal);
        return measured;
    }

private:
    //! What lies within 25 mm of the end effector, without the vertices of what does not: cv::rapid takes each for one of the outline.
    void rigidMesh(const std::vector<double>& joints, std::vector<Point3f>& vertices, std::vector<Vec3i>& triangles) const
    {
        std::vector<Matx44d> base_T_link;
        model_->forwardKinematics(joints, base_T_link);
        const Matx44d tool_T_base = rigidInverse(model_->endEffectorPose(joints));
        for (size_t link = 0; link < model_->links().size(); link++)
        {
            if (model_->links()[link].mesh < 0)
                continue;
            const Mesh& mesh = model_->meshes()[model_->links()[link].mesh];
            const Matx44d tool_T_link = tool_T_base * base_T_link[link];
            std::map<int, int> numbers;
            for (size_t i = 0; i < mesh.triangles.size(); i++)
            {
                Point3f corners[3];
                bool near = true;
                for (int j = 0; j < 3; j++)
                {
                    const Point3f& p = mesh.vertices[mesh.triangles[i][j]];
                    const Vec4d q = tool_T_link * Vec4d(p.x, p.y, p.z, 1);
                    corners[j] = Point3f((float)q[0], (float)q[1], (float)q[2]);
                    near = near && norm(corners[j]) < 0.025;
                }
                Vec3i triangle;
                for (int j = 0; j < 3 && near; j++)
                {
                    const std::pair<std::map<int, int>::iterator, bool> added = numbers.insert(std::make_pair(mesh.triangles[i][j], (int)vertices.size()));
                    if (added.second)
                        vertices.push_back(corners[j]);
                    triangle[j] = added.first->second;
                }
                if (near)
                    triangles.push_back(triangle);
            }
        }
    }

    Tool tool_;
    Ptr<ToolModel> model_;
    CameraModel camera_;
    double scale_;
    Matx44d correction_;
};

#endif // HAVE_OPENCV_RAPID

/** @brief Runs a tracker of each tool over a sequence.
@param name contour or rapid
@param frames at most so many; 0 = all
@throws cv::Exception if this build has it not */
inline Run trackEdges(const Data& data, const String& name, int frames, bool quiet)
{
    TrueParts truths(data);
    PartFinder& finder = truths.finder();   // of its reduced images
    std::vector<Ptr<EdgeTracker> > trackers;
    for (size_t i = 0; i < data.tools.size(); i++)
        if (name == "contour")
            trackers.push_back(makePtr<ContourTracker>(data.tools[i], finder.camera(), finder.pixelScale()));
#ifdef HAVE_OPENCV_RAPID
        else if (name == "rapid")
            trackers.push_back(makePtr<RapidTracker>(data.tools[i], finder.camera(), finder.pixelScale()));
#endif
        else
            fail("baseline '" + name + "' is not in this build, misc/compare_peers.sh makes one with opencv_contrib's module rapid");
    PoseRun run(data, name);
    common::FrameReader reader(*data.sequence, 0);
    common::Progress progress(frames > 0 ? std::min(frames, reader.count()) : reader.count(), quiet);
    Mat image;
    std::vector<std::vector<double> > joints;
    std::vector<char> started(trackers.size(), 0);
    for (int frame = 0; (frames == 0 || frame < frames) && reader.read(image); frame++)
    {
        data.joints(frame, joints);
        finder.setImage(image);
        const Mat pixels = finder.pixels(Rect(Point(), finder.camera().imageSize()));
        double seconds = 0;
        for (int i = 0; i < (int)trackers.size(); i++)
        {
            Truth truth;
            if (!started[i] && data.truth(i, frame, truth))
            {
                trackers[i]->start(truth.camera_T_tool * rigidInverse(data.tools[i].info.nominal_T_base * data.tools[i].model->endEffectorPose(joints[i])));
                started[i] = 1;
            }
            if (!started[i])
                continue;
            Matx44d camera_T_tool;
            const int64 start = getTickCount();
            const bool measured = trackers[i]->track(pixels, joints[i], camera_T_tool);
            seconds += double(getTickCount() - start) / getTickFrequency();
            run.add(i, frame, measured ? STATE_TRACKING : STATE_COASTING, camera_T_tool);
        }
        run.addFrame(seconds);
        finder.release();
        progress.show(frame + 1);
    }
    return run.finish();
}

} // namespace evaluation

#endif
