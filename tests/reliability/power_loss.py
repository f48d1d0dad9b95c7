#!/usr/bin/env python3
"""Checks the possible states of a command's files after a power loss. Its writes are logged (faults/io_faults.cpp), and folders are made with
the possible contents of a disk that delays and reorders everything that was not synced.

    tests/reliability/power_loss.py build/release/kerf build/release/tests/libkerf_io_faults.so [--states 1000] [--seed 1] [--only COMMAND] [--write]

A file has the content of its last fsync or fdatasync, plus any subset of the 512-byte sectors written since; its growth may be missing. Names
(files created, renamed, removed) reach the disk in their order, up to any of them; those before a sync of their folder
have certainly reached it. In each of these states, each result must be the complete old or new one, and if the list of
the results in a folder is there, all must be of one run; a recording must exist and contain everything that was synced;
the history must be complete and contain the old attempts, possibly with the new one, and certainly with it after the
program has ended. --write puts the counts into docs/reliability.md; exit code 1 if a state violates this.
"""

import argparse
import json
import os
import pathlib
import random
import shutil
import sys
import tempfile

from faults import COMMANDS, LISTS, Program, check_whole, comparable, copy_tree, list_attempts, prepare, snapshot
from page import write_results

SECTOR = 512
HISTORY = "home/practise.db"
# These commands run in real time, because a recording is synced by the clock.
LIVE = {"loop": ["loop", "scene.toml", "--seconds", "2", "-o", "out", "--record", "session.kerf"]}


def read_log(path):
    """Returns a list of [what, inode, a, b, name, name, bytes]."""
    operations = []
    with open(path, "rb") as log:
        while line := log.readline():
            what, inode, a, b, names = line.decode().rstrip("\n").split(" ", 4)
            name, other = names.split("|")
            size = int(b) if what in "WS" else 0
            operations.append((what, int(inode), int(a), int(b), name, other, log.read(size)))
    return operations


