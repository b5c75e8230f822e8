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
        first = std::min(first, sequence_.firstTime(tools_[i].index));
        last = std::max(last, sequence_.lastTime(tools_[i].index));
    }
    const double span = (reach_ + 1) * step_, fps = sequence_.fps();
    const int begin = int(std::min(double(total), std::max(0., (first - params_.expected - span) * fps)));
    const int end = int(std::max(0., std::min(double(total), (last - params_.expected + span) * fps + 1)));
    const int cell = stride_;
    stride_ = cell * std::max(1, (end - begin + cell * params_.frames - 1) / (cell * params_.frames));
    const Size size = sequence_.frameSize();
    Mat read, image;
    for (int frame = 0; frame < end && video.grab(); frame++)
    {
        if (frame < begin || frame % stride_ != 0) continue;
        if (!video.retrieve(read)) break;
        if (read.size() != size)
            CV_Error(Error::StsUnmatchedSizes, format("%s: frame %d has %dx%d pixels, expected %dx%d as in sequence.yaml", filename.c_str(),
                                                      frame, read.cols, read.rows, size.width, size.height));
        sequence_.eyeImage(read, image);
        Mat kept;
        if (image.size() != camera_.imageSize()) resize(image, kept, camera_.imageSize(), 0, 0, INTER_AREA);
        else kept = image.clone();
        frames_.push_back(kept);
        times_.push_back(sequence_.frameTime(frame));
    }
    if (!frames_.empty())
        blocks_ = std::min(maxBlocks, std::max(1, cvRound((times_.back() - times_.front()) / blockTime)));
}

// All tools as the readings of a time say they look: times of the readings are expected + cell * step. Returns false without readings.
bool TimeOffsetEstimator::drawn(int cell, std::vector<PartDrawing>& drawings)
{
    drawings.resize(tools_.size());
    std::vector<ToolView> views(tools_.size());
    for (size_t i = 0; i < tools_.size(); i++)
    {
        std::vector<double> joints;
        if (!sequence_.jointsAt(tools_[i].index, params_.expected + cell * step_, joints, tools_[i].coordinates)) return false;
        tools_[i].model->forwardKinematics(joints, views[i].base_T_link);
        views[i].camera_T_base = tools_[i].nominal_T_base;
    }
    for (size_t i = 0; i < tools_.size(); i++)
    {
        coarse_->draw(views, int(i), drawings[i]);
        drawings[i].rendering = Rendering();   // many are kept, and only templates are needed
    }
    return true;
}

// Windows for a shift on the tool [m].
static PartWindows windowsFor(const PartDrawing& drawing, const CameraModel& camera, int parts, double shift)
{
    PartWindows windows(DBL_MAX);
    windows.deviations.resize(parts);
    for (size_t i = 0; i < drawing.templates.size(); i++)
    {
        const PartTemplate& t = drawing.templates[i];
        const double half = cvRound(shift * std::max(camera.fx, camera.fy) / std::max(t.viewPoint.z, 0.02));
        windows.deviations[t.part] = Point2d(half, half) / 3;
        windows.halfWidth = std::min(windows.halfWidth, half);
    }
    return windows;
}

// Every frame with the readings of every time within the range.
void TimeOffsetEstimator::searchAll()
{
    FoundParts found;
    for (size_t f = 0; f < frames_.size(); f++)
    {
        const int at = cvRound(times_[f] / step_);
        coarse_->setImage(frames_[f]);
        coarse_->prepare();
        drawings_.erase(drawings_.begin(), drawings_.lower_bound(at - reach_));
        for (int cell = -reach_; cell <= reach_; cell++)
        {
            std::map<int, std::vector<PartDrawing> >::iterator it = drawings_.find(at + cell);
            if (it == drawings_.end())
            {
                it = drawings_.insert(std::make_pair(at + cell, std::vector<PartDrawing>())).first;
                if (!drawn(at + cell, it->second)) it->second.clear();
            }
            if (it->second.empty()) continue;
            frameCounts_[cell + reach_]++;
            for (size_t i = 0; i < tools_.size(); i++)
            {
                const PartDrawing& drawing = it->second[i];
                counts_[cell + reach_]++;
                coarse_->find(drawing, windowsFor(drawing, camera_, int(tools_[i].model->keypoints().size()), searchShift), *verifier_, found);
                if (found.inliers.empty()) continue;
                OffsetDetection d;
                d.tool = int(i);
                d.cell = cell;
                d.frame = f;
                d.inliers = found.inliers;
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
