// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "lab/import/import_tool.hpp"
#include "lab/import/urdf_path.hpp"
#include "lab/import/urdf_shape.hpp"
#include "lab/import/urdf_text.hpp"
#include <map>
#include <mutex>
#include <set>

#ifdef HAVE_URDFDOM
#include <console_bridge/console.h>
#include <urdf_parser/urdf_parser.h>
#endif

// importUrdfTool(): an expanded URDF.

namespace cv { namespace surgtrack {

#ifndef HAVE_URDFDOM

Ptr<ToolModel> importUrdfTool(const String&, const ToolParts&)
{
    CV_Error(Error::StsNotImplemented, "the module was built without urdfdom, which reads URDF");
}

#else

namespace {

//! urdfdom prints what it does not like; here it becomes part of the error.
class Messages : public console_bridge::OutputHandler
{
public:
    Messages() { console_bridge::useOutputHandler(this); }
    ~Messages() { console_bridge::restorePreviousOutputHandler(); }
    void log(const std::string& text, console_bridge::LogLevel level, const char*, int) CV_OVERRIDE
    {
        if (level >= console_bridge::CONSOLE_BRIDGE_LOG_ERROR && first.empty())
            first = text;
    }
    std::string first;
};

//! Quarter turns about the axes exactly, if it is one that was rounded.
Matx33d exactRotation(const Matx33d& R)
{
    Matx33d quarter;
    for (int i = 0; i < 9; i++)
        quarter.val[i] = cvRound(R.val[i]);
    return norm(R, quarter, NORM_INF) < 2e-5 && std::abs(determinant(quarter) - 1) < 1e-9 ? quarter : R;
}

Matx44d toTransform(const urdf::Pose& pose)
{
    const Vec3d columns[] = { Vec3d(1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, 0, 1) };
    Matx33d R;
    for (int c = 0; c < 3; c++)
    {
        const urdf::Vector3 v = pose.rotation * urdf::Vector3(columns[c][0], columns[c][1], columns[c][2]);
        R(0, c) = v.x;
        R(1, c) = v.y;
        R(2, c) = v.z;
    }
    return rigidTransform(exactRotation(R), Vec3d(pose.position.x, pose.position.y, pose.position.z));
}

//! A rotation that brings the z axis to this one.
Matx44d toAxis(const Vec3d& axis)
{
    const Vec3d v(-axis[1], axis[0], 0);   // z x axis
    const Matx33d K(0, 0, v[1], 0, 0, -v[0], -v[1], v[0], 0);
    return rigidTransform(exactRotation(Matx33d::eye() + K + K * K * (1 / (1 + axis[2]))), Vec3d());
}

class UrdfReader
{
public:
    UrdfReader(const String& filename, const ToolParts& parts) : filename_(filename), parts_(parts)
    {
        const String text = readTextFile(filename);
        order_ = checkUrdfText(filename, text);
        static std::mutex mutex;   // messages go to one place for all threads
        const std::lock_guard<std::mutex> lock(mutex);
        Messages messages;
        try
        {
            urdf_ = urdf::parseURDF(text);
        }
        catch (const std::exception& e)
        {
            messages.first = e.what();
        }
        if (!urdf_ || !messages.first.empty())
            fail("expected an expanded URDF" + (messages.first.empty() ? String() : " (" + messages.first + ")"));
        replaced_ = pairsByLabel(parts.meshes, "meshes");
        if (!parts.like.empty())
            like_ = ToolModel::load(parts.like, 0);
    }

    ToolModel::Description read()
    {
        tool_.name = urdf_->getName();
        const urdf::LinkConstSharedPtr base = parts_.base.empty() ? urdf::LinkConstSharedPtr(urdf_->getRoot()) : urdf_->getLink(parts_.base);
        if (!base)
            fail("there is no link `" + parts_.base + "` to be the base");
        addChildren(base, -1);
        if (tool_.links.empty())
            fail("nothing hangs on the link `" + base->name + "`, expected joints");
        if (like_)
            addKeypoints();
        findEndEffector();
        orderCoordinates();
        return tool_;
    }

