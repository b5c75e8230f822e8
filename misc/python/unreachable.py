#!/usr/bin/env python3
# This file is part of OpenCV project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution and at http://opencv.org/license.html.
"""Says what of the module's public headers Python cannot reach: classes, functions, methods and fields without a word for the binding
generator. What stays in C++ on purpose is in CPP_ONLY, with the reason; an entry that is not needed is an error, too."""

import os
import re
import sys

HEADERS = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', '..', 'include', 'opencv2')

CPP_ONLY = {
    'CameraModel.project': 'one point at a time: projectPoints() does many',
    'CameraModel.fx, fy, cx, cy': 'cameraMatrix() has them',
    'CameraModel.k': 'distCoeffs() has them',
    'ToolPoseEKF.copyTo': 'state(), covariance() and reset() have what Python needs of it',
    'ToolModel.Link': 'a tool is described by its file',
    'ToolModel.Keypoint': 'a tool is described by its file',
    'ToolModel.Description': 'a tool is described by its file',
    'ToolModel.create': 'takes a Description: load() reads one from a file',
    'ToolModel.links': 'linkNames(), linkMesh() and linkPoses() have what Python needs of them',
    'ToolModel.keypoints': 'keypointNames() and keypointPositions() have what Python needs of them',
    'ToolModel.description': 'a tool is described by its file',
    'ToolModel.forwardKinematics': 'linkPoses() is the same as an array',
    'Rendering.create': 'memory for a renderer, which is derived in C++',
    'TemplateFeature': 'PartTemplate.getFeatures() is all of them as an array',
    'PartTemplate.features': 'getFeatures() is the same as an array',
    'ToolView.base_T_link': 'given to the constructor, read by linkPoses(): a list of matrices comes to Python without its shape',
    'PartFinder': 'renderers, matchers and verifiers do the same one by one',
    'PartDrawing': 'of PartFinder',
    'PartWindows': 'of PartFinder',
    'FoundParts': 'of PartFinder',
    'meanSimilarity': 'numpy does it',
    'GeometricContextVerifier.copySample': 'saves a copy of memory: sample() is the same',
    'ArticulatedPoseEKF.Belief': 'of State',
    'ArticulatedPoseEKF.const int MAX_OFFSETS = 10, MAX_STATES = 40': 'sizes of State',
    'ArticulatedPoseEKF.State': 'an image of memory; copyTo() keeps a filter as it is',
    'ArticulatedPoseEKF.state': 'see State',
    'ArticulatedPoseEKF.setState': 'see State',
    'ArticulatedPoseEKF.dropReadings': 'see State',
    'ArticulatedPoseEKF.correctJoints': 'joints() and offsets() have what Python needs of it',
    'ToolSight': 'for pictures: track_sequence --debug draws them',
    'ToolTracker.sight': 'see ToolSight',
    'PartTemplateRenderer.swapRendering': 'saves a copy of memory; rendering() is a copy in Python',
}


def blocks(text):
    """The declarations of a scope: what ends with a semicolon, or with a block in braces, which comes apart."""
    start = depth = 0
    opened = None
    for i, c in enumerate(text):
        if c == '{':
            depth += 1
            if depth == 1:
                opened = i
        elif c == '}':
            depth -= 1
            if depth == 0:
                yield text[start:opened].strip(), text[opened + 1:i]
                start = i + 1
        elif c == ';' and depth == 0:
            yield text[start:i].strip(), None
            start = i + 1


def declarations(text, scope='', public=True):
    """Path, name in Python and whether it is reachable, of everything public."""
    for head, body in blocks(text):
        for label in re.finditer(r'\b(public|private|protected)\s*:(?!:)', head):
            public = label.group(1) == 'public'
        head = re.sub(r'^.*\b(?:public|private|protected)\s*:(?!:)', '', head, flags=re.DOTALL).strip()
        kind = re.match(r'(?:class|struct)\s+(CV_EXPORTS\w*)\s+(\w+)', head)
        if re.match(r'namespace\b', head):
            for found in declarations(body, scope):
                yield found
        elif kind and body is not None and public:
            path = scope + kind.group(2)
            yield path, path, kind.group(1).startswith('CV_EXPORTS_W')
            if kind.group(1).startswith('CV_EXPORTS_W'):   # else all of it is as unreachable as its name
                for found in declarations(body, path + '.', head.startswith('struct')):
                    yield found
        elif not head or not public or re.match(r'(enum|typedef|using|friend|class|struct|template)\b', head):
            continue
        elif '(' in re.sub(r'CV_\w+_AS\(\w+\)', '', head):
            name = re.search(r'(~?\w+)\s*\(', re.sub(r'CV_\w+_AS\(\w+\)', '', head)).group(1)
            if name.startswith('~') or not scope and not head.startswith('CV_EXPORTS'):
                continue
            alias = re.match(r'CV_(?:WRAP|EXPORTS)_AS\((\w+)\)', head)
            wrapped = alias or re.match(r'CV_WRAP\b|CV_EXPORTS_W\b', head)
            yield scope + name, scope + (alias.group(1) if alias else name), bool(wrapped)
        elif scope:
            names = re.sub(r'\[.*?\]', '', re.sub(r'^(?:CV_PROP\w*\s+)?[\w:]+(?:<.*>)?\s+', '', head))
            yield scope + names, scope + names, head.startswith('CV_PROP')


def unreachable(headers=HEADERS):
    """What Python cannot reach and should, and entries of CPP_ONLY that it can reach, as lines to read."""
    names = []
    for header in ('surgtrack.hpp', 'surgtrack/lab.hpp'):   # tracking, and what is around it
        with open(os.path.join(headers, header)) as file:
            names += re.findall(r'#include "opencv2/(surgtrack/\w+\.hpp)"', file.read())
    found, defaults = [], []
    for name in names:
        with open(os.path.join(headers, name)) as file:
            text = re.sub(r'//[^\n]*|/\*.*?\*/|(?m:^[ \t]*#(?:\\\n|[^\n])*)', '', file.read(), flags=re.DOTALL)
        found += declarations(text)
        defaults += [match.group(1) for match in re.finditer(r'\b(?:CV_WRAP|CV_EXPORTS_W|CV_\w+_AS\(\w+\))[^;{(]*?(\w+)\([^;{]*?\bMatx\w+&?\s+\w+\s*=', text)]
    reached = {python for _, python, wrapped in found if wrapped}
    missing = {path for path, _, wrapped in found if not wrapped and path not in reached}
    return (['%s: Python cannot reach it; expected CV_WRAP, or a reason in CPP_ONLY' % path for path in sorted(missing - set(CPP_ONLY))]
            + ['%s: in CPP_ONLY, but there is no such thing that Python cannot reach' % path for path in sorted(set(CPP_ONLY) - missing)]
            + ['%s: OpenCV cannot leave out a Matx argument; expected an overload in the place of its default' % name for name in defaults])


if __name__ == '__main__':
    lines = unreachable()
    sys.exit('\n'.join(lines) if lines else 0)
