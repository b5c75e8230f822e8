// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// The tracker that Table 1 of the paper compares with (Reiter, Allen, Zhao 2014), re-implemented from its description: landmarks found
// by the forest and fused with the kinematics. Published: class-specific landmarks, extended Kalman filter, triangulation with two
// eyes. Windows, weights and noise are ours.

#ifndef OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_REITER2014_HPP
#define OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_REITER2014_HPP

#include "forest.hpp"
#include "pose_run.hpp"

namespace evaluation {

//! Where a landmark was found with both eyes, or with the left one alone.
struct Landmark
{
    int part;                //!< index of the keypoint
    Point2d left, right;     //!< right: NaN if not seen there
};

/** One tool: a filter of the six states of the hand-eye correction, fed with landmarks. Pixels are those of the images given. */
class LandmarkFusion
{
public:
    enum { WIDEST = 120, NARROWEST = 20, NEAR = 20, CONFIRM = 3, LEAST = 3 };   // [pixel at 720 px width], frames, landmarks

    /** @param cameras of the images; the right one of size 0 x 0 if there is one eye
    @param scale pixels of an image 720 pixel wide, see PartFinder::pixelScale()
    @param noise of a landmark, were each frame's independent [pixel at 720 px width]. Within 40 px they scatter by 8.1 and 8.6 px an axis, on each
    training video with the trees of the other, but err alike for long: correlations of 1 to 48 frames add up to 14 and 10, so that 22 to 29
    frames tell as much as one: sqrt(25) times */
    LandmarkFusion(const Ptr<ToolModel>& model, const Matx44d& nominal_T_base, const CameraPair& cameras, double scale, double noise = 40)
        : cameras_(cameras), scale_(scale), state_(STATE_INITIALIZING), measured_(0), lastTime_(0)
    {
        ArticulatedPoseEKF::Params params;
        params.jointOffsets = false;
        params.pointNoise = noise * scale;
        const ToolPoseEKF::Params published;   // a calibration changes slowly, and landmarks are coarse
        params.processRotation = published.processRotation;
        params.processTranslation = published.processTranslation;
        filter_ = ArticulatedPoseEKF::create(model, nominal_T_base, params);
        filter_->reset();
    }

    void predict(const std::vector<double>& joints) { filter_->predict(joints); }
    const ToolView& view() const { return filter_->view(); }
    int state() const { return state_; }

    //! Where a part is expected, and how far off that may be [pixel].
    Point2d expected(int part, const Ptr<ToolModel>& model, double& deviation) const
    {
        Mat basePoints;
        model->keypointPositions(filter_->joints(), basePoints);
        const double* const p = basePoints.ptr<double>(part);
        const Vec4d q = filter_->view().camera_T_base * Vec4d(p[0], p[1], p[2], 1);
        const Matx22d C = filter_->imageCovariance(cameras_.left, Matx44d::eye(), part);
        deviation = std::sqrt(std::max(C(0, 0), C(1, 1)));
        const Point3d point(q[0], q[1], q[2]);
        return q[2] > 1e-3 ? cameras_.left.project(point) : Point2d(-1e6, -1e6);
    }
    //! Half the width of a window.
    double halfWindow(double deviation) const
    {
        return measured_ < CONFIRM ? WIDEST * scale_ : std::min(std::max(3 * deviation, NARROWEST * scale_), WIDEST * scale_);
    }

    /** @brief Takes in what was found of a frame.
    @param landmarks of parts @param time [s] */
    void correct(const std::vector<Landmark>& landmarks, double time)
    {
        std::vector<int> parts, rightParts;
        std::vector<Point2d> left, right;
        for (size_t i = 0; i < landmarks.size(); i++)
        {
            parts.push_back(landmarks[i].part);
            left.push_back(landmarks[i].left);
            if (cvIsNaN(landmarks[i].right.x))
                continue;
            rightParts.push_back(landmarks[i].part);
            right.push_back(landmarks[i].right);
        }
        std::vector<uchar> used;
        filter_->begin();
        const int count = parts.empty() ? 0 : filter_->addPoints(cameras_.left, Matx44d::eye(), parts, left, used);
        if (!right.empty())
            filter_->addPoints(cameras_.right, cameras_.right_T_left, rightParts, right, used);
        if (count >= LEAST && filter_->solve())
        {
            state_ = STATE_TRACKING;
            measured_++;
            lastTime_ = time;
        }
        else if (state_ != STATE_INITIALIZING)
            state_ = time - lastTime_ > 2 ? STATE_LOST : STATE_COASTING;
        if (state_ != STATE_LOST)
            return;
        measured_ = 0;
        filter_->reset();   // with what is believed of where it was, it would not be found elsewhere
    }

