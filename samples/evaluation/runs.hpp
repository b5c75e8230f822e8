// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// What evaluate runs over a sequence: the tracker with a method, or a control that looks at no image; its errors, frame by frame; and
// a picture of the worst one.

#ifndef OPENCV_SURGTRACK_SAMPLES_EVALUATION_RUNS_HPP
#define OPENCV_SURGTRACK_SAMPLES_EVALUATION_RUNS_HPP

#include "opencv2/imgcodecs.hpp"
#include "opencv2/imgproc.hpp"
#include "measures.hpp"
#include "../support/frame_reader.hpp"

namespace evaluation {

//! One tool in one frame, beside the truth.
struct Record
{
    int frame, tool, state;
    double time;
    double translation, rotation;   //!< errors [m, rad]
    Vec3d axes;                     //!< rotation vector of R_true^T R_estimate: about the axes of the end effector [rad]
    Vec6d error;                    //!< poseError()
    Vec6d sigma;                    //!< its standard deviations; zeros without a covariance
    double nees, rotationNees, translationNees;   //!< of 6, 3, 3 degrees of freedom; unknown without a covariance
    double nis;                     //!< per degree of freedom; unknown if nothing was measured
    int visible, inliers;           //!< -1: a control
    double similarity, contourSupport;
    double space, image;            //!< PointDistance
    std::vector<double> offsets, trueOffsets;   //!< of the joints; empty if there are none
    bool covered() const { return state == STATE_TRACKING || state == STATE_COASTING; }
};

//! A frame to look at.
struct WorstFrame
{
    Record record;
    Mat image;   //!< empty: there is none
    Matx44d camera_T_base, true_camera_T_base;
    std::vector<double> joints, trueJoints;
};

struct Run
{
    String method;                  //!< full, full-stereo, paper, epnp, recorded, frozen
    std::vector<Record> records;
    std::vector<LabelError> labels;
    std::vector<PoseScore> scores;  //!< a tool; the last: all of them
    int frames;                     //!< of the video
    double seconds;                 //!< in ToolTracker::update(); 0: a control
    Record worst;                   //!< the tracked frame with the largest translation error
    std::vector<uchar> picture;     //!< of it, a PNG file; empty: there is none
    Run() : frames(0), seconds(0), worst() {}
    bool isControl() const { return method == "recorded" || method == "frozen"; }
};

inline void drawSkeletons(Mat& image, const CameraModel& camera, const Data& data, const WorstFrame& worst)
{
    const Ptr<ToolModel>& model = data.tools[worst.record.tool].model;
    drawSkeleton(image, camera, model, worst.trueJoints, worst.true_camera_T_base, Scalar(255, 255, 255));
    drawSkeleton(image, camera, model, worst.joints, worst.camera_T_base, Scalar(0, 255, 0));
}

/** The frame with truth in white and estimate in green, beside it the surroundings of the tool twice as large. */
inline Mat overlayOf(const Data& data, const WorstFrame& worst)
{
    const CameraModel camera = data.sequence->leftCamera();
    Mat image = worst.image.clone();
    if (image.channels() == 1)
        cvtColor(worst.image, image, COLOR_GRAY2BGR);
    const Ptr<ToolModel>& model = data.tools[worst.record.tool].model;
    Mat basePoints;
    model->keypointPositions(worst.trueJoints, basePoints);
    Point2d centre;
    for (int i = 0; i < basePoints.rows; i++)
    {
        const Vec4d p = worst.true_camera_T_base * Vec4d(basePoints.at<double>(i, 0), basePoints.at<double>(i, 1), basePoints.at<double>(i, 2), 1);
        if (p[2] > 1e-3)
            centre += camera.project(Point3d(p[0], p[1], p[2])) * (1. / basePoints.rows);
    }
    const int side = std::min(image.rows, image.cols) / 2;   // the inset, twice that, is as high as a wide frame or lower
    const Rect crop(std::min(std::max(cvRound(centre.x) - side / 2, 0), image.cols - side),
                    std::min(std::max(cvRound(centre.y) - side / 2, 0), image.rows - side), side, side);
    Mat inset;
    resize(image(crop), inset, Size(), 2, 2, INTER_CUBIC);
    const Matx33d K(2 * camera.fx, 0, 2 * (camera.cx - crop.x + 0.5) - 0.5, 0, 2 * camera.fy, 2 * (camera.cy - crop.y + 0.5) - 0.5, 0, 0, 1);
    drawSkeletons(inset, CameraModel(K, camera.distCoeffs(), inset.size()), data, worst);
    drawSkeletons(image, camera, data, worst);
    Mat result(image.rows, image.cols + inset.cols, CV_8UC3, Scalar::all(0));
    image.copyTo(result(Rect(Point(), image.size())));
    inset.copyTo(result(Rect(image.cols, 0, inset.cols, std::min(inset.rows, image.rows))));
    return result;
}

inline Record recordOf(const Data& data, int tool, int frame, int state, const Matx44d& camera_T_tool, const Truth& truth)
{
    Record r;
    r.frame = frame;
    r.tool = tool;
    r.state = state;
    r.time = data.time(frame);
    r.error = Vec6d(poseError(camera_T_tool, truth.camera_T_tool).val);
    r.axes = Vec3d(poseError(rigidInverse(camera_T_tool), rigidInverse(truth.camera_T_tool)).val);   // its first three: R_true^T R_estimate
    r.translation = norm(Vec3d(r.error[3], r.error[4], r.error[5]));
    r.rotation = norm(r.axes);
    r.nees = r.rotationNees = r.translationNees = r.nis = unknown();
    r.visible = r.inliers = -1;
    r.similarity = r.contourSupport = r.space = r.image = unknown();
    return r;
}

//! Adds what an estimate says of itself.
inline void addEvidence(const ToolEstimate& e, const Truth& truth, const std::vector<double>& readings, Record& r)
{
    r.visible = e.visibleParts;
    r.inliers = e.inliers;
    r.similarity = e.similarity;
    r.contourSupport = e.contourSupport;
    if (e.nis > 0)
        r.nis = e.nis;
    for (int i = 0; i < 6; i++)
        r.sigma[i] = std::sqrt(std::max(0., e.covariance(i, i)));
    r.nees = normalizedErrorSquared(r.error, e.covariance);
    r.rotationNees = normalizedErrorSquared(r.error, e.covariance, 0, 3);
    r.translationNees = normalizedErrorSquared(r.error, e.covariance, 3, 3);
    r.offsets = e.jointOffsets;
    for (size_t i = 0; i < truth.joints.size(); i++)
        r.trueOffsets.push_back(truth.joints[i] - readings[i]);
}

inline void score(const Data& data, PoseScorer& scorer, Run& run)
{
    for (int i = 0; i < (int)data.tools.size(); i++)
        run.scores.push_back(scorer.score(i));
    run.scores.push_back(scorer.score(-1));
}

//! Tracks a sequence.
class TrackedRun
{
public:
    /** @param data the sequence; must outlive this
    @param name of the method, for the tables
    @param method see TrackingMethod
    @param stereo the right image too
    @param keepWorst whether the worst frame's image is wanted */
    TrackedRun(const Data& data, const String& name, int method, bool stereo, bool keepWorst)
        : data_(data), stereo_(stereo), keepWorst_(keepWorst)
    {
        run_.method = name;
        ToolTracker::Params params;
        params.method = method;
        tracker_ = ToolTracker::create(data.sequence->leftCamera(), params);
        for (size_t i = 0; i < data.tools.size(); i++)
            tracker_->addTool(data.tools[i].model, data.tools[i].info.nominal_T_base);
        if (stereo)
            tracker_->setRightCamera(data.sequence->rightCamera(), data.sequence->right_T_left());
        common::setMasks(*data.sequence, *tracker_, stereo);
        scorer_ = PoseScorer::create(data.sequence->leftCamera(), common::modelsOf(data.tools));
        for (size_t i = 0; i < data.tools.size(); i++)
            points_.push_back(ToolPoints(data.tools[i].model));
    }

