"""Tasks for policies, in the shape of Gymnasium's environments (reset, step, spaces), which is not needed to use them.

    env = kerf.envs.DepthControl()
    observation, info = env.reset(seed=1)
    while True:
        observation, reward, terminated, truncated, info = env.step(env.baseline(observation))
        if terminated or truncated:
            break

A disc saw stands upright (spindle along y) on a block of bone whose top is z = 0; x points along the cut, z up. An action
moves the handle, which a spring connects to the saw, for one step of 20 ms (20 ticks). Actions and observations are
arrays of float32. The same seed and actions give the same bits.
"""

from __future__ import annotations

import math
import numbers
import warnings
from typing import Any, Optional

import numpy as np
from numpy.typing import ArrayLike, NDArray

import kerf

Array = NDArray[np.float32]


class Box:
    """A box of arrays, as Gymnasium's Box: low <= x <= high."""

    def __init__(self, low: ArrayLike, high: ArrayLike, seed: Optional[int] = None) -> None:
        self.low = np.asarray(low, dtype=np.float32)
        self.high = np.asarray(high, dtype=np.float32)
        self.shape = self.low.shape
        self.dtype = np.dtype(np.float32)
        self._random = np.random.default_rng(seed)

    def seed(self, seed: Optional[int] = None) -> None:
        self._random = np.random.default_rng(seed)

    def sample(self) -> Array:
        """Returns a uniform random array within the box, or within 1000 where it has no limit."""
        return self._random.uniform(np.maximum(self.low, -1000), np.minimum(self.high, 1000)).astype(np.float32)

    def contains(self, x: Any) -> bool:
        return np.shape(x) == self.shape and bool(np.all(x >= self.low) and np.all(x <= self.high))

    def __repr__(self) -> str:
        return f"Box({self.low.tolist()}, {self.high.tolist()})"


