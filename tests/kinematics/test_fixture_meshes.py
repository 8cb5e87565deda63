"""Fixtures that are meshes: found where boxes are, at their lines; what the meshes themselves may be."""

import contextlib
import io
import re
import runpy
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

import verne_post
from tests.builders import MACHINE
from tests.kinematics.test_keep_out import PAST, SHAPE, SPINDLE, SWING, check
from verne_post.app.assemble import assemble
from verne_post.app.constraints import check_program, guard_joints
from verne_post.app.convert import check_source
from verne_post.cli.main import main
from verne_post.kinematics.checks import mesh_distances
from verne_post.kinematics.checks.keep_out import KeepOut
from verne_post.model.findings import InputError
from verne_post.model.options import Options
from verne_post.model.part_setup import Box, Cylinder, FixtureMesh, NominalPart, Wanted
from verne_post.output.machined import describe_judged, list_worst
from verne_post.part.bodies import Piece
from verne_post.part.compare import CLEAR, GOUGE, Cells, Comparison, Gouges
from verne_post.part.fixture import load_fixture
from verne_post.part.motion import build_motion
from verne_post.part.stl import build_mesh
from verne_post.part.sweep import Nearest, look
from verne_post.part.verdict import Judged, Machined, list_findings

SAMPLE = runpy.run_path(str(Path(__file__).parents[2] / "gcode_samples" / "make_vise_sample.py"))
unite_boxes, pack_stl = SAMPLE["unite_boxes"], SAMPLE["pack_stl"]
Corners = tuple[float, float, float]


def mesh_of(low: Corners, high: Corners, name: str = "pin", **place: Any) -> FixtureMesh:
    return FixtureMesh(name, pack_stl(unite_boxes([(low, high)])), **place)


# --- as boxes are ------------------------------------------------------------------------------------

