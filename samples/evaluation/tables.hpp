// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// The CSV files of evaluate.

#ifndef OPENCV_SURGTRACK_SAMPLES_EVALUATION_TABLES_HPP
#define OPENCV_SURGTRACK_SAMPLES_EVALUATION_TABLES_HPP

#include "consistency.hpp"
#include "result.hpp"

namespace evaluation {

typedef std::vector<Ptr<Result> > Results;

//! The methods in the order of the runs; not every sequence has all of them.
inline std::vector<String> methodsOf(const Results& results)
{
    std::vector<String> methods;
    for (size_t i = 0; i < results.size(); i++)
    {
        size_t next = 0;
        for (size_t j = 0; j < results[i]->runs.size(); j++)
        {
            const String& method = results[i]->runs[j].method;
            if (std::find(methods.begin(), methods.end(), method) == methods.end())
                methods.insert(methods.begin() + next, method);
            next = std::find(methods.begin(), methods.end(), method) - methods.begin() + 1;
        }
    }
    return methods;
}

//! The name of a sequence, or, beyond the last, of all.
inline String labelOf(const Results& results, size_t index)
{
    return index < results.size() ? results[index]->label : String("all");
}

inline const Run* find(const Result& result, const String& method)
{
    for (size_t i = 0; i < result.runs.size(); i++)
        if (result.runs[i].method == method)
            return &result.runs[i];
    return 0;
}

//! A row of Table 1: scores of any number of tools and sequences.
struct Score
{
    int frames, covered;
    double accurate, silent;          // frames
    Moments translation, rotation;    // [m, rad]
    double videoFrames, seconds;

    Score() : frames(0), covered(0), accurate(0), silent(0), videoFrames(0), seconds(0) {}

