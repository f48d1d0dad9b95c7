#!/usr/bin/python3
"""Recomputes what kerf computes from closed forms, brute force and single teeth, and compares both in one table.

    PYTHONPATH=build/release/python KERF_PROGRAM=build/release/kerf tests/recompute/recompute.py [GROUP ...]
    tests/recompute/recompute.py --figure docs/images/stroke_rate.png     # needs matplotlib

Uses kerf only by its Python module and its program; everything in the column "expected" is computed here. Exit code 1
if a row is out of its bound, 77 (skipped) if NumPy or the module is missing.
"""

import argparse
import csv
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import warnings

try:
    import numpy as np

    import kerf
except ModuleNotFoundError as missing:
    print(f"skipped: {missing}; install python3-numpy, and set PYTHONPATH to kerf's Python module")
    sys.exit(77)

warnings.simplefilter("ignore")  # of kerf: about coarse voxels and bites outside the laws' measurements
KERF = os.environ.get("KERF_PROGRAM", "kerf")
PI = math.pi
UPRIGHT = ((1, 0, 0), -90)  # the spindle points along y, the disc lies in the x-z plane
GROUP = ""
rows = []


def row(quantity, got, expected, bound, basis):
    """Adds a row. The difference is relative to the expected value; of vectors the lengths are printed."""
    got, expected = np.atleast_1d(got), np.atleast_1d(expected)
    size = np.linalg.norm(expected)
    difference = np.linalg.norm(got - expected) / size
    rows.append(difference <= bound)
    print(f"{GROUP:12} {quantity:68} {np.linalg.norm(got):11.6g} {size:11.6g} {100 * difference:9.2g} % {100 * bound:8.2g} % "
          f"{'   ' if rows[-1] else 'OUT'} {basis}", flush=True)


# ---- what a tooth of steel feels in bone, from docs/physics.md

REGIONS = {24: (19300, 0.28, 1), 21: (20500, 0.25, 1), 13: (19300, 0.25, 1), 6: (17300, 0.38, 1), 32: (1370, 0.3, 0.25)}


def hertz(depth, radius, region=24):
    """Hertz's sphere on a half space, at a depth of a^2 / radius."""
    E, nu, _ = REGIONS[region]
    E_star = 1 / ((1 - 0.28**2) / 205000 + (1 - nu**2) / E)
    return 4 / 3 * E_star * np.sqrt(radius) * np.maximum(depth, 0) ** 1.5


def two_component(bite, width, region=24, edge=9.66, chip=468.0):
    bite = np.maximum(bite, 0)
    return REGIONS[region][2] * width * (edge * np.minimum(1, bite / 0.002) + chip * bite)


def cutting(bite, width, region=24):
    return two_component(bite, width, region, 6.83, 166)


# ---- volumes

def block(voxel=0.1, size=(20, 8, 10), **more):
    return kerf.Bone.block(size_mm=size, voxel_mm=voxel, **more)


def cut(bone, tool, poses, rpm=7500, dt=0.01):
    """Moves a tool along poses and returns the volume that is gone."""
    simulation = kerf.Simulation(bone, poses[0], tool=tool)
    simulation.run(np.array(poses[1:]), dt=dt, rpm=rpm)
    return bone.volume_mm3() - simulation.bone().volume_mm3()


def straight(start, end, frame, steps=300):
    return [kerf.pose(np.asarray(start) + (np.asarray(end) - start) * i / steps, *frame) for i in range(steps + 1)]


def segment(R, depth):
    return R * R * math.acos(1 - depth / R) - (R - depth) * math.sqrt(depth * (2 * R - depth))


def spread(n, low, high):
    """Returns n points evenly spread in a box (additive recurrence)."""
    step = 1.22074408460575947536 ** -np.arange(1.0, 4.0)
    return low + (0.5 + np.arange(n)[:, None] * step) % 1 * (np.subtract(high, low))


