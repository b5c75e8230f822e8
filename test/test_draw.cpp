// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_common.hpp"

namespace opencv_test { namespace {

DrawnTool drawn(const PosedTool& tool, const Scalar& color = Scalar(0, 255, 0), double opacity = 0.4)
{
    return DrawnTool(tool.model, tool.joints, tool.view.camera_T_base, color, opacity);
}

Mat idsOf(const PosedTool& tool, const CameraModel& camera)
{
    Mat depth, ids, shading;
    MeshRenderer::createSoftware()->renderTool(tool.model, tool.joints, tool.view.camera_T_base, camera, depth, ids, shading);
    return ids;
}

Mat differences(const Mat& a, const Mat& b)
{
    Mat difference, channels;
    absdiff(a, b, difference);
    transform(difference, channels, Matx13f(1, 1, 1));
    return channels > 0;
}

Vec3b colorAt(const Mat& image, const Point2d& p) { return image.at<Vec3b>(cvRound(p.y), cvRound(p.x)); }

Vec3b bytes(const Scalar& color) { return Vec3b(uchar(color[0]), uchar(color[1]), uchar(color[2])); }

PartMatch matchOf(int part, const Point2d& predicted, const Point2d& at, double similarity = 0.8)
{
    PartMatch m;
    m.part = part;
    m.predictedPoint = predicted;
    m.imagePoint = at;
    m.similarity = similarity;
    return m;
}

TEST(SurgTrack_Draw, theOverlayTouchesOnlyTheToolsPixelsAndAllOfThem)
{
    for (int distorted = 0; distorted < 2; distorted++)
    {
        const CameraModel camera = endoscope(distorted != 0);
        const PosedTool tool;
        const Mat before = textured(camera.imageSize(), 3, 1), ids = idsOf(tool, camera);
        Mat image = before.clone();
        drawTool(image, camera, tool.model, tool.joints, tool.view.camera_T_base, Scalar(255, 0, 255));
        const Mat changed = differences(image, before);
        EXPECT_EQ(0, countNonZero(changed & (ids == 0)));
        EXPECT_GT(countNonZero(changed & (ids > 0)), 0.98 * countNonZero(ids));   // a pixel may have the colour it gets already
    }
}

TEST(SurgTrack_Draw, theNearerToolHidesTheOther)
{
    const CameraModel camera = endoscope();
    const PosedTool near(0.09, 0.3), far(0.14, 0.1);
    const Mat idsNear = idsOf(near, camera), idsFar = idsOf(far, camera), both = (idsNear > 0) & (idsFar > 0);
    ASSERT_GT(countNonZero(both), 500);
    Mat images[2];
    for (int order = 0; order < 2; order++)
    {
        std::vector<DrawnTool> tools(1, drawn(near, Scalar(0, 0, 255), 1));
        tools.insert(order ? tools.end() : tools.begin(), drawn(far, Scalar(255, 0, 0), 1));
        images[order] = Mat::zeros(camera.imageSize(), CV_8UC3);
        drawTools(images[order], camera, tools);
    }
    EXPECT_EQ(0, countNonZero(differences(images[0], images[1])));
    // At the jaws, whose depth differs by 50 mm: blue is the far one's.
    const Point2d tip = camera.project(near.keypoint(near.model->keypoints().size() - 1));
    const Rect about = Rect(cvRound(tip.x) - 40, cvRound(tip.y) - 40, 81, 81) & Rect(Point(), camera.imageSize());
    std::vector<Mat> planes;
    split(images[0], planes);
    EXPECT_GT(countNonZero(idsNear(about)), 100);
    EXPECT_EQ(0, countNonZero(planes[0](about) & (idsNear(about) > 0)));
}

TEST(SurgTrack_Draw, opacityGoesFromTheOutlineAloneToNothingOfTheImage)
{
    const CameraModel camera = endoscope();
    const PosedTool tool;
    const Mat one = textured(camera.imageSize(), 3, 1), other = textured(camera.imageSize(), 3, 2), ids = idsOf(tool, camera);
    const Ptr<MeshRenderer> renderer = MeshRenderer::createSoftware();
    Mat image = one.clone(), image2 = other.clone();
    drawTools(image, camera, std::vector<DrawnTool>(1, drawn(tool, Scalar(0, 255, 0), 0)), renderer, 0);
    EXPECT_EQ(0, countNonZero(differences(image, one)));
    drawTools(image, camera, std::vector<DrawnTool>(1, drawn(tool, Scalar(0, 255, 0), 1)), renderer, 0);
    drawTools(image2, camera, std::vector<DrawnTool>(1, drawn(tool, Scalar(0, 255, 0), 1)), renderer, 0);
    EXPECT_EQ(0, countNonZero(differences(image, image2) & (ids > 0)));
    // The outline: of its colour, inside of the tool, as thick as asked for.
    image = one.clone();
    drawTools(image, camera, std::vector<DrawnTool>(1, drawn(tool, Scalar(1, 254, 3), 0)), renderer, 3);
    Mat outline = differences(image, one), inner;
    erode(ids, inner, getStructuringElement(MORPH_RECT, Size(11, 11)));   // 5 pixels: the outline's 3 along a diagonal
    EXPECT_GT(countNonZero(outline), 1000);
    EXPECT_EQ(0, countNonZero(outline & (inner > 0)));
    for (int y = 0; y < image.rows; y++)
        for (int x = 0; x < image.cols; x++)
            if (outline.at<uchar>(y, x)) ASSERT_EQ(Vec3b(1, 254, 3), image.at<Vec3b>(y, x));
}

TEST(SurgTrack_Draw, aToolBehindTheCameraAndNoToolLeaveTheImage)
{
    const CameraModel camera = endoscope();
    const PosedTool behind(-0.6, 0, 0);
    const Mat before = textured(camera.imageSize(), 3, 1);
    Mat image = before.clone();
    drawTools(image, camera, std::vector<DrawnTool>(1, drawn(behind)));
    drawTools(image, camera, std::vector<DrawnTool>());
    EXPECT_EQ(0, countNonZero(differences(image, before)));
}

ToolEstimate estimateOf(const PosedTool& tool, int state)
{
    ToolEstimate e;
    e.state = state;
    e.camera_T_tool = tool.camera_T_tool;
    e.joints = tool.joints;
    e.similarity = 0.8;
    e.matches.push_back(matchOf(0, Point2d(650, 500), Point2d(650, 500)));
    return e;
}

TEST(SurgTrack_Draw, anEstimateIsTheToolAtItsJointsAndPoseItsMatchesAndAText)
{
    const CameraModel camera = endoscope();
    const PosedTool tool;
    const Mat before = textured(camera.imageSize(), 3, 1);
    Mat image = before.clone(), expected = before.clone();
    const ToolEstimate e = estimateOf(tool, STATE_TRACKING);
    drawEstimate(image, camera, tool.model, e, "PSM1");
    drawTools(expected, camera, std::vector<DrawnTool>(1, drawn(tool)));
    drawMatches(expected, e.matches, true);
    const Rect text(0, 0, 400, 30);
    EXPECT_GT(countNonZero(differences(image, expected)(text)), 500) << "the text";
    image(text).copyTo(expected(text));
    EXPECT_EQ(0, countNonZero(differences(image, expected)));
    EXPECT_LT(cv::norm(DrawnTool(tool.model, e).camera_T_base - tool.view.camera_T_base, NORM_INF), 1e-12);   // rounding
}

TEST(SurgTrack_Draw, theStateOfAnEstimateIsToldByColour)
{
    const CameraModel camera = endoscope();
    const PosedTool tool;
    const int states[] = {STATE_INITIALIZING, STATE_TRACKING, STATE_COASTING, STATE_LOST};
    for (int i = 0; i < 4; i++)
    {
        const bool known = i == 1 || i == 2;
        const ToolEstimate e = estimateOf(tool, states[i]);
        EXPECT_EQ(known ? Scalar(0, 255, 0) : Scalar::all(150), DrawnTool(tool.model, e).color);
        Mat image = Mat::zeros(camera.imageSize(), CV_8UC3), alone = image.clone();
        drawEstimate(image, camera, tool.model, e);
        drawEvidence(alone, e, "");
        EXPECT_EQ(known, countNonZero(differences(image, alone)) > 1000) << "the tool is drawn where it is known";
        const Scalar sum = cv::sum(alone(Rect(0, 0, 400, 30)));
        EXPECT_EQ(known, sum[1] > sum[2]) << "green, else red";
    }
    Mat second = Mat::zeros(camera.imageSize(), CV_8UC3);
    drawEvidence(second, estimateOf(tool, STATE_LOST), "PSM2", 1);
    EXPECT_EQ(0, countNonZero(second(Rect(0, 0, 720, 24)).clone().reshape(1)));
    EXPECT_GT(countNonZero(second(Rect(0, 26, 400, 22)).clone().reshape(1)), 500);
}

TEST(SurgTrack_Draw, rejectsWhatCannotBeDrawn)
{
    const CameraModel camera = endoscope();
    const PosedTool tool;
    Mat image = Mat::zeros(camera.imageSize(), CV_8UC3), grey(camera.imageSize(), CV_8UC1), small(100, 100, CV_8UC3);
    std::vector<DrawnTool> tools(1, drawn(tool));
    EXPECT_ERROR(drawTools(grey, camera, tools), "BGR");
    EXPECT_ERROR(drawTools(small, camera, tools), "100 x 100");
    tools[0].opacity = 1.5;
    EXPECT_ERROR(drawTools(image, camera, tools), "opacity");
    tools[0] = drawn(tool);
    tools[0].camera_T_base(0, 0) += 1;
    EXPECT_ERROR(drawTools(image, camera, tools), "tools[0].camera_T_base");
    tools[0] = DrawnTool();
    EXPECT_ERROR(drawTools(image, camera, tools), "tools[0].model");
    ToolEstimate e = estimateOf(tool, STATE_TRACKING);
    EXPECT_ERROR(drawEstimate(small, camera, tool.model, e), "100 x 100");
    EXPECT_ERROR(drawEstimate(image, camera, Ptr<ToolModel>(), e), "model");
    EXPECT_ERROR(drawEvidence(image, e, "PSM1", -1), "row");
    e.joints.pop_back();
    EXPECT_ERROR(drawEstimate(image, camera, tool.model, e), "joints");
    EXPECT_EQ(0, countNonZero(image.reshape(1)));
    EXPECT_THROW(orientationColor(8), cv::Exception);
    EXPECT_THROW(partColor(-1), cv::Exception);
    EXPECT_THROW(drawOrientations(image, small), cv::Exception);
    EXPECT_THROW(drawOrientationLegend(image, Point(50, 50), 0), cv::Exception);
    EXPECT_THROW(drawTemplate(image, PartTemplate(), Point(), 0), cv::Exception);
    EXPECT_THROW(drawSimilarity(Mat(3, 3, CV_16UC1, Scalar(0)), PartTemplate(), image), cv::Exception);
    EXPECT_THROW(drawContour(image, std::vector<ContourPoint>(), 0), cv::Exception);
    EXPECT_THROW(drawMatches(grey, std::vector<PartMatch>()), cv::Exception);
    EXPECT_THROW(drawGeometricContext(image, std::vector<PartMatch>(), std::vector<PartMatch>(), std::vector<PartMatch>(1), true), cv::Exception);
}

TEST(SurgTrack_Draw, theLegendHasTheColoursOfADiscsEdge)
{
    // The gradient of a bright disc points to its centre: the orientation at each angle is that angle, modulo 180 degrees.
    const Point centre(150, 150);
    Mat disc(301, 301, CV_8UC1, Scalar(30)), orientations, picture(disc.size(), CV_8UC3, Scalar::all(0)), legend = picture.clone();
    circle(disc, centre, 100, Scalar(220), FILLED);
    quantizeOrientations(disc, orientations);
    drawOrientations(picture, orientations);
    drawOrientationLegend(legend, centre, 130);
    int same = 0, all = 0;
    for (int degrees = 0; degrees < 360; degrees++)
    {
        const double inBin = std::fmod(degrees + 11.25, 22.5);
        if (inBin < 4 || inBin > 18.5) continue;   // pixels of a circle are off by some degrees
        const Point2d p = Point2d(centre) + 100 * Point2d(std::cos(degrees * CV_PI / 180), std::sin(degrees * CV_PI / 180));
        if (colorAt(picture, p) == Vec3b(0, 0, 0)) continue;
        all++;
        same += colorAt(picture, p) == colorAt(legend, p);
    }
    EXPECT_GT(all, 150);           // of about 230: the vote drops some pixels
    EXPECT_GT(same, 0.97 * all);   // where the vote took a neighbour's bin
}

TEST(SurgTrack_Draw, orientationsHaveTheirColoursAndOtherPixelsStay)
{
    Mat image(1, 10, CV_8UC3, Scalar(7, 8, 9)), orientations(1, 10, CV_8UC1, Scalar(0));
    std::set<int> colors;
    for (int bin = 0; bin < 8; bin++)
    {
        orientations.at<uchar>(bin) = uchar(1 << bin);
        const Vec3b c = bytes(orientationColor(bin));
        colors.insert(c[0] + 256 * c[1] + 65536 * c[2]);
    }
    orientations.at<uchar>(8) = 3;
    drawOrientations(image, orientations);
    EXPECT_EQ(size_t(8), colors.size());
    for (int bin = 0; bin < 8; bin++) EXPECT_EQ(bytes(orientationColor(bin)), image.at<Vec3b>(bin));
    for (int c = 0; c < 3; c++)
        EXPECT_NEAR((orientationColor(0)[c] + orientationColor(1)[c]) / 2, image.at<Vec3b>(8)[c], 1);   // rounding
    EXPECT_EQ(Vec3b(7, 8, 9), image.at<Vec3b>(9));
}

TEST(SurgTrack_Draw, templatesFeaturesAreThoseOfTheVirtualView)
{
    const CameraModel camera = endoscope();
    const PosedTool tool;
    const Ptr<PartTemplateRenderer> renderer = PartTemplateRenderer::create();
    renderer->addTool(tool.model);
    const std::vector<PartTemplate> templates = renderer->renderTool(camera, tool.view.camera_T_base, tool.joints);
    ASSERT_GE(templates.size(), size_t(5));
    // The virtual view made by drawTools(), as pictures show it.
    Mat view(camera.imageSize(), CV_8UC3, Scalar::all(80)), orientations;
    drawTools(view, camera, std::vector<DrawnTool>(1, drawn(tool, Scalar::all(255), 1)), Ptr<MeshRenderer>(), 0);
    quantizeOrientations(view, orientations, PartTemplateRenderer::Params().magnitudeThreshold);
    Mat expected = Mat::zeros(view.size(), CV_8UC3);
    drawOrientations(expected, orientations);
    int same = 0, all = 0;
    for (size_t i = 0; i < templates.size(); i++)
    {
        Mat picture = Mat::zeros(view.size(), CV_8UC3);
        drawTemplate(picture, templates[i], templates[i].anchor);
        EXPECT_EQ(templates[i].features.size(), size_t(countNonZero(differences(picture, Mat::zeros(view.size(), CV_8UC3))))) << i;
        for (const TemplateFeature& f : templates[i].features)
        {
            const Point p = templates[i].anchor + Point(f.x, f.y);
            EXPECT_EQ(bytes(orientationColor(f.bin)), picture.at<Vec3b>(p));
            same += picture.at<Vec3b>(p) == expected.at<Vec3b>(p);
            all++;
        }
        // Larger ones cover a square a feature, and none is lost outside of the picture.
        Mat large = Mat::zeros(50, 50, CV_8UC3);
        drawTemplate(large, templates[i], Point(25, 25), 3);
    }
    EXPECT_GT(same, 0.99 * all);   // two roundings of the same shades
}

TEST(SurgTrack_Draw, similarityIsBrightestWhereEverythingAgrees)
{
    PartTemplate t;
    t.features.resize(100);
    const Mat similarity = (Mat_<ushort>(1, 3) << 0, 200, 400);   // 4 a feature is all
    Mat picture;
    drawSimilarity(similarity, t, picture);
    ASSERT_EQ(similarity.size(), picture.size());
    ASSERT_EQ(CV_8UC3, picture.type());
    double brightness[3];
    for (int i = 0; i < 3; i++) brightness[i] = sum(picture.col(i)).dot(Scalar::all(1));
    EXPECT_LT(brightness[0], 30);
    EXPECT_LT(brightness[0], brightness[1]);
    EXPECT_LT(brightness[1], brightness[2]);
}

TEST(SurgTrack_Draw, bothGridsMarkTheMatchesWhereTheyBelong)
{
    std::vector<PartMatch> matches, inliers;
    const Point2d shift(12, -7);
    for (int i = 0; i < 6; i++)
    {
        const Point2d p(150 + 60 * (i % 3), 120 + 70 * (i / 3));
        matches.push_back(matchOf(i, p, p + shift));
    }
    const Ptr<GeometricContextVerifier> verifier = GeometricContextVerifier::create();
    ASSERT_TRUE(verifier->verify(matches, inliers));
    ASSERT_EQ(size_t(6), inliers.size());
    matches.push_back(matchOf(2, matches[2].predictedPoint, Point2d(400, 300)));   // another place for part 2
    for (int predicted = 0; predicted < 2; predicted++)
    {
        Mat image(400, 500, CV_8UC3, Scalar::all(50));
        drawGeometricContext(image, matches, inliers, verifier->sample(), predicted != 0);
        for (size_t i = 0; i < inliers.size(); i++)
            EXPECT_EQ(bytes(partColor(inliers[i].part)), colorAt(image, predicted ? inliers[i].predictedPoint : inliers[i].imagePoint)) << i;
        if (!predicted) EXPECT_EQ(Vec3b(50, 50, 50), colorAt(image, matches[6].imagePoint));   // not an inlier: a ring
        Mat grid = Mat(image != Scalar::all(50)).reshape(1);
        EXPECT_GT(countNonZero(grid), 3 * 2000);   // rays and rings
    }
    Mat image(400, 500, CV_8UC3, Scalar::all(50));
    drawMatches(image, inliers, true);
    EXPECT_EQ(bytes(partColor(3)), colorAt(image, matches[3].imagePoint));
    // Points anywhere do no harm.
    const std::vector<PartMatch> wild(1, matchOf(0, Point2d(-1e9, 4e7), Point2d(1e12, -1e12)));
    drawMatches(image, wild);
    drawGeometricContext(image, wild, wild, std::vector<PartMatch>(), false);
}

TEST(SurgTrack_Draw, contourPointsGoFromGreenToRed)
{
    std::vector<ContourPoint> points(3);
    for (int i = 0; i < 3; i++)
    {
        points[i].imagePoint = Point2d(30 + 40 * i, 50);
        points[i].normal = Point2d(0, 1);
        points[i].found = i < 2;
        points[i].offset = i == 1 ? 4 : 0;
    }
    Mat image = Mat::zeros(100, 150, CV_8UC3);
    drawContour(image, points, 3, 5);
    EXPECT_EQ(Vec3b(0, 255, 0), colorAt(image, points[0].imagePoint));
    EXPECT_EQ(Vec3b(0, 0, 255), colorAt(image, points[1].imagePoint));
    EXPECT_EQ(Vec3b(0, 0, 255), colorAt(image, points[1].imagePoint + Point2d(0, 15)));   // 4 pixels off, drawn five times as long
    EXPECT_EQ(Vec3b(0, 0, 0), colorAt(image, points[0].imagePoint + Point2d(0, 15)));
    const Vec3b none = colorAt(image, points[2].imagePoint);
    EXPECT_TRUE(none[0] == none[1] && none[1] == none[2] && none[0] > 0);
}

// ---- the scene from outside

Ptr<SceneView> sceneView(const CameraModel& camera, Size size)
{
    try
    {
        return SceneView::create(camera, size);
    }
    catch (const cv::Exception& e)
    {
        if (e.code != Error::StsNotImplemented) throw;
        throw SkipTestException(e.err);
    }
}

int near(const Mat& picture, const Scalar& color, double distance)
{
    Mat mask;
    inRange(picture, color - Scalar::all(distance), color + Scalar::all(distance), mask);
    return countNonZero(mask);
}

TEST(SurgTrack_SceneView, seenFromTheCameraTheToolIsWhereTheCameraSeesIt)
{
    const CameraModel camera(Matx33d(600, 0, 199.5, 0, 600, 149.5, 0, 0, 1), noArray(), Size(400, 300));
    const PosedTool tool;
    const Ptr<SceneView> scene = sceneView(camera, camera.imageSize());
    const Mat black = Mat::zeros(camera.imageSize(), CV_8UC3);
    Mat empty, picture;
    // A little behind the camera, for its own axes to be in front; VTK's default angle of view is 30 degrees.
    scene->setViewpoint(Point3d(0, 0, -0.02), Point3d(0, 0, 1));
    scene->draw(black, std::vector<DrawnTool>(), std::vector<Mat>(), empty);
    scene->draw(black, std::vector<DrawnTool>(1, drawn(tool, Scalar(0, 0, 255), 1)), std::vector<Mat>(), picture);
    ASSERT_EQ(camera.imageSize(), picture.size());
    ASSERT_EQ(CV_8UC3, picture.type());
    const double f = 150 / std::tan(15 * CV_PI / 180);
    const CameraModel seen(Matx33d(f, 0, 199.5, 0, f, 149.5, 0, 0, 1), noArray(), camera.imageSize());
    PosedTool moved = tool;
    moved.view.camera_T_base(2, 3) += 0.02;
    const Mat expected = idsOf(moved, seen) > 0;
    std::vector<Mat> planes;
    split(picture, planes);
    const Mat red = differences(picture, empty) & (planes[2] > 40) & (planes[0] < 40) & (planes[1] < 40);
    Mat wide, narrow;
    const Mat square = getStructuringElement(MORPH_RECT, Size(5, 5));
    dilate(expected, wide, square);   // 2 pixels: OpenGL's half a pixel, and smoothing
    erode(expected, narrow, square);
    EXPECT_GT(countNonZero(narrow), 2000);
    EXPECT_GT(countNonZero(red & narrow), 0.95 * countNonZero(narrow));   // highlights are white
    EXPECT_LE(countNonZero(red & ~wide), 5);   // smoothed corners
}

TEST(SurgTrack_SceneView, showsImagePathsAndWhatIsSeenThrough)
{
    const CameraModel camera = endoscope();
    const Ptr<SceneView> scene = sceneView(camera, Size(640, 480));
    const PosedTool tool;
    const Mat yellow(camera.imageSize(), CV_8UC3, Scalar(0, 255, 255));
    Mat path;
    for (int i = 0; i < 20; i++) path.push_back(Mat(Matx13d(-0.02 + 0.002 * i, 0.01, 0.08)));
    Mat bare, full, without, ghost, again;
    scene->draw(noArray(), std::vector<DrawnTool>(1, drawn(tool, Scalar(255, 0, 255), 1)), std::vector<Mat>(), bare);
    scene->draw(yellow, std::vector<DrawnTool>(1, drawn(tool, Scalar(255, 0, 255), 1)), std::vector<Mat>(), without);
    scene->draw(yellow, std::vector<DrawnTool>(1, drawn(tool, Scalar(255, 0, 255), 1)), std::vector<Mat>(1, path), full);
    scene->draw(yellow, std::vector<DrawnTool>(1, drawn(tool, Scalar(255, 0, 255), 0.3)), std::vector<Mat>(1, path), ghost);
    scene->draw(yellow, std::vector<DrawnTool>(1, drawn(tool, Scalar(255, 0, 255), 1)), std::vector<Mat>(1, path), again);
    EXPECT_EQ(0, near(bare, Scalar(0, 255, 255), 20));
    EXPECT_GT(near(without, Scalar(0, 255, 255), 20), 20000);   // the image covers a good part of the view
    EXPECT_GT(countNonZero(differences(full, without)), 200);   // the path
    EXPECT_GT(countNonZero(differences(ghost, full)), 2000);    // the image through the tool
    EXPECT_EQ(0, countNonZero(differences(again, full)));
}

TEST(SurgTrack_SceneView, rejectsWhatCannotBeShown)
{
    const CameraModel camera = endoscope();
    const Ptr<SceneView> scene = sceneView(camera, Size(64, 48));
    const PosedTool tool;
    Mat picture;
    const std::vector<DrawnTool> none;
    EXPECT_ERROR(scene->draw(Mat(10, 10, CV_8UC3), none, std::vector<Mat>(), picture), "size");
    EXPECT_ERROR(scene->draw(noArray(), none, std::vector<Mat>(1), picture), "paths");
    EXPECT_ERROR(scene->draw(noArray(), std::vector<DrawnTool>(1), std::vector<Mat>(), picture), "tools[0].model");
    EXPECT_ERROR(scene->draw(noArray(), std::vector<DrawnTool>(1, drawn(tool)), std::vector<Mat>(1, Mat::zeros(3, 2, CV_64F)), picture), "paths");
    EXPECT_ERROR(scene->setViewpoint(Point3d(1, 1, 1), Point3d(1, 1, 1)), "different");
    EXPECT_ERROR(scene->show(), "window");
    EXPECT_THROW(SceneView::create(camera, Size(0, 10)), cv::Exception);
    EXPECT_THROW(SceneView::create(CameraModel(), Size(10, 10)), cv::Exception);
    if (!std::getenv("DISPLAY")) EXPECT_ERROR(SceneView::create(camera, Size(64, 48), true), "display");
}

TEST(SurgTrack_SceneView, aWindowShowsAndEndsByItself)
{
    if (!std::getenv("DISPLAY")) throw SkipTestException("there is no display");
    const CameraModel camera = endoscope();
    const Ptr<SceneView> scene = SceneView::create(camera, Size(320, 240), true);
    const PosedTool tool;
    Mat picture;
    scene->draw(textured(camera.imageSize(), 3, 1), std::vector<DrawnTool>(1, drawn(tool)), std::vector<Mat>(), picture);
    EXPECT_EQ(Size(320, 240), picture.size());
    scene->show(0.3);
    scene->draw(noArray(), std::vector<DrawnTool>(1, drawn(tool)), std::vector<Mat>(), picture);   // it can be drawn on afterwards
    EXPECT_GT(near(picture, Scalar(0, 100, 0), 90), 100);
}

}} // namespace
