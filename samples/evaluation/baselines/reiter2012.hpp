// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// What the paper starts from (Reiter, Allen, Zhao 2012), re-implemented from its description: the whole tool drawn in hundreds of poses
// about that of the kinematics, each frame anew, and matched by its gradient orientations. Published: drawings about the kinematics,
// matching, pyramid, rejection by material. The grid and all numbers are ours.

#ifndef OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_REITER2012_HPP
#define OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_REITER2012_HPP

#include "materials.hpp"
#include "pose_run.hpp"

namespace evaluation {

//! A pose about the one of the kinematics: steps of the grid.
struct Hypothesis
{
    enum { IN_PLANE = 0, OUT_X, OUT_Y, DISTANCE, YAW, PITCH, JAW, COUNT };
    double value[COUNT];   // [rad, rad, rad, share, rad, rad, rad]
    Hypothesis() { std::fill(value, value + COUNT, 0.); }

    static double step(int i)
    {
        static const double steps[] = { 3 * CV_PI / 180, 5 * CV_PI / 180, 5 * CV_PI / 180, 0.08, 0.06, 0.06, 0.1 };
        return steps[i];
    }
    //! @param fine the pitch of the wrist and the jaw, too
    static std::vector<Hypothesis> grid(bool fine)
    {
        std::vector<Hypothesis> all(1);
        for (int i = 0; i < (fine ? int(COUNT) : int(PITCH)); i++)
        {
            const int reach = i == IN_PLANE ? 2 : 1;
            std::vector<Hypothesis> more;
            for (size_t j = 0; j < all.size(); j++)
                for (int k = -reach; k <= reach; k++)
                {
                    more.push_back(all[j]);
                    more.back().value[i] = k * step(i);
                }
            all.swap(more);
        }
        return all;
    }
};

//! Finds one tool in one image as a whole.
class WholeToolSearch
{
public:
    //! What was found: the pose, and how much the image looks like its drawing.
    struct Found
    {
        Matx44d camera_T_tool;
        std::vector<double> joints;
        double similarity;   //!< 0: nothing
        Found() : similarity(0) {}
    };

    /** @param camera of the images @param fine see Hypothesis::grid() @param pyramid half the size first, then the ten best */
    WholeToolSearch(const Ptr<ToolModel>& model, const CameraModel& camera, bool fine, bool pyramid) : model_(model), fine_(fine), pyramid_(pyramid)
    {
        PartTemplateRenderer::Params drawing;
        drawing.boxSize = 0.04;
        drawing.maxFeatures = 400;
        QGOMatcher::Params matching;
        matching.candidates = 1;
        matching.minSimilarity = 0.2;
        for (int level = 0; level < 2; level++)
        {
            renderers_[level] = PartTemplateRenderer::create(Ptr<MeshRenderer>(), drawing);
            renderers_[level]->addTool(model);
            matching.spread = level == 0 ? 3 : 5;   // chosen on paper_rig and exvivo_dual_moved, see doc/accuracy.md
            matchers_[level] = QGOMatcher::create(matching);
        }
        cameras_[0] = camera;
        const Size half(camera.imageSize().width / 2, camera.imageSize().height / 2);
        cameras_[1] = CameraModel(Matx33d(camera.fx / 2, 0, (camera.cx + 0.5) / 2 - 0.5, 0, camera.fy / 2, (camera.cy + 0.5) / 2 - 0.5, 0, 0, 1),
                                  camera.distCoeffs(), half);
        findWrist();
    }

    /** @param image of the camera @param camera_T_tool pose of the kinematics @param joints readings @param reach half the window [pixel] */
    Found search(const Mat& image, const Matx44d& camera_T_tool, const std::vector<double>& joints, double reach)
    {
        nominal_ = camera_T_tool;
        joints_ = joints;
        matchers_[0]->setImage(image);
        const std::vector<Hypothesis> grid = Hypothesis::grid(fine_);
        std::vector<std::pair<Found, Hypothesis> > found;
        if (pyramid_)
        {
            Mat half;
            resize(image, half, cameras_[1].imageSize(), 0, 0, INTER_AREA);
            matchers_[1]->setImage(half);
        }
        for (size_t i = 0; i < grid.size(); i++)
            found.push_back(std::make_pair(match(grid[i], Vec3d(), reach, pyramid_ ? 1 : 0), grid[i]));
        std::stable_sort(found.begin(), found.end(), [](const std::pair<Found, Hypothesis>& a, const std::pair<Found, Hypothesis>& b) {
            return a.first.similarity > b.first.similarity;
        });
        return pyramid_ ? refined(found) : found[0].first;
    }

private:
    enum { BEST = 10 };

