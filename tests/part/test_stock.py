"""Stock that is cut: volumes by hand and by an independent program, with and without numba, and what touches on the
way.
"""

import re
from itertools import pairwise

import numpy as np
import pytest
from msgspec.structs import replace

import verne_post as vp
from verne_post.app.stock_check import WIRE, report_touches
from verne_post.kinematics.tables.tilting import TiltingTable
from verne_post.model.findings import InputError
from verne_post.model.part_setup import Cylinder, Tool
from verne_post.part import cutting
from verne_post.part.bodies import build_pieces, measure_phi
from verne_post.part.cutting import Cut, Touch, cut_stock
from verne_post.part.dexels import Dexels, list_sweeps
from verne_post.part.motion import join_chords
from verne_post.part.ray_tables import make_table, meet_moving, meet_standing
from verne_post.part.stl import build_mesh
from verne_post.part.stock_forms import ASIDE, cross_mesh, make_box, make_cylinder, make_of_mesh, unpack
from verne_post.part.tool_spans import Spans, group_pieces, list_pairs

UP = (0.0, 0.0, 1.0)
UPRIGHT = TiltingTable(np.zeros(3), np.zeros(3), np.zeros(3), 1.0, 1.0)
FLAT = Cylinder("cutter", 10.0, 20.0)
BALL = Cylinder("cutter", 8.0, 20.0, corner_radius=4.0)
BULL = Cylinder("cutter", 10.0, 20.0, corner_radius=1.5)
SHAPES = {
    "flat": FLAT,
    "ball": BALL,
    "bull": BULL,
    "taper": Cylinder("cutter", 6.0, 20.0, corner_radius=1.0, taper=5.0),
    "dovetail": Cylinder("cutter", 10.0, 10.0, taper=-15.0),
    "drill": Cylinder("cutter", 6.0, 20.0, point_angle=118.0),
    "lollipop": Cylinder("cutter", 8.0, 20.0, neck_diameter=3.0),
    "form": Cylinder("cutter", 16.0, 20.0, profile=((3, 0), (5, 2), (5, 6), (2, 9), (2, 12), (8, 15), (8, 20))),
}
WITH_NUMBA = [
    False,
    pytest.param(True, marks=pytest.mark.skipif("not __import__('importlib').util.find_spec('numba')")),
]


def box(x: float, y: float, z: float, cell: float = 0.1) -> Dexels:
    return make_box(np.zeros(3), np.array([x, y, z]), np.zeros(3), 0.0, cell)


def cut(
    stock: Dexels, shape: Cylinder, tip: object, axis: object = (UP, UP), *, step: float = 0.05, compiled: bool = False
) -> float:
    """Cut spans (n, 2, 3), or one; the volume."""
    tips = np.asarray(tip, dtype=float).reshape(-1, 2, 3)
    axes = np.broadcast_to(np.asarray(axis, dtype=float).reshape(-1, 2, 3), tips.shape).copy()
    return sum(
        float(stock.cut(list_sweeps(tips, axes, piece.high, step), make_table(piece), compiled=compiled).sum())
        for piece in build_pieces((shape,), shape.length or 0.0)
    )


# --- rays and bodies ------------------------------------------------------------------------------


def test_rays_meet_a_ball_with_a_leaning_flank() -> None:
    """Its pieces together: where the flank ends the one has an edge, and the other is round."""
    pieces = build_pieces((Cylinder("cutter", 10.0, 20.0, corner_radius=5.0, taper=40.0),), 20.0)
    rng = np.random.default_rng(3)
    for _ in range(8):
        axis = np.abs(rng.normal(size=3)) + [0.0, 0.0, 0.2]
        axis /= np.linalg.norm(axis)
        x, y = rng.uniform(-12, 12, (2, 2000))
        ends = [meet_standing(make_table(piece), x, y, axis) for piece in pieces]
        first = np.min([np.where(low < high, low, np.inf) for low, high in ends], axis=0)
        hit = np.isfinite(first)
        assert hit.sum() > 200
        phi = measure_phi(pieces, np.column_stack([x, y, first])[hit], np.zeros(3), axis)
        assert np.abs(phi).max() < 1e-9


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
def test_rays_meet_bodies_where_their_distance_is_zero(shape: Cylinder) -> None:
    rng = np.random.default_rng(3)
    z = np.linspace(-25, 35, 400)
    for piece in build_pieces((shape,), 20.0):
        table = make_table(piece)
        for k in range(8):
            axis = rng.normal(size=3) if k else np.array(UP)
            axis[2] = abs(axis[2]) + 0.2
            axis /= np.linalg.norm(axis)
            x, y = rng.uniform(-12, 12, (2, 200))
            low, high = meet_standing(table, x, y, axis)
            point = np.stack(np.broadcast_arrays(x[:, None], y[:, None], z), axis=-1)
            phi = measure_phi((piece,), point, np.zeros(3), axis)
            inside = (z > low[:, None]) & (z < high[:, None])
            # where both disagree the point is on the surface
            assert np.abs(phi[(phi < 0) != inside]).max(initial=0.0) < 1e-9
            if not k:
                at = np.zeros(3)
                both = low < high
                moving = meet_moving(table, x, y, at, at)
                assert ((moving[0] < moving[1]) == both).all()
                assert np.allclose([one[both] for one in moving], [low[both], high[both]], rtol=0, atol=1e-9)


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
def test_a_straight_move_is_the_union_of_all_its_places(shape: Cylinder) -> None:
    rng = np.random.default_rng(5)
    share = np.linspace(0, 1, 4001)[:, None]
    for start, end in (
        ((0, 0, 0), (9, 4, 0)),
        ((1, 2, 3), (1, 2, -5)),
        ((0, 0, 0), (6, -3, 4)),
        ((2, 1, 5), (5, 5, -2)),
    ):
        start, end = np.array(start, float), np.array(end, float)
        for piece in build_pieces((shape,), 20.0):
            table = make_table(piece)
            for x, y in rng.uniform(-8, 12, (25, 2)):
                low, high = meet_moving(table, np.array([x]), np.array([y]), start, end)
                tip = start + share * (end - start)
                standing = meet_standing(table, x - tip[:, 0], y - tip[:, 1], np.array(UP))
                hit = standing[0] < standing[1]
                if hit.any():
                    # between two of 4001 places a round edge rises by less than this
                    assert (
                        low[0] <= (standing[0] + tip[:, 2])[hit].min() + 1e-7
                    )  # halving leaves a billionth of the way
                    assert high[0] >= (standing[1] + tip[:, 2])[hit].max() - 1e-7
                    if hit.sum() > 100:  # not at the rim, where a flank is vertical
                        assert low[0] == pytest.approx((standing[0] + tip[:, 2])[hit].min(), abs=5e-3)
                else:
                    assert (
                        not low[0] < high[0]
                        or measure_phi((piece,), np.array([x, y, 0.5 * (low[0] + high[0])]), tip, np.array(UP)).min()
                        < 0.01
                    )


