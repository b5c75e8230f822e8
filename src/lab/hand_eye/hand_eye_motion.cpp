// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "base/geometry.hpp"
#include "lab/hand_eye/hand_eye_motion.hpp"

namespace cv { namespace surgtrack {

namespace {

const double degree = CV_PI / 180;
const int enoughPoses = 10;
// Errors of the calibration are those of the poses, divided by about the sine of the angles they turn by: at 30 degrees they double.
const double enoughRotation = 30 * degree, enoughCross = 15 * degree;
const double leastCross = 1 * degree;                           // less is the noise of robot and board
const double uncertainShift = 0.004, uncertainAngle = 2 * degree;   // half of what ToolPoseEKF takes a calibration to be wrong by
const double misfitShift = 0.005, misfitAngle = 5 * degree;     // no robot is that wrong: other set-up, other unit, other pairs
const double manyRejected = 0.3;

//! Largest rotation of any pair, and the largest about an axis perpendicular to the one that pairs turn about most [rad].
void measureMotion(const std::vector<Matx44d>& M, const std::vector<int>& kept, double& largest, double& cross)
{
    std::vector<Vec3d> rotations;
    Matx33d sum = Matx33d::zeros();
    for (size_t i = 0; i < kept.size(); i++)
        for (size_t j = 0; j < i; j++)
        {
            const Matx44d motion = M[kept[j]] * rigidInverse(M[kept[i]]);
            const Vec3d v = rotationVector(rotationOf(motion));
            rotations.push_back(v);
            sum += v * v.t();
        }
    Matx31d values;
    Matx33d vectors;
    eigen(sum, values, vectors);
    const Vec3d axis(vectors(0, 0), vectors(0, 1), vectors(0, 2));
    largest = cross = 0;
    for (size_t i = 0; i < rotations.size(); i++)
    {
        largest = std::max(largest, norm(rotations[i]));
        cross = std::max(cross, norm(rotations[i].cross(axis)));
    }
}

} // namespace

void judgeHandEye(const HandEyeProblem& problem, const std::vector<int>& kept, HandEyeResult& result)
{
    measureMotion(problem.M(), kept, result.largestRotation, result.crossRotation);
    const HandEyeFit& best = result.best;
    const double largest = result.largestRotation / degree, cross = result.crossRotation / degree;
    if (result.crossRotation < leastCross)
        result.reason = format("the robot's poses turn about one axis only (by up to %.1f degrees, by %.1f about any other), expected at least two axes", largest, cross);
    else if (!best.valid)
        result.reason = "no answer from these poses" + (best.method == HAND_EYE_BEST ? String() : " by method " + handEyeMethodName(best.method));
    if (!result.reason.empty()) return;

    std::vector<String>& warnings = result.warnings;
    if ((int)kept.size() < enoughPoses)
        warnings.push_back(format("few poses: %d, expected %d or more", (int)kept.size(), enoughPoses));
    if (result.largestRotation < enoughRotation)
        warnings.push_back(format("small rotations: the robot's poses differ by at most %.1f degrees, expected %.0f or more", largest, enoughRotation / degree));
    if (result.crossRotation < enoughCross)
        warnings.push_back(format("nearly parallel rotation axes: about any but the main one the robot's poses differ by at most %.1f degrees, "
                                  "expected %.0f or more", cross, enoughCross / degree));
    if (result.rejected.size() > manyRejected * problem.size())
        warnings.push_back(format("%d of %d poses were thrown out: do robot and board poses belong together?", (int)result.rejected.size(), problem.size()));
    if (best.leftOutTranslation > misfitShift || best.leftOutRotation > misfitAngle)
        warnings.push_back(format("poses that do not fit: left out, they are off by %.1f mm and %.2f degrees; are set-up, pairs, units and camera right?",
                                  1e3 * best.leftOutTranslation, best.leftOutRotation / degree));
    if (best.spreadTranslation > uncertainShift || best.spreadRotation > uncertainAngle)
        warnings.push_back(format("uncertain: the calibration's standard deviation is %.1f mm and %.2f degrees", 1e3 * best.spreadTranslation,
                                  best.spreadRotation / degree));
}

}} // namespace cv::surgtrack
