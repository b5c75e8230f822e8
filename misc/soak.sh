#!/usr/bin/env bash
# Long runs and faults: memory, covariance and files after 100,000 frames, kill -9, full disks and damaged files. Prints tables.

set -euo pipefail

usage() {
  cat <<'TEXT'
usage: misc/soak.sh [FRAMES]

Builds what is needed and tracks a synthetic sequence for FRAMES frames (100000) in each of six ways; then ends programs by kill -9 while
they write, lets them write to a disk that is full, and gives them files that are cut. The exit code is 0 if all rows are ok.
TEXT
}

case "${1:-}" in
  '' | [1-9]*) ;;
  -h | --help) usage; exit 0 ;;
  *) usage >&2; exit 1 ;;
esac

# shellcheck source=misc/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
frames="${1:-100000}"
prepare
build opencv_surgtrack opencv_samples_surgtrack opencv_python3
work="$BUILD_DIR/soak"
track="$BUILD_DIR/bin/example_surgtrack_track_sequence"
make="$BUILD_DIR/bin/example_surgtrack_make_sequence"
evaluate="$BUILD_DIR/bin/example_surgtrack_evaluate"
import="$BUILD_DIR/bin/example_surgtrack_import"
export OPENCV_LOG_LEVEL=SILENT
rm -rf "$work"
mkdir -p "$work"
failed=0

"$make" --out="$work/sequence" --frames=100 --quiet >"$LOGS/soak.log" 2>&1

step "Long runs"
echo '| run | frames | ms a frame | initializing, tracking, coasting, lost | memory [MB] | least variance | refused, skipped readings | |'
echo '|---|---|---|---|---|---|---|---|'
for scenario in motion static noise black glitches jumps; do
  python_cv2 "$REPO/misc/soak.py" "$work/sequence" "$frames" "$scenario" || failed=1
done

row() {
  echo "| $1 | $2 | $3 |"
  [[ $3 == ok ]] || failed=1
}

# sound CODE: a program ended by itself, with an answer or an error in words.
sound() { if (($1 < 3)); then echo ok; else echo "FAILED, exit code $1"; fi; }

# killed AFTER COMMAND...: ended by kill -9 after so many seconds.
killed() {
  local after="$1" pid
  shift
  "$@" >"$LOGS/soak.log" 2>&1 &
  pid=$!
  sleep "$after"
  kill -9 "$pid" 2>/dev/null || true
  wait "$pid" 2>/dev/null || true
}

# after COMMAND...: its exit code.
after() {
  local code=0
  timeout -k 5 120 "$@" >"$LOGS/soak.log" 2>&1 || code=$?
  echo "$code"
}

step "Faults"
echo '| fault | then | |'
echo '|---|---|---|'
for delay in 0.3 0.7 1.1; do
  rm -rf "$work/killed"
  mkdir -p "$work/killed"
  killed "$delay" "$track" --sequence="$work/sequence" --poses="$work/killed/poses.csv" --quiet
  rows="$(awk -F, 'NR == 1 { n = NF } NF != n { bad++ } END { print bad + 0 }' "$work/killed/poses.csv" 2>/dev/null || echo 0)"
  row "track_sequence, kill -9 after $delay s" "rows that are cut: $rows" "$([[ $rows == 0 ]] && echo ok || echo FAILED)"
  killed "$delay" "$make" --out="$work/killed/made" --frames=200 --quiet
  row "make_sequence, kill -9 after $delay s" "tracking what is there" "$(sound "$(after "$track" --sequence="$work/killed/made" --frames=3 --quiet)")"
  row "the same" "made once more" "$([[ $(after "$make" --out="$work/killed/made" --frames=5 --quiet) == 0 ]] && echo ok || echo FAILED)"
  killed "$delay" "$evaluate" --sequences="$work/sequence" --out="$work/killed/evaluated" --quiet
  row "evaluate, kill -9 after $delay s" "evaluated once more" "$([[ $(after "$evaluate" --sequences="$work/sequence" --frames=20 --out="$work/killed/evaluated2" --quiet) -lt 2 ]] && echo ok || echo FAILED)"
done

# limited in size: what a disk that is full answers, in the middle of a file
# shellcheck disable=SC2016
full() { local blocks="$1"; shift; after bash -c 'trap "" XFSZ; ulimit -f "$1"; shift; exec "$@"' _ "$blocks" "$@"; }
cp -r "$work/sequence" "$work/full"
before="$(cksum <"$work/full/sequence.yaml")"
code="$(full 4 "$track" --sequence="$work/sequence" --poses="$work/full/poses.csv" --quiet)"
row "track_sequence, disk full" "poses: exit code $code" "$([[ $code == 1 ]] && echo ok || echo FAILED)"
code="$(full 4 "$make" --out="$work/full/made" --frames=20 --quiet)"
row "make_sequence, disk full" "exit code $code" "$([[ $code == 1 ]] && echo ok || echo FAILED)"
printf 'image_width: 720\nimage_height: 576\ncamera_matrix:\n  rows: 3\n  cols: 3\n  data: [800, 0, 360, 0, 800, 288, 0, 0, 1]\ndistortion_coefficients:\n  rows: 1\n  cols: 5\n  data: [0, 0, 0, 0, 0]\n' >"$work/info.yaml"
code="$(full 0 "$import" --from=camera_info --in="$work/info.yaml" --into="$work/full")"
same="$([[ "$(cksum <"$work/full/sequence.yaml")" == "$before" ]] && echo 'as it was' || echo changed)"
row "import --into, disk full" "exit code $code, sequence.yaml $same" "$([[ $code == 1 && $same == 'as it was' ]] && echo ok || echo FAILED)"

# Files that are cut anywhere, and one that changes while it is read.
for file in sequence.yaml kinematics.csv groundtruth.csv left.mp4; do
  worst=0
  size="$(stat -c %s "$work/sequence/$file")"
  for share in 0 1 10 37 50 83 99; do
    rm -rf "$work/cut"
    cp -r "$work/sequence" "$work/cut"
    head -c $((size * share / 100)) "$work/sequence/$file" >"$work/cut/$file"
    code="$(after "$track" --sequence="$work/cut" --frames=10 --quiet)"
    ((code > worst)) && worst=$code
  done
  row "$file, cut" "exit codes up to $worst" "$(sound "$worst")"
done
cp -r "$work/sequence" "$work/changing"
(for ((i = 0; i < 200; i++)); do cat "$work/sequence/kinematics.csv" >"$work/changing/kinematics.csv"; done) &
writer=$!
worst=0
for ((i = 0; i < 8; i++)); do
  code="$(after "$track" --sequence="$work/changing" --frames=5 --quiet)"
  ((code > worst)) && worst=$code
done
kill "$writer" 2>/dev/null || true
wait "$writer" 2>/dev/null || true
row "kinematics.csv, written while it is read" "exit codes up to $worst" "$(sound "$worst")"
echo
echo "Workers of Dask that are ended: misc/checks/cluster.sh, a part of misc/test.sh."
rm -rf "$work"
exit "$failed"