    Matx44d camera_T_tool(const Ptr<ToolModel>& model) const { return filter_->view().camera_T_base * model->endEffectorPose(filter_->joints()); }
    double scale() const { return scale_; }

private:
    CameraPair cameras_;
    double scale_;
    Ptr<ArticulatedPoseEKF> filter_;
    int state_, measured_;
    double lastTime_;
};

//! Tracks a sequence with them.
class ReiterFusion
{
public:
    ReiterFusion(const Data& data, Forest& forest) : data_(data), forest_(forest), run_(data, "reiter2014")
    {
        renderer_ = PartTemplateRenderer::create();
        for (size_t i = 0; i < data.tools.size(); i++)
            renderer_->addTool(data.tools[i].model);
        left_ = PartFinder::create(data.sequence->leftCamera(), renderer_);
        cameras_.left = left_->camera();
        if (data.sequence->isStereo())
        {
            right_ = PartFinder::create(data.sequence->rightCamera(), renderer_);
            cameras_.right = right_->camera();
            cameras_.right_T_left = data.sequence->right_T_left();
        }
        for (size_t i = 0; i < data.tools.size(); i++)
            tools_.push_back(makePtr<LandmarkFusion>(data.tools[i].model, data.tools[i].info.nominal_T_base, cameras_, left_->pixelScale()));
    }

    //! @param frames at most so many; 0 = all
    Run track(int frames, bool quiet)
    {
        common::EyesReader reader(*data_.sequence, 0, !right_.empty());
        common::Progress progress(frames > 0 ? std::min(frames, reader.count()) : reader.count(), quiet);
        Mat left, right;
        for (int frame = 0; (frames == 0 || frame < frames) && reader.read(left, right); frame++)
        {
            data_.joints(frame, joints_);
            const int64 start = getTickCount();
            update(left, right, data_.time(frame));
            run_.addFrame(double(getTickCount() - start) / getTickFrequency());
            for (int i = 0; i < (int)tools_.size(); i++)
                run_.add(i, frame, tools_[i]->state(), tools_[i]->camera_T_tool(data_.tools[i].model));
            progress.show(frame + 1);
        }
        return run_.finish();
    }

private:
    //! A part that should be seen.
    struct Wanted
    {
        int tool, part, cls;
        Point2d expected;
        double half;
    };

    void update(const Mat& left, const Mat& right, double time)
    {
        std::vector<ToolView> views;
        for (size_t i = 0; i < tools_.size(); i++)
        {
            tools_[i]->predict(joints_[i]);
            views.push_back(tools_[i]->view());
        }
        std::vector<std::vector<Landmark> > landmarks(tools_.size());
        left_->setImage(left);
        forest_.setImage(left_->pixels(Rect(Point(), cameras_.left.imageSize())));
        for (int tool = 0; tool < (int)tools_.size(); tool++)
        {
            landmarks[tool] = look(wantedOf(views, tool), tool);
        }
        left_->release();
        if (right_)
        {
            right_->setImage(right);
            forest_.setImage(right_->pixels(Rect(Point(), cameras_.right.imageSize())));
            for (int tool = 0; tool < (int)tools_.size(); tool++)
                lookRight(tool, landmarks[tool]);
            right_->release();
        }
        for (size_t i = 0; i < tools_.size(); i++)
            tools_[i]->correct(landmarks[i], time);
    }

    int classOf(int tool, int part) const
    {
        const String name = className(data_.tools[tool].model->keypointNames()[part]);
        const std::vector<String>& classes = forest_.classes();
        const size_t index = std::find(classes.begin(), classes.end(), name) - classes.begin();
        return index < classes.size() ? (int)index + 1 : 0;
    }

    //! The parts that a drawing at the predicted pose shows.
    std::vector<Wanted> wantedOf(const std::vector<ToolView>& views, int tool)
    {
        PartDrawing drawing;
        left_->draw(views, tool, drawing);
        std::vector<Wanted> wanted;
        for (size_t i = 0; i < drawing.templates.size(); i++)
        {
            Wanted w;
            w.tool = tool;
            w.part = drawing.templates[i].part;
            w.cls = classOf(tool, w.part);
            double deviation;
            w.expected = tools_[tool]->expected(w.part, data_.tools[tool].model, deviation);
            w.half = tools_[tool]->halfWindow(deviation);
            if (w.cls > 0)
                wanted.push_back(w);
        }
        return wanted;
    }

    static double gaussian(const Point2d& d, double sigma) { return std::exp(-d.dot(d) / (2 * sigma * sigma)); }

    //! A place that may be a part.
    struct Candidate
    {
        size_t wanted;
        Point2d place;
        double value;   //!< posterior, times less the farther it is from where the part is expected
    };

