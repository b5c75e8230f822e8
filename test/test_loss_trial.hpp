// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Seeded trials in which a tool is lost and comes back.

#ifndef OPENCV_SURGTRACK_TEST_LOSS_TRIAL_HPP
#define OPENCV_SURGTRACK_TEST_LOSS_TRIAL_HPP

#include "test_tracking.hpp"
#include "opencv2/imgproc.hpp"

namespace opencv_test { namespace {

enum Loss
{
    LOSS_NONE,         // nothing: for false alarms
    LOSS_BLACK,        // the image is black,
    LOSS_GREY,         // one grey,
    LOSS_NOISE,        // or noise
    LOSS_JUMP,         // the camera is knocked: 10 mm and 5 degrees, about the tool
    LOSS_INSTRUMENT,   // an instrument that nobody told of comes between tool and camera
    LOSS_PATCH,        // something flat lies over the tool
    LOSS_LEAVES,       // the tool leaves the view
    LOSS_OF_ONE,       // of two tools one is lost: its arm is knocked, it is covered, or it leaves
    LOSSES
};

inline const char* lossName(int loss)
{
    static const char* const names[LOSSES] = {"nothing", "black", "grey", "noise", "jump", "instrument", "patch", "leaves", "oneOfTwo"};
    return names[loss];
}

const double RIGHT_POSE = 0.005;           // [m], of the end effector
const int LEAD_FRAMES = 12, AFTER_FRAMES = 15;
const int FLAG_FRAMES = 5, RECOVERY_FRAMES = 10;
const int PLAIN_KEYPOINTS = 8;             // of 14 in sight: the tool is plainly visible

inline Matx44d rotationAbout(const Point3d& centre, const Vec3d& rotation)
{
    const Matx33d R = rotationMatrix(rotation);
    return rigid(R, centre - R * centre);
}

inline Matx44d shiftBy(const Point3d& t) { return rigid(Matx33d::eye(), t); }

/* What the camera sees and the robot says in one trial, and the truth. All of it follows from loss, seed and size.
   The tools are not plainly visible in the frames from begin() to before end(); for a jump both are its first frame. */
class LossTrial
{
public:
    LossTrial(Loss loss, int seed, Size size) : loss_(loss), rng_((uint64)(seed + 1) * 0x9E3779B97F4A7C15ULL + loss), victim_(0), begin_(LEAD_FRAMES)
    {
        SyntheticScene::Params p = opencv_test::scene(seed, loss == LOSS_OF_ONE ? 2 : 1, size, seed % 2 != 0);
        scene_ = SyntheticScene::create(needleDriver(), p);
        fps_ = p.fps;
        for (int i = 0; i < 4; i++) rng_.next();
        how_ = loss;
        if (loss == LOSS_OF_ONE)
        {
            static const Loss kinds[] = {LOSS_JUMP, LOSS_PATCH, LOSS_LEAVES};
            how_ = kinds[rng_.uniform(0, 3)];
            victim_ = rng_.uniform(0, 2);
        }
        const int length = rng_.uniform(how_ == LOSS_INSTRUMENT || how_ == LOSS_PATCH ? 10 : 5, 41);
        end_ = begin_ + length;
        if (how_ == LOSS_NONE) begin_ = end_ = 50;
        if (how_ == LOSS_JUMP) planJump();
        if (how_ == LOSS_INSTRUMENT) planInstrument();
        if (how_ == LOSS_PATCH) planPatch();
        if (how_ == LOSS_LEAVES) planWay(length);
    }

    const SyntheticScene& scene() const { return *scene_; }
    int victim() const { return victim_; }
    int begin() const { return begin_; }
    int end() const { return end_; }
    int frames() const { return how_ == LOSS_NONE ? end_ : end_ + AFTER_FRAMES; }
    double time(int frame) const { return frame / fps_; }
    bool showsNothing(int frame) const { return (how_ == LOSS_BLACK || how_ == LOSS_GREY || how_ == LOSS_NOISE) && frame >= begin_ && frame < end_; }

