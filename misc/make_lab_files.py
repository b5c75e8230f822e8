#!/usr/bin/env python3
# This file is part of OpenCV project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution and at http://opencv.org/license.html.

"""Makes the files a lab would have of a sequence, in the formats of others, for samples/import.cpp.

Into DIR go the dVRK's kinematics (PSM.json, DRIVER.json), keypoints as picked in the meshes of the sequence's tool (points.csv), left.mp4,
camera_info.yaml of ROS, stereo.yml of OpenCV, js.csv and jaw.csv with nanoseconds of another clock, hand_eye.yaml, a URDF of the built-in tool
(driver.urdf, needle_driver_*.ply) and one of something else (crane.urdf, peak.obj), a calibration as SurgPose has it (rig.ini), and labels (labels.json, keypoints_left.yaml).
With --urdf, driver.urdf is that file, with its meshes, and points.csv has points picked in these.
"""

import argparse
import csv
import os
import re
import shutil

import cv2
import numpy as np

PSM = """/* -*- Mode: Javascript -*- */
{ // the arm
  "DH": { "convention": "modified", "joints": [
    { "name": "yaw", "alpha": 1.5708, "A": 0.0, "theta": 0.0, "D": 0.0, "type": "revolute", "offset": 1.5708 },
    { "name": "pitch", "alpha": -1.5708, "A": 0.0, "theta": 0.0, "D": 0.0, "type": "revolute", "offset": -1.5708 },
    { "name": "insertion", "alpha": 1.5708, "A": 0.0, "theta": 0.0, "D": 0.0, "type": "prismatic", "offset": -0.4318 } ] }
}
"""

DRIVER = """{ "DH": { "convention": "modified", "joints": [
    { "name": "roll", "alpha": 0.0, "A": 0.0, "theta": 0.0, "D": 0.4162, "type": "revolute", "offset": 0.0 },
    { "name": "wrist_pitch", "alpha": -1.5708, "A": 0.0, "theta": 0.0, "D": 0.0, "type": "revolute", "offset": -1.5708 },
    { "name": "wrist_yaw", "alpha": -1.5708, "A": 0.0091, "theta": 0.0, "D": 0.0, "type": "revolute", "offset": -1.5708 } ] },
  "jaw": { "qmin": -0.7, "qmax": 1.4 },
  "tooltip_offset": [[0, -1, 0, 0], [0, 0, 1, 0], [-1, 0, 0, 0], [0, 0, 0, 1]]
}
"""

CRANE = """<?xml version="1.0"?>
<robot name="crane">
  <link name="base"/>
  <link name="shaft"><visual><geometry><mesh filename="package://crane/peak.obj" scale="0.001 0.001 0.001"/></geometry></visual></link>
  <joint name="turn" type="continuous"><parent link="base"/><child link="shaft"/><origin xyz="0 0 0.1" rpy="0 1.5708 0"/><axis xyz="0 1 0"/></joint>
</robot>
"""

ARM = """<?xml version="1.0"?>
<robot name="driver">
  <link name="base"/> <link name="yaw"/> <link name="pitch"/> <link name="insertion"/> <link name="wrist_yaw"/> <link name="opening"/> <link name="tool_tip_link"/>
  <link name="roll"><visual><geometry><mesh filename="package://driver/needle_driver_0.ply"/></geometry></visual></link>
  <link name="wrist_pitch"><visual><geometry><mesh filename="package://driver/needle_driver_1.ply"/></geometry></visual></link>
  <link name="jaw_right"><visual><geometry><mesh filename="package://driver/needle_driver_2.ply"/></geometry></visual></link>
  <link name="jaw_left"><visual><geometry><mesh filename="package://driver/needle_driver_3.ply"/></geometry></visual></link>
"""

# Joint, parent, child, xyz, rpy, what else it has: the numbers of PSM and DRIVER.
ARM_JOINTS = (("outer_yaw", "base", "yaw", "0 0 0", "1.5708 -1.5708 0", ""),
              ("outer_pitch", "yaw", "pitch", "0 0 0", "-1.5708 -1.5708 0", ""),
              ("outer_insertion", "pitch", "insertion", "0 0.4318 0", "1.5708 0 0", ""),
              ("outer_roll", "insertion", "roll", "0 0 0.4162", "0 0 0", ""),
              ("outer_wrist_pitch", "roll", "wrist_pitch", "0 0 0", "-1.5708 -1.5708 0", ""),
              ("outer_wrist_yaw", "wrist_pitch", "wrist_yaw", "0.0091 0 0", "-1.5708 -1.5708 0", ""),
              ("jaw", "wrist_yaw", "opening", "0 0 0", "0 0 0", ""),
              ("right", "wrist_yaw", "jaw_right", "0 0 0", "0 0 0", '<mimic joint="jaw" multiplier="0.5"/>'),
              ("left", "wrist_yaw", "jaw_left", "0 0 0", "0 0 0", '<mimic joint="jaw" multiplier="-0.5"/>'),
              ("tip", "wrist_yaw", "tool_tip_link", "0 0.0102 0", "-1.5708 1.5708 0", ""))

