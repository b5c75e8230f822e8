// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include <cerrno>
#include <clocale>
#include <cstdlib>
#include <cstring>
#include "files/csv.hpp"

namespace cv { namespace surgtrack {

CsvReader::CsvReader(const String& filename)
    : filename_(filename), file_(filename.c_str(), std::ios::binary), lineNumber_(0)
{
    if (!file_)
        CV_Error(Error::StsObjectNotFound, format("%s: can't be read: %s", filename.c_str(), std::strerror(errno)));
    if (!readLine())
        fail("the file is empty, expected a line with the names of the columns");
    if (line_.compare(0, 3, "\xEF\xBB\xBF") == 0)   // byte order mark, as spreadsheets write it
        line_.erase(0, 3);
    split();
    for (size_t i = 0; i < cells_.size(); i++)
    {
        const String name(cells_[i]);
        if (name.empty())
            fail(format("column %d has no name", (int)i + 1));
        if (find(name) >= 0)
            fail(format("column '%s' is there twice", name.c_str()));
        header_.push_back(name);
    }
}

int CsvReader::find(const String& name) const
{
    for (size_t i = 0; i < header_.size(); i++)
        if (header_[i] == name)
            return (int)i;
    return -1;
}

int CsvReader::column(const String& name) const
{
    const int index = find(name);
    if (index < 0)
        CV_Error(Error::StsParseError, format("%s, line 1: expected a column '%s'", filename_.c_str(), name.c_str()));
    return index;
}

bool CsvReader::next()
{
    do
    {
        if (!readLine())
            return false;
    }
    while (line_.empty());
    split();
    if (cells_.size() != header_.size())
        fail(format("%d values, expected %d as in the first line", (int)cells_.size(), (int)header_.size()));
    return true;
}

bool CsvReader::readLine()
{
    if (!std::getline(file_, line_))
    {
        if (file_.bad())
            fail("can't be read");
        return false;
    }
    lineNumber_++;
    if (file_.eof())
        fail("the line is cut in the middle, expected an end of line");
    if (!line_.empty() && line_[line_.size() - 1] == '\r')
        line_.erase(line_.size() - 1);
    return true;
}

void CsvReader::split()
{
    cells_.clear();
    char* cell = &line_[0];
    for (;;)
    {
        char* end = std::strchr(cell, ',');
        char* last = end ? end : cell + std::strlen(cell);
        while (*cell == ' ' || *cell == '\t')
            cell++;
        while (last > cell && (last[-1] == ' ' || last[-1] == '\t'))
            last--;
        *last = 0;
        cells_.push_back(cell);
        if (!end)
            return;
        cell = end + 1;
    }
}

double CsvReader::number(int column) const
{
    const char* cell = cells_[column];
    char* end = 0;
    double value = std::strtod(cell, &end);
    if (*end == '.')   // the program runs in a locale with a decimal comma
    {
        std::string local(cell);
        local.replace(end - cell, 1, std::localeconv()->decimal_point);
        char* localEnd = 0;
        value = std::strtod(local.c_str(), &localEnd);
        end = const_cast<char*>(*localEnd ? "?" : "");
    }
    if (end == cell || *end)
        fail(format("%s is '%s', expected a number", header_[column].c_str(), cell));
    if (cvIsNaN(value) || cvIsInf(value))
        fail(format("%s is '%s', expected a finite number", header_[column].c_str(), cell));
    return value;
}

int CsvReader::count(int column) const
{
    const double value = number(column);
    if (value < 0 || value > INT_MAX || value != std::floor(value))
        fail(format("%s is '%s', expected a whole number from 0", header_[column].c_str(), cells_[column]));
    return (int)value;
}

void CsvReader::fail(const String& what) const
{
    CV_Error(Error::StsParseError, format("%s, line %d: %s", filename_.c_str(), lineNumber_, what.c_str()));
}

}} // namespace cv::surgtrack
