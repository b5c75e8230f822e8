// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include <cerrno>
#include <clocale>
#include <cstdlib>
#include <cstring>
#include "opencv2/core/utils/filesystem.hpp"
#include "files/csv.hpp"
#include "files/text_file.hpp"

namespace cv { namespace surgtrack {

static bool isNumber(const char* text)
{
    char* end = 0;
    std::strtod(text, &end);
    return end != text && !*end;
}

CsvReader::CsvReader(const String& filename, bool recorded)
    : filename_(filename), lineNumber_(0), separator_(','), recorded_(recorded)
{
    const size_t mostColumns = 10000;
    if (utils::fs::exists(filename) && !isRegularFile(filename))
        CV_Error(Error::StsObjectNotFound, filename + ": can't be read: expected a file, not a folder, device or pipe");
    file_.open(filename.c_str(), std::ios::binary);
    if (!file_)
        CV_Error(Error::StsObjectNotFound, format("%s: can't be read: %s", filename.c_str(), std::strerror(errno)));
    readHeader();
    if (line_.find(',') == std::string::npos)
        separator_ = line_.find(';') != std::string::npos ? ';' : line_.find('\t') != std::string::npos ? '\t' : ',';
    split();
    if (isNumber(cells_[0]))
        fail("holds values, expected a header: the names of the columns");
    if (cells_.size() > mostColumns)
        fail(format("expected at most %d columns", (int)mostColumns));
    for (size_t i = 0; i < cells_.size(); i++)
    {
        const String name(cells_[i]);
        if (!name.empty() && find(name) >= 0)   // one without name, as pandas' index, is not asked for
            fail(format("column '%s' is there twice", name.c_str()));
        header_.push_back(name);
    }
}

//! Into line_. Comments come before it, or it is one, as of NumPy's savetxt(): then values follow.
void CsvReader::readHeader()
{
    std::string comment;
    int comments = 0;
    std::streampos behind = 0;
    for (;;)
    {
        if (!readLine())
            fail("the file is empty, expected a line with the names of the columns");
        if (line_.compare(0, 3, "\xEF\xBB\xBF") == 0)   // byte order mark, as spreadsheets write it
            line_.erase(0, 3);
        if (lineNumber_ == 1 && (line_.compare(0, 2, "\xFF\xFE") == 0 || line_.compare(0, 2, "\xFE\xFF") == 0))
            fail("is UTF-16, expected UTF-8 or ASCII");
        if (line_.empty() || line_[0] != '#')
            break;
        comment = line_;
        comments = lineNumber_;
        behind = file_.tellg();
        if (behind < 0 || file_.peek() == EOF)
            break;
    }
    const std::string first = line_.substr(0, line_.find_first_of(",;\t "));
    if (comments == 0 || (line_[0] != '#' && !isNumber(first.c_str())))
        return;
    file_.clear();
    file_.seekg(behind);
    lineNumber_ = comments;
    line_ = comment.substr(comment.compare(0, 2, "# ") == 0 ? 2 : 1);
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
    if (cells_.size() == header_.size() + 1 && !*cells_.back())   // a separator at the end of each row
        cells_.pop_back();
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
    if (file_.eof() && recorded_ && lineNumber_ > 2)
        return false;
    if (file_.eof())
        fail("the line is cut in the middle, expected an end of line");
    if (!line_.empty() && line_[line_.size() - 1] == '\r')
        line_.erase(line_.size() - 1);
    return true;
}

//! Takes the quotes off a cell. @return its end, behind the quotes
char* CsvReader::splitQuoted(char* cell)
{
    char* out = cell;
    for (char* in = cell + 1; *in; in++)
    {
        if (*in == '"' && in[1] != '"')
        {
            *out = 0;
            return in + 1;
        }
        in += *in == '"';
        *out++ = *in;
    }
    fail("a quote is opened and not closed");
}

void CsvReader::split()
{
    cells_.clear();
    char* cell = &line_[0];
    for (;;)
    {
        while (*cell == ' ' || (*cell == '\t' && separator_ != '\t'))
            cell++;
        char* const start = cell;
        const bool quoted = *cell == '"';
        if (quoted)
            cell = splitQuoted(cell);
        char* end = std::strchr(cell, separator_);
        if (!quoted)
        {
            char* last = end ? end : cell + std::strlen(cell);
            while (last > cell && (last[-1] == ' ' || last[-1] == '\t'))
                last--;
            *last = 0;
        }
        cells_.push_back(start);
        if (!end)
            return;
        cell = end + 1;
    }
}

bool CsvReader::isEmpty(int column) const
{
    const char* const nothing[] = { "", "nan", "NaN", "NAN", "NA", "N/A", "null", "NULL", "None", "<NA>" };
    for (size_t i = 0; i < sizeof(nothing) / sizeof(nothing[0]); i++)
        if (std::strcmp(cells_[column], nothing[i]) == 0)
            return true;
    return false;
}

double CsvReader::number(int column) const
{
    const char* cell = cells_[column];
    char* end = 0;
    double value = std::strtod(cell, &end);
    const bool decimalComma = *end == ',' && separator_ != ',';
    if (*end == '.' || decimalComma)   // the program, or the file, is of a locale with a decimal comma
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
    importError(format("%s, line %d", filename_.c_str(), lineNumber_), what);
}

}} // namespace cv::surgtrack
