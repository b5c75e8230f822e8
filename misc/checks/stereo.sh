# shellcheck shell=bash
# Two eyes. Sourced by misc/test.sh.

# second_eye_helps STEREO_CSV MONO_CSV: the depth is known better, by the filter's own word, at the end.
second_eye_helps() {
  # shellcheck disable=SC2153
  "$PYTHON" - "$1" "$2" <<'PYTHON'
import csv, sys
stereo, mono = (list(csv.DictReader(open(name, newline="")))[-1] for name in sys.argv[1:3])
assert stereo["status"] == mono["status"] == "tracking", (stereo, mono)
assert float(stereo["sd_tz"]) < float(mono["sd_tz"]), (stereo["sd_tz"], mono["sd_tz"])
PYTHON
}

# names_exchanged_eyes COMMAND...: without being told to look at both.
names_exchanged_eyes() {
  local output
  output="$(limited "$@" 2>&1 || true)"
  grep -q 'are the eyes exchanged' <<<"$output" || { echo "$output"; return 1; }
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

  cp -r "$work/stereo" "$work/exchanged"
  cp "$work/stereo/left.mp4" "$work/exchanged/right.mp4"
  cp "$work/stereo/right.mp4" "$work/exchanged/left.mp4"
  sample "--check names exchanged eyes" names_exchanged_eyes "$track" --sequence="$work/exchanged" --check
  sample "--check of track_sequence.py, too" names_exchanged_eyes "${python[@]}" --sequence="$work/exchanged" --check

  sample "what is learnt of joints is kept" "$track" --sequence="$work/stereo" --frames=10 --tool-state="$work/state.yaml" --quiet
  sample "and read, in Python" "${python[@]}" --sequence="$work/stereo" --frames=3 --tool-state="$work/state.yaml" --quiet
  sed 's/q6 gain/q9 gain/' "$work/state.yaml" >"$work/other.yaml"
  sample "refused: that of another tool" refuses "other.yaml: tool 'PSM1': errors.names" "$track" --sequence="$work/stereo" --tool-state="$work/other.yaml"
  sample "refused: the same in Python" refuses "other.yaml: tool 'PSM1': errors.names" "${python[@]}" --sequence="$work/stereo" --tool-state="$work/other.yaml"
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