# --- volumes --------------------------------------------------------------------------------------


@pytest.mark.parametrize("compiled", WITH_NUMBA)
def test_volumes_by_hand(compiled: bool) -> None:
    """Bounds as measured at 0.1 mm: half a cell at a wall is the largest error."""
    assert cut(box(40, 20, 20), FLAT, ((-10, 10, 14), (50, 10, 14)), compiled=compiled) == pytest.approx(
        2400.0, abs=1e-6
    )
    # blind slot of a ball: a half cylinder, and half a ball at both ends
    assert cut(box(40, 20, 20), BALL, ((10, 10, 16), (30, 10, 16)), compiled=compiled) == pytest.approx(
        636.696, rel=8e-4
    )
    assert cut(box(40, 20, 20), BULL, ((20, 10, 40), (20, 10, 12)), compiled=compiled) == pytest.approx(
        614.166, rel=1e-3
    )
    stock = box(40, 20, 20)
    hole = Cylinder("cutter", 6.0, 40.0)
    removed = cut(stock, hole, ((20, -30, 10), (20, 22, 10)), ((0, -1, 0), (0, -1, 0)), compiled=compiled)
    assert removed == pytest.approx(565.487, rel=8e-4)
    assert (stock.high > stock.low).sum(axis=2).max() == 2
    assert stock.measure_volume() + removed == pytest.approx(16000.0, abs=1e-6)


def test_nothing_is_lost_where_rays_have_many_intervals() -> None:
    stock = box(20, 20, 60, 0.5)
    removed = sum(
        cut(stock, Cylinder("cutter", 2.0, 60.0), ((10, -30, z), (10, 22, z)), ((0, -1, 0), (0, -1, 0)))
        for z in range(5, 60, 5)
    )
    assert (stock.high > stock.low).sum(axis=2).max() == 12
    assert stock.measure_volume() + removed == pytest.approx(24000.0, abs=1e-6)


def test_a_ramp_leaves_nothing_behind() -> None:
    """45 degrees with a flat tool: swept as one body where it stands upright, else teeth of at most half the step."""
    upright, turned = box(40, 20, 20, 0.25), box(40, 20, 20, 0.25)
    way = np.array([(10.0, 10, 18), (20, 10, 8)])
    cut(upright, FLAT, way)
    cut(turned, FLAT, way, np.tile([1e-6, 0.0, 1.0], (2, 1)), step=0.2)
    i, j = 80, 40  # below the tip's end: the deepest place of the tool's way
    for x in np.arange(8.0, 22.0, 0.25):
        k = int(x / 0.25)
        at = (k + 0.5) * 0.25
        floor = 8 + max(0.0, 20 - 5.0 - at)  # the lower edge of the disc on its way down
        if at < 15:
            assert upright.high[k, j, 0] == pytest.approx(18 - (at + 5 - 10) if at + 5 < 20 else 8, abs=0.01)
        assert -1e-4 <= turned.high[k, j, 0] - upright.high[k, j, 0] <= 0.2 * np.sin(np.pi / 4) + 1e-5
        assert floor <= 20
    assert upright.high[i, j, 0] == pytest.approx(8.0, abs=1e-9)


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
def test_numba_has_the_same_answers(shape: Cylinder) -> None:
    pytest.importorskip("numba")
    rng = np.random.default_rng(7)
    tips = rng.uniform((0, 0, 4), (30, 30, 22), (24, 2, 3))
    axes = 0.3 * rng.normal(size=(24, 2, 3)) + UP
    axes[:12] = UP
    axes /= np.linalg.norm(axes, axis=-1, keepdims=True)
    tips[5, 1, 2], tips[6, 1, :2], tips[7, 1] = tips[5, 0, 2], tips[6, 0, :2], tips[7, 0]
    stocks = box(30, 30, 20, 0.4), box(30, 30, 20, 0.4)
    for piece in build_pieces((shape,), 20.0):
        table, sweeps = make_table(piece), list_sweeps(tips, axes, 20.0, 2.0)
        volumes = [stock.cut(sweeps, table, compiled=flag) for stock, flag in zip(stocks, (False, True), strict=True)]
        assert np.allclose(*volumes, rtol=0, atol=1e-8)
        for by in (-0.005, 0.1):
            touching = [stocks[0].find_touching(sweeps, table.extend(by), compiled=flag) for flag in (False, True)]
            assert (touching[0] == touching[1]).all()
        assert not stocks[0].find_touching(sweeps, table.extend(-0.005), compiled=False).any()


@pytest.mark.parametrize("compiled", WITH_NUMBA)
def test_rays_with_many_intervals_do_not_widen_the_others(compiled: bool) -> None:
    """100 thin discs above each other, cut out of the same few of 1600 rays, and half of them again by a long body."""
    stock, tips = box(20, 20, 101, 0.5), np.array([[[2.0, 2.0, z + 0.25]] * 2 for z in range(1, 101)])
    discs = list_sweeps(tips, np.broadcast_to(UP, tips.shape), 0.5, 0.1)
    (disc,), (wide,) = (build_pieces((Cylinder("cutter", size, 0.5),), 0.5) for size in (2.0, 3.5))
    volumes = stock.cut(discs, make_table(disc), compiled=compiled)
    assert volumes == pytest.approx(np.full(100, 12 * 0.5**3))  # 12 rays 0.5 apart pass a disc of 2 mm
    there = stock.high > stock.low
    assert (there.sum(axis=2).max(), there.sum()) == (101, 1600 + 100 * 12)
    assert stock._low.shape == (40, 40, 2)
    assert stock._more_low.nbytes < 200_000  # all rays with so many would have 1.6 MB
    assert not stock.find_touching(discs, make_table(disc), compiled=compiled).any()
    assert stock.find_touching(discs, make_table(wide), compiled=compiled).all()
    again = unpack(stock.pack(), "left.npz")
    for one in (stock, again, stock.copy()):
        assert one.measure_volume() == pytest.approx(20 * 20 * 101 - volumes.sum())
    assert cut(stock, Cylinder("cutter", 2.0, 50.0), [(2, 2, 51)] * 2, compiled=compiled) == pytest.approx(
        12 * 25 * 0.25
    )
    assert (stock.high > stock.low).sum(axis=2).max() == 51