PEAK = """v 0 0 0\nv 2 0 0\nv 0 2 0\nv 0 0 2\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"""

EYE = "res_x=720\nres_y=576\nfc_x=800\nfc_y=800\ncc_x=360\ncc_y=288\nkc_0=0\nkc_1=0\nkc_2=0\nkc_3=0\nkc_4=0\n"
RIG = ("[StereoLeft]\n" + EYE + "[StereoRight]\n" + EYE + "R_0=1\nR_1=0\nR_2=0\nR_3=0\nR_4=1\nR_5=0\nR_6=0\nR_7=0\nR_8=1\n"
       "T_0=-5\nT_1=0\nT_2=0\n")

LABELS = '[{"annotations": [{"class": "HeadPoint", "id": "tool1", "x": 3, "y": 4}]}]\n'
KEYPOINTS_LEFT = "0:\n  1:\n  - 3.5\n  - 4\n  2: null\n"

JOINTS = ["outer_yaw", "outer_pitch", "outer_insertion", "outer_roll", "outer_wrist_pitch", "outer_wrist_yaw"]
LINKS = {"shaft": "roll", "wrist": "wrist_pitch", "yaw": "wrist_yaw"}   # of the built-in tool, by the names in DRIVER


def write_camera(left, sequence, folder):
    with open(os.path.join(folder, "camera_info.yaml"), "w") as info:   # no %YAML line, as ROS writes it
        info.write("image_width: %d\nimage_height: %d\ndistortion_model: plumb_bob\n"
                   % (sequence.getNode("image_width").real(), sequence.getNode("image_height").real()))
        for key, rows, cols in (("camera_matrix", 3, 3), ("distortion_coefficients", 1, 5)):
            data = ", ".join(repr(float(v)) for v in left.getNode(key).mat().ravel())
            info.write("%s:\n  rows: %d\n  cols: %d\n  data: [%s]\n" % (key, rows, cols, data))
    stereo = cv2.FileStorage(os.path.join(folder, "stereo.yml"), cv2.FILE_STORAGE_WRITE)
    for eye in ("1", "2"):
        stereo.write("M" + eye, left.getNode("camera_matrix").mat())
        stereo.write("D" + eye, left.getNode("distortion_coefficients").mat())
    stereo.write("R", cv2.Rodrigues(np.array([0., 0.01, 0.]))[0])
    stereo.write("T", np.array([-5., 0., 0.]))
    stereo.release()


def write_joints(source, tool, folder):
    with open(os.path.join(source, "kinematics.csv"), newline="") as readings:
        rows = [row for row in csv.DictReader(readings) if row["tool"] == tool]
    columns = [column for column in rows[0] if column not in ("time", "tool")]
    with open(os.path.join(folder, "js.csv"), "w") as arm, open(os.path.join(folder, "jaw.csv"), "w") as jaw:
        arm.write("header.stamp," + ",".join(JOINTS) + "\n")
        jaw.write("header.stamp,position[0]\n")
        for r in rows:
            stamp = 1700000000000000000 + int(round(float(r["time"]) * 1e9))
            arm.write("%d,%s\n" % (stamp, ",".join(r[column] for column in columns[:6])))
            jaw.write("%d,%s\n" % (stamp, r[columns[6]] if len(columns) > 6 else "0"))


def write_urdf(meshes, folder):
    with open(os.path.join(folder, "driver.urdf"), "w") as urdf:
        urdf.write(ARM)
        for joint, parent, child, xyz, rpy, more in ARM_JOINTS:
            kind = "fixed" if child == "tool_tip_link" else "prismatic" if child == "insertion" else "revolute"
            urdf.write('  <joint name="%s" type="%s"><parent link="%s"/><child link="%s"/><origin xyz="%s" rpy="%s"/><axis xyz="0 0 1"/>'
                       '<limit lower="%g" upper="%g" effort="1" velocity="1"/>%s</joint>\n'
                       % ((joint, kind, parent, child, xyz, rpy) + ((0, 0.24) if kind == "prismatic" else (-4, 4)) + (more,)))
        urdf.write("</robot>\n")
    for i in range(4):
        shutil.copy(os.path.join(meshes, "needle_driver_%d.ply" % i), folder)


