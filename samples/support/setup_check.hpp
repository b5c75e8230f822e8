// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// What is likely to be wrong with a sequence that can't be tracked: each finding is a line with the key to change.

#ifndef OPENCV_SURGTRACK_SAMPLES_SUPPORT_SETUP_CHECK_HPP
#define OPENCV_SURGTRACK_SAMPLES_SUPPORT_SETUP_CHECK_HPP

#include "opencv2/imgproc.hpp"
#include "opencv2/surgtrack.hpp"
#include "tools.hpp"
#include "units.hpp"
#include "video.hpp"

namespace common {

class SetupCheck
{
public:
    SetupCheck(const cv::surgtrack::Sequence& sequence, const std::vector<Tool>& tools) : sequence_(sequence), tools_(tools) {}

    //! @param stereo the right eye is used
    std::vector<std::string> run(bool stereo)
    {
        cv::VideoCapture video(sequence_.leftVideo());
        end_ = sequence_.frameTime(std::max(0, (int)video.get(cv::CAP_PROP_FRAME_COUNT) - 1));
        const double rate = video.get(cv::CAP_PROP_FPS);
        if (rate > 0 && !sequence_.hasFrameTimes() && std::abs(rate - sequence_.fps()) > 0.01 * rate)
            say(cv::format("sequence.yaml: fps: %g, but the header of the video says %g frames/s", sequence_.fps(), rate));
        for (size_t i = 0; i < tools_.size(); i++)
        {
            const cv::Mat joints = readings((int)i);
            if (!joints.empty())
                checkTool((int)i, joints);
        }
        if (stereo)
            checkEyes();
        return findings_;
    }

private:
    void say(const std::string& finding) { findings_.push_back(finding); }

    //! Readings all over the time that both they and the video cover, a row each.
    cv::Mat readings(int tool)
    {
        const double start = sequence_.frameTime(0), first = std::max(start, sequence_.firstTime(tool)), last = std::min(end_, sequence_.lastTime(tool));
        const std::string name = tools_[tool].info.name;
        cv::Mat joints;
        if (first > last)
            say(cv::format("%s: readings of tool '%s' cover %.3f to %.3f s, the video %.3f to %.3f s: other clocks? time_offset of the tool tells how "
                           "far they are apart", sequence_.kinematicsFile().c_str(), name.c_str(), sequence_.firstTime(tool), sequence_.lastTime(tool),
                           start, end_));
        const int samples = 40;
        std::vector<double> row;
        for (int k = 0; k < samples && first <= last; k++)
            if (sequence_.jointsAt(tool, first + k * (last - first) / samples, row, tools_[tool].model->coordinateNames()))
                joints.push_back(cv::Mat(row).reshape(1, 1).clone());
        return joints;
    }

    void checkTool(int tool, const cv::Mat& joints)
    {
        const Tool& t = tools_[tool];
        const std::string name = t.info.name, fault = unitFault(*t.model, joints);
        const std::string size = sizeFault(*t.model);
        if (!size.empty())
            say(t.info.model + ": " + size);
        if (!fault.empty())
            return say(sequence_.kinematicsFile() + ": tool '" + name + "': " + fault);
        const std::string limit = limitFault(*t.model, joints);
        if (!limit.empty())
            say(sequence_.kinematicsFile() + ": tool '" + name + "': " + limit);
        const cv::Matx44d& T = t.info.nominal_T_base;
        const double seen = share(*t.model, T, joints), enough = 0.5;
        if (seen >= enough)
            return;
        const std::string which = cv::format("sequence.yaml: camera_T_base of tool '%s': the tool is in the image in %.0f %% of the time: ", name.c_str(), 100 * seen);
        if (share(*t.model, T.inv(), joints) >= enough)
            return say(which + "with the inverse it is: is it base_T_camera?");
        for (int other = 0; other < (int)tools_.size(); other++)
            if (other != tool && share(*t.model, tools_[other].info.nominal_T_base, joints) >= enough)
                return say(which + "with that of '" + tools_[other].info.name + "' it is: are the arms exchanged?");
        const double distance = cv::norm(cv::Vec3d(T(0, 3), T(1, 3), T(2, 3)));
        say(which + (distance > 1 ? cv::format("it is %.3g m away, expected metres, not millimetres or centimetres", distance)
                                  : std::string("is it the calibration of this arm and this camera, and is its translation in metres?")));
    }

