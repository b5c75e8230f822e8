#!/usr/bin/env bash
# Builds the module within OpenCV and tracks a sequence with it.

set -euo pipefail

usage() {
  cat <<'TEXT'
usage: misc/demo.sh [--help] [SEQUENCE [OPTION...]]

Installs what is missing (apt), gets OpenCV's source, builds the module and tracks a sequence: the folder SEQUENCE (format:
doc/formats.md), or without it a synthetic one that is made first, from the built-in tool. OPTIONs go to track_sequence, such
as --method=paper, --stereo or --frames=50. Needs no display.

Leaves in demo/:
  overlay.mp4   the video; in red the tool where the recorded kinematics has it, in green where it was found
  overlay.png   one frame of it
  poses.csv     the pose of each tool in each frame

environment:
  DEMO_DIR        output folder (default: demo/ in the repository)
  BUILD_DIR       build folder, kept for the next run (default: build/ in the repository)
  OPENCV_SOURCE   OpenCV source tree, 4.6 or newer (default: the distribution's source package, else a git clone of 4.10.0)
  JOBS            parallel compilations (default: number of processors)
  PYTHON          interpreter that the bindings are built for (default: python3 in PATH, if it has numpy and headers)
TEXT
}

sequence=''
case "${1:-}" in
  '') ;;
  -h | --help) usage; exit 0 ;;
  -*) usage >&2; exit 1 ;;
  *) sequence="$1"; shift ;;
esac
if [[ -n "$sequence" ]]; then
  [[ -d "$sequence" ]] || { echo "error: no such folder: $sequence" >&2; exit 1; }
  sequence="$(cd "$sequence" && pwd -P)"
fi

# shellcheck source=misc/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
DEMO_DIR="${DEMO_DIR:-$REPO/demo}"

prepare
build opencv_surgtrack opencv_samples_surgtrack opencv_python3

mkdir -p "$DEMO_DIR" || die "cannot make the folder $DEMO_DIR"
DEMO_DIR="$(cd "$DEMO_DIR" && pwd -P)"

if [[ -z "$sequence" ]]; then
  step "Making a synthetic sequence"
  sequence="$DEMO_DIR/sequence"
  "$BUILD_DIR/bin/example_surgtrack_make_sequence" --out="$sequence" || die "make_sequence failed, see above"
fi

step "Tracking $sequence"
"$BUILD_DIR/bin/example_surgtrack_track_sequence" --sequence="$sequence" --poses="$DEMO_DIR/poses.csv" \
  --video="$DEMO_DIR/overlay.mp4" "$@" || die "track_sequence failed, see above"

python_cv2 - "$DEMO_DIR/overlay.mp4" "$DEMO_DIR/overlay.png" <<'PYTHON' || die "no frame of the overlay video could be saved"
import sys
import cv2
video = cv2.VideoCapture(sys.argv[1])
wanted = int(video.get(cv2.CAP_PROP_FRAME_COUNT)) * 2 // 3
picture = None
for _ in range(wanted + 1):
    found, frame = video.read()
    if not found:
        break
    picture = frame
if picture is None or not cv2.imwrite(sys.argv[2], picture):
    sys.exit("%s: no frame can be read, or %s cannot be written" % tuple(sys.argv[1:3]))
PYTHON

step "Done"
echo "video    $DEMO_DIR/overlay.mp4"
echo "picture  $DEMO_DIR/overlay.png"
echo "poses    $DEMO_DIR/poses.csv"
