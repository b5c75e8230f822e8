// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_FILES_TEXT_FILE_HPP
#define OPENCV_SURGTRACK_SRC_FILES_TEXT_FILE_HPP

#include <locale>
#include <map>
#include <sstream>
#include "opencv2/core.hpp"

namespace cv { namespace surgtrack {

CV_NORETURN void importError(const String& filename, const String& what, Error::Code code = Error::StsParseError);

//! The content of a text file, without byte order mark. @throws cv::Exception naming it
String readTextFile(const String& filename);

//! @throws cv::Exception naming the file if it can't be written as a whole
void writeText(const String& filename, const String& text);

//! The same, all or nothing: written beside, then renamed.
void writeAtOnce(const String& filename, const String& text);

//! A file of cv::FileStorage, whose root is a map. @throws cv::Exception naming it
FileStorage openStorage(const String& filename);

//! The same of its content.
FileStorage parseStorage(const String& filename, const String& text);

/** JSON, or YAML as ROS and PyYAML write it: without the line `%YAML:1.0`, lists not indented, and keys that are numbers. To such keys the
prefix `n` is added. Of several documents the first; numbers of a list may be without commas. */
FileStorage openYaml(const String& filename);

//! Splits `LABEL:VALUE`. @param what of the argument, for the error
std::pair<String, String> splitPair(const String& text, const char* what);

//! The pairs `LABEL:VALUE` by their labels.
std::map<String, String> pairsByLabel(const std::vector<String>& pairs, const char* what);

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
