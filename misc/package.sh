#!/usr/bin/env bash
# Makes packages: a .deb and a Python wheel.

set -euo pipefail

usage() {
  cat <<'TEXT'
usage: misc/package.sh [--check] [deb] [wheel]

Installs what is missing (apt), gets OpenCV's source and builds it with the module for any processor of this machine's kind, with
faster code for newer ones beside it. Leaves in packages/:
  opencv-surgtrack_VERSION_ARCHITECTURE.deb   library, headers, programs, Python, stubs, documentation and an example, in /opt/opencv-surgtrack
  opencv_surgtrack-VERSION-....whl            cv2 with the module, and the libraries it needs; without windows and VTK. Its FFmpeg is built
                                              here without the parts under the GPL: it reads the usual videos and writes MPEG-4
Without deb or wheel both are made. Both bring cv2, as opencv-python and python3-opencv do: have one of them only.

--check tries them, made now or before, each in a new root file system with nothing else (mmdebstrap; as root, some minutes): the .deb's
track_sequence on the built-in sequence and README's programs, the wheel by pip in a new virtual environment and README's Python program.

environment:
  PACKAGES_DIR    output folder (default: packages/ in the repository)
  BUILD_DIR, OPENCV_SOURCE, JOBS      as in misc/test.sh
TEXT
}

check='' wanted=()
for argument in "$@"; do
  case "$argument" in
    -h | --help) usage; exit 0 ;;
    --check) check=1 ;;
    deb | wheel) wanted+=("$argument") ;;
    *) usage >&2; exit 1 ;;
  esac
done
[[ ${#wanted[@]} -gt 0 ]] || wanted=(deb wheel)

# shellcheck source=misc/common.sh
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"
have_apt || die "packages are made with the tools of Debian and Ubuntu"
PYTHON=/usr/bin/python3   # which the packages are for
PACKAGES_DIR="${PACKAGES_DIR:-$REPO/packages}"
mkdir -p "$PACKAGES_DIR" || die "cannot make the folder $PACKAGES_DIR"
PACKAGES_DIR="$(cd "$PACKAGES_DIR" && pwd -P)"
NAME=opencv-surgtrack
WHERE="/opt/$NAME"
SUMMARY='OpenCV with surgtrack: 3D tracking of articulated surgical tools'
if [[ $(uname -m) == x86_64 ]]; then
  PROCESSOR=(-DCPU_BASELINE=SSE3 "-DCPU_DISPATCH=AVX2,AVX512_SKX")
else
  PROCESSOR=(-UCPU_BASELINE -UCPU_DISPATCH)
fi
ALL_BUILD="$BUILD_DIR"
PARTS=(libs plugins python licenses)

# builds KIND TARGET...: in a build folder of its own.
builds() {
  local kind="$1"
  shift
  BUILD_DIR="$ALL_BUILD/package-$kind"
  LOGS="$BUILD_DIR/logs"
  mkdir -p "$LOGS"
  build "$@"
}

make_deb() {
  local architecture part projects=''
  architecture="$(dpkg --print-architecture)"
  CONFIGURATION=("-DOPENCV_EXTRA_MODULES_PATH=$REPO" "-DBUILD_LIST=surgtrack,highgui,python3" -DBUILD_EXAMPLES=ON -DBUILD_TESTS=OFF -DBUILD_opencv_python3=ON
    "-DPYTHON3_EXECUTABLE=$PYTHON" -DPYTHON3_PACKAGES_PATH:STRING=lib/python3/dist-packages -DCMAKE_INSTALL_LIBDIR:STRING=lib -DHIGHGUI_PLUGIN_LIST=gtk3)
  builds deb all
  step "Packing $NAME.deb"
  for part in "${PARTS[@]}" dev samples docs; do
    projects+="$BUILD_DIR;OpenCV;$part;/;"
  done
  cat >"$BUILD_DIR/surgtrack-cpack.cmake" <<CPACK
set(CPACK_GENERATOR DEB)
set(CPACK_CMAKE_GENERATOR Ninja)
set(CPACK_PACKAGE_NAME $NAME)
set(CPACK_PACKAGE_VERSION $VERSION)
set(CPACK_PACKAGE_FILE_NAME ${NAME}_${VERSION}_$architecture)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "$SUMMARY")
set(CPACK_PACKAGE_DESCRIPTION "Library, programs, Python's part, documentation and an example, in $WHERE. It brings a cv2 of its own: PYTHONPATH=$WHERE/lib/python3/dist-packages")
set(CPACK_PACKAGE_CONTACT "${MAINTAINER:-$NAME <root@localhost>}")
set(CPACK_PACKAGE_VENDOR $NAME)
set(CPACK_INSTALL_CMAKE_PROJECTS "$projects")
set(CPACK_PACKAGING_INSTALL_PREFIX $WHERE)
set(CPACK_SET_DESTDIR ON)
set(CPACK_INSTALL_PREFIX $WHERE)
set(CPACK_STRIP_FILES ON)
set(CPACK_OUTPUT_FILE_PREFIX "$PACKAGES_DIR")
set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE $architecture)
set(CPACK_DEBIAN_PACKAGE_SECTION libs)
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA "$BUILD_DIR/prerm")
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS "$BUILD_DIR/lib")
set(CPACK_DEBIAN_PACKAGE_DEPENDS "python3 (>= $PYTHON_VERSION), python3 (<< ${PYTHON_VERSION%.*}.$((${PYTHON_VERSION#*.} + 1))), python3-numpy")
CPACK
  # What Python has compiled there since.
  printf '#!/bin/sh\nset -e\nfind %s -name __pycache__ -prune -exec rm -rf {} +\n' "$WHERE" >"$BUILD_DIR/prerm"
  chmod 755 "$BUILD_DIR/prerm"
  (cd "$BUILD_DIR" && run_logged "$LOGS/cpack.log" "CPack failed" cpack --config surgtrack-cpack.cmake)
}

