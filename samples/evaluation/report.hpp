// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// The pictures and the text that evaluate leaves for people.

#ifndef OPENCV_SURGTRACK_SAMPLES_EVALUATION_REPORT_HPP
#define OPENCV_SURGTRACK_SAMPLES_EVALUATION_REPORT_HPP

#include "other_tables.hpp"

namespace evaluation {

//! As people read it.
inline String methodTitle(const String& method)
{
    return method == "full-stereo" ? String("full, stereo") : method;
}

inline String worstName(const Result& result, const Run& run)
{
    return "worst_" + result.label + "_" + run.method + ".png";
}

inline void writeWorst(const String& folder, const Results& results)
{
    TextFile file(utils::fs::join(folder, "worst.csv"));
    file << "sequence,method,tool,frame,translation_mm,rotation_rad,inliers,similarity,contour_support,nis,nees,picture\n";
    for (size_t i = 0; i < results.size(); i++)
        for (size_t j = 0; j < results[i]->runs.size(); j++)
        {
            const Run& run = results[i]->runs[j];
            if (run.picture.empty())
                continue;
            const Record& r = run.worst;
            const String picture = worstName(*results[i], run);
            TextFile image(utils::fs::join(folder, picture));
            image << std::string(run.picture.begin(), run.picture.end());
            image.finish();
            file << results[i]->label + "," + run.method + "," + results[i]->tools[r.tool] + format(",%d,", r.frame) +
                        cell(1e3 * r.translation) + "," + cell(r.rotation) + format(",%d,", r.inliers) + cell(r.similarity) + "," +
                        cell(r.contourSupport) + "," + cell(r.nis) + "," + cell(r.nees) + "," + picture + "\n";
        }
    file.finish();
}

inline std::string scoreTable(const Results& results)
{
    std::string text = "| sequence | method | frames | translation [mm] | rotation [rad] | accuracy | covered | silent |\n"
                       "|---|---|---|---|---|---|---|---|\n";
    const std::vector<String> methods = methodsOf(results);
    for (size_t i = 0; i <= results.size(); i++)
        for (size_t j = 0; j < methods.size(); j++)
        {
            const bool all = i == results.size();
            if (!all && !find(*results[i], methods[j]))
                continue;
            const Score s = all ? overallScore(results, methods[j]) : scoreOf(*find(*results[i], methods[j]));
            text += "| " + (j > 0 ? String() : labelOf(results, i)) + " | " + methodTitle(methods[j]) +
                    format(" | %d | ", s.frames) + shown(1e3 * s.translation.mean(), 1e3 * s.translation.deviation(), 2) + " | " +
                    shown(s.rotation.mean(), s.rotation.deviation(), 3) + " | " + shown(100 * s.share(s.accurate), 2, " %") + " | " +
                    shown(100 * s.share(s.covered), 1, " %") + " | " + shown(100 * s.share(s.silent), 2, " %") + " |\n";
        }
    return text;
}

//! Frames a second, for the screen.
inline std::string speedLine(const Results& results)
{
    const std::vector<String> methods = methodsOf(results);
    std::string text;
    for (size_t i = 0; i < methods.size(); i++)
    {
        const Score s = overallScore(results, methods[i]);
        if (s.seconds > 0)
            text += (text.empty() ? "\nHz of ToolTracker::update(): " : "; ") + methodTitle(methods[i]) + " " + shown(s.hz(), 0);
    }
    return text.empty() ? text : text + "\n";
}

inline std::string detectionTable(const Results& results)
{
    std::string text = "| sequence | templates drawn | prior off by [px] | top 1: 5 px | 10 px | 20 px | top 5: 5 px | 10 px | 20 px | samples |\n"
                       "|---|---|---|---|---|---|---|---|---|---|\n";
    Detection sum;
    for (size_t i = 0; i <= results.size(); i++)
    {
        const bool all = i == results.size();
        const Detection& detection = all ? sum : results[i]->detection;
        for (int variant = 0; variant < VARIANTS; variant++)
        {
            const DetectionCount count = detection.all(variant);
            text += "| " + (variant > 0 ? String() : labelOf(results, i)) + " | " +
                    (variant == 0 ? "with the raw hand-eye" : "as tracked") + " | " +
                    shown(count.samples ? count.prior / count.samples : unknown(), 1);
            for (int n = 0; n < MAX_TOP_N; n += MAX_TOP_N - 1)
                for (int k = 0; k < THRESHOLDS; k++)
                    text += " | " + shown(100 * count.rate(k, n), 1, " %");
            text += format(" | %d |\n", count.samples);
        }
        if (!all)
            sum.add(detection);
    }
    return text;
}

//! The detectors that are compared on the same classes; empty without baselines.
inline std::string classTable(const Results& results)
{
    std::string text;
    for (size_t i = 0; i <= results.size(); i++)
    {
        const std::vector<ClassCounts> classes = classesOf(results, i);
        for (size_t j = 0; j < classes.size(); j++)
        {
            const DetectionCount count = classes[j].all();
            text += "| " + (j > 0 ? String() : labelOf(results, i)) + " | " + classes[j].detector + ", " + classes[j].variant;
            for (int n = 0; n < MAX_TOP_N; n += MAX_TOP_N - 1)
                for (int k = 0; k < THRESHOLDS; k++)
                    text += " | " + shown(100 * count.rate(k, n), 1, " %");
            text += format(" | %d |\n", count.samples);
        }
    }
    return text.empty() ? text : "The same of classes of parts, whatever their side, for all detectors. `image`: a class is looked for in the whole "
                                 "image; `window`: within 120 px of where the recorded kinematics have it. A part without a template is one not found."
                                 "\n\n| sequence | detector | top 1: 5 px | 10 px | 20 px | top 5: 5 px | 10 px | 20 px | samples |\n"
                                 "|---|---|---|---|---|---|---|---|---|\n" + text + "\n![](detection_classes.png)\n\n";
}

inline std::string axesTable(const Results& results)
{
    std::string text = "| sequence | method | x | y | z |\n|---|---|---|---|---|\n";
    const std::vector<String> methods = methodsOf(results);
    for (size_t i = 0; i <= results.size(); i++)
        for (size_t j = 0; j < methods.size(); j++)
        {
            const std::vector<const Run*> runs = runsOf(results, i, methods[j]);
            if (runs.empty())
                continue;
            text += "| " + (j > 0 ? String() : labelOf(results, i)) + " | " + methodTitle(methods[j]);
            for (int axis = 0; axis < 3; axis++)
            {
                AxisError error;
                for (size_t k = 0; k < runs.size(); k++)
                    error.add(*runs[k], axis);
                text += " | " + shown(error.size.mean(), error.size.deviation(), 3);
            }
            text += " |\n";
        }
    return text;
}

inline std::string consistencyTable(const Results& results)
{
    std::string text = "| sequence | method | quantity | mean | 95 % band of the mean | runs | frames inside their 95 % band |\n"
                       "|---|---|---|---|---|---|---|\n";
    const std::vector<String> methods = methodsOf(results);
    for (size_t i = 0; i <= results.size(); i++)
        for (size_t j = 0; j < methods.size(); j++)
        {
            const std::vector<const Run*> runs = runsOf(results, i, methods[j]);
            if (runs.empty() || runs[0]->isControl())
                continue;
            const std::vector<ConsistencyRow> rows = consistencyOf(runs);
            for (size_t k = 0; k < rows.size(); k++)
                if (rows[k].frames > 0)
                    text += "| " + labelOf(results, i) + " | " + methodTitle(methods[j]) + " | " + rows[k].quantity +
                            format(" (expected %g) | ", rows[k].expected) + shown(rows[k].mean, 2) + " | " + shown(rows[k].band.low, 2) + " to " +
                            shown(rows[k].band.high, 2) + format(" | %d | ", rows[k].runs) + shown(100 * rows[k].inside, 1, " %") + " |\n";
        }
    return text;
}

inline std::string worstTable(const Results& results)
{
    std::string text;
    for (size_t i = 0; i < results.size(); i++)
        for (size_t j = 0; j < results[i]->runs.size(); j++)
        {
            const Run& run = results[i]->runs[j];
            if (run.picture.empty())
                continue;
            const Record& r = run.worst;
            text += results[i]->label + ", " + methodTitle(run.method) + format(": frame %d, ", r.frame) +
                    results[i]->tools[r.tool] + format(", %.2f mm, %.3f rad; %d inliers of similarity %.2f", 1e3 * r.translation,
                                                                      r.rotation, r.inliers, r.similarity) +
                    "\n\n![](" + worstName(*results[i], run) + ")\n\n";
        }
    return text.empty() ? "No frame was tracked.\n\n" : text;
}

//! Whether some method of a sequence has covariances, so that plot_evaluation.py has something to plot.
inline bool hasCovariance(const Result& result)
{
    for (size_t i = 0; i < result.runs.size(); i++)
        for (size_t j = 0; j < result.runs[i].records.size(); j++)
            if (result.runs[i].records[j].covered() && !cvIsNaN(result.runs[i].records[j].nees))
                return true;
    return false;
}

//! The same for joint offsets.
inline bool hasOffsets(const Result& result)
{
    for (size_t i = 0; i < result.runs.size(); i++)
        for (size_t j = 0; j < result.runs[i].records.size(); j++)
        {
            const Record& r = result.runs[i].records[j];
            if (r.covered() && std::count(r.offsets.begin(), r.offsets.end(), 0.) < (int)r.offsets.size())
                return true;
        }
    return false;
}

inline void writeReport(const String& filename, const Results& results, const std::vector<std::string>& failures)
{
    TextFile file(filename);
    file << "# Evaluation\n\nPictures that are missing come from `plot_evaluation.py` with this folder.\n\n";
    for (size_t i = 0; i < failures.size(); i++)
        file << (i == 0 ? "Not evaluated:\n\n" : "") + ("- " + failures[i] + "\n") + (i + 1 == failures.size() ? "\n" : "");
    file << "## Errors\n\nMean \xc2\xb1 standard deviation over the frames with a pose (tracking or coasting). Accuracy: share of all frames "
            "whose mean reprojection error is at most 10 px in an image 720 px wide. Silent: share of all frames that claim to be tracking "
            "and are more than 5 mm off. Two controls look at no image and give a pose in every frame: `recorded`, joint readings and hand-eye "
            "calibration as recorded; `frozen`, the true correction of the first frame, kept.\n\n"
         << scoreTable(results) << "\n![](table.png)\n\n";
    const bool known = !measureTable(results).empty();   // poses, of some sequence
    if (known)
        file << "## Detection of parts\n\nShare of the visible keypoints with a template that have a match within so many pixels (of an image "
            "720 px wide) among the best 1 or 5 of their part.\n\n"
         << detectionTable(results) << "\n![](detection.png)\n\n![](detection_parts.png)\n\n"
         << classTable(results);
    if (hasLabels(results))
        file << "## Keypoints in the image\n\nDistance of labelled keypoints, or of those that the truth has in sight, from where the pose has them; and the "
                "share of them, with a pose or without, within so many per cent of the image width (PCK).\n\n"
             << labelTable(results) << "\n![](pck.png)\n\n";
    if (known)
        file << "## Measures of SurgRIPE\n\nShare of all frames. ADD: the points of the end effector, jaws at their joints, are within 10 % of its diameter of "
                "where they are, on average; projection: within 5 px in the image; pose: within 5 mm and 5 degrees.\n\n"
             << measureTable(results) << "\n";
    if (known)
        file << "## Rotation error by axis\n\nSize of the components of the rotation vector of R_true^T R_estimate [rad], about the axes of the "
            "end effector.\n\n"
         << axesTable(results) << "\n![](rotation_axes.png)\n\n";
    file << "## Consistency\n\nNEES: squared error of `camera_T_tool` normalised by its covariance. Its mean is that over runs (a tool of a "
            "sequence each) of their means over time, the band that of the mean of as many independent values: errors of successive frames are "
            "correlated. NIS per degree of freedom, two an inlier, over all frames. The last column looks at each frame alone: 95 % if the "
            "filter is consistent.\n\n"
         << consistencyTable(results) << "\n";
    for (size_t i = 0; i < results.size(); i++)
        if (hasCovariance(*results[i]))
            file << "![](error_" + results[i]->label + ".png)\n\n![](nees_" + results[i]->label + ".png)\n\n";
    for (size_t i = 0; i < results.size(); i++)
        if (hasOffsets(*results[i]))
            file << "![](offsets_" + results[i]->label + ".png)\n\n";
    file << "## Worst frames\n\nThe tracked frame whose end effector is farthest off. White: truth, green: estimate; right: twice as large.\n\n"
         << worstTable(results);
    file.finish();
}

} // namespace evaluation

#endif
