// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_hand_eye.hpp"

#include <cstdio>
#include <fstream>
#include "opencv2/core/utils/filesystem.hpp"

namespace opencv_test { namespace {

// A board as the camera sees it: where the ray of each pixel meets it. Four samples a pixel.
Mat photograph(const CameraModel& camera, const CalibrationBoard& board, const Matx44d& camera_T_board)
{
    Mat points;
    getBoardPoints(board, points);
    const double s = board.spacing, right = points.at<double>(points.rows - 1, 0), bottom = points.at<double>(points.rows - 1, 1);
    const Matx44d board_T_camera = camera_T_board.inv();
    const Point3d centre = transformed(board_T_camera, Point3d());
    const Point3d corners[] = { Point3d(-2 * s, -2 * s, 0), Point3d(right + 3 * s, -2 * s, 0), Point3d(right + 3 * s, bottom + 2 * s, 0),
                                Point3d(-2 * s, bottom + 2 * s, 0) };
    Rect2d outline;
    for (int i = 0; i < 4; i++) outline |= Rect2d(camera.project(transformed(camera_T_board, corners[i])) - Point2d(5, 5), Size(10, 10));
    Mat image(camera.imageSize(), CV_8U, Scalar(110));
    const Rect window = Rect(outline) & Rect(Point(), image.size());
    for (int v = window.y; v < window.br().y; v++)
    {
        Mat pixels(4 * window.width, 2, CV_64F), rays;
        for (int i = 0; i < pixels.rows; i++)
        {
            pixels.at<double>(i, 0) = window.x + i / 4 + (i & 1) * 0.5 - 0.25;
            pixels.at<double>(i, 1) = v + (i >> 1 & 1) * 0.5 - 0.25;
        }
        camera.unprojectPoints(pixels, rays);
        for (int u = window.x; u < window.br().x; u++)
        {
            double sum = 0;
            for (int i = 4 * (u - window.x); i < 4 * (u - window.x) + 4; i++)
            {
                const Point2d ray = rays.at<Point2d>(i);
                const Point3d d = transformed(board_T_camera, Point3d(ray.x, ray.y, 1)) - centre, p = centre - d * (centre.z / d.z);
                bool dark = false;
                const bool on = p.x > -2 * s && p.y > -2 * s && p.x < right + 3 * s && p.y < bottom + 2 * s;
                if (board.pattern == CalibrationBoard::CHESSBOARD)
                    dark = p.x > -s && p.y > -s && p.x < right + s && p.y < bottom + s && (cvFloor(p.x / s) + cvFloor(p.y / s)) % 2 != 0;
                else
                    for (int j = 0; j < points.rows; j++) dark = dark || std::hypot(p.x - points.at<double>(j, 0), p.y - points.at<double>(j, 1)) < 0.4 * s;
                sum += !on ? 110 : dark ? 25 : 230;
            }
            image.at<uchar>(v, u) = saturate_cast<uchar>(sum / 4);
        }
    }
    return image;
}

CalibrationBoard chessboard()
{
    CalibrationBoard board;
    board.pattern = CalibrationBoard::CHESSBOARD;
    board.size = Size(7, 6);
    board.spacing = 0.003;
    return board;
}

TEST(SurgTrack_HandEye, aBoardIsFoundWithDistortionAnyWayUp)
{
    const CameraModel camera = endoscope();
    const CalibrationBoard boards[] = { CalibrationBoard(), chessboard() };
    for (int i = 0; i < 2; i++)
        for (int roll = -2; roll <= 3; roll++)
        {
            const Matx44d T = rigid(rotationMatrix(Vec3d(0.3, -0.2, 0)) * rotationMatrix(Vec3d(0, 0, roll * 60 * degree)), Point3d(0.002, -0.001, 0.09));
            Matx44d found;
            Mat points;
            double error = -1;
            ASSERT_TRUE(findBoard(photograph(camera, boards[i], T), camera, boards[i], found, points, error)) << i << " " << roll;
            EXPECT_EQ(boards[i].size.area(), points.rows);
            EXPECT_LT(error, 0.2);                                   // pixel; four samples a pixel place an edge to about a quarter
            EXPECT_LT(rotationAngle(found, T), 1 * degree);          // 0.2 pixel of 100, times sqrt(1 / 40 points), seen at 20 degrees
            EXPECT_LT(distance(found, T), 0.0005);                   // 0.2 % of the distance, likewise, and the board's corner turns
        }
}

TEST(SurgTrack_HandEye, aBoardThatIsNotThereIsNotFound)
{
    const CameraModel camera = endoscope();
    Matx44d T = Matx44d::eye() * 7.;
    double error = -1;
    Mat points;
    EXPECT_FALSE(findBoard(textured(camera.imageSize(), 3, 1), camera, CalibrationBoard(), T, points, error));
    EXPECT_FALSE(findBoard(Mat(camera.imageSize(), CV_8U, Scalar(128)), camera, chessboard(), T, points, error));
    EXPECT_EQ(7, T(0, 0));
    EXPECT_EQ(-1, error);
    EXPECT_ERROR(findBoard(Mat(100, 100, CV_8U, Scalar(0)), camera, chessboard(), T, points, error), "image is 100 x 100, expected the camera's 720 x 576");
}

TEST(SurgTrack_HandEye, aBoardThatLooksTheSameUpsideDownIsRefused)
{
    CalibrationBoard board = chessboard();
    Mat points;
    board.size = Size(8, 6);
    EXPECT_ERROR(getBoardPoints(board, points), "upside down");
    board.size = Size(7, 5);
    EXPECT_ERROR(getBoardPoints(board, points), "upside down");
    board = CalibrationBoard();
    board.size = Size(4, 10);
    EXPECT_ERROR(getBoardPoints(board, points), "upside down");
    board = CalibrationBoard();
    board.spacing = 0;
    EXPECT_ERROR(getBoardPoints(board, points), "board.spacing");
    getBoardPoints(CalibrationBoard(), points);
    ASSERT_EQ(44, points.rows);
    EXPECT_EQ(0.0015 * 7, points.at<double>(7, 0));   // last of the second row
    EXPECT_EQ(0.0015 * 1, points.at<double>(7, 1));
}

TEST(SurgTrack_HandEye, imagesOfABoardGiveTheCalibration)
{
    const Recording r(21, HAND_EYE_BOARD_ON_TOOL, 8, 0, 0, 25 * degree);
    const CameraModel camera = endoscope();
    const CalibrationBoard board;
    Mat points;
    getBoardPoints(board, points);
    std::vector<Matx44d> robot, found;
    for (size_t i = 0; i < r.board.size(); i++)
    {
        Matx44d T;
        double error;
        Mat at;
        if (!findBoard(photograph(camera, board, r.board[i]), camera, board, T, at, error)) continue;
        robot.push_back(r.robot[i]);
        found.push_back(T);
    }
    ASSERT_GE(found.size(), 6u);    // others may reach out of the image
    HandEyeResult result;
    ASSERT_TRUE(estimateHandEye(robot, found, result, HandEyeParams(), camera, points));
    EXPECT_LT(r.errorAtBoard(result.best.camera_T_mount), 0.0005);                                  // as a single board pose above
    EXPECT_LT(rotationAngle(result.best.camera_T_mount, r.camera_T_mount), 0.5 * degree);           // half of one above, for six
    EXPECT_LT(result.best.pixels, 2.);                                                              // exact robot: tilt and depth of the boards
}

String written(const String& text, const char* extension = ".csv")
{
    const String filename = cv::tempfile(extension);
    std::ofstream(filename.c_str(), std::ios::binary) << text;
    return filename;
}

String textOf(const String& filename)
{
    std::ifstream file(filename.c_str(), std::ios::binary);
    return String((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
}

TEST(SurgTrack_HandEye, posesAreReadByIndexAndByTime)
{
    std::vector<double> keys;
    Mat poses;
    const String file = written("index,tx,ty,tz,qx,qy,qz,qw,note\n3,0.1,0.2,0.3,0,0,0,1,a\n7,0,0,0.1,0,0,0.6,0.8,b\n");
    EXPECT_FALSE(readPoses(file, keys, poses));
    ASSERT_EQ(Size(16, 2), poses.size());
    EXPECT_EQ(7, keys[1]);
    EXPECT_EQ(0.2, poses.at<double>(0, 7));
    EXPECT_NEAR(0.28, poses.at<double>(1, 0), 1e-12);    // cos of twice acos 0.8; rounding
    EXPECT_NEAR(-0.96, poses.at<double>(1, 1), 1e-12);   // the same
    std::remove(file.c_str());

    const String head = "time,tx,ty,tz,qx,qy,qz,qw\n";
    const char* const wrong[][2] = { { "0.5,100,0,30,0,0,0,1\n", "line 2: tx,ty,tz is 104.4 m away, expected metres" },
                                     { "0.5,0,0,0,0,0,0,0.5\n", "line 2: qx,qy,qz,qw has length 0.5" },
                                     { "0.5,0,0,0,0,0,0,1\n0.5,0,0,0,0,0,0,1\n", "line 3: time is 0.5 after 0.5, expected rising values" },
                                     { "0.5,0,0,nan,0,0,0,1\n", "line 2: tz is 'nan'" },
                                     { "", "has no poses" } };
    for (int i = 0; i < 5; i++)
    {
        const String bad = written(head + wrong[i][0]);
        EXPECT_ERROR(readPoses(bad, keys, poses), wrong[i][1]);
        EXPECT_ERROR(readPoses(bad, keys, poses), bad);
        std::remove(bad.c_str());
    }
    const String unkeyed = written("tx,ty,tz,qx,qy,qz,qw\n0,0,0,0,0,0,1\n");
    EXPECT_ERROR(readPoses(unkeyed, keys, poses), "expected a column 'index' or a column 'time'");
    std::remove(unkeyed.c_str());
    EXPECT_ERROR(readPoses("/none/poses.csv", keys, poses), "/none/poses.csv");
}

const char* const description =
    "%YAML:1.0\n---\nfps: 25   # frames\ntools:\n"
    "   # camera_T_base: !!opencv-matrix, data: [ 0 ], of the old camera\n"
    "   -\n      name: \"camera_T_base data: [ 1 ]\"\n      model: \"a.yaml\"\n"
    "      camera_T_base: !!opencv-matrix\n         rows: 4\n         cols: 4\n         dt: d\n"
    "         data: [ 1, 0, 0, 0.5, 0, 1, 0, 0.25, 0, 0, 1, 0, 0, 0, 0, 1 ]\n"
    "   - { name: PSM2, my_camera_T_base: 3, camera_T_base: !!opencv-matrix { rows: 4, cols: 4, dt: d,\n"
    "         data: [ 1, 0, 0, 0, 0, 1, 0, 0,\n         0, 0, 1, 0, 0, 0, 0, 1 ] } }\nextra: [ 1, 2.5, yes ]\n";

TEST(SurgTrack_HandEye, onlyTheMatrixOfTheToolIsReplaced)
{
    const Matx44d T = rigid(rotationMatrix(Vec3d(0.1, 0.2, 0.3)), Point3d(0.01, -0.02, 0.1234567890123456789));
    const char* const names[] = { "camera_T_base data: [ 1 ]", "PSM2" };
    for (int i = 0; i < 2; i++)
    {
        const String file = written(description, ".yaml");
        writeHandEye(file, names[i], T);
        const String after = textOf(file), before = description;
        const size_t open = before.find("[ 1, 0, 0, 0", i ? before.find("PSM2") : 0), close = before.find(']', open);
        EXPECT_EQ(before.substr(0, open), after.substr(0, open));
        EXPECT_EQ(before.substr(close), after.substr(after.size() - (before.size() - close)));
        Mat read;
        cv::FileStorage(file, cv::FileStorage::READ)["tools"][i]["camera_T_base"] >> read;
        EXPECT_EQ(0, cv::norm(read, Mat(T), NORM_INF));
        EXPECT_FALSE(cv::utils::fs::exists(file + ".new"));
        std::remove(file.c_str());
    }
}

TEST(SurgTrack_HandEye, aDescriptionThatCannotBeChangedStaysAsItIs)
{
    const String file = written(description, ".yaml");
    EXPECT_ERROR(writeHandEye(file, "PSM3", Matx44d::eye()), "no tool 'PSM3', expected one of: camera_T_base data: [ 1 ], PSM2");
    EXPECT_ERROR(writeHandEye(file, "PSM2", Matx44d::eye() * 2.), "camera_T_base must be rigid");
    EXPECT_EQ(String(description), textOf(file));
    std::remove(file.c_str());
    const String missing = written("%YAML:1.0\n---\ntools:\n   - { name: PSM1, model: a }\n", ".yaml");
    EXPECT_ERROR(writeHandEye(missing, "PSM1", Matx44d::eye()), "tools[0].camera_T_base is missing");
    std::remove(missing.c_str());
    EXPECT_ERROR(writeHandEye("/none", "PSM1", Matx44d::eye()), "/none");
}

}} // namespace
