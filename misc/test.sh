#!/usr/bin/env bash
# Builds the module within OpenCV and runs all its tests.

set -euo pipefail

usage() {
  cat <<'TEXT'
usage: misc/test.sh [--help]

Installs what is missing (apt), gets OpenCV's source, builds the module and runs its C++ tests, Python tests, performance
tests (once each, as a check that they run) and samples. Needs no display. The last line is `N passed, N failed`; the exit
code is 0 if nothing failed.

environment:
  BUILD_DIR       build folder, kept for the next run (default: build/ in the repository)
  OPENCV_SOURCE   OpenCV source tree, 4.6 or newer (default: the distribution's source package, else a git clone of 4.x)
  SURGTRACK_DATA  folder with tools/ and sequences/ for the tests on recorded data (without it they are skipped)
  JOBS            parallel compilations (default: number of processors)
  CCACHE_DIR      as ever
TEXT
}

case "${1:-}" in
  '') ;;
  -h | --help) usage; exit 0 ;;
  *) usage >&2; exit 1 ;;
esac

# shellcheck source=misc/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

passed=0
failed=0
skipped=0
failures=()

# count NAME PASSED FAILED SKIPPED
count() {
  echo "$1: $2 passed, $3 failed, $4 skipped"
  passed=$((passed + $2))
  failed=$((failed + $3))
  skipped=$((skipped + $4))
  [[ "$3" -eq 0 ]] || failures+=("$1")
}

occurrences() { grep -a -c -e "$1" "$2" || true; }

# run_gtest NAME LOG COMMAND...: a test that started and did not end (a crash, a time-out) counts as failed.
run_gtest() {
  local name="$1" log="$2" code=0 started ended skips
  shift 2
  timeout -k 10 1800 "$@" 2>&1 | tee "$log" || code=$?
  started="$(occurrences '\[ RUN      \]' "$log")"
  ended="$(occurrences '\[       OK \]' "$log")"
  skips="$(occurrences '\[     SKIP \]' "$log")"
  ((skips <= ended)) || skips=$ended
  local bad=$((started - ended))
  if ((bad == 0 && (code != 0 || started == 0))); then
    echo "$name: exit code $code after $started tests" >&2
    bad=1
  fi
  count "$name" $((ended - skips)) "$bad" "$skips"
}

# run_unittest NAME LOG COMMAND...
run_unittest() {
  local name="$1" log="$2" code=0 ran bad=0 skips number
  shift 2
  timeout -k 10 900 "$@" 2>&1 | tee "$log" || code=$?
  ran="$(sed -nE 's/^Ran ([0-9]+) tests? in .*/\1/p' "$log" | tail -n 1)"
  ran="${ran:-0}"
  for number in $(grep -a -E '^FAILED \(' "$log" | tail -n 1 | grep -oE '(failures|errors|unexpected successes)=[0-9]+' |
    grep -oE '[0-9]+' || true); do
    bad=$((bad + number))
  done
  skips="$(grep -a -E '^(OK|FAILED) \(' "$log" | tail -n 1 | grep -oE 'skipped=[0-9]+' | grep -oE '[0-9]+' || true)"
  skips="${skips:-0}"
  if ((ran == 0 || (bad == 0 && code != 0))); then
    echo "$name: exit code $code after $ran tests" >&2
    bad=$((bad + 1))
    ran=$((ran + 1))
  fi
  count "$name" $((ran > bad + skips ? ran - bad - skips : 0)) "$bad" "$skips"
}

sample_passed=0
sample_failed=0

limited() { timeout -k 10 300 "$@"; }

# sample NAME COMMAND...: the command must succeed.
sample() {
  local name="$1"
  shift
  if "$@" >"$LOGS/sample.log" 2>&1; then
    echo "ok      $name"
    sample_passed=$((sample_passed + 1))
  else
    cat "$LOGS/sample.log"
    echo "FAILED  $name"
    sample_failed=$((sample_failed + 1))
  fi
}

