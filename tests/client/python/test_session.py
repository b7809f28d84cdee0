"""The module against a real server."""

import os
import pathlib
import signal
import subprocess
import sys
import threading

import numpy as np
import pytest

import handgraft

MODELS = pathlib.Path(__file__).parents[3] / "server" / "models"


def test_no_server_is_an_error_that_says_where(empty_domain):
    with pytest.raises(handgraft.NoServer, match=f"domain {empty_domain}"):
        handgraft.connect(empty_domain, start=False)
    assert issubclass(handgraft.NoServer, ConnectionError)


def test_where_the_server_is_comes_from_the_environment(server, domain, empty_domain, monkeypatch):
    monkeypatch.setenv("HANDGRAFT_DOMAIN", str(domain))
    assert "lemon" in handgraft.connect(start=False).models("object")
    monkeypatch.setenv("HANDGRAFT_SERVER", "left")
    with pytest.raises(handgraft.NoServer, match=f"domain {empty_domain}.*left"):  # what is given counts more
        handgraft.connect(empty_domain, start=False)


@pytest.mark.parametrize("option, value, told", [
    ("DOMAIN", "abc", "'abc'.*0 to 100"), ("DOMAIN", "101", "'101'.*0 to 100"), ("DOMAIN", "-1", "'-1'.*0 to 100"),
    ("INTERFACE", "nope7", "'nope7'.*there are: .*lo"), ("SERVER", "9", "'9'.*letter"),
    ("PEERS", "nobody.invalid", "'nobody.invalid'")])
def test_a_bad_variable_is_named(empty_domain, monkeypatch, option, value, told):
    monkeypatch.setenv("HANDGRAFT_DOMAIN", str(empty_domain))
    monkeypatch.setenv(f"HANDGRAFT_{option}", value)
    with pytest.raises(handgraft.InvalidInput, match=f"HANDGRAFT_{option}: .*{told}"):
        handgraft.connect(start=False)


def test_models_are_listed_and_described(server):
    assert "barrett8" in server.models("hand")
    assert "lemon" not in server.models("hand")
    hand = server.describe("hand", "barrett8")
    assert [joint["kind"] for joint in hand["joints"]] == ["revolute"] * 8
    lemon = server.describe("object", "lemon", meshes=True)["mesh_O"]
    vertices = lemon["vertices_m"].reshape(-1, 3)
    assert lemon["triangles"].max() == len(vertices) - 1


def test_a_kind_that_is_none_is_told_those_there_are(server):
    with pytest.raises(handgraft.InvalidInput, match="'hands': permitted are hand, object, contacts, motion"):
        server.models("hands")


def lemon_in_millimetres(folder):
    """The path of a lemon.obj whose numbers are a thousand times as large."""
    path = folder / "lemon_mm.obj"
    lines = [line.split() for line in (MODELS / "objects" / "lemon.obj").read_text().splitlines()]
    path.write_text("\n".join(" ".join([words[0], *(str(1e3 * float(word)) for word in words[1:])])
                              if words[:1] == ["v"] else " ".join(words) for words in lines))
    return path


def test_units_are_asked_for_as_python_takes_them(server, tmp_path):
    path = lemon_in_millimetres(tmp_path)
    with pytest.raises(handgraft.Refused, match="say units='mm'$") as refusal:
        server.grasp("barrett8", path, "lemon_3")
    assert refusal.value.code == "units"
    with pytest.raises(handgraft.InvalidInput, match="neither object nor contacts"):
        server.open("barrett8", "lemon", "lemon_3", units="mm")
    name = server.load_object(path, units="mm")
    extent = np.ptp(server.describe("object", name, meshes=True)["mesh_O"]["vertices_m"].reshape(-1, 3), axis=0)
    assert 0.03 < extent.max() < 0.2


def test_models_that_are_none_are_named(server):
    with pytest.raises(TypeError, match="hand: None is neither"):
        server.grasp(None, "lemon", "lemon_3")
    with pytest.raises(handgraft.InvalidInput, match="'nope.urdf': no such file"):
        server.grasp("nope.urdf", "lemon", "lemon_3")
    with pytest.raises(handgraft.InvalidInput, match="'nope.urdf': no such file"):
        server.grasp(pathlib.Path("nope.urdf"), "lemon", "lemon_3")


def test_refusals_are_exceptions_with_the_servers_words(server):
    with pytest.raises(handgraft.Refused, match="glove") as refusal:
        server.describe("hand", "glove")
    assert refusal.value.code == "not_found"


