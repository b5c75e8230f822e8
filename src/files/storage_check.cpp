// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include <cctype>
#include "files/storage_check.hpp"
#include "files/text_file.hpp"

namespace cv { namespace surgtrack {

namespace {

const size_t deepest = 64;       // levels of brackets or tags, or of keys on a line
const size_t widest = 256;       // column that a line may begin at: each level of lines begins further to the right

} // namespace

void StorageCheck::fail(const String& what) const
{
    importError(filename_ + format(", line %d", std::max(line_, 1)), what);
}

String StorageCheck::checked()
{
    if (text_.find('\0') != String::npos)
        CV_Error(Error::StsParseError, filename_ + ": expected a text, found a byte 0");
    if (text_.empty() || text_[text_.size() - 1] != '\n')
        text_ += '\n';
    if (text_.compare(0, 5, "%YAML") == 0)
        checkYaml();
    else if (text_.compare(0, 5, "<?xml") == 0)
        checkXml();
    else if (text_[0] == '{')
        checkJson();
    return text_;   // what is none of these is refused by its first bytes
}

void StorageCheck::checkMatrices(const String& filename, const FileNode& node)
{
    if (node.isMap() && node["dt"].isString() && !node["data"].empty())
    {
        const FileNode rows = node["rows"], cols = node["cols"];
        const int64 data = node["data"].isSeq() ? (int64)node["data"].size() : 1;
        const int64 few = 10000;   // of so many the reader of the key tells
        if (!rows.isInt() || !cols.isInt() || (int)rows < 0 || (int)cols < 0 || (int64)(int)rows * (int)cols > std::max(data, few))
            importError(filename, "key " + (node.isNamed() ? node.name() : String("[]")) + format(": expected a matrix of rows x cols numbers, found %lld", (long long)data));
    }
    if (node.isMap() || node.isSeq())
        for (FileNodeIterator it = node.begin(); it != node.end(); ++it)
            if ((*it).isMap() || (*it).isSeq())
                checkMatrices(filename, *it);
}

void StorageCheck::skipSpaces()
{
    while (pos_ < text_.size() && (text_[pos_] == ' ' || text_[pos_] == '\t'))
        pos_++;
}

void StorageCheck::endLine()
{
    const size_t end = text_.find('\n', pos_);
    pos_ = end == String::npos ? text_.size() : end + 1;
    line_++;
}

//! Spaces, comments and ends of lines.
void StorageCheck::skipLines()
{
    for (skipSpaces(); pos_ < text_.size() && (isEnd() || text_[pos_] == '#'); skipSpaces())
        endLine();
}

//! Behind the next one of this character on the line.
bool StorageCheck::skipTo(char c)
{
    while (!isEnd() && text_[pos_] != c)
        pos_++;
    if (isEnd())
        return false;
    pos_++;
    return true;
}

//! A text in quotes.
void StorageCheck::skipText()
{
    const char quote = text_[pos_++];
    for (; !isEnd(); pos_++)
    {
        if (quote == '"' && text_[pos_] == '\\')
            pos_++;
        else if (text_[pos_] == quote && quote == '\'' && next() == quote)
            pos_++;
        else if (text_[pos_] == quote)
            break;
        if (isEnd())
            break;
    }
    if (isEnd())
        fail("a quote is opened and not closed");
    pos_++;
}

//! The type of a value, such as !!opencv-matrix.
void StorageCheck::skipTag()
{
    const size_t start = pos_;
    while (!isEnd() && text_[pos_] != ' ')
        pos_++;
    const String tag = text_.substr(start, pos_ - start);
    if (tag.find("binary") != String::npos || tag.find('<') != String::npos || tag.find_first_not_of('!') == String::npos)
        fail("expected a value in words and numbers, found one of type " + tag.substr(0, 40));
}

bool StorageCheck::isNumber() const
{
    const char c = text_[pos_], d = next();
    return std::isdigit((uchar)c) || ((c == '-' || c == '+') && (std::isdigit((uchar)d) || d == '.')) || (c == '.' && std::isalnum((uchar)d));
}

//! From an opening bracket to behind the one that closes it, over lines.
void StorageCheck::checkFlow()
{
    String open;   // brackets
    bool first = true;
    do
    {
        if (open.empty() || text_[pos_] == '[' || text_[pos_] == '{')
        {
            open += text_[pos_++];
            first = true;
            if (open.size() > deepest)
                fail(format("expected at most %d levels of brackets", (int)deepest));
        }
        else if (text_[pos_] == '\'' || text_[pos_] == '"')
            skipText();
        else
        {
            const size_t start = pos_;
            while (!isEnd() && text_[pos_] != ',' && text_[pos_] != ']' && text_[pos_] != '}')
                pos_++;
            if (pos_ == start)
                fail("expected a value");
        }
        for (skipLines(); pos_ < text_.size() && (text_[pos_] == ']' || text_[pos_] == '}'); skipLines())
        {
            if (text_[pos_] != (open[open.size() - 1] == '[' ? ']' : '}'))
                fail("expected the bracket that closes the last one opened");
            pos_++;
            first = false;
            open.resize(open.size() - 1);
            if (open.empty())
                return;
        }
        if (pos_ >= text_.size())
            fail("a bracket is opened and not closed");
        if (!first && text_[pos_++] != ',')
            fail("expected a comma between values");
        first = false;
        skipLines();
        const bool key = open[open.size() - 1] == '{';
        if (pos_ >= text_.size() || text_[pos_] == ']' || text_[pos_] == '}' || (key && (text_[pos_] == '-' || text_[pos_] == ':' || !skipTo(':'))))
            fail(key ? "expected KEY: VALUE" : "expected a value after the comma");
        skipLines();
        if (pos_ < text_.size() && text_[pos_] == '!')
        {
            skipTag();
            skipLines();
        }
    }
    while (pos_ < text_.size());
    fail("a bracket is opened and not closed");
}

//! A line of keys, items and their values; with what is in brackets the lines that these go on to.
void StorageCheck::checkLine()
{
    size_t levels = 0;
    for (skipSpaces(); !isEnd() && text_[pos_] != '#'; skipSpaces())
    {
        const char c = text_[pos_];
        if (++levels > deepest)
            fail(format("expected at most %d levels on a line", (int)deepest));
        if (c == '-' && !(pending_ && isNumber()))
        {
            pos_++;
            pending_ = true;
        }
        else if (pending_ && c == '!')
            skipTag();
        else if (pending_ && (c == '[' || c == '{' || c == '\'' || c == '"' || isNumber()))
        {
            if (c == '[' || c == '{')
                checkFlow();
            else if (c == '\'' || c == '"')
                skipText();
            else
                while (!isEnd() && text_[pos_] != ' ')
                    pos_++;
            skipSpaces();
            if (!isEnd() && text_[pos_] != '#')
                fail("expected an end of line after the value");
            pending_ = false;
            break;
        }
        else if (c == ':')
            fail("expected a key before the colon");
        else if (skipTo(':'))
            pending_ = true;
        else if (!pending_)
            fail("expected KEY: VALUE");
        else
        {
            pending_ = false;   // a text
            break;
        }
    }
    endLine();
}

void StorageCheck::checkYaml()
{
    bool marked = false, begun = false, closed = false;   // marked: by `---`, behind which nothing is a directive
    size_t root = 0;
    while (pos_ < text_.size())
    {
        const size_t start = pos_;
        skipSpaces();
        const size_t column = pos_ - start;
        if (isEnd() || text_[pos_] == '#' || (!marked && !begun && text_[pos_] == '%'))
        {
            endLine();
            continue;
        }
        if (text_.compare(pos_, 3, "...") == 0)   // the end of the document: what follows is not read
        {
            text_.resize(start);
            break;
        }
        if (!marked && !begun && text_.compare(pos_, 3, "---") == 0)
        {
            marked = true;
            pos_ += 3;
            skipSpaces();
            if (isEnd() || text_[pos_] == '#')
            {
                endLine();
                continue;
            }
        }
        if (closed || (begun && column < root))
            fail("expected one map, found more after its end");
        if (column > widest)
            fail(format("expected lines that begin before column %d", (int)widest));
        if (!begun)
        {
            root = pos_ - start;   // it may stand behind `---`
            closed = text_[pos_] == '[' || text_[pos_] == '{';
        }
        begun = true;
        checkLine();
    }
}

void StorageCheck::checkXml()
{
    size_t levels = 0, counted = 0;
    bool ended = false;
    while ((pos_ = text_.find_first_not_of(" \t\r\n", pos_)) != String::npos)
    {
        const size_t tag = text_.find('<', pos_);
        line_ += (int)std::count(text_.begin() + counted, text_.begin() + pos_, '\n');
        if (tag != pos_ && (levels == 0 || tag == String::npos))
            fail("expected a tag");
        const bool comment = text_.compare(tag, 4, "<!--") == 0, header = text_.compare(tag, 2, "<?") == 0, closing = text_.compare(tag, 2, "</") == 0;
        size_t end = comment ? text_.find("-->", tag + 4) : tag + 1;
        if (!comment)
            for (char quote = 0; end < text_.size() && (quote || text_[end] != '>'); end++)
                quote = quote ? (text_[end] == quote ? '\0' : quote) : text_[end] == '"' || text_[end] == '\'' ? text_[end] : '\0';
        if (end >= text_.size() || (header && (tag > 0 || text_[end - 1] != '?')) || (!comment && !header && !closing && !std::isalpha((uchar)text_[tag + 1]) && text_[tag + 1] != '_'))
            fail("expected tags that are closed");
        if (ended && !comment)
            fail("expected one map, found more after its end");
        if (text_.substr(tag, std::min(end - tag, (size_t)1000)).find("binary") != String::npos && !comment)
            fail("expected a value in words and numbers, found a tag of binary ones");
        if (closing && levels-- == 0)
            fail("expected tags that are closed, each once");
        ended = ended || (closing && levels == 0);
        levels += !comment && !header && !closing;
        if (levels > deepest)
            fail(format("expected at most %d levels of tags", (int)deepest));
        counted = pos_;
        pos_ = end + (comment ? 3 : 1);
    }
    if (levels || !ended)
        fail("a tag is opened and not closed");
}

void StorageCheck::checkJson()
{
    size_t levels = 0;
    for (; pos_ < text_.size(); pos_++)
    {
        const char c = text_[pos_];
        line_ += c == '\n';
        if (c == '"')
        {
            if (text_.compare(pos_ + 1, 8, "$base64$") == 0)
                fail("expected a value in words and numbers, found one of base64");
            skipText();
            pos_--;
        }
        else if (c == '/' && next() == '*')
        {
            const size_t end = text_.find("*/", pos_ + 2);
            if (end == String::npos)
                fail("a comment is opened and not closed");
            line_ += (int)std::count(text_.begin() + pos_, text_.begin() + end, '\n');
            pos_ = end + 1;
        }
        else if (c == '/')
        {
            endLine();
            pos_--;
        }
        else if ((c == ']' || c == '}') && levels-- == 0)
            fail("expected each bracket to be opened");
        else if ((c == '[' || c == '{') && ++levels > deepest)
            fail(format("expected at most %d levels of brackets", (int)deepest));
    }
    if (levels)
        fail("a bracket is opened and not closed");
}

}} // namespace cv::surgtrack
