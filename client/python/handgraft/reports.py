"""What a session tells when it is asked: better places for a patch, and what differs between snapshots."""

from __future__ import annotations

from typing import Any, Mapping, NamedTuple


class Difference(NamedTuple):
    """One thing that two states of a session have otherwise."""

    what: str  #: ``joint thumb_mcp``, ``patch index mean mm``, ``objective``
    a: str  #: of the first, with its unit
    b: str
    change: float  #: b - a in that unit; NaN where they are no numbers


class Suggestion:
    """A place on the hand where a patch loses fewer points."""

    def __init__(self, message: Mapping[str, Any]):
        self.message = message  #: the whole PlacementSuggestion of idl/sessions.idl
        self.moved_m: float = message["moved_m"]  #: of the root, along the skin
        self.turned_rad: float = message["turned_rad"]
        self.points: int = message["point_count"]  #: that the hand has a place for
        self.lost: int = message["lost_count"]
        self.reasons: dict[str, int] = {one["reason"]: one["count"] for one in message["lost"]}  #: of those lost

    def __repr__(self) -> str:
        return f"Suggestion({1e3 * self.moved_m:.1f} mm away, {self.points} points, {self.lost} lost)"
