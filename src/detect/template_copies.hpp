// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_DETECT_TEMPLATE_COPIES_HPP
#define OPENCV_SURGTRACK_SRC_DETECT_TEMPLATE_COPIES_HPP

#include "opencv2/surgtrack/part_templates.hpp"

namespace cv { namespace surgtrack {

//! Copies of templates, to be changed; what a frame takes of memory is kept for the next one, whichever parts it sees.
class TemplateCopies
{
public:
    std::vector<PartTemplate>& of(const std::vector<PartTemplate>& templates)
    {
        while (copies_.size() > templates.size())
        {
            spare_.push_back(std::vector<TemplateFeature>());
            spare_.back().swap(copies_.back().features);
            copies_.pop_back();
        }
        while (copies_.size() < templates.size())
        {
            copies_.push_back(PartTemplate());
            if (spare_.empty()) continue;
            copies_.back().features.swap(spare_.back());
            spare_.pop_back();
        }
        for (size_t i = 0; i < templates.size(); i++) copies_[i] = templates[i];
        return copies_;
    }

private:
    std::vector<PartTemplate> copies_;
    std::vector<std::vector<TemplateFeature> > spare_;
};

}} // namespace cv::surgtrack

#endif
