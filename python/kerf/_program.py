"""Studies, comparisons, stability and scores: made by the program kerf in a process of its own, returned as data."""

from __future__ import annotations

import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import tempfile
from typing import Any, Sequence

import numpy as np

from kerf import _kerf
from kerf._progress import _on_terminal


def find_program() -> str:
    """Returns the path of the program: $KERF_PROGRAM, the one of this installation or build, or the one on the PATH."""
    given = os.environ.get("KERF_PROGRAM")
    if given:
        return given
    here = pathlib.Path(__file__).parent
    for candidate in (here / "_installed/bin/kerf", pathlib.Path(_kerf.__file__).parent / "../../kerf", here / "../../../../bin/kerf"):
        if candidate.is_file():
            return str(candidate.resolve())
    found = shutil.which("kerf")
    if found is None:
        raise _kerf.Error("the program kerf was not found; install it, or set the environment variable KERF_PROGRAM to its path")
    return found


def _call(arguments: Sequence[str], codes: tuple[int, ...] = (0,), progress: Any = None) -> dict[str, Any]:
    """Returns the JSON document that the program prints. The program shows its own progress in a terminal."""
    shown = progress is not False and _on_terminal()
    command = [find_program(), *arguments]
    with tempfile.TemporaryFile() as messages:
        try:
            process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=None if shown else messages,
                                       stdin=subprocess.DEVNULL, text=True)
        except OSError as error:
            raise _kerf.Error(f"the program {command[0]} cannot be started: {error.strerror}") from None
        try:
            text, _ = process.communicate()
        except BaseException:  # Ctrl-C: the program ends cleanly too
            process.send_signal(signal.SIGINT)
            process.wait()
            raise
        document = _parse(text) if process.returncode in codes else None
        if document is None:
            messages.seek(0)
            raise _make_error(messages.read(), command, process.returncode)
    return document


def _make_error(messages: bytes, command: Sequence[str], code: int) -> Exception:
    """Returns kerf.Error with the program's last message."""
    lines = messages.decode(errors="replace").strip().splitlines()
    sentence = next((line for line in reversed(lines) if line.startswith("kerf: ")), "")
    sentence = sentence.removeprefix("kerf: ").removeprefix("error: ")
    return _kerf.Error(sentence or f"'{' '.join(command)}' ended with exit code {code}")


def _parse(text: str) -> dict[str, Any] | None:
    try:
        document = json.loads(text)
    except json.JSONDecodeError:
        return None
    return document if isinstance(document, dict) else None


def _read_csv(path: pathlib.Path) -> Any:
    """Returns a table as a structured array with the names of its columns; text columns are of the type str."""
    return np.genfromtxt(path, delimiter=",", names=True, dtype=None, encoding="utf-8", deletechars="", ndmin=1)


class _SceneFile:
    """The file of a scene: its own, or a temporary one with the same name for a scene that was made in Python."""

    def __init__(self, scene: Any) -> None:
        self._scene = scene
        self._made: tempfile.TemporaryDirectory[str] | None = None

    def __enter__(self) -> str:
        if not isinstance(self._scene, _kerf.Scene):
            return os.fsdecode(self._scene)
        own = pathlib.Path(self._scene.path)
        if own.is_file() and own.read_text(encoding="utf-8", errors="replace") == self._scene.toml:
            return str(own)
        text = self._scene.resolve()  # names files absolutely, so that it can be in any folder
        self._made = tempfile.TemporaryDirectory(prefix="kerf_")
        made = pathlib.Path(self._made.name) / f"{own.stem}.toml"
        made.write_text(text, encoding="utf-8")
        return str(made)

    def __exit__(self, *_: Any) -> None:
        if self._made is not None:
            self._made.cleanup()