    //! @param frames at most so many; 0 = all
    const Run& track(int frames, bool quiet)
    {
        common::EyesReader reader(*data_.sequence, 0, stereo_);
        common::Progress progress(frames > 0 ? std::min(frames, reader.count()) : reader.count(), quiet);
        Mat left, right;
        std::vector<std::vector<double> > joints;
        std::vector<ToolEstimate> estimates;
        for (int frame = 0; frames == 0 || frame < frames; frame++)
        {
            if (!reader.read(left, right))
                break;
            run_.frames++;
            if (!data_.hasPoses() && !data_.hasJoints(frame))   // recordings hardly ever start together
            {
                for (int i = 0; i < (int)data_.tools.size(); i++)
                    addLabels(data_, i, frame, Matx44d::eye(), std::vector<double>(), run_.labels);
                continue;
            }
            data_.joints(frame, joints);
            update(left, right, data_.time(frame), joints, estimates);
            for (int i = 0; i < (int)estimates.size(); i++)
                take(frame, i, left, joints[i], estimates[i]);
            if (reader.readSecond(left, right))   // the poses of a frame are those of its first field
            {
                data_.joints(frame, joints, 1);
                update(left, right, data_.time(frame, 1), joints, estimates);
            }
            progress.show(run_.frames);
        }
        if (run_.frames == 0)
            fail(data_.sequence->leftVideo() + ": has no frames");
        const StageTime total = tracker_->getTimings().back();
        run_.seconds = total.mean * total.calls;
        score(data_, *scorer_, run_);
        if (!worst_.image.empty())
        {
            run_.worst = worst_.record;
            imencode(".png", overlayOf(data_, worst_), run_.picture);
        }
        return run_;
    }

private:
    void update(const Mat& left, const Mat& right, double time, const std::vector<std::vector<double> >& joints, std::vector<ToolEstimate>& estimates)
    {
        if (stereo_)
            tracker_->updateStereo(left, right, time, joints, estimates);
        else
            tracker_->update(left, time, joints, estimates);
    }

