// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "perf_common.hpp"
#include "opencv2/core/utils/filesystem.hpp"
#include "opencv2/opencv_modules.hpp"
#ifdef HAVE_OPENCV_RGBD
#include "opencv2/rgbd/linemod.hpp"
#endif
#ifdef HAVE_OPENCV_RAPID
#include "opencv2/calib3d.hpp"
#include "opencv2/rapid.hpp"
#endif

// The module beside its peers in OpenCV, those of opencv_contrib if they are in the build. misc/compare_peers.sh makes a table.

namespace opencv_test { namespace {

typedef TestBaseWithParam<Size> Size_Peers;

/* The job of cv::linemod: an image comes, and 28 templates of 63 features are sought all over it. Both matchers get the same
features, cut from a drawn image of two tools, and seek them in that image and in a copy that is moved by a fraction of linemod's
grid of 4 pixels, with more noise; the time is measured on the copy. Whether they do the job is checked: the best match of each
template within 4 pixels in x and y, as fine as linemod's grid. */
struct Matching
{
    enum { TEMPLATES = 28, FEATURES = 63, GRID = 4 };

    explicit Matching(Size size)
    {
        const View view(size, 2);
        image = view.image;
        templates = cutTemplates(image, TEMPLATES, FEATURES);
        shift = Point2d(1.5, 1);
        const Matx23d T(1, 0, shift.x, 0, 1, shift.y);
        warpAffine(image, moved, T, size, INTER_LINEAR, BORDER_REPLICATE);
        RNG rng(7);
        Mat noise(size, CV_16SC3);
        rng.fill(noise, RNG::NORMAL, 0, 8);
        cv::add(moved, noise, moved, noArray(), CV_8U);
    }

    bool isRight(int index, const Point2d& found, bool inMoved) const
    {
        const Point2d error = found - Point2d(templates[index].anchor) - (inMoved ? shift : Point2d());
        return std::abs(error.x) <= GRID && std::abs(error.y) <= GRID;
    }

    Mat image, moved;
    std::vector<PartTemplate> templates;
    Point2d shift;
};

int recall(QGOMatcher& matcher, const Matching& job, bool inMoved)
{
    std::vector<PartMatch> matches;
    matcher.setImage(inMoved ? job.moved : job.image);
    matcher.match(job.templates, std::vector<Rect>(), matches);
    std::vector<char> seen(job.templates.size());
    int right = 0;
    for (size_t i = 0; i < matches.size(); i++)
        if (!seen[matches[i].templateIndex]++) right += job.isRight(matches[i].templateIndex, matches[i].imagePoint, inMoved);
    return right;
}

PERF_TEST_P(Size_Peers, matchingOurs, SURGTRACK_SIZES)
{
    const Matching job(GetParam());
    Ptr<QGOMatcher> matcher = QGOMatcher::create();
    const int inImage = recall(*matcher, job, false), inMoved = recall(*matcher, job, true);
    std::vector<PartMatch> matches;
    TEST_CYCLE()
    {
        matcher->setImage(job.moved);
        matcher->match(job.templates, std::vector<Rect>(), matches);
    }
    RecordProperty("recall", format("%d and %d of %d", inImage, inMoved, int(Matching::TEMPLATES)).c_str());
    EXPECT_EQ(int(Matching::TEMPLATES), inImage);
    EXPECT_EQ(int(Matching::TEMPLATES), inMoved);
    SANITY_CHECK_NOTHING();
}

#ifdef HAVE_OPENCV_RGBD

/* cv::linemod with gradients only and one level, T = {4}: its default T = {5, 8} throws at these sizes, and T = {4, 8} reads beyond
its images. Its threshold is 75, the highest that finds every template: with less it is slower, for it has more candidates. */
struct Linemod
{
    Linemod(const Matching& job, float weakThreshold)
        : detector(std::vector<Ptr<linemod::Modality> >(1, makePtr<linemod::ColorGradient>(weakThreshold, size_t(Matching::FEATURES), 55.f)),
                   std::vector<int>(1, int(Matching::GRID)))
    {
        for (size_t i = 0; i < job.templates.size(); i++)
        {
            const PartTemplate& t = job.templates[i];
            linemod::Template pattern;
            pattern.pyramid_level = 0;
            pattern.width = t.bounds.width;
            pattern.height = t.bounds.height;
            for (size_t j = 0; j < t.features.size(); j++)
                pattern.features.push_back(linemod::Feature(t.features[j].x - t.bounds.x, t.features[j].y - t.bounds.y, t.features[j].bin));
            CV_Assert(detector.addSyntheticTemplate(std::vector<linemod::Template>(1, pattern), "part") == int(i));
        }
    }

