"""Making poses."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kerf import _kerf


def _numbers(value: ArrayLike) -> NDArray[np.float64]:
    try:
        return np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise _kerf.Error(f"{value!r} is not an array of numbers") from None


def pose(position_mm: ArrayLike, axis: ArrayLike = (0, 0, 1), angle_deg: float = 0.0) -> NDArray[np.float64]:
    """Returns a pose: an array of 7 numbers, position x, y, z (mm) and unit quaternion w, x, y, z.

    The frame is turned by angle_deg about `axis`, a direction of any length. A disc lies in the x-y plane of its frame, so
    pose((0, 0, 10), (1, 0, 0), -90) is a saw that stands upright, with its spindle along y.
    """
    p, e = _numbers(position_mm), _numbers(axis)
    length = float(np.linalg.norm(e)) if e.shape == (3,) else 0.0
    if p.shape != (3,) or not math.isfinite(length) or length == 0:
        raise _kerf.Error("a pose needs a position of 3 numbers and an axis of 3 numbers that is not zero")
    half = 0.5 * math.radians(angle_deg)
    return np.concatenate([p, [math.cos(half)], math.sin(half) * e / length])


def line(start: ArrayLike, end_mm: ArrayLike, feed_mm_per_s: float, dt: float = 0.001) -> NDArray[np.float64]:
    """Returns the poses (n, 7) of a straight motion with the orientation of `start`, one for the end of each tick.

    start: pose of 7 numbers, or a position. end_mm: last position. feed_mm_per_s: speed, above 0; the last step may be
    shorter. dt: duration of a tick, s. The start itself is not among them: it is where the simulation starts.
    """
    begin = _numbers(start)
    if begin.shape == (3,):
        begin = pose(begin)
    end = _numbers(end_mm)
    if begin.shape != (7,) or end.shape != (3,):
        raise _kerf.Error("a line needs a pose of 7 or 3 numbers and an end of 3 numbers")
    if not feed_mm_per_s > 0 or not dt > 0:
        raise _kerf.Error("feed_mm_per_s and dt must be above 0")
    length = float(np.linalg.norm(end - begin[:3]))
    ticks = max(1, int(np.ceil(length / (feed_mm_per_s * dt) - 1e-9)))
    share = np.minimum(np.arange(1, ticks + 1) * (feed_mm_per_s * dt / length if length > 0 else 1.0), 1.0)[:, None]
    poses = np.tile(begin, (ticks, 1))
    poses[:, :3] = begin[:3] + share * (end - begin[:3])
    return poses
