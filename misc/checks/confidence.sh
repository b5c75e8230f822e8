# shellcheck shell=bash
# fit_confidence.py. Sourced by misc/test.sh.

# confidence_sound LOG CSV: all four coefficients, both tables, and samples of which each is a pose.
confidence_sound() {
  "$PYTHON" - "$1" "$2" <<'PYTHON'
import csv, re, sys
text, rows = open(sys.argv[1]).read(), list(csv.DictReader(open(sys.argv[2], newline="")))
for name in ("parts", "support", "nis", "constant"):
    assert re.search(r"^ +%s +[-0-9.]+ +[-0-9.]+ \+- [0-9.]+$" % name, text, re.M), name
assert text.count("on what is held out: log loss") == 2, text
assert rows and "%d poses" % len(rows) in text, len(rows)
for r in rows:
    assert 0 <= float(r["similarity"]) <= 1 and 0 <= float(r["support"]) <= 1 and float(r["nis"]) >= 0 and r["right"] in "01", r
assert any(r["right"] == "1" for r in rows), "no pose is right"
PYTHON
}

# fits_confidence FOLDER SEQUENCE
fits_confidence() {
  mkdir -p "$1"
  limited env "PYTHONPATH=$BUILD_DIR/python_loader" PYTHONDONTWRITEBYTECODE=1 "$PYTHON" "$REPO/misc/fit_confidence.py" "$2" --scenes=0 \
    --starts=6 --length=2 --samples="$1/samples.csv" >"$1/fit.txt"
}

run_confidence() {
  local work="$1/confidence"
  sample "fit_confidence.py" fits_confidence "$work" "$1/sequence"
  sample "its coefficients, tables and samples" confidence_sound "$work/fit.txt" "$work/samples.csv"
  sample "refused: nothing to fit" refuses "no pose" env "PYTHONPATH=$BUILD_DIR/python_loader" "$PYTHON" "$REPO/misc/fit_confidence.py" --scenes=0
}
