"""Grasps from a human hand to any robot hand.

    import handgraft

    server = handgraft.connect()
    pose = server.grasp("barrett8", "lemon", "lemon_3")
    print(pose.verdict, pose.joints)

    with server.open("barrett8", "lemon", "lemon_3") as session:
        session.solve()
        session.lock("thumb_distal_flex")
        print(session.pose().joints)

SI units and radians; +z up. A pose is a 4x4 array: ``X_WH`` takes points of the hand's frame H to the
world W. Errors are exceptions with the server's words (handgraft.errors). Ctrl-C ends a wait, after
the work on the server has been stopped.
"""

from __future__ import annotations

import contextlib
import os
import pathlib
import re
import warnings
from typing import Any, Iterator, Mapping, Sequence

import numpy as np

from . import _handgraft
from .errors import Cancelled, Error, InvalidInput, NoServer, Refused, SolveFailed, TransportError
from .poses import Depth, Patch, Pose, matrix_of, message_of
from .view import View, web_folder

__all__ = [
    "connect", "Server", "Session", "Pose", "Patch", "Depth", "View", "Error", "InvalidInput", "Refused", "NoServer",
    "SolveFailed", "Cancelled", "TransportError",
]


def connect(domain: int | None = None, interface: str | None = None, start: bool = True, *,
            peers: Sequence[str] | None = None, server: str | None = None,
            identity: str | os.PathLike[str] | None = None) -> Server:
    """The server on a DDS domain (0-100, usually 0) and network interface (usually ``lo``).

    ``peers`` are hosts to look for it on where multicast is dropped, ``server`` is its name where a domain
    has several. ``identity`` is the folder of an identity that ``handgraft keys add`` made, for a secured
    domain; there no server is started. What is None is taken from the environment, as every program of
    Handgraft takes it: HANDGRAFT_DOMAIN, HANDGRAFT_INTERFACE, HANDGRAFT_PEERS (parted by commas),
    HANDGRAFT_SERVER, HANDGRAFT_IDENTITY; a bad value there is InvalidInput that names the variable.

    Where none answers within 0.5 s (2 s on other interfaces than ``lo``), one is started that
    ends with this program, unless ``start`` is false; then NoServer is raised. Other programs
    meet that server, too, and lose it with this one: several at once each give a ``server`` of
    their own, or one ``handgraft-server`` is started before them.
    """
    from_environment = [name for name, value in (("domain", domain), ("interface", interface), ("peers", peers),
                                                 ("server", server), ("identity", identity)) if value is None]
    if domain is None:
        domain = _domain_of_environment()
    if interface is None:
        interface = _environment("interface") or "lo"
    if peers is None:
        peers = [peer for peer in _environment("peers").split(",") if peer]
    if server is None:
        server = _environment("server")
    if identity is None:
        identity = _environment("identity")
    try:
        client = _handgraft.Client(domain, interface, start, list(peers), server, os.fspath(identity))
    except InvalidInput as error:
        name = str(error).partition(":")[0]  # "interface: 'eth7' is not ..."
        if name in from_environment and _environment(name):
            raise InvalidInput(f"{_variable(name)}: {error}") from None
        raise
    return Server(client)


def _variable(option: str) -> str:
    return f"HANDGRAFT_{option.upper()}"


def _environment(option: str) -> str:
    return os.environ.get(_variable(option), "")


def _domain_of_environment() -> int:
    text = _environment("domain")
    if not text:
        return 0
    if not (text.isascii() and text.isdigit() and int(text) <= 100):
        raise InvalidInput(f"{_variable('domain')}: {text!r} is no domain; permitted are 0 to 100")
    return int(text)