def volumes():
    said = "docs/physics.md: below 1 % in each pose"
    disc = kerf.Disc(thickness_mm=0.5)
    R, w = 11, 0.5
    check = lambda *values: row(*values, 0.01, said)
    through = lambda z: straight((-24, 0, z), (24, 0, z), UPRIGHT)
    check("disc, slot 3 mm deep (mm3)", cut(block(), disc, through(8)), 20 * 3 * w)
    check("disc, slot 7 mm deep", cut(block(), disc, through(4)), 20 * 7 * w)
    check("disc, plunge 3 mm deep", cut(block(), disc, straight((0, 0, 12), (0, 0, 8), UPRIGHT)), segment(R, 3) * w)
    # The block stands oblique to the grid, and the disc is tilted by 30 degrees to the block's top.
    c, s = math.cos(PI / 12), math.sin(PI / 12)
    turned = np.array([c, s * 2 / 7, s * 3 / 7, s * 6 / 7])
    tilted = [np.concatenate([rotate(turned, p[:3]), multiply(turned, p[3:])])
              for p in straight((-24, -4.8, 7), (24, -4.8, 7), ((1, 0, 0), -60))]
    check("disc, oblique in a turned block", cut(block(rotation=turned), disc, tilted),
          20 * w * (R - 7 / math.cos(PI / 6)))
    # The disc turns by 20 degrees about its horizontal diameter, 8 mm above the block.
    turning = [kerf.pose((0, 0, 8), (1, 0, 0), -90 + 20 * i / 400) for i in range(401)]
    p = spread(400000, (-8, -1, -3.2), (8, 4, 0))
    angle = np.arctan2(p[:, 1], 8 - p[:, 2])
    r = np.hypot(p[:, 1], 8 - p[:, 2])
    from_sweep = r * np.sin(np.maximum(np.maximum(-angle, angle - PI / 9), 0))
    inside = (from_sweep <= w / 2) & (np.hypot(p[:, 0], r) <= R)
    check("disc, turning by 20 degrees about its diameter", cut(block(), disc, turning),
          inside.mean() * 16 * 5 * 3.2)
    check("disc, through a plate of 2 mm", cut(block(size=(20, 8, 2)), disc, straight((0, 0, 12), (0, 0, 7), UPRIGHT)),
          (segment(R, 4) - segment(R, 2)) * w)
    check("disc, half over the block's end", cut(block(), disc, straight((10, 0, 12), (10, 0, 8), UPRIGHT)),
          segment(R, 3) * w / 2)
    check("ball, groove 2 mm deep", cut(block(), kerf.Ball(diameter_mm=6), straight((-14, 0, 1), (14, 0, 1), ((0, 0, 1), 0))),
          20 * segment(3, 2))
    bur = kerf.Bur(diameter_mm=2.1, length_mm=8, point_angle_deg=120)
    check("bur, groove 4 mm deep", cut(block(), bur, straight((-12, 0, -4), (12, 0, -4), ((0, 0, 1), 0)), -20000),
          20 * (2.1 * 4 - 1.05**2 / math.tan(PI / 3)))
    drill = kerf.Drill(diameter_mm=2)
    check("drill, hole 8 mm deep", cut(block(), drill, straight((0, 0, 0.5), (0, 0, -8), ((0, 0, 1), 0)), -1000),
          PI * (8 - 2 / 3 / math.tan(math.radians(59))))
    # Blades plunge, then stay for a whole stroke, so that every phase has been at the bottom.
    plunge = lambda depth: [np.array([0, 0, 0.5 - (0.5 + depth) * min(1, i / 4000), *DOWN]) for i in range(4201)]
    blade = dict(dt=0.001, rpm=1370)
    swing = kerf.OscillatingBlade()
    half = 25 * math.sin(math.asin(4.5 / 25) + math.radians(2.5))
    y = (np.arange(20000) + 0.5) / 20000 * half
    check("oscillating, slot 4 mm deep", cut(block(), swing, plunge(4), **blade),
          0.5 * 2 * half * (4 - 25 + np.sqrt(625 - y * y)).mean())
    saw = kerf.ReciprocatingBlade(length_mm=12)
    check("reciprocating, slot 4 mm deep", cut(block(), saw, plunge(4), **blade), 0.5 * (12 + 3) * 4)
    check("piezo, slot 4 mm deep", cut(block(), kerf.PiezoInsert(), plunge(4), dt=0.001, rpm=1680000), 0.5 * 4.12 * 4)


def multiply(a, b):
    return np.array([a[0] * b[0] - np.dot(a[1:], b[1:]), *(a[0] * np.array(b[1:]) + b[0] * np.array(a[1:]) +
                                                         np.cross(a[1:], b[1:]))])


def rotate(q, p):
    return multiply(multiply(q, [0, *p]), [q[0], *-np.array(q[1:])])[1:]


# ---- forces: single teeth of a disc at many moments of a turn

TEETH, R, W, PASSES = 24, 11.0, 0.25, 24 * 7500 / 60


