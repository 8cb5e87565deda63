"""Every real assembly mode of the parallel module by brute force: a dense scan over the tilt alpha.

Written from the rod equations (3)-(6) and nothing of the product. For a fixed alpha each rod holds P on a sphere. The
two of leg I have one radius L1 and share their centre's x, so P lies on a circle around the line through both centres;
the sphere of leg II meets that circle in two points; the sphere of leg III is left over, and its equation changes sign
at an assembly mode. The circle never degenerates (R1 != r1), and the plane in which leg II cuts it never lies parallel
to it (leg II stands elsewhere in x), so that nothing special happens at y = 0.
"""

from typing import Final

import numpy as np
from newton_raphson import Lengths, forward_from, rods
from numpy.typing import NDArray

Array = NDArray[np.float64]
Ints = NDArray[np.intp]

#: Angles of the first grid. Cells that may hide an even number of roots, or an end of the curve, are divided again.
GRID: Final = 1024
#: Parts into which such a cell is divided, and how often: 2 pi / 1024 / 32**4 is 6e-9 rad.
PARTS: Final = 32
DEPTH: Final = 4
#: A cell is divided when a parabola through three values comes within this share of their size of the axis.
NEAR: Final = 0.5
#: Halvings of a bracket: 6e-3 rad / 2**44 is below the spacing of doubles at 1 rad.
HALVINGS: Final = 44
#: A point at an end of the curve is within this of its root, mm: the curve rises there like a square root, and an angle
#: of 6e-9 makes 0.04 mm on this machine.
END_MM: Final = 1.0
#: A root is accepted when its rods close to this: 1e-9 mm on a rod of 950 mm.
CLOSED_MM2: Final = 2e-6
#: Two roots nearer than this (mm, and mm at a radius of 1 m for alpha) are one. Close to a double root the solution is
#: known only to the root of the rounding error, 1e-5 mm; two modes that near are one for every purpose here.
SAME_MM: Final = 1e-4
#: The scan and another solver agree on a mode within this: both polish on (3)-(6), the scan tells modes apart from
#: SAME_MM on.
AGREE_MM: Final = 0.5 * SAME_MM
#: Angles looked at a time: the arrays then stay in the cache.
ROOM: Final = 16384


