#!/usr/bin/env bash
# Shared by demo.sh, test.sh, package.sh and compare_peers.sh: packages, OpenCV's source, configuration and build. To be sourced, not run.
#
# Tried on Debian 12. Elsewhere, by what these have:
#   Ubuntu 24.04  as it is
#   Ubuntu 22.04  its OpenCV is too old: the fixed release is cloned
#   Fedora        packages are not installed, only looked for; what to install is said
#   macOS         the same, by Homebrew; its bash is too old, Homebrew has another; no windows, no package.sh

if [[ -z "${BASH_VERSINFO:-}" ]] || ((BASH_VERSINFO[0] * 100 + BASH_VERSINFO[1] < 404)); then
  echo "error: bash 4.4 or newer is needed, this is ${BASH_VERSION:-none} (macOS: brew install bash)" >&2
  exit 1
fi
set -Eeuo pipefail
trap 'echo "error: ${BASH_SOURCE[0]}, line $LINENO: $BASH_COMMAND" >&2' ERR

REPO="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd -P)"
BUILD_DIR="${BUILD_DIR:-$REPO/build}"
mkdir -p "$BUILD_DIR" || { echo "error: cannot make the build folder $BUILD_DIR" >&2; exit 1; }
BUILD_DIR="$(cd "$BUILD_DIR" && pwd -P)"
LOGS="$BUILD_DIR/logs"
# The Python that OpenCV's bindings are built for: PYTHON, else that in PATH (venv, conda) if it has numpy and its headers, else the distribution's.
PYTHON="${PYTHON:-}"
[[ -n "$PYTHON" ]] || PYTHON="$(python3 -c 'import numpy, os, sys, sysconfig
if os.path.exists(os.path.join(sysconfig.get_paths()["include"], "Python.h")): print(sys.executable)' 2>/dev/null || true)"
PYTHON="${PYTHON:-/usr/bin/python3}"
JOBS="${JOBS:-$(nproc 2>/dev/null || getconf _NPROCESSORS_ONLN 2>/dev/null || echo 2)}"

if [[ -z "${SURGTRACK_DATA:-}" && -d "$REPO/../shared/data" ]]; then
  SURGTRACK_DATA="$(cd "$REPO/../shared/data" && pwd -P)"
  export SURGTRACK_DATA
fi

# What is built; another script may want something else.
# shellcheck disable=SC2054
CONFIGURATION=("-DOPENCV_EXTRA_MODULES_PATH=$REPO"
  -DBUILD_LIST=surgtrack,ts,python3,python_tests -DBUILD_EXAMPLES=ON
  -DBUILD_TESTS=ON -DOPENCV_BUILD_TEST_MODULES_LIST=surgtrack
  -DBUILD_opencv_python3=ON "-DPYTHON3_EXECUTABLE=$PYTHON")

# What is cloned where the distribution has no source of OpenCV.
RELEASE=4.10.0

# Parts of OpenCV that nothing here uses.
WITHOUT=(ADE IPP ITT QUIRC OPENCL PROTOBUF CUDA 1394 GSTREAMER LAPACK TIFF WEBP OPENJPEG JASPER OPENEXR GDAL VA VA_INTEL EIGEN VTK)

# What Debian 12 needs. assimp and meshoptimizer read and thin out meshes, nlohmann-json3 and urdfdom read robots' files; GTK shows windows;
# VTK draws by OpenGL, the last two let it do so without a display; xvfb and xauth test it with one.
PACKAGES=(build-essential dpkg-dev cmake ninja-build ccache libvtk9-dev libeigen3-dev
  libassimp-dev libmeshoptimizer-dev nlohmann-json3-dev liburdfdom-dev libavcodec-dev libavformat-dev libavutil-dev libswscale-dev libjpeg-dev libpng-dev zlib1g-dev
  libgtk-3-dev python3-dev python3-numpy xvfb xauth libegl1 libgl1-mesa-dri)

# Options for other processors than that of this machine.
PROCESSOR=()

