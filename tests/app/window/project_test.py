#!/usr/bin/env python3
"""Tests that a project saved in the real window has everything, and that it opens with the same bone and plan.

    project_test.py KERF

Exit code 77: the test was skipped; it prints the reason."""

import argparse
import gzip
import hashlib
import json
import pathlib
import re
import shutil
import struct
import subprocess
import zipfile

from drive import Display, Window, run_without_events, workspace
from rehearse_test import SCENE


def write_ct(path, gap=0):
    """Writes a scan of the scene's bar in voxels of 0.5 mm: 30 x 10 x 10 mm, denser to the left. `gap`: columns of voxels
    at its middle, on each side, that are air."""
    columns, rows, slices = 80, 40, 40
    air = struct.pack("<h", -1000)
    line = b"".join(struct.pack("<h", 1400 + 10 * (i - 40)) if 10 <= i < 40 - gap or 40 + gap <= i < 70 else air
                    for i in range(columns))
    header = ("NRRD0004\ntype: short\ndimension: 3\nspace: left-posterior-superior\n"
              f"sizes: {columns} {rows} {slices}\nspace directions: (0.5,0,0) (0,0.5,0) (0,0,0.5)\n"
              "kinds: domain domain domain\nendian: little\nencoding: gzip\nspace origin: (-19.75,-9.75,-14.75)\n\n")
    with open(path, "wb") as out:
        out.write(header.encode())
        with gzip.GzipFile(fileobj=out, mode="wb") as packed:
            for k in range(slices):
                for j in range(rows):
                    packed.write(line if 10 <= k < 30 and 10 <= j < 30 else columns * air)


def import_bar(kerf, folder, *options, gap=0):
    """Makes a bone of the bar's scan, and a scene with it."""
    write_ct(folder / "bar.nrrd", gap)
    subprocess.run([kerf, "import", "bar.nrrd", "-o", "bar.vdb", "--no-isolate", "--voxel", "0.4", *options], cwd=folder,
                   check=True, capture_output=True)
    block = SCENE[SCENE.index("[bone]"):SCENE.index("[tool]")]
    (folder / "ct.toml").write_text(SCENE.replace(block, '[bone]\nfile = "bar.vdb"\n'))


def cut(w):
    """Removes some bone with the keyboard."""
    w.key("v", "l", "space")
    w.wait_state("the spindle turns", lambda s: s["spindle"])
    w.press("Down")
    w.wait_state("bone is removed", lambda s: s["removed_mm3"] > 2)
    w.release("Down")
    w.key("space")
    return w.wait_still("removed_mm3", still_s=0.5)


def save(w):
    """Saves the project and returns the event."""
    after = w.mark()
    w.key("ctrl+s")
    return w.wait_event("project", after=after)


def export_results(w):
    """Exports the results and returns their folder."""
    after = w.mark()
    w.key("F9")
    w.wait_state("it asks for the folder", lambda s: s["entry"])
    w.key("Return")
    done = w.wait_event("taken_away", after=after)
    w.wait_state("the question", lambda s: s["dialog"])
    w.key("Escape")
    w.wait_state("no question", lambda s: not s["dialog"])
    return w.folder / done["folder"]


def export(w):
    """Exports the results and returns the report's text without tags."""
    html = (export_results(w) / "report.html").read_text()
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
        assert (project.parent / f"{project.stem}-export/report.html").exists(), "it is beside the project"
        turning = max(s["turning_force_N"] for s in sessions)
        assert f"largest force on the hand in bone, spindle turning {turning:.2f} N" in report, report
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


def unzipped_text(project, name):
    with zipfile.ZipFile(project) as archive:
        return archive.read(name).decode()


def save_as(w, name):
    """Saves the project under a name and returns the event."""
    after = w.mark()
    w.key("ctrl+shift+s")
    w.wait_state("it asks where", lambda s: s["entry"])
    w.key("ctrl+a")
    w.type(str(name))
    w.key("Return")
    return w.wait_event("project", after=after)


