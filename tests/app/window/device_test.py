#!/usr/bin/env python3
"""Tests the window with a Novint Falcon that is emulated below libusb: a cut during which it is unplugged and plugged
in again, with undo and redo; loss of the display during a cut; and an exercise with the device.

    device_test.py KERF_MADE_UP EMULATE_USB KERF [PICTURE]

KERF has a real window, for the loss of the display. PICTURE: file for a PNG of the window after unplugging, which
docs/devices.md shows. Exit code 77: the test was skipped; it prints the reason."""

import json
import math
import pathlib
import shutil
import subprocess
import sys

from drive import Display, Window, workspace

SOURCE = pathlib.Path(__file__).resolve().parents[3]
# Initial views of the window, as directions towards the eye in world coordinates: three-quarter
# (src/view/picture/view_frame.cpp), and the view of an exercise (src/app/window/practice_cutting.cpp).
TOWARDS_EYE = (0.75, -1.0, 0.55)
TOWARDS_EYE_AT_EXERCISE = (0.0, -1.0, 0.6)

# Settings that only the simulated hand has.
DEVICE = """
[device]
profile = "falcon"
delay_ticks = 2
orientation = [{}]
"""


def quaternion_of(right, up, towards):
    """Returns the quaternion w, x, y, z of the rotation with these columns."""
    m = [[right[i], up[i], towards[i]] for i in range(3)]
    w = math.sqrt(max(0.0, 1 + m[0][0] + m[1][1] + m[2][2])) / 2
    return w, (m[2][1] - m[1][2]) / (4 * w), (m[0][2] - m[2][0]) / (4 * w), (m[1][0] - m[0][1]) / (4 * w)


def cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def unit(a):
    length = math.sqrt(sum(x * x for x in a))
    return tuple(x / length for x in a)


def make_folder(scene, towards_eye):
    """Returns a folder with the scene of the hand and a Falcon's firmware. The device's axes are the picture's right, up and the direction
    towards the eye."""
    towards = unit(towards_eye)
    right = unit(cross((0, 0, 1), towards))
    folder = workspace()
    orientation = quaternion_of(right, cross(towards, right), towards)
    (folder / "hand.toml").write_text(scene + DEVICE.format(", ".join(repr(x) for x in orientation)))
    (folder / "firmware.bin").write_bytes(bytes(i % 251 for i in range(7324)))
    return folder


