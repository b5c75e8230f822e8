// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Gradient boosting for several classes (Friedman 2001), as Sznitman et al. 2014 detect parts with; constants they leave open are ours.

#ifndef OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_BOOSTING_HPP
#define OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_BOOSTING_HPP

#include <algorithm>
#include <cmath>
#include <vector>
#include "opencv2/core.hpp"

namespace evaluation {

using namespace cv;

//! A regression tree of depth 2: to the right where the value is above the threshold.
struct BoostedTree
{
    int feature[3], threshold[3];   //!< root, left, right
    float leaf[4];
};

/** Softmax over classes, of which 0 is the background: each round adds a tree a class. After some rounds a place is given up whose margin,
the best part's score less the background's, is below what nearly all parts have there. */
class Boosting
{
public:
    struct Params
    {
        int rounds, tried;            //!< tried: features a split
        double shrinkage, share;      //!< share: of the samples drawn for each tree
        double quantile, slack;       //!< of the margin at which a place is given up
        uint64 seed;
        Params() : rounds(200), tried(120), shrinkage(0.1), share(0.5), quantile(0.02), slack(0.05), seed(1) {}
    };
    enum { LEVELS = 64 };

    Boosting() : classes_(0) {}

    /** @param values a row a sample, CV_16U
    @param labels of the samples, 0..classes-1
    Each class has the same total weight. */
    void train(const Mat& values, const std::vector<int>& labels, int classes, const Params& params = Params())
    {
        CV_Assert(values.type() == CV_16U && values.rows == (int)labels.size() && classes > 1);
        classes_ = classes;
        params_ = params;
        labels_ = labels;
        trees_.clear();
        quantise(values);
        weigh();
        scores_ = Mat::zeros(values.rows, classes, CV_32F);
        Mat margins((int)labels.size(), params.rounds, CV_32F);
        for (int round = 0; round < params.rounds; round++)
        {
            addRound(round);
            for (int i = 0; i < margins.rows; i++)
                margins.at<float>(i, round) = margin(scores_.ptr<float>(i));
        }
        setStops(margins);
        levels_.release();
        scores_.release();
    }

    int classes() const { return classes_; }
    int rounds() const { return classes_ ? (int)trees_.size() / classes_ : 0; }
    const BoostedTree& tree(int round, int cls) const { return trees_[round * classes_ + cls]; }
    float stop(int round) const { return stops_[round]; }

    //! @param F classes(), result @param early whether it may be given up @return rounds looked at; fewer than rounds(): given up
    template <class Value> int evaluate(const Value& value, float* F, bool early) const
    {
        std::fill(F, F + classes_, 0.f);
        const int count = rounds();
        const BoostedTree* tree = trees_.data();
        for (int round = 0; round < count; round++)
        {
            for (int k = 0; k < classes_; k++, tree++)
            {
                const int right = value(tree->feature[0]) > tree->threshold[0], node = 1 + right;
                F[k] += tree->leaf[2 * right + (value(tree->feature[node]) > tree->threshold[node])];
            }
            if (early && margin(F) < stops_[round])
                return round + 1;
        }
        return count + 1;
    }
    void probabilities(const float* F, double* p) const
    {
        double sum = 0;
        const float most = *std::max_element(F, F + classes_);
        for (int k = 0; k < classes_; k++)
            sum += p[k] = std::exp(double(F[k] - most));
        for (int k = 0; k < classes_; k++)
            p[k] /= sum;
    }

