#!/usr/bin/env python3
"""Tests in the real window that the saw is not lost outside the picture, that it is brought back undisturbed, and that the
guide and the spindle wait until it has turned into the plane.

    saw_in_view_test.py KERF

Exit code 77: the test was skipped; it prints the reason."""

import sys

from drive import Display, Window, workspace
from rehearse_test import SCENE

# The saw begins turned out of the plane by 35 degrees, in air.
TURNED = SCENE.replace("disc_normal = [1.0, 0.0, 0.0]", "disc_normal = [0.82, 0.57, 0.0]").replace(
    "start_mm = [0.0, 0.0, 13.0]", "start_mm = [4.0, 0.0, 20.0]").replace("end_mm = [0.0, 0.0, 12.0]",
                                                                         "end_mm = [4.0, 0.0, 19.0]")


def lose_and_bring_back(w):
    w.key("v")
    assert not w.state["saw_outside"]
    # The view is shifted until the saw is outside.
    for _ in range(12):
        if w.state["saw_outside"]:
            break
        w.drag((500, 200), (500, 640), button=2)
        w.read()
    w.wait_state("the saw is outside", lambda s: s["saw_outside"])
    after = w.mark()
    w.input.tap("r", "ctrl+z", "space")  # at once: the way back may be short
    w.wait_message("Bringing the saw back", after=after)
    w.wait_event("answer", what="Retracted", failure="", after=after)
    w.wait_state("the saw is seen", lambda s: not s["saw_outside"] and not s["retracting"])
    there = w.wait_still("saw_mm", still_s=1)
    assert not any(e["event"] == "answer" and e["what"] == "Undone" for e in w.events[after:]), w.events[after:]
    assert not w.state["spindle"], "the spindle was not started on the way"
    return there


def turn_then_guide_then_cut(w):
    after = w.mark()
    w.key("shift+G", "g", "space")
    w.wait_state("the spindle turns, with the guide", lambda s: s["guided"] and s["spindle"])
    w.read()
    order = [e for e in w.events[after:] if e["event"] in ("session", "spindle")]
    assert order[0]["event"] == "session", "the guide's session begins before the spindle"
    # The guide began in the plane, so there is nothing to warn of.
    assert not any("beside the planned plane" in e.get("text", "") for e in w.events[after:]), w.events[after:]
    assert abs(w.state["saw_mm"][0]) < 0.6, w.state["saw_mm"]
    w.key("space")
    w.wait_state("the spindle stops", lambda s: not s["spindle"])


def main():
    folder = workspace()
    (folder / "bar.toml").write_text(TURNED)
    with Display() as display:
        w = Window(display, sys.argv[1], ["rehearse", "bar.toml", "-o", "out"], folder, title="kerf rehearse")
        w.wait_event("running")
        w.wait_event("first_picture")
        turn_then_guide_then_cut(w)
        lose_and_bring_back(w)
        w.quit()
        code, out = w.wait_end()
        assert code == 0, (code, out)
    print("ok")


if __name__ == "__main__":
    main()
