#!/usr/bin/env python3
"""Tests a CT whose mandible touches other bone, in the real window: the window asks for points, which are clicked in the
slices, and imports again. Then a nerve is marked in an enlarged slice of that CT.

    separate_test.py KERF

Exit code 77: the test was skipped; it prints the reason."""

import math
import struct
import subprocess
import sys
import time

from drive import NEXT_CLICK_S, Display, Window, workspace

SIZE, SPACING_MM, ORIGIN_MM = (62, 50, 46), 2, (-61, -54, -14)
LOWER = [o - SPACING_MM / 2 for o in ORIGIN_MM]  # edges of the scan
UPPER = [o + SPACING_MM * n for o, n in zip(LOWER, SIZE)]
TUBES = (((-12, -40, 0), (12, -40, 0), 7), ((12, -40, 0), (45, 25, 5), 7), ((-12, -40, 0), (-45, 25, 5), 7),
         ((45, 25, 5), (48, 30, 56), 6), ((-45, 25, 5), (-48, 30, 56), 6))


def is_bone(p):
    for a, b, radius in TUBES:
        ab = [v - u for u, v in zip(a, b)]
        along = sum(d * (w - u) for d, w, u in zip(ab, p, a)) / sum(d * d for d in ab)
        along = min(max(along, 0), 1)
        if math.dist(p, [u + along * d for u, d in zip(a, ab)]) < radius:
            return True
    x, y, z = abs(p[0]), p[1], p[2]
    return (x < 56 and 20 < y < 40 and 66 < z < 74) or (44 < x < 50 and 28 < y < 34 and 60 < z <= 66)


def write_ct(path):
    """A horseshoe with two uprights, which passes for a mandible, and a block that rests on the uprights: bone as dense as
    theirs, so that no threshold separates them. Around it is soft tissue in front of y = 0, and air behind."""
    values = []
    for k in range(SIZE[2]):
        for j in range(SIZE[1]):
            for i in range(SIZE[0]):
                p = [o + SPACING_MM * n for o, n in zip(ORIGIN_MM, (i, j, k))]
                values.append(1000 if is_bone(p) else 40 if p[1] < 0 else -1000)
    header = ("NRRD0004\ntype: short\ndimension: 3\nspace: left-posterior-superior\n"
              f"sizes: {SIZE[0]} {SIZE[1]} {SIZE[2]}\nspace directions: (2,0,0) (0,2,0) (0,0,2)\n"
              "kinds: domain domain domain\nendian: little\nencoding: raw\n"
              f"space origin: ({ORIGIN_MM[0]},{ORIGIN_MM[1]},{ORIGIN_MM[2]})\n\n")
    path.write_bytes(header.encode() + struct.pack(f"<{len(values)}h", *values))


def click_coronal(w, x_mm, z_mm):
    left, top, width, height = w.items["ct.large"]
    w.click(left + width * (x_mm - LOWER[0]) / (UPPER[0] - LOWER[0]),
            top + height * (UPPER[2] - z_mm) / (UPPER[2] - LOWER[2]))


def click_sagittal(w, y_mm, z_mm):
    left, top, width, height = w.items["ct.large"]
    w.click(left + width * (y_mm - LOWER[1]) / (UPPER[1] - LOWER[1]),
            top + height * (UPPER[2] - z_mm) / (UPPER[2] - LOWER[2]))


def separate(w, after):
    """Gives the points that are asked for, with mistakes that are corrected."""
    w.wait_items("the slices", lambda items: "ct.large" in items and "ct 3" in items)
    w.key("Return")  # nothing can be separated yet
    click_coronal(w, -60, -13)  # air
    w.wait_state("refused", lambda s: s["separation"]["refusal"] and s["separation"]["keep"] == 0)
    assert w.state["separation"]["asks"]
    time.sleep(NEXT_CLICK_S)
    choice = w.items["separate.drop"]
    click_coronal(w, 17.3, 1)
    w.wait_state("a point in the mandible", lambda s: s["separation"]["keep"] == 1 and not s["separation"]["refusal"])
    time.sleep(NEXT_CLICK_S)
    click_coronal(w, -17.3, 1)
    w.wait_state("another one", lambda s: s["separation"]["keep"] == 2)
    w.wait_items("two rows", lambda items: "separate.remove keep 2" in items)
    assert w.items["separate.drop"] == choice, "the list grows below the choice"
    w.click_item("separate.remove keep 2")
    w.wait_state("removed", lambda s: s["separation"]["keep"] == 1)
    w.wait_items("the list is shorter", lambda items: "separate.remove keep 2" not in items)
    w.click_item("separate.drop")
    coronal = w.items["ct.large"]
    w.click_item("ct.large 3")
    w.wait_items("the sagittal slice, which is narrower", lambda items: items["ct.large"] != coronal)
    time.sleep(NEXT_CLICK_S)
    click_sagittal(w, 30, 70)
    w.wait_state("a point in the block", lambda s: s["separation"]["drop"] == 1)
    assert w.state["separation"]["keep"] == 1
    w.click_item("separate.run")
    w.wait_event("running", after=after)
    w.wait_state("the notes on the import", lambda s: s["dialog"])
    w.key("Return")
    w.wait_state("no dialog", lambda s: not s["dialog"])


