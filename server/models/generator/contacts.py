"""The contact sets: what the demonstrated grasps leave on the objects, as JSON."""

import json

from . import vectors as v
from .demonstration import Demonstration
from .grasps import box, lemon, lemon_of_three, scissors, wine_glass
from .patches import (Outline, boundary_loop, inside_outline, log_coordinates, nearest_vertex)

INTERPOLATION_COUNT = 25

# Half lengths and half widths (mm) of what each pad covers, per object; outlines differ by phase.
FINGERTIP = {"thumb": Outline(11.5, 8.5, phase=0.6), "index": Outline(10.0, 7.0, phase=2.1),
             "middle": Outline(10.5, 7.2, phase=3.9), "ring": Outline(10.0, 7.0, phase=5.2),
             "little": Outline(9.0, 6.4, phase=1.2),
             "palm": Outline(16.0, 12.0, lean=0.10, wave=0.07, phase=0.9)}
ON_A_RING = {"thumb": Outline(6.5, 9.0, phase=0.6), "index": Outline(6.0, 7.5, phase=2.1),
             "middle": Outline(6.0, 7.5, phase=3.9)}

# name of the set, object, outlines, the hand that touches it, how
SETS = (("scissors_3", "scissors", ON_A_RING, "human20", scissors),
        ("wine_glass_4", "wine_glass", FINGERTIP, "human20", wine_glass),
        ("box_5", "box", FINGERTIP, "human20", box),
        ("lemon_6", "lemon", FINGERTIP, "human20", lemon),
        ("lemon_3", "lemon", FINGERTIP, "barrett8", lemon_of_three))


def contact_sets(hands, objects):
    """Yields name and JSON text of every contact set."""
    hand_named = {hand.name: hand for hand in hands}
    object_named = {item.name: item for item in objects}
    for name, object_name, outlines, hand_name, grasp in SETS:
        yield name, contact_set_text(name, hand_named[hand_name], object_named[object_name],
                                     outlines, grasp())


def contact_set_text(name, hand, item, outlines, grasp):
    poses, _ = Demonstration(hand, item.solid, grasp).solve()
    normals, neighbours = item.mesh.vertex_normals(), item.mesh.neighbours()
    patches = [make_patch(hand.site(touch.site), poses, item.mesh, normals, neighbours,
                          outlines[touch.site]) for touch in grasp.touches]
    return document_text(name, item.name, hand.name, patches)


def make_patch(site, poses, mesh, normals, neighbours, outline):
    """The patch where a posed pad touches: its root is the vertex nearest to the pad, its
    direction the pad's own."""
    X = poses[site.link]
    root = nearest_vertex(mesh, v.apply(X, site.point))
    direction = v.tangent(v.rotate(X[0], site.direction), normals[root])
    farthest = 1.3 * max(outline.length, outline.width)
    coordinates = log_coordinates(mesh, normals, neighbours, root, direction, farthest)
    loop = boundary_loop(mesh, neighbours, inside_outline(coordinates, outline), root)
    return {"name": site.name, "root": {"vertex": root},
            "direction": [round(x, 6) + 0.0 for x in direction], "boundary": loop,
            "interpolation_count": INTERPOLATION_COUNT}


def document_text(name, object_name, hand_name, patches):
    """JSON with one line a field, so that differences read well."""
    lines = ["{", '  "format": "handgraft-contacts/1",', f'  "name": "{name}",',
             f'  "object": "{object_name}",', '  "patches": [']
    for patch in patches:
        fields = [f'      "{key}": {json.dumps(value)}' for key, value in patch.items()]
        comma = "" if patch is patches[-1] else ","
        lines.extend(["    {", ",\n".join(fields), f"    }}{comma}"])
    lines.extend(["  ],",
                  f'  "notes": ["what a posed {hand_name} hand touches"]', "}"])
    return "\n".join(lines) + "\n"