    const MeshFrames& frames() const { return frames_; }

private:
    //! Those on the way to the end effector first, from the base on, then the others as in the file.
    void orderCoordinates()
    {
        std::vector<int> found;
        for (int i = tool_.endEffectorLink; i >= 0; i = tool_.links[i].parent)
            if (tool_.links[i].jointType != ToolModel::JOINT_FIXED)
                found.insert(found.begin(), tool_.links[i].coordinate);
        for (size_t i = 0; i < order_.size(); i++)
            found.push_back((int)(std::find(tool_.coordinates.begin(), tool_.coordinates.end(), order_[i]) - tool_.coordinates.begin()));
        for (size_t i = 0; i < tool_.coordinates.size(); i++)
            found.push_back((int)i);
        std::vector<int> place(tool_.coordinates.size() + 1, -1);
        std::vector<String> sorted;
        std::vector<Vec2d> limits;
        for (size_t i = 0; i < found.size(); i++)
            if (found[i] < (int)tool_.coordinates.size() && place[found[i]] < 0)
            {
                place[found[i]] = (int)sorted.size();
                sorted.push_back(tool_.coordinates[found[i]]);
                limits.push_back(tool_.limits[found[i]]);
            }
        tool_.coordinates.swap(sorted);
        tool_.limits.swap(limits);
        for (size_t i = 0; i < tool_.links.size(); i++)
            if (tool_.links[i].jointType != ToolModel::JOINT_FIXED)
                tool_.links[i].coordinate = place[tool_.links[i].coordinate];
    }

    CV_NORETURN void fail(const String& what, Error::Code code = Error::StsParseError) const { importError(filename_, what, code); }

    void addChildren(const urdf::LinkConstSharedPtr& link, int parent)
    {
        if (!added_.insert(link->name).second)
            fail("link `" + link->name + "`: expected a tree of links, more than one joint leads to it");
        for (size_t i = 0; i < link->child_joints.size(); i++)
        {
            const urdf::Joint& joint = *link->child_joints[i];
            const urdf::LinkConstSharedPtr child = urdf_->getLink(joint.child_link_name);
            addJoint(joint, child->name, parent);
            const int index = (int)tool_.links.size() - 1;
            addMeshes(*child, index);
            addChildren(child, index);
        }
    }

    //! The joint's coordinate, by way of those it mimics; value of the joint = scale * coordinate + offset.
    int coordinateOf(const urdf::Joint& joint, double& scale, double& offset)
    {
        scale = 1;
        offset = 0;
        const urdf::Joint* source = &joint;
        for (int i = 0; source->mimic; i++)
        {
            offset += scale * source->mimic->offset;
            scale *= source->mimic->multiplier;
            const urdf::JointConstSharedPtr next = urdf_->getJoint(source->mimic->joint_name);
            if (!next || i > 100)
                fail("joint `" + joint.name + "`: mimic: expected the name of a joint that moves by itself, found `"
                     + source->mimic->joint_name + "`");
            source = next.get();
        }
        if (source->type == urdf::Joint::FIXED)
            fail("joint `" + joint.name + "`: mimic: `" + source->name + "` is fixed");
        const std::vector<String>::iterator at = std::find(tool_.coordinates.begin(), tool_.coordinates.end(), source->name);
        if (at != tool_.coordinates.end())
            return (int)(at - tool_.coordinates.begin());
        tool_.coordinates.push_back(source->name);
        tool_.limits.push_back(limitsOf(*source));
        return (int)tool_.coordinates.size() - 1;
    }

    //! Without lower and upper both are 0 in urdfdom.
    static Vec2d limitsOf(const urdf::Joint& joint)
    {
        const bool known = joint.limits && joint.type != urdf::Joint::CONTINUOUS && joint.limits->lower < joint.limits->upper;
        return known ? Vec2d(joint.limits->lower, joint.limits->upper) : Vec2d(-DBL_MAX, DBL_MAX);
    }

