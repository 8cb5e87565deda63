"""Tools as convex bodies of revolution, and the signed distance of points from them.

A *piece* is everything that is no farther than ``rounding`` from a convex polygon which turns about the tool axis (its
core), below the plane ``high``. Cutters, shanks and holders consist of pieces; a profile that is not convex is cut into
several, which reach into each other as far as they can, so that no point deep inside the tool lies on a border.

The distance phi of a piece is convex and changes by no more than the point moves. It is exact but for one place: above
``high``, beside the rim of a rounded piece, it is a lower bound. The top of a cutter is no cutting surface.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import Final

import numpy as np
from msgspec import Struct

from verne_post.base.arrays import Array
from verne_post.base.tolerances import BRACKET_STEPS, DIAMETER_SLACK_MM, LIMIT_SLACK_MM
from verne_post.base.units import RAD_PER_DEG
from verne_post.model.findings import make_input_error
from verne_post.model.part_setup import Cylinder, Tool, ToolShape

#: The corner radius of a cutter may be another one than the tool table says by this, mm: the edge is then 0.008 mm off,
#: 0.41 of it along the normal. That is less than parts show; sizes in inches with three decimals differ by 0.013 mm.
CORNER_SLACK_MM: Final = 0.02
#: Profiles that bend by less than this, mm2 (twice the area of a triangle), are straight there.
_STRAIGHT_MM2: Final = 1e-12
#: Heights that differ by less are one, mm: rounding of lengths up to some metres.
_SAME_MM: Final = 1e-9


class Piece(Struct, frozen=True, eq=False):
    """A convex body of revolution; r is the distance from the tool axis, h the height above the tip along it, mm."""

    part: str  #: "cutter", "shank" or "holder".
    #: (m, 2): r and h of the core's corners, from its lower to its upper end on the axis, counter-clockwise.
    core: Array
    rounding: float
    #: low, high: Where the piece begins and ends along the axis.
    low: float
    high: float
    radius: float  #: The largest r.
    #: A cylinder whose lower edge has the radius ``rounding``; its distance is also exact beside the upper rim.
    plain: bool = False
    inner: bool = False  #: It lies inside two others, and only says how deep a point between them is.

    def list_edges(self) -> Array:
        """Edges (k, 7) of the core: start r, h, direction r, h over the squared length, outward normal, that square.

        An edge without a length stands for a side of a core that has shrunk to a line or a point.
        """
        start, along = self.core[:-1], np.diff(self.core, axis=0)
        square = (along * along).sum(1)
        normal = np.stack([along[:, 1], -along[:, 0]], axis=1) / np.sqrt(np.where(square > 0, square, 1.0))[:, None]
        for k in np.flatnonzero(square == 0).tolist():
            normal[k] = (0.0, -1.0) if k == 0 else (0.0, 1.0) if k == len(along) - 1 else (1.0, 0.0)
        return np.column_stack([start, along / np.where(square > 0, square, 1.0)[:, None], normal, square])

    def evaluate(self, r: Array, h: Array) -> tuple[Array, Array, Array]:
        """Signed distance phi (n,) of points and its derivatives by r and h; at a corner one of its subgradients."""
        return _evaluate_plain(self, r, h) if self.plain else _evaluate_core(self, r, h)


def _evaluate_plain(piece: Piece, r: Array, h: Array) -> tuple[Array, Array, Array]:
    """The distance from a cylinder with a rounded lower edge."""
    beside, below, above = (np.asarray(one) for one in (r - piece.radius, piece.low - h, h - piece.high))
    a, b = beside + piece.rounding, below + piece.rounding
    # most points are far from the edges, which take longer
    phi, side = np.asarray(np.maximum(beside, below)), np.asarray(beside >= below, dtype=np.float64)
    by_r, by_h = side, np.asarray(side - 1.0)
    for edge, across, along, rounding, sign in (
        ((a > 0) & (b > 0), a, b, piece.rounding, -1.0),
        ((beside > 0) & (above > 0) & (b <= 0), beside, above, 0.0, 1.0),
    ):
        across, along = across[edge], along[edge]
        reach = np.hypot(across, along)
        phi[edge], by_r[edge], by_h[edge] = reach - rounding, across / reach, sign * along / reach
    top = above > phi
    phi[top], by_r[top], by_h[top] = above[top], 0.0, 1.0
    return phi, by_r, by_h


def _evaluate_core(piece: Piece, r: Array, h: Array) -> tuple[Array, Array, Array]:
    """The distance from a rounded polygon."""
    nearest = np.full(np.shape(r), np.inf)
    farthest = np.full(np.shape(r), -np.inf)
    to_r, to_h, by_r, by_h = (np.zeros(np.shape(r)) for _ in range(4))
    for start_r, start_h, along_r, along_h, normal_r, normal_h, square in piece.list_edges():
        off_r, off_h = r - start_r, h - start_h
        signed = off_r * normal_r + off_h * normal_h
        share = np.clip(off_r * along_r + off_h * along_h, 0.0, 1.0) * square
        off_r, off_h = off_r - share * along_r, off_h - share * along_h
        distance = off_r * off_r + off_h * off_h
        better = distance < nearest
        nearest, to_r, to_h = (np.where(better, *one) for one in ((distance, nearest), (off_r, to_r), (off_h, to_h)))
        better = signed > farthest
        farthest = np.where(better, signed, farthest)
        by_r, by_h = np.where(better, normal_r, by_r), np.where(better, normal_h, by_h)
    outside = (farthest > 0) & (nearest > 0)
    reach = np.sqrt(nearest)
    safe = np.where(outside, reach, 1.0)
    phi = np.where(outside, reach, np.minimum(farthest, 0.0)) - piece.rounding
    by_r, by_h = np.where(outside, to_r / safe, by_r), np.where(outside, to_h / safe, by_h)
    above = h - piece.high
    top = above > phi
    return np.where(top, above, phi), np.where(top, 0.0, by_r), np.where(top, 1.0, by_h)


def measure_phi(pieces: Sequence[Piece], point: Array, tip: Array, axis: Array) -> Array:
    """Signed distance of points from a tool: negative inside.

    Parameters
    ----------
    point, tip, axis : ndarray, shapes that broadcast to (..., 3)
        mm, one frame; the axis is a unit vector from the tip to the spindle.

    Returns
    -------
    ndarray, shape (...)
        mm; the least of the pieces.
    """
    off = np.asarray(point, dtype=np.float64) - tip
    h = (off * axis).sum(-1)
    r = np.linalg.norm(off - h[..., None] * np.asarray(axis), axis=-1)
    return np.min([piece.evaluate(r, h)[0] for piece in pieces], axis=0)


# --- from the shape of a tool ----------------------------------------------------------------------


def build_pieces(shape: ToolShape, length: float, *, joined: bool = True) -> tuple[Piece, ...]:
    """The pieces of a tool, from the tip upwards; its last part ends at the gauge line.

    Parameters
    ----------
    length : float
        Tip to gauge line, mm.
    joined : bool
        For distances, bodies of different parts reach into each other; cuts and touches need each part as it is.
    """
    pieces: list[Piece] = []
    at = 0.0
    for k, one in enumerate(shape):
        end = length if one.length is None or k == len(shape) - 1 else at + one.length
        part = _build_part(one, at, max(end, at + (one.length or 0.0)))
        if pieces and joined:
            pieces += _join(pieces[-1], part[0])
        pieces += part
        at = end
    return tuple(pieces)


def _join(below: Piece, above: Piece) -> list[Piece]:
    """A double cone that lies inside two pieces of different parts: no point on their border is on the surface."""
    radius = min(_find_radius(below, below.high), _find_radius(above, above.low))
    low, high = 0.5 * (below.low + above.low), 0.5 * (above.low + above.high)
    core = np.array([(0.0, low), (radius, above.low), (0.0, high)])
    return [Piece(above.part, core, 0.0, low, high, radius, inner=True)] if radius > 0 else []


def _find_radius(piece: Piece, height: float) -> float:
    """How thick a piece is at one of its ends."""
    low, high = 0.0, piece.radius
    for _ in range(BRACKET_STEPS):
        middle = 0.5 * (low + high)
        inside = piece.evaluate(np.array(middle), np.array(height))[0] <= 0
        low, high = (middle, high) if inside else (low, middle)
    return low


def check_tool(name: str, shape: ToolShape, length: float, table: Tool | None) -> None:
    """Refuse a tool whose parts are longer than it is, or whose cutter is another one than the tool table has.

    Parameters
    ----------
    length : float
        Of the tool table or as the program has it, mm.
    table : Tool or None
        The tool in the tool table or the set-up; diameter 0: not known.

    Raises
    ------
    InputError
        VP018.
    """
    parts = sum(one.length or 0.0 for one in shape)
    if parts > length + LIMIT_SLACK_MM:
        text = f"{name}: its parts among the tool shapes are {parts:g} mm long, but its length is {length:g}"
        raise make_input_error("VP018", text)
    if not shape or table is None:
        return
    place = f"{table.key} of the set-up" if table.key else "the tool table"
    if table.diameter > 0:
        sizes = [shape[0].diameter, shape[0].widest]
        if min(abs(size - table.diameter) for size in sizes) > DIAMETER_SLACK_MM:
            text = (
                f"{name}: its cutter among the tool shapes is {sizes[0]:g} mm thick, but its diameter in "
                f"{place} is {table.diameter:g}"
            )
            raise make_input_error("VP018", text)
    if table.corner_radius is None or shape[0].profile:  # a form has its edge in its profile
        return
    are_balls = all(one.corner_radius == 0.5 * one.diameter for one in (shape[0], table))  # their diameters agree
    if abs(shape[0].corner_radius - table.corner_radius) > CORNER_SLACK_MM and not are_balls:
        text = (
            f"{name}: the corner_radius of its cutter among the tool shapes is {shape[0].corner_radius:g} mm, but in "
            f"{place} it is {table.corner_radius:g}"
        )
        raise make_input_error("VP018", text)


def _build_part(one: Cylinder, low: float, high: float) -> list[Piece]:
    """The pieces of a part between two heights."""
    half, corner = 0.5 * one.diameter, one.corner_radius
    if one.profile:
        points = [(r, low + h) for r, h in one.profile]
        return _cut_profile(one.part, [*points, *([(points[-1][0], high)] if high > points[-1][1] else [])])
    if one.point_angle:
        tip = 0.5 * one.tip_diameter
        point = low + (half - tip) / np.tan(0.5 * one.point_angle * RAD_PER_DEG)
        return _cut_profile(one.part, [(tip, low), (half, point), *([(half, high)] if high > point else [])])
    if one.neck_diameter:
        middle, neck = low + half, 0.5 * one.neck_diameter
        ball = Piece(one.part, np.array([[0.0, middle]] * 4), half, low, low + one.diameter, half)
        return [ball, _build_cylinder(one.part, neck, 0.0, middle, high)]
    if one.taper:
        return _build_tapered(one, low, high)
    return [_build_cylinder(one.part, half, corner, low, high)]


def _build_tapered(one: Cylinder, low: float, high: float) -> list[Piece]:
    """A cone above a rounded nose, and what goes on above its length."""
    corner, inner = one.corner_radius, 0.5 * one.diameter - one.corner_radius
    slope, end, nose = np.tan(one.taper * RAD_PER_DEG), low + (one.length or 0.0), low + one.corner_radius
    # the core's side is that of the cone, moved inwards by the corner radius
    if one.taper > 0:
        top = 0.5 * one.top_diameter - corner
        cone_end, lid = nose + (top - inner) / slope, [(top, high + corner), (0.0, high + corner)]
        # an edge of no length but for rounding may point downwards, and the body would be hollow
        side = [(top, cone_end), *lid] if cone_end < high + corner - _SAME_MM else lid
        pieces = [Piece(one.part, np.array([(0.0, nose), (inner, nose), *side]), corner, low, high, top + corner)]
        if not corner:
            return pieces
        # that one is rounded where the cone ends, and the tool is not: a small piece there has its edge
        lean, edge = one.taper * RAD_PER_DEG, 0.5 * one.top_diameter
        reach = min(corner * np.tan(0.5 * lean), (end - nose + corner * np.sin(lean)) / np.cos(lean))
        begin = (edge - reach * np.sin(lean), end - reach * np.cos(lean))
        ends = [(edge, height) for height in sorted({end, min(high, end + corner * np.tan(0.5 * lean))})]
        return [*pieces, _build_convex(one.part, [begin, *ends])]
    top = min(end + corner, nose - inner / slope)
    core = [(0.0, nose), (inner, nose), (max(inner + (top - nose) * slope, 0.0), top), (0.0, top)]
    pieces = [Piece(one.part, np.array(core), corner, low, end, 0.5 * one.diameter)]
    neck = 0.5 * one.top_diameter
    return [*pieces, *([_build_cylinder(one.part, neck, 0.0, low, high)] if high > end and neck > 0 else [])]


def _build_cylinder(part: str, radius: float, corner: float, low: float, high: float) -> Piece:
    inner = radius - corner
    core = np.array([(0.0, low + corner), (inner, low + corner), (inner, high + corner), (0.0, high + corner)])
    return Piece(part, core, corner, low, high, radius, plain=True)


def _cut_profile(part: str, points: list[tuple[float, float]]) -> list[Piece]:
    """Convex pieces of a profile (r, h) that rises."""
    points = [one for one, before in zip(points, [None, *points], strict=False) if one != before]
    chains: list[list[tuple[float, float]]] = [[points[0]]]
    for k, point in enumerate(points[1:], start=1):
        chain = chains[-1]
        if len(chain) > 1 and _measure_turn(chain[-2], chain[-1], point) < -_STRAIGHT_MM2:
            chains.append([chain[-1]])
        chains[-1].append(points[k])
    chains = [chain for chain in map(_strip_level_ends, chains) if len(chain) > 1]
    reached = list(chains)
    for k, (below, above) in enumerate(pairwise(chains)):
        reached[k] = _strip_level_ends([*reached[k], *_extend(below, above)])
        downwards = [(r, -h) for r, h in above[::-1]], [(r, -h) for r, h in below[::-1]]
        reached[k + 1] = _strip_level_ends([*((r, -h) for r, h in _extend(*downwards)[::-1]), *reached[k + 1]])
    return [_build_convex(part, chain) for chain in reached]


def _measure_turn(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> float:
    """Twice the area of a triangle: above 0 where the way turns to the left, towards the axis on its way up."""
    return (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0])


def _strip_level_ends(chain: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """A chain without level edges at its ends: they are parts of its flat ends."""
    while len(chain) > 1 and chain[0][1] == chain[1][1]:
        chain = chain[1:]
    while len(chain) > 1 and chain[-1][1] == chain[-2][1]:
        chain = chain[:-1]
    return chain


def _extend(below: list[tuple[float, float]], above: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """How far the last edge of a chain can go on inside the next one: no point, or one."""
    (r0, h0), (r1, h1) = below[-2:]
    slope = (r1 - r0) / (h1 - h0)
    gap = [r - (r1 + slope * (h - h1)) for r, h in above]
    if gap[0] < 0 or above[0][1] != h1:
        return []
    end = above[-1][1]
    for (_, ha), (_, hb), ga, gb in zip(above[:-1], above[1:], gap[:-1], gap[1:], strict=True):
        if gb < 0:
            end = ha + (hb - ha) * ga / (ga - gb)
            break
    if slope < 0:
        end = min(end, h1 - r1 / slope)
    return [(r1 + slope * (end - h1), end)] if end > h1 else []


def build_cylinder(part: str, low: float, high: float, radius: float) -> Piece:
    """A cylinder with flat ends about the axis between two heights."""
    return _build_cylinder(part, radius, 0.0, low, high)


def build_capsule(part: str, low: float, high: float, radius: float) -> Piece:
    """Everything within ``radius`` of the axis between two heights."""
    core = np.array([(0.0, low), (0.0, low), (0.0, high), (0.0, high)])
    return Piece(part, core, radius, low - radius, high + radius, radius)


def _build_convex(part: str, chain: list[tuple[float, float]]) -> Piece:
    core = np.array(
        [
            *([(0.0, chain[0][1])] if chain[0][0] > 0 else []),
            *chain,
            *([(0.0, chain[-1][1])] if chain[-1][0] > 0 else []),
        ]
    )
    return Piece(part, core, 0.0, chain[0][1], chain[-1][1], float(core[:, 0].max()))
