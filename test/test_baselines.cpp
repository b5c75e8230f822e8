// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// What the evaluation's baselines are made of; misc/checks/evaluation.sh runs them as a whole.

#include "test_common.hpp"
#include "../samples/evaluation/baselines/gradboost.hpp"

namespace opencv_test { namespace {

using namespace evaluation;

// Two values, an exclusive-or of which is the class.
void makeExclusiveOr(Mat& values, std::vector<int>& labels)
{
    RNG rng(3);
    values.create(2000, 2, CV_16U);
    for (int i = 0; i < values.rows; i++)
    {
        const int a = rng.uniform(0, 2), b = rng.uniform(0, 2);
        values.at<ushort>(i, 0) = ushort(1000 * a + rng.uniform(0, 900));
        values.at<ushort>(i, 1) = ushort(1000 * b + rng.uniform(0, 900));
        labels.push_back(a ^ b);
    }
}

struct RowOf
{
    const ushort* values;
    int operator()(int feature) const { return values[feature]; }
};

Boosting learn(const Mat& values, const std::vector<int>& labels, double quantile = 0.02, double slack = 0.05)
{
    Boosting::Params params;
    params.rounds = 60;
    params.quantile = quantile;
    params.slack = slack;
    Boosting boosting;
    boosting.train(values, labels, 2, params);
    return boosting;
}

String textOf(const Boosting& boosting)
{
    FileStorage file(".yml", FileStorage::WRITE | FileStorage::MEMORY);
    boosting.write(file);
    return file.releaseAndGetString();
}

TEST(Surgtrack_Boosting, learnsExclusiveOr)
{
    Mat values;
    std::vector<int> labels;
    makeExclusiveOr(values, labels);
    const Boosting boosting = learn(values, labels);
    int right = 0;
    for (int i = 0; i < values.rows; i++)
    {
        const RowOf row = { values.ptr<ushort>(i) };
        float F[2];
        double p[2];
        boosting.evaluate(row, F, false);
        boosting.probabilities(F, p);
        EXPECT_NEAR(1, p[0] + p[1], 1e-12);
        right += (p[1] > p[0]) == (labels[i] == 1);
    }
    EXPECT_GT(right, 0.99 * values.rows);
}

TEST(Surgtrack_Boosting, theSameAgainAndFromItsFile)
{
    Mat values;
    std::vector<int> labels;
    makeExclusiveOr(values, labels);
    const Boosting boosting = learn(values, labels);
    const String text = textOf(boosting);
    EXPECT_EQ(text, textOf(learn(values, labels)));
    Boosting other;
    ASSERT_TRUE(other.read(FileStorage(text, FileStorage::READ | FileStorage::MEMORY).root()));
    EXPECT_EQ(boosting.rounds(), other.rounds());
    for (int i = 0; i < values.rows; i++)
    {
        const RowOf row = { values.ptr<ushort>(i) };
        float a[2], b[2];
        EXPECT_EQ(boosting.evaluate(row, a, true), other.evaluate(row, b, true));
        EXPECT_EQ(a[0], b[0]);
        EXPECT_EQ(a[1], b[1]);
    }
}

TEST(Surgtrack_Boosting, readsNoOtherFile)
{
    const String text = "%YAML:1.0\n---\nclasses: 2\nstops: [ 1. ]\n";
    Boosting boosting;
    EXPECT_FALSE(boosting.read(FileStorage(text, FileStorage::READ | FileStorage::MEMORY).root()));
}

// With quantile 0 and no slack all positives stay, and most of the others go.
TEST(Surgtrack_Boosting, earlyStoppingKeepsParts)
{
    Mat values;
    std::vector<int> labels;
    makeExclusiveOr(values, labels);
    const Boosting boosting = learn(values, labels, 0, 0);
    int stopped = 0, others = 0;
    for (int i = 0; i < values.rows; i++)
    {
        const RowOf row = { values.ptr<ushort>(i) };
        float F[2];
        const bool early = boosting.evaluate(row, F, true) <= boosting.rounds();
        EXPECT_FALSE(early && labels[i] == 1) << i;
        stopped += early;
        others += labels[i] == 0;
    }
    EXPECT_GT(stopped, others / 2);
}

void checkChannels(const Mat& image)
{
    Channels channels;
    channels.setImage(image);
    ASSERT_EQ(Size(image.cols / 2, image.rows / 2), channels.size());
    const Rect all(Point(), channels.size());
    for (int channel = 0; channel < Channels::COUNT; channel++)
    {
        const Mat& plane = channels.plane(channel);
        EXPECT_EQ(cvRound(sum(plane)[0]), channels.sum(channel, all));
        const Rect inner(3, 2, 7, 5), outer(-4, -3, 4, 3);   // beyond its corner the edge goes on
        EXPECT_EQ(cvRound(sum(plane(inner))[0]), channels.sum(channel, inner));
        EXPECT_EQ(12 * plane.at<uchar>(0, 0), channels.sum(channel, outer));
    }
    Mat bins = Mat::zeros(channels.size(), CV_8U);
    for (int i = 0; i < Channels::BINS; i++)
        bins += channels.plane(4 + i);
    EXPECT_EQ(0, cvtest::norm(bins, channels.plane(3), NORM_INF));
}

TEST(Surgtrack_Channels, sumsAreThoseOfPixels)
{
    RNG rng(5);
    Mat colour(61, 83, CV_8UC3), grey(40, 57, CV_8U);
    rng.fill(colour, RNG::UNIFORM, 0, 256);
    rng.fill(grey, RNG::UNIFORM, 0, 256);
    checkChannels(colour);
    checkChannels(grey);
}

TEST(Surgtrack_Channels, featuresAreInsideTheWindow)
{
    const std::vector<ChannelFeature> features = ChannelFeature::random(1000, 1);
    const int half = ChannelFeature::WINDOW / 2;
    for (size_t i = 0; i < features.size(); i++)
        EXPECT_EQ(features[i].box, features[i].box & Rect(-half, -half, 2 * half, 2 * half)) << i;
}

TEST(Surgtrack_Baselines, suppressesNeighbours)
{
    RNG rng(7);
    std::vector<PartMatch> matches;
    for (int i = 0; i < 500; i++)
        matches.push_back(matchAt(Point2d(rng.uniform(0., 100.), rng.uniform(0., 100.)), 1, rng.uniform(0., 1.)));
    suppress(matches, 12, 10);
    ASSERT_EQ(10u, matches.size());
    for (size_t i = 1; i < matches.size(); i++)
    {
        EXPECT_LE(matches[i].similarity, matches[i - 1].similarity);
        for (size_t j = 0; j < i; j++)
            EXPECT_GE(cv::norm(matches[i].imagePoint - matches[j].imagePoint), 12);
    }
}

TEST(Surgtrack_Baselines, sidesAreOneClass)
{
    EXPECT_EQ("logo_s", className("logo_s_flat"));
    EXPECT_EQ("logo_s", className("logo_s_deep"));
    EXPECT_EQ("tip", className("tip"));
}

}} // namespace
