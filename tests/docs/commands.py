#!/usr/bin/env python3
"""Runs the commands that README.md and the pages of docs show, as a reader would type them.

    tests/docs/commands.py KERF [--page NAME ...] [--list]

Each page has a folder of its own with the files that its commands name (make_files()), in which its commands run one
after another; each must end with exit code 0 and without an error message. A command that needs a display, a device, a
real CT, or more than a minute is in commands.txt with its reason. Every option of every command, including these, must
be in `kerf reference`. Commands of other programs (tools/..., cmake) must exist. Python snippets also run, with a
substitute for matplotlib that draws nothing. Exit code 1 if any of these checks fails.
"""

import argparse
import json
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md")),
         *sorted((ROOT / "docs/tutorials").glob("*.md"))]
# These pages are printed by the program itself; their examples are checked separately.
LEFT_OUT = {"commands.md", "scene_keys.md"}

# A small scene that any command can use.
SCENE = """title = "Block"
[bone]
model = "block"
[bone.block]
size_x_mm = 16
size_y_mm = 6
size_z_mm = 12
voxel_mm = 0.2
[[path.stroke]]
start_mm = [0, 0, 13]
end_mm = [0, 0, 6]
feed_mm_per_s = 6
disc_normal = [1, 0, 0]
[effects.guide]
point_mm = [0, 0, 0]
normal = [1, 0, 0]
[[plan.plane]]
name = "cut"
point_mm = [0, 0, 0]
normal = [1, 0, 0]
[slab]
direction = [0, 0, -1]
"""
# Cuts the block that the first scene has cut.
SECOND = re.sub(r"(?s)model = .*?\[\[path", 'file = "one/bone.vdb"\n[[path', SCENE).replace("_mm = [0, 0,", "_mm = [4, 0,")


def list_commands(page):
    """Returns the commands in the code of a page, with continuation lines joined and comments removed."""
    code, text, commands = False, "", []
    for number, line in enumerate(page.read_text(encoding="utf-8").splitlines(), 1):
        if line.startswith("```"):
            code = not code
            continue
        if not code and not line.startswith("    "):
            continue
        text += line.strip()
        if text.endswith("\\"):
            text = text[:-1]
            continue
        if re.match(r"(kerf [a-z-]|(tools|tests|\.ci)/|cmake |ctest |build/release/)", text) and not text.startswith("kerf:"):
            commands.append((number, re.sub(r"\s+#.*", "", text)))
        text = ""
    return commands


def list_snippets(page):
    """Returns [(line, text)] of the Python snippets of a page."""
    text = page.read_text(encoding="utf-8")
    return [(text[:match.start()].count("\n") + 1, match.group(1)) for match in re.finditer(r"^```python\n(.*?)^```", text, re.M | re.S)]


def write_saved_files(page, folder):
    """Writes the TOML snippets that a page says to save under a name: "save it as `NAME`"."""
    text = page.read_text(encoding="utf-8")
    for match in re.finditer(r"save\s+it\s+as\s+`([^`]+)`[^#]*?^```toml\n(.*?)^```", text, re.M | re.S):
        (folder / match.group(1)).write_text(match.group(2))


def read_rules():
    rules = []
    for line in (pathlib.Path(__file__).parent / "commands.txt").read_text(encoding="utf-8").splitlines():
        if line and not line.startswith("#"):
            pattern, reason = line.split("\t")
            rules.append((re.compile(pattern), reason))
    return rules


