# shellcheck shell=bash
# The commands and Python programs of README.md and doc/, and Doxygen. Sourced by misc/test.sh.

# doc_page PAGE FOLDER: its blocks run in FOLDER, which looks like the repository after misc/demo.sh. `their_demo` is what that leaves,
# `without` what cannot run here.
doc_page() {
  rm -rf "$2"
  PYTHONDONTWRITEBYTECODE=1 limited "$PYTHON" "$REPO/misc/run_doc.py" "$1" --folder="$2" --build="$BUILD_DIR" --demo="$their_demo" "${without[@]}"
}

# doc_links: files and titles that pages link to are there, and so are the files of the repository they only name; README.md's list
# has each page once. README.md has at most 900 words, doc/ at most 8 pages.
doc_links() {
  "$PYTHON" - "$REPO" <<'PYTHON'
import glob, os, re, sys
root, bad = sys.argv[1], []
mostWords, mostPages = 900, 8
pages = sorted(glob.glob(os.path.join(root, "doc", "*.md"))) + [os.path.join(root, "README.md")]
anchors = {}
for page in pages:
    text = re.sub(r"^```.*?^```", "", open(page).read(), flags=re.M | re.S)
    titles = re.findall(r"^#+ (.*)$", text, re.M)
    anchors[page] = {re.sub(r"[^\w\- ]", "", t.lower()).replace(" ", "-") for t in titles}
for page in pages:
    text = open(page).read()
    for name in re.findall(r"`((?:include|src|samples|test|perf|misc|doc)/[\w./]*\.\w+)\b", text):
        if not os.path.exists(os.path.join(root, name)):
            bad.append("%s: %s" % (os.path.relpath(page, root), name))
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if re.match(r"\w+:", target):
            continue
        path, _, anchor = target.partition("#")
        file = os.path.normpath(os.path.join(os.path.dirname(page), path)) if path else page
        if not os.path.exists(file) or (anchor and file.endswith(".md") and anchor not in anchors[file]):
            bad.append("%s: %s" % (os.path.relpath(page, root), target))
readme = open(os.path.join(root, "README.md")).read()
if len(readme.split()) > mostWords:
    bad.append("README.md: %d words, expected at most %d" % (len(readme.split()), mostWords))
if len(pages) - 1 > mostPages:
    bad.append("doc: %d pages, expected at most %d" % (len(pages) - 1, mostPages))
listed = re.findall(r"^- \[.*?\]\((doc/\S+\.md)\)", readme, re.M)
expected = sorted(os.path.relpath(page, root) for page in pages[:-1])
if sorted(listed) != expected:
    bad.append("README.md lists %s, expected %s" % (sorted(listed), expected))
sys.exit("\n".join(bad) or 0)
PYTHON
}

# doc_compiles PAGE: its C++ blocks, as one file.
doc_compiles() {
  local include=() module
  for module in core imgproc calib3d features2d flann imgcodecs videoio; do include+=("-I$OPENCV_SOURCE/modules/$module/include"); done
  # shellcheck disable=SC2016
  sed -n '/^```cpp$/,/^```$/p' "$1" | sed '/^```/d' | limited c++ -x c++ -std=c++11 -fsyntax-only -I"$BUILD_DIR" -I"$OPENCV_SOURCE/include" \
    -I"$REPO/include" "${include[@]}" -
}

# Whether view3d can draw here; what else is wrong with it is for others to find.
draws_with_opengl() {
  limited "$BUILD_DIR/bin/example_surgtrack_view3d" --sequence="$their_demo/sequence" --poses="$their_demo/poses.csv" \
    --out="$their_demo/scene.png" >/dev/null 2>"$LOGS/view3d.log" || ! grep -q 'VTK can draw neither' "$LOGS/view3d.log"
}

run_docs() {
  local work="$1/docs" their_demo="$1/docs/demo" page name plots=yes without=()
  mkdir -p "$their_demo"
  sample "what demo.sh leaves: a sequence" limited "$BUILD_DIR/bin/example_surgtrack_make_sequence" --out="$their_demo/sequence" --quiet
  sample "what demo.sh leaves: its poses" limited "$BUILD_DIR/bin/example_surgtrack_track_sequence" --sequence="$their_demo/sequence" \
    --poses="$their_demo/poses.csv" --quiet
  if ! "$PYTHON" -c 'import matplotlib' 2>/dev/null; then
    echo "skipped: plots in pages, which need matplotlib"
    plots=''
    without+=(--without=plot_)
  fi
  if ! draws_with_opengl; then
    echo "skipped: view3d in pages, which needs OpenGL"
    without+=(--without=view3d)
  fi
  for page in "$REPO/README.md" "$REPO"/doc/*.md; do
    grep -q -E '^```(sh|python)$' "$page" || continue
    name="${page#"$REPO"/}"
    if [[ -z "$plots" ]] && grep -q '^import matplotlib' "$page"; then
      echo "skipped: $name, which needs matplotlib"
      continue
    fi
    sample "run_doc.py $name" doc_page "$page" "$work/$(basename "$page" .md)"
  done
  if [[ -d "$work/python" ]]; then
    while read -r name; do
      sample "its picture $name" test -s "$work/python/$name" -a -s "$REPO/doc/pics/$name"
    done < <(sed -nE 's/^!\[.*\]\(pics\/(.*)\)$/\1/p' "$REPO/doc/python.md")
  fi
  for page in "$REPO/README.md" "$REPO"/doc/*.md; do
    if grep -q '^```cpp$' "$page"; then sample "C++ of ${page#"$REPO"/}" doc_compiles "$page"; fi
  done
  sample "poses of doc/live.md" poses_complete "$work/live/poses.csv" 100
  # shellcheck disable=SC2016
  printf '# A page\n\n```python\na = 1\n```\ntext\n```python\nb = a.c\n```\n' >"$work/page.md"
  sample "refused: an error in a page" refuses "page.md, line 8" "$PYTHON" "$REPO/misc/run_doc.py" "$work/page.md" --folder="$work/page"
  # shellcheck disable=SC2016
  printf '# A page\n\n```sh\ntrue\n\nfalse\ntrue\n```\n' >"$work/page.md"
  sample "refused: a command that fails" refuses "page.md, line 6" "$PYTHON" "$REPO/misc/run_doc.py" "$work/page.md" --folder="$work/page"
  sample "what cannot run here is left out" "$PYTHON" "$REPO/misc/run_doc.py" "$work/page.md" --folder="$work/page" --without=false
  sample "links of the pages" doc_links
  if command -v doxygen >/dev/null; then
    sample "Doxygen without a warning" limited "$REPO/misc/doxygen.sh" "$work/doxygen"
  else
    echo "skipped: Doxygen, which is not there"
  fi
}
