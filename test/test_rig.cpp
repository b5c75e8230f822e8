// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_tracking.hpp"

#include <fstream>
#include "opencv2/core/utils/filesystem.hpp"
#include "opencv2/imgcodecs.hpp"
#include "../samples/support/frame_reader.hpp"
#include "../samples/support/tools.hpp"

// How theatres record: both eyes in one file, fields, images that do not show the scene everywhere.

namespace opencv_test { namespace {

using cv::utils::fs::join;

String contents(const String& filename)
{
    std::ifstream file(filename.c_str());
    return String(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
}

void put(const String& filename, const String& text) { std::ofstream(filename.c_str()) << text; }

String replaced(String text, const String& from, const String& to)
{
    const size_t at = text.find(from);
    CV_Assert(at != String::npos);
    return text.replace(at, from.size(), to);
}

// A written sequence of two eyes, and the same images in other files.
class SurgTrack_Rig : public testing::Test
{
protected:
    static const int FRAMES = 8;

    void SetUp() CV_OVERRIDE
    {
        folder = cv::tempfile("");
        SyntheticScene::Params p = scene(2);
        p.stereo = true;
        p.frames = FRAMES;
        SyntheticScene::create(needleDriver(), p)->write(folder);
        description = contents(join(folder, "sequence.yaml"));
        const Ptr<Sequence> s = Sequence::load(folder);
        for (int eye = 0; eye < 2; eye++)
        {
            VideoCapture video(eye ? s->rightVideo() : s->leftVideo());
            for (Mat image; video.read(image);) images[eye].push_back(image.clone());
        }
        if (images[0].empty()) throw SkipTestException("this OpenCV cannot read the video");
        ASSERT_EQ(size_t(FRAMES), images[1].size());
    }
    void TearDown() CV_OVERRIDE { cv::utils::fs::remove_all(folder); }

    // Both eyes in one video, of images without loss.
    void putTogether(const String& layout)
    {
        for (int i = 0; i < FRAMES; i++)
        {
            Mat both;
            if (layout == "top_bottom") vconcat(images[0][i], images[1][i], both);
            else hconcat(images[0][i], images[1][i], both);
            imwrite(join(folder, format("both%03d.png", i)), both);
        }
        describe("layout: \"" + layout + "\"\n");
    }
    void describe(const String& keys)
    {
        const String text = replaced(replaced(description, "left.mp4", "both%03d.png"), "right.mp4", "both%03d.png");
        put(join(folder, "sequence.yaml"), text + keys);
    }

    std::vector<Estimates> tracked(bool stereo) const
    {
        const Ptr<Sequence> s = Sequence::load(folder);
        const std::vector<common::Tool> tools = common::loadTools(*s);
        Ptr<ToolTracker> tracker = ToolTracker::create(s->leftCamera());
        if (stereo) tracker->setRightCamera(s->rightCamera(), s->right_T_left());
        common::setMasks(*s, *tracker, stereo);
        tracker->addTool(tools[0].model, tools[0].info.nominal_T_base);
        common::EyesReader reader(*s, 0, stereo);
        std::vector<Estimates> result;
        Mat left, right;
        for (int frame = 0; reader.read(left, right); frame++)
        {
            Joints joints(1);
            s->jointsAt(0, s->frameTime(frame), joints[0], tools[0].model->coordinateNames());
            result.push_back(Estimates());
            if (stereo) tracker->updateStereo(left, right, s->frameTime(frame), joints, result.back());
            else tracker->update(left, s->frameTime(frame), joints, result.back());
        }
        return result;
    }

    String folder, description;
    std::vector<Mat> images[2];   // an eye's
};

TEST_F(SurgTrack_Rig, bothEyesInOneFileAreTrackedAsInTwo)
{
    for (bool stereo : {false, true})
    {
        put(join(folder, "sequence.yaml"), description);
        const std::vector<Estimates> separate = tracked(stereo);
        ASSERT_EQ(size_t(FRAMES), separate.size());
        EXPECT_EQ(STATE_TRACKING, separate.back()[0].state);
        for (const char* layout : {"side_by_side", "top_bottom", "side-by-side"})
        {
            putTogether(layout);
            const std::vector<Estimates> together = tracked(stereo);
            ASSERT_EQ(separate.size(), together.size());
            for (size_t i = 0; i < separate.size(); i++) EXPECT_TRUE(same(separate[i], together[i])) << layout << ", frame " << i;   // the same pixels
        }
    }
}

TEST_F(SurgTrack_Rig, layoutIsChecked)
{
    describe("layout: \"diagonal\"\n");
    EXPECT_ERROR(Sequence::load(folder), "key layout: expected separate, side_by_side or top_bottom");
    describe("fields: 1\n");
    EXPECT_ERROR(Sequence::load(folder), "key fields: expected none, top_first or bottom_first");
    put(join(folder, "sequence.yaml"), description + "layout: \"top_bottom\"\n");
    EXPECT_ERROR(Sequence::load(folder), "key right.video: expected none, or that of the left eye");

    putTogether("side_by_side");
    const Ptr<Sequence> s = Sequence::load(folder);
    EXPECT_EQ(LAYOUT_SIDE_BY_SIDE, s->layout());
    EXPECT_EQ(Size(1440, 576), s->frameSize());
    EXPECT_EQ(s->leftVideo(), s->rightVideo());
    EXPECT_TRUE(s->isStereo());
    Mat image;
    EXPECT_ERROR(s->eyeImage(images[0][0], image), "has 720x576 pixels, expected 1440x576 by image_width, image_height of an eye, and layout");
    EXPECT_ERROR(s->eyeImage(Mat::zeros(576, 1440, CV_8UC3), image, 2), "eye must be 0 or 1");
    EXPECT_ERROR(s->eyeImage(Mat::zeros(576, 1440, CV_8UC3), image, 0, 1), "imagesPerFrame");
    describe("layout: \"top_bottom\"\n");   // the video is the other one
    EXPECT_ERROR(tracked(false), "expected 720x1152 as in sequence.yaml by image_width, image_height and layout");
    // Cameras may be calibrated anew.
    CameraPair cameras;
    cameras.left = s->leftCamera();
    cameras.right = s->rightCamera();
    cameras.right_T_left = s->right_T_left();
    put(join(folder, "sequence.yaml"), replaced(description, "right.mp4", "left.mp4") + "layout: \"side_by_side\"\n");
    writeSequenceCameras(folder, cameras);
    EXPECT_EQ(LAYOUT_SIDE_BY_SIDE, Sequence::load(folder)->layout());
}

TEST_F(SurgTrack_Rig, masksAreReadAndUsed)
{
    EXPECT_TRUE(Sequence::load(folder)->mask().empty());
    Mat mask(576, 720, CV_8U, Scalar(255));
    mask.colRange(0, 100).setTo(0);
    imwrite(join(folder, "mask.png"), mask);
    imwrite(join(folder, "nothing.png"), Mat::zeros(576, 720, CV_8U));
    imwrite(join(folder, "small.png"), Mat::zeros(57, 72, CV_8U));
    put(join(folder, "sequence.yaml"), description + "mask: \"mask.png\"\n");
    for (int eye = 0; eye < 2; eye++) EXPECT_EQ(0, cvtest::norm(mask, Sequence::load(folder)->mask(eye), NORM_INF));

    // An eye's own one takes its place, and where there is nothing to see nothing is found.
    const String own = replaced(description, "video: \"left.mp4\"", "video: \"left.mp4\"\n   mask: \"nothing.png\"");
    put(join(folder, "sequence.yaml"), own + "mask: \"mask.png\"\n");
    EXPECT_EQ(0, countNonZero(Sequence::load(folder)->mask(0)));
    EXPECT_EQ(0, cvtest::norm(mask, Sequence::load(folder)->mask(1), NORM_INF));
    EXPECT_EQ(STATE_INITIALIZING, tracked(false).back()[0].state);
    CameraPair cameras;
    cameras.left = Sequence::load(folder)->leftCamera();
    writeSequenceCameras(folder, cameras);   // keeps it
    EXPECT_EQ(0, countNonZero(Sequence::load(folder)->mask(0)));

    put(join(folder, "sequence.yaml"), description + "mask: \"small.png\"\n");
    EXPECT_ERROR(Sequence::load(folder)->mask(), "key mask: " + join(folder, "small.png") + " has 72x57 pixels, expected 720x576");
    put(join(folder, "sequence.yaml"), description + "mask: \"none.png\"\n");
    EXPECT_ERROR(Sequence::load(folder)->mask(), "none.png can't be read, expected an image");
}

// Rows of a parity from one image, the others from the next.
Mat woven(const Mat& top, const Mat& bottom)
{
    Mat result = top.clone();
    for (int y = 1; y < top.rows; y += 2) bottom.row(y).copyTo(result.row(y));
    return result;
}

TEST_F(SurgTrack_Rig, fieldsAreTakenApart)
{
    const Mat &a = images[0][0], &b = images[0][5];
    for (const char* order : {"top_first", "bottom-first"})
    {
        const bool topFirst = order == String("top_first");
        put(join(folder, "sequence.yaml"), description + "fields: \"" + order + "\"\n");
        const Ptr<Sequence> s = Sequence::load(folder);
        EXPECT_EQ(2, s->imagesPerFrame());
        EXPECT_NEAR(s->frameTime(3) + 0.5 / s->fps(), s->frameTime(3, 1), 1e-12);   // rounding
        Mat first, second, one, other;
        s->eyeImage(woven(a, b), first, 0, 0);
        s->eyeImage(woven(a, b), second, 0, 1);
        splitFields(topFirst ? a : b, topFirst, one, noArray());
        splitFields(topFirst ? b : a, !topFirst, other, noArray());
        EXPECT_EQ(0, cvtest::norm(first, one, NORM_INF));
        EXPECT_EQ(0, cvtest::norm(second, other, NORM_INF));
    }
    // Stamps: where frames are missing the second field still comes half a frame later.
    put(join(folder, "frames.csv"), "frame,stamp\n0,10\n1,10.04\n2,10.5\n3,10.53\n4,10.57\n");
    const Ptr<Sequence> s = Sequence::load(folder);
    EXPECT_NEAR(10.04 + 0.5 / s->fps(), s->frameTime(1, 1), 1e-9);   // rounding
    EXPECT_NEAR(10.515, s->frameTime(2, 1), 1e-9);                   // before the next one
    // Below another eye's image with an odd number of rows fields change places.
    String odd = replaced(description, "image_height: 576", "image_height: 287");
    odd = replaced(odd, "right.mp4", "left.mp4");
    put(join(folder, "sequence.yaml"), odd + "fields: \"top_first\"\nlayout: \"top_bottom\"\n");
    Mat whole, top, bottom, expected;
    vconcat(a.rowRange(0, 287), b.rowRange(0, 287), whole);
    Sequence::load(folder)->eyeImage(whole, bottom, 1, 0);
    splitFields(b.rowRange(0, 287), false, expected, noArray());
    EXPECT_EQ(0, cvtest::norm(bottom, expected, NORM_INF));
}

TEST(SurgTrack_Fields, nothingMovesUpOrDown)
{
    Mat image(101, 40, CV_8UC3);   // grey levels rise by two a row
    for (int y = 0; y < image.rows; y++) image.row(y).setTo(Scalar::all(2 * y));
    Mat first, second;
    splitFields(image, true, first, second);
    const Rect inside(0, 1, 40, 99);
    EXPECT_EQ(0, cvtest::norm(image(inside), first(inside), NORM_INF));
    EXPECT_EQ(0, cvtest::norm(image(inside), second(inside), NORM_INF));
    EXPECT_EQ(2, second.at<Vec3b>(0, 0)[0]);   // the nearest row there is
    Mat bottom;
    splitFields(image, false, bottom, noArray());
    EXPECT_EQ(0, cvtest::norm(bottom, second, NORM_INF));
    EXPECT_ERROR(splitFields(image.row(0), true, first, second), "a row of each field");
    EXPECT_ERROR(splitFields(Mat::zeros(10, 10, CV_32F), true, first, second), "CV_8U");
}

// 25 frames a second of two fields each: the tool is followed through 50 poses a second, each at its own time and height.
TEST(SurgTrack_Fields, eachIsTrackedAtItsTimeAndHeight)
{
    SyntheticScene::Params p = scene(3);
    p.fps = 50;
    p.frames = 60;
    const Recording r(p, 40);
    Ptr<ToolTracker> tracker = r.tracker(METHOD_FULL);
    double offset[2] = {0, 0}, error = 0, most = 0;   // mean vertical offset of the tip [pixel]; distances [m]
    int count = 0;
    for (int frame = 0; frame < r.frames(); frame += 2)
    {
        Mat fields[2];
        splitFields(woven(r.images[frame], r.images[frame + 1]), true, fields[0], fields[1]);
        for (int i = 0; i < 2; i++)
        {
            EXPECT_FALSE(isInterlaced(fields[i]));
            Estimates e;
            tracker->update(fields[i], r.time(frame + i), r.joints(frame + i), e);
            if (frame < 10) continue;   // the start
            const Matx44d truth = r.scene->truePose(0, r.time(frame + i));
            ASSERT_EQ(STATE_TRACKING, e[0].state) << frame;
            const Point3d tip(e[0].camera_T_tool(0, 3), e[0].camera_T_tool(1, 3), e[0].camera_T_tool(2, 3)), trueTip(truth(0, 3), truth(1, 3), truth(2, 3));
            offset[i] += r.scene->camera().project(tip).y - r.scene->camera().project(trueTip).y;
            const double apart = distance(e[0].camera_T_tool, truth);
            error += apart;
            most = std::max(most, apart);
            count++;
        }
    }
    error /= count;
    if (std::getenv("SURGTRACK_TEST_PRINT"))
        std::cout << "fields: " << offset[0] * 2 / count << ", " << offset[1] * 2 / count << " px, " << error * 1e3 << " mm, at most " << most * 1e3 << std::endl;
    // A field taken for a row higher or lower than it is would be half a pixel off the other: five times this.
    EXPECT_NEAR(offset[0] * 2 / count, offset[1] * 2 / count, 0.1);
    EXPECT_LT(error, 0.0004);   // at most twice what is measured
    EXPECT_LT(most, 0.002);
}

}} // namespace
