# shellcheck shell=bash
# Live tracking. Sourced by misc/test.sh.

# The loopback tests.
run_live() {
  local work="$1" live="$BUILD_DIR/bin/example_surgtrack_live" sender="$REPO/samples/send_joints.py"
  local python=(env "SURGTRACK_BIN=$BUILD_DIR/bin" "PYTHONPATH=$BUILD_DIR/python_loader" PYTHONDONTWRITEBYTECODE=1 "$PYTHON")
  run_unittest "Python tests, live" "$LOGS/test-live.log" "${python[@]}" "$REPO/misc/python/test/test_live.py"
  run_unittest "Python tests, ROS node" "$LOGS/test-ros2-node.log" "${python[@]}" "$REPO/misc/python/test/test_ros2_node.py"
  sample "refused: live without a sequence" refuses --sequence "$live"
  sample "refused: joints without kinematics" refuses "$work/none/kinematics.csv" "$PYTHON" "$sender" --sequence="$work/none"
  sample "refused: joints to nowhere" refuses "--to=nowhere" "$PYTHON" "$sender" --sequence="$work/sequence" --to=nowhere
}
