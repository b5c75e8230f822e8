# This file is part of OpenCV project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution and at http://opencv.org/license.html.
"""What track_sequence.py reads frames with, and writes and shows its results with."""

import concurrent.futures
import sys
import time

import cv2 as cv

st = cv.surgtrack


class Failure(Exception):
    """The line the user gets."""


class FrameReader:
    """A video whose frames all have the size the sequence says; decoded in a thread of its own, one frame ahead. See EyesReader."""

    def __init__(self, sequence, start, right=False):
        self.filename = sequence.rightVideo() if right else sequence.leftVideo()
        self.size, self.layout = sequence.frameSize(), sequence.layout()
        self.capture = cv.VideoCapture(self.filename)
        self.capture.set(cv.CAP_PROP_ORIENTATION_AUTO, 0)       # frames as the camera was calibrated with, not turned
        if not self.capture.isOpened():
            raise Failure('%s: can\'t be read as a video%s' % (self.filename, ', expected images numbered from 0 or 1 on' if '%' in self.filename else ''))
        turned, header = round(self.capture.get(cv.CAP_PROP_ORIENTATION_META)), self.capture.get(cv.CAP_PROP_FPS)
        if turned in (90, 180, 270):
            sys.stderr.write('note: %s: is to be rotated by %d degrees by its header, its frames are taken as they were recorded\n' % (self.filename, turned))
        images = '%' in self.filename   # have no rate of their own
        if not sequence.hasFrameTimes() and not images and 0 < header < 1000 and abs(header - sequence.fps()) > 0.01 * sequence.fps():
            sys.stderr.write('warning: %s: %g frames/s by its header, %g by fps: is fps right?\n' % (self.filename, header, sequence.fps()))
        self.rate, self.shift = 0 if sequence.hasFrameTimes() else header, None     # of the time stamps, see check_stamp()
        self.count = int(self.capture.get(cv.CAP_PROP_FRAME_COUNT))
        self.next = 0
        while self.next < start and self.capture.grab():  # seeking is not exact in every container
            self.next += 1
        if self.next < start:
            raise Failure('%s: has %d frames, none at --start=%d' % (self.filename, self.next, start))
        self.thread = concurrent.futures.ThreadPoolExecutor(1)
        self.decoded = self.thread.submit(self.decode)

    def decode(self):
        found, image = self.capture.read()
        return found, image, 1e-3 * self.capture.get(cv.CAP_PROP_POS_MSEC)

    def check_stamp(self, stamp):
        """Says so, once, if the video's own time stamps [s] are not those of a constant rate."""
        if self.rate <= 0 or stamp <= 0:    # not said
            return
        late = stamp - self.next / self.rate
        self.shift = late if self.shift is None else self.shift     # a clip that was cut begins later
        if abs(late - self.shift) >= 1.5 / self.rate:
            sys.stderr.write('warning: %s: the time stamps are not k / fps: frame %d is %.3f s off; a variable frame rate, or frames that were left out? '
                             'frames.csv with the columns frame,stamp says when each was taken\n' % (self.filename, self.next, late - self.shift))
            self.rate = 0

    def read(self):
        found, image, stamp = self.decoded.result()
        if not found:
            return None
        self.decoded = self.thread.submit(self.decode)
        self.check_stamp(stamp)
        if (image.shape[1], image.shape[0]) != tuple(self.size):
            raise Failure('%s: frame %d has %dx%d pixels, expected %dx%d as in sequence.yaml%s'
                          % ((self.filename, self.next, image.shape[1], image.shape[0]) + tuple(self.size)
                             + (' by image_width, image_height and layout' if self.layout
                                else ': is it turned by 90 degrees?' if image.shape[:2] == tuple(self.size) else '',)))
        self.next += 1
        return image

    def check_end(self, sequence):
        if self.next < self.count and '%' in self.filename:
            raise Failure('%s: ends after %d images, expected %d: is one missing?' % (self.filename, self.next, self.count))
        if self.next < sequence.groundTruthEnd():
            raise Failure('%s: ends after %d frames, expected %d as in the ground truth' % (self.filename, self.next, sequence.groundTruthEnd()))
        if self.next + 2 < self.count:      # some containers count what was cut off
            sys.stderr.write('note: %s: has %d frames, its header counts %d\n' % (self.filename, self.next, self.count))


class EyesReader:
    """The images of one eye, or of both."""

    def __init__(self, sequence, start, stereo):
        self.sequence, self.frames = sequence, []
        self.together = stereo and sequence.layout() != st.LAYOUT_SEPARATE     # in one file
        self.readers = [FrameReader(sequence, start, right) for right in ([False, True] if stereo and not self.together else [False])]
        self.count = self.readers[0].count
        self.combed = 0

    def read(self):
        """Whether there is a next frame; an error if one of the videos should have gone on."""
        frames = [reader.read() for reader in self.readers]
        ended = [reader for reader, frame in zip(self.readers, frames) if frame is None]
        for reader in ended:
            reader.check_end(self.sequence)
        if len(ended) == 1 < len(frames):
            other = self.readers[1 - self.readers.index(ended[0])]
            raise Failure('%s: ends after %d frames, expected more, as in %s' % (ended[0].filename, ended[0].next, other.filename))
        self.frames = frames * 2 if self.together else frames
        return not ended

    def images(self, field=0):
        """Of the frame read last, of its first or second field."""
        return [self.sequence.eyeImage(frame, eye=eye, field=field) for eye, frame in enumerate(self.frames)]

    def note_fields(self, image):
        """Says so, once, if images are interlaced and the description does not tell."""
        sure = 3    # images
        if self.sequence.imagesPerFrame() > 1 or self.combed >= sure or not st.isInterlaced(image):
            return
        self.combed += 1
        if self.combed == sure:
            sys.stderr.write('note: %s: is interlaced, only one field of each frame is used: write fields: top_first (or bottom_first, as DV has) '
                             'into sequence.yaml for both\n' % self.sequence.leftVideo())


class Overlay:
    """The overlay video."""

    def __init__(self, filename, fps, size):
        self.filename, self.frames = filename, 0
        for code in ('avc1', 'mp4v'):
            self.writer = cv.VideoWriter(filename, cv.VideoWriter_fourcc(*code), fps, size)
            if self.writer.isOpened():
                return
        raise Failure('%s: can\'t be written as a video, expected a file in a folder that exists, such as overlay.mp4' % filename)

    def write(self, image):
        self.writer.write(image)
        self.frames += 1

    def finish(self):
        self.writer.release()
        if self.frames and cv.VideoCapture(self.filename).get(cv.CAP_PROP_FRAME_COUNT) < self.frames:
            raise Failure('%s: not all of its %d frames were written, is the disk full?' % (self.filename, self.frames))


class Progress:
    """A line on stderr that is written over itself, if stderr is a terminal."""

    def __init__(self, total, quiet):
        self.total, self.enabled = total, not quiet and sys.stderr.isatty()
        self.start = self.last = time.time()

    def show(self, done):
        now = time.time()
        if not self.enabled or (now - self.last < 0.2 and done != self.total):
            return
        self.last = now
        rate = done / max(now - self.start, 1e-9)
        eta = int(max(0, self.total - done) / rate)
        sys.stderr.write('\rframe %d of %d   %.1f frames/s   ETA %d:%02d   ' % (done, self.total, rate, eta // 60, eta % 60))
        sys.stderr.flush()

    def clear(self):
        if self.enabled:
            sys.stderr.write('\r%60s\r' % '')