    void addJoint(const urdf::Joint& joint, const String& name, int parent)
    {
        const Matx44d origin = toTransform(joint.parent_to_joint_origin_transform);
        if (joint.type == urdf::Joint::FIXED)
        {
            addSteps(denavitHartenbergSteps(origin), name, parent);
            return;
        }
        const bool turns = joint.type == urdf::Joint::REVOLUTE || joint.type == urdf::Joint::CONTINUOUS;
        if (!turns && joint.type != urdf::Joint::PRISMATIC)
            fail("joint `" + joint.name + "`: expected one of type fixed, revolute, continuous or prismatic");
        Vec3d axis(joint.axis.x, joint.axis.y, joint.axis.z);
        if (!(norm(axis) > 1e-6))
            fail("joint `" + joint.name + "`: axis: expected a direction, found 0 0 0");
        axis = normalize(axis);
        const bool along = std::hypot(axis[0], axis[1]) < 1e-9;
        const Matx44d joint_T_axis = along ? Matx44d::eye() : toAxis(axis);

        double scale, offset;
        std::vector<ToolModel::Link> steps = denavitHartenbergSteps(origin * joint_T_axis);
        ToolModel::Link& moving = steps.back();
        moving.jointType = turns ? ToolModel::JOINT_REVOLUTE : ToolModel::JOINT_PRISMATIC;
        moving.coordinate = coordinateOf(joint, scale, offset);
        const double sign = along && axis[2] < 0 ? -1 : 1;
        moving.scale = sign * scale;
        (turns ? moving.theta : moving.d) += sign * offset;
        if (!along)
        {
            const std::vector<ToolModel::Link> back = denavitHartenbergSteps(rigidInverse(joint_T_axis));
            steps.insert(steps.end(), back.begin(), back.end());
        }
        addSteps(steps, name, parent);
    }

    void addSteps(const std::vector<ToolModel::Link>& steps, const String& name, int parent)
    {
        for (size_t i = 0; i < steps.size(); i++)
        {
            tool_.links.push_back(steps[i]);
            tool_.links.back().name = i + 1 < steps.size() ? name + format("__%d", (int)i + 1) : name;
            tool_.links.back().parent = i ? (int)tool_.links.size() - 2 : parent;
        }
    }

    void addMeshes(const urdf::Link& link, int index)
    {
        if (replaced_.count(link.name))
            return;   // whatever the URDF has: it need not even be a file that can be read
        Mesh all;
        for (size_t i = 0; i < link.visual_array.size(); i++)
        {
            const urdf::Visual& visual = *link.visual_array[i];
            if (!visual.geometry)
                continue;
            if (visual.geometry->type != urdf::Geometry::MESH)
            {
                append(shapeMesh(*visual.geometry, toTransform(visual.origin)), all);
                continue;
            }
            const urdf::Mesh& mesh = static_cast<const urdf::Mesh&>(*visual.geometry);
            try
            {
                const Vec3d scale(mesh.scale.x, mesh.scale.y, mesh.scale.z);
                append(loadScaled(urdfMeshPath(filename_, parts_.packages, mesh.filename), scale, toTransform(visual.origin)), all);
                frames_[index].push_back(toTransform(visual.origin) * Matx44d::diag(Matx41d(scale[0], scale[1], scale[2], 1)));
            }
            catch (const Exception& e)
            {
                fail("link `" + link.name + "`: " + e.err, (Error::Code)e.code);
            }
        }
        if (all.triangles.empty() && like_)
            for (size_t i = 0; i < like_->links().size(); i++)
                if (like_->links()[i].name == link.name && like_->links()[i].mesh >= 0)
                    all = like_->meshes()[like_->links()[i].mesh];
        if (all.triangles.empty())
            return;
        tool_.links[index].mesh = (int)tool_.meshes.size();
        tool_.meshes.push_back(all);
    }

