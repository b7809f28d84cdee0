#!/usr/bin/env python3
"""Writes seeds of urdf_fuzz, contact_set_fuzz and contact_map_fuzz: make_text_corpus.py HANDS_DIR CORPUS_DIR

urdf/: the shipped hands, and small ones by hand. contact_set/: a file of each kind behind the
byte that names it. contact_map/: options, then maps on a ball in every encoding, by value, label
and colour, or a textured mesh with its picture. Same input, same files.
"""

import math
import pathlib
import re
import struct
import sys
import zlib

MARK = "<!--SRDF-->"


# === Hands

def joint(name, kind, parent, child, inner=""):
    return (f'<joint name="{name}" type="{kind}"><parent link="{parent}"/>'
            f'<child link="{child}"/>{inner}</joint>')


def link(name, shape=""):
    solid = f"<visual><geometry>{shape}</geometry></visual>" if shape else ""
    return f'<link name="{name}">{solid}</link>'


LIMIT = '<limit lower="-0.2" upper="1.5" effort="1" velocity="2"/>'
TIP = '<box size="0.01 0.01 0.01"/>'


def finger(name, side, inner=LIMIT):
    origin = f'<origin xyz="{side} 0 0.02" rpy="0 0 {side}"/><axis xyz="0 1 0"/>'
    return (link(name + "_low", '<box size="0.01 0.01 0.04"/>') + link(name + "_tip", TIP)
            + joint(name + "_1", "revolute", "palm", name + "_low", origin + inner)
            + joint(name + "_2", "revolute", name + "_low", name + "_tip", origin
                    + f'{LIMIT}<mimic joint="{name}_1" multiplier="0.7" offset="0.1"/>'))


def with_few_shapes(text):
    """Of every link one visual, a box, and no collision: more and rounder ones only take time."""
    text = re.sub(r"<collision>.*?</collision>", "", text, flags=re.S)
    seen = set()

    def keep(match):
        link_start = text.rfind("<link", 0, match.start())
        is_first = link_start not in seen
        seen.add(link_start)
        return match.group(0) if is_first else ""

    text = re.sub(r"<visual>.*?</visual>", keep, text, flags=re.S)
    text = re.sub(r"<(sphere|cylinder)[^>]*>", '<box size="0.01 0.01 0.02"/>', text)
    return re.sub(r"\s*\n\s*", "\n", text)


def hands(shipped):
    palm = link("palm", '<box size="0.1 0.08 0.02"/>')
    two = palm + finger("thumb", -0.05) + finger("index", 0.05)
    yield "two_fingers", two
    yield "no_limits", palm + finger("a", 0.1, "") + finger("b", 0.2, '<limit upper="1"/>')
    yield "meshes", (link("palm", '<mesh filename="package://hand/palm.stl" scale="1 -1 2"/>')
                     + link("tip", '<mesh filename="tip.obj"/>')
                     + joint("j", "prismatic", "palm", "tip", '<axis xyz="0 0 2"/>' + LIMIT))
    yield "round", (link("palm", '<cylinder radius="0.05" length="0.02"/>') + link("tip", '<sphere radius="0.01"/>')
                    + joint("j", "revolute", "palm", "tip", LIMIT))
    yield "missing_mesh", link("palm", '<mesh filename="gone.stl"/>')
    yield "cut_mesh", link("palm", '<mesh filename="cut.ply"/>')
    yield "planar", palm + link("b", TIP) + joint("j", "planar", "palm", "b", '<axis xyz="0 1 1"/>')
    yield "floating", (link("world") + two.replace("world", "w")
                       + joint("root", "floating", "world", "palm", '<origin xyz="1 0 0"/>'))
    yield "own_root", ("".join(link(f"r{i}") for i in range(6)) + palm + finger("f", 0.1)
                       + "".join(joint(f"t{i}", "prismatic", f"r{i}", f"r{i + 1}",
                                       f'<axis xyz="{int(i == 0)} {int(i == 1)} {int(i == 2)}"/>' + LIMIT)
                                 for i in range(3))
                       + "".join(joint(f"t{i}", "continuous", f"r{i}", f"r{i + 1}" if i < 5 else "palm",
                                       f'<axis xyz="{int(i == 3)} {int(i == 4)} {int(i == 5)}"/>')
                                 for i in range(3, 6)))
    yield "loop", link("a") + link("b") + joint("j", "fixed", "a", "b") + joint("k", "fixed", "b", "a")
    yield "mimic_loop", (palm + link("b", TIP) + link("c", TIP)
                         + joint("j", "continuous", "palm", "b", '<mimic joint="k"/>')
                         + joint("k", "continuous", "b", "c", '<mimic joint="j"/>'))
    yield "mimic_chain", (palm + "".join(link(f"l{i}", TIP) for i in range(6))
                          + joint("j0", "continuous", "palm", "l0")
                          + "".join(joint(f"j{i}", "continuous", f"l{i - 1}", f"l{i}",
                                          f'<mimic joint="j{i - 1}" multiplier="-1.5" offset="0.1"/>')
                                    for i in range(1, 6)))
    srdf = ('<robot name="r"><group_state name="open" group="g"><joint name="thumb_1" value="0.2"/>'
            '<joint name="index_1" value="9"/><joint name="gone" value="0"/></group_state>'
            '<group_state name="open" group="h"/></robot>')
    for name, text in shipped:
        yield name, with_few_shapes(text)
    yield "named_poses", (two, srdf)


