// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/surgtrack/tool_view.hpp"
#include "base/geometry.hpp"

namespace cv { namespace surgtrack {

ToolView::ToolView() {}

ToolView::ToolView(const Matx44d& _camera_T_base, const std::vector<Matx44d>& _base_T_link) : camera_T_base(_camera_T_base), base_T_link(_base_T_link) {}

Mat ToolView::linkPoses() const
{
    return stackPoses(base_T_link);
}

}} // namespace cv::surgtrack
