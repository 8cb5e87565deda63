"""A judge that shares nothing with the kernel: tools as drawn outlines, distances to their edges, poses by their own
interpolation.

An outline is a polygon of radius and height, drawn here from the drawing of the tool; whether a place is in the tool is
asked of matplotlib. The kernel's formulas of pieces, its tree, bounds and searches are not used.
"""

from functools import cache

import numpy as np
import pytest
from matplotlib.path import Path as Polygon
from scipy.optimize import minimize_scalar

from verne_post.model.part_setup import Cylinder, Wanted
from verne_post.part.bodies import build_pieces
from verne_post.part.compare import CLEAR, GOUGE, compare
from verne_post.part.motion import Motion, build_motion
from verne_post.part.stl import build_mesh
from verne_post.part.sweep import find_nearest, load_accelerator

PATHS = [False] if load_accelerator() is None else [False, True]
TOP = 30.0


def draw_arc(r: float, h: float, radius: float, first: float, last: float) -> list[tuple[float, float]]:
    turn = np.radians(np.linspace(first, last, 400))
    return [(r + radius * np.cos(one), h + radius * np.sin(one)) for one in turn]


#: Right half of each tool, from the tip outwards and up; and its words for the kernel.
TOOLS = {
    "flat": ([(0, 0), (5, 0), (5, TOP), (0, TOP)], Cylinder("cutter", 10.0, TOP)),
    "bull": ([(0, 0), *draw_arc(3.5, 1.5, 1.5, -90, 0), (5, TOP), (0, TOP)],
             Cylinder("cutter", 10.0, TOP, corner_radius=1.5)),
    "ball": ([*draw_arc(0, 4, 4, -90, 0), (4, TOP), (0, TOP)], Cylinder("cutter", 8.0, TOP, corner_radius=4.0)),
    "chamfer": ([(0, 0), (0.5, 0), (5, 4.5), (5, TOP), (0, TOP)],
                Cylinder("cutter", 10.0, TOP, point_angle=90.0, tip_diameter=1.0)),
    "taper": ([(0, 0), (2, 0), (2 + TOP * np.tan(np.radians(6)), TOP), (0, TOP)],
              Cylinder("cutter", 4.0, TOP, taper=6.0)),
}  # fmt: skip


