#!/usr/bin/env python3
# This file is part of OpenCV project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution and at http://opencv.org/license.html.
"""Tracks the tools of a recorded sequence: video, joint readings and a rough hand-eye calibration in, tool poses out."""

import argparse
import concurrent.futures
import os
import sys
import time

os.environ.setdefault('OPENCV_FFMPEG_LOGLEVEL', '-8')  # errors are printed once, below
os.environ.setdefault('OPENCV_LOG_LEVEL', 'SILENT')
import numpy as np
import cv2 as cv
from cv2 import surgtrack as st

METHODS = {'full': st.METHOD_FULL, 'paper': st.METHOD_PAPER, 'epnp': st.METHOD_EPNP}


class Failure(Exception):
    """The line the user gets."""


class ArgumentParser(argparse.ArgumentParser):
    def error(self, message):
        raise Failure(message + ', see --help')


def count(text):
    if not text.isdigit():
        raise argparse.ArgumentTypeError("'%s': expected a whole number from 0" % text)
    return int(text)


def time_offset(text):
    if text == 'auto':
        return None
    try:
        value = float(text)
    except ValueError:
        value = float('nan')
    if not abs(value) <= 1e12:
        raise argparse.ArgumentTypeError("'%s': expected a number of seconds or auto" % text)
    return value


def parse_arguments():
    parser = ArgumentParser(description=__doc__, allow_abbrev=False)
    parser.add_argument('--sequence', help='folder of the sequence; without it a synthetic one is made in ./surgtrack_demo and tracked')
    parser.add_argument('--poses', help='CSV file to write the poses to')
    parser.add_argument('--video', help='MP4 file to draw the result into: kinematics in red, estimate in green, matched parts as dots')
    parser.add_argument('--method', default='full',
                        help='full: with joint offsets and outlines; paper: Ye et al. 2016; epnp: their baseline, EPnP on each frame alone')
    parser.add_argument('--stereo', action='store_true', help='use the right image too; method full only')
    parser.add_argument('--start', type=count, default=0, help='first frame')
    parser.add_argument('--frames', type=count, default=0, help='number of frames, 0 = to the end of the video')
    parser.add_argument('--time-offset', type=time_offset, default=0., metavar='SECONDS',
                        help='the joints that belong to the image of time t were recorded at t + SECONDS; auto: found from the sequence')
    parser.add_argument('--render-ahead', action='store_true',
                        help='draw the templates of the next frame in a second thread: faster, the poses differ a little')
    parser.add_argument('--quiet', action='store_true', help='no progress')
    args = parser.parse_args()
    if args.method not in METHODS:
        raise Failure("argument '--method=%s': the methods available are full, paper and epnp" % args.method)
    if args.stereo and args.method != 'full':
        raise Failure("argument '--stereo': method %s uses one image, expected --method=full" % args.method)
    return args


class FrameReader:
    """A video whose frames all have the size the sequence says; decoded in a thread of its own, one frame ahead."""

    def __init__(self, sequence, start, right=False):
        self.filename = sequence.rightVideo() if right else sequence.leftVideo()
        self.size = (sequence.rightCamera() if right else sequence.leftCamera()).imageSize()
        self.capture = cv.VideoCapture(self.filename)
        self.capture.set(cv.CAP_PROP_ORIENTATION_AUTO, 0)       # frames as the camera was calibrated with, not turned
        if not self.capture.isOpened():
            raise Failure('%s: can\'t be read as a video' % self.filename)
        self.count = int(self.capture.get(cv.CAP_PROP_FRAME_COUNT))
        self.next = 0
        while self.next < start and self.capture.grab():  # seeking is not exact in every container
            self.next += 1
        if self.next < start:
            raise Failure('%s: has %d frames, none at --start=%d' % (self.filename, self.next, start))
        self.thread = concurrent.futures.ThreadPoolExecutor(1)
        self.decoded = self.thread.submit(self.capture.read)

    def read(self):
        found, image = self.decoded.result()
        if not found:
            return None
        self.decoded = self.thread.submit(self.capture.read)
        if (image.shape[1], image.shape[0]) != tuple(self.size):
            raise Failure('%s: frame %d has %dx%d pixels, expected %dx%d as in sequence.yaml'
                          % ((self.filename, self.next, image.shape[1], image.shape[0]) + tuple(self.size)))
        self.next += 1
        return image

    def check_end(self, sequence):
        if self.next < sequence.groundTruthEnd():
            raise Failure('%s: ends after %d frames, expected %d as in the ground truth' % (self.filename, self.next, sequence.groundTruthEnd()))
        if self.next + 2 < self.count:      # some containers count what was cut off
            sys.stderr.write('note: %s: has %d frames, its header counts %d\n' % (self.filename, self.next, self.count))


