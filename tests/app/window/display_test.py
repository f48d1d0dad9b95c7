#!/usr/bin/env python3
"""Tests what the window does on other displays: twice the density of pixels, small windows with large German text, a
picture of the first frame, and files that are dropped into it.

    display_test.py KERF [--pictures FOLDER]

--pictures: keeps the test's pictures. Exit code 77: the test was skipped; it prints the reason."""

import argparse
import ctypes
import json
import os
import pathlib
import shutil
import subprocess
import sys
import zlib

from drive import Display, Window, workspace
from rehearse_test import SCENE

# Gives the display the density that a desktop sets for the dots per inch in argv[1].
SET_DENSITY = """
import ctypes, sys
x = ctypes.CDLL("libX11.so.6")
x.XOpenDisplay.restype = ctypes.c_void_p
x.XDefaultRootWindow.restype = ctypes.c_ulong
d = ctypes.c_void_p(x.XOpenDisplay(None))
text = b"Xft.dpi:\\t" + sys.argv[1].encode() + b"\\n"
RESOURCE_MANAGER, STRING = 23, 31
x.XChangeProperty(d, ctypes.c_ulong(x.XDefaultRootWindow(d)), ctypes.c_ulong(RESOURCE_MANAGER), ctypes.c_ulong(STRING), 8, 0,
                  text, len(text))
x.XSync(d, 0)
"""


