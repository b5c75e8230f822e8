#!/usr/bin/env python3
# This file is part of OpenCV project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution and at http://opencv.org/license.html.

"""Fits the coefficients of src/track/evidence.hpp: log odds that a pose of METHOD_FULL is right, from what it has to show.

A tracker that refuses no pose (ToolTracker::Params::minConfidence = 0) starts at random frames, about the recorded hand-eye calibration
and about one that points at the tissue beside the tool, in images that are spoilt at random: darker, brighter, of another tone, hazy,
blurred, noisy, coded. Each pose it reports is a sample; it is right if its keypoints are by the mean within 5 mm and 10 pixels of the
truth. Two thirds of the starts are fitted, the others tell how well it does: of poses said to be right by 0.8 to 0.9 as many should be.

A tracker reports one pose a frame, the best of those it tried; so there are fewer wrong ones among the samples than it has to refuse.
"""

import argparse
import csv
import json
import os
import re
import sys
import tempfile

import cv2
import numpy as np

st = cv2.surgtrack
NEAR, NEAR_IMAGE = 0.005, 10        # of a pose that is right [m], [pixel]
BESIDE = 0.025                      # from the tool to where there is tissue only [m]
RIDGE = 0.01                        # holds coefficients of which few samples tell anything
NAMES = ("parts", "support", "nis", "constant")


# Images ----------------------------------------------------------------------------------------------------------------------------

def of_light(image, change):
    """Lenses and shutters blur light, of which grey levels are about the square root."""
    return np.sqrt(np.maximum(change(image ** 2), 0))


def motion(length, angle):
    side = length | 1
    kernel, c = np.zeros((side, side), np.float32), side // 2
    d = c * np.array([np.cos(angle), np.sin(angle)])
    cv2.line(kernel, tuple(int(v) for v in np.round(c - d)), tuple(int(v) for v in np.round(c + d)), 1)
    return kernel / kernel.sum()


def spoiler(rng):
    """A function that spoils images, all in the same way but for noise."""
    kind = rng.choice(["plain", "motion", "defocus", "haze", "gain", "motion and haze", "gamma", "jpeg"])
    kernel, sigma, haze = motion(int(rng.integers(4, 17)), rng.uniform(0, np.pi)), rng.uniform(0.5, 3), rng.uniform(0.2, 0.7)
    gain, gamma, quality = rng.uniform(0.15, 1.6), rng.uniform(0.5, 2), int(rng.integers(10, 60))
    noise = rng.uniform(1, 6) if rng.random() < 0.5 else 0

    def spoil(image):
        f = image.astype(np.float32)
        if "motion" in kind:
            f = of_light(f, lambda light: cv2.filter2D(light, -1, kernel))
        if kind == "defocus":
            f = of_light(f, lambda light: cv2.GaussianBlur(light, (0, 0), sigma))
        if "haze" in kind:
            f = f * (1 - haze) + 200 * haze
        if kind == "gain":
            f = f * gain
        if kind == "gamma":
            f = 255 * (f / 255) ** gamma
        if noise:
            f = f + rng.normal(0, noise, f.shape)
        f = np.clip(f, 0, 255).astype(np.uint8)
        return cv2.imdecode(cv2.imencode(".jpg", f, [cv2.IMWRITE_JPEG_QUALITY, quality])[1], cv2.IMREAD_COLOR) if kind == "jpeg" else f

    return spoil


# What is tracked: camera, models, calibrations, and starts(): per start a list of frames (image, joints, truth), truth per tool
# (camera_T_base, joints) or None ----------------------------------------------------------------------------------------------------

class Recorded:
    """A sequence folder with truth."""

    def __init__(self, folder):
        self.sequence = st.Sequence.load(folder)
        self.name = self.sequence.name()
        if not self.sequence.hasGroundTruth():
            raise SystemExit("fit_confidence.py: %s has no truth" % folder)
        self.camera = self.sequence.leftCamera()
        self.tools = [self.sequence.tool(i) for i in range(self.sequence.toolCount())]
        self.models = [st.ToolModel.load(tool.model) for tool in self.tools]
        self.nominal = [np.array(tool.nominal_T_base) for tool in self.tools]

    def truth(self, tool, frame):
        known, camera_T_tool, joints = self.sequence.groundTruth(tool, frame)
        return (camera_T_tool @ np.linalg.inv(self.models[tool].endEffectorPose(joints)), joints) if known else None

    def starts(self, count, length, rng):
        last = self.sequence.groundTruthEnd() - length
        if last < 0:
            raise SystemExit("fit_confidence.py: %s is shorter than --length" % self.name)
        first = sorted(rng.integers(0, last + 1, count))
        video, at, images = cv2.VideoCapture(self.sequence.leftVideo()), 0, {}
        for start in first:
            while at < start + length:
                images[at] = video.read()[1]
                at += 1
            images = {k: image for k, image in images.items() if k >= start}
            frames = []
            for k in range(start, start + length):
                joints = [self.sequence.jointsAt(i, self.sequence.frameTime(k), m.coordinateNames()) for i, m in enumerate(self.models)]
                if images[k] is None or not all(known for known, _ in joints):
                    break
                frames.append((images[k], [q for _, q in joints], [self.truth(i, int(k)) for i in range(len(self.models))]))
            if frames:
                yield frames


