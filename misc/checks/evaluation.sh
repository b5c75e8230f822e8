# shellcheck shell=bash
# evaluate, plot_evaluation.py. Sourced by misc/test.sh.

# evaluation_sound DIR FRAMES: the files of `evaluate` agree with each other and with what must be so.
evaluation_sound() {
  "$PYTHON" - "$1" "$2" <<'PYTHON'
import csv, math, os, sys
folder, frames = sys.argv[1], int(sys.argv[2])
def read(name):
    return list(csv.DictReader(open(os.path.join(folder, name), newline="")))
def close(a, b, relative):
    return abs(a - b) <= relative * max(abs(a), abs(b), 1e-9)
table = read("table.csv")
assert {r["method"] for r in table} == {"full", "full-stereo", "paper", "epnp", "recorded", "frozen"}, table
sequences = {r["sequence"] for r in table} - {"all"}
assert len(sequences) == 2, sequences
for row in table:
    if row["sequence"] == "all" or row["tool"] != "all":
        continue
    rows = read("frames_%s_%s.csv" % (row["sequence"], row["method"]))
    assert len(rows) == int(row["frames"]) == frames * len({r["tool"] for r in rows}), row
    errors = [float(r["translation_error"]) for r in rows if r["state"] in ("tracking", "coasting", "control")]
    assert close(len(errors) / len(rows), float(row["coverage"]), 1e-5), row   # 1e-5: six digits in the file
    assert not errors or close(1e3 * sum(errors) / len(errors), float(row["translation_mean_mm"]), 2e-5), row   # the same, of both
    for r in rows:
        parts = [float(r["error_" + c]) for c in ("tx", "ty", "tz")]
        assert close(math.sqrt(sum(p * p for p in parts)), float(r["translation_error"]), 1e-4), r   # differences of rounded numbers
        if row["method"] == "frozen" and r["frame"] == "0":
            assert float(r["translation_error"]) < 1e-12 and float(r["rotation_error"]) < 1e-12, r   # exact but for rounding
        assert row["method"] not in ("recorded", "frozen", "epnp") or r["nees"] == "", r
for row in table:   # the rows of all sequences are their means, weighted by the frames with a pose
    if row["sequence"] == "all":
        parts = [r for r in table if r["sequence"] != "all" and r["tool"] == "all" and r["method"] == row["method"]]
        weights = [float(r["coverage"]) * int(r["frames"]) for r in parts]
        if sum(weights) > 0:
            mean = sum(w * float(r["rotation_mean_rad"] or 0) for w, r in zip(weights, parts)) / sum(weights)
            assert close(mean, float(row["rotation_mean_rad"]), 2e-5), row   # six digits in the file
rates = {}
for r in read("detection.csv"):
    if r["rate"]:
        rates[r["sequence"], r["variant"], r["part"], int(r["threshold_px"]), int(r["top_n"])] = float(r["rate"])
assert any(k[2] == "all" for k in rates)
for (s, v, p, t, n), rate in rates.items():
    assert 0 <= rate <= 1
    assert n == 5 or rates[s, v, p, t, n + 1] >= rate, (s, v, p, t, n)   # more candidates, wider circles: no fewer hits
    assert t == 20 or rates[s, v, p, 2 * t, n] >= rate, (s, v, p, t, n)
# Drawn within 14 px of the truth, in clean pictures: fewer would be an error of the bookkeeping.
assert rates["all", "tracked", "all", 10, 5] > 0.9, rates["all", "tracked", "all", 10, 5]
bands = {1: (1.23734, 14.4494), 2: (2.20189, 11.6683)}   # chi-square of 6 and of 12 degrees of freedom, 2.5 and 97.5 %, from tables
checked = 0
for r in read("consistency.csv"):
    assert r["method"] != "epnp" or r["mean"] == "", r
    if r["quantity"] == "nees" and int(r["runs"]) in bands:
        low, high = bands[int(r["runs"])]
        assert close(float(r["band_low"]), low, 1e-5) and close(float(r["band_high"]), high, 1e-5), r   # six digits
        checked += 1
assert checked > 0
for r in read("worst.csv"):
    assert os.path.getsize(os.path.join(folder, r["picture"])) > 1000, r
PYTHON
}

