#!/usr/bin/env python3
"""Tests the control of the saw in the real window, with real keys and mouse: the saw stops when the user lets go of it,
undo and redo bring it back out of the bone, and it can be retracted from any place.

    control_test.py KERF

Exit code 77: the test was skipped; it prints the reason."""

import shutil
import subprocess
import sys
import time

from drive import Display, Window, workspace
from rehearse_test import SCENE

# What a saw may do after the tick in which the hand let go of it: the coupling relaxes, and the force that held it is
# gone. A blade of 0.5 mm removes 5 mm3 per mm from a bar of 10 mm.
RELAX_MM = 0.4
RELAX_MM3 = 2
# In air, the hand completes at most 1 mm of the motion. On a busy machine the mouse may be released when the bar is cut
# through.
COAST_MM = 1.1
FORCE_N = 0.3  # what friction in the kerf may hold
# From then on nothing may change. The log rounds to 0.1.
REST_MM = 0.11
REST_MM3 = 0.11


def start(display, kerf, scene=SCENE):
    folder = workspace()
    (folder / "bar.toml").write_text(scene)
    w = Window(display, kerf, ["rehearse", "bar.toml", "-o", "out"], folder, title="kerf rehearse")
    w.wait_event("running")
    w.wait_event("first_picture")
    w.key("v")  # from the front: down in the picture is down in the bone
    w.key("bracketleft", "bracketleft", "bracketleft")  # keys move the saw at 2 mm/s
    return w, folder


def end(w, kerf, folder):
    w.quit()
    code, out = w.wait_end()
    assert code == 0, out
    done = subprocess.run([kerf, "replay", "out/session.kerf", "--verify"], cwd=folder, capture_output=True, text=True)
    assert done.returncode == 0 and "bit-identical to the recording" in done.stdout, (done.stdout, done.stderr)
    shutil.rmtree(folder)


def spindle(w, on):
    if w.state["spindle"] != on:
        w.key("space")
        w.wait_state("the spindle", lambda s: s["spindle"] == on and (s["rpm"] != 0) == on)


def begin_drag(w, at, by):
    w.begin_drag(at, (at[0] + by[0], at[1] + by[1]), steps=10)


def check_stays(w, what, seconds=2, relax_mm=RELAX_MM, wedged=False):
    """Checks that the saw neither moves nor cuts after it was let go. `wedged`: it turns in a kerf that it does not fit
    into, so that friction drives it, and the hand holds it against that."""
    released = w.wait_state("let go", lambda s: not s["holds"] and "released" in s)["released"]

    def changes(before):
        w.read()
        moved = max(abs(a - b) for a, b in zip(w.state["saw_mm"], before["saw_mm"]))
        return moved, w.state["removed_mm3"] - before["removed_mm3"]

    time.sleep(1.5)  # the state is logged when it changes
    moved, cut = changes(released)
    in_air = moved <= COAST_MM and cut <= REST_MM3
    assert in_air or (moved <= relax_mm and cut <= RELAX_MM3), (what, moved, cut, released, w.state)
    rest = dict(w.state)
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        time.sleep(0.1)
        moved, cut = changes(rest)
        assert moved <= REST_MM and cut <= REST_MM3, (what, moved, cut, rest, w.state)
    assert wedged or w.state["force_N"] <= FORCE_N, (what, w.state)
    assert not w.state["holds"], (what, w.state)


def move_beside(w, by_mm):
    x = w.state["saw_mm"][0]
    w.press("Right")
    w.wait_state(f"{by_mm} mm beside", lambda s: s["saw_mm"][0] > x + by_mm)
    w.release("Right")


