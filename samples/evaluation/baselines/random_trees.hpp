// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Extremely randomised trees (Geurts et al. 2006), the classifier of Reiter et al. 2014's landmarks; sizes are ours.

#ifndef OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_RANDOM_TREES_HPP
#define OPENCV_SURGTRACK_SAMPLES_EVALUATION_BASELINES_RANDOM_TREES_HPP

#include <cmath>
#include <vector>
#include "opencv2/core.hpp"

namespace evaluation {

using namespace cv;

//! Classes weigh equally but for the first, the background, which weighs twice.
class RandomTrees
{
public:
    struct Params
    {
        int trees, depth, tried, least;   //!< tried: (feature, threshold) pairs a node; least: samples of a node that is split
        uint64 seed;
        Params() : trees(60), depth(12), tried(40), least(10), seed(1) {}
    };

    RandomTrees() : classes_(0) {}

    //! @param values a row a sample, CV_32F
    void train(const Mat& values, const std::vector<int>& labels, int classes, const Params& params = Params())
    {
        CV_Assert(values.type() == CV_32F && values.rows == (int)labels.size() && classes > 1);
        classes_ = classes;
        std::vector<int> counts(classes, 0);
        for (size_t i = 0; i < labels.size(); i++)
            counts[labels[i]]++;
        std::vector<double> weights(classes);
        for (int k = 0; k < classes; k++)
            weights[k] = (k == 0 ? 2. : 1.) / std::max(counts[k], 1);
        std::vector<Grower> growers(params.trees, Grower(values, labels, weights, params));
        parallel_for_(Range(0, params.trees), [&](const Range& range) {
            for (int i = range.start; i < range.end; i++)
                growers[i].grow(params.seed * 104729 + i);
        });
        nodes_.release();
        posteriors_.release();
        roots_.clear();
        for (int i = 0; i < params.trees; i++)
        {
            roots_.push_back(nodes_.rows);
            Mat nodes = growers[i].nodes();
            for (int j = 0; j < nodes.rows; j++)   // children and leaves are counted over all trees
            {
                double* const node = nodes.ptr<double>(j);
                if (node[0] >= 0)
                    node[2] += nodes_.rows;
                else
                    node[2] += posteriors_.rows;
            }
            const Mat posteriors = growers[i].posteriors();
            nodes_.push_back(nodes);
            posteriors_.push_back(posteriors);
        }
    }

    int classes() const { return classes_; }

    //! @param p classes(): the mean of the leaves' posteriors
    void posterior(const float* values, double* p) const
    {
        std::fill(p, p + classes_, 0.);
        for (size_t i = 0; i < roots_.size(); i++)
        {
            const double* node = nodes_.ptr<double>(roots_[i]);
            while (node[0] >= 0)
                node = nodes_.ptr<double>((int)node[2] + (values[(int)node[0]] > node[1]));
            const float* const leaf = posteriors_.ptr<float>((int)node[2]);
            for (int k = 0; k < classes_; k++)
                p[k] += leaf[k] / roots_.size();
        }
    }

    void write(FileStorage& file) const { file << "classes" << classes_ << "roots" << roots_ << "nodes" << nodes_ << "posteriors" << posteriors_; }
    //! @return whether it was all there
    bool read(const FileNode& node)
    {
        node["classes"] >> classes_;
        node["roots"] >> roots_;
        node["nodes"] >> nodes_;
        node["posteriors"] >> posteriors_;
        return classes_ > 1 && !roots_.empty() && nodes_.type() == CV_64F && nodes_.cols == 3 && posteriors_.type() == CV_32F && posteriors_.cols == classes_;
    }

private:
    //! One tree. Nodes: feature, threshold, first child; or -1, 0, leaf.
    class Grower
    {
    public:
        Grower(const Mat& values, const std::vector<int>& labels, const std::vector<double>& weights, const Params& params)
            : values_(values), labels_(labels), weights_(weights), params_(params)
        {
        }
        void grow(uint64 seed)
        {
            rng_ = RNG(seed);
            std::vector<int> all(labels_.size());
            for (size_t i = 0; i < all.size(); i++)
                all[i] = (int)i;
            nodes_.assign(3, 0.);
            split(0, all, 0);
        }
        Mat nodes() const { return Mat(nodes_, true).reshape(1, (int)nodes_.size() / 3); }
        Mat posteriors() const { return Mat(posteriors_, true).reshape(1, (int)(posteriors_.size() / weights_.size())); }

