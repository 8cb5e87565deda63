"""Meshes on the report page: they stand where the checks have them, and a page stays small whatever their size."""

import math
import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from verne_post.model.options import Options
from verne_post.model.part_setup import Box, Cylinder, FixtureMesh, NominalPart, Wanted, WorkOffset
from verne_post.part.bodies import build_pieces
from verne_post.part.dexels import list_sweeps
from verne_post.part.ray_tables import make_table
from verne_post.part.stl import Mesh, build_mesh
from verne_post.part.stock_forms import make_box
from verne_post.report.left import draw_skin, make_left
from verne_post.report.page import make_page
from verne_post.report.study import study
from verne_post.report.surfaces import FIXTURE_VERTICES, make_part, thin_surface
from verne_post.report.table import Study
from verne_post.report.worst import find_worst_places

from ..builders import MACHINE
from .test_report import embedded

SAMPLE = runpy.run_path(str(Path(__file__).parents[2] / "gcode_samples" / "make_vise_sample.py"))
PASS = "G21 G90\nG0 X-30 Y0 Z50 A0 C0\nG1 X30 F2000\nM2\n"


def place_surface(data: dict[str, Any], k: int) -> np.ndarray:
    """Corners (m, 3, 3) of a surface of a page, on the table, mm."""
    one = data["scene"]["meshes"][k]
    vertex = np.array(one["low"]) + one["step"] * data[f"surface.{k}.vertex"]
    c, s = math.cos(one["turn"]), math.sin(one["turn"])
    corners = vertex[data[f"surface.{k}.facet"]] @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    return np.asarray(corners + np.array(one["middle"]))