    void take(int frame, int tool, const Mat& image, const std::vector<double>& readings, const ToolEstimate& e)
    {
        addLabels(data_, tool, frame, e.camera_T_tool, common::isKnown(e) ? e.joints : std::vector<double>(), run_.labels);
        Truth truth;
        if (!data_.truth(tool, frame, truth))
            return;
        scorer_->add(tool, e.state, e.camera_T_tool, truth.camera_T_tool);
        Record r = recordOf(data_, tool, frame, e.state, e.camera_T_tool, truth);
        addEvidence(e, truth, readings, r);
        const PointDistance d = distanceOf(points_[tool], data_.sequence->leftCamera(), e.camera_T_tool, e.joints, truth.camera_T_tool, truth.joints);
        r.space = d.space;
        r.image = d.image;
        run_.records.push_back(r);
        WorstFrame& worst = worst_;
        if (!keepWorst_ || e.state != STATE_TRACKING || (!worst.image.empty() && r.translation <= worst.record.translation))
            return;
        worst.record = r;
        image.copyTo(worst.image);
        worst.joints = e.joints;
        worst.trueJoints = truth.joints.empty() ? readings : truth.joints;
        worst.camera_T_base = data_.camera_T_base(tool, e.camera_T_tool, worst.joints);
        worst.true_camera_T_base = data_.camera_T_base(tool, truth.camera_T_tool, worst.trueJoints);
    }

    const Data& data_;
    bool stereo_, keepWorst_;
    Ptr<ToolTracker> tracker_;
    Ptr<PoseScorer> scorer_;
    std::vector<ToolPoints> points_;   // a tool
    Run run_;
    WorstFrame worst_;
};

/** @brief A control: a pose in every frame from the recorded joints and a correction that does not change.
@param data the sequence
@param frozen the true correction of the first frame with truth, with which the pose of that frame is exact; false: none
@param frames at most so many; 0 = all with truth */
inline Run control(const Data& data, bool frozen, int frames)
{
    Run run;
    run.method = frozen ? "frozen" : "recorded";
    const Ptr<PoseScorer> scorer = PoseScorer::create(data.sequence->leftCamera(), common::modelsOf(data.tools));
    const int end = data.sequence->groundTruthEnd();
    std::vector<Matx44d> corrections(data.tools.size(), Matx44d::eye());
    std::vector<char> known(data.tools.size(), !frozen);
    std::vector<std::vector<double> > joints;
    for (int frame = 0; frame < end && (frames == 0 || frame < frames); frame++)
    {
        data.joints(frame, joints);
        for (int i = 0; i < (int)data.tools.size(); i++)
        {
            Truth truth;
            if (!data.truth(i, frame, truth))
                continue;
            const Matx44d nominal_T_tool = data.tools[i].info.nominal_T_base * data.tools[i].model->endEffectorPose(joints[i]);
            if (!known[i])
                corrections[i] = truth.camera_T_tool * rigidInverse(nominal_T_tool);
            known[i] = true;
            const Matx44d camera_T_tool = corrections[i] * nominal_T_tool;
            scorer->add(i, STATE_TRACKING, camera_T_tool, truth.camera_T_tool);
            run.records.push_back(recordOf(data, i, frame, STATE_TRACKING, camera_T_tool, truth));
        }
        run.frames++;
    }
    score(data, *scorer, run);
    return run;
}

} // namespace evaluation

#endif
