// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_MODEL_MESH_HPP
#define OPENCV_SURGTRACK_SRC_MODEL_MESH_HPP

#include "opencv2/surgtrack/tool_model.hpp"

namespace cv { namespace surgtrack {

//! Makes points at the same place one, in the order triangles name them, and drops triangles with a point twice; drops the normals.
void mergePoints(Mesh& mesh);

//! Merges points, makes the triangles' sense consistent (outward where the mesh is closed), and gives every vertex
//! one normal; vertices on creases are split.
void computeNormals(Mesh& mesh);

}} // namespace cv::surgtrack

#endif
