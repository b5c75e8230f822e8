// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Names the binding generator forms for nested structures and for lists of structures; and a door for the Python part of the bindings.

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
typedef std::vector<cv::surgtrack::ReadingErrors> vector_ReadingErrors;
typedef std::vector<cv::surgtrack::StageTime> vector_StageTime;
typedef std::vector<cv::surgtrack::ToolEstimate> vector_ToolEstimate;
typedef std::vector<cv::surgtrack::ToolView> vector_ToolView;
typedef std::vector<cv::surgtrack::TrueKeypoint> vector_TrueKeypoint;
typedef std::vector<cv::Ptr<cv::surgtrack::ToolModel> > vector_Ptr_ToolModel;
typedef std::vector<cv::Matx44d> vector_Matx44d;
typedef std::vector<cv::Point2d> vector_Point2d;
typedef std::vector<cv::Vec3i> vector_Vec3i;
typedef std::vector<std::vector<double> > vector_vector_double;

#ifndef Py_LIMITED_API   // else Python may set attributes of the types itself
static PyObject* pyopencv_surgtrack_callRepr(PyObject* self)
{
    return PyObject_CallMethod(self, "__repr__", NULL);
}

static PyObject* pyopencv_surgtrack_setRepr(PyObject*, PyObject* args)
{
    PyObject *type = NULL, *function = NULL;
    if (!PyArg_ParseTuple(args, "O!O", &PyType_Type, &type, &function)) return NULL;
    PyTypeObject* const t = (PyTypeObject*)type;
    if (PyDict_SetItemString(t->tp_dict, "__repr__", function) != 0) return NULL;
    t->tp_repr = pyopencv_surgtrack_callRepr;
    PyType_Modified(t);
    Py_RETURN_NONE;
}

#define PYOPENCV_EXTRA_METHODS_SURGTRACK \
    {"_setRepr", pyopencv_surgtrack_setRepr, METH_VARARGS, "_setRepr(type, function) -> None\n.   Used by surgtrack/__init__.py."},
#endif
#endif
