"""Scenes as TOML text, from Python values."""

from __future__ import annotations

import json
import math
from typing import Any, Mapping

from kerf import _kerf


def write_value(value: Any) -> str:
    """Returns a value in TOML."""
    if hasattr(value, "tolist"):  # NumPy
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        if math.isnan(value):
            return "nan"
        return repr(value) if math.isfinite(value) else ("inf" if value > 0 else "-inf")
    if isinstance(value, str):
        if not _is_unicode(value):
            raise _kerf.Error(f"a scene cannot have the text {value!a}, which is not valid Unicode")
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if hasattr(value, "__fspath__"):
        return write_value(value.__fspath__())
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(write_value(v) for v in value) + "]"
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{_key(k)} = {write_value(v)}" for k, v in value.items()) + "}"
    raise _kerf.Error(f"a scene cannot have a value of the type {type(value).__name__}")


def _is_unicode(text: str) -> bool:
    """Returns False for what os.fsdecode() makes of file names that are not UTF-8."""
    try:
        text.encode()
    except UnicodeEncodeError:
        return False
    return True


def _key(key: Any) -> str:
    if not isinstance(key, str) or not _is_unicode(key):
        raise _kerf.Error(f"a scene's key must be a text, not {key!a}")
    plain = key and all(c.isascii() and (c.isalnum() or c in "_-") for c in key)
    return key if plain else json.dumps(key, ensure_ascii=False)


def _is_tables(value: Any) -> bool:
    return isinstance(value, (list, tuple)) and len(value) > 0 and all(isinstance(v, Mapping) for v in value)


def write(tables: Mapping[str, Any], path: str = "") -> str:
    """Returns a dict of dicts as TOML: values first, then tables and arrays of tables."""
    lines, below = [], []
    for key, value in tables.items():
        name = f"{path}.{_key(key)}" if path else _key(key)
        if isinstance(value, Mapping):
            below.append(f"\n[{name}]\n" + write(value, name))
        elif _is_tables(value):
            below += [f"\n[[{name}]]\n" + write(v, name) for v in value]
        else:
            lines.append(f"{_key(key)} = {write_value(value)}\n")
    return "".join(lines + below)
