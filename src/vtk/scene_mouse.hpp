// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_VTK_SCENE_MOUSE_HPP
#define OPENCV_SURGTRACK_SRC_VTK_SCENE_MOUSE_HPP

class vtkRenderer;
class vtkRenderWindow;

namespace cv { namespace surgtrack {

/** @brief Lets the user look about in a window, until it is closed.
@param seconds or for so long; 0: only that */
void interact(vtkRenderWindow* window, vtkRenderer* renderer, double seconds);

}} // namespace cv::surgtrack

#endif
