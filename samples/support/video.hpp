// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// What the files of videos say of themselves, and may be wrong about.

#ifndef OPENCV_SURGTRACK_SAMPLES_SUPPORT_VIDEO_HPP
#define OPENCV_SURGTRACK_SAMPLES_SUPPORT_VIDEO_HPP

#include <cstdio>
#include <fstream>
#include "opencv2/videoio.hpp"

namespace common {

//! Frames as the camera delivered them, and was calibrated with: not turned as the file's header asks for.
inline void asRecorded(cv::VideoCapture& capture)
{
#if CV_VERSION_MAJOR > 4 || CV_VERSION_MINOR >= 5
    capture.set(cv::CAP_PROP_ORIENTATION_AUTO, 0);
#else
    (void)capture;
#endif
}

//! Says so if the header of a video asks for its frames to be turned: players do, and its calibration may be of those.
inline void noteTurned(const cv::VideoCapture& capture, const cv::String& filename)
{
#if CV_VERSION_MAJOR > 4 || CV_VERSION_MINOR >= 5
    const int turned = cvRound(capture.get(cv::CAP_PROP_ORIENTATION_META));
    if (turned == 90 || turned == 180 || turned == 270)
        std::fprintf(stderr, "note: %s: is to be rotated by %d degrees by its header, its frames are taken as they were recorded\n", filename.c_str(), turned);
#else
    (void)capture;
    (void)filename;
#endif
}

//! Says so if the header of a video has another rate. @param fps 0: none is expected
inline void warnOfRate(cv::VideoCapture& capture, const cv::String& filename, double fps)
{
    const double found = capture.get(cv::CAP_PROP_FPS);
    const bool images = filename.find('%') != cv::String::npos;    // have no rate of their own
    if (fps > 0 && found > 0 && found < 1000 && !images && std::abs(found - fps) > 0.01 * fps)
        std::fprintf(stderr, "warning: %s: %g frames/s by its header, %g by fps: is fps right?\n", filename.c_str(), found, fps);
}

//! Whether an MP4 was cut in the middle of its data, as by a full disk: a box of it goes on beyond its end. Others can't be told: they are.
inline bool isCut(const cv::String& filename)
{
    std::ifstream file(filename.c_str(), std::ios::binary | std::ios::ate);
    const double size = (double)file.tellg();
    double at = 0;
    for (int boxes = 0; at < size; boxes++)
    {
        unsigned char box[16] = {};
        file.seekg((std::streamoff)at);
        file.read((char*)box, 16);
        const bool known = boxes > 0 || std::string((const char*)box + 4, 4) == "ftyp";
        double length = 0;
        for (int i = 0; i < 4; i++)
            length = length * 256 + box[i];
        const bool longer = length == 1;   // in 64 bits
        length = longer ? 0 : length;
        if (longer)
            for (int i = 8; i < 16; i++)
                length = length * 256 + box[i];
        else if (length == 0)
            return !known;   // to the end of the file
        if (!known || length < 8 || file.gcount() < 8)
            return true;
        at += length;
    }
    return at != size || size == 0;
}

} // namespace common

#endif
