# shellcheck shell=bash
# How track_sequence answers: mistakes of the setup, exit codes, Ctrl-C, parameters, folders of sequences. Sourced by misc/test.sh.

# exits CODE WORD COMMAND...: the exit code, and WORD in what the command prints; nothing has to be printed if WORD is empty.
exits() {
  local expected="$1" word="$2" code=0
  shift 2
  limited "$@" >"$LOGS/exits" 2>&1 || code=$?
  if [[ $code -ne $expected ]] || ! grep -q -F -e "$word" "$LOGS/exits"; then
    echo "expected exit code $expected and '$word', got exit code $code and:"
    cat "$LOGS/exits"
    return 1
  fi
}

# lacks WORD: the command before has not printed it.
lacks() { ! grep -q -F -e "$1" "$LOGS/exits"; }

prints_nothing() { limited "$@" >"$LOGS/exits" 2>&1 && [[ ! -s "$LOGS/exits" ]]; }

# interrupted DIR COMMAND...: Ctrl-C after some frames leaves poses, video and a summary of all frames until then.
interrupted() {
  local work="$1" code=0 pid i rows
  shift
  rm -f "$work/cut.csv"
  "$@" --poses="$work/cut.csv" --video="$work/cut.mp4" >"$LOGS/interrupted" 2>&1 &
  pid=$!
  for ((i = 0; i < 1200 && $(wc -l 2>/dev/null <"$work/cut.csv" || echo 0) < 4; i++)); do sleep 0.05; done
  kill -INT "$pid"
  wait "$pid" || code=$?
  rows=$(($(wc -l <"$work/cut.csv") - 1))
  [[ $code -eq 130 ]] && grep -q 'tracked in' "$LOGS/interrupted" && video_readable "$work/cut.mp4" "$rows" && return 0
  echo "exit code $code, $rows rows, and:"
  cat "$LOGS/interrupted"
  return 1
}

run_manners() {
  local work="$1/manners" make="$BUILD_DIR/bin/example_surgtrack_make_sequence" program
  local cpp=("$BUILD_DIR/bin/example_surgtrack_track_sequence")
  local python=(env PYTHONDONTWRITEBYTECODE=1 "PYTHONPATH=$BUILD_DIR/python_loader" "$PYTHON" "$REPO/samples/track_sequence.py")
  mkdir -p "$work/all"
  sample "make_sequence, a long one" limited "$make" --out="$work/all/long" --frames=200 --quiet
  sample "make_sequence, a short one" limited "$make" --out="$work/all/short" --frames=40 --seed=2 --quiet
  cp -r "$work/all/short" "$work/inverse"
  "$PYTHON" - "$work/inverse/sequence.yaml" <<'PYTHON'
import re, sys
import numpy as np
text = open(sys.argv[1]).read()
data = re.search(r"camera_T_base:.*?data: \[([^\]]*)\]", text, re.S)
inverse = np.linalg.inv(np.array([float(x) for x in data.group(1).split(",")]).reshape(4, 4))
open(sys.argv[1], "w").write(text[:data.start(1)] + ", ".join(repr(float(x)) for x in inverse.ravel()) + text[data.end(1):])
PYTHON
  "${cpp[0]}" --write-config="$work/params.yaml" --set seed=7
  for program in cpp python; do
    local -n track="$program"
    sample "$program: --version" exits 0 "cv::surgtrack on OpenCV" "${track[@]}" --version
    sample "$program: --check, a sound sequence" exits 0 ": 0 findings" "${track[@]}" --check --sequence="$work/all/short"
    sample "$program: --check, an inverse calibration" exits 1 "is it base_T_camera?" "${track[@]}" --check --sequence="$work/inverse"
    sample "$program: nothing was tracked, and why" exits 2 "$work/inverse/sequence.yaml: camera_T_base" "${track[@]}" --sequence="$work/inverse" --frames=5
    sample "$program: no times before that" lacks median
    sample "$program: nothing was kept" exits 0 "nothing was kept" "${track[@]}" --sequence="$work/all/short" --frames=3
    sample "$program: parameters" exits 0 "tracked in 100" "${track[@]}" --sequence="$work/all/short" --frames=3 --config="$work/params.yaml" \
      --set matcher.candidates=6 --set=minWindow=25
    sample "$program: refused: no such parameter" exits 1 "'matcher.none'" "${track[@]}" --sequence="$work/all/short" --set matcher.none=1
    sample "$program: refused: one out of its range" exits 1 "'matcher.minSimilarity': expected a number from 0 to 1, found '7'" "${track[@]}" \
      --sequence="$work/all/short" --set matcher.minSimilarity=7
    sample "$program: refused: one misspelt" exits 1 "did you mean 'matcher.minSimilarity'?" "${track[@]}" --set minSimilarty=0.6
    sample "$program: refused: an option misspelt" exits 1 "did you mean '--quiet'?" "${track[@]}" --quite
    sample "$program: quiet" prints_nothing "${track[@]}" --sequence="$work/all/short" --frames=3 --quiet
    sample "$program: Ctrl-C" interrupted "$work" "${track[@]}" --sequence="$work/all/long"
    rm -f "$work"/poses_*
    sample "$program: a folder of sequences" limited "${track[@]}" --sequence="$work/all" --frames=3 --poses="$work/poses.csv" --quiet
    sample "$program: the poses of one" poses_complete "$work/poses_long.csv" 3
    sample "$program: those of the other" poses_complete "$work/poses_short.csv" 3
  done
}
