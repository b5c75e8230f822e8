// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include <cerrno>
#include <climits>
#include <set>
#include "opencv2/surgtrack/names.hpp"
#include "opencv2/surgtrack/tracker_params.hpp"
#include "files/text_file.hpp"

// Each field is named once, in visit(), with what it may be: whoever reads, writes or sets them is a visitor.

namespace cv { namespace surgtrack {

namespace {

//! What a parameter may be, both ends included.
struct Range
{
    double low, high;

    bool contains(double value) const { return value >= low && value <= high; }
    String text(const char* kind) const
    {
        if (low == INT_MIN) return String("expected ") + kind;
        const String from = low == DBL_MIN ? String("above 0") : format("from %g", low);
        return String("expected ") + kind + " " + from + (high == DBL_MAX ? String(low == DBL_MIN ? "" : " on") : format(" to %g", high));
    }
};

// Lengths and windows beyond these find nothing, whatever the tool: they are of other units.
const Range positive = {DBL_MIN, DBL_MAX}, notNegative = {0, DBL_MAX}, share = {0, 1}, angle = {0, CV_PI}, counts = {1, 1e6}, seeds = {INT_MIN, INT_MAX};
const Range metres = {DBL_MIN, 1}, pixels = {DBL_MIN, 1e4};

inline Range range(double low, double high)
{
    const Range r = {low, high};
    return r;
}

#define FLAG(name) v(#name, p.name)
#define FIELD(name, range) v(#name, p.name, range)

template <class V> void visit(V& v, PartTemplateRenderer::Params& p)
{
    FIELD(boxSize, range(DBL_MIN, 0.1)); FIELD(minFeatures, counts); FIELD(maxFeatures, counts); FIELD(magnitudeThreshold, notNegative);
    FIELD(depthSlack, range(0, 0.1)); FLAG(wholeTool); FIELD(tipDepthSlack, range(0, 0.1));
}

template <class V> void visit(V& v, QGOMatcher::Params& p)
{
    FIELD(magnitudeThreshold, notNegative); FIELD(contrast, notNegative); FIELD(leastMagnitude, notNegative); FIELD(spread, range(1, 63));
    FIELD(candidates, counts); FIELD(suppressionRadius, range(0, 1e4)); FIELD(minSimilarity, share); FIELD(relativeSimilarity, share);
}

template <class V> void visit(V& v, GeometricContextVerifier::Params& p)
{
    FIELD(zoneAngle, range(DBL_MIN, 2 * CV_PI)); FIELD(zoneRadius, pixels); FLAG(centredZones); FIELD(minInliers, range(2, 1e6));
    FIELD(maxIterations, counts); FIELD(maxScale, notNegative); FIELD(maxRotation, angle); FIELD(seed, seeds);
}

template <class V> void visit(V& v, ToolPoseEKF::Params& p)
{
    FIELD(initialRotation, angle); FIELD(initialTranslation, range(0, 1)); FIELD(processRotation, angle); FIELD(processTranslation, range(0, 1));
    FIELD(measurementNoise, pixels); FIELD(gate, notNegative); FIELD(minPoints, counts);
}

template <class V> void visit(V& v, ArticulatedPoseEKF::Params& p)
{
    FIELD(initialRotation, range(DBL_MIN, CV_PI)); FIELD(initialTranslation, metres); FIELD(processRotation, angle); FIELD(processTranslation, range(0, 1));
    FIELD(processJoint, notNegative); FIELD(gain, notNegative); FIELD(play, angle); FIELD(coupling, notNegative); FIELD(delay, notNegative); FIELD(exact, range(0, 1));
    FIELD(pointNoise, pixels); FIELD(gate, notNegative); FIELD(contourNoise, pixels); FIELD(edgeBias, pixels); FIELD(bloom, pixels); FLAG(jointOffsets); FIELD(contourCorrelation, range(1, 1e6));
}

template <class V> void visit(V& v, ToolContour::Params& p)
{
    FIELD(spacing, pixels); FIELD(maxPoints, counts); FIELD(creaseAngle, angle);
}

template <class V> void visit(V& v, ContourSearch& p)
{
    FIELD(halfWindow, range(1, 40)); FIELD(preference, notNegative); FIELD(minStrength, notNegative); FIELD(contrast, notNegative);
    FIELD(leastStrength, notNegative); FIELD(ambiguity, share);
}

template <class V> void visit(V& v, ToolTracker::Params& p)
{
    FIELD(method, range(METHOD_PAPER, METHOD_FULL)); FLAG(jointOffsets); FLAG(contours); FLAG(adaptation); FIELD(initialWindow, metres);
    FIELD(minWindow, pixels); FIELD(minInitialInliers, range(4, 1e6)); FIELD(minInitialSimilarity, share); FIELD(minConfidence, range(0, 0.999));
    FIELD(confirmFrames, range(0, 1e6)); FIELD(coastingTime, notNegative); FIELD(seed, seeds);
}

#undef FLAG
#undef FIELD

template <class V> void visitAll(V& v, ToolTracker::Params& params, ToolTracker::Stages& stages)
{
    visit(v, params);
    v.group("templates", stages.templates);
    v.group("matcher", stages.matcher);
    v.group("verifier", stages.verifier);
    v.group("paperFilter", stages.paperFilter);
    v.group("filter", stages.filter);
    v.group("contour", stages.contour);
    v.group("edges", stages.edges);
}

class Writer
{
public:
    explicit Writer(FileStorage& file) : file_(file) {}
    void operator()(const char* name, double& value, const Range&) { file_ << name << value; }
    void operator()(const char* name, int& value, const Range&) { file_ << name << value; }
    void operator()(const char* name, bool& value) { file_ << name << (int)value; }
    template <class P> void group(const char* name, P& params)
    {
        file_ << name << "{";
        visit(*this, params);
        file_ << "}";
    }

private:
    FileStorage& file_;
};

//! Takes the keys of a map, each of which must be a field.
class Reader
{
public:
    Reader(const String& filename, const String& path, const FileNode& node) : filename_(filename), path_(path), node_(node)
    {
        if (!node.isMap()) fail(path.substr(0, path.find('.')), "expected a map of parameters");
    }
    void operator()(const char* name, double& value, const Range& range)
    {
        const FileNode node = find(name);
        if (node.empty()) return;
        const double found = number(name, node);
        if (!range.contains(found)) fail(path_ + name, range.text("a number") + format(", found %g", found));
        value = found;
    }
    void operator()(const char* name, int& value, const Range& range)
    {
        const FileNode node = find(name);
        if (node.empty()) return;
        if (!node.isInt() || !range.contains((int)node)) fail(path_ + name, range.text("a whole number"));
        value = (int)node;
    }
    void operator()(const char* name, bool& value)
    {
        const FileNode node = find(name);
        if (node.empty()) return;
        const double flag = number(name, node);
        if (flag != 0 && flag != 1) fail(path_ + name, "expected 0 or 1");
        value = flag != 0;
    }
    template <class P> void group(const char* name, P& params)
    {
        const FileNode node = find(name);
        if (node.empty()) return;
        Reader reader(filename_, path_ + name + ".", node);
        visit(reader, params);
        reader.finish();
    }
    //! Throws if there are keys that are none.
    void finish() const
    {
        const std::vector<String> keys = node_.keys();
        for (size_t i = 0; i < keys.size(); i++)
            if (!known_.count(keys[i]))
                fail(path_ + keys[i], "there is no such parameter" + didYouMean(keys[i], std::vector<String>(known_.begin(), known_.end())));
    }

private:
    CV_NORETURN void fail(const String& key, const String& what) const
    {
        importError(filename_, "key " + key + ": " + what);
    }
    FileNode find(const char* name)
    {
        known_.insert(name);
        return node_[name];
    }
    double number(const char* name, const FileNode& node) const
    {
        const double value = node.isReal() || node.isInt() ? (double)node : DBL_MAX;
        if (!(std::abs(value) < DBL_MAX)) fail(path_ + name, "expected a finite number");
        return value;
    }

