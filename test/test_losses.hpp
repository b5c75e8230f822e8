// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Seeded trials in which a tool is lost and comes back: what becomes of them.

#ifndef OPENCV_SURGTRACK_TEST_LOSSES_HPP
#define OPENCV_SURGTRACK_TEST_LOSSES_HPP

#include "test_loss_trial.hpp"

namespace opencv_test { namespace {

// What trials of one kind add up to.
struct LossFigures
{
    LossFigures() : trials(0), started(0), flagged(0), recovered(0), silent(0), blind(0), alarms(0), visible(0), disturbed(0), beside(0) {}
    int trials;
    int started;               // the tool was tracked, and rightly, before it was lost
    int flagged;               // within 5 frames of the loss not `tracking` any more, or right
    int recovered;             // within 10 frames of the tool's return `tracking`, and right
    int silent;                // frames: `tracking` more than 5 mm off, but for the 5 frames of grace
    int blind;                 // frames: `tracking` though the image shows nothing, after the 5 frames of grace
    int alarms, visible;       // frames: not `tracking`, of those with the tool plainly visible and known
    int disturbed, beside;     // frames: the other tool wrong or not `tracking`, of those with it plainly visible during the loss and after
    std::vector<int> delays;   // frames from the return to the recovery
    std::vector<int> failed;   // seeds
};

inline String traceLine(const LossTrial& trial, int frame, int tool, const ToolEstimate& e)
{
    const Matx44d truth = trial.truePose(frame, tool);
    const Matx66d& P = e.covariance;
    return format("%3d %c tool %d %-12s %6.2f mm %.3f rad  sigma %5.2f mm %.3f rad  sight %2d parts %2d inliers %2d similarity %.2f contour %.2f nis %.2f\n", frame,
                  frame < trial.begin() ? '-' : frame < trial.end() ? 'x' : '+', tool, stateName(e.state).c_str(),
                  distance(e.camera_T_tool, truth) * 1e3, rotationAngle(e.camera_T_tool, truth), std::sqrt(P(3, 3) + P(4, 4) + P(5, 5)) * 1e3,
                  std::sqrt(P(0, 0) + P(1, 1) + P(2, 2)), trial.keypointsInSight(frame, tool), e.visibleParts, e.inliers, e.similarity, e.contourSupport, e.nis);
}

inline void runTrial(Loss loss, int seed, Size size, LossFigures& figures)
{
    LossTrial trial(loss, seed, size);
    const int tools = trial.scene().toolCount(), begin = trial.begin(), end = trial.end(), victim = trial.victim();
    ToolTracker::Params params;
    params.method = METHOD_FULL;
    Ptr<ToolTracker> tracker = ToolTracker::create(trial.scene().camera(), params);
    for (int i = 0; i < tools; i++) tracker->addTool(trial.scene().model(), trial.scene().nominal_T_base(i));

    const LossFigures before = figures;
    bool started = false, flagged = loss == LOSS_NONE;
    std::vector<uchar> known(tools, false);   // started, and not lost since
    int recovery = -1;
    String trace;
    for (int frame = 0; frame < trial.frames(); frame++)
    {
        Mat image;
        Estimates estimates;
        trial.render(frame, image);
        tracker->update(image, trial.time(frame), trial.joints(frame), estimates);
        for (int i = 0; i < tools; i++)
        {
            const bool tracking = estimates[i].state == STATE_TRACKING;
            const bool right = distance(estimates[i].camera_T_tool, trial.truePose(frame, i)) <= RIGHT_POSE;
            trace += traceLine(trial, frame, i, estimates[i]);
            const bool lost = i == victim && frame >= begin;
            if (lost && frame < begin + FLAG_FRAMES) flagged = flagged || !tracking || right;
            else
            {
                figures.silent += tracking && !right;
                figures.blind += tracking && trial.showsNothing(frame);
            }
            if (i == victim && frame == std::min(begin, LEAD_FRAMES) - 1) started = tracking && right;
            if (i == victim && frame == begin) known[i] = false;
            const bool plain = known[i] && trial.plainlyVisible(frame, i);
            if (i != victim && frame >= begin)
            {
                figures.beside += plain;
                figures.disturbed += plain && !(tracking && right);
            }
            else
            {
                figures.visible += plain;
                figures.alarms += plain && !tracking;
            }
            if (lost && frame >= end && recovery < 0 && tracking && right) recovery = frame;
            known[i] = known[i] || (tracking && (!lost || recovery >= 0));
        }
    }
    const bool recovered = loss == LOSS_NONE || (recovery >= 0 && recovery < end + RECOVERY_FRAMES);
    figures.trials++;
    figures.started += started;
    figures.flagged += flagged;
    figures.recovered += recovered;
    if (recovery >= 0) figures.delays.push_back(recovery - end + 1);
    const bool failed = !started || !flagged || !recovered || figures.silent > before.silent || figures.blind > before.blind || figures.disturbed > before.disturbed;
    if (failed) figures.failed.push_back(seed);
    if (failed && std::getenv("SURGTRACK_TEST_PRINT"))
        std::cout << lossName(loss) << ", seed " << seed << (started ? "" : ", not started") << (flagged ? "" : ", not flagged")
                  << (recovered ? "" : ", not recovered") << ", silent frames " << figures.silent - before.silent << std::endl << trace;
}

inline void printFigures(Loss loss, const LossFigures& f)
{
    std::vector<int> delays = f.delays;
    std::sort(delays.begin(), delays.end());
    std::cout << format("%-10s %6s %7s %7s %9s %12s %6s %5s %16s %13s  failed seeds", "loss", "trials", "started", "flagged", "recovered",
                        "after frames", "silent", "blind", "false alarms", "disturbed") << std::endl
              << format("%-10s %6d %7d %7d %9d %6d (< %2d) %6d %5d %5d %5d %4.1f%% %6d %6d ", lossName(loss), f.trials, f.started, f.flagged, f.recovered,
                        delays.empty() ? 0 : delays[delays.size() / 2], delays.empty() ? 0 : delays.back() + 1, f.silent, f.blind, f.alarms, f.visible,
                        100. * f.alarms / std::max(1, f.visible), f.disturbed, f.beside);
    for (int seed : f.failed) std::cout << " " << seed;
    std::cout << std::endl;
}

}} // namespace

#endif