#: Program, corners of a body that is touched in it, and options.
CASES: dict[str, tuple[str, Corners, Corners, dict[str, Any]]] = {
    "a pin in the middle of a motion": (PAST, (-3.0, -2.0, 0.0), (3.0, 2.0, 33.0), {}),
    "a tool that swings over": (SWING, (20.0, 20.0, 60.0), (30.0, 60.0, 130.0), {}),
    "nothing": (SWING, (60.0, -20.0, 60.0), (70.0, 20.0, 130.0), {}),
    "in a dry run over it": (PAST, (-3.0, -2.0, 0.0), (3.0, 2.0, 33.0), {"air": 10.0}),
    "a tool without a size": (PAST, (-3.0, -2.0, 0.0), (3.0, 2.0, 33.0), {"tool_shapes": {}}),
    "a distance": (PAST, (-3.0, -2.0, 0.0), (3.0, 2.0, 29.0), {"distance": 1.5}),
    "a face that is touched": (PAST, (-3.0, -9.0, 0.0), (3.0, 9.0, 30.0), {}),
    "a wall that is slid along": (PAST.replace("X", "Y").replace("Y0", "X0"), (6.0, -50.0, 0.0), (40.0, 50.0, 60.0),
                                  {}),
    "a plunge that goes on from one above it": ("G21 G90 G64 P0.01\nG0 X0 Y0 Z60 A0 C0\nZ40\nZ20\nM2\n",
                                                (-3.0, -2.0, 0.0), (3.0, 2.0, 33.0), {}),
    "turned with the part": (PAST, (-20.0, -9.0, 0.0), (-10.0, 9.0, 60.0),
                             {"system": 1, "wcs": {"G54": (9, 2, 0, 30)}}),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_a_mesh_is_found_where_its_box_is(name: str) -> None:
    source, low, high, options = CASES[name]
    place = {key: options[key] for key in ("system", "distance") if key in options}
    options = {key: value for key, value in options.items() if key not in place}
    boxes, meshes = (
        check(source, keep_out=(one,), **options)
        for one in (Box("pin", low, high, **place), mesh_of(low, high, **place))
    )
    told = [
        [(item.code, item.line, item.last_line, re.split(r" -?\d+\.", item.message)[0]) for item in found]
        for found in (boxes, meshes)
    ]
    assert told[0] == told[1]
    for box, mesh in zip(boxes, meshes, strict=True):
        assert mesh.value is not None
        assert box.value is not None
        # what overlaps deeply is measured from the surface of the mesh; a box is left in the nearest direction
        assert mesh.value == pytest.approx(box.value, abs=0.01) or box.value < mesh.value < 0


def test_bodies_that_begin_inside_never_cross_the_surface() -> None:
    """All that a box there is told to touch is named."""
    corners = (-90.0, -90.0, 1.0), (90.0, 90.0, 400.0)
    boxes, meshes = (check(PAST, keep_out=(one,)) for one in (Box("pin", *corners), mesh_of(*corners)))
    told = [{(item.code, item.line, item.quantity.split(" from ")[0]) for item in found} for found in (boxes, meshes)]
    assert told[0] == told[1]
    assert len(meshes) > 1


def test_every_line_that_touches_is_told() -> None:
    """Three passes at one place, the second deepest: the stretch begins with the first and ends with the last."""
    source = "G21 G90 G61.1\nG0 X-60 Y0 Z34 A0 C0\nG1 X60 Z32 F6000\nX-60 Z28\nX60 Z32\nG0 Z60\nM2\n"
    (found,) = check(source, keep_out=(mesh_of((-3.0, -2.0, 0.0), (3.0, 2.0, 33.0)),))
    assert (found.line, found.last_line, found.count) == (4, 6, 3)


@pytest.mark.parametrize("is_mesh", [False, True])
def test_the_spindle_of_a_mill_meets_a_jaw_with_its_flat_nose(is_mesh: bool) -> None:
    """A nose 100 mm above the tip, 60 mm wide to either side, over a jaw beside the tool: 0.02 mm decide."""
    machine = verne_post.load_machine("ac_trunnion").changed(SPINDLE)
    for high, depth in ((129.98, 0.0), (130.02, 0.02)):
        jaw = Box("jaw", (-5.0, 45.0, 0.0), (5.0, 80.0, high))
        found = check(PAST, machine, keep_out=(mesh_of(jaw.low, jaw.high, "jaw") if is_mesh else jaw,))
        assert [item.code for item in found] == ["VP215"] * bool(depth)
        for item in found:
            assert item.message.startswith("the spindle goes 0.020 mm into fixture 'jaw'")
            assert item.value == pytest.approx(-depth, abs=5e-3)


@pytest.mark.parametrize(
    "body", [Box("pin", (-3.0, -2.0, 0.0), (3.0, 2.0, 33.0)), mesh_of((-3.0, -2.0, 0.0), (3.0, 2.0, 33.0))]
)
def test_one_cause_is_one_finding(body: Any) -> None:
    """Six passes through a pin; between them the tool goes round it."""
    passes = "".join(f"G1 X60 Y0 Z{32 - k / 2} F6000\nZ60\nX-60\nZ{31.5 - k / 2}\n" for k in range(6))
    (found,) = check(f"G21 G90 G61.1\nG0 X-60 Y0 Z32 A0 C0\n{passes}M2\n", keep_out=(body,))
    assert (found.line, found.last_line, found.worst_line, found.count) == (4, 24, 24, 6)
    assert found.value == pytest.approx(-3.5, abs=0.04)
    assert ", in 6 stretches: lines 4, 8, 12, 16 and on" in found.message


def test_distances_in_poses_are_those_from_the_same_box() -> None:
    """Of a tool beside, over and in a block: by the points of the mesh, and by the exact distances from a box."""
    corners = (-20.0, -9.0, 0.0), (-10.0, 9.0, 60.0)
    given = {"tool_length": 100.0, "wcs": {"G54": (9.0, 2.0, 0.0, 30.0)}, "tool_shapes": {1: SHAPE}}
    source = "G21 G90 G61.1\nT1 M6 S900 M3\nG0 X-60 Y30 Z80 A0 C0\nG1 X60 Y-30 Z50 A20 C40 F6000\nM2\n"
    found = []
    for body in (Box("block", *corners, system=1), mesh_of(*corners, "block", system=1)):
        joints = guard_joints(assemble(source.encode(), MACHINE, Options(**given, keep_out=(body,))))
        element, w = np.full(201, len(joints.contour) - 1), np.linspace(0, 1, 201)
        assert isinstance(joints.keep_out, KeepOut)
        found.append(joints.keep_out.evaluate(joints.place_bodies(element, joints.solve(element, w)))[0])
    box, mesh = found
    outside = (box > 0.5) & (box < 20)
    assert outside.sum() > 50
    assert np.abs(mesh - box)[outside].max() < 0.1  # points are 2 mm apart
    assert (mesh >= box - 1e-6)[box < 20].all()  # no point of the surface is nearer than the body
    assert ((mesh < 0) == (box < 0))[np.abs(box) > 0.1].mean() > 0.98


def test_the_nearest_point_of_a_mesh_is_found_where_another_group_of_points_seems_nearer() -> None:
    """Of a vise, whose jaws stand beside its base: every point is held against a cutter at 300 poses."""
    vise = load_fixture(pack_stl(unite_boxes([SAMPLE["BASE"], *SAMPLE["JAWS"], SAMPLE["STOP"]])), "vise", "mm")
    corners = np.array([[0.0, 0.0], [5.0, 0.0], [5.0, 20.0], [0.0, 20.0]])
    piece = Piece("cutter", corners, 0.0, 0.0, 20.0, 5.0, plain=True)
    pick = np.random.default_rng(1)
    tip = pick.uniform([-60.0, -60.0, 60.0], [60.0, 60.0, 110.0], (300, 3))
    axis = 0.3 * pick.normal(size=(300, 3)) + [0.0, 0.0, 1.0]
    axis /= np.linalg.norm(axis, axis=1)[:, None]
    balls = mesh_distances._sample(vise)
    points = balls[-1][0]
    least = np.array(
        [
            look(piece, points, *(np.broadcast_to(one, points.shape) for one in pose)).phi.min()
            for pose in zip(tip, axis, strict=True)
        ]
    )
    found = mesh_distances._find_least(piece, tip, axis, balls, np.full(300, 20.0))
    assert 50 < (least < 20.0).sum() < 250
    assert found[least < 20.0] == pytest.approx(least[least < 20.0], abs=1e-9)
    assert (found[least >= 20.0] >= 20.0).all()
    for near, some in ((20.0, slice(None)), (20.0, least > 20.0), (2.0, slice(100, 110))):
        of_all = mesh_distances._find_least_of_all(piece, tip[some], axis[some], balls, near)
        lowest = min(least[some].min(), near)
        assert of_all.min() >= lowest - 1e-9
        if lowest < near:
            assert (of_all.argmin(), of_all.min()) == (least[some].argmin(), pytest.approx(lowest, abs=1e-9))


def test_rods_keep_out_of_boxes_and_meshes(machine_with: Any) -> None:
    """A post under the platform: only the rods, as thick as the machine file says, come near it."""
    machine = machine_with({"rods.diameter_mm": 40.0})
    program = "G21 G90 G61.1\nT1 M6 S900 M3\nG0 X0 Y0 Z30 A0 C0\nG1 X40 F6000\nM2\n"
    joints = assemble(
        program.encode(), machine, Options(tool_length=100.0, wcs={"G54": (0.0, 0.0, 0.0)})
    ).build_joint_path()
    element, w = np.zeros(1, dtype=int), np.zeros(1)
    solved = joints.solve(element, w)
    start, end = machine.clearance.module.find_rod_ends(solved.q[:, :3], solved.platform)
    rod = [machine.five_axis.carry_to_table(one[:, 0], solved.q)[0] for one in (start, end)]
    middle = 0.5 * (rod[0] + rod[1])
    for aside, touches in ((0.0, True), (200.0, False)):
        low = middle + [aside - 3.0, -3.0, -3.0] if touches else middle + [-3.0, -3.0, 500.0]
        corners = tuple(low), tuple(low + 6.0)
        for body in (Box("post", *corners), mesh_of(*corners, name="post")):
            options = Options(tool_length=100.0, wcs={"G54": (0.0, 0.0, 0.0)}, keep_out=(body,))
            found = check_program(assemble(program.encode(), machine, options))[1]
            assert [(item.code, item.message[:9]) for item in found if item.code == "VP215"] == (
                [("VP215", "the leg I")] if touches else []
            )


# --- what a mesh may be ------------------------------------------------------------------------------

CUBE = unite_boxes([((0.0, 0.0, 0.0), (10.0, 10.0, 10.0))])
CROSSED = np.concatenate([CUBE, unite_boxes([((5.0, 4.0, 3.0), (15.0, 14.0, 13.0))])])


@pytest.mark.parametrize(("facets", "unit", "says"), [
    (CUBE[1:], "mm", "vise (vise.stl): it is open: 3 edges belong to only one facet"),
    (np.concatenate([CUBE[:1, ::-1], CUBE[1:]]), "mm", "vise (vise.stl): facets are flipped"),
    (CUBE[:, ::-1], "mm", "vise (vise.stl): it is inside out"),
    (CROSSED, "mm", "vise (vise.stl): its surface crosses itself: 11 facets"),
    (CUBE * 0.001, "mm",
     "vise (vise.stl): read in mm it is 0.01 mm large, a part is 0.1 to 10000 mm; is it in m or inch? (unit)"),
    (CUBE * 50.0, "m", "vise (vise.stl): read in m it is 500000 mm large"),
])  # fmt: skip
def test_meshes_that_are_no_body_are_named(facets: np.ndarray, unit: str, says: str) -> None:
    with pytest.raises(InputError) as error:
        check(PAST, keep_out=(FixtureMesh("vise", pack_stl(facets), unit=unit, file="vise.stl"),))
    assert [item.code for item in error.value.findings] == ["VP506"]
    assert error.value.findings[0].message.startswith(says)


@pytest.mark.parametrize(
    ("low", "high", "unit", "touched", "is_doubtful"),
    [
        ((-30.0, -20.0, 0.0), (30.0, 20.0, 30.5), "inch", ("error",), True),  # a doubt hides no contact
        ((40.0, -20.0, -40.0), (100.0, 20.0, -30.0), "inch", (), True),
        ((-2.0, -2.0, -5.0), (2.0, 2.0, -1.0), "inch", (), False),  # 102 mm are plausible
        ((-300.0, -20.0, -50.0), (1500.0, 20.0, -40.0), "mm", (), False),  # no unit is smaller
        ((-300.0, -20.0, -50.0), (650.0, 20.0, -40.0), "cm", (), False),  # in mm it is too large too
    ],
)
def test_a_mesh_that_fits_only_in_mm_is_doubted(
    low: Corners, high: Corners, unit: str, touched: tuple[str, ...], is_doubtful: bool
) -> None:
    found = check(PAST, keep_out=(mesh_of(low, high, "vise", unit=unit),))
    assert {item.severity for item in found if item.code == "VP215"} == set(touched)
    doubts = [item for item in found if item.code == "VP505"]
    assert [item.severity for item in doubts] == ["warning"] * is_doubtful
    for item in doubts:
        assert item.message.startswith("keep_out.vise.unit: read in inch, vise is 1524 mm long, and the table ")
        assert item.message.endswith("; did you mean mm?")


#: A vise of 110 x 130 x 84 mm in inches, read in mm; and pins.
LOST = ((-2.165, -2.559, -9.0), (2.165, 2.559, -5.693))
PIN, OTHER_PIN = ((-3.0, -3.0, -9.0), (3.0, 3.0, -2.0)), ((57.0, -3.0, -9.0), (63.0, 3.0, -2.0))


@pytest.mark.parametrize(
    ("fixtures", "says"),
    [
        ([mesh_of(*LOST, "vise")], 'write unit = "cm" (51.18 mm) or unit = "inch" (130 mm)'),
        ([Box("vise", *LOST)], "write the corners in mm"),
        ([mesh_of(*LOST, "vise", unit="inch")], ""),
        ([mesh_of(*PIN, "left"), mesh_of(*OTHER_PIN, "right")], ""),
        ([FixtureMesh("pins", pack_stl(unite_boxes([PIN, OTHER_PIN])))], ""),
        ([mesh_of(*PIN, "pin"), Box("base", (-50.0, -50.0, -30.0), (50.0, 50.0, -9.0))], ""),
    ],
)
def test_fixtures_that_are_smaller_than_any_in_all_are_doubted(fixtures: list[Box | FixtureMesh], says: str) -> None:
    found = check(PAST, keep_out=tuple(fixtures))
    assert [(item.code, item.severity) for item in found] == [("VP505", "warning")] * bool(says)
    for item in found:
        size = "keep_out.vise (4.33 x 5.118 x 3.307 mm from (-2.165, -2.559, -9) on the table): read in mm, "
        assert item.message.startswith(size)
        assert item.message.endswith(says)


#: A vise of 110 x 130 x 84 mm in inches, and a clamp in mm beside the stock on it.
VISE_INCH = ((-2.165, -2.559, 0.0), (2.165, 2.559, 3.307))
BESIDE = ((-65.0, -8.0, 80.0), (-40.0, 8.0, 100.0))


@pytest.mark.parametrize(
    ("fixture", "is_doubtful"),
    [
        (mesh_of(*VISE_INCH, "vise"), True),
        (mesh_of(*VISE_INCH, "vise", unit="inch"), False),
        (mesh_of((-55.0, -65.0, 0.0), (55.0, 65.0, 84.0), "vise"), False),
        (mesh_of((1.6, -0.3, 3.3), (2.4, 0.3, 3.9), "second clamp"), True),
        (mesh_of((42.0, -0.3, 80.0), (44.0, 0.3, 90.0), "second clamp"), False),
        (mesh_of((90.0, 20.0, 0.0), (110.0, 40.0, 25.0), "probe stand"), False),
        (mesh_of((-6.0, -6.0, 0.0), (6.0, 6.0, 20.0), "pin below"), False),  # it would go through the stock
        (mesh_of((-40.0, -4.0, 60.0), (-16.0, 4.0, 69.0), "parallel"), False),
        (mesh_of((-1.0, -1.0, -9.0), (1.0, 1.0, 0.0), "nut"), False),
    ],
)
def test_each_fixture_that_would_touch_the_stock_in_inches_is_doubted(fixture: FixtureMesh, is_doubtful: bool) -> None:
    stock = Box("the stock", (-40.0, -20.0, 80.0), (40.0, 20.0, 100.0))
    found = check(PAST.replace("Z30", "Z90"), keep_out=(fixture, Box("clamp", *BESIDE)), stock=stock)
    told = [item.message for item in found if item.code == "VP505" and "keep_out" in item.message]
    assert len(told) == is_doubtful
    for message in told:
        assert message.startswith(f"keep_out.{fixture.name}.unit: read in mm, it is ")
        assert message.endswith('mm large and touch it: did you mean unit = "inch"?')


#: A clamp with its z from the part, beside what cuts at z 30 of the table; the part zero is at z 100.
CLAMP = ((60.0, -10.0, -20.0), (85.0, 10.0, 12.0))
ABOVE = {"G54": (0.0, 0.0, 100.0)}


@pytest.mark.parametrize(
    ("fixtures", "wcs", "depth"),
    [
        ([mesh_of(*CLAMP, "clamp")], ABOVE, "20 mm"),
        ([Box("clamp", (60.0, -40.0, -30.0), (85.0, 40.0, -5.0))], ABOVE, "25 mm"),
        ([Box("clamp", *CLAMP), Box("far", (-85.0, -9.0, 0.0), (-60.0, 9.0, 9.0))], ABOVE, "20 mm"),
        ([Box("clamp", *CLAMP, system=1)], ABOVE, ""),
        ([Box("clamp", *CLAMP)], {"G54": (0.0, 0.0, 15.0)}, ""),  # it would be below the table face as well
        ([Box("bolted", (60.0, -10.0, -20.0), (85.0, 10.0, 21.0))], ABOVE, ""),  # less than half is in the slots
        ([Box("nut", (60.0, -9.0, -20.0), (80.0, 9.0, -8.0)), Box("bar", (60.0, -9.0, -8.0), (85.0, 9.0, 12.0))], ABOVE,
         ""),
        ([Box("flush", (60.0, -10.0, -20.0), (85.0, 10.0, 0.0))], ABOVE, ""),
        ([Box("table", (-200.0, -200.0, -60.0), (200.0, 200.0, -1.0))], ABOVE, ""),
        ([Box("beside", (300.0, -10.0, -20.0), (330.0, 10.0, -8.0))], ABOVE, ""),
    ],
)  # fmt: skip
def test_a_fixture_in_the_table_that_would_stand_on_it_in_a_work_system_is_doubted(
    fixtures: list[Box | FixtureMesh], wcs: dict[str, tuple[float, ...]], depth: str
) -> None:
    text = PAST.replace("Z30", "Z-70") if wcs is ABOVE else PAST
    told = [item.message for item in check(text, keep_out=tuple(fixtures), wcs=wcs) if item.code == "VP505"]
    assert len(told) == bool(depth)
    for message in told:
        assert message.startswith("the table face is at z 0, and keep_out.clamp (25 x ")
        assert f"is {depth} below it; " in message
        assert message.endswith('give it in G54 (system = "G54"); else correct z')


#: The stock of a part of 80 x 40 x 30 mm, in which PAST cuts.
STOCK = ((-40.0, -20.0, 0.0), (40.0, 20.0, 31.0))


@pytest.mark.parametrize(
    ("stock", "unit", "says"),
    [
        (Box("the stock", *STOCK), "mm", ""),
        (Box("the stock", (-39.9, -20.0, 0.0), (40.0, 20.0, 31.0)), "mm", ""),  # less than the excess that is accepted
        (Box("the stock", (-30.0, -20.0, 0.0), (30.0, 20.0, 31.0)), "mm",
         "part: part.stl reaches 10 mm outside the stock, at (-40.000, -20.000, 0.000) on the table: it is 80 x 40 x "
         "30 mm large, and the stock 60 x 40 x 31 mm from (-30, -20, 0); correct the unit, the size or the place of "
         "either"),
        (mesh_of((-1.575, -0.79, 29.0), (1.575, 0.79, 31.0), "the stock"), "mm", "part: part.stl reaches 51.8"),
        (mesh_of(*STOCK, "the stock"), "inch", "part.unit: read in inch, part.stl is 2032 mm long"),
    ],
)  # fmt: skip
def test_a_part_that_is_not_in_its_stock_is_doubted(stock: Box | FixtureMesh, unit: str, says: str) -> None:
    """Where its own unit is doubtful, nothing is said about the stock."""
    raw = pack_stl(unite_boxes([((-40.0, -20.0, 0.0), (40.0, 20.0, 30.0))]))
    found = check(PAST, stock=stock, part=NominalPart("part.stl", raw, 1, unit))
    told = [item.message for item in found if item.code == "VP505"]
    assert len(told) == bool(says)
    assert all(one.startswith(says) for one in told)


@pytest.mark.parametrize(
    ("size", "doubted"),
    [
        ((80.0 / 25.4, 40.0 / 25.4, 30.0 / 25.4), True),
        ((70.0 / 25.4, 40.0 / 25.4, 20.0 / 25.4), True),
        ((3.0, 1.5, 0.5), False),  # a small part in a large stock: 76 x 38 x 13 mm would be less than half as high
        ((2.0, 2.0, 1.0), False),
        ((30.0, 20.0, 10.0), False),
    ],
)
def test_a_part_in_inches_that_fills_its_stock_is_doubted(size: tuple[float, float, float], doubted: bool) -> None:
    x, y, z = size
    part = NominalPart("part.stl", pack_stl(unite_boxes([((-x / 2, -y / 2, 0.0), (x / 2, y / 2, z))])), 1)
    told = [item.message for item in check(PAST, stock=Box("the stock", *STOCK), part=part) if item.code == "VP505"]
    assert len(told) == doubted
    assert all(one.endswith('fits into it: did you mean unit = "inch"?') for one in told)


#: Around a block of 80 x 60 x 30 mm whose top is at Z0, then back over it, down in rapid traverse.
AROUND = (
    "G21 G90 G61.1\nG0 X-30 Y-20 Z20 A0 C0\nG1 Z-8 F600\nX30 F3000\nY20\nX-30\nY-20\nG0 Z20\nG0 X20 Y0\n{rapid}M2\n"
)
PLATE = AROUND.replace("Z-8", "Z0")
INTO = AROUND.format(rapid="G0 Z-10\n")
WHOLE = AROUND.format(rapid="")


def make_block(size: tuple[float, float, float], bottom: float, scale: float) -> bytes:
    x, y, z = size
    low, high = (-x / 2 * scale, -y / 2 * scale, bottom * scale), (x / 2 * scale, y / 2 * scale, (bottom + z) * scale)
    return pack_stl(unite_boxes([(low, high)]))


@pytest.mark.parametrize(
    ("source", "size", "bottom", "scale", "unit"),
    [
        (INTO, (80.0, 60.0, 30.0), -30.0, 1 / 25.4, "inch"),
        (WHOLE, (80.0, 60.0, 30.0), -30.0, 0.1, "cm"),
        (WHOLE.replace("Z-8", "Z22").replace("Z20", "Z60"), (80.0, 60.0, 30.0), 0.0, 1 / 25.4, "inch"),
        (INTO, (80.0, 60.0, 30.0), -30.0, 1.0, ""),
        (PLATE.format(rapid="X0 Y0\nG1 Z-1\nX1\nG0 Z20\n"), (3.0, 2.0, 1.2), -1.2, 1.0, ""),  # its plate is faced
        ("G52 X20\n" + WHOLE, (3.0, 2.0, 1.2), -1.2, 1.0, ""),  # another part on the same plate
        (WHOLE.replace("X30", "X4").replace("X-30", "X-4").replace("Y20", "Y3").replace("Y-20", "Y-3"),
         (3.0, 2.0, 1.2), -1.2, 1.0, ""),  # a small part, cut around far below it
        (WHOLE, (40.0, 30.0, 4.0), -4.0, 1.0, ""),  # no larger unit has it in the cuts
    ],
)  # fmt: skip
@pytest.mark.parametrize("key", ["stock", "part"])
def test_a_mesh_far_smaller_than_its_cuts_is_doubted_at_its_unit(
    key: str, source: str, size: tuple[float, float, float], bottom: float, scale: float, unit: str
) -> None:
    raw, place = make_block(size, bottom, scale), {"wcs": {"G54": (0.0, 0.0, 60.0)}}
    body = NominalPart("block.stl", raw, 1) if key == "part" else FixtureMesh("the stock", raw, 1, file="block.stl")
    found = check(source.replace("G52", "G90 G52"), **{key: body}, **place)
    told = [item.message for item in found if item.code == "VP505"]
    if unit:
        (message,) = told
        assert message.startswith(f"{key}.unit: read in mm, ")
        assert message.endswith(f'did you mean unit = "{unit}"?')
    else:
        assert not [one for one in told if ".unit" in one]


def test_the_unit_of_a_part_is_named_before_its_grid() -> None:
    raw = pack_stl(unite_boxes([((-40.0, -20.0, 0.0), (40.0, 20.0, 30.0))]))
    part = NominalPart("part.stl", raw, 1, "inch", Wanted(grid=1.0))
    options = Options(tool_length=100.0, tool_shapes={1: SHAPE}, wcs={"G54": (0.0, 0.0, 0.0)}, part=part)
    source = PAST.replace("G61.1\n", "G61.1\nT1 M6 S900 M3\n").encode()
    doubt, refused = check_source(source, MACHINE, options).findings
    assert (doubt.code, doubt.severity, doubt.message[:24]) == ("VP505", "warning", "part.unit: read in inch,")
    assert (refused.code, refused.severity) == ("VP018", "error")
    assert "has too many places; give 4.1 mm (grid_mm of [part] in the set-up" in refused.message


def test_a_body_of_many_facets_does_not_cross_itself() -> None:
    """6000 facets of a wavy plate; then a needle through it."""
    x, y = np.meshgrid(np.linspace(0, 100, 51), np.linspace(0, 100, 31), indexing="ij")
    top, low = np.stack([x, y, 5 + np.sin(x) * np.cos(y)], axis=-1), np.stack([x, y, np.zeros_like(x)], axis=-1)

    def sheet(p: np.ndarray) -> np.ndarray:
        a, b, c, d = p[:-1, :-1], p[1:, :-1], p[1:, 1:], p[:-1, 1:]
        return np.concatenate([np.stack([a, b, c], axis=-2), np.stack([a, c, d], axis=-2)]).reshape(-1, 3, 3)

    def wall(upper: np.ndarray, lower: np.ndarray) -> np.ndarray:
        return sheet(np.stack([lower, upper], axis=1))

    edges = [wall(top[:, 0], low[:, 0]), wall(low[:, -1], top[:, -1]), wall(low[0], top[0]), wall(top[-1], low[-1])]
    plate = np.concatenate([sheet(top), sheet(low)[:, ::-1], *edges])
    mesh = load_fixture(pack_stl(plate), "plate", "mm")
    assert len(mesh.facets) > 6000
    needle = unite_boxes([((50.1, 50.2, -3.0), (50.3, 50.4, 12.0))])
    with pytest.raises(InputError, match="crosses itself"):
        load_fixture(pack_stl(np.concatenate([plate, needle])), "plate", "mm")
    assert build_mesh("plate", plate).volume > 0


# --- from a set-up -----------------------------------------------------------------------------------


#: The part is compared at fewer places, and for deeper gouges: a third of the time, where no test is about these.
COARSE = "grid_mm = 4.0\ngouge_mm = 0.2"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    SAMPLE["main"](tmp_path)
    monkeypatch.chdir(tmp_path)
    replace_in("vise.nc.toml", "grid_mm = 1.0", COARSE)
    return tmp_path


#: The rows of the sample against the part.
COMPARED = ("--against", "vise.nc", "--nominal", "part.stl@G54", "--grid", "4", "--gouge", "0.1")


@pytest.fixture(scope="module")
def once(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """The sample, converted and compared with its part: the folder, and what the comparison says."""
    folder, said = tmp_path_factory.mktemp("once"), io.StringIO()
    SAMPLE["main"](folder)
    setup = (folder / "vise.nc.toml").read_text().partition("[part]")
    with contextlib.chdir(folder), contextlib.redirect_stderr(said):
        Path("vise.nc.toml").write_text(setup[0])  # the part is compared once, below
        assert main(["convert", "vise.nc", "-o", "rows.csv"]) == 0
        said.truncate(0)
        # both parts of the file, one after the other
        assert main(["machined", "rows.index.json", *COMPARED, "--stock-left", "left.npz@G54"]) == 0
    (folder / "vise.nc.toml").write_text("".join(setup))
    return folder, said.getvalue()


@pytest.fixture
def converted(folder: Path, once: tuple[Path, str]) -> str:
    """The sample with its rows and what is left of its stock; what the comparison said."""
    shutil.copytree(once[0], folder, dirs_exist_ok=True)
    return once[1]


def test_the_sample_is_clean_and_its_record_knows_the_files(folder: Path) -> None:
    """With the vise in mm and the stock as a box, then with the vise in inch and the stock as a file."""
    results = [verne_post.check(Path("vise.nc"), verne_post.load_machine())]
    ascii_stl = (
        "solid vise\n"
        + "".join(
            "facet normal 0 0 0\nouter loop\n"
            + "".join(f"vertex {x} {y} {z}\n" for x, y, z in one / 25.4)
            + "endloop\nendfacet\n"
            for one in unite_boxes([SAMPLE["BASE"], *SAMPLE["JAWS"], SAMPLE["STOP"]])
        )
        + "endsolid\n"
    )
    (folder / "vise.stl").write_text(ascii_stl)
    replace_in("vise.nc.toml", '"vise.stl"', '"vise.stl"\nunit = "inch"')
    replace_in("vise.nc.toml", "min = [-40.0, -20.0, -30.0]\nmax = [40.0, 20.0, 1.0]", 'file = "stock.stl"')
    results.append(verne_post.check(Path("vise.nc"), verne_post.load_machine()))
    records = []
    for result in results:
        assert (result.ok, result.findings) == (True, ())
        assert result.summary is not None
        assert result.part is not None
        assert result.part.rests == ()
        records.append(result.summary.options.record())
    one, other = (record["keep_out"][0] for record in records)
    assert one["mesh"] != other["mesh"]
    assert (one["name"], one["system"], other["unit"]) == ("vise", "table", "inch")
    assert records[1]["stock"]["unit"] == "mm"


def replace_in(file: str, old: str, new: str) -> None:
    text = Path(file).read_text()
    assert old in text
    Path(file).write_text(text.replace(old, new, 1))


#: File, what is replaced in it, by what -> lines and body that are told.
MUTATIONS = {
    "deep Z": ("vise.nc", "\nZ-6\n", "\nZ-10\n", "18 cutter"),
    "wrong offset": (
        "vise.nc.toml",
        "0.0, 0.0, 70.0",
        "0.0, 6.0, 70.0",
        "20 cutter",
    ),  # the shank begins at the height of the stop
    "long rapid": ("vise.nc", "G0 Z5\nX-50 Y-23", "G0 Z5\nX60 Y46\nX-50 Y-23", "17 cutter"),
    "short holder": ("shapes.toml", "length = 20.0 }\nshank", "length = 6.0 }\nshank", "20 holder"),
}


@pytest.mark.usefixtures("without_remedies")
@pytest.mark.parametrize("name", MUTATIONS)
def test_mutations_of_the_sample_are_found_at_their_lines(folder: Path, name: str) -> None:
    """Remedies are asked for below."""
    file, old, new, told = MUTATIONS[name]
    replace_in(file, old, new)
    findings = verne_post.check(Path("vise.nc"), verne_post.load_machine()).findings
    found = [item for item in findings if "from vise" in item.quantity]
    assert ", ".join(f"{item.line} {item.quantity.split()[3]}" for item in found) == told
    assert {item.code for item in found} == {"VP215"}


def test_explain_says_where_a_mesh_is_touched_and_what_cures_it(folder: Path, run: Any) -> None:
    """The pocket is 2 mm too deep: the part has to be raised by these and what bodies keep off."""
    replace_in("vise.nc", "\nZ-6\n", "\nZ-10\n")
    answer = run("explain", "vise.nc:22")
    assert re.search(
        r"VP215 error: the cutter goes 2\.\d+ mm into fixture 'vise'.*\n +at [\d.]+ % of the way: tip",
        answer.out,
    )
    raised = re.search(r"the part moved by 0, 0, (\d\.\d+) mm", answer.out)
    assert raised is not None
    replace_in("vise.nc.toml", "0.0, 0.0, 70.0", f"0.0, 0.0, {70 + float(raised[1])}")
    # the part itself goes with its offset, and is still cut too deep
    codes = {item.code for item in verne_post.check(Path("vise.nc"), verne_post.load_machine()).findings}
    assert codes == {"VP218"}


def test_a_tenth_too_deep_is_a_tenth_by_the_shortest_way_out(folder: Path) -> None:
    """The wall below the step is undercut over its whole thickness, along its normal: that is not how far the tool is
    off.
    """
    replace_in("vise.nc.toml", COARSE, "grid_mm = 2.0")
    replace_in("vise.nc", "\nZ-6\n", "\nZ-6.1\n")
    [found] = verne_post.check(Path("vise.nc"), verne_post.load_machine()).findings
    assert (found.code, found.line) == ("VP218", 19)
    depth = re.search(r"cuts (0\.\d+) mm into part.stl, by the shortest way out", found.message)
    assert depth is not None
    assert 0.1 <= float(depth[1]) <= 0.11  # a corner may leave the path by 0.01 mm
    assert found.value == pytest.approx(float(depth[1]), abs=0.001)


#: A wall that the tool undercuts: its depths along the normal and by the shortest way out, what is told beside the
#: second one, in a message and in the summary.
UNDERCUTS: dict[str, tuple[float, float, str, str]] = {
    "a shallow wall": (0.3, 0.2, "", ""),
    "much deeper along the normal": (0.3, 0.1, "; along the normal it is 0.300 mm there",
                                     " (along the normal it is 0.300 mm)"),
    "beyond the search": (2.0, 0.1, "; along the normal it is 2.000 mm or more there",
                          " (along the normal it is 2.000 mm or more)"),
    "by the shortest way within gouge_mm": (
        2.0, 0.02,
        "; along the normal it is 2.000 mm or more there, and that is what gouge_mm (--gouge) limits, to 0.05 mm",
        " (along the normal it is 2.000 mm or more)"),
    "just within gouge_mm": (
        0.06, 0.04, "; along the normal it is 0.060 mm there, and that is what gouge_mm (--gouge) limits, to 0.05 mm",
        " (along the normal it is 0.060 mm)"),
}  # fmt: skip


@pytest.mark.parametrize("name", UNDERCUTS)
def test_a_gouge_is_told_by_the_shortest_way_out(name: str) -> None:
    """The place beside it is deeper along the normal, and less deep by the shortest way out."""
    along, shortest, more, also = UNDERCUTS[name]
    part = build_mesh("part.stl", unite_boxes([((0.0, 0.0, 0.0), (1.0, 1.0, 1.0))]))
    core = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 9.0], [0.0, 9.0]])
    tool = (Piece("cutter", core, 0.0, 0.0, 9.0, 2.0),)
    motion = build_motion("tool 1", tool, np.eye(3)[:2], np.eye(3)[[2, 2]], np.array([7, 8]), np.array([True, False]))
    none = np.zeros(2, dtype=np.int64)
    near = Nearest(np.array([-0.5 * shortest, -shortest]), none, none, np.array([0, 1]))
    gouges = Gouges(np.eye(3)[:2], np.array([along + 0.1, along]), none, near)
    cells = Cells(part.list_corners(), np.arange(12))
    state = np.where(np.arange(12) > 0, CLEAR, GOUGE)
    found = Comparison(part, Wanted(), cells, np.zeros(12), near, state, np.zeros(12), gouges, 0.2)
    judged = Judged("nominal", "table", 0.0, (motion,), found)
    [finding], [spot] = list_findings(judged)
    assert finding.message.endswith(
        f"the cutter of tool 1 cuts {shortest:.3f} mm into part.stl, by the shortest way out, at "
        f"(0.000, 1.000, 0.000){more}"
    )
    assert (finding.severity, finding.value, finding.limit) == ("error", shortest, 0.05)
    assert (finding.line, finding.worst_line, spot.place.tolist()) == (7, 8, [0.0, 1.0, 0.0])
    [said] = describe_judged(Machined((judged,), (), (finding,)))
    assert f": gouged {shortest:.3f} mm deep at (0.000, 1.000, 0.000){also}, 1 facets;" in said
    [_said, not_checked] = describe_judged(Machined((replace(judged, comparison=replace(found, grid=0.3)),), (), ()))
    assert not_checked.startswith(
        "NOT CHECKED: excess between places that are 0.3 mm apart; on this part a grid of 0.2 mm"
    )
    first, second = (row.split(",") for row in list_worst(judged).splitlines()[1:])
    assert (float(first[3]), float(first[-1])) == (-shortest, -along)
    assert float(second[3]) == -0.5 * shortest


