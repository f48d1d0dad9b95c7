#!/usr/bin/env python3
"""Makes one system call of a command fail: the first one, then the second and so on, until the command ends without a
failed call.

    tests/reliability/io_faults.py build/release/kerf build/release/tests/libkerf_io_faults.so [--most N] [--only COMMAND] [--write]

After each failure, the exit code must be 1 with one sentence, or 0 with complete results; each file must be the complete old or new one; a
folder with results of two runs must have no list of them; and nothing else in the folder may have changed. --most N: at most N calls of each kind, evenly spaced. --write: puts the
table into docs/reliability.md. Exit code 1 if kerf did not survive a fault.
"""

import argparse
import errno
import json
import pathlib
import re
import shutil
import signal
import struct
import sys
import tempfile

from faults import COMMANDS, LISTS, Program, check_whole, copy_tree, list_attempts, prepare, snapshot
from page import write_results

# Each fault is a kind of call, its error, and whether all later calls fail too.
FAULTS = [("open", errno.EMFILE, False), ("open_elsewhere", errno.EMFILE, False), ("read", errno.EIO, False), ("write", errno.ENOSPC, True),
          ("write", errno.EIO, False), ("fwrite", errno.ENOSPC, True), ("sync", errno.EIO, False), ("rename", errno.EIO, False), ("mmap", errno.ENOMEM, False),
          ("alloc", errno.ENOMEM, False), ("new_at", errno.ENOMEM, False), ("new", errno.ENOMEM, True)]
# These calls are very numerous, so only this many of them are made to fail, evenly spaced. "new_at" is the first `new`
# of each place in the program; there are thousands of places.
MAX_CALLS = {"new": 60, "new_at": 120, "alloc": 60, "fwrite": 25}
OLD = b"old\n"
HISTORY = "home/practise.db"


class Case:
    """A command, with its folder before the command and after the command has ended successfully."""

    def __init__(self, program, name, folder):
        self.program, self.name = program, name
        self.clean, self.root = folder / "clean" / "x", folder / "work" / "x"
        prepare(program, self.clean, name)
        self.before = snapshot(self.clean)
        first, self.reference = self.run_clean()
        _, second = self.run_clean()
        self.known = set(first.stderr.decode().splitlines())
        self.exact = {path for path in self.reference if self.reference[path] == second.get(path)}
        # Usually the results of an earlier run are in place.
        for path in self.reference:
            if path not in self.before and path != "session.kerf":
                (self.clean / path).parent.mkdir(parents=True, exist_ok=True)
                (self.clean / path).write_bytes(OLD)
        self.before = snapshot(self.clean)
        self.report = folder / "report"
        self.sites = []

    def run_clean(self):
        copy_tree(self.clean, self.root)
        ended = self.program.run(self.root, COMMANDS[self.name])
        assert ended.returncode == 0, ended.stderr
        return ended, snapshot(self.root)

    def inject(self, call, number, error, lasts):
        """Makes a call fail. Returns the exit code, and the numbers of calls and of failed calls. Raises
        AssertionError."""
        copy_tree(self.clean, self.root)
        self.report.unlink(missing_ok=True)
        which = {"KERF_FAULT_SITE": str(self.sites[number - 1])} if call == "new_at" else {"KERF_FAULT_AT": str(number)}
        ended = self.program.run(self.root, COMMANDS[self.name], KERF_FAULT_CALL=call, KERF_FAULT_ERROR=str(error), KERF_FAULT_LASTS=str(int(lasts)),
                                 KERF_FAULT_REPORT=str(self.report), **which)
        calls, failed = struct.unpack("<QQ", self.report.read_bytes())
        self.check(ended)
        return ended.returncode, calls, failed

    def count(self, call):
        """Returns the number of calls of a kind if none fails; for "new_at", the number of places."""
        if call != "new_at":
            return self.inject(call, 0, 0, False)[1]
        copy_tree(self.clean, self.root)
        self.report.unlink(missing_ok=True)
        self.program.run(self.root, COMMANDS[self.name], KERF_FAULT_CALL=call, KERF_FAULT_SITES=str(self.report))
        self.sites = [site for (site,) in struct.iter_unpack("<Q", self.report.read_bytes())]
        return len(self.sites)

    def check(self, ended):
        text = ended.stderr.decode(errors="replace")
        if ended.returncode < 0:
            raise AssertionError(f"ended by {signal.Signals(-ended.returncode).name}: {text.strip()[-300:]}")
        assert ended.returncode in (0, 1), f"exit code {ended.returncode}: {text}"
        said = [line for line in text.splitlines()
                if line not in self.known and not line.startswith(("kerf: warning: ", "kerf: note: "))]
        foreign = [line for line in said if not line.startswith("kerf: ")]
        assert not foreign, f"not a message of kerf: {foreign[:3]}"
        if ended.returncode == 1:
            # A recording that ended early is reported first, then other losses.
            assert len(said) == 1 or (len(said) == 2 and "session.kerf" in said[0]), f"{len(said)} messages: {said[:4]}"
        self.check_files(ended.returncode == 0, "the recording ended" in text)
        if self.name in LISTS and ended.returncode == 1:
            self.check_list(text)

    def check_files(self, done, shorter):
        """Checks the files in the folder. `shorter`: a loop ended with its recording, so its results are those of a
        shorter session."""
        now = snapshot(self.root)
        for path, content in self.before.items():
            assert path in now or path not in self.reference or path in LISTS.values() or path.startswith(HISTORY), f"{path} is missing"
            if path.startswith(HISTORY):
                continue
            assert path in self.reference or now.get(path) == content, f"{path} has changed"
        for path, content in now.items():
            if path.startswith(HISTORY):
                continue
            assert path in self.before or path in self.reference, f"{path} was left behind"
            if content == self.before.get(path) and not (done and content == OLD):
                continue
            if path == "session.kerf":
                self.check_recording(done)
            elif path in self.exact and not shorter:
                content, reference = (strip_lost(path, text, now) for text in (content, self.reference[path]))
                assert content == reference, f"{path} has neither the old nor the new content: {len(content)} bytes"
            else:
                check_whole(self.program, self.root, path, content, content if shorter else self.reference[path])
        if done:
            assert set(self.reference) <= set(now) | {HISTORY + "-shm", HISTORY + "-wal"}, f"missing: {set(self.reference) - set(now)}"
        if self.name == "hand-in":
            students = [student for student, _ in list_attempts(self.root / HISTORY)]
            assert students == ["Grace", "Ada"] or (not done and students == ["Grace"]), students

    def check_list(self, text):
        """Checks that a folder with results of two runs has no list, and that the message says so."""
        now, results = snapshot(self.root), LISTS[self.name]
        folder = results.rpartition("/")[0]
        if results not in now:
            assert "may have files of two runs, and has no " in text, f"{results} is missing: {text}"
        elif now[results] == OLD:
            new = [path for path in self.reference if path.startswith(f"{folder}/") and now[path] != OLD]
            assert not new, f"{new} are new, and {results} is old"
        else:
            old = [name for name in json.loads(now[results])["files"] if now[f"{folder}/{name}"] == OLD]
            assert self.name == "loop" and not old, f"{old} are old, and {results} is new"

    def check_recording(self, done):
        """Checks that the recording up to the fault can be opened, or that it is refused with one sentence if its
        header is incomplete."""
        log = self.program.run(self.root, ["log", "session.kerf"])
        assert log.returncode == 0 if done else log.returncode in (0, 3) or (log.returncode == 1 and log.stderr.count(b"\n") == 1), log.stderr


