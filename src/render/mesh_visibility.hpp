// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_RENDER_MESH_VISIBILITY_HPP
#define OPENCV_SURGTRACK_SRC_RENDER_MESH_VISIBILITY_HPP

#include "opencv2/surgtrack/tool_model.hpp"

namespace cv { namespace surgtrack {

/** Which triangles can be seen from behind: the inner walls of open tubes, and those that are wound the wrong way. All others are
always hidden by the mesh itself when their back is turned to the camera, and need not be drawn then. Found by drawing the mesh
from many directions; the neighbours of such a triangle count too, so that none is missed for being small.
@return a flag per triangle */
std::vector<uchar> seenFromBehind(const Mesh& mesh);

}} // namespace cv::surgtrack

#endif