    /** Of five places a part the best; none if its posterior is low. A class does not know the side, so of two parts of a class, as the tips
    of two jaws, each has a place of its own. */
    std::vector<Landmark> look(const std::vector<Wanted>& wanted, int tool)
    {
        const double scale = tools_[tool]->scale();
        std::vector<Candidate> candidates;
        for (size_t i = 0; i < wanted.size(); i++)
        {
            const Wanted& w = wanted[i];
            const Rect window = Rect(Point(w.expected - Point2d(w.half, w.half)), Size(2 * cvRound(w.half) + 1, 2 * cvRound(w.half) + 1)) &
                                Rect(Point(), cameras_.left.imageSize());
            std::vector<PartMatch> matches;
            if (!window.empty())
                forest_.detect(window, w.cls, 5, matches);
            for (size_t j = 0; j < matches.size(); j++)
            {
                const double near = gaussian(matches[j].imagePoint - w.expected, LandmarkFusion::NEAR * scale);
                const Candidate candidate = { i, matches[j].imagePoint, matches[j].similarity * near };
                if (matches[j].similarity >= LEAST_POSTERIOR)
                    candidates.push_back(candidate);
            }
        }
        std::stable_sort(candidates.begin(), candidates.end(), [](const Candidate& a, const Candidate& b) { return a.value > b.value; });
        std::vector<Landmark> landmarks;
        std::vector<int> classes;   // of the landmarks
        for (size_t i = 0; i < candidates.size(); i++)
        {
            const Wanted& w = wanted[candidates[i].wanted];
            bool free = true;
            for (size_t j = 0; j < landmarks.size(); j++)
                free = free && landmarks[j].part != w.part && (classes[j] != w.cls || norm(landmarks[j].left - candidates[i].place) >= SUPPRESSION * scale);
            if (!free)
                continue;
            const Landmark landmark = { w.part, candidates[i].place, Point2d(unknown(), unknown()) };
            landmarks.push_back(landmark);
            classes.push_back(w.cls);
        }
        return landmarks;
    }

    //! On the epipolar line, between 20 mm in front of and behind where the landmark is expected.
    void lookRight(int tool, std::vector<Landmark>& landmarks)
    {
        const Ptr<ToolModel>& model = data_.tools[tool].model;
        Mat basePoints;
        model->keypointPositions(joints_[tool], basePoints);
        std::vector<Landmark> kept;
        for (size_t i = 0; i < landmarks.size(); i++)
        {
            Landmark landmark = landmarks[i];
            const double* const p = basePoints.ptr<double>(landmark.part);
            const Vec4d expected = tools_[tool]->view().camera_T_base * Vec4d(p[0], p[1], p[2], 1);
            Mat ray;
            cameras_.left.unprojectPoints(Mat(Vec2d(landmark.left.x, landmark.left.y)).t(), ray);
            const Vec2d r = ray.at<Vec2d>(0);
            double best = LEAST_POSTERIOR;
            for (double depth = expected[2] - 0.02; depth <= expected[2] + 0.02; depth += 0.0005)
            {
                const Vec3d q = Vec3d(r[0] * depth, r[1] * depth, depth);
                const Vec4d inRight = cameras_.right_T_left * Vec4d(q[0], q[1], q[2], 1);
                if (depth < 1e-3 || inRight[2] < 1e-3 || norm(q - Vec3d(expected[0], expected[1], expected[2])) > 0.02)
                    continue;
                const Point2d place = cameras_.right.project(Point3d(inRight[0], inRight[1], inRight[2]));
                std::vector<PartMatch> matches;
                const int beside = cvRound(3 * tools_[tool]->scale());
                const Rect window = Rect(Point(place) - Point(beside, beside), Size(2 * beside + 1, 2 * beside + 1)) &
                                    Rect(Point(), cameras_.right.imageSize());
                if (!window.empty())
                    forest_.detect(window, classOf(tool, landmark.part), 1, matches);
                if (matches.empty() || matches[0].similarity <= best)
                    continue;
                best = matches[0].similarity;
                landmark.right = matches[0].imagePoint;
            }
            const Vec3d away(r[0] * expected[2] - expected[0], r[1] * expected[2] - expected[1], 0);
            if (norm(away) <= 0.02)
                kept.push_back(landmark);
        }
        landmarks.swap(kept);
    }

    static constexpr double LEAST_POSTERIOR = 0.3;

    const Data& data_;
    Forest& forest_;
    PoseRun run_;
    Ptr<PartTemplateRenderer> renderer_;
    Ptr<PartFinder> left_, right_;
    CameraPair cameras_;
    std::vector<Ptr<LandmarkFusion> > tools_;
    std::vector<std::vector<double> > joints_;
};

} // namespace evaluation

#endif