class Task:
    """What the tasks have in common.

    Action (3,): velocity of the handle along x, y and z, each -1 to 1 times 10 mm/s, and limited to it. Observation
    (8,): position of the saw's centre x, y, z (mm), force on the hand x, y, z (N), depth of the blade's edge below
    the surface (mm, negative above it), and one number of the task.
    """

    MAX_SPEED_MM_PER_S = 10.0
    STEP_TICKS = 20
    TICK_S = 0.001
    RPM = 7500.0
    LIMIT_S = 20.0  # an episode is truncated after this time
    DIAMETER_MM = 10.0
    metadata: dict[str, Any] = {"render_modes": []}
    render_mode = None
    spec = None

    action_space = Box([-1] * 3, [1] * 3)
    observation_space = Box([-np.inf] * 8, [np.inf] * 8)

    def __init__(self, voxel_mm: float = 0.25) -> None:
        """voxel_mm: edge of the bone's voxels, 0.02 to 4. Smaller ones are more accurate and slower."""
        given: Any = voxel_mm
        if not isinstance(given, numbers.Real) or not 0.02 <= float(given) <= 4:
            raise kerf.Error(f"voxel_mm = {voxel_mm!r} is not a number in the valid range, 0.02 to 4 mm")
        self.voxel_mm = voxel_mm
        self._random = np.random.default_rng()
        self._simulation: Optional[kerf.HandSimulation] = None

    @property
    def unwrapped(self) -> Task:
        return self

    def close(self) -> None:
        self._simulation = None

    def render(self) -> None:
        """There is no picture: `bone` gives the current bone, whose mesh() can be drawn."""

    @property
    def bone(self) -> kerf.Bone:
        """Copy of the current bone."""
        return self._running().bone()

    def reset(self, *, seed: Optional[int] = None, options: Optional[dict[str, Any]] = None) -> tuple[Array, dict[str, Any]]:
        """Begins an episode; returns the observation and a dict. `options` is not used."""
        if seed is not None:
            self._random = np.random.default_rng(seed)
        bone = self._begin()
        self._handle = kerf.pose(self._start_mm(), (1, 0, 0), -90)
        saw = kerf.Disc(diameter_mm=self.DIAMETER_MM, thickness_mm=0.5)
        self._simulation = kerf.HandSimulation(bone, self._handle, tool=saw, stiffness_N_per_mm=2)
        self._steps = 0
        self._ended = False
        self._last = self._run(self._handle[None])
        return self._observe(), self._info()

    def _run(self, handles: Any) -> Any:
        """Moves the handle. Returns the last tick. Shows no warning: a step is too short to judge a simulation by."""
        simulation = self._running()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)
            return simulation.run(handles, dt=self.TICK_S, rpm=self.RPM, progress=False)[-1]

    def step(self, action: ArrayLike) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Moves the handle for 20 ms. Returns (observation, reward, terminated, truncated, info)."""
        self._running()
        if self._ended:
            raise kerf.Error("the episode has ended; call reset()")
        velocity = np.asarray(action, dtype=float)
        if velocity.shape != (3,) or not np.all(np.isfinite(velocity)):
            raise kerf.Error("an action must have 3 finite numbers")
        velocity = self.MAX_SPEED_MM_PER_S * np.clip(velocity, -1, 1) + self._disturb()
        handles = np.tile(self._handle, (self.STEP_TICKS, 1))
        handles[:, :3] += np.arange(1, self.STEP_TICKS + 1)[:, None] * (self.TICK_S * velocity)
        self._handle = handles[-1]
        self._last = self._run(handles)
        self._steps += 1
        reward, terminated = self._judge()
        truncated = not terminated and self._steps * self.STEP_TICKS * self.TICK_S >= self.LIMIT_S
        self._ended = terminated or truncated
        return self._observe(), float(reward), terminated, truncated, self._info()

    # ---- for the tasks
    def _running(self) -> kerf.HandSimulation:
        if self._simulation is None:
            raise kerf.Error("call reset() before the first step")
        return self._simulation

    def _tool_mm(self) -> NDArray[np.float64]:
        return np.array([self._last["tool_x_mm"], self._last["tool_y_mm"], self._last["tool_z_mm"]])

    def _depth_mm(self) -> float:
        return float(0.5 * self.DIAMETER_MM - self._last["tool_z_mm"])

    def _observe(self) -> Array:
        force = [self._last["hand_x_N"], self._last["hand_y_N"], self._last["hand_z_N"]]
        return np.array([*self._tool_mm(), *force, self._depth_mm(), self._number()], dtype=np.float32)

    def _begin(self) -> kerf.Bone:
        raise NotImplementedError

    def _start_mm(self) -> tuple[float, float, float]:
        raise NotImplementedError

    def _disturb(self) -> NDArray[np.float64]:
        return np.zeros(3)

    def _number(self) -> float:
        raise NotImplementedError

    def _judge(self) -> tuple[float, bool]:
        raise NotImplementedError

    def _info(self) -> dict[str, Any]:
        raise NotImplementedError

    def baseline(self, observation: Array) -> Array:
        """A scripted policy: the action that a simple rule takes."""
        raise NotImplementedError


class DepthControl(Task):
    """Cut a groove of a given depth, 1 to 3 mm, along the block, through a cortex whose thickness varies.

    The last number of the observation is the depth that is wanted, mm. Reward of a step: minus the error of the depth, mm,
    times the way along the cut, mm; a way that is cut without error costs nothing, and each second costs 0.1. The episode
    ends at the end of the groove. info: "depth_error_mm" (mean along the cut, nan before it), "wanted_mm".
    """

    LENGTH_MM = 12.0

    def _begin(self) -> kerf.Bone:
        self._wanted_mm = float(self._random.uniform(1, 3))
        cortex_mm = float(self._random.uniform(1, 3))
        self._errors: list[tuple[float, float]] = []
        self._reached_mm = 0.0
        return kerf.Bone.block(size_mm=(self.LENGTH_MM + 16, 6, 8), layers=[(cortex_mm, 24), (8, 32)], voxel_mm=self.voxel_mm)

    def _start_mm(self) -> tuple[float, float, float]:
        return (-0.5 * self.LENGTH_MM, 0, 0.5 * self.DIAMETER_MM + 0.5)

    def _number(self) -> float:
        return self._wanted_mm

    def _judge(self) -> tuple[float, bool]:
        way_mm = min(float(self._last["tool_x_mm"]) + 0.5 * self.LENGTH_MM, self.LENGTH_MM)
        step_mm = max(0.0, way_mm - self._reached_mm)
        self._reached_mm = max(self._reached_mm, way_mm)
        error_mm = abs(self._depth_mm() - self._wanted_mm)
        self._errors.append((step_mm, error_mm))
        return -error_mm * step_mm - 0.1 * self.STEP_TICKS * self.TICK_S, way_mm >= self.LENGTH_MM

    def _info(self) -> dict[str, Any]:
        way_mm = sum(step for step, _ in self._errors)
        mean = sum(step * error for step, error in self._errors) / way_mm if way_mm > 0 else float("nan")
        return {"depth_error_mm": mean, "wanted_mm": self._wanted_mm}

    def baseline(self, observation: Array) -> Array:
        error_mm = observation[7] - observation[6]
        down = np.clip(2 * error_mm, -1, 1)
        along = 0.5 if abs(error_mm) < 0.1 else 0.0
        return np.array([along, 0, -down], dtype=np.float32)


class StraightOsteotomy(Task):
    """Cut through a bar of 8 x 8 mm, straight, with a hand that drifts to one side and trembles.

    The last number of the observation is the distance of the blade from the planned plane, y, mm. Reward of a step: the
    depth that was gained, mm, minus the distance from the plane, mm, times that depth, minus the sideways force on the
    hand, N, times 0.02. The episode ends when the bar is cut through. info: "aside_mm" (largest), "depth_mm".
    """

    DIAMETER_MM = 22.0
    WIDTH_MM = HEIGHT_MM = 8.0

    def _begin(self) -> kerf.Bone:
        self._drift_mm_per_s = float(self._random.uniform(-0.5, 0.5))
        self._deepest_mm = self._aside_mm = 0.0
        return kerf.Bone.block(size_mm=(self.WIDTH_MM, 16, self.HEIGHT_MM), layers=[(2, 24), (4, 32), (2, 24)], voxel_mm=self.voxel_mm)

    def _start_mm(self) -> tuple[float, float, float]:
        return (0, float(self._random.uniform(-0.5, 0.5)), 0.5 * self.DIAMETER_MM + 1)

    def _disturb(self) -> NDArray[np.float64]:
        return np.array([0, self._drift_mm_per_s + self._random.normal(0, 0.5), 0])

    def _number(self) -> float:
        return float(self._last["tool_y_mm"])

    def _judge(self) -> tuple[float, bool]:
        # The disc is wider than the bar, whose lower corners are the last to be cut.
        radius_mm = 0.5 * self.DIAMETER_MM
        through_mm = self.HEIGHT_MM + radius_mm - math.sqrt(radius_mm**2 - (0.5 * self.WIDTH_MM)**2) + 0.2
        gained_mm = max(0.0, min(self._depth_mm(), through_mm) - self._deepest_mm)
        self._deepest_mm += gained_mm
        aside_mm = abs(float(self._last["tool_y_mm"]))
        if self._deepest_mm > 0:
            self._aside_mm = max(self._aside_mm, aside_mm)
        reward = gained_mm - aside_mm * gained_mm - 0.02 * abs(float(self._last["hand_y_N"]))
        return reward, self._deepest_mm >= through_mm

    def _info(self) -> dict[str, Any]:
        return {"aside_mm": self._aside_mm, "depth_mm": self._deepest_mm}

    def baseline(self, observation: Array) -> Array:
        aside_mm = observation[7]
        aligned = abs(aside_mm) < 0.1 or observation[6] > 0
        return np.array([0, np.clip(-0.5 * aside_mm, -1, 1), -0.3 if aligned else 0], dtype=np.float32)


class StayOffNerve(Task):
    """Cut as deep as possible above a nerve canal, at a depth of 4 to 7 mm, and leave at least 1 mm of bone.

    The last number of the observation is the distance of the blade's edge from the canal, mm, measured with an error of
    0.2 mm (standard deviation). Reward of a step: the depth that was gained, mm, up to 1 mm above the canal, minus ten times
    the depth gained below that. Cutting the canal costs 20 and ends the episode; so does lifting the saw out of the bone
    after the cut, without a cost. info: "left_mm" (bone above the canal, from the deepest point), "canal_cut_mm3".
    """

    CANAL_MM = 3.0
    MARGIN_MM = 1.0

    def _begin(self) -> kerf.Bone:
        self._canal_mm = float(self._random.uniform(4, 7))
        self._deepest_mm = 0.0
        self._cut_mm3 = 0.0
        spacing = 0.5
        x, y, z = (spacing * np.arange(n) for n in (40, 17, 25))
        labels = np.ones((len(x), len(y), len(z)), dtype=np.uint8)
        top = z[-1] + 0.5 * spacing
        labels[:, :, z > top - 2] = 2
        canal = np.hypot(y[:, None] - y.mean(), z[None] - (top - self._canal_mm - 0.5 * self.CANAL_MM)) < 0.5 * self.CANAL_MM
        labels[:, canal] = 3
        pose = (-x.mean(), -y.mean(), -top)
        return kerf.Bone.from_labels(labels, {1: 32, 2: 24, 3: 34}, self.voxel_mm, (spacing,) * 3, pose)

    def _start_mm(self) -> tuple[float, float, float]:
        return (0, 0, 0.5 * self.DIAMETER_MM + 0.5)

    def _number(self) -> float:
        return self._canal_mm - self._depth_mm() + float(self._random.normal(0, 0.2))

    def _judge(self) -> tuple[float, bool]:
        allowed_mm = self._canal_mm - self.MARGIN_MM
        before_mm = self._deepest_mm
        self._deepest_mm = max(before_mm, self._depth_mm())
        good_mm = min(self._deepest_mm, allowed_mm) - min(before_mm, allowed_mm)
        bad_mm = max(self._deepest_mm, allowed_mm) - max(before_mm, allowed_mm)
        self._cut_mm3 = self._running().removed_by_region_mm3().get(34, 0.0)
        if self._cut_mm3 > 0:
            return good_mm - 10 * bad_mm - 20, True
        return good_mm - 10 * bad_mm, self._deepest_mm > 0.5 and self._depth_mm() < -0.5

    def _info(self) -> dict[str, Any]:
        return {"left_mm": self._canal_mm - self._deepest_mm, "canal_cut_mm3": self._cut_mm3}

    def reset(self, *, seed: Optional[int] = None, options: Optional[dict[str, Any]] = None) -> tuple[Array, dict[str, Any]]:
        self._distance_mm: Optional[float] = None
        self._leaving = False
        return super().reset(seed=seed, options=options)

    def baseline(self, observation: Array) -> Array:
        """Smooths the measured distance, goes down until it is 1.3 mm, then lifts the saw."""
        measured = float(observation[7]) + float(observation[6])  # of the canal from the surface
        before = self._distance_mm
        self._distance_mm = measured if before is None else before + 0.05 * (measured - before)
        left_mm = self._distance_mm - float(observation[6])
        self._leaving = self._leaving or left_mm < self.MARGIN_MM + 0.3
        return np.array([0, 0, 1.0 if self._leaving else -0.15], dtype=np.float32)


TASKS = {"depth_control": DepthControl, "straight_osteotomy": StraightOsteotomy, "stay_off_nerve": StayOffNerve}


def make(name: str, **options: Any) -> Task:
    """Returns the task of that name: depth_control, straight_osteotomy or stay_off_nerve."""
    if name not in TASKS:
        raise kerf.Error(f"there is no task '{name}'; the tasks are {', '.join(TASKS)}")
    return TASKS[name](**options)


def play(task: Task, policy: Any = None, seed: Optional[int] = None) -> tuple[float, dict[str, Any]]:
    """Plays an episode; returns the sum of the rewards and the last info. policy: function of the observation; None: the baseline."""
    observation, info = task.reset(seed=seed)
    total = 0.0
    while True:
        observation, reward, terminated, truncated, info = task.step((policy or task.baseline)(observation))
        total += reward
        if terminated or truncated:
            return total, info
