// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_FILES_TEXT_FILE_HPP
#define OPENCV_SURGTRACK_SRC_FILES_TEXT_FILE_HPP

#include <map>
#include "opencv2/core.hpp"

namespace cv { namespace surgtrack {

CV_NORETURN void importError(const String& filename, const String& what, int code = Error::StsParseError);

//! The content of a text file. @throws cv::Exception naming it
String readTextFile(const String& filename);

//! A file of cv::FileStorage. @throws cv::Exception naming it
FileStorage openStorage(const String& filename);

/** YAML as ROS and PyYAML write it: without the line `%YAML:1.0`, lists not indented, and keys that are numbers. To such keys the
prefix `n` is added. */
FileStorage openYaml(const String& filename);

//! Splits `LABEL:VALUE`. @param what of the argument, for the error
std::pair<String, String> splitPair(const String& text, const char* what);

//! The pairs `LABEL:VALUE` by their labels.
std::map<String, String> pairsByLabel(const std::vector<String>& pairs, const char* what);

}} // namespace cv::surgtrack

#endif
