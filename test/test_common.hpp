// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_TEST_COMMON_HPP
#define OPENCV_SURGTRACK_TEST_COMMON_HPP

#include "test_data.hpp"
#if CV_VERSION_MAJOR >= 5   // distances and rectangles too are there
#include "opencv2/geometry.hpp"
#else
#include "opencv2/calib3d.hpp"
#endif

#include <fstream>
#include <limits>
#include <map>
#include <set>

namespace opencv_test { namespace {

using namespace cv::surgtrack;

const double NOT_A_NUMBER = std::numeric_limits<double>::quiet_NaN();

// The text of the cv::Exception a call throws; "" if it throws none.
template <typename Call> std::string errorText(const Call& call)
{
    try
    {
        call();
    }
    catch (const cv::Exception& e)
    {
        return e.what();
    }
    return std::string();
}

// The message names what is wrong.
#define EXPECT_ERROR(statement, what)                                                                                       \
    do                                                                                                                      \
    {                                                                                                                       \
        const std::string text_ = errorText([&]() { statement; });                                                          \
        EXPECT_NE(std::string::npos, text_.find(what)) << #statement << ": the message is '" << text_ << "'";               \
    } while (false)

inline Matx44d rigid(const Matx33d& R, const Point3d& t)
{
    return Matx44d(R(0, 0), R(0, 1), R(0, 2), t.x, R(1, 0), R(1, 1), R(1, 2), t.y, R(2, 0), R(2, 1), R(2, 2), t.z, 0, 0, 0, 1);
}

// Rodrigues' formula.
inline Matx33d rotationMatrix(const Vec3d& v)
{
    const double angle = cv::norm(v);
    if (angle < 1e-12) return Matx33d(1, -v[2], v[1], v[2], 1, -v[0], -v[1], v[0], 1);
    const Vec3d a = v * (1 / angle);
    const Matx33d K(0, -a[2], a[1], a[2], 0, -a[0], -a[1], a[0], 0);
    return Matx33d::eye() + std::sin(angle) * K + (1 - std::cos(angle)) * (K * K);
}

// The rotation vector of a rotation of less than 180 degrees.
inline Vec3d rotationVector(const Matx33d& R)
{
    const Vec3d v(R(2, 1) - R(1, 2), R(0, 2) - R(2, 0), R(1, 0) - R(0, 1));
    const double sine = cv::norm(v), angle = std::atan2(sine, trace(R) - 1);
    return sine < 1e-12 ? v * 0.5 : v * (angle / sine);
}

inline double rotationAngle(const Matx44d& A, const Matx44d& B)
{
    const Matx44d D = A.inv() * B;
    return cv::norm(rotationVector(D.get_minor<3, 3>(0, 0)));
}

inline double distance(const Matx44d& A, const Matx44d& B)
{
    return cv::norm(Vec3d(A(0, 3) - B(0, 3), A(1, 3) - B(1, 3), A(2, 3) - B(2, 3)));
}

inline Point3d transformed(const Matx44d& T, const Point3d& p)
{
    const Vec4d v = T * Vec4d(p.x, p.y, p.z, 1);
    return Point3d(v[0], v[1], v[2]);
}

// Numbers one after another, the last first. In the arguments of a call compilers draw them in different orders.
template <int n> inline Vec<double, n> uniform(RNG& rng, const Vec<double, n>& low, const Vec<double, n>& high)
{
    Vec<double, n> v;
    for (int i = n - 1; i >= 0; i--) v[i] = rng.uniform(low[i], high[i]);
    return v;
}

template <int n> inline Vec<double, n> gaussian(RNG& rng, double deviation)
{
    Vec<double, n> v;
    for (int i = n - 1; i >= 0; i--) v[i] = rng.gaussian(deviation);
    return v;
}

inline Vec3d randomDirection(RNG& rng)
{
    Vec3d v;
    do v = gaussian<3>(rng, 1);
    while (cv::norm(v) < 1e-3);
    return v * (1 / cv::norm(v));
}

// An endoscope's camera with the paper's own unequal focal lengths and barrel distortion, for any image width.
inline CameraModel endoscope(bool distorted = true, Size size = Size(720, 576))
{
    const double s = size.width / 720.;
    const Matx33d K(854.7 * s, 0, 340 * s, 0, 935.1 * s, 0.47 * size.height, 0, 0, 1);
    const Matx<double, 1, 5> D(-0.2334, 0.148, -0.0058, 0.001, 0);
    return CameraModel(K, distorted ? Mat(D) : Mat(), size);
}

// Blotches of all sizes between low and high grey levels: edges in all directions.
inline Mat textured(Size size, int channels, uint64 seed, double low = 0, double high = 255)
{
    RNG rng(seed);
    Mat result(size, CV_MAKETYPE(CV_8U, channels));
    std::vector<Mat> planes(channels);
    for (int c = 0; c < channels; c++)
    {
        Mat fine(size, CV_32F), coarse(Size(size.width / 6 + 2, size.height / 6 + 2), CV_32F), enlarged;
        rng.fill(fine, RNG::UNIFORM, 0, 1);
        rng.fill(coarse, RNG::UNIFORM, 0, 1);
        resize(coarse, enlarged, size, 0, 0, INTER_LINEAR);
        Mat sum = enlarged + 0.3 * fine;
        cv::normalize(sum, sum, low, high, NORM_MINMAX);
        sum.convertTo(planes[c], CV_8U);
    }
    merge(planes, result);
    return result;
}

// Made once: immutable.
inline Ptr<ToolModel> needleDriver()
{
    static const Ptr<ToolModel> model = ToolModel::needleDriver();
    return model;
}

/* The built-in tool in front of a camera.
   depth, at: of its end effector [m]; roll: about the viewing axis; tilt: of the shaft against it; wrist: its two bends [rad] */
struct PosedTool
{
    explicit PosedTool(double depth = 0.1, double roll = 0.3, double tilt = 1.1, double wrist = 0.35, const Point2d& at = Point2d())
        : model(needleDriver()), joints(model->coordinateNames().size(), 0.)
    {
        set("q3", 0.12);
        set("q4", 0.4);
        set("q5", wrist);
        set("q6", -wrist);
        set("jaw", 0.5);
        const Matx33d R = rotationMatrix(Vec3d(0, 0, roll)) * rotationMatrix(Vec3d(0, tilt, 0));
        camera_T_tool = rigid(R, Point3d(at.x, at.y, depth));
        place();
    }