def lose_the_recording(kerf):
    """The session ends when its recording cannot be written: the window says so and keeps the bone and the plan, which
    are saved and exported elsewhere. The exit code says that the recording is not whole."""
    folder = workspace()
    (folder / "bar.toml").write_text(SCENE)
    with Display(1480, 920) as display:
        w = Window(display, kerf, ["rehearse", "bar.toml", "-o", "out"], folder, title="kerf rehearse", may_fail=True)
        w.wait_event("running")
        w.wait_event("first_picture")
        cut(w)
        w.key("n", "2")
        w.wait_state("a new plane", lambda s: s["planes"] == 2)
        # A dialog that was open before the end cannot save anything that is not there any more.
        w.key("ctrl+s")
        w.wait_state("it asks where", lambda s: s["entry"])
        shutil.rmtree(folder / "out")
        assert w.wait_event("ended")["failure"] == ""
        why = w.wait_event("work_kept")["failure"]
        w.wait_state("the question", lambda s: s["dialog"] and not s["entry"] and s["work_kept"])
        # Quitting asks, also within this question.
        w.key("ctrl+q")
        w.wait_state("it asks whether to quit", lambda s: s["dialog"] and s["unsaved"])
        w.key("Escape")
        w.wait_state("it stays", lambda s: not s["dialog"])
        w.key("ctrl+s")
        w.wait_state("it asks where", lambda s: s["entry"])
        w.key("Return")
        saved = w.wait_event("project")
        assert "failure" not in saved, saved
        w.wait_state("saved", lambda s: not s["unsaved"] and s["planes"] == 2)
        after = w.mark()
        w.key("F9")
        w.wait_state("it asks where", lambda s: s["entry"])
        w.key("Return")
        taken = w.wait_event("taken_away", after=after)
        assert taken.get("folder") == str(folder / "bar-export"), taken
        w.wait_state("the question", lambda s: s["dialog"])
        w.key("Escape")
        w.wait_state("no question", lambda s: not s["dialog"])
        w.key("ctrl+q")
        code, out = w.wait_end()
        assert code == 1 and f"kerf: {why}" in out, (code, out)
        assert "the recording ended at" in why and why.count("out/session.kerf") >= 1, why
        assert not (folder / "out").exists(), "nothing was written there"
        assert (folder / "bar-export" / "report.html").exists()

        project = pathlib.Path(saved["file"])
        with zipfile.ZipFile(project) as archive:
            assert archive.read("bone.vdb") != archive.read("cut.vdb"), "the bone was cut"
            assert json.loads(archive.read("manifest.json"))["recordings"] == []
            sessions = json.loads(archive.read("sessions.json"))
        assert len(sessions) == 1 and sessions[0]["removed_mm3"] > 2 and sessions[0]["recorded"] is False, sessions
        w = Window(display, kerf, ["rehearse", project.name, "-o", "again"], folder, title="kerf rehearse", may_fail=True)
        w.wait_event("running")
        w.wait_state("the plan", lambda s: s["planes"] == 2)
        assert "failure" not in save(w)
        end(w)
    sessions = json.loads(unzipped_text(project, "sessions.json"))
    assert [s.get("recorded", True) for s in sessions] == [False, True], sessions
    shutil.rmtree(folder)


def lose_the_next_session(kerf):
    """Another saw, whose session cannot begin: the bone and the plan of the session before are kept."""
    for name, make in (("path-2.csv", pathlib.Path.mkdir), ("session-2.kerf", pathlib.Path.touch)):
        folder = workspace()
        (folder / "bar.toml").write_text(SCENE)
        with Display(1480, 920) as display:
            w = Window(display, kerf, ["rehearse", "bar.toml", "-o", "out"], folder, title="kerf rehearse", may_fail=True)
            w.wait_event("running")
            w.wait_event("first_picture")
            cut(w)
            make(folder / "out" / name)
            w.key("3")
            why = w.wait_event("work_kept")["failure"]
            assert name in why, why
            w.wait_state("the question", lambda s: s["dialog"])
            w.key("Return")  # save the project as
            w.wait_state("it asks where", lambda s: s["entry"])
            # The files of the scene are not needed for that.
            shutil.rmtree(folder / "out")
            w.key("Return")
            saved = w.wait_event("project")
            assert "failure" not in saved, saved
            w.key("ctrl+q")
            code, out = w.wait_end()
            assert code == 1 and f"kerf: {why}" in out, (code, out)
            # Quitting without saving is possible too, and opening something else asks.
            w = Window(display, kerf, ["rehearse", "bar.toml", "-o", "again"], folder, title="kerf rehearse", may_fail=True)
            w.wait_event("running")
            make(folder / "again" / name)
            w.key("3")
            w.wait_event("work_kept")
            w.wait_state("the question", lambda s: s["dialog"])
            w.key("Escape")
            w.wait_state("no question", lambda s: not s["dialog"])
            w.wait_items("no buttons", lambda items: "answer 2" not in items)
            w.key("ctrl+q")
            w.wait_state("it asks", lambda s: s["dialog"])
            w.click_item("answer 2")
            code, out = w.wait_end()
            assert code == 1 and name in out, (code, out)
        with zipfile.ZipFile(saved["file"]) as archive:
            assert archive.read("bone.vdb") != archive.read("cut.vdb"), "the bone was cut"
            sessions = json.loads(archive.read("sessions.json"))
        assert len(sessions) == 1, sessions
        shutil.rmtree(folder)