    Joints joints(int frame) const
    {
        Joints result;
        for (int i = 0; i < scene_->toolCount(); i++) result.push_back(added(scene_->recordedJoints(i, time(frame)), i, frame));
        return result;
    }

    Matx44d truePose(int frame, int tool) const
    {
        return camera_T_base(frame, tool) * scene_->model()->endEffectorPose(added(scene_->trueJoints(tool, time(frame)), tool, frame));
    }

    bool plainlyVisible(int frame, int tool) const { return keypointsInSight(frame, tool) >= PLAIN_KEYPOINTS; }

    int keypointsInSight(int frame, int tool) const
    {
        if (showsNothing(frame) || (tool == victim_ && loss_ != LOSS_OF_ONE && how_ != LOSS_LEAVES && frame >= begin_ && frame < end_)) return 0;
        const std::vector<Point3d> points = keypoints(frame, tool);
        int count = 0;
        for (size_t i = 0; i < points.size(); i++) count += inImage(points[i], 0) && !(covers(frame) && inPatch(scene_->camera().project(points[i])));
        return count;
    }

    void render(int frame, Mat& image)
    {
        if (showsNothing(frame))
        {
            image.create(scene_->camera().imageSize(), CV_8UC3);
            if (how_ == LOSS_NOISE) RNG(frame + 1).fill(image, RNG::UNIFORM, 0, 256);
            else image = Scalar::all(how_ == LOSS_BLACK ? 0 : 128);
            return;
        }
        Joints all;
        std::vector<Matx44d> bases;
        for (int i = 0; i < scene_->toolCount(); i++)
        {
            all.push_back(added(scene_->trueJoints(i, time(frame)), i, frame));
            bases.push_back(camera_T_base(frame, i));
        }
        if (how_ == LOSS_INSTRUMENT && frame >= begin_ && frame < end_)
        {
            all.push_back(strangerJoints(frame));
            bases.push_back(strangerBase(frame));
        }
        scene_->renderArms(frame, all, bases, image);
        if (!covers(frame)) return;
        Mat mask = Mat::zeros(image.size(), CV_8U);
        ellipse(mask, patch_, Scalar::all(255), FILLED);
        patchTexture_.copyTo(image, mask);
    }

private:
    std::vector<Point3d> keypoints(int frame, int tool) const
    {
        return pointsOf(added(scene_->trueJoints(tool, time(frame)), tool, frame), camera_T_base(frame, tool));
    }

    std::vector<Point3d> pointsOf(const std::vector<double>& q, const Matx44d& base) const
    {
        std::vector<Matx44d> links;
        scene_->model()->forwardKinematics(q, links);
        std::vector<Point3d> points;
        for (const ToolModel::Keypoint& k : scene_->model()->keypoints()) points.push_back(transformed(base * links[k.link], k.linkPoint));
        return points;
    }

    static Point3d meanOf(const std::vector<Point3d>& points)
    {
        Point3d sum;
        for (const Point3d& p : points) sum += p;
        return sum * (1. / double(points.size()));
    }

    // margin: beyond the borders [pixel]
    bool inImage(const Point3d& p, int margin) const
    {
        if (p.z < 0.02) return false;
        const Point2d u = scene_->camera().project(p);
        const Size s = scene_->camera().imageSize();
        return u.x > -margin && u.y > -margin && u.x < s.width - 1 + margin && u.y < s.height - 1 + margin;
    }

    Matx44d camera_T_base(int frame, int tool) const
    {
        const Matx44d base = scene_->camera_T_base(tool);
        const bool moved = how_ == LOSS_JUMP && frame >= begin_ && tool == victim_;
        return moved ? jump_ * base : base;
    }

