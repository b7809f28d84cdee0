"""Hands that are not built yet: variants, and sweeps over them; contacts of a posed hand."""

import numpy as np
import pytest

import handgraft
from handgraft.studies import Sweep, property_of


@pytest.fixture(scope="module")
def swept(server):
    hand = server.describe("hand", "barrett8")
    joint = hand["joints"][1]["name"]
    return joint, server.sweep("barrett8", {f"{joint}.upper": [0.4, 1.2, 2.4], "hand.size": [0.8, 1.0]},
                               [("lemon", "lemon_3"), ("lemon", "lemon_6")])


def test_a_sweep_has_an_axis_a_property_and_one_of_grasps(swept):
    joint, sweep = swept
    assert list(sweep.axes) == [f"{joint}.upper", "hand.size"]
    for values in (sweep.mean_mm, sweep.reached, sweep.patches, sweep.depth_m, sweep.errors):
        assert values.shape == (3, 2, 2)
    assert sweep.joints.shape == (3, 2, 2, 8)
    assert sweep.grasps == ["lemon_3", "lemon_6"]
    assert (sweep.errors == "").all()
    column = sweep.joint_names.index(joint)
    for k, upper in enumerate([0.4, 1.2, 2.4]):
        assert sweep.joints[k, :, :, column].max() <= upper + 1e-9
    assert (sweep.reached <= sweep.patches).all()
    assert sweep.depth_m.max() < 0.003
    assert any("contacts go to" in note for note in sweep.notes["lemon_6"]), "three fingers for five"


def test_the_best_reaches_most(swept):
    joint, sweep = swept
    best = sweep.best
    at = (list(sweep.axes[f"{joint}.upper"]).index(best[f"{joint}.upper"]),
          list(sweep.axes["hand.size"]).index(best["hand.size"]))
    assert sweep.share_reached[at] == pytest.approx(sweep.share_reached.max(), abs=1e-3)


def test_a_row_is_the_variants_grasp(server, swept):
    joint, sweep = swept
    name = server.vary("barrett8", "short_barrett", {f"{joint}.upper": 1.2, "hand.size": 0.8})
    assert name in server.models("hand")
    limits = {one["name"]: one["upper"] for one in server.describe("hand", name)["joints"]}
    assert limits[joint] == pytest.approx(1.2)
    pose = server.grasp(name, "lemon", "lemon_3")
    assert pose.joints.shape == (8,)
    assert sweep.mean_mm[1, 0, 0] < 20.0


def test_rows_without_an_answer_are_nan_and_say_why():
    row = {"error": "", "mean_mm": 2.0, "max_mm": 3.0, "normal_deg": 10.0, "max_depth_m": 0.0, "self_depth_m": 0.0,
           "patch_count": 4, "reached_count": 2, "joint_positions": [0.1]}
    none = {**row, "error": "limits cross", "joint_positions": []}
    better = {**row, "reached_count": 3, "mean_mm": 5.0}
    sweep = Sweep({"joint_names": ["bend"], "rows": [row, row, none, better, better, better],
                   "notes": [{"grasp": 1, "text": "no palm"}]},
                  {"bend.upper": np.array([0.1, 0.2, 0.3])}, ["a", "b"])
    assert np.isnan(sweep.mean_mm[1, 0]) and np.isnan(sweep.joints[1, 0, 0])
    assert sweep.errors[1, 0] == "limits cross"
    np.testing.assert_allclose(sweep.share_reached, [0.5, 0.375, 0.75])
    assert sweep.best == {"bend.upper": 0.3}
    assert sweep.notes == {"a": [], "b": ["no palm"]}


@pytest.mark.parametrize("name, expected", [
    ("thumb_mcp.upper", {"property": "upper", "target": "thumb_mcp"}),
    ("a.b.length", {"property": "length", "target": "a.b"}),
    ("hand.size", {"property": "size", "target": ""}),
    ("palm.size", {"property": "size", "target": "palm"})])
def test_properties_are_named_as_for_the_command(name, expected):
    assert property_of(name) == expected


@pytest.mark.parametrize("name", ["upper", ".upper", "thumb.colour", "thumb"])
def test_a_property_that_is_none_is_told_those_there_are(name):
    with pytest.raises(handgraft.InvalidInput, match=f"'{name}'.*lower"):
        property_of(name)


def test_a_joint_that_is_none_is_named(server):
    with pytest.raises(handgraft.Refused, match="no_such_joint"):
        server.sweep("barrett8", {"no_such_joint.upper": [0.1]}, [("lemon", "lemon_3")])
    with pytest.raises(handgraft.Refused, match="no_such_link"):
        server.vary("barrett8", "odd", {"no_such_link.length": 1.1})


def test_a_posed_hand_leaves_contacts(server):
    pose = server.grasp("human20", "lemon", "lemon_3")
    joints = dict(zip(pose.joint_names, pose.joints))
    name = server.contacts_of_pose("human20", "lemon", joints, X_WH=pose.X_WH, X_WO=pose.X_WO, name="left_behind")
    assert name == "left_behind"
    touched = server.describe("contacts", name)
    assert touched["object"] == "lemon"
    assert any(patch["name"].startswith("thumb") for patch in touched["patches"])
    with pytest.raises(handgraft.Refused, match="nowhere|touch"):
        server.contacts_of_pose("human20", "lemon", joints, X_WH=np.diag([1.0, 1, 1, 1]), X_WO=pose.X_WO + np.eye(4, k=3) * 9,
                                name="apart")


def test_joints_of_a_posed_hand_may_be_an_array(server):
    pose = server.grasp("human20", "lemon", "lemon_3")
    name = server.contacts_of_pose("human20", "lemon", pose.joints, X_WH=pose.X_WH, X_WO=pose.X_WO, name="by_array")
    assert server.describe("contacts", name)["demonstrator"] == "right"
    with pytest.raises(handgraft.InvalidInput, match="2 numbers; hand 'human20' has 20 joints"):
        server.contacts_of_pose("human20", "lemon", [0.1, 0.2])


def test_what_is_swept_is_checked_before_it_is_sent(server):
    with pytest.raises(TypeError, match="vary"):
        server.sweep("barrett8", ["hand.size"], [("lemon", "lemon_3")])
    with pytest.raises(TypeError, match="'lemon_3'; each must be"):
        server.sweep("barrett8", {"hand.size": [1.0]}, ["lemon_3"])
    with pytest.raises(handgraft.InvalidInput, match="hand.size: a value is not finite"):
        server.sweep("barrett8", {"hand.size": [np.nan]}, [("lemon", "lemon_3")])
    with pytest.warns(UserWarning, match="90 rad; limits are in rad or m, not degrees"):
        server.sweep("barrett8", {"thumb_proximal_flex.upper": [1.0, 90.0]}, [("lemon", "lemon_3")], starts=1)