def test_a_line_does_not_deny_a_gouge_that_only_check_finds(folder: Path, run: Any) -> None:
    answer = run("explain", "vise.nc:9")
    said = (
        "within limits; it was not compared with the nominal part\nNOT CHECKED: cuts into the nominal part part.stl, "
    )
    assert f"{said}and what stays on it: `verne-post check vise.nc` compares it; spindle, platform" in answer.out


def test_a_ridge_between_two_strips_is_told(folder: Path, run: Any) -> None:
    """The face is milled 1.5 mm less far to one side: there the stock stays 1 mm high, beside the step."""
    replace_in("vise.nc", "Y13.5", "Y12")
    result = verne_post.check(Path("vise.nc"), verne_post.load_machine())
    assert result.ok
    [found] = result.findings
    assert found.code == "VP221"
    # 76 x 1 x 1 mm, less what is within 0.2 mm of the part, or may be: 0.12 more
    assert 76 * 0.6 < found.value < 76
    place = re.fullmatch(
        r".* mm3 of the stock stay farther than 0.2 mm from part.stl, where .*, up to \((.*), (.*), (.*)\)",
        found.message,
    )
    assert place is not None
    assert 17.0 < float(place[2]) < 18.0
    assert float(place[3]) == 1.0
    assert "stock: nothing stays" not in str(result.summary)
    answer = run("convert", "vise.nc", "-o", "rows.csv")
    assert answer.code == 0
    assert found.message in answer.err
    answer = run("machined", "rows.index.json", *COMPARED)
    assert found.message in answer.err
    assert f"stock: {found.value:.1f} mm3 stay farther than 0.2 mm from the part" in answer.err