    void planJump()
    {
        end_ = begin_;
        const Matx44d tool = truePose(LEAD_FRAMES - 1, victim_);
        const Point3d centre(tool(0, 3), tool(1, 3), tool(2, 3));
        for (int attempt = 0; attempt < 50; attempt++)
        {
            const Vec3d rotation = randomDirection(rng_) * (5 * CV_PI / 180), shift = randomDirection(rng_) * 0.01;
            jump_ = shiftBy(Point3d(shift)) * rotationAbout(centre, rotation);
            bool visible = true;
            for (int f = begin_; f < frames(); f++) visible = visible && plainlyVisible(f, victim_);
            if (visible) return;
        }
        CV_Error(Error::StsError, "no jump leaves the tool in the view");
    }

    // The way out of the view: a share of what is added to q1, q2 and q3, of the readings as well.
    double wayShare(int frame) const
    {
        const int ramp = 8;   // [frames]
        const double out = (frame - LEAD_FRAMES) / double(ramp), back = (wayEnd_ - frame) / double(ramp);
        return std::max(0., std::min(1., std::min(out, back)));
    }

    std::vector<double> added(std::vector<double> q, int tool, int frame) const
    {
        if (how_ != LOSS_LEAVES || tool != victim_) return q;
        for (int i = 0; i < 3; i++) q[scene_->model()->coordinateIndex(format("q%d", i + 1))] += wayShare(frame) * way_[i];
        return q;
    }

    void planWay(int length)
    {
        const int middle = LEAD_FRAMES + 8 + length / 2;
        wayEnd_ = LEAD_FRAMES + length + 16;
        for (int attempt = 0; attempt < 200; attempt++)
        {
            const Vec3d direction = randomDirection(rng_);
            for (double far = 0.02; far < 0.15; far += 0.01)
            {
                way_ = Vec3d(direction[0] * far / 0.12, direction[1] * far / 0.12, direction[2] * far);   // the arm is 0.12 m long
                bool inFront = true, outside = true;
                const std::vector<Point3d> points = keypoints(middle, victim_);
                for (const Point3d& p : points)
                {
                    inFront = inFront && p.z > 0.03;
                    outside = outside && !inImage(p, 20);
                }
                if (!inFront) break;
                if (!outside) continue;
                for (begin_ = LEAD_FRAMES; plainlyVisible(begin_, victim_);) begin_++;
                for (end_ = wayEnd_; plainlyVisible(end_ - 1, victim_);) end_--;
                return;
            }
        }
        CV_Error(Error::StsError, "no way leads out of the view");
    }

    bool covers(int frame) const { return how_ == LOSS_PATCH && frame >= begin_ && frame < end_; }

    bool inPatch(const Point2d& p) const
    {
        const double a = patch_.angle * CV_PI / 180, x = p.x - patch_.center.x, y = p.y - patch_.center.y;
        const double u = (std::cos(a) * x + std::sin(a) * y) / (0.5 * patch_.size.width), v = (-std::sin(a) * x + std::cos(a) * y) / (0.5 * patch_.size.height);
        return u * u + v * v < 1;
    }

    void planPatch()
    {
        std::vector<Point2f> points;
        for (int f = begin_; f < end_; f += 3)
            for (const Point3d& p : keypoints(f, victim_)) points.push_back(scene_->camera().project(p));
        patch_ = minAreaRect(points);
        const float grown = (float)rng_.uniform(1.1, 1.5);
        patch_.size = Size2f(patch_.size.width * grown, patch_.size.height * grown);
        Mat texture = textured(scene_->camera().imageSize(), 1, rng_.next(), rng_.uniform(20., 90.), rng_.uniform(110., 250.));
        cvtColor(texture, texture, COLOR_GRAY2BGR);
        const Scalar tint(rng_.uniform(0.4, 1.), rng_.uniform(0.4, 1.), 1);
        cv::multiply(texture, tint, patchTexture_);
    }

