// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/videoio.hpp"
#include "opencv2/surgtrack/setup_check.hpp"
#include "opencv2/surgtrack/tool_setup.hpp"
#include "opencv2/surgtrack/time_offset.hpp"
#include "base/geometry.hpp"
#include "lab/setup_check/setup_trial.hpp"
#include "lab/setup_check/setup_units.hpp"

namespace cv { namespace surgtrack {

namespace {

const double enoughSeen = 0.5;         // share of the time that a tool should be in the image
const double farthestSeen = 1;         // [m]
const int leastKeypoints = 6;

class SetupCheck
{
public:
    SetupCheck(const Ptr<Sequence>& sequence, std::vector<String>& findings, std::vector<String>& figures)
        : sequence_(sequence), file_(sequence->descriptionFile()), findings_(findings), figures_(figures), end_(0)
    {
        for (int i = 0; i < sequence->toolCount(); i++)
        {
            infos_.push_back(sequence->tool(i));
            int same = 0;
            while (infos_[same].model != infos_[i].model) same++;
            tools_.models.push_back(same < i ? tools_.models[same] : loadTool(infos_[i].model));
            tools_.nominal_T_base.push_back(infos_[i].nominal_T_base);
        }
        tools_.timeOffsets.assign(infos_.size(), 0.);
    }

    void run(bool stereo)
    {
        checkVideo();
        for (int i = 0; i < (int)infos_.size(); i++)
        {
            const Mat joints = readings(i);
            if (!joints.empty()) checkTool(i, joints);
        }
        if (stereo) checkBaseline();
        if (findings_.empty()) tryOut();
    }

private:
    void say(const String& finding) { findings_.push_back(finding); }

    void checkVideo()
    {
        VideoCapture video(sequence_->leftVideo());
        end_ = sequence_->frameTime(std::max(0, (int)video.get(CAP_PROP_FRAME_COUNT) - 1));
        const double rate = video.get(CAP_PROP_FPS);
        const bool images = sequence_->leftVideo().find('%') != String::npos;   // have no rate of their own
        if (rate > 0 && !images && !sequence_->hasFrameTimes() && std::abs(rate - sequence_->fps()) > 0.01 * rate)
            say(file_ + format(": fps: %g, but the header of the video says %g frames/s", sequence_->fps(), rate));
    }

    //! Readings all over the time that both they and the video cover, a row each.
    Mat readings(int tool)
    {
        const double start = sequence_->frameTime(0), first = std::max(start, sequence_->firstTime(tool)), last = std::min(end_, sequence_->lastTime(tool));
        Mat joints;
        if (first > last)
            say(format("%s: readings of tool '%s' cover %.3f to %.3f s, the video %.3f to %.3f s: other clocks? time_offset of the tool tells how "
                       "far they are apart", sequence_->kinematicsFile().c_str(), infos_[tool].name.c_str(), sequence_->firstTime(tool),
                       sequence_->lastTime(tool), start, end_));
        const int samples = 40;
        std::vector<double> row;
        for (int k = 0; k < samples && first <= last; k++)
            if (sequence_->jointsAt(tool, first + k * (last - first) / samples, row, tools_.models[tool]->coordinateNames()))
                joints.push_back(Mat(row).reshape(1, 1).clone());
        return joints;
    }

    void checkTool(int i, const Mat& joints)
    {
        const ToolModel& model = *tools_.models[i];
        const String size = sizeFault(model), units = checkUnits(tools_.models[i], joints), limits = limitFault(model, joints);
        if (!size.empty()) say(infos_[i].model + ": " + size);
        if ((int)model.keypoints().size() < leastKeypoints)
            say(format("%s: keypoints: %d, expected at least %d to track by", infos_[i].model.c_str(), (int)model.keypoints().size(), leastKeypoints));
        const String& fault = units.empty() ? limits : units;
        if (fault.empty()) checkHandEye(i, joints);
        else say(sequence_->kinematicsFile() + ": tool '" + infos_[i].name + "': " + fault);
    }

