# This file is part of OpenCV project.
# It is subject to the license terms in the LICENSE file found in the top-level directory
# of this distribution and at http://opencv.org/license.html.
"""The Python part of cv2.surgtrack: its values have a readable repr and can be copied and pickled, and cv2.error.err is of the
error it is asked of."""

import copyreg as _copyreg
import types as _types

import numpy as _np
from cv2 import error as _error
from cv2 import surgtrack as _bindings   # all that is in there comes into this package once it is loaded

_VALUES = (_bindings.ToolEstimate, _bindings.PartMatch, _bindings.StageTime, _bindings.PoseScore)   # structures with writable fields only
_SHOWN = 16   # numbers: a pose is shown, a covariance is not


def _fields(cls):
    return [name for name, member in vars(cls).items() if isinstance(member, _types.GetSetDescriptorType)]


def _text(name, value):
    if name == 'state':
        return _bindings.stateName(value)
    if isinstance(value, str):
        return repr(value)
    if isinstance(value, tuple) and value and isinstance(value[0], _VALUES):
        return '%d %s' % (len(value), type(value[0]).__name__)
    numbers = _np.asarray(value)
    if numbers.size > _SHOWN:
        return '%s array' % 'x'.join(map(str, numbers.shape))
    if numbers.ndim == 0:
        return '%.6g' % value
    return '[%s]' % ', '.join(_text('', item) for item in numbers)


def _repr(value):
    cls = type(value)
    return '%s(%s)' % (cls.__name__, ', '.join('%s=%s' % (name, _text(name, getattr(value, name))) for name in _fields(cls)))


def _restore(cls, fields):
    value = cls()
    for name, field in fields.items():
        setattr(value, name, field)
    return value


def _reduce(value):
    return _restore, (type(value), {name: getattr(value, name) for name in _fields(type(value))})


def _error_attribute(error, name):
    # OpenCV keeps `err` in the class: an error of Python's arguments has that of the error before, or none.
    value = Exception.__getattribute__(error, name)
    return str(error) if name == 'err' and (not value or value not in str(error)) else value


_error.__getattribute__ = _error_attribute

for _cls in _VALUES:
    _copyreg.pickle(_cls, _reduce)   # copy asks there, too
    if hasattr(_bindings, '_setRepr'):
        _bindings._setRepr(_cls, _repr)
    else:
        _cls.__repr__ = _repr
