#!/usr/bin/env python3
"""Plots of an evaluation, beside its CSV files:

    example_surgtrack_evaluate --sequences=DIR[,DIR...] --out=OUT
    plot_evaluation.py OUT
"""
import argparse
import csv
import math
import os
import sys

TITLES = {"full-stereo": "full, stereo"}
COLORS = {"full": "tab:green", "full-stereo": "tab:olive", "paper": "tab:blue", "epnp": "tab:orange", "reiter2014": "tab:red", "reiter2012": "tab:purple", "contour": "tab:cyan", "rapid": "tab:brown", "recorded": "0.45", "frozen": "0.75"}
CONTROLS = ("recorded", "frozen")
VARIANTS = [("raw", "templates drawn with the raw hand-eye"), ("tracked", "templates drawn as tracked")]
CLASS_VARIANTS = ["image", "window"]
DETECTORS = {"qgo": ("-", "o"), "gradboost": ("--", "s"), "forest": (":", "^")}
# What holds 95 % of a chi-square variable with 6 degrees of freedom.
NEES_BAND = (1.237344, 14.449375)


class DataError(Exception):
    """A file that is not as expected; the text is the line the user gets."""


def read(folder, name, columns, numbers, empty=False):
    """Rows of a CSV file as dictionaries; cells of the columns in numbers as floats, NaN where there is nothing."""
    filename = os.path.join(folder, name)
    try:
        with open(filename, newline="") as file:
            reader = csv.DictReader(file)
            header = reader.fieldnames or []
            for column in columns:
                if column not in header:
                    raise DataError("%s: expected a column '%s'" % (filename, column))
            rows = list(reader)
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise DataError("%s: %s" % (filename, getattr(error, "strerror", None) or error))
    if not rows and not empty:
        raise DataError("%s: expected lines after the first" % filename)
    for line, row in enumerate(rows, 2):
        for column in columns:
            if row[column] is None:
                raise DataError("%s, line %d: has fewer columns than line 1" % (filename, line))
        for column in numbers:
            try:
                row[column] = float(row[column]) if row[column] else math.nan
            except ValueError:
                raise DataError("%s, line %d: %s is '%s', expected a number" % (filename, line, column, row[column]))
    return rows


class Evaluation:
    """All files of an evaluation."""

    COMPONENTS = ["rx", "ry", "rz", "tx", "ty", "tz"]

    def __init__(self, folder):
        if not os.path.isdir(folder):
            raise DataError("%s: there is no such folder" % folder)
        self.folder = folder
        scores = ["translation_mean_mm", "translation_std_mm", "rotation_mean_rad", "rotation_std_rad"]
        table = read(folder, "table.csv", ["sequence", "tool", "method", "frames"] + scores, scores)
        self.scores = [row for row in table if row["tool"] == "all"]
        rates = ["threshold_px", "top_n", "rate", "samples"]
        detection = read(folder, "detection.csv", ["sequence", "variant", "part"] + rates, rates)
        self.detection = [row for row in detection if row["variant"] in [variant for variant, _ in VARIANTS]]
        self.classes = [row for row in detection if row["variant"] in CLASS_VARIANTS and row["part"] == "all"]   # with baselines
        axes = ["mean_abs", "std_abs"]
        self.axes = read(folder, "rotation_axes.csv", ["sequence", "method", "axis"] + axes, axes)
        self.sequences = unique(row["sequence"] for row in self.scores)
        self.methods = unique(row["method"] for row in self.scores)
        errors = ["error_" + c for c in self.COMPONENTS] + ["sigma_" + c for c in self.COMPONENTS]
        numbers = ["time", "nees"] + errors
        share = ["threshold_percent", "pck"]
        self.pck = read(folder, "pck.csv", ["sequence", "method"] + share, share, empty=True)
        self.frames = {}
        for row in self.scores:
            if row["sequence"] != "all" and row["method"] not in CONTROLS and row["frames"] != "0":     # 0: there are labels only
                name = "frames_%s_%s.csv" % (row["sequence"], row["method"])
                self.frames[row["sequence"], row["method"]] = read(folder, name, ["tool", "state"] + numbers, numbers)

    def withOffsets(self, sequence):
        """The first method that estimates joint offsets, its frames with a pose, and the coordinates it does so for; or nothing."""
        for method in self.methods:
            rows = [row for row in self.frames.get((sequence, method), []) if row["state"] in ("tracking", "coasting")]
            names = [column[len("offset_"):] for column in (rows[0] if rows else []) if column.startswith("offset_")]
            names = [name for name in names if any(row["offset_" + name] not in ("", "0") for row in rows)]
            if names:
                return method, rows, names
        return None

    def withCovariance(self, sequence):
        """Methods with a covariance, and their frames with a pose."""
        result = []
        for method in self.methods:
            rows = [row for row in self.frames.get((sequence, method), []) if row["state"] in ("tracking", "coasting")]
            if any(not math.isnan(row["nees"]) for row in rows):
                result.append((method, rows))
        return result


