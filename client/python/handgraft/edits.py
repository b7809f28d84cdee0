"""What can be edited in a session; the prompt's words, as functions."""

from __future__ import annotations

import os
import time
import warnings
from typing import TYPE_CHECKING, Any, Mapping, Sequence, overload

import numpy as np

from . import _handgraft
from .arguments import count_of, is_path, number_of
from .errors import InvalidInput, NoServer, WrongType
from .poses import Pose, matrix_of, message_of
from .reports import Difference, Suggestion

if TYPE_CHECKING:
    from .server import Server

_SIDES = ("hand", "object")
_SAY_ALL = ("undo", "redo", "release")  # kinds of edits that need no member
_TIMELESS = ("undo", "redo", "snapshot", "restore", "take_back")  # what moves through the history is of no time
_FARTHEST_ROOT_M = 0.05  # as the prompt has it: numbers in another unit or frame are farther


class Edits:
    """Of a `Session`. Each is answered by a fresh pose: `Session.pose` waits for it."""

    _session: _handgraft.Session
    _server: Server
    _revision: int
    _when: dict[str, float] | None

    def edit(self, kind: str, member: str | None = None, value: Any = None) -> str:
        """Any edit of idl/edits.idl: its kind, the member that it chooses, and that as a dict.

        Returns what the server has to say of it, mostly nothing.
        """
        if member is None and kind not in _SAY_ALL:
            raise InvalidInput(f"edit {kind!r}: the member that it chooses, and its value, are not given: EditBody of "
                               "idl/edits.idl has them")
        body = {"kind": kind} if member is None else {"kind": kind, member: value}
        reply = self._session.edit(body, 0, None if kind in _TIMELESS else self._when)
        self._revision = reply["revision"]
        return reply["message"]

    def lock(self, joint: str, locked: bool = True) -> None:
        """Holds a joint where it is, or lets it go; in a motion in the middle of what it does, `at` a time where it is then."""
        self.edit("joint_lock", "joint_lock", {"joint": joint, "locked": bool(locked)})

    def limit(self, joint: str, lower: float, upper: float) -> None:
        """A joint's range, rad or m; warns where angles seem to be degrees, or metres millimetres."""
        self._warning("joint_limit", "joint_limit", {"joint": joint, "lower": lower, "upper": upper})

    def hold(self, joint: str, value: float, weight: float = 1.0) -> None:
        """Holds a joint near a value by so many times the prior's weight; 0 lets it go."""
        self.edit("joint_soft", "joint_soft", {"joint": joint, "value": value, "weight": weight})

    def weigh(self, patch: str, weight: float) -> None:
        """What a patch counts; 0 switches it off."""
        self.edit("patch_weight", "patch_weight", {"patch": patch, "weight": weight})

    def enable(self, patch: str, enabled: bool = True) -> None:
        """Has a patch count, or not."""
        self.edit("patch_enabled", "patch_enabled", {"patch": patch, "enabled": bool(enabled)})

    def turn(self, patch: str, angle: float, side: str = "hand") -> None:
        """Turns a patch about the outward normal, counter-clockwise, on the hand or the object."""
        self.edit("patch_direction", "patch_direction", {"patch": patch, "side": side, "angle_rad": angle})

    def place(self, X_WO: np.ndarray) -> None:
        """Moves the object: its pose in the world, 4x4."""
        self.edit("object_pose", "X_WO", message_of(X_WO))

    def weights(self, distance: float, normal: float, prior: float) -> None:
        """What distances (1/m^2), normals and the prior count."""
        self.edit("weights", "weights", {"distance": distance, "normal": normal, "prior": prior})

    @overload
    def drag(self, link: str, p_L: Sequence[float], target_W: Sequence[float], weight: float = 1.0) -> None: ...

    @overload
    def drag(self, link: str, *, to: Sequence[float], weight: float = 1.0) -> None: ...

    def drag(self, link: str, p_L: Sequence[float] | None = None, target_W: Sequence[float] | None = None,
             weight: float = 1.0, *, to: Sequence[float] | None = None) -> None:
        """Moves a point of the hand to a place in the world, and holds it there until `release`.

        A point of a link (m, in the link's frame), or by its name alone: ``drag("index", to=(x, y, z))`` a site's,
        ``index_tip`` the end of that site's link, the name of a link its origin.

        ``weight`` 1 holds it 20 times as firmly as all patches together; 0: the next solve may take it back. Warns
        where it falls short of its target.
        """
        given = [p_L is not None, target_W is not None, to is not None]
        if given not in ([True, True, False], [False, False, True]):
            raise InvalidInput(f"drag {link!r}: p_L and target_W have to be given, or to alone")
        if to is None:
            point = {"link": link, "p_L_m": p_L}
        else:
            point = self._point(link)
            target_W = _numbers("to", to, 3)
        self._warning("drag", "drag", {**point, "target_W_m": target_W, "weight": weight})

    def palm(self, to: Sequence[float], R_WL: np.ndarray | None = None) -> None:
        """Moves the palm to a place in the world, m, and holds it there until `release`; warns where it falls short.

        ``R_WL``: how its link is turned then, a 3x3 rotation to the world; None: as it comes.
        """
        point = self._point("")
        edit = {**point, "target_W_m": _numbers("to", to, 3), "weight": 1.0}
        if R_WL is not None:
            X_WL = np.eye(4)
            X_WL[:3, :3] = _rotation("R_WL", R_WL)
            edit["target_q_wxyz"] = message_of(X_WL)["q_wxyz"]
        self._warning("drag", "drag", edit)

    def release(self, link: str = "") -> None:
        """Lets go what was dragged of a link, or of the link of a point that `drag` knows by name, or all of it."""
        if link:
            link = self._point(link)["link"]
        self.edit("release", "release", {"link": link})

    def _point(self, name: str) -> dict[str, Any]:
        """The link and the place on it that a name means; the palm's if it is empty."""
        return self._server._client.hand_point(self._heard()["hand"], name)

    # === Where a patch lies

    def root(self, patch: str, side: str = "hand", *, pick: str | None = None, at: Sequence[float] | None = None,
             face: Sequence[float] | None = None) -> None:
        """Puts a patch's root somewhere on the hand's skin, or, with ``side="object"``, on the object's mesh.

        On a site of the hand (``pick="index"``); on the surface's place nearest to a point (``at``: m, in the frame of
        the object or of the skin); or on a face (``face``: its number and three weights that sum to 1).
        """
        if side not in _SIDES:
            raise InvalidInput(f"side {side!r}: permitted are {', '.join(_SIDES)}")
        if [pick is None, at is None, face is None].count(False) != 1:
            raise InvalidInput(f"root of patch {patch!r}: one of pick, at and face has to be given, no two")
        if pick is not None:
            if side != "hand":
                raise InvalidInput(f"pick {pick!r}: sites are of the hand; side is {side!r}")
            root, _ = self._nearest(side, self._place_on_skin(pick))
        elif at is not None:
            point = _numbers("at", at, 3)
            root, distance = self._nearest(side, point)
            if not distance <= _FARTHEST_ROOT_M:
                surface = "object's surface" if side == "object" else "hand's skin"
                raise InvalidInput(f"at {point.tolist()}: it is {1e3 * distance:.0f} mm from the {surface}; at most "
                                   f"{1e3 * _FARTHEST_ROOT_M:.0f} mm are permitted")
        else:
            number, *weights = _numbers("face", face, 4)
            if number != int(number) or number < 0:
                raise InvalidInput(f"face {number:g}: it must be a whole number, 0 or more")
            if min(weights) < 0 or abs(sum(weights) - 1) > 1e-3:
                raise InvalidInput(f"face: weights {weights}: they must not be negative and sum to 1")
            root = {"face": int(number), "barycentric": np.array(weights) / sum(weights)}
        self.edit("patch_root", "patch_root", {"patch": patch, "side": side, "root": root})

    def suggest(self, patch: str, *, reach: float = 0.0, count: int = 0, apply: int = 0) -> list[Suggestion]:
        """Places on the hand nearby where a patch loses fewer points, best first; empty: none is better.

        ``reach``: how far the root may move, m (1e-4 to 0.1; 0: 0.01); ``count``: at most so many (1 to 100; 0: 5).
        ``apply`` takes one, counted from 1, by edits of root and direction; 0 takes none.
        """
        if not (number_of("reach", reach) == 0.0 or 1e-4 <= reach <= 0.1):
            raise InvalidInput(f"reach {reach!r}: it must be 1e-4 to 0.1 (m), or 0")
        request = {"session_id": self._session.id, "patch": patch, "reach_m": reach,
                   "count": count_of("count", count, 0, 100)}
        reply = self._server._client.ask({"kind": "suggest", "suggest": request})["suggest"]
        suggestions = [Suggestion(one) for one in reply["suggestions"]]
        if apply:
            if not 1 <= apply <= len(suggestions):
                raise InvalidInput(f"apply {apply!r}: there are {len(suggestions)} suggestions, counted from 1")
            chosen = suggestions[apply - 1]
            self.edit("patch_root", "patch_root", {"patch": patch, "side": "hand", "root": chosen.message["root_S"]})
            if chosen.turned_rad:
                self.turn(patch, chosen.turned_rad)
        return suggestions

    def _place_on_skin(self, site: str) -> np.ndarray:
        hand = self._server.describe("hand", self._heard()["hand"], meshes=True)
        sites = {one["name"]: one for one in hand["sites"]}
        if site not in sites:
            raise InvalidInput(f"pick {site!r}: the hand has no such site; there are {', '.join(sites)}")
        link = [one["name"] for one in hand["links"]].index(sites[site]["link"])
        return (matrix_of(hand["X_SL"][link]) @ [*sites[site]["p_L_m"], 1.0])[:3]

    def _nearest(self, side: str, point: np.ndarray) -> tuple[dict[str, Any], float]:
        """The surface's place nearest to a point, and how far it is, m."""
        found = self._server._client.nearest(side, self._heard()[side], point.tolist())
        return found["root"], found["distance_m"]

    # === Prior and start

    def joint(self, joint: str, value: float) -> None:
        """Bends a joint, rad or m: the pose becomes prior and start."""
        self.prior({joint: value})

    def prior(self, pose: str | os.PathLike[str] | Pose | Mapping[str, float], X_WH: np.ndarray | None = None) -> None:
        """A pose becomes prior and start: of the next solve, and what a solution stays near to.

        ``"rest"``: the hand's rest pose, the palm stays; ``"here"``: the last solution; a `Pose`; joints by name,
        rad or m, of those that change; or the path of a pose's file (``grasp --out`` writes one). ``X_WH``: the
        hand's root, where it is not told by these; None: it stays.
        """
        edit = self._prior_of(pose)
        if X_WH is not None:
            edit["X_WH"] = message_of(X_WH)
        self._warning("prior", "prior", edit)

    def _prior_of(self, pose: Any) -> dict[str, Any]:
        if isinstance(pose, str) and pose == "here":
            pose = self.pose(diagnosed=False)  # type: ignore[attr-defined]
        if isinstance(pose, Pose):
            return {"X_WH": pose.message["X_WH"], "joints": pose.joint_names, "joint_positions": pose.joints}
        if isinstance(pose, str) and pose == "rest":
            hand = self._server.describe("hand", self._heard()["hand"])
            return {"joints": [joint["name"] for joint in hand["joints"]], "joint_positions": hand["rest_positions"]}
        if isinstance(pose, Mapping):
            return {"joints": list(pose), "joint_positions": list(pose.values())}
        if isinstance(pose, os.PathLike) or isinstance(pose, str) and _handgraft.is_path(pose):
            return _handgraft.pose_file(os.fspath(pose))
        raise InvalidInput(f"prior {pose!r}: permitted are 'rest', 'here', a pose, joints by name, the path of a pose's "
                           "file")

    def prior_shares(self, rotation: float, place: float, joints: float) -> None:
        """How firmly the prior holds the palm's rotation, its place and the joints; 1, 1, 1 is the paper's."""
        self._share(root_rotation=rotation, root_translation=place, joints=joints)

    def prior_posture(self, share: float) -> None:
        """How firmly a first solve holds the hand's posture; 0: not at all."""
        self._share(posture=share)

    def _share(self, **shares: float) -> None:
        stand = self._session.settings()["prior_shares"]
        self.edit("prior_shares", "prior_shares", {**stand, **shares})

    # === Models and search

    def hand(self, hand: str | os.PathLike[str]) -> None:
        """Takes another hand, a name on the server or the path of a URDF to send; what still fits is kept."""
        hand = self._server.load_hand(hand) if is_path(hand, "hand") else hand
        self._warning("hand", "swapped_model", {"name": hand})

    def object(self, object: str | os.PathLike[str], *, units: str = "") -> None:
        """Takes another object, likewise; ``units`` of a file: m, cm, mm or in."""
        if is_path(object, "object"):
            object = self._server.load_object(object, units=units)
        elif units:
            raise InvalidInput(f"units {units!r}: object {object!r} is no file")
        self._warning("object", "swapped_model", {"name": object})

    def solver(self, solver: str | None = None, *, starts: int | None = None, seed: int | None = None,
               max_evaluations: int | None = None, normal_form: str | None = None,
               touch_only: bool | None = None) -> None:
        """How poses are searched from now on, also after edits; what is None stays as it is.

        ``solver``: default, lm, mma, ccsaq, slsqp, lbfgs, tnewton, var2, or all of them, ranked; ``paper`` searches as
        the paper does: one start, the prior, by mma. ``starts``, ``seed``, ``max_evaluations`` (of a start): 0 is the
        default. ``normal_form``: cosine, the paper's, or sum. With ``touch_only`` depth costs nothing.
        """
        changes: dict[str, Any] = {}
        if solver == "paper":
            if starts is not None:
                raise InvalidInput("solver 'paper': it has its own start, so starts does not go with it")
            changes |= {"solver": "default", "starts": 0, "paper": True}
        elif solver is not None or starts is not None:
            changes["paper"] = False
        given = {"solver": None if solver == "paper" else solver, "starts": starts, "seed": seed,
                 "max_evaluations": max_evaluations, "normal_form": normal_form}
        changes |= {name: value for name, value in given.items() if value is not None}
        if touch_only is not None:
            changes["penetration"] = "reported" if touch_only else "avoided"
        self.edit("solving", "solving", {**self._session.settings()["solving"], **changes})

    # === Back and forth

    def choose(self, rank: int) -> None:
        """Takes one of the places where searches ended, as `Pose.minima` ranks them; 0 is the best."""
        self.edit("choice", "choice", {"rank": rank})

    def undo(self, count: int = 1) -> None:
        """Takes back edits."""
        self.edit("undo", "steps", {"count": count})

    def redo(self, count: int = 1) -> None:
        """Brings back edits that were taken back."""
        self.edit("redo", "steps", {"count": count})

    def take_back(self, index: int) -> None:
        """Takes back an edit `at` a time of a motion, whoever made it and whatever was edited since.

        ``index``: which one of ``settings()["timed"]``; below 0 from the end, as of any list.
        """
        count = len(self._session.settings()["timed"])
        if count == 0:
            raise InvalidInput(f"index {index!r}: nothing was edited at a time")
        index = count_of("index", index, -count, count - 1)
        self.edit("take_back", "take_back", {"index": index % count})

    # === Snapshots

    def snapshot(self, name: str) -> None:
        """Remembers the session as it is under a name."""
        self.edit("snapshot", "snapshot", {"name": name})

    def restore(self, snapshot: str) -> None:
        """Makes the session as it was at a snapshot."""
        self.edit("restore", "snapshot", {"name": snapshot})

    def compare(self, snapshot: str, other: str = "") -> list[Difference]:
        """What differs between a snapshot and now, or another snapshot; empty: nothing."""
        request = {"session_id": self._session.id, "a": snapshot, "b": other}
        reply = self._server._client.ask({"kind": "compare", "compare": request})["compare"]
        return [Difference(**one) for one in reply["differences"]]

    def _heard(self) -> dict[str, Any]:
        """The session's state once the last edit of this program is in it."""
        while True:
            state = self._session.state()
            if state["phase"] == "closed" or state["revision"] >= self._revision:
                return state
            if not self._server._client.alive():
                raise NoServer("the server stopped answering")
            time.sleep(0.005)

    def _warning(self, kind: str, member: str, value: Any) -> None:
        """An edit whose answer, where there is one, is a warning to who called its function."""
        said = self.edit(kind, member, value)
        if said:
            warnings.warn(said, stacklevel=3)


def _rotation(name: str, matrix: Any) -> np.ndarray:
    try:
        R = np.asarray(matrix, dtype=float)
    except (TypeError, ValueError):
        raise WrongType(f"{name} {matrix!r}: it must be a 3x3 rotation") from None
    if R.shape != (3, 3) or not np.allclose(R @ R.T, np.eye(3), atol=1e-6) or np.linalg.det(R) < 0:
        raise InvalidInput(f"{name} {R.tolist()}: it must be a 3x3 rotation")
    return R


def _numbers(name: str, values: Any, count: int) -> np.ndarray:
    try:
        numbers = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise WrongType(f"{name} {values!r}: it must be {count} numbers") from None
    if numbers.shape != (count,) or not np.isfinite(numbers).all():
        raise InvalidInput(f"{name} {values!r}: it must be {count} finite numbers")
    return numbers