def test_release(display, kerf):
    w, folder = start(display, kerf)
    centre = (640, 360)
    depth = lambda s: 11 - s["saw_mm"][2]
    for lock in (False, True):
        if lock:
            move_beside(w, 2)  # into whole bone: in the first kerf the saw would coast
            w.key("l")
        spindle(w, True)
        begin_drag(w, centre, (0, 250))
        w.wait_state("2.5 mm deep", lambda s: depth(s) > 2.5)
        w.input.release_button(1)
        check_stays(w, f"mouse released, lock {lock}")
        # The next drag begins where the saw is, not where the handle was.
        begin_drag(w, centre, (0, -40))
        time.sleep(0.5)
        w.read()
        w.input.release_button(1)
        # With several keys, the last one counts.
        w.press("Down", "Right")
        now = depth(w.state)
        w.wait_state("deeper", lambda s: depth(s) > max(now, 2.5) + 0.5)
        w.release("Right")
        now = depth(w.state)
        w.wait_state("still moving", lambda s: depth(s) > now + 0.3)
        w.release("Down")
        check_stays(w, "keys released")
        w.press("ctrl")
        begin_drag(w, centre, (10, 5))
        time.sleep(0.7)  # the hand turns about its grip, which is far from the blade
        w.input.release_button(1)
        w.release("ctrl")
        # A blade that was wedged in its kerf may spring out of it.
        check_stays(w, "rotation released", relax_mm=11, wedged=True)
        # Without the spindle, nothing drives it, and all of the force is let go.
        spindle(w, False)
        w.wait_state("no force", lambda s: s["force_N"] <= FORCE_N)
        w.key("r")
        # Keys that are pressed on the way are not for the saw.
        w.wait_state("out of the bone", lambda s: not s["retracting"] and s["saw_mm"][2] > 12.5)
    end(w, kerf, folder)


def cut_to(w, depth_mm):
    spindle(w, True)
    w.press("Down")
    w.wait_state(f"{depth_mm} mm deep", lambda s: 11 - s["saw_mm"][2] > depth_mm)
    w.release("Down")
    return w.wait_still("saw_mm", still_s=0.5)


def is_at(w, place, tolerance=0.25):
    return lambda s: all(abs(a - b) <= tolerance for a, b in zip(s["saw_mm"], place))


def answered(w, what, after):
    answer = w.wait_event("answer", after=after, what=what)
    assert answer["failure"] == "", answer


def test_undo(display, kerf):
    w, folder = start(display, kerf)
    begin = list(w.wait_still("saw_mm", still_s=0.5))
    deep = list(cut_to(w, 4))
    removed = w.state["removed_mm3"]
    assert removed > 5

    # Undo with the saw deep in the bone and the spindle on, and the key to move it still held: the last stroke is undone,
    # so the saw is where the one before ended. Without that one it is at the start, clear of the bone by 2 mm, and does
    # not cut on any way through air.
    w.press("Down")
    w.wait_state("another stroke", lambda s: s["removed_mm3"] > removed + 2)
    after = w.mark()
    w.key("ctrl+z")
    answered(w, "Undone", after)
    w.release("Down")
    w.wait_state("back at the end of the first stroke", is_at(w, deep))
    w.wait_message("are bone again", after=after)
    after = w.mark()
    w.key("ctrl+z")
    answered(w, "Undone", after)
    w.wait_state("back at the start", is_at(w, begin))
    assert not w.state["spindle"]
    removed = w.state["removed_mm3"]
    w.press("Right")
    w.wait_state("moved", lambda s: s["saw_mm"][0] > begin[0] + 2)
    w.release("Right")
    assert w.state["force_N"] == 0 and w.state["removed_mm3"] == removed, w.state

    # Redo brings it into its kerf again, and a checkpoint there is a place to return to.
    after = w.mark()
    w.key("ctrl+y")
    answered(w, "Redone", after)
    w.wait_state("back in the kerf", is_at(w, deep))
    assert w.state["removed_mm3"] == removed
    after = w.mark()
    w.key("c")
    w.wait_state("it asks for a name", lambda s: s["entry"])
    w.key("Return")
    answered(w, "Checkpoint", after)
    cut_to(w, 6)
    removed = w.state["removed_mm3"]
    after = w.mark()
    w.key("b", "1")
    answered(w, "Undone", after)
    w.wait_state("back at the checkpoint", is_at(w, deep))
    check_stays(w, "at the checkpoint")

    # From deep in the kerf, the saw is retracted along the way it came in.
    after = w.mark()
    w.key("r")
    answered(w, "Retracted", after)
    w.wait_state("at the start", is_at(w, begin, 0.8))
    assert w.state["removed_mm3"] == removed, (removed, w.state)
    end(w, kerf, folder)

    # A saw that is buried in bone is taken out as well.
    w, folder = start(display, kerf, SCENE.replace("[0.0, 0.0, 13.0]", "[0.0, 0.0, 7.0]").replace("[0.0, 0.0, 12.0]", "[0.0, 0.0, 6.0]"))
    begin = list(w.wait_still("saw_mm", still_s=0.5))
    assert begin[2] < 7.5, begin
    removed = w.state["removed_mm3"]  # not 0: the spindle turns until the first action of the session stops it
    after = w.mark()
    w.key("r")
    answered(w, "Retracted", after)
    assert w.wait_state("out", lambda s: s["saw_mm"][2] > 11)["removed_mm3"] == removed
    end(w, kerf, folder)


