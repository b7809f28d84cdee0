"""The built-in objects: solids (signed distances, for grasping them) and their meshes."""

import math

from . import vectors as v
from .revolution import RevolvedSolid, revolve, smooth_profile
from .surface_nets import polygonise


class Object:
    """`solid` is what a hand cannot enter: a glass counts as full."""

    def __init__(self, name, summary, solid, mesh, genus):
        self.name = name
        self.summary = summary
        self.solid = solid
        self.mesh = mesh
        mesh.check(genus)


# === Box
class RoundedBox:
    def __init__(self, size, radius):
        self.inner = tuple(0.5 * s - radius for s in size)
        self.radius = radius

    def value(self, p):
        q = tuple(abs(x) - h for x, h in zip(p, self.inner))
        outside = v.norm(tuple(max(x, 0.0) for x in q))
        return outside + min(max(q), 0.0) - self.radius


def make_box():
    solid = RoundedBox((65.0, 40.0, 160.0), 6.0)
    margin = 4.0
    high = (32.5 + margin, 20.0 + margin, 80.0 + margin)
    mesh = polygonise(solid, v.scaled(high, -1.0), high, 2.8)
    return Object("box", "box with rounded edges, 65 x 40 x 160 mm", solid, mesh, 0)


# === Lemon
LEMON = [(0.0, -38.0), (3.4, -37.3), (5.6, -35.7), (8.8, -33.6), (14.4, -30.4), (21.6, -25.0),
         (26.8, -17.8), (29.3, -9.4), (29.9, 0.0), (29.3, 9.2), (27.0, 17.4), (21.9, 24.6),
         (14.6, 30.2), (8.9, 33.4), (5.8, 35.4), (3.6, 37.3), (0.0, 38.0)]


def make_lemon():
    curve = smooth_profile(LEMON)
    return Object("lemon", "lemon, 60 mm across, 76 mm long", RevolvedSolid(curve),
                  revolve(curve, 1.9, 1.0), 0)


# === Wine glass
WINE_GLASS = [
    # foot: underside, rim, upper side
    (0.0, 1.6), (12.0, 1.2), (24.0, 0.5), (31.5, 0.0), (33.6, 1.1), (31.5, 2.4), (20.0, 4.6),
    (10.0, 7.4), (5.8, 12.5),
    # stem
    (4.3, 22.0), (3.9, 40.0), (3.8, 60.0), (4.0, 78.0), (5.2, 88.0),
    # bowl: outer wall, lip, inner wall
    (10.5, 95.5), (21.0, 104.0), (30.5, 117.0), (35.2, 133.0), (36.0, 148.0), (34.2, 168.0),
    (31.8, 186.0), (30.2, 198.0), (29.1, 200.0), (27.8, 198.0), (29.3, 186.0), (31.7, 168.0),
    (33.4, 148.0), (32.6, 134.0), (28.2, 119.5), (19.5, 107.8), (9.5, 101.2), (0.0, 98.8),
]


def make_wine_glass():
    curve = smooth_profile(WINE_GLASS)
    lip = max(range(len(WINE_GLASS)), key=lambda k: WINE_GLASS[k][1])
    filled = smooth_profile(WINE_GLASS[:lip + 1]) + [(0.0, WINE_GLASS[lip][1])]
    return Object("wine_glass", "wine glass, 200 mm tall, bowl 72 mm wide", RevolvedSolid(filled),
                  revolve(curve, 2.9, 1.1), 0)


# === Scissors
def distance_to_segment(x, y, a, b):
    """Distance in the plane to the segment a-b, and the place along it in [0, 1]."""
    dx, dy = b[0] - a[0], b[1] - a[1]
    length2 = dx * dx + dy * dy
    t = ((x - a[0]) * dx + (y - a[1]) * dy) / length2 if length2 > 0.0 else 0.0
    t = min(1.0, max(0.0, t))
    return math.hypot(x - a[0] - t * dx, y - a[1] - t * dy), t


def tapered(a, b, ra, rb):
    """A bar in the plane from a to b, of half width ra there and rb here."""
    def outline(x, y):
        d, t = distance_to_segment(x, y, a, b)
        return d - (ra + t * (rb - ra))
    return outline


def ring(centre, angle, straight, inner_radius, band):
    """A racetrack-shaped ring: two half circles of `inner_radius` joined by straights."""
    c, s = math.cos(angle), math.sin(angle)
    a = (centre[0] - 0.5 * straight * c, centre[1] - 0.5 * straight * s)
    b = (centre[0] + 0.5 * straight * c, centre[1] + 0.5 * straight * s)
    middle = inner_radius + 0.5 * band

    def outline(x, y):
        return abs(distance_to_segment(x, y, a, b)[0] - middle) - 0.5 * band
    return outline


def plate(outline, half_thickness, rounding):
    """The outline made solid between -half_thickness and half_thickness, its rims rounded."""
    def value(p):
        u = outline(p[0], p[1]) + rounding
        w = abs(p[2]) - half_thickness + rounding
        return min(max(u, w), 0.0) + math.hypot(max(u, 0.0), max(w, 0.0)) - rounding
    return value


class SmoothUnion:
    """Union with fillets about `blend` wide (polynomial smooth minimum)."""

    def __init__(self, parts, blend):
        self.parts = parts
        self.blend = blend

    def value(self, p):
        total = self.parts[0](p)
        for part in self.parts[1:]:
            d = part(p)
            h = max(self.blend - abs(total - d), 0.0) / self.blend
            total = min(total, d) - 0.25 * h * h * self.blend
        return total


# Inside of the rings: the thumb's 23 x 32 mm, the fingers' 23 x 43 mm.
THUMB_RING = ((-58.0, 21.5), 0.12, 9.0, 11.5, 6.0)
FINGER_RING = ((-60.0, -21.5), -0.06, 20.0, 11.5, 6.0)


def make_scissors():
    solid = SmoothUnion([
        plate(tapered((2.0, 2.4), (92.5, 0.5), 6.2, 2.3), 2.5, 1.2),
        plate(tapered((2.0, -2.4), (90.0, -0.6), 6.2, 2.3), 2.5, 1.2),
        plate(tapered((0.0, 0.0), (3.0, 0.0), 6.0, 6.0), 3.8, 1.6),
        plate(tapered((0.0, 1.5), (-38.0, 16.5), 5.4, 4.2), 3.6, 2.4),
        plate(tapered((0.0, -1.5), (-36.0, -16.5), 5.4, 4.2), 3.6, 2.4),
        plate(ring(*THUMB_RING), 5.6, 2.8),
        plate(ring(*FINGER_RING), 5.6, 2.8),
    ], 3.0)
    mesh = polygonise(solid, (-98.0, -45.0, -9.0), (98.0, 45.0, 9.0), 2.1)
    return Object("scissors", "scissors, 182 mm long, two finger rings", solid, mesh, 2)


def make_objects():
    return [make_box(), make_lemon(), make_wine_glass(), make_scissors()]
