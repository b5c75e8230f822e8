// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "files/joint_names.hpp"
#include "lab/import/import_tool.hpp"

#ifdef HAVE_NLOHMANN_JSON
#include "lab/import/import_json.hpp"
#endif

// importDvrkTool(): kinematics of sawIntuitiveResearchKit.

namespace cv { namespace surgtrack {

#ifndef HAVE_NLOHMANN_JSON

Ptr<ToolModel> importDvrkTool(const std::vector<String>&, const ToolParts&)
{
    CV_Error(Error::StsNotImplemented, "dVRK files are JSON with comments: the module was built without nlohmann_json, which reads them");
}

#else

namespace {

struct Joint : ToolModel::Link
{
    Joint() : limits(-DBL_MAX, DBL_MAX) {}
    Vec2d limits;   // of the coordinate
};

struct Chain
{
    Chain() : hasJaw(false), hasTip(false), tip(Matx44d::eye()) {}
    std::vector<Joint> joints;
    bool hasJaw, hasTip;
    Matx44d tip;                  // tooltip_offset
};

Joint readJoint(const JsonKey& key, const JsonKey& dh)
{
    // Old files state the convention of each link, later ones once.
    const String convention = key.has("convention") ? key["convention"].text() : dh["convention"].text();
    if (convention != "modified")
        key.fail("expected the convention `modified`, found `" + convention + "`");
    Joint joint;
    joint.name = key.has("name") ? key["name"].text() : String();
    const String type = key["type"].text();
    if (type != "revolute" && type != "prismatic")
        key["type"].fail("expected revolute or prismatic, found `" + type + "`");
    const bool passive = key.has("mode") && key["mode"].text() == "passive";   // no reading moves it
    joint.jointType = passive ? ToolModel::JOINT_FIXED : type == "revolute" ? ToolModel::JOINT_REVOLUTE : ToolModel::JOINT_PRISMATIC;
    const double offset = key.has("offset") ? key["offset"].number() : 0;
    const bool turns = type == "revolute";
    if (!passive && key.has("qmin") && key.has("qmax"))
    {
        joint.limits = Vec2d(key["qmin"].number(), key["qmax"].number());
    }
    joint.alpha = exactAngle(key["alpha"].number());
    joint.a = key["A"].number();
    joint.theta = exactAngle(key["theta"].number()) + (turns ? exactAngle(offset) : 0);
    joint.d = key["D"].number() + (turns ? 0 : offset);
    return joint;
}

void readFile(const String& filename, Chain& chain)
{
    if (chain.hasJaw || chain.hasTip)
        importError(filename, "comes after the instrument's file, which has jaw or tooltip_offset: expected the arm's file first");
    const JsonFile file(filename);
    const JsonKey root = file.root();
    if (root.has("snake_like") && root["snake_like"].boolean())
        root["snake_like"].fail("expected a wrist of two joints; a snake-like one bends several joints by one reading");
    const JsonKey dh = root["DH"], joints = dh[dh.has("links") ? "links" : "joints"];
    for (size_t i = 0; i < joints.size(); i++)
        chain.joints.push_back(readJoint(joints[i], dh));
    chain.hasJaw = chain.hasJaw || root.has("jaw");
    if (!root.has("tooltip_offset"))
        return;
    const JsonKey tip = root["tooltip_offset"];
    const char* expected = "expected a rigid 4x4 matrix: four rows of four numbers, translation in metres";
    if (tip.size() != 4)
        tip.fail(expected);
    for (int i = 0; i < 16; i++)
        chain.tip(i / 4, i % 4) = tip[i / 4].size() == 4 ? tip[i / 4][i % 4].number() : DBL_MAX;
    if (!isRigid(chain.tip))
        tip.fail(expected);
    chain.tip = nearestRigid(chain.tip);
    chain.hasTip = true;
}

//! Are all files there, and in their order? The dVRK's names tell.
void checkOrder(const Chain& chain, const std::vector<String>& files)
{
    String last;
    for (size_t i = 0; i < chain.joints.size(); i++)
    {
        const String key = jointKey(chain.joints[i].name);
        if (key.size() != 2 || key[0] != 'q' || key[1] < '1' || key[1] > '6')
            continue;
        if (last.empty() && key > "q3")
            importError(files[0], "the joints begin with `" + chain.joints[i].name + "`, as those of an instrument: expected the arm's file (PSM.json) "
                        "before it");
        if (!last.empty() && key <= last)
            importError(files.back(), "joint `" + chain.joints[i].name + "` comes too late: expected the arm's file first, then the instrument's, once each");
        last = key;
    }
}

void limit(const Joint& joint, int coordinate, ToolModel::Description& tool)
{
    if (joint.limits == Vec2d(-DBL_MAX, DBL_MAX) || coordinate < 0) return;
    tool.limits.resize(tool.coordinates.size(), Vec2d(-DBL_MAX, DBL_MAX));
    tool.limits[coordinate] = joint.limits;
}

void addJaw(const char* name, double scale, ToolModel::Description& tool)
{
    ToolModel::Link jaw;
    jaw.name = name;
    jaw.parent = (int)tool.endEffectorLink;
    jaw.jointType = ToolModel::JOINT_REVOLUTE;
    jaw.coordinate = (int)tool.coordinates.size() - 1;
    jaw.scale = scale;
    tool.links.push_back(jaw);
}

ToolModel::Description describe(const Chain& chain)
{
    ToolModel::Description tool;
    for (size_t i = 0; i < chain.joints.size(); i++)
    {
        tool.links.push_back(chain.joints[i]);
        ToolModel::Link& link = tool.links.back();
        link.parent = (int)i - 1;
        if (link.name.empty())
            link.name = format("link%d", (int)i + 1);
        if (link.jointType == ToolModel::JOINT_FIXED)
            continue;
        link.coordinate = (int)tool.coordinates.size();
        tool.coordinates.push_back(format("q%d", link.coordinate + 1));
    }
    tool.endEffectorLink = (int)tool.links.size() - 1;
    for (size_t i = 0; i < chain.joints.size(); i++) limit(chain.joints[i], tool.links[i].coordinate, tool);
    if (chain.hasJaw)
    {
        if (!tool.limits.empty()) tool.limits.push_back(Vec2d(-DBL_MAX, DBL_MAX));
        tool.coordinates.push_back("jaw");
        addJaw("jaw_right", 0.5, tool);
        addJaw("jaw_left", -0.5, tool);
    }
    return tool;
}

//! The tool of a tool file with its joints, from the base to the end effector, where the chain has them.
ToolModel::Description describeLike(const Chain& chain, const String& filename)
{
    const Ptr<ToolModel> model = ToolModel::load(filename, 0);
    ToolModel::Description tool;
    tool.coordinates = model->coordinateNames();
    tool.links = model->links();
    tool.meshes = model->meshes();
    tool.keypoints = model->keypoints();
    tool.endEffectorLink = model->endEffectorLink();
    tool.link_T_endEffector = model->endEffectorFromLinks(std::vector<Matx44d>(tool.links.size(), Matx44d::eye()));
    std::vector<int> path;
    for (int i = tool.endEffectorLink; i >= 0; i = tool.links[i].parent)
        path.insert(path.begin(), i);
    if (path.size() != chain.joints.size())
        importError(filename, format("%d links from the base to the end effector, expected %d, as many as the dVRK's files have joints",
                                     (int)path.size(), (int)chain.joints.size()));
    for (size_t i = 0; i < path.size(); i++)
    {
        ToolModel::Link& link = tool.links[path[i]];
        const Joint& joint = chain.joints[i];
        if (link.jointType != joint.jointType || link.scale != 1)
            importError(filename, format("link '%s' does not move as joint %d of the dVRK's files, expected a %s joint with scale 1",
                                         link.name.c_str(), (int)i + 1, joint.jointType == ToolModel::JOINT_REVOLUTE ? "revolute" : "prismatic"));
        link.alpha = joint.alpha;
        link.a = joint.a;
        link.theta = joint.theta;
        link.d = joint.d;
        limit(joint, link.coordinate, tool);
    }
    return tool;
}

} // namespace

Ptr<ToolModel> importDvrkTool(const std::vector<String>& files, const ToolParts& parts)
{
    Chain chain;
    for (size_t i = 0; i < files.size(); i++)
        readFile(files[i], chain);
    if (chain.joints.empty())
        CV_Error(Error::StsBadArg, "files: expected the kinematics of an arm and of an instrument");
    checkOrder(chain, files);
    ToolModel::Description tool = parts.like.empty() ? describe(chain) : describeLike(chain, parts.like);
    const String& last = files.back();
    const size_t start = last.find_last_of("/\\") + 1;
    tool.name = last.substr(start, last.find('.', start) - start);
    if (chain.hasTip)
    {
        const Matx44d given = tool.link_T_endEffector;
        tool.link_T_endEffector = chain.tip;
        const bool atOrigin = chain.tip(0, 3) == 0 && chain.tip(1, 3) == 0 && chain.tip(2, 3) == 0;
        for (int i = 0; i < 3 && atOrigin; i++)
            tool.link_T_endEffector(i, 3) = given(i, 3);
    }
    addParts(parts, parts.meshesInToolAxes ? chain.tip.get_minor<3, 3>(0, 0) : Matx33d::eye(), tool);
    return makeTool(files[0], parts, tool);
}

#endif

}} // namespace cv::surgtrack