def mark_in_slice(w):
    """A click does not move the enlarged slice, and a point is dragged where it is drawn."""
    w.choose("Plan", "mark.nerve")
    w.wait_state("points are asked for", lambda s: s["placed"] == 0)
    left, top, width, height = w.items["slice 2"]
    w.scroll(left + width / 2, top + height / 2, 3)
    w.wait_state("scrolled", lambda s: s["slices_mm"][1] == 1.5)
    before = w.wait_still("slice_middles_mm", still_s=1)
    w.click(left + width / 2, top + height / 2, times=2)
    w.wait_state("enlarged", lambda s: s["slice_enlarged"])
    assert w.wait_still("slice_middles_mm", still_s=1)[1] == before[1], "the slice is kept when it is enlarged"
    w.wait_items("the large slice", lambda items: items["slice 2"][2] > 1.5 * width)
    left, top, width, height = w.items["slice 2"]
    at = (left + 0.6 * width, top + 0.4 * height)
    w.click(*at)
    w.wait_state("a point", lambda s: s["placed"] == 1)
    after = w.wait_still("slice_middles_mm", still_s=1)
    assert after[1] == before[1], "the slice that was clicked stays"
    assert after[0] != before[0] and after[2] != before[2], "the others follow"
    point = w.state["placed_mm"][0]
    w.drag(at, (at[0] + 60, at[1]))
    w.wait_state("the point is moved to the patient's left", lambda s: s["placed_mm"][0][0] > point[0] + 1)
    assert w.wait_still("placed", still_s=0.5) == 1, "no second point"
    assert abs(w.state["placed_mm"][0][2] - point[2]) < 0.2, (point, w.state["placed_mm"])
    assert w.wait_still("slice_middles_mm", still_s=0.5)[1] == before[1]
    w.key("BackSpace")
    w.wait_state("no point", lambda s: s["placed"] == 0)
    w.key("Escape")
    w.wait_state("shrunk", lambda s: not s["slice_enlarged"])
    w.key("Escape")
    w.wait_state("no longer asked", lambda s: s["placed"] == -1)


def main():
    kerf = sys.argv[1]
    folder = workspace()
    write_ct(folder / "jaws.nrrd")
    with Display() as display:
        # Cancelling opens the built-in bone, and the window stays.
        w = Window(display, kerf, ["rehearse", "jaws.nrrd", "-o", "out", "--voxel", "0.5"], folder, title="kerf rehearse")
        w.wait_event("asks_for_points")
        w.key("Escape")
        w.wait_event("running")
        # From there, the CT is opened again; the bone that was open stays until the points are given.
        for cancels in (True, False):
            w.key("ctrl+o")
            w.wait_state("it asks for a file", lambda s: s["dialog"])
            after = w.mark()
            w.type("jaws.nrrd")
            w.key("Return")
            w.wait_event("asks_for_points", after=after)
            assert w.state["running"]
            w.wait_items("nothing of the case before is shown",
                         lambda items: "ct.large" in items and "section Values" not in items
                         and "indicator plan.guide" not in items)
            w.key("p", "c", "ctrl+s")  # of the case before, and not for this question
            if cancels:
                w.click_item("separate.cancel")
                w.wait_message("The case before it is still open", after=after)
                w.wait_state("the bone before", lambda s: s["running"] and "separation" not in s)
        separate(w, after)
        mark_in_slice(w)
        w.quit()
        code, out = w.wait_end()
        assert code == 0, (code, out)
    bone = max((folder / "out").glob("bone*.vdb"), key=lambda f: f.stat().st_mtime)
    info = subprocess.run([kerf, "info", str(bone)], check=True, capture_output=True, text=True).stdout
    assert "points: 1 keep, 1 drop" in info, info
    print("ok")


if __name__ == "__main__":
    main()