def test_a_grasp_is_numpy_arrays(server):
    pose = server.grasp("barrett8", "lemon", "lemon_6")
    links = server.describe("hand", "barrett8")["links"]
    assert pose.joints.shape == (8,) and pose.joints.dtype == np.float64
    assert pose.link_poses.shape == (len(links), 4, 4)
    np.testing.assert_allclose(pose.link_poses[0], pose.X_WH, atol=1e-9)  # the root is a link
    for patch in pose.patches.values():
        if len(patch.residuals) > 0:  # they are what the server's own figures are made of
            assert 1e3 * patch.residuals.mean() == pytest.approx(patch.mean_mm, rel=1e-6)
            assert 1e3 * patch.residuals.max() == pytest.approx(patch.max_mm, rel=1e-6)
    assert pose.is_diagnosed and pose.verdict
    assert pose.depth.max_m == max(pose.depth.links.values(), default=0.0)


def test_a_hand_that_is_sent_may_be_mirrored(server):
    urdf = MODELS / "hands" / "human20" / "human20.urdf"
    with server.open(urdf, "lemon", "lemon_6", mirrored=True) as session:
        assert session.solve().patches
    left = server.grasp(urdf, "lemon", "lemon_6", mirrored=True)
    right = server.grasp(urdf, "lemon", "lemon_6")
    assert left.objective > right.objective, "a right hand's contacts on a left one"
    with pytest.raises(handgraft.InvalidInput, match="has been read already"):
        server.grasp("human20", "lemon", "lemon_6", mirrored=True)


def test_files_are_sent(server, tmp_path):
    name = server.load_object(MODELS / "objects" / "lemon.obj", "my_lemon")
    assert name == "my_lemon"
    contacts = server.load_contacts(MODELS / "contacts" / "lemon_6.json", name, "my_contacts")
    hand = server.load_hand(MODELS / "hands" / "barrett8" / "barrett8.urdf", "my_barrett")
    mine = server.grasp(hand, name, contacts)
    built_in = server.grasp("barrett8", "lemon", "lemon_6")
    np.testing.assert_allclose(mine.joints, built_in.joints, atol=1e-6)


def test_a_missing_file_is_named(server):
    with pytest.raises(handgraft.InvalidInput, match="nowhere.obj"):
        server.load_object("/nowhere.obj")
    assert issubclass(handgraft.InvalidInput, ValueError)


def test_edits_are_answered_by_poses(session):
    first = session.solve()
    joint = session.settings()["joints"][0]
    middle = (joint["model_lower"] + joint["model_upper"]) / 2
    value = first[joint["name"]]
    # The half of its range where the joint is not.
    lower, upper = (joint["model_lower"], middle) if value > middle else (middle, joint["model_upper"])
    session.limit(joint["name"], lower, upper)
    limited = session.pose()
    assert limited.revision == session.revision == 1
    assert lower - 1e-9 <= limited[joint["name"]] <= upper + 1e-9
    session.undo()
    assert session.pose(diagnosed=False).revision == 2
    assert session.settings()["joints"][0]["upper"] == pytest.approx(joint["model_upper"])


def test_limits_in_degrees_are_warned_of(session):
    with pytest.warns(UserWarning, match="angles are radians, not degrees"):
        session.limit(session.joint_names[1], 10, 60)


def test_an_edit_of_nothing_is_refused(session):
    with pytest.raises(handgraft.Refused, match="no_such_joint"):
        session.lock("no_such_joint")
    with pytest.raises(handgraft.InvalidInput, match="frequency"):
        session.edit("joint_lock", "joint_lock", {"joint": "a", "frequency": 1})


def test_a_session_without_a_pose_says_so(session):
    with pytest.raises(handgraft.Error, match="solve it first"):
        session.pose()


def test_the_object_moves_and_the_hand_follows(session):
    before = session.solve()
    X_WO = np.eye(4)
    X_WO[:3, 3] = (0.5, 0.0, 0.0)
    session.place(X_WO)
    after = session.pose()
    np.testing.assert_allclose(after.X_WO, X_WO, atol=1e-12)
    moved = after.X_WH[:3, 3] - before.X_WH[:3, 3]
    np.testing.assert_allclose(moved, (0.5, 0, 0), atol=0.02)


