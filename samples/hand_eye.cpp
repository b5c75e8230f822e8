// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Hand-eye calibration from poses of the robot and poses, or images, of a calibration board.

#include "support/hand_eye_data.hpp"

using namespace hand_eye;

namespace {

const char* const KEYS =
    "{ help h        |        | print this }"
    "{ robot         |        | CSV file index,tx,ty,tz,qx,qy,qz,qw or time,...: base_T_tool of the instrument that holds the board, or base_T_arm of the arm that holds the camera [m] }"
    "{ board-poses   |        | CSV file of the same columns: camera_T_board }"
    "{ images        |        | instead: folder of board images; the number in an image's name is the index of its robot pose }"
    "{ board         | acircles | acircles: asymmetric grid of circles; chessboard }"
    "{ board-size    | 4x11   | circles a row x rows; inner corners of a chessboard }"
    "{ spacing-mm    | 1.5    | distance of two rows of circles, half of that of two circles in a row; side of a square }"
    "{ camera        |        | folder of a sequence, or camera calibration file of OpenCV; default: that of --into. Without one no errors in pixels }"
    "{ setup         | board-on-tool | board-on-tool: the instrument holds the board, the camera stands; camera-on-arm: an arm holds the camera, the board lies }"
    "{ method        | best   | best, tsai, park, horaud, andreff, daniilidis, shah, li, refined }"
    "{ rejection     | 3      | a pose is thrown out if its error is so many standard deviations; 0 = keep all }"
    "{ seed          | 1      | all that is random follows from it }"
    "{ into          |        | folder of a sequence: camera_T_base in its sequence.yaml is set }"
    "{ tool          |        | name of the tool it is set for }"
    "{ arm           |        | camera-on-arm, with --into: base_T_arm while the sequence was recorded, as tx,ty,tz,qx,qy,qz,qw }"
    "{ base          |        | the same: base of the instrument's arm in the base of the arm that holds the camera }"
    "{ force         |        | write into the sequence what does not fit, too }"
    "{ quiet         |        | no progress }";

const int mostPoses = 60;    // time grows with the square of their number; more add little

struct Options
{
    String robot, boardPoses, images, camera, into, tool;
    CalibrationBoard board;
    HandEyeParams params;
    Matx44d arm, cameraBase_T_base;    //!< with camera-on-arm
    bool force, quiet;
};

const double worstFit = 0.005, worstTurn = 5 * CV_PI / 180;    // [m], [rad] of poses left out: what is worse is warned of as no calibration

Matx44d readPose(const CommandLineParser& parser, const char* name)
{
    const String text = parser.get<String>(name);
    double v[7];
    char rest;
    if (std::sscanf(text.c_str(), "%lf,%lf,%lf,%lf,%lf,%lf,%lf%c", v, v + 1, v + 2, v + 3, v + 4, v + 5, v + 6, &rest) != 7)
        fail("argument '--" + String(name) + "=" + text + "': expected tx,ty,tz,qx,qy,qz,qw [m]");
    const double x = v[3], y = v[4], z = v[5], w = v[6];
    if (!(std::abs(std::sqrt(x * x + y * y + z * z + w * w) - 1) < 0.01) || !(norm(Vec3d(v)) < 10))
        fail("argument '--" + String(name) + "=" + text + "': expected metres and a unit quaternion");
    const double s = 2 / (x * x + y * y + z * z + w * w);
    return Matx44d(1 - s * (y * y + z * z), s * (x * y - z * w), s * (x * z + y * w), v[0],
                   s * (x * y + z * w), 1 - s * (x * x + z * z), s * (y * z - x * w), v[1],
                   s * (x * z - y * w), s * (y * z + x * w), 1 - s * (x * x + y * y), v[2], 0, 0, 0, 1);
}

CalibrationBoard readBoard(const CommandLineParser& parser)
{
    CalibrationBoard board;
    const String pattern = parser.get<String>("board"), size = parser.get<String>("board-size");
    if (pattern != "acircles" && pattern != "chessboard") fail("argument '--board=" + pattern + "': expected acircles or chessboard");
    board.pattern = pattern == "acircles" ? CalibrationBoard::ASYMMETRIC_CIRCLES : CalibrationBoard::CHESSBOARD;
    char rest;
    if (std::sscanf(size.c_str(), "%dx%d%c", &board.size.width, &board.size.height, &rest) != 2 || board.size.width > 100 || board.size.height > 100)
        fail("argument '--board-size=" + size + "': expected two numbers up to 100, such as 4x11");
    board.spacing = common::number(parser, "spacing-mm", 1e-3, 1e3) * 1e-3;
    try
    {
        Mat points;
        getBoardPoints(board, points);
    }
    catch (const Exception& e)
    {
        fail("argument '--board-size=" + size + "': " + e.err);
    }
    return board;
}

int readMethod(const String& text)
{
    String known;
    for (int method = HAND_EYE_BEST; method <= HAND_EYE_REFINED; method++)
    {
        if (text == handEyeMethodName(method)) return method;
        known += (known.empty() ? "" : ", ") + handEyeMethodName(method);
    }
    fail("argument '--method=" + text + "': expected one of " + known);
}

Options readOptions(const CommandLineParser& parser)
{
    Options options;
    options.robot = parser.get<String>("robot");
    options.boardPoses = parser.get<String>("board-poses");
    options.images = parser.get<String>("images");
    options.into = parser.get<String>("into");
    options.tool = parser.get<String>("tool");
    options.camera = parser.has("camera") ? parser.get<String>("camera") : options.into;
    options.board = readBoard(parser);
    options.params.method = readMethod(parser.get<String>("method"));
    options.params.rejection = common::number(parser, "rejection", 0, 1e6);
    options.params.seed = common::integer(parser, "seed", 0);
    options.force = parser.has("force");
    options.quiet = parser.has("quiet");
    const String setup = parser.get<String>("setup");
    if (setup != "board-on-tool" && setup != "camera-on-arm") fail("argument '--setup=" + setup + "': expected board-on-tool or camera-on-arm");
    options.params.setup = setup == "board-on-tool" ? HAND_EYE_BOARD_ON_TOOL : HAND_EYE_CAMERA_ON_ARM;
    if (options.robot.empty()) fail("expected --robot=CSV, see --help");
    if (options.boardPoses.empty() == options.images.empty()) fail("expected --board-poses=CSV or --images=DIR, one of them, see --help");
    if (!options.images.empty() && options.camera.empty()) fail("argument '--images': expected --camera=FILE or --into=DIR too, for the camera");
    if (options.into.empty() != options.tool.empty()) fail("expected --into=DIR and --tool=NAME, or neither");
    const bool arms = options.params.setup == HAND_EYE_CAMERA_ON_ARM && !options.into.empty();
    if (parser.has("arm") != arms || parser.has("base") != arms)
        fail(arms ? "argument '--into': with --setup=camera-on-arm expected --arm and --base too, see --help"
                  : "arguments '--arm' and '--base': expected with --setup=camera-on-arm and --into only");
    if (arms)
    {
        options.arm = readPose(parser, "arm");
        options.cameraBase_T_base = readPose(parser, "base");
    }
    return options;
}

void printResult(const Options& options, const Pairs& pairs, const HandEyeResult& result, bool pixels)
{
    const double degree = CV_PI / 180;
    std::printf("%d poses, %d thrown out; they turn by up to %.0f degrees, by %.0f about the second axis\n", (int)pairs.names.size(),
                (int)result.rejected.size(), result.largestRotation / degree, result.crossRotation / degree);
    for (size_t i = 0; i < result.rejected.size(); i++)
    {
        const double* r = result.residuals.ptr<double>(result.rejected[i]);
        std::printf("  thrown out: %s, off by %.2f mm and %.2f degrees\n", pairs.names[result.rejected[i]].c_str(), 1e3 * r[0], r[1] / degree);
    }
    std::printf("             residual              left out              standard deviation\n");
    std::printf("method        mm    deg   pixel     mm    deg   pixel     mm    deg\n");
    for (size_t i = 0; i < result.fits.size(); i++)
    {
        const HandEyeFit& f = result.fits[i];
        const String name = handEyeMethodName(f.method);
        if (!f.valid)
        {
            std::printf("%-10s  no answer\n", name.c_str());
            continue;
        }
        const String in = pixels ? format("%7.2f", f.pixels) : String("      -"), out = pixels ? format("%7.2f", f.leftOutPixels) : String("      -");
        std::printf("%-10s%6.2f %6.3f %s %6.2f %6.3f %s %6.2f %6.3f%s\n", name.c_str(), 1e3 * f.translation, f.rotation / degree, in.c_str(),
                    1e3 * f.leftOutTranslation, f.leftOutRotation / degree, out.c_str(), 1e3 * f.spreadTranslation, f.spreadRotation / degree,
                    f.method == result.best.method ? options.params.method == HAND_EYE_BEST ? "  <- best" : "  <- chosen" : "");
    }
    const bool onTool = options.params.setup == HAND_EYE_BOARD_ON_TOOL;
    const Matx44d& T = result.best.camera_T_mount;
    std::printf("%s:\n", onTool ? "camera_T_base" : "camera_T_arm");
    for (int i = 0; i < 4; i++) std::printf("  %12.9f %12.9f %12.9f %12.9f\n", T(i, 0), T(i, 1), T(i, 2), T(i, 3));
    std::fflush(stdout);
    for (size_t i = 0; i < result.warnings.size(); i++) std::fprintf(stderr, "warning: %s\n", result.warnings[i].c_str());
}

int run(const CommandLineParser& parser)
{
    const Options options = readOptions(parser);
    const CameraModel camera = options.camera.empty() ? CameraModel() : readCamera(options.camera);
    const bool fromImages = !options.images.empty();
    const Poses robot = loadPoses(options.robot);
    if (fromImages && robot.byTime) fail(options.robot + ": has a column 'time', expected 'index' as images have");
    const Poses board = fromImages ? findBoards(options.images, camera, options.board, options.quiet) : loadPoses(options.boardPoses);
    Pairs pairs = pair(robot, board, options.robot, fromImages ? options.images : options.boardPoses);
    const int all = (int)pairs.names.size();
    thin(pairs, mostPoses);
    if ((int)pairs.names.size() < all) std::printf("%d of %d poses are used, evenly spread\n", (int)pairs.names.size(), all);

    Mat points;
    getBoardPoints(options.board, points);
    HandEyeResult result;
    if (!estimateHandEye(pairs.robot, pairs.board, result, options.params, camera, points))
        fail("the calibration can't be told: " + result.reason);
    printResult(options, pairs, result, !camera.imageSize().empty());
    if (options.into.empty()) return 0;
    if (!options.force && !(result.best.leftOutTranslation < worstFit && result.best.leftOutRotation < worstTurn))
        fail(options.into + ": is left as it was: poses that are off by more than 5 mm or 5 degrees are no calibration; are robot poses "
             "base_T_tool, not their inverse, and in metres? --force writes it all the same");
    const bool onTool = options.params.setup == HAND_EYE_BOARD_ON_TOOL;
    const Matx44d& T = result.best.camera_T_mount;
    writeHandEye(options.into, options.tool, onTool ? T : T * options.arm.inv() * options.cameraBase_T_base);
    std::printf("%s: camera_T_base of %s is set\n", options.into.c_str(), options.tool.c_str());
    return 0;
}

} // namespace

int main(int argc, char** argv)
{
    const common::Program program = { "hand_eye", "Hand-eye calibration: the camera against the robot, from poses of the robot and of a calibration board.",
                                      KEYS, { "robot", "board-poses", "images", "board", "board-size", "spacing-mm", "camera", "setup", "method",
                                        "rejection", "seed", "into", "tool", "arm", "base" }, { "force", "quiet" } };
    return common::runProgram(argc, argv, program, run);
}
