// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/imgproc.hpp"
#include "synthetic_image.hpp"
#include "synthetic_write.hpp"

namespace cv { namespace surgtrack {

namespace {

const int COORDINATES = 7;
const char* const COORDINATE_NAMES[COORDINATES] = { "q1", "q2", "q3", "q4", "q5", "q6", "jaw" };

// Amplitude of the motion, and standard deviations of the errors of the readings [rad, m].
const double AMPLITUDE[COORDINATES] = { 0.05, 0.05, 0.008, 0.9, 0.55, 0.55, 0.4 };
const double BIAS[COORDINATES]      = { 0.006, 0.006, 0.0006, 0.02, 0.02, 0.02, 0.03 };
const double DRIFT[COORDINATES]     = { 0.001, 0.001, 0.0001, 0.004, 0.004, 0.004, 0.006 };
const double WHITE[COORDINATES]     = { 0.0002, 0.0002, 0.00002, 0.0006, 0.0006, 0.0006, 0.001 };
const double MIN_JAW = 0.03;
const double RECORD_RATE = 100;          // [Hz]
const double BASELINE = 0.0052;          // [m]
const double TISSUE_DEPTH = 0.125;       // [m]; decides what the right eye sees of the background

// Independent streams of random numbers from one seed.
enum Stream { STREAM_MOTION = 1, STREAM_HAND_EYE, STREAM_READING, STREAM_WHITE, STREAM_TISSUE, STREAM_SENSOR };

RNG makeRng(int seed, Stream stream, uint64 index)
{
    uint64 x = (uint64)(unsigned)seed * 0x9E3779B97F4A7C15ULL + (uint64)stream * 0xD1B54A32D192ED03ULL + index * 0x8CB92BA72F3D8DD7ULL;
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9ULL;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBULL;
    return RNG(x ^ (x >> 31));
}

Vec3d randomDirection(RNG& rng)
{
    Vec3d v;
    do
        v = Vec3d(rng.gaussian(1), rng.gaussian(1), rng.gaussian(1));
    while (norm(v) < 1e-3);
    return normalize(v);
}

Matx33d rotationAbout(const Vec3d& axis, double angle)
{
    const Matx33d K(0, -axis[2], axis[1], axis[2], 0, -axis[0], -axis[1], axis[0], 0);
    return Matx33d::eye() + std::sin(angle) * K + (1 - std::cos(angle)) * (K * K);
}

Matx44d rigid(const Matx33d& R, const Vec3d& t)
{
    return Matx44d(R(0, 0), R(0, 1), R(0, 2), t[0], R(1, 0), R(1, 1), R(1, 2), t[1], R(2, 0), R(2, 1), R(2, 2), t[2], 0, 0, 0, 1);
}

// A pendulum of two sines; whole periods in the length of the sequence.
struct Motion
{
    double centre, amplitude;
    int cycles[2];
    double phases[2];
    double at(double phase) const    // phase: 0..1 over the sequence
    {
        return centre + amplitude * (0.65 * std::sin(2 * CV_PI * (cycles[0] * phase + phases[0])) +
                                     0.35 * std::sin(2 * CV_PI * (cycles[1] * phase + phases[1])));
    }
};

struct Arm
{
    Matx44d camera_T_base, nominal_T_base;
    Motion motion[COORDINATES];
    double bias[COORDINATES], drift[COORDINATES], driftPhase[COORDINATES];
};

class SyntheticSceneImpl CV_FINAL : public SyntheticScene
{
public:
    SyntheticSceneImpl(const Ptr<ToolModel>& model, const Params& params);

    int toolCount() const CV_OVERRIDE { return (int)arms_.size(); }
    int frameCount() const CV_OVERRIDE { return params_.frames; }
    Ptr<ToolModel> model() const CV_OVERRIDE { return model_; }
    CameraModel camera(bool right) const CV_OVERRIDE;
    Matx44d right_T_left() const CV_OVERRIDE { return rigid(Matx33d::eye(), Vec3d(params_.stereo ? -BASELINE : 0, 0, 0)); }
    Matx44d nominal_T_base(int tool) const CV_OVERRIDE { return arm(tool).nominal_T_base; }
    Matx44d camera_T_base(int tool) const CV_OVERRIDE { return arm(tool).camera_T_base; }
    std::vector<double> trueJoints(int tool, double time) const CV_OVERRIDE;
    std::vector<double> recordedJoints(int tool, double time) const CV_OVERRIDE;
    Matx44d truePose(int tool, double time) const CV_OVERRIDE;
    void render(int frame, OutputArray image, bool right) CV_OVERRIDE;
    void write(const String& folder) CV_OVERRIDE { writeScene(*this, params_, folder); }

private:
    const Arm& arm(int tool) const;
    void placeArm(int tool);
    void moveArm(int tool);
    double insertionFor(double reach) const;
    void prepareDrawing();