# refuses WORD COMMAND...: exit code 1 and one line on stderr that holds WORD.
refuses() {
  local word="$1" code=0
  shift
  limited "$@" >/dev/null 2>"$LOGS/stderr" || code=$?
  if [[ $code -ne 1 || $(wc -l <"$LOGS/stderr") -ne 1 ]] || ! grep -q -i -F -e "$word" "$LOGS/stderr"; then
    echo "expected exit code 1 and one line with '$word' on stderr; got exit code $code and:"
    cat "$LOGS/stderr"
    return 1
  fi
}

# poses_complete CSV FRAMES: the header of the format, and the same number of rows (one a tool) for every frame.
poses_complete() {
  awk -F, -v frames="$2" '
    NR == 1 { header = ($0 ~ /^frame,time,tool,status,tx,ty,tz,qx,qy,qz,qw(,|\r?$)/); next }
    { rows[$1]++; n++ }
    tolower($0) ~ /(^|,)[-+]?(nan|inf)/ || $4 !~ /^(initializing|tracking|coasting|lost)$/ { bad = 1 }
    END {
      for (f in rows) { distinct++; if (rows[f] * frames != n) bad = 1 }
      if (!header || bad || distinct != frames) { print "header " header ", " n " rows, " distinct " frames"; exit 1 }
    }' "$1"
}

# columns_sound CSV METHOD: the further columns, and what the method has to say in them.
columns_sound() {
  "$PYTHON" - "$1" "$2" <<'PYTHON'
import csv, sys
rows, method = list(csv.DictReader(open(sys.argv[1], newline=""))), sys.argv[2]
deviations = ["sd_" + c for c in ("rx", "ry", "rz", "tx", "ty", "tz")]
offsets = ["offset_" + c for c in ("q1", "q2", "q3", "q4", "q5", "q6", "jaw")]
assert list(rows[0])[11:] == ["visible", "inliers", "similarity", "contour", "nis"] + deviations + offsets, list(rows[0])
tracked = [r for r in rows if r["status"] == "tracking"]
assert tracked, "nothing was tracked"
for r in tracked:
    assert int(r["visible"]) > 0 and 0 <= float(r["similarity"]) <= 1, r
    assert (0 < float(r["contour"]) <= 1) if method == "full" else float(r["contour"]) == 0, r
    for name in deviations:   # a method without a covariance leaves them empty
        assert r[name] == "" if method == "epnp" else 0 < float(r[name]) < 0.1, (name, r)   # 0.1: more than the calibration's own
    assert any(float(r[name]) != 0 for name in offsets) == (method == "full"), r
PYTHON
}

# second_eye_helps STEREO_CSV MONO_CSV: the depth is known better, by the filter's own word, at the end.
second_eye_helps() {
  "$PYTHON" - "$1" "$2" <<'PYTHON'
import csv, sys
stereo, mono = (list(csv.DictReader(open(name, newline="")))[-1] for name in sys.argv[1:3])
assert stereo["status"] == mono["status"] == "tracking", (stereo, mono)
assert float(stereo["sd_tz"]) < float(mono["sd_tz"]), (stereo["sd_tz"], mono["sd_tz"])
PYTHON
}

video_readable() {
  python_cv2 -c '
import sys, cv2
v = cv2.VideoCapture(sys.argv[1])
n = 0
while v.read()[0]:
    n += 1
assert n == int(sys.argv[2]), "%d frames" % n' "$1" "$2"
}

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

