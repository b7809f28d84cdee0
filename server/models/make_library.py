#!/usr/bin/env python3
"""Writes the built-in library of hands, objects and contact sets (README.md).

Needs nothing but Python 3's standard library; the same script writes the same bytes everywhere.
Lengths inside are millimetres, in the files metres.
"""

import argparse
import pathlib
import sys

sys.dont_write_bytecode = True

from generator.allegro16 import make_allegro16
from generator.barrett8 import make_barrett8
from generator.contacts import contact_sets
from generator.human20 import make_human20
from generator.objects import make_objects
from generator.tendon16 import make_tendon16
from generator.urdf import urdf_text


def library_files():
    """Relative path -> text of every file of the library but the sites, which are found."""
    files = {}
    hands = (make_human20(), make_allegro16(), make_barrett8(), make_tendon16())
    for hand in hands:
        files[f"hands/{hand.name}/{hand.name}.urdf"] = urdf_text(hand)
    objects = make_objects()
    for item in objects:
        files[f"objects/{item.name}.obj"] = item.mesh.obj_text(item.name, item.summary)
    for name, text in contact_sets(hands, objects):
        files[f"contacts/{name}.json"] = text
    return files


def main():
    here = pathlib.Path(__file__).resolve().parent
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--output", type=pathlib.Path, default=here,
                        help="folder to write into (default: this script's)")
    output = parser.parse_args().output
    for path, text in sorted(library_files().items()):
        target = output / path
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(text.encode("ascii"))
        print(path)


if __name__ == "__main__":
    main()
