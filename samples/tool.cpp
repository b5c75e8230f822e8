// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Says what a tool file or an URDF holds, checks it, and draws what a person checks it by.

#include "opencv2/imgcodecs.hpp"
#include "opencv2/surgtrack.hpp"
#include "opencv2/surgtrack/lab.hpp"
#include "support/common.hpp"
#include "support/tools.hpp"

using namespace cv;
using namespace cv::surgtrack;

static const char* const KEYS =
    "{ help h |      | print this }"
    "{ tool   |      | tool file or URDF; needle_driver and curved_scissors are those built in }"
    "{ out    |      | picture to write; without it NAME.png here }"
    "{ quiet  |      | say only what is wrong }";

static void describe(const ToolModel& model)
{
    const Mat_<double> limits = model.jointLimits();
    const std::vector<double> wrong = model.offsetDeviations();
    std::printf("%s\n", model.name().c_str());
    for (int c = 0; c < limits.rows; c++)
    {
        const bool known = limits(c, 0) > -DBL_MAX && limits(c, 1) < DBL_MAX;
        std::printf("  coordinate %-14s %s%s\n", model.coordinateNames()[c].c_str(),
                    known ? format("%8.4g to %8.4g", limits(c, 0), limits(c, 1)).c_str() : "no limits known     ",
                    wrong[c] > 0 ? format(", read with an offset of %g or so", wrong[c]).c_str() : "");
    }
    for (size_t i = 0; i < model.links().size(); i++)
    {
        const ToolModel::Link& link = model.links()[i];
        if (link.mesh < 0)
            continue;
        int keypoints = 0;
        for (size_t k = 0; k < model.keypoints().size(); k++)
            keypoints += model.keypoints()[k].link == (int)i;
        const Mesh& mesh = model.meshes()[link.mesh];
        Mat low, high;
        const Mat vertices = Mat(mesh.vertices).reshape(1, (int)mesh.vertices.size());
        reduce(vertices, low, 0, REDUCE_MIN);
        reduce(vertices, high, 0, REDUCE_MAX);
        const Mat_<float> size = high - low;
        std::printf("  link %-20s %6d triangles, %.1f x %.1f x %.1f mm, %d keypoints\n", link.name.c_str(), (int)mesh.triangles.size(), 1e3 * size(0), 1e3 * size(1),
                    1e3 * size(2), keypoints);
    }
    std::printf("  end effector on link %s\n", model.linkNames()[model.endEffectorLink()].c_str());
}

static int run(const CommandLineParser& parser)
{
    const String file = parser.get<String>("tool");
    if (file.empty())
        common::fail("expected a tool file or an URDF, see --help");
    const Ptr<ToolModel> model = common::anyTool(file);
    if (!parser.has("quiet"))
        describe(*model);
    const std::vector<String> findings = checkTool(model);
    for (size_t i = 0; i < findings.size(); i++)
        std::printf("%s: %s\n", file.c_str(), findings[i].c_str());
    Mat sheet;
    drawToolSheet(model, sheet);
    const String out = parser.get<String>("out").empty() ? model->name() + ".png" : parser.get<String>("out");
    bool written = false;
    try
    {
        written = imwrite(out, sheet);
    }
    catch (const cv::Exception&)
    {
    }
    if (!written)
        common::fail(out + ": can't be written, expected the name of a picture");
    if (!parser.has("quiet"))
        std::printf("%s: the tool from six sides at three settings of its joints\n", out.c_str());
    return findings.empty() ? 0 : 1;
}

int main(int argc, char** argv)
{
    const common::Program program = { "tool", "Says what a tool file or an URDF holds, checks it and draws it from all sides.", KEYS, { "tool", "out" }, { "quiet" } };
    // FILE by itself is --tool=FILE.
    std::vector<std::string> words(argv, argv + argc);
    std::vector<char*> arguments;
    for (int i = 0; i < argc; i++)
    {
        if (i > 0 && !words[i].empty() && words[i][0] != '-')
            words[i] = "--tool=" + words[i];
        arguments.push_back(&words[i][0]);
    }
    return common::runProgram(argc, &arguments[0], program, run);
}
