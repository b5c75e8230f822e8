// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// How often QGO matching finds the parts of a tool (paper, Fig. 3 a and b).

#ifndef OPENCV_SURGTRACK_SAMPLES_EVALUATION_DETECTION_HPP
#define OPENCV_SURGTRACK_SAMPLES_EVALUATION_DETECTION_HPP

#include "opencv2/imgproc.hpp"
#include "true_parts.hpp"
#include "../support/frame_reader.hpp"

namespace evaluation {

enum { MAX_TOP_N = 5, THRESHOLDS = 3, VARIANTS = 2, MAX_DETECTION_FRAMES = 300 };

inline int thresholdPixels(int index)   // of an image 720 pixel wide
{
    static const int pixels[] = { 5, 10, 20 };
    return pixels[index];
}

inline const char* variantName(int variant) { return variant == 0 ? "raw" : "tracked"; }

//! Counts of one part.
struct DetectionCount
{
    int visible;     //!< keypoints that could be seen
    int samples;     //!< of these, with a template
    int hits[THRESHOLDS][MAX_TOP_N];
    double prior;    //!< sum of the distances of the template from the keypoint, over the samples [pixel at 720 px width]

    DetectionCount() : visible(0), samples(0), prior(0) { std::memset(hits, 0, sizeof(hits)); }

    void add(const DetectionCount& other)
    {
        visible += other.visible;
        samples += other.samples;
        prior += other.prior;
        for (int i = 0; i < THRESHOLDS; i++)
            for (int n = 0; n < MAX_TOP_N; n++)
                hits[i][n] += other.hits[i][n];
    }
    //! @param distances of the candidates, best first [pixel at 720 px width]; with fewer than N there is no more to offer
    void addHits(const std::vector<double>& distances)
    {
        double nearest = DBL_MAX;
        for (size_t n = 0; n < MAX_TOP_N; n++)
        {
            if (n < distances.size())
                nearest = std::min(nearest, distances[n]);
            for (int k = 0; k < THRESHOLDS; k++)
                hits[k][n] += nearest <= thresholdPixels(k);
        }
    }
    double rate(int threshold, int topN) const { return samples ? double(hits[threshold][topN]) / samples : unknown(); }
};

struct Detection
{
    std::vector<String> parts;                       //!< names of keypoints, those of the same name together
    std::vector<DetectionCount> counts[VARIANTS];    //!< a part

    DetectionCount& at(int variant, const String& part)
    {
        const size_t index = std::find(parts.begin(), parts.end(), part) - parts.begin();
        if (index == parts.size())
        {
            parts.push_back(part);
            for (int i = 0; i < VARIANTS; i++)
                counts[i].push_back(DetectionCount());
        }
        return counts[variant][index];
    }
    void add(const Detection& other)
    {
        for (int i = 0; i < VARIANTS; i++)
            for (size_t j = 0; j < other.parts.size(); j++)
                at(i, other.parts[j]).add(other.counts[i][j]);
    }
    DetectionCount all(int variant) const
    {
        DetectionCount sum;
        for (size_t i = 0; i < counts[variant].size(); i++)
            sum.add(counts[variant][i]);
        return sum;
    }
};

//! How often classes of parts, keypoints whatever their side, are found: what detectors that know no sides are compared by.
struct ClassCounts
{
    String detector, variant;    //!< qgo, gradboost or forest; image or window
    std::vector<String> parts;
    std::vector<DetectionCount> counts;
    int images;
    double seconds;              //!< in the detector
    ClassCounts() : images(0), seconds(0) {}

    void add(const ClassCounts& other)
    {
        for (size_t i = 0; i < other.counts.size(); i++)
            counts[i].add(other.counts[i]);
        images += other.images;
        seconds += other.seconds;
    }
    DetectionCount all() const
    {
        DetectionCount sum;
        for (size_t i = 0; i < counts.size(); i++)
            sum.add(counts[i]);
        return sum;
    }
};

/** @brief Draws templates, searches them as the tracker does, and compares with the true image points.

Two variants. `raw`: at the pose of the recorded kinematics with the raw hand-eye calibration, windows of +-120 px. `tracked`: at the
recorded joints with the true correction of the end effector, turned and moved by random amounts that put keypoints some 13 px off,
windows of +-40 px. Pixels are those of an image 720 px wide; larger images are reduced by a whole number, as the tracker does.
True points: see TrueParts. */
class DetectionRun
{
public:
    explicit DetectionRun(const Data& data) : data_(data), rng_(20160605), truths_(data), finder_(truths_.finder())
    {
        camera_ = finder_.camera();
        pixel_ = finder_.pixelScale();
        for (size_t i = 0; i < data.tools.size(); i++)
        {
            const std::vector<String> names = data.tools[i].model->keypointNames();
            for (size_t j = 0; j < names.size(); j++)
                detection_.at(0, names[j]);   // in the order of the tool file, whatever is seen first
        }
        verifier_ = GeometricContextVerifier::create();
    }

