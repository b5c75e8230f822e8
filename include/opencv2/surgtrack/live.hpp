// This file is part of OpenCV project.
// It is subject to the license terms in the LICENSE file found in the top-level directory
// of this distribution and at http://opencv.org/license.html.

#ifndef OPENCV_SURGTRACK_LIVE_HPP
#define OPENCV_SURGTRACK_LIVE_HPP

#include "opencv2/surgtrack/tool_tracker.hpp"

namespace cv { namespace surgtrack {

//! @addtogroup surgtrack
//! @{

/** @brief What a robot says of one tool's joints at one moment: of all of them, or of some. */
struct CV_EXPORTS_W_SIMPLE JointReading
{
    CV_WRAP JointReading();

    CV_PROP_RW String tool;                      //!< empty if the sender does not say
    CV_PROP_RW double time;                      //!< on the robot's clock [s]
    CV_PROP_RW std::vector<String> names;        //!< of the positions; empty if the sender does not say
    CV_PROP_RW std::vector<double> positions;    //!< [rad or m]
};

/** @brief Reads a message of a robot. Two kinds are understood:

    {"tool": "PSM1", "time": 12.34, "position": [0.1, -0.2, 0.12, 0.3, 0.2, -0.1, 0.5]}
    {"measured_js": {"Name": ["yaw", "pitch", ...], "Position": [0.1, -0.2, ...], "Timestamp": 12.34, "Valid": true, ...}}

The first is plain: `tool` may be missing, names come as `"name": ["q1", ...]` or as `"position": {"q1": 0.1, ...}`. The second is
that of the dVRK's sawSocketStreamer, which has one such key in a message, or several. A key is `measured_js`, before it the tool's
name or nothing, and `jaw` for the jaw: `PSM1/measured_js`, `jaw/measured_js`, `PSM1/jaw/measured_js`. What a jaw's joint is called
there does not matter, here it is `jaw`. Readings the robot says are not valid are left out, and so are other keys.

@param message JSON
@param readings those it has; none in a message about other things
@throws cv::Exception naming the key and what was expected, of text that is not JSON, and of a reading that lacks a key or has
another type, number of values, or a value that is not finite, a time beyond 1e11 s or a position beyond 1e6; readings is then empty. Also if the module was built without
nlohmann_json */
CV_EXPORTS_W void parseJointMessage(const String& message, CV_OUT std::vector<JointReading>& readings);

/** @brief Writes an estimate as a line of JSON, for sending.
@param frame number
@param time of the image [s]
@param tool name
@param estimate its numbers must be finite
@return `frame`, `time`, `tool`, `status` (see stateName()), `position` [m] and `orientation` (unit quaternion x, y, z, w) of
camera_T_tool, `covariance` (6 rows of 6 numbers, as ToolEstimate::covariance), `joint_offsets`, `similarity`, `contour`,
`inliers`, `nis`; all numbers but the time with nine digits
@throws cv::Exception if a number is not finite, or the module was built without nlohmann_json */
CV_EXPORTS_W String formatPoseMessage(int frame, double time, const String& tool, const ToolEstimate& estimate);

//! What JointBuffer::at() found.
enum JointsState
{
    JOINTS_FOUND = 0,     //!< readings before and after the time, or at it
    JOINTS_NONE = 1,      //!< a coordinate has no reading at all
    JOINTS_TOO_OLD = 2,   //!< the time lies before the history
    JOINTS_TOO_NEW = 3,   //!< the time lies after the last reading: wait for the next one
    JOINTS_GAP = 4        //!< the readings before and after are too far apart
};

/** @brief The joint readings of a tool's last seconds, to be had at the time of an image. For readings that come one by one, in
any order and from several senders, as over a network: late ones are put where they belong, those there is one of already are
ignored. Each coordinate has a history of its own, since arm and jaws are read at different moments. Not for several threads at
once. */
class CV_EXPORTS_W JointBuffer
{
public:
    /** @param coordinates as ToolModel::coordinateNames()
    @param history how long a reading is kept [s]; 4096 readings of a coordinate at most
    @param maxGap readings further apart are not interpolated between [s]. A tool at 50 mm/s that turns back within 0.1 s is
    1.3 mm off a straight line */
    CV_WRAP static Ptr<JointBuffer> create(const std::vector<String>& coordinates, double history = 10., double maxGap = 0.1);

    virtual ~JointBuffer() {}

    /** @brief Takes in a reading.

    Positions go to the coordinates of their names, or of those the dVRK has for q1 to q6 (yaw, pitch, insertion, roll, wrist_pitch,
    wrist_yaw, with or without `outer_`); a name that is none is passed over. Without names, or if none of them is a
    coordinate, positions are in the order of the coordinates: all of them, or all but the last one, the jaw.

    A reading older than the history, counted from the newest one, is not kept, nor one that is newer by more than that. If that happens 50
    times in succession the robot's clock was set, or paused, or the newest reading was wrong: the history then starts anew.

    @return whether anything of it was new
    @throws cv::Exception for another number of positions, for values that are not finite, and for times beyond 1e11 s and positions beyond
    1e6, which no robot has; nothing is then kept */
    CV_WRAP virtual bool add(const JointReading& reading) = 0;

    /** @brief The joints at a time, linearly interpolated.
    @param time on the robot's clock [s]
    @param joints one value per coordinate [rad or m]; unchanged if there are none
    @return see cv::surgtrack::JointsState; of several coordinates that of the first one that is not found */
    CV_WRAP virtual int at(double time, CV_OUT std::vector<double>& joints) const = 0;

    /** @brief The last moment of which all coordinates are known [s]; -DBL_MAX if there is none. */
    CV_WRAP virtual double newest() const = 0;

    /** @brief Forgets all readings. */
    CV_WRAP virtual void clear() = 0;
};

/** @brief How far another clock is behind this one, from messages stamped by that one. A message takes some time to arrive, never
less than none, so the one that arrived soonest after its stamp tells best; of those of the last seconds, since clocks drift. */
class CV_EXPORTS_W ClockOffset
{
public:
    /** @param window length of the time that is looked back on [s] */
    CV_WRAP static Ptr<ClockOffset> create(double window = 10.);

    virtual ~ClockOffset() {}

    /** @param stamp of the message, on the sender's clock [s]
    @param arrival on this clock [s], not before that of the last call
    @throws cv::Exception for values that are not finite */
    CV_WRAP virtual void add(double stamp, double arrival) = 0;

    /** @brief What to add to a time of the sender's clock to have it on this one [s]: the least arrival - stamp. 0 without a message. */
    CV_WRAP virtual double offset() const = 0;
};

//! @}

}} // namespace cv::surgtrack

#endif
