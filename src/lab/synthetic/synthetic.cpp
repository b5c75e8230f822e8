// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "base/geometry.hpp"
#include "lab/synthetic/synthetic_arm.hpp"
#include "lab/synthetic/synthetic_image.hpp"
#include "lab/synthetic/synthetic_write.hpp"
#include "lab/tool/tool_motion.hpp"
#include "render/tool_instances.hpp"

namespace cv { namespace surgtrack {

namespace {

const double BASELINE = 0.0052;          // [m]
const double TISSUE_DEPTH = 0.125;       // [m]; decides what the right eye sees of the background

class SyntheticSceneImpl CV_FINAL : public SyntheticScene
{
public:
    SyntheticSceneImpl(const Ptr<ToolModel>& model, const Params& params);

    int toolCount() const CV_OVERRIDE { return (int)arms_.size(); }
    int frameCount() const CV_OVERRIDE { return params_.frames; }
    Ptr<ToolModel> model() const CV_OVERRIDE { return model_; }
    CameraModel camera(bool right) const CV_OVERRIDE;
    Matx44d right_T_left() const CV_OVERRIDE { return rigidTransform(Matx33d::eye(), Vec3d(params_.stereo ? -BASELINE : 0, 0, 0)); }
    Matx44d nominal_T_base(int tool) const CV_OVERRIDE { return arm(tool).nominal_T_base; }
    Matx44d camera_T_base(int tool) const CV_OVERRIDE { return arm(tool).camera_T_base; }
    std::vector<double> trueJoints(int tool, double time) const CV_OVERRIDE { return arm(tool).trueJoints(time); }
    std::vector<double> recordedJoints(int tool, double time) const CV_OVERRIDE { return arm(tool).recordedJoints(time); }
    Matx44d truePose(int tool, double time) const CV_OVERRIDE
    {
        return arm(tool).camera_T_base * model_->endEffectorPose(trueJoints(tool, time));
    }
    void render(int frame, OutputArray image, bool right) CV_OVERRIDE;
    void renderArms(int frame, const std::vector<std::vector<double> >& joints, const std::vector<Matx44d>& camera_T_base, OutputArray image,
                    bool right) CV_OVERRIDE;
    void write(const String& folder) CV_OVERRIDE { writeScene(*this, params_, folder); }

private:
    const SyntheticArm& arm(int tool) const;
    void prepareDrawing();
    void prepareMaterials(size_t arms);

    Ptr<ToolModel> model_;
    Params params_;
    CameraModel camera_, doubledCamera_;
    std::vector<SyntheticArm> arms_;

