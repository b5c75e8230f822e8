// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "lab/setup_check/setup_trial.hpp"
#include "opencv2/videoio.hpp"
#include "opencv2/surgtrack/tool_tracker.hpp"

namespace cv { namespace surgtrack {

namespace {

const int stretches = 6, stretchFrames = 6, mostFrames = 5000, leastParts = 4, leastSeen = 15;

} // namespace

void SetupTools::readAs(int tool, std::vector<double>& joints) const
{
    for (size_t c = 0; c < joints.size() && !inDegrees.empty() && !inDegrees[tool].empty(); c++)
        if (inDegrees[tool][c]) joints[c] *= CV_PI / 180;
}

void SetupScore::addParts(const ToolModel& model, const ToolSight& sight, const std::vector<PartMatch>& matches)
{
    std::vector<char> isEnd(model.links().size(), 1);    // no mesh hangs on it
    for (int i = (int)isEnd.size() - 1; i >= 0; i--)
        if (model.links()[i].parent >= 0 && (model.links()[i].mesh >= 0 || !isEnd[i])) isEnd[model.links()[i].parent] = 0;
    for (size_t i = 0; i < sight.templates.size(); i++) seen[(int)isEnd[model.keypoints()[sight.templates[i].part].link]]++;
    for (size_t i = 0; i < matches.size(); i++) matched[(int)isEnd[model.keypoints()[matches[i].part].link]] += matches[i].similarity;
}

bool SetupScore::isGood() const
{
    const double score = share() * evidence - 2 * nis;
    if (std::min(seen[0], seen[1]) < leastSeen) return score >= 0.9;
    return score + 4 * (matched[1] / seen[1] - matched[0] / seen[0]) >= 1.3;
}

SetupTrial::SetupTrial(const Sequence& sequence) : sequence_(sequence)
{
    const String filename = sequence.leftVideo();
    VideoCapture video(filename);
    if (!video.isOpened()) CV_Error(Error::StsObjectNotFound, format("%s: can't be read as a video", filename.c_str()));
    video.set(CAP_PROP_ORIENTATION_AUTO, 0);   // as the camera was calibrated
    double first = -DBL_MAX, last = DBL_MAX;   // of the readings
    for (int i = 0; i < sequence.toolCount(); i++)
    {
        first = std::max(first, sequence.firstTime(i));
        last = std::min(last, sequence.lastTime(i));
    }
    const int count = std::min(mostFrames, (int)video.get(CAP_PROP_FRAME_COUNT));
    int begin = 0, end = count;
    while (begin < end && sequence.frameTime(begin) < first) begin++;
    while (end > begin && sequence.frameTime(end - 1) > last) end--;
    for (int k = 0; k < stretches && end > begin; k++)
    {
        const int start = begin + (2 * k + 1) * (end - begin) / (2 * stretches);
        if (starts_.empty() || start >= starts_.back() + stretchFrames) starts_.push_back(start);
    }
    size_t next = 0;   // stretch
    Mat image;
    for (int frame = 0; next < starts_.size() && video.grab(); frame++)
    {
        if (frame < starts_[next]) continue;
        if (!video.retrieve(image) || image.size() != sequence.frameSize()) break;
        Mat& left = images_[frame];
        sequence.eyeImage(image.clone(), left, 0);
        next += frame + 1 == starts_[next] + stretchFrames;
    }
}

void SetupTrial::trackStretch(const SetupTools& tools, int start, std::vector<SetupScore>& scores) const
{
    const Ptr<ToolTracker> tracker = ToolTracker::create(sequence_.leftCamera());
    for (size_t i = 0; i < tools.models.size(); i++) tracker->addTool(tools.models[i], tools.nominal_T_base[i]);
    std::vector<std::vector<double> > joints(tools.models.size());
    std::vector<ToolEstimate> estimates;
    for (int frame = start; frame < start + stretchFrames; frame++)
    {
        const std::map<int, Mat>::const_iterator image = images_.find(frame);
        if (image == images_.end()) return;
        const double time = sequence_.frameTime(frame);
        for (size_t i = 0; i < joints.size(); i++)
        {
            if (!sequence_.jointsAt((int)i, time + tools.timeOffsets[i], joints[i], tools.models[i]->coordinateNames())) return;
            tools.readAs((int)i, joints[i]);
        }
        Mat turned = image->second;
        if (tools.upsideDown) rotate(image->second, turned, ROTATE_180);
        tracker->update(turned, time, joints, estimates);
        for (size_t i = 0; i < estimates.size(); i++)
        {
            const ToolEstimate& e = estimates[i];
            SetupScore& score = scores[i];
            score.tried++;
            if (e.visibleParts < leastParts) continue;
            score.frames++;
            score.parts += e.visibleParts;
            if (e.state != STATE_TRACKING) continue;
            score.tracked++;
            score.evidence += e.similarity + e.contourSupport;
            score.nis += e.nis;
            score.addParts(*tools.models[i], tracker->sight((int)i), e.matches);
        }
    }
}

std::vector<SetupScore> SetupTrial::run(const SetupTools& tools) const
{
    std::vector<SetupScore> scores(tools.models.size());
    for (size_t k = 0; k < starts_.size(); k++) trackStretch(tools, starts_[k], scores);
    for (size_t i = 0; i < scores.size(); i++)
    {
        scores[i].parts /= std::max(1, scores[i].frames);
        scores[i].evidence /= std::max(1, scores[i].tracked);
        scores[i].nis /= std::max(1, scores[i].tracked);
    }
    return scores;
}

}} // namespace cv::surgtrack
