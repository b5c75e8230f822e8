// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/surgtrack/tool_setup.hpp"
#include "base/geometry.hpp"
#include "lab/tool/surface.hpp"
#include "lab/tool/tool_motion.hpp"
#include "render/box_window.hpp"

namespace cv { namespace surgtrack {

namespace {

// Instruments of surgical robots: shafts are 3 to 15 mm thick, and at most as long as an arm reaches.
const double THINNEST = 0.001, THICKEST = 0.04, LONGEST = 1;   // [m]
const double GAP = 0.003;            // between a mesh and the nearest other one [m]

class Check
{
public:
    explicit Check(const ToolModel& model) : model_(model), motion_(model) { model.forwardKinematics(motion_.rest, base_T_link_); }

    std::vector<String> run()
    {
        checkChain();
        checkLimits();
        if (model_.meshes().empty())
            say("there are no meshes: it needs some to be tracked");
        else
        {
            checkSizes();
            checkPlaces();
        }
        checkKeypoints();
        return findings_;
    }

private:
    void say(const String& finding) { findings_.push_back(finding); }

    void checkChain()
    {
        if (motion_.path.empty())
            return say("no joint moves the end effector: is it a link of the tool?");
        int bends = 0;
        for (size_t c = 0; c < motion_.role.size(); c++)
            bends += motion_.role[c] == ToolMotion::WRIST;
        if (motion_.slide >= 0 && !bends)
            say("nothing bends between the shaft and the end effector: is the end effector the right link?");
    }

    void checkLimits()
    {
        const Mat_<double> limits = model_.jointLimits();
        for (int c = 0; c < limits.rows; c++)
        {
            const double most = std::max(limits(c, 0) > -DBL_MAX ? -limits(c, 0) : 0, limits(c, 1) < DBL_MAX ? limits(c, 1) : 0);
            if (most > (c == motion_.slide ? 1 : 4 * CV_PI))
                say(format("coordinate %s goes as far as %g: expected metres and radians, not millimetres and degrees", model_.coordinateNames()[c].c_str(), most));
        }
    }

    static Vec3d sides(const MeshBox& box)
    {
        Vec3d s(Point3d(box.high - box.low));
        std::sort(s.val, s.val + 3);
        return s;
    }

    void checkSizes()
    {
        double thickest = 0;
        String name;
        for (size_t i = 0; i < model_.links().size(); i++)
        {
            if (model_.links()[i].mesh < 0)
                continue;
            const Vec3d s = sides(boxAbout(model_.meshes()[model_.links()[i].mesh]));
            if (s[2] > LONGEST)
                return say(format("the mesh of link %s is %.3g m long: expected metres; files in millimetres have scale 0.001, in inches 0.0254",
                                  model_.links()[i].name.c_str(), s[2]));
            if (s[1] > thickest)
            {
                thickest = s[1];
                name = model_.links()[i].name;
            }
        }
        if (thickest > THICKEST || thickest < THINNEST)
            say(format("the thickest mesh, of link %s, is %.3g mm thick, instruments are some millimetres: files in millimetres have scale 0.001, in inches 0.0254",
                       name.c_str(), 1e3 * thickest));
    }

    //! The box about a link's mesh at rest, in the base frame.
    MeshBox boxOf(int link) const
    {
        Mesh placed;
        const Mesh& mesh = model_.meshes()[model_.links()[link].mesh];
        for (size_t k = 0; k < mesh.vertices.size(); k++)
            placed.vertices.push_back(Point3f(transform(base_T_link_[link], Point3d(mesh.vertices[k]))));
        return boxAbout(placed);
    }

    void checkPlaces()
    {
        std::vector<int> drawn;
        std::vector<MeshBox> boxes;
        for (size_t i = 0; i < model_.links().size(); i++)
            if (model_.links()[i].mesh >= 0)
            {
                drawn.push_back((int)i);
                boxes.push_back(boxOf((int)i));
            }
        for (size_t i = 0; i < drawn.size() && drawn.size() > 1; i++)
        {
            double nearest = DBL_MAX;
            for (size_t k = 0; k < drawn.size(); k++)
            {
                if (k == i)
                    continue;
                const Point3f a = boxes[i].low - boxes[k].high, b = boxes[k].low - boxes[i].high;
                const Vec3d gap(std::max(0.f, std::max(a.x, b.x)), std::max(0.f, std::max(a.y, b.y)), std::max(0.f, std::max(a.z, b.z)));
                nearest = std::min(nearest, norm(gap));
            }
            if (nearest > GAP)
                say(format("the mesh of link %s is %.1f mm from all others: is it in the link's axes?", model_.links()[drawn[i]].name.c_str(), 1e3 * nearest));
        }
        const Matx44d end = model_.endEffectorFromLinks(base_T_link_);
        const double far = norm(Point3d(end(0, 3), end(1, 3), end(2, 3)) - motion_.centre);
        if (far > 0.1)
            say(format("the end effector is %.0f mm from the wrist, expected the tip of an instrument", 1e3 * far));
    }

    void checkKeypoints()
    {
        const std::vector<ToolModel::Keypoint>& keypoints = model_.keypoints();
        if (keypoints.size() < 6)
            say(format("%d keypoints: it needs 6 and more to be tracked", (int)keypoints.size()));
        for (size_t i = 0; i < keypoints.size(); i++)
        {
            const int mesh = model_.links()[keypoints[i].link].mesh;
            const double off = mesh < 0 ? 0 : distanceTo(model_.meshes()[mesh], keypoints[i].linkPoint);
            if (mesh < 0 && !model_.meshes().empty())
                say("keypoint " + keypoints[i].name + " is on link " + model_.links()[keypoints[i].link].name + ", which has no mesh");
            else if (off > farthestKeypoint)
                say(format("keypoint %s is %.3g mm off the surface of link %s", keypoints[i].name.c_str(), 1e3 * off,
                           model_.links()[keypoints[i].link].name.c_str()));
        }
    }

    const ToolModel& model_;
    ToolMotion motion_;
    std::vector<Matx44d> base_T_link_;
    std::vector<String> findings_;
};

} // namespace

std::vector<String> checkTool(const Ptr<ToolModel>& model)
{
    CV_Assert(model);
    return Check(*model).run();
}

}} // namespace cv::surgtrack