    void match(const Mat& image) { detector.match(std::vector<Mat>(1, image), 75, matches); }

    int recall(const Matching& job, bool inMoved)
    {
        match(inMoved ? job.moved : job.image);
        std::vector<char> seen(job.templates.size());
        int right = 0;
        for (size_t i = 0; i < matches.size(); i++)
        {
            const int index = matches[i].template_id;
            if (!seen[index]++) right += job.isRight(index, Point(matches[i].x, matches[i].y) - job.templates[index].bounds.tl(), inMoved);
        }
        return right;
    }

    linemod::Detector detector;
    std::vector<linemod::Match> matches;
};

// With our threshold of gradients instead of its default of 10: fewer pixels to vote for, so it is faster, with the same recall.
PERF_TEST_P(Size_Peers, matchingLinemod, SURGTRACK_SIZES)
{
    const Matching job(GetParam());
    Linemod peer(job, 50);
    const int inImage = peer.recall(job, false), inMoved = peer.recall(job, true);
    TEST_CYCLE() peer.match(job.moved);
    RecordProperty("recall", format("%d and %d of %d", inImage, inMoved, int(Matching::TEMPLATES)).c_str());
    EXPECT_EQ(int(Matching::TEMPLATES), inImage);
    EXPECT_EQ(int(Matching::TEMPLATES), inMoved);
    SANITY_CHECK_NOTHING();
}

PERF_TEST_P(Size_Peers, matchingLinemodDefaultThreshold, SURGTRACK_SIZES)
{
    const Matching job(GetParam());
    Linemod peer(job, 10);
    const int inImage = peer.recall(job, false), inMoved = peer.recall(job, true);
    TEST_CYCLE() peer.match(job.moved);
    RecordProperty("recall", format("%d and %d of %d", inImage, inMoved, int(Matching::TEMPLATES)).c_str());
    EXPECT_EQ(int(Matching::TEMPLATES), inImage);
    EXPECT_EQ(int(Matching::TEMPLATES), inMoved);
    SANITY_CHECK_NOTHING();
}

#endif // HAVE_OPENCV_RGBD

/* One frame, one tool, a camera without distortion because cv::rapid knows none. The two do not do the same. ToolTracker finds where
an articulated tool is from joint readings and a hand-eye calibration that are wrong, and says whether it can be believed;
cv::rapid refines the pose of a rigid mesh from a near one. So this is a time beside a time, not a contest. */
struct Tracking
{
    explicit Tracking(Size size) : scene(SyntheticScene::create(Ptr<ToolModel>(), sceneOf(size, 1, false))), camera(scene->camera())
    {
        for (int frame = 0; frame < 3; frame++) images.push_back(drawn(sceneOf(size, 1, false), frame));
    }

    static int frame(int shown) { return shown % 4 == 3 ? 1 : shown % 4; }    // to and fro, so that motion never jumps

