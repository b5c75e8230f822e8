// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_FILES_MESH_READER_HPP
#define OPENCV_SURGTRACK_SRC_FILES_MESH_READER_HPP

#include <fstream>
#include <sstream>
#include "opencv2/core.hpp"
#include "opencv2/core/utils/filesystem.hpp"

namespace cv { namespace surgtrack {

// Reads mesh files and checks them: what is damaged is an error, never a part of the mesh.
class MeshFileReader
{
public:
    explicit MeshFileReader(const String& filename) : filename_(filename), pos_(0)
    {
        std::ifstream file;
        if (!utils::fs::isDirectory(filename))
            file.open(filename.c_str(), std::ios::binary);
        if (!file.is_open())
            CV_Error(Error::StsObjectNotFound, filename + ": expected a mesh file that can be read");
        std::ostringstream content;
        content << file.rdbuf();
        data_ = content.str();
        if (data_.compare(0, 42, "version https://git-lfs.github.com/spec/v1") == 0)
            fail("is the pointer git-LFS leaves in the place of a file, expected the mesh itself: run `git lfs pull` where it comes from");
    }

    void readPLY();
    void readSTL();
    void readOBJ();

    const std::vector<Point3d>& points() const { return points_; }
    //! Number of corners and then their points, a face after the other.
    const std::vector<int>& faces() const { return faces_; }

    CV_NORETURN void fail(const String& what) const { CV_Error(Error::StsParseError, filename_ + ": " + what); }

private:
    struct Type { int size; bool isInteger, isSigned; };
    struct Property { String name; Type count, value; };   // count.size 0: not a list
    struct Element { String name; int64 count; std::vector<Property> properties; };

    std::vector<Element> readPLYHeader(String& plyFormat);
    void needPLYProperty(const std::vector<Element>& elements, const char* element, const char* property, bool list) const;
    static Type plyType(const String& name);
    void addPLYFace(const std::vector<double>& indices, int64 vertices);
    void addPLYItem(const Element& element, const Property& property, const std::vector<double>& values, int64 vertices);
    void readTextElement(const Element& element, int64 vertices);
    void readBinaryElement(const Element& element, int64 vertices, bool bigEndian);
    double nextNumber();
    int64 nextInteger(const Type& type, bool bigEndian);
    double nextValue(const Type& type, bool bigEndian);
    void readBinarySTL(int64 triangles);
    void readTextSTL();
    void readOBJVertex(std::istream& words, int line);
    void addFace(const std::vector<int>& corners);

    bool nextLine(String& line)
    {
        if (pos_ >= data_.size())
            return false;
        const size_t end = std::min(data_.find('\n', pos_), data_.size());
        line = data_.substr(pos_, end - pos_);
        if (!line.empty() && line[line.size() - 1] == '\r')
            line.resize(line.size() - 1);
        pos_ = end + 1;
        return true;
    }

    int readOBJCorner(const String& corner, const int64* count, int line) const;

    void nextPLYLine(String& line, const char* expected)
    {
        if (!nextLine(line))
            fail(String("truncated: expected ") + expected);
        for (size_t i = 0; i < line.size(); ++i)
            if ((uchar)line[i] < ' ' && line[i] != '\t')
                fail("expected text, found `" + line.substr(0, 40) + "`");
    }

    void need(int64 bytes) const
    {
        if (bytes > (int64)data_.size() - (int64)pos_)
            fail(format("truncated: expected %lld bytes more than its %lld", (long long)(bytes - ((int64)data_.size() - (int64)pos_)),
                        (long long)data_.size()));
    }

    String filename_;
    std::string data_;
    size_t pos_;
    std::vector<Point3d> points_;
    std::vector<int> faces_;
};

}} // namespace cv::surgtrack

#endif