class Reference:
    """The names of the options of each command."""

    def __init__(self, kerf):
        root = json.loads(subprocess.run([kerf, "reference", "--json"], capture_output=True, text=True, check=True).stdout)
        self.commands = {}
        self._add(root)

    def _add(self, command):
        self.commands[command["name"]] = {name for option in command["options"] for name in option["names"]}
        for child in command["commands"]:
            self._add(child)

    def check(self, words):
        """Returns a phrase that describes the fault in a command line of kerf; "" if there is none."""
        name, rest = "kerf", words[1:]
        while rest and f"{name} {rest[0]}" in self.commands:
            name, rest = f"{name} {rest[0]}", rest[1:]
        if name == "kerf" and rest and not rest[0].startswith("-"):
            return f"there is no command {rest[0]}"
        for word in (word.split("=")[0] for word in rest):
            if re.match(r"--?[a-z]", word) and word not in self.commands[name]:
                return f"{name} has no option {word}"
        return ""


def coarsen_mandibles(folder):
    """Gives the generated mandibles of all scenes coarse voxels; tools/run and the tests of `kerf run` make fine ones."""
    for scene in [*folder.glob("*.toml"), *folder.glob("scenes/*.toml"), *folder.glob("out/*.toml")]:
        text = scene.read_text(encoding="utf-8")
        coarse = re.sub(r"^(\[bone\.mandible\]\n(?:(?!\[).*\n)*?voxel_mm = )0\.[0-7]\d*", r"\g<1>0.8", text, flags=re.M)
        if coarse != text:
            scene.write_text(coarse, encoding="utf-8")


def make_files(kerf, folder):
    """Makes the files that pages name in their examples."""
    def call(*arguments):
        subprocess.run([kerf, *arguments], cwd=folder, check=True, capture_output=True, text=True)
    for name in ("scenes", "examples", "docs", "volumes", "tools"):
        shutil.copytree(ROOT / name, folder / name, ignore=shutil.ignore_patterns("images", "*.png"))
    (folder / "docs/images").mkdir()
    (folder / "scene.toml").write_text(SCENE)
    (folder / "out").mkdir()
    call("model", "mandible", "--voxel", "0.4", "-o", "bone.vdb")
    for name in ("a.vdb", "b.vdb", "patient.vdb", "out/patient.vdb"):
        shutil.copy(folder / "bone.vdb", folder / name)
    call("run", "scene.toml", "--no-pictures", "-o", "out")
    call("loop", "scene.toml", "--virtual", "--seconds", "15", "--record", "session.kerf")
    call("practise", "--agent", "expert", "--exercise", "groove", "--record", "attempt.kerf")
    call("loop", "scene.toml", "--virtual", "--seconds", "1", "--record", "first.kerf")
    call("replay", "first.kerf", "-o", "one")
    (folder / "second.toml").write_text(SECOND)
    call("loop", "second.toml", "--virtual", "--seconds", "1", "--record", "second.kerf")
    (folder / "case/recordings").mkdir(parents=True)  # as an unpacked project
    shutil.copy(folder / "session.kerf", folder / "case/recordings/session-2.kerf")
    shutil.copy(ROOT / "docs/compare/block/compare.json", folder / "out/compare.json")
    (folder / "matplotlib").mkdir()
    (folder / "matplotlib/pyplot.py").write_text("def __getattr__(name):\n    return lambda x=(), y=(), **_: len(x) == len(y) or 1 / 0\n")
    (folder / "plane.mrk.json").write_text(PLANE)
    shutil.copy(folder / "plane.mrk.json", folder / "plan.mrk.json")


PLANE = json.dumps({"markups": [{"type": "Plane", "coordinateSystem": "LPS", "name": "cut", "origin": [0.0, 0.0, 6.0],
                                 "normal": [1.0, 0.0, 0.0], "center": [0.0, 0.0, 6.0],
                                 "controlPoints": [{"id": "1", "position": [0.0, 0.0, 6.0]}]}]})


def check_options(page, reference):
    """Returns [(line, command, fault)] of a page's commands that name a command, an option or a script that does not exist."""
    wrong = []
    for number, command in list_commands(page):
        words = shlex.split(command)
        fault = ""
        if words[0] == "kerf":
            fault = reference.check(words)
        elif "/" in words[0] and not words[0].startswith("build/") and not (ROOT / words[0]).exists():
            fault = f"there is no {words[0]}"
        if fault:
            wrong.append((number, command, fault))
    return wrong


