#!/usr/bin/env python3
"""Tests in the real window that an injured structure stays named until the cut is undone, and after its project was opened
again.

    injury_test.py KERF [--pictures FOLDER]

Exit code 77: the test was skipped; it prints the reason."""

import argparse
import pathlib
import shutil

from drive import Display, Window, workspace
from rehearse_test import SCENE

# From its top, the bar is cortical to 1 mm, tooth to 2 mm, cancellous to 8 mm, nerve canal to 9 mm, and then cancellous:
# a saw that a busy machine stops seconds too late has not reached the nerve.
LAYERS = ((1, 24), (1, 33), (6, 32), (1, 34), (1, 32))
BAR = SCENE[:SCENE.index("[[bone.block.layer]]")] + "".join(
    f"[[bone.block.layer]]\nthickness_mm = {thickness}.0\nregion = {region}\n" for thickness, region in LAYERS
) + SCENE[SCENE.index("[tool]"):]


def cut_to(w, depth_mm):
    if not w.state["spindle"]:
        w.key("space")
        w.wait_state("the spindle turns", lambda s: s["spindle"] and s["rpm"] != 0)
    w.press("Down")
    w.wait_state(f"{depth_mm} mm deep", lambda s: 11 - s["saw_mm"][2] > depth_mm)
    w.release("Down")
    w.key("space")
    w.wait_state("the spindle stands", lambda s: not s["spindle"])


def wait_injuries(w, what, names):
    """Waits until exactly the structures with these names are injured; `names`: beginnings of their sentences."""

    def same(state):
        injuries = state["injuries"]
        return len(injuries) == len(names) and all(text.startswith(name) for text, name in zip(injuries, names))

    w.wait_state(what, same)
    # They are shown as long as there are any.
    w.wait_items("the sign", lambda items: ("injuries" in items) == bool(names))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kerf")
    parser.add_argument("--pictures")
    options = parser.parse_args()
    folder = workspace()
    (folder / "bar.toml").write_text(BAR)

    def picture(w, name):
        if options.pictures:
            shutil.copy(folder / w.picture(), pathlib.Path(options.pictures) / f"{name}.png")

    with Display() as display:
        w = Window(display, options.kerf, ["rehearse", "bar.toml", "-o", "out"], folder, title="kerf rehearse")
        w.wait_event("running")
        w.wait_event("first_picture")
        w.key("v", "l")  # from the front, in the blade's plane: down in the picture is down in the bone
        # Keys move the saw at 1 mm/s.
        w.key(*["bracketleft"] * 6)
        wait_injuries(w, "nothing is injured", [])

        # A little of the tooth is cut: about 0.2 mm of its depth.
        cut_to(w, 1.2)
        tooth = "Row of touching teeth, on both sides: cut"
        wait_injuries(w, "the tooth", [tooth])
        picture(w, "tooth")
        # The saw leaves it, and it is still named.
        w.key("r")
        # Until it is there, undo is refused.
        w.wait_event("answer", what="Retracted", failure="")
        w.wait_state("clear of the bone", lambda s: s["saw_mm"][2] > 12.5)
        wait_injuries(w, "still the tooth", [tooth])
        # An undone cut is none.
        w.key("ctrl+z")
        w.wait_event("answer", what="Undone", failure="")
        wait_injuries(w, "nothing is injured", [])

        # The nerve too, and then the project is saved.
        w.key(*["bracketright"] * 3)
        cut_to(w, 8.6)
        nerves = ["Canal of the nerve, patient's right: ", "Canal of the nerve, patient's left: "]
        wait_injuries(w, "nerve and tooth", [*nerves, tooth])
        picture(w, "nerve")
        after = w.mark()
        w.key("ctrl+s")
        w.wait_state("it asks for a file", lambda s: s["dialog"])
        w.key("ctrl+a")
        w.type("case")
        w.key("Return")
        saved = w.wait_event("project", after=after)
        w.quit()
        code, out = w.wait_end()
        assert code == 0, out

        w = Window(display, options.kerf, ["rehearse", saved["file"], "-o", "again"], folder, title="kerf rehearse")
        w.wait_event("running")
        wait_injuries(w, "as it was saved", [*nerves, tooth])
        picture(w, "opened")
        w.quit()
        code, out = w.wait_end()
        assert code == 0, out
    shutil.rmtree(folder)


if __name__ == "__main__":
    main()