def urdf_seeds(folder):
    shipped = [(path.stem, path.read_text()) for path in sorted(folder.glob("*/*.urdf"))]
    if not shipped:
        sys.exit(f"make_text_corpus.py: no .urdf in {folder}")
    for name, body in hands(shipped):
        srdf = ""
        if isinstance(body, tuple):
            body, srdf = body[0], MARK + body[1]
        text = body if "<robot" in body else f'<robot name="{name}">{body}</robot>'
        yield name, (text + srdf).encode()


# === Contact sets, sites, joints, problems

SET = """{"format": "handgraft-contacts/1", "name": "two", "object": "ball",
 "patches": [{"name": "thumb", "root": {"vertex": 12}, "direction": [1, 0.5, 0], "boundary": [],
   "interpolation_boundary": [{"vertex": 3}, {"vertex": 40}, {"face": 7, "barycentric": [0.2, 0.3, 0.5]},
     {"face": 30, "triangle": 1, "barycentric": [0, 0.5, 0.5]}], "weight": 0.5},
  {"name": "index", "root": {"vertex": 61}, "boundary": [%s],
   "interpolation_count": 8}], "notes": ["by hand"]}"""
CLOUD_SET = """{"format": "handgraft-contacts/1", "name": "c", "patches": [{"name": "thumb",
 "root": {"vertex": 0}, "boundary": [42, 43, 45, 47, 49], "interpolation_count": 12}]}"""
SITES = """format: handgraft-sites/1
sites:
  - name: "thumb"
    link: tip
    point_m: [0.001, 0, 0.02]
    normal: [0, 0, 1]
    direction: [-1, 0.1, 0.2]
  - {name: palm, link: palm, point_m: [0, 0, 0.01], normal: [0, 0, 1e-3], direction: [1, 0, 0]}
"""
PROBLEM = """{"format": "handgraft-problem/1", "hand": {"urdf": "hand.urdf", "packages": {}},
 "dofs": ["root_rx", "root_ry", "root_rz", "root_tx", "root_ty", "root_tz", "k", "j"],
 "start": [0.1, 0, 0, 0, 0, 1, 0, 0], "prior": [0, 3.1, 0, 0, 0, 0, 0, 0],
 "lower": [null, null, null, -1, null, null, null, -0.5], "upper": [null, null, null, 1, 2, 3, null, 1.5],
 "weights": {"distance": 10000, "normal": 1, "prior": 0.001}, "locked": ["root_tz", "j"],
 "prior_weights": [1, 1, 1, 0, 0, 0, 2, 3],
 "correspondences": [{"link": "tip", "p_hand": [0, 0, 0.01], "n_hand": [0, 0, 1],
   "p_object": [1, 2, 3], "n_object": [0, 0, -1], "weight": 2}]}"""


def ball():
    """The icosahedron that the fuzz targets' ball is split from, split once."""
    g = (1 + math.sqrt(5)) / 2
    corners = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g), (0, -1, -g),
               (0, 1, -g), (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4),
             (11, 10, 2), (10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8),
             (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    vertices = [list(c) for c in corners]
    for _ in range(2):
        middle = {}
        split = []
        for a, b, c in faces:
            ends = []
            for pair in ((a, b), (b, c), (c, a)):
                key = tuple(sorted(pair))
                if key not in middle:
                    middle[key] = len(vertices)
                    vertices.append([(x + y) / 2 for x, y in zip(vertices[pair[0]], vertices[pair[1]])])
                ends.append(middle[key])
            ab, bc, ca = ends
            split += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        faces = split
    scaled = []
    for v in vertices:
        length = math.sqrt(sum(x * x for x in v))
        scaled.append([0.03 * x / length for x in v])
    return scaled, faces


def contact_set_seeds():
    joints = [[0.01 * i, 0.02 * (i % 5), 0.001 * i * i] for i in range(21)]
    yield "set", 0, SET % "158, 63, 62, 134, 55, 54"
    yield "cloud", 1, CLOUD_SET
    yield "sites", 2, SITES
    yield "joints", 3, str(joints)
    yield "joints_named", 3, '{"joints": %s, "other": [[[]]]}' % joints
    yield "two_hands", 4, '{"hands": [{"valid": false}, {"valid": true, "joints": %s}]}' % joints
    yield "right_hand", 11, '{"hands": [{"joints": %s}, {"joints": %s}]}' % (joints, joints)
    yield "problem", 5, PROBLEM


# === Contact maps

def ply(encoding, columns, rows, faces, comment=""):
    types = {"float": "f", "double": "d", "int": "i", "uchar": "B"}
    head = ["ply", f"format {encoding} 1.0"] + ([f"comment {comment}"] if comment else [])
    head += [f"element vertex {len(rows)}"] + [f"property {kind} {name}" for kind, name in columns]
    head += [f"element face {len(faces)}", "property list uchar int vertex_indices", "end_header", ""]
    data = "\n".join(head).encode()
    if encoding == "ascii":
        text = [" ".join(f"{x:.6g}" for x in row) for row in rows]
        return data + ("\n".join(text + ["3 %d %d %d" % face for face in faces]) + "\n").encode()
    order = "<" if "little" in encoding else ">"
    for row in rows:
        data += struct.pack(order + "".join(types[kind] for kind, _ in columns),
                            *(int(x) if kind in ("int", "uchar") else x
                              for x, (kind, _) in zip(row, columns)))
    for face in faces:
        data += struct.pack(order + "B3i", 3, *face)
    return data


def png(width, height, pixels, depth=8):
    def chunk(kind, body):
        return (struct.pack(">I", len(body)) + kind + body
                + struct.pack(">I", zlib.crc32(kind + body)))
    rows = b"".join(b"\0" + bytes(pixels[y * width * 3:(y + 1) * width * 3]) for y in range(height))
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, depth, 2, 0, 0, 0))
            + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b""))


