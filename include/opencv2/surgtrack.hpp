// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_HPP
#define OPENCV_SURGTRACK_HPP

/**
@defgroup surgtrack 3D tracking of articulated surgical tools

Finds the pose of articulated tools in the endoscope's camera from video, CAD model and joint readings, although the hand-eye
calibration is wrong by millimetres and degrees. Implements @cite ye2016realtime, and on top of it (METHOD_FULL, the default)
errors of the joint readings, outlines, a second eye and a verdict on every pose.

Data flows one way through the stages; the correction found in frame t-1 is the only thing that goes back, into the view of
frame t:

    ToolModel ---+                                                                   +-> ToolPoseEKF (METHOD_PAPER) --------+
                 +-> PartTemplateRenderer -> QGOMatcher -> GeometricContextVerifier -+-> solveEPnP() (METHOD_EPNP) ---------+-> estimate
    MeshRenderer +           |                                                       +-> ArticulatedPoseEKF (METHOD_FULL) --+
                             |                                                              |                 ^
                             |                                            pose of the parts |                 | edges on normals
                             |                                                              v                 |
                             +-> ToolContour: outline of the drawing -------------> placeContour() -> matchContour()
    |<------------------------------------------ ToolTracker: all of it, per frame ------------------------------------------->|

METHOD_FULL runs the upper row once for each eye; one filter takes in the points and edges of all of them. Beside the pose it
reports evidence that the filter does not have: how similar the parts are, and how much of the outline is where it should be.

**Frames.** `base`: the arm's remote centre of motion. `tool`: the end effector of the tool file. `nominal`: where the hand-eye
calibration believes the camera is. `camera`: x right, y down, z forward. `a_T_b` maps coordinates in b to coordinates in a:

    camera_T_tool = camera_T_nominal * nominal_T_base * base_T_tool(joints)

and `camera_T_nominal`, the correction, is what is sought. METHOD_FULL seeks the joints' errors as well: there `joints` are the
readings plus ToolEstimate::jointOffsets. With a right camera all poses are in the frame of the left one.

**Units.** Metres, radians, seconds, pixels. Pixel (0, 0) is the centre of the top-left pixel.

**Headers.** `opencv2/surgtrack.hpp` is tracking. `opencv2/surgtrack/lab.hpp` is what is around it: synthetic scenes, hand-eye
calibration, time offsets, importers, live data, the scene from outside and scores against the truth.
*/

#include "opencv2/surgtrack/camera.hpp"
#include "opencv2/surgtrack/fields.hpp"
#include "opencv2/surgtrack/tool_model.hpp"
#include "opencv2/surgtrack/tool_view.hpp"
#include "opencv2/surgtrack/part_match.hpp"
#include "opencv2/surgtrack/mesh_renderer.hpp"
#include "opencv2/surgtrack/part_templates.hpp"
#include "opencv2/surgtrack/qgo.hpp"
#include "opencv2/surgtrack/qgo_matcher.hpp"
#include "opencv2/surgtrack/geometric_context.hpp"
#include "opencv2/surgtrack/part_finder.hpp"
#include "opencv2/surgtrack/tool_pose_ekf.hpp"
#include "opencv2/surgtrack/contour.hpp"
#include "opencv2/surgtrack/reading_errors.hpp"
#include "opencv2/surgtrack/articulated_pose_ekf.hpp"
#include "opencv2/surgtrack/tracking_state.hpp"
#include "opencv2/surgtrack/tool_estimate.hpp"
#include "opencv2/surgtrack/tool_tracker.hpp"
#include "opencv2/surgtrack/draw.hpp"
#include "opencv2/surgtrack/sequence.hpp"

#endif
