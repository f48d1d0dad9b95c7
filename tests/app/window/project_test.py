#!/usr/bin/env python3
"""Tests that a project saved in the real window has everything, and that it opens with the same bone and plan.

    project_test.py KERF

Exit code 77: the test was skipped; it prints the reason."""

import argparse
import hashlib
import json
import os
import pathlib
import shutil
import subprocess
import zipfile

from drive import Display, Window, skip_without_display_programs, workspace
from rehearse_test import SCENE


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("kerf")
    options = parser.parse_args()
    skip_without_display_programs()
    folder = workspace()
    (folder / "bar.toml").write_text(SCENE)
    with Display(1480, 920) as display:
        w = Window(display, options.kerf, ["rehearse", "bar.toml", "-o", "out", "--json"], folder, title="kerf rehearse")
        w.wait_event("running")
        w.wait_event("first_picture")
        w.key("v", "l", "space")
        w.wait_state("the spindle turns", lambda s: s["spindle"])
        w._xdotool("keydown", "Down")
        w.wait_state("bone is removed", lambda s: s["removed_mm3"] > 2, 60)
        w._xdotool("keyup", "Down")
        w.key("space")
        w.wait_still("removed_mm3", still_s=0.5)
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