def teeth_sum(centre, velocity, in_bone, law, drag=None):
    """Returns means over a pitch of the force on the disc, the torque about its grip, engaged teeth and cutting power.

    A tooth bites what lies between its place and the rim where the tooth before passed: the disc was there 1 / PASSES
    earlier. in_bone(x, z) gives the region, or 0. drag: whether the cutting force acts too; None: if the law states one.
    """
    drag = law == "two_component" if drag is None else drag
    turn = (np.arange(1000) + 0.5) / 1000 * 2 * PI / TEETH
    angle = (turn[:, None] + np.arange(TEETH) * 2 * PI / TEETH).ravel()
    e = np.stack([np.cos(angle), np.sin(angle)])  # x, z
    back = np.asarray(velocity)[:, None] / PASSES
    bite = np.hypot(*(R * e + back)) - R
    region = in_bone(centre[0] + R * e[0], centre[1] + R * e[1])
    engaged = (bite > 0) & (region > 0)
    thrust, along = np.zeros_like(bite), np.zeros_like(bite)
    for r in set(region[engaged]):
        here = engaged & (region == r)
        thrust[here] = hertz(bite[here], R, r) if law == "hertz_chip" else two_component(bite[here], W, r)
        along[here] = cutting(bite[here], W, r)
    n = len(turn)
    # The spindle points along y, about which the disc turns from z to x; the cutting force acts against that.
    motion = np.stack([e[1], -e[0]])
    if not drag:
        along = 0 * along
    force = (-thrust * e - along * motion).sum(axis=1) / n
    # The grip is 80 mm along the spindle, so that the arm of the force is -80 mm along y.
    return {"force_N": np.array([force[0], 0, force[1]]),
            "torque_Nmm": np.array([-80 * force[1], -R * along.sum() / n, 80 * force[0]]), "torque_y_Nmm": -R * along.sum() / n,
            "engaged_teeth": engaged.sum() / n, "cutting_W": along.sum() / n * 2 * PI * R * 125 / 1000}


