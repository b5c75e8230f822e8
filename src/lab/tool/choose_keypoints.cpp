// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "precomp.hpp"
#include "opencv2/surgtrack/tool_setup.hpp"
#include <map>
#include "base/geometry.hpp"
#include "lab/tool/keypoint_trial.hpp"
#include "lab/tool/simplified.hpp"
#include "lab/tool/surface.hpp"

namespace cv { namespace surgtrack {

namespace {

const double SPACING = 0.0015;      // of candidates [m]
const double APART = 0.0022;        // of keypoints [m]: a fifth of a template's box; nearer ones are found and missed together
const double SHAFT = 0.012;         // how much of the shaft belongs to it [m]: a template's box, and a little
const double FARTHEST = 0.06;       // of candidates from the middle of wrist and jaws [m]: twice what instruments have; a tool in millimetres is soon done with
const double CREASE = 35 * CV_PI / 180;   // sharper edges of a mesh are drawn as edges [rad]
const int MOST = 200000;            // triangles: beyond it drawing takes too long
const double CLEARLY = 1.001;       // halves of a tool are mirror images: the first of two alike, not the one that rounding prefers
const int LEAST = 6;                // from every side: as many as geometric context needs to tell good from bad
const double RELIABLE = 0.75;       // a point found less often says something wrong too often: 0.75 and 0.9 are alike in scenes of other seeds than the tests'
const double SIGMA = 0.7;           // error of a match in any case: places are whole pixels, edges are blurred [pixel]

// What is known before an image, as the tracker takes it: of a hand-eye calibration, and of joints.
const double PRIOR_SHIFT = 0.008, PRIOR_TURN = 4 * CV_PI / 180, PRIOR_OFFSET = 0.03;

typedef std::vector<std::vector<Sighting> > Sightings;   // by picture and candidate

Vec3d normalOf(const Mesh& mesh, const Vec3i& t)
{
    const Point3d a(mesh.vertices[t[0]]), b(mesh.vertices[t[1]]), c(mesh.vertices[t[2]]);
    return Vec3d((b - a).cross(c - a));
}

bool isSharp(const Mesh& mesh, const Vec3i& a, const Vec3i& b)
{
    const Vec3d p = normalOf(mesh, a), q = normalOf(mesh, b);
    return p.dot(q) < std::cos(CREASE) * norm(p) * norm(q);
}

/* Places on a mesh, one in each cell of a grid: the point of its sharp edges nearest to the cell's middle, else that of its surface. So they are the
same however its faces are cut into triangles. */
class Places
{
public:
    Places(const Mesh& mesh, const Matx44d& base_T_link, const Point3d& centre, double reach)
        : centre_(transform(rigidInverse(base_T_link), centre)), reach_(reach)
    {
        typedef std::pair<Vec3f, Vec3f> Edge;   // by position: vertices at creases are there twice
        struct Less { bool operator()(const Edge& a, const Edge& b) const
        {
            const float* p = a.first.val, *q = b.first.val;
            for (int i = 0; i < 3; i++) if (p[i] != q[i]) return p[i] < q[i];
            p = a.second.val, q = b.second.val;
            for (int i = 0; i < 3; i++) if (p[i] != q[i]) return p[i] < q[i];
            return false;
        } };
        std::map<Edge, int, Less> edges;
        for (int i = 0; i < (int)mesh.triangles.size(); i++)
        {
            const Vec3i& t = mesh.triangles[i];
            const Vec3f corners[] = { Vec3f(mesh.vertices[t[0]]), Vec3f(mesh.vertices[t[1]]), Vec3f(mesh.vertices[t[2]]) };
            if (!addAll(corners, 3))
                continue;
            for (int k = 0; k < 3; k++)
            {
                const Vec3f ends[] = { corners[k], corners[(k + 1) % 3] };
                const Edge edge(ends[0], ends[1]), turned(ends[1], ends[0]);
                const std::pair<typename std::map<Edge, int, Less>::iterator, bool> put = edges.insert(std::make_pair(Less()(turned, edge) ? turned : edge, i));
                if (!put.second && isSharp(mesh, mesh.triangles[put.first->second], t))
                    addAll(ends, 2);
            }
        }
        for (std::map<int64, Place>::const_iterator i = cells_.begin(); i != cells_.end(); ++i)
            found.push_back(i->second.point);
    }

