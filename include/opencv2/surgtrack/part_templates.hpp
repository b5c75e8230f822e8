// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_PART_TEMPLATES_HPP
#define OPENCV_SURGTRACK_PART_TEMPLATES_HPP

#include "opencv2/surgtrack/mesh_renderer.hpp"
#include "opencv2/surgtrack/tool_view.hpp"

namespace cv { namespace surgtrack {

//! @addtogroup surgtrack
//! @{

/** @brief One feature of a template: an orientation at an offset from the keypoint. */
struct CV_EXPORTS TemplateFeature
{
    short x, y;     //!< offset from PartTemplate::anchor [pixel]
    uchar bin;      //!< orientation, 0..7
};

/** @brief How a part of a tool should look around its keypoint (paper, Sec. 2.1). */
struct CV_EXPORTS_W_SIMPLE PartTemplate
{
    CV_WRAP PartTemplate();

    CV_PROP int tool;              //!< index of the tool
    CV_PROP int part;              //!< index of the keypoint
    CV_PROP Point2d imagePoint;    //!< where the keypoint is expected [pixel]
    CV_PROP Point anchor;          //!< imagePoint, rounded
    CV_PROP Point3d viewPoint;     //!< the keypoint in the camera frame the template was drawn in [m]
    CV_PROP Rect bounds;           //!< of the features, relative to the anchor [pixel]
    std::vector<TemplateFeature> features;

    /** @brief Features as N x 3 CV_32S: x and y from the anchor [pixel], bin of the orientation, 0..7. */
    CV_WRAP Mat getFeatures() const;
};

/** @brief Cuts part templates from a drawing of the tools (paper, Sec. 2.1).

All tools are in one drawing, so that they hide each other. A keypoint gets a template if it lies in the image and the depth
map does not hide it. The template's box has a fixed size on the tool, so its size in the image follows the depth. */
class CV_EXPORTS_W PartTemplateRenderer
{
public:
    struct CV_EXPORTS_W_SIMPLE Params
    {
        CV_WRAP Params();
        CV_PROP_RW double boxSize;              //!< side of the box on the tool [m]; default 0.011
        CV_PROP_RW int minFeatures;             //!< a template with fewer is dropped; default 30
        CV_PROP_RW int maxFeatures;             //!< features kept, spread over the box; default 250 (paper's release: 63)
        CV_PROP_RW double magnitudeThreshold;   //!< see quantizeOrientations(); default 80 (paper's release: 50): the gentle shading of a round shaft is no edge in an image
        CV_PROP_RW double depthSlack;           //!< a keypoint this far behind the drawn surface is visible [m]; 0.001, as the paper's release
        CV_PROP_RW bool wholeTool;              //!< rendering() shows the tool as far as it lies in the image, not only its parts; default false
        CV_PROP_RW double tipDepthSlack;        //!< the same for keypoints on the last links of the chain (tips) [m]; 0.003, as the paper's release
    };

    /** @param renderer draws the tools; none: MeshRenderer::createSoftware()
    @param params sizes and thresholds */
    CV_WRAP static Ptr<PartTemplateRenderer> create(const Ptr<MeshRenderer>& renderer = Ptr<MeshRenderer>(),
                                                    const PartTemplateRenderer::Params& params = PartTemplateRenderer::Params());
    virtual ~PartTemplateRenderer() {}

    /** @brief Adds a tool. @param model the tool @return its index */
    CV_WRAP virtual int addTool(const Ptr<ToolModel>& model) = 0;

    /** @brief Draws the tools and cuts the templates of one of them.
    @param camera intrinsics and distortion
    @param views one per tool added; a tool without link poses may be anywhere, and is not drawn
    @param tool the tool wanted; the others only hide it
    @param templates result; those of invisible parts are missing
    @param scale the tool is drawn this much larger, about the centre of its keypoints (initialisation: 0.8, 1, 1.2)
    @param rotation the tool is turned by this about the viewing ray through the centre of its keypoints [rad]
    (initialisation: 0, +-15 degrees) */
    CV_WRAP virtual void render(const CameraModel& camera, const std::vector<ToolView>& views, int tool, CV_OUT std::vector<PartTemplate>& templates,
                                double scale = 1, double rotation = 0) = 0;

    /** @brief The same for a single tool, from its joints.
    @param camera intrinsics and distortion
    @param camera_T_base pose of the arm's base in the camera frame; the model is that of index 0
    @param joints one value per coordinate [rad or m]
    @param scale see render()
    @param rotation see render() */
    CV_WRAP std::vector<PartTemplate> renderTool(const CameraModel& camera, const Matx44d& camera_T_base, InputArray joints,
                                                 double scale = 1, double rotation = 0);

    /** @brief A tool that was added. @param tool index */
    CV_WRAP virtual Ptr<ToolModel> model(int tool) const = 0;

    //! The last drawing: of the parts' surroundings, or of the whole tool.
    virtual const Rendering& rendering() const = 0;

    /** @brief The last drawing: of the parts' surroundings, or of the whole tool. A copy, which stays as it is. */
    CV_WRAP_AS(rendering) Rendering copyRendering() const;

    //! Takes the last drawing away, for another's memory.
    virtual void swapRendering(Rendering& other) = 0;
};

//! @}

}} // namespace cv::surgtrack

#endif
