"""The sentence of a TypeError for a call whose arguments do not fit."""

import difflib
import os
import re
import typing

import numpy as np

# What arguments of these types must be, and whether a value is one. Others are checked where they are used.
_NUMBER = "a number", lambda value: _is_number(value)
_KINDS: dict[str, tuple[str, typing.Callable[[typing.Any], bool]]] = {
    "float": _NUMBER,
    "int": ("a whole number", lambda value: hasattr(value, "__index__")),
    "bool": ("True or False", lambda value: hasattr(value, "__bool__")),
    "str": ("a text", lambda value: isinstance(value, (str, bytes))),
    "os.PathLike": ("the name of a file", lambda value: isinstance(value, (str, bytes, os.PathLike))),
    "dict": ("a dict", lambda value: isinstance(value, dict)),
    "tuple": ("a tuple", lambda value: isinstance(value, tuple)),
    "bytes": ("bytes", lambda value: isinstance(value, bytes)),
    "numpy.ndarray": ("an array", lambda value: isinstance(value, np.ndarray)),
    "list[tuple[float, int]]": ("a list of pairs (thickness in mm, number of the region)",
                                lambda value: _is_list(value, lambda pair: _is_list(pair, _is_number) and len(pair) == 2
                                                       and hasattr(pair[1], "__index__"))),
    "dict[int, int]": ("a dict from the number of a label to that of a region",
                       lambda value: isinstance(value, dict) and all(hasattr(n, "__index__") for pair in value.items() for n in pair)),
}


class _Parameter(typing.NamedTuple):
    name: str
    type: str
    default: str  # empty: it is required
    by_name: bool


def _is_number(value: typing.Any) -> bool:
    if isinstance(value, np.ndarray):
        return value.ndim == 0
    return (hasattr(value, "__float__") or hasattr(value, "__index__")) and not isinstance(value, (str, bytes))


def _is_list(value: typing.Any, check: typing.Callable[[typing.Any], bool]) -> bool:
    return hasattr(value, "__len__") and hasattr(value, "__getitem__") and not isinstance(value, (str, bytes, dict)) \
        and all(check(item) for item in value)


def _split(text: str) -> list[str]:
    """Splits at the commas that are not within brackets or texts."""
    parts, depth, quote, last = [], 0, "", 0
    for i, c in enumerate(text):
        if quote:
            quote = "" if c == quote else quote
        elif c in "'\"":
            quote = c
        elif c == "," and depth == 0:
            parts.append(text[last:i])
            last = i + 1
        else:
            depth += (c in "([{<") - (c in ")]}>")
    return [part.strip() for part in (*parts, text[last:]) if part.strip()]


def _read_parameters(message: str) -> tuple[list[_Parameter], bool]:
    """Returns the parameters of the first signature in pybind11's message, and whether there may be any others."""
    line = next(text for text in message.splitlines() if re.match(r" *1\. ", text))
    inner = re.sub(r"^.*?\(", "", line, count=1)
    inner = inner.rpartition(") -> ")[0] if ") -> " in inner else inner.rpartition(")")[0]
    parameters: list[_Parameter] = []
    open_ended = by_name = False
    for part in _split(inner):
        if part == "*":
            by_name = True
        elif part.startswith("*"):
            open_ended = True
        else:
            name, _, rest = part.partition(":")
            kind, _, default = rest.partition(" = ")
            parameters.append(_Parameter(name.strip(), kind.strip(), default, by_name))
    return parameters, open_ended


def _show(value: typing.Any) -> str:
    if isinstance(value, np.ndarray):
        return f"an array of shape {value.shape}"
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def _find_kind(name: str) -> tuple[str, typing.Callable[[typing.Any], bool]] | None:
    name = re.sub(r"\b(List|Tuple|Dict)\[", lambda old: old[0].lower(), name)  # of pybind11 before 2.12
    if optional := re.fullmatch(r"Optional\[(.*)\]", name):
        if (found := _find_kind(optional[1])) is None:
            return None
        what, check = found
        return what + " or None", lambda value: value is None or check(value)
    if listed := re.fullmatch(r"list\[kerf\._kerf\.(\w+)\]", name):
        kind = listed[1]
        return f"a list of {kind}", lambda value: _is_list(value, lambda item: type(item).__name__ == kind)
    if ours := re.fullmatch(r"(?:kerf\._kerf|kerf)\.(\w+)", name):
        own = ours[1]
        return f"a kerf.{own}", lambda value: type(value).__name__ == own
    return _KINDS.get(name)


def explain(function: str, message: str, arguments: tuple[typing.Any, ...], keywords: dict[str, typing.Any]) -> str:
    """Returns a sentence about a call that pybind11 has refused with `message`."""
    parameters, open_ended = _read_parameters(message)
    if "incompatible constructor" in message.split("\n", 1)[0]:  # pybind11 leaves self out
        arguments = arguments[1:]
    elif parameters and parameters[0].name == "self":
        arguments, parameters = arguments[1:], parameters[1:]
    places = [p for p in parameters if not p.by_name]
    if len(arguments) > len(places):
        at_most = f"at most {len(places)} argument{'s' * (len(places) != 1)}" if places else "no argument"
        return f"{function}() takes {at_most} without a name, not {len(arguments)}"
    given = dict(zip((p.name for p in places), arguments))
    known = [p.name for p in parameters]
    for name, value in keywords.items():
        if name in given:
            return f"{function}() has two values for {name}"
        if name not in known and not open_ended:
            near = difflib.get_close_matches(name, known, 1)
            hint = f"did you mean '{near[0]}'?" if near else f"there are {', '.join(known)}" if known else "there are none"
            return f"{function}() has no argument '{name}'; {hint}"
        given[name] = value
    for parameter in parameters:
        if not parameter.default and parameter.name not in given:
            return f"{function}() needs the argument {parameter.name}"
    for parameter in parameters:
        kind = _find_kind(parameter.type)
        if parameter.name in given and kind and not kind[1](given[parameter.name]):
            name = "the state" if function.endswith("__setstate__") else parameter.name
            what = kind[0] if parameter.default != "None" or kind[0].endswith("None") else kind[0] + " or None"
            return f"{name} must be {what}, not {_show(given[parameter.name])}"
    shown = ", ".join([*map(_show, arguments), *(f"{name}={_show(value)}" for name, value in keywords.items())])
    return f"{function}() does not take these values: {shown}"
