#!/usr/bin/env bash
# Times the module beside its peers in OpenCV: cv::linemod and cv::rapid of opencv_contrib, and OpenCV's own filters.

set -euo pipefail

usage() {
  cat <<'TEXT'
usage: misc/compare_peers.sh [--help] [SAMPLES]

Installs what is missing (apt), gets OpenCV's source and opencv_contrib's, builds the module's performance tests together with
opencv_contrib's modules rgbd (cv::linemod) and rapid, and runs those that have a peer: one thread, SAMPLES timings each
(default: 50), in one process. Prints a table of the medians and their ratios. Needs no display.

With SEQUENCES it also tracks these, and prints how far off the poses are and how many frames a second there are, in one run: ours,
ours without parts (contour) and cv::rapid, both from the true pose of the first frame, the controls, and poses of other programs.

Leaves in the build folder:
  peers.md, peers.csv   the table
  peers.xml             what the performance tests measured
  poses/                what example_surgtrack_evaluate writes of SEQUENCES

environment:
  BUILD_DIR               build folder, kept for the next run (default: build-peers/ in the repository)
  OPENCV_SOURCE           OpenCV source tree, 4.6 or newer (default: that of build/, else the distribution's source package,
                          else a git clone of 4.10.0)
  OPENCV_CONTRIB_SOURCE   opencv_contrib source tree of the same version (default: OPENCV_SOURCE/contrib, where Debian's
                          source package has it, else a git clone)
  SEQUENCES               folders of sequences with groundtruth.csv, separated by commas (default: none)
  POSES                   NAME:FILE,...: poses of other programs, see --poses of example_surgtrack_evaluate (default: none)
  JOBS                    parallel compilations (default: number of processors)
TEXT
}

samples=50
case "${1:-}" in
  '') ;;
  -h | --help) usage; exit 0 ;;
  *[!0-9]* | 0) usage >&2; exit 1 ;;
  *) samples="$1" ;;
esac
[[ $# -le 1 ]] || { usage >&2; exit 1; }

here="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd -P)"
BUILD_DIR="${BUILD_DIR:-$here/../build-peers}"
if [[ -z "${OPENCV_SOURCE:-}" && -f "$here/../build/opencv-src/CMakeLists.txt" ]]; then
  OPENCV_SOURCE="$here/../build/opencv-src"
fi
# shellcheck source=misc/common.sh
source "$here/common.sh"

is_contrib() { [[ -f "$1/modules/rgbd/src/linemod.cpp" && -f "$1/modules/rapid/CMakeLists.txt" ]]; }

# The branch or tag of opencv_contrib that belongs to OPENCV_SOURCE.
contrib_branch() {
  local version
  version="$(source_version "$OPENCV_SOURCE")"
  if grep -q '#define CV_VERSION_STATUS *"-dev"' "$OPENCV_SOURCE/modules/core/include/opencv2/core/version.hpp"; then
    echo "${version%%.*}.x"
  else
    echo "$version"
  fi
}

# Sets OPENCV_CONTRIB_SOURCE to a folder with opencv_contrib's source.
ensure_contrib() {
  local branch
  if [[ -n "${OPENCV_CONTRIB_SOURCE:-}" ]]; then
    is_contrib "$OPENCV_CONTRIB_SOURCE" ||
      die "OPENCV_CONTRIB_SOURCE is not opencv_contrib's source (modules/rgbd and modules/rapid): $OPENCV_CONTRIB_SOURCE"
    OPENCV_CONTRIB_SOURCE="$(cd "$OPENCV_CONTRIB_SOURCE" && pwd -P)"
  elif is_contrib "$OPENCV_SOURCE/contrib"; then
    OPENCV_CONTRIB_SOURCE="$OPENCV_SOURCE/contrib"
  else
    OPENCV_CONTRIB_SOURCE="$BUILD_DIR/opencv-contrib-src"
    if ! is_contrib "$OPENCV_CONTRIB_SOURCE"; then
      branch="$(contrib_branch)"
      step "Cloning opencv_contrib $branch"
      if ! command -v git >/dev/null && have_apt; then install_packages git ca-certificates; fi
      command -v git >/dev/null || die "git was not found: set OPENCV_CONTRIB_SOURCE"
      rm -rf "$OPENCV_CONTRIB_SOURCE"
      run_logged "$LOGS/opencv-contrib-source.log" \
        "opencv_contrib could not be fetched; is there a network? OPENCV_CONTRIB_SOURCE names a source tree to use instead" \
        git clone --depth 1 -b "$branch" https://github.com/opencv/opencv_contrib "$OPENCV_CONTRIB_SOURCE"
      is_contrib "$OPENCV_CONTRIB_SOURCE" || die "opencv_contrib $branch lacks modules/rgbd/src/linemod.cpp or modules/rapid"
    fi
  fi
  echo "opencv_contrib in $OPENCV_CONTRIB_SOURCE"
}

prepare
ensure_contrib
# shellcheck disable=SC2054
CONFIGURATION=("-DOPENCV_EXTRA_MODULES_PATH=$REPO;$OPENCV_CONTRIB_SOURCE/modules/rgbd;$OPENCV_CONTRIB_SOURCE/modules/rapid"
  -DBUILD_LIST=surgtrack,rgbd,rapid,ts "-DBUILD_EXAMPLES=$([[ -n "${SEQUENCES:-}" ]] && echo ON || echo OFF)" -DBUILD_TESTS=OFF -DBUILD_opencv_python3=OFF)
build opencv_perf_surgtrack ${SEQUENCES:+example_surgtrack_evaluate}

step "Measuring ($samples samples each, one thread)"
report="$BUILD_DIR/peers"
code=0
env -u DISPLAY timeout -k 10 1800 "$BUILD_DIR/bin/opencv_perf_surgtrack" --perf_threads=1 --perf_strategy=simple \
  --perf_min_samples="$samples" --perf_force_samples="$samples" --gtest_output="xml:$report.xml" \
  --gtest_filter="$("$PYTHON" "$REPO/misc/compare_peers.py" --filter)" >"$LOGS/peers.log" 2>&1 || code=$?
if [[ $code -ne 0 ]]; then
  grep -a -E '\[  FAILED  \]|Failure|xception' "$LOGS/peers.log" >&2 || true
  die "opencv_perf_surgtrack failed with exit code $code (log: $LOGS/peers.log)"
fi

step "Ours and theirs"
"$PYTHON" "$REPO/misc/compare_peers.py" "$report.xml" "$report.md" "$report.csv" || die "no table could be made of $report.xml"
echo
echo "$report.md"

if [[ -n "${SEQUENCES:-}" ]]; then
  step "Poses of ours and of theirs"
  env -u DISPLAY "$BUILD_DIR/bin/example_surgtrack_evaluate" --sequences="$SEQUENCES" --methods=full --baselines=contour,rapid --quiet \
    --out="$BUILD_DIR/poses" ${POSES:+"--poses=$POSES"} || die "example_surgtrack_evaluate failed"
  echo "$BUILD_DIR/poses/report.md"
fi
