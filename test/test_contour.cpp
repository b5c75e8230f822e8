// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_common.hpp"

namespace opencv_test { namespace {

// Dense, and as many as there are.
ToolContour::Params dense()
{
    ToolContour::Params params;
    params.spacing = 3;
    params.maxPoints = 100000;
    return params;
}

Ptr<ToolContour> denseContour()
{
    static const Ptr<ToolContour> contour = ToolContour::create(needleDriver(), dense());
    return contour;
}

std::vector<PosedTool> severalViews()
{
    std::vector<PosedTool> views;
    views.push_back(PosedTool(0.1, 0.3, 1.1, 0.35));
    views.push_back(PosedTool(0.09, 2.5, 1.1, -0.3));
    views.push_back(PosedTool(0.11, -1.9, 2.1, 0.5, Point2d(0.005, -0.003)));
    views.push_back(PosedTool(0.08, 0.4, 0.7, 0.2, Point2d(-0.005, 0.005)));
    return views;
}

// All tools in one drawing, with the ids 1, 2, ...
void draw(const CameraModel& camera, const Rect& window, const std::vector<ToolView>& views, Rendering& rendering)
{
    const Ptr<ToolModel> model = needleDriver();
    Ptr<MeshRenderer> renderer = MeshRenderer::createSoftware();
    std::vector<int> meshes;
    for (const Mesh& mesh : model->meshes()) meshes.push_back(renderer->addMesh(mesh));
    std::vector<MeshInstance> instances;
    for (size_t i = 0; i < views.size(); i++)
        for (size_t l = 0; l < model->links().size(); l++)
        {
            if (model->links()[l].mesh < 0) continue;
            const MeshInstance instance = {meshes[model->links()[l].mesh], int(i) + 1, views[i].camera_T_base * views[i].base_T_link[l]};
            instances.push_back(instance);
        }
    renderer->render(camera, window, instances, rendering);
}

std::vector<ContourPoint> sampled(ToolContour& contour, const CameraModel& camera, const Rect& window, const std::vector<ToolView>& views, int tool = 0)
{
    Rendering rendering;
    draw(camera, window, views, rendering);
    std::vector<ContourPoint> points;
    contour.sample(camera, views[tool], rendering, tool + 1, points);
    return points;
}

std::vector<ContourPoint> sampled(const CameraModel& camera, const PosedTool& tool)
{
    return sampled(*denseContour(), camera, Rect(Point(), camera.imageSize()), std::vector<ToolView>(1, tool.view));
}

/* The silhouette in pixels an eighth as wide, of a camera without distortion and with fx = fy: its pixels are exact, since straight
   edges stay straight. */
struct Silhouette
{
    enum { FINER = 8 };

    // Drawn around the points only.
    Silhouette(const CameraModel& _camera, const ToolView& view, const std::vector<ContourPoint>& points) : camera(_camera)
    {
        const Size size = camera.imageSize();
        const Rect2d field = camera.fieldOfView(Rect(Point(), size));
        const double f = FINER * std::max(camera.fx, camera.fy);
        const Size fine(cvCeil(f * field.width), cvCeil(f * field.height));
        pinhole = CameraModel(Matx33d(f, 0, -f * field.x, 0, f, -f * field.y, 0, 0, 1), noArray(), fine);
        Rect2d box;
        for (const ContourPoint& c : points)
        {
            const Point2d ray = lineAlong(c).at;
            const Rect2d at(f * (ray.x - field.x) - 5 * FINER, f * (ray.y - field.y) - 5 * FINER, 10 * FINER, 10 * FINER);
            box = box.empty() ? at : box | at;
        }
        draw(pinhole, Rect(box) & Rect(Point(), fine), std::vector<ToolView>(1, view), rendering);
    }

    // Image points on a line, as the fine drawing has them; the lens bends it by less than 1e-3 pixels in a few.
    struct Line
    {
        Point2d at, step;
    };

    Line lineAlong(const ContourPoint& c) const
    {
        Mat_<Vec2d> rays;
        const Point2d end = c.imagePoint + c.normal;
        camera.unprojectPoints(Mat(Matx22d(c.imagePoint.x, c.imagePoint.y, end.x, end.y)), rays);
        const Line line = {Point2d(rays(0)), Point2d(rays(1)) - Point2d(rays(0))};
        return line;
    }

