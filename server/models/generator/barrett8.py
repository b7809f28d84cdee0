"""`barrett8`: a Barrett-class gripper: three fingers, two of which spread about the palm.

Kinematic facts (25 mm and 50 mm base offsets, 70 mm and 58 mm links, ranges of 180, 140 and 48
degrees, outer links bent by 40 degrees at rest) are those published for the BarrettHand. Its
outer joints break away from the inner ones; here they are joints of their own, since a pose does
not tell in which order the fingers closed.

The fingers stand around a round palm that faces +x: `index` (+y) and `middle` (-y) along +z at
zero spread, `thumb` opposite to them along -z.
"""

import math

from . import vectors as v
from .hand import FLEXION, Hand

EFFORT = 2.0
VELOCITY = 2.4
PALM_HEIGHT = 76.0
PALM_RADIUS = 45.0
SPREAD_OFFSET = 25.0
KNUCKLE = 50.0
PROXIMAL, DISTAL = 70.0, 58.0
DEPTH, WIDTH = 17.0, 24.0
REST_BEND = math.radians(40.0)
LIMITS = {"spread": (0.0, math.pi), "proximal": (0.0, 2.44), "distal": (0.0, 0.84)}


def add_segment(link, length):
    """A block between two rounded ends."""
    half = 0.5 * WIDTH
    for z in (0.0, length):
        link.add_cylinder((0.0, -half, z), (0.0, half, z), 0.5 * DEPTH)
    link.add_box((0.0, 0.0, 0.5 * length), (DEPTH, WIDTH, length))


def add_finger(hand, name, parent, knuckle):
    """Inner and outer link; `knuckle` is the pose of the inner joint in the parent."""
    proximal = hand.add_link(f"{name}_proximal", parent, f"{name}_proximal_flex", knuckle, FLEXION,
                             LIMITS["proximal"], EFFORT, VELOCITY)
    add_segment(proximal, PROXIMAL)
    bend = (v.turn(FLEXION, REST_BEND), (0.0, 0.0, PROXIMAL))
    distal = hand.add_link(f"{name}_distal", proximal.name, f"{name}_distal_flex", bend, FLEXION,
                           LIMITS["distal"], EFFORT, VELOCITY)
    add_segment(distal, DISTAL - 0.5 * DEPTH)
    hand.add_pad(name, distal.name, (0.0, 0.0, 40.0), 0.5 * DEPTH)


def add_spreading_finger(hand, name, side):
    """`side` is +1 for the finger at +y, -1 for the one at -y; spread turns it outwards."""
    place = (PALM_HEIGHT, side * SPREAD_OFFSET, 0.0)
    base = hand.add_link(f"{name}_base", "palm", f"{name}_spread", place, (-side, 0.0, 0.0),
                         LIMITS["spread"], EFFORT, VELOCITY)
    base.add_box((-6.0, 0.0, 0.5 * KNUCKLE), (10.0, WIDTH - 4.0, KNUCKLE))
    base.add_cylinder((-20.0, 0.0, 0.0), (-1.0, 0.0, 0.0), 13.0)
    add_finger(hand, name, base.name, (v.IDENTITY, (0.0, 0.0, KNUCKLE)))


def make_barrett8():
    hand = Hand("barrett8", "Barrett-class hand, 8 joints; palm faces +x.", "palm")
    hand.root.add_cylinder((0.0, 0.0, 0.0), (PALM_HEIGHT, 0.0, 0.0), PALM_RADIUS)
    hand.root.add_box((PALM_HEIGHT - 8.0, 0.0, -0.5 * KNUCKLE), (14.0, WIDTH - 4.0, KNUCKLE))
    about_x = ((1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 0.0, -1.0))
    add_finger(hand, "thumb", "palm", (about_x, (PALM_HEIGHT, 0.0, -KNUCKLE)))
    add_spreading_finger(hand, "index", 1.0)
    add_spreading_finger(hand, "middle", -1.0)
    hand.add_palm_site((PALM_HEIGHT, 0.0, 0.0))
    return hand
