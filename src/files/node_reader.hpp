// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_FILES_NODE_READER_HPP
#define OPENCV_SURGTRACK_SRC_FILES_NODE_READER_HPP

#include <set>
#include "opencv2/core.hpp"

namespace cv { namespace surgtrack {

//! The path of a file that another file names: from that one's folder, unless it is absolute.
String besideFile(const String& filename, const String& path);

//! The matrix of a node; empty if it holds none, or one without its numbers. @param reason cv::FileStorage's, in brackets
Mat matrixOf(const FileNode& node, String* reason = 0);

/** A node of a file of cv::FileStorage that knows where it is, for errors that say so: `FILE: key PATH: expected WHAT`. Asking a node
that is not there for anything is such an error. */
class NodeReader
{
public:
    NodeReader(const String& filename, const FileNode& node, const String& path = String(), const String& alike = String())
        : filename_(filename), path_(path), alike_(alike), node_(node)
    {
    }

    CV_NORETURN void fail(const String& what, Error::Code code = Error::StsParseError) const;
    CV_NORETURN void expected(const String& what) const;    //!< and there is something else, or nothing

    bool isThere() const { return !node_.empty(); }
    bool has(const String& key) const { return (*this)[key].isThere(); }
    NodeReader operator[](const String& key) const;

    //! A map that holds no other keys than these, and none twice.
    const NodeReader& map(const std::set<String>& keys) const;
    //! Other keys may be there, but none that looks like one of these misspelt.
    void checkSpelling(const std::vector<String>& keys) const;
    std::vector<NodeReader> sequence() const;

    String text(const char* what = "a string") const;       //!< not empty
    String path(const char* what = "the path of a file") const;    //!< see besideFile()
    double number() const;
    int count(const char* what) const;                      //!< from 1 on
    Mat matrix(const char* what) const;                     //!< CV_64F, one channel, of any size
    Matx44d rigid() const;

private:
    String filename_, path_;
    String alike_;   // where this is not there: a key that looks like it
    FileNode node_;
};

}} // namespace cv::surgtrack

#endif
