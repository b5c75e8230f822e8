#!/usr/bin/env python3
"""Plots of a run over time, from the poses file it wrote:

    example_surgtrack_track_sequence --sequence=DIR --poses=poses.csv --timings=timings.csv
    plot_run.py poses.csv [--timings=timings.csv] [--sequence=DIR] [--out=FOLDER]

poses.png: position and orientation with the band of two standard deviations; evidence.png: state, parts, similarity, outline, NIS;
offsets.png: what is added to the joint readings; with --sequence, errors.png: errors against the ground truth, in the same bands;
with --timings, timings.png.
"""
import argparse
import csv
import math
import os
import sys

COLORS = ("tab:blue", "tab:orange", "tab:green", "tab:red", "tab:purple")
STATES = {"initializing": "0.75", "tracking": "tab:green", "coasting": "gold", "lost": "tab:red"}
POSE = ["tx", "ty", "tz", "qx", "qy", "qz", "qw"]
COMPONENTS = ["tx", "ty", "tz", "rx", "ry", "rz"]
TEXTS = ("tool", "status")


class DataError(Exception):
    """A file that is not as expected; the text is the line the user gets."""


def read(filename, needed):
    """Rows of a CSV file by tool, '' without such a column, in the file's order: {tool: {column: list}}. All other columns but
    status are numbers, NaN where there is nothing."""
    try:
        with open(filename, newline="") as file:
            reader = csv.DictReader(file)
            header = reader.fieldnames or []
            for column in needed:
                if column not in header:
                    raise DataError("%s: expected a column '%s'" % (filename, column))
            tools = {}
            for line, row in enumerate(reader, 2):
                if None in row.values():
                    raise DataError("%s, line %d: has fewer columns than line 1" % (filename, line))
                tool = tools.setdefault(row.get("tool", ""), {column: [] for column in header})
                for column in header:
                    try:
                        tool[column].append(row[column] if column in TEXTS else float(row[column] or "nan"))
                    except ValueError:
                        raise DataError("%s, line %d: %s is '%s', expected a number" % (filename, line, column, row[column]))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise DataError("%s: %s" % (filename, getattr(error, "strerror", None) or error))
    if not tools:
        raise DataError("%s: expected lines after the first" % filename)
    return tools


