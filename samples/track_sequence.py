#!/usr/bin/env python3
# This file is part of OpenCV project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution and at http://opencv.org/license.html.
"""Tracks the tools of a recorded sequence: video, joint readings and a rough hand-eye calibration in, tool poses out.

Exit code 2: nothing was tracked."""

import argparse
import copy
import difflib
import glob
import os
import re
import signal
import sys
import time

os.environ.setdefault('OPENCV_FFMPEG_LOGLEVEL', '-8')  # errors are printed once, below
os.environ.setdefault('OPENCV_LOG_LEVEL', 'SILENT')
import numpy as np
import cv2 as cv
from cv2 import surgtrack as st
from track_support import EyesReader, Failure, Overlay, Progress

METHODS = {'full': st.METHOD_FULL, 'paper': st.METHOD_PAPER, 'epnp': st.METHOD_EPNP}


class ArgumentParser(argparse.ArgumentParser):
    def error(self, message):
        unknown = re.match(r'unrecognized arguments: (--[^ =]+)', message)
        near = difflib.get_close_matches(unknown.group(1), self._option_string_actions, 1) if unknown else []
        raise Failure("%s%s see --help" % (message, ", did you mean '%s'?" % near[0] if near else ','))


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
    parser.add_argument('--sequence', help='folder of the sequence, or one that is searched for such; without it a synthetic one is made in ./surgtrack_demo')
    parser.add_argument('--poses', help='CSV file to write the poses to. Of several sequences: FILE_SEQUENCE.csv, and so for --video')
    parser.add_argument('--video', help='MP4 file to draw the result into: kinematics in red, estimate in green, matched parts as dots')
    parser.add_argument('--method',
                        help='full (default): with joint offsets and outlines; paper: Ye et al. 2016; epnp: their baseline, EPnP on each frame alone')
    parser.add_argument('--stereo', action='store_true', help='use the right image too; method full only')
    parser.add_argument('--start', type=count, default=0, help='first frame')
    parser.add_argument('--frames', type=count, default=0, help='number of frames, 0 = to the end of the video')
    parser.add_argument('--time-offset', type=time_offset, default=0., metavar='SECONDS',
                        help='the joints that belong to the image of time t were recorded at t + SECONDS; auto: found from the sequence, of each tool')
    parser.add_argument('--render-ahead', action='store_true',
                        help='draw the templates of the next frame in a second thread: faster, the poses differ a little')
    parser.add_argument('--tool-state',
                        help="file with what was learnt of the joints' errors: read if it is there, written in the end, one for all sequences: play is the same tomorrow")
    parser.add_argument('--config', help='file with parameters of the tracker, as track_sequence --write-config writes it')
    parser.add_argument('--set', action='append', default=[], metavar='NAME=VALUE', help='a parameter, as matcher.minSimilarity=0.5; comes after --config')
    parser.add_argument('--check', action='store_true',
                        help='only look for mistakes of the setup: units, calibrations, clocks, arms, instruments; exit code 1 if there are any')
    parser.add_argument('--quiet', action='store_true', help='print warnings and errors only')
    parser.add_argument('--version', action='version', version='track_sequence.py, cv::surgtrack on OpenCV ' + cv.__version__)
    args = parser.parse_args()
    args.params, args.stages = st.ToolTracker.Params(), st.ToolTracker.Stages()
    if args.config:
        args.params, args.stages = st.readTrackerParams(args.config, args.params, args.stages)
    for setting in args.set:
        name, equals, value = setting.partition('=')
        if not equals:
            raise Failure("argument '--set': expected NAME=VALUE, found '%s'" % setting)
        args.params, args.stages = st.setTrackerParam(name, value, args.params, args.stages)
    if args.method is not None and args.method not in METHODS:
        raise Failure("argument '--method=%s': the methods available are full, paper and epnp" % args.method)
    if args.method is not None:
        args.params.method = METHODS[args.method]
    if args.stereo and args.params.method != st.METHOD_FULL:
        method = [name for name, value in METHODS.items() if value == args.params.method][0]
        raise Failure("argument '--stereo': method %s uses one image, expected --method=full" % method)
    if args.tool_state and args.params.method != st.METHOD_FULL:
        raise Failure("argument '--tool-state': only --method=full learns what is wrong with readings")
    return args


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
            scene.cables = 1.
            st.SyntheticScene.create(None, scene).write(folder)
        self.sequence = st.Sequence.load(folder)
        if args.stereo and not self.sequence.isStereo():
            raise Failure("argument '--stereo': sequence %s has one camera, expected 'right' and 'right_T_left' in its sequence.yaml" % folder)
        self.tracker = st.ToolTracker.create(self.sequence.leftCamera(), args.params, args.stages)
        if args.stereo:
            self.tracker.setRightCamera(self.sequence.rightCamera(), self.sequence.right_T_left())
        for eye in range(2 if args.stereo else 1):
            mask = self.sequence.mask(eye)
            if mask is not None:
                self.tracker.setMask(mask, eye)
        self.tools, models = [], {}
        for i in range(self.sequence.toolCount()):
            info = self.sequence.tool(i)
            if info.model not in models:
                models[info.model] = st.loadTool(info.model)
            self.tracker.addTool(models[info.model], info.nominal_T_base)
            self.tools.append(Tool(info, models[info.model]))
        if args.tool_state and os.path.isfile(args.tool_state):
            for i, tool in enumerate(self.tools):
                errors = st.readToolState(args.tool_state, tool.info.name)
                try:
                    self.tracker.setReadingErrors(i, errors)
                except cv.error as e:
                    raise Failure("%s: tool '%s': %s" % (args.tool_state, tool.info.name, e.err))
        self.renderer = st.MeshRenderer.createSoftware()    # of the overlay
        self.scorer = None
        if self.sequence.hasGroundTruth():
            self.scorer = st.PoseScorer.create(self.sequence.leftCamera(), [tool.model for tool in self.tools])
        self.timings, self.frames, self.skipped, self.seconds = [], 0, 0, 0.   # skipped: of the frames, those without joint readings
        self.time_offsets = [args.time_offset or 0.] * len(self.tools)      # beside those of the sequence
        self.interrupted = False

    def find_time_offsets(self, quiet):
        """Arms have clocks of their own: of each tool, or, where that can't be told, that of one where it can."""
        if not quiet:
            sys.stderr.write('looking for the time offset%s\n' % (' of each tool' if len(self.tools) > 1 else ''))
        params, answers = st.TimeOffsetParams(), []
        for params.tool, tool in enumerate(self.tools):
            known, found = st.estimateTimeOffset(self.sequence, params)
            answers.append((known, found))
            if known and not quiet:
                sys.stderr.write('%s: time offset %.4f s +- %.4f s, confidence %.2f\n' % (tool.info.name, found.offset, found.deviation, found.confidence))
        best = max(range(len(answers)), key=lambda i: (answers[i][0], answers[i][1].support))
        if not answers[best][0]:
            raise Failure("argument '--time-offset=auto': the time offset can't be told: %s; give it in seconds" % answers[0][1].reason)
        for i, (known, found) in enumerate(answers):
            self.time_offsets[i] = (found if known else answers[best][1]).offset
            if not known:
                sys.stderr.write("warning: the time offset of tool '%s' can't be told (%s): that of '%s' is taken\n"
                                 % (self.tools[i].info.name, found.reason, self.tools[best].info.name))

    def check(self, stereo, quiet):
        """The findings, printed."""
        findings, figures = st.checkSetup(self.sequence, stereo)
        for line in () if quiet else figures:
            print(line)
        for line in findings:
            sys.stderr.write('check: %s\n' % line)
        return findings

    def reading_time(self, tool, frame, field=0):
        """Time of the joint readings of a tool that belong to a frame."""
        return self.sequence.frameTime(frame, field) + self.time_offsets[tool]

    def render_ahead(self, frame, field):
        """What comes after this image; unless the records end before."""
        frame, field = (frame, field + 1) if field + 1 < self.sequence.imagesPerFrame() else (frame + 1, 0)
        readings = [self.sequence.jointsAt(i, self.reading_time(i, frame, field), tool.model.coordinateNames()) for i, tool in enumerate(self.tools)]
        if all(found for found, _ in readings):
            self.tracker.renderAhead([joints for _, joints in readings])

    def joints(self, frame):
        """None if there are none."""
        result = []
        for i, tool in enumerate(self.tools):
            seconds = self.reading_time(i, frame)
            found, joints = self.sequence.jointsAt(i, seconds, tool.model.coordinateNames())
            if not found and self.time_offsets[i] == 0 and self.skipped == 0:
                sys.stderr.write("warning: %s: no joint readings of tool '%s' at %.3f s (frame %d), they cover %.3f to %.3f s: such frames are not tracked\n"
                                 % (self.sequence.kinematicsFile(), tool.info.name, seconds, frame, self.sequence.firstTime(i), self.sequence.lastTime(i)))
            if not found:
                return None
            result.append(joints)
        return result

    def track_second(self, frame, images, ahead):
        """The second field of a frame; its poses are those of the first."""
        readings = [self.sequence.jointsAt(i, self.reading_time(i, frame, 1), tool.model.coordinateNames()) for i, tool in enumerate(self.tools)]
        if all(found for found, _ in readings):
            if ahead:
                self.render_ahead(frame, 1)
            self.update(frame, images, [joints for _, joints in readings], 1)

    def update(self, frame, images, joints, field=0):
        seconds = self.sequence.frameTime(frame, field)
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
            seconds = min(max(self.reading_time(i, frame), self.sequence.firstTime(i)), self.sequence.lastTime(i))
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

    def nothing_tracked(self):
        return not any(tool.tracked for tool in self.tools)

    def print_summary(self):
        """Where nothing was tracked, no more than that: what may be the cause comes next."""
        size = self.sequence.leftCamera().imageSize()
        print('%s: %d frames of %dx%d' % (self.sequence.name(), self.frames, size[0], size[1]))
        for tool in self.tools:
            print('  %-8s tracked in %.1f %% of the frames' % (tool.info.name, 100. * tool.tracked / self.frames))
        for tool, offset in zip(self.tools, self.time_offsets):
            if offset != 0:
                print('  %-8s time offset %.4f s; time_offset: %.4f of this tool in sequence.yaml keeps it'
                      % (tool.info.name, offset, tool.info.timeOffset + offset))
        if self.skipped > 0:
            print('  %d frames without joint readings' % self.skipped)
        if self.nothing_tracked():
            return
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

    def interrupt(number, _):
        run.interrupted = True      # after this frame; the second Ctrl-C ends the program
        signal.signal(number, signal.SIG_DFL)
    signal.signal(signal.SIGINT, interrupt)
    signal.signal(signal.SIGTERM, interrupt)
    try:
        while not run.interrupted and (args.frames == 0 or frame < args.start + args.frames):
            if not reader.read():
                break
            images = reader.images()
            reader.note_fields(images[0])
            joints = run.joints(frame)
            found = joints is not None
            if not found:
                joints, estimates = run.skip(frame, estimates)
            else:
                if args.render_ahead:
                    run.render_ahead(frame, 0)
                estimates = run.update(frame, images, joints)
            run.record(frame, estimates, writer)
            if overlay is not None:
                run.draw(images[0], joints, estimates)
                overlay.write(images[0])
            if found and run.sequence.imagesPerFrame() > 1:
                run.track_second(frame, reader.images(1), args.render_ahead)
            run.seconds = time.time() - begin
            progress.show(run.frames)
            frame += 1
    finally:
        progress.clear()
        if overlay is not None:
            overlay.finish()
    if args.tool_state and run.frames > run.skipped:
        tools = range(len(run.tools))
        st.writeToolState(args.tool_state, [run.tools[i].info.name for i in tools], [run.tracker.readingErrors(i) for i in tools])
    if run.interrupted:
        return
    if run.frames == 0:
        raise Failure('%s: has no frames' % run.sequence.leftVideo())
    if run.skipped == run.frames:
        raise Failure("%s: no joint readings at the time of any frame with a time offset of %g s; those of tool '%s' cover %.3f to %.3f s"
                      % (run.sequence.kinematicsFile(), run.time_offsets[0], run.tools[0].info.name, run.sequence.firstTime(0), run.sequence.lastTime(0)))


