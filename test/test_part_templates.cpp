// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_common.hpp"

namespace opencv_test { namespace {

const double BOX = PartTemplateRenderer::Params().boxSize;

std::vector<PartTemplate> templatesOf(const CameraModel& camera, const PosedTool& tool, double scale = 1, double rotation = 0)
{
    Ptr<PartTemplateRenderer> renderer = PartTemplateRenderer::create();
    renderer->addTool(tool.model);
    return renderer->renderTool(camera, tool.view.camera_T_base, tool.joints, scale, rotation);
}

bool equal(const std::vector<PartTemplate>& a, const std::vector<PartTemplate>& b)
{
    if (a.size() != b.size()) return false;
    for (size_t i = 0; i < a.size(); i++)
        if (a[i].tool != b[i].tool || a[i].part != b[i].part || a[i].imagePoint != b[i].imagePoint || a[i].anchor != b[i].anchor
            || a[i].viewPoint != b[i].viewPoint || a[i].bounds != b[i].bounds || a[i].features.size() != b[i].features.size()
            || cvtest::norm(a[i].getFeatures(), b[i].getFeatures(), NORM_INF) != 0)
            return false;
    return true;
}

std::set<int> partsOf(const std::vector<PartTemplate>& templates)
{
    std::set<int> parts;
    for (const PartTemplate& t : templates) parts.insert(t.part);
    return parts;
}

// A square plate, side [m], in the plane z = 0 of its base.
Ptr<ToolModel> plate(double side)
{
    ToolModel::Description d;
    d.name = "plate";
    d.coordinates.push_back("none");
    ToolModel::Link link;
    link.name = "plate";
    link.jointType = ToolModel::JOINT_REVOLUTE;
    link.coordinate = 0;
    link.scale = 1;
    link.mesh = 0;
    d.links.push_back(link);
    Mesh mesh;
    for (int i = 0; i < 4; i++) mesh.vertices.push_back(Point3f(float(i % 2 ? side : -side) / 2, float(i / 2 ? side : -side) / 2, 0.f));
    mesh.normals.assign(4, Point3f(0, 0, -1));
    mesh.triangles.push_back(Vec3i(0, 1, 2));
    mesh.triangles.push_back(Vec3i(1, 3, 2));
    d.meshes.push_back(mesh);
    ToolModel::Keypoint keypoint;
    keypoint.name = "middle";
    keypoint.link = 0;
    d.keypoints.push_back(keypoint);
    d.endEffectorLink = 0;
    return ToolModel::create(d);
}

ToolView plateView(const Ptr<ToolModel>& model, const Point3d& at)
{
    ToolView view;
    view.camera_T_base = rigid(Matx33d::eye(), at);
    model->forwardKinematics(std::vector<double>(1, 0.), view.base_T_link);
    return view;
}

// Views of the tool from several sides.
std::vector<PosedTool> severalViews()
{
    std::vector<PosedTool> views;
    views.push_back(PosedTool(0.1, 0.3, 1.1, 0.35));
    views.push_back(PosedTool(0.09, 2.5, 1.1, -0.3));
    views.push_back(PosedTool(0.11, -1.9, 2.1, 0.5, Point2d(0.01, -0.005)));
    views.push_back(PosedTool(0.08, 0.4, 2.4, 0.2, Point2d(-0.01, 0.01)));
    return views;
}

TEST(SurgTrack_PartTemplates, aPartHasATemplateIfAndOnlyIfTheDepthMapDoesNotHideIt)
{
    const CameraModel camera = endoscope();
    const PartTemplateRenderer::Params params;
    Ptr<MeshRenderer> drawing = MeshRenderer::createSoftware();
    int shown = 0, hidden = 0;
    for (const PosedTool& tool : severalViews())
    {
        Mat depth, ids, shading;
        drawing->renderTool(tool.model, tool.joints, tool.view.camera_T_base, camera, depth, ids, shading);
        const std::set<int> parts = partsOf(templatesOf(camera, tool));
        const std::vector<ToolModel::Keypoint>& keypoints = tool.model->keypoints();
        for (int i = 0; i < int(keypoints.size()); i++)
        {
            bool tip = true;
            for (const ToolModel::Link& link : tool.model->links()) tip = tip && link.parent != keypoints[i].link;
            const Point3d p = tool.keypoint(i);
            const Point2d u = camera.project(p);
            bool visible = false;   // in one of the nine pixels around it
            for (int j = 0; j < 9; j++)
            {
                const Point at(cvRound(u.x) + j % 3 - 1, cvRound(u.y) + j / 3 - 1);
                const float z = depth.at<float>(at);
                visible = visible || (z > 0 && p.z <= z + (tip ? params.tipDepthSlack : params.depthSlack));
            }
            (visible ? shown : hidden)++;
            EXPECT_EQ(visible, parts.count(i) == 1) << keypoints[i].name;
        }
    }
    EXPECT_GE(shown, 20);    // both cases occurred
    EXPECT_GE(hidden, 10);
}

TEST(SurgTrack_PartTemplates, partsHiddenByAnotherToolHaveNone)
{
    const CameraModel camera = endoscope();
    const PosedTool tool(0.1);
    const Ptr<ToolModel> cover = plate(0.2);
    Ptr<PartTemplateRenderer> renderer = PartTemplateRenderer::create();
    EXPECT_EQ(0, renderer->addTool(cover));
    EXPECT_EQ(1, renderer->addTool(tool.model));
    EXPECT_EQ(tool.model, renderer->model(1));
    std::vector<ToolView> views(2, tool.view);
    std::vector<PartTemplate> templates;

    views[0] = plateView(cover, Point3d(0, 0, 0.2));      // behind the tool
    renderer->render(camera, views, 1, templates);
    const std::set<int> all = partsOf(templates);
    ASSERT_GE(all.size(), 7u);
    for (const PartTemplate& t : templates) EXPECT_EQ(1, t.tool);

    views[0] = plateView(cover, Point3d(0, 0, 0.05));     // in front of all of it
    renderer->render(camera, views, 1, templates);
    EXPECT_TRUE(templates.empty());

    // In front of the left half.
    const double edge = -0.008;    // [m], at the depth of the plate
    views[0] = plateView(cover, Point3d(edge - 0.1, 0, 0.08));
    renderer->render(camera, views, 1, templates);
    const std::set<int> rest = partsOf(templates);
    const double border = camera.project(Point3d(edge, 0, 0.08)).x;
    int covered = 0;
    for (int part : all)
    {
        const double u = camera.project(tool.keypoint(part)).x;
        if (std::abs(u - border) < 5) continue;   // the lens bends the plate's edge
        covered += u < border;
        EXPECT_EQ(u > border, rest.count(part) == 1) << part;
    }
    EXPECT_GE(covered, 2);
    EXPECT_GE(rest.size(), 2u);
}

TEST(SurgTrack_PartTemplates, twoToolsOfOneModelHideEachOther)
{
    const CameraModel camera = endoscope();
    const PosedTool tool(0.1), front(0.08);   // the same pose, 2 cm nearer: hides most
    Ptr<PartTemplateRenderer> renderer = PartTemplateRenderer::create();
    renderer->addTool(tool.model);
    renderer->addTool(tool.model);
    std::vector<ToolView> views(1, tool.view);
    views.push_back(front.view);
    std::vector<PartTemplate> back, nearer;
    renderer->render(camera, views, 0, back);
    renderer->render(camera, views, 1, nearer);
    EXPECT_LT(back.size(), nearer.size());
    EXPECT_TRUE(partsOf(nearer) == partsOf(templatesOf(camera, front)));
}

TEST(SurgTrack_PartTemplates, aToolThatMayBeAnywhereHidesNothing)
{
    const CameraModel camera = endoscope();
    const PosedTool tool(0.1);
    Ptr<PartTemplateRenderer> renderer = PartTemplateRenderer::create();
    renderer->addTool(tool.model);
    renderer->addTool(tool.model);
    std::vector<ToolView> views(1, tool.view);
    views.push_back(PosedTool(0.08).view);   // would hide most of it
    views[1].base_T_link.clear();
    std::vector<PartTemplate> found;
    renderer->render(camera, views, 0, found);
    EXPECT_TRUE(partsOf(found) == partsOf(templatesOf(camera, tool)));
    EXPECT_ERROR(renderer->render(camera, views, 1, found), "link");
}

TEST(SurgTrack_PartTemplates, theAnchorIsWhereTheCameraSeesTheKeypoint)
{
    // Distortion and fx != fy.
    const CameraModel cameras[] = {endoscope(true), endoscope(false), endoscope(true, Size(320, 256))};
    for (const CameraModel& camera : cameras)
        for (const PosedTool& tool : severalViews())
            for (const PartTemplate& t : templatesOf(camera, tool))
            {
                const Point3d p = tool.keypoint(t.part);
                EXPECT_LT(cv::norm(t.viewPoint - p), 1e-12);                           // rounding [m]
                EXPECT_LT(cv::norm(t.imagePoint - camera.project(p)), 1e-8);           // rounding [pixel]
                EXPECT_EQ(Point(cvRound(t.imagePoint.x), cvRound(t.imagePoint.y)), t.anchor);
            }
}

TEST(SurgTrack_PartTemplates, featuresLieInTheBoxAndOnTheToolsPixelsOrOneBeside)
{
    const CameraModel cameras[] = {endoscope(true), endoscope(true, Size(320, 256))};
    Ptr<MeshRenderer> drawing = MeshRenderer::createSoftware();
    for (const CameraModel& camera : cameras)
        for (const PosedTool& tool : severalViews())
        {
            Mat depth, ids, shading, near;
            drawing->renderTool(tool.model, tool.joints, tool.view.camera_T_base, camera, depth, ids, shading);
            cv::dilate(ids != 0, near, getStructuringElement(MORPH_CROSS, Size(3, 3)));
            const std::vector<PartTemplate> templates = templatesOf(camera, tool);
            ASSERT_FALSE(templates.empty());
            for (const PartTemplate& t : templates)
            {
                ASSERT_GE(t.features.size(), 30u);
                ASSERT_LE(t.features.size(), 250u);
                const int hx = cvRound(BOX * camera.fx / t.viewPoint.z / 2), hy = cvRound(BOX * camera.fy / t.viewPoint.z / 2);
                std::set<std::pair<int, int> > places;
                for (const TemplateFeature& f : t.features)
                {
                    ASSERT_LE(std::abs(f.x), hx);
                    ASSERT_LE(std::abs(f.y), hy);
                    ASSERT_LT(f.bin, 8);
                    ASSERT_TRUE(near.at<uchar>(t.anchor + Point(f.x, f.y))) << t.part;
                    ASSERT_TRUE(t.bounds.contains(Point(f.x, f.y)));
                    ASSERT_TRUE(places.insert(std::make_pair(f.x, f.y)).second) << "twice";
                }
                const Mat features = t.getFeatures();
                ASSERT_EQ(Size(3, int(t.features.size())), features.size());
                ASSERT_EQ(t.features.back().x, features.at<int>(features.rows - 1, 0));
                ASSERT_EQ(t.features.back().y, features.at<int>(features.rows - 1, 1));
                ASSERT_EQ(t.features.back().bin, features.at<int>(features.rows - 1, 2));
            }
        }
}

TEST(SurgTrack_PartTemplates, theBoxFollowsDepthAndFocalLength)
{
    const double depths[] = {0.06, 0.09, 0.14, 0.2};
    const Size sizes[] = {Size(720, 576), Size(1440, 1152)};
    for (const Size& size : sizes)
        for (double depth : depths)
        {
            const CameraModel camera = endoscope(false, size);
            double fill = 0, fillY = 0;
            for (const PartTemplate& t : templatesOf(camera, PosedTool(depth, 0.8)))
            {
                fill = std::max(fill, t.bounds.width / (BOX * camera.fx / t.viewPoint.z));
                fillY = std::max(fillY, t.bounds.height / (BOX * camera.fy / t.viewPoint.z));
            }
            // Boxes on the wrist are full of edges; a box has an odd number of pixels, so it may exceed its size by one and a half of 40.
            EXPECT_GT(fill, 0.9) << size << " " << depth;
            EXPECT_GT(fillY, 0.9) << size << " " << depth;
            EXPECT_LT(fill, 1.05) << size << " " << depth;
            EXPECT_LT(fillY, 1.05) << size << " " << depth;
        }
}

TEST(SurgTrack_PartTemplates, featuresAreSpreadOverTheBoxWhenThinned)
{
    const CameraModel camera = endoscope();
    const PosedTool tool(0.06);
    PartTemplateRenderer::Params params;
    params.maxFeatures = 100000;
    Ptr<PartTemplateRenderer> every = PartTemplateRenderer::create(Ptr<MeshRenderer>(), params);
    params.maxFeatures = 60;
    Ptr<PartTemplateRenderer> few = PartTemplateRenderer::create(Ptr<MeshRenderer>(), params);
    every->addTool(tool.model);
    few->addTool(tool.model);
    const std::vector<PartTemplate> all = every->renderTool(camera, tool.view.camera_T_base, tool.joints);
    const std::vector<PartTemplate> thin = few->renderTool(camera, tool.view.camera_T_base, tool.joints);
    ASSERT_EQ(all.size(), thin.size());
    ASSERT_FALSE(all.empty());
    for (size_t i = 0; i < all.size(); i++)
    {
        ASSERT_EQ(60u, thin[i].features.size());
        ASSERT_GT(all[i].features.size(), 200u);
        // The same centre of mass as all of them: within a tenth of the box.
        Point2d a, b;
        for (const TemplateFeature& f : all[i].features) a += Point2d(f.x, f.y) * (1. / double(all[i].features.size()));
        for (const TemplateFeature& f : thin[i].features) b += Point2d(f.x, f.y) * (1. / 60);
        EXPECT_LT(cv::norm(a - b), 0.1 * BOX * camera.fx / all[i].viewPoint.z) << all[i].part;
    }
}

TEST(SurgTrack_PartTemplates, featuresAreTheOrientationsOfTheDrawing)
{
    // Inside the outline, where the background does not matter; linear changes of the grey levels do not turn gradients.
    const CameraModel camera = endoscope();
    for (const PosedTool& tool : severalViews())
    {
        Mat depth, ids, shading, orientations, inside;
        MeshRenderer::createSoftware()->renderTool(tool.model, tool.joints, tool.view.camera_T_base, camera, depth, ids, shading);
        quantizeOrientations(shading, orientations, 40);
        cv::erode(ids != 0, inside, Mat(), Point(-1, -1), 6);   // blur, Sobel and vote reach five pixels
        int all = 0, same = 0;
        for (const PartTemplate& t : templatesOf(camera, tool))
            for (const TemplateFeature& f : t.features)
            {
                const Point at = t.anchor + Point(f.x, f.y);
                if (!inside.at<uchar>(at)) continue;
                all++;
                same += orientations.at<uchar>(at) == 1 << f.bin;
            }
        EXPECT_GT(all, 100);
        EXPECT_GT(same, 0.95 * all);   // rounded grey levels move some gradients over a bin's bound
    }
}

TEST(SurgTrack_PartTemplates, aToolOutOfViewOrBehindTheCameraHasNone)
{
    const CameraModel camera = endoscope();
    EXPECT_TRUE(templatesOf(camera, PosedTool(0.1, 0.3, 1.1, 0.3, Point2d(0.3, 0))).empty());
    EXPECT_TRUE(templatesOf(camera, PosedTool(0.1, 0.3, 1.1, 0.3, Point2d(0, -0.3))).empty());
    EXPECT_TRUE(templatesOf(camera, PosedTool(-0.1)).empty());
    EXPECT_TRUE(templatesOf(camera, PosedTool(-0.005, 0, 0)).empty());
    EXPECT_FALSE(templatesOf(camera, PosedTool(0.1)).empty());
}

TEST(SurgTrack_PartTemplates, boxesAtTheBorderStayInTheImage)
{
    // The tip a few pixels inside each border of the image.
    const CameraModel camera = endoscope(false);
    const Point2d targets[] = {Point2d(3, 280), Point2d(716, 280), Point2d(330, 2), Point2d(330, 573), Point2d(1, 1), Point2d(718, 574)};
    const Rect image(Point(), camera.imageSize());
    for (const Point2d& target : targets)
    {
        const double z = 0.1;
        const PosedTool tool(z, 0.3, 1.1, 0.35, Point2d((target.x - camera.cx) / camera.fx * z, (target.y - camera.cy) / camera.fy * z));
        for (const PartTemplate& t : templatesOf(camera, tool))
        {
            EXPECT_TRUE(image.contains(t.anchor));
            for (const TemplateFeature& f : t.features) ASSERT_TRUE(image.contains(t.anchor + Point(f.x, f.y))) << target;
        }
    }
}

// How the part's image points lie about their common centre.
struct Arrangement
{
    Arrangement(const CameraModel& camera, const PosedTool& tool, double scale, double rotation)
    {
        // Rays instead of pixels, so that fx != fy does not shear.
        const std::vector<PartTemplate> templates = templatesOf(camera, tool, scale, rotation);
        for (const PartTemplate& t : templates) rays[t.part] = Point2d(t.viewPoint.x / t.viewPoint.z, t.viewPoint.y / t.viewPoint.z);
        Point3d centre;
        for (size_t i = 0; i < tool.model->keypoints().size(); i++) centre += tool.keypoint(i) * (1. / double(tool.model->keypoints().size()));
        middle = Point2d(centre.x / centre.z, centre.y / centre.z);
    }
    std::map<int, Point2d> rays;
    Point2d middle;
};

TEST(SurgTrack_PartTemplates, scaleEnlargesTheToolAboutTheCentreOfItsKeypoints)
{
    const CameraModel camera = endoscope();
    for (const PosedTool& tool : severalViews())
    {
        const Arrangement plain(camera, tool, 1, 0);
        const double scales[] = {0.8, 1.2};
        for (double scale : scales)
        {
            const Arrangement scaled(camera, tool, scale, 0);
            int compared = 0;
            double mean = 0;
            for (const std::pair<const int, Point2d>& p : plain.rays)
                if (scaled.rays.count(p.first))
                {
                    const double before = cv::norm(p.second - plain.middle), after = cv::norm(scaled.rays.at(p.first) - plain.middle);
                    EXPECT_NEAR(scale, after / before, 0.06) << p.first;   // nearer parts grow more: the tool is 2 cm deep at 10 cm
                    mean += after / before;
                    compared++;
                }
            ASSERT_GE(compared, 4);
            EXPECT_NEAR(scale, mean / compared, 0.03);   // visible parts are on the near side
        }
    }
}

TEST(SurgTrack_PartTemplates, rotationTurnsTheToolAboutTheViewingRay)
{
    const CameraModel camera = endoscope();
    for (const PosedTool& tool : severalViews())
    {
        const Arrangement plain(camera, tool, 1, 0);
        const double angles[] = {15 * CV_PI / 180, -15 * CV_PI / 180};
        for (double angle : angles)
        {
            const Arrangement turned(camera, tool, 1, angle);
            int compared = 0;
            for (const std::pair<const int, Point2d>& p : plain.rays)
                if (turned.rays.count(p.first))
                {
                    const Point2d before = p.second - plain.middle, after = turned.rays.at(p.first) - plain.middle;
                    const double by = std::atan2(before.cross(after), before.dot(after));
                    EXPECT_NEAR(angle, by, 0.03) << p.first;                             // the ray is up to 10 degrees off the axis: the plane z = 1 shears
                    EXPECT_NEAR(1, cv::norm(after) / cv::norm(before), 0.06) << p.first; // the same
                    compared++;
                }
            ASSERT_GE(compared, 4);
        }
    }
}

TEST(SurgTrack_PartTemplates, theSameInputGivesTheSameTemplates)
{
    const CameraModel camera = endoscope();
    const std::vector<PosedTool> views = severalViews();
    Ptr<PartTemplateRenderer> renderer = PartTemplateRenderer::create();
    renderer->addTool(views[0].model);
    std::vector<std::vector<PartTemplate> > first;
    for (const PosedTool& v : views) first.push_back(renderer->renderTool(camera, v.view.camera_T_base, v.joints));
    // In another order, from other memory.
    for (int i = int(views.size()) - 1; i >= 0; i--)
    {
        EXPECT_TRUE(equal(first[i], renderer->renderTool(camera, views[i].view.camera_T_base, views[i].joints))) << i;
        EXPECT_TRUE(equal(first[i], templatesOf(camera, views[i]))) << i;
    }
}

TEST(SurgTrack_PartTemplates, aTemplateWithTooFewFeaturesIsDropped)
{
    const CameraModel camera = endoscope();
    const PosedTool tool;
    PartTemplateRenderer::Params params;
    params.minFeatures = params.maxFeatures + 1;
    Ptr<PartTemplateRenderer> renderer = PartTemplateRenderer::create(Ptr<MeshRenderer>(), params);
    renderer->addTool(tool.model);
    EXPECT_TRUE(renderer->renderTool(camera, tool.view.camera_T_base, tool.joints).empty());
}

TEST(SurgTrack_PartTemplates, rejectsBadInput)
{
    const CameraModel camera = endoscope();
    const PosedTool tool;
    Ptr<PartTemplateRenderer> renderer = PartTemplateRenderer::create();
    EXPECT_THROW(renderer->addTool(Ptr<ToolModel>()), cv::Exception);
    renderer->addTool(tool.model);
    std::vector<PartTemplate> templates;
    EXPECT_ERROR(renderer->render(camera, std::vector<ToolView>(), 0, templates), "views");
    EXPECT_ERROR(renderer->render(camera, std::vector<ToolView>(2, tool.view), 0, templates), "views");
    EXPECT_ERROR(renderer->render(camera, std::vector<ToolView>(1, tool.view), 1, templates), "tool");
    EXPECT_ERROR(renderer->render(camera, std::vector<ToolView>(1, tool.view), -1, templates), "tool");
    EXPECT_ERROR(renderer->render(camera, std::vector<ToolView>(1, tool.view), 0, templates, 0), "scale");
    EXPECT_ERROR(renderer->render(camera, std::vector<ToolView>(1, tool.view), 0, templates, NOT_A_NUMBER), "scale");
    std::vector<double> joints = tool.joints;
    joints[2] = NOT_A_NUMBER;
    EXPECT_ERROR(renderer->renderTool(camera, tool.view.camera_T_base, joints), "joints");
    EXPECT_ERROR(renderer->renderTool(camera, tool.view.camera_T_base, std::vector<double>(3, 0.)), "joints");
    PartTemplateRenderer::Params params;
    params.boxSize = 0;
    EXPECT_ERROR(PartTemplateRenderer::create(Ptr<MeshRenderer>(), params), "boxSize");
    params = PartTemplateRenderer::Params();
    params.maxFeatures = 0;
    EXPECT_ERROR(PartTemplateRenderer::create(Ptr<MeshRenderer>(), params), "maxFeatures");
}

TEST(SurgTrack_PartTemplates, rejectsPosesThatAreNotFinite)
{
    const CameraModel camera = endoscope();
    const PosedTool tool;
    Ptr<PartTemplateRenderer> renderer = PartTemplateRenderer::create();
    renderer->addTool(tool.model);
    Matx44d bad = tool.view.camera_T_base;
    bad(0, 3) = NOT_A_NUMBER;
    EXPECT_THROW(renderer->renderTool(camera, bad, tool.joints), cv::Exception);
    EXPECT_THROW(renderer->renderTool(camera, tool.view.camera_T_base, tool.joints, 1, NOT_A_NUMBER), cv::Exception);
}

}} // namespace
