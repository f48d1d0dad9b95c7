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

from drive import Display, Window, skip_without_display_programs, workspace


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kerf")
    parser.add_argument("--pictures")
    parser.add_argument("--scale", type=int, default=1)
    options = parser.parse_args()
    skip_without_display_programs()
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
        w.key("Return")
        w.wait_event("running")
        w.wait_event("first_picture")
        assert w.state["exercise"] == "groove"

        # The saw moves down to the depth at which the stop of level 1 holds it, along the line of 16 mm, and up and
        # out.
        w.key("bracketleft", "bracketleft")
        w.key("space")
        w.wait_state("the spindle turns", lambda s: s["spindle"])
        start = w.state["saw_mm"][0]
        w._xdotool("keydown", "Down")
        w.wait_state("deep enough", lambda s: s.get("to_goal_mm", 9) < 0.15, 60)
        time.sleep(0.3)
        picture("goal")
        w._xdotool("keyup", "Down")
        w._xdotool("keydown", "Right")
        w.wait_state("along the line", lambda s: abs(s["saw_mm"][0] - start) > 8, 60)
        picture("along")
        w.wait_state("to its end", lambda s: abs(s["saw_mm"][0] - start) > 15.6, 60)
        w._xdotool("keyup", "Right")
        deepest = w.state["depth_mm"]
        assert deepest < 2.5, ("the stop holds", w.state)
        w._xdotool("keydown", "shift", "keydown", "Up")
        w.wait_state("out", lambda s: s.get("depth_mm", 1) < 0 or "depth_mm" not in s, 60)
        w._xdotool("keyup", "Up", "keyup", "shift")
        w.key("space", "Return")
        score = w.wait_event("score", seconds=120)
        assert score["total"] > 50, score
        time.sleep(0.5)
        picture("score")

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

    env = dict(w.env, **data)
    def kerf(*arguments):
        done = subprocess.run([options.kerf, *arguments], cwd=folder, env=env, capture_output=True, text=True)
        assert done.returncode == 0, (arguments, done.stdout, done.stderr)
        return done.stdout

    # The recording alone gives the same numbers.
    assert json.loads(kerf("score", "out/session.kerf", "--json")) == score["sheet"]
    history = json.loads(kerf("practise", "--history", "--student", "Ann", "--json"))
    assert len(history) == 1 and abs(history[0]["total"] - score["total"]) < 1e-9, history
    kerf("practise", "--report", "teacher.html")
    assert "Ann" in (folder / "teacher.html").read_text()
    if options.pictures:
        for name, file in kept:
            shutil.copy(file, f"{options.pictures}/practise_{name.replace(' ', '_')}.png")
    shutil.rmtree(folder)
    print(f"exercise completed: {score['total']:.1f} of 100, {len(kept)} pictures")


if __name__ == "__main__":
    main()
