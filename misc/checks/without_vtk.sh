# shellcheck shell=bash
# The module without VTK. Sourced by misc/test.sh.

# says_without_vtk DIR: the configuration says what the module is without, and leaves the wing of VTK out.
says_without_vtk() {
  local off=("${WITHOUT[@]/#/-DWITH_}")
  rm -rf "$1"
  cmake -G Ninja -S "$OPENCV_SOURCE" -B "$1" "-DOPENCV_EXTRA_MODULES_PATH=$REPO" -DBUILD_LIST=surgtrack -DBUILD_TESTS=OFF -DBUILD_PERF_TESTS=OFF \
    "${off[@]/%/=OFF}" -DCMAKE_DISABLE_FIND_PACKAGE_VTK=ON "-DOPENCV_DOWNLOAD_PATH=$BUILD_DIR/.cache" >"$1.log" 2>&1 || return 1
  grep -q 'opencv_surgtrack: without MeshRenderer::createVTK() and SceneView' "$1.log" &&
    grep -q 'src/vtk/without_vtk.cpp' "$1/build.ninja" && ! grep -q 'src/vtk/scene_view.cpp' "$1/build.ninja"
}

# links_without_vtk DIR: what was compiled, but for the wing of VTK, and what stands for it are all the library needs, and it loads few others.
# By the commands of the build there is: no second OpenCV is built.
links_without_vtk() {
  local compile link loaded library="$1/libopencv_surgtrack.so" object="$1/without_vtk.o"
  mkdir -p "$1"
  ninja -C "$BUILD_DIR" -t commands opencv_surgtrack >"$1/commands"
  compile="$(grep -m 1 -e '/src/model/tool_view\.cpp$' "$1/commands")"
  link="$(grep -m 1 -e '-shared .*-o lib/libopencv_surgtrack\.so' "$1/commands")"
  compile="$(sed -E "s# -o [^ ]+ -c .*# -o $object -c $REPO/src/vtk/without_vtk.cpp#; s# -M[DTF] [^ ]*##g" <<<"$compile")"
  link="$(sed -E "s#^: && ##; s# && .*##; s#-o lib/[^ ]+#-o $library#; s# [^ ]*/src/vtk/[^ ]+\.o##g; s# [^ ]*libvtk[^ ]*##g; s#\$# $object -Wl,--no-undefined#" <<<"$link")"
  (cd "$BUILD_DIR" && eval "$compile" && eval "$link") || return 1
  loaded="$(LD_LIBRARY_PATH="$BUILD_DIR/lib" ldd "$library" | wc -l)"
  echo "$loaded shared objects are loaded without VTK"
  [[ "$loaded" -gt 0 && "$loaded" -le 40 ]]
}

run_without_vtk() {
  sample "without VTK: the configuration says so" says_without_vtk "$1/without_vtk"
  sample "without VTK: nothing else needs it" links_without_vtk "$1/without_vtk_link"
}
