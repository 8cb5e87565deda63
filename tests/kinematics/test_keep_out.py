"""Distances of tool, spindle and platform from boxes: against brute force, and along whole motions."""

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize

import verne_post
from verne_post.app.assemble import assemble, build_interpreter_setup
from verne_post.app.constraints import check_program
from verne_post.base import spans
from verne_post.config.tool_shapes import read_tool_shapes
from verne_post.kinematics.checks.clearance import _bound_convex
from verne_post.kinematics.checks.keep_out import KeepOut, Placed, build_keep_out
from verne_post.kinematics.checks.moving import Moving
from verne_post.kinematics.checks.separation import bound_distance, measure_cylinder_to_box
from verne_post.model.findings import Finding, InputError
from verne_post.model.options import Options
from verne_post.model.part_setup import Box, Cylinder, Tool, WorkOffset
from verne_post.model.poses import Platform, Pose

from ..builders import MACHINE

# --- one cylinder and one box -------------------------------------------------------------------


def random_cylinders(n: int, seed: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    start = rng.uniform(-120, 120, (n, 3))
    axis = rng.normal(size=(n, 3))
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    end = start + axis * rng.uniform(0, 90, (n, 1))
    radius = np.where(rng.random(n) < 0.2, 0.0, rng.uniform(0, 30, n))
    return start, end, radius


def to_box(point: np.ndarray, half: np.ndarray) -> np.ndarray:
    return np.linalg.norm(np.maximum(np.abs(point) - half, 0.0), axis=-1)


def test_ten_thousand_poses_against_brute_force() -> None:
    """Points all over each cylinder, against the box: never nearer than told, and not farther than they are apart."""
    half = np.array([45.0, 12.0, 30.0])
    n = 10_000
    start, end, radius = random_cylinders(n, 1)
    told = measure_cylinder_to_box(start, end, radius, half)
    axis = end - start
    length = np.linalg.norm(axis, axis=1)
    axis /= length[:, None]
    helper = np.eye(3)[np.argmin(np.abs(axis), axis=1)]
    u = np.cross(axis, helper)
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    v = np.cross(axis, u)
    best = np.full(n, np.inf)
    heights, rings, turns = np.linspace(0, 1, 13), np.linspace(0, 1, 4), np.linspace(0, 2 * np.pi, 25)[:-1]
    for height in heights:
        for ring in rings:
            for turn in turns[:1] if ring == 0 else turns:
                point = start + height * (end - start)
                point = point + (ring * radius)[:, None] * (np.cos(turn) * u + np.sin(turn) * v)
                best = np.minimum(best, to_box(point, half))
    spacing = np.hypot(length / 12 / 2, np.hypot(radius / 3 / 2, radius * np.pi / 24))
    apart = told > 0
    assert apart.sum() > 5000
    assert (~apart).sum() > 400
    assert (best[apart] >= told[apart] - 1e-9).all()
    assert (best[apart] <= told[apart] + spacing[apart] + 1e-9).all()
    # one that overlaps has a point inside, or all but inside
    assert (best[~apart] <= spacing[~apart]).all()


def test_distances_are_exact() -> None:
    """Against a general solver for the nearest two points, started at several places."""
    half = np.array([45.0, 12.0, 30.0])
    start, end, radius = random_cylinders(150, 2)
    told = measure_cylinder_to_box(start, end, radius, half)
    for a, b, r, d in zip(start, end, radius, told, strict=True):
        if d < 1e-3:
            continue
        axis = (b - a) / np.linalg.norm(b - a)
        u = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
        u /= np.linalg.norm(u)
        v = np.cross(axis, u)

        def point(x: np.ndarray, a=a, b=b, r=r, u=u, v=v) -> np.ndarray:
            return a + x[0] * (b - a) + r * (x[1] * u + x[2] * v)

        found = [
            minimize(
                lambda x: float(to_box(point(x), half) ** 2),
                [first, 0.0, 0.0],
                method="SLSQP",
                bounds=[(0, 1), (-1, 1), (-1, 1)],
                options={"maxiter": 500, "ftol": 1e-14},
                constraints={"type": "ineq", "fun": lambda x: 1.0 - x[1] ** 2 - x[2] ** 2},
            ).x
            for first in (0.0, 0.5, 1.0)
        ]
        # the solver leaves its bounds by a little
        found = [np.array([np.clip(x[0], 0, 1), *(x[1:] / max(1.0, math.hypot(*x[1:])))]) for x in found]
        nearest = min(float(to_box(point(x), half)) for x in found)
        assert d <= nearest + 1e-6
        assert d == pytest.approx(nearest, abs=0.03)  # the solver stops that short of the nearest point


def test_known_distances() -> None:
    half = np.array([10.0, 20.0, 30.0])

    def one(start: list[float], end: list[float], radius: float) -> float:
        return float(measure_cylinder_to_box(np.array([start]), np.array([end]), np.array([radius]), half)[0])

    assert one([0, 0, 32], [0, 0, 90], 5.0) == pytest.approx(2.0, abs=1e-9)  # stands above, flat on flat
    assert one([18, 0, -5], [18, 0, 90], 5.0) == pytest.approx(3.0, abs=1e-9)  # beside
    assert one([13, 24, 0], [13, 24, 90], 0.0) == pytest.approx(5.0, abs=1e-7)  # a element off an edge: 3, 4, 5
    assert one([0, 0, 28.5], [0, 0, 90], 5.0) == pytest.approx(-1.5, abs=1e-9)  # 1.5 deep
    assert one([13, 0, 0], [13, 0, 90], 5.0) == pytest.approx(-2.0, abs=1e-9)
    tilt = math.sqrt(0.5)
    # an edge of the flat end under 45 degrees: the rim's lowest point is at (20 - 5 tilt, 0, 40 - 5 tilt)
    told = one([20, 0, 40], [20 + 50 * tilt, 0, 40 + 50 * tilt], 5.0)
    assert told == pytest.approx(
        math.hypot(20 - 5 * tilt - 10, 0)
        if 40 - 5 * tilt < 30
        else min(math.hypot(max(20 - s * tilt - 10, 0), max(40 + s * tilt - 30, 0)) for s in np.linspace(-5, 5, 20001)),
        abs=1e-6,
    )


def test_the_quick_bound_is_one() -> None:
    half = np.array([45.0, 12.0, 30.0])
    cylinders = random_cylinders(5000, 3)
    exact = measure_cylinder_to_box(*cylinders, half)
    assert (bound_distance(*cylinders, half) <= np.maximum(exact, 0.0) + 1e-6).all()


# --- the machine's bodies -----------------------------------------------------------------------

PLATFORM = {
    "clearance.minimum_mm": 0.0,
    "clearance.spindle_diameter_mm": 90.0,
    "clearance.spindle_top_mm": 200.0,
    "clearance.platform_ends_mm": [[0.0, -120.0, -40.0], [0.0, 120.0, -40.0]],
    "clearance.platform_diameter_mm": 80.0,
    "provenance.clearance": "assumed",
}
SHAPE = (Cylinder("cutter", 12.0, 25.0), Cylinder("shank", 10.0, 20.0), Cylinder("holder", 50.0))


def test_bodies_stand_where_the_machine_has_them(machine_with: Callable[..., verne_post.Machine]) -> None:
    """Random poses: points of spindle and platform carried from the base frame to the table by hand."""
    machine = machine_with(PLATFORM)
    rng = np.random.default_rng(4)
    n = 300
    tip = rng.uniform([-80, -80, 20], [80, 80, 90], (n, 3))
    angles = np.radians(rng.uniform([-40, -180], [40, 180], (n, 2)))
    length = np.full(n, 110.0)
    q, platform, ok = machine.five_axis.solve(tip, angles, length)
    position, alpha = platform.position, platform.alpha
    placed = Platform(position[ok], platform.angles[ok])
    axis = machine.five_axis.find_tool_axis(q[ok], angles[ok], placed)
    pose = Pose(q[ok], placed, tip[ok], axis, length[ok], np.zeros(ok.sum(), dtype=int))
    box = Placed("post", np.array([30.0, -10.0, 160.0]), np.array([15.0, 25.0, 40.0]), math.radians(33.0), 0.0, False)
    moving = Moving([SHAPE], np.array([np.nan]), np.zeros(1, int), machine)
    model = KeepOut([box], moving, np.zeros(1, bool))
    assert moving.known == ["cutter", "shank", "holder", "spindle", "platform"]
    margins, _points = model.evaluate(pose)
    turn = np.array(
        [[math.cos(-box.turn), -math.sin(-box.turn), 0], [math.sin(-box.turn), math.cos(-box.turn), 0], [0, 0, 1]]
    )

    def from_box(point: np.ndarray) -> np.ndarray:
        """Points (m, k, 3) of the table frame: distance from the box, each."""
        return to_box((point - box.middle) @ turn.T, box.half)

    a, c = angles[ok].T
    k = np.stack([np.sin(a) * np.sin(c), np.sin(a) * np.cos(c), np.cos(a)], axis=1)
    along = np.linspace(0, 1, 400)[None, :, None]
    # spindle: from the gauge line to 200 mm behind P, radius 45
    nose = tip[ok] + 110.0 * k
    spindle = nose[:, None] + along * (200.0 * k)[:, None]
    by_hand = from_box(spindle).min(axis=1) - 45.0
    close = (by_hand < 20) & (by_hand > -44)  # beyond 25 mm what is told is a lower bound
    assert close.sum() > 20
    assert np.abs(by_hand - margins[:, 3])[close].max() < 0.2
    # platform: tilts with alpha about x in the base frame, whose y and z are turned; the table stands at A + alpha and
    # C
    platform_tilt = alpha[ok]
    ends = []
    for end in PLATFORM["clearance.platform_ends_mm"]:
        x, y, z = end
        base = position[ok] + np.stack(
            [
                np.full_like(platform_tilt, x),
                np.cos(platform_tilt) * y - np.sin(platform_tilt) * z,
                np.sin(platform_tilt) * y + np.cos(platform_tilt) * z,
            ],
            axis=1,
        )
        upright = (base - machine.coordinates.pivot) * [1.0, -1.0, -1.0]
        tilt = a + platform_tilt
        y1 = np.cos(tilt) * upright[:, 1] + np.sin(tilt) * upright[:, 2]
        z1 = -np.sin(tilt) * upright[:, 1] + np.cos(tilt) * upright[:, 2]
        ends.append(
            np.stack(
                [np.cos(c) * upright[:, 0] + np.sin(c) * y1, -np.sin(c) * upright[:, 0] + np.cos(c) * y1, z1], axis=1
            )
        )
    platform = ends[0][:, None] + along * (ends[1] - ends[0])[:, None]
    by_hand = from_box(platform).min(axis=1) - 40.0
    close = (by_hand < 20) & (by_hand > -39)
    assert np.abs(by_hand - margins[:, 4])[close].max(initial=0.0) < 0.2
    assert (margins[:, 4] <= by_hand + 0.2).all()


#: A spindle of 120 x 250 mm above the gauge line of a machine of schema 2.
SPINDLE = {"clearance.spindle_diameter_mm": 120.0, "clearance.spindle_top_mm": 250.0, "provenance.clearance": "assumed"}


@pytest.mark.parametrize("name", ["ac_trunnion", "b_head_c_table", "nutating_table", "hexam", "george_v"])
def test_the_spindle_of_a_chain_is_a_cylinder_above_the_gauge_line(name: str) -> None:
    """Random joint values: points all over the cylinder, on the axis that ``forward`` has, against a box."""
    machine = verne_post.load_machine(name).changed(SPINDLE)
    five_axis, n = machine.five_axis, 400
    rng = np.random.default_rng(5)
    tip, angles = rng.uniform([-60, -60, 20], [60, 60, 90], (n, 3)), np.radians(rng.uniform(-20, 20, (n, 2)))
    q, platform, ok = five_axis.solve(tip, angles, np.full(n, 70.0))
    assert ok.sum() > 200
    placed = Platform(platform.position[ok], platform.angles[ok])
    axis = five_axis.find_tool_axis(q[ok], angles[ok], placed)
    pose = Pose(q[ok], placed, tip[ok], axis, np.full(ok.sum(), 70.0), np.zeros(ok.sum(), dtype=int))
    post = Placed("post", np.array([60.0, -10.0, 160.0]), np.array([15.0, 25.0, 40.0]), 0.0, 0.0, False)
    moving = Moving([SHAPE], np.array([np.nan]), np.zeros(1, int), machine)
    model = KeepOut([post], moving, np.zeros(1, bool))
    column = [body for body, _box in model.pairs].index("spindle")
    told = model.evaluate(pose)[0][:, column]
    # the frame of the part, turned into that of the table
    end, along, sure = five_axis.forward(q[ok], 70.0)
    assert sure.all()
    nose, k = (one @ machine.coordinates.part_frame.T for one in (end + 70.0 * along, along))
    u = np.cross(k, np.eye(3)[np.argmin(np.abs(k), axis=1)])
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    v, nearest = np.cross(k, u), np.full(len(k), np.inf)
    for height in np.linspace(0.0, 250.0, 26):
        for radius in np.linspace(0.0, 60.0, 4):
            for turn in np.linspace(0.0, 2 * np.pi, 25)[: 1 if radius == 0 else -1]:
                point = nose + height * k + radius * (np.cos(turn) * u + np.sin(turn) * v)
                nearest = np.minimum(nearest, to_box(point - post.middle, post.half))
    apart = (told > 0) & (told < 20)  # beyond 25 mm what is told is a lower bound
    assert apart.sum() > 20
    assert (nearest[apart] >= told[apart] - 1e-6).all()
    assert (nearest[apart] <= told[apart] + 14.0).all()  # the points are that far from each other
    assert (nearest[told < 0] < 14.0).all()


# --- whole motions ------------------------------------------------------------------------------

#: The tool swings about its tip, upright at both ends: in the middle it tilts over by 40 degrees.
SWING = "G21 G90 G61.1\nG0 X0 Y0 Z40 A0 C0\nG1 A40 F3000\nG1 A0\nM2\n"
#: Legal ends, and a post in the middle of the way.
PAST = "G21 G90 G61.1\nG0 X-60 Y0 Z30 A0 C0\nG1 X60 F6000\nM2\n"


def check(source: str, machine: verne_post.Machine = MACHINE, **options: Any) -> list[Finding]:
    given = {"tool_length": 100.0, "tool_shapes": {1: SHAPE}, "wcs": {"G54": (0.0, 0.0, 0.0)}, **options}
    program = assemble(source.replace("G61.1\n", "G61.1\nT1 M6 S900 M3\n").encode(), machine, Options(**given))
    return check_program(program)[1]


def least(source: str, box: Box, body: str, machine: verne_post.Machine = MACHINE, **options: Any) -> float:
    """Smallest distance by dense sampling of all motion."""
    given = {"tool_length": 100.0, "tool_shapes": {1: SHAPE}, "keep_out": (box,), **options}
    program = assemble(source.replace("G61.1\n", "G61.1\nT1 M6 S900 M3\n").encode(), machine, Options(**given))
    frames = build_interpreter_setup(machine, program.options).frames
    model = build_keep_out(machine, program.path, program.moves, program.options, frames)
    assert model is not None
    joints, n = program.build_joint_path(), 4001
    column = next(k for k, (name, _box) in enumerate(model.pairs) if name == body)
    found = []
    for element in range(len(program.contour)):
        own = np.full(n, element)
        solved = joints.solve(own, np.linspace(0, 1, n))
        found.append(model.evaluate(joints.place_bodies(own, solved))[0][:, column].min())
    return float(min(found))


@pytest.mark.parametrize(
    ("source", "box", "body"),
    [
        (SWING, Box("post", (-20.0, 80.0, 70.0), (20.0, 95.0, 90.0)), "holder"),
        (PAST, Box("pin", (-3.0, 10.0, 0.0), (3.0, 14.0, 33.0)), "cutter"),
        (PAST, Box("beam", (-3.0, 20.0, 60.0), (3.0, 50.0, 72.0)), "shank"),
    ],
    ids=["swing", "past", "shank"],
)
def test_ends_are_legal_and_the_middle_is_not(source: str, box: Box, body: str) -> None:
    distance = least(source, box, body)
    assert 0.1 < distance < 40
    for gap, clean in ((0.01, True), (-0.01, False)):
        asked = Box(box.name, box.low, box.high, None, distance - gap)
        found = [item for item in check(source, keep_out=(asked,)) if body in item.message]
        assert (not found) == clean
        if found:
            assert (found[0].code, found[0].line, found[0].severity) == ("VP215", 4, "error")
            assert f"'{box.name}'" in found[0].message
            assert found[0].value == pytest.approx(distance, abs=1e-4)


def test_the_spindle_of_a_mill_swings_into_a_post_between_legal_ends() -> None:
    machine = verne_post.load_machine("ac_trunnion").changed(SPINDLE)
    source, post = SWING.replace("A40", "A-40"), Box("post", (-20.0, 205.0, 70.0), (20.0, 225.0, 180.0))
    distance = least(source, post, "spindle", machine)
    assert 0.1 < distance < 40
    for gap in (0.01, -0.01):
        asked = Box(post.name, post.low, post.high, None, distance - gap)
        found = [item for item in check(source, machine, keep_out=(asked,)) if "spindle" in item.message]
        assert [(item.code, item.line) for item in found] == [("VP215", 4)] * (gap < 0)
        assert all(item.value == pytest.approx(distance, abs=1e-4) for item in found)


@pytest.mark.parametrize(
    ("body", "code"),
    [({"stock": Box("the stock", (-5.0, 45.0, 100.0), (5.0, 65.0, 135.0))}, "VP216"), ({}, "VP213")],
)
def test_the_spindle_of_a_mill_keeps_out_of_stock_and_table(body: dict[str, Box], code: str) -> None:
    """Upright, the nose is 130 mm above the table; lying, its rim is 60 mm below the axis at 50 mm."""
    machine = verne_post.load_machine("ac_trunnion").changed(SPINDLE)
    source = PAST if body else "G21 G90 G61.1\nG0 X0 Y-60 Z50 A0 C0\nG1 A-90 F3000\nM2\n"
    found = [item for item in check(source, machine, **body) if "the spindle" in item.message]
    assert {item.code for item in found} == {code}
    if not body:
        assert found[0].value == pytest.approx(50.0 - 60.0, abs=1e-3)


def test_a_tool_may_slide_along_a_fixture() -> None:
    """Facing at the very height of the jaws: not a collision, and not endless to check; a hundredth lower is one."""
    jaws = Box("jaws", (-70.0, -20.0, 0.0), (70.0, 20.0, 30.0))
    assert check(PAST, keep_out=(jaws,)) == []
    found = check(PAST.replace("Z30", "Z29.99"), keep_out=(jaws,))
    assert [item.code for item in found] == ["VP215"]
    assert found[0].value == pytest.approx(-0.01, abs=1e-6)


def test_bounds_bound_convex_are_bounds() -> None:
    """Random convex functions, sampled as spans are: never below the bound, and near it where they are straight."""
    rng = np.random.default_rng(7)
    x = np.linspace(0, 1, 4001)
    at = spans.WITH_ENDS
    for _ in range(300):
        slopes, offsets = rng.normal(size=(2, 6)) * 20
        bend, middle = rng.uniform(0, 50), rng.uniform(0, 1)

        def convex(u: np.ndarray, slopes=slopes, offsets=offsets, bend=bend, middle=middle) -> np.ndarray:
            return np.max(slopes[:, None] * u + offsets[:, None], axis=0) + bend * (u - middle) ** 2

        bound = _bound_convex(convex(at)[:, None, None], np.array([np.inf]))[0, 0]
        assert bound <= convex(x).min() + 1e-9
        assert bound >= convex(at).min() - 40
    assert _bound_convex(np.full((len(at), 1, 1), 3.0), np.array([np.inf]))[0, 0] == pytest.approx(3.0)
    assert _bound_convex(np.full((len(at), 1, 1), 3.0), np.array([2.0]))[0, 0] == -np.inf


def test_a_tool_without_a_length_in_force_is_still_there() -> None:
    """Behind G49 the same tool is in the spindle: 82.5 mm of it hang below the gauge line."""
    source = (
        "G21 G90 G61.1\nT1 M6 S900 M3\nG43 H1\nG0 X0 Y0 Z50 A0 C0\nG1 Z10 F600\nG0 Z50\nG49\nG0 X60 Z20\nG0 Z10\nM2\n"
    )
    tools = {1: Tool(1, 1, (0.0, 0.0, 82.5, *(0.0,) * 6), 10.0)}
    box = Box("block", (55.0, -5.0, 90.0), (65.0, 5.0, 150.0))
    options = Options(tools=tools, wcs={1: WorkOffset((0.0, 0.0, 150.0))}, keep_out=(box,), split_at_stops=True)
    found = check_program(assemble(source.encode(), MACHINE, options))[1]
    assert {item.code for item in found} == {"VP215", "VP034"}
    shaped = Options(
        tools=tools,
        wcs=options.wcs,
        keep_out=(box,),
        tool_shapes={1: (Cylinder("cutter", 10.0, 20.0), Cylinder("holder", 30.0))},
    )
    assert {item.code for item in check_program(assemble(source.encode(), MACHINE, shaped))[1]} == {"VP215", "VP034"}


def test_the_last_part_reaches_up_to_the_gauge_line() -> None:
    short = {1: (Cylinder("cutter", 8.0, 20.0),)}
    box = Box("beam", (-3.0, -50.0, 60.0), (-2.0, 50.0, 120.0))
    assert [item.code for item in check(PAST, keep_out=(box,), tool_shapes=short)] == ["VP215"]


STOCK = Box("the stock", (-50.0, -50.0, 0.0), (50.0, 50.0, 60.0))
#: Into the stock at feed, along, out straight up; then a rapid through it.
POCKET = "G21 G90 G61.1\nG0 X0 Y0 Z70 A0 C0\nG1 Z50 F900\nX20\nG0 Z80\nG0 X60\nZ55\nG0 X70\nM2\n"


def test_the_stock_is_for_feeding_cutters() -> None:
    assert check(POCKET, stock=STOCK) == []
    # a rapid that goes down into it, one that crosses it, and a retract that is not straight
    for broken, line in (("G1 Z50 F900", 4), ("G0 X60\nZ55\nG0 X70", 9), ("G0 Z80\n", 6)):
        source = POCKET.replace(
            broken,
            {"G1 Z50 F900": "G0 Z50", "G0 X60\nZ55\nG0 X70": "G0 X60\nZ55\nG0 X10", "G0 Z80\n": "G0 Z80 X30\n"}[broken],
        ).replace("\nX20\n", "\nG1 X20 F900\n")
        found = check(source, stock=STOCK)
        assert [(item.code, item.line) for item in found] == [("VP216", line)], (broken, found)


#: A hole drilled in pecks, each with a full retract to 2 mm above the stock.
PECKS = "G21 G90 G61.1\nG0 X0 Y0 Z70 A0 C0\nG98 G83 X10 Z35 R62 Q8 F900\nG80\nG0 Z80\n{after}M2\n"
THIN = {1: (Cylinder("cutter", 6.0, 60.0),), 2: (Cylinder("cutter", 6.0, 60.0),)}


@pytest.mark.parametrize(
    ("after", "line"),
    [
        ("", None),
        ("G0 X10 Z62\nG1 Z30 F900\nG0 Z62\nZ30\nG1 Z25\nG0 Z80\n", None),
        ("G1 X20 Z50 F900\nG0 Z70\nG0 Z50\nG1 X30\nG0 Z80\n", None),  # back to where a slanting cut ended
        ("G0 X10 Z62\nG1 Z30 F900\nG0 Z62\nZ29.9\nG0 Z80\n", 10),  # deeper than it has drilled
        ("G0 X10 Z62\nG1 Z30 F900\nG0 Z62\nX11\nG0 Z31\nG0 Z80\n", 11),  # beside the hole
        ("T2 M6 S900 M3\nG43 H2\nG0 X10 Z62\nG0 Z40\nG0 Z80\n", 10),  # another tool
    ],
)
def test_a_drill_goes_back_into_its_own_hole(after: str, line: int | None) -> None:
    tools = {number: Tool(number, number, (0.0, 0.0, 100.0, *(0.0,) * 6), 6.0) for number in (1, 2)}
    source = PECKS.format(after=after).replace("Z70", "Z70 G43 H1")
    found = check(source, stock=STOCK, tool_shapes=THIN, split_at_stops=True, tools=tools, tool_length=None)
    assert [(item.code, item.line) for item in found] == ([("VP216", line)] if line else [])
    assert all("in a rapid traverse" in item.message for item in found)


def test_holders_and_shanks_keep_out_of_the_stock_as_it_is_then() -> None:
    def found(depth: str, *parts: Cylinder) -> list[tuple[str, int | None]]:
        items = check(POCKET.replace("Z50", depth), stock=STOCK, tool_shapes={1: parts} if parts else {1: SHAPE})
        assert all(item.code == "VP216" for item in items)
        return [(item.message.split()[1], item.line) for item in items if item.severity == "error"]

    # cutter 25 mm: 30 mm deep the shank is 5 mm in; it comes down in the hole of the cutter, then there is no way for
    # it
    assert found("Z36") == []
    assert found("Z30") == [("shank", 5), ("cutter", 6)]
    thick = Cylinder("cutter", 12.0, 25.0), Cylinder("shank", 14.0, 20.0), Cylinder("holder", 50.0)
    assert found("Z30", *thick) == [("shank", 4)]
    assert ("holder", 4) in found("Z10")


#: A slot, a rapid back through it (line 7), and one through uncut stock (line 11).
SLOT = (
    "G21 G90 G61.1\n"
    "G0 X-45 Y-20 Z80 A0 C0\n"
    "(first slot)\n"
    "G0 Z54\n"
    "G1 X45 F3000\n"
    "G0 X-45\n"
    "G0 Z80\n"
    "G0 Y20\n"
    "G0 Z54\n"
    "G0 X45\n"
    "M2\n"
)
BLOCK = Box("the stock", (-30.0, -40.0, 0.0), (30.0, 40.0, 60.0))


def test_the_stock_counts_as_it_is_cut() -> None:
    (found,) = check(SLOT, stock=BLOCK)
    assert (found.code, found.severity, found.line, found.worst_line) == ("VP216", "error", 11, 11)
    assert found.value == pytest.approx(-6.0, abs=0.15)
    # X-30 is 15 mm on, the radius 6; rays are 0.1 mm apart
    assert ": the contact begins 9.1 mm along line 11, 80.9 mm before its end; " in found.message
    # beside the slot: by less than bodies may touch, by less than rays can tell, by more
    for aside, expected in ((0.001, []), (0.02, ["warning"]), (0.2, ["error"])):
        beside = SLOT.replace("G0 X-45\nG0 Z80", f"G0 Y{aside - 20.0}\nG0 X-45\nG0 Z80").replace("G0 Z54\nG0 X45\n", "")
        assert [item.severity for item in check(beside, stock=BLOCK)] == expected, aside
    # a box elsewhere, turned with its work system
    offset = {"G54": (20.0, -30.0, 40.0, 37.0)}
    turned = Box("the stock", (-30.0, -40.0, -40.0), (30.0, 40.0, 20.0), system=1)
    source = SLOT.replace("Z80", "Z40").replace("Z54", "Z14")
    assert [item.line for item in check(source, stock=turned, wcs=offset)] == [11]


@pytest.mark.parametrize(
    ("corner", "way", "expected"),
    [
        ("", "G0 Z20", []),  # the rounded corner leaves 0.016 mm at a tolerance of 0.01, through which the rapid begins
        ("G64 P0.005", "G0 Z20", []),
        ("G64 P0.02", "G0 Z20", []),
        ("G64 P0.1", "G0 Z20", []),
        ("G61.1", "G0 Z20", []),
        ("G64 P0.02", "G0 Y5 Z30", [10]),
        ("G64 P0.02", "G0 X10", [10]),
    ],
)
def test_a_rapid_out_of_a_rounded_corner(corner: str, way: str, expected: list[int]) -> None:
    """It was refused for what the corner of the cut before it had left.

    The last rapid goes down into the groove, so that the stock is cut.
    """
    source = f"G21 G17 G90 G94 {corner}\nT1 M6\nS900 M3\nG43 H1\nG0 A0 C0\nG0 X-50 Y0\nG0 Z20\nG1 Z-2 F1500\nG1 X0\n"
    tool = Tool(1, 1, (0.0, 0.0, 80.0, *(0.0,) * 6), 10.0)
    stock = Box("the stock", (-40.0, -30.0, -20.0), (40.0, 30.0, 0.0), system=1)
    options = Options(tools={1: tool}, wcs={"G54": (0.0, 0.0, 100.0)}, stock=stock)
    found = check_program(assemble(f"{source}{way}\nG0 Z40\nX-20 Y0\nZ-1\nZ40\nM2\n".encode(), MACHINE, options))[1]
    assert [item.line for item in found] == expected


@pytest.mark.parametrize(
    ("corner", "diameter", "end", "down", "way", "least", "most"),
    [
        # the wall is 8 tan 30 deg = 4.6 mm nearer at the top: material lies on the axis of the cutter, of radius 4;
        # docs/stock.md: the depth may be 5 % too small
        ("G64", 8.0, 0.0, -8, "G0 A30", 3.8, 4.0),
        ("G61.1", 8.0, 0.0, -8, "G0 A30", 3.8, 4.0),
        # sideways through solid stock, 3 mm below its top: material lies on the axis of a ball of radius 1
        ("G64", 2.0, 1.0, -3, "G0 X4 A10", 0.9, 1.0),
        ("G64", 2.0, 1.0, -3, "G0 X4", 0.9, 1.0),
        ("G64", 2.0, 1.0, -3, "G0 X4 C1", 0.9, 1.0),
        # the edge, of 90 degrees, goes 4 sin 60 deg - 3 = 0.464 mm into the face: 0.464 sin 45 / cos 15 deg are inside
        ("G64", 8.0, 0.0, 3, "G0 A60", 0.32, 0.340),
    ],
)
def test_a_rapid_that_turns_meets_the_stock_as_it_was_before_its_line(
    corner: str, diameter: float, end: float, down: float, way: str, least: float, most: float
) -> None:
    """It ran: each chord of 0.5 degrees was cut before the next one was checked, and met next to nothing."""
    source = (
        f"G21 G90 G17 {corner}\nT1 M6\nM3 S5000\nG43 H1\nG0 A0 C0\nG0 X0 Y0 Z5\nG1 Z{down} F500\n{way}\nG0 Z60\nM2\n"
    )
    cutter = f"[tool.1]\ncutter = {{ diameter = {diameter}, length = 20.0, corner_radius = {end} }}\n"
    stock = Box("the stock", (-30.0, -30.0, -20.0), (30.0, 30.0, 0.0), system=1)
    options = Options(
        tool_length=60.0,
        wcs={"G54": (0.0, 0.0, 60.0)},
        stock=stock,
        tool_shapes=read_tool_shapes(cutter.encode(), "s.toml"),
    )
    program = assemble(source.encode(), verne_post.load_machine("serial"), options)
    found = next(item for item in check_program(program)[1] if item.severity == "error")
    assert (found.code, found.line) == ("VP216", 8)
    depth = re.search(r"material lies up to ([\d.]+) mm inside it", found.message)
    assert depth is not None
    assert least <= float(depth[1]) <= most
    if "X" not in way:  # the tip stays
        assert re.search(r"begins [\d.]+ deg along line 8, [\d.]+ deg before its end", found.message)


@pytest.mark.parametrize("way", ["G0 Z20 A30", "G0 Z20", "G0 A0.001"])
def test_a_rapid_that_turns_while_it_leaves_is_clear(way: str) -> None:
    """The edge of the cutter goes down by no more than 4 sin A while its tip goes up by 20 mm for 30 degrees."""
    source = f"G21 G90 G17\nT1 M6\nM3 S5000\nG43 H1\nG0 A0 C0\nG0 X0 Y0 Z5\nG1 Z0 F500\n{way}\nG0 Z60\nM2\n"
    stock = Box("the stock", (-30.0, -30.0, -20.0), (30.0, 30.0, 0.0), system=1)
    shape = read_tool_shapes(b"[tool.1]\ncutter = { diameter = 8.0, length = 20.0 }\n", "s.toml")
    options = Options(tool_length=60.0, wcs={"G54": (0.0, 0.0, 60.0)}, stock=stock, tool_shapes=shape)
    program = assemble(source.encode(), verne_post.load_machine("serial"), options)
    assert [item for item in check_program(program)[1] if item.severity == "error"] == []


def test_a_cutter_that_is_wider_below_does_not_come_back_up() -> None:
    """A lollipop in the slot that it has cut: a flat cutter comes out of it, this one does not."""
    up = SLOT.replace("G1 X45", "G1 X0").replace("G0 X-45\nG0 Z80", "G0 Z80", 1).split("G0 Y20")[0] + "M2\n"
    up = up.replace("Z54", "Z45")
    for neck, expected in ((0.0, []), (4.0, [("VP216", 7)])):
        shape = (Cylinder("cutter", 12.0, 40.0, corner_radius=6.0, neck_diameter=neck), Cylinder("holder", 50.0))
        found = check(up, stock=BLOCK, tool_shapes={1: shape})
        assert [(item.code, item.line) for item in found if item.severity == "error"] == expected


def test_a_dry_run_in_the_air_is_checked_there() -> None:
    pin = Box("pin", (-3.0, -3.0, 0.0), (3.0, 3.0, 45.0))
    assert check(PAST, keep_out=(pin,))
    assert check(PAST, keep_out=(pin,), air=16.0) == []
    assert check(PAST, keep_out=(pin,), air=16.0, air_along="table") == []
    assert check(PAST, keep_out=(pin,), air=14.0)


def test_each_tool_has_its_own_shape() -> None:
    source = (
        "G21 G90 G61.1\nT1 M6 S900 M3\nG43 H1\nG0 X-60 Y0 Z30 A0 C0\nG1 X60 F6000\n"
        "T2 M6 S900 M3\nG43 H2\nG0 X60 Y0 Z30\nG1 X-60 F6000\nM2\n"
    )
    tools = {n: Tool(n, n, (0.0, 0.0, 100.0, *(0.0,) * 6), d) for n, d in ((1, 6.0), (2, 30.0))}
    beside = Box("rail", (-50.0, 10.0, 0.0), (50.0, 20.0, 40.0))

    def found(**options: Any) -> list[tuple[str, int | None]]:
        given = Options(tools=tools, wcs={"G54": (0.0, 0.0, 0.0)}, split_at_stops=True, keep_out=(beside,), **options)
        program = assemble(source.encode(), MACHINE, given)
        return [(item.code, item.line) for item in check_program(program)[1]]

    # by the diameters of the tool table: 3 mm pass the rail at 10 mm, 15 mm do not
    assert found() == [("VP215", 9)]
    thin = {
        2: (
            Cylinder("cutter", 30.0, profile=((3.0, 0.0), (3.0, 40.0), (15.0, 50.0)), length=50.0),
            Cylinder("holder", 60.0),
        )
    }
    assert found(tool_shapes=thin) == [("VP215", 9)]  # a form counts as the cylinder around it
    holder = {2: (Cylinder("cutter", 30.0, 5.0), Cylinder("holder", 6.0, 50.0), Cylinder("holder", 60.0))}
    beside = Box("rail", (-50.0, 10.0, 36.0), (50.0, 20.0, 80.0))
    assert found(tool_shapes=holder) == []  # the cutter passes below it, the thin part of the holder beside it
    beside = Box("rail", (-50.0, 10.0, 36.0), (50.0, 20.0, 86.0))
    assert found(tool_shapes=holder) == [("VP215", 9)]


def test_boxes_in_a_work_system_move_with_the_part() -> None:
    """A part turned by 90 degrees: the box at +x of the part stands at +y of the table."""
    offset = {1: WorkOffset((5.0, -7.0, 12.0), 90.0)}
    box = Box("pin", (10.0, -2.0, 0.0), (14.0, 6.0, 20.0), system=1)
    program = assemble(PAST.encode(), MACHINE, Options(tool_length=100.0, wcs=offset, keep_out=(box,)))
    frames = build_interpreter_setup(MACHINE, program.options).frames
    model = build_keep_out(MACHINE, program.path, program.moves, program.options, frames)
    assert model is not None
    placed = model.boxes[0]
    corners = np.array([[x, y, z] for x in (10, 14) for y in (-2, 6) for z in (0, 20)], dtype=float)
    on_table = np.stack([5.0 - corners[:, 1], -7.0 + corners[:, 0], 12.0 + corners[:, 2]], axis=1)
    assert np.abs(np.abs(placed.map_inside(on_table)) - placed.half).max() < 1e-9


def test_a_tool_longer_than_it_is(machine: verne_post.Machine) -> None:
    long = {1: (Cylinder("cutter", 6.0, 80.0), Cylinder("shank", 6.0, 30.0), Cylinder("holder", 60.0))}
    with pytest.raises(InputError, match="tool 1: its parts among the tool shapes are 110 mm long, but its length is"):
        check(PAST, keep_out=(STOCK,), tool_shapes=long)


# --- options ------------------------------------------------------------------------------------


@pytest.fixture
def program(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "p.nc"
    path.write_text(PAST, encoding="utf-8")
    return path


@pytest.mark.usefixtures("without_remedies")
def test_settings_and_command_line(program: Path, run: Callable[..., Any]) -> None:
    place = ("check", program, "--tool-length", 100, "--wcs", "G54=0,0,0")
    Path("verne-post.toml").write_text(
        "[keep_out.pin]\nmin = [-3.0, -2.0, 0.0]\nmax = [3.0, 2.0, 33.0]\ndistance_mm = 1.5\n"
        "[stock]\nmin = [-5.0, -5.0, 0.0]\nmax = [5.0, 5.0, 10.0]\nsystem = 'G54'\n"
    )
    answer = run(*place)
    assert answer.code == 1
    assert "VP215" in answer.err + answer.out
    assert "it must stay 1.5 mm away" in answer.err + answer.out
    # the same name on the command line goes before the settings; another one comes besides
    assert run(*place, "--keep-out", "pin=-3,-2,0,3,2,20").code == 0
    assert run(*place, "--keep-out", "pin@G54=-3,-2,0,3,2,20", "--keep-out", "high=0,-1,0,1,1,50").code == 1
    assert run(*place, "--keep-out", "pin=-3,-2,0,3,2,20", "--stock", "G54=-60,-9,0,60,9,29").code == 0
    answer = run("convert", *place[1:], "-o", "axes.csv")
    assert answer.code == 1
    assert not Path("axes.csv").exists()


@pytest.mark.parametrize(
    ("text", "words", "said"),
    [
        (PAST, ("--keep-out", "v@G54=0,0,0,1,1,1"), "v is given in G54, and G54 is not"),
        (PAST, ("--stock", "G55=0,0,0,1,1,1", "--wcs", "G54=0,0,0"), "the stock is given in G55, and G55 is not"),
        (PAST.replace("G61.1", "G61.1 G10 L2 P1 X5"), ("--keep-out", "v@G54=0,0,0,1,1,1", "--wcs", "G54=0,0,0"),
         "which the program moves (G10)"),
    ],
)  # fmt: skip
def test_boxes_whose_place_is_a_guess(
    program: Path, run: Callable[..., Any], text: str, words: tuple[str, ...], said: str
) -> None:
    program.write_text(text, encoding="utf-8")
    answer = run("check", program, "--tool-length", 100, *words)
    assert answer.code == 2
    assert said in answer.err + answer.out


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--keep-out", "a=0,0,0,1,1,1", "--keep-out", "a=0,0,0,1,1,2"), "a is given twice"),
        (("--keep-out", "-3,-2,0,3,2,20"), "expected NAME=X0,Y0,Z0,X1,Y1,Z1"),
        (("--keep-out", "pin=1,2,3"), "got 3 numbers, expected NAME=X0,Y0,Z0,X1,Y1,Z1"),
        (("--keep-out", "pin=1,2,3,4,5,x"), "is not a list of numbers"),
        (("--keep-out", "pin@G5=1,2,3,4,5,6"), "'G5' is not a work system"),
        (("--stock", "0,0,0,1,-1,1"), "must be below that of the second"),
        (("--stock", "0,0,0,1,1,nan"), "is not a list of numbers"),
        (("--stock", "A:B@G54"), "expected X0,Y0,Z0,X1,Y1,Z1, two corners in mm, G54=X0,..., or program"),
    ],
)
def test_bad_options(program: Path, run: Callable[..., Any], words: tuple[str, ...], said: str) -> None:
    answer = run("check", program, "--tool-length", 100, *words)
    assert answer.code == 2
    assert said in answer.err


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            "[keep_out.a]\nmin = [0, 0, 0]\nmax = [1, 1, 1]\ndistance = 2.0\n",
            "keep_out.a.distance is not a key of a settings file; did you mean distance_mm?",
        ),
        ("[keepout.a]\n", "keepout is not a key of a settings file; did you mean keep_out?"),
        ("[keep_out.a]\nmin = [0, 0]\nmax = [1.0, 1.0, 1.0]\n", "keep_out.a.min"),
        ("[keep_out.a]\nmin = [0.0, 2.0, 0.0]\nmax = [1.0, 1.0, 1.0]\n", "y of min, 2, must be below that of max, 1"),
        ("[stock]\nmin = [0.0, 0.0, 0.0]\nmax = [1.0, 1.0, 1.0]\nsystem = 'G5'\n", "a work system such as G54"),
        ("[stock]\nmin = [0.0, 0.0, 0.0]\n", "stock: max is missing"),
        (
            "[stock]\nsize = [8, 8, 8]\n",
            "stock.size is not a key of a settings file; its table has min, max, file",
        ),
        ('stock = "program"\n', 'expected a table of keys, [stock] file = "program"; its table has min'),
        ("stock = [0, 0, 0, 8, 8, 8]\n", "expected a table of keys; its table has min, max, file, unit, system"),
    ],
)
def test_bad_settings(program: Path, run: Callable[..., Any], text: str, said: str) -> None:
    Path("verne-post.toml").write_text(text)
    answer = run("check", program, "--tool-length", 100)
    assert answer.code == 2
    assert said in answer.err


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[tool.1]\ncutter = {diameter = 0.0}\n", "tool.1.cutter.diameter = 0.0"),
        ("[tool.1]\ncutter = {diameter = 6.0}\nholder = {diameter = 40.0}\n", "tool.1.cutter needs a length"),
        ("[tool.one]\ncutter = {diameter = 6.0}\n", "its set-up gives: [tools.one] number = 3"),
        ("[tool.1]\nshank = {diameter = 6.0}\n", "tool.1.cutter"),
        ("[tool.1\n", "not a TOML file"),
    ],
)
def test_bad_tool_shapes(program: Path, run: Callable[..., Any], text: str, said: str) -> None:
    Path("s.toml").write_text(text)
    answer = run("check", program, "--tool-length", 100, "--keep-out", "a=0,0,0,1,1,1", "--tool-shapes", "s.toml")
    assert answer.code == 2
    assert "VP504" in answer.err
    assert said in answer.err


