#!/usr/bin/env python3
"""Tests `kerf rehearse --igtl` in the real window, with a peer that reads and writes the protocol's bytes itself: what it gets, planes
and points that it sends, their undo, a bone, what is refused, and a tracked tool.

    link_test.py KERF [--pictures FOLDER]

--pictures: keeps the test's pictures. Exit code 77: the test was skipped; it prints the reason."""

import argparse
import pathlib
import re
import shutil
import struct
import sys
import threading
import time

from drive import Display, Window, workspace
from rehearse_test import SCENE

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "session/link"))
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "tools/slicer/KerfLink"))
import peer  # noqa: E402
from KerfLinkLib import messages  # noqa: E402

AXIAL, CORONAL = (0, 0, 1), (0, 1, 0)  # normals


class Peer:
    """Reads everything in a thread of its own."""

    def __init__(self, window):
        self.window = window
        self.socket = peer.connect(self._port_of(window))
        self.last = {}
        threading.Thread(target=self._read, daemon=True).start()

    @staticmethod
    def _port_of(window):
        return int(window.wait("its port", lambda: re.search(r"listening on 127\.0\.0\.1, port (\d+)",
                                                             (window.folder / "out.txt").read_text()))[1])

    def _read(self):
        try:
            while (message := peer.receive(self.socket)) is not None:
                kind, name, body = message
                self.last[f"{kind} {name}"] = body
        except OSError:
            pass

    def wait(self, what, test=lambda body: True):
        self.window.wait(what, lambda: what in self.last and test(self.last[what]))
        return self.last[what]

    def send_pose(self, name, place_ras, normal_ras=AXIAL):
        """Sends the matrix that the module of 3D Slicer makes, or a place that it refuses to send."""
        rows = messages.plane_matrix([p if p == p else 0 for p in place_ras], normal_ras)
        columns = [row[j] for j in range(3) for row in rows[:3]]
        self.socket.sendall(peer.message("TRANSFORM", name, struct.pack(">12f", *columns, *place_ras)))

    def send_points(self, name, points_ras):
        body = b"".join(struct.pack(">64s32s4B4f20s", b"point", b"", 255, 0, 0, 255, *p, 1.0, b"") for p in points_ras)
        self.socket.sendall(peer.message("POINT", name, body))


def edit_plan(kerf, folder, display, keep):
    w = Window(display, kerf, ["rehearse", "bar.toml", "-o", "out", "--igtl", "--igtl-port", "0"], folder, title="kerf rehearse")
    w.wait_event("first_picture")
    w.wait_event("running")
    slicer = Peer(w)
    for what in ("TRANSFORM kerf_tool", "POLYDATA kerf_tool_shape", "POLYDATA kerf_bone", "SENSOR kerf_force", "STRING kerf_names"):
        slicer.wait(what)
    volume = peer.volume_of(slicer.last["POLYDATA kerf_bone"])
    assert abs(volume - 3000) < 30, volume

    # A plane that is dragged in Slicer: 40 poses in a second move it in kerf, and one undo takes them all back.
    before = w.wait_state("the plane of the scene", lambda s: s["planes"] == 1)["plane_mm"]
    for i in range(41):
        slicer.send_pose("cut", (0.1 * i, -0.05 * i, -5), CORONAL)
        time.sleep(0.025)
    w.wait_state("the moved plane", lambda s: s["plane_mm"] == [[-4, 2, -5]] and s["plane_deg"][0][1] == 0)
    w.wait_message("3D Slicer has changed the plan; Shift+Z undoes that.")
    keep(w)
    w.key("shift+z")
    w.wait_state("the plane where it was", lambda s: s["plane_mm"] == before and s["plane_deg"][0][0] == 0)

    # Other names add a plane only with the prefix; points become a plane or the nerve.
    slicer.send_pose("tracker", (0, 0, 0))
    slicer.wait("STATUS kerf", lambda body: b"the plan has no plane 'tracker'" in body)
    slicer.send_pose("cut", (0, 2000, 0))
    slicer.wait("STATUS kerf", lambda body: b"away from the bone" in body)
    slicer.send_pose("cut", (float("nan"), 0, 0))
    slicer.wait("STATUS kerf", lambda body: b"not finite" in body)
    slicer.send_pose("kerf_plan/left", (7, 0, -5))
    w.wait_state("a plane more", lambda s: s["planes"] == 2 and s["plane_mm"][1] == [-7, 0, -5])
    slicer.send_points("kerf_plan/left", [(3, -4, -8), (3, 4, -8), (3, 0, -1)])
    w.wait_state("the plane through points", lambda s: s["plane_mm"][1] == [-3, 0, -5.67] and s["plane_deg"][1][0] == 0)
    slicer.send_points("nerve", [(-12, 0, -7), (0, 1, -7), (12, 0, -7)])
    w.wait_state("the nerve", lambda s: s["marks"] == 1)
    keep(w)

    # Another saw begins another session; the link goes on, with its shape.
    shape = slicer.last["POLYDATA kerf_tool_shape"]
    w.key("2")
    w.wait_state("another saw", lambda s: s["saw"] != "" and s["running"])
    slicer.wait("POLYDATA kerf_tool_shape", lambda body: body != shape)
    w.quit()
    code, out = w.wait_end()
    assert code == 0, out
    slicer.wait("STATUS kerf", lambda body: b"the rehearsal has ended" in body)


