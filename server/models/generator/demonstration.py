"""A grasp demonstrated by a hand of the library: from a rough pose, pads pressed onto the object.

The pose is the least-squares balance of: pads on the surface, normals opposed, pads near the
places named in `grasps.py`, no link inside the object or inside another digit, joints near the
rough posture and within their limits. So every contact set is one that a hand has reached.
"""

import math

from . import vectors as v
from .linear import minimise
from .revolution import gradient

DISTANCE = 1.0  # per mm between pad and surface
NORMAL = 6.0  # per unit of n_pad + n_object
PLACE = 0.15  # per mm from the place asked for
INSIDE = 0.7  # per mm of a link inside the object
ALONG = 3.0  # per unit between the pad's direction and the one asked for
DIGITS = 0.4  # per mm of a digit inside another
POSTURE = 1.2  # per rad from the rough posture
SLACK = 0.3  # mm that flesh gives way
NEIGHBOURS = (("thumb", "index"), ("thumb", "middle"), ("index", "middle"), ("middle", "ring"),
              ("ring", "little"))


class Touch:
    """A site that touches the object near `place` (object's frame, mm), if need be with its
    direction to the wrist along `direction`."""

    def __init__(self, site, place, direction=None):
        self.site = site
        self.place = place
        self.direction = direction


class Grasp:
    """A rough pose: where the palm looks and the fingers point, a posture, the touches."""

    def __init__(self, origin, palm, fingers, posture, touches):
        self.rotation = v.frame(fingers, palm)
        self.origin = origin
        self.posture = posture
        self.touches = touches


def body_spheres(hand):
    """Spheres that fill the links: (link, centre, radius), a few millimetres apart."""
    spheres = []
    for link in hand.links:
        for shape in link.shapes:
            spheres.extend((link.name, centre, radius) for centre, radius in fill(shape))
    return spheres


def fill(shape):
    R, p = shape.pose
    if shape.kind == "sphere":
        return [(p, shape.size[0])]
    if shape.kind == "cylinder":
        radius, length = shape.size
        count = max(1, math.ceil(length / 7.0))
        axis = v.rotate(R, (0.0, 0.0, 1.0))
        return [(v.along(p, axis, length * ((k + 0.5) / count - 0.5)), radius)
                for k in range(count)]
    radius = 4.0  # of a box, its palmar face alone
    counts = [max(1, round(s / 10.0)) for s in shape.size[1:]]
    return [(v.add(p, (0.5 * shape.size[0] - radius, shape.size[1] * ((i + 0.5) / counts[0] - 0.5),
                       shape.size[2] * ((j + 0.5) / counts[1] - 0.5))), radius)
            for i in range(counts[0]) for j in range(counts[1])]


class Demonstration:
    """The balance of one grasp, as residuals of (rotation increment, position, joints)."""

    def __init__(self, hand, solid, grasp):
        self.hand = hand
        self.solid = solid
        self.grasp = grasp
        self.rough = [grasp.posture.get(joint.name, 0.0) for joint in hand.joints]
        self.spheres = body_spheres(hand)
        self.digits = {}
        for name, centre, radius in self.spheres:
            if name != hand.root.name and not name.endswith(("_knuckle", "_base")):
                self.digits.setdefault(name.split("_")[0], []).append((name, centre, radius))

    def pose(self, x):
        return (v.product(v.turn_by(tuple(x[:3])), self.grasp.rotation), tuple(x[3:6]))

    def residuals(self, x):
        poses = self.hand.link_poses(self.pose(x), x[6:])
        terms = []
        for touch in self.grasp.touches:
            terms.extend(self.touch_terms(poses, touch))
        for name, centre, radius in self.spheres:
            depth = radius - SLACK - self.solid.value(v.apply(poses[name], centre))
            terms.append(INSIDE * max(depth, 0.0))
        terms.extend(self.digit_terms(poses))
        terms.extend(POSTURE * (q - r) for q, r in zip(x[6:], self.rough))
        return terms

    def touch_terms(self, poses, touch):
        site = self.hand.site(touch.site)
        X = poses[site.link]
        p = v.apply(X, site.point)
        n = v.add(v.rotate(X[0], site.normal), gradient(self.solid, p))
        terms = [DISTANCE * self.solid.value(p), *v.scaled(n, NORMAL),
                 *v.scaled(v.sub(p, touch.place), PLACE)]
        if touch.direction is not None:
            off = v.sub(v.rotate(X[0], site.direction), touch.direction)
            terms.extend(v.scaled(off, ALONG))
        return terms

    def digit_terms(self, poses):
        placed = {digit: [(v.apply(poses[name], c), r) for name, c, r in spheres]
                  for digit, spheres in self.digits.items()}
        for one, other in NEIGHBOURS:
            if one not in placed or other not in placed:
                continue
            for (px, py, pz), r in placed[one]:
                for (qx, qy, qz), s in placed[other]:
                    reach = r + s - 1.0
                    gap2 = (px - qx) ** 2 + (py - qy) ** 2 + (pz - qz) ** 2
                    yield DIGITS * (reach - math.sqrt(gap2)) if gap2 < reach * reach else 0.0

    def solve(self, iterations=60):
        """Link poses by name in the object's frame, and joint angles."""
        lower = [-math.inf] * 6 + [joint.lower for joint in self.hand.joints]
        upper = [math.inf] * 6 + [joint.upper for joint in self.hand.joints]
        x = [0.0, 0.0, 0.0, *self.grasp.origin, *self.rough]
        x = [min(h, max(l, s)) for l, s, h in zip(lower, x, upper)]
        x, self.cost = minimise(self.residuals, x, lower, upper, iterations)
        return self.hand.link_poses(self.pose(x), x[6:]), x[6:]
