// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "tool_tracker.hpp"
#include <cstdio>
namespace cv { namespace surgtrack {

// METHOD_FULL: points and contours into a filter of correction and joint offsets.

namespace {

const double supportedWithin = 2.5;   // [pixel at 720 px image width]; an edge this near is the outline's

} // namespace

void ToolTrackerImpl::drawOutline(int)
{
    StageTimer timer(times_, RENDER);
    outlineInstances_.clear();
    for (size_t t = 0; t < tools_.size(); t++)
    {
        const std::vector<ToolModel::Link>& links = tools_[t].model->links();
        for (size_t i = 0; i < links.size(); i++)
        {
            if (links[i].mesh < 0) continue;
            MeshInstance instance;
            instance.mesh = outlineMeshes_[t] + links[i].mesh;
            instance.id = int(t) + 1;
            instance.camera_T_mesh = views_[t].camera_T_base * views_[t].base_T_link[i];
            outlineInstances_.push_back(instance);
        }
    }
    outlineRenderer_->render(camera_, Rect(Point(), camera_.imageSize()), outlineInstances_, outlineRendering_);
}

int ToolTrackerImpl::correctPoints(TrackedTool& tool)
{
    StageTimer timer(times_, FILTER);
    parts_.clear();
    imagePoints_.clear();
    for (size_t i = 0; i < tool.inliers.size(); i++)
    {
        parts_.push_back(tool.inliers[i].part);
        imagePoints_.push_back(tool.inliers[i].imagePoint);
    }
    return tool.full->correctPoints(camera_, Matx44d::eye(), parts_, imagePoints_, used_);
}

// Contour passes about the state of the filter; the drawing is of nearly this view.
void ToolTrackerImpl::refine(int index, const Mat& image)
{
    TrackedTool& tool = tools_[index];
    StageTimer timer(times_, FILTER);
    static const double windows[] = {8, 5, 3};
    tool.full->beginContours();
    if (reduction_ > 1) reduce(image, Rect(Point(), reduced_.size()));
    const Mat& pixels = reduction_ > 1 ? reduced_ : image;
    ContourSearch search;
    for (int pass = 0; pass < 3; pass++)
    {
        tool.contour->sample(camera_, tool.full->view(), outlineRendering_, index + 1, tool.outline);
        search.halfWindow = windows[pass];
        matchContour(pixels, tool.outline, search);
        tool.full->addContour(camera_, Matx44d::eye(), tool.outline);
        tool.full->solveContours();
    }
    tool.contour->sample(camera_, tool.full->view(), outlineRendering_, index + 1, tool.outline);
    search.halfWindow = 5;
    matchContour(pixels, tool.outline, search);
    int supported = 0;
    for (size_t i = 0; i < tool.outline.size(); i++) supported += tool.outline[i].found && std::abs(tool.outline[i].offset) < supportedWithin;
    tool.contourSupport = tool.outline.empty() ? 0 : double(supported) / double(tool.outline.size());
}

bool ToolTrackerImpl::startFull(int index, const Mat& image)
{
    TrackedTool& tool = tools_[index];
    tool.full->undo();
    for (int pass = 0; pass < 3; pass++)
    {
        if (pass > 0)
        {
            views_[index] = tool.full->view();
            const std::vector<PartTemplate>& templates = draw(index);
            locate(index, image, templates, params_.minWindow * pixelScale_, true);
            tool.full->undo();
            if (inliers_.empty()) return false;
            tool.inliers = inliers_;
            tool.visibleParts = int(templates.size());
        }
        correctPoints(tool);
    }
    views_[index] = tool.full->view();
    drawOutline(index);
    refine(index, image);
    tool.correction = tool.full->correction();
    const bool good = meanSimilarity(tool.inliers) >= params_.minInitialSimilarity && plausible(tool, tool.correction);
    if (!good)
    {
        tool.full->undo();
        tool.correction = tool.full->correction();
        tool.inliers.clear();
    }
    return good;
}

bool ToolTrackerImpl::measureFull(int index, const Mat& image)
{
    TrackedTool& tool = tools_[index];
    const std::vector<PartTemplate>& templates = draw(index);
    locate(index, image, templates, params_.minWindow * pixelScale_, false);
    tool.inliers = inliers_;
    tool.visibleParts = int(templates.size());
    tool.contourSupport = 0;
    int passed = tool.inliers.empty() ? 0 : correctPoints(tool);
    if (passed >= 5 && tool.full->nis() > 3 && meanSimilarity(tool.inliers) > 0.55)
    {
        tool.full->undo();
        tool.full->inflate(CV_PI / 180, 0.002);
        tool.boosted = 10;
        passed = correctPoints(tool);
    }
    if (passed < 4)
    {
        tool.inliers.clear();
        return false;
    }
    size_t kept = 0;
    for (size_t i = 0; i < used_.size(); i++)
        if (used_[i]) tool.inliers[kept++] = tool.inliers[i];
    tool.inliers.resize(kept);
    drawOutline(index);
    refine(index, image);
    const bool found = tool.state != STATE_LOST
                       || (int(kept) >= params_.minInitialInliers && meanSimilarity(tool.inliers) >= params_.minInitialSimilarity);
    if (!found || !plausible(tool, tool.full->correction()))
    {
        tool.full->undo();
        return false;
    }
    tool.correction = tool.full->correction();
    tool.nis = tool.full->nis();
    return true;
}

}} // namespace cv::surgtrack
