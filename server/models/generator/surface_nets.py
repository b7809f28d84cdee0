"""Meshes of implicit surfaces: surface nets (Gibson 1998), then relaxed on the surface.

One vertex per grid cell that the surface crosses, one quad per crossed grid edge. Every part of
the solid, and every gap, must be about two cells wide: then no cell sees two sheets, and the mesh
is manifold (`Mesh.check` proves it).
"""

import math

from . import vectors as v
from .mesh import Mesh, flip_to_delaunay
from .revolution import gradient

CORNERS = [(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)]
EDGES = [(a, b) for a in CORNERS for b in CORNERS if a < b and sum(map(abs, v.sub(a, b))) == 1]


def polygonise(solid, low, high, cell, relaxations=6):
    """The surface value = 0 of `solid` inside the box low..high."""
    values = sample(solid, low, high, cell)
    mesh = net(values, low, cell)
    for _ in range(relaxations):
        relax(mesh, solid)
        flip_to_delaunay(mesh)
    return mesh


def sample(solid, low, high, cell):
    counts = [math.ceil((h - l) / cell) + 1 for l, h in zip(low, high)]
    values = {}
    for i in range(counts[0]):
        for j in range(counts[1]):
            for k in range(counts[2]):
                p = (low[0] + i * cell, low[1] + j * cell, low[2] + k * cell)
                values[i, j, k] = solid.value(p)
    return values


def net(values, low, cell):
    vertices, cells = [], {}
    for corner in sorted(values):
        crossing = cell_vertex(values, corner)
        if crossing is not None:
            cells[corner] = len(vertices)
            vertices.append(v.add(low, v.scaled(v.add(corner, crossing), cell)))
    faces = []
    for corner in sorted(values):
        for axis in range(3):
            faces.extend(edge_quad(values, cells, corner, axis))
    mesh = Mesh(vertices, faces)
    return mesh


def cell_vertex(values, corner):
    """Mean of the crossings of a cell's edges, in units of the cell; None if there is none."""
    try:
        inside = {c: values[corner[0] + c[0], corner[1] + c[1], corner[2] + c[2]]
                  for c in CORNERS}
    except KeyError:
        return None
    total, count = (0.0, 0.0, 0.0), 0
    for a, b in EDGES:
        fa, fb = inside[a], inside[b]
        if (fa < 0.0) != (fb < 0.0):
            total = v.add(total, v.mix(a, b, fa / (fa - fb)))
            count += 1
    return v.scaled(total, 1.0 / count) if count else None


def edge_quad(values, cells, corner, axis):
    """Two triangles around the grid edge that leaves `corner` along `axis`, if it is crossed."""
    tip = tuple(c + (n == axis) for n, c in enumerate(corner))
    if tip not in values or (values[corner] < 0.0) == (values[tip] < 0.0):
        return []
    u, w = (axis + 1) % 3, (axis + 2) % 3

    def around(du, dw):
        shifted = list(corner)
        shifted[u] -= du
        shifted[w] -= dw
        return cells[tuple(shifted)]

    quad = [around(1, 1), around(0, 1), around(0, 0), around(1, 0)]
    if values[corner] >= 0.0:
        quad.reverse()
    a, b, c, d = quad
    return [(a, b, c), (a, c, d)]


def relax(mesh, solid):
    """Moves every vertex to the mean of its neighbours, along the surface, and back onto it."""
    normals = mesh.vertex_normals()
    old = mesh.vertices
    moved = []
    for p, n, around in zip(old, normals, mesh.neighbours()):
        mean = v.scaled(tuple(map(sum, zip(*(old[j] for j in around)))), 1.0 / len(around))
        step = v.sub(mean, p)
        moved.append(onto(solid, v.add(p, along_surface(step, n))))
    mesh.vertices = moved


def along_surface(step, normal):
    return v.along(step, normal, -v.dot(step, normal))


def onto(solid, p):
    """The nearest place on the surface, by Newton steps along the gradient."""
    for _ in range(2):
        p = v.along(p, gradient(solid, p), -solid.value(p))
    return p