STOCK_FIRST = (
    'WORKPIECE(,"",,"BOX",112,0,-20,-80,-30,-30,30,30)\n{}G90 G71 G94\nG0 A0 C0\n{}G0 X-20 Y0\nZ30\nG0 Z-5\n'
    "G1 X50 F500\nG0 Z50\nM30\n"
)


@pytest.mark.usefixtures("without_remedies")
@pytest.mark.parametrize(
    ("text", "line"),
    [
        (STOCK_FIRST.format("G55\n", ""), 7),
        (STOCK_FIRST.format("", "G55\n"), 7),
        ("G55\n" + STOCK_FIRST.format("", ""), 7),
    ],
)
def test_a_stock_before_the_first_work_system_stands_in_that_of_the_cuts(run, tmp_path, text, line):
    """It stood in G54, beside the part: the program ran, and the cutter went through it in a rapid."""
    path = tmp_path / "part.mpf"
    path.write_text(text, encoding="utf-8")
    answer = run("check", path, "--tool-length", 80, "--wcs", "G55=0,0,40", "--stock", "program")
    assert answer.code == 1 and f"part.mpf:{line}" in answer.out and "VP216" in answer.out


def test_a_stock_in_a_work_system_without_a_place_is_refused(run, tmp_path):
    """The program names its system before it: then it is meant."""
    path = tmp_path / "part.mpf"
    path.write_text("G54\n" + STOCK_FIRST.format("", "G55\n"), encoding="utf-8")
    answer = run("check", path, "--tool-length", 80, "--wcs", "G55=0,0,40", "--stock", "program")
    assert answer.code == 2 and "line 2 defines the stock in G54, and G54 is not given" in answer.out


