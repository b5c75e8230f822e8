// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_FILES_CSV_HPP
#define OPENCV_SURGTRACK_SRC_FILES_CSV_HPP

#include <fstream>
#include <vector>
#include "opencv2/core.hpp"

namespace cv { namespace surgtrack {

/** Reads a CSV file row by row; columns are found by the names in its first line. Cells are separated by commas, or by semicolons or
tabs if the first line has no comma; what stands in quotes is one cell. Whatever is wrong is a cv::Exception that names file and line. A file ends with an end of line: without it its last row was cut, and a cut number still looks like one. */
class CsvReader
{
public:
    /** @param recorded by another program: a last line without an end of line is passed over, as of a recorder that was stopped; else it is an error
    @throws cv::Exception if the file can't be read or has no header */
    explicit CsvReader(const String& filename, bool recorded = false);

    const std::vector<String>& header() const { return header_; }
    //! Index of a column, or -1.
    int find(const String& name) const;
    //! Index of a column that must be there.
    int column(const String& name) const;

    //! Goes to the next row. @return false at the end of the file
    bool next();
    const char* text(int column) const { return cells_[column]; }
    //! Nothing, or what programs write for nothing: nan, NA, null.
    bool isEmpty(int column) const;
    //! The finite number in a cell.
    double number(int column) const;
    //! The frame number, or another count, in a cell.
    int count(int column) const;

    //! Throws: file, line, and what is wrong.
    CV_NORETURN void fail(const String& what) const;

private:
    bool readLine();
    void readHeader();
    void split();
    char* splitQuoted(char* cell);

    String filename_;
    std::ifstream file_;
    std::string line_;
    int lineNumber_;
    char separator_;
    bool recorded_;
    std::vector<String> header_;
    std::vector<char*> cells_;   // into line_
};

}} // namespace cv::surgtrack

#endif
