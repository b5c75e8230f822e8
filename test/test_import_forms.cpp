// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_import.hpp"

// The forms in which recorders, drivers and calibration tools write what this module reads.

namespace opencv_test { namespace {

const char* const ARM[] = { "yaw", "pitch", "insertion", "roll", "wrist_pitch", "wrist_yaw", "jaw" };

class SurgTrack_JointForms : public ImportTest
{
protected:
    // Joint i of reading k is 0.1 * (i + 1) + 0.01 * k.
    static double truth(int k, int i) { return 0.1 * (i + 1) + 0.01 * k; }

    void read(const std::vector<String>& files)
    {
        std::vector<String> coordinates;
        for (int i = 1; i <= 6; i++)
            coordinates.push_back(format("q%d", i));
        coordinates.push_back("jaw");
        importJoints(files, coordinates, times, joints);
    }

    void expectReadings(const String& text, const String& what)
    {
        ASSERT_NO_THROW(read(list(put("joints.csv", text)))) << what;
        ASSERT_EQ(Size(7, 4), joints.size()) << what;
        for (int k = 0; k < 4; k++)
            for (int i = 0; i < 7; i++)
                EXPECT_NEAR(truth(k, i), joints(k, i), 1e-9) << what;   // as printed
        EXPECT_NEAR(0.03, times[3] - times[0], 1e-6) << what;           // a double holds 2e-7 s of the clock
    }

    void expectError(const String& text, const char* what)
    {
        EXPECT_ERROR(read(list(put("joints.csv", text))), what);
    }

    // A table. row: what stands before the joints, with the number of the reading for %d
    static String table(const String& head, const char* row, const char* separator = ",", const char* numbers = "%.4f")
    {
        String text = head;
        for (int i = 0; i < 7; i++)
            text += separator + String(ARM[i]);
        for (int k = 0; k < 4; k++)
        {
            text += "\n" + format(row, k, k);
            for (int i = 0; i < 7; i++)
                text += separator + format(numbers, truth(k, i));
        }
        return text + "\n";
    }

