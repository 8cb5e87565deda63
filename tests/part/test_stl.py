"""Meshes of STL files: what they hold, and what is wrong with them by name."""

import struct

import numpy as np
import pytest

from verne_post.model.findings import InputError
from verne_post.part.stl import build_mesh, describe_faults, read_stl, require_closed

#: The twelve facets of a cube of 10 mm, counter-clockwise from outside.
_QUADS = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
_PLACES = 10.0 * np.array([[k & 1, k >> 1 & 1, k >> 2] for k in range(8)], dtype=float)
CUBE = np.array([_PLACES[[a, *pair]] for a, b, c, d in _QUADS for pair in ((b, c), (c, d))])


def binary(corner, header=b""):
    rows = b"".join(struct.pack("<12fH", 0, 0, 0, *one.ravel(), 0) for one in corner)
    return header.ljust(80, b" ") + struct.pack("<I", len(corner)) + rows


def ascii(corner):
    rows = "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join("vertex %.9g %.9g %.9g\n" % tuple(p) for p in one)
        + "endloop\nendfacet\n"
        for one in corner
    )
    return f"solid part\n{rows}endsolid part\n".encode()


@pytest.mark.parametrize("raw", [binary(CUBE), binary(CUBE, b"solid of a binary file"), ascii(CUBE)])
def test_a_cube_is_read(raw):
    mesh = read_stl(raw, "cube.stl")
    assert (len(mesh.vertices), len(mesh.facets), mesh.open_edges, mesh.turned_edges) == (8, 12, 0, 0)
    assert mesh.volume == pytest.approx(1000)
    assert describe_faults(require_closed(mesh)) == []
    outwards = ((mesh.list_corners().mean(axis=1) - 5) * mesh.list_normals()).sum(1)
    np.testing.assert_allclose(outwards, 5)


def test_a_unit_scales_and_is_asked_where_the_size_cannot_be_meant():
    np.testing.assert_allclose(
        np.ptp(read_stl(binary(CUBE / 25.4), "cube.stl", "inch").vertices, axis=0), 10, rtol=1e-6
    )
    with pytest.raises(InputError, match=r"read in mm it is 0.01 mm large.*is it in m or inch\?") as caught:
        read_stl(binary(CUBE / 1000), "cube.stl")
    assert caught.value.findings[0].code == "VP506"
    with pytest.raises(InputError, match="read in mm it is 1e\\+07 mm large"):
        read_stl(binary(CUBE * 1e6), "cube.stl")


def test_vertices_that_only_rounding_keeps_apart_are_one():
    noise = np.random.default_rng(1).uniform(-2e-6, 2e-6, CUBE.shape)
    mesh = build_mesh("cube.stl", CUBE + noise)
    assert (len(mesh.vertices), mesh.open_edges) == (8, 0)


@pytest.mark.parametrize(
    ("corner", "says"),
    [
        (CUBE[1:], "it is open: 3 edges belong to only one facet"),
        (np.concatenate([CUBE[:1, ::-1], CUBE[1:]]), "facets are flipped or meet three at an edge: 3 edges"),
        (CUBE[:, ::-1], "it is inside out"),
    ],
)
def test_a_mesh_that_is_no_body_is_named(corner, says):
    with pytest.raises(InputError, match=says):
        require_closed(build_mesh("cube.stl", corner))


@pytest.mark.parametrize(
    ("raw", "says"),
    [
        (b"G1 X10\n", "it is no STL file"),
        (binary(CUBE)[:-10], "it is no STL file: 674 bytes, of 684"),
        (b"solid part\nendsolid part\n", "it has no facets"),
        (ascii(CUBE).replace(b"vertex 10 10 10", b"vertex 10 1O 10", 1), "line 20: expected vertex and three numbers"),
        (ascii(CUBE)[:-60], "the file ends inside one"),
        (binary(np.where(CUBE > 9, np.nan, CUBE)), "facet 1 has a coordinate that is no number"),
        (binary(CUBE).replace(struct.pack("<f", CUBE.max()), b"\1\0\x80\x7f"), "a coordinate that is no number"),
        (binary(CUBE[:, [0, 0, 1]]), "none of its facets has an area"),
        (b"", "it is no STL file"),
    ],
)
@pytest.mark.filterwarnings("error")
def test_what_cannot_be_read_is_named(raw, says):
    with pytest.raises(InputError, match=says):
        read_stl(raw, "cube.stl")


def test_facets_without_an_area_are_dropped():
    mesh = build_mesh("cube.stl", np.concatenate([CUBE, CUBE[:1, [0, 0, 1]]]))
    assert (mesh.dropped, len(mesh.facets), mesh.open_edges) == (1, 12, 0)
