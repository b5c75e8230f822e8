// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Memory is taken while a tracker warms up, none after that. The C library's functions are replaced in this program by ones
// that count; operator new and OpenCV's allocators end in them.

#include "test_common.hpp"

#include <atomic>
#include <cstdlib>

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define COUNTS_ALLOCATIONS 1
#else
#define COUNTS_ALLOCATIONS 0
#endif
#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#undef COUNTS_ALLOCATIONS
#define COUNTS_ALLOCATIONS 0
#endif
#endif

#if COUNTS_ALLOCATIONS
#include <cerrno>

static std::atomic<bool> counting(false);
static std::atomic<int> allocations(0);

extern "C" {

void* __libc_malloc(size_t size);
void* __libc_calloc(size_t n, size_t size);
void* __libc_realloc(void* p, size_t size);
void* __libc_memalign(size_t alignment, size_t size);
void __libc_free(void* p);

static void count()
{
    if (counting.load(std::memory_order_relaxed)) allocations++;
}

#define EXPORTED __attribute__((visibility("default")))

EXPORTED void* malloc(size_t size) __THROW
{
    count();
    return __libc_malloc(size);
}

EXPORTED void* calloc(size_t n, size_t size) __THROW
{
    count();
    return __libc_calloc(n, size);
}

EXPORTED void* realloc(void* p, size_t size) __THROW
{
    count();
    return __libc_realloc(p, size);
}

EXPORTED void* aligned_alloc(size_t alignment, size_t size) __THROW
{
    count();
    return __libc_memalign(alignment, size);
}

EXPORTED int posix_memalign(void** p, size_t alignment, size_t size) __THROW
{
    count();
    *p = __libc_memalign(alignment, size);
    return *p ? 0 : ENOMEM;
}

EXPORTED void free(void* p) __THROW
{
    __libc_free(p);
}

} // extern "C"
#endif

namespace opencv_test { namespace {

// Calls to the C library's allocating functions, by all threads, while it lives.
class AllocationCounter
{
public:
    AllocationCounter()
    {
#if COUNTS_ALLOCATIONS
        allocations = 0;
        counting = true;
#endif
    }
    ~AllocationCounter() { stop(); }

    int stop()
    {
#if COUNTS_ALLOCATIONS
        counting = false;
        return allocations;
#else
        return 0;
#endif
    }
};

void skipWithoutCounting()
{
    if (!COUNTS_ALLOCATIONS) throw SkipTestException("allocations are counted with glibc and without sanitizers only");
}

TEST(SurgTrack_Allocations, areCounted)
{
    skipWithoutCounting();
    AllocationCounter counter;
    const Mat aligned(100, 100, CV_8UC1);
    std::vector<int> plain(100);
    plain.resize(plain.capacity() + 1);
    EXPECT_GE(counter.stop(), 3);
    EXPECT_EQ(100, aligned.rows);
}

TEST(SurgTrack_Allocations, theFilterTakesNone)
{
    skipWithoutCounting();
    const CameraModel camera = endoscope();
    Ptr<ToolPoseEKF> filter = ToolPoseEKF::create(camera);
    RNG rng(1);
    std::vector<Point3d> nominalPoints;
    for (int i = 0; i < 14; i++) nominalPoints.push_back(Point3d(rng.uniform(-0.02, 0.02), rng.uniform(-0.02, 0.02), rng.uniform(0.08, 0.12)));
    std::vector<Point2d> imagePoints;
    for (const Point3d& p : nominalPoints) imagePoints.push_back(camera.project(p + Point3d(0.001, 0, 0)));
    std::vector<uchar> used;
    double sum = 0;
    for (int pass = 0; pass < 2; pass++)
    {
        AllocationCounter counter;
        filter->reset(Matx44d::eye());
        for (int frame = 0; frame < 5; frame++)
        {
            filter->predict();
            ASSERT_TRUE(filter->correct(nominalPoints, imagePoints, used));
            // Headers over anyone's memory are as good.
            ASSERT_TRUE(filter->correct(Mat(14, 3, CV_64F, &nominalPoints[0]), Mat(14, 2, CV_64F, &imagePoints[0])));
            sum += filter->imageCovariance(nominalPoints[0])(0, 0) + filter->poseCovariance(nominalPoints[0])(0, 0) + filter->correction()(0, 3) + filter->nis();
        }
        const int taken = counter.stop();
        EXPECT_EQ(0, pass > 0 ? taken : 0);
    }
    EXPECT_GT(sum, 0);
}

TEST(SurgTrack_Allocations, theVerifierTakesNone)
{
    skipWithoutCounting();
    for (int centred = 0; centred < 2; centred++)
    {
        GeometricContextVerifier::Params params;
        params.centredZones = centred != 0;
        Ptr<GeometricContextVerifier> verifier = GeometricContextVerifier::create(params);
        RNG rng(1);
        std::vector<PartMatch> matches, inliers;
        for (int part = 0; part < 14; part++)
        {
            PartMatch m;
            m.part = part;
            m.predictedPoint = Point2d(rng.uniform(0., 720.), rng.uniform(0., 576.));
            for (int k = 0; k < 5; k++)
            {
                m.similarity = 0.9 - 0.1 * k;
                m.imagePoint = m.predictedPoint + Point2d(12 + 30 * k, 7);
                matches.push_back(m);
            }
        }
        std::sort(matches.begin(), matches.end(), [](const PartMatch& a, const PartMatch& b) { return a.similarity > b.similarity; });
        ASSERT_TRUE(verifier->verify(matches, inliers));
        AllocationCounter counter;
        for (int i = 0; i < 5; i++) ASSERT_TRUE(verifier->verify(matches, inliers));
        EXPECT_EQ(0, counter.stop());
    }
}

// Frames of a scene, played to and fro.
struct Player
{
    Player(int method, Size size, int tools, bool _ahead, bool _stereo) : shown(0), frames(6), ahead(_ahead), stereo(_stereo)
    {
        SyntheticScene::Params params;
        params.imageSize = size;
        params.tools = tools;
        params.stereo = stereo;
        scene = SyntheticScene::create(needleDriver(), params);
        ToolTracker::Params tracking;
        tracking.method = method;
        tracker = ToolTracker::create(scene->camera(), tracking);
        if (stereo) tracker->setRightCamera(scene->camera(true), scene->right_T_left());
        for (int i = 0; i < tools; i++) tracker->addTool(scene->model(), scene->nominal_T_base(i));
        images.resize(frames);
        rightImages.resize(frames);
        joints.resize(frames);
        for (int frame = 0; frame < frames; frame++)
        {
            scene->render(frame, images[frame]);
            if (stereo) scene->render(frame, rightImages[frame], true);
            for (int i = 0; i < tools; i++) joints[frame].push_back(scene->recordedJoints(i, frame / params.fps));
        }
    }

