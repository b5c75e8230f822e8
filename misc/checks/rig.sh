# shellcheck shell=bash
# How theatres record: both eyes in one file, fields, masks; and real stills. Sourced by misc/test.sh.

# other_rig SEQUENCE OUT KIND: the same images as side_by_side or interlaced ones, without loss; a frame of the latter holds two of them.
other_rig() {
  python_cv2 - "$1" "$2" "$3" <<'PYTHON'
import csv, os, shutil, sys
import cv2, numpy as np
source, out, kind = sys.argv[1:]
shutil.copytree(source, out)
eyes = []
for eye in ("left", "right"):
    video, images = cv2.VideoCapture("%s/%s.mp4" % (source, eye)), []
    while True:
        found, image = video.read()
        if not found:
            break
        images.append(image)
    eyes.append(images)
text = open(source + "/sequence.yaml").read()
if kind == "side_by_side":
    frames = [np.hstack(pair) for pair in zip(*eyes)]
    text = text.replace("right.mp4", "left.mp4") + "layout: side_by_side\n"
else:
    frames = []
    for k in range(0, len(eyes[0]) - 1, 2):
        frame = eyes[0][k].copy()
        frame[1::2] = eyes[0][k + 1][1::2]
        frames.append(frame)
    fps = next(line for line in text.splitlines() if line.startswith("fps:"))
    text = text.replace(fps, "fps: %r" % (float(fps.split()[1]) / 2)) + ("fields: top_first\n" if kind == "fields" else "")
    rows = list(csv.reader(open(source + "/groundtruth.csv", newline="")))
    with open(out + "/groundtruth.csv", "w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(rows[:1] + [[str(int(row[0]) // 2)] + row[1:] for row in rows[1:] if int(row[0]) % 2 == 0])
for k, frame in enumerate(frames):
    cv2.imwrite("%s/frame%03d.png" % (out, k), frame)
open(out + "/sequence.yaml", "w").write(text.replace("left.mp4", "frame%03d.png"))
PYTHON
}

# notes WORD COMMAND...: succeeds, and says so in one line.
notes() {
  local word="$1"
  shift
  limited "$@" 2>"$LOGS/stderr" && [[ "$(grep -c -F -e "$word" "$LOGS/stderr")" -eq 1 ]]
}

# silent COMMAND...: succeeds without a line on stderr.
silent() { limited "$@" 2>"$LOGS/stderr" && [[ ! -s "$LOGS/stderr" ]]; }

run_rig() {
  local work="$1/rig" track="$BUILD_DIR/bin/example_surgtrack_track_sequence" make="$BUILD_DIR/bin/example_surgtrack_make_sequence"
  local evaluate="$BUILD_DIR/bin/example_surgtrack_evaluate"
  local python=(env PYTHONDONTWRITEBYTECODE=1 "PYTHONPATH=$BUILD_DIR/python_loader" "$PYTHON" "$REPO/samples/track_sequence.py")
  rm -rf "$work"
  mkdir "$work"
  sample "make_sequence, two eyes" limited "$make" --out="$work/stereo" --frames=12 --stereo --seed=4
  sample "both eyes in one file" other_rig "$work/stereo" "$work/together" side_by_side
  local eyes
  for eyes in "" --stereo; do
    # shellcheck disable=SC2086
    sample "track_sequence, a file each $eyes" limited "$track" --sequence="$work/stereo" $eyes --poses="$work/separate.csv" --quiet
    # shellcheck disable=SC2086
    sample "the same, one file" silent "$track" --sequence="$work/together" $eyes --poses="$work/together.csv" --quiet
    sample "the same poses" cmp "$work/separate.csv" "$work/together.csv"
    # shellcheck disable=SC2086
    sample "the same in Python" silent "${python[@]}" --sequence="$work/together" $eyes --poses="$work/together.csv" --quiet
    sample "the same poses" cmp "$work/separate.csv" "$work/together.csv"
  done
  sample "evaluate, one file" limited "$evaluate" --sequences="$work/together" --stereo --out="$work/evaluation" --quiet
  cp -r "$work/together" "$work/wide"
  sed -i 's/side_by_side/top_bottom/' "$work/wide/sequence.yaml"
  sample "refused: frames of another layout" refuses "expected 720x1152" "$track" --sequence="$work/wide" --quiet
  sample "refused: the same in Python" refuses "expected 720x1152" "${python[@]}" --sequence="$work/wide" --quiet
  cp -r "$work/together" "$work/gap"
  rm "$work/gap/frame005.png"
  sample "refused: an image that is missing" refuses "ends after 5 images" "$track" --sequence="$work/gap" --quiet
  sample "refused: the same in Python" refuses "ends after 5 images" "${python[@]}" --sequence="$work/gap" --quiet

  sample "interlaced frames" other_rig "$work/stereo" "$work/interlaced" interlaced
  sample "interlaced frames, told" other_rig "$work/stereo" "$work/fields" fields
  sample "track_sequence says that they are" notes "fields: top_first" "$track" --sequence="$work/interlaced" --poses="$work/one.csv" --quiet
  sample "the same in Python" notes "fields: top_first" "${python[@]}" --sequence="$work/interlaced" --quiet
  sample "track_sequence, both fields" silent "$track" --sequence="$work/fields" --poses="$work/fields.csv" --quiet
  sample "its poses file: of the first ones" poses_complete "$work/fields.csv" 6
  sample "track_sequence.py, both fields" silent "${python[@]}" --sequence="$work/fields" --poses="$work/fields-python.csv" --quiet
  sample "the same poses" cmp "$work/fields.csv" "$work/fields-python.csv"
  sample "evaluate, both fields" limited "$evaluate" --sequences="$work/fields" --out="$work/evaluation-fields" --quiet
  sample "track_sequence, both fields, drawn ahead" limited "$track" --sequence="$work/fields" --render-ahead --poses="$work/ahead.csv" --quiet
  sample "its poses file" poses_complete "$work/ahead.csv" 6

  cp -r "$work/stereo" "$work/masked"
  python_cv2 -c 'import sys, cv2, numpy as np; cv2.imwrite(sys.argv[1], np.zeros((576, 720), np.uint8))' "$work/masked/mask.png"
  echo 'mask: mask.png' >>"$work/masked/sequence.yaml"
  sample "a mask that hides all" nothing_tracked "$work/masked" "$work/masked.csv" "$track"
  sample "the same in Python" nothing_tracked "$work/masked" "$work/masked-python.csv" "${python[@]}"
  sample "the same poses" cmp "$work/masked.csv" "$work/masked-python.csv"
  rm "$work/masked/mask.png"
  sample "refused: no mask there" refuses "key mask" "$track" --sequence="$work/masked" --quiet

  # Measured: all six tools, at both gains.
  sample "real stills, bright and dim" python_cv2 "$REPO/misc/checks/real_stills.py"
  cat "$LOGS/sample.log"
}

# nothing_tracked SEQUENCE POSES PROGRAM...: exit code 2, a row a frame all the same.
nothing_tracked() {
  local code=0
  limited "${@:3}" --sequence="$1" --poses="$2" --quiet || code=$?
  [[ $code -eq 2 ]] && ! grep -q tracking "$2" && poses_complete "$2" 12
}
