"""`human20`: an adult male right hand with 20 joints.

Segment lengths are fractions of a hand length of 190 mm (Buchholz, Armstrong & Goldstein 1992),
breadths near the male median of common anthropometric tables; joint ranges are the usual
clinical ones (AAOS), with a little hyperextension where most people have it.
"""

import math

from . import vectors as v
from .hand import FLEXION, Hand

EFFORT = 3.0  # N m, of the order of a strong finger's flexors
VELOCITY = 10.0  # rad/s, a fast voluntary movement
ABDUCTION = (-1.0, 0.0, 0.0)  # turns a finger towards the thumb's side
PAD_TILT = math.radians(18.0)  # people touch with the pulp between its middle and the tip

# name: knuckle in the palm's frame; roll (deg) that lets the bent fingers converge; lengths and
# radii of proximal, middle and distal phalanx
FINGERS = {
    "index": ((4.0, 27.0, 91.0), -2.0, (46.5, 27.0, 24.0), (9.2, 8.4, 7.6)),
    "middle": ((4.0, 5.0, 95.0), 0.0, (50.5, 31.0, 25.0), (9.4, 8.6, 7.8)),
    "ring": ((3.0, -16.0, 90.0), 2.0, (46.5, 30.0, 25.0), (8.9, 8.1, 7.4)),
    "little": ((1.0, -35.0, 81.0), 4.0, (38.5, 22.0, 22.5), (8.0, 7.3, 6.7)),
}
FLEXION_LIMITS = {"mcp": (-0.35, 1.57), "pip": (0.0, 1.92), "dip": (-0.10, 1.40)}
ABDUCTION_LIMITS = (-0.35, 0.35)

THUMB_BASE = (10.0, 25.0, 17.0)
THUMB_AZIMUTH = math.radians(75.0)  # of the thumb about z, from +x, at rest
THUMB_ELEVATION = math.radians(45.0)  # between the thumb and the fingers at rest
THUMB_LENGTHS = (47.0, 36.0, 30.0)
THUMB_RADII = (12.0, 10.5, 9.6)
THUMB_LIMITS = {"cmc_abd": (-0.20, 1.60), "cmc_flex": (-0.45, 0.80), "mcp_flex": (-0.20, 1.05),
                "ip_flex": (-0.30, 1.40)}


def add_fingertip(link, length, radius):
    """A round tip that tapers: the pulp's sphere and a smaller one that ends the finger.

    Returns the centre of the pulp's sphere."""
    pulp = (0.0, 0.0, length - 1.5 - radius)
    link.add_capsule((0.0, 0.0, 0.0), pulp, radius)
    link.add_sphere((0.0, 0.0, length - 0.75 * radius), 0.75 * radius)
    return pulp


def add_finger(hand, name, knuckle, roll, lengths, radii):
    place = (v.turn((0.0, 0.0, 1.0), math.radians(roll)), knuckle)
    base = hand.add_link(f"{name}_knuckle", "palm", f"{name}_mcp_abd", place, ABDUCTION,
                         ABDUCTION_LIMITS, EFFORT, VELOCITY)
    base.add_sphere((0.0, 0.0, 0.0), radii[0] + 0.6)
    parent, place = base.name, (0.0, 0.0, 0.0)
    segments = zip(("proximal", "middle", "distal"), ("mcp", "pip", "dip"), lengths, radii)
    for part, joint, length, radius in segments:
        link = hand.add_link(f"{name}_{part}", parent, f"{name}_{joint}_flex", place, FLEXION,
                             FLEXION_LIMITS[joint], EFFORT, VELOCITY)
        if part == "distal":
            pulp = add_fingertip(link, length, radius)
        else:
            link.add_capsule((0.0, 0.0, 0.0), (0.0, 0.0, length), radius)
        parent, place = link.name, (0.0, 0.0, length)
    hand.add_pad(name, parent, pulp, radii[2], PAD_TILT)


def thumb_frame():
    """The thumb's frame at rest: z along it, x out of its pad, both leaning towards +z, so that
    opposition about the hand's z axis keeps the pad looking at the fingers."""
    sin_e, cos_e = math.sin(THUMB_ELEVATION), math.cos(THUMB_ELEVATION)
    cos_a, sin_a = math.cos(THUMB_AZIMUTH), math.sin(THUMB_AZIMUTH)
    along = (sin_e * cos_a, sin_e * sin_a, cos_e)
    pad = (-cos_e * cos_a, -cos_e * sin_a, sin_e)
    return v.frame(along, pad)


def add_thumb(hand):
    R = thumb_frame()
    opposition = v.rotate_back(R, (0.0, 0.0, -1.0))
    base = hand.add_link("thumb_base", "palm", "thumb_cmc_abd", (R, THUMB_BASE), opposition,
                         THUMB_LIMITS["cmc_abd"], EFFORT, VELOCITY)
    base.add_sphere((0.0, 0.0, 0.0), THUMB_RADII[0])
    parent, place = base.name, (0.0, 0.0, 0.0)
    segments = zip(("metacarpal", "proximal", "distal"), ("cmc", "mcp", "ip"), THUMB_LENGTHS,
                   THUMB_RADII)
    for part, joint, length, radius in segments:
        link = hand.add_link(f"thumb_{part}", parent, f"thumb_{joint}_flex", place, FLEXION,
                             THUMB_LIMITS[f"{joint}_flex"], EFFORT, VELOCITY)
        if part == "distal":
            pulp = add_fingertip(link, length, radius)
        else:
            link.add_capsule((0.0, 0.0, 0.0), (0.0, 0.0, length), radius)
        parent, place = link.name, (0.0, 0.0, length)
    # The thenar eminence travels with the metacarpal.
    hand.link("thumb_metacarpal").add_capsule((3.0, 0.0, 8.0), (1.0, 0.0, 26.0), 13.5)
    hand.add_pad("thumb", parent, pulp, THUMB_RADII[2], PAD_TILT)


def add_palm(hand):
    palm = hand.root
    for name, (knuckle, _, _, radii) in FINGERS.items():
        carpal = (0.0, 0.45 * knuckle[1], 8.0)
        palm.add_capsule(carpal, v.along(knuckle, (0.0, 0.0, 1.0), -2.0), radii[0] + 1.2)
    palm.add_box((1.0, -4.0, 51.0), (20.0, 52.0, 66.0))
    palm.add_capsule((0.0, -14.0, 2.0), (0.0, 14.0, 2.0), 13.0)  # wrist
    palm.add_capsule((2.0, 14.0, 14.0), (2.0, 20.0, 34.0), 13.0)  # thenar's base
    palm.add_capsule((2.0, -24.0, 16.0), (1.0, -31.0, 52.0), 12.5)  # hypothenar
    hand.add_palm_site((11.0, -4.0, 64.0))


def make_human20():
    hand = Hand("human20", "Adult male right hand, 20 joints; palm faces +x, fingers +z.", "palm")
    add_palm(hand)
    add_thumb(hand)
    for name, dimensions in FINGERS.items():
        add_finger(hand, name, *dimensions)
    return hand
