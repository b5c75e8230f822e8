// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "test_common.hpp"

namespace opencv_test { namespace {

typedef GeometricContextVerifier Verifier;

bool moreSimilar(const PartMatch& a, const PartMatch& b)
{
    return a.similarity > b.similarity;
}

/* Candidates of the parts of a tool that appears shifted, turned and scaled against its drawing. */
struct Candidates
{
    Candidates(int parts, uint64 seed) : rng(seed), scale(1), rotation(0)
    {
        // No two parts nearer than 25 pixels, as on a tool.
        while (int(predicted.size()) < parts)
        {
            const Point2d p(uniform(rng, Vec2d(200, 150), Vec2d(420, 370)));
            bool apart = true;
            for (const Point2d& q : predicted) apart = apart && cv::norm(p - q) > 25;
            if (apart) predicted.push_back(p);
        }
    }

    Point2d truth(int part) const
    {
        const Point2d d = (predicted[part] - Point2d(310, 260)) * scale;
        return Point2d(310, 260) + shift + Point2d(std::cos(rotation) * d.x - std::sin(rotation) * d.y, std::sin(rotation) * d.x + std::cos(rotation) * d.y);
    }

    void put(int part, const Point2d& at, double similarity)
    {
        PartMatch m;
        m.part = part;
        m.predictedPoint = predicted[part];
        m.imagePoint = at;
        m.similarity = similarity;
        m.templateIndex = int(matches.size());
        matches.push_back(m);
    }

    void putTrue(int part, double noise)
    {
        const double similarity = rng.uniform(0.65, 0.95);
        put(part, truth(part) + Point2d(gaussian<2>(rng, noise)), similarity);
    }

    // At least 20 pixels off.
    void putFalse(int part)
    {
        Point2d at;
        do at = truth(part) + Point2d(uniform(rng, Vec2d(-60, -60), Vec2d(60, 60)));
        while (cv::norm(at - truth(part)) < 20);
        put(part, at, rng.uniform(0.5, 0.8));
    }

    void sort() { std::stable_sort(matches.begin(), matches.end(), moreSimilar); }

    double off(const PartMatch& m) const { return cv::norm(m.imagePoint - truth(m.part)); }