# FFmpeg of the version that OpenCV was built with, without what is under the GPL: what Debian has is.
make_ffmpeg() {
  local version source="$ALL_BUILD/ffmpeg-src" there="$1" log="$LOGS/ffmpeg.log" decoders
  # shellcheck disable=SC2016
  version="$(dpkg-query -W -f '${source:Version}' libavcodec-dev)"
  if [[ -f "$there/version" && "$(cat "$there/version")" == "$version" ]]; then return 0; fi
  step "Building FFmpeg $version without the GPL's parts"
  install_packages nasm
  rm -rf "$there" "$source"
  (BUILD_DIR="$ALL_BUILD" fetch_source_package "$source" ffmpeg "$version") || die "FFmpeg's source is not to be had"
  decoders=h264,hevc,mpeg1video,mpeg2video,mpeg4,msmpeg4v2,msmpeg4v3,wmv1,wmv2,mjpeg,vp8,vp9,ffv1,huffyuv,rawvideo,png,bmp,dvvideo
  (cd "$source" && ./configure "--prefix=$there" --enable-shared --disable-static --disable-programs --disable-doc --disable-autodetect --disable-everything \
    --disable-network --disable-avdevice --disable-avfilter --disable-postproc --disable-swresample --enable-protocol=file "--enable-decoder=$decoders" \
    --enable-encoder=mpeg4,mjpeg,ffv1,huffyuv,rawvideo,png --enable-parser=h264,hevc,mpegvideo,mpeg4video,mjpeg,vp8,vp9,png,dvd_nav \
    --enable-demuxer=mov,matroska,avi,mpegps,mpegts,mpegvideo,m4v,h264,hevc,mjpeg,flv,image2,rawvideo,dv,asf --enable-muxer=mov,mp4,matroska,avi,mpegts,image2,rawvideo \
    --enable-bsf=h264_mp4toannexb,hevc_mp4toannexb,mpeg4_unpack_bframes,vp9_superframe,extract_extradata &&
    make -j "$JOBS" && make install) >"$log" 2>&1 || { tail -n 20 "$log" >&2; die "FFmpeg could not be built (log: $log)"; }
  cp "$source/COPYING.LGPLv2.1" "$there"
  echo "$version" >"$there/version"
}

# What a wheel may expect of the system, by the policy for Linux (PEP 600): the C and C++ libraries.
OF_THE_SYSTEM='^(linux-vdso|ld-linux.*|libc|libm|libdl|librt|libpthread|libresolv|libutil|libgcc_s|libstdc\+\+)\.so'

# gathers LIBRARIES LICENSES FILE...: copies into the folder LIBRARIES what the files need of this machine's libraries, under names that no other
# program's library has, with their licenses.
gathers() {
  local libraries="$1" licenses="$2" name path own package
  shift 2
  while read -r name path; do
    [[ ! "$name" =~ $OF_THE_SYSTEM && ! -e "$libraries/$name" ]] || continue
    cp -L "$path" "$libraries/$name"
    path="$(readlink -f "$path")"
    package="$(dpkg-query -S "$path" "${path#/usr}" 2>/dev/null | head -n 1 | cut -d: -f1 || true)"
    [[ -z "$package" ]] || cp "/usr/share/doc/$package/copyright" "$licenses/$package"
  done < <(LD_LIBRARY_PATH="$libraries" ldd "$@" | awk '$2 == "=>" && $3 ~ /^\// { print $1, $3 }' | sort -u)
  for path in "$libraries"/*; do
    name="${path##*/}"
    own="${name/.so/-surgtrack.so}"
    [[ "$name" != libopencv_videoio_ffmpeg* ]] || own="$name"   # looked for by its name
    chmod u+w "$path"
    if [[ "$own" != "$name" ]]; then
      mv "$path" "$libraries/$own"
      patchelf --set-soname "$own" "$libraries/$own"
      renames["$name"]="$own"
    fi
  done
}