    std::vector<Point3d> found;

private:
    struct Place
    {
        double cost;
        Point3d point;
    };

    //! Many points of a tool lie in planes of symmetry, at 0 but for rounding: no border of cells runs there.
    static int cellAt(double x) { return cvFloor(x / SPACING + 0.37); }

    //! The points of a triangle or an edge in all cells it goes through. @return false if it is far off
    bool addAll(const Vec3f* corners, int count)
    {
        Vec3f low = corners[0], high = low;
        for (int i = 1; i < count; i++)
            for (int k = 0; k < 3; k++)
            {
                low[k] = std::min(low[k], corners[i][k]);
                high[k] = std::max(high[k], corners[i][k]);
            }
        Vec3i first, last;
        for (int k = 0; k < 3; k++)
        {
            first[k] = cellAt(std::max((double)low[k], Vec3d(centre_)[k] - reach_));
            last[k] = cellAt(std::min((double)high[k], Vec3d(centre_)[k] + reach_));
            if (first[k] > last[k])
                return false;
        }
        Vec3i cell;
        for (cell[0] = first[0]; cell[0] <= last[0]; cell[0]++)
            for (cell[1] = first[1]; cell[1] <= last[1]; cell[1]++)
                for (cell[2] = first[2]; cell[2] <= last[2]; cell[2]++)
                    add(cell, corners, count);
        return true;
    }

    void add(const Vec3i& cell, const Vec3f* corners, int count)
    {
        const Vec3d middle = (Vec3d(cell) + Vec3d::all(0.5 - 0.37)) * SPACING;
        const Vec3d p = count == 2 ? nearestOnSegment(middle, corners[0], corners[1]) : nearestOnTriangle(middle, corners[0], corners[1], corners[2]);
        const double off = norm(p - middle), outside = norm(p - middle, NORM_INF) - SPACING / 2;
        if (outside > 0 || norm(Point3d(p) - centre_) > reach_)
            return;
        const Place place = { count == 2 ? off : off + SPACING, Point3d(p) };   // edges before surfaces
        const int64 key = ((int64)(cell[0] + 100000) * 200000 + cell[1] + 100000) * 200000 + cell[2] + 100000;
        const std::pair<std::map<int64, Place>::iterator, bool> put = cells_.insert(std::make_pair(key, place));
        if (place.cost < put.first->second.cost)
            put.first->second = place;
    }