    //! @param frames at most so many; 0 = all. Of a long sequence every k-th is looked at
    const Detection& run(int frames, bool quiet)
    {
        common::FrameReader reader(*data_.sequence, 0);
        const int count = frames > 0 ? std::min(frames, reader.count()) : reader.count();
        const int step = 1 + (std::max(count, 1) - 1) / MAX_DETECTION_FRAMES;
        common::Progress progress(count, quiet);
        Mat image;
        for (int frame = 0; frames == 0 || frame < frames; frame++)
        {
            if (!reader.read(image))
                break;   // the tracker's run tells if it should have gone on
            if (frame % step)
                continue;
            finder_.setImage(image);
            finder_.prepare();
            look(frame);
            progress.show(frame + 1);
        }
        return detection_;
    }

private:
    void place(const std::vector<Matx44d>& camera_T_base)
    {
        views_.resize(data_.tools.size());
        for (size_t i = 0; i < data_.tools.size(); i++)
        {
            views_[i].camera_T_base = camera_T_base[i];
            data_.tools[i].model->forwardKinematics(joints_[i], views_[i].base_T_link);
        }
    }

    // A pose that is off as that of a tracker at a bad moment.
    Matx44d perturbed(const Matx44d& camera_T_tool)
    {
        const double degrees = 1.5, pixels = 12, depth = 0.002;   // turning adds to the pixels
        Vec3d turn;
        for (int i = 0; i < 3; i++)
            turn[i] = rng_.gaussian(degrees * CV_PI / 180);
        const double direction = rng_.uniform(0., 2 * CV_PI), away = rng_.gaussian(depth);
        const Vec3d t = translationOf(camera_T_tool);
        const double side = pixels * pixel_ * t[2];
        const Vec3d shift(side * std::cos(direction) / camera_.fx, side * std::sin(direction) / camera_.fy, away);
        return rigid(rotationFromVector(turn) * rotationOf(camera_T_tool), t + shift);
    }

    void look(int frame)
    {
        data_.joints(frame, joints_);
        if (!truths_.read(frame))
            return;
        std::vector<Matx44d> bases[VARIANTS];
        for (int i = 0; i < (int)data_.tools.size(); i++)
        {
            bases[0].push_back(data_.tools[i].info.nominal_T_base);
            bases[1].push_back(data_.camera_T_base(i, perturbed(truths_.truth(i).camera_T_tool), joints_[i]));
        }
        for (int tool = 0; tool < (int)data_.tools.size(); tool++)
        {
            const std::map<int, Point2d> visible = truths_.visible(tool);
            for (int variant = 0; variant < VARIANTS; variant++)
            {
                place(bases[variant]);
                finder_.draw(views_, tool, drawing_);
                search(variant, data_.tools[tool].model->keypoints(), visible);
            }
        }
    }

    void search(int variant, const std::vector<ToolModel::Keypoint>& keypoints, const std::map<int, Point2d>& visible)
    {
        finder_.find(drawing_, PartWindows(cvRound((variant == 0 ? 120 : 40) * pixel_)), *verifier_, found_);
        const std::vector<PartTemplate>& templates = drawing_.templates;
        const std::vector<PartMatch>& matches = found_.matches;
        for (std::map<int, Point2d>::const_iterator it = visible.begin(); it != visible.end(); ++it)
            detection_.at(variant, keypoints[it->first].name).visible++;
        for (size_t i = 0; i < templates.size(); i++)
        {
            const std::map<int, Point2d>::const_iterator truth = visible.find(templates[i].part);
            if (truth == visible.end())
                continue;
            DetectionCount& count = detection_.at(variant, keypoints[truth->first].name);
            count.samples++;
            count.prior += norm(templates[i].imagePoint - truth->second) / pixel_;
            std::vector<double> distances;
            for (size_t j = 0; j < matches.size(); j++)
                if (matches[j].templateIndex == (int)i)
                    distances.push_back(norm(matches[j].imagePoint - truth->second) / pixel_);
            count.addHits(distances);
        }
    }

    const Data& data_;
    RNG rng_;
    double pixel_;   // of an image 720 pixel wide, in pixels of ours
    CameraModel camera_;
    TrueParts truths_;
    PartFinder& finder_;
    Ptr<GeometricContextVerifier> verifier_;
    std::vector<std::vector<double> > joints_;
    std::vector<ToolView> views_;
    PartDrawing drawing_;
    FoundParts found_;
    Detection detection_;
};

} // namespace evaluation

#endif
