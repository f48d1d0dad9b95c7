#!/usr/bin/env python3
"""Tests that a project saved in the real window has everything, and that it opens with the same bone and plan.

    project_test.py KERF

Exit code 77: the test was skipped; it prints the reason."""

import argparse
import gzip
import hashlib
import json
import os
import pathlib
import re
import shutil
import struct
import subprocess
import zipfile

from drive import Display, Window, skip_without_display_programs, workspace
from rehearse_test import SCENE


def write_ct(path):
    """Writes a scan of the scene's bar in voxels of 0.5 mm: 30 x 10 x 10 mm, denser to the left."""
    columns, rows, slices = 80, 40, 40
    air = struct.pack("<h", -1000)
    line = b"".join(struct.pack("<h", 1400 + 10 * (i - 40)) if 10 <= i < 70 else air for i in range(columns))
    header = ("NRRD0004\ntype: short\ndimension: 3\nspace: left-posterior-superior\n"
              f"sizes: {columns} {rows} {slices}\nspace directions: (0.5,0,0) (0,0.5,0) (0,0,0.5)\n"
              "kinds: domain domain domain\nendian: little\nencoding: gzip\nspace origin: (-19.75,-9.75,-14.75)\n\n")
    with open(path, "wb") as out:
        out.write(header.encode())
        with gzip.GzipFile(fileobj=out, mode="wb") as packed:
            for k in range(slices):
                for j in range(rows):
                    packed.write(line if 10 <= k < 30 and 10 <= j < 30 else columns * air)


def import_bar(kerf, folder, *options):
    """Makes a bone of the bar's scan, and a scene with it."""
    write_ct(folder / "bar.nrrd")
    subprocess.run([kerf, "import", "bar.nrrd", "-o", "bar.vdb", "--no-isolate", "--voxel", "0.4", *options], cwd=folder,
                   check=True, capture_output=True)
    block = SCENE[SCENE.index("[bone]"):SCENE.index("[tool]")]
    (folder / "ct.toml").write_text(SCENE.replace(block, '[bone]\nfile = "bar.vdb"\n'))


def cut(w):
    """Removes some bone with the keyboard."""
    w.key("v", "l", "space")
    w.wait_state("the spindle turns", lambda s: s["spindle"])
    w._xdotool("keydown", "Down")
    w.wait_state("bone is removed", lambda s: s["removed_mm3"] > 2, 60)
    w._xdotool("keyup", "Down")
    w.key("space")
    return w.wait_still("removed_mm3", still_s=0.5)


def save(w):
    """Saves the project and returns the event."""
    after = w.mark()
    w.key("ctrl+s")
    return w.wait_event("project", after=after)


def export(w):
    """Exports the results and returns the report's text without tags."""
    after = w.mark()
    w.key("F9")
    done = w.wait_event("taken_away", after=after, seconds=120)
    w.wait_state("the question", lambda s: s["dialog"])
    w.key("Escape")
    html = (w.folder / done["folder"] / "report.html").read_text()
    return re.sub(r"<[^>]*>", " ", re.sub(r"<(script|style|svg|figure).*?</\1>", "", html, flags=re.DOTALL))


def end(w):
    w.key("ctrl+q")
    code, out = w.wait_end()
    assert code == 0, out


def reopen_with_ct(kerf):
    """The CT, its grey levels, the saw, the guide, the colours of cut faces and the figures of the sessions are those of the
    moment in which the project was saved."""
    folder = workspace()
    import_bar(kerf, folder, "--keep-hu")
    kept = ("has_ct", "ct_window_HU", "colours", "legend", "saw", "guided")
    with Display(1480, 920) as display:
        w = Window(display, kerf, ["rehearse", "ct.toml", "-o", "out"], folder, title="kerf rehearse")
        w.wait_event("running")
        w.wait_event("first_picture")
        assert w.state["has_ct"], w.state
        removed = cut(w)
        for key, reached in (("3", lambda s: s["saw"] == "coarse disc 22 mm"), ("g", lambda s: s["guided"])):
            after = w.mark()
            w.key(key)
            w.wait_event("running", after=after)
            w.wait_state(f"{key} has taken effect", reached)
        left, top, width, height = w.items["slice 1"]
        w.drag((left + 0.4 * width, top + 0.5 * height), (left + 0.8 * width, top + 0.7 * height), button=3)
        w.wait_state("the grey levels are others", lambda s: s["ct_window_HU"] != [600, 2400])
        w.wait_still("ct_window_HU", still_s=0.5)
        w.wait_state("cut faces are drawn", lambda s: "cortical" in s["legend"])
        state = dict(w.wait_state("nothing moves", lambda s: s["running"]))
        w.key("ctrl+s")
        w.wait_state("it asks where", lambda s: s["dialog"])
        w.key("Return")
        saved = w.wait_event("project")
        assert "failure" not in saved, saved
        end(w)
    project = pathlib.Path(saved["file"])
    with zipfile.ZipFile(project) as archive:
        sessions = json.loads(archive.read("sessions.json"))
        recordings = json.loads(archive.read("manifest.json"))["recordings"]
    assert len(sessions) == len(recordings) == 3, (sessions, recordings)
    first = sessions[0]
    assert abs(first["removed_mm3"] - removed) < 0.1 and first["largest_force_N"] > 0.01, first
    assert sessions[2]["saw"].startswith("coarse disc 22 mm: disc 22 x "), sessions[2]
    (folder / "bar.vdb").unlink()
    shutil.rmtree(folder / "out")

    with Display(1480, 920) as display:
        w = Window(display, kerf, ["rehearse", project.name, "-o", "again"], folder, title="kerf rehearse")
        w.wait_event("running")
        w.wait_event("first_picture")
        w.wait_state("the same as before", lambda s: all(s[name] == state[name] for name in kept))
        assert not any("does not contain the CT" in e.get("text", "") for e in w.events), w.events
        report = " ".join(export(w).split())
        assert f" case {project.stem} " in report, report
        assert f"largest force on the hand {first['largest_force_N']:.2f} N" in report, report
        assert "80 x 40 x 40 voxels of 0.5 x 0.5 x 0.5 mm" in report, report
        assert "coarse disc 22 mm: disc 22 x" in report, report
        # Saved again, it has the sessions of both windows.
        assert "failure" not in save(w)
        end(w)
    with zipfile.ZipFile(project) as archive:
        assert json.loads(archive.read("sessions.json"))[:3] == sessions
        assert len(json.loads(archive.read("manifest.json"))["recordings"]) == 4
    shutil.rmtree(folder)


