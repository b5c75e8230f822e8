// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_TRACK_SCENE_HPP
#define OPENCV_SURGTRACK_SRC_TRACK_SCENE_HPP

#include "opencv2/surgtrack/contour.hpp"
#include "opencv2/surgtrack/part_finder.hpp"
#include "track/evidence.hpp"
#include "track/stage_times.hpp"

namespace cv { namespace surgtrack {

//! What one eye saw of one tool in a frame.
struct Sight
{
    Sight() : cut(0), drawn(0), drawnAhead(false) {}

    PartDrawing drawing, redrawn;    // redrawn: for its outline alone
    const PartDrawing* cut;          // whose templates were looked for: `drawing`, or what was drawn ahead
    const PartDrawing* drawn;        // where the tool was drawn last
    bool drawnAhead;                 // `cut` was
    FoundParts found;
    std::vector<ContourPoint> outline;
};

//! What a tool's method needs of the frame, beside what it knows of its own tool.
struct Scene
{
    Scene() : open(0), time(-DBL_MAX), cameraMotion(Matx44d::eye()), cameraStep(Matx44d::eye()) {}

    std::vector<Ptr<PartFinder> > eyes;   // the left one first
    size_t open;                          // of them have an image of this frame
    std::vector<ToolView> views;          // of all tools, in the left camera's frame; one that may be anywhere has no link poses
    double time;                          // of the frame [s]
    Matx44d cameraMotion;                 // since its calibration, as another tool saw it; unit if it saw none
    Matx44d cameraStep;                   // since the frame before, as the surest tool saw it in this one; unit if it was not tracked
    Ptr<GeometricContextVerifier> verifier, startVerifier;   // the first pose needs more points to agree
    StageTimes times;

    const CameraModel& camera() const { return eyes[0]->camera(); }

    /** Draws a tool, and what hides it, for an eye.
    @param view of the tool; alone: see PartFinder::draw() */
    void draw(size_t eye, int tool, const ToolView& view, PartDrawing& drawing, double scale = 1, double rotation = 0, bool alone = false)
    {
        StageTimer timer(times, RENDER);
        views[tool] = view;
        eyes[eye]->draw(views, tool, drawing, scale, rotation, alone);
    }

    void find(size_t eye, const PartDrawing& drawing, const PartWindows& windows, bool starting, FoundParts& found)
    {
        eyes[eye]->find(drawing, windows, starting ? *startVerifier : *verifier, found);
        times.add(IMAGE, found.imageTime);
        times.add(MATCH, found.matchTime);
        times.add(VERIFY, found.verifyTime);
    }
};

}} // namespace cv::surgtrack

#endif
