"""Programs made of points, their contours, and references for what a rounded corner may do."""

import numpy as np

from verne_post.app.assemble import assemble
from verne_post.model.contour import Contour
from verne_post.model.options import Options
from verne_post.model.part_setup import WorkOffset
from verne_post.toolpath.contour_pose import find_contour_pose
from verne_post.toolpath.corner_shapes import KNEE

from ..builders import MACHINE


def contour_of(source: str, mode: str = "spline", tip: float | None = None, axis: float | None = None) -> Contour:
    """The contour of a program; tolerances in mm and rad."""
    options = Options(
        tool_length=80.0,
        wcs={1: WorkOffset((0.0, 0.0, 50.0)), 2: WorkOffset((7.0, -3.0, 60.0))},
        smoothing=mode,
        tolerance=tip,
        orientation_tolerance_deg=None if axis is None else float(np.degrees(axis)),
    )
    return assemble(source.encode(), MACHINE, options).contour


def program_of(points: np.ndarray, tolerance: float, feeds: np.ndarray | None = None) -> str:
    """G1 through points (n, 5) in mm and degrees, with the feeds (n,) that lead to them."""
    feeds = np.full(len(points), 1000.0) if feeds is None else feeds
    words = ("X%.9f Y%.9f Z%.9f A%.9f C%.9f" % tuple(point) for point in points)
    lines = [
        f"G1 {word} F{feed:g}" if k else f"G0 {word}" for k, (word, feed) in enumerate(zip(words, feeds, strict=True))
    ]
    return "\n".join([f"G21 G90 G94 G17 G64 P{tolerance:.9f}", *lines, "M2", ""])


def flat(xy: np.ndarray) -> np.ndarray:
    """Points (n, 2) at Z40 under a vertical tool."""
    return np.column_stack([xy, np.full(len(xy), 40.0), np.zeros((len(xy), 2))])


def poses_at(contour: Contour, s: np.ndarray, side: str) -> np.ndarray:
    """Poses (n, 5) at lengths s (n,) along the whole contour; at an end of an element those of the element on this
    side.
    """
    ends = np.cumsum(contour.length)
    element = np.clip(np.searchsorted(ends, s, side="left" if side == "before" else "right"), 0, len(contour) - 1)
    w = np.clip((s - (ends - contour.length)[element]) / contour.length[element], 0.0, 1.0)
    return np.hstack(find_contour_pose(contour, element, w))


def shares_of_tolerance(contour: Contour, per_element: int = 9) -> np.ndarray:
    """For poses along all elements the larger share (m,) of tip and angle tolerance, at the best pose of the own
    segment.

    The larger of two norms of linear functions of u is convex: a ternary search finds its minimum.
    """
    element = np.repeat(np.arange(len(contour)), per_element)
    w = np.tile(np.linspace(0.0, 1.0, per_element), len(contour))
    here = np.hstack(find_contour_pose(contour, element, w))
    path, segment = contour.path, contour.segment[element]
    start, delta = path.start[segment], path.end[segment] - path.start[segment]
    tip = np.maximum(contour.tip_tolerance[segment], 1e-9)  # 1 nm where nothing is allowed
    axis = np.maximum(contour.axis_tolerance[segment], 1e-9)

    def share(u: np.ndarray) -> np.ndarray:
        off = here - start - u[:, None] * delta
        return np.maximum(np.linalg.norm(off[:, :3], axis=1) / tip, np.linalg.norm(off[:, 3:], axis=1) / axis)

    low, high = np.zeros(len(segment)), np.ones(len(segment))
    for _ in range(64):
        left, right = low + (high - low) / 3, high - (high - low) / 3
        better = share(left) < share(right)
        low, high = np.where(better, low, left), np.where(better, right, high)
    return share(0.5 * (low + high))


def jumps(contour: Contour, points: np.ndarray, width: np.ndarray) -> np.ndarray:
    """Jumps (n, 4, 5) of the pose and its first three derivatives by s at s = ``points``, each times width^k / k!.

    One-sided derivatives from polynomials of degree 7 over ``width`` (n,) on each side.
    """
    nodes = 0.5 * (1.0 - np.cos(np.pi * np.arange(8) / 7))  # Chebyshev points, ends included
    taylor = np.linalg.inv(np.vander(nodes, increasing=True))[:4]  # values -> c0 .. c3 of sum c_k x^k
    sides = []
    for sign, side in ((1.0, "after"), (-1.0, "before")):
        s = points[:, None] + sign * nodes * width[:, None]
        values = poses_at(contour, s.ravel(), side).reshape(len(points), 8, 5)
        sides.append(np.einsum("kj,njc->nkc", taylor, values) * (sign ** np.arange(4))[:, None])
    return np.abs(sides[0] - sides[1])


def ends_of_blends(contour: Contour) -> tuple[np.ndarray, np.ndarray]:
    """Where the derivatives may jump: s of corners and of the ends of corner blends, and the width to the next on each
    side.
    """
    assert contour.corners is not None
    s, reach = contour.corners.s, contour.corners.reach
    wide = reach[1:-1] * (contour.corners.shape[1:-1] > 0)
    ends = [
        s[1:-1] + share * width for share, width in ((-1, reach[1:-1]), (1, reach[1:-1]), (-KNEE, wide), (KNEE, wide))
    ]
    every = np.sort(np.concatenate([s, *ends]))
    every = every[np.append(True, np.diff(every) > 1e-9)]
    width = np.minimum(np.diff(every)[:-1], np.diff(every)[1:])
    stops = np.cumsum(contour.length)[:-1][np.diff(contour.section) > 0]
    at = every[1:-1]
    continuous = np.array([not np.isclose(stops, one, rtol=0, atol=1e-9).any() for one in at])
    return at[continuous], width[continuous] * (1 - 1e-9)