    static std::string sizeFault(const cv::surgtrack::ToolModel& model)
    {
        for (size_t i = 0; i < model.meshes().size(); i++)
        {
            cv::Mat points = cv::Mat(model.meshes()[i].vertices, true).reshape(1);
            cv::Mat low, high;
            cv::reduce(points, low, 0, cv::REDUCE_MIN);
            cv::reduce(points, high, 0, cv::REDUCE_MAX);
            const double length = cv::norm(high - low, cv::NORM_INF);
            if (length > 1.5 || length < 2e-4)
                return cv::format("mesh_scale: a mesh is %.3g m long, expected metres; 0.001 is right for files in millimetres", length);
        }
        return std::string();
    }

    //! How often a keypoint, or the end effector, is in the image and near enough.
    double share(const cv::surgtrack::ToolModel& model, const cv::Matx44d& camera_T_base, const cv::Mat& joints) const
    {
        const cv::Rect2d image(cv::Point2d(0, 0), cv::Size2d(sequence_.leftCamera().imageSize()));
        int seen = 0;
        for (int i = 0; i < joints.rows; i++)
        {
            cv::Mat keypoints;
            if (model.keypointNames().size() > 0)
                model.keypointPositions(joints.row(i), keypoints);
            cv::Mat_<double> points = keypoints.empty() ? cv::Mat(0, 3, CV_64F) : keypoints.reshape(1, (int)model.keypointNames().size()).clone();
            const cv::Matx44d tip = model.endEffectorPose(joints.row(i));
            points.push_back(cv::Mat(cv::Matx13d(tip(0, 3), tip(1, 3), tip(2, 3))));
            std::vector<cv::Point3d> view;
            for (int k = 0; k < points.rows; k++)
            {
                const cv::Vec4d p = camera_T_base * cv::Vec4d(points(k, 0), points(k, 1), points(k, 2), 1);
                if (p[2] > 0.005 && p[2] < 1)
                    view.push_back(cv::Point3d(p[0], p[1], p[2]));
            }
            if (view.empty())
                continue;
            cv::Mat found;
            sequence_.leftCamera().projectPoints(cv::Mat(view), found);
            const cv::Mat_<double> pixels = found.reshape(1);
            bool inside = false;
            for (int k = 0; k < pixels.rows; k++)
                inside = inside || image.contains(cv::Point2d(pixels(k, 0), pixels(k, 1)));
            seen += inside;
        }
        return joints.rows ? (double)seen / joints.rows : 0;
    }

    void checkEyes()
    {
        const cv::Matx44d T = sequence_.right_T_left();
        const double baseline = cv::norm(cv::Vec3d(T(0, 3), T(1, 3), T(2, 3)));
        if (baseline > 0.05)
            say(cv::format("sequence.yaml: right_T_left: the eyes are %.3g m apart, those of an endoscope some millimetres: is its translation in metres?", baseline));
        else if (T(0, 3) > 0.5 * baseline)
            say("sequence.yaml: right_T_left: has the right eye left of the left one: is it left_T_right?");
        const std::string eyes = eyesFault(sequence_);
        if (!eyes.empty())
            say(eyes);
    }