    String filename_, path_;
    FileNode node_;
    std::set<String> known_;
};

//! Sets the one field of a name.
class Setter
{
public:
    Setter(const String& name, const String& value) : name_(name), value_(value), found_(false) {}
    void operator()(const char* name, double& value, const Range& range)
    {
        if (!is(name)) return;
        char* end = 0;
        const double number = std::strtod(value_.c_str(), &end);
        if (end == value_.c_str() || *end || !(std::abs(number) < DBL_MAX) || !range.contains(number)) fail(range.text("a number"));
        value = number;
    }
    void operator()(const char* name, int& value, const Range& range)
    {
        if (!is(name)) return;
        char* end = 0;
        errno = 0;
        const long number = std::strtol(value_.c_str(), &end, 10);
        if (end == value_.c_str() || *end || errno || number < INT_MIN || number > INT_MAX || !range.contains((double)number))
            fail(range.text("a whole number"));
        value = (int)number;
    }
    void operator()(const char* name, bool& value)
    {
        if (!is(name)) return;
        const bool yes = value_ == "1" || value_ == "true";
        if (!yes && value_ != "0" && value_ != "false") fail("expected true or false");
        value = yes;
    }
    template <class P> void group(const char* name, P& params)
    {
        path_ = String(name) + ".";
        visit(*this, params);
        path_ = String();
    }
    void finish() const
    {
        if (found_) return;
        String names;
        for (size_t i = 0; i < names_.size(); i++) names += (i ? ", " : "") + names_[i];
        CV_Error(Error::StsBadArg, "parameter '" + name_ + "': there is no such one" + didYouMean(name_, names_) + "; there are " + names);
    }

private:
    bool is(const char* name)
    {
        names_.push_back(path_ + name);
        found_ = found_ || names_.back() == name_;
        return names_.back() == name_;
    }
    CV_NORETURN void fail(const String& what) const { CV_Error(Error::StsBadArg, "parameter '" + name_ + "': " + what + ", found '" + value_ + "'"); }

    String name_, value_, path_;
    bool found_;
    std::vector<String> names_;
};

} // namespace

void readTrackerParams(const String& filename, ToolTracker::Params& params, ToolTracker::Stages& stages)
{
    const FileStorage file = openStorage(filename);
    ToolTracker::Params newParams = params;      // what is wrong leaves all as it was
    ToolTracker::Stages newStages = stages;
    Reader reader(filename, String(), file.root());
    visitAll(reader, newParams, newStages);
    reader.finish();
    params = newParams;
    stages = newStages;
}

void writeTrackerParams(const String& filename, const ToolTracker::Params& params_, const ToolTracker::Stages& stages_)
{
    ToolTracker::Params params = params_;
    ToolTracker::Stages stages = stages_;
    FileStorage file = newStorage(filename);
    Writer writer(file);
    visitAll(writer, params, stages);
    writeContent(filename, file.releaseAndGetString());
}

void setTrackerParam(const String& name, const String& value, ToolTracker::Params& params, ToolTracker::Stages& stages)
{
    Setter setter(name, value);
    visitAll(setter, params, stages);
    setter.finish();
}

}} // namespace cv::surgtrack
