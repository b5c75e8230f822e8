#!/usr/bin/env python3
# This file is part of OpenCV project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution and at http://opencv.org/license.html.
"""Plays a robot: sends the joint readings of a recorded sequence by UDP, as JSON, at their pace.

    send_joints.py --sequence=DIR [--to=[TOOL=]HOST:PORT ...] [--format=plain|dvrk] [--speed=FACTOR]
                   [--loss=SHARE] [--delay=SECONDS] [--reorder=SHARE] [--malformed=SHARE] [--seed=N]

--format=plain sends one message a reading with the tool's name in it, to every place named by --to. --format=dvrk sends what the
dVRK's sawSocketStreamer does: one message for the arm's joints and one for the jaw, without the tool's name, so that each tool
needs a place of its own: --to=PSM1=127.0.0.1:48051 --to=PSM2=127.0.0.1:48052. Readings hold from the last one of the recording
for half a second more, so that the last image has its joints.

The network's faults are made here, the same for the same seed: --loss is the share of the messages that are not sent; --delay how
much later than its time each one is [s]; --reorder the share that is held back until after the next two; --malformed the share
beside which a damaged message is sent.
"""

import argparse
import csv
import json
import os
import random
import re
import socket
import sys
import time

DVRK_NAMES = ['yaw', 'pitch', 'insertion', 'roll', 'wrist_pitch', 'wrist_yaw']
HOLD = 0.5       # [s]


class Error(Exception):
    pass


def share(text):
    value = float(text)
    if not 0 <= value <= 1:
        raise ValueError()
    return value


def positive(text):
    value = float(text)
    if not 0 < value < 1e6:
        raise ValueError()
    return value


def at_least_zero(text):
    value = float(text)
    if not 0 <= value < 60:
        raise ValueError()
    return value


def read_places(texts):
    """[(tool or None, (host, port))] of --to"""
    places = []
    for text in texts:
        found = re.match(r'(?:([^=]+)=)?([^=:]+):([0-9]{1,5})$', text)
        if not found or not 0 < int(found.group(3)) < 65536:
            raise Error("argument '--to=%s': expected HOST:PORT or TOOL=HOST:PORT, such as 127.0.0.1:48051" % text)
        try:
            places.append((found.group(1), (socket.gethostbyname(found.group(2)), int(found.group(3)))))
        except OSError as e:
            raise Error("argument '--to=%s': no such host: %s" % (text, e))
    return places


def read_kinematics(folder):
    """[(time [s], tool, {joint: position})] by rising time"""
    filename = os.path.join(folder, 'kinematics.csv')
    readings = []
    try:
        with open(filename, newline='') as f:
            for line, row in enumerate(csv.DictReader(f), 2):
                try:
                    joints = dict((name, float(value)) for name, value in row.items() if name not in ('time', 'tool'))
                    readings.append((float(row['time']), row['tool'], joints))
                except (KeyError, TypeError, ValueError):
                    raise Error('%s, line %d: expected the columns time and tool, and a number a joint' % (filename, line))
    except OSError as e:
        raise Error('%s: %s' % (filename, e.strerror))
    if not readings:
        raise Error('%s: has no readings' % filename)
    readings.sort(key=lambda reading: reading[0])
    last = dict((tool, joints) for _, tool, joints in readings)     # the last one of each tool
    end = readings[-1][0]
    for i in range(1, int(100 * HOLD) + 1):
        readings.extend((end + 0.01 * i, tool, joints) for tool, joints in last.items())
    return readings


def messages(reading, style):
    """The texts to send for a reading."""
    stamp, tool, joints = reading
    if style == 'plain':
        return [json.dumps({'tool': tool, 'time': stamp, 'position': joints})]

    def state(names, positions):
        return {'AutomaticTimestamp': False, 'Effort': None, 'Name': names, 'Position': positions, 'Timestamp': stamp, 'Valid': True, 'Velocity': None}

    arm = [value for name, value in joints.items() if name != 'jaw']
    names = DVRK_NAMES if len(arm) == len(DVRK_NAMES) else [name for name in joints if name != 'jaw']
    texts = [json.dumps({'measured_js': state(names, arm)})]
    if 'jaw' in joints:
        texts.append(json.dumps({'jaw/measured_js': state(['jaw'], [joints['jaw']])}))
    return texts


