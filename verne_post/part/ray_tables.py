"""Convex pieces of a tool for rays: profile edges and rounded corners, and where parallel rays enter and leave.

Every ray runs along z. A piece that stands is met exactly: planes and cones by a quadratic, rounded corners by Newton's
method on its distance, which is convex along the ray and so never overshoots. A piece with a vertical axis that moves
along a straight line is met exactly too: its lower side is a convex function of the distance from its axis.
"""

from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array, Mask
from verne_post.part.bodies import Piece

#: A cone whose quadratic has a smaller leading coefficient than this is met once, not twice.
FLAT: Final = 1e-12
#: A ray is on the surface of a rounded corner within this, mm, and is sought in so many steps.
ON_SURFACE_MM: Final = 1e-10
NEWTON_STEPS: Final = 40
#: Halvings of a straight motion in search of its lowest place above a ray: a billionth of it is left.
HALVINGS: Final = 30
#: An axis is vertical when its horizontal part is shorter than this: 1e-6 mm at the end of a tool of 100 mm.
VERTICAL: Final = 1e-8
#: A corner whose circle is thinner than this is a ball, mm.
BALL_MM: Final = 1e-9


class RayTable(Struct, frozen=True, eq=False):
    """A convex piece of revolution, mm."""

    edges: Array  #: (n, 3): Normal (r, h) and offset d: ``n_r r + n_h h <= d``.
    #: (m, 7): Circle of a rounded corner (r, h, radius), and the normals of the edges before and after it.
    corners: Array
    #: radius, low, high: Largest r, and the heights above the tip between which the piece is.
    radius: float
    low: float
    high: float

    def extend(self, by: float) -> "RayTable":
        """The piece larger by ``by`` (mm) in every direction; edges stay sharp, so it is never too small."""
        edges, corners = self.edges.copy(), self.corners.copy()
        edges[:, 2] += by
        corners[:, 2] += by
        return RayTable(edges, corners[corners[:, 2] > 0], self.radius + by, self.low - by, self.high + by)

    def widen(self, by: float) -> "RayTable":
        """The piece with every radius larger by ``by``, mm, at the same heights."""
        edges, corners = self.edges.copy(), self.corners.copy()
        edges[:, 2] += by * edges[:, 0]
        corners[:, 0] += by
        return RayTable(edges, corners, self.radius + by, self.low, self.high)

    @property
    def is_empty(self) -> bool:
        """Whether nothing is left of it."""
        return self.radius <= 0 or self.low >= self.high

    @property
    def widens_upwards(self) -> bool:
        """Whether a retract along the axis stays in what the piece has taken: no edge below the top leans inwards."""
        return bool((self.edges[:, 1][self.edges[:, 0] > 0] <= 0).all())


def make_table(piece: Piece) -> RayTable:
    """A piece as rays meet it."""
    found: list[Array] = []
    corners: list[tuple[float, ...]] = []
    for start_r, start_h, _r, _h, normal_r, normal_h, _square in piece.list_edges():
        normal = np.array([normal_r, normal_h])
        at = float(normal @ (start_r, start_h)) + piece.rounding
        if found and piece.rounding > 0 and start_h < piece.high and np.abs(normal - found[-1][:2]).max() > 0:
            corners.append((start_r, start_h, piece.rounding, *found[-1][:2], *normal))
        found.append(np.array([*normal, at]))
    # the ends, which also leave out the second half of a cone, beyond its apex
    found = [one for one in found if one[0] > 0] + [np.array([0.0, 1.0, piece.high]), np.array([0.0, -1.0, -piece.low])]
    return RayTable(np.array(found), np.array(corners).reshape(-1, 7), piece.radius, piece.low, piece.high)


# --- pieces that stand -----------------------------------------------------------------------------