@pytest.mark.parametrize(
    ("corner", "turning", "step"), [(4.0, 1.0, 0.1), (1.0, 0.0, 0.1), (0.0, 0.0, 0.02)], ids=["ball", "bull", "flat"]
)
def test_an_independent_program_has_the_same_volume(corner: float, turning: float, step: float) -> None:
    """Hulls of neighbouring places of a 96-gon, inside and about the tool, against rays: in their bracket, to 0.03 %.

    A hull of two places is the sweep where the tool does not turn, and of a ball. Teeth of a tilted edge are
    taken off by finer steps.
    """
    manifold3d = pytest.importorskip("manifold3d")
    t = np.linspace(0, 1, 21)
    tips = np.column_stack([5 + 30 * t, 10 + 4 * np.sin(5 * t), 15 - 3 * np.sin(7 * t)])
    bent = turning * t
    axes = np.column_stack([0.1 + 0.2 * np.sin(4 * bent), 0.15 * np.cos(3 * bent), np.ones_like(t)])
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    around, arc = np.arange(96) * np.pi / 48, np.linspace(0, np.pi / 2, 13)

    def measure_volume(scale: float, round_scale: float) -> float:
        r = scale * np.append(4.0 - corner + round_scale * corner * np.sin(arc), 4.0)
        h = np.append(corner - round_scale * corner * np.cos(arc), 12.0)
        cloud = np.stack(np.broadcast_arrays(r[:, None] * np.cos(around), r[:, None] * np.sin(around), h[:, None]), -1)
        places = []
        for tip, u in zip(tips, axes, strict=True):
            side = np.cross(u, (1.0, 0.0, 0.0))
            side /= np.linalg.norm(side)
            places.append(tip + cloud.reshape(-1, 3) @ np.stack([np.cross(side, u), side, u]))
        hulls = [manifold3d.Manifold.hull_points(np.concatenate(pair)) for pair in pairwise(places)]
        swept = manifold3d.Manifold.batch_boolean(hulls, manifold3d.OpType.Add)
        return float((manifold3d.Manifold.cube((40, 20, 20)) ^ swept).volume())

    inside, about = measure_volume(1.0, 1.0), measure_volume(1.0 / np.cos(np.pi / 96), 1.0 / np.cos(np.pi / 48))
    spans = np.stack([tips[:-1], tips[1:]], axis=1), np.stack([axes[:-1], axes[1:]], axis=1)
    removed = cut(box(40, 20, 20), Cylinder("cutter", 8.0, 12.0, corner_radius=corner), *spans, step=step)
    assert inside * (1 - 3e-4) <= removed <= about * (1 + 3e-4), (inside, removed, about)


# --- forms ----------------------------------------------------------------------------------------


def test_cylinders_and_meshes_are_stock() -> None:
    ring = make_cylinder(np.zeros(3), np.array([20.0, 20, 10]), 4.0, np.zeros(3), 0.0)
    assert ring.measure_volume() == pytest.approx(np.pi * (100 - 4) * 10, rel=5e-4)
    manifold3d = pytest.importorskip("manifold3d")
    hole = manifold3d.Manifold.cylinder(40, 4, 4, 48).rotate((90, 0, 0)).translate((10, 30, 6))
    body = manifold3d.Manifold.cube((30, 20, 10)).translate((-3, 4, 1)) - hole
    raw = body.to_mesh()
    corner = np.asarray(raw.vert_properties)[:, :3][np.asarray(raw.tri_verts)].astype(float)
    stock = make_of_mesh(build_mesh("part", corner), np.array([1.0, 2, 3]), 0.3)
    assert stock.measure_volume() == pytest.approx(body.volume(), rel=3e-4)
    assert (stock.high > stock.low).sum(axis=2).max() == 2
    low, high = stock.merge_columns()
    assert np.prod(high - low, axis=1).sum() == pytest.approx(stock.measure_volume())
    # what is left is the next set-up's stock, at the same place
    again = unpack(stock.pack(), "left.npz")
    assert (again.low == stock.low).all()
    assert (again.origin == stock.origin).all()
    assert again.turn == 0.3


def test_rays_meet_triangles_where_all_of_them_are_asked() -> None:
    """Random triangles, thin ones, and ones with an upright edge or a corner on a column of rays: no ray is
    left out.
    """
    rng = np.random.default_rng(7)
    corner = rng.uniform(-4, 30, (400, 3, 3))
    corner[:100, 2] = corner[:100, :2].mean(axis=1) + rng.normal(size=(100, 3)) * 1e-3
    corner[100:150, 1, 0] = corner[100:150, 0, 0]
    corner[150:200, 1] = np.round(corner[150:200, 1]) + 0.5 + np.array([*ASIDE, 0.0])
    corner[200:220, :, 0] = corner[200:220, :1, 0] + rng.normal(size=(20, 3)) * 1e-4
    x, y = (one.ravel() + 0.5 + aside for one, aside in zip(np.indices((27, 21)), ASIDE, strict=True))
    crossings = 0
    for one in corner:
        ray, z, side = cross_mesh(one[None], (27, 21))
        a, b, c = one[:, :2]
        share = np.linalg.solve(np.column_stack([b - a, c - a]), np.stack([x - a[0], y - a[1]]))
        inside = np.minimum(share.min(axis=0), 1 - share.sum(axis=0))
        met = np.isin(np.arange(len(x)), ray)
        # on an edge rounding decides
        assert met[inside > 1e-9].all()
        assert not met[inside < -1e-9].any()
        assert z == pytest.approx((one[0, 2] + (one[1:, 2] - one[0, 2]) @ share)[ray], abs=1e-6)
        assert (side == -np.sign(np.linalg.det([b - a, c - a]))).all()
        crossings += len(ray)
    assert crossings > 10_000


def test_a_file_that_is_no_stock_is_refused() -> None:
    with pytest.raises(InputError, match=r"left\.npz: not a stock file"):
        unpack(b"solid", "left.npz")


