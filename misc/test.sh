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

# evaluation_same A B: two evaluations, byte for byte, but for what depends on the speed of the machine.
evaluation_same() { diff -r -x results -x timings.csv "$1" "$2"; }

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

# lose_a_worker OUT LOG COMMAND...: evaluates with two Dask workers, one of which is ended when there is a first result in OUT.
lose_a_worker() {
  local out="$1" log="$2" code=0 pids=() i results=0 address='' dask=("$PYTHON" -m)
  shift 2
  rm -f "$out.json"
  "${dask[@]}" distributed.cli.dask_scheduler --host 127.0.0.1 --port 0 --no-dashboard --scheduler-file "$out.json" >"$log" 2>&1 &
  pids+=($!)
  for i in 1 2; do   # without a nanny, which would start a new one
    "${dask[@]}" distributed.cli.dask_worker --scheduler-file "$out.json" --name "$i" --nthreads 1 --no-nanny --no-dashboard \
      --local-directory "$out.dask" >>"$log" 2>&1 &
    pids+=($!)
  done
  for ((i = 0; i < 600 && $(occurrences 'Registered to' "$log") < 2; i++)); do sleep 0.1; done
  address="$(sed -nE 's/.*"address": "(tcp:[^"]*)".*/\1/p' "$out.json" | head -n 1)"
  limited "$@" --scheduler="$address" --out="$out" &
  local client=$!
  for ((i = 0; i < 600; i++)); do
    results="$(find "$out/results" -name '*.yml.gz' ! -name 'part-*' 2>/dev/null | wc -l)"
    ((results == 0)) || break
    sleep 0.1
  done
  kill -9 "${pids[2]}"
  wait "$client" || code=$?
  kill "${pids[0]}" "${pids[1]}" 2>/dev/null || true
  wait "${pids[@]}" 2>/dev/null || true
  if ((results == 0 || results > 2)); then   # of four: each of the two workers has one to do
    echo "the worker was not ended in the middle: there were $results results"
    return 1
  fi
  return "$code"
}

# kept DIR COMMAND...: the command leaves the results in DIR as they are.
kept() {
  local before after
  before="$(stat -c '%n %y %s' "$1"/results/*.yml.gz)"
  "${@:2}" || return 1
  after="$(stat -c '%n %y %s' "$1"/results/*.yml.gz)"
  [[ "$before" == "$after" ]] || { echo "before: $before; after: $after"; return 1; }
}

# The first two sequences are those of run_evaluation, the third one can't be evaluated.
run_cluster() {
  local work="$1" evaluate="$BUILD_DIR/bin/example_surgtrack_evaluate" make="$BUILD_DIR/bin/example_surgtrack_make_sequence" i
  local python=(env PYTHONDONTWRITEBYTECODE=1 "$PYTHON") options
  mkdir -p "$work/many/deeper"
  cp -r "$work/stereo" "$work/pair" "$work/many"
  for i in 1 2; do
    sample "make_sequence, number $i" limited "$make" --out="$work/many/deeper/$i" --frames=8 --seed="$i"
  done
  options=(--sequences="$work/many" --stereo --quiet)
  sample "evaluate, a folder of sequences" limited "$evaluate" "${options[@]}" --out="$work/one"
  sample "all of them" grep -q '^| all | full | 40 |' "$work/one/table.md"   # 8 frames of five tools
  sample "evaluate, again" kept "$work/one" limited "$evaluate" "${options[@]}" --out="$work/one"
  sample "evaluate.py, two processes" limited "${python[@]}" "$REPO/samples/evaluate.py" "${options[@]}" --jobs=2 \
    --program="$evaluate" --out="$work/processes"
  sample "the same files" evaluation_same "$work/one" "$work/processes"
  rm "$work"/processes/results/1-*.yml.gz
  rm "$work"/processes/*.csv
  sample "evaluate.py, after an interruption" limited "${python[@]}" "$REPO/samples/evaluate.py" "${options[@]}" \
    --program="$evaluate" --out="$work/processes"
  sample "the same files" evaluation_same "$work/one" "$work/processes"
  sample "evaluate.py, again" kept "$work/processes" limited "${python[@]}" "$REPO/samples/evaluate.py" "${options[@]}" \
    --program="$evaluate" --out="$work/processes"
  echo >>"$work/many/pair/kinematics.csv"
  echo "0" >>"$work/many/pair/kinematics.csv"
  sample "refused: a file has changed, and no result of before is taken" refuses "$work/many/pair/kinematics.csv" "$evaluate" \
    "${options[@]}" --out="$work/one"
  sample "refused: the same in Python" refuses "$work/many/pair/kinematics.csv" "${python[@]}" "$REPO/samples/evaluate.py" \
    "${options[@]}" --program="$evaluate" --out="$work/processes"
  sample "the same files of the others" evaluation_same "$work/one" "$work/processes"
  sample "refused: nothing to merge" refuses "has no result" "$evaluate" --sequences="$work/stereo" --out="$work/never" --merge
  sample "refused: part and merge" refuses "'--part'" "$evaluate" --sequences="$work/stereo" --out="$work/never" --merge --part
  sample "refused: no such method, in Python" refuses "'none'" "${python[@]}" "$REPO/samples/evaluate.py" --sequences="$work/many" \
    --program="$evaluate" --out="$work/never" --methods=none
  sample "refused: no such program" refuses "$work/none" "${python[@]}" "$REPO/samples/evaluate.py" --sequences="$work/many" \
    --program="$work/none" --out="$work/never"
  cat >"$work/fails-once" <<SCRIPT
#!/bin/sh
case "\$*" in *--part*) if mkdir "$work/failed-once" 2>/dev/null; then echo 'evaluate: no memory' >&2; exit 1; fi ;; esac
exec "$evaluate" "\$@"
SCRIPT
  chmod +x "$work/fails-once"
  sample "evaluate.py, a sequence fails once" limited "${python[@]}" "$REPO/samples/evaluate.py" --sequences="$work/many/deeper" \
    --methods=epnp --program="$work/fails-once" --out="$work/once" --quiet
  sample "all are there" grep -q '^| all | epnp | 16 |' "$work/once/table.md"
  sample "it has failed" test -d "$work/failed-once"
  if ! "$PYTHON" -c 'import distributed' 2>/dev/null; then
    echo "skipped: evaluate_cluster.py, which needs dask.distributed"
    return 0
  fi
  local cluster=("${python[@]}" "$REPO/samples/evaluate_cluster.py" "${options[@]}" --program="$evaluate")
  sample "refused: no scheduler" refuses "tcp://127.0.0.1:9" "${cluster[@]}" --scheduler=tcp://127.0.0.1:9 --out="$work/cluster"
  cp "$work/pair/kinematics.csv" "$work/many/pair/kinematics.csv"
  sample "evaluate, all of them once more" limited "$evaluate" "${options[@]}" --out="$work/one"
  sample "evaluate_cluster.py, one of two workers is lost" lose_a_worker "$work/cluster" "$LOGS/dask.log" "${cluster[@]}"
  sample "the same files" evaluation_same "$work/one" "$work/cluster"
}

# The stubs, and a user's program that type checkers have to accept but for one line.
run_python_docs() {
  local work="$1" name
  sample "make_stubs.py: the stubs are up to date" python_cv2 "$REPO/misc/python/make_stubs.py" --check
  if "$PYTHON" -c 'import mypy' 2>/dev/null; then
    sample "mypy: the stubs" env "MYPYPATH=$REPO/misc/python/stubs" "$PYTHON" -m mypy --strict --cache-dir="$work/mypy" \
      "$REPO/misc/python/stubs/cv2/surgtrack.pyi"
    sample "mypy: a user's program" env "MYPYPATH=$REPO/misc/python/stubs" "$PYTHON" -m mypy --strict --cache-dir="$work/mypy" \
      "$REPO/misc/python/test/typed_user.py"
    sed 's/tracker.addTool(model/tracker.addTool(model.name()/' "$REPO/misc/python/test/typed_user.py" >"$work/wrong_user.py"
    sample "mypy: a wrong one" mypy_refuses 'Argument 1 to "addTool"' "$work" "$work/wrong_user.py"
  else
    echo "skipped: the type stubs, which need mypy to be checked"
  fi
  sample "the user's program" python_cv2 "$REPO/misc/python/test/typed_user.py"
  if "$PYTHON" -c 'import matplotlib' 2>/dev/null; then
    sample "run_doc.py doc/python.md" limited env PYTHONDONTWRITEBYTECODE=1 "PYTHONPATH=$BUILD_DIR/python_loader" "$PYTHON" \
      "$REPO/misc/run_doc.py" "$REPO/doc/python.md" --folder="$work/python"
    while read -r name; do
      sample "its picture $name" test -s "$work/python/$name" -a -s "$REPO/doc/pics/$name"
    done < <(sed -nE 's/^!\[.*\]\(pics\/(.*)\)$/\1/p' "$REPO/doc/python.md")
  else
    echo "skipped: doc/python.md, which needs matplotlib"
  fi
  # shellcheck disable=SC2016
  printf '# A page\n\n```python\na = 1\n```\ntext\n```python\nb = a.c\n```\n' >"$work/page.md"
  sample "refused: an error in a page" refuses "page.md, line 8" "$PYTHON" "$REPO/misc/run_doc.py" "$work/page.md" --folder="$work"
}

# mypy_refuses MESSAGE FOLDER FILE
mypy_refuses() {
  local code=0
  env "MYPYPATH=$REPO/misc/python/stubs" "$PYTHON" -m mypy --strict --cache-dir="$2/mypy" "$3" >"$LOGS/mypy.log" 2>&1 || code=$?
  grep -q -F -e "$1" "$LOGS/mypy.log" && [[ $code -eq 1 ]]
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

# import_files SEQUENCE DIR: what a lab would have of a sequence, in the formats of others.
import_files() {
  mkdir -p "$2"
  cat >"$2/PSM.json" <<'JSON'
/* -*- Mode: Javascript -*- */
{ // the arm
  "DH": { "convention": "modified", "joints": [
    { "name": "yaw", "alpha": 1.5708, "A": 0.0, "theta": 0.0, "D": 0.0, "type": "revolute", "offset": 1.5708 },
    { "name": "pitch", "alpha": -1.5708, "A": 0.0, "theta": 0.0, "D": 0.0, "type": "revolute", "offset": -1.5708 },
    { "name": "insertion", "alpha": 1.5708, "A": 0.0, "theta": 0.0, "D": 0.0, "type": "prismatic", "offset": -0.4318 } ] }
}
JSON
  cat >"$2/DRIVER.json" <<'JSON'
{ "DH": { "convention": "modified", "joints": [
    { "name": "roll", "alpha": 0.0, "A": 0.0, "theta": 0.0, "D": 0.4162, "type": "revolute", "offset": 0.0 },
    { "name": "wrist_pitch", "alpha": -1.5708, "A": 0.0, "theta": 0.0, "D": 0.0, "type": "revolute", "offset": -1.5708 },
    { "name": "wrist_yaw", "alpha": -1.5708, "A": 0.0091, "theta": 0.0, "D": 0.0, "type": "revolute", "offset": -1.5708 } ] },
  "jaw": { "qmin": -0.7, "qmax": 1.4 },
  "tooltip_offset": [[0, -1, 0, 0], [0, 0, 1, 0], [-1, 0, 0, 0], [0, 0, 0, 1]]
}
JSON
  cat >"$2/crane.urdf" <<'XML'
<?xml version="1.0"?>
<robot name="crane">
  <link name="base"/>
  <link name="shaft"><visual><geometry><mesh filename="package://crane/peak.obj" scale="0.001 0.001 0.001"/></geometry></visual></link>
  <joint name="turn" type="continuous"><parent link="base"/><child link="shaft"/><origin xyz="0 0 0.1" rpy="0 1.5708 0"/><axis xyz="0 1 0"/></joint>
</robot>
XML
  printf 'v 0 0 0\nv 2 0 0\nv 0 2 0\nv 0 0 2\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n' >"$2/peak.obj"
  local eye='res_x=720\nres_y=576\nfc_x=800\nfc_y=800\ncc_x=360\ncc_y=288\nkc_0=0\nkc_1=0\nkc_2=0\nkc_3=0\nkc_4=0'
  printf '%b\n' '[StereoLeft]' "$eye" '[StereoRight]' "$eye" 'R_0=1\nR_1=0\nR_2=0\nR_3=0\nR_4=1\nR_5=0\nR_6=0\nR_7=0\nR_8=1' \
    'T_0=-5\nT_1=0\nT_2=0' >"$2/rig.ini"
  printf '[{"annotations": [{"class": "HeadPoint", "id": "tool1", "x": 3, "y": 4}]}]\n' >"$2/labels.json"
  printf '0:\n  1:\n  - 3.5\n  - 4\n  2: null\n' >"$2/keypoints_left.yaml"
  python_cv2 - "$1" "$2" <<'PYTHON'
import csv, os, sys
import cv2
import numpy as np
source, out = sys.argv[1:3]
f = cv2.FileStorage(os.path.join(source, "sequence.yaml"), cv2.FILE_STORAGE_READ)
left = f.getNode("left")
with open(os.path.join(out, "camera_info.yaml"), "w") as info:   # no %YAML line, as ROS writes it
    info.write("image_width: %d\nimage_height: %d\ndistortion_model: plumb_bob\n"
               % (f.getNode("image_width").real(), f.getNode("image_height").real()))
    for key, rows, cols in (("camera_matrix", 3, 3), ("distortion_coefficients", 1, 5)):
        data = ", ".join(repr(float(v)) for v in left.getNode(key).mat().ravel())
        info.write("%s:\n  rows: %d\n  cols: %d\n  data: [%s]\n" % (key, rows, cols, data))
stereo = cv2.FileStorage(os.path.join(out, "stereo.yml"), cv2.FILE_STORAGE_WRITE)
for eye in ("1", "2"):
    stereo.write("M" + eye, left.getNode("camera_matrix").mat())
    stereo.write("D" + eye, left.getNode("distortion_coefficients").mat())
stereo.write("R", cv2.Rodrigues(np.array([0., 0.01, 0.]))[0])
stereo.write("T", np.array([-5., 0., 0.]))
stereo.release()
eye = cv2.FileStorage(os.path.join(out, "hand_eye.yaml"), cv2.FILE_STORAGE_WRITE)
eye.write("camera_T_base", f.getNode("tools").at(0).getNode("camera_T_base").mat())
eye.release()
names = ["outer_yaw", "outer_pitch", "outer_insertion", "outer_roll", "outer_wrist_pitch", "outer_wrist_yaw"]
rows = list(csv.DictReader(open(os.path.join(source, "kinematics.csv"), newline="")))
with open(os.path.join(out, "js.csv"), "w") as arm, open(os.path.join(out, "jaw.csv"), "w") as jaw:   # nanoseconds of another clock
    arm.write("header.stamp," + ",".join(names) + "\n")
    jaw.write("header.stamp,position[0]\n")
    for r in rows:
        stamp = 1700000000000000000 + int(round(float(r["time"]) * 1e9))
        arm.write("%d,%s\n" % (stamp, ",".join(r["q%d" % i] for i in range(1, 7))))
        jaw.write("%d,%s\n" % (stamp, r["jaw"]))
PYTHON
}

# poses_alike A B: the same states, and places within 20 micrometres: what single precision in the meshes can move.
poses_alike() {
  "$PYTHON" - "$1" "$2" <<'PYTHON'
import csv, sys
a, b = (list(csv.DictReader(open(name, newline=""))) for name in sys.argv[1:3])
assert len(a) == len(b)
for r, s in zip(a, b):
    assert r["status"] == s["status"], (r, s)
    for c in ("tx", "ty", "tz"):
        assert abs(float(r[c]) - float(s[c])) < 20e-6, (c, r, s)
PYTHON
}

# import_paper DIR: the recordings of the paper, by the commands of doc/formats.md.
import_paper() {
  local import="$BUILD_DIR/bin/example_surgtrack_import" track="$BUILD_DIR/bin/example_surgtrack_track_sequence"
  if [[ ! -d "${SURGTRACK_DATA:-}/paper_rig" ]]; then
    echo "skipped: import of the paper's recordings, SURGTRACK_DATA does not name a folder that has paper_rig"
    return
  fi
  sample "import: the paper's tool" limited "$import" --from=dvrk \
    --in="$SURGTRACK_DATA/formats/dvrk/PSM.json,$SURGTRACK_DATA/formats/dvrk/LARGE_NEEDLE_DRIVER_400006.json" \
    --like="$SURGTRACK_DATA/tools/large_needle_driver/large_needle_driver.yaml" --out="$1/tool/driver.yaml"
  sample "import: the paper's recordings" limited "$import" --from=daVinciToolTrack --in="$SURGTRACK_DATA/paper_rig" \
    --model="$1/tool/driver.yaml" --left="$SURGTRACK_DATA/sequences/paper_rig/left.mp4" --into="$1/recording"
  cp "$SURGTRACK_DATA/sequences/paper_rig/groundtruth.csv" "$1/recording/"
  sample "tracking them" limited "$track" --sequence="$1/recording" --poses="$1/poses.csv" --frames=60 --quiet
  sample "close to the truth" close_to_truth "$1/poses.csv" "$1/recording/groundtruth.csv"
}

# close_to_truth POSES TRUTH: tracked, and off by less than 0.6 mm on average; the whole of the ready-made sequence gives 0.33 mm.
close_to_truth() {
  "$PYTHON" - "$1" "$2" <<'PYTHON'
import csv, math, sys
truth = {(r["frame"], r["tool"]): r for r in csv.DictReader(open(sys.argv[2], newline=""))}
rows = list(csv.DictReader(open(sys.argv[1], newline="")))
tracked = [r for r in rows if r["status"] == "tracking"]
errors = [math.dist(*([float(p[c]) for c in ("tx", "ty", "tz")] for p in (r, truth[r["frame"], r["tool"]]))) for r in tracked]
assert len(tracked) > 0.9 * len(rows), (len(tracked), len(rows))
assert sum(errors) / len(errors) < 0.6e-3, sum(errors) / len(errors)
PYTHON
}

run_import() {
  local work="$1" import="$BUILD_DIR/bin/example_surgtrack_import" track="$BUILD_DIR/bin/example_surgtrack_track_sequence" like
  like="$(echo "$work"/sequence/tool/*.yaml)"
  local lab="$work/lab" out="$work/imported"
  sample "files of other programs" import_files "$work/sequence" "$lab"
  sample "import: dVRK" limited "$import" --from=dvrk --in="$lab/PSM.json,$lab/DRIVER.json" --like="$like" --out="$out/driver.yaml"
  sample "import: camera_info" limited "$import" --from=camera_info --in="$lab/camera_info.yaml" --left="$work/sequence/left.mp4" --into="$out"
  sample "import: joints" limited "$import" --from=joints_csv --in="$lab/js.csv,$lab/jaw.csv" --tool=PSM1 --model="$out/driver.yaml" \
    --hand-eye="$lab/hand_eye.yaml" --start=1700000000 --into="$out"
  sample "tracking what was imported" limited "$track" --sequence="$out" --poses="$work/imported.csv" --quiet
  sample "as the original" poses_alike "$work/imported.csv" "$work/poses.csv"
  sample "import: URDF" limited "$import" --from=urdf --in="$lab/crane.urdf" --packages="$lab" --out="$out/crane.yaml"
  sample "import: SurgPose" limited "$import" --from=surgpose --in="$lab/rig.ini" --into="$work/rig"
  sample "its two cameras" grep -q right_T_left "$work/rig/sequence.yaml"
  sample "import: labels of EndoVis" limited "$import" --from=endovis15 --in="$lab/labels.json" --keypoints=HeadPoint:pivot --tools=tool1:PSM1 \
    --out="$work/labels.csv"
  sample "its points" grep -q '^0,PSM1,pivot,3,4,1$' "$work/labels.csv"
  sample "import: labels of SurgPose" limited "$import" --from=surgpose_keypoints --in="$lab/keypoints_left.yaml" --out="$work/labels.csv"
  sample "its points" grep -q '^0,PSM1,1,3.5,4,1$' "$work/labels.csv"
  sample "refused: no such format" refuses "--from=none" "$import" --from=none
  sample "refused: no file" refuses "$lab/none.json" "$import" --from=dvrk --in="$lab/none.json" --out="$out/never.yaml"
  sample "refused: no output" refuses "--out" "$import" --from=dvrk --in="$lab/PSM.json"
  sample "refused: a package that is not there" refuses "package://crane/peak.obj" "$import" --from=urdf --in="$lab/crane.urdf" --out="$out/never.yaml"
  sample "refused: a video of another size" refuses "720x576" "$import" --from=surgpose --in="$lab/rig.ini" --left="$work/two/left.mp4" \
    --into="$work/rig"
  sample "import: stereo calibration of OpenCV" limited "$import" --from=opencv_stereo --in="$lab/stereo.yml" --image-size=720x576 --unit=mm \
    --into="$work/rig"
  sample "refused: a baseline without unit" refuses "unit" "$import" --from=opencv_stereo --in="$lab/stereo.yml" --image-size=720x576 --into="$work/rig"
  sample "refused: no such unit" refuses "argument '--unit=inch'" "$import" --from=opencv_stereo --in="$lab/rig.ini" --unit=inch --into="$work/rig"
  import_paper "$work/paper"
  printf 'version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n' >"$lab/peak.obj"
  sample "refused: a pointer of git-LFS" refuses "git-LFS" "$import" --from=urdf --in="$lab/crane.urdf" --packages="$lab" --out="$out/never.yaml"
}

# pictures_of_frame DIR FRAME TOOL: one a stage, readable, with more than one colour, and the sheet.
pictures_of_frame() {
  python_cv2 - "$1/$(printf '%06d' "$2")_$3" <<'PYTHON'
import sys, cv2
stages = ["1_view", "2_orientations", "3_templates", "4_similarity", "5_context", "6_contour"]
pictures = {s: cv2.imread("%s_%s.png" % (sys.argv[1], s)) for s in stages}
for stage, picture in pictures.items():
    assert picture is not None and picture.std() > 5, stage
view = pictures["1_view"].shape
assert 500 <= view[1] <= 1100, view   # 720, by a whole factor
for stage in ("2_orientations", "5_context"):   # two beside each other
    assert pictures[stage].shape[0] == view[0] and pictures[stage].shape[1] >= 2 * view[1], stage
assert pictures["6_contour"].shape == view
assert cv2.imread(sys.argv[1] + ".jpg").shape[1] == 1440
PYTHON
}

# timings_sound CSV FRAMES
timings_sound() {
  "$PYTHON" - "$1" "$2" <<'PYTHON'
import csv, sys
rows = list(csv.DictReader(open(sys.argv[1], newline="")))
assert len(rows) == int(sys.argv[2]) and list(rows[0])[:2] == ["frame", "time"] and list(rows[0])[-1] == "total", rows[0]
for row in rows:
    assert 0 < sum(float(row[c]) for c in list(row)[2:-1]) <= 1.01 * float(row["total"]), row
PYTHON
}

# What is to be looked at: pictures of the stages, plots of a run, the scene from outside.
run_look() {
  local work="$1" frames=6 track="$BUILD_DIR/bin/example_surgtrack_track_sequence" view="$BUILD_DIR/bin/example_surgtrack_view3d"
  local plot=("$PYTHON" "$REPO/samples/plot_run.py") name
  sample "make_sequence, to look at" limited "$BUILD_DIR/bin/example_surgtrack_make_sequence" --out="$work/seen" --frames="$frames" --tools=2 \
    --distortion --seed=8
  sample "track_sequence, with pictures" limited "$track" --sequence="$work/seen" --poses="$work/seen.csv" --timings="$work/timings.csv" \
    --debug="$work/debug" --debug-frames=0,4 --quiet
  sample "the same poses as without" limited "$track" --sequence="$work/seen" --poses="$work/unseen.csv" --quiet
  sample "they are the same" cmp "$work/seen.csv" "$work/unseen.csv"
  for name in $(tail -n +2 "$work/seen.csv" | cut -d, -f3 | sort -u); do
    sample "pictures of $name at first" pictures_of_frame "$work/debug" 0 "$name"
    sample "pictures of $name" pictures_of_frame "$work/debug" 4 "$name"
  done
  sample "no others" test "$(find "$work/debug" -type f | wc -l)" -eq 28
  sample "its times" timings_sound "$work/timings.csv" "$frames"
  sample "track_sequence, pictures of every third frame" limited "$track" --sequence="$work/seen" --method=paper --debug="$work/debug3" \
    --debug-frames=every:3 --start=1 --quiet
  sample "two of them" test "$(find "$work/debug3" -name '*_1_view.png' | wc -l)" -eq 4
  sample "refused: frames that are no numbers" refuses "'--debug-frames=1,x'" "$track" --sequence="$work/seen" --debug="$work/debug" \
    --debug-frames=1,x
  sample "refused: frames without a folder" refuses "--debug=DIR" "$track" --sequence="$work/seen" --debug-frames=1
  sample "refused: frames that are not there" refuses "none of these frames" "$track" --sequence="$work/seen" --debug="$work/debug" \
    --debug-frames=99 --quiet
  sample "refused: pictures into a file" refuses "$work/seen.csv" "$track" --sequence="$work/seen" --debug="$work/seen.csv" --quiet
  sample "refused: times into no folder" refuses "$work/none/t.csv" "$track" --sequence="$work/seen" --timings="$work/none/t.csv" --quiet

  if limited "$view" --sequence="$work/seen" --poses="$work/seen.csv" --out="$work/scene.png" 2>"$LOGS/view3d.log" ||
    ! grep -q 'VTK can draw neither' "$LOGS/view3d.log"; then
    sample "view3d" limited "$view" --sequence="$work/seen" --poses="$work/seen.csv" --frame=3 --out="$work/scene.png"
    sample "its picture" python_cv2 -c 'import sys, cv2; assert cv2.imread(sys.argv[1]).std() > 10' "$work/scene.png"
    sample "refused: no such picture" refuses "$work/none/scene.png" "$view" --sequence="$work/seen" --poses="$work/seen.csv" \
      --out="$work/none/scene.png"
    sample "refused: a window without a display" refuses "display" env -u DISPLAY "$view" --sequence="$work/seen" --poses="$work/seen.csv" --window
  else
    echo "skipped: view3d, which needs OpenGL"
  fi
  sample "refused: nothing to show it in" refuses "--window" "$view" --sequence="$work/seen" --poses="$work/seen.csv"
  sample "refused: no poses file" refuses "$work/none.csv" "$view" --sequence="$work/seen" --poses="$work/none.csv" --out="$work/scene.png"
  sample "refused: no such frame" refuses "frame 99" "$view" --sequence="$work/seen" --poses="$work/seen.csv" --frame=99 --out="$work/scene.png"

  if "$PYTHON" -c 'import matplotlib' 2>/dev/null; then
    sample "plot_run.py" limited "${plot[@]}" "$work/seen.csv" --timings="$work/timings.csv" --sequence="$work/seen" --out="$work/plots"
    for name in poses evidence offsets errors timings; do
      sample "its $name.png" test -s "$work/plots/$name.png"
    done
    sample "refused: plots into a file" refuses "$work/seen.csv" "${plot[@]}" "$work/seen.csv" --out="$work/seen.csv"
  else
    echo "skipped: the plots of plot_run.py, which need matplotlib"
  fi
  sample "refused: plots of no poses" refuses "$work/none.csv" "${plot[@]}" "$work/none.csv"
  sample "refused: plots of something else" refuses "'tool'" "${plot[@]}" "$work/timings.csv"
  sed '3s/tracking,[^,]*/tracking,x/' "$work/seen.csv" >"$work/broken.csv"
  sample "refused: plots of a broken file" refuses "broken.csv, line 3" "${plot[@]}" "$work/broken.csv"
}

# hand_eye_right SEQUENCE TOOL RECORDING MM DEGREES: camera_T_base of the tool (its index) is the true one, as near as that where the
# tool works.
hand_eye_right() {
  python_cv2 - "$@" <<'PYTHON'
import sys
import cv2, numpy as np
sequence, index = cv2.surgtrack.Sequence.load(sys.argv[1]), int(sys.argv[2])
found, truth = np.float64(sequence.tool(index).nominal_T_base), np.loadtxt(sys.argv[3] + "/camera_T_base.txt")
place = np.linalg.inv(truth).dot([0, 0, 0.1, 1])
mm = 1e3 * np.linalg.norm((found - truth).dot(place))
degrees = np.degrees(np.linalg.norm(cv2.Rodrigues(found[:3, :3].dot(truth[:3, :3].T))[0]))
print("%.2f mm, %.2f degrees" % (mm, degrees))
assert mm < float(sys.argv[4]) and degrees < float(sys.argv[5])
PYTHON
}

# The same recording, as of an arm that holds the camera: its poses the other way round. By time, with readings between.
camera_on_arm() {
  "$PYTHON" - "$1" <<'PYTHON'
import sys
import numpy as np
folder = sys.argv[1]
rows = np.loadtxt(folder + "/robot.csv", delimiter=",", skiprows=1)
def line(time, t, q):
    return ",".join("%.9f" % v for v in [time, *t, *q]) + "\n"
with open(folder + "/arm.csv", "w") as file:
    file.write("time,tx,ty,tz,qx,qy,qz,qw\n")
    for index, t, q in zip(rows[:, 0], rows[:, 1:4], rows[:, 4:]):
        v, w = -q[:3], q[3]
        turned = t + 2 * np.cross(v, np.cross(v, t) + w * t)
        for moment in (index, index + 0.4):   # the arm stands for a while
            file.write(line(moment, -turned, [*v, w]))
board = open(folder + "/board.csv").read().splitlines()
with open(folder + "/board-time.csv", "w") as file:
    file.write(board[0].replace("index", "time") + "\n")
    for row in board[1:]:
        index, rest = row.split(",", 1)
        file.write("%.2f,%s\n" % (int(index) + 0.25, rest))
PYTHON
}

same_but_the_matrix() {
  diff <(sed '/data: \[/,/\]/d' "$1") <(sed '/data: \[/,/\]/d' "$2")
}

# doc_commands FILE FOLDER: its shell blocks, one after the other, pasted into a shell in a folder that looks like the repository's.
doc_commands() {
  mkdir "$2"
  ln -s "$BUILD_DIR" "$2/build"
  ln -s "$REPO/misc" "$REPO/samples" "$2"
  (
    cd "$2"
    mkdir python
    ln -s "$PYTHON" python/python3
    PATH="$PWD/python:$PATH" PYTHONDONTWRITEBYTECODE=1 bash -euo pipefail -c "$(sed -n '/^```sh$/,/^```$/{/^```/d;p}' "$REPO/doc/$1")"
  )
}

# doc_python FILE FOLDER: its Python blocks, in one program, where the commands ran.
doc_python() {
  (
    cd "$2"
    python_cv2 -c "$(sed -n '/^```python$/,/^```$/{/^```/d;p}' "$REPO/doc/$1")"
  )
}

run_handeye() {
  local work="$1/hand-eye" hand_eye="$BUILD_DIR/bin/example_surgtrack_hand_eye" make="$BUILD_DIR/bin/example_surgtrack_make_sequence"
  mkdir "$work"
  local data="$work/recording" sequence="$work/sequence"
  sample "make_sequence, with distortion" limited "$make" --out="$sequence" --frames=4 --tools=2 --distortion --seed=8
  cp "$sequence/sequence.yaml" "$work/before.yaml"
  sample "make_hand_eye.py" python_cv2 "$REPO/misc/make_hand_eye.py" "$sequence" "$data" --tool=1
  # 1 mm, 1 degree: three to four times the deviation that hand_eye states for this recording (0.3 mm, 0.3 degrees)
  sample "hand_eye, board images" limited "$hand_eye" --robot="$data/robot.csv" --images="$data/images" --into="$sequence" --tool=PSM2 --quiet
  cp "$LOGS/sample.log" "$work/images.txt"
  sample "its calibration" hand_eye_right "$sequence" 1 "$data" 1 1
  sample "it names the pose that was thrown out" grep -q 'thrown out: index 5,' "$work/images.txt"
  sample "it has no warnings" test -z "$(grep warning "$work/images.txt")"
  sample "the rest of sequence.yaml" same_but_the_matrix "$work/before.yaml" "$sequence/sequence.yaml"
  sample "track_sequence with it" limited "$BUILD_DIR/bin/example_surgtrack_track_sequence" --sequence="$sequence" --quiet
  cp "$work/before.yaml" "$sequence/sequence.yaml"
  local method
  for method in tsai park horaud daniilidis shah refined; do
    sample "hand_eye, board poses, method $method" limited "$hand_eye" --robot="$data/robot.csv" --board-poses="$data/board.csv" \
      --into="$sequence" --tool=PSM2 --method="$method"
    # board.csv has more noise than the images: 0.4 degrees of tilt, and of its depth 0.2 %
    sample "its calibration" hand_eye_right "$sequence" 1 "$data" 3 2
  done
  sample "a recording of a camera on an arm" camera_on_arm "$data"
  sample "hand_eye, camera on an arm, by time" limited "$hand_eye" --setup=camera-on-arm --robot="$data/arm.csv" \
    --board-poses="$data/board-time.csv" --into="$sequence" --tool=PSM2 --arm=0.1,0.2,0.3,0.5,0.5,0.5,0.5 --base=0.1,0.2,0.3,0.5,0.5,0.5,0.5
  sample "its calibration" hand_eye_right "$sequence" 1 "$data" 3 2

  local args=(--robot="$data/robot.csv" --board-poses="$data/board.csv")
  sample "refused: no such tool" refuses "no tool 'PSM3', expected one of: PSM1, PSM2" "$hand_eye" "${args[@]}" --into="$sequence" --tool=PSM3
  sample "refused: no such method" refuses "'--method=none': expected one of best, tsai" "$hand_eye" "${args[@]}" --method=none
  sample "refused: a sequence without a tool" refuses "--tool=NAME" "$hand_eye" "${args[@]}" --into="$sequence"
  sample "refused: images without a camera" refuses "--camera" "$hand_eye" --robot="$data/robot.csv" --images="$data/images"
  sample "refused: a board like its reverse" refuses "upside down" "$hand_eye" "${args[@]}" --board=chessboard --board-size=8x6
  sample "refused: a board that is not there" refuses "no board of 3 x 5" "$hand_eye" --robot="$data/robot.csv" --images="$data/images" \
    --camera="$sequence" --board-size=3x5 --quiet
  sample "refused: keys of two kinds" refuses "has a column 'time', expected 'index'" "$hand_eye" --robot="$data/arm.csv" --board-poses="$data/board.csv"
  sample "refused: an arm's pose without its arm" refuses "--arm" "$hand_eye" "${args[@]}" --arm=0,0,0,0,0,0,1
  head -n 4 "$data/robot.csv" >"$work/three.csv"
  sample "refused: three poses" refuses "3 poses in common, expected at least 4" "$hand_eye" --robot="$work/three.csv" --board-poses="$data/board.csv"
  awk -F, -v OFS=, 'NR > 1 { for (i = 2; i <= 4; i++) $i *= 1000 } 1' "$data/robot.csv" >"$work/mm.csv"
  sample "refused: millimetres" refuses "expected metres" "$hand_eye" --robot="$work/mm.csv" --board-poses="$data/board.csv"
  awk -F, -v OFS=, 'NR > 1 { $5 = $6 = $7 = 0; $8 = 1 } 1' "$data/robot.csv" >"$work/still.csv"
  sample "refused: an arm that does not turn" refuses "one axis only" "$hand_eye" --robot="$work/still.csv" --board-poses="$data/board.csv"
  sample "the commands of own_robot.md" doc_commands own_robot.md "$work/doc"
  sample "its Python" doc_python own_robot.md "$work/doc"
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
  run_cluster "$work"
  run_python_docs "$work"
  run_stereo "$work"
  run_import "$work"
  run_look "$work"
  run_handeye "$work"
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

# For the checks of plots, of the cluster and of the type stubs; without them these are skipped.
PACKAGES+=(python3-matplotlib python3-distributed mypy)
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
  step "C++ tests of what draws with OpenGL, with an X server"
  run_gtest "C++ tests, X server" "$LOGS/test-x.log" xvfb-run -a -s '-screen 0 1280x1024x24' \
    "$BUILD_DIR/bin/opencv_test_surgtrack" '--gtest_filter=*MeshRenderer*:*SceneView*'
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
