// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_FILES_TEXT_TABLE_HPP
#define OPENCV_SURGTRACK_SRC_FILES_TEXT_TABLE_HPP

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <locale>
#include <sstream>
#include "opencv2/core.hpp"

namespace cv { namespace surgtrack {

//! @throws cv::Exception naming the file if it can't be written as a whole
inline void writeText(const String& filename, const String& text)
{
    FILE* file = std::fopen(filename.c_str(), "wb");
    const bool written = file && std::fwrite(text.data(), 1, text.size(), file) == text.size() && std::fflush(file) == 0;
    const String reason = written ? "" : std::strerror(errno);
    const bool closed = !file || std::fclose(file) == 0;
    if (!written || !closed)
        CV_Error(Error::StsError, format("%s: can't be written: %s", filename.c_str(), reason.c_str()));
}

//! Text with the decimal point whatever the locale.
class Table
{
public:
    explicit Table(const String& header)
    {
        text_.imbue(std::locale::classic());
        text_.precision(9);
        text_ << header;
    }
    Table& operator<<(const String& s) { text_ << s; return *this; }
    Table& operator<<(int v) { text_ << v; return *this; }
    Table& operator<<(double v) { text_ << v; return *this; }
    void write(const String& filename) const { writeText(filename, text_.str()); }

private:
    std::ostringstream text_;
};

}} // namespace cv::surgtrack

#endif
