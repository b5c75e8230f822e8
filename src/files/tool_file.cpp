// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/core/utils/filesystem.hpp"
#include "files/mesh_io.hpp"
#include "files/node_reader.hpp"
#include "files/text_file.hpp"
#include "model/mesh.hpp"

// ToolModel::load() and save(): the tool file of doc/formats.md.

namespace cv { namespace surgtrack {

namespace {

const char* const JOINT_NAMES[] = { "fixed", "revolute", "prismatic" };

int indexOf(const std::vector<String>& names, const String& name)
{
    const std::vector<String>::const_iterator it = std::find(names.begin(), names.end(), name);
    return it == names.end() ? -1 : (int)(it - names.begin());
}

//! Reads node.text() as a name that is not yet among the names.
String newName(const NodeReader& node, const std::vector<String>& names)
{
    const String name = node.text();
    if (indexOf(names, name) >= 0)
        node.fail("expected a name of its own, `" + name + "` is taken");
    return name;
}

//! Reads node.text() as one of the names. @return its index
int knownName(const NodeReader& node, const std::vector<String>& names, const char* what)
{
    const int index = indexOf(names, node.text());
    if (index < 0)
        node.fail(String("expected the name of ") + what + ", found `" + node.text() + "`");
    return index;
}

// How wrong readings may be.
struct Deviation
{
    double ToolModel::Link::*value;
    const char* key;
    bool turns;    // of joints that turn
};
const Deviation DEVIATIONS[] = { { &ToolModel::Link::offsetDeviation, "offset_deviation", false }, { &ToolModel::Link::gainDeviation, "gain_deviation", true },
                                 { &ToolModel::Link::playDeviation, "play_deviation", true },
                                 { &ToolModel::Link::couplingDeviation, "coupling_deviation", true } };

ToolModel::Link parseLink(const NodeReader& node, const std::vector<String>& coordinates)
{
    node.map({ "name", "parent", "joint", "mdh", "mesh", "link_T_mesh" });
    ToolModel::Link link;
    link.name = node["name"].text();

    const NodeReader joint = node["joint"].map({ "type", "coordinate", "scale", "offset_deviation", "gain_deviation", "play_deviation", "coupling_deviation" });
    const String type = joint["type"].text();
    link.jointType = type == "fixed" ? ToolModel::JOINT_FIXED : type == "revolute" ? ToolModel::JOINT_REVOLUTE : ToolModel::JOINT_PRISMATIC;
    if (type != JOINT_NAMES[link.jointType])
        joint["type"].fail("expected revolute, prismatic or fixed, found `" + type + "`");
    if (link.jointType == ToolModel::JOINT_FIXED)
        node["joint"].map({ "type" });
    else
        link.coordinate = knownName(joint["coordinate"], coordinates, "a coordinate");
    if (joint.has("scale"))
        link.scale = joint["scale"].number();
    for (const Deviation& d : DEVIATIONS)
    {
        if (!joint.has(d.key))
            continue;
        link.*d.value = joint[d.key].number();
        if (link.*d.value < 0)
            joint[d.key].fail("expected a number of at least 0; without the key it is the default");
        if (d.turns && link.jointType != ToolModel::JOINT_REVOLUTE)
            joint[d.key].fail("expected none, as the joint does not turn");
    }

    const NodeReader mdh = node["mdh"].map({ "alpha", "a", "theta", "d" });
    link.alpha = mdh["alpha"].number();
    link.a = mdh["a"].number();
    link.theta = mdh["theta"].number();
    link.d = mdh["d"].number();
    return link;
}

/* The order in which every link comes after its parent; else that of the file. */
std::vector<int> parentsFirst(const std::vector<NodeReader>& nodes, const std::vector<String>& names)
{
    std::vector<int> order, parents;
    std::vector<bool> placed(nodes.size(), false);
    for (size_t i = 0; i < nodes.size(); ++i)
    {
        const NodeReader parent = nodes[i]["parent"];
        parents.push_back(parent.text() == "base" ? -1 : knownName(parent, names, "a link or `base`"));
    }
    while (order.size() < nodes.size())
    {
        const size_t before = order.size();
        for (size_t i = 0; i < nodes.size(); ++i)
            if (!placed[i] && (parents[i] < 0 || placed[parents[i]]))
            {
                placed[i] = true;
                order.push_back((int)i);
            }
        if (order.size() == before)
        {
            const size_t i = std::find(placed.begin(), placed.end(), false) - placed.begin();
            nodes[i]["parent"].fail("expected a tree of links that ends at `base`, found a cycle");
        }
    }
    return order;
}

double longestSide(const Mesh& mesh)
{
    Point3f low = mesh.vertices[0], high = low;
    for (size_t i = 0; i < mesh.vertices.size(); ++i)
    {
        const Point3f& v = mesh.vertices[i];
        low = Point3f(std::min(low.x, v.x), std::min(low.y, v.y), std::min(low.z, v.z));
        high = Point3f(std::max(high.x, v.x), std::max(high.y, v.y), std::max(high.z, v.z));
    }
    return std::max(high.x - low.x, std::max(high.y - low.y, high.z - low.z));
}

/* Meshes of all links, decimated together. */
void parseMeshes(const std::vector<NodeReader>& nodes, const std::vector<int>& order, double scale, int maxTriangles,
                 ToolModel::Description& tool)
{
    std::vector<NodeReader> meshNodes;
    std::vector<String> paths;
    std::vector<Matx44d> link_T_mesh;
    for (size_t i = 0; i < order.size(); ++i)
    {
        const NodeReader& node = nodes[order[i]];
        if (!node.has("mesh") && !node.has("link_T_mesh"))
            continue;
        meshNodes.push_back(node["mesh"]);
        paths.push_back(node["mesh"].path());
        link_T_mesh.push_back(node.has("link_T_mesh") ? node["link_T_mesh"].rigid() : Matx44d::eye());
        tool.links[i].mesh = (int)meshNodes.size() - 1;
    }
    tool.meshes.resize(meshNodes.size());
    for (size_t i = 0; i < meshNodes.size(); ++i)
    {
        try
        {
            tool.meshes[i] = readMesh(paths[i], scale, link_T_mesh[i]);
        }
        catch (const cv::Exception& e)
        {
            meshNodes[i].fail(e.err, (Error::Code)e.code);
        }
        const double length = longestSide(tool.meshes[i]);
        if (length > 10)   // [m]; in millimetres most are
            meshNodes[i].fail(format("it is %.4g m long, expected metres: is mesh_scale right, 0.001 for a file in millimetres?", length));
    }
    if (maxTriangles)
        decimateMeshes(tool.meshes, maxTriangles);
    parallel_for_(Range(0, (int)tool.meshes.size()), [&](const Range& range)
    {
        for (int i = range.start; i < range.end; ++i)
            computeNormals(tool.meshes[i]);
    });
}

//! How far joints go; without lower or upper there is no limit on that side.
void parseLimits(const NodeReader& root, ToolModel::Description& tool)
{
    if (!root.has("limits"))
        return;
    tool.limits.assign(tool.coordinates.size(), Vec2d(-DBL_MAX, DBL_MAX));
    const std::vector<NodeReader> nodes = root["limits"].sequence();
    for (size_t i = 0; i < nodes.size(); ++i)
    {
        nodes[i].map({ "coordinate", "lower", "upper" });
        Vec2d& limits = tool.limits[knownName(nodes[i]["coordinate"], tool.coordinates, "a coordinate")];
        if (nodes[i].has("lower"))
            limits[0] = nodes[i]["lower"].number();
        if (nodes[i].has("upper"))
            limits[1] = nodes[i]["upper"].number();
        if (!(limits[0] <= limits[1]))
            nodes[i].fail(format("expected lower and upper in this order, found %g and %g", limits[0], limits[1]));
    }
}

void parseLinks(const NodeReader& root, int maxTriangles, ToolModel::Description& tool)
{
    const std::vector<NodeReader> nodes = root["links"].sequence();
    std::vector<ToolModel::Link> links;
    std::vector<String> names;
    for (size_t i = 0; i < nodes.size(); ++i)
    {
        links.push_back(parseLink(nodes[i], tool.coordinates));
        if (links[i].name == "base")
            nodes[i]["name"].fail("expected another name, `base` is what the first link hangs on");
        names.push_back(newName(nodes[i]["name"], names));
    }
    const std::vector<int> order = parentsFirst(nodes, names);
    names.clear();
    for (size_t i = 0; i < order.size(); ++i)
    {
        tool.links.push_back(links[order[i]]);
        tool.links[i].parent = indexOf(names, nodes[order[i]]["parent"].text());
        names.push_back(tool.links[i].name);
    }

    const NodeReader endEffector = root["end_effector"].map({ "link", "link_T_end_effector" });
    tool.endEffectorLink = knownName(endEffector["link"], names, "a link");
    tool.link_T_endEffector = endEffector["link_T_end_effector"].rigid();

    const std::vector<NodeReader> keypoints = root["keypoints"].sequence();
    std::vector<String> keypointNames;
    for (size_t i = 0; i < keypoints.size(); ++i)
    {
        keypoints[i].map({ "name", "link", "position", "score" });
        const NodeReader position = keypoints[i]["position"];
        const std::vector<NodeReader> xyz = position.sequence();
        if (xyz.size() != 3)
            position.fail(format("expected three numbers, found %d", (int)xyz.size()));
        ToolModel::Keypoint keypoint;
        keypoint.name = newName(keypoints[i]["name"], keypointNames);
        keypoint.link = knownName(keypoints[i]["link"], names, "a link");
        keypoint.linkPoint = Point3d(xyz[0].number(), xyz[1].number(), xyz[2].number());
        if (keypoints[i].has("score"))
            keypoint.score = keypoints[i]["score"].number();
        if (keypoints[i].has("score") && !(keypoint.score >= 0 && keypoint.score <= 1))
            keypoints[i]["score"].fail("expected a number from 0 to 1");
        keypointNames.push_back(keypoint.name);
        tool.keypoints.push_back(keypoint);
    }

    const double scale = root.has("mesh_scale") ? root["mesh_scale"].number() : 1;
    if (scale <= 0)
        root["mesh_scale"].fail("expected a positive number of metres per unit of the mesh files");
    parseMeshes(nodes, order, scale, maxTriangles, tool);
}

void writeLimits(FileStorage& file, const ToolModel::Description& tool)
{
    if (tool.limits.empty())
        return;
    file << "limits" << "[";
    for (size_t i = 0; i < tool.limits.size(); ++i)
    {
        file << "{:" << "coordinate" << tool.coordinates[i];
        if (tool.limits[i][0] > -DBL_MAX)
            file << "lower" << tool.limits[i][0];
        if (tool.limits[i][1] < DBL_MAX)
            file << "upper" << tool.limits[i][1];
        file << "}";
    }
    file << "]";
}

} // namespace

Ptr<ToolModel> createTool(const String& filename, const ToolModel::Description& tool)
{
    try
    {
        return ToolModel::create(tool);
    }
    catch (const Exception& e)
    {
        importError(filename, e.err);
    }
}

Ptr<ToolModel> ToolModel::load(const String& filename, int maxTriangles)
{
    CV_CheckGE(maxTriangles, 0, "maxTriangles: 0 keeps all");
    const FileStorage storage = openStorage(filename);
    const NodeReader root(filename, storage.root());
    root.map({ "name", "coordinates", "limits", "mesh_scale", "links", "end_effector", "keypoints" });
    Description tool;
    tool.name = root["name"].text();
    const std::vector<NodeReader> coordinates = root["coordinates"].sequence();
    for (size_t i = 0; i < coordinates.size(); ++i)
        tool.coordinates.push_back(newName(coordinates[i], tool.coordinates));
    parseLimits(root, tool);
    parseLinks(root, maxTriangles, tool);
    return createTool(filename, tool);
}

void ToolModel::save(const String& filename) const
{
    const String folder = utils::fs::join(utils::fs::getParent(filename), "meshes");
    if (!description_.meshes.empty() && !utils::fs::createDirectories(folder))
        CV_Error(Error::StsError, folder + ": cannot be made");
    const size_t slash = filename.find_last_of("/\\");
    const String base = slash == String::npos ? filename : filename.substr(slash + 1), stem = base.substr(0, base.find('.'));
    for (size_t i = 0; i < description_.meshes.size(); ++i)
        writePLY(utils::fs::join(folder, format("%s_%d.ply", stem.c_str(), (int)i)), description_.meshes[i]);

    FileStorage file = newStorage(filename);
    file << "name" << description_.name << "coordinates" << "[:";
    for (size_t i = 0; i < description_.coordinates.size(); ++i)
        file << description_.coordinates[i];
    file << "]";
    writeLimits(file, description_);
    file << "mesh_scale" << 1 << "links" << "[";
    for (size_t i = 0; i < description_.links.size(); ++i)
    {
        const Link& link = description_.links[i];
        file << "{" << "name" << link.name << "parent" << (link.parent < 0 ? String("base") : description_.links[link.parent].name);
        file << "joint" << "{:" << "type" << JOINT_NAMES[link.jointType];
        if (link.jointType != JOINT_FIXED)
            file << "coordinate" << description_.coordinates[link.coordinate] << "scale" << link.scale;
        for (const Deviation& d : DEVIATIONS)
            if (link.*d.value >= 0)
                file << d.key << link.*d.value;
        file << "}" << "mdh" << "{:" << "alpha" << link.alpha << "a" << link.a << "theta" << link.theta << "d" << link.d << "}";
        if (link.mesh >= 0)
            file << "mesh" << format("meshes/%s_%d.ply", stem.c_str(), link.mesh);
        file << "}";
    }
    file << "]" << "end_effector" << "{" << "link" << description_.links[description_.endEffectorLink].name;
    file << "link_T_end_effector" << Mat(description_.link_T_endEffector) << "}" << "keypoints" << "[";
    for (size_t i = 0; i < description_.keypoints.size(); ++i)
    {
        const Keypoint& k = description_.keypoints[i];
        file << "{:" << "name" << k.name << "link" << description_.links[k.link].name << "position" << "[:";
        file << k.linkPoint.x << k.linkPoint.y << k.linkPoint.z << "]";
        if (k.score >= 0)
            file << "score" << k.score;
        file << "}";
    }
    file << "]";
    writeContent(filename, file.releaseAndGetString());
}

}} // namespace cv::surgtrack
