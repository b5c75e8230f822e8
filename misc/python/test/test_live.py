#!/usr/bin/env python3
"""Live tracking over the loopback: example_surgtrack_live and send_joints.py on a synthetic sequence. SURGTRACK_BIN is the folder
of the samples' programs."""

import contextlib
import csv
import importlib.util
import json
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import types
import unittest

import numpy as np
import cv2 as cv

st = cv.surgtrack
SAMPLES = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..', '..', 'samples')
BIN = os.environ.get('SURGTRACK_BIN', '')
LIVE = os.path.join(BIN, 'example_surgtrack_live')
FRAMES = 24
TIMEOUT = 120       # [s]; of a run that takes some seconds


def free_ports(count):
    sockets = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(count)]
    for s in sockets:
        s.bind(('127.0.0.1', 0))
    ports = [s.getsockname()[1] for s in sockets]
    for s in sockets:
        s.close()
    return ports


def read_table(filename):
    with open(filename, newline='') as f:
        return list(csv.DictReader(f))


class Result:
    """A run: its exit code, output, the rows of its poses file and the messages it sent."""

    def numbers(self):
        """images, answered, dropped for a newer one, dropped without joint readings"""
        found = re.search(r'(\d+) images, (\d+) answered, (\d+) dropped for a newer one, (\d+) dropped without joint readings', self.output)
        return [int(n) for n in found.groups()]

    def malformed(self):
        return int(re.search(r'(\d+) malformed', self.output).group(1))