    void checkHandEye(int i, const Mat& joints)
    {
        const Matx44d& T = infos_[i].nominal_T_base;
        const double seen = shareSeen(*tools_.models[i], T, joints);
        if (seen >= enoughSeen) return;
        const String which = file_ + format(": camera_T_base of tool '%s': the tool is in the image in %.0f %% of the time: ", infos_[i].name.c_str(), 100 * seen);
        if (shareSeen(*tools_.models[i], rigidInverse(T), joints) >= enoughSeen) return say(which + "with the inverse it is: is it base_T_camera?");
        for (size_t other = 0; other < infos_.size(); other++)
            if ((int)other != i && shareSeen(*tools_.models[i], infos_[other].nominal_T_base, joints) >= enoughSeen)
                return say(which + "with that of '" + infos_[other].name + "' it is: are the arms exchanged?");
        const double distance = norm(Vec3d(T(0, 3), T(1, 3), T(2, 3)));
        if (distance <= farthestSeen && checkDegrees(i, joints)) return;
        say(which + (distance > farthestSeen ? format("it is %.3g m away, expected metres, not millimetres or centimetres", distance)
                                             : String("is it the calibration of this arm and this camera, and is its translation in metres?")));
    }

    //! Is the tool in the image if some readings are degrees? The fewest with which it is.
    bool checkDegrees(int i, const Mat& joints)
    {
        const std::vector<int> all = mayBeDegrees(*tools_.models[i], joints);
        std::vector<char> best;
        double bestSeen = 0;
        for (int subset = 1; subset < 1 << all.size(); subset++)
        {
            std::vector<char> chosen(joints.cols);
            Mat read = joints.clone();
            for (size_t k = 0; k < all.size(); k++)
                if (subset >> k & 1)
                {
                    chosen[all[k]] = 1;
                    read.col(all[k]) *= CV_PI / 180;
                }
            const double seen = shareSeen(*tools_.models[i], infos_[i].nominal_T_base, read);
            const bool fewer = std::count(chosen.begin(), chosen.end(), 1) < std::count(best.begin(), best.end(), 1);
            if (seen < enoughSeen || seen < bestSeen || (seen == bestSeen && !fewer)) continue;
            best = chosen;
            bestSeen = seen;
        }
        if (best.empty()) return false;
        sayDegrees(i, best, joints, format("the tool is in the image in %.0f %% of the time", 100 * bestSeen));
        return true;
    }

    void sayDegrees(int i, const std::vector<char>& chosen, const Mat& joints, const String& then)
    {
        String names;
        for (int c = 0; c < joints.cols; c++)
            if (chosen[c])
                names += (names.empty() ? "" : ", ") + tools_.models[i]->coordinateNames()[c] + format(" (to %.3g)", norm(joints.col(c), NORM_INF));
        say(sequence_->kinematicsFile() + ": tool '" + infos_[i].name + "': " + names + ": read as degrees, " + then
            + ", else not: expected radians, not degrees");
    }

    //! How often a keypoint, or the end effector, is in the image and near enough.
    double shareSeen(const ToolModel& model, const Matx44d& camera_T_base, const Mat& joints) const
    {
        const CameraModel camera = sequence_->leftCamera();
        const Rect2d image(Point2d(0, 0), Size2d(camera.imageSize()));
        int seen = 0;
        for (int i = 0; i < joints.rows; i++)
        {
            Mat keypoints(0, 3, CV_64F);
            if (!model.keypoints().empty()) model.keypointPositions(joints.row(i), keypoints);
            const Matx44d tip = model.endEffectorPose(joints.row(i));
            keypoints.push_back(Mat(Matx13d(tip(0, 3), tip(1, 3), tip(2, 3))));
            bool inside = false;
            for (int k = 0; k < keypoints.rows && !inside; k++)
            {
                const Point3d p = transform(camera_T_base, Point3d(Vec3d(keypoints.ptr<double>(k))));
                inside = p.z > nearestDepth && p.z < farthestSeen && image.contains(camera.project(p));
            }
            seen += inside;
        }
        return joints.rows ? (double)seen / joints.rows : 0;
    }

