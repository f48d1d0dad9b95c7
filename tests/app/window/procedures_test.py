#!/usr/bin/env python3
"""Tests exercises of several holes and of several cuts in the real window, with real keys: a scene file is opened, each hole
or cut is shown and made, and the attempt is scored and compared with the expert's.

    procedures_test.py KERF [--pictures FOLDER]

Exit code 77: the test was skipped; it prints the reason."""

import argparse
import json
import shutil
import subprocess
import time

from drive import Display, Window, workspace

HOLES = """title = "Two holes through a block"
[bone]
model = "block"
[bone.block]
size_x_mm = 24
size_y_mm = 14
size_z_mm = 4
voxel_mm = 0.25
[tool]
shape = "drill"
diameter_mm = 1.5
length_mm = 20
point_angle_deg = 118
rpm = 8000
[force]
law = "hertz_chip"
[coupling]
stiffness_N_per_mm = 8
[device]
profile = "omega_6"
[hand]
model = "H4"
[loop]
rate_hz = 500
[exercise]
kind = "drill_holes"
start_mm = [-5, 0, 0]
into = [0, 0, -1]
depth_mm = 5
margin_mm = 1
feed_mm_per_s = 1
[[exercise.cut]]
start_mm = [5, 0, 0]
into = [0.259, 0, -0.966]
[[path.stroke]]
start_mm = [-5, 0, 4]
end_mm = [-5, 0, 2]
feed_mm_per_s = 2
disc_normal = [0, 0, 1]
"""

CUTS = """title = "Two cuts through a bar"
[bone]
model = "block"
[bone.block]
size_x_mm = 24
size_y_mm = 10
size_z_mm = 3
voxel_mm = 0.25
[tool]
diameter_mm = 22
thickness_mm = 0.5
teeth = 24
rpm = 7500
[force]
law = "hertz_chip"
[coupling]
stiffness_N_per_mm = 2
[device]
profile = "omega_6"
[hand]
model = "H4"
[loop]
rate_hz = 500
[exercise]
kind = "osteotomy"
start_mm = [-5, -1, 0]
end_mm = [-5, 1, 0]
into = [0, 0, -1]
depth_mm = 5
margin_mm = 0.6
feed_mm_per_s = 3
[[exercise.cut]]
start_mm = [5, -1, 0]
end_mm = [5, 1, 0]
into = [0, 0, -1]
[[path.stroke]]
start_mm = [-5, -1, 15]
end_mm = [-5, -1, 13]
feed_mm_per_s = 3
disc_normal = [1, 0, 0]
"""


def say(w, text):
    w.wait_state(f"it is said: {text}", lambda s: text in s.get("step", "") + s.get("coach", ""))


def make_current(w, number, deep_mm):
    """Switches the spindle on, moves the tool down until the cut is made, and up out of the bone."""
    w.wait_state(f"cut {number}", lambda s: s["cut"] == number and s["cuts_made"] == number - 1 and not s["spindle"])
    w.key("space")
    w.wait_state("the spindle turns", lambda s: s["spindle"])
    w.press("Down")
    w.wait_state("it is made", lambda s: s["cuts_made"] == number and s["depth_mm"] > deep_mm)
    w.release("Down")


def saw_through(w, number):
    """Makes a planned cut, and moves along its line of 2 mm, which is seen from its end."""
    make_current(w, number, 3)
    start = w.state["saw_mm"][1]
    w.press("Left")
    w.wait_state("at the other end of the line", lambda s: s["saw_mm"][1] > start + 1.7)
    w.release("Left")


def lift_out(w):
    w.press("shift", "Up")
    w.wait_state("out of the bone", lambda s: s.get("depth_mm", -9) < -1)
    w.release("Up", "shift")
    w.key("space")
    w.wait_state("the spindle is off", lambda s: not s["spindle"])


def go_to_next(w, number):
    w.wait_state(f"cut {number} is next", lambda s: s["cut"] == number)
    after = w.mark()
    w.key("r")
    w.wait_event("answer", what="Retracted", failure="", after=after)
    say(w, "spindle is off")


def finish(w, folder):
    after = w.mark()
    w.key("Return")
    score = w.wait_event("score", after=after)
    assert w.wait_event("verified", after=after)["same"]
    time.sleep(0.5)
    return score


