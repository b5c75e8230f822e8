// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// What hand_eye is given: cameras, board images, and poses of robot and board that belong together.

#ifndef OPENCV_SURGTRACK_SAMPLES_SUPPORT_HAND_EYE_DATA_HPP
#define OPENCV_SURGTRACK_SAMPLES_SUPPORT_HAND_EYE_DATA_HPP

#include <map>
#include "opencv2/imgcodecs.hpp"
#include "opencv2/surgtrack.hpp"
#include "opencv2/surgtrack/lab.hpp"
#include "common.hpp"
#include "opencv2/core/utils/filesystem.hpp"

namespace hand_eye {

using namespace cv;
using namespace cv::surgtrack;
using common::fail;

//! Poses by index or time.
struct Poses
{
    bool byTime;
    std::vector<double> keys;
    Mat poses;    //!< N x 16

    Matx44d at(int i) const { return Matx44d(poses.ptr<double>(i)); }
};

inline Poses loadPoses(const String& filename)
{
    Poses p;
    p.byTime = readPoses(filename, p.keys, p.poses);
    return p;
}

//! Poses of both, a row each, with what names them in messages.
struct Pairs
{
    Mat robot, board;
    std::vector<String> names;
};

//! The rigid transform a share of the way from a to b, 0 to 1.
inline Matx44d between(const Matx44d& a, const Matx44d& b, double share)
{
    Matx44d sum = a * (1 - share) + b * share;    // of readings that follow each other closely
    Matx31d w;
    Matx33d u, vt;
    SVD::compute(sum.get_minor<3, 3>(0, 0), w, u, vt);
    const Matx33d R = u * vt;
    for (int i = 0; i < 9; i++) sum(i / 3, i % 3) = R(i / 3, i % 3);
    return sum;
}

//! By index: those that both have. By time: the robot's poses between its two nearest readings; board poses outside of them have none.
inline Pairs pair(const Poses& robot, const Poses& board, const String& robotFile, const String& boardName)
{
    if (robot.byTime != board.byTime)
        fail(robotFile + ": has a column '" + (robot.byTime ? "time" : "index") + "', expected '" + (board.byTime ? "time" : "index") + "' as " + boardName + " has");
    Pairs pairs;
    for (int i = 0; i < (int)board.keys.size(); i++)
    {
        const double key = board.keys[i];
        const int next = (int)(std::lower_bound(robot.keys.begin(), robot.keys.end(), key) - robot.keys.begin());
        const bool exact = next < (int)robot.keys.size() && robot.keys[next] == key;
        if (!exact && (!robot.byTime || next == 0 || next == (int)robot.keys.size())) continue;
        const double share = exact ? 1 : (key - robot.keys[next - 1]) / (robot.keys[next] - robot.keys[next - 1]);
        const Matx44d T = exact ? robot.at(next) : between(robot.at(next - 1), robot.at(next), share);
        pairs.robot.push_back(Mat(T).reshape(1, 1));
        pairs.board.push_back(board.poses.row(i));
        pairs.names.push_back(format(robot.byTime ? "time %g" : "index %g", key));
    }
    if (pairs.names.size() < 4)
        fail(format("%s and %s have %d poses in common, expected at least 4", robotFile.c_str(), boardName.c_str(), (int)pairs.names.size()));
    return pairs;
}

//! Not more than `most`, evenly spread.
inline void thin(Pairs& pairs, int most)
{
    const int n = (int)pairs.names.size();
    if (n <= most) return;
    Pairs fewer;
    for (int i = 0; i < most; i++)
    {
        const int k = (int)((int64)i * n / most);
        fewer.robot.push_back(pairs.robot.row(k));
        fewer.board.push_back(pairs.board.row(k));
        fewer.names.push_back(pairs.names[k]);
    }
    pairs = fewer;
}

inline Mat readMatrix(const FileNode& node)
{
    Mat m;
    try
    {
        if (node.isMap()) node >> m;
    }
    catch (const Exception&) {}
    return m;
}

//! The camera of a sequence (the left one), or of a calibration file of OpenCV or ROS.
inline CameraModel readCamera(const String& path)
{
    const String filename = utils::fs::isDirectory(path) ? utils::fs::join(path, "sequence.yaml") : path;
    FileStorage file;
    try
    {
        file.open(filename, FileStorage::READ);
    }
    catch (const Exception&)   // no file of cv::FileStorage: one of ROS, or an error that says what is wrong
    {
        return importCameraInfo(std::vector<String>(1, filename)).left;
    }
    if (!file.isOpened()) fail(filename + ": can't be read, expected a sequence.yaml or a camera calibration of cv::FileStorage");
    if (!file["left"].isMap())
        return importOpenCVCameras(std::vector<String>(1, filename)).left;
    const FileNode node = file["left"];
    const Mat K = readMatrix(node["camera_matrix"]);
    if (K.empty()) fail(filename + ": key left.camera_matrix is missing, expected a 3x3 matrix");
    const char* const sizes[] = { "image_width", "image_height" };
    for (int i = 0; i < 2; i++)
        if (!file[sizes[i]].isInt()) fail(filename + ": key " + sizes[i] + " is missing, expected a whole number [pixel]");
    try
    {
        return CameraModel(K, readMatrix(node["distortion_coefficients"]), Size((int)file["image_width"], (int)file["image_height"]));
    }
    catch (const Exception& e)
    {
        fail(filename + ": " + e.err);
    }
}

//! The last number in a file's name.
inline int imageNumber(const String& path)
{
    const String name = path.substr(path.find_last_of("/\\") + 1);
    const size_t dot = name.rfind('.'), last = name.find_last_of("0123456789", dot == String::npos ? dot : dot - 1);
    if (last == String::npos) fail(path + ": expected a number in the name, the index of its robot pose");
    const size_t before = name.find_last_not_of("0123456789", last), first = before == String::npos ? 0 : before + 1;
    if (last - first >= 9) fail(path + ": expected a number of at most nine digits at the end of the name, the index of its robot pose");
    return std::atoi(name.substr(first, last - first + 1).c_str());
}

//! Board poses of all images of a folder, by the number in their names.
inline Poses findBoards(const String& folder, const CameraModel& camera, const CalibrationBoard& board, bool quiet)
{
    if (!utils::fs::isDirectory(folder)) fail(folder + ": expected a folder of images");
    std::vector<String> files;
    glob(utils::fs::join(folder, "*"), files);
    std::map<int, String> images;
    for (size_t i = 0; i < files.size(); i++)
    {
        if (!haveImageReader(files[i])) continue;
        String& image = images[imageNumber(files[i])];
        if (!image.empty()) fail(files[i] + ": has the number of " + image + ", expected another for each image");
        image = files[i];
    }
    if (images.empty()) fail(folder + ": has no images");

    Poses found;
    found.byTime = false;
    common::Progress progress((int)images.size(), quiet);
    int done = 0;
    double sum = 0;
    String missed;
    for (std::map<int, String>::const_iterator it = images.begin(); it != images.end(); ++it)
    {
        const Mat image = imread(it->second);
        if (image.empty()) fail(it->second + ": can't be read as an image");
        if (image.size() != camera.imageSize())
            fail(format("%s: is %d x %d, expected %d x %d as the camera was calibrated with", it->second.c_str(), image.cols, image.rows,
                        camera.imageSize().width, camera.imageSize().height));
        Matx44d T;
        double error = 0;
        if (findBoard(image, camera, board, T, noArray(), error))
        {
            found.keys.push_back(it->first);
            found.poses.push_back(Mat(T).reshape(1, 1));
            sum += error * error;
        }
        else
            missed += format(" %d", it->first);
        progress.show(++done);
    }
    progress.clear();
    if (found.keys.empty()) fail(format("%s: no board of %d x %d in any of its %d images", folder.c_str(), board.size.width, board.size.height, done));
    std::printf("board found in %d of %d images, its points %.2f pixel (rms) off\n", (int)found.keys.size(), done, std::sqrt(sum / found.keys.size()));
    if (!missed.empty()) std::printf("no board in image%s\n", missed.c_str());
    return found;
}

} // namespace hand_eye

#endif
