// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "base/geometry.hpp"
#include "lab/synthetic/synthetic_arm.hpp"
#include "lab/tool/keypoint_trial.hpp"
#include "render/tool_instances.hpp"

namespace cv { namespace surgtrack {

namespace {

// The endoscope of a da Vinci, cut to what lies about the wrist; templates are seen as in an image 720 pixels wide.
const double FOCAL = 820;
const int SIDE = 480;
const double DISTANCE = 0.1;        // [m], the middle of where instruments work
const double NEAR = 5;              // a match this near is the point [pixel]; what tracking counts as found
const int WINDOW = 32;              // about the prediction [pixel], as the tracker looks

// How wrong the drawing is that templates are cut from: somewhat more than while tracking, less than the first guess of a bad calibration.
const double TURN = 4 * CV_PI / 180, FARTHER = 0.04, BENT = 0.05;

} // namespace

KeypointTrial::KeypointTrial(const Ptr<ToolModel>& model, const ToolMotion& motion)
    : model_(model), motion_(motion), offsets_(offsets(*model, motion)), renderer_(MeshRenderer::createSoftware())
{
    camera_ = CameraModel(Matx33d(FOCAL, 0, SIDE / 2, 0, FOCAL, SIDE / 2, 0, 0, 1), noArray(), Size(SIDE, SIDE));
    const double middle = 2 * (SIDE / 2 + 0.5) - 0.5;
    doubledCamera_ = CameraModel(Matx33d(2 * FOCAL, 0, middle, 0, 2 * FOCAL, middle, 0, 0, 1), noArray(), Size(2 * SIDE, 2 * SIDE));
    firstMesh_ = renderer_->addTool(model);
    PartTemplateRenderer::Params parts;
    parts.wholeTool = true;
    parts_ = PartTemplateRenderer::create(renderer_, parts);
    parts_->addTool(model);
    QGOMatcher::Params match;
    match.candidates = 1;
    matcher_ = QGOMatcher::create(match);
    materials_ = toolMaterials(motion.wristDepth(*model));
    RNG rng(1);
    tissue_ = makeTissue(camera_.imageSize(), rng);
    vignette_ = Mat::ones(camera_.imageSize(), CV_32F);
}

std::vector<int> KeypointTrial::offsets(const ToolModel& model, const ToolMotion& motion)
{
    std::vector<int> found;
    for (size_t c = 0; c < model.coordinateNames().size(); c++)
        if (motion.role[c] == ToolMotion::WRIST || motion.role[c] == ToolMotion::JAW)
            found.push_back((int)c);
    return found;
}

Viewpoint KeypointTrial::viewpoint(int picture)
{
    // From twelve sides, at four angles to the shaft: an instrument comes from beside the camera.
    static const double elevations[] = { 40, 60, 80, 105 };
    const Viewpoint view = { CV_2PI * ((picture % 12) + 0.25 * (picture / 12)) / 12, elevations[picture / 12 % 4] * CV_PI / 180, DISTANCE };
    return view;
}

void KeypointTrial::paint(int picture, const Matx44d& camera_T_base, const std::vector<Matx44d>& base_T_link)
{
    std::vector<MeshInstance> instances;
    addInstances(*model_, firstMesh_, camera_T_base, base_T_link, 1, true, instances);
    renderer_->render(doubledCamera_, Rect(Point(), doubledCamera_.imageSize()), instances, doubled_);
    const double angle = 2.4 * picture;   // the second light comes from everywhere
    const Vec3f side = normalize(Vec3f((float)std::cos(angle), (float)std::sin(angle), -0.7f));
    Mat light;
    composeImage(doubled_, doubledCamera_, materials_, side, tissue_, vignette_, light);
    GaussianBlur(light, light, Size(3, 3), 0.7);
    sqrt(light, light);
    light.convertTo(picture_, CV_8U);
}

void KeypointTrial::addJacobian(const Matx44d& camera_T_base, const std::vector<Matx44d>& base_T_link, int candidate, Sighting& sighting) const
{
    const ToolModel::Keypoint& keypoint = model_->keypoints()[candidate];
    const Point3d basePoint = transform(base_T_link[keypoint.link], keypoint.linkPoint), viewPoint = transform(camera_T_base, basePoint);
    Matx23d image;
    camera_.project(viewPoint, &image);
    const size_t n = 6 + offsets_.size(), coordinates = model_->coordinateNames().size();
    std::vector<double> joints(3 * coordinates);
    model_->pointJacobian(base_T_link, keypoint.link, basePoint, &joints[0]);
    const Vec3d lever = Vec3d(viewPoint) - Vec3d(0, 0, DISTANCE);   // turns are about the centre, see viewpoint()
    const Matx33d R = rotationOf(camera_T_base);
    sighting.jacobian.assign(2 * n, 0.);
    for (size_t s = 0; s < n; s++)
    {
        Vec3d axis, moved;
        if (s < 6)
            axis[s % 3] = 1;
        if (s < 3)
            moved = axis;
        else if (s < 6)
            moved = axis.cross(lever);
        else
            for (int k = 0; k < 3; k++)
                moved[k] = joints[k * coordinates + offsets_[s - 6]];
        if (s >= 6)
            moved = R * moved;
        const Vec2d pixels = image * moved;
        sighting.jacobian[s] = pixels[0];
        sighting.jacobian[n + s] = pixels[1];
    }
}

void KeypointTrial::look(const Matx44d& camera_T_base, const std::vector<Matx44d>& base_T_link, std::vector<Sighting>& sightings)
{
    std::vector<Rect> windows;
    for (size_t i = 0; i < templates_.size(); i++)
        windows.push_back(Rect(templates_[i].anchor - Point(WINDOW, WINDOW), Size(2 * WINDOW + 1, 2 * WINDOW + 1)));
    matcher_->setImage(picture_);
    matcher_->match(templates_, windows, matches_);
    for (size_t i = 0; i < matches_.size(); i++)
    {
        const PartMatch& match = matches_[i];
        Sighting& s = sightings[match.part];
        const ToolModel::Keypoint& keypoint = model_->keypoints()[match.part];
        const Point3d viewPoint = transform(camera_T_base * base_T_link[keypoint.link], keypoint.linkPoint);
        s.error = norm(match.imagePoint - camera_.project(viewPoint));
        s.found = s.error < NEAR;
        if (s.found)
            addJacobian(camera_T_base, base_T_link, match.part, s);
    }
}

void KeypointTrial::run(int picture, std::vector<Sighting>& sightings)
{
    const std::vector<ToolModel::Keypoint>& keypoints = model_->keypoints();
    sightings.assign(keypoints.size(), Sighting());
    std::vector<double> joints = motion_.setting(picture);
    const Matx44d camera_T_base = viewpoint(picture).camera_T_base(motion_);
    std::vector<Matx44d> base_T_link;
    model_->forwardKinematics(joints, base_T_link);
    paint(picture, camera_T_base, base_T_link);
    for (size_t i = 0; i < keypoints.size(); i++)
    {
        const Point3d viewPoint = transform(camera_T_base * base_T_link[keypoints[i].link], keypoints[i].linkPoint);
        const Point2d at = doubledCamera_.project(viewPoint);
        const double slack = 0.0003;   // of candidates on the surface, drawn in pixels of 0.06 mm [m]
        sightings[i].seen = isVisible(doubled_.depth, doubled_.ids, Point(cvRound(at.x), cvRound(at.y)), 1, viewPoint.z,
                                      std::min(1 + keypoints[i].link, 255), slack);
    }

    RNG rng(picture + 1);
    Vec3d turn;
    for (int i = 2; i >= 0; i--) turn[i] = rng.gaussian(1);   // not as arguments of a call: compilers differ in their order
    turn *= TURN / std::max(norm(turn), 1e-3);
    const Point3d centre(0, 0, DISTANCE);
    const Matx33d R = exponential(turn);
    const Vec3d shift = Vec3d(centre) - R * Vec3d(centre) + Vec3d(0, 0, (picture % 2 ? FARTHER : -FARTHER) * DISTANCE);
    for (size_t k = 0; k < offsets_.size(); k++)
        joints[offsets_[k]] += (picture >> k) % 2 ? BENT : -BENT;
    std::vector<ToolView> views(1);
    views[0].camera_T_base = rigidTransform(R, shift) * camera_T_base;
    model_->forwardKinematics(joints, views[0].base_T_link);
    parts_->render(camera_, views, 0, templates_);
    for (size_t i = 0; i < templates_.size(); i++)
        sightings[templates_[i].part].drawn = true;
    look(camera_T_base, base_T_link, sightings);
}

}} // namespace cv::surgtrack
