# shellcheck shell=bash
# What the files of src/ and include/ may include. Sourced by misc/test.sh.

# wings_hold FOLDER: the files of each wing name only those of the wings it may, no wing names back, no file is too long.
wings_hold() {
  "$PYTHON" - "$1" <<'PYTHON'
import os, re, sys
root, bad = sys.argv[1], []
MAY = {   # beside itself; all may name precomp.hpp, which names none
    'base': '',
    'model': 'base',
    'render': 'base model',
    'detect': 'base model render',
    'filter': 'base model render detect',
    'files': 'base model',
    'track': 'base model render detect filter',
    'draw': 'base model render detect',
    'vtk': 'base model render draw',
    'lab': 'base model render detect filter files track draw vtk',
    'precomp.hpp': '',
}
HEADERS = {   # of include/opencv2/surgtrack: whose they are
    'base': 'fields names',
    'model': 'camera tool_model tool_view tracking_state part_match tool_estimate',
    'render': 'mesh_renderer',
    'detect': 'part_templates qgo qgo_matcher geometric_context part_finder contour',
    'filter': 'tool_pose_ekf articulated_pose_ekf reading_errors',
    'files': 'sequence',
    'track': 'tool_tracker',
    'draw': 'draw',
    'vtk': 'scene_view',
    'lab': 'synthetic hand_eye time_offset import tool_setup live pose_score setup_check tracker_params tool_state lab',
}
LONGEST = 400
PUBLIC = 'opencv2/surgtrack/'
wing_of = {PUBLIC + name + '.hpp': wing for wing, names in HEADERS.items() for name in names.split()}

def files(folder):
    for path, _, names in os.walk(os.path.join(root, folder)):
        for name in names:
            full = os.path.join(path, name)
            yield os.path.relpath(full, os.path.join(root, folder)), open(full).read()

def check(file, text, wing):
    for name in re.findall(r'^\s*#\s*include\s+"([^"]+)"', text, re.M):
        named = wing_of.get(name) if name.startswith('opencv2/surgtrack') else name.split('/')[0] if not name.startswith('opencv2/') else ''
        if name == 'opencv2/surgtrack.hpp':
            bad.append('%s: names all of opencv2/surgtrack.hpp, expected the headers it needs' % file)
        elif named is None or (named and named not in MAY):
            bad.append('%s: %s belongs to no wing' % (file, name))
        elif named and named != wing and named != 'precomp.hpp' and named not in MAY[wing].split():
            bad.append('%s: %s may not name %s (%s)' % (file, wing, named, name))

for file, text in files('src'):
    wing = file.split(os.sep)[0]
    if wing not in MAY:
        bad.append('src/%s: there is no such wing' % file)
        continue
    check('src/' + file, text, wing)
    lines = text.count('\n')
    if file.endswith('.simd.hpp'):   # numeric kernels
        continue
    if lines > LONGEST:
        bad.append('src/%s: %d lines, expected at most %d' % (file, lines, LONGEST))
public = dict(files('include'))
for file in sorted(public):
    if file == 'opencv2/surgtrack.hpp':   # tracking: no one names this one
        for name in re.findall(r'^#include "([^"]+)"', public[file], re.M):
            if wing_of.get(name) in ('lab', 'vtk', None):
                bad.append('%s: may not name %s' % (file, name))
    elif file not in wing_of:
        bad.append('%s: belongs to no wing' % file)
    else:
        check(file, public[file], wing_of[file])
for header in sorted(set(wing_of) - set(public)):
    bad.append('%s: there is no such file' % header)
sys.exit('\n'.join(bad) or 0)
PYTHON
}

# finds_wing WORD FOLDER: what does not hold is told.
finds_wing() { ! wings_hold "$2" 2>"$LOGS/wings.log" && grep -q -F -e "$1" "$LOGS/wings.log"; }

run_wings() {
  local work="$1/wings"
  sample "wings: each names only those it may" wings_hold "$REPO"
  rm -rf "$work"
  mkdir "$work"
  cp -r "$REPO/src" "$REPO/include" "$work"
  echo '#include "track/tool_tracker.hpp"' >>"$work/src/detect/qgo.hpp"
  echo '#include "opencv2/surgtrack/draw.hpp"' >>"$work/include/opencv2/surgtrack/contour.hpp"
  printf '//\n%.0s' {1..400} >>"$work/src/base/geometry.cpp"
  sample "refused: a source that names back" finds_wing "src/detect/qgo.hpp: detect may not name track" "$work"
  sample "refused: a header that names back" finds_wing "contour.hpp: detect may not name draw" "$work"
  sample "refused: a long file" finds_wing "src/base/geometry.cpp" "$work"
}
