// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_TRACK_TOOL_TRACKER_HPP
#define OPENCV_SURGTRACK_SRC_TRACK_TOOL_TRACKER_HPP

#include "track/render_ahead.hpp"
#include "track/tool_method.hpp"

namespace cv { namespace surgtrack {

//! Places all tools, lets the method of each measure it, reports.
class ToolTrackerImpl CV_FINAL : public ToolTracker
{
public:
    ToolTrackerImpl(const CameraModel& camera, const Params& params, const Stages& stages, const Ptr<MeshRenderer>& renderer);

    void setRightCamera(const CameraModel& right, const Matx44d& right_T_left) CV_OVERRIDE;
    int addTool(const Ptr<ToolModel>& model, const Matx44d& nominal_T_base) CV_OVERRIDE;
    void replaceTool(int tool, const Ptr<ToolModel>& model) CV_OVERRIDE;
    void removeTool(int tool) CV_OVERRIDE;
    void setHandEye(int tool, const Matx44d& nominal_T_base) CV_OVERRIDE;
    void moveCamera(const Matx44d& now_T_before) CV_OVERRIDE;
    void setMask(InputArray mask, int eye) CV_OVERRIDE;
    ReadingErrors readingErrors(int tool) const CV_OVERRIDE;
    void setReadingErrors(int tool, const ReadingErrors& errors) CV_OVERRIDE;
    void reset(int tool) CV_OVERRIDE;
    void update(InputArray image, double time, const std::vector<std::vector<double> >& joints, std::vector<ToolEstimate>& estimates) CV_OVERRIDE;
    void updateStereo(InputArray left, InputArray right, double time, const std::vector<std::vector<double> >& joints,
                      std::vector<ToolEstimate>& estimates) CV_OVERRIDE;
    void renderAhead(const std::vector<std::vector<double> >& joints) CV_OVERRIDE;
    ToolSight sight(int tool, int eye) const CV_OVERRIDE;
    std::vector<StageTime> getTimings() const CV_OVERRIDE { return scene_.times.get(); }
    void resetTimings() CV_OVERRIDE { scene_.times.reset(); }

private:
    //! A camera, and what draws for it.
    struct Camera
    {
        CameraModel model;
        Matx44d eye_T_camera;
        Mat mask;
    };

    void checkTool(int tool) const;
    void checkModel(const Ptr<ToolModel>& model) const;
    void checkJoints(const std::vector<std::vector<double> >& joints) const;
    void checkFrame(const Mat& image, size_t eye, const char* name, double time) const;
    Ptr<PartFinder> makeFinder(const Camera& camera, const std::vector<Ptr<ToolMethod> >& tools, const Ptr<MeshRenderer>& renderer) const;
    Ptr<ToolMethod> makeMethod(int index, const Ptr<ToolModel>& model, const Matx44d& nominal_T_base) const;
    void change(std::vector<Ptr<ToolMethod> > tools, std::vector<Camera> cameras);
    void updateEyes(const Mat* images, size_t count, double time, const std::vector<std::vector<double> >& joints, std::vector<ToolEstimate>& estimates);
    void show(int tool);
    void sortTools();
    Matx44d motionOfAnother(int tool) const;
    double shiftSince(const std::vector<ToolView>* drawn) const;
    const TemplateSet* drawnAhead();
    void report(int tool, ToolEstimate& estimate) const;

    Params params_;
    Stages stages_;
    Ptr<MeshRenderer> renderer_;       // of both eyes
    std::vector<Camera> cameras_;      // the left one first
    Rect2d field_;                     // of view, of the left eye
    std::vector<Ptr<ToolMethod> > tools_;
    std::vector<int> order_;           // in which they are measured
    Scene scene_;
    Ptr<RenderAhead> ahead_;           // made by the first renderAhead()
    std::vector<ToolView> aheadViews_;
};

}} // namespace cv::surgtrack

#endif
