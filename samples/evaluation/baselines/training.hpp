// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// What a baseline learns from: sequences with truth, none of whose videos is tested.

#ifndef OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_TRAINING_HPP
#define OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_TRAINING_HPP

#include "../files.hpp"
#include "../true_parts.hpp"
#include "../../support/frame_reader.hpp"

namespace evaluation {

//! Keypoints of the same name on two sides are one class: a classifier does not know the side.
inline String className(const String& keypoint)
{
    const size_t end = keypoint.size() > 5 ? keypoint.size() - 5 : 0;
    return keypoint.compare(end, 5, "_flat") == 0 || keypoint.compare(end, 5, "_deep") == 0 ? keypoint.substr(0, end) : keypoint;
}

//! The videos of a sequence: canonical path and contents of each. None if it can't be read: evaluating it will tell.
inline std::vector<std::pair<String, String> > videosOf(const String& folder)
{
    static std::map<String, std::vector<std::pair<String, String> > > known;   // a video is long to read
    if (known.count(folder))
        return known[folder];
    std::vector<std::pair<String, String> > videos;
    try
    {
        const Ptr<Sequence> sequence = Sequence::load(folder);
        const String files[] = { sequence->leftVideo(), sequence->rightVideo() };
        for (int i = 0; i < 2; i++)
            if (!files[i].empty() && utils::fs::exists(files[i]))
            {
                Fingerprint print;
                print.addFile(files[i]);
                videos.push_back(std::make_pair(absolutePath(files[i]), print.text()));
            }
    }
    catch (const Exception&)
    {
    }
    return known[folder] = videos;
}

//! Whether two sequences have a video in common.
inline bool shareVideo(const String& one, const String& other)
{
    const std::vector<std::pair<String, String> > ours = videosOf(one), theirs = videosOf(other);
    for (size_t a = 0; a < ours.size(); a++)
        for (size_t b = 0; b < theirs.size(); b++)
            if (ours[a].first == theirs[b].first || ours[a].second == theirs[b].second)
                return true;
    return false;
}

//! Refuses to learn from what is tested. @throws cv::Exception naming both
inline void checkLeaks(const std::vector<String>& training, const std::vector<String>& tested)
{
    for (size_t i = 0; i < training.size(); i++)
        for (size_t j = 0; j < tested.size(); j++)
            if (shareVideo(training[i], tested[j]))
                fail("argument '--train': " + training[i] + " has a video of " + tested[j] +
                     ", which is tested; expected others, or --leave-out");
}

//! The classes of all tools of a sequence, in the order of their files.
inline std::vector<String> classNames(const Data& data)
{
    std::vector<String> classes;
    for (size_t i = 0; i < data.tools.size(); i++)
    {
        const std::vector<String> names = data.tools[i].model->keypointNames();
        for (size_t j = 0; j < names.size(); j++)
            if (std::find(classes.begin(), classes.end(), className(names[j])) == classes.end())
                classes.push_back(className(names[j]));
    }
    return classes;
}

//! Parts in an image: names of their classes, and points.
typedef std::vector<std::pair<String, Point2d> > ClassPoints;

//! The parts of all tools that can be seen in the frame read last.
inline ClassPoints pointsOf(const Data& data, TrueParts& parts)
{
    ClassPoints points;
    for (int tool = 0; tool < (int)data.tools.size(); tool++)
    {
        const std::vector<String> names = data.tools[tool].model->keypointNames();
        const std::map<int, Point2d> visible = parts.visible(tool);
        for (std::map<int, Point2d>::const_iterator it = visible.begin(); it != visible.end(); ++it)
            points.push_back(std::make_pair(className(names[it->first]), it->second));
    }
    return points;
}

//! Those of one class.
inline ClassPoints pointsOf(const ClassPoints& points, const String& name)
{
    ClassPoints own;
    for (size_t i = 0; i < points.size(); i++)
        if (points[i].first == name)
            own.push_back(points[i]);
    return own;
}

//! A place in an image to learn from.
struct Place
{
    Point2d point;
    int cls;   //!< 0: background
};

//! Sequences to learn from.
class Training
{
public:
    explicit Training(const std::vector<String>& folders)
    {
        Fingerprint print;
        for (size_t i = 0; i < folders.size(); i++)
        {
            data_.push_back(makePtr<Data>());
            data_.back()->load(folders[i]);
            addSequence(print, folders[i]);
        }
        print_ = print.text();
    }
    const String& print() const { return print_; }
    std::vector<String> classes() const { return classNames(*data_[0]); }

