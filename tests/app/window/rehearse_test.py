#!/usr/bin/env python3
"""Tests a whole rehearsal in the real window, with real keys and mouse: planning, cutting through, undo, pieces,
measurements, another saw and export.

    rehearse_test.py KERF [--pictures FOLDER] [--scale 2]

--pictures: keeps the test's pictures. Exit code 77: the test was skipped; it prints the reason."""

import argparse
import json
import shutil
import subprocess
import time

from drive import Display, Window, workspace

# A bar lies across the patient and is cut in two by a stroke of some seconds; the disc is above its middle.
SCENE = """title = "Bar of cortical and cancellous bone"
[bone]
model = "block"
[bone.block]
size_x_mm = 30.0
size_y_mm = 10.0
size_z_mm = 10.0
voxel_mm = 0.2
[[bone.block.layer]]
thickness_mm = 2.0
region = 24
[[bone.block.layer]]
thickness_mm = 8.0
region = 32
[tool]
diameter_mm = 22.0
thickness_mm = 0.5
[force]
law = "hertz_chip"
[effects.kerf_friction]
coefficient = 0.2
[hand]
model = "H4"
[[plan.plane]]
name = "cut"
point_mm = [0.0, 0.0, -5.0]
normal = [1.0, 0.0, 0.0]
margin_mm = 0.5
[[path.stroke]]
start_mm = [0.0, 0.0, 13.0]
end_mm = [0.0, 0.0, 12.0]
feed_mm_per_s = 3.0
disc_normal = [1.0, 0.0, 0.0]
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kerf")
    parser.add_argument("--pictures")
    parser.add_argument("--scale", type=int, default=1)
    options = parser.parse_args()
    folder = workspace()
    (folder / "bar.toml").write_text(SCENE)
    size = (1280 * options.scale, 720 * options.scale)
    arguments = ["rehearse", "bar.toml", "-o", "out", "--size", f"{size[0]}x{size[1]}", "--scale", str(options.scale), "--json"]
    kept = []

    with Display(size[0] + 200, size[1] + 200) as display:
        w = Window(display, options.kerf, arguments, folder, title="kerf rehearse")

        def picture(name):
            file = folder / w.picture()
            assert file.stat().st_size > 10_000, file
            kept.append((name, file))

        centre = (size[0] // 2, size[1] // 2)
        w.wait_event("running")
        w.wait_event("first_picture")
        assert w.state["planes"] == 1, "the scene's plan is there"

        # Opens the help and turns the view with the mouse.
        w.key("F1")
        w.wait_state("help", lambda s: s["help"])
        picture("help")
        w.key("question")
        w.wait_state("no help", lambda s: not s["help"])
        w.drag((centre[0], centre[1] + 150), (centre[0] - 60, centre[1] + 120), button=3)
        w.scroll(*centre, 2)
        picture("begin")

        # Cuts half through with the keys, against the bone's resistance. The saw moves down in the blade's plane, and a
        # force is shown.
        w.key("v")  # from the front: down in the picture is down in the bone
        w.key("l")
        w.key("bracketleft", "bracketleft", "bracketleft")  # 2 mm/s
        w.key("space")
        w.wait_state("the spindle turns", lambda s: s["spindle"])
        w.press("Down")
        w.wait_state("bone is removed", lambda s: s["removed_mm3"] > 2)
        w.wait_state("the bone resists", lambda s: s["force_N"] > 0.1)
        w.wait_state("half through", lambda s: s["saw_mm"][2] < 9.5)
        w.release("Down")
        removed = w.wait_still("removed_mm3", still_s=0.5)
        # The kerf is about a fifth as deep as the bar.
        w.wait_state("a part of the plane is cut", lambda s: s["plane_cut"] and 0.05 < s["plane_cut"][0] < 0.5)
        picture("cutting")
        w.key("t")
        picture("translucent")
        w.key("t", "m", "m")
        picture("regions")
        w.key("m")

        # Moves out of the cut, then undoes and redoes. The spindle stops by itself, so that the restored bone is not
        # cut at once.
        w.press("Up")
        w.wait_state("out of the bone", lambda s: s["saw_mm"][2] > 12)
        w.release("Up")
        w.key("ctrl+z")
        w.wait_event("answer", what="Undone", failure="")
        w.wait_state("the spindle is off", lambda s: not s["spindle"])
        sawed = w.state["removed_mm3"]
        w.key("ctrl+y")
        w.wait_event("answer", what="Redone", failure="")
        assert w.wait_still("removed_mm3", still_s=0.5) == sawed, "redo saws nothing"

        # Makes a named checkpoint.
        w.key("c")
        w.wait_state("it asks for a name", lambda s: s["entry"])
        w.type("half through")  # replaces the proposed name, which is selected
        w.key("Return")
        answer = w.wait_event("answer", what="Checkpoint")
        assert answer["name"] == "half through", answer

        # Cuts through.
        w.key("space")
        w.wait_state("the spindle turns", lambda s: s["spindle"])
        w.press("Down")
        w.wait_state("through", lambda s: s["saw_mm"][2] < -0.8)
        w.release("Down")
        # Half of the bar without half of the kerf, 14.7 x 10 x 10 mm; half a voxel at each face is uncertain.
        freed = w.wait_event("came_free")
        assert 1390 < freed["mm3"] < 1550, freed
        w.wait_state("the plane is cut", lambda s: s["plane_cut"] == [1])
        w.key("space")
        w.press("shift", "Up")  # with Shift: fast
        w.wait_state("out again", lambda s: s["saw_mm"][2] > 13)
        w.release("Up", "shift")
        assert w.state["removed_mm3"] > removed
        assert sum(e["event"] == "came_free" for e in w.events) == 1, "the piece is announced once"

        # Places a plane and a depth stop with the mouse.
        w.key("Home", "n")
        w.wait_state("the plan's menu", lambda s: s.get("menu") == "Plan")
        picture("plan menu")
        w.key("1")
        w.wait_state("points are asked for", lambda s: s["mode"] == "picking")
        for x, y in ((-200, 20), (-150, -10), (-180, 40)):
            after = w.mark()
            w.click(centre[0] + x * options.scale, centre[1] + y * options.scale)
            w.wait_event("point", after=after)
        w.wait_state("two planes", lambda s: s["planes"] == 2)
        w.key("n", "3")
        w.wait_state("a point is asked for", lambda s: s["mode"] == "picking")
        w.click(centre[0] + 150 * options.scale, centre[1])
        w.wait_state("a depth is asked for", lambda s: s["entry"])
        w.type("4")
        w.key("Return")
        w.wait_state("a stop", lambda s: s["stops"] == 1)
        picture("plan")

        # Pieces are picked, moved along an axis, rotated and measured.
        w.key("p")
        pieces = w.wait_event("pieces")
        assert pieces["count"] == 2, pieces
        w.wait_event("contact")
        w.key("a")  # along left - right only
        w.key("Tab")
        for _ in range(6):
            w.key("Right")
        w.wait_state("a piece is moved", lambda s: any(p["moved_mm"] == 3 for p in s["pieces"]))

        # When the piece is moved towards the other one, they overlap by 3 mm minus the kerf of 0.5 mm, over 10 x 10 mm.
        # When it is moved away, the gap is 3 mm plus the kerf. The kerf may be a tenth wider than the disc.
        def as_moved():
            return any(235 < e["overlap_mm3"] < 252 or 3.45 < (e["gap_mm"] or 0) < 3.7
                       for e in w.events if e["event"] == "contact")
        w.wait("the overlap or the gap of a piece moved by 3 mm", as_moved)
        w.key("a", "a", "a", "e", "e")
        w.wait_state("and turned", lambda s: any(abs(p["turned_deg"] - 2) < 0.01 for p in s["pieces"]))
        w.key("ctrl+z", "ctrl+z", "ctrl+z")
        w.wait_state("undone", lambda s: any(p["moved_mm"] == 2.5 for p in s["pieces"]))
        w.key("ctrl+y")
        w.wait_state("redone", lambda s: any(p["moved_mm"] == 3 for p in s["pieces"]))
        w.key("d")
        w.click(centre[0] - 100 * options.scale, centre[1])
        w.click(centre[0] + 100 * options.scale, centre[1])
        label = w.wait_event("measure")["label"]
        assert label.endswith(" mm"), label
        # The points belong to their pieces: when one piece is moved, the distance changes, and undo brings it back.
        w.wait_state("the distance", lambda s: len(s["measured"]) == 1)
        distance = w.state["measured"][0]
        w.key("a", "Right", "Right")
        w.wait_state("another distance", lambda s: abs(s["measured"][0] - distance) > 0.5)
        w.key("ctrl+z", "ctrl+z", "a", "a", "a")
        w.wait_state("the same distance", lambda s: s["measured"] == [distance])
        time.sleep(0.3)
        picture("pieces")
        w.key("h")
        w.wait_state("hidden", lambda s: any(p["hidden"] for p in s["pieces"]))
        w.key("h")

        # Escape ends the measurement, not the mode; the pieces' own undo still works. A second Escape ends the mode.
        w.key("d")
        for x in (-100, 100):
            after = w.mark()
            w.click(centre[0] + x * options.scale, centre[1])
        w.wait_event("measure", after=after)
        w.wait_state("the result is shown", lambda s: s["measuring"])
        w.key("Escape")
        w.wait_state("the measurement is over", lambda s: not s["measuring"])
        assert w.state["mode"] == "pieces", w.state
        w.key("ctrl+z", "ctrl+z")  # shown, hidden
        w.wait_state("moved by the last step", lambda s: any(p["moved_mm"] == 3 for p in s["pieces"]))
        w.key("Escape")
        w.wait_state("cutting again", lambda s: s["mode"] == "cutting")
        # An undo that may be meant for the pieces takes back nothing of the cut.
        after = w.mark()
        w.key("ctrl+z")
        w.wait_message("You are back at the saw", after)
        assert w.state["plane_cut"][0] == 1, w.state

        # The cut is undone and redone. The export from the saw's mode contains the pieces as they were moved and measured.
        after = w.mark()
        w.key("b", "1")
        w.wait_event("answer", after=after, what="Undone", failure="")
        w.wait_state("a part of the plane is cut", lambda s: 0.05 < s["plane_cut"][0] < 0.5)
        after = w.mark()
        w.key("ctrl+shift+z")
        w.wait_event("answer", after=after, what="Redone", failure="")
        w.wait_state("the plane is cut", lambda s: s["plane_cut"][0] == 1)
        w.key("F9")
        w.wait_state("it asks for the folder", lambda s: s["entry"])
        w.key("Return")
        taken = w.wait_event("taken_away")
        assert "failure" not in taken, taken
        w.wait_state("it asks whether to open the folder", lambda s: s["dialog"])
        w.key("Escape")
        w.wait_state("no question", lambda s: not s["dialog"])

        # The guide holds the saw in the plan's first plane and releases it again.
        w.key("n", "5")  # the next plane: the scene's own
        for guided in (True, False):
            sessions = w.mark()
            # The second key is pressed while the session restarts; it is for the next one.
            w.input.tap("g", "space")
            w.wait_event("running", after=sessions)
            w.wait_state("the guide and the spindle", lambda s: s["guided"] == guided and s["spindle"])
            assert w.wait_event("spindle", after=sessions, on=True), w.events
            w.key("space")
            w.wait_state("the spindle is off", lambda s: not s["spindle"])

        # Another saw continues with the same bone.
        sessions = w.mark()
        w.key("2")
        w.wait_event("running", after=sessions)
        w.wait_state("the fine disc", lambda s: s["saw"] == "fine disc 16 mm")
        picture("another saw")
        # Pieces were moved, and an export is not a project.
        w.key("ctrl+q")
        w.wait_state("a question", lambda s: s["dialog"])
        w.click_item("answer 2")
        code, out = w.wait_end()
        assert code == 0, out

    left = json.loads(out[out.index("{"):])
    assert len(left["recordings"]) == 4, left
    away = folder / left["take_away"]
    names = {p.name for p in away.iterdir()}
    for name in ("report.html", "measures.csv", "transforms.json", "planned.mrk.json", "achieved.mrk.json", "pieces.json"):
        assert name in names, (name, names)
    assert sum(name.endswith(".stl") for name in names) >= 2, names
    report = (away / "report.html").read_text()
    assert "http://" not in report.replace("http://www.w3.org", "") and "cut" in report
    assessed = json.loads((away / "assessment.json").read_text())
    cut = next(p for p in assessed["planes"] if p["name"] == "cut")
    assert abs(cut["offset_mm"]) < 0.2, cut
    pieces = json.loads((away / "transforms.json").read_text())["pieces"]
    moved = [sum(p["transform"][i] ** 2 for i in (3, 7, 11)) ** 0.5 for p in pieces]
    assert sorted(moved) == [0, 3], pieces
    assert "distance 2" in (away / "measures.csv").read_text()
    # The window announced the piece with the volume that the report has, except for what the saw has cut since the piece
    # came free. The sum of the voxels would be 5 % less.
    assert any(abs(p["volume_mm3"] - freed["mm3"]) < 0.005 * freed["mm3"] for p in pieces), (freed, pieces)

    # Every recorded session replays bit-identically without a window.
    for i, recording in enumerate(left["recordings"]):
        done = subprocess.run([options.kerf, "replay", recording, "--verify"], cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, (recording, done.stdout, done.stderr)
    if options.pictures:
        for name, file in kept:
            shutil.copy(file, f"{options.pictures}/rehearse_{name.replace(' ', '_')}.png")
    shutil.rmtree(folder)
    print("rehearsal completed:", len(kept), "pictures")


if __name__ == "__main__":
    main()