def copy_urdf(urdf, folder):
    """The file and the meshes of its packages, which lie beside it."""
    with open(urdf) as file:
        text = file.read()
    with open(os.path.join(folder, "driver.urdf"), "w") as file:
        file.write(text)
    for mesh in set(re.findall(r'filename="package://([^"]+)"', text)):
        os.makedirs(os.path.dirname(os.path.join(folder, mesh)), exist_ok=True)
        shutil.copy(os.path.join(os.path.dirname(urdf), mesh), os.path.join(folder, mesh))


def pick_points(folder, count=16, reach=0.022):
    """As a user picks them in a mesh viewer: all over what lies within 22 mm of the wrist, each far from the others."""
    parts = cv2.surgtrack.ToolParts()
    parts.packages, parts.endEffector = folder, "tool_tip_link"
    model = cv2.surgtrack.importUrdfTool(os.path.join(folder, "driver.urdf"), parts)
    names, poses = model.linkNames(), model.linkPoses(np.zeros(len(model.coordinateNames())))
    wrist = poses[[name.startswith("wrist_pitch") for name in names].index(True)][:3, 3]
    candidates, places = [], []
    for link, name in enumerate(names):
        if model.linkMesh(link) < 0:
            continue
        vertices = model.getMesh(model.linkMesh(link))[0].reshape(-1, 3).astype(float)
        in_base = vertices @ poses[link][:3, :3].T + poses[link][:3, 3]
        near = np.linalg.norm(in_base - wrist, axis=1) < reach
        candidates += [(name, point) for point in vertices[near]]
        places.append(in_base[near])
    places = np.concatenate(places)
    chosen = [int(np.argmax(np.linalg.norm(places - places.mean(0), axis=1)))]
    distances = np.full(len(places), np.inf)
    while len(chosen) < count:
        distances = np.minimum(distances, np.linalg.norm(places - places[chosen[-1]], axis=1))
        chosen.append(int(np.argmax(distances)))
    with open(os.path.join(folder, "points.csv"), "w") as points:
        points.write("name,link,x,y,z\n")
        for i, index in enumerate(chosen):
            name, point = candidates[index]
            points.write("point%d,%s,%.6f,%.6f,%.6f\n" % (i, name, *point))


def write_points(model, folder):
    tool = cv2.FileStorage(model, cv2.FILE_STORAGE_READ)
    keypoints = tool.getNode("keypoints")
    with open(os.path.join(folder, "points.csv"), "w") as points:
        points.write("name,link,x,y,z\n")
        for i in range(keypoints.size()):
            keypoint = keypoints.at(i)
            link, position = keypoint.getNode("link").string(), keypoint.getNode("position")
            points.write("%s,%s,%s\n" % (keypoint.getNode("name").string(), LINKS.get(link, link),
                                         ",".join(repr(position.at(k).real()) for k in range(3))))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sequence", help="a folder with sequence.yaml; its first tool is taken")
    parser.add_argument("dir", help="folder to write; is made if it does not exist")
    parser.add_argument("--urdf", help="the instrument, its meshes in packages beside it; without it the tool is that of make_sequence")
    args = parser.parse_args()
    os.makedirs(args.dir, exist_ok=True)
    for name, text in (("PSM.json", PSM), ("DRIVER.json", DRIVER), ("crane.urdf", CRANE), ("peak.obj", PEAK), ("rig.ini", RIG),
                       ("labels.json", LABELS), ("keypoints_left.yaml", KEYPOINTS_LEFT)):
        with open(os.path.join(args.dir, name), "w") as file:
            file.write(text)
    sequence = cv2.FileStorage(os.path.join(args.sequence, "sequence.yaml"), cv2.FILE_STORAGE_READ)
    tool = sequence.getNode("tools").at(0)
    write_camera(sequence.getNode("left"), sequence, args.dir)
    hand_eye = cv2.FileStorage(os.path.join(args.dir, "hand_eye.yaml"), cv2.FILE_STORAGE_WRITE)
    hand_eye.write("camera_T_base", tool.getNode("camera_T_base").mat())
    hand_eye.release()
    write_joints(args.sequence, tool.getNode("name").string(), args.dir)
    shutil.copy(os.path.join(args.sequence, sequence.getNode("left").getNode("video").string()), os.path.join(args.dir, "left.mp4"))
    if args.urdf:
        copy_urdf(args.urdf, args.dir)
        pick_points(args.dir)
        return
    write_urdf(os.path.join(args.sequence, os.path.dirname(tool.getNode("model").string()), "meshes"), args.dir)
    write_points(os.path.join(args.sequence, tool.getNode("model").string()), args.dir)


if __name__ == "__main__":
    main()