def check_end(kerf, folder):
    # The peak force in the Falcon's profile is 8.9 N.
    report = json.loads((folder / "report.json").read_text())
    assert report["motors_at_end"] == [0, 0, 0] and 0 < report["peak_force_N"] < 9, report
    done = subprocess.run([kerf, "replay", "out/session.kerf", "--verify"], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0 and "bit-identical to the recording" in done.stdout, (done.stdout, done.stderr)
    shutil.rmtree(folder)


def rehearse(kerf, emulate, picture):
    scene = (SOURCE / "tests/support/cut_bar.toml").read_text()
    # The path is deeper than necessary, because motion of the hand while the program stalls does not move the saw.
    folder = make_folder(scene.replace("end_mm = [0.0, 0.0, 0.5]", "end_mm = [0.0, 0.0, -2.5]"), TOWARDS_EYE)
    (folder / "bar.toml").write_text(scene)
    with Display() as display:
        w = Window(display, emulate,
                   ["--firmware", "firmware.bin", "--scene", "hand.toml", "--report", "report.json", "--unplug-on-way", "2",
                    "--plug-in-later", "1", "--", kerf, "rehearse", "bar.toml", "--device", "falcon", "--falcon-firmware",
                    "firmware.bin", "-o", "out"], folder, title="kerf rehearse")
        w.wait_event("running")
        w.key("space")
        w.wait_state("the spindle turns", lambda s: s["spindle"])
        w.wait_message("is gone: no force")
        if picture:
            w.key("F12")
            shutil.copy(folder / w.wait_event("picture")["file"], picture)
        w.wait_message("is connected again")
        # The hand confirms with a button of the device and continues to cut.
        w.wait_state("the bar is cut", lambda s: s["removed_mm3"] > 5)
        # Undo restores the bone around the blade, which the hand still holds there; redo removes it again.
        w.key("ctrl+z")
        w.wait_event("answer", what="Undone", failure="")
        w.wait_state("the spindle is off", lambda s: not s["spindle"])
        before = w.mark()
        w.key("r")
        w.wait_message("the handle sets its position", after=before)
        w.key("ctrl+y")
        w.wait_event("answer", what="Redone", failure="")
        # A saw that a device holds can be stopped even while the help is shown.
        w.key("space")
        w.wait_state("the spindle turns", lambda s: s["spindle"])
        w.key("F1")
        w.wait_state("help", lambda s: s["help"])
        w.key("space")
        w.wait_state("the spindle is off", lambda s: not s["spindle"])
        w.key("Escape")
        w.quit()
        code, text = w.wait_end()
        assert code == 0, text
    check_end(kerf, folder)


def lose_display(kerf, emulate):
    """Tests the loss of the display during a cut: Xlib ends a program that loses its server."""
    scene = (SOURCE / "tests/support/cut_bar.toml").read_text()
    folder = make_folder(scene, TOWARDS_EYE)
    (folder / "bar.toml").write_text(scene)
    with Display() as display:
        w = Window(display, emulate,
                   ["--firmware", "firmware.bin", "--scene", "hand.toml", "--report", "report.json", "--", kerf, "rehearse", "bar.toml",
                    "--device", "falcon", "--falcon-firmware", "firmware.bin", "-o", "out"], folder, title="kerf rehearse")
        w.wait_event("running")
        w.key("space")
        w.wait_state("the saw cuts", lambda s: s["removed_mm3"] > 1)
        display.server.kill()
        code, text = w.wait_end()
        assert code != 0, (code, text)
    report = json.loads((folder / "report.json").read_text())
    assert report["motors_at_end"] == [0, 0, 0] and report["peak_force_N"] > 0, report
    # The recording exists up to that point but is cut short: exit code 3.
    done = subprocess.run([kerf, "replay", "out/session.kerf", "--verify"], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 3 and "bit-identical to the recording" in done.stdout, (done.stdout, done.stderr)
    shutil.rmtree(folder)


def practise(kerf, emulate):
    # A hand that yields follows the exercise's own path. The groove becomes shallower than wanted, but never too deep.
    scene = (SOURCE / "scenes/practise/01_groove.toml").read_text().replace('[device]\nprofile = "omega_6"\n', "")
    folder = make_folder(scene, TOWARDS_EYE_AT_EXERCISE)
    with Display() as display:
        w = Window(display, emulate,
                   ["--firmware", "firmware.bin", "--scene", "hand.toml", "--report", "report.json", "--wait-for", "turns", "--",
                    kerf, "practise", "--exercise", "groove", "--student", "Ann", "--device", "falcon", "--falcon-firmware", "firmware.bin",
                    "-o", "out"], folder, {"KERF_DATA": str(folder / "data")}, title="kerf practise")
        w.wait_event("running")
        w.key("space")
        w.wait_state("the loop's spindle turns", lambda s: s["rpm"] > 0)
        (folder / "turns").touch()
        w.wait_state("along the line and out", lambda s: s["saw_mm"][0] > 7.5 and s["saw_mm"][2] > 12)
        w.key("space", "Return")
        score = w.wait_event("score")
        measures = {name: m["value"] for name, m in score["sheet"]["measures"].items()}
        assert measures["too_deep_mm"] == 0 and measures["cut_share"] > 0.3, measures
        # The tolerance is one voxel, 0.2 mm.
        assert abs(measures["plane_offset_mm"]) < 0.2, measures
        w.key("ctrl+q")
        code, text = w.wait_end()
        assert code == 0, text
    check_end(kerf, folder)


def main():
    made_up, emulate, kerf = sys.argv[1:4]
    rehearse(made_up, emulate, sys.argv[4] if len(sys.argv) > 4 else None)
    practise(made_up, emulate)
    lose_display(kerf, emulate)
    print("cut in the window with an emulated device: ok")


if __name__ == "__main__":
    main()
