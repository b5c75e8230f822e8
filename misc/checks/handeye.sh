# shellcheck shell=bash
# Hand-eye calibration. Sourced by misc/test.sh.

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
}
