#!/usr/bin/env bash
# Builds the module within OpenCV and runs all its tests.

set -euo pipefail

usage() {
  cat <<'TEXT'
usage: misc/test.sh [--help | --sanitize=address,undefined | --sanitize=thread]

Installs what is missing (apt), gets OpenCV's source, builds the module and runs its C++ tests, Python tests, performance
tests (once each, as a check that they run) and samples. Needs no display. The last line is `N passed, N failed`; the exit
code is 0 if nothing failed.

--sanitize builds the module and its C++ tests alone, with the compiler's sanitizers, in BUILD_DIR-address or BUILD_DIR-thread, and runs the
tests: with `thread` those that have several threads. OpenCV itself is not instrumented. For `address` and `undefined` it need not be: what
the module hands over is checked where the module touches it. ThreadSanitizer does not see how OpenCV's own threads wait for each other:
OpenCV's functions are left out by misc/tsan.supp, and parallel_for_() runs in one thread (--test_threads=1).

environment:
  BUILD_DIR       build folder, kept for the next run (default: build/ in the repository)
  OPENCV_SOURCE   OpenCV source tree, 4.6 or newer (default: the distribution's source package, else a git clone of 4.10.0)
  SURGTRACK_DATA  folder with tools/ and sequences/ for the tests on recorded data (without it they are skipped)
  JOBS            parallel compilations (default: number of processors)
  PYTHON          interpreter that the bindings are built for (default: python3 in PATH, if it has numpy and headers)
  CCACHE_DIR      as ever
TEXT
}

sanitize=''
case "${1:-}" in
  '') ;;
  --sanitize=address,undefined | --sanitize=thread) sanitize="${1#--sanitize=}" ;;
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

video_readable() {
  python_cv2 -c '
import sys, cv2
v = cv2.VideoCapture(sys.argv[1])
n = 0
while v.read()[0]:
    n += 1
assert n == int(sys.argv[2]), "%d frames" % n' "$1" "$2"
}

for checks in wings without_vtk evaluation cluster python_docs stereo rig import look handeye live fuzz manners confidence docs install versions; do
  # shellcheck source=/dev/null
  source "$REPO/misc/checks/$checks.sh"
done

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
  run_wings "$work"
  run_without_vtk "$work"
  run_evaluation "$work"
  run_cluster "$work"
  run_python_docs "$work"
  run_stereo "$work"
  run_rig "$work"
  run_import "$work"
  run_look "$work"
  run_handeye "$work"
  run_live "$work"
  run_fuzz
  run_manners "$work"
  run_confidence "$work"
  run_docs "$work"
  run_install "$work"
  run_versions "$work"
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

if [[ -n "$sanitize" ]]; then
  BUILD_DIR="$BUILD_DIR-${sanitize%%,*}"
  LOGS="$BUILD_DIR/logs"
  mkdir -p "$BUILD_DIR"
  # shellcheck disable=SC2054
  CONFIGURATION=("-DOPENCV_EXTRA_MODULES_PATH=$REPO" "-DSURGTRACK_SANITIZE=$sanitize" -DBUILD_LIST=surgtrack,ts -DBUILD_EXAMPLES=OFF
    -DBUILD_TESTS=ON -DOPENCV_BUILD_TEST_MODULES_LIST=surgtrack -DBUILD_opencv_python3=OFF)
  prepare
  build opencv_surgtrack opencv_test_surgtrack
  export ASAN_OPTIONS=detect_leaks=1 LSAN_OPTIONS="suppressions=$REPO/misc/lsan.supp" UBSAN_OPTIONS=print_stacktrace=1 \
    TSAN_OPTIONS="suppressions=$REPO/misc/tsan.supp"
  filter='*-*Allocations*:*SceneView*:*VTK*'   # who counts allocations counts those of the sanitizer; drivers of OpenGL are not clean
  options=()
  if [[ "$sanitize" == thread ]]; then
    filter='SurgTrack_HostileFiles.meshesAreLoadedInSeveralThreads:*RenderAhead*:*render*head*:*Live*:*JointBuffer*:*Tracker_Calls*'
    options=(--test_threads=1)
  fi
  step "C++ tests with -fsanitize=$sanitize"
  run_gtest "C++ tests, $sanitize" "$LOGS/test.log" env -u DISPLAY "$BUILD_DIR/bin/opencv_test_surgtrack" "--gtest_filter=$filter" "${options[@]}"
  echo
  echo "$passed passed, $failed failed"
  [[ $failed -eq 0 ]] || { trap - ERR; exit 1; }
  exit 0
fi

# For the checks of plots, of the cluster, of the type stubs and for ARM; without them these are skipped.
PACKAGES+=(python3-matplotlib python3-distributed mypy g++-aarch64-linux-gnu)
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
  # -noreset: else the server starts anew, and answers nobody for a moment, whenever its last window is closed
  run_gtest "C++ tests, X server" "$LOGS/test-x.log" xvfb-run -a -s '-screen 0 1280x1024x24 -noreset' \
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
