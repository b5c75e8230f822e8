// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "lab/time_offset/time_offset.hpp"
#include "opencv2/videoio.hpp"

namespace cv { namespace surgtrack {

namespace {

const double searchShift = 0.014;   // half-width of the search windows [m on the tool]
const double blockTime = 2;         // of one hand-eye correction [s]
const int maxBlocks = 8, maxCandidates = 3;

double scoreOf(const std::vector<PartMatch>& inliers)
{
    double score = 0;
    for (size_t i = 0; i < inliers.size(); i++) score += std::max(0., inliers[i].similarity - chanceSimilarity);
    return score;
}

} // namespace

// Keeps frames spread evenly over the part of the video that may have readings.
void TimeOffsetEstimator::readFrames()
{
    const String filename = sequence_.leftVideo();
    VideoCapture video(filename);
    if (!video.isOpened()) CV_Error(Error::StsObjectNotFound, format("%s: can't be read as a video", filename.c_str()));
    int total = int(video.get(CAP_PROP_FRAME_COUNT));
    if (total <= 0)   // not known to every container
    {
        for (total = 0; video.grab();) total++;
        video.open(filename);
    }
    double first = DBL_MAX, last = -DBL_MAX;
    for (size_t i = 0; i < tools_.size(); i++)
    {
        first = std::min(first, sequence_.firstTime(int(i)));
        last = std::max(last, sequence_.lastTime(int(i)));
    }
    const double span = (reach_ + 1) * step_, fps = sequence_.fps();
    const int begin = int(std::min(double(total), std::max(0., (first - params_.expected - span) * fps)));
    const int end = int(std::max(0., std::min(double(total), (last - params_.expected + span) * fps + 1)));
    const int cell = stride_;
    stride_ = cell * std::max(1, (end - begin + cell * params_.frames - 1) / (cell * params_.frames));
    const Size size = sequence_.leftCamera().imageSize();
    Mat image;
    for (int frame = 0; frame < end && video.grab(); frame++)
    {
        if (frame < begin || frame % stride_ != 0) continue;
        if (!video.retrieve(image)) break;
        if (image.size() != size)
            CV_Error(Error::StsUnmatchedSizes, format("%s: frame %d has %dx%d pixels, expected %dx%d as in sequence.yaml", filename.c_str(),
                                                      frame, image.cols, image.rows, size.width, size.height));
        Mat kept;
        if (reduction_ > 1) resize(image, kept, camera_.imageSize(), 0, 0, INTER_AREA);
        else kept = image.clone();
        frames_.push_back(kept);
        times_.push_back(frame / fps);
    }
    if (!frames_.empty())
        blocks_ = std::min(maxBlocks, std::max(1, cvRound((times_.back() - times_.front()) / blockTime)));
}

// The templates of all tools as the readings of a time say they look: times of the readings are expected + cell * step.
// Returns false without readings.
bool TimeOffsetEstimator::drawn(int cell, std::vector<std::vector<PartTemplate> >& templates)
{
    templates.resize(tools_.size());
    std::vector<ToolView> views(tools_.size());
    for (size_t i = 0; i < tools_.size(); i++)
    {
        std::vector<double> joints;
        if (!sequence_.jointsAt(int(i), params_.expected + cell * step_, joints, tools_[i].coordinates)) return false;
        tools_[i].model->forwardKinematics(joints, views[i].base_T_link);
        views[i].camera_T_base = tools_[i].nominal_T_base;
    }
    for (size_t i = 0; i < tools_.size(); i++) coarseRenderer_->render(camera_, views, int(i), templates[i]);
    return true;
}

// Matches and verifies in the image set. Windows: halfWidth [pixel] or, if that is 0, a shift on the tool [m].
void TimeOffsetEstimator::locate(const std::vector<PartTemplate>& templates, double halfWidth, double shift, std::vector<PartMatch>& inliers)
{
    const Rect all(Point(), camera_.imageSize());
    std::vector<Rect> windows;
    std::vector<PartTemplate> wanted;
    for (size_t i = 0; i < templates.size(); i++)
    {
        const PartTemplate& t = templates[i];
        const int h = cvRound(halfWidth > 0 ? halfWidth : shift * std::max(camera_.fx, camera_.fy) / std::max(t.viewPoint.z, 0.02));
        const Rect window = Rect(t.anchor.x - h, t.anchor.y - h, 2 * h + 1, 2 * h + 1) & all;
        if (window.empty()) continue;
        windows.push_back(window);
        wanted.push_back(t);
    }
    inliers.clear();
    if (wanted.empty()) return;
    std::vector<PartMatch> matches;
    matcher_->match(wanted, windows, matches);
    verifier_->verify(matches, inliers);
}

// Every frame with the readings of every time within the range.
void TimeOffsetEstimator::searchAll()
{
    for (size_t f = 0; f < frames_.size(); f++)
    {
        const int at = cvRound(times_[f] / step_);
        matcher_->setImage(frames_[f]);
        templates_.erase(templates_.begin(), templates_.lower_bound(at - reach_));
        for (int cell = -reach_; cell <= reach_; cell++)
        {
            std::map<int, std::vector<std::vector<PartTemplate> > >::iterator it = templates_.find(at + cell);
            if (it == templates_.end())
            {
                it = templates_.insert(std::make_pair(at + cell, std::vector<std::vector<PartTemplate> >())).first;
                if (!drawn(at + cell, it->second)) it->second.clear();
            }
            if (it->second.empty()) continue;
            frameCounts_[cell + reach_]++;
            for (size_t i = 0; i < tools_.size(); i++)
            {
                OffsetDetection d;
                locate(it->second[i], 0, searchShift, d.inliers);
                counts_[cell + reach_]++;
                if (d.inliers.empty()) continue;
                d.tool = int(i);
                d.cell = cell;
                d.frame = f;
                d.score = scoreOf(d.inliers);
                sums_[cell + reach_] += d.score;
                detections_.push_back(d);
            }
        }
    }
}

// Mean score, less what a few lucky frames are worth; 0 if too little overlaps.
double TimeOffsetEstimator::coarseScore(int cell) const
{
    if (std::abs(cell) > reach_) return 0;
    if (frameCounts_[cell + reach_] < minOffsetFrames || overlapOf(cell) < params_.minOverlap) return 0;
    return sums_[cell + reach_] / (counts_[cell + reach_] + luckyFrames);
}

// The best maxima of the coarse scores.
std::vector<int> TimeOffsetEstimator::peaks() const
{
    std::vector<std::pair<double, int> > sorted;
    for (int cell = -reach_; cell <= reach_; cell++)
    {
        const double score = coarseScore(cell);
        if (score > 0 && score >= coarseScore(cell - 1) && score >= coarseScore(cell + 1)) sorted.push_back(std::make_pair(-score, cell));
    }
    std::sort(sorted.begin(), sorted.end());
    std::vector<int> result;
    for (size_t i = 0; i < sorted.size() && int(result.size()) < maxCandidates; i++)
    {
        bool apart = true;
        for (size_t k = 0; k < result.size(); k++) apart = apart && std::abs(result[k] - sorted[i].second) > 2;
        if (apart) result.push_back(sorted[i].second);
    }
    return result;
}

}} // namespace cv::surgtrack
