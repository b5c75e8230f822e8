// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Makes a synthetic sequence: a folder as track_sequence takes it, with exact truth.

#include "opencv2/surgtrack.hpp"
#include "opencv2/surgtrack/lab.hpp"
#include "support/common.hpp"
#include "support/tools.hpp"

using namespace cv;
using namespace cv::surgtrack;

static const char* const KEYS =
    "{ help h           |     | print this }"
    "{ out              |     | folder to write; is made if it does not exist }"
    "{ tool             |     | tool file or URDF, or one of the built-in tools: needle_driver, which it is without this, curved_scissors }"
    "{ tools            | 1   | number of tools, 1 to 4 }"
    "{ frames           | 100 | number of frames }"
    "{ seed             | 1   | all that is random follows from it }"
    "{ width            | 720 | of the image [pixel] }"
    "{ height           | 576 | of the image [pixel] }"
    "{ fps              | 25  | frames a second }"
    "{ stereo           |     | write a right video too }"
    "{ distortion       |     | a lens with distortion }"
    "{ hand-eye-degrees | 3   | error of the recorded hand-eye calibration [degree] }"
    "{ hand-eye-mm      | 6   | the same [mm], at the tool }"
    "{ joint-noise      | 1   | scale of offsets and noise of the recorded joints; 0 = none }"
    "{ cables           | 1   | scale of their play, gains and coupling; 1 = as measured on a real arm, 0 = none }"
    "{ image-noise      | 3   | standard deviation of the image noise [grey levels] }"
    "{ quiet            |     | do not say what was written }";

static int make(const CommandLineParser& parser)
{
    const String folder = parser.get<String>("out"), tool = parser.get<String>("tool");
    if (folder.empty())
        common::fail("expected --out=DIR, see --help");
    SyntheticScene::Params params;
    params.tools = common::integer(parser, "tools", 1, 4);
    params.frames = common::integer(parser, "frames", 1);
    params.seed = common::integer(parser, "seed", 0);
    params.imageSize = Size(common::integer(parser, "width", 64, 8192), common::integer(parser, "height", 64, 8192));
    params.fps = common::number(parser, "fps", 0.1, 1000);
    params.stereo = parser.has("stereo");
    params.distortion = parser.has("distortion");
    params.handEyeRotation = common::number(parser, "hand-eye-degrees", 0, 45) * CV_PI / 180;
    params.handEyeTranslation = common::number(parser, "hand-eye-mm", 0, 100) * 1e-3;
    params.jointNoise = common::number(parser, "joint-noise", 0, 100);
    params.cables = common::number(parser, "cables", 0, 100);
    params.imageNoise = common::number(parser, "image-noise", 0, 100);

    const Ptr<ToolModel> model = common::anyTool(tool.empty() ? String("needle_driver") : tool);
    SyntheticScene::create(model, params)->write(folder);
    if (!parser.has("quiet"))
        std::printf("%s: %d frames of %dx%d, %d tool%s (%s)\n", folder.c_str(), params.frames, params.imageSize.width,
                    params.imageSize.height, params.tools, params.tools > 1 ? "s" : "", model->name().c_str());
    return 0;
}

int main(int argc, char** argv)
{
    const common::Program program = { "make_sequence", "Makes a synthetic sequence of surgical tools over tissue, with exact truth.",
                                      KEYS, { "out", "tool", "tools", "frames", "seed", "width", "height", "fps",
                                        "hand-eye-degrees", "hand-eye-mm", "joint-noise", "cables", "image-noise" },
                                      { "stereo", "distortion", "quiet" } };
    return common::runProgram(argc, argv, program, make);
}
