// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_FILES_MESH_READER_HPP
#define OPENCV_SURGTRACK_SRC_FILES_MESH_READER_HPP

#include "opencv2/surgtrack/tool_model.hpp"

namespace cv { namespace surgtrack {

//! The triangles of a mesh file, in its unit and axes; points are not merged, there are no normals. @throws cv::Exception naming the file
Mesh readMeshFile(const String& filename);

}} // namespace cv::surgtrack

#endif