    private:
        void split(int node, std::vector<int>& samples, int depth)
        {
            int feature = -1;
            float threshold = 0;
            if (depth < params_.depth && (int)samples.size() >= params_.least && !pure(samples))
                choose(samples, feature, threshold);
            if (feature < 0)
                return makeLeaf(node, samples);
            std::vector<int> sides[2];
            for (size_t i = 0; i < samples.size(); i++)
                sides[values_.at<float>(samples[i], feature) > threshold].push_back(samples[i]);
            std::vector<int>().swap(samples);
            const int child = (int)nodes_.size() / 3;
            nodes_[3 * node] = feature;
            nodes_[3 * node + 1] = threshold;
            nodes_[3 * node + 2] = child;
            nodes_.resize(nodes_.size() + 6, 0.);
            for (int side = 0; side < 2; side++)
                split(child + side, sides[side], depth + 1);
        }
        bool pure(const std::vector<int>& samples) const
        {
            for (size_t i = 1; i < samples.size(); i++)
                if (labels_[samples[i]] != labels_[samples[0]])
                    return false;
            return true;
        }
        void makeLeaf(int node, const std::vector<int>& samples)
        {
            std::vector<double> p(weights_.size(), 0.);
            double sum = 0;
            for (size_t i = 0; i < samples.size(); i++)
            {
                p[labels_[samples[i]]] += weights_[labels_[samples[i]]];
                sum += weights_[labels_[samples[i]]];
            }
            nodes_[3 * node] = -1;
            nodes_[3 * node + 2] = double(posteriors_.size() / p.size());
            for (size_t k = 0; k < p.size(); k++)
                posteriors_.push_back(float(p[k] / sum));
        }
        static double entropy(const std::vector<double>& p, double sum)
        {
            double result = 0;
            for (size_t k = 0; k < p.size(); k++)
                if (p[k] > 0)
                    result -= p[k] * std::log(p[k] / sum);
            return result;
        }
        void choose(const std::vector<int>& samples, int& feature, float& threshold)
        {
            double least = DBL_MAX;
            std::vector<double> sides[2];
            for (int i = 0; i < params_.tried; i++)
            {
                const int f = rng_.uniform(0, values_.cols);
                float low = FLT_MAX, high = -FLT_MAX;
                for (size_t j = 0; j < samples.size(); j++)
                {
                    low = std::min(low, values_.at<float>(samples[j], f));
                    high = std::max(high, values_.at<float>(samples[j], f));
                }
                if (!(low < high))
                    continue;
                const float t = std::min(rng_.uniform(low, high), std::nextafter(high, low));
                double sums[2] = { 0, 0 };
                for (int side = 0; side < 2; side++)
                    sides[side].assign(weights_.size(), 0.);
                for (size_t j = 0; j < samples.size(); j++)
                {
                    const int side = values_.at<float>(samples[j], f) > t, label = labels_[samples[j]];
                    sides[side][label] += weights_[label];
                    sums[side] += weights_[label];
                }
                const double mixed = entropy(sides[0], sums[0]) + entropy(sides[1], sums[1]);
                if (mixed < least)
                {
                    least = mixed;
                    feature = f;
                    threshold = t;
                }
            }
        }

        Mat values_;
        const std::vector<int>& labels_;
        const std::vector<double>& weights_;
        Params params_;
        RNG rng_;
        std::vector<double> nodes_;
        std::vector<float> posteriors_;
    };

    int classes_;
    std::vector<int> roots_;
    Mat nodes_, posteriors_;
};

} // namespace evaluation

#endif
