// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_filter_bench.hpp"
#include "opencv2/surgtrack/tool_state.hpp"

// What is wrong with the readings of a wrist that cables move, and what METHOD_FULL's filter learns of it.

namespace opencv_test { namespace {

const size_t WRIST = 3;   // the first coordinate that is not exact: q4; then q5, q6, jaw
const int FRAMES = 160, LAST = 60;

//! A wrist that stands where its readings do not say.
class CableDriven
{
public:
    CableDriven(double gain, double play, double coupling) : gain_(gain), play_(play), coupling_(coupling) {}

    std::vector<double> joints(const std::vector<double>& readings)
    {
        if (first_.empty()) first_ = hanging_ = readings;
        std::vector<double> result = readings;
        for (size_t i = WRIST; i < readings.size(); i++)
        {
            // Pulled along by whichever end of the play is reached.
            hanging_[i] = std::min(std::max(hanging_[i], readings[i] - play_), readings[i] + play_);
            result[i] = hanging_[i] + gain_ * (readings[i] - first_[i]);
            if (i > WRIST && i + 1 < readings.size()) result[i] += coupling_ * (readings[i - 1] - first_[i - 1]);
        }
        return result;
    }

private:
    double gain_, play_, coupling_;
    std::vector<double> first_, hanging_;
};

// Forth and back, each coordinate at its own pace: the whole travel within 60 frames.
std::vector<double> readingsAt(const PosedTool& tool, int frame)
{
    return joints(tool, 0.4 + 0.9 * std::sin(0.11 * frame), 0.6 * std::sin(0.17 * frame + 1), 0.6 * std::sin(0.23 * frame + 2), 0.5 + 0.3 * std::sin(0.13 * frame));
}

ArticulatedPoseEKF::Params offsetsOnly()
{
    ArticulatedPoseEKF::Params params;
    params.gain = params.play = params.coupling = 0;
    return params;
}

// Mean error of the last frames [rad]. The arm itself is exact.
double rotationError(CableDriven wrist, const ArticulatedPoseEKF::Params& params, uint64 seed)
{
    const CameraModel camera = endoscope();
    RNG rng(seed);
    Bench bench(PosedTool(0.1), motionAbout(Point3d(0, 0, 0.1), randomDirection(rng) * DEGREE, randomDirection(rng) * 0.002));
    const Ptr<ArticulatedPoseEKF> filter = bench.filter(params);
    double sum = 0;
    for (int frame = 0; frame < FRAMES; frame++)
    {
        const std::vector<double> readings = readingsAt(bench.tool, frame);
        bench.move(wrist.joints(readings));
        filter->predict(readings);
        EXPECT_TRUE(correct(*filter, camera, bench.parts, bench.seen(camera, SAME_EYE, 1, &rng), 2)) << frame;
        if (frame >= FRAMES - LAST) sum += rotationAngle(bench.toolPose(filter->view()), bench.toolPose(bench.tool.view)) / LAST;
    }
    return sum;
}

struct Wrist
{
    const char* name;
    double gain, play, coupling;
    double better;   // errors without what is learnt are at least so many times larger: three quarters of what is measured
};

class SurgTrack_Wrists : public testing::TestWithParam<Wrist>
{
};

struct WristNames
{
    template <typename Info> std::string operator()(const Info& info) const { return info.param.name; }
};

TEST_P(SurgTrack_Wrists, areLearntAsTheyTravel)
{
    const Wrist& w = GetParam();
    double learnt = 0, without = 0;
    for (int run = 0; run < 3; run++)
    {
        learnt += rotationError(CableDriven(w.gain, w.play, w.coupling), ArticulatedPoseEKF::Params(), 20 + run) / 3;
        without += rotationError(CableDriven(w.gain, w.play, w.coupling), offsetsOnly(), 20 + run) / 3;
    }
    if (std::getenv("SURGTRACK_TEST_PRINT")) std::cout << w.name << ": " << learnt << " rad, " << without << " rad without" << std::endl;
    EXPECT_GT(without, w.better * learnt);
}

// Measured: 5.6, 8.7, 14.4, 15.0; what is learnt leaves 0.003 to 0.004 rad, as if the readings were exact.
const Wrist WRISTS[] = {{"gain", 0.03, 0, 0, 4}, {"play", 0, 0.02, 0, 6.5}, {"coupling", 0, 0, 0.1, 10}, {"together", 0.03, 0.02, 0.1, 11}};
INSTANTIATE_TEST_CASE_P(All, SurgTrack_Wrists, testing::ValuesIn(WRISTS), WristNames());

TEST(SurgTrack_JointErrors, exactReadingsLoseLittle)
{
    double learnt = 0, without = 0;
    for (int run = 0; run < 3; run++)
    {
        learnt += rotationError(CableDriven(0, 0, 0), ArticulatedPoseEKF::Params(), 20 + run) / 3;
        without += rotationError(CableDriven(0, 0, 0), offsetsOnly(), 20 + run) / 3;
    }
    if (std::getenv("SURGTRACK_TEST_PRINT")) std::cout << "exact: " << learnt << " rad, " << without << " rad without" << std::endl;
    EXPECT_LT(learnt, 1.5 * without);   // noise is taken for errors of readings, too; measured: 1.31
}

// What was learnt, through a file or not, is where another filter begins.
Ptr<ArticulatedPoseEKF> learntFilter(const Bench& still, CableDriven wrist)
{
    const CameraModel camera = endoscope();
    Bench bench(still);
    RNG rng(5);
    const Ptr<ArticulatedPoseEKF> filter = bench.filter();
    for (int frame = 0; frame < FRAMES; frame++)
    {
        const std::vector<double> readings = readingsAt(bench.tool, frame);
        bench.move(wrist.joints(readings));
        filter->predict(readings);
        EXPECT_TRUE(correct(*filter, camera, bench.parts, bench.seen(camera, SAME_EYE, 1, &rng), 2)) << frame;
    }
    return filter;
}

TEST(SurgTrack_JointErrors, areTheSameTheNextDay)
{
    const TempFolder folder;
    const CameraModel camera = endoscope();
    const Matx44d correction = motionAbout(Point3d(0, 0, 0.1), Vec3d(0.01, -0.01, 0.01), Vec3d(0.001, 0.001, -0.001));
    const Ptr<ArticulatedPoseEKF> before = learntFilter(Bench(PosedTool(0.1), correction), CableDriven(0.03, 0.02, 0.1));
    writeToolState(folder / "state.yaml", { "PSM1", "PSM2" }, { before->readingErrors(), ReadingErrors() });
    const ReadingErrors learnt = readToolState(folder / "state.yaml", "PSM1");
    EXPECT_TRUE(readToolState(folder / "state.yaml", "PSM2").names.empty());
    EXPECT_EQ(before->readingErrors().names, learnt.names);
    EXPECT_EQ(before->readingErrors().values, learnt.values);   // as decimal numbers of 17 digits
    EXPECT_EQ(before->readingErrors().reference, learnt.reference);

    // Play and gains take a travel to be learnt: the first twelve frames of another posture, with and without them.
    double error[2] = {0, 0};
    for (int known = 0; known < 2; known++)
        for (int run = 0; run < 3; run++)
        {
            Bench bench(PosedTool(0.1), correction);
            CableDriven wrist(0.03, 0.02, 0.1);
            for (int frame = 0; frame <= 40; frame++) wrist.joints(readingsAt(bench.tool, frame));
            const Ptr<ArticulatedPoseEKF> filter = bench.filter();
            if (known) filter->setReadingErrors(learnt);
            RNG rng(30 + run);
            for (int frame = 41; frame < 53; frame++)
            {
                const std::vector<double> readings = readingsAt(bench.tool, frame);
                bench.move(wrist.joints(readings));
                filter->predict(readings);
                ASSERT_TRUE(correct(*filter, camera, bench.parts, bench.seen(camera, SAME_EYE, 1, &rng), 2)) << frame;
                error[known] += rotationAngle(bench.toolPose(filter->view()), bench.toolPose(bench.tool.view)) / 36;
            }
        }
    if (std::getenv("SURGTRACK_TEST_PRINT")) std::cout << "next day: " << error[1] << " rad, " << error[0] << " rad anew" << std::endl;
    EXPECT_LT(error[1], error[0]);
}

TEST(SurgTrack_JointErrors, ofAnotherToolAreRefused)
{
    const Ptr<ArticulatedPoseEKF> filter = Bench(PosedTool(0.1)).filter();
    const ReadingErrors good = filter->readingErrors();
    ReadingErrors bad = good;
    bad.names.pop_back();
    EXPECT_THROW(filter->setReadingErrors(bad), cv::Exception);
    bad = good;
    bad.values[0] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(filter->setReadingErrors(bad), cv::Exception);
    bad = good;
    bad.values[1] = 1e200;   // a number, of which the square is none
    EXPECT_ERROR(filter->setReadingErrors(bad), "errors.values");
    bad = good;
    bad.reference[1] = 1e200;
    EXPECT_ERROR(filter->setReadingErrors(bad), "errors.reference");
    bad = good;
    bad.covariance = Mat(good.covariance * 1e200);   // bad and good share theirs
    EXPECT_ERROR(filter->setReadingErrors(bad), "errors.covariance");
    bad = good;
    bad.covariance = Mat(-good.covariance);
    EXPECT_THROW(filter->setReadingErrors(bad), cv::Exception);
    bad = good;
    bad.covariance = good.covariance(Range(0, 2), Range(0, 2)).clone();
    EXPECT_THROW(filter->setReadingErrors(bad), cv::Exception);
    bad = good;
    bad.reference.clear();
    EXPECT_THROW(filter->setReadingErrors(bad), cv::Exception);
    filter->setReadingErrors(good);
    filter->setReadingErrors(ReadingErrors());
    EXPECT_EQ(good.names, filter->readingErrors().names);
}

TEST(SurgTrack_JointErrors, priorsOfTheToolFileReplaceTheDefaults)
{
    const Ptr<ToolModel> driver = ToolModel::needleDriver();
    ToolModel::Description d = driver->description();
    for (ToolModel::Link& link : d.links)
    {
        if (link.coordinate == driver->coordinateIndex("q5")) link.gainDeviation = 0.2;
        if (link.coordinate == driver->coordinateIndex("q6")) link.playDeviation = link.couplingDeviation = 0;
    }
    const TempFolder folder;
    ToolModel::create(d)->save(folder / "tool.yaml");
    const ReadingErrors errors = ArticulatedPoseEKF::create(ToolModel::load(folder / "tool.yaml"), Matx44d::eye())->readingErrors();
    const ArticulatedPoseEKF::Params params;
    const std::vector<String> expected = {"q4 offset", "q5 offset", "q6 offset", "jaw offset", "q4 gain", "q4 play", "q5 gain", "q5 play", "q5 coupling",
                                          "q6 gain", "jaw gain", "jaw play", "delay"};
    ASSERT_EQ(expected, errors.names);
    EXPECT_DOUBLE_EQ(0.2, std::sqrt(errors.covariance.at<double>(6, 6)));
    EXPECT_DOUBLE_EQ(params.gain, std::sqrt(errors.covariance.at<double>(4, 4)));
    EXPECT_DOUBLE_EQ(params.coupling, std::sqrt(errors.covariance.at<double>(8, 8)));

    for (ToolModel::Link& link : d.links)
        if (link.jointType == ToolModel::JOINT_PRISMATIC) link.gainDeviation = 0.1;
    EXPECT_THROW(ToolModel::create(d), cv::Exception);
}

TEST(SurgTrack_JointErrors, playIsHungInUntilItsOtherEndIsReached)
{
    const Bench bench(PosedTool(0.1));
    const Ptr<ArticulatedPoseEKF> filter = bench.filter();
    std::vector<double> q = bench.tool.joints;
    filter->predict(q);
    for (size_t i = 0; i < q.size(); i++) EXPECT_EQ(0, filter->state().directions[i]) << i;   // nobody knows
    // One coordinate forth, one back, one not at all: steps of a quarter of half the play, 0.02 rad.
    for (int step = 1; step <= 9; step++)
    {
        q[3] += 0.005;
        q[4] -= 0.005;
        filter->predict(q);
        EXPECT_NEAR(std::min(1., step / 4.), filter->state().directions[3], 1e-12) << step;   // rounding
        EXPECT_NEAR(-std::min(1., step / 4.), filter->state().directions[4], 1e-12) << step;
        EXPECT_EQ(0, filter->state().directions[5]);
    }
    EXPECT_EQ(1, filter->state().directions[3]);
    EXPECT_EQ(-1, filter->state().directions[4]);
    // Back through the whole play, by a jump farther than it is.
    q[3] -= 0.02;
    filter->predict(q);
    EXPECT_NEAR(0, filter->state().directions[3], 1e-12);
    q[3] -= 1;
    filter->predict(q);
    EXPECT_EQ(-1, filter->state().directions[3]);
}

TEST(SurgTrack_JointErrors, aCopyTravelsFromWhereTheOriginalDid)
{
    const CameraModel camera = endoscope();
    Bench bench(PosedTool(0.1));
    CableDriven wrist(0.03, 0.02, 0.1);
    const Ptr<ArticulatedPoseEKF> filter = bench.filter(), copy = bench.filter(), value = bench.filter();
    for (int frame = 0; frame < 30; frame++)
    {
        const std::vector<double> readings = readingsAt(bench.tool, frame);
        bench.move(wrist.joints(readings));
        filter->predict(readings);
        ASSERT_TRUE(correct(*filter, camera, bench.parts, bench.seen(camera)));
    }
    copy->predict(joints(bench.tool, 0, 0, 0, 0));   // of other first readings, and hanging elsewhere
    copy->predict(joints(bench.tool, 1, 1, 1, 1));
    filter->copyTo(*copy);
    const ArticulatedPoseEKF::State before = filter->state();
    value->setState(before);
    const std::vector<double> first = readingsAt(bench.tool, 0);
    for (size_t i = 0; i < first.size(); i++)
    {
        EXPECT_EQ(first[i], before.reference[i]) << i;
        EXPECT_EQ(before.reference[i], copy->state().reference[i]) << i;
        EXPECT_EQ(before.directions[i], copy->state().directions[i]) << i;
    }
    for (int frame = 30; frame < 60; frame++)
    {
        const std::vector<double> readings = readingsAt(bench.tool, frame);
        bench.move(wrist.joints(readings));
        for (const Ptr<ArticulatedPoseEKF>& f : {filter, copy, value})
        {
            f->predict(readings);
            ASSERT_TRUE(correct(*f, camera, bench.parts, bench.seen(camera)));
            EXPECT_EQ(filter->offsets(), f->offsets()) << frame;   // the same, bit for bit
            EXPECT_EQ(0, cvtest::norm(filter->covariance(), f->covariance(), NORM_INF)) << frame;
        }
    }
    // Back to what it was, however far it has gone meanwhile.
    filter->setState(before);
    value->setState(before);
    for (const Ptr<ArticulatedPoseEKF>& f : {filter, value}) f->predict(readingsAt(bench.tool, 30));
    EXPECT_EQ(filter->offsets(), value->offsets());
}

TEST(SurgTrack_JointErrors, aFilterThatIsResetIsANewOne)
{
    const CameraModel camera = endoscope();
    Bench bench(PosedTool(0.1));
    const Ptr<ArticulatedPoseEKF> filter = bench.filter(), fresh = bench.filter();
    for (int frame = 0; frame < 20; frame++)
    {
        filter->predict(readingsAt(bench.tool, frame));
        correct(*filter, camera, bench.parts, bench.seen(camera));
    }
    filter->reset();
    for (int frame = 20; frame < 30; frame++)
        for (const Ptr<ArticulatedPoseEKF>& f : {filter, fresh})
        {
            const std::vector<double> readings = readingsAt(bench.tool, frame);
            bench.move(readings);
            f->predict(readings);
            correct(*f, camera, bench.parts, bench.seen(camera));
            EXPECT_EQ(filter->offsets(), f->offsets()) << frame;
            EXPECT_EQ(0, cvtest::norm(filter->covariance(), f->covariance(), NORM_INF)) << frame;
        }
}

}} // namespace