    // The stranger: an instrument of the same kind nearer to the camera, that comes from the side and goes again.
    std::vector<double> strangerJoints(int frame) const
    {
        std::vector<double> q = scene_->trueJoints(0, 1.7 + 0.3 * time(frame));
        q[scene_->model()->coordinateIndex("q3")] += strangerInsertion_;
        return q;
    }

    Matx44d strangerBase(int frame) const
    {
        const int ramp = 5;   // [frames]
        const double away = 1 - std::min(1., std::min((frame + 1 - begin_) / double(ramp), (end_ - frame) / double(ramp)));
        return shiftBy(strangerSide_ * (0.04 * away)) * strangerBase_;
    }

    int keypointsBehindStranger(int frame)
    {
        if (!renderer_)
        {
            renderer_ = MeshRenderer::createSoftware();
            for (const Mesh& m : scene_->model()->meshes()) renderer_->addMesh(m);
        }
        std::vector<Matx44d> links;
        scene_->model()->forwardKinematics(strangerJoints(frame), links);
        std::vector<MeshInstance> instances;
        for (size_t i = 0; i < links.size(); i++)
        {
            MeshInstance instance;
            instance.mesh = scene_->model()->links()[i].mesh;
            instance.id = 1;
            instance.camera_T_mesh = strangerBase(frame) * links[i];
            if (instance.mesh >= 0) instances.push_back(instance);
        }
        const CameraModel camera = scene_->camera();
        Rendering drawing;
        renderer_->render(camera, Rect(Point(), camera.imageSize()), instances, drawing);
        int hidden = 0;
        for (const Point3d& p : keypoints(frame, victim_))
        {
            if (!inImage(p, -1)) continue;
            const float z = drawing.depth.at<float>(Point(camera.project(p)));
            hidden += z > 0 && z < p.z;
        }
        return hidden;
    }

    // The best of many places, until one hides most of the 14 keypoints all the time.
    void planInstrument()
    {
        const int middle = (begin_ + end_) / 2, most = 9;
        const Point3d tool = meanOf(keypoints(middle, victim_)), ray = tool * (1 / cv::norm(tool));
        int bestHidden = -1;
        Matx44d bestBase;
        double bestInsertion = 0;
        for (int attempt = 0; attempt < 100 && bestHidden < most; attempt++)
        {
            // Put over the tool, then pushed on, so that its wrist or its shaft hides the tool.
            strangerInsertion_ = 0;
            strangerBase_ = scene_->camera_T_base(0);
            const Point3d stranger = meanOf(pointsOf(strangerJoints(middle), strangerBase_));
            const Vec3d turn = Vec3d(ray.x, ray.y, ray.z) * rng_.uniform(-0.5, 0.5);
            strangerBase_ = shiftBy(tool * rng_.uniform(0.5, 0.8) - stranger) * rotationAbout(stranger, turn) * strangerBase_;
            strangerInsertion_ = rng_.uniform(0., 0.02);
            const int hidden = std::min(keypointsBehindStranger(begin_ + 4), std::min(keypointsBehindStranger(middle), keypointsBehindStranger(end_ - 5)));
            if (hidden <= bestHidden) continue;
            bestHidden = hidden;
            bestBase = strangerBase_;
            bestInsertion = strangerInsertion_;
        }
        strangerBase_ = bestBase;
        strangerInsertion_ = bestInsertion;
        const double side = rng_.uniform(0., 2 * CV_PI);
        strangerSide_ = Point3d(std::cos(side), std::sin(side), 0);
    }

    Loss loss_, how_;
    RNG rng_;
    Ptr<SyntheticScene> scene_;
    double fps_;
    int victim_, begin_, end_;
    Matx44d jump_;
    int wayEnd_;
    Vec3d way_;                  // of q1, q2 [rad] and q3 [m]
    RotatedRect patch_;
    Mat patchTexture_;
    Ptr<MeshRenderer> renderer_;
    double strangerInsertion_;   // [m]
    Matx44d strangerBase_;
    Point3d strangerSide_;
};

}} // namespace

#endif