# evaluation_same A B: two evaluations, but for what depends on the speed of the machine.
evaluation_same() {
  local file name
  for file in "$1"/*.csv "$1"/worst_*.png; do
    name="$(basename "$file")"
    if [[ "$name" == table.csv ]]; then
      cmp <(cut -d, -f1-11 "$file") <(cut -d, -f1-11 "$2/$name") || return 1
    else
      cmp "$file" "$2/$name" || return 1
    fi
  done
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
  if "$PYTHON" -c 'import matplotlib' 2>/dev/null; then
    sample "plot_evaluation.py" limited "${plot[@]}" "$work/evaluation"
    sample "its pictures" pictures_there "$work/evaluation"
  else
    echo "skipped: the plots of plot_evaluation.py, which need matplotlib"
  fi
  cp -r "$work/pair" "$work/untrue"
  rm "$work/untrue/groundtruth.csv"
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

# The sequence of two eyes is that of run_evaluation: 8 frames.
run_stereo() {
  local work="$1" track="$BUILD_DIR/bin/example_surgtrack_track_sequence" make="$BUILD_DIR/bin/example_surgtrack_make_sequence"
  local python=(env PYTHONDONTWRITEBYTECODE=1 "PYTHONPATH=$BUILD_DIR/python_loader" "$PYTHON" "$REPO/samples/track_sequence.py")
  sample "track_sequence, two eyes" limited "$track" --sequence="$work/stereo" --stereo --poses="$work/eyes.csv" --quiet
  sample "its poses file" poses_complete "$work/eyes.csv" 8
  sample "its further columns" columns_sound "$work/eyes.csv" full
  sample "track_sequence, one of them" limited "$track" --sequence="$work/stereo" --poses="$work/eye.csv" --quiet
  sample "the other one helps" second_eye_helps "$work/eyes.csv" "$work/eye.csv"
  sample "track_sequence.py, two eyes" limited "${python[@]}" --sequence="$work/stereo" --stereo --poses="$work/eyes-python.csv" --quiet
  sample "the same poses file" cmp "$work/eyes.csv" "$work/eyes-python.csv"
  sample "track_sequence, two eyes, drawn ahead" limited "$track" --sequence="$work/stereo" --stereo --render-ahead \
    --poses="$work/eyes-ahead.csv" --video="$work/eyes.mp4" --quiet
  sample "its poses file" poses_complete "$work/eyes-ahead.csv" 8
  sample "its video" video_readable "$work/eyes.mp4" 8

  sample "refused: two eyes without the method for it" refuses "--method=full" "$track" --sequence="$work/stereo" --stereo --method=paper
  sample "refused: two eyes of a sequence with one" refuses "right_T_left" "$track" --sequence="$work/sequence" --stereo
  sample "make_sequence, a shorter one" limited "$make" --out="$work/short" --frames=5 --stereo --distortion --seed=5
  cp -r "$work/stereo" "$work/right-ends"
  cp "$work/short/right.mp4" "$work/right-ends/right.mp4"
  sample "refused: the right video ends early" refuses "right.mp4: ends after 5 frames" "$track" --sequence="$work/right-ends" --stereo --quiet
  rm "$work/right-ends/groundtruth.csv"
  sample "refused: the same, not told by the truth" refuses "right.mp4: ends after 5 frames" "$track" --sequence="$work/right-ends" \
    --stereo --quiet --poses="$work/right-ends.csv"
  sample "what was tracked until then" poses_complete "$work/right-ends.csv" 5
  sample "refused: the same in Python" refuses "right.mp4: ends after 5 frames" "${python[@]}" --sequence="$work/right-ends" --stereo --quiet
  sample "refused: two eyes of a sequence with one, in Python" refuses "right_T_left" "${python[@]}" --sequence="$work/sequence" --stereo
  sample "refused: two eyes without the method for it, in Python" refuses "--method=full" "${python[@]}" --sequence="$work/stereo" \
    --stereo --method=epnp
  cp -r "$work/stereo" "$work/left-ends"
  rm "$work/left-ends/groundtruth.csv"
  cp "$work/short/left.mp4" "$work/left-ends/left.mp4"
  sample "refused: the left video ends early" refuses "left.mp4: ends after 5 frames" "$track" --sequence="$work/left-ends" --stereo --quiet
  sample "track_sequence, only the shorter one" limited "$track" --sequence="$work/left-ends" --quiet
  rm "$work/left-ends/right.mp4"
  sample "refused: no right video" refuses "right.mp4" "$track" --sequence="$work/left-ends" --stereo --quiet
}

# The loopback tests, and the commands of doc/live.md as they stand there.
run_live() {
  local work="$1" live="$BUILD_DIR/bin/example_surgtrack_live" sender="$REPO/samples/send_joints.py"
  local python=(env "SURGTRACK_BIN=$BUILD_DIR/bin" "PYTHONPATH=$BUILD_DIR/python_loader" PYTHONDONTWRITEBYTECODE=1 "$PYTHON")
  run_unittest "Python tests, live" "$LOGS/test-live.log" "${python[@]}" "$REPO/misc/python/test/test_live.py"
  run_unittest "Python tests, ROS node" "$LOGS/test-ros2-node.log" "${python[@]}" "$REPO/misc/python/test/test_ros2_node.py"
  sample "commands of doc/live.md" documented_live "$work"
  sample "their poses" poses_complete "$work/live-doc/poses.csv" 100
  sample "refused: live without a sequence" refuses --sequence "$live"
  sample "refused: joints without kinematics" refuses "$work/none/kinematics.csv" "$PYTHON" "$sender" --sequence="$work/none"
  sample "refused: joints to nowhere" refuses "--to=nowhere" "$PYTHON" "$sender" --sequence="$work/sequence" --to=nowhere
}

# documented_live WORK: the commands of doc/live.md that end by themselves, pasted into a shell in an empty folder. They find the
# programs, samples and bindings where README says they are.
documented_live() {
  local work="$1/live-doc"
  rm -rf "$work"
  mkdir "$work"
  ln -s "$BUILD_DIR" "$work/build"
  ln -s "$REPO/samples" "$work/samples"
  # shellcheck disable=SC2016
  sed -n '/^```bash$/,/^```$/p' "$REPO/doc/live.md" | grep -v '^```' >"$work/commands.sh"
  [[ -s "$work/commands.sh" ]] || return 1
  (cd "$work" && limited bash -e commands.sh)
}

run_samples() {
  local work="$BUILD_DIR/test-samples" frames=12
  local track="$BUILD_DIR/bin/example_surgtrack_track_sequence" make="$BUILD_DIR/bin/example_surgtrack_make_sequence"
  rm -rf "$work"
  mkdir "$work"
  sample "make_sequence" limited "$make" --out="$work/sequence" --frames="$frames" --seed=3
  sample "make_sequence, two tools, another size" limited "$make" --out="$work/two" --frames=4 --tools=2 --width=642 --height=478
  sample "track_sequence on a sequence" limited "$track" --sequence="$work/sequence" --poses="$work/poses.csv" \
    --video="$work/overlay.mp4" --frames="$frames" --quiet
  sample "its poses file" poses_complete "$work/poses.csv" "$frames"
  sample "its further columns" columns_sound "$work/poses.csv" full
  sample "its video" video_readable "$work/overlay.mp4" "$frames"
  sample "track_sequence on the built-in sequence" limited env -C "$work" "$track" --frames="$frames" --poses="$work/builtin.csv"
  sample "its poses file" poses_complete "$work/builtin.csv" "$frames"
  sample "track_sequence, method epnp, two tools" limited "$track" --sequence="$work/two" --method=epnp \
    --frames=4 --poses="$work/two.csv"
  sample "its poses file" poses_complete "$work/two.csv" 4
  sample "its further columns" columns_sound "$work/two.csv" epnp
  sample "track_sequence, method paper" limited "$track" --sequence="$work/sequence" --method=paper --poses="$work/paper.csv"
  sample "its poses file" poses_complete "$work/paper.csv" "$frames"
  sample "its further columns" columns_sound "$work/paper.csv" paper
  sample "track_sequence, drawn ahead" limited "$track" --sequence="$work/two" --render-ahead --poses="$work/ahead.csv"
  sample "its poses file" poses_complete "$work/ahead.csv" 4
  sample "track_sequence.py" python_cv2 "$REPO/samples/track_sequence.py" --sequence="$work/sequence" \
    --poses="$work/python.csv" --frames="$frames" --render-ahead
  sample "its poses file" poses_complete "$work/python.csv" "$frames"
  sample "its further columns" columns_sound "$work/python.csv" full
  sample "plot_performance.py" "$PYTHON" "$REPO/samples/plot_performance.py" "$LOGS/perf.xml" --markdown="$work/performance.md"
  sample "its table" grep -q 'Tools Tracker update' "$work/performance.md"
  run_evaluation "$work"
  run_stereo "$work"
  run_live "$work"
  sample "refused: no such sequence" refuses "$work/none" "$track" --sequence="$work/none"
  sample "refused: no such method" refuses method "$track" --sequence="$work/sequence" --method=none
  sample "refused: output folder missing" refuses "$work/none/poses.csv" "$track" --sequence="$work/sequence" \
    --poses="$work/none/poses.csv"
  if [[ -c /dev/full ]]; then
    sample "refused: disk full" refuses /dev/full "$track" --sequence="$work/sequence" --poses=/dev/full --quiet
  fi
  sample "refused: no such tool file" refuses "$work/none.yaml" "$make" --out="$work/never" --tool="$work/none.yaml"
  count "samples" "$sample_passed" "$sample_failed" 0
}

prepare
build opencv_surgtrack opencv_test_surgtrack opencv_perf_surgtrack opencv_samples_surgtrack opencv_python3

if [[ -n "${SURGTRACK_DATA:-}" ]]; then
  echo "SURGTRACK_DATA=$SURGTRACK_DATA"
else
  echo "SURGTRACK_DATA is not set: tests on recorded data are skipped"
fi

step "C++ tests"
run_gtest "C++ tests" "$LOGS/test.log" env -u DISPLAY "$BUILD_DIR/bin/opencv_test_surgtrack"

if command -v xvfb-run >/dev/null && command -v xauth >/dev/null; then
  step "C++ tests of the renderers, with an X server"
  run_gtest "C++ tests, X server" "$LOGS/test-x.log" xvfb-run -a -s '-screen 0 1280x1024x24' \
    "$BUILD_DIR/bin/opencv_test_surgtrack" '--gtest_filter=*MeshRenderer*'
fi

step "Python tests"
run_unittest "Python tests" "$LOGS/test-python.log" \
  env "PYTHONPATH=$BUILD_DIR/python_loader:$OPENCV_SOURCE/modules/python/test" PYTHONDONTWRITEBYTECODE=1 \
  "$PYTHON" "$REPO/misc/python/test/test_surgtrack.py"

step "Performance tests, one sample each"
run_gtest "performance tests" "$LOGS/perf.log" env -u DISPLAY "$BUILD_DIR/bin/opencv_perf_surgtrack" \
  --perf_min_samples=1 --perf_force_samples=1 --perf_strategy=simple "--gtest_output=xml:$LOGS/perf.xml"

step "Samples"
run_samples

step "Summary"
if [[ $skipped -gt 0 ]]; then echo "skipped: $skipped (see SKIP in the logs in $LOGS)"; fi
if [[ $failed -gt 0 ]]; then
  printf 'failed in: %s\n' "${failures[@]}"
  sed -nE 's/^\[  FAILED  \] ([A-Za-z_/*]+\.[^, ]*).*/  \1/p' "$LOGS"/test.log "$LOGS"/test-x.log "$LOGS"/perf.log 2>/dev/null | sort -u || true
fi
echo
echo "$passed passed, $failed failed"
[[ $failed -eq 0 ]] || { trap - ERR; exit 1; }