    Ptr<MeshRenderer> renderer_;
    int firstMesh_;
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

SyntheticSceneImpl::SyntheticSceneImpl(const Ptr<ToolModel>& model, const Params& params) : model_(model), params_(params), firstMesh_(-1), disparity_(0)
{
    camera_ = makeCamera(params, 1);
    doubledCamera_ = makeCamera(params, 2);
    for (int i = 0; i < params.tools; i++)
        arms_.push_back(SyntheticArm(model_, params, i));
}

const SyntheticArm& SyntheticSceneImpl::arm(int tool) const
{
    CV_CheckGE(tool, 0, "tool index");
    CV_CheckLT(tool, toolCount(), "tool index");
    return arms_[tool];
}

CameraModel SyntheticSceneImpl::camera(bool right) const
{
    CV_Assert((!right || params_.stereo) && "the scene has no right camera");
    return camera_;
}

void SyntheticSceneImpl::prepareDrawing()
{
    renderer_ = MeshRenderer::createSoftware();
    firstMesh_ = renderer_->addTool(model_);
    RNG rng = makeRng(params_.seed, STREAM_TISSUE, 0);
    disparity_ = cvRound(camera_.fx * BASELINE / TISSUE_DEPTH);
    tissue_ = makeTissue(Size(params_.imageSize.width + disparity_, params_.imageSize.height), rng);
    vignette_ = makeVignette(params_.imageSize);
    const float down = (float)rng.uniform(-0.9, -0.4), aside = (float)rng.uniform(-0.9, 0.9);
    sideLight_ = normalize(Vec3f(aside, down, -0.6f));
}

void SyntheticSceneImpl::prepareMaterials(size_t arms)
{
    const std::vector<ToolMaterial> own = toolMaterials(ToolMotion(*model_).wristDepth(*model_));
    CV_CheckLE(own.size() * arms, (size_t)255, "links of all arms");
    while (materials_.size() < own.size() * arms)
        materials_.insert(materials_.end(), own.begin(), own.end());
}

void SyntheticSceneImpl::render(int frame, OutputArray image, bool right)
{
    std::vector<std::vector<double> > joints;
    std::vector<Matx44d> bases;
    for (int tool = 0; tool < toolCount(); tool++)
    {
        joints.push_back(trueJoints(tool, frame / params_.fps));
        bases.push_back(arms_[tool].camera_T_base);
    }
    renderArms(frame, joints, bases, image, right);
}

void SyntheticSceneImpl::renderArms(int frame, const std::vector<std::vector<double> >& joints, const std::vector<Matx44d>& bases,
                                    OutputArray image, bool right)
{
    CV_CheckGE(frame, 0, "frame");
    CV_Assert((!right || params_.stereo) && "the scene has no right camera");
    CV_CheckEQ(joints.size(), bases.size(), "joints and camera_T_base: one per arm");
    if (!renderer_)
        prepareDrawing();
    prepareMaterials(joints.size());
    const Matx44d eye_T_left = right ? right_T_left() : Matx44d::eye();
    std::vector<MeshInstance> instances;
    for (size_t tool = 0; tool < joints.size(); tool++)
    {
        std::vector<Matx44d> base_T_link;
        model_->forwardKinematics(joints[tool], base_T_link);
        addInstances(*model_, firstMesh_, eye_T_left * bases[tool], base_T_link, 1 + (int)(tool * model_->links().size()), true, instances);
    }
    renderer_->render(doubledCamera_, Rect(Point(), doubledCamera_.imageSize()), instances, rendering_);

    image.create(params_.imageSize, CV_8UC3);
    Mat result = image.getMat(), light;
    const Mat background = tissue_(Rect(right ? disparity_ : 0, 0, params_.imageSize.width, params_.imageSize.height));
    composeImage(rendering_, doubledCamera_, materials_, sideLight_, background, vignette_, light);
    GaussianBlur(light, light, Size(3, 3), 0.7);
    sqrt(light, light);      // the lens blurs light, the camera's tone curve comes after it
    light.convertTo(result, CV_8U);
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
      jointNoise(1), cables(0), imageNoise(3), distortion(false), stereo(false)
{
}

Ptr<SyntheticScene> SyntheticScene::create(const Ptr<ToolModel>& model, const SyntheticScene::Params& params)
{
    CV_Check(params.tools, params.tools >= 1 && params.tools <= 4, "Params::tools must be 1..4");
    CV_CheckGT(params.frames, 0, "Params::frames");
    CV_CheckGE(params.imageSize.width, 64, "Params::imageSize");
    CV_CheckGE(params.imageSize.height, 64, "Params::imageSize");
    const double values[] = { params.fps, params.handEyeRotation, params.handEyeTranslation, params.jointNoise, params.cables, params.imageNoise };
    const char* const names[] = { "fps", "handEyeRotation", "handEyeTranslation", "jointNoise", "cables", "imageNoise" };
    for (int i = 0; i < 5; i++)
        if (!(values[i] >= 0 && values[i] < 1e6) || (i == 0 && values[i] == 0))
            CV_Error(Error::StsOutOfRange, format("Params::%s is %g, expected a finite number %s", names[i], values[i], i == 0 ? "above 0" : "from 0"));
    return makePtr<SyntheticSceneImpl>(model ? model : ToolModel::needleDriver(), params);
}

}} // namespace cv::surgtrack
