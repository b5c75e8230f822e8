// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_common.hpp"

#include <cstdlib>
#include <fstream>
#include <limits>
#include "opencv2/core/utils/filesystem.hpp"
#include "opencv2/videoio.hpp"

namespace opencv_test { namespace {

const double frameTime = 0.04;   // all sequences here have 25 frames/s

String textOf(const String& filename)
{
    std::ifstream file(filename.c_str(), std::ios::binary);
    return String((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
}

// A copy of a sequence whose joint readings are recorded at other times. Video and tools stay where they are.
class ShiftedCopy
{
public:
    explicit ShiftedCopy(const String& source) : folder_(cv::tempfile("")), records_(textOf(source + "/kinematics.csv"))
    {
        CV_Assert(cv::utils::fs::createDirectories(folder_));
        std::istringstream in(textOf(source + "/sequence.yaml"));
        std::ofstream out((folder_ + "/sequence.yaml").c_str());
        const String base = cv::utils::fs::canonical(source);
        for (std::string line; std::getline(in, line);)
        {
            const size_t video = line.find("video: \""), path = video == String::npos ? line.find("model: \"") : video;
            if (path != String::npos && line[path + 8] != '/') line.insert(path + 8, base + "/");
            out << line << "\n";
        }
        CV_Assert(out.good());
    }
    ~ShiftedCopy() { cv::utils::fs::remove_all(folder_); }

    /* shifts: the records are written once for each, that much later, in this order
       first, last: times of records that are kept
       still: all records are like the first */
    Ptr<Sequence> sequence(const std::vector<double>& shifts, double first = -1e9, double last = 1e9, bool still = false) const
    {
        {
            std::ofstream out((folder_ + "/kinematics.csv").c_str());
            for (size_t i = 0; i < shifts.size(); i++)
            {
                std::istringstream in(records_);
                std::string line, rest;
                std::getline(in, line);
                if (i == 0) out << line << "\n";
                while (std::getline(in, line))
                {
                    const double time = std::atof(line.c_str()) + shifts[i];
                    if (rest.empty() || !still) rest = line.substr(line.find(','));
                    if (time >= first && time <= last) out << cv::format("%.4f", time) << rest << "\n";
                }
            }
            CV_Assert(out.good());
        }
        return Sequence::load(folder_);
    }
    Ptr<Sequence> sequence(double shift) const { return sequence(std::vector<double>(1, shift)); }

private:
    String folder_, records_;
};

// Half the default number of frames, for the tests' time.
TimeOffsetParams fewFrames()
{
    TimeOffsetParams params;
    params.frames = 24;
    return params;
}

// The built-in scene, written once for all tests: 6.4 s, so that its period is longer than the range of the search.
class SurgTrack_TimeOffset : public testing::Test
{
protected:
    static void SetUpTestCase()
    {
        folder = new String(cv::tempfile(""));
        SyntheticScene::Params params;
        params.frames = 160;
        SyntheticScene::create(needleDriver(), params)->write(*folder);
    }
    static void TearDownTestCase()
    {
        cv::utils::fs::remove_all(*folder);
        delete folder;
        folder = 0;
    }
    static String* folder;
};

String* SurgTrack_TimeOffset::folder = 0;

// Half a frame is half of what is asked for; the estimate's own deviation is 5 ms.
const double tolerance = frameTime / 2;

TEST_F(SurgTrack_TimeOffset, isFoundAnywhereInTheRange)
{
    const ShiftedCopy copy(*folder);
    const double offsets[] = { 0, -75 * frameTime, -0.237, 60 * frameTime };
    for (int i = 0; i < 4; i++)
    {
        TimeOffset found;
        EXPECT_TRUE(estimateTimeOffset(copy.sequence(offsets[i]), found, fewFrames())) << found.reason;
        EXPECT_NEAR(offsets[i], found.offset, tolerance);
        EXPECT_GT(found.deviation, 0);
        EXPECT_LE(found.deviation, fewFrames().maxDeviation);
        EXPECT_GE(found.confidence, fewFrames().minConfidence);
        EXPECT_TRUE(found.reason.empty());
    }
}

TEST_F(SurgTrack_TimeOffset, isFoundWhereOnlyPartOfTheVideoHasReadings)
{
    const ShiftedCopy copy(*folder);
    const double offset = 60 * frameTime, length = 160 * frameTime;
    TimeOffset found;
    EXPECT_TRUE(estimateTimeOffset(copy.sequence(std::vector<double>(1, offset), 0, length), found, fewFrames())) << found.reason;
    EXPECT_NEAR(offset, found.offset, tolerance);
    EXPECT_TRUE(estimateTimeOffset(copy.sequence(std::vector<double>(1, -offset), 0, length), found, fewFrames())) << found.reason;
    EXPECT_NEAR(-offset, found.offset, tolerance);
}

TEST_F(SurgTrack_TimeOffset, isSoughtAboutTheExpectedOne)
{
    const ShiftedCopy copy(*folder);
    TimeOffsetParams params = fewFrames();
    params.expected = 1e5;   // another clock
    params.range = 0.6;
    TimeOffset found;
    EXPECT_TRUE(estimateTimeOffset(copy.sequence(1e5 + 0.4), found, params)) << found.reason;
    EXPECT_NEAR(1e5 + 0.4, found.offset, tolerance);
}

TEST_F(SurgTrack_TimeOffset, isTheSameEachTime)
{
    const Ptr<Sequence> sequence = Sequence::load(*folder);
    TimeOffsetParams params = fewFrames();
    params.range = 0.16;
    TimeOffset first, second;
    EXPECT_TRUE(estimateTimeOffset(sequence, first, params)) << first.reason;
    EXPECT_TRUE(estimateTimeOffset(sequence, second, params)) << second.reason;
    EXPECT_EQ(first.offset, second.offset);
    EXPECT_EQ(first.deviation, second.deviation);
    EXPECT_EQ(first.confidence, second.confidence);
    EXPECT_EQ(first.support, second.support);
}

TEST_F(SurgTrack_TimeOffset, isNotToldBeyondTheRange)
{
    const ShiftedCopy copy(*folder);
    TimeOffsetParams params = fewFrames();
    params.range = 1;
    TimeOffset found;
    EXPECT_FALSE(estimateTimeOffset(copy.sequence(2.), found, params)) << found.offset;
    EXPECT_FALSE(found.reason.empty());
}

TEST_F(SurgTrack_TimeOffset, isNotToldWithoutOverlap)
{
    const ShiftedCopy copy(*folder);
    TimeOffset found;
    EXPECT_FALSE(estimateTimeOffset(copy.sequence(1000.), found));
    EXPECT_NE(String::npos, found.reason.find("0.00 s of the video")) << found.reason;
    // 1 s of readings, 1.5 s are wanted
    EXPECT_FALSE(estimateTimeOffset(copy.sequence(std::vector<double>(1, 0.), 2, 3), found, fewFrames()));
    EXPECT_NE(String::npos, found.reason.find("of the video")) << found.reason;
}

TEST_F(SurgTrack_TimeOffset, isNotToldFromReadingsThatStandStill)
{
    const ShiftedCopy copy(*folder);
    TimeOffset found;
    EXPECT_FALSE(estimateTimeOffset(copy.sequence(std::vector<double>(1, 0.), -1e9, 1e9, true), found, fewFrames()));
    EXPECT_FALSE(found.reason.empty());
}

// A scene written for one test.
class SurgTrack_TimeOffsetScene : public testing::Test
{
protected:
    void SetUp() CV_OVERRIDE { folder = cv::tempfile(""); }
    void TearDown() CV_OVERRIDE { cv::utils::fs::remove_all(folder); }
    String folder;
};

// Arms whose clocks differ, each found alone.
TEST_F(SurgTrack_TimeOffsetScene, isFoundOfEachArm)
{
    SyntheticScene::Params params;
    params.frames = 160;
    params.tools = 2;
    SyntheticScene::create(needleDriver(), params)->write(folder);
    const double offsets[] = { 0.2, -0.36 };
    std::istringstream in(textOf(folder + "/kinematics.csv"));
    std::ostringstream out;
    std::string line;
    std::getline(in, line);
    out << line << "\n";
    while (std::getline(in, line))
        out << cv::format("%.4f", std::atof(line.c_str()) + offsets[line.find("PSM2") != String::npos]) << line.substr(line.find(',')) << "\n";
    std::ofstream((folder + "/kinematics.csv").c_str()) << out.str();
    const Ptr<Sequence> sequence = Sequence::load(folder);
    TimeOffsetParams options = fewFrames();
    options.range = 1;
    for (options.tool = 0; options.tool < 2; options.tool++)
    {
        TimeOffset found;
        EXPECT_TRUE(estimateTimeOffset(sequence, found, options)) << found.reason;
        EXPECT_NEAR(offsets[options.tool], found.offset, tolerance);
    }
}

TEST_F(SurgTrack_TimeOffsetScene, isNotToldFromAToolThatStandsStill)
{
    SyntheticScene::Params params;
    params.frames = 4;
    const Ptr<SyntheticScene> scene = SyntheticScene::create(needleDriver(), params);
    scene->write(folder);
    Mat image;
    scene->render(0, image);
    {
        VideoWriter video;
        if (!video.open(folder + "/left.mp4", VideoWriter::fourcc('m', 'p', '4', 'v'), params.fps, image.size()))
            throw SkipTestException("this OpenCV cannot write videos");
        for (int i = 0; i < 60; i++) video.write(image);
    }
    // The records of one instant, for 20 s; those of the scene take 0.16 s.
    const ShiftedCopy copy(folder);
    std::vector<double> shifts;
    for (int i = 0; i < 100; i++) shifts.push_back(-10 + 0.2 * i);
    TimeOffset found;
    TimeOffsetParams options = fewFrames();
    options.range = 1;
    EXPECT_FALSE(estimateTimeOffset(copy.sequence(shifts, -1e9, 1e9, true), found, options));
    EXPECT_GT(found.support, 0.6) << "the tool itself is found";
    EXPECT_NE(String::npos, found.reason.find("move too little")) << found.reason;
}

TEST_F(SurgTrack_TimeOffsetScene, isNotToldFromMotionThatRepeatsItself)
{
    SyntheticScene::Params params;
    params.frames = 50;   // a period of 2 s
    SyntheticScene::create(needleDriver(), params)->write(folder);
    const ShiftedCopy copy(folder);
    std::vector<double> shifts;
    for (int i = -2; i <= 2; i++) shifts.push_back(2. * i);
    TimeOffsetParams wide = fewFrames();
    wide.range = 2.2;
    TimeOffset found;
    EXPECT_FALSE(estimateTimeOffset(copy.sequence(shifts, -4, 5.985), found, wide));
    EXPECT_NE(String::npos, found.reason.find("another offset")) << found.reason;
    // A range that holds one period only leaves no doubt.
    TimeOffsetParams narrow = fewFrames();
    narrow.range = 0.8;
    EXPECT_TRUE(estimateTimeOffset(copy.sequence(shifts, -4, 5.985), found, narrow)) << found.reason;
    EXPECT_NEAR(0, found.offset, tolerance);
}

TEST_F(SurgTrack_TimeOffset, refusesBadArguments)
{
    TimeOffset found;
    EXPECT_THROW(estimateTimeOffset(Ptr<Sequence>(), found), cv::Exception);
    const Ptr<Sequence> sequence = Sequence::load(*folder);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    std::vector<TimeOffsetParams> bad(12);
    bad[0].expected = nan;
    bad[1].range = -1;
    bad[2].range = nan;
    bad[3].step = 0;
    bad[4].step = 1e-9;
    bad[5].frames = 3;
    bad[6].minOverlap = nan;
    bad[7].minConfidence = 1.5;
    bad[8].maxDeviation = 0;
    bad[9].maxDeviation = nan;
    bad[10].tool = -2;
    bad[11].tool = 1;
    for (size_t i = 0; i < bad.size(); i++) EXPECT_THROW(estimateTimeOffset(sequence, found, bad[i]), cv::Exception) << i;
}

TEST_F(SurgTrack_TimeOffsetScene, namesAVideoThatCannotBeRead)
{
    SyntheticScene::Params params;
    params.frames = 4;
    SyntheticScene::create(needleDriver(), params)->write(folder);
    const Ptr<Sequence> sequence = Sequence::load(folder);
    { std::ofstream file((folder + "/left.mp4").c_str()); }
    TimeOffset found;
    try
    {
        estimateTimeOffset(sequence, found);
        ADD_FAILURE() << "no exception";
    }
    catch (const cv::Exception& e)
    {
        EXPECT_NE(String::npos, e.err.find("left.mp4")) << e.err;
    }
}

// Sequence and injected offset [frames]. Smoke and an instrument in front of the tool; a camera that moves.
typedef testing::TestWithParam<std::pair<const char*, int> > SurgTrack_TimeOffsetOfRecordings;

TEST_P(SurgTrack_TimeOffsetOfRecordings, isFound)
{
    const String source = recorded(String("sequences/") + GetParam().first);
    if (!VideoCapture(Sequence::load(source)->leftVideo()).isOpened()) throw SkipTestException("this OpenCV cannot read the video");
    const ShiftedCopy copy(source);
    const double offset = GetParam().second * frameTime;
    TimeOffsetParams params = fewFrames();
    params.range = 2;
    TimeOffset found;
    EXPECT_TRUE(estimateTimeOffset(copy.sequence(offset), found, params)) << found.reason;
    EXPECT_NEAR(offset, found.offset, frameTime);   // what is asked for
}

INSTANTIATE_TEST_CASE_P(/**/, SurgTrack_TimeOffsetOfRecordings,
                        testing::Values(std::make_pair("exvivo_single", -50), std::make_pair("exvivo_dual_moved", 33)));

}} // namespace
