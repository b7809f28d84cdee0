"""One session on a server: the poses that answer its edits, and what can be asked about it."""

from __future__ import annotations

import contextlib
import pathlib
import time
import warnings
from typing import TYPE_CHECKING, Any, Iterator, Sequence

import numpy as np

from . import _handgraft
from .arguments import number_of
from .edits import Edits
from .errors import Cancelled, Error, InvalidInput, NoServer, Refused, SolveFailed
from .motions import Demonstrator, Motion
from .poses import Pose
from .view import View, web_folder

if TYPE_CHECKING:
    from .server import Server


class Session(Edits):
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
        self._when: dict[str, float] | None = None

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *_: Any) -> None:
        try:
            self.close()
        except (Refused, NoServer):
            pass  # it is closed already, or its server is gone

    def __repr__(self) -> str:
        state = self._session.state()
        return f"Session({self.id}: {state['hand']} on {state['object']}, revision {state['revision']}, {state['phase']})"

    @property
    def id(self) -> int:
        """Its number, for other clients."""
        return self._session.id

    @property
    def joint_names(self) -> list[str]:
        """In the order of `Pose.joints`."""
        self._joints = list(self._heard()["joint_names"])  # an edit may have changed the hand
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
            if self._session.state()["motion"]:
                raise Error(f"session {self.id} holds a motion: motion() tells its frames")
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

    # === Motions, of a session that was opened with one

    def solve_motion(self, *, causal: bool = False, smoothness: float = 0.0, fade_s: float = 0.0,
                     acceleration_limit: float = 0.0, starts: int = 0, seed: int = 0) -> Motion:
        """Has the hand follow the session's motion and waits for it. 0: the server's default.

        All frames at once; with ``causal`` each from those before it (`follow` also searches anew where the hand is
        lost). ``smoothness``: what a second difference of a joint counts (rad^-2 at 120 frames a second). ``fade_s``: s,
        in which patches come and go. ``acceleration_limit``: rad/s^2 or m/s^2, of every joint. From now on edits are
        followed by frames.
        """
        options = {"causal": bool(causal), "smoothness": smoothness, "fade_s": fade_s,
                   "acceleration_limit": acceleration_limit, "solving": {"starts": starts, "seed": seed}}
        summary = self._ask("solve_motion", {"session_id": self.id, "options": options}, "motion")
        return self._frames(summary)

    def motion(self) -> Motion:
        """The frames that answer the last edit of this program; waits for them. Edits of a motion that has been
        solved are followed by frames as those of a grasp by poses."""
        state = self._rested()
        if not state["motion"]:
            raise Error(f"session {self.id} holds no motion: pose() tells its hand")
        if state["phase"] == "closed":
            raise Error(f"session {self.id} has been closed")
        if state["phase"] == "failed":
            raise SolveFailed(state["message"])
        if state["phase"] == "open":
            raise Error(f"session {self.id} has no frames: solve_motion makes them")
        motion = self._frames(None)
        if motion.revision < self._revision and state["message"] in ("stopped", "cancelled"):
            raise Cancelled(f"the solve after edit {self._revision} was {state['message']}; the frames there are answer "
                            f"edit {motion.revision}")
        return motion

    def _rested(self) -> dict[str, Any]:
        """The session's state once nothing is at work for the last edit of this program."""
        try:
            while True:
                state = self._heard()
                if state["phase"] not in ("transferring", "optimizing"):
                    return state
                if not self._server._client.alive():
                    raise NoServer("the server stopped answering")
                time.sleep(0.005)
        except KeyboardInterrupt:
            self.stop()
            raise

    @contextlib.contextmanager
    def at(self, time_s: float, falloff_s: float = 0.0) -> Iterator[Session]:
        """Edits within are of the motion at a time alone, fading to nothing ``falloff_s`` away from it; 0: of that
        frame alone.

            with session.at(1.2, falloff_s=0.3):
                session.turn("thumb", 0.2)

        It holds for whoever edits by this object meanwhile: threads take one each (`Server.join`).
        """
        before = self._when
        self._when = {"time_s": number_of("time_s", time_s), "falloff_s": number_of("falloff_s", falloff_s)}
        try:
            yield self
        finally:
            self._when = before

    def follow(self, chirality: str = "right") -> Demonstrator:
        """A demonstrator whose frames the session's hand follows live; ``chirality``: of their hand, left or right."""
        if chirality not in ("left", "right"):
            raise InvalidInput(f"chirality {chirality!r}: permitted are left, right")
        return Demonstrator(self, chirality)

    def _ask(self, kind: str, request: dict[str, Any], answer: str) -> dict[str, Any]:
        return self._server._client.ask({"kind": kind, kind: request})[answer]

    def _frames(self, summary: dict[str, Any] | None) -> Motion:
        state = self._session.state()
        frames: list[dict[str, Any]] = []
        while True:
            reply = self._ask("motion_frames", {"session_id": self.id, "first": len(frames)}, "motion_frames")
            frames += reply["frames"]
            if reply["is_last"] or not reply["frames"]:
                break
        patches = self._server.describe("motion", state["motion"])["patches"]
        return Motion(frames, state["joint_names"], patches, summary, reply["revision"])

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

    def export(self, format: str, path: str | os.PathLike[str] | None = None, *, live: bool = False) -> bytes:
        """The last pose for other programs, or the last frames of a motion; written to ``path``, too.

        A pose as json, csv, obj, glb, isaac_grasp, problem, npz, mjcf or ros_trajectory; a motion as all of these but
        obj, isaac_grasp and problem (core/io/FORMATS.md). What the file cannot say is a warning. With ``live``: what
        the hand did last after a demonstrator (``Demonstrator``), in a motion's formats.
        """
        content, notes = self._session.export({"format": format, "live": live})
        for note in notes:
            warnings.warn(f"{format}: {note}", stacklevel=2)
        if path is not None:
            pathlib.Path(path).write_bytes(content)
        return content

    def save(self) -> str:
        """All of it as ``handgraft-session/1``: state, history, snapshots, log."""
        return self._session.save()

    def close(self) -> None:
        """Ends the session, for all who use it."""
        self._session.close()
