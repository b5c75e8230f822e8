#!/usr/bin/env python3
# This file is part of OpenCV project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution and at http://opencv.org/license.html.

"""Makes the recording of a hand-eye calibration as the robot and the camera of a sequence with truth would give it.

Into DIR go robot.csv (base_T_tool of the instrument that holds the board), board.csv (camera_T_board) and images/NNNN.png of a grid of
4 x 11 circles, 1.5 mm from row to row. The robot's poses are wrong by 0.2 mm and 0.2 degrees, those of the board as the images have it;
pose 5 was read while the arm still moved.
"""

import argparse
import os

import cv2
import numpy as np

SPACING, COLUMNS, ROWS = 0.0015, 4, 11
RADIUS = 0.0006
PIXELS = 24000.    # of the drawn board, per metre
MARGIN = 0.003


def rigid(rotation_vector, translation):
    T = np.eye(4)
    T[:3, :3] = cv2.Rodrigues(np.float64(rotation_vector))[0]
    T[:3, 3] = translation
    return T


def board_picture():
    width, height = (2 * COLUMNS - 1) * SPACING + 2 * MARGIN, (ROWS - 1) * SPACING + 2 * MARGIN
    picture = np.full((round(height * PIXELS), round(width * PIXELS)), 230, np.uint8)
    for row in range(ROWS):
        for column in range(COLUMNS):
            x, y = (2 * column + row % 2) * SPACING + MARGIN, row * SPACING + MARGIN
            cv2.circle(picture, (round(x * PIXELS * 16), round(y * PIXELS * 16)), round(RADIUS * PIXELS * 16), 25, cv2.FILLED, cv2.LINE_AA, 4)
    return cv2.GaussianBlur(picture, (0, 0), 0.7 * PIXELS / 8500)    # 8500: pixels of the image per metre


def photograph(camera, camera_T_board, picture, rng):
    """The board as the camera sees it, with its distortion: where the ray of each pixel meets the board."""
    width, height = camera.imageSize()
    u, v = np.meshgrid(np.arange(width, dtype=np.float64), np.arange(height, dtype=np.float64))
    rays = camera.unprojectPoints(np.stack([u.ravel(), v.ravel()], 1)).reshape(-1, 2)
    rays = np.hstack([rays, np.ones((len(rays), 1))])
    R, t = camera_T_board[:3, :3], camera_T_board[:3, 3]
    depth = R[:, 2].dot(t) / rays.dot(R[:, 2])
    points = (rays * depth[:, None] - t).dot(R)
    x, y = (((points[:, i] + MARGIN) * PIXELS).reshape(height, width).astype(np.float32) for i in (0, 1))
    image = cv2.remap(picture, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=110).astype(np.float64)
    return np.clip(image + rng.normal(0, 2, image.shape), 0, 255).astype(np.uint8)


def true_camera_T_base(sequence, tool):
    found, camera_T_tool, joints = sequence.groundTruth(tool, 0)
    if not found:
        raise SystemExit("make_hand_eye.py: the sequence has no truth of frame 0")
    model = cv2.surgtrack.ToolModel.load(sequence.tool(tool).model)
    names = sequence.jointNames()
    values = np.float64([joints[names.index(name)] for name in model.coordinateNames()])
    return np.float64(camera_T_tool).dot(np.linalg.inv(model.endEffectorPose(values)))


def quaternion(R):
    """x, y, z, w."""
    w, V = np.linalg.eigh(np.array([
        [R[0, 0] - R[1, 1] - R[2, 2], 0, 0, 0],
        [R[0, 1] + R[1, 0], R[1, 1] - R[0, 0] - R[2, 2], 0, 0],
        [R[0, 2] + R[2, 0], R[1, 2] + R[2, 1], R[2, 2] - R[0, 0] - R[1, 1], 0],
        [R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1], R[0, 0] + R[1, 1] + R[2, 2]]]))
    return V[:, -1]


def write_poses(filename, poses):
    with open(filename, "w") as file:
        file.write("index,tx,ty,tz,qx,qy,qz,qw\n")
        for index, T in enumerate(poses):
            file.write("%d,%s\n" % (index, ",".join("%.9f" % v for v in np.hstack([T[:3, 3], quaternion(T[:3, :3])]))))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("sequence", help="folder of a sequence with groundtruth.csv")
    parser.add_argument("out", help="folder to write; is made if it does not exist")
    parser.add_argument("--tool", type=int, default=0, help="index of the tool")
    parser.add_argument("--poses", type=int, default=16)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    os.makedirs(os.path.join(options.out, "images"), exist_ok=True)
    rng = np.random.default_rng(options.seed)
    sequence = cv2.surgtrack.Sequence.load(options.sequence)
    camera, picture = sequence.leftCamera(), board_picture()
    camera_T_base = true_camera_T_base(sequence, options.tool)
    tool_T_board = rigid([0.2, 2.9, -0.3], [0.004, -0.006, 0.012])
    middle = np.array([3.5 * SPACING, 5 * SPACING, 0])
    robot, board = [], []
    for index in range(options.poses):
        tilt, direction, roll = np.radians(35) * np.sqrt(rng.random()), rng.uniform(-np.pi, np.pi), rng.uniform(-1, 1)
        T = rigid([tilt * np.cos(direction), tilt * np.sin(direction), 0], [0, 0, 0]).dot(rigid([0, 0, roll], [0, 0, 0]))
        T[:3, 3] = rng.uniform([-0.012, -0.008, 0.085], [0.012, 0.008, 0.115]) - T[:3, :3].dot(middle)
        cv2.imwrite(os.path.join(options.out, "images", "%04d.png" % index), photograph(camera, T, picture, rng))
        robot_error = rigid(rng.normal(0, np.radians(0.2), 3), rng.normal(0, 0.0002, 3))
        robot.append(np.linalg.inv(camera_T_base).dot(T).dot(np.linalg.inv(tool_T_board)).dot(robot_error))
        board.append(T.dot(rigid(rng.normal(0, np.radians([0.4, 0.4, 0.05])), [0, 0, 0])))
        board[-1][:3, 3] *= 1 + rng.normal(0, 0.002)
    if options.poses > 5:
        robot[5] = robot[5].dot(rigid([0.02, -0.15, 0.05], [0.004, 0.001, -0.003]))
    write_poses(os.path.join(options.out, "robot.csv"), robot)
    write_poses(os.path.join(options.out, "board.csv"), board)
    np.savetxt(os.path.join(options.out, "camera_T_base.txt"), camera_T_base, "%.9f")


if __name__ == "__main__":
    main()
