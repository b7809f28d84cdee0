"""Edits that the prompt has, too: where patches lie, what is prior, snapshots."""

import json
import pathlib

import numpy as np
import pytest

import handgraft


def root_on_hand(session, patch):
    """Where a patch's root lies on the hand."""
    fits = {fit["name"]: fit for fit in session.transfer()["patches"]}
    return fits[patch]["root_S"]["face"], fits[patch]["root_S"]["barycentric"]


def corner_of(mesh, face):
    return mesh["vertices_m"].reshape(-1, 3)[mesh["triangles"].reshape(-1, 3)[face, 0]]


def test_a_root_goes_to_a_point_of_the_skin(server, session):
    mesh = server.describe("hand", "barrett8", meshes=True)["skin_S"]
    session.root("thumb", at=corner_of(mesh, 100))
    face, barycentric = root_on_hand(session, "thumb")
    corner = mesh["triangles"].reshape(-1, 3)[face][int(np.argmax(barycentric))]
    np.testing.assert_allclose(mesh["vertices_m"].reshape(-1, 3)[corner], corner_of(mesh, 100), atol=1e-6)


def test_a_root_goes_to_a_face_of_the_object(session):
    session.root("thumb", "object", face=(7, 0.2, 0.3, 0.5))
    patch = next(patch for patch in session.settings()["patches"] if patch["name"] == "thumb")
    assert patch["root_O"]["face"] == 7
    np.testing.assert_allclose(patch["root_O"]["barycentric"], (0.2, 0.3, 0.5))


def test_a_root_goes_to_a_site(server, session):
    hand = server.describe("hand", "barrett8", meshes=True)
    site = hand["sites"][1]
    session.root("thumb", pick=site["name"])
    face, _ = root_on_hand(session, "thumb")
    assert hand["links"][hand["skin_face_links"][face]]["name"] == site["link"]


@pytest.mark.parametrize("where, told", [
    ({}, "one of pick, at and face"), ({"pick": "palm", "at": (0, 0, 0)}, "one of pick, at and face"),
    ({"pick": "sixth"}, "'sixth': the hand has no such site; there are .*palm"),
    ({"at": (100, 0, 0)}, "at .*mm from the hand's skin; at most 50 mm"), ({"at": (0, 0)}, "at .*3 finite numbers"),
    ({"face": (1, 0.5, 0.5, 0.5)}, "face: weights .*sum to 1"), ({"face": (-1, 1, 0, 0)}, "face -1: .*whole number"),
    ({"side": "foot", "at": (0, 0, 0)}, "side 'foot': permitted are hand, object"),
    ({"side": "object", "pick": "palm"}, "'palm': sites are of the hand")])
def test_a_root_that_is_none_is_told(session, where, told):
    with pytest.raises(handgraft.InvalidInput, match=told):
        session.root("thumb", **where)


def site_of(server, session, name):
    """A site's link, and its place on it."""
    sites = {site["name"]: site for site in server.describe("hand", session.state()["hand"])["sites"]}
    return sites[name]["link"], sites[name]["p_L_m"]


def place_of(server, session, pose, link, p_L):
    links = [one["name"] for one in server.describe("hand", session.state()["hand"])["links"]]
    return (pose.link_poses[links.index(link)] @ [*p_L, 1.0])[:3]


def held_links(session):
    return [held["link"] for held in session.settings()["held"]]


def test_a_site_is_dragged_by_its_name(server, session):
    link, p_L = site_of(server, session, "thumb")
    target = place_of(server, session, session.solve(), link, p_L) + (0.0, 0.0, 0.004)
    session.drag("thumb", to=target)
    np.testing.assert_allclose(place_of(server, session, session.pose(), link, p_L), target, atol=1e-3)
    assert held_links(session) == [link]
    session.release("thumb")
    assert held_links(session) == []


def test_the_end_of_a_sites_link_is_dragged_by_its_name(server, session):
    link, p_L = site_of(server, session, "thumb")
    links = {one["name"]: one for one in server.describe("hand", "barrett8", meshes=True)["links"]}
    vertices = links[link]["surface_L"]["vertices_m"].reshape(-1, 3)
    session.solve()
    session.drag("thumb_tip", to=(0.0, 0.0, 0.1), weight=0.5)
    (held,) = session.settings()["held"]
    assert (held["link"], held["weight"]) == (link, 0.5)
    assert np.linalg.norm(vertices - held["p_L_m"], axis=1).min() < 1e-6
    assert np.linalg.norm(p_L - held["p_L_m"]) > 1e-3