    //! The last two coordinates on the way to the end effector, and one that is not on it.
    void findWrist()
    {
        std::vector<int> chain;
        for (int link = model_->endEffectorLink(); link >= 0; link = model_->links()[link].parent)
            if (model_->links()[link].coordinate >= 0)
                chain.push_back(model_->links()[link].coordinate);
        yaw_ = chain.size() > 0 ? chain[0] : -1;
        pitch_ = chain.size() > 1 ? chain[1] : -1;
        jaw_ = -1;
        for (int i = 0; i < (int)model_->coordinateNames().size(); i++)
            if (std::find(chain.begin(), chain.end(), i) == chain.end())
                jaw_ = i;
    }

    //! @param shift of all the poses in the camera frame [m]
    Found match(const Hypothesis& h, const Vec3d& shift, double reach, int level)
    {
        Found result;
        result.joints = joints_;
        const int coordinates[] = { yaw_, pitch_, jaw_ };
        for (int i = 0; i < 3; i++)
            if (coordinates[i] >= 0)
                result.joints[coordinates[i]] += h.value[Hypothesis::YAW + i];
        const Matx33d turn = rotationFromVector(Vec3d(0, 0, h.value[Hypothesis::IN_PLANE])) *
                             rotationFromVector(Vec3d(h.value[Hypothesis::OUT_X], h.value[Hypothesis::OUT_Y], 0));
        result.camera_T_tool = rigid(turn * rotationOf(nominal_), translationOf(nominal_) * (1 + h.value[Hypothesis::DISTANCE]) + shift);
        std::vector<ToolView> views(1);
        views[0].camera_T_base = result.camera_T_tool * rigidInverse(model_->endEffectorPose(result.joints));
        model_->forwardKinematics(result.joints, views[0].base_T_link);
        std::vector<PartTemplate> templates;
        renderers_[level]->render(cameras_[level], views, 0, templates);
        size_t most = 0;
        for (size_t i = 1; i < templates.size(); i++)
            if (templates[i].features.size() > templates[most].features.size())
                most = i;
        if (templates.empty())
            return result;
        const PartTemplate& t = templates[most];
        const int half = cvRound(level ? reach / 2 : reach);
        std::vector<PartMatch> matches;
        const Rect window = Rect(t.anchor - Point(half, half), Size(2 * half + 1, 2 * half + 1)) & Rect(Point(), cameras_[level].imageSize());
        if (window.empty())
            return result;
        matchers_[level]->match(std::vector<PartTemplate>(1, t), std::vector<Rect>(1, window), matches);
        if (matches.empty())
            return result;
        const Point2d moved = matches[0].imagePoint - t.imagePoint;
        const double z = t.viewPoint.z;
        const Vec3d away(moved.x * z / cameras_[level].fx, moved.y * z / cameras_[level].fy, 0);
        result.camera_T_tool = rigid(rotationOf(result.camera_T_tool), translationOf(result.camera_T_tool) + away);
        result.similarity = matches[0].similarity;
        return result;
    }

    //! The ten best in the whole image, and the best of them with half the steps.
    Found refined(const std::vector<std::pair<Found, Hypothesis> >& found)
    {
        const double near = 12;   // [pixel]
        Found best;
        Hypothesis at;
        Vec3d shift;
        for (size_t i = 0; i < found.size() && i < BEST; i++)
        {
            if (found[i].first.similarity == 0)
                continue;
            const Hypothesis& h = found[i].second;
            const Vec3d moved = translationOf(found[i].first.camera_T_tool) - translationOf(nominal_) * (1 + h.value[Hypothesis::DISTANCE]);
            const Found now = match(h, moved, near, 0);
            if (now.similarity <= best.similarity)
                continue;
            best = now;
            at = h;
            shift = moved;
        }
        for (int i = 0; i < (fine_ ? int(Hypothesis::COUNT) : int(Hypothesis::PITCH)) && best.similarity > 0; i++)
            for (int side = -1; side <= 1; side += 2)
            {
                Hypothesis h = at;
                h.value[i] += side * Hypothesis::step(i) / 2;
                const Vec3d moved = translationOf(best.camera_T_tool) - translationOf(nominal_) * (1 + at.value[Hypothesis::DISTANCE]);
                const Found now = match(h, moved, near, 0);
                if (now.similarity <= best.similarity)
                    continue;
                best = now;
                at = h;
                break;
            }
        return best;
    }

