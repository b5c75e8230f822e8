// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_FILES_MESH_CHECK_HPP
#define OPENCV_SURGTRACK_SRC_FILES_MESH_CHECK_HPP

#include "opencv2/surgtrack/tool_model.hpp"
#include "files/text_file.hpp"

namespace cv { namespace surgtrack {

/** STL, and a check of OBJ. Whether an STL file is text or binary is decided here alone: Assimp 5.2 takes a text with letters that are not ASCII
for binary, and its size from there. And it takes OBJ for a mesh though it is damaged: numbers that are none, faces with vertices that are not
there. Such a file is an error, never a part of the mesh. */
class MeshCheck
{
public:
    //! @param data the file's content
    MeshCheck(const String& filename, const std::string& data) : filename_(filename), data_(data), pos_(0) {}

    Mesh readSTL();
    //! @return what of the file is a mesh: its vertices and faces
    std::string checkedOBJ();

private:
    CV_NORETURN void fail(const String& what) const { importError(filename_, what); }
    Mesh readTextSTL();
    Mesh readBinarySTL(int64 triangles) const;
    String nextWord();
    float nextNumber();
    void checkVertex(const char* text, int line, std::string& checked) const;
    void checkFace(const char* text, const int64* count, int line, std::string& checked) const;

    String filename_;
    const std::string& data_;
    size_t pos_;
};

}} // namespace cv::surgtrack

#endif
