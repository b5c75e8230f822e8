// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_precomp.hpp"
#include <fstream>
#include "opencv2/core/affine.hpp"
#include "opencv2/core/utils/filesystem.hpp"

namespace opencv_test { namespace {

using namespace cv::surgtrack;

const char* const DESCRIPTION =
    "%YAML:1.0\n---\n"
    "name: \"bench\"\n"
    "fps: 25\n"
    "image_width: 720\n"
    "image_height: 576\n"
    "left:\n"
    "   video: \"../elsewhere/left.mp4\"\n"
    "   camera_matrix: !!opencv-matrix { rows: 3, cols: 3, dt: d, data: [ 818, 0, 362, 0, 822, 284, 0, 0, 1 ] }\n"
    "   distortion_coefficients: !!opencv-matrix { rows: 1, cols: 5, dt: d, data: [ -0.2, 0.1, 0, 0, 0 ] }\n"
    "kinematics: \"kinematics.csv\"\n"
    "surgeon: \"unknown keys are fine\"\n"
    "tools:\n"
    "   -\n"
    "      name: \"PSM1\"\n"
    "      model: \"../tools/driver.yaml\"\n"
    "      camera_T_base: !!opencv-matrix { rows: 4, cols: 4, dt: d, data: [ 0, -1, 0, 0.1, 1, 0, 0, 0.2, 0, 0, 1, 0.3, 0, 0, 0, 1 ] }\n"
    "   -\n"
    "      name: \"PSM2\"\n"
    "      model: \"../tools/driver.yaml\"\n"
    "      camera_T_base: !!opencv-matrix { rows: 4, cols: 4, dt: d, data: [ 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 ] }\n";

const char* const KINEMATICS =
    "time,tool,q1,jaw\n"
    "0.00,PSM1,1,10\n"
    "0.00,PSM2,5,50\n"
    "0.01,PSM1,2,20\n"
    "0.01,PSM2,6,60\n"
    "0.03,PSM1,4,40\n"
    "0.03,PSM2,8,80\n";

const char* const TRUTH =
    "frame,time,tool,tx,ty,tz,qx,qy,qz,qw,q1,jaw\n"
    "0,0.00,PSM1,0.1,0.2,0.3,0,0,0.70710678,0.70710678,1.5,15\n"
    "7,0.28,PSM1,0.1,0.2,0.4,0,0,0,1,2.5,25\n";

String replaced(const char* text, const char* from, const char* to)
{
    String s = text;
    const size_t at = s.find(from);
    CV_Assert(at != String::npos);
    return s.replace(at, String(from).size(), to);
}

class SurgTrack_Sequence : public testing::Test
{
protected:
    void SetUp() CV_OVERRIDE
    {
        folder = cv::tempfile("");
        ASSERT_TRUE(cv::utils::fs::createDirectories(folder));
        put("sequence.yaml", DESCRIPTION);
        put("kinematics.csv", KINEMATICS);
        put("groundtruth.csv", TRUTH);
    }
    void TearDown() CV_OVERRIDE { cv::utils::fs::remove_all(folder); }

    void put(const char* name, const String& text) const
    {
        std::ofstream file(cv::utils::fs::join(folder, name).c_str(), std::ios::binary);
        file << text;
        ASSERT_TRUE(file.good());
    }

    // Loading fails with a message that has each of the words in it.
    void expectError(const char* word1, const char* word2 = "", const char* word3 = "") const
    {
        try
        {
            Sequence::load(folder);
            ADD_FAILURE() << "no exception, expected one with " << word1 << ", " << word2;
        }
        catch (const cv::Exception& e)
        {
            EXPECT_NE(String::npos, e.err.find(word1)) << e.err;
            EXPECT_NE(String::npos, e.err.find(word2)) << e.err;
            EXPECT_NE(String::npos, e.err.find(word3)) << e.err;
        }
    }
    void expectDescriptionError(const char* from, const char* to, const char* key)
    {
        put("sequence.yaml", replaced(DESCRIPTION, from, to));
        expectError("sequence.yaml", key, "expected");
    }
    void expectKinematicsError(const char* from, const char* to, const char* line, const char* what)
    {
        put("kinematics.csv", replaced(KINEMATICS, from, to));
        expectError("kinematics.csv", line, what);
    }

