// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_tracking.hpp"
#include "detect/enlarge.hpp"
#include "detect/template_copies.hpp"

// Tools far away, whose wrist is less than 30 pixels wide in the image: they are matched at twice its size.

namespace opencv_test { namespace {

Matx44d inverseOf(const Matx44d& T)
{
    const Matx33d R = Matx33d(T(0, 0), T(0, 1), T(0, 2), T(1, 0), T(1, 1), T(1, 2), T(2, 0), T(2, 1), T(2, 2)).t();
    const Vec3d t = R * Vec3d(T(0, 3), T(1, 3), T(2, 3));
    return rigid(R, Point3d(-t[0], -t[1], -t[2]));
}

// The scene's tool so much farther that its wrist is 26 pixels wide: 8.4 mm at 0.27 m.
class FarTool
{
public:
    //! @param farther false: it stays where it is
    explicit FarTool(int seed, Size size = Size(720, 576), bool farther = true) : scene_(SyntheticScene::create(needleDriver(), scene(seed, 1, size)))
    {
        const Matx44d pose = scene_->truePose(0, 0);
        const double factor = farther ? scene_->camera().fx * 0.0084 / 26 / pose(2, 3) : 1;
        // Along the ray through the tool, so that it stays in the image.
        away_ = rigid(Matx33d::eye(), Point3d(pose(0, 3), pose(1, 3), pose(2, 3)) * (factor - 1));
    }

