"""`tendon16`: a tendon-driven right-hand prosthesis, printed in one piece, with 16 joints.

A design of our own in the manner of the paper's (section IV-F): each finger bends at three
creases and cannot spread, the thumb turns about its base and bends at three creases. The soft
creases give way backwards, hence the negative lower limits (paper, Fig. 8).
"""

import math

from . import vectors as v
from .hand import FLEXION, Hand

EFFORT = 0.8  # N m, a monofilament tendon at 8 mm from the crease
VELOCITY = 5.0
HYPEREXTENSION = -0.3
CREASE_LIMITS = ((HYPEREXTENSION, 1.57), (HYPEREXTENSION, 1.75), (HYPEREXTENSION, 1.40))
PAD_TILT = math.radians(18.0)
TIP_RADIUS = 7.0
DEPTH, WIDTH = 12.0, 13.5

# name: first crease in the palm's frame, splay towards the thumb's side, lengths of the links
FINGERS = {
    "index": ((2.0, 30.0, 92.0), math.radians(4.0), (42.0, 27.0, 25.0)),
    "middle": ((2.0, 9.0, 96.0), math.radians(1.0), (46.0, 30.0, 26.0)),
    "ring": ((2.0, -12.0, 92.0), math.radians(-3.0), (43.0, 28.0, 25.0)),
    "little": ((2.0, -32.0, 84.0), math.radians(-7.0), (36.0, 22.0, 24.0)),
}

THUMB_BASE = (8.0, 28.0, 20.0)
THUMB_ALONG = (0.18, 0.68, 0.71)
THUMB_PAD = (-0.18, -0.68, 0.71)
THUMB_LENGTHS = (44.0, 36.0, 29.0)
OPPOSITION_LIMITS = (-0.20, 1.75)


def add_segment(link, length, depth, width):
    """A printed segment: a slender bar and the round stock of the crease it hangs on."""
    link.add_cylinder((0.0, -0.5 * width, 0.0), (0.0, 0.5 * width, 0.0), 0.5 * depth)
    link.add_box((0.0, 0.0, 0.5 * length), (depth, width, length))


def add_tip(hand, site, link, length):
    """The last segment, round, with its pad."""
    centre = (0.0, 0.0, length - TIP_RADIUS)
    link.add_cylinder((0.0, -0.5 * WIDTH, 0.0), (0.0, 0.5 * WIDTH, 0.0), 0.5 * DEPTH)
    link.add_cylinder((0.0, 0.0, 0.0), centre, TIP_RADIUS)
    link.add_sphere(centre, TIP_RADIUS)
    hand.add_pad(site, link.name, centre, TIP_RADIUS, PAD_TILT)


def add_creased_digit(hand, name, parent, place, lengths, scale=1.0):
    """Three segments at three creases."""
    for part, length, limits in zip(("proximal", "middle", "distal"), lengths, CREASE_LIMITS):
        link = hand.add_link(f"{name}_{part}", parent, f"{name}_{part}_crease", place, FLEXION,
                             limits, EFFORT, VELOCITY)
        if part == "distal":
            add_tip(hand, name, link, length)
        else:
            add_segment(link, length, scale * DEPTH, scale * WIDTH)
        parent, place = link.name, (0.0, 0.0, length)


def add_thumb(hand):
    R = v.frame(THUMB_ALONG, THUMB_PAD)
    base = hand.add_link("thumb_base", "palm", "thumb_opposition", (R, THUMB_BASE),
                         v.rotate_back(R, (0.0, 0.0, -1.0)), OPPOSITION_LIMITS, EFFORT, VELOCITY)
    base.add_sphere((0.0, 0.0, 0.0), 10.0)
    add_creased_digit(hand, "thumb", base.name, (0.0, 0.0, 0.0), THUMB_LENGTHS, 1.2)


def add_palm(hand):
    palm = hand.root
    palm.add_box((0.0, 0.0, 50.0), (18.0, 68.0, 76.0))
    palm.add_cylinder((0.0, 0.0, -2.0), (0.0, 0.0, 16.0), 22.0)  # socket of the wrist
    for knuckle, splay, _ in FINGERS.values():
        R = v.turn((1.0, 0.0, 0.0), -splay)
        root = v.along(knuckle, v.rotate(R, (0.0, 0.0, 1.0)), -16.0)
        palm.add_capsule(root, knuckle, 7.5)
    hand.add_palm_site((9.0, -3.0, 58.0))


def make_tendon16():
    hand = Hand("tendon16",
                "Tendon-driven right-hand prosthesis, 16 joints; palm faces +x, fingers +z.",
                "palm")
    add_palm(hand)
    add_thumb(hand)
    for name, (knuckle, splay, lengths) in FINGERS.items():
        place = (v.turn((1.0, 0.0, 0.0), -splay), knuckle)
        add_creased_digit(hand, name, "palm", place, lengths)
    return hand