def test_a_drag_that_is_none_is_told(session):
    session.solve()
    with pytest.raises(handgraft.InvalidInput, match="no point 'sixth'; there are its sites .*palm.*_tip, and its links"):
        session.drag("sixth", to=(0, 0, 0))
    with pytest.raises(handgraft.InvalidInput, match="drag 'thumb': p_L and target_W have to be given, or to alone"):
        session.drag("thumb", (0, 0, 0))
    with pytest.raises(handgraft.InvalidInput, match="R_WL .*3x3 rotation"):
        session.palm((0, 0, 0), 2 * np.eye(3))


@pytest.fixture
def free_session(session):
    """Where the prior alone counts: each edit of it is answered by itself."""
    X_WO = np.eye(4)
    X_WO[:3, 3] = (5.0, 0.0, 0.0)
    session.place(X_WO)
    session.weights(0.0, 0.0, 1.0)
    session.solve()
    return session


def middle_of(session, joint):
    limits = session.settings()["joints"][joint]
    return (limits["lower"] + limits["upper"]) / 2


def test_a_bent_joint_is_prior(free_session):
    middle = middle_of(free_session, 1)
    free_session.joint(free_session.joint_names[1], middle)
    assert free_session.pose().joints[1] == pytest.approx(middle, abs=1e-4)


def test_a_pose_becomes_prior(server, free_session, tmp_path):
    free_session.joint(free_session.joint_names[1], middle_of(free_session, 1))
    bent = free_session.pose()
    free_session.prior("rest")
    rest = server.describe("hand", "barrett8")["rest_positions"]
    np.testing.assert_allclose(free_session.pose().joints, rest, atol=0.1)  # at rest it would touch itself
    free_session.prior(bent)
    np.testing.assert_allclose(free_session.pose().joints, bent.joints, atol=1e-4)
    np.testing.assert_allclose(free_session.pose().X_WH, bent.X_WH, atol=1e-4)
    free_session.prior("here")
    np.testing.assert_allclose(free_session.pose().joints, bent.joints, atol=1e-4)
    file = tmp_path / "pose.json"
    file.write_text(json.dumps({"joints": {free_session.joint_names[1]: rest[1]}}))
    free_session.prior(file)
    assert free_session.pose().joints[1] == pytest.approx(rest[1], abs=1e-4)


def test_the_hand_of_a_prior_is_placed(free_session):
    X_WH = np.eye(4)
    X_WH[:3, 3] = (0.1, 0.2, 0.3)
    free_session.prior("rest", X_WH)
    np.testing.assert_allclose(free_session.pose().X_WH, X_WH, atol=1e-4)


@pytest.mark.filterwarnings("ignore:.*short of its")
def test_the_palm_is_placed_and_turned(server, free_session):
    link, p_L = site_of(server, free_session, "palm")
    links = [one["name"] for one in server.describe("hand", "barrett8")["links"]]
    R_WL = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    free_session.palm((0.1, 0.2, 0.3), R_WL)
    pose = free_session.pose()
    np.testing.assert_allclose(place_of(server, free_session, pose, link, p_L), (0.1, 0.2, 0.3), atol=1e-3)
    np.testing.assert_allclose(pose.link_poses[links.index(link)][:3, :3], R_WL, atol=0.05)  # the prior pulls
    free_session.palm((0.1, 0.2, 0.4))
    np.testing.assert_allclose(place_of(server, free_session, free_session.pose(), link, p_L), (0.1, 0.2, 0.4), atol=1e-3)
    free_session.release()
    assert held_links(free_session) == []


def test_another_hand_is_taken(session):
    session.solve()
    with pytest.warns(UserWarning, match="the hand has other joints"):
        session.hand("human20")
    assert session.state()["hand"] == "human20"
    assert len(session.joint_names) == 20
    assert session.pose().joint_names == session.joint_names
    with pytest.raises(handgraft.Refused, match="glove"):
        session.hand("glove")


def test_another_object_is_taken(session):
    file = pathlib.Path(__file__).parents[3] / "server" / "models" / "objects" / "lemon.obj"
    before = session.state()["object"]
    session.object(file)
    session.solve()
    assert session.state()["object"].startswith(before)
    with pytest.raises(handgraft.InvalidInput, match="units 'mm': object 'lemon' is no file"):
        session.object("lemon", units="mm")
    with pytest.raises(handgraft.WrongType, match="object: 7 is neither"):
        session.object(7)