def test_a_tool_that_is_longer_by_a_fifth_of_a_millimetre_gouges(converted: str, run: Any) -> None:
    """The rows are of the length of the tool table; the tool that is used is 0.2 longer."""
    assert "poses of tool 1, tool 2 against part.stl" in converted
    assert (
        "--measured is compared with one" in run("machined", "rows.index.json", *COMPARED, "--measured", "log.csv").err
    )
    replace_in("tools.tbl", "Z90", "Z90.2")
    answer = run("machined", "rows.2.csv", *COMPARED)
    assert answer.code == 1
    # it plunges there; later lines are as deep
    assert "vise.nc:29: VP218 error: the cutter of tool 2 cuts 0.20" in answer.err


@pytest.mark.parametrize(
    ("table", "says"),
    [
        ('file = "vise.stl"\nmin = [0, 0, 0]', "keep_out.vise: expected min and max of a box, or the file of an STL"),
        ('system = "G54"', "keep_out.vise: expected min and max of a box, or the file of an STL"),
        ("min = [0, 0, 0]", "keep_out.vise: max is missing"),
        ('min = [0, 0, 0]\nmax = [1, 1, 1]\nunit = "mm"', "keep_out.vise: a unit goes with a file; boxes are in mm"),
        ('file = "vise.stl"\nunit = "ft"', "keep_out.vise.unit = 'ft': expected"),
        (
            'file = "../vise.stl"',
            "keep_out.vise.file = '../vise.stl': lies outside the folder of the file that names it",
        ),
        ('file = "none.stl"', "keep_out.vise.file"),
        ('file = "vise.nc"', "vise (vise.nc): it is no STL file"),
    ],
)
def test_what_is_wrong_in_the_set_up_is_named(folder: Path, run: Any, table: str, says: str) -> None:
    replace_in("vise.nc.toml", 'file = "vise.stl"', table)
    answer = run("check", "vise.nc")
    assert answer.code == 2
    assert says in answer.out + answer.err


