// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_import.hpp"
#include "opencv2/surgtrack/names.hpp"

namespace opencv_test { namespace {

class SurgTrack_TrackerParamsFile : public ImportTest
{
protected:
    ToolTracker::Params params;
    ToolTracker::Stages stages;
};

TEST_F(SurgTrack_TrackerParamsFile, readsBackAsItWasWritten)
{
    const char* const endings[] = { "yaml", "xml", "json" };
    params.minWindow = 21.5;
    params.adaptation = false;
    stages.matcher.candidates = 7;
    stages.edges.ambiguity = 1. / 3;
    for (int i = 0; i < 3; i++)
    {
        const String file = path(String("params.") + endings[i]);
        writeTrackerParams(file, params, stages);
        ToolTracker::Params p;
        ToolTracker::Stages s;
        readTrackerParams(file, p, s);
        EXPECT_EQ(21.5, p.minWindow);
        EXPECT_FALSE(p.adaptation);
        EXPECT_EQ(7, s.matcher.candidates);
        EXPECT_EQ(1. / 3, s.edges.ambiguity);   // FileStorage writes all digits
        writeTrackerParams(path("again"), p, s);   // the rest is equal, too
        writeTrackerParams(path("first"), params, stages);
        EXPECT_EQ(get("first"), get("again"));
    }
}

TEST_F(SurgTrack_TrackerParamsFile, changesWhatItNamesOnly)
{
    readTrackerParams(put("few.yaml", "%YAML:1.0\nmethod: 0\nfilter: { gate: 2.5 }\n"), params, stages);
    EXPECT_EQ(METHOD_PAPER, params.method);
    EXPECT_EQ(2.5, stages.filter.gate);
    EXPECT_EQ(ToolTracker::Params().seed, params.seed);
    EXPECT_EQ(ToolTracker::Stages().filter.pointNoise, stages.filter.pointNoise);
}

TEST_F(SurgTrack_TrackerParamsFile, refusesWhatIsNoParameter)
{
    EXPECT_ERROR(readTrackerParams(put("a.yaml", "%YAML:1.0\nfilter: { gat: 2.5 }\n"), params, stages), "key filter.gat: there is no such parameter");
    EXPECT_ERROR(readTrackerParams(put("b.yaml", "%YAML:1.0\nseed: 0.5\n"), params, stages), "key seed: expected a whole number");
    EXPECT_ERROR(readTrackerParams(put("c.yaml", "%YAML:1.0\nmethod: 0\ncontours: 2\n"), params, stages), "key contours: expected 0 or 1");
    EXPECT_ERROR(readTrackerParams(put("d.yaml", "%YAML:1.0\nedges: 2\n"), params, stages), "key edges: expected a map");
    EXPECT_ERROR(readTrackerParams(path("none.yaml"), params, stages), "none.yaml");
    EXPECT_EQ(METHOD_FULL, params.method);   // c.yaml was refused as a whole
}

TEST_F(SurgTrack_TrackerParamsFile, setsOneByItsName)
{
    setTrackerParam("coastingTime", "0.5", params, stages);
    setTrackerParam("contours", "false", params, stages);
    setTrackerParam("templates.maxFeatures", "90", params, stages);
    EXPECT_EQ(0.5, params.coastingTime);
    EXPECT_FALSE(params.contours);
    EXPECT_EQ(90, stages.templates.maxFeatures);
    EXPECT_ERROR(setTrackerParam("verifier.maxFeatures", "1", params, stages), "there is no such one, did you mean 'templates.maxFeatures'?; there are method, ");
    EXPECT_ERROR(setTrackerParam("seed", "1.5", params, stages), "parameter 'seed': expected a whole number, found '1.5'");
    EXPECT_ERROR(setTrackerParam("contours", "2", params, stages), "expected true or false");
    EXPECT_ERROR(setTrackerParam("minWindow", "wide", params, stages), "expected a number above 0 to 10000, found 'wide'");
}

TEST_F(SurgTrack_TrackerParamsFile, refusesWhatIsOutOfRange)
{
    EXPECT_ERROR(setTrackerParam("matcher.minSimilarity", "7", params, stages), "'matcher.minSimilarity': expected a number from 0 to 1, found '7'");
    EXPECT_ERROR(setTrackerParam("confirmFrames", "-1", params, stages), "'confirmFrames': expected a whole number from 0 to ");
    EXPECT_ERROR(setTrackerParam("method", "3", params, stages), "'method': expected a whole number from 0 to 2");
    EXPECT_ERROR(setTrackerParam("filter.pointNoise", "0", params, stages), "'filter.pointNoise': expected a number above 0");
    EXPECT_ERROR(readTrackerParams(put("a.yaml", "%YAML:1.0\nmatcher: { candidates: 0 }\n"), params, stages),
                 "key matcher.candidates: expected a whole number from 1 to ");
    EXPECT_ERROR(readTrackerParams(put("b.yaml", "%YAML:1.0\ncoastingTime: -0.5\n"), params, stages), "key coastingTime: expected a number from 0 on, found -0.5");
    EXPECT_ERROR(readTrackerParams(put("c.yaml", "%YAML:1.0\ncoastngTime: 0.5\n"), params, stages), "did you mean 'coastingTime'?");
    EXPECT_EQ(ToolTracker::Params().confirmFrames, params.confirmFrames);
}

TEST(SurgTrack_Names, aMisspeltOneIsToldAndNoOther)
{
    std::vector<String> names;
    names.push_back("time_offset");
    names.push_back("camera_T_base");
    names.push_back("matcher.spread");
    EXPECT_EQ("time_offset", closestName("time_ofset", names));
    EXPECT_EQ("camera_T_base", closestName("camera_t_bass", names));
    EXPECT_EQ("matcher.spread", closestName("spread", names));
    EXPECT_EQ("", closestName("surgeon", names));
    EXPECT_EQ("", closestName("", names));
    EXPECT_EQ(", did you mean 'time_offset'?", didYouMean("timeoffset", names));
}

}} // namespace
