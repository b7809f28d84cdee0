"""Triangle meshes as lists: checks, edge flips, OBJ text. Millimetres; faces counter-clockwise
seen from outside."""

import math

from . import vectors as v
from .urdf import metres


class Mesh:
    def __init__(self, vertices, faces):
        self.vertices = vertices
        self.faces = faces

    def neighbours(self):
        """Sorted neighbours of every vertex."""
        around = [set() for _ in self.vertices]
        for a, b, c in self.faces:
            around[a].update((b, c))
            around[b].update((a, c))
            around[c].update((a, b))
        return [sorted(s) for s in around]

    def face_normal(self, face):
        a, b, c = (self.vertices[i] for i in face)
        return v.cross(v.sub(b, a), v.sub(c, a))

    def vertex_normals(self):
        """Area-weighted unit normals."""
        sums = [(0.0, 0.0, 0.0)] * len(self.vertices)
        for face in self.faces:
            n = self.face_normal(face)
            for i in face:
                sums[i] = v.add(sums[i], n)
        return [v.unit(n) for n in sums]

    def halfedges(self):
        """(from, to) -> the face's third corner. Fails if an edge has two faces on one side."""
        opposite = {}
        for a, b, c in self.faces:
            for i, j, k in ((a, b, c), (b, c, a), (c, a, b)):
                if (i, j) in opposite:
                    raise ValueError(f"edge {i}-{j} is not manifold")
                opposite[i, j] = k
        return opposite

    def volume(self):
        return sum(v.dot(self.vertices[a], v.cross(self.vertices[b], self.vertices[c]))
                   for a, b, c in self.faces) / 6.0

    def check(self, genus):
        """Closed, manifold, one component, outward, of the genus that is expected."""
        opposite = self.halfedges()
        if any((j, i) not in opposite for i, j in opposite):
            raise ValueError("the mesh is not closed")
        euler = len(self.vertices) - len(opposite) // 2 + len(self.faces)
        if euler != 2 - 2 * genus:
            raise ValueError(f"Euler characteristic {euler}, expected {2 - 2 * genus}")
        if len(reached(self.neighbours(), 0)) != len(self.vertices):
            raise ValueError("the mesh has several components")
        if self.volume() <= 0.0:
            raise ValueError("the faces look inwards")

    def obj_text(self, name, summary):
        lines = [f"# {name}: {summary}", "# Metres. Written by make_library.py.", f"o {name}"]
        lines.extend(f"v {metres(p)}" for p in self.vertices)
        lines.extend(f"f {a + 1} {b + 1} {c + 1}" for a, b, c in self.faces)
        return "\n".join(lines) + "\n"


def reached(neighbours, start):
    found, front = {start}, [start]
    while front:
        for j in neighbours[front.pop()]:
            if j not in found:
                found.add(j)
                front.append(j)
    return found


def corner_angle(p, a, b):
    """The angle at p between a and b."""
    u, w = v.sub(a, p), v.sub(b, p)
    return math.atan2(v.norm(v.cross(u, w)), v.dot(u, w))


def flip_to_delaunay(mesh, most_bend=0.6):
    """Flips edges whose opposite angles exceed pi, where the surface bends less than
    `most_bend` rad; several passes over all edges in a fixed order."""
    faces = {}
    for a, b, c in mesh.faces:
        for i, j, k in ((a, b, c), (b, c, a), (c, a, b)):
            faces[i, j] = k
    for _ in range(6):
        flips = 0
        for i, j in sorted(faces):
            if (i, j) in faces and i < j and should_flip(mesh, faces, i, j, most_bend):
                flip(faces, i, j)
                flips += 1
        if flips == 0:
            break
    mesh.faces = sorted({tuple_from_least(i, j, k) for (i, j), k in faces.items()})


def tuple_from_least(i, j, k):
    if i < j and i < k:
        return (i, j, k)
    return (j, k, i) if j < k else (k, i, j)


def should_flip(mesh, faces, i, j, most_bend):
    k, m = faces[i, j], faces[j, i]
    if (k, m) in faces or (m, k) in faces:
        return False
    p = mesh.vertices
    angles = corner_angle(p[k], p[i], p[j]) + corner_angle(p[m], p[i], p[j])
    if angles <= math.pi + 1e-9:
        return False
    n1 = v.unit(mesh.face_normal((i, j, k)))
    n2 = v.unit(mesh.face_normal((j, i, m)))
    return v.dot(n1, n2) > math.cos(most_bend)


def flip(faces, i, j):
    """Edge i-j between corners k, m becomes k-m."""
    k, m = faces.pop((i, j)), faces.pop((j, i))
    for a, b, c in ((i, m, k), (m, j, k)):
        faces[a, b], faces[b, c], faces[c, a] = c, a, b
