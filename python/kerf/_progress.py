"""A progress bar with the time left, in a terminal or a notebook, for work that takes over two seconds."""

from __future__ import annotations

import os
import sys
import time
from typing import Any, Callable

from kerf import _kerf

_DELAY_S = 2.0
_WIDTH = 30
_MANY = 1000


def _in_notebook() -> bool:
    shell = sys.modules.get("IPython")
    instance = shell.get_ipython() if shell is not None else None
    return instance is not None and hasattr(instance, "kernel")


def _write(text: str) -> None:
    try:
        if sys.stderr is not None:
            sys.stderr.write(text)
            sys.stderr.flush()
    except (OSError, ValueError):  # nothing can be shown
        pass


def _room() -> int:
    """Returns how many characters fit into a line of the terminal."""
    try:
        if sys.stderr is not None and sys.stderr.isatty():
            columns = os.get_terminal_size(sys.stderr.fileno()).columns
            if columns > 0:
                return columns - 1  # the cursor needs one
    except (OSError, ValueError):  # its size is not known
        pass
    return _MANY


class Bar:
    """Draws on stderr, in one line; a notebook shows it below the cell."""

    def __init__(self, label: str) -> None:
        self._label = label
        self._began = time.monotonic()
        self._text = ""

    def __call__(self, fraction: float) -> None:
        passed_s = time.monotonic() - self._began
        if passed_s < _DELAY_S:
            return
        room = _room()
        left = f", {passed_s * (1 - fraction) / fraction:.0f} s left" if fraction > 0.01 else ""
        percent = f"{100 * fraction:3.0f} %{left}"
        width = min(_WIDTH, room - len(f"{self._label} [] {percent}"))
        full = round(width * fraction)
        bar = f"[{'#' * full}{'.' * (width - full)}] " if width > 0 else ""
        text = f"{self._label} {bar}{percent}"[:room]
        if text == self._text:
            return
        _write("\r" + text.ljust(min(len(self._text), room)))
        self._text = text

    def end(self) -> None:
        """Removes the bar."""
        if self._text:
            _write("\r" + " " * min(len(self._text), _room()) + "\r")
        self._text = ""


def _on_terminal() -> bool:
    try:
        return sys.stderr is not None and sys.stderr.isatty()
    except ValueError:  # it is closed
        return False


def make(progress: Any, label: str) -> Callable[[float], Any] | None:
    """Returns what is called with the fraction done. progress: None, False, True (a bar in any case), or a function."""
    if progress is None:
        progress = _on_terminal() or _in_notebook()
    if callable(progress):
        function: Callable[[float], Any] = progress
        return function
    if progress not in (True, False):
        raise _kerf.Error("progress must be None, True, False or a function")
    return Bar(label) if progress else None
