// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "track/render_ahead.hpp"

namespace cv { namespace surgtrack {

RenderAhead::RenderAhead(const Ptr<PartFinder>& finder, int tools) : finder_(finder), stop_(false)
{
    for (int i = 0; i < 3; i++) slots_[i].drawings.resize(tools);
    requests_[EARLIER] = requests_[NEWEST] = 0;
    thread_ = std::thread(&RenderAhead::run, this);
}

RenderAhead::~RenderAhead()
{
    {
        std::lock_guard<std::mutex> lock(mutex_);
        stop_ = true;
    }
    changed_.notify_all();
    thread_.join();
}

void RenderAhead::request(const std::vector<ToolView>& views)
{
    {
        std::lock_guard<std::mutex> lock(mutex_);
        drop(NEWEST);
        Slot* slot = slots_;
        while (slot == requests_[EARLIER] || slot->state == DRAWING) slot++;   // two of three at most
        slot->views = views;
        slot->error = std::exception_ptr();
        slot->state = QUEUED;
        requests_[NEWEST] = slot;
    }
    changed_.notify_all();
}

const std::vector<ToolView>* RenderAhead::stamp(Request which) const
{
    return requests_[which] ? &requests_[which]->views : 0;
}

const TemplateSet& RenderAhead::wait(Request which)
{
    std::unique_lock<std::mutex> lock(mutex_);
    Slot& slot = *requests_[which];
    while (slot.state != IDLE) changed_.wait(lock);
    if (slot.error)
    {
        drop(which);
        const std::exception_ptr error = slot.error;
        slot.error = std::exception_ptr();
        std::rethrow_exception(error);
    }
    return slot;
}

void RenderAhead::nextFrame()
{
    std::lock_guard<std::mutex> lock(mutex_);
    drop(EARLIER);
    std::swap(requests_[EARLIER], requests_[NEWEST]);
}

void RenderAhead::clear()
{
    std::lock_guard<std::mutex> lock(mutex_);
    drop(EARLIER);
    drop(NEWEST);
}

// The mutex is locked. A set that is being drawn is finished, for nobody.
void RenderAhead::drop(Request which)
{
    if (requests_[which] && requests_[which]->state == QUEUED) requests_[which]->state = IDLE;
    requests_[which] = 0;
}

RenderAhead::Slot* RenderAhead::nextJob()
{
    for (int i = 0; i < 2; i++)
        if (requests_[i] && requests_[i]->state == QUEUED) return requests_[i];
    return 0;
}

void RenderAhead::run()
{
    std::unique_lock<std::mutex> lock(mutex_);
    for (;;)
    {
        Slot* slot = 0;
        while (!stop_ && !(slot = nextJob())) changed_.wait(lock);
        if (stop_) return;
        slot->state = DRAWING;
        lock.unlock();
        try
        {
            for (size_t i = 0; i < slot->drawings.size(); i++)
            {
                PartDrawing& drawing = slot->drawings[i];
                if (slot->views[i].base_T_link.empty()) drawing.templates.clear();   // may be anywhere
                else finder_->draw(slot->views, int(i), drawing);
            }
        }
        catch (...)
        {
            slot->error = std::current_exception();
        }
        lock.lock();
        slot->state = IDLE;
        changed_.notify_all();
    }
}

}} // namespace cv::surgtrack
