#!/usr/bin/env python3
# This file is part of OpenCV project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution and at http://opencv.org/license.html.
"""Measures the tracker on many sequences whose truth is known, a process a sequence: the same files as those of
example_surgtrack_evaluate, byte for byte but for timings.csv. Sequences whose results are in --out already are not run again."""

import argparse
import concurrent.futures
import os
import shutil
import subprocess
import sys
import time

PROGRAM = 'example_surgtrack_evaluate'
BASELINES = {  # options handed on as they are
    'baselines': 'systems that the paper compares with: gradboost, reiter2014, reiter2012',
    'train': 'folders of sequences with truth that they learn from',
    'parts': 'classes of parts that gradboost learns',
    'rounds': 'that gradboost learns',
    'trees': 'of reiter2014',
    'hypotheses': 'of reiter2012: coarse or fine',
}
FLAGS = {
    'leave-out': 'of --train those with the tested video are left out, not refused',
    'no-early-stopping': 'gradboost looks at all rounds everywhere',
}
ATTEMPTS = 2  # a sequence that failed is run once more: files may come late, memory may have been short


class Failure(Exception):
    """The line the user gets."""


class ArgumentParser(argparse.ArgumentParser):
    def error(self, message):
        raise Failure(message + ', see --help')


def positive(text):
    if not text.isdigit() or int(text) == 0:
        raise argparse.ArgumentTypeError("'%s': expected a whole number from 1" % text)
    return int(text)


def make_parser(description):
    """The options of example_surgtrack_evaluate, and where it is."""
    parser = ArgumentParser(description=description, allow_abbrev=False)
    parser.add_argument('--sequences', required=True, metavar='DIR[,DIR...]',
                        help='folders of sequences with groundtruth.csv; other folders are searched for such')
    parser.add_argument('--out', required=True, metavar='DIR', help='folder to write; is made if it does not exist')
    parser.add_argument('--methods', default='full,paper,epnp', help='full, paper, epnp; worst frames are those of the first')
    parser.add_argument('--frames', default='0', help='number of frames of each sequence, 0 = to the end of the video')
    parser.add_argument('--stereo', action='store_true', help='method full a second time with the right image, where there is one')
    for name, text in BASELINES.items():
        parser.add_argument('--' + name, help=text)
    for name, text in FLAGS.items():
        parser.add_argument('--' + name, action='store_true', help=text)
    parser.add_argument('--poses', metavar='NAME:FILE[,NAME:FILE...]', help='poses of other programs beside ours')
    parser.add_argument('--program', default=find_program(), metavar='FILE', help='the %s to run (default: %%(default)s)' % PROGRAM)
    parser.add_argument('--quiet', action='store_true', help='no progress')
    return parser


def find_program():
    """That of the build folder beside this one, else the one in PATH."""
    built = os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), 'build', 'bin', PROGRAM)
    return built if os.path.exists(built) else shutil.which(PROGRAM) or PROGRAM


def find_sequences(folders):
    """The folders of all sequences; as example_surgtrack_evaluate finds them, which keeps one without any to tell what is missing."""
    found = {}
    for folder in folders.split(','):
        if not folder:
            raise Failure("argument '--sequences=%s': expected folders separated by commas, none of them empty" % folders)
        paths = [folder]
        if os.path.isdir(folder) and not os.path.exists(os.path.join(folder, 'sequence.yaml')):
            paths = sorted(path for path, _, files in os.walk(folder, followlinks=True) if 'sequence.yaml' in files) or paths
        for path in paths:
            found.setdefault(os.path.realpath(path), path)
    return list(found.values())


def command(args, sequences, *flags):
    """The command line for some of the sequences."""
    line = [args.program, '--sequences=' + sequences, '--out=' + args.out, '--methods=' + args.methods, '--frames=' + args.frames]
    values = {name: getattr(args, name) for name in BASELINES}
    line += ['--%s=%s' % item for item in values.items() if item[1] is not None]
    line += ['--' + name for name in FLAGS if getattr(args, name.replace('-', '_'))]
    return line + ['--stereo'] * args.stereo + ['--quiet'] + list(flags)


def merging(args):
    """The flags of the last call, which alone needs the poses of others."""
    return ['--merge'] + (['--poses=' + args.poses] if args.poses is not None else [])


def check(args):
    """Refuses options that example_surgtrack_evaluate refuses, now and not for each sequence."""
    try:
        probe = subprocess.run(command(args, os.path.join(args.out, 'none'), *merging(args)), capture_output=True, text=True)
    except OSError as error:
        raise Failure("argument '--program=%s': %s" % (args.program, error.strerror))
    line = probe.stderr.strip().partition(': ')[2]
    if line.startswith('argument') or probe.returncode not in (0, 1):
        raise Failure(line or '%s ended with code %d' % (args.program, probe.returncode))


def run(line):
    """Runs a command. Returns the seconds it took; an error is its last words."""
    start = time.time()
    ended = subprocess.run(line, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    if ended.returncode:
        raise RuntimeError((ended.stderr.strip().splitlines() or ['ended with code %d' % ended.returncode])[-1])
    return time.time() - start


def retry(line):
    for _ in range(ATTEMPTS - 1):
        try:
            return run(line)
        except RuntimeError:
            pass
    return run(line)


class Report:
    """Tells of each sequence as it ends."""

    def __init__(self, args, total):
        self.quiet, self.total, self.done = args.quiet, total, 0

    def add(self, sequence, outcome):
        self.done += 1
        if not self.quiet:
            text = 'failed' if isinstance(outcome, Exception) else '%.1f s' % outcome
            sys.stderr.write('%d of %d: %s, %s\n' % (self.done, self.total, sequence, text))


def merge(args):
    """Makes the tables from the results. Its exit code is 1 if a sequence has none; it tells which, and why."""
    sys.stdout.flush()
    return subprocess.run(command(args, args.sequences, *merging(args))).returncode


def main():
    parser = make_parser(__doc__)
    parser.add_argument('--jobs', type=positive, default=os.cpu_count(), help='processes at a time (default: %(default)s, the processors)')
    args = parser.parse_args()
    check(args)
    sequences = find_sequences(args.sequences)
    report = Report(args, len(sequences))
    with concurrent.futures.ThreadPoolExecutor(args.jobs) as pool:
        runs = {pool.submit(retry, command(args, sequence, '--part')): sequence for sequence in sequences}
        try:
            for ended in concurrent.futures.as_completed(runs):
                report.add(runs[ended], ended.exception() or ended.result())
        except KeyboardInterrupt:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return merge(args)


if __name__ == '__main__':
    try:
        sys.exit(main())
    except Failure as error:
        sys.exit('evaluate.py: %s' % error)
    except KeyboardInterrupt:
        sys.exit(130)