    Ptr<SyntheticScene> scene;
    CameraModel camera;
    std::vector<Mat> images;
};

PERF_TEST_P(Size_Peers, trackingOurs, SURGTRACK_SIZES)
{
    const Tracking job(GetParam());
    Ptr<ToolTracker> tracker = ToolTracker::create(job.camera);
    tracker->addTool(job.scene->model(), job.scene->nominal_T_base(0));
    std::vector<std::vector<std::vector<double> > > joints;
    for (int frame = 0; frame < 3; frame++) joints.push_back(std::vector<std::vector<double> >(1, job.scene->recordedJoints(0, frame / 25.)));
    std::vector<ToolEstimate> estimates;
    int shown = 0;
    for (; shown < 20; shown++) tracker->update(job.images[Tracking::frame(shown)], shown / 25., joints[Tracking::frame(shown)], estimates);
    TEST_CYCLE()
    {
        tracker->update(job.images[Tracking::frame(shown)], shown / 25., joints[Tracking::frame(shown)], estimates);
        shown++;
    }
    EXPECT_EQ(STATE_TRACKING, estimates[0].state);
    const Matx44d error = estimates[0].camera_T_tool - job.scene->truePose(0, Tracking::frame(shown - 1) / 25.);
    RecordProperty("error", format("%.2f mm", 1e3 * cv::norm(Vec3d(error(0, 3), error(1, 3), error(2, 3)))).c_str());
    SANITY_CHECK_NOTHING();
}

#ifdef HAVE_OPENCV_RAPID

// What lies within 25 mm of the end effector, with the true joints, as one rigid mesh of about a thousand triangles.
void rigidMesh(const SyntheticScene& scene, std::vector<Point3f>& vertices, std::vector<Vec3i>& triangles)
{
    const String folder = cv::tempfile(""), file = utils::fs::join(folder, "tool.yaml");
    CV_Assert(utils::fs::createDirectories(folder));
    scene.model()->save(file);
    const Ptr<ToolModel> model = ToolModel::load(file, 1500);
    std::vector<Matx44d> base_T_link;
    model->forwardKinematics(scene.trueJoints(0, 0), base_T_link);
    const Matx44d tool_T_base = scene.model()->endEffectorPose(scene.trueJoints(0, 0)).inv();
    for (size_t i = 0; i < model->links().size(); i++)
    {
        if (model->links()[i].mesh < 0) continue;
        const Mesh& mesh = model->meshes()[model->links()[i].mesh];
        const Matx44d tool_T_link = tool_T_base * base_T_link[i];
        // Only what is drawn: cv::rapid takes every vertex that projects onto the outline for a point of it.
        std::vector<int> number(mesh.vertices.size(), -1);
        for (size_t k = 0; k < mesh.triangles.size(); k++)
        {
            Point3f corners[3];
            bool near = true;
            for (int j = 0; j < 3; j++)
            {
                const Point3f& p = mesh.vertices[mesh.triangles[k][j]];
                const Vec4d q = tool_T_link * Vec4d(p.x, p.y, p.z, 1);
                corners[j] = Point3f(float(q[0]), float(q[1]), float(q[2]));
                near = near && cv::norm(corners[j]) < 0.025;
            }
            if (!near) continue;
            Vec3i triangle;
            for (int j = 0; j < 3; j++)
            {
                int& index = number[mesh.triangles[k][j]];
                if (index < 0)
                {
                    index = int(vertices.size());
                    vertices.push_back(corners[j]);
                }
                triangle[j] = index;
            }
            triangles.push_back(triangle);
        }
    }
    utils::fs::remove_all(folder);
}

/* 100 search lines of +-4 pixels at 720 pixels' width, at most five iterations and the criterion that are its default; from 0.5 mm (4
pixels) and one degree off. With longer lines it takes inner edges of the steel for the outline and ends 3 to 17 mm away. */
PERF_TEST_P(Size_Peers, trackingRapid, SURGTRACK_SIZES)
{
    const Tracking job(GetParam());
    std::vector<Point3f> vertices;
    std::vector<Vec3i> triangles;
    rigidMesh(*job.scene, vertices, triangles);
    Ptr<rapid::Rapid> peer = rapid::Rapid::create(vertices, triangles);
    const Matx44d truth = job.scene->truePose(0, 0);
    Vec3d trueRotation;
    Rodrigues(truth.get_minor<3, 3>(0, 0), trueRotation);
    const Vec3d trueTranslation(truth(0, 3), truth(1, 3), truth(2, 3));
    Mat rvec, tvec;
    float matched = 0;
    TEST_CYCLE()
    {
        rvec = Mat(trueRotation + Vec3d(0.01, -0.01, 0.01)).clone();
        tvec = Mat(trueTranslation + Vec3d(0.0003, 0.0004, 0)).clone();
        matched = peer->compute(job.images[0], 100, cvRound(4 * GetParam().width / 720.), job.camera.cameraMatrix(), rvec, tvec);
    }
    EXPECT_GT(matched, 0.5f);
    RecordProperty("error", format("%.2f mm", 1e3 * cv::norm(Vec3d(tvec.ptr<double>()) - trueTranslation)).c_str());
    SANITY_CHECK_NOTHING();
}

#endif // HAVE_OPENCV_RAPID

}} // namespace
