// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include <cerrno>
#include <climits>
#include <set>
#include "opencv2/surgtrack/tracker_params.hpp"
#include "files/text_file.hpp"

// Each field is named once, in visit(): whoever reads, writes or sets them is a visitor.

namespace cv { namespace surgtrack {

namespace {

#define FIELD(name) v(#name, p.name)

template <class V> void visit(V& v, PartTemplateRenderer::Params& p)
{
    FIELD(boxSize); FIELD(minFeatures); FIELD(maxFeatures); FIELD(magnitudeThreshold); FIELD(depthSlack); FIELD(wholeTool); FIELD(tipDepthSlack);
}

template <class V> void visit(V& v, QGOMatcher::Params& p)
{
    FIELD(magnitudeThreshold); FIELD(contrast); FIELD(leastMagnitude); FIELD(spread); FIELD(candidates); FIELD(suppressionRadius);
    FIELD(minSimilarity); FIELD(relativeSimilarity);
}

template <class V> void visit(V& v, GeometricContextVerifier::Params& p)
{
    FIELD(zoneAngle); FIELD(zoneRadius); FIELD(centredZones); FIELD(minInliers); FIELD(maxIterations); FIELD(maxScale); FIELD(maxRotation);
    FIELD(seed);
}

template <class V> void visit(V& v, ToolPoseEKF::Params& p)
{
    FIELD(initialRotation); FIELD(initialTranslation); FIELD(processRotation); FIELD(processTranslation); FIELD(measurementNoise); FIELD(gate);
    FIELD(minPoints);
}

template <class V> void visit(V& v, ArticulatedPoseEKF::Params& p)
{
    FIELD(initialRotation); FIELD(initialTranslation); FIELD(processRotation); FIELD(processTranslation); FIELD(processJoint); FIELD(gain); FIELD(play);
    FIELD(coupling); FIELD(delay); FIELD(pointNoise);
    FIELD(gate); FIELD(contourNoise); FIELD(jointOffsets); FIELD(contourCorrelation);
}

template <class V> void visit(V& v, ToolContour::Params& p) { FIELD(spacing); FIELD(maxPoints); FIELD(creaseAngle); }

template <class V> void visit(V& v, ContourSearch& p)
{
    FIELD(halfWindow); FIELD(preference); FIELD(minStrength); FIELD(contrast); FIELD(leastStrength); FIELD(ambiguity);
}

template <class V> void visit(V& v, ToolTracker::Params& p)
{
    FIELD(method); FIELD(jointOffsets); FIELD(contours); FIELD(adaptation); FIELD(initialWindow); FIELD(minWindow); FIELD(minInitialInliers);
    FIELD(minInitialSimilarity); FIELD(minConfidence); FIELD(confirmFrames); FIELD(coastingTime); FIELD(seed);
}

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
    void operator()(const char* name, double& value) { file_ << name << value; }
    void operator()(const char* name, int& value) { file_ << name << value; }
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
    void operator()(const char* name, double& value)
    {
        const FileNode node = find(name);
        if (!node.empty()) value = number(name, node);
    }
    void operator()(const char* name, int& value)
    {
        const FileNode node = find(name);
        if (node.empty()) return;
        if (!node.isInt()) fail(path_ + name, "expected a whole number");
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
            if (!known_.count(keys[i])) fail(path_ + keys[i], "there is no such parameter");
    }

private:
    CV_NORETURN void fail(const String& key, const char* what) const
    {
        CV_Error(Error::StsParseError, filename_ + ": key " + key + ": " + what);
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
    void operator()(const char* name, double& value)
    {
        if (!is(name)) return;
        char* end = 0;
        const double number = std::strtod(value_.c_str(), &end);
        if (end == value_.c_str() || *end || !(std::abs(number) < DBL_MAX)) fail("expected a number");
        value = number;
    }
    void operator()(const char* name, int& value)
    {
        if (!is(name)) return;
        char* end = 0;
        errno = 0;
        const long number = std::strtol(value_.c_str(), &end, 10);
        if (end == value_.c_str() || *end || errno || number < INT_MIN || number > INT_MAX) fail("expected a whole number");
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
        CV_Error(Error::StsBadArg, "parameter '" + name_ + "': there is no such one, expected one of " + names);
    }

private:
    bool is(const char* name)
    {
        names_.push_back(path_ + name);
        found_ = found_ || names_.back() == name_;
        return names_.back() == name_;
    }
    CV_NORETURN void fail(const char* what) const { CV_Error(Error::StsBadArg, "parameter '" + name_ + "': " + what + ", found '" + value_ + "'"); }

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