class Disk:
    """The operations so far, and which of their effects must be on the disk."""

    def __init__(self, root):
        self.root = root
        self.synced, self.pending, self.names, self.moves = {}, {}, {}, []
        self.files = {}  # by inode; inode numbers are reused
        for path in root.rglob("*"):
            if path.is_file():
                file = self.files[path.stat().st_ino] = len(self.files)
                self.synced[file] = path.read_bytes()
                self.names[str(path.relative_to(root))] = file

    def plain(self, name):
        return os.path.relpath(os.path.join(self.root, name), self.root)

    def do(self, operation):
        what, inode, a, _, name, other, content = operation
        if what == "O" and not name.startswith("/proc/") and self.plain(name) not in self.names_now():
            file = self.files[inode] = len(self.synced)
            self.synced[file] = b""
            self.moves.append(("make", self.plain(name), file))
        file = self.files.get(inode)
        pending = self.pending.setdefault(file, [])
        if what == "O" and a == 1:
            pending.append(("cut", 0, b""))
        elif what == "W":
            pending.append(("write", a, content))
        elif what == "T":
            pending.append(("cut", a, b""))
        elif what == "S":
            self.synced[file], self.pending[file] = content, []
        elif what == "R":
            self.moves.append(("move", self.plain(name), self.plain(other)))
        elif what == "U":
            self.moves.append(("remove", self.plain(name), None))
        elif what == "D":
            folder = os.path.relpath(name, self.root)
            here = [move for move in self.moves if (os.path.dirname(move[1]) or ".") == folder]
            for move in here:
                self.apply(self.names, move)
            self.moves = [move for move in self.moves if move not in here]

    def names_now(self):
        names = dict(self.names)
        for move in self.moves:
            self.apply(names, move)
        return names

    @staticmethod
    def apply(names, move):
        kind, name, what = move
        if kind == "make":
            names[name] = what
        elif name in names:
            file = names.pop(name)
            if kind == "move":
                names[what] = file

    def content(self, file, dice, share):
        """Returns the content with a random subset of the sectors that were written since the last sync."""
        data = bytearray(self.synced[file])
        for kind, at, content in self.pending.get(file, []):
            if kind == "cut":
                if dice.random() < share:
                    del data[at:]
                    data.extend(bytes(at - len(data)))
                continue
            begin = at
            while begin < at + len(content):
                end = min((begin // SECTOR + 1) * SECTOR, at + len(content))
                if dice.random() < share:
                    data.extend(bytes(max(0, end - len(data))))
                    data[begin:end] = content[begin - at:end - at]
                begin = end
        return bytes(data)

    def after_loss(self, dice, share):
        """Returns the files of a folder that is possible after the loss."""
        names = dict(self.names)
        for move in self.moves[:round(dice.random() * len(self.moves)) if 0 < share < 1 else round(share * len(self.moves))]:
            self.apply(names, move)
        return {name: self.content(file, dice, share) for name, file in names.items()}


class Trial:
    def __init__(self, program, name, folder):
        self.program, self.name, self.folder = program, name, folder
        self.clean, self.root, self.found = folder / "clean" / "x", folder / "work" / "x", folder / "found" / "x"
        prepare(program, self.clean, name)
        copy_tree(self.clean, self.root)
        command = LIVE.get(name, COMMANDS[name])
        if "-o" in command:
            # The results of an earlier run are in place.
            without = [word for word in COMMANDS[name] if word not in ("--record", "session.kerf")]
            assert program.run(self.root, without).returncode == 0
        self.disk = Disk(self.root)
        self.before = snapshot(self.root)
        log = folder / "log"
        ended = program.run(self.root, command, KERF_IO_LOG=str(log))
        assert ended.returncode == 0, ended.stderr
        self.after = snapshot(self.root)
        self.operations = read_log(log)
        self.lengths = {}

    def duration(self, content):
        """Returns the duration of a recording, s; None if it is not a recording."""
        if content not in self.lengths:
            self.found.mkdir(parents=True, exist_ok=True)
            (self.found / "part.kerf").write_bytes(content)
            log = self.program.run(self.found, ["log", "part.kerf", "--json"])
            assert log.returncode in (0, 1, 3), log.stderr
            self.lengths[content] = None if log.returncode == 1 else json.loads(log.stdout)["duration_s"]
            (self.found / "part.kerf").unlink()
        return self.lengths[content]

    def check(self, files, ended):
        """Checks the files of a possible state after the loss. Raises AssertionError if they are not as required."""
        if self.found.exists():
            shutil.rmtree(self.found)
        for name, content in files.items():
            (self.found / name).parent.mkdir(parents=True, exist_ok=True)
            (self.found / name).write_bytes(content)
        for name, content in files.items():
            if name == "session.kerf" or name.startswith(HISTORY) or pathlib.Path(name).name.startswith("."):
                continue
            if comparable(name, content) in (self.before.get(name), self.after.get(name)):
                continue
            check_whole(self.program, self.found, name, content, self.after.get(name, b""))
        for name in self.before:
            assert name in files or name not in self.after or name == LISTS.get(self.name) or name.startswith(HISTORY), f"{name} is missing"
        results = LISTS.get(self.name)
        if results in files:
            run = self.before if files[results] == self.before[results] else self.after
            mixed = [name for name in files if name.startswith("out/") and name[4] != "." and comparable(name, files[name]) != run.get(name)]
            assert not mixed, f"{mixed} are of another run than {results}"
        if "session.kerf" in self.after:
            self.check_recording(files)
        if self.name == "hand-in":
            students = [student for student, _ in list_attempts(self.found / HISTORY)]
            assert students == ["Grace", "Ada"] or (not ended and students == ["Grace"]), students

    def check_recording(self, files):
        synced = [content for what, _, _, _, name, _, content in self.done if what == "S" and name.endswith("/session.kerf")]
        if not synced or self.duration(synced[-1]) is None:
            return
        assert "session.kerf" in files, f"the recording is missing, although {self.duration(synced[-1]):.2f} s were synced"
        found = self.duration(files["session.kerf"])
        assert found is not None and found >= self.duration(synced[-1]), f"the recording has {found} s, but {self.duration(synced[-1])} s were synced"

    def run(self, states, dice, say):
        """Returns the number of states and the failures. The power is lost at each moment, with none and with all of the unsynced
        data on the disk, and at random moments."""
        plan = [(moment, share) for moment in range(len(self.operations) + 1) for share in (0.0, 1.0)]
        plan = dice.sample(plan, min(states // 2, len(plan)))
        plan += [(dice.randrange(len(self.operations) + 1), dice.choice((0.1, 0.5, 0.9))) for _ in range(states - len(plan))]
        plan += [(len(self.operations), 0.0)]
        self.done, failures = [], []
        for moment, share in sorted(plan):
            for operation in self.operations[len(self.done):moment]:
                self.disk.do(operation)
                self.done.append(operation)
            try:
                self.check(self.disk.after_loss(dice, share), moment == len(self.operations))
            except Exception as problem:  # also errors of SQLite and JSON
                failures.append(f"{self.name}: after {moment} of {len(self.operations)} operations, fraction {share}: {problem}")
                say(failures[-1])
        return len(plan), failures


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("kerf")
    parser.add_argument("library")
    parser.add_argument("--states", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", choices=list(COMMANDS), action="append")
    parser.add_argument("--write", action="store_true")
    arguments = parser.parse_args()
    folder = pathlib.Path(tempfile.mkdtemp(prefix="kerf_power_")).resolve()
    program = Program(arguments.kerf, arguments.library)
    rows, failures = [], []
    for name in arguments.only or COMMANDS:
        trial = Trial(program, name, folder / name)
        states, wrong = trial.run(arguments.states, random.Random(arguments.seed), lambda text: print(text, flush=True))
        syncs = sum(operation[0] in "SD" for operation in trial.operations)
        rows.append((name, len(trial.operations), syncs, states, len(wrong)))
        print(f"{name}: {rows[-1][1]} operations, {syncs} of them syncs; {states} states, {len(wrong)} of them wrong", flush=True)
        failures += wrong
    shutil.rmtree(folder)
    total = sum(row[3] for row in rows)
    text = f"{total - len(failures)} of {total} states after a power loss are complete (seed {arguments.seed})."
    print(text)
    if arguments.write:
        table = "| command | operations logged | of which syncs | states | complete |\n|---|---|---|---|---|\n"
        table += "".join(f"| `{row[0]}` | {row[1]} | {row[2]} | {row[3]} | {row[3] - row[4]} |\n" for row in rows)
        write_results("power", text + "\n\n" + table)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
