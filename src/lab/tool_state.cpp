// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/surgtrack/tool_state.hpp"
#include "files/node_reader.hpp"
#include "files/text_file.hpp"

namespace cv { namespace surgtrack {

static std::vector<double> numbers(const NodeReader& node)
{
    std::vector<double> result;
    for (const NodeReader& item : node.sequence()) result.push_back(item.number());
    return result;
}

ReadingErrors readToolState(const String& filename, const String& tool)
{
    const FileStorage file = openStorage(filename);
    const NodeReader root(filename, file.root());
    root.map({ "tools" });
    ReadingErrors result;
    for (const NodeReader& entry : root["tools"].sequence())
    {
        entry.map({ "name", "constants", "values", "covariance", "reference" });
        if (entry["name"].text() != tool) continue;
        if (!result.names.empty()) entry["name"].fail("expected the name of another tool, found `" + tool + "` again");
        for (const NodeReader& name : entry["constants"].sequence()) result.names.push_back(name.text());
        result.values = numbers(entry["values"]);
        result.reference = numbers(entry["reference"]);
        result.covariance = entry["covariance"].matrix("the covariance of the values");
        const int n = (int)result.names.size();
        if ((int)result.values.size() != n) entry["values"].expected(format("%d numbers, one of each of `constants`", n));
        if (result.covariance.rows != n || result.covariance.cols != n) entry["covariance"].expected(format("a matrix of %d x %d", n, n));
    }
    return result;
}

void writeToolState(const String& filename, const std::vector<String>& tools, const std::vector<ReadingErrors>& errors)
{
    CV_CheckEQ(tools.size(), errors.size(), "errors: one of each tool");
    FileStorage file = newStorage(filename);
    file << "tools" << "[";
    for (size_t i = 0; i < tools.size(); i++)
    {
        if (std::find(tools.begin(), tools.begin() + i, tools[i]) != tools.begin() + i) CV_Error(Error::StsBadArg, "tools: '" + tools[i] + "' is there twice");
        if (errors[i].names.empty()) continue;
        file << "{" << "name" << tools[i] << "constants" << errors[i].names << "values" << "[:";
        for (size_t k = 0; k < errors[i].values.size(); k++) file << errors[i].values[k];
        file << "]" << "reference" << "[:";
        for (size_t k = 0; k < errors[i].reference.size(); k++) file << errors[i].reference[k];
        file << "]" << "covariance" << errors[i].covariance << "}";
    }
    file << "]";
    writeContent(filename, file.releaseAndGetString());
}

}} // namespace cv::surgtrack