@pytest.mark.usefixtures("without_remedies")
def test_a_stock_of_klartext_stands_in_the_preset_of_the_cuts(run, tmp_path):
    path = tmp_path / "part.h"
    path.write_text(
        "BEGIN PGM A MM\nBLK FORM 0.1 Z X-30 Y-30 Z-20\nBLK FORM 0.2 X+30 Y+30 Z+0\nCYCL DEF 247 DATUM SETTING Q339=2\n"
        "TOOL CALL 1 Z S1000\nL X-20 Y+0 A+0 C+0 R0 FMAX M3\nL Z+30 FMAX\nL Z-5 FMAX\nL X+50 F500\nL Z+50 FMAX\n"
        "END PGM A MM\n",
        encoding="utf-8",
    )
    answer = run("check", path, "--tool-length", 80, "--wcs", "G55=0,0,40", "--stock", "program")
    assert "part.h:8" in answer.out and "VP216" in answer.out


@pytest.mark.usefixtures("without_remedies")
def test_an_end_in_a_pocket_that_lines_before_have_cut_is_found(run, tmp_path):
    """A holder of 40 mm, 20 mm above the tip: beside the whole stock no end was free, and explain found none."""
    path = tmp_path / "pocket.h"
    text = (
        "BEGIN PGM P MM\nBLK FORM 0.1 Z X-30 Y-30 Z-40\nBLK FORM 0.2 X+30 Y+30 Z+0\nTOOL CALL 2 Z S8000 F900\n"
        "L X+0 Y+0 Z+40 R0 FMAX M3\nL Z+2 FMAX\nL Z-10 F300\nL X+10 F900\nL X+0\nL Z-18\nL X+10\nL Z-25\n"
        "L Z+40 FMAX\nM30\nEND PGM P MM\n"
    )
    path.write_text(text)
    (tmp_path / "shapes.toml").write_text(
        "[tool.2]\ncutter = {diameter = 10.0, length = 12.0}\nshank = {diameter = 9.0, length = 8.0}\n"
        "holder = {diameter = 40.0}\n"
    )
    (tmp_path / "pocket.h.toml").write_text(
        'tool_shapes = "shapes.toml"\ntools = {2 = {length = 60, diameter = 10}}\nwcs = {G54 = [0, 0, 60]}\n'
        'stock = {file = "program"}\n'
    )
    refused = run("check", path).out
    assert (
        "pocket.h:12: VP216 error: the holder runs into the stock of the program: the contact begins 2.0 mm" in refused
    )
    told = run("explain", f"{path}:12").out
    assert "the line ended elsewhere: Z -19.9 in place of -25 mm" in told
    assert "no move within" not in told
    path.write_text(text.replace("Z-25", "Z-19.9"))
    assert "pocket.h:12" not in run("check", path).out
    path.write_text(text.replace("Z-25", "Z-20.1"))
    assert "pocket.h:12: VP216 error" in run("check", path).out, "and no other end is much deeper"


