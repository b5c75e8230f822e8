// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_import.hpp"

namespace opencv_test { namespace {

// ---- cameras

const char* const CAMERA_INFO =
    "image_width: 720\n"
    "image_height: 576\n"
    "camera_name: left\n"
    "camera_matrix:\n"
    "  rows: 3\n"
    "  cols: 3\n"
    "  data: [854.5, 0, 319.25,\n"
    "         0, 935.5, 254.75,\n"
    "         0, 0, 1]\n"
    "distortion_model: plumb_bob\n"
    "distortion_coefficients:\n"
    "  rows: 1\n"
    "  cols: 5\n"
    "  data: [-0.25, 0.125, -0.005, 0.001, 0]\n"
    "rectification_matrix:\n"
    "  rows: 3\n"
    "  cols: 3\n"
    "  data: [0.8, 0, -0.6, 0, 1, 0, 0.6, 0, 0.8]\n"
    "projection_matrix:\n"
    "  rows: 3\n"
    "  cols: 4\n"
    "  data: [800, 0, 320, 0, 0, 800, 240, 0, 0, 0, 1, 0]\n";

class SurgTrack_ImportCameras : public ImportTest
{
protected:
    void expectInfoError(const char* from, const char* to, const char* what) const
    {
        const std::vector<String> file = list(put("info.yaml", replaced(CAMERA_INFO, from, to)));
        EXPECT_ERROR(importCameraInfo(file), "info.yaml");
        EXPECT_ERROR(importCameraInfo(file), what);
    }
};

TEST_F(SurgTrack_ImportCameras, cameraInfoNeedsNoYamlLine)
{
    const CameraPair cameras = importCameraInfo(list(put("left.yaml", CAMERA_INFO)));
    EXPECT_EQ(Size(720, 576), cameras.left.imageSize());
    EXPECT_EQ(854.5, cameras.left.fx);
    EXPECT_EQ(254.75, cameras.left.cy);
    EXPECT_EQ(-0.005, cameras.left.k[2]);
    EXPECT_EQ(Size(), cameras.right.imageSize());
    // Lists as PyYAML writes them, a document start, comments.
    String text = replaced(CAMERA_INFO, "  data: [-0.25, 0.125, -0.005, 0.001, 0]\n",
                           "  data:\n  - -0.25\n  - 0.125\n  - -0.005\n  - 0.001\n  - 0\n");
    text = "# from the lab\n---\n" + text;
    EXPECT_EQ(0.001, importCameraInfo(list(put("left.yaml", text))).left.k[3]);
}

TEST_F(SurgTrack_ImportCameras, cameraInfoMayBeRational)
{
    String text = replaced(CAMERA_INFO, "plumb_bob", "rational_polynomial");
    text = replaced(text, "-0.25, 0.125, -0.005, 0.001, 0", "0.01, 0.02, 0.03, 0.04, 0.05, 0.06, 0.07, 0.08");
    const CameraModel camera = importCameraInfo(list(put("left.yaml", text))).left;
    for (int i = 0; i < 8; i++)
        EXPECT_DOUBLE_EQ((i + 1) / 100., camera.k[i]);
}

TEST_F(SurgTrack_ImportCameras, twoCameraInfosAreAStereoPair)
{
    String right = replaced(CAMERA_INFO, "0.8, 0, -0.6, 0, 1, 0, 0.6, 0, 0.8", "1, 0, 0, 0, 1, 0, 0, 0, 1");
    const std::vector<String> files = list(put("left.yaml", CAMERA_INFO), put("right.yaml", replaced(right, "320, 0, 0, 800", "320, -4, 0, 800")));
    const Matx44d T = importCameraInfo(files).right_T_left;
    // right = rectification of left, moved by -4 / 800 m
    const Matx44d expected(0.8, 0, -0.6, -0.005, 0, 1, 0, 0, 0.6, 0, 0.8, 0, 0, 0, 0, 1);
    EXPECT_LT(cv::norm(T - expected), 1e-15);   // rounding
    EXPECT_ERROR(importCameraInfo(list(files[1], files[0])), "projection_matrix");   // left and right mixed up
}

TEST_F(SurgTrack_ImportCameras, wrongCameraInfosAreRefused)
{
    expectInfoError("plumb_bob", "equidistant", "equidistant");
    expectInfoError("image_width: 720\n", "", "image_width");
    expectInfoError("image_height: 576", "image_height: none", "image_height");
    expectInfoError("-0.005, 0.001, 0]", "-0.005]", "distortion_coefficients");
    expectInfoError("[854.5,", "[-854.5,", "cameraMatrix");
    expectInfoError("[854.5,", "[x,", "camera_matrix");
    EXPECT_ERROR(importCameraInfo(list(path("none.yaml"))), "none.yaml");
    EXPECT_ERROR(importCameraInfo(std::vector<String>()), "files");
}

const char* const INTRINSICS =
    "%YAML:1.0\n---\n"
    "M1: !!opencv-matrix { rows: 3, cols: 3, dt: d, data: [ 800, 0, 320, 0, 810, 240, 0, 0, 1 ] }\n"
    "D1: !!opencv-matrix { rows: 1, cols: 14, dt: d, data: [ -0.2, 0.1, 0.01, 0.02, 0.03, 0, 0, 0, 0, 0, 0, 0, 0, 0 ] }\n"
    "M2: !!opencv-matrix { rows: 3, cols: 3, dt: d, data: [ 801, 0, 321, 0, 811, 241, 0, 0, 1 ] }\n"
    "D2: !!opencv-matrix { rows: 5, cols: 1, dt: d, data: [ -0.3, 0.1, 0.01, 0.02, 0.03 ] }\n";

const char* const EXTRINSICS =
    "%YAML:1.0\n---\n"
    "R: !!opencv-matrix { rows: 3, cols: 3, dt: d, data: [ 1, 0, 0, 0, 0.8, -0.6, 0, 0.6, 0.8 ] }\n"
    "T: !!opencv-matrix { rows: 3, cols: 1, dt: d, data: [ -5.2, 0.1, 0.2 ] }\n";

TEST_F(SurgTrack_ImportCameras, stereoCalibrationOfOpenCVNeedsItsUnit)
{
    const std::vector<String> files = list(put("intrinsics.yml", INTRINSICS), put("extrinsics.yml", EXTRINSICS));
    const CameraPair cameras = importOpenCVCameras(files, 0.001, Size(640, 480));
    EXPECT_EQ(810, cameras.left.fy);
    EXPECT_EQ(0.03, cameras.left.k[4]);
    EXPECT_EQ(801, cameras.right.fx);
    EXPECT_EQ(-0.3, cameras.right.k[0]);
    EXPECT_NEAR(-0.0052, cameras.right_T_left(0, 3), 1e-15);   // rounding
    EXPECT_NEAR(-0.6, cameras.right_T_left(1, 2), 1e-15);
    EXPECT_ERROR(importOpenCVCameras(files, 0, Size(640, 480)), "unit");
    EXPECT_ERROR(importOpenCVCameras(files, 0, Size(640, 480)), "5.2");
    EXPECT_ERROR(importOpenCVCameras(files, 0.001), "imageSize");
    EXPECT_ERROR(importOpenCVCameras(list(files[0]), 0.001, Size(640, 480)), "R rotation");
    put("intrinsics.yml", replaced(INTRINSICS, "0, 0, 0 ] }", "0, 0, 0.5 ] }"));   // a tilted sensor
    EXPECT_ERROR(importOpenCVCameras(files, 0.001, Size(640, 480)), "distCoeffs");
}

TEST_F(SurgTrack_ImportCameras, oneCameraOfOpenCVHasOtherNames)
{
    const String text = "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\n"
        "camera_matrix: !!opencv-matrix { rows: 3, cols: 3, dt: d, data: [ 800, 0, 320, 0, 810, 240, 0, 0, 1 ] }\n"
        "distortion_coefficients: !!opencv-matrix { rows: 5, cols: 1, dt: d, data: [ -0.2, 0.1, 0.01, 0.02, 0.03 ] }\n";
    const CameraPair cameras = importOpenCVCameras(list(put("camera.yml", text)));
    EXPECT_EQ(Size(640, 480), cameras.left.imageSize());
    EXPECT_EQ(Size(), cameras.right.imageSize());
    EXPECT_ERROR(importOpenCVCameras(list(put("camera.yml", text)), 0, Size(720, 576)), "640x480");
    EXPECT_ERROR(importOpenCVCameras(list(put("camera.yml", replaced(text, "camera_matrix", "k")))), "camera_matrix");
    EXPECT_ERROR(importOpenCVCameras(list(put("camera.yml", "no yaml"))), "camera.yml");
}

TEST_F(SurgTrack_ImportCameras, thePapersCalibrationIsRead)
{
    const CameraPair cameras = importOpenCVCameras(list(recorded("paper_rig/out_camera_data.xml")), 0.001);
    EXPECT_EQ(Size(720, 576), cameras.right.imageSize());
    EXPECT_NEAR(854.735447, cameras.left.fx, 1e-6);   // digits compared
    EXPECT_NEAR(-0.341256, cameras.right.k[0], 1e-6);
    EXPECT_NEAR(-5.456446e-3, cameras.right_T_left(0, 3), 1e-9);
}

const char* const SURGPOSE =
    "[StereoLeft]\nres_x=1400\nres_y=986\nfc_x=1811.91\nfc_y=1809.64\ncc_x=588.5\ncc_y=477.25\nkc_0=-0.3\n"
    "kc_1=0.6\nkc_2=0.001\nkc_3=0.002\nkc_4=-0.7\n\n"
    "[StereoRight]\r\nres_x = 1400\r\nres_y = 986\r\nfc_x = 1801\nfc_y = 1800\ncc_x = 700\ncc_y = 480\nkc_0 = -0.31\nkc_1 = 0.5\nkc_2 = 0.003\n"
    "kc_3 = 0.004\nkc_4 = 0.1\nR_0=1\nR_1=0\nR_2=0\nR_3=0\nR_4=0.8\nR_5=-0.6\nR_6=0\nR_7=0.6\nR_8=0.8\nT_0=-5.5\nT_1=-0.25\nT_2=0.5\n";

TEST_F(SurgTrack_ImportCameras, surgPoseHasTangentialDistortionInTheMiddle)
{
    const CameraPair cameras = importSurgPoseCameras(put("StereoCalibrationDVRK.ini", SURGPOSE));
    EXPECT_EQ(Size(1400, 986), cameras.left.imageSize());
    EXPECT_EQ(1811.91, cameras.left.fx);
    const double left[] = { -0.3, 0.6, 0.001, 0.002, -0.7 };   // k1 k2 p1 p2 k3
    for (int i = 0; i < 5; i++)
        EXPECT_EQ(left[i], cameras.left.k[i]);
    EXPECT_EQ(0.1, cameras.right.k[4]);
    EXPECT_NEAR(-0.0055, cameras.right_T_left(0, 3), 1e-15);   // rounding
    EXPECT_NEAR(-0.6, cameras.right_T_left(1, 2), 1e-15);
    EXPECT_ERROR(importSurgPoseCameras(put("bad.ini", replaced(SURGPOSE, "T_2=0.5", "T_2=half"))), "StereoRight.T_2");
    EXPECT_ERROR(importSurgPoseCameras(put("bad.ini", replaced(SURGPOSE, "kc_4=-0.7", ""))), "StereoLeft.kc_4: missing");
    EXPECT_ERROR(importSurgPoseCameras(put("bad.ini", replaced(SURGPOSE, "R_4=0.8", "R_4=0.9"))), "rotation");
}

// ---- joints

std::vector<String> coordinates()
{
    const char* const names[] = { "q1", "q2", "q3", "q4", "q5", "q6", "jaw" };
    return std::vector<String>(names, names + 7);
}

class SurgTrack_ImportJoints : public ImportTest
{
protected:
    void read(const String& a, const String& b = String(), const std::vector<String>& columns = std::vector<String>())
    {
        const String first = put("a.csv", a);
        importJoints(b.empty() ? list(first) : list(first, put("b.csv", b)), names.empty() ? coordinates() : names, times, joints, columns);
    }

