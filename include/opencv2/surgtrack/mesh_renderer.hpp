// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_MESH_RENDERER_HPP
#define OPENCV_SURGTRACK_MESH_RENDERER_HPP

#include "opencv2/surgtrack/camera.hpp"
#include "opencv2/surgtrack/tool_model.hpp"

namespace cv { namespace surgtrack {

//! @addtogroup surgtrack
//! @{

/** @brief What a MeshRenderer draws: three images of the same size, for one window of the camera's image. */
struct CV_EXPORTS_W_SIMPLE Rendering
{
    CV_WRAP Rendering();

    CV_PROP_RW Rect window;    //!< the part of the image that was drawn; pixel (0, 0) of the maps is window.tl() of the image
    CV_PROP_RW Mat depth;      //!< CV_32FC1, z in the camera frame [m], 0 where there is nothing
    CV_PROP_RW Mat ids;        //!< CV_8UC1, MeshInstance::id of the nearest surface, 0 where there is nothing
    CV_PROP_RW Mat shading;    //!< CV_8UC1, headlight shading: 255 * |cos| of the angle between normal and viewing ray, 0 where nothing

    //! Makes the three maps of the window's size; memory is taken only when the window outgrows all before it.
    void create(const Rect& newWindow);

private:
    Mat storage_;
};

/** @brief A mesh placed in the camera frame. */
struct CV_EXPORTS_W_SIMPLE MeshInstance
{
    CV_WRAP MeshInstance();
    CV_WRAP MeshInstance(int mesh, int id, const Matx44d& camera_T_mesh);

    CV_PROP_RW int mesh;                  //!< what MeshRenderer::addMesh() returned
    CV_PROP_RW int id;                    //!< 1..255, written into Rendering::ids
    CV_PROP_RW Matx44d camera_T_mesh;     //!< rigid
};

/** @brief Draws meshes as the camera would see them: with its intrinsics, its distortion, and hiding each other.

Derive from it to bring a renderer of your own. Not thread-safe: one renderer for each thread. */
class CV_EXPORTS_W MeshRenderer
{
public:
    virtual ~MeshRenderer() {}

    /** @brief The default: a z-buffer on the CPU. Needs no display; its result does not depend on the vector instructions there are. */
    CV_WRAP static Ptr<MeshRenderer> createSoftware();

    /** @brief VTK / OpenGL, off screen: through an X server if DISPLAY names one, else X-free through EGL.
    @throws cv::Exception (StsNotImplemented) if there is neither */
    CV_WRAP static Ptr<MeshRenderer> createVTK();

    /** @brief Makes a mesh known.
    @param mesh with at least one triangle, and a normal for each vertex
    @return its handle for MeshInstance::mesh */
    CV_WRAP virtual int addMesh(const Mesh& mesh) = 0;

    /** @brief Draws the instances into the window of the camera's image.
    @param camera intrinsics and distortion
    @param window part of the image; must lie inside it
    @param instances meshes and their poses; may reach behind the camera
    @param rendering result
    @param regions the parts of the window that are needed, in the image's coordinates; what lies outside of them may stay empty.
    None: all of it is needed */
    CV_WRAP virtual void render(const CameraModel& camera, const Rect& window, const std::vector<MeshInstance>& instances, CV_OUT Rendering& rendering,
                                const std::vector<Rect>& regions = std::vector<Rect>()) = 0;

    /** @brief Makes all meshes of a tool known, one after the other; those of a tool that is known already are not added again.
    @param tool whose mesh i gets the handle of the first one + i
    @return the handle of the first one */
    CV_WRAP int addTool(const Ptr<ToolModel>& tool);

    /** @brief Draws one tool into a whole image.
    @param tool addTool() is called for it
    @param joints one value per coordinate of the tool [rad or m]
    @param camera_T_base the arm's base in the camera frame
    @param camera intrinsics and distortion
    @param depth CV_32FC1 [m], 0 where there is nothing
    @param ids CV_8UC1, 1 + index of the link, 0 where there is nothing
    @param shading CV_8UC1 */
    CV_WRAP void renderTool(const Ptr<ToolModel>& tool, InputArray joints, const Matx44d& camera_T_base, const CameraModel& camera,
                            OutputArray depth, OutputArray ids, OutputArray shading);

private:
    std::vector<std::pair<Ptr<ToolModel>, int> > tools_;   // a tool and the handle of its first mesh
};

//! @}

}} // namespace cv::surgtrack

#endif
