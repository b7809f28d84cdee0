"""Patches on a mesh: log coordinates about a root, an outline, the loop of vertices around it."""

import heapq
import math

from . import vectors as v


class Outline:
    """An oval of radii `length` (along the direction to the wrist) and `width` mm, uneven by
    `lean` (one side fuller) and `wave` (three lobes), turned by `phase`: no contact is an
    ellipse."""

    def __init__(self, length, width, lean=0.08, wave=0.05, phase=0.0):
        self.length = length
        self.width = width
        self.lean = lean
        self.wave = wave
        self.phase = phase

    def radius(self, angle):
        oval = 1.0 / math.hypot(math.cos(angle) / self.length, math.sin(angle) / self.width)
        uneven = self.lean * math.cos(angle - self.phase)
        return oval * (1.0 + uneven + self.wave * math.sin(3.0 * angle + self.phase))


def log_coordinates(mesh, normals, neighbours, root, direction, radius):
    """Vertex -> (u, v) in the root's tangent plane, x along `direction`, up to `radius`.

    A discrete exponential map (Schmidt, Grimm & Wyvill 2006): Dijkstra's order, each vertex the
    mean over its settled neighbours of their coordinates plus the edge, turned by the rotation
    that carries normal to normal.
    """
    x = v.tangent(direction, normals[root])
    settled, frames = {root: (0.0, 0.0)}, {root: x}
    reach = {root: 0.0}
    front = [(v.distance(mesh.vertices[root], mesh.vertices[j]), j, root)
             for j in neighbours[root]]
    heapq.heapify(front)
    while front:
        _, i, parent = heapq.heappop(front)
        if i in settled:
            continue
        near = [j for j in neighbours[i] if j in settled]
        guesses = [unrolled(mesh, normals, settled[j], frames[j], j, i) for j in near]
        uv = tuple(sum(g[k] for g in guesses) / len(guesses) for k in range(2))
        if math.hypot(*uv) > radius:
            continue
        settled[i] = uv
        frames[i] = v.tangent(carried(frames[parent], normals[parent], normals[i]), normals[i])
        reach[i] = math.hypot(*uv)
        for j in neighbours[i]:
            if j not in settled:
                step = v.distance(mesh.vertices[i], mesh.vertices[j])
                heapq.heappush(front, (reach[i] + step, j, i))
    return settled


def carried(vector, n_from, n_to):
    """`vector` turned by the least rotation that takes one unit normal to the other."""
    axis = v.cross(n_from, n_to)
    length = v.norm(axis)
    if length < 1e-12:
        return vector
    angle = math.atan2(length, v.dot(n_from, n_to))
    return v.rotate(v.turn(v.scaled(axis, 1.0 / length), angle), vector)


def unrolled(mesh, normals, uv, x, j, i):
    """Coordinates of i by its edge from j, whose own are `uv` in the frame x, n x x."""
    edge = v.sub(mesh.vertices[i], mesh.vertices[j])
    y = v.cross(normals[j], x)
    a, b = v.dot(edge, x), v.dot(edge, y)
    flat = max(math.hypot(a, b), 1e-9)
    stretch = v.norm(edge) / flat
    return (uv[0] + a * stretch, uv[1] + b * stretch)


def inside_outline(coordinates, outline):
    return {i for i, (a, b) in coordinates.items()
            if math.hypot(a, b) <= outline.radius(math.atan2(b, a))}


def boundary_loop(mesh, neighbours, region, root):
    """The simple loop around the faces of `region` that hang together with the root.

    Vertices where the loop would pinch are taken out of the region until it does not.
    """
    region = set(region)
    while True:
        faces = connected_faces([f for f in mesh.faces if all(i in region for i in f)], root)
        sides = {(f[k], f[(k + 1) % 3]) for f in faces for k in range(3)}
        rim = sorted((i, j) for i, j in sides if (j, i) not in sides)
        starts = [i for i, _ in rim]
        pinched = {i for i in starts if starts.count(i) > 1}
        if pinched:
            region -= pinched
            continue
        following = dict(rim)
        loop = [min(following)]
        while following[loop[-1]] != loop[0]:
            loop.append(following[loop[-1]])
        if len(loop) != len(rim) or root in loop:
            raise ValueError(f"the patch about vertex {root} has holes or no inside")
        return loop


def connected_faces(faces, root):
    """The faces that are joined through shared edges to the root's."""
    by_side = {}
    for f in faces:
        for k in range(3):
            by_side[f[k], f[(k + 1) % 3]] = f
    front = [f for f in faces if root in f]
    found = set(front)
    while front:
        f = front.pop()
        for k in range(3):
            other = by_side.get((f[(k + 1) % 3], f[k]))
            if other is not None and other not in found:
                found.add(other)
                front.append(other)
    return found


def nearest_vertex(mesh, p):
    return min(range(len(mesh.vertices)), key=lambda i: (v.distance(mesh.vertices[i], p), i))
