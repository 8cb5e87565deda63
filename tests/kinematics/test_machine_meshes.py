"""Spindle and platform as meshes of the machine file: known distances from boxes and meshes, certain between rows."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import verne_post
from tests.kinematics.test_fixture_meshes import pack_stl, unite_boxes
from tests.part.test_clearance import block
from verne_post.app.assemble import assemble
from verne_post.app.constraints import check_program
from verne_post.app.convert import check_source
from verne_post.base.segments import measure_between_triangles
from verne_post.config.machine_paths import list_machine_files
from verne_post.model.findings import InputError
from verne_post.model.machine import Machine
from verne_post.model.part_setup import Box, FixtureMesh
from verne_post.part.rigid import build_balls, build_body, build_way, find_distances, find_inside, find_lines

#: A housing of 100 x 80 mm above P, in the platform frame, whose z points down: with a tool of 80 mm it begins at Z
#: 100.
HOUSING = ((-50.0, -40.0, -200.0), (50.0, 40.0, 0.0))
#: Past a post at y 41, 1 mm beside the housing, while the tool is 41 mm from it.
PAST = "G21 G90 G94\nG0 X-60 Y0 Z20 A0 C0\nG1 X60 F6000\nG0 Z60\nM2\n"


def write_machine(folder: Path, raw: bytes, table: str = 'file = "housing.stl"', name: str = "spindle") -> Path:
    text = list_machine_files()["verne"].read_text(encoding="utf-8")
    text = text.replace("[provenance]", f'[bodies.{name}]\n{table}\n\n[provenance]\nbodies = "assumed"')
    (folder / "mine.toml").write_text(text, encoding="utf-8")
    (folder / "housing.stl").write_bytes(raw)
    return folder / "mine.toml"


@pytest.fixture(scope="module")
def machine(tmp_path_factory: pytest.TempPathFactory) -> Machine:
    raw = pack_stl(unite_boxes([HOUSING]) / 25.4)
    folder = tmp_path_factory.mktemp("machine")
    return verne_post.load_machine(write_machine(folder, raw, 'file = "housing.stl"\nunit = "inch"'))


def check(machine: Machine, body: Any) -> list[tuple[int | None, str, float | None]]:
    """Line, body and distance of each VP215; remedies, which take longest, are looked for where one finding is
    whole.
    """
    options = verne_post.Options(tool_length=80.0, wcs={"G54": (0, 0, 0)}, keep_out=(body,))
    found = [item for item in check_program(assemble(PAST.encode(), machine, options))[1] if item.code == "VP215"]
    assert all(
        ("runs into fixture 'post'" in item.message) == (item.value == 0.0) for item in found if item.limit == 0.0
    )
    return [(item.line, item.quantity.split()[3], item.value) for item in found]


@pytest.mark.parametrize("mesh", [False, True])
@pytest.mark.parametrize(
    ("low", "high", "distance", "told"),
    [
        ((-5, 41, 50), (5, 60, 300), 0.0, []),
        ((-5, 41, 50), (5, 60, 300), 1.0, []),
        ((-5, 41, 50), (5, 60, 300), 1.01, [(3, "spindle", 1.0)]),
        ((-5, 39.9, 50), (5, 60, 300), 0.0, [(3, "spindle", 0.0)]),
        ((-5, 20, 50), (5, 30, 99.9), 0.0, []),
        ((-5, 20, 50), (5, 30, 100.1), 0.0, [(3, "spindle", 0.0)]),
        ((-50, -10, 150), (-40, 10, 160), 0.0, [(3, "spindle", 0.0)]),  # it begins all inside
    ],
)
def test_a_housing_passes_a_post(machine: Machine, low: Any, high: Any, distance: float, told: Any, mesh: bool) -> None:
    low, high = (tuple(map(float, one)) for one in (low, high))
    post = FixtureMesh("post", pack_stl(unite_boxes([(low, high)])), distance=distance)
    found = check(machine, post if mesh else Box("post", low, high, distance=distance))
    assert [one[:2] for one in found] == [one[:2] for one in told]
    assert [one[2] for one in found] == pytest.approx([one[2] for one in told], abs=1e-3)


def test_a_finding_has_its_remedy(machine: Machine) -> None:
    """The post is 0.1 mm too near; surfaces that meet have no depth, which would lead out. The line may end earlier."""
    options = verne_post.Options(
        tool_length=80.0, wcs={"G54": (0, 0, 0)}, keep_out=(Box("post", (-5.0, 39.9, 50.0), (5.0, 60.0, 300.0)),)
    )
    result = verne_post.check(PAST, machine, options)
    assert not result.ok
    [found] = [item for item in result.findings if item.code == "VP215"]
    assert (found.line, found.value) == (3, 0.0)
    # the front of the housing is 50 mm before the tip, and the post begins at X-5
    assert found.remedies[0] == "within limits if line 3 ends at X -55.1 instead of 60"


@pytest.mark.parametrize(("system", "is_told"), [(None, True), (2, True), (1, False)])
def test_no_other_offset_is_sought_for_a_body_that_moves_along(
    machine: Machine, system: int | None, is_told: bool
) -> None:
    """A clamp or stock of G54 has the same place in a program of G54 wherever G54 is; `fit` cannot help.

    The cutter runs into it: the distance of the housing, which takes most of the time, is measured in one case.
    """
    machine = machine if system is None else verne_post.load_machine()
    cuts = "G1 X1 Z-15 F300\nG0 X0 Y5\nG0 Z50\nG1 Z-14\nG0 X0\nG0 Z50\n"
    program = f"G21 G90 G94 G54 T1 M6 S500 M3\nG0 X0 Y0 Z50 A0 C0\n{cuts}M30\n"
    floor = -60.0 if system == 1 else 0.0  # in all systems the same body on the table
    body = Box("clamp", (-50.0, -50.0, floor), (50.0, 50.0, floor + 60.0), system=system)
    places = {"tool_length": 60.0, "wcs": {"G54": (0, 0, 60), "G55": (0, 0, 0)}}
    for given in ({"keep_out": (body,)}, {"stock": replace(body, name="the stock")}):
        found = check_source(program.encode(), machine, verne_post.Options(**places, **given)).findings
        contacts = [one for one in found if one.code in ("VP215", "VP216")]
        assert contacts
        remedies = [text for one in contacts for text in one.remedies]
        told = [text for text in remedies if "the part is moved" in text or "`verne-post fit" in text]
        assert bool(told) == is_told, told


@pytest.mark.parametrize("seed", range(6))
def test_random_motions_against_dense_poses(seed: int) -> None:
    """Blocks that turn and move: the least distance of dense poses decides, but for what they miss between them."""
    pick = np.random.default_rng(seed)
    turn = np.linalg.qr(pick.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    body, fixture = build_body(block((-4, -3, 0), (4, 3, 12), turn)), block((9, -9, -9), (13, 9, 9))
    n, corners = 12, body.list_corners()
    shift = np.cumsum(pick.normal(size=(n, 3)) * 2.0, axis=0) + [-3.0, 0, 0]
    angle = np.cumsum(pick.normal(size=n) * 0.1)
    rows = np.stack(
        [
            corners @ np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]]).T + move
            for a, move in zip(angle, shift, strict=True)
        ]
    )
    way = build_way(rows, np.arange(n), np.ones(n, dtype=bool))
    share = np.linspace(0, 1, 41)[:, None, None]
    dense = [rows[k] + share * (rows[k + 1] - rows[k]) for k in range(n - 1)]
    balls = build_balls(fixture)
    least = np.array([find_distances(body, balls, one, 99.0).min() for one in dense])
    # in poses: all pairs of facets
    at = rows[:, :1] + (body.balls.corner.reshape(-1, 3) @ (rows[:, [1, 2, 4]] - rows[:, :1]))
    plain = [
        measure_between_triangles(np.repeat(one.reshape(-1, 3, 3), 12, axis=0), np.tile(balls.corner, (12, 1, 1))).min()
        for one in at
    ]
    np.testing.assert_allclose(find_distances(body, balls, rows, 99.0), plain, atol=1e-9)
    apart = np.array([np.linalg.norm(np.diff(one, axis=0), axis=2).max() for one in dense])
    limit = max(float(np.sort(least)[4]), 0.01)
    line, value = find_lines(body, balls, way, limit)
    named = np.isin(np.arange(n - 1), line)
    assert named[least <= limit].all()
    assert (least[named] <= limit + 0.5 * apart[named] + 0.001).all()
    assert (value <= limit + 0.002).all()


def test_a_body_in_a_fixture_is_found_where_it_begins() -> None:
    body = build_body(block((-1, -1, -1), (1, 1, 1)))
    way = build_way(body.list_corners()[None] + np.zeros((2, 1, 1)), np.array([3, 3]), np.ones(2, dtype=bool))
    assert find_inside(body, block((-5, -5, -5), (5, 5, 5)), way).tolist() == [0]
    assert find_inside(body, block((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5)), way).tolist() == [0]
    assert find_inside(body, block((2, 2, 2), (5, 5, 5)), way).tolist() == []


@pytest.mark.parametrize(
    ("table", "name", "says"),
    [
        ('file = "none.stl"', "spindle", "bodies.spindle.file 'none.stl'"),
        ('file = "../housing.stl"', "spindle", "bodies.spindle.file = '../housing.stl': lies outside the folder"),
        ('file = "mine.toml"', "platform", "platform (mine.toml): it is no STL file"),
        ('file = "housing.stl"\nunit = "m"', "spindle", "spindle (housing.stl): read in m it is 200000 mm large"),
        ('file = "open.stl"', "spindle", "spindle (open.stl): it is open: 3 edges belong to only one facet"),
        ('file = "housing.stl"', "rods", "bodies"),
        ('unit = "mm"', "spindle", "bodies.spindle.file is missing"),
    ],
)
def test_what_is_wrong_in_the_file_is_named(tmp_path: Path, table: str, name: str, says: str) -> None:
    facets = unite_boxes([HOUSING])
    (tmp_path / "open.stl").write_bytes(pack_stl(facets[1:]))
    with pytest.raises(InputError) as error:
        verne_post.load_machine(write_machine(tmp_path, pack_stl(facets), table, name))
    assert says in error.value.findings[0].message
