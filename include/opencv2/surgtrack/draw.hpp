// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_DRAW_HPP
#define OPENCV_SURGTRACK_DRAW_HPP

#include "opencv2/surgtrack/geometric_context.hpp"
#include "opencv2/surgtrack/contour.hpp"
#include "opencv2/surgtrack/tool_estimate.hpp"

namespace cv { namespace surgtrack {

//! @addtogroup surgtrack
//! @{

/** @brief A tool as drawTools() and SceneView::draw() show it. */
struct CV_EXPORTS_W_SIMPLE DrawnTool
{
    CV_WRAP DrawnTool();

    /** @param model the tool
    @param joints one value per coordinate [rad or m]
    @param camera_T_base the arm's base in the camera frame
    @param color BGR
    @param opacity of its surface, 0..1 */
    CV_WRAP DrawnTool(const Ptr<ToolModel>& model, const std::vector<double>& joints, const Matx44d& camera_T_base,
                      const Scalar& color = Scalar(0, 255, 0), double opacity = 0.4);

    /** @brief A tool where an estimate has it: green where that is known (tracking or coasting), else grey.
    @param model the tool
    @param estimate what the tracker said of it
    @param opacity of its surface, 0..1 */
    CV_WRAP DrawnTool(const Ptr<ToolModel>& model, const ToolEstimate& estimate, double opacity = 0.4);

