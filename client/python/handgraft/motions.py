"""A hand that follows a motion, as numpy arrays, and a demonstrator who is followed live."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Any, Mapping, Sequence

import numpy as np

from . import _handgraft
from .errors import Error, InvalidInput, NotBegun
from .poses import Pose, in_order, matrices_of, message_of

if TYPE_CHECKING:
    from .session import Session

#: From which presence on a patch counts as there (PRESENCE_COUNTED of idl/motions.idl).
COUNTED = 0.5


class PatchOverTime:
    """How one patch of a motion is followed, frame by frame: arrays of T, NaN where it is not there."""

    def __init__(self, name: str, frames: int):
        self.name = name
        self.presence: np.ndarray = np.zeros(frames)  #: 0 to 1: between, it comes or goes
        self.mean_mm: np.ndarray = np.full(frames, np.nan)
        self.normal_deg: np.ndarray = np.full(frames, np.nan)
        self.reached: np.ndarray = np.zeros(frames, dtype=bool)  #: as a grasp's verdict is

    @property
    def there(self) -> np.ndarray:
        """The frames, as bool, in which it counts as there."""
        return self.presence >= COUNTED

    def __repr__(self) -> str:
        there = int(self.there.sum())
        return f"PatchOverTime({self.name!r}, there in {there} frames, reached in {int((self.reached & self.there).sum())})"


class Motion:
    """A hand that follows a motion: T frames, as a session's last answer has them."""

    def __init__(self, frames: Sequence[Mapping[str, Any]], joint_names: Sequence[str], patch_names: Sequence[str],
                 summary: Mapping[str, Any] | None = None, revision: int = 0):
        self.frames = list(frames)  #: MotionFrame of idl/motions.idl, each
        self.summary = summary  #: MotionSummary, of `Session.solve_motion`; None after edits
        self.revision = revision  #: of the edits that these frames answer
        self.joint_names = list(joint_names)
        self.time_s: np.ndarray = np.array([frame["time_s"] for frame in frames])  #: T, from the motion's begin
        self.joints: np.ndarray = np.array([frame["joint_positions"] for frame in frames])  #: T x J, rad or m
        self.X_WH: np.ndarray = matrices_of([frame["X_WH"] for frame in frames])  #: T x 4 x 4, the hand's root
        self.X_WO: np.ndarray = matrices_of([frame["X_WO"] for frame in frames])  #: T x 4 x 4, the object
        self.depth_m: np.ndarray = np.array([frame["max_depth_m"] for frame in frames])  #: T, in the object
        self.self_depth_m: np.ndarray = np.array([frame["self_depth_m"] for frame in frames])  #: T, in itself
        self.patches: dict[str, PatchOverTime] = {name: PatchOverTime(name, len(frames)) for name in patch_names}
        for k, frame in enumerate(frames):
            # A patch may be there several times (a palm's recorded points): then each has to be reached.
            fits: dict[int, list[Mapping[str, Any]]] = {}
            for fit in frame["patches"]:
                fits.setdefault(fit["patch"], []).append(fit)
            for index, told in fits.items():
                counted = [fit for fit in told if fit["presence"] >= COUNTED] or told
                points = sum(fit["point_count"] for fit in counted)
                patch = self.patches[patch_names[index]]
                patch.presence[k] = max(fit["presence"] for fit in told)
                patch.mean_mm[k] = sum(fit["point_count"] * fit["mean_mm"] for fit in counted) / points
                patch.normal_deg[k] = sum(fit["point_count"] * fit["normal_deg"] for fit in counted) / points
                patch.reached[k] = all(fit["reached"] for fit in counted)

    @property
    def touches(self) -> np.ndarray:
        """The frames, as bool, in which any patch is there."""
        return np.any([patch.there for patch in self.patches.values()], axis=0)

    @property
    def reached(self) -> np.ndarray:
        """The frames, as bool, that touch and in which every patch that is there is reached."""
        missed = np.any([patch.there & ~patch.reached for patch in self.patches.values()], axis=0)
        return self.touches & ~missed

    def __len__(self) -> int:
        return len(self.frames)

    def __getitem__(self, joint: str) -> np.ndarray:
        """Positions of one joint, T."""
        if joint not in self.joint_names:
            raise KeyError(f"joint {joint!r}: there are {', '.join(self.joint_names)}")
        return self.joints[:, self.joint_names.index(joint)]

    def __repr__(self) -> str:
        return (f"Motion({len(self)} frames in {self.time_s[-1]:.2f} s, reached in {int(self.reached.sum())} of "
                f"{int(self.touches.sum())} that touch, {1e3 * self.depth_m.max():.1f} mm deep at most)")


