// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_CONTOUR_HPP
#define OPENCV_SURGTRACK_CONTOUR_HPP

#include "opencv2/surgtrack/mesh_renderer.hpp"
#include "opencv2/surgtrack/tool_view.hpp"

namespace cv { namespace surgtrack {

//! @addtogroup surgtrack
//! @{

/** @brief A point of a tool's outline or of a crease, and where the image has an edge on its normal. */
struct CV_EXPORTS_W_SIMPLE ContourPoint
{
    CV_WRAP ContourPoint();

    CV_PROP_RW int link;              //!< index of the link it lies on
    CV_PROP_RW Point3d linkPoint;     //!< in the link's frame [m]
    CV_PROP_RW Point3d linkDirection; //!< along the edge, in the link's frame; the tool is on its left, seen from the camera
    CV_PROP_RW Point2d imagePoint;    //!< where it is expected [pixel]
    CV_PROP_RW Point2d normal;        //!< unit vector in the image, out of the tool
    CV_PROP_RW bool crease;           //!< an edge inside the tool's image, not its outline
    CV_PROP_RW bool found;            //!< whether the image has an edge near it
    CV_PROP_RW double offset;         //!< where, from imagePoint along the normal [pixel]
    CV_PROP_RW double deviation;      //!< standard deviation of the offset, as edges of this strength have it [pixel]
    CV_PROP_RW int clipped;           //!< what the sensor has clipped to white beside the edge: 1 outside the tool, -1 inside, 0 neither; its light blooms over the edge
    CV_PROP_RW double strength;       //!< of that edge, change of the strongest channel [grey levels a pixel]
};

/** @brief The outline of a tool: from its meshes' edges, so exact to a fraction of a pixel, where a drawing shows that they are seen.

An edge between a triangle that faces the camera and one that does not is part of the outline if the drawing has the tool on one
side of it and neither this nor another tool on the other. Sharp edges between two triangles that face the camera are creases. */
class CV_EXPORTS_W ToolContour
{
public:
    struct CV_EXPORTS_W_SIMPLE Params
    {
        CV_WRAP Params();
        CV_PROP_RW double spacing;      //!< distance of the points [pixel]; default 5: nearer ones tell the same
        CV_PROP_RW int maxPoints;       //!< more than these are thinned out; default 200
        CV_PROP_RW double creaseAngle;  //!< edges sharper than this are creases [rad]; 0 = no creases
    };

    CV_WRAP static Ptr<ToolContour> create(const Ptr<ToolModel>& model, const ToolContour::Params& params = ToolContour::Params());
    virtual ~ToolContour() {}

    /** @brief Points of the outline and the creases, where a drawing shows that they are seen.
    @param camera of the drawing
    @param view of this tool
    @param rendering a drawing of all tools from this view; points outside its window are left out
    @param id of this tool's meshes in the drawing
    @param points result */
    CV_WRAP virtual void sample(const CameraModel& camera, const ToolView& view, const Rendering& rendering, int id,
                                CV_OUT std::vector<ContourPoint>& points) = 0;

    /** @brief The same for a single tool, which is drawn for it.
    @param camera intrinsics and distortion
    @param camera_T_base pose of the arm's base in the camera frame
    @param joints one value per coordinate [rad or m] */
    CV_WRAP std::vector<ContourPoint> sampleTool(const CameraModel& camera, const Matx44d& camera_T_base, InputArray joints);

protected:
    virtual Ptr<ToolModel> model() const = 0;
};

/** @brief Moves contour points to where another view has them, as long as it is so near that the same points of the tool make its
outline: to a tenth of a pixel for turns up to 0.05 rad.
@param camera of the view
@param view of their tool
@param points imagePoint and normal are set; points that are not in front of the camera are dropped */
CV_EXPORTS_W void placeContour(const CameraModel& camera, const ToolView& view, CV_IN_OUT std::vector<ContourPoint>& points);

/** @brief Where edges are sought, and which are believed. */
struct CV_EXPORTS_W_SIMPLE ContourSearch
{
    CV_WRAP ContourSearch();
    CV_PROP_RW double halfWindow;    //!< on both sides of the expected place, 1 to 40 [pixel]
    CV_PROP_RW double preference;    //!< edges this far from the expected place count 0.6 of one there, as a share of halfWindow; 0 = all the same
    CV_PROP_RW double minStrength;   //!< weaker edges are none [grey levels a pixel]; the most that is asked for
    CV_PROP_RW double contrast;      //!< edges must be so many times the median strength along the normals, where that is less than minStrength; 0 = not looked at; default 1.1: a ramp has none
    CV_PROP_RW double leastStrength; //!< contrast never asks for less; default 1: a blurred edge of three grey levels
    CV_PROP_RW double ambiguity;     //!< a point with a second edge more than this share as likely as the first is left out
};

/** @brief Looks for an edge on the normal of each point, to a fraction of a pixel: the maximum of the image's gradient along the
normal, over all channels, nearer ones preferred. In dim or hazy pictures weaker edges are believed, and their deviations are
smaller, as much as the threshold is. Rendered scenes in good light have medians of 5.5 to 7.5, where minStrength rules.
@param image CV_8UC1 or CV_8UC3
@param points their found, offset and strength are set
@param search where to look
@return how many were found */
CV_EXPORTS_W int matchContour(InputArray image, CV_IN_OUT std::vector<ContourPoint>& points, const ContourSearch& search);

//! @}

}} // namespace cv::surgtrack

#endif
