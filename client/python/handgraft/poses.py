"""What a solution says, as numpy arrays."""

from __future__ import annotations

from typing import Any, Mapping, Sequence

import numpy as np

from .errors import InvalidInput


def matrix_of(pose: Mapping[str, Any]) -> np.ndarray:
    """The 4x4 matrix of a message's position and quaternion (w x y z)."""
    w, x, y, z = np.asarray(pose["q_wxyz"]) / np.linalg.norm(pose["q_wxyz"])
    X = np.eye(4)
    X[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    X[:3, 3] = pose["p_m"]
    return X


def matrices_of(poses: Sequence[Mapping[str, Any]]) -> np.ndarray:
    """Of many, n x 4 x 4."""
    return np.array([matrix_of(pose) for pose in poses]).reshape(-1, 4, 4)


def in_order(values: Mapping[str, float], names: Sequence[str], what: str) -> list[float]:
    """Values by name as a list, in the order of all the names."""
    if strange := sorted(set(values) - set(names)):
        raise InvalidInput(f"{what}: there is no {strange[0]!r}; there are {', '.join(names)}")
    if missing := [name for name in names if name not in values]:
        raise InvalidInput(f"{what}: {missing[0]!r} is missing")
    return [float(values[name]) for name in names]


def message_of(X: np.ndarray) -> dict[str, Any]:
    """The message of a 4x4 matrix, whose rotation must be one within 1e-6."""
    try:
        X = np.asarray(X, dtype=float)
    except (TypeError, ValueError):
        raise InvalidInput(f"a pose is a 4x4 array of numbers, not {X!r}") from None
    R = X[:3, :3] if X.shape == (4, 4) else np.empty(0)
    if X.shape != (4, 4) or not np.allclose(R @ R.T, np.eye(3), atol=1e-6) or np.linalg.det(R) < 0:
        raise InvalidInput("a pose is a 4x4 array whose upper left 3x3 block is a rotation")
    # The largest of the four squared components is the one to divide by (Shepperd 1978).
    squares = np.array([np.trace(R), R[0, 0], R[1, 1], R[2, 2]])
    largest = int(np.argmax(squares))
    if largest == 0:
        q = np.array([1 + squares[0], R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    else:
        i = largest - 1
        j, k = (i + 1) % 3, (i + 2) % 3
        q = np.empty(4)
        q[0] = R[k, j] - R[j, k]
        q[1 + i] = 1 + R[i, i] - R[j, j] - R[k, k]
        q[1 + j] = R[j, i] + R[i, j]
        q[1 + k] = R[k, i] + R[i, k]
    return {"p_m": X[:3, 3], "q_wxyz": q / np.linalg.norm(q)}


class Patch:
    """How well one patch is reached."""

    def __init__(self, message: Mapping[str, Any]):
        self.message = message  #: the whole PatchFit of idl/sessions.idl
        self.name: str = message["name"]
        self.mean_mm: float = message["mean_mm"]
        self.rms_mm: float = message["rms_mm"]
        self.max_mm: float = message["max_mm"]
        self.normal_deg: float = message["normal_deg"]
        self.within_2mm: float = message["within_2mm"]
        self.within_5mm: float = message["within_5mm"]
        self.verdict: str = message["diagnosis"]["verdict"]
        self.text: str = message["diagnosis"]["text"]
        self.facing_deg: float = message["diagnosis"]["facing_deg"]  #: between both sides' mean normals

    @property
    def hand_W(self) -> np.ndarray:
        """Points on the posed hand, n x 3, m in the world."""
        return self.message["hand_W_m"].reshape(-1, 3)

    @property
    def object_W(self) -> np.ndarray:
        """Their partners on the object, n x 3, in the same order."""
        return self.message["object_W_m"].reshape(-1, 3)

    @property
    def residuals(self) -> np.ndarray:
        """Distances between the two, n, m."""
        return np.linalg.norm(self.hand_W - self.object_W, axis=1)

    def __repr__(self) -> str:
        return f"Patch({self.name!r}, {self.mean_mm:.2f} mm, {self.verdict})"


class Depth:
    """How deep a posed hand is in the object, and in itself."""

    def __init__(self, message: Mapping[str, Any]):
        self.message = message  #: the whole Penetration of idl/sessions.idl
        self.max_m: float = message["max_depth_m"]  #: of the deepest point in the object; 0: none is
        self.links: dict[str, float] = {one["link"]: one["depth_m"] for one in message["links"]}  #: m, deepest first
        self.link: str | None = next(iter(self.links), None)  #: the deepest; None: none is in the object, or it is not told (live)
        self.volume_m3: float = message["volume_m3"]  #: that hand and object share; of live hands 0
        self.self_m: float = message["self_depth_m"]  #: of one link in another; 0: none is
        self.self_links: tuple[str, ...] = tuple(message["self_links"])  #: those two, or none

    def __repr__(self) -> str:
        where = f" at {self.link}" if self.link else ""
        return f"Depth({1e3 * self.max_m:.1f} mm{where}, {1e3 * self.self_m:.1f} mm in itself)"


class Pose:
    """One pose of a hand that answers a session's edits."""

    def __init__(self, message: Mapping[str, Any], joint_names: Sequence[str]):
        self.message = message  #: the whole PoseSolution of idl/sessions.idl
        self.joint_names = list(joint_names)
        self.joints: np.ndarray = message["joint_positions"]  #: rad or m, as `joint_names`
        self.revision: int = message["revision"]
        self.is_final: bool = message["is_final"]
        self.is_diagnosed: bool = message["is_diagnosed"]
        self.outcome: str = message["outcome"]
        self.verdict: str = message["verdict"]  #: one line for people
        self.objective: float = message["terms"]["objective"]
        self.patches: dict[str, Patch] = {fit["name"]: Patch(fit) for fit in message["patches"]}

    @property
    def X_WH(self) -> np.ndarray:
        """The hand's root in the world, 4x4."""
        return matrix_of(self.message["X_WH"])

    @property
    def X_WO(self) -> np.ndarray:
        """The object in the world, 4x4."""
        return matrix_of(self.message["X_WO"])

    @property
    def link_poses(self) -> np.ndarray:
        """Poses of all links in the world, L x 4 x 4, in the order of the hand's description."""
        return matrices_of(self.message["X_WL"])

    @property
    def time_s(self) -> float | None:
        """In the session's motion, or of the demonstrator's frame that it answers; None of a grasp."""
        return self.message["time_s"]

    @property
    def depth(self) -> Depth | None:
        """How deep the hand is in the object and in itself; None until `is_diagnosed`."""
        told = self.message["penetration"]
        return None if told is None else Depth(told)

    @property
    def minima(self) -> list[dict[str, Any]]:
        """The places where searches ended, best first; the last pose alone has them."""
        return list(self.message["minima"])

    def __getitem__(self, joint: str) -> float:
        return float(self.joints[self.joint_names.index(joint)])

    def __repr__(self) -> str:
        return f"Pose(revision {self.revision}, {len(self.joints)} joints, {self.verdict or self.outcome})"
