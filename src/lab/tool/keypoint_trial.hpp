// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_LAB_TOOL_KEYPOINT_TRIAL_HPP
#define OPENCV_SURGTRACK_SRC_LAB_TOOL_KEYPOINT_TRIAL_HPP

#include "opencv2/surgtrack/qgo_matcher.hpp"
#include "lab/synthetic/synthetic_image.hpp"
#include "lab/tool/tool_motion.hpp"

namespace cv { namespace surgtrack {

//! What a candidate did in one picture.
struct Sighting
{
    bool drawn, seen, found;           // a template was cut; the true drawing shows the point itself; the matcher found it there
    double error;                      // [pixel], of what was found
    std::vector<double> jacobian;      // 2 x states [pixel per unit]; empty if not found
};

/** Looks for candidates, which are the keypoints of a model, in pictures of it. One for each thread. */
class KeypointTrial
{
public:
    KeypointTrial(const Ptr<ToolModel>& model, const ToolMotion& motion);

    enum { PICTURES = 48 };
    static Viewpoint viewpoint(int picture);
    //! Coordinates whose offsets are to be known beside the pose.
    static std::vector<int> offsets(const ToolModel& model, const ToolMotion& motion);

    void run(int picture, std::vector<Sighting>& sightings);

private:
    void paint(int picture, const Matx44d& camera_T_base, const std::vector<Matx44d>& base_T_link);
    void look(const Matx44d& camera_T_base, const std::vector<Matx44d>& base_T_link, std::vector<Sighting>& sightings);
    void addJacobian(const Matx44d& camera_T_base, const std::vector<Matx44d>& base_T_link, int candidate, Sighting& sighting) const;

    Ptr<ToolModel> model_;
    const ToolMotion& motion_;
    std::vector<int> offsets_;
    Ptr<MeshRenderer> renderer_;
    Ptr<PartTemplateRenderer> parts_;
    Ptr<QGOMatcher> matcher_;
    CameraModel camera_, doubledCamera_;
    int firstMesh_;
    std::vector<ToolMaterial> materials_;
    Mat tissue_, vignette_, picture_;
    Rendering doubled_;
    std::vector<PartTemplate> templates_;
    std::vector<PartMatch> matches_;
};

}} // namespace cv::surgtrack

#endif
