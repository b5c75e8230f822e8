// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_TRACK_RENDER_AHEAD_HPP
#define OPENCV_SURGTRACK_SRC_TRACK_RENDER_AHEAD_HPP

#include "precomp.hpp"
#include "opencv2/surgtrack/part_templates.hpp"

#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>

namespace cv { namespace surgtrack {

//! Templates of all tools, with the views they are drawn from as their stamp.
struct TemplateSet
{
    std::vector<ToolView> views;
    std::vector<std::vector<PartTemplate> > templates;   // a tool
    std::vector<Rendering> renderings;                   // a tool; of whole tools only
};

/** Draws part templates in a thread of its own.

Its owner calls from one thread only. What it may use is told by the order of its calls alone, not by how far the drawing has
come: the last set requested in the current frame and the last one requested in the frame before. */
class RenderAhead
{
public:
    enum Request { EARLIER = 0, NEWEST = 1 };   // of the frame before, of this frame

    RenderAhead(const CameraModel& camera, const std::vector<Ptr<ToolModel> >& models, bool wholeTools = false);
    ~RenderAhead();

    //! Takes the place of an earlier request of this frame. Does not wait.
    void request(const std::vector<ToolView>& views);

    //! The stamp of a set, drawn or not; 0 if there was no request.
    const std::vector<ToolView>* stamp(Request which) const;

    //! Waits for a set. Throws what drawing it threw; the set is gone then.
    const TemplateSet& wait(Request which);

    //! The frame is done: its request is now the earlier one.
    void nextFrame();

    //! Drops both.
    void clear();

private:
    enum State { IDLE, QUEUED, DRAWING };

    struct Slot : TemplateSet
    {
        Slot() : state(IDLE) {}
        State state;
        std::exception_ptr error;
    };

    void run();
    Slot* nextJob();
    void drop(Request which);

    CameraModel camera_;
    Ptr<PartTemplateRenderer> renderer_;   // the thread's
    bool wholeTools_;
    Slot slots_[3];         // two requests, and one dropped while it is drawn
    Slot* requests_[2];
    bool stop_;
    std::mutex mutex_;      // states and requests; a slot that is drawn belongs to the thread
    std::condition_variable changed_;
    std::thread thread_;
};

}} // namespace cv::surgtrack

#endif
