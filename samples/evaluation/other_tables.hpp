// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Tables of what others report, see measures.hpp.

#ifndef OPENCV_SURGTRACK_SAMPLES_EVALUATION_OTHER_TABLES_HPP
#define OPENCV_SURGTRACK_SAMPLES_EVALUATION_OTHER_TABLES_HPP

#include "tables.hpp"

namespace evaluation {

//! The labels of a method in a sequence, or, if index is beyond the last, in all. @param tool -1: all
inline LabelScore labelScore(const Results& results, size_t index, const String& method, int tool)
{
    LabelScore score;
    for (size_t i = 0; i < results.size(); i++)
    {
        const Run* run = index >= results.size() || i == index ? find(*results[i], method) : 0;
        for (size_t k = 0; run && k < run->labels.size(); k++)
            if (tool < 0 || run->labels[k].tool == tool)
                score.add(run->labels[k], results[i]->width);
    }
    return score;
}

inline bool hasLabels(const Results& results)
{
    bool found = false;
    for (size_t i = 0; i < results.size(); i++)
        for (size_t j = 0; j < results[i]->runs.size(); j++)
            found = found || !results[i]->runs[j].labels.empty();
    return found;
}

//! labels.csv, a row a tool; pck.csv, the curves.
inline void writeLabels(const String& folder, const Results& results)
{
    TextFile table(utils::fs::join(folder, "labels.csv")), curves(utils::fs::join(folder, "pck.csv"));
    table << "sequence,tool,method,labels,coverage,mean_px,std_px,mean_percent,std_percent\n";
    curves << "sequence,method,threshold_percent,pck\n";
    const std::vector<String> methods = methodsOf(results);
    for (size_t i = 0; i <= results.size(); i++)
        for (size_t j = 0; j < methods.size(); j++)
        {
            const int count = i < results.size() ? (int)results[i]->tools.size() : 0;
            for (int k = count > 1 ? 0 : count; k <= count; k++)    // each tool, then all
            {
                const int tool = k < count ? k : -1;
                const LabelScore s = labelScore(results, i, methods[j], tool);
                if (s.labels == 0)
                    continue;
                table << labelOf(results, i) + "," + (tool < 0 ? String("all") : results[i]->tools[tool]) + "," + methods[j] + format(",%d,", s.labels) +
                             cell((double)s.percents.size() / s.labels) + "," + cell(s.pixels.mean()) + "," + cell(s.pixels.deviation()) + "," +
                             cell(s.percent.mean()) + "," + cell(s.percent.deviation()) + "\n";
                for (int step = 0; step <= 40 && tool < 0; step++)
                    curves << labelOf(results, i) + "," + methods[j] + "," + cell(0.25 * step) + "," + cell(s.pck(0.25 * step)) + "\n";
            }
        }
    table.finish();
    curves.finish();
}

inline std::string labelTable(const Results& results)
{
    std::string text = "| sequence | method | labels | with a pose | error [px] | error [% of the width] | PCK 1 % | 2 % | 5 % |\n"
                       "|---|---|---|---|---|---|---|---|---|\n";
    const std::vector<String> methods = methodsOf(results);
    for (size_t i = 0; i <= results.size(); i++)
        for (size_t j = 0; j < methods.size(); j++)
        {
            const LabelScore s = labelScore(results, i, methods[j], -1);
            if (s.labels > 0)
                text += "| " + labelOf(results, i) + " | " + methods[j] + format(" | %d | ", s.labels) +
                        shown(100. * s.percents.size() / s.labels, 1, " %") + " | " + shown(s.pixels.mean(), s.pixels.deviation(), 1) + " | " +
                        shown(s.percent.mean(), s.percent.deviation(), 2) + " | " + shown(100 * s.pck(1), 1, " %") + " | " +
                        shown(100 * s.pck(2), 1, " %") + " | " + shown(100 * s.pck(5), 1, " %") + " |\n";
        }
    return text;
}

//! Shares of all frames with truth.
struct MeasureScore
{
    MeasureScore() : frames(0), near(0), inImage(0), pose(0) {}
    double frames, near, inImage, pose;
    Moments distance, pixels;    // share of the diameter; [pixel]

    void add(const Run& run)
    {
        for (size_t i = 0; i < run.records.size(); i++)
        {
            const Record& r = run.records[i];
            frames++;
            if (!r.covered() || cvIsNaN(r.space))
                continue;
            distance.add(r.space);
            pixels.add(r.image);
            near += r.space < 0.1;
            inImage += r.image < 5;
            pose += r.translation < 0.005 && r.rotation < 5 * CV_PI / 180;
        }
    }
};

inline MeasureScore measureScore(const Results& results, size_t index, const String& method)
{
    MeasureScore score;
    const std::vector<const Run*> runs = runsOf(results, index, method);
    for (size_t i = 0; i < runs.size(); i++)
        if (!runs[i]->isControl())
            score.add(*runs[i]);
    return score;
}

inline void writeMeasures(const String& filename, const Results& results)
{
    TextFile file(filename);
    file << "sequence,method,frames,add_10_percent,projection_5px,pose_5mm_5deg,add_mean_percent,projection_mean_px\n";
    const std::vector<String> methods = methodsOf(results);
    for (size_t i = 0; i <= results.size(); i++)
        for (size_t j = 0; j < methods.size(); j++)
        {
            const MeasureScore s = measureScore(results, i, methods[j]);
            if (s.frames > 0)
                file << labelOf(results, i) + "," + methods[j] + format(",%.0f,", s.frames) + cell(s.near / s.frames) + "," + cell(s.inImage / s.frames) +
                            "," + cell(s.pose / s.frames) + "," + cell(100 * s.distance.mean()) + "," + cell(s.pixels.mean()) + "\n";
        }
    file.finish();
}

//! Empty: there is no truth.
inline std::string measureTable(const Results& results)
{
    std::string text;
    const std::vector<String> methods = methodsOf(results);
    for (size_t i = 0; i <= results.size(); i++)
        for (size_t j = 0; j < methods.size(); j++)
        {
            const MeasureScore s = measureScore(results, i, methods[j]);
            if (s.frames > 0)
                text += "| " + labelOf(results, i) + " | " + methods[j] + format(" | %.0f | ", s.frames) + shown(100 * s.near / s.frames, 1, " %") + " | " +
                        shown(100 * s.inImage / s.frames, 1, " %") + " | " + shown(100 * s.pose / s.frames, 1, " %") + " | " +
                        shown(100 * s.distance.mean(), 1, " %") + " | " + shown(s.pixels.mean(), 2) + " |\n";
        }
    return text.empty() ? text : "| sequence | method | frames | ADD 10 % | projection 5 px | pose 5 mm, 5 degrees | mean ADD | mean projection [px] |\n"
                                 "|---|---|---|---|---|---|---|---|\n" + text;
}

} // namespace evaluation

#endif