class EyesReader:
    """The frames of one eye, or of both side by side."""

    def __init__(self, sequence, start, stereo):
        self.sequence = sequence
        self.readers = [FrameReader(sequence, start, right) for right in ([False, True] if stereo else [False])]
        self.count = self.readers[0].count

    def read(self):
        """The images; None at the end of the videos, an error if one of them should have gone on."""
        images = [reader.read() for reader in self.readers]
        ended = [reader for reader, image in zip(self.readers, images) if image is None]
        for reader in ended:
            reader.check_end(self.sequence)
        if len(ended) == 1 < len(images):
            other = self.readers[1 - self.readers.index(ended[0])]
            raise Failure('%s: ends after %d frames, expected more, as in %s' % (ended[0].filename, ended[0].next, other.filename))
        return None if ended else images


class Overlay:
    """The overlay video."""

    def __init__(self, filename, fps, size):
        self.filename, self.frames = filename, 0
        for code in ('avc1', 'mp4v'):
            self.writer = cv.VideoWriter(filename, cv.VideoWriter_fourcc(*code), fps, size)
            if self.writer.isOpened():
                return
        raise Failure('%s: can\'t be written as a video, expected a file in a folder that exists, such as overlay.mp4' % filename)

    def write(self, image):
        self.writer.write(image)
        self.frames += 1

    def finish(self):
        self.writer.release()
        if self.frames and cv.VideoCapture(self.filename).get(cv.CAP_PROP_FRAME_COUNT) < self.frames:
            raise Failure('%s: not all of its %d frames were written, is the disk full?' % (self.filename, self.frames))