def save_elsewhere(kerf):
    """A project that cannot be saved under another name keeps its name; a save during another one follows it."""
    folder = workspace()
    (folder / "bar.toml").write_text(SCENE)
    with Display(1480, 920) as display:
        w = Window(display, kerf, ["rehearse", "bar.toml", "-o", "out"], folder, title="kerf rehearse")
        w.wait_event("running")
        w.wait_event("first_picture")
        good = folder / "good.kerf-project"
        assert save_as(w, good) == w.wait_event("project", file=str(good))
        # Nothing can be written there.
        for changed in (False, True):
            if changed:
                w.key("n", "2")
                w.wait_state("a new plane", lambda s: s["planes"] == 2)
            assert w.wait_state("unsaved or not", lambda s: s["unsaved"] == changed)
            assert "failure" in save_as(w, "/proc/bad.kerf-project")
            w.wait_state("unsaved as before", lambda s: s["unsaved"] == changed)
        recent = json.loads((folder / "config/kerf/window.json").read_text())["recent"]
        assert recent[0] == str(good) and not any("bad" in name for name in recent), recent
        assert save(w)["file"] == str(good)
        w.wait_state("saved", lambda s: not s["unsaved"])
        # Several saves at once: each is done.
        w.key("n", "2")
        w.wait_state("a new plane", lambda s: s["planes"] == 3)
        after = w.mark()
        w.key("ctrl+s", "ctrl+s", "ctrl+s")
        w.wait_state("three saves", lambda s: len([e for e in w.events[after:] if e["event"] == "project"]) == 3)
        assert all(e.get("file") == str(good) for e in w.events[after:] if e["event"] == "project"), w.events[after:]
        end(w)
    assert unzipped_text(good, "scene.toml").count("[[plan.plane]]") == 3
    assert json.loads(unzipped_text(good, "manifest.json"))["title"] == "good"
    shutil.rmtree(folder)


def replay_sessions(kerf):
    """Each recording of a project replays after everything else is gone, also after the project was opened and saved
    again."""
    folder = workspace()
    (folder / "bar.toml").write_text(SCENE)
    with Display(1480, 920) as display:
        w = Window(display, kerf, ["rehearse", "bar.toml", "-o", "out"], folder, title="kerf rehearse")
        w.wait_event("running")
        w.wait_event("first_picture")
        for key in ("3", "4"):  # a cut before each saw, so that each session begins with another bone
            cut(w)
            after = w.mark()
            w.key(key)
            w.wait_event("running", after=after)
        cut(w)
        project = save_as(w, folder / "case.kerf-project")["file"]
        end(w)
        shutil.rmtree(folder / "out")
        w = Window(display, kerf, ["rehearse", project, "-o", "again"], folder, title="kerf rehearse")
        w.wait_event("running")
        w.wait_event("first_picture")
        cut(w)
        assert "failure" not in save(w)
        end(w)
        shutil.rmtree(folder / "again")
    with zipfile.ZipFile(project) as archive:
        archive.extractall(folder / "unzipped")
    recordings = sorted((folder / "unzipped/recordings").iterdir())
    assert len(recordings) == 4, recordings
    bones = [file.read_bytes() for file in (folder / "unzipped").rglob("*.vdb")]
    assert len(bones) == len(set(bones)), "each bone is stored once"
    for recording in recordings:
        done = subprocess.run([kerf, "replay", str(recording), "--verify"], capture_output=True, text=True)
        # The recording of a session that was still running when the project was saved has no end: exit code 3.
        assert done.returncode in (0, 3), (recording, done.stdout, done.stderr)
        assert "differs" not in done.stdout + done.stderr, (recording, done.stdout, done.stderr)

    # More sessions than recordings are refused.
    refuse_forged(kerf, project, "sessions.json", lambda sessions: sessions + [{"saw": "x"}],
                  "lists 5 recorded sessions, but there are 4 recordings")
    shutil.rmtree(folder)


