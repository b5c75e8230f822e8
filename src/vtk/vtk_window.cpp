// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "vtk/vtk_window.hpp"

#include <vtkCallbackCommand.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkObjectFactory.h>
#include <vtkVersionMacros.h>

namespace cv { namespace surgtrack {

namespace {

class EGLRenderWindow : public vtkGenericOpenGLRenderWindow
{
public:
    static EGLRenderWindow* New();
    vtkTypeMacro(EGLRenderWindow, vtkGenericOpenGLRenderWindow);

    void setContext(const Ptr<EGLContextHolder>& context) { context_ = context; }
    void MakeCurrent() override { if (context_) context_->makeCurrent(); }
    bool IsCurrent() override { return context_ && context_->isCurrent(); }
    int SupportsOpenGL() override { return 1; }
    vtkTypeBool IsDirect() override { return 1; }

    void Initialize() override
    {
        MakeCurrent();
        if (!this->Initialized) OpenGLInit();
    }

    void OpenGLInitContext() override
    {
        Superclass::OpenGLInitContext();
#if VTK_MAJOR_VERSION == 9 && VTK_MINOR_VERSION < 4
        // A GLEW made for GLX loads all functions, then finds no GLX display (its error 4) and VTK gives up. Every other of its
        // errors was excluded when the context was made: it has a version, and that is 3.2.
        if (!this->GlewInitValid)
        {
            this->GlewInitValid = true;
            this->Initialized = true;
        }
#endif
    }

private:
    Ptr<EGLContextHolder> context_;
};

vtkStandardNewMacro(EGLRenderWindow);

} // namespace

Drawable openXWindow(String& reason)
{
    Drawable drawable;
    // VTK ends the process if it finds no display. If it opened one, it would close it while a context on it is current.
    drawable.display = XDisplayHolder::create(reason);
    if (!drawable.display) return drawable;
    vtkSmartPointer<vtkRenderWindow> window = vtkSmartPointer<vtkRenderWindow>::New();
    drawable.window = vtkOpenGLRenderWindow::SafeDownCast(window);
    if (!drawable.window) reason = "VTK was built without OpenGL windows";
    else if (drawable.display->display) drawable.window->SetDisplayId(drawable.display->display);
    if (drawable.window)   // with somebody listening, VTK does not end the process if it gets no context
        drawable.window->AddObserver(vtkCommand::ExitEvent, vtkSmartPointer<vtkCallbackCommand>::New());
    return drawable;
}

Drawable openEGLWindow(String& reason)
{
    Drawable drawable;
    const Ptr<EGLContextHolder> context = EGLContextHolder::create(reason);
    if (!context) return drawable;
    vtkSmartPointer<EGLRenderWindow> window = vtkSmartPointer<EGLRenderWindow>::New();
    window->setContext(context);
    drawable.window = window;
    return drawable;
}

}} // namespace cv::surgtrack
