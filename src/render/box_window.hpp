// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_RENDER_BOX_WINDOW_HPP
#define OPENCV_SURGTRACK_SRC_RENDER_BOX_WINDOW_HPP

#include <cfloat>
#include "opencv2/surgtrack/mesh_renderer.hpp"

namespace cv { namespace surgtrack {

struct MeshBox
{
    Point3f low, high;   // of the vertices
};

MeshBox boxAbout(const Mesh& mesh);

/** @brief A window of the image that holds all that is seen of some boxes. */
class BoxWindow
{
public:
    BoxWindow() : left_(DBL_MAX), right_(-DBL_MAX), top_(DBL_MAX), bottom_(-DBL_MAX) {}

    void add(const Matx44d& camera_T_mesh, const MeshBox& box);

    //! @param field CameraModel::fieldOfView() of the whole image
    Rect get(const CameraModel& camera, const Rect2d& field) const;

private:
    double left_, right_, top_, bottom_;   // x / z, y / z
};

}} // namespace cv::surgtrack

#endif
