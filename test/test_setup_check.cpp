// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_import.hpp"

namespace opencv_test { namespace {

// Two arms, from a built-in scene; each test spoils a copy.
class SurgTrack_SetupCheck : public ImportTest
{
protected:
    static void SetUpTestCase()
    {
        scene() = cv::tempfile("");
        SyntheticScene::Params params;
        params.tools = 2;
        params.frames = 48;
        params.stereo = true;
        SyntheticScene::create(Ptr<ToolModel>(), params)->write(scene());
    }
    static void TearDownTestCase() { cv::utils::fs::remove_all(scene()); }

    static String& scene()
    {
        static String folder;
        return folder;
    }

    void SetUp() CV_OVERRIDE
    {
        ImportTest::SetUp();
        std::ifstream description((scene() + "/sequence.yaml").c_str()), records((scene() + "/kinematics.csv").c_str());
        std::ostringstream yaml, csv;
        yaml << description.rdbuf();
        csv << records.rdbuf();
        String text = yaml.str();
        for (size_t at = 0; (at = std::min(text.find("video: \"", at), text.find("model: \"", at))) != String::npos; at += 8)
            text.insert(at + 8, scene() + "/");
        put("sequence.yaml", text);
        put("kinematics.csv", csv.str());
        sound = Sequence::load(folder);
    }

    // Readings times factors, one per coordinate.
    void scaleReadings(const std::vector<double>& factors)
    {
        for (int tool = 0; tool < 2; tool++)
        {
            std::vector<double> times, row;
            Mat joints;
            for (double t = sound->firstTime(tool); t < sound->lastTime(tool); t += 0.02)
            {
                ASSERT_TRUE(sound->jointsAt(tool, t, row));
                for (size_t i = 0; i < row.size(); i++) row[i] *= factors[i];
                joints.push_back(Mat(row).reshape(1, 1).clone());
                times.push_back(t);
            }
            writeSequenceJoints(folder, sound->tool(tool).name, sound->jointNames(), times, joints);
        }
    }

    void shiftReadings(double shift)
    {
        std::istringstream in(get("kinematics.csv"));
        std::ostringstream out;
        std::string line;
        std::getline(in, line);
        out << line << "\n";
        while (std::getline(in, line))
            out << format("%.4f", std::atof(line.c_str()) + shift) << line.substr(line.find(',')) << "\n";
        put("kinematics.csv", out.str());
    }

    // Each finding has a line; the words are in the first one.
    void expectFinding(const std::vector<String>& words, bool stereo = false)
    {
        std::vector<String> findings, figures;
        checkSetup(Sequence::load(folder), findings, figures, stereo);
        ASSERT_FALSE(findings.empty());
        for (size_t i = 0; i < words.size(); i++)
            EXPECT_NE(String::npos, findings[0].find(words[i])) << findings[0];
    }

