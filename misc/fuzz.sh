#!/usr/bin/env bash
# Fuzzes parsers and the tracker: the targets of fuzz/, by clang's libFuzzer with AddressSanitizer and UBSan.

set -euo pipefail

usage() {
  cat <<'TEXT'
usage: misc/fuzz.sh [SECONDS [TARGET...]]

Builds the module with clang (coverage, -fsanitize=address,undefined) on top of the OpenCV of BUILD_DIR, which is built first where it is
missing and is not instrumented itself, and runs each target for so many seconds (60). Targets: the fuzz_NAME.cpp of fuzz/, all of them
unless some are named. What is found stays in BUILD_DIR/fuzz-found; the exit code is then 1. New inputs that cover more are kept in
BUILD_DIR/fuzz-corpus for the next time; those in fuzz/corpus are the first ones.
TEXT
}

case "${1:-}" in
  -h | --help) usage; exit 0 ;;
  '' | [1-9]*) ;;
  *) usage >&2; exit 1 ;;
esac

# shellcheck source=misc/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
seconds="${1:-60}"
shift || true
PACKAGES+=(clang)
prepare
build opencv_surgtrack
command -v clang++ >/dev/null || die "clang was not found"

step "Building the targets"
work="$BUILD_DIR/fuzz-clang"
run_logged "$LOGS/fuzz-configure.log" "cmake failed" env CXX=clang++ cmake -G Ninja -S "$REPO/fuzz" -B "$work" "-DOpenCV_DIR=$BUILD_DIR"
cmake --build "$work" --parallel "$JOBS"

targets=("$@")
if [[ ${#targets[@]} -eq 0 ]]; then
  for file in "$REPO"/fuzz/fuzz_*.cpp; do
    targets+=("$(basename "$file" .cpp)")
  done
fi
found="$BUILD_DIR/fuzz-found"
mkdir -p "$found"
[[ -d /dev/shm ]] && export FUZZ_FOLDER=/dev/shm
export OPENCV_LOG_LEVEL=SILENT "LSAN_OPTIONS=suppressions=$REPO/misc/lsan.supp:print_suppressions=0"
failed=0
printf '%-14s %12s %10s  %s\n' target inputs covered result
for target in "${targets[@]}"; do
  name="${target#fuzz_}"
  program="$work/fuzz_$name"
  [[ -x "$program" ]] || die "there is no target $name"
  corpus="$BUILD_DIR/fuzz-corpus/$name"
  mkdir -p "$corpus"
  result=nothing
  "$program" "-max_total_time=$seconds" -timeout=20 -rss_limit_mb=3000 -max_len=8192 -print_final_stats=1 "-artifact_prefix=$found/$name-" \
    "$corpus" "$REPO/fuzz/corpus/$name" >"$LOGS/fuzz-$name.log" 2>&1 || { result="FOUND: $LOGS/fuzz-$name.log"; failed=1; }
  inputs="$(sed -n 's/^stat::number_of_executed_units: *//p' "$LOGS/fuzz-$name.log")"
  covered="$(sed -nE 's/.* cov: ([0-9]+) .*/\1/p' "$LOGS/fuzz-$name.log" | tail -n 1)"
  printf '%-14s %12s %10s  %s\n' "$name" "${inputs:--}" "${covered:--}" "$result"
done
exit "$failed"
