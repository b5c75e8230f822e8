// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_SRC_LAB_TOOL_TOOL_MOTION_HPP
#define OPENCV_SURGTRACK_SRC_LAB_TOOL_TOOL_MOTION_HPP

#include "opencv2/surgtrack/tool_model.hpp"

namespace cv { namespace surgtrack {

/** How any tool moves, from its chain alone: which coordinates carry it, bend its wrist and open its jaws, how far, and where its
shaft points. */
struct ToolMotion
{
    enum Role { ARM, ROLL, WRIST, JAW };   // what lies before the wrist, turns about the shaft, bends, or moves beside the end effector only

    explicit ToolMotion(const ToolModel& model);

    std::vector<int> role;                 //!< of each coordinate
    std::vector<int> path;                 //!< coordinates on the way to the end effector, from the base on, each once
    std::vector<double> low, high;         //!< a usual range of each coordinate, inside of its limits [rad or m]
    std::vector<double> rest;              //!< straight, jaws closed [rad or m]
    int slide;                             //!< the coordinate that slides along the shaft, or -1
    Vec3d shaft;                           //!< direction of the shaft at rest, towards the end effector, in the base frame
    Point3d centre;                        //!< of wrist and jaws at rest, in the base frame [m]
    double reach;                          //!< from there to the end effector and the wrist's first axis [m]

    /** One of many settings: wrist and jaws anywhere in their range, the arm at rest. @param index settings of 0, 1, ... fill the range evenly */
    std::vector<double> setting(int index) const;

    //! How many joints of the wrist a link hangs on: 0 = the shaft.
    std::vector<int> wristDepth(const ToolModel& model) const;

private:
    void findRoles(const ToolModel& model);
    void findRanges(const ToolModel& model);
    void findShaft(const ToolModel& model);
};

//! How a camera looks at a tool: the tool's base in the camera frame.
struct Viewpoint
{
    double azimuth;      //!< about the shaft [rad]
    double elevation;    //!< between viewing direction and shaft [rad]; 0: from behind along the shaft
    double distance;     //!< of the centre [m]
    Matx44d camera_T_base(const ToolMotion& motion) const;
};

}} // namespace cv::surgtrack

#endif
