"""Arguments before they are sent: what is none of what is permitted is told by name, value and what is."""

from __future__ import annotations

import os
from typing import Any, Mapping

from . import _handgraft
from .errors import InvalidInput, WrongType

#: What the command line calls how a contact map is read, and what the contract does (ContactOptions of idl/models.idl).
_MAP_OPTIONS = {
    "value": "value_property", "label": "label_property", "colors": "color_scale", "joints_hand": "joints_hand",
    "threshold": "threshold", "otsu": "otsu", "low_share": "low_share", "outline": "outline_share",
    "smooth": "smoothing_steps", "min_area": "minimum_area_m2", "points": "interpolation_count",
}
#: Files that are sent with a map.
_MAP_FILES = ("picture", "joints")
_HANDS = {"left": 0, "right": 1, 0: 0, 1: 1}


def text_of(name: str, value: Any) -> str:
    """Of an argument that is text."""
    if not isinstance(value, str):
        raise WrongType(f"{name} {value!r}: it must be text")
    return value


def path_of(name: str, value: Any) -> str:
    """Of an argument that is the path of a file."""
    try:
        return text_of(name, os.fspath(value))
    except TypeError:
        raise WrongType(f"{name} {value!r}: it must be the path of a file") from None


def is_path(model: Any, option: str) -> bool:
    """Of a model, which is the name of one on the server or a file's path."""
    if isinstance(model, os.PathLike):
        return True
    if not isinstance(model, str):
        raise WrongType(f"{option}: {model!r} is neither a model's name nor a file's path")
    return _handgraft.is_path(model)


def count_of(name: str, value: Any, least: int, most: int) -> int:
    """Of a whole number."""
    try:
        number = value.__index__()
    except AttributeError:
        raise WrongType(f"{name} {value!r}: it must be a whole number, {least} to {most}") from None
    if not least <= number <= most:
        raise InvalidInput(f"{name} {value!r}: it must be {least} to {most}")
    return int(number)


def number_of(name: str, value: Any) -> float:
    """Of a number."""
    try:
        return float(value)
    except (TypeError, ValueError):
        raise WrongType(f"{name} {value!r}: it must be a number") from None


def is_of_map(option: str) -> bool:
    """An option says how a contact map is read."""
    return option in _MAP_OPTIONS or option in _MAP_FILES or option in _MAP_OPTIONS.values()


def map_options(options: Mapping[str, Any]) -> tuple[dict[str, str], dict[str, Any]]:
    """The files that go with a contact map, and how it is read, as the contract says it."""
    files = {name: path_of(name, options[name]) if options.get(name) else "" for name in _MAP_FILES}
    reading: dict[str, Any] = {}
    for name, value in options.items():
        if name in _MAP_FILES or value is None:
            continue
        if not is_of_map(name):
            raise TypeError(f"contacts have no option {name!r}; there are {', '.join([*_MAP_OPTIONS, *_MAP_FILES])}")
        if name == "joints_hand":
            if value not in _HANDS:
                raise InvalidInput(f"joints_hand {value!r}: permitted are left, right, 0, 1")
            if not files["joints"]:
                raise InvalidInput(f"joints_hand {value!r}: it goes with joints")
            value = _HANDS[value]
        reading[_MAP_OPTIONS.get(name, name)] = value
    if files["picture"] and not reading.get("color_scale"):
        raise InvalidInput(f"picture {files['picture']!r}: colors must say what its colours mean: grey, hot, inferno, jet "
                           "or viridis")
    return files, reading