def send_bone(kerf, folder, display, keep):
    """A bone in place of the one that is cut: asked first, opened, refused."""
    w = Window(display, kerf, ["rehearse", "bar.toml", "-o", "sent", "--igtl", "--igtl-port", "0"], folder, title="kerf rehearse")
    w.wait_event("first_picture")
    w.wait_event("running")
    slicer = Peer(w)
    assert abs(peer.volume_of(slicer.wait("POLYDATA kerf_bone")) - 3000) < 30

    # 20 x 12 x 8 mm, with an edge of background; the first axis points to the left, as Slicer stores it.
    def block(x, y, z, size):
        return int(all(1 <= i <= n for i, n in zip((x, y, z), size)))

    size = (20, 12, 8)
    labels = [[[block(x, y, z, size) for x in range(22)] for y in range(14)] for z in range(10)]
    steps = [(-1, 0, 0), (0, -1, 0), (0, 0, 1)]
    slicer.send_pose("cut", (1, 0, -5), CORONAL)  # something that is not saved
    w.wait_state("the moved plane", lambda s: s["plane_deg"][0][1] == 0)
    slicer.socket.sendall(peer.bone_message(labels, steps, (5, 0, 40)))
    w.wait_message("3D Slicer has sent a bone.")
    keep(w)
    w.click_item("answer 3")  # stay
    w.wait_state("the same case", lambda s: s["planes"] == 1 and s["running"])
    time.sleep(2.1)  # between two bones
    bar = slicer.last["POLYDATA kerf_bone"]
    slicer.socket.sendall(peer.bone_message(labels, steps, (5, 0, 40)))
    w.click_item("answer 2")  # open without saving
    body = slicer.wait("POLYDATA kerf_bone", lambda body: body != bar)
    # The edges of a label map are rounded.
    assert abs(peer.volume_of(body) - 20 * 12 * 8) < 60, peer.volume_of(body)
    points = [struct.unpack_from(">3f", body, 40 + 12 * i) for i in range(struct.unpack_from(">I", body)[0])]
    middle = [(min(p[a] for p in points) + max(p[a] for p in points)) / 2 for a in range(3)]
    assert max(abs(a - b) for a, b in zip(middle, (5, 0, 40))) < 0.1, middle
    w.wait_state("a case without a plan", lambda s: s["planes"] == 0 and s["running"])
    keep(w)
    # A surface is in mm, however small: a cube of 6 mm. It waits until the notes on the bone before are closed.
    w.click_item("answer 1")
    time.sleep(2.1)  # between two bones
    corners = [(6 * (i & 1), 6 * (i >> 1 & 1), 6 * (i >> 2)) for i in range(8)]
    sides = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    slicer.socket.sendall(peer.surface_message(corners, [t for a, b, c, d in sides for t in ((a, b, c), (a, c, d))]))
    slicer.wait("POLYDATA kerf_bone", lambda body: abs(peer.volume_of(body) - 216) < 10)
    # What is no bone is refused to the peer, and the case goes on.
    time.sleep(2.1)
    labels[5][5][5] = 2
    slicer.socket.sendall(peer.bone_message(labels, steps, (5, 0, 40)))
    slicer.wait("STATUS kerf", lambda body: b"several labels" in body)
    w.quit()
    code, out = w.wait_end()
    assert code == 0, out
    assert (folder / "sent" / "kerf_bone-2.seg.nrrd").exists() and (folder / "sent" / "kerf_bone-3.ply").exists()


def hold_saw(kerf, folder, display, keep):
    w = Window(display, kerf, ["rehearse", "bar.toml", "-o", "tracked", "--igtl", "--igtl-port", "0", "--device", "igtl"], folder,
               title="kerf rehearse")
    w.wait_message("waits for TRANSFORM messages named kerf_hand")
    hand = Peer(w)
    hand.send_pose("kerf_hand", (500, 0, 0))
    w.wait_event("running")
    w.wait_event("first_picture")
    start = w.wait_still("saw_mm")

    def send(places):
        for p in places:
            hand.send_pose("kerf_hand", p)
            time.sleep(0.01)

    # The saw moves as the hand does, from where it was: 8 mm to the right of the patient, 6 mm up. Motion that a busy machine misses
    # is repeated.
    send([(500, 0, 0)] * 30)
    place = (500, 0, 0)
    for _ in range(20_000):
        w.read()
        if w.state["saw_mm"][0] <= start[0] - 8:
            break
        place = (place[0] + 0.04, 0, place[2] + 0.03)
        send([place])
    keep(w)
    # It stops when the poses stop, and does not follow a leap.
    w.wait_message("tracked tool: does not answer: the tool is stopped")
    there = w.wait_still("saw_mm")
    assert abs(there[1] - start[1]) <= 0.1 and abs((there[2] - start[2]) - 0.75 * (start[0] - there[0])) <= 0.2, (start, there)
    assert start[0] - there[0] >= 8, (start, there)
    send([(float("nan"), 0, 0)] * 3)
    w.wait_message("tracked tool: sent a pose that is not valid: it is not used")
    send([place] * 40 + [(5000, 0, 0)] * 40)
    w.wait_message("reported an implausible jump: the tool stays where it was")
    assert max(abs(a - b) for a, b in zip(w.wait_still("saw_mm"), there)) <= 0.2, (w.state["saw_mm"], there)
    w.quit()
    code, out = w.wait_end()
    assert code == 0, out


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kerf")
    parser.add_argument("--pictures")
    options = parser.parse_args()
    folder = workspace()
    (folder / "bar.toml").write_text(SCENE)
    pictures = []

    def keep(window):
        pictures.append(folder / window.picture())

    with Display(1480, 920) as display:
        edit_plan(options.kerf, folder, display, keep)
        send_bone(options.kerf, folder, display, keep)
        hold_saw(options.kerf, folder, display, keep)
    if options.pictures:
        for i, file in enumerate(pictures):
            shutil.copy(file, pathlib.Path(options.pictures) / f"link-{i}.png")
    shutil.rmtree(folder)


if __name__ == "__main__":
    main()