    Ptr<ToolModel> model_;
    bool fine_, pyramid_;
    Ptr<PartTemplateRenderer> renderers_[2];   // the whole image, half its size
    Ptr<QGOMatcher> matchers_[2];
    CameraModel cameras_[2];
    Matx44d nominal_;
    std::vector<double> joints_;
    int yaw_, pitch_, jaw_;
};

//! Finds the tools of a sequence with it; it remembers nothing from frame to frame.
class WholeTool
{
public:
    enum { MOST_FRAMES = 60 };

    //! @param materials reject poses by colours; none: nothing is rejected
    WholeTool(const Data& data, const Materials* materials, bool fine) : data_(data), materials_(materials), truths_(data), run_(data, "reiter2012")
    {
        for (size_t i = 0; i < data.tools.size(); i++)
            searches_.push_back(makePtr<WholeToolSearch>(data.tools[i].model, truths_.finder().camera(), fine, true));
        renderer_ = MeshRenderer::createSoftware();
    }

    //! @param frames at most so many are read; 0 = all. At most MOST_FRAMES of them, evenly spread and with truth, are looked at
    Run track(int frames, bool quiet)
    {
        PartFinder& finder = truths_.finder();   // of its reduced images
        common::FrameReader reader(*data_.sequence, 0);
        const int count = frames > 0 ? std::min(frames, reader.count()) : reader.count(), step = 1 + (std::max(count, 1) - 1) / MOST_FRAMES;
        common::Progress progress(count, quiet);
        Mat image;
        std::vector<std::vector<double> > joints;
        for (int frame = 0; (frames == 0 || frame < frames) && reader.read(image); frame++)
        {
            if (frame % step || !truths_.read(frame))
                continue;
            data_.joints(frame, joints);
            finder.setImage(image);
            const Mat pixels = finder.pixels(Rect(Point(), finder.camera().imageSize()));
            const int64 start = getTickCount();
            std::vector<WholeToolSearch::Found> found;
            for (size_t i = 0; i < searches_.size(); i++)
            {
                const Matx44d nominal = data_.tools[i].info.nominal_T_base * data_.tools[i].model->endEffectorPose(joints[i]);
                found.push_back(searches_[i]->search(pixels, nominal, joints[i], 120 * finder.pixelScale()));
            }
            for (int i = 0; i < (int)found.size(); i++)
                run_.add(i, frame, isRight(i, found[i], pixels) ? STATE_TRACKING : STATE_LOST,
                         found[i].similarity > 0 ? found[i].camera_T_tool : data_.tools[i].info.nominal_T_base);
            run_.addFrame(double(getTickCount() - start) / getTickFrequency());
            finder.release();
            progress.show(frame + 1);
        }
        return run_.finish();
    }

private:
    bool isRight(int tool, const WholeToolSearch::Found& found, const Mat& pixels)
    {
        if (found.similarity == 0 || !materials_)
            return found.similarity > 0;
        const Ptr<ToolModel>& model = data_.tools[tool].model;
        Mat depth, ids, shading;
        renderer_->renderTool(model, found.joints, data_.camera_T_base(tool, found.camera_T_tool, found.joints), truths_.finder().camera(), depth, ids,
                              shading);
        return materials_->agreement(pixels, ids, *model) >= 0.6;
    }

    const Data& data_;
    const Materials* materials_;
    TrueParts truths_;
    PoseRun run_;
    std::vector<Ptr<WholeToolSearch> > searches_;
    Ptr<MeshRenderer> renderer_;
};

} // namespace evaluation

#endif
