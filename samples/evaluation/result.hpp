// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// What evaluate finds out about a sequence, as a file: tables are made from these files alone, whichever process wrote them.

#ifndef OPENCV_SURGTRACK_SAMPLES_EVALUATION_RESULT_HPP
#define OPENCV_SURGTRACK_SAMPLES_EVALUATION_RESULT_HPP

#include "detection.hpp"
#include "files.hpp"
#include "runs.hpp"

namespace evaluation {

//! All that was found out about a sequence.
struct Result
{
    String label;                                     //!< for tables and file names
    std::vector<String> tools;                        //!< names
    std::vector<std::vector<String> > coordinates;    //!< of the joints, a tool
    int width;                                        //!< of the image [pixel]
    std::vector<Run> runs;
    Detection detection;
    std::vector<ClassCounts> classes;                 //!< a detector and variant; none without baselines
};

//! A row of numbers that is written or read: there is one order of the fields for both.
class Row
{
public:
    Row() : reading_(false), next_(0) {}
    Row(const double* begin, const double* end) : values_(begin, end), reading_(true), next_(0) {}

    const std::vector<double>& values() const { return values_; }
    Row& operator()(double& value)
    {
        if (!reading_)
            values_.push_back(value);
        else if (next_ < values_.size())
            value = values_[next_++];
        else
            fail("a row of numbers ends too early");
        return *this;
    }
    Row& operator()(int& value)
    {
        double number = value;
        (*this)(number);
        value = cvRound(number);
        return *this;
    }
    template <int n> Row& operator()(Vec<double, n>& v)
    {
        for (int i = 0; i < n; i++)
            (*this)(v[i]);
        return *this;
    }
    Row& operator()(std::vector<double>& v)
    {
        int size = (int)v.size();
        (*this)(size);
        if (size < 0 || size > 1000)
            fail(format("a row of numbers has a list of %d", size));
        v.resize(size);
        for (int i = 0; i < size; i++)
            (*this)(v[i]);
        return *this;
    }

private:
    std::vector<double> values_;
    bool reading_;
    size_t next_;
};

inline void exchange(Row& row, Record& r)
{
    row(r.frame)(r.tool)(r.state)(r.time)(r.translation)(r.rotation)(r.axes)(r.error)(r.sigma)(r.nees)(r.rotationNees)(r.translationNees);
    row(r.nis)(r.visible)(r.inliers)(r.similarity)(r.contourSupport)(r.space)(r.image)(r.offsets)(r.trueOffsets);
}

inline void exchange(Row& row, LabelError& e) { row(e.frame)(e.tool)(e.part)(e.covered)(e.pixels); }

inline void exchange(Row& row, PoseScore& s)
{
    row(s.frames)(s.covered)(s.translationMean)(s.translationStd)(s.rotationMean)(s.rotationStd)(s.accuracy)(s.silent);
}

inline void exchange(Row& row, DetectionCount& c)
{
    row(c.visible)(c.samples)(c.prior);
    for (int k = 0; k < THRESHOLDS; k++)
        for (int n = 0; n < MAX_TOP_N; n++)
            row(c.hits[k][n]);
}

//! CV_64F, a row each; short rows are filled up with zeros.
template <class T> Mat tableOf(const std::vector<T>& items)
{
    std::vector<std::vector<double> > rows;
    size_t columns = 0;
    for (size_t i = 0; i < items.size(); i++)
    {
        Row row;
        T item = items[i];
        exchange(row, item);
        rows.push_back(row.values());
        columns = std::max(columns, rows.back().size());
    }
    Mat table = Mat::zeros((int)rows.size(), (int)columns, CV_64F);
    for (size_t i = 0; i < rows.size(); i++)
        std::copy(rows[i].begin(), rows[i].end(), table.ptr<double>((int)i));
    return table;
}

template <class T> std::vector<T> itemsOf(const FileNode& node)
{
    Mat table;
    node >> table;
    if (!table.empty() && table.type() != CV_64F)
        fail("'" + node.name() + "' is no table of numbers");
    std::vector<T> items(table.rows);
    for (int i = 0; i < table.rows; i++)
    {
        Row row(table.ptr<double>(i), table.ptr<double>(i) + table.cols);
        exchange(row, items[i]);
    }
    return items;
}

inline FileNode child(const FileNode& parent, const char* key)
{
    const FileNode node = parent[key];
    if (node.empty())
        fail("expected a key '" + String(key) + "'");
    return node;
}

inline void save(FileStorage& file, const Run& run)
{
    file << "{" << "method" << run.method << "frames" << run.frames << "seconds" << run.seconds << "records" << tableOf(run.records) << "labels" << tableOf(run.labels) << "scores"
         << tableOf(run.scores) << "worst" << tableOf(std::vector<Record>(run.picture.empty() ? 0 : 1, run.worst)) << "picture" << run.picture << "}";
}

inline Run loadRun(const FileNode& node)
{
    Run run;
    child(node, "method") >> run.method;
    child(node, "frames") >> run.frames;
    child(node, "seconds") >> run.seconds;
    run.records = itemsOf<Record>(child(node, "records"));
    run.labels = itemsOf<LabelError>(child(node, "labels"));
    run.scores = itemsOf<PoseScore>(child(node, "scores"));
    const std::vector<Record> worst = itemsOf<Record>(node["worst"]);
    node["picture"] >> run.picture;
    if (run.scores.empty() || worst.empty() != run.picture.empty())
        fail("a run is not complete");
    if (!worst.empty())
        run.worst = worst[0];
    return run;
}

inline void save(FileStorage& file, const ClassCounts& counts)
{
    file << "{" << "detector" << counts.detector << "variant" << counts.variant << "images" << counts.images << "seconds" << counts.seconds << "parts"
         << counts.parts << "counts" << tableOf(counts.counts) << "}";
}

inline ClassCounts loadCounts(const FileNode& node)
{
    ClassCounts counts;
    child(node, "detector") >> counts.detector;
    child(node, "variant") >> counts.variant;
    child(node, "images") >> counts.images;
    child(node, "seconds") >> counts.seconds;
    child(node, "parts") >> counts.parts;
    counts.counts = itemsOf<DetectionCount>(child(node, "counts"));
    if (counts.counts.size() != counts.parts.size())
        fail("'" + counts.detector + "' has not the same number of parts and counts");
    return counts;
}

inline void load(const String& filename, Result& result)
{
    try
    {
        const FileStorage file(filename, FileStorage::READ);
        const FileNode root = file.root();
        child(root, "label") >> result.label;
        child(root, "tools") >> result.tools;
        child(root, "width") >> result.width;
        const FileNode coordinates = child(root, "coordinates"), runs = child(root, "runs");
        for (int i = 0; i < (int)coordinates.size(); i++)
        {
            result.coordinates.push_back(std::vector<String>());
            coordinates[i] >> result.coordinates.back();
        }
        for (int i = 0; i < (int)runs.size(); i++)
            result.runs.push_back(loadRun(runs[i]));
        child(root, "parts") >> result.detection.parts;
        for (int i = 0; i < VARIANTS; i++)
            result.detection.counts[i] = itemsOf<DetectionCount>(child(root, variantName(i)));
        const FileNode classes = root["classes"];
        for (int i = 0; i < (int)classes.size(); i++)
            result.classes.push_back(loadCounts(classes[i]));
    }
    catch (const Exception& e)
    {
        fail(filename + ": is no result of a sequence, delete it to have it made anew (" + (e.err.empty() ? e.what() : e.err) + ")");
    }
}

//! @param filename appears when all of it is written, as results of other processes may be looked for at any time
inline void save(const String& filename, const Result& result)
{
    const String part = partOf(filename);
    FileStorage file(part, FileStorage::WRITE);
    if (!file.isOpened())
        fail(part + ": can't be written, expected a folder with room for it");
    file << "label" << result.label << "tools" << result.tools << "width" << result.width << "coordinates" << "[";
    for (size_t i = 0; i < result.coordinates.size(); i++)
        file << result.coordinates[i];
    file << "]" << "runs" << "[";
    for (size_t i = 0; i < result.runs.size(); i++)
        save(file, result.runs[i]);
    file << "]" << "parts" << result.detection.parts;
    for (int i = 0; i < VARIANTS; i++)
        file << variantName(i) << tableOf(result.detection.counts[i]);
    if (!result.classes.empty())
    {
        file << "classes" << "[";
        for (size_t i = 0; i < result.classes.size(); i++)
            save(file, result.classes[i]);
        file << "]";
    }
    file.release();
    Result written;
    load(part, written);   // on a full disk it is cut
#ifdef _WIN32
    std::remove(filename.c_str());
#endif
    if (std::rename(part.c_str(), filename.c_str()) != 0)
        fail(filename + ": can't be written, expected a folder with room for it");
}

} // namespace evaluation

#endif