def meet_standing(table: RayTable, x: Array, y: Array, axis: Array) -> tuple[Array, Array]:
    """Where rays enter and leave a piece.

    Parameters
    ----------
    x, y : ndarray, shape (...)
        The rays, from the tip, mm.
    axis : ndarray, shape (3,)
        Unit.

    Returns
    -------
    low, high : ndarray, shape (...)
        z from the tip, mm; ``low >= high`` where a ray misses.
    """
    ux, uy, uz = axis.tolist()
    h0, square = x * ux + y * uy, x * x + y * y
    low, high = np.full(h0.shape, -np.inf), np.full(h0.shape, np.inf)
    for nr, nh, d in table.edges.tolist():
        if nr == 0:
            slope, rest = nh * uz, d - nh * h0
            if slope > 0:
                high = np.minimum(high, rest / slope)
            elif slope < 0:
                low = np.maximum(low, rest / slope)
            else:
                high = np.where(rest < 0, -np.inf, high)
            continue
        m, k = d / nr, -nh / nr
        wide = m + k * h0
        a, b, c = ux * ux + uy * uy - k * k * uz * uz, -uz * (h0 + k * wide), square - h0 * h0 - wide * wide
        if abs(a) <= FLAT:
            with np.errstate(divide="ignore", invalid="ignore"):
                once = -c / (2.0 * b)
            high = np.where(b > 0, np.minimum(high, once), np.where((b == 0) & (c > 0), -np.inf, high))
            low = np.where(b < 0, np.maximum(low, once), low)
            continue
        inside = b * b - a * c
        root = np.sqrt(np.maximum(inside, 0.0))
        first, last = (-b - root) / a, (-b + root) / a
        if a > 0:
            low, high = np.maximum(low, first), np.where(inside < 0, -np.inf, np.minimum(high, last))
        elif k * uz > 0:  # the nappe above the apex
            low = np.maximum(low, first)
        else:
            high = np.minimum(high, last)
    for corner in table.corners:
        low, high = _round_end(corner, x, y, axis, low, high, 1.0)
        high, low = _round_end(corner, x, y, axis, high, low, -1.0)
    return low, high


def _round_end(
    corner: Array, x: Array, y: Array, axis: Array, end: Array, other: Array, way: float
) -> tuple[Array, Array]:
    """Move the ends of rays from the sharp edge to the rounded one; where a ray misses, ``end`` passes ``other``."""
    rc, hc, radius, n1r, n1h, n2r, n2h = corner.tolist()
    rows = np.flatnonzero((way * (other - end) > 0).ravel())
    if not len(rows):
        return end, other
    x, y, z, stop = x.ravel()[rows], y.ravel()[rows], end.ravel()[rows], other.ravel()[rows]
    end = end.copy()
    flat = end.reshape(-1)
    if rc < BALL_MM:
        h0 = x * axis[0] + y * axis[1]
        h = h0 + z * axis[2] - hc
        r = np.sqrt(np.maximum(x * x + y * y + z * z - (h + hc) ** 2, 0.0))
        here = _lies_between(r, h, n1r, n1h, n2r, n2h)
        along = hc * axis[2]
        inside = radius**2 - (x - hc * axis[0]) ** 2 - (y - hc * axis[1]) ** 2
        sphere = np.where(inside > 0, along - way * np.sqrt(np.maximum(inside, 0.0)), way * np.inf)
        flat[rows] = np.where(here, sphere, z)
        return end, other
    active = np.arange(len(rows))
    for _ in range(NEWTON_STEPS):
        xa, ya, za = x[active], y[active], z[active]
        h = xa * axis[0] + ya * axis[1] + za * axis[2]
        r = np.sqrt(np.maximum(xa * xa + ya * ya + za * za - h * h, 0.0))
        off_r, off_h = r - rc, h - hc
        size = np.hypot(off_r, off_h)
        gap = size - radius
        open_ = _lies_between(off_r, off_h, n1r, n1h, n2r, n2h) & (gap > ON_SURFACE_MM)
        active, za, h, r, off_r, off_h, size, gap = (one[open_] for one in (active, za, h, r, off_r, off_h, size, gap))
        if not len(active):
            break
        slope = (off_r * (za - h * axis[2]) / np.maximum(r, BALL_MM) + off_h * axis[2]) / size
        falls = way * slope < 0
        z[active] = np.where(falls, za - gap / np.where(falls, slope, 1.0), way * np.inf)
        active = active[way * (stop[active] - z[active]) > 0]
    flat[rows] = z
    return end, other


