#!/usr/bin/env python3
"""Writes the seeds of the fuzz targets: make_corpus.py OBJECTS_DIR CORPUS_DIR

mesh_file/: pieces of the shipped objects and small solids in every format and encoding, behind
the byte that names the format. raw_mesh/: the same meshes as raw_mesh_fuzz.cpp reads them.
Same input, same files.
"""

import math
import pathlib
import random
import struct
import sys

STL, OBJ, PLY = range(3)  # first byte modulo 3


def read_obj(path):
    vertices, faces = [], []
    for line in path.read_text().splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            vertices.append(tuple(map(float, words[1:4])))
        elif words[:1] == ["f"]:
            faces.append(tuple(int(word.split("/")[0]) - 1 for word in words[1:4]))
    return vertices, faces


def piece(mesh, face_count, seed):
    """Faces around one face, by shared vertices, renumbered."""
    vertices, faces = mesh
    around = {}
    for index, face in enumerate(faces):
        for corner in face:
            around.setdefault(corner, []).append(index)
    order = [random.Random(seed).randrange(len(faces))]
    met = set(order)
    for index in order:
        for corner in faces[index]:
            for other in around[corner]:
                if other not in met:
                    met.add(other)
                    order.append(other)
        if len(order) >= face_count:
            break
    kept = [faces[index] for index in order[:face_count]]
    number = {corner: i for i, corner in enumerate(dict.fromkeys(sum(kept, ())))}
    return [vertices[corner] for corner in number], [tuple(number[c] for c in f) for f in kept]