@unittest.skipUnless(os.path.exists(LIVE), 'SURGTRACK_BIN names no folder with example_surgtrack_live')
class LiveTest(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp()
        make = os.path.join(BIN, 'example_surgtrack_make_sequence')
        for name, tools in (('one', 1), ('two', 2)):
            subprocess.check_call([make, '--out=' + os.path.join(cls.folder, name), '--frames=%d' % FRAMES, '--tools=%d' % tools,
                                   '--width=480', '--height=384', '--seed=4', '--stereo', '--quiet'])

    @classmethod
    def tearDownClass(cls):
        shutil.rmtree(cls.folder)

    def sequence(self, name):
        return os.path.join(self.folder, name)      # name may be an absolute path

    @contextlib.contextmanager
    def live(self, *arguments):
        """The program, once it listens."""
        process = subprocess.Popen([LIVE] + list(arguments), stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True)
        try:
            line = process.stderr.readline()
            self.assertEqual(line, 'waiting for joint readings\n', line + process.stderr.read() if line != 'waiting for joint readings\n' else '')
            yield process
        finally:
            if process.poll() is None:
                process.kill()
            process.communicate()

    def send(self, *arguments):
        return subprocess.Popen([sys.executable, os.path.join(SAMPLES, 'send_joints.py')] + list(arguments), stdout=subprocess.PIPE,
                                universal_newlines=True)

    def run_live(self, sequence, live=(), send=(), joints=None, to=None):
        """Tracks a sequence that is played at 8 images a second, a third of its pace: a busy machine keeps up, too."""
        port, back = free_ports(2)
        receiver = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        receiver.bind(('127.0.0.1', back))
        receiver.settimeout(0.2)
        poses = os.path.join(self.folder, 'poses.csv')
        result = Result()
        with self.live('--sequence=' + self.sequence(sequence), '--joints=' + (joints or str(port)), '--poses=' + poses,
                       '--send=127.0.0.1:%d' % back, '--fps=8', *live) as process:
            sender = self.send('--sequence=' + self.sequence(sequence), '--speed=0.32', *(to or ['--to=127.0.0.1:%d' % port]), *send)
            result.messages = []
            end = time.monotonic() + TIMEOUT
            while time.monotonic() < end:
                ended = process.poll() is not None
                try:
                    result.messages.append(json.loads(receiver.recv(65536).decode()))
                except socket.timeout:
                    if ended:
                        break
            result.output, result.errors = process.communicate(timeout=TIMEOUT)
            result.code = process.returncode
            sender.kill()
            sender.communicate()
        receiver.close()
        result.rows = read_table(poses)
        return result

    def check_every_image_is_accounted_for(self, result, tools, frames=FRAMES):
        self.assertEqual(result.code, 0, result.errors)
        images, answered, newer, unread = result.numbers()
        self.assertEqual((images, answered + newer + unread), (frames, frames))
        names = ['PSM%d' % (i + 1) for i in range(tools)]
        self.assertEqual([(int(r['frame']), r['tool']) for r in result.rows], [(f, name) for f in range(frames) for name in names])
        for row in result.rows:
            self.assertIn(row['dropped'], '012')
            self.assertEqual(row['latency'] == '', row['dropped'] != '0', row)
            self.assertFalse(row['dropped'] != '0' and row['status'] == 'tracking', row)
            np.testing.assert_array_equal(np.isfinite([float(row[c]) for c in ('tx', 'ty', 'tz', 'qx', 'qy', 'qz', 'qw')]), True)
        answers = [row for row in result.rows if row['dropped'] == '0']
        self.assertEqual(len(answers), answered * tools)
        self.assertEqual(sum(row['dropped'] == '1' for row in result.rows), newer * tools)
        # What was sent is what was written, for the images that were answered, in their order.
        self.assertEqual([(m['frame'], m['tool'], m['status']) for m in result.messages],
                         [(int(r['frame']), r['tool'], r['status']) for r in answers])
        for message, row in zip(result.messages, answers):
            np.testing.assert_allclose(message['position'], [float(row[c]) for c in ('tx', 'ty', 'tz')], atol=1e-9)   # 9 digits in the file
            self.assertEqual(np.array(message['covariance']).shape, (6, 6))
            self.assertEqual(len(message['joint_offsets']), 7)

    def errors(self, rows, name):
        """{(frame, tool): error [m]} of the rows that are tracked"""
        def place(row):
            return np.array([float(row[c]) for c in ('tx', 'ty', 'tz')])
        truth = {(r['frame'], r['tool']): place(r) for r in read_table(os.path.join(self.sequence(name), 'groundtruth.csv'))}
        return {(r['frame'], r['tool']): np.linalg.norm(truth[r['frame'], r['tool']] - place(r)) for r in rows if r['status'] == 'tracking'}

    def check_poses(self, result, name, tracked):
        """At least so many images are tracked, and their poses are true."""
        errors = self.errors(result.rows, name)
        self.assertGreaterEqual(len(errors), tracked, result.output)
        # 6 mm without tracking; one eye at 480 pixels has some 0.5 mm; joints of another image, one frame off, 2 mm and more.
        self.assertLess(np.mean(list(errors.values())), 0.002)

    def test_images_are_answered(self):
        result = self.run_live('one')
        self.check_every_image_is_accounted_for(result, 1)
        self.check_poses(result, 'one', FRAMES // 2)
        self.assertEqual(result.malformed(), 0)

    @unittest.skipUnless(os.environ.get('SURGTRACK_DATA'), 'SURGTRACK_DATA is not set')
    def test_recorded_data_are_tracked_as_well_as_offline(self):
        sequence = os.path.join(os.environ['SURGTRACK_DATA'], 'sequences', 'paper_rig')
        result = self.run_live(sequence, live=['--fps=12.5', '--frames=120'], send=['--speed=0.5'])
        self.check_every_image_is_accounted_for(result, 2, 120)
        offline = os.path.join(self.folder, 'offline.csv')
        subprocess.check_call([os.path.join(BIN, 'example_surgtrack_track_sequence'), '--sequence=' + sequence, '--frames=120',
                               '--poses=' + offline, '--quiet'], stdout=subprocess.DEVNULL)
        live, recorded = self.errors(result.rows, sequence), self.errors(read_table(offline), sequence)
        both = set(live) & set(recorded)
        self.assertGreater(len(both), 120)      # of 240
        # 20 %: what drawing ahead and some images that were dropped may cost.
        self.assertLess(np.mean([live[k] for k in both]), 1.2 * np.mean([recorded[k] for k in both]))

    def test_both_eyes(self):
        result = self.run_live('one', live=['--stereo', '--frames=12'])
        self.check_every_image_is_accounted_for(result, 1, 12)
        self.check_poses(result, 'one', 6)

    def test_messages_of_the_dvrk_two_tools_on_ports_of_their_own(self):
        a, b = free_ports(2)
        result = self.run_live('two', joints='PSM1:%d,PSM2:%d' % (a, b), send=['--format=dvrk'],
                               to=['--to=PSM1=127.0.0.1:%d' % a, '--to=PSM2=127.0.0.1:%d' % b])
        self.check_every_image_is_accounted_for(result, 2)
        self.check_poses(result, 'two', FRAMES // 2)
        self.assertEqual(result.malformed(), 0)

    def test_lost_late_reordered_and_malformed_messages(self):
        result = self.run_live('one', send=['--loss=0.2', '--reorder=0.2', '--malformed=0.3', '--delay=0.03', '--seed=5'])
        self.check_every_image_is_accounted_for(result, 1)
        # At 0.32 of the pace readings are 31 ms apart: those that are lost in a row, or held back, come after the 50 ms an image
        # waits, or leave a gap. The others are as good as ever.
        self.check_poses(result, 'one', FRAMES // 4)
        self.assertGreater(result.malformed(), 10)
        self.assertIn('the first one: ', result.output)

    def test_hostile_messages_stop_nothing(self):
        """Before the readings, and among them: wild positions, stamps of other clocks, a flood."""
        port, = free_ports(1)
        poses = os.path.join(self.folder, 'hostile.csv')
        back, = free_ports(1)
        with self.live('--sequence=' + self.sequence('one'), '--joints=%d' % port, '--fps=8', '--poses=' + poses, '--send=127.0.0.1:%d' % back) as process:
            link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)

            def attack():
                for stamp in (-86400, -1e15, -1e300, 1e15, 1e11, 0.05):
                    for insertion in (1e200, -1e308, 1e308) if stamp == 0.05 else (9.9, 1e200):
                        link.sendto(json.dumps({'tool': 'PSM1', 'time': stamp, 'position': [0, 0, insertion, 0, 0, 0, 0.1]}).encode(), ('127.0.0.1', port))
                for data in (b'[' * 60000, b'{"a":' * 10000, b'\x00' * 60000, b'{"tool": "\\u001b[2J", "time": 0, "position": [0]}', b'', b'{"measured_js": null}'):
                    link.sendto(data, ('127.0.0.1', port))
            attack()
            sender = self.send('--sequence=' + self.sequence('one'), '--to=127.0.0.1:%d' % port, '--speed=0.32')
            end = time.monotonic() + TIMEOUT
            flooded = 0
            while process.poll() is None and time.monotonic() < end:
                attack()
                for _ in range(200 if flooded < 4000 else 0):     # bounded: some 8 MB in all
                    link.sendto(b'{"tool": "PSM1"' + b' ' * 2000, ('127.0.0.1', port))
                    flooded += 1
                time.sleep(0.1)
            result = Result()
            result.output, result.errors = process.communicate(timeout=TIMEOUT)
            sender.kill()
            sender.communicate()
            link.close()
        self.assertEqual(process.returncode, 0, result.errors)
        self.assertNotIn('\x1b', result.output + result.errors)
        result.rows, result.messages = read_table(poses), []
        images, answered, newer, unread = result.numbers()
        self.assertEqual((images, answered + newer + unread), (FRAMES, FRAMES))
        self.assertGreater(answered, FRAMES // 4, result.output)      # a busy machine drops some of them without an attack, too
        self.assertGreater(result.malformed(), 10)
        self.assertGreater(int(re.search(r'(\d+) with stamps of another clock', result.output).group(1)), 3, result.output)
        for row in result.rows:
            np.testing.assert_array_equal(np.isfinite([float(row[c]) for c in ('tx', 'ty', 'tz', 'qx', 'qy', 'qz', 'qw')]), True)

    def test_it_listens_to_whom_it_is_told(self):
        port, = free_ports(1)
        for options, heard in (([], True), (['--from=127.0.0.1'], True), (['--from=127.0.0.2'], False), (['--listen=127.0.0.2'], False),
                               (['--listen=0.0.0.0', '--from=127.0.0.1'], True)):
            with self.live('--sequence=' + self.sequence('two'), '--joints=%d' % port, *options) as process:
                link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
                for _ in range(5):
                    link.sendto(b'hello', ('127.0.0.1', port))
                link.close()
                _, errors = process.communicate(timeout=TIMEOUT)
            self.assertEqual(process.returncode, 1)
            self.assertIn('%d malformed' % (5 if heard else 0), errors, options)
        for option in ('--listen=nowhere', '--from=1.2.3'):
            self.assertIn(option, self.refused('--sequence=' + self.sequence('one'), '--joints=%d' % port, option))
        self.assertIn('8.8.8.8', self.refused('--sequence=' + self.sequence('one'), '--joints=%d' % port, '--listen=8.8.8.8'))

    def test_a_robot_whose_clock_is_far_behind_the_video_is_told_of(self):
        port, = free_ports(1)
        with self.live('--sequence=' + self.sequence('one'), '--joints=%d' % port) as process:
            link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            for k in range(20):
                message = {'tool': 'PSM1', 'time': -86400 + 0.01 * k, 'position': [0, 0, 0.1, 0, 0, 0, 0.1]}
                link.sendto(json.dumps(message).encode(), ('127.0.0.1', port))
                time.sleep(0.01)
            link.close()
            _, errors = process.communicate(timeout=TIMEOUT)
        self.assertEqual(process.returncode, 1)
        self.assertIn('before the first image', errors)

    def test_readings_that_fall_behind_drop_images_and_say_so(self):
        result = self.run_live('one', send=['--speed=0.1'])
        self.check_every_image_is_accounted_for(result, 1)
        _, _, _, unread = result.numbers()
        self.assertGreater(unread, FRAMES // 2)        # after 0.2 s they are 0.1 s behind
        self.assertIn('no joint readings at the time of the images', result.errors)
        self.assertEqual([r['status'] for r in result.rows if r['dropped'] == '2' and r['status'] not in ('initializing', 'lost', 'coasting')], [])

    def test_a_stream_that_keeps_no_pace_is_never_queued(self):
        port, = free_ports(1)
        poses = os.path.join(self.folder, 'stream.csv')
        with self.live('--sequence=' + self.sequence('one'), '--joints=%d' % port, '--camera=' + os.path.join(self.sequence('one'), 'left.mp4'),
                       '--poses=' + poses) as process:
            sender = self.send('--sequence=' + self.sequence('one'), '--to=127.0.0.1:%d' % port)
            result = Result()
            result.output, result.errors = process.communicate(timeout=TIMEOUT)
            sender.communicate(timeout=TIMEOUT)
        self.assertEqual(process.returncode, 0, result.errors)
        images, answered, newer, unread = result.numbers()
        self.assertEqual((images, answered + newer + unread), (FRAMES, FRAMES))
        self.assertEqual([int(r['frame']) for r in read_table(poses)], list(range(FRAMES)))

    def test_interrupted_it_ends_with_its_summary(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            port, = free_ports(1)
            poses = os.path.join(self.folder, 'interrupted.csv')
            with self.live('--sequence=' + self.sequence('one'), '--joints=%d' % port, '--fps=2', '--poses=' + poses) as process:
                sender = self.send('--sequence=' + self.sequence('one'), '--to=127.0.0.1:%d' % port, '--speed=0.08')
                end = time.monotonic() + TIMEOUT
                while time.monotonic() < end and (not os.path.exists(poses) or len(read_table(poses)) < 2):
                    time.sleep(0.05)
                process.send_signal(number)
                result = Result()
                result.output, result.errors = process.communicate(timeout=TIMEOUT)
                sender.kill()
                sender.communicate()
            self.assertEqual(process.returncode, 0, result.errors)
            self.assertLess(result.numbers()[0], FRAMES)
            self.assertEqual(len(read_table(poses)), result.numbers()[0])

    def refused(self, *arguments):
        process = subprocess.run([LIVE] + list(arguments), stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True, timeout=TIMEOUT)
        self.assertEqual(process.returncode, 1, arguments)
        lines = [line for line in process.stderr.splitlines() if line != 'waiting for joint readings']
        self.assertEqual(len(lines), 1, process.stderr)
        return lines[0]

    def test_wrong_calls_are_refused_in_one_line(self):
        sequence = '--sequence=' + self.sequence('one')
        port, = free_ports(1)
        self.assertIn('--sequence', self.refused())
        self.assertIn('none', self.refused('--sequence=' + self.sequence('none')))
        for ports in ('0', '65536', '4805x', 'PSM1:', '48051,'):
            self.assertIn('--joints=' + ports, self.refused(sequence, '--joints=' + ports))
        self.assertIn("tool 'PSM9'", self.refused(sequence, '--joints=PSM9:%d' % port))
        self.assertIn("'nowhere'", self.refused(sequence, '--joints=%d' % port, '--send=nowhere'))
        self.assertIn('--camera=0,1', self.refused(sequence, '--camera=0,1'))
        self.assertIn('no-such.mp4', self.refused(sequence, '--joints=%d' % port, '--camera=no-such.mp4'))
        taken = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        taken.bind(('127.0.0.1', port))
        self.assertIn('UDP port %d' % port, self.refused(sequence, '--joints=%d' % port))
        taken.close()

    def test_without_readings_it_ends_and_tells_what_came(self):
        port, = free_ports(1)
        with self.live('--sequence=' + self.sequence('two'), '--joints=%d' % port) as process:
            link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            link.sendto(b'hello', ('127.0.0.1', port))
            link.sendto(b'{"measured_cp": {}}', ('127.0.0.1', port))
            link.sendto(b'{"tool": "PSM2", "time": 0, "position": [0, 0, 0.1, 0, 0, 0, 0.1]}', ('127.0.0.1', port))
            link.close()
            _, errors = process.communicate(timeout=TIMEOUT)
        self.assertEqual(process.returncode, 1)
        self.assertEqual(len(errors.splitlines()), 1, errors)
        for what in ("tool 'PSM1'", '1 messages with readings', '1 without', '1 malformed', "'hello'"):
            self.assertIn(what, errors)


def load_sample(name):
    spec = importlib.util.spec_from_file_location(name, os.path.join(SAMPLES, name + '.py'))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class SendJointsTest(unittest.TestCase):

    def schedule(self, **options):
        args = types.SimpleNamespace(format='plain', speed=1., places=[(None, ('127.0.0.1', 1))], loss=0., delay=0., reorder=0., malformed=0., seed=1)
        vars(args).update(options)
        readings = [(0.01 * i, 'PSM1', {'q1': 0.5 * i, 'jaw': 0.25}) for i in range(500)]
        return load_sample('send_joints').schedule(readings, args)

    def test_faults_are_what_was_asked_for_and_the_same_for_a_seed(self):
        packets, counts = self.schedule()
        self.assertEqual([json.loads(p[2].decode())['time'] for p in packets], [0.01 * i for i in range(500)])
        packets, counts = self.schedule(loss=0.2, reorder=0.1, malformed=0.1, delay=0.5, seed=3)
        # Of 500: within four standard deviations.
        self.assertAlmostEqual(counts['lost'], 100, delta=36)
        self.assertAlmostEqual(counts['reordered'], 40, delta=24)
        self.assertAlmostEqual(counts['malformed'], 50, delta=27)
        self.assertGreaterEqual(packets[0][0], 0.5)
        self.assertEqual(packets, self.schedule(loss=0.2, reorder=0.1, malformed=0.1, delay=0.5, seed=3)[0])
        self.assertNotEqual(packets, self.schedule(loss=0.2, reorder=0.1, malformed=0.1, delay=0.5, seed=4)[0])
        times = []
        for _, _, data in packets:
            with contextlib.suppress(ValueError, KeyError, TypeError, RecursionError):
                stamp = json.loads(data.decode())['time']
                if isinstance(stamp, float):
                    times.append(stamp)
        self.assertGreater(sum(b < a for a, b in zip(times, times[1:])), 10)      # some are out of order

    def test_messages_are_understood(self):
        send = load_sample('send_joints')
        reading = (1.5, 'PSM1', dict(q1=.1, q2=.2, q3=.3, q4=.4, q5=.5, q6=.6, jaw=.7))
        for style in ('plain', 'dvrk'):
            buffer = st.JointBuffer.create(['q1', 'q2', 'q3', 'q4', 'q5', 'q6', 'jaw'])
            for text in send.messages(reading, style):
                for r in st.parseJointMessage(text):
                    self.assertEqual((r.tool, r.time), ('PSM1' if style == 'plain' else '', 1.5))
                    self.assertTrue(buffer.add(r))
            state, joints = buffer.at(1.5)
            self.assertEqual(state, st.JOINTS_FOUND)
            np.testing.assert_array_equal(joints, list(reading[2].values()))


if __name__ == '__main__':
    unittest.main()
