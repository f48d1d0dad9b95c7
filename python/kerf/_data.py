"""Tables as pandas frames."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from kerf import _kerf


def to_frame(table: NDArray[np.void]) -> Any:
    """Returns a structured array, such as Run.ticks, as a pandas.DataFrame. Raises kerf.Error if pandas is not installed."""
    if not isinstance(table, np.ndarray) or table.dtype.names is None:
        raise TypeError(f"table must be a structured array, such as Run.ticks, not {table!r:.60}")
    try:
        import pandas  # type: ignore
    except ImportError:
        raise _kerf.Error("pandas is not installed (Debian: python3-pandas); structured arrays work without it") from None
    return pandas.DataFrame({name: table[name] for name in table.dtype.names})