def test_a_mesh_inside_another_is_material_once_and_a_turned_one_is_refused() -> None:
    face = [((0, 0, 0), (0, 1, 0), (1, 1, 0)), ((0, 0, 0), (1, 1, 0), (1, 0, 0))]
    cube = []
    for axis in range(3):
        for triangle in face:
            flat = np.roll(np.array(triangle, float), axis, axis=1)
            cube += [flat, flat[::-1] + np.roll([0.0, 0, 1], axis)]
    corner = np.array(cube)
    both = np.concatenate([10 * corner, 4 * corner + 3.0])
    stock = make_of_mesh(build_mesh("two", both), np.zeros(3), 0.0)
    assert stock.measure_volume() == pytest.approx(1000.0, rel=1e-5)
    inverted = np.concatenate([10 * corner, 4 * corner[:, ::-1] + 20.0])
    with pytest.raises(InputError, match="more often than it enters"):
        make_of_mesh(build_mesh("two", inverted), np.zeros(3), 0.0)


# --- touches --------------------------------------------------------------------------------------


def run(
    moves: list[tuple[str, float, float, float]],
    *shape: Cylinder,
    stock: Dexels | None = None,
    tilt: float = 0.0,
    is_line: bool = False,
) -> Cut:
    """Moves (word, x, y, z) of one tool from far above, which leans towards +x; line k + 1 is move k."""
    at = np.array([(*moves[0][1:3], 60.0), *(move[1:] for move in moves)], dtype=float)
    n = len(moves)
    rapid = np.array([move[0] == "G0" for move in moves])
    axes = np.tile([np.sin(tilt), 0.0, np.cos(tilt)], (n, 2, 1))
    spans = Spans(np.stack([at[:-1], at[1:]], axis=1), axes, np.arange(1, n + 1), np.zeros(n, dtype=int), rapid)
    tool = replace(group_pieces(build_pieces(shape, 60.0, joined=False)), is_line=is_line)
    return cut_stock(stock or box(60, 40, 20), spans, [tool])


HOLDER = Cylinder("holder", 40.0)
LONG = Cylinder("cutter", 10.0, 25.0)


def found(result: Cut) -> list[tuple[int, str, str]]:
    return [(one.line, one.body, "in it" if one.depth == one.depth else "open") for one in result.touches]


@pytest.mark.parametrize(
    ("moves", "expected"),
    [
        ([], []),
        ([("G0", -10, 10, 14)], []),  # back through its own slot
        ([("G0", 20, 10, 14), ("G0", 20, 10, 40)], []),
        ([("G0", 70, 10.001, 14), ("G0", -10, 10.001, 14)], []),  # within what may touch
        ([("G0", 70, 10.02, 14), ("G0", -10, 10.02, 14)], [(5, "cutter", "open")]),
        ([("G0", 70, 10.2, 14), ("G0", -10, 10.2, 14)], [(5, "cutter", "in it")]),
        ([("G0", 70, 10, 13.9), ("G0", -10, 10, 13.9)], [(5, "cutter", "in it")]),
        ([("G0", -10, 10, 40), ("G0", -10, 30, 40), ("G0", -10, 30, 14), ("G0", 70, 30, 14)], [(7, "cutter", "in it")]),
    ],
)  # fmt: skip
def test_a_rapid_is_checked_against_the_stock_as_it_is_then(
    moves: list[tuple[str, float, float, float]], expected: object
) -> None:
    slot = [("G0", -10, 10, 40), ("G0", -10, 10, 14), ("G1", 70, 10, 14)]
    result = run([*slot, *moves], LONG, HOLDER)
    assert found(result) == expected
    assert result.volume[2] == pytest.approx(3600.0, abs=1e-6)
    stock = box(60, 40, 20)
    whole = stock.measure_volume()
    by_line = run([*slot, *moves], LONG, HOLDER, stock=stock).sum_by(np.arange(1, len(result.volume) + 1))
    assert sum(by_line.values()) == pytest.approx(whole - stock.measure_volume(), abs=1e-6)


@pytest.mark.parametrize(
    ("moves", "tilt", "expected"),
    [
        ([("G0", 30, 10, 5)], 0, [(1, "in it")]),  # nothing was cut before
        ([("G1", 30, 30, 21), ("G0", 30, 10, 14)], 0, [(2, "in it")]),  # nor by a cut in the air
        ([("G1", 30, 30, 14), ("G0", 30, 30, 40), ("G0", 30, 10, 40), ("G0", 30, 10, 14)], 0, [(4, "open")]),
        ([("G1", 30, 30, 14), ("G0", 30, 30, 40), ("G0", 30, 10, 40), ("G0", 30, 10, 13)], 0, [(4, "in it")]),
        # nor where no cutter reaches from its cut: aside, from beside the stock, and along a rapid
        ([("G1", 2, 2, 14), ("G0", 2, 2, 40), ("G0", 50, 38, 40), ("G0", 50, 38, 14)], 0, [(4, "in it")]),
        ([("G1", -30, 10, 14), ("G0", -30, 10, 40), ("G0", 30, 10, 40), ("G0", 30, 10, 14)], 0, [(4, "in it")]),
        ([("G0", -20, 10, 14), ("G1", 5, 10, 14), ("G0", 70, 10, 14)], 0, [(3, "in it")]),
        # a face mill: 20 mm and 50 mm of room beside the stock
        ([("G0", -20, 0, 14), ("G1", 60, 0, 14), ("G0", 60, 0, 40), ("G0", 30, 18, 40), ("G0", 30, 18, 14)], 0,
         [(5, "open")]),
        ([("G0", -20, 0, 14), ("G1", 60, 0, 14), ("G0", 60, 0, 40), ("G0", 30, 35, 40), ("G0", 30, 35, 14)], 0,
         [(5, "in it")]),
        ([("G0", -50, 0, 14), ("G1", 60, 0, 14), ("G0", 60, 0, 40), ("G0", 30, 35, 40), ("G0", 30, 35, 14)], 0,
         [(5, "open")]),
        # a hole of one span that is deeper than a cutter is long
        ([("G1", 30, 10, -115), ("G0", 30, 10, 40), ("G0", 33, 10, 40), ("G0", 33, 10, -110)], 0, [(4, "open")]),
        # out of its cut along z, and out of a plunge along its axis
        ([("G1", -10, 10, 14), ("G1", 30, 10, 14), ("G1", 30, 12, 14), ("G0", 30, 12, 60)], 0.2, [(4, "open")]),
        ([("G1", 30, 10, 14), ("G0", 30 + 46 * np.tan(0.2), 10, 60)], 0.2, []),
    ],
)  # fmt: skip
def test_what_a_cutter_of_unknown_diameter_has_cut_is_open_above_its_tip(
    moves: list[tuple[str, float, float, float]], tilt: float, expected: list[tuple[int, str]]
) -> None:
    """As a thin line it leaves a groove: a retract along z was said to be in the stock, however wide the cutter is."""
    result = run(moves, WIRE, tilt=tilt, is_line=True)
    assert [(line, state) for line, _body, state in found(result)] == expected
    assert all(one.by_line == (one.depth != one.depth) for one in result.touches)
    assert all((one.line_gap > 20.0) == (one.depth == one.depth) for one in result.touches if one.line > 1)


