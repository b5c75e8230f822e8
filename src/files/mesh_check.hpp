// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_FILES_MESH_CHECK_HPP
#define OPENCV_SURGTRACK_SRC_FILES_MESH_CHECK_HPP

#include "opencv2/core.hpp"

namespace cv { namespace surgtrack {

/** What Assimp would take for a mesh though it is damaged, or not take though it is none the worse: texts of STL that are cut off, spaces before and
bytes behind; numbers in OBJ that are none, and faces with vertices that are not there. Such a file is an error, never a part of the mesh. */
class MeshCheck
{
public:
    //! @param data the file's content; spaces before an STL and what follows it are dropped
    MeshCheck(const String& filename, std::string& data) : filename_(filename), data_(data), pos_(0) {}

    void checkSTL();
    void checkOBJ();

private:
    CV_NORETURN void fail(const String& what) const { CV_Error(Error::StsParseError, filename_ + ": " + what); }
    void checkTextSTL();
    String nextWord();
    double nextNumber();
    void checkVertex(const char* text, int line) const;
    void checkFace(const char* text, const int64* count, int line) const;

    String filename_;
    std::string& data_;
    size_t pos_;
};

}} // namespace cv::surgtrack

#endif
