"""Common parts of io_faults.py and power_loss.py: small inputs, commands that write, and checks of complete results."""

import contextlib
import json
import math
import os
import pathlib
import shutil
import sqlite3
import struct
import subprocess

SCENE = """
[bone]
model = "block"
[bone.block]
size_x_mm = 6.0
size_y_mm = 4.0
size_z_mm = 3.0
voxel_mm = 0.25
[tool]
diameter_mm = 12.0
thickness_mm = 0.5
teeth = 16
[[path.stroke]]
start_mm = [0.0, 0.0, 6.5]
end_mm = [0.0, 0.0, 4.5]
feed_mm_per_s = 6.0
disc_normal = [1.0, 0.0, 0.0]
[output]
pictures = {pictures}
[effects.sound]
"""


def write_ball(path):
    """Writes a ball of 1600 HU with a radius of 11 mm in soft tissue of 50 HU, blurred by 0.5 mm, as NRRD."""
    side = 32
    voxels = bytearray()
    for k in range(side):
        for j in range(side):
            for i in range(side):
                r = math.hypot(i - 15.6, j - 15.2, k - 15.9)
                voxels += struct.pack("<h", int(50 + 775 * math.erfc((r - 11) / (0.5 * math.sqrt(2)))))
    header = (f"NRRD0004\ntype: short\ndimension: 3\nspace: left-posterior-superior\nsizes: {side} {side} {side}\n"
              "space directions: (1,0,0) (0,1,0) (0,0,1)\nendian: little\nencoding: raw\nspace origin: (0,0,0)\n\n")
    path.write_bytes(header.encode() + bytes(voxels))


class Program:
    """Runs kerf in a separate folder, with the preloaded library."""

    def __init__(self, kerf, library):
        self.kerf, self.library = str(pathlib.Path(kerf).resolve()), str(pathlib.Path(library).resolve())

    def run(self, root, arguments, **settings):
        environment = {name: value for name, value in os.environ.items() if name != "DISPLAY"}
        environment.update(HOME=str(root / "home"), KERF_DATA=str(root / "home"), TMPDIR=str(root / "tmp"))
        if settings:
            environment.update(LD_PRELOAD=self.library, KERF_FAULT_ROOT=str(root), **settings)
        # Addresses are equal in each run, so that they identify the places that allocate memory.
        return subprocess.run(["setarch", "-R", self.kerf, *arguments], cwd=root, env=environment, capture_output=True, check=False, timeout=300,
                              stdin=subprocess.DEVNULL)


# The file in a folder of results that describes the others.
LISTS = {"run": "out/summary.json", "loop": "out/loop.json"}
COMMANDS = {
    "import": ["import", "ball.nrrd", "--no-isolate", "--voxel", "1", "-o", "b.vdb"],
    "run": ["run", "scene.toml", "-o", "out", "--record", "session.kerf"],
    "loop": ["loop", "scene.toml", "--virtual", "--seconds", "0.6", "-o", "out", "--record", "session.kerf"],
    "hand-in": ["practise", "--hand-in", "attempt.kerf", "--student", "Ada"],
}


def prepare(program, root, name, pictures=False):
    """Prepares the folder in which the command is run, with everything that it needs."""
    for folder in ("home", "tmp"):
        (root / folder).mkdir(parents=True)
    if name == "import":
        write_ball(root / "ball.nrrd")
    if name in ("run", "loop"):
        (root / "scene.toml").write_text(SCENE.format(pictures="true" if pictures else "false"), encoding="utf-8")
    if name == "hand-in":
        for seed, student in (("1", "Grace"), ("2", None)):
            made = program.run(root, ["practise", "--agent", "expert", "--exercise", "groove", "--seconds", "1", "--seed", seed, "--record",
                                      "attempt.kerf" if student is None else "earlier.kerf"])
            assert made.returncode == 0, made.stderr
            if student is not None:
                handed = program.run(root, ["practise", "--hand-in", "earlier.kerf", "--student", student])
                assert handed.returncode == 0, handed.stderr


def comparable(name, content):
    """Returns the content without the unique number that OpenVDB gives each file."""
    return content[:21] + content[57:] if name.endswith(".vdb") and len(content) > 57 else content


def snapshot(root):
    """Returns all files below the folder, as comparable() does."""
    files = {str(path.relative_to(root)): path.read_bytes() for path in sorted(root.rglob("*")) if path.is_file() and not path.is_symlink()}
    return {name: comparable(name, content) for name, content in files.items()}


def list_attempts(path):
    """Returns the attempts of a history, which must be complete."""
    with contextlib.closing(sqlite3.connect(path)) as history:
        assert history.execute("PRAGMA integrity_check").fetchone() == ("ok",), "the history is damaged"
        return history.execute("SELECT student, hash FROM attempts ORDER BY number").fetchall()


def check_whole(program, root, name, content, reference):
    """Checks a new result that need not be byte-identical each time. Raises AssertionError."""
    kind = pathlib.Path(name).suffix
    if kind == ".json":
        json.loads(content)
    elif kind == ".vdb":
        assert program.run(root, ["info", name]).returncode == 0, f"{name} can't be read"
    elif kind == ".png":
        assert content[-8:-4] == b"IEND", f"{name} is cut short"
    else:
        assert content[-1:] == reference[-1:] and abs(len(content) - len(reference)) <= 0.2 * len(reference) + 64, f"{name} is incomplete"


def copy_tree(source, target):
    if target.exists():
        shutil.rmtree(target)
    shutil.copytree(source, target)
