// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

// Whether a filter is as good as it says: normalised errors and innovations, and what they would be.

#ifndef OPENCV_SURGTRACK_SAMPLES_EVALUATION_CONSISTENCY_HPP
#define OPENCV_SURGTRACK_SAMPLES_EVALUATION_CONSISTENCY_HPP

#include "runs.hpp"

namespace evaluation {

/** NEES: the mean over runs, a tool of a sequence each, of their means over time; its band is
that of the mean of as many independent values, since the errors of successive frames are not independent. NIS per degree of freedom:
the mean over all frames; innovations of a consistent filter are independent, so its band has the degrees of freedom of all of them. */
struct Consistency
{
    std::map<std::pair<int, int>, Moments> runs;          // by number of the run and tool
    double dof, sum;                                      // NIS: of all frames
    int frames, inside;
    Consistency() : dof(0), sum(0), frames(0), inside(0) {}

    void addNees(int number, const Run& run, double Record::*value, int degrees)
    {
        const Band band(degrees, 1);
        for (size_t i = 0; i < run.records.size(); i++)
        {
            const Record& r = run.records[i];
            if (!r.covered() || cvIsNaN(r.*value))
                continue;
            runs[std::make_pair(number, r.tool)].add(r.*value);
            frames++;
            inside += band.holds(r.*value);
        }
    }
    void addNis(int number, const Run& run)
    {
        std::map<int, Band> bands;
        for (size_t i = 0; i < run.records.size(); i++)
        {
            const Record& r = run.records[i];
            const int degrees = 2 * r.inliers;   // u and v of each
            if (!r.covered() || cvIsNaN(r.nis) || degrees <= 0)
                continue;
            const Band& band = bands.insert(std::make_pair(degrees, Band(degrees, degrees))).first->second;
            runs[std::make_pair(number, r.tool)].add(r.nis);
            dof += degrees;
            sum += r.nis * degrees;
            frames++;
            inside += band.holds(r.nis);
        }
    }
    double meanOfRuns() const
    {
        Moments mean;
        for (std::map<std::pair<int, int>, Moments>::const_iterator it = runs.begin(); it != runs.end(); ++it)
            mean.add(it->second.mean());
        return mean.mean();
    }
};

struct ConsistencyRow
{
    String quantity;
    int frames, runs;
    double expected, mean, inside;
    Band band;

    ConsistencyRow(const String& name, const Consistency& c, double newExpected, double newMean, const Band& newBand)
        : quantity(name), frames(c.frames), runs((int)c.runs.size()), expected(newExpected), mean(newMean),
          inside(c.frames ? double(c.inside) / c.frames : unknown()), band(newBand)
    {
    }
};

inline std::vector<ConsistencyRow> consistencyOf(const std::vector<const Run*>& runs)
{
    static const struct { const char* name; double Record::*value; int dof; } kinds[] = {
        { "nees", &Record::nees, 6 }, { "nees_rotation", &Record::rotationNees, 3 }, { "nees_translation", &Record::translationNees, 3 } };
    std::vector<ConsistencyRow> rows;
    for (int k = 0; k < 3; k++)
    {
        Consistency c;
        for (size_t i = 0; i < runs.size(); i++)
            c.addNees((int)i, *runs[i], kinds[k].value, kinds[k].dof);
        const double n = (double)c.runs.size();
        rows.push_back(ConsistencyRow(kinds[k].name, c, kinds[k].dof, c.meanOfRuns(), Band(kinds[k].dof * n, n)));
    }
    Consistency c;
    for (size_t i = 0; i < runs.size(); i++)
        c.addNis((int)i, *runs[i]);
    rows.push_back(ConsistencyRow("nis", c, 1, c.dof > 0 ? c.sum / c.dof : unknown(), Band(c.dof, c.dof)));
    return rows;
}

} // namespace evaluation

#endif
