"""A progress bar with the time left, in a terminal or a notebook, for work that takes over two seconds."""

from __future__ import annotations

import sys
import time
from typing import Any, Callable

_DELAY_S = 2.0
_WIDTH = 30


def _in_notebook() -> bool:
    shell = sys.modules.get("IPython")
    instance = shell.get_ipython() if shell is not None else None
    return instance is not None and hasattr(instance, "kernel")


class Bar:
    """Draws on stderr; a notebook shows it below the cell."""

    def __init__(self, label: str) -> None:
        self._label = label
        self._began = time.monotonic()
        self._drawn = 0

    def __call__(self, fraction: float) -> None:
        passed_s = time.monotonic() - self._began
        if passed_s < _DELAY_S:
            return
        full = round(_WIDTH * fraction)
        left = f", {passed_s * (1 - fraction) / fraction:.0f} s left" if fraction > 0.01 else ""
        text = f"{self._label} [{'#' * full}{'.' * (_WIDTH - full)}] {100 * fraction:3.0f} %{left}"
        sys.stderr.write("\r" + text.ljust(self._drawn))
        sys.stderr.flush()
        self._drawn = len(text)

    def end(self) -> None:
        """Removes the bar."""
        if self._drawn:
            sys.stderr.write("\r" + " " * self._drawn + "\r")
            sys.stderr.flush()
        self._drawn = 0


def make(progress: Any, label: str) -> Callable[[float], Any] | None:
    """Returns what is called with the fraction done. progress: None, False, True (a bar in any case), or a function."""
    if progress is None:
        progress = sys.stderr.isatty() or _in_notebook()
    if progress is False:
        return None
    return Bar(label) if progress is True else progress
