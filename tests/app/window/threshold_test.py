#!/usr/bin/env python3
"""Tests a CT whose values are no Hounsfield units, in the real window: the window asks for a threshold, whose bone it
tints in the slices, and imports with it.

    threshold_test.py KERF

Exit code 77: the test was skipped; it prints the reason."""

import re
import struct
import subprocess
import sys

from drive import Display, Window, skip_without_display_programs, workspace
from separate_test import ORIGIN_MM, SIZE, SPACING_MM, is_bone

AIR, SOFT, BONE = 24, 1064, 1700  # HU plus 1024; bone below the threshold of enamel


def write_ct(path):
    """The lower part of the CT of separate_test.py: a horseshoe with two uprights, without the block above."""
    values = []
    for k in range(SIZE[2]):
        for j in range(SIZE[1]):
            for i in range(SIZE[0]):
                p = [o + SPACING_MM * n for o, n in zip(ORIGIN_MM, (i, j, k))]
                values.append(BONE if p[2] < 60 and is_bone(p) else SOFT if p[1] < 0 else AIR)
    header = ("NRRD0004\ntype: short\ndimension: 3\nspace: left-posterior-superior\n"
              f"sizes: {SIZE[0]} {SIZE[1]} {SIZE[2]}\nspace directions: (2,0,0) (0,2,0) (0,0,2)\n"
              "kinds: domain domain domain\nendian: little\nencoding: raw\n"
              f"space origin: ({ORIGIN_MM[0]},{ORIGIN_MM[1]},{ORIGIN_MM[2]})\n\n")
    path.write_bytes(header.encode() + struct.pack(f"<{len(values)}h", *values))


def main():
    skip_without_display_programs()
    kerf = sys.argv[1]
    folder = workspace()
    write_ct(folder / "grey.nrrd")
    with Display() as display:
        w = Window(display, kerf, ["rehearse", "grey.nrrd", "-o", "out", "--voxel", "0.5"], folder, title="kerf rehearse")
        w.wait_event("asks_for_threshold")
        w.wait_items("the slices", lambda items: "ct.large" in items and "threshold.value" in items)
        proposed = w.state["threshold"]["value"]
        assert SOFT < proposed < BONE, proposed
        left, top, width, height = w.items["threshold.value"]
        w.drag((left + 0.6 * width, top + height / 2), (left + 0.8 * width, top + height / 2))
        w.wait_state("the threshold is moved", lambda s: proposed < s["threshold"]["value"] < BONE)
        after = w.mark()
        w.click_item("threshold.run")
        w.wait_event("running", after=after)
        w.wait_state("the notes on the import", lambda s: s["dialog"])
        assert "threshold" not in w.state
        w.key("Return")
        w.quit()
        code, out = w.wait_end()
        assert code == 0, (code, out)
    bone = max((folder / "out").glob("bone*.vdb"), key=lambda f: f.stat().st_mtime)
    info = subprocess.run([kerf, "info", str(bone)], check=True, capture_output=True, text=True).stdout
    # The drag goes on after the state that was read, so only the range is known.
    iso = float(re.search(r"import_iso_HU (\S+)", info)[1])
    assert proposed < iso < BONE, (proposed, info)
    print("ok")


if __name__ == "__main__":
    main()