def reopen_without_ct(kerf):
    """A bone of a CT whose numbers were not kept: a message says so."""
    folder = workspace()
    import_bar(kerf, folder)
    with Display(1480, 920) as display:
        w = Window(display, kerf, ["rehearse", "ct.toml", "-o", "out"], folder, title="kerf rehearse")
        w.wait_event("running")
        assert not w.state["has_ct"], w.state
        w.key("ctrl+s")
        w.wait_state("it asks where", lambda s: s["dialog"])
        w.key("Return")
        project = w.wait_event("project")["file"]
        end(w)
        w = Window(display, kerf, ["rehearse", project, "-o", "again"], folder, title="kerf rehearse")
        w.wait_event("running")
        w.wait_message("does not contain the CT")
        end(w)
    shutil.rmtree(folder)


def lose_the_recording(kerf):
    """The session ends when its recording cannot be written, while the dialog to save is open: the window says so."""
    folder = workspace()
    (folder / "bar.toml").write_text(SCENE)
    with Display(1480, 920) as display:
        w = Window(display, kerf, ["rehearse", "bar.toml", "-o", "out"], folder, title="kerf rehearse")
        w.wait_event("running")
        w.wait_event("first_picture")
        w.key("ctrl+s")
        w.wait_state("it asks where", lambda s: s["dialog"])
        shutil.rmtree(folder / "out")
        w.wait_event("ended")
        for _ in range(3):  # the cause, and the dialog for the file if it is still there
            w.key("Return")
        w.wait_state("nothing is asked", lambda s: not s["dialog"])
        w.key("ctrl+q")
        code, out = w.wait_end()
        assert code in (0, 1), (code, out)
        assert "out/" in out and "session" in out, out  # the cause, in one sentence
    assert not list(folder.glob("*.kerf-project")), "nothing was saved"
    shutil.rmtree(folder)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kerf")
    options = parser.parse_args()
    skip_without_display_programs()
    reopen_with_ct(options.kerf)
    reopen_without_ct(options.kerf)
    lose_the_recording(options.kerf)
    folder = workspace()
    (folder / "bar.toml").write_text(SCENE)
    with Display(1480, 920) as display:
        w = Window(display, options.kerf, ["rehearse", "bar.toml", "-o", "out", "--json"], folder, title="kerf rehearse")
        w.wait_event("running")
        w.wait_event("first_picture")
        cut(w)
        w.key("ctrl+s")
        w.wait_state("it asks where", lambda s: s["dialog"])
        w.key("Return")
        saved = w.wait_event("project")
        assert "failure" not in saved, saved
        w.key("ctrl+q")
        code, out = w.wait_end()
        assert code == 0, out

    # The file is a ZIP file that others can read, and its digests are those of BLAKE2b with 256 bits.
    project = pathlib.Path(saved["file"])
    assert project == folder / "bar.kerf-project", project
    with zipfile.ZipFile(project) as archive:
        manifest = json.loads(archive.read("manifest.json"))
        content = {name: archive.read(name) for name in archive.namelist() if name != "manifest.json"}
    assert {m["name"] for m in manifest["members"]} == set(content), manifest
    for member in manifest["members"]:
        digest = hashlib.blake2b(content[member["name"]], digest_size=32).hexdigest()
        assert digest == member["blake2b"], member
    assert {"scene.toml", "bone.vdb", "cut.vdb"} <= set(content), set(content)
    assert content["bone.vdb"] != content["cut.vdb"], "the bone was cut"

    moved = folder / "moved.kerf-project"
    shutil.move(project, moved)
    shutil.rmtree(folder / "out")
    with Display(1480, 920) as display:
        w = Window(display, options.kerf, ["rehearse", moved.name, "-o", "again", "--json"], folder, title="kerf rehearse")
        w.wait_event("running")
        w.wait_event("first_picture")
        assert w.state["planes"] == 1, "the plan is there"
        w.key("ctrl+q")
        code, out = w.wait_end()
        assert code == 0, out
    assert (folder / "again" / "project" / "cut.vdb").read_bytes() == content["cut.vdb"], "the bone is the same"

    # A damaged project is refused with one sentence.
    moved.write_bytes(moved.read_bytes()[:-100])
    with Display(1480, 920) as display:
        done = subprocess.run([options.kerf, "rehearse", moved.name, "-o", "damaged"], cwd=folder, capture_output=True,
                              text=True, timeout=120, env={**os.environ, "DISPLAY": display.name})
    assert done.returncode == 1 and "moved.kerf-project: is not a complete ZIP file" in done.stderr, done.stderr
    assert done.stderr.count("\n") == 1, done.stderr
    shutil.rmtree(folder)
    print("project saved and opened")


if __name__ == "__main__":
    main()
