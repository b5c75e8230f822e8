#!/usr/bin/env python3
# This file is part of OpenCV project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution and at http://opencv.org/license.html.
"""ROS 2 node: image, camera_info and joint states in, camera_T_tool with covariance out.

    python3 samples/ros2_node.py --sequence=DIR --image=/endoscope/left/image_raw --camera-info=/endoscope/left/camera_info

Subscribes to the image, its camera_info and, for each tool of DIR/sequence.yaml (such as PSM1), to PSM1/measured_js and
PSM1/jaw/measured_js, as the dVRK publishes them. Publishes, for each tool,

    PSM1/camera_T_tool   geometry_msgs/PoseWithCovarianceStamped, while the tool is tracked or coasting, in the image's frame
    PSM1/estimate        std_msgs/String, always: the line of formatPoseMessage(), with status and evidence

The camera's matrix, distortion and size are those of camera_info; the images must be raw ones, not rectified. All stamps must be of
one clock; --time-offset is added to the image's to find its joints.

ToolNode and the functions before it need no ROS: they take anything that has the fields of the messages.
"""

import argparse
import sys

import numpy as np
import cv2 as cv
from cv2 import surgtrack as st

try:
    import rclpy
    from rclpy.node import Node
    from rclpy.qos import HistoryPolicy, QoSProfile, ReliabilityPolicy
    from geometry_msgs.msg import PoseWithCovarianceStamped
    from sensor_msgs.msg import CameraInfo, Image, JointState
    from std_msgs.msg import String
except ImportError as e:
    rclpy, why_no_ros = None, e

CHANNELS = {'mono8': 1, '8UC1': 1, 'bgr8': 3, '8UC3': 3, 'rgb8': 3, 'bgra8': 4, '8UC4': 4, 'rgba8': 4,
            'bayer_rggb8': 1, 'bayer_bggr8': 1, 'bayer_gbrg8': 1, 'bayer_grbg8': 1}
# OpenCV names a pattern by its second row, ROS by its first one.
CONVERSIONS = {'rgb8': cv.COLOR_RGB2BGR, 'bgra8': cv.COLOR_BGRA2BGR, '8UC4': cv.COLOR_BGRA2BGR, 'rgba8': cv.COLOR_RGBA2BGR,
               'bayer_rggb8': cv.COLOR_BayerBG2BGR, 'bayer_bggr8': cv.COLOR_BayerRG2BGR,
               'bayer_gbrg8': cv.COLOR_BayerGR2BGR, 'bayer_grbg8': cv.COLOR_BayerGB2BGR}
DISTORTIONS = {'plumb_bob': 5, 'rational_polynomial': 12}       # coefficients that may be other than 0


def seconds(stamp):
    """builtin_interfaces/Time -> [s]"""
    return stamp.sec + 1e-9 * stamp.nanosec


def image_from_message(message):
    """sensor_msgs/Image -> height x width (x 3: BGR) of uint8. ValueError for another encoding, or data that do not fit."""
    encoding = message.encoding
    if encoding not in CHANNELS:
        raise ValueError("image: encoding '%s', expected one of %s" % (encoding, ', '.join(sorted(CHANNELS))))
    channels = CHANNELS[encoding]
    data = np.frombuffer(message.data, np.uint8)
    if message.width < 1 or message.height < 1 or message.step < message.width * channels or data.size < message.step * message.height:
        raise ValueError('image: %d bytes, %d a row, expected %dx%d pixels of %d bytes'
                         % (data.size, message.step, message.width, message.height, channels))
    rows = data[:message.step * message.height].reshape(message.height, message.step)[:, :message.width * channels]
    image = rows if channels == 1 else rows.reshape(message.height, message.width, channels)
    return cv.cvtColor(image, CONVERSIONS[encoding]) if encoding in CONVERSIONS else np.ascontiguousarray(image)


