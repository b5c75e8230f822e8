// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_FILES_STORAGE_CHECK_HPP
#define OPENCV_SURGTRACK_SRC_FILES_STORAGE_CHECK_HPP

#include "opencv2/core.hpp"

namespace cv { namespace surgtrack {

/** What the readers of cv::FileStorage can't be given, in YAML, XML and JSON: they call themselves for each level (50,000 end the program), go
beyond their buffers where a text ends within a value or a key is empty, and some texts of 37 bytes keep them for ever. A text that passes has
at most 64 levels, each of them closed, one document and no base64. What is only wrong is left to them. */
class StorageCheck
{
public:
    //! @param added lines before those of the file
    StorageCheck(const String& filename, const String& text, int added) : filename_(filename), text_(text), line_(1 - added), pos_(0), pending_(true) {}

    //! The text they can be given. @throws cv::Exception naming file and line
    String checked();

    //! That matrices have as many numbers as they say: else memory is taken for those they say.
    static void checkMatrices(const String& filename, const FileNode& node);

private:
    CV_NORETURN void fail(const String& what) const;
    void checkYaml();
    void checkLine();
    void checkFlow();
    void checkXml();
    void checkJson();

    bool isEnd() const { return pos_ >= text_.size() || text_[pos_] == '\n' || text_[pos_] == '\r'; }
    char next() const { return pos_ + 1 < text_.size() ? text_[pos_ + 1] : '\0'; }
    bool isNumber() const;
    void skipSpaces();
    void skipLines();
    void endLine();
    bool skipTo(char c);
    void skipText();
    void skipTag();

    String filename_, text_;
    int line_;
    size_t pos_;
    bool pending_;   // a value follows, not a key
};

}} // namespace cv::surgtrack

#endif
