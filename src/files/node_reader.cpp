// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/surgtrack/names.hpp"
#include "base/geometry.hpp"
#include "files/node_reader.hpp"
#include "files/text_file.hpp"

namespace cv { namespace surgtrack {

String besideFile(const String& filename, const String& path)
{
    const bool absolute = path[0] == '/' || path[0] == '\\' || path.find(':') == 1;
    return absolute ? path : filename.substr(0, filename.find_last_of("/\\") + 1) + path;
}

void NodeReader::fail(const String& what, Error::Code code) const
{
    importError(filename_, (path_.empty() ? "" : "key " + path_ + ": ") + what, code);
}

void NodeReader::expected(const String& what) const
{
    fail(isThere() ? "expected " + what : "missing, expected " + what + (alike_.empty() ? alike_ : ", there is '" + alike_ + "'"));
}

NodeReader NodeReader::operator[](const String& key) const
{
    const String path = path_.empty() ? key : path_ + "." + key;
    if (!node_.isMap())
        return NodeReader(filename_, FileNode(), path);
    const FileNode node = node_[key];
    return NodeReader(filename_, node, path, node.empty() ? closestName(key, node_.keys()) : String());
}

void NodeReader::checkSpelling(const std::vector<String>& keys) const
{
    const std::vector<String> found = node_.isMap() ? node_.keys() : std::vector<String>();
    for (size_t i = 0; i < found.size(); i++)
    {
        const bool known = std::find(keys.begin(), keys.end(), found[i]) != keys.end();
        const String hint = known ? String() : didYouMean(found[i], keys);
        if (!hint.empty())
            (*this)[found[i]].fail("unknown key" + hint);
    }
}

const NodeReader& NodeReader::map(const std::set<String>& keys) const
{
    if (!node_.isMap())
        expected("a map");
    std::set<String> seen;
    for (FileNodeIterator it = node_.begin(); it != node_.end(); ++it)
    {
        const String key = (*it).name();
        if (!keys.count(key))
        {
            String known;
            for (std::set<String>::const_iterator k = keys.begin(); k != keys.end(); ++k)
                known += (known.empty() ? "" : ", ") + *k;
            (*this)[key].fail("unknown key" + didYouMean(key, std::vector<String>(keys.begin(), keys.end())) + " expected one of: " + known);
        }
        if (!seen.insert(key).second)
            (*this)[key].fail("expected once, found twice");
    }
    return *this;
}

std::vector<NodeReader> NodeReader::sequence() const
{
    if (!node_.isSeq())
        expected("a sequence");
    const size_t most = 1000;   // links, keypoints, tools: what is done for them grows with their square
    if (node_.size() > most)
        expected(format("at most %d items", (int)most));
    std::vector<NodeReader> items;
    for (FileNodeIterator it = node_.begin(); it != node_.end(); ++it)
        items.push_back(NodeReader(filename_, *it, path_ + format("[%d]", (int)items.size())));
    return items;
}

String NodeReader::text(const char* what) const
{
    if (!node_.isString() || ((String)node_).empty())
        expected(what);
    return (String)node_;
}

String NodeReader::path(const char* what) const
{
    return besideFile(filename_, text(what));
}

double NodeReader::number() const
{
    if ((!node_.isReal() && !node_.isInt()) || !(std::abs((double)node_) < DBL_MAX))
        expected("a finite number");
    return (double)node_;
}

int NodeReader::count(const char* what) const
{
    if (!node_.isInt() || (int)node_ <= 0)
        expected(what);
    return (int)node_;
}

Mat matrixOf(const FileNode& node, String* reason)
{
    Mat m;
    try
    {
        if (node.isMap())
            node >> m;
    }
    catch (const Exception& e)
    {
        m.release();   // room for the numbers was made before they were read
        if (reason)
            *reason = " (" + e.err + ")";
    }
    return m;
}

Mat NodeReader::matrix(const char* what) const
{
    String reason;
    Mat m = matrixOf(node_, &reason);
    if (!node_.isMap() || !reason.empty() || m.channels() != 1)
        expected(what + reason);
    m.convertTo(m, CV_64F);
    return m;
}

Matx44d NodeReader::rigid() const
{
    const Mat m = matrix("a 4x4 matrix of numbers");
    if (m.size() != Size(4, 4))
        expected(format("a 4x4 opencv-matrix, found %dx%d", m.rows, m.cols));
    const Matx44d T(m.ptr<double>());
    if (!isRigid(T))
        expected("a rigid transform: finite, rotation orthonormal and right-handed, translation [m], last row 0 0 0 1");
    return T;
}

}} // namespace cv::surgtrack
