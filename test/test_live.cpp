// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_common.hpp"
#include <cfloat>
#include "opencv2/core/utils/filesystem.hpp"

namespace opencv_test { namespace {

std::vector<String> names(const char* a, const char* b, const char* c = 0)
{
    std::vector<String> result;
    result.push_back(a);
    result.push_back(b);
    if (c) result.push_back(c);
    return result;
}

JointReading reading(double time, double q1, double q2, double jaw)
{
    JointReading r;
    r.time = time;
    const double positions[] = { q1, q2, jaw };
    r.positions.assign(positions, positions + 3);
    return r;
}

std::vector<JointReading> parsed(const String& message)
{
    std::vector<JointReading> readings(7);   // what was there before is gone afterwards
    parseJointMessage(message, readings);
    return readings;
}

Ptr<JointBuffer> buffer(double history = 2, double maxGap = 0.1)
{
    return JointBuffer::create(names("q1", "q2", "jaw"), history, maxGap);
}

// --- messages ---

TEST(SurgTrack_JointMessage, readsPlainOnes)
{
    std::vector<JointReading> r = parsed("{\"tool\": \"PSM1\", \"time\": 12.5, \"position\": [0.1, -2, 3e-2], \"sequence\": 7}");
    ASSERT_EQ(1u, r.size());
    EXPECT_EQ("PSM1", r[0].tool);
    EXPECT_EQ(12.5, r[0].time);
    EXPECT_EQ(std::vector<double>({ 0.1, -2., 0.03 }), r[0].positions);
    EXPECT_TRUE(r[0].names.empty());
    r = parsed("{\"time\": 1, \"name\": [\"q2\", \"q1\"], \"position\": [1, 2]}");
    ASSERT_EQ(1u, r.size());
    EXPECT_EQ("", r[0].tool);
    EXPECT_EQ(names("q2", "q1"), r[0].names);
    r = parsed("{\"time\": 1, \"position\": {\"q2\": 5, \"q1\": 6}}");
    ASSERT_EQ(1u, r.size());
    ASSERT_EQ(2u, r[0].names.size());
    EXPECT_EQ(5, r[0].positions[r[0].names[0] == "q2" ? 0 : 1]);
}

// As sawSocketStreamer sends them; the values of its README's kind of message.
TEST(SurgTrack_JointMessage, readsThoseOfTheDVRK)
{
    std::vector<JointReading> r = parsed("{\"measured_js\":{\"AutomaticTimestamp\":true,\"Effort\":[0,0],\"Name\":[\"yaw\",\"pitch\"],"
                                         "\"Position\":[-0.47,-0.23],\"Timestamp\":46.072619962,\"Valid\":true,\"Velocity\":null}}\n");
    ASSERT_EQ(1u, r.size());
    EXPECT_EQ("", r[0].tool);
    EXPECT_EQ(46.072619962, r[0].time);
    EXPECT_EQ(names("yaw", "pitch"), r[0].names);
    EXPECT_EQ(std::vector<double>({ -0.47, -0.23 }), r[0].positions);
    r = parsed("{\"jaw/measured_js\":{\"Name\":[\"outer_jaw\"],\"Position\":[0.02],\"Timestamp\":46.08,\"Valid\":true}}");
    ASSERT_EQ(1u, r.size());
    EXPECT_EQ("", r[0].tool);
    EXPECT_EQ(std::vector<String>(1, "jaw"), r[0].names);
    // Both in one, with the tool's name, and other things beside them.
    r = parsed("{\"PSM2/measured_js\":{\"Position\":[1],\"Timestamp\":1},\"PSM2/jaw/measured_js\":{\"Position\":[2],\"Timestamp\":2},"
               "\"PSM2/measured_cp\":{\"Position\":null}}");
    ASSERT_EQ(2u, r.size());
    for (size_t i = 0; i < 2; i++)
    {
        EXPECT_EQ("PSM2", r[i].tool);
        EXPECT_EQ(r[i].positions[0] == 2, !r[i].names.empty());
        EXPECT_EQ(r[i].time, r[i].positions[0]);
    }
}

TEST(SurgTrack_JointMessage, leavesOutWhatIsNotValidOrNotAboutJoints)
{
    EXPECT_TRUE(parsed("{\"measured_js\":{\"Position\":null,\"Timestamp\":46.1,\"Valid\":false}}").empty());
    EXPECT_TRUE(parsed("{\"measured_cp\":{\"Position\":{\"Translation\":[0,0,0]},\"Timestamp\":1,\"Valid\":true}}").empty());
    EXPECT_TRUE(parsed("{\"setpoint_js\":{\"Position\":[1],\"Timestamp\":1,\"Valid\":true}}").empty());
    EXPECT_TRUE(parsed("{}").empty());
}

TEST(SurgTrack_JointMessage, errorsNameTheKeyAndWhatWasExpected)
{
    EXPECT_ERROR(parsed("{\"tool\": \"PSM1\", \"time\": 1}"), "key position is missing");
    EXPECT_ERROR(parsed("{\"tool\": \"PSM1\", \"position\": [1]}"), "key time is missing");
    EXPECT_ERROR(parsed("{\"tool\": 3, \"time\": 1, \"position\": [1]}"), "key tool: expected a text");
    EXPECT_ERROR(parsed("{\"time\": \"now\", \"position\": [1]}"), "key time: expected a number");
    EXPECT_ERROR(parsed("{\"time\": 1, \"position\": [1, null]}"), "key position[1]: expected a number");
    EXPECT_ERROR(parsed("{\"time\": 1, \"position\": []}"), "key position: expected a list of numbers");
    EXPECT_ERROR(parsed("{\"time\": 1, \"position\": {\"q1\": true}}"), "key position.'q1': expected a number");
    EXPECT_ERROR(parsed("{\"time\": 1, \"position\": [1, 2], \"name\": [\"q1\"]}"), "key name: expected a list of 2 names");
    EXPECT_ERROR(parsed("{\"measured_js\": 5}"), "key 'measured_js': expected an object");
    EXPECT_ERROR(parsed("{\"measured_js\":{\"Position\":[1],\"Valid\":true}}"), "key 'measured_js'.Timestamp is missing");
    EXPECT_ERROR(parsed("{\"measured_js\":{\"Timestamp\":1,\"Valid\":1,\"Position\":[1]}}"), "Valid: expected true or false");
    EXPECT_ERROR(parsed("{\"measured_js\":{\"Timestamp\":1,\"Position\":[1],\"Name\":[\"a\",\"b\"]}}"), "Name: expected a list of 1 names");
    EXPECT_ERROR(parsed("{\"jaw/measured_js\":{\"Timestamp\":1,\"Position\":[1,2]}}"), "expected one number, found 2");
}

// Nothing that may come over a network does more than throw, and the message is one line of text.
TEST(SurgTrack_JointMessage, survivesAnything)
{
    std::vector<String> messages;
    const char* const texts[] = { "", " ", "null", "[]", "5", "\"measured_js\"", "{", "{\"time\":", "{\"time\": 1e999, \"position\": [1]}",
                                  "{\"time\": NaN, \"position\": [1]}", "{\"time\": 1, \"position\": [Infinity]}", "{} {}", "time=1", "\xff\xfe\x01{" };
    for (size_t i = 0; i < sizeof(texts) / sizeof(texts[0]); i++) messages.push_back(texts[i]);
    messages.push_back(String(60000, '['));             // a packet's most
    messages.push_back(String("{\"a\":") + String(60000, '['));
    messages.push_back(String(1, '\0') + "{}");
    const String good = "{\"tool\": \"PSM1\", \"time\": 12.5, \"position\": [0.1, -2, 3e-2]}";
    for (size_t length = 0; length < good.size(); length++) messages.push_back(good.substr(0, length));   // cut
    for (size_t i = 0; i < messages.size(); i++)
    {
        std::vector<JointReading> readings(2);
        try
        {
            parseJointMessage(messages[i], readings);
            ADD_FAILURE() << "no exception for " << messages[i];
        }
        catch (const cv::Exception& e)
        {
            EXPECT_NE(String::npos, e.err.find("expected a JSON object")) << e.err;
            EXPECT_EQ(String::npos, e.err.find('\n')) << e.err;
            EXPECT_LT(e.err.size(), 200u);
        }
        EXPECT_TRUE(readings.empty());
    }
    RNG rng(7);
    for (int i = 0; i < 2000; i++)   // one character of a good message replaced: it may be good, but nothing else happens
    {
        String message = good;
        message[rng.uniform(0, (int)message.size())] = (char)rng.uniform(1, 256);
        std::vector<JointReading> readings;
        errorText([&]() { parseJointMessage(message, readings); });
        for (size_t k = 0; k < readings.size(); k++)
            for (size_t j = 0; j < readings[k].positions.size(); j++) EXPECT_TRUE(std::isfinite(readings[k].positions[j])) << message;
    }
}

TEST(SurgTrack_PoseMessage, holdsTheEstimate)
{
    ToolEstimate e;
    e.state = STATE_TRACKING;
    e.camera_T_tool = rigid(rotationMatrix(Vec3d(0.3, -0.2, 0.5)), Point3d(0.01, -0.02, 0.11));
    for (int i = 0; i < 36; i++) e.covariance.val[i] = 0.5 * i;
    e.jointOffsets.assign(2, 0.125);
    e.inliers = 6;
    const String message = formatPoseMessage(12, 0.48, "PSM1", e);
    EXPECT_EQ(String::npos, message.find('\n'));
    EXPECT_EQ(0u, message.find("{\"frame\":12,\"time\":0.48,\"tool\":\"PSM1\",\"status\":\"tracking\",\"position\":[0.01,-0.02,0.11],")) << message;
    EXPECT_NE(String::npos, message.find("\"covariance\":[[0.0,0.5,1.0,1.5,2.0,2.5],[3.0,")) << message;
    EXPECT_NE(String::npos, message.find("\"joint_offsets\":[0.125,0.125]")) << message;
    EXPECT_NE(String::npos, message.find("\"inliers\":6")) << message;
    // The quaternion is that of the rotation.
    double q[4];
    const size_t at = message.find("\"orientation\":[");
    ASSERT_NE(String::npos, at);
    ASSERT_EQ(4, std::sscanf(message.c_str() + at, "\"orientation\":[%lf,%lf,%lf,%lf]", q, q + 1, q + 2, q + 3));
    const double sine = cv::norm(Vec3d(q));
    const Vec3d vector = Vec3d(q) * (2 * std::atan2(sine, q[3]) / sine);
    EXPECT_LT(cv::norm(vector - Vec3d(0.3, -0.2, 0.5)), 1e-8);   // nine digits
    for (int i = 0; i < 36; i++) e.covariance.val[i] = -1e-5 / 3;
    e.jointOffsets.assign(7, -0.1 / 3);
    EXPECT_LT(formatPoseMessage(123456, 1e6 / 3, "PSM1", e).size(), 1400u);   // one packet of Ethernet, with room for a long name
    e.covariance(2, 2) = NOT_A_NUMBER;
    EXPECT_ERROR(formatPoseMessage(12, 0.48, "PSM1", e), "finite");
}

// --- joints at a time ---

TEST(SurgTrack_JointBuffer, interpolatesWhateverTheOrderOfArrival)
{
    std::vector<double> times;
    for (int i = 0; i < 50; i++) times.push_back(0.01 * i);
    RNG rng(3);
    for (int run = 0; run < 20; run++)
    {
        if (run > 0) randShuffle(times, 1, &rng);
        const Ptr<JointBuffer> b = buffer();
        for (size_t i = 0; i < times.size(); i++)
        {
            EXPECT_TRUE(b->add(reading(times[i], times[i], 2 * times[i], -times[i])));
            EXPECT_FALSE(b->add(reading(times[i], 7, 7, 7)));   // twice: the first one counts
        }
        std::vector<double> joints;
        for (double t = 0; t <= 0.49; t += 0.0037)
        {
            ASSERT_EQ(JOINTS_FOUND, b->at(t, joints)) << t;
            EXPECT_NEAR(t, joints[0], 1e-12);                    // rounding
            EXPECT_NEAR(2 * t, joints[1], 1e-12);
            EXPECT_NEAR(-t, joints[2], 1e-12);
        }
        ASSERT_EQ(JOINTS_FOUND, b->at(0.01 * 7, joints));
        EXPECT_EQ(0.01 * 7, joints[0]);                          // a reading's own time: the reading
    }
}

TEST(SurgTrack_JointBuffer, saysWhyThereIsNone)
{
    const Ptr<JointBuffer> b = buffer(1, 0.05);
    std::vector<double> joints(1, 42);
    EXPECT_EQ(JOINTS_NONE, b->at(0, joints));
    EXPECT_EQ(-DBL_MAX, b->newest());
    b->add(reading(5, 1, 1, 1));
    b->add(reading(5.04, 2, 2, 2));
    b->add(reading(5.2, 3, 3, 3));
    EXPECT_EQ(5.2, b->newest());
    EXPECT_EQ(JOINTS_TOO_OLD, b->at(4.99, joints));
    EXPECT_EQ(JOINTS_TOO_NEW, b->at(5.21, joints));
    EXPECT_EQ(JOINTS_GAP, b->at(5.1, joints));
    EXPECT_EQ(JOINTS_TOO_NEW, b->at(NOT_A_NUMBER, joints));
    EXPECT_EQ(std::vector<double>(1, 42), joints);               // untouched
    EXPECT_EQ(JOINTS_FOUND, b->at(5.04, joints));
    EXPECT_EQ(std::vector<double>(3, 2), joints);
    EXPECT_EQ(JOINTS_FOUND, b->at(5.2, joints));                 // a reading at the far side of a gap
    b->add(reading(5.12, 3, 3, 3));
    EXPECT_EQ(JOINTS_GAP, b->at(5.1, joints));                   // 0.08 s, still too far
    b->clear();
    EXPECT_EQ(JOINTS_NONE, b->at(5.04, joints));
}

// Arm and jaw come in messages of their own, with times of their own.
TEST(SurgTrack_JointBuffer, keepsEachCoordinateByItself)
{
    const Ptr<JointBuffer> b = buffer();
    JointReading arm, jaw;
    arm.names = names("shoulder", "elbow");                      // no coordinates: taken in order, all but the jaw
    jaw.names = std::vector<String>(1, "jaw");
    std::vector<double> joints;
    for (int i = 0; i < 10; i++)
    {
        arm.time = 0.01 * i;
        arm.positions = { arm.time, -arm.time };
        EXPECT_TRUE(b->add(arm));
        EXPECT_EQ(i == 0 ? JOINTS_NONE : JOINTS_TOO_NEW, b->at(arm.time, joints));   // the jaw is behind
        jaw.time = arm.time + 0.003;
        jaw.positions.assign(1, 3 * jaw.time);
        EXPECT_TRUE(b->add(jaw));
        EXPECT_EQ(arm.time, b->newest());
    }
    ASSERT_EQ(JOINTS_FOUND, b->at(0.05, joints));
    EXPECT_NEAR(0.05, joints[0], 1e-12);                         // rounding, also below
    EXPECT_NEAR(-0.05, joints[1], 1e-12);
    EXPECT_NEAR(0.15, joints[2], 1e-12);
    EXPECT_EQ(JOINTS_TOO_OLD, b->at(0, joints));
    JointReading some;                                           // by name, in another order; an unknown one is passed over
    some.time = 0.2;
    some.names = names("jaw", "elbow", "q1");
    some.positions = { 1, 2, 3 };
    EXPECT_TRUE(b->add(some));
    EXPECT_EQ(0.09, b->newest());                                // q2 has nothing new
}

// The dVRK's names are those of q1 to q6 wherever they stand, with the jaw in the same message or not.
TEST(SurgTrack_JointBuffer, knowsTheNamesOfTheDVRK)
{
    const char* const coordinates[] = { "q1", "q2", "q3", "q4", "q5", "q6", "jaw" };
    const char* const sent[] = { "insertion", "outer_pitch", "roll", "wrist_pitch", "PSM1_wrist_yaw", "yaw", "jaw" };
    const double values[] = { 0.12, 0.2, 0.4, 0.5, 0.6, 0.1, 0.7 }, expected[] = { 0.1, 0.2, 0.12, 0.4, 0.5, 0.6, 0.7 };
    const Ptr<JointBuffer> b = JointBuffer::create(std::vector<String>(coordinates, coordinates + 7));
    JointReading all;
    all.names.assign(sent, sent + 7);
    all.positions.assign(values, values + 7);
    all.time = 3;
    EXPECT_TRUE(b->add(all));
    std::vector<double> joints;
    ASSERT_EQ(JOINTS_FOUND, b->at(3, joints));
    EXPECT_EQ(std::vector<double>(expected, expected + 7), joints);
}

TEST(SurgTrack_JointBuffer, refusesWhatDoesNotFit)
{
    const Ptr<JointBuffer> b = buffer();
    JointReading r = reading(1, 2, 3, 4);
    r.positions.pop_back();
    r.positions.pop_back();
    EXPECT_ERROR(b->add(r), "a reading has 1 positions without names; expected 3, or 2 without the jaw");
    r.names.push_back("elbow");
    EXPECT_ERROR(b->add(r), "whose names are no coordinates");
    r.names.push_back("wrist");
    EXPECT_ERROR(b->add(r), "one name a position");
    EXPECT_ERROR(b->add(reading(NOT_A_NUMBER, 1, 1, 1)), "finite");
    EXPECT_ERROR(b->add(reading(1, 1, NOT_A_NUMBER, 1)), "finite");
    EXPECT_EQ(-DBL_MAX, b->newest());                            // nothing of them was kept
    EXPECT_ERROR(JointBuffer::create(std::vector<String>()), "coordinates");
    EXPECT_ERROR(buffer(0), "history");
    EXPECT_ERROR(buffer(1, NOT_A_NUMBER), "maxGap");
}

TEST(SurgTrack_JointBuffer, forgetsWhatIsOldAndIsBounded)
{
    const Ptr<JointBuffer> b = buffer(0.5);
    std::vector<double> joints;
    for (int i = 0; i <= 100; i++) b->add(reading(0.01 * i, i, i, i));
    EXPECT_EQ(JOINTS_TOO_OLD, b->at(0.49, joints));
    EXPECT_EQ(JOINTS_FOUND, b->at(0.505, joints));
    EXPECT_FALSE(b->add(reading(0.495, 0, 0, 0)));               // late by more than the history
    EXPECT_TRUE(b->add(reading(0.505, 0, 0, 0)));                // by less
    for (int i = 0; i < 10000; i++) b->add(reading(1 + 1e-5 * i, i, i, i));   // a flood within the history
    EXPECT_EQ(JOINTS_TOO_OLD, b->at(1.05, joints));              // 4096 are left: from 1.059 on
    EXPECT_EQ(JOINTS_FOUND, b->at(1.06, joints));
}

// What comes over a network may be anything: it is refused, or kept apart, and never changes what is answered for other times.
TEST(SurgTrack_JointBuffer, wildReadingsChangeNothing)
{
    const Ptr<JointBuffer> b = buffer();
    std::vector<double> joints;
    for (int i = 0; i <= 100; i++) b->add(reading(0.01 * i, 1, 2, 3));
    for (const double wild : { 1e200, -1e308, 1e308, 1.1e6 }) EXPECT_ERROR(b->add(reading(0.505, wild, 0, 0)), "positions");
    for (const double time : { 1e15, -1e300, 1e300, 1.1e11 }) EXPECT_ERROR(b->add(reading(time, 0, 0, 0)), "time");
    EXPECT_FALSE(b->add(reading(1e9, 5, 5, 5)));                 // far ahead of the others, once
    EXPECT_FALSE(b->add(reading(-86400, 5, 5, 5)));
    ASSERT_EQ(JOINTS_FOUND, b->at(0.505, joints));
    EXPECT_EQ(1, joints[0]);
    EXPECT_TRUE(b->add(reading(1.01, 1, 2, 3)));
    for (const double time : { 1e15, -1e300 })
    {
        std::vector<JointReading> readings;
        EXPECT_ERROR(parseJointMessage(format("{\"time\": %g, \"position\": [1]}", time), readings), "time");
        EXPECT_ERROR(parseJointMessage("{\"time\": 1, \"position\": [1, 1e308]}", readings), "position[1]");
        EXPECT_ERROR(parseJointMessage("{\"time\": 1, \"position\": {\"q1\": -1e200}}", readings), "position.'q1'");
    }
}

// The robot was restarted, or one reading had a wrong time: after 50 that are too old it is they that are right.
TEST(SurgTrack_JointBuffer, startsAnewWhenTheClockWasSetBack)
{
    const Ptr<JointBuffer> b = buffer();
    std::vector<double> joints;
    b->add(reading(1e9, 1, 1, 1));
    for (int i = 0; i < 49; i++) EXPECT_FALSE(b->add(reading(5 + 0.01 * i, i, i, i)));
    for (int i = 49; i < 60; i++) EXPECT_TRUE(b->add(reading(5 + 0.01 * i, i, i, i)));
    ASSERT_EQ(JOINTS_FOUND, b->at(5.55, joints));
    EXPECT_NEAR(55, joints[0], 1e-9);                            // rounding of 0.01
    EXPECT_EQ(JOINTS_TOO_NEW, b->at(1e9, joints));
    // Some late ones among good ones are not in succession.
    for (int i = 0; i < 200; i++)
    {
        EXPECT_FALSE(b->add(reading(1, 0, 0, 0)));
        EXPECT_TRUE(b->add(reading(6 + 0.01 * i, 0, 0, 0)));
    }
}

// --- clocks ---

TEST(SurgTrack_ClockOffset, isTheLeastDelay)
{
    const Ptr<ClockOffset> clock = ClockOffset::create(10);
    EXPECT_EQ(0, clock->offset());
    RNG rng(5);
    const double truth = 1234.5, least = 0.0002;                 // [s]
    for (int i = 0; i < 1000; i++)
    {
        const double stamp = 0.01 * i;
        clock->add(stamp, truth + stamp + least + rng.uniform(0., 0.008));   // below the interval: arrivals are in order
    }
    EXPECT_GE(clock->offset(), truth + least - 1e-9);            // rounding
    EXPECT_LT(clock->offset(), truth + least + 0.0002);          // of 1000 delays evenly up to 8 ms, the least is below 0.2 ms (p = 1e-11 that not)
}

TEST(SurgTrack_ClockOffset, followsADriftAndABrokenStamp)
{
    const Ptr<ClockOffset> clock = ClockOffset::create(1);
    for (int i = 0; i < 10000; i++)
        clock->add(0.01 * i, 50 + 0.01 * i * (1 + 1e-4));        // 100 ppm, in 100 s
    EXPECT_NEAR(50 + 100 * 1e-4, clock->offset(), 1e-4 + 1e-6);  // the window's share of the drift, and one interval's
    clock->add(1e6, 151);
    EXPECT_LT(clock->offset(), -9e5);
    for (int i = 0; i < 110; i++) clock->add(101 + 0.01 * i, 151.01 + 0.01 * i);
    EXPECT_NEAR(50.01, clock->offset(), 1e-9);                   // out of the window
    EXPECT_ERROR(clock->add(NOT_A_NUMBER, 1), "finite");
    EXPECT_ERROR(ClockOffset::create(0), "window");
}

// --- what live use needs of a sequence ---

TEST(SurgTrack_Sequence_Setup, needsNoRecording)
{
    const String folder = cv::tempfile("");
    SyntheticScene::Params params;
    params.imageSize = Size(160, 120);
    params.frames = 1;
    SyntheticScene::create(Ptr<ToolModel>(), params)->write(folder);
    for (const char* name : { "kinematics.csv", "groundtruth.csv", "left.mp4" })
        ASSERT_EQ(0, std::remove(cv::utils::fs::join(folder, name).c_str())) << name;
    EXPECT_ERROR(Sequence::load(folder), "kinematics.csv");
    const Ptr<Sequence> s = Sequence::load(folder, false);
    EXPECT_EQ(Size(160, 120), s->leftCamera().imageSize());
    EXPECT_EQ(1, s->toolCount());
    EXPECT_FALSE(s->hasGroundTruth());
    std::vector<double> joints;
    EXPECT_ERROR(s->jointsAt(0, 0, joints), "without its recording");
    EXPECT_ERROR(s->firstTime(0), "without its recording");
    cv::utils::fs::remove_all(folder);
}

}} // namespace
