"""Drives the window of kerf: the real one with real key and mouse events on a separate display (Xvfb), or that of kerf_made_up
with made-up events, without a display (tests/app/made_up_window)."""

import array
import contextlib
import fcntl
import functools
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import termios
import time

PROGRAMS = ("Xvfb", "xdotool")
NEXT_CLICK_S = 1.5  # after this time, a click is not the second one of a double click, however slow the window is
PATIENCE_S = 300  # a wait that lasts longer fails, on a machine without other programs


def patience_s():
    """Returns the time after which a wait fails. A program that shares the processors with others gets its share of them."""
    return PATIENCE_S * max(1, os.getloadavg()[0] / os.cpu_count())


def skip_without_display_programs():
    missing = [p for p in PROGRAMS if shutil.which(p) is None]
    if missing:
        print("Skipped:", ", ".join(missing), "not installed (apt-get install xvfb xdotool)")
        sys.exit(77)


def run_without_events(arguments, **options):
    """Runs kerf until it ends by itself; a window that it opens gets no event."""
    read, write = os.pipe()
    try:
        return subprocess.run(arguments, stdin=read, capture_output=True, text=True, timeout=300, **options)
    finally:
        os.close(read)
        os.close(write)


class Display:
    """An X server without a screen, which starts when its name is asked for: kerf_made_up needs none."""

    def __init__(self, width=1600, height=1000):
        self.size = f"{width}x{height}x24"
        self.server = None

    @functools.cached_property
    def name(self):
        skip_without_display_programs()
        read, write = os.pipe()
        self.server = subprocess.Popen(
            ["Xvfb", "-displayfd", str(write), "-screen", "0", self.size, "-nolisten", "tcp",
             "-noreset",  # otherwise it resets when its last client leaves, and refuses clients meanwhile
             "-r"],  # no key repeats, which a key that a busy machine releases late would cause
            pass_fds=[write], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as pipe:
            name = pipe.readline().strip()
        if not name:
            raise RuntimeError("Xvfb did not start")
        return ":" + name

    def environment(self, *command):
        """Returns the environment of a command that runs kerf on this display."""
        return dict(os.environ) if is_made_up(*command) else dict(os.environ, DISPLAY=self.name)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.server:
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


def is_made_up(*command):
    """A device is emulated by another program, which runs that of the window."""
    return any(pathlib.Path(word).name == "kerf_made_up" for word in command)


class RealInput:
    """Events of a window on a display, from xdotool."""

    def __init__(self, window, title):
        self.env = window.env
        # Only a visible window can receive the focus.
        self.id = window.wait("a window", lambda: self.xdotool("search", "--onlyvisible", "--name", title, check=False).split())[0]
        self.focus()

    def xdotool(self, *arguments, check=True):
        done = subprocess.run(["xdotool", *map(str, arguments)], env=self.env, capture_output=True, text=True)
        if check and done.returncode != 0:
            raise RuntimeError(f"xdotool {arguments}: {done.stderr}")
        return done.stdout

    def focus(self):
        self.xdotool("windowfocus", "--sync", self.id)

    def tap(self, *names):
        self.xdotool("key", "--clearmodifiers", "--delay", "0", *names)

    def press(self, name):
        self.xdotool("keydown", name)

    def release(self, name):
        self.xdotool("keyup", name)

    def type(self, text):
        """GLFW drops a key that is pressed twice at one time of the display, and a busy display gives all keys that wait
        the same time: each key is sent once by a connection, whose end waits for the display."""
        part = ""
        for letter in text:
            if letter.lower() in part.lower() or (letter in "-_" and set(part) & set("-_")):
                self.xdotool("type", "--delay", "20", part)
                part = ""
            part += letter
        self.xdotool("type", "--delay", "20", part)

    def move(self, x, y):
        self.xdotool("mousemove", "--window", self.id, int(x), int(y))

    def press_button(self, button):
        self.xdotool("mousedown", button)

    def release_button(self, button):
        self.xdotool("mouseup", button)

    def click(self, button, times=1):
        self.xdotool("click", "--repeat", times, "--delay", 60, button)

    def scroll(self, notches):
        self.xdotool("click", "--repeat", abs(notches), 4 if notches > 0 else 5)

    def resize(self, width, height):
        self.xdotool("windowsize", self.id, width, height)

    def close(self):
        subprocess.run([sys.executable, "-c", ASK_TO_CLOSE, self.id], env=self.env, check=True)

    def drop(self, file):
        subprocess.run([sys.executable, pathlib.Path(__file__).with_name("drag_and_drop.py"), self.id, file], env=self.env,
                       check=True, timeout=120)


class MadeUpInput:
    """Events that the window of kerf_made_up reads."""

    # As in src/view/ui/event.h.
    KINDS = ("key_down", "key_up", "text", "mouse_down", "mouse_up", "mouse_move", "scroll", "resize", "focus", "minimise",
             "refresh", "drop", "close")
    NAMED = ("Escape", "Return", "Tab", "BackSpace", "Delete", "Left", "Right", "Up", "Down", "Prior", "Next", "Home", "End",
             *(f"F{i}" for i in range(1, 13)))
    CHARACTERS = {"space": " ", "minus": "-", "equal": "=", "bracketleft": "[", "bracketright": "]", "question": "?"}
    MODIFIERS = {"shift": "shift", "ctrl": "control"}
    BUTTONS = {1: 0, 2: 2, 3: 1}

    def __init__(self, window, _title):
        self.process = window.process
        self.held = set()
        self.at = (0, 0)

    def event(self, kind, **members):
        return {"kind": self.KINDS.index(kind), **{self.MODIFIERS[name]: True for name in self.held}, **members}

    def send(self, *events):
        """Sends the events of one frame, and waits until the program takes them, however busy it is."""
        with contextlib.suppress(BrokenPipeError):  # the program has ended, which a wait notices
            os.write(self.process.stdin.fileno(), (json.dumps(events) + "\n").encode())
        unread = array.array("i", [1])
        while unread[0] and self.process.poll() is None:
            time.sleep(0.005)
            fcntl.ioctl(self.process.stdin, termios.FIONREAD, unread)

    def key_of(self, name):
        if name in self.NAMED:
            return 256 + self.NAMED.index(name)
        character = self.CHARACTERS.get(name, name).upper()
        return ord(character) if character.isascii() and (character.isalnum() or character in " -=[]") else 0

    def down(self, name):
        if name in self.MODIFIERS:
            self.held.add(name)
            return []
        events = [self.event("key_down", key=self.key_of(name))]
        character = self.CHARACTERS.get(name, name)
        if len(character) == 1 and "ctrl" not in self.held:
            events.append(self.event("text", character=ord(character.upper() if "shift" in self.held else character)))
        return events

    def up(self, name):
        if name in self.MODIFIERS:
            self.held.discard(name)
            return []
        return [self.event("key_up", key=self.key_of(name))]

    def press(self, name):
        self.send(*self.down(name))

    def release(self, name):
        self.send(*self.up(name))

    def tap(self, *names):
        """Without a frame in between."""
        events = []
        for chord in names:
            keys = chord.split("+")
            for act, key in (*((self.down, key) for key in keys), *((self.up, key) for key in reversed(keys))):
                events += act(key)
        self.send(*events)

    def type(self, text):
        for letter in text:
            self.tap("Tab" if letter == "\t" else letter)

    def mouse(self, kind, **members):
        return self.event(kind, x=self.at[0], y=self.at[1], **members)

    def move(self, x, y):
        self.at = (int(x), int(y))
        self.send(self.mouse("mouse_move"))

    def press_button(self, button):
        self.send(self.mouse("mouse_down", button=self.BUTTONS[button]))

    def release_button(self, button):
        self.send(self.mouse("mouse_up", button=self.BUTTONS[button]))

    def click(self, button, times=1):
        self.send(*[self.mouse(kind, button=self.BUTTONS[button]) for kind in ("mouse_down", "mouse_up")] * times)

    def scroll(self, notches):
        self.send(*[self.mouse("scroll", amount=1 if notches > 0 else -1)] * abs(notches))

    def close(self):
        self.send(self.event("close"))

    def drop(self, file):
        self.send(self.event("drop", path=str(file)))


class Window:
    """Runs `kerf` with a window and reads its log as it grows. Positions are in pixels from the window's top left
    corner. `may_fail`: a session may end by itself, for example because it cannot be recorded."""

    def __init__(self, display, kerf, arguments, folder, environment=None, title="kerf", may_fail=False):
        self.folder = pathlib.Path(folder)
        self.log = self.folder / "log.jsonl"
        self.log.unlink(missing_ok=True)
        self.env = {**display.environment(kerf, *arguments), **(environment or {})}
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
        made_up = is_made_up(kerf, *arguments)
        self.process = subprocess.Popen([kerf, *arguments, "--log", str(self.log)], cwd=self.folder, env=self.env,
                                        stdout=self.out, stderr=self.out, stdin=subprocess.PIPE if made_up else subprocess.DEVNULL)
        self.may_fail = may_fail
        self.unread = b""
        self.lines = None
        self.states = 0  # read so far
        self.fresh = []  # states that were read last, the last one of which is `state`
        self.events = []
        self.state = {}
        self.items = {}  # name -> left, top, width, height of buttons, menus and rows that are shown
        self.input = (MadeUpInput if made_up else RealInput)(self, title)

    def read(self):
        """Reads what the log has more than before."""
        self.fresh = []
        if self.lines is None:
            if not self.log.exists():
                return
            self.lines = open(self.log, "rb")
        *lines, self.unread = (self.unread + self.lines.read()).split(b"\n")
        for line in lines:
            event = json.loads(line)
            if event["event"] == "state":
                self.state = event
                self.states += 1
                self.fresh.append(event)
            elif event["event"] == "items":
                self.items = event["items"] or {}
            else:
                self.events.append(event)

    def wait(self, what, test, seconds=None):
        """Waits until the test of what was read returns something, and returns it."""
        began = time.monotonic()
        while True:
            over = self._over()
            self.read()
            if found := test():
                return found
            why = ""
            if kept := [event for event in self.events if event["event"] == "work_kept" and not self.may_fail]:
                why = f"the session ended by itself: {kept[0]['failure']}"
            elif over:
                self.out.seek(0)
                why = f"kerf ended with {self.process.returncode}: {self.out.read()[-2000:]}"
            elif time.monotonic() > began + (seconds or patience_s()):
                why = "it takes too long"
            if why:
                raise AssertionError(f"not reached: {what}: {why}; state {self.state}; shown: {sorted(self.items)}; "
                                     f"last events {self.events[-8:]}")
            time.sleep(0.02)

    def wait_still(self, name, still_s=1):
        """Returns the state's value `name` once it has not changed for `still_s`."""
        return self._wait_same(f"{name} is still", lambda: self.state[name], still_s)

    def wait_still_items(self, still_s=2):
        """Waits until the buttons, menus and rows that are shown have been the same, in their places, for `still_s`."""
        return self._wait_same("nothing on the panels moves", lambda: self.items, still_s)

    def _wait_same(self, what, value, still_s):
        """The program logs its state twice a second if it is the same; a busy one needs more time for that."""
        same = []  # the value, since when, and after how many states

        def test():
            if not same or same[0] != value():
                same[:] = value(), time.monotonic(), self.states
            return time.monotonic() > same[1] + still_s and self.states > same[2] + 2 * still_s

        self.wait(what, test)
        return same[0]

    # ---- input
    def key(self, *names):
        for name in names:
            self.input.tap(name)
            time.sleep(0.05)

    def press(self, *names):
        for name in names:
            self.input.press(name)

    def release(self, *names):
        for name in names:
            self.input.release(name)

    def hold(self, name, seconds, until=None):
        """Holds a key for a time, and then until the state is as `until` wants it: a busy window may not see it before."""
        self.press(name)
        time.sleep(seconds)
        if until is not None:
            self.wait_state(f"{name} acts", until)
        self.release(name)

    def type(self, text):
        self.input.type(text)

    def move(self, x, y):
        self.input.move(x, y)

    def click(self, x, y, button=1, times=1):
        self.move(x, y)
        time.sleep(0.05)
        self.input.click(button, times)

    def click_item(self, name, button=1):
        """Clicks a button, an entry of a menu or a row, once it is shown and stays in its place."""
        places = []

        def stays():
            places.append(self.items.get(name))
            return places[-1] and len(places) > 2 and places[-1] == places[-3]

        self.wait(f"{name} is shown", stays)
        left, top, width, height = self.items[name]
        self.click(left + width / 2, top + height / 2, button)

    def choose(self, menu, action):
        """Chooses an entry of the menu bar. A menu that is still open would be closed by the click."""
        self.wait_items("no open menu", lambda items: not any(name.startswith("entry ") for name in items))
        self.click_item(f"menu {menu}")
        self.click_item(f"entry {action}")

    def drag(self, start, end, button=1, steps=20, pace_s=0.02):
        self.begin_drag(start, end, button, steps, pace_s)
        self.input.release_button(button)

    def begin_drag(self, start, end, button=1, steps=20, pace_s=0.02):
        """Presses a button and moves the mouse; the button stays pressed."""
        self.move(*start)
        self.input.press_button(button)
        for i in range(1, steps + 1):
            share = i / steps
            self.move(start[0] + share * (end[0] - start[0]), start[1] + share * (end[1] - start[1]))
            time.sleep(pace_s)

    def scroll(self, x, y, notches):
        self.move(x, y)
        self.input.scroll(notches)

    # ---- responses
    def wait_event(self, name, seconds=None, after=0, **wanted):
        return self.wait(f"event {name} {wanted}", lambda: next(
            (event for event in self.events[after:]
             if event["event"] == name and all(event.get(k) == v for k, v in wanted.items())), None), seconds)

    def wait_message(self, part, after=0):
        """Waits for a message to the user after the mark `after`; a message is shown for about a second, or until the next one."""
        self.wait(f"message {part}", lambda: any(event["event"] == "message" and part in event["text"] for event in self.events[after:]))

    def wait_state(self, what, test, seconds=None):
        """Waits until the present state or a later one passes a test, and returns it; a busy script reads several at once. A
        state that lacks what the test reads, because it belongs to another mode, does not pass."""
        self.read()
        self.fresh = [self.state]  # without those before
        def passes(state):
            try:
                return state and test(state)
            except (KeyError, IndexError):
                return False

        return next(filter(passes, self.fresh), None) or self.wait(what, lambda: next(filter(passes, self.fresh), None), seconds)

    def wait_items(self, what, test):
        """Waits until the buttons, menus and rows that are shown pass a test."""
        self.wait(what, lambda: test(self.items))

    def _over(self):
        return self.process.poll() is not None

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
        self.input.close() if how == "close" else self.key("ctrl+q")
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

    def wait_end(self, seconds=None):
        code = self.process.wait(timeout=seconds or patience_s())
        self.read()
        self.out.seek(0)
        return code, self.out.read()


def workspace():
    return pathlib.Path(tempfile.mkdtemp(prefix="kerf_window_"))