def forces():
    feed = 3
    layers = [(2.45, 24), (7.5, 32)]  # a border in the middle between voxels; elsewhere it lies up to half a voxel off
    layered = lambda x, z: np.where((z >= 0) | (abs(x) > 10), 0, np.where(z > -2.45, 24, 32))
    plain = lambda x, z: np.where((z < 0) & (abs(x) < 10), 24, 0)
    plate = lambda x, z: np.where((z < 0) & (z > -2), 24, 0)
    cases = [  # name, start, end, bone, region at a place, stretch of which the mean is taken
        ("slot 3 mm deep", (-20, 8), (8, 8), block(), plain, (-6, 0)),
        ("slot 7 mm deep", (-22, 4), (8, 4), block(), plain, (-6, 0)),
        ("half immersed in two tissues", (-24, 0), (2, 0), block(size=(20, 8, 14), layers=layers), layered, (-5, -3)),
        ("into the block's end", (-20, 8), (0, 8), block(), plain, (-14.5, -13.5)),
        ("entry, 1 to 2 mm deep", (0, 12), (0, 8.5), block(), plain, (9, 10)),
        ("breakthrough of a plate", (0, 12), (0, 6), block(size=(26, 8, 2)), plate, (7, 8)),
    ]
    half = "half of one of the 16 samples of the rim a pitch in the other tissue"
    slot = 0.0057, "docs/physics.md: at most 0.57 % in a slot"
    for name, start, end, bone, region, (low, high) in cases:
        bound = {"hertz_chip": slot, "two_component": slot}
        if "tissues" in name:  # the rim does not move across the border, so that the error of a sample does not average out
            bound = {"hertz_chip": (0.029, half), "two_component": (0.013, half)}
        for law in bound:
            first = kerf.pose((start[0], 0, start[1]), *UPRIGHT)
            simulation = kerf.Simulation(bone, first, tool=kerf.Disc(), law=law,
                                         effects=[] if law == "hertz_chip" else ["tangential_force"])
            ticks = simulation.run(kerf.line(first, (end[0], 0, end[1]), feed))
            at = ticks["x_mm" if start[0] != end[0] else "z_mm"]
            ticks = ticks[(at > low) & (at < high)]
            velocity = np.sign(np.subtract(end, start)) * feed
            places = list(zip(ticks["x_mm"], ticks["z_mm"]))[::max(1, len(ticks) // 40)]
            sums = [teeth_sum(place, velocity, region, law) for place in places]
            for key in sums[0]:
                if law == "two_component" or key == "force_N":
                    columns = {"force_N": ["force_x_N", "force_y_N", "force_z_N"],
                               "torque_Nmm": ["torque_x_Nmm", "torque_y_Nmm", "torque_z_Nmm"]}.get(key, [key])
                    row(f"disc, {name}, {law}: {key}", [ticks[c].mean() for c in columns],
                        np.mean([one[key] for one in sums], axis=0), *(slot if key == "engaged_teeth" else bound[law]))
    # Each of the two lips of a drill bites half the feed of a turn, times the sine of half the point angle.
    first = kerf.pose((0, 0, 0.5))
    drill = kerf.Drill(diameter_mm=2)
    simulation = kerf.Simulation(block(), first, tool=drill, law="two_component", effects=[])
    ticks = simulation.run(kerf.line(first, (0, 0, -5), 1), rpm=-1000)
    sine = math.sin(math.radians(59))
    row("drill, 1 mm/s: force_N", ticks["force_z_N"][4500:].mean(),
        2 / 0.5 * two_component(60 / 1000 / 2 * sine, 0.5) / (1 - drill.chisel_share), 0.0057, "as for a disc")
    # Blades on a path: each tooth bites what the teeth before have left of the floor while the feed is steady.
    for name, tool, rpm, radius, width, *blade in (
            ("reciprocating", kerf.ReciprocatingBlade(), 15000, 15, 0.4, 1.41, 3, 0, 6),
            ("oscillating", kerf.OscillatingBlade(width_mm=16), 15000, 25, 0.4, 1, math.radians(5) * 25, 25, 6),
            ("piezo", kerf.PiezoInsert(), 1680000, 2, 0.5, 0.8, 0.12, 0, 4)):
        for law in ("hertz_chip", "two_component"):
            first = np.array([0, 0, 0.5, *DOWN])
            simulation = kerf.Simulation(block(size=(6, 3, 6)), first, tool=tool, law=law, effects=[])
            ticks = simulation.run(kerf.line(first, (0, 0, -2), 1), rpm=rpm)[-1000:]
            row(f"{name}, 1 mm/s, {law}: force_N", ticks["force_z_N"].mean(),
                steady_feed(*blade, 60 / rpm, tooth(law, radius, width)), 0.005, "docs/physics.md: 0.5 %")


# ---- blades with a stroke: single teeth, and the floor that each has left

DOWN = (0.5, -0.5, 0.5, 0.5)  # the teeth of a blade face down, its plane is x-z
CELLS = 47  # of a pitch: all teeth come to their next cells at the same moment


def tooth(law, radius, width):
    return (lambda bite: hertz(bite, radius)) if law == "hertz_chip" else (lambda bite: two_component(bite, width))


def walk(pitch, stroke, swing, length, periods, steps=4000):
    """Yields, each time that the teeth of a row come to other cells of the floor of a block: the time in periods, the
    cells of the teeth in the block and their cosines to the feed. The row is carried by a cell in each period."""
    cell = pitch / CELLS
    reach = swing * math.asin(length / 2 / swing) if swing else length / 2  # along the arc
    teeth = np.arange(-math.ceil((reach + stroke) / pitch) - 1, math.ceil((reach + stroke) / pitch) + 2) * CELLS
    before = None
    for i in range(periods * steps):
        at = math.floor((stroke / 2 * math.sin(2 * PI * i / steps) + reach) / cell + i / steps)
        if at == before:
            continue
        before = at
        cells = teeth + at
        cells = cells[(cells >= 0) & (cells < cells_in(pitch, swing, length))]
        along = (cells + 0.5) * cell - reach
        yield i / steps, cells, np.cos(along / swing) if swing else np.ones(len(cells))


def steady_push(pitch, stroke, swing, length, laws, settle=15):
    """Returns how far the floor sinks in a period, for each push of {force of a tooth: pushes}. The blade has no mass: it
    is always where its teeth carry the push."""
    push = np.concatenate([np.asarray(pushes, float) for pushes in laws.values()])
    ends = np.cumsum([len(pushes) for pushes in laws.values()])[:-1]
    floor = np.zeros((len(push), cells_in(pitch, swing, length)))
    z = np.zeros(len(push))
    began = None
    for when, cells, cosine in walk(pitch, stroke, swing, length, settle + CELLS):
        if when >= settle and began is None:
            began = floor.mean(axis=1)
        found = floor[:, cells]
        low, high = z - 0.02, z + 0.02
        for _ in range(20):
            z = (low + high) / 2
            bites = cosine * (z[:, None] - found)
            carried = np.concatenate([law(some) for law, some in zip(laws, np.split(bites, ends))])
            carried = (carried * cosine).sum(axis=1)
            low, high = np.where(carried < push, z, low), np.where(carried < push, high, z)
        floor[:, cells] = np.maximum(found, z[:, None])
    return (floor.mean(axis=1) - began) / CELLS


def cells_in(pitch, swing, length):
    """Returns the number of cells of the floor across a block."""
    return round((2 * swing * math.asin(length / 2 / swing) if swing else length) / (pitch / CELLS))


def since_passed(pitch, stroke, moments=720, grid=20000):
    """Returns how long ago, in periods, a tooth was last where one is now, at moments of a period: by brute force over
    the earlier places of all teeth."""
    way = stroke / 2 * np.sin(2 * PI * np.arange(2 * grid) / grid)
    found = []
    for now in grid + (np.arange(moments) + 0.5) * grid // moments:
        teeth_on = np.floor((way[int(now)] - way[int(now) - 1:int(now) - grid:-1]) / pitch)
        found.append(0.5 + np.argmax(teeth_on != teeth_on[0]))
    return np.array(found) / grid


def steady_feed(pitch, stroke, swing, length, period_s, law, feed=1.0):
    """Returns the mean force of a blade with a steady feed: each tooth bites the feed since its place was last passed."""
    cell = pitch / CELLS
    at = (np.arange(cells_in(pitch, swing, length) * 2) / 2 + 0.25) * cell
    cosine = np.cos((at - at.mean()) / swing)[:, None] if swing else np.ones((len(at), 1))
    bites = cosine * feed * period_s * since_passed(pitch, stroke)
    return (cosine * law(bites)).mean() * len(at) / 2 / CELLS


def hand(bone, tool, law, start, push, ticks, dt, rpm):
    """Returns the heights of a tool on which a constant push acts downwards: the coupling is at its limit of force."""
    simulation = kerf.HandSimulation(bone, start, tool=tool, law=law, effects=[], max_force_N=push, stiffness_N_per_mm=push)
    below = np.array([*start[:2], -50, *start[3:]])
    return simulation.run(np.tile(below, (ticks, 1)), dt=dt, rpm=rpm)["tool_z_mm"]


def hand_rate(tool, law, push, rate, hz):
    """Returns the rate at which a blade sinks, mm/s, over whole periods."""
    per_period = 60 / rate * hz
    n = round(math.ceil(0.2 * hz / per_period) * per_period)
    z = hand(block(size=(12, 3, 6)), tool, law, np.array([0, 0, -1, *DOWN]), push, 2 * n, 1 / hz, rate)
    return (z[n - 1] - z[-1]) * hz / n


def strokes():
    for name, tool, *blade in (("reciprocating", kerf.ReciprocatingBlade(), 1.41, 3, 0),
                               ("oscillating", kerf.OscillatingBlade(width_mm=16), 1, math.radians(5) * 25, 25)):
        cases = [(law, push) for law in ("hertz_chip", "two_component") for push in (3, 7, 20)]
        depths = steady_push(*blade, 12, {tooth(law, blade[2] or 15, 0.4): (3, 7, 20) for law in ("hertz_chip", "two_component")})
        for (law, push), depth in zip(cases, depths):
            rates = [(hand_rate(tool, law, push, rate, hz), depth * rate / 60, f"{rate}/min, {hz // 1000} kHz")
                     for rate in (5000, 12000, 20000) for hz in (1000, 2000, 4000)]
            worst = max(rates, key=lambda one: abs(one[0] / one[1] - 1))
            row(f"{name}, {law}, {push} N: mm/s, worst of {len(rates)}: {worst[2]}", *worst[:2], 0.03,
                "tests/cut/hand_sim/stroke_rate_test.cpp: 3 %")


def earlier_rate(pitch, stroke, length, law, push, rate, hz):
    """Returns the rate by the rule before 4990ce89: the bite was the feed of a tick times the mean time since the place
    was last passed, and so the feed of each tick that at which this bite carries the push."""
    low, high = 0.0, 0.1
    for _ in range(50):
        bite = (low + high) / 2
        low, high = (bite, high) if law(np.array([bite])).sum() * length / pitch < push else (low, bite)
    dt = since_passed(pitch, stroke, 7200)
    until = np.concatenate([[0], np.cumsum(dt)]) / 7200
    turns = np.arange(4001) * rate / 60 / hz
    means = np.diff(np.floor(turns) * until[-1] + np.interp(turns % 1, np.arange(7201) / 7200, until)) / (rate / 60 / hz)
    return np.mean(bite / (means * 60 / rate))


def draw(path):
    """Draws the removal rate of a blade in a hand against the rate of its strokes and against the push."""
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    law, length, blade, saw = tooth("two_component", 15, 0.4), 12, (1.41, 3, 0), kerf.ReciprocatingBlade()
    area = length * 0.5  # mm2: 12 mm of a kerf 0.5 mm wide
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.6))
    fixed_N, fixed_rate = 7, 15000
    rates, pushes = np.arange(2000, 24001, 2000), np.array([1, 2, 3, 5, 7, 10, 13, 16, 20])
    depths = steady_push(*blade, length, {law: (fixed_N, *pushes)})
    for axes, x, cases, teeth_rate in ((left, rates, [(fixed_N, r) for r in rates], depths[0] * rates / 60),
                                       (right, pushes, [(p, fixed_rate) for p in pushes], depths[1:] * fixed_rate / 60)):
        for hz, style in ((4000, "--"), (1000, ":")):
            axes.plot(x, [area * earlier_rate(*blade[:2], length, law, p, r, hz) for p, r in cases], style, color="tab:red",
                      label=f"kerf before, {hz // 1000} kHz")
        axes.plot(x, area * teeth_rate, color="0.3", label="single teeth and their floor")
        for hz, marker in ((1000, "o"), (4000, "x")):
            axes.plot(x, [area * hand_rate(saw, "two_component", p, r, hz) for p, r in cases], marker, color="tab:blue",
                      fillstyle="none", markersize=8, label=f"kerf now, {hz // 1000} kHz")
        axes.set(ylabel="removal rate (mm$^3$/s)", xlim=(0, None), ylim=(0, None))
        axes.grid(alpha=0.3)
    left.set(xlabel="double strokes a minute", title=f"push {fixed_N} N")
    right.set(xlabel="push (N)", title=f"{fixed_rate} double strokes a minute")
    left.legend()
    figure.suptitle("Reciprocating blade in a hand, law two_component, cut 12 mm long and 0.5 mm wide")
    figure.tight_layout()
    figure.savefig(path, dpi=110)