def refuse_forged(kerf, project, name, change, sentence):
    """A project is refused with a sentence if the content of a member is changed, also if the manifest states the digest
    of the changed content."""
    project = pathlib.Path(project)
    forged = project.with_name("forged.kerf-project")
    with zipfile.ZipFile(project) as archive, zipfile.ZipFile(forged, "w") as out:
        content = {member: archive.read(member) for member in archive.namelist()}
        content[name] = json.dumps(change(json.loads(content[name]))).encode()
        manifest = json.loads(content["manifest.json"])
        for member in manifest["members"]:
            if member["name"] == name:
                member["bytes"] = len(content[name])
                member["blake2b"] = hashlib.blake2b(content[name], digest_size=32).hexdigest()
        content["manifest.json"] = json.dumps(manifest).encode()
        for member, data in content.items():
            out.writestr(member, data)
    with Display(1480, 920) as display:
        done = run_without_events([kerf, "rehearse", forged.name, "-o", "forged"], cwd=project.parent, env=display.environment(kerf))
    assert done.returncode == 1 and sentence in done.stderr and done.stderr.count("\n") == 1, done.stderr


def measurements_of_export(w):
    """Exports the results and returns the lines of the user's measurements."""
    lines = (export_results(w) / "measures.csv").read_text().splitlines()
    return [line for line in lines if "distance 1" in line or "angle 2" in line]