    // Whether the tool is on the line, so many pixels from its origin.
    bool covers(const Line& line, double t) const
    {
        const Point2d ray = line.at + t * line.step;
        const Point at = Point(cvRound(pinhole.fx * ray.x + pinhole.cx), cvRound(pinhole.fy * ray.y + pinhole.cy)) - rendering.window.tl();
        return Rect(Point(), rendering.ids.size()).contains(at) && rendering.ids.at<uchar>(at) != 0;
    }

    // Where the outline is, from a point along its normal [pixel]; NaN if not within so many pixels.
    double offset(const ContourPoint& c, double within = 3) const
    {
        const double step = 1. / 32;
        const Line line = lineAlong(c);
        for (double t = step / 2; t < within; t += step)
            for (int side = -1; side <= 1; side += 2)
                if (covers(line, side * t - step / 2) && !covers(line, side * t + step / 2)) return side * t;
        return NOT_A_NUMBER;
    }

    CameraModel camera, pinhole;
    Rendering rendering;
};

struct Offsets
{
    Offsets() : mean(0), missing(0) {}

    void add(double offset)
    {
        if (cvIsNaN(offset)) missing++;
        else all.push_back(offset);
    }

    // The share p of them is at most this far off.
    double within(double p)
    {
        std::vector<double> sizes;
        mean = 0;
        for (double v : all)
        {
            sizes.push_back(std::abs(v));
            mean += v / all.size();
        }
        std::sort(sizes.begin(), sizes.end());
        return sizes.empty() ? NOT_A_NUMBER : sizes[std::min(sizes.size() - 1, size_t(p * sizes.size()))];
    }

