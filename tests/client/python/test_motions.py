"""Motions: made of grasps or of what a hand did, solved, edited at a time, followed live."""

import json
import pathlib

import numpy as np
import pytest

import handgraft
from handgraft.motions import Motion

DEMO = pathlib.Path(__file__).parents[2] / "system" / "demo"


def turned(angle, p):
    """About z, at p."""
    X = np.eye(4)
    X[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    X[:3, 3] = p
    return X


@pytest.fixture(scope="module")
def pull(server):
    """A box pulled off a shelf and turned, two seconds at 20 frames a second."""
    return server.join_grasps("box_5", DEMO / "box_4.json", [0.0, 1.0, 2.0],
                              [turned(0, (0, 0, 0.3)), turned(0, (-0.25, 0, 0.32)), turned(0.5, (-0.3, 0, 0.2))],
                              "pull", rate_hz=20)


@pytest.fixture(scope="module")
def followed(server, pull):
    with server.open("tendon16", motion=pull) as session:
        yield session, session.solve_motion()


def test_a_motion_of_two_grasps_is_a_model(server, pull):
    assert pull in server.models("motion")
    motion = server.describe("motion", pull)
    assert motion["object"] == "box"
    assert motion["frame_count"] == 41
    assert set(motion["patches"]) >= {"thumb", "index", "little"}


def test_a_path_without_as_many_poses_is_told(server):
    with pytest.raises(handgraft.InvalidInput, match="2 times and 1 poses"):
        server.join_grasps("box_5", "box_5", [0.0, 1.0], [np.eye(4)], "short")
    with pytest.raises(handgraft.InvalidInput, match="'box_5' lie on object 'box' and 'lemon_6' on 'lemon'"):
        server.join_grasps("box_5", "lemon_6", [0.0, 1.0], [np.eye(4)] * 2, "both")


def test_frames_are_arrays(followed):
    session, motion = followed
    frames, joints = 41, len(session.joint_names)
    assert len(motion) == frames
    np.testing.assert_allclose(motion.time_s, np.arange(frames) / 20, atol=1e-9)
    assert motion.joints.shape == (frames, joints)
    assert motion.X_WH.shape == motion.X_WO.shape == (frames, 4, 4)
    np.testing.assert_allclose(motion.X_WO[-1], turned(0.5, (-0.3, 0, 0.2)), atol=1e-6)
    np.testing.assert_array_equal(motion[session.joint_names[2]], motion.joints[:, 2])
    assert motion.summary["max_depth_m"] == motion.depth_m.max() < 0.002
    assert motion.summary["self_depth_m"] == motion.self_depth_m.max()
    assert motion.summary["frames_reached"] == motion.reached.sum() > 0


def test_patches_come_and_go(followed):
    _, motion = followed
    thumb, little = motion.patches["thumb"], motion.patches["little"]
    assert thumb.there.all() and not np.isnan(thumb.mean_mm).any()
    assert little.there[0] and not little.there[-1]
    assert np.isnan(little.mean_mm[-1])
    assert motion.touches.all()


def test_a_limit_that_the_answer_before_cannot_keep_is_met_from_nothing(server):
    """From where the hand was, the index ended 8.6 mm off in all frames; a hand of that limit reaches all."""
    path = [turned(0, (0, 0, 0.3)), turned(0, (-0.25, 0, 0.32)), turned(0.5, (-0.3, 0, 0.2))]
    motion = server.join_grasps("box_5", "box_5", [0.0, 1.0, 2.0], path, "still", rate_hz=10)
    with server.open("allegro16", motion=motion) as session:
        assert session.solve_motion().reached.all()
        session.limit("index_proximal_flex", -0.196, np.radians(40.0))
        after = session.motion()
        assert after.joints[:, session.joint_names.index("index_proximal_flex")].max() <= np.radians(40.0) + 1e-6
        assert after.reached.all()


def test_an_edit_at_a_time_changes_the_frames_about_it(server, pull, followed):
    before = followed[1]
    with server.open("tendon16", motion=pull) as session:
        session.solve_motion()
        with session.at(1.0, falloff_s=0.1):
            session.turn("thumb", 0.5)
        after = session.motion()
        changed = np.abs(after.joints - before.joints).max(axis=1) > 1e-9
        assert changed[19:22].any()
        assert not changed[0] and not changed[-1]
        session.undo()
        np.testing.assert_array_equal(session.motion().joints, before.joints)
        # Without `at` an edit is of the whole motion.
        session.turn("thumb", 0.5)
        assert (np.abs(session.motion().joints - before.joints).max(axis=1) > 1e-9).all()


def test_an_edit_of_somebody_else_at_a_time_is_taken_back(server, pull):
    with server.open("tendon16", motion=pull) as session:
        other = server.join(session.id)
        with other.at(0.5, falloff_s=0.1):
            other.turn("thumb", 0.5)
        with session.at(1.5, falloff_s=0.1):
            session.turn("index", 0.3)
            assert [timed["time_s"] for timed in session.settings()["timed"]] == [0.5, 1.5]
            session.take_back(0)
        assert [timed["time_s"] for timed in session.settings()["timed"]] == [1.5]
        with pytest.raises(handgraft.InvalidInput, match="index 1: it must be -1 to 0"):
            session.take_back(1)
        session.take_back(-1)
        assert len(session.settings()["timed"]) == 0


def test_a_motion_is_exported(followed, tmp_path):
    session, motion = followed
    session.export("npz", tmp_path / "pull.npz")
    np.testing.assert_allclose(np.load(tmp_path / "pull.npz")["time"], motion.time_s, atol=1e-9)


def test_what_a_hand_did_is_a_motion_for_another(server, followed):
    session, motion = followed
    name = server.motion_of_hand("tendon16", "box", motion.time_s, motion.joints, "done",
                                 joint_names=session.joint_names, X_WH=motion.X_WH, X_WO=motion.X_WO)
    done = server.describe("motion", name)
    assert done["object"] == "box"
    assert any(patch.startswith("thumb") for patch in done["patches"])
    with server.open("human20", motion=name) as other:
        assert len(other.solve_motion(causal=True)) == done["frame_count"]
    with pytest.raises(handgraft.InvalidInput, match="3 poses for 41 frames"):
        server.motion_of_hand("tendon16", "box", motion.time_s, motion.joints, "odd", X_WO=motion.X_WO[:3])
    with pytest.raises(handgraft.InvalidInput, match="2 rows for 41 times"):
        server.motion_of_hand("tendon16", "box", motion.time_s, motion.joints[:2], "odd")


def test_a_motion_file_is_loaded(server, pull, tmp_path):
    path = tmp_path / "mine.json"
    path.write_text(json.dumps({**json.loads(server.describe("motion", pull, meshes=True)["file"]), "name": "mine"}))
    assert server.load_motion(path) == "mine"
    path.write_text("{")
    with pytest.raises(handgraft.Refused, match="mine.json"):
        server.load_motion(path, name="broken")


def test_a_demonstration_of_numpy_names_its_object(server, tmp_path):
    t = np.linspace(0, 0.5, 16)
    places = np.zeros((16, 21, 3))
    for finger in range(5):  # straight fingers beside each other, which lie on the box's side
        places[:, 1 + 4 * finger: 5 + 4 * finger, 0] = 0.09 + 0.025 * np.arange(4)
        places[:, 1 + 4 * finger: 5 + 4 * finger, 1] = 0.02 * (finger - 2)
    box = server.describe("object", "box", meshes=True)["mesh_O"]["vertices_m"].reshape(-1, 3)
    places[:, :, 2] = box[:, 2].max() + 0.01
    places[:, :, 0] -= 0.12
    pose = np.tile([0, 0, 0, 1, 0, 0, 0.0], (16, 1))
    np.savez(tmp_path / "demo.npz", joints_W_m=places, time_s=t, object_pose=pose, object="box")
    name = server.load_motion(tmp_path / "demo.npz")
    assert server.describe("motion", name)["object"] == "box"


def test_contacts_or_a_motion_have_to_be_given(server, pull):
    for given in ({}, {"contacts": "box_5", "motion": pull}):
        with pytest.raises(handgraft.InvalidInput, match="one of them"):
            server.open("tendon16", "box", **given)
    with server.open("tendon16", "box", "box_5") as session:
        with pytest.raises(handgraft.Refused, match="motion"):
            session.solve_motion()


def test_a_demonstrator_is_followed_live(server, followed, tmp_path):
    """The hand of the motion as a demonstrator: another robot's joints."""
    _, motion = followed
    with server.open("barrett8", motion="pull") as session:
        demonstrator = session.follow()
        steps, depths = [], []
        for k, at in enumerate(motion.time_s):
            pose = demonstrator.answer(at, motion.X_WO[k], joints=motion.joints[k], hand="tendon16", X_WH=motion.X_WH[k])
            assert pose.time_s == at
            np.testing.assert_allclose(pose.X_WO, motion.X_WO[k], atol=1e-9)
            steps.append(pose.joints)
            assert pose.is_diagnosed
            depths.append(pose.depth.max_m)
            assert len(pose.patches) >= 3 and all("_" in name for name in pose.patches)
            reached = sum(patch.verdict == "reached" for patch in pose.patches.values())
            assert pose.verdict.startswith(f"{reached} of ") and reached > 0
        assert np.abs(np.diff(steps, axis=0)).max() < 0.5
        assert np.median(depths) < 0.001 and max(depths) < 0.002
        session.export("npz", tmp_path / "live.npz", live=True)
        with np.load(tmp_path / "live.npz") as did:
            np.testing.assert_allclose(did["qpos"][:, 7:-7][:, : len(steps[0])], steps, atol=1e-9)
            assert did["contact"].max() == 1
        with pytest.raises(ValueError, match="2 of them"):
            demonstrator.send(1.0, np.eye(4), places=np.zeros((21, 3)), mano=np.zeros(51))
        by_name = dict(zip(motion.joint_names, motion.joints[-1]))
        pose = demonstrator.answer(2.1, motion.X_WO[-1], joints=by_name, hand="tendon16", X_WH=motion.X_WH[-1])
        np.testing.assert_allclose(pose.joints, steps[-1], atol=0.05)
        with pytest.raises(handgraft.Error, match="2.2 s is not answered: .*'no_such_hand' is not known"):
            demonstrator.answer(2.2, np.eye(4), joints=[0.0], hand="no_such_hand")
        with pytest.raises(handgraft.InvalidInput, match="joints of 'tendon16': there is no 'tail'"):
            demonstrator.send(2.2, np.eye(4), joints={**by_name, "tail": 0.0}, hand="tendon16")
        with pytest.raises(handgraft.InvalidInput, match=r"shape \(3, 21\); it must be 21 x 3"):
            demonstrator.send(2.2, np.eye(4), places=np.zeros((3, 21)))
        with pytest.raises(handgraft.InvalidInput, match="'middle': permitted are left, right"):
            session.follow("middle")


def test_another_demonstrator_begins_anew(server, followed):
    """Neither the touches of the one before nor its clock."""
    _, motion = followed
    away = motion.X_WO[0].copy()
    away[:3, 3] += 1.0
    given = {"joints": motion.joints[0], "hand": "tendon16", "X_WH": motion.X_WH[0]}
    with server.open("barrett8", motion="pull") as session:
        session.follow().answer(5.0, motion.X_WO[0], **given)
        another = session.follow()
        assert not another.answer(0.0, away, **given).patches
        assert another.answer(0.1, motion.X_WO[0], **given).is_diagnosed


def test_a_demonstrator_that_touches_nothing_is_told(server, pull):
    with server.open("barrett8", motion=pull) as session:
        demonstrator = session.follow()
        places = np.zeros((21, 3))
        for finger in range(5):
            places[1 + 4 * finger: 5 + 4 * finger, 0] = 5 + np.linspace(0.08, 0.16, 4)
        places[0, 0] = 5
        # Knuckles in one line: nobody knows how such a hand is turned.
        with pytest.raises(handgraft.NotBegun, match="touches the object with 0 of the 3 parts"):
            demonstrator.answer(0.0, np.eye(4), places=places)
        with pytest.raises(handgraft.Error, match="a hand has 0.05 to 0.5") as refused:
            demonstrator.answer(0.1, np.eye(4), places=1e3 * places)
        assert not isinstance(refused.value, handgraft.NotBegun)


def test_what_a_motion_lacks_is_told_and_not_waited_for(server, pull):
    with server.open("tendon16", motion=pull) as session:
        with pytest.raises(handgraft.Error, match="solve_motion makes them"):
            session.motion()
        session.solve_motion(causal=np.bool_(True))
        session.weigh("thumb", 2.0)
        assert session.motion().revision == session.revision
        with pytest.raises(handgraft.Error, match=r"motion\(\) tells its frames"):
            session.pose()
    with server.open("barrett8", "lemon", "lemon_3") as session:
        session.solve()
        with pytest.raises(handgraft.Error, match="holds no motion"):
            session.motion()


def test_no_pose_is_published_beside_a_motion(server, pull):
    """A bridge that follows the session would leave the motion for it."""
    with server.open("tendon16", motion=pull) as session:
        session.solve_motion()
        stream = session.watch(final=False)
        for weight in (2.0, 3.0):
            session.weigh("thumb", weight)
            session.motion()
        last = server.join(session.id)._session.last()
        assert last is None
        session.close()
        assert list(stream) == []


def test_a_joint_is_locked_in_the_middle_of_what_it_does(server, pull):
    with server.open("tendon16", motion=pull) as session:
        before = session.solve_motion()
        joint = before.joint_names[int(np.ptp(before.joints, axis=0).argmax())]
        session.lock(joint)
        locked = session.motion()
        middle = 0.5 * (before[joint].min() + before[joint].max())
        np.testing.assert_allclose(locked[joint], middle, atol=1e-6)
        session.lock(joint, np.bool_(False))
        assert np.ptp(session.motion()[joint]) > 0


def test_a_patch_that_is_switched_off_is_not_missed(server, pull):
    with server.open("tendon16", motion=pull) as session:
        before = session.solve_motion()
        session.enable("thumb", False)
        after = session.motion()
        assert after.reached.sum() == before.reached.sum() == len(before)
        assert not after.patches["thumb"].there.any()
        assert session.solve_motion().summary["mean_mm"] < before.summary["mean_mm"] + 1


def test_the_object_goes_the_motions_way(server, pull):
    with pytest.raises(handgraft.Refused, match="X_WO: motion 'pull' tells where its object is"):
        server.open("tendon16", motion=pull, X_WO=np.eye(4))
    with server.open("tendon16", motion=pull) as session:
        with pytest.raises(handgraft.Refused, match="goes the way that motion 'pull' tells"):
            session.place(np.eye(4))


def test_an_exported_motion_is_read_back_with_its_hand(server, followed, tmp_path):
    session, motion = followed
    for format in ("json", "csv"):
        session.export(format, tmp_path / f"again.{format}")
        name = server.load_motion(tmp_path / f"again.{format}", "box", f"again_{format}", hand="tendon16")
        assert server.describe("motion", name)["duration_s"] == pytest.approx(motion.time_s[-1])
        server.unload("motion", name)
        assert name not in server.models("motion")


def test_frames_alone_make_a_motion():
    frame = {"time_s": 0.0, "joint_positions": np.array([0.5]), "X_WH": {"p_m": [0, 0, 0], "q_wxyz": [1, 0, 0, 0]},
             "X_WO": {"p_m": [0, 0, 1], "q_wxyz": [1, 0, 0, 0]}, "max_depth_m": 0.001, "self_depth_m": 0.0}
    fit = {"presence": 1.0, "mean_mm": 2.0, "normal_deg": 10.0, "point_count": 1}
    twice = Motion([{**frame, "patches": [{**fit, "patch": 0, "reached": True},
                                          {**fit, "patch": 0, "point_count": 3, "mean_mm": 6.0, "reached": False}]}],
                   ["bend"], ["palm"])
    assert not twice.reached[0] and twice.touches[0]
    assert twice.patches["palm"].mean_mm[0] == pytest.approx(5.0)
    motion = Motion([{**frame, "patches": [{**fit, "patch": 0, "reached": True}]},
                     {**frame, "patches": [{**fit, "patch": 0, "reached": True}, {**fit, "patch": 1, "reached": False}]},
                     {**frame, "patches": [{**fit, "patch": 1, "presence": 0.2, "reached": False}]}],
                    ["bend"], ["thumb", "index"])
    np.testing.assert_array_equal(motion.touches, [True, True, False])
    np.testing.assert_array_equal(motion.reached, [True, False, False])
    np.testing.assert_array_equal(motion.patches["index"].there, [False, True, False])
    assert repr(motion) == "Motion(3 frames in 0.00 s, reached in 1 of 2 that touch, 1.0 mm deep at most)"
    assert repr(motion.patches["thumb"]) == "PatchOverTime('thumb', there in 2 frames, reached in 2)"