def test_fixtures_of_a_settings_file_may_be_meshes(folder: Path, run: Any) -> None:
    setup = folder / "vise.nc.toml"
    setup.write_text(setup.read_text().replace('[keep_out.vise]\nfile = "vise.stl"', "").partition("[part]")[0])
    (folder / "verne-post.toml").write_text('[keep_out.jaws]\nfile = "vise.stl"\n')
    kept = "kept out of: jaws (110 x 130 x 84 mm from (-55, -65, 0)), the stock (80 x 40 x 31 mm from (-40, -20, 40))"
    assert kept in run("check", "vise.nc").out
    (folder / "verne-post.toml").write_text('[keep_out.jaws]\nfile = "/vise.stl"\n')
    answer = run("check", "vise.nc")
    assert "keep_out.jaws.file = '/vise.stl': names of files count from the folder" in answer.out + answer.err


# --- the stock as a file --------------------------------------------------------------------------------

#: A rapid through the gap of a casting, 20 mm over the table, and a cut of 2 mm into its right post.
THROUGH = "G21 G90 G94 G54\nT1 M6 S900 M3\nG0 X0 Y-40 Z40 A0 C0\nZ10\nY40\nG1 X16 F1000\nY0\nG0 Z40\nM2\n"
POSTS = [
    ((-30.0, -20.0, 0.0), (-10.0, 20.0, 30.0)),
    ((10.0, -20.0, 0.0), (30.0, 20.0, 30.0)),
    ((-30.0, -20.0, 0.0), (30.0, 20.0, 5.0)),
]
CUTTER = {1: (Cylinder("cutter", 8.0, 40.0), Cylinder("holder", 30.0))}