    Ptr<Sequence> sound;
};

TEST_F(SurgTrack_SetupCheck, hasNothingToSayOfASoundSequence)
{
    std::vector<String> findings, figures;
    checkSetup(sound, findings, figures, true);
    EXPECT_TRUE(findings.empty()) << findings[0];
    ASSERT_EQ(2u, figures.size());
    EXPECT_EQ(0u, figures[1].find("PSM2: ")) << figures[1];
}

TEST_F(SurgTrack_SetupCheck, namesUnitsOfReadings)
{
    std::vector<double> degrees(7, 180 / CV_PI), millimetres(7, 1.);
    degrees[2] = 1;
    millimetres[2] = 1000;
    scaleReadings(degrees);
    expectFinding(list("kinematics.csv", "radians, not degrees"));
    scaleReadings(millimetres);
    expectFinding(list("kinematics.csv", "metres, not millimetres"));
}

// Angles that are small enough to be some turns as radians: the calibration, or the instrument, would be blamed.
TEST_F(SurgTrack_SetupCheck, namesTheFewJointsThatAreInDegrees)
{
    for (int first = 0; first < 5; first += 4)   // q1 and q2, of the arm; q5 and q6, of the wrist
    {
        std::vector<double> degrees(7, 1.);
        degrees[first] = degrees[first + 1] = 180 / CV_PI;
        scaleReadings(degrees);
        expectFinding(list("kinematics.csv: tool 'PSM1'", "radians, not degrees"));
    }
}

TEST_F(SurgTrack_SetupCheck, namesTheInverseOfACalibration)
{
    writeHandEye(folder, "PSM2", sound->tool(1).nominal_T_base.inv());
    expectFinding(list("camera_T_base of tool 'PSM2'", "is it base_T_camera?"));
}

TEST_F(SurgTrack_SetupCheck, namesArmsThatAreExchanged)
{
    writeHandEye(folder, "PSM1", sound->tool(1).nominal_T_base);
    writeHandEye(folder, "PSM2", sound->tool(0).nominal_T_base);
    expectFinding(list("camera_T_base", "are the arms exchanged"));
}

TEST_F(SurgTrack_SetupCheck, namesAnotherRateAndOtherClocks)
{
    put("sequence.yaml", replaced(get("sequence.yaml"), "fps: 25", "fps: 30"));
    expectFinding(list("fps: 30", "25 frames/s"));
    put("sequence.yaml", replaced(get("sequence.yaml"), "fps: 30", "fps: 25"));
    shiftReadings(1e9);
    expectFinding(list("kinematics.csv", "other clocks? time_offset"));
}

TEST_F(SurgTrack_SetupCheck, namesAClockThatIsLate)
{
    std::istringstream in(get("kinematics.csv"));
    std::ostringstream out;
    std::string line;
    std::getline(in, line);
    out << line << "\n";
    while (std::getline(in, line))   // those of one arm only
        out << format("%.4f", std::atof(line.c_str()) + (line.find("PSM2") == String::npos ? 0 : 0.28)) << line.substr(line.find(',')) << "\n";
    put("kinematics.csv", out.str());
    expectFinding(list("time_offset of tool 'PSM2'", "0.2"));
}

TEST_F(SurgTrack_SetupCheck, namesEyesThatAreExchanged)
{
    String text = get("sequence.yaml");
    text = replaced(replaced(replaced(text, "/left.mp4", "/middle.mp4"), "/right.mp4", "/left.mp4"), "/middle.mp4", "/right.mp4");
    put("sequence.yaml", text);
    expectFinding(list("left.video, right.video", "are the eyes exchanged"), true);
    EXPECT_FALSE(checkEyes(Sequence::load(folder)).empty());
    EXPECT_TRUE(checkEyes(sound).empty());
}

TEST_F(SurgTrack_SetupCheck, namesImagesThatAreUpsideDown)
{
    const String turned = path("turned.avi");
    cv::VideoCapture video(sound->leftVideo());
    cv::VideoWriter writer(turned, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 25, sound->frameSize());
    for (Mat image; video.read(image); )
    {
        cv::rotate(image, image, cv::ROTATE_180);
        writer.write(image);
    }
    writer.release();
    put("sequence.yaml", replaced(get("sequence.yaml"), sound->leftVideo(), turned));
    expectFinding(list("left.video", "turned by 180 degrees"));
}

// The built-in tool with a wrist and jaws half as long again.
TEST_F(SurgTrack_SetupCheck, namesAnotherInstrument)
{
    ToolModel::Description other;
    other.name = "long";
    other.coordinates = needleDriver()->coordinateNames();
    other.links = needleDriver()->links();
    other.meshes = needleDriver()->meshes();
    other.keypoints = needleDriver()->keypoints();
    other.endEffectorLink = needleDriver()->endEffectorLink();
    const float factor = 1.5f;
    for (size_t i = 0; i < other.links.size(); i++)
        if (other.links[i].a > 0) other.links[i].a *= factor;
    for (size_t i = 1; i < other.meshes.size(); i++)   // 0: the shaft
        for (size_t k = 0; k < other.meshes[i].vertices.size(); k++) other.meshes[i].vertices[k] *= factor;
    for (size_t i = 0; i < other.keypoints.size(); i++)
        if (other.links[other.keypoints[i].link].mesh > 0) other.keypoints[i].linkPoint *= factor;
    ToolModel::create(other)->save(path("long.yaml"));
    for (int i = 0; i < 2; i++) writeSequenceTool(folder, sound->tool(i).name, path("long.yaml"), sound->tool(i).nominal_T_base);
    expectFinding(list("model of tool 'PSM1'", "another instrument"));
}

TEST_F(SurgTrack_SetupCheck, namesKeypointsInsideTheMeshes)
{
    ToolModel::Description hollow;
    hollow.name = needleDriver()->name();
    hollow.coordinates = needleDriver()->coordinateNames();
    hollow.links = needleDriver()->links();
    hollow.meshes = needleDriver()->meshes();
    hollow.endEffectorLink = needleDriver()->endEffectorLink();
    hollow.keypoints = needleDriver()->keypoints();
    for (size_t i = 0; i < hollow.keypoints.size(); i++)   // all on the axis of the shaft, which is 8 mm thick
    {
        hollow.keypoints[i].link = 3;
        hollow.keypoints[i].linkPoint = Point3d(0, 0, -0.004 - 0.001 * i);
    }
    ToolModel::create(hollow)->save(path("hollow.yaml"));
    writeSequenceTool(folder, "PSM1", path("hollow.yaml"), sound->tool(0).nominal_T_base);
    expectFinding(list("hollow.yaml: keypoints: of tool 'PSM1'", "inside the meshes"));
}

TEST_F(SurgTrack_SetupCheck, namesReadingsBeyondTheLimitsOfTheTool)
{
    const Ptr<ToolModel> plain = needleDriver();
    ToolModel::Description limited;
    limited.name = plain->name();
    limited.coordinates = plain->coordinateNames();
    limited.links = plain->links();
    limited.meshes = plain->meshes();
    limited.keypoints = plain->keypoints();
    limited.endEffectorLink = plain->endEffectorLink();
    limited.limits.assign(limited.coordinates.size(), Vec2d(-DBL_MAX, DBL_MAX));
    limited.limits[4] = Vec2d(2, 3);   // q5 bends the wrist by less than 1 rad here
    ToolModel::create(limited)->save(path("limited.yaml"));
    EXPECT_EQ(3, ToolModel::load(path("limited.yaml"))->jointLimits().at<double>(4, 1));
    writeSequenceTool(folder, "PSM1", path("limited.yaml"), sound->tool(0).nominal_T_base);
    expectFinding(list("tool 'PSM1': coordinate q5", "its limits in the tool file are 2 and 3: another column?"));
    limited.limits[4] = Vec2d(-1.5, 1.5);
    ToolModel::create(limited)->save(path("limited.yaml"));
    std::vector<double> degrees(7, 1.);
    degrees[4] = 10;   // some of the readings are beyond the limits, none more than two turns
    scaleReadings(degrees);
    expectFinding(list("tool 'PSM1': coordinate q5", "expected radians, not degrees"));
}

TEST(SurgTrack_SetupUnits, areToldByWhatNoInstrumentCanDo)
{
    Mat joints = (Mat_<double>(2, 7) << 0.1, 0.1, 0.12, 3, 0.1, 0.1, 0, 0.2, 0.1, 0.13, -4, 0.1, 0.1, 0.2);
    EXPECT_EQ(String(), checkUnits(needleDriver(), joints));
    joints.at<double>(1, 2) = 1.3;
    EXPECT_NE(String::npos, checkUnits(needleDriver(), joints).find("q3 goes to 1.3"));
    EXPECT_ERROR(checkUnits(needleDriver(), joints.colRange(0, 3)), "joints");
    EXPECT_ERROR(checkUnits(Ptr<ToolModel>(), joints), "model");
}

}} // namespace