    const Ptr<SyntheticScene>& source() const { return scene_; }
    CameraModel camera() const { return scene_->camera(); }
    double time(int frame) const { return frame / 25.; }
    Matx44d truth(double time) const { return away_ * scene_->truePose(0, time); }
    Joints joints(double time) const { return Joints(1, scene_->recordedJoints(0, time)); }
    Mat image(double time) const
    {
        Mat image;
        scene_->renderArms(cvRound(time * 25), Joints(1, scene_->trueJoints(0, time)), std::vector<Matx44d>(1, away_ * scene_->camera_T_base(0)), image);
        return image;
    }
    Ptr<ToolTracker> tracker(int method = METHOD_FULL) const
    {
        ToolTracker::Params p;
        p.method = method;
        Ptr<ToolTracker> result = ToolTracker::create(camera(), p);
        result->addTool(scene_->model(), away_ * scene_->nominal_T_base(0));
        return result;
    }
    // How far the tips are from where they are in the image [pixel].
    double imageDistance(const Matx44d& found, double time) const
    {
        const Matx44d T = truth(time);
        const Point2d d = camera().project(Point3d(found(0, 3), found(1, 3), found(2, 3))) - camera().project(Point3d(T(0, 3), T(1, 3), T(2, 3)));
        return std::sqrt(d.dot(d));
    }

private:
    Ptr<SyntheticScene> scene_;
    Matx44d away_;
};

// In small images, where the wrist is 24 pixels wide, and windows are small too. Matched at their size: 34 of 40, and one wrong.
TEST(SurgTrack_SmallTools, areFound)
{
    int found = 0, wrong = 0, starts = 0;
    for (int seed = 1; seed <= 10; seed++)
    {
        const FarTool far(seed, Size(240, 192), false);
        for (int still = 0; still < 4; still++, starts++)
        {
            const double time = 0.4 * still;
            const Mat image = far.image(time);
            Ptr<ToolTracker> tracker = far.tracker();
            Estimates e;
            for (int k = 0; k < 4; k++) tracker->update(image, 0.04 * k, far.joints(time), e);
            if (e[0].state != STATE_TRACKING) continue;
            const double apart = far.imageDistance(e[0].camera_T_tool, time);
            (apart < 3 ? found : wrong)++;   // a ninth of the wrist's width
            if (apart >= 3 && std::getenv("SURGTRACK_TEST_PRINT")) std::cout << seed << ", " << still << ": " << apart << " pixels off" << std::endl;
        }
    }
    if (std::getenv("SURGTRACK_TEST_PRINT")) std::cout << "small tools: " << found << " of " << starts << " found, " << wrong << " wrong" << std::endl;
    EXPECT_GE(found, 38);
    EXPECT_LE(wrong, 1);   // as without
}

// Matched at their size: 1.30 mm, 0.51 pixels; at twice the size 1.12 mm, 0.22 pixels.
TEST(SurgTrack_SmallTools, areTracked)
{
    double error = 0, beside = 0;
    int tracked = 0, frames = 0;
    for (int seed = 1; seed <= 6; seed++)
    {
        const FarTool far(seed);
        Ptr<ToolTracker> tracker = far.tracker();
        for (int frame = 0; frame < 12; frame++, frames++)
        {
            Estimates e;
            tracker->update(far.image(far.time(frame)), far.time(frame), far.joints(far.time(frame)), e);
            if (e[0].state != STATE_TRACKING) continue;
            tracked++;
            error += distance(e[0].camera_T_tool, far.truth(far.time(frame)));
            beside += far.imageDistance(e[0].camera_T_tool, far.time(frame));
        }
    }
    if (std::getenv("SURGTRACK_TEST_PRINT"))
        std::cout << "small tools: " << error / tracked * 1e3 << " mm, " << beside / tracked << " px, tracked in " << tracked << " of " << frames << std::endl;
    EXPECT_GE(tracked, 70);
    EXPECT_LT(error / tracked, 0.002);   // depth, most of it: a thousandth of it is a fortieth of a pixel of the wrist's width
    EXPECT_LT(beside / tracked, 0.35);
}

// The tool drawn where it is, its wrist so many pixels wide.
int enlargementAt(PartFinder& finder, const FarTool& far, double width, std::vector<PartTemplate>* templates = 0)
{
    ToolView view;
    view.camera_T_base = far.truth(0) * inverseOf(far.source()->model()->endEffectorPose(far.source()->trueJoints(0, 0)));
    far.source()->model()->forwardKinematics(far.source()->trueJoints(0, 0), view.base_T_link);
    const Matx44d pose = far.truth(0);
    const double farther = far.camera().fx * 0.0084 / width / pose(2, 3);
    view.camera_T_base = rigid(Matx33d::eye(), Point3d(pose(0, 3), pose(1, 3), pose(2, 3)) * (farther - 1)) * view.camera_T_base;
    PartDrawing drawing;
    finder.draw(std::vector<ToolView>(1, view), 0, drawing);
    if (templates) *templates = drawing.templates;
    return drawing.enlargement;
}

Ptr<PartFinder> finder(const FarTool& far)
{
    Ptr<PartTemplateRenderer> templates = PartTemplateRenderer::create();
    templates->addTool(far.source()->model());
    return PartFinder::create(far.camera(), templates);
}

TEST(SurgTrack_SmallTools, areThoseThatWereOneUntilTheyAreClearlyLarger)
{
    const FarTool far(1);
    Ptr<PartFinder> eye = finder(far);
    // Widths of what is as far as the end effector; keypoints are some 8 mm nearer, so theirs are a twentieth larger.
    const double widths[] = {60, 34, 30, 26, 30, 40, 30, 20};
    const int expected[] = {1, 1, 1, 2, 2, 1, 1, 2};
    for (int i = 0; i < 8; i++) EXPECT_EQ(expected[i], enlargementAt(*eye, far, widths[i])) << i << ": " << widths[i] << " pixels";
}

TEST(SurgTrack_SmallTools, partsAreFoundWhereTheyAre)
{
    const FarTool far(2);
    for (int variant = 0; variant < 3; variant++)   // as it is, masked elsewhere, and of an image twice as large
    {
        const FarTool seen(2, variant == 2 ? Size(1440, 1152) : Size(720, 576));
        Ptr<PartFinder> eye = finder(seen);
        Mat mask(seen.camera().imageSize(), CV_8U, Scalar(255));
        mask.rowRange(0, 8).setTo(0);
        if (variant == 1) eye->setMask(mask);
        const Mat image = seen.image(0);
        eye->setImage(image);
        ToolView view;
        view.camera_T_base = seen.truth(0) * inverseOf(seen.source()->model()->endEffectorPose(seen.source()->trueJoints(0, 0)));
        seen.source()->model()->forwardKinematics(seen.source()->trueJoints(0, 0), view.base_T_link);
        PartDrawing drawing;
        eye->draw(std::vector<ToolView>(1, view), 0, drawing);
        EXPECT_EQ(2, drawing.enlargement);
        FoundParts found, prepared;
        Ptr<GeometricContextVerifier> verifier = GeometricContextVerifier::create();
        eye->find(drawing, PartWindows(20), *verifier, found);
        ASSERT_GE(found.inliers.size(), 5u);
        Point2d mean;
        for (const PartMatch& m : found.inliers)
        {
            const Point2d expected = eye->camera().project(drawing.templates[m.templateIndex].viewPoint);
            EXPECT_LT(std::abs(m.predictedPoint.x - expected.x) + std::abs(m.predictedPoint.y - expected.y), 1e-6);   // rounding
            const Point2d off = m.imagePoint - expected;
            EXPECT_LT(std::sqrt(off.dot(off)), 3) << m.part;   // three of the larger pixels, which are spread by four
            mean += off * (1. / double(found.inliers.size()));
            EXPECT_TRUE(found.windows[m.templateIndex].contains(Point(cvRound(m.imagePoint.x), cvRound(m.imagePoint.y))));
        }
        EXPECT_LT(std::sqrt(mean.dot(mean)), 1) << variant;   // half a pixel of quantisation and what the blur of noise leaves
        eye->prepare();
        eye->find(drawing, PartWindows(20), *verifier, prepared);
        EXPECT_GE(prepared.inliers.size(), 5u);
    }
}

TEST(SurgTrack_SmallTools, enlargingIsThatOfResize)
{
    RNG rng(5);
    for (int type : {CV_8UC1, CV_8UC3})
    {
        Mat image(37, 301, type), whole, expected;
        rng.fill(image, RNG::UNIFORM, 0, 256);
        whole.create(image.size() * 2, type);
        enlargeTwice(image, Rect(Point(), whole.size()), whole);
        resize(image, expected, whole.size(), 0, 0, INTER_CUBIC);
        EXPECT_LE(cvtest::norm(whole, expected, NORM_INF), 1);   // rounding
        const Rect area(7, 3, 460, 33);
        Mat part(whole.size(), type, Scalar::all(0));
        enlargeTwice(image, area, part);
        EXPECT_EQ(0, cvtest::norm(part(area), whole(area), NORM_INF));
    }
}

TEST(SurgTrack_SmallTools, copiesOfTemplatesKeepTheirMemory)
{
    std::vector<PartTemplate> many(5), few(2);
    for (PartTemplate& t : many) t.features.resize(200);
    for (PartTemplate& t : few) t.features.resize(100);
    few[1].part = 7;
    TemplateCopies copies;
    EXPECT_EQ(5u, copies.of(many).size());
    ASSERT_EQ(2u, copies.of(few).size());
    EXPECT_EQ(7, copies.of(few)[1].part);
    EXPECT_EQ(100u, copies.of(few)[1].features.size());
    for (const PartTemplate& t : copies.of(many)) EXPECT_GE(t.features.capacity(), 200u);
}

}} // namespace