PLACES = [("float", axis) for axis in "xyz"]


def map_seeds():
    vertices, faces = ball()
    contact = [max(0.0, 1.0 - math.dist(v, vertices[0]) / 0.03, 1.0 - math.dist(v, vertices[3]) / 0.025)
               for v in vertices]
    label = [0 if math.dist(v, vertices[0]) < 0.03 else 2 for v in vertices]
    names = "0=thumb 1=index_tip 2=palm"
    rows = [v + [c] for v, c in zip(vertices, contact)]
    labelled = [v + [c, l] for v, c, l in zip(vertices, contact, label)]
    plain = bytes(8)
    for number, encoding in enumerate(("ascii", "binary_little_endian", "binary_big_endian")):
        yield f"values_{number}", plain, 0, ply(encoding, PLACES + [("float", "contact")], rows, faces)
        yield f"labels_{number}", plain, 0, ply(
            encoding, PLACES + [("float", "contact"), ("int", "link")], labelled, faces, names)
    yield "otsu_joints", bytes([3, 0, 2, 1, 3, 0, 0, 3]), 0, ply(
        "ascii", PLACES + [("float", "contact")], rows, faces)
    yield "smooth_own", bytes([2, 4, 0, 2, 2, 0, 2, 9]), 256, ply(
        "ascii", PLACES + [("float", "contact")], rows, faces)
    yield "quality", plain, 1, ply("ascii", PLACES + [("double", "quality")], rows, faces)
    yield "segment", plain, 2, ply(
        "ascii", PLACES + [("float", "contact"), ("int", "segment")], labelled, faces)
    grey = [v + [int(255 * c)] * 3 for v, c in zip(vertices, contact)]
    yield "grey", plain, 3, ply("binary_little_endian", PLACES + [("uchar", c) for c in ("red", "green", "blue")],
                                grey, faces)
    yield "cloud", plain, 0, ply("ascii", PLACES + [("float", "contact")], rows[:42], [])
    # A fan of nine vertices around a middle, each with its place in the picture.
    places, uv, corners = [(0.0, 0.0, 0.03)], [(0.5, 0.5)], []
    for i in range(8):
        angle = math.pi * i / 4
        places.append((0.012 * math.cos(angle), 0.012 * math.sin(angle), 0.0275))
        uv.append((0.5 + 0.45 * math.cos(angle), 0.5 + 0.45 * math.sin(angle)))
        corners += [0, 1 + i, 1 + (i + 1) % 8]
    mesh = (b"".join(struct.pack("<3f", *p) for p in places) + b"".join(struct.pack("<2f", *p) for p in uv)
            + struct.pack("<24H", *corners))
    shades = [max(0, 255 - 20 * (abs(x - 8) + abs(y - 8))) for y in range(16) for x in range(16)]
    picture = png(16, 16, [shade for shade in shades for _ in range(3)])
    yield "texture", plain, 8, mesh + picture
    yield "texture_own", bytes([0, 0, 0, 1, 0, 2, 3, 0]), 8 + 256, mesh + picture


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    hands_folder, corpus = map(pathlib.Path, sys.argv[1:])
    for folder in ("urdf", "contact_set", "contact_map"):
        (corpus / folder).mkdir(parents=True, exist_ok=True)
    for name, data in urdf_seeds(hands_folder):
        (corpus / "urdf" / f"seed_{name}").write_bytes(data)
    for name, kind, text in contact_set_seeds():
        (corpus / "contact_set" / f"seed_{name}").write_bytes(bytes([kind]) + text.encode())
    for name, options, kind, data in map_seeds():
        # Eight bytes of options, whether the map's own mesh is the object, the kind of map.
        first = options + bytes([kind // 256, kind % 256])
        (corpus / "contact_map" / f"seed_{name}").write_bytes(first + data)


if __name__ == "__main__":
    main()
