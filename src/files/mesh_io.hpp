// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_FILES_MESH_IO_HPP
#define OPENCV_SURGTRACK_SRC_FILES_MESH_IO_HPP

#include "opencv2/surgtrack/tool_model.hpp"

// The steps of loadMesh(), one by one: a tool decimates its meshes only when it knows how many triangles there are in all.

namespace cv { namespace surgtrack {

//! Reads and checks a mesh file: triangles, duplicate points merged, in the link's frame [m]; no normals yet.
Mesh readMesh(const String& filename, double scale, const Matx44d& link_T_mesh);

//! ToolModel::create() of what a file says, which an error names.
Ptr<ToolModel> createTool(const String& filename, const ToolModel::Description& tool);

//! Quadric decimation to at most maxTriangles in all, with one measure of error for all meshes, whose points are merged. Drops the normals.
void decimateMeshes(std::vector<Mesh>& meshes, int maxTriangles);

//! Binary PLY, in the unit of the mesh.
void writePLY(const String& filename, const Mesh& mesh);

}} // namespace cv::surgtrack

#endif
