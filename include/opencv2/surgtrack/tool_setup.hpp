// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_TOOL_SETUP_HPP
#define OPENCV_SURGTRACK_TOOL_SETUP_HPP

#include "opencv2/surgtrack/tool_model.hpp"

// What a new instrument needs before it is tracked: keypoints, and a look at what was imported.

namespace cv { namespace surgtrack {

//! @addtogroup surgtrack
//! @{

/** @brief Chooses keypoints of a tool by what tracking does with them.

Points all over the surface of wrist, jaws and the end of the shaft are tried: the tool is drawn from all around, at many settings of
its joints, over tissue and in a light of its own. In each of these pictures PartTemplateRenderer cuts their templates from a drawing that is
wrong by what a hand-eye calibration and a wrist are wrong by, and QGOMatcher looks for them. What a point is worth there is how much finding it,
with the error it was found with, tells of the pose and of the offsets of wrist and jaws. Those that tell most together are taken, one by one
(the determinant of the information matrix, over all pictures); further ones, until at least six are found from every side that shows as many.

Takes a second or two. The same tool gets the same points.

@param model the tool; keypoints it has are replaced
@param count at least so many, if the surface has them
@return the tool with keypoints named LINK_1, LINK_2, ...; their score is the share of pictures that show them in which they were found
@throws cv::Exception if the tool has no meshes, and (StsObjectNotFound) if less than four keypoints are found again */
CV_EXPORTS_W Ptr<ToolModel> chooseKeypoints(const Ptr<ToolModel>& model, int count = 24);

/** @brief A tool from any file that describes one: a tool file, or an URDF (by its name, `.urdf`); ready to be tracked.

A tool without keypoints gets those of chooseKeypoints(), if there are any. The end effector of an URDF is the link `tool_tip_link`, or the only end of the
chain that no joint moves by itself; importUrdfTool() has more options.
@param filename tool file or URDF
@param maxTriangles a tool with more triangles than this is decimated, all meshes to the same closeness; 0 = never */
CV_EXPORTS_W Ptr<ToolModel> loadTool(const String& filename, int maxTriangles = 20000);

/** @brief What is likely to be wrong with a tool, in a line each: its chain, units and sizes, keypoints off the surface, joint limits, axes.
@param model the tool
@return empty if nothing was found */
CV_EXPORTS_W std::vector<String> checkTool(const Ptr<ToolModel>& model);

/** @brief Draws what a person checks an import by: the tool from six sides (columns) at three settings of its joints (rows), its keypoints
numbered, the axes of its end effector, and the coordinates' values.
@param model the tool
@param sheet CV_8UC3, is made */
CV_EXPORTS_W void drawToolSheet(const Ptr<ToolModel>& model, OutputArray sheet);

//! @}

}} // namespace cv::surgtrack

#endif
