// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#include "lab/setup_check/setup_units.hpp"
#include "opencv2/surgtrack/setup_check.hpp"

namespace cv { namespace surgtrack {

namespace {

const double limitSlack = 0.2;         // readings this far beyond a limit are wrong, not badly calibrated [rad]; a tenth of it where a joint slides [m]
const double degrees = 1;              // a turning joint that goes further may have been read in degrees [rad]

//! How the units of a coordinate show: those of the first link that it turns, else of one that it moves, as a jaw's rod beside the jaw.
const ToolModel::Link* linkOf(const ToolModel& model, int coordinate)
{
    const ToolModel::Link* found = 0;
    for (size_t i = 0; i < model.links().size(); i++)
    {
        const ToolModel::Link& link = model.links()[i];
        if (link.jointType == ToolModel::JOINT_FIXED || link.coordinate != coordinate) continue;
        if (!found || (found->jointType == ToolModel::JOINT_PRISMATIC && link.jointType == ToolModel::JOINT_REVOLUTE)) found = &link;
    }
    return found;
}

} // namespace

//! A coordinate that is beyond its limits for a tenth of the time.
String limitFault(const ToolModel& model, const Mat& joints)
{
    const Mat_<double> limits = model.jointLimits();
    for (int c = 0; c < joints.cols; c++)
    {
        const ToolModel::Link* link = linkOf(model, c);
        if (!link || (limits(c, 0) == -DBL_MAX && limits(c, 1) == DBL_MAX)) continue;
        const double slack = link->jointType == ToolModel::JOINT_PRISMATIC ? limitSlack / 10 : limitSlack;
        const int beyond = countNonZero((joints.col(c) < limits(c, 0) - slack) | (joints.col(c) > limits(c, 1) + slack));
        if (beyond * 10 < joints.rows) continue;
        double low, high;
        minMaxIdx(joints.col(c), &low, &high);
        const bool slides = link->jointType == ToolModel::JOINT_PRISMATIC;
        const double unit = slides ? 1e-3 : CV_PI / 180;
        const bool fits = low * unit >= limits(c, 0) - slack && high * unit <= limits(c, 1) + slack;
        return format("coordinate %s goes from %.4g to %.4g, its limits in the tool file are %g and %g: %s", model.coordinateNames()[c].c_str(), low, high,
                      limits(c, 0), limits(c, 1), !fits ? "another column?" : slides ? "expected metres, not millimetres" : "expected radians, not degrees");
    }
    return String();
}

//! Turning coordinates that go so far that their readings may be degrees.
std::vector<int> mayBeDegrees(const ToolModel& model, const Mat& joints)
{
    std::vector<int> found;
    for (int c = 0; c < joints.cols; c++)
    {
        const ToolModel::Link* link = linkOf(model, c);
        if (link && link->jointType == ToolModel::JOINT_REVOLUTE && norm(joints.col(c), NORM_INF) > degrees) found.push_back(c);
    }
    return found;
}

String sizeFault(const ToolModel& model)
{
    for (size_t i = 0; i < model.meshes().size(); i++)
    {
        const Mat points = Mat(model.meshes()[i].vertices).reshape(1);
        Mat low, high;
        reduce(points, low, 0, REDUCE_MIN);
        reduce(points, high, 0, REDUCE_MAX);
        const double length = norm(high - low, NORM_INF);
        if (length > 1.5 || length < 2e-4)
            return format("mesh_scale: a mesh is %.3g m long, expected metres; 0.001 is right for files in millimetres", length);
    }
    return String();
}

String checkUnits(const Ptr<ToolModel>& model, InputArray joints_)
{
    if (!model) CV_Error(Error::StsNullPtr, "model: expected a tool");
    Mat joints;
    joints_.getMat().convertTo(joints, CV_64F);
    CV_CheckEQ(joints.cols * joints.channels(), (int)model->coordinateNames().size(), "joints: expected a column per coordinate");
    for (int c = 0; c < joints.cols; c++)
    {
        const ToolModel::Link* link = linkOf(*model, c);
        if (!link) continue;
        double low, high;
        minMaxIdx(joints.col(c), &low, &high);
        const double most = std::max(-low, high);
        const bool slides = link->jointType == ToolModel::JOINT_PRISMATIC;
        if (most * std::abs(link->scale) > (slides ? 1 : 4 * CV_PI))
            return format("coordinate %s goes to %g: %s", model->coordinateNames()[c].c_str(), most,
                          slides ? "no instrument slides more than 1 m, expected metres, not millimetres"
                                 : "more than two turns, expected radians, not degrees");
    }
    return String();
}

}} // namespace cv::surgtrack