    void checkBaseline()
    {
        const Matx44d T = sequence_->right_T_left();
        const double baseline = norm(Vec3d(T(0, 3), T(1, 3), T(2, 3)));
        if (baseline > 0.05)
            say(file_ + format(": right_T_left: the eyes are %.3g m apart, those of an endoscope some millimetres: is its translation in metres?", baseline));
        else if (T(0, 3) > 0.5 * baseline)
            say(file_ + ": right_T_left: has the right eye left of the left one: is it left_T_right?");
        const String eyes = checkEyes(sequence_);
        if (!eyes.empty()) say(eyes);
    }

    //! What only tracking shows.
    void tryOut()
    {
        const SetupTrial trial(*sequence_);
        const std::vector<SetupScore> scores = trial.run(tools_);
        bool good = true;
        for (size_t i = 0; i < scores.size(); i++)
        {
            const SetupScore& s = scores[i];
            figures_.push_back(format("%s: %.1f of %d parts can be seen, tracked in %d of %d frames, evidence %.2f", infos_[i].name.c_str(), s.parts,
                                      (int)tools_.models[i]->keypoints().size(), s.tracked, s.frames, s.evidence));
            good = good && (s.isGood() || !s.isJudged());
            if (s.frames * 4 < s.tried)
                say(format("%s: keypoints: of tool '%s' fewer than four can be seen in %d of %d frames: do they lie inside the meshes, or does its calibration "
                           "leave it at the border of the image?", infos_[i].model.c_str(), infos_[i].name.c_str(), s.tried - s.frames, s.tried));
        }
        if (good || exchanged(trial, scores) || late(trial, scores) || inDegrees(trial, scores) || upsideDown(trial)) return;
        for (size_t i = 0; i < scores.size(); i++)
            if (scores[i].isJudged() && !scores[i].isGood()) blame(infos_[i], scores[i]);
    }

    void blame(const SequenceTool& tool, const SetupScore& s)
    {
        const bool lost = s.share() < 0.1;
        say(file_ + format(": model of tool '%s': %s (tracked in %.0f %% of the frames, evidence %.2f): is it another instrument? Else %s",
                   tool.name.c_str(), lost ? "what is seen is not it" : "what is seen is not quite it", 100 * s.share(), s.evidence,
                   lost ? "another arm (name), another time (time_offset), or a calibration that is off by centimetres (camera_T_base)"
                        : "another time (time_offset), or it is hidden or blurred"));
    }

    //! Are calibrations or tool files of two arms exchanged?
    bool exchanged(const SetupTrial& trial, const std::vector<SetupScore>& scores)
    {
        for (size_t i = 0; i < infos_.size(); i++)
            for (size_t j = i + 1; j < infos_.size(); j++)
            {
                if ((scores[i].isGood() && scores[j].isGood()) || !(scores[i].isJudged() || scores[j].isJudged())) continue;
                SetupTools arms = tools_, instruments = tools_;
                std::swap(arms.nominal_T_base[i], arms.nominal_T_base[j]);
                std::swap(instruments.models[i], instruments.models[j]);
                const String names = "'" + infos_[i].name + "' and '" + infos_[j].name + "'";
                if (bothGood(trial.run(arms), i, j))
                {
                    say(file_ + ": camera_T_base of " + names + ": tools are found with each other's, not with their own: are the arms exchanged, here or in "
                        + sequence_->kinematicsFile() + "?");
                    return true;
                }
                const bool other = infos_[i].model != infos_[j].model && tools_.models[i]->coordinateNames() == tools_.models[j]->coordinateNames();
                if (!other || !bothGood(trial.run(instruments), i, j)) continue;
                say(file_ + ": model of " + names + ": tools are found with each other's, not with their own: are the tool files exchanged?");
                return true;
            }
        return false;
    }

