#!/usr/bin/env python3
# This file is part of OpenCV project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution and at http://opencv.org/license.html.
"""Finds the tools in real stills of the recording of Ye et al., each a start of its own, as they are and with less light.

    SURGTRACK_DATA=FOLDER PYTHONPATH=BUILD/python_loader python3 real_stills.py [--stills=8,203,295] [--gain=1,0.4] [--least=5]
    ... real_stills.py --sequences=DIR      writes each still as a sequence for example_surgtrack_evaluate instead, to set others beside ours

FOLDER has real/paper_frames (left_NNN.png; reference.csv: poses that overlays confirmed, not truth), paper_rig (joints.json,
out_camera_data.xml) and tools. Exit code 1 if at a gain fewer tools are found than --least, or one where there is none."""

import argparse
import csv
import json
import os
import sys

import cv2 as cv
import numpy as np
from cv2 import surgtrack as st

LATE = 1.5          # images lag the joints by so many frames in this recording
SHOWN = 6           # a still is shown so many times: a first pose is confirmed over some frames
WRONG = 15          # mean distance of the keypoints from the reference's [pixel]


def numbers(text):
    return [float(value) for value in text.split(',')]


class Recording:
    """Joints, camera, calibration and reference poses."""

    def __init__(self, data):
        self.stills = os.path.join(data, 'real', 'paper_frames')
        rig = cv.FileStorage(os.path.join(data, 'paper_rig', 'out_camera_data.xml'), cv.FILE_STORAGE_READ)
        self.camera = st.CameraModel(rig.getNode('M1').mat(), rig.getNode('D1').mat().reshape(-1), (720, 576))
        self.tool = os.path.join(data, 'tools', 'large_needle_driver', 'large_needle_driver.yaml')
        self.model = st.ToolModel.load(self.tool)
        with open(os.path.join(data, 'paper_rig', 'joints.json')) as file:
            arms = json.load(file)
        self.arms = sorted(arms)
        self.joints = {arm: np.array(arms[arm]['q']) for arm in arms}
        self.nominal = {arm: np.array(arms[arm]['camera_T_base']) for arm in arms}
        self.reference, self.confirmed = {}, {}
        with open(os.path.join(self.stills, 'reference.csv'), newline='') as file:
            for row in csv.DictReader(file):
                if row['m00']:      # a pose was confirmed
                    pose = np.array([float(row['m%d%d' % (i, j)]) for i in range(3) for j in range(4)] + [0, 0, 0, 1]).reshape(4, 4)
                    joints = [float(row[name]) for name in self.model.coordinateNames()]
                    self.reference[int(row['frame']), row['tool']] = self.points(pose, joints)
                    self.confirmed[int(row['frame']), row['tool']] = pose, joints

    def image(self, still):
        name = os.path.join(self.stills, 'left_%03d.png' % still)
        image = cv.imread(name)
        if image is None:
            sys.exit(name + ': there is no such image')
        return image

    def reading(self, arm, time):
        """Between the records of two frames."""
        values, frame = self.joints[arm], int(time)
        return list(values[frame] + (time - frame) * (values[frame + 1] - values[frame]))

    def points(self, camera_T_base, joints):
        """The keypoints in the image."""
        base = self.model.keypointPositions(np.array(joints))[0].reshape(-1, 3)
        return self.camera.projectPoints(base @ camera_T_base[:3, :3].T + camera_T_base[:3, 3]).reshape(-1, 2)


def find(recording, still, gain):
    """The tools found in a still, and of these those that are where none is."""
    tracker = st.ToolTracker.create(recording.camera)
    for arm in recording.arms:
        tracker.addTool(recording.model, recording.nominal[arm])
    image = cv.convertScaleAbs(recording.image(still), alpha=gain)
    joints = [recording.reading(arm, still - LATE) for arm in recording.arms]
    for k in range(SHOWN):
        estimates = tracker.update(image, 0.04 * k, joints)
    found, wrong = 0, 0
    for arm, e in zip(recording.arms, estimates):
        if e.state != st.STATE_TRACKING:
            continue
        found += 1
        if (still, arm) in recording.reference:
            points = recording.points(np.array(e.camera_T_nominal) @ recording.nominal[arm], e.joints)
            wrong += np.linalg.norm(points - recording.reference[still, arm], axis=1).mean() > WRONG
    return found, wrong