def test_seen(display, kerf):
    """A saw that was dragged out of the picture comes back into it, and clicks while it is changed are not lost."""
    w, folder = start(display, kerf)
    w.key("v")  # the blade is seen from its side

    def is_seen(s):  # at least its lower edge is: the saw begins above the bone, at the edge of the picture
        left, top, width, height = s["scene_px"]
        saw_left, saw_top, saw_width, saw_height = s["saw_px"]
        return (left < saw_left + saw_width - 50 and saw_left + 50 < left + width and top < saw_top + saw_height - 50
                and saw_top + 50 < top + height)

    assert is_seen(w.state), w.state
    for _ in range(3):
        w.drag((640, 360), (1240, 40), steps=30)
        w.wait_still("saw_mm", still_s=0.5)
    assert not is_seen(w.state), w.state
    after = w.mark()
    w.key("Tab")
    # While the saw is changed, the panel stays, and the toolbar takes clicks.
    w.click_item("button saw.spindle")
    w.wait_event("running", after=after)
    w.wait_state("the spindle, as was clicked", lambda s: s["spindle"])
    w.key("space")
    w.wait_state("off", lambda s: not s["spindle"])
    after = w.mark()
    w.key("r")
    answered(w, "Retracted", after)
    w.wait_state("seen again", is_seen)
    assert w.state["removed_mm3"] == 0, w.state
    end(w, kerf, folder)


def test_held(display, kerf):
    """A saw that does not follow says why, until it follows or is let go."""
    w, folder = start(display, kerf)
    cut_to(w, 4)
    begin_drag(w, (640, 360), (120, 0))  # across the blade
    w.wait_state("it binds", lambda s: "binds sideways" in s["held"])
    w.input.release_button(1)
    w.wait_state("let go", lambda s: s["held"] == "")
    spindle(w, False)
    begin_drag(w, (640, 360), (0, 150))
    w.wait_state("the spindle is off", lambda s: "spindle is off" in s["held"])
    w.input.release_button(1)
    w.wait_state("let go", lambda s: s["held"] == "")
    w.key("u")
    w.wait_message("The sound is off.")
    w.key("minus")
    w.wait_message("The volume is 40 %.")
    end(w, kerf, folder)