    void expectError(const String& a, const char* what, const String& b = String())
    {
        EXPECT_ERROR(read(a, b), ".csv");
        EXPECT_ERROR(read(a, b), what);
    }

    std::vector<String> names;
    std::vector<double> times;
    Mat_<double> joints;
};

TEST_F(SurgTrack_ImportJoints, columnsHaveTheNamesOfTheRobot)
{
    read("time,outer_wrist_yaw,outer_yaw,outer_pitch,outer_insertion,outer_roll,outer_wrist_pitch,jaw,comment\n"
         "1700000000.00,6,1,2,3,4,5,7,ok\n1700000000.01,6.5,1.5,2.5,3.5,4.5,5.5,7.5,ok\n");
    ASSERT_EQ(Size(7, 2), joints.size());
    EXPECT_NEAR(0.01, times[1] - times[0], 1e-6);   // a double holds 2e-7 s of the clock
    for (int i = 0; i < 7; i++)
    {
        EXPECT_EQ(i + 1, joints(0, i));
        EXPECT_EQ(i + 1.5, joints(1, i));
    }
    read("__time,/PSM1/measured_js/yaw/position,/PSM1/measured_js/yaw/velocity,pitch,insertion,roll,wrist_pitch,wrist_yaw,q7,/PSM1/jaw/position\n"
         "0.0,1,9,2,3,4,5,6,0,7\n0.1,1,9,2,3,4,5,6,0,7\n");
    EXPECT_EQ(1, joints(0, 0));
    EXPECT_EQ(7, joints(0, 6));
}

TEST_F(SurgTrack_ImportJoints, positionsHaveNumbersAndTheJawMayBeInAFileOfItsOwn)
{
    read("%time,field.header.stamp,field.header.frame_id,field.name0,field.position0,field.position1,field.position2,field.position3,"
         "field.position4,field.position5,field.velocity0\n"
         "1700000000900000000,1700000000000000000,x,outer_yaw,1,2,3,4,5,6,0\n1700000000910000000,1700000000010000000,x,outer_yaw,1,2,3,4,5,6,0\n"
         "1700000000920000000,1700000000020000000,x,outer_yaw,2,3,4,5,6,7,0\n",
         "header.stamp.secs,header.stamp.nsecs,position[0]\n1700000000,5000000,0.5\n1700000000,25000000,0.7\n");
    ASSERT_EQ(2u, times.size()) << "both files cover two of the three readings";
    EXPECT_NEAR(0.01, times[1] - times[0], 1e-6);   // a double holds 2e-7 s of the clock
    EXPECT_NEAR(1700000000.01, times[0], 1e-6);
    EXPECT_EQ(6, joints(0, 5));
    EXPECT_NEAR(0.55, joints(0, 6), 1e-5);          // interpolated, a quarter of the way
}

TEST_F(SurgTrack_ImportJoints, columnsMayBeNamed)
{
    names = list("insertion", "roll");
    read("timestamp,a,b\n0,1,2\n10000000,3,4\n", "", list("b", "a"));
    EXPECT_EQ(0.01, times[1]) << "nanoseconds";
    EXPECT_EQ(2, joints(0, 0));
    EXPECT_EQ(3, joints(1, 1));
    read("time,a_mm,b [deg]\n0,1000,90\n0.01,3000,90\n", "", list("b [deg]", "a_mm"));
    EXPECT_EQ(CV_PI / 2, joints(0, 0));
    EXPECT_EQ(3, joints(1, 1));
    EXPECT_ERROR(read("time,a\n0,1\n0.1,3\n", "", list("b", "a")), "a column of b");
    EXPECT_ERROR(read("time,a\n0,1\n0.1,3\n", "", list("a")), "columns");
}

TEST_F(SurgTrack_ImportJoints, wrongFilesAreRefused)
{
    const String head = "time,q1,q2,q3,q4,q5,q6,jaw\n";
    expectError("q1,q2,q3,q4,q5,q6,jaw\n0,0,0,0,0,0,0\n", "column of the time");
    expectError("time,q1,q2,q3,q4,q5,jaw\n0,0,0,0,0,0,0\n0.1,0,0,0,0,0,0\n", "a column of q6");
    expectError("time,x\n0,0\n", "columns of joints");
    expectError("time,q1,yaw,q2,q3,q4,q5,q6,jaw\n", "both of q1");
    expectError(head + "0,1,2,3,4,5,6,7\n", "at least two");
    expectError(head + "0.1,1,2,3,4,5,6,7\n0,1,2,3,4,5,6,7\n", "line 3");
    expectError(head + "0,1,2,3,4,5,6,7\n10,1,2,3,4,5,6,7\n", "seconds or nanoseconds");        // ms
    expectError(head + "0,1,2,3,4,5,6,7\n10000,1,2,3,4,5,6,7\n", "seconds or nanoseconds");     // us
    expectError(head + "0,1,2,x,4,5,6,7\n", "q3");
    expectError("time,q1,q2,q3,q4,q5,q6\n0,1,2,3,4,5,6\n0.1,1,2,3,4,5,6\n", "same time", "time,jaw\n7,1\n7.1,1\n");
}

// ---- the paper's recordings

class SurgTrack_ImportDaVinci : public ImportTest
{
protected:
    static std::vector<double> truth(int frame)
    {
        const double q[] = { 0.2 + 0.01 * frame, -0.1, 0.11, 3.0 + 0.1 * frame, 0.4, -0.3, 0.5 - 0.1 * frame };
        return std::vector<double>(q, q + 7);
    }

