// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_RENDER_CHECK_RENDERING_HPP
#define OPENCV_SURGTRACK_SRC_RENDER_CHECK_RENDERING_HPP

#include "opencv2/surgtrack/mesh_renderer.hpp"

namespace cv { namespace surgtrack {

//! The arguments of MeshRenderer::render(), for a renderer that has so many meshes.
void checkRendering(const CameraModel& camera, const Rect& window, const std::vector<MeshInstance>& instances, int meshes);

}} // namespace cv::surgtrack

#endif
