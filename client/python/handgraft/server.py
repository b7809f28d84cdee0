"""A server's models, and sessions on it."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import pathlib
import re
import warnings
from typing import Any, Iterator, Mapping, Sequence

import numpy as np

from . import _handgraft, motion_plans
from .arguments import count_of, is_of_map, is_path, map_options, path_of, text_of
from .errors import Error, InvalidInput, Refused, WrongType
from .poses import Pose, message_of
from .session import Session
from .studies import Sweep, property_of
from .view import web_folder

_KINDS = ("hand", "object", "contacts", "motion")


@contextlib.contextmanager
def _options_as_arguments() -> Iterator[None]:
    """Advice names the command's options."""
    try:
        yield
    except Error as error:
        error.args = (re.sub(r"--(units|picture|colors) (\w+)", r"\1='\2'", str(error)),)
        raise


class Server:
    """A handgraft-server: its models, and sessions on it. Made by `connect`."""

    def __init__(self, client: _handgraft.Client):
        self._client = client
        self._page: _handgraft.Page | None = None

    def __repr__(self) -> str:
        status = self.status
        return f"Server({status['version']} on {status['host']}, {status['session_count']} sessions)"

    @property
    def status(self) -> dict[str, Any]:
        """What the server last told of itself: version, host, uptime_s, session_count, ..."""
        return self._client.status()

    @property
    def is_private(self) -> bool:
        """True for a server that `connect` started."""
        return self._client.is_private

    def _address(self) -> str:
        """Of the page of this server's sessions, which is served from the first time on."""
        if self._page is None:
            self._page = _handgraft.Page(self._client, web_folder())
        return self._page.address

    # === Models

    def models(self, kind: str | None = None) -> list[str]:
        """Names of the models of a kind (hand, object, contacts, motion), or of all."""
        if kind is not None:
            self._kind(kind)
        return [model["name"] for model in self._client.list_models()["models"]
                if kind is None or model["kind"] == kind]

    @staticmethod
    def _kind(kind: str) -> str:
        if kind not in _KINDS:
            raise InvalidInput(f"kind {kind!r}: permitted are {', '.join(_KINDS)}")
        return kind

    def describe(self, kind: str, name: str, meshes: bool = False) -> dict[str, Any]:
        """A model as the contract describes it: joints, links, sites; vertices; patches."""
        return self._client.describe(self._kind(kind), text_of("name", name), bool(meshes))[kind]

    def load_hand(self, urdf: str | os.PathLike[str], name: str = "", *, units: str = "",
                  packages: Mapping[str, str | os.PathLike[str]] | None = None,
                  mirrored: bool = False, rest_pose: str = "") -> str:
        """Sends a URDF with its meshes; returns the model's name on the server.

        ``packages`` says where ``package://`` names lie. Without a ``name`` the file's is taken, and told
        apart by its content where another model has it.
        """
        if packages is not None and not isinstance(packages, Mapping):
            raise WrongType(f"packages {packages!r}: it must map names of packages to folders")
        folders = {text_of("packages", package): path_of(f"packages[{package!r}]", folder)
                   for package, folder in (packages or {}).items()}
        options = {"mirrored": mirrored, "rest_pose": rest_pose}
        with _options_as_arguments():
            return self._client.load_hand(path_of("urdf", urdf), text_of("name", name), text_of("units", units), folders,
                                          options)["name"]

    def load_object(self, mesh: str | os.PathLike[str], name: str = "", *, units: str = "") -> str:
        """Sends a mesh; returns the model's name. ``units``: m, cm, mm or in; metres by default."""
        with _options_as_arguments():
            return self._client.load_object(path_of("mesh", mesh), text_of("name", name), text_of("units", units))["name"]

    def load_contacts(self, path: str | os.PathLike[str], object: str, name: str = "", *, units: str = "",
                      **options: Any) -> str:
        """Sends a contact set (JSON) or a contact map (PLY, OBJ, glTF and the like) on an object; returns its name.

        ``options`` say how patches are found in a map, as ``handgraft contacts import --help`` has them: ``value``,
        ``label``: properties of the map; ``colors``: which scale of colours shows values, grey, hot, inferno, jet or
        viridis; ``picture``: the path of a PNG with those colours, for a map with texture coordinates; ``joints``:
        that of the 21 joints of the hand that touched, ``joints_hand``: which one of the file's; ``threshold``,
        ``otsu``, ``low_share``, ``outline``, ``smooth``; ``min_area``: m^2; ``points``: on each outline.
        """
        files, reading = map_options(options)
        with _options_as_arguments():
            return self._client.load_contacts(path_of("path", path), text_of("object", object), text_of("name", name),
                                              text_of("units", units), files["picture"], files["joints"],
                                              reading)["name"]

    def load_motion(self, path: str | os.PathLike[str], object: str | os.PathLike[str] = "", name: str = "", *,
                    object_path: str | os.PathLike[str] | None = None, hand: str | os.PathLike[str] = "") -> str:
        """Sends a motion (``handgraft-motion/1``), a recording of contacts or a demonstration; returns its name.

        ``object``: that it is of; by default the one that the file names. ``object_path``: the splines (``.smexp``) of
        the object's way, where a recording of contact points lacks it. ``hand``: whose joints the file tells, as a
        motion is exported to json or csv: what that hand touched is the motion.
        """
        object = self.load_object(object) if object and is_path(object, "object") else object
        if object_path is None and not hand:
            return self._client.load_motion(path_of("path", path), object, text_of("name", name))["name"]
        if object_path is not None and hand:
            raise TypeError("object_path is of a recording, hand of what a hand did: one of them alone")
        name = name or pathlib.Path(path).stem
        if not hand:
            return self._load_made(name, object, motion_plans.of_recording(name, path, object_path))
        hand = self.load_hand(hand) if is_path(hand, "hand") else hand
        parts = motion_plans.of_trajectory(name, hand, path)
        return self._load_made(name, object or motion_plans.object_named_in(next(iter(parts[1].values()))), parts)

    def join_grasps(self, first: str | os.PathLike[str], last: str | os.PathLike[str], time_s: Sequence[float],
                    X_WO: Sequence[np.ndarray], name: str, *, object: str = "", **timing: float) -> str:
        """A motion from one grasp to another while the object goes along a path; returns its name.

        ``first`` and ``last`` are sets of contacts on one object, by name or path; what both have slides from one
        place to the other, the rest comes and goes. ``time_s`` and ``X_WO``: when the object is where. ``timing``:
        ``rate_hz``, ``slide_begin_share``, ``slide_end_share``, ``vanish_share``, ``appear_share``
        (handgraft-motion-plan/1, core/io/FORMATS.md).
        """
        sets: list[str] = []
        under: list[str] = []
        for option, contacts in (("first", first), ("last", last)):
            if is_path(contacts, option):
                sets.append(pathlib.Path(contacts).read_text())
                under.append(motion_plans.object_named_in(sets[-1]))
            else:
                described = self.describe("contacts", os.fspath(contacts))
                sets.append(described["file"])
                under.append(described["object"])
        if not object and all(under) and under[0] != under[1]:
            raise InvalidInput(f"contacts {first!r} lie on object {under[0]!r} and {last!r} on {under[1]!r}: a motion is "
                               "of one object")
        return self._load_made(name, object or under[0] or under[1],
                               motion_plans.of_grasps(name, *sets, time_s, X_WO, timing))

    def motion_of_hand(self, hand: str | os.PathLike[str], object: str | os.PathLike[str], time_s: Sequence[float],
                       joints: np.ndarray, name: str, *, joint_names: Sequence[str] | None = None,
                       X_WH: Sequence[np.ndarray] | None = None, X_WO: Sequence[np.ndarray] | None = None,
                       reach_m: float | None = None, every_s: float | None = None) -> str:
        """What a hand did, as a motion for other hands: where it touched the object over time. Returns its name.

        ``joints``: T x J, of ``joint_names``, by default all of the hand's in its order. ``X_WH``: T poses of its root,
        by default the identity or what the joints of a floating base say; ``X_WO``: of the object. ``reach_m``: at
        which contact ends; ``every_s``: how often contacts are cut.
        """
        hand = self.load_hand(hand) if is_path(hand, "hand") else hand
        object = self.load_object(object) if is_path(object, "object") else object
        names = list(joint_names) if joint_names is not None else self._joints_of(hand)
        parts = motion_plans.of_hand(name, hand, names, time_s, joints, X_WH, X_WO, reach_m=reach_m, every_s=every_s)
        return self._load_made(name, object, parts)

    def contacts_of_pose(self, hand: str | os.PathLike[str], object: str | os.PathLike[str],
                         joints: Mapping[str, float] | Sequence[float] | None = None, *, X_WH: np.ndarray | None = None,
                         X_WO: np.ndarray | None = None, pose: str = "", reach: float = 0.0, name: str = "") -> str:
        """Where a posed hand touches an object, as a set of contacts; returns its name.

        ``joints``: positions, rad or m, by name, of those that differ from the hand's named ``pose``, by default its
        rest pose; or of all, in its order. ``X_WH``, ``X_WO``: the hand's root and the object in the world.
        ``reach``: m, at which contact ends; 0: 0.01.
        """
        hand = self.load_hand(hand) if is_path(hand, "hand") else hand
        object = self.load_object(object) if is_path(object, "object") else object
        given = {} if joints is None else joints
        if not isinstance(given, Mapping):
            names = self._joints_of(hand)
            if len(given) != len(names):
                raise InvalidInput(f"joints: {len(given)} numbers; hand {hand!r} has {len(names)} joints")
            given = dict(zip(names, given))
        request = {"name": name or f"{object}_{hand}", "hand": hand, "object": object, "start_pose": pose,
                   "joints": list(given), "joint_positions": list(given.values()), "reach_m": reach,
                   "X_WH": None if X_WH is None else message_of(X_WH),
                   "X_WO": None if X_WO is None else message_of(X_WO)}
        try:
            return self._made("pose_contacts", request)
        except Refused as refusal:
            if refusal.code != "conflict" or name:
                raise
        # Another pose has left its contacts under the name of hand and object.
        hash_of_all = hashlib.sha256(repr(request).encode()).hexdigest()[:8]
        return self._made("pose_contacts", {**request, "name": f"{request['name'][:55]}-{hash_of_all}"})

    def _joints_of(self, hand: str) -> list[str]:
        return [joint["name"] for joint in self.describe("hand", hand)["joints"]]

    def _load_made(self, name: str, object: str, parts: motion_plans.Parts) -> str:
        plan, texts = parts
        return self._client.load_planned_motion(name, object, json.dumps(plan), texts)["name"]

    def _made(self, member: str, request: dict[str, Any], kind: str = "") -> str:
        """The name of a model that the server makes."""
        return self._client.ask({"kind": kind or member, member: request})["models"]["models"][0]["name"]

    def unload(self, kind: str, name: str) -> None:
        """Takes a model (hand, object, contacts, motion) away; sessions that have it keep it."""
        self._client.unload(self._kind(kind), text_of("name", name))

    # === Hands that are not built yet

    def vary(self, hand: str | os.PathLike[str], name: str, changes: Mapping[str, float]) -> str:
        """A hand like another one but for some changes, in order; returns its name.

        ``{"thumb_mcp.upper": 1.2, "index_2.length": 1.1, "hand.size": 0.9}``: limits of joints in rad or m (``lower``,
        ``upper``), factors of their range, of a link's length or size, or of the whole hand's.
        """
        hand = self.load_hand(hand) if is_path(hand, "hand") else hand
        request = {"hand": hand, "name": name,
                   "changes": [{**property_of(one), "value": value} for one, value in changes.items()]}
        return self._made("variant", request, "make_variant")

    def sweep(self, hand: str | os.PathLike[str], vary: Mapping[str, Sequence[float]],
              grasps: Sequence[tuple[str, str]] = (), *, motions: Sequence[str] = (), starts: int = 0,
              seed: int = 0) -> Sweep:
        """Solves every grasp, (object, contacts), and motion with every combination of values.

        Each model is a name on the server, or the path of a file to send. Limits are in rad or m.

            server.sweep("tendon16", {"thumb_mcp.upper": np.linspace(0.3, 1.2, 10)}, [("lemon", "lemon_3")])
        """
        hand = self.load_hand(hand) if is_path(hand, "hand") else hand
        if not isinstance(vary, Mapping):
            raise TypeError("vary: must map properties to values: {'hand.size': [0.9, 1.0, 1.1]}")
        axes = {name: np.atleast_1d(np.asarray(values, dtype=float)) for name, values in vary.items()}
        for name, values in axes.items():
            if not np.all(np.isfinite(values)):
                raise InvalidInput(f"{name}: a value is not finite")
            if property_of(name)["property"] in ("lower", "upper") and np.abs(values).max(initial=0.0) > 2 * np.pi:
                warnings.warn(f"{name}: {values[np.abs(values).argmax()]:g} rad; limits are in rad or m, not degrees",
                              stacklevel=2)
        asked: list[dict[str, str]] = []
        for grasp in grasps:
            if isinstance(grasp, str) or len(grasp) != 2:
                raise TypeError(f"grasps: {grasp!r}; each must be (object, contacts)")
            sent = self._send(hand, *grasp, "")
            asked.append({"object": sent["object"], "contacts": sent["contacts"]})
        motions = [motions] if isinstance(motions, str) else list(motions)
        for k, motion in enumerate(motions):
            motions[k] = self.load_motion(motion) if is_path(motion, "motion") else motion
            asked.append({"object": self.describe("motion", motions[k])["object"], "motion": motions[k]})
        request = {"hand": hand, "grasps": asked,
                   "axes": [{**property_of(name), "values": values} for name, values in axes.items()],
                   "options": {"starts": starts, "seed": seed}}
        reply = self._client.ask({"kind": "sweep", "sweep": request})["sweep"]
        return Sweep(reply, axes, [one.get("contacts") or one["motion"] for one in asked])

    # === Grasps and motions

    def open(self, hand: str | os.PathLike[str], object: str | os.PathLike[str] = "",
             contacts: str | os.PathLike[str] = "", *, motion: str | os.PathLike[str] = "",
             X_WO: np.ndarray | None = None, weights: Sequence[float] | None = None, units: str = "",
             mirrored: bool = False, **reading: Any) -> Session:
        """A live session. Each model is a name on the server, or the path of a file to send.

        Of ``contacts`` on an object, or of a ``motion``, whose own object is taken if none is named. ``weights``:
        of distance (1/m^2), normals and prior. ``X_WO``: the object's pose, 4x4. ``units`` are those of the
        object's and the contacts' files: m, cm, mm or in; metres by default. ``mirrored``: the other hand of the
        URDF that is sent, a left one of a right one. ``reading``: how a contact map that is
        sent is read, as `load_contacts` has it (``picture``, ``colors``, ``threshold``, ...).
        """
        if bool(contacts) == bool(motion):
            both = "not both" if contacts else "and there is neither"
            raise InvalidInput(f"a session is of contacts or of a motion: one of them has to be given, {both}")
        request: dict[str, Any] = self._send(hand, object, contacts, units, mirrored, **reading)
        if motion:
            motion = self.load_motion(motion, request["object"]) if is_path(motion, "motion") else motion
            request["motion"] = motion
            request["object"] = request["object"] or self.describe("motion", motion)["object"]
        if X_WO is not None:
            request["X_WO"] = message_of(X_WO)
        if weights is not None:
            if not isinstance(weights, (Sequence, np.ndarray)) or isinstance(weights, str):
                raise WrongType(f"weights {weights!r}: they are three numbers, of distance, normals and prior")
            if len(weights) != 3:
                raise InvalidInput(f"weights: {len(weights)} numbers; they are of distance, normals and prior")
            request["weights"] = dict(zip(("distance", "normal", "prior"), weights))
        return Session(self._client.open_session(request), self)

    def join(self, session_id: int) -> Session:
        """A session that somebody else opened."""
        return Session(self._client.join_session(count_of("session_id", session_id, 0, 2**64 - 1)), self)

    def load_session(self, text: str) -> Session:
        """A session of what `Session.save` gave."""
        return Session(self._client.load_session(text_of("text", text)), self)

    def sessions(self) -> list[int]:
        """Numbers of the sessions that are open."""
        return [session["session_id"] for session in self._client.list_sessions()["sessions"]]

    def grasp(self, hand: str | os.PathLike[str], object: str | os.PathLike[str],
              contacts: str | os.PathLike[str], *, X_WO: np.ndarray | None = None,
              weights: Sequence[float] | None = None, units: str = "", mirrored: bool = False,
              **options: Any) -> Pose:
        """Lays the contacts onto the hand and solves its pose; arguments as for `open` and `Session.solve`."""
        reading = {name: value for name, value in options.items() if is_of_map(name)}
        solving = {name: value for name, value in options.items() if name not in reading}
        with self.open(hand, object, contacts, X_WO=X_WO, weights=weights, units=units, mirrored=mirrored,
                       **reading) as session:
            return session.solve(**solving)

    def _send(self, hand: Any, object: Any, contacts: Any, units: str, mirrored: bool = False,
              **reading: Any) -> dict[str, str]:
        """Their names on the server; of what is empty, empty."""
        is_file = {option: model != "" and is_path(model, option)
                   for option, model in (("hand", hand), ("object", object), ("contacts", contacts))}
        if reading and not is_file["contacts"]:
            name, value = next(iter(reading.items()))
            raise InvalidInput(f"{name} {value!r}: contacts {contacts!r} have been read already; it is for files")
        if units and not (is_file["object"] or is_file["contacts"]):
            raise InvalidInput(f"units {units!r}: neither object nor contacts is a file")
        if mirrored and not is_file["hand"]:
            raise InvalidInput(f"mirrored: hand {hand!r} has been read already; it is for files")
        hand = self.load_hand(hand, mirrored=mirrored) if is_file["hand"] else hand
        object = self.load_object(object, units=units) if is_file["object"] else object
        contacts = self.load_contacts(contacts, object, units=units, **reading) if is_file["contacts"] else contacts
        return {"hand": hand, "object": object, "contacts": contacts}