    void write(FileStorage& file) const
    {
        Mat nodes((int)trees_.size(), 6, CV_32S), leaves((int)trees_.size(), 4, CV_32F);
        for (int i = 0; i < nodes.rows; i++)
        {
            std::copy(trees_[i].feature, trees_[i].feature + 3, nodes.ptr<int>(i));
            std::copy(trees_[i].threshold, trees_[i].threshold + 3, nodes.ptr<int>(i) + 3);
            std::copy(trees_[i].leaf, trees_[i].leaf + 4, leaves.ptr<float>(i));
        }
        file << "classes" << classes_ << "nodes" << nodes << "leaves" << leaves << "stops" << stops_;
    }
    //! @return whether it was all there
    bool read(const FileNode& node)
    {
        Mat nodes, leaves;
        node["classes"] >> classes_;
        node["nodes"] >> nodes;
        node["leaves"] >> leaves;
        node["stops"] >> stops_;
        if (classes_ < 2 || nodes.cols != 6 || leaves.cols != 4 || nodes.rows != leaves.rows || nodes.rows != classes_ * (int)stops_.size())
            return false;
        trees_.resize(nodes.rows);
        for (int i = 0; i < nodes.rows; i++)
        {
            std::copy(nodes.ptr<int>(i), nodes.ptr<int>(i) + 3, trees_[i].feature);
            std::copy(nodes.ptr<int>(i) + 3, nodes.ptr<int>(i) + 6, trees_[i].threshold);
            std::copy(leaves.ptr<float>(i), leaves.ptr<float>(i) + 4, trees_[i].leaf);
        }
        return true;
    }

private:
    float margin(const float* F) const { return *std::max_element(F + 1, F + classes_) - F[0]; }

    //! Levels of equal numbers of samples: a row a feature.
    void quantise(const Mat& values)
    {
        levels_.create(values.cols, values.rows, CV_8U);
        edges_.create(values.cols, LEVELS - 1, CV_32S);
        parallel_for_(Range(0, values.cols), [&](const Range& range) {
            for (int f = range.start; f < range.end; f++)
            {
                std::vector<int> sorted(values.rows);
                for (int i = 0; i < values.rows; i++)
                    sorted[i] = values.at<ushort>(i, f);
                std::sort(sorted.begin(), sorted.end());
                int* edges = edges_.ptr<int>(f);
                for (int j = 0; j < LEVELS - 1; j++)   // a value above edge j has a level above j
                    edges[j] = sorted[size_t(j + 1) * (sorted.size() - 1) / LEVELS];
                for (int i = 0; i < values.rows; i++)
                    levels_.at<uchar>(f, i) = (uchar)(std::lower_bound(edges, edges + LEVELS - 1, (int)values.at<ushort>(i, f)) - edges);
            }
        });
    }
    void weigh()
    {
        std::vector<int> counts(classes_, 0);
        for (size_t i = 0; i < labels_.size(); i++)
            counts[labels_[i]]++;
        weights_.resize(labels_.size());
        for (size_t i = 0; i < labels_.size(); i++)
            weights_[i] = (float)(double(labels_.size()) / (classes_ * counts[labels_[i]]));
    }

    void addRound(int round)
    {
        const int count = (int)labels_.size();
        Mat residuals(classes_, count, CV_32F);
        parallel_for_(Range(0, count), [&](const Range& range) {
            std::vector<double> p(classes_);
            for (int i = range.start; i < range.end; i++)
            {
                probabilities(scores_.ptr<float>(i), p.data());
                for (int k = 0; k < classes_; k++)
                    residuals.at<float>(k, i) = float((labels_[i] == k) - p[k]);
            }
        });
        trees_.resize(trees_.size() + classes_);
        parallel_for_(Range(0, classes_), [&](const Range& range) {
            for (int k = range.start; k < range.end; k++)
            {
                Grower grower(*this, residuals.ptr<float>(k), params_.seed * 7919 + round * classes_ + k);
                BoostedTree& tree = trees_[round * classes_ + k];
                tree = grower.grow();
                for (int i = 0; i < count; i++)
                {
                    const int right = grower.above(0, i), node = 1 + right;
                    scores_.at<float>(i, k) += tree.leaf[2 * right + grower.above(node, i)];
                }
            }
        });
    }

    void setStops(const Mat& margins)
    {
        stops_.assign(params_.rounds, 0);
        for (int round = 0; round < params_.rounds; round++)
        {
            std::vector<float> ofParts;
            for (int i = 0; i < margins.rows; i++)
                if (labels_[i] > 0)
                    ofParts.push_back(margins.at<float>(i, round));
            std::sort(ofParts.begin(), ofParts.end());
            stops_[round] = float(ofParts[size_t(params_.quantile * (ofParts.size() - 1))] - params_.slack);
        }
    }