    // Poses as the authors wrote them: millimetres, axes of the da Vinci's tool frame.
    String record(double scale = 1000) const
    {
        const int links[] = { linkIndex(*needleDriver(), "shaft"), linkIndex(*needleDriver(), "wrist"), linkIndex(*needleDriver(), "yaw") };
        const char* const keys[] = { "J4_poses", "J5_poses", "bHe_poses" };
        const Matx44d axes(0, -1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 0, 0, 0, 0, 1);
        FileStorage file(path("sim-PSM1.xml"), FileStorage::WRITE);
        for (int k = 0; k < 3; k++)
        {
            file << keys[k] << "[";
            for (int frame = 0; frame < FRAMES; frame++)
            {
                std::vector<Matx44d> base_T_link;
                needleDriver()->forwardKinematics(truth(frame), base_T_link);
                Matx44d T = base_T_link[links[k]] * axes;
                for (int i = 0; i < 3; i++)
                    T(i, 3) *= scale;
                file << Mat(T);
            }
            file << "]";
        }
        file << "jaws" << "[";
        for (int frame = 0; frame < FRAMES; frame++)
            file << truth(frame)[6];
        file << "]";
        return path("sim-PSM1.xml");
    }

    enum { FRAMES = 8 };
};

TEST_F(SurgTrack_ImportDaVinci, jointsFollowFromPoses)
{
    Mat_<double> joints;
    importDaVinciJoints(record(), needleDriver(), joints);
    ASSERT_EQ(Size(7, FRAMES), joints.size());
    const double turns = CV_PI * 2 * cvRound((joints(0, 3) - truth(0)[3]) / (CV_PI * 2));
    for (int frame = 0; frame < FRAMES; frame++)
    {
        std::vector<double> expected = truth(frame);
        expected[3] += turns;                        // whole turns are not known, but do not change within the recording
        expected[6] = std::max(expected[6], 0.);     // closed is closed
        for (int i = 0; i < 7; i++)
            EXPECT_NEAR(expected[i], joints(frame, i), 1e-9) << "frame " << frame << ", joint " << i;   // Gauss-Newton to the last digits
    }
}

TEST_F(SurgTrack_ImportDaVinci, wrongRecordingsAreRefused)
{
    Mat joints;
    EXPECT_ERROR(importDaVinciJoints(record(1), needleDriver(), joints), "frame 0");   // metres
    const String text = (record(), get("sim-PSM1.xml"));
    EXPECT_ERROR(importDaVinciJoints(put("bad.xml", replaced(text, "<J5_poses>", "<J5><x>")), needleDriver(), joints), "bad.xml");
    const String whole = "<?xml version=\"1.0\"?><opencv_storage><jaws>0</jaws></opencv_storage>";
    EXPECT_ERROR(importDaVinciJoints(put("bad.xml", whole), needleDriver(), joints), "J4_poses");
    EXPECT_ERROR(importDaVinciJoints(path("none.xml"), needleDriver(), joints), "none.xml");
    EXPECT_ERROR(importDaVinciHandEye(path("none.xml"), "bHc_psm1"), "none.xml");
    EXPECT_ERROR(importDaVinciHandEye(record(), "bHc_psm1"), "bHc_psm1");
}

TEST_F(SurgTrack_ImportDaVinci, theRecordingsOfThePaperAreRead)
{
    const FileStorage answers(recorded("paper_rig/joints.json"), FileStorage::READ);
    const Ptr<ToolModel> model = ToolModel::load(recorded("tools/large_needle_driver/large_needle_driver_lowres.yaml"));
    for (int arm = 1; arm <= 2; arm++)
    {
        const FileNode answer = answers[format("PSM%d", arm)];
        Mat_<double> joints;
        importDaVinciJoints(recorded(format("paper_rig/sim-PSM%d-2016Feb05T175836.xml", arm)), model, joints);
        ASSERT_EQ(373, joints.rows);
        double worst = 0, worstSlide = 0, sum = 0;
        int frame = 0;
        const FileNode q = answer["q"];
        for (FileNodeIterator it = q.begin(); it != q.end(); ++it, ++frame)
            for (int i = 0; i < 7; i++)
            {
                double difference = joints(frame, i) - (double)(*it)[i];
                if (i == 3)
                    difference -= CV_PI * 2 * cvRound(difference / (CV_PI * 2));
                (i == 2 ? worstSlide : worst) = std::max(i == 2 ? worstSlide : worst, std::abs(difference));
                sum += i == 2 ? 0 : std::abs(difference) / (6 * 373);
                // the jaw opens by 0.5 within a frame
                EXPECT_TRUE(frame == 0 || std::abs(joints(frame, i) - joints(frame - 1, i)) < 1) << "frame " << frame;
            }
        printf("PSM%d: joints differ by at most %.1e rad and %.1e m, by %.1e rad on average\n", arm, worst, worstSlide, sum);
        EXPECT_LT(worst, 3e-3);        // poses of one frame contradict each other by 5e-3 rad in fast motion: it depends on the weights
        EXPECT_LT(worstSlide, 5e-5);   // and by 0.17 mm
        EXPECT_LT(sum, 1e-5);          // most frames are slow
        Matx44d expected;
        const FileNode rows = answer["camera_T_base"];
        for (int i = 0; i < 16; i++)
            expected(i / 4, i % 4) = (double)rows[i / 4][i % 4];
        EXPECT_LT(cv::norm(importDaVinciHandEye(recorded("paper_rig/out_handeye_data.xml"), format("bHc_psm%d", arm)) - expected), 1e-6)
            << "rotations of the file are orthonormal to 1e-7";
    }
}

// ---- labels

class SurgTrack_ImportKeypoints : public ImportTest {};

TEST_F(SurgTrack_ImportKeypoints, labelsOfEndoVisBecomeKeypoints)
{
    const String labels = put("labels.json",
        "[ { \"annotations\": [ { \"class\": \"HeadPoint\", \"id\": \"tool1\", \"x\": 1.5, \"y\": 2 },"
        " { \"class\": \"EndPoint\", \"id\": \"tool2\", \"x\": 3, \"y\": 4 } ], \"class\": \"image\", \"filename\": \"img_0001.png\" },\n"
        "{ \"annotations\": [] }, { \"annotations\": [ { \"class\": \"HeadPoint\", \"id\": \"tool1\", \"x\": 5, \"y\": 6 } ] } ]");
    EXPECT_EQ(3, orSkip([&]() { return importEndoVisKeypoints(labels, path("all.csv")); }));
    EXPECT_EQ("frame,tool,keypoint,u,v,visible\n0,tool1,HeadPoint,1.5,2,1\n0,tool2,EndPoint,3,4,1\n2,tool1,HeadPoint,5,6,1\n", get("all.csv"));
    EXPECT_EQ(2, importEndoVisKeypoints(labels, path("some.csv"), list("HeadPoint:pivot"), list("tool1:PSM1")));
    EXPECT_EQ("frame,tool,keypoint,u,v,visible\n0,PSM1,pivot,1.5,2,1\n2,PSM1,pivot,5,6,1\n", get("some.csv"));
    EXPECT_ERROR(importEndoVisKeypoints(labels, path("none.csv"), list("Nose:tip")), "HeadPoint");
    EXPECT_ERROR(importEndoVisKeypoints(put("bad.json", "[ { } ]"), path("none.csv")), "[0].annotations: missing");
    EXPECT_ERROR(importEndoVisKeypoints(labels, path("no/folder.csv")), "folder.csv");
    EXPECT_FALSE(cv::utils::fs::exists(path("none.csv")));
}

// As `EndPoint` of the fifth test sequence is.
TEST_F(SurgTrack_ImportKeypoints, labelsWithoutToolAreOfTheOneThatLacksThem)
{
    const String labels = put("labels.json",
        "[ { \"annotations\": [ { \"class\": \"HeadPoint\", \"id\": \"tool1\", \"x\": 1, \"y\": 2 }, { \"class\": \"EndPoint\", \"x\": 3, \"y\": 4 },"
        " { \"class\": \"EndPoint\", \"id\": \"tool2\", \"x\": 5, \"y\": 6 }, { \"class\": \"ShaftPoint\", \"x\": 7, \"y\": 8 } ] } ]");
    EXPECT_EQ(3, orSkip([&]() { return importEndoVisKeypoints(labels, path("all.csv")); }));
    EXPECT_EQ("frame,tool,keypoint,u,v,visible\n0,tool1,HeadPoint,1,2,1\n0,tool1,EndPoint,3,4,1\n0,tool2,EndPoint,5,6,1\n", get("all.csv"));
}

TEST_F(SurgTrack_ImportKeypoints, allLabelsOfARecordingAreRead)
{
    const String labels = recorded("formats/endovis15/test1_labels.json");
    EXPECT_EQ(960, orSkip([&]() { return importEndoVisKeypoints(labels, path("all.csv")); }));
    EXPECT_EQ(320, importEndoVisKeypoints(labels, path("tips.csv"), list("LeftClasperPoint:tip_flat", "RightClasperPoint:tip_deep")));
    EXPECT_NE(String::npos, get("tips.csv").find("\n0,tool2,tip_flat,386,271,1\n"));
}

TEST_F(SurgTrack_ImportKeypoints, labelsOfSurgPoseBecomeKeypoints)
{
    const String expected = "frame,tool,keypoint,u,v,visible\n0,PSM1,1,585,404.5,1\n0,PSM3,9,700,300,1\n12,PSM1,2,1,2,1\n";
    const char* const texts[] = {
        "0:\n  1:\n  - 585.0\n  - 404.5\n  2: null\n  9:\n  - 700\n  - 300\n12:\n  1: null\n  2:\n  - 1.0\n  - 2.0\n",
        "0: {1: [585.0, 404.5], 2: null, 9: [700, 300]}\n12: {1: null, 2: [1.0, 2.0]}\n",
        "'0':\n  '1': [585.0, 404.5]\n  '2': null\n  '9': !!python/tuple\n  - 700\n  - 300\n'12':\n  '2': [1, 2]\n" };
    for (int i = 0; i < 3; i++)
    {
        EXPECT_EQ(3, importSurgPoseKeypoints(put("keypoints_left.yaml", texts[i]), path("all.csv"))) << texts[i];
        EXPECT_EQ(expected, get("all.csv")) << texts[i];
    }
    EXPECT_EQ(1, importSurgPoseKeypoints(path("keypoints_left.yaml"), path("some.csv"), list("9:pivot"), list("PSM3:left")));
    EXPECT_EQ("frame,tool,keypoint,u,v,visible\n0,left,pivot,700,300,1\n", get("some.csv"));
    EXPECT_ERROR(importSurgPoseKeypoints(put("bad.yaml", "0:\n  15: [1, 2]\n"), path("none.csv")), "key 0.15");
    EXPECT_ERROR(importSurgPoseKeypoints(put("bad.yaml", "0:\n  1: [1, 2, 3]\n"), path("none.csv")), "key 0.1: expected two numbers");
    EXPECT_ERROR(importSurgPoseKeypoints(put("bad.yaml", "frames: 3\n"), path("none.csv")), "key frames");
    EXPECT_ERROR(importSurgPoseKeypoints(put("bad.yaml", "0:\n  1: null\n"), path("none.csv")), "no labels");
}

// ---- the folder

class SurgTrack_WriteSequence : public ImportTest
{
protected:
    void writeAll() const
    {
        CameraPair cameras;
        cameras.left = endoscope();
        writeSequenceCameras(folder, cameras, "/videos/left.mp4", "", 30);
        writeSequenceTool(folder, "PSM1", "tool.yaml", Matx44d::eye());
        writeSequenceTool(folder, "PSM2", "tool.yaml", Matx44d::eye());
        const double values[] = { 1, 2, 3, 4 };
        const double t[] = { 0, 0.01 };
        const std::vector<double> times(t, t + 2);
        writeSequenceJoints(folder, "PSM1", list("q1", "jaw"), times, Mat(2, 2, CV_64F, (void*)values));
        writeSequenceJoints(folder, "PSM2", list("q1", "jaw"), times, Mat(2, 2, CV_64F, (void*)values));
    }
};

TEST_F(SurgTrack_WriteSequence, whatWasWrittenIsASequence)
{
    writeAll();
    const Ptr<Sequence> s = Sequence::load(folder);
    EXPECT_EQ(30, s->fps());
    EXPECT_EQ("/videos/left.mp4", s->leftVideo());
    EXPECT_EQ(Size(720, 576), s->leftCamera().imageSize());
    EXPECT_EQ(endoscope().fy, s->leftCamera().fy);
    EXPECT_EQ(endoscope().k[1], s->leftCamera().k[1]);
    EXPECT_FALSE(s->isStereo());
    EXPECT_EQ(2, s->toolCount());
    std::vector<double> joints;
    ASSERT_TRUE(s->jointsAt(1, 0.01, joints));
    EXPECT_EQ(4, joints[1]);
}

TEST_F(SurgTrack_WriteSequence, everythingElseIsKept)
{
    writeAll();
    put("sequence.yaml", get("sequence.yaml") + "surgeon: { name: \"Ye\", cases: [ 3, 4.5, \"x\" ] }\n"
        "board: !!opencv-matrix { rows: 1, cols: 2, dt: d, data: [ 1, 2 ] }\n");
    CameraPair cameras;
    cameras.left = cameras.right = endoscope(false);
    cameras.right_T_left(0, 3) = -0.005;
    writeSequenceCameras(folder, cameras);
    Matx44d moved = Matx44d::eye();
    moved(0, 3) = 0.1;
    writeSequenceTool(folder, "PSM1", "", moved);
    const Ptr<Sequence> s = Sequence::load(folder);
    EXPECT_EQ(30, s->fps());
    EXPECT_EQ("/videos/left.mp4", s->leftVideo());
    EXPECT_TRUE(s->isStereo());
    EXPECT_EQ(-0.005, s->right_T_left()(0, 3));
    EXPECT_FALSE(s->leftCamera().hasDistortion());
    ASSERT_EQ(2, s->toolCount());
    EXPECT_EQ(0.1, s->tool(0).nominal_T_base(0, 3));
    EXPECT_EQ(0, s->tool(1).nominal_T_base(0, 3));
    const FileStorage file(path("sequence.yaml"), FileStorage::READ);
    EXPECT_EQ("Ye", (String)file["surgeon"]["name"]);
    EXPECT_EQ(4.5, (double)file["surgeon"]["cases"][1]);
    EXPECT_EQ(2, file["board"].mat().at<double>(1));
    const String before = get("sequence.yaml");
    writeSequenceTool(folder, "PSM1", "", moved);
    EXPECT_EQ(before, get("sequence.yaml"));
    cameras.right = CameraModel();
    writeSequenceCameras(folder, cameras);
    EXPECT_FALSE(Sequence::load(folder)->isStereo());
}

TEST_F(SurgTrack_WriteSequence, readingsOfAToolAreReplaced)
{
    writeAll();
    const std::vector<double> times(1, 0.0000015);
    writeSequenceJoints(folder, "PSM1", list("q1", "jaw"), times, Mat::ones(1, 2, CV_64F));
    EXPECT_EQ("time,tool,q1,jaw\n0.000000,PSM2,1,2\n0.010000,PSM2,3,4\n0.000002,PSM1,1,1\n", get("kinematics.csv"));
    EXPECT_ERROR(writeSequenceJoints(folder, "PSM1", list("q1", "q2"), times, Mat::ones(1, 2, CV_64F)), "time,tool,q1,q2");
    EXPECT_ERROR(writeSequenceJoints(folder, "PSM1", list("q1", "jaw"), times, Mat::ones(2, 2, CV_64F)), "joints");
    EXPECT_ERROR(writeSequenceJoints(folder, "PSM1", list("q1", "jaw"), std::vector<double>(2, 0.), Mat::ones(2, 2, CV_64F)), "times[1]");
    EXPECT_ERROR(writeSequenceJoints(folder, "PSM1", list("q1", "jaw"), times, Mat(1, 2, CV_64F, Scalar(NOT_A_NUMBER))), "joints");
}

TEST_F(SurgTrack_WriteSequence, wrongArgumentsAreRefused)
{
    EXPECT_ERROR(writeSequenceCameras(folder, CameraPair()), "left camera");
    EXPECT_ERROR(writeSequenceTool(folder, "PSM1", "", Matx44d::eye()), "model");
    EXPECT_ERROR(writeSequenceTool(folder, "PSM,1", "tool.yaml", Matx44d::eye()), "name");
    EXPECT_ERROR(writeSequenceTool(folder, "PSM1", "tool.yaml", Matx44d::zeros()), "rigid");
    CameraPair cameras;
    cameras.left = endoscope();
    EXPECT_ERROR(writeSequenceCameras(put("file", "x"), cameras), "file");
    cameras.right = endoscope(true, Size(640, 480));
    EXPECT_ERROR(writeSequenceCameras(folder, cameras), "same size");
}

}} // namespace
