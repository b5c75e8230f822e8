// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_VTK_VTK_WINDOW_HPP
#define OPENCV_SURGTRACK_SRC_VTK_VTK_WINDOW_HPP

#include "vtk/egl_context.hpp"

#include <vtkOpenGLRenderWindow.h>
#include <vtkSmartPointer.h>

namespace cv { namespace surgtrack {

/** VTK's messages go to the terminal; ours are exceptions. */
struct Quiet
{
    Quiet() : was(vtkObject::GetGlobalWarningDisplay()) { vtkObject::SetGlobalWarningDisplay(0); }
    ~Quiet() { vtkObject::SetGlobalWarningDisplay(was); }
    int was;
};

/** A window, and what must outlive it. */
struct Drawable
{
    Ptr<XDisplayHolder> display;   // empty with EGL
    vtkSmartPointer<vtkOpenGLRenderWindow> window;
};

/** @brief Windows for drawing off screen, through an X server and through EGL. They are not initialised yet.
@param reason why there is none, if the result has no window */
Drawable openXWindow(String& reason);
Drawable openEGLWindow(String& reason);

}} // namespace cv::surgtrack

#endif