# baseline_sound DIR: all rows of the baselines are there; rates rise with N and threshold; poses of others count as ours do.
baseline_sound() {
  "$PYTHON" - "$1" <<'PYTHON'
import csv, os, sys
def read(name):
    return list(csv.DictReader(open(os.path.join(sys.argv[1], name), newline="")))
rates, classes = {}, {}
for r in read("detection.csv"):
    if r["variant"] in ("image", "window"):
        classes.setdefault((r["detector"], r["variant"]), set()).add(r["part"])
        if r["rate"]:
            rates[r["detector"], r["variant"], r["sequence"], r["part"], int(r["threshold_px"]), int(r["top_n"])] = float(r["rate"])
paper = {"logo_pivot", "logo_s", "shaft_pivot", "all"}
for detector in ("qgo", "gradboost"):
    for variant in ("image", "window"):
        assert classes[detector, variant] == paper, classes
assert classes["forest", "window"] > paper and ("forest", "image") not in classes, classes
for key, rate in rates.items():
    t, n = key[-2:]
    assert 0 <= rate <= 1
    assert n == 5 or rates[key[:-1] + (n + 1,)] >= rate, key
    assert t == 20 or rates[key[:-2] + (2 * t, n)] >= rate, key
rows = {r["method"]: r for r in read("table.csv") if r["sequence"] != "all" and r["tool"] == "all"}
assert list(rows) == ["epnp", "reiter2014", "reiter2012", "contour", "theirs", "recorded", "frozen"], list(rows)
assert float(rows["theirs"]["translation_mean_mm"]) < 1e-3 and float(rows["theirs"]["accuracy"]) == 1, rows["theirs"]   # the truth itself; digits of files
assert float(rows["contour"]["translation_mean_mm"]) < float(rows["recorded"]["translation_mean_mm"]), rows   # it starts with the true pose
PYTHON
}

# learns MODELS SECONDS COMMAND...: so many are learnt, the others read from their files, in less time of processors.
learns() {
  local models="$1" seconds="$2" learnt used TIMEFORMAT=%U
  shift 2
  used="$({ time "$@" >/dev/null 2>"$LOGS/stderr"; } 2>&1)" || { cat "$LOGS/stderr"; return 1; }
  learnt="$(grep -c 'learnt in' "$LOGS/stderr" || true)"
  if [[ $learnt -ne $models || ${used%.*} -ge $seconds ]]; then
    echo "expected $models models and less than $seconds s of processors; got $learnt, $used s"
    return 1
  fi
}