def verdict(args, run):
    """The exit code."""
    if run.interrupted:
        sys.stderr.write('interrupted: all is of the first %d frames\n' % run.frames)
        return 130
    if not run.nothing_tracked():
        if not (args.poses or args.video or args.quiet):
            print('nothing was kept: --poses FILE.csv and --video FILE.mp4 write the result')
        return 0
    if not run.check(args.stereo, True):
        sys.stderr.write('check: nothing was tracked, though units and calibration are plausible: is it this instrument (model), this arm (name), '
                         'this time (time_offset), and does the hand-eye calibration put it within some centimetres?\n')
    return 2


def run_sequence(args):
    """The exit code."""
    run = Run(args)
    if args.check:
        findings = run.check(run.sequence.isStereo(), args.quiet)
        if not args.quiet:
            print('%s: %d finding%s' % (run.sequence.name(), len(findings), '' if len(findings) == 1 else 's'))
        return 1 if findings else 0
    eyes = st.checkEyes(run.sequence) if args.stereo else ''
    if eyes:
        sys.stderr.write('warning: %s\n' % eyes)
    if args.time_offset is None:
        run.find_time_offsets(args.quiet)
    try:
        track(args, run)
    finally:
        if run.frames > 0 and not args.quiet:   # what was tracked until an error is written and summed up all the same
            run.print_summary()
            sys.stdout.flush()
    return verdict(args, run)


