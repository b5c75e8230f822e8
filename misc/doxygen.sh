#!/usr/bin/env bash
# Runs Doxygen over the headers.

set -euo pipefail

usage() {
  cat <<'TEXT'
usage: misc/doxygen.sh [--help] FOLDER

Writes the reference of the module's headers into FOLDER/html. Warnings are shown and are an error: exit code 1. Citations are
resolved with doc/surgtrack.bib if bibtex is there; without it they stay as [key], and only their keys are checked.
TEXT
}

case "${1:-}" in
  -h | --help) usage; exit 0 ;;
  '' | -*) usage >&2; exit 1 ;;
esac

command -v doxygen >/dev/null || { echo "error: doxygen was not found" >&2; exit 1; }
mkdir -p "$1" || { echo "error: cannot make the folder $1" >&2; exit 1; }
output="$(cd "$1" && pwd -P)"
cd "$(dirname "${BASH_SOURCE[0]}")/.."

bad=0
while read -r key; do
  grep -q -F -e "{$key," doc/surgtrack.bib || { echo "error: @cite $key: not in doc/surgtrack.bib" >&2; bad=1; }
done < <(grep -rhoE '[@\\]cite +[A-Za-z0-9]+' include | awk '{ print $2 }' | sort -u)
[[ $bad -eq 0 ]] || exit 1

if command -v bibtex >/dev/null && command -v perl >/dev/null; then
  citations='CITE_BIB_FILES = doc/surgtrack.bib'
else
  # shellcheck disable=SC1003
  citations='INPUT_FILTER = "sed -E '\''s/[@\\]cite +([A-Za-z0-9]+)/[\1]/g'\''"'
fi

code=0
{
  cat doc/Doxyfile
  echo "OUTPUT_DIRECTORY = \"$output\""
  echo "WARN_LOGFILE = \"$output/warnings.log\""
  echo "$citations"
} | doxygen - >"$output/doxygen.log" 2>&1 || code=$?
if [[ $code -ne 0 || -s "$output/warnings.log" ]]; then
  cat "$output/doxygen.log" "$output/warnings.log" >&2
  echo "error: doxygen: exit code $code, $(wc -l <"$output/warnings.log") lines of warnings" >&2
  exit 1
fi
echo "$output/html/index.html"