    RNG rng;
    std::vector<Point2d> predicted;
    std::vector<PartMatch> matches;
    double scale, rotation;
    Point2d shift;
};

// Ten parts, eight of which were found, and two wrong places for each part; wrong ones are less similar as a rule.
Candidates mixture(int seed)
{
    Candidates c(10, seed);
    c.scale = c.rng.uniform(0.97, 1.03);
    c.rotation = c.rng.uniform(-0.1, 0.1);
    c.shift = Point2d(uniform(c.rng, Vec2d(-20, -20), Vec2d(20, 20)));
    for (int part = 0; part < 10; part++)
    {
        if (part < 8) c.putTrue(part, 1);
        c.putFalse(part);
        c.putFalse(part);
    }
    c.sort();
    return c;
}

void precisionAndRecall(const Verifier::Params& params, double& precision, double& recall, double& foundShare)
{
    const int rounds = 300;
    int inlierCount = 0, right = 0, found = 0;
    for (int seed = 1; seed <= rounds; seed++)
    {
        const Candidates c = mixture(seed);
        std::vector<PartMatch> inliers;
        found += Verifier::create(params)->verify(c.matches, inliers);
        inlierCount += int(inliers.size());
        for (const PartMatch& m : inliers) right += c.off(m) < 10;
    }
    precision = double(right) / std::max(1, inlierCount);
    recall = right / (8. * rounds);
    foundShare = found / double(rounds);
}

TEST(SurgTrack_GeometricContext, separatesTrueMatchesFromTwiceAsManyWrongOnes)
{
    double precision, recall, found;
    precisionAndRecall(Verifier::Params(), precision, recall, found);
    EXPECT_GT(precision, 0.8);   // measured: 0.88; at 100 pixels from the centre a zone is 50 pixels wide, where parts that were not found leave room for wrong ones
    EXPECT_GT(recall, 0.93);     // measured: 0.965
    EXPECT_GT(found, 0.99);      // measured: 1
}

TEST(SurgTrack_GeometricContext, theLiteralFormOfThePaperFindsFewer)
{
    Verifier::Params literal;
    literal.centredZones = false;
    literal.maxScale = literal.maxRotation = 0;
    double precision, recall, found, centredPrecision, centredRecall, centredFound;
    precisionAndRecall(literal, precision, recall, found);
    precisionAndRecall(Verifier::Params(), centredPrecision, centredRecall, centredFound);
    EXPECT_GT(precision, 0.9);                  // measured: 0.97
    EXPECT_GT(recall, 0.75);                    // measured: 0.82; places near a cell's edge fall into the next one
    EXPECT_LT(recall, centredRecall - 0.05);    // the reason for centred zones; measured: 0.15 less
}

TEST(SurgTrack_GeometricContext, keepsAllMatchesOfACleanSimilarityTransform)
{
    for (int literal = 0; literal < 2; literal++)
        for (int seed = 1; seed <= 50; seed++)
        {
            Candidates c(8, seed);
            c.shift = Point2d(13, -8);
            for (int part = 0; part < 8; part++) c.putTrue(part, 0);
            c.sort();
            Verifier::Params params;
            params.centredZones = literal == 0;
            std::vector<PartMatch> inliers;
            ASSERT_TRUE(Verifier::create(params)->verify(c.matches, inliers));
            ASSERT_EQ(8u, inliers.size()) << seed;
            for (int i = 0; i < 8; i++) EXPECT_EQ(i, inliers[i].part);   // sorted by part
        }
}

TEST(SurgTrack_GeometricContext, aPartHasAtMostOneInlierAndInliersAreMatches)
{
    for (int literal = 0; literal < 2; literal++)
        for (int seed = 1; seed <= 100; seed++)
        {
            const Candidates c = mixture(seed);
            Verifier::Params params;
            params.centredZones = literal == 0;
            std::vector<PartMatch> inliers;
            const bool found = Verifier::create(params)->verify(c.matches, inliers);
            EXPECT_EQ(found, !inliers.empty());
            EXPECT_TRUE(!found || inliers.size() >= 4);
            for (size_t i = 0; i < inliers.size(); i++)
            {
                ASSERT_TRUE(i == 0 || inliers[i].part > inliers[i - 1].part);
                bool known = false;
                for (const PartMatch& m : c.matches) known = known || sameMatches(std::vector<PartMatch>(1, m), std::vector<PartMatch>(1, inliers[i]));
                ASSERT_TRUE(known);
            }
        }
}

TEST(SurgTrack_GeometricContext, tellsTheSampleThatTheInliersAgreeWith)
{
    const Verifier::Params params;
    const Ptr<Verifier> verifier = Verifier::create(params);
    for (int seed = 0; seed < 20; seed++)
    {
        const Candidates c = mixture(seed);
        std::vector<PartMatch> inliers;
        ASSERT_TRUE(verifier->verify(c.matches, inliers));
        const std::vector<PartMatch> sample = verifier->sample();
        ASSERT_EQ(size_t(2), sample.size());
        int members = 0;
        for (const PartMatch& m : inliers)
        {
            for (const PartMatch& s : sample) members += m.part == s.part && m.imagePoint == s.imagePoint;
            // The zone of each: the same distance from the centre in both grids.
            const double drawn = cv::norm(m.predictedPoint - sample[0].predictedPoint), seen = cv::norm(m.imagePoint - sample[0].imagePoint);
            if (m.part != sample[1].part) EXPECT_LE(std::abs(drawn - seen), params.zoneRadius / 2);
        }
        EXPECT_EQ(2, members);
    }
    std::vector<PartMatch> inliers;
    EXPECT_FALSE(verifier->verify(std::vector<PartMatch>(), inliers));
    EXPECT_TRUE(verifier->sample().empty());
}

TEST(SurgTrack_GeometricContext, matchesThatDoNotAgreeGiveNothing)
{
    // A mirrored arrangement, which no turn or scale makes.
    Candidates c(8, 5);
    for (int part = 0; part < 8; part++) c.put(part, Point2d(620 - c.predicted[part].x, c.predicted[part].y), 0.9 - 0.01 * part);
    std::vector<PartMatch> inliers(3);
    EXPECT_FALSE(Verifier::create()->verify(c.matches, inliers));
    EXPECT_TRUE(inliers.empty());

    // Places at random all over the image.
    int found = 0;
    for (int seed = 1; seed <= 100; seed++)
    {
        Candidates random(8, seed);
        for (int part = 0; part < 8; part++) random.put(part, Point2d(uniform(random.rng, Vec2d(), Vec2d(720, 576))), 0.9 - 0.01 * part);
        found += Verifier::create()->verify(random.matches, inliers);
    }
    EXPECT_LE(found, 3);   // measured: 0; four of eight places agree by chance now and again
}

TEST(SurgTrack_GeometricContext, threeMatchesAreNotEnoughFourAre)
{
    std::vector<PartMatch> inliers(2);
    Candidates c(4, 3);
    EXPECT_FALSE(Verifier::create()->verify(c.matches, inliers));
    EXPECT_TRUE(inliers.empty());
    for (int n = 1; n <= 3; n++)
    {
        c.putTrue(n - 1, 0);
        c.sort();
        inliers.resize(2);
        EXPECT_FALSE(Verifier::create()->verify(c.matches, inliers)) << n;
        EXPECT_TRUE(inliers.empty()) << n;
    }
    c.putTrue(3, 0);
    c.sort();
    EXPECT_TRUE(Verifier::create()->verify(c.matches, inliers));
    EXPECT_EQ(4u, inliers.size());

    Verifier::Params three;
    three.minInliers = 3;
    c.matches.pop_back();
    EXPECT_TRUE(Verifier::create(three)->verify(c.matches, inliers));
    EXPECT_EQ(3u, inliers.size());
}

TEST(SurgTrack_GeometricContext, manyCandidatesOfOnePartAreNoAgreement)
{
    Candidates c(2, 4);
    for (int i = 0; i < 10; i++) c.putTrue(0, 2);
    for (int i = 0; i < 10; i++) c.putTrue(1, 2);
    c.sort();
    std::vector<PartMatch> inliers;
    EXPECT_FALSE(Verifier::create()->verify(c.matches, inliers));
    EXPECT_TRUE(inliers.empty());
}

TEST(SurgTrack_GeometricContext, ofDuplicatesOfAPartTheMoreSimilarIsKept)
{
    Candidates c(6, 6);
    for (int part = 0; part < 6; part++)
    {
        c.put(part, c.truth(part), 0.9 - 0.01 * part);
        c.put(part, c.truth(part), 0.6);
    }
    c.sort();
    std::vector<PartMatch> inliers;
    ASSERT_TRUE(Verifier::create()->verify(c.matches, inliers));
    ASSERT_EQ(6u, inliers.size());
    for (int part = 0; part < 6; part++) EXPECT_EQ(0.9 - 0.01 * part, inliers[part].similarity);
}

TEST(SurgTrack_GeometricContext, coincidentPointsDoNotDisturb)
{
    // All matches at one place: no axis.
    Candidates c(6, 7);
    for (int part = 0; part < 6; part++) c.put(part, Point2d(300, 200), 0.8);
    std::vector<PartMatch> inliers;
    EXPECT_FALSE(Verifier::create()->verify(c.matches, inliers));
    EXPECT_TRUE(inliers.empty());

    // Two parts predicted and found at the same place, among others.
    Candidates d(6, 8);
    d.predicted[1] = d.predicted[0];
    for (int part = 0; part < 6; part++) d.put(part, d.truth(part), 0.9 - 0.01 * part);
    ASSERT_TRUE(Verifier::create()->verify(d.matches, inliers));
    EXPECT_EQ(6u, inliers.size());
}

TEST(SurgTrack_GeometricContext, theSameSeedGivesTheSameInliers)
{
    bool differ = false;
    for (int round = 1; round <= 50; round++)
    {
        const Candidates c = mixture(round);
        Verifier::Params params;
        params.maxIterations = 10;   // few samples, so that the seed matters
        Ptr<Verifier> verifier = Verifier::create(params);
        std::vector<PartMatch> first, again, fresh, other;
        verifier->verify(c.matches, first);
        verifier->verify(c.matches, again);
        Verifier::create(params)->verify(c.matches, fresh);
        EXPECT_TRUE(sameMatches(first, again));
        EXPECT_TRUE(sameMatches(first, fresh));
        params.seed = 2;
        Verifier::create(params)->verify(c.matches, other);
        differ = differ || !sameMatches(first, other);
    }
    EXPECT_TRUE(differ);
}

TEST(SurgTrack_GeometricContext, arrangementsBeyondTheLimitsAreRejected)
{
    struct { double scale, rotation; bool found; } const cases[] = {
        {1, 0, true}, {1.3, 0, true}, {1.45, 0, false}, {0.76, 0, true}, {0.68, 0, false},
        {1, 30 * CV_PI / 180, true}, {1, -30 * CV_PI / 180, true}, {1, 45 * CV_PI / 180, false}, {1, CV_PI, false}};
    for (const auto& k : cases)
    {
        Candidates c(8, 9);
        c.scale = k.scale;
        c.rotation = k.rotation;
        for (int part = 0; part < 8; part++) c.putTrue(part, 0);
        c.sort();
        std::vector<PartMatch> inliers;
        Verifier::Params wide;
        wide.zoneRadius = 200;   // the zones would reject large scales too
        const bool found = Verifier::create(wide)->verify(c.matches, inliers);
        EXPECT_EQ(k.found, found) << k.scale << " " << k.rotation;
        // A rotated arrangement agrees with itself when there is no limit to rotation, as in the paper.
        Verifier::Params any;
        any.maxScale = any.maxRotation = 0;
        if (k.scale == 1)
        {
            EXPECT_TRUE(Verifier::create(any)->verify(c.matches, inliers)) << k.rotation;
            EXPECT_EQ(8u, inliers.size());
        }
    }
}

TEST(SurgTrack_GeometricContext, aWiderZoneAdmitsMore)
{
    Candidates c(8, 10);
    for (int part = 0; part < 5; part++) c.putTrue(part, 0);
    for (int part = 5; part < 8; part++) c.put(part, c.truth(part) + Point2d(12, 0), 0.5);
    c.sort();
    Verifier::Params params;
    std::vector<PartMatch> narrow, wide;
    EXPECT_TRUE(Verifier::create(params)->verify(c.matches, narrow));
    params.zoneRadius = 40;
    EXPECT_TRUE(Verifier::create(params)->verify(c.matches, wide));
    EXPECT_LT(narrow.size(), 8u);
    EXPECT_EQ(8u, wide.size());
}

TEST(SurgTrack_GeometricContext, rejectsBadParameters)
{
    Verifier::Params params;
    params.zoneAngle = 0;
    EXPECT_ERROR(Verifier::create(params), "zoneAngle");
    params = Verifier::Params();
    params.zoneRadius = -1;
    EXPECT_ERROR(Verifier::create(params), "zoneRadius");
    params.zoneRadius = NOT_A_NUMBER;
    EXPECT_ERROR(Verifier::create(params), "zoneRadius");
    params = Verifier::Params();
    params.minInliers = 1;
    EXPECT_ERROR(Verifier::create(params), "minInliers");
    Candidates c(5, 1);
    for (int part = 0; part < 5; part++) c.putTrue(part, 0);
    c.matches[2].part = -1;
    std::vector<PartMatch> inliers;
    EXPECT_ERROR(Verifier::create()->verify(c.matches, inliers), "matches");
}

TEST(SurgTrack_GeometricContext, rejectsPointsThatAreNotFinite)
{
    for (int i = 0; i < 4; i++)
    {
        Candidates c(6, 2);
        for (int part = 0; part < 6; part++) c.putTrue(part, 0);
        c.sort();
        double* const values[] = {&c.matches[0].imagePoint.x, &c.matches[1].imagePoint.y, &c.matches[2].predictedPoint.x, &c.matches[3].similarity};
        *values[i] = NOT_A_NUMBER;
        std::vector<PartMatch> inliers;
        EXPECT_ERROR(Verifier::create()->verify(c.matches, inliers), "matches");
    }
}

}} // namespace
