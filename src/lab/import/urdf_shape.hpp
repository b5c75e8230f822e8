// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_LAB_IMPORT_URDF_SHAPE_HPP
#define OPENCV_SURGTRACK_SRC_LAB_IMPORT_URDF_SHAPE_HPP

#ifdef HAVE_URDFDOM
#include <urdf_model/link.h>
#include "opencv2/surgtrack/tool_model.hpp"

namespace cv { namespace surgtrack {

//! The mesh of a cylinder along z, a sphere or a box, around the origin.
Mesh shapeMesh(const urdf::Geometry& geometry, const Matx44d& link_T_shape);

}} // namespace cv::surgtrack
#endif

#endif