class Server:
    """A handgraft-server: its models, and sessions on it. Made by `connect`."""

    def __init__(self, client: _handgraft.Client):
        self._client = client
        self._page: _handgraft.Page | None = None

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
        if kind is not None and kind not in _KINDS:
            raise InvalidInput(f"kind {kind!r}: permitted are {', '.join(_KINDS)}")
        return [model["name"] for model in self._client.list_models()["models"]
                if kind is None or model["kind"] == kind]

    def describe(self, kind: str, name: str, meshes: bool = False) -> dict[str, Any]:
        """A model as the contract describes it: joints, links, sites; vertices; patches."""
        return self._client.describe(kind, name, meshes)[kind]

    def load_hand(self, urdf: str | os.PathLike[str], name: str = "", *, units: str = "",
                  packages: Mapping[str, str | os.PathLike[str]] | None = None,
                  mirrored: bool = False, rest_pose: str = "") -> str:
        """Sends a URDF with its meshes; returns the model's name on the server.

        ``packages`` says where ``package://`` names lie. Without a ``name`` the file's is taken, and told
        apart by its content where another model has it.
        """
        folders = {package: os.fspath(folder) for package, folder in (packages or {}).items()}
        options = {"mirrored": mirrored, "rest_pose": rest_pose}
        with _units_as_arguments():
            return self._client.load_hand(os.fspath(urdf), name, units, folders, options)["name"]

    def load_object(self, mesh: str | os.PathLike[str], name: str = "", *, units: str = "") -> str:
        """Sends a mesh; returns the model's name. ``units``: m, cm, mm or in; metres by default."""
        with _units_as_arguments():
            return self._client.load_object(os.fspath(mesh), name, units)["name"]

    def load_contacts(self, path: str | os.PathLike[str], object: str, name: str = "", *, units: str = "",
                      **options: Any) -> str:
        """Sends a contact set (JSON) or a contact map (PLY) on an object; returns its name.

        ``options`` say how patches are found in a map: ContactOptions of idl/models.idl.
        """
        with _units_as_arguments():
            return self._client.load_contacts(os.fspath(path), object, name, units, options)["name"]

    # === Grasps

    def open(self, hand: str | os.PathLike[str], object: str | os.PathLike[str],
             contacts: str | os.PathLike[str], *, X_WO: np.ndarray | None = None,
             weights: Sequence[float] | None = None, units: str = "") -> Session:
        """A live session. Each model is a name on the server, or the path of a file to send.

        ``weights``: of distance (1/m^2), normals and prior. ``X_WO``: the object's pose, 4x4. ``units``
        are those of the object's and the contacts' files: m, cm, mm or in; metres by default.
        """
        request = dict(zip(("hand", "object", "contacts"), self._send(hand, object, contacts, units)))
        if X_WO is not None:
            request["X_WO"] = message_of(X_WO)
        if weights is not None:
            request["weights"] = dict(zip(("distance", "normal", "prior"), weights))
        return Session(self._client.open_session(request), self)

    def join(self, session_id: int) -> Session:
        """A session that somebody else opened."""
        return Session(self._client.join_session(session_id), self)

    def load_session(self, text: str) -> Session:
        """A session of what `Session.save` gave."""
        return Session(self._client.load_session(text), self)

    def sessions(self) -> list[int]:
        """Numbers of the sessions that are open."""
        return [session["session_id"] for session in self._client.list_sessions()["sessions"]]

    def grasp(self, hand: str | os.PathLike[str], object: str | os.PathLike[str],
              contacts: str | os.PathLike[str], *, X_WO: np.ndarray | None = None,
              weights: Sequence[float] | None = None, units: str = "", **solving: Any) -> Pose:
        """Lays the contacts onto the hand and solves its pose; arguments as for `open` and `Session.solve`."""
        with self.open(hand, object, contacts, X_WO=X_WO, weights=weights, units=units) as session:
            return session.solve(**solving)

    def _send(self, hand: Any, object: Any, contacts: Any, units: str) -> tuple[str, str, str]:
        is_file = {option: _is_path(model, option)
                   for option, model in (("hand", hand), ("object", object), ("contacts", contacts))}
        if units and not (is_file["object"] or is_file["contacts"]):
            raise InvalidInput(f"units {units!r}: neither object nor contacts is a file")
        hand = self.load_hand(hand) if is_file["hand"] else hand
        object = self.load_object(object, units=units) if is_file["object"] else object
        contacts = self.load_contacts(contacts, object, units=units) if is_file["contacts"] else contacts
        return hand, object, contacts


