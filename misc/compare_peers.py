#!/usr/bin/env python3
"""The table of compare_peers.sh: medians and ratios from the XML report of opencv_perf_surgtrack.

usage: compare_peers.py --filter                  prints the gtest filter of the cases that are compared
       compare_peers.py REPORT.xml OUT.md OUT.csv
"""
import csv
import sys
import xml.etree.ElementTree

# What is done, our case, the peer's name and case.
PAIRS = [
    ("quantised orientations", "Size_Channels_QGO_quantize", "GaussianBlur 7x7 + Sobel x, y", "Size_Channels_QGO_referenceBlurAndSobel"),
    ("image stage + 28 templates of 63 features", "Size_Peers_matchingOurs", "cv::linemod, T = {4}, its best threshold",
     "Size_Peers_matchingLinemod"),
    ("image stage + 28 templates of 63 features", "Size_Peers_matchingOurs", "cv::linemod, T = {4}, default threshold",
     "Size_Peers_matchingLinemodDefaultThreshold"),
    ("one frame, one tool (not the same job)", "Size_Peers_trackingOurs", "cv::rapid, 100 lines, at most 5 iterations",
     "Size_Peers_trackingRapid"),
]


def test_filter():
    return ":".join(sorted({"*%s.*" % name for _, ours, _, peer in PAIRS for name in (ours, peer)}))


def read(report):
    """{(case, number of its parameters): properties} of the cases that were run."""
    results = {}
    for case in xml.etree.ElementTree.parse(report).iter("testcase"):
        properties = dict(case.attrib)
        for item in case.iter("property"):
            properties[item.get("name")] = item.get("value")
        if case.find("failure") is not None:
            sys.exit("%s: failed" % properties["name"])
        if "median" not in properties:
            continue
        results[properties["classname"].split("/")[-1], int(properties["name"].split("/")[-1])] = properties
    return results


def milliseconds(properties, which="median"):
    return 1e3 * float(properties[which]) / float(properties["frequency"])


def evidence(properties):
    return "; ".join("%s %s" % (key, properties[key]) for key in ("recall", "error") if key in properties)


def main():
    if sys.argv[1:] == ["--filter"]:
        print(test_filter())
        return
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    results = read(sys.argv[1])
    rows = []
    for job, ours, peer_name, peer in PAIRS:
        cases = sorted(index for name, index in results if name == peer and (ours, index) in results)
        if not cases:
            sys.exit("%s: no results of %s and %s" % (sys.argv[1], ours, peer))
        for index in cases:
            a, b = results[ours, index], results[peer, index]
            parameters = a["value_param"].strip("()").replace(", 1", ", grey").replace(", 3", ", colour")
            rows.append([job, parameters, peer_name, "%.2f" % milliseconds(a), "%.2f" % milliseconds(b),
                         "%.2f" % (milliseconds(b) / milliseconds(a)), "%.2f" % (milliseconds(b, "min") / milliseconds(a, "min")), evidence(a), evidence(b)])
    header = ["job", "image", "peer", "ours [ms]", "peer [ms]", "peer / ours", "of the minima", "ours found", "peer found"]
    with open(sys.argv[3], "w", newline="") as out:
        csv.writer(out).writerows([header] + rows)
    widths = [max(len(row[i]) for row in [header] + rows) for i in range(len(header))]
    lines = ["| " + " | ".join(cell.ljust(width) for cell, width in zip(row, widths)) + " |" for row in [header] + rows]
    lines.insert(1, "|" + "|".join("-" * (width + 2) for width in widths) + "|")
    text = "\n".join(lines) + "\n"
    with open(sys.argv[2], "w") as out:
        out.write(text)
    sys.stdout.write(text)


if __name__ == "__main__":
    main()
