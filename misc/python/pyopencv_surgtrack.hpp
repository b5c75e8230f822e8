// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Names the binding generator forms for nested structures and for lists of structures.

#ifdef HAVE_OPENCV_SURGTRACK
#include "opencv2/surgtrack.hpp"
#include "opencv2/surgtrack/lab.hpp"

typedef cv::surgtrack::ArticulatedPoseEKF::Params ArticulatedPoseEKF_Params;
typedef cv::surgtrack::GeometricContextVerifier::Params GeometricContextVerifier_Params;
typedef cv::surgtrack::PartTemplateRenderer::Params PartTemplateRenderer_Params;
typedef cv::surgtrack::QGOMatcher::Params QGOMatcher_Params;
typedef cv::surgtrack::SyntheticScene::Params SyntheticScene_Params;
typedef cv::surgtrack::ToolContour::Params ToolContour_Params;
typedef cv::surgtrack::ToolPoseEKF::Params ToolPoseEKF_Params;
typedef cv::surgtrack::ToolTracker::Params ToolTracker_Params;
typedef cv::surgtrack::ToolTracker::Stages ToolTracker_Stages;

typedef std::vector<cv::surgtrack::ContourPoint> vector_ContourPoint;
typedef std::vector<cv::surgtrack::DrawnTool> vector_DrawnTool;
typedef std::vector<cv::surgtrack::HandEyeFit> vector_HandEyeFit;
typedef std::vector<cv::surgtrack::JointReading> vector_JointReading;
typedef std::vector<cv::surgtrack::Mesh> vector_Mesh;
typedef std::vector<cv::surgtrack::MeshInstance> vector_MeshInstance;
typedef std::vector<cv::surgtrack::PartMatch> vector_PartMatch;
typedef std::vector<cv::surgtrack::PartTemplate> vector_PartTemplate;
typedef std::vector<cv::surgtrack::StageTime> vector_StageTime;
typedef std::vector<cv::surgtrack::ToolEstimate> vector_ToolEstimate;
typedef std::vector<cv::surgtrack::ToolView> vector_ToolView;
typedef std::vector<cv::surgtrack::TrueKeypoint> vector_TrueKeypoint;
typedef std::vector<cv::Ptr<cv::surgtrack::ToolModel> > vector_Ptr_ToolModel;
typedef std::vector<cv::Matx44d> vector_Matx44d;
typedef std::vector<cv::Point2d> vector_Point2d;
typedef std::vector<cv::Vec3i> vector_Vec3i;
typedef std::vector<std::vector<double> > vector_vector_double;
#endif
