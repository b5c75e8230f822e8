#!/usr/bin/env python3
"""Table and plot of how cost grows, from a run of the performance tests:

    opencv_perf_surgtrack --perf_threads=1 --gtest_output=xml:perf.xml
    plot_performance.py perf.xml --png=performance.png [--markdown=performance.md]
"""
import argparse
import sys
import xml.etree.ElementTree


def read(report):
    """[(case, [parameters], median [ms])] of the cases that were run."""
    results = []
    for case in xml.etree.ElementTree.parse(report).iter("testcase"):
        properties = dict(case.attrib)
        for item in case.iter("property"):
            properties[item.get("name")] = item.get("value")
        if "median" not in properties or case.find("failure") is not None:
            continue
        name = properties["classname"].split("/")[-1]
        parameters = [p.strip().strip('"') for p in properties.get("value_param", "").strip("()").split(",")]
        results.append((name, parameters, 1e3 * float(properties["median"]) / float(properties["frequency"])))
    return results


def table(results):
    rows = [[name.replace("_", " "), ", ".join(parameters), "%.3f" % ms] for name, parameters, ms in results]
    header = ["case", "parameters", "median [ms]"]
    widths = [max(len(row[i]) for row in [header] + rows) for i in range(3)]
    lines = ["| " + " | ".join(cell.ljust(width) for cell, width in zip(row, widths)) + " |" for row in [header] + rows]
    lines.insert(1, "|" + "|".join("-" * (width + 2) for width in widths) + "|")
    return "\n".join(lines) + "\n"


def pixels(size):
    width, height = size.split("x")
    return int(width) * int(height) / 1e6


def curve(results, case, x, keep=lambda p: True):
    """Points (x of the parameters, median) of a case, by x."""
    return sorted((x(p), ms) for name, p, ms in results if name == case and keep(p))


def plot(results, filename):
    try:
        import matplotlib
    except ImportError:
        sys.exit("plots need matplotlib (Debian: python3-matplotlib)")
    matplotlib.use("Agg")
    import matplotlib.pyplot as pyplot

    small = "720x576"
    triangles = {"12k": 12e3, "80k": 80e3, "1M": 1e6}
    panels = [
        ("image size [megapixels]", [
            ("update, 1 tool", curve(results, "Size_Tools_Tracker_update", lambda p: pixels(p[0]), lambda p: p[1] == "1")),
            ("update, 2 tools", curve(results, "Size_Tools_Tracker_update", lambda p: pixels(p[0]), lambda p: p[1] == "2")),
            ("orientations, whole colour image", curve(results, "Size_Channels_QGO_quantize", lambda p: pixels(p[0]), lambda p: p[1] == "3")),
            ("blur and Sobel for comparison", curve(results, "Size_Channels_QGO_referenceBlurAndSobel", lambda p: pixels(p[0]), lambda p: p[1] == "3"))]),
        ("tools", [
            ("update, 720 x 576", curve(results, "Size_Tools_Tracker_update", lambda p: int(p[1]), lambda p: p[0] == small)),
            ("templates of one of them", curve(results, "Size_Tools_PartTemplates_render", lambda p: int(p[1]), lambda p: p[0] == small))]),
        ("triangles of the CAD", [
            ("templates of a tool", curve(results, "Size_CAD_PartTemplates_render", lambda p: triangles[p[1]], lambda p: p[0] == small and p[1] in triangles)),
            ("drawing a window", curve(results, "Size_CAD_MeshRenderer_softwareWindow", lambda p: triangles[p[1]], lambda p: p[0] == small and p[1] in triangles))]),
        ("templates of 63 features", [
            ("image and search, whole image", curve(results, "Templates_QGOMatcher_imageAndMatchInTheWholeImage", lambda p: int(p[0])))]),
    ]
    figure, axes = pyplot.subplots(1, len(panels), figsize=(16, 3.8))
    for axis, (label, curves) in zip(axes, panels):
        for name, points in curves:
            if points:
                axis.plot([x for x, _ in points], [ms for _, ms in points], "o-", label=name)
        if "triangles" in label:
            axis.set_xscale("log")
        axis.set_xlabel(label)
        axis.set_ylabel("median [ms]")
        axis.set_ylim(bottom=0)
        axis.grid(alpha=0.3)
        axis.legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(filename, dpi=90)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("report", help="XML report of opencv_perf_surgtrack")
    parser.add_argument("--png", help="plot to write")
    parser.add_argument("--markdown", help="table to write; without, it is printed")
    args = parser.parse_args()
    try:
        results = read(args.report)
    except (OSError, xml.etree.ElementTree.ParseError) as error:
        sys.exit("%s: %s" % (args.report, error))
    if not results:
        sys.exit("%s: no results of performance tests" % args.report)
    if args.markdown:
        with open(args.markdown, "w") as out:
            out.write(table(results))
    else:
        sys.stdout.write(table(results))
    if args.png:
        plot(results, args.png)


if __name__ == "__main__":
    main()