class Progress:
    """A line on stderr that is written over itself, if stderr is a terminal."""

    def __init__(self, total, quiet):
        self.total, self.enabled = total, not quiet and sys.stderr.isatty()
        self.start = self.last = time.time()

    def show(self, done):
        now = time.time()
        if not self.enabled or (now - self.last < 0.2 and done != self.total):
            return
        self.last = now
        rate = done / max(now - self.start, 1e-9)
        eta = int(max(0, self.total - done) / rate)
        sys.stderr.write('\rframe %d of %d   %.1f frames/s   ETA %d:%02d   ' % (done, self.total, rate, eta // 60, eta % 60))
        sys.stderr.flush()

    def clear(self):
        if self.enabled:
            sys.stderr.write('\r%60s\r' % '')


class Tool:
    def __init__(self, info, model):
        self.info, self.model, self.tracked = info, model, 0


class Run:
    def __init__(self, args):
        folder = args.sequence
        if folder is None:
            folder = 'surgtrack_demo'
            if not args.quiet:
                sys.stderr.write('making a synthetic sequence in %s\n' % folder)
            scene = st.SyntheticScene.Params()
            scene.stereo = args.stereo
            st.SyntheticScene.create(None, scene).write(folder)
        self.sequence = st.Sequence.load(folder)
        if args.stereo and not self.sequence.isStereo():
            raise Failure("argument '--stereo': sequence %s has one camera, expected 'right' and 'right_T_left' in its sequence.yaml" % folder)
        params = st.ToolTracker.Params()
        params.method = METHODS[args.method]
        self.tracker = st.ToolTracker.create(self.sequence.leftCamera(), params)
        if args.stereo:
            self.tracker.setRightCamera(self.sequence.rightCamera(), self.sequence.right_T_left())
        self.tools, models = [], {}
        for i in range(self.sequence.toolCount()):
            info = self.sequence.tool(i)
            if info.model not in models:
                models[info.model] = st.loadTool(info.model)
            self.tracker.addTool(models[info.model], info.nominal_T_base)
            self.tools.append(Tool(info, models[info.model]))
        self.renderer = st.MeshRenderer.createSoftware()    # of the overlay
        self.scorer = None
        if self.sequence.hasGroundTruth():
            self.scorer = st.PoseScorer.create(self.sequence.leftCamera(), [tool.model for tool in self.tools])
        self.timings, self.frames, self.skipped, self.seconds = [], 0, 0, 0.   # skipped: of the frames, those without joint readings
        self.time_offset = self.find_time_offset(args.quiet) if args.time_offset is None else args.time_offset

    def find_time_offset(self, quiet):
        if not quiet:
            sys.stderr.write('looking for the time offset\n')
        known, found = st.estimateTimeOffset(self.sequence)
        if not known:
            raise Failure("argument '--time-offset=auto': the time offset can't be told: %s; give it in seconds" % found.reason)
        if not quiet:
            sys.stderr.write('time offset %.4f s +- %.4f s, confidence %.2f\n' % (found.offset, found.deviation, found.confidence))
        return found.offset

    def reading_time(self, frame):
        """Time of the joint readings that belong to a frame."""
        return self.sequence.frameTime(frame) + self.time_offset

    def render_ahead(self, frame):
        """Unless the records end before that frame."""
        readings = [self.sequence.jointsAt(i, self.reading_time(frame), tool.model.coordinateNames()) for i, tool in enumerate(self.tools)]
        if all(found for found, _ in readings):
            self.tracker.renderAhead([joints for _, joints in readings])

    def joints(self, frame):
        """None if there are none."""
        result, seconds = [], self.reading_time(frame)
        for i, tool in enumerate(self.tools):
            found, joints = self.sequence.jointsAt(i, seconds, tool.model.coordinateNames())
            if not found and self.time_offset == 0 and self.skipped == 0:
                sys.stderr.write("warning: %s: no joint readings of tool '%s' at %.3f s (frame %d), they cover %.3f to %.3f s: such frames are not tracked\n"
                                 % (self.sequence.kinematicsFile(), tool.info.name, seconds, frame, self.sequence.firstTime(i), self.sequence.lastTime(i)))
            if not found:
                return None
            result.append(joints)
        return result

    def update(self, frame, images, joints):
        seconds = self.sequence.frameTime(frame)
        if len(images) > 1:
            estimates = self.tracker.updateStereo(images[0], images[1], seconds, joints)
        else:
            estimates = self.tracker.update(images[0], seconds, joints)
        self.timings.append([stage.last for stage in self.tracker.getTimings()])
        return estimates

    def skip(self, frame, last):
        """A frame without joint readings, at an end of the records: the poses at the nearest reading, not to be relied on."""
        readings, estimates = [], []
        for i, tool in enumerate(self.tools):
            seconds = min(max(self.reading_time(frame), self.sequence.firstTime(i)), self.sequence.lastTime(i))
            joints = self.sequence.jointsAt(i, seconds, tool.model.coordinateNames())[1]
            estimate = st.ToolEstimate()
            estimate.state = st.STATE_INITIALIZING if self.frames == self.skipped else st.STATE_LOST
            if last:
                estimate.camera_T_nominal = last[i].camera_T_nominal
            estimate.jointOffsets = last[i].jointOffsets if last else np.zeros(len(joints))
            estimate.joints = np.array(joints) + estimate.jointOffsets
            nominal_T_tool = np.dot(tool.info.nominal_T_base, tool.model.endEffectorPose(estimate.joints))
            estimate.camera_T_tool = np.dot(estimate.camera_T_nominal, nominal_T_tool)
            readings.append(joints)
            estimates.append(estimate)
        self.skipped += 1
        return readings, estimates

    def record(self, frame, estimates, writer):
        seconds = self.sequence.frameTime(frame)
        for i, (tool, e) in enumerate(zip(self.tools, estimates)):
            tool.tracked += e.state == st.STATE_TRACKING
            if writer is not None:
                writer.write(frame, seconds, tool.info.name, e)
            if self.scorer is not None:
                found, truth, _ = self.sequence.groundTruth(i, frame)
                if found:
                    self.scorer.add(i, e.state, e.camera_T_tool, truth)
        self.frames += 1

    def draw(self, image, joints, estimates):
        camera, nominal, found = self.sequence.leftCamera(), [], []
        for tool, e, readings in zip(self.tools, estimates, joints):
            nominal.append(st.DrawnTool(tool.model, readings, tool.info.nominal_T_base, (0, 0, 255), 0.))
            if e.state in (st.STATE_TRACKING, st.STATE_COASTING):
                found.append(st.DrawnTool(tool.model, e))
        st.drawTools(image, camera, found, self.renderer)
        st.drawTools(image, camera, nominal, self.renderer)
        for i, (tool, e) in enumerate(zip(self.tools, estimates)):
            st.drawEvidence(image, e, tool.info.name, i)

    def print_summary(self):
        size = self.sequence.leftCamera().imageSize()
        print('%s: %d frames of %dx%d' % (self.sequence.name(), self.frames, size[0], size[1]))
        for tool in self.tools:
            print('  %-8s tracked in %.1f %% of the frames' % (tool.info.name, 100. * tool.tracked / self.frames))
        if self.time_offset != 0 or self.skipped > 0:
            print('  time offset %.4f s, %d frames without joint readings' % (self.time_offset, self.skipped))
        print('time a frame [ms]   median      95 %')
        tracked = len(self.timings)
        timings = np.sort(np.array(self.timings or [[0.] * len(self.tracker.getTimings())]), axis=0)
        for i, stage in enumerate(self.tracker.getTimings()):
            print('  %-14s %9.2f %9.2f' % (stage.name, 1e3 * timings[tracked // 2, i], 1e3 * timings[min(max(tracked - 1, 0), int(0.95 * tracked)), i]))
        print('tracker %.1f Hz, whole run %.1f frames/s' % (tracked / max(timings[:, -1].sum(), 1e-9), self.frames / max(self.seconds, 1e-9)))
        if self.scorer is None:
            return
        print('error of the poses  covered     translation [mm]     rotation [rad]   accuracy     silent')
        for i, name in enumerate([tool.info.name for tool in self.tools] + ['overall']):
            s = self.scorer.score(i if i < len(self.tools) else -1)
            print('  %-14s %8.1f %%    %6.2f +- %6.2f    %6.3f +- %5.3f   %6.1f %%   %6.1f %%'
                  % (name, 100. * s.covered / max(s.frames, 1), 1e3 * s.translationMean, 1e3 * s.translationStd, s.rotationMean, s.rotationStd,
                     100 * s.accuracy, 100 * s.silent))


def track(args, run):
    reader = EyesReader(run.sequence, args.start, args.stereo)
    tools = [tool.info.name for tool in run.tools], [tool.model for tool in run.tools]
    writer = st.PoseWriter.create(args.poses, *tools) if args.poses else None
    overlay = Overlay(args.video, run.sequence.fps(), run.sequence.leftCamera().imageSize()) if args.video else None
    remaining = max(0, reader.count - args.start)
    progress = Progress(min(args.frames, remaining) if args.frames else remaining, args.quiet)
    begin, frame, estimates = time.time(), args.start, None
    try:
        while args.frames == 0 or frame < args.start + args.frames:
            images = reader.read()
            if images is None:
                break
            joints = run.joints(frame)
            if joints is None:
                joints, estimates = run.skip(frame, estimates)
            else:
                if args.render_ahead:
                    run.render_ahead(frame + 1)
                estimates = run.update(frame, images, joints)
            run.record(frame, estimates, writer)
            if overlay is not None:
                run.draw(images[0], joints, estimates)
                overlay.write(images[0])
            run.seconds = time.time() - begin
            progress.show(run.frames)
            frame += 1
    finally:
        progress.clear()
        if overlay is not None:
            overlay.finish()
    if run.frames == 0:
        raise Failure('%s: has no frames' % run.sequence.leftVideo())
    if run.skipped == run.frames:
        raise Failure("%s: no joint readings at the time of any frame with a time offset of %g s; those of tool '%s' cover %.3f to %.3f s"
                      % (run.sequence.kinematicsFile(), run.time_offset, run.tools[0].info.name, run.sequence.firstTime(0), run.sequence.lastTime(0)))


def main():
    try:
        args = parse_arguments()
        run = Run(args)
        try:
            track(args, run)
        finally:
            if run.frames > 0:  # what was tracked until an error is written and summed up all the same
                run.print_summary()
                sys.stdout.flush()
        return 0
    except Failure as e:
        message = str(e)
    except cv.error as e:
        message = e.err
    except OSError as e:
        message = str(e)
    sys.stderr.write('track_sequence.py: %s\n' % message.replace('\n', ' '))
    return 1


if __name__ == '__main__':
    sys.exit(main())