def multiply(a, b):
    """Quaternions x, y, z, w."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz)


def rotationVector(q):
    """Of a quaternion, at most 180 degrees [rad]."""
    x, y, z, w = q if q[3] >= 0 else [-c for c in q]
    sine = math.sqrt(x * x + y * y + z * z)
    factor = 2 if sine < 1e-12 else 2 * math.atan2(sine, w) / sine
    return [factor * x, factor * y, factor * z]


def quaternions(tool):
    return list(zip(*(tool[c] for c in POSE[3:])))


class Run:
    """The poses of all tools, and what is drawn of them: {component: list}, in mm and rad, NaN in frames that have no pose."""

    def __init__(self, filename, sequence):
        self.tools = read(filename, ["frame", "time", "tool", "status"] + POSE)
        for tool in self.tools.values():
            tool["known"] = [s in ("tracking", "coasting") for s in tool["status"]]
        self.truth = None
        if sequence:
            self.truth = read(os.path.join(sequence, "groundtruth.csv"), ["frame", "tool"] + POSE)
            for name in self.tools:
                if name not in self.truth:
                    raise DataError("%s: has no tool '%s'" % (os.path.join(sequence, "groundtruth.csv"), name))

    def columns(self, prefix):
        """Names of the columns that begin so, without those that hold nothing or zeros only."""
        names = [column for column in next(iter(self.tools.values())) if column.startswith(prefix)]
        return [n for n in names if any(v and not math.isnan(v) for tool in self.tools.values() for v in tool.get(n, []))]

    def poses(self, tool):
        """Position, and the rotation since the first known frame."""
        result = {c: [1e3 * v for v in tool[c]] for c in POSE[:3]}
        rotations = quaternions(tool)
        first = rotations[tool["known"].index(True) if True in tool["known"] else 0]
        inverse = (-first[0], -first[1], -first[2], first[3])
        for component, values in zip(COMPONENTS[3:], zip(*(rotationVector(multiply(q, inverse)) for q in rotations))):
            result[component] = list(values)
        return known(tool, result)

    def errors(self, name):
        """Estimate less truth, in the camera frame."""
        tool, truth = self.tools[name], self.truth[name]
        rows = {int(frame): i for i, frame in enumerate(truth["frame"])}
        result = {c: [] for c in COMPONENTS}
        for i, q in enumerate(quaternions(tool)):
            k = rows.get(int(tool["frame"][i]))
            if k is None:
                values = [math.nan] * 6
            else:
                x, y, z, w = (truth[c][k] for c in POSE[3:])
                values = [1e3 * (tool[c][i] - truth[c][k]) for c in POSE[:3]] + rotationVector(multiply(q, (-x, -y, -z, w)))
            for component, value in zip(COMPONENTS, values):
                result[component].append(value)
        return known(tool, result)


def known(tool, values):
    return {c: [v if k else math.nan for v, k in zip(column, tool["known"])] for c, column in values.items()}


def save(pyplot, figure, folder, name):
    filename = os.path.join(folder, name)
    figure.tight_layout()
    try:
        figure.savefig(filename, dpi=90)
    except OSError as error:
        raise DataError("%s: %s" % (filename, error.strerror or error))
    pyplot.close(figure)
    print(filename)


def finish(axes, title):
    for axis in axes.flat:
        axis.grid(alpha=0.3)
    for axis in axes[-1]:
        axis.set_xlabel("time [s]")
    axes[0, 0].figure.suptitle(title, fontsize=10)


def plotComponents(pyplot, run, values, folder, name, title, centred):
    """Six components over time. centred: the bands are about zero, else about the values."""
    figure, axes = pyplot.subplots(2, 3, figsize=(14, 6), sharex=True)
    for axis, component in zip(axes.flat, COMPONENTS):
        limits = []
        for (label, tool), color in zip(run.tools.items(), COLORS):
            line = values[label][component]
            scale = 2e3 if component[0] == "t" else 2
            band = [scale * s if k else math.nan for s, k in zip(tool.get("sd_" + component, [math.nan] * len(line)), tool["known"])]
            middle = [0] * len(line) if centred else line
            axis.fill_between(tool["time"], [m - b for m, b in zip(middle, band)], [m + b for m, b in zip(middle, band)], color=color, alpha=0.25, lw=0)
            axis.plot(tool["time"], line, color=color, lw=1, label=label)
            sizes = sorted(abs(v) + b for v, b in zip(line, band) if not math.isnan(v + b))
            limits += sizes[int(0.97 * (len(sizes) - 1)):][:1]   # the first frames, with their wide band, may leave the picture
        if centred and limits:
            axis.set_ylim(-1.2 * max(limits), 1.2 * max(limits))
        axis.set_title("%s %s [%s]" % ("rotation" if component[0] == "r" else "translation", component[1], "rad" if component[0] == "r" else "mm"), fontsize=9)
    axes[0, 0].legend(fontsize=8)
    finish(axes, title)
    save(pyplot, figure, folder, name)


def plotEvidence(pyplot, run, folder):
    rows = [("similarity", "similarity of the parts"), ("contour", "share of the outline with an edge"), ("nis", "NIS per degree of freedom")]
    rows = [row for row in rows if run.columns(row[0])]
    count = len(rows) + 2
    figure, axes = pyplot.subplots(count, 1, figsize=(11, 1.2 + 1.7 * count), sharex=True, squeeze=False)
    names = list(run.tools)
    for i, tool in enumerate(run.tools.values()):
        for state, color in STATES.items():
            times = [t for t, s in zip(tool["time"], tool["status"]) if s == state]
            axes[0, 0].plot(times, [i] * len(times), "s", color=color, ms=7, label=state if i == 0 else None)
    axes[0, 0].set_yticks(range(len(names)))
    axes[0, 0].set_yticklabels(names)
    axes[0, 0].set_ylim(len(names) - 0.4, -0.6)
    axes[0, 0].legend(fontsize=7, ncol=4, loc="lower left", bbox_to_anchor=(0, 1), frameon=False)
    for (name, tool), color in zip(run.tools.items(), COLORS):
        for column, style in (("visible", ":"), ("inliers", "-")):
            if column in tool:
                axes[1, 0].plot(tool["time"], tool[column], style, color=color, lw=1, label="%s, %s" % (name, column))
        for (column, _), axis in zip(rows, axes[2:, 0]):
            axis.plot(tool["time"], tool[column], color=color, lw=1, label=name)
    axes[1, 0].set_ylabel("parts", fontsize=8)
    axes[1, 0].set_ylim(bottom=0)
    axes[1, 0].legend(fontsize=7, ncol=2)
    for (column, label), axis in zip(rows, axes[2:, 0]):
        axis.set_ylabel(label.replace(" of the", "\nof the").replace(" per", "\nper"), fontsize=8)
        axis.set_ylim(0, 1.02 if column != "nis" else None)
    finish(axes, "states and evidence")
    save(pyplot, figure, folder, "evidence.png")


def plotOffsets(pyplot, run, names, folder):
    columns = min(4, len(names))
    lines = -(-len(names) // columns)
    figure, axes = pyplot.subplots(lines, columns, figsize=(1.5 + 3.5 * columns, 0.8 + 2.6 * lines), squeeze=False, sharex=True)
    for axis in axes.flat[len(names):]:
        axis.axis("off")
    for axis, name in zip(axes.flat, names):
        for (label, tool), color in zip(run.tools.items(), COLORS):
            axis.plot(tool["time"], tool[name], color=color, lw=1, label=label)
        axis.set_title(name[len("offset_"):], fontsize=9)
    for line in axes:
        line[0].set_ylabel("offset [rad or m]")
    axes[0, 0].legend(fontsize=7)
    finish(axes, "what is added to the joint readings")
    save(pyplot, figure, folder, "offsets.png")


def plotTimings(pyplot, timings, folder):
    figure, axes = pyplot.subplots(1, 1, figsize=(11, 4), squeeze=False)
    stages = [c for c in timings if c not in ("frame", "time", "total")]
    axes[0, 0].stackplot(timings["time"], [[1e3 * v for v in timings[c]] for c in stages], labels=stages, alpha=0.8, lw=0)
    total = [1e3 * v for v in timings["total"]]
    axes[0, 0].plot(timings["time"], total, color="black", lw=0.7, label="total")
    axes[0, 0].set_ylim(0, 1.3 * sorted(total)[int(0.97 * (len(total) - 1))])   # the first frame may leave the picture
    axes[0, 0].set_ylabel("time of a frame [ms]")
    axes[0, 0].legend(fontsize=8, ncol=len(stages) + 1, loc="upper center")
    finish(axes, "time of the tracker by stage, median %.2f ms" % sorted(total)[len(total) // 2])
    save(pyplot, figure, folder, "timings.png")


def plot(args):
    run = Run(args.poses, args.sequence)
    try:
        import matplotlib
    except ImportError:
        raise DataError("plots need matplotlib (Debian: python3-matplotlib)")
    matplotlib.use("Agg")
    import matplotlib.pyplot as pyplot
    try:
        os.makedirs(args.out, exist_ok=True)
    except OSError as error:
        raise DataError("%s: %s" % (args.out, error.strerror))

    poses = {name: run.poses(tool) for name, tool in run.tools.items()}
    plotComponents(pyplot, run, poses, args.out, "poses.png",
                   "end effector in the camera frame, rotation since the first pose, with bands of 2 standard deviations", False)
    plotEvidence(pyplot, run, args.out)
    offsets = run.columns("offset_")
    if offsets:
        plotOffsets(pyplot, run, offsets, args.out)
    if args.timings:
        plotTimings(pyplot, read(args.timings, ["time", "total"])[""], args.out)
    if run.truth:
        errors = {name: run.errors(name) for name in run.tools}
        plotComponents(pyplot, run, errors, args.out, "errors.png", "errors in the camera frame, and the bands of 2 standard deviations", True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("poses", help="poses file of a run")
    parser.add_argument("--timings", help="timings file of the run")
    parser.add_argument("--sequence", help="its folder with groundtruth.csv, for the errors")
    parser.add_argument("--out", default=".", help="folder for the pictures, default: here")
    args = parser.parse_args()
    try:
        plot(args)
    except DataError as error:
        sys.exit("plot_run.py: %s" % error)


if __name__ == "__main__":
    main()
