#!/usr/bin/env python3
"""samples/ros2_node.py without ROS: its conversions, and tracking from messages."""

import importlib.util
import json
import os
import shutil
import subprocess
import sys
import tempfile
import types
import unittest

import numpy as np
import cv2 as cv

st = cv.surgtrack
SAMPLES = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..', '..', 'samples')


def load_sample(name):
    spec = importlib.util.spec_from_file_location(name, os.path.join(SAMPLES, name + '.py'))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def message(**fields):
    return types.SimpleNamespace(**fields)


def header(time, frame='endoscope'):
    return message(stamp=message(sec=int(time), nanosec=int(round(1e9 * (time - int(time))))), frame_id=frame)


def image_message(pixels, encoding, padding=0, time=0.):
    rows = pixels.reshape(pixels.shape[0], -1)
    data = np.hstack([rows, np.full((rows.shape[0], padding), 99, np.uint8)])
    return message(header=header(time), height=pixels.shape[0], width=pixels.shape[1], encoding=encoding, step=data.shape[1], data=data.tobytes())


class RosNodeTest(unittest.TestCase):

    def setUp(self):
        self.ros = load_sample('ros2_node')

    def test_images(self):
        bgr = np.random.RandomState(1).randint(0, 256, (6, 8, 3), np.uint8)
        read = self.ros.image_from_message
        for padding in (0, 5):
            np.testing.assert_array_equal(read(image_message(bgr, 'bgr8', padding)), bgr)
            np.testing.assert_array_equal(read(image_message(bgr[:, :, ::-1].copy(), 'rgb8', padding)), bgr)
            alpha = np.dstack([bgr, np.zeros((6, 8), np.uint8)])
            np.testing.assert_array_equal(read(image_message(alpha, 'bgra8', padding)), bgr)
            np.testing.assert_array_equal(read(image_message(bgr[:, :, 0].copy(), 'mono8', padding)), bgr[:, :, 0])
        for pattern in ('rggb', 'bggr', 'gbrg', 'grbg'):      # an even colour, as its sensor has it: blue 10, green 20, red 30
            value = dict(b=10, g=20, r=30)
            mosaic = np.tile(np.array([[value[pattern[0]], value[pattern[1]]], [value[pattern[2]], value[pattern[3]]]], np.uint8), (4, 4))
            np.testing.assert_array_equal(read(image_message(mosaic, 'bayer_%s8' % pattern)).reshape(-1, 3), [[10, 20, 30]] * 64)
        with self.assertRaisesRegex(ValueError, "encoding '16UC1', expected one of"):
            read(image_message(bgr, '16UC1'))
        short = image_message(bgr, 'bgr8')
        short.data = short.data[:-1]
        with self.assertRaisesRegex(ValueError, 'expected 8x6 pixels of 3 bytes'):
            read(short)

    def camera_info(self, **fields):
        info = message(width=720, height=576, distortion_model='plumb_bob', d=[-0.2, 0.1, 0.001, 0.002, 0.], k=[800., 0, 360, 0, 810, 288, 0, 0, 1],
                       binning_x=0, binning_y=1)
        vars(info).update(fields)
        return info

    def test_cameras(self):
        read = self.ros.camera_from_message
        camera = read(self.camera_info())
        np.testing.assert_array_equal(camera.cameraMatrix(), [[800, 0, 360], [0, 810, 288], [0, 0, 1]])
        np.testing.assert_array_equal(camera.distCoeffs().ravel()[:5], [-0.2, 0.1, 0.001, 0.002, 0])
        self.assertEqual(tuple(camera.imageSize()), (720, 576))
        self.assertFalse(read(self.camera_info(distortion_model='', d=[])).hasDistortion())
        for fields, what in ((dict(k=[0.] * 9), 'calibrated'), (dict(distortion_model='equidistant'), "'equidistant'"),
                             (dict(d=[0.1] * 6), '6 numbers, expected 4, 5'), (dict(d=[0.1] * 8), 'zeros behind the first 5'), (dict(binning_x=2), 'binning')):
            with self.assertRaisesRegex(ValueError, what):
                read(self.camera_info(**fields))

    def test_cameras_of_other_drivers(self):
        read = self.ros.camera_from_message
        self.assertEqual(read(self.camera_info(d=[-0.2, 0.1, 0.001, 0.002])).distCoeffs().ravel()[4], 0)
        rational = read(self.camera_info(distortion_model='rational_polynomial', d=[0.01 * i for i in range(8)] + [0.] * 6))
        self.assertEqual(rational.distCoeffs().ravel()[7], 0.07)
        roi = read(self.camera_info(roi=message(x_offset=60, y_offset=38, width=500, height=400)))
        self.assertEqual((tuple(roi.imageSize()), roi.cameraMatrix()[0, 2], roi.cameraMatrix()[1, 2]), ((500, 400), 300, 250))

    def test_covariance_is_in_the_order_of_ros(self):
        # Of a deviation (rotation, translation), twice: ours and ROS's are the covariance of the same one.
        rotation, translation = np.array([1., 2, 3]), np.array([10., 20, 30])
        ours, theirs = np.hstack([rotation, translation]), np.hstack([translation, rotation])
        np.testing.assert_array_equal(np.reshape(self.ros.ros_covariance(np.outer(ours, ours)), (6, 6)), np.outer(theirs, theirs))

    def test_quaternions_are_those_of_the_rotation(self):
        rng = np.random.RandomState(2)
        vectors = [np.zeros(3), [np.pi, 0, 0], [0, np.pi, 0], [0, 0, np.pi - 1e-9]] + list(rng.uniform(-2, 2, (50, 3)))
        for v in vectors:
            v = np.array(v, np.float64)
            q = np.array(self.ros.quaternion(cv.Rodrigues(v)[0]))
            angle = np.linalg.norm(v)
            expected = np.append(v / max(angle, 1e-300) * np.sin(angle / 2), np.cos(angle / 2))
            self.assertAlmostEqual(abs(q.dot(expected)), 1, delta=1e-12)      # rounding; q and -q are one rotation
            self.assertGreaterEqual(q[3], 0)

    def test_a_pose_message_is_filled(self):
        T = np.eye(4)
        T[:3, 3] = [0.01, 0.02, 0.1]
        pose = message(header=message(), pose=message(pose=message(position=message(), orientation=message()), covariance=None))
        self.ros.fill_pose(pose, header(2.5), message(camera_T_tool=T, covariance=np.diag([1., 2, 3, 4, 5, 6])))
        self.assertEqual((pose.header.frame_id, pose.header.stamp.sec, pose.header.stamp.nanosec), ('endoscope', 2, 500000000))
        p, q = pose.pose.pose.position, pose.pose.pose.orientation
        self.assertEqual((p.x, p.y, p.z, q.x, q.y, q.z, q.w), (0.01, 0.02, 0.1, 0, 0, 0, 1))
        self.assertEqual(np.diag(np.reshape(pose.pose.covariance, (6, 6))).tolist(), [4, 5, 6, 1, 2, 3])

    def test_the_node_tracks_a_sequence(self):
        folder = tempfile.mkdtemp()
        try:
            params = st.SyntheticScene.Params()
            params.imageSize, params.frames = (480, 384), 12
            st.SyntheticScene.create(None, params).write(folder)
            sequence = st.Sequence.load(folder)
            camera = sequence.leftCamera()
            name = sequence.tool(0).name
            published, warnings = [], []
            node = self.ros.ToolNode(st.Sequence.load(folder, False), 0., lambda *a: published.append(a), warnings.append)
            node.take_camera_info(self.camera_info(k=[0.] * 9))
            self.assertEqual(len(warnings), 1)
            info = self.camera_info(width=480, height=384, k=camera.cameraMatrix().ravel().tolist(), distortion_model='', d=[])
            node.take_camera_info(info)
            video = cv.VideoCapture(sequence.leftVideo())
            names = list(sequence.jointNames())
            for frame in range(12):
                found, image = video.read()
                time_ = frame / sequence.fps()
                node.take_image(image_message(image, 'bgr8', time=time_))
                self.assertEqual(node.frames, frame)               # its joints are still to come
                for t in (time_, time_ + 0.01):
                    known, joints = sequence.jointsAt(0, t)
                    values = dict(zip(names, joints))
                    arm = message(header=header(t), name=['yaw', 'pitch', 'insertion', 'roll', 'wrist_pitch', 'wrist_yaw'],
                                  position=[values['q%d' % i] for i in range(1, 7)])
                    node.take_joints(name, arm)
                    node.take_joints(name, message(header=header(t), name=['outer_jaw'], position=[values['jaw']]), True)
                self.assertEqual(node.frames, frame + 1)
            self.assertEqual((len(published), node.dropped, len(warnings)), (12, 0, 1))
            tool, head, estimate, text = published[-1]
            self.assertEqual((tool, head.frame_id, json.loads(text)['frame'], json.loads(text)['status']), (name, 'endoscope', 11, 'tracking'))
            known, truth, _ = sequence.groundTruth(0, 11)
            self.assertLess(np.linalg.norm(estimate.camera_T_tool[:3, 3] - truth[:3, 3]), 0.003)   # the calibration is 6 mm off, one eye 1 mm in depth
            node.take_joints(name, message(header=header(9.), name=[], position=[1.]))
            self.assertEqual(len(warnings), 2)
            node.take_image(image_message(image, 'bgr8', time=5.))
            node.take_image(image_message(image, 'bgr8', time=5.04))    # a newer one takes the place of one that waits
            self.assertEqual(node.dropped, 1)
        finally:
            shutil.rmtree(folder)

    def test_without_ros_it_says_so(self):
        if self.ros.rclpy is not None:
            self.skipTest('ROS 2 is here')
        process = subprocess.run([sys.executable, os.path.join(SAMPLES, 'ros2_node.py'), '--sequence=none'], stdout=subprocess.PIPE,
                                 stderr=subprocess.PIPE, universal_newlines=True)
        self.assertEqual((process.returncode, len(process.stderr.splitlines())), (1, 1))
        self.assertIn('ROS 2 is needed', process.stderr)


if __name__ == '__main__':
    unittest.main()