def strip_lost(path, text, now):
    """Returns a report without the lines for pictures that could not be written; other files unchanged."""
    if not path.endswith(".md"):
        return text
    folder = path.rpartition("/")[0]
    def is_lost(line):
        picture = re.fullmatch(rb"!\[[^]]*\]\((.*)\)", line)
        return picture and now.get(f"{folder}/{picture[1].decode()}") in (None, OLD)
    return b"\n".join(line for line in text.split(b"\n") if line and not is_lost(line))


def numbers(count, limit):
    """Returns the first, the last and others between them, evenly spaced."""
    if count <= limit:
        return range(1, count + 1)
    return sorted({1 + round(i * (count - 1) / max(limit - 1, 1)) for i in range(limit)})


def sweep(case, limit, say):
    """Returns a row for each kind of fault: kind, calls, injected, ended with a sentence, harmless, failures."""
    for call, error, lasts in FAULTS:
        count = case.count(call)
        injected = sentences = harmless = 0
        failures = []
        for number in numbers(count, min(limit, MAX_CALLS.get(call, limit))):
            try:
                code, _, failed = case.inject(call, number, error, lasts)
            except AssertionError as problem:
                failures.append(f"{case.name}: {call} {number} of {count}, {errno.errorcode[error]}{' and all later calls' if lasts else ''}: {problem}")
                say(failures[-1])
                injected += 1
                continue
            # Because of threads, there may be fewer calls in this run.
            injected += failed > 0
            sentences += failed > 0 and code == 1
            harmless += failed > 0 and code == 0
        what = {"new_at": "new, by call site"}.get(call, call.replace("_", " "))
        name = f"{what}, {errno.errorcode[error]}{', lasting' if lasts else ''}"
        say(f"{case.name}: {name}: {count} calls, {injected} failed: {sentences} messages, {harmless} harmless, {len(failures)} failures")
        yield name, count, injected, sentences, harmless, failures


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("kerf")
    parser.add_argument("library")
    parser.add_argument("--most", type=int, default=1_000_000)
    parser.add_argument("--only", choices=list(COMMANDS), action="append")
    parser.add_argument("--call", help="inject faults only into this kind of call")
    parser.add_argument("--write", action="store_true")
    arguments = parser.parse_args()
    if arguments.call:
        FAULTS[:] = [fault for fault in FAULTS if fault[0] == arguments.call]
    folder = pathlib.Path(tempfile.mkdtemp(prefix="kerf_faults_")).resolve()
    program = Program(arguments.kerf, arguments.library)
    rows, failures = [], []
    for name in arguments.only or COMMANDS:
        case = Case(program, name, folder / name)
        for row in sweep(case, arguments.most, lambda text: print(text, flush=True)):
            rows.append((name, *row[:-1], len(row[-1])))
            failures += row[-1]
    shutil.rmtree(folder)
    injected = sum(row[3] for row in rows)
    text = f"kerf survived {injected - len(failures)} of {injected} faults: {sum(row[4] for row in rows)} ended with a message, {sum(row[5] for row in rows)} were harmless."
    print(text)
    if arguments.write:
        table = "| command | fault | calls | injected | exit 1, with a message | exit 0, complete |\n|---|---|---|---|---|---|\n"
        table += "".join(f"| `{row[0]}` | {row[1]} | {row[2]} | {row[3]} | {row[4]} | {row[5]} |\n" for row in rows)
        write_results("faults", text + "\n\n" + table)
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