    std::vector<double> all;
    double mean;
    int missing;
};

TEST(SurgTrack_Contour, pointsLieOnTheSilhouetteOfADrawingEightTimesFinerAndNormalsPointOutOfIt)
{
    const CameraModel cameras[] = {endoscope(false), endoscope(true)};
    const std::vector<PosedTool> tools = severalViews();
    for (int lens = 0; lens < 2; lens++)
    {
        const CameraModel& camera = cameras[lens];
        Offsets offsets;
        size_t outwards = 0;
        for (size_t i = lens; i < tools.size(); i += 2)
        {
            const std::vector<ContourPoint> points = sampled(camera, tools[i]);
            ASSERT_GE(points.size(), 200u);
            const Silhouette truth(camera, tools[i].view, points);
            for (const ContourPoint& c : points)
            {
                EXPECT_NEAR(1, cv::norm(c.normal), 1e-12);   // rounding
                offsets.add(truth.offset(c));
                const Silhouette::Line line = truth.lineAlong(c);
                outwards += truth.covers(line, -0.4) && !truth.covers(line, 0.4);
            }
        }
        const double most = offsets.within(0.95), median = offsets.within(0.5);
        // [pixel]. The fine drawing is good to half of its pixels, 0.06; in the mean this cancels. Measured: mean 0.012, median 0.016, 95 % 0.078.
        EXPECT_LT(std::abs(offsets.mean), 0.025);
        EXPECT_LT(median, 0.05);
        EXPECT_LT(most, 0.15);
        EXPECT_LE(offsets.missing, 2);
        EXPECT_GT(outwards, 0.98 * offsets.all.size());   // the rest are corners, and edges half a pixel beside the outline
    }
}

TEST(SurgTrack_Contour, pointsAreWhereTheCameraSeesThemOnTheirLink)
{
    const CameraModel camera = endoscope();
    for (const PosedTool& tool : severalViews())
        for (const ContourPoint& c : sampled(camera, tool))
        {
            ASSERT_TRUE(c.link >= 0 && c.link < int(tool.model->links().size()) && tool.model->links()[c.link].mesh >= 0);
            const Matx44d T = tool.view.camera_T_base * tool.view.base_T_link[c.link];
            const Point3d p = transformed(T, c.linkPoint), q = transformed(T, c.linkPoint + 1e-6 * c.linkDirection);
            EXPECT_LT(cv::norm(camera.project(p) - c.imagePoint), 2e-3);   // vertices are float: 1e-8 of 0.45 m, at 9 pixels a millimetre
            EXPECT_NEAR(1, cv::norm(c.linkDirection), 1e-6);               // the same
            // The tool is on its left: with y down, the normal is on the right of (x, y) if it is (-y, x).
            const Point2d along = camera.project(q) - camera.project(p);
            EXPECT_GT(c.normal.dot(Point2d(-along.y, along.x)), 0.999 * cv::norm(along));   // a difference over a micrometre
            EXPECT_FALSE(c.found);
            EXPECT_FALSE(c.crease);
        }
}

TEST(SurgTrack_Contour, aToolHiddenByAnotherHasNoPointsThere)
{
    const CameraModel camera = endoscope();
    const Rect window(Point(), camera.imageSize());
    const PosedTool back(0.1, 0.3), front(0.08, 1.9, 1.1, 0.35, Point2d(-0.004, 0.006));   // crosses in front
    std::vector<ToolView> views(1, back.view);
    const std::vector<ContourPoint> alone = sampled(*denseContour(), camera, window, views);
    views.push_back(front.view);
    Rendering both, single;
    draw(camera, window, views, both);
    draw(camera, window, std::vector<ToolView>(1, front.view), single);
    std::vector<ContourPoint> rest;
    denseContour()->sample(camera, views[0], both, 1, rest);
    ASSERT_GE(rest.size(), 50u);
    Mat well, near;
    erode(single.ids, well, Mat::ones(3, 3, CV_8U));
    dilate(single.ids, near, Mat::ones(5, 5, CV_8U));   // what a pixel beside a point is decides
    size_t kept = 0, hidden = 0;
    for (const ContourPoint& c : alone)
    {
        const bool still = kept < rest.size() && rest[kept].imagePoint == c.imagePoint;
        const Point at(cvRound(c.imagePoint.x), cvRound(c.imagePoint.y));
        kept += still;
        hidden += well.at<uchar>(at) != 0;
        if (well.at<uchar>(at) || !near.at<uchar>(at))
        {
            EXPECT_EQ(near.at<uchar>(at) == 0, still) << at;
        }
    }
    EXPECT_EQ(rest.size(), kept);   // they are some of those of the tool alone
    EXPECT_GE(hidden, 20u);

    // The one in front has its outline where it stands before the background, and none where it stands before the other.
    std::vector<ContourPoint> over;
    denseContour()->sample(camera, views[1], both, 2, over);
    const std::vector<ContourPoint> frontAlone = sampled(*denseContour(), camera, window, std::vector<ToolView>(1, front.view));
    EXPECT_LT(over.size(), frontAlone.size());
    EXPECT_GT(over.size(), frontAlone.size() / 2);
}

TEST(SurgTrack_Contour, pointsOutsideTheWindowOrBehindTheCameraAreLeftOut)
{
    const CameraModel camera = endoscope();
    const PosedTool tool(0.1, 0.3, 0.9);
    // The shaft reaches behind the camera.
    double nearestVertex = DBL_MAX;
    const int shaft = tool.model->keypoints()[0].link;
    for (const Point3f& v : tool.model->meshes()[tool.model->links()[shaft].mesh].vertices)
        nearestVertex = std::min(nearestVertex, transformed(tool.view.camera_T_base * tool.view.base_T_link[shaft], Point3d(v)).z);
    ASSERT_LT(nearestVertex, -0.02);

    const Rect windows[] = {Rect(Point(), camera.imageSize()), Rect(200, 150, 300, 260), Rect(0, 0, 40, 40), Rect(300, 280, 1, 1), Rect()};
    for (const Rect& window : windows)
    {
        Rendering rendering;
        if (!window.empty()) draw(camera, window, std::vector<ToolView>(1, tool.view), rendering);
        std::vector<ContourPoint> points(3);
        denseContour()->sample(camera, tool.view, rendering, 1, points);
        for (const ContourPoint& c : points)
        {
            EXPECT_TRUE(c.imagePoint.x >= window.x && c.imagePoint.y >= window.y && c.imagePoint.x <= window.x + window.width - 1
                        && c.imagePoint.y <= window.y + window.height - 1) << window;
            EXPECT_GT(transformed(tool.view.camera_T_base * tool.view.base_T_link[c.link], c.linkPoint).z, 0);
        }
        if (window.width >= 300)
        {
            EXPECT_GE(points.size(), 100u);
        }
        if (window.width <= 1)
        {
            EXPECT_TRUE(points.empty());
        }
    }

    // A tool that is behind the camera, or beside its view, has none.
    const PosedTool away[] = {PosedTool(-0.1), PosedTool(0.1, 0.3, 1.1, 0.35, Point2d(0.5, 0))};
    for (const PosedTool& t : away) EXPECT_TRUE(denseContour()->sampleTool(camera, t.view.camera_T_base, t.joints).empty());
}

TEST(SurgTrack_Contour, aToolAloneIsSampledAsInADrawingOfIt)
{
    const CameraModel camera = endoscope();
    const PosedTool tool(0.1);
    const std::vector<ContourPoint> points = sampled(camera, tool), same = denseContour()->sampleTool(camera, tool.view.camera_T_base, tool.joints);
    ASSERT_EQ(points.size(), same.size());
    for (size_t i = 0; i < points.size(); i++) EXPECT_EQ(points[i].imagePoint, same[i].imagePoint);
}

TEST(SurgTrack_Contour, spacingAndNumberAreThoseAskedFor)
{
    const CameraModel camera = endoscope();
    const PosedTool tool(0.1);
    const std::vector<ContourPoint> all = sampled(camera, tool);
    const double spacings[] = {1.5, 6, 12};
    for (double spacing : spacings)
    {
        ToolContour::Params params = dense();
        params.spacing = spacing;
        const std::vector<ContourPoint> points = ToolContour::create(tool.model, params)->sampleTool(camera, tool.view.camera_T_base, tool.joints);
        // Which short edges of hidden or hardly visible facets are met is chance.
        EXPECT_NEAR(1, points.size() * spacing / (all.size() * 3.), 0.15) << spacing;
    }
    // On the straight shaft, the distance is the spacing; the lens stretches it by a few per cent.
    Offsets distances;
    for (size_t i = 1; i < all.size(); i++)
        if (cv::norm(all[i].linkDirection - all[i - 1].linkDirection) < 1e-9) distances.add(cv::norm(all[i].imagePoint - all[i - 1].imagePoint));
    ASSERT_GE(distances.all.size(), 50u);
    EXPECT_NEAR(3, distances.within(0.5), 0.3);

    const int numbers[] = {1, 50, 100, int(all.size()), 100000};
    for (int n : numbers)
    {
        ToolContour::Params params = dense();
        params.maxPoints = n;
        const std::vector<ContourPoint> points = ToolContour::create(tool.model, params)->sampleTool(camera, tool.view.camera_T_base, tool.joints);
        ASSERT_EQ(std::min(size_t(n), all.size()), points.size());
        // Thinned out evenly: of the n-th part of all points there is one of each.
        size_t at = 0;
        for (size_t i = 0; i < points.size(); i++)
        {
            const size_t before = at;
            while (at < all.size() && all[at].imagePoint != points[i].imagePoint) at++;
            ASSERT_LT(at, all.size());
            if (i > 0)
            {
                EXPECT_LE(at - before, all.size() / n + 1);
            }
        }
    }
}

TEST(SurgTrack_Contour, placedPointsAreTheOutlineOfANearbyView)
{
    const CameraModel camera = endoscope();
    RNG rng(21);
    Offsets offsets;
    int dropped = 0;
    const std::vector<PosedTool> tools = severalViews();
    for (size_t view = 0; view < 2; view++)
    {
        const PosedTool& tool = tools[view];
        std::vector<ContourPoint> points = sampled(camera, tool);
        const size_t before = points.size();
        // 0.05 rad about the tool, and 6 pixels of an image 720 wide.
        PosedTool moved = tool;
        const Matx33d R = rotationMatrix(randomDirection(rng) * 0.05);
        const Point3d t(tool.camera_T_tool(0, 3), tool.camera_T_tool(1, 3), tool.camera_T_tool(2, 3));
        const Vec3d side = randomDirection(rng);
        const Point3d shift = Point3d(side[0], side[1], 0) * (6. / 900 * t.z / cv::norm(Point2d(side[0], side[1])));
        moved.camera_T_tool = rigid(R, t + shift - R * t) * tool.camera_T_tool;
        moved.place();
        placeContour(camera, moved.view, points);
        dropped += int(before - points.size());
        const Silhouette truth(camera, moved.view, points);
        for (const ContourPoint& c : points) offsets.add(truth.offset(c));

        // Back again: what it was, but for rounding.
        const std::vector<ContourPoint> original = sampled(camera, tool);
        placeContour(camera, tool.view, points);
        for (size_t i = 0; i < points.size() && dropped == 0; i++)
        {
            EXPECT_LT(cv::norm(points[i].imagePoint - original[i].imagePoint), 2e-3);   // as in pointsAreWhereTheCameraSeesThemOnTheirLink
            EXPECT_LT(cv::norm(points[i].normal - original[i].normal), 1e-3);   // the same over short edges
        }
    }
    const double most = offsets.within(0.9), median = offsets.within(0.5);
    EXPECT_EQ(0, dropped);
    EXPECT_LT(median, 0.05);   // [pixel], of straight edges that stay the outline's. Measured: 0.016
    EXPECT_LT(most, 0.2);      // round parts, whose outline is another edge of the mesh now: 4 mm (1 - cos(0.05)) are 0.05, and facets as much. Measured: 0.14
    EXPECT_LT(std::abs(offsets.mean), 0.1);   // those lie inside. Measured: 0.047
    EXPECT_LE(offsets.missing, int(offsets.all.size() / 50));   // where another part now hides the edge
}

TEST(SurgTrack_Contour, placedPointsThatAreNotInFrontAreDropped)
{
    const CameraModel camera = endoscope();
    const PosedTool tool(0.1);
    std::vector<ContourPoint> points = sampled(camera, tool);
    placeContour(camera, PosedTool(-0.5).view, points);
    EXPECT_TRUE(points.empty());
    placeContour(camera, tool.view, points);
    EXPECT_TRUE(points.empty());
}

TEST(SurgTrack_Contour, creasesAreSharpEdgesInsideTheOutline)
{
    const CameraModel camera = endoscope();
    const PosedTool tool(0.1, 0.3, 1.1, 0.35);
    const Silhouette truth(camera, tool.view, sampled(camera, tool));
    size_t before = 0;
    const double angles[] = {0, 1.2, 0.6};   // [rad]
    for (double angle : angles)
    {
        ToolContour::Params params = dense();
        params.creaseAngle = angle;
        size_t creases = 0, outline = 0, inside = 0;
        for (const ContourPoint& c : ToolContour::create(tool.model, params)->sampleTool(camera, tool.view.camera_T_base, tool.joints))
        {
            (c.crease ? creases : outline)++;
            if (!c.crease) continue;
            const Silhouette::Line line = truth.lineAlong(c);
            inside += truth.covers(line, -0.3) && truth.covers(line, 0.3);
        }
        EXPECT_GE(outline, 60u);
        EXPECT_GE(inside, creases * 0.98);   // but for ends at the outline
        if (angle == 0)
        {
            EXPECT_EQ(0u, creases);
        }
        else
        {
            EXPECT_GT(creases, before + 10);   // more, the blunter they may be
        }
        before = creases;
    }
}

TEST(SurgTrack_Contour, rejectsBadInputNamingTheArgument)
{
    const CameraModel camera = endoscope();
    const PosedTool tool(0.1);
    Rendering rendering;
    draw(camera, Rect(0, 0, 100, 80), std::vector<ToolView>(1, tool.view), rendering);
    std::vector<ContourPoint> points;
    ToolView view = tool.view;
    view.base_T_link.pop_back();
    EXPECT_ERROR(denseContour()->sample(camera, view, rendering, 1, points), "view");
    EXPECT_ERROR(denseContour()->sample(camera, tool.view, rendering, 0, points), "id");
    EXPECT_ERROR(denseContour()->sample(camera, tool.view, rendering, 256, points), "id");
    Rendering wrong = rendering;
    wrong.ids = Mat::zeros(80, 99, CV_8U);
    EXPECT_ERROR(denseContour()->sample(camera, tool.view, wrong, 1, points), "ids");
    wrong = rendering;
    wrong.depth = Mat::zeros(80, 100, CV_64F);
    EXPECT_ERROR(denseContour()->sample(camera, tool.view, wrong, 1, points), "depth");
    EXPECT_THROW(denseContour()->sampleTool(camera, tool.view.camera_T_base, std::vector<double>(3)), cv::Exception);
    EXPECT_THROW(denseContour()->sampleTool(camera, tool.view.camera_T_base, std::vector<double>(7, NOT_A_NUMBER)), cv::Exception);
    points.assign(1, ContourPoint());
    EXPECT_ERROR(placeContour(camera, tool.view, points), "link");
    points[0].link = int(tool.model->links().size());
    EXPECT_ERROR(placeContour(camera, tool.view, points), "link");

    EXPECT_THROW(ToolContour::create(Ptr<ToolModel>()), cv::Exception);
    const double values[] = {-1, NOT_A_NUMBER};
    for (double value : values)
    {
        ToolContour::Params params;
        params.spacing = value;
        EXPECT_ERROR(ToolContour::create(tool.model, params), "spacing");
        params = ToolContour::Params();
        params.creaseAngle = value;
        EXPECT_ERROR(ToolContour::create(tool.model, params), "creaseAngle");
    }
    ToolContour::Params params;
    params.spacing = 0;
    EXPECT_ERROR(ToolContour::create(tool.model, params), "spacing");
    params.spacing = 3;
    params.maxPoints = 0;
    EXPECT_ERROR(ToolContour::create(tool.model, params), "maxPoints");
}

}} // namespace
