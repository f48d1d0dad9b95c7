#!/usr/bin/env python3
"""Kills recorded sessions with SIGKILL at random moments. The recording must open, contain everything except at most
the last half second, replay bit-identically, and allow a continuation; earlier results must be unchanged.

    tests/reliability/kill_recording.py build/release/kerf [--kills 200] [--seed 1] [--write]
    --write puts the counts into docs/reliability.md; exit code 1 if kerf did not survive a kill

A kill that loses more than half a second of real time is repeated with the same parameters; three in a row are a failure.
"""

import argparse
import hashlib
import json
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

from page import write_results

MAX_LOST_S = 0.5  # a block of 0.25 s that is not full yet, and one that is being written
FIRST_SEEN = {}  # by recording: time when it was first seen
SCENE = """
[bone]
model = "block"
[bone.block]
size_x_mm = 12.0
size_y_mm = 6.0
size_z_mm = 6.0
voxel_mm = 0.2
[tool]
diameter_mm = 12.0
thickness_mm = 0.5
teeth = 16
[[path.stroke]]
start_mm = [0.0, 0.0, 9.2]
end_mm = [0.0, 0.0, 3.5]
feed_mm_per_s = 2.0
disc_normal = [1.0, 0.0, 0.0]
[output]
pictures = false
"""


def run(kerf, *arguments):
    return subprocess.run([kerf, *arguments], capture_output=True, text=True, check=False, timeout=300)


def hashes(folder):
    return {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted(folder.iterdir()) if not path.name.startswith(".")}


def check_results(kerf, folder, earlier):
    """Checks that each file is unchanged. A run that was killed while it replaced files one by one has left complete
    new ones, with the same bytes except for times in JSON and the unique number that OpenVDB gives each file."""
    now = hashes(folder)
    assert set(now) == set(earlier), f"files were added or removed: {set(now) ^ set(earlier)}"
    for name in now:
        if now[name] == earlier[name]:
            continue
        if name.endswith(".json"):
            json.loads((folder / name).read_text(encoding="utf-8"))
        elif name.endswith(".vdb"):
            assert run(kerf, "info", str(folder / name)).returncode == 0, f"{name} can't be read"
        else:
            raise AssertionError(f"{name} has changed")
    return now


def draw(dice):
    """Draws the kind of session, whether it is killed at any moment since its start (one in ten; otherwise once there is something
    to lose), and the delay after that."""
    kind = dice.choice(["live", "live", "live", "virtual", "run"])
    return kind, dice.random() <= 0.1, dice.uniform(0.0, 0.15 if kind == "run" else 2.5)


def has_a_block(recording):
    """Returns true once the first block is written. The header is written at once, the first block a quarter of a second after the loop began.
    If the machine stalls in between, the kill may be too early, and less can be checked."""
    now = recording.stat()
    return now.st_mtime > FIRST_SEEN.setdefault((recording, now.st_ino), now.st_mtime) + 0.1


def one_kill(kerf, folder, kind, at_any_moment, delay_s, index):
    """Returns the result: 'before', or the number of seconds lost at the end. Raises AssertionError."""
    recording = folder / f"{index}.kerf"
    recording.unlink(missing_ok=True)
    results = folder / ("run" if kind == "run" else "loop")
    common = [str(folder / "scene.toml"), "-o", str(results), "--record", str(recording)]
    actions = ["--do", "0.5:checkpoint=a", "--do", "1.2:undo=a", "--do", "1.5:redo"]
    command = {"live": [kerf, "loop", *common, "--seconds", "30", *actions],
               "virtual": [kerf, "loop", *common, "--seconds", "3000", "--virtual", *actions],
               "run": [kerf, "run", *common]}[kind]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    if not at_any_moment:
        while process.poll() is None and not (recording.exists() and (kind != "live" or has_a_block(recording))):
            time.sleep(0.002)
    time.sleep(delay_s)
    # The time is taken before the signal, so that delays of this script do not count as loss.
    killed = time.time()
    process.send_signal(signal.SIGKILL)
    ended = process.wait()
    if kind == "run" and ended == 0:
        return "done"
    if not recording.exists() or recording.stat().st_size < 200:
        return "before"
    lost_s = killed - recording.stat().st_mtime

    replayed = run(kerf, "replay", str(recording), "--verify", "--json")
    if replayed.returncode != 0 and "before its header" in replayed.stderr:
        return "before"
    assert replayed.returncode == 3 and "cut short" in replayed.stderr, f"replay: {replayed.returncode} {replayed.stderr}"
    figures = json.loads(replayed.stdout)
    assert figures["identical"] and figures["replayed_ticks"] == figures["ticks"], figures
    if kind != "run":
        further = folder / f"{index}_further.kerf"
        continued = run(kerf, "loop", "--from", str(recording), "--virtual", "--seconds", "0.2", "--record", str(further))
        assert continued.returncode == 0, f"continuation: {continued.stderr}"
        again = json.loads(run(kerf, "replay", str(further), "--verify", "--json").stdout)
        assert again["identical"] and again["ticks"] == figures["ticks"] + 200, again
        further.unlink()
    recording.unlink()
    # Data are written when a block is full, so a new file may contain none yet.
    return lost_s if kind == "live" and figures["ticks"] > 0 else "fast"


