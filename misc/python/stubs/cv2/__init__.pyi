# This file is part of OpenCV project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution and at http://opencv.org/license.html.
"""Stubs of this module alone: of the rest of cv2, which has none before 4.8, everything is taken to be there."""

from typing import Any

from . import surgtrack as surgtrack

class error(Exception):
    code: int
    err: str
    file: str
    func: str
    line: int
    msg: str

def __getattr__(name: str) -> Any: ...
