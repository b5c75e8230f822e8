// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// The detector of Fig. 3 that the paper compares with (Sznitman et al. 2014), re-implemented from its description: gradient boosting at
// every pixel of the image, most of which are given up after a few rounds. Published: classes, 6000 places a class, early stopping. The
// constants that it leaves open are ours.

#ifndef OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_GRADBOOST_HPP
#define OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_GRADBOOST_HPP

#include "boosting.hpp"
#include "channels.hpp"
#include "detectors.hpp"

namespace evaluation {

class GradBoost : public PartDetector
{
public:
    //! @param early whether places are given up
    GradBoost(const std::vector<String>& parts, int rounds, bool early)
        : early_(early), roundCount_(rounds), classes_(parts), done_(false), looked_(0), places_(0)
    {
        features_ = ChannelFeature::random(1000, 20140915);
    }
    String name() const CV_OVERRIDE { return "gradboost"; }
    const std::vector<String>& classes() const CV_OVERRIDE { return classes_; }
    String constants() const CV_OVERRIDE
    {
        String text = format("gradboost 3, %d rounds", roundCount_);
        for (size_t i = 0; i < classes_.size(); i++)
            text += " " + classes_[i];
        return text;
    }
    int rounds() const { return boosting_.rounds(); }
    //! Rounds looked at, a place.
    double meanRounds() const { return places_ > 0 ? looked_ / places_ : 0; }

    void setImage(const Mat& image) CV_OVERRIDE
    {
        channels_.setImage(image);
        done_ = false;
    }

    //! Windows cost nothing: the whole image is scored once.
    void detect(const Rect& window, int cls, int count, std::vector<PartMatch>& matches) CV_OVERRIDE
    {
        if (!done_)
            score();
        matches.clear();
        const Mat& map = scores_[cls - 1];
        for (int y = 0; y < map.rows; y++)
            for (int x = 0; x < map.cols; x++)
            {
                const float value = map.at<float>(y, x);
                const Point2d point = Channels::pointOf(Point(x, y));
                const bool inside = window.empty() || window.contains(Point(point));
                if (value > -FLT_MAX && inside && isPeak(map, x, y))
                    matches.push_back(matchAt(point, cls, value));
            }
        suppress(matches, SUPPRESSION, count);
    }

    void train(const Training& training, bool quiet) CV_OVERRIDE
    {
        PlaceChooser chooser(training, classes_, 6000);
        Mat values;
        std::vector<int> labels;
        training.frames(1, [&](const Mat& image, const ClassPoints& points) {
            channels_.setImage(image);
            const std::vector<Place> places = chooser.choose(image.size(), points);
            for (size_t i = 0; i < places.size(); i++)
                add(Channels::placeOf(places[i].point), places[i].cls, values, labels);
        });
        learn(values, labels, quiet);
        const bool early = early_;
        early_ = true;   // the same model either way
        training.frames(6, [&](const Mat& image, const ClassPoints& points) {   // hard negatives
            setImage(image);
            for (int cls = 1; cls < classCount(); cls++)
            {
                std::vector<PartMatch> matches;
                detect(Rect(), cls, 6, matches);
                for (size_t i = 0; i < matches.size(); i++)
                    for (int copy = 0; copy < 2 && nearestOf(points, matches[i].imagePoint) >= PlaceChooser::CLEAR; copy++)
                        add(Channels::placeOf(matches[i].imagePoint), 0, values, labels);
            }
        });
        learn(values, labels, quiet);
        early_ = early;
        looked_ = places_ = 0;   // meanRounds() is of images that it did not learn from
    }
    void write(FileStorage& file) const CV_OVERRIDE { boosting_.write(file); }
    bool read(const FileNode& node) CV_OVERRIDE { return boosting_.read(node) && boosting_.classes() == classCount(); }

private:
    void add(const Point& place, int cls, Mat& values, std::vector<int>& labels) const
    {
        Mat row(1, (int)features_.size(), CV_16U);
        for (size_t f = 0; f < features_.size(); f++)
            row.at<ushort>(0, (int)f) = (ushort)features_[f].of(channels_, inside(place));
        values.push_back(row);
        labels.push_back(cls);
    }
    Point inside(const Point& p) const
    {
        const Size size = channels_.size();
        return Point(std::min(std::max(p.x, 0), size.width - 1), std::min(std::max(p.y, 0), size.height - 1));
    }
    void learn(const Mat& values, const std::vector<int>& labels, bool quiet)
    {
        if (!quiet)
            std::fprintf(stderr, "gradboost: learns from %d places\n", values.rows);
        Boosting::Params params;
        params.rounds = roundCount_;
        boosting_.train(values, labels, classCount(), params);
        done_ = false;
    }
    static bool isPeak(const Mat& map, int x, int y)
    {
        const float value = map.at<float>(y, x);
        for (int dy = -1; dy <= 1; dy++)
            for (int dx = -1; dx <= 1; dx++)
                if (y + dy >= 0 && y + dy < map.rows && x + dx >= 0 && x + dx < map.cols && map.at<float>(y + dy, x + dx) > value)
                    return false;
        return true;
    }
    //! Offsets of the corners of all features from a place.
    struct Corners
    {
        const int* base;   // of the channel, at pixel 0, 0
        int at[4];
    };
    void score()
    {
        std::vector<Corners> corners(features_.size());
        const int stride = channels_.stride();
        for (size_t f = 0; f < features_.size(); f++)
        {
            const Rect& r = features_[f].box;
            const int top = r.y * stride + r.x, bottom = top + r.height * stride;
            const Corners c = { channels_.at(features_[f].channel, 0, 0), { bottom + r.width, bottom, top + r.width, top } };
            corners[f] = c;
        }
        scores_.resize(classes_.size());
        for (size_t k = 0; k < scores_.size(); k++)
            scores_[k].create(channels_.size(), CV_32F);
        std::vector<double> looked(channels_.size().height, 0.);
        parallel_for_(Range(0, channels_.size().height), [&](const Range& range) {
            for (int y = range.start; y < range.end; y++)
                looked[y] = scoreRow(y, corners);
        });
        for (size_t y = 0; y < looked.size(); y++)
            looked_ += looked[y];
        places_ += channels_.size().area();
        done_ = true;
    }
    double scoreRow(int y, const std::vector<Corners>& corners)
    {
        std::vector<float> F(classCount());
        double looked = 0;
        for (int x = 0; x < channels_.size().width; x++)
        {
            const int place = y * channels_.stride() + x;
            const int rounds = boosting_.evaluate(
                [&](int f) {
                    const Corners& c = corners[f];
                    const int* const p = c.base + place;
                    return p[c.at[0]] - p[c.at[1]] - p[c.at[2]] + p[c.at[3]];
                },
                F.data(), early_);
            looked += std::min(rounds, boosting_.rounds());
            for (int k = 1; k < classCount(); k++)
            {
                float other = -FLT_MAX;
                for (int j = 0; j < classCount(); j++)
                    if (j != k)
                        other = std::max(other, F[j]);
                scores_[k - 1].at<float>(y, x) = rounds > boosting_.rounds() ? F[k] - other : -FLT_MAX;
            }
        }
        return looked;
    }

    bool early_;
    int roundCount_;
    std::vector<String> classes_;
    std::vector<ChannelFeature> features_;
    Boosting boosting_;
    Channels channels_;
    std::vector<Mat> scores_;
    bool done_;
    double looked_, places_;
};

} // namespace evaluation

#endif