    Ptr<ToolModel> model_;
    Params params_;
    CameraModel camera_, doubledCamera_;
    std::vector<int> coordinates_;    // of the model, in the order of COORDINATE_NAMES
    std::vector<Arm> arms_;

    Ptr<MeshRenderer> renderer_;
    std::vector<int> meshes_;
    std::vector<ToolMaterial> materials_;
    Rendering rendering_;
    Mat tissue_, vignette_;
    int disparity_;    // of the tissue [pixel]
    Vec3f sideLight_;
};

CameraModel makeCamera(const SyntheticScene::Params& params, int scale)
{
    // The endoscope of a da Vinci at 720 x 576; other sizes keep its horizontal field of view.
    const double s = params.imageSize.width / 720.;
    const Matx33d K(818 * s * scale, 0, scale * (362.4 * s + 0.5) - 0.5, 0, 822.5 * s * scale,
                    scale * (284.1 * params.imageSize.height / 576. + 0.5) - 0.5, 0, 0, 1);
    const Matx<double, 1, 5> distortion(-0.2, 0.06, 0.0006, -0.0004, 0);
    return CameraModel(K, params.distortion ? Mat(distortion) : Mat(), Size(params.imageSize.width * scale, params.imageSize.height * scale));
}

SyntheticSceneImpl::SyntheticSceneImpl(const Ptr<ToolModel>& model, const Params& params) : model_(model), params_(params), disparity_(0)
{
    camera_ = makeCamera(params, 1);
    doubledCamera_ = makeCamera(params, 2);
    const std::vector<String> names = model_->coordinateNames();
    for (int i = 0; i < COORDINATES; i++)
    {
        coordinates_.push_back(model_->coordinateIndex(COORDINATE_NAMES[i]));
        if (coordinates_.back() < 0 || names.size() != (size_t)COORDINATES)
            CV_Error(Error::StsBadArg, format("tool '%s': expected the coordinates q1, q2, q3, q4, q5, q6 and jaw", model_->name().c_str()));
    }
    arms_.resize(params.tools);
    for (int i = 0; i < params.tools; i++)
    {
        placeArm(i);
        moveArm(i);
    }
}

const Arm& SyntheticSceneImpl::arm(int tool) const
{
    CV_CheckGE(tool, 0, "tool index");
    CV_CheckLT(tool, toolCount(), "tool index");
    return arms_[tool];
}

void SyntheticSceneImpl::placeArm(int tool)
{
    RNG rng = makeRng(params_.seed, STREAM_HAND_EYE, tool);
    const double side = tool == 0 ? 1 : -1;
    // The arms enter beside the endoscope, one from the right, one from the left, and point at their part of the view.
    const Vec3d jitter(rng.uniform(-0.003, 0.003), rng.uniform(-0.003, 0.003), rng.uniform(-0.003, 0.003));
    const Vec3d base = Vec3d(side * 0.079, -0.067, 0.011) + jitter;
    const Vec3d workspace = params_.tools == 1 ? Vec3d(0.002, 0.003, 0.097) : Vec3d(side * 0.014, 0.003 + side * 0.003, 0.099);
    const Vec3d z = normalize(base - workspace), x = normalize(Vec3d(-side * z[2], 0, side * z[0])), y = z.cross(x);
    const Matx33d R(x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]);
    Arm& a = arms_[tool];
    a.camera_T_base = rigid(R, base);
    a.motion[2].centre = insertionFor(norm(base - workspace));

    // The calibration is wrong by a rotation about the workspace and a shift, so that the tool is off by the shift there.
    const Matx33d error = rotationAbout(randomDirection(rng), params_.handEyeRotation);
    const Vec3d shift = params_.handEyeTranslation * randomDirection(rng);
    a.nominal_T_base = rigid(error, workspace - error * workspace + shift) * a.camera_T_base;