class Stills:
    """The stills of the paper's recording, with poses that were confirmed by eye: $SURGTRACK_DATA/real/paper_frames."""

    LAG = 1.5   # frames that images come after their readings

    def __init__(self, data):
        self.name, self.folder = "stills", os.path.join(data, "real", "paper_frames")
        rig = cv2.FileStorage(os.path.join(data, "paper_rig", "out_camera_data.xml"), cv2.FILE_STORAGE_READ)
        self.camera = st.CameraModel(rig.getNode("M1").mat(), rig.getNode("D1").mat().reshape(-1), (720, 576))
        with open(os.path.join(data, "paper_rig", "joints.json")) as file:
            self.arms = sorted(json.load(file).items())
        model = st.ToolModel.load(os.path.join(data, "tools", "large_needle_driver", "large_needle_driver.yaml"))
        self.models = [model] * len(self.arms)
        self.nominal = [np.array(arm["camera_T_base"]) for _, arm in self.arms]
        self.reference = {}
        with open(os.path.join(self.folder, "reference.csv"), newline="") as file:
            for row in csv.DictReader(file):
                if row["m00"]:
                    T = np.array([float(row["m%d%d" % (i, j)]) for i in range(3) for j in range(4)]).reshape(3, 4)
                    self.reference[int(row["frame"]), row["tool"]] = np.vstack([T, [0, 0, 0, 1]]), [float(row[c]) for c in model.coordinateNames()]
        self.frames = sorted({frame for frame, _ in self.reference})

    def starts(self, count, length, rng):
        for k in rng.choice(self.frames, count):
            image = cv2.imread(os.path.join(self.folder, "left_%03d.png" % k))
            joints = []
            for _, arm in self.arms:
                q, t = np.array(arm["q"]), max(k - self.LAG, 0)
                joints.append(q[int(t)] + (t - int(t)) * (q[int(t) + 1] - q[int(t)]))
            yield [(image, joints, [self.reference.get((k, name)) for name, _ in self.arms])] * length


def scenes(count, length, folder):
    """Built-in scenes, as sequence folders."""
    for seed in range(1, count + 1):
        params = st.SyntheticScene.Params()
        params.seed, params.tools, params.frames = 100 + seed, 1 + seed % 2, max(50, length)
        path = os.path.join(folder, "scene%d" % seed)
        st.SyntheticScene.create(None, params).write(path)
        yield Recorded(path)


# Samples ---------------------------------------------------------------------------------------------------------------------------

def is_right(camera, model, estimate, truth):
    def keypoints(camera_T_base, joints):
        points = model.keypointPositions(np.float64(joints))[0].reshape(-1, 3)
        return points @ camera_T_base[:3, :3].T + camera_T_base[:3, 3]
    found = keypoints(estimate.camera_T_tool @ np.linalg.inv(model.endEffectorPose(estimate.joints)), estimate.joints)
    true = keypoints(*truth)
    pixels = camera.projectPoints(found).reshape(-1, 2) - camera.projectPoints(true).reshape(-1, 2)
    return np.linalg.norm(found - true, axis=1).mean() < NEAR and np.linalg.norm(pixels, axis=1).mean() < NEAR_IMAGE * camera.imageSize()[0] / 720


def samples_of(source, count, length, rng):
    """Rows (start, frame, inliers, similarity, support, nis, right)."""
    params = st.ToolTracker.Params()
    params.minConfidence = 0
    rows = []
    for number, frames in enumerate(source.starts(count, length, rng)):
        spoil = spoiler(rng)
        beside = np.eye(4)
        if rng.random() < 0.4:
            angle = rng.uniform(0, 2 * np.pi)
            beside[:2, 3] = BESIDE * np.cos(angle), BESIDE * np.sin(angle)
        tracker = st.ToolTracker.create(source.camera, params)
        for model, nominal_T_base in zip(source.models, source.nominal):
            tracker.addTool(model, beside @ nominal_T_base)
        for k, (image, joints, truth) in enumerate(frames):
            for i, e in enumerate(tracker.update(spoil(image), 0.04 * (k + 1), joints)):
                if truth[i] is not None and e.confidence > 0:
                    rows.append(("%s:%d" % (source.name, number), k, e.inliers, e.similarity, e.contourSupport, e.nis,
                                 int(is_right(source.camera, source.models[i], e, truth[i]))))
    return rows


