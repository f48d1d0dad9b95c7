#!/usr/bin/env python3
"""Tests what may happen to a window: it is resized or minimised, loses the focus during a cut, is closed during a cut,
is killed, or has no display.

    lifecycle_test.py KERF

Exit code 77: the test was skipped; it prints the reason."""

import os
import shutil
import signal
import subprocess
import sys
import time

from drive import Display, Window, workspace
from rehearse_test import SCENE


def begin_cut(w):
    w.wait_event("running")
    w.wait_event("first_picture")
    w.key("v", "l", "space")
    w.key(*["bracketleft"] * 6)  # 1 mm/s: ten seconds of bone, even if this script is slow
    w.wait_state("the spindle turns", lambda s: s["spindle"])
    w.press("Down")
    w.wait_state("bone is removed", lambda s: s["removed_mm3"] > 2)


def check_recording(kerf, folder, whole=True, recording="out/session.kerf"):
    """Checks that the replay is identical. For a recording without an end (whole=False), the exit code must be 3."""
    done = subprocess.run([kerf, "replay", recording, "--verify"], cwd=folder, capture_output=True, text=True)
    assert done.returncode == (0 if whole else 3), (done.stdout, done.stderr)
    assert "bit-identical to the recording" in done.stdout, done.stdout


def start(display, kerf):
    folder = workspace()
    (folder / "bar.toml").write_text(SCENE)
    return Window(display, kerf, ["rehearse", "bar.toml", "-o", "out"], folder, title="kerf rehearse"), folder


def main():
    kerf = sys.argv[1]

    # Without a display there is one clear sentence, and no files are left behind.
    folder = workspace()
    env = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    for command in ("rehearse", "practise"):
        done = subprocess.run([kerf, command, "-o", "out"], cwd=folder, env=env, capture_output=True, text=True, timeout=60)
        assert done.returncode == 1 and done.stderr.count("\n") == 1 and "display" in done.stderr, done
    done = subprocess.run([kerf, "rehearse", "none.toml", "-o", "out"], cwd=folder, env=env, capture_output=True, text=True)
    assert done.returncode == 1 and "none.toml" in done.stderr, done
    assert not (folder / "out").exists() or not any((folder / "out").iterdir())
    shutil.rmtree(folder)

    with Display() as display:
        # A bone without a scene is cut, recorded and replayed.
        folder = workspace()
        subprocess.run([kerf, "model", "block", "-o", "bone.vdb", "--voxel", "0.5"], cwd=folder, check=True, capture_output=True)
        w = Window(display, kerf, ["rehearse", "bone.vdb", "-o", "out"], folder, title="kerf rehearse")
        w.wait_event("running")
        w.key("space")
        w.wait_state("the spindle turns", lambda s: s["spindle"])
        w.key("Right", "c")
        w.wait_state("it asks for a name", lambda s: s["entry"])
        w.key("ctrl+q")  # even while it asks
        code, out = w.wait_end()
        assert code == 0, out
        check_recording(kerf, folder)
        shutil.rmtree(folder)

        # The window is resized, minimised and restored. When it loses the focus during a cut, the spindle and the saw
        # stop.
        w, folder = start(display, kerf)
        begin_cut(w)
        w.input.resize(900, 600)
        w.wait_event("resized", width=900, height=600)
        assert w.picture().name.endswith(".png")
        w.input.xdotool("windowunmap", w.input.id)
        w.wait_state("the spindle is off", lambda s: not s["spindle"])  # hiding also removes the focus
        w.release("Down")
        w.input.xdotool("windowmap", w.input.id)
        w.input.focus()
        w.key("space")
        w.wait_state("the spindle turns", lambda s: s["spindle"])
        w.press("Down")
        w.wait_state("cutting again", lambda s: s["force_N"] > 0.1)
        before = w.mark()
        other = subprocess.Popen([sys.executable, "-c", OTHER_WINDOW], env=w.env, stdout=subprocess.PIPE, text=True)
        other.stdout.readline()
        w.wait_event("focus", after=before, on=False)
        w.wait_state("the loop's spindle is off", lambda s: not s["spindle"] and s["rpm"] == 0)
        removed = w.state["removed_mm3"]
        time.sleep(1)
        w.read()
        assert w.state["removed_mm3"] == removed
        other.terminate()
        w.release("Down")
        w.input.focus()

        # The window is closed by its frame during a cut: the recording is complete and verifies.
        w.key("space")
        w.wait_state("the spindle turns", lambda s: s["spindle"])
        w.press("Down")
        w.wait_state("cutting again", lambda s: s["removed_mm3"] > removed + 1)
        w.input.close()
        w.wait_state("it asks whether the cut is saved", lambda s: s["dialog"] and not s["spindle"])
        w.click_item("answer 2")
        code, out = w.wait_end()
        assert code == 0, (code, out)
        check_recording(kerf, folder)
        w.release("Down")
        shutil.rmtree(folder)

        # The program is ended by the system during a cut: the recording is also complete and verifies.
        w, folder = start(display, kerf)
        begin_cut(w)
        w.process.send_signal(signal.SIGTERM)
        code, out = w.wait_end()
        assert code == 0, (code, out)
        check_recording(kerf, folder)
        w.release("Down")
        shutil.rmtree(folder)

        # The program is killed: the part written until then opens and replays identically.
        w, folder = start(display, kerf)
        begin_cut(w)
        time.sleep(1)
        w.process.kill()
        w.process.wait()
        w.release("Down")
        check_recording(kerf, folder, whole=False)
        shutil.rmtree(folder)

    # A window manager that died has left its property: the program removes it and starts. With a live window manager the
    # property stays.
    for what, kept in (("gone", False), ("silent", False), ("other", False), ("alive", True)):
        with Display() as display:
            env = dict(os.environ, DISPLAY=display.name)
            manager = subprocess.Popen([sys.executable, "-c", WINDOW_MANAGER, what], env=env, stdout=subprocess.PIPE, text=True)
            assert manager.stdout.readline().strip() == "set"
            w, folder = start(display, kerf)
            w.wait_event("running")
            w.key("ctrl+q")
            code, out = w.wait_end()
            assert code == 0, (what, out)
            left = subprocess.run([sys.executable, "-c", WINDOW_MANAGER, "read"], env=env, capture_output=True, text=True)
            assert left.stdout.strip() == ("named" if kept else "none"), (what, left)
            manager.terminate()
            manager.wait()
            shutil.rmtree(folder)
    print("resized, hidden, without focus, closed, ended and killed: all recordings complete")