def unique(values):
    return list(dict.fromkeys(values))


def title(method):
    return TITLES.get(method, method)


def save(pyplot, figure, folder, name):
    filename = os.path.join(folder, name)
    try:
        figure.savefig(filename, dpi=90)
    except OSError as error:
        raise DataError("%s: %s" % (filename, error.strerror or error))
    pyplot.close(figure)
    print(filename)


def bars(axis, groups, methods, values, deviations):
    """Grouped bars; values and deviations by (group, method), those that are missing are left out."""
    width = 0.8 / max(1, len(methods))
    for i, method in enumerate(methods):
        for j, group in enumerate(groups):
            value = values.get((group, method), math.nan)
            if math.isnan(value):
                continue
            deviation = deviations[group, method]
            axis.bar(j + (i - (len(methods) - 1) / 2) * width, value, width, yerr=[[min(deviation, value)], [deviation]], color=COLORS.get(method),
                     error_kw={"elinewidth": 0.7, "capsize": 1.5}, label=title(method))
    axis.set_xticks(range(len(groups)))
    axis.grid(axis="y", alpha=0.3)


def legend(axis, **options):
    """A legend with each label once."""
    handles = {}
    for handle, label in zip(*axis.get_legend_handles_labels()):
        handles.setdefault(label, handle)
    if handles:
        axis.legend(handles.values(), handles.keys(), **options)


def plotScores(pyplot, evaluation):
    figure, axes = pyplot.subplots(2, 1, figsize=(3 + 1.8 * len(evaluation.sequences), 8), squeeze=False)
    for axis, name, unit in zip(axes[:, 0], ("translation", "rotation"), ("mm", "rad")):
        values, deviations = {}, {}
        for row in evaluation.scores:
            values[row["sequence"], row["method"]] = row["%s_mean_%s" % (name, unit)]
            deviations[row["sequence"], row["method"]] = row["%s_std_%s" % (name, unit)]
        bars(axis, evaluation.sequences, evaluation.methods, values, deviations)
        known = [v for v in values.values() if v > 1e-6]   # the control of the first frame alone is exact
        if known:
            # The methods differ by factors.
            axis.set_yscale("log")
            axis.set_ylim(bottom=min(known) / 3)
        axis.set_xticklabels(evaluation.sequences, rotation=10)
        axis.set_ylabel("%s error [%s], mean and std" % (name, unit))
    legend(axes[0, 0], ncol=len(evaluation.methods), fontsize=8, loc="lower center", bbox_to_anchor=(0.5, 1))
    figure.tight_layout()
    save(pyplot, figure, evaluation.folder, "table.png")


def plotDetection(pyplot, evaluation):
    figure, axes = pyplot.subplots(1, len(VARIANTS), figsize=(11, 4), sharey=True)
    thresholds = sorted({row["threshold_px"] for row in evaluation.detection})
    for axis, (variant, label) in zip(axes, VARIANTS):
        for threshold, color in zip(thresholds, ("tab:red", "tab:blue", "tab:green")):
            for sequence in unique(row["sequence"] for row in evaluation.detection):
                points = sorted((row["top_n"], 100 * row["rate"]) for row in evaluation.detection
                                if (row["sequence"], row["variant"], row["part"], row["threshold_px"]) == (sequence, variant, "all", threshold))
                overall = sequence == "all"
                axis.plot([n for n, _ in points], [rate for _, rate in points], "o-" if overall else "-", color=color, alpha=1 if overall else 0.3,
                          lw=2 if overall else 1, label="within %g px" % threshold if overall else None)
        axis.set_title(label, fontsize=10)
        axis.set_xlabel("best N candidates of a part")
        axis.set_xticks(sorted({row["top_n"] for row in evaluation.detection}))
        axis.grid(alpha=0.3)
    axes[0].set_ylabel("detection rate [%]; pale: single sequences")
    axes[-1].legend(fontsize=8)
    figure.tight_layout()
    save(pyplot, figure, evaluation.folder, "detection.png")