def test_guide(display, kerf):
    """The saw turns into a plane although the guide is switched on meanwhile, and the guide follows the selected plane."""
    second = "\n".join(("[[plan.plane]]", 'name = "second"', "point_mm = [-5.0, 0.0, -5.0]", "normal = [1.0, 0.0, 0.0]",
                        "margin_mm = 0.5", "[[path.stroke]]"))
    scene = SCENE.replace("[[path.stroke]]", second).replace("[0.0, 0.0, 13.0]", "[9.0, 0.0, 13.0]")
    scene = scene.replace("[0.0, 0.0, 12.0]", "[9.0, 0.0, 12.0]")
    w, folder = start(display, kerf, scene)

    def beside(x_mm):
        return lambda s: abs(s["saw_mm"][0] - x_mm) <= 0.3

    w.wait_state("beside the plane", beside(9))
    after = w.mark()
    w.choose("Plan", "plan.align")
    w.key("g")
    w.wait_event("running", after=after)
    w.wait_state("in the plane, with the guide", lambda s: s["guided"] and beside(0)(s))

    # The other plane is selected, with the saw clear of the bone.
    after = w.mark()
    w.choose("Plan", "plan.next")
    w.wait_event("running", after=after)
    w.wait_message("The guide now follows second", after=after)
    w.choose("Plan", "plan.align")
    w.wait_state("in the second plane", beside(-5))
    assert w.state["guided"] and w.state["plane"] == 1, w.state

    # With the saw in the bone, the guide stays, and follows when the saw is clear of it.
    w.key("l")
    cut_to(w, 1.5)
    spindle(w, False)
    removed = w.state["removed_mm3"]
    after = w.mark()
    w.choose("Plan", "plan.next")
    w.wait_message("The saw is in the bone", after=after)
    assert w.wait_still("plane", still_s=1) == 0 and w.state["removed_mm3"] == removed, w.state
    assert not any(e["event"] == "running" for e in w.events[after:]), w.events[after:]
    w.key("r")
    w.wait_event("running", after=after)
    w.wait_message("The guide now follows cut", after=after)
    w.choose("Plan", "plan.align")
    w.wait_state("in the first plane", beside(0))
    end(w, kerf, folder)


def test_turn(display, kerf):
    """A saw beside the bone turns into a plane that it could not reach at its height; one in the plane stays."""
    # The rim of the disc is 1 mm below the bar's top, beside its end; the plane is in the bar.
    scene = SCENE.replace("[0.0, 0.0, 13.0]", "[16.0, 0.0, 10.0]").replace("[0.0, 0.0, 12.0]", "[16.0, 0.0, 9.0]")
    w, folder = start(display, kerf, scene)
    w.wait_state("beside the bar", lambda s: s["saw_mm"][2] < 10.5)
    after = w.mark()
    w.key("shift+g", "space")
    w.wait_state("in the plane, clear of the bar, turning",
                 lambda s: abs(s["saw_mm"][0]) <= 0.3 and s["saw_mm"][2] > 11 and s["spindle"])
    assert w.state["removed_mm3"] == 0, w.state
    spindle(w, False)
    at = w.state["saw_mm"]
    w.key("shift+g")
    w.wait_message("The saw lies in cut already", after=after)
    assert w.state["saw_mm"] == at, w.state
    end(w, kerf, folder)

    # A turning saw is stopped first: it cuts nothing on its way.
    w, folder = start(display, kerf, scene)
    w.wait_state("beside the bar", lambda s: s["saw_mm"][2] < 10.5)
    spindle(w, True)
    after = w.mark()
    w.key("shift+g")
    w.wait_message("The spindle is stopped. The saw is turning into cut", after=after)
    w.wait_state("in the plane, clear of the bar", lambda s: abs(s["saw_mm"][0]) <= 0.3 and s["saw_mm"][2] > 11 and not s["turning"])
    assert w.state["removed_mm3"] == 0 and not w.state["spindle"], w.state
    end(w, kerf, folder)


def main():
    kerf = sys.argv[1]
    with Display() as display:
        test_release(display, kerf)
        test_undo(display, kerf)
        test_seen(display, kerf)
        test_held(display, kerf)
        test_guide(display, kerf)
        test_turn(display, kerf)
    print("released, undone and retracted")


if __name__ == "__main__":
    main()
