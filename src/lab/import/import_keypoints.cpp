// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/surgtrack/import.hpp"
#include "files/text_file.hpp"

#include <algorithm>
#include <cstdlib>
#include <iterator>
#include <set>

#ifdef HAVE_NLOHMANN_JSON
#include "lab/import/import_json.hpp"
#endif

// Labelled image points of other data sets -> keypoints.csv.

namespace cv { namespace surgtrack {

namespace {

//! Writes points under the names wanted.
class KeypointTable
{
public:
    KeypointTable(const std::vector<String>& keypoints, const std::vector<String>& tools)
        : keypoints_(pairsByLabel(keypoints, "keypoints")), tools_(pairsByLabel(tools, "tools")), table_("frame,tool,keypoint,u,v,visible\n"),
          count_(0)
    {
    }

    void add(int frame, String tool, String keypoint, const Point2d& imagePoint)
    {
        seen_.insert(std::make_pair(keypoint, tool));
        if (!rename(keypoints_, keypoint) || !rename(tools_, tool))
            return;
        table_ << frame << "," << tool << "," << keypoint << "," << imagePoint.x << "," << imagePoint.y << ",1\n";
        count_++;
    }

    int write(const String& labels, const String& csv) const
    {
        if (count_ == 0)
            importError(labels, "no labels" + String(seen_.empty() ? "" : " of the keypoints and tools asked for, there are " + seen()));
        table_.write(csv);
        return count_;
    }

private:
    static bool rename(const std::map<String, String>& names, String& name)
    {
        const std::map<String, String>::const_iterator at = names.find(name);
        if (at != names.end())
            name = at->second;
        return names.empty() || at != names.end();
    }

    String seen() const
    {
        String all;
        for (std::map<String, String>::const_iterator it = seen_.begin(); it != seen_.end(); ++it)
            all += (all.empty() ? "" : ", ") + it->first + " (" + it->second + ")";
        return all;
    }

    std::map<String, String> keypoints_, tools_, seen_;
    Table table_;
    int count_;
};

} // namespace

#ifdef HAVE_NLOHMANN_JSON

//! The last number in a file's name, -1 if it has none.
static int numberOf(const String& path)
{
    const String name = path.substr(path.find_last_of("/\\") + 1), stem = name.substr(0, name.rfind('.'));
    const size_t last = stem.find_last_of("0123456789");
    if (last == String::npos)
        return -1;
    const size_t before = stem.find_last_not_of("0123456789", last), start = before == String::npos ? 0 : before + 1;
    return std::atoi(stem.substr(start, std::min(last - start + 1, (size_t)9)).c_str());
}

//! The tool a label is of. Some have no `id`: then it is the only tool of the image without a label of that class, else it is not known (empty).
static String toolOf(const JsonKey& annotations, const JsonKey& point)
{
    if (point.has("id"))
        return point["id"].text();
    std::set<String> tools, having;
    for (size_t i = 0; i < annotations.size(); i++)
    {
        const JsonKey other = annotations[i];
        if (!other.has("id"))
            continue;
        tools.insert(other["id"].text());
        if (other["class"].text() == point["class"].text())
            having.insert(other["id"].text());
    }
    std::vector<String> left;
    std::set_difference(tools.begin(), tools.end(), having.begin(), having.end(), std::back_inserter(left));
    return left.size() == 1 ? left[0] : String();
}

int importEndoVisKeypoints(const String& labels, const String& csv, const std::vector<String>& keypoints, const std::vector<String>& tools)
{
    KeypointTable table(keypoints, tools);
    const JsonFile file(labels);
    const JsonKey images = file.root();
    int first = -1, last = -1;
    for (size_t k = 0; k < images.size(); k++)
    {
        // Labels may be of some frames only: the number in the name tells, counted from the first.
        const JsonKey annotations = images[k]["annotations"];
        const int number = images[k].has("filename") ? numberOf(images[k]["filename"].text()) : -1;
        first = k == 0 ? number : first;
        const int frame = first >= 0 && number >= 0 ? number - first : last + 1;
        if (frame <= last)
            images[k].fail(format("expected images in the order of the numbers in their names, found %d after %d", number, first + last));
        last = frame;
        for (size_t i = 0; i < annotations.size(); i++)
        {
            const JsonKey point = annotations[i];
            const String tool = toolOf(annotations, point);
            if (!tool.empty())
                table.add(frame, tool, point["class"].text(), Point2d(point["x"].number(), point["y"].number()));
        }
    }
    return table.write(labels, csv);
}

#else

int importEndoVisKeypoints(const String&, const String&, const std::vector<String>&, const std::vector<String>&)
{
    CV_Error(Error::StsNotImplemented, "labels of EndoVis are JSON: the module was built without nlohmann_json, which reads it");
}

#endif

int importSurgPoseKeypoints(const String& labels, const String& csv, const std::vector<String>& keypoints, const std::vector<String>& tools)
{
    KeypointTable table(keypoints, tools);
    const FileStorage file = openYaml(labels);
    const FileNode frames = file.root();
    for (FileNodeIterator frame = frames.begin(); frame != frames.end(); ++frame)
    {
        const String frameName = (*frame).name();
        if (frameName[0] != 'n' || !(*frame).isMap())
            importError(labels, "key " + frameName + ": expected the number of a frame, and keypoints below it");
        for (FileNodeIterator it = (*frame).begin(); it != (*frame).end(); ++it)
        {
            const FileNode point = *it;
            if (point.isNone() || (point.isString() && ((String)point == "null" || (String)point == "~")))
                continue;   // not seen; OpenCV 5 knows null
            const String name = point.name(), path = "key " + frameName.substr(1) + "." + name.substr(1);
            const int number = name[0] == 'n' ? std::atoi(name.c_str() + 1) : 0;
            if (number < 1 || number > 14)
                importError(labels, path + ": expected the number of a keypoint, 1 to 14");
            Point2d p(DBL_MAX, DBL_MAX);
            if (point.isSeq() && point.size() == 2 && !point[0].isString() && !point[1].isString())
                p = Point2d((double)point[0], (double)point[1]);
            if (!(std::abs(p.x) < 1e6 && std::abs(p.y) < 1e6))
                importError(labels, path + ": expected two numbers [pixel]");
            table.add(std::atoi(frameName.c_str() + 1), number <= 7 ? "PSM1" : "PSM3", name.substr(1), p);
        }
    }
    return table.write(labels, csv);
}

}} // namespace cv::surgtrack