    void set(const String& coordinate, double value)
    {
        const int index = model->coordinateIndex(coordinate);
        CV_Assert(index >= 0);
        joints[index] = value;
    }

    void place()
    {
        view.camera_T_base = camera_T_tool * model->endEffectorPose(joints).inv();
        model->forwardKinematics(joints, view.base_T_link);
    }

    Point3d keypoint(size_t i) const
    {
        const ToolModel::Keypoint& k = model->keypoints()[i];
        return transformed(view.camera_T_base * view.base_T_link[k.link], k.linkPoint);
    }

    Ptr<ToolModel> model;
    std::vector<double> joints;
    Matx44d camera_T_tool;
    ToolView view;
};

inline bool sameMatches(const std::vector<PartMatch>& a, const std::vector<PartMatch>& b)
{
    if (a.size() != b.size()) return false;
    for (size_t i = 0; i < a.size(); i++)
        if (a[i].tool != b[i].tool || a[i].part != b[i].part || a[i].imagePoint != b[i].imagePoint || a[i].similarity != b[i].similarity
            || a[i].predictedPoint != b[i].predictedPoint || a[i].templateIndex != b[i].templateIndex)
            return false;
    return true;
}

/* A folder that is removed again. */
class TempFolder
{
public:
    TempFolder() : path_(cv::tempfile()) { CV_Assert(cv::utils::fs::createDirectories(path_)); }
    ~TempFolder() { cv::utils::fs::remove_all(path_); }
    String operator/(const String& name) const { return cv::utils::fs::join(path_, name); }

private:
    String path_;
};

}} // namespace

#endif
