"""What motions are made of: a plan (handgraft-motion-plan/1, core/io/FORMATS.md) and the files that it names."""

from __future__ import annotations

import json
import os
import pathlib
from typing import Any, Mapping, Sequence

import numpy as np

from .errors import InvalidInput
from .poses import message_of

#: A plan, and the files that it names, as texts.
Parts = tuple[dict[str, Any], dict[str, str]]

_TIMING = ("rate_hz", "slide_begin_share", "slide_end_share", "vanish_share", "appear_share")


def of_grasps(name: str, first: str, last: str, time_s: Sequence[float], X_WO: Sequence[np.ndarray],
              timing: Mapping[str, float]) -> Parts:
    """Two sets of contacts, as texts, and the object's poses."""
    if len(time_s) != len(X_WO):
        raise InvalidInput(f"the object's path has {len(time_s)} times and {len(X_WO)} poses")
    if strange := sorted(set(timing) - set(_TIMING)):
        raise TypeError(f"join_grasps has no {strange[0]!r}; there are {', '.join(_TIMING)}")
    lines = ["time_s,x,y,z,qw,qx,qy,qz"]
    for at, pose in zip(time_s, map(message_of, X_WO)):
        lines.append(",".join(repr(float(value)) for value in (at, *pose["p_m"], *pose["q_wxyz"])))
    plan = {**_plan(name), "first": "first.json", "last": "last.json", "path": "path.csv",
            **{key: float(value) for key, value in timing.items()}}
    return plan, {"first.json": first, "last.json": last, "path.csv": "\n".join(lines) + "\n"}


def of_hand(name: str, hand: str, joint_names: Sequence[str], time_s: Sequence[float], joints: np.ndarray,
            X_WH: Sequence[np.ndarray] | None, X_WO: Sequence[np.ndarray] | None, **numbers: float | None) -> Parts:
    """What a hand did, frame by frame; ``numbers`` that are None are the server's to choose."""
    rows = np.asarray(joints, dtype=float)
    if len(time_s) != len(rows):
        raise InvalidInput(f"joints: {len(rows)} rows for {len(time_s)} times")
    if not np.all(np.isfinite(time_s)):
        raise InvalidInput("time_s: a time is not finite")
    if (wrong := np.argwhere(~np.isfinite(rows))).size > 0:
        raise InvalidInput(f"joints: frame {wrong[0][0]}, joint {wrong[0][1]} is not finite")
    frames: list[dict[str, Any]] = [{"time_s": float(at), "joints": row.tolist()} for at, row in zip(time_s, rows)]
    for key, poses in (("X_WH", X_WH), ("X_WO", X_WO)):
        if poses is None:
            continue
        if len(poses) != len(frames):
            raise InvalidInput(f"{key}: {len(poses)} poses for {len(frames)} frames")
        for frame, pose in zip(frames, map(message_of, poses)):
            frame[key] = {entry: np.asarray(values).tolist() for entry, values in pose.items()}
    plan = {**_plan(name), "hand": hand, "hand_trajectory": "did.json",
            **{key: float(value) for key, value in numbers.items() if value is not None}}
    did = {"format": "handgraft-trajectory/1", "hand": hand, "joint_names": list(joint_names), "frames": frames}
    return plan, {"did.json": json.dumps(did)}


def of_trajectory(name: str, hand: str, path: str | os.PathLike[str]) -> Parts:
    """A file of what a hand did, as motions are exported to json and csv."""
    did = "did" + pathlib.Path(path).suffix
    return {**_plan(name), "hand": hand, "hand_trajectory": did}, {did: pathlib.Path(path).read_text()}


def of_recording(name: str, path: str | os.PathLike[str], object_path: str | os.PathLike[str]) -> Parts:
    """A recording of contact points, and the splines of the object's way."""
    plan = {**_plan(name), "recording": "recording.json", "object_path": "object.smexp"}
    return plan, {"recording.json": pathlib.Path(path).read_text(), "object.smexp": pathlib.Path(object_path).read_text()}


def object_named_in(text: str) -> str:
    """The object that a file says that it is of; empty if it does not."""
    try:
        said = json.loads(text).get("object")
    except (ValueError, AttributeError):
        return ""  # no JSON: the server says what is wrong with it
    return said if isinstance(said, str) else ""


def _plan(name: str) -> dict[str, Any]:
    return {"format": "handgraft-motion-plan/1", "name": name}
