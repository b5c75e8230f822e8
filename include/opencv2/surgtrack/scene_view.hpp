// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SCENE_VIEW_HPP
#define OPENCV_SURGTRACK_SCENE_VIEW_HPP

#include "opencv2/surgtrack/draw.hpp"

namespace cv { namespace surgtrack {

//! @addtogroup surgtrack
//! @{

/** @brief A view of camera, image and tools from outside, by VTK / OpenGL.

It shows the camera's axes (x red, y green, z blue) and its field of view up to a plane behind the tools, with the image on it, undistorted
by being drawn where its pixels look; the tools; and paths, such as those of their tips. Everything is in the camera frame. */
class CV_EXPORTS_W SceneView
{
public:
    /** @param camera whose frame and image it is
    @param size of the pictures [pixel]
    @param window false: off screen, through an X server if DISPLAY names one, else X-free through EGL; true: in a window for show()
    @throws cv::Exception (StsNotImplemented) if there is neither; with a window, if there is no display */
    CV_WRAP static Ptr<SceneView> create(const CameraModel& camera, Size size = Size(960, 720), bool window = false);
    virtual ~SceneView() {}

    /** @brief Where the scene is seen from; by default from behind, above and right of the camera, so that the tools of the first draw() are
    in the middle.
    @param viewer where the viewer is, in the camera frame [m]
    @param centre what is in the middle of the picture [m]; another place */
    CV_WRAP virtual void setViewpoint(const Point3d& viewer, const Point3d& centre) = 0;

    /** @brief Draws the scene anew.
    @param image of the camera, CV_8UC1 or CV_8UC3 of its size; empty: the frame of its field of view alone
    @param tools their poses and looks; one with an opacity below 1 is seen through
    @param paths N x 3 points each, floating [m], in the colours of the tools of the same index
    @param picture CV_8UC3 of the view's size */
    CV_WRAP virtual void draw(InputArray image, const std::vector<DrawnTool>& tools, const std::vector<Mat>& paths, OutputArray picture) = 0;

    /** @brief Lets the user look at the last drawing: the left button turns, the wheel comes nearer, `q` or closing the window ends it.
    @param seconds ends it too; 0 = never
    @throws cv::Exception if there is no window */
    CV_WRAP virtual void show(double seconds = 0) = 0;
};

//! @}

}} // namespace cv::surgtrack

#endif