class Demonstrator:
    """A human hand, or another robot's, that a session's hand follows live. Made by `Session.follow`.

    Each frame tells where the demonstrator's hand and the object are; the server finds where they touch and
    answers by a pose, which `Session.watch` and all other watchers see, too. `Pose.time_s` tells of which frame,
    `Pose.patches` how the hand meets each part that touches now (``index_tip``, ``palm_1``), `Pose.depth` how deep it is.
    While nothing touches the hand comes near, and lets go, as the demonstrator's does; a hand without digits to compare
    begins once the demonstrator has touched the object with three parts, or pinched it. A session follows one
    demonstrator at a time.
    """

    def __init__(self, session: Session, chirality: str):
        self._session = session
        self._writer = _handgraft.DemonstratorWriter(session._session)
        self._chirality = chirality
        self._joints: dict[str, list[str]] = {}
        self._stream = session._session.watch()

    def send(self, time_s: float, X_WO: np.ndarray, *, places: Any = None, mano: Any = None,
             joints: Mapping[str, float] | Sequence[float] | None = None, hand: str = "",
             X_WH: np.ndarray | None = None) -> None:
        """One frame of the demonstrator's own clock, which has to rise (one that goes back by 0.25 s and more begins
        anew). One of these tells the hand:

        ``places``: 21 x 3, m, in the world: the wrist, then of thumb, index, middle, ring and little finger three
        joints from the knuckle on and the tip. ``mano``: MANO's 48 rotation vector entries and its translation, m.
        ``joints``: positions of the joints of ``hand``, a model of the server, by name or in its order, with its
        root ``X_WH``.
        """
        told = [(kind, values) for kind, values in (("joint_places", places), ("mano", mano), ("joints", joints))
                if values is not None]
        if len(told) != 1:
            raise ValueError(f"a frame tells places, mano or joints; {len(told)} of them are given")
        kind, values = told[0]
        if kind == "joint_places" and np.shape(values) != (21, 3):
            raise InvalidInput(f"places: an array of shape {np.shape(values)}; it must be 21 x 3")
        if isinstance(values, Mapping):
            values = in_order(values, self._joints_of(hand), f"joints of {hand!r}")
        self._writer.send({
            "time_s": time_s, "chirality": self._chirality, "kind": kind, "hand": hand,
            "values": np.asarray(values, dtype=float).ravel(),
            "X_WH": None if X_WH is None else message_of(X_WH), "X_WO": message_of(X_WO),
        })

    def _joints_of(self, hand: str) -> list[str]:
        if hand not in self._joints:
            described = self._session._server.describe("hand", hand)
            self._joints[hand] = [joint["name"] for joint in described["joints"]]
        return self._joints[hand]

    def answer(self, time_s: float, X_WO: np.ndarray, *, patience_s: float = 1.0, **hand: Any) -> Pose:
        """Sends a frame as `send` does and waits for its pose. Raises, with what the server says of it, NotBegun as long
        as the hand has no pose yet, and any other Error for a frame that is refused or not answered in time."""
        while self._stream.next(0.0) is not None:
            pass  # of frames before
        before = self._session.state()["following"]  # of a frame that was wrong, perhaps
        self.send(time_s, X_WO, **hand)
        until = time.monotonic() + patience_s
        while (left := until - time.monotonic()) > 0.0:
            event = self._stream.next(min(left, 0.05))
            if event is not None and event[0] == "solution" and event[1]["time_s"] == time_s:
                return Pose(event[1], self._session.joint_names)
            said = self._session.state()["following"]
            if event is None and said != before and said["text"]:
                break
        state = self._session.state()
        why = "the session is closed" if state["phase"] == "closed" else state["message"]
        kind = NotBegun if state["following"]["verdict"] == "waits" else Error
        raise kind(f"the frame at {time_s} s is not answered{': ' if why else ''}{why}")

    def __repr__(self) -> str:
        return f"Demonstrator({self._chirality}, followed by {self._session!r})"