def plotClasses(pyplot, evaluation):
    """The paper's Fig. 3 a-b: a panel a sequence, a colour a threshold, solid ours and dashed the others; below in windows."""
    rows = evaluation.classes
    sequences = [name for name in unique(row["sequence"] for row in rows) if name != "all"] or ["all"]
    variants = [variant for variant in CLASS_VARIANTS if any(row["variant"] == variant for row in rows)]
    figure, axes = pyplot.subplots(len(variants), len(sequences), squeeze=False, sharex=True, sharey=True,
                                   figsize=(2.5 + 3.2 * len(sequences), 0.8 + 2.9 * len(variants)))
    thresholds = sorted({row["threshold_px"] for row in rows})
    for line, variant in zip(axes, variants):
        for axis, sequence in zip(line, sequences):
            for detector in unique(row["detector"] for row in rows):
                style, marker = DETECTORS.get(detector, ("-.", "x"))
                for threshold, color in zip(thresholds, ("tab:red", "tab:blue", "tab:green")):
                    points = sorted((row["top_n"], 100 * row["rate"]) for row in rows
                                    if (row["sequence"], row["variant"], row["detector"], row["threshold_px"]) == (sequence, variant, detector, threshold))
                    axis.plot([n for n, _ in points], [rate for _, rate in points], style, marker=marker, ms=3, color=color,
                              label="%s, %g px" % (detector, threshold) if points else None)
            axis.set_title("%s, %s" % (sequence, {"image": "whole image", "window": "windows of the kinematics"}[variant]), fontsize=9)
            axis.grid(alpha=0.3)
            axis.set_ylim(0, 102)
        line[0].set_ylabel("detection rate [%]")
    for axis in axes[-1]:
        axis.set_xlabel("best N candidates of a class")
        axis.set_xticks(sorted({row["top_n"] for row in rows}))
    handles, labels = axes[-1, 0].get_legend_handles_labels()
    figure.tight_layout(rect=(0, 0.1 if len(variants) > 1 else 0.17, 1, 1))
    figure.legend(handles, labels, loc="lower center", fontsize=7, ncol=max(1, len(labels) // len(thresholds)))
    save(pyplot, figure, evaluation.folder, "detection_classes.png")


def plotDetectionOfParts(pyplot, evaluation):
    rows = [row for row in evaluation.detection if row["sequence"] == "all"]
    parts = unique(row["part"] for row in rows)
    thresholds = sorted({row["threshold_px"] for row in rows})
    counts = sorted({row["top_n"] for row in rows})
    samples = {(row["variant"], row["part"]): row["samples"] for row in rows}
    figure, axes = pyplot.subplots(len(VARIANTS), len(thresholds), squeeze=False,
                                   figsize=(4 + 2.6 * len(thresholds), 1.2 + 0.27 * len(VARIANTS) * (len(parts) + 2)))
    lowest = min([100 * row["rate"] for row in rows if not math.isnan(row["rate"])] or [0])
    for i, (variant, label) in enumerate(VARIANTS):
        for axis, threshold in zip(axes[i], thresholds):
            rates = {(row["part"], row["top_n"]): 100 * row["rate"] for row in rows if (row["variant"], row["threshold_px"]) == (variant, threshold)}
            table = [[rates.get((part, n), math.nan) for n in counts] for part in parts]
            axis.imshow(table, vmin=min(lowest, 99), vmax=100, cmap="RdYlGn", alpha=0.6, aspect="auto")
            for y, line in enumerate(table):
                for x, rate in enumerate(line):
                    axis.text(x, y, "" if math.isnan(rate) else "%.1f" % rate, ha="center", va="center", fontsize=6)
            axis.set_xticks(range(len(counts)))
            axis.set_xticklabels(["%g" % n for n in counts], fontsize=7)
            axis.set_yticks(range(len(parts)))
            axis.set_yticklabels([])
            axis.set_title("%s, within %g px" % (label.replace("templates drawn ", ""), threshold), fontsize=8)
        axes[i][0].set_yticklabels(["%s (%d)" % (part, samples.get((variant, part), 0)) for part in parts], fontsize=7)
    for axis in axes[-1]:
        axis.set_xlabel("best N candidates", fontsize=8)
    figure.suptitle("detection rate [%] by part, all sequences (samples)", fontsize=10)
    figure.tight_layout()
    save(pyplot, figure, evaluation.folder, "detection_parts.png")


def plotPck(pyplot, evaluation):
    sequences = unique(row["sequence"] for row in evaluation.pck)
    if len(sequences) == 2:     # that of all is the one's
        sequences = sequences[:1]
    figure, axes = pyplot.subplots(1, len(sequences), figsize=(1 + 4 * len(sequences), 4), sharey=True, squeeze=False, constrained_layout=True)
    for axis, sequence in zip(axes[0], sequences):
        for method in unique(row["method"] for row in evaluation.pck):
            rows = [row for row in evaluation.pck if row["sequence"] == sequence and row["method"] == method]
            axis.plot([row["threshold_percent"] for row in rows], [100 * row["pck"] for row in rows], label=title(method), color=COLORS.get(method))
        axis.set_title(sequence)
        axis.set_xlabel("distance [% of the image width]")
        axis.set_ylim(0, 102)
        axis.grid(alpha=0.3)
    axes[0][0].set_ylabel("keypoints within it [%]")
    axes[0][-1].legend(loc="lower right")
    save(pyplot, figure, evaluation.folder, "pck.png")


def plotAxes(pyplot, evaluation):
    sequences = unique(row["sequence"] for row in evaluation.axes)
    columns = min(3, len(sequences))
    lines = -(-len(sequences) // columns)
    figure, axes = pyplot.subplots(lines, columns, figsize=(1 + 4 * columns, 0.5 + 2.8 * lines), squeeze=False, sharey=True)
    for axis in axes.flat[len(sequences):]:
        axis.axis("off")
    for axis, sequence in zip(axes.flat, sequences):
        rows = [row for row in evaluation.axes if row["sequence"] == sequence]
        names = unique(row["axis"] for row in rows)
        values = {(row["axis"], row["method"]): row["mean_abs"] for row in rows}
        deviations = {(row["axis"], row["method"]): row["std_abs"] for row in rows}
        bars(axis, names, evaluation.methods, values, deviations)
        axis.set_xticklabels(names)
        axis.set_title(sequence, fontsize=9)
    for line in axes:
        line[0].set_ylabel("|rotation error| [rad]")
    legend(axes[0, 0], fontsize=7)
    figure.suptitle("rotation error about the axes of the end effector, mean and std", fontsize=10)
    figure.tight_layout()
    save(pyplot, figure, evaluation.folder, "rotation_axes.png")


def plotErrors(pyplot, evaluation, sequence):
    method, rows = evaluation.withCovariance(sequence)[0]
    figure, axes = pyplot.subplots(2, 3, figsize=(14, 6), sharex=True)
    tools = unique(row["tool"] for row in rows)
    for axis, component in zip(axes.flat, Evaluation.COMPONENTS):
        scale = 1e3 if component[0] == "t" else 1
        limit = 0
        for tool, color in zip(tools, ("tab:blue", "tab:orange", "tab:green", "tab:red")):
            ours = [row for row in rows if row["tool"] == tool]
            times = [row["time"] for row in ours]
            errors = [scale * row["error_" + component] for row in ours]
            band = [2 * scale * row["sigma_" + component] for row in ours]
            axis.fill_between(times, [-b for b in band], band, color=color, alpha=0.2, lw=0)
            axis.plot(times, errors, color=color, lw=0.9, label=tool)
            # The first frames, with their wide band, may leave the picture.
            sizes = sorted(max(abs(e), b) for e, b in zip(errors, band) if not math.isnan(b))
            if sizes:
                limit = max(limit, 1.3 * sizes[int(0.98 * (len(sizes) - 1))])
        if limit > 0:
            axis.set_ylim(-limit, limit)
        axis.set_title("%s %s [%s]" % ("rotation" if component[0] == "r" else "translation", component[1], "rad" if scale == 1 else "mm"), fontsize=9)
        axis.grid(alpha=0.3)
    for axis in axes[1]:
        axis.set_xlabel("time [s]")
    axes[0, 0].legend(fontsize=8)
    figure.suptitle("%s, %s: error in the camera frame and the band of 2 standard deviations" % (sequence, title(method)), fontsize=10)
    figure.tight_layout()
    save(pyplot, figure, evaluation.folder, "error_%s.png" % sequence)


def plotOffsets(pyplot, evaluation, sequence):
    method, rows, names = evaluation.withOffsets(sequence)
    columns = min(4, len(names))
    lines = -(-len(names) // columns)
    figure, axes = pyplot.subplots(lines, columns, figsize=(1 + 4 * columns, 0.8 + 2.6 * lines), squeeze=False, sharex=True)
    for axis in axes.flat[len(names):]:
        axis.axis("off")
    for axis, name in zip(axes.flat, names):
        for tool, color in zip(unique(row["tool"] for row in rows), ("tab:blue", "tab:orange", "tab:green", "tab:red")):
            ours = [row for row in rows if row["tool"] == tool]
            for prefix, style in (("offset_", "-"), ("true_offset_", "--")):
                values = [float(row.get(prefix + name) or "nan") for row in ours]
                axis.plot([row["time"] for row in ours], values, style, color=color, lw=1, label="%s%s" % (tool, ", true" if style == "--" else ""))
        axis.set_title(name, fontsize=9)
        axis.grid(alpha=0.3)
    for axis in axes[-1]:
        axis.set_xlabel("time [s]")
    for line in axes:
        line[0].set_ylabel("offset [rad or m]")
    axes[0, 0].legend(fontsize=7)
    figure.suptitle("%s, %s: what is added to the joint readings, and what would have to be" % (sequence, title(method)), fontsize=10)
    figure.tight_layout()
    save(pyplot, figure, evaluation.folder, "offsets_%s.png" % sequence)


def plotNees(pyplot, evaluation, sequence):
    figure, axis = pyplot.subplots(figsize=(11, 4))
    for method, rows in evaluation.withCovariance(sequence):
        for tool, style in zip(unique(row["tool"] for row in rows), ("-", "--", ":", "-.")):
            ours = [row for row in rows if row["tool"] == tool]
            axis.plot([row["time"] for row in ours], [row["nees"] for row in ours], style, color=COLORS.get(method), lw=0.9,
                      label="%s, %s" % (title(method), tool))
    axis.axhspan(*NEES_BAND, color="0.85", label="95 % of the frames of a consistent filter")
    axis.axhline(6, color="0.4", lw=0.8)
    axis.set_yscale("log")
    axis.set_xlabel("time [s]")
    axis.set_ylabel("NEES (expected: 6)")
    axis.set_title(sequence, fontsize=10)
    axis.grid(alpha=0.3)
    axis.legend(fontsize=8, ncol=2)
    figure.tight_layout()
    save(pyplot, figure, evaluation.folder, "nees_%s.png" % sequence)


def plot(evaluation):
    try:
        import matplotlib
    except ImportError:
        raise DataError("plots need matplotlib (Debian: python3-matplotlib)")
    matplotlib.use("Agg")
    import matplotlib.pyplot as pyplot

    plotScores(pyplot, evaluation)
    if any(row["samples"] for row in evaluation.detection):     # where poses are known
        plotDetection(pyplot, evaluation)
        plotDetectionOfParts(pyplot, evaluation)
        if evaluation.classes:
            plotClasses(pyplot, evaluation)
        plotAxes(pyplot, evaluation)
    if evaluation.pck:
        plotPck(pyplot, evaluation)
    for sequence in evaluation.sequences:
        if sequence != "all" and evaluation.withCovariance(sequence):
            plotErrors(pyplot, evaluation, sequence)
            plotNees(pyplot, evaluation, sequence)
        if sequence != "all" and evaluation.withOffsets(sequence):
            plotOffsets(pyplot, evaluation, sequence)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", help="what example_surgtrack_evaluate wrote")
    args = parser.parse_args()
    try:
        plot(Evaluation(args.folder))
    except DataError as error:
        sys.exit("plot_evaluation.py: %s" % error)


if __name__ == "__main__":
    main()
