// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// How often detectors find the same classes of parts, counted in the same way (paper, Fig. 3 a and b).

#ifndef OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_RUN_HPP
#define OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_RUN_HPP

#include <functional>
#include "../detection.hpp"
#include "detectors.hpp"

namespace evaluation {

//! What is looked for once: a class, of which at least one part can be seen.
struct ClassSample
{
    int tool;             //!< -1: any
    int part;             //!< in the list of classes
    Rect window;          //!< empty: the image
    ClassPoints truth;    //!< of this class and tool
};

/** @brief Counts for any detector: in the whole image, a class once a frame; and in windows of +-120 px about where recorded joints and
hand-eye have it, once a tool. A hit: a visible keypoint of the class is near. */
class ClassRun
{
public:
    typedef std::function<void(const ClassSample&, std::vector<PartMatch>&)> Detect;
    enum { IMAGE = 0, WINDOW = 1 };

    ClassRun(const Data& data, const std::vector<String>& classes) : data_(data), classes_(classes), truths_(data), finder_(truths_.finder())
    {
        verifier_ = GeometricContextVerifier::create();
        addCounts("qgo", classes, IMAGE);
        addCounts("qgo", classes, WINDOW);
    }

    //! @param variant IMAGE or WINDOW
    void add(PartDetector& detector, int variant)
    {
        if (detectors_.empty() || detectors_.back() != &detector)
            detectors_.push_back(&detector);
        counted_.push_back(Counted(&detector, variant, (int)counts_.size()));
        addCounts(detector.name(), detector.classes(), variant);
    }

    //! @param frames at most so many; 0 = all. Of a long sequence every k-th is looked at
    const std::vector<ClassCounts>& run(int frames, bool quiet)
    {
        common::FrameReader reader(*data_.sequence, 0);
        const int count = frames > 0 ? std::min(frames, reader.count()) : reader.count();
        const int step = 1 + (std::max(count, 1) - 1) / MAX_DETECTION_FRAMES;
        common::Progress progress(count, quiet);
        Mat image;
        for (int frame = 0; (frames == 0 || frame < frames) && reader.read(image); frame++)
        {
            if (frame % step || !truths_.read(frame))
                continue;
            finder_.setImage(image);
            place(frame);
            lookForTemplates();
            const Mat pixels = finder_.pixels(Rect(Point(), finder_.camera().imageSize()));
            for (size_t i = 0; i < detectors_.size(); i++)
                if (detectors_[i]->name() != "forest" || frame / step % 4 == 0)   // it is slow
                    lookWith(*detectors_[i], pixels);
            finder_.release();
            progress.show(frame + 1);
        }
        return counts_;
    }

private:
    struct Counted
    {
        PartDetector* detector;
        int variant, counts;
        Counted(PartDetector* newDetector, int newVariant, int newCounts) : detector(newDetector), variant(newVariant), counts(newCounts) {}
    };
    struct Timer
    {
        explicit Timer(ClassCounts& counts) : counts_(counts), start_(getTickCount()) {}
        ~Timer() { counts_.seconds += double(getTickCount() - start_) / getTickFrequency(); }
        ClassCounts& counts_;
        int64 start_;
    };

    void addCounts(const String& detector, const std::vector<String>& classes, int variant)
    {
        ClassCounts counts;
        counts.detector = detector;
        counts.variant = variant == IMAGE ? "image" : "window";
        counts.parts = classes;
        counts.counts.resize(classes.size());
        counts_.push_back(counts);
    }

    //! Where the kinematics have the tools, and what can be seen of them.
    void place(int frame)
    {
        data_.joints(frame, joints_);
        views_.resize(data_.tools.size());
        seen_.clear();
        expected_.clear();
        for (int tool = 0; tool < (int)data_.tools.size(); tool++)
        {
            const Ptr<ToolModel>& model = data_.tools[tool].model;
            views_[tool].camera_T_base = data_.tools[tool].info.nominal_T_base;
            model->forwardKinematics(joints_[tool], views_[tool].base_T_link);
            Mat basePoints;
            model->keypointPositions(joints_[tool], basePoints);
            const std::vector<String> names = model->keypointNames();
            const std::map<int, Point2d> visible = truths_.visible(tool);
            seen_.push_back(ClassPoints());
            expected_.push_back(std::vector<Point2d>());
            for (std::map<int, Point2d>::const_iterator it = visible.begin(); it != visible.end(); ++it)
            {
                const double* const p = basePoints.ptr<double>(it->first);
                const Vec4d q = views_[tool].camera_T_base * Vec4d(p[0], p[1], p[2], 1);
                seen_[tool].push_back(std::make_pair(className(names[it->first]), it->second));
                expected_[tool].push_back(q[2] > 1e-3 ? finder_.camera().project(Point3d(q[0], q[1], q[2])) : it->second);
            }
        }
    }

