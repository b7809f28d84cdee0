"""Arguments that are none are told by name, value and what is permitted; contacts are read as they say."""

import pathlib
import struct
import zlib

import numpy as np
import pytest

import handgraft

MODELS = pathlib.Path(__file__).parents[3] / "server" / "models"
LEMON = MODELS / "objects" / "lemon.obj"


@pytest.mark.parametrize("call, told", [
    (lambda server: server.unload(3, "x"), "kind 3: permitted are hand, object, contacts, motion"),
    (lambda server: server.describe("hand", None), "name None: it must be text"),
    (lambda server: server.load_object(LEMON, 5), "name 5: it must be text"),
    (lambda server: server.load_object(LEMON, units=5), "units 5: it must be text"),
    (lambda server: server.load_object(5), "mesh 5: it must be the path of a file"),
    (lambda server: server.load_contacts("a.json", 5), "object 5: it must be text"),
    (lambda server: server.load_hand("a.urdf", packages=3), "packages 3: it must map names"),
    (lambda server: server.join("abc"), "session_id 'abc': it must be a whole number"),
    (lambda server: server.join(-1), "session_id -1: it must be 0 to"),
    (lambda server: server.load_session(3), "text 3: it must be text"),
    (lambda server: server.open("barrett8", "lemon", "lemon_3", weights=5), "weights 5: they are three numbers"),
    (lambda server: server.open("barrett8", "lemon", "lemon_3", X_WO="a"), "a 4x4 array of numbers, not 'a'"),
    (lambda server: server.grasp("barrett8", "lemon", "lemon_3", starts=-1), "starts: -1 is outside 0 to 10000"),
    (lambda server: handgraft.connect("0"), "domain '0': it must be a whole number, 0 to 100"),
    (lambda server: handgraft.connect(1, peers="host"), "peers 'host': they are a list"),
    (lambda server: handgraft.connect(1, peers=[1]), "peers 1: it must be text"),
    (lambda server: handgraft.connect(1, 5), "interface 5: it must be text")])
def test_an_argument_that_is_none_is_told(server, call, told):
    with pytest.raises(handgraft.InvalidInput, match=told):
        call(server)


def test_what_is_of_a_wrong_type_is_a_type_error(server):
    with pytest.raises(TypeError, match="name None"):
        server.describe("hand", None)


def png_of(row):
    """A PNG of one row of grey pixels."""
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", len(row), 1, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(b"\0" + bytes(row))) + chunk(b"IEND", b"")


@pytest.fixture
def painted_lemon(tmp_path):
    """A lemon with texture coordinates, and the picture: white where its two flanks are touched."""
    lines = LEMON.read_text().splitlines()
    vertices = np.array([[float(word) for word in line.split()[1:]] for line in lines if line.startswith("v ")])
    mesh = tmp_path / "painted.obj"
    with mesh.open("w") as file:
        for line in lines:
            if line.startswith("v "):
                file.write(line + "\n")
        wide = np.abs(vertices[:, 0] - vertices[:, 0].mean())
        for far in wide / wide.max():
            file.write(f"vt {0.25 if far < 0.8 else 0.75} 0.5\n")
        for line in lines:
            if line.startswith("f "):
                corners = [word.split("/")[0] for word in line.split()[1:]]
                file.write("f " + " ".join(f"{corner}/{corner}" for corner in corners) + "\n")
    picture = tmp_path / "touched.png"
    picture.write_bytes(png_of([0, 0, 255, 255]))
    return mesh, picture


def test_a_picture_goes_with_its_mesh(server, painted_lemon):
    mesh, picture = painted_lemon
    name = server.load_contacts(mesh, "lemon", colors="grey", picture=picture, outline=0.5, min_area=10e-6)
    assert len(server.describe("contacts", name)["patches"]) == 2
    with server.open("barrett8", "lemon", mesh, picture=picture, colors="grey") as session:
        assert len(session.settings()["patches"]) == 2


def test_how_a_map_is_read_is_told_what_is_permitted(server, painted_lemon):
    mesh, picture = painted_lemon
    with pytest.raises(handgraft.InvalidInput, match="picture .*touched.png': colors must say .*grey, hot"):
        server.open("barrett8", "lemon", mesh, picture=picture)
    with pytest.raises(handgraft.InvalidInput, match="touched.png': a picture is no contact map by itself.*picture="):
        server.open("barrett8", "lemon", picture, colors="grey")
    with pytest.raises(handgraft.InvalidInput, match="colors 'jet': contacts 'lemon_3' have been read already"):
        server.grasp("barrett8", "lemon", "lemon_3", colors="jet")
    with pytest.raises(TypeError, match="no option 'colours'; there are value, label, colors"):
        server.load_contacts(mesh, "lemon", colours="jet")
    with pytest.raises(handgraft.InvalidInput, match="joints_hand 'third': permitted are left, right, 0, 1"):
        server.load_contacts(mesh, "lemon", joints="a.json", joints_hand="third")