# Of libraries, programs and Python's part, as seen from where they are: what is installed may be moved.
# shellcheck disable=SC2016
INSTALL_RPATH='$ORIGIN;$ORIGIN/../lib;$ORIGIN/../../../..'
[[ $(uname) != Darwin ]] || INSTALL_RPATH="${INSTALL_RPATH//\$ORIGIN/@loader_path}"

step() { printf '\n== %s\n' "$*"; }
die() { trap - ERR; echo "error: $*" >&2; exit 1; }

# run_logged LOG MESSAGE COMMAND...: output goes to LOG; if COMMAND fails, LOG's last lines and MESSAGE are shown.
run_logged() {
  local log="$1" message="$2"
  shift 2
  if ! "$@" >"$log" 2>&1; then
    tail -n 25 "$log" >&2
    die "$message (log: $log)"
  fi
}

as_root() {
  if [[ $(id -u) -eq 0 ]]; then "$@"; else sudo "$@"; fi
}

is_installed() { [[ $(dpkg-query -W -f '${db:Status-Status}' "$1" 2>/dev/null) == installed ]]; }

# Installs those of the packages named that are missing.
install_packages() {
  local package missing=()
  for package in "$@"; do
    is_installed "$package" || missing+=("$package")
  done
  [[ ${#missing[@]} -gt 0 ]] || return 0

  if [[ $(id -u) -ne 0 ]] && ! command -v sudo >/dev/null; then
    die "packages are missing and there is no sudo; as root: apt-get install ${missing[*]}"
  fi
  step "Installing ${missing[*]}"
  local apt=(env DEBIAN_FRONTEND=noninteractive NEEDRESTART_MODE=a apt-get -o DPkg::Lock::Timeout=500)
  # One unreachable source does not matter if the others have the packages.
  as_root "${apt[@]}" update >"$LOGS/apt-update.log" 2>&1 ||
    echo "warning: apt-get update failed, going on with the package lists there are (log: $LOGS/apt-update.log)" >&2
  run_logged "$LOGS/apt-install.log" "apt-get could not install ${missing[*]}; is there a network?" \
    as_root "${apt[@]}" install -y --no-install-recommends "${missing[@]}"
}

have_apt() { command -v apt-get >/dev/null && command -v dpkg-query >/dev/null; }

ensure_tools() {
  local tool missing=()
  if have_apt; then
    install_packages "${PACKAGES[@]}"
    command -v pkg-config >/dev/null || install_packages pkg-config
  else
    echo "no apt here: packages are not installed, only looked for"
    if command -v dnf >/dev/null; then
      echo "Fedora: dnf install gcc-c++ cmake ninja-build ccache git pkgconf-pkg-config vtk-devel eigen3-devel assimp-devel meshoptimizer-devel" \
        "json-devel urdfdom-devel ffmpeg-free-devel libjpeg-turbo-devel libpng-devel zlib-devel gtk3-devel python3-devel python3-numpy"
    elif command -v brew >/dev/null; then
      echo "macOS: brew install cmake ninja ccache pkg-config vtk eigen assimp meshoptimizer nlohmann-json urdfdom ffmpeg jpeg-turbo libpng numpy"
    fi
  fi
  for tool in c++ cmake pkg-config "$PYTHON"; do
    command -v "$tool" >/dev/null || missing+=("$tool")
  done
  command -v ninja >/dev/null || command -v ninja-build >/dev/null || missing+=(ninja)
  [[ ${#missing[@]} -eq 0 ]] || die "not found: ${missing[*]}"
  "$PYTHON" -c 'import numpy' 2>/dev/null || die "$PYTHON has no numpy (Debian: python3-numpy)"
}

# source_version FOLDER: OpenCV's version there, such as 4.6.0; nothing if it is no OpenCV source.
source_version() {
  local header="$1/modules/core/include/opencv2/core/version.hpp"
  [[ -f "$header" ]] || return 0
  awk '/#define CV_VERSION_(MAJOR|MINOR|REVISION) /{ v = v s $3; s = "." } END { print v }' "$header"
}

at_least_4_6() {
  local major minor
  IFS=. read -r major minor _ <<<"$1"
  [[ "$major" =~ ^[0-9]+$ && "$minor" =~ ^[0-9]+$ ]] && ((major > 4 || (major == 4 && minor >= 6)))
}

# Fetches a source package of the distribution, with its patches, into the folder $1: OpenCV's newest, or package $2 in version $3. The user's apt
# sources are read, not changed: a copy of them, deb turned into deb-src, serves an apt configuration that is thrown away afterwards.
fetch_source_package() {
  local destination="$1" package="${2:-opencv}" best="${3:-}" work list='' parts='' file version settings log
  work="$BUILD_DIR/$package-fetch"
  log="$LOGS/$package-source.log"
  rm -rf "$work"
  mkdir -p "$work/sources.list.d" "$work/lists/partial" "$work/cache/archives/partial" "$work/src"
  eval "$(apt-config shell list Dir::Etc::sourcelist/f parts Dir::Etc::sourceparts/d)"

  # One-line format; cdrom: entries have no sources.
  : >"$work/sources.list"
  for file in "$list" "${parts%/}"/*.list; do
    [[ -f "$file" ]] || continue
    awk '/^[ \t]*deb(-src)?[ \t]/ && !/cdrom:/ { sub(/^[ \t]*deb(-src)?/, "deb-src"); if (!seen[$0]++) print }' "$file" \
      >>"$work/sources.list"
  done
  # deb822 format; Signed-By and everything else stays as it is.
  for file in "${parts%/}"/*.sources; do
    [[ -f "$file" ]] || continue
    awk 'tolower($0) ~ /^types[ \t]*:/ { print "Types: deb-src"; next } { print }' "$file" \
      >"$work/sources.list.d/${file##*/}"
  done
  settings="$work/apt.conf"
  cat >"$settings" <<CONF
Dir::Etc::sourcelist "$work/sources.list";
Dir::Etc::sourceparts "$work/sources.list.d";
Dir::State::lists "$work/lists";
Dir::Cache "$work/cache";
DPkg::Lock::Timeout "500";
Acquire::Languages "none";
Acquire::Retries "3";
#clear APT::Update::Pre-Invoke;
#clear APT::Update::Post-Invoke;
#clear APT::Update::Post-Invoke-Success;
CONF

  apt-get -c "$settings" update >"$log" 2>&1 || true     # sources of third parties may fail; what counts is the next line
  [[ -n "$best" ]] || while read -r version; do
    at_least_4_6 "$version" || continue
    if [[ -z "$best" ]] || dpkg --compare-versions "$version" gt "$best"; then best="$version"; fi
  done < <(apt-cache -c "$settings" showsrc --only-source opencv 2>>"$log" | awk '$1 == "Version:" { print $2 }' || true)
  if [[ -z "$best" ]]; then
    echo "no source package of OpenCV 4.6 or newer is to be had from the distribution (log: $log)" >&2
    return 1
  fi
  echo "source package $package $best"
  if ! (cd "$work/src" && apt-get -c "$settings" source --only-source "$package=$best") >>"$log" 2>&1; then
    tail -n 10 "$log" >&2
    echo "apt-get source $package=$best failed (log: $log)" >&2
    return 1
  fi
  for file in "$work/src/$package"-*/; do
    [[ -d "$file" ]] || continue
    rm -rf "$destination"
    mv "${file%/}" "$destination"
    rm -rf "$work"
    return 0
  done
  echo "apt-get source left no folder in $work/src (log: $log)" >&2
  return 1
}

clone_source() {
  local destination="$1" work="$BUILD_DIR/opencv-fetch"
  rm -rf "$work"
  if ! command -v git >/dev/null && have_apt; then install_packages git ca-certificates; fi
  command -v git >/dev/null || die "git was not found and no source package is to be had: set OPENCV_SOURCE"
  run_logged "$LOGS/opencv-source.log" \
    "OpenCV's source could not be fetched; is there a network? OPENCV_SOURCE names a source tree to use instead" \
    git clone --depth 1 -b "$RELEASE" https://github.com/opencv/opencv "$work"
  rm -rf "$destination"
  mv "$work" "$destination"
}

# Sets OPENCV_SOURCE to a folder with OpenCV's source.
ensure_source() {
  local version
  if [[ -n "${OPENCV_SOURCE:-}" ]]; then
    [[ -d "$OPENCV_SOURCE" ]] || die "OPENCV_SOURCE is no folder: $OPENCV_SOURCE"
    OPENCV_SOURCE="$(cd "$OPENCV_SOURCE" && pwd -P)"
  else
    OPENCV_SOURCE="$BUILD_DIR/opencv-src"
    if [[ ! -f "$OPENCV_SOURCE/CMakeLists.txt" ]]; then
      step "Fetching OpenCV's source"
      local free
      free="$(df -Pk "$BUILD_DIR" | awk 'NR == 2 { print int($4 / 1024) }')"
      [[ "$free" -ge 2500 ]] || die "$BUILD_DIR has $free MB left; source and build need 2500 MB"
      if ! have_apt || ! fetch_source_package "$OPENCV_SOURCE"; then
        echo "cloning https://github.com/opencv/opencv, release $RELEASE"
        clone_source "$OPENCV_SOURCE"
      fi
    fi
  fi
  version="$(source_version "$OPENCV_SOURCE")"
  [[ -n "$version" ]] ||
    die "this is not OpenCV's source: $OPENCV_SOURCE (modules/core/include/opencv2/core/version.hpp is missing)"
  at_least_4_6 "$version" || die "OpenCV $version is too old, 4.6 or newer is needed: $OPENCV_SOURCE"
  echo "OpenCV $version in $OPENCV_SOURCE"
}

has_avx2() {
  [[ $(uname -m) == x86_64 && -r /proc/cpuinfo ]] || return 1
  grep -Eq '^flags.* avx2( |$)' /proc/cpuinfo && grep -Eq '^flags.* fma( |$)' /proc/cpuinfo &&
    grep -Eq '^flags.* f16c( |$)' /proc/cpuinfo
}

# Runs cmake if the configuration or the list of the module's files has changed since the last time.
configure() {
  local options=() off stamp="$BUILD_DIR/surgtrack-configuration" wanted log="$LOGS/configure.log" cached
  options=(-G Ninja -S "$OPENCV_SOURCE" -B "$BUILD_DIR" -DCMAKE_BUILD_TYPE=Release
    "-DOPENCV_DOWNLOAD_PATH=$BUILD_DIR/.cache"
    -DOPENCV_VCSVERSION=unknown -DBUILD_INFO_SKIP_EXTRA_MODULES=ON   # else each commit here would rebuild OpenCV's core
    "${CONFIGURATION[@]}"
    -DBUILD_PERF_TESTS=ON -DOPENCV_BUILD_PERF_TEST_MODULES_LIST=surgtrack
    -DBUILD_opencv_python2=OFF -DBUILD_JAVA=OFF -DBUILD_DOCS=OFF -DBUILD_opencv_apps=OFF -DENABLE_PRECOMPILED_HEADERS=OFF -DWITH_FFMPEG=ON
    -DVIDEOIO_PLUGIN_LIST=ffmpeg   # loaded when a video is opened: FFmpeg brings a hundred libraries along
    "-DCMAKE_INSTALL_RPATH=$INSTALL_RPATH")
  for off in "${WITHOUT[@]}"; do
    options+=("-DWITH_$off=OFF")
  done
  # Cameras and a window for `live`, where the system has them. Not Qt: OpenCV 4.6 does not compile with it unless OpenGL is on, too.
  options+=(-DWITH_V4L=ON -DWITH_GTK=ON -DWITH_QT=OFF)
  # Without AVX2 OpenCV's own default: a program built for AVX2 does not start on an older processor.
  if [[ ${#PROCESSOR[@]} -gt 0 ]]; then
    options+=("${PROCESSOR[@]}")
  elif has_avx2; then
    options+=(-DCPU_BASELINE=AVX2 -DCPU_DISPATCH=AVX512_SKX)
  else
    options+=(-UCPU_BASELINE -UCPU_DISPATCH)
  fi
  if command -v ccache >/dev/null; then
    options+=(-DCMAKE_C_COMPILER_LAUNCHER=ccache -DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
  fi

  # CMake lists the module's files when it runs: a new one needs another run.
  wanted="$(printf '%s\n' "${options[@]}"
    cd "$REPO"
    { find include src test perf samples misc/python -name '*.[ch]pp' 2>/dev/null || true; } | LC_ALL=C sort)"
  if [[ -f "$BUILD_DIR/build.ninja" && -f "$stamp" && "$(cat "$stamp")" == "$wanted" ]]; then return 0; fi

  step "Configuring in $BUILD_DIR"
  cached="$(sed -n 's/^CMAKE_HOME_DIRECTORY:INTERNAL=//p' "$BUILD_DIR/CMakeCache.txt" 2>/dev/null || true)"
  if [[ -n "$cached" && "$cached" != "$OPENCV_SOURCE" ]]; then
    die "$BUILD_DIR was configured for another OpenCV source ($cached): remove it, or set BUILD_DIR"
  fi
  cached="$(sed -n 's/^CMAKE_CACHEFILE_DIR:INTERNAL=//p' "$BUILD_DIR/CMakeCache.txt" 2>/dev/null || true)"
  if [[ -n "$cached" && "$cached" != "$BUILD_DIR" ]]; then
    die "$BUILD_DIR was configured in another place ($cached): remove it, or set BUILD_DIR"
  fi
  rm -f "$stamp"
  run_logged "$log" "cmake failed" cmake "${options[@]}"

  cached=";$(sed -n 's/^OPENCV_MODULES_BUILD:INTERNAL=//p' "$BUILD_DIR/CMakeCache.txt");"
  if [[ "$cached" != *";opencv_surgtrack;"* ]]; then
    grep 'opencv_surgtrack disabled' "$log" >&2 || true
    die "the module is disabled: Eigen 3.3, assimp and meshoptimizer are needed (log: $log)"
  fi
  [[ "$cached" == *";opencv_python3;"* || " ${CONFIGURATION[*]} " == *" -DBUILD_opencv_python3=OFF "* ]] ||
    die "OpenCV's Python bindings are unavailable: $PYTHON needs its headers and numpy (log: $log)"
  grep -Eq 'FFMPEG: +YES' "$log" || die "OpenCV did not find FFmpeg's libraries, videos could not be read (log: $log)"
  printf '%s\n' "$wanted" >"$stamp"
}

# ccache fails, and every compilation with it, if it cannot write to its folder.
ensure_ccache() {
  local folder
  command -v ccache >/dev/null || return 0
  folder="$(ccache --get-config cache_dir 2>/dev/null || true)"
  if [[ -z "$folder" ]] || ! mkdir -p "$folder/tmp" 2>/dev/null || [[ ! -w "$folder/tmp" ]]; then
    export CCACHE_DIR="$BUILD_DIR/.ccache"
  fi
}

# Gets ready to build: packages, OpenCV's source, ccache.
prepare() {
  mkdir -p "$LOGS"
  ensure_tools
  ensure_source
  ensure_ccache
}

# build TARGET...: everything that is needed to have these targets up to date in BUILD_DIR.
build() {
  configure
  step "Building ($JOBS jobs)"
  export NINJA_STATUS='[%f/%t %es] '
  # Headers of the bindings that are generated in the same run are noticed by the next one only.
  if [[ " $* " == *" opencv_python3 "* ]]; then
    cmake --build "$BUILD_DIR" --parallel "$JOBS" --target gen_opencv_python_source || die "the build failed, see above"
  fi
  cmake --build "$BUILD_DIR" --parallel "$JOBS" --target "$@" || die "the build failed, see above"
}

# Python with the cv2 of this build.
python_cv2() {
  PYTHONDONTWRITEBYTECODE=1 PYTHONPATH="$BUILD_DIR/python_loader${PYTHONPATH:+:$PYTHONPATH}" "$PYTHON" "$@"
}