def disc_in_hand():
    for law in ("hertz_chip", "two_component"):
        # The feed at a depth is that at which single teeth carry the push.
        def feed(depth, push=5.0):
            low, high = 0.0, 500.0
            for _ in range(40):
                v = (low + high) / 2
                carried = teeth_sum((0, R - depth), (0, -v), lambda x, z: np.where(z < 0, 24, 0), law, False)["force_N"][2]
                low, high = (v, high) if carried < push else (low, v)
            return v
        depths = 1 + 2 * (np.arange(20) + 0.5) / 20
        expected = 2 / sum(2 / 20 / feed(d) for d in depths)
        for hz in (1000, 2000, 4000):
            for voxel in (0.1, 0.2):
                z = hand(block(voxel), kerf.Disc(), law, kerf.pose((0, 0, 11.2), *UPRIGHT), 5, hz * 4, 1 / hz, 7500)
                at = [np.interp(d, R - z, np.arange(len(z)) / hz) for d in (1, 3)]
                row(f"{law}, 5 N, {hz / 1000:g} kHz, {voxel} mm voxels: rate (mm/s)", 2 / (at[1] - at[0]), expected, 0.001,
                    "docs/accuracy.md: 0.07 % on a plunge in a hand")


# ---- the paper, the slab and the comparison

