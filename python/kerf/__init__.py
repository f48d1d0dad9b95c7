"""Cutting bone with a saw: bones, scenes, simulations, recordings and studies (docs/python.md).

Lengths are in mm, forces in N, torques in N mm, times in s, moduli in MPa, energies in mJ. A pose is an array of 7
numbers, position x, y, z and unit quaternion w, x, y, z, unless stated otherwise; 3 numbers (a position) and matrices of
4 x 4 are accepted too.
"""

import copyreg as _copyreg
import typing as _typing

from kerf import _kerf
from kerf._data import to_frame as to_frame
from kerf._kerf import *  # also a class for each kind of tool
from kerf._kerf import __version__ as __version__
from kerf._poses import line as line, pose as pose
from kerf._program import compare as compare, score as score, stability as stability, study as study

__all__ = sorted([*(_name for _name in vars(_kerf) if not _name.startswith("_")), "__version__", "compare", "line", "pose",
                  "score", "stability", "study", "to_frame"])


def _reduce(self: _typing.Any) -> tuple[_typing.Any, ...]:
    """Pickles by __getstate__ with every protocol: protocols 0 and 1 would call pybind11's base class, which ends the
    interpreter."""
    if type(self).__getstate__ is getattr(object, "__getstate__"):
        raise TypeError(f"cannot pickle '{type(self).__module__}.{type(self).__name__}' object")
    return getattr(_copyreg, "__newobj__"), (type(self),), self.__getstate__()


for _name in __all__:  # the classes of the compiled part are known by the names of the package
    _object = getattr(_kerf, _name, None)
    if isinstance(_object, type):
        _object.__module__ = "kerf"
        if not issubclass(_object, BaseException) and "__reduce__" not in vars(_object):
            setattr(_object, "__reduce__", _reduce)
del _name, _object
