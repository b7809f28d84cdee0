"""Grasps from a human hand to any robot hand.

    import handgraft

    server = handgraft.connect()
    pose = server.grasp("human20", "lemon", "lemon_6")
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

import os
from collections.abc import Sequence

from . import _handgraft
from .arguments import count_of, path_of, text_of
from .errors import Cancelled, Error, InvalidInput, NoServer, NotBegun, Refused, SolveFailed, TransportError, WrongType
from .motions import Demonstrator, Motion, PatchOverTime
from .poses import Depth, Patch, Pose
from .reports import Difference, Suggestion
from .server import Server
from .session import Session
from .studies import Sweep
from .view import View

__all__ = [
    "connect", "Server", "Session", "Pose", "Patch", "Depth", "Motion", "PatchOverTime", "Demonstrator", "Sweep",
    "Suggestion", "Difference", "View",
    "Error", "InvalidInput", "WrongType", "Refused", "NotBegun", "NoServer", "SolveFailed", "Cancelled",
    "TransportError",
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
    ends with this program; unless ``start`` is false: then NoServer is raised after 2 s. Other programs
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
    if isinstance(peers, str) or not isinstance(peers, Sequence):
        raise WrongType(f"peers {peers!r}: they are a list of hosts")
    domain = count_of("domain", domain, 0, 100)
    peers = [text_of("peers", peer) for peer in peers]
    try:
        client = _handgraft.Client(domain, text_of("interface", interface), bool(start), peers,
                                   text_of("server", server), path_of("identity", identity))
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