# What a window manager leaves on the root window: the name of a window that is gone, of one without a name of its own, of
# one that names another, or of its own live window. "read": prints whether the root window has the property.
WINDOW_MANAGER = """
import ctypes, sys, time
x = ctypes.CDLL("libX11.so.6")
x.XOpenDisplay.restype = ctypes.c_void_p
for f in (x.XDefaultRootWindow, x.XInternAtom, x.XCreateSimpleWindow):
    f.restype = ctypes.c_ulong
d = ctypes.c_void_p(x.XOpenDisplay(None))
root = ctypes.c_ulong(x.XDefaultRootWindow(d))
check = ctypes.c_ulong(x.XInternAtom(d, b"_NET_SUPPORTING_WM_CHECK", 0))
window_type = ctypes.c_ulong(33)
if sys.argv[1] == "read":
    type_, format_, count, left, data = ctypes.c_ulong(), ctypes.c_int(), ctypes.c_ulong(), ctypes.c_ulong(), ctypes.c_void_p()
    x.XGetWindowProperty(d, root, check, ctypes.c_long(0), ctypes.c_long(1), 0, window_type, ctypes.byref(type_),
                         ctypes.byref(format_), ctypes.byref(count), ctypes.byref(left), ctypes.byref(data))
    print("named" if count.value else "none", flush=True)
    sys.exit()
w = ctypes.c_ulong(x.XCreateSimpleWindow(d, root, 0, 0, 1, 1, 0, 0, 0))
def name(of, named):
    x.XChangeProperty(d, of, check, window_type, 32, 0, ctypes.byref(named), 1)
name(root, w)
if sys.argv[1] == "other":
    name(w, root)
elif sys.argv[1] != "silent":
    name(w, w)
if sys.argv[1] == "gone":
    x.XDestroyWindow(d, w)
x.XSync(d, 0)
print("set", flush=True)
time.sleep(600)
"""

# A window that takes the focus.
OTHER_WINDOW = """
import ctypes, time
x = ctypes.CDLL("libX11.so.6")
x.XOpenDisplay.restype = ctypes.c_void_p
d = ctypes.c_void_p(x.XOpenDisplay(None))
x.XDefaultRootWindow.restype = ctypes.c_ulong
root = ctypes.c_ulong(x.XDefaultRootWindow(d))
x.XCreateSimpleWindow.restype = ctypes.c_ulong
w = ctypes.c_ulong(x.XCreateSimpleWindow(d, root, 1000, 700, 100, 100, 0, 0, 0))
x.XMapWindow(d, w)
x.XSync(d, 0)
time.sleep(0.3)
x.XSetInputFocus(d, w, 1, 0)
x.XSync(d, 0)
print("focus", flush=True)
time.sleep(60)
"""

if __name__ == "__main__":
    main()
