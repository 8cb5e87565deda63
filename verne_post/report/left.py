"""What a program leaves of its stock, as a picture: cut on few rays, and drawn as one skin."""

from typing import Final

import numpy as np

from verne_post.app.assemble import Program
from verne_post.app.machined_stock import make_stock
from verne_post.app.stock_check import CHORD_MM, count_chords, list_spans
from verne_post.base.arrays import Array, Ints
from verne_post.kinematics.checks.keep_out import build_moving
from verne_post.model.findings import InputError
from verne_post.part.dexels import Dexels, list_sweeps, load_compiled
from verne_post.part.ray_tables import make_table
from verne_post.report.surfaces import Surface

#: Rays of the picture, each with two vertices or more.
RAYS: Final = 16_000
#: Poses of a program at most, each taking some 20 microseconds: a page of a longer one would take minutes.
MOST_POSES: Final = 2_000_000
#: Without numba a body takes about a millisecond, and more of them than this too long for a picture.
MOST_BODIES: Final = 20_000


def make_left(program: Program) -> tuple[Surface | None, str]:
    """What is left of the stock; None without a stock, and where it cannot be drawn: then the text says why."""
    options = program.options
    if (options.stock is None and program.moves.stock is None) or options.lift:
        return None, ""
    try:
        stock = make_stock(program, RAYS)
        moving = build_moving(program.machine, program.path, program.moves, options)
    except InputError:  # among the findings already
        return None, ""
    if not all(moving.shapes):
        return None, "What is left of the stock is not drawn: a tool has no size."
    joints, step = program.build_joint_path(), float(stock.cell.max())
    coarse = max(step / CHORD_MM, 1.0)
    if len(program.contour) + count_chords(joints).sum() / coarse > MOST_POSES:
        return None, "What is left of the stock is not drawn: the program is too long."
    spans, tools, _skipped = list_spans(program, joints, moving, len(program.contour) - 1, coarse)
    for k, tool in enumerate(tools):
        own = spans.tool == k
        for piece in tool.cutter:
            sweeps = list_sweeps(*stock.place_inside(spans.tip[own], spans.axis[own]), piece.high, step)
            if len(sweeps) > MOST_BODIES and load_compiled() is None:
                return None, "What is left of the stock is not drawn: without numba it would take too long."
            stock.cut(sweeps, make_table(piece))
    if not (stock.high > stock.low).any():
        return None, ""
    flat = any(shape[0].assumed_flat for shape in moving.shapes)
    text = f"Stock that is left: cells of {step:.2g} mm{', tools of unknown shape cut as flat ones' if flat else ''}."
    return Surface("stock that is left", "left", *draw_skin(stock), stock.origin, stock.turn), text


def draw_skin(stock: Dexels) -> tuple[Array, Ints]:
    """Vertices and facets of the skin of a stock, in its frame.

    Overlapping intervals of four neighbouring rays form squares at their tops and at their bottoms. Where such a sheet
    ends, a wall joins its top to its bottom.
    """
    order = np.argsort(stock.low, axis=2)
    low, high = (np.take_along_axis(one, order, axis=2) for one in (stock.low, stock.high))
    there = high > low
    number = np.cumsum(there).reshape(there.shape) - 1
    i, j, k = np.nonzero(there)
    x, y = (_space_rays(n, cell) for n, cell in zip(stock.counts, stock.cell, strict=True))
    top = np.column_stack([x[i], y[j], high[i, j, k]])
    bottom = np.column_stack([x[i], y[j], low[i, j, k]])
    squares = []
    corners = [
        (slice(None, -1), slice(None, -1)),
        (slice(1, None), slice(None, -1)),
        (slice(1, None), slice(1, None)),
        (slice(None, -1), slice(1, None)),
    ]
    for first in range(4):
        window = corners[first]
        for place in range(there.shape[2]):
            own_low, own_high = low[*window, place], high[*window, place]
            chosen, joined = [], there[*window, place].copy()
            for other in corners:
                overlap = np.minimum(own_high[..., None], high[other]) - np.maximum(own_low[..., None], low[other])
                best = overlap.argmax(axis=2)
                joined &= np.take_along_axis(overlap, best[..., None], axis=2)[..., 0] > 0
                chosen.append(np.take_along_axis(number[other], best[..., None], axis=2)[..., 0])
            squares.append(np.stack(chosen, axis=-1)[joined])
    # where a ray splits, each interval goes on with one only: those that all four corners choose
    square, count = np.unique(np.concatenate(squares), axis=0, return_counts=True)
    square = square[count == len(corners)]
    edges = [(a, b) for n in range(4) for a, b in square[:, [n, (n + 1) % 4]].tolist()]
    border = np.array(sorted(set(edges) - {(b, a) for a, b in edges})).reshape(-1, 2)
    under = len(top)
    a, b = border.T
    walls = [np.stack([b, a, a + under], axis=1), np.stack([b, a + under, b + under], axis=1)]
    upper = [square[:, [0, 1, 2]], square[:, [0, 2, 3]]]
    lower = [one[:, ::-1] + under for one in upper]
    return np.concatenate([top, bottom]), np.concatenate([*upper, *lower, *walls]).astype(np.int64)


def _space_rays(count: int, cell: float) -> Array:
    """Places of rays; the outer ones stand on the faces of the stock."""
    return np.concatenate([[0.0], (np.arange(1, count - 1) + 0.5) * cell, [count * cell]]) if count > 1 else np.zeros(1)