    CV_PROP_RW Ptr<ToolModel> model;
    CV_PROP_RW std::vector<double> joints;    //!< one value per coordinate [rad or m]
    CV_PROP_RW Matx44d camera_T_base;         //!< the arm's base in the camera frame
    CV_PROP_RW Scalar color;                  //!< BGR
    CV_PROP_RW double opacity;                //!< of its surface: 0 = outline only, 1 = hides the image
};

/** @brief Draws tools over a camera's image where they are: their shaded surface, blended, and their outline.

All tools are in one drawing: the nearer one hides the other. Only pixels that a tool covers are changed; the image's distortion is
that of the camera.
@param image CV_8UC3 of the camera's size, is drawn on
@param camera of the image
@param tools their poses and looks
@param renderer keep one from image to image, and the tools' meshes are prepared once; none: a software renderer of this call's own
@param thickness of the outlines, inside of the tools [pixel]; 0 = none, negative: image width / 360 */
CV_EXPORTS_W void drawTools(InputOutputArray image, const CameraModel& camera, const std::vector<DrawnTool>& tools,
                            const Ptr<MeshRenderer>& renderer = Ptr<MeshRenderer>(), int thickness = -1);

/** @brief drawTools() of a single tool.
@param image CV_8UC3 of the camera's size, is drawn on
@param camera of the image
@param model the tool
@param joints one value per coordinate [rad or m]
@param camera_T_base the arm's base in the camera frame
@param color BGR
@param opacity of its surface, 0..1
@param renderer see drawTools() */
CV_EXPORTS_W void drawTool(InputOutputArray image, const CameraModel& camera, const Ptr<ToolModel>& model, InputArray joints,
                           const Matx44d& camera_T_base, const Scalar& color = Scalar(0, 255, 0), double opacity = 0.4,
                           const Ptr<MeshRenderer>& renderer = Ptr<MeshRenderer>());

/** @brief Draws a tool's skeleton (joint axes' origins and the end effector) and its keypoints into an image.
@param image CV_8UC3, is drawn on
@param camera of the image
@param model the tool
@param joints one value per coordinate [rad or m]
@param camera_T_base the arm's base in the camera frame
@param color BGR */
CV_EXPORTS_W void drawSkeleton(InputOutputArray image, const CameraModel& camera, const Ptr<ToolModel>& model, InputArray joints,
                               const Matx44d& camera_T_base, const Scalar& color);

/** @brief The colour of a quantised orientation, BGR. @param bin 0..7 */
CV_EXPORTS_W Scalar orientationColor(int bin);

/** @brief A colour for a part, BGR: the same in every picture, far from that of the next part. @param part index of the keypoint */
CV_EXPORTS_W Scalar partColor(int part);

/** @brief Paints quantised orientations in their colours (paper, Fig. 2b); pixels without one are left as they are.
@param image CV_8UC3, is drawn on
@param orientations CV_8UC1 bit sets of the image's size, see quantizeOrientations(); several bits are painted in the mean of their colours */
CV_EXPORTS_W void drawOrientations(InputOutputArray image, InputArray orientations);

/** @brief Draws a pie whose sectors have the colours of the gradients that point there (paper, Fig. 1c).
@param image CV_8UC3, is drawn on
@param centre of the pie [pixel]
@param radius [pixel] */
CV_EXPORTS_W void drawOrientationLegend(InputOutputArray image, Point centre, int radius);

/** @brief Paints the features of a template in the colours of their orientations (paper, Fig. 2a).
@param image CV_8UC3, is drawn on; features beyond its border are left out
@param partTemplate the template
@param anchor where its keypoint is put [pixel]
@param pixelSize side of the squares that features are painted as [pixel]: the template is drawn this much larger */
CV_EXPORTS_W void drawTemplate(InputOutputArray image, const PartTemplate& partTemplate, Point anchor, int pixelSize = 1);

/** @brief Paints a similarity map (paper, Fig. 2c): dark is 0, yellow is 1.
@param similarity CV_16UC1, see QGOMatcher::similarityMap()
@param partTemplate the template it is of
@param picture CV_8UC3 of the map's size */
CV_EXPORTS_W void drawSimilarity(InputArray similarity, const PartTemplate& partTemplate, OutputArray picture);

/** @brief Draws matches as circles in their parts' colours, larger ones for more similarity, and lines to where they were expected.
@param image CV_8UC3, is drawn on
@param matches what QGOMatcher::match() or GeometricContextVerifier::verify() gave
@param filled whether the circles are */
CV_EXPORTS_W void drawMatches(InputOutputArray image, const std::vector<PartMatch>& matches, bool filled = false);

/** @brief Draws the evidence of an estimate: its matches as dots, and a line of text in the upper left corner with the tool's name, the
state, the similarity and how much of the outline is where it should be; green where the pose is known (tracking or coasting), else red.
@param image CV_8UC3, is drawn on
@param estimate what the tracker said
@param name of the tool
@param row of the text: 0, 1, ... for several tools in one image */
CV_EXPORTS_W void drawEvidence(InputOutputArray image, const ToolEstimate& estimate, const String& name, int row = 0);

/** @brief Draws an estimate: the tool where it was found, if that is known (tracking or coasting), and drawEvidence().

For tools that hide each other: drawTools() of all of them, then drawEvidence() of each.
@param image CV_8UC3 of the camera's size, is drawn on
@param camera of the image
@param model the tool
@param estimate what the tracker said of it
@param name of the tool, for the text
@param renderer see drawTools() */
CV_EXPORTS_W void drawEstimate(InputOutputArray image, const CameraModel& camera, const Ptr<ToolModel>& model, const ToolEstimate& estimate,
                               const String& name = String(), const Ptr<MeshRenderer>& renderer = Ptr<MeshRenderer>());

/** @brief Draws one of the two polar grids of the geometric context (paper, Fig. 2d-f): rays and rings of the zones about the first
match of the sample, the inliers' zones, which are those of the drawing in both grids, and the matches: inliers filled, others not.
@param image CV_8UC3, is drawn on
@param matches what was verified
@param inliers what GeometricContextVerifier::verify() gave
@param sample GeometricContextVerifier::sample(); without one, only the matches are drawn
@param predicted true: the grid of the drawing, at PartMatch::predictedPoint; false: that of the image, at PartMatch::imagePoint
@param params of the verifier */
CV_EXPORTS_W void drawGeometricContext(InputOutputArray image, const std::vector<PartMatch>& matches, const std::vector<PartMatch>& inliers,
                                       const std::vector<PartMatch>& sample, bool predicted,
                                       const GeometricContextVerifier::Params& params = GeometricContextVerifier::Params());

/** @brief Draws what matchContour() found: the expected points, and lines along the normals to their edges, from green where the edge is
in its place to red where it is @p worst pixels off. Points without an edge are grey.
@param image CV_8UC3, is drawn on
@param points after matchContour()
@param worst offset that is red [pixel]
@param gain the lines are drawn this much longer */
CV_EXPORTS_W void drawContour(InputOutputArray image, const std::vector<ContourPoint>& points, double worst = 3, double gain = 1);

//! @}

}} // namespace cv::surgtrack

#endif
