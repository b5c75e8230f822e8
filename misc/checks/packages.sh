# shellcheck shell=bash
# Packages, each in a root file system with nothing else. Sourced by misc/package.sh.

# makes_root ROOT PACKAGE...: a new one of this release, with these packages and what they need, and with apt.
makes_root() {
  local root="$1" sources
  shift
  # shellcheck disable=SC2016
  sources="$(apt-get indextargets --format 'deb $(REPO_URI) $(RELEASE) $(COMPONENT)' 'Created-By: Packages' 'Origin: Debian')"
  rm -rf "$root"
  mmdebstrap --variant=apt --include="$(IFS=,; echo "$*")" "$(. /etc/os-release; echo "$VERSION_CODENAME")" "$root" - <<<"$sources"
}

# inside ROOT COMMAND...: with /proc, by which a program finds the libraries beside it.
inside() {
  local root="$1"
  shift
  # shellcheck disable=SC2016
  unshare --mount sh -c 'mount -t proc proc "$0/proc" && exec chroot "$0" "$@"' "$root" env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"
}

# checked NAME COMMAND...
checked() {
  local name="$1"
  shift
  run_logged "$ALL_BUILD/package-check.log" "FAILED  $name" "$@"
  echo "ok      $name"
}

# README's Python program, in ROOT/work: on a sequence that is in demo/sequence there.
python_program() {
  mkdir -p "$1/work"
  # shellcheck disable=SC2016
  sed -n '/^```python$/,/^```$/p' "$REPO/README.md" | sed '1d;$d' >"$1/work/program.py"
}

check_deb() {
  local root="$ALL_BUILD/root-deb" deb
  step "Trying the .deb in a new root"
  deb="$(find "$PACKAGES_DIR" -name "${NAME}_${VERSION}_*.deb")"
  checked "deb: it depends on python3-numpy" bash -c "dpkg-deb -f '$deb' Depends | grep -q python3-numpy"
  checked "deb: all is in $WHERE" bash -c "! dpkg-deb -c '$deb' | grep -v -e ' \./\(opt/\)\?\$' -e ' \.$WHERE/'"
  checked "deb: a new root" makes_root "$root" ca-certificates
  cp "$deb" "$root/package.deb"
  cp /etc/resolv.conf "$root/etc/resolv.conf"
  checked "deb: it installs with what it depends on" inside "$root" sh -c "apt-get update && apt-get install -y --no-install-recommends /package.deb"
  python_program "$root"
  checked "deb: track_sequence on the built-in sequence" inside "$root" sh -c "cd /work && $WHERE/bin/example_surgtrack_track_sequence --frames=10 --poses=poses.csv"
  checked "deb: and finds the tool" grep -q tracking "$root/work/poses.csv"
  checked "deb: README's Python program" inside "$root" sh -c "mkdir -p /work/demo && cd /work &&
    ln -sfn $WHERE/share/opencv4/surgtrack/example demo/sequence && PYTHONPATH=$WHERE/lib/python3/dist-packages python3 program.py | grep tracking"
  checked "deb: it leaves nothing behind" inside "$root" sh -c "apt-get purge -y $NAME && test ! -e $WHERE"
  rm -rf "$root"
}

check_wheel() {
  local root="$ALL_BUILD/root-wheel" wheel packages=(python3-venv) venv=(python3 -m venv) pip=(/venv/bin/pip install)
  step "Trying the wheel in a new root"
  wheel="$(find "$PACKAGES_DIR" -name "${NAME//-/_}-$VERSION-*.whl")"
  if ! "$PYTHON" -m venv "$ALL_BUILD/index" >/dev/null || ! "$ALL_BUILD/index/bin/pip" download --no-deps -d "$ALL_BUILD/index" numpy >/dev/null 2>&1; then
    echo "pip has no index here: numpy is the distribution's"
    packages+=(python3-numpy)
    venv+=(--system-site-packages)
    pip+=(--no-index)
  fi
  checked "wheel: a new root" makes_root "$root" "${packages[@]}"
  cp "$wheel" "$root"
  cp /etc/resolv.conf "$root/etc/resolv.conf"
  checked "wheel: a virtual environment" inside "$root" "${venv[@]}" /venv
  checked "wheel: pip installs it" inside "$root" "${pip[@]}" "/${wheel##*/}"
  python_program "$root"
  checked "wheel: a sequence" inside "$root" /venv/bin/python -c '
import cv2, os
params = cv2.surgtrack.SyntheticScene.Params()
params.frames = 10
os.makedirs("/work/demo")
cv2.surgtrack.SyntheticScene.create(params=params).write("/work/demo/sequence")'
  checked "wheel: README's Python program" inside "$root" sh -c "cd /work && /venv/bin/python program.py | grep tracking"
  checked "wheel: its FFmpeg is not under the GPL" inside "$root" /venv/bin/python -c '
import ctypes, cv2, glob, os
library, = glob.glob(os.path.join(os.path.dirname(cv2.__file__), "..", "opencv_surgtrack.libs", "libavcodec*"))
license = ctypes.CDLL(library).avcodec_license
license.restype = ctypes.c_char_p
assert license().startswith(b"LGPL"), license()'
  rm -rf "$root" "$ALL_BUILD/index"
}
