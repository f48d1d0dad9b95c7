"""Making poses."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kerf import _kerf

MAX_POSES = 10_000_000  # of a line: 560 MB, and nearly three hours at 1000 ticks per second


def _numbers(value: ArrayLike) -> NDArray[np.float64]:
    try:
        return np.asarray(value, dtype=float)
    except (TypeError, ValueError):
        raise _kerf.Error(f"{value!r} is not an array of numbers") from None


def _number(value: float, name: str, least: float, most: float) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        raise _kerf.Error(f"{name} = {value!r} is not a number; valid range {least:g} to {most:g}") from None
    if not least <= number <= most:
        raise _kerf.Error(f"{name} = {number:g} is out of range; valid range {least:g} to {most:g}")
    return number


def pose(position_mm: ArrayLike, axis: ArrayLike = (0, 0, 1), angle_deg: float = 0.0) -> NDArray[np.float64]:
    """Returns a pose: an array of 7 numbers, position x, y, z (mm) and unit quaternion w, x, y, z.

    The frame is turned by angle_deg about `axis`, a direction of any length. A disc lies in the x-y plane of its frame, so
    pose((0, 0, 10), (1, 0, 0), -90) is a saw that stands upright, with its spindle along y.
    """
    p, e = _numbers(position_mm), _numbers(axis)
    length = float(np.linalg.norm(e)) if e.shape == (3,) else 0.0
    if p.shape != (3,) or not math.isfinite(length) or length == 0:
        raise _kerf.Error("a pose needs a position of 3 numbers and an axis of 3 numbers that is not zero")
    if not np.isfinite(p).all():
        raise _kerf.Error(f"position_mm = {p.tolist()} must be finite")
    half = 0.5 * math.radians(_number(angle_deg, "angle_deg", -1e6, 1e6))
    return np.concatenate([p, [math.cos(half)], math.sin(half) * e / length])


def line(start: ArrayLike, end_mm: ArrayLike, feed_mm_per_s: float, dt: float = 0.001) -> NDArray[np.float64]:
    """Returns the poses (n, 7) of a straight motion with the orientation of `start`, one for the end of each tick.

    start: pose of 7 numbers, or a position. end_mm: last position. feed_mm_per_s: speed, 1e-6 to 1e6; the last step may be
    shorter. dt: duration of a tick, 1e-6 to 1 s. The start itself is not among them: it is where the simulation starts.
    Raises kerf.Error; also for more than 10 million poses.
    """
    begin = _numbers(start)
    if begin.shape == (3,):
        begin = pose(begin)
    end = _numbers(end_mm)
    if begin.shape != (7,) or end.shape != (3,):
        raise _kerf.Error("a line needs a pose of 7 or 3 numbers and an end of 3 numbers")
    if not np.isfinite(begin).all() or not np.isfinite(end).all():
        raise _kerf.Error(f"the line from {begin.tolist()} to {end.tolist()} must have finite numbers")
    feed_mm_per_s = _number(feed_mm_per_s, "feed_mm_per_s", 1e-6, 1e6)
    dt = _number(dt, "dt", 1e-6, 1)
    length = float(np.linalg.norm(end - begin[:3]))
    steps = length / (feed_mm_per_s * dt)
    if not steps <= MAX_POSES:
        raise _kerf.Error(f"the line of {length:g} mm has {steps:.3g} poses; at most {MAX_POSES} are possible; raise feed_mm_per_s or dt")
    ticks = max(1, int(np.ceil(steps - 1e-9)))
    share = np.minimum(np.arange(1, ticks + 1) * (feed_mm_per_s * dt / length if length > 0 else 1.0), 1.0)[:, None]
    poses = np.tile(begin, (ticks, 1))
    poses[:, :3] = begin[:3] + share * (end - begin[:3])
    return poses