    String folder;
};

TEST_F(SurgTrack_Sequence, readsEveryKey)
{
    const Ptr<Sequence> s = Sequence::load(folder);
    EXPECT_EQ("bench", s->name());
    EXPECT_EQ(cv::utils::fs::join(folder, "groundtruth.csv"), s->groundTruthFile());
    EXPECT_EQ(25, s->fps());
    EXPECT_EQ(Size(720, 576), s->leftCamera().imageSize());
    EXPECT_EQ(822, s->leftCamera().fy);
    EXPECT_EQ(-0.2, s->leftCamera().k[0]);
    EXPECT_FALSE(s->isStereo());
    EXPECT_EQ(cv::utils::fs::join(folder, "../elsewhere/left.mp4"), s->leftVideo());
    ASSERT_EQ(2, s->toolCount());
    EXPECT_EQ("PSM2", s->tool(1).name);
    EXPECT_EQ(cv::utils::fs::join(folder, "../tools/driver.yaml"), s->tool(0).model);
    EXPECT_EQ(0.2, s->tool(0).nominal_T_base(1, 3));
    EXPECT_EQ(-1, s->tool(0).nominal_T_base(0, 1));
    EXPECT_ANY_THROW(s->tool(2));
}

TEST_F(SurgTrack_Sequence, loadsFromFolderOrFile)
{
    EXPECT_EQ(2, Sequence::load(cv::utils::fs::join(folder, "sequence.yaml"))->toolCount());
    EXPECT_EQ(2, Sequence::load(folder + "/")->toolCount());
}

TEST_F(SurgTrack_Sequence, stereoNeedsTheTransformBetweenTheEyes)
{
    const char* const right =
        "right:\n"
        "   video: \"/videos/right.mp4\"\n"
        "   camera_matrix: !!opencv-matrix { rows: 3, cols: 3, dt: d, data: [ 800, 0, 362, 0, 822, 284, 0, 0, 1 ] }\n"
        "   distortion_coefficients: !!opencv-matrix { rows: 1, cols: 4, dt: d, data: [ 0, 0, 0, 0 ] }\n";
    put("sequence.yaml", String(DESCRIPTION) + right);
    expectError("sequence.yaml", "right_T_left", "missing");
    put("sequence.yaml", String(DESCRIPTION) + right +
        "right_T_left: !!opencv-matrix { rows: 4, cols: 4, dt: d, data: [ 1, 0, 0, -0.005, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 ] }\n");
    const Ptr<Sequence> s = Sequence::load(folder);
    EXPECT_TRUE(s->isStereo());
    EXPECT_EQ("/videos/right.mp4", s->rightVideo());
    EXPECT_EQ(800, s->rightCamera().fx);
    EXPECT_EQ(-0.005, s->right_T_left()(0, 3));
}

TEST_F(SurgTrack_Sequence, interpolatesJointsBetweenTheNearestRecords)
{
    const Ptr<Sequence> s = Sequence::load(folder);
    std::vector<double> joints;
    ASSERT_TRUE(s->jointsAt(0, 0.02, joints));   // halfway between the records at 0.01 and 0.03
    ASSERT_EQ(2u, joints.size());
    EXPECT_NEAR(3, joints[0], 1e-12);            // rounding
    EXPECT_NEAR(30, joints[1], 1e-12);           // rounding
    ASSERT_TRUE(s->jointsAt(1, 0.0025, joints));
    EXPECT_NEAR(5.25, joints[0], 1e-12);         // rounding
    ASSERT_TRUE(s->jointsAt(0, 0.03, joints));
    EXPECT_EQ(4, joints[0]);
}

TEST_F(SurgTrack_Sequence, holdsJointsForOneIntervalBeyondTheRecordsAndNoLonger)
{
    const Ptr<Sequence> s = Sequence::load(folder);
    std::vector<double> joints;
    EXPECT_TRUE(s->jointsAt(0, 0.044, joints));   // mean interval: 0.015 s
    EXPECT_EQ(4, joints[0]);
    EXPECT_TRUE(s->jointsAt(0, -0.014, joints));
    EXPECT_EQ(1, joints[0]);
    EXPECT_FALSE(s->jointsAt(0, 0.046, joints));
    EXPECT_FALSE(s->jointsAt(0, -0.016, joints));
    EXPECT_FALSE(s->jointsAt(0, std::numeric_limits<double>::quiet_NaN(), joints));
    EXPECT_EQ(1, joints[0]) << "false must leave the joints alone";
    EXPECT_EQ(0.03, s->lastTime(0));
}

TEST_F(SurgTrack_Sequence, framesHaveTheirOwnTimes)
{
    EXPECT_FALSE(Sequence::load(folder)->hasFrameTimes());
    EXPECT_EQ(0.4, Sequence::load(folder)->frameTime(10));
    put("frames.csv", "frame,stamp\n1,100.00\n2,100.04\n4,100.20\n5,100.24\n");
    const Ptr<Sequence> s = Sequence::load(folder);
    EXPECT_TRUE(s->hasFrameTimes());
    EXPECT_NEAR(99.96, s->frameTime(0), 1e-9);    // rounding, also below; 1 / fps before the first
    EXPECT_NEAR(100.04, s->frameTime(2), 1e-9);
    EXPECT_NEAR(100.12, s->frameTime(3), 1e-9);   // between
    EXPECT_NEAR(100.28, s->frameTime(6), 1e-9);
    put("frames.csv", "frame,stamp\n1,100.00\n2,99\n");
    expectError("frames.csv", "line 3", "rise");
}

TEST_F(SurgTrack_Sequence, toolsMayHaveClocksOfTheirOwn)
{
    put("sequence.yaml", replaced(DESCRIPTION, "name: \"PSM1\"", "name: \"PSM1\"\n      time_offset: 0.01"));
    const Ptr<Sequence> s = Sequence::load(folder);
    EXPECT_EQ(0.01, s->tool(0).timeOffset);
    EXPECT_EQ(0, s->tool(1).timeOffset);
    std::vector<double> joints;
    ASSERT_TRUE(s->jointsAt(0, 0.01, joints));
    EXPECT_NEAR(3, joints[0], 1e-12);             // rounding: of 0.02 s on the robot's clock
    EXPECT_NEAR(0.02, s->lastTime(0), 1e-12);
}

TEST_F(SurgTrack_Sequence, metresAreNotMillimetres)
{
    expectDescriptionError("1, 0, 0, 0.2", "1, 0, 0, 200", "camera_T_base");
}

TEST_F(SurgTrack_Sequence, findsColumnsByName)
{
    put("kinematics.csv", "jaw,current,tool,time,q1\r\n10,0,PSM1,0,1\r\n20,0,PSM2,0,2\r\n");
    const Ptr<Sequence> s = Sequence::load(folder);
    std::vector<String> wanted(1, "q1");
    wanted.push_back("jaw");
    std::vector<double> joints;
    ASSERT_TRUE(s->jointsAt(1, 0, joints, wanted));
    EXPECT_EQ(2, joints[0]);
    EXPECT_EQ(20, joints[1]);
    wanted.push_back("q9");
    try
    {
        s->jointsAt(1, 0, joints, wanted);
        ADD_FAILURE() << "expected an exception";
    }
    catch (const cv::Exception& e)
    {
        EXPECT_NE(String::npos, e.err.find("'q9'")) << e.err;
    }
}

TEST_F(SurgTrack_Sequence, readsGroundTruth)
{
    const Ptr<Sequence> s = Sequence::load(folder);
    EXPECT_TRUE(s->hasGroundTruth());
    EXPECT_EQ(8, s->groundTruthEnd());
    Matx44d T;
    std::vector<double> joints;
    ASSERT_TRUE(s->groundTruth(0, 0, T, joints));
    const Matx44d expected(0, -1, 0, 0.1, 1, 0, 0, 0.2, 0, 0, 1, 0.3, 0, 0, 0, 1);
    EXPECT_LT(cvtest::norm(Mat(T), Mat(expected), NORM_INF), 1e-12);   // the quaternion is normalised, only rounding is left
    ASSERT_EQ(2u, joints.size());
    EXPECT_EQ(15, joints[1]);
    EXPECT_FALSE(s->groundTruth(0, 1, T, joints));
    EXPECT_FALSE(s->groundTruth(1, 0, T, joints));
}

TEST_F(SurgTrack_Sequence, groundTruthMayLackJointsOrBeAbsent)
{
    put("groundtruth.csv", "frame,tool,tx,ty,tz,qx,qy,qz,qw\n3,PSM2,0,0,0.1,0,0,0,-1\n");
    Matx44d T;
    std::vector<double> joints(1);
    EXPECT_TRUE(Sequence::load(folder)->groundTruth(1, 3, T, joints));
    EXPECT_TRUE(joints.empty());
    cv::utils::fs::remove_all(cv::utils::fs::join(folder, "groundtruth.csv"));
    EXPECT_FALSE(Sequence::load(folder)->hasGroundTruth());
    EXPECT_EQ(0, Sequence::load(folder)->groundTruthEnd());
}

TEST_F(SurgTrack_Sequence, readsKeypoints)
{
    put("keypoints.csv", "frame,tool,keypoint,u,v,x,y,z,visible\n"
                         "3,PSM1,tip,10.5,20,0.01,0.02,0.1,1\n"
                         "3,PSM2,tip,30,40,0,0,0.2,1\n"
                         "3,PSM1,pivot,-5,60,,,,0\n");
    const Ptr<Sequence> s = Sequence::load(folder);
    EXPECT_TRUE(s->hasKeypoints());
    EXPECT_EQ(cv::utils::fs::join(folder, "keypoints.csv"), s->keypointsFile());
    const std::vector<TrueKeypoint> points = s->keypoints(0, 3);
    ASSERT_EQ(2u, points.size());
    EXPECT_EQ("tip", points[0].name);
    EXPECT_EQ(Point2d(10.5, 20), points[0].imagePoint);
    EXPECT_EQ(Point3d(0.01, 0.02, 0.1), points[0].cameraPoint);
    EXPECT_TRUE(points[0].visible);
    EXPECT_EQ("pivot", points[1].name);
    EXPECT_EQ(Point3d(), points[1].cameraPoint) << "no x, y, z";
    EXPECT_FALSE(points[1].visible);
    EXPECT_EQ(1u, s->keypoints(1, 3).size());
    EXPECT_TRUE(s->keypoints(0, 2).empty());
    EXPECT_THROW(s->keypoints(2, 3), cv::Exception);
}

TEST_F(SurgTrack_Sequence, keypointsMayLackColumnsAndPointsOrBeAbsentOrElsewhere)
{
    EXPECT_FALSE(Sequence::load(folder)->hasKeypoints());
    EXPECT_TRUE(Sequence::load(folder)->keypoints(0, 0).empty());
    put("keypoints.csv", "frame,tool,keypoint,u,v,x,y,z,visible\n");
    EXPECT_TRUE(Sequence::load(folder)->hasKeypoints()) << "of the header alone";
    EXPECT_TRUE(Sequence::load(folder)->keypoints(0, 0).empty());
    put("labels.csv", "keypoint,frame,tool,visible,u,v\ntip,0,PSM1,1,7,8\n");
    put("sequence.yaml", replaced(DESCRIPTION, "kinematics:", "keypoints: \"labels.csv\"\nkinematics:"));
    const std::vector<TrueKeypoint> points = Sequence::load(folder)->keypoints(0, 0);
    ASSERT_EQ(1u, points.size());
    EXPECT_EQ(Point2d(7, 8), points[0].imagePoint);
    EXPECT_FALSE(Sequence::load(folder, false)->hasKeypoints()) << "without its recording";
}

TEST_F(SurgTrack_Sequence, errorsNameFileAndLineOfTheKeypoints)
{
    const char* const lines[] = { "0,PSM3,tip,1,2,1", "0,PSM1,tip,1,2,2", "0,PSM1,tip,1,x,1", "-1,PSM1,tip,1,2,1" };
    const char* const words[] = { "PSM3", "visible", "v is 'x'", "frame" };
    for (int i = 0; i < 4; i++)
    {
        put("keypoints.csv", String("frame,tool,keypoint,u,v,visible\n") + lines[i] + "\n");
        const Ptr<Sequence> s = Sequence::load(folder);   // who does not ask for them is not told
        for (int again = 0; again < 2; again++)
            try
            {
                s->keypoints(0, 0);
                ADD_FAILURE() << "no exception, expected one with " << words[i];
            }
            catch (const cv::Exception& e)
            {
                EXPECT_NE(String::npos, e.err.find("keypoints.csv, line 2")) << e.err;
                EXPECT_NE(String::npos, e.err.find(words[i])) << e.err;
            }
    }
}

TEST_F(SurgTrack_Sequence, errorsNameFileAndKeyOfTheDescription)
{
    expectDescriptionError("fps: 25\n", "", "key fps: missing");
    expectDescriptionError("fps: 25", "fps: 0", "key fps");
    expectDescriptionError("fps: 25", "fps: -25", "key fps");
    expectDescriptionError("fps: 25", "fps: .Nan", "key fps");
    expectDescriptionError("fps: 25", "fps: \"25\"", "key fps");
    expectDescriptionError("image_width: 720", "image_width: 0", "key image_width");
    expectDescriptionError("video: \"../elsewhere/left.mp4\"\n", "\n", "key left.video");
    expectDescriptionError("rows: 3, cols: 3, dt: d, data: [ 818, 0, 362, 0, 822, 284, 0, 0, 1 ]", "rows: 2, cols: 2, dt: d, data: [ 818, 0, 362, 1 ]",
                           "key left.camera_matrix");
    expectDescriptionError("cols: 5, dt: d, data: [ -0.2, 0.1, 0, 0, 0 ]", "cols: 3, dt: d, data: [ -0.2, 0.1, 0 ]", "key left.distortion_coefficients");
    expectDescriptionError("rows: 4, cols: 4, dt: d, data: [ 0, -1, 0, 0.1, 1, 0, 0, 0.2, 0, 0, 1, 0.3, 0, 0, 0, 1 ]",
                           "rows: 3, cols: 4, dt: d, data: [ 0, -1, 0, 0.1, 1, 0, 0, 0.2, 0, 0, 1, 0.3 ]", "key tools[0].camera_T_base");
    expectDescriptionError("[ 0, -1, 0, 0.1, 1,", "[ 0, -2, 0, 0.1, 1,", "key tools[0].camera_T_base");      // scaled
    expectDescriptionError("[ 0, -1, 0, 0.1, 1,", "[ 0, 1, 0, 0.1, 1,", "key tools[0].camera_T_base");       // mirrored
    expectDescriptionError("[ 0, -1, 0, 0.1, 1,", "[ 0, -1, 0, .Nan, 1,", "key tools[0].camera_T_base");
    expectDescriptionError("name: \"PSM2\"", "name: \"PSM1\"", "key tools[1].name");
    expectDescriptionError("      model: \"../tools/driver.yaml\"\n", "", "key tools[0].model");
}

TEST_F(SurgTrack_Sequence, errorsNameFileOfAMissingOrBrokenDescription)
{
    put("sequence.yaml", "not a description");
    expectError("sequence.yaml");
    put("sequence.yaml", "");
    expectError("sequence.yaml");
    put("sequence.yaml", "%YAML:1.0\n---\nfps: [ 25,\n");
    expectError("sequence.yaml");
    cv::utils::fs::remove_all(cv::utils::fs::join(folder, "sequence.yaml"));
    expectError("sequence.yaml", "no such file");
}

TEST_F(SurgTrack_Sequence, errorsNameAKeyThatIsMisspelt)
{
    put("sequence.yaml", replaced(DESCRIPTION, "camera_T_base", "camera_T_bass"));
    expectError("tools[0].camera_T_bass: unknown key", "did you mean 'camera_T_base'?");
    put("sequence.yaml", replaced(DESCRIPTION, "fps", "fpz"));
    expectError("fpz", "did you mean 'fps'?");
}

TEST_F(SurgTrack_Sequence, errorsNameFileAndLineOfTheKinematics)
{
    expectKinematicsError("0.01,PSM1,2,20", "0.01,PSM1,2", "line 4", "expected 4");
    expectKinematicsError("0.01,PSM1,2,20", "0.01,PSM3,2,20", "line 4", "'PSM3'");
    expectKinematicsError("0.01,PSM1,2,20", "0.01,PSM1,nan,20", "line 4", "finite");
    expectKinematicsError("0.01,PSM1,2,20", "0.01,PSM1,inf,20", "line 4", "finite");
    expectKinematicsError("0.01,PSM1,2,20", "0.01,PSM1,,20", "line 4", "q1 is ''");
    expectKinematicsError("0.01,PSM1,2,20", "0.01,PSM1,2x,20", "line 4", "'2x'");
    expectKinematicsError("0.01,PSM1,2,20", "0.00,PSM1,2,20", "line 4", "does not come after");
    expectKinematicsError("time,tool", "when,tool", "line 1", "'time'");
    expectKinematicsError("time,tool,q1,jaw", "time,tool,q1,q1", "line 1", "twice");
    expectKinematicsError("0.03,PSM2,8,80\n", "0.03,PSM2,8,8", "line 7", "cut in the middle");
    expectKinematicsError("0.03,PSM2,8,80\n", "0.03,PSM", "line 7", "cut in the middle");
    put("kinematics.csv", "");
    expectError("kinematics.csv", "empty");
    put("kinematics.csv", "time,tool,q1,jaw\n0,PSM1,1,2\n");
    expectError("kinematics.csv", "'PSM2'");
    cv::utils::fs::remove_all(cv::utils::fs::join(folder, "kinematics.csv"));
    expectError("kinematics.csv", "can't be read");
}

TEST_F(SurgTrack_Sequence, errorsNameFileAndLineOfTheGroundTruth)
{
    put("groundtruth.csv", replaced(TRUTH, "0,0,0,1,2.5", "0,0,0,0,2.5"));
    expectError("groundtruth.csv", "line 3", "unit quaternion");
    put("groundtruth.csv", replaced(TRUTH, "7,0.28", "0,0.28"));
    expectError("groundtruth.csv", "line 3", "twice");
    put("groundtruth.csv", replaced(TRUTH, "7,0.28", "7.5,0.28"));
    expectError("groundtruth.csv", "line 3", "whole number");
}

std::vector<String> readLines(const String& filename)
{
    std::ifstream file(filename.c_str());
    std::vector<String> lines;
    for (std::string line; std::getline(file, line);)
        lines.push_back(line);
    return lines;
}

TEST(SurgTrack_PoseWriter, rowsReadBackAsTheyWereWritten)
{
    const String filename = cv::tempfile(".csv");
    RNG rng(7);
    std::vector<Matx44d> poses;
    {
        const Ptr<PoseWriter> writer = PoseWriter::create(filename, std::vector<String>(1, "nis"));
        for (int i = 0; i < 40; i++)
        {
            const Vec3d axis(rng.gaussian(1), rng.gaussian(1), rng.gaussian(1));
            const double angle = i % 4 == 0 ? CV_PI : rng.uniform(0., CV_PI);   // half turns: w is 0
            const Matx44d T = Affine3d(axis * (angle / cv::norm(axis)), Vec3d(0.01 * i, -0.02, 0.1)).matrix;
            poses.push_back(T);
            writer->write(i, i / 30., "PSM1", i % 4, T, std::vector<double>(1, i == 3 ? std::numeric_limits<double>::quiet_NaN() : 1.5));
            EXPECT_EQ((size_t)i + 2, readLines(filename).size()) << "a row must be in the file as soon as it is written";
        }
    }
    const std::vector<String> lines = readLines(filename);
    ASSERT_EQ(41u, lines.size());
    EXPECT_EQ("frame,time,tool,status,tx,ty,tz,qx,qy,qz,qw,nis", lines[0]);
    const char* const states[] = { "initializing", "tracking", "coasting", "lost" };
    for (int i = 0; i < 40; i++)
    {
        int frame;
        double time, t[3], q[4];
        char state[20], rest[20] = "";
        ASSERT_GE(sscanf(lines[i + 1].c_str(), "%d,%lf,PSM1,%19[a-z],%lf,%lf,%lf,%lf,%lf,%lf,%lf,%19s", &frame, &time, state, t, t + 1, t + 2, q, q + 1,
                         q + 2, q + 3, rest), 10) << lines[i + 1];
        EXPECT_EQ(i, frame);
        EXPECT_NEAR(i / 30., time, 1e-6);                    // six decimals
        EXPECT_STREQ(states[i % 4], state);
        EXPECT_STREQ(i == 3 ? "" : "1.5", rest);
        EXPECT_NEAR(1, cv::norm(Vec4d(q)), 1e-8);            // nine decimals
        EXPECT_NEAR(0.01 * i, t[0], 1e-9);                   // nine decimals
        const Vec3d v(q[0], q[1], q[2]);
        const double angle = 2 * std::atan2(cv::norm(v), q[3]);
        const Matx33d R = Affine3d(cv::norm(v) > 0 ? v * (angle / cv::norm(v)) : v).rotation();
        EXPECT_LT(cv::norm(R, poses[i].get_minor<3, 3>(0, 0), NORM_INF), 1e-8);   // nine decimals
    }
    remove(filename.c_str());
}

TEST(SurgTrack_PoseWriter, estimatesFillTheFurtherColumns)
{
    const Ptr<ToolModel> first = ToolModel::needleDriver();
    ToolModel::Description other;   // of another tool: it shares a coordinate, at another place
    other.name = "probe";
    other.coordinates.push_back("turn");
    other.coordinates.push_back("q4");
    other.links.resize(1);
    other.links[0].name = "rod";
    other.endEffectorLink = 0;
    const std::vector<Ptr<ToolModel> > models = {first, ToolModel::create(other)};
    const String filename = cv::tempfile(".csv");
    {
        const Ptr<PoseWriter> writer = PoseWriter::create(filename, {"PSM1", "PSM2"}, models, {"latency"});
        ToolEstimate e;
        e.state = STATE_TRACKING;
        e.camera_T_tool(2, 3) = 0.1;
        e.covariance = Matx66d::eye() * 4;
        e.visibleParts = 9;
        e.inliers = 7;
        e.similarity = 0.75;
        e.contourSupport = 0.5;
        e.nis = 1.25;
        e.jointOffsets = {0, 0, 0, 0.01, 0.02, 0.03, 0.04};
        writer->write(3, 0.12, "PSM1", e, std::vector<double>(1, 0.5));
        e.covariance = Matx66d::zeros();
        e.jointOffsets = {0.1, 0.2};
        writer->write(3, 0.12, "PSM2", e, std::vector<double>(1, std::numeric_limits<double>::quiet_NaN()));
        EXPECT_THROW(writer->write(3, 0.12, "PSM3", e, std::vector<double>(1, 0.)), cv::Exception);
        EXPECT_THROW(writer->write(3, 0.12, "PSM1", e), cv::Exception) << "a column without a value";
    }
    const std::vector<std::string> lines = readLines(filename);
    ASSERT_EQ(3u, lines.size());
    EXPECT_EQ("frame,time,tool,status,tx,ty,tz,qx,qy,qz,qw,visible,inliers,similarity,contour,nis,sd_rx,sd_ry,sd_rz,sd_tx,sd_ty,sd_tz,"
              "offset_q1,offset_q2,offset_q3,offset_q4,offset_q5,offset_q6,offset_jaw,latency", lines[0]);
    const std::string pose = ",tracking,0.000000000,0.000000000,0.100000000,0.000000000,0.000000000,0.000000000,1.000000000,9,7,0.75,0.5,1.25,";
    EXPECT_EQ("3,0.120000,PSM1" + pose + "2,2,2,2,2,2,0,0,0,0.01,0.02,0.03,0.04,0.5", lines[1]);
    EXPECT_EQ("3,0.120000,PSM2" + pose + ",,,,,,,,,0.2,,,,", lines[2]);
    EXPECT_THROW(PoseWriter::create(filename)->write(0, 0, "PSM1", ToolEstimate()), cv::Exception) << "not begun for estimates";
    remove(filename.c_str());
}

TEST(SurgTrack_PoseWriter, refusesWhatIsNoPose)
{
    const String filename = cv::tempfile(".csv");
    {
        const Ptr<PoseWriter> writer = PoseWriter::create(filename);
        Matx44d T = Matx44d::eye();
        T(0, 3) = std::numeric_limits<double>::infinity();
        EXPECT_THROW(writer->write(0, 0, "PSM1", STATE_TRACKING, T), cv::Exception);
        T = 2 * Matx44d::eye();
        EXPECT_THROW(writer->write(0, 0, "PSM1", STATE_TRACKING, T), cv::Exception);
        EXPECT_THROW(writer->write(0, 0, "a,b", STATE_TRACKING, Matx44d::eye()), cv::Exception);
        EXPECT_THROW(writer->write(0, 0, "PSM1", STATE_TRACKING, Matx44d::eye(), std::vector<double>(1, 0.)), cv::Exception);
    }
    EXPECT_EQ(1u, readLines(filename).size()) << "nothing but the header";
    remove(filename.c_str());
}

TEST(SurgTrack_PoseWriter, errorsNameTheFile)
{
    const String missing = cv::utils::fs::join(cv::tempfile(""), "poses.csv");
    try
    {
        PoseWriter::create(missing);
        ADD_FAILURE() << "expected an exception";
    }
    catch (const cv::Exception& e)
    {
        EXPECT_NE(String::npos, e.err.find(missing)) << e.err;
    }
#ifdef __linux__
    try
    {
        PoseWriter::create("/dev/full");
        ADD_FAILURE() << "expected an exception";
    }
    catch (const cv::Exception& e)
    {
        EXPECT_NE(String::npos, e.err.find("/dev/full")) << e.err;
    }
#endif
}

TEST(SurgTrack_PoseScorer, countsAsTheTableOfThePaper)
{
    const Matx33d K(720, 0, 360, 0, 720, 288, 0, 0, 1);
    const CameraModel camera(K, noArray(), Size(720, 576));
    const Ptr<PoseScorer> scorer = PoseScorer::create(camera, std::vector<Ptr<ToolModel> >(2, ToolModel::needleDriver()));
    Matx44d truth = Matx44d::eye(), near = truth, far = truth;
    truth(2, 3) = near(2, 3) = far(2, 3) = 0.1;
    near(0, 3) = 0.001;    // 7.2 to 8 pixel
    far(0, 3) = 0.006;     // 43 pixel and more
    scorer->add(0, STATE_TRACKING, near, truth);
    scorer->add(0, STATE_COASTING, far, truth);
    scorer->add(0, STATE_LOST, truth, truth);
    scorer->add(1, STATE_TRACKING, far, truth);
    const PoseScore s = scorer->score(0);
    EXPECT_EQ(3, s.frames);
    EXPECT_EQ(2, s.covered);
    EXPECT_NEAR(0.0035, s.translationMean, 1e-12);   // rounding
    EXPECT_NEAR(0.0025, s.translationStd, 1e-12);    // rounding
    EXPECT_NEAR(1 / 3., s.accuracy, 1e-12);          // rounding
    EXPECT_EQ(0, s.silent) << "coasting makes no claim";
    EXPECT_EQ(1, scorer->score(1).silent);
    EXPECT_EQ(4, scorer->score().frames);
}

// A pivot 0.05 m behind the end effector, whose link is fixed to the last one that moves.
Ptr<ToolModel> longTool()
{
    ToolModel::Description d;
    d.name = "hook";
    d.coordinates.push_back("turn");
    d.links.resize(2);
    d.links[0].name = "pivot";
    d.links[0].jointType = ToolModel::JOINT_REVOLUTE;
    d.links[0].coordinate = 0;
    d.links[1].name = "tip";
    d.links[1].parent = 0;
    d.endEffectorLink = 1;
    d.link_T_endEffector(0, 3) = 0.05;
    return ToolModel::create(d);
}

TEST(SurgTrack_PoseScorer, scoredPointsAreThoseOfTheTool)
{
    const CameraModel camera(Matx33d(720, 0, 360, 0, 720, 288, 0, 0, 1), noArray(), Size(720, 576));
    const std::vector<Ptr<ToolModel> > models = {ToolModel::needleDriver(), longTool()};
    const Ptr<PoseScorer> scorer = PoseScorer::create(camera, models);
    Matx44d truth = Matx44d::eye(), turned = truth;
    turned(2, 3) = truth(2, 3) = 0.1;
    // Turned by 17 degrees about the viewing axis the end effector stays. Points 0.05 m from it move by some 107 pixel, those of
    // the needle driver, which lie behind it, by 7 at most.
    turned(0, 0) = turned(1, 1) = std::cos(0.3);
    turned(1, 0) = std::sin(0.3);
    turned(0, 1) = -turned(1, 0);
    for (int tool = 0; tool < 2; tool++) scorer->add(tool, STATE_TRACKING, turned, truth);
    EXPECT_EQ(1, scorer->score(0).accuracy);
    EXPECT_EQ(0, scorer->score(1).accuracy);
    EXPECT_EQ(0, scorer->score(1).translationMean);
    EXPECT_THROW(PoseScorer::create(camera, std::vector<Ptr<ToolModel> >()), cv::Exception);
    EXPECT_THROW(PoseScorer::create(camera, std::vector<Ptr<ToolModel> >(1)), cv::Exception);
    EXPECT_THROW(PoseScorer::create(CameraModel(), models), cv::Exception);
}

}} // namespace