def read_png(path):
    """Returns width and rows of RGB bytes of a PNG picture with 8 bits a channel."""
    data = pathlib.Path(path).read_bytes()
    at, packed = 8, b""
    while at < len(data):
        size, kind = int.from_bytes(data[at:at + 4], "big"), data[at + 4:at + 8]
        body = data[at + 8:at + 8 + size]
        if kind == b"IHDR":
            width, height, depth, colours = *(int.from_bytes(body[i:i + 4], "big") for i in (0, 4)), body[8], body[9]
            assert (depth, colours) == (8, 2), (depth, colours)
        elif kind == b"IDAT":
            packed += body
        at += 12 + size
    raw, rows, before = zlib.decompress(packed), [], bytes(3 * width)
    for i in range(height):
        start = i * (3 * width + 1)
        how, line = raw[start], bytearray(raw[start + 1:start + 1 + 3 * width])
        for k in range(len(line)):
            a, b, c = line[k - 3] if k >= 3 else 0, before[k], before[k - 3] if k >= 3 else 0
            if how == 4:
                p = a + b - c
                guess = min((abs(p - a), 0, a), (abs(p - b), 1, b), (abs(p - c), 2, c))[2]
            else:
                guess = (0, a, b, (a + b) // 2)[how]
            line[k] = (line[k] + guess) & 255
        rows.append(bytes(line))
        before = rows[-1]
    return width, rows


def start(display, kerf, arguments, settings=None):
    folder = workspace()
    (folder / "bar.toml").write_text(SCENE)
    file = folder / "config/kerf/window.json"
    file.parent.mkdir(parents=True)
    file.write_text(json.dumps({"tour_shown": True, "language": "en", **(settings or {})}))
    return Window(display, kerf, ["rehearse", "bar.toml", "-o", "out", *arguments], folder, title="kerf rehearse"), folder


def quit_window(w, folder):
    w.quit()
    code, out = w.wait_end()
    assert code == 0, out
    shutil.rmtree(folder)


def draw_at_twice_the_density(kerf, keep):
    """The same items are at the same places, twice as large, and the window is too."""
    items = {}
    for dpi in (96, 192):
        scale = dpi // 96
        with Display(1300 * scale, 760 * scale) as display:
            subprocess.run([sys.executable, "-c", SET_DENSITY, str(dpi)], env=dict(os.environ, DISPLAY=display.name), check=True)
            w, folder = start(display, kerf, ["--size", "1280x720"])
            w.wait_event("running")
            w.wait_event("first_picture")
            w.wait_state("the finest surface, and no message", lambda s: s["chunks_left"] == 0 and s["message"] == "")
            w.wait_still_items()  # what shows that the bone is being made has gone
            if scale == 2:
                w.wait_items(f"twice as large as {items}", lambda shown: is_twice(items, shown))
            items = w.items
            file = folder / w.picture()
            with open(file, "rb") as picture:
                assert int.from_bytes(picture.read(20)[16:20], "big") == 1280 * scale
            keep(f"scale_{scale}", file)
            quit_window(w, folder)
    assert sum(name.startswith(("button ", "menu ", "section ", "indicator ", "slice ")) for name in items) > 20


def is_twice(items, shown):
    """The glyphs of both sizes are fitted to whole pixels: the text of a row of buttons may differ by some of them."""
    return set(shown) == set(items) and all(abs(2 * small - large) < 12 + 0.02 * large for name, box in items.items()
                                            for small, large in zip(box, shown[name]))


def fit_large_german_text(kerf, keep):
    """Modes that do not fit into the status line are in a menu at its end."""
    with Display(1100, 800) as display:
        w, folder = start(display, kerf, ["--size", "1024x768"], {"language": "de", "text_size": 1.5})
        w.wait_event("running")
        w.wait_items("the menu", lambda items: "indicators more" in items)
        w.wait_still_items()  # modes are added to the status line while the bone is being made
        keep("german", folder / w.picture())
        for name, (left, top, width, height) in w.items.items():
            if name.startswith(("indicator", "button")):
                assert left + width <= 1024 and top + height <= 768, (name, w.items[name])
        assert "indicator saw.spindle" in w.items and "indicator view.translucent" not in w.items, sorted(w.items)
        w.click_item("indicators more")
        w.wait_items("the menu is above its button", lambda items: "indicator view.translucent" in items and
                     items["indicator view.translucent"][1] + items["indicator view.translucent"][3] <
                     items["indicators more"][1])
        w.click_item("indicator view.translucent")
        w.wait_state("translucent", lambda s: s["translucent"])
        quit_window(w, folder)


def take_picture_of_the_first_frame(kerf, keep):
    """The menu bar is light, from its first pixels on: a picture waits for the panels."""
    with Display() as display:
        w, folder = start(display, kerf, ["--size", "1280x720"])
        file = folder / w.picture()  # the key is pressed as soon as the window exists
        keep("first", file)
        width, rows = read_png(file)
        for x, y in ((5, 3), (900, 10), (1270, 12), (5, 715)):
            assert min(rows[y][3 * x:3 * x + 3]) > 150, (x, y, rows[y][3 * x:3 * x + 3])
        w.wait_event("running")
        quit_window(w, folder)


def drop_files(kerf):
    """A bone and a scene that are dropped are opened; work that is not saved is not lost by that."""
    with Display() as display:
        w, folder = start(display, kerf, [])
        subprocess.run([kerf, "model", "block", "-o", "another bone.vdb", "--voxel", "0.5"], cwd=folder, check=True,
                       capture_output=True)
        w.wait_event("running")

        def drop(name):
            w.input.drop(folder / name)

        for name in ("another bone.vdb", "bar.toml"):
            after = w.mark()
            drop(name)
            assert w.wait_event("dropped", after=after)["file"] == str(folder / name)
            w.wait_event("running", after=after)
        assert w.state["planes"] == 1, "the scene has its plan"
        (folder / "note.txt").write_text("not a bone")
        drop("note.txt")
        w.wait_state("it says why not", lambda s: s["dialog"])
        w.key("Escape")
        w.wait_state("the bone is still there", lambda s: not s["dialog"] and s["running"])
        # Ctrl+Q asks while another question is open, too.
        w.key("v", "l", "space")
        w.wait_state("the spindle turns", lambda s: s["spindle"])
        w.press("Down")
        w.wait_state("bone is removed", lambda s: s["removed_mm3"] > 1)
        w.release("Down")
        w.key("space")
        w.wait_state("the spindle is off", lambda s: not s["spindle"])
        w.key("c")
        w.wait_state("it asks for a name", lambda s: s["entry"])
        after = w.mark()
        drop("bar.toml")  # the dialog is about the bone that is open
        w.wait_event("dropped", after=after)
        w.wait_message("Answer the dialog first", after=after)
        w.wait_state("it is not opened", lambda s: s["entry"])
        w.key("ctrl+q")
        w.wait_state("it asks whether to save", lambda s: s["dialog"] and not s["entry"])
        w.wait_items("answers", lambda items: "answer 3" in items)
        w.key("ctrl+q")
        w.click_item("answer 3")
        w.wait_state("it stays", lambda s: not s["dialog"] and s["running"])
        drop("another bone.vdb")
        w.click_item("answer 3")
        w.wait_state("it stays", lambda s: not s["dialog"] and s["removed_mm3"] > 1)
        quit_window(w, folder)


def inside(box, area, what):
    """Asserts that the middle of a box lies in an area."""
    x, y = box[0] + box[2] / 2, box[1] + box[3] / 2
    assert area[0] <= x <= area[0] + area[2] and area[1] <= y <= area[1] + area[3], (what, box, area)


def practise_in_small_windows(kerf, keep):
    """The saw is not covered by panels while it cuts and in the replay, and the result says what comes next."""
    for width, height, text_size, language in ((640, 480, 1, "de"), (640, 480, 1.5, "en"), (800, 600, 1.5, "de")):
        name = f"{width}_{text_size}"
        folder = workspace()
        file = folder / "config/kerf/window.json"
        file.parent.mkdir(parents=True)
        file.write_text(json.dumps({"tour_shown": True, "language": language, "text_size": text_size}))
        with Display(width + 100, height + 100) as display:
            w = Window(display, kerf, ["practise", "--exercise", "groove", "-o", "out", "--size", f"{width}x{height}"], folder,
                       {"KERF_DATA": str(folder / "data")}, title="kerf practise")
            w.wait_event("running")
            w.wait_event("first_picture")
            w.wait_items("the card", lambda items: "banner" in items)
            keep(f"start_{name}", folder / w.picture())
            w.key("space")
            w.wait_state("the spindle turns", lambda s: s["spindle"])
            w.press("Down")
            w.wait_state("in the bone", lambda s: s.get("depth_mm", -1) > 1)
            w.release("Down")
            state = w.wait_state("the picture is fitted to the scene", lambda s: s["scene_px"][0] > 0)
            inside(state["saw_px"], state["scene_px"], "saw in the scene")
            left, top, _, banner_height = w.items["banner"]
            assert state["saw_px"][1] + state["saw_px"][3] > top + banner_height, ("the blade's rim is seen", state, w.items)
            keep(f"cut_{name}", folder / w.picture())
            w.key("Return")
            w.wait_event("score")
            w.wait_items("what comes next", lambda items: "practise.reason" in items)
            for item in ("practise.reason", "practise.step", "practise.watch"):
                left, top, item_width, item_height = w.items[item]
                assert 0 <= left and left + item_width <= width and top + item_height <= height, (item, w.items[item])
            keep(f"result_{name}", folder / w.picture())
            w.click_item("practise.watch")
            w.wait_state("the replay", lambda s: s["mode"] == "replaying")
            w.wait_items("its buttons", lambda items: "practise.restart" in items)
            state = w.wait_state("it goes on", lambda s: s.get("replay_s", 0) > 0.5)
            panel_top = w.items.get("practise.plot", w.items["practise.restart"])[1]
            area = list(state["scene_px"])
            area[3] = panel_top - area[1]
            inside(state["saw_px"], area, "saw above the panel")
            keep(f"replay_{name}", folder / w.picture())
            w.key("ctrl+q")
            code, out = w.wait_end()
            assert code == 0, out
        shutil.rmtree(folder)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kerf")
    parser.add_argument("--pictures")
    options = parser.parse_args()
    try:
        ctypes.CDLL("libX11.so.6")
    except OSError:
        print("Skipped: libX11.so.6 is not installed (apt-get install libx11-6)")
        sys.exit(77)

    def keep(name, file):
        if options.pictures:
            shutil.copy(file, f"{options.pictures}/display_{name}.png")

    fit_large_german_text(options.kerf, keep)
    take_picture_of_the_first_frame(options.kerf, keep)
    draw_at_twice_the_density(options.kerf, keep)
    practise_in_small_windows(options.kerf, keep)
    drop_files(options.kerf)
    print("displays and drops tested")


if __name__ == "__main__":
    main()
