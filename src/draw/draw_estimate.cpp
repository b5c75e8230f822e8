// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/surgtrack/draw.hpp"
#include "base/geometry.hpp"

// What the tracker said of a tool.

namespace cv { namespace surgtrack {

namespace {

bool isKnown(const ToolEstimate& estimate) { return estimate.state == STATE_TRACKING || estimate.state == STATE_COASTING; }

} // namespace

DrawnTool::DrawnTool(const Ptr<ToolModel>& _model, const ToolEstimate& estimate, double _opacity)
    : model(_model), joints(estimate.joints), color(isKnown(estimate) ? Scalar(0, 255, 0) : Scalar::all(150)), opacity(_opacity)
{
    if (!model) CV_Error(Error::StsBadArg, "model is empty");
    CV_CheckEQ(joints.size(), model->coordinateNames().size(), "estimate.joints: one per coordinate");
    camera_T_base = estimate.camera_T_tool * rigidInverse(model->endEffectorPose(joints));
}

void drawEvidence(InputOutputArray _image, const ToolEstimate& estimate, const String& name, int row)
{
    CV_CheckGE(row, 0, "row must not be negative");
    drawMatches(_image, estimate.matches, true);
    Mat image = _image.getMat();
    String text = (name.empty() ? name : name + "  ") + format("%s  similarity %.2f", stateName(estimate.state).c_str(), estimate.similarity);
    if (estimate.contourSupport > 0) text += format("  outline %.2f", estimate.contourSupport);
    const double scale = image.cols / double(referenceWidth);
    const int thickness = std::max(1, cvRound(scale));
    const Point origin(cvRound(10 * scale), cvRound((22 + 22 * double(row)) * scale));
    const Scalar color = isKnown(estimate) ? Scalar(120, 255, 120) : Scalar(120, 120, 255);
    putText(image, text, origin, FONT_HERSHEY_SIMPLEX, 0.55 * scale, Scalar::all(0), 3 * thickness, LINE_AA);   // a dark rim
    putText(image, text, origin, FONT_HERSHEY_SIMPLEX, 0.55 * scale, color, thickness, LINE_AA);
}

void drawEstimate(InputOutputArray image, const CameraModel& camera, const Ptr<ToolModel>& model, const ToolEstimate& estimate, const String& name,
                  const Ptr<MeshRenderer>& renderer)
{
    if (isKnown(estimate)) drawTools(image, camera, std::vector<DrawnTool>(1, DrawnTool(model, estimate)), renderer);
    drawEvidence(image, estimate, name);
}

}} // namespace cv::surgtrack