def test_a_second_rapid_through_the_same_place_is_clear() -> None:
    result = run([("G0", -10, 10, 14), ("G0", 70, 10, 14), ("G0", -10, 10, 14)], LONG)
    assert [(one.line, one.body) for one in result.touches] == [(2, "cutter")]
    assert result.touches[0].depth == pytest.approx(5.0, abs=0.15)  # 6 mm deep, and 5 mm from its side
    assert result.volume[1] == pytest.approx(3600.0, abs=1e-6)


def test_a_rapid_away_from_a_wall_is_clear() -> None:
    """Along a wall, then off it: nothing comes nearer to the stock than it was while it was cut."""
    wall = [
        ("G0", -10, 3, 40),
        ("G0", -10, 3, 5),
        ("G1", 70, 3, 5),
        ("G0", -10, 3, 5),
        ("G1", -10, 4, 5),
        ("G1", 30, 4, 5),
    ]
    assert found(run([*wall, ("G0", 30, -8, 5)], LONG)) == []
    assert found(run([*wall, ("G0", 30, 4.5, 5)], LONG)) == [(7, "cutter", "in it")]


def test_holders_and_thick_shanks_touch_the_stock_as_it_is_then() -> None:
    short = Cylinder("cutter", 10.0, 5.0)
    slot = [("G0", -25, 20, 40), ("G0", -25, 20, 14), ("G1", 30, 20, 14)]
    higher = [(word, x, y, max(z, 16)) for word, x, y, z in slot]
    coarse = box(60, 40, 20, 0.4)
    assert (3, "holder", "in it") in found(run(slot, short, HOLDER, stock=coarse.copy()))
    assert found(run(higher, short, Cylinder("shank", 9.0, 30.0), HOLDER, stock=coarse.copy())) == []
    assert found(run(slot, short, Cylinder("shank", 9.0, 30.0), HOLDER, stock=coarse.copy())) == [(3, "shank", "in it")]
    # a pocket as wide as the holder, cut before: the holder goes down where it could not
    wide = [("G0", -25, 20, 40), ("G0", -25, 20, 14), ("G1", 90, 20, 14)]
    stock = coarse.copy()
    run(wide, Cylinder("cutter", 50.0, 30.0), stock=stock)
    assert found(run([("G0", -25, 20, 40), ("G0", -25, 20, 10), ("G1", 90, 20, 10)], short, HOLDER, stock=stock)) == []


