#!/usr/bin/env python3
"""Tests what the window asks about a CT before it is imported, in the real window: a dental cone-beam file, one file of
many frames without places and with grey values, is dropped into it and becomes a bone after one question; a folder with
two series becomes one after the series is chosen by its picture, a surface after its unit is. Enter alone answers none of
these, and the tour of a first start waits.

    scan_check_test.py KERF [--pictures FOLDER] [--language CODE]

Exit code 77: the test was skipped; it prints the reason."""

import argparse
import json
import pathlib
import re
import shutil
import struct
import subprocess
import time

from drive import Display, Window, workspace
from separate_test import ORIGIN_MM, SIZE, SPACING_MM, is_bone

AIR, SOFT, BONE = 324, 1076, 1620  # grey values of -1000, 40 and 792 HU; bone below the threshold of enamel


def frames():
    """The lower part of the CT of separate_test.py: a horseshoe with two uprights, without the block above."""
    for k in range(SIZE[2]):
        values = []
        for j in range(SIZE[1]):
            for i in range(SIZE[0]):
                p = [o + SPACING_MM * n for o, n in zip(ORIGIN_MM, (i, j, k))]
                bone = p[2] < 60 and is_bone(p)
                values.append(BONE if bone else SOFT if p[1] < 0 else AIR + (i + j + k) % 5)
        yield struct.pack(f"<{len(values)}h", *values)


def element(group, number, kind, value):
    if isinstance(value, str):
        value = value.encode()
    value += (b"\0" if kind in ("UI", "OB") else b" ") * (len(value) % 2)
    size = struct.pack("<xxI", len(value)) if kind in ("OB", "OW") else struct.pack("<H", len(value))
    return struct.pack("<HH", group, number) + kind.encode() + size + value


def dicom(uid, pixels, modality="CT", kernel="", position=None, count=1):
    """A file of `count` frames, explicit VR, little-endian."""
    sop = "1.2.840.10008.5.1.4.1.1.2"
    meta = (element(2, 2, "UI", sop) + element(2, 3, "UI", uid) + element(2, 0x10, "UI", "1.2.840.10008.1.2.1")
            + element(2, 0x12, "UI", "1.2.3"))
    meta = element(2, 0, "UL", struct.pack("<I", len(meta))) + meta
    series = uid.rsplit(".", 1)[0]
    data = element(8, 0x16, "UI", sop) + element(8, 0x18, "UI", uid) + element(8, 0x60, "CS", modality)
    data += element(8, 0x103e, "LO", "Jaw") + element(0x10, 0x20, "LO", "7")
    data += element(0x18, 0x1210, "SH", kernel) if kernel else b""
    data += element(0x20, 0xd, "UI", "1.2.4") + element(0x20, 0xe, "UI", series)
    if position:
        data += element(0x20, 0x32, "DS", "\\".join(map(str, position))) + element(0x20, 0x37, "DS", "1\\0\\0\\0\\1\\0")
    data += element(0x28, 2, "US", struct.pack("<H", 1)) + element(0x28, 4, "CS", "MONOCHROME2")
    data += element(0x28, 8, "IS", str(count)) if count > 1 else b""
    data += element(0x28, 0x10, "US", struct.pack("<H", SIZE[1])) + element(0x28, 0x11, "US", struct.pack("<H", SIZE[0]))
    data += element(0x28, 0x30, "DS", f"{SPACING_MM}\\{SPACING_MM}")
    for number, value in ((0x100, 16), (0x101, 16), (0x102, 15), (0x103, 1)):
        data += element(0x28, number, "US", struct.pack("<H", value))
    data += element(0x28, 0x1052, "DS", "0") + element(0x28, 0x1053, "DS", "1")
    return bytes(128) + b"DICM" + meta + data + element(0x7fe0, 0x10, "OW", pixels)


def write_inputs(folder):
    planes = list(frames())
    write_shin(folder / "shin.stl")
    (folder / "none").mkdir()
    (folder / "none/notes.txt").write_text("no scan")
    # From the head to the feet, and nothing says how far apart.
    (folder / "cbct.dcm").write_bytes(dicom("1.5.1.1", b"".join(reversed(planes)), count=SIZE[2]))
    for series, kernel in ((1, "H60s"), (2, "H70s")):
        path = folder / f"two/{series}"
        path.mkdir(parents=True)
        for k, plane in enumerate(planes):
            place = [*ORIGIN_MM[:2], ORIGIN_MM[2] + SPACING_MM * k]
            (path / f"{k}.dcm").write_bytes(dicom(f"1.6.{series}.{k + 1}", plane, kernel=kernel, position=place))