class Session:
    """A grasp under way on the server: edits, and the poses that answer them.

    Made by `Server.open`. As a context manager it is closed at the end; without, it stays open until
    `close` or until nobody has used it for long.
    """

    def __init__(self, session: _handgraft.Session, server: Server):
        self._session = session
        self._server = server
        state = session.state()
        self._joints: list[str] = list(state["joint_names"])
        self._revision: int = state["revision"]

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *_: Any) -> None:
        try:
            self.close()
        except (Refused, NoServer):
            pass  # it is closed already, or its server is gone

    @property
    def id(self) -> int:
        """Its number, for other clients."""
        return self._session.id

    @property
    def joint_names(self) -> list[str]:
        """In the order of `Pose.joints`."""
        return list(self._joints)

    @property
    def revision(self) -> int:
        """Counts the edits; of this program's last one, or as the session was opened."""
        return self._revision

    def state(self) -> dict[str, Any]:
        """As last heard: phase, revision, message, models, undo_count, ..."""
        return self._session.state()

    def settings(self) -> dict[str, Any]:
        """All that can be edited, as it stands: patches, joints, weights, prior."""
        return self._session.settings()

    def transfer(self) -> dict[str, Any]:
        """How each patch lies on the hand: points, lost ones with the reason, fidelity."""
        return self._session.transfer()

    # === Poses

    def solve(self, *, solver: str | None = None, starts: int = 0, seed: int = 0,
              max_evaluations: int = 0, touch_only: bool = False) -> Pose:
        """Solves the pose and waits for it, diagnosed. 0 and None: the session's or the default.

        A hand keeps out of the object, and of itself; with ``touch_only`` depth costs nothing, as in the paper.
        """
        options: dict[str, Any] | None = None
        if solver or starts or seed or max_evaluations or touch_only:
            options = {"starts": starts, "seed": seed, "max_evaluations": max_evaluations,
                       "penetration": "reported" if touch_only else "avoided"}
            if solver:
                options["solver"] = solver
        return Pose(self._session.solve(options), self._joints)

    def pose(self, diagnosed: bool = True) -> Pose:
        """The pose that answers the last edit of this program; waits for it.

        Without ``diagnosed`` it comes at once, verdicts may be missing. Raises SolveFailed if it could not
        be solved, Error if none follows because nothing has been solved yet.
        """
        solution = self._session.await_final(self._revision)
        if solution is None:
            raise Error(f"session {self.id} has no pose at revision {self._revision}: solve it first")
        if diagnosed and not solution["is_diagnosed"]:
            solution = self._session.await_diagnosed(self._revision)
        self._joints = list(self._session.state()["joint_names"])  # an edit may have changed the hand
        return Pose(solution, self._joints)

    def watch(self, final: bool = True) -> Iterator[Pose]:
        """The session's poses as they come, whoever edits, until it is closed.

        With ``final`` those that answer an edit, first undiagnosed and then diagnosed; without, also
        what the solver passes on the way. Who comes late sees the last one at once.
        """
        stream = self._session.watch()
        joints = self._joints
        while True:
            event = stream.next(1.0)
            if event is None:
                continue
            kind, message = event
            if kind == "solution" and (message["is_final"] or not final):
                yield Pose(message, joints)
            elif kind == "state":
                if message["phase"] == "closed":
                    return
                joints = list(message["joint_names"])

    def stop(self) -> None:
        """Stops the solve under way, whoever asked for it."""
        self._session.stop_solving()

    # === Edits; each is answered by a fresh pose: `pose()` waits for it

    def edit(self, kind: str, member: str | None = None, value: Any = None) -> str:
        """Any edit of idl/edits.idl: its kind, the member that it chooses, and that as a dict.

        Returns what the server has to say of it, mostly nothing.
        """
        body = {"kind": kind} if member is None else {"kind": kind, member: value}
        reply = self._session.edit(body, 0)
        self._revision = reply["revision"]
        return reply["message"]

    def lock(self, joint: str, locked: bool = True) -> None:
        """Holds a joint where it is, or lets it go."""
        self.edit("joint_lock", "joint_lock", {"joint": joint, "locked": locked})

    def limit(self, joint: str, lower: float, upper: float) -> None:
        """A joint's range, rad or m; warns where angles seem to be degrees, or metres millimetres."""
        said = self.edit("joint_limit", "joint_limit", {"joint": joint, "lower": lower, "upper": upper})
        if said:
            warnings.warn(said, stacklevel=2)

    def hold(self, joint: str, value: float, weight: float = 1.0) -> None:
        """Holds a joint near a value by so many times the prior's weight; 0 lets it go."""
        self.edit("joint_soft", "joint_soft", {"joint": joint, "value": value, "weight": weight})

    def weigh(self, patch: str, weight: float) -> None:
        """What a patch counts; 0 switches it off."""
        self.edit("patch_weight", "patch_weight", {"patch": patch, "weight": weight})

    def enable(self, patch: str, enabled: bool = True) -> None:
        """Has a patch count, or not."""
        self.edit("patch_enabled", "patch_enabled", {"patch": patch, "enabled": enabled})

    def turn(self, patch: str, angle: float, side: str = "hand") -> None:
        """Turns a patch about the outward normal, counter-clockwise, on the hand or the object."""
        self.edit("patch_direction", "patch_direction", {"patch": patch, "side": side, "angle_rad": angle})

    def place(self, X_WO: np.ndarray) -> None:
        """Moves the object: its pose in the world, 4x4."""
        self.edit("object_pose", "X_WO", message_of(X_WO))

    def weights(self, distance: float, normal: float, prior: float) -> None:
        """What distances (1/m^2), normals and the prior count."""
        self.edit("weights", "weights", {"distance": distance, "normal": normal, "prior": prior})

    def drag(self, link: str, p_L: Sequence[float], target_W: Sequence[float]) -> None:
        """Moves a point of a link (m, in the link's frame) to a place in the world."""
        self.edit("drag", "drag", {"link": link, "p_L_m": p_L, "target_W_m": target_W})

    def choose(self, rank: int) -> None:
        """Takes one of the places where searches ended, as `Pose.minima` ranks them; 0 is the best."""
        self.edit("choice", "choice", {"rank": rank})

    def undo(self, count: int = 1) -> None:
        """Takes back edits."""
        self.edit("undo", "steps", {"count": count})

    def redo(self, count: int = 1) -> None:
        """Brings back edits that were taken back."""
        self.edit("redo", "steps", {"count": count})

    # === Looking

    def view(self, live: bool = True, *, width: int | str = "100%", height: int | str = 600) -> View:
        """The session as a page, which notebooks show in a frame: looked at and edited by mouse, touch and keys.

        It is served on this machine for as long as the `Server` lives. With ``live=False`` it is the pose as it is
        now, as one file without a server: kept in a notebook that is saved, seen on other machines, and where frames
        of other addresses are not shown. Raises InvalidInput where the page was not built.
        """
        state = self._session.state()
        title = f"{state['hand']} grasps {state['object']}"
        if not live:
            text = self._server._client.page_file(self.id, web_folder())
            return View(None, text, title, width, height)
        return View(f"{self._server._address()}?session={self.id}", None, title, width, height)

    # === Files

    def export(self, format: str, path: str | os.PathLike[str] | None = None) -> bytes:
        """The last pose for other programs: json, csv, obj, glb, isaac_grasp, ...; written to ``path``, too."""
        content = self._session.export({"format": format})
        if path is not None:
            pathlib.Path(path).write_bytes(content)
        return content

    def save(self) -> str:
        """All of it as ``handgraft-session/1``: state, history, snapshots, log."""
        return self._session.save()

    def close(self) -> None:
        """Ends the session, for all who use it."""
        self._session.close()


_KINDS = ("hand", "object", "contacts", "motion")


@contextlib.contextmanager
def _units_as_arguments() -> Iterator[None]:
    """The server's advice names the command's option."""
    try:
        yield
    except Error as error:
        error.args = (re.sub(r"--units (\w+)", r"units='\1'", str(error)),)
        raise


def _is_path(model: Any, option: str) -> bool:
    if isinstance(model, os.PathLike):
        return True
    if isinstance(model, os.PathLike):
        return True
    if not isinstance(model, str):
        raise TypeError(f"{option}: {model!r} is neither a model's name nor a file's path")
    return _handgraft.is_path(model)