# Fit -------------------------------------------------------------------------------------------------------------------------------

def built_in():
    """The coefficients that are compiled in, and the two constants that are not fitted."""
    path = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "src", "track", "evidence.hpp")
    with open(path) as file:
        found = re.search(r"EvidenceModel\(\) : (.*?) \{\}", file.read())
    values = {name: float(value) for name, value in re.findall(r"(\w+)\(([-0-9.]+)\)", found.group(1))}
    return np.array([values["parts"], values["support"], -values["nis"], values["constant"]]), values["tissue"], values["mostNis"]


def features(rows, tissue, most_nis):
    inliers, similarity, support, nis = np.array([row[2:6] for row in rows], float).T
    return np.c_[np.sqrt(inliers * np.maximum(similarity - tissue, 0)), support, np.sqrt(np.minimum(nis, most_nis)), np.ones(len(rows))]


def fit(X, right):
    """Logistic regression, by Newton's steps: coefficients and their standard deviations."""
    b = np.zeros(X.shape[1])
    for _ in range(50):
        p = 1 / (1 + np.exp(-np.clip(X @ b, -30, 30)))
        H = X.T @ (X * (p * (1 - p))[:, None]) + RIDGE * np.eye(len(b))
        b = b + np.linalg.solve(H, X.T @ (right - p) - RIDGE * b)
    return b, np.sqrt(np.diag(np.linalg.inv(H)))


def table(title, log_odds, right):
    p = 1 / (1 + np.exp(-log_odds))
    loss = -np.mean(np.log(np.where(right, p, 1 - p) + 1e-9))
    print("%s: log loss %.3f" % (title, loss))
    print("  said to be right    poses   mean   are right")
    for tenth in range(10):
        inside = (p >= tenth / 10) & (p < (tenth + 1) / 10 if tenth < 9 else p <= 1)
        if inside.any():
            print("     %.1f to %.1f      %6d   %.3f   %.3f" % (tenth / 10, (tenth + 1) / 10, inside.sum(), p[inside].mean(), right[inside].mean()))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("sequences", nargs="*", metavar="SEQUENCE", help="sequence folder with truth")
    parser.add_argument("--scenes", type=int, default=3, help="built-in scenes beside them (default %(default)s)")
    parser.add_argument("--stills", action="store_true", help="also the real stills of $SURGTRACK_DATA")
    parser.add_argument("--starts", type=int, default=40, help="per sequence (default %(default)s)")
    parser.add_argument("--length", type=int, default=4, help="frames after a start (default %(default)s)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--samples", metavar="CSV", help="is written")
    options = parser.parse_args()
    rng, rows = np.random.default_rng(options.seed), []
    with tempfile.TemporaryDirectory() as folder:
        sources = [Recorded(path) for path in options.sequences] + list(scenes(options.scenes, options.length, folder))
        if options.stills:
            sources.append(Stills(os.environ["SURGTRACK_DATA"]))
        for source in sources:
            rows += samples_of(source, options.starts, options.length, rng)
            print("%s: %d poses so far" % (source.name, len(rows)), file=sys.stderr)
    if not rows:
        raise SystemExit("fit_confidence.py: no pose was found")
    if options.samples:
        with open(options.samples, "w", newline="") as file:
            writer = csv.writer(file)
            writer.writerow(("start", "frame", "inliers", "similarity", "support", "nis", "right"))
            writer.writerows(rows)

    now, tissue, most_nis = built_in()
    X, right = features(rows, tissue, most_nis), np.array([row[6] for row in rows]) > 0
    held_out = np.array([int(row[0].split(":")[-1]) % 3 == 2 for row in rows])
    if held_out.all() or not held_out.any():
        raise SystemExit("fit_confidence.py: too few starts to hold some out")
    fitted, deviation = fit(X[~held_out], right[~held_out])
    print("%d poses, %d right; %d of them held out" % (len(rows), right.sum(), held_out.sum()))
    print("             built in   fitted")
    for name, a, b, d in zip(NAMES, now, fitted, deviation):
        print("  %-9s  %8.2f %8.2f +- %.2f" % (name, a, b, d))
    table("built in, on what is held out", X[held_out] @ now, right[held_out])
    table("fitted, on what is held out", X[held_out] @ fitted, right[held_out])


if __name__ == "__main__":
    main()
