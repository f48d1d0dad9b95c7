#!/usr/bin/env python3
"""Records sessions of every kind with one program and replays them with others, and under the conditions of other machines as far as one
machine can simulate them: on one core, and with the processor's newer instructions hidden from the C library.

    tests/reliability/replay_matrix.py build/release/kerf [more programs] [--write]
    --only NAME: only this kind of session; --write: puts the table into docs/reliability.md; exit code 1 if a replay
    differs
"""

import argparse
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

from page import write_results

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENES = ROOT / "scenes"
FRAGMENTS = '\n[effects.fragments]\npieces = "hidden"\nremove_dust = true\n[effects.heat]\n[effects.tooth_vibration]\n[effects.tangential_force]\n'
UNDO = ["--do", "2:checkpoint=a", "--do", "4:undo=a", "--do", "4.5:redo", "--do", "5:undo"]
RECORDINGS = {
    "loop_live": ("loop, live", ["loop", "hand_held_cut.toml", "--seconds", "6"]),
    "loop_undo": ("loop, live, undo and redo", ["loop", "hand_held_cut.toml", "--seconds", "6", *UNDO]),
    "loop_effects": ("loop with effects", ["loop", "fragments.toml", "--seconds", "14", "--virtual"]),
    "loop_overrun": ("loop, overrun: missed ticks, coarser ticks", ["loop", "hand_held_cut.toml", "--seconds", "6", "--virtual", "--burn-us", "1500"]),
    "run_disc": ("run, disc, 21 s", ["run", "slot_in_block.toml", "--no-pictures", "-o", "out"]),
    "run_ball": ("run, ball", ["run", "ball_slot.toml", "--no-pictures", "-o", "out"]),
    "run_bur": ("run, bur", ["run", "bur_groove.toml", "--no-pictures", "-o", "out"]),
    "run_slab": ("run, slab mode", ["run", "slab_mandible.toml", "--no-pictures", "-o", "out"]),
}
HIDDEN = "glibc.cpu.hwcaps=-AVX2,-FMA,-AVX512F,-AVX,-FMA4,-AVX2_Usable,-FMA_Usable"


def call(command, folder, environment=None):
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False,
                          env={**os.environ, **(environment or {})})


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("kerf")
    parser.add_argument("others", nargs="*")
    parser.add_argument("--only", choices=RECORDINGS)
    parser.add_argument("--write", action="store_true")
    arguments = parser.parse_args()
    if arguments.only and arguments.write:
        parser.error("--write needs all recordings: omit --only")
    folder = pathlib.Path(tempfile.mkdtemp(prefix="kerf_replays_"))
    for scene in SCENES.glob("*.toml"):
        shutil.copy(scene, folder)
    if arguments.only:  # in the tests, a coarse mandible is enough
        slab = (SCENES / "slab_mandible.toml").read_text(encoding="utf-8")
        (folder / "slab_mandible.toml").write_text(slab.replace("voxel_mm = 0.2", "voxel_mm = 0.8"), encoding="utf-8")
    (folder / "fragments.toml").write_text((SCENES / "hand_held_cut.toml").read_text(encoding="utf-8") + FRAGMENTS, encoding="utf-8")
    kerf = str(pathlib.Path(arguments.kerf).resolve())
    variants = [("same program", [kerf], {}), ("on one core", ["taskset", "-c", str(min(os.sched_getaffinity(0))), kerf], {}),
            ("C library without AVX, FMA", [kerf], {"GLIBC_TUNABLES": HIDDEN})]
    for other in arguments.others:
        path = pathlib.Path(other).resolve()
        variants.append((f"build {path.parent.name}", [str(path)], {"ASAN_OPTIONS": "detect_leaks=0"}))
    failed = 0
    rows = []
    for index, (name, command) in enumerate([RECORDINGS[arguments.only]] if arguments.only else RECORDINGS.values()):
        file = f"{index}.kerf"
        made = call([kerf, *command, "--record", file], folder)
        if made.returncode != 0:
            print(f"{name}: {made.stderr}", file=sys.stderr)
            return 1
        cells = []
        summary = None
        for _, program, environment in variants:
            replayed = call([*program, "replay", file, "--verify", "--json"], folder, environment)
            same = replayed.returncode == 0 and json.loads(replayed.stdout)["identical"]
            summary = json.loads(replayed.stdout) if same else summary
            failed += not same
            cells.append("same" if same else f"**{replayed.stderr.strip() or replayed.returncode}**")
        summary = summary or json.loads(call([kerf, "replay", file, "--json"], folder).stdout)
        minute_MB = 60e-6 * summary["bytes"] / summary["duration_s"]
        rows.append([name, str(summary["ticks"]), f"{minute_MB:.2f}", f"`{summary['voxel_hash']}`", *cells])
        print(" | ".join(rows[-1]), flush=True)
    shutil.rmtree(folder)
    header = ["recorded", "ticks", "MB a minute", "voxel hash", *(name for name, _, _ in variants)]
    table = "\n".join("| " + " | ".join(row) + " |" for row in [header, ["---"] * len(header), *rows])
    total = len(rows) * len(variants)
    text = f"{total - failed} of {total} replays were bit-identical.\n\n{table}"
    print(text)
    if arguments.write:
        write_results("replays", text + "\n")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