def camera_from_message(message):
    """sensor_msgs/CameraInfo -> CameraModel of the raw image. ValueError for one that is not calibrated, or has another lens model."""
    K, D = np.array(message.k, np.float64).reshape(3, 3), np.array(message.d, np.float64)
    if not (K[0, 0] > 0 and K[1, 1] > 0):
        raise ValueError('camera_info: k has focal lengths of %g and %g, expected those of a calibrated camera' % (K[0, 0], K[1, 1]))
    model = message.distortion_model
    if D.size and model not in DISTORTIONS:
        raise ValueError("camera_info: distortion_model '%s', expected one of %s" % (model, ', '.join(sorted(DISTORTIONS))))
    if D.size not in (0, 4, 5, 8, 12, 14):
        raise ValueError('camera_info: d has %d numbers, expected 4, 5, 8, 12 or 14' % D.size)
    if D.size and D[DISTORTIONS[model]:].any():
        raise ValueError('camera_info: d has %d numbers, expected zeros behind the first %d of a %s' % (D.size, DISTORTIONS[model], model))
    D = D[:DISTORTIONS[model]] if D.size else D
    if max(message.binning_x, message.binning_y) > 1:
        raise ValueError('camera_info: binning %d x %d, expected images of full size' % (message.binning_x, message.binning_y))
    size, roi = (message.width, message.height), getattr(message, 'roi', None)
    if roi is not None and roi.width and roi.height:            # k is of the whole sensor, the images are of a part of it
        K = K - [[0, 0, roi.x_offset], [0, 0, roi.y_offset], [0, 0, 0]]
        size = (roi.width, roi.height)
    return st.CameraModel(K, D, size)


def reading_from_message(message, jaw=False):
    """sensor_msgs/JointState -> JointReading; a jaw's joint is called jaw, whatever its name is."""
    reading = st.JointReading()
    reading.time = seconds(message.header.stamp)
    reading.positions = [float(p) for p in message.position]
    reading.names = ['jaw'] if jaw else [str(name) for name in message.name]
    return reading


def ros_covariance(covariance):
    """6 x 6 of (rotation, translation) -> 36 numbers, row by row, of (translation, rotation). Both rotations are small ones about
    the fixed axes of the camera's frame."""
    order = [3, 4, 5, 0, 1, 2]
    return np.asarray(covariance, np.float64)[np.ix_(order, order)].ravel().tolist()


def quaternion(R):
    """3 x 3 rotation -> (x, y, z, w) of unit length; w is not negative."""
    R = np.asarray(R, np.float64)
    # Of K's eigenvectors the one of the largest eigenvalue (Bar-Itzhack 2000): exact at any angle.
    K = np.array([[R[0, 0] - R[1, 1] - R[2, 2], 0, 0, 0],
                  [R[1, 0] + R[0, 1], R[1, 1] - R[0, 0] - R[2, 2], 0, 0],
                  [R[2, 0] + R[0, 2], R[2, 1] + R[1, 2], R[2, 2] - R[0, 0] - R[1, 1], 0],
                  [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], np.trace(R)]])
    q = np.linalg.eigh(K)[1][:, 3]      # reads the lower triangle
    return tuple(float(c) for c in (q if q[3] >= 0 else -q))


def fill_pose(message, header, estimate):
    """Fills a geometry_msgs/PoseWithCovarianceStamped. header: of the image"""
    T = np.asarray(estimate.camera_T_tool)
    message.header.stamp = header.stamp
    message.header.frame_id = header.frame_id
    position, orientation = message.pose.pose.position, message.pose.pose.orientation
    position.x, position.y, position.z = (float(c) for c in T[:3, 3])
    orientation.x, orientation.y, orientation.z, orientation.w = quaternion(T[:3, :3])
    message.pose.covariance = ros_covariance(estimate.covariance)
    return message