    //! How well patches of one image are found in the other, if that stands as other_T_one says: the best over all depths.
    static void agreement(const cv::Mat& one, const cv::Mat& other, const std::vector<cv::Point2f>& corners, const cv::surgtrack::CameraModel& oneCamera,
                          const cv::surgtrack::CameraModel& otherCamera, const cv::Matx44d& other_T_one, std::vector<double>& best)
    {
        const int half = 8;
        best.assign(corners.size(), -1);
        std::vector<cv::Point2d> pixels(corners.begin(), corners.end());
        cv::Mat found;
        oneCamera.unprojectPoints(cv::Mat(pixels).reshape(1), found);
        const cv::Mat_<double> rays = found.reshape(1, (int)corners.size());
        for (size_t i = 0; i < corners.size(); i++)
        {
            std::vector<cv::Point3d> points;
            for (double inverse = 1 / 0.03; inverse > 1 / 0.5; inverse *= 0.985)
            {
                const double z = 1 / inverse;
                const double x = rays((int)i, 0) * z, y = rays((int)i, 1) * z;
                const cv::Vec4d p = other_T_one * cv::Vec4d(x, y, z, 1);
                if (p[2] > 0)
                    points.push_back(cv::Point3d(p[0], p[1], p[2]));
            }
            if (points.empty())
                continue;
            cv::Mat pixelsThere;
            otherCamera.projectPoints(cv::Mat(points).reshape(1), pixelsThere);
            std::vector<cv::Point2d> there;
            pixelsThere.reshape(2).copyTo(there);
            const cv::Rect patch(cvRound(corners[i].x) - half, cvRound(corners[i].y) - half, 2 * half + 1, 2 * half + 1), all(cv::Point(), one.size());
            for (size_t k = 0; k < there.size(); k++)
            {
                const cv::Rect at(cvRound(there[k].x) - half, cvRound(there[k].y) - half, 2 * half + 1, 2 * half + 1);
                if ((patch & all) != patch || (at & all) != at)
                    continue;
                cv::Mat result;
                cv::matchTemplate(other(at), one(patch), result, cv::TM_CCOEFF_NORMED);
                best[i] = std::max(best[i], (double)result.at<float>(0, 0));
            }
        }
    }

public:
    /** Whether the first images of the eyes contradict right_T_left: corners are found where they would be with the eyes exchanged.
    @return what is wrong; empty: nothing, or it can't be told */
    static std::string eyesFault(const cv::surgtrack::Sequence& sequence)
    {
        cv::Mat left, right;
        cv::VideoCapture a(sequence.leftVideo()), b(sequence.rightVideo());
        if (!a.read(left) || !b.read(right) || left.size() != right.size())
            return std::string();
        cv::cvtColor(left, left, cv::COLOR_BGR2GRAY);
        cv::cvtColor(right, right, cv::COLOR_BGR2GRAY);
        std::vector<cv::Point2f> corners;
        cv::goodFeaturesToTrack(left, corners, 150, 0.02, 12);
        if (corners.empty())
            return std::string();
        const cv::Matx44d T = sequence.right_T_left();
        std::vector<double> given, exchanged;
        agreement(left, right, corners, sequence.leftCamera(), sequence.rightCamera(), T, given);
        agreement(left, right, corners, sequence.rightCamera(), sequence.leftCamera(), T.inv(), exchanged);
        int forGiven = 0, forExchanged = 0;
        for (size_t i = 0; i < corners.size(); i++)
        {
            forGiven += given[i] > 0.9 && given[i] > exchanged[i] + 0.1;
            forExchanged += exchanged[i] > 0.9 && exchanged[i] > given[i] + 0.1;
        }
        if (forExchanged >= 10 && forExchanged > 3 * forGiven)
            return cv::format("sequence.yaml: left.video, right.video: what is seen in the right image contradicts right_T_left (%d of %d places): are the "
                              "eyes exchanged?", forExchanged, forGiven + forExchanged);
        return std::string();
    }

private:
    const cv::surgtrack::Sequence& sequence_;
    const std::vector<Tool>& tools_;
    double end_;    // time of the last frame [s]
    std::vector<std::string> findings_;
};

} // namespace common

#endif