def test_watching_ends_with_the_session(server):
    session = server.open("barrett8", "lemon", "lemon_6")
    poses = []
    watcher = server.join(session.id)
    thread = threading.Thread(target=lambda: poses.extend(watcher.watch()))
    thread.start()
    session.solve()
    session.lock(session.joint_names[0])
    last = session.pose()
    session.close()
    thread.join()  # waiting released the GIL, or nothing of this thread had run
    assert poses[-1].revision == last.revision
    np.testing.assert_array_equal(poses[-1].joints, last.joints)


def test_exports_are_files(session, tmp_path):
    session.solve()
    content = session.export("csv", tmp_path / "grasp.csv")
    assert (tmp_path / "grasp.csv").read_bytes() == content
    assert session.joint_names[0].encode() in content
    assert session.save().startswith("{")


def test_a_grasp_is_exported_for_simulators(session, tmp_path):
    """As MuJoCo's qpos: the root, the joints, the object."""
    pose = session.solve()
    session.export("npz", tmp_path / "grasp.npz")
    arrays = np.load(tmp_path / "grasp.npz")
    joints = len(arrays["joint_names"])
    assert arrays["qpos"].shape == (1, 14 + joints)
    assert list(arrays["joint_names"][: len(session.joint_names)]) == session.joint_names
    np.testing.assert_allclose(arrays["qpos"][0, 7:7 + len(session.joint_names)], pose.joints, atol=1e-12)
    np.testing.assert_allclose(arrays["qpos"][0, :3], pose.X_WH[:3, 3], atol=1e-12)
    assert list(arrays["patch_names"]) == list(pose.patches)
    reached = [patch.verdict == "reached" for patch in pose.patches.values()]
    np.testing.assert_array_equal(arrays["contact"][0], np.array(reached, dtype=float))
    assert arrays["contact_pos"].shape == (1, len(reached), 3)
    numbers = session.export("mjcf").decode().split('qpos="')[1].split('"')[0].split()
    np.testing.assert_allclose(np.array(numbers, dtype=float), arrays["qpos"][0], atol=1e-8)


def test_ctrl_c_ends_a_wait_and_the_work(domain, server):
    program = (
        "import handgraft\n"
        f"server = handgraft.connect({domain}, start=False)\n"
        "session = server.open('human20', 'lemon', 'lemon_6')\n"
        "try:\n"
        "    print('waiting', session.id, flush=True)\n"
        "    for pose in session.watch(): pass\n"
        "except KeyboardInterrupt:\n"
        "    session.close()\n"
        "    print('stopped', flush=True)\n"
    )
    child = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True, env=os.environ)
    assert child.stdout.readline().startswith("waiting")
    child.send_signal(signal.SIGINT)
    assert child.stdout.readline() == "stopped\n"
    assert child.wait() == 0


@pytest.mark.parametrize("end, code", [("", 0), ("raise RuntimeError('over')", 1)])
def test_a_script_ends_beside_a_thread_that_watches(server, domain, end, code):
    program = (
        "import handgraft, threading, time\n"
        f"session = handgraft.connect({domain}, start=False).open('barrett8', 'lemon', 'lemon_3')\n"
        "def watch():\n"
        "    for pose in session.watch(): pass\n"
        "threading.Thread(target=watch, daemon=True).start()\n"
        "time.sleep(0.5)  # it waits by then\n"
        "print('over', flush=True)\n"
        f"{end}\n"
    )
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, env=os.environ,
                           timeout=120, check=False)
    assert ended.stdout == "over\n"
    assert ended.returncode == code, ended.stderr


def test_a_dragged_place_is_held_until_it_is_let_go(server):
    with server.open("barrett8", "lemon", "lemon_6") as session:
        before = session.solve()
        names = [link["name"] for link in server.describe("hand", "barrett8")["links"]]
        palm = names.index("palm")
        target = before.link_poses[palm][:3, 3] + (0, 0, 0.03)
        session.drag("palm", [0, 0, 0], target)
        assert np.linalg.norm(session.pose().link_poses[palm][:3, 3] - target) < 0.003
        session.release()
        after = session.pose()
        assert np.linalg.norm(after.link_poses[palm][:3, 3] - target) > 0.003


def test_weights_are_three(server):
    for weights in ([1, 2], [1, 2, 3, 4]):
        with pytest.raises(handgraft.InvalidInput, match=f"weights: {len(weights)} numbers"):
            server.open("barrett8", "lemon", "lemon_3", weights=weights)