def test_a_casting_is_the_stock_where_it_is() -> None:
    """Its box is full, and it is not: a rapid through the gap is no mistake, one through a post is."""
    place = {"tool_length": 80.0, "tool_shapes": CUTTER, "wcs": {"G54": (5.0, -3.0, 10.0, 30.0)}}
    box = Box("the stock", (-30.0, -20.0, 0.0), (30.0, 20.0, 30.0), 1)
    casting = FixtureMesh("the stock", pack_stl(unite_boxes(POSTS)), 1)
    told = [check(THROUGH, stock=stock, **place) for stock in (box, casting)]
    assert [(item.code, item.line) for item in told[0]] == [("VP216", 5)]
    assert told[1] == []
    [through] = check(THROUGH.replace("X0 Y-40", "X9 Y-40"), stock=casting, **place)
    assert (through.code, through.line, through.severity) == ("VP216", 5, "error")
    assert through.value == pytest.approx(-3.0, abs=0.3)
    # the way that the cutter has made into the post is free
    assert check(THROUGH.replace("G0 Z40\nM2", "G0 Y38\nZ40\nM2"), stock=casting, **place) == []


@pytest.mark.usefixtures("converted", "without_remedies")
def test_a_second_set_up_starts_from_what_the_first_has_left(folder: Path, run: Any) -> None:
    Path("next.nc").write_text("G21 G90 G94 G54\nT2 M6 S900 M3\nG43 H2\nG0 X-12 Y0 Z20\nZ-8\nX12\nZ20\nM2\n")
    box = (folder / "vise.nc.toml").read_text().partition("[part]")[0]
    (folder / "next.nc.toml").write_text(box)
    answer = run("check", "next.nc")
    assert answer.code == 1
    assert "next.nc:5: VP216 error" in answer.out + answer.err
    begin = box.index("[stock]")
    (folder / "next.nc.toml").write_text(box[:begin] + '[stock]\nfile = "left.npz"\nsystem = "G54"\n')
    assert run("check", "next.nc").code == 0
    (folder / "next.nc").write_text((folder / "next.nc").read_text().replace("Z-8", "Z-13"))  # the pocket is 12 deep
    answer = run("check", "next.nc")
    assert answer.code == 1
    assert "next.nc:5: VP216 error" in answer.out + answer.err
    Path("left.npz").write_bytes(b"no stock")
    answer = run("check", "next.nc")
    assert answer.code == 2
    assert "the stock (left.npz): not a stock file" in answer.out + answer.err


