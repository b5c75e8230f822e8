// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/surgtrack/hand_eye.hpp"
#include "base/calib.hpp"
#include "base/checks.hpp"
#include "base/geometry.hpp"

namespace cv { namespace surgtrack {

namespace {

void checkBoard(const CalibrationBoard& board)
{
    CV_Assert((board.pattern == CalibrationBoard::CHESSBOARD || board.pattern == CalibrationBoard::ASYMMETRIC_CIRCLES) && "board.pattern is none of CalibrationBoard::Pattern");
    if (board.size.width < 2 || board.size.height < 3)
        CV_Error(Error::StsBadSize, format("board.size is %d x %d, expected at least 2 x 3", board.size.width, board.size.height));
    if (board.pattern == CalibrationBoard::CHESSBOARD && (board.size.width + board.size.height) % 2 == 0)
        CV_Error(Error::StsBadSize, format("board.size is %d x %d, expected one odd and one even number of inner corners: other chessboards look the same upside down",
                                           board.size.width, board.size.height));
    if (board.pattern == CalibrationBoard::ASYMMETRIC_CIRCLES && board.size.height % 2 == 0)
        CV_Error(Error::StsBadSize, format("board.size is %d x %d, expected an odd number of rows: other grids of circles look the same upside down",
                                           board.size.width, board.size.height));
    CV_Assert(board.spacing > 0 && board.spacing < DBL_MAX && "board.spacing must be positive");
}

bool findPoints(const Mat& image, const CalibrationBoard& board, std::vector<Point2f>& points)
{
    Mat grey = image;
    if (image.channels() == 3) cvtColor(image, grey, COLOR_BGR2GRAY);
    if (board.pattern == CalibrationBoard::CHESSBOARD)
        return findChessboardCornersSB(grey, board.size, points, CALIB_CB_NORMALIZE_IMAGE | CALIB_CB_EXHAUSTIVE | CALIB_CB_ACCURACY);
    return findCirclesGrid(grey, board.size, points, CALIB_CB_ASYMMETRIC_GRID)
           || findCirclesGrid(grey, board.size, points, CALIB_CB_ASYMMETRIC_GRID | CALIB_CB_CLUSTERING);
}

double reprojection(const CameraModel& camera, const Matx44d& camera_T_board, const Mat& boardPoints, const std::vector<Point2f>& imagePoints)
{
    double sum = 0;
    for (int i = 0; i < boardPoints.rows; i++)
    {
        const Point3d p = transform(camera_T_board, *boardPoints.ptr<Point3d>(i));
        if (p.z <= 0) return DBL_MAX;
        const Point2d d = camera.project(p) - Point2d(imagePoints[i]);
        sum += d.dot(d);
    }
    return std::sqrt(sum / boardPoints.rows);
}

} // namespace

CalibrationBoard::CalibrationBoard() : pattern(ASYMMETRIC_CIRCLES), size(4, 11), spacing(0.0015) {}

void getBoardPoints(const CalibrationBoard& board, OutputArray points)
{
    checkBoard(board);
    points.create(board.size.area(), 3, CV_64F);
    Mat_<double> p = points.getMat();
    for (int r = 0, i = 0; r < board.size.height; r++)
        for (int c = 0; c < board.size.width; c++, i++)
        {
            p(i, 0) = board.spacing * (board.pattern == CalibrationBoard::CHESSBOARD ? c : 2 * c + r % 2);
            p(i, 1) = board.spacing * r;
            p(i, 2) = 0;
        }
}

bool findBoard(InputArray _image, const CameraModel& camera, const CalibrationBoard& board, Matx44d& camera_T_board, OutputArray imagePoints, double& error)
{
    const Mat image = _image.getMat();
    checkImage(image);
    if (camera.imageSize() != image.size())
        CV_Error(Error::StsBadSize, format("image is %d x %d, expected the camera's %d x %d", image.cols, image.rows, camera.imageSize().width,
                                           camera.imageSize().height));
    Mat points;
    getBoardPoints(board, points);
    std::vector<Point2f> found;
    if (!findPoints(image, board, found)) return false;

    // From far away a flat board looks much the same tilted the other way: both poses are refined, and the better one is taken.
    std::vector<Mat> rotations, translations;
    solvePnPGeneric(points, found, camera.cameraMatrix(), camera.distCoeffs(), rotations, translations, false, SOLVEPNP_IPPE);
    double least = DBL_MAX;
    for (size_t i = 0; i < rotations.size(); i++)
    {
        solvePnPRefineLM(points, found, camera.cameraMatrix(), camera.distCoeffs(), rotations[i], translations[i]);
        Matx33d R;
        Rodrigues(rotations[i], R);
        const Matx44d T = rigidTransform(R, Vec3d(translations[i].ptr<double>()));
        const double e = checkRange(T) ? reprojection(camera, T, points, found) : DBL_MAX;
        if (e >= least) continue;
        least = e;
        camera_T_board = nearestRigid(T);
    }
    if (least == DBL_MAX) return false;
    error = least;
    if (imagePoints.needed()) Mat(found).reshape(1, (int)found.size()).convertTo(imagePoints, CV_64F);
    return true;
}

}} // namespace cv::surgtrack