    Point3d centre_;   // in the link's frame
    double reach_;
    std::map<int64, Place> cells_;
};

Ptr<ToolModel> withCandidates(const ToolModel& model, const ToolMotion& motion)
{
    ToolModel::Description tool = model.description();
    tool.keypoints.clear();
    std::vector<Matx44d> base_T_link;
    model.forwardKinematics(motion.rest, base_T_link);
    for (size_t i = 0; i < tool.links.size(); i++)
    {
        if (tool.links[i].mesh < 0)
            continue;
        const Places places(tool.meshes[tool.links[i].mesh], base_T_link[i], motion.centre, std::min(motion.reach + SHAFT, FARTHEST));
        for (size_t k = 0; k < places.found.size(); k++)
        {
            ToolModel::Keypoint keypoint;
            keypoint.name = tool.links[i].name + format("_%d", (int)k + 1);
            keypoint.link = (int)i;
            keypoint.linkPoint = places.found[k];
            tool.keypoints.push_back(keypoint);
        }
    }
    return ToolModel::create(tool);
}

//! Only the keypoints of these indices, in this order.
Ptr<ToolModel> withOnly(const ToolModel& model, const std::vector<int>& kept)
{
    ToolModel::Description tool = model.description();
    tool.keypoints.clear();
    for (size_t i = 0; i < kept.size(); i++)
        tool.keypoints.push_back(model.keypoints()[kept[i]]);
    return ToolModel::create(tool);
}

Sightings tryAll(const Ptr<ToolModel>& model, const ToolMotion& motion, int first, int step)
{
    std::vector<int> pictures;
    for (int i = first; i < KeypointTrial::PICTURES; i += step)
        pictures.push_back(i);
    Sightings sightings(pictures.size());
    const int parts = std::max(1, std::min(getNumThreads(), (int)pictures.size()));
    parallel_for_(Range(0, parts), [&](const Range& range)
    {
        for (int part = range.start; part < range.end; part++)
        {
            KeypointTrial trial(model, motion);
            for (size_t i = part; i < pictures.size(); i += parts)
                trial.run(pictures[i], sightings[i]);
        }
    }, parts);
    return sightings;
}

/* Takes the points that tell most, one by one. */
class Choice
{
public:
    Choice(const ToolModel& model, const Sightings& sightings, int states)
        : model_(model), sightings_(sightings), states_(states), taken_(model.keypoints().size(), 0)
    {
        std::vector<double> prior(states * states, 0.);
        for (int i = 0; i < states; i++)
            prior[i * states + i] = i < 3 ? PRIOR_SHIFT * PRIOR_SHIFT : i < 6 ? PRIOR_TURN * PRIOR_TURN : PRIOR_OFFSET * PRIOR_OFFSET;
        covariance_.assign(sightings.size(), prior);
        for (int c = 0; c < (int)taken_.size(); c++)
        {
            int drawn = 0, found = 0;
            double squares = 0;
            for (size_t v = 0; v < sightings.size(); v++)
            {
                const Sighting& s = sightings[v][c];
                drawn += s.drawn;
                found += s.found;
                squares += s.found ? s.error * s.error : 0;
            }
            noise_.push_back(SIGMA * SIGMA + squares / std::max(found, 1));
            found_.push_back((double)found / std::max(drawn, 1));
        }
    }

    std::vector<int> chosen;

    //! In how many of the pictures that show it the matcher found a candidate, 0..1.
    double share(int candidate) const { return found_[candidate]; }

    //! Takes the best one for all pictures, or for one of them. @return whether there was any
    bool take(int picture = -1)
    {
        double most = 1e-3;   // nothing left to be told
        int best = -1;
        for (int c = 0; c < (int)taken_.size(); c++)
        {
            if (taken_[c] || found_[c] < RELIABLE || tooNear(c))
                continue;
            double gain = 0;
            for (int v = picture < 0 ? 0 : picture; v < (picture < 0 ? (int)sightings_.size() : picture + 1); v++)
                gain += told(v, c);
            if (gain > most * CLEARLY)
            {
                most = gain;
                best = c;
            }
        }
        if (best < 0)
            return false;
        taken_[best] = 1;
        chosen.push_back(best);
        for (size_t v = 0; v < sightings_.size(); v++)
            learn((int)v, best);
        return true;
    }

    int found(int picture) const
    {
        int count = 0;
        for (size_t i = 0; i < chosen.size(); i++)
            count += sightings_[picture][chosen[i]].found;
        return count;
    }

private:
    bool tooNear(int c) const
    {
        const ToolModel::Keypoint& k = model_.keypoints()[c];
        for (size_t i = 0; i < chosen.size(); i++)
        {
            const ToolModel::Keypoint& other = model_.keypoints()[chosen[i]];
            if (other.link == k.link && norm(other.linkPoint - k.linkPoint) < APART)
                return true;
        }
        return false;
    }

    //! J P, and the 2 x 2 matrix J P J' + R.
    Matx22d innovation(int v, int c, std::vector<double>& JP) const
    {
        const Sighting& s = sightings_[v][c];
        const std::vector<double>& P = covariance_[v];
        const int n = states_;
        JP.assign(2 * n, 0.);
        for (int r = 0; r < 2; r++)
            for (int k = 0; k < n; k++)
                for (int i = 0; i < n; i++)
                    JP[r * n + i] += s.jacobian[r * n + k] * P[k * n + i];
        Matx22d S(noise_[c], 0, 0, noise_[c]);
        for (int r = 0; r < 2; r++)
            for (int q = 0; q < 2; q++)
                for (int k = 0; k < n; k++)
                    S(r, q) += JP[r * n + k] * s.jacobian[q * n + k];
        return S;
    }