    /** Shows every so many frames with truth of all sequences.
    @param visit called with the reduced image, and the visible keypoints: names of their classes and points */
    template <class Visit> void frames(int step, const Visit& visit) const
    {
        scenes(step, [&](const Data& data, TrueParts& parts, const Mat& image) { visit(image, pointsOf(data, parts)); });
    }
    //! @param visit called with the sequence, the truth of the frame, and the reduced image
    template <class Visit> void scenes(int step, const Visit& visit) const
    {
        for (size_t i = 0; i < data_.size(); i++)
        {
            TrueParts parts(*data_[i]);
            common::FrameReader reader(*data_[i]->sequence, 0);
            Mat image;
            const int end = data_[i]->sequence->groundTruthEnd();
            for (int frame = 0; frame < end && reader.read(image); frame++)
            {
                if (frame % step || !parts.read(frame))
                    continue;
                parts.finder().setImage(image);
                visit(*data_[i], parts, parts.finder().pixels(Rect(Point(), parts.finder().camera().imageSize())));
                parts.finder().release();
            }
        }
    }

private:
    std::vector<Ptr<Data> > data_;
    String print_;
};

//! Distance of a point from the nearest keypoint of any class.
inline double nearestOf(const ClassPoints& points, const Point2d& p)
{
    double nearest = DBL_MAX;
    for (size_t i = 0; i < points.size(); i++)
        nearest = std::min(nearest, norm(points[i].second - p));
    return nearest;
}

//! Chooses places to learn from.
class PlaceChooser
{
public:
    enum { ANYWHERE = 15, AT_TOOL = 25, NEAR = 70, CLEAR = 12 };   // [pixel]

    /** @param training where from
    @param classes names of the parts wanted, 1 and on
    @param wanted places a class */
    PlaceChooser(const Training& training, const std::vector<String>& classes, int wanted) : classes_(classes), copies_(classes.size(), 0.), rng_(20140914)
    {
        training.frames(1, [&](const Mat&, const ClassPoints& points) {
            for (size_t i = 0; i < points.size(); i++)
                if (const int cls = classOf(points[i].first))
                    copies_[cls - 1]++;
        });
        for (size_t i = 0; i < copies_.size(); i++)
        {
            if (copies_[i] == 0)
                fail("argument '--train': no frame shows part '" + classes_[i] + "', expected some of each");
            copies_[i] = wanted / copies_[i];
        }
    }

    int classOf(const String& name) const
    {
        const size_t index = std::find(classes_.begin(), classes_.end(), name) - classes_.begin();
        return index < classes_.size() ? (int)index + 1 : 0;
    }

    std::vector<Place> choose(const Size& size, const ClassPoints& points)
    {
        std::vector<Place> places;
        for (size_t i = 0; i < points.size(); i++)
        {
            const int cls = classOf(points[i].first);
            const double copies = cls ? copies_[cls - 1] : 0;
            for (int j = 0; j < int(copies + rng_.uniform(0., 1.)); j++)
                add(places, size, points[i].second + (j == 0 ? Point2d() : Point2d(rng_.uniform(-2., 2.), rng_.uniform(-2., 2.))), cls);
        }
        for (int i = 0; i < ANYWHERE + AT_TOOL; i++)
        {
            Point2d p(rng_.uniform(0., size.width - 1.), rng_.uniform(0., size.height - 1.));
            if (i >= ANYWHERE && !points.empty())
                p = points[rng_.uniform(0, (int)points.size())].second + Point2d(rng_.uniform(-double(NEAR), double(NEAR)), rng_.uniform(-double(NEAR), double(NEAR)));
            if (nearestOf(points, p) >= CLEAR)
                add(places, size, p, 0);
        }
        return places;
    }

private:
    static void add(std::vector<Place>& places, const Size& size, const Point2d& p, int cls)
    {
        const Place place = { p, cls };
        if (p.x >= 0 && p.y >= 0 && p.x <= size.width - 1 && p.y <= size.height - 1)
            places.push_back(place);
    }

    std::vector<String> classes_;
    std::vector<double> copies_;
    RNG rng_;
};

} // namespace evaluation

#endif
