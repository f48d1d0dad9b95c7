#!/usr/bin/env python3
"""Tests planning in the real window, with real keys and mouse: the tour, points that are moved, a plane's handles and
fields, marks on the bone and from files, undo of the plan, what still holds, the project, settings and the language.

    planning_test.py KERF [--pictures FOLDER]

--pictures: keeps the test's pictures. Exit code 77: the test was skipped; it prints the reason."""

import argparse
import json
import pathlib
import shutil
import time

from drive import NEXT_CLICK_S, Display, Window, workspace
from rehearse_test import SCENE

CENTRE = (785, 375)  # middle of the bone between the panels, pixels


def write_curve(file, points_mm):
    """Writes a curve as 3D Slicer does."""
    curve = {"type": "Curve", "coordinateSystem": "LPS",
             "controlPoints": [{"position": list(p), "positionStatus": "defined"} for p in points_mm]}
    file.write_text(json.dumps({"markups": [curve]}))


def write_mask(file, values):
    """Writes a label map around the bar, 0.5 mm, whose x axis points to the right: the voxels whose distance
    from the bar's middle line is at most 1.2 mm have one of the values in turn."""
    size = (80, 30, 30)
    head = ("NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\n"
            f"sizes: {' '.join(map(str, size))}\nspace directions: (-0.5,0,0) (0,0.5,0) (0,0,0.5)\n"
            "kinds: domain domain domain\nencoding: raw\nspace origin: (20,-7.5,-12.5)\n\n")
    voxels = bytearray()
    for k in range(size[2]):
        for j in range(size[1]):
            inside = (0.5 * j - 7.5)**2 + (0.5 * k - 7.5)**2 <= 1.2**2
            voxels += bytes(values[(i + 8 * j) % len(values)] if inside and 15 <= i < 65 else 0 for i in range(size[0]))
    file.write_bytes(head.encode() + voxels)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kerf")
    parser.add_argument("--pictures")
    options = parser.parse_args()
    folder = workspace()
    (folder / "bar.toml").write_text(SCENE)
    settings = folder / "config/kerf/window.json"
    settings.parent.mkdir(parents=True)
    settings.write_text('{"language": "en"}')  # the tour was not shown yet
    kept = []

    with Display(1480, 920) as display:
        w = Window(display, options.kerf, ["rehearse", "bar.toml", "-o", "out"], folder, title="kerf rehearse")

        def picture(name):
            kept.append((name, folder / w.picture()))

        w.wait_event("running")
        w.wait_event("first_picture")

        # The tour begins by itself, step by step, and can be skipped. It is not shown again.
        w.wait_state("the tour", lambda s: s["tour"] == 1)
        picture("tour")
        # Escape closes only what lies over the tour: a menu, the settings, the help.
        w.key("n")
        w.wait_state("the plan's menu", lambda s: s.get("menu") == "Plan")
        w.key("Escape")
        w.wait_state("no menu", lambda s: "menu" not in s and s["tour"] == 1)
        w.key("F10")
        w.wait_state("the settings", lambda s: s["settings"])
        w.key("Escape")
        w.wait_state("no settings", lambda s: not s["settings"] and s["tour"] == 1)
        w.key("F1")
        w.wait_state("the help", lambda s: s["help"])
        w.key("Escape")
        w.wait_state("no help", lambda s: not s["help"] and s["tour"] == 1)
        w.click_item("tour.next")
        w.wait_state("its second step", lambda s: s["tour"] == 2)
        w.click_item("tour.skip")
        w.wait_state("no tour", lambda s: s["tour"] == 0)
        assert json.loads(settings.read_text())["tour_shown"] is True

        # A plane through three points: a point is moved before the third one is set, and one is taken back.
        w.key("v")
        w.choose("Plan", "plan.three_points")
        w.wait_state("points are asked for", lambda s: s["placed"] == 0)
        for i, (x, y) in enumerate(((-120, -60), (-100, 60))):
            w.click(CENTRE[0] + x, CENTRE[1] + y)
            w.wait_state("a point", lambda s: s["placed"] == i + 1)
        w.drag((CENTRE[0] - 100, CENTRE[1] + 60), (CENTRE[0] - 60, CENTRE[1] + 80))
        w.key("BackSpace")
        w.wait_state("one point less", lambda s: s["placed"] == 1)
        for x, y in ((-60, 80), (-90, 0)):
            w.click(CENTRE[0] + x, CENTRE[1] + y)
        w.wait_state("two planes", lambda s: s["planes"] == 2 and s["placed"] == -1)
        # The new plane is selected, and as large as the bar there plus 4 mm on each side, so that its handles are in view.
        # The points lie on one face of the bar; its section by a plane that is not quite that face is at most 30 mm long.
        w.wait_state("its handles", lambda s: len(s["handles"]) == 8)
        assert max(w.state["plane_size_mm"][1]) < 42, w.state

        # A handle under the mouse says what it does.
        w.click_item("plane 1")
        w.wait_state("handles of the first plane", lambda s: s["plane"] == 0 and len(s["handles"]) == 8)
        w.wait_still("handles", still_s=1)
        w.move(*w.state["handles"][1])
        w.wait_state("the arrow's handle", lambda s: s["handle"] == 1)
        w.move(CENTRE[0], CENTRE[1] + 250)
        w.wait_state("no handle", lambda s: s["handle"] == -1)

        # The plane of the scene is moved along its normal, which is x, by a handle. Undo brings it back.
        w.click_item("plane 1")
        w.wait_state("handles of the first plane", lambda s: s["plane"] == 0 and len(s["handles"]) == 8)
        w.wait_still("handles", still_s=2)  # until it is drawn, even on a slow machine
        before = w.state["plane_mm"][0]
        at = w.state["handles"][1]
        w.drag(at, (at[0] + 60, at[1]))
        w.wait_state("the plane is moved", lambda s: s["plane_mm"][0][0] > before[0] + 0.5)
        moved = w.wait_still("plane_mm", still_s=2)[0]
        assert moved[1:] == before[1:], (before, moved)
        picture("handles")
        w.key("shift+Z")
        w.wait_state("undone", lambda s: s["plane_mm"][0] == before)
        w.key("shift+Y")
        w.wait_state("redone", lambda s: s["plane_mm"][0] == moved)
        w.key("shift+Z")
        w.wait_state("undone", lambda s: s["plane_mm"][0] == before)

        # A field in mm sets the same.
        w.click_item("plane.fields")
        w.click_item("plane.x")
        w.key("ctrl+a")
        w.type("2.5")
        w.key("Return")
        w.wait_state("moved to 2.5 mm", lambda s: s["plane_mm"][0][0] == 2.5)
        # A value far from the bone is refused with a sentence.
        after = w.mark()
        w.click_item("plane.z")
        w.key("ctrl+a")
        w.type("99999")
        w.key("Return")
        w.wait_message("too far away from the bone", after=after)
        assert w.state["plane_mm"][0] == [2.5, *before[1:]], w.state
        w.choose("Plan", "plan.undo")
        w.wait_state("undone", lambda s: s["plane_mm"][0] == before)

        # Tab takes the number and goes to the next field, Shift+Tab back. The letters after it are for the next field. Each
        # field turns the plane about one of its own axes and is 0 again, and no angle is refused.
        angles = [0, 90, 90]  # to the sagittal, the coronal and the axial plane
        w.wait_state("the plane is perpendicular to x", lambda s: s["plane_deg"][0] == angles)
        turned = [90, 60, 30]
        w.click_item("plane.turn_width")
        w.type("90\t30")
        w.key("Tab")  # GLFW takes a key that is pressed twice in the same millisecond for a duplicate
        w.wait_state("both turns", lambda s: s["plane_deg"][0] == turned)
        w.key("shift+Tab", "shift+Tab")
        w.type("340")
        w.key("Return")
        w.wait_state("another turn", lambda s: s["plane_deg"][0] not in (angles, turned))
        last = w.state["plane_deg"][0]
        # Escape discards what was typed.
        w.click_item("plane.turn_width")
        w.type("30")
        w.key("Escape")
        # A turn about the normal leaves the plane where it is.
        w.click_item("plane.turn_normal")
        w.type("15")
        w.key("Return")
        time.sleep(0.5)  # the field gives the keys back in one of the next frames
        assert w.wait_still("plane_deg", still_s=0.5)[0] == last, w.state
        w.click_item("plane.coronal")
        w.wait_state("it is coronal", lambda s: s["plane_deg"][0] == [90, 0, 90])
        for expected in (last, last, turned, [90, 90, 0], angles):
            w.key("shift+Z")
            w.wait_state("undone", lambda s: s["plane_deg"][0] == expected)
        w.wait_state("where it was", lambda s: s["plane_mm"][0] == before)

        # The wheel over a slice scrolls the slice, and not the column; beside the slices it scrolls the column.
        left, top, width, height = w.items["slice 1"]
        w.scroll(left + width / 2, top + height / 2, 3)
        w.wait_state("the first slice is scrolled", lambda s: s["slices_mm"] == [1.5, 0, 0])
        assert w.items["slice 1"] == [left, top, width, height], w.items["slice 1"]

        # While a structure is marked, a click in a slice sets a point. A double click only enlarges the slice, and what
        # the user is asked stays visible above it.
        w.choose("Plan", "mark.nerve")
        w.wait_state("points are asked for", lambda s: s["placed"] == 0)
        w.click_item("slice 1")
        w.wait_state("a point", lambda s: s["placed"] == 1)
        time.sleep(NEXT_CLICK_S)
        for enlarged in (True, False):
            left, top, width, height = w.items["slice 2"]
            w.click(left + 0.6 * width, top + 0.4 * height, times=2)
            w.wait_state("enlarged or not", lambda s: s["slice_enlarged"] == enlarged)
            assert w.wait_still("placed", still_s=0.5) == 1
            if enlarged:
                w.wait_items("a larger slice", lambda items: items["slice 2"][2] > 1.5 * width)
                banner = w.items["banner"]
                assert banner[1] + banner[3] < w.items["slice 2"][1], w.items
                picture("enlarged_slice")
        w.key("Escape")
        w.wait_state("nothing is asked for", lambda s: s["placed"] == -1)

        # The other plane is removed, mirrored ones have a name of their own.
        w.choose("Plan", "plan.mirror")
        w.wait_state("a mirrored plane", lambda s: s["planes"] == 3)
        for count in (2, 1):
            w.click_item(f"plane {count + 1}")
            w.wait_state("it is selected", lambda s: s["plane"] == count)
            w.choose("Plan", "plan.remove")
            w.wait_state("a plane less", lambda s: s["planes"] == count)

        # A nerve is marked by clicks on the bone; its distance is then known.
        w.choose("Plan", "mark.nerve")
        w.wait_state("points are asked for", lambda s: s["placed"] == 0)
        for i, x in enumerate((-250, -150, 150, 250)):
            w.click(CENTRE[0] + x, CENTRE[1] + 100)
            w.wait_state("a point", lambda s: s["placed"] == i + 1)
        # A slice that is enlarged for it does not hide the scene afterwards.
        left, top, width, height = w.items["slice 2"]
        w.click(left + 0.6 * width, top + 0.4 * height, times=2)
        w.wait_state("enlarged", lambda s: s["slice_enlarged"] and s["placed"] == 4)
        w.scroll(*CENTRE, 3)
        w.wait_state("scrolled", lambda s: s["slices_mm"][1] == 1.5)
        w.key("Return")
        w.wait_state("a mark", lambda s: s["marks"] == 1 and not s["slice_enlarged"])
        # The slices go through the saw again; one that is scrolled after that has a button that brings it back.
        w.wait_state("no slice is scrolled", lambda s: s["slices_mm"] == [0, 0, 0])
        w.wait_items("the slice is small again", lambda items: items["slice 2"] == [left, top, width, height])
        w.scroll(left + width / 2, top + height / 2, 3)
        w.wait_state("scrolled", lambda s: s["slices_mm"] == [0, 1.5, 0])
        picture("scrolled")
        w.click_item("slice 2 back")
        w.wait_state("back", lambda s: s["slices_mm"] == [0, 0, 0])
        picture("mark")

        # Marks come from a file of 3D Slicer and from a mask; each file is one step of undo.
        write_curve(folder / "tooth.mrk.json", [(-8, 0, -2), (-8, 0, -5), (-8, 1, -8)])
        write_curve(folder / "far.mrk.json", [(0, 0, 0), (0, 0, 90)])
        write_mask(folder / "mask.nrrd", [1])
        write_mask(folder / "ct.nrrd", range(1, 81))

        def import_marks(name):
            w.choose("Plan", "mark.import")
            w.wait_state("it asks for a file", lambda s: s["dialog"])
            w.type(name)
            w.key("Return")

        import_marks("tooth.mrk.json")
        w.wait_state("a mark more", lambda s: s["marks"] == 2 and not s["dialog"])
        after = w.mark()
        import_marks("mask.nrrd")
        w.wait_state("it asks what it is", lambda s: s["dialog"])
        w.click_item("answer 1")  # a tube: a nerve
        w.wait_state("a mark more", lambda s: s["marks"] == 3 and not s["dialog"])
        w.wait_message("One mark was imported from mask.nrrd", after=after)
        picture("imported")
        for name, reason in (("far.mrk.json", "outside of the bone"), ("ct.nrrd", "looks like a CT")):
            after = w.mark()
            import_marks(name)
            assert reason in w.wait_event("marks_refused", after=after)["why"]
            w.wait_state("it says so", lambda s: s["dialog"])
            w.key("Return")
            w.wait_state("no dialog", lambda s: not s["dialog"])
        w.key("shift+Z")
        w.wait_state("undone", lambda s: s["marks"] == 2)
        w.key("shift+Z")
        w.wait_state("undone", lambda s: s["marks"] == 1)
        # Open takes such a file too.
        w.key("ctrl+o")
        w.wait_state("it asks for a file", lambda s: s["dialog"])
        w.type("tooth.mrk.json")
        w.key("Return")
        w.wait_state("a mark more", lambda s: s["marks"] == 2 and not s["dialog"])
        w.key("shift+Z")
        w.wait_state("undone", lambda s: s["marks"] == 1)

        # After half of the cut, the plan says how much is cut, and the picture where it still holds.
        w.click_item("plane 1")
        w.wait_state("it is selected", lambda s: s["plane"] == 0)
        w.key("l", "space")
        w.wait_state("the spindle turns", lambda s: s["spindle"])
        w.key(*["bracketleft"] * 6)  # at 1 mm/s, a saw that a busy machine stops seconds too late is not through
        w.press("Down")
        w.wait_state("half through", lambda s: s["saw_mm"][2] < 8)
        w.release("Down")
        w.key("space")
        w.wait_state("partly cut", lambda s: s["plane_cut"] and 0.1 < s["plane_cut"][0] < 0.9)
        time.sleep(0.5)
        picture("bridges")

        # A project keeps it all.
        w.key("ctrl+s")
        w.wait_state("it asks where", lambda s: s["dialog"])
        w.key("Return")
        project = pathlib.Path(w.wait_event("project")["file"])

        # Settings: dark, larger text, German.
        w.key("F10")
        w.click_item("setting dark")
        w.wait_event("settings", theme="dark")
        w.click_item("setting language de")
        w.wait_event("settings", language="de")
        w.click_item("setting text 120")
        w.wait_event("settings", text_size=1.2)
        w.key("Escape")
        time.sleep(0.5)
        picture("german")

        # Quitting asks while something is not saved, and Escape stays.
        after = w.mark()
        w.choose("Plan", "plan.at_blade")
        w.wait_event("plan", after=after)
        w.key("ctrl+q")
        w.wait_state("a question", lambda s: s["dialog"])
        w.key("Escape")
        w.wait_state("it stays", lambda s: not s["dialog"])
        w.key("ctrl+q")
        w.wait_state("a question", lambda s: s["dialog"])
        w.click_item("answer 2")
        code, out = w.wait_end()
        assert code == 0, out

        # The settings and the project are there at the next start. The saved plan has one plane.
        # In a small window with large text, a menu has the buttons for which there is no room, and a message says why there
        # are no slices; without the side panel, there is room for them.
        settings.write_text(json.dumps({**json.loads(settings.read_text()), "text_size": 1.5}))
        w = Window(display, options.kerf, ["rehearse", str(project), "-o", "again", "--size", "1024x768"], folder,
                   title="kerf rehearse")
        w.wait_event("running")
        w.wait_message("Für die Schichten ist kein Platz")
        w.click_item("button more")
        w.wait_items("the last button", lambda items: "button help.keys" in items)
        picture("small")
        w.key("Escape")
        assert "slice 1" not in w.items, w.items
        w.key("F4")
        w.click_item("slice 1")
        w.key("F4")
        w.wait_state("the plan and the mark", lambda s: s["planes"] == 1 and s["marks"] == 1 and s["tour"] == 0)
        w.wait_state("what was cut", lambda s: s["plane_cut"] and 0.1 < s["plane_cut"][0] < 0.9)
        w.key("ctrl+q")
        code, out = w.wait_end()
        assert code == 0, out

    if options.pictures:
        for name, file in kept:
            shutil.copy(file, f"{options.pictures}/planning_{name}.png")
    shutil.rmtree(folder)
    print("planning completed:", len(kept), "pictures")


if __name__ == "__main__":
    main()
