# shellcheck shell=bash
# The sources against the headers of other OpenCVs, and for ARM: compiled as far as errors and warnings show. Sourced by misc/test.sh.

# fetches_headers FOLDER RELEASE PACKAGE...: takes apart the packages of another release of Debian, by an apt configuration of its own.
fetches_headers() {
  local folder="$1" release="$2" site settings="$1/apt.conf" package file
  shift 2
  site="$(apt-get indextargets --format '$(SITE)' 'Created-By: Packages' 'Origin: Debian' 2>/dev/null | head -n 1 || true)"
  [[ -n "$site" ]] || return 1
  mkdir -p "$folder/lists/partial" "$folder/archives/partial" "$folder/files"
  echo "deb [signed-by=/usr/share/keyrings/debian-archive-keyring.gpg] $site $release main" >"$folder/sources.list"
  cat >"$settings" <<CONF
Dir::Etc::sourcelist "$folder/sources.list";
Dir::Etc::sourceparts "/nowhere";
Dir::State::lists "$folder/lists";
Dir::Cache "$folder";
Acquire::Languages "none";
Acquire::Retries "2";
Acquire::Check-Valid-Until "false";
#clear APT::Update::Pre-Invoke;
#clear APT::Update::Post-Invoke;
#clear APT::Update::Post-Invoke-Success;
CONF
  apt-get -c "$settings" update >"$folder/log" 2>&1 || return 1
  for package in "$@"; do
    (cd "$folder/archives" && apt-get -c "$settings" download "$package") >>"$folder/log" 2>&1 || return 1
  done
  for file in "$folder/archives"/*.deb; do dpkg -x "$file" "$folder/files" || return 1; done
  rm -rf "$folder/lists" "$folder/archives"
}

# generated FOLDER AVX2|NEON: what CMake makes for a build.
generated() {
  local folder="$1" file
  mkdir -p "$folder/opencv2/core"
  ln -sfn "$OPENCV_SOURCE/modules/core/include/opencv2/core/private" "$folder/opencv2/core/private"   # private headers are not in packages
  ln -sfn "$OPENCV_SOURCE/modules/core/include/opencv2/core/private.hpp" "$folder/opencv2/core/private.hpp"
  if [[ "$2" == NEON ]]; then
    printf '#define CV_CPU_%s 1\n' COMPILE_NEON BASELINE_COMPILE_NEON >"$folder/cv_cpu_config.h"
    printf '#define CV_CPU_%s\n' 'BASELINE_FEATURES 0, CV_CPU_NEON' 'DISPATCH_FEATURES 0' >>"$folder/cv_cpu_config.h"
  else
    printf '#define CV_CPU_%s 1\n' {,BASELINE_}COMPILE_{SSE,SSE2} DISPATCH_COMPILE_AVX2 >"$folder/cv_cpu_config.h"
    printf '#define CV_CPU_%s\n' 'BASELINE_FEATURES 0, CV_CPU_SSE, CV_CPU_SSE2' 'DISPATCH_FEATURES 0, CV_CPU_AVX2' >>"$folder/cv_cpu_config.h"
  fi
  for file in detect/qgo render/mesh_raster; do
    mkdir -p "$folder/${file%/*}"
    {
      echo "#define CV_CPU_SIMD_FILENAME \"$REPO/src/$file.simd.hpp\""
      [[ "$2" == NEON ]] || printf '#define CV_CPU_DISPATCH_MODE %s\n#include "opencv2/core/private/cv_cpu_include_simd_declarations.hpp"\n' "$2"
      [[ "$2" == NEON ]] && echo '#define CV_CPU_DISPATCH_MODES_ALL BASELINE' || echo "#define CV_CPU_DISPATCH_MODES_ALL $2, BASELINE"
      echo '#undef CV_CPU_SIMD_FILENAME'
    } >"$folder/$file.simd_declarations.hpp"
  done
}

# compiles FOLDER FILES-OF-PACKAGES AVX2|NEON COMPILER...: every source but those of VTK, without an error or a warning.
compiles() {
  local folder="$1" files="$2" opencv file flags
  generated "$folder" "$3"
  shift 3
  opencv="$(dirname "$(dirname "$(find "$files" -name opencv_modules.hpp | head -n 1)")")"
  flags=(-fsyntax-only -std=c++17 -Wall -Wextra -Werror -Wno-psabi -D__OPENCV_BUILD=1 -DHAVE_NLOHMANN_JSON -DHAVE_URDFDOM "-I$folder" "-I$REPO/include" "-I$REPO/src"
    -isystem "$opencv" -isystem "$(dirname "$(find "$files" -name cvconfig.h | head -n 1)")" -isystem "$(find "$files" /usr/include -path '*/include/eigen3' -prune -print | head -n 1)")
  for file in /usr/include/urdfdom /usr/include/urdfdom_headers; do flags+=(-isystem "$file"); done
  cat >"$folder/first.hpp" <<'CPP'
#include "opencv2/core.hpp"
#include "opencv2/core/private.hpp"
#include "opencv2/core/utility.hpp"
#include "opencv2/imgproc.hpp"
#include "opencv2/surgtrack/lab.hpp"
CPP
  "$@" "${flags[@]/-fsyntax-only/-O0}" -x c++-header "$folder/first.hpp" -o "$folder/first.hpp.gch" || return 1   # read once
  find "$REPO/src" -name '*.cpp' ! -path '*/vtk/*' -print0 | xargs -0 -P "$JOBS" -n 8 "$@" "${flags[@]}" -include "$folder/first.hpp"
}

run_versions() {
  local work="$BUILD_DIR/versions" release="" tried packages module
  if ! have_apt; then
    echo "skipped: other versions of OpenCV, whose headers come from Debian's later releases"
    return
  fi
  for tried in "4.10 trixie" "5 experimental"; do
    release="${tried#* }"
    packages=()
    for module in core imgproc imgcodecs videoio flann; do packages+=("libopencv-$module-dev"); done
    if [[ "$tried" == 4* ]]; then packages+=(libopencv-calib3d-dev libopencv-features2d-dev)
    else packages+=(libopencv-calib-dev libopencv-geometry-dev libopencv-features-dev libopencv-dnn-dev libopencv-objdetect-dev libopencv-stereo-dev libopencv-ptcloud-dev); fi
    if [[ ! -f "$work/$release/there" ]]; then
      rm -rf "${work:?}/$release"
      if ! fetches_headers "$work/$release" "$release" "${packages[@]}" ; then
        echo "skipped: OpenCV ${tried%% *}, whose headers are not to be had from Debian's $release"
        continue
      fi
      [[ "$tried" == 4* ]] || fetches_headers "$work/$release" sid libeigen3-dev || echo "Eigen 5 is not to be had, the installed one stands for it"
      touch "$work/$release/there"
    fi
    sample "OpenCV ${tried%% *}: the sources compile" compiles "$work/x86" "$work/$release/files" AVX2 g++
    [[ "$tried" == 4* ]] || continue   # what differs by processor is the same there
    if command -v aarch64-linux-gnu-g++ >/dev/null; then
      sample "OpenCV ${tried%% *}: and for ARM" compiles "$work/arm" "$work/$release/files" NEON aarch64-linux-gnu-g++
    else
      echo "skipped: OpenCV ${tried%% *} for ARM, which needs g++-aarch64-linux-gnu"
    fi
  done
}