def assembly_modes(g: Lengths, rho: Array, grid: int = GRID) -> tuple[Array, Ints]:
    """All real solutions (x, y, z, alpha) of (3)-(6) for rows of sliders.

    Parameters
    ----------
    g : Lengths
    rho : ndarray, shape (n, 3)
        mm.

    Returns
    -------
    pose : ndarray, shape (m, 4)
        mm, rad; rows of one triple stand together, sorted by alpha.
    row : ndarray of int, shape (m,)
        Which triple each belongs to, ascending.
    """
    found: list[tuple[Ints, Array, Ints]] = []
    cells = np.arange(len(rho)), np.full(len(rho), -np.pi), np.full(len(rho), np.pi)
    parts = grid
    for _ in range(DEPTH + 1):
        looks = [
            _look(g, rho, *(v[k : k + ROOM // parts] for v in cells), parts)
            for k in range(0, len(cells[0]), ROOM // parts)
        ]
        for side in (0, 1):
            row, low, high = (np.concatenate(v) for v in zip(*(look[side] for look in looks), strict=True))
            found.append((row, _bisected(g, rho[row], low, high, side), np.full(len(row), side)))
        cells = tuple(np.concatenate(v) for v in zip(*(look[2] for look in looks), strict=True))
        parts = PARTS
        if not len(cells[0]):
            break
    else:  # what is left lies at an end of the curve or at a double root: try the point itself, on both sides
        row, low, high = cells
        found += [(row, 0.5 * (low + high), np.full(len(row), side)) for side in (0, 1)]
    row, alpha, side = (np.concatenate(v) for v in zip(*found, strict=True))
    return _polished(g, rho, row, alpha, side)


def _sphere_cut(g: Lengths, rho: Array, alpha: Array) -> tuple[Array, Array, Array, Array]:
    """For rho (n, 3) and alpha (n, m): the discriminant, and (u, v) of the two points on leg I's circle, (2, n, m)."""
    c, s = np.cos(alpha), np.sin(alpha)
    arm1, rise1 = g.R1 * c - g.r1, g.R1 * s  # half the line between the two centres of leg I, in y and z
    half = np.sqrt(arm1 * arm1 + rise1 * rise1)
    circle = g.L1**2 - half * half  # squared radius of the circle
    arm2, rise2 = g.R2 * c - g.r4, g.R2 * s
    apart = g.x1 - g.x2  # centres of legs II and III minus those of leg I, in x
    height2 = rho[:, 1:2] - rho[:, 0:1] + rise2
    height3 = rho[:, 2:3] - rho[:, 0:1] - rise2
    # across the line in y and z: (-rise1, arm1) / half
    across2, across3 = (height2 * arm1 - arm2 * rise1) / half, (height3 * arm1 + arm2 * rise1) / half
    q2 = 0.5 * (circle + apart**2 + arm2 * arm2 + height2 * height2 - g.L2**2)
    q3 = 0.5 * (circle + apart**2 + arm2 * arm2 + height3 * height3 - g.L3**2)
    size = apart**2 + across2 * across2
    disc = circle * size - q2 * q2
    root = np.sqrt(np.maximum(disc, 0.0))
    u = np.stack([q2 * apart - across2 * root, q2 * apart + across2 * root]) / size
    v = np.stack([q2 * across2 + apart * root, q2 * across2 - apart * root]) / size
    return disc, u, v, u * apart + v * across3 - q3


def _look(
    g: Lengths, rho: Array, row: Ints, low: Array, high: Array, parts: int
) -> tuple[tuple[Ints, Array, Array], ...]:
    """Divides cells: brackets (row, low, high) of either side, and the cells to be divided again."""
    # one angle beyond each end, so that each of the cell's own has two neighbours
    alpha = low[:, None] + (high - low)[:, None] * (np.arange(-1, parts + 2) / parts)
    disc, left = _sphere_cut(g, rho[row], alpha)[::3]
    real = disc >= 0
    border = real[:, :-1] != real[:, 1:]
    # an end of the curve inside a cell, or beside it: no parabola fits there
    again = border[:, 1:-1] | border[:, :-2] | border[:, 2:]
    dip = _dip(np.abs(disc))  # or twice inside one
    brackets = []
    for f in left:
        at, cell = np.nonzero((real[:, :-1] & real[:, 1:] & ((f[:, :-1] < 0) != (f[:, 1:] < 0)))[:, 1:-1])
        brackets.append((row[at], alpha[at, cell + 1], alpha[at, cell + 2]))
        dip |= _dip(np.abs(f)) & real[:, 1:-1]
        again |= _flat(f)
    again |= dip[:, :-1] | dip[:, 1:]
    at, cell = np.nonzero(again)
    return (*brackets, (row[at], alpha[at, cell + 1], alpha[at, cell + 2]))


def _dip(f: Array) -> NDArray[np.bool_]:
    """Inner angles where f >= 0 is smallest and a parabola comes near zero: f may touch zero or pass it twice there."""
    before, here, after = f[:, :-2], f[:, 1:-1], f[:, 2:]
    bend = before - 2 * here + after
    with np.errstate(divide="ignore", invalid="ignore"):
        bottom = here - (after - before) ** 2 / (8 * bend)
        return (here <= before) & (here <= after) & (bottom <= NEAR * np.maximum(here, bend))


def _flat(f: Array) -> NDArray[np.bool_]:
    """Inner cells where f is near zero and so is its slope: three roots can stand there without f having a dip."""
    slope = np.abs(np.diff(f, axis=1))
    lowest = np.minimum(np.abs(f[:, 1:-2]), np.abs(f[:, 2:-1]))
    flat = _dip(slope) & (lowest <= np.maximum(slope[:, :-2], slope[:, 2:]))
    flat[:, 1:] |= flat[:, :-1]
    flat[:, :-1] |= flat[:, 1:]
    return flat


def _bisected(g: Lengths, rho: Array, low: Array, high: Array, side: int) -> Array:
    """Middle of brackets (m,) after halving; ``left`` of ``side`` changes sign in each."""
    if not len(low):
        return low
    negative = _sphere_cut(g, rho, low[:, None])[3][side, :, 0] < 0
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        same = (_sphere_cut(g, rho, middle[:, None])[3][side, :, 0] < 0) == negative
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return 0.5 * (low + high)


def _polished(g: Lengths, rho: Array, row: Ints, alpha: Array, side: Ints) -> tuple[Array, Ints]:
    """Points of the candidates, polished on (3)-(6), kept when the rods close, each pose once."""
    if not len(row):
        return np.empty((0, 4)), np.empty(0, dtype=int)
    _disc, u, v, _left = _sphere_cut(g, rho[row], alpha[:, None])
    pick = np.arange(len(row))
    u, v = u[side, pick, 0], v[side, pick, 0]
    arm1, rise1 = g.R1 * np.cos(alpha) - g.r1, g.R1 * np.sin(alpha)
    half = np.hypot(arm1, rise1)
    start = np.stack([u - g.x1, -v * rise1 / half, rho[row, 0] + v * arm1 / half, alpha], axis=-1)
    pose, _steps, good = forward_from(g, rho[row], start)
    good &= np.abs(rods(g, pose, rho[row])).max(axis=0) < CLOSED_MM2
    # a step far away belongs to another root, which has its own bracket
    good &= np.abs(pose[:, :3] - start[:, :3]).max(axis=1) < END_MM
    pose, row = pose[good], row[good]
    pose[:, 3] = (pose[:, 3] + np.pi) % (2 * np.pi) - np.pi
    order = np.lexsort((pose[:, 0], pose[:, 3], row))
    pose, row = pose[order], row[order]
    keep = np.ones(len(row), dtype=bool)
    for ahead in range(1, int(np.bincount(row).max(initial=0))):
        same = (row[ahead:] == row[:-ahead]) & keep[:-ahead] & (separation(pose[ahead:], pose[:-ahead]) < SAME_MM)
        keep[ahead:] &= ~same
    return pose[keep], row[keep]


def separation(one: Array, other: Array) -> Array:
    """Largest coordinate difference of poses (..., 4), mm, with alpha counted at a radius of 1 m."""
    turn = np.abs((one[..., 3] - other[..., 3] + np.pi) % (2 * np.pi) - np.pi)
    return np.maximum(np.abs(one[..., :3] - other[..., :3]).max(axis=-1), 1000.0 * turn)


def disagreements(scanned: Array, row: Ints, position: Array, alpha: Array) -> list[int]:
    """Triples for which another solver has other modes than the scan.

    Parameters
    ----------
    scanned, row
        As :func:`assembly_modes` gives them.
    position : ndarray, shape (n, k, 3)
    alpha : ndarray, shape (n, k)
        Of the other solver; NaN where a triple has fewer than k modes.
    """
    other_row, at = np.nonzero(np.isfinite(alpha))
    other = np.column_stack([position[other_row, at], alpha[other_row, at]])
    n, most = len(alpha), int(max(np.bincount(row).max(initial=0), np.bincount(other_row).max(initial=0)))
    one, two = np.full((n, most, 4), np.nan), np.full((n, most, 4), np.nan)
    for table, pose, of in ((one, scanned, row), (two, other, other_row)):
        # rows ascend, so the place of a mode in its triple is its distance from the triple's first
        table[of, np.arange(len(of)) - np.searchsorted(of, of)] = pose
    near = separation(one[:, :, None], two[:, None, :]) < AGREE_MM
    partners = near.sum(axis=2), near.sum(axis=1)
    bad = np.zeros(n, dtype=bool)
    for table, partner in zip((one, two), partners, strict=True):
        bad |= (partner != np.isfinite(table[:, :, 3])).any(axis=1)
    return [int(k) for k in np.flatnonzero(bad)]
