// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_LAB_IMPORT_IMPORT_TOOL_HPP
#define OPENCV_SURGTRACK_SRC_LAB_IMPORT_IMPORT_TOOL_HPP

#include <map>
#include "opencv2/surgtrack/import.hpp"
#include "base/geometry.hpp"
#include "files/text_file.hpp"

// What the importers of tools share.

namespace cv { namespace surgtrack {

//! The multiple of pi / 12 an angle stands for if it differs by less than 1e-5 rad, as 1.5708 does from pi / 2; else the angle.
double exactAngle(double angle);

/** A rigid transform as modified Denavit-Hartenberg transforms one after the other: one where that does, else two or three.
Only alpha, a, theta and d of the links are filled in. */
std::vector<ToolModel::Link> denavitHartenbergSteps(const Matx44d& T);

//! Index of a link. @throws cv::Exception naming the source of the name and the links there are
int findLink(const ToolModel::Description& tool, const String& name, const String& source);

//! By the index of a link: link_T_file of its mesh files, with their scale; those of all others by -1.
typedef std::map<int, std::vector<Matx44d> > MeshFrames;

/** Meshes and keypoints that parts names itself.
@param axes rotation of the meshes' axes in the link's frame
@param frames of links whose meshes are not those of parts */
void addParts(const ToolParts& parts, const Matx33d& axes, ToolModel::Description& tool, MeshFrames frames = MeshFrames());

//! Whether ToolParts::keypoints asks for keypoints to be chosen. @param count is set if it says how many
bool wantsAuto(const String& keypoints, int* count = 0);

//! The tool, with keypoints chosen if parts asks for it. @param filename for errors
Ptr<ToolModel> makeTool(const String& filename, const ToolParts& parts, const ToolModel::Description& tool);

//! Drops meshes that no link has.
void dropUnusedMeshes(ToolModel::Description& tool);

}} // namespace cv::surgtrack

#endif
