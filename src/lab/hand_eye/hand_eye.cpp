// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "base/checks.hpp"
#include "base/geometry.hpp"
#include "lab/hand_eye/hand_eye_motion.hpp"
#include "lab/hand_eye/hand_eye_reject.hpp"

namespace cv { namespace surgtrack {

namespace {

const int leastPoses = 4;               // three to calibrate, one to check
const int mostPoses = 200;              // the methods look at all pairs
const double defaultBoard = 0.0075;     // [m]; half the side of the square
const char* const names[] = { "best", "tsai", "park", "horaud", "andreff", "daniilidis", "shah", "li", "refined" };

std::vector<Matx44d> readTransforms(InputArray array, const char* name)
{
    Mat m = array.getMat();
    if ((m.depth() != CV_64F && m.depth() != CV_32F) || m.total() * m.channels() % 16 != 0)
        CV_Error(Error::StsBadArg, format("%s must be N x 4 x 4 and floating point, is of type %s with %d numbers", name,
                                          typeToString(m.type()).c_str(), (int)(m.total() * m.channels())));
    const Mat continuous = m.clone();
    Mat((int)(m.total() * m.channels() / 16), 16, m.depth(), continuous.data).convertTo(m, CV_64F);    // whatever its dimensions
    std::vector<Matx44d> poses;
    for (int i = 0; i < m.rows; i++)
    {
        const Matx44d T(m.ptr<double>(i));
        if (!isRigid(T)) CV_Error(Error::StsBadArg, format("%s: pose %d is not rigid: expected a finite rotation, translation and the last row 0 0 0 1", name, i));
        poses.push_back(nearestRigid(T));
    }
    return poses;
}

std::vector<Point3d> readBoard(InputArray array)
{
    std::vector<Point3d> points;
    if (array.empty())
        for (int i = 0; i < 4; i++) points.push_back(Point3d(i & 1 ? defaultBoard : -defaultBoard, i & 2 ? defaultBoard : -defaultBoard, 0));
    const Mat rows = asRows(array, 3, "boardPoints");
    for (int i = 0; i < rows.rows; i++) points.push_back(*rows.ptr<Point3d>(i));
    return points;
}

HandEyeProblem readProblem(InputArray robotPoses, InputArray boardPoses, const HandEyeParams& params, const CameraModel& camera, InputArray boardPoints)
{
    std::vector<Matx44d> M = readTransforms(robotPoses, "robotPoses");
    const std::vector<Matx44d> B = readTransforms(boardPoses, "boardPoses");
    const std::vector<Point3d> points = readBoard(boardPoints);
    CV_CheckEQ(M.size(), B.size(), "robotPoses and boardPoses: as many of the one as of the other");
    if ((int)M.size() < leastPoses)
        CV_Error(Error::StsBadSize, format("robotPoses: %d poses, expected at least %d", (int)M.size(), leastPoses));
    if ((int)M.size() > mostPoses)
        CV_Error(Error::StsBadSize, format("robotPoses: %d poses, expected at most %d", (int)M.size(), mostPoses));
    if (params.setup == HAND_EYE_CAMERA_ON_ARM)
        for (size_t i = 0; i < M.size(); i++) M[i] = rigidInverse(M[i]);
    for (size_t i = 0; i < B.size() && !camera.imageSize().empty(); i++)
        for (size_t j = 0; j < points.size(); j++)
            if (!(transform(B[i], points[j]).z > nearestDepth))
                CV_Error(Error::StsBadArg, format("boardPoses: pose %d has a point of the board behind the camera", (int)i));
    return HandEyeProblem(M, B, camera, points);
}

//! Root mean squares of errors.
struct Sums
{
    Sums() : translation(0), rotation(0), pixels(0), n(0) {}
    void add(const HandEyeError& e)
    {
        translation += e.translation * e.translation;
        rotation += e.rotation * e.rotation;
        pixels += e.pixels * e.pixels;
        n++;
    }
    double mean(double sum) const { return std::sqrt(sum / n); }
    double translation, rotation, pixels;
    int n;
};

//! A method's solutions: from all poses, and from all but a group each.
struct Solutions
{
    Solutions() : valid(false), leftOut(DBL_MAX) {}
    bool valid;
    double leftOut;    //!< weighted error of the poses left out; what methods are compared by
    HandEye all;
    std::vector<HandEye> others;
};

//! start: for HAND_EYE_REFINED, else not read
Solutions solveAll(const HandEyeProblem& problem, const Indices& poses, int method, const Solutions& start)
{
    const std::vector<Indices> groups = groupsOf(poses);
    const bool refined = method == HAND_EYE_REFINED;
    Solutions s = start;
    s.leftOut = DBL_MAX;
    s.others.resize(groups.size());
    s.valid = refined ? start.valid : problem.solve(method, poses, s.all);
    if (!s.valid) return s;
    if (refined) problem.refine(poses, s.all);
    std::vector<uchar> solved(groups.size(), 1);
    parallel_for_(Range(0, (int)groups.size()), [&](const Range& range)
    {
        for (int g = range.start; g < range.end; g++)
        {
            const Indices rest = without(poses, groups[g]);
            if (refined) problem.refine(rest, s.others[g]);
            else solved[g] = problem.solve(method, rest, s.others[g]);
        }
    });
    s.valid = std::count(solved.begin(), solved.end(), 0) == 0;
    double sum = 0;
    for (size_t g = 0; g < groups.size() && s.valid; g++)
        for (size_t i = 0; i < groups[g].size(); i++) sum += std::pow(problem.weighted(problem.error(s.others[g], groups[g][i]).e), 2);
    if (s.valid) s.leftOut = std::sqrt(sum / poses.size());
    return s;
}

/* Standard deviations by the jackknife: (n - 1) / n times the sum of the squared differences from the mean. Of the translation where
   the board was: that of the mount's origin, which is far away, would say more of the rotation. */
void measureSpread(const HandEyeProblem& problem, const Indices& poses, const Solutions& s, HandEyeFit& fit)
{
    Point3d place;
    for (size_t i = 0; i < poses.size(); i++) place += transform(problem.B()[poses[i]], problem.middle()) * (1. / poses.size());
    const Point3d mountPlace = transform(rigidInverse(s.all.X), place);
    Matx44d sum = Matx44d::zeros();
    for (size_t g = 0; g < s.others.size(); g++) sum += s.others[g].X;
    const Matx44d mean = nearestRigid(sum * (1. / s.others.size()));
    double translation = 0, rotation = 0;
    for (size_t g = 0; g < s.others.size(); g++)
    {
        const Matx44d difference = rigidInverse(mean) * s.others[g].X;
        const Vec3d angle = rotationVector(rotationOf(difference));
        const Point3d d = transform(s.others[g].X, mountPlace) - transform(mean, mountPlace);
        translation += d.dot(d);
        rotation += angle.dot(angle);
    }
    const double factor = (s.others.size() - 1.) / s.others.size();
    fit.spreadTranslation = std::sqrt(factor * translation);
    fit.spreadRotation = std::sqrt(factor * rotation);
}

HandEyeFit describe(const HandEyeProblem& problem, const Indices& poses, int method, const Solutions& s)
{
    HandEyeFit fit;
    fit.method = method;
    fit.valid = s.valid;
    if (!s.valid) return fit;
    fit.camera_T_mount = s.all.X;
    fit.holder_T_board = s.all.Y;
    const std::vector<Indices> groups = groupsOf(poses);
    Sums in, out;
    for (size_t g = 0; g < groups.size(); g++)
        for (size_t i = 0; i < groups[g].size(); i++)
        {
            in.add(problem.error(s.all, groups[g][i]));
            out.add(problem.error(s.others[g], groups[g][i]));
        }
    fit.translation = in.mean(in.translation);
    fit.rotation = in.mean(in.rotation);
    fit.pixels = in.mean(in.pixels);
    fit.leftOutTranslation = out.mean(out.translation);
    fit.leftOutRotation = out.mean(out.rotation);
    fit.leftOutPixels = out.mean(out.pixels);
    measureSpread(problem, poses, s, fit);
    return fit;
}

} // namespace

HandEyeParams::HandEyeParams() : setup(HAND_EYE_BOARD_ON_TOOL), method(HAND_EYE_BEST), rejection(3), seed(1) {}

HandEyeFit::HandEyeFit()
    : method(HAND_EYE_BEST), valid(false), camera_T_mount(Matx44d::eye()), holder_T_board(Matx44d::eye()), translation(0), rotation(0), pixels(0),
      leftOutTranslation(0), leftOutRotation(0), leftOutPixels(0), spreadTranslation(0), spreadRotation(0)
{
}

HandEyeResult::HandEyeResult() : largestRotation(0), crossRotation(0) {}

String handEyeMethodName(int method)
{
    CV_CheckGE(method, (int)HAND_EYE_BEST, "method");
    CV_CheckLE(method, (int)HAND_EYE_REFINED, "method");
    return names[method + 1];
}

bool estimateHandEye(InputArray robotPoses, InputArray boardPoses, HandEyeResult& result, const HandEyeParams& params, const CameraModel& camera,
                     InputArray boardPoints)
{
    CV_Assert((params.setup == HAND_EYE_BOARD_ON_TOOL || params.setup == HAND_EYE_CAMERA_ON_ARM) && "params.setup is none of HandEyeSetup");
    CV_Assert(params.method >= HAND_EYE_BEST && params.method <= HAND_EYE_REFINED && "params.method is none of HandEyeMethod");
    CV_Assert((params.rejection == 0 || (params.rejection >= 1 && params.rejection < DBL_MAX)) && "params.rejection must be 0 or at least 1");
    HandEyeProblem problem = readProblem(robotPoses, boardPoses, params, camera, boardPoints);
    result = HandEyeResult();
    const Indices kept = keptPoses(problem, params.rejection, params.seed);
    for (int i = 0; i < problem.size(); i++)
        if (std::find(kept.begin(), kept.end(), i) == kept.end()) result.rejected.push_back(i);

    std::vector<Solutions> solutions;
    int best = 0;
    for (int method = 0; method <= HAND_EYE_REFINED; method++)
    {
        solutions.push_back(solveAll(problem, kept, method, solutions.empty() ? Solutions() : solutions[best]));
        result.fits.push_back(describe(problem, kept, method, solutions[method]));
        if (solutions[method].leftOut < solutions[best].leftOut) best = method;
    }
    const int chosen = params.method == HAND_EYE_BEST ? best : params.method;
    result.best = result.fits[chosen];
    result.residuals = Mat::zeros(problem.size(), 3, CV_64F);
    for (int i = 0; i < problem.size() && result.best.valid; i++)
    {
        const HandEyeError e = problem.error(solutions[chosen].all, i);
        const double row[] = { e.translation, e.rotation, e.pixels };
        std::copy(row, row + 3, result.residuals.ptr<double>(i));
    }
    judgeHandEye(problem, kept, result);
    return result.reason.empty();
}

}} // namespace cv::surgtrack