def write_shin(file):
    """A box of 38 x 3 x 2.5, as a long bone in cm."""
    corners = [(x, y, z) for z in (0, 2.5) for y in (0, 3) for x in (0, 38)]
    sides = ((0, 2, 3), (0, 3, 1), (4, 5, 7), (4, 7, 6), (0, 1, 5), (0, 5, 4), (1, 3, 7), (1, 7, 5), (3, 2, 6), (3, 6, 7),
             (2, 0, 4), (2, 4, 6))
    file.write_bytes(bytes(80) + struct.pack("<I", len(sides)) + b"".join(
        struct.pack("<3f", 0, 0, 0) + b"".join(struct.pack("<3f", *corners[i]) for i in side) + b"\0\0" for side in sides))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("kerf")
    parser.add_argument("--pictures")
    parser.add_argument("--language", default="en")
    options = parser.parse_args()
    folder = workspace()
    write_inputs(folder)
    settings = folder / "config/kerf/window.json"
    settings.parent.mkdir(parents=True)
    settings.write_text(json.dumps({"language": options.language, "save_folder": str(folder)}))
    with Display() as display:
        w = Window(display, options.kerf, ["rehearse", "two", "-o", "out", "--voxel", "0.5"], folder, title="kerf rehearse")

        def picture(name):
            if options.pictures:
                shutil.copy(folder / w.picture(), pathlib.Path(options.pictures) / f"{name}_{options.language}.png")

        def enter_alone(asks):
            after = w.mark()
            w.key("Return")
            time.sleep(1)
            w.read()
            assert asks(w.state) and "opening" not in [e["event"] for e in w.events[after:]], (w.state, w.events[after:])

        # The series of a folder.
        w.wait_event("asks_for_series")
        w.wait_items("both series, without the tour", lambda items: "answer 3" in items and "tour.skip" not in items)
        assert w.state["tour"] == 1
        enter_alone(lambda s: s["dialog"])
        assert w.items["answer 2"][3] > 90, ("pictures", w.items)
        picture("series")
        after = w.mark()
        w.click_item("answer 2")
        w.wait_event("asks_about_scan", after=after)
        w.wait_items("the threshold, without the tour", lambda items: "threshold.value" in items
                     and "placing.swap 3" not in items and "tour.skip" not in items)
        picture("threshold")
        proposed = w.state["scan"]["threshold"]
        assert SOFT < proposed < BONE, proposed
        left, top, width, height = w.items["threshold.value"]
        w.drag((left + 0.6 * width, top + height / 2), (left + 0.8 * width, top + height / 2))
        w.wait_state("the threshold is moved", lambda s: proposed < s["scan"]["threshold"] < BONE)
        w.click_item("scan.import")
        w.wait_event("running", after=after)
        w.click_item("tour.skip")
        w.wait_state("the notes on the import", lambda s: s["dialog"])
        picture("notes")
        assert "scan" not in w.state
        w.key("Return")
        w.wait_state("no dialog", lambda s: not s["dialog"])

        # A cone-beam file.
        after = w.mark()
        w.input.drop(folder / "cbct.dcm")
        w.wait_event("asks_about_scan", after=after)
        w.wait_items("the questions", lambda items: "placing.spacing" in items and "threshold.value" in items)
        assert w.state["scan"]["spacing_mm"] == 0, w.state["scan"]
        enter_alone(lambda s: s["scan"]["asks"])
        w.click_item("scan.import")  # is disabled until the distance is given
        enter_alone(lambda s: s["scan"]["asks"])
        before = w.items["ct.large"]
        picture("placing")
        w.click_item("placing.swap 3")
        w.wait_state("turned", lambda s: s["scan"]["frame"] == "LPI")
        left, top, width, height = w.items["placing.spacing"]  # the field is left of its name
        w.click(left + 20, top + height / 2)
        w.key("ctrl+a")
        w.type("2.2")
        w.key("Tab")
        w.wait_state("the distance is given", lambda s: s["scan"]["spacing_mm"] == 2.2)
        w.wait_items("higher slices", lambda items: items["ct.large"] != before)
        picture("placed")
        for _ in range(2):  # the first one leaves the field
            enter_alone(lambda s: s["scan"]["asks"])
        w.click_item("scan.import")
        w.wait_event("running", after=after)
        w.wait_state("the notes on the import", lambda s: s["dialog"])
        w.key("Return")
        w.wait_state("no dialog", lambda s: not s["dialog"])
        asked = [e["event"] for e in w.events[after:] if e["event"].startswith("asks")]
        assert asked == ["asks_about_scan"], asked

        # A surface in cm, and a folder without a scan.
        after = w.mark()
        w.input.drop(folder / "shin.stl")
        w.wait_event("asks_for_unit", after=after)
        w.wait_items("both units", lambda items: "answer 3" in items)
        picture("unit")
        enter_alone(lambda s: s["dialog"])
        w.key("Escape")
        w.wait_state("no dialog", lambda s: not s["dialog"])
        w.input.drop(folder / "none")
        w.wait_event("not_opened", after=after)
        w.wait_state("the reason", lambda s: s["dialog"])
        picture("refused")
        w.key("Return")
        w.wait_state("no dialog", lambda s: not s["dialog"])
        w.quit()
        code, out = w.wait_end()
        assert code == 0, (code, out)
    bones = sorted((folder / "out").glob("bone*.vdb"), key=lambda f: f.stat().st_mtime)
    assert len(bones) == 2, bones
    chosen, given = (subprocess.run([options.kerf, "info", str(bone)], check=True, capture_output=True, text=True).stdout
                     for bone in bones)
    assert "import_series_uid 1.6.2" in chosen, chosen
    # The drag goes on after the state that was read, so only the range is known.
    assert proposed < float(re.search(r"import_iso_HU (\S+)", chosen)[1]) < BONE, (proposed, chosen)
    assert "import_ct_spacing_mm 2 2 2.2" in given and "import_frame LPI" in given, given
    print("ok")


if __name__ == "__main__":
    main()