#: A cylinder of 40 mm under a rapid that passes beside it, but through its box.
BLANK = (
    "BEGIN PGM A MM\n"
    "BLK FORM CYLINDER Z R20 L20\n"
    "TOOL CALL 1 Z S900 F900\n"
    "L X-40 Y+{y} Z+30 A+0 C+0 FMAX\n"
    "L Z-5 FMAX\n"
    "L X+40 FMAX\n"
    "L Z+30 FMAX\n"
    "M30\n"
    "END PGM A MM\n"
)


@pytest.mark.usefixtures("without_remedies")
def test_the_stock_that_a_program_defines_is_checked_where_one_asks(tmp_path: Path, run: Any) -> None:
    shapes, file = tmp_path / "shapes.toml", tmp_path / "a.h"
    shapes.write_text("[tool.1]\ncutter = { diameter = 8, length = 40 }\nholder = { diameter = 30 }\n")
    words = ("--tool-length", 80, "--wcs", "G54=3,-2,60,20", "--tool-shapes", shapes)
    file.write_text(BLANK.format(y=0))
    answer = run("check", file, *words)
    assert answer.code == 0
    assert "not checked (--stock program checks it)" in answer.out + answer.err
    for given in (("--stock", "program"), ()):
        if not given:
            Path(f"{file}.toml").write_text('[stock]\nfile = "program"\n')
        answer = run("check", file, *words, *given)
        assert answer.code == 1
        found = re.search(
            r"a.h:6: VP216 error: the cutter runs into the stock of the program in a .* up to ([\d.]+) mm inside it",
            answer.out + answer.err,
        )
        assert found is not None
        assert float(found[1]) == pytest.approx(4.0, abs=0.1)  # 5 mm deep, and 4 mm from its side
    file.write_text(BLANK.format(y=24.2))  # beside the cylinder; the box around it is wider at its corners
    assert run("check", file, *words).code == 0
    file.write_text(BLANK.format(y=20).replace("X-40", "X-21").replace("L X+40 FMAX", "L X-18 FMAX"))
    assert run("check", file, *words).code == 0
    square = BLANK.format(y=20).replace("X-40", "X-21").replace("L X+40 FMAX", "L X-18 FMAX")
    file.write_text(
        square.replace("BLK FORM CYLINDER Z R20 L20", "BLK FORM 0.1 Z X-20 Y-20 Z-20\nBLK FORM 0.2 X+20 Y+20 Z+0")
    )
    assert run("check", file, *words).code == 1
    plain = tmp_path / "b.nc"
    plain.write_text("G21 G90 G94\nT1 M6 S900 M3\nG0 X0 Y0 Z50 A0 C0\nG1 X10 F900\nM2\n")
    answer = run("check", plain, *words, "--stock", "program")
    assert answer.code == 2
    assert "--stock program: the program defines no stock (BLK FORM, WORKPIECE)" in answer.out + answer.err
