#!/usr/bin/env python3
"""Long runs of the tracker on a sequence, for misc/soak.sh: soak.py SEQUENCE FRAMES SCENARIO; one row of its table."""

import os
import sys
import time

import cv2
import numpy as np

st = cv2.surgtrack
PERIOD = 2000   # frames from one look at the memory to the next


def memory():
    """Of this process, in MB."""
    with open('/proc/self/statm') as f:
        return int(f.read().split()[1]) * os.sysconf('SC_PAGE_SIZE') / 1e6


def load(folder):
    sequence = st.Sequence.load(folder)
    model = st.ToolModel.load(sequence.tool(0).model)
    tracker = st.ToolTracker.create(sequence.leftCamera())
    tracker.addTool(model, sequence.tool(0).nominal_T_base)
    video, images, joints = cv2.VideoCapture(sequence.leftVideo()), [], []
    while True:
        found, image = video.read()
        if not found:
            break
        known, q = sequence.jointsAt(0, len(images) / sequence.fps(), model.coordinateNames())
        if not known:
            break
        images.append(image)
        joints.append(list(q))
    return tracker, images, joints, sequence.fps()


def main():
    folder, frames, scenario = sys.argv[1], int(sys.argv[2]), sys.argv[3]
    tracker, images, joints, fps = load(folder)
    count, rng = len(images), np.random.default_rng(1)
    black, states, least, now, refused, skipped, sizes, finite = np.zeros_like(images[0]), np.zeros(4, int), np.inf, 0., 0, 0, [], True
    noisy = [np.clip(images[0] + rng.normal(0, 2, images[0].shape), 0, 255).astype(np.uint8) for _ in range(20)]   # as a sensor's [grey levels]
    still, first, farthest = scenario in ('static', 'noise'), None, 0.   # how far a tool that stands moves, in deviations
    start = time.monotonic()
    for i in range(frames):
        k = i % (2 * count - 2)
        k = min(k, 2 * count - 2 - k)       # forward and backward
        image, q = images[k], list(joints[k])
        now += 1 / fps
        if scenario == 'static':
            image, q = images[0], list(joints[0])
        elif scenario == 'noise':
            image, q = noisy[i % len(noisy)], list(joints[0])
        elif scenario == 'black' and i % 1000 >= 500:
            image = black
        elif scenario == 'glitches' and i % 20 == 10:
            q[rng.integers(len(q))] = rng.choice([1e200, -1e308, 50., -11., 700., np.nan, np.inf])
        elif scenario == 'jumps' and i % 50 == 25:
            now += rng.choice([-5, 0.3, 3, 1e4])
        try:
            e = tracker.update(image, now, [q])[0]
        except cv2.error:
            refused += 1
            now = max(now, 0)
            if scenario == 'jumps':
                now += 6                    # a clock that was set back goes on
            continue
        states[e.state] += 1
        skipped = e.skippedReadings
        least = min(least, np.linalg.eigvalsh(e.covariance)[0])
        finite = finite and np.isfinite(e.camera_T_tool).all() and np.isfinite(e.covariance).all()
        if still and i >= 200:
            first = e.camera_T_tool[:3, 3].copy() if first is None else first
            farthest = max(farthest, np.linalg.norm(e.camera_T_tool[:3, 3] - first) / np.sqrt(np.trace(e.covariance[3:, 3:])))
        if i % PERIOD == PERIOD - 1 or i in (200, frames - 1):
            sizes.append(memory())
    took = time.monotonic() - start
    growth = sizes[-1] - sizes[min(1, len(sizes) - 1)]
    sound = finite and least > 0 and growth < 20 and farthest < 3
    print('| %s | %d | %.1f | %s | %+.1f | %.1e | %d, %d | %s |' % (scenario, frames, 1e3 * took / frames, ', '.join(map(str, states)), growth, least, refused, skipped,
                                                               'ok' if sound else 'FAILED'))
    return 0 if sound else 1


if __name__ == '__main__':
    sys.exit(main())