def find_sequences(folder):
    """A folder that is no sequence itself is searched for them, in the order of their names."""
    if folder is None or not os.path.isdir(folder) or os.path.exists(os.path.join(folder, 'sequence.yaml')):
        return [folder]
    found = sorted(glob.glob(os.path.join(glob.escape(folder), '**', 'sequence.yaml'), recursive=True))
    return [os.path.dirname(file) for file in found] or [folder]


def reported(call, *arguments):
    """The exit code of a call, whatever goes wrong in it told in one line."""
    try:
        return call(*arguments)
    except Failure as e:
        message = str(e)
    except cv.error as e:
        message = e.err
    except OSError as e:
        message = str(e)
    except KeyboardInterrupt:
        return 130
    sys.stderr.write('track_sequence.py: %s\n' % message.replace('\n', ' '))
    return 1


def main():
    args = parse_arguments()
    folders = find_sequences(args.sequence)
    if len(folders) == 1:
        args.sequence = folders[0]
        return run_sequence(args)
    worst, labels = 0, {}
    for folder in folders:      # one that fails is told of, and the next one's turn comes
        label = os.path.basename(os.path.abspath(folder))
        labels[label] = labels.get(label, 0) + 1
        own = copy.copy(args)
        own.sequence = folder
        for name in ('poses', 'video'):     # each writes files of its own
            stem, ending = os.path.splitext(getattr(args, name) or '')
            setattr(own, name, stem and '%s_%s%s%s' % (stem, label, '-%d' % labels[label] if labels[label] > 1 else '', ending))
        code = reported(run_sequence, own)
        worst = max(worst, code)
        if code == 130:
            break
    return worst


if __name__ == '__main__':
    sys.exit(reported(main))
