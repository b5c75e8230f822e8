// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "base/geometry.hpp"
#include "lab/synthetic/synthetic_arm.hpp"

namespace cv { namespace surgtrack {

namespace {

const int COORDINATES = SyntheticArm::COORDINATES;
const char* const COORDINATE_NAMES[COORDINATES] = { "q1", "q2", "q3", "q4", "q5", "q6", "jaw" };

// Amplitude of the motion, and standard deviations of the errors of the readings [rad, m].
const double AMPLITUDE[COORDINATES] = { 0.05, 0.05, 0.008, 0.9, 0.55, 0.55, 0.4 };
const double BIAS[COORDINATES]      = { 0.006, 0.006, 0.0006, 0.02, 0.02, 0.02, 0.03 };
const double DRIFT[COORDINATES]     = { 0.001, 0.001, 0.0001, 0.004, 0.004, 0.004, 0.006 };
const double WHITE[COORDINATES]     = { 0.0002, 0.0002, 0.00002, 0.0006, 0.0006, 0.0006, 0.001 };
const double MIN_JAW = 0.03;
const double RECORD_RATE = 100;          // [Hz]

Vec3d randomDirection(RNG& rng)
{
    Vec3d v;
    do
        v = Vec3d(rng.gaussian(1), rng.gaussian(1), rng.gaussian(1));
    while (norm(v) < 1e-3);
    return normalize(v);
}

} // namespace

RNG makeRng(int seed, Stream stream, uint64 index)
{
    uint64 x = (uint64)(unsigned)seed * 0x9E3779B97F4A7C15ULL + (uint64)stream * 0xD1B54A32D192ED03ULL + index * 0x8CB92BA72F3D8DD7ULL;
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ULL;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBULL;
    return RNG(x ^ (x >> 31));
}

SyntheticArm::SyntheticArm(const Ptr<ToolModel>& model, const SyntheticScene::Params& params, int tool)
    : model_(model), params_(params), tool_(tool)
{
    for (int i = 0; i < COORDINATES; i++)
    {
        coordinates[i] = model_->coordinateIndex(COORDINATE_NAMES[i]);
        if (coordinates[i] < 0 || model_->coordinateNames().size() != (size_t)COORDINATES)
            CV_Error(Error::StsBadArg, format("tool '%s': expected the coordinates q1, q2, q3, q4, q5, q6 and jaw", model_->name().c_str()));
    }
    place();
    makeMotion();
}

void SyntheticArm::place()
{
    RNG rng = makeRng(params_.seed, STREAM_HAND_EYE, tool_);
    const double side = tool_ % 2 == 0 ? 1 : -1, height = tool_ < 2 ? -1 : 1;
    // The arms enter beside the endoscope, from the upper right and left, then the lower, and point at their part of the view.
    const Vec3d jitter(rng.uniform(-0.003, 0.003), rng.uniform(-0.003, 0.003), rng.uniform(-0.003, 0.003));
    const Vec3d base = Vec3d(side * 0.079, height * (params_.tools <= 2 ? 0.067 : 0.040), 0.011) + jitter;
    const Vec3d workspace = params_.tools == 1 ? Vec3d(0.002, 0.003, 0.097) :
                            params_.tools == 2 ? Vec3d(side * 0.014, 0.003 + side * 0.003, 0.099) : Vec3d(side * 0.017, height * 0.013, 0.099);
    const Vec3d z = normalize(base - workspace), x = normalize(Vec3d(-side * z[2], 0, side * z[0])), y = z.cross(x);
    const Matx33d R(x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]);
    camera_T_base = rigidTransform(R, base);
    motion_[2].centre = insertionFor(norm(base - workspace));

    // The calibration is wrong by a rotation about the workspace and a shift, so that the tool is off by the shift there.
    const Matx33d error = rotationAbout(randomDirection(rng), params_.handEyeRotation);
    const Vec3d shift = params_.handEyeTranslation * randomDirection(rng);
    nominal_T_base = rigidTransform(error, workspace - error * workspace + shift) * camera_T_base;

    RNG reading = makeRng(params_.seed, STREAM_READING, tool_);
    for (int i = 0; i < COORDINATES; i++)
    {
        bias_[i] = params_.jointNoise * reading.gaussian(BIAS[i]);
        drift_[i] = params_.jointNoise * DRIFT[i];
        driftPhase_[i] = reading.uniform(0., 2 * CV_PI);
    }
}

// The insertion q3 that puts the end effector of the straight tool this far from the base.
double SyntheticArm::insertionFor(double reach) const
{
    std::vector<double> joints(COORDINATES, 0.);
    const double z0 = model_->endEffectorPose(joints)(2, 3);
    joints[coordinates[2]] = 0.1;
    const double z1 = model_->endEffectorPose(joints)(2, 3);
    if (std::abs(z0 - z1 - 0.1) > 1e-6)
        CV_Error(Error::StsBadArg, format("tool '%s': expected q3 to move the tool along -z of the base", model_->name().c_str()));
    return reach + z0;
}

void SyntheticArm::makeMotion()
{
    RNG rng = makeRng(params_.seed, STREAM_MOTION, tool_);
    const double duration = params_.frames / params_.fps;
    const double shortness = std::min(1., duration / 4);   // whole periods in a short sequence would be fast
    for (int i = 0; i < COORDINATES; i++)
    {
        Motion& m = motion_[i];
        if (i != 2)
            m.centre = i == 3 ? rng.uniform(-0.5, 0.5) : i == 6 ? 0.45 : 0;
        m.amplitude = AMPLITUDE[i] * shortness * (i >= 2 || params_.tools == 1 ? 1 : params_.tools == 2 ? 0.7 : 0.5);
        m.cycles[0] = std::max(1, cvRound(duration * rng.uniform(0.15, 0.3)));
        m.cycles[1] = m.cycles[0] + std::max(1, cvRound(duration * rng.uniform(0.1, 0.3)));
        m.phases[0] = rng.uniform(0., 1.);
        m.phases[1] = rng.uniform(0., 1.);
    }
}

std::vector<double> SyntheticArm::trueJoints(double time) const
{
    const double phase = time * params_.fps / params_.frames;
    std::vector<double> joints(COORDINATES);
    for (int i = 0; i < COORDINATES; i++)
        joints[coordinates[i]] = i == 6 ? std::max(motion_[i].at(phase), MIN_JAW) : motion_[i].at(phase);
    return joints;
}

std::vector<double> SyntheticArm::recordedJoints(double time) const
{
    std::vector<double> joints = trueJoints(time);
    // White noise belongs to the records; between two of them it is interpolated as the records are.
    const double record = time * RECORD_RATE;
    const int64 before = (int64)std::floor(record);
    const double weight = record - (double)before;
    for (int j = 0; j < 2; j++)
    {
        RNG rng = makeRng(params_.seed, STREAM_WHITE, 2 * (uint64)(before + j) + tool_ % 2 + ((uint64)(tool_ / 2) << 48));
        for (int i = 0; i < COORDINATES; i++)
            joints[coordinates[i]] += (j ? weight : 1 - weight) * params_.jointNoise * rng.gaussian(WHITE[i]);
    }
    for (int i = 0; i < COORDINATES; i++)
        joints[coordinates[i]] += bias_[i] + drift_[i] * std::sin(2 * CV_PI * time / 30 + driftPhase_[i]);
    return joints;
}

}} // namespace cv::surgtrack
