// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include <map>
#include "perf_common.hpp"
#include "opencv2/core/utils/filesystem.hpp"

namespace opencv_test {

namespace {

// Finer by so many splits of one triangle into four. New vertices leave the surface by up to 30 micrometres, as those of a scan do:
// no tie for the decimation, and no crack, because the displacement depends on the place alone.
Mesh subdivide(const Mesh& mesh, size_t splits)
{
    Mesh fine = mesh;
    fine.triangles.clear();
    std::map<std::pair<int, int>, int> middles;
    for (size_t i = 0; i < mesh.triangles.size(); i++)
    {
        const Vec3i t = mesh.triangles[i];
        if (i >= splits)
        {
            fine.triangles.push_back(t);
            continue;
        }
        Vec3i middle;
        for (int k = 0; k < 3; k++)
        {
            const int a = t[k], b = t[(k + 1) % 3];
            const std::pair<int, int> edge(std::min(a, b), std::max(a, b));
            if (!middles.count(edge))
            {
                middles[edge] = int(fine.vertices.size());
                const Point3f p = (mesh.vertices[a] + mesh.vertices[b]) * 0.5f, n = mesh.normals[a] + mesh.normals[b];
                fine.vertices.push_back(p + 3e-5f * Point3f(std::sin(31e3f * p.y + 17e3f * p.z), std::sin(29e3f * p.z + 13e3f * p.x),
                                                            std::sin(23e3f * p.x + 19e3f * p.y)));
                fine.normals.push_back(n * float(1 / cv::norm(n)));
            }
            middle[k] = middles[edge];
        }
        fine.triangles.push_back(Vec3i(t[0], middle[0], middle[2]));
        fine.triangles.push_back(Vec3i(middle[0], t[1], middle[1]));
        fine.triangles.push_back(Vec3i(middle[2], middle[1], t[2]));
        fine.triangles.push_back(middle);
    }
    return fine;
}

Ptr<ToolModel> refinedTool(size_t wanted)
{
    const Ptr<ToolModel> coarse = ToolModel::needleDriver();
    ToolModel::Description d;
    d.name = coarse->name();
    d.coordinates = coarse->coordinateNames();
    d.links = coarse->links();
    d.keypoints = coarse->keypoints();
    d.meshes = coarse->meshes();
    // The model tells the end effector's pose, not its link: what carries the last jaw.
    d.endEffectorLink = d.links.back().parent;
    const std::vector<double> joints(d.coordinates.size(), 0.);
    std::vector<Matx44d> base_T_link;
    coarse->forwardKinematics(joints, base_T_link);
    d.link_T_endEffector = base_T_link[d.endEffectorLink].inv() * coarse->endEffectorPose(joints);
    size_t triangles = 0;
    for (size_t i = 0; i < d.meshes.size(); i++) triangles += d.meshes[i].triangles.size();
    for (size_t i = 0; triangles < wanted; i = (i + 1) % d.meshes.size())
    {
        const size_t splits = std::min(d.meshes[i].triangles.size(), (wanted - triangles + 2) / 3);
        d.meshes[i] = subdivide(d.meshes[i], splits);
        triangles += 3 * splits;
    }
    const String folder = cv::tempfile(""), file = utils::fs::join(folder, "tool.yaml");
    CV_Assert(utils::fs::createDirectories(folder));
    ToolModel::create(d)->save(file);
    const Ptr<ToolModel> loaded = ToolModel::load(file);
    utils::fs::remove_all(folder);
    return loaded;
}

bool stronger(const std::pair<float, TemplateFeature>& a, const std::pair<float, TemplateFeature>& b)
{
    return a.first > b.first;
}

// So many of the candidates, the strongest first, as far from each other as that allows.
std::vector<TemplateFeature> scatter(std::vector<std::pair<float, TemplateFeature> >& candidates, size_t count)
{
    std::stable_sort(candidates.begin(), candidates.end(), stronger);
    std::vector<TemplateFeature> chosen;
    for (int distance = int(candidates.size() / count) + 1; chosen.size() < count; distance--)
        for (size_t i = 0; i < candidates.size() && chosen.size() < count; i++)
        {
            const TemplateFeature f = candidates[i].second;
            bool apart = true;
            for (size_t j = 0; j < chosen.size() && apart; j++)
            {
                const int dx = f.x - chosen[j].x, dy = f.y - chosen[j].y;
                apart = dx * dx + dy * dy >= distance * distance;
            }
            if (apart) chosen.push_back(f);
        }
    return chosen;
}

} // namespace

Ptr<ToolModel> tool(const std::string& cad)
{
    static std::map<std::string, Ptr<ToolModel> > made;
    Ptr<ToolModel>& model = made[cad];
    if (model) return model;
    if (cad == "SURGTRACK_DATA")
    {
        const char* const data = getenv("SURGTRACK_DATA");
        if (!data || !*data) throw SkipTestException("SURGTRACK_DATA is not set");
        model = ToolModel::load(String(data) + "/tools/large_needle_driver/large_needle_driver.yaml");
    }
    else
        model = refinedTool(cad == "12k" ? 12000 : cad == "80k" ? 80000 : 1000000);
    return model;
}

Mat drawn(const SyntheticScene::Params& params, int frame, bool right)
{
    static std::map<String, Mat> images;
    Mat& image = images[format("%d %d %d %d %d %d %d", params.imageSize.width, params.imageSize.height, params.tools, params.distortion, params.stereo, frame, right)];
    if (image.empty()) SyntheticScene::create(Ptr<ToolModel>(), params)->render(frame, image, right);
    return image.clone();
}

std::vector<PartTemplate> cutTemplates(const Mat& image, int count, int features)
{
    const int half = cvRound(32 * image.cols / 720.);
    Mat orientations, grey, gx, gy;
    quantizeOrientations(image, orientations);
    cvtColor(image, grey, COLOR_BGR2GRAY);
    GaussianBlur(grey, grey, Size(7, 7), 1.4);
    Sobel(grey, gx, CV_32F, 1, 0);
    Sobel(grey, gy, CV_32F, 0, 1);
    Mat inside = Mat::zeros(image.size(), CV_8UC1);
    inside(Rect(2 * half, 2 * half, image.cols - 4 * half, image.rows - 4 * half)) = 255;
    std::vector<Point2f> corners;
    goodFeaturesToTrack(grey, corners, 10 * count, 0.0005, half / 2., inside);

    std::vector<PartTemplate> templates;
    for (size_t c = 0; c < corners.size() && int(templates.size()) < count; c++)
    {
        PartTemplate t;
        t.anchor = corners[c];
        t.imagePoint = t.anchor;
        t.part = int(templates.size());
        t.bounds = Rect(-half, -half, 2 * half, 2 * half);
        std::vector<std::pair<float, TemplateFeature> > candidates;
        for (int y = -half; y < half; y++)
            for (int x = -half; x < half; x++)
            {
                const Point p = t.anchor + Point(x, y);
                TemplateFeature f = { short(x), short(y), 0 };
                for (int bits = orientations.at<uchar>(p); bits > 1; bits /= 2) f.bin++;
                const float u = gx.at<float>(p), v = gy.at<float>(p);
                if (orientations.at<uchar>(p)) candidates.push_back(std::make_pair(u * u + v * v, f));
            }
        if (int(candidates.size()) < 3 * features) continue;
        t.features = scatter(candidates, features);
        templates.push_back(t);
    }
    CV_Assert(int(templates.size()) == count);
    return templates;
}

} // namespace
