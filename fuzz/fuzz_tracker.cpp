// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "fuzz.hpp"
#include <cstring>
#include "opencv2/core/utils/filesystem.hpp"
#include "opencv2/imgproc.hpp"
#include "opencv2/surgtrack.hpp"
#include "opencv2/surgtrack/synthetic.hpp"

using namespace cv;
using namespace cv::surgtrack;

// Calls of the tracker's interface in any order, with any readings and times: each is answered with numbers, or refused. At the end it says
// how many.

namespace {

const int frames = 6;

struct Scene
{
    Scene()
    {
        SyntheticScene::Params p;
        p.imageSize = Size(96, 72);
        p.stereo = true;
        // Of few triangles: how meshes hide themselves is found out for each tracker anew, and took most of the time.
        const std::string folder = tempfile("");
        CV_Assert(utils::fs::createDirectory(folder));
        ToolModel::needleDriver()->save(folder + "/driver.yaml");
        scene = SyntheticScene::create(ToolModel::load(folder + "/driver.yaml", 600), p);
        utils::fs::remove_all(folder);
        for (int i = 0; i < frames; i++)
        {
            scene->render(i, left[i]);
            scene->render(i, right[i], true);
        }
    }
    Ptr<SyntheticScene> scene;
    Mat left[frames], right[frames];
};

class Bytes
{
public:
    Bytes(const uint8_t* data, size_t size) : data_(data), left_(size) {}
    bool empty() const { return left_ == 0; }
    int next(int count)
    {
        if (!left_) return 0;
        left_--;
        return *data_++ % count;
    }
    //! Now and then any double.
    double number(double usual)
    {
        const int kind = next(16);
        if (kind < 12) return usual * (1 + (kind - 6) * 0.01);
        if (kind == 12) return usual * 100;
        double any = 0;
        if (left_ >= 8)
        {
            std::memcpy(&any, data_, 8);
            data_ += 8;
            left_ -= 8;
        }
        return any;
    }
    Matx44d pose(const Matx44d& usual)
    {
        Matx44d T = usual;
        T(next(4), next(4)) = number(T(next(3), 3));
        return next(4) ? usual : T;
    }

private:
    const uint8_t* data_;
    size_t left_;
};

struct Counts
{
    Counts() : updates(0), answered(0) {}
    ~Counts() { std::fprintf(stderr, "%ld calls of update(), %ld answered\n", updates, answered); }
    long updates, answered;
};

bool isFinite(const ToolEstimate& e)
{
    bool ok = checkRange(e.camera_T_tool) && checkRange(e.camera_T_nominal) && checkRange(e.covariance) && checkRange(e.jointOffsets) && checkRange(e.joints);
    ok = ok && checkRange(Vec<double, 5>(e.similarity, e.contourSupport, e.confidence, e.nis, e.delay));
    for (int i = 0; i < 6; i++) ok = ok && e.covariance(i, i) >= 0;
    return ok;
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    static const Scene scene;
    static Counts counts;
    static ErrorCallback quiet = redirectError([](int, const char*, const char*, const char*, int, void*) { return 0; });
    (void)quiet;
    Bytes bytes(data, std::min(size, (size_t)200));
    ToolTracker::Params params;
    ToolTracker::Stages stages;
    params.method = bytes.next(3);
    if (bytes.next(8) == 0) stages.edges.minStrength = bytes.number(stages.edges.minStrength);
    if (bytes.next(8) == 0) stages.filter.pointNoise = bytes.number(stages.filter.pointNoise);
    if (bytes.next(8) == 0) stages.templates.magnitudeThreshold = bytes.number(stages.templates.magnitudeThreshold);
    Ptr<ToolTracker> tracker;
    int tools = 0, frame = 0;
    double time = 0;
    std::vector<ToolEstimate> estimates;
    try
    {
        CameraModel camera = scene.scene->camera();
        if (bytes.next(4) == 0)
        {
            Mat_<double> D(1, 8);
            for (int i = 0; i < 8; i++) D(i) = bytes.number(0.1);
            camera = CameraModel(Mat(camera.cameraMatrix()), D, camera.imageSize());
        }
        tracker = ToolTracker::create(camera, params, stages);
    }
    catch (const Exception&)
    {
        return 0;
    }
    for (int calls = 0; !bytes.empty() && calls < 10; calls++)
    {
        std::vector<std::vector<double> > joints(tools, scene.scene->recordedJoints(0, frame / SyntheticScene::Params().fps));
        for (int i = 0; i < tools; i++)
            if (bytes.next(3) == 0) joints[i][bytes.next((int)joints[i].size())] = bytes.number(0.1);
        try
        {
            switch (tools ? bytes.next(16) : 0)
            {
            case 0:
                if (tools < 2 && tracker->addTool(scene.scene->model(), bytes.pose(scene.scene->nominal_T_base(0))) == tools) tools++;
                break;
            case 1: tracker->setHandEye(bytes.next(3), bytes.pose(scene.scene->nominal_T_base(0))); break;
            case 2: tracker->moveCamera(bytes.pose(Matx44d::eye())); break;
            case 3: tracker->setRightCamera(scene.scene->camera(true), bytes.pose(scene.scene->right_T_left())); break;
            case 4: tracker->setMask(Mat(bytes.next(2) ? Size(96, 72) : Size(3, 3), CV_8UC1, Scalar::all(bytes.next(2))), bytes.next(2)); break;
            case 5: tracker->reset(bytes.next(4) - 1); break;
            case 6: tracker->replaceTool(bytes.next(3), scene.scene->model()); break;
            case 7:
                if (tools > 1)
                {
                    tracker->removeTool(bytes.next(2));
                    tools--;
                }
                break;
            case 8: tracker->renderAhead(joints); break;
            case 9:
            {
                ReadingErrors errors = tracker->readingErrors(0);
                errors.covariance = errors.covariance.clone();
                const int n = (int)errors.values.size();
                if (n > 0) errors.values[bytes.next(n)] = bytes.number(0.01);
                if (n > 0) errors.covariance.at<double>(bytes.next(n * n)) = bytes.number(0.01);
                if (n > 0) errors.reference[bytes.next((int)errors.reference.size())] = bytes.number(0.01);
                tracker->setReadingErrors(0, errors);
                break;
            }
            default:
            {
                frame = (frame + 1) % frames;
                time += bytes.number(0.04);
                Mat left = scene.left[frame], right = scene.right[frame];
                const int kind = bytes.next(12);
                if (kind == 0) left = Mat(left.size(), left.type(), Scalar::all(bytes.next(256)));
                if (kind == 1)
                {
                    left = left.clone();
                    RNG rng(bytes.next(256));
                    rng.fill(left, RNG::UNIFORM, 0, 256);
                }
                if (kind == 2) cvtColor(left, left, COLOR_BGR2GRAY);
                if (kind == 3) left = Mat();
                counts.updates++;
                if (kind < 9) tracker->update(left, time, joints, estimates);
                else tracker->updateStereo(left, right, time, joints, estimates);
                counts.answered++;
                for (size_t i = 0; i < estimates.size(); i++)
                    if (!isFinite(estimates[i])) std::abort();
            }
            }
        }
        catch (const Exception&)
        {
        }
    }
    return 0;
}
