// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// The landmark detector of Reiter et al. 2014, re-implemented from its description: randomised trees over covariance descriptors.
// Published: both of them. Sizes and the set of values are ours.

#ifndef OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_FOREST_HPP
#define OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_FOREST_HPP

#include "covariance.hpp"
#include "detectors.hpp"
#include "random_trees.hpp"

namespace evaluation {

class Forest : public PartDetector
{
public:
    enum { STEP = 3, REFINE = 6 };   // [pixel]

    Forest(const std::vector<String>& classes, int trees) : classes_(classes) { params_.trees = trees; }
    String name() const CV_OVERRIDE { return "forest"; }
    const std::vector<String>& classes() const CV_OVERRIDE { return classes_; }
    String constants() const CV_OVERRIDE
    {
        String text = format("forest 1, %d trees", params_.trees);
        for (size_t i = 0; i < classes_.size(); i++)
            text += " " + classes_[i];
        return text;
    }

    void setImage(const Mat& image) CV_OVERRIDE
    {
        image_.setImage(image);
        posteriors_.create((image.rows + STEP - 1) / STEP, (image.cols + STEP - 1) / STEP, CV_32FC(classCount()));
        known_ = Mat::zeros(posteriors_.size(), CV_8U);
    }

    //! Windows that overlap share what was computed. Scores are posteriors.
    void detect(const Rect& window, int cls, int count, std::vector<PartMatch>& matches) CV_OVERRIDE
    {
        const Rect all(Point(), image_.size());
        matches.clear();
        const Rect grid = gridOf(window.empty() ? all : window & all);
        compute(grid);
        for (int y = grid.y; y < grid.br().y; y++)
            for (int x = grid.x; x < grid.br().x; x++)
                matches.push_back(matchAt(Point2d(x * STEP, y * STEP), cls, posteriors_.ptr<float>(y)[x * classCount() + cls]));
        suppress(matches, SUPPRESSION, count);
        for (size_t i = 0; i < matches.size(); i++)
            matches[i].imagePoint = refined(matches[i].imagePoint, cls);
    }

    void train(const Training& training, bool quiet) CV_OVERRIDE
    {
        PlaceChooser chooser(training, classes_, 2000);
        Mat values;
        std::vector<int> labels;
        training.frames(1, [&](const Mat& image, const ClassPoints& points) {
            image_.setImage(image);
            const std::vector<Place> places = chooser.choose(image.size(), points);
            Mat rows((int)places.size(), LENGTH, CV_32F);
            for (size_t i = 0; i < places.size(); i++)
            {
                const Point p(cvRound(places[i].point.x), cvRound(places[i].point.y));
                image_.prepare(Rect(p, Size(1, 1)));
                image_.describe(p, rows.ptr<float>((int)i));
                labels.push_back(places[i].cls);
            }
            values.push_back(rows);
        });
        if (!quiet)
            std::fprintf(stderr, "forest: learns from %d places\n", values.rows);
        trees_.train(values, labels, classCount(), params_);
    }
    void write(FileStorage& file) const CV_OVERRIDE { trees_.write(file); }
    bool read(const FileNode& node) CV_OVERRIDE { return trees_.read(node) && trees_.classes() == classCount(); }

private:
    enum { LENGTH = CovarianceImage::LENGTH * CovarianceImage::SIZES };

    //! Places of the grid inside a region.
    static Rect gridOf(const Rect& r)
    {
        if (r.empty())
            return Rect();
        const Point first((r.x + STEP - 1) / STEP, (r.y + STEP - 1) / STEP), last((r.x + r.width - 1) / STEP, (r.y + r.height - 1) / STEP);
        return last.x < first.x || last.y < first.y ? Rect() : Rect(first, last + Point(1, 1));
    }
    void compute(const Rect& grid)
    {
        if (grid.empty() || countNonZero(known_(grid)) == grid.area())
            return;
        image_.prepare(Rect(grid.x * STEP, grid.y * STEP, (grid.width - 1) * STEP + 1, (grid.height - 1) * STEP + 1));
        parallel_for_(Range(grid.y, grid.br().y), [&](const Range& range) {
            float values[LENGTH];
            std::vector<double> p(classCount());
            for (int y = range.start; y < range.end; y++)
                for (int x = grid.x; x < grid.br().x; x++)
                {
                    if (known_.at<uchar>(y, x))
                        continue;
                    known_.at<uchar>(y, x) = 1;
                    image_.describe(Point(x * STEP, y * STEP), values);
                    trees_.posterior(values, p.data());
                    for (int k = 0; k < classCount(); k++)
                        posteriors_.ptr<float>(y)[x * classCount() + k] = (float)p[k];
                }
        });
    }
    //! The centre of mass of the posterior about a place.
    Point2d refined(const Point2d& place, int cls) const
    {
        const int cx = cvRound(place.x / STEP), cy = cvRound(place.y / STEP), reach = REFINE / STEP;
        Point2d sum;
        double mass = 0;
        for (int y = std::max(cy - reach, 0); y <= std::min(cy + reach, known_.rows - 1); y++)
            for (int x = std::max(cx - reach, 0); x <= std::min(cx + reach, known_.cols - 1); x++)
                if (known_.at<uchar>(y, x) && std::hypot(x - cx, y - cy) * STEP <= REFINE)
                {
                    const double p = posteriors_.ptr<float>(y)[x * classCount() + cls];
                    sum += p * Point2d(x * STEP, y * STEP);
                    mass += p;
                }
        return mass > 0 ? sum * (1 / mass) : place;
    }

    std::vector<String> classes_;
    RandomTrees::Params params_;
    RandomTrees trees_;
    CovarianceImage image_;
    Mat posteriors_, known_;
};

} // namespace evaluation

#endif
