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

//! A line of bounded length, whatever of the file is repeated in it.
CV_NORETURN void importError(const String& filename, const String& what, Error::Code code = Error::StsParseError);

//! Whether this is a file with an end, and not a folder, a pipe or a device, which may never have one.
bool isRegularFile(const String& filename);

//! The content of a file, bytes as they are. @param expected for the error. @throws cv::Exception naming it
String readContent(const String& filename, const char* expected);

//! std::strtod() of a text with a decimal point, whatever the locale.
double toDouble(const char* text, const char*& end);

//! The content of a text file, without byte order mark. @throws cv::Exception naming it
String readTextFile(const String& filename);

/** All or nothing: written beside it under a temporary name, then renamed. Devices and pipes are written to.
@throws cv::Exception naming the file if it can't be written as a whole; what was there before still is */
void writeContent(const String& filename, const String& content);

//! A file of cv::FileStorage, whose root is a map. @throws cv::Exception naming it
FileStorage openStorage(const String& filename);

//! The same of its content.
FileStorage parseStorage(const String& filename, const String& text);

//! One to be filled, in the format that the name asks for, and then written by writeContent().
FileStorage newStorage(const String& filename);

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
    void write(const String& filename) const { writeContent(filename, text_.str()); }

private:
    std::ostringstream text_;
};

}} // namespace cv::surgtrack

#endif
