// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_FILES_PLY_READER_HPP
#define OPENCV_SURGTRACK_SRC_FILES_PLY_READER_HPP

#include <sstream>
#include "opencv2/surgtrack/tool_model.hpp"
#include "files/text_file.hpp"

namespace cv { namespace surgtrack {

/** Reads PLY files and checks them: what is damaged is an error, never a part of the mesh.

Assimp 5.2 loses the first byte of a binary body that is a line feed, and takes what is cut off for a mesh of zeros. */
class PlyReader
{
public:
    PlyReader(const String& filename, const std::string& data) : filename_(filename), data_(data), pos_(0) {}

    Mesh read();

    CV_NORETURN void fail(const String& what) const { importError(filename_, what); }

private:
    struct Type { int size; bool isInteger, isSigned; };
    struct Property { String name; Type count, value; };   // count.size 0: not a list
    struct Element { String name; int64 count; std::vector<Property> properties; };

    std::vector<Element> readHeader(String& plyFormat);
    void needPLYProperty(const std::vector<Element>& elements, const char* element, const char* property, bool list) const;
    static Type plyType(const String& name);
    double nextValue(const Type& type, bool bigEndian);
    void addFace(const std::vector<double>& corners, int64 vertices);
    void addNumber(const Element& element, const Property& property, double value);
    void readTextElement(const Element& element, int64 vertices);
    void readBinaryElement(const Element& element, int64 vertices, bool bigEndian);
    double nextNumber();
    int64 nextInteger(const Type& type, bool bigEndian);

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
    const std::string& data_;
    size_t pos_;
    std::vector<double> values_;
    Mesh mesh_;
};

}} // namespace cv::surgtrack

#endif