    //! Are readings that follow each other in the chain degrees? Found if the tool is with these, as a wrist that is somewhere else is hardly.
    bool inDegrees(const SetupTrial& trial, const std::vector<SetupScore>& before)
    {
        bool any = false;
        for (size_t i = 0; i < infos_.size(); i++)
        {
            if (before[i].isGood() || before[i].tried == 0) continue;
            const Mat joints = readings((int)i);
            const std::vector<int> all = mayBeDegrees(*tools_.models[i], joints);
            bool found = false;
            for (size_t count = all.size(); count > 0 && !found; count--)
                for (size_t first = 0; first + count <= all.size() && !found; first++)
                {
                    SetupTools tools = tools_;
                    tools.inDegrees.resize(infos_.size());
                    tools.inDegrees[i].resize(joints.cols);
                    for (size_t k = first; k < first + count; k++) tools.inDegrees[i][all[k]] = 1;
                    const SetupScore score = trial.run(tools)[i];
                    found = score.isJudged() && score.isGood();
                    if (found) sayDegrees((int)i, tools.inDegrees[i], joints, "the tool is found");
                }
            any = any || found;
        }
        return any;
    }

    //! Are the images turned against those of the calibration?
    bool upsideDown(const SetupTrial& trial)
    {
        SetupTools tools = tools_;
        tools.upsideDown = true;
        const std::vector<SetupScore> scores = trial.run(tools);
        for (size_t i = 0; i < scores.size(); i++)
            if (!scores[i].isJudged() || !scores[i].isGood()) return false;
        say(file_ + ": left.video: tools are found in images turned by 180 degrees, not in these: expected images as the camera was calibrated with");
        return true;
    }

    static bool bothGood(const std::vector<SetupScore>& scores, size_t i, size_t j)
    {
        return scores[i].isJudged() && scores[j].isJudged() && scores[i].isGood() && scores[j].isGood();
    }

    //! Is it another time? Arms may have clocks of their own.
    bool late(const SetupTrial& trial, const std::vector<SetupScore>& before)
    {
        SetupTools tools = tools_;
        TimeOffsetParams params;
        params.frames /= 2;   // half the time: what is found is tried
        for (params.tool = 0; params.tool < (int)infos_.size(); params.tool++)
        {
            TimeOffset found;
            const bool judged = before[params.tool].isJudged() && !before[params.tool].isGood();
            if (judged && estimateTimeOffset(sequence_, found, params) && std::abs(found.offset) * sequence_->fps() >= 1)
                tools.timeOffsets[params.tool] = found.offset;
        }
        if (tools.timeOffsets == tools_.timeOffsets) return false;
        const std::vector<SetupScore> scores = trial.run(tools);
        for (size_t i = 0; i < scores.size(); i++)
            if (scores[i].isJudged() && !scores[i].isGood()) return false;
        for (size_t i = 0; i < scores.size(); i++)
            if (tools.timeOffsets[i] != 0)
                say(file_ + format(": time_offset of tool '%s': it is found with readings that are stamped %.3f s later than the images (%.3f), not with "
                           "those of their time: do the clocks differ?", infos_[i].name.c_str(), tools.timeOffsets[i], infos_[i].timeOffset + tools.timeOffsets[i]));
        return true;
    }

    const Ptr<Sequence> sequence_;
    const String file_;
    std::vector<String>&findings_, &figures_;
    std::vector<SequenceTool> infos_;
    SetupTools tools_;
    double end_;    // time of the last frame [s]
};

} // namespace

void checkSetup(const Ptr<Sequence>& sequence, std::vector<String>& findings, std::vector<String>& figures, bool stereo)
{
    if (!sequence) CV_Error(Error::StsNullPtr, "sequence: expected one that is loaded");
    findings.clear();
    figures.clear();
    SetupCheck(sequence, findings, figures).run(stereo);
}

}} // namespace cv::surgtrack
