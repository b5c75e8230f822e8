// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_MODEL_MESH_HPP
#define OPENCV_SURGTRACK_SRC_MODEL_MESH_HPP

#include "opencv2/surgtrack/tool_model.hpp"

class vtkPolyData;

namespace cv { namespace surgtrack {

//! Merges duplicate points, makes the triangles' sense consistent (outward where the mesh is closed), and gives every vertex
//! one normal; vertices on creases are split.
void computeNormals(Mesh& mesh);

//! Takes vertices, triangles and, if there are any, normals; triangles with a vertex twice are dropped.
void fromPolyData(vtkPolyData* data, Mesh& mesh);

}} // namespace cv::surgtrack

#endif