class ToolNode:
    """What the node does, without ROS. Of images that come faster than they can be tracked the newest is taken.

    setup: Sequence; publish(tool name, header of the image, ToolEstimate, text) is called for every tool of an image;
    warn(text) for what is wrong with a message, which is then left out."""

    def __init__(self, setup, time_offset, publish, warn):
        self.publish, self.warn, self.time_offset = publish, warn, time_offset
        self.tools = [setup.tool(i) for i in range(setup.toolCount())]
        self.models = [st.loadTool(tool.model) for tool in self.tools]
        self.buffers = {t.name: st.JointBuffer.create(m.coordinateNames()) for t, m in zip(self.tools, self.models)}
        self.tracker = self.pending = self.last = None
        self.frames = self.dropped = 0

    def take_camera_info(self, message):
        if self.tracker is not None:
            return
        try:
            self.tracker = st.ToolTracker.create(camera_from_message(message))
        except (ValueError, cv.error) as e:
            self.warn(str(e))
            return
        for tool, model in zip(self.tools, self.models):
            self.tracker.addTool(model, tool.nominal_T_base)

    def take_joints(self, tool, message, jaw=False):
        try:
            self.buffers[tool].add(reading_from_message(message, jaw))
        except (ValueError, cv.error) as e:
            self.warn('%s: %s' % (tool, e))
            return
        self.track()

    def take_image(self, message):
        self.dropped += self.pending is not None
        self.pending = message
        self.track()

    def track(self):
        """Tracks the image that waits, once the joints at its time are known."""
        if self.pending is None or self.tracker is None:
            return
        time = seconds(self.pending.header.stamp)
        joints = []
        for tool in self.tools:
            state, values = self.buffers[tool.name].at(time + self.time_offset)
            if state in (st.JOINTS_NONE, st.JOINTS_TOO_NEW):
                return      # still to come
            joints.append(values if state == st.JOINTS_FOUND else None)
        message, self.pending = self.pending, None
        if any(values is None for values in joints) or (self.last is not None and time <= self.last):
            self.dropped += 1
            return
        try:
            estimates = self.tracker.update(image_from_message(message), time, joints)
        except (ValueError, cv.error) as e:
            self.warn(str(e))
            self.dropped += 1
            return
        self.last = time
        for tool, estimate in zip(self.tools, estimates):
            self.publish(tool.name, message.header, estimate, st.formatPoseMessage(self.frames, time, tool.name, estimate))
        self.frames += 1
        self.tracker.renderAhead(joints)        # the next image will have nearly these


def run(args, ros_arguments):
    rclpy.init(args=ros_arguments)
    node = Node('surgtrack')
    setup = st.Sequence.load(args.sequence, False)
    poses, estimates = {}, {}
    for i in range(setup.toolCount()):
        name = setup.tool(i).name
        poses[name] = node.create_publisher(PoseWithCovarianceStamped, name + '/camera_T_tool', 10)
        estimates[name] = node.create_publisher(String, name + '/estimate', 10)

    def publish(name, header, estimate, text):
        if estimate.state in (st.STATE_TRACKING, st.STATE_COASTING):
            poses[name].publish(fill_pose(PoseWithCovarianceStamped(), header, estimate))
        estimates[name].publish(String(data=text))

    tools = ToolNode(setup, args.time_offset, publish, lambda text: node.get_logger().warning(text, throttle_duration_sec=1.))
    newest = QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)
    many = QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=100, reliability=ReliabilityPolicy.BEST_EFFORT)
    node.create_subscription(CameraInfo, args.camera_info, tools.take_camera_info, newest)
    node.create_subscription(Image, args.image, tools.take_image, newest)
    for name in poses:
        node.create_subscription(JointState, name + '/measured_js', lambda m, n=name: tools.take_joints(n, m), many)
        node.create_subscription(JointState, name + '/jaw/measured_js', lambda m, n=name: tools.take_joints(n, m, True), many)
    try:
        rclpy.spin(node)
    except KeyboardInterrupt:
        pass
    node.get_logger().info('%d images tracked, %d dropped' % (tools.frames, tools.dropped))
    node.destroy_node()
    rclpy.try_shutdown()


def main():
    parser = argparse.ArgumentParser(description='Tracks surgical tools in ROS 2.', allow_abbrev=False)
    parser.add_argument('--sequence', required=True, metavar='DIR', help='folder with sequence.yaml: tools and hand-eye calibration')
    parser.add_argument('--image', default='image_raw', metavar='TOPIC')
    parser.add_argument('--camera-info', default='camera_info', metavar='TOPIC')
    parser.add_argument('--time-offset', type=float, default=0., metavar='SECONDS', help='is added to the time of an image to find its joints')
    own = sys.argv[1:sys.argv.index('--ros-args') if '--ros-args' in sys.argv else None]
    args, ros_arguments = parser.parse_args(own), sys.argv[1 + len(own):]
    if rclpy is None:
        print('ros2_node.py: ROS 2 is needed, with rclpy, geometry_msgs, sensor_msgs and std_msgs: %s' % why_no_ros, file=sys.stderr)
        return 1
    try:
        run(args, ros_arguments)
    except cv.error as e:
        print('ros2_node.py: %s' % e.err, file=sys.stderr)
        return 1
    return 0


if __name__ == '__main__':
    sys.exit(main())