    int frame(int index) const
    {
        const int k = index % (2 * frames - 2);
        return k < frames ? k : 2 * frames - 2 - k;
    }

    void next()
    {
        const int k = frame(shown);
        if (ahead) tracker->renderAhead(joints[frame(shown + 1)]);
        if (stereo) tracker->updateStereo(images[k], rightImages[k], shown / 25., joints[k], estimates);
        else tracker->update(images[k], shown / 25., joints[k], estimates);
        shown++;
    }

    int shown, frames;
    bool ahead, stereo;
    Ptr<SyntheticScene> scene;
    Ptr<ToolTracker> tracker;
    std::vector<Mat> images, rightImages;
    std::vector<std::vector<std::vector<double> > > joints;
    std::vector<ToolEstimate> estimates;
};

TEST(SurgTrack_Allocations, theTrackerTakesNone)
{
    skipWithoutCounting();
    const Size plain(720, 576), large(1440, 1152), small(240, 192);   // the larger is reduced, tools in the smaller are enlarged
    struct { int method; Size size; bool ahead, stereo, masked; } const cases[] = {
        {METHOD_FULL, plain, false, false, false}, {METHOD_FULL, large, false, false, false}, {METHOD_FULL, plain, true, false, false},
        {METHOD_FULL, plain, false, true, false},  {METHOD_PAPER, plain, true, false, false}, {METHOD_FULL, small, false, false, false},
        {METHOD_FULL, plain, false, false, true},  {METHOD_FULL, small, false, false, true}};
    for (const auto& c : cases)
    {
        Player player(c.method, c.size, 2, c.ahead, c.stereo);
        for (Mat& image : player.images)
            if (c.masked) rectangle(image, Rect(0, 0, image.cols, image.rows / 5), Scalar::all(0), FILLED);   // a surround: it is looked for in every 32nd
        for (int k = 0; k < 60; k++) player.next();
        AllocationCounter counter;
        for (int k = 0; k < (c.masked ? 32 : 10); k++) player.next();
        EXPECT_EQ(0, counter.stop()) << c.method << " " << c.size << (player.ahead ? ", drawn ahead" : "") << (player.stereo ? ", both eyes" : "")
                                     << (c.masked ? ", masked" : "");
        EXPECT_EQ(STATE_TRACKING, player.estimates[0].state);
        EXPECT_EQ(STATE_TRACKING, player.estimates[1].state);
    }
}

}} // namespace