def kill_until_in_time(kerf, folder, kind, at_any_moment, delay_s, index):
    """Like one_kill, but repeats a kill that loses too much, and also returns the number of repetitions. If the machine
    stalls while kerf should write, more real time is lost than kerf itself would lose. Any other fault counts
    immediately; losing too much three times in a row is a fault of kerf."""
    losses = []
    for again in range(3):
        outcome = one_kill(kerf, folder, kind, at_any_moment, delay_s, index)
        if isinstance(outcome, str) or outcome <= MAX_LOST_S:
            return outcome, again
        losses.append(outcome)
    raise AssertionError(f"the last {', '.join(f'{s:.2f}' for s in losses)} s are lost, three times in a row")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("kerf")
    parser.add_argument("--kills", type=int, default=200)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--write", action="store_true")
    arguments = parser.parse_args()
    dice = random.Random(arguments.seed)
    folder = pathlib.Path(tempfile.mkdtemp(prefix="kerf_kill_"))
    (folder / "scene.toml").write_text(SCENE, encoding="utf-8")
    earlier = {}
    for kind, options in (("loop", ["--virtual", "--seconds", "1"]), ("run", [])):
        first = run(arguments.kerf, kind, str(folder / "scene.toml"), *options, "-o", str(folder / kind))
        assert first.returncode == 0, first.stderr
        earlier[kind] = hashes(folder / kind)

    lost, counts, failures, repeats = [], {"before": 0, "done": 0, "fast": 0}, [], 0
    for index in range(arguments.kills):
        try:
            outcome, again = kill_until_in_time(arguments.kerf, folder, *draw(dice), index)
            repeats += again
            assert hashes(folder / "loop") == earlier["loop"], "an existing file has changed"
            earlier["run"] = check_results(arguments.kerf, folder / "run", earlier["run"])
            if isinstance(outcome, str):
                counts[outcome] += 1
            else:
                lost.append(outcome)
        except AssertionError as error:
            failures.append(f"kill {index}: {error}")
            print(failures[-1], file=sys.stderr)
        if sys.stderr.isatty():
            print(f"\r{index + 1} of {arguments.kills}", end="", file=sys.stderr)
    shutil.rmtree(folder)
    survived = arguments.kills - len(failures)
    worst = max(lost, default=0)
    text = (f"kerf survived {survived} of {arguments.kills} kills (seed {arguments.seed}): {len(lost)} of live sessions, which lost at most {worst:.2f} s at "
            f"their end; {counts['fast']} of runs and of loops in virtual time, or within a session's first quarter of a second; {counts['before']} before "
            f"anything was recorded; {counts['done']} after the end of a run.")
    if repeats > 0:
        text += f" {repeats} were repeated, because more than {MAX_LOST_S} s of real time were lost when the machine stalled."
    print(text)
    if arguments.write:
        write_results("kills", text + "\n")
    return 1 if failures else 0


if __name__ == "__main__":
    sys.exit(main())
