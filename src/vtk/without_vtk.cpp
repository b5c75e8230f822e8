// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/surgtrack/scene_view.hpp"

// What stands for this wing where the module is built without VTK.

namespace cv { namespace surgtrack {

Ptr<MeshRenderer> MeshRenderer::createVTK()
{
    CV_Error(Error::StsNotImplemented, "the module was built without VTK, which draws by OpenGL; MeshRenderer::createSoftware() needs none");
}

Ptr<SceneView> SceneView::create(const CameraModel&, Size, bool)
{
    CV_Error(Error::StsNotImplemented, "the module was built without VTK, which draws the view from outside");
}

}} // namespace cv::surgtrack