def drill_holes(w, folder, picture):
    w.wait_event("running")
    w.wait_event("first_picture")
    w.wait_items("the slices", lambda i: {"slice 1", "slice 2", "slice 3", "slice 4"} <= set(i))
    time.sleep(0.5)
    picture("holes")
    make_current(w, 1, 4.3)
    say(w, "This hole is drilled")
    picture("first hole")
    lift_out(w)
    say(w, "beside the axis of the hole")
    go_to_next(w, 2)
    time.sleep(0.5)
    picture("second hole")
    make_current(w, 2, 4.3)
    say(w, "All holes are drilled")
    lift_out(w)
    score = finish(w, folder)
    measures = {key: row["value"] for key, row in score["sheet"]["measures"].items()}
    # Keys move along the axis of each hole, and R turns the drill into it.
    assert measures["holes_through"] == 2 and measures["hole_offset_mm"] < 0.2 and measures["hole_angle_deg"] < 2, measures
    assert score["total"] > 60, score
    picture("result of holes")
    w.key("w")
    w.wait_state("the replay", lambda s: s["mode"] == "replaying")
    w.wait_state("at the second hole", lambda s: s["cut"] == 2)
    picture("holes beside the expert")
    w.key("Escape")
    w.wait_state("the result", lambda s: s["mode"] == "result")
    # Again: the same exercise begins at its first hole.
    after = w.mark()
    w.key("a")
    w.wait_event("running", after=after)
    w.wait_state("from the first hole", lambda s: s["mode"] == "cutting" and s["cut"] == 1 and s["cuts_made"] == 0)
    w.key("Escape")
    w.wait_state("the list", lambda s: s["mode"] == "choosing")
    # The list also has the procedures, and what was opened.
    w.wait_items("the exercises", lambda i: {"exercise groove", "exercise plate_holes"} <= set(i))
    time.sleep(0.5)
    picture("list with procedures")
    return score


def make_cuts(w, folder, picture):
    w.key("ctrl+o")
    w.wait_state("a file is asked for", lambda s: s["dialog"])
    time.sleep(0.5)
    after = w.mark()
    w.type(str(folder / "cuts.toml"))
    w.key("Return")
    w.wait_event("running", after=after)
    w.wait_state("the first cut", lambda s: s["exercise"] == "cuts" and s["cut"] == 1 and s["mode"] == "cutting")
    time.sleep(1)
    picture("cuts")
    saw_through(w, 1)
    say(w, "This cut is made")
    picture("first cut")
    lift_out(w)
    go_to_next(w, 2)
    saw_through(w, 2)
    say(w, "The planned cut")
    picture("second cut")
    lift_out(w)
    score = finish(w, folder)
    assert score["sheet"]["measures"]["cut_share"]["value"] > 0.95 and score["total"] > 60, score
    picture("result of cuts")
    w.key("w")
    w.wait_state("the replay", lambda s: s["mode"] == "replaying")
    time.sleep(2)
    picture("cuts beside the expert")
    w.key("Escape")
    return score


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kerf")
    parser.add_argument("--pictures")
    options = parser.parse_args()
    folder = workspace()
    (folder / "holes.toml").write_text(HOLES)
    (folder / "cuts.toml").write_text(CUTS)
    (folder / "none.toml").write_text(HOLES[:HOLES.index("[exercise]")] + HOLES[HOLES.index("[[path"):])
    (folder / "wrong.toml").write_text(HOLES.replace("depth_mm = 5", "depth_mm = 5000"))
    data = {"KERF_DATA": str(folder / "data")}
    kept = []

    def run(*arguments):
        return subprocess.run([options.kerf, *arguments], cwd=folder, env=dict(w.env, **data), capture_output=True, text=True)

    with Display() as display:
        arguments = ["practise", "-o", "out", "--exercise", "holes.toml", "--student", "Ann", "--size", "1280x800"]
        w = Window(display, options.kerf, arguments, folder, data, title="kerf practise")

        def picture(name):
            kept.append((name, folder / w.picture()))

        scores = [drill_holes(w, folder, picture), make_cuts(w, folder, picture)]
        w.key("ctrl+q")
        code, out = w.wait_end()
        assert code == 0, out

        # A bad file is one sentence, and no window.
        for file, part in (("none.toml", "is not an exercise"), ("wrong.toml", "depth_mm = 5000 is above 200"),
                           ("absent.toml", "there is no such file")):
            done = run("practise", "--exercise", file, "-o", "out2")
            assert done.returncode not in (0, -11) and part in done.stderr and file in done.stderr, (file, done.stderr)
            assert len(done.stderr.strip().splitlines()) == 1, done.stderr

    # The recordings alone give the same numbers, and the attempts are stored.
    for recording, score in zip(("session.kerf", "session-3.kerf"), scores):
        assert json.loads(run("score", f"out/{recording}", "--json").stdout) == score["sheet"], recording
    history = json.loads(run("practise", "--history", "--student", "Ann", "--json").stdout)
    assert [a["exercise"] for a in history] == ["holes", "cuts"], history
    if options.pictures:
        for name, file in kept:
            shutil.copy(file, f"{options.pictures}/procedures_{name.replace(' ', '_')}.png")
    shutil.rmtree(folder)
    print(f"holes and cuts completed: {scores[0]['total']:.1f} and {scores[1]['total']:.1f} of 100, {len(kept)} pictures")


if __name__ == "__main__":
    main()
