// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_VTK_VTK_MESH_HPP
#define OPENCV_SURGTRACK_SRC_VTK_VTK_MESH_HPP

#include "opencv2/surgtrack/tool_model.hpp"

#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

namespace cv { namespace surgtrack {

//! A mesh with its normals. @throws cv::Exception for one without triangles, with an index that is none, or that is not finite
vtkSmartPointer<vtkPolyData> toPolyData(const Mesh& mesh);

}} // namespace cv::surgtrack

#endif
