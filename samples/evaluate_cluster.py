#!/usr/bin/env python3
# This file is part of OpenCV project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution and at http://opencv.org/license.html.
"""Measures the tracker on many sequences whose truth is known, on a cluster: a Dask task a sequence. The files are those of
example_surgtrack_evaluate, byte for byte but for timings.csv. Sequences whose results are in --out already are not run again; what a
worker had not finished when it was lost is given to another one.

All workers see sequences, --out and the program under the same paths. On one machine:

    dask-scheduler &
    dask-worker tcp://127.0.0.1:8786 --nthreads 1 --nworkers 2 &
    evaluate_cluster.py --scheduler=tcp://127.0.0.1:8786 --sequences=DIR --out=OUT
"""

import os
import sys

import evaluate


def connect(address):
    try:
        import cloudpickle
        import distributed
    except ImportError:
        raise evaluate.Failure('a cluster needs dask.distributed (Debian: python3-distributed)')
    cloudpickle.register_pickle_by_value(evaluate)  # workers need not have the samples
    try:
        return distributed, distributed.Client(address, timeout=10)
    except (OSError, ValueError) as error:
        raise evaluate.Failure("argument '--scheduler=%s': there is no scheduler, expected an address such as tcp://127.0.0.1:8786 (%s)"
                               % (address, str(error).strip().split('\n')[0]))


def main():
    parser = evaluate.make_parser(__doc__)
    parser.add_argument('--scheduler', required=True, metavar='ADDRESS', help='of the Dask scheduler, such as tcp://127.0.0.1:8786')
    args = parser.parse_args()
    args.program = os.path.abspath(args.program) if os.path.dirname(args.program) else args.program
    args.out = os.path.abspath(args.out)
    args.sequences = ','.join(os.path.abspath(folder) for folder in args.sequences.split(','))
    if args.train is not None:
        args.train = ','.join(os.path.abspath(folder) for folder in args.train.split(','))
    evaluate.check(args)
    sequences = evaluate.find_sequences(args.sequences)
    report = evaluate.Report(args, len(sequences))
    distributed, client = connect(args.scheduler)
    with client:
        # A worker that is lost does not count: Dask gives its tasks to others, `allowed-failures` (3) times.
        runs = {client.submit(evaluate.run, evaluate.command(args, sequence, '--part'), pure=False, retries=evaluate.ATTEMPTS - 1): sequence
                for sequence in sequences}
        for ended in distributed.as_completed(runs):
            report.add(runs[ended], ended.exception() or ended.result())
    return evaluate.merge(args)


if __name__ == '__main__':
    try:
        sys.exit(main())
    except evaluate.Failure as error:
        sys.exit('evaluate_cluster.py: %s' % error)
    except KeyboardInterrupt:
        sys.exit(130)
