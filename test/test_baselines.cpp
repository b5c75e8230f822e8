// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// What the evaluation's baselines are made of; misc/checks/evaluation.sh runs them as a whole.

#include "test_common.hpp"
#include "../samples/evaluation/baselines/forest.hpp"
#include "../samples/evaluation/baselines/gradboost.hpp"
#include "../samples/evaluation/baselines/options.hpp"

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

Ptr<SyntheticScene> smallScene(int seed, int frames, Size size)
{
    SyntheticScene::Params params;
    params.seed = seed;
    params.frames = frames;
    params.imageSize = size;
    return SyntheticScene::create(Ptr<ToolModel>(), params);
}

// Most of an image is given up at once; the detector is read from the file of the one that learnt.
TEST(Surgtrack_GradBoost, bareTissueIsGivenUpEarly)
{
    const String folder = cv::tempfile("");
    const Ptr<SyntheticScene> scene = smallScene(1, 30, Size(360, 288));
    scene->write(folder);
    const std::vector<String> parts(1, "shaft_pivot");
    GradBoost learnt(parts, 100, true), detector(parts, 100, true);
    learnt.train(Training(std::vector<String>(1, folder)), true);
    utils::fs::remove_all(folder);
    FileStorage file(".yml", FileStorage::WRITE | FileStorage::MEMORY);
    learnt.write(file);
    ASSERT_TRUE(detector.read(FileStorage(file.releaseAndGetString(), FileStorage::READ | FileStorage::MEMORY).root()));
    Mat bare, withTools;
    scene->renderArms(0, std::vector<std::vector<double> >(), std::vector<Matx44d>(), bare);
    scene->render(0, withTools);
    ASSERT_GT(cvtest::norm(bare, withTools, NORM_INF), 50);   // there are none
    std::vector<PartMatch> matches;
    detector.setImage(bare);
    detector.detect(Rect(), 1, 5, matches);
    EXPECT_LT(detector.meanRounds(), 0.1 * detector.rounds());
    EXPECT_GE(detector.meanRounds(), 1);
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
        bins += channels.plane(1 + i);
    EXPECT_EQ(0, cvtest::norm(bins, channels.plane(0), NORM_INF));
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

// The nine values of a pixel, from their definition; x and y are about the place.
std::vector<Vec<double, 9> > valuesAbout(const Mat& image, const Point& place, int radius)
{
    Mat padded, grey, dx, dy;   // the edge goes on beyond the image
    cv::copyMakeBorder(image, padded, 30, 30, 30, 30, BORDER_REPLICATE);
    cv::cvtColor(padded, grey, COLOR_BGR2GRAY);
    cv::Sobel(grey, dx, CV_64F, 1, 0);
    cv::Sobel(grey, dy, CV_64F, 0, 1);
    std::vector<Vec<double, 9> > values;
    for (int y = place.y - radius; y <= place.y + radius; y++)
        for (int x = place.x - radius; x <= place.x + radius; x++)
        {
            const Vec3b c = padded.at<Vec3b>(y + 30, x + 30);
            const double a = std::abs(dx.at<double>(y + 30, x + 30)) / 1020, b = std::abs(dy.at<double>(y + 30, x + 30)) / 1020;
            values.push_back(Vec<double, 9>((x - place.x) / 20., (y - place.y) / 20., c[2] / 255., c[1] / 255., c[0] / 255., a, b,
                                            std::sqrt(a * a + b * b), std::atan2(b, a)));
        }
    return values;
}

Mat randomImage(int low, int high)
{
    Mat image(70, 90, CV_8UC3);
    RNG rng(11);
    rng.fill(image, RNG::UNIFORM, low, high);
    cv::GaussianBlur(image, image, Size(5, 5), 0);
    return image;
}

TEST(Surgtrack_Covariance, isThatOfTheDefinition)
{
    const Mat image = randomImage(0, 256);
    CovarianceImage covariances;
    covariances.setImage(image);
    covariances.prepare(Rect(0, 10, 90, 40));
    const Point places[] = { Point(40, 30), Point(0, 10), Point(89, 49) };
    for (int i = 0; i < 3; i++)
        for (int size = 0; size < 2; size++)
        {
            double mean[9];
            Matx99d C, expected = Matx99d::zeros();
            covariances.covariance(places[i], size, mean, C);
            const int r = CovarianceImage::radius(size);
            std::vector<Vec<double, 9> > values = valuesAbout(image, places[i], r);
            Vec<double, 9> average = Vec<double, 9>::all(0);
            for (int k = 0; k < (int)values.size(); k++)
            {
                const Point from(places[i].x - r + k % (2 * r + 1), places[i].y - r + k / (2 * r + 1));
                Vec<double, 9> kept;
                covariances.valuesAt(from.x + CovarianceImage::BORDER, from.y + CovarianceImage::BORDER, kept.val);
                for (int j = 2; j < 9; j++)
                {
                    EXPECT_NEAR(values[k][j], kept[j], j < 8 ? 1e-6 : 1e-4);   // floats; the last is an angle of gradients of 1/1020 and more
                    values[k][j] = kept[j];
                }
                average += values[k] * (1. / values.size());
            }
            for (size_t k = 0; k < values.size(); k++)
                expected += (values[k] - average) * (values[k] - average).t() * (1. / values.size());
            expected += Matx99d::eye() * 1e-3;
            for (int k = 2; k < 9; k++)
                EXPECT_NEAR(average[k], mean[k], 1e-9 * std::max(1e-2, std::abs(average[k])));
            EXPECT_LT(cv::norm(C - expected, NORM_INF), 1e-9 * cv::norm(expected, NORM_INF)) << places[i] << " " << size;
        }
}

// Of grey levels far from 0 and 255 the gradients are the same.
TEST(Surgtrack_Covariance, gradientsDoNotSeeAConstant)
{
    const Mat dark = randomImage(40, 120);
    Mat bright;
    cv::add(dark, Scalar::all(60), bright);
    Matx99d C[2];
    for (int i = 0; i < 2; i++)
    {
        CovarianceImage covariances;
        covariances.setImage(i == 0 ? dark : bright);
        covariances.prepare(Rect(30, 30, 1, 1));
        double mean[9];
        covariances.covariance(Point(30, 30), 0, mean, C[i]);
    }
    EXPECT_LT(cv::norm(C[0] - C[1], NORM_INF), 1e-5);   // floats, of values up to 1.6
}

TEST(Surgtrack_Covariance, logarithmIsThatOfEigenvalues)
{
    RNG rng(13);
    Mat A(9, 9, CV_64F), values, vectors;
    rng.fill(A, RNG::UNIFORM, -1, 1);
    const Mat C = A * A.t() + Mat::eye(9, 9, CV_64F) * 1e-3;
    cv::eigen(C, values, vectors);
    cv::log(values, values);
    const Mat expected = vectors.t() * Mat::diag(values) * vectors;
    EXPECT_LT(cv::norm(Mat(matrixLog(Matx99d(C.ptr<double>()))), expected, NORM_INF), 1e-9);
}

TEST(Surgtrack_Covariance, isFiniteWhereNothingIs)
{
    const Mat sizes[] = { Mat(41, 33, CV_8UC3, Scalar::all(90)), Mat(30, 47, CV_8U, Scalar::all(0)) };
    for (int i = 0; i < 2; i++)
    {
        CovarianceImage covariances;
        covariances.setImage(sizes[i]);
        covariances.prepare(Rect(Point(), sizes[i].size()));
        std::vector<float> values(CovarianceImage::LENGTH * CovarianceImage::SIZES);
        covariances.describe(Point(3, 5), values.data());
        EXPECT_TRUE(checkRange(Mat(values)));
    }
}

TEST(Surgtrack_Forest, learnsClustersAndComesFromItsFile)
{
    RNG rng(17);
    Mat values(900, 4, CV_32F);
    std::vector<int> labels;
    for (int i = 0; i < values.rows; i++)
    {
        labels.push_back(i % 3);
        for (int j = 0; j < 4; j++)
            values.at<float>(i, j) = float(rng.gaussian(0.5) + (j == labels[i] ? 4 : 0));   // eight deviations apart
    }
    RandomTrees::Params params;
    params.trees = 10;
    RandomTrees trees, other;
    trees.train(values, labels, 3, params);
    FileStorage file(".yml", FileStorage::WRITE | FileStorage::MEMORY);
    trees.write(file);
    ASSERT_TRUE(other.read(FileStorage(file.releaseAndGetString(), FileStorage::READ | FileStorage::MEMORY).root()));
    int right = 0;
    for (int i = 0; i < values.rows; i++)
    {
        double p[3], q[3];
        trees.posterior(values.ptr<float>(i), p);
        other.posterior(values.ptr<float>(i), q);
        EXPECT_NEAR(1, p[0] + p[1] + p[2], 1e-5);   // of floats
        right += std::max_element(p, p + 3) - p == labels[i];
        for (int k = 0; k < 3; k++)
            EXPECT_EQ(p[k], q[k]);
    }
    EXPECT_GT(right, 0.99 * values.rows);
}

// Folders that name the same video, and one with a copy of it.
TEST(Surgtrack_Baselines, refuseToLearnFromTestedVideos)
{
    const String root = cv::tempfile("");
    const String names[] = { "one", "worn", "copy", "other" };
    for (int i = 0; i < 4; i++)
        smallScene(i == 3 ? 2 : 1, 2, Size(160, 120))->write(utils::fs::join(root, names[i]));
    const std::vector<String> tested(1, utils::fs::join(root, "one"));
    CameraPair cameras;
    cameras.left = Sequence::load(tested[0])->leftCamera();
    writeSequenceCameras(utils::fs::join(root, "worn"), cameras, "../one/left.mp4");
    for (int i = 0; i < 3; i++)
    {
        const String training = utils::fs::join(root, names[i]);
        const std::string text = errorText([&]() { checkLeaks(std::vector<String>(1, training), tested); });
        EXPECT_NE(std::string::npos, text.find(training)) << text;
        EXPECT_NE(std::string::npos, text.find(tested[0])) << text;
    }
    EXPECT_NO_THROW(checkLeaks(std::vector<String>(1, utils::fs::join(root, "other")), tested));
    utils::fs::remove_all(root);
}

TEST(Surgtrack_Baselines, refuseThoseOfTheEvaluation)
{
    const String folder = utils::fs::getParent(recorded("sequences/paper_rig_worn"));
    const char* const pairs[][2] = { { "paper_rig_worn", "paper_rig" }, { "paper_rig", "paper_rig_realjoints" },
                                     { "exvivo_dual_moved_realjoints", "exvivo_dual_moved" }, { "phantom_stereo", "phantom_stereo_realjoints" } };
    for (int i = 0; i < 4; i++)
        EXPECT_ERROR(checkLeaks(std::vector<String>(1, utils::fs::join(folder, pairs[i][0])), std::vector<String>(1, utils::fs::join(folder, pairs[i][1]))),
                     pairs[i][1]);
    EXPECT_NO_THROW(checkLeaks(std::vector<String>(1, utils::fs::join(folder, "paper_rig")), std::vector<String>(1, utils::fs::join(folder, "exvivo_single"))));
    BaselineOptions options;
    options.leaveOut = true;
    options.train.push_back(utils::fs::join(folder, "paper_rig"));
    options.train.push_back(utils::fs::join(folder, "exvivo_single"));
    EXPECT_EQ(std::vector<String>(1, options.train[1]), options.trainingFor(utils::fs::join(folder, "paper_rig_worn")));
    EXPECT_EQ(std::vector<String>(1, options.train[0]), options.trainingFor(utils::fs::join(folder, "exvivo_single_realjoints")));
}

// Counts how often it learns.
struct Learner
{
    String text;
    int learnt, value;
    explicit Learner(const String& constants) : text(constants), learnt(0), value(0) {}
    String name() const { return "learner"; }
    String constants() const { return text; }
    void train(const Training&, bool)
    {
        learnt++;
        value = 7;
    }
    void write(FileStorage& file) const { file << "value" << value; }
    bool read(const FileNode& node)
    {
        node["value"] >> value;
        return value == 7;
    }
};

void checkLearner(const String& constants, const String& sequence, const String& models, int learnt)
{
    Learner learner(constants);
    prepare(learner, Training(std::vector<String>(1, sequence)), models, true);
    EXPECT_EQ(learnt, learner.learnt) << constants << " " << sequence;
    EXPECT_EQ(7, learner.value);
}

// A model is learnt once for its constants and the files that it learns from.
TEST(Surgtrack_Baselines, learnOnce)
{
    const String root = cv::tempfile(""), one = utils::fs::join(root, "one"), other = utils::fs::join(root, "other"), models = utils::fs::join(root, "models");
    smallScene(1, 2, Size(160, 120))->write(one);
    smallScene(2, 2, Size(160, 120))->write(other);
    checkLearner("a", one, models, 1);
    checkLearner("a", one, models, 0);
    checkLearner("b", one, models, 1);
    checkLearner("a", other, models, 1);
    smallScene(3, 2, Size(160, 120))->write(one);   // other contents
    checkLearner("a", one, models, 1);
    std::vector<String> files;
    utils::fs::glob(models, "*", files);
    ASSERT_EQ(4u, files.size());   // and nothing half written
    for (size_t i = 0; i < files.size(); i++)
    {
        EXPECT_NE(String::npos, files[i].find("learner-")) << files[i];
        FileStorage file(files[i], FileStorage::WRITE);
        file << "value" << 8;
    }
    EXPECT_ERROR(checkLearner("a", one, models, 0), "is no model of learner");
    utils::fs::remove_all(root);
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