# run_baseline WORK: baselines, small, learn from one sequence and are tested with another one; stereo and pair are there.
run_baseline() {
  local work="$1" evaluate="$BUILD_DIR/bin/example_surgtrack_evaluate" poses
  cp -r "$work/pair" "$work/look"
  cp -r "$work/stereo" "$work/learn"
  find "$work/look" "$work/learn" \( -name '*.yaml' -o -name keypoints.csv \) -exec sed -i 's/logo_v_/logo_s_/' {} +   # a part of the paper's
  mkdir "$work/theirs"
  poses="$work/theirs/look.csv"
  # true poses in the form of another program's
  "$PYTHON" -c 'import csv, sys
rows = list(csv.DictReader(open(sys.argv[1])))
names = ["frame", "tool"] + [c for c in ("tx", "ty", "tz", "qx", "qy", "qz", "qw")]
out = csv.writer(sys.stdout)
out.writerow(names)
out.writerows([row[name] for name in names] for row in rows)' "$work/look/groundtruth.csv" >"$poses"
  # shellcheck disable=SC2054
  local options=(--sequences="$work/look" --train="$work/learn" --baselines=gradboost,reiter2014,reiter2012,contour --rounds=20 --trees=10
    --poses="theirs:$work/theirs" --methods=epnp --frames=4)
  sample "evaluate, baselines" learns 3 120 limited "$evaluate" "${options[@]}" --out="$work/baseline"
  sample "their rows" baseline_sound "$work/baseline"
  mkdir "$work/baseline2"
  cp -r "$work/baseline/models" "$work/baseline2"
  sample "evaluate, baselines in parts" learns 0 120 limited "$evaluate" "${options[@]}" --out="$work/baseline2" --part
  sample "evaluate, their tables" limited "$evaluate" "${options[@]}" --out="$work/baseline2" --merge --quiet
  sample "the same files" evaluation_same "$work/baseline" "$work/baseline2"
  if "$PYTHON" -c 'import matplotlib' 2>/dev/null; then
    sample "plots of baselines" limited "$PYTHON" "$REPO/samples/plot_evaluation.py" "$work/baseline"
    sample "the pictures of their report" pictures_there "$work/baseline"
  fi
  sample "refused: learning from what is tested" refuses "$work/pair" "$evaluate" --sequences="$work/pair" --train="$work/pair" \
    --baselines=gradboost --out="$work/leak"
  cp -r "$work/look" "$work/again"
  rm "$work/again"/*.mp4
  sed -i 's|"\(left[^"]*.mp4\)"|"../look/\1"|; s|video: \(left.mp4\)|video: "../look/\1"|' "$work/again/sequence.yaml"
  sample "refused: learning from the video of what is tested" refuses "$work/look" "$evaluate" --sequences="$work/look" --train="$work/again" \
    --baselines=gradboost --out="$work/leak"
  sample "refused: a baseline that learns from nothing" refuses "'--train'" "$evaluate" --sequences="$work/pair" --baselines=gradboost \
    --out="$work/leak"
  sample "refused: nothing is left to learn from" refuses "'--train'" "$evaluate" --sequences="$work/look" --train="$work/again" --leave-out \
    --baselines=gradboost --out="$work/leak"
  sample "refused: no file of poses" refuses "$work/none.csv" "$evaluate" --sequences="$work/pair" --poses="theirs:$work/none.csv" --out="$work/leak"
}

# run_learning WORK: full models of two recordings take less than three minutes of two processors.
run_learning() {
  local data="${SURGTRACK_DATA:-}/sequences"
  if [[ ! -d "$data/paper_rig" || ! -d "$data/exvivo_dual_moved" || ! -d "$data/exvivo_single" ]]; then
    echo "skipped: learning from recorded data"
    return
  fi
  sample "baselines learn in less than three minutes" learns 3 360 timeout -k 10 900 "$BUILD_DIR/bin/example_surgtrack_evaluate" \
    --sequences="$data/exvivo_single" --train="$data/paper_rig,$data/exvivo_dual_moved" --baselines=gradboost,reiter2014,reiter2012 \
    --methods=epnp --frames=1 --out="$1/learning"
}

# evaluation_same A B: two evaluations, byte for byte, but for what depends on the speed of the machine.
evaluation_same() { diff -r -x results -x models -x timings.csv "$1" "$2"; }

# labels_sound LABELS TRUTH: keypoint errors do not depend on whether poses are known; and the measures where they are.
labels_sound() {
  "$PYTHON" - "$1" "$2" <<'PYTHON'
import csv, os, sys
def read(folder, name):
    return list(csv.DictReader(open(os.path.join(folder, name), newline="")))
alone, known = (read(folder, "labels.csv") for folder in sys.argv[1:3])
rows = [row for row in alone if row["sequence"] != "all"]
assert {(r["tool"], r["method"]) for r in rows} == {(t, m) for t in ("PSM1", "PSM2", "all") for m in ("full", "paper", "epnp")}, rows
for row in rows:
    same = [r for r in known if (r["tool"], r["method"], r["labels"]) == (row["tool"], row["method"], row["labels"])]
    assert any(r["mean_px"] == row["mean_px"] for r in same), (row, same)
    # The picture is 720 px wide; six digits in the file.
    assert abs(float(row["mean_px"]) / 7.2 - float(row["mean_percent"])) < 1e-4 * float(row["mean_percent"]), row
full = [r for r in rows if r["method"] == "full" and r["tool"] == "all"][0]
assert float(full["mean_px"]) < 5 and float(full["coverage"]) > 0.9, full   # clean pictures: a pixel or two
curves = {}
for r in read(sys.argv[1], "pck.csv"):
    curves.setdefault((r["sequence"], r["method"]), []).append(float(r["pck"]))
assert all(c == sorted(c) and 0 <= c[0] and c[-1] <= 1 for c in curves.values())
assert not read(sys.argv[1], "measures.csv")
measures = {(r["sequence"], r["method"]): r for r in read(sys.argv[2], "measures.csv")}
assert float(measures["all", "full"]["pose_5mm_5deg"]) > 0.9 and float(measures["all", "full"]["add_10_percent"]) > 0.9, measures
PYTHON
}

# pictures_there DIR: all that report.md shows.
pictures_there() {
  local name
  while read -r name; do
    if [[ ! -s "$1/$name" ]]; then
      echo "report.md shows $name, which is not there"
      return 1
    fi
  done < <(sed -nE 's/^!\[\]\((.*)\)$/\1/p' "$1/report.md")
}

run_evaluation() {
  local work="$1" evaluate="$BUILD_DIR/bin/example_surgtrack_evaluate" make="$BUILD_DIR/bin/example_surgtrack_make_sequence"
  local plot=("$PYTHON" "$REPO/samples/plot_evaluation.py") frames=8
  sample "make_sequence, stereo" limited "$make" --out="$work/stereo" --frames="$frames" --stereo --distortion --seed=5
  sample "make_sequence, two tools" limited "$make" --out="$work/pair" --frames="$frames" --tools=2 --seed=6
  rm "$work/stereo/keypoints.csv"   # true image points then come from the true joints
  sample "evaluate" limited "$evaluate" --sequences="$work/stereo,$work/pair" --out="$work/evaluation" --stereo --quiet
  sample "its files" evaluation_sound "$work/evaluation" "$frames"
  sample "evaluate, again" limited "$evaluate" --sequences="$work/stereo,$work/pair" --out="$work/evaluation2" --stereo --quiet
  sample "the same files" evaluation_same "$work/evaluation" "$work/evaluation2"
  run_baseline "$work"
  run_learning "$work"
  if "$PYTHON" -c 'import matplotlib' 2>/dev/null; then
    sample "plot_evaluation.py" limited "${plot[@]}" "$work/evaluation"
    sample "its pictures" pictures_there "$work/evaluation"
  else
    echo "skipped: the plots of plot_evaluation.py, which need matplotlib"
  fi
  cp -r "$work/pair" "$work/untrue"
  rm "$work/untrue/groundtruth.csv"
  sample "evaluate, labels only" limited "$evaluate" --sequences="$work/untrue" --out="$work/labels" --quiet
  sample "their errors" labels_sound "$work/labels" "$work/evaluation"
  if "$PYTHON" -c 'import matplotlib' 2>/dev/null; then
    sample "plot_evaluation.py, labels only" limited "${plot[@]}" "$work/labels"
    sample "the curves" test -s "$work/labels/pck.png"
  fi
  rm "$work/untrue/keypoints.csv"
  sample "refused: no ground truth" refuses "$work/untrue/groundtruth.csv" "$evaluate" --sequences="$work/untrue" --out="$work/untold"
  sample "refused: one of two sequences" refuses "$work/untrue/groundtruth.csv" "$evaluate" --sequences="$work/untrue,$work/pair" \
    --methods=paper --frames=2 --out="$work/half" --quiet
  sample "the other one's table" grep -q '^| all | paper | 4 |' "$work/half/table.md"
  sample "refused: no such method" refuses "'none'" "$evaluate" --sequences="$work/pair" --out="$work/never" --methods=none
  sample "refused: stereo without the method for it" refuses stereo "$evaluate" --sequences="$work/pair" --out="$work/never" \
    --methods=paper --stereo
  sample "refused: output is a file" refuses "$work/pair/sequence.yaml" "$evaluate" --sequences="$work/pair" --out="$work/pair/sequence.yaml"
  sample "refused: plots of a folder that is not there" refuses "$work/never" "${plot[@]}" "$work/never"
  rm "$work/evaluation2/detection.csv"
  sample "refused: plots without a file" refuses "$work/evaluation2/detection.csv" "${plot[@]}" "$work/evaluation2"
  sed -i 's/rotation_std_rad/r/' "$work/evaluation2/table.csv"
  sample "refused: plots without a column" refuses "'rotation_std_rad'" "${plot[@]}" "$work/evaluation2"
}