    RNG reading = makeRng(params_.seed, STREAM_READING, tool);
    for (int i = 0; i < COORDINATES; i++)
    {
        a.bias[i] = params_.jointNoise * reading.gaussian(BIAS[i]);
        a.drift[i] = params_.jointNoise * DRIFT[i];
        a.driftPhase[i] = reading.uniform(0., 2 * CV_PI);
    }
}

// The insertion q3 that puts the end effector of the straight tool this far from the base.
double SyntheticSceneImpl::insertionFor(double reach) const
{
    std::vector<double> joints(COORDINATES, 0.);
    const double z0 = model_->endEffectorPose(joints)(2, 3);
    joints[coordinates_[2]] = 0.1;
    const double z1 = model_->endEffectorPose(joints)(2, 3);
    if (std::abs(z0 - z1 - 0.1) > 1e-6)
        CV_Error(Error::StsBadArg, format("tool '%s': expected q3 to move the tool along -z of the base", model_->name().c_str()));
    return reach + z0;
}

void SyntheticSceneImpl::moveArm(int tool)
{
    RNG rng = makeRng(params_.seed, STREAM_MOTION, tool);
    const double duration = params_.frames / params_.fps;
    const double shortness = std::min(1., duration / 4);   // whole periods in a short sequence would be fast
    for (int i = 0; i < COORDINATES; i++)
    {
        Motion& m = arms_[tool].motion[i];
        if (i != 2)
            m.centre = i == 3 ? rng.uniform(-0.5, 0.5) : i == 6 ? 0.45 : 0;
        m.amplitude = AMPLITUDE[i] * shortness * (params_.tools == 2 && i < 2 ? 0.7 : 1);
        m.cycles[0] = std::max(1, cvRound(duration * rng.uniform(0.15, 0.3)));
        m.cycles[1] = m.cycles[0] + std::max(1, cvRound(duration * rng.uniform(0.1, 0.3)));
        m.phases[0] = rng.uniform(0., 1.);
        m.phases[1] = rng.uniform(0., 1.);
    }
}

CameraModel SyntheticSceneImpl::camera(bool right) const
{
    CV_Assert((!right || params_.stereo) && "the scene has no right camera");
    return camera_;
}

std::vector<double> SyntheticSceneImpl::trueJoints(int tool, double time) const
{
    const Arm& a = arm(tool);
    const double phase = time * params_.fps / params_.frames;
    std::vector<double> joints(COORDINATES);
    for (int i = 0; i < COORDINATES; i++)
        joints[coordinates_[i]] = i == 6 ? std::max(a.motion[i].at(phase), MIN_JAW) : a.motion[i].at(phase);
    return joints;
}

std::vector<double> SyntheticSceneImpl::recordedJoints(int tool, double time) const
{
    std::vector<double> joints = trueJoints(tool, time);
    const Arm& a = arm(tool);
    // White noise belongs to the records; between two of them it is interpolated as the records are.
    const double record = time * RECORD_RATE;
    const int64 before = (int64)std::floor(record);
    const double weight = record - (double)before;
    for (int j = 0; j < 2; j++)
    {
        RNG rng = makeRng(params_.seed, STREAM_WHITE, 2 * (uint64)(before + j) + tool);
        for (int i = 0; i < COORDINATES; i++)
            joints[coordinates_[i]] += (j ? weight : 1 - weight) * params_.jointNoise * rng.gaussian(WHITE[i]);
    }
    for (int i = 0; i < COORDINATES; i++)
        joints[coordinates_[i]] += a.bias[i] + a.drift[i] * std::sin(2 * CV_PI * time / 30 + a.driftPhase[i]);
    return joints;
}

Matx44d SyntheticSceneImpl::truePose(int tool, double time) const
{
    return arm(tool).camera_T_base * model_->endEffectorPose(trueJoints(tool, time));
}

void SyntheticSceneImpl::prepareDrawing()
{
    renderer_ = MeshRenderer::createSoftware();
    for (size_t i = 0; i < model_->meshes().size(); i++)
        meshes_.push_back(renderer_->addMesh(model_->meshes()[i]));
    // Plastic up to the shaft, then steel; the last links, the jaws, are brighter.
    const std::vector<ToolModel::Link>& links = model_->links();
    CV_Assert(links.size() * arms_.size() <= 255);
    const ToolMaterial plastic = { Vec3f(0.19f, 0.18f, 0.18f), 0.22f, 16 };
    const ToolMaterial steel = { Vec3f(0.62f, 0.61f, 0.60f), 0.45f, 32 };
    const ToolMaterial jaw = { Vec3f(0.74f, 0.75f, 0.76f), 0.50f, 16 };
    for (size_t tool = 0; tool < arms_.size(); tool++)
        for (size_t i = 0; i < links.size(); i++)
        {
            int depth = 0;    // wrist joints above the link
            for (int l = (int)i; l >= 0; l = links[l].parent)
                depth += links[l].coordinate == coordinates_[4] || links[l].coordinate == coordinates_[5];
            materials_.push_back(depth == 0 ? plastic : depth == 1 ? steel : jaw);
        }
    RNG rng = makeRng(params_.seed, STREAM_TISSUE, 0);
    disparity_ = cvRound(camera_.fx * BASELINE / TISSUE_DEPTH);
    tissue_ = makeTissue(Size(params_.imageSize.width + disparity_, params_.imageSize.height), rng);
    vignette_ = makeVignette(params_.imageSize);
    sideLight_ = normalize(Vec3f((float)rng.uniform(-0.9, 0.9), (float)rng.uniform(-0.9, -0.4), -0.6f));
}

void SyntheticSceneImpl::render(int frame, OutputArray image, bool right)
{
    CV_CheckGE(frame, 0, "frame");
    CV_Assert((!right || params_.stereo) && "the scene has no right camera");
    if (!renderer_)
        prepareDrawing();
    const Matx44d eye_T_left = right ? right_T_left() : Matx44d::eye();
    const std::vector<ToolModel::Link>& links = model_->links();
    std::vector<MeshInstance> instances;
    for (int tool = 0; tool < toolCount(); tool++)
    {
        std::vector<Matx44d> base_T_link;
        model_->forwardKinematics(trueJoints(tool, frame / params_.fps), base_T_link);
        for (size_t i = 0; i < links.size(); i++)
        {
            if (links[i].mesh < 0)
                continue;
            MeshInstance instance;
            instance.mesh = meshes_[links[i].mesh];
            instance.id = 1 + (int)(tool * links.size() + i);
            instance.camera_T_mesh = eye_T_left * arms_[tool].camera_T_base * base_T_link[i];
            instances.push_back(instance);
        }
    }
    renderer_->render(doubledCamera_, Rect(Point(), doubledCamera_.imageSize()), instances, rendering_);

    image.create(params_.imageSize, CV_8UC3);
    Mat result = image.getMat(), composed;
    const Mat background = tissue_(Rect(right ? disparity_ : 0, 0, params_.imageSize.width, params_.imageSize.height));
    composeImage(rendering_, doubledCamera_, materials_, sideLight_, background, vignette_, composed);
    GaussianBlur(composed, result, Size(3, 3), 0.7);
    if (params_.imageNoise > 0)
    {
        Mat noise(params_.imageSize, CV_16SC3);
        RNG rng = makeRng(params_.seed, STREAM_SENSOR, 2 * (uint64)frame + right);
        rng.fill(noise, RNG::NORMAL, 0, params_.imageNoise);
        add(result, noise, result, noArray(), CV_8U);
    }
}

} // namespace

SyntheticScene::Params::Params()
    : tools(1), frames(100), seed(1), imageSize(720, 576), fps(25), handEyeRotation(3 * CV_PI / 180), handEyeTranslation(0.006),
      jointNoise(1), imageNoise(3), distortion(false), stereo(false)
{
}

Ptr<SyntheticScene> SyntheticScene::create(const Ptr<ToolModel>& model, const SyntheticScene::Params& params)
{
    CV_Assert((params.tools == 1 || params.tools == 2) && "Params::tools must be 1 or 2");
    CV_CheckGT(params.frames, 0, "Params::frames");
    CV_CheckGE(params.imageSize.width, 64, "Params::imageSize");
    CV_CheckGE(params.imageSize.height, 64, "Params::imageSize");
    const double values[] = { params.fps, params.handEyeRotation, params.handEyeTranslation, params.jointNoise, params.imageNoise };
    const char* const names[] = { "fps", "handEyeRotation", "handEyeTranslation", "jointNoise", "imageNoise" };
    for (int i = 0; i < 5; i++)
        if (!(values[i] >= 0 && values[i] < 1e6) || (i == 0 && values[i] == 0))
            CV_Error(Error::StsOutOfRange, format("Params::%s is %g, expected a finite number %s", names[i], values[i], i == 0 ? "above 0" : "from 0"));
    return makePtr<SyntheticSceneImpl>(model ? model : ToolModel::needleDriver(), params);
}

}} // namespace cv::surgtrack