def tooth_of_paper(depth):
    """Returns the paper's force of a tooth in the region at a depth."""
    region = np.select([depth < 7.5, depth < 17.5, depth < 20], [24, 21, 13], 6)
    a = 0.01 * PI * 22 / 24
    return np.sum([np.where(region == r, hertz(a * a / 11, 11, r), 0) for r in (24, 21, 13, 6)], axis=0)


PRINTED = {24: (0.05541, 0.44325, 0.44325, 1.49595, 1.49595, 3.54596), 21: (0.05763, 0.46107, 0.46107, 1.55610, 1.55610, 3.68854),
           13: (0.05455, 0.43637, 0.43637, 1.47273, 1.47273, 3.49092), 6: (0.05365, 0.42924, 0.42924, 1.44867, 1.44867, 3.43389)}


def program(*words):
    return subprocess.run([KERF, *map(str, words)], check=True, text=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL).stdout


def as_computed(d):
    return np.floor(22 * np.arccos(1 - d / 44) / (PI * 22 / 24)) ** 3 * tooth_of_paper(d)


@np.vectorize
def corrected(d):
    angle = (np.arange(2000) + 0.5) / 2000 * np.arccos(1 - d / 11)
    return tooth_of_paper(d - 11 * (1 - np.cos(angle))).mean() * np.arccos(1 - d / 11) * 11 / (PI * 22 / 24)


def paper():
    table = list(csv.DictReader(program("paper", "--csv").splitlines()))
    computed = np.array([float(one["force_computed_N"]) for one in table])
    a = 0.01 * PI * 22 / 24
    expected = [math.floor(22 * math.acos(1 - float(one["depth_mm"]) / 44) / (100 * a)) ** 3 *
                hertz(a * a / 11, 11, int(one["region"])) for one in table]
    worst = np.argmax(abs(computed / expected - 1))
    row("24 forces, worst (N)", computed[worst], expected[worst], 1e-9, "the same formula in double precision")
    printed = np.array([PRINTED[int(one["region"])][i % 6] for i, one in enumerate(table)])
    worst = np.argmax(abs(computed / printed - 1))
    row("24 forces, worst against the paper's (N)", computed[worst], printed[worst], 1.2e-4, "docs/paper.md")
    own = np.array([float(one["corrected_force_N"]) for one in table])
    expected = [math.acos(1 - float(one["depth_mm"]) / 11) * 11 / (100 * a) * hertz(a * a / 11, 11, int(one["region"])) for one in table]
    worst = np.argmax(abs(own / expected - 1))
    row("24 corrected forces, worst (N)", own[worst], expected[worst], 1e-9, "the same formula in double precision")
    scene = {"bone": {"model": "block", "block": {"size_x_mm": 20, "size_y_mm": 6, "size_z_mm": 6, "voxel_mm": 0.1,
                                                  "layer": [{"thickness_mm": 6, "region": 24}]}},
             "tool": {"diameter_mm": 22, "thickness_mm": 0.25, "teeth": 24, "rpm": 7500},
             "path": {"stroke": [{"start_mm": [0, 0, 11.5], "end_mm": [0, 0, -3], "feed_mm_per_s": 3, "disc_normal": [0, 1, 0]}]},
             "force": {"law": "hertz_chip"}, "simulation": {"mode": "slab"}}
    rail = {"direction": [0, 0, -1], "depth_by": "paper_table_2"}
    for law, force in (("as_computed", as_computed), ("corrected", corrected)):
        run = kerf.run(kerf.Scene(**scene, slab={"law": law, **rail})).slab
        first, last = np.searchsorted(run["deepest_mm"], (1, 13))
        from_mm, to_mm = run["deepest_mm"][[first, last]]
        work = force(from_mm + (np.arange(4000) + 0.5) / 4000 * (to_mm - from_mm)).mean() * (to_mm - from_mm)
        row(f"slab, {law}: cutting work from 1 to 13 mm (mJ)", run["cutting_mJ"][last] - run["cutting_mJ"][first], work, 0.001,
            "a tick advances by 3 um, less than 0.1 % of a step of as_computed")
    scene["path"]["stroke"][0]["end_mm"][2] = 8.4
    curves = kerf.compare(kerf.Scene(**scene, slab={"law": "corrected", **rail}), laws=["two_component"], repeat=1)["curves"]
    curves = curves[(curves["depth_mm"] > 1) & (curves["depth_mm"] < 2.5)]
    d = curves["depth_mm"]
    for column, force in (("slab_as_computed_N", as_computed), ("slab_corrected_N", corrected)):
        row(f"comparison, 1 to 2.5 mm: {column}", curves[column].mean(), force(d).mean(), 0.01,
            "a step of depth is 0.05 mm")
    for law in ("hertz_chip", "two_component"):
        row(f"comparison, 1 to 2.5 mm: voxel_{law}_N", curves[f"voxel_{law}_N"].mean(), np.mean(
            [teeth_sum((0, R - x), (0, -3), lambda x, z: np.where(z < 0, 24, 0), law, False)["force_N"][2] for x in d]), 0.0057,
            "docs/physics.md: at most 0.57 % in a slot")