make_wheel() {
  local work tree libraries licenses part file numpy tag
  local -A renames=()
  CONFIGURATION=("-DOPENCV_EXTRA_MODULES_PATH=$REPO" "-DBUILD_LIST=surgtrack,python3" -DBUILD_EXAMPLES=OFF -DBUILD_TESTS=OFF -DBUILD_opencv_python3=ON
    "-DPYTHON3_EXECUTABLE=$PYTHON" -DPYTHON3_PACKAGES_PATH:STRING=python -DCMAKE_INSTALL_LIBDIR:STRING=lib -DCMAKE_DISABLE_FIND_PACKAGE_VTK=ON)
  WITHOUT+=(GTK)
  builds wheel opencv_python3 opencv_videoio_ffmpeg opencv_surgtrack
  make_ffmpeg "$BUILD_DIR/ffmpeg"
  step "Packing the wheel"
  work="$BUILD_DIR/wheel"
  tree="$work/tree"
  libraries="$tree/opencv_surgtrack.libs"
  licenses="$tree/opencv_surgtrack-$VERSION.dist-info/licenses"
  rm -rf "$work"
  mkdir -p "$libraries" "$licenses"
  for part in "${PARTS[@]}"; do
    cmake --install "$BUILD_DIR" --prefix "$work/installed" --component "$part" --strip >>"$LOGS/wheel.log" 2>&1 || die "the installation failed (log: $LOGS/wheel.log)"
  done
  mv "$work/installed/python/cv2" "$tree"
  # In a wheel libraries are found by their RUNPATH alone.
  echo 'BINARIES_PATHS = []' >"$tree/cv2/config.py"
  for file in "$work/installed/lib"/*.so* "$BUILD_DIR/ffmpeg/lib"/*.so.*; do   # under the names they are loaded by
    [[ -L "$file" ]] || cp "$file" "$libraries/$(patchelf --print-soname "$file" | grep . || basename "$file")"
  done
  cp "$REPO/LICENSE" "$licenses/surgtrack"
  cp "$OPENCV_SOURCE/LICENSE" "$licenses/opencv"
  cp "$BUILD_DIR/ffmpeg/COPYING.LGPLv2.1" "$licenses/ffmpeg"
  gathers "$libraries" "$licenses" "$libraries"/* "$tree"/cv2/python-*/*.so
  for file in "$libraries"/* "$tree"/cv2/python-*/*.so; do
    part="\$ORIGIN"
    [[ "$file" == "$libraries"/* ]] || part="\$ORIGIN/../../opencv_surgtrack.libs"
    patchelf --set-rpath "$part" "$file"
    while read -r part; do   # one by one: patchelf 0.14 spoils several at once
      [[ -z "${renames[$part]:-}" ]] || patchelf --replace-needed "$part" "${renames[$part]}" "$file"
    done < <(patchelf --print-needed "$file")
  done
  numpy="$("$PYTHON" -c 'import numpy; v = numpy.__version__.split("."); print("numpy >= %s.%s, < %d" % (v[0], v[1], int(v[0]) + 1))')"
  tag="$("$PYTHON" -c 'import os, sys, sysconfig
cp, libc = "cp%d%d" % sys.version_info[:2], os.confstr("CS_GNU_LIBC_VERSION").split()[1].replace(".", "_")
print("%s-%s-manylinux_%s_%s" % (cp, cp, libc, sysconfig.get_platform().split("-", 1)[1]))')"
  cat >"$licenses/../METADATA" <<METADATA
Metadata-Version: 2.1
Name: $NAME
Version: $VERSION
Summary: $SUMMARY
License: Apache-2.0; the libraries' own beside it
Requires-Python: == $PYTHON_VERSION.*
Requires-Dist: $numpy
Description-Content-Type: text/markdown

$(cat "$REPO/README.md")
METADATA
  printf 'Wheel-Version: 1.0\nGenerator: misc/package.sh\nRoot-Is-Purelib: false\nTag: %s\n' "$tag" >"$licenses/../WHEEL"
  run_logged "$LOGS/wheel.log" "the wheel could not be packed" "$PYTHON" -m wheel pack "$tree" --dest-dir "$PACKAGES_DIR"
}

PACKAGES+=(patchelf python3-wheel file)
[[ -z "$check" ]] || PACKAGES+=(mmdebstrap)
prepare
VERSION="$(source_version "$OPENCV_SOURCE")"
PYTHON_VERSION="$("$PYTHON" -c 'import sys; print("%d.%d" % sys.version_info[:2])')"
for kind in "${wanted[@]}"; do
  (make_"$kind")
done
ls -l "$PACKAGES_DIR"

if [[ -n "$check" ]]; then
  # shellcheck source=misc/checks/packages.sh
  source "$REPO/misc/checks/packages.sh"
  for kind in "${wanted[@]}"; do
    check_"$kind"
  done
fi
