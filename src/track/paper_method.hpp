// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_TRACK_PAPER_METHOD_HPP
#define OPENCV_SURGTRACK_SRC_TRACK_PAPER_METHOD_HPP

#include "opencv2/surgtrack/tool_pose_ekf.hpp"
#include "track/tool_method.hpp"

namespace cv { namespace surgtrack {

//! What the paper's methods know from frame to frame, beside their filter.
struct PaperMemory
{
    ToolView view_;
    Matx44d trusted_;                      // the last correction that was tracked; what an unconfirmed one goes back to
    int hypothesis_;                       // of the search for a lost tool
    int attempts_;                         // at a first pose
};

//! METHOD_PAPER and METHOD_EPNP: parts of the left eye, into the paper's filter or into EPnP.
class PaperMethod CV_FINAL : public ToolMethod, private PaperMemory
{
public:
    PaperMethod(int index, const Ptr<ToolModel>& model, const Matx44d& nominal_T_base, const ToolTracker::Params& params, double pixelScale,
                const CameraModel& camera, const ToolPoseEKF::Params& filter);

    void reset() CV_OVERRIDE;
    void takeBack() CV_OVERRIDE;
    void measure(Scene& scene, const PartDrawing* ahead) CV_OVERRIDE;
    const ToolView& view() const CV_OVERRIDE { return view_; }
    void report(ToolEstimate& estimate) const CV_OVERRIDE;
    void setHandEye(const Matx44d& nominal_T_base) CV_OVERRIDE;
    void moveCamera(const Matx44d& now_T_before) CV_OVERRIDE;
    void inherit(const ToolMethod& other) CV_OVERRIDE;

private:
    const ToolView& predict(const std::vector<double>& joints, double seconds) CV_OVERRIDE;
    bool follow(Scene& scene, const PartDrawing* ahead);
    bool start(Scene& scene, int first, int last);
    bool startFrom(Scene& scene, const StartCandidate& candidate);
    bool startFromHandEye(Scene& scene);
    bool correctFromHandEye();
    bool correct();
    void gather();
    void setCorrection(const Matx44d& correction);
    void conclude(const Scene& scene, bool seen);

    CameraModel camera_;
    Ptr<ToolPoseEKF> filter_;
    Ptr<ToolPoseEKF> filterBefore_;        // this frame
    PaperMemory before_;
    PartWindows windows_;                  // memory
    std::vector<Point3d> nominalInliers_;  // of the inliers gathered: where the calibration has them
    std::vector<Point2d> imageInliers_;    // and where they are
    std::vector<uchar> used_;              // of these, by the filter
};

}} // namespace cv::surgtrack

#endif
