"""`allegro16`: an Allegro-class right hand with four big fingers of four joints.

Kinematic facts (segment lengths, offsets, joint ranges, 0.7 N m) are those that the maker of the
Allegro hand publishes; the solids are our own blocks of about the same size.
"""

import math

from . import vectors as v
from .hand import FLEXION, Hand

EFFORT = 0.7
VELOCITY = 7.0
ALONG = (0.0, 0.0, 1.0)
PAD_TILT = math.radians(18.0)

PALM_LENGTH = 95.0
SPACING = 45.0
SPLAY = math.radians(5.0)
KNUCKLE = 16.4  # from the spread joint to the first flexion
LENGTHS = (54.0, 38.4, 43.7)  # proximal, middle, distal with its tip
DEPTH, WIDTH = 19.6, 27.5
TIP_RADIUS = 12.0

FINGER_LIMITS = ((-0.47, 0.47), (-0.196, 1.61), (-0.174, 1.709), (-0.227, 1.618))
THUMB_LIMITS = ((0.263, 1.396), (-0.105, 1.163), (-0.189, 1.644), (-0.162, 1.719))
THUMB_BASE = (-18.2, 19.3, PALM_LENGTH - 46.0)
THUMB_OFFSET = (-27.0, 5.0, 39.9)
THUMB_LENGTHS = (17.7, 51.4, 54.3)


def add_block(link, length, start=0.0):
    link.add_box((0.0, 0.0, 0.5 * (start + length)), (DEPTH, WIDTH, length - start))


def add_hinge(link):
    """The rounded end of a block: a cylinder about the flexion axis."""
    half = 0.5 * WIDTH
    link.add_cylinder((0.0, -half, 0.0), (0.0, half, 0.0), 0.5 * DEPTH)


def add_tip(hand, site, link, length):
    """Block, round rubber tip and the pad on it."""
    centre = (0.0, 0.0, length - TIP_RADIUS)
    add_hinge(link)
    add_block(link, centre[2] - 6.0)
    link.add_cylinder((0.0, 0.0, centre[2] - 10.0), centre, TIP_RADIUS)
    link.add_sphere(centre, TIP_RADIUS)
    hand.add_pad(site, link.name, centre, TIP_RADIUS, PAD_TILT)


def add_finger(hand, name, y, splay):
    place = (v.turn((1.0, 0.0, 0.0), -splay), (0.0, y, PALM_LENGTH))
    spread = hand.add_link(f"{name}_base", "palm", f"{name}_spread", place, ALONG,
                           FINGER_LIMITS[0], EFFORT, VELOCITY)
    add_block(spread, KNUCKLE, -4.0)
    parent, offset = spread.name, (0.0, 0.0, KNUCKLE)
    for part, length, limits in zip(("proximal", "middle", "distal"), LENGTHS,
                                    FINGER_LIMITS[1:]):
        link = hand.add_link(f"{name}_{part}", parent, f"{name}_{part}_flex", offset, FLEXION,
                             limits, EFFORT, VELOCITY)
        if part == "distal":
            add_tip(hand, name, link, length)
        else:
            add_hinge(link)
            add_block(link, length)
        parent, offset = link.name, (0.0, 0.0, length)


def add_thumb(hand):
    """Opposition about the hand's z axis, a roll about the thumb, two flexions."""
    R = v.frame((0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    base = hand.add_link("thumb_base", "palm", "thumb_opposition", (R, THUMB_BASE),
                         v.rotate_back(R, (0.0, 0.0, -1.0)), THUMB_LIMITS[0], EFFORT, VELOCITY)
    base.add_box((-13.5, 2.5, 18.0), (46.0, 24.0, 42.0))
    roll = hand.add_link("thumb_roll", base.name, "thumb_roll_twist", THUMB_OFFSET, ALONG,
                         THUMB_LIMITS[1], EFFORT, VELOCITY)
    add_block(roll, THUMB_LENGTHS[0], -2.0)
    proximal = hand.add_link("thumb_proximal", roll.name, "thumb_proximal_flex",
                             (0.0, 0.0, THUMB_LENGTHS[0]), FLEXION, THUMB_LIMITS[2], EFFORT,
                             VELOCITY)
    add_hinge(proximal)
    add_block(proximal, THUMB_LENGTHS[1])
    distal = hand.add_link("thumb_distal", proximal.name, "thumb_distal_flex",
                           (0.0, 0.0, THUMB_LENGTHS[1]), FLEXION, THUMB_LIMITS[3], EFFORT,
                           VELOCITY)
    add_tip(hand, "thumb", distal, THUMB_LENGTHS[2])


def make_allegro16():
    hand = Hand("allegro16", "Allegro-class right hand, 16 joints; palm faces +x, fingers +z.",
                "palm")
    # The lower block leaves the room in which the thumb's base turns.
    hand.root.add_box((-9.0, 0.0, 72.5), (40.0, 113.0, 45.0))
    hand.root.add_box((-9.0, -22.0, 27.5), (40.0, 69.0, 55.0))
    hand.add_palm_site((11.0, -14.0, 58.0))
    add_thumb(hand)
    add_finger(hand, "index", SPACING, SPLAY)
    add_finger(hand, "middle", 0.0, 0.0)
    add_finger(hand, "ring", -SPACING, -SPLAY)
    return hand