    //! log det of the information with the point, less that without: det(I + J P J' / R).
    double told(int v, int c) const
    {
        if (!sightings_[v][c].found)
            return 0;
        std::vector<double> JP;
        return std::log(determinant(innovation(v, c, JP)) / (noise_[c] * noise_[c]));
    }

    void learn(int v, int c)
    {
        if (!sightings_[v][c].found)
            return;
        std::vector<double> JP;
        const Matx22d inverse = innovation(v, c, JP).inv();
        std::vector<double>& P = covariance_[v];
        const int n = states_;
        for (int i = 0; i < n; i++)
            for (int k = 0; k < n; k++)
                for (int r = 0; r < 2; r++)
                    for (int q = 0; q < 2; q++)
                        P[i * n + k] -= JP[r * n + i] * inverse(r, q) * JP[q * n + k];
    }

    const ToolModel& model_;
    const Sightings& sightings_;
    int states_;
    std::vector<uchar> taken_;
    std::vector<double> noise_, found_;   // by candidate: variance of its matches [pixel^2]; see share()
    std::vector<std::vector<double> > covariance_;   // by picture
};

} // namespace

Ptr<ToolModel> chooseKeypoints(const Ptr<ToolModel>& model, int count)
{
    CV_Assert(model);
    CV_CheckGE(count, LEAST, "count: of keypoints");
    if (model->meshes().empty())
        CV_Error(Error::StsBadArg, "tool '" + model->name() + "': expected meshes to choose keypoints on");
    const Ptr<ToolModel> shape = simplified(canonical(model), MOST);
    const ToolMotion motion(*shape);
    Ptr<ToolModel> all = withCandidates(*shape, motion);

    // First a few pictures: most candidates are inside, or nothing to be found again.
    std::vector<int> kept;
    Sightings sightings = tryAll(all, motion, 0, 4);
    for (size_t c = 0; c < all->keypoints().size(); c++)
    {
        int seen = 0, drawn = 0, found = 0;
        for (size_t v = 0; v < sightings.size(); v++)
        {
            const Sighting& s = sightings[v][c];
            seen += s.seen;
            drawn += s.drawn;
            found += s.found;
        }
        if (seen > 0 && 2 * found >= drawn && found > 0)
            kept.push_back((int)c);
    }
    all = withOnly(*all, kept);
    sightings = tryAll(all, motion, 0, 1);

    Choice choice(*all, sightings, 6 + (int)KeypointTrial::offsets(*all, motion).size());
    while ((int)choice.chosen.size() < count && choice.take()) {}
    for (int v = 0; v < (int)sightings.size(); v++)
        while (choice.found(v) < LEAST && choice.take(v)) {}
    if (choice.chosen.size() < 4)
        CV_Error(Error::StsObjectNotFound, format("tool '%s': %d points were found again in pictures of it, expected 4 and more: are the meshes in metres?",
                                         model->name().c_str(), (int)choice.chosen.size()));
    ToolModel::Description tool = model->description();
    tool.keypoints.clear();
    std::vector<int> number(tool.links.size(), 0);
    std::sort(choice.chosen.begin(), choice.chosen.end());
    for (size_t i = 0; i < choice.chosen.size(); i++)
    {
        ToolModel::Keypoint keypoint = all->keypoints()[choice.chosen[i]];
        keypoint.name = tool.links[keypoint.link].name + format("_%d", ++number[keypoint.link]);
        keypoint.score = choice.share(choice.chosen[i]);
        tool.keypoints.push_back(keypoint);
    }
    return ToolModel::create(tool);
}

}} // namespace cv::surgtrack
