"""Closed surfaces of revolution with nearly equilateral triangles, and their signed distance.

A profile is a list of (rho, z) from one pole on the axis to the other, such that the outside is
on its right seen in the half plane (rho to the right, z up).
"""

import math

from . import vectors as v
from .mesh import Mesh, flip_to_delaunay


def smooth_profile(points, steps=24):
    """A dense Catmull-Rom curve through the points; mirrored at the axis, so that it meets it at
    a right angle."""
    first = (-points[1][0], points[1][1])
    last = (-points[-2][0], points[-2][1])
    knots = [first, *points, last]
    curve = []
    for i in range(1, len(knots) - 2):
        p0, p1, p2, p3 = knots[i - 1:i + 3]
        curve.extend(hermite(p0, p1, p2, p3, step / steps) for step in range(steps))
    return [(max(rho, 0.0), z) for rho, z in curve] + [points[-1]]


def hermite(p0, p1, p2, p3, t):
    """Centripetal Catmull-Rom between p1 and p2 (no overshoot where knots lie unevenly)."""
    def step(a, b):
        return math.sqrt(max(math.dist(a, b), 1e-9))

    t1 = step(p0, p1)
    t2 = t1 + step(p1, p2)
    t3 = t2 + step(p2, p3)
    s = t1 + t * (t2 - t1)

    def blend(a, b, ta, tb):
        w = (s - ta) / (tb - ta)
        return tuple(x + w * (y - x) for x, y in zip(a, b))

    a1, a2, a3 = blend(p0, p1, 0.0, t1), blend(p1, p2, t1, t2), blend(p2, p3, t2, t3)
    return blend(blend(a1, a2, 0.0, t2), blend(a2, a3, t1, t3), t1, t2)


def ring_places(curve, edge, least_edge):
    """Places of the rings along the curve: `edge` apart where it is straight, closer where it
    turns."""
    density = [0.0]
    for i in range(1, len(curve)):
        length = math.dist(curve[i - 1], curve[i])
        bend = turn_at(curve, i)
        density.append(density[-1] + length / min(edge, max(least_edge, 0.8 * bend)))
    count = max(3, round(density[-1]))
    places, i = [], 1
    for k in range(1, count):
        target = density[-1] * k / count
        while density[i] < target:
            i += 1
        t = (target - density[i - 1]) / (density[i] - density[i - 1])
        (r0, z0), (r1, z1) = curve[i - 1], curve[i]
        places.append((r0 + t * (r1 - r0), z0 + t * (z1 - z0)))
    return places


def turn_at(curve, i):
    """Radius of curvature around the segment before point i."""
    a, b = curve[max(i - 4, 0)], curve[min(i + 3, len(curve) - 1)]
    m = curve[i]
    u = math.atan2(m[1] - a[1], m[0] - a[0])
    w = math.atan2(b[1] - m[1], b[0] - m[0])
    turned = abs(math.remainder(w - u, 2.0 * math.pi))
    return 0.5 * (math.dist(a, m) + math.dist(m, b)) / max(turned, 1e-9)


def revolve(curve, edge, least_edge):
    """The mesh of the curve turned about z: rings of vertices about `edge` apart, zipped."""
    vertices, rings = [(0.0, 0.0, curve[0][1])], []
    for k, (rho, z) in enumerate(ring_places(curve, edge, least_edge)):
        count = max(6, round(2.0 * math.pi * rho / edge))
        shift = 0.5 * (k % 2)
        ring = []
        for j in range(count):
            angle = 2.0 * math.pi * (j + shift) / count
            ring.append((len(vertices), angle))
            vertices.append((rho * math.cos(angle), rho * math.sin(angle), z))
        rings.append(ring)
    vertices.append((0.0, 0.0, curve[-1][1]))

    faces = fan(0, rings[0], False) + fan(len(vertices) - 1, rings[-1], True)
    for lower, upper in zip(rings, rings[1:]):
        faces.extend(zipped(lower, upper))
    mesh = Mesh(vertices, faces)
    flip_to_delaunay(mesh)
    return mesh


def fan(pole, ring, top):
    pairs = zip(ring, ring[1:] + ring[:1])
    return [(pole, a, b) if top else (pole, b, a) for (a, _), (b, _) in pairs]


def zipped(lower, upper):
    """Triangles between two rings: advance on the ring whose next vertex comes first."""
    faces, i, j = [], 0, 0
    n, m = len(lower), len(upper)

    def angle(ring, k):
        return ring[k % len(ring)][1] + 2.0 * math.pi * (k // len(ring))

    while i < n or j < m:
        a, b = lower[i % n][0], upper[j % m][0]
        if j == m or (i < n and angle(lower, i + 1) <= angle(upper, j + 1)):
            faces.append((a, lower[(i + 1) % n][0], b))
            i += 1
        else:
            faces.append((a, upper[(j + 1) % m][0], b))
            j += 1
    return faces


class RevolvedSolid:
    """Signed distance to a surface of revolution, tabulated on a grid of its half plane."""

    STEP = 1.0

    def __init__(self, curve):
        self.outline = curve[::4] + [curve[-1]]
        self.table = {}

    def value(self, p):
        rho, z = math.hypot(p[0], p[1]) / self.STEP, p[2] / self.STEP
        i, j = math.floor(rho), math.floor(z)
        s, t = rho - i, z - j
        low = (1.0 - s) * self._node(i, j) + s * self._node(i + 1, j)
        high = (1.0 - s) * self._node(i, j + 1) + s * self._node(i + 1, j + 1)
        return (1.0 - t) * low + t * high

    def _node(self, i, j):
        if (i, j) not in self.table:
            self.table[i, j] = self._distance(i * self.STEP, j * self.STEP)
        return self.table[i, j]

    def _distance(self, rho, z):
        best, inside = math.inf, False
        for (r0, z0), (r1, z1) in zip(self.outline, self.outline[1:]):
            dr, dz = r1 - r0, z1 - z0
            t = ((rho - r0) * dr + (z - z0) * dz) / max(dr * dr + dz * dz, 1e-12)
            t = min(1.0, max(0.0, t))
            best = min(best, math.hypot(rho - r0 - t * dr, z - z0 - t * dz))
            if (z0 > z) != (z1 > z) and rho < r0 + (z - z0) / dz * dr:
                inside = not inside
        return -best if inside else best


def gradient(solid, p, step=0.05):
    """Unit gradient of a solid's signed distance by central differences."""
    g = []
    for k in range(3):
        e = tuple(step if n == k else 0.0 for n in range(3))
        g.append(solid.value(v.add(p, e)) - solid.value(v.sub(p, e)))
    length = v.norm(g)
    return v.scaled(g, 1.0 / length) if length > 1e-12 else (0.0, 0.0, 1.0)
