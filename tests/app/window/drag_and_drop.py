"""Drags a file from another program into a window, as a file manager does (XDND, version 5).

    drag_and_drop.py WINDOW FILE

Ends with 0 once the window has taken the file, and with 1 if it refuses it or does not answer."""

import ctypes
import pathlib
import sys
import time

x = ctypes.CDLL("libX11.so.6")
x.XOpenDisplay.restype = ctypes.c_void_p
x.XInternAtom.restype = x.XCreateSimpleWindow.restype = x.XDefaultRootWindow.restype = ctypes.c_ulong

CLIENT_MESSAGE, SELECTION_REQUEST, SELECTION_NOTIFY = 33, 30, 31


class ClientMessage(ctypes.Structure):
    _fields_ = [("type", ctypes.c_int), ("serial", ctypes.c_ulong), ("send_event", ctypes.c_int),
                ("display", ctypes.c_void_p), ("window", ctypes.c_ulong), ("message_type", ctypes.c_ulong),
                ("format", ctypes.c_int), ("data", ctypes.c_long * 5)]


class SelectionRequest(ctypes.Structure):
    _fields_ = [("type", ctypes.c_int), ("serial", ctypes.c_ulong), ("send_event", ctypes.c_int),
                ("display", ctypes.c_void_p), ("owner", ctypes.c_ulong), ("requestor", ctypes.c_ulong),
                ("selection", ctypes.c_ulong), ("target", ctypes.c_ulong), ("property", ctypes.c_ulong),
                ("time", ctypes.c_ulong)]


class SelectionNotify(ctypes.Structure):
    _fields_ = [("type", ctypes.c_int), ("serial", ctypes.c_ulong), ("send_event", ctypes.c_int),
                ("display", ctypes.c_void_p), ("requestor", ctypes.c_ulong), ("selection", ctypes.c_ulong),
                ("target", ctypes.c_ulong), ("property", ctypes.c_ulong), ("time", ctypes.c_ulong)]


class Event(ctypes.Union):
    _fields_ = [("type", ctypes.c_int), ("message", ClientMessage), ("request", SelectionRequest),
                ("notify", SelectionNotify), ("pad", ctypes.c_long * 24)]


def main():
    target = int(sys.argv[1])
    uris = (pathlib.Path(sys.argv[2]).absolute().as_uri() + "\r\n").encode()
    display = ctypes.c_void_p(x.XOpenDisplay(None))
    atom = {name: x.XInternAtom(display, name.encode(), 0)
            for name in ("XdndEnter", "XdndPosition", "XdndStatus", "XdndDrop", "XdndFinished", "XdndSelection",
                         "XdndActionCopy", "text/uri-list")}
    root = x.XDefaultRootWindow(display)
    source = x.XCreateSimpleWindow(display, ctypes.c_ulong(root), 0, 0, 1, 1, 0, ctypes.c_ulong(0), ctypes.c_ulong(0))
    x.XSetSelectionOwner(display, ctypes.c_ulong(atom["XdndSelection"]), ctypes.c_ulong(source), ctypes.c_ulong(0))

    def send(event, to):
        x.XSendEvent(display, ctypes.c_ulong(to), 0, ctypes.c_long(0), ctypes.byref(event))
        x.XFlush(display)

    def tell(name, *data):
        event = Event()
        event.message = ClientMessage(type=CLIENT_MESSAGE, send_event=1, window=target, message_type=atom[name], format=32)
        for i, value in enumerate((source, *data)):
            event.message.data[i] = value
        send(event, target)

    def wait(name):
        """Waits for the target's message, and answers its request for the file's name."""
        deadline = time.monotonic() + 60
        event = Event()
        while time.monotonic() < deadline:
            if x.XPending(display) == 0:
                time.sleep(0.02)
                continue
            x.XNextEvent(display, ctypes.byref(event))
            if event.type == CLIENT_MESSAGE and event.message.message_type == atom[name]:
                return event.message.data[1]
            if event.type != SELECTION_REQUEST:
                continue
            asked = event.request
            x.XChangeProperty(display, ctypes.c_ulong(asked.requestor), ctypes.c_ulong(asked.property),
                              ctypes.c_ulong(asked.target), 8, 0, uris, len(uris))
            answer = Event()
            answer.notify = SelectionNotify(type=SELECTION_NOTIFY, send_event=1, requestor=asked.requestor,
                                            selection=asked.selection, target=asked.target, property=asked.property,
                                            time=asked.time)
            send(answer, asked.requestor)
        sys.exit(f"no {name}")

    tell("XdndEnter", 5 << 24, atom["text/uri-list"])
    tell("XdndPosition", 0, 200 << 16 | 200, 0, atom["XdndActionCopy"])
    if wait("XdndStatus") & 1 == 0:
        sys.exit("the window does not take files")
    tell("XdndDrop", 0, 0)
    wait("XdndFinished")  # GLFW 3.3.8 answers with the number of bytes: even if it has taken the file, bit 0 may be 0


if __name__ == "__main__":
    main()