def make_ball(rings: int) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and facets of a ball of radius 10."""
    polar, around = np.meshgrid(
        np.linspace(0.05, 3.09, rings), np.linspace(0, 2 * np.pi, 2 * rings, endpoint=False), indexing="ij"
    )
    vertices = 10 * np.stack([np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)], axis=-1)
    i, j = np.meshgrid(np.arange(rings - 1), np.arange(2 * rings), indexing="ij")
    a, b = i * 2 * rings + j, i * 2 * rings + (j + 1) % (2 * rings)
    facets = np.concatenate(
        [np.stack([a, a + 2 * rings, b], axis=-1), np.stack([b, a + 2 * rings, b + 2 * rings], axis=-1)]
    )
    return vertices.reshape(-1, 3), facets.reshape(-1, 3)


def test_a_fixture_stands_on_the_page_where_it_is_checked() -> None:
    pytest.importorskip("jupyter_threejs_sage")
    raw = SAMPLE["pack_stl"](SAMPLE["unite_boxes"]([((60.0, 10.0, -5.0), (70.0, 30.0, 25.0))]))
    options = Options(
        tool_length=60.0, wcs={1: WorkOffset((5.0, -7.0, 40.0), 90.0)}, keep_out=(FixtureMesh("pin", raw, 1),)
    )
    source = PASS.encode()
    data = embedded(make_page("p.nc", source, MACHINE, study(source, MACHINE, options)))
    assert [one["name"] for one in data["scene"]["meshes"]] == ["pin"]
    corners = place_surface(data, 0)
    # a quarter of a turn: X of the part is Y of the table
    assert np.allclose(corners.min(axis=(0, 1)), [5 - 30, -7 + 60, 35], atol=0.001)
    assert np.allclose(corners.max(axis=(0, 1)), [5 - 10, -7 + 70, 65], atol=0.001)
    volume = np.einsum("nk,nk->n", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    assert volume == pytest.approx(10 * 20 * 30, rel=1e-3)


def test_a_large_mesh_is_simplified_and_a_small_one_is_not() -> None:
    vertices, facets = make_ball(200)
    assert len(vertices) > FIXTURE_VERTICES
    fewer, left = thin_surface(vertices, facets, FIXTURE_VERTICES)
    assert FIXTURE_VERTICES / 3 < len(fewer) <= FIXTURE_VERTICES
    assert np.allclose(np.linalg.norm(fewer, axis=1), 10.0)
    normal = np.cross(fewer[left[:, 1]] - fewer[left[:, 0]], fewer[left[:, 2]] - fewer[left[:, 0]])
    assert np.linalg.norm(normal, axis=1).sum() / 2 == pytest.approx(400 * np.pi, rel=0.02)  # no hole
    same, kept = thin_surface(vertices, facets, len(vertices))
    assert (len(same), len(kept)) == (len(vertices), len(facets))
    assert np.array_equal(np.sort(same[kept], axis=None), np.sort(vertices[facets], axis=None))


# --- the nominal part ----------------------------------------------------------------------------------

#: A floor of 20 x 10 mm at Z0 with a flat cutter of 6 mm in strips 4 mm apart; line 8 dips by 0.2 mm, and the last
#: strip is missing.
FLOOR = (
    "G21 G90 G94 G61.1\nG0 X-15 Y-4 Z10 A0 C0\nG1 Z0 F6000\nX15\nY0\nX0\nG1 Z0\nX-4 Z-0.2\nX-8 Z0\nX-15\nG0 Z30\nM2\n"
)
SHAPE = (Cylinder("cutter", 6.0, 20.0),)


def make_options(grid: float = 0.5, parts: int = 1, **more: Any) -> Options:
    i, j = np.meshgrid(np.arange(parts), np.arange(parts))
    square = np.stack([i, j], axis=-1).reshape(-1, 1, 2) + np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    corner = np.concatenate([square * [20.0, 10.0] / parts - [10.0, 5.0], np.zeros((parts * parts, 4, 1))], axis=2)
    raw = SAMPLE["pack_stl"](corner[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3, 3))
    part = NominalPart("floor.stl", raw, 1, "mm", Wanted(0.05, 0.1, grid, 1.0))
    place = {1: WorkOffset((5.0, -7.0, 40.0), 90.0)}
    return Options(tool_length=60.0, wcs=place, part=part, tool_shapes={0: SHAPE}, **more)


def study_floor(*words: Any) -> Study:
    return study(FLOOR.encode(), MACHINE, make_options(*words))


def test_the_part_has_its_deviations_where_they_are() -> None:
    pytest.importorskip("jupyter_threejs_sage")
    found = study_floor()
    data = embedded(make_page("p.nc", FLOOR.encode(), MACHINE, found))
    assert [one["kind"] for one in data["scene"]["meshes"]] == ["part"]
    assert data["wanted"] == {"gouge": 0.05, "excess": 0.1, "search": 1.0}
    middle = place_surface(data, 0).mean(axis=1) - [5.0, -7.0, 40.0]
    x, y = middle[:, 1], -middle[:, 0]  # of the part, which is turned by a quarter
    value, colour, frame = (data[f"surface.0.{name}"] for name in ("value", "colour", "frame"))
    assert np.allclose(middle[:, 2], 0.0, atol=0.001)
    dip = np.hypot(x + 4.0, y) < 2.5  # the tool stands here at its lowest
    assert np.allclose(value[dip], -0.2, atol=0.003)
    assert (colour[dip, 0] > 150).all()
    assert (colour[dip, 1] < 40).all()
    assert set(data["line"][frame[dip]].tolist()) <= {8, 9}
    cut = (y < -3.2) & (y > -4.8) | (np.abs(y) < 2.8) & (x > 4.0)
    assert np.allclose(value[cut], 0.0, atol=1e-3)
    assert (colour[cut] == 190).all()
    never = y > 4.3  # no cutter comes within 1 mm
    assert np.isnan(value[never]).all()
    assert (frame[never] == -1).all()
    # the finding stands on the part, and its button leads to the line
    [gouge] = [k for k, item in enumerate(found.findings) if item.code == "VP218"]
    assert found.line[found.place[gouge]] == found.findings[gouge].worst_line
    assert np.abs(found.place_tip[gouge, 2] - 40.0) < 1e-6
    place = find_worst_places(MACHINE, found)
    assert [one.value for one in place if one.what == "cut into floor.stl"] == ["0.200 mm"]


@pytest.mark.parametrize("parts", [1, 20])  # facets are divided coarser, or are too many themselves
def test_fewer_triangles_keep_the_worst(monkeypatch: pytest.MonkeyPatch, parts: int) -> None:
    found = study_floor(0.2, parts)
    assert found.part is not None
    assert found.program is not None
    judged = found.part.judged[0]
    fine = make_part(found.program, judged)
    monkeypatch.setattr("verne_post.report.surfaces.PART_FACETS", 100)
    coarse = make_part(found.program, judged)
    assert fine.deviation is not None
    assert coarse.deviation is not None
    assert len(fine.facets) > 1000
    assert 30 < len(coarse.facets) <= 100
    assert np.nanmin(coarse.deviation.value) == np.nanmin(fine.deviation.value)
    assert 3 < (coarse.deviation.colour[:, 1] < 40).sum() < 60
    area = [
        np.linalg.norm(np.cross(c[:, 1] - c[:, 0], c[:, 2] - c[:, 0]), axis=1).sum() / 2
        for c in (one.vertices[one.facets] for one in (fine, coarse))
    ]
    assert area == pytest.approx([200.0, 200.0], rel=1e-6 if parts == 1 else 0.06)


# --- what is left of the stock -------------------------------------------------------------------------


def make_mesh(vertices: np.ndarray, facets: np.ndarray) -> Mesh:
    return build_mesh("skin", vertices[facets])


def test_the_skin_of_a_stock_is_closed_and_holds_its_volume() -> None:
    """A slot, a hole through all of it, and a hole across it: rays with no, one and two intervals."""
    stock = make_box(np.zeros(3), np.array([30.0, 20.0, 10.0]), np.zeros(3), 0.0, 0.2)
    flat, thin = (build_pieces((Cylinder("cutter", d, 40.0),), 40.0)[0] for d in (6.0, 4.0))
    upright, across = np.array([[[0.0, 0.0, 1.0]] * 2]), np.array([[[1.0, 0.0, 0.0]] * 2])
    for tip, axis, piece in (
        ([[-9, 5, 7], [12, 5, 7]], upright, flat),
        ([[22, 6, 12], [22, 6, -1]], upright, thin),
        ([[-5, 15, 5], [-5, 15, 5]], across, thin),
    ):
        stock.cut(list_sweeps(np.array([tip], dtype=float), axis, 40.0, 0.1), make_table(piece))
    mesh = make_mesh(*draw_skin(stock))
    assert mesh.open_edges == 0
    assert mesh.volume == pytest.approx(stock.measure_volume(), rel=0.01)
    removed = 6.0 * 12.0 * 3.0 + np.pi * 9 / 2 * 3 + np.pi * 4 * 10 + np.pi * 4 * 30
    assert 6000.0 - mesh.volume == pytest.approx(removed, rel=0.08)  # a wall stands half a cell beside its place


def test_what_is_left_stands_where_the_stock_stood() -> None:
    pytest.importorskip("jupyter_threejs_sage")
    stock = Box("the stock", (-10.0, -5.0, -8.0), (10.0, 5.0, 0.5), 1)
    found = study(FLOOR.encode(), MACHINE, make_options(stock=stock))
    data = embedded(make_page("p.nc", FLOOR.encode(), MACHINE, found))
    assert [one["kind"] for one in data["scene"]["meshes"]] == ["part", "left"]
    assert "cells of 0.11 mm." in data["scene"]["note"]
    corners = place_surface(data, 1)
    assert np.allclose(corners.min(axis=(0, 1)), [5 - 5, -7 - 10, 40 - 8], atol=0.001)
    assert np.allclose(corners.max(axis=(0, 1)), [5 + 5, -7 + 10, 40 + 0.5], atol=0.001)
    mesh = build_mesh("left", corners)
    assert mesh.open_edges == 0
    # 0.5 over the floor up to y = 3, and the dip: a triangle of 8 by 0.2 mm, which the round cutter widens
    dip = 6.0 * 0.5 * 8.0 * 0.2 + 0.2 * 2.0 * 0.5 * np.pi * 9.0
    assert 200 * 8.5 - mesh.volume == pytest.approx(0.5 * 20 * 8 + dip, abs=1.0)


def test_a_stock_of_a_file_is_drawn_as_it_is() -> None:
    pytest.importorskip("jupyter_threejs_sage")
    low, high = (-10.0, -5.0, -8.0), (10.0, 5.0, 0.5)
    raw = SAMPLE["pack_stl"](SAMPLE["unite_boxes"]([(low, (0.0, 5.0, -4.0)), ((0.0, -5.0, -8.0), high)]))
    stock = FixtureMesh("the stock", raw, 1)
    data = embedded(
        make_page("p.nc", FLOOR.encode(), MACHINE, study(FLOOR.encode(), MACHINE, make_options(stock=stock)))
    )
    assert [one["kind"] for one in data["scene"]["meshes"]] == ["stock", "part", "left"]
    assert data["scene"]["boxes"] == []
    volume = [build_mesh("stock", place_surface(data, k)).volume for k in (0, 2)]
    assert volume[0] == pytest.approx(10 * 10 * (4 + 8.5), rel=0.01)
    assert volume[1] < volume[0] - 30


def test_a_tool_without_a_size_leaves_no_picture() -> None:
    stock = Box("the stock", (-10.0, -5.0, -8.0), (10.0, 5.0, 0.5), 1)
    options = Options(tool_length=60.0, wcs={1: WorkOffset((0.0, 0.0, 40.0))}, stock=stock)
    found = study(FLOOR.encode(), MACHINE, options)
    assert found.program is not None
    assert make_left(found.program) == (None, "What is left of the stock is not drawn: a tool has no size.")


def test_a_program_that_is_too_long_for_a_picture_leaves_none(monkeypatch: pytest.MonkeyPatch) -> None:
    stock = Box("the stock", (-10.0, -5.0, -8.0), (10.0, 5.0, 0.5), 1)
    program = study(FLOOR.encode(), MACHINE, make_options(stock=stock)).program
    assert program is not None
    monkeypatch.setattr("verne_post.report.left.MOST_POSES", 5)
    assert make_left(program) == (None, "What is left of the stock is not drawn: the program is too long.")