    std::vector<ClassSample> samples(const std::vector<String>& classes, int variant) const
    {
        std::vector<ClassSample> result;
        const int half = cvRound(120 * finder_.pixelScale());
        for (int part = 0; part < (int)classes.size(); part++)
            for (int tool = variant == IMAGE ? -1 : 0; tool < (variant == IMAGE ? 0 : (int)seen_.size()); tool++)
            {
                ClassSample sample = { tool, part, Rect(), ClassPoints() };
                for (int i = 0; i < (int)seen_.size(); i++)
                    for (size_t j = 0; j < seen_[i].size() && (tool < 0 || tool == i); j++)
                        if (seen_[i][j].first == classes[part])
                        {
                            sample.truth.push_back(seen_[i][j]);
                            const Point p(expected_[i][j]);
                            if (tool >= 0)
                                sample.window |= Rect(p.x - half, p.y - half, 2 * half + 1, 2 * half + 1);
                        }
                if (!sample.truth.empty())
                    result.push_back(sample);
            }
        return result;
    }

    void count(ClassCounts& counts, int variant, const Detect& detect)
    {
        const std::vector<ClassSample> wanted = samples(counts.parts, variant);
        std::vector<PartMatch> matches;
        for (size_t i = 0; i < wanted.size(); i++)
        {
            {
                Timer timer(counts);
                detect(wanted[i], matches);
            }
            std::vector<double> distances;
            for (size_t j = 0; j < matches.size(); j++)
                distances.push_back(nearestOf(wanted[i].truth, matches[j].imagePoint) / finder_.pixelScale());
            DetectionCount& ofPart = counts.counts[wanted[i].part];
            ofPart.visible++;
            ofPart.samples++;
            ofPart.prior = unknown();
            ofPart.addHits(distances);
        }
        counts.images++;
    }

    void lookWith(PartDetector& detector, const Mat& pixels)
    {
        for (size_t i = 0; i < counted_.size(); i++)
        {
            if (counted_[i].detector != &detector)
                continue;
            ClassCounts& counts = counts_[counted_[i].counts];
            {
                Timer timer(counts);
                detector.setImage(pixels);   // nothing is kept of the variant before: times are comparable
            }
            count(counts, counted_[i].variant, [&](const ClassSample& sample, std::vector<PartMatch>& matches) {
                matches.clear();
                if (sample.window.empty() || !(sample.window & Rect(Point(), pixels.size())).empty())
                    detector.detect(sample.window, sample.part + 1, MAX_TOP_N, matches);
            });
        }
    }

    //! Ours: templates drawn where the kinematics have the tools.
    void lookForTemplates()
    {
        for (int variant = IMAGE; variant <= WINDOW; variant++)
        {
            std::vector<PartDrawing> drawings(views_.size());
            std::vector<FoundParts> found(views_.size());
            {
                Timer timer(counts_[variant]);
                for (int tool = 0; tool < (int)views_.size(); tool++)
                {
                    finder_.draw(views_, tool, drawings[tool]);
                    finder_.find(drawings[tool], PartWindows(variant == IMAGE ? 1e4 : 120 * finder_.pixelScale()), *verifier_, found[tool]);
                }
            }
            count(counts_[variant], variant, [&](const ClassSample& sample, std::vector<PartMatch>& matches) {
                matches.clear();
                for (int tool = 0; tool < (int)found.size(); tool++)
                {
                    const std::vector<String> names = data_.tools[tool].model->keypointNames();
                    for (size_t i = 0; i < found[tool].matches.size() && (sample.tool < 0 || sample.tool == tool); i++)
                        if (className(names[found[tool].matches[i].part]) == classes_[sample.part])
                            matches.push_back(found[tool].matches[i]);
                }
                suppress(matches, 1, MAX_TOP_N);   // those of a template are apart already
            });
        }
    }

    const Data& data_;
    std::vector<String> classes_;
    TrueParts truths_;
    PartFinder& finder_;
    Ptr<GeometricContextVerifier> verifier_;
    std::vector<PartDetector*> detectors_;
    std::vector<Counted> counted_;
    std::vector<ClassCounts> counts_;
    std::vector<std::vector<double> > joints_;
    std::vector<ToolView> views_;
    std::vector<ClassPoints> seen_;                    // a tool
    std::vector<std::vector<Point2d> > expected_;      // where the kinematics have what is seen
};

} // namespace evaluation

#endif
