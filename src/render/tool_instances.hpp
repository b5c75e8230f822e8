// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_RENDER_TOOL_INSTANCES_HPP
#define OPENCV_SURGTRACK_SRC_RENDER_TOOL_INSTANCES_HPP

#include <algorithm>
#include "opencv2/surgtrack/mesh_renderer.hpp"

namespace cv { namespace surgtrack {

/** Places the meshes of a tool's links in the camera frame.
@param firstMesh MeshRenderer::addTool()
@param id of all of them
@param eachLink the ids are those of the links, id + the link's index, as far as 255 */
inline void addInstances(const ToolModel& tool, int firstMesh, const Matx44d& camera_T_base, const std::vector<Matx44d>& base_T_link,
                         int id, bool eachLink, std::vector<MeshInstance>& instances)
{
    const std::vector<ToolModel::Link>& links = tool.links();
    for (size_t i = 0; i < links.size(); i++)
    {
        if (links[i].mesh < 0) continue;
        instances.push_back(MeshInstance(firstMesh + links[i].mesh, eachLink ? std::min(id + int(i), 255) : id, camera_T_base * base_T_link[i]));
    }
}

//! Whether a link ends its chain; keypoints there are tips.
inline bool isTip(const ToolModel& tool, int link)
{
    const std::vector<ToolModel::Link>& links = tool.links();
    for (size_t i = 0; i < links.size(); i++)
        if (links[i].parent == link) return false;
    return true;
}

/** Whether the instances of an id are drawn at a pixel, or at one that is no more than `aside` beside it, and do not hide depth z.
@param slack a point this far behind the surface is visible [m] */
inline bool isVisible(const Mat& depth, const Mat& ids, const Point& pixel, int aside, double z, int id, double slack)
{
    for (int y = std::max(pixel.y - aside, 0); y <= std::min(pixel.y + aside, ids.rows - 1); y++)
        for (int x = std::max(pixel.x - aside, 0); x <= std::min(pixel.x + aside, ids.cols - 1); x++)
            if (ids.at<uchar>(y, x) == id && z <= depth.at<float>(y, x) + slack) return true;
    return false;
}

}} // namespace cv::surgtrack

#endif