def box():
    corners = [(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
    faces = [(0, 2, 3), (0, 3, 1), (4, 5, 7), (4, 7, 6), (0, 1, 5), (0, 5, 4),
             (2, 6, 7), (2, 7, 3), (0, 4, 6), (0, 6, 2), (1, 3, 7), (1, 7, 5)]
    return [tuple(0.02 * c for c in corner) for corner in corners], faces


def fan(count, height, turns=1.0):
    """A cone, a saddle (more than one turn) or, with fewer faces, an open fan."""
    vertices = [(0.0, 0.0, 0.0)]
    for i in range(count):
        angle = 2.0 * math.pi * turns * i / count
        vertices.append((math.cos(angle), math.sin(angle), height * (1 if i % 2 else -1)))
    return vertices, [(0, 1 + i, 1 + (i + 1) % count) for i in range(count)]


def book(pages):
    """Faces around one non-manifold edge."""
    vertices = [(0.0, 0.0, 0.0), (0.0, 0.0, 1.0)]
    for i in range(pages):
        vertices.append((math.cos(i), math.sin(i), 0.5))
    return vertices, [(0, 1, 2 + i) for i in range(pages)]


def moebius(count):
    vertices = []
    for i in range(count):
        for side in (-0.3, 0.3):
            a = 2.0 * math.pi * i / count
            r = 1.0 + side * math.cos(a / 2)
            vertices.append((r * math.cos(a), r * math.sin(a), side * math.sin(a / 2)))
    faces = []
    for i in range(count):
        a, b = 2 * i, 2 * i + 1
        c, d = (2 * i + 2, 2 * i + 3) if i + 1 < count else (1, 0)
        faces += [(a, c, b), (b, c, d)]
    return vertices, faces


def sliver_strip(count):
    vertices = [(1e-4 * i, (i % 2) * 0.5, 0.0) for i in range(count + 2)]
    return vertices, [(i, i + 1, i + 2) if i % 2 else (i + 1, i, i + 2) for i in range(count)]


# === File formats

def obj_bytes(vertices, faces):
    lines = ["v %r %r %r" % v for v in vertices]
    lines += ["f " + " ".join(str(c + 1) for c in face) for face in faces]
    return ("\n".join(lines) + "\n").encode()


def stl_text(vertices, faces):
    lines = ["solid piece"]
    for face in faces:
        lines += ["facet normal 0 0 0", "outer loop"]
        lines += ["vertex %r %r %r" % vertices[c] for c in face]
        lines += ["endloop", "endfacet"]
    return ("\n".join(lines + ["endsolid piece"]) + "\n").encode()


def stl_binary(vertices, faces):
    data = b"piece".ljust(80, b"\0") + struct.pack("<I", len(faces))
    for face in faces:
        data += struct.pack("<12fH", 0, 0, 0, *(x for c in face for x in vertices[c]), 0)
    return data


def ply_bytes(vertices, faces, encoding):
    header = ["ply", f"format {encoding} 1.0", "comment piece", f"element vertex {len(vertices)}"]
    header += [f"property double {axis}" for axis in "xyz"]
    header += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header"]
    data = ("\n".join(header) + "\n").encode()
    if encoding == "ascii":
        rows = ["%r %r %r" % v for v in vertices]
        rows += [" ".join(map(str, (len(f),) + tuple(f))) for f in faces]
        return data + ("\n".join(rows) + "\n").encode()
    order = "<" if "little" in encoding else ">"
    for vertex in vertices:
        data += struct.pack(order + "3d", *vertex)
    for face in faces:
        data += struct.pack(f"{order}B{len(face)}i", len(face), *face)
    return data


def file_seeds(mesh):
    yield STL, stl_text(*mesh)
    yield STL, stl_binary(*mesh)
    yield OBJ, obj_bytes(*mesh)
    for encoding in ("ascii", "binary_little_endian", "binary_big_endian"):
        yield PLY, ply_bytes(*mesh, encoding)


def raw_seed(mesh, choice):
    """As raw_mesh_fuzz.cpp reads it, coordinates as doubles."""
    vertices, faces = mesh
    vertices = vertices[:64]
    data = struct.pack("<HBB", choice, len(vertices) - 3, 3)
    for vertex in vertices:
        data += struct.pack("<3d", *vertex)
    for face in faces:
        if max(face) < len(vertices):
            data += bytes(face)
    return data


def lattice_seed(seed):
    """Faces at random over a coarse lattice: duplicates, slivers, non-manifold edges."""
    chance = random.Random(seed)
    count = chance.randrange(5, 30)
    data = struct.pack("<HBB", chance.randrange(65536), count - 3, 0)
    data += bytes(8 * chance.randrange(-2, 3) & 255 for _ in range(3 * count))
    return data + bytes(chance.randrange(count) for _ in range(3 * chance.randrange(8, 80)))


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    objects, corpus = map(pathlib.Path, sys.argv[1:])
    meshes = [box(), fan(8, 0.1), fan(12, 0.6), fan(9, 0.3, 2.0), book(2), book(5), moebius(12),
              sliver_strip(40)]
    shipped = sorted(objects.glob("*.obj"))
    if not shipped:
        sys.exit(f"make_corpus.py: no .obj in {objects}")
    for index, path in enumerate(shipped):
        mesh = read_obj(path)
        meshes += [piece(mesh, 60, seed=index), piece(mesh, 14, seed=100 + index)]

    for folder in ("mesh_file", "raw_mesh"):
        (corpus / folder).mkdir(parents=True, exist_ok=True)
    for index, mesh in enumerate(meshes):
        for kind, (file_format, data) in enumerate(file_seeds(mesh)):
            first = bytes([file_format + 3 * (index % 80)])
            (corpus / "mesh_file" / f"seed_{index}_{kind}").write_bytes(first + data)
        for choice in range(3):
            name = f"seed_{index}_{choice}"
            (corpus / "raw_mesh" / name).write_bytes(raw_seed(mesh, 7 * choice + index))
    quads = (box()[0], [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2)])
    (corpus / "mesh_file" / "quads_obj").write_bytes(bytes([OBJ]) + obj_bytes(*quads))
    (corpus / "mesh_file" / "quads_ply").write_bytes(bytes([PLY]) + ply_bytes(*quads, "ascii"))
    for seed in range(20):
        (corpus / "raw_mesh" / f"lattice_{seed}").write_bytes(lattice_seed(seed))


if __name__ == "__main__":
    main()