def _lies_between(r: Array, h: Array, n1r: float, n1h: float, n2r: float, n2h: float) -> Mask:
    """Directions between two normals, counter-clockwise."""
    return (n1r * h - n1h * r >= 0) & (r * n2h - h * n2r >= 0)


# --- pieces with a vertical axis that move straight ------------------------------------------------


def meet_moving(table: RayTable, x: Array, y: Array, start: Array, end: Array) -> tuple[Array, Array]:
    """Where rays (...) meet the sweep of a piece with axis (0, 0, 1) between tips (3,): z; low >= high: missed."""
    along = (end - start).tolist()
    x, y = x - start[0], y - start[1]
    long = along[0] ** 2 + along[1] ** 2
    near = (x * along[0] + y * along[1]) / long if long > 0 else np.zeros_like(x)
    beside = np.maximum(x * x + y * y - near * near * long, 0.0)
    inside = table.radius**2 - beside
    if along[2] == 0 or long == 0:
        share = np.clip(near, 0.0, 1.0)
        r = np.sqrt(beside + (near - share) ** 2 * long)
        missed = r > table.radius
        low = np.where(missed, np.inf, find_side(table, r, -1.0)[0] + min(start[2], end[2]))
        return low, np.where(missed, -np.inf, find_side(table, r, 1.0)[0] + max(start[2], end[2]))
    half = np.sqrt(np.maximum(inside, 0.0) / long)
    first, last = np.clip(near - half, 0.0, 1.0), np.clip(near + half, 0.0, 1.0)
    missed = (inside < 0) | (near - half > 1.0) | (near + half < 0.0)
    ends = []
    for side in (-1.0, 1.0):
        share = _find_extreme(table, side, near, beside, long, along[2], first, last)
        r = np.sqrt(beside + (near - share) ** 2 * long)
        ends.append(np.where(missed, -side * np.inf, find_side(table, r, side)[0] + start[2] + share * along[2]))
    return ends[0], ends[1]


def _find_extreme(
    table: RayTable, side: float, near: Array, beside: Array, long: float, rise: float, first: Array, last: Array
) -> Array:
    """Share of the way at which the lower (side -1) or upper (1) side is lowest or highest above rays."""
    if _is_level(table, side):
        return last if side * rise > 0 else first
    low, high = first.copy(), last.copy()
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        r = np.sqrt(beside + (near - middle) ** 2 * long)
        slope = find_side(table, r, side)[1] * (middle - near) * long / np.maximum(r, BALL_MM) + rise
        up = side * slope > 0
        low, high = np.where(up, middle, low), np.where(up, high, middle)
    return 0.5 * (low + high)


def _is_level(table: RayTable, side: float) -> bool:
    """Whether one side of a piece is flat."""
    leaning = (table.edges[:, 0] > 0) & (side * table.edges[:, 1] > 0)
    round_ = side * table.corners[:, [4, 6]] > 0
    return not (leaning.any() or round_.any())


def find_side(table: RayTable, r: Array, side: float) -> tuple[Array, Array]:
    """Height over the tip (...) of the lower (side -1) or upper (1) side at distances r, and its slope."""
    height, slope = np.full(r.shape, side * np.inf), np.zeros(r.shape)
    for nr, nh, d in table.edges.tolist():
        if side * nh > 0:
            here = (d - nr * r) / nh
            better = side * here < side * height
            height, slope = np.where(better, here, height), np.where(better, -nr / nh, slope)
    for rc, hc, radius, n1r, n1h, n2r, n2h in table.corners.tolist():
        first, last = (n1r if side * n1h > 0 else 1.0), (n2r if side * n2h > 0 else 1.0)
        off = r - rc
        here = (
            (off > radius * min(first, last)) & (off <= radius * max(first, last)) & (max(side * n1h, side * n2h) > 0)
        )
        rise = np.sqrt(np.maximum(radius**2 - off * off, 0.0))
        height = np.where(here, hc + side * rise, height)
        slope = np.where(here, -side * off / np.maximum(rise, BALL_MM), slope)
    return height, slope
