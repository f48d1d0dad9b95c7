"""Drives the real window of kerf with real key and mouse events on a separate display (Xvfb)."""

import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

PROGRAMS = ("Xvfb", "xdotool")
NEXT_CLICK_S = 1.5  # after this time, a click is not the second one of a double click, however slow the window is
PATIENCE_S = 300  # a wait that lasts longer fails; the slowest one seen was 60 s, on a machine with 10 other programs


def skip_without_display_programs():
    missing = [p for p in PROGRAMS if shutil.which(p) is None]
    if missing:
        print("Skipped:", ", ".join(missing), "not installed (apt-get install xvfb xdotool)")
        sys.exit(77)


class Display:
    """An X server without a screen."""

    def __init__(self, width=1600, height=1000):
        read, write = os.pipe()
        self.server = subprocess.Popen(
            ["Xvfb", "-displayfd", str(write), "-screen", "0", f"{width}x{height}x24", "-nolisten", "tcp",
             "-noreset",  # otherwise it resets when its last client leaves, and refuses clients meanwhile
             "-r"],  # no key repeats, which a key that a busy machine releases late would cause
            pass_fds=[write], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as pipe:
            self.name = ":" + pipe.readline().strip()
        if self.name == ":":
            raise RuntimeError("Xvfb did not start")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.server.terminate()
        self.server.wait()


# Sends a client message WM_DELETE_WINDOW to the window in argv[1].
ASK_TO_CLOSE = """
import ctypes, sys
x = ctypes.CDLL("libX11.so.6")
x.XOpenDisplay.restype = ctypes.c_void_p
x.XInternAtom.restype = ctypes.c_ulong
d = ctypes.c_void_p(x.XOpenDisplay(None))
class Event(ctypes.Structure):
    _fields_ = [("type", ctypes.c_int), ("serial", ctypes.c_ulong), ("send_event", ctypes.c_int), ("display", ctypes.c_void_p),
                ("window", ctypes.c_ulong), ("message_type", ctypes.c_ulong), ("format", ctypes.c_int), ("data", ctypes.c_long * 5),
                ("pad", ctypes.c_long * 24)]
e = Event(type=33, send_event=1, window=int(sys.argv[1]), format=32)
e.message_type = x.XInternAtom(d, b"WM_PROTOCOLS", 0)
e.data[0] = x.XInternAtom(d, b"WM_DELETE_WINDOW", 0)
x.XSendEvent(d, ctypes.c_ulong(e.window), 0, ctypes.c_long(0), ctypes.byref(e))
x.XSync(d, 0)
"""


class Window:
    """Runs `kerf` with a window and reads its log as it grows. Positions are in pixels from the window's top left
    corner."""

    def __init__(self, display, kerf, arguments, folder, environment=None, title="kerf"):
        self.folder = pathlib.Path(folder)
        self.log = self.folder / "log.jsonl"
        self.log.unlink(missing_ok=True)
        self.env = dict(os.environ, DISPLAY=display.name, **(environment or {}))
        self.env.setdefault("LP_NUM_THREADS", "2")
        self.env["HOME"] = str(self.folder)  # a project that has no folder yet is saved there
        # Settings of its own, as after the tour.
        if "XDG_CONFIG_HOME" not in (environment or {}):
            settings = self.folder / "config/kerf/window.json"
            settings.parent.mkdir(parents=True, exist_ok=True)
            if not settings.exists():
                settings.write_text(json.dumps({"tour_shown": True, "language": "en", "save_folder": str(self.folder)}))
            self.env["XDG_CONFIG_HOME"] = str(self.folder / "config")
        self.out = open(self.folder / "out.txt", "w+")
        self.process = subprocess.Popen([kerf, *arguments, "--log", str(self.log)], cwd=self.folder, env=self.env,
                                        stdout=self.out, stderr=self.out, stdin=subprocess.DEVNULL)
        self.seen = 0
        self.events = []
        self.state = {}
        self.all_items = []  # each state of items
        self.items = {}  # name -> left, top, width, height of buttons, menus and rows that are shown
        self.id = None
        deadline = time.monotonic() + PATIENCE_S
        while self.id is None:
            self._check(deadline, "no window appeared")
            # Only a visible window can receive the focus.
            found = self._xdotool("search", "--onlyvisible", "--name", title, check=False).split()
            self.id = found[0] if found else None
            time.sleep(0.1)
        self.focus()

    def _xdotool(self, *arguments, check=True):
        done = subprocess.run(["xdotool", *map(str, arguments)], env=self.env, capture_output=True, text=True)
        if check and done.returncode != 0:
            raise RuntimeError(f"xdotool {arguments}: {done.stderr}")
        return done.stdout

    def _check(self, deadline, what):
        if self.process.poll() is not None:
            self.out.seek(0)
            raise AssertionError(f"{what}: kerf ended with {self.process.returncode}:\n{self.out.read()}")
        if time.monotonic() > deadline:
            raise AssertionError(f"{what}; state {self.state}; last events {self.events[-8:]}")

    def read(self):
        if not self.log.exists():
            return
        text = self.log.read_text()
        lines = text[:text.rfind("\n") + 1].splitlines()
        for line in lines[self.seen:]:
            event = json.loads(line)
            if event["event"] == "state":
                self.state = event
            elif event["event"] == "items":
                self.items = event["items"]
                self.all_items.append(self.items)
            else:
                self.events.append(event)
        self.seen = len(lines)

    # ---- input
    def focus(self):
        self._xdotool("windowfocus", "--sync", self.id)

    def key(self, *names):
        for name in names:
            self._xdotool("key", "--clearmodifiers", name)
            time.sleep(0.05)

    def hold(self, name, seconds, until=None):
        """Holds a key for a time, and then until the state is as `until` wants it: a busy window may not see it before."""
        self._xdotool("keydown", name)
        time.sleep(seconds)
        if until is not None:
            self.wait_state(f"{name} acts", until)
        self._xdotool("keyup", name)

    def type(self, text):
        """Types a text. GLFW drops a key that is pressed twice at one time of the display, and a busy display gives all
        keys that wait the same time: each key is sent once by a connection, whose end waits for the display."""
        part = ""
        for letter in text:
            if letter.lower() in part.lower() or (letter in "-_" and set(part) & set("-_")):
                self._xdotool("type", "--delay", "20", part)
                part = ""
            part += letter
        self._xdotool("type", "--delay", "20", part)

    def move(self, x, y):
        self._xdotool("mousemove", "--window", self.id, int(x), int(y))

    def click(self, x, y, button=1):
        self.move(x, y)
        time.sleep(0.05)
        self._xdotool("click", button)

    def click_item(self, name, button=1, seconds=PATIENCE_S):
        """Clicks a button, an entry of a menu or a row, once it is shown and stays in its place."""
        deadline = time.monotonic() + seconds
        place = None
        while True:
            self.read()
            if name in self.items and self.items[name] == place:
                break
            place = self.items.get(name)
            self._check(deadline, f"{name} is not shown; shown: {sorted(self.items)}")
            time.sleep(0.05)
        left, top, width, height = self.items[name]
        self.click(left + width / 2, top + height / 2, button)

    def choose(self, menu, action):
        """Chooses an entry of the menu bar. A menu that is still open would be closed by the click."""
        deadline = time.monotonic() + PATIENCE_S
        while True:
            self.read()
            if not any(name.startswith("entry ") for name in self.items):
                break
            self._check(deadline, "a menu does not close")
            time.sleep(0.05)
        self.click_item(f"menu {menu}")
        self.click_item(f"entry {action}")

    def drag(self, start, end, button=1, modifier=None, steps=20, pace_s=0.02):
        self.move(*start)
        if modifier:
            self._xdotool("keydown", modifier)
        self._xdotool("mousedown", button)
        for i in range(1, steps + 1):
            share = i / steps
            self.move(start[0] + share * (end[0] - start[0]), start[1] + share * (end[1] - start[1]))
            time.sleep(pace_s)
        self._xdotool("mouseup", button)
        if modifier:
            self._xdotool("keyup", modifier)

    def scroll(self, x, y, notches):
        self.move(x, y)
        self._xdotool("click", "--repeat", abs(notches), 4 if notches > 0 else 5)

    def resize(self, width, height):
        self._xdotool("windowsize", self.id, width, height)

    def close(self):
        """Closes the window with the message that a window manager sends."""
        subprocess.run([sys.executable, "-c", ASK_TO_CLOSE, self.id], env=self.env, check=True)

    # ---- responses
    def wait_event(self, name, seconds=PATIENCE_S, after=0, **wanted):
        deadline = time.monotonic() + seconds
        while True:
            self.read()
            for event in self.events[after:]:
                if event["event"] == name and all(event.get(k) == v for k, v in wanted.items()):
                    return event
            self._check(deadline, f"no event {name} {wanted}") if not self._over() else self._fail(name)
            time.sleep(0.05)

    def wait_message(self, part, seconds=PATIENCE_S, after=0):
        """Waits for a message to the user after the mark `after`; a message is shown for about a second, or until the next one."""
        deadline = time.monotonic() + seconds
        while True:
            self.read()
            for event in self.events[after:]:
                if event["event"] == "message" and part in event["text"]:
                    return
            self._check(deadline, f"no message: {part}")
            time.sleep(0.05)

    def wait_state(self, what, test, seconds=PATIENCE_S):
        """Waits until the state passes a test. A state that lacks what the test reads, because it belongs to another mode,
        does not pass."""
        deadline = time.monotonic() + seconds
        while True:
            self.read()
            try:
                if self.state and test(self.state):
                    return self.state
            except (KeyError, IndexError):
                pass
            self._check(deadline, f"not reached: {what}")
            time.sleep(0.05)

    def wait_items(self, what, test, seconds=PATIENCE_S):
        """Waits until the buttons, menus and rows that are shown pass a test."""
        deadline = time.monotonic() + seconds
        while True:
            self.read()
            if test(self.items):
                return
            self._check(deadline, f"not reached: {what}; shown: {sorted(self.items)}")
            time.sleep(0.05)

    def wait_still_items(self, still_s=2):
        """Waits until the buttons, menus and rows that are shown have been the same for `still_s`."""
        shown, since = None, time.monotonic()
        while time.monotonic() - since < still_s:
            self.read()
            if set(self.items) != shown:
                shown, since = set(self.items), time.monotonic()
            time.sleep(0.05)

    def wait_still(self, name, still_s=1, seconds=PATIENCE_S):
        """Returns the state's value `name` once it has not changed for `still_s`."""
        deadline = time.monotonic() + seconds
        value, since = None, time.monotonic()
        while time.monotonic() < since + still_s:
            self.read()
            if self.state[name] != value:
                value, since = self.state[name], time.monotonic()
            self._check(deadline, f"{name} does not settle")
            time.sleep(0.05)
        return value

    def _over(self):
        return self.process.poll() is not None

    def _fail(self, name):
        """Ends the test. The events until the end have been searched already, except for those of the last moment."""
        seen = len(self.events)
        self.read()
        if len(self.events) > seen:
            return
        self.out.seek(0)
        raise AssertionError(f"kerf ended with {self.process.returncode} before {name}: {self.out.read()[-2000:]}; "
                             f"last events {self.events[-8:]}")

    def mark(self):
        self.read()
        return len(self.events)

    def picture(self):
        """Presses F12 and returns the picture's file."""
        after = self.mark()
        self.key("F12")
        return pathlib.Path(self.wait_event("picture", after=after)["file"])

    def quit(self, how="key"):
        """Ends the program without saving, by the keyboard or by the window's frame. It asks if there is work to save."""
        self.close() if how == "close" else self.key("ctrl+q")
        while not self._over():
            self.read()
            if "answer 3" in self.items:  # may still be that of the dialog before: then it is asked again
                left, top, width, height = self.items["answer 2"]
                try:
                    self.click(left + width / 2, top + height / 2)
                except RuntimeError:  # the window has closed
                    pass
                time.sleep(0.5)
            time.sleep(0.05)

    def wait_end(self, seconds=PATIENCE_S):
        code = self.process.wait(timeout=seconds)
        self.read()
        self.out.seek(0)
        return code, self.out.read()


def workspace():
    return pathlib.Path(tempfile.mkdtemp(prefix="kerf_window_"))
