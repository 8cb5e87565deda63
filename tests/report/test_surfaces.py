"""Meshes on the report page: they stand where the checks have them, and a page stays small whatever their size."""

import math
import runpy
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from verne_post.model.options import Options
from verne_post.model.part_setup import FixtureMesh, WorkOffset
from verne_post.report.page import page
from verne_post.report.study import study
from verne_post.report.surfaces import FIXTURE_VERTICES, thin_surface

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
    data = embedded(page("p.nc", source, MACHINE, study(source, MACHINE, options)))
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
