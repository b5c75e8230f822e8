#!/usr/bin/env python3
# This file is part of OpenCV project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution and at http://opencv.org/license.html.
"""Runs the sh and python blocks of a Markdown page in their order, in a folder that looks like the repository after misc/demo.sh.

All python blocks of a page are one program; each sh block is pasted into a new shell. An error names the line of the page.
What a machine may lack stands in a sh block of its own, which can be left out."""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import traceback

REPOSITORY = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


class Failure(Exception):
    pass


def blocks(text):
    """(language, program) of each block; before the program there are as many empty lines as in the page, so that lines keep their numbers."""
    found, lines, language = [], [], None
    for number, line in enumerate(text.split('\n')):
        fence = re.match(r'```(\w*)\s*$', line)
        if fence and language is None:
            language, lines = fence.group(1), [''] * (number + 1)
        elif fence:
            if language in ('sh', 'python'):
                found.append((language, '\n'.join(lines) + '\n'))
            language = None
        elif language is not None:
            lines.append(line)
    return found


def prepare(folder, build, demo):
    """What the repository has, by links; demo/ is a copy, as commands may write into it."""
    os.makedirs(folder, exist_ok=True)
    places = {name: os.path.join(REPOSITORY, name) for name in ('doc', 'misc', 'samples')}
    places['build'] = build
    for name, place in places.items():
        if not os.path.lexists(os.path.join(folder, name)):
            os.symlink(os.path.abspath(place), os.path.join(folder, name))
    if demo and not os.path.exists(os.path.join(folder, 'demo')):
        shutil.copytree(demo, os.path.join(folder, 'demo'))


def run_shell(program, page, environment):
    with tempfile.NamedTemporaryFile('w', suffix='.sh') as file:
        file.write("trap 'echo $LINENO >\"$RUN_DOC_LINE\"' ERR\n" + program[1:])   # the page's first line is never in a block
        file.flush()
        line = file.name + '.line'
        code = subprocess.call(['bash', '-eEuo', 'pipefail', file.name], env=dict(environment, RUN_DOC_LINE=line), stderr=subprocess.STDOUT)
        where = '?'
        if os.path.exists(line):
            with open(line) as reported:
                where = reported.read().split()[-1]
            os.remove(line)
    if code:
        raise Failure('%s, line %s: exit code %d' % (page, where, code))


def run_python(program, page, names):
    path = os.path.abspath(page)
    try:
        exec(compile(program, path, 'exec'), names)
    except Exception as error:
        lines = [frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == path]
        raise Failure('%s, line %s: %s' % (page, lines[-1] if lines else getattr(error, 'lineno', '?'),
                                           ' '.join(str(error).split()) or type(error).__name__))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('page', help='the Markdown file')
    parser.add_argument('--folder', default='.', help='where to run it; is made if it does not exist (default: here)')
    parser.add_argument('--build', default=os.path.join(REPOSITORY, 'build'), help='build folder (default: build/ of the repository)')
    parser.add_argument('--demo', help='folder to copy to demo/, as misc/demo.sh makes it')
    parser.add_argument('--without', action='append', default=[], help='leave out sh blocks with this word; may be given several times')
    args = parser.parse_args()
    with open(args.page) as file:
        found = blocks(file.read())
    if not found:
        sys.exit('run_doc.py: %s: has no sh or python block' % args.page)
    prepare(args.folder, args.build, args.demo)
    page = os.path.abspath(args.page)
    os.chdir(args.folder)
    sys.path.insert(0, os.path.abspath('build/python_loader'))
    environment = {key: value for key, value in os.environ.items() if key != 'PYTHONPATH'}   # a page says itself what it needs
    environment['PYTHONDONTWRITEBYTECODE'] = '1'
    names = {'__name__': '__main__'}
    for language, program in found:
        if language == 'sh' and any(word in program for word in args.without):
            continue
        try:
            if language == 'sh':
                run_shell(program, page, environment)
            else:
                run_python(program, page, names)
        except Failure as failure:
            sys.exit('run_doc.py: %s' % failure)
        sys.stdout.flush()


if __name__ == '__main__':
    main()
