// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/imgproc.hpp"
#include "opencv2/videoio.hpp"
#include "opencv2/surgtrack/setup_check.hpp"
#include "base/calib.hpp"

namespace cv { namespace surgtrack {

namespace {

//! How well patches of one image are found in the other, if that stands as other_T_one says: the best over all depths.
void agreement(const Mat& one, const Mat& other, const std::vector<Point2f>& corners, const CameraModel& oneCamera,
               const CameraModel& otherCamera, const Matx44d& other_T_one, std::vector<double>& best)
{
    const int half = 8;
    best.assign(corners.size(), -1);
    std::vector<Point2d> pixels(corners.begin(), corners.end());
    Mat found;
    oneCamera.unprojectPoints(pixels, found);
    const Mat_<double> rays = found.reshape(1, (int)corners.size());
    for (size_t i = 0; i < corners.size(); i++)
    {
        std::vector<Point3d> points;
        for (double inverse = 1 / 0.03; inverse > 1 / 0.5; inverse *= 0.985)
        {
            const double z = 1 / inverse;
            const double x = rays((int)i, 0) * z, y = rays((int)i, 1) * z;
            const Vec4d p = other_T_one * Vec4d(x, y, z, 1);
            if (p[2] > 0)
                points.push_back(Point3d(p[0], p[1], p[2]));
        }
        if (points.empty())
            continue;
        Mat pixelsThere;
        otherCamera.projectPoints(points, pixelsThere);
        std::vector<Point2d> there;
        pixelsThere.reshape(2).copyTo(there);
        const Rect patch(cvRound(corners[i].x) - half, cvRound(corners[i].y) - half, 2 * half + 1, 2 * half + 1), all(Point(), one.size());
        for (size_t k = 0; k < there.size(); k++)
        {
            const Rect at(cvRound(there[k].x) - half, cvRound(there[k].y) - half, 2 * half + 1, 2 * half + 1);
            if ((patch & all) != patch || (at & all) != at)
                continue;
            Mat result;
            matchTemplate(other(at), one(patch), result, TM_CCOEFF_NORMED);
            best[i] = std::max(best[i], (double)result.at<float>(0, 0));
        }
    }
}

} // namespace

String checkEyes(const Ptr<Sequence>& sequence)
{
    if (!sequence) CV_Error(Error::StsNullPtr, "sequence: expected one that is loaded");
    if (!sequence->isStereo()) return String();
    Mat left, right;
    VideoCapture a(sequence->leftVideo()), b(sequence->rightVideo());
    if (!a.read(left) || !b.read(right) || left.size() != sequence->frameSize() || right.size() != sequence->frameSize())
        return String();
    sequence->eyeImage(left.clone(), left, 0);
    sequence->eyeImage(right.clone(), right, 1);
    cvtColor(left, left, COLOR_BGR2GRAY);
    cvtColor(right, right, COLOR_BGR2GRAY);
    std::vector<Point2f> corners;
    goodFeaturesToTrack(left, corners, 150, 0.02, 12);
    if (corners.empty())
        return String();
    const Matx44d T = sequence->right_T_left();
    std::vector<double> given, exchanged;
    agreement(left, right, corners, sequence->leftCamera(), sequence->rightCamera(), T, given);
    agreement(left, right, corners, sequence->rightCamera(), sequence->leftCamera(), T.inv(), exchanged);
    int forGiven = 0, forExchanged = 0;
    for (size_t i = 0; i < corners.size(); i++)
    {
        forGiven += given[i] > 0.9 && given[i] > exchanged[i] + 0.1;
        forExchanged += exchanged[i] > 0.9 && exchanged[i] > given[i] + 0.1;
    }
    if (forExchanged >= 10 && forExchanged > 3 * forGiven)
        return sequence->descriptionFile() + format(": left.video, right.video: what is seen in the right image contradicts right_T_left (%d of %d places): are the "
                      "eyes exchanged?", forExchanged, forGiven + forExchanged);
    return String();
}

}} // namespace cv::surgtrack