    static Mesh loadScaled(const String& filename, const Vec3d& scale, const Matx44d& link_T_mesh)
    {
        const double volume = scale[0] * scale[1] * scale[2];
        if (!(std::abs(volume) > 0) || !checkRange(scale))
            CV_Error(Error::StsParseError, filename + ": scale: expected three numbers other than 0");
        if (volume > 0 && scale[0] == scale[1] && scale[1] == scale[2])
            return loadMesh(filename, scale[0], link_T_mesh);
        Mesh mesh = loadMesh(filename);
        const Matx33d R = link_T_mesh.get_minor<3, 3>(0, 0);
        for (size_t i = 0; i < mesh.vertices.size(); i++)
        {
            const Point3f v = mesh.vertices[i], n = mesh.normals[i];
            mesh.vertices[i] = Point3f(transform(link_T_mesh, Point3d(v.x * scale[0], v.y * scale[1], v.z * scale[2])));
            mesh.normals[i] = Point3f(Point3d(normalize(R * Vec3d(n.x / scale[0], n.y / scale[1], n.z / scale[2]))));
        }
        for (size_t i = 0; volume < 0 && i < mesh.triangles.size(); i++)   // a mirror turns the triangles over
            std::swap(mesh.triangles[i][1], mesh.triangles[i][2]);
        return mesh;
    }

    static void append(const Mesh& mesh, Mesh& all)
    {
        const int start = (int)all.vertices.size();
        all.vertices.insert(all.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
        all.normals.insert(all.normals.end(), mesh.normals.begin(), mesh.normals.end());
        for (size_t i = 0; i < mesh.triangles.size(); i++)
            all.triangles.push_back(mesh.triangles[i] + Vec3i::all(start));
    }

    void addKeypoints()
    {
        for (size_t i = 0; i < like_->keypoints().size(); i++)
        {
            ToolModel::Keypoint keypoint = like_->keypoints()[i];
            keypoint.link = findLink(tool_, like_->links()[keypoint.link].name, filename_ + ": keypoints of " + parts_.like);
            tool_.keypoints.push_back(keypoint);
        }
    }

    void findEndEffector()
    {
        if (!parts_.endEffector.empty() || like_)
        {
            const bool named = !parts_.endEffector.empty();
            tool_.endEffectorLink = findLink(tool_, named ? parts_.endEffector : like_->links()[like_->endEffectorLink()].name,
                                             filename_ + ": end effector");
            if (!named)
                tool_.link_T_endEffector = like_->endEffectorFromLinks(std::vector<Matx44d>(like_->links().size(), Matx44d::eye()));
            return;
        }
        std::vector<bool> ends(tool_.links.size(), true);
        for (size_t i = 0; i < ends.size(); i++)
            if (tool_.links[i].parent >= 0)
                ends[tool_.links[i].parent] = false;
        std::vector<int> all, still;
        for (int i = 0; i < (int)ends.size(); i++)
        {
            if (tool_.links[i].name == "tool_tip_link")
            {
                tool_.endEffectorLink = i;
                return;
            }
            if (!ends[i])
                continue;
            all.push_back(i);
            if (urdf_->getLink(tool_.links[i].name)->parent_joint->type == urdf::Joint::FIXED)
                still.push_back(i);
        }
        const std::vector<int>& candidates = still.empty() ? all : still;
        String names;
        for (size_t i = 0; i < candidates.size(); i++)
            names += (i ? ", " : "") + tool_.links[candidates[i]].name;
        if (candidates.size() != 1)
            fail("several links that nothing hangs on: " + names + "; expected the end effector to be named (endEffector), it may be any link", Error::StsBadArg);
        tool_.endEffectorLink = candidates[0];
    }

    String filename_;
    ToolParts parts_;
    urdf::ModelInterfaceSharedPtr urdf_;
    std::vector<String> order_;              // of the joints, in the file
    std::set<String> added_;                 // links
    std::map<String, String> replaced_;      // meshes, by link
    Ptr<ToolModel> like_;
    ToolModel::Description tool_;
    MeshFrames frames_;
};

} // namespace

Ptr<ToolModel> importUrdfTool(const String& filename, const ToolParts& parts)
{
    UrdfReader reader(filename, parts);
    ToolModel::Description tool = reader.read();
    addParts(parts, Matx33d::eye(), tool, reader.frames());
    return makeTool(filename, parts, tool);
}

#endif

}} // namespace cv::surgtrack
