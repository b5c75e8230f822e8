# shellcheck shell=bash
# The module installed, moved, and used from there; the other ways to build it. Sourced by misc/test.sh.

# installs_into DIR: what was built; then DIR/first is moved to DIR/there.
installs_into() {
  local component
  for component in libs plugins dev python licenses samples docs; do
    cmake --install "$BUILD_DIR" --prefix "$1/first" --component "$component" || return 1
  done
  mv "$1/first" "$1/there"
}

# holds DIR FILE...
holds() {
  local dir="$1" file
  shift
  for file in "$@"; do
    compgen -G "$dir/$file" >/dev/null || { echo "$file was not installed"; return 1; }
  done
}

# stays_inside DIR: nothing there is looked for in the build folder or in the first place.
stays_inside() {
  local file path
  while IFS= read -r file; do
    path="$(readelf -d "$file" 2>/dev/null | sed -nE 's/.*R(UN)?PATH.*\[(.*)\]/\2/p')"
    [[ "$path" != *"$BUILD_DIR"* && "$path" != *first* ]] || { echo "$file: $path"; return 1; }
  done < <(find "$1/bin" "$1/lib" -type f \( -name '*.so*' -o -name 'example_*' \))
}

# loads_from DIR FILE...: all OpenCV's libraries that FILE loads are those of DIR.
loads_from() {
  local dir="$1" list
  shift
  list="$(env -u LD_LIBRARY_PATH ldd "$@" | grep -F libopencv)" || return 1
  ! grep -v -F "$dir/" <<<"$list"
}

# A user's project: README's C++ program, with nothing named but the component.
user_builds() {
  local dir="$1" config="$2"
  mkdir -p "$dir"
  sed -n '/^```cpp$/,/^```$/p' "$REPO/README.md" | sed '1d;$d' >"$dir/program.cpp"
  cat >"$dir/CMakeLists.txt" <<'CMAKE'
cmake_minimum_required(VERSION 3.5)
project(program CXX)
find_package(OpenCV REQUIRED COMPONENTS surgtrack)
add_executable(program program.cpp)
target_link_libraries(program ${OpenCV_LIBS})
CMAKE
  cmake -S "$dir" -B "$dir/build" "-DOpenCV_DIR=$config" && cmake --build "$dir/build"
}

# tracks_in DIR PROGRAM...: in a folder with demo/sequence, PROGRAM prints a line a frame and tool.
tracks_in() {
  local dir="$1"
  shift
  (cd "$dir" && limited "$@") >"$LOGS/program.log" 2>&1 && [[ "$(grep -c tracking "$LOGS/program.log")" -ge 20 ]]
}

# configures DIR OPTION...: OpenCV with the module, and nothing is built.
configures() {
  local dir="$1" off=("${WITHOUT[@]/#/-DWITH_}")
  shift
  rm -rf "$dir"
  mkdir -p "$dir"
  cmake -G Ninja -S "$OPENCV_SOURCE" -B "$dir" "-DOPENCV_EXTRA_MODULES_PATH=$REPO" -DBUILD_LIST=surgtrack,highgui,world -DBUILD_opencv_apps=OFF -DBUILD_TESTS=OFF \
    -DBUILD_PERF_TESTS=OFF "${off[@]/%/=OFF}" "-DOPENCV_DOWNLOAD_PATH=$BUILD_DIR/.cache" "$@" >"$dir.log" 2>&1
}

# stays_outside DIR: opencv_world does not hold the module, which is linked with it.
stays_outside() {
  configures "$1" -DBUILD_opencv_world=ON || return 1
  ninja -C "$1" -t commands opencv_surgtrack | grep -e '-shared .*-o lib/libopencv_surgtrack.* lib/libopencv_world' >/dev/null &&
    ! ninja -C "$1" -t commands opencv_world | grep -e "$REPO/src" >/dev/null
}

# links_statically DIR: a static build, made of what is compiled already; a user's project finds all that it is to be linked with.
links_statically() {
  local dir="$1" module
  configures "$dir/build" -DBUILD_SHARED_LIBS=OFF "-DCMAKE_INSTALL_PREFIX=$dir/there" || return 1
  mkdir -p "$dir/build/lib"
  for module in core flann imgproc features2d imgcodecs videoio highgui calib3d surgtrack; do
    find "$BUILD_DIR/modules/$module/CMakeFiles/opencv_$module.dir" -name '*.o' -print0 | xargs -0 ar qc "$dir/build/lib/libopencv_$module.a" || return 1
  done
  cmake --install "$dir/build" --component dev >"$dir.log" && user_builds "$dir/user" "$dir/there/lib/cmake/opencv4"
}

run_install() {
  local work="$1/install" there="$1/install/there" python
  rm -rf "$work"
  mkdir -p "$work/user/demo"
  sample "install: elsewhere than configured" installs_into "$work"
  python="$(dirname "$(find "$there/lib" -path '*/cv2/__init__.py')")"
  sample "install: programs, Python, stubs, documentation, an example" holds "$there" bin/example_surgtrack_track_sequence \
    'lib/libopencv_surgtrack.so' 'include/*/opencv2/surgtrack/lab.hpp' 'share/opencv4/samples/surgtrack/track_sequence.py' \
    'share/doc/opencv4/surgtrack/doc/tutorial.md' 'share/opencv4/surgtrack/example/sequence.yaml' 'share/opencv4/surgtrack/example/tool*/*.yaml' \
    "${python#"$there/"}/surgtrack/__init__.pyi"
  sample "install: no path of the build is left" stays_inside "$there"
  sample "install: libraries are found where they are" loads_from "$there" "$there/bin/example_surgtrack_track_sequence" "$python"/python-*/cv2*.so
  ln -s "$there/share/opencv4/surgtrack/example" "$work/user/demo/sequence"
  sample "install: a program tracks the example" limited "$there/bin/example_surgtrack_track_sequence" \
    --sequence="$there/share/opencv4/surgtrack/example" --frames=2 --poses="$work/poses.csv" --quiet
  sed -n '/^```python$/,/^```$/p' "$REPO/README.md" | sed '1d;$d' >"$work/user/program.py"
  sample "install: README's Python program" tracks_in "$work/user" env "PYTHONPATH=$(dirname "$python")" "$PYTHON" program.py
  sample "install: README's C++ program is built" user_builds "$work/user" "$there/lib/cmake/opencv4"
  sample "install: and runs" tracks_in "$work/user" build/program
  if "$PYTHON" -c 'import mypy' 2>/dev/null; then
    sample "install: mypy finds the stubs" env "MYPYPATH=$(dirname "$python")" "$PYTHON" -m mypy --strict --cache-dir="$work/mypy" \
      "$REPO/misc/python/test/typed_user.py"
  fi
  sample "opencv_world: the module stays outside" stays_outside "$work/world"
  sample "static: README's C++ program is built" links_statically "$work/static"
  sample "static: and runs" env "OPENCV_VIDEOIO_PLUGIN_PATH=$BUILD_DIR/lib" bash -c \
    "cd '$work/user' && '$work/static/user/build/program' | grep -q tracking"
}
