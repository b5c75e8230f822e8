// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// A window with the tools where they are found.

#ifndef OPENCV_SURGTRACK_SAMPLES_LIVE_WINDOW_HPP
#define OPENCV_SURGTRACK_SAMPLES_LIVE_WINDOW_HPP

#include "opencv2/opencv_modules.hpp"
#ifdef HAVE_OPENCV_HIGHGUI
#include "opencv2/highgui.hpp"
#endif
#include "opencv2/surgtrack.hpp"
#include "../support/common.hpp"
#include "../support/tools.hpp"

namespace common {

class LiveWindow
{
public:
    //! Throws if there can't be a window.
    LiveWindow() : renderer_(cv::surgtrack::MeshRenderer::createSoftware())
    {
        std::string reason = "without highgui";
#ifdef HAVE_OPENCV_HIGHGUI
        try
        {
            cv::namedWindow("live");
            return;
        }
        catch (const cv::Exception& e)
        {
            reason = e.err;
        }
#endif
        fail("argument '--show': there is no window without a display and an OpenCV built with GTK or Qt (" + reason + ")");
    }

    //! @return false: the user wants it to end
    bool show(const cv::Mat& image, const cv::surgtrack::CameraModel& camera, const std::vector<Tool>& tools,
              const std::vector<cv::surgtrack::ToolEstimate>& estimates)
    {
        cv::Mat picture = image.clone();
        std::vector<cv::surgtrack::DrawnTool> found;
        for (size_t i = 0; i < tools.size(); i++)
            if (isKnown(estimates[i]))
                found.push_back(cv::surgtrack::DrawnTool(tools[i].model, estimates[i]));
        cv::surgtrack::drawTools(picture, camera, found, renderer_);
        for (size_t i = 0; i < tools.size(); i++)
            cv::surgtrack::drawEvidence(picture, estimates[i], tools[i].info.name, (int)i);
#ifdef HAVE_OPENCV_HIGHGUI
        cv::imshow("live", picture);
        return cv::waitKey(1) != 27;
#else
        return false;
#endif
    }

private:
    cv::Ptr<cv::surgtrack::MeshRenderer> renderer_;
};

} // namespace common

#endif