def damaged(text, rng):
    """What a network or another program might send in its place: cut off, of another type, not JSON, not text."""
    kind = rng.randrange(4)
    if kind == 0:
        return text[:rng.randrange(len(text))].encode()
    if kind == 1:
        return re.sub(r'\[?-?[0-9]+\.[0-9]+', '"?"', text).encode()
    if kind == 2:
        return b'[' * rng.randrange(1, 2000)
    return bytes(rng.randrange(256) for _ in range(rng.randrange(1, 200)))


def schedule(readings, args):
    """[(when [s] from the first reading, place, bytes)] by rising time, and the numbers of messages lost, reordered and damaged."""
    rng = random.Random(args.seed)
    counts = dict(lost=0, reordered=0, malformed=0)
    first = readings[0][0]
    steps = sorted(set(reading[0] for reading in readings))
    interval = (steps[-1] - steps[0]) / max(1, len(steps) - 1)
    packets = []
    for reading in readings:
        for text in messages(reading, args.format):
            for tool, place in args.places:
                if tool not in (None, reading[1]):
                    continue
                when = (reading[0] - first) / args.speed + args.delay
                if rng.random() < args.malformed:
                    counts['malformed'] += 1
                    packets.append((when, place, damaged(text, rng)))
                if rng.random() < args.loss:
                    counts['lost'] += 1
                    continue
                if rng.random() < args.reorder:
                    counts['reordered'] += 1
                    when += 2.5 * interval / args.speed
                packets.append((when, place, text.encode()))
    packets.sort(key=lambda packet: packet[0])
    return packets, counts


def send(packets):
    link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    start = time.monotonic()
    for when, place, data in packets:
        wait = start + when - time.monotonic()
        if wait > 0:
            time.sleep(wait)
        try:
            link.sendto(data, place)
        except ConnectionRefusedError:      # nobody listens yet, or any more
            pass
    link.close()


def main():
    parser = argparse.ArgumentParser(description='Sends the joint readings of a recorded sequence by UDP, as a robot would.', allow_abbrev=False)
    parser.add_argument('--sequence', required=True, metavar='DIR', help='folder with kinematics.csv')
    parser.add_argument('--to', action='append', metavar='[TOOL=]HOST:PORT', help='where to; default 127.0.0.1:48051')
    parser.add_argument('--format', choices=('plain', 'dvrk'), default='plain', help='of the messages, default plain')
    parser.add_argument('--speed', type=positive, default=1, metavar='FACTOR', help='times faster than recorded, default 1')
    parser.add_argument('--loss', type=share, default=0, metavar='SHARE', help='of the messages that are lost, 0 to 1')
    parser.add_argument('--delay', type=at_least_zero, default=0, metavar='SECONDS', help='of every message, 0 to 60')
    parser.add_argument('--reorder', type=share, default=0, metavar='SHARE', help='of the messages that come after the next two, 0 to 1')
    parser.add_argument('--malformed', type=share, default=0, metavar='SHARE', help='of damaged messages beside the right ones, 0 to 1')
    parser.add_argument('--seed', type=int, default=1, metavar='N', help='of the faults')
    args = parser.parse_args()
    try:
        args.places = read_places(args.to or ['127.0.0.1:48051'])
        readings = read_kinematics(args.sequence)
        if args.format == 'dvrk' and len(set(r[1] for r in readings)) > 1 and any(tool is None for tool, _ in args.places):
            raise Error("argument '--to': messages of the dVRK do not name the tool, expected TOOL=HOST:PORT for each")
        packets, counts = schedule(readings, args)
        send(packets)
        print('%d messages sent, %d of them damaged, %d held back; %d lost' % (len(packets), counts['malformed'], counts['reordered'], counts['lost']))
        return 0
    except Error as e:
        print('send_joints.py: %s' % e, file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        return 1


if __name__ == '__main__':
    sys.exit(main())