    void add(const PoseScore& s)
    {
        frames += s.frames;
        covered += s.covered;
        accurate += s.accuracy * s.frames;
        silent += s.silent * s.frames;
        translation.add(s.covered, s.translationMean, s.translationStd);
        rotation.add(s.covered, s.rotationMean, s.rotationStd);
    }
    void addTime(const Run& run)
    {
        videoFrames += run.frames;
        seconds += run.seconds;
    }
    double hz() const { return seconds > 0 ? videoFrames / seconds : unknown(); }
    double share(double count) const { return frames ? count / frames : unknown(); }
};

inline Score scoreOf(const Run& run)
{
    Score score;
    score.add(run.scores.back());
    score.addTime(run);
    return score;
}

inline Score overallScore(const Results& results, const String& method)
{
    Score score;
    for (size_t i = 0; i < results.size(); i++)
        if (const Run* run = find(*results[i], method))
        {
            score.add(run->scores.back());
            score.addTime(*run);
        }
    return score;
}

inline std::string scoreRow(const String& sequence, const String& tool, const String& method, const Score& s)
{
    return sequence + "," + tool + "," + method + format(",%d,", s.frames) + cell(s.share(s.covered)) + "," + cell(1e3 * s.translation.mean()) + "," +
           cell(1e3 * s.translation.deviation()) + "," + cell(s.rotation.mean()) + "," + cell(s.rotation.deviation()) + "," +
           cell(s.share(s.accurate)) + "," + cell(s.share(s.silent)) + "\n";
}

inline void writeScores(const String& filename, const Results& results)
{
    TextFile file(filename);
    file << "sequence,tool,method,frames,coverage,translation_mean_mm,translation_std_mm,rotation_mean_rad,rotation_std_rad,accuracy,silent\n";
    for (size_t i = 0; i < results.size(); i++)
        for (size_t j = 0; j < results[i]->runs.size(); j++)
        {
            const Run& run = results[i]->runs[j];
            const std::vector<String>& tools = results[i]->tools;
            for (size_t k = 0; k < tools.size() && tools.size() > 1; k++)
            {
                Score score;
                score.add(run.scores[k]);
                file << scoreRow(results[i]->label, tools[k], run.method, score);
            }
            file << scoreRow(results[i]->label, "all", run.method, scoreOf(run));
        }
    const std::vector<String> methods = methodsOf(results);
    for (size_t i = 0; i < methods.size(); i++)
        file << scoreRow("all", "all", methods[i], overallScore(results, methods[i]));
    file.finish();
}

//! Of a sequence, or, if index is beyond the last, of all.
inline std::vector<ClassCounts> classesOf(const Results& results, size_t index)
{
    if (index < results.size())
        return results[index]->classes;
    std::vector<ClassCounts> sums;
    for (size_t i = 0; i < results.size(); i++)
        for (size_t j = 0; j < results[i]->classes.size(); j++)
        {
            const ClassCounts& counts = results[i]->classes[j];
            size_t k = 0;
            while (k < sums.size() && (sums[k].detector != counts.detector || sums[k].variant != counts.variant))
                k++;
            if (k == sums.size())
                sums.push_back(counts);
            else
                sums[k].add(counts);
        }
    return sums;
}

//! Frames a second: the only figures that differ from run to run, so they have a file of their own.
inline void writeTimings(const String& filename, const Results& results)
{
    TextFile file(filename);
    file << "sequence,method,frames,seconds,hz\n";
    const std::vector<String> methods = methodsOf(results);
    for (size_t i = 0; i <= results.size(); i++)
        for (size_t j = 0; j < methods.size(); j++)
        {
            const Run* run = i < results.size() ? find(*results[i], methods[j]) : 0;
            if (i < results.size() && !run)
                continue;
            const Score s = run ? scoreOf(*run) : overallScore(results, methods[j]);
            if (s.seconds > 0)
                file << labelOf(results, i) + "," + methods[j] + format(",%.0f,", s.videoFrames) + cell(s.seconds) + "," + cell(s.hz(), 4) + "\n";
        }
    for (size_t i = 0; i <= results.size(); i++)
    {
        const std::vector<ClassCounts> classes = classesOf(results, i);
        for (size_t j = 0; j < classes.size(); j++)
            if (classes[j].seconds > 0)
                file << labelOf(results, i) + "," + classes[j].detector + " in " + classes[j].variant + format(",%d,", classes[j].images) +
                            cell(classes[j].seconds) + "," + cell(classes[j].images / classes[j].seconds, 4) + "\n";
    }
    file.finish();
}

//! @param detector for a last column; empty: there is none
inline void writeDetection(TextFile& file, const String& sequence, const String& variant, const String& part, const DetectionCount& count,
                           const String& detector)
{
    for (int k = 0; k < THRESHOLDS; k++)
        for (int n = 0; n < MAX_TOP_N; n++)
            file << sequence + "," + variant + "," + part +
                        format(",%d,%d,%s,%d,%d,%s", thresholdPixels(k), n + 1, cell(count.rate(k, n)).c_str(), count.samples, count.visible,
                               cell(count.samples ? count.prior / count.samples : unknown(), 4).c_str()) +
                        (detector.empty() ? String() : "," + detector) + "\n";
}

inline void writeDetections(const String& filename, const Results& results)
{
    TextFile file(filename);
    Detection sum;
    for (size_t i = 0; i < results.size(); i++)
        sum.add(results[i]->detection);
    const bool baselines = !classesOf(results, results.size()).empty();
    const String qgo = baselines ? "qgo" : "";
    file << String("sequence,variant,part,threshold_px,top_n,rate,samples,visible,prior_px") + (baselines ? ",detector\n" : "\n");
    for (size_t i = 0; i <= results.size(); i++)
    {
        const Detection& detection = i == results.size() ? sum : results[i]->detection;
        const String sequence = labelOf(results, i);
        for (int variant = 0; variant < VARIANTS; variant++)
        {
            for (size_t part = 0; part < detection.parts.size(); part++)
                writeDetection(file, sequence, variantName(variant), detection.parts[part], detection.counts[variant][part], qgo);
            writeDetection(file, sequence, variantName(variant), "all", detection.all(variant), qgo);
        }
        const std::vector<ClassCounts> classes = classesOf(results, i);
        for (size_t j = 0; j < classes.size(); j++)
        {
            const ClassCounts& c = classes[j];
            for (size_t part = 0; part < c.parts.size(); part++)
                writeDetection(file, sequence, c.variant, c.parts[part], c.counts[part], c.detector);
            writeDetection(file, sequence, c.variant, "all", c.all(), c.detector);
        }
    }
    file.finish();
}

//! Rotation errors about one axis of the end effector.
struct AxisError
{
    Moments value, size;   // with its sign, and without [rad]
    void add(const Run& run, int axis)
    {
        for (size_t i = 0; i < run.records.size(); i++)
            if (run.records[i].covered())
            {
                value.add(run.records[i].axes[axis]);
                size.add(std::abs(run.records[i].axes[axis]));
            }
    }
};

inline void writeAxes(const String& filename, const Results& results)
{
    TextFile file(filename);
    file << "sequence,method,axis,mean_abs,std_abs,mean,std,frames\n";
    const std::vector<String> methods = methodsOf(results);
    for (size_t i = 0; i <= results.size(); i++)
        for (size_t j = 0; j < methods.size(); j++)
            for (int axis = 0; axis < 3; axis++)
            {
                AxisError error;
                const bool all = i == results.size();
                for (size_t k = all ? 0 : i; k < (all ? results.size() : i + 1); k++)
                    if (const Run* run = find(*results[k], methods[j]))
                        error.add(*run, axis);
                if (!all && !find(*results[i], methods[j]))
                    continue;
                file << labelOf(results, i) + "," + methods[j] + format(",%c,", 'x' + axis) + cell(error.size.mean()) + "," +
                            cell(error.size.deviation()) + "," + cell(error.value.mean()) + "," + cell(error.value.deviation()) +
                            format(",%d\n", error.value.count());
            }
    file.finish();
}

//! Runs of a method in one sequence, or, if index is beyond the last, in all.
inline std::vector<const Run*> runsOf(const Results& results, size_t index, const String& method)
{
    std::vector<const Run*> runs;
    for (size_t i = 0; i < results.size(); i++)
        if (index >= results.size() || i == index)
            if (const Run* run = find(*results[i], method))
                runs.push_back(run);
    return runs;
}

inline void writeConsistency(const String& filename, const Results& results)
{
    TextFile file(filename);
    file << "sequence,method,quantity,expected,mean,band_low,band_high,runs,frames,inside\n";
    const std::vector<String> methods = methodsOf(results);
    for (size_t i = 0; i <= results.size(); i++)
        for (size_t j = 0; j < methods.size(); j++)
        {
            const std::vector<const Run*> runs = runsOf(results, i, methods[j]);
            if (runs.empty() || runs[0]->isControl())
                continue;
            const std::vector<ConsistencyRow> rows = consistencyOf(runs);
            for (size_t k = 0; k < rows.size(); k++)
            {
                const ConsistencyRow& row = rows[k];
                file << labelOf(results, i) + "," + methods[j] + "," + row.quantity + "," +
                            cell(row.expected) + "," + cell(row.mean) + "," + cell(row.band.low) + "," + cell(row.band.high) +
                            format(",%d,%d,", row.runs, row.frames) + cell(row.inside) + "\n";
            }
        }
    file.finish();
}

//! Errors frame by frame, in metres and radians.
inline void writeFrames(const String& filename, const Result& result, const Run& run)
{
    static const char* const components[] = { "rx", "ry", "rz", "tx", "ty", "tz" };
    std::vector<String> coordinates;   // of any tool
    for (size_t i = 0; i < result.coordinates.size(); i++)
        for (size_t j = 0; j < result.coordinates[i].size(); j++)
            if (std::find(coordinates.begin(), coordinates.end(), result.coordinates[i][j]) == coordinates.end())
                coordinates.push_back(result.coordinates[i][j]);
    TextFile file(filename);
    file << "frame,time,tool,state,translation_error,rotation_error,axis_x,axis_y,axis_z";
    for (int k = 0; k < 2; k++)
        for (int i = 0; i < 6; i++)
            file << (k == 0 ? ",error_" : ",sigma_") + std::string(components[i]);
    file << ",visible,inliers,similarity,contour_support,nis,nees";
    for (int k = 0; k < 2; k++)
        for (size_t i = 0; i < coordinates.size(); i++)
            file << (k == 0 ? ",offset_" : ",true_offset_") + coordinates[i];
    file << "\n";
    for (size_t i = 0; i < run.records.size(); i++)
    {
        const Record& r = run.records[i];
        const std::vector<String>& own = result.coordinates[r.tool];
        file << format("%d,", r.frame) + cell(r.time, 9) + "," + result.tools[r.tool] + "," +
                    (run.isControl() ? String("control") : stateName(r.state)) + "," + cell(r.translation) + "," + cell(r.rotation);
        for (int k = 0; k < 3; k++)
            file << "," + cell(r.axes[k]);
        for (int k = 0; k < 6; k++)
            file << "," + cell(r.error[k]);
        for (int k = 0; k < 6; k++)
            file << "," + (r.sigma[k] > 0 ? cell(r.sigma[k]) : std::string());
        file << (r.inliers < 0 ? std::string(",,") : format(",%d,%d", r.visible, r.inliers)) + "," + cell(r.similarity) + "," + cell(r.contourSupport) +
                    "," + cell(r.nis) + "," + cell(r.nees);
        for (int k = 0; k < 2; k++)
            for (size_t j = 0; j < coordinates.size(); j++)
            {
                const std::vector<double>& values = k == 0 ? r.offsets : r.trueOffsets;
                const size_t index = std::find(own.begin(), own.end(), coordinates[j]) - own.begin();
                file << "," + (index < own.size() && index < values.size() ? cell(values[index]) : std::string());
            }
        file << "\n";
    }
    file.finish();
}

} // namespace evaluation

#endif
