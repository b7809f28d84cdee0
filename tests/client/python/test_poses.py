"""Poses as matrices: no server."""

import numpy as np
import pytest

from handgraft.poses import Pose, matrix_of, message_of


def rotation(axis, angle):
    """Rodrigues' formula, independent of quaternions."""
    x, y, z = np.asarray(axis) / np.linalg.norm(axis)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K


@pytest.mark.parametrize("angle", [0.0, 0.3, 2.0, np.pi - 1e-9, np.pi])
@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (1, -2, 3), (-1, -1, -1)])
def test_a_pose_is_the_same_there_and_back(axis, angle):
    X = np.eye(4)
    X[:3, :3] = rotation(axis, angle)
    X[:3, 3] = (0.1, -0.2, 0.3)
    message = message_of(X)
    assert np.linalg.norm(message["q_wxyz"]) == pytest.approx(1)
    np.testing.assert_allclose(matrix_of(message), X, atol=1e-9)


def test_a_quaternion_says_its_turn():
    message = {"p_m": [0, 0, 0], "q_wxyz": [np.cos(0.35), 0, 0, np.sin(0.35)]}
    np.testing.assert_allclose(matrix_of(message)[:3, :3], rotation((0, 0, 1), 0.7), atol=1e-12)


@pytest.mark.parametrize("X", [np.eye(3), 2 * np.eye(4), np.diag([1.0, 1.0, -1.0, 1.0])])
def test_what_is_no_pose_is_refused(X):
    with pytest.raises(ValueError, match="rotation"):
        message_of(X)


def posed(penetration):
    return Pose({"joint_positions": np.zeros(1), "revision": 1, "is_final": True, "outcome": "converged",
                 "is_diagnosed": penetration is not None, "verdict": "", "terms": {"objective": 1.0},
                 "patches": [], "penetration": penetration}, ["bend"])


def test_a_pose_says_how_deep_it_is():
    assert posed(None).depth is None
    depth = posed({"max_depth_m": 0.004, "mean_depth_m": 0.001, "volume_m3": 2e-7,
                   "links": [{"link": "tip", "depth_m": 0.004}, {"link": "palm", "depth_m": 0.001}],
                   "self_depth_m": 0.002, "self_links": ["tip", "thumb"]}).depth
    assert (depth.max_m, depth.link, depth.volume_m3) == (0.004, "tip", 2e-7)
    assert depth.links == {"tip": 0.004, "palm": 0.001}
    assert (depth.self_m, depth.self_links) == (0.002, ("tip", "thumb"))


def test_a_pose_may_be_nowhere_inside():
    depth = posed({"max_depth_m": 0.0, "mean_depth_m": 0.0, "volume_m3": 0.0, "links": [],
                   "self_depth_m": 0.0, "self_links": []}).depth
    assert depth.link is None and depth.links == {} and depth.self_links == ()