def keep_measurements(kerf):
    """Distances and angles are in the project with the points of the pieces to which they belong, and in the report of
    the reopened project; measuring and deleting count as unsaved."""
    folder = workspace()
    import_bar(kerf, folder, "--keep-hu", gap=2)
    arguments = ["--size", "1280x720"]
    centre = (640, 360)

    def measure(w, key, places):
        after = w.mark()
        w.key(key)
        for x in places:
            w.click(centre[0] + x, centre[1])
        w.wait_event("measure", after=after)
        w.key("Escape")
        return w.wait_state("the measurement is over", lambda s: not s["measuring"])

    def enter_pieces(w):
        w.key("v", "p")
        assert w.wait_event("pieces")["count"] == 2, w.events
        w.wait_event("contact")

    with Display(1480, 920) as display:
        w = Window(display, kerf, ["rehearse", "ct.toml", "-o", "out", *arguments], folder, title="kerf rehearse")
        w.wait_event("running")
        w.wait_event("first_picture")
        enter_pieces(w)
        assert not w.state["unsaved"], "looking at the pieces changes nothing"
        # Each row has the volume and the gap: that of the bar, 2 mm, less the voxels at its faces.
        w.wait_state("rows", lambda s: all(re.fullmatch(r"1.\d+ cm³; gap [12].\d+ mm with piece [12]", row)
                                           for row in s["piece_rows"]) and len(s["piece_rows"]) == 2)
        # The description of a piece that was picked is a message like others.
        after = w.mark()
        w.key("Tab")
        w.wait_message("piece 1: ", after=after)
        w.wait_state("no message", lambda s: s["message"] == "")
        # A checkpoint is work, too.
        w.key("c")
        w.wait_state("it asks for a name", lambda s: s["entry"])
        w.key("Return")
        w.wait_state("a checkpoint", lambda s: s["unsaved"])
        w.key("BackSpace")  # there is nothing to delete
        measure(w, "d", (-100, 100))
        assert w.state["unsaved"] and len(w.state["measured"]) == 1, w.state
        project = save_as(w, folder / "case.kerf-project")["file"]
        w.wait_state("saved", lambda s: not s["unsaved"])
        w.key("BackSpace")
        w.wait_state("deleting is a change", lambda s: s["measured"] == [] and s["unsaved"])
        assert "failure" not in save(w)
        w.wait_state("saved without it", lambda s: not s["unsaved"])
        with zipfile.ZipFile(project) as archive:
            assert "measurements.json" not in archive.namelist()
        measure(w, "d", (-100, 100))
        measure(w, "j", (-100, 100, -50))
        # The points move with their pieces.
        distance = w.state["measured"][0]
        w.key("a", "Tab", "Right", "Right", "Right")
        w.wait_state("another distance", lambda s: abs(abs(s["measured"][0] - distance) - 1.5) < 0.1)
        measured, labels = w.state["measured"], w.state["measurement_labels"]
        assert re.fullmatch(r"\d+\.\d mm", labels[0]) and re.fullmatch(r"\d+\.\d°", labels[1]), labels
        lines = measurements_of_export(w)
        assert len(lines) == 2, lines
        w.key("t", "p")
        w.wait_state("the saw", lambda s: s["mode"] == "cutting")
        assert "failure" not in save(w)
        end(w)
        shutil.rmtree(folder / "out")

        w = Window(display, kerf, ["rehearse", project, "-o", "again", *arguments], folder, title="kerf rehearse")
        w.wait_event("running")
        w.wait_event("first_picture")
        # They are kept by a save and an export even if the pieces are not looked at.
        assert "failure" not in save(w)
        assert measurements_of_export(w) == lines
        enter_pieces(w)
        w.wait_state("the same", lambda s: s["measured"] == measured and s["measurement_labels"] == labels)
        assert not w.state["unsaved"], w.state
        assert measurements_of_export(w) == lines
        w.key("shift+r")
        w.wait_state("the first distance", lambda s: s["measured"][0] == distance)
        w.key("ctrl+z")
        w.wait_state("the same again", lambda s: s["measured"] == measured)
        assert "failure" not in save(w)
        end(w)
        shutil.rmtree(folder / "again")

        # The project was saved while the pieces were shown, and begins with them.
        w = Window(display, kerf, ["rehearse", project, "-o", "third", *arguments], folder, title="kerf rehearse")
        w.wait_event("pieces")
        w.wait_state("the same", lambda s: s["mode"] == "pieces" and s["measured"] == measured)
        w.wait_state("translucent", lambda s: s["translucent"])
        w.key("Escape")
        w.wait_state("the saw", lambda s: s["mode"] == "cutting")
        end(w)
    assert [len(m["points"]) for m in json.loads(unzipped_text(project, "measurements.json"))] == [2, 3]

    def rename(measurements):
        measurements[0]["points"][1]["piece"] = "piece 9"
        return measurements
    refuse_forged(kerf, project, "measurements.json", rename, "names 'piece 9', which is not a piece of the project")
    refuse_forged(kerf, project, "measurements.json", lambda m: [{"points": m[0]["points"][:1]}],
                  "a measurement has neither 2 points (a distance) nor 3 (an angle)")
    shutil.rmtree(folder)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kerf")
    options = parser.parse_args()
    reopen_with_ct(options.kerf)
    reopen_without_ct(options.kerf)
    lose_the_recording(options.kerf)
    lose_the_next_session(options.kerf)
    save_elsewhere(options.kerf)
    replay_sessions(options.kerf)
    keep_measurements(options.kerf)
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
        # A cut is work that is not saved: quitting and opening something else ask. Then it is saved, and the other bone is
        # opened.
        cut(w)
        w.key("ctrl+q")
        w.wait_state("a question", lambda s: s["dialog"])
        w.key("Escape")
        w.wait_state("it stays", lambda s: not s["dialog"] and s["running"])
        after = w.mark()
        w.key("ctrl+o")
        w.wait_state("it asks for a file", lambda s: s["dialog"])
        w.type(str(folder / "bar.toml"))
        w.key("Return")
        w.click_item("answer 1")
        again = w.wait_event("project", after=after)
        assert "failure" not in again, again
        w.wait_event("running", after=after)
        with zipfile.ZipFile(moved) as archive:
            assert archive.read("cut.vdb") != content["cut.vdb"], "the second cut is saved"
        w.key("ctrl+q")
        code, out = w.wait_end()
        assert code == 0, out
    assert (folder / "again" / "project" / "cut.vdb").read_bytes() == content["cut.vdb"], "the bone is the same"

    # A damaged project is refused with one sentence.
    moved.write_bytes(moved.read_bytes()[:-100])
    with Display(1480, 920) as display:
        done = run_without_events([options.kerf, "rehearse", moved.name, "-o", "damaged"], cwd=folder,
                                  env=display.environment(options.kerf))
    assert done.returncode == 1 and "moved.kerf-project: is not a complete ZIP file" in done.stderr, done.stderr
    assert done.stderr.count("\n") == 1, done.stderr
    shutil.rmtree(folder)
    print("project saved and opened")


if __name__ == "__main__":
    main()
