# shellcheck shell=bash
# The module without VTK. Sourced by misc/test.sh.

# says_without_vtk DIR: the configuration says what the module is without.
says_without_vtk() {
  rm -rf "$1"
  cmake -G Ninja -S "$OPENCV_SOURCE" -B "$1" "${CONFIGURATION[@]}" -DBUILD_LIST=surgtrack -DBUILD_TESTS=OFF -DBUILD_EXAMPLES=OFF \
    -DBUILD_opencv_python3=OFF -DCMAKE_DISABLE_FIND_PACKAGE_VTK=ON -DWITH_VTK=OFF "-DOPENCV_DOWNLOAD_PATH=$BUILD_DIR/.cache" -DWITH_IPP=OFF -DWITH_ADE=OFF \
    >"$1.log" 2>&1 || { tail -n 20 "$1.log"; return 1; }
  grep -q 'opencv_surgtrack: without MeshRenderer::createVTK() and SceneView' "$1.log" &&
    grep -q 'src/vtk/without_vtk.cpp' "$1/build.ninja" && ! grep -q 'src/vtk/scene_view.cpp' "$1/build.ninja"
}

# links_without_vtk DIR: what was compiled, but for the wing of VTK, and what stands for it, is all the library needs; it loads few others.
# Compiled by the commands of the build, so no second OpenCV is built.
links_without_vtk() {
  local compile library="$1/libopencv_surgtrack_without_vtk.so" objects needed
  mkdir -p "$1"
  compile="$(ninja -C "$BUILD_DIR" -t commands lib/libopencv_surgtrack.so | grep -m 1 -e '-c [^ ]*/src/model/tool_view.cpp$')" || return 1
  compile="${compile//model\/tool_view.cpp/vtk/without_vtk.cpp}"
  (cd "$BUILD_DIR" && eval "${compile/ -o */ -o $1/without_vtk.o -c $REPO/src/vtk/without_vtk.cpp}") || return 1
  objects="$(find "$BUILD_DIR/modules/surgtrack" -path '*opencv_surgtrack.dir*' -name '*.o' ! -path '*/src/vtk/*')"
  # shellcheck disable=SC2086
  c++ -shared -o "$library" $objects "$1/without_vtk.o" -Wl,--no-undefined -Wl,--as-needed -Wl,--gc-sections -L"$BUILD_DIR/lib" \
    -lopencv_calib3d -lopencv_videoio -lopencv_imgcodecs -lopencv_imgproc -lopencv_features2d -lopencv_flann -lopencv_core \
    -lassimp -lmeshoptimizer $(pkg-config --libs urdfdom 2>/dev/null) -lconsole_bridge -ldl -lpthread || return 1
  needed="$(readelf -d "$library" | grep -c NEEDED)"
  echo "$needed libraries named, $(LD_LIBRARY_PATH="$BUILD_DIR/lib" ldd "$library" | wc -l) loaded"
}

run_without_vtk() {
  sample "without VTK: the configuration says so" says_without_vtk "$1/without_vtk"
  sample "without VTK: the library needs no more" links_without_vtk "$1/without_vtk_link"
}
