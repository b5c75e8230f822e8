# shellcheck shell=bash
# The fuzz targets, for a moment each and of the module as it is built. Sourced by misc/test.sh; misc/fuzz.sh does it in earnest.

# fuzz_briefly TARGET RUNS: the corpus, and so many inputs made of it.
fuzz_briefly() {
  (cd "$BUILD_DIR/fuzz" && limited "./fuzz_$1" "-runs=$2" "$REPO/fuzz/corpus/$1")
}

run_fuzz() {
  local file name
  sample "fuzz targets: configured" cmake -G Ninja -S "$REPO/fuzz" -B "$BUILD_DIR/fuzz" "-DOpenCV_DIR=$BUILD_DIR" -DFUZZ_REPLAY=ON -DFUZZ_MODULE=ON
  sample "fuzz targets: built" cmake --build "$BUILD_DIR/fuzz" --parallel "$JOBS"
  for file in "$REPO"/fuzz/fuzz_*.cpp; do
    name="$(basename "$file" .cpp)"
    name="${name#fuzz_}"
    sample "fuzz: $name" fuzz_briefly "$name" "$([[ $name == tracker ]] && echo 40 || echo 2000)"
  done
}