    std::vector<double> times;
    Mat_<double> joints;
};

TEST_F(SurgTrack_JointForms, tablesOfManyProgramsAreRead)
{
    expectReadings(table("Time", "1700000000.0%d"), "a capital");
    expectReadings(table("time [ns]", "%d0000000"), "a unit");
    expectReadings(table("time_ms", "%d0"), "milliseconds, as they are called");
    expectReadings(table(",time", "%d,0.0%d"), "an index without name");
    expectReadings(table("# time", "0.0%d"), "NumPy");
    expectReadings(table("time", "0.0%d", ";"), "semicolons");
    expectReadings(table("time", "0.0%d", "\t"), "tabs");
    expectReadings(replaced(table("time,note", "0.0%d,x"), "0.01,x", "0.01,\"a \"\"b\"\", c\""), "quotes");
    expectReadings("# made by us\n#\n" + table("time", "0.0%d"), "comments");
    expectReadings(table("Time", "2023-11-14 22:13:20.0%d"), "a date, as pandas writes it");
    expectReadings(table("timestamp", "2023-11-14T23:13:20.0%d0+01:00"), "ISO 8601");
    expectReadings(table("Time", "0.0%d sec"), "a duration of MATLAB");
    expectReadings(table("time", "0.0%d") + "0.04,0.2,0.", "a recorder that was stopped");
    String comma = table("time", "0.0%d", ";");
    std::replace(comma.begin(), comma.end(), '.', ',');
    expectReadings(comma, "a decimal comma");
    String ends = table("time", "0.0%d", ";");
    for (size_t at = ends.find('\n') + 1; (at = ends.find('\n', at)) != String::npos; at += 2)
        ends.insert(at, ";");
    expectReadings(ends, "a separator at the end");
}

TEST_F(SurgTrack_JointForms, datesAreSecondsSince1970)
{
    read(list(put("joints.csv", table("time", "2024-03-01T00:00:00.0%dZ"))));
    EXPECT_EQ(1709251200, times[0]);   // of date -u
}

TEST_F(SurgTrack_JointForms, columnsMayNameTheirUnits)
{
    const String text = "time [s],q1 [deg],q2 (rad),q3_mm,q4_deg,q5 [rad],q6 [rad],jaw [deg]\n0,90,-0.2,130,180,0.2,0.1,45\n0.01,90,-0.2,131,180,0.2,0.1,45\n";
    read(list(put("joints.csv", text)));
    const double expected[] = { CV_PI / 2, -0.2, 0.13, CV_PI, 0.2, 0.1, CV_PI / 4 };
    for (int i = 0; i < 7; i++)
        EXPECT_NEAR(expected[i], joints(0, i), 1e-12);
}

TEST_F(SurgTrack_JointForms, namesInTheRowsCountMoreThanPlaces)
{
    const int order[] = { 2, 6, 1, 3, 4, 5, 0 };   // sorted: insertion, jaw, pitch, ...
    String numbered = "%time", lists = "Time,header.stamp.secs,header.stamp.nsecs,name,position,velocity\n";
    for (int i = 0; i < 7; i++)
        numbered += format(",field.name%d,field.position%d", i, i);
    for (int k = 0; k < 4; k++)
    {
        numbered += format("\n17000000000%d0000000", k);
        String names, values;
        for (int i = 0; i < 7; i++)
        {
            numbered += format(",%s,%.4f", ARM[order[i]], truth(k, order[i]));
            names += format("%s'outer_%s'", i ? ", " : "", ARM[order[i]]);
            values += format("%s%.4f", i ? ", " : "", truth(k, order[i]));
        }
        lists += format("17.0%d,17,%d0000000,\"[", k, k) + names + "]\",\"(" + values + ")\",\"()\"\n";
    }
    expectReadings(numbered + "\n", "a name beside each position");
    expectReadings(lists, "lists");
}

TEST_F(SurgTrack_JointForms, cellsWithoutReadingAreNoReadings)
{
    String text = "__time,/arm/jaw/position";
    for (int i = 0; i < 6; i++)
        text += format(",/arm/%s/position", ARM[i]);
    for (int k = 0; k < 8; k++)
    {
        text += format("\n%.3f,%.4f", 0.01 * k, truth(k, 6)) + ",,nan,,,,";
        text += format("\n%.3f,", 0.01 * k + 0.004);
        for (int i = 0; i < 6; i++)
            text += format(",%.4f", truth(k, i) + 0.004);
    }
    ASSERT_NO_THROW(read(list(put("gaps.csv", text + "\n"))));
    ASSERT_LE(7u, times.size());
    for (int k = 0; k < (int)times.size(); k++)
        for (int i = 0; i < 7; i++)   // all rise by 1 a second
            EXPECT_NEAR(0.1 * (i + 1) + times[k], joints(k, i), 1e-9) << k;
}

TEST_F(SurgTrack_JointForms, stampsThatStandStillAreNoTime)
{
    expectReadings(table("header.stamp,%time", "0,0.0%d"), "never filled in");
    expectReadings(table("header.stamp.sec,header.stamp.nanosec,time", "0,0,0.0%d"), "a pair");
    expectError(table("time", "17"), "different times");
    String coarse = "time";
    for (int i = 0; i < 7; i++)
        coarse += "," + String(ARM[i]);
    for (int k = 0; k < 20; k++)
    {
        coarse += format("\n%.1f", 1e9 + 0.1 * (k / 10));
        for (int i = 0; i < 7; i++)
            coarse += format(",%.4f", truth(k, i));
    }
    expectError(coarse + "\n", "18 of 20 rows repeat the time");
}

TEST_F(SurgTrack_JointForms, otherEncodingsAreNamed)
{
    expectError(String("\xFF\xFEt\0i\0\n\0", 8), "UTF-16");
    EXPECT_ERROR(importCameraInfo(list(put("info.yaml", String("\xFE\xFF\0i\0m", 6)))), "UTF-16");
}

TEST_F(SurgTrack_JointForms, aFileWithoutNamesSaysSo)
{
    expectError("1700000000,0,,yaw,pitch,0.1,0.2\n1700000000,10000000,,yaw,pitch,0.1,0.2\n", "expected a header");
}

TEST_F(SurgTrack_JointForms, unitsNoRobotHasAreRefused)
{
    expectError(replaced(table("time", "0.0%d"), "0.3000", "130.0"), "millimetres");
    expectError(replaced(table("time", "0.0%d"), "0.7000", "28.0"), "degrees");
}

TEST_F(SurgTrack_JointForms, jointsOfSurgPoseAreByFrame)
{
    const String text = "'0':\n  PSM1:\n  - 0.1\n  - -0.2\n  - 0.12\n  - 0.4\n  - 0.5\n  - -0.6\n  PSM3: [1, 2, 3, 4, 5, 6]\n"
                        "'1':\n  PSM1: [0.2, 0, 0, 0, 0, 0]\n  PSM3: [7, 8, 9, 10, 11, 12]\n";
    importSurgPoseJoints(put("jp.yaml", text), "PSM1", 7, 0.25, joints);
    ASSERT_EQ(Size(7, 2), joints.size());
    EXPECT_EQ(-0.2, joints(0, 1));
    EXPECT_EQ(0.25, joints(0, 6)) << "the jaw as it was given";
    EXPECT_EQ(0.2, joints(1, 0));
    EXPECT_ERROR(importSurgPoseJoints(path("jp.yaml"), "PSM2", 7, 0, joints), "key 0.PSM2");
    EXPECT_ERROR(importSurgPoseJoints(put("gap.yaml", replaced(text, "'1'", "'2'")), "PSM1", 7, 0, joints), "expected frame 1");
}

// ---- cameras

const char* const INFO =
    "image_width: 640\nimage_height: 480\ncamera_name: scope\n"
    "camera_matrix:\n  rows: 3\n  cols: 3\n  data: [700, 0, 310, 0, 710, 250, 0, 0, 1]\n"
    "distortion_model: plumb_bob\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [-0.3, 0.1, 0.002, -0.001, 0.05]\n";

class SurgTrack_CameraForms : public ImportTest
{
protected:
    void expectInfo(const String& text, const String& what, int coefficients = 5)
    {
        const double k[] = { -0.3, 0.1, 0.002, -0.001, 0.05 };
        CameraModel camera;
        ASSERT_NO_THROW(camera = importCameraInfo(list(put("info.yaml", text))).left) << what;
        EXPECT_EQ(Size(640, 480), camera.imageSize()) << what;
        EXPECT_EQ(700, camera.fx) << what;
        EXPECT_EQ(250, camera.cy) << what;
        for (int i = 0; i < 5; i++)
            EXPECT_EQ(i < coefficients ? k[i] : 0, camera.k[i]) << what;
    }
};

TEST_F(SurgTrack_CameraForms, infosOfEveryReleaseAreRead)
{
    expectInfo("\xEF\xBB\xBF" + String(INFO), "a byte order mark");
    expectInfo(replaced(INFO, "distortion_model", "camera_model"), "another name of the model");
    expectInfo(replaced(INFO, "distortion_model: plumb_bob\n", ""), "no model");
    expectInfo(replaced(INFO, ", 0.05]", "]"), "four coefficients", 4);
    expectInfo(replaced(replaced(INFO, "0.05]", "0.05, 0, 0, 0, 0, 0, 0, 0, 0, 0]"), "plumb_bob", "rational_polynomial"), "fourteen");
    expectInfo(replaced(INFO, "[-0.3, 0.1, 0.002, -0.001, 0.05]", "[-0.3 0.1 0.002 -0.001 0.05]"), "no commas");
    expectInfo("header:\n  seq: 7\nheight: 480\nwidth: 640\ndistortion_model: plumb_bob\nD: [-0.3, 0.1, 0.002, -0.001, 0.05]\n"
               "K: [700.0, 0.0, 310.0, 0.0, 710.0, 250.0, 0.0, 0.0, 1.0]\nbinning_x: 0\nroi:\n  width: 0\n---\nheight: 1\n", "messages");
}

TEST_F(SurgTrack_CameraForms, filesOfPythonsAreRead)
{
    const String K = "[[700.0, 0.0, 310.0], [0.0, 710.0, 250.0], [0.0, 0.0, 1.0]]", D = "[-0.3, 0.1, 0.002, -0.001, 0.05]";
    expectInfo("{\"width\":640,\"height\":480,\"distortion_model\":\"plumb_bob\",\"D\":" + D + ",\"K\":[700,0,310,0,710,250,0,0,1],\"binning_x\":0}", "JSON");
    expectInfo("width: 640\nheight: 480\ndistortion_model: ''\nd: []\nk: [700, 0, 310, 0, 710, 250, 0, 0, 1]\n", "no distortion", 0);
    const String texts[] = { "{ \"camera_matrix\": " + K + ", \"dist_coeff\": [" + D + "], \"image_width\": 640, \"image_height\": 480 }",
                             "image_height: 480\nimage_width: 640\nmtx:\n- - 700.0\n  - 0.0\n  - 310.0\n- - 0.0\n  - 710.0\n  - 250.0\n- - 0.0\n  - 0.0\n  - 1.0\ndist:\n- - -0.3\n"
                             "  - 0.1\n  - 0.002\n  - -0.001\n  - 0.05\n" };
    for (int i = 0; i < 2; i++)
    {
        const CameraModel camera = importOpenCVCameras(list(put(i ? "camera.yaml" : "camera.json", texts[i]))).left;
        EXPECT_EQ(710, camera.fy) << texts[i];
        EXPECT_EQ(-0.001, camera.k[3]) << texts[i];
        EXPECT_EQ(480, camera.imageSize().height) << texts[i];
    }
}

TEST_F(SurgTrack_CameraForms, aRegionOfInterestIsCutOut)
{
    const String text = INFO + String("roi:\n  x_offset: 40\n  y_offset: 30\n  height: 200\n  width: 300\n");
    const CameraModel camera = importCameraInfo(list(put("info.yaml", text))).left;
    EXPECT_EQ(Size(300, 200), camera.imageSize());
    EXPECT_EQ(270, camera.cx);
    EXPECT_EQ(220, camera.cy);
    EXPECT_ERROR(importCameraInfo(list(put("info.yaml", INFO + String("binning_x: 2\n")))), "binning");
}

TEST_F(SurgTrack_CameraForms, otherLensesAreRefusedByName)
{
    const String storage = "%YAML:1.0\n---\nimage_Width: 640\nimage_Height: 480\n"
        "Camera_Matrix: !!opencv-matrix { rows: 3, cols: 3, dt: d, data: [ 700, 0, 310, 0, 710, 250, 0, 0, 1 ] }\n"
        "Distortion_Coefficients: !!opencv-matrix { rows: 4, cols: 1, dt: d, data: [ -0.3, 0.1, 0.002, -0.001 ] }\n";
    EXPECT_EQ(0.002, importOpenCVCameras(list(put("camera.yml", storage))).left.k[2]) << "keys of OpenCV 2.4";
    EXPECT_ERROR(importOpenCVCameras(list(put("camera.yml", storage + "fisheye_model: 1\n"))), "fisheye");
    EXPECT_ERROR(importOpenCVCameras(list(put("camera.yml", storage + "model_type: KANNALA_BRANDT\n"))), "fisheye");
    EXPECT_ERROR(importOpenCVCameras(list(put("camera.yml", storage + "xi: 1.2\n"))), "xi");
    EXPECT_NO_THROW(importOpenCVCameras(list(put("camera.yml", storage + "fisheye_model: 0\n"))));
    EXPECT_ERROR(importCameraInfo(list(put("info.yaml", replaced(INFO, "plumb_bob", "equidistant")))), "fisheye");
    EXPECT_ERROR(importCameraInfo(list(put("info.yaml", replaced(replaced(INFO, "distortion_model: plumb_bob\n", ""), ", 0.05]", "]")))),
                 "four coefficients");
    EXPECT_ERROR(importCameraInfo(list(put("info.yaml", replaced(INFO, "0.05]", "0.05, 0, 0, 0.1]")))), "zeros behind the first 5");
}

TEST_F(SurgTrack_CameraForms, eyesInOtherUnitsOrExchangedAreRefused)
{
    const String head = "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\n"
        "M1: !!opencv-matrix { rows: 3, cols: 3, dt: d, data: [ 700, 0, 310, 0, 710, 250, 0, 0, 1 ] }\n"
        "M2: !!opencv-matrix { rows: 3, cols: 3, dt: d, data: [ 700, 0, 310, 0, 710, 250, 0, 0, 1 ] }\n"
        "D1: !!opencv-matrix { rows: 4, cols: 1, dt: d, data: [ 0, 0, 0, 0 ] }\nD2: !!opencv-matrix { rows: 4, cols: 1, dt: d, data: [ 0, 0, 0, 0 ] }\n"
        "R: !!opencv-matrix { rows: 3, cols: 3, dt: d, data: [ 1, 0, 0, 0, 1, 0, 0, 0, 1 ] }\nT: !!opencv-matrix { rows: 3, cols: 1, dt: d, data: [ ";
    EXPECT_EQ(-0.005, importOpenCVCameras(list(put("eyes.yml", head + "-5, 0, 0 ] }\n")), 0.001).right_T_left(0, 3));
    EXPECT_ERROR(importOpenCVCameras(list(path("eyes.yml")), 1), "millimetres?");
    EXPECT_ERROR(importOpenCVCameras(list(put("eyes.yml", head + "5, 0, 0 ] }\n")), 0.001), "exchanged?");
}

// ---- hand-eye

class SurgTrack_HandEyeForms : public ImportTest {};

TEST_F(SurgTrack_HandEyeForms, matricesOfManyProgramsAreRead)
{
    const Matx44d expected(0, -1, 0, 0.1, 1, 0, 0, -0.2, 0, 0, 1, 0.15, 0, 0, 0, 1);
    const String rows = "[[0, -1, 0, 0.1], [1.0, 0, 0, -0.2], [0, 0, 1, 0.15], [0, 0, 0, 1]]";
    const struct { const char* name; String text; } files[] = {
        { "storage.yaml", "%YAML:1.0\n---\ncamera_T_base: !!opencv-matrix { rows: 4, cols: 4, dt: d, data: [ 0, -1, 0, 0.1, 1, 0, 0, -0.2, 0, 0, 1, "
                          "0.15, 0, 0, 0, 1 ] }\n" },
        { "PSM2-registration-open-cv.json", "{\n\"base-frame\": {\"reference-frame\": \"/eye\", \"transform\": " + rows + "}\n}\n" },
        { "plain.yaml", "camera_T_base: " + rows + "\n" },
        { "pyyaml.yaml", "camera_T_base:\n- [0, -1, 0, 0.1]\n- [1, 0, 0, -0.2]\n- [0, 0, 1, 0.15]\n- [0, 0, 0, 1]\n" },
        { "rows.csv", "0,-1,0,0.1\n1,0,0,-0.2\n0,0,1,0.15\n0,0,0,1\n" },
        { "savetxt.txt", "0 -1 0 1e-1\n1 0 0 -0.2\n0 0 1 0.15\n" } };
    for (size_t i = 0; i < sizeof(files) / sizeof(files[0]); i++)
    {
        Matx44d T;
        ASSERT_NO_THROW(T = importHandEye(put(files[i].name, files[i].text))) << files[i].name;
        EXPECT_EQ(expected, T) << files[i].name;
    }
    EXPECT_ERROR(importHandEye(put("PSM2-registration-dVRK.json", "{}")), "open-cv.json");
    EXPECT_ERROR(importHandEye(put("mm.csv", "0,-1,0,100\n1,0,0,-200\n0,0,1,150\n")), "millimetres");
    EXPECT_ERROR(importHandEye(put("left.csv", "0,1,0,0.1\n1,0,0,-0.2\n0,0,1,0.15\n")), "right-handed");
    EXPECT_ERROR(importHandEye(put("none.yaml", "camera_T_base: 7\n")), "expected the 4x4 matrix");
}

// ---- labels

TEST_F(SurgTrack_HandEyeForms, labelsOfSomeFramesKeepTheirFrames)
{
    const String text = "[{\"filename\": \"a_0005.png\", \"annotations\": [{\"class\": \"Tip\", \"id\": \"t\", \"x\": 1, \"y\": 2}]},\n"
                        " {\"filename\": \"a_0012.png\", \"annotations\": [{\"class\": \"Tip\", \"id\": \"t\", \"x\": 3, \"y\": 4}]}]\n";
    orSkip([&] { return importEndoVisKeypoints(put("labels.json", text), path("k.csv")); });
    EXPECT_EQ("frame,tool,keypoint,u,v,visible\n0,t,Tip,1,2,1\n7,t,Tip,3,4,1\n", get("k.csv"));
    EXPECT_ERROR(importEndoVisKeypoints(put("labels.json", replaced(text, "0012", "0004")), path("k.csv")), "in the order");
}

// ---- places of errors

TEST_F(SurgTrack_HandEyeForms, whatYamlCannotBeReadSaysWhere)
{
    const String text = "%YAML:1.0\n---\nname: \"x\"\nfps: 25\n\timage_width: 7\n";
    EXPECT_ERROR(Sequence::load(put("tab.yaml", text)), "line 5");
    EXPECT_ERROR(importCameraInfo(list(put("info.yaml", "image_width: 7\n\timage_height: 8\n"))), "line 2");
    EXPECT_ERROR(Sequence::load(put("bom.yaml", "\xEF\xBB\xBF%YAML:1.0\n---\nname: \"x\"\n")), "fps");
}

}} // namespace