def place(tip: np.ndarray, axis: np.ndarray, share: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Tips and unit axes (k, 3) on the straight way between two poses (2, 3)."""
    at = tip[0] + share[:, None] * (tip[1] - tip[0])
    to = axis[0] + share[:, None] * (axis[1] - axis[0])
    return at, to / np.sqrt((to * to).sum(axis=1))[:, None]


def see(point: np.ndarray, tip: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """Radius and height (k, 2) of a point at poses (k, 3)."""
    off = point - tip
    height = off @ axis[0] if len(axis) == 1 else (off * axis).sum(axis=1)
    return np.column_stack([np.linalg.norm(np.cross(off, axis), axis=1), np.atleast_1d(height)])


def measure(outline: np.ndarray, seen: np.ndarray) -> np.ndarray:
    """Signed distance (k,) of places from the outline; its side on the axis is no surface."""
    inside = Polygon([*outline, outline[0]]).contains_points(seen)
    a, b = outline[:-1], outline[1:]
    along = b - a
    share = np.clip(((seen[:, None] - a) * along).sum(2) / (along * along).sum(1), 0, 1)
    distance = np.linalg.norm(seen[:, None] - a - share[..., None] * along, axis=2).min(axis=1)
    return np.where(inside, -distance, distance)


def judge(outline: np.ndarray, point: np.ndarray, tip: np.ndarray, axis: np.ndarray) -> float:
    """The least signed distance of a point from the tool on its way through poses (n, 3)."""
    ends, far = measure(outline, see(point, tip, axis)), np.linalg.norm(point - tip, axis=1)
    # how far the point goes, as the tool sees it, from one pose to the next: no distance changes by more
    moved = np.linalg.norm(np.diff(tip, axis=0), axis=1)
    moved += np.maximum(far[:-1], far[1:]) * np.linalg.norm(np.diff(axis, axis=0), axis=1) * 1.01
    lowest, best = 0.5 * (ends[:-1] + ends[1:] - moved), float(ends.min())
    for k in np.argsort(lowest):
        if lowest[k] > best:
            break

        def value(share: float, k: int = k) -> float:
            at = place(tip[k : k + 2], axis[k : k + 2], np.array([share]))
            return float(measure(outline, see(point, *at))[0])

        shares = np.linspace(0, 1, 41)
        seen = measure(outline, see(point, *place(tip[k : k + 2], axis[k : k + 2], shares)))
        best = min(best, float(seen.min()))
        i = int(seen.argmin())
        # nobody can come nearer between two of them than they are apart
        if seen[i] < best + 0.1:
            ends = shares[max(i - 1, 0)], shares[min(i + 1, 40)]
            best = min(best, float(minimize_scalar(value, bounds=ends, method="bounded", options={"xatol": 1e-7}).fun))
    return best


def travel(seed: int, rows: int) -> tuple[np.ndarray, np.ndarray]:
    """A way through seven poses a few mm apart that turns by some degrees, in so many rows from each to the next."""
    pick = np.random.default_rng(seed)
    tip = np.cumsum(pick.normal(size=(7, 3)) * [2.5, 2.5, 0.6], axis=0)
    axis = np.cumsum(pick.normal(size=(7, 3)) * 0.03, axis=0) + [0.1, -0.1, 1.0]
    return interpolate(tip, rows), interpolate(axis / np.linalg.norm(axis, axis=1)[:, None], rows)


def interpolate(anchors: np.ndarray, rows: int) -> np.ndarray:
    at = np.arange((len(anchors) - 1) * rows + 1) / rows
    found = np.column_stack([np.interp(at, np.arange(len(anchors)), column) for column in anchors.T])
    return found if abs(np.linalg.norm(anchors[0]) - 1) > 1e-9 else found / np.linalg.norm(found, axis=1)[:, None]


def make_motion(name: str, tip: np.ndarray, axis: np.ndarray) -> Motion:
    pieces = build_pieces((TOOLS[name][1],), TOP)
    return build_motion("tool 1", pieces, tip, axis, np.arange(len(tip)), np.append(np.ones(len(tip) - 1, bool), False))


@cache
def judge_points(name: str, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Places near the way of a tool, and their least distances."""
    tip, axis = travel(seed, 8)
    pick = np.random.default_rng(100 + seed)
    point = pick.uniform(tip.min(0) - [6, 6, 2], tip.max(0) + [6, 6, 12], (25, 3))
    outline = np.array(TOOLS[name][0], dtype=float)
    return point, np.array([judge(outline, one, tip, axis) for one in point])


@pytest.mark.parametrize("accelerate", PATHS)
@pytest.mark.parametrize("name", TOOLS)
def test_distances_are_those_of_the_drawing(name: str, accelerate: bool) -> None:
    for seed in range(2):
        tip, axis = travel(seed, 8)
        motion = make_motion(name, tip, axis)
        point, exact = judge_points(name, seed)
        found = find_nearest((motion,), point, 50.0, accelerate=accelerate).distance
        assert min((exact < 0).sum(), (exact > 0).sum()) > 3
        # arcs are chords of 0.225 degrees, 0.00001 mm off; the way between rows is straight but for what it bows, which
        # is told
        assert motion.bow < 0.02
        assert (found > exact - 5e-5).all(), (name, seed)
        assert (found < exact + motion.bow + 5e-5).all(), (name, seed)
        assert (np.abs(found - exact) < 5e-5).mean() > 0.8, (name, seed)


@pytest.mark.parametrize("accelerate", PATHS)
@pytest.mark.parametrize("name", ["flat", "bull", "ball"])
def test_no_facet_that_is_called_clear_is_cut_deeper(name: str, accelerate: bool) -> None:
    """Tilted tools graze a floor: facets that are clear hold no place that the drawing cuts deeper; gouges are as deep
    as it says.
    """
    outline = np.array(TOOLS[name][0], dtype=float)
    polygon, asked, decided = Polygon([*outline, outline[0]]), 0.05, np.zeros(3, dtype=int)
    side = np.linspace(-8, 8, 9)
    square = np.stack(np.meshgrid(side[:-1], side[:-1], [0.0], indexing="ij"), axis=-1).reshape(-1, 1, 3)
    corner = square + 2.0 * np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    mesh = build_mesh("floor", corner[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3, 3))
    # seed 1 has many facets that are not decided: numpy takes 5 s for what numba does alike in 1 s
    for seed in (0, 1, 2) if accelerate == PATHS[-1] else (0, 2):
        pick = np.random.default_rng(seed)
        tip, axis = travel(40 + seed, 20)
        # the lowest place of the tool is a little over the floor, or below it
        turn = np.linspace(0, 2 * np.pi, 721)
        wave = interpolate(pick.uniform(-0.12, 0.06, (7, 1)), 20)[:, 0]
        for k in range(len(tip)):
            across = np.cross(axis[k], [1.0, 0.0, 0.0])
            across /= np.linalg.norm(across)
            ring = np.cos(turn)[:, None] * across + np.sin(turn)[:, None] * np.cross(axis[k], across)
            steepest = float(ring[:, 2].min())
            tip[k, 2] = wave[k] - (outline[:-2] @ [steepest, axis[k, 2]]).min()
        motion = make_motion(name, tip, axis)
        found = compare(mesh, (motion,), Wanted(asked, 0.2, 0.5, 1.0), accelerate=accelerate)
        ways = [place(tip[k : k + 2], axis[k : k + 2], np.linspace(0, 1, 6)) for k in range(len(tip) - 1)]
        at, to = (np.concatenate(one) for one in zip(*ways, strict=True))

        def is_cut(points: np.ndarray, at: np.ndarray = at, to: np.ndarray = to) -> np.ndarray:
            seen = np.concatenate([see(one, at, to) for one in points])
            inside = ((outline.min(0) <= seen) & (seen <= outline.max(0))).all(axis=1)  # of the box about the outline
            inside[inside] = polygon.contains_points(seen[inside])
            return inside.reshape(len(points), -1).any(axis=1)

        decided += np.bincount(found.state, minlength=3)
        clear = np.flatnonzero(found.state == CLEAR)
        near = (
            np.hypot(*(mesh.list_corners()[clear, :, None, :2].mean(axis=1) - at[:, :2]).transpose(2, 0, 1)).min(axis=1)
            < 7.0
        )
        share = pick.dirichlet(np.ones(3), (int(near.sum()), 4))
        below = np.einsum("ftk,fkx->ftx", share, mesh.list_corners()[clear[near]]).reshape(-1, 3) - [0, 0, asked + 1e-4]
        assert not is_cut(below).any(), (name, seed)
        deep, depth = found.gouges.place[:60], found.gouges.depth[:60, None]
        assert is_cut(deep - depth * [0, 0, 1] + [0, 0, 0.01]).all(), (name, seed)
        assert not is_cut(deep - depth * [0, 0, 1] - [0, 0, motion.bow + 1e-3]).any(), (name, seed)
    assert decided[CLEAR] > 50
    assert decided[GOUGE] > 20
