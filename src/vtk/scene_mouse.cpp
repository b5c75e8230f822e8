// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "vtk/scene_mouse.hpp"

#include <vtkCallbackCommand.h>
#include <vtkCamera.h>
#include <vtkNew.h>
#include <vtkRenderWindow.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>

namespace cv { namespace surgtrack {

namespace {

// What the mouse does. VTK's own styles are in another of its libraries.
struct Mouse
{
    vtkRenderer* renderer;
    bool turning;

    static void listen(vtkObject* caller, unsigned long event, void* clientData, void*)
    {
        Mouse& mouse = *static_cast<Mouse*>(clientData);
        vtkRenderWindowInteractor* interactor = static_cast<vtkRenderWindowInteractor*>(caller);
        vtkCamera* view = mouse.renderer->GetActiveCamera();
        if (event == vtkCommand::LeftButtonPressEvent) mouse.turning = true;
        else if (event == vtkCommand::LeftButtonReleaseEvent) mouse.turning = false;
        else if (event == vtkCommand::TimerEvent) interactor->TerminateApp();
        else if (event == vtkCommand::MouseWheelForwardEvent || event == vtkCommand::MouseWheelBackwardEvent)
            view->Dolly(event == vtkCommand::MouseWheelForwardEvent ? 1.1 : 1 / 1.1);
        else if (event == vtkCommand::MouseMoveEvent && mouse.turning)
        {
            const double degreesPerPixel = 0.4;
            const int *now = interactor->GetEventPosition(), *last = interactor->GetLastEventPosition();
            view->Azimuth(degreesPerPixel * (last[0] - now[0]));
            view->Elevation(degreesPerPixel * (last[1] - now[1]));
            view->OrthogonalizeViewUp();
        }
        else return;
        mouse.renderer->ResetCameraClippingRange();
        interactor->Render();
    }
};

} // namespace

void interact(vtkRenderWindow* window, vtkRenderer* renderer, double seconds)
{
    vtkSmartPointer<vtkRenderWindowInteractor> interactor = vtkSmartPointer<vtkRenderWindowInteractor>::New();
    if (String(interactor->GetClassName()) == "vtkRenderWindowInteractor") CV_Error(Error::StsNotImplemented, "VTK was built or linked without windows");
    interactor->SetRenderWindow(window);
    Mouse mouse = {renderer, false};
    vtkNew<vtkCallbackCommand> command;
    command->SetCallback(Mouse::listen);
    command->SetClientData(&mouse);
    const unsigned long events[] = {vtkCommand::LeftButtonPressEvent, vtkCommand::LeftButtonReleaseEvent, vtkCommand::MouseMoveEvent,
                                    vtkCommand::MouseWheelForwardEvent, vtkCommand::MouseWheelBackwardEvent, vtkCommand::TimerEvent};
    interactor->Initialize();
    for (size_t i = 0; i < sizeof(events) / sizeof(events[0]); i++) interactor->AddObserver(events[i], command);
    if (seconds > 0) interactor->CreateOneShotTimer(std::max(1ul, (unsigned long)(1000 * seconds)));
    interactor->Start();
    window->SetInteractor(0);
}

}} // namespace cv::surgtrack
