"""The demonstrated grasps, as rough poses in the object's frame (mm, rad).

All but the scissors are held from the object's +x side, by `human20` with its thumb side up (+z).
"""

from .demonstration import Grasp, Touch


UP = (0.0, 0.0, 1.0)


def posture(mcp, pip, dip, thumb, **more):
    """All fingers bent alike, the thumb's four joints, and single joints that differ."""
    q = {}
    for finger in ("index", "middle", "ring", "little"):
        q.update({f"{finger}_mcp_flex": mcp, f"{finger}_pip_flex": pip, f"{finger}_dip_flex": dip})
    names = ("thumb_cmc_abd", "thumb_cmc_flex", "thumb_mcp_flex", "thumb_ip_flex")
    q.update(zip(names, thumb))
    q.update(more)
    return q


def scissors():
    """Index and middle finger in the long ring, the thumb in the other, blades on the thumb's
    side; the other fingers curl away behind the ring."""
    away = {f"{finger}_{joint}_flex": bend for finger in ("ring", "little")
            for joint, bend in (("mcp", 1.2), ("pip", 1.6), ("dip", 0.9))}
    return Grasp(
        origin=(-86.0, 83.0, 101.0), palm=(0.0, 0.13, -0.99), fingers=(0.1, -0.98, -0.13),
        posture=posture(0.95, 0.65, 0.15, (1.4, -0.1, 0.0, -0.2), **away),
        touches=[Touch("thumb", (-58.0, 10.0, 0.0), UP), Touch("index", (-52.0, -10.0, 0.0), UP),
                 Touch("middle", (-70.0, -10.0, 0.0), UP)])


def wine_glass():
    """Around the bowl, the palm free: thumb on one side, three fingers on the other."""
    return Grasp(
        origin=(104.0, -59.0, 145.0), palm=(-0.89, -0.45, 0.0), fingers=(-0.45, 0.89, 0.0),
        posture=posture(0.65, 0.65, 0.45, (1.5, -0.4, -0.1, 0.6)),
        touches=[Touch("thumb", (-8.0, -35.0, 148.0)), Touch("index", (-12.0, 33.0, 164.0)),
                 Touch("middle", (-16.0, 32.0, 143.0)), Touch("ring", (-10.0, 32.0, 122.0))])


def box():
    """Across the narrow side: four fingers in a row on one broad face, the thumb on the other."""
    return Grasp(
        origin=(111.0, -73.0, -20.0), palm=(-0.95, -0.25, 0.15), fingers=(-0.25, 0.97, 0.05),
        posture=posture(0.8, 0.65, 0.25, (1.5, -0.2, 0.0, 0.05)),
        touches=[Touch("thumb", (8.0, -20.0, 14.0)), Touch("index", (8.0, 20.0, 34.0)),
                 Touch("middle", (4.0, 20.0, 12.0)), Touch("ring", (8.0, 20.0, -10.0)),
                 Touch("little", (14.0, 20.0, -31.0))])


def lemon():
    """In the palm, all five digits around it."""
    return Grasp(
        origin=(57.0, -57.0, -5.0), palm=(-0.95, -0.3, 0.1), fingers=(-0.3, 0.95, 0.0),
        posture=posture(0.75, 1.4, 0.3, (1.5, -0.4, 0.2, 1.3)),
        touches=[Touch("palm", (29.8, -1.0, -2.0)), Touch("thumb", (-24.0, -16.0, 6.0)),
                 Touch("index", (-18.0, 13.0, 20.0)), Touch("middle", (-23.0, 17.0, 7.0)),
                 Touch("ring", (-23.0, 16.0, -8.0)), Touch("little", (-17.0, 12.0, -21.0))])


def lemon_of_three():
    """By a gripper of three fingers, spread evenly round the lemon, its palm free."""
    bent = {f"{finger}_{joint}_flex": bend for finger in ("thumb", "index", "middle")
            for joint, bend in (("proximal", 1.5), ("distal", 0.3))}
    return Grasp(
        origin=(140.0, 0.0, 0.0), palm=(-1.0, 0.0, 0.0), fingers=(0.0, 1.0, 0.0),
        posture={**bent, "index_spread": 1.05, "middle_spread": 1.05},
        touches=[Touch("thumb", (-14.0, -24.0, 0.0)), Touch("index", (-14.0, 13.0, 24.0)),
                 Touch("middle", (-14.0, 13.0, -24.0))])
