# shellcheck shell=bash
# The type stubs. Sourced by misc/test.sh.

# The stubs, and a user's program that type checkers have to accept but for one line.
run_python_docs() {
  local work="$1"
  sample "make_stubs.py: the stubs are up to date" python_cv2 "$REPO/misc/python/make_stubs.py" --check
  if "$PYTHON" -c 'import mypy' 2>/dev/null; then
    sample "mypy: the stubs" env "MYPYPATH=$REPO/misc/python/stubs" "$PYTHON" -m mypy --strict --cache-dir="$work/mypy" \
      "$REPO/misc/python/stubs/cv2/surgtrack.pyi"
    sample "mypy: a user's program" env "MYPYPATH=$REPO/misc/python/stubs" "$PYTHON" -m mypy --strict --cache-dir="$work/mypy" \
      "$REPO/misc/python/test/typed_user.py"
    sed 's/tracker.addTool(model/tracker.addTool(model.name()/' "$REPO/misc/python/test/typed_user.py" >"$work/wrong_user.py"
    sample "mypy: a wrong one" mypy_refuses 'Argument 1 to "addTool"' "$work" "$work/wrong_user.py"
  else
    echo "skipped: the type stubs, which need mypy to be checked"
  fi
  sample "the user's program" python_cv2 "$REPO/misc/python/test/typed_user.py"
}

# mypy_refuses MESSAGE FOLDER FILE
mypy_refuses() {
  local code=0
  env "MYPYPATH=$REPO/misc/python/stubs" "$PYTHON" -m mypy --strict --cache-dir="$2/mypy" "$3" >"$LOGS/mypy.log" 2>&1 || code=$?
  grep -q -F -e "$1" "$LOGS/mypy.log" && [[ $code -eq 1 ]]
}
