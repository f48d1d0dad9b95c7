#!/usr/bin/env python3
"""Tests a whole exercise in the real window, with real keys: it is selected, cut, scored and saved. The recording must
have the same score without a window.

    practise_test.py KERF [--pictures FOLDER] [--scale 2]

Exit code 77: the test was skipped; it prints the reason."""

import argparse
import json
import shutil
import subprocess
import time

from drive import Display, Window, workspace


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kerf")
    parser.add_argument("--pictures")
    parser.add_argument("--scale", type=int, default=1)
    options = parser.parse_args()
    folder = workspace()
    data = {"KERF_DATA": str(folder / "data")}
    size = (1280 * options.scale, 720 * options.scale)
    arguments = ["practise", "-o", "out", "--student", "Ann", "--size", f"{size[0]}x{size[1]}", "--scale", str(options.scale)]
    kept = []

    with Display(size[0] + 200, size[1] + 200) as display:
        w = Window(display, options.kerf, arguments, folder, data, title="kerf practise")

        def picture(name):
            kept.append((name, folder / w.picture()))

        w.wait_state("the list of exercises", lambda s: s["mode"] == "choosing")
        time.sleep(0.3)
        picture("exercises")
        w.key("Down", "Up", "Return")  # the first exercise: the groove
        w.wait_state("its levels", lambda s: s.get("menu", "").startswith("Groove"))
        time.sleep(0.3)
        picture("levels")
        w.key("Return")
        w.wait_event("running")
        w.wait_event("first_picture")
        assert w.state["exercise"] == "groove"

        # The saw moves down to the depth at which the stop of level 1 holds it, along the line of 16 mm, and up and
        # out.
        w.wait_state("the first step is said", lambda s: "spindle" in s.get("step", ""))
        # The clock does not run while the student reads. A busy loop has fewer ticks in this time.
        time.sleep(4)
        w.read()
        assert w.state["elapsed_s"] == 0, w.state
        w.key("space")
        w.wait_state("the spindle turns", lambda s: s["spindle"])
        w.wait_state("the next step is said", lambda s: "Lower the blade" in s.get("step", ""))
        start = w.state["saw_mm"][0]
        w.press("Down")
        w.wait_state("deep enough", lambda s: s.get("to_goal_mm", 9) < 0.15)
        picture("goal")
        # A stop of 200 N/mm gives way by 0.03 mm at 6 N.
        w.wait_state("pressed against the stop", lambda s: s["force_N"] > 6)
        w.wait_state("it says so", lambda s: "depth stop holds the saw" in s["held"])
        # It is pressed down all along: a hand that lets go in between, if only for a frame, holds the saw without force,
        # and the teeth then lift it.
        w.press("Right")
        w.wait_state("along the line", lambda s: abs(s["saw_mm"][0] - start) > 8)
        picture("along")
        w.wait_state("to its end", lambda s: abs(s["saw_mm"][0] - start) > 15.6)
        w.release("Right", "Down")
        w.wait_state("the last step is said", lambda s: "whole line is cut" in s.get("step", ""))
        deepest = w.state["depth_mm"]
        assert deepest < 2.06, ("the stop holds", w.state)
        w.press("shift", "Up")
        w.wait_state("out", lambda s: s.get("depth_mm", 1) < 0 or "depth_mm" not in s)
        w.release("Up", "shift")
        w.key("space", "Return")
        score = w.wait_event("score")
        assert score["total"] > 50, score
        assert score["headline"].endswith("."), score["headline"]
        ended = w.wait_event("ended")
        measured_s = score["sheet"]["measures"]["time_total_s"]["value"]
        assert measured_s < 0.001 * (ended["ticks"] + ended["missed"]) - 2, (measured_s, ended)
        assert (score["next_exercise"], score["next_level"]) == ("groove", 2 if score["total"] >= 70 else 1), score
        time.sleep(0.5)
        picture("score")

        # Further figures are folded; all buttons are shown.
        after = w.mark()
        w.click_item("practise.more")
        w.read()
        assert {"practise.step", "practise.watch", "practise.list", "practise.above", "practise.side"} <= set(w.items), w.items
        picture("more figures")
        w.click_item("practise.more")

        # The replay beside the expert begins when the expert's attempt has been computed; it can be left.
        w.click_item("practise.watch")
        w.wait_state("the replay", lambda s: s["mode"] == "replaying")
        w.wait_state("goes on", lambda s: s.get("replay_s", 0) > 2)
        picture("beside the expert")
        # Space pauses it, and the arrows step; both are not for the saw.
        w.key("space")
        w.wait_state("paused", lambda s: not s["replay_runs"])
        paused = w.state["replay_s"]
        w.key("Right", "Right")
        w.wait_state("a second later", lambda s: abs(s["replay_s"] - paused - 1) < 1e-6)
        w.key("space")
        w.wait_state("goes on", lambda s: s["replay_runs"] and s["replay_s"] > paused + 1.2)
        # A click in the plot chooses the time; Enter begins again.
        plot = w.items["practise.plot"]
        w.click(plot[0] + 0.75 * plot[2], plot[1] + 0.5 * plot[3])
        w.wait_state("a later time", lambda s: s.get("replay_s", 0) > 5)
        w.key("Return")
        w.wait_state("from the beginning", lambda s: s.get("replay_s", 9) < 2)
        w.click_item("practise.result")
        w.wait_state("back to the result", lambda s: s["mode"] == "result")
        # A replay of the recording gives the sheet that was computed while the exercise was done.
        assert w.wait_event("verified")["same"]

        # A cut beside the line is noticed while it is made; an unfinished one has no score, and the same level follows.
        after = w.mark()
        w.key("Escape")
        w.wait_state("the list again", lambda s: s["mode"] == "choosing")
        # The list recommends what the result has recommended.
        w.wait_event("recommended", after=after, exercise=score["next_exercise"], level=score["next_level"])
        w.key("Return", "3")
        after = w.mark()
        w.wait_event("running", after=after)
        w.wait_state("level 3", lambda s: s["level"] == 3 and s["mode"] == "cutting")
        # The lock holds the saw in the wanted plane, and Down leads straight into the bone without it, too. Beside the line
        # the way back is said, and the lock permits only this way.
        w.wait_state("a saw that does not move", lambda s: s["time_s"] > 0.3 and s["saw_mm"] != [0, 0, 0])
        start = w.state["saw_mm"]
        w.hold("Next", 0.5)
        w.read()
        assert w.state["saw_mm"] == start, ("the lock holds", w.state)
        w.key("l")
        w.hold("Next", 1, lambda s: s["saw_mm"] != start)
        w.wait_state("the way is said", lambda s: "beside the line" in s.get("step", "") and "Page Up key" in s.get("step_way", ""))
        w.wait_state("the saw rests", lambda s: not s["holds"])
        time.sleep(1)  # a hand in air completes a short motion
        w.read()
        aside = w.state["saw_mm"]
        w.press("Down")
        w.wait_state("lower", lambda s: s["saw_mm"][2] < aside[2] - 0.5)
        w.release("Down")
        moved = [b - a for a, b in zip(aside, w.state["saw_mm"])]
        # The handle's friction may leave the last tenths of the motion before to this one.
        assert abs(moved[0]) < 0.35 and abs(moved[1]) < 0.35, (aside, w.state)
        w.key("l")
        w.hold("Next", 0.5)
        w.read()
        assert abs(w.state["saw_mm"][1] - aside[1]) < 0.35, ("not further away", w.state)
        w.press("Prior")
        w.wait_state("back in the plane", lambda s: abs(s["saw_mm"][1] - start[1]) < 0.35)
        w.release("Prior")
        w.key("r")
        # Keys that are pressed on the way are not for the saw.
        w.wait_state("back at the start", lambda s: not s["retracting"] and
                     max(abs(a - b) for a, b in zip(s["saw_mm"], start)) < 0.01)
        # A saw that is far from the cut, and perhaps out of the picture, is led back on every level.
        home = w.state["saw_mm"]
        w.press("shift", "Up")
        w.wait_state("the way back is said", lambda s: "away from the cut. Press R" in s.get("step", ""))
        w.release("Up", "shift")
        picture("far away")
        w.key("r")
        w.wait_state("back at the start", lambda s: "step" not in s and not s["retracting"] and
                     max(abs(a - b) for a, b in zip(s["saw_mm"], home)) < 0.01)
        w.wait_event("message", text="Retracted")
        w.key("l", "space")
        w.wait_state("the spindle turns", lambda s: s["spindle"])
        beside = w.state["saw_mm"][1]
        # Towards the viewer. Down leads straight into the bone, also without the lock.
        w.press("Next")
        w.wait_state("beside the line", lambda s: abs(s["saw_mm"][1] - beside) > 1.2)
        w.release("Next")
        w.press("Down")
        w.wait_state("in the bone, which is noticed", lambda s: "You leave the line" in s.get("coach", "") and s["removed_mm3"] > 0)
        assert w.state["way"].startswith("Lift the blade out first. Up key: up. Then move it over. Page"), w.state["way"]
        w.release("Down")
        picture("beside the line")
        # Leaving an attempt in which something was cut asks first; Escape goes on.
        w.key("Escape")
        w.wait_state("a question", lambda s: s["dialog"] and s["mode"] == "cutting")
        time.sleep(0.3)
        picture("leave")
        # Quitting asks too, also within the question.
        w.key("ctrl+q")
        time.sleep(0.5)
        w.wait_state("it asks", lambda s: s["dialog"] and s["mode"] == "cutting")
        w.key("Escape")
        w.wait_state("it goes on", lambda s: not s["dialog"] and s["mode"] == "cutting" and not s["spindle"])
        # Finishing asks, too, because too little is cut for a score. Enter answers nothing.
        w.key("Return", "Return")
        w.wait_state("a question", lambda s: s["dialog"] and s["mode"] == "cutting")
        time.sleep(0.3)
        picture("unfinished")
        w.click_item("answer 1")
        unfinished = w.wait_event("score", after=after)
        assert unfinished["total"] is None and "You cut beside the line" in unfinished["headline"], unfinished["headline"]
        assert unfinished["figures"][0] == "outside_mm3" and unfinished["nerve"] == "", unfinished
        assert (unfinished["next_exercise"], unfinished["next_level"]) == ("groove", 3), unfinished

        # Level 5 has no aids; an abandoned attempt is not scored.
        w.key("Escape")
        w.wait_state("the list again", lambda s: s["mode"] == "choosing")
        w.key("Return", "5")
        after = w.mark()
        w.wait_event("running", after=after)
        w.wait_state("level 5", lambda s: s["level"] == 5)
        time.sleep(0.5)
        picture("no aids")
        w.key("Escape")
        w.wait_state("the list again", lambda s: s["mode"] == "choosing")
        w.key("ctrl+q")
        code, out = w.wait_end()
        assert code == 0, out

        # All levels have the same bone, which is made once.
        bones = [e["bone_is_kept"] for e in w.events if e["event"] == "exercise"]
        assert bones == [False, True, True], bones

        # Without a name, attempts are stored as soon as one is entered. In German.
        settings = folder / "german/kerf/window.json"
        settings.parent.mkdir(parents=True)
        settings.write_text('{"language": "de"}')  # the tour was not shown yet
        named = ["practise", "-o", "out2", "--exercise", "groove"]
        w = Window(display, options.kerf, named, folder, dict(data, XDG_CONFIG_HOME=str(settings.parents[1])), title="kerf practise")
        w.wait_event("running")
        w.wait_state("the tour, without the step about the list", lambda s: s["mode"] == "cutting" and s["tour"] == 1)
        # The clock waits for the user.
        time.sleep(1)
        w.read()
        assert w.state["elapsed_s"] == 0 and w.state["time_s"] > 0.5, w.state
        w.key("ctrl+q")  # asks nothing: nothing was begun
        code, out = w.wait_end()
        assert code == 0, out
        assert "tour_shown" not in json.loads(settings.read_text())
        shutil.rmtree(folder / "out2")
        second = ["practise", "-o", "out2", "--size", f"{size[0]}x{size[1]}", "--scale", str(options.scale)]
        w = Window(display, options.kerf, second, folder, dict(data, XDG_CONFIG_HOME=str(settings.parents[1])), title="kerf practise")
        w.wait_state("the list of exercises", lambda s: s["mode"] == "choosing")
        # The tour begins by itself, has three steps, and is in the menu of help.
        w.wait_state("the tour", lambda s: s["tour"] == 1)
        time.sleep(0.5)
        picture("tour 1")  # after it, its buttons have been logged
        # What the next steps explain is not shown here: only an exercise leads on.
        w.wait_items("no next step", lambda items: "tour.skip" in items and "tour.next" not in items)
        w.click_item("tour.skip")
        w.wait_state("no tour", lambda s: s["tour"] == 0)
        assert json.loads(settings.read_text())["tour_shown"] is True
        w.choose("Help", "help.tour")
        w.wait_state("the tour again", lambda s: s["tour"] == 1)
        picture("tour again")
        # The tour goes on when an exercise is begun; Escape ends it first.
        w.click_item("exercise groove 3")
        w.wait_state("its second step", lambda s: s["tour"] == 2 and s["mode"] == "cutting")
        w.wait_event("running")
        # The spindle alone does not end the step about cutting.
        w.key("space")
        w.wait_state("the spindle", lambda s: s["spindle"])
        w.key("space")
        w.wait_state("still its second step", lambda s: not s["spindle"] and s["tour"] == 2)
        w.key("Escape")
        w.wait_state("no tour", lambda s: s["tour"] == 0 and s["mode"] == "cutting")
        w.key("Escape")
        w.wait_state("the list again", lambda s: s["mode"] == "choosing")
        time.sleep(0.5)
        picture("exercises without a name")
        after = w.mark()
        w.click_item("exercise groove 3")
        w.wait_event("running", after=after)
        w.wait_state("level 3", lambda s: s["level"] == 3 and s["mode"] == "cutting")
        w.key("space")
        w.wait_state("the spindle turns", lambda s: s["spindle"])
        w.press("Down")
        w.wait_state("in the bone", lambda s: s["removed_mm3"] > 0.2)
        w.release("Down")
        w.key("space", "Return")
        w.click_item("answer 1")  # although too little is cut for a score
        assert w.wait_event("score")["total"] is None
        time.sleep(0.5)
        picture("score without a name")
        w.click_item("practise.name")
        w.wait_state("a name is asked for", lambda s: s["entry"])
        time.sleep(0.3)
        # Spaces at the ends do not belong to the name.
        w.type(" Bea ")
        picture("name")
        w.key("Return")
        assert w.wait_event("student")["name"] == "Bea"
        w.click_item("practise.list")
        w.wait_state("the list again", lambda s: s["mode"] == "choosing" and "Bea" in s.get("menu", ""))
        time.sleep(0.3)
        picture("exercises of Bea")
        w.key("ctrl+q")
        code, out = w.wait_end()
        assert code == 0, out

        # The student of the last session goes on, with the scores.
        second[2] = "out3"
        w = Window(display, options.kerf, second, folder, dict(data, XDG_CONFIG_HOME=str(settings.parents[1])), title="kerf practise")
        w.wait_state("the list of Bea", lambda s: s["mode"] == "choosing" and "Bea" in s.get("menu", ""))
        # Another student is chosen from those who have attempts, the latest first.
        w.click_item("practise.name")
        w.wait_items("the students", lambda i: {"dialog.offered 1", "dialog.offered 2"} <= set(i))
        time.sleep(0.3)
        picture("students")
        after = w.mark()
        w.click_item("dialog.offered 2")
        assert w.wait_event("student", after=after)["name"] == "Ann"
        w.wait_state("the list of Ann", lambda s: "Ann" in s.get("menu", ""))
        w.key("ctrl+q")
        code, out = w.wait_end()
        assert code == 0, out

    env = dict(w.env, **data)
    def kerf(*arguments):
        done = subprocess.run([options.kerf, *arguments], cwd=folder, env=env, capture_output=True, text=True)
        assert done.returncode == 0, (arguments, done.stdout, done.stderr)
        return done.stdout

    # The recording alone gives the same numbers.
    assert json.loads(kerf("score", "out/session.kerf", "--json")) == score["sheet"]
    # The bone that was kept is that of the scene: the replay makes it again and compares the hash.
    assert "bit-identical" in kerf("replay", "out/session-2.kerf", "--verify")
    history = json.loads(kerf("practise", "--history", "--student", "Ann", "--json"))
    assert len(history) == 2 and abs(history[0]["total"] - score["total"]) < 1e-9, history
    named = json.loads(kerf("practise", "--history", "--student", "Bea", "--json"))
    assert len(named) == 1 and named[0]["level"] == 3, named
    assert history[1]["total"] is None and history[1]["incomplete"], history
    kerf("practise", "--report", "teacher.html")
    assert "Ann" in (folder / "teacher.html").read_text()
    if options.pictures:
        for name, file in kept:
            shutil.copy(file, f"{options.pictures}/practise_{name.replace(' ', '_')}.png")
    shutil.rmtree(folder)
    print(f"exercise completed: {score['total']:.1f} of 100, {len(kept)} pictures")


if __name__ == "__main__":
    main()
