#!/usr/bin/env python3
# This file is part of OpenCV project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution and at http://opencv.org/license.html.
"""Runs the Python blocks of a Markdown file, one after the other, as one program. An error names the line of the file."""

import argparse
import os
import re
import sys
import traceback


def blocks(text):
    """The program: the file with everything but its Python blocks empty, so that lines keep their numbers."""
    lines, inside = [], False
    for line in text.split('\n'):
        fence = re.match(r'```(\w*)\s*$', line)
        lines.append(line if inside and not fence else '')
        inside = fence.group(1) == 'python' if fence and not inside else inside and not fence
    return '\n'.join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('file', help='the Markdown file')
    parser.add_argument('--folder', default='.', help='where to run it; is made if it does not exist (default: here)')
    args = parser.parse_args()
    with open(args.file) as file:
        program = blocks(file.read())
    if not program.strip():
        sys.exit('run_doc.py: %s: has no Python block' % args.file)
    path = os.path.abspath(args.file)
    os.makedirs(args.folder, exist_ok=True)
    os.chdir(args.folder)
    try:
        exec(compile(program, path, 'exec'), {'__name__': '__main__'})
    except Exception as error:
        lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == path]
        sys.exit('run_doc.py: %s, line %s: %s'
                 % (args.file, lines[-1] if lines else getattr(error, 'lineno', '?'), ' '.join(str(error).split()) or type(error).__name__))


if __name__ == '__main__':
    main()