def write_sequence(recording, still, folder):
    """The still as a video of SHOWN frames, with the tools whose pose was confirmed; that is the truth of the last frame alone."""
    os.makedirs(folder, exist_ok=True)
    names = recording.model.coordinateNames()
    arms = [arm for arm in recording.arms if (still, arm) in recording.confirmed]
    out = cv.FileStorage(os.path.join(folder, 'sequence.yaml'), cv.FILE_STORAGE_WRITE)
    for key, value in (('name', 'still_%03d' % still), ('fps', 25), ('image_width', 720), ('image_height', 576)):
        out.write(key, value)
    out.startWriteStruct('left', cv.FileNode_MAP)
    out.write('video', 'left_%d.png')
    out.write('camera_matrix', recording.camera.cameraMatrix())
    out.write('distortion_coefficients', recording.camera.distCoeffs())
    out.endWriteStruct()
    out.write('kinematics', 'kinematics.csv')
    out.write('groundtruth', 'groundtruth.csv')
    out.startWriteStruct('tools', cv.FileNode_SEQ)
    for arm in arms:
        out.startWriteStruct('', cv.FileNode_MAP)
        out.write('name', arm)
        out.write('model', os.path.abspath(recording.tool))
        out.write('camera_T_base', recording.nominal[arm])
        out.endWriteStruct()
    out.endWriteStruct()
    out.release()
    for k in range(SHOWN):
        cv.imwrite(os.path.join(folder, 'left_%d.png' % k), recording.image(still))
    with open(os.path.join(folder, 'kinematics.csv'), 'w', newline='') as file:
        rows = csv.writer(file)
        rows.writerow(['time', 'tool'] + list(names))
        for k in range(SHOWN):
            rows.writerows([0.04 * k, arm] + recording.reading(arm, still - LATE) for arm in arms)
    with open(os.path.join(folder, 'groundtruth.csv'), 'w', newline='') as file:
        rows = csv.writer(file)
        rows.writerow(['frame', 'time', 'tool', 'tx', 'ty', 'tz', 'qx', 'qy', 'qz', 'qw'] + list(names))
        for arm in arms:
            base, joints = recording.confirmed[still, arm]
            pose = base @ np.array(recording.model.endEffectorPose(np.array(joints)))
            vector = cv.Rodrigues(pose[:3, :3])[0].reshape(3)
            angle = np.linalg.norm(vector)
            turn = [*(np.sin(angle / 2) * vector / max(angle, 1e-12)), np.cos(angle / 2)]
            rows.writerow([SHOWN - 1, 0.04 * (SHOWN - 1), arm, *pose[:3, 3], *turn, *joints])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--stills', type=numbers, default=[8, 203, 295], help='numbers of frames')
    parser.add_argument('--gain', type=numbers, default=[1, 0.4], help='factors of the light')
    parser.add_argument('--least', type=int, default=5, help='tools, of two a still')
    parser.add_argument('--sequences', help='folder to write all confirmed stills to, a sequence each')
    args = parser.parse_args()
    data = os.environ.get('SURGTRACK_DATA', '')
    if not os.path.isdir(os.path.join(data, 'real', 'paper_frames')):
        print('skipped: SURGTRACK_DATA does not name a folder that has real/paper_frames')
        return 0
    recording, failed = Recording(data), False
    if args.sequences:
        for still in sorted({still for still, _ in recording.confirmed}):
            write_sequence(recording, still, os.path.join(args.sequences, 'still_%03d' % still))
        return 0
    for gain in args.gain:
        results = [find(recording, int(still), gain) for still in args.stills]
        found, wrong = (sum(column) for column in zip(*results))
        print('gain %g: %d of %d tools found, %d of them wrong' % (gain, found, 2 * len(args.stills), wrong))
        failed = failed or found < args.least or wrong > 0
    return int(failed)


if __name__ == '__main__':
    sys.exit(main())
