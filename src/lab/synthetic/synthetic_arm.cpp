// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "base/geometry.hpp"
#include "lab/synthetic/synthetic_arm.hpp"
#include "lab/tool/tool_motion.hpp"

namespace cv { namespace surgtrack {

namespace {

const int COORDINATES = SyntheticArm::COORDINATES;

// Of two joints that turn, the insertion, the roll, two of the wrist, and the jaw: amplitude of the motion, and standard deviations of the errors of the readings [rad, m].
const double AMPLITUDE[COORDINATES] = { 0.05, 0.05, 0.008, 0.9, 0.55, 0.55, 0.4 };
const double BIAS[COORDINATES]      = { 0.006, 0.006, 0.0006, 0.02, 0.02, 0.02, 0.03 };
const double DRIFT[COORDINATES]     = { 0.001, 0.001, 0.0001, 0.004, 0.004, 0.004, 0.006 };
/* Of a real PSM under an optical tracker (507 poses of a Large Needle Driver, KinematicCalibDVRK's data): of 0.070 rad of wrist error constant
   offsets explain 0.010, play of +-0.02 rad another 0.013, gains of 0.02 and a coupling of pitch into yaw another 0.014. */
const double PLAY[COORDINATES]      = { 0, 0, 0, 0.012, 0.02, 0.02, 0.03 };    // half of it: cables of the jaws are the longest, of the roll the shortest
const double GAIN[COORDINATES]      = { 0, 0, 0, 0.02, 0.02, 0.02, 0.02 };
const double COUPLING = 0.09;
const double WHITE[COORDINATES]     = { 0.0002, 0.0002, 0.00002, 0.0006, 0.0006, 0.0006, 0.001 };
const double MIN_JAW = 0.03;
const double RECORD_RATE = 100;          // [Hz]

Vec3d randomDirection(RNG& rng)
{
    Vec3d v;
    do
        for (int i = 2; i >= 0; i--) v[i] = rng.gaussian(1);   // not as arguments of a call: compilers differ in their order
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
    const ToolMotion motion(*model);
    count_ = (int)motion.path.size();
    for (int i = 0; i < count_ && i < 6; i++)
        coordinates[i] = motion.path[i];
    bool jaws = motion.role.size() == 7;
    for (size_t c = 0; c < motion.role.size() && jaws && count_ == 6; c++)
        if (motion.role[c] == ToolMotion::JAW)
            coordinates[count_++] = (int)c;
    if (count_ != (int)motion.role.size() || count_ < 6 || motion.slide != motion.path[2])
        CV_Error(Error::StsBadArg, format("tool '%s': expected an arm of two joints that turn, one that slides and one that rolls, two joints of a wrist, and "
                                          "perhaps one of jaws", model_->name().c_str()));
    limits_ = model_->jointLimits();
    place(motion.shaft);
    makeMotion();
    makePlay();
}

void SyntheticArm::place(const Vec3d& shaft)
{
    RNG rng = makeRng(params_.seed, STREAM_HAND_EYE, tool_);
    const double side = tool_ % 2 == 0 ? 1 : -1, height = tool_ < 2 ? -1 : 1;
    // The arms enter beside the endoscope, from the upper right and left, then the lower, and point at their part of the view.
    Vec3d jitter;
    for (int i = 2; i >= 0; i--) jitter[i] = rng.uniform(-0.003, 0.003);
    const Vec3d base = Vec3d(side * 0.079, height * (params_.tools <= 2 ? 0.067 : 0.040), 0.011) + jitter;
    const Vec3d workspace = params_.tools == 1 ? Vec3d(0.002, 0.003, 0.097) :
                            params_.tools == 2 ? Vec3d(side * 0.014, 0.003 + side * 0.003, 0.099) : Vec3d(side * 0.017, height * 0.013, 0.099);
    const Vec3d z = normalize(base - workspace), x = normalize(Vec3d(-side * z[2], 0, side * z[0])), y = z.cross(x);
    const Matx33d R(x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]);
    // The straight tool points along -z there; the base of most arms has its own like that.
    const Vec3d turn = shaft.cross(Vec3d(0, 0, -1));
    const Matx33d own = norm(turn) > 1e-9 ? rotationAbout(normalize(turn), std::atan2(norm(turn), -shaft[2]))
                        : shaft[2] > 0 ? Matx33d(1, 0, 0, 0, -1, 0, 0, 0, -1) : Matx33d::eye();
    camera_T_base = rigidTransform(R * own, base);
    motion_[2].centre = insertionFor(norm(base - workspace), shaft);

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
    for (int i = 0; i < COORDINATES; i++)
    {
        gain_[i] = params_.cables * reading.gaussian(GAIN[i]);
        hang_[i] = params_.cables * reading.uniform(-1., 1.) * PLAY[i];
    }
    coupling_ = params_.cables * (reading.uniform(0., 1.) < 0.5 ? -COUPLING : COUPLING);
}

// The insertion that puts the end effector of the straight tool this far from the base.
double SyntheticArm::insertionFor(double reach, const Vec3d& shaft) const
{
    std::vector<double> joints(count_, 0.);
    const Matx44d T0 = model_->endEffectorPose(joints);
    joints[coordinates[2]] = 0.1;
    const Matx44d T1 = model_->endEffectorPose(joints);
    const double s0 = -shaft.dot(Vec3d(T0(0, 3), T0(1, 3), T0(2, 3))), s1 = -shaft.dot(Vec3d(T1(0, 3), T1(1, 3), T1(2, 3)));
    if (std::abs(s0 - s1 - 0.1) > 1e-6)
        CV_Error(Error::StsBadArg, format("tool '%s': expected `%s` to move the tool out along its shaft", model_->name().c_str(),
                                          model_->coordinateNames()[coordinates[2]].c_str()));
    return reach + s0;
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
        if (i < count_ && i >= 4)
            keepInside(m, limits_(coordinates[i], 0), limits_(coordinates[i], 1));
    }
}

// How far each joint lags behind its motor at each record, after all it has travelled until then.
void SyntheticArm::makePlay()
{
    const int records = cvCeil(params_.frames / params_.fps * RECORD_RATE) + 2;
    std::vector<double> before = trueJoints(0);
    hangs_.assign((size_t)records * COORDINATES, 0.);
    for (int k = 0; k < records; k++)
    {
        const std::vector<double> now = trueJoints(k / RECORD_RATE);
        for (int i = 0; i < count_; i++)
        {
            const double play = params_.cables * PLAY[i], travel = now[coordinates[i]] - before[coordinates[i]];
            hang_[i] = std::min(std::max(hang_[i] - travel, -play), play);
            hangs_[(size_t)k * COORDINATES + i] = hang_[i];
        }
        before = now;
    }
}

double SyntheticArm::hangAt(int coordinate, double record) const
{
    const double last = (double)(hangs_.size() / COORDINATES) - 1, at = std::min(std::max(record, 0.), last);
    const size_t k = (size_t)std::min(at, last - 1);
    const double weight = at - (double)k;
    return (1 - weight) * hangs_[k * COORDINATES + coordinate] + weight * hangs_[(k + 1) * COORDINATES + coordinate];
}

//! Motions that would go beyond the joint's limits become as large as those allow.
void SyntheticArm::keepInside(Motion& m, double low, double high)
{
    if (m.centre - m.amplitude >= low && m.centre + m.amplitude <= high)
        return;
    low = std::max(low, m.centre - m.amplitude);
    high = std::min(high, m.centre + m.amplitude);
    m.centre = 0.5 * (low + high);
    m.amplitude = std::max(0., 0.5 * (high - low));
}

std::vector<double> SyntheticArm::trueJoints(double time) const
{
    const double phase = time * params_.fps / params_.frames;
    std::vector<double> joints(count_);
    for (int i = 0; i < count_; i++)
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
        for (int i = 0; i < count_; i++)
            joints[coordinates[i]] += (j ? weight : 1 - weight) * params_.jointNoise * rng.gaussian(WHITE[i]);
    }
    const std::vector<double> truth = trueJoints(time);
    for (int i = 0; i < count_; i++)
        joints[coordinates[i]] += bias_[i] + drift_[i] * std::sin(2 * CV_PI * time / 30 + driftPhase_[i]);
    for (int i = 0; i < count_ && params_.cables > 0; i++)
        joints[coordinates[i]] += gain_[i] * (truth[coordinates[i]] - motion_[i].centre) - hangAt(i, record);
    joints[coordinates[5]] += coupling_ * (truth[coordinates[4]] - motion_[4].centre);
    return joints;
}

}} // namespace cv::surgtrack
