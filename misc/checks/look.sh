# shellcheck shell=bash
# Pictures, plots, the scene from outside. Sourced by misc/test.sh.

# pictures_of_frame DIR FRAME TOOL: one a stage, readable, with more than one colour, and the sheet.
pictures_of_frame() {
  python_cv2 - "$1/$(printf '%06d' "$2")_$3" <<'PYTHON'
import sys, cv2
stages = ["1_view", "2_orientations", "3_templates", "4_similarity", "5_context", "6_contour"]
pictures = {s: cv2.imread("%s_%s.png" % (sys.argv[1], s)) for s in stages}
for stage, picture in pictures.items():
    assert picture is not None and picture.std() > 5, stage
view = pictures["1_view"].shape
assert 500 <= view[1] <= 1100, view   # 720, by a whole factor
for stage in ("2_orientations", "5_context"):   # two beside each other
    assert pictures[stage].shape[0] == view[0] and pictures[stage].shape[1] >= 2 * view[1], stage
assert pictures["6_contour"].shape == view
assert cv2.imread(sys.argv[1] + ".jpg").shape[1] == 1440
PYTHON
}

# timings_sound CSV FRAMES
timings_sound() {
  "$PYTHON" - "$1" "$2" <<'PYTHON'
import csv, sys
rows = list(csv.DictReader(open(sys.argv[1], newline="")))
assert len(rows) == int(sys.argv[2]) and list(rows[0])[:2] == ["frame", "time"] and list(rows[0])[-1] == "total", rows[0]
for row in rows:
    assert 0 < sum(float(row[c]) for c in list(row)[2:-1]) <= 1.01 * float(row["total"]), row
PYTHON
}

# What is to be looked at: pictures of the stages, plots of a run, the scene from outside.
run_look() {
  local work="$1" frames=6 track="$BUILD_DIR/bin/example_surgtrack_track_sequence" view="$BUILD_DIR/bin/example_surgtrack_view3d"
  local plot=("$PYTHON" "$REPO/samples/plot_run.py") name
  sample "make_sequence, to look at" limited "$BUILD_DIR/bin/example_surgtrack_make_sequence" --out="$work/seen" --frames="$frames" --tools=2 \
    --distortion --seed=8
  sample "track_sequence, with pictures" limited "$track" --sequence="$work/seen" --poses="$work/seen.csv" --timings="$work/timings.csv" \
    --debug="$work/debug" --debug-frames=0,4 --quiet
  sample "the same poses as without" limited "$track" --sequence="$work/seen" --poses="$work/unseen.csv" --quiet
  sample "they are the same" cmp "$work/seen.csv" "$work/unseen.csv"
  for name in $(tail -n +2 "$work/seen.csv" | cut -d, -f3 | sort -u); do
    sample "pictures of $name at first" pictures_of_frame "$work/debug" 0 "$name"
    sample "pictures of $name" pictures_of_frame "$work/debug" 4 "$name"
  done
  sample "no others" test "$(find "$work/debug" -type f | wc -l)" -eq 28
  sample "its times" timings_sound "$work/timings.csv" "$frames"
  sample "track_sequence, pictures of every third frame" limited "$track" --sequence="$work/seen" --method=paper --debug="$work/debug3" \
    --debug-frames=every:3 --start=1 --quiet
  sample "two of them" test "$(find "$work/debug3" -name '*_1_view.png' | wc -l)" -eq 4
  sample "refused: frames that are no numbers" refuses "'--debug-frames=1,x'" "$track" --sequence="$work/seen" --debug="$work/debug" \
    --debug-frames=1,x
  sample "refused: frames without a folder" refuses "--debug=DIR" "$track" --sequence="$work/seen" --debug-frames=1
  sample "refused: frames that are not there" refuses "none of these frames" "$track" --sequence="$work/seen" --debug="$work/debug" \
    --debug-frames=99 --quiet
  sample "refused: pictures into a file" refuses "$work/seen.csv" "$track" --sequence="$work/seen" --debug="$work/seen.csv" --quiet
  sample "refused: times into no folder" refuses "$work/none/t.csv" "$track" --sequence="$work/seen" --timings="$work/none/t.csv" --quiet

  if limited "$view" --sequence="$work/seen" --poses="$work/seen.csv" --out="$work/scene.png" 2>"$LOGS/view3d.log" ||
    ! grep -q 'VTK can draw neither' "$LOGS/view3d.log"; then
    sample "view3d" limited "$view" --sequence="$work/seen" --poses="$work/seen.csv" --frame=3 --out="$work/scene.png"
    sample "its picture" python_cv2 -c 'import sys, cv2; assert cv2.imread(sys.argv[1]).std() > 10' "$work/scene.png"
    sample "refused: no such picture" refuses "$work/none/scene.png" "$view" --sequence="$work/seen" --poses="$work/seen.csv" \
      --out="$work/none/scene.png"
    sample "refused: a window without a display" refuses "display" env -u DISPLAY "$view" --sequence="$work/seen" --poses="$work/seen.csv" --window
  else
    echo "skipped: view3d, which needs OpenGL"
  fi
  sample "refused: nothing to show it in" refuses "--window" "$view" --sequence="$work/seen" --poses="$work/seen.csv"
  sample "refused: no poses file" refuses "$work/none.csv" "$view" --sequence="$work/seen" --poses="$work/none.csv" --out="$work/scene.png"
  sample "refused: no such frame" refuses "frame 99" "$view" --sequence="$work/seen" --poses="$work/seen.csv" --frame=99 --out="$work/scene.png"

  if "$PYTHON" -c 'import matplotlib' 2>/dev/null; then
    sample "plot_run.py" limited "${plot[@]}" "$work/seen.csv" --timings="$work/timings.csv" --sequence="$work/seen" --out="$work/plots"
    for name in poses evidence offsets errors timings; do
      sample "its $name.png" test -s "$work/plots/$name.png"
    done
    sample "refused: plots into a file" refuses "$work/seen.csv" "${plot[@]}" "$work/seen.csv" --out="$work/seen.csv"
  else
    echo "skipped: the plots of plot_run.py, which need matplotlib"
  fi
  sample "refused: plots of no poses" refuses "$work/none.csv" "${plot[@]}" "$work/none.csv"
  sample "refused: plots of something else" refuses "'tool'" "${plot[@]}" "$work/timings.csv"
  sed '3s/tracking,[^,]*/tracking,x/' "$work/seen.csv" >"$work/broken.csv"
  sample "refused: plots of a broken file" refuses "broken.csv, line 3" "${plot[@]}" "$work/broken.csv"
}