# ---- bands, calibration and energy

def bands():
    """The law edge_plus_chip is linear in both drawn values, so that its force is distributed as a trapezoid."""
    scene = kerf.Scene(
        bone={"model": "block", "block": {"size_x_mm": 20, "size_y_mm": 2, "size_z_mm": 4, "voxel_mm": 0.2,
                                          "layer": [{"thickness_mm": 4, "region": 24}]}},
        tool={"thickness_mm": 0.5, "rpm": 7500}, force={"law": "edge_plus_chip"},
        material={"kind": "uniform", "E_GPa": 19.3, "nu": 0.28},  # so that E is not drawn
        path={"stroke": [{"start_mm": [0, 0, 11.2], "end_mm": [0, 0, 9], "feed_mm_per_s": 20, "disc_normal": [0, 1, 0]}]})
    runs = 200
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "band.toml"
        file.write_text(scene.toml)
        program("run", file, "--uncertain", runs, "--jobs", 1, "--no-pictures", "-o", folder)
        with open(pathlib.Path(folder) / "band.csv") as file:
            last = list(csv.DictReader(file))[-2]
    depth = float(last["time_s"]) * 20 - 0.2 - 0.01  # in the middle of the tick
    angle = math.acos(1 - depth / R) * ((np.arange(4000) + 0.5) / 2000 - 1)
    teeth = 2 * math.acos(1 - depth / R) / (2 * PI / TEETH)
    E_star = 1 / ((1 - 0.28**2) / 205000 + (1 - 0.28**2) / 19300)
    edge = teeth * np.mean(np.cos(angle)) * 0.5 * E_star / 19140
    chip = teeth * np.mean(np.cos(angle) ** 2) * 20 / PASSES * 0.5 * E_star / 19140
    row("edge_plus_chip, nominal force (N)", float(last["force_nominal_N"]), 9.28 * edge + 530 * chip, 0.0057,
        "docs/physics.md: at most 0.57 % in a slot")
    draw = np.sort(np.add.outer(edge * (9.28 + 0.77 * (np.arange(2000) + 0.5) / 2000),
                                chip * (407 + 123 * (np.arange(2000) + 0.5) / 2000)).ravel())
    for p in (5, 50, 95):
        share = np.searchsorted(draw, float(last[f"force_p{p}_N"])) / len(draw)
        sigma = math.sqrt(p / 100 * (1 - p / 100) / runs)
        value = float(last[f"force_p{p}_N"])
        expected = draw[int(p / 100 * len(draw))]
        allowed = max(abs(draw[int(np.clip(p / 100 + side * 3 * sigma, 0, 0.99999) * len(draw))] / expected - 1) for side in (-1, 1))
        row(f"edge_plus_chip, {p} % of the band (N)", value, expected, 0.002 + allowed, f"0.2 % and 3 SDs of {runs} draws; {share:.3f} are below")