@pytest.mark.parametrize(("last", "depth", "most"), [(-7.0, 2.0, 8), (-9.0, 4.0, 30)])
def test_a_long_contact_is_measured_only_where_it_becomes_deeper(
    last: float, depth: float, most: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A holder 2 mm deep all along, or down to 4 mm: every mm was measured, 50 times."""
    asked = []
    measure = cutting._Run._measure_depth
    monkeypatch.setattr(cutting._Run, "_measure_depth", lambda *a: asked.append(1) or measure(*a))
    first = min(last + 2.0, -7.0)
    moves = [("G0", -30, 20, 60), ("G0", -30, 20, first), ("G1", 30, 20, last)]
    (touch,) = run(moves, LONG, HOLDER, stock=box(60, 40, 20, 0.2)).touches
    assert (touch.line, touch.body) == (3, "holder")
    assert depth - max(0.1, 0.05 * depth) <= touch.depth <= depth + 0.01
    assert len(asked) <= most


@pytest.mark.parametrize("cell", [0.1, 0.4])
@pytest.mark.parametrize("deeper", [0.02, 0.049, 0.099])
def test_an_edge_between_rays_is_not_told_too_shallow_as_a_contact_deepens(deeper: float, cell: float) -> None:
    """A holder goes onto an edge by 0.5 mm, then by a little more: that and the distance of the rays added up."""
    depth = np.array([-0.5, 0.5, 0.5 + deeper])
    off = (depth - 20.0) / np.sqrt(2.0)
    tip = np.column_stack([off, off, np.full(3, -27.0)])
    zeros = np.zeros(2, dtype=int)
    spans = Spans(list_pairs(tip, tip)[0], np.tile(UP, (2, 2, 1)), zeros + 7, zeros, zeros > 0)
    tools = [group_pieces(build_pieces((LONG, HOLDER), 60.0, joined=False))]
    found = max(one.depth for one in cut_stock(box(10, 10, 4, cell), spans, tools).touches)
    assert depth[-1] - max(0.1, cell) <= found <= depth[-1] + 1e-6


def test_short_spans_of_a_turning_line_are_checked_together(monkeypatch: pytest.MonkeyPatch) -> None:
    """40 mm in 400 chords as in 4: each chord was cut and checked by itself."""
    lean = np.radians([30.0, 31.0])
    asked, answers = [], []
    check = cutting._Run._check
    monkeypatch.setattr(cutting._Run, "_check", lambda *a: asked.append(1) or check(*a))
    for chords in (4, 400):
        share = np.linspace(0.0, 1.0, chords + 1)
        angle = lean[0] + share * (lean[1] - lean[0])
        tip = np.column_stack([10 + 40 * share, np.full(chords + 1, 20.0), np.full(chords + 1, -5.0)])
        axis = np.column_stack([0 * share, -np.sin(angle), np.cos(angle)])
        zeros = np.zeros(chords, dtype=int)
        spans = Spans(*list_pairs(tip, axis), zeros + 7, zeros, zeros > 0)
        tools = [group_pieces(build_pieces((BALL, Cylinder("shank", 12.0, 10.0), HOLDER), 60.0, joined=False))]
        touches = cut_stock(box(60, 40, 20, 0.4), spans, tools).touches
        answers.append({one.body: max(o.depth for o in touches if o.body == one.body) for one in touches})
        answers[-1] |= {f"begin {one.body}": one.begin[0] for one in reversed(touches)}
    assert answers[0].keys() == answers[1].keys() >= {"shank"}
    assert answers[1] == pytest.approx(answers[0], rel=0.05, abs=0.11)
    assert len(asked) <= 2 * 41


def test_what_is_asked_ahead_hides_no_contact(monkeypatch: pytest.MonkeyPatch) -> None:
    """A holder meets what a later span of its block cuts, and what the shank has left; slanting ways, two pieces."""
    shape = (
        Cylinder("cutter", 8.0, 6.0, corner_radius=2.0),
        Cylinder("shank", 8.0, 4.0),
        Cylinder("holder", 20.0, 30.0),
    )
    tools = [group_pieces(build_pieces(shape, 60.0, joined=False))]
    places = np.random.default_rng(7).uniform((5, 5, -9), (55, 35, 2), (14, 3))
    tip = np.stack([places[:-1], places[1:]], axis=1)
    tip = np.concatenate([tip, np.stack([places[-1], places[-1] + (0, 0, 20)])[None]])
    zeros = np.zeros(len(tip), dtype=int)
    spans = Spans(tip, np.tile(UP, (len(tip), 2, 1)), np.arange(len(tip)), zeros, zeros > 0)
    found = []
    for ahead in (1, cutting.MOST_AHEAD):
        monkeypatch.setattr(cutting, "MOST_AHEAD", ahead)
        stock = box(60, 40, 20, 1.0)
        cut = cut_stock(stock, spans, tools)
        found.append((cut.touches, cut.volume.tolist(), stock.measure_volume()))
    every = cutting._Run._find_met
    monkeypatch.setattr(cutting._Run, "_find_met", lambda run, tip, *a: np.ones_like(every(run, tip, *a)))
    stock = box(60, 40, 20, 1.0)
    cut = cut_stock(stock, spans, tools)
    assert {one.body for one in cut.touches} == {"shank", "holder"}
    assert found == [(cut.touches, pytest.approx(cut.volume.tolist()), pytest.approx(stock.measure_volume()))] * 2


def test_chords_are_joined_where_they_are_nearly_one_line() -> None:
    def join(tip: np.ndarray, axis: np.ndarray | None = None, owner: np.ndarray | None = None) -> list[int]:
        axis = np.tile([0.0, 0.0, 1.0], (len(tip), 1)) if axis is None else axis
        owner = np.zeros(len(tip), dtype=int) if owner is None else owner
        first, last = join_chords(tip, axis, owner, np.flatnonzero(np.diff(owner) == 0))
        assert (first[1:] >= last[:-1]).all() and last[-1] == len(tip) - 1
        return (last - first).tolist()

    angle = np.linspace(0.0, 2 * np.pi, 65)
    for radius, joined in (
        (0.5, 1),
        (0.1, 2),
        (0.04, 4),
        (0.006, 8),
    ):  # a chord of the angle a is radius (1 - cos(a / 2)) off
        circle = radius * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
        assert join(circle) == [joined] * (64 // joined)
    line = np.column_stack([np.linspace(0.0, 5.0, 24), np.zeros(24), np.zeros(24)])
    assert join(line) == [16, 4, 2, 1]
    assert join(line, owner=np.repeat([0, 1], 12)) == [8, 2, 1, 8, 2, 1]
    back = np.concatenate([line[:4], line[2::-1], line[1:2]])  # there and back is no straight way
    assert max(join(back)) == 2
    turning = np.column_stack([np.zeros(24), np.sin(line[:, 0] * 1e-3), np.cos(line[:, 0] * 1e-3)])
    assert join(line, turning) == [1] * 23


@pytest.mark.parametrize("lower", [0.0, 0.2])
def test_a_body_that_passes_too_near_says_how_near(lower: float) -> None:
    """A holder 0.3 mm above the stock, or down to 0.1 mm, that has to keep 0.5 mm off: it always said 0 mm."""
    moves = [("G0", -40, 20, 60), ("G0", -40, 20, -4.7), ("G1", 40, 20, -4.7 - lower)]
    tip = np.array([[(*a[1:],), (*b[1:],)] for a, b in pairwise(moves)], dtype=float)
    zeros = np.zeros(2, dtype=int)
    spans = Spans(tip, np.tile(UP, (2, 2, 1)), np.arange(2), zeros, np.array([True, False]))
    tools = [group_pieces(build_pieces((LONG, HOLDER), 60.0, joined=False))]
    done = cut_stock(box(60, 40, 20, 0.4), spans, tools, 0.5)
    (item,) = report_touches(UPRIGHT, done, spans, tools, "the stock", 0.5, 0.4)
    said = re.search(r"passes the stock at (\S+) mm, nearer than 0.5 mm", item.message)
    assert said is not None
    assert float(said[1]) == pytest.approx(0.3 - lower, abs=0.06)


def test_a_remedy_that_fails_is_cut_up_to_its_first_touch() -> None:
    moves = [("G0", -30, 20, 60), ("G0", -30, 20, -7), ("G1", 30, 20, -7), ("G1", 30, 40, -7)]
    tip = np.array([[(*a[1:],), (*b[1:],)] for a, b in pairwise(moves)], dtype=float)
    zeros = np.zeros(3, dtype=int)
    spans = Spans(tip, np.tile(UP, (3, 2, 1)), np.arange(3), zeros, np.array([True, False, False]))
    tools = [group_pieces(build_pieces((LONG, HOLDER), 60.0, joined=False))]
    whole, first, of_holder, of_shank = (
        cut_stock(box(60, 40, 20, 0.4), spans, tools, only_first=asked) for asked in (False, True, "holder", "shank")
    )
    assert [(one.line, one.body) for one in whole.touches] == [(1, "holder"), (2, "holder")]
    assert [(one.line, one.body) for one in first.touches] == [(1, "holder")]
    assert first.volume[2] == 0 < whole.volume[2]
    assert first.volume[1] < 0.5 * whole.volume[1]
    assert (of_holder.touches, of_holder.volume.tolist()) == (first.touches, first.volume.tolist())
    assert of_shank.volume.tolist() == whole.volume.tolist()


@pytest.mark.parametrize("keep_off", [0.0, 0.5])
def test_which_spans_touch_does_not_depend_on_their_depth(keep_off: float) -> None:
    """Remedies ask which lines have a contact. A holder that plunges, leans, leaves and comes back, in short spans."""
    at = np.linspace(0.0, 1.0, 41)
    tip = np.column_stack([60 * at - 20, 10 + 20 * np.abs(np.sin(9 * at)), -3 - 6 * np.sin(7 * at)])
    lean = 0.2 * np.sin(11 * at)
    axis = np.column_stack([lean, np.zeros(41), np.sqrt(1 - lean**2)])
    lines, zeros = np.repeat(np.arange(5), 8), np.zeros(40, dtype=int)
    rapid = (lines == 2) | (lines == 4)
    corner = np.where(rapid & (np.arange(40) % 8 == 0), 0.3, 0.0)
    spans = Spans(*list_pairs(tip, axis), lines, zeros, rapid, corner)
    tools = [group_pieces(build_pieces((LONG, HOLDER), 60.0, joined=False))]
    whole, asked = (
        cut_stock(box(60, 40, 20, 0.4), spans, tools, keep_off, only_spans=only_spans) for only_spans in (False, True)
    )
    assert {one.line for one in whole.touches} == {0, 1, 2, 4}
    touching = [[(one.span, one.body, one.depth == one.depth) for one in cut.touches] for cut in (whole, asked)]
    assert touching[0] == touching[1]
    np.testing.assert_allclose(whole.volume, asked.volume, rtol=1e-12)  # compiled or not, from some number of bodies on


def test_bodies_of_short_spans_are_no_nearer_than_those_of_a_long_one() -> None:
    """Spans a little longer than the step had two bodies each."""
    tip = np.column_stack([np.linspace(0.0, 9.3, 89), np.zeros(89), np.zeros(89)])
    axis = np.tile([0.0, -0.6, 0.8], (89, 1))
    long = list_sweeps(tip[None, [0, -1]], axis[None, [0, -1]], 20.0, 0.1)
    short = list_sweeps(*list_pairs(tip, axis), 20.0, 0.1)
    assert len(short) == len(long) == 94
    assert short.end == pytest.approx(long.end, abs=1e-9)
    assert (np.diff(short.owner) >= 0).all() and short.owner[-1] == 87


@pytest.mark.skipif("not __import__('importlib').util.find_spec('numba')")
def test_few_long_tilted_cuts_are_worth_compiling(monkeypatch: pytest.MonkeyPatch) -> None:
    """They are as many bodies as thousands of short ones: four lines of 80 mm. So are many runs of few bodies."""
    monkeypatch.setattr(cutting._Run, "bodies", 0)
    tip = np.array([[[10.0, y, 12.0], [90.0, y, 12.0]] for y in (5.0, 10.0, 15.0, 20.0)])
    lines, zeros = np.arange(4), np.zeros(4, dtype=int)
    tools = [group_pieces(build_pieces((BALL,), 60.0, joined=False))]
    for axis, worth in ((UP, False), ((0.0, -0.6, 0.8), True)):
        spans = Spans(tip, np.tile(axis, (4, 2, 1)), lines, zeros, zeros > 0)
        assert cutting._Run(box(60, 40, 20, 0.4), spans, tools, 0.0).compiled is worth
    monkeypatch.setattr(cutting._Run, "bodies", 0)
    stock, spans = box(60, 40, 20, 0.4), Spans(tip, np.tile(UP, (4, 2, 1)), lines, zeros, zeros > 0)
    compiled = [cutting._Run(stock, spans, tools, 0.0).compiled for _ in range(cutting.WORTH_COMPILING)]
    assert not compiled[0] and compiled[-1]


def test_a_body_that_rubs_along_many_lines_is_one_finding() -> None:
    """A holder in lines 10 to 15, certain in most spans; then in 30; what may touch in line 16 is told, in line 12 it
    is not.
    """
    unsure = float("nan")
    holder = [
        (0, 10, 0.1),
        (2, 10, 0.3),
        (3, 11, 0.2),
        (5, 12, unsure),
        (6, 12, 0.1),
        (9, 13, 0.6),
        (11, 14, 0.1),
        (14, 15, 0.2),
    ]
    holder += [(16, 16, unsure), (40, 30, 0.4)]
    cutter = [(20, 20, 0.5), (22, 21, 0.7)]  # two rapids are two mistakes
    touches = (
        *(Touch(span, line, "holder", depth) for span, line, depth in holder),
        *(Touch(span, line, "cutter", depth) for span, line, depth in cutter),
    )
    poses, zeros = np.zeros((50, 2, 3)), np.zeros(50, dtype=np.int64)
    spans = Spans(poses, poses, zeros, zeros, np.zeros(50, dtype=np.bool_))
    tool = group_pieces(build_pieces((HOLDER,), 60.0, joined=False))
    told = [
        (item.severity, item.line, item.last_line, item.worst_line, item.message.split(":")[0].split(" may")[0])
        for item in report_touches(UPRIGHT, Cut(np.zeros(50), touches), spans, [tool], "the stock", 0.0, 0.1)
    ]
    whole, cut = (
        "the holder runs into the stock",
        "the cutter runs into the stock in a rapid traverse",
    )
    assert told == [
        ("error", 10, 15, 13, whole),
        ("error", 30, 30, 30, whole),
        ("warning", 16, 16, 16, "the holder"),
        ("error", 20, 20, 20, cut),
        ("error", 21, 21, 21, cut),
    ]


BALL_PROGRAM = """BEGIN PGM X MM
BLK FORM 0.1 Z X-30 Y-30 Z-20
BLK FORM 0.2 X+30 Y+30 Z+0
TOOL CALL 1 Z S9000
L A+0 C+0 FMAX M3
M128
L X-35 Y+0 Z+30 FMAX
L X-35 Y+0 Z-1.5 A-18 C+90 F1000
L X+20 F1500
L Z{} FMAX
M129
M30
END PGM X MM
"""


@pytest.mark.parametrize(
    ("corner", "z", "told"),
    [
        (None, "+30", [True]),
        (0.0, "+30", [False]),
        (4.0, "+30", []),
        (None, "-9", [False]),
        (4.0, "-9", [False]),
    ],
)
def test_a_ball_is_no_flat_cutter(corner: float | None, z: str, told: list[bool]) -> None:
    """And a contact that only the corner of a flat cutter has says that the cutter counts as flat, unless it is one."""
    options = vp.Options(
        tools={1: Tool(1, 1, (0.0, 0.0, 120.0, *(0.0,) * 6), 8.0, corner_radius=corner)},
        wcs={"G54": (0, 0, 60)},
        stock=vp.OwnStock(),
    )
    findings = vp.check(BALL_PROGRAM.format(z), "ac_trunnion", options, limits_only=True).findings
    assert ["counts as flat" in item.message for item in findings if item.code == "VP216"] == told, findings


@pytest.mark.parametrize(
    ("low", "high", "system", "z", "said"),
    [
        ((-40, -20, -20), (40, 20, 0), 1, -2, None),
        ((-40, -20, 60), (40, 20, 80), None, -2, None),  # the same place, read from the table
        ((-40, -20, -20), (40, 20, 0), 1, 0.5, None),  # it scratches the top
        ((-40, 3, 60), (40, 20, 80), None, -2, None),  # its side cuts, the tip passes at 3 mm
        ((-40, -20, 0), (40, 20, 30), None, -2, "is 48.0 mm or more away from it; correct G54 or stock"),
        ((-40, -20, -20), (40, 20, 0), None, -2, 'write system = "G54" in stock if its numbers are those of'),
        ((60, -20, -20), (80, 20, 0), 1, -2, "the nearest, of line 7, is 46.0 mm or more away from it"),
    ],
)
def test_a_stock_into_which_no_cut_comes_is_in_doubt(low, high, system, z, said) -> None:
    """It was kept out of without a word, and so were contacts with the real one."""
    program = f"G21 G90 G17\nT1 M6\nS900 M3\nG54 G0 X-10. Y0. A0. C0.\nG43 H1 Z20.\nG1 Z{z} F300.\nX10.\nG0 Z20.\nM30\n"
    options = vp.Options(
        dialect="fanuc",
        tools={1: Tool(1, 1, (0.0, 0.0, 80.0, *(0.0,) * 6), 8.0)},
        wcs={"G54": (0, 0, 80)},
        stock=vp.Box("the stock", low, high, system),
    )
    findings = vp.check(program, "ac_trunnion", options, limits_only=True).findings
    found = [item.message for item in findings if item.code == "VP505"]
    assert len(found) == (said is not None), findings
    assert all(said in one for one in found)


@pytest.mark.parametrize(
    ("second", "diameter", "said"),
    [
        ("M3\nG0 X-10. Z20.\nG1 Z2. F300.\nX10.", 8.0, "of line 13, is 2.0 mm or more away from it"),  # for Z-2.
        ("M3\nG0 X-10. Z20.\nG1 Z-2. F300.\nX10.", 8.0, None),
        ("M3\nG0 X-10. Z20.\nG1 Z0.9 F300.\nX10.", 8.0, None),
        ("M3\nG0 X-10. Z20.\nG1 Z2. F300.\nX10. A15.", 8.0, None),  # its side comes nearer
        ("G0 X-10. Z20.\nG1 Z2. F300.\nX10.", 8.0, None),  # a probe
        ("M3\nG0 X-10. Z20.\nG1 Z2. F300.\nX10.", 0.0, None),
        ("M3\nG55 G0 X-10. Z20.\nG1 Z2. F300.\nX10.", 8.0, None),  # another part
        ("M3\nG0 X-10. Z20.", 8.0, None),
        # a plane and a shift are the same part, a shift aside by the size of the stock is another one
        ("M3\nG68.2 X0 Y0 Z0 I0 J10 K0\nG0 X-10. Y0 Z20.\nG1 Z8. F300.\nX10.\nG69", 8.0, "of line 14, is"),
        ("M3\nG52 Z0.5\nG0 X-10. Z20.\nG1 Z2. F300.\nX10.\nG52 Z0", 8.0, "of line 14, is 2.5 mm or more"),
        ("M3\nG52 Y39.9\nG0 X-10. Y0 Z20.\nG1 Z2. F300.\nX10.\nG52 Y0", 8.0, "of line 14, is 16."),
        ("M3\nG52 Y40.\nG0 X-10. Y0 Z20.\nG1 Z2. F300.\nX10.\nG52 Y0", 8.0, None),
    ],
)
def test_a_tool_that_cuts_only_air_is_in_doubt(second: str, diameter: float, said: str | None) -> None:
    """Another tool cuts the stock in the same work system; nothing was said of this one."""
    first = "G21 G90 G17\nT1 M6\nS900 M3\nG54 G0 X-10. Y0. A0. C0.\nG43 H1 Z20.\nG1 Z-2. F300.\nX10.\nG0 Z20.\nM5\n"
    program = f"{first}T2 M6\nG43 H2 {second}\nG0 Z20.\nM30\n"
    tools = {n: Tool(n, n, (0.0, 0.0, 80.0, *(0.0,) * 6), size) for n, size in ((1, 8.0), (2, diameter))}
    box = vp.Box("the stock", (-40, -20, -20), (40, 20, 0), 1)
    places = {"G54": (0, 0, 80), "G55": (0, 0, 80)}
    options = vp.Options(dialect="fanuc", split_at_stops=True, tools=tools, wcs=places, stock=box)
    findings = vp.check(program, "ac_trunnion", options, limits_only=True).findings
    assert not [item for item in findings if item.severity == "error"]
    found = [item.message for item in findings if item.code == "VP505"]
    assert [f"tool 2 cuts nothing of the stock: its nearest cut, {said}" in one for one in found] == [True] * bool(said)


@pytest.mark.parametrize(("spindle", "severity"), [("M3", "warning"), ("M5", "error")])
def test_a_probe_without_a_diameter_has_cut_nothing(spindle: str, severity: str) -> None:
    """It touches the side of the stock; a rapid of another tool beside it, into the stock, was undecided."""
    program = (
        f"G21 G90 G17\nT3 M6\nS900 {spindle}\nG54 G0 X0. Y-60. A0. C0.\nG43 H3 Z-5.\nG1 Y-22. F300.\nY-60.\nG0 Z20.\n"
        "M5\nT1 M6\nS900 M3\nG43 H1 Z20.\nX-10. Y-10.\nZ-2.\nG1 X10.\nG0 Z20.\nM30\n"
    )
    tools = {n: Tool(n, n, (0.0, 0.0, 80.0, *(0.0,) * 6), size) for n, size in ((1, 8.0), (3, 0.0))}
    box = vp.Box("the stock", (-40, -20, -20), (40, 20, 0), 1)
    options = vp.Options(dialect="fanuc", split_at_stops=True, tools=tools, wcs={"G54": (0, 0, 80)}, stock=box)
    findings = vp.check(program, "ac_trunnion", options, limits_only=True).findings
    assert [item.severity for item in findings if item.code == "VP216"] == [severity], findings
