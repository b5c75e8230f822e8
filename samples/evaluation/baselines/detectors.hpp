// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// What the baselines' detectors have in common.

#ifndef OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_DETECTORS_HPP
#define OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_DETECTORS_HPP

#include "training.hpp"

namespace evaluation {

//! Finds parts of classes 1 and on in an image; 0 is the background.
struct PartDetector
{
    virtual ~PartDetector() {}
    virtual String name() const = 0;
    virtual const std::vector<String>& classes() const = 0;   //!< names of the classes 1 and on
    virtual String constants() const = 0;                     //!< what else makes another model
    //! @param image CV_8UC1 or CV_8UC3; must stay
    virtual void setImage(const Mat& image) = 0;
    //! @param window empty: the image @param cls 1 and on @param matches at most count, by falling score
    virtual void detect(const Rect& window, int cls, int count, std::vector<PartMatch>& matches) = 0;
    virtual void train(const Training& training, bool quiet) = 0;
    virtual void write(FileStorage& file) const = 0;
    virtual bool read(const FileNode& node) = 0;              //!< whether it was all there
    int classCount() const { return (int)classes().size() + 1; }
};

//! The best of many, none nearer to another than a radius [pixel]. @param matches sorted by falling score when done
inline void suppress(std::vector<PartMatch>& matches, double radius, int count)
{
    std::stable_sort(matches.begin(), matches.end(), [](const PartMatch& a, const PartMatch& b) { return a.similarity > b.similarity; });
    std::vector<PartMatch> kept;
    for (size_t i = 0; i < matches.size() && (int)kept.size() < count; i++)
    {
        bool free = true;
        for (size_t j = 0; j < kept.size(); j++)
            free = free && norm(kept[j].imagePoint - matches[i].imagePoint) >= radius;
        if (free)
            kept.push_back(matches[i]);
    }
    matches.swap(kept);
}

inline PartMatch matchAt(const Point2d& point, int cls, double score)
{
    PartMatch match;
    match.tool = 0;
    match.part = cls;
    match.imagePoint = match.predictedPoint = point;
    match.similarity = score;
    match.templateIndex = 0;
    return match;
}

enum { SUPPRESSION = 12 };   // [pixel]

//! Learns a model, or reads it if the same one was learnt before. @param detector or something else that learns @param folder of models
template <class Learner> void prepare(Learner& detector, const Training& training, const String& folder, bool quiet)
{
    Fingerprint print;
    print.add(detector.constants() + training.print());
    const String filename = utils::fs::join(folder, detector.name() + "-" + print.text() + ".yml.gz");
    if (utils::fs::exists(filename))
    {
        const FileStorage file(filename, FileStorage::READ);
        if (!detector.read(file.root()))
            fail(filename + ": is no model of " + detector.name() + ", delete it to have it learnt anew");
        return;
    }
    const int64 start = getTickCount();
    detector.train(training, quiet);
    if (!quiet)
        std::fprintf(stderr, "%s: learnt in %.0f s\n", detector.name().c_str(), double(getTickCount() - start) / getTickFrequency());
    if (!utils::fs::createDirectories(folder))
        fail(folder + ": the folder can't be made");
    const String part = partOf(filename);   // other processes may look for it at any time
    FileStorage file(part, FileStorage::WRITE);
    if (!file.isOpened())
        fail(part + ": can't be written, expected a folder with room for it");
    detector.write(file);
    file.release();
    if (std::rename(part.c_str(), filename.c_str()) != 0)
        fail(filename + ": can't be written, expected a folder with room for it");
}

} // namespace evaluation

#endif
