"""Cutting bone with a saw: bones, scenes, simulations, recordings and studies (docs/python.md).

Lengths are in mm, forces in N, torques in N mm, times in s, moduli in MPa, energies in mJ. A pose is an array of 7
numbers, position x, y, z and unit quaternion w, x, y, z, unless stated otherwise; 3 numbers (a position) and matrices of
4 x 4 are accepted too.
"""

import copyreg as _copyreg
import typing as _typing

from kerf import _kerf
from kerf._data import to_frame
from kerf._kerf import (Ball, Bone, Disc, Error, HandSimulation, HandTick, Materials, Recording, Region, Run, Scene, Simulation,
                        SlabSimulation, Tick, __version__, commit, effects, force_laws, run, run_in_hand)
from kerf._poses import line, pose
from kerf._program import compare, score, stability, study

__all__ = ["Ball", "Bone", "Disc", "Error", "HandSimulation", "HandTick", "Materials", "Recording", "Region", "Run", "Scene",
           "Simulation", "SlabSimulation", "Tick", "__version__", "commit", "compare", "effects", "force_laws", "line", "pose",
           "run", "run_in_hand", "score", "stability", "study", "to_frame"]


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