    //! Fits one tree to the residuals of some samples.
    class Grower
    {
    public:
        Grower(const Boosting& boosting, const float* residuals, uint64 seed) : b_(boosting), r_(residuals), rng_(seed) {}

        BoostedTree grow()
        {
            std::vector<int> all, sides[2];
            for (int i = 0; i < (int)b_.labels_.size(); i++)
                if (rng_.uniform(0., 1.) < b_.params_.share)
                    all.push_back(i);
            split(0, all);
            for (size_t i = 0; i < all.size(); i++)
                sides[above(0, all[i])].push_back(all[i]);
            for (int side = 0; side < 2; side++)
            {
                split(1 + side, sides[side]);
                double r[2] = { 0, 0 }, curvature[2] = { 0, 0 };
                for (size_t i = 0; i < sides[side].size(); i++)
                {
                    const int sample = sides[side][i], leaf = above(1 + side, sample);
                    const double size = std::abs(r_[sample]);
                    r[leaf] += b_.weights_[sample] * r_[sample];
                    curvature[leaf] += b_.weights_[sample] * size * (1 - size);
                }
                for (int leaf = 0; leaf < 2; leaf++)
                {
                    const double step = (b_.classes_ - 1.) / b_.classes_ * r[leaf] / std::max(curvature[leaf], 1e-9);
                    tree_.leaf[2 * side + leaf] = float(b_.params_.shrinkage * std::max(-1., std::min(1., step)));
                }
            }
            return tree_;
        }
        int above(int node, int sample) const { return b_.levels_.at<uchar>(tree_.feature[node], sample) > level_[node]; }

    private:
        void split(int node, const std::vector<int>& samples)
        {
            tree_.feature[node] = 0;
            level_[node] = LEVELS - 1;
            tree_.threshold[node] = INT_MAX;   // all to the left
            std::vector<float> wr(samples.size()), w(samples.size());
            for (size_t i = 0; i < samples.size(); i++)
            {
                w[i] = b_.weights_[samples[i]];
                wr[i] = w[i] * r_[samples[i]];
            }
            double best = 0;
            for (int i = 0; i < b_.params_.tried; i++)
                tryFeature(node, rng_.uniform(0, b_.levels_.rows), samples, wr, w, best);
        }
        void tryFeature(int node, int feature, const std::vector<int>& samples, const std::vector<float>& wr, const std::vector<float>& w, double& best)
        {
            double sums[LEVELS][2] = {}, total[2] = { 0, 0 }, left[2] = { 0, 0 };
            const uchar* const levels = b_.levels_.ptr<uchar>(feature);
            for (size_t i = 0; i < samples.size(); i++)
            {
                double* const sum = sums[levels[samples[i]]];
                sum[0] += wr[i];
                sum[1] += w[i];
            }
            for (int j = 0; j < LEVELS; j++)
            {
                total[0] += sums[j][0];
                total[1] += sums[j][1];
            }
            for (int j = 0; j < LEVELS - 1; j++)
            {
                left[0] += sums[j][0];
                left[1] += sums[j][1];
                const double right[2] = { total[0] - left[0], total[1] - left[1] };
                if (left[1] < 1e-6 || right[1] < 1e-6)
                    continue;
                const double gain = left[0] * left[0] / left[1] + right[0] * right[0] / right[1];
                if (gain <= best)
                    continue;
                best = gain;
                tree_.feature[node] = feature;
                tree_.threshold[node] = b_.edges_.at<int>(feature, j);
                level_[node] = j;
            }
        }

        const Boosting& b_;
        const float* r_;
        RNG rng_;
        BoostedTree tree_;
        int level_[3];
    };

    Params params_;
    int classes_;
    std::vector<BoostedTree> trees_;
    std::vector<float> stops_;
    Mat levels_, edges_, scores_;   // while it learns
    std::vector<int> labels_;
    std::vector<float> weights_;
};

} // namespace evaluation

#endif
