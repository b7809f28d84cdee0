"""What a designer asks of a hand that is not built yet: values of its joints and links over grasps and motions."""

from __future__ import annotations

from typing import Any, Mapping, Sequence

import numpy as np

from .errors import InvalidInput

_PROPERTIES = ("lower", "upper", "range", "length", "size")


def property_of(name: str) -> dict[str, Any]:
    """The property and target of ``thumb_mcp.upper``, ``index_2.length``, ``hand.size``."""
    target, _, which = name.rpartition(".")
    if not target or which not in _PROPERTIES:
        raise InvalidInput(f"{name!r}: must be JOINT.lower, .upper (rad or m) or .range (a factor), LINK.length or "
                           ".size (factors), or hand.size")
    return {"property": which, "target": "" if (target, which) == ("hand", "size") else target}


class Sweep:
    """Grasps and motions solved with every combination of values. Arrays have an axis a property, in order, and
    last one of what was grasped; NaN where there is no answer."""

    def __init__(self, reply: Mapping[str, Any], axes: Mapping[str, np.ndarray], grasps: Sequence[str]):
        self.message = reply  #: the whole SweepReply of idl/studies.idl
        self.axes = dict(axes)  #: the values of each property
        self.grasps = list(grasps)  #: names of what was grasped: a set of contacts, or a motion
        self.joint_names: list[str] = list(reply["joint_names"])
        #: What is said of each on the hand as it is: ``notes[name]``.
        self.notes: dict[str, list[str]] = {name: [] for name in self.grasps}
        for note in reply["notes"]:
            self.notes[self.grasps[note["grasp"]]].append(note["text"])
        rows = reply["rows"]
        shape = tuple(len(values) for values in self.axes.values()) + (len(self.grasps),)

        def column(name: str) -> np.ndarray:
            return np.array([np.nan if row["error"] else row[name] for row in rows]).reshape(shape)

        self.mean_mm = column("mean_mm")  #: of all points
        self.max_mm = column("max_mm")  #: of the farthest point; of a motion's patches the largest mean of a frame
        self.normal_deg = column("normal_deg")
        self.depth_m = column("max_depth_m")  #: of the deepest point in the object; of a motion's deepest frame
        self.self_depth_m = column("self_depth_m")  #: of the hand in itself
        self.patches = column("patch_count")  #: that count; of a motion the frames that touch
        self.reached = column("reached_count")  #: of those
        self.errors: np.ndarray = np.array([row["error"] for row in rows], dtype=object).reshape(shape)  #: why not
        joints = np.full((len(rows), len(self.joint_names)), np.nan)
        for k, row in enumerate(rows):
            if len(row["joint_positions"]) == joints.shape[1]:
                joints[k] = row["joint_positions"]
        self.joints: np.ndarray = joints.reshape(shape + joints.shape[1:])  #: rad or m; NaN of motions

    @property
    def share_reached(self) -> np.ndarray:
        """Of the patches (of a motion: of the frames that touch) those that are reached, over all grasps: an axis a
        property. What has no answer reaches nothing."""
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.nan_to_num(self.reached / self.patches).mean(axis=-1)

    @property
    def best(self) -> dict[str, float]:
        """The values with the largest share reached, of those with the least mean distance."""
        share = np.round(self.share_reached, 3)
        mean = np.where(np.isnan(self.mean_mm).any(axis=-1), np.inf, self.mean_mm.mean(axis=-1))
        order = np.lexsort((mean.ravel(), -share.ravel()))
        place = np.unravel_index(order[0], share.shape)
        return {name: float(values[i]) for (name, values), i in zip(self.axes.items(), place)}

    def __repr__(self) -> str:
        return f"Sweep({' x '.join(self.axes) or 'the hand as it is'}, {len(self.grasps)} grasped, best {self.best})"