def compare(scene: Any, laws: Sequence[str] = (), repeat: int = 3, progress: Any = None) -> dict[str, Any]:
    """Makes the same cut in voxel mode and slab mode; returns forces, work, time and memory of each.

    scene: path or Scene, with a [slab] section. laws: force laws in addition to the scene's. repeat: runs of each case.
    Returns the document compare.json (docs/formats.md), and "curves": compare.csv, the force of each case over the depth,
    as a structured array. Raises kerf.Error. `kerf compare` also writes figures.
    """
    with _SceneFile(scene) as file, tempfile.TemporaryDirectory(prefix="kerf_") as folder:
        options = ["--laws", ",".join(laws)] if laws else []
        document = _call(["compare", file, "-o", folder, "--repeat", str(repeat), "--json", *options], progress=progress)
        return {**document, "curves": _read_csv(pathlib.Path(folder) / "compare.csv")}


def study(study_file: Any = None, jobs: int = 0, errors_only: bool = False, costs_only: bool = False, data: Any = None,
          output: Any = None, progress: Any = None) -> dict[str, Any]:
    """Measures how much computing time accuracy costs; returns errors and times for many settings and paths.

    study_file: a study (TOML, docs/study.md); None: the default study, which takes hours. jobs: cases at once, 0: one for
    each core. output: folder that keeps the records, with which the same call continues a study that was stopped; None: a
    temporary one, which Ctrl-C leaves if it has records. Returns the document study.json (docs/formats.md), and "cases":
    cases.csv, errors and times of each case, as a structured array. Raises kerf.Error. `kerf study` also writes figures.
    """
    options = [*(["--errors-only"] if errors_only else []), *(["--costs-only"] if costs_only else []),
               *(["--data", os.fsdecode(data)] if data is not None else [])]
    folder = pathlib.Path(tempfile.mkdtemp(prefix="kerf_") if output is None else os.fsdecode(output))
    kept = output is not None
    try:
        with tempfile.TemporaryDirectory(prefix="kerf_") as made:
            file = pathlib.Path(made, "study_default.toml") if study_file is None else pathlib.Path(os.fsdecode(study_file))
            if study_file is None:
                _write_default_study(file)
            _call(["study", str(file), "-o", str(folder), "--jobs", str(jobs), "--json", *options], progress=progress)
        document: dict[str, Any] = json.loads((folder / "study.json").read_text(encoding="utf-8"))
        return {**document, "cases": _read_csv(folder / "cases.csv")}
    except KeyboardInterrupt:
        kept = kept or any((folder / "cases").glob("*.json"))
        raise
    finally:
        if not kept:
            shutil.rmtree(folder, ignore_errors=True)


def _write_default_study(path: pathlib.Path) -> None:
    command = [find_program(), "study", "--defaults"]
    try:
        text = subprocess.run(command, capture_output=True, check=True, stdin=subprocess.DEVNULL).stdout
    except OSError as error:
        raise _kerf.Error(f"the program {command[0]} cannot be started: {error.strerror}") from None
    except subprocess.CalledProcessError as error:
        raise _make_error(error.stderr, command, error.returncode) from None
    path.write_bytes(text)


def stability(scene: Any, quick: bool = False, seed: int = 1, progress: Any = None) -> dict[str, Any]:
    """Examines whether a scene's bone, tool, device, hand and gains are stable together.

    scene: path or Scene. quick: fewer hands and a coarser map. Returns the document stability.json (docs/formats.md),
    also if something is not stable. Raises kerf.Error.
    """
    with _SceneFile(scene) as file:
        return _call(["stability", file, "--seed", str(seed), "--json", *(["--quick"] if quick else [])], codes=(0, 1), progress=progress)


def score(recording: Any, bone: Any = None, progress: Any = None) -> dict[str, Any]:
    """Measures the cut of a recording, and scores it if its scene is an exercise (docs/practise.md).

    recording: path of a .kerf file. bone: path of its bone, if it was moved. Returns the document of `kerf score --json`
    (docs/json.md). Raises kerf.Error.
    """
    options = [] if bone is None else ["--bone", os.fsdecode(bone)]
    return _call(["score", os.fsdecode(recording), "--json", *options], codes=(0, 3), progress=progress)