def check_page(kerf, page, rules, files):
    """Returns [(line, command, fault)] of a page, and the number of commands that ran."""
    wrong, ran = [], 0
    with tempfile.TemporaryDirectory(prefix="kerf_docs_") as name:
        folder = pathlib.Path(name) / "work"
        shutil.copytree(files, folder)
        write_saved_files(page, folder)
        environment = {key: value for key, value in os.environ.items() if key != "DISPLAY"}
        environment |= {"HOME": name, "PATH": f"{kerf.parent}:{os.environ['PATH']}"}
        for number, command in list_commands(page):
            words = shlex.split(command)
            if command == "tools/run":  # replaced by the command that it runs
                command = "kerf run scenes/body_osteotomy.toml -o out/body_osteotomy"
                words = shlex.split(command)
            if words[0] != "kerf" or any(pattern.search(command) for pattern, _ in rules):
                continue
            if "--record" in words:  # a recording never replaces a file
                (folder / words[words.index("--record") + 1]).unlink(missing_ok=True)
            coarsen_mandibles(folder)
            started = time.monotonic()
            done = subprocess.run(["bash", "-c", command], cwd=folder, env=environment, capture_output=True, text=True,
                                  stdin=subprocess.DEVNULL)
            print(f"{time.monotonic() - started:6.1f} s  {page.relative_to(ROOT)}:{number}: {command}", flush=True)
            ran += 1
            if done.returncode != 0:
                wrong.append((number, command, f"exit code {done.returncode}: {done.stderr.strip()}"))
        for number, snippet in list_snippets(page):
            done = subprocess.run([sys.executable, "-c", snippet], cwd=folder, env=environment | {"PYTHONPATH": str(folder)},
                                  capture_output=True, text=True, stdin=subprocess.DEVNULL)
            ran += 1
            if done.returncode != 0:
                wrong.append((number, "python snippet", done.stderr.strip().splitlines()[-1]))
    return wrong, ran


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("kerf", type=pathlib.Path)
    parser.add_argument("--page", action="append", help="only this page, such as docs/study.md")
    parser.add_argument("--list", action="store_true", help="print the commands; run none")
    parser.add_argument("--options", action="store_true", help="check that commands and options exist; run none")
    arguments = parser.parse_args()
    kerf, rules = arguments.kerf.resolve(), read_rules()
    pages = [page for page in PAGES if page.name not in LEFT_OUT and
             (not arguments.page or str(page.relative_to(ROOT)) in arguments.page)]
    if not pages:
        sys.exit("tests/docs/commands.py: there is no such page")
    if arguments.list:
        for page in pages:
            for number, command in list_commands(page):
                reason = next((reason for pattern, reason in rules if pattern.search(command)), "run")
                print(f"{page.relative_to(ROOT)}:{number}: {command} [{reason}]")
        return 0
    reference = Reference(kerf)
    failed = ran = 0

    def report(page, wrong):
        nonlocal failed
        for number, command, problem in wrong:
            failed += 1
            print(f"{page.relative_to(ROOT)}:{number}: {command}\n    {problem}")
    if arguments.options:
        for page in pages:
            report(page, check_options(page, reference))
        print(f"{len(pages)} pages, {failed} commands with a fault")
        return 1 if failed else 0
    with tempfile.TemporaryDirectory(prefix="kerf_docs_") as name:
        files = pathlib.Path(name) / "files"
        files.mkdir()
        make_files(kerf, files)
        for page in pages:
            wrong, count = check_page(kerf, page, rules, files)
            ran += count
            report(page, [*check_options(page, reference), *wrong])
    print(f"{ran} commands of {len(pages)} pages ran, {failed} failed")
    return 1 if failed or ran == 0 else 0


if __name__ == "__main__":
    sys.exit(main())