def test_how_it_searches_is_kept(session):
    session.solver("slsqp", starts=3, seed=5, touch_only=True)
    session.solver(max_evaluations=200, normal_form="sum")
    kept = session.settings()["solving"]
    assert {name: kept[name] for name in ("solver", "starts", "seed", "max_evaluations", "normal_form", "penetration")} == {
        "solver": "slsqp", "starts": 3, "seed": 5, "max_evaluations": 200, "normal_form": "sum", "penetration": "reported"}
    session.solver("paper")
    kept = session.settings()["solving"]
    assert (kept["paper"], kept["solver"], kept["starts"], kept["seed"]) == (True, "default", 0, 5)
    session.solver("lm", touch_only=False)
    kept = session.settings()["solving"]
    assert (kept["paper"], kept["solver"], kept["penetration"]) == (False, "lm", "avoided")
    with pytest.raises(handgraft.InvalidInput, match="'paper'.*starts"):
        session.solver("paper", starts=2)
    with pytest.raises(handgraft.InvalidInput, match="newton"):
        session.solver("newton")


def test_nothing_that_was_edited_at_a_time_is_taken_back(session):
    with pytest.raises(handgraft.InvalidInput, match="index 0: nothing was edited at a time"):
        session.take_back(0)


def test_a_prior_that_is_none_is_told(session):
    with pytest.raises(handgraft.InvalidInput, match="prior 'here is': permitted are 'rest', 'here'"):
        session.prior("here is")
    with pytest.raises(handgraft.Error, match="solve it first"):
        session.prior("here")


def test_an_edit_that_says_nothing_is_told(session):
    with pytest.raises(handgraft.InvalidInput, match="edit 'joint_lock': the member that it chooses.*not given"):
        session.edit("joint_lock")


def test_the_prior_has_shares(session):
    before = session.settings()["prior_shares"]
    session.prior_shares(2.0, 3.0, 4.0)
    session.prior_posture(0.5)
    shares = session.settings()["prior_shares"]
    assert (shares["root_rotation"], shares["root_translation"], shares["joints"]) == (2.0, 3.0, 4.0)
    assert shares["posture"] == 0.5 != before["posture"]


def test_a_snapshot_is_compared_and_restored(session):
    session.solve()
    session.snapshot("before")
    assert session.compare("before") == []
    session.weigh("thumb", 0.25)
    session.pose()
    session.snapshot("after")
    told = {one.what: one for one in session.compare("before")}
    assert told["patch thumb weight"].change == pytest.approx(-0.75)
    assert [one.what for one in session.compare("before", "after")] == list(told)
    session.restore("before")
    assert {patch["name"]: patch["weight"] for patch in session.settings()["patches"]}["thumb"] == 1.0
    with pytest.raises(handgraft.Refused, match="never"):
        session.restore("never")


def test_where_no_point_is_lost_no_place_is_better(session):
    assert session.suggest("thumb", reach=0.03, count=2) == []


@pytest.mark.parametrize("wrong, told", [({"apply": 9}, "apply 9: there are 0"), ({"reach": 5}, "reach 5: .* 1e-4 to 0.1"),
                                         ({"count": 101}, "count 101: .* 0 to 100")])
def test_suggestions_asked_for_wrongly_are_told(session, wrong, told):
    with pytest.raises(handgraft.InvalidInput, match=told):
        session.suggest("thumb", **wrong)


def test_a_place_suggested_is_where_the_patch_goes(server, session, monkeypatch):
    place = {"root_S": {"face": 7, "barycentric": [0.2, 0.3, 0.5]}, "turned_rad": 0.4, "moved_m": 0.01, "point_count": 20,
             "lost_count": 5, "lost": [{"reason": "beyond the skin", "count": 5}]}
    client = server._client

    class Suggesting:  # no built-in hand loses points
        def ask(self, body):
            return {"suggest": {"suggestions": [place]}} if body["kind"] == "suggest" else client.ask(body)

        def __getattr__(self, name):
            return getattr(client, name)

    monkeypatch.setattr(server, "_client", Suggesting())
    (one,) = session.suggest("thumb", apply=1)
    assert (one.moved_m, one.points, one.lost, one.reasons) == (0.01, 20, 5, {"beyond the skin": 5})
    assert session.revision == 2  # root and direction
    assert root_on_hand(session, "thumb")[0] == 7