def test_a_tool_that_is_in_the_stock_when_a_retract_begins(run, tmp_path):
    """Another angle of the table was proposed, which moves nothing relative to the part; explain found nothing."""
    path = tmp_path / "lean.nc"
    path.write_text(
        "G21 G90 G94\nT1 M6\nS9 M3\nG54\nG0 X0 Y0 Z60 A0 C0\nG43 H1\nG0 Z5\nG1 Z0 F900\nX30 Y5 A15 C30\nG0 Z60\nM30\n"
    )
    (tmp_path / "lean.nc.toml").write_text(
        "tools = {1 = {length = 80, diameter = 10}}\nwcs = {G54 = [0, 0, 60]}\n"
        'stock = {system = "G54", min = [-10, -15, -30], max = [50, 25, 0]}\n'
    )
    refused = run("check", path)
    assert "VP216" in refused.out and "table solution" not in refused.out
    told = run("explain", f"{path}:7")
    assert "VP216 error" in told.out and "a line before it brings the tool there" in told.out
    assert "table solution: the line ends" not in told.out


@pytest.mark.parametrize(
    ("opening", "depth"),
    [
        ("G0 X20 Y20\nG43 H1 Z-5", "3."),  # rapids alone: nearest way out is sideways, past the flank
        ("G0 X20 Y20\nG43 H1\nG1 Z-5 F100", ""),  # at a feed rate the cutter may go into the stock
        ("G0 X20 Y20\nG43 H1 Z0.5", ""),
        ("G0 X20 Y20 Z50\nG43 H1", ""),
    ],
)
def test_a_first_place_in_the_stock(run, tmp_path, opening, depth):
    """No motion leads to the first place of a program, so no rapid was there to be checked."""
    path = tmp_path / "first.nc"
    path.write_text(f"G21 G90 G94\nT1 M6\nS5000 M3\nG54\n{opening}\nG1 X40 F500\nG0 Z50\nM30\n")
    given = ["--tool-shapes", tmp_path / "s.toml", "--wcs", "G54=0,0,60", "--stock", "G54=0,0,-20,80,60,0"]
    (tmp_path / "s.toml").write_text("[tool.1]\ncutter = {diameter = 8, length = 30}\n")
    said = run("check", path, "--tool-length", 80, *given).out
    assert ("VP216" in said) == bool(depth), said
    if depth:
        assert "first.nc:6" in said and "after the rapid traverse of line 6, to the first place of the program" in said
        assert f"material lies up to {depth}" in said
        assert "no work offset" not in said