def calibration():
    true = {"thrust_edge_N_per_mm": 8.1, "thrust_chip_N_per_mm2": 610.0, "cutting_edge_N_per_mm": 5.2, "cutting_chip_N_per_mm2": 240.0}
    bites = np.repeat([0.0025, 0.004, 0.006, 0.008, 0.01], 12)
    design = 0.5 * np.stack([np.ones(60), bites], axis=1)
    noise = np.random.default_rng(5).normal(size=(2, 60)) * 0.3
    sd = 0.3 * (1 + 100 * bites)
    for name, scatter in (("exact data", 0), ("data with noise", 1)):
        values = [design @ list(true.values())[2 * i:2 * i + 2] + scatter * noise[i] * (1 + 100 * bites) for i in (0, 1)]
        with tempfile.TemporaryDirectory() as folder:
            data = pathlib.Path(folder) / "data.csv"
            data.write_text("bite_mm,width_mm,thrust_N,thrust_sd_N,cutting_N,cutting_sd_N\n" + "".join(
                f"{b!r},0.5,{t!r},{s!r},{c!r},{s!r}\n" for b, t, c, s in zip(*(x.tolist() for x in (bites, *values, sd)))))
            fit = {one["key"]: one["value"] for one in json.loads(program("calibrate", data, "--bootstrap", 0, "--json"))["parameters"]}
        for i in (0, 1):
            best = np.linalg.lstsq(design / sd[:, None], values[i] / sd, rcond=None)[0]
            for key, expected in zip(list(true)[2 * i:2 * i + 2], best if scatter else list(true.values())[2 * i:]):
                row(f"{name}: {key}", fit[key], expected, 1e-6, "weighted least squares in double precision")


def energy():
    for name, law, effects in (("no friction", "hertz_chip", []), ("friction", "two_component", ["kerf_friction", "tangential_force"])):
        start = kerf.pose((0, 0, 11.2), *UPRIGHT)
        simulation = kerf.HandSimulation(block(), start, tool=kerf.Disc(), law=law, effects=effects, stiffness_N_per_mm=2)
        angle = np.minimum(np.arange(1, 3001) / 2000, 1) * PI
        handles = np.tile(start, (3000, 1))
        handles[:, 0], handles[:, 2] = 4 * np.sin(angle), 11.2 - 4 * np.minimum(np.arange(1, 3001) / 1500, 1)
        ticks = simulation.run(handles)
        place = lambda what, at: np.stack([ticks[f"{what}_{axis}_{at}"] for axis in "xyz"], axis=1)
        tool, handle = (np.vstack([start[:3], place(what, "mm")]) for what in ("tool", "handle"))
        spring = lambda h, t: ((h - t) ** 2).sum(axis=1)  # 1/2 K x^2 with K = 2 N/mm
        step = np.diff(tool, axis=0)
        in_air = spring(handle[1:], tool[1:]) == 0  # there the tool is at the handle, at once
        work = np.where(in_air, 0, spring(handle[1:], tool[:-1]) - spring(handle[:-1], tool[:-1])).sum()
        row(f"{name}: work of the hand (mJ)", ticks["hand_mJ"].sum(), work, 1e-6, "docs/tick.md: the handle moves first")
        row(f"{name}: force on the hand, last tick (N)", place("hand", "N")[-1], 2 * (tool[-1] - handle[-1]), 1e-6, "the spring's law")
        row(f"{name}: cutting work (mJ)", ticks["cut_mJ"].sum(), -(place("cut", "N") * step).sum(), 1e-6, "force times way of the tool")
        turned = 2 * np.arccos(min(1, abs(np.dot([ticks[f"tool_q{c}"][-1] for c in "wxyz"], start[3:]))))
        stored = spring(handle[-1:], tool[-1:])[0] + 5000 / 2 * turned**2
        used = ticks["cut_mJ"].sum() + ticks["friction_mJ"].sum() + ticks["damping_mJ"].sum() + ticks["numerical_mJ"].sum()
        row(f"{name}: hand and spindle (mJ)", ticks["hand_mJ"].sum() + ticks["spindle_mJ"].sum(),
            stored + used, 1e-5, "docs/tick.md: 1e-5")


GROUPS = [volumes, forces, paper, disc_in_hand, strokes, bands, calibration, energy]


def main():
    global GROUP
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("groups", nargs="*", metavar="GROUP", help=", ".join(g.__name__ for g in GROUPS) + "; all if none")
    parser.add_argument("--figure", metavar="FILE", help="only draw the rate of a blade in a hand (needs matplotlib)")
    args = parser.parse_args()
    if args.figure:
        return draw(args.figure)
    print(f"{'group':12} {'quantity':68} {'kerf':>11} {'expected':>11} {'difference':>11} {'bound':>10}     bound from")
    for group in GROUPS:
        if not args.groups or group.__name__ in args.groups:
            began = sum(os.times()[:4])
            GROUP = group.__name__
            group()
            print(f"{GROUP:12} {sum(os.times()[:4]) - began:.0f} s of processor time")
    print(f"{rows.count(False)} of {len(rows)} rows are out of bound")
    sys.exit(rows.count(False) > 0 or not rows)


if __name__ == "__main__":
    main()
